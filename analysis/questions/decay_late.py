"""Decay rates of plants with dead time: the circle criterion of the weighted loop, and slower constant gains."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any, ClassVar

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.systems import texts
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import Proposal
from lure.analysis.questions.channel_pieces import PiecewiseProofs
from lure.analysis.questions.decay_channels import SeveralChannels, accepted, require_states
from lure.arrays import NDArray, Reals, np
from lure.errors import AssumptionError, InputError
from lure.plants.delay_matrix import DelayMatrix

_LEAST_NODES, _MOST_NODES, _NEWTON, _ROOTS, _CLOSE = 12, 60, 12, 6, 1e-13
_HALVINGS, _APART = 22, 5e-10

# With ``xi = x e^(a t)`` what arrives ``T`` late is ``e^(a T)`` times as large, ``e^(-(s - a) T) = e^(a T) e^(-s T)``,
# a number that the checkers enclose; sectors stay, of nonlinearities that depend on time.


@dataclass
class LateChannels(SeveralChannels):
    """The searches for a plant with dead times and a class in each of its channels, at a rate."""

    close = Fraction(1, 10**5)
    _tried: ClassVar = 24, 2, 12, 8

    def __post_init__(self) -> None:
        self.require_functions()
        require_states(self.late.order)
        if self.late.rates:
            raise InputError(
                "decay rates are not shown of neutral equations, with a direct term that has dead time or the like; "
                "lure certify and lure max-sector decide whether the loop is stable"
            )
        if any(math.inf in map(abs, one.gains) or one.memory or one.rectifier for one in self.asked.classes.classes):
            raise InputError(
                "beside dead times rates are shown of sectors, slope bounds and constant gains with two finite bounds; "
                "give such classes"
            )

    @property
    def late(self) -> DelayMatrix:
        """The plant."""
        assert isinstance(self.asked.plant, DelayMatrix), "made for those"
        return self.asked.plant

    def prove(self, rate: Fraction) -> Proved | None:
        """What is accepted of a rate.

        Parameters
        ----------
        rate : Fraction
            The rate.
        """
        proposal = None if self._close(rate) else self._proposal(rate)
        if proposal is None:
            return None
        draft = {"verdict": "PROVED", **self.base, "theorem": "piecewise-circle", "rate": str(rate)}
        found = accepted({**draft, "multiplier": proposal.multiplier, "proof": proposal.proof})
        return found if isinstance(found, Proved) else None

    def _close(self, rate: Fraction) -> bool:
        """Whether a rate is so near to that of the slowest gains that the second checker may not tell them apart."""
        slowest, gains = self.slowest
        return (any(gains) or bool(self.late.inner)) and abs(float(rate) - slowest) < _APART * abs(slowest)

    def _proposal(self, rate: Fraction, *, exactly: bool = True) -> Proposal | None:
        """A multiplier, in floating point alone or as the checker wants it."""
        checkpoint()
        try:
            return PiecewiseProofs(self.asked, None, rate).at(Fraction(1), exactly=exactly)
        except AssumptionError:
            return None

    def expected(self, easy: Fraction, hard: Fraction) -> float:
        """Where the circle criterion seems to end between two rates, in floating point.

        Parameters
        ----------
        easy, hard : Fraction
            The rates, of which the second is wanted.
        """
        low, high = float(easy), float(hard)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            serves = self._proposal(Fraction(f"{middle:.12g}"), exactly=False) is not None
            low, high = (middle, high) if serves else (low, middle)
        return low

    def _slowness(self, gains: Reals) -> Reals:
        """The real part of the rightmost root of ``det(s - A_0 - sum A_k e^(-s T_k))``, for each row of gains.

        It is looked for among the eigenvalues of the generator, collocated at Chebyshev's points (Breda, Maset,
        Vermiglio 2005), and of a single loop by Newton's method from there.
        """
        (A, B, C, D), one, n = self.late.base.doubles(), np.eye(self.late.inputs), self.late.order
        delays, seen, back = self._arrivals
        found = np.empty(len(gains))
        for k, row in enumerate(gains):
            checkpoint()
            closed = np.linalg.solve(one + np.diag(row) @ D, np.diag(row))
            now = A - B @ closed @ C
            later = [own - B @ closed @ side for own, side in zip(back, seen, strict=True)]
            weights, turn = _collocation(self._nodes, tuple(delays))
            whole = np.kron(turn, np.eye(n))
            whole[:n] = np.kron(weights[0], now) + sum(np.kron(w, M) for w, M in zip(weights[1:], later, strict=True))
            roots = np.linalg.eigvals(whole)
            roots = roots[np.argsort(-roots.real)]
            found[k] = roots[0].real if len(gains) > 1 else _polished(roots[: _ROOTS * n], now, delays, later)
        return found

    @cached_property
    def _arrivals(self) -> tuple[list[float], list[NDArray[np.float64]], list[NDArray[np.float64]]]:
        """Dead times, and what shows the states of that time to ``sigma`` and to ``x'``."""
        seen, none = [np.array(rows, dtype=float) for _, rows in self.late.late], np.zeros((self.late.order,) * 2)
        back = [np.array(rows, dtype=float) for rows in self.late.inner] or [none] * len(seen)
        return [float(delay) for delay, _ in self.late.late], seen, back

    @cached_property
    def _nodes(self) -> int:
        size = float(np.abs(np.linalg.eigvals(self.late.base.doubles()[0])).max()) * self._arrivals[0][-1]
        return min(max(_LEAST_NODES, math.ceil(4 * size)), _MOST_NODES)

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Gains that jump are not looked at."""
        return iter(())

    def by_multipliers(self, _end: Fraction | None, _known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """Popov's terms and kernels are not weighed beside dead times."""
        return iter(())

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate, by constant gains with a root farther to the right.

        Parameters
        ----------
        rate : Fraction
            The rate.
        """
        if self._close(rate):
            return None
        gains, draft = texts(self.slowest[1]), {"verdict": "REFUTED", **self.base, "theorem": "counterexample"}
        found = accepted({**draft, "proof": {"method": "late-turns", "gains": gains}, "rate": str(rate)})
        return found if isinstance(found, Refuted) else None


@lru_cache(maxsize=8)
def _collocation(count: int, delays: tuple[float, ...]) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Rows that interpolate at 0 and at each ``-T_k`` from Chebyshev's points on ``[-T, 0]``, and the derivative."""
    angles = np.pi * np.arange(count + 1) / count
    points = (np.cos(angles) - 1) * delays[-1] / 2
    signs = (-1.0) ** np.arange(count + 1)
    signs[[0, -1]] /= 2
    gaps = points[:, None] - points + np.eye(count + 1)
    turn = signs / signs[:, None] / gaps
    np.fill_diagonal(turn, 0)
    np.fill_diagonal(turn, -turn.sum(axis=1))
    rows = [np.eye(count + 1)[:1]]
    for delay in delays:
        away = -delay - points
        at = np.abs(away) < 1e-14 * delays[-1]
        row = at.astype(float) if at.any() else signs / away
        rows.append((row / row.sum())[None])
    return rows, turn


def _polished(
    roots: NDArray[np.complex128],
    now: NDArray[np.float64],
    delays: Sequence[float],
    later: Sequence[NDArray[np.float64]],
) -> float:
    """The largest real part of the roots to which Newton's method goes from these."""
    one, found = np.eye(len(now)), list[float]()
    for start in roots:
        s = complex(start)
        for _ in range(_NEWTON):
            waits = [np.exp(-s * delay) * M for delay, M in zip(delays, later, strict=True)]
            slope = one + sum(delay * M for delay, M in zip(delays, waits, strict=True))
            try:
                step = 1 / np.trace(np.linalg.solve(s * one - now - sum(waits), slope))
            except np.linalg.LinAlgError:  # a root
                step = 0.0
            s -= step
            if not abs(step) > _CLOSE * abs(s):
                found.append(s.real)
                break
    return max(found, default=float(roots[0].real))

r"""A gain from ``w`` to ``z`` beside eigenvalues 0 (in discrete time 1) that ``w`` moves: a form that is semidefinite.

With ``V = x'Px + 2 sum theta_i int psi_i >= 0``, ``x(0) = 0``, it is enough for a gain that

.. math:: -\dot V - \sum 2 \lambda_i \psi_i (w_i \sigma_i - \psi_i) - |z|^2 + g |w|^2 \ge 0

as a form in ``(x, psi, w)``: then ``int |z|^2 <= g int |w|^2`` up to every time, whether 0 attracts or not.  Where the
form is 0 whatever the unknowns are, its derivative is, too: linear equations, solved in fractions, again and again.
The programme is about what they leave free.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from flint import fmpq, fmpq_mat

from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal, Widths
from lure.analysis.inequality.zero_modes import Exact, Rows, diagonal, exact, floats, fractions, freed, null_rows
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, np

MOST_STATES, MOST_CHANNELS = 12, 6
_SURE, _LARGEST, _DIGITS = 1e-9, 1e6, 12


class _Cone(NamedTuple):
    """Multipliers for which the form may be semidefinite: ``P``, ``lambda``, ``theta``, 1 and ``g`` in a basis.

    ``forms``: (unknowns, n + m, n + m); ``kept``: where the form is not always 0, of it and of ``P``.
    """

    basis: fmpq_mat
    forms: Exact
    kept: tuple[list[int], list[int]]


@dataclass
class RestingGain(ChannelSearch):
    """The search for one plant; the others: see :class:`ChannelSearch`.

    Parameters
    ----------
    loop : sequence of matrices
        ``A``, ``B``, ``C`` and ``D`` exactly, shifted by the lower bounds.
    given : sequence of sequence of Fraction
        ``C`` as it was given.
    performance : range
        The channels from ``z`` to ``w``, the last.
    free : sequence of bool
        Which ``theta`` may differ from 0.
    popov : bool
        Whether a certificate states ``theta``.
    discrete : bool
        Whether in discrete time.
    """

    loop: Sequence[Rows]
    given: Rows
    performance: range
    free: Sequence[bool]
    popov: bool
    discrete: bool

    @cached_property
    def _turned(self) -> list[int]:
        return [i for i in range(self.performance.start) if self.free[i]]

    def _forms(self, widths: Sequence[Fraction]) -> Exact:
        """The form of each unknown, exactly: ``P``, ``lambda``, ``theta``, then that of ``|z|^2`` and of ``|w|^2``."""
        A, B, C, D = (fractions(exact(side)) for side in self.loop)
        n, one = len(A), np.array([[fmpq(i == j) for j in range(sum(B.shape))] for i in range(sum(B.shape))])
        moved, seen, now, forms = np.hstack([A, -B]), np.hstack([C, -D]), one[:n], list[Exact]()
        for E in symmetric_basis(n).astype(int).astype(object):
            side = moved.T @ E @ moved - now.T @ E @ now if self.discrete else now.T @ E @ moved + moved.T @ E @ now
            forms.append(-side)
        for i in range(self.performance.start):
            own, w = one[n + i], fmpq(widths[i].numerator, widths[i].denominator)
            side = np.outer(w * seen[i] - own, own)
            forms.append(-(side + side.T))
        for i in self._turned:
            side = np.outer(C[i] @ moved, one[n + i])
            forms.append(-(side + side.T))
        z, w = seen[[*self.performance]], one[[n + i for i in self.performance]]
        return np.array([*forms, -(z.T @ z), w.T @ w], dtype=object)

    def _cone(self, widths: Sequence[Fraction]) -> _Cone | None:
        """What the equations leave free; None if ``z`` sees what nothing holds."""
        forms, n = self._forms(widths), len(self.A)
        places, count, size = np.tril_indices(n), len(forms), len(self.A) + len(self.D)
        positive = [bool(i == j) for i, j in zip(*places, strict=True)] + [True] * (count - len(places[0]))
        P = np.zeros((count, n, n), dtype=object)
        P[: len(places[0])] = symmetric_basis(n).astype(int).astype(object)
        still = exact(self.loop[0]) - diagonal([Fraction(int(self.discrete))] * n)
        rest = [[*row, *[fmpq(0)] * (size - n)] for row in null_rows(still).tolist()]
        tried = np.array([*rest, *([fmpq(i == j) for j in range(size)] for i in range(size))], dtype=object)
        rows, gone = list[Exact](), (list[Exact](), list[Exact]())
        while True:
            found = freed(np.array(rows or [[fmpq(0)] * count], dtype=object), positive)
            basis, before = fractions(found.basis), len(rows)
            if not any(basis[-2]):
                return None
            for M, zeros, width in ((forms, gone[0], size), (P, gone[1], n)):
                for v in tried[:, :width]:
                    if not any(v) or any((v == other).all() for other in zeros):
                        continue
                    flat = M @ v
                    value = flat @ v
                    below = all(positive[k] and value[k] < 0 for k in range(count) if value[k])
                    if below or not any(value @ basis):
                        zeros.append(v)
                        rows += [*flat.T]
            if len(rows) == before:
                break
        kept = []
        for zeros, width in zip(gone, (size, n), strict=True):
            reduced, rank = fmpq_mat([list(v) for v in zeros] or [[fmpq(0)] * width]).rref()
            pivots = [next(j for j in range(width) if reduced[i, j] != 0) for i in range(rank)]
            kept.append([j for j in range(width) if j not in pivots])
        return _Cone(found.basis, forms, (kept[0], kept[1]))

    def _programme(self, cone: _Cone, g: Fraction | None) -> Reals | None:
        """The least ``g``, the last unknown; or for a given one the unknowns with the largest margin, which is last."""
        basis, forms, n = floats(fractions(cone.basis)), floats(cone.forms), len(self.A)
        count, d = basis.shape
        P = np.zeros((count, n, n))
        P[: n * (n + 1) // 2] = symmetric_basis(n)
        room, limits, blocks = g is not None, Limits(d + (g is not None)), list[Block]()
        for M, kept in zip((forms, P), cone.kept, strict=True):
            slopes = np.tensordot(basis.T, M, 1)[:, kept][:, :, kept]
            slopes = np.concatenate([slopes, -np.eye(len(kept))[None]]) if room else slopes
            if kept:
                blocks.append(Block(np.zeros((len(kept),) * 2), slopes))
        for k in range(n * (n + 1) // 2, count - 2):
            limits.at_most({int(j): -basis[k, j] for j in np.flatnonzero(basis[k])}, 0.0)
        limits.at_most({d - 2: 1.0}, 1.0)
        limits.at_most({d - 2: -1.0}, -1.0)
        for j in range(d - 2):
            limits.at_most({j: 1.0}, _LARGEST)
            limits.at_most({j: -1.0}, _LARGEST)
        if g is None:
            return proposed(-np.eye(d)[-1], blocks, *limits.arrays())
        limits.at_most({d - 1: 1.0}, float(g))
        limits.at_most({d: 1.0}, 1.0)
        return proposed(np.eye(d + 1)[-1], blocks, *limits.arrays())

    @property
    def possible(self) -> bool:
        """Whether there are unknowns to search for, and few enough."""
        return len(self.A) <= MOST_STATES and len(self.D) <= MOST_CHANNELS

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme has a solution."""
        return self._least(widths) * float(widths[-1]) ** 2 <= 1

    def largest(self, widths: Widths, start: float, most: float) -> float:
        """The factor of the least gain; see :class:`ChannelSearch`."""
        unit = float(widths(1.0)[-1])
        least = self._least(widths(1.0))
        return 0.0 if not 0 < least < np.inf else min(least**-0.5 / unit, most)

    def _least(self, widths: NDArray[np.float64]) -> float:
        cone = self._cone([Fraction(float(w)) for w in widths])
        found = None if cone is None else self._programme(cone, None)
        return np.inf if found is None or found[-1] <= 0 else float(found[-1])

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded where the equations leave it free."""
        cone, g = self._cone(widths), 1 / widths[-1] ** 2
        found = None if cone is None else self._programme(cone, g)
        if cone is None or found is None or found[-1] <= _SURE:
            return
        (n, m), own, columns = (len(self.A), len(self.D)), self.performance, cone.basis.ncols()
        free = [[Fraction(f"{v:.{_DIGITS}g}")] for v in found[: columns - 2]] + [[Fraction(1)], [g]]
        values = [Fraction(int(v.p), int(v.q)) for v in (cone.basis * exact(free)).entries()]
        P = [[Fraction(0)] * n for _ in range(n)]
        for (i, j), v in zip(zip(*np.tril_indices(n), strict=True), values, strict=False):
            P[i][j] = P[j][i] = v
        rest = values[n * (n + 1) // 2 :]
        weights = rest[: own.start] + [g / 2] * len(own)
        theta = [Fraction(0)] * m
        for i, v in zip(self._turned, rest[own.start :], strict=False):
            theta[i] = v
        C = exact(self.given)
        whole = exact(P) - C.transpose() * diagonal([t * low for t, low in zip(theta, lower, strict=True)]) * C
        entries, factor = whole.numer_denom()
        stated = {"lambda": [str(int(factor) * v) for v in weights]}
        stated |= {"theta": [str(int(factor) * v) for v in theta]} if self.popov else {}
        rows = [[str(entries[i, j]) for j in range(i + 1)] for i in range(n)]
        yield Proposal(stated, {"method": "matrix", "P": rows, "exponent": 0, "semidefinite": True})

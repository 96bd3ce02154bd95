"""Decay rates of plants with dead time: the circle criterion of the weighted loop, and slower constant gains."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.late_roots import LateRoots
from lure.analysis.counterexamples.late_switching import LateSwitching
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import Proposal
from lure.analysis.questions.channel_pieces import PiecewiseProofs
from lure.analysis.questions.decay_channels import SeveralChannels, accepted, require_states
from lure.arrays import Reals, np
from lure.errors import AssumptionError, InputError
from lure.plants.delay_matrix import DelayMatrix

_HALVINGS, _FEW, _APART, _SHARE = 22, 12, 5e-10, 1e-6
_BACK = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5)  # where the proof of a rate that seems to serve is not accepted

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
        self.late.require_retarded("decay rates")
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
        """What is accepted of a rate."""
        return self._proved(rate, None)

    def _proved(self, rate: Fraction, free: Sequence[bool] | None) -> Proved | None:
        """The same, with Popov's terms in some channels, or without."""
        proposal = None if self._close(rate) else self._proposal(rate, free)
        if proposal is None:
            return None
        theorem = "piecewise-circle" if free is None else "piecewise-popov"
        draft = {"verdict": "PROVED", **self.base, "theorem": theorem, "rate": str(rate)}
        found = accepted({**draft, "multiplier": proposal.multiplier, "proof": proposal.proof})
        return found if isinstance(found, Proved) else None

    def _close(self, rate: Fraction) -> bool:
        """Whether a rate is so near to that of the slowest gains that the second checker may not tell them apart."""
        slowest, gains = self.slowest
        return (any(gains) or bool(self.late.inner)) and abs(float(rate) - slowest) < _APART * abs(slowest)

    def _proposal(self, rate: Fraction, free: Sequence[bool] | None, *, exactly: bool = True) -> Proposal | None:
        """A multiplier, in floating point alone or as the checker wants it."""
        checkpoint()
        try:
            return PiecewiseProofs(self.asked, free, rate).at(Fraction(1), exactly=exactly)
        except AssumptionError:
            return None

    def expected(self, easy: Fraction, hard: Fraction) -> float:
        """Where the circle criterion seems to end between two rates, in floating point.

        Parameters
        ----------
        easy, hard : Fraction
            The rates, of which the second is wanted.
        """
        return self._end(float(easy), float(hard), None, _HALVINGS)

    def _end(self, low: float, high: float, free: Sequence[bool] | None, halvings: int) -> float:
        """Where proposals end between two rates: often close to the second, which is looked at first."""
        near = high + _SHARE * (low - high)
        for k in range(halvings):
            middle = (low + high) / 2 if k else near
            if self._proposal(Fraction(f"{middle:.12g}"), free, exactly=False) is None:
                high = middle
            elif k:
                low = middle
            else:
                return near
        return low

    @cached_property
    def _roots(self) -> LateRoots:
        return LateRoots(self.late)

    def _slowness(self, gains: Reals) -> Reals:
        """The real part of the rightmost root of the loop, for each row of gains; of a single loop with all digits."""
        if len(gains) == 1:
            return np.array([self._roots.rightmost(gains[0]).real])
        return np.array([self._roots.spectrum(row)[0].real for row in gains])

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates that gains that jump seem to have, and their proofs."""
        classes = self.asked.classes
        ends = classes.lower, classes.upper
        low, high = (np.array([float(v) for v in side]) for side in ends)
        varying = tuple(one.time_varying and not one.linear for one in classes.classes)
        for rate, one in LateSwitching(self.late, low, high, varying, classes.blocks).slower(self.slowest[0]):
            rows = [texts([ends[end][i] for i, end in enumerate(row)]) for row in one.ends]
            yield rate, {"method": "switched-gains", "gains": rows, **one.numbers}

    def by_multipliers(self, end: Fraction | None, known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """What Popov's terms prove, of functions whose slopes are within their bounds, better than what is known.

        Parameters
        ----------
        end, known : Fraction or None
            What no rate exceeds, and what is proved.
        """
        classes, base = self.asked.classes.classes, self.late.base.D
        free = [
            not (one.time_varying or one.linear or any(row))
            and one.slope is not None
            and one.gains == (one.slope.lower, one.slope.upper)
            for one, row in zip(classes, base, strict=True)
        ]
        if known is None or not any(free):
            return
        easy, hard = float(known), self.fastest if end is None else min(float(end), self.fastest)
        reached = self._end(easy, hard, free, _FEW)
        for back in _BACK if reached > easy else ():
            rate = Fraction(f"{reached - back * (reached - easy):.9g}")
            if rate > known and (shown := self._proved(rate, free)) is not None:
                yield rate, shown
                return

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

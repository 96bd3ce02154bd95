"""Parameters of a plant that change with time so that some solution grows, in floating point: jumps, and ramps.

The searches are those for gains, :mod:`lure.analysis.counterexamples.channel_switching` and ``channel_ramps``: each
parameter stands behind the channels as a gain whose interval does not depend on the factor of the classes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from lure.analysis.counterexamples.channel_ramps import RampedGains
from lure.analysis.counterexamples.channel_switching import SwitchedGains
from lure.arrays import NDArray, Reals, np
from lure.classes import Diagonal
from lure.plants.channel_family import ChannelFamily

_LEAST = 1e-9  # a factor that stands for none of the classes but their lower bounds


class Moving(NamedTuple):
    """For the classes of a factor: parameters and gains, step after step, and what a certificate needs."""

    factor: float
    at: list[list[Fraction]]
    gains: list[list[Fraction]]
    times: list[Fraction]
    squarings: int
    bits: int


@dataclass(frozen=True)
class _Loops:
    """The plants in floating point, closed by gains."""

    powers: Reals
    common: Reals
    sides: tuple[Reals, ...]

    @classmethod
    def of(cls, family: ChannelFamily) -> _Loops:
        """Those of a family."""
        terms = family.terms
        sides = tuple(np.array([[[float(v) for v in row] for row in one.sides[k]] for one in terms]) for k in range(4))
        return cls(np.array([one.powers for one in terms]), np.array([float(one.common) for one in terms]), sides)

    def closed(self, gains: Reals, points: Reals) -> Reals:
        """The matrices of the loops ``mu = -g sigma`` at these parameters: (k, n, n)."""
        weights = (points[:, None, :] ** self.powers).prod(axis=2)
        below = (weights @ self.common)[:, None, None]
        A, B, C, D = (np.einsum("kt,tij->kij", weights, side) / below for side in self.sides)
        G = gains[:, :, None] * np.eye(gains.shape[1])
        return np.asarray(A - B @ G @ np.linalg.solve(np.eye(gains.shape[1]) + D @ G, C))


@dataclass(frozen=True, kw_only=True)
class SwitchedParameters(SwitchedGains):
    """Parameters that jump between their ends, beside gains."""

    loops: _Loops
    scaled: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def closed(self, ends: NDArray[np.int_], alpha: float) -> Reals:
        """The matrices of the loop: (k, n, n)."""
        values, m = np.where(ends == 1, np.where(self.scaled, alpha, 1.0) * self.upper, self.lower), self.scaled.sum()
        return self.loops.closed(values[:, :m], values[:, m:])


@dataclass(frozen=True, kw_only=True)
class RampedParameters(RampedGains):
    """Parameters that move no faster than their rates, beside gains that stay."""

    loops: _Loops
    channels: int
    affine: tuple[bool, ...]

    def _alone(self, block: range) -> bool:
        return self.affine[block[0]]

    def _top(self, i: int, alpha: Fraction) -> Fraction:
        return alpha * self.upper[i] if i < self.channels else self.upper[i]

    def closed_by(self, gains: Reals) -> Reals:
        """The matrices of the loop, the parameters behind the gains: (k, n, n)."""
        return self.loops.closed(gains[:, : self.channels], gains[:, self.channels :])


@dataclass(frozen=True)
class MovingParameters:
    """The search: parameters and gains that jump, and parameters that go at their rates beside gains that stay.

    Attributes
    ----------
    family : ChannelFamily
        The plants.
    classes : Diagonal
        The classes at the factor 1, with gains.
    """

    family: ChannelFamily
    classes: Diagonal

    @property
    def _paces(self) -> tuple[Fraction | float, ...]:
        return self.family.rates or (Fraction(0),) * len(self.family.box)

    @property
    def discrete(self) -> bool:
        """Whether in discrete time."""
        return self.family.dt is not None or self.family.any_period

    def _ends(self) -> tuple[list[Fraction], list[Fraction], list[range]]:
        """The lower and upper ends of gains and parameters, and which are one."""
        classes, box, m = self.classes, self.family.box, len(self.classes.classes)
        blocks = [*classes.blocks, *(range(m + j, m + j + 1) for j in range(len(box)))]
        return [*classes.lower, *(low for low, _ in box)], [*classes.upper, *(high for _, high in box)], blocks

    def _rungs(self, low: float, most: float) -> tuple[float, ...]:
        return (_LEAST, most) if low <= 0 else (most,)

    def jumps(self, low: float, most: float) -> Iterator[Moving]:
        """What to certify of jumps; nothing where nothing may jump.

        Parameters
        ----------
        low : float
            A factor up to which nothing grows; 0 where nothing is known: then the lower bounds alone are tried too.
        most : float
            The largest factor of interest; infinity: none.
        """
        (lower, upper, blocks), m = self._ends(), len(self.classes.classes)
        free = [one.time_varying and not one.linear for one in self.classes.classes]
        search = SwitchedParameters(
            *self.family.central.doubles(),
            lower=np.array([float(v) for v in lower]),
            upper=np.array([float(v) for v in upper]),
            varying=(*free, *(rate == math.inf for rate in self._paces)),
            blocks=tuple(blocks),
            discrete=self.discrete,
            loops=_Loops.of(self.family),
            scaled=np.arange(len(lower)) < m,
        )
        for top in self._rungs(low, most):
            for one in search.proposals(low, top):
                least = top == _LEAST
                ends = lower, [*(lower[:m] if least else self.classes.scaled(Fraction(one.factor)).upper), *upper[m:]]
                rows = [[ends[end][i] for i, end in enumerate(row)] for row in one.ends]
                at, own = [row[m:] for row in rows], [row[:m] for row in rows]
                yield Moving(0.0 if least else one.factor, at, own, one.times, one.squarings, one.bits)

    def ramps(self, low: float, most: float) -> Iterator[Moving]:
        """The same of parameters of bounded rates.

        Parameters
        ----------
        low, most : float
            As for jumps.
        """
        (lower, upper, blocks), m = self._ends(), len(self.classes.classes)
        rates = [Fraction(rate) if 0 < rate < math.inf else None for rate in self._paces]
        going = [j for j, rate in enumerate(rates) if rate is not None]
        if self.discrete or not going:
            return
        search = RampedParameters(
            *self.family.central.doubles(),
            lower=lower,
            upper=upper,
            rates=[*[None] * len(self.classes.blocks), *rates],
            blocks=blocks,
            discrete=False,
            loops=_Loops.of(self.family),
            channels=m,
            affine=(*[False] * m, *(_affine(self.family, j, going) for j in range(len(rates)))),
        )
        for top in self._rungs(low, most):
            for one in search.proposals(low, top, lowest=top != _LEAST):
                least, at = top == _LEAST, [row[m:] for row in one.gains]
                own = [lower[:m] if least else row[:m] for row in one.gains]
                yield Moving(0.0 if least else one.factor, at, own, one.times, one.squarings, one.bits)


def _affine(family: ChannelFamily, j: int, going: list[int]) -> bool:
    """Whether a parameter stands in ``A`` alone, to the first power, and beside no other that goes."""
    terms = [one for one in family.terms if one.powers[j]]
    alone = (not one.common and not any(any(map(any, side)) for side in one.sides[1:]) for one in terms)
    return all(alone) and all(sum(one.powers[k] for k in going) == 1 for one in terms)

"""Kernels between channels: how far below the proposals of floating point the checker accepts them.

Those of loops side by side are sought by themselves, so that none is weighed against another.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.frequencies import MOST_CHANNELS
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channels import MOST_STATES, ChannelInequality
from lure.analysis.inequality.kernel_cone import KernelCone
from lure.analysis.inequality.kernels import Found, multiplier
from lure.analysis.inequality.shifted_loop import LARGEST, MEETING, Proposal
from lure.analysis.inequality.zero_modes import ZeroModes
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.questions.channel_delays import without_delays
from lure.analysis.questions.channel_hypotheses import (
    constant_gains_of,
    fixed_operators,
    free_channels,
    modes_of,
    require_no_zero,
    rising,
    sloped_channels,
)
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.problem import Problem
from lure.arrays import NDArray, np
from lure.classes import SCALAR
from lure.record import described, quantity

if TYPE_CHECKING:
    from lure.analysis.inequality.shifted_loop import Widths

_NOTHING = 1e-11  # relative: an entry of H that is rounding
_STEPS_BACK = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3)
_DENSE, _NEARLY = 2000, 3e-3
_LOST = 1e-3  # relative: a factor that rounding may lose
Accept = Callable[[Fraction, Proposal], Proved | None]


def farthest_kernels(cone: KernelCone, widths: Widths, start: float, most: float) -> Found | None:
    """The multiplier found that serves farthest, of loops side by side one for each; None if none was found.

    Of odd nonlinearities it is sought with kernels of one sign as well, which the search with both may miss.

    Parameters
    ----------
    cone : KernelCone
        The multipliers.
    widths : callable
        (m,) of a factor, increasing with it.
    start : float
        The factor to begin with.
    most : float
        More is not asked.
    """
    apart = _apart(cone)
    if len(apart) < 2:
        return _either_sign(cone, widths, start, most)
    found = Found.none(len(cone.odd))
    for channels in apart:

        def own(factor: float, channels: list[int] = channels) -> NDArray[np.float64]:
            """The widths of these channels."""
            return np.asarray(widths(factor)[channels])

        part = _either_sign(_alone(cone, channels), own, start, most)
        if part is None:
            return None
        found.gamma[channels], found.theta[channels], most = part.gamma, part.theta, min(most, part.factor)
        moved = [one._replace(row=channels[one.row], column=channels[one.column]) for one in part.kernels]
        found = found._replace(kernels=found.kernels + moved, masses=np.append(found.masses, part.masses))
    return cone.remember(found._replace(factor=most))


def _either_sign(cone: KernelCone, widths: Widths, start: float, most: float) -> Found | None:
    found = cone.largest(widths, start, most)
    if not any(cone.odd) or cone.gains or cone.wide or (found is not None and found.factor >= most):
        return found
    monotone = replace(cone, odd=[False] * len(cone.odd))
    other = monotone.largest(widths, start if found is None else found.factor, most)
    return other if other is not None and (found is None or other.factor > found.factor) else found


def _apart(cone: KernelCone) -> list[list[int]]:
    """The channels of each of the loops that do not interact, where all are functions of one channel each."""
    m, H = len(cone.odd), np.abs(np.where(np.isfinite(cone.H), cone.H, 0)).max(axis=0)
    if cone.plant.operators or cone.gains or cone.wide or cone.fixed or cone.ratios or cone.scaled or cone.rate:
        return [[*range(m)]]
    joined = (_NOTHING * np.sqrt(np.outer(H.max(axis=1), H.max(axis=0))) < H) | np.eye(m, dtype=bool)
    for block in cone.blocks:
        joined[np.ix_([*block], [*block])] = True
    joined = np.linalg.matrix_power((joined | joined.T).astype(float), m) > 0
    return [[*map(int, np.flatnonzero(row))] for i, row in enumerate(joined) if not row[:i].any()]


def _alone(cone: KernelCone, channels: list[int]) -> KernelCone:
    """The multipliers of some channels."""
    plant, at = cone.plant, {i: k for k, i in enumerate(channels)}
    free = [plant.free[i] for i in channels]
    own = replace(
        plant,
        B=plant.B[:, channels],
        C=plant.C[channels],
        D=plant.D[np.ix_(channels, channels)],
        lower=np.zeros(len(channels)),
        free=free,
    )
    blocks = [[at[i] for i in block] for block in cone.blocks if block[0] in at]
    return KernelCone(own, blocks, [cone.odd[i] for i in channels])


@described(frozen=True, eq=False)
class KernelSearch:
    """The search for kernels, for the slopes of the classes where they are bounded."""

    cone: KernelCone = quantity("The multipliers")
    modes: ZeroModes | None = quantity("The eigenvalues 0 of the loop")
    ends: list[tuple[Fraction, Fraction]] = quantity("Between which the gains or slopes of each channel lie")
    scaled: Sequence[int] = quantity("The channels whose upper ends are multiplied by the factor")
    least: Fraction = quantity("The factor at which a class is empty")

    @classmethod
    def of(cls, asked: Problem) -> KernelSearch | None:
        """The search of a question; None where there are no kernels, or too many channels or states.

        Raises
        ------
        AssumptionError
            There are eigenvalues 0 that no theorem covers.
        """
        least = asked.classes.least
        if not rising(asked) or channel_plant(asked.plant).dt is not None:
            require_no_zero(asked)
        modes, asked = modes_of(asked), without_delays(asked)
        H, sloped, classes = channel_plant(asked.plant), sloped_channels(asked), asked.classes
        A, B, C, D = H.doubles()
        if H.dt is not None:  # functions of the frequency alone, in terms of s = (z - 1)/(z + 1)
            sloped = [any(i in block for block in constant_gains_of(asked)) for i in range(len(D))]
            E = np.linalg.inv(np.eye(len(A)) + A)
            A, B, D = np.eye(len(A)) - 2 * E, 2 * E @ E @ B, D - C @ E @ B
        if not (any(sloped) or fixed_operators(asked)) or len(D) > MOST_CHANNELS or len(A) > MOST_STATES:
            return None

        ends = list(zip(classes.lower, classes.upper, strict=True))
        for i, one in enumerate(classes.classes):
            if sloped[i] and one.slope is not None:
                ends[i] = Fraction(one.slope.lower), Fraction(one.slope.upper)
        lower = np.array([float(low) for low, _ in ends])
        free = [one and H.dt is None for one in free_channels(asked)]
        sides, operators = (A, B, C, D), classes.operators
        plant = ChannelInequality(*sides, lower, free, popov=True, discrete=False, operators=operators, modes=modes)
        blocks, scaled = (
            [block for block in classes.blocks if sloped[block[0]]],
            classes.performance or range(len(ends)),
        )
        odd = [one.odd for one in classes.classes]
        if modes is None:
            gains, fixed = constant_gains_of(asked), fixed_operators(asked)
            wide = [one for one in (*gains, *fixed) if len(one) > 1]
            wide = [one for one in wide if one in gains or classes.classes[one[0]].operator == SCALAR]
            alone = [one[0] for one in gains if len(one) == 1]
            own = classes.performance or ()
            cone = KernelCone(plant, blocks, odd, fixed=fixed, gains=alone, wide=wide, scaled=own)
        else:
            ratios, own = [(first, float(ratio)) for first, ratio in modes.ratios], classes.performance or ()
            cone = KernelCone(plant, blocks, odd, ratios, residue=modes.residue(), scaled=own)
        return cls(cone, modes, ends, scaled, least)

    def widths(self, factor: Fraction) -> list[Fraction]:
        """How wide the classes are at a factor."""
        return [(factor if i in self.scaled else 1) * high - low for i, (low, high) in enumerate(self.ends)]

    def whole(self, accept: Accept) -> Proved | None:
        """What is accepted for the classes as they are given."""
        found = self._found(1.0, 1.001)
        return None if found is None or found.factor <= 1 else self._at(accept, found, Fraction(1))

    def farthest(self, accept: Accept, known: Fraction, most: float) -> tuple[Fraction, Proved] | None:
        """The largest factor that is accepted, above what is known and below ``most``."""
        cone = self.cone
        begin = min(1.0, most / 2) if cone.gains or cone.wide else float(known) or min(1.0, most / 2)
        start = max(begin, 1.01 * double_above(self.least))
        top = min(most * (1 - MEETING), LARGEST)
        if 4 * start > LARGEST:  # more is not asked
            return None
        best: tuple[Fraction, Proved] | None = None
        for closely in (False, True):  # where what is found fails between its frequencies
            if closely:
                seen = cone.omega[(cone.omega > 0) & np.isfinite(cone.omega)]
                cone.look_at(np.geomspace(seen.min(), seen.max(), _DENSE))
            found = self._found(start, top)
            if found is None:
                break
            shown = self._below(accept, found, max(known, self.least))
            best = best if shown is None else shown
            if best is not None and best[0] >= Fraction(found.factor) * (1 - Fraction(_NEARLY)):
                break
            known = known if best is None else best[0]
        return best

    def _found(self, start: float, top: float) -> Found | None:
        return farthest_kernels(
            self.cone, lambda factor: np.array([*map(float, self.widths(Fraction(factor)))]), start, top
        )

    def _at(self, accept: Accept, found: Found, alpha: Fraction) -> Proved | None:
        """What is accepted of a multiplier for a factor."""
        ratios = () if self.modes is None or self.cone.residue is None else self.modes.ratios
        stated = multiplier(found, self.widths(alpha), self.cone.gains, ratios, self.cone.wide)
        return accept(alpha, Proposal(stated, {"method": "determinant"}))

    def _below(self, accept: Accept, found: Found, known: Fraction) -> tuple[Fraction, Proved] | None:
        """The largest factor that is accepted, as far below what floating point says as it must be."""
        above = Fraction(found.factor)
        for step in _STEPS_BACK:
            checkpoint()
            alpha = Fraction(double_below(Fraction(found.factor) * (1 - Fraction(step))))
            shown = self._at(accept, found, alpha) if alpha > known else None
            if shown is not None:
                return between(lambda factor: self._at(accept, found, factor), (alpha, shown), above)
            above = alpha
        return None


def between(
    proof: Callable[[Fraction], Proved | None], known: tuple[Fraction, Proved], above: Fraction
) -> tuple[Fraction, Proved]:
    """What is proved where floating point said too much: halving from what is proved to what is not.

    Parameters
    ----------
    proof : callable
        What is proved of a factor; None if nothing.
    known : (Fraction, Proved)
        A factor and its proof.
    above : Fraction
        A factor that was not proved.
    """
    while above > known[0] * (1 + Fraction(_LOST)):
        checkpoint()
        alpha = Fraction(math.sqrt(known[0] * above))
        shown = proof(alpha)
        known, above = (known, alpha) if shown is None else ((alpha, shown), above)
    return known

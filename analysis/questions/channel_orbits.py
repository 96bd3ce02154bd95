"""Nonlinear members of several channels that refute: periodic solutions and equilibria, as checked."""

from __future__ import annotations

import math
from fractions import Fraction

from lure.analysis.certificates.channels import Plant, closed_loop
from lure.analysis.certificates.checker import Refuted
from lure.analysis.counterexamples.balance import Balance
from lure.analysis.counterexamples.channel_orbits import MemoryLoop, memory_proofs, near_fold, proofs
from lure.analysis.counterexamples.channel_samples import SampledOrbits
from lure.analysis.numerics.doubles import double_above
from lure.analysis.questions.channel_delays import stated
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.channel_refutations import refutation
from lure.analysis.questions.problem import Problem
from lure.arrays import np
from lure.plants.delay_matrix import DelayMatrix

_HALVES, _WHOLE, _NEAR = (1, 3, 5, 7), (0, 1, 2, 3, 4), 1e-4
_MOST_STATES, _MOST_CHANNELS, _STARTS, _KEPT, _BEYOND = 20, 6, 40, 2, 30.0  # of the search


def orbits_refuting(
    asked: Problem, known: Fraction, most: float, *, whole: bool = False
) -> tuple[Fraction, Refuted] | None:
    """The smallest factor above what is known and below ``most`` with a periodic solution of piecewise linear members.

    Parameters
    ----------
    asked : Problem
        The question.
    known : Fraction
        A factor up to which there is none.
    most : float
        The largest factor of interest.
    whole : bool
        Whether as a refutation of the classes as they are given.
    """
    if isinstance(asked.plant, DelayMatrix):  # not searched for beside dead times
        return None
    classes, H = asked.classes, channel_plant(asked.plant)
    each = [classes.classes[block[0]] for block in classes.blocks]
    if classes.operators or H.order > _MOST_STATES:
        return None
    if H.dt is not None:
        return _by_samples(asked, known, most, whole=whole)
    if any(one.memory for one in each):
        return _by_memory(asked, known, most, whole=whole)
    repeats = any(len(block) > 1 for block in classes.blocks)  # else gains give all equilibria that others do
    resting = _by_samples(asked, known, most, whole=whole) if repeats else None
    closed = resting is not None and (whole or known >= resting[0] * (1 - Fraction(_NEAR)))
    if closed or classes.rectified or len(each) > _MOST_CHANNELS or all(one.linear or one.time_varying for one in each):
        return resting  # gains that switch do more than members that do not depend on time
    lower, upper = (np.array([float(v) for v in side]) for side in (classes.lower, classes.upper))
    A, B, C, D = ([list(row) for row in side] for side in (H.A, H.B, H.C, H.D))
    top = most if math.isfinite(most) else _BEYOND * max(float(known), float(classes.least), 1e-3)
    searches: list[tuple[tuple[int, ...], list[bool]]] = [(_HALVES, [True] * len(each))]
    if not all(one.odd for one in each):
        searches.append((_WHOLE, [one.odd for one in each]))
    kinks, found = [0 if one.linear else 1 for one in each], [] if resting is None else [resting]
    top = top if resting is None else float(resting[0])
    for harmonics, odd in searches:
        balance = Balance(*H.doubles(), lower, upper, classes.blocks, odd, harmonics, kinks)
        for finer, wave in balance.found(_STARTS, top)[:_KEPT]:
            if not float(known) < wave.alpha < top * (1 - _NEAR):
                continue
            plant = Plant(A, B, C, D, discrete=False)
            for one in near_fold(finer, wave, plant, classes.lower, classes.upper):
                if not known < one.alpha < top:
                    continue
                factor = Fraction(1) if whole else one.alpha
                shown = next((made for proof in proofs(one) if (made := refutation(asked, factor, proof))), None)
                if shown is not None:
                    found.append((factor, shown))
                    top = float(one.alpha)
                    break
    return min(found, key=lambda one: one[0], default=None)


def _by_samples(asked: Problem, known: Fraction, most: float, *, whole: bool) -> tuple[Fraction, Refuted] | None:
    """Exact solutions with functions of ``sigma``: periodic ones in discrete time, equilibria."""
    classes, H = asked.classes, channel_plant(asked.plant)
    each = [classes.classes[block[0]] for block in classes.blocks]
    if any(one.memory or one.rectifier for one in each):
        return None
    kinds = ["sector" if one.slope is None else "odd" if one.odd else "monotone" for one in each]
    own = zip(each, kinds, classes.blocks, strict=True)  # gains that change do more than functions of one channel
    kept = [kind * (not one.linear and (len(b) > 1 or not one.time_varying)) for one, kind, b in own]
    top = most if math.isfinite(most) else _BEYOND * max(float(known), float(classes.least), 1e-3)
    A, B, C, D = ([list(row) for row in side] for side in (H.A, H.B, H.C, H.D))
    plant = Plant(A, B, C, D, discrete=H.dt is not None)
    search = SampledOrbits(plant, classes.lower, classes.upper, classes.blocks, kept, [one.odd for one in each])
    for alpha, proof in search.found(known, top):
        factor = Fraction(1) if whole else Fraction(double_above(alpha))
        shown = refutation(asked, factor, proof) if known < factor and alpha <= top else None
        if shown is not None:
            return factor, shown
    return None


def _by_memory(asked: Problem, known: Fraction, most: float, *, whole: bool) -> tuple[Fraction, Refuted] | None:
    """Periodic solutions with one play or stop, the other channels at their lower bounds."""
    classes, (H, _) = asked.classes, stated(asked)
    own, gains = [i for i, one in enumerate(classes.classes) if one.memory], list(classes.lower)
    G = [[g * (i == j) for j in range(len(gains))] for i, g in enumerate(gains)]
    closed = closed_loop(H, G)
    if len(own) != 1 or closed is None or closed.D[own[0]][own[0]]:
        return None
    (i,), top = own, Fraction(classes.upper[own[0]])
    stop = classes.classes[i].memory == "stop"
    loop = MemoryLoop(closed.A, [row[i] for row in closed.B], closed.C[i], stop)
    for slope, course in loop.least(float(known * top), most * float(top)):
        alpha = Fraction(double_above(slope / top))
        if not known < alpha < most:
            continue
        gains[i], factor = slope, Fraction(1) if whole else alpha
        for proof in memory_proofs(course, gains):
            shown = refutation(asked, factor, proof)
            if shown is not None:
                return factor, shown
    return None

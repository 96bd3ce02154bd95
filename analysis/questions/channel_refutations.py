"""Several nonlinearities: members that destabilise a factor of the classes, as checked.

Gains, constant or changing; and nonlinear members, with periodic solutions and equilibria.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain, product
from typing import Any

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Plant, closed_loop
from lure.analysis.certificates.checker import OTHERS, Refuted
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.balance import Balance
from lure.analysis.counterexamples.channel_gains import GainSearch, LateGains, MatrixGains
from lure.analysis.counterexamples.channel_orbits import MemoryLoop, memory_proofs, near_fold, proofs
from lure.analysis.counterexamples.channel_ramps import MovingParameters, RampedGains
from lure.analysis.counterexamples.channel_samples import SampledOrbits
from lure.analysis.counterexamples.channel_switching import SwitchedGains, Switching
from lure.analysis.counterexamples.late_switching import LatePattern, LateRoots, LateSwitching
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import double_above, double_below
from lure.analysis.questions.channel_delays import stated
from lure.analysis.questions.channel_hypotheses import is_critical
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.problem import Problem
from lure.arrays import Reals, np
from lure.classes import DELAYS, FULL_BLOCK, Diagonal
from lure.errors import InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay_matrix import DelayMatrix

RAMPS, MEMBERS, RESTS = "ramped-gains", "members", "equilibrium"
_ON_AXIS, _LITTLE = 1e-9, 1e-6  # how near to the axis a pole is, and a factor with little gain
_POLES, _NEARBY, _CORNERS = 3, 1e-4, 6  # poles that are looked at, how near to them; channels of which all corners are
_DISCS = (1e-9, 1e-7, 1e-5)  # radii about a root, relative
_SURE = 1e-6  # of the largest entry: a growth below is more than rounding
_HALVES, _WHOLE, _NEAR = (1, 3, 5, 7), (0, 1, 2, 3, 4), 1e-4
_MOST_STATES, _MOST_CHANNELS, _STARTS, _KEPT, _BEYOND = 20, 6, 40, 2, 30.0  # of the search


def unsettled(asked: Problem) -> bool:
    """Whether the loop with the gains at the lower bounds is not stable, or floating point leaves it open."""
    if isinstance(asked.plant, DelayMatrix):  # its states are stable, or nothing is said
        return False
    H = channel_plant(asked.plant)
    A, B, C, D = H.doubles()
    lower = np.array([float(v) for v in asked.classes.lower])
    search = GainSearch(A, B, C, D, lower, lower, asked.classes.blocks, H.dt is not None)
    return bool(search.growth(lower) > -_SURE * (1 + np.abs(A).max()))


def gains_refuting(asked: Problem, *, most: float) -> tuple[Fraction, Refuted] | None:
    """The smallest factor with destabilising gains that the checker accepts; 0 if they lie in the classes of each.

    ``most``: the largest factor of interest; finite: gains of the classes of that factor.
    """
    if asked.classes.rectified:  # no gain is a member
        return None
    H = channel_plant(asked.plant)
    A, B, C, D = H.doubles()
    one = asked.classes.upper
    lower, upper = (np.array([float(v) for v in side]) for side in (asked.classes.lower, one))
    memory = any(each.memory for each in asked.classes.classes)
    upper[[each.memory == "stop" for each in asked.classes.classes]] = 0.0  # what is left of it far from 0
    search = GainSearch(A, B, C, D, lower, upper, asked.classes.blocks, H.dt is not None, is_critical(asked))
    found, lost = search.found(double_above(asked.classes.least), most), search.unsolvable(most)
    tried: Iterable[list[Fraction]] = search.proposals(*found, most=most) if found is not None else ()
    if lost is not None and (found is None or lost[0] <= found[0]):
        tried = chain(search.singular(H.D, (asked.classes.lower, one), lost, most=most), tried)
    if most < math.inf and not memory:  # an eigenvalue on the axis, of which floating point does not see the side
        corners = ([*map(Fraction, gains)] for gains in ends_of(asked.scaled(Fraction(most))))
        size = _SURE * (1 + np.abs(A).max(initial=0))
        tried = chain(tried, (gains for gains in corners if search.growth(np.array([*map(float, gains)])) > -size))
    for gains in tried:
        least = max((g / u for g, u in zip(gains, one, strict=True) if u > 0), default=Fraction(0))
        if math.isinf(most) and least <= 0:  # no gain is positive: they lie in the classes of every factor
            alpha, of = Fraction(0), Fraction(1)
        else:
            alpha = of = Fraction(double_above(least)) if math.isinf(most) else Fraction(most)
        rate = float(search.growth(np.array([*map(float, gains)]))) if memory else 0.0
        growth = {"growth": str(Fraction(rate / 2))} if rate > 0 else {}
        shown = refutation(asked, of, constant_gains(gains) | growth)
        if shown is not None:
            return alpha, shown
    return None


def late_gains_refuting(asked: Problem, *, most: float) -> tuple[Fraction, Refuted] | None:
    """The same of a plant with dead times: gains with a root on the imaginary axis, or a real one.

    ``most``: the largest factor of interest; finite: gains of the classes of that factor.
    """
    plant, classes = asked.plant, asked.classes
    assert isinstance(plant, DelayMatrix), "asked of such plants"
    opened = plant.opened() if plant.inner else plant
    more = np.zeros(opened.outputs - plant.outputs)
    waits = [float(wait) for wait, _ in plant.late]
    poles = np.linalg.eigvals(plant.base.doubles()[0]).astype(complex)
    lower, upper = (np.array([float(v) for v in side]) for side in (classes.lower, classes.upper))
    late = [one.operator in DELAYS for one in classes.classes]  # of which the gain 1 is one
    upper = np.where(late, 0.0, upper)
    bounds = zip(classes.classes, classes.lower, classes.upper, strict=True)
    zero = Fraction(0)  # gains of the class in exact numbers: rounded they may lie outside
    nearest = [Fraction(c.operator in DELAYS) if c.operator else min(max(a, zero), b) for c, a, b in bounds]
    least = [min(a, zero) for a in classes.lower] if not any(nearest) else [zero] * len(nearest)
    base = np.array([double_above(v) if v > 0 else double_below(v) for v in nearest])
    below = np.array([float(v) for v in least])
    if classes.rectified:
        return None
    signed = [bool(classes.classes[block[0]].operator) for block in classes.blocks]
    unstable = poles[poles != 0].real.max(initial=-1) >= -_ON_AXIS * np.abs(poles).max()
    resting = len(poles) - np.count_nonzero(poles)
    starts = [nearest] * bool(base.any() or unstable or plant.inner) + [least] * any(least)
    for method, start in product(("late-gains", "late-turns"), starts):
        never = refutation(asked, Fraction(1), {"method": method, "gains": texts(start)})
        if never is not None:
            return Fraction(0), never
    alpha = Fraction(_LITTLE) if math.isinf(most) else Fraction(most)
    if (unstable or resting > len(lower)) and not base.any() and alpha >= _LITTLE:
        gains = [str(Fraction(v)) for v in (_LITTLE / 2 * upper).tolist()]
        small = refutation(asked, alpha, {"method": "late-turns", "gains": gains})
        if small is not None:
            return alpha, small
    if unstable and not base.any() and not plant.inner:
        return None
    upper = np.where(base < 0, lower, upper)
    for ends, signs in ((below, [False] * len(signed)), (upper, signed)):
        whole, closed = np.append(ends, more), np.append(base, more + 1)
        search = LateGains(opened.transfer, whole, classes.blocks, signs, poles, (min(waits), max(waits)), closed)
        found, always = search.best() if ends.any() else None, ends is not upper  # below 0: in the classes of all
        for factor, proof in search.proofs(found, len(base)) if found is not None else ():
            alpha = Fraction(double_above(Fraction(factor))) if math.isinf(most) else Fraction(most)
            if factor > (1 if always else alpha):
                continue
            shown = refutation(asked, Fraction(1) if always else alpha, proof)
            if shown is not None:
                return Fraction(0) if always else alpha, shown
    return None


def switching_refuting(
    asked: Problem, known: Fraction, most: float, *, whole: bool = False
) -> tuple[Fraction, Refuted] | None:
    """The smallest factor above what is known and up to ``most`` with gains that jump, or move as fast as they may.

    ``known``: a factor up to which nothing grows; ``most``: the largest factor of interest; ``whole``: whether as a
    refutation of the classes as they are given.
    """
    if any(one.operator == FULL_BLOCK and one.time_varying for one in asked.classes.classes):
        return as_members(asked, switching_refuting(narrowed(asked), known, most, whole=whole))
    if asked.classes.operators or any(one.memory for one in asked.classes.classes):
        return None
    lower, late = asked.classes.lower, isinstance(asked.plant, DelayMatrix)
    for one, rest in (_late_jumps if late else _jumps)(asked, double_above(known), most):
        factor = Fraction(one.factor)
        ends, alpha = (lower, asked.classes.scaled(factor).upper), Fraction(1) if whole else factor
        gains = [[ends[end][i] for i, end in enumerate(row)] for row in one.ends]
        shown = refutation(asked, alpha, {"method": "switched-gains", "gains": [texts(row) for row in gains], **rest})
        if shown is not None:
            return alpha, shown
    return None if late else _ramps_refuting(asked, known, most, whole=whole)


def _jumps(asked: Problem, known: float, most: float) -> Iterator[tuple[Switching, dict[str, Any]]]:
    """Gains that jump, for certificates, without dead times."""
    H, varying = channel_plant(asked.plant), _varying(asked)
    search = SwitchedGains(*H.doubles(), *_ends(asked), varying, asked.classes.blocks, H.dt is not None)
    for one in search.proposals(known, most):
        times = {} if search.discrete else {"times": texts(one.times)}
        yield one, times | {"squarings": one.squarings, "bits": one.bits}


def _late_jumps(asked: Problem, known: float, most: float) -> Iterator[tuple[LatePattern, dict[str, Any]]]:
    """The same beside dead times."""
    assert isinstance(asked.plant, DelayMatrix), "asked of such plants"
    search = LateSwitching(asked.plant, *_ends(asked), _varying(asked), asked.classes.blocks)
    for one in search.proposals(known, most):
        yield one, one.numbers


def _varying(asked: Problem) -> tuple[bool, ...]:
    return tuple(one.time_varying and not one.linear for one in asked.classes.classes)


def _ends(asked: Problem) -> tuple[Reals, Reals]:
    return np.array([float(v) for v in asked.classes.lower]), np.array([float(v) for v in asked.classes.upper])


def parameters_refuting(
    asked: Problem, known: Fraction, most: float, *, whole: bool = False
) -> tuple[Fraction, Refuted] | None:
    """The smallest factor above what is known with parameters or gains that change; 0 where no gain is needed.

    Parameters
    ----------
    asked : Problem
        The question, about plants with parameters.
    known : Fraction
        A factor up to which nothing grows; 0 where nothing is known.
    most : float
        The largest factor of interest.
    whole : bool
        Whether as a refutation of the classes as they are given.
    """
    family, classes = asked.plant, asked.classes
    assert isinstance(family, ChannelFamily), "asked of such plants"
    plain = not classes.operators and not classes.rectified and not any(one.memory for one in classes.classes)
    if not plain:
        return None
    search, best = MovingParameters(family, classes), None
    for moving in (search.jumps, search.ramps):
        for one in moving(double_above(known), most):
            alpha = Fraction(1) if whole or not one.factor else Fraction(one.factor)
            proof: dict[str, Any] = {"method": MEMBERS, "at": [texts(row) for row in one.at]}
            proof |= {"gains": [texts(row) for row in one.gains], "squarings": one.squarings, "bits": one.bits}
            shown = refutation(asked, alpha, proof | ({} if search.discrete else {"times": texts(one.times)}))
            if shown is not None:
                best = alpha if whole else Fraction(one.factor), shown
                break
        if best is not None and (whole or not best[0]):
            break
        most = most if best is None else float(best[0])
    return best


def _ramps_refuting(asked: Problem, known: Fraction, most: float, *, whole: bool) -> tuple[Fraction, Refuted] | None:
    """The same with gains that move no faster than their rates."""
    H, classes = channel_plant(asked.plant), asked.classes
    rates = [classes.classes[block[0]].rate for block in classes.blocks]
    search = RampedGains(*H.doubles(), classes.lower, classes.upper, rates, classes.blocks, H.dt is not None)
    for one in search.proposals(double_above(known), most, lowest=not whole):
        alpha = Fraction(1) if whole else Fraction(one.factor)
        proof: dict[str, Any] = {"gains": [texts(row) for row in one.gains], "squarings": one.squarings}
        proof |= {"method": "switched-gains"} if search.discrete else {"method": RAMPS, "times": texts(one.times)}
        shown = refutation(asked, alpha, proof | {"bits": one.bits})
        if shown is not None:
            return alpha, shown
    return None


def unlimited(asked: Problem, tried: Iterable[Sequence[Fraction]] = ()) -> Refuted | None:
    """Constant gains with which no gain from ``w`` to ``z`` is finite: a pole on the axis or beyond that ``z`` sees.

    ``asked``: the question, about a gain.  ``tried``: gains, one for each channel; by default those at the ends of the
    classes.
    """
    if isinstance(asked.plant, DelayMatrix):
        return _unlimited_late(asked, asked.plant)
    H, classes = channel_plant(asked.plant), asked.classes
    own = [*(classes.performance or ())]
    for gains in tried or ends_of(asked):
        checkpoint()
        A, B, C, D = H.doubles()
        G, one = np.diag([*map(float, gains)]), np.eye(len(D))
        if abs(np.linalg.det(one + D @ G)) < _ON_AXIS or not len(A):
            continue
        E = np.linalg.inv(one + D @ G)
        A, B, C = A - B @ G @ E @ C, (B @ (one - G @ E @ D))[:, own], (E @ C)[own]
        poles = np.linalg.eigvals(A).astype(complex)
        size, away = float(np.abs(poles).max()) or 1.0, np.abs(poles) - 1 if H.dt is not None else poles.real
        places = list[tuple[int, int]]()
        for pole in poles[away >= -_SURE * size][:_POLES]:  # where is its part the largest nearby?
            near = pole + _NEARBY * size * (pole / (abs(pole) or 1.0) if H.dt is not None else 1.0)
            seen = np.abs(C @ np.linalg.solve(near * np.eye(len(A)) - A, B.astype(complex)))
            places.append(divmod(int(seen.argmax()), len(own)))
        for i, j in dict.fromkeys(places):
            pair = {"unlimited": [i + 1, j + 1]}
            shown = refutation(asked, Fraction(1), constant_gains(gains) | pair)
            if shown is not None:
                return shown
    return None


def _unlimited_late(asked: Problem, plant: DelayMatrix) -> Refuted | None:
    """The same of a plant with dead times: a root in ``Re s > 0``, or at 0, that ``w`` moves and ``z`` sees."""
    own = [*(asked.classes.performance or ())]
    if plant.rates or asked.classes.rectified or not plant.order:
        return None
    roots, (A, _, _, D), one = LateRoots(plant), plant.base.doubles(), np.eye(plant.inputs)
    for gains in ends_of(asked):
        G = np.diag([float(g) for g in gains])
        if abs(np.linalg.det(one + D @ G)) < _ON_AXIS:
            continue
        root = roots.rightmost(np.diagonal(G))
        size = float(np.abs(A).max()) + abs(root) or 1.0
        if root.real < -_SURE * size:
            continue
        H = plant.transfer(root + _NEARBY * size)  # where is its part the largest nearby?
        i, j = divmod(int(np.abs(np.linalg.solve(one + H @ G, H)[np.ix_(own, own)]).argmax()), len(own))
        proof = {"method": "late-gains", "gains": texts(gains), "unlimited": [i + 1, j + 1]}
        at = [str(Fraction(f"{part:.14g}")) for part in (root.real, root.imag)]
        discs = [str(Fraction(f"{step * size:.3g}")) for step in _DISCS if step * size < root.real]
        for where, radius in [(at, disc) for disc in discs] or [(["0", "0"], "0")]:
            shown = refutation(asked, Fraction(1), proof | {"root": where, "radius": radius})
            if shown is not None:
                return shown
    return None


def ends_of(asked: Problem) -> Iterator[list[Fraction]]:
    """The gains at the ends of the classes, of play and stop those that they come near to; 0 of operators."""
    classes, free = asked.classes, list[range]()
    start = [
        Fraction(0 if one.memory else 1 if one.operator in DELAYS else low)
        for one, low in zip(classes.classes, classes.lower, strict=True)
    ]
    free = [b for b in classes.blocks if not classes.classes[b[0]].operator]
    most = (
        product((False, True), repeat=len(free))
        if len(free) <= _CORNERS
        else ((up,) * len(free) for up in (False, True))
    )
    for corner in most:
        gains = list(start)
        for up, block in zip(corner, free, strict=True):
            for i in block if up else ():
                gains[i] = classes.upper[i]
        yield gains


def matrices_refuting(asked: Problem, most: float) -> tuple[Fraction, Refuted] | None:
    """Matrices of gains for functions of several channels, constant gains of the others: the smallest factor.

    ``asked``: the question, functions of several channels being its only operators.  ``most``: the largest factor of
    interest; finite: of the classes of that factor.
    """
    H, classes = channel_plant(asked.plant), asked.classes
    ends, inside = (classes.lower, classes.upper), {i for block in classes.operators for i in block}
    search = MatrixGains(*H.doubles(), *ends, classes.blocks, classes.operators, H.dt is not None)
    for alpha, rows in search.found(most):
        wide = [[texts(rows[i][j] for j in block) for i in block] for block in classes.operators]
        gains = [low if i in inside else rows[i][i] for i, low in enumerate(classes.lower)]
        shown = refutation(asked, alpha, constant_gains(gains) | {"matrices": wide})
        if shown is not None:
            return alpha, shown
    return None


def narrowed(asked: Problem) -> Problem:
    """The question with a function in each channel in place of functions of several: its members are members."""
    classes, sizes = list(asked.classes.classes), list[int]()
    for block in asked.classes.blocks:
        one = classes[block[0]]
        sizes += [1] * len(block) if one.operator == FULL_BLOCK else [len(block)]
        for i in block if one.operator == FULL_BLOCK else ():
            classes[i] = replace(one, operator="")
    return replace(asked, classes=Diagonal(tuple(classes), repeated=tuple(sizes)))


def as_members(asked: Problem, found: tuple[Fraction, Refuted] | None) -> tuple[Fraction, Refuted] | None:
    """What refutes the narrower classes, as a refutation of those asked about; ``found``: of :func:`narrowed`."""
    if found is None:
        return None
    shown = refutation(asked, found[0] or Fraction(1), found[1].certificate["proof"])
    return None if shown is None else (found[0], shown)


def constant_gains(gains: Sequence[Fraction]) -> dict[str, Any]:
    """The proof of a certificate that constant gains refute; ``gains``: one for each channel."""
    return {"method": "linear-gains", "gains": texts(gains)}


def refutation(asked: Problem, alpha: Fraction, proof: Mapping[str, Any]) -> Refuted | None:
    """What the checker accepts against the classes of a factor; None if nothing.

    ``proof``: the proof of the certificate.
    """
    draft = {"verdict": "REFUTED", "system": asked.system, "theorem": "counterexample", "proof": dict(proof)}
    try:  # a class whose lower bound is above 0 is empty for some factors: then nothing is refuted
        shown = checked(draft | {"laws": asked.scaled(alpha).class_entry})
    except (Rejected, InputError):
        return None
    # gains that leave an eigenvalue 0 refute nothing where an end of the classes is a critical case
    other = shown.certificate["conclusion"] == OTHERS
    other = other and (proof.get("proof", proof)["method"] != RESTS or is_critical(asked))
    return shown if isinstance(shown, Refuted) and not other else None


def orbits_refuting(
    asked: Problem, known: Fraction, most: float, *, whole: bool = False
) -> tuple[Fraction, Refuted] | None:
    """The smallest factor above what is known and below ``most`` with a periodic solution of piecewise linear members.

    ``known``: a factor up to which there is none; ``most``: the largest factor of interest; ``whole``: whether as a
    refutation of the classes as they are given.
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

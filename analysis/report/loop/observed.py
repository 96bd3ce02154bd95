"""The loop simulated: what was observed of the given member, and the stop if a solution contradicts what is proved."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lure.analysis.certificates.checker import ATTRACTS, BOUNDED, CONVERGES
from lure.analysis.counterexamples.channel_solutions import Hysteron, channel_solutions
from lure.analysis.counterexamples.confirming import BUDGET, Conclusion, scales, tried
from lure.analysis.counterexamples.simulated import Characteristic, nonlinearity_entry, orbit_start
from lure.analysis.counterexamples.trajectories import Finding, Trajectory, natural_frequency
from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.questions import LoopAnalysis
from lure.analysis.report.parts import ContradictionError
from lure.analysis.verdict import Verdict, Witness
from lure.classes import Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.exact import exact_number
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.channel_family import ChannelFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Runs = tuple[Trajectory, ...]

SHOWN = 6
"""Trajectories kept for figures."""
MOST_SIMULATED = 60
"""States, or channels, up to which several nonlinearities are simulated."""
_CONCLUSIONS: dict[str, Conclusion] = {
    ATTRACTS: "0 attracts",
    CONVERGES: "converges to equilibria",
    BOUNDED: "bounded",
}
_ORBITS = 2
_SHARE = BUDGET // 4
_WORDS = {
    Finding.RESTS: "came to rest at equilibria other than 0",
    Finding.OSCILLATES: "went on oscillating without decay",
    Finding.GROWS: "grew to the end of the run",
    Finding.UNSOLVABLE: "ended where sigma + H(inf) phi(sigma) = c x has no solution",
    Finding.OPEN: "not decided by the run",
}


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Observation:
    """What simulations of a loop showed: OBSERVED evidence."""

    sentences: tuple[str, ...] = quantity(
        "On the given nonlinearity, or those of several channels, known or members of their classes; empty without "
        "one or with dead time",
        default=(),
    )
    trajectories: Runs = quantity(
        "Some of the solutions: of the given nonlinearity, or of members of the class proved where no nonlinearity "
        "is given",
        default=(),
    )


def observed(found: LoopAnalysis) -> Observation:
    """The given nonlinearity simulated; without a nonlinearity, members of the class that is proved.

    Raises
    ------
    ContradictionError
        A solution does, beyond the error of its computation, what is proved not to happen; or the class said to be
        proved holds an unstable linear gain or a certified counterexample.
    """
    about = found.problem
    block, nonlinearity = about.plant, about.nonlinearity
    if isinstance(block, ChannelFamily):
        return Observation()
    if isinstance(block, MultivariablePlant):
        return _several(found, block)
    if not isinstance(block, RationalPlant) or block.order == 0:
        return Observation()
    claimed, conclusion = _claim(found)
    if claimed is not None:
        _members(found, block, claimed, conclusion)
    if nonlinearity is None:
        return Observation(trajectories=_examples(found, block, claimed, conclusion))
    if block.dt is None and not getattr(nonlinearity, "locally_lipschitz", True):
        return Observation(
            sentences=(
                "the nonlinearity was not simulated: it is not locally Lipschitz, and its solutions need not be unique",
            )
        )
    of_nonlinearity: Conclusion = (
        "0 attracts" if found.verdict is Verdict.PROVED and found.conclusion.attracts else conclusion
    )
    try:
        seen = tried(block, nonlinearity, conclusion=of_nonlinearity, orbits=_orbits(found, block, nonlinearity))
    except (AssumptionError, InputError) as refused:
        return Observation(sentences=(f"the nonlinearity was not simulated: {refused}",))
    if seen.contradiction is not None:
        raise ContradictionError(_against(found, seen.contradiction))
    return Observation(sentences=(_sentence(seen.trajectories),), trajectories=_chosen(seen.trajectories))


def _several(found: LoopAnalysis, plant: MultivariablePlant) -> Observation:
    """The nonlinearities of several channels simulated, where they are known; else members of their classes.

    Raises
    ------
    ContradictionError
        A solution grows a million times, and it is proved that all tend to 0.
    """
    about = found.problem
    if max(plant.order, plant.inputs) > MOST_SIMULATED:
        return Observation()
    known = [("", list(about.known), about.nonlinearity_words)] if about.known else list(_in_channels(about.classes))
    sentences, shown = list[str](), list[Trajectory]()
    for name, members, words in known:
        try:
            runs = channel_solutions(plant, members, words)
        except InputError as refused:
            return Observation(sentences=(f"the classes were not simulated: {refused}",))
        growing = next((run for run in runs if run.finding is Finding.GROWS), None)
        if growing is not None and found.verdict is Verdict.PROVED and _claimed(found) == "0 attracts":
            raise ContradictionError(_against(found, growing))
        sentences.append(f"{name}{_sentence(runs)}")
        shown += runs
    return Observation(sentences=tuple(sentences), trajectories=tuple(shown))


def _in_channels(classes: Diagonal) -> Iterator[tuple[str, list[Graph | Hysteron], str]]:
    """Members of the classes of several channels, in all of them of one kind: what they are, and their names.

    None where an operator or a delay closes a channel; gains stay gains, a ReLU a ReLU, play and stop have the largest
    slope and the half-width 1.
    """
    if classes.operators:
        return
    one, kinds = Fraction(1), ("saturations", "dead zones", "gains")
    fixed = [bool(each.linear or each.memory or each.rectifier) for each in classes.classes]
    for kind in kinds[-1:] if all(fixed) else kinds:
        members, words = list[Graph | Hysteron](), list[str]()
        for i, (each, low, high) in enumerate(zip(classes.classes, classes.lower, classes.upper, strict=True), 1):
            gain = f"the gain {float(high):.4g}"
            if each.memory:
                members.append(Hysteron(each.memory == "stop", float(high)))
                words.append(f"phi_{i} a {each.memory} of slope {float(high):.4g}")
            elif each.rectifier:
                members.append(Graph.through([(-one, -low), (one, high)], low, high))
                words.append(f"phi_{i} the ReLU")
            elif each.linear or kind == "gains":
                members.append(Graph.through([(-one, -high), (one, high)], high, high))
                words.append(f"phi_{i} {gain}")
            else:
                inner, outer = (high, low) if kind == "saturations" else (low, high)
                members.append(Graph.through([(-one, -inner), (one, inner)], outer, outer))
                ends = f"between the slopes {float(low):.4g} and {float(high):.4g}"
                words.append(f"phi_{i} a {kind[:-1]} {ends}")
        named = ", ".join(words)
        yield f"{named}: ", members, named


def _claimed(found: LoopAnalysis) -> Conclusion:
    """What is said to be proved of every solution."""
    said = "" if found.shown is None else str(found.shown.certificate["conclusion"])
    return next((short for text, short in _CONCLUSIONS.items() if said.startswith(text)), "bounded")


def _sentence(runs: Runs) -> str:
    found = Counter(run.finding for run in runs)
    longest = max(run.until for run in runs)
    if longest == 0:
        return "the nonlinearity was not simulated: a solution takes more evaluations of it than are granted"
    seen = [float(np.abs(run.sigma[np.isfinite(run.sigma)]).max(initial=0.0)) for run in runs]
    words = (
        f"{len(runs)} simulated solutions over up to {longest:.4g} {runs[0].unit}, with |sigma| up to {max(seen):.3g}"
    )
    if found[Finding.CONVERGES] == len(runs):
        return f"{words}: all converged to 0, |sigma| ended below a ten-thousandth of its largest value"
    parts = [f"{found[Finding.CONVERGES]} converged to 0"] if found[Finding.CONVERGES] else []
    parts += [f"{found[kind]} {text}" for kind, text in _WORDS.items() if found[kind]]
    return f"{words}: {'; '.join(parts)}"


def _against(found: LoopAnalysis, run: Trajectory) -> str:
    return (
        f"what is said to be proved of {found.problem.name}, {found.statement!r:.200}, is contradicted by a simulated "
        f"solution with {run.nonlinearity}, which {run.finding} within {run.until:.4g} {run.unit} ({run.start}); one "
        "of the two is wrong, or what is declared of the nonlinearity is false: please report the loop"
    )


def _claim(found: LoopAnalysis) -> tuple[NonlinearityClass | None, Conclusion]:
    """The class said to be proved, and of what; no conclusion if nothing is."""
    if found.verdict is not Verdict.PROVED or found.shown is None:
        return None, ""
    conclusion = _claimed(found)
    if found.problem.given is not None:
        return found.problem.given, conclusion
    row = next((row for row in found.rows if row.proof is found.shown), found.rows[0])
    low, high = row.lower, row.largest.low
    upper = exact_number(high, "k") if math.isfinite(high) else math.inf
    if not low < upper:
        return None, ""
    slope = SlopeBounds(low, upper) if row.question == "slope" else None
    return NonlinearityClass(
        sector=Sector(low, upper), slope=slope, odd=row.odd, time_varying=row.time_varying
    ), conclusion


def _members(found: LoopAnalysis, block: RationalPlant, claimed: NonlinearityClass, conclusion: Conclusion) -> None:
    """Stop if the class said to be proved holds a linear gain that is not stable, or a certified counterexample.

    Raises
    ------
    ContradictionError
        It does.
    """
    gain = _unstable_gain(found, block, claimed.sector, critical=conclusion != "0 attracts")
    if gain is None:
        witness = next((one for low, one in _witnesses(found) if _belongs(low, one, claimed)), None)
        against = None if witness is None else str(witness)
    else:
        against = f"phi = {gain} sigma, for which the loop is not stable"
    if against is not None:
        raise ContradictionError(
            f"what is said to be proved of {found.problem.name}, {found.statement!r:.200}, is contradicted by a member "
            f"of the class {claimed}: {against}; one of the two is wrong: please report the loop"
        )


def _unstable_gain(found: LoopAnalysis, block: RationalPlant, sector: Sector, *, critical: bool) -> str | None:
    """A gain of the sector that is not stable, in words; by exact counts of roots."""
    low, high = sector.lower, sector.upper
    for end in (high,) if critical else (low, high):
        if math.isfinite(end) and not is_stable_gain(block, exact_number(end, "gain")):
            return f"{float(end):.9g}"
    if found.gains is None:  # there was no time for them
        return None
    for one in found.gains:
        if one.lower.value.low <= low and high <= one.upper.value.high:
            return None
    return f"k, for some k in {sector}"


def _witnesses(found: LoopAnalysis) -> Iterator[tuple[Fraction, Witness]]:
    """The nonlinear counterexamples that the checker accepted, once each, with the lower end of their class."""
    seen: set[str] = set()
    for row in found.rows:
        witness = row.witness
        if witness is None or witness.refutation is None or witness.kind == "linear gain" or str(witness) in seen:
            continue
        seen.add(str(witness))
        yield row.lower, witness


def _belongs(lower: Fraction, witness: Witness, claimed: NonlinearityClass) -> bool:
    """Whether the class has the nonlinearity of a witness, found for classes from ``lower`` on, as a member."""
    bounds = claimed.slope or claimed.sector
    return (
        (bounds.lower, bounds.upper) == (claimed.sector.lower, claimed.sector.upper)
        and bounds.lower <= lower
        and witness.k <= bounds.upper
        and (witness.odd or not claimed.odd)
        and (witness.slope_restricted or claimed.slope is None)
        and (claimed.time_varying or not witness.time_varying)
    )


def _orbits(
    found: LoopAnalysis, block: RationalPlant, nonlinearity: Characteristic
) -> list[tuple[NDArray[np.float64], float]]:
    """States on the orbits of counterexamples, scaled from the kinks of their graphs to the scales of this one."""
    orbits = [
        (*orbit_start(block, witness), scales(nonlinearity_entry(witness))[0])
        for _, witness in _witnesses(found)
        if witness.kind == "periodic orbit"
    ]
    return [(state * (knee / own), period) for state, period, own in orbits[:_ORBITS] for knee in scales(nonlinearity)]


def _examples(
    found: LoopAnalysis, block: RationalPlant, claimed: NonlinearityClass | None, conclusion: Conclusion
) -> Runs:
    """Solutions with extreme members of the class that is proved.

    Raises
    ------
    ContradictionError
        One contradicts what is proved.
    """
    shown: list[Trajectory] = []
    for name, nonlinearity in _extremes(block, claimed) if claimed is not None else ():
        try:
            seen = tried(
                block, nonlinearity, conclusion=conclusion, orbits=_orbits(found, block, nonlinearity), budget=_SHARE
            )
        except (AssumptionError, InputError):
            continue
        if seen.contradiction is not None:
            raise ContradictionError(_against(found, replace(seen.contradiction, nonlinearity=name)))
        shown += [replace(run, nonlinearity=name) for run in _chosen(seen.trajectories)[:2]]
    return tuple(shown[:SHOWN])


def _extremes(block: RationalPlant, claimed: NonlinearityClass) -> Iterator[tuple[str, Graph]]:
    """Piecewise-linear members of a class: gains of both its ends, inside and outside of ``|sigma| <= 1``."""
    bounds = claimed.sector
    if not math.isfinite(bounds.lower):
        return
    low, one = exact_number(bounds.lower, "lower"), Fraction(1)
    high = exact_number(bounds.upper, "upper") if math.isfinite(bounds.upper) else low + _large_gain(block)
    ends = f"{float(low):.6g} and {float(high):.6g}"
    yield f"a saturation between the slopes {ends}", Graph.through([(-one, -high), (one, high)], low, low)
    yield f"a dead zone between the slopes {ends}", Graph.through([(-one, -low), (one, low)], high, high)
    if not claimed.odd:
        yield f"a rectifier with the slopes {ends}", Graph.through([(-one, -low), (one, high)], low, high)
    if claimed.slope is None:
        far = Fraction(21, 20)
        points = [(one, low), (far, high * far), (3 * one, 3 * high), (3 * far, low * 3 * far)]
        mirrored = [(-x, -y) for x, y in reversed(points)]
        yield f"a gain that changes with |sigma| between {ends}", Graph.through([*mirrored, *points], low, low)


def _large_gain(block: RationalPlant) -> Fraction:
    """Ten times the gain that balances the block near its own frequency."""
    at = 1j * float(natural_frequency(block, Fraction(1))) if block.dt is None else np.exp(1j)
    size = float(np.abs(block.transfer(at)))
    return Fraction(10 / size) if math.isfinite(size) and size > 1e-300 else Fraction(10)


def _chosen(runs: Runs) -> Runs:
    """A few of them: one of each finding, then those of other sizes."""
    kinds = {(run.start, run.finding): run for run in reversed(runs)}
    first = {run.finding: run for run in reversed(runs)}
    return tuple(sorted(kinds.values(), key=lambda run: (first[run.finding] is not run, runs.index(run)))[:SHOWN])

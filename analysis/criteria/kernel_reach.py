"""How far multipliers of Zames and Falb reach: bisection in floating point, every result proved exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import reduce

from analysis.criteria.kernel_certificate import check, check_every
from analysis.criteria.kernel_scaled import Scaled
from analysis.criteria.kernel_search import TOLERANCE, Family, Proposal, Search
from analysis.criteria.kernel_seeds import seeds
from analysis.criteria.kernels import Multiplier
from analysis.plant import Plant

BELOW = (0.0, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5)
CAP = 1e6
CLOSE = 2e-8
TRIVIAL = Multiplier(Fraction(0), ())


@dataclass(frozen=True, slots=True)
class Reach:
    """A certified slope ``k`` (None: every finite one) and the multiplier that proves it."""

    k: Fraction | None
    multiplier: Multiplier


@dataclass(frozen=True, kw_only=True, slots=True)
class Task:
    """The class ``[lower, k]`` and what is known beforehand.

    Attributes
    ----------
    plant : Plant
        ``H / (1 + lower H)``, strictly stable, in continuous time.
    lower : Fraction
        Lower slope.
    limit : float
        Every ``k`` looked for is strictly below it: the loop with the gain ``limit`` is not stable, or ``inf``.
    odd : bool
        Whether coefficients may be negative.
    full : bool
        Whether to take more time.
    """

    plant: Plant
    lower: Fraction
    limit: float
    odd: bool
    full: bool

    @property
    def families(self) -> tuple[Family, ...]:
        """The kernels to try, in this order."""
        return ("gamma", "delays", "both") if self.full else ("gamma", "delays")


def reach(task: Task) -> Reach | None:
    """The largest ``k`` proved; None if not even a small one was."""
    if _static(task.plant):
        edge = _rounded_down(Fraction(min(task.limit, 1e300)), task)
        return every(task, TRIVIAL) or (Reach(edge, TRIVIAL) if edge and proved(task, edge, TRIVIAL) else None)
    best = _known(task)
    scaled = Scaled.of(task.plant)
    cap = _cap(task, scaled)[0]
    if best is not None and (best.k is None or float((best.k - task.lower) * scaled.gain) >= cap * (1 - CLOSE)):
        return best
    searches = [scaled.search(family, odd=task.odd, full=task.full) for family in task.families]
    for search in searches:
        found = next((certify(task, scaled, search, start) for start in _at_cap(task, scaled, search)), None)
        best = _larger(best, found)
        if found is not None and best is found:
            return every(task, found.multiplier) or found
    for search in reversed(searches):
        start = _farthest(task, scaled, search, best)
        if start is not None:
            best = _larger(best, certify(task, scaled, search, start))
    return best


def _known(task: Task) -> Reach | None:
    """The best of what less work and stricter assumptions give."""
    if task.full or task.odd:
        easier = [replace(task, full=False)] if task.full else []
        easier += [replace(task, odd=False)] if task.odd else []
        return reduce(_larger, map(reach, easier))
    best: Reach | None = None
    for k, multiplier in seeds(task.plant.block, task.lower):
        if k is None:
            best = _larger(best, every(task, multiplier))
        elif proved(task, k, multiplier):
            best = _larger(best, Reach(k, multiplier))
    return best


def _larger(one: Reach | None, two: Reach | None) -> Reach | None:
    if one is None or two is None:
        return one or two
    return two if one.k is not None and (two.k is None or two.k > one.k) else one


def every(task: Task, multiplier: Multiplier) -> Reach | None:
    """Every finite slope, if this multiplier proves them all."""
    legal = task.limit == math.inf and multiplier.admissible(odd=task.odd)
    return Reach(None, multiplier) if legal and check_every(task.plant, multiplier) else None


def proved(task: Task, k: Fraction, multiplier: Multiplier) -> bool:
    """Whether the multiplier is legal and proves the slopes ``[lower, k]``."""
    legal = task.lower < k < task.limit and multiplier.admissible(odd=task.odd)
    return legal and check(task.plant, k - task.lower, multiplier).holds


def propose_at(task: Task, k: Fraction) -> Reach | None:
    """A proof for the slopes ``[lower, k]`` of one class; None if none was found."""
    if not task.lower < k < task.limit:
        return None
    if _static(task.plant):
        return Reach(k, TRIVIAL) if proved(task, k, TRIVIAL) else None
    for known, multiplier in seeds(task.plant.block, task.lower):
        if (known is None or known >= k) and proved(task, k, multiplier):
            return Reach(k, multiplier)
    scaled = Scaled.of(task.plant)
    for family in task.families:
        found = _attempts(task, scaled, scaled.search(family, odd=task.odd, full=task.full), k)
        if found is not None:
            return found
    return None


def least_sample(plant: Plant, width: Fraction, multiplier: Multiplier) -> float:
    """A frequency [rad/s] near which the left-hand side is least, from samples."""
    if _static(plant):
        return 0.0
    scaled = Scaled.of(plant)
    search = scaled.search("none")
    return search.least(multiplier.scaled(1 / scaled.unit), float(width * scaled.gain)) * float(scaled.unit)


def certify(task: Task, scaled: Scaled, search: Search, start: tuple[float, Proposal]) -> Reach | None:
    """A proof at, or somewhat below, a slope that the search found feasible."""
    for below in BELOW:
        k = _rounded_down(task.lower + Fraction(start[0] * (1 - below)) / scaled.gain, task)
        if k is None:
            continue
        if proved(task, k, start[1].multiplier.scaled(scaled.unit)):
            return Reach(k, start[1].multiplier.scaled(scaled.unit))
        found = _attempts(task, scaled, search, k)
        if found is not None:
            return found
    return None


def _attempts(task: Task, scaled: Scaled, search: Search, k: Fraction) -> Reach | None:
    """Propose and check; a frequency at which the check fails becomes a row of the next programme."""
    width = float((k - task.lower) * scaled.gain)
    for _ in range(6 if task.full else 4):
        proposal = search.propose(width)
        if proposal is None or not proposal.least > 0:
            return None
        multiplier = proposal.multiplier.scaled(scaled.unit)
        found = check(task.plant, k - task.lower, multiplier)
        if found.holds and multiplier.admissible(odd=task.odd):
            return Reach(k, multiplier)
        if found.where is None or not math.isfinite(found.where):
            return None
        search.add_row(found.where / float(scaled.unit))
    return None


def _cap(task: Task, scaled: Scaled) -> tuple[float, float]:
    """The width, scaled, at which the search stops, and the limit, which may be the same."""
    limit = float((Fraction(task.limit) - task.lower) * scaled.gain) if math.isfinite(task.limit) else math.inf
    return min(CAP, limit), limit


def _at_cap(task: Task, scaled: Scaled, search: Search) -> Iterator[tuple[float, Proposal]]:
    """A multiplier just below the limit or at the largest slope asked for, if the search has one."""
    cap, limit = _cap(task, scaled)
    for width in (cap * (1 - 1e-8), cap * (1 - 1e-6)) if cap == limit else (cap,):
        found = _feasible(search, width)
        if found is not None:
            yield found
            return


def _farthest(task: Task, scaled: Scaled, search: Search, best: Reach | None) -> tuple[float, Proposal] | None:
    """The largest slope, scaled, at which the search has a multiplier on its fine grid, if above the best known."""
    high, _ = _cap(task, scaled)
    known = float((best.k - task.lower) * scaled.gain) if best is not None and best.k is not None else 1e-3
    found = _feasible(search, known * 1.0005)
    if found is None:
        return None
    width, proposal = found
    while high > width * (1 + (1e-6 if task.full else 1e-4)):
        farther = min(search.largest(proposal.multiplier, width), high * (1 - 1e-9))
        width = max(width, width + (farther - width) * (1 - 1e-6))
        middle = min(math.sqrt(width * high), 8 * width)
        found = _feasible(search, middle)
        if found is None:
            high = middle
        else:
            width, proposal = found
    return width, proposal


def _feasible(search: Search, width: float) -> tuple[float, Proposal] | None:
    proposal = search.propose(width)
    return (width, proposal) if proposal is not None and proposal.least > TOLERANCE else None


def _static(plant: Plant) -> bool:
    return plant.d.degree() == 0 or plant.n.degree() < 0


def _rounded_down(k: Fraction, task: Task) -> Fraction | None:
    """The slope as a double of nine digits, in the class and not above ``k``; None if there is none."""
    if not math.isfinite(float(k)):
        return None
    for digits in (9, 12, 15, 17):
        value = float(f"{float(k):.{digits}g}")
        step = abs(value) * 10.0 ** (1 - digits)
        for candidate in (value, float(f"{value - step:.{digits}g}")):
            if task.lower < Fraction(candidate) <= k and candidate < task.limit:
                return Fraction(candidate)
    return None

"""One loop with one channel: asked in two forms, its answers attacked, its certificates checked twice."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from campaign import members, quick
from campaign.draws import Drawn, drawn
from campaign.forms import FORMS, LATE, Brought, brought, plain
from campaign.replay import replayed

from lure import AssumptionError, InputError, NonlinearityClass, Sector
from lure.analysis import certify, max_sector, max_slope
from lure.analysis.certificates import checker
from lure.analysis.certificates.second import recheck
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.verdict import Verdict

Counts = Counter[str]
Found = tuple[Counts, list[str]]


@dataclass(frozen=True, kw_only=True)
class Shares:
    """How long a search may take, and which shares of the loops are treated in the dear ways."""

    seconds: float
    deep: float
    brackets: float
    forms: float = 1.0
    checkers: float = 1.0
    quick: bool = False


WHOLE, LATE_ONES = Shares(seconds=2.0, deep=0.15, brackets=0.4), Shares(seconds=2.0, deep=0.6, brackets=0.4)
SMALL_ONES = Shares(seconds=0.02, deep=0.01, brackets=0.01, forms=0.05, checkers=0.1, quick=True)


@dataclass(frozen=True, kw_only=True)
class Depth:
    """Whether the dear attacks are made too, and whether the class is as large as could be proved."""

    deep: bool
    shares: Shares = WHOLE
    end: bool = False


def checked(certificate: Mapping[str, Any]) -> str:
    """What a checker says against a certificate."""
    try:
        checker.check(certificate)
    except Exception as error:  # whatever it raises is said
        return f"the first checker refuses: {error}"
    opinion = recheck(certificate, seconds=20)
    late = not opinion.accepted and ("time" in opinion.reason)
    return "" if opinion.accepted or late else f"the second checker refuses: {opinion.reason}"


def proved(case: Drawn, conclusion: str, rng: np.random.Generator, counts: Counts, *, depth: Depth) -> list[str]:
    """Every attack that fits on a class that is proved; at an end, where loops hardly decay, most stay below it."""
    attacks: list[Callable[[Drawn, str, np.random.Generator], str]] = [members.constant]
    one = case.one
    if case.plant.delay:
        attacks += [members.late] if depth.deep else []
    elif one.time_varying and not one.linear:
        attacks.append(members.jumping if depth.deep or not depth.shares.quick else quick.words)
    elif one.rate is not None:
        attacks.append(quick.ramps)
    elif not one.linear and depth.deep:
        attacks.append(members.functions)
    if case.plant.discrete and not one.linear and depth.shares.quick:
        attacks.append(quick.integer_orbits)
    if case.plant.discrete and not one.linear and (depth.deep or (not depth.shares.quick and rng.random() < 0.4)):
        attacks.append(members.orbits)
    found = []
    for attack in attacks:
        counts[f"attack: {attack.__name__}"] += 1
        share = 0 if not depth.end or attack is members.constant else 50 if attack is members.late else 1000
        said = attack(below(case, share) if share else case, conclusion, rng)
        if said:
            found.append(f"PROVED ({conclusion}) against {said}")
    return found


def below(case: Drawn, share: int) -> Drawn:
    """The class with an upper end that is less by one in so many; more where an attack has the loop but nearly."""
    low, high = case.one.sector.lower, case.one.sector.upper
    if math.inf in (abs(low), abs(high)):
        return case
    return replace(case, one=case.one.scaled(1 - (high - low) / (share * abs(high)) * (1 if high > 0 else -1)))


def single(kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """Draw a loop of the kind, ask, attack."""
    case = drawn(rng, kind)
    counts: Counts = Counter()
    shares = SMALL_ONES if kind.startswith("small ") else LATE_ONES if case.plant.delay else WHOLE
    depth = Depth(deep=bool(rng.random() < shares.deep), shares=shares)
    if case.one.linear or rng.random() < 1 - shares.brackets or case.one.odd:
        faults = asked_class(case, rng, counts, depth)
    else:
        faults = asked_bracket(case, rng, counts, depth)
    return counts, faults, case


def one_class(
    case: Drawn, source: object, rng: np.random.Generator, counts: Counts, depth: Depth
) -> tuple[str, list[str]]:
    """The verdict on the class, and what contradicts it."""
    found = certify(source, case.one, ways=ProofOptions(seconds=depth.shares.seconds))
    verdict = str(found.verdict)
    counts[verdict] += 1
    faults: list[str] = []
    if found.certificate is None:
        return verdict, faults if verdict == "INCONCLUSIVE" else [f"{verdict} without a certificate"]
    if drawn_for(depth.shares.checkers, rng):
        counts["certificates"] += 1
        if said := checked(found.certificate):
            faults.append(said)
    if found.verdict is Verdict.PROVED:
        faults += proved(case, str(found.certificate["conclusion"]), rng, counts, depth=depth)
        if depth.shares.quick:
            counts["attack: inequality"] += 1
            said = quick.inequality(case, found.certificate)
            faults += [f"PROVED against {said}"] if said else []
    else:
        counts["replayed"] += 1
        said = replayed(case, found.certificate["proof"])
        counts["not replayed"] += said == "-"
        faults += [f"REFUTED: {said}"] if said not in ("", "-") else []
    return verdict, faults


def drawn_for(share: float, rng: np.random.Generator) -> bool:
    """Whether this loop is one of a share."""
    return share == 1 or bool(rng.random() < share)


def asked_class(case: Drawn, rng: np.random.Generator, counts: Counts, depth: Depth) -> list[str]:
    """One class, in two forms."""
    try:
        first, faults = one_class(case, plain(case.plant), rng, counts, depth)
        if not drawn_for(depth.shares.forms, rng):
            return faults
        other = second_form(case, rng)
        counts[f"form: {other.name}"] += 1
        second, more = one_class(other.case, other.source, rng, counts, replace(depth, deep=False))
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return []
    faults += [f"as {other.name}: {said}" for said in more]
    if {first, second} == {"PROVED", "REFUTED"}:
        faults.append(f"{first}, and as {other.name} {second}")
    counts["forms that differ in strength"] += first != second
    return faults


def second_form(case: Drawn, rng: np.random.Generator) -> Brought:
    """The loop in another form, drawn at random."""
    return brought(case, str(rng.choice(LATE if case.plant.delay else FORMS)), rng)


def one_bracket(
    case: Drawn, source: object, rng: np.random.Generator, counts: Counts, depth: Depth
) -> tuple[float, float, list[str]]:
    """The largest upper end proved, the least refuted, and what contradicts them."""
    one, lower = case.one, Fraction(case.one.sector.lower)
    if one.slope is not None:
        found = max_slope(source, lower=lower, seconds=depth.shares.seconds)
    else:
        found = max_sector(source, lower=lower, time_varying=one.time_varying, seconds=depth.shares.seconds)
    counts[str(found.verdict)] += 1
    low, high, faults = -math.inf, math.inf, []

    def about(upper: float) -> Drawn:
        top = upper if upper == math.inf else Fraction(upper)
        return Drawn(
            case.plant,
            NonlinearityClass.slope_restricted(lower, top)
            if one.slope is not None
            else NonlinearityClass(sector=Sector(lower, top), time_varying=one.time_varying),
        )

    if found.verdict is Verdict.PROVED:
        low = found.largest.low
        if found.proof is None or low < lower:
            return low, high, [f"PROVED up to {low} without a proof"]
        counts["certificates"] += 1
        said = checked(found.proof.certificate)
        faults += [said] if said else []
        if low > lower:
            conclusion = str(found.proof.certificate["conclusion"])
            faults += proved(about(low), conclusion, rng, counts, depth=replace(depth, end=True))
    if found.refuted_at is not None:
        high = found.refuted_at
        for refutation in found.refutations:
            counts["certificates"] += 1
            said = checked(refutation.certificate)
            faults += [said] if said else []
        if found.refutation is not None and high < math.inf:
            counts["replayed"] += 1
            if high > lower:
                said = replayed(about(math.nextafter(high, math.inf)), found.refutation.certificate["proof"])
                counts["not replayed"] += said == "-"
                faults += [f"REFUTED at {high!r}: {said}"] if said not in ("", "-") else []
    return low, high, faults


def asked_bracket(case: Drawn, rng: np.random.Generator, counts: Counts, depth: Depth) -> list[str]:
    """The largest class, in two forms."""
    if case.one.rate is not None or case.one.odd:
        return []
    try:
        low, high, faults = one_bracket(case, plain(case.plant), rng, counts, depth)
        other = second_form(case, rng)
        if other.factor < 0:
            other = brought(case, "text", rng)
        counts[f"form: {other.name}"] += 1
        low2, high2, more = one_bracket(other.case, other.source, rng, counts, replace(depth, deep=False))
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return []
    faults += [f"as {other.name}: {said}" for said in more]
    back = [(v - float(other.offset)) / float(other.factor) for v in (low2, high2)]
    slack = 1e-12 * (abs(float(case.one.sector.lower)) + min(abs(v) for v in (low, high, *back)))
    if max(low, back[0]) > min(high, back[1]) + slack:
        faults.append(f"[{low!r}, {high!r}], and as {other.name} {back}")
    return faults

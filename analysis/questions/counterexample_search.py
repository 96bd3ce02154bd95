"""The searches for a nonlinearity of a class that destabilises, put before the checker."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import islice
from typing import TYPE_CHECKING

from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import Refuted
from lure.analysis.certificates.drafts import Failure, check_for_class, complete_and_check, guarded
from lure.analysis.certificates.systems import class_entry
from lure.analysis.certificates.theory import theory_of
from lure.analysis.inequality.gains import hurwitz_limit, unstable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_below, text_above
from lure.analysis.numerics.precision import ball, outward
from lure.analysis.questions import families
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.proofs import EXPECTED
from lure.analysis.questions.worst_plants import least
from lure.analysis.verdict import Bracket, Evidence, Witness
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, Reason
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.family import PlantFamily, Point
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved
    from lure.analysis.certificates.proposals import Numbers

# Linear gains: members of every class.


@lru_cache(maxsize=64)
def worst(family: PlantFamily, lower: Fraction) -> tuple[Point, float]:
    """About where in a box the stable linear gains end first, and where they end there.

    ``lower``: the gain to begin with.
    """
    return least(family, lambda plant: hurwitz(Problem.largest(plant, "sector", lower=lower)).high)


def _at_worst(asked: Problem) -> tuple[Problem, Point]:
    """The question about the plant of a box at which the stable linear gains end first."""
    family, lower = asked.plant, asked.lower
    assert isinstance(family, PlantFamily)
    point, _ = worst(family, lower)
    return replace(asked, plant=family.at(point)), point


def hurwitz(asked: Problem) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``[lower, k]`` is stable (in the critical case: but 0)."""
    plant, lower = asked.plant, asked.lower
    if isinstance(plant, RationalPlant):
        if TransferPolynomials.of(plant).shifted(lower).case == "unstable":  # lower itself, a member of every class
            return outward(ball(lower), ball(lower))
        return hurwitz_limit(plant, lower)
    if isinstance(plant, PlantFamily):
        _, high = worst(plant, lower)
        return Bracket(min(double_below(lower), high), high)
    if isinstance(plant, StateSpace):
        witness = _smallest_gain(plant, lower)
        return Bracket(double_below(lower), math.inf if witness is None else witness.k)
    if isinstance(plant, DelayPlant):
        from lure.analysis.inequality.delay import Delayed, raised

        return raised(Delayed.of(plant, lower).gains(), lower)
    if lower != 0:
        raise AssumptionError(
            f"for a {type(plant).__name__} the classes begin at 0; got lower = {float(lower):g}: close a loop with "
            "that gain in the model first",
            code=Reason.NOT_APPLICABLE,
        )
    return theory_of(plant).hurwitz() if isinstance(plant, StructuredPlant) else Bracket(0.0, math.inf)


def critical(asked: Problem) -> bool:
    """Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): members of the class add equilibria."""
    plant = asked.plant.central if isinstance(asked.plant, PlantFamily) else asked.plant
    if isinstance(plant, RationalPlant):
        return TransferPolynomials.of(plant).shifted(asked.lower).case == "critical"
    if isinstance(plant, DelayPlant):
        plant = plant.closed(asked.lower) if plant.strictly_proper else plant
        return plant.denominator[-1] + sum(q[-1] for _, q in plant.feedback) == 0
    return isinstance(plant, StructuredPlant) and theory_of(plant).critical


def linear_witnesses(asked: Problem, limit: Bracket) -> list[Witness]:
    """The smallest destabilising linear gain of the classes asked about, if there is one, with what was accepted of it.

    ``asked``: of the largest class; ``limit``: from :func:`hurwitz`.
    """
    from lure.analysis.certificates.refutations import accepted_witness

    if isinstance(asked.plant, PlantFamily):
        one, point = _at_worst(asked)
        own = hurwitz(one) if isinstance(one.plant, DelayPlant) else limit
        return [families.refuted_at(asked.plant, point, witness) for witness in linear_witnesses(one, own)]
    if isinstance(asked.plant, StructuredPlant):
        return _of_structure(asked.plant)
    found = _smallest_gain(asked.plant, asked.lower, limit)
    return [] if found is None else [accepted_witness(asked.plant, found)]


def _of_structure(plant: StructuredPlant) -> list[Witness]:
    """What the structure of a plant refutes, the gain 0: a dashpot of a rod that feeds energy in."""
    draft, least = (
        theory_of(plant).refutation(),
        NonlinearityClass(slope=SlopeBounds(0, 1), sector=Sector(0, 1), odd=True),
    )
    if draft is None:
        return []
    stated = {**draft, "laws": class_entry(least, unbounded=False)}
    shown = guarded("linear gain", lambda: complete_and_check(stated), passing=(TimeoutError,))
    if not isinstance(shown, Refuted) or shown.certificate["proof"]["method"] != "structure":
        return []
    return [
        Witness(
            kind="linear gain",
            k=0.0,
            evidence=Evidence.CERTIFIED,
            slope_restricted=True,
            odd=True,
            description="phi = 0: the loop is not asymptotically stable",
            data={"lower": "0", "gain": "0"},
            refutation=shown,
        )
    ]


def _smallest_gain(plant: object, lower: Fraction, limit: Bracket | None = None) -> Witness | None:
    """The smallest gain from ``lower`` on that destabilises, as far as there is a way to find it for such a plant."""
    from lure.analysis.counterexamples.linear import linear_witness

    if isinstance(plant, RationalPlant):
        return linear_witness(plant, lower=lower)
    if isinstance(plant, StateSpace):
        from lure.analysis.certificates.refutations import growing_gain

        return growing_gain(plant, lower)
    if not isinstance(plant, DelayPlant):
        return None
    limit = hurwitz(Problem.largest(plant, "sector", lower=lower)) if limit is None else limit
    return _dead_time_gain(plant, limit, lower) if limit.high < math.inf else None


def _dead_time_gain(plant: DelayPlant, limit: Bracket, lower: Fraction) -> Witness:
    return Witness(
        kind="linear gain",
        k=limit.high,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"a linear gain of about {text_above(limit.high, 9)} puts a root on the imaginary axis, so that "
        "the loop does not come to rest",
        data={"gain": [limit.low, limit.high], "block": str(plant), "lower": str(lower)},
    )


def linear_refutation(asked: Problem, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A constant gain of the class with which the loop does not come to rest; or what the plant's structure refutes.

    ``numbers``: where the numbers came from.

    Returns
    -------
    Refuted or None
        None if every gain is stable, or the plant has none that is looked at.
    """
    from lure.analysis.certificates.refutations import refutation_draft

    plant, sector = asked.plant, asked.nonlinearity_class.sector
    if isinstance(plant, PlantFamily):
        return _of_one_plant(asked, linear_refutation, numbers)
    if isinstance(plant, StructuredPlant):
        draft = theory_of(plant).refutation()
        return None if draft is None else check_for_class(asked, {**draft, "numbers": numbers})
    if not isinstance(plant, RationalPlant | DelayPlant | StateSpace):
        return None
    bounds = asked.nonlinearity_class.slope or sector if isinstance(plant, StateSpace) else sector
    if isinstance(plant, DelayPlant):
        lower = Fraction(bounds.lower) if bounds.lower != -math.inf and plant.strictly_proper else Fraction(0)
        witness = _smallest_gain(plant, lower)
    elif bounds.lower != -math.inf:
        witness = _smallest_gain(plant, Fraction(bounds.lower))
    else:
        witness = _some_gain(asked)
    if witness is None or not bounds.lower <= witness.k <= bounds.upper:
        return None
    return check_for_class(asked, refutation_draft(plant, witness, asked.class_entry, numbers=numbers))


def _of_one_plant(
    asked: Problem, search: Callable[[Problem, Numbers], Proved | Refuted | Failure | None], numbers: Numbers
) -> Proved | Refuted | Failure | None:
    """What a search refutes of the plant of a box at which the stable linear gains end first."""
    if asked.nonlinearity_class.sector.lower == -math.inf:
        return None
    one, point = _at_worst(asked)
    found = search(one, numbers)
    if not isinstance(found, Refuted):
        return found
    assert isinstance(asked.plant, PlantFamily)
    return check_for_class(asked, families.member_draft(asked.plant, point, found.certificate))


def _some_gain(asked: Problem) -> Witness | None:
    """Some gain that is not stable, of a sector without a lower end."""
    from lure.analysis.counterexamples.linear import linear_witness

    plant = asked.plant
    gain = unstable_gain(plant, asked.nonlinearity_class.sector) if isinstance(plant, RationalPlant) else None
    if not isinstance(gain, Fraction) or not isinstance(plant, RationalPlant):
        return None
    found = linear_witness(plant, lower=gain)
    return None if found is None else replace(found, data={"gain": str(gain), "lower": str(gain - 1)})


# Other nonlinearities: orbits and switched gains.


def _nonlinearities(asked: Problem) -> tuple[Witness, ...]:
    """Destabilising members of the class that are no constant gains, smallest class first."""
    from lure.analysis.counterexamples.search import refute

    if isinstance(asked.plant, DelayPlant) and asked.time_varying and asked.lower == 0:
        from lure.analysis.certificates.refutations import accepted_witness
        from lure.analysis.counterexamples.late_switching import late_witness

        most = hurwitz(Problem.largest(asked.plant, "sector", lower=Fraction(0))).high
        tried = (accepted_witness(asked.plant, witness) for witness in late_witness(asked.plant, most))
        return tuple(islice((witness for witness in tried if witness.refutation is not None), 1))
    if not isinstance(asked.plant, RationalPlant):
        return ()
    kind = {"slope": asked.question == "slope", "odd": asked.odd, "time_varying": asked.time_varying}
    found = refute(asked.plant, lower=asked.lower, **kind)
    return tuple(witness for witness in found if witness.kind != "linear gain")


def nonlinear_witnesses(asked: Problem) -> list[Witness]:
    """Other destabilising members of the classes asked about, with more than a simulation behind them.

    ``asked``: of the largest class.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.refutations import accepted_witness

    if isinstance(asked.plant, PlantFamily):
        one, point = _at_worst(asked)
        return [families.refuted_at(asked.plant, point, witness) for witness in nonlinear_witnesses(one)]
    found = guarded("refute", lambda: _nonlinearities(asked), passing=(*EXPECTED, TimeoutError))
    if isinstance(found, Failure):
        return []
    shown = [witness for witness in found if witness.evidence > Evidence.OBSERVED]
    return [one if one.refutation is not None else accepted_witness(asked.plant, one) for one in shown]


def counterexample(asked: Problem, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A nonlinearity of the class, not a constant gain, that destabilises; ``numbers``: where the numbers came from.

    Returns
    -------
    Refuted, Failure or None
        A failure where one was found that could not be proved; None where none was found.
    """
    from lure.analysis.certificates.arithmetic import Rejected
    from lure.analysis.certificates.refutations import refutation_draft

    plant, bounds = asked.plant, asked.nonlinearity_class.slope or asked.nonlinearity_class.sector
    if isinstance(plant, PlantFamily):
        return _of_one_plant(asked, counterexample, numbers)
    if not isinstance(plant, RationalPlant | DelayPlant) or bounds.lower == -math.inf:
        return None
    last: Failure | None = None
    for witness in _nonlinearities(asked):
        code, reason = codes.UNPROVED_ORBIT, str(witness)
        if witness.evidence is Evidence.CERTIFIED:
            try:
                return check_for_class(asked, refutation_draft(plant, witness, asked.class_entry, numbers=numbers))
            except (Rejected, AssumptionError) as refusal:  # beyond the class, as often as not
                code, reason = codes.REJECTED, str(refusal)
        if witness.k <= bounds.upper:
            last = Failure(search="counterexamples", code=code, detail=reason)
    return last

"""The searches for a law of a class that destabilises, put before the checker."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import TYPE_CHECKING

from lure.analysis.certificates import codes
from lure.analysis.certificates.sealing import Failure, check_for_class, guarded
from lure.analysis.certificates.theory import theory_of
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.gains import hurwitz_limit, is_stable_gain, unstable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_above, double_below, short
from lure.analysis.numerics.precision import ball, outward
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.proofs import EXPECTED
from lure.analysis.verdict import Bracket, Evidence, Witness
from lure.errors import AssumptionError
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.proposals import Numbers

# Linear gains: members of every class.


def hurwitz(asked: Problem) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``[lower, k]`` is stable (in the critical case: but 0)."""
    plant, lower = asked.plant, asked.lower
    if isinstance(plant, RationalPlant):
        if TransferPolynomials.of(plant).shifted(lower).case == "unstable":  # lower itself, a member of every class
            return outward(ball(lower), ball(lower))
        return hurwitz_limit(plant, lower)
    if isinstance(plant, StateSpace):
        witness = growing_gain(plant, lower)
        return Bracket(double_below(lower), math.inf if witness is None else witness.k)
    if lower != 0:
        raise AssumptionError(
            f"for a {type(plant).__name__} the classes begin at 0; got lower = {float(lower):g}: close a loop with "
            "that gain in the model first"
        )
    if isinstance(plant, DelayPlant):
        from lure.analysis.theorems.dead_time import hurwitz_limit as with_dead_time

        return with_dead_time(plant)
    return theory_of(plant).hurwitz() if isinstance(plant, StructuredPlant) else Bracket(0.0, math.inf)


def critical(asked: Problem) -> bool:
    """Whether the loop with the gain ``lower`` has a pole at 0 (``z = 1``): laws of the class add equilibria."""
    plant = asked.plant
    if isinstance(plant, RationalPlant):
        return TransferPolynomials.of(plant).shifted(asked.lower).case == "critical"
    if isinstance(plant, DelayPlant):
        return plant.denominator[-1] == 0
    return isinstance(plant, StructuredPlant) and theory_of(plant).critical


def linear_witnesses(asked: Problem, limit: Bracket) -> list[Witness]:
    """The smallest destabilising linear gain of the classes asked about, if there is one, with what was accepted of it.

    Parameters
    ----------
    asked : Problem
        Of the largest class.
    limit : Bracket
        From :func:`hurwitz`.
    """
    found = _smallest_gain(asked.plant, asked.lower, limit)
    return [] if found is None else [accepted_witness(asked, found)]


def _smallest_gain(plant: object, lower: Fraction, limit: Bracket | None = None) -> Witness | None:
    """The smallest gain from ``lower`` on that destabilises, as far as there is a way to find it for such a plant."""
    from lure.analysis.counterexamples.linear import linear_witness

    if isinstance(plant, RationalPlant):
        return linear_witness(plant, lower=lower)
    if isinstance(plant, StateSpace):
        return growing_gain(plant, lower)
    if not isinstance(plant, DelayPlant):
        return None
    limit = hurwitz(Problem.largest(plant, "sector", lower=Fraction(0))) if limit is None else limit
    return _dead_time_gain(plant, limit) if limit.high < math.inf else None


def _dead_time_gain(plant: DelayPlant, limit: Bracket) -> Witness:
    return Witness(
        kind="linear gain",
        k=limit.high,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"a linear gain of about {limit.middle:.9g} puts a root on the imaginary axis, so that the loop "
        "does not come to rest",
        data={"gain": [limit.low, limit.high], "block": str(plant)},
    )


@lru_cache(maxsize=4)
def growing_gain(block: StateSpace, lower: Fraction) -> Witness | None:
    """The smallest linear gain for which the checker accepts that a solution grows; None where none is found.

    Parameters
    ----------
    block : StateSpace
        The plant.
    lower : Fraction
        Least gain.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    found = guarded("linear gains", partial(_growing, block, lower), passing=(*EXPECTED, TimeoutError))
    return None if isinstance(found, Failure) else found


def _growing(block: StateSpace, lower: Fraction) -> Witness | None:
    from lure.analysis.counterexamples.linear import growing_gains

    for witness in growing_gains(block, lower=lower):
        checkpoint()
        found = _accepted(block, witness)
        if found is not None:
            return replace(witness, refutation=found)
    return None


def linear_refutation(asked: Problem, numbers: Numbers) -> Proved | Refuted | None:
    """A constant gain of the class with which the loop does not come to rest; or what the plant's structure refutes.

    Parameters
    ----------
    asked : Problem
        About one class.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted or None
        None if every gain is stable, or the plant has none that is looked at.
    """
    from lure.analysis.certificates.refutations import refutation_draft

    plant, sector = asked.plant, asked.law_class.sector
    if isinstance(plant, StructuredPlant):
        draft = theory_of(plant).refutation()
        return None if draft is None else check_for_class(asked, {**draft, "numbers": numbers})
    if not isinstance(plant, RationalPlant | DelayPlant | StateSpace):
        return None
    bounds = asked.law_class.slope or sector if isinstance(plant, StateSpace) else sector
    if isinstance(plant, DelayPlant):
        witness = _smallest_gain(plant, Fraction(0))
    elif bounds.lower != -math.inf:
        witness = _smallest_gain(plant, Fraction(bounds.lower))
    else:
        witness = _some_gain(asked)
    if witness is None or not bounds.lower <= witness.k <= bounds.upper:
        return None
    return check_for_class(asked, refutation_draft(plant, witness, asked.laws, numbers=numbers))


def _some_gain(asked: Problem) -> Witness | None:
    """Some gain that is not stable, of a sector without a lower end."""
    from lure.analysis.counterexamples.linear import linear_witness

    plant = asked.plant
    gain = unstable_gain(plant, asked.law_class.sector) if isinstance(plant, RationalPlant) else None
    if not isinstance(gain, Fraction) or not isinstance(plant, RationalPlant):
        return None
    found = linear_witness(plant, lower=gain)
    return None if found is None else replace(found, data={"gain": str(gain), "lower": str(gain - 1)})


# Other laws: orbits and switched gains.


def _laws(asked: Problem) -> tuple[Witness, ...]:
    """Destabilising members of the class that are no constant gains, smallest class first."""
    from lure.analysis.counterexamples.search import refute

    if not isinstance(asked.plant, RationalPlant):
        return ()
    kind = {"slope": asked.question == "slope", "odd": asked.odd, "time_varying": asked.time_varying}
    found = refute(asked.plant, lower=asked.lower, **kind)
    return tuple(witness for witness in found if witness.kind != "linear gain")


def nonlinear_witnesses(asked: Problem) -> list[Witness]:
    """Other destabilising members of the classes asked about, with more than a simulation behind them.

    Parameters
    ----------
    asked : Problem
        Of the largest class.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    found = guarded("refute", lambda: _laws(asked), passing=(*EXPECTED, TimeoutError))
    if isinstance(found, Failure):
        return []
    return [accepted_witness(asked, witness) for witness in found if witness.evidence > Evidence.OBSERVED]


def counterexample(asked: Problem, numbers: Numbers) -> Proved | Refuted | Failure | None:
    """A law of the class, not a constant gain, that destabilises.

    Parameters
    ----------
    asked : Problem
        About one class.
    numbers : str
        Where the numbers came from.

    Returns
    -------
    Refuted, Failure or None
        A failure where one was found that could not be proved; None where none was found.
    """
    from lure.analysis.certificates.arithmetic import Rejected
    from lure.analysis.certificates.refutations import refutation_draft

    plant, bounds = asked.plant, asked.law_class.slope or asked.law_class.sector
    if not isinstance(plant, RationalPlant) or bounds.lower == -math.inf:
        return None
    last: Failure | None = None
    for witness in _laws(asked):
        code, reason = codes.UNPROVED_ORBIT, str(witness)
        if witness.evidence is Evidence.CERTIFIED:
            try:
                return check_for_class(asked, refutation_draft(plant, witness, asked.laws, numbers=numbers))
            except (Rejected, AssumptionError) as refusal:  # beyond the class, as often as not
                code, reason = codes.REJECTED, str(refusal)
        if witness.k <= bounds.upper:
            last = Failure(search="counterexamples", code=code, detail=reason)
    return last


# Before the checker.


def accepted_witness(asked: Problem, witness: Witness) -> Witness:
    """The witness with what the checker accepted of it; COMPUTED where it accepted nothing.

    Parameters
    ----------
    asked : Problem
        The problem.
    witness : Witness
        A destabilising member.
    """
    plant = asked.plant
    if witness.evidence is not Evidence.CERTIFIED or not isinstance(plant, RationalPlant | DelayPlant):
        return witness
    for candidate in (witness, *_just_above(plant, witness)):
        found = _accepted(plant, candidate)
        if found is not None:
            return _as_accepted(candidate, found)
    return replace(witness, evidence=Evidence.COMPUTED)


def _accepted(plant: RationalPlant | DelayPlant | StateSpace, witness: Witness) -> Refuted | None:
    """What the checker accepts of the smallest class of a witness."""
    from lure.analysis.certificates.checker import Refuted

    found = guarded(witness.kind, partial(_settled, plant, witness), passing=(TimeoutError,))
    return found if isinstance(found, Refuted) else None


def _settled(plant: RationalPlant | DelayPlant | StateSpace, witness: Witness) -> Proved | Refuted:
    from lure.analysis.certificates.refutations import refutation_draft
    from lure.analysis.certificates.sealing import settled

    numbers: Numbers = "doubles, exactly" if isinstance(plant, StateSpace) else "rationals"
    return settled(refutation_draft(plant, witness, numbers=numbers))


def _as_accepted(witness: Witness, found: Refuted) -> Witness:
    """The witness with the gain of its certificate: a larger one where the gain at a critical end refutes nothing."""
    gain = found.certificate["proof"].get("gain")
    if gain is None or gain == witness.data.get("gain"):
        return replace(witness, refutation=found)
    return replace(
        witness,
        k=double_above(Fraction(gain)),
        description=f"phi = {short(Fraction(gain))} sigma: the loop is not asymptotically stable",
        data={**witness.data, "gain": gain},
        refutation=found,
    )


def _just_above(plant: RationalPlant | DelayPlant, witness: Witness) -> Iterator[Witness]:
    """Gains just above a linear one that only makes other equilibria: at the end of a class they refute nothing."""
    if witness.kind != "linear gain" or not isinstance(witness.data.get("gain"), str):
        return
    gain = Fraction(str(witness.data["gain"]))
    for exponent in (40, 30, 20):
        above = gain + max(abs(gain), Fraction(1, 2**exponent)) / 2**exponent
        if isinstance(plant, RationalPlant) and not is_stable_gain(plant, above):
            yield replace(
                witness,
                k=double_above(above),
                description=f"phi = k sigma, k just above {short(gain)}: the loop is not asymptotically stable",
                data={**witness.data, "gain": str(above)},
            )

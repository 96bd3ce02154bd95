"""Hurwitz sector, circle and Popov criteria for blocks with dead time, as answers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from lure.analysis.inequality.delay import DelayResponse, gain_limit, popov_infimum
from lure.analysis.numerics.minimum import Minimum
from lure.analysis.numerics.polynomial import root_sizes
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant

BITS = 128
STEPS = 48
_POPOV = (
    "Popov's criterion for a convolution kernel in L1, or an integrator besides (C. A. Desoer and M. Vidyasagar, "
    "Feedback Systems: Input-Output Properties, 1975, ch. VI)"
)
_CIRCLE = (
    "circle criterion for a convolution kernel in L1 (C. A. Desoer and M. Vidyasagar, Feedback Systems: Input-Output "
    "Properties, 1975, ch. V)"
)
_NYQUIST = "Nyquist's criterion for a retarded equation"


@dataclass(frozen=True, slots=True)
class Delayed:
    """A block with dead time, its response, and a frequency beyond its features."""

    block: DelayPlant
    response: DelayResponse
    start: float

    @classmethod
    def of(cls, block: DelayPlant) -> Delayed:
        """The plant of a block.

        Raises
        ------
        AssumptionError
            The block is not covered (see :class:`DelayResponse`), or its residue at 0 is not positive.
        """
        with working_precision(BITS):
            response = DelayResponse.of(block)
            if response.critical and not response.residue > 0:
                raise AssumptionError(
                    f"the block {block} has the residue {float(response.residue):.6g} at its pole 0: not positive, so "
                    "that small gains destabilise; turn the sign of the feedback",
                    code=Reason.RESIDUE,
                )
            features = [1 / float(delay) for delay, _ in block.terms if delay > 0]
            for p in (response.bottom, *(term.top for term in response.terms)):
                features += root_sizes(p)
            return cls(block, response, 8 * max([1e-3, *features]))


def hurwitz_limit(block: DelayPlant) -> Bracket:
    """Supremum of the ``k`` such that every linear gain in ``(0, k]`` is stable, bracketed.

    Parameters
    ----------
    block : DelayPlant
        The block.
    """
    plant = Delayed.of(block)
    with working_precision(BITS):
        return gain_limit(plant.block, plant.response, plant.start)


def hurwitz_largest(block: DelayPlant) -> Answer:
    """The answer of linear gains alone; it proves nothing about nonlinearities.

    Parameters
    ----------
    block : DelayPlant
        The block.
    """
    limit = hurwitz_limit(block)
    return Answer(
        criterion="hurwitz",
        theorem=_NYQUIST,
        largest=limit,
        nonlinearity_class=NonlinearityClass(sector=Sector(0, limit.low if limit.low > 0 else math.inf)),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        reason="stability of every linear gain in a sector does not prove that of its nonlinearities",
    )


def circle_largest(block: DelayPlant) -> Answer:
    r"""Largest ``k`` with ``1/k + Re H(i omega) > 0`` on ``[0, inf]``, certified over all frequencies.

    Parameters
    ----------
    block : DelayPlant
        The block, stable: with a pole at 0 the theorem used does not cover time-varying nonlinearities.

    Raises
    ------
    AssumptionError
        The block is not covered.
    """
    plant = Delayed.of(block)
    if plant.response.critical:
        raise AssumptionError(
            f"the block {block} has a pole at 0, where the circle criterion for dead time is not used; ask popov",
            code=Reason.DEAD_TIME,
        )
    with working_precision(BITS):
        found = popov_infimum(plant.response, arb(0), plant.start)
        return _answer("circle", plant, Fraction(0), found, found.high)


def popov_largest(block: DelayPlant) -> Answer:
    r"""Largest ``k`` with ``1/k + Re[(1 + i omega theta) H(i omega)] > 0`` on ``[0, inf]`` for some ``theta >= 0``.

    The infimum over frequency is concave in ``theta``; its maximum is enclosed between two multipliers whose worst
    frequencies pull to opposite sides, and the two together bound what any multiplier can reach.

    Parameters
    ----------
    block : DelayPlant
        The block: stable, or with a simple pole at 0 of positive residue besides.

    Raises
    ------
    AssumptionError
        The block is not covered.
    """
    plant = Delayed.of(block)
    with working_precision(BITS):
        theta, ceiling = _best_multiplier(plant)
        found = popov_infimum(plant.response, ball(theta), plant.start)
        return _answer("popov", plant, theta, found, ceiling)


def _best_multiplier(plant: Delayed) -> tuple[Fraction, arb]:
    """A nearly best ``theta >= 0``, and an upper bound on the infimum for every ``theta >= 0``."""

    def worst(theta: Fraction) -> tuple[arb, arb, arb]:
        """Lower bound of the infimum for one multiplier, and both parts where it is attained."""
        found = popov_infimum(plant.response, ball(theta), plant.start)
        real, slope = plant.response.parts(found.where)
        return found.low, real, slope

    low, left_real, left_slope = worst(Fraction(0))
    if not left_slope > 0:
        return Fraction(0), left_real.upper() if left_slope <= 0 else arb("inf")
    right = Fraction(1) / Fraction(plant.start)
    right_low, right_real, right_slope = worst(right)
    for _ in range(40):
        if not right_slope > 0:
            break
        left_real, left_slope = right_real, right_slope
        right *= 4
        right_low, right_real, right_slope = worst(right)
    best = (low, Fraction(0)) if low > right_low else (right_low, right)
    left = Fraction(0)
    for _ in range(STEPS):
        middle = (left + right) / 2
        value, real, slope = worst(middle)
        if value > best[0]:
            best = (value, middle)
        if slope > 0:
            left, left_real, left_slope = middle, real, slope
        elif slope < 0:
            right, right_real, right_slope = middle, real, slope
        else:
            break
    if not (left_slope > 0 and right_slope < 0):
        return best[1], arb("inf")
    ceiling = (left_real * -right_slope + right_real * left_slope) / (left_slope - right_slope)
    return best[1], ceiling.upper()


def _answer(name: str, plant: Delayed, theta: Fraction, found: Minimum, ceiling: arb) -> Answer:
    limit = gain_limit(plant.block, plant.response, plant.start)
    reach = outward(_reach(found.low, arb(0)), _reach(ceiling, arb("inf")))
    low = max(0.0, min(math.nextafter(reach.low, 0), math.nextafter(limit.low, 0)))
    high = max(low, min(reach.high, limit.high))
    varying = name == "circle"
    proved = low > 0
    conclusion = (
        "every motion converges to the stationary set"
        if plant.response.critical
        else "0 is globally attractive for inputs to the block and initial functions of finite energy"
    )
    return Answer(
        criterion=name,
        theorem=_CIRCLE if varying else _POPOV,
        largest=Bracket(low, high),
        nonlinearity_class=NonlinearityClass(sector=Sector(0, low if proved else math.inf), time_varying=varying),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=() if varying else ("time-invariant",),
        theta=None if varying else float(theta),
        multiplier=None if varying else f"1 + {float(theta):.6g} s",
        parameters={} if varying else {"theta": str(theta)},
        worst_frequency=float(found.where),
        hypotheses=(
            "poles: counted exactly; every term with dead time strictly proper: checked",
            "inequality on [0, inf]: branch and bound in ball arithmetic, and a bound on the tail",
            f"phi {'' if varying else 'time-invariant, '}continuous, in the sector: assumed of the class",
        ),
        reason=f"{conclusion}, for every member" if proved else "the inequality fails for every sector tried",
    )


def _reach(infimum: arb, unknown: arb) -> arb:
    if infimum >= 0:
        return arb("inf")
    return -1 / infimum if infimum < 0 else unknown

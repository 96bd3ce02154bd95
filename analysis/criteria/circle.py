"""The circle criterion for a rational block, exact: every sign case of the sector, unstable and critical blocks too."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

from flint import arb

from analysis.answer import Answer
from analysis.criteria.checks import check_plant, require_well_posed
from analysis.criteria.circle_words import CircleCase, circle_answer, failure
from analysis.criteria.gain_ends import GainEnd
from analysis.criteria.hurwitz import unstable_gain
from analysis.doubles import double_below
from analysis.evidence import INFINITE, Bracket, Verdict
from analysis.extremum import Infimum, infimum, largest_below, positive_with_limits
from analysis.plant import Plant, Response
from analysis.polynomial import to_fmpq
from analysis.precision import ball, outward, working_precision
from lure.errors import AssumptionError
from lure.rational import RationalBlock
from lure.sector import Sector

BITS = 128


def circle_largest(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""The largest ``k`` for which the circle criterion covers the sector ``[lower, k]``, as an algebraic number.

    With ``P = H/(1 + lower H)`` the criterion reads ``1/(k - lower) + Re P(i w) > 0`` on ``[0, inf]``, so that
    ``k - lower = -1/inf Re P`` is the supremum, or every finite ``k`` where ``Re P >= 0``.

    Parameters
    ----------
    block : RationalBlock
        The block ``sigma = H mu``, ``mu = -phi(t, sigma)``, in continuous or discrete time.
    lower : Fraction
        Lower end of the sector, of either sign; for an unstable block a gain at which the loop is stable.

    Returns
    -------
    Answer
        ``largest``: at ``low`` the inequality was tested exactly, at every frequency, apart from how it was found;
        ``high`` bounds the supremum to a relative width of 1e-10 in ``k - lower``.

    Raises
    ------
    InputError, AssumptionError
        As :func:`analysis.criteria.checks.check_plant`.

    Notes
    -----
    Principal case: global exponential stability of 0, uniform over the class, for time-varying ``phi`` (piecewise
    continuous in ``t``).  Critical case: for time-invariant, locally Lipschitz ``phi`` every solution is bounded and
    converges to the stationary set ``{phi = 0}``, which is more than one point where ``phi`` vanishes elsewhere; for
    time-varying ``phi`` boundedness alone.  Above ``largest.high`` nothing follows about the loop.

    Examples
    --------
    Re H = (1 - x)/((1 - x)^2 + x), x = w^2, is least at x = 2 and equals -1/3 there.

    >>> print(f"{circle_largest(RationalBlock([1], [1, 1, 1])).largest.low:.12g}")
    3
    """
    lower = Fraction(lower)
    plant = check_plant(block, lower=lower)
    response = plant.response()
    found = infimum(response.U, response.D)
    reach = _reach(response, found, lower)
    spr = _holds(plant, response, math.inf)
    if reach.low > lower:
        return circle_answer(CircleCase(block, plant, Sector(lower, reach.low), found, spr), reach, Verdict.PROVED)
    return circle_answer(CircleCase(block, plant, Sector(lower, math.inf), found, spr), reach, Verdict.INCONCLUSIVE)


def circle_criterion(block: RationalBlock, sector: Sector) -> Answer:
    r"""The circle criterion for one sector ``[k1, k2]``, certified over all frequencies.

    The loop is shifted by ``k1`` to ``P = H/(1 + k1 H)``, exactly, and the criterion reads
    ``1/(k2 - k1) + Re P(i w) > 0`` on ``[0, inf]``; for ``k2 = inf``, ``P`` strictly positive real.  It is the
    classical one: the Nyquist plot of ``H`` stays clear of the disc on ``[-1/k1, -1/k2]`` and encircles it as often as
    ``H`` has unstable poles (``0 < k1``), stays right of ``-1/k2`` (``k1 = 0``) or inside the disc (``k1 < 0 < k2``).

    Parameters
    ----------
    block : RationalBlock
        The block ``sigma = H mu``, ``mu = -phi(t, sigma)``, in continuous or discrete time.
    sector : Sector
        Both ends of any sign; one may be infinite.

    Returns
    -------
    Answer
        ``margin`` brackets the infimum of the left-hand side.  REFUTED where a linear gain of the sector is not
        stable, INCONCLUSIVE where the inequality fails and none is known.

    Raises
    ------
    InputError
        ``1 + kappa H(inf)`` vanishes for a gain of the sector.
    AssumptionError
        Both ends are infinite, or the loop at ``k1`` is not admitted by
        :func:`analysis.criteria.checks.check_plant`.

    Notes
    -----
    Conclusions as for :func:`circle_largest`.  A sector ``[k1, k2]`` of ``H`` is the sector ``[-k2, -k1]`` of ``-H``:
    that is used for ``k1 = -inf`` and where the loop is critical at ``k2``.

    Examples
    --------
    >>> print(circle_criterion(RationalBlock([12], [1, 2, -3]), Sector(1, 2)).verdict)
    PROVED
    """
    if sector.lower == -math.inf and sector.upper == math.inf:
        raise AssumptionError("the circle criterion needs a sector with a finite end; got [-inf, inf]")
    mirrored = _mirror_needed(block, sector)
    used, lower, upper = block, sector.lower, sector.upper
    if mirrored:
        used = RationalBlock([-c for c in block.numerator], block.denominator, block.dt)
        lower, upper = -sector.upper, -sector.lower
    lower = Fraction(lower)
    require_well_posed(used, upper, lower=lower)
    plant = check_plant(used, lower=lower)
    response = plant.response()
    found = infimum(response.U, response.D)
    reach = _reach(response, found, lower)
    gain = None
    if _holds(plant, response, upper - lower):
        verdict = Verdict.PROVED
    else:
        gain = unstable_gain(used, Sector(lower, upper))
        verdict = Verdict.INCONCLUSIVE if gain is None else Verdict.REFUTED
    if mirrored:
        reach = Bracket(double_below(Fraction(sector.upper)) if verdict is Verdict.PROVED else -math.inf, math.inf)
    case = CircleCase(block, plant, sector, found, _holds(plant, response, math.inf))
    answer = circle_answer(case, reach, verdict)
    margin = _margin(found, upper - lower, holds=verdict is Verdict.PROVED)
    if verdict is Verdict.PROVED:
        return replace(answer, margin=margin)
    linear = None if gain is None else _linear_gain(gain, mirrored=mirrored)
    reason = failure(case, margin, None if mirrored else reach, linear)
    witness = None if linear is None else f"phi = {linear} sigma"
    return replace(answer, margin=margin, reason=reason, witness=witness)


def _mirror_needed(block: RationalBlock, sector: Sector) -> bool:
    if sector.lower == -math.inf:
        return True
    return sector.upper != math.inf and Plant.of(block).shifted(Fraction(sector.upper)).case == "critical"


def _reach(response: Response, found: Infimum, lower: Fraction) -> Bracket:
    """The largest ``k``: ``low`` tested exactly, or at most ``lower`` if the criterion reaches no double above that."""
    if found.low >= 0:
        return INFINITE
    with working_precision(BITS):
        guess = outward(ball(lower) - 1 / found.low, ball(lower) - 1 / found.high)
        low = largest_below(response.D, response.U, guess.low, lower)
        return Bracket(outward(ball(lower), ball(lower)).low if low is None else low, guess.high)


def _holds(plant: Plant, response: Response, width: Fraction | float) -> bool:
    """Whether ``1/width + Re P > 0`` on ``[0, inf]``; for an infinite width, ``P`` strictly positive real."""
    D, U = response.D, response.U
    if width != math.inf:
        return positive_with_limits(D + to_fmpq(width) * U, D.degree())
    if plant.hidden.degree() > 0:  # the proof without an upper bound needs a minimal realisation
        return False
    # Re P > 0 at every frequency, and w^2 Re P has a positive limit (in discrete time Re P itself)
    return positive_with_limits(U, U.degree()) and D.degree() - U.degree() <= (0 if plant.discrete else 1)


def _margin(found: Infimum, width: Fraction | float, *, holds: bool) -> Bracket:
    """The infimum of ``1/width + Re P``, its sign that of the exact test."""
    with working_precision(BITS):
        ease = arb(0) if width == math.inf else 1 / ball(width)
        margin = outward(found.low + ease, found.high + ease)
    return Bracket(max(margin.low, 0.0), margin.high) if holds else Bracket(margin.low, min(margin.high, 0.0))


def _linear_gain(gain: Fraction | GainEnd, *, mirrored: bool) -> str:
    sign = -1 if mirrored else 1
    return f"{sign * gain.value.middle:.10g}" if isinstance(gain, GainEnd) else f"{sign * gain}"

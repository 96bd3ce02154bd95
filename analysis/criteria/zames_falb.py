"""Zames and Falb's criterion in continuous time, with the Popov term, for slope-restricted laws: certified."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType
from typing import Literal

from analysis.answer import Answer
from analysis.criteria.checks import check_plant
from analysis.criteria.hurwitz import hurwitz_limit
from analysis.criteria.kernel_certificate import margin_near
from analysis.criteria.kernel_reach import Reach, Task, every, least_sample, propose_at, proved, reach
from analysis.criteria.kernels import multiplier_of
from analysis.doubles import text_below
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.precision import ball, outward
from lure.errors import AssumptionError, InputError
from lure.exact import exact_number
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import SlopeBounds

Effort = Literal["quick", "full"]
NAME = "zames-falb"
THEOREM = (
    "Zames-Falb multipliers with a Popov term (G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108; U. Jonsson, "
    "Systems & Control Letters 31 (1997) 85-92; J. Carrasco, M. C. Turner and W. P. Heath, European J. Control 28 "
    "(2016) 1-19)"
)


def zames_falb_largest(
    block: RationalBlock, *, odd: bool, lower: Fraction = Fraction(0), effort: Effort = "quick"
) -> Answer:
    r"""Largest slope that a Zames-Falb multiplier with a Popov term proves, in continuous time.

    For ``sigma = H mu``, ``mu = -phi(sigma)`` with ``H`` stable, ``1 + k H(inf) > 0`` and ``phi`` time-invariant,
    ``phi(0) = 0``, with slope in ``[0, k]``, the origin is globally asymptotically stable if for some ``eps > 0`` and
    every real ``w``

    .. math:: \mathrm{Re}\,[M(i w)\,(H(i w) + 1/k) + i w \theta\, H(i w)] \ge \varepsilon, \\
        M(i w) = 1 - \sum_j c_j\, \hat h_j(i w), \qquad \sum_j |c_j| \le 1,

    with kernels ``h_j >= 0`` of mass 1 (delays of either sign, gamma densities on either side) and ``theta`` of either
    sign.  All ``c_j >= 0``, unless ``phi`` is odd: then they may have either sign.  Without ``h`` this is Popov's
    criterion, without ``theta`` as well the circle criterion.

    Parameters
    ----------
    block : RationalBlock
        In continuous time; with the gain ``lower`` it is strictly stable, hidden modes included.
    odd : bool
        Whether ``phi`` is known to be odd.  An answer for odd laws says nothing about others.
    lower : Fraction
        Lower slope: the class ``[lower, k]`` is that of ``[0, k - lower]`` for ``H / (1 + lower H)``.
    effort : {"quick", "full"}
        Time to spend on the search: a few seconds, or up to a minute.  The proof is the same.

    Returns
    -------
    Answer
        ``largest.low`` is certified, up to itself; ``parameters`` are exact and suffice for :func:`recheck`.
        That a larger slope is not reached means neither that the loop is unstable nor that no multiplier does it.

    Raises
    ------
    InputError
        The block is in discrete time, or not well posed at ``lower``.
    AssumptionError
        The block is not strictly stable with the gain ``lower``.

    Notes
    -----
    Why it holds.  Let ``v = phi(sigma)`` and ``e = sigma - v/k``: both are nondecreasing functions of ``sigma``, and
    ``P = int phi d(e)`` satisfies ``P(a) - P(b) <= v(a) (e(a) - e(b))``; hence, for signals in L2, the integral of
    ``v(t) e(t - tau)`` is at most that of ``v e`` for every ``tau`` of either sign, and for odd ``phi`` at least its
    negative.  Summed with weights of total at most 1 (point masses are as good as densities) this gives
    ``int v (M e) dt >= 0``.  The integral of ``v dsigma/dt`` is a difference of two values of ``int phi d(sigma)``:
    zero but for the initial state, so that ``theta`` may have either sign.  With ``v = -mu``, ``e = (H + 1/k) mu`` the
    inequality above bounds the energy of ``mu`` by the initial state.  That signals are in L2 follows by continuation
    from ``phi`` replaced by ``t phi``, ``0 <= t <= 1``, for which everything holds alike; it needs ``H`` stable, and
    ``dsigma/dt`` in L2, hence ``H`` strictly proper.  A direct term ``D`` is moved into the law first:
    ``phi (1 + D phi)^-1`` has slope in ``[0, k']``, ``1/k' = 1/k + D``, if ``1 + k D > 0``, and the inequality is the
    same, since ``i w theta D`` has no real part.

    The multiplier comes from linear programmes in floating point; whether it satisfies the inequality is then decided
    for all frequencies, by ``analysis.criteria.kernel_certificate``.

    Examples
    --------
    >>> block = RationalBlock([1, Fraction("-0.2"), Fraction("-0.1")], [1, 2, 1, 1])
    >>> f"{zames_falb_largest(block, odd=False).largest.low:.5f}"
    '4.58945'
    """
    task = _task(block, exact_number(lower, "lower"), odd=odd, full=effort == "full")
    found = reach(task)
    if found is None:
        return _answer(task, SlopeBounds(task.lower, math.inf), None, "no multiplier found proves any slope")
    if found.k is None:
        limit = found.multiplier.mass == 1 and all(c > 0 for c, _ in found.multiplier.terms)
        how = "coefficients as close to these as k asks for" if limit else "one multiplier"
        reason = f"every finite slope is proved, with {how}; the inequality was decided exactly"
        return _answer(task, SlopeBounds(task.lower, math.inf), found, reason)
    reason = f"slopes up to {text_below(float(found.k))} are proved; the inequality was decided at every frequency"
    return _answer(task, SlopeBounds(task.lower, found.k), found, reason)


def zames_falb_criterion(block: RationalBlock, bounds: SlopeBounds, *, odd: bool, effort: Effort = "quick") -> Answer:
    r"""Whether a Zames-Falb multiplier with a Popov term proves one class of slopes, in continuous time.

    The theorem is that of :func:`zames_falb_largest`.

    Parameters
    ----------
    block : RationalBlock
        In continuous time; with the gain ``bounds.lower`` it is strictly stable, hidden modes included.
    bounds : SlopeBounds
        Bounds on the slope of ``phi``; ``upper = inf`` asks about all finite slopes at once.
    odd : bool
        Whether ``phi`` is known to be odd.
    effort : {"quick", "full"}
        Time to spend on the search.

    Returns
    -------
    Answer
        PROVED with a ``margin``, or INCONCLUSIVE: no multiplier was found, which means neither that the loop is
        unstable nor that there is none.

    Raises
    ------
    InputError
        The block is in discrete time, or not well posed at ``bounds.lower``.
    AssumptionError
        ``bounds.lower`` is infinite, or the block is not strictly stable with this gain.
    """
    if math.isinf(bounds.lower):
        raise AssumptionError(f"zames_falb_criterion needs a finite lower slope; got {bounds}: give a finite one")
    task = _task(block, Fraction(bounds.lower), odd=odd, full=effort == "full")
    if math.isinf(bounds.upper):
        found = reach(task)
        found = found if found is not None and found.k is None else None
    else:
        found = propose_at(task, Fraction(bounds.upper))
    if found is None:
        beyond = bounds.upper >= task.limit
        reason = (
            f"a linear gain up to {task.limit:.9g} in this class is not stable"
            if beyond and math.isfinite(task.limit)
            else f"no multiplier found proves slopes in {bounds}; try effort='full', or ask for the largest slope"
        )
        return _answer(task, bounds, None, reason)
    return _answer(task, bounds, found, "the inequality was decided at every frequency")


def recheck(block: RationalBlock, parameters: Mapping[str, object]) -> bool:
    r"""Verify a proof again from the block and the exact numbers alone, without any search.

    Parameters
    ----------
    block : RationalBlock
        The block of the answer.
    parameters : Mapping
        ``Answer.parameters`` of a proved answer: ``lower``, ``k``, ``odd``, ``theta`` and ``kernels``.

    Returns
    -------
    bool
        True proves that all laws with slope in ``[lower, k]`` (odd ones only if ``odd``) leave the origin globally
        asymptotically stable.  False: these numbers prove nothing.

    Raises
    ------
    InputError
        The parameters are not complete, or the block is in discrete time.
    AssumptionError
        The block is not strictly stable with the gain ``lower``.
    """
    multiplier = multiplier_of(parameters)
    try:
        lower, k, odd = Fraction(str(parameters["lower"])), str(parameters["k"]), parameters["odd"]
        width = None if k == "inf" else Fraction(k)
    except (KeyError, ValueError, ZeroDivisionError):
        raise InputError(f"parameters are {dict(parameters)!r}; give lower, k and odd besides the multiplier") from None
    task = _task(block, lower, odd=odd is True, full=False)
    return every(task, multiplier) is not None if width is None else proved(task, width, multiplier)


def _task(block: RationalBlock, lower: Fraction, *, odd: bool, full: bool) -> Task:
    if isinstance(block, RationalBlock) and block.dt is not None:
        raise InputError("zames_falb is for continuous time, the block is in discrete time; use zames_falb_discrete")
    plant = check_plant(block, lower=lower)
    if plant.case != "stable":
        raise AssumptionError(
            f"the block has a pole at s = 0 with the lower slope {float(lower):g}, and Zames-Falb multipliers need it "
            "strictly stable; give a larger lower slope, or ask Popov's criterion"
        )
    return Task(plant=plant, lower=lower, limit=hurwitz_limit(block, lower).low, odd=odd, full=full)


def _answer(task: Task, bounds: SlopeBounds, found: Reach | None, reason: str) -> Answer:
    lower, high = task.lower, hurwitz_limit(task.plant.block, task.lower).high
    blank = Answer(
        criterion=NAME,
        theorem=THEOREM,
        largest=Bracket(math.nextafter(float(lower), -math.inf), high),
        law_class=LawClass.slope_restricted(bounds.lower, bounds.upper, odd=task.odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "odd", "time-invariant") if task.odd else ("slope", "time-invariant"),
        hypotheses=_hypotheses(task),
        reason=reason,
    )
    if found is None:
        return blank
    margin, worst = None, None
    if found.k is not None:
        worst = least_sample(task.plant, found.k - lower, found.multiplier)
        margin = margin_near(task.plant, found.k - lower, found.multiplier, Fraction(worst))
    parameters = {
        "lower": str(lower),
        "k": "inf" if found.k is None else str(found.k),
        "odd": task.odd,
        **found.multiplier.to_parameters(),
    }
    low = math.inf if found.k is None else outward(ball(found.k), ball(found.k)).low
    return replace(
        blank,
        largest=Bracket(low, high),
        verdict=Verdict.PROVED,
        theta=float(found.multiplier.theta),
        multiplier=str(found.multiplier),
        parameters=MappingProxyType(parameters),
        margin=margin,
        worst_frequency=worst,
    )


def _hypotheses(task: Task) -> tuple[str, ...]:
    odd = " and odd" if task.odd else ""
    return (
        f"phi time-invariant{odd}, phi(0) = 0, slope in [{float(task.lower):g}, k]: assumed",
        "H strictly stable with the lower slope, hidden modes included: exact root count",
        "1 + k H(inf) > 0 over the class: below the exact Hurwitz limit",
        "sum of |c_j| at most 1, kernels nonnegative of mass 1: exact",
        "the inequality at every frequency and in the limit: polynomials exactly, delays by ball arithmetic",
    )

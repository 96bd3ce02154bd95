"""Discrete-time Zames-Falb multipliers of finite length: searched by linear programs, certified in exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from lure.analysis.inequality.checks import finite_bounds
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.unit_circle import DiscretePlant, largest_certified
from lure.analysis.numerics.doubles import double_below, text_above, text_below
from lure.analysis.numerics.trigonometric import least_on_circle
from lure.analysis.theorems.fir import (
    Multiplier,
    Proposal,
    SampledResponse,
    best_taps,
    certifies,
    certifies_every,
    evaluated,
    inequality,
)
from lure.analysis.theorems.phase_limit import lowest_phase_limit
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.arrays import np
from lure.classes import NonlinearityClass, SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant

NAME = "zames-falb"
THEOREM = (
    "Discrete-time Zames-Falb multipliers (J. C. Willems and R. W. Brockett, IEEE Trans. Automatic Control 13 (1968) "
    "539-549; finite length: J. Carrasco et al., IEEE Trans. Automatic Control 65 (2020) 4538-4553)"
)
LENGTHS = (2, 5, 10, 20, 40)
PERIODS = range(2, 21)
CLOSED = 5e-9
NEGLIGIBLE = 1e-12
DENOMINATORS = tuple(10**digits for digits in (2, 3, 4, 6, 8, 10, 12, 15))


def zames_falb_discrete_largest(
    block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0), taps: int | None = None
) -> Answer:
    r"""Largest slope that a discrete-time Zames-Falb multiplier of finite length proves.

    In ``sigma = H mu``, ``mu = -phi(sigma)``, ``phi`` time-invariant with ``phi(0) = 0`` and slope in ``[0, k]``, the
    origin is globally asymptotically stable if ``H`` is stable and for some ``M(z) = 1 - sum h_i z^-i``

    .. math:: \mathrm{Re}\,[M(z)\,(H(z) + 1/k)] > 0 \quad (|z| = 1), \qquad \sum_{i \ne 0} |h_i| < 1,

    with ``h_i >= 0``; for odd ``phi`` the ``h_i`` may have either sign.  The sum runs over both signs of ``i``: the
    multiplier need not be causal.  A lower slope other than zero is shifted into the block first.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    odd : bool
        Whether ``phi`` is known to be odd.  The answer for odd laws says nothing about others.
    lower : Fraction
        Lower slope.
    taps : int, optional
        Largest ``|i|``; by default lengths up to 40 are tried.

    Returns
    -------
    Answer
        ``largest.low`` is certified, up to itself; ``parameters`` hold the exact taps and ``k``.  At and above
        ``largest.high``, certified too, no Zames-Falb multiplier of any length satisfies the inequality; that does not
        mean that the loop is unstable there.

    Raises
    ------
    InputError
        The block is in continuous time, or ``taps`` is not a positive integer.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    The taps come from linear programs on sampled frequencies and are rounded to rationals; whether they satisfy the
    inequality is then decided for all frequencies by counting, exactly, the roots of a polynomial in ``cos w``.

    Examples
    --------
    >>> block = RationalPlant([Fraction(2), Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
    >>> round(zames_falb_discrete_largest(block, odd=False).largest.low, 6)
    0.911458
    """
    discrete = DiscretePlant.of(block, lower, "zames_falb_discrete_largest")
    if taps is not None and (isinstance(taps, bool) or not isinstance(taps, int) or taps < 1):
        raise InputError(f"zames_falb_discrete_largest: taps is {taps!r}; give a positive integer, or None")
    ceiling, why = _ceiling(block, discrete, odd=odd)
    multiplier, low = _reach(discrete, ceiling, odd=odd, taps=taps)
    if not low > lower:
        return replace(_blank(SlopeBounds(lower, math.inf), odd=odd), largest=Bracket(double_below(lower), ceiling))
    width = None if math.isinf(low) else Fraction(low) - lower
    margin, worst = _margin(discrete, multiplier, width)
    reach = "every finite slope" if width is None else f"slopes up to {text_below(low)}"
    return replace(
        _blank(SlopeBounds(lower, low), odd=odd),
        largest=Bracket(low, ceiling),
        verdict=Verdict.PROVED,
        multiplier=str(multiplier),
        parameters=_parameters(multiplier, None if width is None else Fraction(low)),
        margin=margin,
        worst_frequency=worst,
        reason=f"A multiplier with {len(multiplier.taps)} taps proves {reach}, decided exactly; {why}.",
    )


def zames_falb_discrete_criterion(block: RationalPlant, bounds: SlopeBounds, *, odd: bool) -> Answer:
    r"""Whether a discrete-time Zames-Falb multiplier of finite length proves one class of slopes.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds on the slope of ``phi``.
    odd : bool
        Whether ``phi`` is known to be odd.

    Returns
    -------
    Answer
        As :func:`zames_falb_discrete_largest`, about this class; INCONCLUSIVE if it is beyond the multipliers found,
        which does not mean that the loop is unstable.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        A bound is infinite, or the block is not stable with the gain ``bounds.lower``.
    """
    lower, upper = finite_bounds(bounds, "zames_falb_discrete_criterion")
    discrete = DiscretePlant.of(block, lower, "zames_falb_discrete_criterion")
    ceiling, why = _ceiling(block, discrete, odd=odd)
    multiplier, low = _reach(discrete, ceiling, odd=odd, taps=None)
    proved = certifies(discrete, multiplier, upper - lower, odd=odd)
    margin, worst = _margin(discrete, multiplier, upper - lower)
    return replace(
        _blank(bounds, odd=odd),
        largest=Bracket(low if low > lower else double_below(lower), ceiling),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        multiplier=str(multiplier),
        parameters=_parameters(multiplier, upper),
        margin=margin,
        worst_frequency=worst,
        reason="The inequality holds at every frequency, decided exactly."
        if proved
        else f"The multipliers found reach {text_below(low)} only; {why}; nothing follows about larger slopes.",
    )


def _ceiling(block: RationalPlant, discrete: DiscretePlant, *, odd: bool) -> tuple[float, str]:
    """A slope that no multiplier reaches, and why."""
    linear = hurwitz_limit(block, discrete.lower).high
    limit = lowest_phase_limit(discrete, PERIODS, odd=odd)
    if limit is not None and limit.k < linear:
        return (
            limit.k,
            f"the harmonics of period {limit.period} rule out every multiplier from {text_above(limit.k)} on",
        )
    if math.isinf(linear):
        return linear, "no upper limit of the criterion was found"
    return linear, f"linear gains are stable only below {text_above(linear)}"


def _reach(discrete: DiscretePlant, ceiling: float, *, odd: bool, taps: int | None) -> tuple[Multiplier, float]:
    """The best multiplier found and the certified upper slope, infinite for all finite ones, NaN for none."""
    target = 0.0
    if ceiling < math.inf:
        target = float((1 + Fraction(CLOSED)) / ((Fraction(ceiling) - discrete.lower) * discrete.gain))
    response = SampledResponse.of(*discrete.coefficients())
    lengths = LENGTHS if taps is None else (*(n for n in LENGTHS if n < taps), taps)
    best = _search(response, lengths, target, odd=odd)
    if odd and best.inverse > target:  # odd laws are monotone too: never less than for those
        best = min(best, _search(response, lengths, target, odd=False), key=lambda proposal: proposal.inverse)
    proposal = _rounded(response, best)
    multiplier = _multiplier(proposal)
    if math.isinf(ceiling) and proposal.inverse <= NEGLIGIBLE and certifies_every(discrete, multiplier, odd=odd):
        return multiplier, math.inf

    def certified(width: Fraction) -> bool:
        """Whether the exact test proves this width."""
        return discrete.lower + width < ceiling and certifies(discrete, multiplier, width, odd=odd)

    return multiplier, largest_certified(discrete, proposal.inverse, certified)


def _search(response: SampledResponse, lengths: Sequence[int], target: float, *, odd: bool) -> Proposal:
    """The best taps of growing length, until their ``1/k`` is down to ``target``."""
    best: Proposal | None = None
    for length in lengths:
        best = best_taps(response, length, odd=odd, start=best)
        if best.inverse <= target:
            break
    assert best is not None
    return best


def _rounded(response: SampledResponse, best: Proposal) -> Proposal:
    """The same taps, cut to the fewest decimals that cost nothing."""
    for denominator in DENOMINATORS:
        cut = np.trunc(best.taps * denominator) / denominator
        trial = evaluated(response, best.shifts, cut)
        if trial.inverse <= best.inverse + 1e-11 * abs(best.inverse):
            return trial
    return trial


def _multiplier(proposal: Proposal) -> Multiplier:
    limit = DENOMINATORS[-1]
    exact = {
        i: Fraction(round(value * limit), limit)
        for i, value in zip(proposal.shifts, proposal.taps.tolist(), strict=True)
        if value
    }
    return Multiplier(taps=exact)


def _margin(discrete: DiscretePlant, multiplier: Multiplier, width: Fraction | None) -> tuple[Bracket, float]:
    margin, c = least_on_circle(inequality(discrete, multiplier, width), discrete.square)
    return margin, math.acos(min(max(c, -1.0), 1.0))


def _parameters(multiplier: Multiplier, k: Fraction | None) -> Mapping[str, object]:
    taps = {str(i): str(h) for i, h in sorted(multiplier.taps.items())}
    return MappingProxyType({"taps": taps, "k": "inf" if k is None else str(k)})


def _blank(bounds: SlopeBounds, *, odd: bool) -> Answer:
    """The answer that nothing was shown of this class."""
    signs = "of either sign, for odd phi" if odd else "h_i >= 0"
    return Answer(
        criterion=NAME,
        theorem=THEOREM,
        largest=Bracket(double_below(Fraction(bounds.lower)), math.inf),
        law_class=NonlinearityClass.slope_restricted(bounds.lower, bounds.upper, odd=odd),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "odd", "time-invariant") if odd else ("slope", "time-invariant"),
        hypotheses=(
            "every pole of H after the shift by the lower slope, hidden modes included, lies inside the unit circle: "
            "exact root count",
            f"sum |h_i| < 1, {signs}: checked on the exact taps",
            "1 + kappa D > 0 for every slope kappa of the class: exact",
            "the inequality at every frequency: exact root count of a polynomial in cos w",
            "phi is time-invariant, phi(0) = 0, with the slopes of the class"
            + (", and odd" if odd else "")
            + ": assumed",
        ),
        reason="No multiplier was found that proves any slope above the lower one.",
    )

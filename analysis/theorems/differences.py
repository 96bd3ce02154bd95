"""Tsypkin's criterion, for odd laws too, and the Jury-Lee criterion: discrete time, one difference of samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType

from flint import fmpq_poly

from lure.analysis.inequality.checks import finite_bounds
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.unit_circle import DiscretePlant, below, largest_certified, nearest_double
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.trigonometric import (
    Laurent,
    at_cosine,
    least_on_circle,
    nonnegative_on_circle,
    positive_on_circle,
)
from lure.analysis.theorems.fir import SampledResponse
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.arrays import Reals, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.plants.rational import RationalPlant

# What these criteria share: one weight ``q >= 0`` on a difference of successive samples, or on their sum.


WEIGHTS = [0.0, *(10 ** (i / 4) for i in range(-24, 33))]
GOLDEN_STEPS = 50
NEARBY = (0.0, *(sign * 10.0**-power for power in range(3, 9) for sign in (-1, 1)))
GOLDEN = (math.sqrt(5) - 1) / 2
DIGITS = (2, 3, 4, 6, 8, 10, 12, 17)
STEPS_UP = (1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)


@dataclass(frozen=True, kw_only=True, slots=True)
class DifferenceMultiplier:
    r"""The inequality ``1/K + Re[(1 + q Z) H] - q K s |(z - 1) H|^2 > 0`` on ``|z| = 1``.

    Attributes
    ----------
    discrete : DiscretePlant
        The stable block ``H``.
    difference : Laurent
        ``Z``: ``1 - z^-1``, ``1 + z^-1`` or ``z - 1``.
    loss : Fraction
        ``s >= 0``.
    """

    discrete: DiscretePlant
    difference: Laurent
    loss: Fraction

    def constant(self, width: Fraction) -> fmpq_poly:
        """``|d|^2 (1/width + Re H)`` as a polynomial in ``c = cos w``."""
        return to_fmpq(1 / width) * self.discrete.square + self.discrete.cross.real_part()

    def slope(self, width: Fraction) -> fmpq_poly:
        """The coefficient of ``q``, times ``|d|^2``."""
        gain = (self.difference * self.discrete.cross).real_part()
        return gain - to_fmpq(self.loss * width) * self.squared_difference

    @property
    def squared_difference(self) -> fmpq_poly:
        """``|z - 1|^2 |n|^2``."""
        n = self.discrete.n
        return fmpq_poly([2, -2]) * (n * n.conjugate()).real_part()

    def inequality(self, width: Fraction, q: Fraction) -> fmpq_poly:
        """The left-hand side times ``|d|^2``."""
        return self.constant(width) + to_fmpq(q) * self.slope(width)

    def certifies(self, width: Fraction, q: Fraction) -> bool:
        """Whether it holds at every frequency and ``1 + kappa D > 0`` on ``[0, width]``, decided exactly."""
        if not (width > 0 and q >= 0 and self.discrete.well_posed(width)):
            return False
        return positive_on_circle(self.inequality(width, q))

    def certifies_every(self, q: Fraction) -> bool:
        """The same for every finite width: possible only without a loss that grows with it."""
        if not (q >= 0 and self.discrete.feedthrough >= 0):
            return False
        if q > 0 and self.loss > 0 and self.discrete.n.p.degree() >= 0:
            return False
        real_part = self.discrete.cross + (self.difference * self.discrete.cross).scaled(q)
        return nonnegative_on_circle(real_part.real_part())

    def excluded(self, width: Fraction, cosines: Iterable[Fraction]) -> bool:
        """Whether no ``q >= 0`` satisfies the inequality even at these ``c = cos w`` alone, decided exactly.

        At one ``c`` it reads ``alpha + beta q > 0``: a bound on ``q`` from below or from above.
        """
        constant, slope = self.constant(width), self.slope(width)
        above, below = Fraction(0), None
        for c in cosines:
            alpha, beta = at_cosine(constant, c), at_cosine(slope, c)
            if not -1 <= c <= 1 or (beta == 0 and alpha > 0):
                continue
            if beta == 0:
                return True
            if beta > 0:
                above = max(above, -alpha / beta)
            else:
                below = -alpha / beta if below is None else min(below, -alpha / beta)
        # q above ``above``, or equal to it where it is 0, and strictly below ``below``
        return below is not None and below <= above


@dataclass(frozen=True, kw_only=True, slots=True)
class DifferenceReach:
    """How far it reaches: ``low`` is certified with ``q`` (NaN if none), at ``high`` no ``q`` is left."""

    q: Fraction
    low: float
    high: float


def difference_reach(multiplier: DifferenceMultiplier) -> DifferenceReach:
    """The largest class and the best weight: searched in floating point, then both ends decided exactly.

    Parameters
    ----------
    multiplier : DifferenceMultiplier
        The inequality.

    Notes
    -----
    The set of feasible ``q`` is an interval that shrinks as ``K`` grows, so that the reach is quasiconcave in ``q``.
    """
    sampled = _Sampled.of(multiplier)
    weight, inverse, tight = _best_weight(sampled)
    for text in ("0", *(f"{weight:.{digits}g}" for digits in DIGITS)):
        q = Fraction(text)
        rounded, _ = sampled.inverse_reach(float(q))
        if rounded <= inverse * (1 + 1e-12):
            break
    discrete = multiplier.discrete
    if not inverse > 1e-12 * sampled.size and multiplier.certifies_every(q):
        return DifferenceReach(q=q, low=math.inf, high=math.inf)
    low = largest_certified(discrete, rounded, lambda width: multiplier.certifies(width, q))
    cosines = [Fraction(c) for c in np.unique(np.cos(tight)).tolist()]
    high = math.inf
    for step in STEPS_UP if 0 < inverse < math.inf else ():
        k = nearest_double(discrete.lower + (1 + Fraction(step)) / (Fraction(inverse) * discrete.gain))
        if discrete.lower < k < math.inf and multiplier.excluded(Fraction(k) - discrete.lower, cosines):
            high = k
            break
    return DifferenceReach(q=q, low=low, high=high)


@dataclass(frozen=True, slots=True)
class _Sampled:
    """The inequality in floating point: ``1/K`` must exceed ``(sqrt(R^2 + 4 q Q) - R)/2``, ``R = Re[(1 + q Z) H]``."""

    response: SampledResponse
    multiplier: DifferenceMultiplier
    size: float

    @classmethod
    def of(cls, multiplier: DifferenceMultiplier) -> _Sampled:
        """The left-hand side of a multiplier on the points of a response."""
        response = SampledResponse.of(*multiplier.discrete.coefficients())
        return cls(response, multiplier, float(np.max(np.abs(response.at(response.omega)))))

    def at(self, omega: Reals, q: float) -> Reals:
        """Its values at ``omega`` for one ``q``, in floating point."""
        z, H = np.exp(1j * omega), self.response.at(omega)
        difference = self.multiplier.difference
        Z = np.polyval([float(c.p) / float(c.q) for c in reversed(difference.p.coeffs())], z) / z**difference.shift
        with np.errstate(invalid="ignore", over="ignore"):
            R = ((1 + q * Z) * H).real
            Q = float(self.multiplier.loss) * np.abs((z - 1) * H) ** 2
            return np.asarray((np.sqrt(R * R + 4 * q * Q) - R) / 2)

    def inverse_reach(self, q: float) -> tuple[float, Reals]:
        """The largest value over all frequencies, and the frequencies of the local maxima."""
        return self.response.maximum(lambda omega: self.at(omega, q))


def _best_weight(sampled: _Sampled) -> tuple[float, float, Reals]:
    values = [sampled.inverse_reach(q)[0] for q in WEIGHTS]
    best = int(np.argmin(values))
    left, right = WEIGHTS[max(best - 1, 0)], WEIGHTS[min(best + 1, len(WEIGHTS) - 1)]
    a, b = right - GOLDEN * (right - left), left + GOLDEN * (right - left)
    at_a, at_b = sampled.inverse_reach(a)[0], sampled.inverse_reach(b)[0]
    for _ in range(GOLDEN_STEPS):
        if at_a <= at_b:
            right, b, at_b = b, a, at_a
            a = right - GOLDEN * (right - left)
            at_a = sampled.inverse_reach(a)[0]
        else:
            left, a, at_a = a, b, at_b
            b = left + GOLDEN * (right - left)
            at_b = sampled.inverse_reach(b)[0]
    weight, inverse = min((a, at_a), (b, at_b), (WEIGHTS[best], values[best]), key=lambda pair: pair[1])
    near = [sampled.inverse_reach(weight * (1 + step))[1] for step in NEARBY]
    return weight, inverse, np.concatenate(near)


# The answers of Tsypkin's and the Jury-Lee criterion, given what sets the two apart.

Bound = Fraction | float


@dataclass(frozen=True, kw_only=True, slots=True)
class Form:
    """One of the criteria.

    Attributes
    ----------
    name, theorem, formula : str
        For the answer; ``formula`` is the left-hand side with ``q`` and ``k``.
    difference : Laurent
        What ``q`` multiplies.
    loss : Fraction
        The factor of ``-q K |(z - 1) H|^2``.
    slopes : callable
        The slope bounds the theorem needs, given lower and upper end of the sector and ``D`` of the shifted block.
    odd : bool
        Whether it is about odd laws only.
    """

    name: str
    theorem: str
    formula: str
    difference: Laurent
    loss: Fraction
    slopes: Callable[[Bound, Bound, Fraction], SlopeBounds]
    odd: bool = False


def largest_answer(block: RationalPlant, form: Form, *, lower: Fraction) -> Answer:
    """How far the criterion reaches from ``lower``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    form : Form
        The criterion.
    lower : Fraction
        Lower end of the class.
    """
    multiplier, reach = _reach(block, form, lower)
    if not reach.low > lower:
        return replace(
            _blank(multiplier, form, (lower, math.inf)),
            largest=Bracket(below(lower), reach.high),
            reason="No weight q was found that proves any slope above the lower one.",
        )
    margin, worst = _margin(multiplier, reach.q, reach.low)
    return replace(
        _blank(multiplier, form, (lower, reach.low)),
        largest=Bracket(reach.low, reach.high),
        verdict=Verdict.PROVED,
        parameters=MappingProxyType({"q": str(reach.q), "k": _text(reach.low)}),
        margin=margin,
        worst_frequency=worst,
        reason=f"With q = {float(reach.q):.8g} the inequality holds up to k = {text_below(reach.low)}, decided "
        f"exactly; no q reaches {text_above(reach.high)}.",
    )


def class_answer(block: RationalPlant, form: Form, bounds: SlopeBounds) -> Answer:
    """Whether the criterion proves one class.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    form : Form
        The criterion.
    bounds : SlopeBounds
        Finite bounds.

    Raises
    ------
    AssumptionError
        A bound is infinite.
    """
    lower, upper = finite_bounds(bounds, form.name)
    multiplier, reach = _reach(block, form, lower)
    margin, worst = _margin(multiplier, reach.q, upper)
    proved = multiplier.certifies(upper - lower, reach.q)
    return replace(
        _blank(multiplier, form, (bounds.lower, bounds.upper)),
        largest=Bracket(reach.low if reach.low > lower else below(lower), reach.high),
        verdict=Verdict.PROVED if proved else Verdict.INCONCLUSIVE,
        parameters=MappingProxyType({"q": str(reach.q), "k": str(upper)}),
        margin=margin,
        worst_frequency=worst,
        reason="The inequality holds at every frequency, decided exactly."
        if proved
        else f"The criterion reaches {text_below(reach.low)} and not {text_above(reach.high)}; nothing follows about "
        "larger slopes.",
    )


def _reach(block: RationalPlant, form: Form, lower: Fraction) -> tuple[DifferenceMultiplier, DifferenceReach]:
    discrete = DiscretePlant.of(block, lower, form.name)
    multiplier = DifferenceMultiplier(discrete=discrete, difference=form.difference, loss=form.loss)
    ceiling = hurwitz_limit(block, lower).high
    reach = difference_reach(multiplier)
    return multiplier, replace(reach, high=min(reach.high, ceiling))


def _margin(multiplier: DifferenceMultiplier, q: Fraction, k: Bound) -> tuple[Bracket, float]:
    if k == math.inf:
        discrete = multiplier.discrete
        top = (discrete.cross + (multiplier.difference * discrete.cross).scaled(q)).real_part()
    else:
        top = multiplier.inequality(Fraction(k) - multiplier.discrete.lower, q)
    margin, c = least_on_circle(top, multiplier.discrete.square)
    return margin, math.acos(min(max(c, -1.0), 1.0))


def _blank(multiplier: DifferenceMultiplier, form: Form, ends: tuple[Bound, Bound]) -> Answer:
    lower, upper = ends
    slopes = form.slopes(lower, upper, multiplier.discrete.feedthrough)
    law = NonlinearityClass(sector=Sector(lower, upper), slope=slopes, odd=form.odd)
    return Answer(
        criterion=form.name,
        theorem=form.theorem,
        largest=Bracket(below(Fraction(lower)), math.inf),
        law_class=law,
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        needs=("slope", "odd", "time-invariant") if form.odd else ("slope", "time-invariant"),
        multiplier=form.formula,
        hypotheses=(
            "every pole of H after the shift by the lower slope, hidden modes included, lies inside the unit circle: "
            "exact root count",
            "1 + kappa D > 0 for every gain kappa of the sector: exact",
            "the inequality at every frequency: exact root count of a polynomial in cos w",
            f"{law}, time-invariant" + (", continuous" if multiplier.discrete.feedthrough else "") + ": assumed",
        ),
    )


def _text(k: float) -> str:
    return "inf" if math.isinf(k) else str(Fraction(k))


# Tsypkin's criterion: discrete time, a monotone law in a sector, one causal difference.


def _slopes(lower: Bound, upper: Bound, feedthrough: Fraction) -> SlopeBounds:
    """Monotone is enough, unless the algebraic loop needs a bound on the slope from above."""
    return SlopeBounds(lower, upper if feedthrough < 0 else math.inf)


TSYPKIN = Form(
    name="tsypkin",
    theorem="Tsypkin's criterion (Ya. Z. Tsypkin, Soviet Physics Doklady 9 (1964) 263-266; with a Lyapunov function: "
    "V. Kapila, W. M. Haddad, IEEE Trans. Automatic Control 41 (1996) 149-152)",
    formula="1/k + Re[(1 + q (1 - z^-1)) H(z)] > 0",
    difference=Laurent(fmpq_poly([-1, 1]), 1),
    loss=Fraction(0),
    slopes=_slopes,
)


def tsypkin_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""Largest sector that Tsypkin's criterion proves for monotone laws.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    nondecreasing ``phi`` in the sector ``[0, k]`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(1 - z^{-1}))\, H(z)] > 0 \quad (|z| = 1).

    The slope of ``phi`` may exceed ``k``; only where the feedthrough ``D`` is negative is it bounded by ``k`` here, for
    the algebraic loop to have a solution.  With another ``lower`` the criterion is that of ``H/(1 + lower H)``,
    ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector and of the slope.

    Returns
    -------
    Answer
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond: the
        criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    Why: ``phi(y_t) (y_t - y_{t-1}) >= Phi(y_t) - Phi(y_{t-1})`` for the convex primitive ``Phi >= 0`` of ``phi``.

    Examples
    --------
    >>> block = RationalPlant([Fraction("0.1"), 0], [1, Fraction("-1.8"), Fraction("0.81")], dt=1)
    >>> print(f"{tsypkin_largest(block).largest.low:.6f}")
    3.800000
    """
    return largest_answer(block, TSYPKIN, lower=lower)


def tsypkin_criterion(block: RationalPlant, bounds: SlopeBounds) -> Answer:
    """Whether Tsypkin's criterion proves the laws of slope at least ``bounds.lower`` in the sector of both bounds.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds; see :func:`tsypkin_largest` for the class.

    Returns
    -------
    Answer
        PROVED, or INCONCLUSIVE, which says nothing about the loop.
    """
    return class_answer(block, TSYPKIN, bounds)


TSYPKIN_ODD = Form(
    name="tsypkin-odd",
    theorem="Tsypkin's criterion for odd laws (J. C. Willems, R. W. Brockett, IEEE Trans. Automatic Control 13 (1968) "
    "539-549)",
    formula="1/k + Re[(1 + q (1 + z^-1)) H(z)] > 0",
    difference=Laurent(fmpq_poly([1, 1]), 1),
    loss=Fraction(0),
    slopes=_slopes,
    odd=True,
)


def tsypkin_odd_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""Largest sector that Tsypkin's criterion, with the sum of successive samples, proves for odd monotone laws.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant odd
    nondecreasing ``phi`` in the sector ``[0, k]`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(1 + z^{-1}))\, H(z)] > 0 \quad (|z| = 1).

    Hypotheses on the slope, on the feedthrough and on ``lower`` are those of :func:`tsypkin_largest`.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector and of the slope.

    Returns
    -------
    Answer
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond, and nothing
        for laws that are not odd: the criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    Why: the convex primitive ``Phi >= 0`` of an odd ``phi`` is even, so that ``phi(y_t) (y_t + y_{t-1}) >= Phi(y_t) -
    Phi(-y_{t-1}) = Phi(y_t) - Phi(y_{t-1})``.  It is Tsypkin's criterion for ``H(-z)``: ``y_t -> (-1)^t y_t`` maps odd
    laws to themselves.

    Examples
    --------
    ``H(-z)`` of the example of :func:`tsypkin_largest`.

    >>> block = RationalPlant([Fraction("-0.1"), 0], [1, Fraction("1.8"), Fraction("0.81")], dt=1)
    >>> print(f"{tsypkin_odd_largest(block).largest.low:.6f}")
    3.800000
    """
    return largest_answer(block, TSYPKIN_ODD, lower=lower)


def tsypkin_odd_criterion(block: RationalPlant, bounds: SlopeBounds) -> Answer:
    """Whether it proves the odd laws of slope at least ``bounds.lower`` in the sector of both bounds.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds; see :func:`tsypkin_odd_largest` for the class.

    Returns
    -------
    Answer
        PROVED, or INCONCLUSIVE, which says nothing about the loop.
    """
    return class_answer(block, TSYPKIN_ODD, bounds)


def _jury_lee_slopes(lower: Bound, upper: Bound, feedthrough: Fraction) -> SlopeBounds:
    """A bound from above is enough, unless the algebraic loop needs one from below."""
    return SlopeBounds(lower if feedthrough > 0 else -math.inf, upper)


JURY_LEE = Form(
    name="jury-lee",
    theorem="The Jury-Lee criterion (E. I. Jury, B. W. Lee, IEEE Trans. Automatic Control 9 (1964) 51-61)",
    formula="1/k + Re[(1 + q (z - 1)) H(z)] - (q k/2) |(z - 1) H(z)|^2 > 0",
    difference=Laurent(fmpq_poly([-1, 1])),
    loss=Fraction(1, 2),
    slopes=_jury_lee_slopes,
)


def jury_lee_largest(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Answer:
    r"""Largest sector that the Jury-Lee criterion proves for laws of slope at most ``k``.

    In ``sigma = H mu``, ``mu = -phi(sigma)`` the origin is globally asymptotically stable for every time-invariant
    ``phi`` in the sector ``[0, k]`` with ``(phi(x) - phi(y))/(x - y) <= k`` if ``H`` is stable and for some ``q >= 0``

    .. math:: 1/k + \mathrm{Re}\,[(1 + q\,(z - 1))\, H(z)] - \tfrac12 q k\, |(z - 1) H(z)|^2 > 0 \quad (|z| = 1).

    ``phi`` need not be monotone; only where the feedthrough ``D`` is positive is its slope bounded from below by
    ``lower`` here, for the algebraic loop to have a solution.  With another ``lower`` the criterion is that of
    ``H/(1 + lower H)``, ``phi - lower sigma`` and ``k - lower``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``lower`` stable, hidden modes included.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    Answer
        ``largest``: both ends decided exactly; at ``high`` no ``q >= 0`` is left.  Nothing follows beyond: the
        criterion is sufficient only.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        The block is not stable with the gain ``lower``.

    Notes
    -----
    Why: ``phi(y_t) (y_{t+1} - y_t) + (k/2) (y_{t+1} - y_t)^2 >= Phi(y_{t+1}) - Phi(y_t)`` for the primitive
    ``Phi >= 0`` of a ``phi`` with slope at most ``k``.

    Examples
    --------
    For ``H = (2 z + 0.92)/(z^2 - 0.5 z)`` it reaches 0.684932, the circle criterion 0.651041.

    >>> block = RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)
    >>> print(f"{jury_lee_largest(block).largest.low:.6f}")
    0.684932
    """
    return largest_answer(block, JURY_LEE, lower=lower)


def jury_lee_criterion(block: RationalPlant, bounds: SlopeBounds) -> Answer:
    """Whether the Jury-Lee criterion proves the laws of slope at most ``bounds.upper`` in the sector of both bounds.

    Parameters
    ----------
    block : RationalPlant
        In discrete time, with the gain ``bounds.lower`` stable, hidden modes included.
    bounds : SlopeBounds
        Finite bounds; see :func:`jury_lee_largest` for the class.

    Returns
    -------
    Answer
        PROVED, or INCONCLUSIVE, which says nothing about the loop.
    """
    return class_answer(block, JURY_LEE, bounds)

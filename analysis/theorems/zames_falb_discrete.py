"""Discrete-time Zames-Falb multipliers of finite length: searched by linear programs, certified in exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, ClassVar, Self

from flint import fmpq_poly

from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.inequality.protocol import Best, Grounds, Proves
from lure.analysis.inequality.protocol import Multiplier as Weights
from lure.analysis.inequality.unit_circle import DiscretePlant, largest_certified
from lure.analysis.numerics.doubles import double_below, text_above
from lure.analysis.numerics.trigonometric import least_on_circle
from lure.analysis.theorems.criterion import Criterion, slope_criterion
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
from lure.analysis.verdict import Bracket, CriterionResult, Verdict
from lure.arrays import np
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

NAME = "zames-falb"
TITLE = "the criterion of Zames and Falb in discrete time"
THEOREM = (
    "Discrete-time Zames-Falb multipliers (J. C. Willems and R. W. Brockett, IEEE Trans. Automatic Control 13 (1968) "
    "539-549; finite length: J. Carrasco et al., IEEE Trans. Automatic Control 65 (2020) 4538-4553)"
)
LENGTHS = (2, 5, 10, 20, 40)
PERIODS = range(2, 21)
CLOSED = 5e-9
NEGLIGIBLE = 1e-12
NEAR_ONE = 1e-4  # rad per sample, in place of a pole at z = 1
DENOMINATORS = tuple(10**digits for digits in (2, 3, 4, 6, 8, 10, 12, 15))


def zames_falb_discrete_largest(
    block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0), taps: int | None = None
) -> CriterionResult:
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
        Whether ``phi`` is known to be odd.  The answer for odd nonlinearities says nothing about others.
    lower : Fraction
        Lower slope.
    taps : int, optional
        Largest ``|i|``; by default lengths up to 40 are tried.

    Returns
    -------
    CriterionResult
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
    if taps is not None and (isinstance(taps, bool) or not isinstance(taps, int) or taps < 1):
        raise InputError(f"zames_falb_discrete_largest: taps is {taps!r}; give a positive integer, or None")
    inequality = TapsInequality.of(block, Fraction(lower), odd=odd, taps=taps)
    answer = _criterion(odd=odd).answer(inequality)
    if answer.verdict is not Verdict.PROVED:
        return answer
    margin, worst = inequality.least(answer.parameters, answer.largest.low)
    return replace(answer, margin=margin, worst_frequency=worst)


def zames_falb_discrete_criterion(block: RationalPlant, bounds: SlopeBounds, *, odd: bool) -> CriterionResult:
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
    CriterionResult
        As :func:`zames_falb_discrete_largest`, about this class; INCONCLUSIVE if it is beyond the multipliers found,
        which does not mean that the loop is unstable.

    Raises
    ------
    InputError
        The block is in continuous time.
    AssumptionError
        A bound is infinite, or the block is not stable with the gain ``bounds.lower``.
    """
    return _criterion(odd=odd).decide(block, bounds)


@described(frozen=True, kw_only=True, slots=True)
class TapsInequality:
    """``Re[M (H + 1/(k - lower))] > 0`` on the circle with finitely many taps."""

    base: RationalInequality = quantity("The same without a multiplier")
    discrete: DiscretePlant = quantity("The shifted plant in powers of ``z``")
    odd: bool = quantity("Whether taps may be negative")
    taps: int | None = quantity("Largest shift; None for growing lengths", default=None)
    title: ClassVar[str] = TITLE
    critical: ClassVar[bool] = True

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction, *, odd: bool, **more: Any) -> Self:  # noqa: ANN401  (fields)
        """The inequality of a plant.

        Parameters
        ----------
        block : RationalPlant
            The plant.
        lower : Fraction
            Lower slope.
        odd : bool
            Whether ``phi`` is known to be odd.
        **more
            The other fields.

        Raises
        ------
        AssumptionError, InputError
            As :func:`lure.analysis.inequality.checks.admitted_plant`.
        """
        base = RationalInequality.of(block, lower, cls.title, discrete=True, critical=cls.critical).unweighted
        discrete = DiscretePlant.of(block, lower, cls.title, critical=cls.critical)
        return cls(base=base, discrete=discrete, odd=odd, **more)

    @property
    def grounds(self) -> Grounds:
        """Those of Popov's inequality."""
        return self.base.grounds

    def best(self, enough: Fraction | None = None) -> Best:
        """The best taps that the linear programmes find, and a slope that none of any length reach."""
        ceiling, limit = _ceiling(self.base.plant.block, self.discrete, odd=self.odd)
        multiplier, low = _certified_taps(self.discrete, ceiling, odd=self.odd, taps=self.taps)
        return Best(
            multiplier={"taps": {str(i): str(h) for i, h in sorted(multiplier.taps.items())}},
            largest=Bracket(low if low > self.base.lower else double_below(self.base.lower), ceiling),
            formula=str(multiplier),
            limit=limit,
        )

    def serving(self, best: Best, _proves: Proves) -> Weights:
        """The best taps: they serve every smaller class too."""
        return best.multiplier or {"taps": {}}

    def decide(self, multiplier: Weights, upper: Fraction) -> bool:
        """Whether the taps prove the slopes ``[lower, upper]``, exactly."""
        return certifies(self.discrete, _taps(multiplier), Fraction(upper) - self.base.lower, odd=self.odd)

    def least(self, multiplier: Weights, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum over frequency of the left-hand side, and where it is attained [rad per sample]."""
        width = None if upper == math.inf else Fraction(upper) - self.base.lower
        square = self.discrete.square
        square = square // fmpq_poly([1, -1]) if self.discrete.critical else square
        margin, c = least_on_circle(self.polynomial(multiplier, width), square)
        return margin, math.acos(min(max(c, -1.0), 1.0))

    def polynomial(self, multiplier: Weights, width: Fraction | None) -> fmpq_poly:
        """The left-hand side times ``|d|^2`` as a polynomial in ``cos w``, for a width of the class, None for none."""
        return inequality(self.discrete, _taps(multiplier), width)


def _taps(multiplier: Weights) -> Multiplier:
    return Multiplier(taps={int(i): Fraction(h) for i, h in multiplier["taps"].items()})


def _criterion(*, odd: bool) -> Criterion:
    """The criterion for monotone nonlinearities, or for odd ones."""
    return slope_criterion(
        odd=odd,
        name=NAME,
        title=TITLE,
        theorem=THEOREM,
        formula="M(z) = 1 - sum h_i z^-i",
        inequality=partial(TapsInequality.of, odd=odd),
        legal=f"sum |h_i| < 1, {'of either sign, for odd phi' if odd else 'h_i >= 0'}: checked on the exact taps",
    )


def _ceiling(block: RationalPlant, discrete: DiscretePlant, *, odd: bool) -> tuple[float, str]:
    """A slope that no multiplier reaches, and why."""
    linear = hurwitz_limit(block, discrete.lower).high
    limit = lowest_phase_limit(discrete, PERIODS, odd=odd, below=linear)
    if limit is not None:
        return (
            limit.k,
            f"the harmonics of period {limit.period} rule out every multiplier from {text_above(limit.k)} on",
        )
    if math.isinf(linear):
        return linear, "no upper limit of the criterion was found"
    return linear, f"linear gains are stable only below {text_above(linear)}"


def best_multiplier(discrete: DiscretePlant, block: RationalPlant, *, odd: bool) -> tuple[Multiplier, float]:
    """The best taps found and the largest slope that they prove, NaN for none.

    ``discrete``: the shifted plant; ``block``: the plant as given; ``odd``: whether taps may be negative.
    """
    ceiling, _ = _ceiling(block, discrete, odd=odd)
    return _certified_taps(discrete, ceiling, odd=odd, taps=None)


def _certified_taps(
    discrete: DiscretePlant, ceiling: float, *, odd: bool, taps: int | None
) -> tuple[Multiplier, float]:
    """The best multiplier found and the certified upper slope, infinite for all finite ones, NaN for none."""
    target = 0.0
    if ceiling < math.inf:
        target = float((1 + Fraction(CLOSED)) / ((Fraction(ceiling) - discrete.lower) * discrete.gain))
    response = SampledResponse.of(*discrete.coefficients(), least=NEAR_ONE if discrete.critical else 0.0)
    lengths = LENGTHS if taps is None else (*(n for n in LENGTHS if n < taps), taps)
    best = _search(response, lengths, target, odd=odd)
    if odd and best.inverse > target:  # odd nonlinearities are monotone too: never less than for those
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

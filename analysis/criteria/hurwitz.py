"""Every linear gain for which the loop is stable, exactly: the bound that no criterion for nonlinear laws can pass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from analysis.answer import Answer
from analysis.criteria.gain_ends import GainEnd, gain_ends, simplest_between
from analysis.evidence import INFINITE, Bracket, Evidence, Verdict
from analysis.plant import Plant
from analysis.polynomial import is_hurwitz, to_fmpq
from analysis.precision import ball, outward
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector
from lure.showing import html_table, plain

THEOREM = (
    "Nyquist's criterion by exact root counts: d + kappa n has all roots in the open left half-plane (open unit disc); "
    "H. Nyquist, Bell System Technical Journal 11 (1932) 126-147"
)


@dataclass(frozen=True, kw_only=True, slots=True)
class GainInterval:
    """An open interval of stable gains, as large as possible.

    Attributes
    ----------
    lower, upper : GainEnd
        Its ends, at which the loop is not stable; infinite where there is none.
    sample : Fraction
        A gain inside.
    """

    lower: GainEnd
    upper: GainEnd
    sample: Fraction

    def __str__(self) -> str:
        return f"({self.lower.value.middle:.6g}, {self.upper.value.middle:.6g})"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: brackets of both ends, and the gain inside as text ``p/q``."""
        ends = {"lower": plain(self.lower.value), "upper": plain(self.upper.value)}
        return {"kind": "interval of stable gains", **ends, "sample": str(self.sample), "evidence": "certified"}

    def _repr_html_(self) -> str:
        rows = [("from", self.lower.value), ("to", self.upper.value), ("a gain inside", self.sample)]
        note = "Linear gains, by exact root counts (certified); nothing follows for nonlinear phi."
        return html_table("Stable linear gains, mu = -kappa sigma", rows, notes=[note])


def is_stable_gain(block: RationalBlock, kappa: Fraction) -> bool:
    r"""Whether ``mu = -kappa sigma`` is stable: all roots of ``d + kappa n`` strictly inside, hidden modes too.

    Where ``1 + kappa H(inf) = 0`` the loop has no solution, and the answer is False.

    Parameters
    ----------
    block : RationalBlock
        The block ``sigma = H mu``.
    kappa : Fraction
        The gain, of either sign.

    Examples
    --------
    >>> block = RationalBlock([1], [1, 3, 2, 0])
    >>> is_stable_gain(block, Fraction(5)), is_stable_gain(block, Fraction(6))
    (True, False)
    """
    plant = Plant.of(block)
    p = plant.d + to_fmpq(kappa) * plant.n
    return p.degree() == plant.degree and is_hurwitz(p)


def gain_intervals(block: RationalBlock) -> tuple[GainInterval, ...]:
    r"""All real gains ``kappa`` for which the loop ``mu = -kappa sigma``, ``sigma = H mu`` is stable, ascending.

    Roots of ``d + kappa n`` depend continuously on ``kappa`` and can leave the open half-plane only through the axis
    (infinity included), at the gains of :func:`analysis.criteria.gain_ends.gain_ends`; one exact count between
    neighbours decides each interval.

    Parameters
    ----------
    block : RationalBlock
        The block; hidden modes that are not strictly stable leave no interval.

    Returns
    -------
    tuple of GainInterval
        Disjoint; the loop is unstable or marginal at every gain outside.

    Examples
    --------
    >>> print(*gain_intervals(RationalBlock([1], [1, 3, 2, 0])))
    (0, 6)
    """
    ends = gain_ends(block)
    if ends is None:
        return ()
    found = []
    for i in range(len(ends) + 1):
        sample = _sample(ends, i)
        if is_stable_gain(block, sample):
            lower = ends[i - 1] if i > 0 else GainEnd(value=Bracket(-math.inf, -math.inf))
            upper = ends[i] if i < len(ends) else GainEnd(value=INFINITE)
            found.append(GainInterval(lower=lower, upper=upper, sample=sample))
    return tuple(found)


def hurwitz_limit(block: RationalBlock, lower: Fraction = Fraction(0)) -> Bracket:
    r"""The supremum of the ``k`` such that every gain in ``[lower, k]`` is stable; ``lower`` itself if there is none.

    Where the loop is marginal at ``lower`` (a pole at 0, say) the gains are those of ``(lower, k]``.  Every gain above
    ``lower`` and strictly below the bracket's ``low`` is stable; its relative width is below 1e-12.

    Parameters
    ----------
    block : RationalBlock
        The block.
    lower : Fraction
        Least gain.

    Examples
    --------
    >>> print(hurwitz_limit(RationalBlock([1], [1, 3, 2, 0])))
    6
    """
    end = _upper_end(block, Fraction(lower))
    return outward(ball(lower), ball(lower)) if end is None else end.value


def hurwitz_largest(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Answer:
    """The largest ``k`` for which every linear gain in ``[lower, k]`` is stable: a necessary condition for the class.

    The verdict is INCONCLUSIVE where that interval is not empty, for nothing is said about nonlinear laws, and REFUTED
    by a linear gain where it is, or where ``lower`` itself is a gain that leaves solutions away from all equilibria.

    Parameters
    ----------
    block : RationalBlock
        The block.
    lower : Fraction
        Least gain; one simple pole at 0 (``z = 1``) with it is admitted.
    """
    lower = Fraction(lower)
    unstable = Plant.of(block).shifted(lower).case == "unstable"
    end = None if unstable else _upper_end(block, lower)
    if end is None:
        gain = lower if unstable else _gain_above(block, lower)
        return _answer(
            Sector(lower, math.inf),
            outward(ball(lower), ball(lower)),
            Verdict.REFUTED,
            f"the gain {float(lower):g} is not stable"
            if unstable
            else f"no gain just above {float(lower):g} is stable",
            f"phi = {gain} sigma",
        )
    if end.high is None:
        return _answer(
            Sector(lower, math.inf),
            INFINITE,
            Verdict.INCONCLUSIVE,
            f"every linear gain above {float(lower):g} is stable; nothing follows for nonlinear phi",
        )
    low = math.nextafter(end.value.low, -math.inf)
    sector = Sector(lower, low) if low > lower else Sector(lower, end.high)
    exact = f" = {end.exact}" if end.exact is not None else ""
    where = ", ".join(f"{omega:.6g}" for omega in end.frequencies)
    reason = (
        f"linear gains are stable up to {end.value.middle:.10g}{exact}, where roots reach the axis at frequency "
        f"{where}; nothing follows for nonlinear phi, and no criterion can pass this bound"
    )
    return _answer(sector, Bracket(low, end.value.high), Verdict.INCONCLUSIVE, reason)


def hurwitz_criterion(block: RationalBlock, sector: Sector) -> Answer:
    """Whether every linear gain in a finite or infinite sector is stable; REFUTED with a linear gain where not.

    The least gain may leave one simple pole at 0 (then the gains of ``(lower, upper]`` are asked about).

    Parameters
    ----------
    block : RationalBlock
        The block.
    sector : Sector
        The sector; an infinite ``lower`` is allowed.
    """
    gain = unstable_gain(block, sector)
    limit = INFINITE if sector.lower == -math.inf else hurwitz_limit(block, Fraction(sector.lower))
    if gain is not None:
        return _answer(sector, limit, Verdict.REFUTED, f"the linear gain {gain} is not stable", f"phi = {gain} sigma")
    reason = f"every linear gain in the sector {sector} is stable; nothing follows for nonlinear phi"
    return _answer(sector, limit, Verdict.INCONCLUSIVE, reason)


def unstable_gain(block: RationalBlock, sector: Sector) -> Fraction | GainEnd | None:
    """A gain of the sector for which the loop is not stable; None if there is none but perhaps ``sector.lower``.

    A gain at which the loop is only marginal counts as not stable, save ``sector.lower`` in the critical case, one
    simple pole at 0; it is returned as its :class:`GainEnd` where it may be irrational.

    Parameters
    ----------
    block : RationalBlock
        The block.
    sector : Sector
        The sector, with finite or infinite bounds.
    """
    marks = tuple(Fraction(bound) for bound in (sector.lower, sector.upper) if abs(bound) != math.inf)
    ends = gain_ends(block, marks)
    if ends is None:
        return simplest_inside(sector)
    inside = [end for end in ends if _within(end, sector)]
    for i in range(len(inside) + 1):
        low = inside[i - 1].high if i > 0 else _finite(sector.lower)
        high = inside[i].low if i < len(inside) else _finite(sector.upper)
        if low is not None and low == high:  # a mark that is an end itself
            continue
        sample = _between(low, high)
        if not is_stable_gain(block, sample):
            return sample
    lower = _finite(sector.lower)
    spared = lower if lower is not None and Plant.of(block).shifted(lower).case == "critical" else None
    marginal = next((end for end in inside if end.exact is None or end.exact != spared), None)
    return marginal if marginal is None or marginal.exact is None else marginal.exact


def simplest_inside(sector: Sector) -> Fraction:
    """A simple rational strictly inside a sector."""
    return _between(_finite(sector.lower), _finite(sector.upper))


def _within(end: GainEnd, sector: Sector) -> bool:
    return end.low is not None and end.high is not None and sector.lower <= end.low and end.high <= sector.upper


def _finite(bound: float | Fraction) -> Fraction | None:
    return None if abs(bound) == math.inf else Fraction(bound)


def _between(low: Fraction | None, high: Fraction | None) -> Fraction:
    """A simple rational strictly between two bounds, None for infinity."""
    if low is None and high is None:
        return Fraction(0)
    if low is None:
        return Fraction(math.floor(high or 0) - 1)
    if high is None:
        return Fraction(math.ceil(low) + 1)
    third = (high - low) / 3
    return simplest_between(low + third, high - third)


def _sample(ends: Sequence[GainEnd], i: int) -> Fraction:
    """A gain between the ends ``i - 1`` and ``i``."""
    return _between(ends[i - 1].high if i > 0 else None, ends[i].low if i < len(ends) else None)


def _upper_end(block: RationalBlock, lower: Fraction) -> GainEnd | None:
    """Where the stable gains that begin at ``lower`` end; None if no gain just above it is stable."""
    ends = gain_ends(block, (lower,))
    if ends is None:
        return None
    above = [end for end in ends if end.low is not None and end.low > lower]
    at_lower = any(end.exact == lower for end in ends)
    sample = _between(lower, above[0].low if above else None) if at_lower else lower
    if not is_stable_gain(block, sample):
        return None
    return above[0] if above else GainEnd(value=INFINITE)


def _gain_above(block: RationalBlock, lower: Fraction) -> Fraction:
    ends = gain_ends(block, (lower,)) or ()
    above = [end for end in ends if end.low is not None and end.low > lower]
    return _between(lower, above[0].low if above else None)


def _answer(sector: Sector, largest: Bracket, verdict: Verdict, reason: str, witness: str | None = None) -> Answer:
    return Answer(
        criterion="hurwitz",
        theorem=THEOREM,
        largest=largest,
        law_class=LawClass(sector=sector),
        verdict=verdict,
        evidence=Evidence.CERTIFIED,
        hypotheses=("phi linear: phi = kappa sigma with a constant kappa", "root counts: exact, for every gain"),
        reason=reason,
        witness=witness,
    )

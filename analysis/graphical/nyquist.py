"""``nyquist_response``: the Nyquist plot of a loop, the region of the circle criterion, and what stands behind it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.graphical.axis import Drawable, axis_values, drawable
from lure.analysis.graphical.supporting_proof import (
    ROUNDING,
    Drawn,
    block_text,
    criterion_asked,
    span_text,
    upper_end,
)
from lure.analysis.numerics.doubles import double_above, double_below, text_above, text_below
from lure.analysis.questions import StabilityBound, max_sector
from lure.analysis.verdict import CriterionResult, Verdict
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.exact import Exact, exact_number
from lure.plants.block import StructuredPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import derived, quantity

# What a Nyquist plot shows, and what stands behind it.


class NyquistResponse(Drawn):
    r"""A curve ``H(i omega)``, the region that the circle criterion forbids to it, and what proves the sector, if any.

    For ``mu = -phi(t, sigma)``, ``sigma = H mu`` and the sector ``[lower, k]`` the criterion asks
    ``Re[(1 + k H)(1 + lower H)^*] > 0``: the curve stays right of ``-1/k`` (``lower = 0``), outside the disc on
    ``[-1/lower, -1/k]`` (both of one sign; then it must also encircle it as often as ``H`` has unstable poles, which no
    distance shows), or inside that disc (``lower < 0 < k``).  The curve here is finitely many points: OBSERVED.
    """

    lower: float = quantity("Lower end of the sector")
    _kind = "nyquist response"
    _title = "Nyquist plot"
    _notes = ("A drawing proves nothing between and beyond its points, and a region that is entered refutes nothing.",)
    _criterion = "the circle criterion"
    _drawn = ("lower", "k")

    @property
    def disc(self) -> tuple[float, float] | None:
        """The ends of the disc on the real axis, ascending; None where the region is a half-plane, or there is none."""
        if self.k is None or self.lower == 0 or self.k == 0:
            return None
        return min(-1.0 / self.lower, -1.0 / self.k), max(-1.0 / self.lower, -1.0 / self.k)

    @property
    def inside(self) -> bool:
        """Whether the curve belongs inside the disc: ``lower < 0 < k``."""
        return self.k is not None and self.lower < 0 < self.k

    @property
    @derived("1", dims="omega")
    def distance(self) -> NDArray[np.float64]:
        """(m,) distance of each point from the forbidden region, negative inside it; nan where there is none."""
        if self.k is None:
            return np.full(self.omega.size, np.nan)
        ends = self.disc
        if ends is None:
            return 1.0 / self.k + self.values.real if self.lower == 0 else -1.0 / self.lower - self.values.real
        radius = 0.5 * (ends[1] - ends[0])
        outwards = np.abs(self.values - 0.5 * (ends[0] + ends[1])) - radius
        return -outwards if self.inside else outwards

    @property
    def distances(self) -> NDArray[np.float64]:
        """(m,) ``distance``."""
        return self.distance

    @property
    def sector_text(self) -> str:
        """The sector, for people, never larger than it is."""
        if self.k is None:
            return "none"
        bracket = ")" if self.k == math.inf and self.answer is None else "]"
        return f"[{text_above(self.lower)}, {text_below(self.k)}{bracket}"

    def __str__(self) -> str:
        head = f"Nyquist plot of {block_text(self.block)}, {span_text(self.omega)}"
        if self.k is None or self.margin_seen is None:
            return f"{head}, without a region. A drawing proves nothing; {self.supporting_proof}."
        seen = self._seen(self.margin_seen)
        return f"{head}: {seen} (observed). The drawing proves nothing; {self.supporting_proof}."

    def _seen(self, margin: float) -> str:
        size = float(np.max(np.abs(self.values[np.isfinite(self.values)])))
        region = f"the region forbidden for the sector {self.sector_text}"
        if abs(margin) <= ROUNDING * size:
            return f"the curve touches {region}, to rounding"
        if margin > 0:
            return f"the curve keeps at least {margin:.4g} away from {region}"
        return f"the curve goes {-margin:.4g} deep into {region}"


Region = tuple["float | Fraction | None", "StabilityBound | None", "CriterionResult | None", str]


def nyquist_response(
    system: object, *, k: Exact | None = None, lower: Exact = 0, omega: ArrayLike | None = None
) -> NyquistResponse:
    r"""The Nyquist plot of a loop with the region that the circle criterion forbids for a sector ``[lower, k]``.

    For ``mu = -phi(t, sigma)``, ``sigma = H mu``, in continuous or discrete time.  Without ``k`` the sector is the
    largest that ``max_sector(system, criterion="circle", lower=lower)`` proves; for matrices too large for exact
    coefficients and for measured data, the largest that the points drawn allow, which is observed and proves nothing.

    Parameters
    ----------
    system : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        Whatever :func:`lure.as_plant` takes, a ``StructuredPlant`` such as a rod, or a loop, whose block it is then.
    k : int, float, Fraction or Decimal, optional
        Upper end of the sector, above ``lower``; may be ``inf``.
    lower : int, float, Fraction or Decimal
        Lower end of the sector, finite, of either sign.
    omega : array_like, optional
        (m,) positive, increasing frequencies [rad/s]; by default a grid refined around every resonance.

    Returns
    -------
    NyquistResponse
        With ``plot()``, ``margin_seen`` (OBSERVED) and, in ``answer`` or ``found``, what is proved.

    Raises
    ------
    InputError
        The block or a number is no good.

    Notes
    -----
    The drawing decides nothing: the criterion is decided at every frequency, encirclements with it, by exact root
    counts, without it.

    Examples
    --------
    >>> response = nyquist_response("4/((s-1)*(s/3+1))", lower=0.5, k=1)
    >>> print(response.answer.verdict, response.evidence, response.margin_seen > 0)
    PROVED observed True
    """
    block = drawable(system)
    least = exact_number(lower, "lower")
    end = None if k is None else upper_end(k, least)
    at, values = axis_values(block, omega)
    used, found, answer, reason = _largest(block, values, least) if end is None else _asked(block, end, least)
    return NyquistResponse(
        block=block,
        omega=at,
        values=values,
        lower=double_above(least),
        k=double_below(used) if isinstance(used, Fraction) else used,
        found=found,
        answer=answer,
        reason=reason,
    )


def _largest(block: Drawable, values: NDArray[np.complex128], lower: Fraction) -> Region:
    """The largest sector that the circle criterion proves, or, for what nothing can be proved of, that is seen."""
    try:
        found = max_sector(block, criterion="circle", lower=lower, time_varying=True)
    except AssumptionError as refusal:
        return None, None, None, str(refusal)
    if found.verdict is Verdict.PROVED:
        return found.largest.low, found, None, ""
    if isinstance(block, StateSpace | FrequencyData) and lower == 0:
        least = float(np.min(values.real[np.isfinite(values)], initial=math.inf))
        return -1.0 / least if least < 0 else math.inf, found, None, found.reason
    return None, found, None, found.reason or str(found)


def _asked(block: Drawable, k: float | Fraction, lower: Fraction) -> Region:
    """A sector asked about, with the criterion's word on it."""
    try:
        if isinstance(block, RationalPlant | StructuredPlant):
            answer, reason = criterion_asked(block, "circle", Sector(lower, k))
            return k, None, answer, reason
        found = max_sector(block, criterion="circle", lower=lower, time_varying=True)
    except (AssumptionError, InputError) as refusal:
        return k, None, None, str(refusal)
    if found.verdict is Verdict.PROVED and k <= found.largest.low:
        return k, found, None, ""
    return k, found, None, f"this sector was not decided. Of the loop is known: {found}"

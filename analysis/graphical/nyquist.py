"""``nyquist_response``: the Nyquist plot of a loop, the region of the circle criterion, and what stands behind it."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.answer import Answer
from analysis.answers import Largest, max_sector
from analysis.criteria.circle import circle_criterion
from analysis.criteria.popov import circle_criterion as rod_circle_criterion
from analysis.criteria.result import CriterionResult
from analysis.doubles import double_above, double_below
from analysis.evidence import Verdict
from analysis.graphical.axis import Drawable, axis_values, drawable
from analysis.graphical.page import ROD, upper_end
from lure.errors import AssumptionError, InputError
from lure.exact import Exact, exact_number
from lure.frequency_data import FrequencyData
from lure.rational import RationalBlock
from lure.sector import Sector
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

if TYPE_CHECKING:
    pass
from analysis.graphical.nyquist_result import NyquistResponse

Region = tuple["float | Fraction | None", "Largest | None", "Answer | CriterionResult | None", str]


def nyquist_response(
    system: object, *, k: Exact | None = None, lower: Exact = 0, omega: ArrayLike | None = None
) -> NyquistResponse:
    r"""The Nyquist plot of a loop with the region that the circle criterion forbids for a sector ``[lower, k]``.

    For ``mu = -phi(t, sigma)``, ``sigma = H mu``, in continuous or discrete time.  Without ``k`` the sector is the
    largest that ``max_sector(system, criterion="circle", lower=lower)`` proves; for matrices too large for exact
    coefficients and for measured data, the largest that the points drawn allow, which is observed and proves nothing.

    Parameters
    ----------
    system : RationalBlock, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        Whatever :func:`lure.as_block` takes, an ``UpwindScheme`` or ``RodBlock``, or a loop, whose block it is then.
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
    if isinstance(block, StateSpaceBlock | FrequencyData) and lower == 0:
        least = float(np.min(values.real[np.isfinite(values)], initial=math.inf))
        return -1.0 / least if least < 0 else math.inf, found, None, found.reason
    return None, found, None, found.reason or str(found)


def _asked(block: Drawable, k: float | Fraction, lower: Fraction) -> Region:
    """A sector asked about, with the criterion's word on it."""
    try:
        if isinstance(block, RationalBlock | UpwindScheme | RodBlock):
            sector = Sector(lower, k)
            answer: Answer | CriterionResult = (
                circle_criterion(block, sector)
                if isinstance(block, RationalBlock)
                else rod_circle_criterion(block, sector)
            )
            reason = "" if answer.verdict is Verdict.PROVED else answer.reason
            return k, None, answer, ROD if isinstance(block, RodBlock) else reason
        found = max_sector(block, criterion="circle", lower=lower, time_varying=True)
    except (AssumptionError, InputError) as refusal:
        return k, None, None, str(refusal)
    if found.verdict is Verdict.PROVED and k <= found.largest.low:
        return k, found, None, ""
    return k, found, None, f"this sector was not decided. Of the loop is known: {found}"

"""``popov_response``: the Popov plot of a loop, its line, and what stands behind the line."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.answer import Answer
from analysis.answers import Largest, max_sector
from analysis.criteria.popov import popov_criterion
from analysis.criteria.result import CriterionResult
from analysis.doubles import double_below
from analysis.evidence import Verdict
from analysis.graphical.axis import Drawable, axis_values, continuous, drawable
from analysis.graphical.page import ROD, upper_end
from analysis.graphical.theta import searched_theta
from lure.errors import AssumptionError, InputError
from lure.exact import Exact, exact_number
from lure.frequency_data import FrequencyData
from lure.rational import RationalBlock
from lure.sector import Sector
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

if TYPE_CHECKING:
    pass
from analysis.graphical.popov_result import PopovResponse

Line = tuple["float | Fraction | None", "float | None", "Largest | None", "Answer | CriterionResult | None", str]


def popov_response(
    system: object, *, k: Exact | None = None, theta: Exact | None = None, omega: ArrayLike | None = None
) -> PopovResponse:
    r"""The Popov plot of a loop with the line of a sector ``[0, k]``, ready to be drawn.

    For ``mu = -phi(sigma)``, ``sigma = H mu``.  Without ``k`` the line is that of the largest sector that
    ``max_sector(system, criterion="popov")`` proves (or computes, for a block that nothing can be certified of).
    With ``k`` alone a multiplier is searched for it; with ``theta`` alone the largest ``k`` for this ``theta``.

    Parameters
    ----------
    system : RationalBlock, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        Whatever :func:`lure.as_block` takes, an ``UpwindScheme`` or ``RodBlock``, or a loop, whose block it is then.
    k : int, float, Fraction or Decimal, optional
        Upper end of the sector, positive; ``inf`` for a line through 0.
    theta : int, float, Fraction or Decimal, optional
        Multiplier [s], finite: the slope of the line is ``1/theta``.
    omega : array_like, optional
        (m,) positive, increasing frequencies [rad/s]; by default a grid refined around every resonance.

    Returns
    -------
    PopovResponse
        With ``plot()``, ``margin_seen`` (OBSERVED) and, in ``answer`` or ``found``, what is proved.

    Raises
    ------
    InputError
        The block or a number is no good.
    AssumptionError
        The block is in discrete time, which has no Popov plot.

    Notes
    -----
    The drawing decides nothing: the criterion is decided at every frequency, by exact root counts, without it.

    Examples
    --------
    >>> response = popov_response("1/(s*(s+1)*(s+2))", k=5)
    >>> print(response.answer.verdict, response.evidence, response.margin_seen > 0)
    PROVED observed True
    """
    block = drawable(system)
    if not continuous(block):
        raise AssumptionError(
            "a Popov plot needs continuous time, and this block is in discrete time; draw nyquist_response(system), "
            "and ask max_sector(system) or, for laws with bounded slope, max_slope(system, criterion='tsypkin')"
        )
    end = None if k is None else upper_end(k, Fraction(0))
    given = None if theta is None else exact_number(theta, "theta")
    at, values = axis_values(block, omega)
    used, multiplier, found, answer, reason = _line(block, (at, values), end, given)
    return PopovResponse(
        block=block,
        omega=at,
        values=values,
        k=double_below(used) if isinstance(used, Fraction) else used,
        theta=multiplier,
        found=found,
        answer=answer,
        reason=reason,
    )


def _line(
    block: Drawable,
    seen: tuple[NDArray[np.float64], NDArray[np.complex128]],
    k: float | Fraction | None,
    theta: Fraction | None,
) -> Line:
    """``k``, ``theta``, what they rest on, and why on nothing."""
    if k is None and theta is None:
        return _largest(block, seen)
    if k is None:
        assert theta is not None
        k = _reach(block, seen, theta)
    if isinstance(block, RationalBlock | UpwindScheme | RodBlock):
        return _asked(block, seen, k, theta)
    own = None if theta is None else float(theta)
    try:
        found = max_sector(block, criterion="popov")
    except AssumptionError as refusal:
        return k, own if own is not None else _searched(seen, float(k)), None, None, str(refusal)
    if own is None and found.theta is not None and found.lower < k <= found.largest.low:
        return k, found.theta, found, None, "" if found.verdict is Verdict.PROVED else found.reason
    used = own if own is not None else _searched(seen, float(k))
    same = own is not None and own == found.theta and found.verdict is Verdict.PROVED and k <= found.largest.low
    return k, used, found, None, "" if same else f"this line was not decided. Of the loop is known: {found}"


def _largest(block: Drawable, seen: tuple[NDArray[np.float64], NDArray[np.complex128]]) -> Line:
    """The line of the largest sector that Popov's criterion reaches."""
    try:
        found = max_sector(block, criterion="popov")
    except AssumptionError as refusal:
        return None, None, None, None, str(refusal)
    if isinstance(block, FrequencyData):
        k = found.largest.high
        return k, _searched(seen, k), found, None, found.reason
    if not (found.largest.low > found.lower and (found.verdict is Verdict.PROVED or found.theta is not None)):
        return None, None, found, None, found.reason or str(found)
    k, theta = found.largest.low, found.theta
    if theta is None or not math.isfinite(theta):
        theta = _searched(seen, k)
    return k, theta, found, None, "" if found.verdict is Verdict.PROVED else found.reason


def _asked(
    block: RationalBlock | UpwindScheme | RodBlock,
    seen: tuple[NDArray[np.float64], NDArray[np.complex128]],
    k: float | Fraction,
    theta: Fraction | None,
) -> Line:
    """The line of a sector asked about, with the criterion's word on it."""
    own = None if theta is None else float(theta)
    try:
        answer: Answer | CriterionResult = popov_criterion(block, Sector(0, k), theta=theta)  # type: ignore[arg-type]
    except (AssumptionError, InputError) as refusal:
        return k, own if own is not None else _searched(seen, float(k)), None, None, str(refusal)
    reason = "" if answer.verdict is Verdict.PROVED else answer.reason
    if isinstance(block, RodBlock):
        reason = ROD
    used = own if own is not None else answer.theta if answer.verdict is Verdict.PROVED else None
    if used is None or not math.isfinite(used):
        used = _searched(seen, float(k))
    return k, used, None, answer, reason


def _searched(seen: tuple[NDArray[np.float64], NDArray[np.complex128]], k: float) -> float:
    omega, values = seen
    good = np.isfinite(values)
    return searched_theta(values.real[good], (omega * values.imag)[good], k) if good.any() else 0.0


def _reach(
    block: Drawable, seen: tuple[NDArray[np.float64], NDArray[np.complex128]], theta: Fraction
) -> float | Fraction:
    """The ``k`` of the line of slope ``1/theta`` just short of the curve: of the whole of it, where that is decided."""
    if isinstance(block, RationalBlock):
        try:
            margin = popov_criterion(block, Sector(0, math.inf), theta=theta).margin
        except (AssumptionError, InputError):
            margin = None
        if margin is not None and math.isfinite(margin.low):
            return -(1 - 1e-9) / margin.low if margin.low < 0 else math.inf
    omega, values = seen
    expression = values.real - float(theta) * omega * values.imag
    least = float(np.min(expression[np.isfinite(expression)], initial=math.inf))
    return -1.0 / least if least < 0 else math.inf

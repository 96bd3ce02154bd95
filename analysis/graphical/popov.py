"""``popov_response``: the Popov plot of a loop, its line, and what stands behind the line."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.graphical.axis import Drawable, axis_values, continuous, drawable
from lure.analysis.graphical.supporting_proof import (
    ROUNDING,
    Drawn,
    block_text,
    criterion_asked,
    searched_theta,
    span_text,
    upper_end,
)
from lure.analysis.numerics.doubles import double_below, text_below
from lure.analysis.questions import StabilityBound, max_sector
from lure.analysis.theorems.popov import popov_criterion
from lure.analysis.verdict import CriterionResult, Verdict
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.exact import Exact, exact_number
from lure.plants.block import StructuredPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.record import derived, quantity

# What a Popov plot shows, and what stands behind it.


class PopovResponse(Drawn):
    r"""A curve ``(Re H, omega Im H)``, the Popov line beside it, and what proves the sector of the line, if anything.

    For ``mu = -phi(sigma)``, ``sigma = H mu`` and the sector ``[0, k]`` the line ``Re H = theta omega Im H - 1/k``
    passes through ``-1/k`` with slope ``1/theta``; the criterion asks that the whole curve lie to its right.  The curve
    here is finitely many points: OBSERVED, whatever it looks like.
    """

    theta: float | None = quantity("Multiplier of the line", "s")
    _kind = "popov response"
    _title = "Popov plot"
    _notes = ("A drawing proves nothing between and beyond its points, and a line that is crossed refutes nothing.",)
    _criterion = "Popov's criterion"
    _drawn = ("k", "theta")

    @property
    @derived("1", dims="omega")
    def omega_imag(self) -> NDArray[np.float64]:
        """(m,) omega Im H."""
        return self.omega * self.values.imag

    @property
    @derived("1", dims="omega")
    def expression(self) -> NDArray[np.float64]:
        """(m,) ``1/k + Re[(1 + i omega theta) H]``, the distance of each point from the line along the real axis."""
        if self.k is None or self.theta is None:
            return np.full(self.omega.size, np.nan)
        return 1.0 / self.k + self.values.real - self.theta * self.omega * self.values.imag

    @property
    def distances(self) -> NDArray[np.float64]:
        """(m,) ``expression``."""
        return self.expression

    @property
    def sector_text(self) -> str:
        """The sector of the line, for people, never larger than it is."""
        if self.k is None:
            return "none"
        return f"[0, {text_below(self.k)}{')' if self.k == math.inf and self.answer is None else ']'}"

    def __str__(self) -> str:
        head = f"Popov plot of {block_text(self.block)}, {span_text(self.omega)}"
        if self.k is None or self.theta is None:
            return f"{head}, without a line. A drawing proves nothing; {self.supporting_proof}."
        return f"{head}: {self._seen()} (observed). The drawing proves nothing; {self.supporting_proof}."

    def _seen(self) -> str:
        assert self.k is not None
        assert self.theta is not None
        line = f"the line through {-1.0 / self.k + 0.0:.6g} with theta = {self.theta:.6g} s"
        if self.margin_seen is None:
            return f"no point is finite beside {line}"
        x, y = self.values.real, self.theta * self.omega * self.values.imag
        size = float(np.nanmax(np.where(np.isfinite(x) & np.isfinite(y), np.abs(x) + np.abs(y), 0.0)))
        if abs(self.margin_seen) <= ROUNDING * size:
            return f"the curve touches {line}, to rounding"
        where = "to the right of" if self.margin_seen > 0 else "on the wrong side of"
        verb = "keeps at least" if self.margin_seen > 0 else "comes as far as"
        return f"the curve {verb} {abs(self.margin_seen):.4g} {where} {line}"

    def _region(self) -> Iterator[tuple[object, ...]]:
        if self.k is not None and self.theta is not None:
            yield "sector of the line", self.sector_text
            yield "theta", f"{self.theta:.10g} s"


Line = tuple["float | Fraction | None", "float | None", "StabilityBound | None", "CriterionResult | None", str]


def popov_response(
    system: object, *, k: Exact | None = None, theta: Exact | None = None, omega: ArrayLike | None = None
) -> PopovResponse:
    r"""The Popov plot of a loop with the line of a sector ``[0, k]``, ready to be drawn.

    For ``mu = -phi(sigma)``, ``sigma = H mu``.  Without ``k`` the line is that of the largest sector that
    ``max_sector(system, criterion="popov")`` proves (or computes, for a block that nothing can be certified of).
    With ``k`` alone a multiplier is searched for it; with ``theta`` alone the largest ``k`` for this ``theta``.

    Parameters
    ----------
    system : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        Whatever :func:`lure.as_plant` takes, a ``StructuredPlant`` such as a rod, or a loop, whose block it is then.
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
            "and ask max_sector(system) or, for nonlinearities with bounded slope, max_slope(system, "
            "criterion='tsypkin')"
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
        k = _upper_end(block, seen, theta)
    if isinstance(block, RationalPlant | StructuredPlant):
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
    block: RationalPlant | StructuredPlant,
    seen: tuple[NDArray[np.float64], NDArray[np.complex128]],
    k: float | Fraction,
    theta: Fraction | None,
) -> Line:
    """The line of a sector asked about, with the criterion's word on it."""
    own = None if theta is None else float(theta)
    try:
        answer, reason = criterion_asked(block, "popov", Sector(0, k), theta)
    except (AssumptionError, InputError) as refusal:
        return k, own if own is not None else _searched(seen, float(k)), None, None, str(refusal)
    used = own if own is not None else answer.theta if answer.verdict is Verdict.PROVED else None
    if used is None or not math.isfinite(used):
        used = _searched(seen, float(k))
    return k, used, None, answer, reason


def _searched(seen: tuple[NDArray[np.float64], NDArray[np.complex128]], k: float) -> float:
    omega, values = seen
    good = np.isfinite(values)
    return searched_theta(values.real[good], (omega * values.imag)[good], k) if good.any() else 0.0


def _upper_end(
    block: Drawable, seen: tuple[NDArray[np.float64], NDArray[np.complex128]], theta: Fraction
) -> float | Fraction:
    """The ``k`` of the line of slope ``1/theta`` just short of the curve: of the whole of it, where that is decided."""
    if isinstance(block, RationalPlant):
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

"""Assertions about a nonlinearity for tests: its sector, its slope, oddness and monotony."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from os import PathLike
from pathlib import Path
from typing import ParamSpec

from lure.analysis.testing.decisions import Decision, decided, witness
from lure.analysis.testing.result import HISTORY, Checked, NonlinearityViolation, Violation
from lure.analysis.testing.search import (
    Domain,
    Kind,
    Limits,
    Measure,
    NotANumber,
    Subject,
    Worst,
    domain,
    rounding,
    simplest,
    subject,
    worst,
)
from lure.analysis.verdict import Evidence, Verdict
from lure.arrays import np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError, demand_whole
from lure.exact import Exact
from lure.record.values import exact_text

_QUANTITIES = {
    "sector": "phi(sigma)/sigma",
    "slope": "the slope from sigma to sigma",
    "odd": "phi(sigma) + phi(-sigma)",
}
_FEWEST = 50
P = ParamSpec("P")


@dataclass(frozen=True, kw_only=True, slots=True)
class Search:
    """Where and how closely a nonlinearity is looked at; see :func:`lure.analysis.testing.assert_in_sector`."""

    on: tuple[Exact, Exact] | None
    samples: int
    breakpoints: tuple[float, ...]
    plot: str | PathLike[str] | None

    def __post_init__(self) -> None:
        demand_whole("samples", self.samples, _FEWEST)
        if self.plot is not None and Path(self.plot).suffix not in (".png", ".svg"):
            raise InputError(f"plot is {str(self.plot)!r:.60}; give a file name that ends in .png or .svg")


@dataclass(frozen=True, kw_only=True, slots=True)
class Inquiry:
    """What is asserted of a nonlinearity; ``words`` say that it is so, and that it is not."""

    kind: Kind
    words: tuple[str, str]
    limits: Limits
    search: Search


def run(phi: object, inquiry: Inquiry) -> Checked:
    """Answer, or raise; ``phi``: the nonlinearity, as :func:`lure.analysis.testing.search.subject` takes it.

    Raises
    ------
    NonlinearityViolation
        The nonlinearity does not have the property, or no value somewhere.
    InputError
        Something is not as described.
    """
    where, nonlinearity = domain(inquiry.search.on), subject(phi)
    try:
        known = decided(nonlinearity, inquiry.kind, inquiry.limits, where.given) if nonlinearity.known else Decision()
        violation = None
        if known.verdict is not Verdict.PROVED:
            violation = _found(nonlinearity, inquiry, where, known)
    except NotANumber as error:
        raise NonlinearityViolation(_no_value(nonlinearity, inquiry, error)) from None
    if violation is not None:
        if inquiry.search.plot is not None:
            violation.save(Path(inquiry.search.plot))
        raise NonlinearityViolation(violation.message(), violation)
    if known.verdict is Verdict.REFUTED:
        exact = "" if inquiry.kind == "odd" else witness(nonlinearity, inquiry.kind, inquiry.limits, where.given)
        raise NonlinearityViolation(
            f"{nonlinearity.name} {inquiry.words[1]}: {exact or known.how}, though doubles do not show it"
        )
    checked = _passed(nonlinearity, inquiry, where, known)
    HISTORY.add(checked)
    return checked


def _passed(phi: Subject, inquiry: Inquiry, where: Domain, known: Decision) -> Checked:
    slack = inquiry.limits.tolerance
    claim = f"{_claim(phi, inquiry)}, to within {slack:g}" if slack else _claim(phi, inquiry)
    if known.verdict is Verdict.PROVED:
        return Checked(claim=claim, evidence=Evidence.CERTIFIED, how=known.how, points=phi.evaluations)
    how = f"no violation among {phi.evaluations} values on {where}"
    how += f"; {known.how}" if known.how else ""
    return Checked(claim=claim, evidence=Evidence.OBSERVED, how=how, points=phi.evaluations)


def _claim(phi: Subject, inquiry: Inquiry) -> str:
    return f"{phi.name} {inquiry.words[0]}"


def _found(phi: Subject, inquiry: Inquiry, where: Domain, known: Decision) -> Violation | None:
    """The violation, at the simplest numbers that show it; None if there is none."""
    x = where.points(inquiry.search.samples, (*phi.breakpoints, *inquiry.search.breakpoints))
    if known.total:
        x = x[np.isfinite(phi.anyhow(x))]  # floating point may overflow where the nonlinearity does not
    noise = rounding(phi, x, where)
    if inquiry.kind == "odd":
        x = x[(-x >= where.low) & (-x <= where.high) & (x > 0)]
        if x.size == 0:
            raise InputError(f"on is {where}; oddness is about sigma and -sigma: give an interval with 0 inside")
    elif inquiry.kind == "sector":
        if where.holds(0.0) and abs(phi.at(0.0)) > noise:
            return _violation(inquiry, phi, (0.0,), np.inf, (where, known))
        x = x[x != 0]
    measure = Measure(kind=inquiry.kind, subject=phi, limits=inquiry.limits, noise=noise)
    found = worst(measure, x)
    if found[0] <= 0:
        return None

    def excess(sigma: tuple[float, ...]) -> float:
        """How far a point or a pair violates; nothing is asserted outside the interval, nor of a chord to 0."""
        asserted = sigma[0] < sigma[1] if len(sigma) == 2 else sigma[0] != 0
        mirrored = [-part for part in sigma] if inquiry.kind == "odd" else []
        if not asserted or not all(map(where.holds, (*sigma, *mirrored))):
            return -np.inf
        try:
            return float(measure.look(np.array(sigma))[1][0])
        except NotANumber:
            return -np.inf

    sigma = simplest(excess, found, size=inquiry.limits.size, unit=where.unit)
    value = float(measure.look(np.array(sigma))[0][0])
    return _violation(inquiry, phi, sigma, value, (where, known), found)


def _violation(  # noqa: PLR0913  (what was found where, and what else is known)
    inquiry: Inquiry,
    phi: Subject,
    sigma: tuple[float, ...],
    found: float,
    context: tuple[Domain, Decision],
    worst: Worst | None = None,
) -> Violation:
    where, known = context
    how = f"Found in floating point, by a search of {phi.evaluations} values on {where}."
    if worst is not None and worst[1] != sigma:
        places = " and ".join(exact_text(sigma, 12) for sigma in worst[1])
        how += f" The search began to shrink it from sigma = {places}."
    if known.verdict is Verdict.REFUTED:
        how += f" {known.how[0].upper()}{known.how[1:]} ({Evidence.CERTIFIED})."
    return Violation(
        kind=inquiry.kind,
        name=phi.name,
        claim=_claim(phi, inquiry),
        denial=f"{phi.name} {inquiry.words[1]}",
        quantity=_QUANTITIES[inquiry.kind] if inquiry.kind != "slope" else "the slope of the chord",
        sigma=sigma,
        phi=tuple(phi.at(point) for point in sigma),
        found=found,
        lower=inquiry.limits.lower,
        upper=inquiry.limits.upper,
        tolerance=inquiry.limits.tolerance,
        slope=_slope(phi, sigma[0]) if inquiry.kind != "slope" else np.nan,
        on=(where.low, where.high),
        how=how,
        subject=phi,
    )


def _slope(phi: Subject, sigma: float) -> float:
    """A central difference quotient, nan where there is none: at a jump and at a corner the two sides differ."""
    step = 1e-5 * (abs(sigma) or 1e-3)
    try:
        here = phi.at(sigma)
        left, right = (here - phi.at(sigma - step)) / step, (phi.at(sigma + step) - here) / step
    except NotANumber:
        return float(np.nan)
    curved = 0.1 * max(abs(left), abs(right)) + 1e-3 * abs(here / (sigma or 1.0))
    return 0.5 * (left + right) if abs(right - left) <= curved else float(np.nan)


def _no_value(phi: Subject, inquiry: Inquiry, error: NotANumber) -> str:
    where = domain(inquiry.search.on)

    def missing(place: tuple[float, ...]) -> float:
        """1 where the nonlinearity has no value, 0 where it has or where nothing is asserted."""
        try:
            phi.at(place[0])
        except NotANumber:
            return float(where.holds(place[0]))
        return 0.0

    (sigma,) = simplest(missing, (1.0, (error.sigma,)), size=1.0, unit=where.unit)
    try:
        phi.at(sigma)
    except NotANumber as simpler:
        error = simpler
    return (
        f"it was not tested whether {_claim(phi, inquiry)}: phi({exact_text(error.sigma, 12)}) {error}, and a "
        "nonlinearity is a function of one number with a finite real value everywhere"
    ) + ("; name the interval on which this one has, on=(low, high)" if error.elsewhere else "")


def _told_where_called(assertion: Callable[P, Checked]) -> Callable[P, Checked]:
    """An assertion of whose failures and refusals pytest shows the line of the test, and no frame of ours."""

    @wraps(assertion)
    def asserted(*args: P.args, **kwargs: P.kwargs) -> Checked:
        """The assertion itself."""
        __tracebackhide__ = True
        try:
            return assertion(*args, **kwargs)
        except (InputError, NonlinearityViolation) as error:
            raise error.with_traceback(None) from None

    return asserted


@_told_where_called
def assert_in_sector(  # noqa: PLR0913  (the nonlinearity, the sector, and settings with defaults, all by name)
    phi: object,
    sector: Sector,
    *,
    on: tuple[Exact, Exact] | None = None,
    tolerance: float = 0.0,
    samples: int = 4000,
    breakpoints: Sequence[float] = (),
    plot: str | PathLike[str] | None = None,
) -> Checked:
    r"""Demand ``lower sigma^2 <= sigma phi(sigma) <= upper sigma^2``, and ``phi(0) = 0``.

    Parameters
    ----------
    phi : callable, nonlinearity of lure.nonlinearities, Expression or str
        The nonlinearity; a text is a formula in ``sigma`` or ``x``.
    sector : Sector
        What is asserted [unit of phi / unit of sigma].
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        How far ``phi(sigma)/sigma`` may lie outside, not negative [unit of phi / unit of sigma].
    samples : int
        With how many points the search begins, at least 50; it adds points of its own where the nonlinearity is worst.
    breakpoints : sequence of float
        Where the nonlinearity changes its formula, as far as you know: the search looks at them and near them.
    plot : path or None
        A file, ``.png`` or ``.svg``, for a plot if the nonlinearity leaves the sector; one that exists is replaced.

    Returns
    -------
    Checked
        What the pass rests on: ``.evidence`` is CERTIFIED for formulas and nonlinearities of the library that could be
        decided for every ``sigma``, and OBSERVED for anything else.  It proves nothing of points between.

    Raises
    ------
    NonlinearityViolation
        An AssertionError: the nonlinearity leaves the sector, at the point named, or has no value somewhere.
    InputError
        An argument is not as described.

    Notes
    -----
    A callable is judged as it is in floating point: a ratio counts as outside if it is so by more than 1e-12 of its
    size, plus what rounding near 0 can make: 4e-15 of the largest ``|phi|`` for ``|sigma| <= 1``, over ``|sigma|``.
    For one that returns single precision both are ``2^29`` times larger.

    Examples
    --------
    >>> import numpy as np
    >>> print(assert_in_sector(np.tanh, Sector(0, 1), on=(-20, 20)).evidence)
    observed
    """
    _demand(sector, Sector, "sector")
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    words = (f"lies in the sector {sector}", f"leaves the sector {sector}")
    limits = Limits(lower=sector.lower, upper=sector.upper, tolerance=_slack(tolerance))
    return run(phi, Inquiry(kind="sector", words=words, limits=limits, search=search))


@_told_where_called
def assert_slope_restricted(  # noqa: PLR0913  (as above)
    phi: object,
    slope: SlopeBounds,
    *,
    on: tuple[Exact, Exact] | None = None,
    tolerance: float = 0.0,
    samples: int = 4000,
    breakpoints: Sequence[float] = (),
    plot: str | PathLike[str] | None = None,
) -> Checked:
    r"""Demand ``lower <= (phi(x) - phi(y))/(x - y) <= upper`` for every ``x != y``.

    Parameters
    ----------
    phi : callable, nonlinearity of lure.nonlinearities, Expression or str
        The nonlinearity.
    slope : SlopeBounds
        What is asserted [unit of phi / unit of sigma].
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        How far a quotient may lie outside, not negative [unit of phi / unit of sigma].
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the nonlinearity changes its formula.
    plot : path or None
        A file for a plot of the nonlinearity if it fails.

    Returns
    -------
    Checked
        What the pass rests on, as for :func:`assert_in_sector`.

    Raises
    ------
    NonlinearityViolation
        A pair of points whose quotient lies outside, or the nonlinearity has no value somewhere.
    InputError
        An argument is not as described.

    Notes
    -----
    Pairs closer than about ``1e-7 |sigma|`` are not looked at: rounding would speak.

    Examples
    --------
    >>> from lure import SlopeBounds
    >>> print(assert_slope_restricted("tanh(sigma) + sigma/3", SlopeBounds(0, 2)).evidence)
    certified
    """
    _demand(slope, SlopeBounds, "slope")
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    words = (f"has its slopes in {slope}", f"leaves the slope bounds {slope}")
    limits = Limits(lower=slope.lower, upper=slope.upper, tolerance=_slack(tolerance))
    return run(phi, Inquiry(kind="slope", words=words, limits=limits, search=search))


@_told_where_called
def assert_monotone(  # noqa: PLR0913  (as above)
    phi: object,
    *,
    on: tuple[Exact, Exact] | None = None,
    tolerance: float = 0.0,
    samples: int = 4000,
    breakpoints: Sequence[float] = (),
    plot: str | PathLike[str] | None = None,
) -> Checked:
    """Demand ``phi(x) <= phi(y)`` for every ``x < y``: slopes in ``[0, inf]``.

    Parameters
    ----------
    phi : callable, nonlinearity of lure.nonlinearities, Expression or str
        The nonlinearity.
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        By how much a slope may be negative, not negative itself.
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the nonlinearity changes its formula.
    plot : path or None
        A file for a plot of the nonlinearity if it fails.

    Returns
    -------
    Checked
        What the pass rests on, as for :func:`assert_in_sector`.

    Raises
    ------
    NonlinearityViolation
        A pair of points between which the nonlinearity falls, or it has no value somewhere.
    InputError
        An argument is not as described.
    """
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    limits = Limits(lower=0, upper=math.inf, tolerance=_slack(tolerance))
    words = ("is nondecreasing", "is not nondecreasing")
    return run(phi, Inquiry(kind="slope", words=words, limits=limits, search=search))


@_told_where_called
def assert_odd(  # noqa: PLR0913  (as above)
    phi: object,
    *,
    on: tuple[Exact, Exact] | None = None,
    tolerance: float = 0.0,
    samples: int = 4000,
    breakpoints: Sequence[float] = (),
    plot: str | PathLike[str] | None = None,
) -> Checked:
    """Demand ``phi(-sigma) = -phi(sigma)``.

    Parameters
    ----------
    phi : callable, nonlinearity of lure.nonlinearities, Expression or str
        The nonlinearity.
    on : (low, high) or None
        Where it is asserted, with 0 inside: for ``|sigma| <= min(-low, high)``; None for all of R.
    tolerance : float
        How far ``phi(sigma) + phi(-sigma)`` may be from 0, not negative [unit of phi].
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the nonlinearity changes its formula.
    plot : path or None
        A file for a plot of the nonlinearity if it fails.

    Returns
    -------
    Checked
        What the pass rests on.

    Raises
    ------
    NonlinearityViolation
        A point at which the nonlinearity is not odd, or has no value.
    InputError
        An argument is not as described.

    Examples
    --------
    >>> print(assert_odd("sigma**3").evidence)
    certified
    """
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    limits = Limits(lower=0, upper=0, tolerance=_slack(tolerance))
    return run(phi, Inquiry(kind="odd", words=("is odd", "is not odd"), limits=limits, search=search))


def _demand(value: object, kind: type, name: str) -> None:
    if not isinstance(value, kind):
        raise InputError(f"{name} is {value!r:.60}; give a {kind.__name__}, as in {kind.__name__}(0, 2)")


def _slack(tolerance: float) -> float:
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 0 <= tolerance < math.inf:
        raise InputError(f"tolerance is {tolerance!r:.60}; give a number of at least 0")
    return float(tolerance)

"""Assertions about a law for tests: its sector, its slope, oddness and monotony."""

from __future__ import annotations

import math
from collections.abc import Sequence
from os import PathLike

from lure.analysis.testing.inquiry import Inquiry, Search, run
from lure.analysis.testing.result import Checked
from lure.analysis.testing.search import Limits
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import Exact


def assert_in_sector(  # noqa: PLR0913  (the law, the sector, and settings with defaults, all by name)
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
    phi : callable, law of lure.nonlinearities, Expression or str
        The law; a text is a formula in ``sigma`` or ``x``.
    sector : Sector
        What is asserted [unit of phi / unit of sigma].
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        How far ``phi(sigma)/sigma`` may lie outside, not negative [unit of phi / unit of sigma].
    samples : int
        With how many points the search begins, at least 50; it adds points of its own where the law is worst.
    breakpoints : sequence of float
        Where the law changes its formula, as far as you know: the search looks at them and near them.
    plot : path or None
        A file, ``.png`` or ``.svg``, for a plot of the law if it leaves the sector; one that exists is replaced.

    Returns
    -------
    Checked
        What the pass rests on: ``.evidence`` is CERTIFIED for formulas and laws of the library that could be decided
        for every ``sigma``, and OBSERVED for anything else.  An observed pass proves nothing of the points between.

    Raises
    ------
    NonlinearityViolation
        An AssertionError: the law leaves the sector, at the point named, or has no value somewhere.
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
    __tracebackhide__ = True
    _demand(sector, Sector, "sector")
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    words = (f"lies in the sector {sector}", f"leaves the sector {sector}")
    limits = Limits(lower=sector.lower, upper=sector.upper, tolerance=_slack(tolerance))
    return run(phi, Inquiry(kind="sector", words=words, limits=limits, search=search))


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
    phi : callable, law of lure.nonlinearities, Expression or str
        The law.
    slope : SlopeBounds
        What is asserted [unit of phi / unit of sigma].
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        How far a quotient may lie outside, not negative [unit of phi / unit of sigma].
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the law changes its formula.
    plot : path or None
        A file for a plot of the law if it fails.

    Returns
    -------
    Checked
        What the pass rests on, as for :func:`assert_in_sector`.

    Raises
    ------
    NonlinearityViolation
        A pair of points whose quotient lies outside, or the law has no value somewhere.
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
    __tracebackhide__ = True
    _demand(slope, SlopeBounds, "slope")
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    words = (f"has its slopes in {slope}", f"leaves the slope bounds {slope}")
    limits = Limits(lower=slope.lower, upper=slope.upper, tolerance=_slack(tolerance))
    return run(phi, Inquiry(kind="slope", words=words, limits=limits, search=search))


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
    phi : callable, law of lure.nonlinearities, Expression or str
        The law.
    on : (low, high) or None
        Where it is asserted; None for all of R.
    tolerance : float
        By how much a slope may be negative, not negative itself.
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the law changes its formula.
    plot : path or None
        A file for a plot of the law if it fails.

    Returns
    -------
    Checked
        What the pass rests on, as for :func:`assert_in_sector`.

    Raises
    ------
    NonlinearityViolation
        A pair of points between which the law falls, or it has no value somewhere.
    InputError
        An argument is not as described.
    """
    __tracebackhide__ = True
    search = Search(on=on, samples=samples, breakpoints=tuple(breakpoints), plot=plot)
    limits = Limits(lower=0, upper=math.inf, tolerance=_slack(tolerance))
    return run(
        phi, Inquiry(kind="slope", words=("is nondecreasing", "is not nondecreasing"), limits=limits, search=search)
    )


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
    phi : callable, law of lure.nonlinearities, Expression or str
        The law.
    on : (low, high) or None
        Where it is asserted, with 0 inside: for ``|sigma| <= min(-low, high)``; None for all of R.
    tolerance : float
        How far ``phi(sigma) + phi(-sigma)`` may be from 0, not negative [unit of phi].
    samples : int
        With how many points the search begins, at least 50.
    breakpoints : sequence of float
        Where the law changes its formula.
    plot : path or None
        A file for a plot of the law if it fails.

    Returns
    -------
    Checked
        What the pass rests on.

    Raises
    ------
    NonlinearityViolation
        A point at which the law is not odd, or has no value.
    InputError
        An argument is not as described.

    Examples
    --------
    >>> print(assert_odd("sigma**3").evidence)
    certified
    """
    __tracebackhide__ = True
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

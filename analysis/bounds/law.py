"""Sector and slope bounds of one law."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from analysis.bounds import blackbox, steps
from analysis.bounds.extremes import BITS, Candidate, End, largest, least
from analysis.bounds.gathering import cuts_of, over_pieces
from analysis.bounds.jets import value_at
from analysis.bounds.known import Known, Value, domain, known_law
from analysis.bounds.pieces import Piece
from analysis.bounds.rational import roots_between
from analysis.bounds.result import Extreme, LawBounds, short
from analysis.bounds.search import Effort
from analysis.bounds.slopes import slope_extremes
from analysis.evidence import Evidence
from analysis.precision import working_precision
from lure.errors import InputError
from lure.exact import exact_number
from lure.expressions.regularity import nature
from lure.laws import Quantiser

_TIGHT = Fraction(1, 10**9)


def law_bounds(
    law: object, *, on: object = None, lipschitz: float | Fraction | None = None, samples: int = 4001
) -> LawBounds:
    r"""Sector and slope bounds of a law, from both sides, with the places where they are attained.

    .. math:: \inf_{\sigma \ne 0} \phi(\sigma)/\sigma, \quad \sup_{\sigma \ne 0} \phi(\sigma)/\sigma, \quad
        \inf_{x \ne y} \frac{\phi(x) - \phi(y)}{x - y}, \quad \sup_{x \ne y} \frac{\phi(x) - \phi(y)}{x - y}

    over all of R, or over a closed interval.  The law enters a loop as ``mu = -phi(sigma)``.

    Parameters
    ----------
    law : law of lure.laws, Expression, str or callable
        A text is a formula in ``sigma`` (or ``x``).  Anything else that can be called is known by its values alone.
    on : pair of numbers, optional
        The interval; all of R by default.
    lipschitz : float or Fraction, optional
        For a callable: a constant ``L`` with ``|phi(x) - phi(y)| <= L |x - y|`` that the user vouches for.
    samples : int
        For a callable: how many points are asked before the sample is refined.

    Returns
    -------
    LawBounds
        For a law known as a formula, CERTIFIED: exact for piecewise linear laws, from isolated roots for polynomials
        and rational functions, else in ball arithmetic, ends and infinity included; ``inner`` and ``outer`` enclose the
        true bound, and what could not be shown is in ``notes``.  For a callable, OBSERVED: a sample says nothing about
        the values between its points; with ``lipschitz``, CERTIFIED under the assumption in ``assumptions``.

    Raises
    ------
    InputError
        The formula is refused by the parser, ``phi(0)`` is not 0 or not defined (where 0 belongs to the domain), the
        law has a pole or no value somewhere, the degree of a rational function passes 256, or an argument is not as
        described.
    AssumptionError
        The sample contradicts ``lipschitz``.

    Notes
    -----
    A jump gives an infinite slope bound, and its sector where there is one.  Slope bounds are those of the derivative
    between the jumps: every difference quotient of a continuous, piecewise differentiable law is a mean of slopes.

    Examples
    --------
    >>> print(law_bounds("x/(1 + x**2)").sector, law_bounds("x/(1 + x**2)").slope)
    [0, 1] [-0.125, 1]
    """
    interval = domain(on)
    low, high = (-math.inf, math.inf) if interval is None else interval
    if isinstance(law, Quantiser):
        found = steps.quantiser_bounds(law, interval)
    elif (known := known_law(law, low, high)) is not None:
        found = bounds_of_known(known, low, high)
    else:
        return _of_callable(law, interval, lipschitz, samples)
    if lipschitz is not None:
        raise InputError("lipschitz is for a law given as a function; this one is known, and nothing need be assumed")
    return found


def _of_callable(
    law: object, on: tuple[Fraction, Fraction] | None, lipschitz: float | Fraction | None, samples: int
) -> LawBounds:
    if not callable(law):
        raise InputError(f"the law is {law!r:.60}; give a formula in sigma, a law of lure.laws, or a function")
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 10:
        raise InputError(f"samples is {samples!r:.60}; give a whole number of at least 10")
    name = getattr(law, "__name__", None) or str(law)
    function: Callable[[Any], Any] = law
    sample = blackbox.sampled(function, name, on, samples)
    if lipschitz is None:
        return blackbox.observed(sample, name, on)
    constant = exact_number(lipschitz, "lipschitz")
    if constant <= 0:
        raise InputError(f"lipschitz is {float(constant):g}; give a positive number")
    return blackbox.vouched(sample, name, on, constant)


def bounds_of_known(known: Known, low: End, high: End, effort: Effort | None = None) -> LawBounds:
    """Sector and slope bounds of a law that is known exactly; see :func:`law_bounds`.

    Parameters
    ----------
    known : Known
        The law.
    low, high : Fraction, or an infinity
        Its domain.
    effort : Effort, optional
        What may be spent: bounds that were not reached in time are infinite, or wide.

    Raises
    ------
    InputError
        As for :func:`law_bounds`.
    """
    with working_precision(BITS):
        return _of_known(known, low, high, effort)


def has_values(known: Known, found: LawBounds) -> bool:
    """Whether a law is known to have a value everywhere on its domain, now that it was bounded there.

    Parameters
    ----------
    known : Known
        The law.
    found : LawBounds
        Its bounds, without an error.  A search that bounds the chords from one side has looked at every place; one that
        was given up, or that met growth without bound on both sides, has not.
    """
    if any(isinstance(end.outer, Fraction) for end in (found.sector_lower, found.sector_upper)):
        return True
    return all(piece.ratio is not None or nature(piece.tree) is not None for piece in known.pieces)


def _of_known(known: Known, low: End, high: End, effort: Effort | None) -> LawBounds:
    if low <= 0 <= high:
        _demand_zero(known)
    for piece in known.pieces:
        _demand_values(piece, known.name)
    chords, chord_covers = over_pieces(known, chords=True, effort=effort)
    chords += [Candidate(value=_divided(known.value(x), x), place=x, inside=True) for x in cuts_of(known) if x != 0]
    sector = least(chords, chord_covers), largest(chords, chord_covers)
    slope, notes = slope_extremes(known, effort)
    notes += _remarks("sector", *sector) + _remarks("slope", *slope)
    return LawBounds(
        law=known.name,
        sector_lower=sector[0],
        sector_upper=sector[1],
        slope_lower=slope[0],
        slope_upper=slope[1],
        evidence=Evidence.CERTIFIED,
        on=None if isinstance(low, float) or isinstance(high, float) else (low, high),
        notes=tuple(notes),
    )


def _demand_zero(known: Known) -> None:
    value = known.value(Fraction(0))
    if value == 0:
        return
    if isinstance(value, tuple) and value[0] <= 0 <= value[1]:
        raise InputError(
            f"the law {known.name[:60]!r} has a phi(0) that cannot be shown to be 0; write it so that it is"
        )
    shown = value[0] if isinstance(value, tuple) else value
    raise InputError(
        f"the law {known.name[:60]!r} has phi(0) = {short(shown)}; a sector needs a law that vanishes at 0: "
        "measure sigma and phi from the equilibrium"
    )


def _demand_values(piece: Piece, name: str) -> None:
    """Refuse a pole inside, and a piece where the formula is undefined."""
    if piece.ratio is not None:
        poles = roots_between(piece.ratio.poles, piece.low, piece.high)
        if poles:
            place = float(poles[0]) if isinstance(poles[0], Fraction) else float(poles[0].mid())
            raise InputError(
                f"the law {name[:60]!r} has a pole, or divides zero by zero, at sigma = {place:.10g}; bound it on an "
                "interval without that point"
            )
        return
    for x in _spread(piece):
        if not value_at(piece.tree, x).is_finite():
            raise InputError(
                f"the law {name[:60]!r} has no value that could be enclosed at sigma = {float(x):.10g}; bound it on an "
                "interval where it has values"
            )


def _spread(piece: Piece) -> list[Fraction]:
    """A few points of a piece."""
    low, high = piece.low, piece.high
    if isinstance(low, Fraction) and isinstance(high, Fraction):
        return [low + (high - low) * k / 8 for k in range(1, 8)]
    start, side = (low, 1) if isinstance(low, Fraction) else (high, -1)
    assert isinstance(start, Fraction), "0 is a cut, or one end is finite"
    return [start + side * Fraction(10) ** k for k in (-3, 0, 1, 2)]


def _divided(value: Value, x: Fraction) -> Value:
    if not isinstance(value, tuple):
        return value / x
    low, high = sorted((value[0] / x, value[1] / x))
    return low, high


def _remarks(quantity: str, low: Extreme | None, high: Extreme | None) -> list[str]:
    """What was not shown, or not closely, in sentences."""
    pair = [(side, part) for side, part in (("lower", low), ("upper", high)) if part is not None]
    sizes = [abs(Fraction(part.inner)) for _, part in pair if isinstance(part.inner, Fraction)]
    said = []
    for side, part in pair:
        words = f"the {quantity} bound, {side},"
        if math.isinf(part.gap):
            said.append(f"{words} could not be shown beyond the values seen")
        elif Fraction(part.gap) > _TIGHT * max(sizes, default=Fraction(0)):
            said.append(f"{words} is known to within {part.gap:.1e}")
    return said

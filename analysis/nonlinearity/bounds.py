"""Sector and slope bounds of one nonlinearity."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lure.analysis.deadline import check_seconds
from lure.analysis.nonlinearity import sampled as blackbox
from lure.analysis.nonlinearity.jets import over_sigma, value_at
from lure.analysis.nonlinearity.pieces import (
    Known,
    Piece,
    Value,
    difference_vanishes,
    domain,
    jumps_possible,
    known_nonlinearity,
    of_tree,
    tree_of,
)
from lure.analysis.nonlinearity.rational import (
    BITS,
    Candidate,
    Cover,
    End,
    candidates,
    interval_of,
    largest,
    least,
    limit,
    roots_between,
    tightened,
)
from lure.analysis.nonlinearity.result import Bound, Extreme, NonlinearityBounds
from lure.analysis.nonlinearity.search import Effort, NotEnclosed, Target, end_limit, extremes
from lure.analysis.numerics.precision import working_precision
from lure.analysis.verdict import Evidence
from lure.errors import InputError, demand_whole
from lure.exact import exact_number
from lure.expressions.regularity import hull, nature, smooth
from lure.expressions.rigorous import ball
from lure.expressions.tree import Apply, Node, Number, Variable, derivative
from lure.nonlinearities import MovedNonlinearity, Quantiser, Tanh
from lure.nonlinearities.shifted import steepest_chord
from lure.record.values import exact_text

# Chords and slopes gathered over the pieces of a nonlinearity.


def piecewise_extrema(
    known: Known, *, chords: bool, effort: Effort | None = None
) -> tuple[list[Candidate], list[Cover]]:
    """What bounds the chords, or the slopes, on all pieces: those known exactly come first and spare work on others."""
    found, covers = list[Candidate](), list[Cover]()
    for piece in known.pieces:
        if piece.ratio is not None:
            quotient = piece.ratio.over_sigma() if chords else piece.ratio.slope()
            found += candidates(quotient, piece.low, piece.high)
    for piece in known.pieces:
        if piece.ratio is None:
            target = _chord_target(piece) if chords else _slope_target(piece)
            more, rest = tightened(*extremes(target, found, effort), hull(target.tree, piece.low, piece.high))
            found += more
            covers += rest
    return found, covers


def _chord_target(piece: Piece) -> Target:
    tree = over_sigma(piece.tree, 1 if piece.low >= 0 else -1)
    return Target(
        tree=tree, base=piece.tree, over_sigma=True, low=piece.low, high=piece.high, vanishes=piece.tends_to_zero
    )


def _slope_target(piece: Piece) -> Target:
    tree = derivative(piece.tree, "sigma")
    return Target(tree=tree, base=tree, over_sigma=False, low=piece.low, high=piece.high)


def cuts_of(known: Known) -> list[Fraction]:
    """The finite ends of the pieces, ascending."""
    ends = {end for piece in known.pieces for end in (piece.low, piece.high)}
    return sorted(end for end in ends if isinstance(end, Fraction))


# The uniform quantiser, whose jumps are infinitely many: bounds in closed form.

_HALF = Fraction(1, 2)


def quantiser_bounds(nonlinearity: Quantiser, on: tuple[Fraction, Fraction] | None) -> NonlinearityBounds:
    """Sector and slope bounds, exact.

    At the jump to level ``n``, at ``(n - 1/2) step``, the chord rises to ``n/(n - 1/2)``; between the jumps it falls,
    before the next one to ``n/(n + 1/2)``.  The first falls with ``n``, the second rises: only the first jumps count.
    """
    chords: list[Candidate] = []
    jump: Fraction | None = None
    flat = False
    for side in (1, -1):
        near, far = (Fraction(0), math.inf) if on is None else sorted((side * on[0], side * on[1]))
        if far <= 0:
            continue
        near = max(Fraction(near), Fraction(0))
        found, first, level = _of_side(nonlinearity, near, far)
        flat = flat or level
        jump = side * first if first is not None and jump is None else jump
        chords += [
            Candidate(value=v, place=side * x, inside=inside, side=-side * (not inside)) for v, x, inside in found
        ]
    slopes = [Candidate(value=Fraction(0), place="between the jumps", inside=True)]
    if jump is not None:
        slopes.append(Candidate(value=math.inf, place=f"a jump at {exact_text(jump)}", inside=False))
    return NonlinearityBounds(
        nonlinearity=str(nonlinearity),
        sector_lower=least(chords),
        sector_upper=largest(chords),
        slope_lower=least(slopes),
        slope_upper=largest(slopes),
        evidence=Evidence.CERTIFIED,
        on=on,
    )


def _of_side(
    nonlinearity: Quantiser, near: Fraction, far: Fraction | float
) -> tuple[list[tuple[Fraction, Fraction, bool]], Fraction | None, bool]:
    """Values, places and whether they are taken, on ``[near, far]``; the first jump in it."""
    n = int(near / nonlinearity.step + _HALF)  # the level at near
    found = []
    if near > 0:
        found.append((nonlinearity.exact(near) / near, near, True))
    elif far > 0:
        found.append(
            (Fraction(0), min(nonlinearity.step / 4, Fraction(far)) if far != math.inf else nonlinearity.step / 4, True)
        )
    if far != math.inf:
        found.append((nonlinearity.exact(Fraction(far)) / Fraction(far), Fraction(far), True))
    first = (n + _HALF) * nonlinearity.step
    if near < first <= far:
        if n:
            found.append((n * nonlinearity.step / first, first, False))
        found.append(((n + 1) * nonlinearity.step / first, first, True))
        return found, first, True
    return found, None, True


# A nonlinearity around a point that is known to within a radius.


def moved_bounds(phi: MovedNonlinearity, low: End, high: End, effort: Effort | None = None) -> NonlinearityBounds:
    r"""Sector and slope bounds of ``phi(s + sigma) - phi(s)`` that are true for every ``s`` in question.

    Around the middle they are those of a known nonlinearity.  Where ``phi`` is smooth, chords and slopes change by no
    more than :math:`\max|\phi''|` times the distance from there; of a piecewise linear one chords up to the next kink
    do not change, and others by its ``spread``.

    ``low``, ``high``: its domain; ``effort``: what may be spent.

    Raises
    ------
    InputError
        The nonlinearity is neither piecewise linear nor a smooth formula, or as for :func:`nonlinearity_bounds`.
    """
    if type(phi.nonlinearity) is Tanh and low < 0 < high:
        return _of_tanh(phi, phi.nonlinearity, low, high)
    if phi.centre is not None:
        known = known_nonlinearity(phi.centre, low, high)
        inside = max(-low, high) <= phi.room - phi.within
        wide = Fraction(0) if inside else phi.spread
    else:
        tree = tree_of(phi.nonlinearity)
        if tree is None or not smooth(tree):
            raise InputError(f"{phi!s:.60} is no smooth formula, and what is counted from elsewhere has to be one")
        there = _substituted(tree, Apply("+", (Variable("sigma"), Number(phi.at))))
        known = of_tree(Apply("-", (there, _substituted(tree, Number(phi.at)))), str(phi), low, high)
        ends = hull(derivative(derivative(tree, "sigma"), "sigma"), *_around(phi, low, high))
        bend = ends[1] if -ends[0] <= ends[1] else -ends[0]
        if math.isinf(bend):
            raise InputError(f"the second derivative of {phi!s:.60} could not be bounded; ask on a smaller interval")
        wide = Fraction(bend) * phi.within
    assert known is not None, "a graph and a tree are known"
    found = bounds_of_known(known, low, high, effort)
    slopes = Fraction(0) if phi.centre is not None or (low, high) == (-math.inf, math.inf) else wide
    least, most = found.slope_lower, found.slope_upper
    if phi.centre is not None:  # a kink just beyond the domain may lie in it
        ends = low - phi.within, high + phi.within
        beyond = known_nonlinearity(phi.centre, *ends)
        assert beyond is not None, "a graph is known"
        more = bounds_of_known(beyond, *ends, effort)
        least, most = (
            one and other and replace(one, outer=other.outer, attained=one.attained and one.outer == other.outer)
            for one, other in ((least, more.slope_lower), (most, more.slope_upper))
        )
    return replace(
        found,
        nonlinearity=str(phi),
        sector_lower=_wider(found.sector_lower, -wide),
        sector_upper=_wider(found.sector_upper, wide),
        slope_lower=least and _wider(least, -slopes),
        slope_upper=most and _wider(most, slopes),
    )


def _of_tanh(phi: MovedNonlinearity, inner: Tanh, low: End, high: End) -> NonlinearityBounds:
    """The same for ``tanh``, in closed form: chords rise up to the steepest one and fall beyond, slopes up to 0."""
    sign = 1 if phi.at >= 0 else -1
    at, within, unit = abs(phi.at) / inner.scale, phi.within / inner.scale, inner.gain / inner.scale
    left, right = (end if isinstance(end, float) else end / inner.scale for end in sorted((sign * low, sign * high)))
    chords, slopes = list[tuple[Fraction, Fraction]](), list[tuple[Fraction, Fraction]]()
    with working_precision(BITS):
        s = ball(at)
        middle, falls = interval_of(1 - s.tanh() * s.tanh()), False
        for x in (left, right):
            if isinstance(x, float):
                chords, slopes = [*chords, (Fraction(0),) * 2], [*slopes, (Fraction(0),) * 2]
                continue
            t = (s + ball(x)).tanh()
            chord, slope = (t - s.tanh()) / ball(x), 1 - t * t
            falls = falls or bool(x < 0 and slope > chord)  # all the way from the left end on
            chords, slopes = [*chords, interval_of(chord)], [*slopes, interval_of(slope)]
    chord, steepest = min(chords), chords[0][1] + within if falls else steepest_chord(at, within)
    slope = min(slopes)
    most = Fraction(1) if left <= -at else slopes[0][1] + within
    seen = max(low_chord for low_chord, _ in (*chords, middle)) - within
    a, b, c, d = (
        Extreme(inner=unit * inner_bound, outer=unit * outer, at=place, attained=False)
        for inner_bound, outer, place in (
            (chord[1] + within, max(Fraction(0), chord[0] - within), "where chords are least steep"),
            (min(seen, steepest), min(Fraction(1), steepest), "where chords are steepest"),
            (slope[1] + within, max(Fraction(0), slope[0] - within), "at an end"),
            (min(middle[0] - within, most), min(Fraction(1), most), "where it is steepest"),
        )
    )
    whole = isinstance(low, float) or isinstance(high, float)
    return NonlinearityBounds(
        nonlinearity=str(phi),
        sector_lower=a,
        sector_upper=b,
        slope_lower=c,
        slope_upper=d,
        evidence=Evidence.CERTIFIED,
        on=None if whole else (Fraction(low), Fraction(high)),
    )


def _around(phi: MovedNonlinearity, low: End, high: End) -> tuple[End, End]:
    """The domain in terms of the nonlinearity itself, wherever it is counted from; 0 belongs to it."""
    ends = min(low, 0), max(high, 0)
    a, b = (end if isinstance(end, float) else end + phi.at for end in ends)
    return a if isinstance(a, float) else a - phi.within, b if isinstance(b, float) else b + phi.within


def _substituted(node: Node, value: Node) -> Node:
    """The tree with another one in the place of its variable."""
    if isinstance(node, Variable):
        return value
    return (
        Apply(node.operation, tuple(_substituted(part, value) for part in node.arguments))
        if isinstance(node, Apply)
        else node
    )


def _wider(bound: Extreme, by: Fraction) -> Extreme:
    """A bound farther out, below for a negative width."""
    if not by or math.isinf(bound.outer):
        return bound
    inner = bound.inner if isinstance(bound.inner, float) else bound.inner - by
    return replace(bound, inner=inner, outer=Fraction(bound.outer) + by, attained=False)


# Slope bounds of a nonlinearity from its pieces and its jumps.


def slope_extremes(
    known: Known, effort: Effort | None = None
) -> tuple[tuple[Extreme | None, Extreme | None], list[str]]:
    """Slope bounds from the derivative on the pieces and the jumps between them."""
    if not known.continuous and not known.whole:
        return (None, None), ["no slope bounds: a branch changes where continuity could not be decided"]
    try:
        found, covers = piecewise_extrema(known, chords=False, effort=effort)
    except NotEnclosed as error:  # the nonlinearity has its values there, or its chords would not have been enclosed
        where = exact_text(error.place, 10)
        return (None, None), [f"no slope bounds: the slope could not be enclosed near sigma = {where}"]
    if not known.continuous:
        jumps = jumps_of(known)
        if jumps is None:
            return (None, None), ["no slope bounds: continuity where a branch changes could not be decided"]
        found += jumps
    found += _smooth_cuts(known, found)
    if not found:
        return (None, None), ["no slope bounds: the time allowed was over before a slope was looked at"]
    return (least(found, covers), largest(found, covers)), []


def jumps_of(known: Known) -> list[Candidate] | None:
    """Infinite slopes at the jumps; None if it is not known whether there is one."""
    assert known.branches is not None, "a nonlinearity without branches is continuous"
    found: list[Candidate] = []
    for x in cuts_of(known):
        here = known.branches(x, x)
        for piece, side in ((p, s) for p in known.pieces for end, s in ((p.high, -1), (p.low, 1)) if end == x):
            if known.branches(piece.low, piece.high) == here and not jumps_possible(here):
                continue  # one formula, continuous, holds on the piece and at its end
            edge = _edge(piece, x, side)
            step = None if edge is None else _step(known.value(x), edge)
            if step is None and difference_vanishes(known.branches(piece.low, piece.high), here, x):
                continue
            if step is None:
                return None
            if step:
                place = f"a jump at {exact_text(x, 10)}"
                found.append(Candidate(value=side * step * math.inf, place=place, inside=False))
    return found


def _edge(piece: Piece, x: Fraction, side: int) -> Value | float | None:
    """The limit of the nonlinearity at an end of a piece, None if it is not known."""
    if piece.ratio is not None:
        return limit(piece.ratio, x, side).value
    tree = piece.tree
    return end_limit(Target(tree=tree, base=tree, over_sigma=False, low=piece.low, high=piece.high), x, side)


def _step(before: Value | float, after: Value | float) -> int | None:
    """The sign of a step; None if it is not known to be one."""
    if before == after and not isinstance(before, tuple):
        return 0
    a = before if isinstance(before, tuple) else (before, before)
    b = after if isinstance(after, tuple) else (after, after)
    return 1 if a[1] < b[0] else -1 if b[1] < a[0] else None


def _smooth_cuts(known: Known, found: Sequence[Candidate]) -> list[Candidate]:
    """The slope at cuts where the nonlinearity is differentiable, since the limits from both sides agree."""
    unbroken = {right.low for left, right in pairwise(known.pieces) if left.tree == right.tree}
    limits: dict[Fraction, dict[int, Bound | tuple[Fraction, Fraction]]] = {}
    for c in found:
        if isinstance(c.place, Fraction) and not c.inside and c.side:
            limits.setdefault(c.place, {})[c.side] = c.value
    broken = {c.place for c in found if isinstance(c.place, str)}
    return [
        Candidate(value=sides[1], place=x, inside=True)
        for x, sides in limits.items()
        if len(sides) == 2 and not broken and _same(sides[1], sides[-1], unbroken=x in unbroken)
    ]


def _same(left: Bound | tuple[Fraction, Fraction], right: Bound | tuple[Fraction, Fraction], *, unbroken: bool) -> bool:
    """Whether two finite limits are known to be one: exactly, or since one smooth formula holds on both sides."""
    if isinstance(left, Fraction):
        return left == right
    return unbroken and isinstance(left, tuple)


_TIGHT = Fraction(1, 10**9)
_LATE = "the time allowed ended the search (LURE-I007): these are the best bounds so far"


def nonlinearity_bounds(
    nonlinearity: object,
    *,
    on: object = None,
    lipschitz: float | Fraction | None = None,
    samples: int = 4001,
    seconds: float | None = None,
) -> NonlinearityBounds:
    r"""Sector and slope bounds of a nonlinearity, from both sides, with the places where they are attained.

    .. math:: \inf_{\sigma \ne 0} \phi(\sigma)/\sigma, \quad \sup_{\sigma \ne 0} \phi(\sigma)/\sigma, \quad
        \inf_{x \ne y} \frac{\phi(x) - \phi(y)}{x - y}, \quad \sup_{x \ne y} \frac{\phi(x) - \phi(y)}{x - y}

    over all of R, or over a closed interval.  The nonlinearity enters a loop as ``mu = -phi(sigma)``.

    Parameters
    ----------
    nonlinearity : nonlinearity of lure.nonlinearities, Expression, str or callable
        A text is a formula in ``sigma`` (or ``x``).  Anything else that can be called is known by its values alone.
    on : pair of numbers, optional
        The interval; all of R by default.
    lipschitz : float or Fraction, optional
        For a callable: a constant ``L`` with ``|phi(x) - phi(y)| <= L |x - y|`` that the user vouches for.
    samples : int
        For a callable: how many points are asked before the sample is refined.
    seconds : float, optional
        Time allowed to the search for the bounds of a formula.  When it is over, what was shown until then is returned:
        bounds that hold and are wider, or infinite, and ``notes`` say so.

    Returns
    -------
    NonlinearityBounds
        For a nonlinearity known as a formula, CERTIFIED: exact for piecewise linear nonlinearities, from isolated roots
        for polynomials and rational functions, else in ball arithmetic, ends and infinity included; ``inner`` and
        ``outer`` enclose the true bound, and what could not be shown is in ``notes``.  For a callable, OBSERVED: a
        sample says nothing about the values between its points; with ``lipschitz``, CERTIFIED under the assumption in
        ``assumptions``.

    Raises
    ------
    InputError
        The formula is refused by the parser, ``phi(0)`` is not 0 or not defined (where 0 belongs to the domain), the
        nonlinearity has a pole or no value somewhere, the degree of a rational function passes 256, or an argument is
        not as described.
    AssumptionError
        The sample contradicts ``lipschitz``.

    Notes
    -----
    A jump gives an infinite slope bound, and its sector where there is one.  Slope bounds are those of the derivative
    between the jumps: every difference quotient of a continuous, piecewise differentiable nonlinearity is a mean of
    slopes.

    Examples
    --------
    >>> print(nonlinearity_bounds("x/(1 + x**2)").sector, nonlinearity_bounds("x/(1 + x**2)").slope)
    [0, 1] [-0.125, 1]
    """
    check_seconds(seconds)
    effort = Effort(until=math.inf if seconds is None else time.monotonic() + seconds)
    interval = domain(on)
    low, high = (-math.inf, math.inf) if interval is None else interval
    if isinstance(nonlinearity, Quantiser):
        found = quantiser_bounds(nonlinearity, interval)
    elif isinstance(nonlinearity, MovedNonlinearity):
        found = moved_bounds(nonlinearity, low, high, effort)
    elif (known := known_nonlinearity(nonlinearity, low, high)) is not None:
        found = bounds_of_known(known, low, high, effort)
        if effort.late:
            found = replace(found, notes=(*found.notes, _LATE))
    else:
        return _of_callable(nonlinearity, interval, lipschitz, samples)
    if lipschitz is not None:
        raise InputError(
            "lipschitz is for a nonlinearity given as a function; this one is known, and nothing need be assumed"
        )
    return found


def _of_callable(
    nonlinearity: object, on: tuple[Fraction, Fraction] | None, lipschitz: float | Fraction | None, samples: int
) -> NonlinearityBounds:
    if not callable(nonlinearity):
        raise InputError(
            f"the nonlinearity is {nonlinearity!r:.60}; give a formula in sigma, a nonlinearity of "
            f"lure.nonlinearities, or "
            "a function"
        )
    demand_whole("samples", samples, 10)
    name = getattr(nonlinearity, "__name__", None) or str(nonlinearity)
    function: Callable[[Any], Any] = nonlinearity
    sample = blackbox.sampled(function, name, on, samples)
    if lipschitz is None:
        return blackbox.observed(sample, name, on)
    constant = exact_number(lipschitz, "lipschitz")
    if constant <= 0:
        raise InputError(f"lipschitz is {float(constant):g}; give a positive number")
    return blackbox.lipschitz_bounds(sample, name, on, constant)


def bounds_of_known(known: Known, low: End, high: End, effort: Effort | None = None) -> NonlinearityBounds:
    """Sector and slope bounds of a nonlinearity that is known exactly; see :func:`nonlinearity_bounds`.

    Parameters
    ----------
    known : Known
        The nonlinearity.
    low, high : Fraction, or an infinity
        Its domain.
    effort : Effort, optional
        What may be spent: bounds that were not reached in time are infinite, or wide.

    Raises
    ------
    InputError
        As for :func:`nonlinearity_bounds`.
    """
    with working_precision(BITS):
        return _of_known(known, low, high, effort)


def has_values(known: Known, found: NonlinearityBounds) -> bool:
    """Whether a nonlinearity is known to have a value everywhere on its domain, now that it was bounded there.

    Parameters
    ----------
    known : Known
        The nonlinearity.
    found : NonlinearityBounds
        Its bounds, without an error.  A search that bounds the chords from one side has looked at every place; one that
        was given up, or that met growth without bound on both sides, has not.
    """
    if any(isinstance(end.outer, Fraction) for end in (found.sector_lower, found.sector_upper)):
        return True
    return all(piece.ratio is not None or nature(piece.tree) is not None for piece in known.pieces)


def _of_known(known: Known, low: End, high: End, effort: Effort | None) -> NonlinearityBounds:
    if low <= 0 <= high:
        _demand_zero(known)
    for piece in known.pieces:
        _demand_values(piece, known.name)
    chords, chord_covers = piecewise_extrema(known, chords=True, effort=effort)
    chords += [Candidate(value=_divided(known.value(x), x), place=x, inside=True) for x in cuts_of(known) if x != 0]
    sector = least(chords, chord_covers), largest(chords, chord_covers)
    slope, notes = slope_extremes(known, effort)
    notes += _remarks("sector", *sector) + _remarks("slope", *slope)
    return NonlinearityBounds(
        nonlinearity=known.name,
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
            f"the nonlinearity {known.name[:60]!r} has a phi(0) that cannot be shown to be 0; write it so that it is"
        )
    shown = value[0] if isinstance(value, tuple) else value
    raise InputError(
        f"the nonlinearity {known.name[:60]!r} has phi(0) = {exact_text(shown)}; a sector needs a nonlinearity that "
        "vanishes at 0: measure sigma and phi from the equilibrium"
    )


def _demand_values(piece: Piece, name: str) -> None:
    """Refuse a pole inside, and a piece where the formula is undefined."""
    if piece.ratio is not None:
        poles = roots_between(piece.ratio.poles, piece.low, piece.high)
        if poles:
            place = float(poles[0]) if isinstance(poles[0], Fraction) else float(poles[0].mid())
            raise InputError(
                f"the nonlinearity {name[:60]!r} has a pole, or divides zero by zero, at sigma = {place:.10g}; "
                "bound it on an interval without that point"
            )
        return
    for x in _spread(piece):
        if not value_at(piece.tree, x).is_finite():
            raise InputError(
                f"the nonlinearity {name[:60]!r} has no value that could be enclosed at sigma = {float(x):.10g}; "
                "bound it on an interval where it has values"
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

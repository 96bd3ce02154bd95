"""Nonlinearities with their first two derivatives on intervals, in ball arithmetic."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise

from flint import arb

from lure.analysis.nonlinearity.jets import jet
from lure.analysis.nonlinearity.pieces import known_nonlinearity, tree_of
from lure.analysis.numerics.precision import ball
from lure.errors import InputError
from lure.nonlinearities import ExpressionNonlinearity, GraphNonlinearity
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.piecewise_linear import Graph
from lure.nonlinearities.reading import control_saturation

Curve = Callable[[arb], tuple[arb, arb, arb]]
"""``phi``, ``phi'`` and ``phi''`` on a ball; at a kink ``phi'`` is the hull of the slopes and ``phi''`` is nan."""


def curve_of(nonlinearity: Nonlinearity) -> Curve:
    """The enclosures of a nonlinearity.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        Piecewise linear, named or a formula.

    Raises
    ------
    InputError
        It is known by its values alone.
    """
    given: object = control_saturation(nonlinearity) or nonlinearity
    own = callable(given) and getattr(type(given).__call__, "__module__", "").startswith("lure.")
    if own and isinstance(given, GraphNonlinearity | ExpressionNonlinearity) and given.graph is not None:
        return _bends(given.graph)
    tree = tree_of(given) if own else None
    if tree is None:
        raise InputError(
            f"the nonlinearity is {str(nonlinearity)[:60]}, known by its values alone, of which no enclosure follows; "
            "give a formula, points, or one of the named kinds"
        )

    def curve(box: arb) -> tuple[arb, arb, arb]:
        """From the series of the formula."""
        value, slope, bend = jet(tree, box)
        return value, slope, 2 * bend

    return curve


def degree_of(nonlinearity: Nonlinearity) -> int | None:
    """The degree of a nonlinearity that is a polynomial; None for others.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        One that has enclosures.
    """
    known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
    ratios = [piece.ratio for piece in known.pieces] if known is not None else [None]
    ratio = ratios[0]
    if ratio is None or ratio.poles.degree() > 0 or any(other != ratio for other in ratios):
        return None
    return int(ratio.top.degree())


def _bends(graph: Graph) -> Curve:
    """The enclosures of a piecewise linear graph."""
    kinks = graph.kinks
    inside = [(x + y) / 2 for x, y in pairwise(kinks)]
    places = [kinks[0] - 1, *inside, kinks[-1] + 1] if kinks else [Fraction(0)]
    slopes = [graph.slopes[bisect_left(graph.knots, x)] for x in places]
    points = (kinks[0], *kinks) if kinks else (Fraction(0),)
    lines = [(ball(x), ball(graph.exact(x)), ball(s)) for x, s in zip(points, slopes, strict=True)]

    at = [ball(x) for x in kinks]

    def curve(box: arb) -> tuple[arb, arb, arb]:
        """From the lines that meet the ball."""
        below, past = sum(x < box for x in at), sum(x > box for x in at)  # what is not certain counts as inside
        parts = lines[below : len(lines) - past]
        values = [y + s * (box - x) for x, y, s in parts]
        value, slope = values[0], parts[0][2]
        for other, (_, _, s) in zip(values[1:], parts[1:], strict=True):
            value, slope = value.union(other), slope.union(s)
        return value, slope, arb(0) if len(parts) == 1 else arb("nan")

    return curve

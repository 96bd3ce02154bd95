"""Slope bounds of a law from its pieces and its jumps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from analysis.bounds.extremes import Candidate, largest, least
from analysis.bounds.gathering import cuts_of, over_pieces
from analysis.bounds.known import Known, Value, jumps_possible
from analysis.bounds.pieces import Piece
from analysis.bounds.rational import limit
from analysis.bounds.result import Bound, Extreme, short
from analysis.bounds.search import Effort, end_limit
from analysis.bounds.target import NotEnclosed, Target
from analysis.bounds.zero import difference_vanishes


def slope_extremes(
    known: Known, effort: Effort | None = None
) -> tuple[tuple[Extreme | None, Extreme | None], list[str]]:
    """Slope bounds from the derivative on the pieces and the jumps between them."""
    if not known.continuous and not known.whole:
        return (None, None), ["no slope bounds: a branch changes where continuity could not be decided"]
    try:
        found, covers = over_pieces(known, chords=False, effort=effort)
    except NotEnclosed as error:  # the law has its values there, or its chords would not have been enclosed
        where = short(error.place, digits=10)
        return (None, None), [f"no slope bounds: the slope could not be enclosed near sigma = {where}"]
    if not known.continuous:
        jumps = jumps_of(known)
        if jumps is None:
            return (None, None), ["no slope bounds: continuity where a branch changes could not be decided"]
        found += jumps
    found += _smooth_cuts(known, found)
    return (least(found, covers), largest(found, covers)), []


def jumps_of(known: Known) -> list[Candidate] | None:
    """Infinite slopes at the jumps; None if it is not known whether there is one."""
    assert known.branches is not None, "a law without branches is continuous"
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
                place = f"a jump at {short(x, digits=10)}"
                found.append(Candidate(value=side * step * math.inf, place=place, inside=False))
    return found


def _edge(piece: Piece, x: Fraction, side: int) -> Value | float | None:
    """The limit of the law at an end of a piece, None if it is not known."""
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
    """The slope at cuts where the law is differentiable, since the limits from both sides agree."""
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

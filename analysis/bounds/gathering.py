"""Chords and slopes gathered over the pieces of a law."""

from __future__ import annotations

from fractions import Fraction

from analysis.bounds.extremes import Candidate, Cover
from analysis.bounds.jets import over_sigma
from analysis.bounds.known import Known
from analysis.bounds.pieces import Piece
from analysis.bounds.rational import candidates
from analysis.bounds.search import Effort, extremes
from analysis.bounds.target import Target
from analysis.bounds.zero import difference_vanishes
from lure.expressions.derivative import derivative
from lure.expressions.tree import ZERO


def over_pieces(known: Known, *, chords: bool, effort: Effort | None = None) -> tuple[list[Candidate], list[Cover]]:
    """What bounds the chords, or the slopes, on all pieces: those known exactly come first and spare work on others."""
    found, covers = list[Candidate](), list[Cover]()
    for piece in known.pieces:
        if piece.ratio is not None:
            quotient = piece.ratio.over_sigma() if chords else piece.ratio.slope()
            found += candidates(quotient, piece.low, piece.high)
    for piece in known.pieces:
        if piece.ratio is None:
            more, rest = extremes(_chord_target(piece) if chords else _slope_target(piece), found, effort)
            found += more
            covers += rest
    return found, covers


def _chord_target(piece: Piece) -> Target:
    tree = over_sigma(piece.tree, 1 if piece.low >= 0 else -1)
    zero = Fraction(0)
    vanishes = zero in (piece.low, piece.high) and difference_vanishes(piece.tree, ZERO, zero)
    return Target(tree=tree, base=piece.tree, over_sigma=True, low=piece.low, high=piece.high, vanishes=vanishes)


def _slope_target(piece: Piece) -> Target:
    tree = derivative(piece.tree, "sigma")
    return Target(tree=tree, base=tree, over_sigma=False, low=piece.low, high=piece.high)


def cuts_of(known: Known) -> list[Fraction]:
    """The finite ends of the pieces, ascending."""
    ends = {end for piece in known.pieces for end in (piece.low, piece.high)}
    return sorted(end for end in ends if isinstance(end, Fraction))

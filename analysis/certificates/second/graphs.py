"""Known nonlinearities of the second checker: polynomials between cuts, or sectors on an interval; loops of them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.numerics import X, nonnegative_from_zero, to_fmpq, to_fraction
from lure.analysis.certificates.second.reading import listed, mapping, number, numbers, record, require

LARGEST_DEGREE = 40
Cut = Fraction | None  # None: there is no end on this side


@dataclass(frozen=True, kw_only=True, slots=True)
class Graph:
    """A nonlinearity: polynomials between cuts, or, without any, a sector for ``|sigma| <= reach``."""

    cuts: tuple[Fraction, ...] = ()
    pieces: tuple[fmpq_poly, ...] = ()
    sector: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))
    reach: Fraction | None = None

    @property
    def clip(self) -> tuple[Fraction, Fraction, Fraction, Fraction] | None:
        """``e, u, least, most``: ``phi - e sigma`` is ``(u - e) sigma`` held between the last two; else None."""
        if len(self.pieces) != 3 or any(p.degree() > 1 for p in self.pieces) or self.pieces[1][0] != 0:
            return None
        left, middle, right = self.pieces
        least, most = sorted((to_fraction(left[0]), to_fraction(right[0])))
        if left[1] != right[1] or not least < 0 < most:  # at cuts on both sides of 0
            return None
        return to_fraction(left[1]), to_fraction(middle[1]), least, most


def read_graph(value: object) -> Graph:
    """The nonlinearity of one channel, continuous with ``phi(0) = 0``; ``value``: as it was read.

    Raises
    ------
    NotShown
        It is none.
    """
    if mapping(value).get("kind") == "signed":  # a class, of no known member, and so known up to 0
        top = number(record(value, "kind", "top")["top"])
        require(top > 0, "a slope is not positive")
        return Graph(sector=(Fraction(0), top), reach=Fraction(0))
    if mapping(value).get("kind") == "sector":
        found = record(value, "kind", "sector", "reach")
        low, high = numbers(found["sector"])
        require(low <= high and number(found["reach"]) > 0, "a sector or its reach is none")
        return Graph(sector=(low, high), reach=number(found["reach"]))
    found = record(value, "kind", "cuts", "pieces")
    require(found["kind"] == "piecewise-polynomial", "the kind of a nonlinearity is unknown")
    cuts = tuple(numbers(found["cuts"]))
    pieces = tuple(fmpq_poly([to_fmpq(v) for v in numbers(piece)]) for piece in listed(found["pieces"]))
    require(len(pieces) == len(cuts) + 1, "there is not one polynomial more than cuts")
    require(all(p.degree() < LARGEST_DEGREE for p in pieces), "the degree of a polynomial is too high")
    require(all(a < b for a, b in pairwise(cuts)), "the cuts do not ascend")
    for cut, (left, right) in zip(cuts, pairwise(pieces), strict=True):
        require(bool(left(to_fmpq(cut)) == right(to_fmpq(cut))), "the nonlinearity jumps")
    require(bool(pieces[sum(cut < 0 for cut in cuts)](fmpq(0)) == 0), "phi(0) is not 0")
    return Graph(cuts=cuts, pieces=pieces)


def pieces_of(graph: Graph, scale: Fraction) -> list[tuple[Cut, Cut, fmpq_poly]]:
    """The pieces of ``phi(scale x)`` over ``x``, with their ends; scale > 0 or < 0.

    ``graph``: the nonlinearity; ``scale``: not 0.
    """
    argument, cuts = to_fmpq(scale) * X, [cut / scale for cut in graph.cuts]
    parts = [piece(argument) for piece in graph.pieces]
    if scale < 0:
        cuts, parts = cuts[::-1], parts[::-1]
    return list(zip([None, *cuts], [*cuts, None], parts, strict=True))


def nonnegative_between(p: fmpq_poly, low: Cut, high: Cut) -> bool:
    """Whether ``p >= 0`` between two ends, one of which is finite."""
    if low is None:
        assert high is not None, "one end is finite"
        return nonnegative_from_zero(p(to_fmpq(high) - X))
    if high is None:
        return nonnegative_from_zero(p(to_fmpq(low) + X))
    top, start, width = max(p.degree(), 0), to_fmpq(low), to_fmpq(high - low)
    # x = low + width t/(1 + t), times (1 + t)^degree
    moved, grown = p(start + width * X), fmpq_poly([])
    for i, c in enumerate(moved.coeffs()):
        grown += c * X**i * (1 + X) ** (top - i)
    return nonnegative_from_zero(grown)


def positive_inside(p: fmpq_poly, low: Cut, high: Cut) -> bool:
    """Whether ``p > 0`` strictly between the ends: it is nonnegative, and has no double root there."""
    if not nonnegative_between(p, low, high) or p.degree() < 0:
        return False
    for end in (low, high):  # roots at the ends are allowed
        while end is not None and p(to_fmpq(end)) == 0:
            p //= X - to_fmpq(end)
    shared = p.gcd(p.derivative())  # a root inside would be a double one, p being nonnegative
    if shared.degree() < 1:
        return True
    return positive_inside(shared, low, high) or positive_inside(-shared, low, high)


@dataclass(frozen=True, kw_only=True, slots=True)
class Loop:
    """The plant as ``x' = F z``, ``sigma = Y z`` with ``z = (x, phi)``, and its nonlinearities."""

    F: fmpq_mat
    Y: fmpq_mat
    D: fmpq_mat
    discrete: bool
    graphs: tuple[Graph, ...]

    @property
    def sizes(self) -> tuple[int, int]:
        """How many states and channels there are."""
        return self.F.nrows(), self.Y.nrows()

    def form(self, P: fmpq_mat, rate: Fraction = Fraction(0)) -> fmpq_mat:
        """``V' - rate V``, or ``V+ - (1 + rate) V``."""
        n, m = self.sizes
        E = fmpq_mat([[int(i == j) for j in range(n + m)] for i in range(n)])
        if self.discrete:
            return self.F.transpose() * P * self.F - to_fmpq(1 + rate) * (E.transpose() * P * E)
        half = E.transpose() * P * self.F
        return half + half.transpose() - to_fmpq(rate) * (E.transpose() * P * E)

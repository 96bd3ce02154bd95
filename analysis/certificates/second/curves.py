"""Curves around 0 in the plane, checked again: once around, crossed in one direction, with one equilibrium inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.graphs import Loop, pieces_of, positive_inside
from lure.analysis.certificates.second.numerics import X, positive_from_zero, to_fmpq, to_fraction
from lure.analysis.certificates.second.reading import NotShown, listed, numbers, require

LONGEST_CURVE = 20_000

# Curves in the plane.  A parabola is q(t) = a + b t + c t^2 for 0 <= t <= 1; a straight edge has c = 0.

Place = tuple[fmpq, fmpq]


@dataclass(frozen=True, kw_only=True, slots=True)
class Arc:
    """Its corners: start, end, and between them the control point of a parabola."""

    corners: tuple[Place, ...]

    def coordinate(self, k: int) -> fmpq_poly:
        """``q_k(t)``."""
        values = [corner[k] for corner in self.corners]
        if len(values) == 2:
            return fmpq_poly([values[0], values[1] - values[0]])
        a, b, c = values
        return a * (1 - X) ** 2 + 2 * b * X * (1 - X) + c * X**2


@dataclass(frozen=True, kw_only=True, slots=True)
class Curve:
    """Once around 0: ``sense`` is 1 for anticlockwise; it ends at ``factor`` times its start."""

    sense: int
    start: Place
    factor: Fraction
    arcs: tuple[Arc, ...]

    def along_ray(self, low: Fraction, high: Fraction) -> Arc:
        """The edge between two factors of the start."""
        low_end, high_end = ((to_fmpq(v) * self.start[0], to_fmpq(v) * self.start[1]) for v in (low, high))
        return Arc(corners=(low_end, high_end))


def turned(p: Place, q: Place) -> fmpq:
    """Positive where ``q`` is anticlockwise of ``p``, by less than half a turn; ``p``, ``q``: two points."""
    return p[0] * q[1] - p[1] * q[0]


def curve_of(loop: Loop, value: object) -> Curve:
    """The curve, which goes once around 0 by steps of less than half a turn in one sense.

    ``loop``: with two states; ``value``: its points, as they were read.

    Raises
    ------
    NotShown
        It does not go once around 0, or the loop has no such curves.
    """
    require(loop.sizes[0] == 2 and not loop.discrete, "curves are about two states in continuous time")
    require(not any(v != 0 for v in loop.D.entries()), "curves are about D = 0")
    require(all(graph.reach is None for graph in loop.graphs), "the nonlinearities are not known")
    rows = [[to_fmpq(v) for v in numbers(row)] for row in listed(value)]
    require(4 <= len(rows) <= LONGEST_CURVE, "the curve has too few or too many points")
    require(len(rows[0]) == 2 and all(len(row) in (2, 4) for row in rows), "a point has not two coordinates")
    at: Place = (rows[0][0], rows[0][1])
    arcs, path = list[Arc](), [at]
    for row in rows[1:]:
        corners = [path[-1], *((row[i], row[i + 1]) for i in range(0, len(row), 2))]
        path += corners[1:]
        arcs.append(Arc(corners=tuple(corners)))
    sense = 1 if turned(path[0], path[1]) > 0 else -1
    steps = [*pairwise(path), *((arc.corners[0], arc.corners[-1]) for arc in arcs)]
    require(all(sense * turned(p, q) > 0 for p, q in steps), "the curve does not turn in one sense")
    passed = sum(bool(sense * turned(p, at) > 0 and sense * turned(at, q) >= 0) for p, q in pairwise(path))
    end = path[-1]
    factor = (at[0] * end[0] + at[1] * end[1]) / (at[0] ** 2 + at[1] ** 2)
    require(bool(turned(at, end) == 0) and factor > 0 and passed == 1, "the curve does not go once around 0")
    return Curve(sense=sense, start=at, factor=to_fraction(factor), arcs=tuple(arcs))


def _positive_on_unit(p: fmpq_poly) -> bool:
    """Whether ``p > 0`` on ``[0, 1]``: at 1, and at ``t = x/(1 + x)`` for no ``x >= 0`` a root."""
    grown, top = fmpq_poly([]), max(p.degree(), 0)
    for i, c in enumerate(p.coeffs()):
        grown += c * X**i * (1 + X) ** (top - i)
    return bool(p(fmpq(1)) > 0) and positive_from_zero(grown)


def require_crossed(loop: Loop, arcs: Sequence[Arc], side: int) -> None:
    """Check that ``x'`` points strictly to the left of every arc, for ``side`` -1 to its right; ``side``: 1 or -1.

    Raises
    ------
    NotShown
        It is not shown.
    """
    for arc in arcs:
        x = arc.coordinate(0), arc.coordinate(1)
        sigma = [loop.Y[i, 0] * x[0] + loop.Y[i, 1] * x[1] for i in range(len(loop.graphs))]
        reaches = [
            sorted(to_fraction(loop.Y[i, 0] * c[0] + loop.Y[i, 1] * c[1]) for c in arc.corners)
            for i in range(len(loop.graphs))
        ]
        times = {Fraction(0), Fraction(1)}
        for graph, own, reach in zip(loop.graphs, sigma, reaches, strict=True):
            for cut in graph.cuts:
                if reach[0] < cut < reach[-1]:
                    require(own.degree() == 1 and len(arc.corners) == 2, "a parabola leaves a piece")
                    times.add((cut - to_fraction(own[0])) / to_fraction(own[1]))
        for start, end in pairwise(sorted(times)):
            inner = to_fmpq(start) + to_fmpq(end - start) * X
            speed = [loop.F[k, 0] * x[0] + loop.F[k, 1] * x[1] for k in (0, 1)]
            for i, (graph, own, reach) in enumerate(zip(loop.graphs, sigma, reaches, strict=True)):
                straight = len(arc.corners) == 2
                here = to_fraction(own(to_fmpq((start + end) / 2))) if straight else (reach[0] + reach[-1]) / 2
                phi = graph.pieces[sum(cut < here for cut in graph.cuts)](own)
                speed = [speed[k] + loop.F[k, 2 + i] * phi for k in (0, 1)]
            left = x[0].derivative() * speed[1] - x[1].derivative() * speed[0]
            require(_positive_on_unit((side * left)(inner)), "an arc is not crossed")


def require_one_equilibrium(loop: Loop, curve: Curve) -> None:
    """Check that ``A x = B phi`` has no solution within the curve but 0; all are ``x = (A - g B C)^-1 B psi``.

    ``loop``: with one nonlinearity; ``curve``: around 0.

    Raises
    ------
    NotShown
        It is not shown.
    """
    A, minus_b = (fmpq_mat([[row[i] for i in own] for row in loop.F.tolist()]) for own in ((0, 1), (2,)))
    C = fmpq_mat([loop.Y.tolist()[0][:2]])
    shift = next((g for g in (0, 1) if (A + g * (minus_b * C)).det() != 0), None)
    if shift is None:
        raise NotShown("equilibria are not isolated")
    line = -((A + shift * (minus_b * C)).inv() * minus_b)
    slope = (C * line)[0, 0]  # sigma = slope psi(sigma), psi = phi - shift sigma
    if slope == 0:
        return
    graph = loop.graphs[0]
    for sign in (1, -1):  # x = tau way for tau > 0
        way: Place = (sign * line[0, 0], sign * line[1, 0])
        far = fmpq(0)
        for arc in curve.arcs:
            for p, q in [*pairwise(arc.corners), (arc.corners[0], arc.corners[-1])]:
                if curve.sense * turned(p, way) >= 0 and curve.sense * turned(way, q) >= 0:
                    far = max(far, turned(p, q) / turned(way, (q[0] - p[0], q[1] - p[1])))
        require(bool(far > 0), "a ray does not leave the curve")
        reach = to_fraction(far * sign * slope)
        for low, high, piece in pieces_of(graph, Fraction(1 if reach > 0 else -1)):  # over |sigma|
            start = Fraction(0) if low is None else max(low, Fraction(0))
            end = abs(reach) if high is None else min(high, abs(reach))
            if start >= end:
                continue
            own = (1 if reach > 0 else -1) * X
            rest = own - slope * (piece - shift * own)
            ends = [rest(to_fmpq(v)) for v in (start, end) if v]
            fine = positive_inside(rest, start, end) or positive_inside(-rest, start, end)
            require(fine and all(v != 0 for v in ends), "there is another equilibrium, or it is not excluded")

"""How large sets around 0 and their unions are at least, by polygons or simplices, and the matrix of one as text."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from flint import fmpq, fmpq_mat

from lure.analysis.numerics.doubles import form_text, text_above, text_below
from lure.analysis.numerics.polynomial import to_fmpq
from lure.arrays import Reals, np
from lure.plants.multivariable import MultivariablePlant

Points = tuple[tuple[Fraction, ...], ...]
Corners = list[tuple[Fraction, Fraction]]
_PARTS, _CORNERS, _RINGS, _HALVINGS, _FAR, _ROUNDED, _ROOM = 4, 200, 16, 60, 1e4, 1e-6, 1.1
_SHOWN = 6  # states, up to which a matrix is written out
_CONES = {2: 500, 3: 40}  # along each edge of a quadrant or an octant


def cross(p: Any, q: Any) -> Any:  # noqa: ANN401  (floats or fractions)
    """``p_1 q_2 - p_2 q_1``.

    ``p``, ``q``: of the plane.
    """
    return p[0] * q[1] - p[1] * q[0]


def arcs(points: Points) -> list[tuple[Any, Any, Any]]:
    """Start, control point or None, and end of each arc of a closed curve, exactly; the last one closes it along a ray.

    ``points``: its start, then for each arc its end, and before it its control point.
    """
    closed = [*points[1:], points[0]]
    ends = [points[0], *(row[-2:] for row in points[1:])]
    return [(p, row[:2] if len(row) == 4 else None, row[-2:]) for p, row in zip(ends, closed, strict=True)]


def area(points: Points) -> Fraction:
    """The area within a closed curve, exactly; ``points``: as :func:`arcs` takes them."""
    found = Fraction(0)
    for p, c, q in arcs(points):
        found += cross(p, q) / 2 if c is None else (2 * cross(p, c) + 2 * cross(c, q) + cross(p, q)) / 6
    return abs(found)


def polygon_within(points: Points) -> list[tuple[Fraction, Fraction]]:
    """Corners of a polygon that lies within a closed curve or an ellipse, anticlockwise, exactly: nearly itself.

    Points of the parabolas are joined, over their control points where they bend towards 0.

    ``points``: as :func:`arcs` takes them; or, of the ellipse ``x'P x <= 1``, the two rows of ``P``.
    """
    if len(points) == 2:
        return _ellipse_within(points)
    found = list[tuple[Fraction, Fraction]]()
    for p, c, q in arcs(points):
        found.append((p[0], p[1]))
        size = 0 if c is None else (cross(p, c) + cross(c, q) - cross(p, q)) * cross(p, q)
        ends = [Fraction(k, _PARTS) for k in range(_PARTS + 1)] if size else []
        for s, t in pairwise(ends):
            if size < 0:  # the control point of the part from s to t
                weights = (1 - s) * (1 - t), s + t - 2 * s * t, s * t
                found.append(_weighted(weights, (p, c, q)))
            if t < 1:
                found.append(_weighted(((1 - t) ** 2, 2 * t * (1 - t), t * t), (p, c, q)))
    return found if cross(found[0], found[1]) > 0 else found[::-1]


def _weighted(weights: Sequence[Fraction], corners: Sequence[Any]) -> tuple[Fraction, Fraction]:
    x, y = (sum((w * corner[k] for w, corner in zip(weights, corners, strict=True)), Fraction(0)) for k in (0, 1))
    return x, y


def _ellipse_within(P: Points) -> list[tuple[Fraction, Fraction]]:
    back = np.linalg.inv(np.linalg.cholesky(np.array(P, dtype=float)).T) * (1 - 1e-9)
    found = list[tuple[Fraction, Fraction]]()
    for angle in np.linspace(0, 2 * np.pi, _CORNERS, endpoint=False):
        x, y = (Fraction(float(v)) for v in back @ np.array([np.cos(angle), np.sin(angle)]))
        if P[0][0] * x * x + 2 * P[0][1] * x * y + P[1][1] * y * y <= 1:
            found.append((x, y))
    return found


def union_below(polygons: Sequence[Sequence[tuple[Fraction, Fraction]]]) -> Fraction:
    """A lower bound of the area of a union of polygons that are seen whole from 0: the largest one in each direction.

    ``polygons``: corners of each, anticlockwise.
    """
    sided = list[tuple[Any, list[tuple[Fraction, Fraction]]]]()
    for polygon in polygons:
        angles = np.array([math.atan2(float(y), float(x)) for x, y in polygon])
        first = int(angles.argmin())
        sided.append((np.roll(angles, -first), [*polygon[first:], *polygon[:first]]))
    rays = sorted((math.atan2(float(y), float(x)), (x, y)) for polygon in polygons for x, y in polygon)
    whole = Fraction(0)
    for (start, u), (end, v) in zip(rays, [*rays[1:], (rays[0][0] + 2 * math.pi, rays[0][1])], strict=True):
        if cross(u, v) <= 0:
            continue
        middle, best = (start + end) / 2, Fraction(0)
        for angles, corners in sided:
            i = int(np.searchsorted(angles, middle if middle < math.pi else middle - 2 * math.pi)) - 1
            a, b = corners[i], corners[(i + 1) % len(corners)]
            if min(cross(a, u), cross(u, b), cross(a, v), cross(v, b)) < 0 or cross(a, b) <= 0:
                continue
            edge = b[0] - a[0], b[1] - a[1]
            best = max(best, cross(a, b) ** 2 * cross(u, v) / (2 * cross(u, edge) * cross(v, edge)))
        whole += best
    return whole * (1 - Fraction(1, 10**9))  # directions that are equal in floating point may be out of order


def level_polygon(
    values: Callable[[Reals], Reals],
    exact: Callable[[Sequence[Fraction]], Fraction],
    flat: Sequence[Sequence[Fraction]],
    turn: Reals,
    *,
    convex: bool,
) -> Corners:
    """Corners of a polygon around 0 in a level set ``V <= 1`` in the plane, anticlockwise, exactly.

    Where ``V`` is not convex the polygon is cut into triangles: in one of them ``V - q`` is convex, ``q = x' flat x``,
    so that ``V`` exceeds its values in the corners ``p_i`` by at most ``max -q(p_i - p_j)/3``.

    Parameters
    ----------
    values : callable
        ``V`` at points, (k, 2), in floating point.
    exact : callable
        ``V`` at a point, exactly; above 1 where it is not known.
    flat : sequence of sequences of Fraction
        (2, 2): ``V`` has second derivatives of at least twice this form on the set.
    turn : ndarray
        (2, 2): what makes of the unit disc about the set.
    convex : bool
        Whether the form is not negative.

    Returns
    -------
    list of pairs of Fraction
        Empty where a triangle is not shown to lie in the set.
    """
    rings, form = (1 if convex else _RINGS), np.array(flat, dtype=float)
    angles = np.linspace(0, 2 * np.pi, _CORNERS, endpoint=False)
    rays = np.column_stack([np.cos(angles), np.sin(angles)]) @ turn.T
    level, points = np.ones(len(rays)), rays
    for _ in range(1 if convex else 2):  # the second time so much farther inside
        points = rays * _reached(values, rays, level - _ROUNDED)[:, None]
        edges = [np.roll(points, -1, axis=0) - points, np.roll(points, 1, axis=0) - points, points / rings]
        sides = [*edges, edges[0] + edges[2], edges[1] + edges[2]]
        falls = np.min([np.einsum("ki,ij,kj->k", side, form, side) for side in sides], axis=0).clip(max=0) * _ROOM / 3
        level = 1 + np.minimum(falls, np.minimum(np.roll(falls, 1), np.roll(falls, -1)))
    corners = [(Fraction(x), Fraction(y)) for x, y in points.astype(np.float32).astype(float).tolist()]

    def bent(x: Fraction, y: Fraction) -> Fraction:
        """What an edge adds."""
        return -(flat[0][0] * x * x + 2 * flat[0][1] * x * y + flat[1][1] * y * y) / 3

    shares = [Fraction(k, rings) for k in range(1, rings + 1)]
    heights = [max(exact((s * x, s * y)) for s in shares) for x, y in corners]
    for (p, top), (q, other) in pairwise(zip([*corners, corners[0]], [*heights, heights[0]], strict=True)):
        ways = [
            (s * (q[0] - p[0]) + k * p[0] / rings, s * (q[1] - p[1]) + k * p[1] / rings) for s in shares for k in (0, 1)
        ]
        ways += [(p[0] / rings, p[1] / rings), (q[0] / rings, q[1] / rings)]
        added = Fraction(0) if convex else max(Fraction(0), *(bent(*way) for way in ways))
        if max(top, other) + added > 1 or cross(p, q) <= 0:
            return []
    return corners


def _reached(values: Callable[[Reals], Reals], rays: Reals, level: Reals | float) -> Reals:
    """How far along each ray a function stays below a level, by halving."""
    low, high = np.zeros(len(rays)), np.full(len(rays), _FAR)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        inside = values(rays * middle[:, None]) <= level
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.asarray(low)


def union_volume(parts: Sequence[Callable[[Reals], Reals]], turn: Reals) -> float:
    """A lower bound of the area or volume of a union of convex sets around 0: of simplices, each in one of them.

    Space is cut into cones from 0; in each the set counts in which the corners reach farthest.

    ``parts``: for each set the values at points, (k, n), n = 2 or 3, of a convex function that is at most 1 on it;
    ``turn``: (n, n): what makes of the unit ball about one of the sets.
    """
    n, count = len(turn), _CONES[len(turn)]
    steps = [one for one in product(range(count + 1), repeat=n) if sum(one) == count]
    place, corners = {one: k for k, one in enumerate(steps)}, list[list[int]]()
    for one in steps:
        moved = [tuple(v + (j == k) - (j == n - 1) for j, v in enumerate(one)) for k in range(n - 1)]
        ways = [[one, *moved]]
        if n == 3:
            ways.append([*moved, (one[0] + 1, one[1] + 1, one[2] - 2)])
        corners += [[place[v] for v in way] for way in ways if all(v in place for v in way)]
    signs = np.array(list(product((1.0, -1.0), repeat=n)))
    rays = (signs[:, None, :] * np.array(steps, dtype=float)).reshape(-1, n) @ turn.T
    cones = (np.array(corners) + len(steps) * np.arange(len(signs))[:, None, None]).reshape(-1, n)
    best = np.zeros(len(cones))
    for value in parts:
        best = np.maximum(best, np.prod(_reached(value, rays, 1 - 1e-9)[cones], axis=1))
    return float(best @ np.abs(np.linalg.det(rays[cones])) / math.factorial(n) * (1 - 1e-9))


def form_said(name: str, rows: Points | None, index: int = 0, *, weights: str = "") -> list[str]:
    """The matrix of a set, rounded so that what is said of the set stays true, and where it is exact.

    Parameters
    ----------
    name : {"P", "Q"}
        ``P`` of a set inside, ``Q`` of one outside.
    rows : sequence of sequences of Fraction, or None
        (n, n); of many states only the place is named, of None nothing is said.
    index : int
        Which of these sets it is.
    weights : str
        What else is rounded; then the rounded set need not lie inside.
    """
    place = f"{'sets' if name == 'P' else 'outside'}[{index}].{name} has it exactly, in Python and in the JSON"
    if rows is None:
        return []
    if len(rows) > _SHOWN:
        return [f"{name} has {len(rows)} rows; {place}."]
    if name == "Q":
        return [f"Q = {form_text(rows, 'below')}, rounded so that this holds for it too; {place}."]
    how = (weights and f"{weights}, rounded") or ", rounded so that its ellipsoid lies inside"
    return [f"P = {form_text(rows, 'above')}{how}; {place}."]


def end_said(end: Fraction | float, towards: str) -> str:
    """An end of an interval, rounded ``"below"`` or ``"above"``."""
    if isinstance(end, float):
        return str(end)
    return text_below(end, 10) if towards == "below" else text_above(end, 10)


def unseen_said(plant: MultivariablePlant | None, word: str) -> list[str]:
    """That a size says little where no ``sigma`` sees some of the states, decided exactly.

    ``word``: what the size is.
    """
    if plant is None:
        return []
    A, row = (fmpq_mat([[to_fmpq(v) for v in one] for one in side]) for side in (plant.A, plant.C))
    rows = list[list[fmpq]]()
    for _ in range(plant.order):
        rows += row.tolist()
        row = row * A
    if fmpq_mat(rows).rank() == plant.order:
        return []
    return [f"No sigma sees some of the states: a set may be made longer along them, and so the {word} says little."]

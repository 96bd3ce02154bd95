"""Closed curves in the plane that solutions cross in one direction alone: bounds of a region of attraction.

Where the region of attraction ends at a periodic solution that repels, the solutions of the field turned outwards by a
small angle wind away from it, inside of it, and those of the field turned inwards close up just outside of it.  Their
vertices, rounded, are proposed here; the checker decides.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, cast

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import system_of
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.polynomial import X, to_fraction
from lure.analysis.questions.region_areas import Points, arcs, area, cross, polygon_within, union_below
from lure.analysis.questions.region_sets import Shape, matrix_of
from lure.arrays import NDArray, np
from lure.plants.multivariable import MultivariablePlant

Point = tuple[float, float]
Arc = tuple[Point, Point | None, Point]  # a straight edge, or a parabola by its control point

_ANGLES = (0.02, 0.004, 0.001, 0.0002)  # by which the field is turned
_WIDE = (0.4, 0.2, 0.1, 0.05)  # tried first, where there is room for fewer arcs
_CLOSE = 0.003  # of the area: the outer curve is close enough to the inner one
_GROWS = 3e-4  # by which a turn of the spiral has to be larger than the one inside it
_CLOSED = 1e-7  # relative distance of the ends of a turn that counts as closed
_TURNS, _ARCS, _STEPS, _HALVINGS = 80, 4000, 4000, 24
_FAR, _BITS, _RAYS, _REST = 1e4, 44, 16, 0.003
_WORTH = Fraction(101, 100)
_TIMES = (0.0, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0)


class PlanarSets(NamedTuple):
    """What the checker accepted: curves inside of the region, and one around it, or None."""

    inside: tuple[Proved, ...]
    outside: Refuted | None


def planar_sets(plant: MultivariablePlant, shapes: Sequence[Shape], first: Proved) -> PlanarSets:
    """Polygons on both sides of the end of the region of attraction, of a loop with two states in continuous time.

    ``first``: an ellipsoid inside of the region.
    """
    nothing = PlanarSets((), None)
    known = all(shape.pieces for shape in shapes) and first.certificate["proof"]["method"] == "ellipsoid"
    if plant.order != 2 or plant.dt is not None or any(map(any, plant.D)) or not known:
        return nothing
    try:
        search = _Search(plant, shapes, np.array(matrix_of(first.certificate), dtype=float))
    except np.linalg.LinAlgError:
        return nothing  # not definite in floating point
    if not search.sense:
        return nothing
    base: dict[str, Any] = {"system": system_of(plant), "laws": {"graphs": [shape.entry(None) for shape in shapes]}}
    inner, outer = list[list[list[Arc]]](), list[list[Arc]]()
    for angle in _ANGLES:
        checkpoint()
        if search.wound(angle) or not inner:
            inner += [list(search.turns)] * bool(search.turns and len(shapes) == 1)
        around = search.closed(angle)
        outer += [] if around is None else [around]
        sizes = [area(_exactly(search.written(turn))) for turn in (*(found[0] for found in inner[-1:]), *outer[-1:])]
        if around is None or (len(sizes) > 1 and sizes[1] <= (1 + _CLOSE) * sizes[0]):
            break
    proof: dict[str, Any] = first.certificate["proof"] | {"method": "spiral"}
    written = ([search.written(turn) for turn in turns] for turns in inner[::-1])
    spirals = ({**first.certificate, "theorem": "planar", "proof": proof | {"turns": turns}} for turns in written)
    base |= {"verdict": "REFUTED", "theorem": "counterexample", "multiplier": {}}
    orbits = ({"orbit": True}, {}) if len(shapes) == 1 else ({},)
    curves = (
        {**base, "proof": {"method": "curve", "points": search.written(one), **orbit}}
        for one in outer[::-1]
        for orbit in orbits
    )
    inside, outside = (next(filter(None, map(_accepted, drafts)), None) for drafts in (spirals, curves))
    if not isinstance(inside, Proved):
        return PlanarSets((), cast("Refuted | None", outside))
    both: tuple[Proved, ...] = (inside,)
    own, opposite = (polygon_within(points) for points in (points_of(inside), _mirrored(points_of(inside))))
    if _odd(shapes[0]) and union_below([own, opposite]) > _WORTH * union_below([own]):
        turns = [_mirrored(turn) for turn in inside.certificate["proof"]["turns"]]
        other = _accepted({**inside.certificate, "proof": inside.certificate["proof"] | {"turns": turns}})
        both = (inside, other) if isinstance(other, Proved) else both
    return PlanarSets(both, cast("Refuted | None", outside))


def _odd(shape: Shape) -> bool:
    """Whether ``phi(-sigma) = -phi(sigma)``."""
    turned = tuple(-piece(-X) for piece in shape.pieces[::-1])
    return turned == shape.pieces and tuple(-cut for cut in shape.cuts[::-1]) == shape.cuts


def _mirrored(points: Any) -> Any:  # noqa: ANN401  (numbers, or their texts)
    """The curve through the opposite points."""
    return [[str(-Fraction(v)) if isinstance(v, str) else -v for v in row] for row in points]


def _exactly(rows: Sequence[Sequence[str]]) -> Points:
    return tuple(tuple(Fraction(v) for v in row) for row in rows)


def points_of(shown: Proved | Refuted) -> Points:
    """The curve of a certificate, once around 0: its start, then for each arc its end, and before it its control point.

    ``shown``: by ``spiral`` or ``curve``.
    """
    proof = shown.certificate["proof"]
    return _exactly(proof["turns"][0] if proof["method"] == "spiral" else proof["points"])


def within(points: Points, x: tuple[Fraction, Fraction]) -> bool:
    """Whether a point lies within a closed curve, or on it, exactly; the curve is seen whole from 0.

    A parabola is ``v^2 = 4 u w`` in the coordinates ``u, v, w`` of its triangle, with ``u + v + w = 1``.

    ``points``: as :func:`points_of` has them.
    """
    if not any(x):
        return True
    for p, c, q in arcs(points):
        side = 1 if cross(p, q) > 0 else -1
        if cross(p, q) == 0 or side * cross(p, x) < 0 or side * cross(x, q) < 0 or side * cross(p, q) < 0:
            continue
        whole = cross(p, q) - cross(x, q) - cross(p, x)  # not negative, times the side, on this side of the chord
        near = side * whole >= 0
        if c is None:
            return bool(near)
        size = cross(p, c) + cross(c, q) - cross(p, q)
        if size == 0:
            return bool(near)
        v = -whole / size
        u = (cross(x, c) + cross(c, q) - cross(x, q)) / size
        bulge = v >= 0 and u >= 0 and u + v <= 1 and v * v <= 4 * u * (1 - u - v)
        outwards = side * size > 0  # the arc lies beyond its chord
        return bool(near or bulge) if outwards else bool(near and (not bulge or v * v == 4 * u * (1 - u - v)))
    return False


def drawn(points: Points) -> NDArray[np.float64]:
    """Points along a closed curve, (k, 2), in floating point; ``points``: as :func:`points_of` has them."""
    t, found = np.linspace(0, 1, 8, endpoint=False)[:, None], list[Any]()
    for p, c, q in arcs(points):
        a, b = np.array(p, dtype=float), np.array(q, dtype=float)
        middle = (a + b) / 2 if c is None else np.array(c, dtype=float)
        found.append((1 - t) ** 2 * a + 2 * t * (1 - t) * middle + t**2 * b)
    return np.concatenate(found)


def gauge(points: Points) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Of a closed curve the factor by which it would have to grow to reach points, (k, 2), in floating point.

    ``points``: as :func:`points_of` has them.
    """
    corners = drawn(points)
    angles = np.arctan2(corners[:, 1], corners[:, 0])
    order = np.argsort(angles)
    corners, angles = corners[order], angles[order]
    edges = np.roll(corners, -1, axis=0) - corners
    across = corners[:, 0] * edges[:, 1] - corners[:, 1] * edges[:, 0]

    def factor(places: NDArray[np.float64]) -> NDArray[np.float64]:
        """At points, (k, 2)."""
        place = np.searchsorted(angles, np.arctan2(places[:, 1], places[:, 0])) - 1
        edge, size = edges[place], across[place]
        return np.asarray((places[:, 0] * edge[:, 1] - places[:, 1] * edge[:, 0]) / np.where(size == 0, 1e-300, size))

    return factor


def _accepted(draft: dict[str, Any]) -> Proved | Refuted | None:
    try:
        return checked(draft)
    except (Rejected, Malformed):
        return None


class _Search:
    """Turns around 0 of the field turned by an angle, in coordinates in which the ellipsoid is the unit disc."""

    def __init__(self, plant: MultivariablePlant, shapes: Sequence[Shape], P: NDArray[np.float64]) -> None:
        A, B, C, _ = plant.doubles()
        to = np.linalg.cholesky(P).T
        self.back = np.linalg.inv(to)
        self.field = _field(to @ A @ self.back, to @ B, C @ self.back, shapes)
        self.cuts = [
            (r, q, list(map(float, shape.cuts))) for (r, q), shape in zip((C @ self.back).tolist(), shapes, strict=True)
        ]
        self.sense, self.ray, self.exact_ray = 0, (1.0, 0.0), (Fraction(1), Fraction(0))
        self._choose_ray()
        self.turns: list[list[Arc]] = []  # each back in time, the outermost first
        self.start = 0.0

    def _choose_ray(self) -> None:
        """The ray from 0 that solutions cross best, and in which sense they go around; 0 if they do not."""
        best = 0.0
        for k in range(_RAYS):
            c, s = math.cos(2 * math.pi * k / _RAYS), math.sin(2 * math.pi * k / _RAYS)
            crossings = list[float]()
            for factor in (0.05, 0.2, 0.5, 0.9, 1.2, 1.6):
                u, v = self.field(factor * c, factor * s)
                crossings.append((c * v - s * u) / max(math.hypot(u, v), 1e-300))
            worst = min(crossings) if crossings[0] > 0 else -max(crossings)
            if worst > best:
                given = self.back @ np.array([c, s])
                exact = tuple(_rounded(float(x), abs(float(x)), 20) for x in given)
                near = np.linalg.solve(self.back, np.array([float(x) for x in exact]))
                best, self.sense = worst, 1 if crossings[0] > 0 else -1
                self.ray, self.exact_ray = (float(near[0]), float(near[1])), (exact[0], exact[1])

    def wound(self, angle: float) -> bool:
        """Wind outwards from the ellipsoid, the field turned outwards by angles down to this one; whether it grew."""
        if not self.turns and not self._begun(angle):
            return False
        grew = False
        while len(self.turns) < _TURNS and sum(map(len, self.turns)) < _ARCS:
            checkpoint()
            fine = self.turn(self.start, angle, inner=True)
            if fine is None:
                return self._last(angle) or grew
            if fine[1] < (1 + _GROWS) * self.start:
                break
            for wide in _WIDE:
                one = self.turn(self.start, wide, inner=True)
                if one is not None and math.log(one[1] / self.start) > 0.6 * math.log(fine[1] / self.start):
                    fine = one
                    break
            arcs, self.start = fine
            self.turns.insert(0, arcs)
            grew = True
        return grew

    def _last(self, angle: float) -> bool:
        """A turn that ends inside the one before, where none begins at its start: as large as it may be."""
        low, high, best = 0.0, self.start, None
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            one = self.turn(middle, angle, inner=True)
            if one is None:
                high = middle
            else:
                low, best = middle, one
        if best is None or best[1] < (1 + _GROWS) * self.start:
            return False
        self.turns.insert(0, best[0])
        self.start = best[1]
        return True

    def _begun(self, angle: float) -> bool:
        """The innermost turn: begun in the disc, as far out as it may be."""
        size = math.hypot(*self.ray)
        for part in (0.95, 0.8, 0.6, 0.4, 0.2, 0.1):
            for each in (*_WIDE, angle):
                one = self.turn(part / size, each, inner=True)
                if one is not None and one[1] > part / size:
                    self.turns, self.start = [one[0]], one[1]
                    return True
        return False

    def closed(self, angle: float) -> list[Arc] | None:
        """A curve around the region: a turn of the field turned inwards that closes almost; None if there is none."""
        at = self.start or 1 / math.hypot(*self.ray)
        for _ in range(_TURNS):
            checkpoint()
            one = self.turn(at, angle, inner=False)
            if one is None:
                return None
            before, at = at, one[1]
            if abs(at / before - 1) < _CLOSED:
                outer = self.turn(at * (1 + 10 * _CLOSED), angle, inner=False)
                return None if outer is None else outer[0]
        return None

    def turn(self, factor: float, angle: float, *, inner: bool) -> tuple[list[Arc], float] | None:
        """Once around from the ray, back in time: the arcs, and the factor on the ray at the end; None if none."""
        turned = -self.sense * angle if inner else self.sense * angle
        c, s, field = math.cos(turned), math.sin(turned), self.field

        def along(x: float, y: float) -> Point:
            """The unit vector along the turned field, back in time."""
            u, v = field(x, y)
            size = math.hypot(u, v) or 1e-300
            return (s * v - c * u) / size, (-s * u - c * v) / size

        def moved(x: float, y: float, first: Point, step: float) -> Point:
            """A step of Runge and Kutta's fourth order."""
            a, b = first
            p, q = along(x + step / 2 * a, y + step / 2 * b)
            r, t = along(x + step / 2 * p, y + step / 2 * q)
            g, h = along(x + step * r, y + step * t)
            return x + step / 6 * (a + 2 * p + 2 * r + g), y + step / 6 * (b + 2 * q + 2 * t + h)

        (a, b), at = self.ray, (factor * self.ray[0], factor * self.ray[1])
        arcs, passed, way = list[Arc](), 0.0, along(*at)
        step, margin = 0.2 * math.hypot(*at), math.sin(angle) * (-turned / angle)
        for _ in range(_STEPS):
            size = math.hypot(*at)
            step = min(step, 0.3 * size)
            end = moved(*at, way, step)
            gone = -self.sense * math.atan2(cross(at, end), at[0] * end[0] + at[1] * end[1])
            last = passed + gone >= 2 * math.pi - 1e-12
            if last:
                low, high = 0.0, step
                for _ in range(60):  # where the ray is
                    middle = (low + high) / 2
                    end = moved(*at, way, middle)
                    low, high = (middle, high) if self.sense * cross(end, (a, b)) < 0 else (low, middle)
                end = moved(*at, way, high)
                end = (a * math.hypot(*end) / math.hypot(a, b), b * math.hypot(*end) / math.hypot(a, b))
                step = max(high, 1e-12 * size)
            after = along(*end)
            one = self._arc(at, end, way, after, margin)
            if one is None or 0 < 2 * math.pi - passed - gone < _REST:
                step *= 0.6
                if step < 1e-7 * size:
                    return None
                continue
            if gone <= 0 or not math.hypot(*end) < _FAR:
                return None
            arcs.append(one)
            if last:
                return arcs, math.hypot(*end) / math.hypot(a, b)
            passed, step, at, way = passed + gone, 1.5 * step, end, after
        return None

    def _arc(self, p: Point, q: Point, way: Point, after: Point, margin: float) -> Arc | None:
        """A parabola with these tangents, or else a straight edge, that ``x'`` crosses; None if it does not."""
        chord, bend = (q[0] - p[0], q[1] - p[1]), cross(way, after)
        if abs(bend) > 1e-7:
            far, back = cross(chord, after) / bend, cross(way, chord) / bend
            size = 2 * math.hypot(*chord)
            if 0 < far < size and 0 < back < size:
                c = (p[0] + far * way[0], p[1] + far * way[1])
                if self._one_piece((p, c, q)) and self._crossed((p, c, q), margin):
                    return p, c, q
        return (p, None, q) if self._crossed((p, None, q), margin) else None

    def _one_piece(self, points: Sequence[Point]) -> bool:
        for r, s, cuts in self.cuts:
            values = [r * x + s * y for x, y in points]
            room = 1e-9 * max(map(abs, values))
            if any(min(values) - room < cut < max(values) + room for cut in cuts):
                return False
        return True

    def _crossed(self, arc: Arc, margin: float) -> bool:
        """Whether some points of it say so; a rounded arc has to be crossed as well."""
        p, c, q = arc
        for t in _TIMES:
            if c is None:
                x, y, u, v = p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), q[0] - p[0], q[1] - p[1]
            else:
                x, y = ((1 - t) ** 2 * p[k] + 2 * t * (1 - t) * c[k] + t * t * q[k] for k in (0, 1))
                u, v = ((1 - t) * (c[k] - p[k]) + t * (q[k] - c[k]) for k in (0, 1))
            f, g = self.field(x, y)
            found = (v * f - u * g) / (math.hypot(u, v) * math.hypot(f, g) or 1e-300)  # seen forward in time
            if found * math.copysign(1, margin) < 0.3 * abs(margin):
                return False
        return True

    def written(self, turn: Sequence[Arc]) -> list[list[str]]:
        """A turn as in a certificate, forward in time: its start, then control points and ends of the arcs."""
        ends = [turn[-1][2], *(p for p, _, _ in turn[::-1])]
        states = np.array([*ends, *(c for _, c, _ in turn if c is not None)]) @ self.back.T
        sizes = [float(v) for v in np.abs(states).max(axis=0)]

        def exact(point: Point) -> list[str]:
            """In the states, rounded."""
            state = self.back @ np.array(point)
            return [str(_rounded(float(v), size, _BITS)) for v, size in zip(state, sizes, strict=True)]

        def on_ray(point: Point) -> list[str]:
            """On the ray, exactly."""
            factor = _rounded(math.hypot(*point) / math.hypot(*self.ray), 1.0, _BITS)
            return [str(factor * v) for v in self.exact_ray]

        rows = [on_ray(ends[0])]
        for (_, c, _), end in zip(turn[::-1], ends[1:], strict=True):
            rows.append([*([] if c is None else exact(c)), *exact(end)])
        rows[-1][-2:] = on_ray(ends[-1])
        return rows


def _rounded(value: float, size: float, bits: int) -> Fraction:
    step = Fraction(2) ** (math.floor(math.log2(max(size, 1e-300))) - bits)
    return round(Fraction(value) / step) * step


def _field(
    A: NDArray[np.float64], B: NDArray[np.float64], C: NDArray[np.float64], shapes: Sequence[Shape]
) -> Callable[[float, float], Point]:
    """``x'`` in floating point."""
    (a, b), (c, d) = A.tolist()
    channels = list[tuple[float, float, float, float, list[float], list[list[float]]]]()
    for i, shape in enumerate(shapes):
        pieces = [[float(to_fraction(v)) for v in p.coeffs()][::-1] or [0.0] for p in shape.pieces]
        cuts = [float(cut) for cut in shape.cuts]
        channels.append((float(B[0, i]), float(B[1, i]), float(C[i, 0]), float(C[i, 1]), cuts, pieces))

    def field(x: float, y: float) -> Point:
        """At a point."""
        u, v = a * x + b * y, c * x + d * y
        for p, q, r, s, cuts, pieces in channels:
            sigma, value = r * x + s * y, 0.0
            for coefficient in pieces[bisect_left(cuts, sigma)]:
                value = value * sigma + coefficient
            u, v = u - p * value, v - q * value
        return u, v

    return field

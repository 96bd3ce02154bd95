"""Sets inside and beyond a region of attraction: proposed in floating point, rounded, decided by the checker."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from flint import arb, fmpq_mat, fmpq_poly

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import system_of
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.ellipsoids import Ellipsoid, Local, ellipsoid, growing, shifted
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.nonlinearity.pieces import known_nonlinearity
from lure.analysis.nonlinearity.rational import interval_of, roots_between
from lure.analysis.numerics.polynomial import X, to_fmpq, to_fraction
from lure.analysis.verdict import Evidence
from lure.arrays import NDArray, np
from lure.errors import InputError
from lure.plants.multivariable import MultivariablePlant

MARGINS = (1e-7, 1e-5, 1e-3, 1e-2)
_BITS = 40
_GRID = np.concatenate([np.linspace(-1, -0.005, 200), np.linspace(0.005, 1, 200)])
_FIXED = np.geomspace(1e-7, 1e7, 1400)


@dataclass(frozen=True, kw_only=True, slots=True)
class Shape:
    """What is known of one nonlinearity: polynomials between cuts, or a sector on an interval, or bounds on demand.

    Attributes
    ----------
    nonlinearity : object
        The nonlinearity, or a class with a reach.
    cuts, pieces : tuple
        The graph, exactly; no pieces where it is none of polynomials.
    sector, reach : tuple of Fraction and Fraction, or None
        A class that holds for ``|sigma| <= reach`` alone.
    """

    nonlinearity: Any
    cuts: tuple[Fraction, ...] = ()
    pieces: tuple[fmpq_poly, ...] = ()
    sector: tuple[Fraction, Fraction] | None = None
    reach: Fraction | None = None

    @property
    def clip(self) -> tuple[Fraction, Fraction, Fraction] | None:
        """``e, u`` and the smaller limit of a line with limits on both sides; None for others."""
        if len(self.pieces) != 3 or max(p.degree() for p in self.pieces) > 1 or not self.cuts[0] < 0 < self.cuts[1]:
            return None
        left, middle, right = self.pieces
        low, high = sorted((to_fraction(left[0]), to_fraction(right[0])))
        if left[1] != right[1] or not low < 0 < high:
            return None
        return to_fraction(left[1]), to_fraction(middle[1]), min(-low, high)

    def entry(self, bounds: tuple[Fraction, Fraction, Fraction] | None) -> dict[str, Any]:
        """The nonlinearity as it stands in a certificate; of one that is no polynomial its bounds on an interval."""
        if self.pieces:
            return {
                "kind": "piecewise-polynomial",
                "cuts": [str(cut) for cut in self.cuts],
                "pieces": [[str(to_fraction(c)) for c in piece.coeffs()] or ["0"] for piece in self.pieces],
            }
        if self.sector is not None:
            low, high, reach = *self.sector, self.reach
        else:
            assert bounds is not None, "nothing else is known of it"
            low, high, reach = bounds
        return {"kind": "sector", "sector": [str(low), str(high)], "reach": str(reach)}

    def sampled(self, reach: float) -> tuple[float, float] | None:
        """About the sector on ``|sigma| <= reach``, from values."""
        if self.sector is not None:
            assert self.reach is not None, "they go together"
            return (float(self.sector[0]), float(self.sector[1])) if reach <= self.reach else None
        own = _FIXED[reach > _FIXED]
        sigma = np.concatenate([reach * _GRID, own, -own])
        chords = np.asarray(self.nonlinearity(sigma)) / sigma
        return (float(chords.min()), float(chords.max())) if np.isfinite(chords).all() else None

    def bounds(self, reach: Fraction) -> tuple[Fraction, Fraction] | None:
        """The sector on ``|sigma| <= reach``, certified; None where there is none."""
        if self.sector is not None:
            return self.sector
        found = nonlinearity_bounds(self.nonlinearity, on=(-reach, reach))
        low, high = found.sector_lower.outer, found.sector_upper.outer
        if found.evidence is not Evidence.CERTIFIED or not (math.isfinite(low) and math.isfinite(high)):
            return None
        return -_above(-Fraction(low)), _above(Fraction(high))


def shape_of(nonlinearity: Any) -> Shape:  # noqa: ANN401  (whatever is taken as a nonlinearity)
    """What is known of a nonlinearity exactly.

    Parameters
    ----------
    nonlinearity : object
        A nonlinearity of the library.

    Raises
    ------
    InputError
        It is known by its values alone.
    """
    known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
    if known is None:
        raise InputError(
            f"{nonlinearity!s:.60} is known by its values alone, which bound nothing; give a formula, or one of the "
            "library"
        )
    ratios = [piece.ratio for piece in known.pieces]
    if any(r is None or r.bottom.degree() > 0 or r.poles.degree() > 0 for r in ratios):
        return Shape(nonlinearity=nonlinearity)
    polynomials = [r.top / r.bottom[0] for r in ratios if r is not None]
    cuts, kept = list[Fraction](), [polynomials[0]]
    for piece, polynomial in zip(known.pieces[1:], polynomials[1:], strict=True):
        if polynomial != kept[-1]:
            if kept[-1](to_fmpq(Fraction(piece.low))) != polynomial(to_fmpq(Fraction(piece.low))):
                return Shape(nonlinearity=nonlinearity)
            cuts.append(Fraction(piece.low))
            kept.append(polynomial)
    return Shape(nonlinearity=nonlinearity, cuts=tuple(cuts), pieces=tuple(kept))


# Ellipsoids.


def proved_ellipsoid(
    plant: MultivariablePlant, shapes: Sequence[Shape], points: NDArray[np.float64] | None
) -> Proved | None:
    """A large ellipsoid whose solutions all tend to 0, accepted by the checker; None where none is found.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part.
    shapes : sequence of Shape
        What is known of the nonlinearity of each channel.
    points : ndarray or None
        (k, n) points whose largest multiple it is to hold; None for the largest volume.
    """
    best = _reaches(plant, shapes, points)
    if best is None:
        return None
    for margin in MARGINS:
        for shrunk in (Fraction(1), Fraction(999, 1000)):
            checkpoint()
            draft = _draft(plant, shapes, [None if c is None else c * shrunk for c in best], points, margin)
            if draft is None:
                continue
            try:
                found = checked(draft)
            except (Rejected, Malformed):
                continue
            assert isinstance(found, Proved), "the checker makes it of this verdict"
            return found
    return None


def _local(
    plant: MultivariablePlant, shapes: Sequence[Shape], reaches: Sequence[Fraction | None], *, exactly: bool
) -> tuple[list[Local], list[tuple[Fraction, Fraction] | None]] | None:
    """What the search uses of each channel, and the sectors; channel after channel, as ``D`` has it."""
    most, found = dict[int, float](), dict[int, Local]()
    sectors: list[tuple[Fraction, Fraction] | None] = [None] * len(shapes)
    left = set(range(len(shapes)))
    while left:
        free = [i for i in left if not any(plant.D[i][j] for j in left)]
        if not free:
            return None
        for i in free:
            left.discard(i)
            clip, reach = shapes[i].clip, reaches[i]
            if clip is not None:
                found[i] = Local(float(clip[0]), float(clip[1]), float(clip[2]), math.inf)
                most[i] = max(abs(float(p[0])) for p in shapes[i].pieces) if clip[0] == 0 else math.inf
                continue
            assert reach is not None, "a sector has one"
            bounds = shapes[i].bounds(reach) if exactly else shapes[i].sampled(float(reach))
            if bounds is None:
                return None
            if exactly:
                sectors[i] = (Fraction(bounds[0]), Fraction(bounds[1]))
            low, high = float(bounds[0]), float(bounds[1])
            high += 1e-12 * (abs(high) + abs(low)) * (high == low)
            rest = float(reach) - sum(abs(float(d)) * most[j] for j, d in enumerate(plant.D[i]) if d)
            if not rest > 0:
                return None
            found[i] = Local(low, high, None, rest)
            most[i] = max(abs(low), abs(high)) * float(reach)
    return [found[i] for i in range(len(shapes))], sectors


def _reaches(
    plant: MultivariablePlant, shapes: Sequence[Shape], points: NDArray[np.float64] | None
) -> list[Fraction | None] | None:
    """For each sector the interval on which it is used: the best found, one after the other, by golden sections."""
    sides, discrete = plant.doubles(), plant.dt is not None
    own = [i for i, shape in enumerate(shapes) if shape.clip is None]

    def size(logs: Sequence[float]) -> float:
        """How large the ellipsoid is; -inf where there is none."""
        checkpoint()
        given: list[Fraction | None] = [None] * len(shapes)
        for i, log in zip(own, logs, strict=True):
            reach = Fraction(2.0**log).limit_denominator(10**9) if log > -20 else Fraction(2.0**log)
            given[i] = reach if shapes[i].reach is None else min(reach, shapes[i].reach or reach)
        used = _local(plant, shapes, given, exactly=False)
        found = None if used is None else ellipsoid(sides, used[0], discrete=discrete, points=points)
        if found is None:
            return -math.inf
        if points is None:
            return found.size
        return -max(0.5 * math.log(p @ found.P @ p) for p in points)

    if not own:
        return [None] * len(shapes)
    sizes = [(size([k] * len(own)), float(k)) for k in range(-24, 25, 2)]
    value, start = max(sizes)
    if value == -math.inf:
        return None
    logs = [start] * len(own)
    for width in (2.0, 1.0) if len(own) > 1 else (2.0,):
        for place in range(len(own)):

            def along(log: float, place: int = place) -> float:
                """The size with another interval of one channel."""
                return size([*logs[:place], log, *logs[place + 1 :]])

            best = _golden(along, logs[place] - width, logs[place] + width)
            if along(best) >= value:
                logs[place], value = best, along(best)
    out: list[Fraction | None] = [None] * len(shapes)
    for i, log in zip(own, logs, strict=True):
        reach = Fraction(2.0**log).limit_denominator(10**6) if log > -12 else Fraction(2.0**log)
        out[i] = min(reach, shapes[i].reach or reach)
    return out


def _golden(value: Callable[[float], float], low: float, high: float, rounds: int = 14) -> float:
    """About where a function with one peak is largest."""
    ratio = (math.sqrt(5) - 1) / 2
    a, b = high - ratio * (high - low), low + ratio * (high - low)
    at_a, at_b = value(a), value(b)
    for _ in range(rounds):
        if at_a >= at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = value(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = value(b)
    return a if at_a >= at_b else b


def _draft(
    plant: MultivariablePlant,
    shapes: Sequence[Shape],
    reaches: Sequence[Fraction | None],
    points: NDArray[np.float64] | None,
    margin: float,
) -> dict[str, Any] | None:
    used = _local(plant, shapes, reaches, exactly=True)
    if used is None:
        return None
    local, sectors = used
    found = ellipsoid(plant.doubles(), local, discrete=plant.dt is not None, points=points, margin=margin)
    if found is None or not all(np.isfinite(part).all() for part in found):
        return None
    grown = _grown(plant, local, found)
    P = _rounded(found.P * grown)
    terms = list[dict[str, Any]]()
    for i, one in enumerate(local):
        weight = {"channel": i + 1, "weight": str(_short(float(found.weights[i]) * grown))}
        if one.limit is None:
            sector, reach = sectors[i], reaches[i]
            assert sector is not None, "it was certified"
            terms.append({**weight, "sector": [str(v) for v in sector], "reach": str(reach)})
        else:
            unit = 2.0 ** (math.floor(math.log2(one.limit)) - _BITS)
            columns = np.sqrt(np.diag(found.P))
            steps = [unit * 2.0 ** math.floor(math.log2(v)) for v in columns]
            terms.append({**weight, "row": [str(_step(v, s)) for v, s in zip(found.rows[i], steps, strict=True)]})
    entries = [
        shape.entry(None if sector is None or reach is None else (*sector, reach))
        for shape, sector, reach in zip(shapes, sectors, reaches, strict=True)
    ]
    return {
        "verdict": "PROVED",
        "system": system_of(plant),
        "laws": {"graphs": entries},
        "theorem": "local-circle",
        "multiplier": {"terms": terms},
        "proof": {"method": "ellipsoid", "P": [[str(v) for v in row[: i + 1]] for i, row in enumerate(P)]},
    }


def _grown(plant: MultivariablePlant, local: Sequence[Local], found: Ellipsoid) -> float:
    """The factor of ``P`` with which the ellipsoid touches its strips, almost."""
    C = plant.doubles()[2]
    ratios = list[float]()
    for i, one in enumerate(local):
        row, limit = (C[i], one.reach) if one.limit is None else (found.rows[i], one.limit)
        ratios.append(float(row @ np.linalg.solve(found.P, row)) / limit**2)
    return max(*ratios, 1e-12) * (1 + 1e-9) if len(ratios) > 1 else max(ratios[0], 1e-12) * (1 + 1e-9)


def _rounded(P: NDArray[np.float64]) -> list[list[Fraction]]:
    """A symmetric matrix with entries of few digits, relative to the diagonal."""
    scale = [math.floor(math.log2(math.sqrt(v))) for v in np.diag(P)]
    n = len(P)
    steps = [[2.0 ** (scale[i] + scale[j] - _BITS) for j in range(n)] for i in range(n)]
    return [[_step(float(P[max(i, j), min(i, j)]), steps[i][j]) for j in range(n)] for i in range(n)]


def _step(value: float, step: float) -> Fraction:
    return round(value / step) * Fraction(step)


def _above(value: Fraction) -> Fraction:
    """The number itself if it is short, else one of few digits that is not below it."""
    if value.denominator.bit_length() < 2 * _BITS:
        return value
    unit = Fraction(2) ** (math.floor(math.log2(abs(value))) - _BITS)
    return math.ceil(value / unit) * unit


def _short(value: float) -> Fraction:
    return _step(value, 2.0 ** (math.floor(math.log2(abs(value))) - 30)) if value else Fraction(0)


# Starts outside.


def proved_growth(plant: MultivariablePlant, shapes: Sequence[Shape]) -> Refuted | None:
    """A set ``x'Q x > 1`` from which every solution grows; None where none is found.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part.
    shapes : sequence of Shape
        What is known of each nonlinearity: all have to be lines with limits.
    """
    clips = [clip for shape in shapes if (clip := shape.clip) is not None]
    if len(clips) < len(shapes):
        return None
    A, B, C, D = plant.doubles()
    outer = np.array([float(e) for e, *_ in clips])
    sides = shifted((A, B, C, D), outer)
    most = [max(abs(to_fraction(piece[0])) for piece in shape.pieces) for shape in shapes]
    limits = np.array([float(v) for v in most])
    for margin in MARGINS:
        checkpoint()
        found = growing(sides, limits, discrete=plant.dt is not None, margin=margin)
        if found is None:
            continue
        weights = [_short(float(w)) for w in found.weights]
        rate = max(_short(found.rate), sum((w * v * v for w, v in zip(weights, most, strict=True)), Fraction(0)))
        diagonal = np.abs(np.diag(found.Q)) + 1e-6 * float(np.abs(found.Q).max())
        scale = [math.floor(math.log2(math.sqrt(v))) for v in diagonal]
        rows = [
            [str(_step(float(found.Q[i, j]), 2.0 ** (scale[i] + scale[j] - _BITS))) for j in range(i + 1)]
            for i in range(plant.order)
        ]
        try:
            shown = checked(
                {
                    "verdict": "REFUTED",
                    "system": system_of(plant),
                    "laws": {"graphs": [shape.entry(None) for shape in shapes]},
                    "theorem": "counterexample",
                    "multiplier": {},
                    "proof": {"method": "growth", "Q": rows, "rate": str(rate), "weights": [str(w) for w in weights]},
                }
            )
        except (Rejected, Malformed):
            continue
        assert isinstance(shown, Refuted), "the checker makes it of this verdict"
        return shown
    return None


# One state: signs.


def sign_interval(plant: MultivariablePlant, shapes: Sequence[Shape]) -> tuple[Proved | None, Refuted | None] | None:
    """Of a loop with one state the interval from which all solutions tend to 0, and that outside which none does.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part.
    shapes : sequence of Shape
        What is known of each nonlinearity.

    Returns
    -------
    tuple or None
        The proof and the refutation of what lies outside, as far as they are found; None where the loop has another
        number of states, ``D`` is not 0 or a nonlinearity is not known exactly.
    """
    if plant.order != 1 or any(map(any, plant.D)) or not all(shape.pieces for shape in shapes):
        return None
    rows = [row[0] for row in plant.C]
    cuts = sorted({Fraction(0), *(x / c for shape, c in zip(shapes, rows, strict=True) if c for x in shape.cuts)})
    whole = list[tuple[Any, Any, fmpq_poly]]()
    ends: list[Any] = [-math.inf, *cuts, math.inf]
    for low, high in pairwise(ends):
        middle = high - 1 if low == -math.inf else low + 1 if high == math.inf else (low + high) / 2
        f = to_fmpq(plant.A[0][0]) * X
        for shape, b, c in zip(shapes, plant.B[0], rows, strict=True):
            piece = shape.pieces[sum(x < c * middle for x in shape.cuts)]
            f -= to_fmpq(b) * piece(to_fmpq(c) * X)
        whole.append((low, high, f))
    discrete = plant.dt is not None
    left, right = (_first(whole, side, discrete=discrete) for side in (-1, 1))
    if left is None or right is None:
        return None, None
    (low_in, low_out), (high_in, high_out) = left, right
    if discrete:
        high_in, high_out = min(high_in, -low_in), min(high_out, -low_out)
        low_in, low_out = -high_in, -high_out
    laws = {"graphs": [shape.entry(None) for shape in shapes]}
    base = {"system": system_of(plant), "laws": laws, "multiplier": {}}

    def accepted(low: Any, high: Any, **more: str) -> Any:  # noqa: ANN401  (Proved, Refuted or None)
        """What the checker makes of an interval."""
        proof = {"method": "signs", "interval": [_end(low), _end(high)]}
        try:
            return checked({**base, **more, "proof": proof})
        except (Rejected, Malformed):
            return None

    inside = accepted(low_in, high_in, verdict="PROVED", theorem="scalar")
    outside = None
    if (low_out, high_out) != (-math.inf, math.inf):
        outside = accepted(low_out, high_out, verdict="REFUTED", theorem="counterexample")
    return inside, outside


def _end(value: Fraction | float) -> str:
    return str(value) if isinstance(value, Fraction) else "inf" if value > 0 else "-inf"


def _first(whole: Sequence[tuple[Any, Any, fmpq_poly]], side: int, *, discrete: bool) -> tuple[Any, Any] | None:
    """Where the attraction ends on one side of 0: a bound inside and one outside; None if there is none near 0."""
    parts = [part for part in whole if (part[0] >= 0 if side > 0 else part[1] <= 0)][::side]
    for low, high, f in parts:
        near = low if side > 0 else high
        for p in (X - f, X + f) if discrete else (-f,):
            if p.degree() < 0:
                return None if near == 0 else (near, near)
        functions = (X - f, X + f) if discrete else (f,)
        roots = [root for p in functions for root in roots_between(p, low, high)]
        middle = _between(low, high, roots, side)
        value = f(to_fmpq(middle))
        attracted = abs(value) < abs(to_fmpq(middle)) if discrete else value * side < 0
        if not attracted:
            return None if near == 0 else (near, near)
        found = [root if isinstance(root, Fraction) else interval_of(root) for root in roots]
        spans = [(root, root) if isinstance(root, Fraction) else root for root in found]
        if spans:
            first = min(spans) if side > 0 else max(spans)
            return (first[0], first[1]) if side > 0 else (first[1], first[0])
        far = high if side > 0 else low
        if not math.isinf(far) and any(p(to_fmpq(far)) == 0 for p in functions):
            return far, far
    return side * math.inf, side * math.inf


def _between(low: Any, high: Any, roots: Sequence[Fraction | arb], side: int) -> Fraction:  # noqa: ANN401  (ends)
    """A point of the piece before the first root."""
    near, far = (low, high) if side > 0 else (high, low)
    places: list[Any] = [
        root if isinstance(root, Fraction) else interval_of(root)[0 if side > 0 else 1] for root in roots
    ]
    if places:
        far = min(places) if side > 0 else max(places)
    return near + side if math.isinf(far) else (Fraction(near) + Fraction(far)) / 2


def volume_below(P: Sequence[Sequence[Fraction]]) -> float:
    """A lower bound of the length, area or volume of ``{x : x'P x <= 1}``.

    Parameters
    ----------
    P : sequence of sequences of Fraction
        Symmetric, positive definite.
    """
    return _volume(P) * (1 - 1e-12)


def volume_above(Q: Sequence[Sequence[Fraction]]) -> float | None:
    """An upper bound of the same; None where the set has no finite one.

    Parameters
    ----------
    Q : sequence of sequences of Fraction
        Symmetric.
    """
    minors = [_determinant([row[:k] for row in Q[:k]]) for k in range(1, len(Q) + 1)]
    return _volume(Q) * (1 + 1e-12) if min(minors) > 0 else None


def _determinant(P: Sequence[Sequence[Fraction]]) -> Fraction:
    return to_fraction(fmpq_mat([[to_fmpq(v) for v in row] for row in P]).det())


def _volume(P: Sequence[Sequence[Fraction]]) -> float:
    n, determinant = len(P), _determinant(P)
    bits = 128 + 2 * max(0, determinant.numerator.bit_length() - determinant.denominator.bit_length())
    root = Fraction(math.isqrt((determinant.denominator << 2 * bits) // determinant.numerator), 1 << bits)
    return float(float(root) * math.pi ** (n / 2) / math.gamma(n / 2 + 1))


def matrix_of(certificate: Any, name: str = "P") -> tuple[tuple[Fraction, ...], ...]:  # noqa: ANN401  (JSON data)
    """The matrix of a certificate.

    Parameters
    ----------
    certificate : Mapping
        The certificate.
    name : str
        ``P`` or ``Q``.
    """
    rows = certificate["proof"][name]
    n = len(rows)
    return tuple(tuple(Fraction(rows[max(i, j)][min(i, j)]) for j in range(n)) for i in range(n))


def strips(certificate: Any) -> Iterator[dict[str, Any]]:  # noqa: ANN401  (JSON data)
    """On what interval each local bound was used, one entry a channel.

    Parameters
    ----------
    certificate : Mapping
        The certificate of an ellipsoid.
    """
    for term in certificate["multiplier"]["terms"]:
        if "sector" in term:
            yield {
                "channel": term["channel"],
                "sector": term["sector"],
                "interval": [f"-{term['reach']}", term["reach"]],
            }
        else:
            yield {"channel": term["channel"], "row": term["row"]}

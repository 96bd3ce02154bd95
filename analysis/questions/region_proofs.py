"""Sets inside and outside a region of attraction: proposed in floating point, rounded, decided by the checker."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain, islice
from typing import Any, NamedTuple, TypeAlias

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked
from lure.analysis.certificates.systems import system_of
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.ellipsoids import (
    Disturbance,
    Ellipsoid,
    Local,
    ellipsoid,
    growing,
    linear_ellipsoid,
    shifted,
    unsaturated_ellipsoid,
)
from lure.analysis.inequality.level_sets import level_set
from lure.analysis.inequality.many_ellipsoids import MANY, many_ellipsoid
from lure.analysis.numerics.doubles import triangle_texts
from lure.analysis.numerics.polynomial import to_fraction
from lure.analysis.questions.channel_refutations import constant_gains, refutation
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.region_sets import Shape, levels, matrix_of
from lure.arrays import NDArray, np
from lure.classes import Diagonal, NonlinearityClass, Sector
from lure.plants.multivariable import MultivariablePlant

MARGINS = (1e-7, 1e-5, 1e-3, 1e-2)
_BITS = 40
_TRIED = 8  # of the intervals proposed
_FARTHER = 1.01  # along an axis, for another ellipsoid to be worth its certificate
MOST_DISTURBED = 12  # channels, from which on no disturbance is asked about
_THIN, _LINE, _FLAT = Fraction(1, 1024), Fraction(1, 10**9), 1e14
_FILLED = 1e-2  # of an interval, at least, that a set goes through
_MORE = Fraction(1, 10**9)  # by which the interval of a channel that sees no state exceeds what reaches it


# Ellipsoids.

Goal: TypeAlias = "NDArray[np.float64] | Disturbance | None"


def proved_ellipsoid(
    plant: MultivariablePlant, shapes: Sequence[Shape], points: Goal, near: Proved | None = None
) -> Proved | None:
    """A large ellipsoid whose solutions all tend to 0, accepted by the checker; None where none is found.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part.
    shapes : sequence of Shape
        What is known of the nonlinearity of each channel.
    points : ndarray, Disturbance or None
        (k, n) points whose largest multiple it is to hold; None for the largest volume; or what ``w`` moves.
    near : Proved or None
        An ellipsoid, of which another one is looked for: where there are many channels with its intervals at first.
    """
    for states in islice(_reaches(plant, shapes, points, near), _TRIED if near is None else 1):
        found = proved_on(plant, shapes, states, points)
        if found is not None:
            return found
    return None


def nothing_found(plant: MultivariablePlant) -> str:
    """Why no set is shown where the search ended without one."""
    if levels(plant.D) is not None:
        return "no invariant ellipsoid was found"
    return (
        "a channel feeds through D back to itself, directly or by way of others, and a set is shown only where sigma "
        "is given channel after channel; a fast pole in the model makes D zero"
    )


def ellipsoids_along(plant: MultivariablePlant, shapes: Sequence[Shape], first: Proved) -> Iterator[Proved]:
    """Ellipsoids that go farther along an axis of a first one, with intervals of their own; the longest axis first.

    ``shapes``: what is known of the nonlinearity of each channel; ``first``: the ellipsoid whose axes are looked along.
    """
    lengths, axes = np.linalg.eigh(np.array(matrix_of(first.certificate), dtype=float))
    for length, axis in zip(lengths.tolist(), axes.T, strict=True):
        end = axis[None] / math.sqrt(length)
        found = proved_ellipsoid(plant, shapes, end, first)
        if found is not None:
            P = np.array(matrix_of(found.certificate), dtype=float)
            if float(end[0] @ P @ end[0]) < _FARTHER**-2:
                yield found


def proved_on(
    plant: MultivariablePlant,
    shapes: Sequence[Shape],
    states: Sequence[Fraction | None],
    points: Goal,
) -> Proved | None:
    """The same with ``|C_i x|`` bounded by given numbers on the set.

    ``states``: the bounds, None for channels that see no state or are lines with limits.  ``points``: (k, n) points
    whose largest multiple it is to hold; None for the largest volume; or what ``w`` moves.
    """
    for margin in (*MARGINS, None):
        for shrunk in (Fraction(1), Fraction(999, 1000)):
            checkpoint()
            draft = _draft(plant, shapes, [None if c is None else c * shrunk for c in states], points, margin)
            if draft is None:
                continue
            try:
                found = checked(draft)
            except (Rejected, Malformed):
                continue
            assert isinstance(found, Proved), "the checker makes it of this verdict"
            return found
    return None


class _Used(NamedTuple):
    """What a search uses of each channel; of sectors also the bounds and the intervals of ``sigma``, exactly."""

    local: list[Local]
    sectors: list[tuple[Fraction, Fraction] | None]
    reaches: list[Fraction | None]


def _local(
    plant: MultivariablePlant, shapes: Sequence[Shape], states: Sequence[Fraction | None], *, exactly: bool
) -> _Used | None:
    """What is used if ``|C_i x|`` is at most so large; channel after channel, as ``D`` has it: what feeds through adds.

    A channel that sees no state has its interval from those before it.
    """
    most, found, m = dict[int, Fraction](), dict[int, Local](), len(shapes)
    sectors: list[tuple[Fraction, Fraction] | None] = [None] * m
    reaches: list[Fraction | None] = [None] * m
    groups = levels(plant.D)
    if groups is None:
        return None
    for i in chain(*groups):
        clip, own = shapes[i].clip, states[i]
        if clip is not None:
            found[i] = Local(float(clip[0]), float(clip[1]), float(clip[2]), math.inf)
            if clip[0] == 0:
                most[i] = max(abs(to_fraction(p[0])) for p in shapes[i].pieces)
            continue
        if any(d and j not in most for j, d in enumerate(plant.D[i])):
            return None
        through = sum((abs(d) * most[j] for j, d in enumerate(plant.D[i]) if d), Fraction(0))
        reach = _above(through + (own if own and any(plant.C[i]) else through * _MORE or Fraction(1)))
        reach = reach if shapes[i].reach is None else min(reach, shapes[i].reach or reach)
        bounds = shapes[i].bounds(reach) if exactly else shapes[i].sampled(float(reach))
        if bounds is None or reach <= through:
            return None
        low, high = Fraction(bounds[0]), Fraction(bounds[1])
        if high - low <= _LINE * (abs(low) + abs(high)):  # a line, of which a sector with some width is searched for
            low, high = low - _THIN * abs(low), high + _THIN * (abs(high) or shapes[i].steepest)
        sectors[i], reaches[i], most[i] = (low, high), reach, _above(max(abs(low), abs(high)) * reach)
        state = reach - through if any(plant.C[i]) else reach
        found[i] = Local(float(low), float(high) + 1e-12 * (high == low), None, float(state))
    return _Used([found[i] for i in range(m)], sectors, reaches)


def _above(value: Fraction) -> Fraction:
    """A number of few digits that is not below one that is not negative, and hardly above it."""
    if value.denominator.bit_length() < _BITS or not value:
        return value
    unit = Fraction(2) ** (math.floor(math.log2(value)) - _BITS)
    return math.ceil(value / unit) * unit


def _found(
    sides: Sequence[NDArray[np.float64]],
    used: _Used,
    points: Goal,
    *,
    discrete: bool,
    margin: float | None = None,
) -> Ellipsoid | None:
    """About the largest ellipsoid, without a margin roughly: by the search that fits the number of channels."""
    local = used.local
    if len(local) < MANY or (isinstance(points, Disturbance) and len(local) < MOST_DISTURBED):
        if margin is None:
            return ellipsoid(sides, local, discrete=discrete, points=points, turns=1)
        return ellipsoid(sides, local, discrete=discrete, points=points, margin=margin)
    if isinstance(points, Disturbance):
        return None
    guess = linear_ellipsoid(sides, local, discrete=discrete)
    for digits in (1e-2,) if margin is None else (1e-2, 1e-5):  # the second in the units of the first
        if guess is None:
            break
        least = MARGINS[0] if margin is None else margin
        guess = many_ellipsoid(sides, local, guess.P, discrete=discrete, points=points, margin=least, digits=digits)
    return guess


def _reaches(
    plant: MultivariablePlant, shapes: Sequence[Shape], points: Goal, near: Proved | None
) -> Iterator[list[Fraction | None]]:
    """For each sector the interval on which it is used: the best found, one after the other, by golden sections.

    Then those of smaller sets: where sets grow with the interval for ever, the largest are lost in rounding.
    """
    sides, discrete = plant.doubles(), plant.dt is not None
    own = [i for i, shape in enumerate(shapes) if shape.clip is None and any(plant.C[i])]

    def size(logs: Sequence[float]) -> float:
        """How large the ellipsoid is; -inf where there is none."""
        checkpoint()
        given: list[Fraction | None] = [None] * len(shapes)
        for i, log in zip(own, logs, strict=True):
            reach = Fraction(2.0**log).limit_denominator(10**9) if log > -20 else Fraction(2.0**log)
            given[i] = reach if shapes[i].reach is None else min(reach, shapes[i].reach or reach)
        used = _local(plant, shapes, given, exactly=False)
        found = None if used is None else _found(sides, used, points, discrete=discrete)
        return _size(found, points) if used and found and _filled(sides[2], used, found, own) else -math.inf

    def exactly(logs: Sequence[float]) -> list[Fraction | None]:
        """The intervals, of few digits."""
        out: list[Fraction | None] = [None] * len(shapes)
        for i, log in zip(own, logs, strict=True):
            reach = Fraction(2.0**log).limit_denominator(10**6) if log > -12 else Fraction(2.0**log)
            out[i] = min(reach, shapes[i].reach or reach)
        return out

    if not own:
        yield [None] * len(shapes)  # channels that see no state have their intervals from those before them
        return
    if len(shapes) >= MANY:
        many = _many_reaches(plant, shapes, points, near)
        yield from [] if many is None else [many]
        return
    starts = [[float(k)] * len(own) for k in range(-24, 25, 2)]
    if near is not None:
        seen = _seen(plant, shapes, near.certificate["multiplier"]["terms"])
        starts = [[math.log2(seen[i] or 1) + k for i in own] for k in (-1, 0, 1)]
    sizes = [(size(start), start) for start in starts]
    value, start = max(sizes)
    if value == -math.inf:
        return
    logs = [*start]
    for width in (2.0, 1.0) if len(own) > 1 else (2.0,):
        for place in range(len(own)):

            def along(log: float, place: int = place) -> float:
                """The size with another interval of one channel."""
                return size([*logs[:place], log, *logs[place + 1 :]])

            best = _golden(along, logs[place] - width, logs[place] + width)
            if along(best) >= value:
                logs[place], value = best, along(best)
    yield exactly(logs)
    for value, start in sorted(sizes, reverse=True):
        if value > -math.inf:
            yield exactly(start)


def _filled(C: NDArray[np.float64], used: _Used, found: Ellipsoid, own: Sequence[int]) -> bool:
    """Whether a set needs the intervals on which its sectors hold; else it is what rounding leaves of none."""
    spread = [float(np.sqrt(C[i] @ np.linalg.solve(found.P, C[i]))) / used.local[i].reach for i in own]
    return max(spread) > _FILLED


def _size(found: Ellipsoid | None, points: Goal) -> float:
    """How large an ellipsoid is; -inf where there is none, or one too long for :func:`_draft`."""
    if found is None or not np.linalg.cond(found.P) < _FLAT / 100:
        return -math.inf
    if isinstance(points, Disturbance):
        return math.log(max(found.energy, 1e-300))
    return found.size if points is None else -max(0.5 * math.log(p @ found.P @ p) for p in points)


def _many_reaches(
    plant: MultivariablePlant, shapes: Sequence[Shape], points: Goal, near: Proved | None
) -> list[Fraction | None] | None:
    """The same for many channels: one factor for those that share a nonlinearity, times how far the set goes.

    Where a set leaves room in an interval, its sectors are tightened to it before the next factor is tried.
    """
    sides, discrete, m = plant.doubles(), plant.dt is not None, len(shapes)
    C = sides[2]
    own = [i for i, shape in enumerate(shapes) if shape.clip is None and C[i].any()]
    kinds = [shape.kind for shape in shapes]
    groups = [[i for i in own if kinds[i] == one] for one in _different(kinds[i] for i in own)]

    def tried(wide: NDArray[np.float64]) -> tuple[float, Ellipsoid | None]:
        """The size with these intervals, and the set."""
        checkpoint()
        given = [Fraction(float(wide[i])).limit_denominator(10**9) if i in own else None for i in range(m)]
        used = _local(plant, shapes, given, exactly=False)
        found = None if used is None else _found(sides, used, points, discrete=discrete)
        return _size(found, points), found

    def spread(found: Ellipsoid) -> NDArray[np.float64]:
        """How far ``C_i x`` goes on a set."""
        return np.asarray(np.sqrt(np.einsum("ij,ji->i", C, np.linalg.solve(found.P, C.T))))

    lengths = np.linalg.norm(C, axis=1)
    value, best, wide = -math.inf, None, lengths
    starts = [lengths / lengths.max() * 2.0**k for k in range(-12, 7, 2)]  # near 0 all is as the linear loop
    if near is not None:
        seen = _seen(plant, shapes, near.certificate["multiplier"]["terms"])
        starts = [np.array([float(v or 0) for v in seen])]
    for start in starts:
        now, found = tried(start)
        if best is not None and now < value:
            break
        if found is not None:
            value, best, wide = now, found, np.minimum(start, 1.0001 * spread(found))
    if best is None:
        return None
    for factor in (1.5, 1.15, 1.04) if near is None else (1.3, 1.1):
        for group in [own, *groups] if len(groups) > 1 else groups:  # all together, then each
            for way in (factor, 1 / factor):
                while True:
                    new = wide.copy()
                    new[group] *= way
                    now, found = tried(new)
                    if found is None or not now > value + 1e-3:
                        break
                    value, wide = now, np.minimum(new, 1.0001 * spread(found))
    return [Fraction(float(wide[i])).limit_denominator(10**9) if i in own else None for i in range(m)]


def _different(given: Iterable[Any]) -> list[Any]:
    found = list[Any]()
    for one in given:
        if one not in found:
            found.append(one)
    return found


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
    points: Goal,
    margin: float | None,
) -> dict[str, Any] | None:
    """What has to be checked; without a margin of the set on which nothing saturates."""
    used = _local(plant, shapes, reaches, exactly=True)
    if used is None:
        return None
    local, sectors, reaches = used
    sides, discrete = plant.doubles(), plant.dt is not None
    if margin is not None:
        found = _found(sides, used, points, discrete=discrete, margin=margin)
    else:
        found = None if isinstance(points, Disturbance) else unsaturated_ellipsoid(sides, local, discrete=discrete)
    if found is None or not all(np.isfinite(part).all() for part in found):
        return None
    if np.linalg.cond(found.P) > _FLAT:  # longer and longer sets are invariant
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
            terms.append({**weight, "row": _row(found.rows[i], found.P, one)})
    moved: dict[str, Any] = {}
    if isinstance(points, Disturbance):
        energy = str(_short(found.energy / grown * (1 - (margin or 0.0))))
        into, seen = ([[str(v) for v in row] for row in side] for side in points.exact)
        moved = {"Bw": into, "energy": energy} | ({"Dsigmaw": seen} if points.D.any() else {})
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
        "proof": {"method": "ellipsoid", "P": triangle_texts(P)} | moved,
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
    diagonal = np.abs(np.diag(P)) + float(np.abs(P).max()) / _FLAT
    scale = [math.floor(math.log2(math.sqrt(v))) for v in diagonal]
    n = len(P)
    steps = [[2.0 ** (scale[i] + scale[j] - _BITS) for j in range(n)] for i in range(n)]
    return [[_step(float(P[max(i, j), min(i, j)]), steps[i][j]) for j in range(n)] for i in range(n)]


def _step(value: float, step: float) -> Fraction:
    return round(value / step) * Fraction(step)


def _short(value: float) -> Fraction:
    return _step(value, 2.0 ** (math.floor(math.log2(abs(value))) - 30)) if value else Fraction(0)


# Level sets with integrals.


def proved_level_set(
    plant: MultivariablePlant, shapes: Sequence[Shape], first: Proved, points: NDArray[np.float64] | None
) -> Proved | None:
    """A larger set than an ellipsoid, by the integrals of the nonlinearities; None where none is found.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part, in continuous time.
    shapes : sequence of Shape
        What is known of each nonlinearity.
    first : Proved
        The ellipsoid.
    points : ndarray or None
        (k, n) points whose largest multiple it is to hold; None for the largest volume.
    """
    given = [shape.pieces and not any(row) for shape, row in zip(shapes, plant.D, strict=True)]
    if plant.dt is not None or not any(given):
        return None
    terms = first.certificate["multiplier"]["terms"]
    used = _local(plant, shapes, _seen(plant, shapes, terms), exactly=True)
    assert used is not None, "it was proved with these"
    zero = ["0"] * plant.order
    ellipse = Ellipsoid(
        np.array(matrix_of(first.certificate), dtype=float),
        np.array([float(Fraction(term["weight"])) for term in terms]),
        np.array([[float(Fraction(v)) for v in term.get("row", zero)] for term in terms]),
    )
    integrals = [shape.primitive if own else None for shape, own in zip(shapes, given, strict=True)]
    for margin in MARGINS[1:]:
        checkpoint()
        try:
            found = level_set(plant.doubles(), used.local, integrals, ellipse, points=points, margin=margin)
        except np.linalg.LinAlgError:
            return None
        if found is None or not all(np.isfinite(part).all() for part in found):
            return None
        entries: list[dict[str, Any]] = [
            {"channel": i + 1, "theta": str(_short(float(theta))), "reach": str(_short(float(reach) * (1 + 1e-6)))}
            for i, (theta, reach) in enumerate(zip(found.theta, found.reaches, strict=True))
            if given[i] and 2 * abs(theta * float(shapes[i].primitive(np.array([reach]))[0])) > 1e-6
        ]
        for entry in entries:
            entry["least"] = str(_least(shapes[entry["channel"] - 1], entry))
        local = {**first.certificate, "multiplier": {"terms": []}}
        for i, term in enumerate(terms):
            weight = {"channel": i + 1, "weight": str(_short(float(found.weights[i])))}
            own = {key: term[key] for key in ("sector", "reach") if key in term}
            local["multiplier"]["terms"].append(
                {**weight, **(own or {"row": _row(found.rows[i], found.P, used.local[i])})}
            )
        rows = triangle_texts(_rounded(found.P))
        proof = {"method": "level-set", "P": rows, "integrals": entries}
        try:
            shown = checked({**local, "theorem": "local-popov", "proof": proof})
        except (Rejected, Malformed):
            continue
        assert isinstance(shown, Proved), "the checker makes it of this verdict"
        return shown
    return None


def _seen(plant: MultivariablePlant, shapes: Sequence[Shape], terms: Sequence[dict[str, Any]]) -> list[Fraction | None]:
    """Of what was proved, the bounds of ``|C_i x|``: the intervals of ``sigma`` less what feeds through."""
    most = [max((abs(to_fraction(p[0])) for p in shape.pieces), default=Fraction(0)) for shape in shapes]
    for i, term in enumerate(terms):
        if "reach" in term:
            most[i] = max(abs(Fraction(v)) for v in term["sector"]) * Fraction(term["reach"])
    through = [sum((abs(d) * v for d, v in zip(row, most, strict=True)), Fraction(0)) for row in plant.D]
    return [
        Fraction(term["reach"]) - own if "reach" in term else None for term, own in zip(terms, through, strict=True)
    ]


def _least(shape: Shape, entry: dict[str, Any]) -> Fraction:
    """About the least, for ``theta < 0`` the largest, ``2 int phi / sigma^2`` on the interval."""
    reach, above = float(Fraction(entry["reach"])), Fraction(entry["theta"]) >= 0
    sigma = reach * np.concatenate([np.geomspace(1e-6, 1, 300), -np.geomspace(1e-6, 1, 300)])
    ratio = 2 * shape.primitive(sigma) / sigma**2
    value = float(ratio.min() if above else ratio.max())
    return _short(value - (1 if above else -1) * 1e-8 * abs(value))


def _row(row: NDArray[np.float64], P: NDArray[np.float64], one: Local) -> list[str]:
    unit = 2.0 ** (math.floor(math.log2(one.limit or 1.0)) - _BITS)
    diagonal = np.abs(np.diag(P)) + float(np.abs(P).max()) / _FLAT
    steps = [unit * 2.0 ** math.floor(math.log2(v)) for v in np.sqrt(diagonal)]
    return [str(_step(float(v), s)) for v, s in zip(row, steps, strict=True)]


# Starts outside.


def unstable_near_0(plant: MultivariablePlant, shapes: Sequence[Shape]) -> Refuted | None:
    """That the loop is linear near 0, and is not asymptotically stable, if the checker agrees.

    Parameters
    ----------
    plant : MultivariablePlant
        The linear part; nothing is said where ``D`` has a cycle: a state near 0 need not have ``sigma`` near 0 then.
    shapes : sequence of Shape
        What is known of each nonlinearity: with one that is no line near 0 nothing is said.
    """
    near = [one.pieces[sum(cut < 0 for cut in one.cuts)] for one in shapes if one.pieces and 0 not in one.cuts]
    if len(near) < len(shapes) or any(piece.degree() > 1 for piece in near) or levels(plant.D) is None:
        return None
    gains = [to_fraction(piece[1]) for piece in near]
    classes = Diagonal(tuple(NonlinearityClass(sector=Sector(gain, gain + 1)) for gain in gains))
    return refutation(Problem(plant=plant, classes=classes, kind="class"), Fraction(1), constant_gains(gains))


def proved_growth(plant: MultivariablePlant, shapes: Sequence[Shape]) -> Refuted | None:
    """A set ``x'Q x > 1`` from which every solution grows; None where none is found.

    ``shapes``: what is known of each nonlinearity: all have to be lines with limits.
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
        rows = triangle_texts(_rounded(found.Q))
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

"""Attacks that take some milliseconds: short words and ramps of gains, orbits in small integers, the inequality again.

They are for loops of low order, of which a campaign asks so many that the dear attacks go to a share of them only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from campaign.draws import Drawn
from campaign.exact import Poly, Rational, plus
from campaign.members import LANES, ROUNDING, Flow, Reals, orbit_room
from flint import fmpq, fmpq_mat

LETTERS, ORBITS, NEAR, GRID, MOST = {2: 7, 3: 5}, 400, 1e-7, 400, 200  # how long words are with so many gains
Complex = tuple[Fraction, Fraction]


def words(case: Drawn, _conclusion: str, rng: np.random.Generator) -> str:
    """Gains that jump: in discrete time all short words, in continuous time two stays of sixteen durations each."""
    flow = Flow.of(case.plant, case.one)
    if flow is None or not flow.high > flow.low:
        return ""
    gains = np.array([flow.low, flow.high, *rng.uniform(flow.low, flow.high, int(rng.random() < 0.3))])
    closed, n = flow.closed(gains), len(flow.A)
    if flow.discrete:
        level, found = closed, [closed]
        for _ in range(LETTERS[len(gains)] - 1):
            level = (level[:, None] @ closed).reshape(-1, n, n)
            found.append(level)
        products = np.concatenate(found)
    else:
        fast = float(np.abs(np.linalg.eigvals(closed)).max())
        if not 0 < fast < math.inf:
            return ""
        stays = exponentials(closed[:2] * (0.05 / fast * rng.uniform(0.8, 1.2)))
        products = (stays[0][:, None] @ stays[1]).reshape(-1, n, n)
    radius = np.abs(np.linalg.eigvals(products[np.isfinite(products).all(axis=(1, 2))])).max(axis=1, initial=0.0)
    worst = float(radius.max(initial=0.0))
    return f"a word of the gains {gains.tolist()} has the multiplier {worst!r}" if worst > 1 + ROUNDING else ""


def exponentials(fields: Reals) -> Reals:
    """``exp(F 2^(k/2))`` for ``k = 0, .., 15`` of small matrices ``F``: by Taylor's series, and squares."""
    first = fields[:, None] * np.array([1.0, math.sqrt(2)])[:, None, None]
    term = total = np.broadcast_to(np.eye(fields.shape[-1]), first.shape)
    for k in range(1, 13):
        term = term @ first / k
        total = total + term
    found = [total]
    for _ in range(7):
        found.append(found[-1] @ found[-1])
    return np.concatenate(found, axis=1)


def ramps(case: Drawn, _conclusion: str, rng: np.random.Generator) -> str:
    """Gains that rise and fall as fast as their class allows, and rest in between: periods at random."""
    flow = Flow.of(case.plant, case.one)
    if flow is None or not flow.high > flow.low:
        return ""
    width = flow.high - flow.low
    fast = float(np.abs(np.linalg.eigvals(flow.closed(np.array([flow.low, flow.high])))).max())
    rests = rng.exponential(rng.choice([0.5, 2, 6]), (LANES, 2))
    if flow.discrete:
        count = int(rng.integers(1, 2 + min(width / flow.pace, MOST)))
        height = min(count * flow.pace, width)
        base = flow.low + (width - height) * rng.choice([0.0, 0.5, 1.0], LANES)
        up = np.arange(1, count + 1) / count
        path = np.concatenate([up, np.ones(int(rests[0, 0])), 1 - up, np.zeros(int(rests[0, 1]))])
        found = radius(flow, lambda whole, t: flow.closed(base + height * path[t]) @ whole, len(path))
        said = f"{count} steps up and down by {height / count!r}"
    elif 0 < fast < math.inf:
        time = np.minimum(rng.exponential(rng.choice([0.5, 2, 6]), LANES) / fast, width / flow.pace)
        height = time * flow.pace
        base = flow.low + (width - height) * rng.choice([0.0, 0.5, 1.0], LANES)
        lengths = np.stack([time, rests[:, 0], time, rests[:, 1]]) / np.array([[1], [fast]] * 2)
        ends = base + height * np.array([0, 1, 1, 0, 0])[:, None]
        pair = []
        steps = int(np.clip(lengths.max() * fast * 4, 8, MOST))
        for count in (steps, 2 * steps):
            h = (lengths / count)[..., None, None]

            def step(whole: Reals, t: int, count: int = count, h: Reals = h) -> Reals:
                k, i = divmod(t, count)
                first, middle, last = (
                    flow.closed(ends[k] + (ends[k + 1] - ends[k]) * (i + part) / count) for part in (0, 0.5, 1)
                )
                k1 = first @ whole
                k2 = middle @ (whole + h[k] / 2 * k1)
                k3 = middle @ (whole + h[k] / 2 * k2)
                return np.asarray(whole + h[k] / 6 * (k1 + 2 * k2 + 2 * k3 + last @ (whole + h[k] * k3)))

            pair.append(radius(flow, step, 4 * count))
        found = np.where(np.abs(pair[1] - pair[0]) < 0.1 * np.abs(pair[1] - 1), pair[1], 0.0)
        said = f"ramps {ends.T[found.argmax()].tolist()} for {lengths.T[found.argmax()].tolist()}"
    else:
        return ""
    worst = float(found.max())
    return f"{said} have the multiplier {worst!r}" if worst > 1 + ROUNDING else ""


def radius(flow: Flow, step: Callable[[Reals, int], Reals], count: int) -> Reals:
    """The spectral radius of so many steps from the identity, a number for each lane; 0 where it overflows."""
    whole = np.broadcast_to(np.eye(len(flow.A)), (LANES, *flow.A.shape))
    with np.errstate(all="ignore"):
        for t in range(count):
            whole = step(whole, t)
    good = np.isfinite(whole).all(axis=(1, 2))
    return np.where(good, np.abs(np.linalg.eigvals(np.where(good[:, None, None], whole, 0))).max(axis=1), 0.0)


def integer_orbits(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Periodic solutions in discrete time with small integers for ``u``; what may be one is decided exactly."""
    period = int(rng.integers(2, 7))
    room = orbit_room(case, conclusion, period)
    if room is None:
        return ""
    wide = {2: 4, 3: 3, 4: 2}.get(period, 1)
    u = np.array(list(itertools.product(range(-wide, wide + 1), repeat=period)))
    u = u[np.ptp(u, axis=1) > 0]
    u = u[rng.permutation(len(u))[:ORBITS]]
    found = room(u.astype(float))
    for i in np.flatnonzero(found > -NEAR)[:3]:
        if orbit_exists(case, [Fraction(int(v)) for v in u[i]]):
            return f"u = {u[i].tolist()} over a period, exactly"
    return ""


def orbit_exists(case: Drawn, u: list[Fraction]) -> bool:
    """Whether a member passes through the points ``(sigma, -u)`` of a periodic solution ``d(q) sigma = n(q) u``."""
    plant, one, period = case.plant, case.one, len(u)
    rows = [[fmpq(0)] * period for _ in range(period)]
    right = []
    for t in range(period):
        for i, v in enumerate(plant.d):
            rows[t][(t + len(plant.d) - 1 - i) % period] += fmpq(v.numerator, v.denominator)
        right.append(sum(v * u[(t + len(plant.n) - 1 - i) % period] for i, v in enumerate(plant.n)))
    try:
        solved = fmpq_mat(rows).solve(fmpq_mat([[fmpq(v.numerator, v.denominator)] for v in right]))
    except ZeroDivisionError:
        return False
    sigma = [Fraction(int(solved[t, 0].p), int(solved[t, 0].q)) for t in range(period)]
    points = [(x, -y) for x, y in zip(sigma, u, strict=True)]
    points += [(-x, -y) for x, y in points] if one.odd else []

    def inside(x: Fraction, y: Fraction, low: float | Fraction, high: float | Fraction) -> bool:
        if x == 0:
            return y == 0
        return low <= y / x <= high

    pairs = list(itertools.combinations(points, 2))
    if not all(inside(x, y, one.sector.lower, one.sector.upper) for x, y in points):
        return False
    if one.time_varying:
        return True
    if one.slope is None:
        return all(x != v or y == w for (x, y), (v, w) in pairs)
    return all((x, y) == (v, w) or inside(x - v, y - w, one.slope.lower, one.slope.upper) for (x, y), (v, w) in pairs)


def inequality(case: Drawn, certificate: Mapping[str, Any]) -> str:
    """The inequality of the circle criterion or of Popov's on a grid; where it is least, exactly at rational points."""
    plant, one, name = case.plant, case.one, certificate["theorem"]
    if name not in ("circle", "popov") or certificate["system"]["kind"] != "transfer" or plant.delay:
        return ""
    low, high = Fraction(one.sector.lower), one.sector.upper
    theta = Fraction(certificate["multiplier"].get("theta", 0))
    below = plus(plant.d, plant.n, low)
    scale = [abs(float(v)) for v in plant.d]
    size = max((scale[-1] / scale[0]) ** (1 / (len(scale) - 1)) if len(scale) > 1 and scale[-1] else 1.0, 1e-12)
    at = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, GRID) * (1.0 if plant.discrete else size)])
    value = sampled(plant, below, at, theta, None if high == math.inf else float(high - low))
    i = int(value.argmin())
    if i and i < len(at) - 1:
        near = np.linspace(at[i - 1], at[i + 1], 60)
        finer = sampled(plant, below, near, theta, None if high == math.inf else float(high - low))
        at, value, i = near, finer, int(finer.argmin())
    if not value[i] < NEAR:
        return ""
    exact = exactly(plant, below, Fraction(float(at[i])), theta, None if high == math.inf else Fraction(high) - low)
    return f"the inequality of {name} at {float(at[i])!r}: {float(exact)!r}" if exact < 0 else ""


def sampled(plant: Rational, below: Poly, at: Reals, theta: Fraction, width: float | None) -> Reals:
    """``Re(conj(D) (D/width + M n))`` over the sizes of its factors, ``D = d + low n``, in double."""
    w = 1j * at
    point = (1 + w) / (1 - w) if plant.discrete else w
    n, D = (np.polyval(np.array([float(v) for v in side]), point) for side in (plant.n, below))
    above = (1 + float(theta) * w) * n
    above = above if width is None else D + width * above
    return np.asarray((D.conj() * above).real / (np.abs(D) * np.abs(above) + 1e-300))


def exactly(plant: Rational, below: Poly, at: Fraction, theta: Fraction, width: Fraction | None) -> Fraction:
    """The same at one rational point, with its sign and without a rounding error."""
    size = 1 + at * at
    point = ((1 - at * at) / size, 2 * at / size) if plant.discrete else (Fraction(0), at)
    (a, b), (c, d) = (horner(side, point) for side in (plant.n, below))
    a, b = a - theta * at * b, b + theta * at * a
    if width is not None:
        a, b = c + width * a, d + width * b
    return a * c + b * d


def horner(side: Poly, point: Complex) -> Complex:
    """The value of a polynomial."""
    x, y = Fraction(0), Fraction(0)
    for v in side:
        x, y = x * point[0] - y * point[1] + v, x * point[1] + y * point[0]
    return x, y

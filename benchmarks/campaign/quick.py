"""Attacks that take a millisecond or so: short words of jumping gains, orbits in small integers, the inequality again.

They are for loops of low order, of which a campaign asks so many that the dear attacks go to a share of them only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from campaign.draws import Drawn
from campaign.exact import Poly, Rational, plus
from campaign.members import ROUNDING, Flow, Reals, orbit_room
from flint import fmpq, fmpq_mat

LETTERS, ORBITS, NEAR, GRID = {2: 7, 3: 5}, 400, 1e-7, 400  # how long words are with so many gains
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

"""Attacks on a proof for one channel: constant gains in balls, gains that jump, functions with corners, dead times.

Each takes a loop and the conclusion that was proved of it, and says in words what contradicts it, or nothing.  None
uses a multiplier, a Lyapunov function of a proof, or a search of the house.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from campaign.draws import Drawn
from campaign.exact import Rational, contains_gain, floats, furthest, gains_of, plus, where
from scipy.linalg import expm, solve_continuous_lyapunov, solve_discrete_lyapunov

from lure import NonlinearityClass

Reals = np.ndarray
AT_ZERO = ("converges to the set of equilibria", "is bounded")  # conclusions that allow a root at 0
LANES, FIRST, LONG, ROUNDS = 32, 320, 3000, 6
CLOSE, STAYS, LARGEST, ROUNDING = 0.97, 0.9999, 1e100, 1e-7
CLIMBS = 60


def size_of(plant: Rational) -> float:
    """A large gain, in the plant's unit."""
    return 1e6 * (1e-3 + abs(float(plant.d[-1])) / (max(map(abs, map(float, plant.n))) or 1.0))


def constant(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Constant gains, the ends and the worst of two hundred in balls."""
    plant, one = case.plant, case.one
    low, high = gains_of(one, most=size_of(plant))
    if plant.delay:
        return encircled(case, [float(low), float(high), *rng.uniform(float(low), float(high), 3)])
    shares = np.concatenate([rng.random(60), np.geomspace(1e-9, 1, 40), 1 - np.geomspace(1e-9, 1, 40)])
    chosen = [low, high, (low + high) / 2]
    worst = furthest(plant.d, plant.n, float(low) + shares * float(high - low), discrete=plant.discrete)
    for i in np.argsort(worst)[-2:]:
        chosen.append(low + Fraction(float(np.clip(shares[i], 0, 1))) * (high - low))
    allowed = any(words in conclusion for words in AT_ZERO)
    for g in chosen:
        if not contains_gain(one, g):
            continue
        if 1 + g * plant.through == 0:
            return f"the gain {g} is not well posed"
        found = where(plus(plant.d, plant.n, g), discrete=plant.discrete)
        if found == "unstable" or (found == "origin" and not allowed):
            return f"the gain {g} is {found}"
    return ""


def encircled(case: Drawn, gains: list[float]) -> str:
    """Constant gains around a dead time: ``1 + g H(i w)`` turns about 0 for a stable ``H``."""
    plant = case.plant
    n, d = (np.array([float(v) for v in side]) for side in (plant.n, plant.d))
    if where(plant.d, discrete=False) != "stable":
        return ""
    scale = np.abs(np.roots(d)).max(initial=1.0)
    delay = float(plant.delay)
    w = np.concatenate([[0], np.geomspace(1e-4, 1e3, 3000) * scale, np.arange(0, 400, 0.02) / delay])
    w.sort()
    H = np.polyval(n, 1j * w) / np.polyval(d, 1j * w) * np.exp(-1j * w * delay)
    for g in gains:
        curve = 1 + g * H
        if np.abs(curve).min() < 1e-3 or np.abs(np.diff(np.angle(curve))).max() > 6.2 or abs(g * H[-1]) > 0.1:
            continue
        steps = np.angle(curve[1:] / curve[:-1])
        if np.abs(steps).max() < 1 and abs(steps.sum()) > 3:
            return f"the gain {g} has roots in the right half-plane: the curve turns by {steps.sum():.3g}"
    return ""


@dataclass(frozen=True)
class Flow:
    """The plant in a unit of time in which its poles are about 1, as floats, the ends of its gains and their pace."""

    A: Reals
    b: Reals
    c: Reals
    d: float
    low: float
    high: float
    discrete: bool
    pace: float = math.inf

    @classmethod
    def of(cls, plant: Rational, one: NonlinearityClass) -> Flow | None:
        """The loop; None where it has no state or is not well posed as a number."""
        order, middle = len(plant.d) - 1, 1.0
        if not order:
            return None
        if not plant.discrete:
            poles = np.abs(np.roots([float(v) for v in plant.d]))
            poles = poles[poles > 0]
            middle = 2.0 ** round(float(np.log2(poles).mean())) if len(poles) else 1.0
            plant = plant.scaled(Fraction(middle), Fraction(1))
        sizes = [float(max(map(abs, side))) for side in (plant.n, plant.d)]
        gain = 2.0 ** round(math.log2(sizes[0] / sizes[1])) if sizes[0] else 1.0
        plant = Rational([v / Fraction(gain) for v in plant.n], plant.d, discrete=plant.discrete)
        low, high = (float(v) * gain for v in gains_of(one, most=size_of(plant) * 3e-5 / gain))
        A, b, c, d = floats(plant.matrices())
        pace = float(one.rate) * gain / middle if one.rate is not None else math.inf
        return (
            cls(A, b, c, float(d), low, high, plant.discrete, pace) if min(1 + low * d, 1 + high * d) > 1e-9 else None
        )

    def closed(self, gains: Reals) -> Reals:
        """``A - b c g/(1 + g d)`` for each gain."""
        share = gains / (1 + gains * self.d)
        return np.asarray(self.A - share[..., None, None] * np.outer(self.b, self.c))

    def fastest(self) -> float:
        """The largest modulus of a pole at the ends; infinite where a solution can not be followed for long enough."""
        poles = np.linalg.eigvals(self.closed(np.array([self.low, (self.low + self.high) / 2, self.high])))
        fast = float(np.abs(poles).max())
        slow = np.abs(np.log(np.abs(poles) + 1e-300) if self.discrete else poles.real)
        steps = 1.0 if self.discrete else 20 * fast
        return fast if fast > 0 and (slow[slow > 0]).min(initial=fast) * LONG > 2 * steps else math.inf


def lasting(step: Callable[[Reals, int], Reals], x: Reals, conclusion: str) -> float:
    """The least of the last three ratios of a window's largest size to that of the window before, over all lanes.

    Near 1 or above for what does not decay.  The size is that of the state; of its increments where only convergence
    to the set of equilibria is claimed; where it is boundedness, 0 but for growth without bound.
    """
    at_rest, bounded = (any(words in conclusion for words in (AT_ZERO[k],)) for k in (0, 1))
    ratios = [np.full(len(x), math.inf)] * 2
    largest, before = np.abs(x).max(axis=1), np.full(len(x), math.inf)
    for window in range(2 + ROUNDS):
        now = np.zeros(len(x))
        for t in range(FIRST // 2 if window < 2 else LONG):
            new = step(x, t)
            now = np.maximum(now, np.abs(new - x if at_rest else new).max(axis=1))
            x = new
        largest = np.maximum(largest, np.abs(x).max(axis=1))
        if not np.isfinite(now).all() or now.max() > LARGEST:
            return math.inf
        ratios.append(np.where(now < 1e-9 * largest, 0, now / np.maximum(before, 1e-300)))
        before = now
        late = np.minimum.reduce(ratios[-3:]).max()
        if (window == 1 and (bounded or ratios[-1].max() < CLOSE)) or (window > 3 and late < STAYS):
            return 0.0
    return float(late)


def jumping(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Gains that jump: periods at random, and those that raise a quadratic form at every step."""
    flow = Flow.of(case.plant, case.one)
    if flow is None or not flow.high > flow.low:
        return ""
    n, fast = len(flow.A), flow.fastest()
    if fast == math.inf:
        return ""
    count = int(rng.integers(2, 5))
    gains = flow.low + (flow.high - flow.low) * np.where(
        rng.random((LANES, count)) < 0.7, rng.integers(0, 2, (LANES, count)), rng.random((LANES, count))
    )
    closed, times = flow.closed(gains), np.ones((LANES, count))
    if not flow.discrete:
        times = rng.exponential(rng.choice([0.5, 2, 6]), (LANES, count)) / np.sqrt(fast)
        closed = expm(closed * times[..., None, None])
    whole = np.broadcast_to(np.eye(n), (LANES, n, n))
    for k in range(count):
        whole = closed[:, k] @ whole
    radius = np.abs(np.linalg.eigvals(whole)).max(axis=1)
    if radius.max() > 1 + ROUNDING:
        i = int(radius.argmax())
        return f"gains {gains[i].tolist()} for {times[i].tolist()} have the multiplier {radius[i]!r}"
    middle = flow.closed(np.array([(flow.low + flow.high) / 2]))[0]
    pick = np.array([flow.low, flow.high])
    h = 1.0 if flow.discrete else float(rng.choice([0.05, 0.2])) / fast
    two = flow.closed(pick) if flow.discrete else expm(flow.closed(pick) * h)
    forms = []
    for _ in range(8):
        root = rng.normal(size=(n, n)) * 10 ** rng.normal(size=n)
        try:
            solve = solve_discrete_lyapunov if flow.discrete else solve_continuous_lyapunov
            P = solve(middle.T, root @ root.T * (1 if flow.discrete else -1))
        except (ValueError, np.linalg.LinAlgError):
            P = root @ root.T
        forms.append(P / np.abs(P).max() if np.isfinite(P).all() else root @ root.T)
    P = np.repeat(np.array(forms), LANES // 8, axis=0)

    def step(x: Reals, _t: int) -> Reals:
        both = np.einsum("kij,lj->kli", two, x)
        value = np.einsum("kli,lij,klj->kl", both, P, both)
        return np.where((value[1] > value[0])[:, None], both[1], both[0])

    with np.errstate(all="ignore"):
        found = lasting(step, rng.normal(size=(LANES, n)), conclusion)
    return f"gains that raise a form: a ratio of {found:.8g}" if found > STAYS else ""


def corners(one: NonlinearityClass, flow: Flow, rng: np.random.Generator) -> Callable[[Reals], Reals]:
    """Members for all lanes: piecewise linear with four corners on each side, with slopes as the class has them."""
    width = flow.high - flow.low
    at = rng.exponential(1.0, (2, LANES, 4)).cumsum(axis=-1) * rng.choice([0.02, 1, 30], (LANES, 1))
    share = np.where(rng.random((2, LANES, 5)) < 0.7, rng.integers(0, 2, (2, LANES, 5)), rng.random((2, LANES, 5)))
    slope = one.slope
    sloped = slope is not None
    if not sloped:
        share[..., 1:] = share[..., 1:] * 13 - 6
    elif slope is not None and (slope.lower, slope.upper) != (one.sector.lower, one.sector.upper):
        unit = float(one.sector.upper - one.sector.lower) if one.sector.upper < math.inf else math.inf
        out = [float(v) / unit for v in (one.sector.lower - slope.lower, slope.upper - one.sector.upper)]
        if math.isfinite(sum(out)):
            share[..., 1:] = share[..., 1:] * (1 + sum(out)) - out[0]
    if one.odd:
        share[1], at[1] = share[0], at[0]
    bends = np.diff(share, axis=-1)

    def phi(sigma: Reals) -> Reals:
        size, side = np.abs(sigma), (sigma < 0).astype(int)
        lanes = np.arange(len(sigma))
        y = share[side, lanes, 0] * size
        y = y + (bends[side, lanes] * np.maximum(size[:, None] - at[side, lanes], 0)).sum(axis=1)
        return np.asarray(flow.low * sigma + width * np.sign(sigma) * np.clip(y, 0, size))

    return phi


def functions(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Functions with corners, from many starts; those that do not come to rest are followed for long."""
    plant, one = case.plant, case.one
    flow = Flow.of(plant, one)
    if flow is None or flow.d or not flow.high > flow.low:
        return ""
    phi, fast = corners(one, flow, rng), flow.fastest()
    x = rng.normal(size=(LANES, len(flow.A))) * np.geomspace(0.05, 1e3, LANES)[:, None]
    if fast == math.inf:
        return ""
    h = 0.5 / fast

    def moved(x: Reals) -> Reals:
        return np.asarray(x @ flow.A.T - phi(x @ flow.c)[:, None] * flow.b)

    def step(x: Reals, _t: int) -> Reals:
        if flow.discrete:
            return moved(x)
        k1 = moved(x)
        k2 = moved(x + h / 2 * k1)
        k3 = moved(x + h / 2 * k2)
        return np.asarray(x + h / 6 * (k1 + 2 * k2 + 2 * k3 + moved(x + h * k3)))

    with np.errstate(all="ignore"):
        found = lasting(step, x, conclusion)
    return f"a function with corners: a ratio of {found:.8g}" if found > STAYS else ""


def orbit_room(case: Drawn, conclusion: str, period: int) -> Callable[[Reals], Reals] | None:
    """How far periodic solutions with ``u`` are from a member's, below 0 where none passes through their points.

    With ``sigma = H u`` over the period a member with ``u = -phi(sigma)`` exists if and only if for its points, the
    point 0 and, of a class of slopes, all differences ``(delta phi - low delta sigma)(high delta sigma - delta phi) >=
    0``; for odd ones sums count too, and members that depend on time have to pass through one point at a time.
    """
    plant, one = case.plant, case.one
    if not plant.discrete or one.linear or "is bounded" in conclusion:
        return None
    points = np.exp(2j * np.pi * np.arange(period) / period)
    n, d = (np.polyval(np.array([float(v) for v in side]), points) for side in (plant.n, plant.d))
    rests = abs(d[0]) < 1e-9 * np.abs(d).max() or any(words in conclusion for words in AT_ZERO)
    if np.abs(d[1:]).min() < 1e-9 * np.abs(d).max():
        return None
    response = np.where([rests] + [False] * (period - 1), 0, n / np.where(d == 0, 1, d))
    bounds = [(one.sector, False)] + ([(one.slope, True)] if one.slope is not None else [])
    size = float(np.abs(response).max()) or 1.0
    ends = [[float(np.clip(float(v), -1e6 / size, 1e6 / size)) for v in (b.lower, b.upper)] for b, _ in bounds]

    def room(u: Reals) -> Reals:
        u = u - u.mean(axis=1, keepdims=True) if rests else u
        sigma, phi = np.fft.ifft(response * np.fft.fft(u)).real, -u
        found = np.full(len(u), math.inf)
        for (low, high), (_, differs) in zip(ends, bounds, strict=True):
            across = [(sigma, phi)]
            if differs and not one.time_varying:
                across += [
                    ((sigma[:, :, None] - q * sigma[:, None])[:, i, j], (phi[:, :, None] - q * phi[:, None])[:, i, j])
                    for i, j in [np.triu_indices(period, 1)]
                    for q in ((1, -1) if one.odd else (1,))
                ]
            for x, y in across:
                whole = (np.abs(y) + max(abs(low), abs(high)) * np.abs(x)) ** 2 + 1e-24 * (u**2).max(axis=1)[:, None]
                found = np.minimum(found, ((y - low * x) * (high * x - y) / whole).min(axis=1))
        return np.asarray(found)

    return room


def orbits(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Periodic solutions in discrete time: ``u`` of short periods, changed until a member passes through all points."""
    period = int(rng.integers(2, 8))
    room = orbit_room(case, conclusion, period)
    if room is None:
        return ""
    levels = rng.normal(size=(8 * LANES, 4)) * (rng.random((8 * LANES, 4)) < 0.8) + 1e-9
    pattern = np.array([rng.integers(0, rng.integers(2, 5), period) for _ in range(8 * LANES)])
    signs = rng.choice([-1, 1], pattern.shape) if case.one.odd else np.ones(pattern.shape)

    def of(levels: Reals) -> Reals:
        return np.asarray(signs * np.take_along_axis(levels, pattern, axis=1))

    best = room(of(levels))
    for k in range(CLIMBS):
        if k == CLIMBS // 2:
            first = np.argsort(best)[-LANES:]
            levels, pattern, signs, best = (np.repeat(v[first], 8, axis=0) for v in (levels, pattern, signs, best))
        scale = np.linalg.norm(levels, axis=1, keepdims=True) * 10 ** rng.uniform(-4, 0, (len(levels), 1))
        other = levels + scale * rng.normal(size=levels.shape)
        now = room(of(other))
        levels, best = np.where((now > best)[:, None], other, levels), np.maximum(now, best)
    i = int(best.argmax())
    u = of(levels)[i]
    return f"u = {u.tolist()} over a period, with {best[i]:.3g} to spare" if best[i] > -ROUNDING and np.ptp(u) else ""


def late(case: Drawn, conclusion: str, rng: np.random.Generator) -> str:
    """Around a dead time, by the method of steps: functions with corners, or gains that jump."""
    plant, one = case.plant, case.one
    delay = float(plant.delay)
    A, b, c, d = floats(plant.matrices())
    if not len(A):
        return ""
    low, high = (float(v) for v in gains_of(one, most=size_of(plant) * 3e-5))
    flow = Flow(A, b, c, 0.0, low, high, discrete=False)
    fast = flow.fastest()
    if fast == math.inf:
        return ""
    steps = int(np.clip(math.ceil(delay * fast * 10), 2, 400))
    h = delay / steps
    n = len(A)
    if not 0.05 <= h * fast <= 0.5:  # a window of shorter steps is too short for what decays slowly
        return ""
    whole = expm(np.block([[A, b[:, None]], [np.zeros((1, n + 1))]]) * h)
    ahead, push = whole[:n, :n], whole[:n, n]
    phi = corners(one, flow, rng)
    period = rng.integers(1, 4 * steps, (2, LANES))
    x0 = rng.normal(size=(LANES, n)) * np.geomspace(0.05, 1e3, LANES)[:, None]

    def step(state: Reals, t: int) -> Reals:
        x, past = state[:, :n], state[:, n:]
        sigma = (past[:, -1] + past[:, -2]) / 2  # in the middle of the step: a sample that is held is half a step late
        if one.time_varying:
            on = (t % period.sum(axis=0)) < period[0]
            mu = -np.where(on, low, high) * sigma
        elif one.linear:
            mu = -low * sigma
        else:
            mu = -phi(sigma)
        now = x @ c  # of mu half a step ago: what is fed through is that of the sample
        return np.hstack([x @ ahead.T + mu[:, None] * push, (now + d * mu)[:, None], past[:, :-1]])

    state = np.hstack([x0, np.zeros((LANES, steps))])
    with np.errstate(all="ignore"):
        found = lasting(step, state, conclusion)
    return f"the method of steps: a ratio of {found:.8g}" if found > 1.001 else ""

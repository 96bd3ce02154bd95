"""Loops with a piecewise-linear nonlinearity: exact affine pieces, their flow in doubles, orbits proved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat

from lure.analysis.counterexamples.linear import Realisation, Row, balls
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import ArrayLike, Reals, in_doubles, linalg, np
from lure.errors import InputError, Reason
from lure.nonlinearities.piecewise_linear import Graph
from lure.record import described, quantity

# Loops with a piecewise-linear nonlinearity: exact affine pieces, and their flow in doubles from switch to switch.

TAYLOR = 16
BLOCK = 64


def saturation(inner: Fraction, outer: Fraction) -> Graph:
    """Slope ``inner`` for ``|sigma| <= 1``, ``outer`` beyond: a saturation, or a dead zone if ``inner`` is smaller."""
    return Graph.through([(Fraction(-1), -inner), (Fraction(1), inner)], outer, outer)


@described(frozen=True, slots=True)
class PiecewiseLoop:
    r"""The loop of a realisation with a piecewise-linear nonlinearity, in exact numbers.

    With feedthrough ``d`` the piece is told from ``y = c x = sigma + d phi(sigma)``, which ascends with ``sigma`` as
    long as every ``1 + d slope > 0``.  On piece ``j``, ``levels[j-1] < y < levels[j]``, ``x' = A_j x + f_j``.
    """

    system: Realisation = quantity("The linear part")
    nonlinearity: Graph = quantity("The nonlinearity; ``mu = -phi(sigma)``")
    levels: Row = quantity("Values of ``y`` at the kinks of the nonlinearity")
    generators: tuple[tuple[Row, ...], ...] = quantity(
        "For every piece the matrix ``[[A_j, f_j], [0, 0]]``, which acts on ``(x, 1)``"
    )

    @classmethod
    def of(cls, system: Realisation, nonlinearity: Graph) -> PiecewiseLoop:
        """The loop.

        Raises
        ------
        InputError
            ``1 + d slope`` is not positive on some piece: ``sigma`` does not follow from the state; or the nonlinearity
            is a straight line.
        """
        d = system.d
        if any(1 + d * s <= 0 for s in nonlinearity.slopes):
            raise InputError(
                f"the loop is not well posed: 1 + d slope must be positive, and d is {float(d):g}",
                code=Reason.ILL_POSED,
            )
        if nonlinearity.is_line:
            raise InputError("the nonlinearity is a straight line; a linear gain belongs into the block")
        kinks = nonlinearity.kinks
        slopes = [nonlinearity.slopes[0], *(nonlinearity.slopes[nonlinearity.knots.index(kink) + 1] for kink in kinks)]
        generators = []
        for slope, kink in zip(slopes, [*kinks[:1], *kinks], strict=False):
            force = (nonlinearity.exact(kink) - slope * kink) / (1 + d * slope)
            rows = [(*row, -force * b) for row, b in zip(system.closed(slope), system.b, strict=True)]
            generators.append((*rows, (Fraction(0),) * (system.order + 1)))
        return cls(
            system, nonlinearity, tuple(kink + d * nonlinearity.exact(kink) for kink in kinks), tuple(generators)
        )

    def interval(self, piece: int) -> tuple[Fraction | None, Fraction | None]:
        """Where ``y`` lies on a piece; None for no bound."""
        low = self.levels[piece - 1] if piece > 0 else None
        return low, self.levels[piece] if piece < len(self.levels) else None

    def mirrored(self, piece: int) -> int:
        """The piece that ``y -> -y`` leads to, for an odd nonlinearity."""
        return len(self.levels) - piece


@dataclass(frozen=True, slots=True)
class Passage:
    """A stay on one piece: from time ``start`` and state ``state`` for ``duration``; the last may end with the run."""

    piece: int
    start: float
    duration: float
    state: Reals


class Flow:
    """The flow in doubles: steps by the matrix exponential of the piece, switches located on its Taylor polynomial."""

    def __init__(self, loop: PiecewiseLoop) -> None:
        n = loop.system.order
        self.levels = np.array([float(v) for v in loop.levels])
        self.row = np.array([*(float(v) for v in loop.system.c), 0.0])
        self.order = n
        self.generators = [in_doubles(g) for g in loop.generators]
        self.steps: list[float] = []
        self.powers: list[Reals] = []
        self.outputs: list[Reals] = []
        self.taylor: list[Reals] = []
        self.quickest = 0.0
        for G in self.generators:
            size = max(1e-12, float(np.abs(np.linalg.eigvals(G)).max()))
            self.quickest, step = max(self.quickest, 4 * size), 0.25 / size
            powers = [np.eye(n + 1)]
            E = linalg.expm(G * step)
            for _ in range(BLOCK):
                powers.append(E @ powers[-1])
            terms = [np.eye(n + 1)]
            for i in range(1, TAYLOR):
                terms.append(G @ terms[-1] / i)
            self.steps.append(step)
            self.powers.append(np.array(powers))
            self.outputs.append(np.array([self.row @ P for P in powers[1:]]))
            self.taylor.append(np.array(terms))

    def piece_of(self, state: Reals) -> int:
        """The piece of ``(x, 1)``; on a level, the one the solution enters."""
        y = float(self.row @ state)
        below, upto = int(np.searchsorted(self.levels, y, "left")), int(np.searchsorted(self.levels, y, "right"))
        return upto if below < upto and float(self.row @ self.generators[below] @ state) > 0 else below

    def passages(self, x0: ArrayLike, until: float, most: int = 100_000) -> list[Passage]:
        """The stays on the pieces from ``x0`` to time ``until``, at most so many; fewer if the solution overflows."""
        state = np.array([*np.asarray(x0, dtype=float), 1.0])
        piece, time = self.piece_of(state), 0.0
        found: list[Passage] = []
        on_level: float | None = None
        while time < until and len(found) < most and np.isfinite(state).all():
            duration, end, level = self._leave(piece, state, until - time, on_level)
            found.append(Passage(piece, time, duration, state[:-1]))
            if level is None:
                break
            time, state, on_level = time + duration, end, level
            piece += 1 if level == (self.levels[piece] if piece < len(self.levels) else math.inf) else -1
        return found

    def states_at(self, passage: Passage, after: Reals) -> Reals:
        """The states, one a row, at ascending times after the start of a passage."""
        step = self.steps[passage.piece]
        state, begun, found = np.append(passage.state, 1.0), 0, []
        for t in after:
            ahead = int(t / step) - begun
            while ahead > 0:
                jump = min(ahead, BLOCK)
                state, begun, ahead = self.powers[passage.piece][jump] @ state, begun + jump, ahead - jump
            found.append(self._advance(passage.piece, state, float(t) - begun * step)[:-1])
        return np.array(found).reshape(len(after), self.order)

    def sampled(self, passages: Sequence[Passage], times: Reals) -> Reals:
        """The states, one a row, at ascending times of a solution given by its stays; NaN after the last stay."""
        found = np.full((len(times), self.order), np.nan)
        begins = np.array([passage.start for passage in passages])
        place = np.searchsorted(begins, times, side="right") - 1
        for i in np.unique(place):
            inside = np.flatnonzero(place == i)
            passage = passages[i]
            step, after = self.steps[passage.piece], times[inside] - passage.start
            inside, after = (
                inside[after <= passage.duration * (1 + 1e-12)],
                after[after <= passage.duration * (1 + 1e-12)],
            )
            state, whole = np.append(passage.state, 1.0), (after / step).astype(int)
            begun = 0
            for jump in np.unique(whole // BLOCK):
                for _ in range(int(jump) - begun):
                    state = self.powers[passage.piece][BLOCK] @ state
                begun = int(jump)
                here = whole // BLOCK == jump
                near = self.powers[passage.piece][whole[here] % BLOCK] @ state
                terms = (after[here] - whole[here] * step)[:, None] ** np.arange(TAYLOR)
                moved = np.einsum("ki,iab,kb->ka", terms, self.taylor[passage.piece], near)
                found[inside[here]] = moved[:, :-1]
        return found

    def _leave(
        self, piece: int, state: Reals, longest: float, start: float | None
    ) -> tuple[float, Reals, float | None]:
        """How long the solution stays on the piece, where it leaves it, and across which level (None: it stays)."""
        low = self.levels[piece - 1] if piece > 0 else -math.inf
        high = self.levels[piece] if piece < len(self.levels) else math.inf
        elapsed, step = 0.0, self.steps[piece]
        while elapsed < longest and np.isfinite(state).all():
            y = self.outputs[piece] @ state
            outside = np.flatnonzero((y < low) | (y > high))
            if len(outside) == 0:
                state, elapsed, start = self.powers[piece][-1] @ state, elapsed + BLOCK * step, None
                continue
            i = int(outside[0])
            state = self.powers[piece][i] @ state
            level = high if y[i] > high else low
            t = self._crossing(piece, state, level, deflate=i == 0 and start == level)
            return elapsed + i * step + t, self._advance(piece, state, t), level
        return longest, state, None

    def _crossing(self, piece: int, state: Reals, level: float, *, deflate: bool) -> float:
        """Where ``y`` meets the level within one step; ``deflate``: other than at 0, where it starts."""
        p = (self.row @ self.taylor[piece]) @ state
        p[0] = 0.0 if deflate else p[0] - level
        p = p[1:] if deflate else p
        low, high, sign = 0.0, self.steps[piece], float(np.sign(p[0]))
        t, change = 0.5 * high, math.inf
        backwards = p[::-1].tolist()
        for _ in range(60):
            value = derivative = 0.0
            for coefficient in backwards:  # Horner's rule, for the derivative too
                derivative = derivative * t + value
                value = value * t + coefficient
            low, high = (t, high) if value * sign > 0 else (low, t)
            new = t - value / derivative if derivative != 0 else math.nan
            new = new if low < new < high else 0.5 * (low + high)
            change, before = abs(new - t) / self.steps[piece], change
            if change <= 1e-15 or before <= change < 1e-9:  # to the last bit, or to what rounding leaves of it
                break
            t = new
        return t

    def _advance(self, piece: int, state: Reals, t: float) -> Reals:
        """The state after a time within one step."""
        return np.asarray(np.tensordot(t ** np.arange(TAYLOR), self.taylor[piece], 1) @ state)


def returns(passages: Sequence[Passage], *, tolerance: float = 1e-6) -> tuple[int, int] | None:
    """The last two passages ``(i, j)`` that start on one piece in one state, to a relative tolerance, if any do."""
    last = len(passages) - 2
    for i in range(last - 1, max(-1, last - 200), -1):
        a, b = passages[i], passages[last]
        scale = float(np.abs(b.state).max())
        if a.piece == b.piece and np.abs(a.state - b.state).max() <= tolerance * scale:
            return i, last
    return None


BITS = 256
NEWTON_STEPS = 60
DEEPEST = 24


@described(frozen=True, kw_only=True, slots=True)
class Itinerary:
    """The pieces an orbit visits and how long it stays on each."""

    pieces: tuple[int, ...] = quantity("Counted from the left; neighbours follow one another")
    durations: tuple[Fraction, ...] = quantity("Times [s] on the pieces, approximate")
    state: Row = quantity("(n,), where it enters the first of the pieces, approximate")
    half: bool = quantity(
        "Whether they make half a period, after which the state is the negative of the first (the nonlinearity is "
        "then odd)"
    )

    @property
    def period(self) -> float:
        """Period of the orbit [s]."""
        return float(sum(self.durations)) * (2 if self.half else 1)


@dataclass(frozen=True, slots=True)
class _Shot:
    """States at the switches for a first state and durations, what the equations miss, and their derivative."""

    states: list[arb_mat]
    misses: arb_mat
    jacobian: arb_mat


def refined(loop: PiecewiseLoop, orbit: Itinerary) -> Itinerary | None:
    """The itinerary after Newton's method; None if it does not converge to positive durations."""
    if not _consistent(loop, orbit):
        return None
    n = loop.system.order
    with working_precision(BITS):
        equations = _Equations(loop, orbit)
        unknowns = [ball(v) for v in (*orbit.state, *orbit.durations)]
        for _ in range(NEWTON_STEPS):
            try:
                shot = equations.shoot(unknowns)
                step = shot.jacobian.mid().solve(shot.misses.mid()).mid()
            except ZeroDivisionError:
                return None
            largest = float(max(abs(step[i, 0]) / unknowns[i] for i in range(n, len(unknowns))))
            damping = 1.0 if largest < 0.3 else 0.3 / largest
            unknowns = [(u - damping * step[i, 0]).mid() for i, u in enumerate(unknowns)]
            if not all(t > 0 and t.is_finite() for t in unknowns[n:]):
                return None
            if largest < 2.0 ** (-BITS // 2):
                exact = tuple(exact_midpoint(u) for u in unknowns)
                return Itinerary(pieces=orbit.pieces, durations=exact[n:], state=exact[:n], half=orbit.half)
    return None


def proved(loop: PiecewiseLoop, orbit: Itinerary) -> bool:
    r"""Whether the loop is proved to have a periodic solution with this itinerary, near these durations.

    The first state and the durations, ``z = (x_0, tau)``, of a periodic solution solve ``F(z) = 0``: ``x_m = +-x_0``,
    and ``c x_i`` on the level at every switch.  Krawczyk's operator ``z - Y F(z) + (1 - Y F'(Z)) (Z - z)`` maps a box
    ``Z`` into its interior: one zero in ``Z``.  Then ``y = c x(t)`` is shown to stay on the piece between the switches:
    near each end because ``y`` starts on the level and ``y'`` keeps its sign, elsewhere by bounds on subintervals.  All
    of it in ball arithmetic, for the exact nonlinearity and block.

    ``orbit``: candidate, refined.

    Returns
    -------
    bool
        True is a proof; False says nothing.
    """
    if not _consistent(loop, orbit):
        return False
    with working_precision(BITS):
        try:
            equations = _Equations(loop, orbit)
            enclosed = equations.enclosed([ball(v).mid() for v in (*orbit.state, *orbit.durations)])
            if enclosed is None:
                return False
            states = equations.shoot(enclosed).states
        except ZeroDivisionError:
            return False
        durations = enclosed[loop.system.order :]
        return all(equations.stays(i, states[i], t) for i, t in enumerate(durations))


def _consistent(loop: PiecewiseLoop, orbit: Itinerary) -> bool:
    """Whether the pieces follow one another and close, and a half orbit has an odd nonlinearity."""
    if orbit.half and not loop.nonlinearity.odd:
        return False
    last = loop.mirrored(orbit.pieces[0]) if orbit.half else orbit.pieces[0]
    path = [*orbit.pieces, last]
    inside = all(0 <= p < len(loop.generators) for p in path)
    return inside and len(orbit.pieces) > 1 and all(abs(p - q) == 1 for p, q in pairwise(path))


class _Equations:
    """The equations of an orbit with a given itinerary."""

    def __init__(self, loop: PiecewiseLoop, orbit: Itinerary) -> None:
        self.n = loop.system.order
        self.sign = -1 if orbit.half else 1
        self.row = balls([[*loop.system.c, Fraction(0)]])
        self.generators = [balls(loop.generators[p]) for p in orbit.pieces]
        self.bounds = [loop.interval(p) for p in orbit.pieces]
        closing = loop.mirrored(orbit.pieces[0]) if orbit.half else orbit.pieces[0]
        following = [*orbit.pieces[1:], closing]
        self.exits = [loop.levels[min(p, q)] for p, q in zip(orbit.pieces, following, strict=True)]
        self.rises = [q > p for p, q in zip(orbit.pieces, following, strict=True)]
        self.entries = [self.sign * self.exits[-1], *self.exits[:-1]]
        self.entered_up = [self.rises[-1] == (self.sign == 1), *self.rises[:-1]]

    def shoot(self, unknowns: Sequence[arb]) -> _Shot:
        """States, misses and their derivative by the first state and the durations."""
        n, times = self.n, unknowns[self.n :]
        steps = [(G * t).exp() for G, t in zip(self.generators, times, strict=True)]
        states = [arb_mat([*([u] for u in unknowns[:n]), [arb(1)]])]
        change = arb_mat([[arb(int(i == j)) for j in range(n + len(times))] for i in range(n + 1)])
        for i in range(n, n + len(times)):
            change[n, i] = arb(0)
        rows, misses = [], []
        for i, step in enumerate(steps):
            rows.append(self.row * change)
            misses.append((self.row * states[-1])[0, 0] - ball(self.entries[i]))
            states.append(step * states[-1])
            push = self.generators[i] * states[-1]
            change = step * change
            for j in range(n):
                change[j, n + i] = push[j, 0]
        closing = [[change[i, j] - (self.sign if i == j else 0) for j in range(n + len(times))] for i in range(n)]
        jacobian = arb_mat([*closing, *([row[0, j] for j in range(n + len(times))] for row in rows)])
        gaps = [states[-1][i, 0] - self.sign * states[0][i, 0] for i in range(n)]
        return _Shot(states, arb_mat([[v] for v in (*gaps, *misses)]), jacobian)

    def enclosed(self, unknowns: Sequence[arb]) -> list[arb] | None:
        """Balls around the unknowns that hold a zero with positive durations; None if every radius tried fails."""
        m = len(unknowns)
        shot = self.shoot(unknowns)
        inverse = shot.jacobian.mid().inv().mid()
        correction = inverse * shot.misses
        largest = max(abs(u) for u in unknowns[: self.n])
        scale = [largest] * self.n + list(unknowns[self.n :])
        for exponent in (-BITS // 2, -BITS // 4, -BITS // 8, -16):
            radius = [s.mid() * arb(2) ** exponent for s in scale]
            box = [u + r * arb(0, 1) for u, r in zip(unknowns, radius, strict=True)]
            contraction = _identity(m) - inverse * self.shoot(box).jacobian
            spread = contraction * arb_mat([[r * arb(0, 1)] for r in radius])
            image = [unknowns[i] - correction[i, 0] + spread[i, 0] for i in range(m)]
            inside = all(b.contains_interior(k) for b, k in zip(box, image, strict=True))
            if inside and all(t > 0 for t in image[self.n :]):
                return image
        return None

    def stays(self, i: int, state: arb_mat, duration: arb) -> bool:
        """Whether ``y`` is on the ``i``-th piece from entry to exit."""
        end = duration.upper()
        low, high = (None if b is None else ball(b) for b in self.bounds[i])
        cells = [(end * a / 8, end * (a + 1) / 8, 0) for a in range(8)]
        while cells:
            a, b, depth = cells.pop()
            a, b = a.mid(), b.mid()
            y, slope = self._bounds_on(i, state, a, b)
            at_start, at_end = a <= 0, b >= end
            above = low is None or y > low
            below = high is None or y < high
            if at_start and (slope > 0 if self.entered_up[i] else slope < 0):
                above, below = above or self.entered_up[i], below or not self.entered_up[i]
            if at_end and (slope > 0 if self.rises[i] else slope < 0):
                above, below = above or not self.rises[i], below or self.rises[i]
            if above and below:
                continue
            if depth == DEEPEST:
                return False
            middle = ((a + b) / 2).mid()
            cells += [(a, middle, depth + 1), (middle, b, depth + 1)]
        return True

    def _bounds_on(self, i: int, state: arb_mat, a: arb, b: arb) -> tuple[arb, arb]:
        """Balls around ``y`` and ``y'`` on ``[a, b]``, by Taylor's formula at the middle."""
        G = self.generators[i]
        middle, half = ((a + b) / 2).mid(), ((b - a) / 2).upper()
        span = half * arb(0, 1)
        at = (G * middle).exp() * state
        first = G * at
        second = G * first
        remainder = (self.row * ((G * span).exp() * second))[0, 0]
        y, slope = (self.row * at)[0, 0], (self.row * first)[0, 0]
        return y + slope * span + remainder * (half * half / 2) * arb(0.5, 0.5), slope + remainder * span


def _identity(n: int) -> arb_mat:
    return arb_mat([[arb(int(i == j)) for j in range(n)] for i in range(n)])

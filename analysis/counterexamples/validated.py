"""Periodic orbits of piecewise-linear loops, proved to exist in ball arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat

from lure.analysis.counterexamples.linear import Row, balls
from lure.analysis.counterexamples.piecewise import PiecewiseLoop
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision

BITS = 256
NEWTON_STEPS = 60
DEEPEST = 24


@dataclass(frozen=True, kw_only=True, slots=True)
class Itinerary:
    """The pieces an orbit visits and how long it stays on each.

    Attributes
    ----------
    pieces : tuple of int
        Counted from the left; neighbours follow one another.
    durations : tuple of Fraction
        Times [s] on the pieces, approximate.
    state : tuple of Fraction
        (n,), where it enters the first of the pieces, approximate.
    half : bool
        Whether they make half a period, after which the state is the negative of the first (the law is then odd).
    """

    pieces: tuple[int, ...]
    durations: tuple[Fraction, ...]
    state: Row
    half: bool

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
    of it in ball arithmetic, for the exact law and block.

    Parameters
    ----------
    loop : PiecewiseLoop
        The loop.
    orbit : Itinerary
        Candidate, refined.

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
    """Whether the pieces follow one another and close, and a half orbit has an odd law."""
    if orbit.half and not loop.law.odd:
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

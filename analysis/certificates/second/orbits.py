"""Periodic solutions of loops with a piecewise-linear nonlinearity, proved by Krawczyk's test on all their switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import arb, arb_mat

from lure.analysis.certificates.second.classes import Graph
from lure.analysis.certificates.second.numerics import ball, balls, working_precision
from lure.analysis.certificates.second.reading import count, flag, listed, number, numbers, require, tick
from lure.analysis.certificates.second.systems import States

BITS = 256
NEWTON_STEPS = 40
RADII = (-BITS // 2, -BITS // 4, -BITS // 8)  # binary exponents, relative to the size of the unknown
DEEPEST = 24
MOST_UNKNOWNS = 1000


@dataclass(frozen=True, kw_only=True, slots=True)
class Watched:
    """What lies on one piece during a stay.

    Attributes
    ----------
    row : tuple of Fraction
        (n + 1,), its product with ``(x, 1)`` is ``y``, with one channel ``c x = sigma + D phi(sigma)``.
    low, high : Fraction or None
        Between which it lies.
    enters, leaves : int
        1 where ``y`` begins, or ends, at one of these and ascends, -1 where it descends, 0 where it lies between them.
    """

    row: tuple[Fraction, ...]
    low: Fraction | None
    high: Fraction | None
    enters: int
    leaves: int


@dataclass(frozen=True, kw_only=True, slots=True)
class Stay:
    """One stay on a piece in each channel, ``(x, 1)' = G (x, 1)``.

    Attributes
    ----------
    G : tuple of tuples
        ``[[A - k b c/(1 + k D), -b q/(1 + k D)], [0, 0]]`` where ``phi = k sigma + q``.
    entry : tuple of Fraction
        (n + 1,), its product with ``(x, 1)`` is 0 at the beginning.
    watched : tuple of Watched
        What does not leave its piece.
    """

    G: tuple[tuple[Fraction, ...], ...]
    entry: tuple[Fraction, ...]
    watched: tuple[Watched, ...]


def stays_of(system: States, nonlinearity: Graph, pieces: Sequence[int], *, half: bool) -> list[Stay]:
    """The stays of an orbit that visits these pieces, counted from the left, kinks of the graph between them.

    Parameters
    ----------
    system : States
        The linear part.
    nonlinearity : Graph
        The nonlinearity.
    pieces : sequence of int
        Each beside the one before.
    half : bool
        Whether they make half a period, after which the state is the negative of the first.

    Raises
    ------
    NotShown
        ``1 + D slope > 0`` fails on a piece, the pieces do not follow one another, or half a period needs an odd
        nonlinearity.
    """
    require(all(1 + system.d * k > 0 for k in nonlinearity.slopes), "1 + D slope is not positive on every piece")
    require(nonlinearity.odd or not half, "half a period needs an odd nonlinearity")
    kinks = nonlinearity.kinks
    levels = [x + system.d * w for x, w, _ in kinks]
    path = [*pieces, len(kinks) - pieces[0] if half else pieces[0]]
    require(all(0 <= p <= len(kinks) for p in path), "there is no such piece")
    require(all(abs(p - q) == 1 for p, q in pairwise(path)), "the pieces do not follow one another")
    ups = [q > p for p, q in pairwise(path)]
    ends = [levels[min(p, q)] for p, q in pairwise(path)]
    lines = [(nonlinearity.knots[0], nonlinearity.values[0], nonlinearity.slopes[0]), *kinks]
    found = []
    for i, piece in enumerate(pieces):
        x, w, k = lines[piece]
        force = (w - k * x) / (1 + k * system.d)
        rows = [(*row, -force * b) for row, b in zip(system.closed(k), system.b, strict=True)]
        output = Watched(
            row=(*system.c, Fraction(0)),
            low=levels[piece - 1] if piece > 0 else None,
            high=levels[piece] if piece < len(levels) else None,
            enters=1 if (ups[i - 1] if i else ups[-1] != half) else -1,
            leaves=1 if ups[i] else -1,
        )
        start = ends[i - 1] if i else -ends[-1] if half else ends[-1]
        still = (Fraction(0),) * (system.order + 1)
        found.append(Stay(G=(*rows, still), entry=(*system.c, -start), watched=(output,)))
    return found


def orbit_numbers(found: Mapping[str, object]) -> tuple[list[Fraction], list[Fraction], bool]:
    """First state and durations of an orbit, and whether they make half a period; nothing rests on the others.

    Raises
    ------
    NotShown
        A duration is not positive.
    """
    count(found["bits"], least=1)
    number(found["radius"])
    inverse = [numbers(row) for row in listed(found["inverse"])]
    require(all(len(row) == len(inverse) for row in inverse), "the inverse is not square")
    state, durations = numbers(found["state"]), numbers(found["durations"])
    require(all(duration > 0 for duration in durations), "a duration is not positive")
    return state, durations, flag(found["half"])


def require_periodic(
    stays: Sequence[Stay], state: Sequence[Fraction], durations: Sequence[Fraction], *, half: bool
) -> None:
    r"""Check that there is a periodic solution with these stays, near a first state and durations.

    The states at the beginnings of the stays and the durations ``z = (x_0, .., x_{m-1}, t_0, .., t_{m-1})`` solve
    ``exp(G_i t_i) x_i = x_{i+1}``, ``x_m = +-x_0``, and ``entry_i (x_i, 1) = 0``.  Krawczyk's operator
    ``z - Y F(z) + (1 - Y F'(Z)) (Z - z)`` maps a box ``Z`` into its interior: there is one zero in it.  Then
    every ``y`` is shown to stay on each piece.

    Parameters
    ----------
    stays : sequence of Stay
        The pieces.
    state : sequence of Fraction
        (n,), approximate.
    durations : sequence of Fraction
        As many as stays, approximate.
    half : bool
        Whether ``x_m = -x_0``.

    Raises
    ------
    NotShown
        It is not proved.
    """
    n, m = len(state), len(stays)
    require(m * (n + 1) <= MOST_UNKNOWNS, "the orbit has too many switches for this order")
    with working_precision(BITS):
        equations = _Equations(n, stays, half=half)
        box = equations.enclosed(equations.near([ball(v) for v in state], [ball(t) for t in durations]))
        require(all(t > 0 for t in box[n * m :]), "a duration is not shown to be positive")
        for i, stay in enumerate(stays):
            start = arb_mat([*([v] for v in box[n * i : n * (i + 1)]), [arb(1)]])
            for one in stay.watched:
                require(equations.on_its_piece(i, one, start, box[n * m + i]), "y is not shown to stay on a piece")


class _Equations:
    """The equations of an orbit, and the enclosure of their solution, at the working precision."""

    def __init__(self, n: int, stays: Sequence[Stay], *, half: bool) -> None:
        self.n, self.m, self.sign = n, len(stays), -1 if half else 1
        self.generators = [balls(stay.G) for stay in stays]
        self.entries = [balls([stay.entry]) for stay in stays]

    def at(self, z: Sequence[arb]) -> tuple[arb_mat, arb_mat]:
        """``F(z)`` and ``F'(z)``."""
        n, m = self.n, self.m
        values, slopes = list[arb](), [[arb(0)] * (m * (n + 1)) for _ in range(m * (n + 1))]
        for i, G in enumerate(self.generators):
            tick()
            step = (G * z[n * m + i]).exp()
            end = step * arb_mat([*([v] for v in z[n * i : n * (i + 1)]), [arb(1)]])
            push, sign, after = G * end, self.sign if i == m - 1 else 1, (i + 1) % m
            for j in range(n):
                row = slopes[n * i + j]
                values.append(end[j, 0] - sign * z[n * after + j])
                for k in range(n):
                    row[n * i + k] += step[j, k]
                row[n * after + j] -= sign
                row[n * m + i] = push[j, 0]
        for i, entry in enumerate(self.entries):
            values.append(sum((entry[0, k] * z[n * i + k] for k in range(n)), entry[0, n]))
            slopes[n * m + i][n * i : n * (i + 1)] = [entry[0, k] for k in range(n)]
        return arb_mat([[v] for v in values]), arb_mat(slopes)

    def near(self, state: Sequence[arb], durations: Sequence[arb]) -> list[arb]:
        """Exact numbers near a solution, by Newton's method from the orbit followed once; nothing rests on it."""
        states, at = list[arb](), arb_mat([*([v] for v in state), [arb(1)]])
        for G, t in zip(self.generators, durations, strict=True):
            states += [at[j, 0].mid() for j in range(self.n)]
            at = (G * t).exp() * at
        z = [*states, *(t.mid() for t in durations)]
        for _ in range(NEWTON_STEPS):
            values, slopes = self.at(z)
            step = slopes.mid().solve(values.mid()).mid()
            z = [(v - step[j, 0]).mid() for j, v in enumerate(z)]
            if all(abs(step[j, 0]) <= size * arb(2) ** (-BITS // 2) for j, size in enumerate(self._sizes(z))):
                break
        return z

    def _sizes(self, z: Sequence[arb]) -> list[arb]:
        count = self.n * self.m
        return [max(abs(v) for v in z[:count])] * count + [abs(t) for t in z[count:]]

    def enclosed(self, z: Sequence[arb]) -> list[arb]:
        """Balls around exact numbers that hold a solution.

        Raises
        ------
        NotShown
            No radius tried leads to any.
        """
        values, slopes = self.at(z)
        inverse = slopes.mid().inv().mid()
        correction, sizes, order = inverse * values, self._sizes(z), len(z)
        for exponent in RADII:
            box = [v + (size * arb(2) ** exponent).mid() * arb(0, 1) for v, size in zip(z, sizes, strict=True)]
            moved = inverse * self.at(box)[1]
            left = arb_mat([[int(i == j) - moved[i, j] for j in range(order)] for i in range(order)])
            spread = left * arb_mat([[whole - v] for whole, v in zip(box, z, strict=True)])
            image = [v - correction[j, 0] + spread[j, 0] for j, v in enumerate(z)]
            if all(whole.contains_interior(part) for whole, part in zip(box, image, strict=True)):
                return image
        require(False, "no periodic orbit is proved to exist")  # noqa: FBT003  (it is the condition)
        return []

    def on_its_piece(self, i: int, one: Watched, start: arb_mat, duration: arb) -> bool:
        """Whether ``y`` is on the piece during a stay; where it begins or ends at a level it is there exactly.

        On each part ``y(t) = y(middle) + y'(..) (t - middle)``; parts are halved until that decides.  At the ends the
        sign of ``y'`` does.
        """
        G, end = self.generators[i], duration.upper()
        low, high = (None if side is None else ball(side) for side in (one.low, one.high))
        seen = balls([one.row])
        pending = [(0, 0)]
        while pending:
            tick()
            depth, part = pending.pop()
            count = 2**depth
            span = (end * part / count).union(end * (part + 1) / count)
            middle = span.mid()
            slope = (seen * G * ((G * span).exp() * start))[0, 0]
            y = (seen * ((G * middle).exp() * start))[0, 0] + slope * (span - middle)
            rises, falls, first, last = slope > 0, slope < 0, part == 0, part == count - 1
            above = low is None or y > low or (first and one.enters > 0 and rises)
            above = above or (last and one.leaves < 0 and falls)
            below = high is None or y < high or (first and one.enters < 0 and falls)
            below = below or (last and one.leaves > 0 and rises)
            if above and below:
                continue
            if depth == DEEPEST:
                return False
            pending += [(depth + 1, 2 * part), (depth + 1, 2 * part + 1)]
        return True

r"""Periodic solutions of loops with piecewise linear nonlinearities: from waves in doubles to the numbers of a proof.

On a stay every ``phi_i`` is on one of its pieces and ``(x, 1)' = G (x, 1)``; it ends when one ``sigma_i`` is on a
kink.  First state and durations solve ``x_m = +-x_0``, ``entry_i (x_i, 1) = 0``.  Newton's method in wide numbers finds
them, the checker's test of a contraction around them decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

from flint import arb, arb_mat

from lure.analysis.certificates.arithmetic import IllPosed
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.gains import affine
from lure.analysis.counterexamples.balance import Balance, Side, Wave
from lure.analysis.counterexamples.linear import balls
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import np

LADDER = (256, 512, 1024, 2048, 4096)
SHARES = (Fraction(5, 8), Fraction(1, 2), Fraction(3, 8))
POLISHING = 12
INVERSE_BITS = 48
_FINE, _CLOSING, _DIGITS = 8192, 40, 12
_MOST_STAYS = 60
_BEYOND = (0.01, -0.01, 0.03, -0.03, 0.1, -0.1)

Rows = Sequence[Sequence[Fraction]]


class Course(NamedTuple):
    """A periodic solution, approximately, and what it solves.

    Attributes
    ----------
    stays : sequence of tuple
        ``G``, (n + 1, n + 1), and ``entry``, (n + 1,), of every stay, exact.
    state : sequence of Fraction
        (n,), at the beginning of the first stay.
    durations : sequence of Fraction
        Of the stays [s].
    half : bool
        Whether they make half a period, after which the state is the negative of the first.
    """

    stays: Sequence[tuple[Rows, Sequence[Fraction]]]
    state: Sequence[Fraction]
    durations: Sequence[Fraction]
    half: bool

    def numbers(self, bits: int) -> dict[str, Any]:
        """State and durations to so many bits after the point, and the inverse of the Jacobian there.

        Parameters
        ----------
        bits : int
            How many.

        Raises
        ------
        ZeroDivisionError
            The Jacobian is singular.
        """
        n = len(self.state)
        with working_precision(2 * bits):
            unknowns = [ball(v) for v in (*self.state, *self.durations)]
            m = len(unknowns)
            for _ in range(POLISHING):
                checkpoint()
                shot = self.shot(unknowns)
                misses, jacobian = (
                    arb_mat([[shot[i, j] for j in columns] for i in range(m)]).mid()
                    for columns in ([0], range(1, m + 1))
                )
                inverse = jacobian.inv().mid()
                step = inverse * misses
                unknowns = [(u - step[i, 0]).mid() for i, u in enumerate(unknowns)]
                if max(abs(step[i, 0]) for i in range(m)) < arb(2) ** -(bits + 8):
                    break
            size = max(sum((abs(jacobian[i, j]) for j in range(m)), arb(0)) for i in range(m))
            digits = max(0, INVERSE_BITS + round(float(size)).bit_length())
            exact = [_rounded(exact_midpoint(u), bits) for u in unknowns]
            rows = [[str(_rounded(exact_midpoint(inverse[i, j]), digits)) for j in range(m)] for i in range(m)]
        return {
            "durations": [*map(str, exact[n:])],
            "state": [*map(str, exact[:n])],
            "half": self.half,
            "inverse": rows,
        }

    def shot(self, unknowns: Sequence[arb]) -> arb_mat:
        """``[F, F']`` at first state and durations: what closure and entries miss, and the derivative.

        Parameters
        ----------
        unknowns : sequence of arb
            First state, then durations.
        """
        n, sign, m = len(self.state), -1 if self.half else 1, len(unknowns)
        start = [*unknowns[:n], arb(1)]
        first = arb_mat([[x, *(arb(int(i == j < n)) for j in range(m))] for i, x in enumerate(start)])
        Z, rows = first, []
        for i, (matrix, entry) in enumerate(self.stays):
            G, t = balls(matrix), unknowns[n + i]
            row = balls([entry]) * Z
            rows.append([row[0, j] for j in range(m + 1)])
            Z = (G * t).exp() * Z
            push = G * Z
            for j in range(n):
                Z[j, n + 1 + i] += push[j, 0]
        closing = [[Z[i, j] - sign * first[i, j] for j in range(m + 1)] for i in range(n)]
        return arb_mat(closing + rows)

    def closed(self) -> Course | None:
        """The course after damped steps of Newton's method; None if it does not converge to positive durations."""
        n = len(self.state)
        with working_precision(128):
            unknowns = [ball(v) for v in (*self.state, *self.durations)]
            for _ in range(_CLOSING):
                checkpoint()
                shot, m = self.shot(unknowns), len(unknowns)
                try:
                    step = (
                        arb_mat([[shot[i, j] for j in range(1, m + 1)] for i in range(m)])
                        .mid()
                        .solve(arb_mat([[shot[i, 0]] for i in range(m)]).mid())
                    )
                except ZeroDivisionError:
                    return None
                largest = max(abs(float(step[i, 0])) / float(unknowns[i]) for i in range(n, m))
                if not math.isfinite(largest):
                    return None
                damping = min(1.0, 0.3 / max(largest, 1e-300))
                unknowns = [(u - damping * step[i, 0]).mid() for i, u in enumerate(unknowns)]
                if not all(float(t) > 0 for t in unknowns[n:]):
                    return None
                if largest < 1e-15:
                    exact = [exact_midpoint(u) for u in unknowns]
                    return self._replace(state=exact[:n], durations=exact[n:])
        return None


def _rounded(value: Fraction, bits: int) -> Fraction:
    """The nearest multiple of ``2^-bits``."""
    return Fraction(round(value * 2**bits), 2**bits)


def exact_sides(
    sides: tuple[Side, Side], low: Fraction, high: Fraction
) -> tuple[list[tuple[Fraction, Fraction]], Fraction, Fraction]:
    """Points of a staircase, (0, 0) among them, and its slopes to the left and to the right.

    Parameters
    ----------
    sides : tuple of (Side, Side)
        To the right and to the left of 0.
    low, high : Fraction
        The slopes.
    """
    found, tails = list[list[tuple[Fraction, Fraction]]](), list[Fraction]()
    for side in sides:
        x = w = Fraction(0)
        slope, points = (high if side.steep else low), list[tuple[Fraction, Fraction]]()
        for kink in side.kinks:
            at = Fraction(f"{kink:.{_DIGITS}g}")
            if at <= x:
                continue
            x, w = at, w + slope * (at - x)
            points.append((x, w))
            slope = low if slope == high else high
        found.append(points)
        tails.append(slope)
    right, left = found
    return [*((-x, -w) for x, w in reversed(left)), (Fraction(0), Fraction(0)), *right], tails[1], tails[0]


class Graphs(NamedTuple):
    """Of every channel what tells its pieces: where each begins, a point of it and its slope."""

    data: list[dict[str, Any]]
    lines: list[list[tuple[Fraction, Fraction, Fraction]]]

    @classmethod
    def of(cls, wave: Wave, balance: Balance, lower: Sequence[Fraction], upper: Sequence[Fraction]) -> Graphs:
        """The staircases of a wave.

        Parameters
        ----------
        wave : Wave
            The waves.
        balance : Balance
            What they balance.
        lower, upper : sequence of Fraction
            (m,) the slopes.
        """
        data, lines = [], list[list[tuple[Fraction, Fraction, Fraction]]]()
        for block, sides in zip(balance.blocks, wave.sides, strict=True):
            points, left, right = exact_sides(sides, lower[block[0]], upper[block[0]])
            data.append({"points": [[*map(str, p)] for p in points], "left": str(left), "right": str(right)})
            slopes = [left, *((w - v) / (x - y) for (y, v), (x, w) in pairwise(points)), right]
            kinks = [(x, w, k) for (x, w), h, k in zip(points, slopes, slopes[1:], strict=False) if h != k]
            lines += [[(*points[0], left), *kinks]] * len(block)
        return cls(data, lines)


def course(
    wave: Wave, balance: Balance, H: Plant, graphs: Graphs, *, half: bool
) -> tuple[list[list[int]], Course] | None:
    """The pieces that waves visit, and their course; None where they visit only one, or too many.

    Parameters
    ----------
    wave : Wave
        The waves.
    balance : Balance
        What they balance.
    H : Plant
        The plant, exact.
    graphs : Graphs
        The nonlinearities.
    half : bool
        Whether half a period is to be taken.
    """
    phase = np.arange(_FINE) * (2 * math.pi / _FINE)
    turns = np.exp(1j * np.outer(phase, balance.harmonics))
    sigma = (wave.waves @ turns.T).real
    pieces = np.array(
        [np.searchsorted([float(x) for x, _, _ in own[1:]], row) for own, row in zip(graphs.lines, sigma, strict=True)]
    )
    switches = [int(q) for q in np.flatnonzero((np.roll(pieces, -1, axis=1) != pieces).any(axis=0))]
    if not switches:
        return None
    first, whole = switches[0], _FINE // 2 if half else _FINE
    kept = [q for q in switches if q < first + whole]
    path, times, before = list[list[int]](), list[float](), [int(p) for p in pieces[:, first]]
    for q, following in zip(kept, [*kept[1:], first + whole], strict=True):
        after = [int(p) for p in pieces[:, (q + 1) % _FINE]]
        steps = [
            (i, 1 if b > a else -1)
            for i, (a, b) in enumerate(zip(before, after, strict=True))
            for _ in range(abs(b - a))
        ]
        share = (following - q) / len(steps)
        for i, step in steps:
            before = [*before[:i], before[i] + step, *before[i + 1 :]]
            path.append(before)
            times.append(share)
    if not 1 < len(path) <= _MOST_STAYS:
        return None
    f = balance.harmonics_of(balance.nonlinear(wave, balance.sampled(wave))[0])
    inverse = np.linalg.inv(
        1j * wave.omega * np.array(balance.harmonics)[:, None, None] * np.eye(len(balance.A)) - balance.A
    )
    states = -np.einsum("hij,jk,kh->ih", inverse, balance.B, f)
    start = (states @ turns[first]).real
    seconds = np.array(times) * (2 * math.pi / wave.omega / _FINE)
    stays = exact_stays(H, graphs, path, half=half)
    if stays is None or not np.isfinite(start).all():
        return None
    return path, Course(stays, [Fraction(float(v)) for v in start], [Fraction(float(v)) for v in seconds], half)


def exact_stays(
    H: Plant, graphs: Graphs, path: Sequence[Sequence[int]], *, half: bool
) -> list[tuple[Rows, Sequence[Fraction]]] | None:
    """``G`` and ``entry`` of every stay; None where the pieces do not close, or the loop has no solution on one.

    Parameters
    ----------
    H : Plant
        The plant.
    graphs : Graphs
        The nonlinearities.
    path : sequence of sequence of int
        The piece of every channel, stay after stay.
    half : bool
        Whether they make half a period.
    """
    closing = [len(own) - 1 - p for own, p in zip(graphs.lines, path[0], strict=True)] if half else list(path[0])
    moves = [
        [(i, max(p, q)) for i, (p, q) in enumerate(zip(a, b, strict=True)) if p != q]
        for a, b in pairwise([*path, closing])
    ]
    if any(len(one) != 1 for one in moves):
        return None
    found, known = list[tuple[Rows, Sequence[Fraction]]](), dict[tuple[int, ...], tuple[Rows, Rows]]()
    for j, at in enumerate(path):
        i, kink = moves[j - 1][0]
        key = tuple(at)
        if key not in known:
            try:
                known[key] = affine(H, [own[p] for own, p in zip(graphs.lines, at, strict=True)], Fraction(1))
            except IllPosed:
                return None
        G, sigma = known[key]
        level = graphs.lines[i][kink][0] * (-1 if half and not j else 1)
        found.append((G, [*sigma[i][:-1], sigma[i][-1] - level]))
    return found


class Found(NamedTuple):
    """A periodic solution in exact numbers, approximately, with the factor of the classes that hold its members."""

    alpha: Fraction
    graphs: Graphs
    pieces: list[list[int]]
    course: Course


def near_fold(
    balance: Balance, wave: Wave, H: Plant, lower: Sequence[Fraction], upper: Sequence[Fraction]
) -> Iterator[Found]:
    """Solutions on both sides of a fold, the nearest first.

    Parameters
    ----------
    balance : Balance
        The balance.
    wave : Wave
        Waves that satisfy it.
    H : Plant
        The plant.
    lower, upper : sequence of Fraction
        (m,) bounds of the slopes at ``alpha = 1``.
    """
    half = all(h % 2 for h in balance.harmonics)
    for step in _BEYOND:
        near = balance.beside(wave, step)
        if near is None:
            continue
        alpha = Fraction(f"{near.alpha:.9g}")
        graphs = Graphs.of(near, balance, lower, [alpha * u for u in upper])
        begun = course(near, balance, H, graphs, half=half)
        closed = None if begun is None else begun[1].closed()
        if begun is not None and closed is not None:
            yield Found(alpha, graphs, begun[0], closed)


def proofs(found: Found) -> Iterator[dict[str, Any]]:
    """Proofs by ``flow-orbit``, with numbers of more and more digits.

    Parameters
    ----------
    found : Found
        The solution.
    """
    for bits in LADDER[:2]:
        numbers = found.course.numbers(bits)
        for share in SHARES:
            around = {"radius": str(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            shape = {"method": "flow-orbit", "nonlinearities": found.graphs.data, "pieces": found.pieces}
            yield {**shape, **numbers, **around}

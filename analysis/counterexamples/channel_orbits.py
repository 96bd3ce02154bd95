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
from lure.arrays import Complexes, Reals, in_doubles, np

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

        ``bits``: how many.

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

        ``unknowns``: first state, then durations.
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

    ``sides``: to the right and to the left of 0.
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

        ``balance``: what they balance; ``lower``, ``upper``: (m,) the slopes.
        """
        pairs = zip(balance.blocks, wave.sides, strict=True)
        found = [exact_sides(sides, lower[block[0]], upper[block[0]]) for block, sides in pairs]
        return cls.through(found, [len(block) for block in balance.blocks])

    @classmethod
    def through(
        cls, given: Sequence[tuple[Sequence[tuple[Fraction, Fraction]], Fraction, Fraction]], channels: Sequence[int]
    ) -> Graphs:
        """Graphs through points, (0, 0) among them.

        ``given``: the points in ascending order, and the slopes to the left and to the right; ``channels``: in how many
        channels each is.
        """
        data, lines = [], list[list[tuple[Fraction, Fraction, Fraction]]]()
        for (points, left, right), count in zip(given, channels, strict=True):
            data.append({"points": [[*map(str, p)] for p in points], "left": str(left), "right": str(right)})
            slopes = [left, *((w - v) / (x - y) for (y, v), (x, w) in pairwise(points)), right]
            kinks = [(x, w, k) for (x, w), h, k in zip(points, slopes, slopes[1:], strict=False) if h != k]
            lines += [[(*points[0], left), *kinks]] * count
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
    tables = [in_doubles(own) for own in graphs.lines]
    at = [table[row] for table, row in zip(tables, pieces, strict=True)]
    values = np.array([(p[:, 1] + p[:, 2] * (row - p[:, 0])) for p, row in zip(at, sigma, strict=True)])
    f = values @ turns.conj() * (np.where(np.array(balance.harmonics) == 0, 1.0, 2.0) / _FINE)
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

    ``wave``: waves that satisfy it; ``lower``, ``upper``: (m,) bounds of the slopes at ``alpha = 1``.
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
    """Proofs by ``flow-orbit``, with numbers of more and more digits."""
    for bits in LADDER[:2]:
        try:
            numbers = found.course.numbers(bits)
        except ZeroDivisionError:  # the solution is not isolated
            return
        for share in SHARES:
            around = {"radius": str(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            shape = {"method": "flow-orbit", "nonlinearities": found.graphs.data, "pieces": found.pieces}
            yield {**shape, **numbers, **around}


# Periodic solutions of a loop with one play or stop: a balance of the first harmonic, then Newton's method.
#
# With ``sigma = a cos(omega t)`` and the half-width 1 the stop has the describing function ``N(a)``, the play ``1 -
# N(a)``: ``xi`` goes with ``sigma`` from 1 to -1, for ``cos(omega t_1) = 1 - 2/a``, and stays there.  ``1 + g N(a) H(i
# omega) = 0`` gives slopes ``g``; from the least of them on the exact pieces are solved for, and followed to the
# least slope that has a solution.  Nothing here is believed: a checker encloses them.

_AMPLITUDES, _FREQUENCIES, _PHASES, _KEPT = 80, 400, 2000, 6
_ABOVE = (1.002, 1.01, 1.03, 1.1, 1.3)
_STEPS, _LEAST_STEP = 40, 2e-4


class Guess(NamedTuple):
    """A slope, an amplitude and a frequency of the first harmonic."""

    slope: float
    amplitude: float
    omega: float


class MemoryLoop(NamedTuple):
    """``x' = A x + b mu``, ``sigma = c x``, ``mu = -phi``.

    Attributes
    ----------
    A : list of lists of Fraction
        (n, n).
    b, c : list of Fraction
        (n,).
    stop : bool
        Whether a stop; else a play.
    """

    A: list[list[Fraction]]
    b: list[Fraction]
    c: list[Fraction]
    stop: bool

    def stays(self, slope: Fraction) -> list[tuple[list[list[Fraction]], list[Fraction]]]:
        """``G`` and ``entry`` of both parts, ``(x, xi, 1)' = G (x, xi, 1)``.

        ``slope``: of the play or stop.
        """
        zero, n = Fraction(0), len(self.A)
        sign = Fraction(-1 if self.stop else 1)
        rows = [
            [
                *(v - (0 if self.stop else b * slope * u) for v, u in zip(row, self.c, strict=True)),
                sign * b * slope,
                zero,
            ]
            for row, b in zip(self.A, self.b, strict=True)
        ]
        rate = [sum((u * row[k] for u, row in zip(self.c, rows, strict=True)), zero) for k in range(n + 2)]
        still = [zero] * (n + 2)
        return [([*rows, rate, still], rate), ([*rows, still, still], [*still[2:], Fraction(1), Fraction(1)])]

    def guesses(self) -> list[Guess]:
        """Balances of the first harmonic, the least slopes first."""
        A, b, c = np.array(self.A, dtype=float), np.array(self.b, dtype=float), np.array(self.c, dtype=float)
        amplitudes = 1 + np.geomspace(1e-3, 1e3, _AMPLITUDES)
        N = _describing(amplitudes)
        N = N if self.stop else 1 - N
        poles = np.abs(np.linalg.eigvals(A))
        omega = np.geomspace(max(poles.min(), 1e-9) / 100, max(poles.max(), 1e-9) * 100, _FREQUENCIES)
        H = np.array([c @ np.linalg.solve(1j * w * np.eye(len(A)) - A, b) for w in omega])
        loop = N[:, None] * H[None, :]
        crossing = (loop.imag[:, 1:] * loop.imag[:, :-1] < 0) & (loop.real[:, 1:] < 0)
        found = list[Guess]()
        for i, j in np.argwhere(crossing):
            share = loop.imag[i, j] / (loop.imag[i, j] - loop.imag[i, j + 1])
            size = abs(loop.real[i, j] + share * (loop.real[i, j + 1] - loop.real[i, j]))
            found.append(
                Guess(float(1 / size), float(amplitudes[i]), float(omega[j] + share * (omega[j + 1] - omega[j])))
            )
        found.sort(key=lambda one: one.slope)
        return found

    def begun(self, guess: Guess) -> tuple[list[Fraction], list[Fraction]]:
        """First state, ``xi`` included, and durations of a balance."""
        A, b = np.array(self.A, dtype=float), np.array(self.b, dtype=float)
        N = _describing(np.array([guess.amplitude]))[0]
        phi = guess.slope * guess.amplitude * (N if self.stop else 1 - N)
        x = np.linalg.solve(1j * guess.omega * np.eye(len(A)) - A, -b * phi).real
        first = math.acos(1 - 2 / guess.amplitude)
        durations = [first / guess.omega, (math.pi - first) / guess.omega]
        return [*(Fraction(float(v)) for v in x), Fraction(1)], [Fraction(v) for v in durations]

    def course(self, slope: Fraction, state: list[Fraction], durations: list[Fraction]) -> Course | None:
        """The solution near a first state and durations; None if there is none, or not of this shape.

        ``state``, ``durations``: (n + 1,) and (2,).
        """
        checkpoint()
        found = Course(self.stays(slope), state, durations, half=True).closed()
        return found if found is not None and abs(float(found.state[-1]) - 1) < 1e-6 else None

    def least(self, known: float, most: float) -> Iterator[tuple[Fraction, Course]]:
        """Slopes between two with a solution each, the least found first.

        ``known``, ``most``: a slope up to which there is none, and one above which none is sought.
        """
        tried = [one for one in self.guesses() if one.slope < most * 2]
        for guess in tried[:: max(1, len(tried) // _KEPT)][:_KEPT]:
            state, durations = self.begun(guess)
            for above in _ABOVE:
                slope = _short(max(guess.slope, known) * above)
                one = self.course(slope, state, durations)
                if one is not None:
                    found = self._followed(slope, one, known)
                    yield from ((g, course) for g, course in reversed(found) if known < g < most)
                    break

    def _followed(self, slope: Fraction, one: Course, known: float) -> list[tuple[Fraction, Course]]:
        """Solutions for ever smaller slopes."""
        found, step = [(slope, one)], 0.05
        for _ in range(_STEPS):
            smaller = _short(float(slope) * (1 - step))
            near = self.course(smaller, list(one.state), list(one.durations)) if smaller > known else None
            change = (
                1.0
                if near is None
                else max(abs(float(u / v) - 1) for u, v in zip(near.durations, one.durations, strict=True))
            )
            if near is not None and change < 0.5:
                slope, one = smaller, near
                found.append((slope, one))
            else:
                step /= 2
                if step < _LEAST_STEP:
                    break
        return found


def memory_proofs(course: Course, gains: list[Fraction]) -> Iterator[dict[str, Any]]:
    """Proofs by ``memory-orbit``, with numbers of more and more digits.

    ``gains``: one for each channel, the slope of the play or stop among them.
    """
    for bits in LADDER[:2]:
        try:
            numbers = course.numbers(bits)
        except ZeroDivisionError:  # the solution is not isolated
            return
        for share in SHARES:
            around = {"radius": str(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            yield {"method": "memory-orbit", "gains": [*map(str, gains)], **numbers, **around}


def _describing(amplitudes: Reals) -> Complexes:
    """The describing function of the stop of half-width 1 and slope 1, of amplitudes above 1."""
    theta = (np.arange(_PHASES) + 0.5) * (math.pi / _PHASES)
    xi = np.maximum(1 - amplitudes[:, None] * (1 - np.cos(theta)), -1.0)
    return np.asarray(2 / _PHASES * (xi * np.exp(-1j * theta)).sum(axis=1) / amplitudes)


def _short(value: float) -> Fraction:
    return Fraction(f"{value:.9g}")

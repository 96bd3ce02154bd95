r"""Disturbances that come far through a loop with lines of two slopes, found in floating point.

``phi_i = a sigma`` below 0 and ``b sigma`` above.  Along the pieces that a signal goes through the loop is linear,
``z = T w``; ``T' z`` over its length is the next signal (power iteration; Tierno, Murray, Doyle, Gregory 1997).  In
continuous time ``w`` is constant on short steps, and so is ``mu`` in the search.  A checker decides what the rounded
signal does.

For a certificate they are followed to many digits in continuous time. A step ends where a ``sigma_i`` changes its side,
at a time with so many digits that what is then on the wrong side stays small, however fast solutions could part.
Nothing rests on what is found here: checkers follow the signal again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from flint import arb, arb_mat, ctx

from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import NDArray, Reals, in_doubles, linalg, np
from lure.plants.multivariable import MultivariablePlant
from lure.record import described, quantity

LENGTHS, _STARTS, _TURNS, _SEED, _BITS = (40, 100), 60, 60, 20261122, 16
_PATIENCE, _GAINED = 5, 1e-4  # turns, and by how much more is to come through after these
MOST_CHANNELS = 5
_MOVING_STARTS, _MOVING_TURNS, _MOVING_SEED, _MOVING_PATIENCE, _MOVING_GAINED = 8, 40, 20261123, 5, 1e-3
_STEPS, _FORGOTTEN, _FIRST_STARTS, _TERMS, _GRID, _MOST_BITS = (100, 400), 16.0, 8, 18, 8, 8000
_NEWTON, _SPARE = 12, 70


class Loop:
    """The matrices of a loop whose functions see no later one at once, taken apart.

    Parameters
    ----------
    plant : sequence of ndarray
        ``A``, ``B``, ``C`` and ``D``; among the functions ``D`` is 0 on and above the diagonal.
    own : sequence of int
        The channels from ``z`` to ``w``; the others are functions, in order.
    """

    def __init__(self, plant: Sequence[Reals], own: Sequence[int]) -> None:
        A, B, C, D = plant
        functions = [i for i in range(len(D)) if i not in own]
        self.A, self.Bf, self.Bw, self.Cf, self.Cz = A, B[:, functions], B[:, [*own]], C[functions], C[[*own]]
        self.Dff, self.Dfw = D[np.ix_(functions, functions)], D[np.ix_(functions, own)]
        self.Dzf, self.Dzw = D[np.ix_(own, functions)], D[np.ix_(own, own)]
        self.layered = bool(self.Dff.any())

    def held(self, step: float) -> Loop:
        """The loop in discrete time whose inputs are constant on steps."""
        n, found = len(self.A), object.__new__(Loop)
        found.__dict__.update(self.__dict__)
        inputs = np.hstack([self.Bf, self.Bw])
        width = inputs.shape[1]
        whole = linalg.expm(np.block([[self.A, inputs], [np.zeros((width, n + width))]]) * step)
        found.A, found.Bf, found.Bw = (
            whole[:n, :n],
            whole[:n, n : n + self.Bf.shape[1]],
            whole[:n, n + self.Bf.shape[1] :],
        )
        return found

    def outward(self, sigma: Reals, slopes: Reals) -> tuple[Reals, Reals]:
        """The gains on the side where ``sigma`` is, and ``mu``; ``sigma`` is given without what functions add to it."""
        if not self.layered:
            gains = np.where(sigma > 0, slopes[:, 1], slopes[:, 0])
            return gains, -gains * sigma
        gains, mu = np.empty_like(sigma), np.zeros_like(sigma)
        for i in range(sigma.shape[1]):
            own = sigma[:, i] + mu[:, :i] @ self.Dff[i, :i]
            gains[:, i] = np.where(own > 0, slopes[i, 1], slopes[i, 0])
            mu[:, i] = -gains[:, i] * own
        return gains, mu

    def inward(self, toward: Reals, gains: Reals) -> Reals:
        """The adjoint of :meth:`outward`: from what ``mu`` does to what ``sigma`` does."""
        into = -gains * toward
        if self.layered:
            for i in reversed(range(gains.shape[1])):
                into[:, i] = -gains[:, i] * (toward[:, i] + into[:, i + 1 :] @ self.Dff[i + 1 :, i])
        return into


def signals(loop: Loop, slopes: Reals, length: int, starts: int = _STARTS) -> tuple[float, Reals]:
    """The gain found, and a signal (length, inputs) that has it, its largest entry about 1.

    Parameters
    ----------
    loop : Loop
        In discrete time.
    slopes : ndarray
        (functions, 2) below and above 0.
    length : int
        Samples.
    starts : int
        How many signals it begins from.
    """
    w = np.random.default_rng(_SEED).normal(size=(starts, length, loop.Bw.shape[1]))
    best, found, before = 0.0, w[0], list[float]()
    for _ in range(_TURNS):
        checkpoint()
        before.append(best)
        if len(before) > 2 * _PATIENCE and best < before[-_PATIENCE] * (1 + _GAINED):
            break
        x, gains, outputs = np.zeros((starts, len(loop.A))), list[Reals](), list[Reals]()
        for t in range(length):
            now, mu = loop.outward(x @ loop.Cf.T + w[:, t] @ loop.Dfw.T, slopes)
            gains.append(now)
            outputs.append(x @ loop.Cz.T + mu @ loop.Dzf.T + w[:, t] @ loop.Dzw.T)
            x = x @ loop.A.T + mu @ loop.Bf.T + w[:, t] @ loop.Bw.T
        reached = np.sqrt(sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300))
        if reached.max() > best:
            best, found = float(reached.max()), w[reached.argmax()].copy()
        p, w = np.zeros((starts, len(loop.A))), np.zeros_like(w)
        for t in reversed(range(length)):
            into = loop.inward(p @ loop.Bf + outputs[t] @ loop.Dzf, gains[t])
            w[:, t] = p @ loop.Bw + outputs[t] @ loop.Dzw + into @ loop.Dfw
            p = p @ loop.A + outputs[t] @ loop.Cz + into @ loop.Cf
        w /= np.maximum(np.abs(w).max((1, 2), keepdims=True), 1e-300)
    return best, found / (np.abs(found).max() or 1.0)


def rounded(signal: Reals) -> list[list[Fraction]]:
    """With few binary digits.

    ``signal``: (length, inputs).
    """
    return [[Fraction(round(float(v) * 2**_BITS), 2**_BITS) for v in row] for row in signal]


def best_signals(loop: Loop, slopes: Reals) -> Iterator[tuple[float, list[list[Fraction]]]]:
    """Signals of several lengths, the farthest first; parameters as for :func:`signals`.

    ``loop``, ``slopes``: as there.
    """
    found = sorted((signals(loop, slopes, length) for length in LENGTHS), key=lambda one: -one[0])
    yield from ((gain, rounded(signal)) for gain, signal in found)


# Disturbances with gains that go with them: what comes far through a loop whose gains may jump at any time.
#
# Along gains ``g_i(t)`` at an end of their classes the loop is linear, ``z = T w``; ``T' z`` is the next signal, and
# each gain goes to the end at which more comes through, by the sign of ``-sigma_i (T' z)_i``.  Nothing rests on what is
# found here: a checker follows signal and gains again.


@described(frozen=True)
class Moving:
    """A signal and the gains beside it."""

    gain: float = quantity("What comes through over what enters")
    inputs: list[list[Fraction]] = quantity("``w`` on each step")
    ends: list[list[int]] = quantity("Of each function in each step which end of its class: 0 or 1")


class Modes:
    """The loop with each choice of ends, in steps.

    Parameters
    ----------
    loop : Loop
        The loop.
    ends : ndarray
        (functions, 2).
    step : float or None
        Length of a step on which ``w`` and the gains are constant; None in discrete time.
    """

    def __init__(self, loop: Loop, ends: Reals, step: float | None) -> None:
        sides, m = list[list[Any]](), len(ends)
        p, n = loop.Bw.shape[1], len(loop.A)
        for chosen in product((0, 1), repeat=m):
            K = np.diag(ends[range(m), chosen])
            inner = np.linalg.solve(np.eye(m) + loop.Dff @ K, np.hstack([loop.Cf, loop.Dfw]))
            A, B = loop.A - loop.Bf @ K @ inner[:, :n], loop.Bw - loop.Bf @ K @ inner[:, n:]
            z = np.hstack([loop.Cz, loop.Dzw]) - loop.Dzf @ K @ inner
            W = z.T @ z
            if step is not None:
                G = np.vstack([np.hstack([A, B]), np.zeros((p, n + p))])
                wide = linalg.expm(np.block([[-G.T, W], [np.zeros_like(G), G]]) * step)
                E, W = wide[n + p :, n + p :], wide[n + p :, n + p :].T @ wide[: n + p, n + p :]
                A, B = E[:n, :n], E[:n, n:]
            sides.append([A, B, z, inner, W])
        self.A, self.B, self.z, self.sigma, self.W = (np.stack(side) for side in zip(*sides, strict=True))
        self.places = 2 ** np.arange(m)[::-1]
        self.Bf, self.Dzf = (loop.Bf if step is None else step * loop.Bf), loop.Dzf

    def through(self, w: Reals, modes: NDArray[np.int64]) -> float:
        """The energy that one signal has in ``z``."""
        x, energy = np.zeros(self.A.shape[1]), 0.0
        for v, k in zip(w, modes, strict=True):
            X = np.concatenate([x, v])
            energy, x = energy + float(X @ self.W[k] @ X), self.A[k] @ x + self.B[k] @ v
        return energy


def moving(loop: Loop, ends: Sequence[tuple[Fraction, Fraction]], length: int, step: Fraction | None) -> Moving | None:
    """The signal with most through it, its largest entry about 1; None where nothing comes through.

    Parameters
    ----------
    loop : Loop
        The loop.
    ends : sequence of pairs of Fraction
        Least and greatest gain of each function.
    length : int
        How many steps.
    step : Fraction or None
        How long each is; None in discrete time.
    """
    own = Modes(loop, in_doubles(ends), None if step is None else float(step))
    rng, n = np.random.default_rng(_MOVING_SEED), len(loop.A)
    w = rng.normal(size=(_MOVING_STARTS, length, loop.Bw.shape[1]))
    modes = rng.integers(0, len(own.A), size=(_MOVING_STARTS, length))
    best, found, before = 0.0, (w[0], modes[0]), list[float]()
    for _ in range(_MOVING_TURNS):
        checkpoint()
        before.append(best)
        if len(before) > 2 * _MOVING_PATIENCE and best < before[-_MOVING_PATIENCE] * (1 + _MOVING_GAINED):
            break
        x, outputs, seen = np.zeros((_MOVING_STARTS, n)), list[Reals](), list[Reals]()
        for t in range(length):
            X, k = np.hstack([x, w[:, t]]), modes[:, t]
            outputs.append(np.einsum("sij,sj->si", own.z[k], X))
            seen.append(np.einsum("sij,sj->si", own.sigma[k], X))
            x = np.einsum("sij,sj->si", own.A[k], x) + np.einsum("sij,sj->si", own.B[k], w[:, t])
        reached = sum((z**2).sum(1) for z in outputs) / np.maximum((w**2).sum((1, 2)), 1e-300)
        top = int(np.argmax(np.where(np.isfinite(reached), reached, 0.0)))
        if reached[top] ** 0.5 > best:
            best, found = float(reached[top]) ** 0.5, (w[top].copy(), modes[top].copy())
        p, w, modes = np.zeros((_MOVING_STARTS, n)), np.zeros_like(w), modes.copy()
        for t in reversed(range(length)):
            toward = p @ own.Bf + outputs[t] @ own.Dzf
            modes[:, t] = (-toward * seen[t] > 0) @ own.places
            k = modes[:, t]
            whole = np.einsum("sj,sji->si", outputs[t], own.z[k])
            w[:, t] = np.einsum("sj,sji->si", p, own.B[k]) + whole[:, n:]
            p = np.einsum("sj,sji->si", p, own.A[k]) + whole[:, :n]
        w /= np.maximum(np.abs(w).max((1, 2), keepdims=True), 1e-300)
    signal, chosen = found
    inputs = rounded(signal / (np.abs(signal).max() or 1.0))
    exact = in_doubles(inputs)
    entered = float((exact**2).sum()) * (1.0 if step is None else float(step))
    if not entered > 0:
        return None
    bits = [[int(k) // int(place) % 2 for place in own.places] for k in chosen]
    return Moving((own.through(exact, chosen) / entered) ** 0.5, inputs, bits)


@described(frozen=True)
class Followed:
    """A signal in steps."""

    gain: float = quantity("What comes through over what enters")
    inputs: list[list[Fraction]] = quantity("``w`` on each step")
    times: list[Fraction] = quantity("How long each takes")
    sides: list[list[int]] = quantity("Of each function whether ``sigma_i > 0``")
    scale: Fraction = quantity("Of ``w`` beside the state, for balls")
    bits: int = quantity("For balls")

    @property
    def proof(self) -> dict[str, Any]:
        """Its keys in a certificate."""
        return {
            "inputs": [list(map(str, row)) for row in self.inputs],
            "times": list(map(str, self.times)),
            "sides": self.sides,
            "scale": str(self.scale),
            "bits": self.bits,
        }


def followed(H: MultivariablePlant, slopes: Sequence[tuple[Fraction, Fraction]], own: Sequence[int]) -> Followed | None:
    """The best signal found, in steps; None where the loop is too fast for its memory, or moves nothing.

    Parameters
    ----------
    H : MultivariablePlant
        In continuous time, with the channels from ``z`` to ``w``.
    slopes : sequence of pairs of Fraction
        Below and above 0, of each function.
    own : sequence of int
        The channels from ``z`` to ``w``.
    """
    loop, lines = Loop(H.doubles(), own), in_doubles(slopes)
    cut = Cut.of(loop, lines)
    if cut is None:
        return None
    gain, signal = signals(loop.held(float(cut.step)), lines, cut.steps, _FIRST_STARTS)
    if not gain > 0:
        return None
    with working_precision(2 * cut.digits + _SPARE):
        return _Walk(H, slopes, own, cut.digits).along(rounded(signal), cut.step, cut.scale)


class Cut(NamedTuple):
    """How time is cut into steps for a checker.

    Attributes
    ----------
    step : Fraction
        The length of each.
    steps : int
        How many.
    digits : int
        Binary digits by which solutions that part as fast as they may are apart at the end, and some more.
    scale : Fraction
        Of ``w`` beside the state.
    """

    step: Fraction
    steps: int
    digits: int
    scale: Fraction

    @classmethod
    def of(cls, loop: Loop, lines: Reals, most: int = _STEPS[1]) -> Cut | None:
        """Steps for a loop with such slopes; None where it is too fast for its memory.

        ``lines``: (functions, 2).
        """
        fast, wide = _speed(loop, lines)
        if not 0 < fast < 1e9:
            return None
        step = Fraction(2) ** math.floor(math.log2(0.49 / fast))
        count = int(np.clip(_FORGOTTEN / (_slowest(loop, lines) * float(step)), _STEPS[0], most))
        digits = int(1.45 * fast * count * float(step)) + _SPARE
        scale = Fraction(2) ** max(0, math.ceil(math.log2(4 * wide / fast))) if wide > 0 else Fraction(1)
        return None if 2 * digits + _SPARE > _MOST_BITS else cls(step, count, digits, scale)


def _speed(loop: Loop, lines: Reals) -> tuple[float, float]:
    """The largest growth rate in the maximum norm, as a checker bounds it, and the size of what ``w`` does to ``x``."""
    steep, near, through = np.abs(lines).max(1), list[float](), list[float]()
    for i, most in enumerate(steep):
        before = np.abs(loop.Dff[i, :i])
        near.append(most * (np.abs(loop.Cf[i]).sum() + before @ np.array(near)))
        through.append(most * (np.abs(loop.Dfw[i]).sum() + before @ np.array(through)))
    sizes = np.abs(loop.Bf)
    rates = np.abs(loop.A).sum(1) + sizes @ np.array(near)
    return float(rates.max()), float((np.abs(loop.Bw).sum(1) + sizes @ np.array(through)).max())


def _slowest(loop: Loop, lines: Reals) -> float:
    """The least decay rate with all functions on one side."""
    found = list[float]()
    for k in (0, 1):
        G = np.diag(lines[:, k])
        closed = loop.A - loop.Bf @ G @ np.linalg.solve(np.eye(len(G)) + loop.Dff @ G, loop.Cf)
        found.append(float(-linalg.eigvals(closed).real.max()))
    return max(min(found), 1e-3 * max(float(np.abs(loop.A).max()), 1e-9))


class _Walk:
    """Following a loop at the working precision, from side to side."""

    def __init__(
        self, H: MultivariablePlant, slopes: Sequence[tuple[Fraction, Fraction]], own: Sequence[int], digits: int
    ) -> None:
        self.n, self.own, self.slopes, self.digits = H.order, list(own), slopes, digits
        self.functions = [i for i in range(len(H.D)) if i not in own]
        self.A, self.B, self.C, self.D = (
            arb_mat([[ball(v) for v in row] for row in side]) for side in (H.A, H.B, H.C, H.D)
        )
        self.known = dict[tuple[int, ...], tuple[arb_mat, arb_mat, Reals, Reals]]()
        self.flows = dict[tuple[tuple[int, ...], Fraction], arb_mat]()

    def mode(self, sides: tuple[int, ...]) -> tuple[arb_mat, arb_mat, Reals, Reals]:
        """``G`` of ``(x, w)``, the rows of functions, then those of ``z``, both also in doubles."""
        if sides not in self.known:
            n, p, m = self.n, len(self.own), self.D.nrows()
            held = arb_mat(m, n + p)
            for k, j in enumerate(self.own):
                held[j, n + k] = arb(1)
            wide = arb_mat([[arb(i == k) for k in range(n + p)] for i in range(n)])
            for i, pair, side in zip(self.functions, self.slopes, sides, strict=True):
                seen = self.C * wide + self.D * held
                for k in range(n + p):
                    held[i, k] = -ball(pair[side]) * seen[i, k]
            outputs = (self.C * wide + self.D * held).tolist()
            G = arb_mat((self.A * wide + self.B * held).tolist() + arb_mat(p, n + p).tolist())
            rows = arb_mat([outputs[i] for i in [*self.functions, *self.own]])
            self.known[sides] = G, rows, _doubles(G), _doubles(rows)
        return self.known[sides]

    def after(self, sides: tuple[int, ...], t: Fraction, X: arb_mat, *, keep: bool) -> arb_mat:
        """``exp(G t) X``, without its error."""
        E = self.flows.get((sides, t))
        if E is None:
            E = (self.mode(sides)[0] * ball(t)).exp().mid()
            if keep:
                self.flows[sides, t] = E
        return (E * X).mid()

    def along(self, signal: list[list[Fraction]], step: Fraction, scale: Fraction) -> Followed:
        """The signal, cut where a side changes."""
        x, sides, energy, size = [arb(0)] * self.n, (1,) * len(self.functions), 0.0, 0.0
        inputs, times, taken = list[list[Fraction]](), list[Fraction](), list[list[int]]()
        first = Fraction(1, 2 ** (self.digits // 16))
        for k, w in enumerate(signal):
            checkpoint()
            left, begun = step, list[Fraction]()
            while not k and first * 16 ** len(begun) < step / 16:
                begun.append(first * 16 ** len(begun))
            sides = self.sides(sides, x, w, min(first, step / 2))
            while left > 0:
                X = arb_mat([[v] for v in [*x, *map(ball, w)]])
                planned = begun.pop(0) if begun else left
                t, crossing = self.until(sides, planned, X)
                energy += self.energy(sides, float(t), X)
                size += float(t) * sum(float(v) ** 2 for v in w)
                x = [v[0] for v in self.after(sides, t, X, keep=t == step).tolist()[: self.n]]
                inputs, times, taken = [*inputs, w], [*times, t], [*taken, list(sides)]
                left -= t
                sides = tuple(1 - s if i == crossing else s for i, s in enumerate(sides))
                if len(times) > 2 * len(signal) + 200:
                    break
        return Followed(math.sqrt(energy / size) if size else 0.0, inputs, times, taken, scale, ctx.prec)

    def sides(self, before: tuple[int, ...], x: list[arb], w: list[Fraction], soon: Fraction) -> tuple[int, ...]:
        """Where each ``sigma_i`` is, or is going if it is near 0."""
        X = arb_mat([[v] for v in [*x, *map(ball, w)]])
        least, found = arb(2) ** (-(self.digits // 2)), before
        for _ in range(len(before) + 1):  # those before may move those after
            rows = self.mode(found)[1]
            now, later = rows * X, rows * self.after(found, soon, X, keep=False)
            seen = [now[i, 0] if abs(now[i, 0]) > least else later[i, 0] for i in range(len(before))]
            found = tuple(int(v > 0) if v != 0 else s for v, s in zip(seen, found, strict=True))
        return found

    def until(self, sides: tuple[int, ...], t: Fraction, X: arb_mat) -> tuple[Fraction, int | None]:
        """How long all stay on their sides, up to ``t``, and which function does not."""
        _, _, G, doubles = self.mode(sides)
        c, at, m = self.series(doubles, G * float(t), X), np.linspace(0, 1, _GRID + 1), len(sides)
        wrong = (np.polynomial.polynomial.polyval(at, c[:, :m]) > 0) != np.array(sides)[:, None]
        wrong[:, 0] = False
        if not wrong.any():
            return t, None
        found, which = t, None
        for i in np.flatnonzero(wrong.any(axis=1)):
            high = float(at[wrong[i].argmax()])
            low = high - 1 / _GRID
            for _ in range(50):
                middle = (low + high) / 2
                value = float(np.polynomial.polynomial.polyval(middle, c[:, i]))
                low, high = (middle, high) if (value > 0) == bool(sides[i]) else (low, middle)
            one = self.refined(sides, int(i), Fraction(high) * t, X)
            if 0 < one < found:
                found, which = one, int(i)
        return found, which

    def refined(self, sides: tuple[int, ...], i: int, t: Fraction, X: arb_mat) -> Fraction:
        """The time near ``t`` at which ``sigma_i = 0``, by Newton's method, with so many digits."""
        G, rows, _, _ = self.mode(sides)
        row, unit = arb_mat([rows.tolist()[i]]), 2 ** (self.digits + _SPARE // 2)
        for _ in range(_NEWTON):
            now = self.after(sides, t, X, keep=False)
            value, slope = (row * now)[0, 0], (row * G * now)[0, 0]
            if slope == 0:
                break
            move = (value / slope * unit).mid()
            move = Fraction(int(move.floor().unique_fmpz() or 0), unit)
            t = Fraction(round((t - move) * unit), unit)
            if abs(move) <= Fraction(4, unit):
                break
        return t

    def series(self, rows: Reals, step: Reals, X: arb_mat) -> Reals:
        """The coefficients of rows of ``exp(G t q) X`` in ``q``, (terms, rows)."""
        x, found = _doubles(X)[:, 0], list[Reals]()
        for k in range(1, _TERMS + 1):
            found.append(rows @ x)
            x = step @ x / k
        return np.array(found)

    def energy(self, sides: tuple[int, ...], t: float, X: arb_mat) -> float:
        """``int |z|^2`` over a step."""
        _, _, G, rows = self.mode(sides)
        c = self.series(rows[len(sides) :], G * t, X)
        powers = np.array([[1 / (j + k + 1) for j in range(_TERMS)] for k in range(_TERMS)])
        return float(t * np.einsum("ji,jk,ki->", c, powers, c))


def _doubles(rows: arb_mat) -> Reals:
    return np.array([[float(v.mid()) for v in row] for row in rows.tolist()], dtype=float)

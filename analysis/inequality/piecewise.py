r"""Multipliers that are functions of the frequency where members are linear and time-invariant, in floating point.

After the shift by the lower bounds, for a delay by the gain 1, sought are numbers ``lambda``, ``theta`` of the other
channels, the same at all frequencies, and ``x(omega)``, ``y(omega)`` with ``F = Y + Y^* > 0``: row ``i`` of ``Y`` is

.. math:: \lambda (e_i + w H_i) + i \omega \theta H_i, \qquad (x + i y)(e_i + w H_i), \qquad
    (y e^{-i \omega h/2} - x) H_i + x e_i/2

for functions, constant gains and delays up to ``h``; an operator of norm up to ``r`` adds ``x (1 - r^2 H_b^* H_b)``.
Semidefinite programmes over some frequencies find the numbers and whether there are functions; these are then made
constant on pieces, each tested as the checker will test it.  Nothing here is believed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from lure.analysis.certificates.pieces import Axis, on_piece
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import LARGEST, Proposal
from lure.analysis.numerics.semidefinite import hermitian_programme, hermitian_rows
from lure.arrays import NDArray, np
from lure.record import described, quantity

_GRID, _BESIDE, _INSIDE, _BETWEEN, _CUTS, _ZOOMS, _DIPS, _DOUBLINGS, _FEW = 60, 30.0, 5, 8, 6, 4, 4, 12, 3
_MOST_PIECES, _LONG = 1000, 1000
_LARGEST, _LEAST, _MARGIN, _CLOSE = 1e3, 1e-9, 1e-7, 1e-4
_EASY, _STEP, _FINE = 1e-5, 3e-4, 400
_AT_REST, _NEAR = 1e-12, 1e-3  # relative: poles at 0, and the first frequency then
_SHARP = 2e-6  # in place of these and of _CLOSE where no function is to be made constant on pieces
_PAID = 1 + 1e-6  # so that rounding leaves enough
_DEEP, _DEEPEST, _ROUNDS, _AGAIN, _DIGITS = 20, 26, 12, 3, 8
FULL_TURN = Fraction(6283185, 10**6)  # below 2 pi
HALF_TURN = Fraction(3141593, 10**6)  # above pi


class Channel(NamedTuple):
    """A channel after the shift: one of the :data:`KINDS`, its width (of operators the norm, of delays the bound)."""

    kind: str
    width: Fraction
    free: bool = False  # of a function: Popov's term, of a delay: x of either sign, of a slow one: y
    rate: Fraction | None = Fraction(0)  # of a slow delay; None: it changes at any rate, and x is 0
    low: Fraction = Fraction(0)  # of a function or a gain that is not shifted: beside known dead times


class _Basis(NamedTuple):
    """Hermitian matrices at some frequencies: (numbers, k, m, m) of the constants and of the functions of each."""

    shared: NDArray[np.complex128]
    local: NDArray[np.complex128]


@described()
class Piecewise:
    """The inequality of one plant, and of channels whose widths are given."""

    A: NDArray[np.float64] = quantity("The loop after the shift, with the other three; of operators the shift is 0")
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    channels: Sequence[Channel] = quantity("In order")
    blocks: Sequence[Sequence[int]] = quantity(
        "The channels of each operator, and of each function of several channels"
    )
    discrete: bool = quantity("Whether in discrete time")
    late: Sequence[tuple[float, NDArray[np.float64]]] = quantity(
        "Dead times [s], and what shows the states of that time to ``sigma``, (p, n)", default=()
    )
    gains: Sequence[float] | None = quantity("Beside dead times what the loop is shifted by", default=None)
    inner: Sequence[NDArray[np.float64]] = quantity(
        "(n, n) for each dead time, what shows the states of that time to themselves; or nothing", default=()
    )
    rates: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]] = quantity(
        "(p, n) and (n, n) for each, what shows ``x'`` of that time to ``sigma`` and to ``x'``; or nothing", default=()
    )
    pace: float = quantity("A rate ``a``: Popov's terms need ``lambda >= |theta a|/w``", default=0.0)
    zeros: int = quantity("Beside dead times how many poles at 0 there are after the shift", default=0)
    ties: Sequence[tuple[int, int, Fraction]] = quantity(
        "Channels ``i``, ``j`` and a number ``q``: ``lambda_j = q lambda_i``", default=()
    )

    def __post_init__(self) -> None:
        kinds = [one.kind for one in self.channels]
        self.shared = [(block, 0) for block in self.blocks if kinds[block[0]] in ("operator", "function")]
        steady = [
            one.kind == "function" or (one.kind == "slow delay" and one.rate is not None) for one in self.channels
        ]
        joint = {i for block, _ in self.shared for i in block}
        self.shared += [((i,), 0) for i, fits in enumerate(steady) if fits and i not in joint]
        self.shared += [((i,), 1) for i, one in enumerate(self.channels) if one.kind == "slow delay" and one.free]
        self.weights = len(self.shared)
        self.shared += [((i,), 1) for i, one in enumerate(self.channels) if one.kind == "function" and one.free]
        self.local = [(block, 0) for block in self.blocks if kinds[block[0]] == "scaled operator"]
        self.local += [((i,), k) for i, kind in enumerate(kinds) if kind in ("gain", "delay") for k in (0, 1)]
        size = np.abs(np.linalg.eigvals(self.A))
        still = size < _AT_REST * max([size.max(), *(1 / delay for delay, _ in self.late)])
        if still.any() and self.late:
            size = np.array([*size[~still], 1 / self.late[-1][0]])
        self.points, self.slowly = np.linspace(0, math.pi, _GRID), dict[int, list[Fraction]]()
        self.slow = 1.0
        if not self.discrete:
            bounds = [1 / float(one.width) for one in self.channels if "delay" in one.kind]
            ends = min(size.min(), *bounds, math.inf) / _BESIDE, max(size.max(), *bounds, 0.0) * _BESIDE
            self.points = np.concatenate([[0.0], np.geomspace(*ends, _GRID), [np.inf]])
            self.slow = float(size.min())
        if self.late:  # there is no limit at infinity
            turns = np.linspace(0, max(ends[1] / _BESIDE, 1 / self.late[0][0]) * 8, _GRID)
            self.points = np.union1d(self.points[:-1], turns)[min(self.zeros, 1) :]
        self._cross([i for i, kind in enumerate(kinds) if kind == "delay"])

    def _cross(self, delays: Sequence[int]) -> None:
        """Add frequencies where ``|h| = 1`` for the loop around one delay: a root of it can only be there."""
        finite = self.points[np.isfinite(self.points) & (self.points > 0)]
        if not delays:
            return
        omega = np.linspace(0, math.pi, _FINE) if self.discrete else np.geomspace(finite[0], finite[-1], _FINE)
        gain = 1 - 2 * np.diagonal(self._response(omega)[0], axis1=1, axis2=2).real[:, delays]
        for i, values in zip(delays, gain.T, strict=True):
            at = np.flatnonzero(values[:-1] * values[1:] < 0)
            low, high, sign = omega[at], omega[at + 1], np.sign(values[at])
            for _ in range(40 if len(at) else 0):
                middle = (low + high) / 2
                same = sign * (1 - 2 * self._response(middle)[0][:, i, i].real) > 0
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            self.points = np.union1d(self.points, low)

    def _response(self, omega: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """``H``, and ``s H`` where it is bounded, at some frequencies; infinity may be among them."""
        far = np.isinf(omega)
        s = np.exp(1j * omega) if self.discrete else 1j * np.where(far, 0.0, omega)
        if self.gains is not None:  # of the plant alone 0 may be a pole
            omega = np.maximum(omega, _AT_REST / self.late[-1][0])
            s = 1j * omega
        waits = [np.exp(-1j * delay * omega)[:, None, None] for delay, _ in self.late]
        A: NDArray[Any] = self.A
        for wait, own in zip(waits, self.inner, strict=False):
            A = A + wait * own
        for wait, (_, own) in zip(waits, self.rates, strict=False):
            A = A + s[:, None, None] * wait * own
        try:
            states = np.linalg.solve(s[:, None, None] * np.eye(len(self.A)) - A, self.B.astype(complex))
        except np.linalg.LinAlgError:  # at a pole of the plant alone, where the loop has none
            if self.gains is None:
                raise
            return self._response(omega * (1 + _AT_REST))
        states[far] = 0
        H, turned = self.C @ states + self.D, self.C @ (A @ states + self.B)
        for wait, (_, outputs) in zip(waits, self.late, strict=True):
            H, turned = H + wait * (outputs @ states), turned + wait * (outputs @ (A @ states + self.B))
        for wait, (outputs, _) in zip(waits, self.rates, strict=False):  # Popov's terms are not for rows of these
            H = H + wait * (outputs @ (A @ states + self.B))
        if self.gains is not None:
            back = np.linalg.inv(np.eye(len(self.D)) + np.array(self.gains)[:, None] * H)
            H, turned = H @ back, turned @ back
        return np.asarray(H), np.asarray(turned)

    def basis(self, omega: NDArray[np.float64]) -> _Basis:
        """The matrices whose combinations ``F`` is; ``omega``: (k,) frequencies."""
        H, turned = self._response(omega)
        sides = []
        for which in (self.shared, self.local):
            found = np.zeros((len(which), len(omega), len(self.D), len(self.D)), dtype=complex)
            for k, (block, part) in enumerate(which):
                one = self.channels[block[0]]
                w = float(one.width)
                if "operator" in one.kind:
                    own = H[:, block]
                    found[k] = -(w**2) * own.conj().swapaxes(1, 2) @ own
                    found[k][:, block, block] += 1
                    continue
                for i in block:
                    row = np.zeros((len(omega), len(self.D)), dtype=complex)
                    if one.kind == "slow delay":
                        share = float(one.rate / (1 - one.rate)) if one.rate is not None and part == 0 else w**2
                        side = (H if part == 0 else turned)[:, i]
                        found[k] = -share / 2 * side.conj()[:, :, None] * side[:, None, :]
                        found[k][:, i] -= H[:, i] * (part == 0)
                        found[k][:, i, i] += 0.5
                        continue
                    if one.kind == "delay" and part == 0:
                        row = -H[:, i]
                        row[:, i] += 0.5
                    elif one.kind == "delay":
                        inside = omega * w <= float(FULL_TURN)
                        row[inside] = np.exp(-0.5j * omega[inside] * w)[:, None] * H[inside, i]
                    elif one.kind == "function" and part == 1:
                        row = turned[:, i] / self.slow
                    else:
                        low = 0.0 if part else float(one.low)
                        row = (w + 2 * low) * H[:, i]
                        row[:, i] += 1
                        row = row * (1j if part else 1)
                        found[k] += low * (w + low) * H[:, i].conj()[:, :, None] * H[:, i][:, None, :]
                    found[k][:, i] += row
            sides.append(found + found.conj().swapaxes(2, 3))
        return _Basis(*sides)

    def _signed(self) -> NDArray[np.bool_]:
        """Which functions may be below 0."""
        kinds = [(self.channels[block[0]], part) for block, part in self.local]
        return np.array([(one.kind == "gain" and part == 1) or (one.free and part == 0) for one, part in kinds])

    def constants(self) -> tuple[float, NDArray[np.float64]] | None:
        """The largest margin at the points, and the numbers that give it; None if the programme has no solution.

        Nor is there one where numbers leave the doubles.
        """
        try:
            with np.errstate(over="raise", invalid="raise"):
                basis = self.basis(self.points)
        except FloatingPointError:
            return None
        ns, nl, k, m = len(self.shared), len(self.local), len(self.points), len(self.D)
        size = ns + k * nl + 1
        columns = np.zeros((k, m * (2 * m + 1), size))
        columns[:, :, :ns] = np.moveaxis(hermitian_rows(basis.shared), 0, -1)
        own = np.moveaxis(hermitian_rows(basis.local), 0, -1)
        for j in range(k):
            columns[j, :, ns + j * nl : ns + (j + 1) * nl] = own[j]
        columns[:, :, -1] = -hermitian_rows(np.eye(m, dtype=complex)[None])
        equal = np.zeros((min(self.weights, 1), size))
        equal[:, : self.weights] = 1
        turns = 0.0 if self.zeros else -_LARGEST
        least = np.concatenate([np.zeros(self.weights), np.full(ns - self.weights, turns)])
        below = np.where(np.tile(self._signed(), k), -self._most, 0.0) if nl else np.zeros(0)
        eye = np.eye(size)[:-1]
        rows, limits = (
            np.vstack([-eye, eye]),
            np.concatenate([-least, -below, np.full(ns, _LARGEST), np.full(k * nl, self._most)]),
        )
        for k, (block, part) in enumerate(self.shared if self.pace else ()):
            if part and self.channels[block[0]].kind == "function":
                cost = abs(self.pace) / (self.slow * float(self.channels[block[0]].width)) * _PAID
                paid = np.zeros((2, size))
                paid[:, self.shared.index((block, 0))], paid[:, k] = -1, (cost, -cost)
                rows, limits = np.vstack([rows, paid]), np.append(limits, [0.0, 0.0])
        ends = np.ones(len(equal))
        for i, j, ratio in self.ties:
            tied = np.zeros((1, size))
            tied[0, self.shared.index(((i,), 0))], tied[0, self.shared.index(((j,), 0))] = float(ratio), -1
            equal, ends = np.vstack([equal, tied]), np.append(ends, 0.0)
        found = hermitian_programme(np.eye(size)[-1], (equal, ends), (rows, limits), [columns])
        return None if found is None else (float(found[0][-1]), found[0][:ns])

    @property
    def _most(self) -> float:
        return _LARGEST if self.weights else 1.0

    def functions(
        self, numbers: NDArray[np.float64], omega: NDArray[np.float64]
    ) -> tuple[float, NDArray[np.float64]] | None:
        """The largest margin that one value of the functions has at some frequencies, and the value.

        ``numbers``: the constants.
        """
        basis, nl, m = self.basis(omega), len(self.local), len(self.D)
        fixed = np.einsum("s,skij->kij", numbers, basis.shared)
        if not nl:
            return float(np.linalg.eigvalsh(fixed).min()), np.zeros(0)
        columns = hermitian_rows(np.stack([*basis.local, fixed], axis=-3)).swapaxes(1, 2)
        margin = -np.broadcast_to(hermitian_rows(np.eye(m, dtype=complex)), columns[:, :, 0].shape)
        columns = np.concatenate([columns, margin[:, :, None]], axis=2)
        equal = np.zeros((1, nl + 2))
        equal[0, nl] = 1
        eye = np.eye(nl, nl + 2)
        most = np.concatenate([np.where(self._signed(), self._most, 0.0), np.full(nl, self._most)])
        sides = np.vstack([-eye, eye]), most
        found = hermitian_programme(np.eye(nl + 2)[-1], (equal, np.ones(1)), sides, [columns])
        if found is None:
            return None
        values = np.clip(found[0][:nl], -most[:nl], most[nl:])
        return float(self._margins(numbers, values, omega).min()), values

    def _margins(
        self, numbers: NDArray[np.float64], values: NDArray[np.float64], omega: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The least eigenvalues of ``F`` with one value of the functions at some frequencies."""
        basis = self.basis(omega)
        F = np.einsum("s,skij->kij", numbers, basis.shared) + np.einsum("s,skij->kij", values, basis.local)
        return np.asarray(np.linalg.eigvalsh(F)[:, 0])

    def _lowest(
        self, numbers: NDArray[np.float64], values: NDArray[np.float64], omega: NDArray[np.float64]
    ) -> float | None:
        """A frequency where ``F > 0`` fails, looked for closely about the least value; None if there is none."""
        for _ in range(_ZOOMS):
            least = self._margins(numbers, values, omega)
            if least.min() <= 0:
                return float(omega[least.argmin()])
            padded = np.concatenate([[np.inf], least, [np.inf]])
            at = np.flatnonzero((least <= padded[:-2]) & (least <= padded[2:]))
            at = at[np.argsort(least[at])[:_DIPS]]
            low, high = omega[np.maximum(at - 1, 0)], omega[np.minimum(at + 1, len(omega) - 1)]
            near = np.isfinite(high)
            if not near.any():
                break
            omega = np.unique(np.linspace(low[near], high[near], 9))
        return None

    def _worst(self, numbers: NDArray[np.float64], omega: float) -> float:
        """About the frequency near one at which no functions serve where they serve least."""
        at = int(np.searchsorted(self.points, omega))
        low, high = self.points[max(at - 2, 0)], self.points[min(at + 1, len(self.points) - 1)]
        high = min(high, 4 * omega)
        for _ in range(_ZOOMS):
            some = np.linspace(low, high, 9)
            found = [self.functions(numbers, np.array([one])) for one in some]
            k = int(np.argmin([math.inf if one is None else one[0] for one in found]))
            omega, low, high = float(some[k]), some[max(k - 1, 0)], some[min(k + 1, 8)]
        return omega

    def largest(self, widths: Callable[[float], Sequence[Channel]], most: float) -> float:
        """The largest factor below ``most`` at which there are multipliers, by halving; 0 if none.

        ``widths``: the channels of a factor; none where there are no such classes.  ``most``: only smaller factors are
        of interest.
        """
        for _ in range(_ROUNDS):
            factor = self._between(widths, most)
            if not factor:
                return 0.0
            most, factor = factor, factor * (1 - (_STEP if self.local else _SHARP))
            self.channels = widths(factor)
            found = self.constants()
            made = self._pieces(found[1], None) if found is not None else 0.0
            if not isinstance(made, float) or made == math.inf:
                break
            self.points = np.union1d(self.points, [made])
        return factor

    def _between(self, widths: Callable[[float], Sequence[Channel]], most: float) -> float:
        """The same, for the frequencies looked at alone."""

        def serves(factor: float) -> bool:
            """Whether the programme has a positive margin; where there are no such classes nothing is against it."""
            checkpoint()
            self.channels = widths(factor)
            if not self.channels:
                return True
            found = self.constants()
            return found is not None and found[0] > (_EASY if self.local else _EASY * close)

        close = _CLOSE if self.local else _SHARP
        low, high, share = 0.0, most if most < math.inf else 1.0, close
        while most < math.inf and share < 1:  # mostly it is close
            low = most * (1 - share)
            if serves(low):
                break
            low, high, share = 0.0, low, 6 * share
        while most == math.inf and high < LARGEST and serves(high):
            low, high = high, 4 * high
        while high - low > close * high and high > 1 / LARGEST:
            middle = (low + high) / 2 if low > high / 8 else math.sqrt(low * high) if low else high / 8
            low, high = (middle, high) if serves(middle) else (low, middle)
        return low if low and widths(low) else 0.0

    def proposal(self, exactly: Callable[[Sequence[Fraction], Sequence[Fraction]], Axis] | None) -> Proposal | None:
        """A multiplier by pieces, each of which passed its test; None if none was found.

        ``exactly``: the loop on the axis for weights and Popov's terms, as the checker has it; None for no test.
        """
        for _ in range(_AGAIN):
            checkpoint()
            found = self.constants()
            if found is None or found[0] <= _LEAST:
                return None
            numbers = found[1]
            weights, theta = [Fraction(0)] * len(self.D), [Fraction(0)] * len(self.D)
            slow = {i: [Fraction(0)] * 2 for i, one in enumerate(self.channels) if one.kind == "slow delay"}
            for value, (block, part) in zip(numbers, self.shared, strict=True):
                for i in block:
                    if i in slow:
                        slow[i][part] = Fraction(f"{max(value, 0.0):.{_DIGITS}g}")
                    elif part:
                        theta[i] = Fraction(f"{value / self.slow:.{_DIGITS}g}")
                    else:
                        weights[i] = Fraction(f"{max(value, 0.0):.{_DIGITS}g}")
            for i, j, ratio in self.ties:
                weights[j] = ratio * weights[i]
            self.slowly = slow
            made = self._pieces(numbers, exactly(weights, theta) if exactly else None)
            if made == math.inf:
                return None
            if isinstance(made, float):
                if made in self.points:
                    return None
                self.points = np.union1d(self.points, [made])
                continue
            ends, rows = made
            stated = {"lambda": [*map(str, weights)], "theta": [*map(str, theta)], "pieces": rows}
            return Proposal(stated, {"method": "pieces", "ends": [*map(str, ends)]})
        return None

    def _pieces(
        self, numbers: NDArray[np.float64], axis: Axis | None
    ) -> tuple[list[Fraction], list[list[list[str] | None]]] | float:
        """Ends and functions of pieces that all pass; or a frequency where none did, infinite if there are too many."""
        far, ends, rows = HALF_TURN, list[Fraction](), list[list[list[str] | None]]()
        last, doublings = None, 0
        if not self.discrete:
            far = Fraction(f"{self.points[-1 if self.late else -2]:.6g}")
            settled = self._settled(numbers, axis, far)
            if settled is None:
                return float(far) * (1 if self.rates else 2)
            far, doublings, last = settled
        low = far / 2**6
        stack = [(far * 2**k, far * 2 ** (k + 1)) for k in reversed(range(doublings))]
        stack += [(low * 2**k, low * 2 ** (k + 1)) for k in reversed(range(6))] + [(Fraction(0), low)]
        while stack:
            checkpoint()
            a, b = stack.pop()
            if len(ends) == _MOST_PIECES:
                return math.inf
            row = self._constant(numbers, axis, a, b)
            if row is not None:
                ends.append(b)
                rows.append(row)
                continue
            middle = (a + b) / 2
            if b - a < far / 2 ** (_DEEPEST if axis else _DEEP):
                return self._worst(numbers, float(middle))
            stack += [(middle, b), (a, middle)]
        return ends, rows if last is None else [*rows, last]

    def _settled(
        self, numbers: NDArray[np.float64], axis: Axis | None, far: Fraction
    ) -> tuple[Fraction, int, list[list[str] | None]] | None:
        """The functions that serve from a frequency to infinity, how often it is to be doubled; None if there are none.

        Beside dead times it may be halved, too: a piece has few radians of one.
        """
        last, doublings = self._constant(numbers, axis, far, None), 0
        most = (_FEW if self.rates else _DOUBLINGS) if self.late else 1  # in neutral equations F does not settle
        while last is None and doublings + 1 < most:
            checkpoint()
            doublings += 1
            last = self._constant(numbers, axis, far * 2**doublings, None)
        while not doublings and self.late and far * Fraction(self.late[-1][0]) > _LONG:
            checkpoint()
            nearer = self._constant(numbers, axis, far / 2, None)
            if nearer is None:
                break
            far, last = far / 2, nearer
        return None if last is None else (far, doublings, last)

    def _constant(
        self, numbers: NDArray[np.float64], axis: Axis | None, a: Fraction, b: Fraction | None
    ) -> list[list[str] | None] | None:
        """Functions that serve from ``a`` to ``b``, or to infinity, and pass the test; None if there are none."""
        if b is None:
            omega = np.append(float(a) * np.array([1.0, 1.5, 3.0, 10.0, 100.0, 1e4]), [] if self.late else [np.inf])
        else:
            start = float(a) or _NEAR * float(b) * bool(self.zeros)
            omega = np.linspace(start, float(b), _BETWEEN * (_INSIDE - 1) + 1)
        found, some = None, omega[::_BETWEEN] if b is not None else omega
        for _ in range(_CUTS):
            found = self.functions(numbers, some)
            if found is None or found[0] <= _MARGIN:
                return None
            lowest = self._lowest(numbers, found[1], omega)
            if lowest is None:
                break
            some = np.append(some, lowest)
        else:
            return None
        row, pairs = list[list[str] | None](), [[Fraction(0)] * 2 for _ in self.channels]
        for value, (block, part) in zip(found[1], self.local, strict=True):
            for i in block:
                pairs[i][part] = Fraction(f"{value:.{_DIGITS}g}")
        for i, (one, pair) in enumerate(zip(self.channels, pairs, strict=True)):
            if one.kind == "slow delay":
                pair[:] = self.slowly.get(i, pair)
                row.append([*map(str, pair)])
                continue
            inside = b is not None and b * one.width <= FULL_TURN
            free = one.kind in ("scaled operator", "gain", "delay")
            pair[0] = pair[0] if one.free else max(pair[0], Fraction(0))
            pair[1] = Fraction(0) if one.kind == "delay" and not inside else pair[1]
            pair[1] = max(pair[1], Fraction(0)) if one.kind == "delay" else pair[1]
            row.append([*map(str, pair)] if free else None)
        return None if axis and on_piece(axis, pairs, a, b, self.zeros) else row

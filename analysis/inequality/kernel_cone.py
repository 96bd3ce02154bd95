r"""Zames-Falb multipliers for several channels, proposed in floating point by semidefinite programmes over frequencies.

After the shift by the lower bounds ``psi_i`` has its slope in ``[0, w_i]``.  Sought are ``M = Gamma - sum c_k h_k`` and
``theta`` for the largest factor of the classes with

.. math:: F(\omega) = \mathrm{He}\,[M (W^{-1} + H) + i\omega\Theta H](i\omega) > 0

(``He X = (X + X^*)/2``) at every frequency, infinity included.  ``h_k`` has mass 1 and stands in one row and column of
channels with one nonlinearity; what the rows and columns of ``|c|`` add up to is at most ``gamma_ii``, and ``c >= 0``
unless the nonlinearities are odd.  For a given factor ``F`` is linear in all of them.  Frequencies are added where
``F`` is worst, kernels where the dual prices of the programme say that one would help, and the factor is raised to what
the multiplier found serves (Dinkelbach).  On the channels of an operator of norm up to ``w`` the multiplier is ``d``
times the identity, for the term ``d (1/w - w H_b^* H_b)``; of a time-invariant one ``d`` has even kernels too, added,
or subtracted up to ``gamma``: ``d`` is then a sum of low and high passes.  Where one constant gain, or one scalar
operator, acts in several channels, ``He M > 0`` on these at every frequency is all that is asked of ``M``, which is
Hermitian there for an operator.  Nothing here is believed: a checker decides
with rational multipliers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, combinations_with_replacement, product
from typing import TYPE_CHECKING, NamedTuple

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.kernels import Found, Kernel
from lure.analysis.numerics.semidefinite import hermitian_duals, hermitian_programme, hermitian_rows
from lure.arrays import NDArray, np
from lure.record import described, quantity

if TYPE_CHECKING:
    from lure.analysis.inequality.shifted_loop import ShiftedLoop, Widths

    Parts = tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]

_NARROW = 24  # frequencies at which a crossing is looked for first
_SOUGHT = 20  # rounds in which frequencies and kernels are added though nothing serves yet
_ROUNDS, _FLAT, _FIRST, _MORE, _ZOOMS, _DIPS = 40, 6, 24, 8, 6, 4
_ORDERS, _BESIDE, _SPACING = (1, 2, 3), 16.0, 2.0
_GAIN, _EXACTLY, _LEAST_PRICE, _UNUSED = 1e-3, 1e-7, 1e-9, 1e-9
_WATCHED, _REAL, _LARGEST_MASS = 80, 1e-7, 1e3
_LARGEST_THETA = 1e4
_RESTING = 0.02  # the share in the margin of channels whose width stays
_SETTLED = 1e-4  # of the factor, about: what a programme would still gain
_LEAST = 1e-6  # of the sum: a weight, where none may be 0
_BEYOND_RATE = 1.01  # kernels decay so much faster at least
_LOWEST, _CLOSE, _EASED, _BEYOND = 1e-6, 1e-11, 1e-3, 1.001


class _Solved(NamedTuple):
    """A solution of the programme: multiplier, margin, the weight of each frequency, the prices of rows and columns."""

    gamma: NDArray[np.float64]
    theta: NDArray[np.float64]
    masses: NDArray[np.float64]
    margin: float
    weights: NDArray[np.complex128]
    prices: NDArray[np.float64]
    real: NDArray[np.float64]  # prices of Re M_ii > 0, for each gain at each frequency
    parts: list[NDArray[np.complex128]]  # and of He M > 0, for each block of those that are wide


def _hermitian(X: NDArray[np.complex128]) -> NDArray[np.complex128]:
    return np.asarray((X + X.conj().swapaxes(-1, -2)) / 2)


def _crossing(value: Callable[[float], float], low: float, high: float) -> float:
    """The largest number found, from ``low`` on, where a falling function is positive; by false position (Illinois)."""
    first, last = value(low), value(high)
    if last > 0:
        return high
    side = steps = 0
    while high > low * (1 + _CLOSE):
        middle, steps = (low * last - high * first) / (last - first), steps + 1
        if not low < middle < high or steps % 4 == 0:
            middle = (low + high) / 2
        found = value(middle)
        if found > 0:
            low, first, last = middle, found, last / 2 if side > 0 else last
            side = 1
        else:
            high, last, first = middle, found, first / 2 if side < 0 else first
            side = -1
    return low


@described()
class KernelCone:
    """The multipliers of one loop, for any widths."""

    plant: ShiftedLoop = quantity("The loop after the shift by the lower bounds; kernels are for continuous time")
    blocks: Sequence[Sequence[int]] = quantity(
        "Channels that share one nonlinearity which has slope bounds and does not depend on time; others have none"
    )
    odd: Sequence[bool] = quantity("Whether the nonlinearity of each channel is odd")
    ratios: Sequence[tuple[int, float]] = quantity(
        "For each channel: ``gamma`` is the ratio times that of the channel, counted from 0, and not 0; none: any",
        default=(),
    )
    gains: Sequence[int] = quantity(
        "The channels with a constant gain each: ``Re M_ii > 0`` at every frequency takes the place of a bound on "
        "masses",
        default=(),
    )
    fixed: Sequence[Sequence[int]] = quantity("The channels of each operator that does not depend on time", default=())
    wide: Sequence[Sequence[int]] = quantity(
        "Of these blocks those where ``He M > 0`` at every frequency is all that is asked: of one constant gain in "
        "several channels, or one scalar operator",
        default=(),
    )
    residue: NDArray[np.float64] | None = quantity(
        "``R``, where the plant is that without ``R/s``: kernels are then on the diagonal, ``ratios`` those of "
        "``M(0)``",
        default=None,
    )
    turning: Sequence[tuple[int, Sequence[Fraction]]] | None = quantity(
        "Which ``theta`` there are: of the channels of its first entries, all of them times what is beside each; "
        "None: any",
        default=None,
    )
    theta_signs: Sequence[int] = quantity(
        "1 where ``theta`` may not be negative, -1 where not positive; none: any", default=()
    )
    scaled: Sequence[int] = quantity(
        "The channels whose width grows with the factor, those of a gain; none: all", default=()
    )
    rate: float = quantity(
        "The loop is that of the solutions times ``e^(rate t)``: what kernels and ``theta`` take is weighed",
        default=0.0,
    )

    def __post_init__(self) -> None:
        size, plant = np.abs(np.linalg.eigvals(self.plant.A)), self.plant
        self.omega, self.H = plant.omega, plant.H
        self.turned = plant.turned(plant.omega, plant.states, plant.H)
        self.last: Found | None = None
        self.growing = np.ones(len(self.odd))
        self.pairs = [(i, j) for block in self.blocks for i in block for j in block]
        if self.residue is not None:
            self.pairs = [(i, j) for i, j in self.pairs if i == j]
        count = _FIRST if self.pairs else _FIRST // 2
        self.points = self.omega[np.unique(np.linspace(0, len(self.omega) - 1, count).astype(int))]
        self.rates = list[Fraction]()
        if self.pairs or self.fixed:
            low, high = size.min() / _BESIDE, 4 * _BESIDE * size.max()
            count = 1 + math.ceil(math.log(high / low, _SPACING))
            rates = [Fraction(f"{low * _SPACING**i:.3g}") for i in range(count)]
            self.rates = [one for one in rates if one > _BEYOND_RATE * abs(self.rate)]
        self.watched = np.zeros(0)
        if self.gains or self.wide:
            ends = float(self.rates[0]) / 4, 4 * float(self.rates[-1])
            count = _WATCHED if self.wide else 5 * _WATCHED  # a matrix at each, or a number
            self.watched = np.concatenate([[0.0], np.geomspace(*ends, count), [np.inf]])
        self.shapes = [Kernel(0, 0, 1, rate, n, side) for rate in self.rates for n in _ORDERS for side in (1, -1)]

    def look_at(self, omega: NDArray[np.float64]) -> None:
        """Add frequencies to those at which the inequality is evaluated.

        ``omega``: frequencies, infinity among them or not [rad/s].
        """
        new = np.setdiff1d(omega, self.omega)
        states, H = self.plant.response(new)
        whole = np.concatenate([self.omega, new])
        order = np.argsort(whole)
        self.omega = whole[order]
        self.H = np.concatenate([self.H, H])[order]
        self.turned = np.concatenate([self.turned, self.plant.turned(new, states, H)])[order]

    def signs(self, i: int) -> tuple[int, ...]:
        """The signs that kernels in a row may have."""
        return (1, -1) if self.odd[i] else (1,)

    def largest(self, widths: Widths, start: float, most: float) -> Found | None:
        """The multiplier found that serves farthest, None if none was found.

        Parameters
        ----------
        widths : callable
            (m,) of a factor, increasing with it.
        start : float
            The factor to begin with.
        most : float
            More is not asked.
        """
        kernels = [Kernel(i, j, s, Fraction(0), 0, 1) for i, j in self.pairs if i != j for s in self.signs(i)]
        kernels += [
            Kernel(i, j, s, Fraction(0), 0, 1, mirrored=True)
            for block in self.fixed
            if block in self.wide
            for i, j in combinations(block, 2)
            for s in (1, -1)
        ]
        kernels += [
            Kernel(i, i, 1, self.rates[len(self.rates) // 2], 1, side)
            for i, j in self.pairs
            if i == j
            for side in (1, -1)
        ]
        best, last, flat, factor, sought = Found.none(len(self.odd)), Found.none(len(self.odd)), 0, start, 0
        gain = 1 + (_GAIN if self.pairs or self.fixed else _EXACTLY)
        for _ in range(_ROUNDS):
            checkpoint()
            seen = self.points
            solved = self._solved(np.searchsorted(self.omega, seen), widths(factor), kernels, last)
            tried = None if solved is None else Found(factor, solved.gamma, solved.theta, kernels, solved.masses)
            serves = 0.0 if tried is None else self.reached(tried, widths, factor, (best.factor, most))
            sought += best.factor == 0 == serves
            seeks = bool(self.pairs or self.fixed) and 2 < sought < _SOUGHT
            if solved is None or tried is None or (best.factor == 0 == serves and not seeks):
                factor /= 4
                if best.factor or factor < _LOWEST or widths(factor).min() <= 0:
                    break
                continue
            last = tried
            before = best.factor
            flat = 0 if serves > best.factor * gain else flat + 1
            best = last._replace(factor=serves) if serves > best.factor else best
            if self.scaled and best.factor:
                self.growing = np.array([1 if i in self.scaled else _RESTING for i in range(len(self.odd))])
            nothing_more = not (self.pairs or self.fixed) and factor <= before and solved.margin < _EXACTLY
            enough = 1 if self.pairs and solved.margin < _SETTLED else 2  # the margin says that more is to be had
            if best.factor >= most or flat >= _FLAT * enough or nothing_more:
                break
            least = self._least(self._parts(last), widths(factor))
            weight = np.trace(solved.weights, axis1=1, axis2=2).real
            used = seen if flat and not self.pairs else seen[weight > _UNUSED * weight.max()]
            self.points = np.union1d(used, self._deepest(last, widths(factor), least))
            self.look_at(self.points)
            if (self.pairs or self.fixed) and (flat or not (self.wide or self.fixed)):
                last = last.without(_UNUSED * 100)
                kernels = last.kernels + self._wanted(
                    np.searchsorted(self.omega, seen), widths(factor), solved, last.kernels
                )
            factor = max(best.factor, factor * (best.factor == 0))
        return self.remember(best)

    def remember(self, best: Found) -> Found | None:
        """The multiplier without what it does not use, kept as the last found; None if it serves nothing."""
        self.last = best.without(_UNUSED) if best.factor else None
        return self.last

    def known(self, widths: NDArray[np.float64]) -> Found | None:
        """The multiplier found last, if it serves for these widths at the frequencies looked at.

        ``widths``: (m,) upper bounds less lower ones.
        """
        if self.last is None:
            return None
        return self.last if self._least(self._parts(self.last), widths).min() > 0 else None

    def serving(self, widths: NDArray[np.float64]) -> Found | None:
        """A multiplier that serves for these widths and a little more, None if none was found.

        ``widths``: (m,) upper bounds less lower ones.
        """
        found = self.largest(lambda factor: factor * widths, 1.0, _BEYOND)
        return found if found is not None and found.factor > 1 else None

    def _parts(self, found: Found, at: NDArray[np.int64] | None = None) -> Parts:
        """``M H + i omega Theta H`` without operators, ``M`` and ``H``, at all frequencies or at some."""
        at = np.arange(len(self.omega)) if at is None else at
        return self._parted(found, self.omega[at], self.H[at], self.turned[at])

    def _parted(
        self, found: Found, omega: NDArray[np.float64], H: NDArray[np.complex128], turned: NDArray[np.complex128]
    ) -> Parts:
        M = found.at(omega)
        functions = (1 - self.plant.acting)[:, None] * M
        inner = functions @ H + found.theta[:, None] * turned
        return (inner if self.residue is None else inner + found.integrated(omega)[..., None] * self.residue), M, H

    def _least(self, parts: Parts, widths: NDArray[np.float64]) -> NDArray[np.float64]:
        """The least eigenvalue of ``F`` at each frequency."""
        inner, M, H = parts
        F = _hermitian(inner + M / widths)
        if self.plant.operators:
            acting = self.plant.acting
            F = F - H.conj().swapaxes(1, 2) @ ((acting[:, None] * M * (acting * widths)) @ H)
        return np.asarray(np.linalg.eigvalsh(F)[:, 0])

    def reached(
        self, found: Found, widths: Widths, start: float, between: tuple[float, float], *, rough: bool = False
    ) -> float:
        """The largest factor for which a multiplier serves at the frequencies, and between these; or 0.

        Parameters
        ----------
        found : Found
            The multiplier.
        widths : callable
            (m,) of a factor.
        start : float
            Where to begin.
        between : tuple of float
            Less than the first is not looked at closely, and more than the second is not asked.
        rough : bool
            Whether the frequencies known will do.
        """
        (known, high), low = between, 0.0
        for _ in range(_ZOOMS):
            whole = self._parts(found)

            def least(factor: float, parts: Parts = whole) -> NDArray[np.float64]:
                """The least eigenvalues of ``F`` for a factor."""
                return self._least(parts, widths(factor))

            low = min(start, high)
            while (values := least(low)).min() <= 0:
                low, high = low / 2, low
                if low < _LOWEST or widths(low).min() <= 0:
                    return 0.0
            while low < high and (further := least(min(2 * low, high))).min() > 0:
                low, values = min(2 * low, high), further
            top, at = min(2 * low, high), np.argsort(values)[:_NARROW]
            while True:  # where it is least, until it is least there
                some = whole[0][at], whole[1][at], whole[2][at]

                def lowest(factor: float, some: Parts = some) -> float:
                    """The least value over the frequencies with this factor."""
                    return float(least(factor, some).min())

                reached = _crossing(lowest, low, top)
                values = least(reached)
                if values.min() > 0:
                    break
                top, at = reached, np.union1d(at, np.argsort(values)[:_NARROW])
            low = reached
            if low <= known or rough:
                break
            deepest = self._deepest(found, widths(low), values)
            self.look_at(deepest)
            if least(low, self._parts(found, np.searchsorted(self.omega, deepest))).min() > 0:
                break
            start = high = low
        return low

    def _deepest(self, found: Found, widths: NDArray[np.float64], least: NDArray[np.float64]) -> NDArray[np.float64]:
        """The frequencies about the lowest local minima where ``F`` is least."""
        padded, last = np.concatenate([[np.inf], least, [np.inf]]), len(self.omega) - 1
        local = np.flatnonzero((least <= padded[:-2]) & (least <= padded[2:]))
        at = local[np.argsort(least[local])[:_DIPS]]
        omega, low, high = self.omega[at], self.omega[np.maximum(at - 1, 0)], self.omega[np.minimum(at + 1, last)]
        wide = np.isfinite(high)
        low, high, each = low[wide], high[wide], np.arange(int(wide.sum()))
        for _ in range(_ZOOMS if len(each) else 0):
            points = np.linspace(low, high, 9)
            states, H = self.plant.response(points.ravel())
            parts = self._parted(found, points.ravel(), H, self.plant.turned(points.ravel(), states, H))
            values = self._least(parts, widths).reshape(points.shape)
            k = values.argmin(axis=0)
            omega[wide] = points[k, each]
            low, high = points[np.maximum(k - 1, 0), each], points[np.minimum(k + 1, 8), each]
        return np.unique(omega)

    def _solved(
        self, at: NDArray[np.int64], widths: NDArray[np.float64], kernels: Sequence[Kernel], last: Found
    ) -> _Solved | None:
        """The programme at some frequencies: the largest ``t`` with ``F >= t N``, ``sum gamma_i/w_i = 1``.

        ``N = He M W^-1`` of the last multiplier, so that ``t`` is about the gain of factor that is left.  Where only
        some widths grow the sum is over these, and ``N`` is what ``F`` loses by that, with a little for the others.
        """
        m, count, unit = len(widths), len(kernels), self.plant.unit
        wide = {i for block in self.wide for i in block}
        rows = self._columns(at, widths, kernels, last)
        size = len(rows)
        sides = np.zeros((4 * m + count, size))  # rows and columns of M, theta, masses
        sides[: 2 * m, :m] = -np.vstack([np.eye(m)] * 2)
        total = np.concatenate([(self.growing == 1) / widths, np.zeros(size - m)])
        real = np.zeros((len(self.gains), len(self.watched), size))  # -Re M_ii of constant gains
        for at_gain, i in enumerate(self.gains):
            real[at_gain, :, i] = -1
        for k, kernel in enumerate(kernels):
            even = bool(kernel.rate) and not kernel.side
            if kernel.row in self.gains:
                values = kernel.sign * kernel.at(self.watched).real
                real[self.gains.index(kernel.row), :, 2 * m + k] = values
                continue
            if kernel.row in wide:
                continue
            first, second = kernel.masses(self.rate)
            if not even or kernel.sign > 0:
                sides[kernel.row, 2 * m + k] += first
            if not even:
                sides[m + kernel.column, 2 * m + k] += second
            elif kernel.sign < 0:
                total[2 * m + k] = 1 / widths[kernel.row]
        turning = np.diag(self.rate * unit * np.array(self.plant.free, dtype=float))
        sides[: 2 * m, m : 2 * m] = np.vstack([-turning, turning])
        sides[2 * m : 4 * m, m : 2 * m] = np.vstack([np.eye(m), -np.eye(m)])
        sides[4 * m :, 2 * m : -1] = -np.eye(count)
        joined = [block for block in self.plant.operators if block not in self.wide]
        equal = self._equal(total, kernels, [(block[0], i) for block in joined for i in block[1:]])
        low = -_LEAST * widths if self.ratios else np.zeros(m)
        bounded = np.zeros((count if self.gains or self.wide else 0, size))
        bounded[:, 2 * m : -1] = np.eye(len(bounded), count)
        sides = np.concatenate([sides, bounded, real.reshape(-1, size)])
        most = [np.full(len(bounded), _LARGEST_MASS), np.full(real.shape[0] * real.shape[1], -_REAL)]
        signs = np.array(self.theta_signs or [0] * m)
        turned = np.where(np.concatenate([signs < 0, signs > 0]), 0.0, _LARGEST_THETA)
        limits = np.concatenate([low, low, turned, np.zeros(count), *most])
        found = hermitian_programme(
            np.eye(size)[-1],
            (equal, np.eye(len(equal))[0]),
            (sides, limits),
            [np.moveaxis(rows, 0, -1), *(self._positive(block, kernels, total) for block in self.wide)],
        )
        if found is None:
            return None
        x, prices, (weights, *parts) = found
        for block in joined:
            x[[*block]] = x[block[0]]
        return _Solved(
            x[:m],
            x[m : 2 * m] * unit,
            np.maximum(x[2 * m : -1], 0.0),
            float(x[-1]),
            hermitian_duals(weights, m),
            prices[: 2 * m].reshape(2, m),
            prices[4 * m + count + len(bounded) :].reshape(len(self.gains), len(self.watched)),
            [hermitian_duals(part, len(block)) for part, block in zip(parts, self.wide, strict=True)],
        )

    def _equal(
        self, total: NDArray[np.float64], kernels: Sequence[Kernel], same: Sequence[tuple[int, int]]
    ) -> NDArray[np.float64]:
        """The rows of the equations: the sum, the ratios of residues, what operators share, and ``theta`` of a turn."""
        m, size = len(self.H[0]), len(total)
        equal = np.zeros((1 + len(self.ratios) + len(same), size))
        equal[0] = total
        for i, (first, ratio) in enumerate(self.ratios):
            equal[1 + i, first] -= ratio
            equal[1 + i, i] += 1
            for k, kernel in enumerate(kernels):  # of M(0)
                equal[1 + i, 2 * m + k] -= kernel.sign * ((kernel.row == i) - ratio * (kernel.row == first))
        for k, (first, i) in enumerate(same, 1 + len(self.ratios)):
            equal[k, [first, i]] = 1, -1
        if self.turning is None:
            return equal
        tied = np.zeros((m, size))
        tied[:, m : 2 * m] = np.eye(m)
        for first, row in self.turning:
            tied[:, m + first] -= [float(v) for v in row]
        return np.vstack([equal, np.delete(tied, [first for first, _ in self.turning], axis=0)])

    def _columns(
        self, at: NDArray[np.int64], widths: NDArray[np.float64], kernels: Sequence[Kernel], last: Found
    ) -> NDArray[np.float64]:
        """``F`` of each unknown at some frequencies, as rows of a programme: gamma, theta, masses, and ``t``."""
        m = len(widths)
        G, joint = self.H[at] + np.diag(1 / widths), {i for block in self.plant.operators for i in block}
        unit, norms = self.plant.unit, self._norms(at, widths)
        columns = np.zeros((2 * m + len(kernels) + 1, len(at), m, m), dtype=complex)
        for i in range(m):
            columns[i, :, i] = G[:, i]
            if i in joint:
                columns[i] = norms[i, i]
            columns[m + i, :, i] = self.turned[at, i] * unit
        for k, kernel in enumerate(kernels):
            lag = -kernel.sign * kernel.at(self.omega[at])[:, None]
            if kernel.mirrored:
                columns[2 * m + k] = 2 * lag[:, None] * norms[kernel.row, kernel.column]
            elif kernel.side or not kernel.rate:
                columns[2 * m + k, :, kernel.row] = lag * G[:, kernel.column]
                if self.residue is not None:
                    late = kernel.integrated(self.omega[at])[:, None] * self.residue[kernel.row]
                    columns[2 * m + k, :, kernel.row] -= kernel.sign * late
            else:
                columns[2 * m + k] = lag[:, None] * sum(norms[i, i] for i in (kernel.row, *kernel.also))
        _, M, _ = self._parts(last, at)
        columns[-1] = -(M + _EASED * np.diag(np.ones(m))) / widths * self.growing
        # of a gain, d (1/w - w H_i^* H_i), what grows with w
        for i in self.scaled if self.growing.min() < 1 else ():
            columns[-1] -= M[:, i, i, None, None] * widths[i] * self.H[at, i].conj()[:, :, None] * self.H[at, i, None]
        return hermitian_rows(_hermitian(columns))

    def _positive(
        self, block: Sequence[int], kernels: Sequence[Kernel], total: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Rows of ``He M`` on a block at the frequencies watched, less a little of what ``total`` sums up to."""
        m, r, place = len(self.odd), len(block), {i: k for k, i in enumerate(block)}
        found = np.zeros((len(total), len(self.watched), r, r), dtype=complex)
        for i in block:
            found[i, :, place[i], place[i]] = 1
        for k, kernel in enumerate(kernels, 2 * m):
            if kernel.row in place:
                found[k, :, place[kernel.row], place[kernel.column]] = -kernel.sign * kernel.at(self.watched)
                found[k] *= 2 if kernel.mirrored else 1
        found = _hermitian(found) - _REAL * total[:, None, None, None] * np.eye(r)
        return np.asarray(np.moveaxis(hermitian_rows(found), 0, -1))

    def _norms(
        self, at: NDArray[np.int64], widths: NDArray[np.float64]
    ) -> dict[tuple[int, int], NDArray[np.complex128]]:
        """``E_ij/w - w H_i^* H_j`` for the channels of operators, of one width in each."""
        found: dict[tuple[int, int], NDArray[np.complex128]] = {}
        for block in self.plant.operators:
            for i, j in product(block, block) if block in self.wide else zip(block, block, strict=True):
                found[i, j] = -widths[i] * self.H[at, i].conj()[:, :, None] * self.H[at, j][:, None, :]
                found[i, j][:, i, j] += 1 / widths[i]
        return found

    def _wanted(
        self, at: NDArray[np.int64], widths: NDArray[np.float64], solved: _Solved, have: Sequence[Kernel]
    ) -> list[Kernel]:
        """The kernels by which the margin would grow fastest, up to two for each entry and sign."""
        values = np.array([shape.at(self.omega[at]) for shape in self.shapes])
        whole = np.array([shape.at(self.watched) for shape in self.shapes])
        beside = whole.real
        parts = {i: (block, part) for block, part in zip(self.wide, solved.parts, strict=True) for i in block}
        GZ = (self.H[at] + np.diag(1 / widths)) @ solved.weights
        found = list[tuple[float, Kernel]]()
        norms = self._norms(at, widths)
        lags = [k for k, shape in enumerate(self.shapes) if (shape.order, shape.side) == (1, 1)]  # between 0 and 1
        for block, prices in zip(self.wide, solved.parts, strict=True):
            if block in self.fixed:
                found += self._beside(block, (values, whole), (solved.weights, prices), norms, have)
        for block in (block for block in self.fixed if block not in self.wide):
            own = np.einsum("kij,kji->k", sum(norms[i, i] for i in block), solved.weights).real
            gain = -(values[lags].real @ own)
            for sign in (1, -1):
                worth = sign * gain - (sign > 0) * solved.prices[0, block[0]]
                for k in np.argsort(-worth)[:2]:
                    kernel = self.shapes[lags[k]]._replace(
                        row=block[0], column=block[0], sign=sign, side=0, also=tuple(block[1:])
                    )
                    if worth[k] > _LEAST_PRICE and kernel not in have:
                        found.append((float(worth[k]), kernel))
        taken = np.array([shape.masses(self.rate) for shape in self.shapes]).T
        for i, j in self.pairs:
            gain = -(values @ GZ[:, j, i]).real
            if self.residue is not None:
                late = np.array([shape.integrated(self.omega[at]) for shape in self.shapes])
                gain = gain - (late @ (self.residue @ solved.weights)[:, j, i]).real
            if i in self.gains:
                gain = gain - beside @ solved.real[self.gains.index(i)]
            if i in parts:
                block, part = parts[i]
                gain = gain - (whole @ part[:, block.index(j), block.index(i)]).real
            free = i in self.gains or i in parts
            for sign in self.signs(i):
                worth = sign * gain - (0 if free else solved.prices[0, i] * taken[0] + solved.prices[1, j] * taken[1])
                for k in np.argsort(-worth)[:2]:
                    kernel = self.shapes[k]._replace(row=i, column=j, sign=sign)
                    if worth[k] > _LEAST_PRICE and kernel not in have:
                        found.append((float(worth[k]), kernel))
        found.sort(key=lambda one: -one[0])
        return [kernel for _, kernel in found[:_MORE]]

    def _beside(
        self,
        block: Sequence[int],
        values: tuple[NDArray[np.complex128], NDArray[np.complex128]],
        duals: tuple[NDArray[np.complex128], NDArray[np.complex128]],
        norms: Mapping[tuple[int, int], NDArray[np.complex128]],
        have: Sequence[Kernel],
    ) -> list[tuple[float, Kernel]]:
        """The same for a Hermitian multiplier of a scalar operator, with what each kernel is worth."""
        found = list[tuple[float, Kernel]]()
        for i, j in combinations_with_replacement(range(len(block)), 2):
            own = np.einsum("kij,kji->k", norms[block[i], block[j]], duals[0])
            sides = [value.real if i == j else 2 * value for value in values]
            gain = -(sides[0] @ own).real - (sides[1] @ duals[1][:, j, i]).real
            for sign in (1, -1):
                for k in np.argsort(-sign * gain)[:2]:
                    side = self.shapes[k].side if i != j else 0
                    kernel = self.shapes[k]._replace(
                        row=block[i], column=block[j], sign=sign, side=side, mirrored=i != j
                    )
                    if sign * gain[k] > _LEAST_PRICE and kernel not in have:
                        found.append((float(sign * gain[k]), kernel))
        return found

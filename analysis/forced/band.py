"""How far a periodic solution can be from a balance of harmonics: enclosures of residual, error and peaks, in balls."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import acb, acb_mat, arb, fmpq

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.balance import Balanced
from lure.analysis.forced.curves import Curve
from lure.analysis.forced.loop import ForcedLoop
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Bracket
from lure.errors import InputError

BITS = 96
_LEAST_POINTS, _PER_HARMONIC, _PEAK_STEPS, _CLOSE = 1024, 16, 400, 1e-12

Harmonics = list[acb]
"""``c_k`` of ``Re sum c_k e^(i k theta)``."""


@dataclass(frozen=True)
class Residual:
    """What the harmonics of ``psi`` miss of ``psi(sigma)``, and the ``sigma`` and ``z`` they make.

    Attributes
    ----------
    rows : list of Harmonics
        Of each ``sigma_i``, then of each entry of ``z``.
    mean : arb
        Mean square root over a period of all channels together, from above.
    largest : arb
        What no channel exceeds at any time.
    """

    rows: list[Harmonics]
    mean: arb
    largest: arb


@dataclass(frozen=True)
class Band:
    """Peaks of the solution over a period.

    Attributes
    ----------
    sigma : tuple of Bracket
        ``max |sigma_i(t)|``.
    z : Bracket
        ``max |z(t)|``, the Euclidean length.
    error : float
        How far ``z`` is from the balanced one at any time, at most.
    mean_error : float
        The same in the mean square of ``sigma`` over a period.
    residual : float
        The mean square root of what the harmonics miss.
    """

    sigma: tuple[Bracket, ...]
    z: Bracket
    error: float
    mean_error: float
    residual: float


def residual(loop: ForcedLoop, found: Balanced) -> Residual:
    """The residual of a balance, enclosed.

    Parameters
    ----------
    loop : ForcedLoop
        The loop.
    found : Balanced
        The harmonics, taken as exact numbers.

    Raises
    ------
    InputError
        A nonlinearity has no slope that is known on the way of ``sigma``.

    Notes
    -----
    The period is cut into equal parts of half-width ``h``.  With ``e`` and ``e'`` in the middle and ``|e''| <= b``, the
    mean square of ``e`` over a part is at most ``(sqrt(e^2 + e'^2 h^2/3) + b h^2/sqrt(20))^2``; where ``sigma`` may
    pass a kink, with ``|e'| <= L``, at most ``(|e| + L h/sqrt(3))^2``.
    """
    with working_precision(BITS):
        rows, psi = _rows(loop, found), [[acb(c.real, c.imag) for c in row] for row in found.psi.tolist()]
        count = 1 if not found.wave.omega else max(_LEAST_POINTS, _power_of_two(_PER_HARMONIC * found.count))
        half = arb.pi() / count if found.wave.omega else arb(0)
        total, largest = arb(0), arb(0)
        for i, curve in enumerate(loop.curves):
            checkpoint()
            g = ball(loop.gains[i])
            straight = _along_a_line(curve, g, rows[i], psi[i])
            if straight is not None:
                total, largest = total + straight[0] * count, largest.max(straight[1])
                continue
            sigma, given = _Sampled.of(rows[i], count), _Sampled.of(psi[i], count)
            for s, ds, p, dp in zip(sigma.values, sigma.slopes, given.values, given.slopes, strict=True):
                fast = _top(abs(ds)) + sigma.bend * half
                value, slope, _ = curve(s)
                _, slopes, bend = curve(s + arb(0, _float_above(fast * half)))
                if not (value.is_finite() and slopes.is_finite()):
                    raise InputError("phi has no slope that is known everywhere on the way of sigma")
                e = abs(value - g * s - p)
                steep = _top(abs(slopes - g))
                if bend.is_finite():
                    moved = (slope - g) * ds - dp
                    curved = _top(abs(bend)) * fast * fast + steep * sigma.bend + given.bend
                    part = (e * e + moved * moved * half * half / 3).sqrt() + curved * half * half / arb(20).sqrt()
                    top = e + abs(moved) * half + curved * half * half / 2
                else:
                    quick = steep * fast + _top(abs(dp)) + given.bend * half
                    part, top = e + quick * half / arb(3).sqrt(), e + quick * half
                total += _top(part) ** 2
                largest = largest.max(_top(top))
        return Residual(rows, _top((total / count).sqrt()), largest)


def _along_a_line(curve: Curve, g: arb, sigma: Harmonics, psi: Harmonics) -> tuple[arb, arb] | None:
    """Mean square and a bound of the residual where ``phi`` is straight on the way of ``sigma``; None elsewhere."""
    around = sum((abs(c) for c in sigma[1:]), arb(0))
    _, slope, bend = curve(sigma[0].real + arb(0, _float_above(around)))
    if not (bend.is_finite() and bend == 0):
        return None
    value, _, _ = curve(sigma[0].real)
    off = abs(value - g * sigma[0].real - psi[0].real)
    rest = [abs((slope - g) * s - p) for s, p in zip(sigma[1:], psi[1:], strict=True)]
    return _top(off**2 + sum((v * v for v in rest), arb(0)) / 2), _top(off + sum(rest, arb(0)))


def band(loop: ForcedLoop, found: Balanced, gain: Fraction, smooth: Sequence[arb]) -> Band:
    r"""Peaks of the solution that a certified incremental gain allows near a balance.

    ``|sigma - sigma_hat| <= gamma |e|`` in the mean square over a period, ``nu`` differs by at most ``(1 + kappa gamma)
    |e|``, and what ``nu`` makes of ``z`` at any time is bounded by Cauchy and Schwarz.

    Parameters
    ----------
    loop : ForcedLoop
        The loop.
    found : Balanced
        The balance.
    gain : Fraction
        The incremental L2 gain ``gamma`` from what is added to ``mu`` to ``sigma``.
    smooth : sequence of arb
        What :meth:`ForcedLoop.smoothing` says at this frequency.
    """
    missed = residual(loop, found)
    with working_precision(BITS):
        spread = [ball(k) for k in loop.spread]
        widest = ball(max(loop.spread))
        mean = ball(gain) * missed.mean
        moved = (1 + widest * ball(gain)) * missed.mean
        m = loop.channels
        direct = [[_top(abs(arb(v))) for v in row] for row in loop.D.tolist()]
        share = _largest(sum((d * k for d, k in zip(row, spread, strict=True)), arb(0)) for row in direct[:m])
        through = [sum(row, arb(0)) * missed.largest for row in direct]
        off = _largest(smooth[i] * moved + through[i] for i in range(m)) / (1 - share) if share < 1 else arb("inf")
        errors = list[arb]()
        for i, row in enumerate(direct):
            turned = sum((d * k for d, k in zip(row, spread, strict=True)), arb(0))
            errors.append(_top(smooth[i] * moved + through[i] + (turned * off if any(row) else 0)))
        wide = sum((e * e for e in errors[m:]), arb(0)).sqrt()
        period = bool(found.wave.omega)
        sigma = tuple(_around(peak([missed.rows[i]], period=period), errors[i]) for i in range(m))
        z = _around(peak(missed.rows[m:], period=period), wide)
        return Band(sigma, z, _float_above(wide), _float_above(mean), _float_above(missed.mean))


def peak(rows: list[Harmonics], *, period: bool = True) -> arb:
    """The largest length over a period of a vector of sums of harmonics, between the ends of a ball.

    Parameters
    ----------
    rows : list of Harmonics
        Its entries.
    period : bool
        Whether they move; else all are constant.
    """
    if not period or all(abs(c) == 0 for row in rows for c in row[1:]):
        return sum((row[0].real ** 2 for row in rows), arb(0)).sqrt()
    order = len(rows[0]) - 1
    bend = sum((_bend(row) ** 2 for row in rows), arb(0)).sqrt()
    count = max(256, _power_of_two(8 * order))
    signals, low, heap = [_Sampled.of(row, count) for row in rows], arb(0), list[tuple[float, int, fmpq, fmpq]]()

    def upper(values: list[arb], slopes: list[arb], half: arb) -> arb:
        ends = [sum(((v + s * d) ** 2 for v, s in zip(values, slopes, strict=True)), arb(0)) for d in (-half, half)]
        return _top(ends[0].max(ends[1]).sqrt() + bend * half * half / 2)

    half = arb.pi() / count
    for j in range(count):
        values, slopes = [one.values[j] for one in signals], [one.slopes[j] for one in signals]
        low = low.max(sum((v * v for v in values), arb(0)).sqrt().lower())
        heap.append((-_float_above(upper(values, slopes, half)), j, fmpq(2 * j, count), fmpq(1, count)))
    heap = [one for one in heap if -one[0] >= low]
    heapq.heapify(heap)
    for number in range(_PEAK_STEPS):
        if not -heap[0][0] > low * (1 + _CLOSE):
            break
        _, _, at, width = heapq.heappop(heap)
        for middle in (at - width / 2, at + width / 2):
            turn = acb(middle).exp_pi_i()
            pairs = [_value(row, turn) for row in rows]
            values, slopes = [v for v, _ in pairs], [s for _, s in pairs]
            low = low.max(sum((v * v for v in values), arb(0)).sqrt().lower())
            half = arb.pi() * arb(width / 2)
            heapq.heappush(heap, (-_float_above(upper(values, slopes, half)), count + 2 * number, middle, width / 2))
    return low.union(arb(-heap[0][0]))


@dataclass(frozen=True)
class _Sampled:
    """A sum of harmonics and its derivative in the middle of equal parts of a period, and a bound of the second."""

    values: list[arb]
    slopes: list[arb]
    bend: arb

    @classmethod
    def of(cls, row: Harmonics, count: int) -> _Sampled:
        """At ``theta = 2 pi j/count``."""
        if count == 1:
            return cls([row[0].real], [arb(0)], arb(0))
        first = [acb(0)] * count
        second = list(first)
        for k, c in enumerate(row):
            first[-k % count], second[-k % count] = c, acb(0, k) * c  # acb.dft turns the other way
        return cls([v.real for v in acb.dft(first)], [v.real for v in acb.dft(second)], _bend(row))


def _bend(row: Harmonics) -> arb:
    """What the second derivative does not exceed."""
    return _top(sum((k * k * abs(c) for k, c in enumerate(row)), arb(0)))


def _value(row: Harmonics, turn: acb) -> tuple[arb, arb]:
    """The sum and its derivative at ``e^(i theta)``."""
    value, slope = acb(0), acb(0)
    for k in range(len(row) - 1, -1, -1):
        value, slope = value * turn + row[k], slope * turn + acb(0, k) * row[k]
    return value.real, slope.real


def _rows(loop: ForcedLoop, found: Balanced) -> list[Harmonics]:
    """The harmonics of ``sigma`` and ``z``."""
    wave, columns = found.wave, list[list[acb]]()
    for k, psi in enumerate(found.psi.T.tolist()):
        inputs = [ball(v) if k == 0 else arb(0) for v in wave.constant]
        right = [[-acb(c.real, c.imag)] for c in psi] + [[acb(v)] for v in inputs]
        if wave.omega and k == wave.periods:
            for i, v in enumerate(wave.amplitude):
                right[loop.channels + i] = [acb(0, -ball(v))]
        columns.append([row[0] for row in (loop.response(wave.base, k) * acb_mat(right)).tolist()])
    return [list(row) for row in zip(*columns, strict=True)]


def _largest(values: object) -> arb:
    found = arb(0)
    for value in values:  # type: ignore[attr-defined]  # a generator of balls
        found = found.max(value)
    return found


def _around(middle: arb, radius: arb) -> Bracket:
    """What lies within the radius, and not below 0."""
    low = middle.lower() - radius
    found = outward(low, middle.upper() + radius)
    return Bracket(max(found.low, 0.0), found.high)


def _top(value: arb) -> arb:
    """The upper end, exactly."""
    return value.upper()


def _float_above(value: arb) -> float:
    return outward(value, value).high


def _power_of_two(number: int) -> int:
    return 1 << (number - 1).bit_length()

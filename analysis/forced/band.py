"""How far a periodic solution can be from a balance of harmonics: enclosures of residual, error and peaks, in balls."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from flint import acb, acb_mat, arb, fmpq

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.balance import Balanced
from lure.analysis.forced.loop import Curve, ForcedLoop
from lure.analysis.numerics.precision import ball, outward, upward, working_precision
from lure.analysis.verdict import Bracket
from lure.arrays import Reals, np
from lure.errors import InputError
from lure.record import described, quantity

BITS = 96
_LEAST_POINTS, _PER_HARMONIC, _PEAK_STEPS, _CLOSE, _MOST_HARMONICS, _FEW_HARMONICS = 1024, 64, 400, 1e-12, 8192, 128

Harmonics = list[acb]
"""``c_k`` of ``Re sum c_k e^(i k theta)``."""


class NotEnclosed(InputError):
    """A nonlinearity whose value or slope has no finite ball on the way of ``sigma``."""


@described(frozen=True)
class Residual:
    """What the harmonics of ``psi`` miss of ``psi(sigma)``, and the ``sigma`` and ``z`` they make."""

    rows: list[Harmonics] = quantity("Of each ``sigma_i``, then of each entry of ``z``")
    responses: list[acb_mat] = quantity("Of ``(sigma, z)`` to each harmonic of ``nu``, without the direct term")
    low: list[list[arb]] = quantity(
        "Of each channel the size of each harmonic ``e_k`` of ``sum e_k e^(i k theta)``, at most"
    )
    mean: arb = quantity("Mean square root over a period of all channels together, from above")
    largest: arb = quantity("What no channel exceeds at any time")
    parts: list[Reals] = quantity(
        "What each channel does not exceed on each of equal parts of a period, the first around its beginning"
    )

    def filtered(self, loop: ForcedLoop, smooth: Sequence[arb]) -> Filtered:
        """What the loop around the gains makes of it.

        ``smooth``: what :meth:`ForcedLoop.smoothing` says at this frequency.
        """
        means, tops = list[arb](), list[arb]()
        direct = [sum((abs(arb(v)) for v in row), arb(0)) for row in loop.D.tolist()]
        for r, whole in enumerate(smooth):
            mean, top = arb(0), arb(0)
            for k, response in enumerate(self.responses):
                twice = 2 if k else 1
                part = sum((abs(response[r, i]) * own[k] for i, own in enumerate(self.low)), arb(0))
                mean, top = mean + twice * part * part, top + twice * part
            beyond = self.tail(r, whole)
            means.append((mean + (beyond * self.mean) ** 2 / 2).sqrt() + direct[r] * self.mean)
            tops.append(_top(top + beyond * self.mean + direct[r] * self.largest))
        return Filtered(_top(sum((v * v for v in means[: loop.channels]), arb(0)).sqrt()), tops)

    def tail(self, row: int, whole: arb, low: int | None = None) -> arb:
        """``(sum |G(i k omega)|^2)^(1/2)`` over the harmonics beyond ``low``, by default all that are here."""
        found = whole * whole
        for k, response in enumerate(self.responses[: None if low is None else low + 1]):
            found -= (2 if k else 1) * sum((abs(response[row, i]) ** 2 for i in range(len(self.low))), arb(0))
        return _top(found.nonnegative_part()).sqrt()


class Filtered(NamedTuple):
    """What a loop makes of a residual that is added to its ``nu``.

    Attributes
    ----------
    mean : arb
        Mean square root of ``sigma``, at most.
    tops : list of arb
        What no ``sigma_i``, no entry of ``z`` exceeds at any time.
    """

    mean: arb
    tops: list[arb]


@described(frozen=True)
class Band:
    """Peaks of the solution over a period."""

    sigma: tuple[Bracket, ...] = quantity("``max |sigma_i(t)|``")
    z: Bracket = quantity("``max |z(t)|``, the Euclidean length")
    error: float = quantity("How far ``z`` is from the balanced one at any time, at most")
    residual: float = quantity("The mean square root of what the harmonics miss")


def residual(loop: ForcedLoop, found: Balanced, each: int = _PER_HARMONIC) -> Residual:
    """The residual of a balance, enclosed.

    ``found``: the harmonics, taken as exact numbers; ``each``: into how many parts for each harmonic a period is cut at
    least, where phi is no polynomial.

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
        rows, responses = _rows(loop, found)
        psi = [[acb(c.real, c.imag) for c in row] for row in found.psi.tolist()]
        count = 1 if not found.wave.omega else max(_LEAST_POINTS, _power_of_two(each * found.count))
        total, largest, low, parts = arb(0), arb(0), list[list[arb]](), list[Reals]()
        for i, curve in enumerate(loop.curves):
            checkpoint()
            missed = _of_polynomial(curve, loop.degrees[i], ball(loop.gains[i]), rows[i], psi[i])
            if missed is None:
                missed = _along_a_line(curve, ball(loop.gains[i]), rows[i], psi[i])
            if missed is None:
                missed = _by_parts(curve, ball(loop.gains[i]), rows[i], psi[i], count)
            total, largest = total + missed.square, largest.max(missed.largest)
            low.append(missed.low)
            parts.append(np.broadcast_to(np.array(missed.parts or [above(missed.largest)]), count))
        return Residual(rows, responses, low, _top(total.sqrt()), largest, parts)


class _Missed(NamedTuple):
    """Of one channel the mean square of the residual, what it does not exceed, the size of its harmonics, and parts."""

    square: arb
    largest: arb
    low: list[arb]
    parts: list[float]


def _by_parts(curve: Curve, g: arb, sigma: Harmonics, psi: Harmonics, count: int) -> _Missed:
    """The residual ``phi - g sigma - psi`` on equal parts of a period."""
    half, total, largest, rest = arb.pi() / count, arb(0), arb(0), arb(0)
    way, given = Sampled.of(sigma, count), Sampled.of(psi, count)
    bends, third = Sampled.of(_turned(_turned(sigma)), count).values, Sampled.of(_turned(sigma), count).bend
    given_bends, given_third = Sampled.of(_turned(_turned(psi)), count).values, Sampled.of(_turned(psi), count).bend
    middles, moves, parts = list[acb](), list[acb](), list[float]()
    for j, (s, ds, p, dp) in enumerate(zip(way.values, way.slopes, given.values, given.slopes, strict=True)):
        fast = _top(abs(ds)) + way.bend * half
        value, slope, _ = curve(s)
        _, slopes, bend = curve(s + arb(0, above(fast * half)))
        if not (value.is_finite() and slopes.is_finite()):
            raise NotEnclosed("phi has no slope that is known everywhere on the way of sigma")
        e, moved, steep = value - g * s - p, arb(0), _top(abs(slopes - g))
        if bend.is_finite():
            moved = (slope - g) * ds - dp
            curved = _top(abs(bend)) * fast * fast + steep * way.bend + given.bend
            if bend == 0:  # on a line the second derivative itself is known in the middle
                curved = _top(abs((slope - g) * bends[j] - given_bends[j])) + half * (steep * third + given_third)
            part = (e * e + moved * moved * half * half / 3).sqrt() + curved * half * half / arb(20).sqrt()
            most, mean = curved * half * half / 2, curved * half * half / 6
        else:
            quick = steep * fast + _top(abs(dp)) + given.bend * half
            part, most, mean = abs(e) + quick * half / arb(3).sqrt(), quick * half, quick * half / 2
        total += _top(part) ** 2
        here = _top(abs(e) + abs(moved) * half + most)
        largest = largest.max(here)
        parts.append(above(here))
        rest += _top(mean)
        middles.append(acb(e))
        moves.append(acb(moved))
    return _Missed(_top(total / count), largest, _harmonics(middles, moves, _top(rest / count), len(psi)), parts)


def _harmonics(middles: list[acb], moves: list[acb], rest: arb, size: int) -> list[arb]:
    """The size of the harmonics of what is ``e + e' tau`` on each part, but for ``rest`` in the mean."""
    count = len(middles)
    half, values, slopes = arb.pi() / count, acb.dft(middles), acb.dft(moves)
    found = [_top(abs(values[0]) / count + rest)]
    for k in range(1, size):
        angle = half * k
        flat, tilted = angle.sin() / angle, (angle.sin() / k - half * angle.cos()) / k  # of 1 and of i tau, over 2 h
        whole = values[k % count] * flat - acb(0, 1) * slopes[k % count] * (tilted / half)
        found.append(_top(abs(whole) / count + rest))
    return found


def _of_polynomial(curve: Curve, degree: int | None, g: arb, sigma: Harmonics, psi: Harmonics) -> _Missed | None:
    """The residual where ``phi`` is a polynomial, so that it is a sum of harmonics itself; None elsewhere."""
    order = (len(sigma) - 1) * (degree or 0)
    if degree is None or order > _MOST_HARMONICS:
        return None
    count = 2 * _power_of_two(order + 1) if order else 1
    values = [curve(s)[0] - g * s for s in Sampled.of(sigma, count).values]
    found = [c / count for c in acb.dft([acb(v) for v in values])[: order + 1]]
    for k, c in enumerate(psi):
        found[k] -= c / (2 if k else 1)
    sizes = [_top(abs(c)) for c in found]
    square = sizes[0] ** 2 + 2 * sum((v * v for v in sizes[1:]), arb(0))
    return _Missed(_top(square), _top(sizes[0] + 2 * sum(sizes[1:], arb(0))), sizes[: len(psi)], [])


def _along_a_line(curve: Curve, g: arb, sigma: Harmonics, psi: Harmonics) -> _Missed | None:
    """The residual where ``phi`` is straight on the way of ``sigma``; None elsewhere."""
    around = sum((abs(c) for c in sigma[1:]), arb(0))
    _, slope, bend = curve(sigma[0].real + arb(0, above(around)))
    if not (bend.is_finite() and bend == 0):
        return None
    value, _, _ = curve(sigma[0].real)
    off = abs(value - g * sigma[0].real - psi[0].real)
    rest = [abs((slope - g) * s - p) for s, p in zip(sigma[1:], psi[1:], strict=True)]
    square = off**2 + sum((v * v for v in rest), arb(0)) / 2
    return _Missed(_top(square), _top(off + sum(rest, arb(0))), [_top(off), *(_top(v / 2) for v in rest)], [])


def band(loop: ForcedLoop, found: Balanced, gain: Fraction, smooth: Sequence[arb]) -> Band:
    r"""Peaks of the solution that a certified incremental gain allows near a balance.

    The residual ``e`` alone makes ``u = G e`` of ``sigma``.  What is left, ``sigma - sigma_hat - u``, answers to
    ``|psi(sigma) - psi(sigma_hat)| <= kappa |sigma - sigma_hat|``, so that ``|sigma - sigma_hat| <= (1 + kappa gamma)
    |u|`` in the mean square over a period, and ``G`` makes of it what Cauchy and Schwarz allow at any time.

    ``found``: the balance; ``gain``: the incremental L2 gain ``gamma`` from what is added to ``mu`` to ``sigma``;
    ``smooth``: what :meth:`ForcedLoop.smoothing` says at this frequency.
    """
    missed = residual(loop, found)
    with working_precision(BITS):
        alone, widest, m = missed.filtered(loop, smooth), ball(max(loop.spread)), loop.channels
        mean = (1 + widest * ball(gain)) * alone.mean
        sides = [top + s * widest * mean for top, s in zip(alone.tops, smooth, strict=True)]
        through = [
            sum((_top(abs(arb(v))) * ball(k) for v, k in zip(row, loop.spread, strict=True)), arb(0))
            for row in loop.D.tolist()
        ]
        share = _largest(through[:m])
        off = _largest(sides[:m]) / (1 - share) if share < 1 else arb("inf")
        errors = [_top(side + (own * off if own != 0 else 0)) for side, own in zip(sides, through, strict=True)]
        wide, period = sum((e * e for e in errors[m:]), arb(0)).sqrt(), bool(found.wave.omega)
        sigma = tuple(around(peak([missed.rows[i]], period=period), errors[i]) for i in range(m))
        z = around(peak(missed.rows[m:], period=period), wide)
        return Band(sigma, z, above(wide), above(missed.mean))


def peak(rows: list[Harmonics], *, period: bool = True) -> arb:
    """The largest length over a period of a vector of sums of harmonics, between the ends of a ball.

    ``rows``: its entries.  ``period``: whether they move; else all are constant.
    """
    if not period or all(abs(c) == 0 for row in rows for c in row[1:]):
        return sum((row[0].real ** 2 for row in rows), arb(0)).sqrt()
    order = len(rows[0]) - 1
    bend = sum((_bend(row) ** 2 for row in rows), arb(0)).sqrt()
    many = order > _FEW_HARMONICS  # of these the value at a point is known by transforms alone
    count = max(256, _power_of_two((64 if many else 8) * order))
    signals, low, heap = [Sampled.of(row, count) for row in rows], arb(0), list[tuple[float, int, fmpq, fmpq]]()

    def upper(values: list[arb], slopes: list[arb], half: arb) -> arb:
        """A bound over an interval from what is known in its middle."""
        ends = [sum(((v + s * d) ** 2 for v, s in zip(values, slopes, strict=True)), arb(0)) for d in (-half, half)]
        return _top(ends[0].max(ends[1]).sqrt() + bend * half * half / 2)

    half = arb.pi() / count
    for j in range(count):
        values, slopes = [one.values[j] for one in signals], [one.slopes[j] for one in signals]
        low = low.max(sum((v * v for v in values), arb(0)).sqrt().lower())
        heap.append((-above(upper(values, slopes, half)), j, fmpq(2 * j, count), fmpq(1, count)))
    heap = [one for one in heap if -one[0] >= low]
    heapq.heapify(heap)
    for number in range(0 if many else _PEAK_STEPS):
        if not -heap[0][0] > low * (1 + _CLOSE):
            break
        _, _, at, width = heapq.heappop(heap)
        for middle in (at - width / 2, at + width / 2):
            turn = acb(middle).exp_pi_i()
            pairs = [_value(row, turn) for row in rows]
            values, slopes = [v for v, _ in pairs], [s for _, s in pairs]
            low = low.max(sum((v * v for v in values), arb(0)).sqrt().lower())
            half = arb.pi() * arb(width / 2)
            heapq.heappush(heap, (-above(upper(values, slopes, half)), count + 2 * number, middle, width / 2))
    return low.union(arb(-heap[0][0]))


@dataclass(frozen=True)
class Sampled:
    """A sum of harmonics and its derivative in the middle of equal parts of a period, and a bound of the second."""

    values: list[arb]
    slopes: list[arb]
    bend: arb

    @classmethod
    def of(cls, row: Harmonics, count: int) -> Sampled:
        """At ``theta = 2 pi j/count``."""
        if count == 1:
            return cls([row[0].real], [arb(0)], arb(0))
        first = [acb(0)] * count
        second = list(first)
        for k, c in enumerate(row):
            first[-k % count] = c  # acb.dft turns the other way
        for k, c in enumerate(_turned(row)):
            second[-k % count] = c
        return cls([v.real for v in acb.dft(first)], [v.real for v in acb.dft(second)], _bend(row))


def _turned(row: Harmonics) -> Harmonics:
    """The derivative."""
    return [acb(0, k) * c for k, c in enumerate(row)]


def _bend(row: Harmonics) -> arb:
    """What the second derivative does not exceed."""
    return _top(sum((k * k * abs(c) for k, c in enumerate(row)), arb(0)))


def _value(row: Harmonics, turn: acb) -> tuple[arb, arb]:
    """The sum and its derivative at ``e^(i theta)``."""
    value, slope = acb(0), acb(0)
    for k in range(len(row) - 1, -1, -1):
        value, slope = value * turn + row[k], slope * turn + acb(0, k) * row[k]
    return value.real, slope.real


def _rows(loop: ForcedLoop, found: Balanced) -> tuple[list[Harmonics], list[acb_mat]]:
    """The harmonics of ``sigma`` and ``z``, and of what each makes of those of ``nu``, without the direct term."""
    wave, columns, responses = found.wave, list[list[acb]](), list[acb_mat]()
    rows, m = range(loop.D.nrows()), loop.channels
    for k, psi in enumerate(found.psi.T.tolist()):
        inputs = [ball(v) if k == 0 else arb(0) for v in wave.constant]
        right = [[-acb(c.real, c.imag)] for c in psi] + [[acb(v)] for v in inputs]
        if wave.omega and k == wave.periods:
            for i, v in enumerate(wave.amplitude):
                right[m + i] = [acb(0, -ball(v))]
        response = loop.response(wave.base, k)
        columns.append([row[0] for row in (response * acb_mat(right)).tolist()])
        responses.append(acb_mat([[response[r, i] - arb(loop.D[r, i]) for i in range(m)] for r in rows]))
    return [list(row) for row in zip(*columns, strict=True)], responses


def _largest(values: object) -> arb:
    found = arb(0)
    for value in values:  # type: ignore[attr-defined]  # a generator of balls
        found = found.max(value)
    return found


def around(middle: arb, radius: arb) -> Bracket:
    """What lies within the radius, and not below 0."""
    low = middle.lower() - radius
    found = outward(low, middle.upper() + radius)
    return Bracket(max(found.low, 0.0), found.high)


def _top(value: arb) -> arb:
    """The upper end, exactly."""
    return value.upper()


def above(value: arb) -> float:
    """The least double that is found not to be below a ball."""
    return upward(value)


def _power_of_two(number: int) -> int:
    return 1 << (number - 1).bit_length()

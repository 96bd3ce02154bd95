"""One Chebyshev series in compiled code: values, parts, bounds; each series has its degree ``n`` and place ``c``."""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, inlined
from lure.rod.motion.kernel_data import DEGREE, FIT, INNER, NODES, PRODUCTS, Counts

NOISE = 1e-16  # coefficients of a part below this share of the whole are rounding


@compiled
def value(f: Array, c: int, n: int, x: float) -> float:
    """Value at ``x``, by Clenshaw's recurrence."""
    total, before = 0.0, 0.0
    for k in range(n, 0, -1):
        total, before = 2.0 * x * total - before + f[c + k], total
    return float(x * total - before + f[c])


@inlined
def right_end(f: Array, c: int, n: int) -> float:
    """Value at 1."""
    total = 0.0
    for k in range(n + 1):
        total += f[c + k]
    return total


@compiled
def left_end(f: Array, c: int, n: int) -> float:
    """Value at -1."""
    total, sign = 0.0, 1.0
    for k in range(n + 1):
        total += sign * f[c + k]
        sign = -sign
    return total


@inlined
def variation(f: Array, c: int, n: int) -> float:
    """Sum of ``|c_k|``, ``k >= 1``."""
    total = 0.0
    for k in range(1, n + 1):
        total += abs(f[c + k])
    return total


@inlined
def trimmed(f: Array, c: int, n: int, tiny: float) -> int:
    """Degree without the last coefficients up to ``tiny``."""
    while n > 0 and abs(f[c + n]) <= tiny:
        n -= 1
    return n


@compiled
def fitted(f: Array, q: Counts, n: int, out: int) -> float:
    """The series of degree ``n`` with the values ``f[NODES], ...`` at the zeros of ``T_{n+1}``; the largest value."""
    width, largest = q[DEGREE] + 1, 0.0
    row = q[FIT] + n * width * width
    for k in range(n + 1):
        total = 0.0
        for j in range(n + 1):
            total += f[row + j] * f[NODES + j]
        f[out + k] = total
        largest = max(largest, abs(f[NODES + k]))
        row += width
    return largest


@compiled
def part(f: Array, q: Counts, series: tuple[int, int], span: tuple[float, float], out: int) -> float:
    """The series on ``[low, high]`` as one on ``[-1, 1]``, with its whole degree; its largest value at the nodes."""
    (c, n), (low, high) = series, span
    half, inner = 0.5 * (high - low), q[INNER] + n * (q[DEGREE] + 1)
    for j in range(n + 1):
        f[NODES + j] = value(f, c, n, low + half * (f[inner + j] + 1.0))
    return fitted(f, q, n, out)


@compiled
def short_part(f: Array, q: Counts, series: tuple[int, int], span: tuple[float, float], out: int) -> int:
    """The part of a series without coefficients that are rounding, and its degree; ``out`` may be the series itself."""
    return trimmed(f, out, series[1], NOISE * part(f, q, series, span, out))


@compiled
def direction(f: Array, c: int, n: int) -> int:
    """1 or -1 where the function certainly rises or falls on all of ``[-1, 1]``, else 0."""
    above, here, rest = 0.0, 0.0, 0.0
    for k in range(n, 0, -1):
        above, here = here, above + 2.0 * k * f[c + k]
        if k > 1:
            rest += abs(here)
    first = 0.5 * here
    if abs(first) < rest or first == 0.0:
        return 0
    return 1 if first > 0.0 else -1


@compiled
def differentiated(f: Array, c: int, n: int, out: int) -> int:
    """The derivative, and its degree."""
    above, here = 0.0, 0.0
    for k in range(n, 0, -1):
        above, here = here, above + 2.0 * k * f[c + k]
        f[out + k - 1] = here
    if n == 0:
        f[out] = 0.0
        return 0
    f[out] *= 0.5
    return n - 1


@compiled
def mean(f: Array, c: int, n: int) -> float:
    """Mean over ``[-1, 1]``."""
    total = 0.0
    for k in range(0, n + 1, 2):
        total += f[c + k] / (1.0 - float(k) * float(k))
    return total


@inlined
def product(f: Array, q: Counts, first: tuple[int, int], second: tuple[int, int]) -> float:
    """Integral of the product of two series over ``[-1, 1]``."""
    (c, n), (d, m), total = first, second, 0.0
    row, width = q[PRODUCTS], q[DEGREE] + 1
    for i in range(n + 1):
        sum_ = 0.0
        for j in range(i & 1, m + 1, 2):
            sum_ += f[row + j] * f[d + j]
        total += f[c + i] * sum_
        row += width
    return total

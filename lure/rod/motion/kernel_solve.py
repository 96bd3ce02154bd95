r"""One piece of the equation ``zeta' + s zeta = h`` on ``[-1, 1]`` in compiled code.

With ``zeta = sum z_k T_k`` the integrated equation reads ``2 k z_k + s (z_{k-1} - z_{k+1}) = h_{k-1} - h_{k+1}``
(``z_0``, ``h_0`` twice for ``k = 1``): tridiagonal, with the start as one more row.  A residual that vanishes at 1 is
left in the last row, ``U_n - (n+1)/n U_{n-1}``, which adds ``s (n+1)/n`` to the diagonal: at ``s -> inf`` the solution
takes the value ``h/s`` at the right end.  Elimination from the last row up has pivots ``2 k + s^2/(next pivot) > 0``,
and the work is proportional to the degree.
"""

from __future__ import annotations

from lure.rod.motion.chebyshev import Array
from lure.rod.motion.jit import compiled, inlined
from lure.rod.motion.kernel_data import DEGREE, FREE, PIVOT, RIGHT, UNIT, Counts

_SMALL = 1e-19


@inlined
def integrated(f: Array, q: Counts, load: tuple[int, int], out: int) -> int:
    """The quadrature from -1, ``s = 0``; the degree, one more than that of ``h`` if there is room."""
    h, n = load
    total, sign, m = 0.0, -1.0, min(n + 1, q[DEGREE])
    for k in range(1, m + 1):
        z = 2.0 * f[h] if k == 1 else f[h + k - 1]
        if k + 1 <= n:
            z -= f[h + k + 1]
        z /= 2.0 * k
        total += sign * z
        sign = -sign
        f[out + k] = z
    f[out] = -total
    return int(m)


@compiled
def relaxed(f: Array, q: Counts, load: tuple[int, int], problem: tuple[float, float], out: int) -> int:
    """The solution for ``s > 0`` from a start; its degree is that of ``h`` and what the exponential needs."""
    (h, n), (s, start), most = load, problem, q[DEGREE]
    m, term, j = n + 1, 1.0, 0
    while term > _SMALL and m < most:
        j += 1
        m += 1
        term *= s / (2.0 * j)
    m = min(m, most)
    for k in range(m, 0, -1):
        right = 0.0
        if k - 1 <= n:
            right = 2.0 * f[h] if k == 1 else f[h + k - 1]
        if k + 1 <= n:
            right -= f[h + k + 1]
        if k == m:
            f[PIVOT + k] = 2.0 * k + s * (k + 1.0) / k
            f[RIGHT + k] = right + ((k + 1.0) / k * f[h + k] if k <= n else 0.0)
        else:
            share = s / f[PIVOT + k + 1]
            f[PIVOT + k] = 2.0 * k + s * share
            f[RIGHT + k] = right + share * f[RIGHT + k + 1]
    free, unit, free_sum, unit_sum, sign = 0.0, 2.0, 0.0, 1.0, -1.0
    for k in range(1, m + 1):
        free = (f[RIGHT + k] - s * free) / f[PIVOT + k]
        unit = -s * unit / f[PIVOT + k]
        f[FREE + k], f[UNIT + k] = free, unit
        free_sum += sign * free
        unit_sum += sign * unit
        sign = -sign
    first = (start - free_sum) / unit_sum
    f[out] = first
    for k in range(1, m + 1):
        f[out + k] = f[FREE + k] + first * f[UNIT + k]
    return int(m)

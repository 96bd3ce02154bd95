"""Values of a state-space block with an error that is known: residuals to the last digit, errors of second order."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

from lure.arrays import Complexes, Reals, np

_UNIT = sys.float_info.epsilon
_SPLIT = 134217729.0  # 2^27 + 1 cuts a double into two halves whose products are exact (Dekker 1971)


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    r"""``H(i omega) = C (i omega - A)^{-1} B + D`` of a block whose resolvent is only known approximately.

    With approximate ``x = (i omega - A)^{-1} B`` and ``y^T = C (i omega - A)^{-1}``, the residuals
    ``r = B - (i omega - A) x`` and ``q^T = C - y^T (i omega - A)`` obey exactly

    .. math:: H(i\omega) = C x + y^T r + q^T (i\omega - A)^{-1} r + D.

    The residuals are sums of products of doubles, formed without error and rounded once, so that ``C x + y^T r + D``
    misses ``H`` by the last term alone: the product of the relative errors of ``x`` and ``y``.  Without this, a mode
    with damping ``gamma`` spoils ``H`` near its resonance by ``eps |A| / gamma``.

    Attributes
    ----------
    A, B, C : ndarray
        Shapes ``(n, n)``, ``(n,)``, ``(n,)``.
    direct : float
        ``D``.
    solve, adjoint : callable
        ``(omega, v) -> (i omega - A)^{-1} v`` and ``-> (i omega - A)^{-T} v``, approximately.
    """

    A: Reals
    B: Reals
    C: Reals
    direct: float
    solve: Callable[[float, Complexes], Complexes]
    adjoint: Callable[[float, Complexes], Complexes]

    def response(self, omega: float) -> tuple[complex, float]:
        """``H(i omega)`` and a bound on its error; the error is infinite where nothing can be said.

        The bound is twice the last term of the identity, as computed, and the rounding of the sum.

        Parameters
        ----------
        omega : float
            Frequency [rad/s].
        """
        with np.errstate(all="ignore"):
            x, y = self.solve(omega, self.B.astype(complex)), self.adjoint(omega, self.C.astype(complex))
            if not (np.isfinite(x).all() and np.isfinite(y).all()):
                return complex(math.nan, math.nan), math.inf
            r, q = _residual(self.A, self.B, omega, x), _residual(self.A.T, self.C, omega, y)
            further = self.solve(omega, r)
            value = complex(exact_dot(self.C, x.real), exact_dot(self.C, x.imag)) + complex(y @ r) + self.direct
            last = 2.0 * float(np.abs(q) @ np.abs(further))
            rounding = 4.0 * _UNIT * (abs(value) + abs(self.direct) + y.size * float(np.abs(y) @ np.abs(r)))
        error = last + rounding
        return value, error if math.isfinite(error) else math.inf


def exact_dot(one: Reals, other: Reals) -> float:
    """The scalar product of two vectors of doubles, rounded once; nan where a product leaves their range.

    Parameters
    ----------
    one, other : ndarray
        Shape ``(n,)`` each.
    """
    return _sum(np.concatenate(_products(one, other)))


def _residual(A: Reals, b: Reals, omega: float, x: Complexes) -> Complexes:
    """``b - (i omega - A) x``, each part rounded once."""
    real, imag = x.real, x.imag
    parts = []
    for here, other, sign, start in ((real, imag, 1.0, b), (imag, real, -1.0, np.zeros_like(b))):
        products = np.concatenate([*_products(A, here[None, :])], axis=1)
        turned = _products(np.full_like(other, sign * omega), other)
        terms = np.column_stack([products, *turned, start])
        parts.append(np.array([_sum(row) for row in terms]))
    return parts[0] + 1j * parts[1]


def _products(one: Reals, other: Reals) -> tuple[Reals, Reals]:
    """``one * other`` as two doubles each, their sum exact."""
    product = one * other
    (a, low_a), (b, low_b) = _halves(one), _halves(other)
    return product, ((a * b - product) + a * low_b + low_a * b) + low_a * low_b


def _halves(values: Reals) -> tuple[Reals, Reals]:
    scaled = _SPLIT * values
    high = scaled - (scaled - values)
    return high, values - high


def _sum(values: Reals) -> float:
    try:
        return math.fsum(values)
    except (OverflowError, ValueError):
        return math.nan

r"""The Popov expression of the rod and of its schemes, bounded over all frequencies in ball arithmetic.

With ``q^{2N} = r e^{-i psi}`` on the imaginary axis (``r = 1``, ``psi = 2 omega T`` for the rod itself),

.. math::

    \mathrm{Re}[(1 + i\omega\theta) H] = d\,T\,F, \qquad
    F = \frac{2 a r\,g + \vartheta (1 - a^2 r^2)}{1 + a^2 r^2 + 2 a r \cos\psi}, \qquad
    g = \frac{\sin\psi}{\omega T}, \quad \vartheta = \theta / T .

``psi`` runs over ``[0, N pi)``; three facts, proved in ``notebooks/notes/0004-popov-for-the-rod.md``, reduce every
question to ``[0, 2 pi]``: wherever ``F < vartheta`` (``vartheta >= 0``), ``F`` falls as ``r`` or ``1/omega`` grows (the
latter for ``a sin psi <= 0``), and flipping the sign of a positive ``a sin psi`` lowers it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from analysis.minimum import Minimum, minimum
from analysis.precision import ball
from lure.rod import Rod

RELATIVE_WIDTH = "1e-10"


@dataclass(frozen=True, kw_only=True, slots=True)
class Ring:
    """The rod (``cells=None``) or its scheme, in balls; ``0 < k < inf``.

    Attributes
    ----------
    sign : int
        Sign of ``a``, decided exactly: -1 for ``k < Z``, 0 for ``k = Z``, 1 for ``k > Z``.
    size : arb
        ``|a|``.
    defect : arb
        ``1 - |a| = 2 min(k, Z)/(k + Z)``, free of cancellation.
    mobility, travel_time : arb
        ``d`` [m/(Pa s)] and ``T`` [s].
    cells : int or None
        ``N``.
    """

    sign: int
    size: arb
    defect: arb
    mobility: arb
    travel_time: arb
    cells: int | None

    @classmethod
    def of(cls, rod: Rod, cells: int | None) -> Ring:
        """The ring of a rod with ``k > 0``, at the current working precision."""
        exact = rod.exact
        k, stiffness = exact["damping"], exact["density"] * exact["youngs_modulus"]
        excess = k * k - exact["area"] ** 2 * stiffness
        root = ball(stiffness).sqrt()
        Z, damping = ball(exact["area"]) * root, ball(k)
        least = Z if excess > 0 else damping
        return cls(
            sign=(excess > 0) - (excess < 0),
            size=abs(ball(excess)) / (damping + Z) ** 2,
            defect=2 * least / (damping + Z),
            mobility=1 / root,
            travel_time=ball(exact["length"]) * ball(exact["density"]).sqrt() / ball(exact["youngs_modulus"]).sqrt(),
            cells=cells,
        )

    @property
    def scale(self) -> arb:
        """``d T`` [m/Pa], the unit of ``F``."""
        return self.mobility * self.travel_time

    @property
    def one_minus_square(self) -> arb:
        """``1 - a^2``."""
        return self.defect * (1 + self.size)

    @property
    def last_angle(self) -> arb:
        """End of the interval of ``psi`` that decides: ``2 pi``, or ``pi`` for ``N = 1``."""
        return arb.pi() if self.cells == 1 else 2 * arb.pi()

    def frequency(self, psi: arb) -> float:
        """``omega`` [rad/s] at the angle ``psi``; ``inf`` at the end of the range of a scheme."""
        if self.cells is None:
            return float(psi / (2 * self.travel_time))
        phi = psi / (2 * self.cells)
        if not phi.cos() > 0:
            return math.inf
        return float(self.cells * phi.tan() / self.travel_time)

    def parts(self, psi: arb) -> tuple[arb, arb, arb, arb]:
        """``r``, ``dr/dpsi``, ``g`` and ``dg/dpsi`` on ``0 <= psi <= 2 pi`` (a ball may stick out below zero)."""
        sine, cosine = psi.sin_cos()
        near_zero = bool(psi.lower() <= 0) and bool(psi.upper() < 1)
        # |sinc'(psi)| <= psi/3 there; the derivative of phi cot phi lies in [-phi, 0] for 0 <= phi <= 1
        sinc, dsinc = psi.sinc(), (-psi.upper() / 3).union(arb(0)) if near_zero else (cosine - psi.sinc()) / psi
        if self.cells is None:
            return arb(1), arb(0), 2 * sinc, 2 * dsinc
        N = self.cells
        phi = psi / (2 * N)
        s, c = phi.sin_cos()
        ratio = c / phi.sinc()
        dratio = (-phi.upper()).union(arb(0)) if near_zero else (c * s - phi) / (s * s)
        return c ** (2 * N), -(c ** (2 * N - 1)) * s, 2 * sinc * ratio, 2 * dsinc * ratio + sinc * dratio / N

    def denominator(self, psi: arb, r: arb) -> arb:
        """``1 + a^2 r^2 + 2 a r cos psi`` as a sum of squares, with no cancellation near ``|a| r = 1``."""
        half = psi / 2
        wave = half.cos() if self.sign > 0 else half.sin()
        return self.gap(r) ** 2 + 4 * self.size * r * wave * wave

    def gap(self, r: arb) -> arb:
        """``1 - |a| r``."""
        return self.defect + self.size * (1 - r)


def popov_minimum(ring: Ring, multiplier: arb) -> Minimum:
    """Bracket on ``inf F`` over all frequencies for ``vartheta = multiplier >= 0``, and the angle where it lies.

    For a scheme the limit ``omega -> inf`` is ``F = vartheta``; it enters the bracket as an upper bound.
    """
    a = ring.sign * ring.size
    if ring.sign == 0:
        return Minimum(low=multiplier.lower(), high=multiplier.upper(), where=arb(0), closed=True)
    if ring.sign > 0 and ring.cells == 1 and multiplier == 0:
        # sin psi >= 0 on [0, pi]: F >= 0, and F -> 0 at the end
        return Minimum(low=arb(0), high=arb(0), where=ring.last_angle, closed=True)
    at_zero = multiplier * ring.one_minus_square - 4 * ring.size
    if ring.sign < 0 and at_zero <= 0:
        # numerator >= at_zero and denominator >= (1 - |a|)^2 wherever F < 0, both attained at psi = 0
        least = at_zero / ring.defect**2
        return Minimum(low=least.lower(), high=least.upper(), where=arb(0), closed=True)

    def value(psi: arb) -> arb:
        r, _, g, _ = ring.parts(psi)
        numerator = 2 * a * r * g + multiplier * ring.gap(r) * (1 + ring.size * r)
        return numerator / ring.denominator(psi, r)

    def slope(psi: arb) -> arb:
        r, dr, g, dg = ring.parts(psi)
        sine, cosine = psi.sin_cos()
        d_numerator = 2 * a * (dr * g + r * dg) - 2 * multiplier * a * a * r * dr
        d_denominator = 2 * a * a * r * dr + 2 * a * dr * cosine - 2 * a * r * sine
        return (d_numerator - value(psi) * d_denominator) / ring.denominator(psi, r)

    found = minimum(value, slope, arb(0), ring.last_angle, width=lambda best: abs(best) * arb(RELATIVE_WIDTH))
    if ring.cells is not None and multiplier <= found.low:
        return Minimum(low=multiplier.lower(), high=multiplier.upper(), where=ring.last_angle, closed=True)
    return found


def smallest_multiplier(ring: Ring, ease: arb) -> Minimum:
    """Bracket on the negative of the smallest ``vartheta >= 0`` that works, for ``ease = 1/(d T k_upper)``.

    ``vartheta`` works at an angle iff it exceeds ``G = -(ease D + 2 a r g)/(1 - a^2 r^2)`` there; the result brackets
    ``min(0, inf -G)``.  For ``a < 0`` the supremum lies at ``omega = 0``, for every ``N`` and for the rod; for ``a > 0`` a
    positive supremum lies in ``(pi, 2 pi)``.
    """
    a = ring.sign * ring.size
    if ring.sign == 0 or (ring.sign > 0 and ring.cells == 1):
        return Minimum(low=arb(0), high=arb(0), where=arb(0), closed=True)
    if ring.sign < 0:
        needed = (4 * ring.size - ease * ring.defect**2) / ring.one_minus_square
        return _clipped(Minimum(low=(-needed).lower(), high=(-needed).upper(), where=arb(0), closed=True))

    def value(psi: arb) -> arb:
        r, _, g, _ = ring.parts(psi)
        return (ease * ring.denominator(psi, r) + 2 * a * r * g) / (ring.gap(r) * (1 + ring.size * r))

    def slope(psi: arb) -> arb:
        r, dr, g, dg = ring.parts(psi)
        sine, cosine = psi.sin_cos()
        d_denominator = 2 * a * a * r * dr + 2 * a * dr * cosine - 2 * a * r * sine
        d_top = ease * d_denominator + 2 * a * (dr * g + r * dg)
        return (d_top + 2 * a * a * r * dr * value(psi)) / (ring.gap(r) * (1 + ring.size * r))

    def width(best: arb) -> arb:
        return abs(best) * arb(RELATIVE_WIDTH) + (ease + 1) * arb("1e-25")

    return _clipped(minimum(value, slope, arb.pi(), 2 * arb.pi(), width=width))


def _clipped(found: Minimum) -> Minimum:
    zero = arb(0)
    low = found.low if found.low < 0 else zero
    high = found.high if found.high < 0 else zero
    return Minimum(low=low, high=high, where=found.where, closed=found.closed)


def precision_for(rod: Rod, cells: int | None) -> int:
    """Bits that leave about 100 good ones after the cancellations near ``|a| = 1`` and for many cells."""
    impedance = Fraction(rod.impedance)
    ratio = abs(math.log2(abs(rod.exact["damping"] / impedance))) if rod.exact["damping"] else 0.0
    return min(4096, 128 + 4 * math.ceil(ratio) + 2 * (cells or 1).bit_length())

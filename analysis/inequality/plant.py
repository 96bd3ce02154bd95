"""A rational block made ready for exact criteria: its polynomials, its poles, its values on the frequency axis."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Literal

from flint import fmpq, fmpq_poly

from lure.analysis.numerics.polynomial import (
    RootCounts,
    X,
    even_odd,
    from_descending,
    root_counts,
    to_fmpq,
    to_fraction,
)
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Case = Literal["stable", "critical", "unstable"]


@described(frozen=True, slots=True)
class Response:
    """``Re H(i w) = U(x)/D(x)`` and ``-w Im H(i w) = W(x)/D(x)`` with ``x = w^2``, common powers of ``x`` divided out.

    ``D > 0`` on ``(0, inf)`` except at poles on the axis; in the critical case ``D(0) > 0`` too.
    """

    D: fmpq_poly = quantity("Denominator")
    U: fmpq_poly = quantity("Numerator of ``Re H``")
    W: fmpq_poly = quantity("Numerator of ``-w Im H``")


@described(frozen=True)
class TransferPolynomials:
    r"""``H = n/d`` in continuous time, exact; a discrete-time block is mapped by ``z = (1 + s)/(1 - s)``.

    The map takes the unit disc to the left half-plane and the unit circle to the imaginary axis, ``z = 1`` to 0 and
    ``z = -1`` to infinity; stability, gains and the circle criterion carry over, multipliers in ``s`` do not.
    """

    block: RationalPlant = quantity("The block as given")
    n: fmpq_poly = quantity("Numerator, common factors kept")
    d: fmpq_poly = quantity("Denominator, common factors kept")
    hidden: fmpq_poly = quantity("Their greatest common divisor: modes that input or output does not see")
    degree: int = quantity(
        "Degree ``d`` would have; less than that, it has poles at infinity (discrete time: at ``z = -1``)"
    )

    @classmethod
    def of(cls, block: RationalPlant) -> TransferPolynomials:
        """The plant of a block; those of the blocks asked about last are at hand."""
        return _of(block)

    @property
    def visible(self) -> TransferPolynomials:
        """The plant without its hidden modes."""
        h = self.hidden
        if h.degree() == 0:
            return self
        return TransferPolynomials(self.block, self.n // h, self.d // h, h // h, self.degree - h.degree())

    @property
    def discrete(self) -> bool:
        """Whether the block is in discrete time."""
        return self.block.dt is not None

    @cached_property
    def poles(self) -> RootCounts:
        """Poles left of, on and right of the axis (inside, on, outside the circle), hidden modes included."""
        return closed_loop_poles(self, Fraction(0))

    @cached_property
    def case(self) -> Case:
        """``stable``; ``critical``: one simple pole at 0 (``z = 1``), the others stable; ``unstable``: any other."""
        poles = self.poles
        if poles.right == 0 and poles.axis == 0:
            return "stable"
        at_zero = self.d.degree() == self.degree and self.d[0] == 0
        return "critical" if poles.right == 0 and poles.axis == 1 and at_zero else "unstable"

    @property
    def residue(self) -> Fraction:
        """Residue of ``H`` at a simple pole ``s = 0``; in discrete time of the mapped ``H``."""
        return to_fraction(self.n[0] / self.d[1])

    def shifted(self, k: Fraction) -> TransferPolynomials:
        """The block ``n / (d + k n)`` of the same loop for ``phi - k sigma``: ``[k, K]`` turns into ``[0, K - k]``."""
        if k == 0:
            return self
        d = self.d + to_fmpq(k) * self.n
        return TransferPolynomials(self.block, self.n, d, self.n.gcd(d) if self.n.degree() >= 0 else d, self.degree)

    @cached_property
    def response(self) -> Response:
        """The response on the axis as polynomials in ``x = w^2``."""
        ne, no = even_odd(self.n)
        de, do = even_odd(self.d)
        D = de * de + X * do * do
        U = ne * de + X * no * do
        W = X * (ne * do - no * de)
        while D.degree() > 0 and D[0] == 0 and U[0] == 0 and W[0] == 0:
            D, U, W = D // X, U // X, W // X
        return Response(D, U, W)

    def frequency(self, omega: float) -> float:
        """Frequency of the block [rad/s; rad per sample] at ``omega`` of the mapped one."""
        return 2 * math.atan(omega) if self.discrete else omega


@lru_cache(maxsize=16)
def _of(block: RationalPlant) -> TransferPolynomials:
    n, d = from_descending(block.numerator), from_descending(block.denominator)
    if block.dt is not None:
        n, d = bilinear(n, block.order), bilinear(d, block.order)
    return TransferPolynomials(block, n, d, n.gcd(d) if n.degree() >= 0 else d, block.order)


@lru_cache(maxsize=4096)
def _counts(coefficients: tuple[fmpq, ...]) -> RootCounts:
    return root_counts(fmpq_poly(list(coefficients)))


def closed_loop_poles(plant: TransferPolynomials, k: Fraction) -> RootCounts:
    """Exact count of the roots of ``d + k n``; those at infinity (``z = -1``; ``1 + k D = 0``) count as on the axis."""
    p = plant.d + to_fmpq(k) * plant.n
    if p.degree() < 0:
        return RootCounts(0, plant.degree, 0)
    found = _counts(tuple(p.coeffs()))
    return RootCounts(found.left, found.axis + plant.degree - p.degree(), found.right)


def bilinear(p: fmpq_poly, degree: int) -> fmpq_poly:
    """``(1 - s)^degree p((1 + s)/(1 - s))``."""
    up, down = fmpq_poly([1, 1]), fmpq_poly([1, -1])
    result = fmpq_poly([])
    for i, c in enumerate(p.coeffs()):
        result += c * up**i * down ** (degree - i)
    return result

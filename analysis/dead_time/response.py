r"""``Re H`` and ``-w Im H`` of a block with dead time, on balls and power series, with a bound for high frequencies.

With ``n_j conj(d) = a_j + i w b_j`` on the axis, ``c_j = cos w T_j`` and ``s_j = sin w T_j``,

.. math:: \mathrm{Re} H = \sum_j (a_j c_j + \omega b_j s_j)/|d|^2, \qquad
          -\omega \mathrm{Im} H = \sum_j (\omega a_j s_j - \omega^2 b_j c_j)/|d|^2 .

For a simple pole at 0, ``d = s d_1``, both are finite at 0: with ``a_j``, ``b_j`` those of ``d_1``,

.. math:: \mathrm{Re} H = \sum_j (b_j c_j - a_j s_j/\omega)/|d_1|^2, \qquad
          -\omega \mathrm{Im} H = \sum_j (a_j c_j + \omega b_j s_j)/|d_1|^2 .
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from flint import acb, arb, arb_series, fmpq_poly

from analysis.polynomial import X, even_odd, from_descending, root_counts
from analysis.precision import ball
from lure.delay import DelayBlock
from lure.errors import AssumptionError

Number = TypeVar("Number", arb, arb_series)


@dataclass(frozen=True, slots=True)
class _Term:
    delay: Fraction
    a: fmpq_poly
    b: fmpq_poly
    top: fmpq_poly


@dataclass(frozen=True, slots=True)
class DelayResponse:
    """The response on the axis of a strictly proper block that is stable or has one simple pole at 0 besides.

    Attributes
    ----------
    terms : tuple
        One for each delay.
    size : fmpq_poly
        ``|d|^2`` (or ``|d_1|^2``) in ``x = w^2``, positive for ``x >= 0``.
    bottom : fmpq_poly
        ``d``.
    critical : bool
        Whether ``d`` has the root 0.
    """

    terms: tuple[_Term, ...]
    size: fmpq_poly
    bottom: fmpq_poly
    critical: bool

    @classmethod
    def of(cls, block: DelayBlock) -> DelayResponse:
        """The response of a block.

        Raises
        ------
        AssumptionError
            A pole is unstable or a multiple or other root on the axis, or a term with dead time is not strictly proper.
        """
        bottom = from_descending(block.denominator)
        counts = root_counts(bottom)
        critical = counts.axis == 1 and bottom[0] == 0
        if counts.right or (counts.axis and not critical):
            raise AssumptionError(
                f"the block {block} has poles that are not stable ({counts.right} to the right of the axis, "
                f"{counts.axis} on it); with dead time only stable blocks, "
                "or a simple pole at 0 besides, are covered: stabilise it by a loop around it first"
            )
        if any(len(top) == len(block.denominator) for _, top in block.terms):
            raise AssumptionError(
                f"the block {block} is not strictly proper; with dead time that is a neutral equation, which is not "
                "covered: add a fast pole to the model"
            )
        reduced = bottom // X if critical else bottom
        de, do = even_odd(reduced)
        terms = []
        for delay, top in block.terms:
            n = from_descending(top)
            ne, no = even_odd(n)
            terms.append(_Term(delay, ne * de + X * no * do, no * de - ne * do, n))
        return cls(tuple(terms), de * de + X * do * do, bottom, critical)

    @property
    def residue(self) -> arb:
        """Residue at the pole 0."""
        return sum((arb(term.a[0]) for term in self.terms), arb(0)) / arb(self.size[0])

    def parts(self, omega: Number) -> tuple[Number, Number]:
        """``Re H`` and ``-w Im H`` at ``omega >= 0``."""
        x = omega * omega
        real: Number = 0 * omega
        slope: Number = 0 * omega
        for term in self.terms:
            a, b = _at(term.a, x), _at(term.b, x)
            angle = omega * ball(term.delay)
            c, s = angle.cos(), angle.sin()
            if self.critical:
                real += b * c - (a * ball(term.delay) * _sinc(angle) if term.delay else 0 * a)
                slope += a * c + omega * b * s
            else:
                real += a * c + omega * b * s
                slope += omega * a * s - x * b * c
        size = _at(self.size, x)
        return real / size, slope / size

    def tail(self, start: arb, theta: arb) -> arb:
        """A lower bound on ``Re[(1 + i w theta) H]`` for all ``w >= start``."""
        v = arb(0).union(1 / start)
        total = arb(0)
        degree = self.bottom.degree()
        below = _reversed_at(self.bottom, degree, v)
        for term in self.terms:
            value = _reversed_at(term.top, degree, v) / below
            slope = _reversed_at(term.top * X, degree, v) / below  # s n/d is proper: H is strictly so
            both = value + acb(theta) * slope
            total += both.real if term.delay == 0 else -both.abs_upper()
        return total.lower() if total.is_finite() else arb("-inf")  # the denominator may vanish on so wide a ball

    def magnitude(self, start: arb) -> arb:
        """An upper bound on ``|H|`` for all ``w >= start``."""
        v = arb(0).union(1 / start)
        degree = self.bottom.degree()
        below = _reversed_at(self.bottom, degree, v)
        return sum(((_reversed_at(term.top, degree, v) / below).abs_upper() for term in self.terms), arb(0)).upper()


def _at(p: fmpq_poly, x: Number) -> Number:
    total: Number = 0 * x
    for c in reversed(p.coeffs()):
        total = total * x + arb(c)
    return total


def _reversed_at(p: fmpq_poly, degree: int, v: arb) -> acb:
    """``p(s)/s^degree`` at ``s = i/v``: ``1/s = -i v``."""
    turn, total = acb(0, -1) * v, acb(0)
    for power in range(degree + 1):
        total = total * turn + (acb(arb(p[power])) if power <= p.degree() else acb(0))
    return total


def _sinc(x: Number) -> Number:
    return x.sinc() if isinstance(x, arb) else x.sin() / x

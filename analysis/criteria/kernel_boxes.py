"""The inequality of Zames and Falb in exact polynomials, and its proof on bounded intervals by balls."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeVar

from flint import acb, acb_poly, arb, arb_poly, fmpq, fmpq_poly

from analysis.criteria.kernels import Delay, Gamma, Multiplier
from analysis.plant import Plant
from analysis.polynomial import X, even_odd, to_fmpq
from analysis.precision import ball, working_precision

Ball = TypeVar("Ball", arb, acb)
BITS = 128
ORDER = 6
_MIRROR = fmpq_poly([0, -1])


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """What was found: ``holds`` is a proof; else ``where`` is a frequency where it fails or stays open [rad/s]."""

    holds: bool
    where: float | None = None


@dataclass(frozen=True, slots=True)
class Inequality:
    r"""The inequality times ``k |d|^2 E > 0`` on the axis, in exact polynomials.

    ``T(w) = A(w^2) - Re[q(w) Psi(i w)]`` with ``q = sum c_j exp(-i w tau_j)`` over the delays and
    ``Psi(s) = E(s) (k n + d)(s) d(-s)``; ``E`` clears the denominators of the gamma kernels, which are in ``A``.

    Attributes
    ----------
    A : fmpq_poly
        In ``x = w^2``.
    psi : fmpq_poly
        In ``s``.
    delays : tuple of (Fraction, Fraction)
        Coefficients ``c_j`` and delays ``tau_j`` [s].
    full : int
        Degree of ``k |d|^2 E`` in ``x``: ``T`` divided by it stays away from 0 at infinity only if ``A`` has it too.
    """

    A: fmpq_poly
    psi: fmpq_poly
    delays: tuple[tuple[Fraction, Fraction], ...]
    full: int

    @classmethod
    def of(cls, plant: Plant, k: Fraction, multiplier: Multiplier, floor: Fraction) -> Inequality:
        """The inequality ``... >= floor`` for ``H = n/d`` with ``d`` Hurwitz and slopes in ``[0, k]``."""
        gain, n, d = to_fmpq(k), plant.n, plant.d
        gammas = [(c, g) for c, g in multiplier.terms if isinstance(g, Gamma)]
        orders: dict[Fraction, int] = {}
        for _, g in gammas:
            orders[g.rate] = max(orders.get(g.rate, 0), g.order)
        E = fmpq_poly([1])
        for rate, order in orders.items():
            E *= fmpq_poly([to_fmpq(rate) ** 2, 0, -1]) ** order
        rational = E
        for c, g in gammas:
            a = to_fmpq(g.rate)
            factor = fmpq_poly([a, 1 if g.side == "causal" else -1]) ** g.order
            rational -= to_fmpq(c) * a**g.order * (E // factor)
        mirrored = d(_MIRROR)
        psi = (gain * n + d) * mirrored
        total = rational * psi + (to_fmpq(multiplier.theta) * X * n - to_fmpq(floor) * d) * gain * E * mirrored
        delays = tuple((c, g.delay) for c, g in multiplier.terms if isinstance(g, Delay) and c != 0)
        return cls(even_odd(total)[0], E * psi, delays, d.degree() + E.degree() // 2)


class TaylorBound:
    """``T`` on boxes in ``w``: its Taylor polynomial at the midpoint and a bound on the rest, in ball arithmetic."""

    def __init__(self, inequality: Inequality) -> None:
        in_omega = [fmpq(0)] * (2 * inequality.A.degree() + 1)
        in_omega[0::2] = inequality.A.coeffs()
        self.real = arb_poly(in_omega)
        turned = [arb(c * (1, 1, -1, -1)[i % 4]) for i, c in enumerate(inequality.psi.coeffs())]
        self.psi = acb_poly([acb(0, c) if i % 2 else acb(c) for i, c in enumerate(turned)])
        self.delays = [(ball(c), ball(tau)) for c, tau in inequality.delays]

    def expansion(self, middle: arb, radius: arb) -> tuple[list[arb], arb]:
        """``T_j`` for ``j < ORDER`` and ``R``: ``|T(middle + u radius) - sum T_j u^j| <= R`` for ``-1 <= u <= 1``."""
        real = _padded(self.real(arb_poly([middle, radius])).coeffs(), arb(0))
        psi = _padded(self.psi(acb_poly([acb(middle), acb(radius)])).coeffs(), acb(0))
        waves, rest = self._waves(middle, radius)
        terms = [real[j] - sum((waves[i] * psi[j - i] for i in range(j + 1)), acb(0)).real for j in range(ORDER)]
        sizes, heights = [abs(wave) for wave in waves], [abs(value) for value in psi]
        beyond = _total(abs(value) for value in real[ORDER:])
        beyond += _total(sizes[i] * heights[j] for i in range(ORDER) for j in range(ORDER - i, ORDER))
        beyond += _total(sizes) * _total(heights[ORDER:]) + rest * _total(heights)
        return terms, beyond

    def _waves(self, middle: arb, radius: arb) -> tuple[list[acb], arb]:
        """The same for ``q``."""
        waves, rest = [acb(0)] * ORDER, arb(0)
        for c, tau in self.delays:
            sine, cosine = (middle * tau).sin_cos()
            term, step = c * acb(cosine, -sine), acb(0, -tau * radius)
            for power in range(ORDER):
                waves[power] += term
                term *= step / (power + 1)
            rest += abs(term)
        return waves, rest


def positive_on(inequality: Inequality, intervals: list[tuple[arb, arb]], boxes: int) -> Check:
    """Whether ``T > 0`` on intervals of ``w``, by at most ``boxes`` boxes.

    Parameters
    ----------
    inequality : Inequality
        ``T``.
    intervals : list of (arb, arb)
        Ends [rad/s]; a ball stands for every end in it.
    boxes : int
        Number of boxes after which the proof is given up.
    """
    with working_precision(BITS + 4 * inequality.psi.degree()):
        function = TaylorBound(inequality)
        waiting = list(intervals)
        for _ in range(boxes):
            if not waiting:
                return Check(holds=True)
            low, high = waiting.pop()
            box = low.union(high)
            middle = box.mid()
            terms, beyond = function.expansion(middle, (box - middle).abs_upper())
            if not terms[0] > 0:
                return Check(holds=False, where=float(middle))
            beyond += _total(abs(term) for term in terms[3:])
            straight = terms[0] - abs(terms[1]) - (abs(terms[2]) if not terms[2] > 0 else 0)
            if straight > beyond or (terms[2] > 0 and terms[0] - terms[1] ** 2 / (4 * terms[2]) > beyond):
                continue
            waiting += [(low, middle), (middle, high)]
        return Check(holds=not waiting, where=float(waiting[-1][0]) if waiting else None)


def _total(values: Iterable[arb]) -> arb:
    return sum(values, arb(0))


def _padded(values: list[Ball], zero: Ball) -> list[Ball]:
    return values + [zero] * (ORDER - len(values))

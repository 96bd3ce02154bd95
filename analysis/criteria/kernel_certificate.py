"""Whether a multiplier of Zames and Falb proves one slope: decided at every frequency, without a grid."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

from flint import acb, acb_poly, arb, fmpq_poly

from analysis.criteria.kernel_boxes import BITS, Check, Inequality, positive_on
from analysis.criteria.kernels import Delay, Multiplier
from analysis.evidence import Bracket
from analysis.plant import Plant
from analysis.polynomial import (
    X,
    even_odd,
    exact_midpoint,
    positive_from_zero,
    positive_root_count,
    real_roots,
    to_fmpq,
)
from analysis.precision import ball, outward, working_precision

MAX_BOXES = 5_000
SHARES = (Fraction(999, 1000), Fraction(9, 10), Fraction(1, 2), Fraction(1, 10))


def check(
    plant: Plant, k: Fraction, multiplier: Multiplier, *, floor: Fraction = Fraction(0), boxes: int = MAX_BOXES
) -> Check:
    r"""Whether ``Re[M(iw)(H(iw) + 1/k) + i w theta H(iw)] >= floor + eps``, some ``eps > 0``, for every real ``w``.

    Without delays this is a sign test on a polynomial in ``w^2``, exact.  With delays of total mass ``Q`` it follows
    from ``A(x) > 0`` and ``A(x)^2 > Q^2 |Psi|^2`` wherever these polynomial inequalities hold, in particular for all
    large ``w``; what is left over, a few bounded intervals, is covered by boxes on which a Taylor bound in ball
    arithmetic is positive.

    Parameters
    ----------
    plant : Plant
        ``H = n/d`` in continuous time, ``d`` Hurwitz (not checked here).
    k : Fraction
        Upper slope, positive [unit of mu / unit of sigma].
    multiplier : Multiplier
        Its admissibility is not checked here.
    floor : Fraction
        What the left-hand side is to exceed.
    boxes : int
        Number of boxes after which the search for a proof is given up.
    """
    inequality = Inequality.of(plant, k, multiplier, floor)
    A = inequality.A
    if A.degree() < inequality.full or not A[A.degree()] > 0:
        return Check(holds=False, where=math.inf)
    if not inequality.delays:
        return Check(holds=True) if positive_from_zero(A) else Check(holds=False, where=_first_failure(A))
    mass = to_fmpq(sum((abs(c) for c, _ in inequality.delays), Fraction(0)))
    even, odd = even_odd(inequality.psi)
    bound = A * A - mass**2 * (even * even + X * odd * odd)
    if bound.degree() < 2 * inequality.full or not bound[bound.degree()] > 0:
        return Check(holds=False, where=math.inf)
    return positive_on(inequality, _open_intervals(A, bound), boxes)


def check_every(plant: Plant, multiplier: Multiplier) -> bool:
    r"""Whether the multiplier proves every finite slope, by ``Re[M H + i w theta H] >= 0`` without delays.

    Then ``Re M / k`` is left, for every ``k``: bounded away from 0 if ``sum |c_j| < 1``, and for ``sum |c_j| = 1`` too
    if some ``c_j < 0``, for ``|h_j^(iw)| < 1`` unless ``w = 0``.  If ``sum c_j = 1``, all positive, ``Re M`` vanishes
    at ``w = 0`` alone.  Multiplying all ``c_j`` by ``1 - delta`` adds ``delta Re[sum c_j h_j^ (H + 1/k)]``,
    near ``H(0) + 1/k`` around ``w = 0`` and small elsewhere, so that for each finite ``k`` a small enough ``delta > 0``
    leaves the sum bounded away from 0 provided that ``H(0) >= 0``.

    Parameters
    ----------
    plant : Plant
        ``H = n/d`` in continuous time, ``d`` Hurwitz and ``H(inf) >= 0`` (neither is checked here).
    multiplier : Multiplier
        Its admissibility is not checked here.
    """
    if any(isinstance(kernel, Delay) for _, kernel in multiplier.terms):
        return False
    signs_differ = any(c < 0 for c, _ in multiplier.terms)
    if not (multiplier.mass < 1 or signs_differ or plant.n[0] * plant.d[0] >= 0):
        return False
    one, two = (Inequality.of(plant, k, multiplier, Fraction(0)).A for k in (Fraction(1), Fraction(2)))
    return _nonnegative(two - one)


def value_at(plant: Plant, k: Fraction, multiplier: Multiplier, omega: Fraction) -> arb:
    """The left-hand side of :func:`check` at one frequency ``omega`` [rad/s], as a ball."""
    with working_precision(BITS):
        s = acb(0, ball(omega))
        top, bottom = (acb_poly([acb(arb(c)) for c in p.coeffs()])(s) for p in (plant.n, plant.d))
        H, M = top / bottom, acb(1)
        for c, kernel in multiplier.terms:
            if isinstance(kernel, Delay):
                M -= ball(c) * (-s * ball(kernel.delay)).exp()
            else:
                rate = ball(kernel.rate)
                M -= ball(c) * (rate / (rate + (s if kernel.side == "causal" else -s))) ** kernel.order
        return (M * (H + 1 / ball(k)) + s * ball(multiplier.theta) * H).real


def margin_near(plant: Plant, k: Fraction, multiplier: Multiplier, omega: Fraction) -> Bracket:
    """A bracket on the infimum of the left-hand side of an inequality that holds.

    Parameters
    ----------
    plant, k, multiplier
        As for :func:`check`, which has said yes.
    omega : Fraction
        A frequency near which it is least [rad/s]: it gives the upper end.  The lower end is proved by :func:`check`,
        and 0 if no share of the upper end could be.
    """
    high = value_at(plant, k, multiplier, omega)
    guess = Fraction(float(high.lower()))
    for share in SHARES:
        if guess > 0 and check(plant, k, multiplier, floor=share * guess).holds:
            return outward(ball(share * guess), high)
    return outward(ball(0), high)


def _nonnegative(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``."""
    if p.degree() < 0:
        return True
    odd = fmpq_poly([1])
    for factor, multiplicity in p.numer().factor_squarefree()[1]:
        if multiplicity % 2:
            odd *= fmpq_poly(factor)
    return bool(p[p.degree()] > 0) and positive_root_count(odd) == 0


def _first_failure(A: fmpq_poly) -> float:
    roots = [root for root in real_roots(A) if root > 0]
    return math.sqrt(float(roots[0])) if roots and A[0] > 0 else 0.0


def _open_intervals(A: fmpq_poly, bound: fmpq_poly) -> list[tuple[arb, arb]]:
    """Intervals of ``w >= 0``: outside of them ``A(w^2) > 0`` and ``bound(w^2) > 0``, given that both are far out."""
    ends = [arb(0)] + [root for root in real_roots(A * bound) if root > 0]
    found = [(end, end) for end in ends]
    for low, high in itertools.pairwise(ends):
        gap = exact_midpoint(high) - exact_midpoint(high.rad()) - exact_midpoint(low) - exact_midpoint(low.rad())
        between = to_fmpq(exact_midpoint(low) + exact_midpoint(low.rad()) + gap / 2)
        if not (A(between) > 0 and bound(between) > 0):
            found.append((low, high))
    return [(low.lower().sqrt().lower(), high.upper().sqrt().upper()) for low, high in found]

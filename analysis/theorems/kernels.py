"""Whether a multiplier of Zames and Falb proves one slope: decided at every frequency, without a grid."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeVar, cast

from flint import acb, acb_poly, arb, arb_series, fmpq, fmpq_poly

from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.minimum import at, minimum, nonnegative_from_zero, sinc
from lure.analysis.numerics.polynomial import (
    X,
    even_odd,
    exact_midpoint,
    positive_from_zero,
    real_roots,
    to_fmpq,
)
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Bracket
from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.record import described, quantity

# Multipliers of Zames and Falb with kernels whose L1 norm is known exactly, and the Popov term beside them.

Side = Literal["causal", "anticausal"]


@described(frozen=True, slots=True)
class Delay:
    r"""A unit mass at ``delay``: ``h(t) = delta(t - delay)``, ``h^(iw) = exp(-i w delay)``."""

    delay: Fraction = quantity("Positive: the multiplier looks back (causal); negative: it looks ahead [s].  Not zero")

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response, in floating point; ``omega`` in rad/s."""
        return np.asarray(np.exp(-1j * float(self.delay) * omega))

    def __str__(self) -> str:
        return f"exp({-float(self.delay):+.6g} s)"


@described(frozen=True, slots=True)
class Gamma:
    r"""A gamma density, nonnegative, of mass 1: ``h(t) = a^n t^(n-1) exp(-a t)/(n-1)!``, ``h^(s) = (a/(a + s))^n``."""

    rate: Fraction = quantity("``a > 0``", "1/s")
    order: int = quantity("``n >= 1``")
    side: Side = quantity("``anticausal`` mirrors it to ``t < 0``: ``h^(s) = (a/(a - s))^n``")

    def at(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response, in floating point; ``omega`` in rad/s."""
        sign = 1 if self.side == "causal" else -1
        return np.asarray((1 / (1 + sign * 1j * omega / float(self.rate))) ** self.order)

    def __str__(self) -> str:
        power = "" if self.order == 1 else f"^{self.order}"
        return f"({float(self.rate):.6g}/({float(self.rate):.6g} {'+' if self.side == 'causal' else '-'} s)){power}"


Kernel = Delay | Gamma


@described(frozen=True, slots=True)
class Multiplier:
    r"""``M(s) + theta s`` with ``M = 1 - sum_j c_j h_j^(s)``, every kernel ``h_j >= 0`` of mass 1.

    The L1 norm (total variation, where masses are) of ``sum c_j h_j`` is at most ``sum |c_j|``, with equality if no
    two terms of opposite sign overlap.
    """

    theta: Fraction = quantity("Weight of the Popov term, of either sign", "s")
    terms: tuple[tuple[Fraction, Kernel], ...] = quantity("Coefficients ``c_j`` and kernels ``h_j``")

    @property
    def mass(self) -> Fraction:
        """``sum |c_j|``, the bound on the L1 norm."""
        return sum((abs(c) for c, _ in self.terms), Fraction(0))

    def admissible(self, *, odd: bool) -> bool:
        """Whether the multiplier is legal: mass at most 1, and no negative coefficient unless ``phi`` is odd."""
        legal = all(
            kernel.delay != 0 if isinstance(kernel, Delay) else kernel.rate > 0 and kernel.order >= 1
            for _, kernel in self.terms
        )
        return legal and self.mass <= 1 and (odd or all(c >= 0 for c, _ in self.terms))

    def at(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """``M(i w)`` without the Popov term, in floating point; ``omega`` in rad/s."""
        points = np.asarray(omega, dtype=float)
        total = np.ones(points.shape, dtype=complex)
        for c, kernel in self.terms:
            total -= float(c) * kernel.at(points)
        return total

    def scaled(self, unit: Fraction) -> Multiplier:
        """The same multiplier when frequencies are multiplied by ``unit``: ``M(s / unit)``."""
        terms = tuple(
            (
                c,
                Delay(kernel.delay / unit)
                if isinstance(kernel, Delay)
                else Gamma(kernel.rate * unit, kernel.order, kernel.side),
            )
            for c, kernel in self.terms
        )
        return Multiplier(self.theta / unit, terms)

    def mirrored(self) -> Multiplier:
        """``M(-s) - theta s``: causal and anticausal exchanged, as for ``H(-s)``."""
        terms: list[tuple[Fraction, Kernel]] = []
        for c, kernel in self.terms:
            if isinstance(kernel, Delay):
                terms.append((c, Delay(-kernel.delay)))
            else:
                side: Side = "anticausal" if kernel.side == "causal" else "causal"
                terms.append((c, Gamma(kernel.rate, kernel.order, side)))
        return Multiplier(-self.theta, tuple(terms))

    def __str__(self) -> str:
        text = "1"
        for c, kernel in self.terms:
            text += f" {'-' if c > 0 else '+'} {abs(float(c)):.6g} {kernel}"
        if self.theta:
            text += f" {'+' if self.theta > 0 else '-'} {abs(float(self.theta)):.6g} s"
        return text

    def to_parameters(self) -> dict[str, object]:
        """Plain data with exact numbers as text ``p/q``; :func:`multiplier_of` reads them back."""
        return {"theta": str(self.theta), "kernels": [_written(c, kernel) for c, kernel in self.terms]}


def multiplier_of(parameters: Mapping[str, object]) -> Multiplier:
    """The multiplier written by :meth:`Multiplier.to_parameters`.

    Parameters
    ----------
    parameters : Mapping
        With ``theta`` and ``kernels``; other keys are left alone.

    Raises
    ------
    InputError
        A key is missing, or a value is not what it should be.
    """
    try:
        entries = [*cast("Iterable[Mapping[str, object]]", parameters["kernels"])]  # a TypeError is caught below
        return Multiplier(Fraction(str(parameters["theta"])), tuple(_read(entry) for entry in entries))
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        raise InputError(
            f"parameters are {dict(parameters)!r}; give theta as text p/q and kernels as a list of "
            "{coefficient, delay} or {coefficient, rate, order, side}"
        ) from None


def _written(c: Fraction, kernel: Kernel) -> dict[str, object]:
    if isinstance(kernel, Delay):
        return {"coefficient": str(c), "delay": str(kernel.delay)}
    return {"coefficient": str(c), "rate": str(kernel.rate), "order": kernel.order, "side": kernel.side}


def _read(entry: Mapping[str, object]) -> tuple[Fraction, Kernel]:
    c = Fraction(str(entry["coefficient"]))
    if "delay" in entry:
        return c, Delay(Fraction(str(entry["delay"])))
    side = entry["side"]
    if side not in ("causal", "anticausal"):
        raise ValueError(side)
    return c, Gamma(
        Fraction(str(entry["rate"])), int(str(entry["order"])), "causal" if side == "causal" else "anticausal"
    )


# The inequality of Zames and Falb in exact polynomials, and its proof on bounded intervals by balls.

Number = TypeVar("Number", arb, arb_series)
BITS = 128
_MIRROR = fmpq_poly([0, -1])


@dataclass(frozen=True, kw_only=True, slots=True)
class Check:
    """What was found: ``holds`` is a proof; else ``where`` is a frequency where it fails or stays open [rad/s]."""

    holds: bool
    where: float | None = None


@described(frozen=True, slots=True)
class Inequality:
    r"""The inequality times ``k |d|^2 E > 0`` on the axis, in exact polynomials; over ``w^2`` in the critical case.

    ``T(w) = A(w^2) - Re[q(w) Psi(i w)]`` with ``q = sum c_j exp(-i w tau_j)`` over the delays and
    ``Psi(s) = E(s) (k n + d)(s) d(-s)``; ``E`` clears the denominators of the gamma kernels, which are in ``A``.  With
    a simple root of ``d`` at 0 ``A`` and ``even`` are divided by ``x``, and the sines of the delays by ``w``.
    """

    A: fmpq_poly = quantity("In ``x = w^2``")
    even: fmpq_poly = quantity("In ``x``: ``Psi(i w) = even + i w odd``")
    odd: fmpq_poly
    delays: tuple[tuple[Fraction, Fraction], ...] = quantity("Coefficients ``c_j`` and delays ``tau_j``", "s")
    full: int = quantity(
        "Degree of ``k |d|^2 E`` in ``x``: ``T`` divided by it stays away from 0 at infinity only if ``A`` has it too"
    )
    critical: bool = quantity("Whether ``d`` has the root 0", default=False)

    @classmethod
    def of(cls, plant: TransferPolynomials, k: Fraction, multiplier: Multiplier, floor: Fraction) -> Inequality:
        """The inequality ``... >= floor`` for ``H = n/d`` with ``d`` Hurwitz, or critical, and slopes in ``[0, k]``."""
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
        (A, _), (even, odd), critical = even_odd(total), even_odd(E * psi), d[0] == 0
        if critical:
            A, even = A // X, even // X
        return cls(A, even, odd, delays, d.degree() + E.degree() // 2 - critical, critical)

    def at(self, omega: Number) -> Number:
        """``T`` at a frequency: on a ball, or on a power series."""
        x = omega * omega
        real, turned = at(self.even, x), at(self.odd, x)
        total = at(self.A, x)
        for c, tau in self.delays:
            angle = omega * ball(tau)
            sine = ball(tau) * sinc(angle) if self.critical else omega * angle.sin()
            total -= ball(c) * (angle.cos() * real + sine * turned)
        return total

    def apart(self, mass: fmpq) -> fmpq_poly:
        """``A^2 - mass^2 |Psi|^2``; in the critical case, where ``|Psi|^2/x^2`` has a pole at 0, times ``x``."""
        own, other = (X, fmpq_poly([1])) if self.critical else (fmpq_poly([1]), X)
        return own * self.A**2 - mass**2 * (own * self.even**2 + other * self.odd**2)


def positive_on(inequality: Inequality, intervals: list[tuple[arb, arb]]) -> Check:
    """Whether ``T > 0`` on intervals of ``w``, by branch and bound in balls.

    Parameters
    ----------
    inequality : Inequality
        ``T``.
    intervals : list of (arb, arb)
        Ends [rad/s]; a ball stands for every end in it.
    """
    with working_precision(BITS + 8 * inequality.even.degree()):
        for low, high in intervals:
            found = minimum(inequality.at, low, high, width=lambda best: best / 2 if best > 0 else arb("inf"))
            if not found.low > 0:
                return Check(holds=False, where=float(found.where))
    return Check(holds=True)


SHARES = (Fraction(999, 1000), Fraction(9, 10), Fraction(1, 2), Fraction(1, 10))


def check(
    plant: TransferPolynomials,
    k: Fraction,
    multiplier: Multiplier,
    *,
    floor: Fraction = Fraction(0),
) -> Check:
    r"""Whether ``Re[M(iw)(H(iw) + 1/k) + i w theta H(iw)] >= floor + eps``, some ``eps > 0``, for every real ``w``.

    Without delays this is a sign test on a polynomial in ``w^2``, exact.  With delays of total mass ``Q`` it follows
    from ``A(x) > 0`` and ``A(x)^2 > Q^2 |Psi|^2`` wherever these polynomial inequalities hold, in particular for all
    large ``w``; what is left over, a few bounded intervals, is covered by boxes on which a Taylor bound in ball
    arithmetic is positive.

    Parameters
    ----------
    plant : TransferPolynomials
        ``H = n/d`` in continuous time, ``d`` Hurwitz or with a simple root at 0 besides (not checked here).
    k : Fraction
        Upper slope, positive [unit of mu / unit of sigma].
    multiplier : Multiplier
        Its admissibility is not checked here.
    floor : Fraction
        What the left-hand side is to exceed.
    """
    inequality = Inequality.of(plant, k, multiplier, floor)
    A = inequality.A
    if A.degree() < inequality.full or not A[A.degree()] > 0:
        return Check(holds=False, where=math.inf)
    if not inequality.delays:
        return Check(holds=True) if positive_from_zero(A) else Check(holds=False, where=_first_failure(A))
    mass = to_fmpq(sum((abs(c) for c, _ in inequality.delays), Fraction(0)))
    bound = inequality.apart(mass)
    if bound.degree() < 2 * inequality.full + inequality.critical or not bound[bound.degree()] > 0:
        return Check(holds=False, where=math.inf)
    return positive_on(inequality, _open_intervals(A, bound))


def check_every(plant: TransferPolynomials, multiplier: Multiplier) -> bool:
    r"""Whether the multiplier proves every finite slope, by ``Re[M H + i w theta H] >= 0`` without delays.

    Then ``Re M / k`` is left, for every ``k``: bounded away from 0 if ``sum |c_j| < 1``, and for ``sum |c_j| = 1`` too
    if some ``c_j < 0``, for ``|h_j^(iw)| < 1`` unless ``w = 0``.  If ``sum c_j = 1``, all positive, ``Re M`` vanishes
    at ``w = 0`` alone.  Multiplying all ``c_j`` by ``1 - delta`` adds ``delta Re[sum c_j h_j^ (H + 1/k)]``,
    near ``H(0) + 1/k`` around ``w = 0`` and small elsewhere, so that for each finite ``k`` a small enough ``delta > 0``
    leaves the sum bounded away from 0 provided that ``H(0) >= 0``; with a pole at 0 ``sum |c_j| < 1`` is asked for.

    ``plant``: ``H = n/d`` in continuous time, ``d`` Hurwitz and ``H(inf) >= 0`` (neither is checked here);
    ``multiplier``: its admissibility is not checked here.
    """
    if any(isinstance(kernel, Delay) for _, kernel in multiplier.terms):
        return False
    signs_differ = any(c < 0 for c, _ in multiplier.terms)
    if not (multiplier.mass < 1 or signs_differ or (plant.d[0] != 0 and plant.n[0] * plant.d[0] >= 0)):
        return False
    one, two = (Inequality.of(plant, k, multiplier, Fraction(0)).A for k in (Fraction(1), Fraction(2)))
    return nonnegative_from_zero(two - one)


def value_at(plant: TransferPolynomials, k: Fraction, multiplier: Multiplier, omega: Fraction) -> arb:
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


def margin_near(plant: TransferPolynomials, k: Fraction, multiplier: Multiplier, omega: Fraction) -> Bracket:
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

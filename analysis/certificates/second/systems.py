"""The loop shifted by the lower gain, its poles counted exactly, and whether it is well posed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Literal

from flint import acb, acb_series, arb, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.numerics import (
    Counts,
    X,
    ball,
    even_odd,
    from_descending,
    half_plane_counts,
    on_axis,
    right_zeros,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.reading import NotShown, count, listed, number, numbers, record, require

# The linear part of a certificate: rational, with dead time, or the rod.

LARGEST_SCHEME = 1000  # cells, for matrices
LARGEST_ORDER = 1000
_BITS = 192
Row = tuple[Fraction, ...]
Case = Literal["stable", "critical"]


@dataclass(frozen=True, kw_only=True, slots=True)
class States:
    """``x' = A x + b mu``, ``sigma = c x + d mu`` (in discrete time ``x+``), every entry exact."""

    A: tuple[Row, ...]
    b: Row
    c: Row
    d: Fraction

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.b)

    def closed(self, gain: Fraction) -> tuple[Row, ...]:
        """``A - b c g/(1 + g d)``: the loop with ``mu = -g sigma``; needs ``1 + g d != 0``."""
        share = gain / (1 + gain * self.d)
        return tuple(
            tuple(a - share * bi * cj for a, cj in zip(row, self.c, strict=True))
            for row, bi in zip(self.A, self.b, strict=True)
        )


@dataclass(frozen=True, kw_only=True)
class Plant:
    """``n/d`` in the variable ``s``; in discrete time mapped by ``z = (1 + s)/(1 - s)``, the unit disc to the left.

    Attributes
    ----------
    n, d : fmpq_poly
        Common factors kept.
    degree : int
        Of ``d``, but for roots at infinity (``z = -1``).
    """

    n: fmpq_poly
    d: fmpq_poly
    degree: int

    @classmethod
    def of(cls, n: fmpq_poly, d: fmpq_poly, *, discrete: bool) -> Plant:
        """The plant of a transfer function."""
        degree = d.degree()
        return (
            cls(n=mapped(n, degree), d=mapped(d, degree), degree=degree) if discrete else cls(n=n, d=d, degree=degree)
        )

    def shifted(self, gain: Fraction) -> Plant:
        """``n / (d + g n)``: the same loop for ``phi - g sigma``."""
        return Plant(n=self.n, d=self.d + to_fmpq(gain) * self.n, degree=self.degree)

    @cached_property
    def hidden(self) -> fmpq_poly:
        """The common factor of ``n`` and ``d``."""
        return self.n.gcd(self.d) if self.n.degree() >= 0 else self.d

    @cached_property
    def counts(self) -> Counts:
        """The roots of ``d``; those at infinity count as on the axis."""
        found = half_plane_counts(self.d)
        return Counts(found.left, found.axis + self.degree - self.d.degree(), found.right)

    @property
    def case(self) -> Case | None:
        """Every root stable, or one simple one at 0 besides; None for any other."""
        if (self.counts.right, self.counts.axis) == (0, 0):
            return "stable"
        simple = (self.counts.right, self.counts.axis) == (0, 1) and self.d.degree() == self.degree
        return "critical" if simple else None  # others than 0 come in pairs

    @property
    def residue(self) -> Fraction:
        """At a simple pole ``s = 0``."""
        return to_fraction(self.n[0] / self.d[1])

    def response(self) -> tuple[fmpq_poly, fmpq_poly, fmpq_poly]:
        """``|d|^2``, ``Re(n conj(d))`` and ``-w Im(n conj(d))`` in ``x = w^2``, without common powers of ``x``."""
        (ne, no), (de, do) = even_odd(self.n), even_odd(self.d)
        found = de * de + X * do * do, ne * de + X * no * do, X * (ne * do - no * de)
        while found[0].degree() > 0 and all(p[0] == 0 for p in found):
            found = found[0] // X, found[1] // X, found[2] // X
        return found


def mapped(p: fmpq_poly, degree: int) -> fmpq_poly:
    """``(1 - s)^degree p((1 + s)/(1 - s))``, which takes the unit disc to the left half plane.

    ``p``: a polynomial in ``z``; ``degree``: at least its own.
    """
    up, down = fmpq_poly([1, 1]), fmpq_poly([1, -1])
    found, factor = fmpq_poly([]), down ** (degree - max(p.degree(), 0))
    for c in reversed(p.coeffs()):
        found, factor = found * up + c * factor, factor * down
    return found


@dataclass(frozen=True, kw_only=True)
class Rational:
    """``H = n/d``, the characteristic polynomial ``d`` with hidden modes, and one realisation.

    Attributes
    ----------
    discrete : bool
        Whether the variable is ``z``.
    states : States
        State equations; for transfer functions the controllable companion form of the monic ``d``.
    given : tuple of fmpq_poly or None
        ``(n, d)`` where the file gives them.
    """

    discrete: bool
    states: States
    given: tuple[fmpq_poly, fmpq_poly] | None

    @cached_property
    def polynomials(self) -> tuple[fmpq_poly, fmpq_poly]:
        """``(n, d)``: with matrices ``d = det(s - A)`` and ``n = det(s - A + b c) - det(s - A) + D d``."""
        if self.given is not None:
            return self.given
        r = self.states
        A = fmpq_mat([[to_fmpq(v) for v in row] for row in r.A])
        looped = fmpq_mat(
            [[to_fmpq(v - bi * cj) for v, cj in zip(row, r.c, strict=True)] for row, bi in zip(r.A, r.b, strict=True)]
        )
        d = A.charpoly()
        return looped.charpoly() - d + to_fmpq(r.d) * d, d

    @property
    def feedthrough(self) -> Fraction:
        """``D = H(inf)``."""
        return self.states.d

    @cached_property
    def plant(self) -> Plant:
        """For poles and responses."""
        return Plant.of(*self.polynomials, discrete=self.discrete)

    def closed(self, gain: Fraction) -> fmpq_poly:
        """The characteristic polynomial ``d + gain n`` of the loop with a linear gain."""
        n, d = self.polynomials
        return d + to_fmpq(gain) * n


@dataclass(frozen=True, kw_only=True)
class Delayed:
    """``H = sum n_j exp(-s T_j)/chi``, ``chi = d + sum q_k exp(-s T_k)``, ``n_j/d``, ``q_k/d`` strictly proper."""

    terms: tuple[tuple[Fraction, fmpq_poly], ...]
    d: fmpq_poly
    back: tuple[tuple[Fraction, fmpq_poly], ...] = ()

    def closed(self, gain: Fraction) -> Delayed:
        """The loop of ``phi - g sigma``: of the equation ``chi + g sum n_j exp(-s T_j)``."""
        parts = dict(self.back)
        for T, n in self.terms if gain else ():
            parts[T] = parts.get(T, fmpq_poly([])) + to_fmpq(gain) * n
        d = self.d + parts.pop(Fraction(0), fmpq_poly([]))
        return Delayed(terms=self.terms, d=d, back=tuple((T, q) for T, q in parts.items() if q.degree() >= 0))

    @property
    def at_zero(self) -> fmpq:
        """``chi(0)``."""
        return sum((q[0] for _, q in self.back), self.d[0])

    def turn(self, a: Fraction | None, b: Fraction) -> acb:
        """``chi/s^n``, ``d`` being monic, as :func:`right_zeros` asks; where ``chi(0) = 0`` for ``chi/s``."""
        n, omega = self.d.degree(), ball(b) if a is None else ball(a).union(ball(b))
        if a is None:
            u, any_phase, total = (1 / omega).union(arb(0)), acb(arb(0, 1), arb(0, 1)), acb(0)
            for T, p in [(Fraction(0), self.d), *self.back]:
                far = sum((acb(arb(c)) * acb(0, -u) ** (n - k) for k, c in enumerate(p.coeffs())), acb(0))
                total += far * any_phase if T else far
            return total / acb(arb(self.d[n]))
        chi = self.chi(acb_series([acb(0, omega), acb(1)]))
        if a:
            return chi[0] / acb(0, omega) ** n
        return chi[0] * acb(0, -1) ** n if self.at_zero != 0 else chi[1] * acb(0, -1) ** (n - 1)

    def closer(self, a: Fraction, b: Fraction) -> acb:
        """``chi/i^n`` between two frequencies, as :func:`right_zeros` asks."""
        return on_axis(self.chi, a, b) * acb(0, -1) ** self.d.degree()

    def chi(self, s: acb_series) -> acb_series:
        """``chi`` over the leading coefficient of ``d``."""
        total = 0 * s
        for T, p in [(Fraction(0), self.d), *self.back]:
            value = 0 * s
            for c in reversed(p.coeffs()):
                value = value * s + acb(arb(c))
            total += value * (s * -ball(T)).exp() if T else value
        return total / acb(arb(self.d[self.d.degree()]))


@dataclass(frozen=True, kw_only=True, slots=True)
class RodData:
    """The rod, ``cells`` None, or its scheme: Young's modulus, density, length, area > 0 and the dashpot."""

    E: Fraction
    rho: Fraction
    length: Fraction
    area: Fraction
    k: Fraction
    cells: int | None

    @property
    def squared_impedance(self) -> Fraction:
        """``Z^2 = A^2 rho E``."""
        return self.area**2 * self.rho * self.E

    def states(self) -> Rational:
        """The scheme as state equations: waves ``y_1 .. y_2N`` and the end ``z``, which is ``sigma``.

        ``y_i' = s (y_{i-1} - y_i)`` but for ``y_1' = -s (a y_2N + y_1)``, with ``2 s d mu`` added to ``y_{N+1}'``;
        ``z' = y_N + d mu``, ``s = c N/L``.

        Raises
        ------
        NotShown
            It is the rod itself, ``sqrt(rho E)`` is irrational, or ``k = -Z``.
        """
        if self.cells is None:
            raise NotShown("the rod itself has no state equations")
        N, root = self.cells, square_root(self.rho * self.E)
        Z, d, s = self.area * root, 1 / root, root / self.rho * self.cells / self.length
        require(self.k != -Z, "k = -Z")
        require(N <= LARGEST_SCHEME, "the scheme is too large for matrices")
        a = (self.k - Z) / (self.k + Z)
        A = [[Fraction(0)] * (2 * N + 1) for _ in range(2 * N + 1)]
        for i in range(2 * N):
            A[i][i], A[i][i - 1 if i else 2 * N - 1] = -s, s if i else -s * a
        A[2 * N][N - 1] = Fraction(1)
        b, c = [Fraction(0)] * (2 * N + 1), [Fraction(0)] * (2 * N + 1)
        b[N], b[2 * N], c[2 * N] = 2 * s * d, d, Fraction(1)
        state = States(A=tuple(map(tuple, A)), b=tuple(b), c=tuple(c), d=Fraction(0))
        return Rational(discrete=False, states=state, given=None)


def square_root(value: Fraction) -> Fraction:
    """The square root of a positive number, if it is rational."""
    top, bottom = math.isqrt(value.numerator), math.isqrt(value.denominator)
    require(top * top == value.numerator and bottom * bottom == value.denominator, "a square root is irrational")
    return Fraction(top, bottom)


System = Rational | Delayed | RodData


def read_system(value: Mapping[str, object]) -> System:
    """The system of a certificate."""
    kind = value.get("kind")
    if kind == "transfer":
        found = record(value, "kind", "time", "numerator", "denominator")
        n, d = (numbers(found[side]) for side in ("numerator", "denominator"))
        require(len(n) > 0, "the numerator is empty")
        require(d[:1] not in ([], [0]), "the denominator does not begin with its leading coefficient")
        return _rational(from_descending(n), from_descending(d), discrete=_discrete(found["time"]))
    if kind == "state-space":
        return _state_space(record(value, "kind", "time", "A", "b", "c", "d"))
    if kind == "delay":
        return _delayed(record(value, "kind", "terms", "denominator", *(["feedback"] if "feedback" in value else [])))
    if kind in ("rod", "rod-scheme"):
        names = ["kind", "E", "rho", "L", "A", "k"] + (["cells"] if kind == "rod-scheme" else [])
        found = record(value, *names)
        E, rho, length, area, k = (number(found[name]) for name in names[1:6])
        require(min(E, rho, length, area) > 0, "E, rho, L and A of the rod must be positive")
        cells = count(found["cells"], least=1) if kind == "rod-scheme" else None
        return RodData(E=E, rho=rho, length=length, area=area, k=k, cells=cells)
    raise NotShown("the kind of system is unknown")


def _rational(n: fmpq_poly, d: fmpq_poly, *, discrete: bool) -> Rational:
    require(d.degree() >= 0 and n.degree() <= d.degree(), "the transfer function is not proper")
    require(d.degree() <= LARGEST_ORDER, "the order is too large")
    return Rational(discrete=discrete, states=_companion(n, d), given=(n, d))


def _companion(n: fmpq_poly, d: fmpq_poly) -> States:
    """The controllable companion form: ``x = (y, y', ..)`` with ``d(p) y = mu``, ``sigma = n(p) y``, ``d`` monic."""
    order = d.degree()
    low, top = ([to_fraction(p[i] / d[order]) for i in range(order + 1)] for p in (d, n))
    one = [[Fraction(int(j == i)) for j in range(order)] for i in range(order)]
    rows = [*map(tuple, one[1:]), tuple(-v for v in low[:order])] if order else []
    c = tuple(t - top[order] * v for t, v in zip(top[:order], low, strict=False))
    return States(A=tuple(rows), b=tuple(one[-1]) if order else (), c=c, d=top[order])


def _state_space(found: Mapping[str, object]) -> Rational:
    A = [tuple(numbers(row)) for row in listed(found["A"])]
    b, c = tuple(numbers(found["b"])), tuple(numbers(found["c"]))
    require(len(A) > 0 and all(len(row) == len(A) for row in (*A, b, c)), "the shapes of A, b, c do not fit")
    state = States(A=tuple(A), b=b, c=c, d=number(found["d"]))
    return Rational(discrete=_discrete(found["time"]), states=state, given=None)


def _delayed(found: Mapping[str, object]) -> Delayed:
    written = numbers(found["denominator"])
    require(written[:1] not in ([], [0]), "the denominator does not begin with its leading coefficient")
    d = from_descending(written)
    terms = _late(found["terms"], d)
    back = _late(found["feedback"], d) if "feedback" in found else {}
    require(Fraction(0) not in back, "a dead time of the denominator is 0")
    return Delayed(terms=tuple(terms.items()), d=d, back=tuple(back.items()))


def _late(given: object, d: fmpq_poly) -> dict[Fraction, fmpq_poly]:
    """Polynomials of a lower degree than ``d``, by their dead times."""
    terms: dict[Fraction, fmpq_poly] = {}
    for entry in listed(given):
        pair = listed(entry)
        require(len(pair) == 2, "a term with dead time is not a pair")
        delay, written = number(pair[0]), numbers(pair[1])
        require(len(written) > 0, "a numerator is empty")
        n = from_descending(written)
        require(delay >= 0 and delay not in terms, "a dead time is negative or given twice")
        require(n.degree() < d.degree(), "a term with dead time is not strictly proper")
        terms[delay] = n
    require(len(terms) > 0, "there are no terms")
    return terms


def _discrete(time: object) -> bool:
    require(time in ("continuous", "discrete"), "time is neither continuous nor discrete")
    return time == "discrete"


@dataclass(frozen=True, kw_only=True)
class Shifted:
    """The loop of ``phi - lower sigma``: ``n / (d + lower n)``, every pole stable or one simple one at 0 besides.

    Attributes
    ----------
    n : tuple of (Fraction, fmpq_poly)
        Delays and numerators; one without delay for a rational block.
    d : fmpq_poly
        In ``s`` or ``z``.
    plant : Plant or None
        None with dead time.
    case : {"stable", "critical"}
        Critical: a simple pole at ``s = 0`` (``z = 1``) whose residue is positive.
    back : tuple of (Fraction, fmpq_poly)
        What is added to ``d`` with dead time.
    """

    n: tuple[tuple[Fraction, fmpq_poly], ...]
    d: fmpq_poly
    discrete: bool
    plant: Plant | None
    case: Case
    back: tuple[tuple[Fraction, fmpq_poly], ...] = ()

    @property
    def hidden(self) -> bool:
        """Whether ``n`` and ``d`` have a common factor; with dead time not decided, and so taken for granted."""
        return self.plant is None or self.plant.hidden.degree() > 0

    @property
    def feedthrough(self) -> Fraction:
        """``H(inf)`` after the shift."""
        if self.plant is None:
            return Fraction(0)
        n, degree = self.n[0][1], self.d.degree()
        return to_fraction(n[degree] / self.d[degree])


def shifted(system: Rational | Delayed, lower: Fraction) -> Shifted:
    """The loop after the shift by ``lower``; its poles are counted exactly, hidden modes included."""
    if isinstance(system, Delayed):
        return _shifted_delayed(system.closed(lower))
    require(1 + lower * system.feedthrough != 0, "1 + l H(inf) vanishes: the loop is not well posed at its lower gain")
    plant = system.plant.shifted(lower)
    case = plant.case
    if case is None:
        raise NotShown("the loop with the lower gain has a pole on the axis or beyond that is no simple one at 0")
    if case == "critical":
        require(plant.residue > 0, "the residue at the pole 0 is not positive")
    n, _ = system.polynomials
    return Shifted(n=((Fraction(0), n),), d=system.closed(lower), discrete=system.discrete, plant=plant, case=case)


def require_well_posed(direct: Fraction, lower: Fraction, upper: Fraction | str) -> None:
    """Check that ``1 + kappa D`` keeps its sign, without zero, for ``kappa`` in ``[lower, upper]``."""
    start = 1 + lower * direct
    good = start * (1 + upper * direct) > 0 if isinstance(upper, Fraction) else start != 0 and direct * start >= 0
    require(good, "1 + kappa H(inf) changes sign in the sector: the loop is not well posed")


def _shifted_delayed(system: Delayed) -> Shifted:
    critical = system.at_zero == 0
    if system.back:
        with working_precision(_BITS):
            zeros = right_zeros(system.d.degree() - bool(critical), system.turn, system.closer)
        require(zeros == 0, "a pole is not stable")
    else:
        counts = half_plane_counts(system.d)
        require(counts.right == 0 and (counts.axis == 0 or (critical and counts.axis == 1)), "a pole is not stable")
    if critical:
        slope = sum((q[1] - to_fmpq(T) * q[0] for T, q in system.back), system.d[1])
        residue = sum((n[0] for _, n in system.terms), fmpq(0)) * slope
        require(bool(residue > 0), "the residue at the pole 0 is not positive")
    case: Case = "critical" if critical else "stable"
    return Shifted(n=system.terms, d=system.d, discrete=False, plant=None, case=case, back=system.back)

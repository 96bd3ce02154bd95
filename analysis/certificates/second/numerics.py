"""The second checker's own numerics on python-flint: roots of rational polynomials, Laurent polynomials, balls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

from flint import acb, acb_series, arb, arb_mat, ctx, fmpq, fmpq_poly

from lure.analysis.certificates.second.reading import require, tick

X = fmpq_poly([0, 1])
ONE = fmpq(1)
SERIES_TERMS = 10


def to_fmpq(value: Fraction | int) -> fmpq:
    """The same number as an ``fmpq``."""
    return fmpq(value.numerator, value.denominator)


def to_fraction(value: fmpq) -> Fraction:
    """The same number as a ``Fraction``."""
    return Fraction(int(value.p), int(value.q))


def from_descending(coefficients: Sequence[Fraction]) -> fmpq_poly:
    """The polynomial with these coefficients, highest power first."""
    return fmpq_poly([to_fmpq(c) for c in reversed(coefficients)])


def even_odd(p: fmpq_poly) -> tuple[fmpq_poly, fmpq_poly]:
    """``(e, o)`` with ``p(i w) = e(w^2) + i w o(w^2)``."""
    coefficients = p.coeffs()
    return fmpq_poly(coefficients[0::2])(-X), fmpq_poly(coefficients[1::2])(-X)


# Balls.


@contextmanager
def working_precision(bits: int, terms: int = SERIES_TERMS) -> Iterator[None]:
    """Run a block at ``bits`` of precision, with series of 10 terms; put both back (they are global to the process)."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = bits, terms
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def ball(value: Fraction | int) -> arb:
    """The ball around an exact number, as narrow as the working precision allows."""
    return arb(to_fmpq(value))


def balls(rows: Sequence[Sequence[Fraction]]) -> arb_mat:
    """Exact rows as balls."""
    return arb_mat([[ball(value) for value in row] for row in rows])


# Roots: isolated by flint, narrowed until each lies on one side of what is asked.


def _roots(p: fmpq_poly, decided: Callable[[acb], bool]) -> list[tuple[acb, int]]:
    """Balls around the distinct roots, decided, with multiplicities; those of real roots have no imaginary part."""
    found = list[tuple[acb, int]]()
    for factor, multiplicity in p.numer().factor_squarefree()[1]:
        bits, near = max(64, ctx.prec), list[acb]()
        while factor.degree() > 0:
            tick()
            with working_precision(bits):
                near = [root for root, _ in cast("list[tuple[acb, int]]", factor.complex_roots())]
            if all(map(decided, near)):
                break
            bits *= 2
        found += [(root, int(multiplicity)) for root in near]
    return found


def _without_zeros(p: fmpq_poly, at: int = 0) -> fmpq_poly:
    while p.degree() > 0 and p(fmpq(at)) == 0:
        p = p // (X - at)
    return p


def positive_roots(p: fmpq_poly) -> list[tuple[arb, int]]:
    """The distinct roots of ``p``, not the zero polynomial, in ``(0, inf)``, with multiplicities."""
    rest = _without_zeros(p)
    if all(c >= 0 for c in rest.coeffs()) or all(c <= 0 for c in rest.coeffs()):
        return []
    found = _roots(rest, lambda root: bool(root.imag != 0) or bool(root.real != 0))
    return [(root.real, multiplicity) for root, multiplicity in found if root.imag == 0 and root.real > 0]


def positive_from_zero(p: fmpq_poly) -> bool:
    """Whether ``p(x) > 0`` for every ``x >= 0``."""
    return p.degree() >= 0 and bool(p[0] > 0) and not positive_roots(p)


def nonnegative_from_zero(p: fmpq_poly) -> bool:
    """Whether ``p(x) >= 0`` for every ``x >= 0``: no positive root of odd multiplicity, and the sign right far out."""
    if p.degree() < 0:
        return True
    return bool(p[p.degree()] > 0) and not any(multiplicity % 2 for _, multiplicity in positive_roots(p))


@dataclass(frozen=True, slots=True)
class Counts:
    """Roots with multiplicity: left of the imaginary axis, on it, right of it."""

    left: int
    axis: int
    right: int


def half_plane_counts(p: fmpq_poly) -> Counts:
    """The roots of ``p``, not the zero polynomial, by their side of the imaginary axis.

    What ``p(s)`` and ``p(-s)`` share holds the roots on the axis and pairs ``s, -s``: a power of ``s`` and a polynomial
    in ``s^2``, whose negative roots are those on the axis.  The rest has none there.
    """
    require(p.degree() >= 0, "the zero polynomial has no roots to count")
    shared = p.gcd(p(-X))
    even = _without_zeros(shared)
    in_square = fmpq_poly(even.coeffs()[::2])
    axis = shared.degree() - even.degree() + 2 * sum(m for _, m in positive_roots(in_square(-X)))
    right = (shared.degree() - axis) // 2
    right += sum(m for root, m in _roots(p // shared, lambda root: bool(root.real != 0)) if root.real > 0)
    return Counts(p.degree() - axis - right, axis, right)


_MOST_PIECES, _DOUBLINGS, _SHORT, _NARROWEST = 20_000, 60, 2**8, 2**90


def taylor(here: acb_series, wide: acb_series, radius: arb) -> acb:
    """Bound of a function by Taylor's formula about the middle of an interval of a real variable.

    ``here``, ``wide``: the function about the middle, and about every point: of this the last coefficient is taken;
    ``radius``: half the length.
    """
    total, power = here[0], arb(1)
    for k in range(1, SERIES_TERMS):
        power *= radius
        coefficient = wide[k] if k == SERIES_TERMS - 1 else here[k]
        total += coefficient * power * (arb(0.5, 0.5) if k % 2 == 0 else arb(0, 1))
    return total


def on_axis(chi: Callable[[acb_series], acb_series], a: Fraction, b: Fraction) -> acb:
    """``chi(i omega)`` for ``omega`` from ``a`` to ``b``.

    ``chi``: the function, of a series in ``omega``; ``a``, ``b``: the frequencies [rad/s].
    """
    centres = acb(ball((a + b) / 2)), acb(ball(a).union(ball(b)))
    here, wide = (chi(acb_series([omega * acb(0, 1), acb(0, 1)])) for omega in centres)
    return taylor(here, wide, ball((b - a) / 2).upper())


def right_zeros(
    n: int, turn: Callable[[Fraction | None, Fraction], acb], closer: Callable[[Fraction, Fraction], acb]
) -> int:
    r"""How many zeros with ``Re s >= 0`` ``chi(s) = s^n g(s)`` has, ``Re g > 0`` far out there, none lying on the axis.

    The angle of ``g``, which is ``-n pi/2`` at 0 where ``chi(0) > 0``, and ``pi`` more where not, rises to near 0 less
    ``pi`` for each.  ``k`` counts quarters on pieces with ``Re i^-k g > 0``.

    Parameters
    ----------
    n : int
        The power.
    turn : callable
        ``g`` between two frequencies, from 0 on times ``omega^n``; from None: from the second on.
    closer : callable
        ``omega^n g`` between two frequencies above 0 that lie close together, near a zero for instance: better bounds.

    Raises
    ------
    NotShown
        They are not counted.
    """
    end = Fraction(1)
    while not turn(None, end).real > 0:
        require(end < 2**_DOUBLINGS, "nothing is shown far out")
        end *= 2
    first = k = -n
    stack, looked_at = [(Fraction(0), end)], 0
    while stack:
        tick()
        looked_at += 1
        require(looked_at < _MOST_PIECES, "the turns are not counted")
        a, b = stack.pop()
        g = turn(a, b) if not a or (b - a) * _SHORT > end else closer(a, b)
        turns = [j for j in ((k, k + 1, k - 1) if a else (-n, 2 - n)) if (g * acb(0, -1) ** (j % 4)).real > 0]
        if turns:
            k = turns[0]
            first = first if a else k
            continue
        require(b - a > end / _NARROWEST, "what is counted may have a root on the axis")
        stack += [((a + b) / 2, b), (a, (a + b) / 2)]
    whole = [quarters for quarters in range(k - 1, k + 2) if quarters % 4 == 0]
    require(len(whole) == 1, "the turns are not counted")
    return (first - whole[0] + n) // 2


# The unit circle, by ``c = cos w`` in ``[-1, 1]``.


def _inner_roots(p: fmpq_poly) -> list[int]:
    """Multiplicities of the distinct roots of ``p``, not the zero polynomial, in ``(-1, 1)``."""

    def inside(root: acb) -> bool:
        """Whether its real part is known to lie between -1 and 1."""
        return bool(root.real > -1) and bool(root.real < 1)

    rest = _without_zeros(_without_zeros(p, 1), -1)
    found = _roots(
        rest, lambda root: bool(root.imag != 0) or inside(root) or bool(root.real > 1) or bool(root.real < -1)
    )
    return [multiplicity for root, multiplicity in found if root.imag == 0 and inside(root)]


def positive_on_circle(p: fmpq_poly) -> bool:
    """Whether ``p(c) > 0`` for every ``c`` in ``[-1, 1]``."""
    return bool(p(ONE) > 0) and bool(p(-ONE) > 0) and not _inner_roots(p)


def nonnegative_on_circle(p: fmpq_poly) -> bool:
    """Whether ``p(c) >= 0`` for every ``c`` in ``[-1, 1]``: no zero of odd order inside, and the sign right."""
    if p.degree() < 0:
        return True
    values = (p(fmpq(1, i)) for i in range(2, p.degree() + 3))  # one of them is no zero
    return next(bool(v > 0) for v in values if v != 0) and not any(m % 2 for m in _inner_roots(p))


@dataclass(frozen=True, slots=True)
class Laurent:
    """``z^-shift p(z)`` with rational coefficients; on ``|z| = 1`` its conjugate is ``z^shift p(1/z)``."""

    p: fmpq_poly
    shift: int = 0

    def __add__(self, other: Laurent) -> Laurent:
        shift = max(self.shift, other.shift)
        return Laurent(self.p * X ** (shift - self.shift) + other.p * X ** (shift - other.shift), shift)

    def __mul__(self, other: Laurent) -> Laurent:
        return Laurent(self.p * other.p, self.shift + other.shift)

    def scaled(self, factor: Fraction) -> Laurent:
        """``factor`` times it."""
        return Laurent(to_fmpq(factor) * self.p, self.shift)

    def conjugate(self) -> Laurent:
        """``z -> 1/z``: the complex conjugate on the unit circle."""
        return Laurent(fmpq_poly(self.p.coeffs()[::-1]), len(self.p.coeffs()) - 1 - self.shift)

    def real_part(self) -> fmpq_poly:
        """The polynomial ``P`` with ``Re = P(cos w)`` on ``z = exp(i w)``, by Clenshaw's rule for ``cos(j w)``."""
        harmonics = [fmpq(0)] * (len(self.p.coeffs()) + abs(self.shift) + 1)
        for i, value in enumerate(self.p.coeffs()):
            harmonics[abs(i - self.shift)] += value
        one, two = fmpq_poly([]), fmpq_poly([])
        for value in reversed(harmonics[1:]):
            tick()
            one, two = fmpq_poly([value]) + 2 * X * one - two, one
        return fmpq_poly(harmonics[:1]) + X * one - two

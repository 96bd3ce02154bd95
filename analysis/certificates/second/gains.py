"""Constant gains: whether all of a class are stable, and whether one is not."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Literal

from flint import acb, acb_poly, arb, arb_poly, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.numerics import (
    ball,
    positive_from_zero,
    positive_roots,
    to_fmpq,
    working_precision,
)
from lure.analysis.certificates.second.reading import NotShown, require
from lure.analysis.certificates.second.systems import Delayed, Rational, require_well_posed, shifted

BITS = (128, 512, 2048, 8192)
CROSSING_BITS = 512
HALVINGS = 400
Kind = Literal["no rest", "equilibria"]


def require_every_gain_stable(system: Rational, nonlinearities: Nonlinearities) -> None:
    """Check that ``d + g n`` has all roots strictly inside for every ``g`` of the class.

    It has at the lower bound; roots move continuously and could leave only through the axis, where ``Im H = 0`` and
    ``|d|^2 (1 + g Re H)`` vanishes for the gain, counted from the lower bound.

    Raises
    ------
    NotShown
        The class is not one of constant gains, or some gain is not shown to be stable.
    """
    require(nonlinearities.linear, "stable gains say nothing about nonlinearities that are not linear")
    if not isinstance(nonlinearities.lower, Fraction):
        raise NotShown("the lower bound is infinite")
    require_well_posed(system.feedthrough, nonlinearities.lower, nonlinearities.upper)
    block = shifted(system, nonlinearities.lower)
    require(block.case == "stable" and block.plant is not None, "the loop is not stable at the lower bound")
    assert block.plant is not None
    square, real, imaginary = block.plant.response()
    strict = isinstance(nonlinearities.upper, Fraction)
    test = (
        square + to_fmpq(nonlinearities.upper - nonlinearities.lower) * real
        if isinstance(nonlinearities.upper, Fraction)
        else real
    )
    far = test[square.degree()]
    at_infinity = bool(far > 0 if strict else far >= 0)
    require(at_infinity, "a gain of the class has a root at infinity")
    require(_at_crossings(test, imaginary, strict=strict), "a gain of the class has roots on the axis")


def _at_crossings(test: fmpq_poly, crossings: fmpq_poly, *, strict: bool) -> bool:
    """Whether ``test > 0`` (or ``>= 0``) at 0 and at every positive root of ``crossings``."""
    if crossings.degree() < 0:
        return positive_from_zero(test) if strict else False
    common = crossings.gcd(test) if test.degree() >= 0 else crossings
    if strict and (positive_roots(common) or common(fmpq(0)) == 0):
        return False
    if not (test[0] > 0 if strict else test[0] >= 0):
        return False
    rest = crossings
    while common.degree() > 0:  # at the common roots test vanishes, which only a strict test minds
        rest = rest // common
        common = rest.gcd(common)
    for bits in BITS:
        with working_precision(bits):
            value = arb_poly(test)
            values = [value(root) for root, _ in positive_roots(rest)]
            if all(v > 0 for v in values):
                return True
            if any(v < 0 for v in values):
                return False
    return False


def unstable_kind(system: Rational, gain: Fraction) -> Kind:
    """What the linear loop with an unstable gain does: solutions without rest, or equilibria other than 0.

    Raises
    ------
    NotShown
        The loop is asymptotically stable, or has no solution.
    """
    require(1 + gain * system.feedthrough != 0, "with this gain the loop has no solution")
    closed = system.plant.shifted(gain)
    counts = closed.counts
    require(counts.right + counts.axis > 0, "the loop with this gain is asymptotically stable")
    at_zero = 0
    while closed.d[at_zero] == 0:
        at_zero += 1
    if counts.right > 0 or counts.axis > at_zero:
        return "no rest"
    return "equilibria" if at_zero == 1 or _semisimple(system, gain, at_zero) else "no rest"


def critical_end(system: Rational, nonlinearities: Nonlinearities) -> bool:
    """Whether an end of the class is its critical case: other equilibria than 0 then refute nothing.

    At the upper end that is the critical case of ``-H`` and ``-phi``.
    """
    for end, sign in zip(nonlinearities.ends, (1, -1), strict=True):
        if end is None or 1 + end * system.feedthrough == 0:
            continue
        plant = system.plant.shifted(end)
        if plant.case == "critical" and sign * plant.residue > 0:
            return True
    return False


def positive_root(system: Delayed, gain: Fraction, least: Fraction | None) -> Kind:
    """What a gain with dead time does whose equation ``d + gain n = 0`` has a real root ``s >= 0``.

    For large ``s > 0`` the sign is that of ``d``, as the other terms are strictly proper.  At the ``least`` gain of the
    class a root 0 may be the critical case, which is no refutation.

    Raises
    ------
    NotShown
        The sign at 0 is the same.
    """
    start = system.at_zero + to_fmpq(gain) * sum((n[0] for _, n in system.terms), fmpq(0))
    start *= system.d[system.d.degree()]
    require(bool(start <= 0), "no real root s >= 0 is shown")
    require(bool(start < 0) or gain != least or not _is_critical(system, gain), "a root 0 of the critical case")
    return "no rest" if start < 0 else "equilibria"


def _is_critical(system: Delayed, gain: Fraction) -> bool:
    try:
        return shifted(system, gain).case == "critical"
    except NotShown:
        return False


def require_crossing(
    system: Rational | Delayed, gains: tuple[Fraction, Fraction], band: tuple[Fraction, Fraction]
) -> None:
    """Check that for some gain between two the loop has a root ``i omega`` with ``omega`` in the band, ``omega > 0``.

    Between two frequencies where ``Im(n conj(d))`` has opposite signs it vanishes; halved until the gain
    ``-|d|^2/Re(n conj(d))`` is known well enough.

    Raises
    ------
    NotShown
        No sign change, or the gain is not shown to lie between the two.
    """
    (low, high), (start, end) = gains, band
    require(low <= high and 0 <= start < end, "the gains or frequencies do not ascend")
    if isinstance(system, Delayed):
        found = _crosses(_delayed_response(system), gains, band)
    else:
        direct = system.feedthrough
        require((1 + low * direct) * (1 + high * direct) > 0, "with one of the gains the loop has no solution")
        found = _crosses(_response(system.plant.n, system.plant.d), gains, band)
        if (
            system.discrete and not found and end <= 3
        ):  # frequencies in radians per sample instead of those of the mapped block
            n, d = system.polynomials
            found = _crosses(_sampled_response(n, d), gains, band)
    require(found, "no gain of the range is shown to have a root on the axis in the band")


def _crosses(
    response: Callable[[arb], tuple[acb, acb]], gains: tuple[Fraction, Fraction], band: tuple[Fraction, Fraction]
) -> bool:
    with working_precision(CROSSING_BITS):
        low, high = ball(gains[0]), ball(gains[1])
        left, right = ball(band[0]), ball(band[1])

        def cross(omega: arb) -> acb:
            """``n conj(d)``."""
            n, d = response(omega)
            return n * d.conjugate()

        at_left, at_right = cross(left).imag, cross(right).imag
        if not at_left * at_right < 0:
            return False
        sign = at_left > 0
        for _ in range(HALVINGS):
            box = left.union(right)
            n, d = response(box)
            gain = -(d * d.conjugate()).real / (n * d.conjugate()).real
            if gain > low and gain < high:
                return True  # the signs at the ends differ from 0, so that the root is inside the band, and not at 0
            middle = ((left + right) / 2).mid()
            value = cross(middle).imag
            if value > 0:
                left, right = (middle, right) if sign else (left, middle)
            elif value < 0:
                left, right = (left, middle) if sign else (middle, right)
            else:
                return False
    return False


def _response(n: fmpq_poly, d: fmpq_poly) -> Callable[[arb], tuple[acb, acb]]:
    def values(omega: arb) -> tuple[acb, acb]:
        """``n`` and ``d`` at ``i omega``."""
        s = acb(0, omega)
        return _at(n, s), _at(d, s)

    return values


def _sampled_response(n: fmpq_poly, d: fmpq_poly) -> Callable[[arb], tuple[acb, acb]]:
    def values(omega: arb) -> tuple[acb, acb]:
        """``n`` and ``d`` at ``exp(i omega)``."""
        z = acb(omega.cos(), omega.sin())
        return _at(n, z), _at(d, z)

    return values


def _delayed_response(system: Delayed) -> Callable[[arb], tuple[acb, acb]]:
    def values(omega: arb) -> tuple[acb, acb]:
        """The same with dead time."""
        s, below = acb(0, omega), ((Fraction(0), system.d), *system.back)
        top, bottom = (
            sum((_at(p, s) * (-s * ball(delay)).exp() for delay, p in side), acb(0)) for side in (system.terms, below)
        )
        return top, bottom

    return values


def _at(p: fmpq_poly, s: acb) -> acb:
    return acb_poly([acb(arb(c)) for c in p.coeffs()])(s) if p.degree() >= 0 else acb(0)


def _semisimple(system: Rational, gain: Fraction, multiplicity: int) -> bool:
    rows = system.states.closed(gain)
    shift = Fraction(int(system.discrete))
    matrix = fmpq_mat(
        [[to_fmpq(v - (shift if i == j else 0)) for j, v in enumerate(row)] for i, row in enumerate(rows)]
    )
    return len(rows) - matrix.rank() == multiplicity

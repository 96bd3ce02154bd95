"""Boxes for the certificates of inequalities with delays: intervals on which the checker's tests will succeed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from flint import acb, acb_poly, arb

from lure.analysis.certificates.arithmetic import Form
from lure.analysis.certificates.balls import box, tail
from lure.analysis.certificates.blocks import block
from lure.analysis.certificates.checker import inequality
from lure.analysis.certificates.states import classes
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.errors import AssumptionError, Reason
from lure.record import described, quantity

BITS = 256
ORDER = 7
MAX_BOXES = 2000
MAX_DOUBLINGS = 14
REFINEMENTS = 4
HALVINGS = 30
SHORT = 2**12
SHORTEST = 2**24


class Uncovered(AssumptionError):
    """No cover was found: the inequality fails somewhere, or nearly so, or would need too many boxes."""

    def __init__(self, message: str) -> None:
        super().__init__(message, code=Reason.PRECISION)


@described(frozen=True, slots=True)
class CoverTests:
    """The tests of an inequality that the checker will repeat."""

    reach: Callable[[Fraction, Fraction], Fraction] = quantity(
        "A length ``h``, at most the one given, such that the inequality passes quickly on ``[a, a + h]``; may be tiny"
    )
    inside: Callable[[Fraction, Fraction], bool] = quantity(
        "Whether the inequality passes on ``[a, b]``, by a test that takes longer"
    )
    beyond: Callable[[Fraction], bool] = quantity("Whether it passes from ``a`` on")
    delay: Fraction = quantity("The largest delay", "s")


def cover(tests: CoverTests) -> list[list[str]]:
    r"""Neighbouring intervals from 0 on, each of which passes its test, as does everything beyond the last.

    Returns
    -------
    list of [str, str]
        ``boxes`` of a certificate.

    Raises
    ------
    Uncovered
        There is no tail within reach, or a box fails however short it is, or there are too many.

    Notes
    -----
    The quick test serves down to intervals far shorter than ``1/delay``; where the inequality is so tight that it
    would need shorter ones, the slow test is asked about longer ones.
    """
    unit = _power_of_two(1 / tests.delay)
    end = _tail_start(tests, unit)
    found: list[list[str]] = []
    left = Fraction(0)
    while left < end:
        checkpoint()
        length = min(tests.reach(left, 4 * unit), end - left)
        if length * SHORT < unit and left + length < end:
            length = _slow(tests, left, unit)
        found.append([str(left), str(left + length)])
        left += length
        if len(found) > MAX_BOXES:
            raise Uncovered(f"{MAX_BOXES} boxes cover the frequencies up to {float(left):.6g} rad/s only")
    return found


def cover_proof(draft: Mapping[str, Any]) -> dict[str, Any]:
    """The proof by a cover for a certificate that has everything else.

    ``draft``: with ``system``, ``laws``, ``theorem`` and ``multiplier``, so that :func:`has_delays`.

    Returns
    -------
    dict
        ``proof`` of the certificate.

    Raises
    ------
    Rejected
        A hypothesis beside the inequality fails.
    Uncovered
        No cover was found.
    """
    F, degree, critical, _ = inequality(
        draft["theorem"], draft["multiplier"], block(draft["system"]), classes(draft["laws"])
    )
    tests = CoverTests(
        reach=lambda a, most: quick_reach(F, a, most, critical=critical),
        inside=lambda a, b: box(F, a, b, ORDER, critical),
        beyond=lambda a: tail(F, a, degree),
        delay=max((abs(tau) for tau, _ in F), default=Fraction(0)) or Fraction(1),
    )
    return {"method": "cover", "boxes": cover(tests), "order": ORDER}


def has_delays(draft: Mapping[str, Any]) -> bool:
    """Whether the inequality of a certificate has terms with delay, so that polynomials do not decide it."""
    delays = any("delay" in kernel for kernel in draft["multiplier"].get("kernels", ()))
    return draft["system"]["kind"] == "delay" or delays


def quick_reach(F: Form, a: Fraction, most: Fraction, *, critical: bool) -> Fraction:
    r"""A length on which the polynomial below ``Re F(a + t)`` has no need of Sturm's theorem.

    That is ``b_0 + sum_i min(b_i, 0) h^i > 0`` for the coefficients ``b_i`` of the polynomial of
    :func:`lure.analysis.certificates.balls.box`.

    Parameters
    ----------
    F : Form
        The inequality, ``sum (u + i v) omega^n exp(-i omega tau)``.
    a : Fraction
        Left end [rad/s].
    most : Fraction
        The largest length to consider.
    critical : bool
        Whether ``Re F`` vanishes at 0 to second order and is divided by ``omega^2`` there.

    Returns
    -------
    Fraction
        ``most`` or 3/4 of it, divided by a power of two; the shortest considered may not pass.
    """
    with working_precision(BITS):
        below = _below(F, a)
        below = below[2:] if critical and a == 0 else below
        for halvings in range(HALVINGS):
            for share in (Fraction(1), Fraction(3, 4)):
                length = share * most / Fraction(2) ** halvings
                h = ball(length)
                if sum((b * h**i for i, b in enumerate(below) if i and not b > 0), below[0]) > 0:
                    return length
    return length


def _below(F: Form, a: Fraction) -> list[arb]:
    """Coefficients in ``t`` of a polynomial that is at most ``Re F(a + t)``, ``t >= 0``."""
    total, shift = acb_poly([0]), acb_poly([ball(a), 1])
    for tau in {tau for tau, _ in F}:
        top = max(n for other, n in F if other == tau)
        terms = [F.get((tau, n), (Fraction(0), Fraction(0))) for n in range(top + 1)]
        moved = acb_poly([acb(ball(u), ball(v)) for u, v in terms])(shift)
        if tau == 0:
            total += moved
            continue
        turn, series = acb(0, -1) * ball(tau), [acb(1)]
        for j in range(1, ORDER):
            series.append(series[-1] * turn / j)
        size = acb_poly([abs(c.real) + abs(c.imag) for c in moved.coeffs()])
        rest = acb_poly([0] * ORDER + [-4 * series[-1].abs_upper() * abs(ball(tau)) / ORDER])
        total += moved * acb_poly(series) * (turn * ball(a)).exp() + size * rest
    return [c.real for c in total.coeffs()] or [arb(0)]


def _slow(tests: CoverTests, left: Fraction, unit: Fraction) -> Fraction:
    """The largest of some lengths that pass the slow test."""
    length = unit / 4
    while not tests.inside(left, left + length):
        length /= 4
        if length * SHORTEST < unit:
            raise Uncovered(f"the inequality does not pass, or only just, at {float(left):.9g} rad/s")
    return length


def _tail_start(tests: CoverTests, unit: Fraction) -> Fraction:
    """A short number from which on the inequality passes."""
    end = unit
    for _ in range(MAX_DOUBLINGS):
        if tests.beyond(end):
            break
        end *= 2
    else:
        raise Uncovered(f"the terms with delay are not outweighed by the others from {float(end / 2):.6g} rad/s on")
    step = end / 4
    for _ in range(REFINEMENTS):
        if tests.beyond(end - step):
            end -= step
        step /= 2
    return end


def _power_of_two(size: Fraction) -> Fraction:
    """A power of two between a half of a number and the number."""
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    power = Fraction(2) ** exponent
    return power if power <= size else power / 2

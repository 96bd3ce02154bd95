"""Boxes for the certificates of inequalities with delays: found with the checker's own tests, one box at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from analysis.certificates.arithmetic import box, tail
from analysis.certificates.blocks import block
from analysis.certificates.checker import inequality
from analysis.certificates.states import classes
from lure.errors import AssumptionError

ORDER = 8
MAX_BOXES = 2000
MAX_DOUBLINGS = 14
REFINEMENTS = 4
HALVINGS = 24
RUN = 3


class Uncovered(AssumptionError):
    """No cover was found: the inequality fails somewhere, or nearly so, or would need too many boxes."""


@dataclass(frozen=True, slots=True)
class CoverTests:
    """The two tests of an inequality that the checker will repeat.

    Attributes
    ----------
    inside : callable
        Whether the inequality passes on ``[a, b]``.
    beyond : callable
        Whether it passes from ``a`` on.
    delay : Fraction
        The largest delay [s].
    """

    inside: Callable[[Fraction, Fraction], bool]
    beyond: Callable[[Fraction], bool]
    delay: Fraction


def cover(tests: CoverTests) -> list[list[str]]:
    r"""Neighbouring intervals from 0 on, each of which passes its test, as does everything beyond the last.

    Parameters
    ----------
    tests : CoverTests
        The inequality.

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
    Intervals are of about the length ``1/delay`` to begin with; three in a row that pass double it, one that fails
    halves it.
    """
    unit = _power_of_two(1 / tests.delay)
    end = _tail_start(tests, unit)
    found: list[list[str]] = []
    left, length, run = Fraction(0), unit, 0
    while left < end:
        right = min(left + length, end)
        if tests.inside(left, right):
            found.append([str(left), str(right)])
            left, run = right, run + 1
            if run >= RUN and (left / (2 * length)).denominator == 1:
                length, run = 2 * length, 0
        else:
            length, run = length / 2, 0
        if length * 2**HALVINGS < unit or len(found) > MAX_BOXES:
            raise Uncovered(f"no cover from {float(left):.6g} rad/s on with up to {MAX_BOXES} boxes was found")
    return found


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


def has_delays(draft: Mapping[str, Any]) -> bool:
    """Whether the inequality of a certificate has terms with delay, so that polynomials do not decide it.

    Parameters
    ----------
    draft : Mapping
        The certificate, or what there is of it.
    """
    delays = any("delay" in kernel for kernel in draft["multiplier"].get("kernels", ()))
    return draft["system"]["kind"] == "delay" or delays


def cover_proof(draft: Mapping[str, Any]) -> dict[str, Any]:
    """The proof by a cover for a certificate that has everything else.

    Parameters
    ----------
    draft : Mapping
        With ``system``, ``laws``, ``theorem`` and ``multiplier``, so that :func:`has_delays`.

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
        inside=lambda a, b: box(F, a, b, ORDER, critical),
        beyond=lambda a: tail(F, a, degree),
        delay=max((abs(tau) for tau, _ in F), default=Fraction(0)) or Fraction(1),
    )
    return {"method": "cover", "boxes": cover(tests), "order": ORDER}

"""Popov's and Park's multipliers in the form of Zames and Falb: the search starts from them and never falls behind."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from analysis.answer import Answer
from analysis.criteria.kernels import Gamma, Multiplier
from analysis.criteria.park import park_largest
from analysis.criteria.popov import popov_largest
from analysis.evidence import Verdict
from lure.rational import RationalBlock

BITS = 300
DENOMINATORS = (10**3, 10**6, 10**12, 2**BITS)


def seeds(block: RationalBlock, lower: Fraction) -> Iterator[tuple[Fraction | None, Multiplier]]:
    """Slopes (None: every finite one) and multipliers that should prove them; each is to be checked.

    Parameters
    ----------
    block : RationalBlock
        In continuous time, strictly stable with the gain ``lower``.
    lower : Fraction
        Lower slope.
    """
    for answer in (popov_largest(block, lower=lower), park_largest(block, lower=lower)):
        if answer.verdict is Verdict.PROVED:
            k = None if math.isinf(answer.largest.low) else Fraction(answer.largest.low)
            for multiplier in _forms(answer):
                yield k, multiplier


def _forms(answer: Answer) -> Iterator[Multiplier]:
    theta, tau, ratio = (answer.parameters.get(name) for name in ("theta", "tau", "theta/tau"))
    if tau == "inf" and ratio is not None:
        yield from (first_order(None, Fraction(str(ratio)), size) for size in DENOMINATORS)
    elif theta is not None and theta not in ("inf", "-inf"):
        weight, squared = Fraction(str(theta)), Fraction(str(tau or 0))
        if squared == 0:
            yield Multiplier(weight, ())
        else:
            yield from (first_order(1 / squared, weight / squared, size) for size in DENOMINATORS)


def first_order(product: Fraction | None, difference: Fraction, size: int) -> Multiplier:
    r"""Park's multiplier ``1 + theta s - tau s^2 = tau (a - s)(b + s)`` as ``1 - c h^`` with an exponential ``h``.

    On the axis it is a positive multiple of ``(b + s)/(a + s) = 1 - ((a - b)/a) a/(a + s)``, used if ``b <= a``, and of
    ``(a - s)/(b - s) = 1 - ((b - a)/b) b/(b - s)``, used if ``a < b``.

    Parameters
    ----------
    product : Fraction or None
        ``a b = 1/tau`` [1/s^2]; None for ``tau = inf``, where it is 0.
    difference : Fraction
        ``a - b = theta/tau`` [1/s].
    size : int
        Denominators of the rounded ``a`` and ``b``, relative to their size.
    """
    if difference == 0:
        return Multiplier(Fraction(0), ())
    larger = (abs(difference) + _root(difference**2 + 4 * (product or 0))) / 2
    smaller = larger - abs(difference)
    rate = _rounded(larger, size)
    share = 1 - _rounded(smaller / larger, size) if product else Fraction(1)
    return Multiplier(Fraction(0), ((share, Gamma(rate, 1, "causal" if difference > 0 else "anticausal")),))


def _root(value: Fraction) -> Fraction:
    shift = 2 * BITS + value.denominator.bit_length()
    return Fraction(math.isqrt(value.numerator * 4**shift // value.denominator), 2**shift)


def _rounded(value: Fraction, size: int) -> Fraction:
    scale = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length())
    return (value / scale).limit_denominator(size) * scale

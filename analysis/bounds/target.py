"""What is bounded on an interval, and the parts the interval is divided into."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from analysis.bounds.extremes import Candidate, Cover, End
from lure.expressions.tree import Node


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """A function of ``sigma`` on an open interval, in two shapes.

    Attributes
    ----------
    tree : Node
        For boxes: ``phi(sigma)/sigma`` with what cancels cancelled, or the derivative.
    base : Node
        For the ends: ``phi``, or the derivative.
    over_sigma : bool
        Whether ``base`` is still to be divided by ``sigma``.
    low, high : Fraction, or an infinity
        The interval.
    vanishes : bool
        Whether ``base`` is known to tend to 0 at 0, whatever rounding leaves of it.
    """

    tree: Node
    base: Node
    over_sigma: bool
    low: End
    high: End
    vanishes: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class Region:
    """A part of the interval with what is known of the values there.

    Attributes
    ----------
    box : pair of Fraction, or None
        A closed interval without a singular end.
    end : tuple or None
        Instead: an end, the side on which the interval lies, and ``n`` for the stretch ``0 < t <= 2^-n``.
    cover : Cover
        What the values lie between.
    found : tuple of Candidate
        Values there.
    closed : bool
        Whether ``cover`` is as narrow as it will get.
    """

    box: tuple[Fraction, Fraction] | None
    end: tuple[End, int, int] | None
    cover: Cover
    found: tuple[Candidate, ...] = ()
    closed: bool = False

    @property
    def unknown(self) -> bool:
        """Whether nothing is known of a box, not even that the law has values there."""
        return self.box is not None and self.cover.low == -math.inf and self.cover.high == math.inf


def border(end: End, side: int, stage: int) -> Fraction:
    """``sigma`` at ``t = 2^-stage``."""
    if isinstance(end, Fraction):
        return end + side * Fraction(1, 2**stage)
    return Fraction(2**stage if end > 0 else -(2**stage))


def middle(a: Fraction, b: Fraction) -> Fraction:
    """The middle, in the logarithm for ends of one sign far apart."""
    if (a > 0 and b > 4 * a) or (b < 0 and a < 4 * b):
        sign = 1 if a > 0 else -1
        low, high = sorted((abs(a), abs(b)))
        exponent = (_log2(low) + _log2(high)) // 2
        guess = Fraction(2**exponent) if exponent >= 0 else Fraction(1, 2**-exponent)
        if low < guess < high:
            return sign * guess
    return (a + b) / 2


def _log2(x: Fraction) -> int:
    return x.numerator.bit_length() - x.denominator.bit_length()

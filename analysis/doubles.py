"""Exact numbers rounded to doubles in a stated direction."""

from __future__ import annotations

import math
import sys
from fractions import Fraction


def double_below(value: Fraction) -> float:
    """The largest double not above an exact number; ``-inf`` below all of them."""
    try:
        nearest = float(value)
    except OverflowError:
        return sys.float_info.max if value > 0 else -math.inf
    return nearest if Fraction(nearest) <= value else math.nextafter(nearest, -math.inf)


def double_above(value: Fraction) -> float:
    """The least double not below an exact number; ``inf`` above all of them."""
    return -double_below(-value)

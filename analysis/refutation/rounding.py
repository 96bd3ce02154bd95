"""Exact numbers for records: rounded up, and as short text."""

from __future__ import annotations

import math
from fractions import Fraction


def rounded_up(value: Fraction) -> float:
    """The least double not below ``value``; ``inf`` beyond the largest."""
    try:
        nearest = float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.nextafter(math.inf, 0.0)
    return nearest if Fraction(nearest) >= value else math.nextafter(nearest, math.inf)


def short(value: Fraction) -> str:
    """``p/q`` if that is short, else ten digits."""
    text = str(value)
    return text if len(text) <= 15 else f"{float(value):.10g}"

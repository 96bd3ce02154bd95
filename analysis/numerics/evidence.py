"""What a number rests on, and the interval in which it lies."""

from __future__ import annotations

import math
from enum import Enum
from functools import total_ordering

from lure.analysis.numerics.doubles import text_above, text_below
from lure.record import Record, plain


@total_ordering
class Evidence(Enum):
    """What a claim rests on, weakest first: ``OBSERVED < COMPUTED < CERTIFIED``.

    ``CERTIFIED``: exact or rigorous (ball) arithmetic over the whole claim.  ``COMPUTED``: floating point with an error
    estimate.  ``OBSERVED``: a simulation or a sample.
    """

    OBSERVED = "observed"
    COMPUTED = "computed"
    CERTIFIED = "certified"

    def __lt__(self, other: object) -> bool:
        if not isinstance(other, Evidence):
            return NotImplemented
        order = [Evidence.OBSERVED, Evidence.COMPUTED, Evidence.CERTIFIED]
        return order.index(self) < order.index(other)

    def __str__(self) -> str:
        return self.value


class Bracket(Record, kw_only=False):
    """An interval that contains a number: ``low <= number <= high``; ``inf`` stands for itself.

    Parameters
    ----------
    low, high : float
        The ends, ``low <= high``.

    Raises
    ------
    ValueError
        A bound is NaN, or ``low > high``.

    Examples
    --------
    >>> print(Bracket(1.0, 1.0 + 1e-9))
    1 .. 1.000000001
    """

    low: float
    high: float
    _title = "An interval that contains a number"

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(f"Bracket needs low <= high; got {self.low}, {self.high}")

    @property
    def middle(self) -> float:
        """Midpoint; ``inf`` if the upper bound is."""
        return self.low if self.low == self.high else 0.5 * self.low + 0.5 * self.high

    @property
    def width(self) -> float:
        """``high - low``; zero where both are the same infinity."""
        return 0.0 if self.low == self.high else self.high - self.low

    def __str__(self) -> str:
        if self.low == self.high:
            return f"{self.low:.15g}" if float(f"{self.low:.15g}") == self.low else repr(self.low)
        return f"{text_below(self.low)} .. {text_above(self.high)}"


def ends(bracket: Bracket | None) -> list[object] | None:
    """Both ends of a bracket as plain JSON data, None for none."""
    return None if bracket is None else [plain(bracket.low), plain(bracket.high)]


INFINITE = Bracket(math.inf, math.inf)

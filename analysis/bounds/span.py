"""Intervals with two ends in ball arithmetic: a radius has 30 bits, too few for a wide interval that must end at 0."""

from __future__ import annotations

from dataclasses import dataclass

from flint import arb


@dataclass(frozen=True, slots=True)
class Span:
    """All numbers from ``low`` to ``high``, exact balls."""

    low: arb
    high: arb

    @classmethod
    def of(cls, value: arb) -> Span:
        """The interval of a ball."""
        return cls(value.lower(), value.upper())

    @property
    def is_zero(self) -> bool:
        """Whether it holds 0 alone."""
        return bool(self.low == 0) and bool(self.high == 0)

    @property
    def is_finite(self) -> bool:
        """Whether both ends are."""
        return self.low.is_finite() and self.high.is_finite()

    @property
    def sign(self) -> int | None:
        """1 or -1 if 0 does not belong to it, else None."""
        return 1 if self.low > 0 else -1 if self.high < 0 else None

    @property
    def ball(self) -> arb:
        """A ball that contains it."""
        return self.low.union(self.high)

    @property
    def size(self) -> Span:
        """The absolute values."""
        if self.low >= 0:
            return self
        if self.high <= 0:
            return -self
        return Span(arb(0), (-self.low).max(self.high))

    def __neg__(self) -> Span:
        return Span(-self.high, -self.low)

    def __add__(self, other: Span) -> Span:
        return Span((self.low + other.low).lower(), (self.high + other.high).upper())

    def __mul__(self, other: Span) -> Span:
        products = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        low, high = products[0].lower(), products[0].upper()
        for product in products[1:]:
            low, high = low.min(product.lower()), high.max(product.upper())
        return Span(low, high)

    def inverse(self) -> Span:
        """``1/x`` for an interval without 0."""
        return Span((1 / self.high).lower(), (1 / self.low).upper())

    def power(self, exponent: arb) -> Span:
        """``x**exponent`` for a positive interval."""
        ends = self.low**exponent, self.high**exponent
        return Span(ends[0].lower().min(ends[1].lower()), ends[0].upper().max(ends[1].upper()))

    def joined(self, other: Span) -> Span:
        """The hull of both."""
        return Span(self.low.min(other.low), self.high.max(other.high))


NOTHING = Span(arb(0), arb(0))

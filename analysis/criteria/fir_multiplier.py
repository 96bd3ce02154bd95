"""Multipliers of finite impulse response with exact taps, and the exact test of the Zames-Falb inequality."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq_poly

from analysis.criteria.discrete_block import DiscreteBlock
from analysis.polynomial import to_fmpq
from analysis.trigonometric import Laurent, nonnegative_on_circle, positive_on_circle

Taps = Mapping[int, Fraction]


@dataclass(frozen=True, kw_only=True, slots=True)
class Multiplier:
    r"""``M(z) = 1 - sum_i h_i z^-i`` with exact taps ``h_i``, ``i != 0``.

    Raises
    ------
    ValueError
        A tap at shift 0.
    """

    taps: Taps

    def __post_init__(self) -> None:
        if 0 in self.taps:
            raise ValueError("Multiplier.taps holds the shift 0; its coefficient is 1")

    def legal(self, *, odd: bool) -> bool:
        """Whether ``sum |h_i| < 1`` and, unless ``phi`` is odd, every ``h_i >= 0``."""
        return sum(abs(h) for h in self.taps.values()) < 1 and (odd or all(h >= 0 for h in self.taps.values()))

    @property
    def laurent(self) -> Laurent:
        """As a Laurent polynomial."""
        reach = max((abs(i) for i in self.taps), default=0)
        coefficients = [to_fmpq(-self.taps.get(reach - j, Fraction(0))) for j in range(2 * reach + 1)]
        coefficients[reach] = to_fmpq(1)
        return Laurent(fmpq_poly(coefficients), reach)

    def __str__(self) -> str:
        parts = ["M(z) = 1"]
        for i, h in sorted(self.taps.items()):
            power = "z" if i == -1 else f"z^{-i}"
            parts.append(f"{'-' if h > 0 else '+'} {float(abs(h)):.8g} {power}")
        return " ".join(parts)


def inequality(discrete: DiscreteBlock, multiplier: Multiplier, width: Fraction | None) -> fmpq_poly:
    """``|d|^2 Re[M (H + 1/width)]`` on the circle as a polynomial in ``cos w``; without ``1/width`` if it is None."""
    sum_ = discrete.cross
    if width is not None:
        sum_ = sum_ + (discrete.d * discrete.d.conjugate()).scaled(1 / width)
    return (multiplier.laurent * sum_).real_part()


def certifies(discrete: DiscreteBlock, multiplier: Multiplier, width: Fraction, *, odd: bool) -> bool:
    r"""Whether the multiplier proves the classes of slopes in ``[0, width]`` stable for ``H``, decided exactly.

    Parameters
    ----------
    discrete : DiscreteBlock
        The stable block.
    multiplier : Multiplier
        Any taps.
    width : Fraction
        Upper slope, positive.
    odd : bool
        Whether ``phi`` is known to be odd.
    """
    return (
        width > 0
        and multiplier.legal(odd=odd)
        and discrete.well_posed(width)
        and positive_on_circle(inequality(discrete, multiplier, width))
    )


def certifies_every(discrete: DiscreteBlock, multiplier: Multiplier, *, odd: bool) -> bool:
    """The same for every finite width at once: ``Re[M H] >= 0``, since ``Re M > 0``."""
    return (
        multiplier.legal(odd=odd)
        and discrete.feedthrough >= 0
        and nonnegative_on_circle(inequality(discrete, multiplier, None))
    )

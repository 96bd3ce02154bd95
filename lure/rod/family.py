"""Rods whose parameters are known only to lie in intervals: what is said of one of them is said of all."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import ClassVar

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.plants.block import StructuredPlant
from lure.record import described, exact_text, quantity
from lure.rod.discretisation import upwind
from lure.rod.parameters import Rod
from lure.rod.transfer import LETTERS, RodPlant

Interval = tuple[Fraction, Fraction]
VARIED = ("youngs_modulus", "density", "length", "area", "damping", "compliance")
"""The parameters that may be intervals."""


def require_varied(intervals: Mapping[str, Interval]) -> None:
    """Refuse intervals to parameters that have none, in the wrong order, or of what is not positive."""
    for name, (low, high) in intervals.items():
        if name not in VARIED:
            raise InputError(f"rod.{name} has an interval; give one number, or intervals to {', '.join(VARIED)}")
        if not low < high:
            raise InputError(f"rod.{name} is [{float(low):g}, {float(high):g}]; give the smaller number first")
        if low <= 0 and name != "damping":
            raise InputError(f"rod.{name} is [{float(low):g}, {float(high):g}]; give positive numbers")


@described(frozen=True)
class RodFamily(StructuredPlant):
    """All rods with some parameters in intervals, constant but unknown, or all of their schemes with ``N`` cells.

    Raises
    ------
    InputError
        There is no interval, one is none or of another parameter, a rod of the box has a parameter that is not
        positive where it must be, or the exponent of the contact law is below 1.
    """

    rod: Rod = quantity("The rod with these in the middle of their intervals")
    intervals: Mapping[str, Interval] = quantity("Of some of :data:`VARIED`, the smaller end first")
    cells: int | None = quantity("``N`` of the schemes; None for the rods themselves", default=None)
    response_units: ClassVar[tuple[str, str]] = RodPlant.response_units
    gain_letter: ClassVar[str] = RodPlant.gain_letter

    def __post_init__(self) -> None:
        if not self.intervals:
            raise InputError("no parameter of the rod has an interval; give one, such as damping = [900, 1100]")
        require_varied(self.intervals)
        if self.rod.exact["exponent"] < 1:
            raise InputError(
                f"rod.exponent is {self.rod.exponent:g} beside intervals, and what is proved of all rods is about "
                "locally Lipschitz contact laws; give at least 1"
            )

    def __hash__(self) -> int:
        return hash((self.rod, self.cells, *self.intervals.items()))

    @property
    def name(self) -> str:
        """``the rod``, or ``the scheme with N cells``."""
        return "the rod" if self.cells is None else upwind(self.rod, self.cells).name

    @property
    def order(self) -> int | None:
        """None for rods; the number of states of their schemes."""
        return None if self.cells is None else 2 * self.cells + 1

    @property
    def ranges(self) -> str:
        """The intervals in words."""
        pairs = ((name, ends) for name, ends in self.intervals.items())
        return ", ".join(f"{name} in [{exact_text(low, 8)}, {exact_text(high, 8)}]" for name, (low, high) in pairs)

    def bounds(self, name: str) -> Interval:
        """The interval of a parameter; of one that has none both ends are its value."""
        value = self.rod.exact[name]
        return self.intervals.get(name, (value, value))

    def with_ends(self, damping: int, others: int) -> Rod:
        """The rod with the least (0) or the most (1) damping, the same of ``E``, ``rho`` and ``A``, and the longest."""
        ends = {name: self.bounds(name)[others] for name in ("youngs_modulus", "density", "area")}
        return self.rod.replace(**ends, damping=self.bounds("damping")[damping], length=self.bounds("length")[1])

    @property
    def hardest(self) -> tuple[Rod, Rod]:
        """The rods at which the conditions of the theorems are hardest; for a damping that is positive in the box."""
        return self.with_ends(1, 0), self.with_ends(0, 1)

    def certificate_system(self) -> Mapping[str, object]:
        """The kind and the bounds of the parameters that the loop depends on."""
        pairs = [[letter, *map(str, self.bounds(name))] for letter, name in LETTERS.items()]
        if self.cells is None:
            return {"kind": "rod-family", "parameters": pairs}
        return {"kind": "rod-scheme-family", "parameters": pairs, "cells": self.cells}

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H(s)`` of the rod, or its scheme, in the middle."""
        middle = RodPlant(self.rod) if self.cells is None else upwind(self.rod, self.cells)
        return middle.transfer(s)

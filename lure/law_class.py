"""Classes of nonlinearities: what is assumed of ``phi``, and nothing more."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lure.errors import InputError
from lure.sector import Sector, SlopeBounds
from lure.showing import html_table, plain


@dataclass(frozen=True, kw_only=True, slots=True)
class LawClass:
    r"""All ``phi`` with ``phi(0) = 0`` that satisfy the properties listed; a theorem holds for every one of them.

    Parameters
    ----------
    sector : Sector
        Bounds on ``phi(sigma) / sigma``.
    slope : SlopeBounds or None
        Bounds on every difference quotient, None if nothing is assumed of them.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    time_varying : bool
        Whether ``phi`` may depend on time; then ``slope`` and ``odd`` hold at each time.

    Raises
    ------
    InputError
        The slope bounds lie outside the sector's: members would leave the sector; or the bounds coincide.

    Examples
    --------
    >>> print(LawClass(sector=Sector(0, 2), slope=SlopeBounds(0, 2), odd=True))
    odd phi with slope in [0, 2]
    """

    sector: Sector
    slope: SlopeBounds | None = None
    odd: bool = False
    time_varying: bool = False

    def __post_init__(self) -> None:
        for bounds in (self.sector, self.slope):
            if bounds is not None and bounds.lower == bounds.upper:
                raise InputError(
                    f"LawClass has the bounds {bounds}, in which only a straight line lies; a linear gain belongs into "
                    "the block"
                )
        if self.slope is not None and (self.slope.lower > self.sector.lower or self.slope.upper < self.sector.upper):
            raise InputError(
                f"LawClass has the sector {self.sector} and the slope bounds {self.slope}: a law with these slopes "
                "lies in the sector of the same bounds; give a sector inside the slope bounds"
            )

    @classmethod
    def slope_restricted(cls, lower: float | Fraction, upper: float | Fraction, *, odd: bool = False) -> LawClass:
        """Time-invariant laws with slope in ``[lower, upper]``, hence in the same sector."""
        return cls(sector=Sector(lower, upper), slope=SlopeBounds(lower, upper), odd=odd)

    def __str__(self) -> str:
        words = "odd phi" if self.odd else "phi"
        bounds = f"slope in {self.slope}" if self.slope is not None else f"sector {self.sector}"
        if self.slope is not None and (self.slope.lower, self.slope.upper) != (self.sector.lower, self.sector.upper):
            bounds += f" and sector {self.sector}"
        when = ", time-varying" if self.time_varying else ""
        return f"{words} with {bounds}{when}" if self.slope is not None else f"{words} in the {bounds}{when}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: exact bounds as text ``p/q``, infinite ones as ``inf``."""
        return {
            "kind": "class of laws",
            "sector": plain(self.sector),
            "slope": plain(self.slope),
            "odd": self.odd,
            "time_varying": self.time_varying,
            "text": str(self),
        }

    def _repr_html_(self) -> str:
        rows = [
            ("sector", self.sector),
            ("slope", "nothing is assumed" if self.slope is None else self.slope),
            ("odd", "assumed" if self.odd else "not assumed"),
            ("time", "phi may depend on it" if self.time_varying else "phi does not depend on it"),
        ]
        return html_table(f"Class of laws: {self}", rows)

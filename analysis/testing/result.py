"""What an assertion about a law returns, and what it raises."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lure.analysis.testing.subject import Subject
from lure.analysis.verdict import Evidence

if TYPE_CHECKING:
    from lure.analysis.plots.style import Axes

_REMEMBERED = 20


@dataclass(frozen=True, kw_only=True, slots=True)
class Checked:
    """An assertion that passed, and what that rests on.

    Attributes
    ----------
    claim : str
        What was asserted, ``tanh lies in the sector [0, 1]``.
    evidence : Evidence
        CERTIFIED: shown for every ``sigma`` of the interval, by exact or ball arithmetic.  OBSERVED: no violation was
        found where it was looked for, which says nothing about the other points.
    how : str
        What was checked.
    points : int
        How many values of the law were looked at; 0 where none had to be.
    """

    claim: str
    evidence: Evidence
    how: str
    points: int

    def to_dict(self) -> dict[str, object]:
        """The result as plain JSON data."""
        return {"claim": self.claim, "evidence": str(self.evidence), "how": self.how, "points": self.points}

    def _repr_html_(self) -> str:
        from lure.record import html_table

        rows = [("how", self.how), ("evidence", self.evidence), ("values of the law looked at", self.points)]
        seen = () if self.evidence is Evidence.CERTIFIED else ("Nothing is said about the points not looked at.",)
        return html_table(self.claim, rows, verdict=str(self.evidence).upper(), notes=seen)

    def __str__(self) -> str:
        return f"{self.claim}: {self.how} ({self.evidence})"


class History:
    """The last assertions that passed, for the pytest plugin, which asks what a test has shown."""

    def __init__(self) -> None:
        self.total = 0
        self._latest: deque[Checked] = deque(maxlen=_REMEMBERED)

    def add(self, checked: Checked) -> None:
        """Remember one more."""
        self.total += 1
        self._latest.append(checked)

    def since(self, total: int) -> list[Checked]:
        """What passed since there were so many, oldest first and as far as it is remembered."""
        latest = list(self._latest)
        return latest[max(len(latest) - (self.total - total), 0) :]


HISTORY = History()


@dataclass(frozen=True, kw_only=True, slots=True)
class Violation:
    """A point, or a pair of points, at which a law breaks what was asserted.

    Attributes
    ----------
    kind : str
        ``sector``, ``slope`` or ``odd``.
    name : str
        What the law is called.
    claim, denial : str
        What was asserted, and that it is not so.
    quantity : str
        What was measured, ``phi(sigma)/sigma``.
    sigma, phi : tuple of float
        The point or the pair, and the values there.
    found : float
        The quantity there.
    lower, upper : float or Fraction
        What it was allowed to be.
    tolerance : float
        By how much it was allowed to miss.
    slope : float
        Slope of the law at ``sigma``, a difference quotient; NaN if it has none.
    on : tuple of float
        The interval on which it was asserted.
    how : str
        How the violation was found, and what else is known.
    subject : Subject
        The law, for plots.
    """

    kind: str
    name: str
    claim: str
    denial: str
    quantity: str
    sigma: tuple[float, ...]
    phi: tuple[float, ...]
    found: float
    lower: float | Fraction
    upper: float | Fraction
    tolerance: float
    slope: float
    on: tuple[float, float]
    how: str
    subject: Subject = field(repr=False)

    @property
    def bound(self) -> float | Fraction:
        """The bound that is broken."""
        return self.upper if self.found > self.upper else self.lower

    @property
    def excess(self) -> float:
        """How far the quantity lies beyond the bound, in size."""
        return abs(self.found - float(self.bound))

    @property
    def window(self) -> tuple[float, float]:
        """The stretch of ``sigma`` to draw: with the origin, unless a pair is too close for that."""
        if self.kind == "slope":
            low, high = min(self.sigma), max(self.sigma)
            if high - low < 0.04 * max(abs(low), abs(high)):
                return low - 3 * (high - low), high + 3 * (high - low)
        reach = 1.5 * max(map(abs, self.sigma)) or 1.0
        return max(-reach, min(self.on[0], 0.0)), min(reach, max(self.on[1], 0.0))

    def lines(self) -> list[tuple[float, float, float]]:
        """What to draw of the bounds: ``(x0, y0, slope)`` of the straight lines that enclose what was allowed."""
        if self.kind == "odd":
            return []
        x0, y0 = (self.sigma[0], self.phi[0]) if self.kind == "slope" else (0.0, 0.0)
        return [(x0, y0, float(slope)) for slope in (self.lower, self.upper) if abs(slope) != math.inf]

    def to_dict(self) -> dict[str, object]:
        """The violation as plain JSON data, without the law itself; infinite numbers are the text ``inf``."""
        from lure.record import plain

        names = ("kind", "name", "claim", "denial", "quantity", "sigma", "phi", "found", "lower", "upper", "tolerance")
        return {name: plain(getattr(self, name)) for name in (*names, "slope", "on", "how")}

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The law, the lines that bound it and the point; see :func:`lure.analysis.plots.plot_violation`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.sectors import plot_violation

        return plot_violation(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.record import html_table

        rows = [
            (self.quantity, f"{self.found:.10g}"),
            ("allowed", f"{float(self.lower):.10g} to {float(self.upper):.10g}"),
            ("sigma", ", ".join(f"{value:.17g}" for value in self.sigma)),
            ("phi(sigma)", ", ".join(f"{value:.17g}" for value in self.phi)),
            ("how", self.how),
        ]
        return html_table(self.denial, rows, verdict="VIOLATED")

    def save(self, path: Path) -> None:
        """Draw the law and the point into a file.

        Parameters
        ----------
        path : Path
            A name that ends in ``.png`` or ``.svg``; folders are made, and a file of this name is replaced.
        """
        from lure.analysis.plots.sectors import plot_violation
        from lure.analysis.plots.style import render

        picture = render(partial(plot_violation, self), name=self.claim)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture.png if path.suffix == ".png" else picture.svg.encode())


class LawViolation(AssertionError):
    """An assertion about a law failed; ``violation`` says where, None where the law has no value at all."""

    __module__ = "lure.analysis.testing"  # where it is found by people, as it is named in front of each message

    def __init__(self, message: str, violation: Violation | None = None) -> None:
        super().__init__(message)
        self.violation = violation

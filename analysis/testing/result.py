"""What an assertion about a law returns, and what it raises."""

from __future__ import annotations

import math
from collections import deque
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lure.analysis.drawing import drawing
from lure.analysis.testing.subject import Subject
from lure.analysis.verdict import Evidence
from lure.record import Page, Record
from lure.record import quantity as declared

if TYPE_CHECKING:
    from lure.analysis.drawing import Axes

_REMEMBERED = 20


class Checked(Record):
    """An assertion that passed, and what that rests on."""

    claim: str = declared("What was asserted, ``tanh lies in the sector [0, 1]``")
    evidence: Evidence = declared(
        "CERTIFIED: shown for every ``sigma`` of the interval, by exact or ball arithmetic. OBSERVED: no "
        "violation was found where it was looked for, which says nothing about the other points"
    )
    how: str = declared("What was checked")
    points: int = declared("How many values of the law were looked at; 0 where none had to be")

    def _page(self) -> Page:
        rows = [("how", self.how), ("evidence", self.evidence), ("values of the law looked at", self.points)]
        seen = () if self.evidence is Evidence.CERTIFIED else ("Nothing is said about the points not looked at.",)
        return Page(self.claim, rows, verdict=str(self.evidence).upper(), notes=seen)

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


class Violation(Record):
    """A point, or a pair of points, at which a law breaks what was asserted."""

    kind: str = declared("``sector``, ``slope`` or ``odd``")
    name: str = declared("What the law is called")
    claim: str = declared("What was asserted")
    denial: str = declared("That it is not so")
    quantity: str = declared("What was measured, ``phi(sigma)/sigma``")
    sigma: tuple[float, ...] = declared("The point or the pair")
    phi: tuple[float, ...] = declared("The values there")
    found: float = declared("The quantity there")
    lower: float | Fraction = declared("The least it was allowed to be")
    upper: float | Fraction = declared("The largest it was allowed to be")
    tolerance: float = declared("By how much it was allowed to miss")
    slope: float = declared("Slope of the law at ``sigma``, a difference quotient; NaN if it has none")
    on: tuple[float, float] = declared("The interval on which it was asserted")
    how: str = declared("How the violation was found, and what else is known")
    subject: Subject = declared("The law, for plots", hidden=True)

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

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The law, the lines that bound it and the point; see :func:`lure.analysis.plots.plot_violation`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)(self, ax=ax)
        return made

    def _page(self) -> Page:
        rows = [
            (self.quantity, f"{self.found:.10g}"),
            ("allowed", f"{float(self.lower):.10g} to {float(self.upper):.10g}"),
            ("sigma", ", ".join(f"{value:.17g}" for value in self.sigma)),
            ("phi(sigma)", ", ".join(f"{value:.17g}" for value in self.phi)),
            ("how", self.how),
        ]
        return Page(self.denial, rows, verdict="VIOLATED")

    def save(self, path: Path) -> None:
        """Draw the law and the point into a file.

        Parameters
        ----------
        path : Path
            A name that ends in ``.png`` or ``.svg``; folders are made, and a file of this name is replaced.
        """
        picture = drawing(self, task="file")(partial(drawing(self), self), name=self.claim)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture.png if path.suffix == ".png" else picture.svg.encode())


class NonlinearityViolation(AssertionError):
    """An assertion about a law failed; ``violation`` says where, None where the law has no value at all."""

    __module__ = "lure.analysis.testing"  # where it is found by people, as it is named in front of each message

    def __init__(self, message: str, violation: Violation | None = None) -> None:
        super().__init__(message)
        self.violation = violation

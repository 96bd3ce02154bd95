"""What an assertion about a nonlinearity returns, and the text of its failure: a sentence, the numbers, and a plot."""

from __future__ import annotations

import math
import textwrap
from collections import deque
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path

from lure.analysis.drawing import drawing, drawn
from lure.analysis.testing.search import NotANumber, Subject
from lure.analysis.verdict import Evidence
from lure.arrays import Reals, np
from lure.record import Page, Record
from lure.record import quantity as declared
from lure.record.values import exact_text

# What an assertion about a nonlinearity returns, and what it raises.

_REMEMBERED = 20


class Checked(Record):
    """An assertion that passed, and what that rests on."""

    claim: str = declared("What was asserted, ``tanh lies in the sector [0, 1]``")
    evidence: Evidence = declared(
        "CERTIFIED: shown for every ``sigma`` of the interval, by exact or ball arithmetic. OBSERVED: no "
        "violation was found where it was looked for, which says nothing about the other points"
    )
    how: str = declared("What was checked")
    points: int = declared("How many values of the nonlinearity were looked at; 0 where none had to be")

    def _page(self) -> Page:
        rows = [("how", self.how), ("evidence", self.evidence), ("values of the nonlinearity looked at", self.points)]
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
    """A point, or a pair of points, at which a nonlinearity breaks what was asserted."""

    kind: str = declared("``sector``, ``slope`` or ``odd``")
    name: str = declared("What the nonlinearity is called")
    claim: str = declared("What was asserted")
    denial: str = declared("That it is not so")
    quantity: str = declared("What was measured, ``phi(sigma)/sigma``")
    sigma: tuple[float, ...] = declared("The point or the pair")
    phi: tuple[float, ...] = declared("The values there")
    found: float = declared("The quantity there")
    lower: float | Fraction = declared("The least it was allowed to be")
    upper: float | Fraction = declared("The largest it was allowed to be")
    tolerance: float = declared("By how much it was allowed to miss")
    slope: float = declared("Slope of the nonlinearity at ``sigma``, a difference quotient; NaN if it has none")
    on: tuple[float, float] = declared("The interval on which it was asserted")
    how: str = declared("How the violation was found, and what else is known")
    subject: Subject = declared("The nonlinearity, for plots", hidden=True)

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

    plot = drawn(
        "The nonlinearity, the lines that bound it and the point; see :func:`lure.analysis.plots.plot_violation`."
    )

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
        """Draw the nonlinearity and the point into a file.

        Parameters
        ----------
        path : Path
            A name that ends in ``.png`` or ``.svg``; folders are made, and a file of this name is replaced.
        """
        picture = drawing(self, task="file")(partial(drawing(self), self), name=self.claim, suffixes=[path.suffix])
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(picture.file(path.suffix))

    def ascii_plot(self) -> str:
        """The plot for a terminal: the graph ``*``, the bounds ``.`` (for oddness ``o``, its mirror), the point ``X``.

        Returns
        -------
        str
            Lines of at most 72 characters, ASCII only, without a line end at the end.
        """
        low, high = self.window
        x = np.linspace(low, high, 4 * _COLUMNS + 1)
        phi = self.values_where_defined(x)
        lines = [y0 + slope * (x - x0) for x0, y0, slope in self.lines()]
        bottom, top = self.heights(phi)
        sheet = _Sheet((low, high), (bottom, top))
        sheet.axes()
        for line in lines:
            sheet.curve(x, line, ".")
        if self.kind == "odd":
            sheet.curve(x, -self.values_where_defined(-x), "o")
        sheet.curve(x, phi, "*")
        for sigma, value in zip(self.sigma, self.phi, strict=True):
            sheet.put(sigma, value, "X")
        return sheet.text(self._legend())

    def values_where_defined(self, x: Reals) -> Reals:
        """Values of the nonlinearity, nan where it has none.

        Parameters
        ----------
        x : NDArray[np.float64]
            Points.
        """
        values = np.full(x.size, np.nan)
        for i, sigma in enumerate(x):
            try:
                values[i] = self.subject.at(float(sigma))
            except NotANumber:
                continue
        return values

    def heights(self, phi: Reals) -> tuple[float, float]:
        """The range of values worth drawing: that of the graph and of the broken bound, cut where it dwarfs the point.

        Parameters
        ----------
        phi : NDArray[np.float64]
            Values of the nonlinearity over the window, nan where it has none.
        """
        marked = list(self.phi)
        bound = float(self.bound)
        if self.kind == "sector":
            marked += [bound * self.sigma[0], 0.0]
        elif self.kind == "slope":
            marked.append(self.phi[0] + bound * (self.sigma[1] - self.sigma[0]))
        else:
            marked.append(-self.phi[0])
        marked = [value for value in marked if math.isfinite(value)]
        size = 3.0 * max(max(marked) - min(marked), 0.5 * max(map(abs, marked)))
        near = phi[np.isfinite(phi)]
        low, high = min([*near, *marked]), max([*near, *marked])
        low, high = max(low, min(marked) - size), min(high, max(marked) + size)
        room = 0.04 * (high - low) or 0.5 * abs(high) or 1.0
        return low - room, high + room

    def _legend(self) -> str:
        mark = "X fails"
        if self.kind == "odd":
            return f"* phi(sigma)   o -phi(-sigma)   {mark}"
        what = "slope bounds, from the left X" if self.kind == "slope" else "sector"
        return f"* phi(sigma)   . {what}   {mark}"

    def message(self) -> str:
        """The message of the failure.

        Returns
        -------
        str
            A sentence that stands alone in pytest's summary, a table, and the plot.
        """
        return "\n".join(
            [
                textwrap.fill(self._sentence(), _WIDTH),
                "",
                *self._table(),
                "",
                self.ascii_plot(),
                "",
                *self._how(),
            ]
        )

    def _sentence(self) -> str:
        places = [exact_text(sigma, 12) for sigma in self.sigma]
        if self.kind == "odd":
            found = f"phi({places[0]}) + phi({exact_text(-self.sigma[0], 12)}) = {self.found:.6g}"
        elif self.kind == "slope":
            found = f"slope {self.measured()} from sigma = {places[0]} to {places[1]}"
        elif self.sigma == (0.0,):
            found = f"phi(0) = {exact_text(self.phi[0], 12)}"
        else:
            found = f"phi(sigma)/sigma = {self.measured()} at sigma = {places[0]}"
        return f"{self.denial}: {found}"

    def _table(self) -> list[str]:
        rows = [("sigma", ", ".join(exact_text(sigma, 12) for sigma in self.sigma))]
        rows.append(("phi(sigma)", ", ".join(f"{value:.8g}" for value in self.phi)))
        if math.isfinite(self.found) and self.sigma != (0.0,):
            rows.append((self.quantity, self.measured()))
        slack = f", tolerance {self.tolerance:g}" if self.tolerance else ""
        if self.kind != "odd":
            rows.append(("allowed", f"[{exact_text(self.lower, 12)}, {exact_text(self.upper, 12)}]{slack}"))
        if math.isfinite(self.excess):
            rows.append(("excess", f"{self.excess:.6g}"))
        if math.isfinite(self.slope):
            rows.append(("slope there", f"{self.slope:.6g}"))
        width = max(len(name) for name, _ in rows)
        return [f"  {name:<{width}}  {value}" for name, value in rows]

    def _how(self) -> list[str]:
        return textwrap.wrap(self.how, _WIDTH)

    def measured(self) -> str:
        """What was found, with digits enough to tell it from the bound."""
        for digits in (6, 9, 12):
            text = f"{self.found:.{digits}g}"
            if self.excess > 10.0 ** (1 - digits) * abs(self.found):
                return text
        return repr(self.found)


class NonlinearityViolation(AssertionError):
    """An assertion about a nonlinearity failed; ``violation`` says where, None where it has no value at all."""

    __module__ = "lure.analysis.testing"  # where it is found by people, as it is named in front of each message

    def __init__(self, message: str, violation: Violation | None = None) -> None:
        super().__init__(message)
        self.violation = violation


# A nonlinearity, its bounds and a point, drawn with characters for a terminal of 80 columns.

_WIDTH = 76
_COLUMNS, _ROWS, _LABEL = 60, 17, 9


class _Sheet:
    """Characters in rows, addressed by coordinates; rows from the top."""

    def __init__(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        self.across, self.up = across, up
        self.rows = [[" "] * _COLUMNS for _ in range(_ROWS)]

    def place(self, x: float, y: float) -> tuple[int, int] | None:
        """Row and column of a point, None outside."""
        (left, right), (bottom, top) = self.across, self.up
        if not (left <= x <= right and bottom <= y <= top):
            return None
        return round((top - y) / (top - bottom) * (_ROWS - 1)), round((x - left) / (right - left) * (_COLUMNS - 1))

    def put(self, x: float, y: float, sign: str) -> None:
        """One character at a point, nothing outside."""
        where = self.place(x, y)
        if where is not None:
            self.rows[where[0]][where[1]] = sign

    def curve(self, x: Reals, y: Reals, sign: str) -> None:
        """A character at each of the points."""
        for a, b in zip(x, y, strict=True):
            self.put(float(a), float(b), sign)

    def axes(self) -> None:
        """The lines ``sigma = 0`` and ``phi = 0``, where they are within sight."""
        for x in np.linspace(*self.across, _COLUMNS):
            self.put(float(x), 0.0, "-")
        for y in np.linspace(*self.up, _ROWS):
            self.put(0.0, float(y), "|")

    def text(self, legend: str) -> str:
        """The sheet with the numbers at its edges, and the legend below."""
        (left, right), (bottom, top) = self.across, self.up
        labels: Sequence[str] = [_short(top), *[""] * (_ROWS - 2), _short(bottom)]
        lines = [f"{label:>{_LABEL}} |{''.join(row)}".rstrip() for label, row in zip(labels, self.rows, strict=True)]
        ends = f"{_short(left)}{_short(right):>{_COLUMNS - len(_short(left))}}"
        margin = " " * (_LABEL + 2)
        return "\n".join([*lines, f"{margin}{ends}", f"{margin}{legend}"])


def _short(value: float) -> str:
    return f"{value:.3g}"

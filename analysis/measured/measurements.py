"""Pairs of displacement and load in SI units, with the lines they came from and the branches they form."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.drawing import drawing
from lure.errors import InputError
from lure.record import Column, Page, Record, quantity

if TYPE_CHECKING:
    from lure.analysis.drawing import Axes

Array = NDArray[np.float64]
_LOAD_UNITS = ("N", "Pa", "N m", "V", "A", "1")
_DISPLACEMENT_UNITS = ("m", "rad", "m/s", "V", "A", "1")
Direction = Literal["loading", "unloading"]
SHOWN = 8
_TURN = 0.1
_ROWS = 5  # a branch has at least so many on average; rows in no order have about two
_SMALLEST = 1e-100  # what is squared and divided below stays a double


class Branch(Record, kw_only=False):
    """Rows ``start`` to ``stop`` (excluded) on which the displacement rises (loading) or falls (unloading)."""

    direction: Direction = quantity("Which")
    start: int = quantity("First row")
    stop: int = quantity("The row after the last")


class Measurements(Record):
    """Displacement and load, in the order in which they were recorded."""

    displacement: Array = quantity(
        "(n,) ``sigma`` before the origin is taken off, mostly [m], positive towards the obstacle", key=""
    )
    load: Array = quantity(
        "(n,) ``phi``: force [N] or stress [Pa], positive in compression, or what else comes out", key=""
    )
    unit: str = quantity("Unit of the load")
    lines: NDArray[np.int64] = quantity("(n,) lines of the file, counted from 1; 1 to n where there is no file", key="")
    source: str = quantity("Name of the file, or ``arrays``", default="arrays")
    columns: tuple[str, str] = quantity("Headings of the two columns", default=("displacement", "load"))
    notes: tuple[str, ...] = quantity("What was assumed or left out in reading", default=())
    displacement_unit: str = quantity("Unit of the displacement", default="m")
    numbers: tuple[int, ...] = quantity(
        "Numbers of the two columns, counted from 1; empty where there is no file", key="column_numbers", default=()
    )
    reasons: tuple[str, ...] = quantity("Why these columns; empty likewise", default=())

    def __post_init__(self) -> None:
        for values, unit in ((self.displacement, self.displacement_unit), (self.load, self.unit)):
            largest = float(np.abs(values).max(initial=0.0))
            if largest and not _SMALLEST < largest < 1 / _SMALLEST:
                raise InputError(
                    f"Measurements: the largest number in {unit} is {largest:.3g}; give other units, in which it lies "
                    f"between {_SMALLEST:g} and {1 / _SMALLEST:g}"
                )

    @classmethod
    def from_arrays(
        cls,
        displacement: ArrayLike,
        load: ArrayLike,
        *,
        unit: str = "N",
        displacement_unit: str = "m",
    ) -> Measurements:
        """Measurements that are in memory already.

        Parameters
        ----------
        displacement, load : array_like
            (n,) [m] and [N] or [Pa], or in the units given, finite.
        unit : {"N", "Pa", "N m", "V", "A", "1"}
            Unit of the load.
        displacement_unit : {"m", "rad", "m/s", "V", "A", "1"}
            Unit of the displacement.

        Raises
        ------
        InputError
            Shapes differ, a number is not finite, all are below 1e-100 or one is above 1e100, or a unit is another one.
        """
        for name, value, known in (
            ("unit", unit, _LOAD_UNITS),
            ("displacement_unit", displacement_unit, _DISPLACEMENT_UNITS),
        ):
            if value not in known:
                raise InputError(f"Measurements: {name} is {value!r:.20}; give one of {', '.join(known)}")
        u, p = (np.array(values, dtype=np.float64) for values in (displacement, load))
        if u.ndim != 1 or u.shape != p.shape:
            raise InputError(f"Measurements needs two columns of one length; got shapes {u.shape} and {p.shape}")
        bad = np.flatnonzero(~(np.isfinite(u) & np.isfinite(p)))
        if bad.size:
            raise InputError(f"Measurements: row {bad[0]} is ({u[bad[0]]}, {p[bad[0]]}); give finite numbers")
        lines = np.arange(1, u.size + 1)
        return cls(displacement=u, load=p, unit=unit, displacement_unit=displacement_unit, lines=lines)

    @property
    def stiffness_unit(self) -> str:
        """Unit of load over displacement."""
        return self.unit if self.displacement_unit == "1" else f"{self.unit}/{self.displacement_unit}"

    @property
    def area_unit(self) -> str:
        """Unit of the area of a loop, load times displacement."""
        product = f"{self.unit} {self.displacement_unit}"
        return {"N m": "J", "Pa m": "J/m^2", "N m rad": "J", "N m/s": "W"}.get(product, product)

    @property
    def named(self) -> str:
        """Which columns were taken, why, and how to choose others; empty where there is no file."""
        if not self.numbers:
            return ""
        u, p = (
            f"column {number} {heading!r} ({why})"
            for number, heading, why in zip(self.numbers, self.columns, self.reasons, strict=True)
        )
        return f"sigma is {u}, phi is {p}; --displacement and --force choose others."

    @cached_property
    def branches(self) -> tuple[Branch, ...]:
        """Loading and unloading, cut where the displacement turns back by more than a tenth of its range.

        Rows in no particular order form no branches, and neither does a single sweep: then there is nothing to compare.
        """
        ends = _turning_points(self.displacement)
        if not 2 <= len(ends) - 1 <= self.displacement.size // _ROWS:
            return ()
        rising = self.displacement[ends[1:]] > self.displacement[ends[:-1]]
        return tuple(
            Branch("loading" if up else "unloading", a if a == 0 else a + 1, b + 1)
            for a, b, up in zip(ends[:-1], ends[1:], rising, strict=True)
        )

    def rows(self, direction: Direction) -> NDArray[np.intp]:
        """Indices of the rows on the branches of one direction.

        Parameters
        ----------
        direction : {"loading", "unloading"}
            Which.
        """
        found = [np.arange(b.start, b.stop) for b in self.branches if b.direction == direction]
        return np.concatenate(found) if found else np.zeros(0, dtype=np.intp)

    def taken(self, rows: NDArray[np.intp]) -> Measurements:
        """Some of the rows, in the order given.

        Parameters
        ----------
        rows : ndarray of int
            Their indices.
        """
        return replace(self, displacement=self.displacement[rows], load=self.load[rows], lines=self.lines[rows])

    def to_dict(self) -> dict[str, Any]:
        """What was read, without the rows."""
        return super().to_dict() | {
            "rows": len(self),
            "displacement": [float(self.displacement.min()), float(self.displacement.max())],
            "load": [float(self.load.min()), float(self.load.max())],
            "branches": [branch.to_dict() for branch in self.branches],
        }

    def _columns(self) -> dict[str, Column]:
        """The rows with the lines of the file and the branches."""
        of, branch = ("row",), np.full(len(self), "", dtype=object)
        for part in self.branches:
            branch[part.start : part.stop] = part.direction
        towards = "displacement u, positive towards the obstacle"
        return {
            "displacement": Column(of, self.displacement, self.displacement_unit, towards),
            "load": Column(of, self.load, self.unit, "load, positive in compression"),
            "line": Column(of, self.lines, "1", "line of the file, from 1"),
            "branch": Column(of, branch, "1", "loading or unloading; empty where the rows form no branches"),
            "row": Column(of, np.arange(len(self)), "1", "row, from 0"),
        }

    def _attributes(self) -> dict[str, object]:
        origin = {"source": self.source, "columns": ", ".join(self.columns), "notes": "; ".join(self.notes)}
        return {"title": "Measured law", "evidence": "observed", **origin}

    def _page(self) -> Page:
        u, p = self.displacement, self.load
        rows = [
            ("rows", len(self)),
            ("columns", ", ".join(self.columns)),
            ("displacement", f"{u.min():.4g} to {u.max():.4g} {self.displacement_unit}"),
            ("load", f"{p.min():.4g} {self.unit} to {p.max():.4g} {self.unit}"),
            ("branches", ", ".join(b.direction for b in self.branches[:SHOWN]) or "one sweep, or in no order"),
        ]
        return Page(f"measurements from {self.source}", rows, verdict="OBSERVED", notes=self.notes)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Load against displacement; see :func:`lure.analysis.plots.plot_measurements`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)(self, ax=ax)
        return made

    def __len__(self) -> int:
        return self.displacement.size

    def __str__(self) -> str:
        u, p = self.displacement, self.load
        parts = [
            f"{u.size} rows of {self.source}: displacement {u.min():.4g} .. {u.max():.4g} {self.displacement_unit}"
        ]
        parts.append(f"load {p.min():.4g} .. {p.max():.4g} {self.unit}")
        parts.append(f"{len(self.branches)} branches" if self.branches else "one sweep, or in no order")
        return "\n".join([", ".join(parts), *filter(None, [self.named]), *self.notes])


def _turning_points(u: Array) -> list[int]:
    """First row, rows of the turns, last row: a turn is where ``u`` comes back by more than a tenth of its range."""
    turn = _TURN * float(np.ptp(u))
    if u.size < 2 or turn == 0:
        return [0]
    ends, low, high, way = [0], 0, 0, 0
    steps = np.diff(u)
    extremes = np.flatnonzero(steps[1:] * steps[:-1] <= 0) + 1
    for i in [0, *extremes.tolist(), u.size - 1]:
        value = u[i]
        high, low = (i if value > u[high] else high), (i if value < u[low] else low)
        if way >= 0 and value < u[high] - turn:
            if way == 1 or u[high] - u[0] > turn:
                ends.append(high)
            way, low, high = -1, i, i
        elif way <= 0 and value > u[low] + turn:
            if way == -1 or u[0] - u[low] > turn:
                ends.append(low)
            way, low, high = 1, i, i
    return [*ends, u.size - 1] if ends[-1] != u.size - 1 else ends

"""Pairs of displacement and load in SI units, with the lines they came from and the branches they form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.record import by_value

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]
_LOAD_UNITS = ("N", "Pa", "N m", "V", "A", "1")
_DISPLACEMENT_UNITS = ("m", "rad", "m/s", "V", "A", "1")
Direction = Literal["loading", "unloading"]
_TURN = 0.1
_ROWS = 5  # a branch has at least so many on average; rows in no order have about two
_SMALLEST = 1e-100  # what is squared and divided below stays a double


@dataclass(frozen=True, slots=True)
class Branch:
    """Rows ``start`` to ``stop`` (excluded) on which the displacement rises (loading) or falls (unloading)."""

    direction: Direction
    start: int
    stop: int


@by_value
@dataclass(frozen=True, kw_only=True, eq=False)  # without slots, for the cached property
class Measurements:
    """Displacement and load, in the order in which they were recorded.

    Attributes
    ----------
    displacement : ndarray
        (n,) ``sigma`` before the origin is taken off, mostly [m], positive towards the obstacle.
    load : ndarray
        (n,) ``phi``: force [N] or stress [Pa], positive in compression, or what else comes out.
    unit : {"N", "Pa", "N m", "V", "A", "1"}
        Unit of the load.
    lines : ndarray of int
        (n,) lines of the file, counted from 1; 1 to n where there is no file.
    source : str
        Name of the file, or ``arrays``.
    columns : tuple of str
        Headings of the two columns.
    notes : tuple of str
        What was assumed or left out in reading.
    displacement_unit : {"m", "rad", "m/s", "V", "A", "1"}
        Unit of the displacement.
    numbers : tuple of int
        Numbers of the two columns, counted from 1; empty where there is no file.
    reasons : tuple of str
        Why these columns; empty likewise.
    """

    displacement: Array
    load: Array
    unit: str
    lines: NDArray[np.int64]
    source: str = "arrays"
    columns: tuple[str, str] = ("displacement", "load")
    notes: tuple[str, ...] = ()
    displacement_unit: str = "m"
    numbers: tuple[int, ...] = ()
    reasons: tuple[str, ...] = ()

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
        return Measurements(
            displacement=self.displacement[rows],
            load=self.load[rows],
            unit=self.unit,
            lines=self.lines[rows],
            source=self.source,
            columns=self.columns,
            notes=self.notes,
            displacement_unit=self.displacement_unit,
            numbers=self.numbers,
            reasons=self.reasons,
        )

    def to_xarray(self) -> xarray.Dataset:
        """The rows as an ``xarray.Dataset`` along ``row``, with units, lines of the file and branches.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.measured.export import measurements_dataset

        return measurements_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Load against displacement; see :func:`lure.analysis.plots.plot_measurements`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.measured import plot_measurements

        return plot_measurements(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.measured.export import measurements_html

        return measurements_html(self)

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

    def to_dict(self) -> dict[str, Any]:
        """What was read, without the rows."""
        return {
            "source": self.source,
            "rows": len(self),
            "columns": list(self.columns),
            "unit": self.unit,
            "displacement_unit": self.displacement_unit,
            "column_numbers": list(self.numbers),
            "reasons": list(self.reasons),
            "displacement": [float(self.displacement.min()), float(self.displacement.max())],
            "load": [float(self.load.min()), float(self.load.max())],
            "branches": [{"direction": b.direction, "start": b.start, "stop": b.stop} for b in self.branches],
            "notes": list(self.notes),
        }


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

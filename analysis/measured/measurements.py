"""Pairs of displacement and load in SI units, with the lines they came from and the branches they form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError

if TYPE_CHECKING:
    import xarray

    from analysis.plots.style import Axes

Array = NDArray[np.float64]
LoadUnit = Literal["N", "Pa"]
Direction = Literal["loading", "unloading"]
_TURN = 0.1
_MANY = 50


@dataclass(frozen=True, slots=True)
class Branch:
    """Rows ``start`` to ``stop`` (excluded) on which the displacement rises (loading) or falls (unloading)."""

    direction: Direction
    start: int
    stop: int


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Measurements:
    """Displacement and load, in the order in which they were recorded.

    Attributes
    ----------
    displacement : ndarray
        (n,) [m], positive towards the obstacle.
    load : ndarray
        (n,) force [N] or stress [Pa], positive in compression.
    unit : {"N", "Pa"}
        Unit of the load.
    lines : ndarray of int
        (n,) lines of the file, counted from 1; 1 to n where there is no file.
    source : str
        Name of the file, or ``arrays``.
    columns : tuple of str
        Headings of the two columns.
    notes : tuple of str
        What was assumed or left out in reading.
    """

    displacement: Array
    load: Array
    unit: LoadUnit
    lines: NDArray[np.int64]
    source: str = "arrays"
    columns: tuple[str, str] = ("displacement", "load")
    notes: tuple[str, ...] = ()

    @classmethod
    def from_arrays(cls, displacement: ArrayLike, load: ArrayLike, *, unit: LoadUnit = "N") -> Measurements:
        """Measurements that are in memory already.

        Parameters
        ----------
        displacement, load : array_like
            (n,) [m] and [N] or [Pa], finite.
        unit : {"N", "Pa"}
            Unit of the load.

        Raises
        ------
        InputError
            Shapes differ, a number is not finite, or the unit is another one.
        """
        if unit not in ("N", "Pa"):
            raise InputError(f"Measurements: unit is {unit!r:.20}; give 'N' or 'Pa'")
        u, p = (np.array(values, dtype=np.float64) for values in (displacement, load))
        if u.ndim != 1 or u.shape != p.shape:
            raise InputError(f"Measurements needs two columns of one length; got shapes {u.shape} and {p.shape}")
        bad = np.flatnonzero(~(np.isfinite(u) & np.isfinite(p)))
        if bad.size:
            raise InputError(f"Measurements: row {bad[0]} is ({u[bad[0]]}, {p[bad[0]]}); give finite numbers")
        return cls(displacement=u, load=p, unit=unit, lines=np.arange(1, u.size + 1))

    @property
    def stiffness_unit(self) -> str:
        """Unit of load over displacement."""
        return f"{self.unit}/m"

    @property
    def branches(self) -> tuple[Branch, ...]:
        """Loading and unloading, cut where the displacement turns back by more than a tenth of its range.

        Rows in no particular order form no branches, and neither does a single sweep: then there is nothing to compare.
        """
        ends = _turning_points(self.displacement)
        if not 2 <= len(ends) - 1 <= min(_MANY, self.displacement.size // 8):
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
        )

    def to_xarray(self) -> xarray.Dataset:
        """The rows as an ``xarray.Dataset`` along ``row``, with units, lines of the file and branches.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from analysis.measured.export import measurements_dataset

        return measurements_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Load against displacement; see :func:`analysis.plots.plot_measurements`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from analysis.plots.measured import plot_measurements

        return plot_measurements(self, ax=ax)

    def _repr_html_(self) -> str:
        from analysis.measured.export import measurements_html

        return measurements_html(self)

    def __len__(self) -> int:
        return self.displacement.size

    def __str__(self) -> str:
        u, p = self.displacement, self.load
        parts = [f"{u.size} rows of {self.source}: displacement {u.min():.4g} .. {u.max():.4g} m"]
        parts.append(f"load {p.min():.4g} .. {p.max():.4g} {self.unit}")
        parts.append(f"{len(self.branches)} branches" if self.branches else "one sweep, or in no order")
        return "\n".join([", ".join(parts), *self.notes])

    def to_dict(self) -> dict[str, Any]:
        """What was read, without the rows."""
        return {
            "source": self.source,
            "rows": len(self),
            "columns": list(self.columns),
            "unit": self.unit,
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
    for i, value in enumerate(u.tolist()):
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

"""Pairs of displacement and load in SI units, and the files, as they are published, that they are read from."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.drawing import drawn
from lure.analysis.measured.table import (
    EXAMPLES,
    SI,
    Kind,
    Table,
    Unit,
    known_unit,
    split_heading,
    table_of,
    unit_named,
    unit_within,
)
from lure.errors import InputError
from lure.files.values import shown
from lure.record import Column, Page, Record, quantity

# Pairs of displacement and load in SI units, with the lines they came from and the branches they form.

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
            Shapes differ, there are no rows, a number is not finite, all are below 1e-100 or one is above 1e100, or a
            unit is another one.
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
        if not u.size:
            raise InputError("Measurements has no rows; give a displacement and a load at least")
        bad = np.flatnonzero(~(np.isfinite(u) & np.isfinite(p)))
        if bad.size:
            raise InputError(f"Measurements: row {bad[0]} is ({u[bad[0]]}, {p[bad[0]]}); give finite numbers")
        lines = np.arange(1, u.size + 1)
        return cls(displacement=u, load=p, unit=unit, displacement_unit=displacement_unit, lines=lines)

    @property
    def stiffness_unit(self) -> str:
        """Unit of load over displacement."""
        below = f"({self.displacement_unit})" if "/" in self.displacement_unit else self.displacement_unit
        return self.unit if below == "1" else f"{self.unit}/{below}"

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
        return {"title": "Measured nonlinearity", "evidence": "observed", **origin}

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

    plot = drawn("Load against displacement; see :func:`lure.analysis.plots.plot_measurements`.")

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


_LARGEST = 200 * 2**20
_SHOWN, _OFFERED = 8, 12
_WORDS: dict[str, tuple[str, ...]] = {
    "displacement": (
        *("displacement", "indentation", "penetration", "depth", "deflection", "extension", "separation", "stroke"),
        *("travel", "weg", "tiefe", "verschiebung", "d\u00e9placement", "deplacement", "course", "spostamento"),
        *(
            "desplazamiento",
            "deformation",
            "position",
            "angle",
            "winkel",
            "velocity",
            "speed",
            "input",
            "sigma",
            "error",
        ),
    ),
    "force": (
        *("force", "load", "stress", "pressure", "kraft", "druck", "spannung", "effort", "contrainte", "forza"),
        *("fuerza", "carico", "torque", "moment", "output"),
    ),
}
_OTHER: tuple[Kind, ...] = ("voltage", "current", "number")
_KINDS: dict[str, tuple[tuple[Kind, ...], ...]] = {  # the first that a column has is taken
    "displacement": (("length",), ("angle",), ("velocity",), _OTHER),
    "force": (("force", "stress"), ("torque",), _OTHER),
}
_WAYS: tuple[frozenset[str], frozenset[str]] = (
    frozenset(("extend", "approach", "loading", "press", "trace", "ex", "ext", "forward")),
    frozenset(("retract", "withdraw", "unloading", "release", "retrace", "rt", "ret", "backward")),
)


def read_measurements(
    source: str | Path,
    *,
    displacement: str | None = None,
    force: str | None = None,
    units: tuple[str, str] | None = None,
    area: float | None = None,
) -> Measurements:
    r"""Displacement and force, or whatever goes in and comes out of an element, from a text file with columns.

    Read are CSV, TSV and columns between blanks; comments after ``#`` or ``%``; headings with units in brackets, after
    a slash or in a line of their own; decimal commas; a byte order mark; blank lines.  Rows with ``nan`` or nothing in
    a chosen column, repeated headings, numbers above the heading and remarks at the end are left out and named.
    Columns for either direction of travel, such as Extend and Retract, are put one after the other.

    Parameters
    ----------
    source : str or Path
        The file, or the text itself if it has more than one line.
    displacement, force : str, optional
        Names of the columns, as in the heading with or without unit, or their numbers counted from 1.  By default the
        only column with such a unit, else with such a name, else the first and the second of two.
    units : tuple of str, optional
        Units of the two columns, instead of those in the heading, such as ``mm``, ``inch``, ``deg``, ``V`` and ``N``,
        ``lbf``, ``gf``, ``N m``, ``MPa``.  Without either, m and N are assumed and noted.
    area : float, optional
        Area [m^2] over which the force acts: the load is then the mean stress [Pa], as the contact law of a rod wants.

    Returns
    -------
    Measurements
        In SI units: metres and newtons, pascals with an area or a column of stress, volts for an amplifier.

    Raises
    ------
    InputError
        The file cannot be read, a column cannot be told or has a unit of another kind, a cell holds no number, or fewer
        than three rows are left.

    Examples
    --------
    >>> found = read_measurements("depth [um], force (mN)\n0, 0\n2, 8\n4, 16\n")
    >>> print(found.displacement[1], found.load[1], found.unit)
    2e-06 0.008 N
    """
    if area is not None and not (isinstance(area, int | float) and math.isfinite(area) and area > 0):
        raise InputError(f"area is {area!r:.40}; give a positive number of square metres")
    name, text = _text(source)
    table = table_of(text)
    notes: list[str] = []
    pairs = _columns(table, displacement, force)
    chosen, reasons = pairs[0]
    given = units or (None, None)
    found = [
        _unit(table, column, role, unit, notes)
        for (role, column), unit in zip(zip(_KINDS, chosen, strict=True), given, strict=True)
    ]
    numbers, lines = _joined(table, [columns for columns, _ in pairs], notes)
    if seen := table.like_thousands(chosen):
        notes.append(f"Commas were read as decimal points: {seen} as {seen.replace(',', '.')}.")
    u, p = (unit.to_si(numbers[:, i]) for i, unit in enumerate(found))
    load_unit = SI[found[1].kind]
    if area is not None:
        if load_unit not in ("N", "Pa"):
            raise InputError(f"an area goes with a force, but the load is in {load_unit}")
        if load_unit == "N":
            p, load_unit = p / area, "Pa"
            notes.append(f"The force was divided by the area {area:g} m^2.")
    if not (np.isfinite(u).all() and np.isfinite(p).all()):
        raise InputError("a number in SI units is beyond the largest double; give smaller numbers or other units")
    for array in (u, p):
        array.flags.writeable = False
    return Measurements(
        displacement=u,
        load=p,
        unit=load_unit,
        displacement_unit=SI[found[0].kind],
        lines=lines,
        source=name,
        columns=(_shown(table, chosen[0]), _shown(table, chosen[1])),
        numbers=(chosen[0] + 1, chosen[1] + 1),
        reasons=reasons,
        notes=tuple(notes),
    )


def _text(source: str | Path) -> tuple[str, str]:
    """Name and contents of the source."""
    if isinstance(source, str) and re.search(r"[\r\n]", source):
        return "the text", source
    path = Path(source)
    try:
        if path.stat().st_size > _LARGEST:
            raise InputError(f"{str(path)!r} is larger than 200 MiB; give fewer rows")
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"{str(path)!r} cannot be read ({reason}); give a text file with columns") from None
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return path.name, data.decode("utf-16", errors="replace")
    if b"\0" in data[:4096]:
        raise InputError(f"{str(path)!r} is not a text file; export it as CSV with columns of numbers")
    try:
        return path.name, data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return path.name, data.decode("latin-1")  # where a micro sign is one byte, as old instruments write it


def _shown(table: Table, column: int) -> str:
    return table.headings[column] or f"column {column + 1}"


def _columns(
    table: Table, displacement: str | None, force: str | None
) -> list[tuple[tuple[int, int], tuple[str, str]]]:
    """Indices of the two columns and why; those of both directions of travel where the file has columns for each."""
    everything = set(range(len(table.headings)))
    if displacement is None and force is None:
        ways = [_way(heading) for heading in table.headings]
        if all(ways.count(way) in (1, 2) for way in (0, 1)):
            taken = [{i for i in everything if ways[i] in (way, None)} for way in (0, 1)]
            return [_two(table, (None, None), some) for some in taken]
    return [_two(table, (displacement, force), everything)]


def _way(heading: str) -> int | None:
    """0 for a column of the way in, 1 for one of the way back, None for others."""
    words = set(re.findall(r"[^\W\d_]+", heading.casefold()))
    found = [i for i, way in enumerate(_WAYS) if words & way]
    return found[0] if len(found) == 1 else None


def _two(table: Table, names: tuple[str | None, str | None], some: set[int]) -> tuple[tuple[int, int], tuple[str, str]]:
    """The columns of displacement and force among some, and why."""
    found: dict[str, tuple[int, str]] = {}
    for role, name in zip(_KINDS, names, strict=True):
        if name is not None:
            found[role] = _named(table, role, name), "as asked for"
    for role in _KINDS:
        if role not in found:
            found[role] = _guessed(table, role, some - {column for column, _ in found.values()}, taken=bool(found))
    (u, why), (p, reason) = found["displacement"], found["force"]
    if u == p:
        raise InputError(f"displacement and force are both {_shown(table, p)!r:.60}; give two columns")
    return (u, p), (why, reason)


def _named(table: Table, role: str, name: str) -> int:
    wanted = name.strip().casefold()
    texts = [(heading, split_heading(heading)[0]) for heading in table.headings]
    hits = [i for i, both in enumerate(texts) if wanted and wanted in (both[0].casefold(), both[1].casefold())]
    if len(hits) == 1:
        return hits[0]
    if not hits and wanted.isdigit() and 1 <= int(wanted) <= len(texts):
        return int(wanted) - 1
    what = "more than one column is named so" if hits else "there is no such column"
    raise InputError(f"{role} is {name!r:.60}, but {what}; {_offer(table)}")


def _offer(table: Table) -> str:
    if not any(table.headings):
        return f"the file names no columns, give a number from 1 to {len(table.headings)}"
    names = [f"{i}: {shown(name)[1:-1]}" for i, name in enumerate(table.headings[:_OFFERED], 1)]
    return "choose by name or number from " + ", ".join(names) + (", ..." if len(table.headings) > _OFFERED else "")


def _guessed(table: Table, role: str, among: set[int], *, taken: bool) -> tuple[int, str]:
    """The only column with a unit of the role, else with a name of it, else the place among two; and why."""
    split = [split_heading(heading) for heading in table.headings]
    free = sorted(among)
    units = [known_unit(unit) for _, unit in split]
    by_unit: list[int] = []
    for kinds in _KINDS[role]:
        by_unit = [i for i in free if (unit := units[i]) is not None and unit.kind in kinds]
        if by_unit:
            break
    if len(by_unit) == 1:
        kinds_taken = {unit.kind for i, unit in enumerate(units) if i not in among and unit is not None}
        alike = not kinds_taken.isdisjoint(kinds)
        return by_unit[0], "the other one with such a unit" if alike else "the only one with such a unit"
    named = [i for i in by_unit or free if any(word in split[i][0].casefold() for word in _WORDS[role])]
    if role == "displacement":
        named = named or [i for i in by_unit or free if split[i][0].strip().casefold() == "x"]
    if len(named) == 1:
        return named[0], "by its name"
    other = "force" if role == "displacement" else "displacement"
    left = [i for i in free if not any(word in split[i][0].casefold() for word in _WORDS[other])]
    if taken:
        left = left or free
    if len(split) == 2 and left and not named:
        return left[0], "by its place"
    raise InputError(f"the column of the {role} cannot be told from the headings; {_offer(table)}")


def _unit(table: Table, column: int, role: str, given: str | None, notes: list[str]) -> Unit:
    """The unit of a column: as given, as in its heading, or SI with a note."""
    where = f"column {_shown(table, column)!r:.60}"
    text = given if given is not None else split_heading(table.headings[column])[1]
    if not text:
        if like := unit_within(table.headings[column]):
            raise InputError(
                f"{where} speaks of {like!r:.40}, but its unit cannot be told; name the units of both columns with "
                f"--units, or units= in Python, for example {EXAMPLES}"
            )
        kind = _KINDS[role][0][0]
        unit = Unit(SI[kind], kind, Fraction(1))
        notes.append(f"The {where} has no unit; {unit.text} is assumed.")
        return unit
    unit = unit_named(text, where)
    if not any(unit.kind in kinds for kinds in _KINDS[role]):
        raise InputError(f"{where} is in {unit.text}, a unit of {unit.kind}; choose another column for the {role}")
    return unit


def _joined(
    table: Table, pairs: list[tuple[int, int]], notes: list[str]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The rows with two numbers and their lines; the way back follows the way in, from where that ended."""
    parts = [_numbers(table, columns, notes) for columns in pairs]
    if len(parts) == 2:
        (there, _), (back, lines) = parts
        end, first, last = there[-1, 0], back[0, 0], back[-1, 0]
        if abs(first - end) > abs(last - end):
            parts[1] = back[::-1], lines[::-1]
        shown = [" and ".join(repr(_shown(table, column)) for column in columns) for columns in pairs]
        notes.append(f"Columns {shown[0]} are the way in, {shown[1]} the way back, and were put one after the other.")
    if table.repeated:
        notes.append(f"Left out, since they repeat the heading: {_lines(table.repeated)}.")
    if table.numbers_above:
        notes.append(f"Not read, since they are above the heading: the numbers on {_lines(table.numbers_above)}.")
    numbers, lines = (np.concatenate(part) for part in zip(*parts, strict=True))
    if len(numbers) < 3:
        raise InputError(f"the file has {len(numbers)} rows with two numbers; give at least 3")
    return numbers, lines


def _lines(lines: Sequence[int]) -> str:
    shown = ", ".join(map(str, lines[:_SHOWN])) + (", ..." if len(lines) > _SHOWN else "")
    return f"line{'s' if len(lines) > 1 else ''} {shown} ({len(lines)} in all)"


def _numbers(table: Table, columns: tuple[int, int], notes: list[str]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The rows with two numbers, and their lines."""
    rows = len(table.rows) - table.footer(columns)
    if rows < len(table.rows):
        notes.append(f"Left out, as a remark below the rows: {_lines([line for line, _ in table.rows[rows:]])}.")
    whole = [table.column_numbers(column, rows) for column in columns]
    if whole[0] is not None and whole[1] is not None:
        return np.column_stack([whole[0], whole[1]]), np.array([line for line, _ in table.rows[:rows]], dtype=np.int64)
    kept, lines, missing = [], [], []
    for row, (line, _) in enumerate(table.rows[:rows]):
        pair = [table.number(row, column) for column in columns]
        if None in pair:
            missing.append(line)
        else:
            kept.append(pair)
            lines.append(line)
    if missing:
        notes.append(f"Left out, since a number is missing or infinite: {_lines(missing)}.")
    if not kept:
        raise InputError("the file has 0 rows with two numbers; give at least 3")
    return np.array(kept, dtype=np.float64), np.array(lines, dtype=np.int64)

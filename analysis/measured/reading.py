"""Files of displacement and force as they are published, read into SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lure.analysis.measured.measurements import Measurements
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

_LARGEST = 200 * 2**20
_SHOWN = 8
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
        raise InputError(f"read_measurements: area is {area!r:.40}; give a positive number of square metres")
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
            raise InputError(f"read_measurements: an area goes with a force, but the load is in {load_unit}")
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
        raise InputError(f"displacement and force are both {_shown(table, p)!r}; give two columns")
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
    return "choose by name or number from " + ", ".join(f"{i}: {name}" for i, name in enumerate(table.headings, 1))


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
        return by_unit[0], "the only one with such a unit"
    named = [i for i in by_unit or free if any(word in split[i][0].casefold() for word in _WORDS[role])]
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
    where = f"column {_shown(table, column)!r}"
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

"""Files of displacement and force as they are published, read into SI units."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from analysis.measured.measurements import LoadUnit, Measurements
from analysis.measured.table import Table, table_of
from analysis.measured.units import SI, Kind, Unit, known_unit, split_heading, unit_named, unit_within
from lure.errors import InputError

_LARGEST = 200 * 2**20
_SHOWN = 8
_WORDS: dict[str, tuple[str, ...]] = {
    "displacement": (
        *("displacement", "indentation", "penetration", "depth", "deflection", "extension", "separation", "stroke"),
        *("travel", "weg", "tiefe", "verschiebung", "d\u00e9placement", "deplacement", "course", "spostamento"),
        *("desplazamiento", "deformation"),
    ),
    "force": (
        *("force", "load", "stress", "pressure", "kraft", "druck", "spannung", "effort", "contrainte", "forza"),
        *("fuerza", "carico"),
    ),
}
_KINDS: dict[str, tuple[Kind, ...]] = {"displacement": ("length",), "force": ("force", "stress")}


def read_measurements(
    source: str | Path,
    *,
    displacement: str | None = None,
    force: str | None = None,
    units: tuple[str, str] | None = None,
    area: float | None = None,
) -> Measurements:
    r"""Displacement and force, or stress, from a text file with columns.

    Read are CSV, TSV and columns between blanks; comments after ``#`` or ``%``; headings with units in brackets, after
    a slash or in a line of their own; decimal commas; a byte order mark; blank lines.  Rows with ``nan`` or nothing in
    a chosen column are left out and named.

    Parameters
    ----------
    source : str or Path
        The file, or the text itself if it has more than one line.
    displacement, force : str, optional
        Names of the columns, as in the heading with or without unit, or their numbers counted from 1.  By default the
        only column with such a unit, else with such a name, else the first and the second of two.
    units : tuple of str, optional
        Units of the two columns, instead of those in the heading.  Without either, SI is assumed and noted.
    area : float, optional
        Area [m^2] over which the force acts: the load is then the mean stress [Pa], as the contact law of a rod wants.

    Returns
    -------
    Measurements
        In metres and newtons, or in pascals with an area or a column of stress.

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
    chosen = _columns(table, displacement, force)
    notes: list[str] = []
    given = units or (None, None)
    found = [
        _unit(table, column, role, unit, notes)
        for (role, column), unit in zip(zip(_KINDS, chosen, strict=True), given, strict=True)
    ]
    pairs, lines = _numbers(table, chosen, notes)
    if seen := table.like_thousands(chosen):
        notes.append(f"Commas were read as decimal points: {seen} as {seen.replace(',', '.')}.")
    u, p = (pairs[:, i] * 10.0**unit.power if unit.power >= 0 else pairs[:, i] / 10.0**-unit.power
            for i, unit in enumerate(found))  # fmt: skip
    load_unit: LoadUnit = "Pa" if found[1].kind == "stress" else "N"
    if area is not None and load_unit == "N":
        p, load_unit = p / area, "Pa"
        notes.append(f"The force was divided by the area {area:g} m^2.")
    for array in (u, p):
        array.flags.writeable = False
    return Measurements(
        displacement=u,
        load=p,
        unit=load_unit,
        lines=lines,
        source=name,
        columns=(_shown(table, chosen[0]), _shown(table, chosen[1])),
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


def _columns(table: Table, displacement: str | None, force: str | None) -> tuple[int, int]:
    """Indices of the two columns."""
    named = {"displacement": displacement, "force": force}
    found = {role: _named(table, role, name) for role, name in named.items() if name is not None}
    for role in named:
        if role not in found:
            taken = set(found.values())
            found[role] = _guessed(table, role, taken)
    if found["displacement"] == found["force"]:
        raise InputError(f"displacement and force are both {_shown(table, found['force'])!r}; give two columns")
    return found["displacement"], found["force"]


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


def _guessed(table: Table, role: str, taken: set[int]) -> int:
    """The only column with a unit of the role, else with a name of it, else the place among two."""
    split = [split_heading(heading) for heading in table.headings]
    free = [i for i in range(len(split)) if i not in taken]
    units = [known_unit(unit) for _, unit in split]
    by_unit = [i for i in free if (unit := units[i]) is not None and unit.kind in _KINDS[role]]
    if len(by_unit) == 1:
        return by_unit[0]
    named = [i for i in by_unit or free if any(word in split[i][0].casefold() for word in _WORDS[role])]
    if len(named) == 1:
        return named[0]
    other = "force" if role == "displacement" else "displacement"
    left = [i for i in free if not any(word in split[i][0].casefold() for word in _WORDS[other])]
    if taken:
        left = left or free
    if len(split) == 2 and left and not (by_unit or named):
        return left[0]
    raise InputError(f"the column of the {role} cannot be told from the headings; {_offer(table)}")


def _unit(table: Table, column: int, role: str, given: str | None, notes: list[str]) -> Unit:
    """The unit of a column: as given, as in its heading, or SI with a note."""
    where = f"column {_shown(table, column)!r}"
    text = given if given is not None else split_heading(table.headings[column])[1]
    if not text:
        if like := unit_within(table.headings[column]):
            raise InputError(
                f"{where} speaks of {like!r:.40}, but its unit cannot be told; give units=(displacement, force), each "
                "of m, mm, um, nm, N, mN, uN, nN, kN, Pa, kPa or MPa"
            )
        unit = Unit(SI[_KINDS[role][0]], _KINDS[role][0], 0)
        notes.append(f"The {where} has no unit; {unit.text} is assumed.")
        return unit
    unit = unit_named(text, where)
    if unit.kind not in _KINDS[role]:
        raise InputError(f"{where} is in {unit.text}, a unit of {unit.kind}; choose another column for the {role}")
    return unit


def _numbers(
    table: Table, columns: tuple[int, int], notes: list[str]
) -> tuple[np.ndarray[tuple[int, int], np.dtype[np.float64]], np.ndarray[tuple[int], np.dtype[np.int64]]]:
    """The rows with two numbers, and their lines."""
    kept, lines, missing = [], [], []
    for row, (line, _) in enumerate(table.rows):
        pair = [table.number(row, column) for column in columns]
        if None in pair:
            missing.append(line)
        else:
            kept.append(pair)
            lines.append(line)
    if missing:
        shown = ", ".join(map(str, missing[:_SHOWN])) + (", ..." if len(missing) > _SHOWN else "")
        plural = "s" if len(missing) > 1 else ""
        notes.append(f"Left out, since a number is missing or infinite: line{plural} {shown} ({len(missing)} in all).")
    if len(kept) < 3:
        raise InputError(f"the file has {len(kept)} rows with two numbers; give at least 3")
    return np.array(kept, dtype=np.float64), np.array(lines, dtype=np.int64)

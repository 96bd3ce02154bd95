"""The cells of a text file with columns: separators, decimal commas, comments, headings, each row with its line."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.record import described, quantity

# Units of what is measured, as column headings write them, and the SI units they are turned into.
#
# A table rather than a library of units: factors are exact, and a word that may or may not be a unit has to be refused.

Kind = Literal["length", "angle", "velocity", "voltage", "current", "number", "force", "stress", "torque"]
SI: dict[Kind, str] = {
    "length": "m",
    "angle": "rad",
    "velocity": "m/s",
    "voltage": "V",
    "current": "A",
    "number": "1",
    "force": "N",
    "stress": "Pa",
    "torque": "N m",
}
EXAMPLES = "m, mm, um, nm, inch, deg, V, N, mN, gf, lbf, N m, Pa, MPa, psi"
_POWERS = {"p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
_PREFIXES = {prefix: Fraction(10) ** power for prefix, power in _POWERS.items()}
_SPELLED_PREFIXES = {
    **{"": Fraction(1), "nano": _PREFIXES["n"], "micro": _PREFIXES["u"], "milli": _PREFIXES["m"]},
    **{"centi": Fraction(1, 100), "kilo": _PREFIXES["k"], "mega": _PREFIXES["M"]},
}
_SPELLED_BASES: dict[str, Kind] = {
    **{"meter": "length", "metre": "length", "newton": "force", "pascal": "stress"},
    **{"volt": "voltage", "ampere": "current", "radian": "angle"},
}
_INCH, _POUND, _GRAM_FORCE = Fraction("0.0254"), Fraction("4.4482216152605"), Fraction("0.00980665")  # exact
_DEGREE = Fraction(math.pi) / 180
_TABLE: dict[str, tuple[Kind, Fraction]] = {  # without blanks, ^ and *; capitals matter
    **{f"{p}m": ("length", size) for p, size in _PREFIXES.items() if size <= 1},
    **{"cm": ("length", Fraction(1, 100)), "dm": ("length", Fraction(1, 10)), "km": ("length", Fraction(1000))},
    **{name: ("length", _PREFIXES["u"]) for name in ("micron", "microns")},
    **{"Å": ("length", Fraction(1, 10**10)), "angstrom": ("length", Fraction(1, 10**10))},
    **{name: ("length", _INCH) for name in ("in", "inch", "inches", '"')},
    **{name: ("length", _INCH / 1000) for name in ("mil", "mils", "thou")},
    **{name: ("length", 12 * _INCH) for name in ("ft", "foot", "feet")},
    **{name: ("angle", _DEGREE) for name in ("deg", "degs", "degree", "degrees", "°")},
    **{"rad": ("angle", Fraction(1)), "mrad": ("angle", _PREFIXES["m"]), "urad": ("angle", _PREFIXES["u"])},
    **{f"{p}m/s": ("velocity", size) for p, size in _PREFIXES.items() if size <= 1},
    **{"cm/s": ("velocity", Fraction(1, 100)), "in/s": ("velocity", _INCH)},
    **{f"{p}V": ("voltage", size) for p, size in _PREFIXES.items() if size <= 1000},
    **{f"{p}A": ("current", size) for p, size in _PREFIXES.items() if size <= 1000},
    **{name: ("number", Fraction(1)) for name in ("1", "-")},
    "%": ("number", Fraction(1, 100)),
    **{f"{p}N": ("force", size) for p, size in _PREFIXES.items() if size <= 10**6},
    **{"cN": ("force", Fraction(1, 100)), "daN": ("force", Fraction(10)), "dyn": ("force", Fraction(1, 10**5))},
    **{name: ("force", _GRAM_FORCE) for name in ("gf", "grf")},
    **{name: ("force", 1000 * _GRAM_FORCE) for name in ("kgf", "kp")},
    **{name: ("force", _POUND) for name in ("lbf", "lbsf", "lb", "lbs", "pound-force")},
    **{"ozf": ("force", _POUND / 16), "kip": ("force", 1000 * _POUND), "kips": ("force", 1000 * _POUND)},
    **{f"{p}Pa": ("stress", size) for p, size in _PREFIXES.items() if size >= 1},
    **{"N/mm2": ("stress", _PREFIXES["M"]), "N/m2": ("stress", Fraction(1)), "hPa": ("stress", Fraction(100))},
    **{"bar": ("stress", Fraction(10**5)), "mbar": ("stress", Fraction(100))},
    **{"psi": ("stress", _POUND / _INCH**2), "ksi": ("stress", 1000 * _POUND / _INCH**2)},
    **{f"{p}Nm": ("torque", size) for p, size in _PREFIXES.items() if size <= 1000},
    **{"Ncm": ("torque", Fraction(1, 100)), "Nmm": ("torque", Fraction(1, 1000))},
    **{
        prefix + base: (kind, size)
        for prefix, size in _SPELLED_PREFIXES.items()
        for base, kind in _SPELLED_BASES.items()
    },
}
_WEAK = frozenset(("in", '"', "V", "A", "1", "-", "%"))  # words, numbers and marks, unless in brackets
_FOREIGN = frozenset(("cmh2o", "g", "kg", "kgs", "mmhg", "oz", "torr"))  # of mass, or of pressure and left out
_SPELLED = re.compile(r"(?:milli|micro|nano|pico|kilo|mega|giga|centi|deci)(?:met|newt|pasc)", re.IGNORECASE)
_WORDS = re.compile(r"[^\s\[\](){},;:=_|]+")
_BARE = str.maketrans({"µ": "u", "μ": "u", "^": None, "²": "2", "*": None, "·": None, "⋅": None, " ": None})
_HEADING = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\]]*)\]|\((?P<round>[^)]*)\)|(?:/|,)\s*(?P<bare>[^\s/,]+))\s*"
)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as written, what it measures, and the factor that turns it into the SI unit."""

    text: str
    kind: Kind
    factor: Fraction

    def to_si(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The values in the SI unit, with one rounding for powers of ten; ``values``: numbers in this unit."""
        top, bottom = self.factor.as_integer_ratio()
        if max(top, bottom) > 10**15:
            return values * float(self.factor)
        return values * float(top) / float(bottom)


def known_unit(text: str) -> Unit | None:
    """The unit a text stands for; None if it is none of those known.

    ``text``: such as ``um``, ``µm``, ``mN``, ``lbf``, ``millimeters`` or ``V``; capitals matter: ``mN`` is not ``MN``.
    """
    bare = text.strip().translate(_BARE)
    found = _TABLE.get(bare)
    if found is None and len(bare) > 3:  # spelled out
        found = _TABLE.get(bare.lower()) or _TABLE.get(bare.lower().removesuffix("s"))
    return None if found is None else Unit(text.strip(), *found)


def stands_alone(text: str) -> bool:
    """Whether a text is a unit even where no bracket says so: ``mm`` is, ``in`` and ``A`` are words and names too.

    ``text``: a word of a heading.
    """
    return text.strip() not in _WEAK and known_unit(text) is not None


def unit_named(text: str, where: str) -> Unit:
    """The unit a text stands for.

    ``text``: as for :func:`known_unit`; ``where``: what has this unit, for the message.

    Raises
    ------
    InputError
        It is not known.
    """
    found = known_unit(text)
    if found is None:
        raise InputError(
            f"{where} has the unit {text!r:.40}, which is not known; name the units of both columns with --units, or "
            f"units= in Python, for example {EXAMPLES}, or 1 for a plain number"
        )
    return found


def split_heading(text: str) -> tuple[str, str]:
    """Name and unit of a heading, as in ``depth [um]``, ``(um)``, ``/ um``, ``, um``, ``depth um``, ``depth_um``.

    Returns
    -------
    tuple of str
        The unit is empty where none is written.
    """
    heading = text.strip()
    match = _HEADING.fullmatch(heading)
    if match:
        unit = match["square"] or match["round"] or match["bare"] or ""
        if match["bare"] is None or stands_alone(unit) or (unit in ("V", "A") and "/" in heading):
            return match["name"].strip(), unit.strip()
    for mark in ("_", " ", "="):
        name, _, unit = heading.rpartition(mark)
        if name and stands_alone(unit):
            return name.strip(), unit
    return heading, ""


def unit_within(heading: str) -> str:
    """What in a heading without a unit looks like one all the same; empty if nothing does.

    ``depth (mm) LVDT``, ``depth [um] x1000``, ``load in lbf``: to take these for metres or newtons would be wrong.
    """
    words: list[str] = _WORDS.findall(heading)
    if len(words) == 1 and words[0].casefold() in ("in", "g", "kg", "v", "a"):
        return words[0]
    for word in words:
        known = len(word) > 1 and stands_alone(word)
        if known or word.casefold() in _FOREIGN or _SPELLED.match(word):
            return word
    return ""


_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?")
_WITH_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+(?:[eE][+-]?[0-9]+)?|[+-]?[0-9]+(?:[eE][+-]?[0-9]+)?")
_BEGINS = re.compile(r"\s*[+-]?[.,]?[0-9]")  # as a number does, and no heading
_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2},[0-9]{3}")
_PLAIN = re.compile(r"[-+0-9.,eE \t\n]*")
_WORDED = re.compile(r"[^\W\d]")
_MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "inf", "+inf", "-inf"}
_BLOCK = 3
_COMMENT = ("#", "%")
_LABEL = re.compile(r"\s*(?:columns?|names?)\s*:\s*", re.IGNORECASE)
_UNITS = re.compile(r"\s*units?\s*:\s*", re.IGNORECASE)
_WORD = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")


@described(frozen=True, kw_only=True, slots=True)
class Table:
    """Rows of cells below their headings."""

    headings: tuple[str, ...] = quantity("One a column; empty texts where the file has none")
    rows: tuple[tuple[int, list[str]], ...] = quantity("Line of the file, counted from 1, and its cells")
    decimal_comma: bool = quantity("Whether ``1,5`` is a number")
    repeated: tuple[int, ...] = quantity("Lines that repeat a heading, which are no rows", default=())
    numbers_above: tuple[int, ...] = quantity("Lines of numbers above the heading, which are none either", default=())

    def footer(self, columns: Sequence[int]) -> int:
        """How many of the last rows have a word instead of a number in one of the columns: a closing remark.

        ``columns``: the columns, counted from 0.
        """
        count = 0
        for _, cells in reversed(self.rows):
            whole = max(columns) < len(cells)
            chosen = [cells[i].strip() for i in columns] if whole else [cell.strip() for cell in cells]
            if not any(_WORDED.match(cell) and cell.lower() not in _MISSING for cell in chosen):
                break
            count += 1
        return count if count < len(self.rows) else 0

    def column_numbers(self, column: int, rows: int) -> NDArray[np.float64] | None:
        """A whole column at once; None where a cell or a row needs a closer look.

        ``column``: counted from 0; ``rows``: how many of the first rows.
        """
        width = len(self.headings)
        cells = [cells[column] for _, cells in self.rows[:rows] if len(cells) == width]
        text = "\n".join(cells)
        if len(cells) < rows or not _PLAIN.fullmatch(text) or (self.decimal_comma and "." in text):
            return None
        try:
            found = np.array(
                [float(cell) for cell in (text.replace(",", ".") if self.decimal_comma else text).split("\n")]
            )
        except ValueError:
            return None
        return found if np.isfinite(found).all() else None

    def like_thousands(self, columns: Sequence[int]) -> str:
        """A number whose comma may mark thousands, if no number of the columns shows that it does not; else empty.

        ``columns``: the columns, counted from 0.
        """
        cells = (cells[i].strip() for _, cells in self.rows for i in columns if i < len(cells) and "," in cells[i])
        first = next(cells, "") if self.decimal_comma else ""
        return first if first and _THOUSANDS.fullmatch(first) and all(map(_THOUSANDS.fullmatch, cells)) else ""

    def number(self, row: int, column: int) -> float | None:
        """The number in a cell; None where it is marked missing or infinite.

        ``row``, ``column``: the cell, counted from 0.

        Raises
        ------
        InputError
            The cell is absent or holds no number.
        """
        line, cells = self.rows[row]
        where = f"line {line}, column {self.headings[column] or column + 1!r:.60}"
        if column >= len(cells):
            raise InputError(f"{where}: the line has too few columns, {len(cells)}; give every column or the word nan")
        if any(extra.strip() for extra in cells[len(self.headings) :]):
            raise InputError(
                f"line {line} has {len(cells)} columns where the first has {len(self.headings)}; write decimals with a "
                "point, or separate the columns by semicolons"
            )
        cell = cells[column].strip().replace("\u2212", "-")
        if cell.lower() in _MISSING:
            return None
        if self.decimal_comma and "." in cell:
            raise InputError(
                f"{where}: {cell!r:.40} has a point in a file with decimal commas, which may stand for a thousand; "
                "write all numbers without marks of thousands"
            )
        text = cell.replace(",", ".") if self.decimal_comma and cell.count(",") == 1 else cell
        value = float(re.sub("[dD]", "e", text)) if _NUMBER.fullmatch(text) else None
        if value is None:
            raise InputError(f"{where}: {cell!r:.40} is not a number; write it as 1.5e-3, or nan where it is missing")
        if value in (float("inf"), float("-inf")):
            raise InputError(f"{where}: {cell!r:.40} is beyond the largest double; give a smaller number")
        return value


def table_of(text: str) -> Table:
    """The table in a text.

    Columns are separated by tabs, semicolons, commas or blanks, whichever the first line of numbers shows; numbers have
    a decimal comma where the separator leaves room for it and they show one.  Lines that begin with ``#`` or ``%`` are
    comments.  The heading is the last line above the numbers with as many cells, a comment if there is no other; a line
    of units may follow it.

    ``text``: the whole file.

    Raises
    ------
    InputError
        No line has two numbers.
    """
    lines = [
        (i, line) for i, line in enumerate(re.split(r"\r\n|\n|\r", text.removeprefix("\ufeff")), 1) if line.strip()
    ]
    plain = [(i, line) for i, line in lines if not line.lstrip().startswith(_COMMENT)]
    first = _first(plain)
    if first is None:
        raise InputError("no line has two numbers; give columns of numbers separated by commas, semicolons or tabs")
    start, separator = plain[first][0], _separator(plain[first][1]) or ""
    comma = separator != "," and any(_shows_comma(_cells(line, separator)) for _, line in plain[first : first + 200])
    width = len(_cells(plain[first][1], separator))
    above = [_cells(line, separator) for _, line in plain[:first]]
    if above and len(above[-1]) == width and all(map(_BEGINS.match, above[-1])):
        raise InputError(f"line {plain[first - 1][0]}: {above[-1][0]!r:.40} is not a number, nor a heading")
    comments = [line.lstrip().lstrip("#%") for i, line in lines if i < start and line.lstrip().startswith(_COMMENT)]
    again = {line.strip() for _, line in plain[max(0, first - 2) : first]}  # names and units
    return Table(
        headings=_headings(above, comments, separator, width),
        rows=tuple((i, _cells(line, separator)) for i, line in plain[first:] if line.strip() not in again),
        decimal_comma=comma,
        repeated=tuple(i for i, line in plain[first:] if line.strip() in again),
        numbers_above=tuple(i for i, line in plain[:first] if _separator(line) is not None),
    )


def _first(plain: Sequence[tuple[int, str]]) -> int | None:
    """Which line is the first row: the first of numbers, or of those below a heading if no three like rows precede it.

    Lines of numbers above a heading describe the test, such as the size of the specimen, and are no rows.
    """
    first: int | None = None
    heading, kind, count, seen = "", ("", 0), 0, set[str]()
    for i, (_, line) in enumerate(plain):
        separator = _separator(line)
        if separator is None:
            heading = "" if line in seen else line  # one that is repeated begins nothing new
            seen.add(line)
            continue
        this = separator, len(_cells(line, separator))
        if first is None or (heading and _heads(heading, *this)):
            first, count = i, 0
        heading, kind, count = "", this, count + 1 if this == kind else 1
        if count == _BLOCK:
            break
    return first


def _heads(line: str, separator: str, width: int) -> bool:
    """Whether a line has as many cells as the rows, and no number."""
    cells = _WORD.findall(line) if separator == " " else _cells(line, separator)
    return len(cells) == width and not any(map(_numeric, cells))


def _separator(line: str) -> str | None:
    """What separates the columns of a line with two numbers or more; None for any other line."""
    blanks = line.split()
    if len(blanks) > 1 and "," in line and all(map(_WITH_COMMA.fullmatch, blanks)):
        return "\t" if "\t" in line else " "
    for separator in ("\t", ";", ",", " "):
        cells = _cells(line, separator)
        if (separator == " " or separator in line) and sum(_numeric(cell) for cell in cells) > 1:
            return separator
        if len(cells) > 1 and _one_number(cells):
            return separator
    return None


def _one_number(cells: Sequence[str]) -> bool:
    """Whether a row has one number and otherwise marks for missing ones."""
    return any(map(_numeric, cells)) and all(_numeric(c) or c.strip().lower() in _MISSING - {""} for c in cells)


def _numeric(cell: str) -> bool:
    text = cell.strip().replace("\u2212", "-")
    return bool(_NUMBER.fullmatch(text) or _WITH_COMMA.fullmatch(text))


def _shows_comma(cells: Sequence[str]) -> bool:
    return any("," in cell and _WITH_COMMA.fullmatch(cell.strip().replace("\u2212", "-")) for cell in cells)


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' in line:
        cells = next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    else:
        cells = line.split(separator)
    while len(cells) > 2 and not cells[-1].strip():
        cells.pop()  # a separator at the end of the line
    return cells


def _headings(above: Sequence[Sequence[str]], comments: Sequence[str], separator: str, width: int) -> tuple[str, ...]:
    """The headings of the columns, with units from a line of their own where there is one."""
    named = [list(cells) for cells in above if len(cells) == width]
    if not named and separator == " " and above:
        named = [cells for cells in (_WORD.findall(" ".join(above[-1])),) if len(cells) == width]
    units = None
    if named and _are_units(named[-1], below=len(named) > 1):
        units = named.pop()
    if not named:
        for comment in comments:
            body = _LABEL.sub("", comment, count=1) if _LABEL.match(comment) else comment
            if _UNITS.match(comment):
                units = _of_width(_UNITS.sub("", comment, count=1), separator, width) or units
            else:
                found = _of_width(body, separator, width)
                named = [found] if found else named
        if named and _are_units(named[-1], below=False):
            units, named = named[-1], []
    names = [cell.strip() for cell in named[-1]] if named else [""] * width
    if units:
        names = [f"{name} [{unit.strip(' ()[]')}]" for name, unit in zip(names, units, strict=True)]
    return tuple(names)


def _of_width(body: str, separator: str, width: int) -> list[str] | None:
    """The cells of a comment if they are as many as there are columns, by the separator of the file or by blanks."""
    for cells in (_cells(body, separator) if separator != " " else [], _WORD.findall(body)):
        if len(cells) == width and any(re.search(r"[^\W\d]", cell) for cell in cells):
            return list(cells)
    return None


def _are_units(cells: Sequence[str], *, below: bool) -> bool:
    """Whether a line holds units, at least one of them known; ``A`` and ``in`` count below a heading only."""
    bare = [cell.strip().strip("()[]") for cell in cells]
    known = known_unit if below else stands_alone
    return any(map(known, bare)) and all(not text or len(text) < 7 or known_unit(text) for text in bare)

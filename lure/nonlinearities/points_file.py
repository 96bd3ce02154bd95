"""The points of a piecewise linear nonlinearity from a CSV file, every decimal taken exactly."""

from __future__ import annotations

import re
import stat
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

from lure.errors import InputError

MAX_BYTES = 1 << 20
MAX_POINTS = 10_000
MAX_DIGITS = 1000
_POINT = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_COMMA = re.compile(r"[+-]?(?:[0-9]+,?[0-9]*|,[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")

_SIGMA, _PHI = (re.compile(rf"(?<![^\W_]){name}(?![^\W_])", re.IGNORECASE) for name in ("(?:sigma|σ)", "(?:phi|φ|ϕ)"))
_UNIT = r"(?:\s*[\[(][^\])]*[\])])?"
_COMMENT = re.compile(  # the line of names as numpy.savetxt writes it, with phi before sigma
    rf"#\s*(?:phi|φ|ϕ){_UNIT}(?:\s*[;,]\s*|\s+)(?:sigma|σ){_UNIT}", re.IGNORECASE
)

Points = list[tuple[Fraction, Fraction]]


def points_from_csv(path: str | Path) -> Points:
    """The points ``(sigma, phi)`` of a file with two columns, with ``sigma`` ascending.

    Parameters
    ----------
    path : str or Path
        Text in UTF-8: two columns ``sigma`` and ``phi`` separated by commas, semicolons, tabs or blanks.  One line of
        names may stand above them, and tells the two apart where it names one of them ``sigma`` or ``phi``; empty
        lines and lines that start with ``#`` count for nothing, but for such a line of names.  With semicolons,
        tabs or blanks between the columns the decimal mark may be a comma.  Points in descending order are turned
        round.

    Raises
    ------
    InputError
        The file cannot be read, a line has not two numbers, or ``sigma`` is not strictly monotone; the message names
        the line.
    """
    label = Path(path).name
    lines = [(number, line.strip()) for number, line in enumerate(_text(Path(path), label).splitlines(), start=1)]
    swapped = any(_COMMENT.fullmatch(line) for _, line in lines)
    lines = [(number, line) for number, line in lines if line and not line.startswith("#")]
    if lines and not any(character.isdigit() for character in lines[0][1]):
        swapped, lines = _swapped(lines[0][1]), lines[1:]  # the names of the columns
    if len(lines) < 2:
        count = "1 point" if lines else "no points"
        raise InputError(f"{label} has {count}; a nonlinearity needs at least two lines with sigma and phi")
    if len(lines) > MAX_POINTS:
        raise InputError(f"{label} has {len(lines)} points; at most {MAX_POINTS} are allowed")
    pairs = [(number, _pair(line, number, label)) for number, line in lines]
    points = [(number, y, x) if swapped else (number, x, y) for number, (x, y) in pairs]
    if points[0][1] > points[-1][1]:
        points.reverse()
    for (_, before, _), (number, after, _) in pairwise(points):
        if not before < after:
            raise InputError(
                f"{label}, line {number}: sigma is {float(after):g} beside {float(before):g}; give the points in "
                "ascending order of sigma, each sigma once (a jump, or a loop of hysteresis, is no graph of this kind)"
            )
    return [(x, y) for _, x, y in points]


def _swapped(names: str) -> bool:
    """Whether the names of the columns say that ``phi`` stands before ``sigma``."""
    columns = [part for part in re.split(r"[;,\t]", names) if part.strip()]
    if len(columns) != 2:
        columns = names.split()
    if len(columns) != 2:  # words and units between blanks
        sigma, phi = _SIGMA.search(names), _PHI.search(names)
        return sigma is not None and phi is not None and phi.start() < sigma.start()
    (first_sigma, second_sigma), (first_phi, second_phi) = (
        [bool(name.search(column)) for column in columns] for name in (_SIGMA, _PHI)
    )
    return (first_phi and not second_phi) or (second_sigma and not first_sigma and not second_phi)


def _pair(line: str, number: int, label: str) -> tuple[Fraction, Fraction]:
    if ";" in line or "\t" in line:
        words, decimal_comma = re.split(r"[;\t]", line), "." not in line
    elif "," in line and not re.search(r"\s", line.replace(", ", ",")):
        words, decimal_comma = line.split(","), False
    else:
        words, decimal_comma = line.split(), "." not in line
    words = [word.strip() for word in words if word.strip()]
    if len(words) != 2:
        raise InputError(f"{label}, line {number}: {line!r:.60} has {len(words)} columns; give two, sigma and phi")
    x, y = (_number(word, number, label, decimal_comma=decimal_comma) for word in words)
    return x, y


def _number(word: str, number: int, label: str, *, decimal_comma: bool) -> Fraction:
    if not _POINT.fullmatch(word) and not (decimal_comma and _COMMA.fullmatch(word)):
        raise InputError(f"{label}, line {number}: {word!r:.60} is no number such as 0.5 or -1e-3")
    if len(word) > MAX_DIGITS or abs(value := Fraction(Decimal(word.replace(",", ".")))) >= 2**1024:
        raise InputError(f"{label}, line {number}: {word!r:.60} is beyond the largest double, or has too many digits")
    return value


def _text(path: Path, label: str) -> str:
    try:
        ordinary = stat.S_ISREG(path.stat().st_mode)  # nothing is read from a pipe or a device
        content = path.read_bytes() if ordinary and path.stat().st_size <= MAX_BYTES else b""
        size = path.stat().st_size
    except FileNotFoundError:
        raise InputError(
            f"the file {str(path)!r:.200} of the nonlinearity does not exist; give its path from the system file"
        ) from None
    except (OSError, ValueError):
        ordinary, content, size = False, b"", 0
    if not ordinary:
        raise InputError(f"the file {label!r:.100} of the nonlinearity cannot be read; give a readable CSV file")
    if size > MAX_BYTES:
        raise InputError(f"{label} is larger than {MAX_BYTES // 1024} KiB; give fewer points")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{label} is not UTF-8 text; save it as UTF-8") from None

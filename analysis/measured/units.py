"""Units of what is measured, as column headings write them, and the SI units they are turned into.

A table rather than a library of units: factors are exact, and a word that may or may not be a unit has to be refused.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError

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
        """The values in the SI unit, with one rounding for powers of ten.

        Parameters
        ----------
        values : ndarray
            Numbers in this unit.
        """
        top, bottom = self.factor.as_integer_ratio()
        if max(top, bottom) > 10**15:
            return values * float(self.factor)
        return values * float(top) / float(bottom)


def known_unit(text: str) -> Unit | None:
    """The unit a text stands for; None if it is none of those known.

    Parameters
    ----------
    text : str
        Such as ``um``, ``µm``, ``mN``, ``lbf``, ``millimeters`` or ``V``; capitals matter: ``mN`` is not ``MN``.
    """
    bare = text.strip().translate(_BARE)
    found = _TABLE.get(bare)
    if found is None and len(bare) > 3:  # spelled out
        found = _TABLE.get(bare.lower()) or _TABLE.get(bare.lower().removesuffix("s"))
    return None if found is None else Unit(text.strip(), *found)


def stands_alone(text: str) -> bool:
    """Whether a text is a unit even where no bracket says so: ``mm`` is, ``in`` and ``A`` are words and names too.

    Parameters
    ----------
    text : str
        A word of a heading.
    """
    return text.strip() not in _WEAK and known_unit(text) is not None


def unit_named(text: str, where: str) -> Unit:
    """The unit a text stands for.

    Parameters
    ----------
    text : str
        As for :func:`known_unit`.
    where : str
        What has this unit, for the message.

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

    Parameters
    ----------
    text : str
        The heading.

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

    Parameters
    ----------
    heading : str
        The heading.
    """
    words: list[str] = _WORDS.findall(heading)
    if len(words) == 1 and words[0].casefold() in ("in", "g", "kg", "v", "a"):
        return words[0]
    for word in words:
        known = len(word) > 1 and stands_alone(word)
        if known or word.casefold() in _FOREIGN or _SPELLED.match(word):
            return word
    return ""

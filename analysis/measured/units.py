"""Units of length, force and stress as column headings write them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from lure.errors import InputError

Kind = Literal["length", "force", "stress"]
SI: dict[Kind, str] = {"length": "m", "force": "N", "stress": "Pa"}
_PREFIXES = {"p": -12, "n": -9, "u": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
_TABLE: dict[str, tuple[Kind, int]] = {
    **{f"{prefix}m": ("length", power) for prefix, power in _PREFIXES.items() if power <= 0},
    "cm": ("length", -2),
    "micron": ("length", -6),
    "microns": ("length", -6),
    **{f"{prefix}N": ("force", power) for prefix, power in _PREFIXES.items() if power <= 6},
    **{f"{prefix}Pa": ("stress", power) for prefix, power in _PREFIXES.items() if power >= 0},
    "N/mm2": ("stress", 6),
    "N/m2": ("stress", 0),
}
_FOREIGN = frozenset(
    (
        *("bar", "cmh2o", "dan", "dyn", "ft", "gf", "hpa", "inch", "inches", "kgf", "kgs", "kip", "kips", "kp", "ksi"),
        *("lb", "lbf", "lbs", "mbar", "mil", "mils", "mmhg", "oz", "ozf", "psi", "thou", "torr"),
    )
)
_SPELLED = re.compile(
    r"(?:milli|micro|nano|pico|kilo|mega|giga|centi|deci)(?:met|newt|pasc)|newtons?$|pascals?$", re.IGNORECASE
)
_WORDS = re.compile(r"[^\s\[\](){},;:=_|]+")
_MICRO = str.maketrans({"µ": "u", "μ": "u", "^": None, "²": "2", "*": None, " ": None})
_HEADING = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\]]*)\]|\((?P<round>[^)]*)\)|(?:/|,)\s*(?P<bare>[^\s/,]+))\s*"
)


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit as written, what it measures, and the power of ten that turns it into the SI unit."""

    text: str
    kind: Kind
    power: int


def known_unit(text: str) -> Unit | None:
    """The unit a text stands for; None if it is none of length, force or stress.

    Parameters
    ----------
    text : str
        Such as ``um``, ``µm``, ``mN`` or ``MPa``; capitals matter, since ``mN`` is not ``MN``.
    """
    found = _TABLE.get(text.strip().translate(_MICRO))
    return None if found is None else Unit(text.strip(), *found)


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
        It is no unit of length, force or stress.
    """
    found = known_unit(text)
    if found is None:
        raise InputError(
            f"{where} has the unit {text!r:.40}; give m, mm, um, nm, N, mN, uN, nN, kN, Pa, kPa or MPa, or no unit: "
            "the numbers are then taken as they stand, as if in m and N"
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
        if match["bare"] is None or known_unit(unit):
            return match["name"].strip(), unit.strip()
    for mark in ("_", " ", "="):
        name, _, unit = heading.rpartition(mark)
        if name and known_unit(unit):
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
    if len(words) == 1 and words[0].casefold() in ("in", "g", "kg"):
        return words[0]
    for word in words:
        known = len(word) > 1 and known_unit(word) is not None
        if known or word.casefold() in _FOREIGN or _SPELLED.match(word):
            return word
    return ""

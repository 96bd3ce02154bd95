"""Loops as TOML: the commented template to start from, and any loop written out."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from fractions import Fraction
from importlib.resources import files

from lure.delay import DelayBlock
from lure.errors import InputError
from lure.expressions.tree import decimal
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.systems_loop import LoopSystem


def plant_template() -> str:
    """The commented TOML file of a plant to start from."""
    return files("lure").joinpath("templates/plant.toml").read_text(encoding="utf-8")


def loop_tables(system: LoopSystem) -> dict[str, object]:
    """The tables of the file that means this loop, numbers as exact fractions.

    Parameters
    ----------
    system : LoopSystem
        The loop.

    Raises
    ------
    InputError
        The block is a matrix in floating point, which no file of a page holds.
    """
    tables: dict[str, object] = {"name": system.name, "title": system.title, "plant": _plant(system)}
    if system.law_table is not None:
        tables["nonlinearity"] = dict(system.law_table)
    if system.law_class is not None:
        tables["class"] = _class(system.law_class)
    return tables


def loop_to_toml(system: LoopSystem) -> str:
    """A TOML file that reads back as the same loop, except for its source, which becomes a comment.

    Parameters
    ----------
    system : LoopSystem
        The loop.

    Raises
    ------
    InputError
        The block is a matrix in floating point, which no file of a page holds.

    Examples
    --------
    >>> from lure.loop_library import builtin_loop
    >>> print(loop_to_toml(builtin_loop("third-order")))
    # a plant whose limits have a closed form
    name = "third-order"
    title = "an integrator and two lags: Popov reaches 6, the circle 4/3"
    <BLANKLINE>
    [plant]
    num = [1]
    den = [1, 3, 2, 0]
    <BLANKLINE>
    """
    lines = [f"# {' '.join(system.source.split())}"] if system.source.strip() else []
    for key, value in loop_tables(system).items():
        if isinstance(value, dict):
            lines += ["", f"[{key}]", *(f"{name} = {_written(entry)}" for name, entry in value.items())]
        else:
            lines.append(f"{key} = {_written(value)}")
    return "\n".join(lines) + "\n"


def _plant(system: LoopSystem) -> dict[str, object]:
    block = system.block
    if isinstance(block, DelayBlock):
        terms = [f"({_formula(top)})*exp(-({_text(delay)})*s)" for delay, top in block.terms]
        return {"transfer": f"({' + '.join(terms)})/({_formula(block.denominator)})"}
    if not isinstance(block, RationalBlock):
        raise InputError(f"the {block} is too large for a system file; keep its matrices elsewhere")
    plant: dict[str, object] = {"num": block.numerator, "den": block.denominator}
    return plant if block.dt is None else {**plant, "dt": block.dt}


def _class(asked: LawClass) -> dict[str, object]:
    table: dict[str, object] = {"sector": (asked.sector.lower, asked.sector.upper)}
    if asked.slope is not None:
        table["slope"] = (asked.slope.lower, asked.slope.upper)
    return table | {"odd": asked.odd, "time_varying": asked.time_varying}


def _formula(coefficients: Sequence[Fraction]) -> str:
    """A polynomial in ``s`` with exact coefficients."""
    powers = range(len(coefficients) - 1, -1, -1)
    terms = [f"({_text(c)})*s**{n}" for n, c in zip(powers, coefficients, strict=True) if c]
    return " + ".join(terms) or "0"


def _text(value: Fraction) -> str:
    """The number exactly, as a decimal if it is one."""
    return decimal(value) or f"{value.numerator}/{value.denominator}"


def _written(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(entry) for entry in value)}]"
    if isinstance(value, float) and math.isinf(value):
        return "inf" if value > 0 else "-inf"
    assert isinstance(value, int | float | Fraction), "tables hold numbers, texts, truth values and lists"
    text = _text(Fraction(value))
    return f'"{text}"' if "/" in text else text

"""Loops as TOML: the commented template to start from, and any loop written out."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from fractions import Fraction
from importlib.resources import files
from pathlib import Path

from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.expressions.tree import decimal
from lure.files.builtin import builtin_loop, loop_names
from lure.files.kinds import FileKind
from lure.files.schema import LAW_TEXTS, PLANT_TABLES, ClassTable, PlantTable, PlantTables
from lure.files.system import LoopSystem, loop_system
from lure.nonlinearities.piecewise_linear import outer_slopes
from lure.nonlinearities.points_file import points_from_csv
from lure.plants.conversion import one_channel
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

# From checked tables to a :class:`lure.files.system.LoopSystem`, with the checks that concern several keys at once.

_FORMS = "num and den, or A, B and C, or transfer"


def built_loop(tables: PlantTables, *, title: str, source: str, folder: Path) -> LoopSystem:
    """The loop of a file.

    Parameters
    ----------
    tables : PlantTables
        The checked tables.
    title : str
        Title, should the file have none.
    source : str
        Where the file comes from.
    folder : Path
        Where the files lie that it names.

    Raises
    ------
    InputError
        The plant is given in no form or in several, it is refused by :func:`lure.plants.as_plant`, the nonlinearity or
        the class is refused, or the nonlinearity is not known to belong to the class.
    """
    identity = (tables.name or "loop", tables.title or title, source)
    block = _block(tables.plant)
    nonlinearity_class = None if tables.nonlinearity_class is None else _nonlinearity_class(tables.nonlinearity_class)
    if tables.nonlinearity is None:
        return loop_system(identity, block, nonlinearity_class=nonlinearity_class)
    try:
        table = _with_points(tables.nonlinearity.nonlinearity_table(), folder)
        return loop_system(identity, block, nonlinearity_table=table, nonlinearity_class=nonlinearity_class)
    except InputError as error:
        raise InputError(f"nonlinearity: {error}") from None


def _with_points(table: dict[str, object], folder: Path) -> dict[str, object]:
    """The table of a nonlinearity with the points of its file in place of the file, so that it stands for itself."""
    file = table.get("file")
    if not isinstance(file, str) or "points" in table:
        return table
    points = points_from_csv(folder / file)
    left, right = outer_slopes(points)
    rest = {key: value for key, value in table.items() if key != "file"}
    return {"left_slope": left, "right_slope": right, **rest, "points": [list(point) for point in points]}


def _block(plant: PlantTable) -> RationalPlant | DelayPlant | StateSpace:
    given = {key for key in ("num", "den", "A", "B", "C", "D", "transfer") if getattr(plant, key) is not None}
    try:
        if given == {"num", "den"}:
            found = one_channel((plant.num, plant.den), dt=plant.dt)
        elif given in ({"A", "B", "C"}, {"A", "B", "C", "D"}):
            found = one_channel((plant.A, plant.B, plant.C, 0 if plant.D is None else plant.D), dt=plant.dt)
        elif given == {"transfer"}:
            found = one_channel(str(plant.transfer), dt=plant.dt)
        else:
            listed = ", ".join(sorted(given)) or "none of them"
            raise InputError(f"the block is given by {_FORMS}; got {listed}")
    except InputError as error:
        raise InputError(f"plant: {error}") from None
    assert not isinstance(found, FrequencyData), "no key of a file holds frequency data"
    return found


def _nonlinearity_class(table: ClassTable) -> NonlinearityClass:
    slope = None if table.slope is None else SlopeBounds(*table.slope)
    if table.sector is None and slope is None:
        raise InputError("class: neither sector nor slope is given; give one, such as sector = [0, 5.9]")
    bounds = table.sector if table.sector is not None else table.slope
    assert bounds is not None, "one of the two is given"
    try:
        return NonlinearityClass(sector=Sector(*bounds), slope=slope, odd=table.odd, time_varying=table.time_varying)
    except InputError as error:
        raise InputError(f"class: {error}") from None


def plant_template() -> str:
    """The commented TOML file of a plant to start from."""
    return files("lure").joinpath("files", "plant.toml").read_text(encoding="utf-8")


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
    if system.nonlinearity_table is not None:
        tables["nonlinearity"] = dict(system.nonlinearity_table)
    if system.nonlinearity_class is not None:
        tables["class"] = _class(system.nonlinearity_class)
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
    >>> from lure.files.builtin import builtin_loop
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
    if isinstance(block, DelayPlant):
        terms = [f"({_formula(top)})*exp(-({_text(delay)})*s)" for delay, top in block.terms]
        return {"transfer": f"({' + '.join(terms)})/({_formula(block.denominator)})"}
    if not isinstance(block, RationalPlant):
        raise InputError(f"the {block} is too large for a system file; keep its matrices elsewhere")
    plant: dict[str, object] = {"num": block.numerator, "den": block.denominator}
    return plant if block.dt is None else {**plant, "dt": block.dt}


def _class(asked: NonlinearityClass) -> dict[str, object]:
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


PLANT_FILE = FileKind(
    word="loop",
    tables=PLANT_TABLES,
    model=PlantTables,
    build=built_loop,
    written=loop_tables,
    names=loop_names,
    builtin=builtin_loop,
    texts=("name", "title", "plant.transfer", *(f"nonlinearity.{key}" for key in LAW_TEXTS)),
    single=("name", "title"),
    letters={"numerator": "plant.num", "denominator": "plant.den", "H": "plant.transfer", "G": "plant.transfer"},
    free="nonlinearity",
)
"""Files with a ``[plant]``, and the built-in loops."""

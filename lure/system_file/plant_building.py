"""From checked tables to a :class:`lure.systems_loop.LoopSystem`, with the checks that concern several keys at once."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lure.delay import DelayBlock
from lure.errors import InputError
from lure.frequency_data import FrequencyData
from lure.inputs import as_block
from lure.law_class import LawClass
from lure.laws.points import outer_slopes
from lure.laws.points_file import points_from_csv
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds
from lure.state_space import StateSpaceBlock
from lure.system_file.plant_schema import PLANT_TABLES, ClassTable, PlantTable, PlantTables
from lure.system_file.schema import TABLES
from lure.systems_loop import LoopSystem, loop_system

_FORMS = "num and den, or A, B and C, or transfer"


def is_plant_file(tables: Mapping[str, Any]) -> bool:
    """Whether the tables of a file are those of a loop rather than of a rod.

    Parameters
    ----------
    tables : Mapping
        The tables of the file.

    Raises
    ------
    InputError
        The file has both a rod and a plant.
    """
    if "rod" in tables and "plant" in tables:
        raise InputError("the file has both [rod] and [plant]; give one of them, or two files")
    if any(table in tables for table in TABLES):
        return False
    if any(table in tables for table in PLANT_TABLES):
        return True
    known = [*TABLES, *PLANT_TABLES, "name", "title"]
    near = [difflib.get_close_matches(key[:40].lower(), known, n=1, cutoff=0.6) for key in tables]
    return any(match and match[0] in PLANT_TABLES for match in near)


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
        The plant is given in no form or in several, it is refused by :func:`lure.inputs.as_block`, the law or the class
        is refused, or the law is not known to belong to the class.
    """
    identity = (tables.name or "loop", tables.title or title, source)
    block = _block(tables.plant)
    law_class = None if tables.law_class is None else _law_class(tables.law_class)
    if tables.nonlinearity is None:
        return loop_system(identity, block, law_class=law_class)
    try:
        table = _with_points(tables.nonlinearity.law_table(), folder)
        return loop_system(identity, block, law_table=table, law_class=law_class)
    except InputError as error:
        raise InputError(f"nonlinearity: {error}") from None


def _with_points(table: dict[str, object], folder: Path) -> dict[str, object]:
    """The table of a law with the points of its file in place of the file, so that it stands for itself."""
    file = table.get("file")
    if not isinstance(file, str) or "points" in table:
        return table
    points = points_from_csv(folder / file)
    left, right = outer_slopes(points)
    rest = {key: value for key, value in table.items() if key != "file"}
    return {"left_slope": left, "right_slope": right, **rest, "points": [list(point) for point in points]}


def _block(plant: PlantTable) -> RationalBlock | DelayBlock | StateSpaceBlock:
    given = {key for key in ("num", "den", "A", "B", "C", "D", "transfer") if getattr(plant, key) is not None}
    try:
        if given == {"num", "den"}:
            found = as_block((plant.num, plant.den), dt=plant.dt)
        elif given in ({"A", "B", "C"}, {"A", "B", "C", "D"}):
            found = as_block((plant.A, plant.B, plant.C, 0 if plant.D is None else plant.D), dt=plant.dt)
        elif given == {"transfer"}:
            found = as_block(str(plant.transfer), dt=plant.dt)
        else:
            listed = ", ".join(sorted(given)) or "none of them"
            raise InputError(f"the block is given by {_FORMS}; got {listed}")
    except InputError as error:
        raise InputError(f"plant: {error}") from None
    assert not isinstance(found, FrequencyData), "no key of a file holds frequency data"
    return found


def _law_class(table: ClassTable) -> LawClass:
    slope = None if table.slope is None else SlopeBounds(*table.slope)
    if table.sector is None and slope is None:
        raise InputError("class: neither sector nor slope is given; give one, such as sector = [0, 5.9]")
    bounds = table.sector if table.sector is not None else table.slope
    assert bounds is not None, "one of the two is given"
    try:
        return LawClass(sector=Sector(*bounds), slope=slope, odd=table.odd, time_varying=table.time_varying)
    except InputError as error:
        raise InputError(f"class: {error}") from None

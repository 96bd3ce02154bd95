"""Loops as TOML: the commented template to start from, and any loop written out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from fractions import Fraction
from importlib.resources import files
from pathlib import Path
from typing import cast

from lure.classes import DELAYS, FULL_BLOCK, OPERATORS, SCALAR, Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.expressions.tree import decimal
from lure.files.builtin import builtin_loop, loop_names
from lure.files.controller import with_network
from lure.files.kinds import FileKind
from lure.files.schema import LAW_TEXTS, PLANT_TABLES, ClassTable, PlantTable, PlantTables
from lure.files.system import Block, LoopSystem, ManyChannels, channel_system, loop_system
from lure.nonlinearities.base import LocalSector
from lure.nonlinearities.piecewise_linear import outer_slopes
from lure.nonlinearities.points_file import points_from_csv
from lure.plants.channel_family import ChannelFamily
from lure.plants.conversion import as_plant, transfer_matrix
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix, one_channel_of
from lure.plants.family import PlantFamily
from lure.plants.interconnection import padded
from lure.plants.multivariable import MultivariablePlant, counted
from lure.plants.parameters import flat, names_in
from lure.plants.performance import Forcing, Performance
from lure.plants.rational import RationalPlant

# From checked tables to a :class:`lure.files.system.LoopSystem`, with the checks that concern several keys at once.

_FORMS = "num and den, or A, B and C, or transfer"


def built_loop(tables: PlantTables, *, title: str, source: str, folder: Path) -> LoopSystem:
    """The loop of a file, with its performance if it states one.

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
    tables, own = _apart(tables)
    system = _closed((tables.name or "loop", tables.title or title, source), tables, folder)
    system = replace(system, ask=() if tables.report is None else tables.report.ask)
    if tables.forcing is not None:
        stated = {name: side for name, side in tables.forcing if side}
        system = replace(system, forcing=Forcing.given(stated))
    if tables.performance is None:
        return system
    stated = {name: side for name, side in tables.performance if side is not None}
    states = [name for name in ("Bw", "Cz") if name in stated]
    if states and tables.plant.A is None:
        raise InputError(
            f"performance.{states[0]} is about the states, and the plant is given without; give it by A, B and C"
        )
    block = system.block
    performance = Performance.given({**stated, "parameters": own} if own else stated)
    if isinstance(block, PlantFamily | ChannelFamily):
        performance.beside(block.channels if isinstance(block, PlantFamily) else block)
        return replace(system, performance=performance)
    if isinstance(block, RationalPlant):
        block = MultivariablePlant.of_one_channel(block)
    if isinstance(block, DelayPlant):
        block = one_channel_of(block)
    if not isinstance(block, MultivariablePlant | DelayMatrix):
        raise InputError("performance needs a plant with exact entries; give num and den, transfer, or A, B and C")
    performance.beside(block)
    return replace(system, performance=performance)


def _apart(tables: PlantTables) -> tuple[PlantTables, dict[str, object]]:
    """The tables without the parameters that occur in ``[performance]`` alone, and those, with its constants."""
    bounds = tables.plant.parameters or {}
    used = names_in([side for _, side in tables.performance or ()])
    of_plant = names_in([side for name, side in tables.plant if name != "parameters"])
    own = {name: one for name, one in bounds.items() if name in used - of_plant}
    constants = {name: one for name, one in bounds.items() if name in used & of_plant and isinstance(one, Fraction)}
    if own:
        kept = {name: one for name, one in bounds.items() if name not in own}
        tables = tables.model_copy(update={"plant": tables.plant.model_copy(update={"parameters": kept})})
    return tables, {**own, **constants}


def _closed(identity: tuple[str, str, str], tables: PlantTables, folder: Path) -> LoopSystem:
    """The block of a file and what closes the loop."""
    if tables.controller is not None:
        if tables.nonlinearity_class:
            raise InputError(
                "class: it is given beside [controller]; give [[nonlinearity]], or the loop without a network"
            )
        known = _known(tables, folder)
        return with_network(identity, tables.plant, tables.controller, folder, known=known, block_of=_block)
    block = _block(tables.plant)
    if any(table.on is not None for table in tables.nonlinearity_class):
        return _on_intervals(identity, _only_channel(block, tables), tables)
    channels = (table.relu or _operates(table) or table.rate is not None for table in tables.nonlinearity_class)
    if any(channels):
        block = _only_channel(block, tables)  # what is known of these is known of channels
    if isinstance(block, ManyChannels):
        return _with_channels(identity, block, tables, folder)
    for word, listed in (("class", tables.nonlinearity_class), ("nonlinearity", tables.nonlinearity)):
        if sum(table.repeated for table in listed) > 1:
            raise InputError(
                f"{word}: the tables are about {sum(table.repeated for table in listed)} channels, and the plant has "
                f"one input and one output; give one table [{word}], or a plant with several channels"
            )
    nonlinearity_class = _nonlinearity_class(tables.nonlinearity_class[0]) if tables.nonlinearity_class else None
    if not tables.nonlinearity:
        return loop_system(identity, block, nonlinearity_class=nonlinearity_class)
    try:
        table = _with_points(tables.nonlinearity[0].nonlinearity_table(), folder)
        return loop_system(identity, block, nonlinearity_table=table, nonlinearity_class=nonlinearity_class)
    except InputError as error:
        raise InputError(f"nonlinearity: {error}") from None


def _on_intervals(identity: tuple[str, str, str], plant: ManyChannels, tables: PlantTables) -> LoopSystem:
    """The loop of a file whose classes hold on intervals."""
    found = list[LocalSector]()
    if isinstance(plant, ChannelFamily):
        raise InputError(
            "class: on is not asked for plants with parameters yet; give each parameter one number, or leave on out"
        )
    if tables.nonlinearity:
        raise InputError("class: on is given beside a nonlinearity, whose bounds are found; leave one out")
    for number, table in enumerate(tables.nonlinearity_class, 1):
        with _numbered("class", number, len(tables.nonlinearity_class)):
            found += [_local_sector(table)] * table.repeated
    if not len(found) == plant.inputs == plant.outputs:
        raise InputError(
            f"class: the tables are about {counted(len(found), 'channel')}, and the plant has {plant.size}; give one "
            "for each channel, in order, with repeated = n for one that acts in n"
        )
    return replace(channel_system(identity, plant), local=tuple(found))


def _local_sector(table: ClassTable) -> LocalSector:
    if table.on is None or table.sector is None or math.inf in map(abs, table.sector):
        raise InputError(
            "class: on is given without sector, or not everywhere; give sector = [l, u], finite, and on = [-a, b] for "
            "each channel"
        )
    given = [table.slope, table.gain, table.rate, table.norm, table.size, table.dynamics, table.memory, table.delay]
    if any(one is not None for one in given) or table.odd or table.relu or table.time_varying:
        raise InputError("class: on is given beside other keys; give sector = [l, u] and on = [-a, b] alone")
    low, high = table.on
    if not low < 0 < high:
        raise InputError(f"class: on is [{float(low):g}, {float(high):g}]; give an interval around 0, such as [-1, 2]")
    reach = min(-low, high)
    if reach == math.inf:
        raise InputError("class: on is the whole line; leave it out, as the sector then holds everywhere")
    return LocalSector(*table.sector, reach)


def _only_channel(block: Block, tables: PlantTables) -> ManyChannels:
    """The plant of a ReLU, a slow gain or an operator, which the theorems on several nonlinearities are about."""
    if isinstance(block, PlantFamily | ChannelFamily):
        return block.channels if isinstance(block, PlantFamily) else block
    if isinstance(block, RationalPlant | MultivariablePlant):
        return block if isinstance(block, MultivariablePlant) else MultivariablePlant.of_one_channel(block)
    given = tables.first_of(
        "rate", "delay", "memory", "on", *(() if isinstance(block, DelayMatrix) else ("relu", "norm"))
    )
    if given or not isinstance(block, DelayMatrix):
        raise InputError(f"class: {given} needs a plant with exact rational entries; leave the dead time out, or this")
    return block


def _with_channels(
    identity: tuple[str, str, str],
    plant: ManyChannels,
    tables: PlantTables,
    folder: Path,
) -> LoopSystem:
    """The loop of a file whose plant has several channels."""
    sizes = [table.size or (table.repeated, table.repeated) for table in tables.nonlinearity_class]
    listed, repeated = list[NonlinearityClass](), tuple(map(max, sizes))
    for number, (table, size) in enumerate(zip(tables.nonlinearity_class, repeated, strict=True), 1):
        with _numbered("class", number, len(repeated)):
            listed += [_nonlinearity_class(table)] * size
    if any(ins != outs for ins, outs in sizes):
        if any(entry.channel for entry in tables.nonlinearity):
            raise InputError("class: size has unequal numbers beside nonlinearities with a channel; give a square one")
        if isinstance(plant, ChannelFamily):
            raise InputError("class: size has unequal numbers beside parameters; give a square one")
        if isinstance(plant, DelayMatrix):
            raise InputError("class: size has unequal numbers, and the plant dead time; give a square one")
        with _numbered("class", 1, 1):
            plant = padded(plant, sizes)
    classes = Diagonal(tuple(listed), repeated=repeated) if listed else None
    return channel_system(identity, plant, classes=classes, nonlinearity_tables=_known(tables, folder))


def _known(tables: PlantTables, folder: Path) -> list[dict[str, object]]:
    """The tables of the nonlinearities, each standing for itself."""
    known = list[dict[str, object]]()
    for number, entry in enumerate(tables.nonlinearity, 1):
        with _numbered("nonlinearity", number, len(tables.nonlinearity)):
            found = _with_points(entry.nonlinearity_table(), folder)
        found |= {} if entry.repeated == 1 else {"repeated": entry.repeated}
        known.append(found | ({} if entry.channel is None else {"channel": entry.channel}))
    return known


@contextmanager
def _numbered(word: str, number: int, of: int) -> Iterator[None]:
    """Errors say which table of several it is."""
    try:
        yield
    except InputError as error:
        raise InputError(f"[[{word}]] number {number}: {error}" if of > 1 else str(error)) from None


def _with_points(table: dict[str, object], folder: Path) -> dict[str, object]:
    """The table of a nonlinearity with the points of its file in place of the file, so that it stands for itself."""
    file = table.get("file")
    if not isinstance(file, str) or "points" in table:
        return table
    points = points_from_csv(folder / file)
    left, right = outer_slopes(points)
    rest = {key: value for key, value in table.items() if key != "file"}
    return {"left_slope": left, "right_slope": right, **rest, "points": [list(point) for point in points]}


def _block(plant: PlantTable) -> Block:
    given = {key for key in ("num", "den", "A", "B", "C", "D", "transfer") if getattr(plant, key) is not None}
    found: object
    try:
        if plant.parameters is not None:
            return _with_parameters(plant, given)
        if given == {"num", "den"}:
            found = as_plant((plant.num, plant.den), dt=plant.dt)
        elif given in ({"A", "B", "C"}, {"A", "B", "C", "D"}):
            found = as_plant((plant.A, plant.B, plant.C, 0 if plant.D is None else plant.D), dt=plant.dt)
        elif given == {"transfer"}:
            rows = isinstance(plant.transfer, list)
            found = (transfer_matrix if rows else as_plant)(plant.transfer, dt=plant.dt)  # type: ignore[arg-type]  # rows for the one
        else:
            listed = ", ".join(sorted(given)) or "none of them"
            raise InputError(f"the block is given by {_FORMS}; got {listed}")
    except InputError as error:
        raise InputError(f"plant: {error}") from None
    assert isinstance(found, Block), "no key of a file holds frequency data"
    return found


def _has_channels(plant: PlantTable) -> bool:
    """Whether ``B`` has several columns, or ``C`` several rows."""
    inward, outward = (
        [row if isinstance(row, list | tuple) else None for row in side or ()] for side in (plant.B, plant.C)
    )
    many = sum(row is not None for row in outward) > 1
    column = many and all(row is not None and len(row) == 1 for row in outward) and len(outward) == len(plant.A or ())
    return any(row is not None and len(row) > 1 for row in inward) or (many and not column)


def _with_parameters(plant: PlantTable, given: set[str]) -> Block:
    """The plants of a table with parameters."""
    bounds = plant.parameters or {}
    if given == {"num", "den"}:
        return PlantFamily.of_coefficients(plant.num or (), plant.den or (), bounds, plant.dt)
    if given in ({"A", "B", "C"}, {"A", "B", "C", "D"}):
        direct = 0 if plant.D is None else plant.D
        if not _has_channels(plant) and any(isinstance(one, tuple) and len(one) == 3 for one in bounds.values()):
            column, row = [[v] for v in flat(plant.B or ())], [flat(plant.C or ())]
            return ChannelFamily.of_matrices(plant.A, column, row, [flat(direct)], bounds, dt=plant.dt)
        if _has_channels(plant):
            return ChannelFamily.of_matrices(plant.A, plant.B, plant.C, plant.D, bounds, dt=plant.dt)
        return PlantFamily.of_matrices(plant.A or (), plant.B or (), plant.C or (), direct, bounds, dt=plant.dt)
    if given == {"transfer"} and isinstance(plant.transfer, list):
        return ChannelFamily.of_transfers(plant.transfer, bounds, plant.dt)
    if given == {"transfer"} and isinstance(plant.transfer, str):
        return PlantFamily.of_formula(plant.transfer, bounds, plant.dt)
    raise InputError(f"with parameters the block is given by {_FORMS}; got {', '.join(sorted(given)) or 'none'}")


def _operates(table: ClassTable) -> bool:
    """Whether it is about an operator, a function of several channels, a delay or memory."""
    return any(one is not None for one in (table.norm, table.size, table.delay, table.memory))


def _delay(table: ClassTable, bound: Fraction) -> NonlinearityClass:
    given = [table.sector, table.slope, table.gain, table.norm, table.size, table.dynamics]
    if any(one is not None for one in given) or table.odd or table.relu:
        raise InputError(
            "class: delay is given beside other keys; give delay = h, with time_varying = true if it may change, with "
            "rate = d if it changes by at most d in a second, and repeated = n if it is one delay in n channels"
        )
    return NonlinearityClass.delayed(bound, varying=table.time_varying, rate=table.rate)


def _memory(table: ClassTable, kind: str) -> NonlinearityClass:
    given = [table.sector, table.gain, table.rate, table.norm, table.size, table.dynamics, table.delay]
    low, high = table.slope or (None, None)
    if any(one is not None for one in given) or table.odd or table.relu or table.time_varying or low != 0:
        raise InputError(
            f"class: memory is given beside other keys, or without the slope; give memory = {kind!r} and slope = [0, k]"
        )
    try:
        return NonlinearityClass.hysteretic(kind, high or 0)
    except InputError as error:
        raise InputError(f"class: {error}") from None


def _nonlinearity_class(table: ClassTable) -> NonlinearityClass:
    if table.memory is not None:
        return _memory(table, table.memory)
    if table.delay is not None:
        return _delay(table, table.delay)
    if table.norm is not None:
        given = [table.sector, table.slope, table.gain]
        if any(one is not None for one in given) or table.odd or table.time_varying:
            raise InputError(
                "class: norm is given beside other keys; of an operator give norm = r, with size and dynamics if it is "
                "not of one channel, or not any, or with repeated = n if it is one in each of n channels"
            )
        if table.repeated > 1 and (table.size is not None or table.dynamics != OPERATORS[1]):
            raise InputError(
                f"class: repeated of an operator is {table.repeated} beside size, or dynamics is not {OPERATORS[1]!r}; "
                f"give size for an operator on all channels together, or dynamics = {OPERATORS[1]!r} for one in each"
            )
        dynamics = SCALAR if table.repeated > 1 else table.dynamics or "any"
        return NonlinearityClass.norm_bounded(table.norm, dynamics=dynamics)
    if table.dynamics is not None:
        raise InputError("class: dynamics is of an operator, whose norm is not given; give norm = r")
    if table.size is not None:
        return _full_block(table, table.size)
    if table.gain is not None:
        if table.sector is not None or table.slope is not None or table.odd or table.time_varying or table.relu:
            raise InputError(
                "class: gain is given beside other keys; a constant gain has no other properties, so give "
                "gain = [a, b] alone, or a sector"
            )
        if table.rate is not None:
            return NonlinearityClass.varying_gain(*table.gain, rate=table.rate)
        return NonlinearityClass.constant_gain(*table.gain)
    if table.rate is not None:
        raise InputError("class: rate is given without gain; give gain = [a, b] beside it, whose change it bounds")
    if table.relu:
        if table.sector is not None or table.odd or table.time_varying:
            raise InputError(
                "class: relu is given beside other keys; a ReLU is known but for its slopes, so give relu = true "
                "alone, or with slope = [l, k] for k max(sigma, 0) + l min(sigma, 0)"
            )
        try:
            return NonlinearityClass.relu(*(table.slope or (0, 1)))
        except InputError as error:
            raise InputError(f"class: {error}") from None
    slope = None if table.slope is None else SlopeBounds(*table.slope)
    bounds = table.sector if table.sector is not None else table.slope
    if bounds is None:
        raise InputError("class: neither sector, slope, gain nor relu is given; give one, such as sector = [0, 5.9]")
    try:
        return NonlinearityClass(sector=Sector(*bounds), slope=slope, odd=table.odd, time_varying=table.time_varying)
    except InputError as error:
        raise InputError(f"class: {error}") from None


def _full_block(table: ClassTable, size: tuple[int, int]) -> NonlinearityClass:
    given = [table.slope, table.gain, table.rate]
    plain = table.sector is not None and size[0] == size[1] and table.repeated == 1
    if table.sector is None or not plain or any(one is not None for one in given) or table.odd or table.relu:
        raise InputError(
            "class: size is given without norm, or beside other keys; give norm = r with size for an operator, or "
            "sector = [l, u] with size = n for one function of n channels, and time_varying = true if it may change"
        )
    try:
        return NonlinearityClass.full_block(*table.sector, time_varying=table.time_varying)
    except InputError as error:
        raise InputError(f"class: {error}") from None


TEMPLATES = ("delay", "disturbance", "memory", "operator")


def plant_template(kind: str = "") -> str:
    """The commented TOML file of a plant to start from.

    Parameters
    ----------
    kind : str
        One of ``TEMPLATES``, for a short file about that; by default the one that explains every key.
    """
    parts = ("templates", f"{kind}.toml") if kind else ("plant.toml",)
    return files("lure").joinpath("files", *parts).read_text(encoding="utf-8")


def loop_tables(system: LoopSystem) -> dict[str, object]:
    """The tables of the file that means this loop, numbers as exact fractions.

    Raises
    ------
    InputError
        The block is a matrix in floating point, which no file of a page holds.
    """
    tables: dict[str, object] = {"name": system.name, "title": system.title, "plant": _plant(system)}
    if system.nonlinearity_table is not None:
        tables["nonlinearity"] = dict(system.nonlinearity_table)
    if system.nonlinearity_tables:
        tables["nonlinearity"] = [dict(table) for table in system.nonlinearity_tables]
    if system.nonlinearity_class is not None:
        tables["class"] = _class(system.nonlinearity_class)
    if system.classes is not None:
        alike = [(system.classes.classes[block[0]], len(block)) for block in system.classes.blocks]
        tables["class"] = [
            _class(one) | ({"repeated" if one.operator in ("", SCALAR, *DELAYS) else "size": size} if size > 1 else {})
            for one, size in alike
        ]
    if system.local:
        tables["class"] = [{"sector": (one.lower, one.upper), "on": (-one.radius, one.radius)} for one in system.local]
    if system.performance is not None:
        tables["performance"] = dict(system.performance.stated)
        if system.performance.parameters:
            plant = cast("dict[str, object]", tables["plant"])
            own = {name: [low, high] for name, low, high in system.performance.parameters}
            plant["parameters"] = {**cast("dict[str, object]", plant.get("parameters", {})), **own}
    if system.forcing is not None:
        tables["forcing"] = system.forcing.stated
    if system.ask:
        tables["report"] = {"ask": list(system.ask)}
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
            inner = {name: entry for name, entry in value.items() if isinstance(entry, dict)}
            lines += ["", f"[{key}]", *_entries({name: entry for name, entry in value.items() if name not in inner})]
            lines += [line for name, entry in inner.items() for line in ("", f"[{key}.{name}]", *_entries(entry))]
        elif isinstance(value, list):
            lines += [line for table in value for line in ("", f"[[{key}]]", *_entries(table))]
        else:
            lines.append(f"{key} = {_written(value)}")
    return "\n".join(lines) + "\n"


def _entries(table: Mapping[str, object]) -> list[str]:
    return [f"{name} = {_written(entry)}" for name, entry in table.items()]


def _plant(system: LoopSystem) -> dict[str, object]:
    block = system.block
    if isinstance(block, RationalPlant) and block.matrices is not None and system.performance is not None:
        block = MultivariablePlant.of_one_channel(block)  # its states are meant
    if isinstance(block, MultivariablePlant):
        sides: dict[str, object] = {name: getattr(block, name) for name in "ABCD"}
        return sides if block.dt is None else {**sides, "dt": block.dt}
    if isinstance(block, PlantFamily) and block.states is not None and system.performance is not None:
        block = block.states
    if isinstance(block, PlantFamily | ChannelFamily):
        bounds: dict[str, object] = {name: list(ends) for name, ends in zip(block.names, block.box, strict=True)}
        for name, rate in zip(block.names, block.rates if isinstance(block, ChannelFamily) else (), strict=False):
            if rate:
                bounds[name] = {"between": bounds[name], **({"varying": True} if rate == math.inf else {"rate": rate})}
        step = {} if block.dt is None else {"dt": block.dt}
        if isinstance(block, ChannelFamily):
            return {**block.sides, **step, "parameters": bounds}
        if isinstance(block, PlantFamily) and block.delay:
            return {"transfer": block.formula, "parameters": bounds}
        return {"num": block.sides[0], "den": block.sides[1], **step, "parameters": bounds}
    if isinstance(block, DelayMatrix):
        return {"transfer": block.formulas()}
    if isinstance(block, DelayPlant):
        above, below = (
            [f"({_formula(top)})*exp(-({_text(delay)})*s)" for delay, top in terms]
            for terms in (block.terms, block.feedback)
        )
        return {"transfer": f"({' + '.join(above)})/({' + '.join([_formula(block.denominator), *below])})"}
    if not isinstance(block, RationalPlant):
        raise InputError(f"the {block} is too large for a system file; keep its matrices elsewhere")
    plant: dict[str, object] = {"num": block.numerator, "den": block.denominator}
    return plant if block.dt is None else {**plant, "dt": block.dt}


def _class(asked: NonlinearityClass) -> dict[str, object]:
    if asked.memory:
        return {"memory": asked.memory, "slope": (asked.sector.lower, asked.sector.upper)}
    if asked.operator in DELAYS:
        slow = {} if asked.rate is None else {"rate": asked.rate}
        return {"delay": asked.sector.upper, "time_varying": asked.operator != DELAYS[0], **slow}
    if asked.operator and asked.operator != FULL_BLOCK:
        return {"norm": asked.sector.upper, "dynamics": asked.operator.removeprefix("scalar ")}
    if asked.linear:
        paced = {} if asked.rate is None else {"rate": asked.rate}
        return {"gain": (asked.sector.lower, asked.sector.upper), **paced}
    if asked.rectifier:
        return {"relu": True, "slope": (asked.sector.lower, asked.sector.upper)}
    table: dict[str, object] = {"sector": (asked.sector.lower, asked.sector.upper)}
    if asked.slope is not None:
        table["slope"] = (asked.slope.lower, asked.slope.upper)
    odd = {} if asked.operator else {"odd": asked.odd}
    return table | odd | {"time_varying": asked.time_varying}


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
    if isinstance(value, dict):
        return f"{{ {', '.join(_entries(value))} }}"
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
    texts=(
        "name",
        "title",
        "plant.transfer",
        "controller.network",
        "controller.activation",
        *(f"nonlinearity.{key}" for key in LAW_TEXTS),
    ),
    single=("name", "title"),
    letters={"numerator": "plant.num", "denominator": "plant.den", "H": "plant.transfer", "G": "plant.transfer"}
    | dict.fromkeys(("delay", "dead_time"), 'plant.transfer = "exp(-0.2*s)/(s+1)"'),
    free="nonlinearity",
)
"""Files with a ``[plant]``, and the built-in loops."""

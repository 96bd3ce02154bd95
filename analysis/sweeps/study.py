"""A study: one system, what is varied, what is asked; read from TOML, checked, and split into chunks of points."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lure.errors import InputError
from lure.exact import exact_number
from lure.extensions import extension
from lure.files.reading import SystemSource, system_source
from lure.files.values import exact_decimal, shown, shown_path

QUESTIONS = ("rod", "sector", "slope", "class", "gain", "rate")
# about a second each, and in a large study some seconds
POINTS_IN_A_CHUNK = {"rod": 1000, "sector": 200, "class": 100, "slope": 20, "gain": 20, "rate": 20}
LARGER, ENOUGH_CHUNKS = 5, 200
MOST_POINTS = 100_000_000
SAMPLE = "sample"
_SPACINGS = ("linear", "log")
_KEYS = ("system", "ask", "over", "draw", "chunk")
_MOST_AXES = 8


class Axis(NamedTuple):
    """A key of the system and the values it takes, each as ``--set`` would be given it."""

    key: str
    values: tuple[str, ...]

    @property
    def coordinates(self) -> list[float] | list[str]:
        """The values as numbers, or as they are written where one of them is none."""
        try:
            return [float(value) for value in self.values]
        except ValueError:
            return list(self.values)


class Distribution(NamedTuple):
    """How the values of a key are drawn: between two ends, with evenly spread values or logarithms, or normal."""

    key: str
    kind: str  # "linear", "log" or "normal"
    first: float  # the lower end, or the mean
    second: float  # the upper end, or the standard deviation


@dataclass(frozen=True, kw_only=True)
class Draw:
    """Points drawn at random (``random``) or spread evenly (``sobol``), always the same ones for one seed.

    Attributes
    ----------
    count : int
        How many.
    seed : int
        Of the generator.
    method : str
        ``random`` or ``sobol``.
    """

    count: int
    seed: int = 0
    method: str = "random"


@dataclass(frozen=True, kw_only=True)
class Study:
    """What a sweep is asked: see :func:`read_study` for the file.

    Attributes
    ----------
    system : str
        A built-in system or a TOML file.
    ask : tuple of str
        The questions: ``rod``, ``sector``, ``slope``, ``class``, ``gain``, ``rate``.
    axes : tuple of Axis
        What is varied over a grid; empty where points are drawn.
    distributions : tuple of Distribution
        What is drawn.
    draw : Draw or None
        How many points, and how.
    chunk_points : int
        Points that are computed between two marks; 0 for what takes some seconds.
    folder : Path
        Where the file lies that names the system.
    """

    system: str
    ask: tuple[str, ...]
    axes: tuple[Axis, ...] = ()
    distributions: tuple[Distribution, ...] = ()
    draw: Draw | None = None
    chunk_points: int = 0
    folder: Path = field(default=Path(), compare=False)

    @cached_property
    def source(self) -> SystemSource:
        """The system, read once."""
        return system_source(self.reference)

    @property
    def reference(self) -> str:
        """The system as :func:`lure.files.find_system` takes it."""
        return str(self.folder.absolute() / self.system) if self.system.endswith(".toml") else self.system

    @property
    def keys(self) -> tuple[str, ...]:
        """What is varied."""
        return tuple(each.key for each in self.axes) or tuple(each.key for each in self.distributions)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values along each dimension."""
        return (self.draw.count,) if self.draw is not None else tuple(len(axis.values) for axis in self.axes)

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Their names: the keys, or ``sample`` where points are drawn."""
        return (SAMPLE,) if self.draw is not None else self.keys

    @property
    def points(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    @cached_property
    def chunk(self) -> tuple[int, ...]:
        """The shape of a chunk: the last dimensions whole as long as they fit, then a part of one, then one value."""
        usual = min(POINTS_IN_A_CHUNK[each] for each in self.ask)
        return self.chunks_of(self.chunk_points or min(max(usual, self.points // ENOUGH_CHUNKS), LARGER * usual))

    def chunks_of(self, points: int) -> tuple[int, ...]:
        """The shape of chunks with at most so many points.

        Parameters
        ----------
        points : int
            How many.
        """
        left, sizes = points, []
        for length in reversed(self.shape):
            sizes.append(min(length, max(left, 1)))
            left //= length
        return tuple(reversed(sizes))

    def regions(self, chunk: tuple[int, ...]) -> Iterator[tuple[slice, ...]]:
        """The parts of the whole that such chunks cover.

        Parameters
        ----------
        chunk : tuple of int
            Their shape.
        """
        ranges = [range(0, length, size) for length, size in zip(self.shape, chunk, strict=True)]
        for start in itertools.product(*ranges):
            yield tuple(slice(a, min(a + n, top)) for a, n, top in zip(start, chunk, self.shape, strict=True))

    @property
    def chunks(self) -> int:
        """How many chunks there are."""
        return math.prod(self._blocks)

    @property
    def _blocks(self) -> tuple[int, ...]:
        return tuple(-(-length // size) for length, size in zip(self.shape, self.chunk, strict=True))

    def region(self, number: int) -> tuple[slice, ...]:
        """Where the points of a chunk stand.

        Parameters
        ----------
        number : int
            Of the chunk, from 0.
        """
        places = np.unravel_index(number, self._blocks)
        return tuple(
            slice(int(place) * size, min((int(place) + 1) * size, length))
            for place, size, length in zip(places, self.chunk, self.shape, strict=True)
        )

    def chunk_with(self, place: Sequence[int]) -> int:
        """The number of the chunk that a point is in.

        Parameters
        ----------
        place : sequence of int
            Of the point along each dimension.
        """
        blocks = [i // size for i, size in zip(place, self.chunk, strict=True)]
        return int(np.ravel_multi_index(blocks, self._blocks))

    def size(self, number: int) -> int:
        """How many points a chunk has.

        Parameters
        ----------
        number : int
            Of the chunk.
        """
        return math.prod(part.stop - part.start for part in self.region(number))

    def of_chunk(self, number: int) -> Iterator[list[str]]:
        """What the points of a chunk change, in order.

        Parameters
        ----------
        number : int
            Of the chunk.
        """
        ranges = (range(part.start, part.stop) for part in self.region(number))
        return (self.settings(place) for place in itertools.product(*ranges))

    def settings(self, place: Sequence[int]) -> list[str]:
        """What a point changes, as for ``--set``.

        Parameters
        ----------
        place : sequence of int
            Of the point along each dimension.
        """
        if self.draw is None:
            return [f"{axis.key}={axis.values[i]}" for axis, i in zip(self.axes, place, strict=True)]
        drawn = _drawn(self.draw, self.distributions)
        return [f"{key}={float(drawn[place[0], i])!r}" for i, key in enumerate(self.keys)]

    @property
    def drawn(self) -> Mapping[str, Any]:
        """The values drawn of each key; empty for a grid."""
        if self.draw is None:
            return {}
        values = _drawn(self.draw, self.distributions)
        return {key: values[:, i] for i, key in enumerate(self.keys)}

    @cached_property
    def text(self) -> str:
        """The study as canonical text: the tables of the system as they are, what is varied, what is asked."""
        varied: dict[str, Any] = {"over": [[axis.key, list(axis.values)] for axis in self.axes]}
        if self.draw is not None:
            varied = {"draw": [self.draw.count, self.draw.seed, self.draw.method]}
            varied["over"] = [[each.key, each.kind, repr(each.first), repr(each.second)] for each in self.distributions]
        whole = {
            "system": self.source.tables,
            "name": self.source.name,
            "reference": self.system,
            "ask": self.ask,
            "chunk": self.chunk,
            **varied,
        }
        return json.dumps(whole, sort_keys=True, default=str)

    @cached_property
    def digest(self) -> str:
        """Of the canonical text."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def __str__(self) -> str:
        counts = [(len(axis.values), axis.key) for axis in self.axes]
        varied = " x ".join(f"{count} value{'s' * (count > 1)} of {key}" for count, key in counts)
        if self.draw is not None:
            varied = f"{self.draw.count} points drawn ({self.draw.method}) of {', '.join(self.keys)}"
        return f"{self.system}, asked for {' and '.join(self.ask)}: {varied}"


@lru_cache(maxsize=2)
def _drawn(draw: Draw, distributions: tuple[Distribution, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The points, (count, keys)."""
    from scipy.stats import norm, qmc

    size = len(distributions)
    if draw.method == "sobol":
        with np.errstate(all="ignore"):
            unit = qmc.Sobol(size, seed=draw.seed).random_base2(max(draw.count - 1, 1).bit_length())[: draw.count]
    else:
        unit = np.random.default_rng(draw.seed).random((draw.count, size))
    columns = []
    for u, (_, kind, first, second) in zip(unit.T, distributions, strict=True):
        if kind == "normal":
            columns.append(norm.ppf(np.clip(u, 1e-300, 1 - 1e-16), first, second))
        elif kind == "log":
            columns.append(np.exp((1 - u) * math.log(first) + u * math.log(second)))
        else:
            columns.append((1 - u) * first + u * second)
    return np.stack(columns, axis=1)


# Reading.


def read_study(path: Path) -> Study:
    """The study in a TOML file.

    Parameters
    ----------
    path : Path
        The file: ``system``, ``ask``, a table ``[over]`` and, for points that are drawn, ``[draw]``.

    Raises
    ------
    InputError
        It cannot be read, has unknown keys or wrong values, or its system does not take what is varied.
    """
    label = shown_path(str(path))
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"), parse_float=exact_decimal)
    except FileNotFoundError:
        raise InputError(f"{label} does not exist; give the TOML file of a study, see lure sweep --help") from None
    except IsADirectoryError:
        raise InputError(
            f"{label} is a folder; give the TOML file of a study, or --report for the page of a store"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{label} cannot be read as UTF-8 text ({error}); give a TOML file") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{label} does not parse as TOML: {error}") from None
    return study_of(tables, folder=path.parent)


def study_of(tables: Mapping[str, Any], *, folder: Path = Path()) -> Study:
    """A study from the tables of its file.

    Parameters
    ----------
    tables : Mapping
        ``system``, ``ask``, ``over`` and perhaps ``draw``, as in the file.
    folder : Path
        Where the file of the system lies, if it is one.

    Raises
    ------
    InputError
        As :func:`read_study`.

    Examples
    --------
    >>> study = study_of({"system": "paper-rod", "ask": "rod", "over": {"rod.damping": [1e-4, 2e-4]}})
    >>> print(study)
    paper-rod, asked for rod: 2 values of rod.damping
    """
    unknown = [key for key in tables if key not in _KEYS]
    if unknown:
        raise InputError(f"unknown key {shown(unknown[0])} of a study; it has system, ask, chunk, [over] and [draw]")
    system, over = tables.get("system"), tables.get("over")
    if not isinstance(system, str):
        raise InputError(f"system is {shown(system)}; give a built-in system or the name of a TOML file")
    ask = _asked(tables.get("ask"))
    if not isinstance(over, Mapping) or not over:
        found = "empty" if over == {} else "missing" if over is None else f"{shown(over)}"
        raise InputError(f"over is {found}; give a table [over] with what is varied, such as rod.damping")
    flat = dict(_flat(over))
    if len(flat) > _MOST_AXES:
        raise InputError(f"[over] has {len(flat)} keys; give at most {_MOST_AXES}, or draw points in several studies")
    chunk, drawn = tables.get("chunk", 0), tables.get("draw")
    if isinstance(chunk, bool) or not isinstance(chunk, int) or not 0 <= chunk <= MOST_POINTS:
        raise InputError(
            f"chunk is {shown(chunk)}; give how many points are computed between two marks, or leave it out"
        )
    if drawn is None:
        varied: dict[str, Any] = {"axes": tuple(_axis(*item) for item in flat.items())}
    else:
        varied = {"distributions": tuple(_distribution(*item) for item in flat.items()), "draw": _draw(drawn)}
    study = Study(system=system, ask=ask, chunk_points=chunk, folder=folder, **varied)
    if study.points > MOST_POINTS:
        raise InputError(
            f"the study has {study.points} points; give at most {MOST_POINTS}, in several studies if need be"
        )
    _demand_served(study)
    return study


def _demand_served(study: Study) -> None:
    """Refuse, before anything is computed, keys that the system has not and questions of another kind of system."""
    for key in study.keys:
        study.source.check_key(key)
    kind = study.source.kind.word
    own = extension("sweep", study.source.changed()) is not None
    wrong = [each for each in study.ask if (each == "rod") != own]
    if wrong:
        fit = "'rod'" if own else f"one of {', '.join(each for each in QUESTIONS if each != 'rod')}"
        raise InputError(f"ask is {wrong[0]!r}, and {study.system} is a {kind}; ask {fit}")


def _asked(ask: object) -> tuple[str, ...]:
    asked = [ask] if isinstance(ask, str) else ask
    if not isinstance(asked, list | tuple) or not asked or any(each not in QUESTIONS for each in asked):
        found = "an empty array" if asked == [] else shown(ask)
        raise InputError(f"ask is {found}; give one of {', '.join(QUESTIONS)}, or a list of them")
    if len(set(asked)) < len(asked):
        raise InputError(f"ask is {shown(str(ask))}; give each question once")
    return tuple(asked)


def _flat(over: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """The keys of ``[over]`` with points, whether written in quotation marks or as nested tables."""
    found: list[tuple[str, Any]] = []
    for key, value in over.items():
        name = f"{before}{key}"
        inner = isinstance(value, Mapping) and not set(value) & {"from", "between", "mean"}
        found += _flat(value, f"{name}.") if inner else [(name, value)]
    return found


def _axis(key: str, value: object) -> Axis:
    if isinstance(value, list | tuple):
        if not value:
            raise InputError(f"over.{key} is an empty array; give at least one value")
        written = tuple(_written(each) for each in value)
        if len(set(written)) < len(written):
            raise InputError(f"over.{key} has a value twice; give each once")
        return Axis(key, written)
    if not isinstance(value, Mapping):
        raise InputError(f"over.{key} is {shown(value)}; give an array of values, or {{ from = , to = , count = }}")
    _only(key, value, ("from", "to", "count", "spacing"))
    low, high = (_number(f"over.{key}.{end}", value.get(end)) for end in ("from", "to"))
    count, spacing = value.get("count"), value.get("spacing", "linear")
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InputError(f"over.{key}.count is {shown(count)}; give a whole number of at least 1")
    if (count == 1) != (low == high):
        raise InputError(f"over.{key} has {count} values from {low:g} to {high:g}; give at least 2 for two ends")
    if spacing not in _SPACINGS:
        raise InputError(f"over.{key}.spacing is {shown(spacing)}; give 'linear' or 'log'")
    if count > MOST_POINTS:
        raise InputError(f"over.{key}.count is {count}; give at most {MOST_POINTS}")
    if spacing == "log" and not (low > 0 and high > 0):
        raise InputError(f"over.{key} has spacing 'log' from {low:g} to {high:g}; give positive ends")
    spaced = np.geomspace if spacing == "log" else np.linspace
    return Axis(key, tuple(repr(float(each)) for each in spaced(low, high, count)))


def _distribution(key: str, value: object) -> Distribution:
    if not isinstance(value, Mapping):
        raise InputError(
            f"over.{key} is {shown(value)}; with [draw] give {{ between = [a, b] }} or {{ mean = , deviation = }}"
        )
    if "mean" in value:
        _only(key, value, ("mean", "deviation"))
        mean, deviation = (_number(f"over.{key}.{each}", value.get(each)) for each in ("mean", "deviation"))
        if deviation <= 0:
            raise InputError(f"over.{key}.deviation is {deviation:g}; give a positive standard deviation")
        return Distribution(key, "normal", mean, deviation)
    _only(key, value, ("between", "spacing"))
    pair, spacing = value.get("between"), value.get("spacing", "linear")
    if not isinstance(pair, list | tuple) or len(pair) != 2:
        raise InputError(f"over.{key}.between is {shown(pair)}; give the two ends [a, b]")
    low, high = (_number(f"over.{key}.between", each) for each in pair)
    if spacing not in _SPACINGS or low >= high or (spacing == "log" and low <= 0):
        raise InputError(
            f"over.{key} is drawn between {low:g} and {high:g} with spacing {shown(spacing)}; give the "
            "smaller end first, positive for 'log', and 'linear' or 'log'"
        )
    return Distribution(key, spacing, low, high)


def _draw(value: object) -> Draw:
    if not isinstance(value, Mapping):
        raise InputError(f"draw is {shown(value)}; give a table [draw] with count, and perhaps seed and method")
    unknown = [key for key in value if key not in ("count", "seed", "method")]
    if unknown:
        raise InputError(f"unknown key draw.{shown(unknown[0])[1:-1]}; [draw] has count, seed and method")
    count, seed, method = value.get("count"), value.get("seed", 0), value.get("method", "random")
    for name, number, least in (("count", count, 1), ("seed", seed, 0)):
        if isinstance(number, bool) or not isinstance(number, int) or number < least:
            raise InputError(f"draw.{name} is {shown(number)}; give a whole number of at least {least}")
    if method not in ("random", "sobol"):
        raise InputError(f"draw.method is {shown(method)}; give 'random' or 'sobol'")
    return Draw(count=count, seed=seed, method=method) if isinstance(count, int) else Draw(count=1)


def _only(key: str, value: Mapping[str, Any], known: tuple[str, ...]) -> None:
    unknown = [each for each in value if each not in known]
    if unknown:
        raise InputError(f"unknown key over.{key}.{shown(unknown[0])[1:-1]}; give {', '.join(known)}")


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        raise InputError(f"{name} is {shown(value)}; give a number")
    return float(exact_number(value, name))


def _written(value: object) -> str:
    """A value as ``--set`` takes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(each) if not isinstance(each, str) else json.dumps(each) for each in value)}]"
    return repr(value) if isinstance(value, float) else str(value)

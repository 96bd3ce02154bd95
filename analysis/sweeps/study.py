"""A study: one system, what is varied and what is asked, split into chunks of points."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lure.files.reading import SystemSource, system_source
from lure.record import described, quantity

QUESTIONS = ("rod", "sector", "slope", "class", "gain", "rate", "region")
# about a second each, and in a large study some seconds
POINTS_IN_A_CHUNK = {"rod": 2000, "sector": 200, "class": 100, "slope": 20, "gain": 20, "rate": 20, "region": 4}
LARGER, ENOUGH_CHUNKS, BOXES = 5, 200, 50  # a box costs about as much as so many points
SAMPLE = "sample"


class Axis(NamedTuple):
    """A key of the system and the values it takes, each as ``--set`` would be given it; or the cells it is cut into."""

    key: str
    values: tuple[str, ...]
    edges: tuple[float, ...] = ()
    spacing: str = "linear"

    @property
    def coordinates(self) -> list[float] | list[str]:
        """The values as numbers, of cells their middles; or as they are written where one of them is none."""
        if self.edges:
            return [a + (b - a) / 2 for a, b in pairwise(self.edges)]
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


@described(frozen=True, kw_only=True)
class Draw:
    """Points drawn at random (``random``), spread evenly (``sobol``), or listed; always the same ones for one seed."""

    count: int = quantity("How many")
    seed: int = quantity("Of the generator", default=0)
    method: str = quantity("``random``, ``sobol`` or ``listed``", default="random")
    listed: tuple[tuple[float, ...], ...] = quantity("The points, where they are listed", default=())


@dataclass(frozen=True, kw_only=True)
class Study:
    """What a sweep is asked: see :func:`lure.analysis.sweeps.reading.read_study` for the file.

    Attributes
    ----------
    system : str
        A built-in system or a TOML file.
    ask : tuple of str
        The questions: ``rod``, ``sector``, ``slope``, ``class``, ``gain``, ``rate``, ``region``.
    axes : tuple of Axis
        What is varied over a grid; empty where points are drawn.
    distributions : tuple of Distribution
        What is drawn.
    draw : Draw or None
        How many points, and how.
    chunk_points : int
        Points that are computed between two marks; 0 for what takes some seconds.
    refine : int
        How often the steps of the grid are halved where the verdict changes.
    folder : Path
        Where the file lies that names the system.
    """

    system: str
    ask: tuple[str, ...]
    axes: tuple[Axis, ...] = ()
    distributions: tuple[Distribution, ...] = ()
    draw: Draw | None = None
    chunk_points: int = 0
    refine: int = 0
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
    def boxes(self) -> bool:
        """Whether a point is a box of values."""
        return any(axis.edges for axis in self.axes)

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
        usual = max(min(POINTS_IN_A_CHUNK[each] for each in self.ask) // (BOXES if self.boxes else 1), 1)
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

    @cached_property
    def _blocks(self) -> tuple[int, ...]:
        return tuple(-(-length // size) for length, size in zip(self.shape, self.chunk, strict=True))

    def block(self, number: int) -> tuple[int, ...]:
        """Where a chunk stands among the others, along each dimension.

        Parameters
        ----------
        number : int
            Of the chunk, from 0.
        """
        return tuple(map(int, np.unravel_index(number, self._blocks)))

    def region(self, number: int) -> tuple[slice, ...]:
        """Where the points of a chunk stand.

        Parameters
        ----------
        number : int
            Of the chunk, from 0.
        """
        return tuple(
            slice(place * size, min((place + 1) * size, length))
            for place, size, length in zip(self.block(number), self.chunk, self.shape, strict=True)
        )

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
        region = self.region(number)
        if self.draw is not None:
            return (self.settings((i,)) for i in range(region[0].start, region[0].stop))
        each = (
            [f"{axis.key}={value}" for value in axis.values[part]] for axis, part in zip(self.axes, region, strict=True)
        )
        return (list(settings) for settings in itertools.product(*each))

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
            varied = {"draw": [self.draw.count, self.draw.seed, self.draw.method, self.draw.listed]}
            varied["over"] = [[each.key, each.kind, repr(each.first), repr(each.second)] for each in self.distributions]
        whole = {
            "system": self.source.tables,
            "name": self.source.name,
            "reference": self.system,
            "ask": self.ask,
            "chunk": self.chunk,
            "refine": self.refine,
            **varied,
        }
        return json.dumps(whole, sort_keys=True, default=str)

    @cached_property
    def digest(self) -> str:
        """Of the canonical text."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def __str__(self) -> str:
        counts = [(len(axis.values), axis.key) for axis in self.axes]
        words = [("interval" if axis.edges else "value") + "s" * (len(axis.values) > 1) for axis in self.axes]
        varied = " x ".join(f"{count} {word} of {key}" for (count, key), word in zip(counts, words, strict=True))
        if self.draw is not None:
            how = "where the verdict changes," if self.draw.listed else f"drawn ({self.draw.method})"
            varied = f"{self.draw.count} points {how} of {', '.join(self.keys)}"
        asked = " and ".join(one for one in (", ".join(self.ask[:-1]), self.ask[-1]) if one)
        return f"{self.system}, asked for {asked}: {varied}"


@lru_cache(maxsize=2)
def _drawn(draw: Draw, distributions: tuple[Distribution, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The points, (count, keys)."""
    from scipy.stats import norm, qmc

    size = len(distributions)
    if draw.listed:
        return np.array(draw.listed)
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

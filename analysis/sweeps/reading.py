"""The file of a study: what is varied, drawn or cut into cells, and what is asked, each checked as it is read."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from lure.analysis.sweeps.rows import refusal
from lure.analysis.sweeps.study import QUESTIONS, Axis, Distribution, Draw, Study
from lure.errors import InputError, did_you_mean
from lure.exact import exact_number
from lure.extensions import extension
from lure.files.reading import MAX_BYTES, tables_of
from lure.files.values import shown, shown_path

MOST_POINTS = 100_000_000
BOUNDARY, HALVINGS = "boundary", 5
_SPACINGS = ("linear", "log")
_KEYS = ("system", "ask", "over", "boxes", "draw", "refine", "chunk")
_MOST_AXES, _LONGEST_KEY = 8, 200


def read_study(path: Path) -> Study:
    """The study in a TOML file.

    Parameters
    ----------
    path : Path
        The file: ``system``, ``ask``, tables ``[over]`` and ``[boxes]`` and, for points that are drawn, ``[draw]``.

    Raises
    ------
    InputError
        It cannot be read, has unknown keys or wrong values, or its system does not take what is varied.
    """
    label = shown_path(str(path))
    try:
        if path.exists() and not path.is_dir() and not (path.is_file() and path.stat().st_size <= MAX_BYTES):
            raise InputError(f"{label} is no file of at most {MAX_BYTES // 1024} KiB; a study is a page of text")
        tables = tables_of(path.read_text(encoding="utf-8"), label)
    except FileNotFoundError:
        raise InputError(f"{label} does not exist; give the TOML file of a study, see lure sweep --help") from None
    except IsADirectoryError:
        raise InputError(
            f"{label} is a folder; give the TOML file of a study, or --report for the page of a store"
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{label} cannot be read as UTF-8 text ({reason}); give a TOML file") from None
    return study_of(tables, folder=path.parent)


def study_of(tables: Mapping[str, Any], *, folder: Path = Path()) -> Study:
    """A study from the tables of its file.

    Parameters
    ----------
    tables : Mapping
        ``system``, ``ask``, ``over`` or ``boxes``, and perhaps ``draw`` or ``refine``, as in the file.
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
        if {"plant", "rod", "contact"} & set(unknown):
            raise InputError(
                "this is the file of a system; a study is one more file, which names it, as in system = 'plant.toml', "
                "with ask, and in [over] what is varied (lure sweep --help)"
            )
        raise InputError(
            f"unknown key {shown(unknown[0])} of a study; {did_you_mean(unknown[0], _KEYS)}it has system, ask, chunk, "
            "refine, [over], [boxes] and [draw]"
        )
    system, over, boxes = tables.get("system"), tables.get("over"), tables.get("boxes", {})
    if not isinstance(system, str):
        raise InputError(f"system is {_said(system)}; give a built-in system or the name of a TOML file")
    ask = _asked(tables.get("ask"))
    if not isinstance(boxes, Mapping) or ("boxes" in tables and not boxes):
        raise InputError(f"boxes is {_said(boxes)}; give a table [boxes] with what is cut into cells, or leave it out")
    over = {} if over is None and boxes else over
    if not isinstance(over, Mapping) or not (over or boxes):
        found = "empty" if over == {} else _said(over)
        raise InputError(f"over is {found}; give a table [over] with what is varied, such as rod.damping")
    flat, cut = dict(_flat(over)), dict(_flat(boxes))
    if not (flat or cut):
        raise InputError("the tables in over are empty; give what is varied, such as rod.damping")
    if twice := set(flat) & set(cut):
        raise InputError(f"{min(twice)} is in [over] and in [boxes]; give it once")
    if len(flat) + len(cut) > _MOST_AXES:
        raise InputError(
            f"the study varies {len(flat) + len(cut)} keys; give at most {_MOST_AXES}, or make several studies of it"
        )
    chunk, drawn = tables.get("chunk", 0), tables.get("draw")
    if isinstance(chunk, bool) or not isinstance(chunk, int) or not 0 <= chunk <= MOST_POINTS:
        raise InputError(
            f"chunk is {_said(chunk)}; give how many points are computed between two marks, or leave it out"
        )
    refine = _refinements(tables.get("refine"))
    for other, given in (("[boxes]", cut), ("refine", refine)):
        if drawn is not None and given:
            raise InputError(f"{other} stands beside [draw]; it is for a grid: leave out one of the two")
    if cut and refine:
        raise InputError("refine stands beside [boxes]; it puts points where the verdict of points changes")
    if drawn is None:
        axes = [_axis(*item) for item in flat.items()] + [_cells(*item) for item in cut.items()]
        varied: dict[str, Any] = {"axes": tuple(axes), "refine": refine}
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
    cut = {axis.key for axis in study.axes if axis.edges}
    for key in study.keys:
        study.source.check_key(key, "[boxes]" if key in cut else "[over]")
    if study.boxes:
        try:
            study.source.changed(study.settings((0,) * len(study.shape)))
        except InputError as error:
            raise InputError(f"[boxes] takes what may be an interval, as the parameters of a plant: {error}") from None
    for axis in study.axes:
        _demand_numbers(study, axis)
    words = [axis.key for axis in study.axes if isinstance(axis.coordinates[0], str)]
    if study.refine and words:
        raise InputError(f"refine is given, and {words[0]} is no number: there is nothing between two of its values")
    kind = study.source.kind.word
    own = extension("sweep", study.source.changed()) is not None
    wrong = [each for each in study.ask if (each == "rod") != own]
    if wrong:
        fit = "'rod'" if own else f"one of {', '.join(each for each in QUESTIONS if each != 'rod')}"
        raise InputError(f"ask is {wrong[0]!r}, and {study.system} is a {kind}; ask {fit}")
    if study.boxes:
        _demand_boxes(study)
    loop: Any = study.source.changed()
    if "region" in study.ask and not (loop.local or loop.nonlinearities or loop.nonlinearity):
        raise InputError(f"ask is 'region', and {study.system} has no [nonlinearity]; give it one, or ask 'class'")
    _demand_answers(study)


def _demand_boxes(study: Study) -> None:
    """Refuse cells of what takes a pair, such as a sector, in place of a number: that is no interval of values."""
    for axis in study.axes:
        low, high = axis.edges[:2] or (0.0, 0.0)
        if axis.edges and not _taken(study, f"{axis.key}={low + (high - low) / 2!r}"):
            raise InputError(f"boxes.{axis.key} is no number of {study.system}; give values for it in [over]")


def _demand_answers(study: Study) -> None:
    """Refuse a question that the first, the middle and the last point cannot be asked, all for one reason."""
    ends = [tuple(int(part * (size - 1)) for size in study.shape) for part in (0, 0.5, 1)]
    for question in study.ask:
        said = {refusal(study.source, study.settings(place), question) for place in dict.fromkeys(ends)}
        if len(said) == 1 and (why := said.pop()):
            raise InputError(f"ask is {question!r}, and no point can be asked that: {why}")


def _demand_numbers(study: Study, axis: Axis) -> None:
    """Refuse what is no finite number where the system has a number."""
    given: Any = study.source.tables
    for part in axis.key.split("."):
        given = given.get(part) if isinstance(given, Mapping) else None
    for value in axis.values:
        try:
            wrong = not math.isfinite(float(value))
        except ValueError:
            wrong = isinstance(given, int | float | Decimal) and not _taken(study, f"{axis.key}={value}")
        if wrong:
            fit = "true or false" if isinstance(given, bool) else "a finite number"
            raise InputError(f"over.{axis.key} has {shown(value)}; give {fit}")


def _taken(study: Study, setting: str) -> bool:
    try:
        study.source.changed([setting])
    except InputError:
        return False
    return True


def _asked(ask: object) -> tuple[str, ...]:
    asked = [ask] if isinstance(ask, str) else ask
    if not isinstance(asked, list | tuple) or not asked or any(each not in QUESTIONS for each in asked):
        found = "an empty array" if asked == [] else _said(ask)
        raise InputError(f"ask is {found}; give one of {', '.join(QUESTIONS)}, or a list of them")
    if len(set(asked)) < len(asked):
        raise InputError(f"ask is {_said(str(ask))}; give each question once")
    return tuple(asked)


def _flat(over: Mapping[str, Any], before: str = "") -> list[tuple[str, Any]]:
    """The keys of ``[over]`` with points, whether written in quotation marks or as nested tables."""
    found: list[tuple[str, Any]] = []
    for key, value in over.items():
        name = f"{before}{key}"
        if not name.isprintable() or len(name) > _LONGEST_KEY:
            raise InputError(f"the study varies {shown(name)}, which is no key; give one such as rod.damping")
        inner = isinstance(value, Mapping) and not set(value) & {"from", "between", "mean"}
        found += _flat(value, f"{name}.") if inner else [(name, value)]
    return found


def _refinements(given: object) -> int:
    """How often steps are halved; ``boundary`` stands for several times."""
    if given is None:
        return 0
    if isinstance(given, str) and given == BOUNDARY:
        return HALVINGS
    raise InputError(f"refine is {_said(given)}; give 'boundary', or leave it out")


def _cells(key: str, value: object) -> Axis:
    """The cells between edges that are listed or evenly spread."""
    if isinstance(value, list | tuple):
        edges = [_number(f"boxes.{key}", each) for each in value]
        spacing = "linear"
        if len(edges) < 2 or any(a >= b for a, b in pairwise(edges)):
            raise InputError(
                f"boxes.{key} is {_said(str(value))}; give the edges of the cells, at least two, ascending"
            )
    else:
        axis = _axis(key, value, table="boxes", more=1)
        edges, spacing = [float(each) for each in axis.values], axis.spacing
        if edges[0] > edges[-1]:
            raise InputError(f"boxes.{key} goes from {edges[0]:g} down to {edges[-1]:g}; give the smaller end first")
    cells = tuple(f"[{a!r}, {b!r}]" for a, b in pairwise(edges))
    return Axis(key, cells, tuple(edges), spacing)


def _axis(key: str, value: object, *, table: str = "over", more: int = 0) -> Axis:
    """The values of a key; with ``more`` so many beside those counted."""
    if isinstance(value, list | tuple):
        if not value:
            raise InputError(f"{table}.{key} is an empty array; give at least one value")
        written = tuple(_written(each) for each in value)
        if len(set(written)) < len(written):
            raise InputError(f"{table}.{key} has a value twice; give each once")
        return Axis(key, written)
    if not isinstance(value, Mapping):
        raise InputError(f"{table}.{key} is {_said(value)}; give an array of values, or {{ from = , to = , count = }}")
    _only(f"{table}.{key}", value, ("from", "to", "count", "spacing"))
    low, high = (_number(f"{table}.{key}.{end}", value.get(end)) for end in ("from", "to"))
    count, spacing = value.get("count"), value.get("spacing", "linear")
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InputError(f"{table}.{key}.count is {_said(count)}; give a whole number of at least 1")
    if (count + more == 1) != (low == high):
        fit = "two ends that differ" if low == high else "at least 2"
        raise InputError(f"{table}.{key} has the count {count} from {low:g} to {high:g}; give {fit}")
    if spacing not in _SPACINGS:
        raise InputError(f"{table}.{key}.spacing is {_said(spacing)}; give 'linear' or 'log'")
    if count > MOST_POINTS:
        raise InputError(f"{table}.{key}.count is {count}; give at most {MOST_POINTS}")
    if spacing == "log" and not (low > 0 and high > 0):
        raise InputError(f"{table}.{key} has spacing 'log' from {low:g} to {high:g}; give positive ends")
    spaced = np.geomspace(low, high, count + more).tolist() if spacing == "log" else _even(low, high, count + more)
    return Axis(key, tuple(map(repr, spaced)), spacing=spacing)


def _even(low: float, high: float, count: int) -> list[float]:
    """Evenly spread values between the decimals that two numbers are written as, each the double next to it.

    So a grid from -0.1 to 0.2 holds 0, where steps of doubles give 1.4e-17, which another verdict may be about.
    """
    first, second, steps = Fraction(repr(low)), Fraction(repr(high)), max(count - 1, 1)
    whole = math.lcm(first.denominator, second.denominator)
    a, b = int(first * whole), int(second * whole)
    return [(a * (steps - i) + b * i) / (whole * steps) for i in range(count)]


def _distribution(key: str, value: object) -> Distribution:
    if not isinstance(value, Mapping):
        raise InputError(
            f"over.{key} is {_said(value)}; with [draw] give {{ between = [a, b] }} or {{ mean = , deviation = }}"
        )
    if "mean" in value:
        _only(f"over.{key}", value, ("mean", "deviation"))
        mean, deviation = (_number(f"over.{key}.{each}", value.get(each)) for each in ("mean", "deviation"))
        if deviation <= 0:
            raise InputError(f"over.{key}.deviation is {deviation:g}; give a positive standard deviation")
        return Distribution(key, "normal", mean, deviation)
    _only(f"over.{key}", value, ("between", "spacing"))
    pair, spacing = value.get("between"), value.get("spacing", "linear")
    if not isinstance(pair, list | tuple) or len(pair) != 2:
        raise InputError(f"over.{key}.between is {_said(pair)}; give the two ends [a, b]")
    low, high = (_number(f"over.{key}.between", each) for each in pair)
    if spacing not in _SPACINGS or low >= high or (spacing == "log" and low <= 0):
        raise InputError(
            f"over.{key} is drawn between {low:g} and {high:g} with spacing {shown(spacing)}; give the "
            "smaller end first, positive for 'log', and 'linear' or 'log'"
        )
    return Distribution(key, spacing, low, high)


def _draw(value: object) -> Draw:
    if not isinstance(value, Mapping):
        raise InputError(f"draw is {_said(value)}; give a table [draw] with count, and perhaps seed and method")
    unknown = [key for key in value if key not in ("count", "seed", "method")]
    if unknown:
        hint = did_you_mean(unknown[0], ("count", "seed", "method"))
        raise InputError(f"unknown key draw.{shown(unknown[0])[1:-1]}; {hint}[draw] has count, seed and method")
    count, seed, method = value.get("count"), value.get("seed", 0), value.get("method", "random")
    for name, number, least in (("count", count, 1), ("seed", seed, 0)):
        if isinstance(number, bool) or not isinstance(number, int) or number < least:
            raise InputError(f"draw.{name} is {_said(number)}; give a whole number of at least {least}")
    if method not in ("random", "sobol"):
        raise InputError(f"draw.method is {_said(method)}; give 'random' or 'sobol'")
    return Draw(count=count, seed=seed, method=method) if isinstance(count, int) else Draw(count=1)


def _said(value: object) -> str:
    """A value in a sentence; TOML has none that means nothing, so that one is missing."""
    return "missing" if value is None else shown(value)


def _only(key: str, value: Mapping[str, Any], known: tuple[str, ...]) -> None:
    unknown = [each for each in value if each not in known]
    if unknown:
        hint = did_you_mean(unknown[0], known)
        raise InputError(f"unknown key {key}.{shown(unknown[0])[1:-1]}; {hint}give {', '.join(known)}")


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | Decimal):
        raise InputError(f"{name} is {_said(value)}; give a number")
    return float(exact_number(value, name))


def _written(value: object) -> str:
    """A value as ``--set`` takes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(each) if not isinstance(each, str) else json.dumps(each) for each in value)}]"
    return repr(value) if isinstance(value, float) else str(value)

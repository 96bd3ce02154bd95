"""The page of a sweep: how many points are proved, maps of the verdict and of numbers, and the points to look at."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lure.analysis.plots import Draw, render
from lure.analysis.plots.studies import LOOKS, Plane, drawn_keys, planes, values_drawn, verdicts_drawn
from lure.analysis.report.html import glyphs, inline, template
from lure.analysis.report.parts import Figure, FigureSpec
from lure.analysis.sweeps.run import opened
from lure.errors import InputError
from lure.files.values import shown_path

if TYPE_CHECKING:
    import xarray

_LISTED = 12
_VALUES = ("largest_low", "slowest_decay", "low", "high", "margin")


def page_of(path: Path) -> str:
    """The page of a store, as HTML.

    Parameters
    ----------
    path : Path
        The store.

    Raises
    ------
    InputError
        It is no sweep of lure.
    """
    known = path / ".lure" / "study.json"
    if not known.is_file():
        raise InputError(f"{shown_path(str(path))} is no sweep of lure; give the store that lure sweep wrote")
    study, data = json.loads(json.loads(known.read_text(encoding="utf-8"))["text"]), opened(path)
    verdicts, errors = data["verdict"].values.ravel(), data["error"].values.ravel()
    counts = [(name, int((verdicts == name).sum())) for name, _, _ in LOOKS]
    seconds = np.asarray(data["seconds"].values, dtype=float)
    figures = tuple(_figures(data))
    return template("sweep.html.j2", "lure.analysis.sweeps").render(
        attributes=data.attrs,
        system=study["name"],
        counts=counts,
        failed=int((errors != "").sum()),
        open=int(((verdicts == "") & (errors == "")).sum()),
        seconds=float(np.nansum(seconds)),
        each=float(np.nanmedian(seconds)) * 1e3 if np.isfinite(seconds).any() else math.nan,
        glyphs=glyphs(figures),
        figures=[(figure.spec, inline(figure)) for figure in figures],
        points=list(_to_look_at(data, study["reference"])),
    )


def _figures(data: xarray.Dataset) -> Iterator[Figure]:
    for number, plane in enumerate(planes(data)):
        yield _figure(f"verdicts-{number}", "Verdicts", plane, partial(verdicts_drawn, plane))
        for name in _VALUES:
            if name in plane.data and len(np.unique(_finite(plane.data[name]))) > 1:
                title = str(plane.data[name].attrs["long_name"])
                yield _figure(f"{name}-{number}", title, plane, partial(values_drawn, plane, name))


def _finite(values: xarray.DataArray) -> np.ndarray[Any, Any]:
    numbers = np.asarray(values.values, dtype=float)
    finite: np.ndarray[Any, Any] = numbers[np.isfinite(numbers)]
    return finite


def _figure(name: str, title: str, plane: Plane, draw: Draw) -> Figure:
    spec = FigureSpec(name=name, section="criteria", title=title, caption=plane.cut, draw=draw)
    return Figure(spec=spec, picture=render(draw, name=name))


class Point(NamedTuple):
    """A point to look at: why, where, and the command for its own report."""

    why: str
    where: str
    command: str


def _to_look_at(data: xarray.Dataset, system: str) -> Iterator[Point]:
    """Points that failed, are open or refuted, and those with the least proved, a few of each."""
    verdict, error = data["verdict"], data["error"].values
    dims = list(verdict.dims)
    kinds = [("failed", error != ""), *((name.lower(), verdict.values == name) for name in ("REFUTED", "INCONCLUSIVE"))]
    for why, chosen in kinds:
        for place in np.argwhere(chosen)[: _LISTED // 3]:
            yield _point(data, dims, place, why, system)
    if "largest_low" in data:
        least = np.where(verdict.values == "PROVED", data["largest_low"].values, np.inf)
        place = np.unravel_index(int(np.argmin(least)), least.shape)
        if np.isfinite(least[place]):
            yield _point(data, dims, np.array(place), "least proved", system)


def _point(data: xarray.Dataset, dims: Sequence[Any], place: np.ndarray[Any, Any], why: str, system: str) -> Point:
    at = {str(name): int(i) for name, i in zip(dims, place, strict=True)}
    keys = drawn_keys(data) or [name for name in at if name != "question"]
    values = [data[key].values[at.get(key, at.get("sample", 0))] for key in keys]
    settings = [f"{key}={value}" for key, value in zip(keys, values, strict=True)]
    command = " ".join(["lure report", shlex.quote(system), *(f"--set {shlex.quote(each)}" for each in settings)])
    said = data["error"].values[tuple(place)]
    return Point(f"{why}: {said}" if said else why, ", ".join(settings), command)

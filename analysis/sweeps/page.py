"""The page of a sweep: how many points are proved, maps of the verdict and of numbers, and the points to look at."""

from __future__ import annotations

import json
import math
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lure.analysis.plots import Draw, render
from lure.analysis.plots.studies import (
    LOOKS,
    Plane,
    covered,
    criteria_drawn,
    curve,
    drawn_keys,
    planes,
    values_drawn,
    verdicts_drawn,
)
from lure.analysis.report.html import glyphs, inline, template
from lure.analysis.report.parts import Figure, FigureSpec
from lure.analysis.sweeps.boundary import stores
from lure.analysis.sweeps.rows import variables
from lure.analysis.sweeps.run import opened
from lure.analysis.sweeps.store import check_files
from lure.errors import InputError
from lure.files.values import shown_path

if TYPE_CHECKING:
    import xarray

_LISTED = 4
_VALUES = ("largest_low", "slowest_decay", "scheme_slowest_decay", "low", "high")


def page_of(path: Path, reports: Callable[[int, str, Sequence[str]], str] | None = None) -> str:
    """The page of a store, as HTML.

    Parameters
    ----------
    path : Path
        The store.
    reports : callable, optional
        Called as ``reports(number, system, settings)`` for each point that is listed; writes its own report and returns
        the link to it, empty if there is none.

    Raises
    ------
    InputError
        It is no sweep of lure.
    """
    known = path / ".lure" / "study.json"
    if not known.is_file():
        beside = path.with_suffix(".zarr")
        there = f"{shown_path(str(beside))}, " if beside != path and (beside / ".lure" / "study.json").is_file() else ""
        raise InputError(f"{shown_path(str(path))} is no sweep of lure; give {there}the store that lure sweep wrote")
    kept = json.loads(known.read_text(encoding="utf-8"))
    study = json.loads(kept["text"])
    check_files(path, variables(study["ask"]))
    data = opened(path)
    points = list(_to_look_at(data, study))
    links = ["" if reports is None else reports(i, kept["reference"], one.settings) for i, one in enumerate(points, 1)]
    verdicts, errors = data["verdict"].values.ravel(), data["error"].values.ravel()
    counts = [(name, int((verdicts == name).sum())) for name, _, _ in LOOKS]
    seconds = np.asarray(data["seconds"].values, dtype=float)
    figures = tuple(_figures(data, [opened(each) for each in stores(path)]))
    return template("sweep.html.j2", "lure.analysis.sweeps").render(
        attributes=data.attrs,
        system=study["name"],
        counts=counts,
        failed=int((errors != "").sum()),
        answers=errors.size,
        open=int(((verdicts == "") & (errors == "")).sum()),
        seconds=float(np.nansum(seconds)),
        slowest=float(np.nanmax(seconds)) if np.isfinite(seconds).any() else math.nan,
        questions=_by_question(data),
        repeated=_repeated(path),
        each=float(np.nanmedian(seconds)) if np.isfinite(seconds).any() else math.nan,
        glyphs=glyphs(figures),
        figures=[(figure.spec, inline(figure)) for figure in figures],
        points=list(zip(points, links, strict=True)),
    )


def _by_question(data: xarray.Dataset) -> list[tuple[str, list[tuple[str, int]]]]:
    """Of each question how many answers have which verdict and which criterion; empty where one question is asked."""
    found = []
    for question in data["question"].values if "question" in data.dims else [None]:
        part = data if question is None else data.sel(question=question)
        verdict, error = part["verdict"].values.ravel(), part["error"].values.ravel()
        criteria = Counter(map(str, part["criterion"].values.ravel()[verdict == "PROVED"]))
        rows = [(name, int((verdict == name).sum())) for name, _, _ in LOOKS]
        rows[1:1] = [(f"by {name}", count) for name, count in criteria.most_common() if name]
        rows.append(("failed", int((error != "").sum())))
        found.append(("" if question is None else str(question), [row for row in rows if row[1]]))
    return found


def _repeated(path: Path) -> int:
    begun = path / ".lure" / "begun"
    numbers = begun.read_text(encoding="ascii").split() if begun.is_file() else []
    return len(numbers) - len(set(numbers))


def _figures(data: xarray.Dataset, more: Sequence[xarray.Dataset]) -> Iterator[Figure]:
    asked: set[str] = set()
    for number, plane in enumerate(planes(data)):
        question = str(plane.data["question"].values) if "question" in plane.data.coords else ""
        first, two = question not in asked, len(plane.along) == 2
        told = variables((question,)) if question else {}
        asked.add(question)
        if not (plane.data["verdict"].values != "").any():
            continue
        changes = first and len(set(map(str, plane.data["verdict"].values.ravel()))) > 1
        over = [each if not question else each.sel(question=question) for each in more] if changes else []
        yield _figure(f"verdicts-{number}", "Verdicts", plane, partial(verdicts_drawn, plane, over))
        if two and len(set(map(str, plane.data["criterion"].values[plane.data["verdict"].values == "PROVED"]))) > 1:
            yield _figure(f"criteria-{number}", "Criterion of what is proved", plane, partial(criteria_drawn, plane))
        for name in _VALUES if first else _VALUES[:1]:
            if name in plane.data and len(np.unique(_finite(plane.data[name]))) > 1:
                if name in told:  # of this question alone, where the store has several
                    plane.data[name].attrs |= {"long_name": told[name].text, "units": told[name].unit}
                title = str(plane.data[name].attrs["long_name"])
                yield _figure(f"{name}-{number}", title, plane, partial(values_drawn, plane, name))
                if first and two and len(np.unique(_finite(curve(plane).data[name]))) > 1:
                    cut = curve(plane)
                    yield _figure(f"{name}-curve-{number}", f"{title}, a slice", cut, partial(values_drawn, cut, name))


def _finite(values: xarray.DataArray) -> np.ndarray[Any, Any]:
    numbers = np.asarray(values.values, dtype=float)
    finite: np.ndarray[Any, Any] = numbers[np.isfinite(numbers)]
    return finite


def _figure(name: str, title: str, plane: Plane, draw: Draw) -> Figure:
    spec = FigureSpec(
        name=name,
        section="criteria",
        title=title,
        caption=". ".join(filter(None, (plane.cut, covered(plane)))),
        draw=draw,
    )
    return Figure(spec=spec, picture=render(draw, name=name))


class Point(NamedTuple):
    """A point to look at: why, where, and the command for its own report."""

    why: str
    settings: tuple[str, ...]
    command: str

    @property
    def where(self) -> str:
        """What the point changes."""
        return ", ".join(self.settings)


_WORST = ("largest_low", "slowest_decay", "low")  # the less, the worse


def _to_look_at(data: xarray.Dataset, study: Mapping[str, Any]) -> Iterator[Point]:
    """Points that failed, are open or refuted, those with the least proved, and those that took longest: a few of each.

    Of many that are alike the first, the last and some between.
    """
    verdict, error = data["verdict"], data["error"].values
    kinds = [("failed", error != ""), *((name.lower(), verdict.values == name) for name in ("REFUTED", "INCONCLUSIVE"))]
    for why, chosen in kinds:
        places = np.flatnonzero(chosen)
        few = places[np.unique(np.linspace(0, len(places) - 1, min(len(places), _LISTED)).astype(int))]
        yield from dict.fromkeys(_point(data, int(place), why, study) for place in few)  # one for all its questions
    proved = verdict.values.ravel() == "PROVED"
    for name in _WORST:
        if name in data:
            least = np.where(proved, np.asarray(data[name].values, dtype=float).ravel(), np.inf)
            place = int(np.nanargmin(least)) if not np.isnan(least).all() else 0
            if np.isfinite(least[place]):
                words, unit = data[name].attrs["long_name"].partition(";")[0], data[name].attrs["units"]
                value = f"{least[place]:.6g}{'' if unit == '1' else f' {unit}'}"
                yield _point(data, place, f"PROVED, the least of all, {value}: {words}", study)
    seconds = np.asarray(data["seconds"].values, dtype=float).ravel()
    if np.isfinite(seconds).any():
        place = int(np.nanargmax(seconds))
        yield _point(data, place, f"took longest, {seconds[place]:.3g} s", study)


def _point(data: xarray.Dataset, flat: int, why: str, study: Mapping[str, Any]) -> Point:
    verdict, system = data["verdict"], study["reference"]
    written = {} if "draw" in study else dict(study["over"])  # values as --set takes them, of cells both ends
    place = np.unravel_index(flat, verdict.shape)
    at = {str(name): int(i) for name, i in zip(verdict.dims, place, strict=True)}
    keys = drawn_keys(data) or [name for name in at if name != "question"]
    settings = tuple(
        f"{key}={written[key][at[key]] if key in written else data[key].values[at['sample']]}" for key in keys
    )
    command = " ".join(["lure report", shlex.quote(system), *(f"--set {shlex.quote(each)}" for each in settings)])
    said = str(data["error"].values[place])
    code = str(data["code"].values[place])
    why += f" ({code})" if code and not said else ""
    return Point(f"{why}: {said}" if said else why, settings, command)

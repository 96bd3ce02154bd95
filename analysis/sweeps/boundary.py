"""Points where the verdict changes: the step between two neighbours of a grid that differ, halved again and again."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lure.analysis.sweeps.store import Store
from lure.analysis.sweeps.study import Distribution, Draw, Study

FOLDER = "boundary"  # of the store, with a store for each time that the steps were halved


class Step(NamedTuple):
    """Two points that differ in one value, and in the verdict."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    axis: int
    verdict: tuple[str, ...]  # at the low end, of each question

    def middle(self, spacing: str) -> tuple[float, ...]:
        """The point between, in the scale of the axis."""
        a, b = self.low[self.axis], self.high[self.axis]
        between = math.copysign(math.sqrt(a * b), a) if spacing == "log" and a * b > 0 else a + (b - a) / 2
        return (*self.low[: self.axis], between, *self.low[self.axis + 1 :])


def steps(store: Store) -> list[Step]:
    """The steps of a grid across which the verdict changes; ``store``: of a study over numbers, done."""
    study = store.study
    verdicts = _verdicts(store)
    values = [[float(each) for each in axis.coordinates] for axis in study.axes]
    found = []
    for axis in range(len(study.axes)):
        after, before = (np.moveaxis(verdicts, axis, 0)[cut] for cut in (slice(1, None), slice(None, -1)))
        for place in np.argwhere(np.moveaxis((after != before).any(axis=-1), 0, axis)).tolist():
            low, high = (tuple(values[i][j + (i == axis) * more] for i, j in enumerate(place)) for more in (0, 1))
            found.append(Step(low, high, axis, tuple(verdicts[tuple(place)])))
    return found


def halved(store: Store) -> Iterator[Store]:
    """The stores of the points halfway, one for each time that the steps are halved; each is to be done at the next.

    ``store``: of the grid, done.
    """
    study = store.study
    left = steps(store) if study.refine else []
    spacings = [axis.spacing for axis in study.axes]
    for time in range(1, study.refine + 1):
        points = [step.middle(spacings[step.axis]) for step in left]
        if not points:
            return
        between = Store(store.path / FOLDER / str(time), _listed(study, tuple(points)))
        yield between
        verdicts = _verdicts(between)
        left = [
            step._replace(low=point) if tuple(verdict) == step.verdict else step._replace(high=point)
            for step, point, verdict in zip(left, points, verdicts, strict=True)
        ]


def stores(path: Path) -> list[Path]:
    """The stores of the points that were put where the verdict changes; ``path``: the store of the grid."""
    folder = path / FOLDER
    return sorted(folder.iterdir(), key=lambda each: int(each.name)) if folder.is_dir() else []


def _listed(study: Study, points: tuple[tuple[float, ...], ...]) -> Study:
    """The same questions for listed points."""
    distributions = tuple(Distribution(axis.key, "listed", 0.0, 0.0) for axis in study.axes)
    draw = Draw(count=len(points), method="listed", listed=points)
    return replace(study, axes=(), distributions=distributions, draw=draw, refine=0)


def _verdicts(store: Store) -> np.ndarray[Any, Any]:
    """The verdict of every point to each question, (*shape of the study, questions)."""
    study = store.study
    return store.values("verdict").astype("U12").reshape(*study.shape, len(study.ask))

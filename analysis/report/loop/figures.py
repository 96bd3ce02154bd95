"""The figures of a report on a loop."""

from __future__ import annotations

import math
from functools import partial

from analysis.answers import Largest
from analysis.answers.text import class_name
from analysis.evidence import Verdict
from analysis.plots import render
from analysis.plots.loops import plot_loop_nyquist, plot_loop_popov, plot_reach
from analysis.plots.orbits import plot_law
from analysis.report.figures import Figure, FigureSpec
from analysis.report.loop.model import LoopReport

_REACH = (
    "Blue: proved for every law of the class. Hatched: unknown. Cross: the smallest class found with a law that "
    "destabilises the loop; larger classes contain it too."
)
_NYQUIST = (
    "The curve stays out of the shaded half-plane, which belongs to the largest sector the circle criterion proves."
)
_NYQUIST_ENDLESS = (
    "The curve does not enter the left half-plane, so that the circle criterion reaches every finite sector."
)
_POPOV = (
    "The curve stays to the right of the line of slope 1/θ through −1/κ, which belongs to the largest sector proved."
)
_POPOV_ENDLESS = (
    "The curve does not cross the line of slope 1/θ through 0, so that the multiplier serves every finite sector."
)
_LAW = "A law for which the loop has a motion that repeats for ever.{}"


def loop_figures(report: LoopReport) -> tuple[Figure, ...]:
    """Draw every figure of a report on a loop.

    Parameters
    ----------
    report : LoopReport
        The report.
    """
    rows, block = report.analysis.rows, report.analysis.subject.block
    names = [class_name(row) for row in rows]
    specs = [
        FigureSpec(
            name="reach",
            section="frequency",
            title="How far each class is known",
            caption=_REACH,
            draw=partial(plot_reach, rows, names),
        )
    ]
    circle, popov = _reach(rows, "circle"), _reach(rows, "popov")
    if circle is not None:
        draw = partial(plot_loop_nyquist, block, circle[0])
        caption = _NYQUIST_ENDLESS if circle[0] == math.inf else _NYQUIST
        specs.append(FigureSpec(name="nyquist", section="frequency", title="Nyquist plot", caption=caption, draw=draw))
    if popov is not None:
        draw_popov = partial(plot_loop_popov, block, popov[0], popov[1])
        caption = _POPOV_ENDLESS if popov[0] == math.inf else _POPOV
        specs.append(
            FigureSpec(name="popov", section="frequency", title="Popov plot", caption=caption, draw=draw_popov)
        )
    drawn: list[str] = []
    for row, name in zip(rows, names, strict=True):
        witness = row.witness
        if witness is None or witness.kind != "periodic orbit" or "points" not in witness.data:
            continue
        if witness.description in drawn:
            continue
        drawn.append(witness.description)
        visits = " It visits the marked points." if "sigma" in witness.data else " It sweeps over the thick part."
        specs.append(
            FigureSpec(
                name=f"law-{len(drawn)}",
                section="frequency",
                title=f"Counterexample, {name}: {witness.description.partition(': ')[2] or witness.kind}",
                caption=_LAW.format(visits),
                draw=partial(plot_law, witness),
            )
        )
    return tuple(Figure(spec=spec, picture=render(spec.draw, name=spec.name)) for spec in specs)


def _reach(rows: tuple[Largest, ...], criterion: str) -> tuple[float, float] | None:
    """The largest ``k`` from 0 that a criterion proves, and its multiplier."""
    for row in rows:
        for answer in row.answers:
            proved = answer.verdict is Verdict.PROVED and answer.criterion == criterion and row.lower == 0
            if proved and answer.largest.low > 0:
                k = answer.largest.low if math.isfinite(answer.largest.low) else math.inf
                return k, answer.theta or 0.0
    return None

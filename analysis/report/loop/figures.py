"""The figures of a report on a loop."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from functools import partial

import numpy as np

from lure.analysis.graphical.axis import axis_values, continuous, drawable
from lure.analysis.graphical.nyquist import NyquistResponse
from lure.analysis.graphical.popov import PopovResponse
from lure.analysis.graphical.supporting_proof import searched_theta
from lure.analysis.inequality.state_space import shifted_states
from lure.analysis.plots import render
from lure.analysis.plots.loops import plot_channels, plot_largest, plot_nonlinearity, plot_orbit_signals, plot_solutions
from lure.analysis.plots.responses import plot_nyquist_response, plot_popov_response
from lure.analysis.questions import StabilityBound
from lure.analysis.questions.problem import Plant
from lure.analysis.report.loop.asked import pictures
from lure.analysis.report.loop.model import LoopReport
from lure.analysis.report.parts import Figure, FigureSpec
from lure.analysis.verdict import Verdict, Witness
from lure.loop import shifted_block
from lure.plants.family import PlantFamily
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

_LARGEST = (
    "Blue: proved for every member of the class. Hatched: unknown. Cross: the smallest class found with a member that "
    "destabilises the loop; larger classes contain it too."
)
_MAP = (
    "A proof for one pair of upper bounds holds for every smaller one, and a counterexample for every larger one: both "
    "regions are unions of rectangles. Hatched: unknown. The lower bounds stay."
)
_PROVED = "The largest sector that {} proves: the curve stays {}."
_NEEDED = "{} proves nothing here. For the sector [{:g}, {}] the curve would have to stay {}, and it does not."
_CLEAR = (
    "{} proves nothing here, though the drawn curve keeps to its side: the poles of H count too, and every frequency."
)
_SHIFTED = " Drawn for H/(1 + {0:g} H) and φ(σ) − {0:g} σ, the same loop."
_MIDDLE = " Of the plant in the middle of the intervals alone."
_SEEN = "Simulated with {}: observed, no proof. Each curve is divided by its largest |σ|; the whole run is longer."
_CHANNELS = "Simulated with {}: observed, no proof. This solution {} within {:.4g} {}; here is its beginning."
_LAW = "The nonlinearity φ of the counterexample.{}"
_ORBIT = "One period of the solution with that φ: it repeats for ever."

Line = tuple[float, float | None, bool]
"""Upper end of a sector, multiplier [s], and whether the criterion proves the sector."""


def loop_figures(report: LoopReport) -> tuple[Figure, ...]:
    """Draw every figure of a report on a loop."""
    rows, block = report.analysis.rows, report.analysis.problem.plant
    largest = FigureSpec(
        name="largest",
        section="frequency",
        title="How far each class is known",
        caption=_LARGEST,
        draw=partial(plot_largest, rows, [row.class_name for row in rows]),
    )
    if report.analysis.problem.several:
        specs = [*_map(report), largest, *_channels(report)]
    else:
        specs = [largest, _nyquist(report), *_popov(report), *_response(report), *_counterexamples(block, rows)]
    whole = [*pictures(report.asked), *specs, *report.beyond_figures]
    return tuple(Figure(spec=spec, picture=render(spec.draw, name=spec.name)) for spec in whole)


def _map(report: LoopReport) -> Iterator[FigureSpec]:
    """With two channels, the plane of their upper bounds."""
    found = report.analysis.map
    if found is not None and (found.proved or found.refuted):
        title = "The upper bounds k₁ and k₂ of the two channels"
        yield FigureSpec(name="map", section="frequency", title=title, caption=_MAP, draw=found.plot)


def _channels(report: LoopReport) -> Iterator[FigureSpec]:
    """The first of the simulated solutions, channel by channel, and one that did something else."""
    runs = [one for one in report.trajectories if one.t[-1] > 0]
    others = [one for one in runs[1:] if one.finding is not runs[0].finding]
    for number, one in enumerate([*runs[:1], *others[:1]], 1):
        yield FigureSpec(
            name=f"channels-{number}",
            section="frequency",
            title=f"Response of the channels, from {one.start}",
            caption=_CHANNELS.format(one.nonlinearity or "the given φᵢ", one.finding, one.until, one.unit),
            draw=partial(plot_channels, one),
        )


def _nyquist(report: LoopReport) -> FigureSpec:
    block = drawable(report.analysis.problem.block)
    lower, (k, _, proved) = _lower(report), _line(report, "circle")
    omega, values = axis_values(block, None)
    seen = NyquistResponse(
        block=block, omega=omega, values=values, lower=lower, k=k, found=None, answer=None, reason="a drawing"
    )
    where = "out of the shaded half-plane" if lower == 0 else "inside the disc" if seen.inside else "out of the disc"
    where += " and goes round it as often as H has unstable poles" if lower > 0 else ""
    caption = _caption("the circle criterion", where, (lower, k), seen, proved=proved) + _middle(report)
    draw = partial(plot_nyquist_response, seen)
    return FigureSpec(name="nyquist", section="frequency", title="Nyquist plot", caption=caption, draw=draw)


def _popov(report: LoopReport) -> Iterator[FigureSpec]:
    """In continuous time, with the lower end of the class moved into the block."""
    block, lower = drawable(report.analysis.problem.block), _lower(report)
    if not continuous(block):
        return
    k, theta, proved = _line(report, "popov")
    drawn = block
    if lower and isinstance(block, RationalPlant):
        drawn = shifted_block(block, Fraction(lower))
    elif lower and isinstance(block, StateSpace):
        drawn = shifted_states(block, Fraction(lower))
    omega, values = axis_values(drawn, None)
    x, y = values.real, omega * values.imag
    if theta is None:  # nothing is proved, or of many plants, with a multiplier each
        seen = np.isfinite(x) & np.isfinite(y)
        seen &= np.abs(x) <= 50 * float(np.median(np.abs(x[seen])))  # not where the curve runs off at a pole
        theta = searched_theta(x[seen], y[seen], k - lower)
    line = PopovResponse(
        block=drawn, omega=omega, values=values, k=k - lower, theta=theta, found=None, answer=None, reason="a drawing"
    )
    where = "to the right of the line" if proved else "to the right of a line through −1/k such as this one"
    caption = _caption("Popov's criterion", where, (lower, k), line, proved=proved) + (
        _SHIFTED.format(lower) if lower else ""
    )
    caption += _middle(report)
    draw = partial(plot_popov_response, line)
    yield FigureSpec(name="popov", section="frequency", title="Popov plot", caption=caption, draw=draw)


def _caption(
    criterion: str, where: str, sector: tuple[float, float], seen: NyquistResponse | PopovResponse, *, proved: bool
) -> str:
    if proved:
        return _PROVED.format(criterion, where)
    begin, (lower, k) = criterion[0].upper() + criterion[1:], sector
    if seen.margin_seen is not None and seen.margin_seen > 0:
        return _CLEAR.format(begin)
    end = "∞" if math.isinf(k) else f"{k:g}"
    return _NEEDED.format(begin, lower, end, where).replace("∞]", "∞)")


def _middle(report: LoopReport) -> str:
    """That a figure is of one plant of many; empty for a single one."""
    return _MIDDLE if isinstance(report.analysis.problem.plant, PlantFamily) else ""


def _lower(report: LoopReport) -> float:
    return float(report.analysis.rows[0].lower)


def _line(report: LoopReport, criterion: str) -> Line:
    """The largest sector that a criterion proves, with its multiplier, or the one that was asked about."""
    rows, asked, lower = report.analysis.rows, report.analysis.problem.given, _lower(report)
    for row in rows:
        for answer in row.answers:
            if answer.verdict is Verdict.PROVED and answer.criterion == criterion and answer.largest.low > lower:
                return answer.largest.low, answer.theta, True
    ends = [] if asked is None else [float(asked.sector.upper)]
    ends += [row.refuted_at for row in rows if row.refuted_at is not None]
    return next((end for end in ends if end > lower), lower + 1.0), None, False


def _response(report: LoopReport) -> Iterator[FigureSpec]:
    """Simulated solutions with the given nonlinearity, or with one extreme member of the class that is proved."""
    seen = [
        one for one in report.trajectories if one.nonlinearity == report.trajectories[0].nonlinearity and one.t[-1] > 0
    ]
    if seen:
        nonlinearity = report.analysis.problem.nonlinearity
        words = "the given φ" if nonlinearity is not None else seen[0].nonlinearity
        draw = partial(plot_solutions, seen)
        title, caption = "Response σ(t) from a few starts", _SEEN.format(words) + _middle(report)
        yield FigureSpec(name="response", section="frequency", title=title, caption=caption, draw=draw)


def _counterexamples(block: Plant, rows: tuple[StabilityBound, ...]) -> Iterator[FigureSpec]:
    """Of each periodic orbit its nonlinearity, and its signals over one period."""
    drawn: list[str] = []
    for row in rows:
        witness = row.witness
        if witness is None or witness.kind != "periodic orbit" or "points" not in witness.data:
            continue
        if witness.description in drawn:
            continue
        drawn.append(witness.description)
        yield from _orbit(block, witness, len(drawn), row.class_name)


def _orbit(block: Plant, witness: Witness, number: int, name: str) -> Iterator[FigureSpec]:
    visits = (
        "The solution visits the marked points." if "sigma" in witness.data else "The solution sweeps the thick part."
    )
    yield FigureSpec(
        name=f"orbit-{number}",
        section="frequency",
        title=f"Counterexample, {name}: {witness.description.partition(': ')[2] or witness.kind}",
        caption=_ORBIT,
        draw=partial(plot_orbit_signals, block, witness),
    )
    yield FigureSpec(
        name=f"nonlinearity-{number}",
        section="frequency",
        title="Its nonlinearity",
        caption=_LAW.format(f" {visits}"),
        draw=partial(plot_nonlinearity, witness),
    )

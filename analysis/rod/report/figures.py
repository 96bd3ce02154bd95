"""The figures of a report: which, in what order, and what each one says."""

from __future__ import annotations

import math
from functools import partial

from lure.analysis.plots import Draw, drawing_frequencies, plot_nyquist, plot_popov_expression, render
from lure.analysis.report.parts import Figure, FigureSpec
from lure.analysis.rod.plots import plot_damping, plot_decay, plot_end_motion, plot_rest, plot_spectrum, plot_surface
from lure.analysis.rod.plots.comparison import plot_both_decays, plot_both_ends
from lure.analysis.rod.plots.frequency import plot_rod_nyquist, plot_rod_popov
from lure.analysis.rod.report.model import StabilityReport
from lure.analysis.verdict import CriterionResult, Model
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant

_NYQUIST = "For the circle criterion the curves have to stay out of the shaded half-plane."
_POPOV = (
    "The curves have to stay to the right of the Popov line, which has slope 1/θ; the horizontal distance is the value "
    "of the Popov expression."
)
_NO_POPOV = "Popov's criterion does not apply to this rod; the line drawn is the one that would have been needed."
_EXPRESSION = (
    "The margin is the least value over all frequencies, marked where it is attained. Triangles mark the limits at "
    "both ends{}."
)
_ENDS = "Dashpot at the left edge, obstacle at the right."
_RESONANCES = "The elastic resonances, from half the first frequency up; mind the scale of the axes.{}"


def figures(report: StabilityReport) -> tuple[Figure, ...]:
    """Draw every figure of a report."""
    return tuple(Figure(spec=spec, picture=render(spec.draw, name=spec.name)) for spec in specs(report))


def specs(report: StabilityReport) -> tuple[FigureSpec, ...]:
    """Every figure of a report before it is drawn."""
    return (*_spectrum(report), *_frequency(report), *_confirmation(report), *_simulation(report))


def _spectrum(report: StabilityReport) -> list[FigureSpec]:
    return [
        FigureSpec(
            name="spectrum",
            section="spectrum",
            title="Eigenvalues of the scheme, poles of the rod",
            caption="The further left a mode of the scheme lies of the rod's, the more of its damping is numerical.",
            draw=partial(plot_spectrum, report.scheme),
        ),
        FigureSpec(
            name="damping",
            section="spectrum",
            title="Damping, mode by mode",
            caption="The grey bar is damping of the scheme that the rod does not have (logarithmic).",
            draw=partial(plot_damping, report.scheme),
        ),
    ]


def _frequency(report: StabilityReport) -> list[FigureSpec]:
    """Popov and Nyquist plot of rod and scheme together; Popov expressions and resonances of each."""
    found = {(result.criterion, result.model): result for result in report.criteria}
    scheme = report.scheme
    blocks: tuple[tuple[Model, UpwindScheme | RodPlant], ...] = (("scheme", scheme), ("rod", RodPlant(scheme.rod)))
    popov, circle = found["popov", "rod"], found["circle", "rod"]
    both = [
        FigureSpec(
            name="popov",
            section="frequency",
            title="Popov plot, rod and scheme",
            caption=_POPOV if popov.theta is not None else _NO_POPOV,
            draw=partial(plot_rod_popov, scheme, popov),
        ),
        FigureSpec(
            name="nyquist",
            section="frequency",
            title="Nyquist plot, rod and scheme",
            caption=_NYQUIST,
            draw=partial(plot_rod_nyquist, scheme, circle),
        ),
    ]
    rows: list[FigureSpec | None] = [_expression(model, block, found["popov", model]) for model, block in blocks]
    rows += [_resonances(model, block, found["circle", model]) for model, block in blocks]
    return both + [spec for spec in rows if spec is not None]


def _expression(model: Model, block: UpwindScheme | RodPlant, result: CriterionResult) -> FigureSpec | None:
    if result.theta is None:
        return None
    return FigureSpec(
        name=f"popov-expression-{model}",
        section="criteria",
        title=f"Popov expression against frequency, {model}",
        caption=_EXPRESSION.format(", upper and lower at infinity" if model == "rod" else ""),
        draw=partial(plot_popov_expression, block, result),
    )


def _resonances(model: Model, block: UpwindScheme | RodPlant, result: CriterionResult) -> FigureSpec | None:
    if block.rod.reflection == 0.0:
        return None
    omega = drawing_frequencies(block)
    omega = omega[omega > 0.5 * math.pi / block.rod.travel_time]
    return FigureSpec(
        name=f"nyquist-{model}-resonances",
        section="criteria",
        title=f"Nyquist plot near the origin, {model}",
        caption=_RESONANCES.format(" The rod has infinitely many; 24 are drawn." if model == "rod" else ""),
        draw=partial(plot_nyquist, block, result.sector, omega=omega),
    )


def _confirmation(report: StabilityReport) -> list[FigureSpec]:
    """Rod and scheme on the same axes."""
    found = report.confirmation
    if found.rod is None:
        return []
    scheme = "" if found.scheme is None else " The scheme loses to numerical damping what the rod keeps."
    ends = "z of the end in the rod and in its scheme, both without a time step."
    if found.kind == "decay":
        ends = f"z of the end in both; ζ is constant in free flight and falls in contact.{scheme}"
    specs = [
        FigureSpec(
            name="both-ends",
            section="confirmation",
            title="The end of the rod, and of its scheme",
            caption=ends,
            draw=partial(plot_both_ends, found),
        )
    ]
    if found.kind != "load":
        says = {
            "decay": "Energy and Popov–Lyapunov function V of each never rise.",
            "undamped": "Without damping the rod keeps its energy.",
            "growth": "The energy of the rod never falls.",
        }[found.kind]
        specs.append(
            FigureSpec(
                name="both-decays",
                section="confirmation",
                title="Energy of the rod, and of its scheme",
                caption=says + (scheme if found.kind == "decay" else ""),
                draw=partial(plot_both_decays, found),
            )
        )
    return specs


def _simulation(report: StabilityReport) -> list[FigureSpec]:
    run = report.simulation.trajectory
    if run is None:
        return []
    shading = "Shaded: contact." if run.contact else "No contact."
    if run.rest_position is None:
        rest_title, rest = "Contact coordinate and its deflated part", "No claim is made about a resting place."
    else:
        rest_title = "Where the rod comes to rest"
        rest = (
            "ζ is where the end would rest if the rod did not touch again; without load it never increases. z "
            "approaches it at the slowest rate of the spectrum, which can take far longer than this run."
        )
    if run.lyapunov is None:
        energy_title, energy = "Energy", "What is checked here is the balance of the energy, not that it falls."
    else:
        energy_title = "Energy and Popov–Lyapunov function"
        energy = "Without load both fall along every motion of the scheme."
    drawn: tuple[tuple[str, str, str, Draw], ...] = (
        ("end-motion", "Motion of the contacting end", shading, partial(plot_end_motion, run)),
        ("resting-place", rest_title, rest, partial(plot_rest, run)),
        ("decay", energy_title, energy, partial(plot_decay, run)),
        ("surface-r1", "Forward wave in space and time", _ENDS, partial(plot_surface, run, "r1")),
        ("surface-r2", "Backward wave in space and time", _ENDS, partial(plot_surface, run, "r2")),
        ("surface-v", "Velocity in space and time", _ENDS, partial(plot_surface, run, "v")),
    )
    return [
        FigureSpec(name=name, section="simulation", title=title, caption=caption, draw=draw)
        for name, title, caption, draw in drawn
    ]

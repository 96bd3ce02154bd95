"""Figures 3 to 10 of the paper, redrawn, each with what the rod itself does; and the reproduction as files."""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from lure.analysis.plots.style import BLUE, GREEN, GREY, PURPLE, Draw, Picture, render
from lure.analysis.report.html import template
from lure.analysis.rod.paper.model import TITLES, PaperTable, Variant
from lure.analysis.rod.paper.runs import FORCED, RELEASE, PaperRuns
from lure.analysis.rod.paper.settling import PAPER_SETTLING
from lure.analysis.rod.plots.paper import EndCurve, plot_end_curves, plot_end_envelope, plot_waves
from lure.record import described, quantity

# The reproduction as files: figures, a page and JSON.


def write_paper(table: PaperTable, runs: PaperRuns, directory: Path) -> None:
    """Write ``paper.html``, ``paper.json`` and ``figures/`` into a directory, made if missing.

    Files of these names are replaced; for all or nothing write inside :func:`lure.analysis.output.replaced`.
    """
    drawn = [(figure, render(figure.draw, name=figure.name)) for figure in paper_figures(runs)]
    folder = directory / "figures"
    folder.mkdir(parents=True, exist_ok=True)
    for figure, picture in drawn:
        (folder / f"{figure.name}.svg").write_text(picture.svg, encoding="utf-8")
        (folder / f"{figure.name}.png").write_bytes(picture.png)
    text = json.dumps(table.to_dict(), indent=2, allow_nan=False)
    (directory / "paper.json").write_text(text + "\n", encoding="utf-8")
    (directory / "paper.html").write_text(paper_page(table, drawn), encoding="utf-8")


def paper_page(table: PaperTable, drawn: list[tuple[PaperFigure, Picture]]) -> str:
    """The reproduction as one page of HTML: offline, without scripts, in the style of the report.

    ``drawn``: the figures, in order.
    """
    peaks = [
        (title, [table.peak(figure, variant) for figure in FORCED])
        for variant, title in TITLES.items()
        if any(peak.variant == variant for peak in table.peaks)
    ]
    return template("paper.html.j2", __package__).render(
        claims=table.claims,
        survivors=sum(claim.survives for claim in table.claims),
        numbers=FORCED,
        peaks=peaks,
        settling=table.settling,
        figures=[(figure, _embedded(picture)) for figure, picture in drawn],
    )


def _embedded(picture: Picture) -> str:
    return "data:image/svg+xml;base64," + base64.b64encode(picture.svg.encode()).decode()


_ZOOM = 1.2e-3
_WAVES = {3: "r1", 4: "r2", 5: "v"}
_NAMES = {"r1": "forward wave r₁", "r2": "backward wave r₂", "v": "velocity v"}
_SHOWN: tuple[tuple[Variant, str, str, str, float], ...] = (
    ("rod-rescaled", "the rod, force / 60000", GREY, "-", 3.0),
    ("as-printed-200", "as printed, N = 200", PURPLE, "--", 1.2),
    ("as-printed", "as printed, N = 10", BLUE, "-", 1.2),
)


@described(frozen=True, kw_only=True, slots=True)
class PaperFigure:
    """One figure before it is drawn."""

    name: str = quantity("File name without its ending")
    number: int = quantity("Number in the paper")
    title: str = quantity("A few words above it")
    caption: str = quantity("What to look at")
    draw: Draw = quantity("``draw(ax=axes)`` draws on the axes")


def paper_figures(runs: PaperRuns) -> tuple[PaperFigure, ...]:
    """Figures 3 to 10, in order.

    Parameters
    ----------
    runs : PaperRuns
        The motions behind them.
    """
    waves = [figure for number in _WAVES for figure in _wave_figures(runs, number)]
    return (*waves, *_release_figures(runs), *(_forced_figure(runs, number) for number in (8, 9, 10)))


def _wave_figures(runs: PaperRuns, number: int) -> list[PaperFigure]:
    which = _WAVES[number]
    coarse, rod = runs.coarse, runs.exact
    t, x = np.linspace(0.0, RELEASE, 401), np.linspace(0.0, runs.release.rod.length, 101)
    forward, backward = rod.waves(t[:, None], x)
    exact = {"r1": forward, "r2": backward, "v": 0.5 * (forward + backward)}[which]
    scheme = {"r1": coarse.frames_r1, "r2": coarse.frames_r2, "v": coarse.frames_v}[which]
    name = _NAMES[which]
    return [
        PaperFigure(
            name=f"figure-{number:02d}",
            number=number,
            title=f"Figure {number}: {name}, scheme with N = 10",
            caption="As in the paper: the steps of the initial data are smeared and die out within a millisecond.",
            draw=lambda ax: plot_waves(coarse.frames_x, coarse.frames_t, scheme, title=f"{name}, N = 10", ax=ax),
        ),
        PaperFigure(
            name=f"figure-{number:02d}-rod",
            number=number,
            title=f"Figure {number}: {name}, the rod itself",
            caption="Exact: steps of 1.2 m/s that run to and fro and lose 0.03 % in each round trip.",
            draw=lambda ax: plot_waves(x, t, exact, title=f"{name}, the rod", ax=ax),
        ),
    ]


def _release_figures(runs: PaperRuns) -> list[PaperFigure]:
    coarse, fine, exact = runs.coarse, runs.fine, runs.exact
    transit = runs.release.rod.travel_time
    corners = np.append(np.arange(0.0, coarse.t[-1], transit), coarse.t[-1])
    curves = [
        EndCurve(label="the rod", t=corners, u=exact.end_displacement(corners), colour=GREY, width=2.5),
        EndCurve(label="N = 200", t=fine.t, u=fine.u_end, colour=GREEN),
        EndCurve(label="N = 10", t=coarse.t, u=coarse.u_end, colour=BLUE),
    ]

    def zoomed(curve: EndCurve) -> EndCurve:
        """The curve on the window of the figure."""
        kept = curve.t <= _ZOOM
        return replace(curve, t=curve.t[kept], u=curve.u[kept])

    trips = 2 * transit * np.linspace(0, int(exact.until / (2 * transit)) - 1, 301).round()
    low, high = exact.end_displacement(trips), exact.end_displacement(trips + transit)
    _, _, rod = runs.settling
    drift = EndCurve(
        label="drift to the resting place", t=trips, u=rod.rest + rod.drift * np.exp(-trips / rod.slow), colour=BLUE
    )
    return [
        PaperFigure(
            name="figure-06",
            number=6,
            title="Figure 6: released end",
            caption=(
                "The paper shows the curve for N = 10. With N = 200 the same scheme still rings; the rod is a triangle "
                "wave that loses 0.03 % in each round trip."
            ),
            draw=lambda ax: plot_end_curves(curves, settling=PAPER_SETTLING, ax=ax),
        ),
        PaperFigure(
            name="figure-07",
            number=7,
            title="Figure 7: the same, closer",
            caption="Up to the printed settling time.",
            draw=lambda ax: plot_end_curves([zoomed(curve) for curve in curves], settling=PAPER_SETTLING, ax=ax),
        ),
        PaperFigure(
            name="figure-06-seconds",
            number=6,
            title="Figure 6 for five seconds",
            caption=(
                "What 2.5 ms cannot show: ringing and drift both decay with a time constant of 1 s, and the end comes "
                "to rest at +1e-4 m."
            ),
            draw=lambda ax: plot_end_envelope(trips, low, high, drift, ax=ax),
        ),
    ]


def _forced_figure(runs: PaperRuns, number: int) -> PaperFigure:
    curves = []
    for variant, label, colour, dashes, width in _SHOWN:
        run = runs.run(number, variant)
        curves.append(EndCurve(label=label, t=run.t, u=run.u, colour=colour, dashes=dashes, width=width))
    printed, small, rod = (runs.run(number, variant) for variant in ("as-printed", "rod-rescaled", "rod"))
    touches = "contact" if printed.peak.contact else "no contact"
    return PaperFigure(
        name=f"figure-{number:02d}",
        number=number,
        title=f"Figure {number}: forced end",
        caption=(
            f"As printed with N = 10: {touches}, largest z {printed.peak.largest_z:.4g} m. The rod does the same for "
            f"{small.peak.amplitude:.3g} N; {rod.peak.amplitude:g} N would take it to z = {rod.peak.largest_z:.4g} m."
        ),
        draw=lambda ax: plot_end_curves(curves, obstacle=runs.release.rod.gap, contacts=printed.contacts, ax=ax),
    )

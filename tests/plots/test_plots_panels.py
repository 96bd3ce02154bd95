"""Figures of two panels: every label stands inside the figure, whatever lays it out."""

from functools import cache

import numpy as np
import pytest
from depth import rarely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lure.analysis.measured import example_measurements, fit_compliance, sector_from_data
from lure.analysis.plots import plot_compliance, plot_measured
from lure.analysis.rod.comparison import compare
from lure.analysis.rod.plots import plot_comparison
from lure.rod import Scenario
from lure.rod.systems import paper_rod

DATA = example_measurements()


@cache
def beside():
    scenario = Scenario.parse(displacement="1/1000")
    return compare(paper_rod(), scenario, 1e-4, cells=(5,), galerkin=(("P1", 6),), samples=101)


DRAWINGS = {
    "measured": lambda ax: plot_measured(sector_from_data(DATA), ax=ax),
    "comparison": lambda ax: plot_comparison(beside(), ax=ax),
    "compliance": lambda ax: plot_compliance(fit_compliance(DATA), ax=ax),
}


def drawn(figure):
    FigureCanvasAgg(figure).draw()
    return figure


def assert_stacked(figure, above, below):
    """Labels inside the figure, the panels one above the other without meeting, as wide as one another."""
    labels = [axes.yaxis.label for axes in (above, below)] + [below.xaxis.label]
    width, height = figure.get_size_inches() * figure.dpi
    for label in labels:
        assert label.get_text()
        box = label.get_window_extent()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
    top, bottom = above.get_position(), below.get_position()
    assert top.y0 > bottom.y1 > bottom.y0
    assert (top.x0, top.x1) == pytest.approx((bottom.x0, bottom.x1), abs=1e-6)
    assert above.get_xlim() == below.get_xlim()


@pytest.mark.slow_for("comparison-None", "compliance-constrained")
@pytest.mark.parametrize("layout", rarely([None, "constrained", "tight", "compressed"], "tight", "compressed"))
@pytest.mark.parametrize("draw", DRAWINGS.values(), ids=DRAWINGS)
def test_the_labels_of_both_panels_are_seen(draw, layout):
    figure = Figure(figsize=(9, 4.5), layout=layout)
    if layout is None:
        figure.subplots_adjust(bottom=0.15)
    left, right = figure.subplots(1, 2)
    right.plot([0, 1])
    above, below = draw(left)
    assert above is left
    drawn(figure)
    assert_stacked(figure, above, below)
    assert below.get_position().x1 < right.get_position().x0


def test_axes_put_down_by_hand_are_cut_in_two_where_they_are():
    figure = Figure(figsize=(6, 5))
    place = figure.add_axes((0.2, 0.2, 0.7, 0.7))
    above, below = DRAWINGS["measured"](place)
    drawn(figure)
    assert_stacked(figure, above, below)
    boxes = np.array([axes.get_position().extents for axes in (above, below)])
    assert [*boxes[:, :2].min(axis=0), *boxes[:, 2:].max(axis=0)] == pytest.approx([0.2, 0.2, 0.9, 0.9])


def test_in_a_figure_within_a_figure_too():
    figure = Figure(figsize=(9, 4.5), layout="constrained")
    half, _ = figure.subfigures(1, 2)
    above, below = DRAWINGS["compliance"](half.subplots())
    drawn(figure)
    assert_stacked(figure, above, below)

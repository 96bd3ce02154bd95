"""The figure of all methods: the numbers of the comparison, on the axes given, and the same bytes every time."""

from fractions import Fraction

import numpy as np
import pytest
from depth import rarely
from matplotlib import pyplot
from matplotlib.figure import Figure

from lure.analysis.rod.comparison import compare
from lure.analysis.rod.plots.comparison import (
    comparison_file,
    plot_comparison,
    plot_comparison_end,
    plot_comparison_error,
)
from lure.rod import Rod, Scenario, builtin_system
from lure.rod.systems import rod_from_exact

PAPER = builtin_system("paper-rod")
NEAR = rod_from_exact(
    {**PAPER.rod.exact, "gap": Fraction(5, 10**5), "compliance": Fraction(1, 10**9), "damping": Fraction(3, 10)}
)


@pytest.fixture(scope="module")
def far():
    """The release of the paper: the obstacle is 200 amplitudes away."""
    return compare(PAPER.rod, PAPER.scenario, 1e-3, cells=(5, 10, 20, 40), galerkin=(("P1", 6),), samples=301)


@pytest.fixture(scope="module")
def near():
    """Two contacts."""
    return compare(NEAR, PAPER.scenario, 1e-3, cells=(10,), galerkin=(("P1", 6), ("P1", 11)), samples=301)


@pytest.mark.slow
def test_above_are_the_motions_and_below_their_errors(far):
    above, below = plot_comparison(far, ax=Figure().add_subplot())
    labels = [row.label for row in far.rows]
    assert [line.get_label() for line in above.lines] == ["exact", *labels]
    for line, u in zip(above.lines, [far.exact.u, *(row.u for row in far.rows)], strict=True):
        assert np.array_equal(line.get_ydata(), u)
    drawn = [line for line in below.lines if len(line.get_xdata()) > 2]
    for line, row in zip(drawn, far.rows, strict=True):
        assert max(line.get_ydata()) == pytest.approx(row.largest_error / far.exact.amplitude, rel=1e-12)
        assert line.get_drawstyle() == "steps-post"
    assert below.get_yscale() == "log"
    assert below.get_xlim() == above.get_xlim() == (0.0, 1e-3)
    assert "first kink" in below.texts[0].get_text()


def test_every_stretch_shows_the_largest_error_within_it(far):
    axes = plot_comparison_error(far, ax=Figure().add_subplot())
    row, line = far.rows[0], axes.lines[0]
    edges, tops = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    error = np.abs(row.u - far.exact.u) / far.exact.amplitude
    for low, high, top in zip(edges[:-2], edges[1:-1], tops[:-2], strict=True):
        assert top == pytest.approx(error[(far.t >= low) & (far.t < high)].max(), rel=1e-12)


@pytest.mark.slow
def test_curves_are_told_apart(far, near):
    for found in (far, near):
        axes = plot_comparison_end(found, ax=Figure().add_subplot())
        shown = {(line.get_color(), line.get_linestyle(), str(line._dash_pattern)) for line in axes.lines}
        assert len(shown) == len(axes.lines)


def test_an_obstacle_out_of_view_is_named_and_one_within_is_drawn(far, near):
    outside = plot_comparison_end(far, ax=Figure().add_subplot())
    assert outside.texts[0].get_text() == "obstacle at 0.02 m, outside this view"
    assert not outside.collections
    inside = plot_comparison_end(near, ax=Figure().add_subplot())
    assert inside.lines[-1].get_ydata() == [5e-5, 5e-5]
    (bars,) = inside.collections
    spans = [(path.get_extents().x0, path.get_extents().x1) for path in bars.get_paths()]
    assert spans == [pytest.approx(contact, rel=1e-9) for contact in near.contacts]


def test_a_model_that_was_not_run_is_not_drawn():
    rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0, compliance=1, gap=99, exponent=0.5)
    found = compare(rod, Scenario.parse(displacement="cos(pi*x)"), 1.0, cells=(5,), galerkin=(("P1", 5),), samples=51)
    above, _ = plot_comparison(found, ax=Figure().add_subplot())
    assert [line.get_label() for line in above.lines][:2] == ["exact", "scheme, N = 5"]
    assert len(above.lines) == 2


def test_a_rod_at_rest_can_be_drawn():
    rod = Rod(youngs_modulus=1, density=1, length=1, area=1, damping=0, compliance=1, gap=1)
    found = compare(rod, Scenario.parse(), 1.0, cells=(5,), galerkin=(), samples=51)
    _, below = plot_comparison(found, ax=Figure().add_subplot())
    assert below.get_ylabel() == "largest error [m]"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "magic"), rarely([("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")], ("pdf", b"%PDF"))
)
def test_files_are_of_their_kind_and_the_same_every_time(near, kind, magic):
    before, figures = pyplot.rcParams.copy(), pyplot.get_fignums()
    document = comparison_file(near, kind)
    assert document.startswith(magic)
    assert document == comparison_file(near, kind)
    assert (pyplot.rcParams, pyplot.get_fignums()) == (before, figures)


def test_without_axes_a_new_figure_is_made(near):
    above, below = plot_comparison(near)
    assert above.figure is below.figure
    pyplot.close(above.figure)

"""Figures: on the axes given, with the numbers of the results, and the same bytes every time."""

import math
import re
from fractions import Fraction
from functools import partial
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib import pyplot
from matplotlib.figure import Figure

from lure import InputError, LinearBlock, Saturation, Sector
from lure.analysis import nonlinearity_bounds, region
from lure.analysis.plots import (
    drawing_frequencies,
    plot_nyquist,
    plot_popov,
    plot_popov_expression,
    render,
    style,
)
from lure.analysis.plots.regions import plot_region
from lure.analysis.plots.sectors import plot_nonlinearity_sector, plot_nonlinearity_slope
from lure.analysis.plots.style import INK, finish_axes, number
from lure.analysis.rod.plots import plot_damping, plot_decay, plot_end_motion, plot_rest, plot_spectrum, plot_surface
from lure.analysis.rod.popov import rod_popov_criterion as popov_criterion
from lure.analysis.rod.simulation import simulate
from lure.rod import Rod, RodPlant, Scenario, upwind
from lure.rod.systems import paper_rod, rod_from_exact

ROD = paper_rod()
SCHEME = upwind(ROD, 10)
SECTOR = ROD.nonlinearity.sector
POPOV = {block: popov_criterion(block, SECTOR) for block in (SCHEME, RodPlant(ROD))}
# pushed at 1 m/s towards an obstacle 0.1 mm away: it touches within the first transit (0.17 ms)
PUSHED = simulate(
    upwind(rod_from_exact({**ROD.exact, "gap": Fraction(1, 10000)}), 6),
    Scenario.parse(velocity=1),
    until=1e-3,
    frames=12,
)
DRAWINGS = {
    "nyquist": partial(plot_nyquist, SCHEME, SECTOR, worst=0.0),
    "popov": partial(plot_popov, SCHEME, POPOV[SCHEME]),
    "popov expression": partial(plot_popov_expression, SCHEME, POPOV[SCHEME]),
    "spectrum": partial(plot_spectrum, SCHEME),
    "damping": partial(plot_damping, SCHEME),
    "end motion": partial(plot_end_motion, PUSHED),
    "resting place": partial(plot_rest, PUSHED),
    "decay": partial(plot_decay, PUSHED),
    "r1": partial(plot_surface, PUSHED, "r1"),
    "r2": partial(plot_surface, PUSHED, "r2"),
    "v": partial(plot_surface, PUSHED, "v"),
}


@pytest.fixture
def ax():
    return Figure().add_subplot()


def rod_with(damping):
    """The paper's rod with a dashpot of `damping` impedances; 1 is matched exactly (Z = 1.2 N s/m)."""
    return rod_from_exact({**ROD.exact, "damping": damping * Fraction(6, 5)})


def curve(axes, label):
    return next(line for line in axes.lines if label in str(line.get_label())).get_xydata()


def texts(axes):
    return " ".join([text.get_text() for text in (*axes.texts, *axes.get_legend().get_texts())])


@pytest.mark.parametrize("draw", DRAWINGS.values(), ids=DRAWINGS)
def test_a_plot_draws_on_the_axes_it_is_given_and_returns_them(draw):
    mine, other = Figure().subplots(1, 2)
    assert draw(ax=mine) is mine
    assert mine.has_data()
    assert not other.has_data()


@pytest.mark.parametrize("draw", DRAWINGS.values(), ids=DRAWINGS)
def test_a_plot_labels_both_axes_and_says_the_units(draw, ax):
    draw(ax=ax)
    assert ax.get_xlabel()
    assert ax.get_ylabel()
    assert "[" in ax.get_xlabel() or ax.get_xlabel() == "elastic mode"
    assert "[" in ax.get_ylabel() or ax.get_ylabel().startswith("share")


# on black what is drawn in black is not seen, nor on a dark page, on which only INK becomes the colour of the words
@pytest.mark.parametrize(
    "draw",
    [
        lambda ax: plot_nonlinearity_sector("tanh(sigma)", nonlinearity_bounds("tanh(sigma)"), ax=ax),
        lambda ax: plot_region(region(([1], [1, -1]), Saturation(gain=2, limit=1)), ax=ax),
    ],
    ids=["nonlinearity", "region"],
)
def test_what_is_drawn_in_the_colour_of_the_words_is_seen_on_black(draw):
    with mpl.rc_context({"axes.labelcolor": "white", "text.color": "white"}):
        axes = draw(ax=Figure().add_subplot())
    colours = {mpl.colors.to_hex(line.get_color()) for line in axes.lines}
    assert "#ffffff" in colours
    assert not colours & {"#000000", INK}


# the slope 1 + cos 2 sigma is 0 at pi/2, which a search encloses in [0, 1.4e-48]: the outer end is the bound;
# 4/3 is the largest phi(sigma)/sigma of tanh + sigma/3, and 1.333 would be no bound
def test_a_bound_is_drawn_where_it_is_certified_and_named_rounded_outwards():
    def labels(plot, text):
        axes = plot(text, nonlinearity_bounds(text), ax=Figure().add_subplot())
        return [str(line.get_label()) for line in axes.lines if str(line.get_label()).startswith(("bound", "slope "))]

    assert labels(plot_nonlinearity_slope, "sin(2*sigma)/2 + sigma") == ["bound 0", "bound 2", "slope of φ"]
    assert labels(plot_nonlinearity_sector, "tanh(sigma) + sigma/3") == ["slope 0.3333", "slope 1.334"]


def test_drawings_of_results_ask_for_the_colour_of_the_words():
    for path in Path(style.__file__).parent.glob("*.py"):
        assert path.name == "style.py" or not re.search(r'"black"|\bINK\b', path.read_text("utf-8"))


def test_without_axes_a_new_figure_is_made():
    axes = plot_spectrum(SCHEME)
    assert pyplot.get_fignums() == [axes.figure.number]
    pyplot.close(axes.figure)


@pytest.mark.slow_for("damping", "nyquist", "popov expression", "popov", "r2", "v")
@pytest.mark.parametrize("draw", DRAWINGS.values(), ids=DRAWINGS)
def test_a_picture_is_the_same_whatever_the_settings_and_leaves_them_alone(draw):
    before = dict(mpl.rcParams)
    draw(ax=Figure().add_subplot())
    first = render(draw, name="x")
    assert dict(mpl.rcParams) == before
    assert pyplot.get_fignums() == []
    with mpl.rc_context({"font.size": 30, "lines.linewidth": 9, "axes.facecolor": "red", "svg.hashsalt": "other"}):
        second = render(draw, name="x")
    assert first == second
    assert "<dc:date>" not in first.svg
    assert len(first.svg) < 150_000


# H = 1/(s(s+1)) at i omega: Re H = -1/(1 + omega^2), omega Im H = -1/(1 + omega^2)
def test_the_popov_plot_shows_the_modified_response(ax):
    block = LinearBlock([[0.0, 1.0], [0.0, -1.0]], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0])
    omega = np.array([0.5, 1.0, 2.0])
    plot_popov(block, POPOV[SCHEME], omega=omega, ax=ax)
    expected = -1.0 / (1.0 + omega**2)
    np.testing.assert_allclose(curve(ax, "H(iω)"), np.column_stack([expected, expected]), rtol=1e-12)


@pytest.mark.parametrize("block", POPOV, ids=["scheme", "rod"])
def test_the_popov_line_passes_through_minus_one_over_the_sector_with_slope_one_over_theta(block, ax):
    result = POPOV[block]
    plot_popov(block, result, ax=ax)
    (x0, y0), (x1, y1) = curve(ax, "Popov line")
    assert (y1 - y0) / (x1 - x0) == pytest.approx(1.0 / result.theta)
    assert x0 - result.theta * y0 == pytest.approx(-1.0 / float(SECTOR.upper))


# The least value drawn can be larger than the infimum over all frequencies, but not by much, and never smaller.
@pytest.mark.slow
@pytest.mark.parametrize("name", ["scheme", "rod"])
@given(damping=st.fractions(Fraction(1, 10**6), 10**3, max_denominator=10**6), cells=st.integers(1, 300))
def test_the_curve_drawn_comes_down_to_the_margin_and_not_below(name, damping, cells):
    rod = rod_with(damping)
    block = upwind(rod, cells) if name == "scheme" else RodPlant(rod)
    result = popov_criterion(block, SECTOR)
    ax = plot_popov_expression(block, result, ax=Figure().add_subplot())
    least = np.nanmin(curve(ax, "θ =")[:, 1])
    assert least >= result.margin.low * (1 - 1e-9)
    assert least <= result.margin.high + 0.02 * abs(result.margin.high)
    assert curve(ax, "margin")[0, 1] == result.margin.low


def test_a_resonance_between_grid_points_is_drawn_to_its_top():
    # |H| is largest near the pole: there H = (d/s)(1 + |a|)/(1 - |a|) exactly at 2 omega T = 2 pi
    rod = RodPlant(ROD)
    omega = drawing_frequencies(rod)
    first = math.pi / ROD.travel_time
    near = omega[(omega > 0.9 * first) & (omega < 1.1 * first)]
    a = abs(ROD.reflection)
    top = ROD.mobility / first * (1 + a) / (1 - a)
    assert np.abs(rod.transfer(1j * near)).max() == pytest.approx(top, rel=1e-3)
    # the half-width is ln(1/|a|)/(2T) = 1.0 rad/s, a twenty-thousandth of the frequency
    assert np.count_nonzero(np.abs(omega - first) < 3.0) > 20


def test_the_frequencies_increase_and_are_no_more_than_needed():
    for block in (SCHEME, RodPlant(ROD), SCHEME.block, RodPlant(rod_with(1)), upwind(ROD, 100_000)):
        omega = drawing_frequencies(block)
        assert omega[0] > 0
        assert (np.diff(omega) > 0).all()
        assert 100 < omega.size < 8000


def test_the_half_plane_of_the_circle_criterion_ends_at_minus_one_over_the_sector(ax):
    plot_nyquist(SCHEME, SECTOR, worst=0.0, ax=ax)
    (band,) = ax.patches
    assert band.get_x() + band.get_width() == pytest.approx(-1.0)
    assert "forbidden" in texts(ax)
    assert "Re H → −0.125" in texts(ax)  # 4 a T d/(1 + a)^2


def test_a_forbidden_region_out_of_sight_is_named(ax):
    omega = np.linspace(1e4, 1e5, 50)
    plot_nyquist(SCHEME, SECTOR, omega=omega, ax=ax)
    assert "forbidden: Re H ≤ −1, far to the left" in texts(ax)


def test_a_sector_away_from_zero_forbids_a_disk(ax):
    block = LinearBlock([[-1.0]], [1.0], [0.0], [1.0])
    plot_nyquist(block, Sector(2, 4), ax=ax)
    (disk,) = ax.patches
    assert disk.center == (-0.375, 0.0)
    assert disk.radius == 0.125


def test_the_unbounded_sector_forbids_the_left_half_plane(ax):
    plot_nyquist(SCHEME, Sector(0, math.inf), ax=ax)
    (band,) = ax.patches
    assert band.get_x() + band.get_width() == pytest.approx(0.0)


def test_the_spectrum_shows_every_eigenvalue_of_the_scheme(ax):
    plot_spectrum(SCHEME, ax=ax)
    drawn = {complex(round(x, 3), round(abs(y), 3)) for x, y in curve(ax, "scheme")}
    exact = {complex(round(value.real, 3), round(abs(value.imag), 3)) for value in SCHEME.eigenvalues()}
    assert drawn == exact


def test_the_damping_of_scheme_and_rod_is_that_of_the_spectrum(ax):
    plot_damping(SCHEME, ax=ax)
    # mode 1 of ten cells: s (1 - exp(ln|a|/20) cos(pi/10)), s = 60000; the rod: -ln|a|/(2T) = 1.0000 1/s
    expected = 60000 * (1 - math.exp(math.log(-ROD.reflection) / 20) * math.cos(math.pi / 10))
    assert curve(ax, "scheme")[0, 1] == pytest.approx(expected, rel=1e-9)
    assert curve(ax, "rod")[:, 1] == pytest.approx(np.full(10, 1.0), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damping", "cells"),
    [
        pytest.param(damping, cells, marks=[pytest.mark.thorough] * (row % 2 or (row + column) % 3 > 0))
        for row, damping in enumerate([Fraction(-1, 2), -2, 0, Fraction(1, 10**6), 1, 3, 10**6])
        for column, cells in enumerate([1, 2, 300])
    ],
)
def test_every_rod_can_be_drawn(damping, cells):
    rod = rod_with(damping)
    scheme = upwind(rod, cells)
    for draw in (
        partial(plot_spectrum, scheme),
        partial(plot_damping, scheme),
        partial(plot_nyquist, scheme, SECTOR),
        partial(plot_nyquist, RodPlant(rod), SECTOR),
    ):
        picture = render(draw, name="x")
        assert "nan" not in picture.svg.lower()
        assert picture.png.startswith(b"\x89PNG")


def test_contact_is_shaded_and_the_obstacle_drawn_where_it_is(ax):
    plot_end_motion(PUSHED, ax=ax)
    assert len(PUSHED.contacts) >= 1
    (bars,) = ax.collections
    spans = [path.get_extents().intervalx for path in bars.get_paths()]
    np.testing.assert_allclose(spans, [(contact.start, contact.end) for contact in PUSHED.contacts])
    assert curve(ax, "obstacle")[:, 1] == pytest.approx([1e-4, 1e-4])


def test_an_obstacle_out_of_sight_is_named(ax):
    still = simulate(SCHEME, Scenario.parse(velocity="0.001"), until=1e-4, frames=3)
    plot_end_motion(still, ax=ax)
    assert "obstacle at 0.02 m, outside this view" in texts(ax)


def test_a_surface_can_be_drawn_in_space():
    axes = Figure().add_subplot(projection="3d")
    assert plot_surface(PUSHED, "v", ax=axes) is axes
    assert axes.get_zlabel() == "[m/s]"


def test_a_plot_that_cannot_be_drawn_says_why(ax):
    undamped = popov_criterion(upwind(rod_with(0), 10), SECTOR)
    with pytest.raises(InputError, match=r"popov criterion gave no multiplier for the scheme: .*double"):
        plot_popov(SCHEME, undamped, ax=ax)
    with pytest.raises(InputError, match="shift the loop"):
        plot_nyquist(SCHEME, Sector(-1, 1), ax=ax)
    with pytest.raises(InputError, match="resonances of a object are not known"):
        drawing_frequencies(object())
    with pytest.raises(InputError, match="two positive frequencies"):
        plot_nyquist(SCHEME, SECTOR, omega=[0.0, 1.0], ax=ax)
    with pytest.raises(InputError, match="give one of r1, r2, v"):
        plot_surface(PUSHED, "w", ax=ax)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (-0.125, "−0.125"), (6000.0, "6000"), (1.5e-7, "1.5×10⁻⁷"), (-2e12, "−2×10¹²"), (math.inf, "∞")],
)
def test_a_number_in_a_label_reads_as_written_by_hand(value, text):
    assert number(value) == text


def test_a_rod_of_another_size_has_its_own_units():
    stiff = Rod(youngs_modulus=2e11, density=7800, length=10, area=1e-2, damping=1e3, compliance=1e-12)
    axes = plot_popov(
        RodPlant(stiff), popov_criterion(RodPlant(stiff), stiff.nonlinearity.sector), ax=Figure().add_subplot()
    )
    assert axes.get_xlabel() == "Re H(iω) [m/Pa]"
    assert axes.get_ylabel() == "ω Im H(iω) [m/(Pa s)]"


def test_a_small_range_far_from_zero_is_counted_from_a_round_number(ax):
    ax.set_ylim(-0.02001, -0.01999)
    finish_axes(ax)
    formatter = ax.yaxis.get_major_formatter()
    assert formatter.get_offset() == "×10⁻⁵ − 0.02"
    assert formatter(-0.019995, 0) == "0.5"


def test_what_fails_is_drawn_inside_the_forbidden_region_and_called_short():
    # A m/k^2 = 4999 m/Pa for k = 1e-6: Re H -> -5000 as omega -> 0, far beyond -1/kappa = -1
    rod = rod_from_exact({**ROD.exact, "damping": Fraction(1, 10**6)})
    axes = plot_nyquist(RodPlant(rod), SECTOR, worst=0.0, ax=Figure().add_subplot())
    assert "short by" in texts(axes)
    assert "margin" not in texts(axes)

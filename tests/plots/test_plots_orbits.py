"""Orbits of counterexamples, the nonlinearities behind them and harmonic balances, as drawings."""

from fractions import Fraction

import numpy as np
import pytest
from matplotlib.figure import Figure

from lure import InputError, PiecewiseLinear, RationalPlant, Saturation
from lure.analysis.counterexamples.linear import linear_witness
from lure.analysis.counterexamples.orbit import accept_orbit
from lure.analysis.counterexamples.search import accept_orbit_continuous
from lure.analysis.counterexamples.simulated import orbit_of
from lure.analysis.describing import DescribingHint, describing_hint
from lure.analysis.plots import plot_hint, plot_nonlinearity, plot_orbit, plot_orbit_signals

# Fitts' plant with damping 3/100, which swings with a steep saturation, from the state of the literature
DAMPING = Fraction(3, 100)
FITTS = RationalPlant(
    [1, 0, 0],
    np.polymul([1, 2 * DAMPING, DAMPING**2 + Fraction(81, 100)], [1, 2 * DAMPING, DAMPING**2 + Fraction(121, 100)]),
)
SWING = accept_orbit_continuous(
    FITTS,
    Saturation(gain=100),
    (-0.8568501753859451, 1.5659435663914607, 0.5061096169300414, -1.061805076491118),
    period=11.917,
)
# Carrasco, Heath, Zhang, Ahmad and Wang (2019), example 6, and its orbit of three samples
SIXTH = RationalPlant([2, Fraction(23, 25)], [1, Fraction(-1, 2), 0], dt=1)
CYCLE = accept_orbit(
    SIXTH, [("-74498/72625", "-192/415"), ("-36864/72625", "-192/415"), ("192/175", 1)], ["192/415", "192/415", -1]
)


@pytest.fixture
def ax():
    return Figure().add_subplot()


def lines(ax):
    return {line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")}


def test_the_orbit_of_a_flow_closes_and_swings_equally_far_to_both_sides():
    t, sigma = orbit_of(FITTS, SWING)
    assert t[-1] == SWING.data["period"]
    assert abs(sigma[-1] - sigma[0]) < 1e-8 * sigma.max()
    # the nonlinearity is odd and the orbit found is symmetric: sigma(t + T/2) = -sigma(t)
    assert sigma[600:] == pytest.approx(-sigma[:601], abs=1e-8 * sigma.max())
    assert SWING.data["visited"] == pytest.approx([sigma.min(), sigma.max()], rel=1e-3)


def test_an_orbit_is_drawn_over_its_period_and_says_what_it_rests_on(ax):
    assert plot_orbit(FITTS, SWING, ax=ax) is ax
    (name,) = [label for label in lines(ax) if "orbit" in label]
    assert name == f"certified orbit, period {SWING.data['period']:.4g} s"
    assert ax.get_xlim() == (0.0, SWING.data["period"])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("t [s]", "σ [unit of σ]")
    bends = sorted(line.get_ydata()[0] for line in ax.get_lines() if line.get_linestyle() == "--")
    assert bends == [float(Fraction(x)) for x, _ in SWING.data["points"]]


def test_an_orbit_in_discrete_time_is_drawn_sample_by_sample(ax):
    plot_orbit(SIXTH, CYCLE, ax=ax)
    drawn = lines(ax)["certified orbit, period 3 samples"]
    visited = [float(Fraction(value)) for value in CYCLE.data["sigma"]]
    assert list(drawn.get_ydata()) == [*visited, visited[0]]
    assert list(drawn.get_xdata()) == [0, 1, 2, 3]


# H = (2 z + 23/25)/(z^2 - z/2): what is drawn satisfies sigma(t+2) = sigma(t+1)/2 + 2 mu(t+1) + 23/25 mu(t)
def test_the_two_signals_of_an_orbit_are_those_of_the_loop(ax):
    figure = ax.figure
    above = plot_orbit_signals(SIXTH, CYCLE, ax=ax)
    below = next(axes for axes in figure.axes if axes is not above)
    assert (above.get_ylabel(), below.get_ylabel()) == ("σ [unit of σ]", "μ [unit of μ]")
    sigma, mu = (axes.get_lines()[0].get_ydata()[:3] for axes in (above, below))
    later, next_mu = np.roll(sigma, -2), np.roll(mu, -1)
    assert later == pytest.approx(np.roll(sigma, -1) / 2 + 2 * next_mu + 0.92 * mu, abs=1e-12)
    assert below.get_xlabel() == "t [samples]"


def test_the_law_is_drawn_as_far_as_the_orbit_goes(ax):
    low, high = SWING.data["visited"]
    drawn = lines(plot_nonlinearity(SWING, ax=ax))
    for name in ("φ", "visited by the orbit"):
        x, y = drawn[name].get_data()
        assert x[0] <= low < -0.5  # far beyond the corners at -1/100 and 1/100
        assert x[-1] >= high > 0.5
        assert y == pytest.approx(np.clip(100 * x, -1, 1), abs=1e-12)
    assert list(drawn["visited by the orbit"].get_xdata()[[0, -1]]) == [low, high]


def test_what_has_no_orbit_cannot_be_drawn():
    with pytest.raises(InputError, match=r"^there is no orbit to draw: the witness is a linear gain"):
        plot_orbit(SIXTH, linear_witness(RationalPlant([1], [1, 3, 2, 0])))
    with pytest.raises(InputError, match="is in discrete time; give the block"):
        plot_orbit(FITTS, CYCLE)
    with pytest.raises(InputError, match="does not close after the period"):
        plot_orbit(RationalPlant([1, 0, 0], [1, 2, 3, 4, 5]), SWING)


# -(s + 8/5)/(s^2 + 39/100 s + 1) is real at one frequency, with 1 + N H = 0 for N = 0.39: there the closed loop
# s^2 + (0.39 - N) s + 1 - 1.6 N has no damping, and swings with sqrt(1 - 1.6 * 0.39) = 0.6132 rad/s
ALARM = RationalPlant([-1, Fraction(-8, 5)], [1, Fraction(39, 100), 1])
STOP = PiecewiseLinear(points=((-2, -1), (-1, 0), (1, 0), (2, 1)), left_slope=0, right_slope=0)


def test_a_hint_marks_each_balance_where_the_curve_meets_the_locus(ax):
    hint = describing_hint(ALARM, STOP)
    assert hint.plot(ax=ax) is ax
    marks = [line for name, line in lines(ax).items() if name.startswith("A = ")]
    assert [float(line.get_xdata()[0]) for line in marks] == pytest.approx([-1 / 0.39] * 2, rel=1e-9)
    assert [line.get_label() for line in marks] == [
        f"A = {b.amplitude:.4g}, ω = 0.6132 rad/s, perhaps {word}"
        for b, word in zip(hint.balances, ("repelling", "attracting"), strict=True)
    ]
    curve = lines(ax)["H(iω), ω > 0"].get_xydata()
    assert np.hypot(*(curve - [-1 / 0.39, 0]).T).min() < 0.05
    low, high = lines(ax)["−1/N(A)"].get_xdata()
    assert low == ax.get_xlim()[0]  # N falls to 0: the locus has no end on the left
    largest = max(describing_values())
    assert high == pytest.approx(-1 / largest, rel=1e-3)
    assert "hint, not a verdict" in ax.get_title()


def describing_values():
    from lure.analysis.describing import describing_function

    return describing_function(STOP, np.linspace(1.01, 20, 2000))


def test_a_hint_without_a_balance_says_that_this_excludes_nothing(ax):
    plot_hint(describing_hint(FITTS, Saturation(gain=2)), ax=ax)
    assert "no balance was found, which excludes no oscillation" in ax.get_legend_handles_labels()[1]


def test_a_locus_out_of_sight_is_named(ax):
    # H = 1/(s (s+1) (s+2)) stays within reach of 0, and the locus of a gain of 1e-6 begins at -1e6
    plot_hint(describing_hint(RationalPlant([1], [1, 3, 2, 0]), Saturation(gain=Fraction(1, 10**6))), ax=ax)
    assert any("out of the picture" in text.get_text() for text in ax.texts)


def test_a_hint_made_by_hand_has_nothing_to_draw():
    with pytest.raises(InputError, match="take it from describing_hint"):
        DescribingHint(balances=(), crossings=()).plot()

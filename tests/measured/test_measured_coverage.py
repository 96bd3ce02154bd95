"""How often the sector of measured data holds smooth nonlinearities, which are not of the class that is assumed."""

import json

import numpy as np
import pytest
from depth import sampled

from lure.analysis.measured import Measurements, margin_from_data, sector_from_data
from lure.analysis.plots.measured import plot_measured

R = 1e-3
EVEN = {rows: np.linspace(-R, R, rows) for rows in (60, 200)}
UNEVEN = np.sort(np.random.default_rng(1).uniform(-0.3 * R, R, 120))
# nonlinearity and displacements; chords and slopes below are least and largest, by hand
TANH = (lambda u: 20 * np.tanh(5 * u / R), EVEN[200])
HERTZ = (lambda u: 3e6 * np.maximum(u, 0) ** 1.5, UNEVEN)
STRETCHED = (lambda u: 10 * np.expm1(3 * u / R), EVEN[60])
TOP = float(UNEVEN[-1])
TRUTH = {
    # 20 tanh(5 s)/s falls from 100 at s = 0 to 20 tanh 5 at s = 1, its slope 100/cosh(5 s)^2 likewise [N/mm]
    "tanh": (TANH, (20e3 * np.tanh(5), 100e3), (100e3 / np.cosh(5) ** 2, 100e3)),
    "Hertz": (HERTZ, (0, 3e6 * TOP**0.5), (0, 4.5e6 * TOP**0.5)),
    # chords of 10 (exp(3 s) - 1) from s = -1 to 1, slopes 30 exp(3 s) [N/mm]
    "stretched": (STRETCHED, (-10e3 * np.expm1(-3), 10e3 * np.expm1(3)), (30e3 * np.exp(-3), 30e3 * np.exp(3))),
}
# noise, as a share of the largest load, at which bounds without the next term of the expansion fail most
WORST = {"tanh": 0.004, "Hertz": 0.002, "stretched": 0.004}


def bounded(name, seed, noise):
    nonlinearity, sigma = TRUTH[name][0]
    load = nonlinearity(sigma)
    errors = np.random.default_rng([7, seed]).standard_normal(sigma.size)
    return sector_from_data(Measurements.from_arrays(sigma, load + noise * np.abs(load).max() * errors))


def holds(found, name):
    _, chords, slopes = TRUTH[name]
    return (
        found.lower.bound <= chords[0]
        and chords[1] <= found.upper.bound
        and found.slope_lower.bound <= slopes[0]
        and slopes[1] <= found.slope_upper.bound
    )


# of 10 sets 9 or 10 are expected inside; 7 or fewer is a chance of 1 in 87 at exactly 95 %
@pytest.mark.parametrize("name", TRUTH)
@pytest.mark.slow
def test_smooth_laws_lie_inside_where_interpolation_alone_misses_them(name):
    assert sum(holds(bounded(name, seed, WORST[name]), name) for seed in range(10)) >= 8


# a confidence of 95 % that is stated may be wrong in 5 of 100 sets; at exactly 95 %, 11 or more of 100 are a chance of
# 1 in 90, and 5 or more of 25 one of 1 in 140
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "noise"),
    [
        pytest.param(name, noise, marks=[] if noise == (0.003 if name == "Hertz" else 0.01) else pytest.mark.thorough)
        for name in TRUTH
        for noise in (0.05, 0.01, 0.003, 0.001)
    ],
)
def test_a_stated_confidence_is_kept(name, noise):
    count = sampled(25, of=100)
    found = [bounded(name, seed, noise) for seed in range(count)]
    assert sum(one.resolved and not holds(one, name) for one in found) <= {25: 4, 100: 10}[count]


# wide bounds would cover, too: with noise of 1 % chords and slopes of tanh are known to a third and a half
def test_the_bounds_of_a_smooth_law_are_not_wide():
    found = bounded("tanh", 0, 0.01)
    assert found.upper.bound < 1.35 * 100e3
    assert found.slope_upper.bound < 1.5 * 100e3
    assert found.slope_lower.bound > -0.25 * 100e3


@pytest.mark.slow
def test_no_confidence_is_stated_for_a_law_that_bends_within_its_pieces():
    found = bounded("stretched", 0, 0.001)
    assert not found.resolved
    assert "is estimated to lie in the sector" in found.conclusion
    assert "no confidence is stated" in found.conclusion
    assert "95 %" not in str(found)
    assert "95 %" not in found._repr_html_()
    assert "without a stated confidence" in found._repr_html_()
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert (document["confidence"], document["resolved"]) == (None, False)
    assert found.to_xarray().attrs["confidence"] == "none is stated"
    answer = margin_from_data(found, ([1], [1, 3, 2, 0]), gain=1e-6, assume_nonnegative=True)
    assert "observed without a stated confidence" in answer.conclusion


def test_the_command_does_not_call_such_bounds_shown(tmp_path, capsys):
    from lure.analysis.cli import main

    data = bounded("stretched", 0, 0.001).measurements
    rows = [f"{u!r},{p!r}" for u, p in zip(data.displacement.tolist(), data.load.tolist(), strict=True)]
    path = tmp_path / "bent.csv"
    path.write_text("\n".join(["displacement [m],force [N]", *rows]))
    assert main(["sector", str(path)]) == 10
    assert "no confidence is stated" in " ".join(capsys.readouterr().out.split())


def test_a_figure_of_such_a_law_says_so():
    from matplotlib.figure import Figure

    figure = Figure()
    above, _ = plot_measured(bounded("stretched", 0, 0.001), ax=figure.subplots())
    assert any("no confidence stated" in text.get_text() for text in above.texts)


def test_a_law_of_the_class_is_resolved():
    u = EVEN[200]
    noise = np.random.default_rng(0).standard_normal(u.size)
    found = sector_from_data(Measurements.from_arrays(u, 1e5 * np.maximum(u, 0) + noise))
    assert found.resolved
    assert found.to_dict()["confidence"] == 0.95
    assert found.conclusion.startswith("With 95 % confidence")


# sectors, by hand: round(s) is 1 at s = 1/2 and 0 below it, [0, 2], whatever the step; a relay that is 0 up to 1/2,
# [0, 2]. Twice as many pieces fit no better, and 95 % was stated of [0.32, 1.60], [0.92, 1.07] and [-1.08, 2.95]
@pytest.mark.parametrize(
    "stepped",
    [np.round, lambda u: np.round(4 * u) / 4, lambda u: np.where(np.abs(u) > 0.5, np.sign(u), 0)],
    ids=["quantiser", "fine quantiser", "relay with dead zone"],
)
def test_no_confidence_is_stated_for_a_nonlinearity_that_jumps(stepped):
    u = np.linspace(-2, 2, 200)
    errors = 0.001 * np.random.default_rng(0).standard_normal(200)
    found = sector_from_data(Measurements.from_arrays(u, stepped(u) + errors))
    assert not found.resolved
    assert "jumps" in str(found)


@pytest.mark.parametrize(("width", "rounded", "groups"), [(0.3, 0, 2), (0.005, 0, 1), (0.0, 0.05, 1)])
def test_a_loop_whose_rows_were_sorted_states_no_confidence(width, rounded, groups):
    # 4 cycles of friction, 0.3 to either side; loads that are rounded scatter evenly, and make no groups
    t = np.arange(200) * 2 * np.pi / 50
    u, noise = np.sin(t), np.random.default_rng(5).normal(0, 1e-2, t.size)
    p = 2 * u + width * np.sign(np.cos(t)) + (noise if not rounded else 0)
    p = rounded * np.round(p / rounded) if rounded else p
    order = np.argsort(u)
    found = sector_from_data(Measurements(displacement=u[order], load=p[order], unit="N", lines=np.arange(1, 201)))
    assert ("two groups" in str(found)) is (groups == 2)
    if not rounded:  # which makes jumps
        assert found.stated is (groups == 1)

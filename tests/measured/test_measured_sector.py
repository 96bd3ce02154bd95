"""The sector of measured data: true nonlinearities inside, tight, and warnings where an assumption is contradicted."""

import json
import math

import numpy as np
import pytest
from depth import rarely

from lure import AssumptionError, InputError, Sector, SlopeBounds
from lure.analysis.measured import (
    EXAMPLE,
    Measurements,
    example_measurements,
    fit_compliance,
    hysteresis_from_data,
    margin_from_data,
    report_from_data,
    sector_from_data,
)
from lure.analysis.measured.mean_nonlinearity import mean_nonlinearity
from lure.analysis.verdict import Evidence
from lure.arrays import one_thread

X = np.linspace(-1e-3, 1e-3, 200)
# nonlinearity, its chords and its slopes on [-1 mm, 1 mm], by hand; affine between a few knots, as is assumed
INSIDE = {
    "linear": (lambda u: 1e5 * u, (1e5, 1e5), (1e5, 1e5)),
    "one-sided": (lambda u: 1e5 * np.maximum(u, 0), (0, 1e5), (0, 1e5)),
    "two stiffnesses": (lambda u: np.where(u > 0, 3e5, 1e5) * u, (1e5, 3e5), (1e5, 3e5)),
}
# smooth ones: not in the class, but bent less between knots than the noise shows
SMOOTH = {
    "power 1.5": (lambda u: 3e6 * np.maximum(u, 0) ** 1.5, (0, 3e6 * 1e-3**0.5), (0, 4.5e6 * 1e-3**0.5)),
    "cubic": (lambda u: 2e4 * u + 1e11 * u**3, (2e4, 1.2e5), (2e4, 3.2e5)),
}


def measured(nonlinearity, seed, noise=0.05, sigma=X):
    load = nonlinearity(sigma)
    return Measurements.from_arrays(
        sigma, load + noise * np.abs(load).max() * np.random.default_rng([1, seed]).standard_normal(sigma.size)
    )


def holds(found, chords, slopes):
    return (
        found.lower.bound <= chords[0]
        and chords[1] <= found.upper.bound
        and found.slope_lower.bound <= slopes[0]
        and slopes[1] <= found.slope_upper.bound
    )


# 15 of 16 are expected; 12 or fewer is a chance of 1 in 100 at exactly 95 %
@pytest.mark.slow
@pytest.mark.parametrize("name", rarely([*INSIDE, *SMOOTH], "linear", "power 1.5"))
def test_the_true_bounds_lie_inside_as_often_as_is_stated(name):
    nonlinearity, chords, slopes = {**INSIDE, **SMOOTH}[name]
    hits = sum(holds(sector_from_data(measured(nonlinearity, seed)), chords, slopes) for seed in range(16))
    assert hits >= 13


# Bounds so wide that nothing is said also fail: a spring with 5 % noise is known to 10 %, one with 0.5 % to 1 %.
@pytest.mark.parametrize("noise", [0.05, 0.005])
def test_bounds_are_as_tight_as_the_noise_allows(noise):
    found = sector_from_data(measured(INSIDE["linear"][0], 3, noise))
    assert found.upper.bound - found.lower.bound < 5 * noise * 1e5
    assert found.slope_upper.bound - found.slope_lower.bound < 8 * noise * 1e5


def test_more_confidence_asks_for_wider_bounds():
    widths = [sector_from_data(measured(INSIDE["linear"][0], 0), confidence=c).sector for c in (0.5, 0.95, 0.999)]
    assert [w.upper for w in widths] == sorted({w.upper for w in widths})
    assert [w.lower for w in widths] == sorted({w.lower for w in widths}, reverse=True)


def test_nothing_is_divided_by_a_small_displacement():
    sigma = np.concatenate([X, np.full(20, 1e-12), np.full(20, -1e-9)])
    found = sector_from_data(measured(INSIDE["linear"][0], 2, sigma=sigma))
    assert holds(found, (1e5, 1e5), (1e5, 1e5))
    assert found.upper.bound < 1.5e5


def test_the_fitted_law_is_the_least_squares_one():
    data = measured(INSIDE["one-sided"][0], 1)
    nonlinearity = mean_nonlinearity(data.displacement, data.load, pieces=4)
    hats = np.array([np.interp(X, nonlinearity.knots, row) for row in np.eye(nonlinearity.knots.size)]).T[
        :, nonlinearity.knots != 0
    ]
    weights = 1 / nonlinearity.noise(nonlinearity(X))
    values = np.linalg.lstsq(hats * weights[:, None], data.load * weights, rcond=None)[0]
    np.testing.assert_allclose(
        nonlinearity.values[nonlinearity.knots != 0], values, rtol=1e-3, atol=1e-3 * values.max()
    )
    covariance = np.linalg.inv((hats * weights[:, None] ** 2).T @ hats)
    np.testing.assert_allclose(
        nonlinearity.covariance[np.ix_(nonlinearity.knots != 0, nonlinearity.knots != 0)],
        covariance,
        rtol=0.02,
        atol=1e-4,
    )


def test_units_scale_the_bounds():
    data = measured(SMOOTH["cubic"][0], 4)
    first = sector_from_data(data)
    second = sector_from_data(Measurements.from_arrays(1e3 * data.displacement, 1e-6 * data.load, unit="Pa"))
    for name in ("lower", "upper", "slope_lower", "slope_upper"):
        assert getattr(second, name).bound == pytest.approx(1e-9 * getattr(first, name).bound, rel=1e-6)


def test_outliers_are_named_and_do_not_count():
    clean = measured(INSIDE["one-sided"][0], 5, 0.01)
    load = clean.load.copy()
    load[[20, 150, 151]] += [30, -25, 40]
    found = sector_from_data(Measurements.from_arrays(X, load))
    assert [(o.index, o.line) for o in found.outliers] == [(20, 21), (150, 151), (151, 152)]
    assert [math.copysign(1, o.score) for o in found.outliers] == [1, -1, 1]
    assert abs(found.outliers[0].score) == pytest.approx(30, rel=0.25)  # 1 % of the largest load is 1 N
    assert "line 21" in str(found)
    assert found.upper.bound == pytest.approx(sector_from_data(clean).upper.bound, rel=0.01)


def test_a_corner_is_no_outlier():
    found = sector_from_data(measured(lambda u: np.clip(2e5 * u, -40, 40), 0, 0.02))
    assert not found.outliers


def loop(width, seed=0):
    """Loading and unloading `width` newtons apart in the middle, with noise of 1 N."""
    up = np.linspace(-2e-4, 1e-3, 120)
    u = np.concatenate([up, up[::-1]])
    bulge = width * np.clip(1 - np.abs(u - 5e-4) / 5e-4, 0, 1)
    load = 1e5 * np.maximum(u, 0) - np.where(np.arange(240) < 120, 0, bulge)
    return Measurements.from_arrays(u, load + np.random.default_rng([2, seed]).standard_normal(240))


def test_hysteresis_is_seen_where_there_is_any():
    data = loop(10)
    assert [(b.direction, b.start, b.stop) for b in data.branches] == [("loading", 0, 120), ("unloading", 120, 240)]
    found = hysteresis_from_data(data)
    assert found.width == pytest.approx(10, abs=2)
    assert found.at == pytest.approx(5e-4, abs=1.5e-4)
    assert found.dissipated == pytest.approx(10 * 5e-4, rel=0.2)  # a triangle: half of 10 N times 1 mm


def test_noise_is_no_hysteresis():
    assert not any(hysteresis_from_data(loop(0, seed)) for seed in range(8))


def test_with_memory_both_branches_are_inside_and_nothing_follows():
    found = sector_from_data(loop(10))
    assert not found.memoryless
    assert len(found.nonlinearities) == 2
    assert found.lower.bound < 0 < 1e5 < found.upper.bound
    assert "no criterion for memoryless nonlinearities" in str(found)
    answer = margin_from_data(found, ([1], [1, 3, 2]), gain=1e-9, assume_nonnegative=True)
    assert not answer.inside
    assert answer.conclusion.startswith("Nothing follows")


def test_rows_in_no_order_form_no_branches():
    order = np.random.default_rng(0).permutation(240)
    assert loop(10).taken(order).branches == ()
    assert measured(INSIDE["linear"][0], 0).branches == ()


def test_turning_points_of_several_cycles_despite_jitter():
    u = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, 0.3, 40), np.linspace(0.3, 1, 40), np.linspace(1, 0, 50)])
    jitter = u + 0.01 * np.random.default_rng(0).standard_normal(u.size)
    found = Measurements.from_arrays(jitter, u).branches
    assert [b.direction for b in found] == ["loading", "unloading", "loading", "unloading"]
    assert [b.start for b in found[1:]] == pytest.approx([50, 90, 130], abs=4)


def test_linear_algebra_runs_on_one_thread():
    from threadpoolctl import threadpool_info

    def threads():
        return {info["num_threads"] for info in threadpool_info() if info["user_api"] == "blas"}

    before = threads()
    assert one_thread(threads)() == {1}
    assert threads() == before
    assert hasattr(sector_from_data, "__wrapped__")
    assert hasattr(fit_compliance, "__wrapped__")


def test_a_load_at_zero_leaves_no_finite_sector_until_it_is_taken_off():
    found = sector_from_data(measured(lambda u: 1e5 * u + 20, 0, 0.01))
    assert (found.lower.bound, found.upper.bound) == (-math.inf, math.inf)
    assert "not 0: such a nonlinearity lies in no finite sector" in str(found)
    assert found.slope_upper.bound < 1.2e5
    with pytest.raises(AssumptionError, match="no lower bound"):
        margin_from_data(found, ([1], [1, 3, 2]))
    assert holds(sector_from_data(measured(lambda u: 1e5 * u + 20, 0, 0.01), origin=-2e-4), (1e5, 1e5), (1e5, 1e5))


def test_correlated_errors_are_seen():
    white = np.random.default_rng(3).standard_normal(400)
    errors = np.convolve(white, 0.9 ** np.arange(60), "full")[:400]
    u = np.linspace(-1e-3, 1e-3, 400)
    found = sector_from_data(Measurements.from_arrays(u, 1e5 * u + 2 * errors), pieces=4)
    assert "correlated" in str(found)
    assert holds(found, (1e5, 1e5), (1e5, 1e5))


def test_exact_data_give_exact_bounds():
    found = sector_from_data(Measurements.from_arrays(X, 1e5 * np.maximum(X, 0)))
    assert found.upper.bound == pytest.approx(1e5, rel=1e-6)
    assert found.lower.bound == pytest.approx(0, abs=1)


# y = x and 2 x at whole numbers: not even rounding scatters the loads, and a noise of 0 would divide by itself
@pytest.mark.parametrize("gain", [1, 2])
def test_data_without_any_scatter_have_bounds_that_are_numbers(gain):
    u = np.arange(20.0)
    found = sector_from_data(Measurements.from_arrays(u, gain * u))
    assert found.sector.lower <= gain <= found.sector.upper
    assert found.sector.upper - found.sector.lower < 1e-9


def test_what_is_said_and_what_is_not():
    found = sector_from_data(example_measurements())
    assert found.evidence is Evidence.OBSERVED
    assert found.sector == Sector(found.lower.bound, found.upper.bound)
    assert found.slope == SlopeBounds(found.slope_lower.bound, found.slope_upper.bound)
    assert "nothing is known outside this range (observed, not proved)" in found.conclusion
    # the largest chord of max(u - 0.12 mm, 0)^1.5/2.5e-7 up to 0.8 mm is at the end: F = 70.93 N over 0.8 mm
    assert pytest.approx(88663, rel=1e-4) == 0.00068**1.5 / 2.5e-7 / 0.0008
    assert 88663 < found.upper.bound < 1.05 * 88663
    assert found.lower.bound < 0


# 1/(s (s + 1) (s + 2)), the sector [0, 6): Hurwitz is k < 6, and Popov's criterion reaches it
def test_from_measurement_to_verdict():
    found = sector_from_data(measured(INSIDE["one-sided"][0], 1))
    plant = ([1], [1, 3, 2, 0])
    inside = margin_from_data(found, plant, gain=3e-5, assume_nonnegative=True)
    assert inside.inside
    assert inside.margin == pytest.approx(6 / (3e-5 * found.upper.bound) - 1, rel=1e-4)
    assert "wrong sign is assumed" in inside.conclusion
    assert inside.evidence is Evidence.OBSERVED
    beyond = margin_from_data(found, plant, gain=7e-5, assume_nonnegative=True)
    assert not beyond.inside
    assert "does not show that the loop is unstable" in beyond.conclusion
    without = margin_from_data(found, plant, gain=3e-5)
    assert found.lower.bound < 0
    assert not without.inside
    assert "give a lower gain" not in without.conclusion  # the lower end is measured, not chosen
    assert "sigma phi(sigma) >= 0, give assume_nonnegative=True: the sector then begins at 0" in without.conclusion
    hopeless = margin_from_data(found, ([1], [1, -1, 2]), gain=3e-5)
    assert "no linear gain stabilises it" in hopeless.conclusion
    assert "assume_nonnegative" not in hopeless.conclusion
    json.dumps(inside.to_dict(), allow_nan=False)


# x' = 1.5 x + phi: stable with the gains below -1.5 alone, while the chords are -2 on one side and -1.2 on the other
def test_a_measured_sector_below_0_is_not_inside_one_that_ends_before_it():
    u = np.linspace(-1, 1, 60)
    noise = np.random.default_rng(0).normal(scale=1e-3, size=60)
    found = sector_from_data(Measurements.from_arrays(u, np.where(u < 0, -1.2, -2) * u + noise))
    apart = margin_from_data(found, ([-1], [1, -1.5]))
    assert apart.proved.largest.low == pytest.approx(-1.5)
    assert apart.margin == pytest.approx(-0.25, abs=0.01)  # (-1.5 + 1.2)/1.2
    assert not apart.inside
    wider = margin_from_data(found, ([-1], [1, -1.1]))  # stable below -1.1
    assert wider.inside
    assert wider.margin == pytest.approx(1 / 12, abs=0.01)  # (-1.1 + 1.2)/1.2


# of 12 rows of a kink in noise the test of the pieces sees none, and the bounds held it in 1 of 3 sets
@pytest.mark.parametrize(("rows", "places", "sure"), [(12, 12, False), (40, 6, False), (40, 40, True)])
def test_no_confidence_is_stated_where_the_rows_cannot_show_a_bend(rows, places, sure):
    u = np.resize(np.linspace(-1, 1, places), rows)
    found = sector_from_data(Measurements.from_arrays(u, u + np.random.default_rng(0).normal(scale=0.1, size=rows)))
    assert found.stated is found.resolved is sure
    assert ("the rows are too few to see it bend" in found.conclusion) is not sure
    assert any("measure at least 24 rows" in text for text in found.warnings) is not sure


def test_a_gap_in_which_nothing_was_measured_is_named():
    u = np.concatenate([np.linspace(-1, -0.8, 30), np.linspace(0.8, 1, 30)])
    noise = np.random.default_rng(0).normal(scale=1e-2, size=60)
    found = sector_from_data(Measurements.from_arrays(u, u + noise))
    assert [text.partition(":")[0] for text in found.warnings] == ["No row lies between sigma = -0.8 and 0.8 m"]
    closed = np.linspace(-1, 1, 60)
    assert not sector_from_data(Measurements.from_arrays(closed, closed + noise)).warnings


# four copies have the mean of one of them, and would have half of its error, were they independent
def test_copies_of_a_file_say_no_more_than_the_file():
    u = np.linspace(-1, 1, 60)
    load = u + np.random.default_rng(0).normal(scale=0.1, size=60)
    once, often = (
        sector_from_data(Measurements.from_arrays(np.tile(u, n), np.tile(load, n)), pieces=2) for n in (1, 4)
    )
    assert "Each row is there 4 times or more" in str(often)
    assert "Each row" not in str(once)
    assert often.upper.bound - often.lower.bound > 0.9 * (once.upper.bound - once.lower.bound)


def test_a_load_that_is_0_throughout_is_refused():
    with pytest.raises(InputError, match="the load is 0 N in every row"):
        sector_from_data(Measurements.from_arrays(X, 0 * X))


@pytest.mark.slow
def test_the_report_holds_everything():
    found = report_from_data(EXAMPLE, fit=True, origin="gap")
    assert found.sector.origin == found.fit.parameters["gap"].value
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["schema"] == "lure-measured/1"
    assert document["sector"]["evidence"] == document["fit"]["evidence"] == "observed"
    assert document["sector"]["upper"]["bound"] == found.sector.upper.bound
    assert str(found.fit) in str(found)
    assert report_from_data(EXAMPLE).fit is None


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"confidence": 1.0}, "confidence is 1.0; give a number between"),
        ({"confidence": 95}, "confidence is 95"),
        ({"origin": math.nan}, "origin is nan"),
    ],
)
def test_what_cannot_be_asked_is_refused(options, message):
    with pytest.raises(InputError, match=message):
        sector_from_data(example_measurements(), **options)


def test_too_few_rows_are_refused():
    with pytest.raises(InputError, match="have 5 rows and 5 different displacements"):
        sector_from_data(Measurements.from_arrays(np.arange(5.0), np.arange(5.0)))
    with pytest.raises(InputError, match="row 1 is"):
        Measurements.from_arrays([0.0, math.nan], [0.0, 1.0])
    with pytest.raises(InputError, match="origin is 'zero'"):
        report_from_data(EXAMPLE, origin="zero")

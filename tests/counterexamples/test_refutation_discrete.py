"""Orbits that destabilise in discrete time: exact, of the published slopes, and rejected when anything is off."""

import itertools
import math
from fractions import Fraction as F

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import CIRCLE, DISCRETE, discrete
from scipy.optimize import linprog

from lure.analysis.counterexamples.matrix_game import (
    all_patterns,
    basis,
    neighbours,
    pattern_count,
    sinusoids,
    solve_games,
)
from lure.analysis.counterexamples.orbit import (
    PiecewiseLinear,
    accept_orbit,
    shifted_block,
    steady_state,
    verify_periodic_discrete,
)
from lure.analysis.counterexamples.periodic_discrete import (
    periodic_witness_discrete,
    proposals,
    sector_witness_discrete,
)
from lure.analysis.counterexamples.switched import switched_witness_discrete
from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.numerics.doubles import double_above
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

POINTS = [("-74498/72625", "-192/415"), ("-36864/72625", "-192/415"), ("192/175", "1")]
ORBIT = ("192/415", "192/415", "-1")


@pytest.fixture(scope="module")
def found():
    """The witness for each plant and parity."""
    return {
        (i, odd): periodic_witness_discrete(DISCRETE[i], odd=odd, periods=range(1, 9))
        for i in DISCRETE
        for odd in (False, True)
    }


def closed_loop(plant, nonlinearity, u, sigma, steps):
    """``sigma`` of the loop for a strictly proper plant, stepped exactly from the past of an orbit."""
    n = plant.order
    top = [F(0)] * (n + 1 - len(plant.numerator)) + list(plant.numerator)
    past_u, past = [u[-j % len(u)] for j in range(1, n + 1)], [sigma[-j % len(u)] for j in range(1, n + 1)]
    for _ in range(steps):
        pushed = sum(b * v for b, v in zip(top[1:], past_u, strict=True))
        value = pushed - sum(a * s for a, s in zip(plant.denominator[1:], past, strict=True))
        past_u, past = [-nonlinearity(value), *past_u[:-1]], [value, *past[:-1]]
        yield value


# k of example 6 is printed in benchmarks; the other rational ones are the slopes of the orbits of +-1 and +-2 that the
# search returned, checked by the loop stepped below; the irrational ones agree with the largest slope that a
# Zames-Falb multiplier proves to 1e-8 (13.0283737, .80274518, .31214485), so that no smaller ones exist.
@pytest.mark.slow_for("6-False-3-k0")
@pytest.mark.parametrize(
    ("plant", "odd", "period", "k"),
    [
        (6, False, 3, F(175, 192)),
        (1, True, 6, F(8281, 610)),
        (2, True, 4, F(331574081, 299891000)),
        (1, False, 7, 13.0283737),
        (2, False, 5, 0.8027451859),
        (3, False, 8, 0.3121448520),
        (3, True, 8, 0.3121448520),
    ],
)
def test_smallest_slopes_of_the_published_examples(found, plant, odd, period, k):
    witness = found[plant, odd]
    assert witness.evidence is Evidence.CERTIFIED
    assert witness.data["period"] == period
    assert witness.odd or not odd
    if isinstance(k, F):
        assert F(witness.data["k"]) == k
        assert F(witness.k) >= k > F(math.nextafter(witness.k, 0))
    assert witness.k == pytest.approx(float(k), rel=1e-8)
    assert verify_periodic_discrete(DISCRETE[plant], witness.data)


@pytest.mark.parametrize(("plant", "odd"), [(5, False), (5, True), (6, True)])
def test_nothing_below_the_linear_gain_where_a_multiplier_reaches_it(found, plant, odd):
    assert found[plant, odd] is None


@pytest.mark.parametrize(
    ("plant", "odd"), [(1, False), (1, True), (2, False), (2, True), (3, False), (3, True), (6, False)]
)
def test_loop_stepped_with_the_law_stays_on_the_orbit(found, plant, odd):
    witness = found[plant, odd]
    data = witness.data
    nonlinearity = PiecewiseLinear.through(((F(s), F(w)) for s, w in data["points"]), F(data["lower"]))
    u, sigma = [F(v) for v in data["u"]], [F(v) for v in data["sigma"]]
    for value, expected in zip(
        closed_loop(DISCRETE[plant], nonlinearity, u, sigma, 3 * len(u)), itertools.cycle(sigma)
    ):
        assert value == expected
    assert any(u)
    assert 0 <= nonlinearity.slopes[0] <= nonlinearity.slopes[1] == F(data["k"])
    assert nonlinearity.odd or not odd


def test_published_orbit_is_accepted_and_a_wrong_one_is_not():
    witness = accept_orbit(DISCRETE[6], POINTS, ORBIT)
    assert witness.data["k"] == "175/192"
    assert not witness.odd
    with pytest.raises(InputError, match="no orbit: sample 0"):
        accept_orbit(DISCRETE[6], [("-74498/72625", "-191/415"), *POINTS[1:]], ORBIT)
    with pytest.raises(InputError, match="exact numbers"):
        accept_orbit(DISCRETE[6], POINTS, ["192/415", "x", -1])
    with pytest.raises(InputError, match="orbit is zero"):
        accept_orbit(DISCRETE[6], POINTS, [0, 0])
    with pytest.raises(InputError, match="empty"):
        accept_orbit(DISCRETE[6], POINTS, [])
    with pytest.raises(InputError, match="no nonlinearity passes through both"):
        accept_orbit(DISCRETE[6], [*POINTS, ("192/175", 2)], ORBIT)
    with pytest.raises(InputError, match="discrete time"):
        accept_orbit(RationalPlant([1], [1, 1]), POINTS, ORBIT)
    with pytest.raises(AssumptionError, match="pole with z"):
        accept_orbit(RationalPlant([1], [1, -1], 1), POINTS, ORBIT)
    with pytest.raises(InputError, match="least slope -"):  # decreasing between the last two points
        accept_orbit(DISCRETE[6], [*POINTS, (2, 0)], ORBIT)


def record():
    return dict(accept_orbit(DISCRETE[6], POINTS, ORBIT).data)


@pytest.mark.parametrize("entry", ["k", "lower", "period", "odd", "slope_restricted", "points", "u", "sigma"])
def test_a_record_without_one_entry_is_rejected(entry):
    data = record()
    del data[entry]
    assert verify_periodic_discrete(DISCRETE[6], data) is False


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("k", "349999/384000"),  # just below 175/192
        ("k", "-1"),
        ("k", "1/0"),
        ("k", "nan"),
        ("lower", "1/1000"),  # the nonlinearity is flat to the left
        ("period", 6),
        ("odd", True),
        ("u", ["0", "0", "0"]),
        ("u", ["192/415", "-1", "192/415"]),
        ("u", []),
        ("points", [["0", "0"]]),
        ("points", [["-74498/72625", "-192/415"], ["-36864/72625", "-192/415"], ["192/175", "1"]]),
    ],
)
def test_a_record_with_one_wrong_entry_is_rejected(entry, value):
    assert verify_periodic_discrete(DISCRETE[6], record())
    assert verify_periodic_discrete(DISCRETE[6], record() | {entry: value}) is False


@given(st.sampled_from(["u", "sigma"]), st.integers(0, 2), st.fractions().filter(bool))
def test_a_record_with_one_sample_moved_is_rejected(name, place, by):
    data = record()
    values = list(data[name])
    values[place] = str(F(values[place]) + by)
    assert verify_periodic_discrete(DISCRETE[6], data | {name: values}) is False


@given(st.integers(0, 3), st.integers(0, 1), st.fractions().filter(bool))
def test_a_record_with_one_point_of_the_orbit_moved_is_rejected(place, side, by):
    data = record()
    points = [list(point) for point in data["points"]]
    points[place][side] = str(F(points[place][side]) + by)
    assert verify_periodic_discrete(DISCRETE[6], data | {"points": points}) is False


def test_an_orbit_of_another_plant_or_in_continuous_time_is_rejected():
    assert not verify_periodic_discrete(discrete("2 .93", "1 -.5 0"), record())
    assert not verify_periodic_discrete(RationalPlant([2, F("0.92")], [1, F("-0.5"), 0]), record())


def test_a_loop_without_solution_inside_the_class_is_rejected():
    # H = -1: sigma = -mu = phi(sigma) holds on the whole line for phi = sigma, and 1 + g H = 0 at g = 1 < k
    data = record() | {"k": "2", "period": 1, "u": ["-1"], "sigma": ["1"], "points": [["0", "0"], ["1", "1"]]}
    assert not verify_periodic_discrete(RationalPlant([-1], [1], 1), data)


def test_two_values_of_the_law_at_one_sigma_are_rejected():
    # sigma[t] = -u[t-1] - u[t-2] = 3 for u = -1, -2 repeated: in the sector [0, 1], but phi(3) cannot be both 1 and 2
    data = record() | {"k": "1", "period": 2, "u": ["-1", "-2"], "sigma": ["3", "3"], "slope_restricted": False}
    plant = RationalPlant([-1, -1], [1, 0, 0], 1)
    assert not verify_periodic_discrete(plant, data | {"points": [["0", "0"], ["3", "1"], ["3", "2"]]})
    same = data | {"u": ["-1", "-1"], "sigma": ["2", "2"], "points": [["0", "0"], ["2", "1"]]}
    assert verify_periodic_discrete(plant, same)  # an equilibrium beside zero


# sigma = H mu, so that c H has the orbits of H with sigma, and hence 1/k, multiplied by c
@pytest.mark.parametrize("c", [F(1, 1000), F(7, 3), F(10**6)])
def test_gain_may_be_moved_between_block_and_law(c):
    plant = RationalPlant([c * b for b in DISCRETE[6].numerator], DISCRETE[6].denominator, 1)
    witness = periodic_witness_discrete(plant, odd=False, periods=range(1, 6))
    assert F(witness.data["k"]) * c == F(175, 192)
    switched = switched_witness_discrete(plant)
    assert switched.k * float(c) == pytest.approx(125 / 192, rel=1e-6)


@pytest.mark.parametrize("shift", [F(1, 4), F(-2), F(50)])
def test_lower_bound_is_a_shift_of_the_loop(shift):
    moved = shifted_block(DISCRETE[6], -shift)  # its loop with phi + shift sigma is that of the plant with phi
    witness = periodic_witness_discrete(moved, odd=False, lower=shift, periods=range(1, 6))
    assert F(witness.data["k"]) == F(175, 192) + shift
    assert F(witness.data["lower"]) == shift
    assert verify_periodic_discrete(moved, witness.data)
    assert switched_witness_discrete(moved, lower=shift).k == pytest.approx(float(125 / F(192) + shift), rel=1e-6)


def test_in_the_critical_case_the_law_lies_inside_the_open_class():
    # example 1 plus (1/1000)/(z - 1): a simple pole at 1, which the mean-free odd orbit hardly sees
    plant = discrete(".101 -.1018 .00081", "1 -2.8 2.61 -.81")
    assert not is_stable_gain(plant, F(0))
    assert is_stable_gain(plant, F(1, 100))
    witness = periodic_witness_discrete(plant, odd=True, periods=range(1, 7))
    assert 0 < F(witness.data["lower"]) < F(1, 100)
    assert witness.k == pytest.approx(8281 / 610, rel=0.02)
    assert all(F(s) * F(w) > 0 for s, w in witness.data["points"] if F(s) != 0)
    assert verify_periodic_discrete(plant, witness.data)


@pytest.mark.slow
@pytest.mark.parametrize("plant", [1, 3, 5])
def test_sector_orbits_lie_between_the_circle_criterion_and_the_slope(found, plant):
    witness = sector_witness_discrete(DISCRETE[plant])
    assert CIRCLE[plant] < witness.k
    if found[plant, False] is not None:
        assert witness.k < found[plant, False].k
    assert not witness.slope_restricted
    assert verify_periodic_discrete(DISCRETE[plant], witness.data)
    data = dict(witness.data)
    assert not verify_periodic_discrete(DISCRETE[plant], data | {"k": str(F(data["k"]) * (1 - F(1, 10**12)))})


# example 6 at z = -1: H(-1) = (-2 + .92)/(1 + .5) = -.72; the circle criterion stops at k = 1/1.536 = 125/192, where a
# nonlinearity that is k sigma at every other step has the orbit sigma, 0, ...
def test_sector_orbit_of_example_6_is_exact():
    assert F(sector_witness_discrete(DISCRETE[6]).data["k"]) == F(125, 192)


@pytest.mark.slow
@given(st.integers(1, 8), st.integers(0, 10**6))
@settings(max_examples=40)
def test_values_of_matrix_games_agree_with_a_linear_program(n, seed):
    games = np.random.default_rng(seed).integers(-4, 5, (5, n, n)).astype(float)
    solved = solve_games(games)
    for game, value, mixture in zip(games, solved.value, solved.mixture, strict=True):
        rows = np.hstack([-game, np.ones((n, 1))])
        program = linprog(
            np.r_[np.zeros(n), -1],
            A_ub=rows,
            b_ub=np.zeros(n),
            A_eq=[np.r_[np.ones(n), 0]],
            b_eq=[1],
            bounds=[(0, None)] * n + [(None, None)],
        )
        assert value == pytest.approx(-program.fun, abs=1e-9)
        assert (game @ mixture).min() == pytest.approx(value, abs=1e-9)
        assert mixture.min() >= 0
        assert mixture.sum() == pytest.approx(1)


@pytest.mark.parametrize("family", ["monotone", "odd", "sector"])
@pytest.mark.parametrize("p", [1, 2, 3, 4])
def test_patterns_hold_every_order_once_up_to_shifts(p, family):
    """Random values, shifted so that the largest comes first, have the order of exactly one pattern."""
    patterns = basis(all_patterns(p, family), family)
    assert len(patterns) == pattern_count(p, family)
    rng = np.random.default_rng(p)
    for _ in range(50):
        values = rng.standard_normal(p)
        values = np.roll(values, -int(np.argmax(values if family == "monotone" else abs(values))))
        if family != "monotone":
            values *= np.sign(values[0])
        inside = [bool((np.linalg.solve(V, values) >= 0).all()) for V in patterns]
        assert sum(inside) == 1


@given(st.integers(2, 9), st.sampled_from(["monotone", "odd", "sector"]), st.integers(0, 10**6))
def test_bases_are_unimodular_and_span_the_order_of_their_values(p, family, seed):
    values = np.random.default_rng(seed).standard_normal(p)
    stack = np.vstack([values[None], sinusoids(p, 1, family), neighbours(values, family)])
    V = basis(stack, family)
    assert np.allclose(abs(np.linalg.det(V)), 1)
    assert (np.linalg.solve(V[0], values) > 0).all()


@given(st.lists(st.fractions(-3, 3, max_denominator=9), min_size=1, max_size=6, unique=True), st.data())
def test_law_passes_its_points_and_keeps_its_bounds(sigmas, data):
    points = [(s, data.draw(st.fractions(-3, 3, max_denominator=9))) for s in sigmas if s != 0]
    nonlinearity = PiecewiseLinear.through(points, F(1, 2))
    low, high = nonlinearity.slopes
    chord_low, chord_high = nonlinearity.sector
    assert all(nonlinearity(s) == w for s, w in points)
    x, y = (data.draw(st.fractions(-5, 5, max_denominator=20)) for _ in range(2))
    if x != y:
        assert low <= (nonlinearity(x) - nonlinearity(y)) / (x - y) <= high
    if x != 0:
        assert chord_low <= nonlinearity(x) / x <= chord_high
    odd = PiecewiseLinear.through([(abs(s), w) for s, w in dict(points).items() if s > 0], F(1, 2), odd=True)
    assert odd.odd
    assert odd(-x) == -odd(x)


@given(st.fractions())
def test_rounding_up_is_the_least_double_not_below(value):
    assert F(double_above(value)) >= value
    assert F(math.nextafter(double_above(value), -math.inf)) < value


def test_steady_state_satisfies_the_difference_equation_by_convolution():
    # H = 1/(z - 1/2): impulse response (1/2)^(t-1), so that u = (1, 0) repeated gives sigma = (2/3, 4/3)
    assert steady_state(RationalPlant([1], [1, F(-1, 2)], 1), [F(1), F(0)]) == [F(2, 3), F(4, 3)]


# The games of (1 + 1/z + 1/z^2 + 1/z^3)/4 are degenerate, and rounding leaves one of them without a row to exchange.
# With the gain 4 the poles are fifth roots of unity; every orbit proposed has to have a smaller one.
@pytest.mark.slow
def test_degenerate_games_give_no_warning_and_nothing_by_rounding_alone():
    block = RationalPlant([F(1, 4)] * 4, [1, 0, 0, 0, 0], dt=1)
    found = proposals(block, ("sector",), 4.0, tuple(range(1, 25)))
    assert all(1 / proposal.reach < 4 for proposal in found)

"""lure.analysis.describing: the describing function as a hint, checked against integrals and python-control."""

import math
from fractions import Fraction

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from lure import AssumptionError, InputError, Sector
from lure.analysis.describing import DescribingHint, describing_function, describing_hint
from lure.analysis.verdict import Evidence
from lure.nonlinearities import (
    Cubic,
    DeadZone,
    ExpressionNonlinearity,
    LeakyReLU,
    PiecewiseLinear,
    Quantiser,
    Saturation,
    Tanh,
    relay_with_slope,
    shifted_nonlinearity,
)
from lure.plants.rational import RationalPlant

THIRD_ORDER = RationalPlant([10], [1, 3, 2, 0])
sizes = st.fractions(Fraction(1, 20), 20, max_denominator=20)
amplitudes = st.floats(0.01, 100)


@st.composite
def odd_polygons(draw):
    xs = sorted(draw(st.sets(sizes, min_size=1, max_size=4)))
    right = [(x, draw(st.fractions(-9, 9, max_denominator=9))) for x in xs]
    slope = draw(st.integers(200, 210))  # steeper than 9 over 1/20, so that the polygon is no straight line
    return PiecewiseLinear([*((-x, -y) for x, y in right[::-1]), (0, 0), *right], left_slope=slope, right_slope=slope)


odd_laws = st.one_of(
    st.builds(Saturation, gain=sizes, limit=sizes),
    st.builds(DeadZone, width=sizes, gain=sizes),
    st.builds(Cubic, linear=sizes, cubic=sizes),
    st.builds(Tanh, scale=sizes, gain=sizes),
    st.builds(Quantiser, step=sizes),
    odd_polygons(),
)


# an odd nonlinearity: the integral over a half period is twice that over a quarter, so N(A) = (4/(pi A)) (pi/2) mean
@given(nonlinearity=odd_laws, amplitude=amplitudes)
def test_the_describing_function_is_its_integral(nonlinearity, amplitude):
    t = (np.arange(50000) + 0.5) * (math.pi / 2 / 50000)
    sine = np.sin(t)
    integral = float((nonlinearity(amplitude * sine) * sine).mean()) * 2 / amplitude
    # the midpoint rule: within 1e-8 at kinks; at a jump it misses up to half a cell of length 3e-5
    rel, absolute = (1e-5, 3e-4) if isinstance(nonlinearity, Quantiser) else (1e-7, 1e-8)
    assert float(describing_function(nonlinearity, amplitude)) == pytest.approx(integral, rel=rel, abs=absolute)


@given(nonlinearity=odd_laws, amplitude=amplitudes)
def test_it_lies_in_the_sector_of_the_law(nonlinearity, amplitude):
    value = float(describing_function(nonlinearity, amplitude))
    room = 1e-12 * (1 + abs(value))
    assert float(nonlinearity.sector.lower) - room <= value <= float(nonlinearity.sector.upper) + room


# N is a mean of chord slopes, linear in the nonlinearity: a shifted nonlinearity has the shifted N, a saturation and
# its dead zone sum to the line
@given(nonlinearity=odd_laws, amplitude=amplitudes, gain=sizes)
def test_a_shift_of_the_law_shifts_it(nonlinearity, amplitude, gain):
    shifted = shifted_nonlinearity(nonlinearity, gain)
    expected = float(describing_function(nonlinearity, amplitude)) - float(gain)
    assert float(describing_function(shifted, amplitude)) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@given(gain=sizes, limit=sizes, amplitude=amplitudes)
def test_python_control_agrees_on_saturation(gain, limit, amplitude):
    ours = float(describing_function(Saturation(gain=1, limit=limit), amplitude))
    theirs = complex(control.describing_function(control.saturation_nonlinearity(float(limit)), amplitude))
    assert ours == pytest.approx(theirs.real, rel=1e-9, abs=1e-12)
    assert theirs.imag == pytest.approx(0, abs=1e-12)
    scaled = float(describing_function(Saturation(gain=gain, limit=gain * limit), amplitude))
    assert scaled == pytest.approx(float(gain) * ours, rel=1e-9)


# a relay of level 1 has 4/(pi A); a steep saturation and a steep tanh come to it.  A cubic: 3/4 A^2
def test_values_by_hand():
    assert float(describing_function(relay_with_slope(gain=10**8, level=1), 2.0)) == pytest.approx(
        2 / math.pi, rel=1e-12
    )
    assert float(describing_function(Tanh(scale=Fraction(1, 10**8)), 2.0)) == pytest.approx(2 / math.pi, rel=1e-12)
    assert describing_function(Cubic(linear=1, cubic=2), [1.0, 2.0]).tolist() == [2.5, 7.0]
    assert describing_function(Saturation(gain=3), 0.1) == 3
    # one level: (4 q/(pi A)) sqrt(1 - (q/2A)^2), at A = q/sqrt(2) its largest value 4/pi; below q/2 nothing
    assert describing_function(Quantiser(step=3), [1.4, 3 / math.sqrt(2)]) == pytest.approx([0, 4 / math.pi], abs=1e-12)
    # two routes to the same nonlinearity
    same = ExpressionNonlinearity("tanh(100*sigma)", sector=Sector(0, 100), odd=True)
    a = np.logspace(-4, 2, 13)
    assert describing_function(same, a) == pytest.approx(
        describing_function(Tanh(scale=Fraction(1, 100)), a), rel=1e-12
    )


# a relay with the dead zone 1/2, of level 1: (4/(pi A)) sqrt(1 - 1/(4 A^2)); 1.10791 was returned for A = 1
def test_formulas_that_jump_are_integrated_up_to_their_jumps():
    found = describing_function("where(abs(sigma) > 0.5, sign(sigma), 0)", [0.4, 1.0, 3.0])
    assert found == pytest.approx(
        [0, 4 / math.pi * math.sqrt(0.75), 4 / (3 * math.pi) * math.sqrt(1 - 1 / 36)], rel=1e-9
    )
    assert describing_function("sigma*abs(sigma)", 2.0) == pytest.approx(16 / (3 * math.pi))  # 8 A/(3 pi)
    with pytest.raises(AssumptionError, match="not known to be odd"):
        describing_function("sigma**2", 1.0)


def test_the_quantiser_far_out_is_the_identity():
    # where the sum over the jumps is cut short, at 2000 steps, both sides of the cut agree to 1e-4
    assert describing_function(Quantiser(), [1999.7, 2000.3, 1e9]) == pytest.approx(1, abs=1e-4)


# H(i sqrt 2) = 10/(-3*2) = -5/3, so N = 3/5: for the saturation (2/pi)(asin r + r sqrt(1-r^2)) = 0.6
def test_the_balance_of_a_third_order_loop_is_found():
    hint = describing_hint(THIRD_ORDER, Saturation())
    (balance,) = hint.balances
    assert balance.frequency == pytest.approx(math.sqrt(2), rel=1e-14)
    assert balance.gain == pytest.approx(0.6, rel=1e-14)
    r = 1 / balance.amplitude
    assert (2 / math.pi) * (math.asin(r) + r * math.sqrt(1 - r * r)) == pytest.approx(0.6, rel=1e-12)
    # N falls with the amplitude, and the linear loop is unstable above 0.6: growth inside, decay outside
    assert balance.stable_guess is True
    ((frequency, value),) = hint.crossings
    assert (frequency, value) == pytest.approx((math.sqrt(2), -5 / 3))


def test_python_control_finds_the_same_balance():
    found = control.describing_function_response(
        THIRD_ORDER.to_control(), control.saturation_nonlinearity(1), np.linspace(1, 10, 50)
    )
    ((amplitude, omega),) = found.intersections
    (balance,) = describing_hint(THIRD_ORDER, Saturation()).balances
    assert (balance.amplitude, balance.frequency) == pytest.approx((amplitude, omega), rel=1e-4)


def test_a_hardening_law_makes_the_balance_repel():
    # the dead zone: N rises with the amplitude, so that a larger motion grows
    (balance,) = describing_hint(THIRD_ORDER, DeadZone()).balances
    assert balance.stable_guess is False


# a relay of level 1 has N = 4/(pi A), so that A = (4/pi) |H| = 20/(3 pi)
def test_the_balance_with_a_relay_is_known():
    (balance,) = describing_hint(THIRD_ORDER, relay_with_slope(gain=1000, level=1)).balances
    assert balance.amplitude == pytest.approx(20 / (3 * math.pi), rel=1e-5)


# |H(3 i sqrt 2)| is 0.07 of |H(i sqrt 2)|: the third harmonic is filtered out, and the hint comes true within 5 %
@pytest.mark.slow
def test_a_loop_that_filters_its_harmonics_settles_near_the_balance():
    nonlinearity = Saturation()
    (balance,) = describing_hint(THIRD_ORDER, nonlinearity).balances

    def motion(_, x):
        return [x[1], x[2], -2 * x[1] - 3 * x[2] - 10 * float(nonlinearity(x[0]))]

    t = np.linspace(80, 100, 4001)
    sigma = solve_ivp(motion, (0, 100), [0.1, 0, 0], t_eval=t, rtol=1e-8, atol=1e-10).y[0]
    rises = t[1:][(sigma[:-1] < 0) & (sigma[1:] >= 0)]
    assert sigma.max() == pytest.approx(balance.amplitude, rel=0.05)
    assert 2 * math.pi / np.diff(rises).mean() == pytest.approx(balance.frequency, rel=0.05)


@given(speed=st.fractions(Fraction(1, 50), 50), size=sizes, gain=sizes)
def test_units_of_time_and_size_only_rescale_the_balance(speed, size, gain):
    (plain,) = describing_hint(THIRD_ORDER, Saturation()).balances
    # H(s/speed)/gain with the nonlinearity gain*size*phi(sigma/size)
    fast = RationalPlant([10 * speed**3 / gain], [1, 3 * speed, 2 * speed**2, 0])
    (scaled,) = describing_hint(fast, Saturation(gain=gain, limit=gain * size)).balances
    assert scaled.frequency == pytest.approx(float(speed) * plain.frequency, rel=1e-12)
    assert scaled.amplitude == pytest.approx(float(size) * plain.amplitude, rel=1e-9)
    assert scaled.stable_guess is plain.stable_guess


def test_two_amplitudes_of_one_frequency_are_both_found():
    # dead zone with saturation: N rises from 0 to a peak above 0.6 and falls again
    nonlinearity = PiecewiseLinear([(-2, -2), (-1, 0), (1, 0), (2, 2)], left_slope=0, right_slope=0)
    first, second = describing_hint(THIRD_ORDER, nonlinearity).balances
    assert first.amplitude < second.amplitude
    assert (first.stable_guess, second.stable_guess) == (False, True)


# It is no oracle.


def fitts():
    """s^2 / (((s + .03)^2 + .81)((s + .03)^2 + 1.21)); with tanh(100 sigma) the loop oscillates with period 11.917."""
    b = Fraction(3, 100)
    first, second = ([1, 2 * b, b * b + Fraction(c, 100)] for c in (81, 121))
    bottom = [sum(first[i] * second[n - i] for i in range(3) if 0 <= n - i < 3) for n in range(5)]
    return RationalPlant([1, 0, 0], bottom)


def test_fitts_counterexample_oscillates_without_a_balance():
    hint = describing_hint(fitts(), Tanh(scale=Fraction(1, 100)))
    assert hint.balances == ()
    assert str(hint) == "hint, not a verdict: no harmonic balance was found, which does not exclude an oscillation"


def test_a_pole_on_the_axis_is_no_crossing():
    # (10.1 s^3 + 10 s^2)/((s^2 + 1)(s^2 + s + 1)), Leonov, Bragin and Kuznetsov: it oscillates, too
    block = RationalPlant([Fraction(101, 10), 10, 0, 0], [1, 1, 2, 1, 1])
    hint = describing_hint(block, Saturation())
    assert hint.balances == ()
    assert all(abs(frequency - 1) > 1e-3 and math.isfinite(value) for frequency, value in hint.crossings)


def test_it_is_a_hint_and_says_so():
    hint = describing_hint(THIRD_ORDER, Saturation())
    assert not hasattr(hint, "verdict")
    assert hint.evidence is Evidence.OBSERVED
    assert str(hint) == (
        "hint, not a verdict: harmonic balance at amplitude 2.03309 at 1.41421 rad/s, perhaps attracting"
    )
    with pytest.raises(TypeError, match=r"^a describing function is a hint, not a verdict"):
        bool(hint)
    for evidence in (Evidence.COMPUTED, Evidence.CERTIFIED):
        with pytest.raises(ValueError, match=r"never more than observed"):
            DescribingHint(balances=(), crossings=(), evidence=evidence)
    for documented in (DescribingHint, describing_hint):
        assert "hint, not a verdict" in documented.__doc__


def test_what_it_is_not_stated_for_is_refused():
    with pytest.raises(AssumptionError, match=r"^the describing function needs an odd nonlinearity, and leaky ReLU"):
        describing_hint(THIRD_ORDER, LeakyReLU())
    with pytest.raises(AssumptionError, match=r"^H is real on the whole axis"):
        describing_hint(RationalPlant([1], [1, 0, 1]), Saturation())
    with pytest.raises(InputError, match=r"^describing_hint is stated for continuous time"):
        describing_hint(RationalPlant([1], [1, 2], 1), Saturation())
    for amplitude in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match=r"an amplitude is not a positive finite number"):
            describing_function(Saturation(), [1.0, amplitude])


def test_a_quadrature_of_another_kind_agrees_on_a_formula():
    nonlinearity = ExpressionNonlinearity("sigma*abs(sigma)", sector=Sector(0, math.inf), odd=True)
    # (4/(pi A)) int_0^(pi/2) A^2 sin^3 = 8 A/(3 pi)
    assert describing_function(nonlinearity, [0.5, 3.0]) == pytest.approx([4 / (3 * math.pi), 8 / math.pi], rel=1e-12)
    integral = quad(lambda t: float(nonlinearity(3 * math.sin(t))) * math.sin(t), 0, math.pi)[0]
    assert float(describing_function(nonlinearity, 3.0)) == pytest.approx(2 * integral / (3 * math.pi), rel=1e-9)

"""The second checker on the circle criterion and Popov's: certificates by hand, sharp on both sides of every limit."""

from fractions import Fraction as F

import pytest
from handwritten import (
    ATTRACTS,
    BOUNDED,
    EQUILIBRIA,
    accepted,
    circle_of_oscillator,
    nonlinearities,
    polynomial,
    proved,
    transfer,
)
from hypothesis import given
from hypothesis import strategies as st


# For ratio = 1/2 the polynomial x^2 - (k + 1) x + k + 1 has the discriminant (k + 1)(k - 3).
@pytest.mark.parametrize(
    ("k", "good"), [("299/100", True), (3 - F(1, 2**60), True), (3, False), (3 + F(1, 2**60), False)]
)
def test_the_circle_criterion_is_sharp_at_three(k, good):
    assert accepted(circle_of_oscillator(F(k))) is good
    assert accepted(circle_of_oscillator(F(k), time_varying=True)) is good


# In general -1/min Re H = 4 ratio (1 + ratio): the discriminant of the polynomial above vanishes there.
@given(
    ratio=st.fractions(min_value=F(1, 50), max_value=F(7, 10), max_denominator=60),
    j=st.integers(1, 60),
    side=st.sampled_from([-1, 1]),
)
def test_the_circle_criterion_is_sharp_for_every_damping(ratio, j, side):
    limit = 4 * ratio * (1 + ratio)
    assert accepted(circle_of_oscillator(limit * (1 + side * F(1, 2**j)), ratio)) is (side < 0)
    assert not accepted(circle_of_oscillator(limit, ratio))


# (s + 1)/(s^2 + 3 s + 3): (1 + iw)(3 - x - 3 iw) has the real part 3 + 2 x, D = x^2 + ..: w^2 Re H tends to 2.
def test_laws_without_a_bound_need_strict_positive_realness():
    lead = transfer([1, 1], [1, 3, 3])
    for upper in ("finite", "inf"):
        assert accepted(proved(lead, nonlinearities(0, upper), "circle", {}, polynomial([3, 2])))
    # (s + 1)/(s^2 + s + 1): U = 1, and w^2 Re H tends to 0
    slow = transfer([1, 1], [1, 1, 1])
    assert accepted(proved(slow, nonlinearities(0, "finite"), "circle", {}, polynomial([1])))
    assert not accepted(proved(slow, nonlinearities(0, "inf"), "circle", {}, polynomial([1])))
    # s/(s^2 + s + 1): U = x vanishes at 0: every finite bound, but not none
    wash = transfer([1, 0], [1, 1, 1])
    assert accepted(proved(wash, nonlinearities(0, "finite"), "circle", {}, polynomial([0, 1])))
    assert not accepted(proved(wash, nonlinearities(0, "inf"), "circle", {}, polynomial([0, 1])))
    # a hidden mode at -2: |d|^2 Re H = 4 + x
    hidden = transfer([1, 3, 2], [1, 3, 3, 2])
    assert accepted(proved(hidden, nonlinearities(0, "finite"), "circle", {}, polynomial([4, 1])))
    assert not accepted(proved(hidden, nonlinearities(0, "inf"), "circle", {}, polynomial([4, 1])))


# 1/(s + 1) with the mode s + h hidden; F (h^2 + x) with F = 1 + (1 + x)/k.
@pytest.mark.parametrize(("mode", "good"), [("1/1000000", True), ("0", False), ("-1/1000000", False)])
def test_a_hidden_mode_must_be_strictly_stable(mode, good):
    h = F(mode)
    certificate = proved(transfer([1, h], [1, 1 + h, h]), nonlinearities(0, 1), "circle", {}, polynomial([2, 1]))
    assert accepted(certificate) is good


# 12/((s - 1)(s + 3)) in [1, 2]: d + n = s^2 + 2 s + 9, U = 12 (9 - x), D = (9 - x)^2 + 4 x, F = 12 (9 - x) + D.
def test_an_unstable_block_is_shifted_by_the_lower_bound():
    unstable = transfer([12], [1, 2, -3])
    assert accepted(proved(unstable, nonlinearities(1, 2), "circle", {}, polynomial([189, -26, 1])))
    assert not accepted(proved(unstable, nonlinearities(0, 2), "circle", {}, polynomial([189, -26, 1])))
    assert not accepted(proved(unstable, nonlinearities("1/4", 2), "circle", {}, polynomial([189, -26, 1])))


# -1/(s + 1) in [-k, 0] is 1/(s + 1) in [0, k]: F = 1 + (1 + x)/k; for "-inf" strictly positive real.
def test_the_mirrored_circle_criterion():
    system = transfer([-1], [1, 1])
    assert accepted(proved(system, nonlinearities(-5, 0), "circle", {"mirrored": True}, polynomial([6, 1])))
    assert accepted(proved(system, nonlinearities("-inf", 0), "circle", {"mirrored": True}, polynomial([1])))
    assert not accepted(proved(system, nonlinearities("-inf", 0), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, nonlinearities("-5", "1"), "circle", {"mirrored": True}, polynomial([6, 1])))


# H = 1/s: Re H = 0 after the pole is divided out, F = 1/k; time-varying nonlinearities give boundedness alone.
def test_the_critical_case_promises_equilibria_or_boundedness():
    integrator = transfer([1], [1, 0])
    fixed, varying = nonlinearities(0, 5), nonlinearities(0, 5, time_varying=True)
    assert accepted(proved(integrator, fixed, "circle", {}, polynomial([1]), EQUILIBRIA))
    assert accepted(proved(integrator, varying, "circle", {}, polynomial([1]), BOUNDED))
    for class_, sentence in ((fixed, ATTRACTS), (fixed, BOUNDED), (varying, EQUILIBRIA), (varying, ATTRACTS)):
        assert not accepted(proved(integrator, class_, "circle", {}, polynomial([1]), sentence))
    for residue in (-1, F(-1, 2)):
        assert not accepted(proved(transfer([residue], [1, 0]), fixed, "circle", {}, polynomial([1]), EQUILIBRIA))
    assert not accepted(proved(transfer([1, 1], [1, 0, 0]), fixed, "circle", {}, polynomial([1]), EQUILIBRIA))


# H = (1 - s)/(1 + s), D = -1: 1 + k D vanishes at k = 1; U = Re (1 - iw)^2 = 1 - x, F = 1 - x + (1 + x)/k.
@pytest.mark.parametrize(("k", "good"), [(F(99, 100), True), (F(1), False), (F(101, 100), False)])
def test_the_loop_must_be_well_posed(k, good):
    certificate = proved(transfer([-1, 1], [1, 1]), nonlinearities(0, k), "circle", {}, polynomial([1 + k, 1 - k]))
    assert accepted(certificate) is good


def test_a_sector_across_the_ill_posed_gain_is_refused_where_the_inequality_holds():
    # D = -2 and l = 1: d + n = -s - 1 + ..., H = (-2 s - 2)/(s + 1) = -2 with a hidden mode, 1 + k D < 0 throughout
    # [1, k]: one sign, and the shifted block is 2, whose F = (2 + 1/w)(1 + x)
    system = transfer([-2, -2], [1, 1])
    assert accepted(proved(system, nonlinearities(1, 3), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, nonlinearities("1/4", 3), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, nonlinearities("1/2", 3), "circle", {}, polynomial([1])))


LAG = transfer([1], [1, 3, 2, 0])


# 1/(s (s + 1)(s + 2)): (x^2 + 5 x + 4)/k - 3 + theta (2 - x); with theta = 3/2 it is (x - 2)^2/6 at k = 6.
@pytest.mark.parametrize(
    ("k", "good"), [(F(599, 100), True), (6 - F(1, 2**60), True), (F(6), False), (F(601, 100), False)]
)
def test_popov_is_sharp_at_six(k, good):
    coefficients = [4 / k - 3 + 3, 5 / k - F(3, 2), 1 / k]
    certificate = proved(LAG, nonlinearities(0, k), "popov", {"theta": "3/2"}, polynomial(coefficients), EQUILIBRIA)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, k, time_varying=True)})
    assert not accepted({**certificate, "multiplier": {"theta": "-3/2"}})
    assert not accepted({**certificate, "conclusion": ATTRACTS})


# 1/(s (s + 1)): U = -1 (x divided out), D = 1 + x, -omega Im H D = 1 there: F = (1 + x)/k - 1 + theta.
def test_popov_for_laws_without_a_bound():
    integral = transfer([1], [1, 1, 0])

    def certificate(theta, upper):
        return proved(
            integral, nonlinearities(0, upper), "popov", {"theta": theta}, polynomial([F(theta) - 1]), EQUILIBRIA
        )

    assert accepted(certificate("1", "finite"))
    assert not accepted(certificate("999/1000", "finite"))
    assert accepted(certificate("1001/1000", "inf"))
    assert not accepted(certificate("1", "inf"))


# 1/(s+1)^3: D = (1 + x)^3, U = 1 - 3 x, -w Im H D = x (3 - x); with theta = 1: (1 + x)^3/k + 1 - x^2, which at k = 8
# has the double root 3.
def test_popov_of_a_stable_block_reaches_the_linear_limit():
    system = transfer([1], [1, 3, 3, 1])
    k = F(799, 100)
    coefficients = [1 / k + 1, 3 / k, 3 / k - 1, 1 / k]
    assert accepted(proved(system, nonlinearities(0, k), "popov", {"theta": "1"}, polynomial(coefficients)))
    coefficients = [F(1, 8) + 1, F(3, 8), F(3, 8) - 1, F(1, 8)]
    assert not accepted(proved(system, nonlinearities(0, 8), "popov", {"theta": "1"}, polynomial(coefficients)))


# (s^2 - s + 10)/(s^2 + s + 25), D = 1: n conj(d) = (10 - x - iw)(25 - x - iw) = (10 - x)(25 - x) - x - iw (35 - 2 x).
def test_a_direct_term_with_a_negative_theta_needs_slope_bounds():
    system, k, theta = transfer([1, -1, 10], [1, 1, 25]), F(9, 10), F(-3, 7)
    D = [F(625), F(-49), F(1)]
    U = [F(250), F(-36), F(1)]
    coefficients = [D[0] / k + U[0], D[1] / k + U[1] + theta * 35, D[2] / k + U[2] - 2 * theta]

    def certificate(slope):
        return proved(
            system, nonlinearities(0, k, slope=slope), "popov", {"theta": str(theta)}, polynomial(coefficients)
        )

    assert accepted(certificate(["0", "inf"]))
    assert accepted(certificate(["-99/100", "inf"]))  # 1 + D slope > 0
    assert not accepted(certificate(["-1", "inf"]))
    assert not accepted(certificate(None))
    # without them the file must say what it assumes
    said = {"solvable": "assumed: sigma + H(inf) phi(sigma) is increasing with a locally Lipschitz inverse"}
    assert accepted({**certificate(None), "hypotheses": said})
    assert not accepted({**certificate(None), "hypotheses": {"solvable": "checked"}})

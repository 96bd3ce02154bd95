"""Zames-Falb multipliers in continuous time: published plants, what must be refused, other ways to the same numbers."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import fmpq_poly
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from analysis.criteria.hurwitz import hurwitz_limit
from analysis.criteria.kernel_boxes import Inequality, TaylorBound
from analysis.criteria.kernel_certificate import check, check_every, value_at
from analysis.criteria.kernel_seeds import first_order
from analysis.criteria.kernels import Delay, Gamma, Multiplier, multiplier_of
from analysis.criteria.park import park_largest
from analysis.criteria.popov import popov_largest
from analysis.criteria.zames_falb import recheck, zames_falb_criterion, zames_falb_largest
from analysis.evidence import Evidence, Verdict
from analysis.plant import Plant
from analysis.precision import ball
from lure.errors import AssumptionError, InputError
from lure.rational import RationalBlock
from lure.sector import SlopeBounds


def F(text):
    return Fraction(text)


def block(numerator, denominator):
    return RationalBlock([F(c) for c in numerator.split()], [F(c) for c in denominator.split()])


# the set of Chen-Wen, Park, Turner, Chang and Carrasco
EX = {
    1: block("1 -0.2 -0.1", "1 2 1 1"),
    3: block("1 0 0", "1 0.2 6 0.1 1"),
    4: block("-1 0 0", "1 0.2 6 0.1 1"),
    5: block("1 0 0", "1 0.0003 10 0.0021 9"),
    6: block("-1 0 0", "1 0.0003 10 0.0021 9"),
    7: block("1 0 0", "1 2 2 1"),
}
# Fitts: s^2/(((s + b)^2 + 0.81)((s + b)^2 + 1.21)), b = 0.03; phi = tanh(sigma/0.01) oscillates with period 11.917
FITTS = block("1 0 0", "1 0.12 2.0254 0.121308 0.98191881")


def samples(system, extra=()):
    """Frequencies on a logarithmic grid and, closer and closer, around every pole."""
    poles = np.roots([float(c) for c in system.denominator])
    sizes = np.abs(poles)
    parts = [[0.0], np.geomspace(sizes.min() * 1e-4, sizes.max() * 1e4, 20_001), extra]
    for pole in poles:
        away = abs(pole.real) * np.geomspace(1e-3, 1e3, 600)
        parts += [abs(pole.imag) + away, abs(pole.imag) - away]
    omega = np.unique(np.concatenate(parts))
    return omega[omega >= 0]


def left_hand_side(system, k, multiplier, omega):
    """The inequality written out from the definition, in floating point."""
    H = system.transfer(1j * omega)
    return (multiplier.at(omega) * (H + 1 / float(k)) + 1j * omega * float(multiplier.theta) * H).real


def assert_sound(system, answer, odd):
    """What every proved answer must satisfy, checked without the code that proved it."""
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert recheck(system, answer.parameters)
    multiplier = multiplier_of(answer.parameters)
    assert sum(abs(c) for c, _ in multiplier.terms) <= 1
    assert odd or all(c > 0 for c, _ in multiplier.terms)
    if math.isfinite(answer.largest.low):
        assert F(answer.parameters["k"]) == F(answer.largest.low)
        assert answer.largest.low < hurwitz_limit(system).high
        omega = samples(system)
        values = left_hand_side(system, answer.largest.low, multiplier, omega)
        scale = np.abs(system.transfer(1j * omega)) + 1 / answer.largest.low
        assert (values > -1e-11 * scale).all()


# least certified slopes: above the table's "at least" everywhere; 1 is the Nyquist value 4.5894542 less its last digits
QUICK = [(1, False, 4.5894541), (1, True, 4.5894541), (3, False, 2.25), (7, False, 1e9), (7, True, 1e9)]
HARD = [(3, True, 2.25), (4, False, 1.34), (4, True, 1.34)]
HARD += [(5, False, 0.08), (5, True, 0.11), (6, False, 0.08), (6, True, 0.108)]


@pytest.mark.parametrize(("number", "odd", "least"), QUICK)
def test_published_plants(number, odd, least):
    answer = zames_falb_largest(EX[number], odd=odd)
    assert answer.largest.low >= least
    assert_sound(EX[number], answer, odd)
    assert answer.needs == (("slope", "odd", "time-invariant") if odd else ("slope", "time-invariant"))


@pytest.mark.slow
@pytest.mark.parametrize(("number", "odd", "least"), HARD)
def test_published_plants_that_take_longer(number, odd, least):
    answer = zames_falb_largest(EX[number], odd=odd)
    assert answer.largest.low >= least
    assert_sound(EX[number], answer, odd)


@pytest.mark.slow
@pytest.mark.parametrize("odd", [False, True])
def test_more_effort_and_odd_laws_never_reach_less(odd):
    quick, full = (zames_falb_largest(EX[3], odd=odd, effort=effort).largest.low for effort in ("quick", "full"))
    assert full >= quick >= (zames_falb_largest(EX[3], odd=False).largest.low if odd else 0)


@pytest.mark.slow
@pytest.mark.parametrize("odd", [False, True])
def test_the_kalman_counterexample_of_fitts_is_not_certified(odd):
    # the law tanh(sigma/0.01) is odd, has slope in [0, 100] and leaves a limit cycle
    answer = zames_falb_largest(FITTS, odd=odd)
    assert 0.3 < answer.largest.low < 100
    assert answer.largest.high == math.inf
    assert_sound(FITTS, answer, odd)
    at_hundred = zames_falb_criterion(FITTS, SlopeBounds(0, 100), odd=odd)
    assert at_hundred.verdict is Verdict.INCONCLUSIVE
    assert not recheck(FITTS, {**answer.parameters, "k": "100"})


def test_iqcbeta_plant_reaches_every_stable_linear_gain():
    # G = 400 (s^2 - 0.5 s + 1)/((s + 10)(s + 20)(s + 30)); its slope is asked up to 1 only
    plant = block("400 -200 400", "1 60 1100 6000")
    answer = zames_falb_largest(plant, odd=True)
    assert answer.largest.low == pytest.approx(hurwitz_limit(plant).low, rel=1e-7)
    proved = zames_falb_criterion(plant, SlopeBounds(0, 1), odd=True)
    assert proved.verdict is Verdict.PROVED
    assert 0 <= proved.margin.low <= proved.margin.high
    assert proved.margin.low > 0.4 * proved.margin.high


def test_margin_brackets_the_least_value():
    # 1/(s + 1), slope up to 2: with M = 1 the least value is 1/2, in the limit, and no frequency is below
    answer = zames_falb_criterion(block("1", "1 1"), SlopeBounds(0, 2), odd=False)
    multiplier = multiplier_of(answer.parameters)
    values = left_hand_side(block("1", "1 1"), 2, multiplier, samples(block("1", "1 1")))
    assert answer.margin.low <= values.min() <= answer.margin.high * (1 + 1e-6)


def test_every_finite_slope():
    # 7 with M = 1 - 1/(1 - s) = -s/(1 - s): Re[M H] is a positive multiple of w^4; with coefficient 1, M vanishes at 0
    answer = zames_falb_largest(EX[7], odd=False)
    assert answer.largest.low == math.inf
    assert answer.parameters["k"] == "inf"
    assert "every finite slope" in answer.reason
    assert answer.margin is None
    asked = zames_falb_criterion(EX[7], SlopeBounds(0, math.inf), odd=False)
    assert asked.verdict is Verdict.PROVED
    assert asked.largest.low == math.inf
    for k in ("100", "1000000"):
        one = zames_falb_criterion(EX[7], SlopeBounds(0, F(k)), odd=False)
        assert one.verdict is Verdict.PROVED
        assert F(one.parameters["k"]) == F(k)
        assert recheck(EX[7], one.parameters)


def test_every_finite_slope_needs_a_nonnegative_gain_at_zero_where_the_multiplier_vanishes():
    # (2 s - 1)/(s + 1) with 1 - 1/(1 - s): Re[M H] (1 + w^2)^2 = 2 w^4 + 2 w^2 >= 0, but the gain 1 has the pole s = 0
    multiplier = Multiplier(F(0), ((F(1), Gamma(F(1), 1, "anticausal")),))
    assert not check_every(Plant.of(block("2 -1", "1 1")), multiplier)
    assert check_every(Plant.of(EX[7]), multiplier)
    assert not check_every(Plant.of(EX[7]), Multiplier(F(0), ((F(1), Gamma(F(1), 1, "causal")),)))
    assert not check_every(Plant.of(EX[7]), Multiplier(F(0), ((F(1), Delay(F(1))),)))


def test_negative_coefficients_are_for_odd_laws_only():
    parameters = {"lower": "0", "k": "1/2", "odd": True, "theta": "0"}
    parameters["kernels"] = [{"coefficient": "-1/10", "delay": "1"}]
    plant = block("1", "1 1")
    assert recheck(plant, parameters)
    assert not recheck(plant, {**parameters, "odd": False})
    assert not recheck(plant, {**parameters, "odd": "yes"})  # only the truth value is an assumption made


def test_mass_above_one_is_refused():
    # Re[1 + c 5/(5 + s)] >= 1 for c > 0, and 1/k = 100 outweighs H: the inequality holds, the multiplier is illegal
    plant = block("1", "1 1")
    term = {"coefficient": "-1", "rate": "5", "order": 1, "side": "causal"}
    parameters = {"lower": "0", "k": "1/100", "odd": True, "theta": "0", "kernels": [term]}
    assert recheck(plant, parameters)
    heavy = {**parameters, "kernels": [{**term, "coefficient": "-1001/1000"}]}
    assert check(Plant.of(plant), F("1/100"), multiplier_of(heavy)).holds
    assert not recheck(plant, heavy)


@pytest.mark.parametrize(
    "change",
    [
        {"k": "5"},
        {"k": "-1"},
        {"k": "inf"},
        {"theta": "40"},
        {"kernels": []},
        {"kernels": [{"coefficient": "9/10", "rate": "-2", "order": 1, "side": "anticausal"}]},
        {"kernels": [{"coefficient": "9/10", "delay": "0"}]},
    ],
)
def test_a_changed_certificate_is_refused(change):
    answer = zames_falb_largest(EX[1], odd=False)
    assert recheck(EX[1], answer.parameters)
    assert not recheck(EX[1], {**answer.parameters, **change})


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"theta": "0", "kernels": [], "k": "1", "odd": True},
        {"theta": "0", "kernels": 3, "lower": "0", "k": "1", "odd": True},
        {"theta": "x", "kernels": [], "lower": "0", "k": "1", "odd": True},
        {"theta": "0", "kernels": [{"coefficient": "1", "rate": "1", "order": 1, "side": "left"}], "lower": "0"},
    ],
)
def test_incomplete_parameters(parameters):
    with pytest.raises(InputError, match="give"):
        recheck(EX[1], parameters)


def test_refusals():
    with pytest.raises(InputError, match="zames_falb_discrete"):
        zames_falb_largest(RationalBlock([1], [1, 0], dt=1), odd=True)
    with pytest.raises(AssumptionError, match="s = 0"):
        zames_falb_largest(block("1", "1 3 2 0"), odd=False)
    with pytest.raises(AssumptionError, match="right half-plane"):
        zames_falb_largest(block("1", "1 -1"), odd=False)
    with pytest.raises(AssumptionError, match="finite lower slope"):
        zames_falb_criterion(EX[1], SlopeBounds(-math.inf, 1), odd=False)
    beyond = zames_falb_criterion(EX[4], SlopeBounds(0, 4), odd=True)
    assert beyond.verdict is Verdict.INCONCLUSIVE
    assert "linear gain" in beyond.reason


def test_blocks_without_dynamics():
    assert zames_falb_largest(block("1/2", "1"), odd=False).largest.low == math.inf
    assert zames_falb_largest(block("0", "1 1"), odd=False).largest.low == math.inf
    assert zames_falb_largest(block("-1/2", "1"), odd=False).largest.low == pytest.approx(2, rel=1e-6)
    assert zames_falb_largest(block("-1/2", "1"), odd=False).largest.low < 2


def test_sign_convention():
    # mu = -phi(sigma): 1/(s + 1) is stable with every slope, -1/(s + 1) below slope 1
    assert zames_falb_largest(block("1", "1 1"), odd=False).largest.low == math.inf
    answer = zames_falb_largest(block("-1", "1 1"), odd=False)
    assert 1 - 1e-6 < answer.largest.low < 1


def test_multiplier_text_and_parameters():
    multiplier = Multiplier(F("-1/4"), ((F("1/2"), Delay(F(3))), (F("-1/8"), Gamma(F(2), 3, "anticausal"))))
    assert str(multiplier) == "1 - 0.5 exp(-3 s) + 0.125 (2/(2 - s))^3 - 0.25 s"
    assert multiplier_of(multiplier.to_parameters()) == multiplier
    assert multiplier.mass == F("5/8")
    assert multiplier.admissible(odd=True)
    assert not multiplier.admissible(odd=False)


@pytest.mark.parametrize("kernel", [Gamma(F(2), 1, "causal"), Gamma(F(3), 4, "causal"), Gamma(F(3), 2, "anticausal")])
def test_gamma_kernels_are_what_their_docstring_says(kernel):
    t = np.linspace(0, 40, 400_001)
    a, n = float(kernel.rate), kernel.order
    density = a**n * t ** (n - 1) * np.exp(-a * t) / math.factorial(n - 1)
    time = t if kernel.side == "causal" else -t
    assert np.trapezoid(np.abs(density), t) == pytest.approx(1, abs=1e-7)  # mass and L1 norm
    for omega in (0.0, 0.7, 3.0):
        transform = np.trapezoid(density * np.exp(-1j * omega * time), t)
        assert kernel.at(np.array([omega]))[0] == pytest.approx(transform, abs=1e-7)


def test_the_inequality_behind_the_theorem():
    # int v(t) e(t - tau) dt <= int v e dt for monotone phi, >= -int v e dt for odd phi, and the latter fails otherwise
    rng = np.random.default_rng(0)
    k, failed = 2.0, False
    for _ in range(200):
        sigma = rng.normal(size=16)
        for law, odd in ((lambda s: np.clip(k * s, -0.1, 3.0), False), (lambda s: k * np.tanh(s), True)):
            v = law(sigma)
            e = sigma - v / k
            products = np.array([np.dot(v, np.roll(e, shift)) for shift in range(16)])
            assert (products <= products[0] + 1e-12).all()
            if odd:
                assert (products >= -products[0] - 1e-12).all()
    for _ in range(200):
        sigma = rng.normal(size=16)
        v = k * np.maximum(sigma, 0)
        e = sigma - v / k
        failed |= bool((np.array([np.dot(v, np.roll(e, i)) for i in range(16)]) < -np.dot(v, e) - 1e-9).any())
    assert failed


def test_park_multiplier_as_a_zames_falb_multiplier():
    # 1 + theta s - tau s^2 = tau (a - s)(b + s) with a = 3, b = 1, tau = 1/3, theta = 2/3, and mirrored
    omega = np.array([0.0, 0.5, 2.0, 30.0])
    for theta in (F("2/3"), F("-2/3")):
        found = first_order(F(3), theta * 3, 10**6)
        park = 1 + omega**2 / 3 + 1j * omega * float(theta)
        ratio = park / found.at(omega)
        assert np.abs(ratio.imag).max() < 1e-12
        assert ratio.real.min() > 0
        assert found.terms == ((F("2/3"), Gamma(F(3), 1, "causal" if theta > 0 else "anticausal")),)


@st.composite
def stable_blocks(draw, most=4):
    """Poles from well damped to nearly on the axis, zeros anywhere."""
    number = st.integers(1, 40)
    d = np.array([F(1)])
    while len(d) - 1 < draw(st.integers(1, most)):
        if draw(st.booleans()) and len(d) < most:
            damping = draw(st.sampled_from(["1/1000", "1/20", "1/2", "2"]))
            w = F(draw(number)) / 10
            d = np.convolve(d, np.array([F(1), F(damping) * w, w * w]))
        else:
            d = np.convolve(d, np.array([F(1), F(draw(number)) / 10]))
    n = [F(draw(st.integers(-30, 30))) / 10 for _ in range(draw(st.integers(1, len(d))))]
    assume(any(n))
    return RationalBlock(n, list(d))


@st.composite
def multipliers(draw, odd=False):
    """Legal multipliers of at most three kernels."""
    count = draw(st.integers(0, 3))
    terms = []
    for _ in range(count):
        c = F(draw(st.integers(1, 99))) / (100 * count) * (draw(st.sampled_from([1, -1])) if odd else 1)
        if draw(st.booleans()):
            terms.append((c, Delay(F(draw(st.integers(1, 60))) / 10 * draw(st.sampled_from([1, -1])))))
        else:
            side = draw(st.sampled_from(["causal", "anticausal"]))
            terms.append((c, Gamma(F(draw(st.integers(1, 60))) / 10, draw(st.integers(1, 3)), side)))
    return Multiplier(F(draw(st.integers(-20, 20))) / 10, tuple(terms))


@settings(max_examples=60, deadline=None)
@given(stable_blocks(), multipliers(odd=True), st.integers(1, 60))
def test_check_agrees_with_dense_samples(system, multiplier, tenths):
    k, plant = F(tenths) / 10, Plant.of(system)
    found = check(plant, k, multiplier)
    omega = samples(system, [0.0 if found.where is None or math.isinf(found.where) else found.where])
    values = left_hand_side(system, k, multiplier, omega)
    scale = (np.abs(system.transfer(1j * omega)) * (1 + omega * abs(float(multiplier.theta))) + 1 / float(k)) * 2
    if found.holds:
        assert (values > -1e-12 * scale).all()
    elif math.isfinite(found.where):  # it fails there, or nearly
        assert left_hand_side(system, k, multiplier, np.array([found.where]))[0] <= 1e-6 * scale.max()
    else:  # the limit of the left-hand side with every delay at its worst phase
        d, top = system.denominator, (*[F(0)] * (system.order + 1 - len(system.numerator)), *system.numerator)
        direct = 1 / k + top[0]
        mass = sum(abs(c) for c, kernel in multiplier.terms if isinstance(kernel, Delay))
        assert direct + multiplier.theta * (top[1] - top[0] * d[1]) <= mass * abs(direct)


@settings(max_examples=40, deadline=None)
@given(stable_blocks(), multipliers(), st.integers(1, 60), st.integers(0, 400))
def test_value_from_balls_and_from_doubles(system, multiplier, tenths, hundredths):
    omega, k = F(hundredths) / 100, F(tenths) / 10
    value = value_at(Plant.of(system), k, multiplier, omega)
    H = abs(system.transfer(1j * float(omega)))
    expected = left_hand_side(system, k, multiplier, np.array([float(omega)]))[0]
    assert float(value) == pytest.approx(expected, abs=1e-9 * (1 + H) * (1 + float(omega)) + 1e-9)


@settings(max_examples=40, deadline=None)
@given(stable_blocks(), multipliers(odd=True), st.integers(1, 60), st.sampled_from(["1/1000", "7/3", "4096"]))
def test_symmetries_of_the_inequality(system, multiplier, tenths, text):
    factor, k, plant = F(text), F(tenths) / 10, Plant.of(system)
    found = check(plant, k, multiplier).holds
    order = system.order
    # time scale: H(s / factor)
    n = [c / factor**i for c, i in zip(system.numerator, range(len(system.numerator) - 1, -1, -1), strict=True)]
    d = [c / factor**i for c, i in zip(system.denominator, range(order, -1, -1), strict=True)]
    assert check(Plant.of(RationalBlock(n, d)), k, multiplier.scaled(factor)).holds is found
    # gain moved from the block to the law
    louder = RationalBlock([factor * c for c in system.numerator], system.denominator)
    assert check(Plant.of(louder), k / factor, multiplier).holds is found
    # time reversed: H(-s), where causal and anticausal change places
    n = [c * (-1) ** i for c, i in zip(system.numerator, range(len(system.numerator) - 1, -1, -1), strict=True)]
    d = [c * (-1) ** i for c, i in zip(system.denominator, range(order, -1, -1), strict=True)]
    assert check(Plant.of(RationalBlock(n, d)), k, multiplier.mirrored()).holds is found
    # a smaller slope is never harder
    assert not found or check(plant, k * F("2/3"), multiplier).holds


def test_the_limit_of_a_multiplier_from_both_sides():
    # M = 1 - (1/2) exp(-s): the largest k is 1/max(-Re[M H]/Re M) since Re M >= 1/2, here from a fine grid
    system, multiplier = EX[3], Multiplier(F(0), ((F("1/2"), Delay(F("-17/10"))),))
    omega = samples(system)
    omega = np.unique(np.concatenate([omega, np.linspace(2.3, 2.7, 400_001), np.linspace(0.3, 0.5, 400_001)]))
    M, H = multiplier.at(omega), system.transfer(1j * omega)
    limit = 1 / np.max(-(M * H).real / M.real)
    assert check(Plant.of(system), F(limit * (1 - 1e-7)), multiplier).holds
    assert not check(Plant.of(system), F(limit * (1 + 1e-7)), multiplier).holds


def test_a_dip_too_narrow_for_a_grid():
    # a resonance of width 1e-9 at w = 1: Re H = -x (1 - x)/((1 - x)^2 + 1e-18 x) dips to -5e8 beside it
    system = block("-1 0 0", "1 1e-9 1")
    for multiplier in (Multiplier(F(0), ()), Multiplier(F(0), ((F("1/100"), Delay(F(1))),))):
        assert check(Plant.of(system), F("1e-9"), multiplier).holds
        assert not check(Plant.of(system), F("3e-9"), multiplier).holds


def test_a_long_delay_meets_every_phase():
    # with delay 1000 the least value is that of Re F - 0.9 |F|, F = H + 1/k, nearly: negative though Re F > 0.45 |F|
    system, k = block("1", "1 1 1"), F("3/5")
    multiplier = Multiplier(F(0), ((F("9/10"), Delay(F(1000))),))
    omega = np.linspace(0, 10, 2_000_001)
    phase = system.transfer(1j * omega) + 1 / float(k)
    assert (phase.real > 0.46 * np.abs(phase)).all()
    assert left_hand_side(system, k, multiplier, omega).min() < -0.01
    assert not check(Plant.of(system), k, multiplier).holds
    assert check(Plant.of(system), k, Multiplier(F(0), ((F("9/20"), Delay(F(1000))),))).holds


def test_an_inequality_that_fades_at_infinity():
    # 1/(s + 1), k = 1, theta = -1: Re[(1 - i w)/(1 + i w)] + 1 = 2/(1 + w^2) > 0, but no eps is left
    plant = Plant.of(block("1", "1 1"))
    assert not check(plant, F(1), Multiplier(F(-1), ())).holds
    assert check(plant, F(1), Multiplier(F("-99/100"), ())).holds


@pytest.mark.parametrize("radius", ["1/100", "1", "5"])
def test_the_bound_on_a_box(radius):
    # |T(m + u r) - sum T_j u^j| <= R, against T at single points
    multiplier = Multiplier(F("1/3"), ((F("1/2"), Delay(F(2))), (F("-1/4"), Delay(F(-1)))))
    function = TaylorBound(Inequality.of(Plant.of(EX[3]), F(2), multiplier, F(0)))
    middle, r = F(6), F(radius)
    terms, rest = function.expansion(ball(middle), ball(r))
    for u in (F(i) / 10 for i in range(-10, 11)):
        exact = function.expansion(ball(middle + u * r), ball(0))[0][0]
        miss = abs(float(exact - sum(term * ball(u) ** j for j, term in enumerate(terms))))
        assert miss <= float(rest.upper()) + 1e-9 * abs(float(exact))


def test_the_parts_of_the_bound_on_a_box():
    # a polynomial alone, then a wave times a constant: each part of R is needed
    alone = Inequality(fmpq_poly([0] * 6 + [1]), fmpq_poly([0]), ((F("1/2"), F(1)),), 0)
    terms, rest = TaylorBound(alone).expansion(ball(0), ball(1))  # w^12 has no terms below the twelfth
    assert (float(sum(terms)), float(rest)) == (0.0, 1.0)
    wave = Inequality(fmpq_poly([0]), fmpq_poly([1]), ((F(1), F(2)),), 0)
    terms, rest = TaylorBound(wave).expansion(ball(0), ball(1))  # -cos(2 u) = -1 + 2 u^2 - 2 u^4/3 + ...
    assert [float(term) for term in terms] == pytest.approx([-1, 0, 2, 0, -2 / 3, 0])
    assert float(rest) == pytest.approx(2**6 / math.factorial(6))
    slow = Inequality(fmpq_poly([0]), fmpq_poly([0] * 8 + [1]), ((F(1), F("1/1000")),), 0)
    terms, rest = TaylorBound(slow).expansion(ball(0), ball(1))  # -u^8 cos(u/1000)
    assert (float(sum(terms)), float(rest)) == (0.0, pytest.approx(1, abs=2e-3))


def test_mass_one_of_delays_touches_zero():
    # 1 - exp(-s) vanishes at w = 0, 2 pi, ...: no eps is left, at zero, at infinity or between
    assert not check(Plant.of(block("1", "1 1 1")), F("1/10"), Multiplier(F(0), ((F(1), Delay(F(1))),))).holds
    # with theta > 0 and relative degree one infinity is safe, zero is not
    assert not check(Plant.of(block("1", "1 1")), F("1/10"), Multiplier(F(9), ((F(1), Delay(F(1))),))).holds


@settings(max_examples=10, deadline=None)
@given(stable_blocks(most=3), st.booleans())
def test_order_of_the_criteria(system, odd):
    answer = zames_falb_largest(system, odd=odd)
    assert_sound(system, answer, odd)
    assert answer.largest.low >= popov_largest(system).largest.low
    assert answer.largest.low >= park_largest(system).largest.low * (1 - 1e-12)
    assert answer.largest.high <= hurwitz_limit(system).high


def test_time_scale_and_gain_of_the_answer():
    base = zames_falb_largest(EX[1], odd=False).largest.low
    n, d = EX[1].numerator, EX[1].denominator
    slower = RationalBlock(
        [c * F("1e-6") ** i for i, c in enumerate(n, 1)], [c * F("1e-6") ** i for i, c in enumerate(d)]
    )
    assert zames_falb_largest(slower, odd=False).largest.low == pytest.approx(base, rel=1e-7)
    louder = RationalBlock([c * 3000 for c in n], d)
    assert zames_falb_largest(louder, odd=False).largest.low * 3000 == pytest.approx(base, rel=1e-7)


def test_a_direct_term_moves_into_the_law():
    # H + D with [0, k] is H with [0, k/(1 + k D)]; 1/k' = 1/k + D
    n, d = EX[1].numerator, EX[1].denominator
    direct = F("1/10")
    padded = [F(0)] * (len(d) - len(n)) + list(n)
    with_direct = RationalBlock([a + direct * b for a, b in zip(padded, d, strict=True)], d)
    base, moved = (zames_falb_largest(system, odd=False).largest.low for system in (EX[1], with_direct))
    assert 1 / base == pytest.approx(1 / moved + float(direct), rel=1e-7)


def test_lower_slope():
    # 1/(s^2 - s/2 + 1) needs a positive lower slope of its derivative: H = s/(...), lower = 1 leaves s/(s^2 + s/2 + 1)
    answer = zames_falb_largest(block("1 0", "1 -1/2 1"), odd=False, lower=F(1))
    assert answer.largest.low == math.inf
    assert answer.parameters["lower"] == "1"
    shifted = RationalBlock(
        EX[1].numerator, [a + b / 2 for a, b in zip(EX[1].denominator, (0, *EX[1].numerator), strict=True)]
    )
    direct = zames_falb_largest(EX[1], odd=False, lower=F("1/2"))
    assert direct.largest.low - 0.5 == pytest.approx(zames_falb_largest(shifted, odd=False).largest.low, rel=1e-7)
    assert recheck(EX[1], direct.parameters)


def test_answer_of_a_given_class_is_not_a_truth_value():
    answer = zames_falb_criterion(EX[1], SlopeBounds(0, 4), odd=False)
    assert answer.verdict is Verdict.PROVED
    assert answer.largest.low == 4.0
    with pytest.raises(TypeError):
        bool(answer)
    assert replace(answer, reason="") != answer

"""The circle criterion against published numbers, its geometry, its symmetries, and adversaries inside the class."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb, fmpq_poly
from hypothesis import assume, given
from hypothesis import strategies as st

from lure.analysis.inequality.checks import encirclements, region
from lure.analysis.inequality.gains import hurwitz_limit, is_stable_gain
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.minimum import infimum, largest_below, nonnegative_from_zero
from lure.analysis.questions.answers import max_sector
from lure.analysis.theorems.circle import circle_criterion, circle_largest, circle_may_reach
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

F = Fraction
OMEGA = np.concatenate([[0.0], np.geomspace(1e-4, 1e4, 4001)])
OSCILLATOR = RationalPlant([1], [1, 1, 1])
UNSTABLE = RationalPlant([12], [1, 2, -3])  # 4/((s - 1)(s/3 + 1))


def exact(*texts):
    return [F(str(text)) for text in texts]


def mirrored(block):
    return RationalPlant([-c for c in block.numerator], block.denominator, block.dt)


def response(block):
    return block.transfer(1j * OMEGA if block.dt is None else np.exp(2j * np.arctan(OMEGA)))


@st.composite
def stable_blocks(draw, *, largest=6):
    """Stable blocks: poles from well damped to nearly on the axis, sometimes a factor that nearly cancels."""
    order = draw(st.integers(1, largest))
    numerator, denominator = [F(1)], np.array([F(1)])  # exact: rounding may put close pairs on the axis
    while len(denominator) <= order:
        size, damping = draw(st.sampled_from([0.25, 0.5, 1.0, 3.0])), draw(st.sampled_from([0.75, 0.125, 2.0**-20]))
        pair = len(denominator) < order and draw(st.booleans())
        factor = [1, 2 * F(damping) * F(size), F(size) ** 2] if pair else [1, F(size)]
        denominator = np.convolve(denominator, np.array(factor, dtype=object))
    numerator = draw(st.lists(st.integers(-8, 8), min_size=1, max_size=order + 1))
    if draw(st.booleans()):
        zero = draw(st.sampled_from([0.5, 2.0]))
        numerator = list(np.convolve(numerator, [1, zero]))
        denominator = np.convolve(denominator, np.array([1, F(zero) + F(1, 2**30)], dtype=object))
    assume(any(numerator))
    return RationalPlant([F(c) for c in numerator], list(denominator))


# continuous time: 1/(s+1)^3: Re = (1 - 3x)/(1 + x)^3 is least at x = 1, -1/4; 1/(s(s+1)(s+2)): the limit at 0, -3/4
@pytest.mark.parametrize(
    ("numerator", "denominator", "largest", "digits"),
    [
        ([1, "-.2", "-.1"], [1, 2, 1, 1], 1.24307, 6),
        ([1, 0, 0], [1, ".2", 6, ".1", 1], 0.326273, 6),
        ([-1, 0, 0], [1, ".2", 6, ".1", 1], 0.308094, 6),
        ([1, 0, 0], [1, ".0003", 10, ".0021", 9], 4.00040e-4, 6),
        ([-1, 0, 0], [1, ".0003", 10, ".0021", 9], 3.99960e-4, 6),
        ([1, 0, 0], [1, 2, 2, 1], 8.12086, 6),
        ([1], [1, 1, 0], 1, 12),
        ([1], [1, 3, 2, 0], 4 / 3, 12),
        ([1], [1, 1, 1, 0], 0.75, 12),
        ([1], [1, ".1", 1, 0], 0.09975, 12),
        ([1, 2], [1, 1, 0], 1, 12),
        ([1, 1], [1, 2, 0], math.inf, 1),
        ([1], [1, 0], math.inf, 1),
        ([1], [1, 3, 3, 1], 4, 12),
        ([4], [F(1, 6), 1, F(11, 6), 1], 1.164456, 7),
        ([1, -1, 10], [1, 1, 25], 0.532958, 6),
        ([1], [1, 1, 1], 3, 12),
    ],
)
def test_published_sectors(numerator, denominator, largest, digits):
    block = RationalPlant(exact(*numerator), exact(*denominator))
    answer = circle_largest(block)
    assert (answer.verdict, answer.evidence) == (Verdict.PROVED, Evidence.CERTIFIED)
    assert f"{answer.largest.low:.{digits}g}" == f"{largest:.{digits}g}"
    assert answer.largest.width <= 1e-10 * answer.largest.low or largest == math.inf


@pytest.mark.parametrize(
    ("numerator", "denominator", "largest"),
    [
        ([".1", 0], [1, "-1.8", ".81"], 0.7934),
        ([1, "-1.95", ".9", ".05"], [1, "-2.8", "3.5", "-2.412", ".7209"], 0.1984),
        ([-1, "1.95", "-.9", "-.05"], [1, "-2.8", "3.5", "-2.412", ".7209"], 0.1379),
        (["-.5", ".1"], [1, "-.9", ".79", ".089"], 1.0273),
        ([2, ".92"], [1, "-.5", 0], 0.6510),
    ],
)
def test_published_sectors_in_discrete_time(numerator, denominator, largest):
    block = RationalPlant(exact(*numerator), exact(*denominator), dt=1)
    answer = circle_largest(block)
    assert round(answer.largest.low, 4) == largest
    # an adversary: no point of the plot lies left of -1/k, and the one at the frequency named does for a larger k
    assert 1 / answer.largest.low + response(block).real.min() > 0
    worst = block.transfer(np.exp(1j * answer.worst_frequency)).real
    assert 1 / (answer.largest.high * (1 + 1e-9)) + worst < 0


@pytest.mark.parametrize(
    "block", [OSCILLATOR, RationalPlant([1], [1, 3, 2, 0]), RationalPlant([2, 1], [1, 0, F(1, 4)], dt=1)]
)
def test_the_largest_sector_is_sharp_to_the_last_bits(block):
    largest = circle_largest(block).largest
    assert circle_criterion(block, Sector(0, largest.low)).verdict is Verdict.PROVED
    beyond = math.nextafter(largest.high, math.inf)
    assert circle_criterion(block, Sector(0, beyond)).verdict is not Verdict.PROVED
    assert largest.width <= 1e-14 * largest.low


# H = 1/z is least at z = -1, the point at infinity of the mapped axis: z + k = 0 leaves the disc at k = 1
def test_a_minimum_at_minus_one_counts():
    delay = RationalPlant([1], [1, 0], dt=1)
    assert circle_criterion(delay, Sector(0, 1)).verdict is Verdict.REFUTED
    assert circle_criterion(delay, Sector(0, 1)).worst_frequency == pytest.approx(math.pi)
    assert 1 - 1e-15 < circle_largest(delay).largest.low < 1


# Re H = (1 - x)/((1 - x)^2 + x): margin 1/k - 1/3 at w = sqrt 2
@pytest.mark.parametrize(
    ("k", "verdict"), [(F(29, 10), Verdict.PROVED), (3, Verdict.INCONCLUSIVE), (4, Verdict.INCONCLUSIVE)]
)
def test_the_margin_is_the_distance_to_the_line(k, verdict):
    answer = circle_criterion(OSCILLATOR, Sector(0, k))
    assert answer.verdict is verdict
    assert answer.margin.low == pytest.approx(1 / k - 1 / 3, abs=1e-15)
    assert answer.margin.low <= 1 / k - 1 / 3 + 1e-16
    assert answer.worst_frequency == pytest.approx(math.sqrt(2))
    assert answer.largest.high >= 3 > answer.largest.low


@given(stable_blocks(largest=12))
def test_circle_stays_below_hurwitz_and_above_no_sample(block):
    answer = circle_largest(block)
    low, high = answer.largest.low, answer.largest.high
    assert answer.verdict is Verdict.PROVED or low == 0
    limit = hurwitz_limit(block)
    assert low < limit.high or low == math.inf == limit.high
    least = response(block).real.min()
    if low == math.inf:
        assert least >= -1e-9 * abs(response(block)).max()
    elif low > 0:
        assert 1 + low * least > -1e-9
        for share in (F(1, 7), F(1, 2), F(1)):
            assert is_stable_gain(block, share * F(low))
        assert F(high) - F(low) <= F(1, 10**10) * F(high)


def in_region(points, k1, k2):
    """The classical geometry, for a stable block: signs of k1, k2 decide between half-plane, outside and inside."""
    if k1 == 0:
        return (points.real > -1 / k2).all()
    if k2 == 0:
        return (points.real < -1 / k1).all()
    centre, radius = -(1 / k1 + 1 / k2) / 2, abs(1 / k1 - 1 / k2) / 2
    distance = abs(points - centre)
    return (distance < radius).all() if k1 < 0 < k2 else (distance > radius).all()


@given(
    stable_blocks(largest=4), st.sampled_from([-4, -1, F(-1, 8), 0, F(1, 8)]), st.sampled_from([F(1, 16), F(1, 2), 3])
)
def test_every_sign_case_is_the_classical_disc(block, k1, width):
    k2 = k1 + width
    assume(1 + k1 * block.feedthrough != 0 and (1 + k2 * block.feedthrough) * (1 + k1 * block.feedthrough) > 0)
    # a pole of the shifted loop on the axis: the criterion has an answer of its own, and the curve touches the disc
    assume(all(TransferPolynomials.of(block).shifted(F(k)).poles.axis == 0 for k in (k1, k2)))
    try:
        answer = circle_criterion(block, Sector(k1, k2))
    except AssumptionError:
        assert not is_stable_gain(block, F(k1))
        return
    if answer.verdict is Verdict.PROVED:
        assert in_region(response(block), float(k1), float(k2))
        if not k1 < 0 < k2:
            assert encirclements(block, F(k1 or k2)).counterclockwise == 0
    else:
        omega = answer.worst_frequency
        worst = block.transfer(1j * omega) if math.isfinite(omega) else complex(block.feedthrough)
        assert ((1 + float(k2) * worst) / (1 + float(k1) * worst)).real <= 1e-6


@given(stable_blocks(largest=3), st.sampled_from([-3, F(-1, 2), 0, F(1, 2)]), st.sampled_from([F(1, 4), 2]))
def test_a_block_and_its_mirror_image_agree(block, k1, width):
    answers = []
    for used, sector in ((block, Sector(k1, k1 + width)), (mirrored(block), Sector(-k1 - width, -k1))):
        try:
            answers.append(circle_criterion(used, sector).verdict)
        except (AssumptionError, InputError):
            answers.append(None)
    # the loop may be refused at one end and refuted at the other; proofs agree
    assert (answers[0] is Verdict.PROVED) is (answers[1] is Verdict.PROVED)


@pytest.mark.parametrize(
    ("block", "sector", "verdict"),
    [
        (UNSTABLE, Sector(1, 2), Verdict.PROVED),
        (UNSTABLE, Sector(1, 3), Verdict.INCONCLUSIVE),
        (mirrored(UNSTABLE), Sector(-2, -1), Verdict.PROVED),
        (RationalPlant([1], [1, 3, 2, 0]), Sector(0, 1), Verdict.PROVED),
        (mirrored(RationalPlant([1], [1, 3, 2, 0])), Sector(-1, 0), Verdict.PROVED),
        (RationalPlant([1], [1, 3, 2, 0]), Sector(0, 7), Verdict.REFUTED),
        (RationalPlant([1], [1, 1]), Sector(0, math.inf), Verdict.PROVED),
        (RationalPlant([1], [1, 1]), Sector(F(-1, 2), math.inf), Verdict.PROVED),
        (mirrored(RationalPlant([1], [1, 1])), Sector(-math.inf, 0), Verdict.PROVED),
        (RationalPlant([1, 1], [1, 2, 0]), Sector(0, math.inf), Verdict.PROVED),
        # Re H = 1/(x (1 + x)) - ... >= 0 with w^2 Re H -> 0: every finite k, not the half-line
        (RationalPlant([1, 3], [1, 3, 2]), Sector(0, math.inf), Verdict.INCONCLUSIVE),
        (RationalPlant([1, 3], [1, 3, 2]), Sector(0, 10**9), Verdict.PROVED),
        (OSCILLATOR, Sector(0, math.inf), Verdict.INCONCLUSIVE),
    ],
)
def test_sectors_of_every_kind(block, sector, verdict):
    answer = circle_criterion(block, sector)
    assert answer.verdict is verdict
    assert answer.reason
    assert (answer.witness is not None) is (verdict is Verdict.REFUTED)
    assert (answer.margin.low >= 0) is (verdict is Verdict.PROVED or answer.margin.low == answer.margin.high == 0)


# lower l: 12/(s^2 + 2s + 12 l - 3); Re is least where the derivative vanishes: with p = 12 l - 3, x = p + 2 sqrt p
@pytest.mark.parametrize("lower", [F(26, 100), F(1, 2), F(1), F(3)])
def test_the_unstable_block_beyond_its_stabilising_gain(lower):
    p = float(12 * lower - 3)
    x = p + 2 * math.sqrt(p)
    least = 12 * (p - x) / ((p - x) ** 2 + 4 * x)
    answer = circle_largest(UNSTABLE, lower=lower)
    assert answer.largest.low == pytest.approx(float(lower) - 1 / least, rel=1e-12)
    assert any("encirclements by the Nyquist plot of H: 1, its poles" in text for text in answer.hypotheses)


def test_the_critical_case_claims_no_more_than_it_may():
    answer = circle_largest(RationalPlant([1], [1, 3, 2, 0]))
    assert answer.needs == ("time-invariant",)
    assert not answer.nonlinearity_class.time_varying
    assert "converges to the stationary set" in answer.reason
    assert "boundedness only" in answer.reason
    assert "exponentially" not in answer.reason
    principal = circle_largest(OSCILLATOR)
    assert principal.needs == ()
    assert principal.nonlinearity_class.time_varying


@pytest.mark.parametrize(
    ("numerator", "denominator"),
    [([1, 1], [1, 0, 0]), ([1, 0], [1, 1, 0]), ([1, -1], [1, 1, 0]), ([1], [1, 0, 1]), ([12], [1, 2, -3])],
)
def test_blocks_outside_the_theorem_are_refused(numerator, denominator):
    with pytest.raises(AssumptionError):
        circle_largest(RationalPlant(numerator, denominator))


def test_a_sector_with_an_algebraic_loop_is_refused():
    with pytest.raises(InputError, match="not well posed"):
        circle_criterion(RationalPlant([-1, 1], [1, 1]), Sector(0, 2))


def test_fitts_is_not_certified_up_to_its_limit_cycle():
    # phi = tanh(sigma/.01), in the sector [0, 100], keeps a limit cycle going
    b = F(3, 100)
    pairs = [[1, 2 * b, b * b + F(81, 100)], [1, 2 * b, b * b + F(121, 100)]]
    block = RationalPlant(
        [1, 0, 0], [sum(pairs[0][i] * pairs[1][j - i] for i in range(3) if 0 <= j - i < 3) for j in range(5)]
    )
    assert circle_largest(block).largest.high < 1


def test_leonov_bragin_kuznetsov_is_not_certified():
    # tanh, in [0, 1], oscillates for ever although linear gains are stable up to 1000/101; poles at +-i are refused
    # H from phi-free form: sigma = x1 - 10.1 x3 - .1 x4, mu = -phi
    s2, s = [1, 0, 1], [1, 1, 1]
    first, second = exact(10, "-10.1"), exact("0.1", "10.1")  # x1 = (10 s - 10.1) mu/(s^2 + 1); -10.1 x3 - .1 x4
    numerator = [a + b for a, b in zip(np.convolve(first, s), np.convolve(second, s2), strict=True)]
    block = RationalPlant(numerator, [int(c) for c in np.convolve(s2, s)])
    assert hurwitz_limit(block).middle == pytest.approx(1000 / 101, rel=1e-12)
    with pytest.raises(AssumptionError, match="2 poles on the imaginary axis"):
        circle_largest(block)
    assert circle_largest(block, lower=F(1, 1000)).largest.low < 1


def test_switching_at_random_inside_the_sector_does_not_destabilise():
    # discrete example 1 in companion form, 300 random switching sequences between 0 and k
    rng = np.random.default_rng(3)
    block = RationalPlant(exact(".1", 0), exact(1, "-1.8", ".81"), dt=1)
    k = circle_largest(block).largest.low
    A, b, c = np.array([[1.8, -0.81], [1.0, 0.0]]), np.array([1.0, 0.0]), np.array([0.1, 0.0])
    x = rng.normal(size=(300, 2))
    for _ in range(400):
        sigma = x @ c
        x = x @ A.T - np.outer(k * rng.integers(0, 2, 300) * sigma, b)
    assert abs(x).max() < 1e-9


@given(stable_blocks(largest=4), st.fractions(-5, 5, max_denominator=16), st.booleans())
def test_encirclements_are_the_winding_number_of_the_plot(block, gain, unstable):
    if unstable:
        block = RationalPlant(
            block.numerator, [float(c) for c in np.convolve([float(c) for c in block.denominator], [1, -2])]
        )
    assume(gain)
    # a peak narrower than the grid is jumped over
    for k in (F(0), gain):
        roots = np.roots(np.polyadd([float(c) for c in block.denominator], [float(k * c) for c in block.numerator]))
        assume((abs(roots.real) > 1e-3 * abs(roots)).all())
    omega = np.concatenate([-np.geomspace(1e5, 1e-5, 60_001), np.geomspace(1e-5, 1e5, 60_001)])
    values = 1 + float(gain) * block.transfer(1j * omega)
    steps = np.angle(values[1:] / values[:-1])
    assume(abs(steps).max() < 0.5)  # fine enough to be counted; a near miss of -1/k is not
    closing = np.angle(values[0] / values[-1])
    assume(abs(closing) < 0.1)
    turns = (steps.sum() + closing) / (2 * np.pi)
    assert encirclements(block, gain).counterclockwise == round(turns)
    assert abs(turns - round(turns)) < 1e-6


def test_nothing_is_counted_through_the_point_itself():
    with pytest.raises(AssumptionError, match="runs through"):
        encirclements(RationalPlant([1], [1, 3, 2, 0]), F(6))
    with pytest.raises(InputError, match="not zero"):
        encirclements(OSCILLATOR, F(0))


@pytest.mark.parametrize(
    ("sector", "words"),
    [
        (Sector(1, 2), "outside the disc with the diameter [-1, -0.5]"),
        (Sector(-2, -1), "outside the disc with the diameter [0.5, 1]"),
        (Sector(-1, 2), "inside the disc with the diameter [-0.5, 1]"),
        (Sector(0, 2), "right of the line Re H = -0.5"),
        (Sector(-2, 0), "left of the line Re H = 0.5"),
        (Sector(0, math.inf), "right of the imaginary axis"),
        (Sector(2, math.inf), "outside the disc with the diameter [-0.5, 0]"),
    ],
)
def test_the_region_is_named_by_the_signs_of_the_sector(sector, words):
    assert region(sector) == words


# (x - 2)^2/(x + 1)^2 touches 0 at 2; (x - 1)/(x + 1) starts at its least value; 1/(1 + x) has it in the limit
@pytest.mark.parametrize(
    ("U", "D", "least", "where"),
    [
        ([4, -4, 1], [1, 2, 1], 0, 2),
        ([-1, 1], [1, 1], -1, 0),
        ([1], [1, 1], 0, math.inf),
        ([1, -2], [1, 0, 1], -0.618033988749895, 1.6180339887498949),
    ],
)
def test_the_infimum_of_a_rational_function(U, D, least, where):
    found = infimum(fmpq_poly(U), fmpq_poly(D))
    assert found.low <= arb(least) + arb("1e-15")
    assert float(found.low) == pytest.approx(least, abs=1e-15)
    assert found.where == pytest.approx(where)


def test_an_infimum_of_zero_is_zero():
    found = infimum(fmpq_poly([4, -4, 1]), fmpq_poly([1, 2, 1]))
    assert found.low == 0 == found.high
    assert nonnegative_from_zero(fmpq_poly([4, -4, 1]))
    assert not nonnegative_from_zero(fmpq_poly([-4, 8, -5, 1]))
    with pytest.raises(ValueError, match="infimum needs"):
        infimum(fmpq_poly([1, 1]), fmpq_poly([1]))


def test_the_exact_test_steps_below_a_guess_that_is_too_large():
    # 1 + k (-1) > 0 on [0, inf] if and only if k < 1
    assert 1 - 1e-15 < largest_below(fmpq_poly([1]), fmpq_poly([-1]), 1.0) < 1
    assert 0 < largest_below(fmpq_poly([1]), fmpq_poly([-1]), 1.5) < 1
    assert largest_below(fmpq_poly([1]), fmpq_poly([-1]), 1e-30, F(1)) is None


def test_an_answer_has_no_truth_value():
    with pytest.raises(TypeError):
        bool(replace(circle_largest(OSCILLATOR)))


def test_the_advice_after_a_failure_suits_the_time():
    """Circle reaches 4/3 and, for the motor sampled, 0.9505; Popov's criterion has no such form in discrete time."""
    ours = circle_criterion(RationalPlant([1], [1, 3, 2, 0]), Sector(0, 2)).reason
    assert ours.endswith("for nonlinearities that do not change with time, Popov's may prove more")
    sampled = RationalPlant(exact("0.0048", "0.0047"), exact("1", "-1.905", "0.905"), exact("0.1")[0])
    theirs = circle_criterion(sampled, Sector(0, 5)).reason
    assert "opov" not in theirs
    assert theirs.endswith("max_slope may prove more")


# inf Re H of the oscillator is -1/3; of 1/(s + 1) it is 0, and of (s + 2)/(s + 1)^2 Re H >= 0 holds too
@pytest.mark.parametrize(
    ("block", "k", "may"),
    [
        (OSCILLATOR, math.nextafter(3, 0), True),
        (OSCILLATOR, 3.0, False),
        (OSCILLATOR, math.inf, False),
        (RationalPlant([1], [1, 1]), math.inf, True),
        (RationalPlant([1, 2], [1, 2, 1]), math.inf, True),
        (RationalPlant([1, 3], [1, 2, 1]), math.inf, False),
    ],
)
def test_a_quick_test_says_how_far_the_circle_may_go(block, k, may):
    assert circle_may_reach(block, k, lower=F(0)) == may == (circle_largest(block).largest.low >= k)


# z + 1 + k has its root inside for -2 < k < 0, and every class [-1/2, k] with k < 0 is proved: the largest double of
# these, -5e-324, is no end to speak of.
@pytest.mark.parametrize(("plant", "lower"), [("1/(z + 1)", F(-1, 2)), ("-1/(s*(s + 1))", F(-1))])
def test_a_class_that_reaches_up_to_zero_ends_at_a_number_to_speak_of(plant, lower):
    found = max_sector(plant, lower=lower)
    assert lower * F(11, 10**13) < F(found.largest.low) <= lower / 10**12
    assert found.closed
    assert "in between nothing" not in str(found)

"""Stable gain intervals against Routh's and Schur's tests, closed forms, and the ends worked out by hand."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.inequality.checks import check_plant, require_well_posed, well_posed
from lure.analysis.inequality.gains import (
    gain_ends,
    gain_intervals,
    hurwitz_criterion,
    hurwitz_largest,
    hurwitz_limit,
    is_stable_gain,
    simplest_between,
    unstable_gain,
)
from lure.analysis.questions import max_sector
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

F = Fraction
_COEFFICIENTS = st.fractions(min_value=-4, max_value=4, max_denominator=8)


def exact(*texts):
    return [F(str(text)) for text in texts]


def routh(coefficients):
    """Routh's reduction on descending coefficients: whether all roots have negative real part."""
    p = list(coefficients)
    while len(p) > 1:
        if not p[0] * p[1] > 0:
            return False
        ratio = p[0] / p[1]
        p = [c - ratio * p[i + 1] if i % 2 == 0 and i + 1 < len(p) else c for i, c in enumerate(p)][1:]
    return p[0] != 0


def schur(coefficients):
    """Schur's recursion on descending coefficients: whether all roots lie in the open unit disc."""
    p = list(coefficients)
    while len(p) > 1:
        if abs(p[-1]) >= abs(p[0]):
            return False
        p = [(p[0] * a - p[-1] * b) for a, b in zip(p, reversed(p), strict=True)][:-1]
    return p[0] != 0


def closed_loop(block, gain):
    padded = (F(0),) * (block.order + 1 - len(block.numerator)) + block.numerator
    return [d + gain * n for n, d in zip(padded, block.denominator, strict=True)]


def holds(interval, gain):
    low, high = interval.lower, interval.upper
    return (low.high is None or low.high < gain) and (high.low is None or gain < high.low)


@st.composite
def blocks(draw, *, largest=6):
    """Blocks of order 1 to `largest`, one third with lightly damped poles, one third with nearly cancelling factors."""
    order = draw(st.integers(1, largest))
    denominator = [F(1)]
    while len(denominator) <= order:
        size, damping = (
            draw(st.fractions(F(1, 4), 4, max_denominator=6)),
            draw(st.sampled_from([F(1), F(1, 8), F(1, 10**6)])),
        )
        factor = (
            [F(1), size] if len(denominator) == order or draw(st.booleans()) else [F(1), 2 * damping * size, size**2]
        )
        denominator = times(denominator, factor)
    numerator = draw(st.lists(_COEFFICIENTS, min_size=1, max_size=order + 1))
    if draw(st.booleans()):
        root = draw(_COEFFICIENTS)
        numerator = times(numerator, [F(1), root])[: order + 1]
        denominator = times(denominator, [F(1), root + F(1, 10**9)])
    return RationalPlant(numerator, denominator)


def times(p, q):
    result = [F(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return result


@given(blocks(), st.lists(st.fractions(-50, 50, max_denominator=100), min_size=1, max_size=6))
def test_a_gain_is_in_an_interval_if_and_only_if_routh_says_stable(block, gains):
    intervals = gain_intervals(block)
    for gain in [*gains, F(0)]:
        polynomial = closed_loop(block, gain)
        stable = polynomial[0] != 0 and routh(polynomial)
        assert is_stable_gain(block, gain) is stable
        assert any(holds(interval, gain) for interval in intervals) is stable


@given(
    st.lists(_COEFFICIENTS, min_size=1, max_size=4),
    st.lists(_COEFFICIENTS, min_size=4, max_size=4),
    st.lists(st.fractions(-5, 5, max_denominator=30), max_size=5),
)
def test_in_discrete_time_schur_decides(numerator, tail, gains):
    block = RationalPlant(numerator, [1, *tail], dt=1)
    intervals = gain_intervals(block)
    for gain in [*gains, F(0)]:
        polynomial = closed_loop(block, gain)
        stable = polynomial[0] != 0 and schur(polynomial)
        assert is_stable_gain(block, gain) is stable
        assert any(holds(interval, gain) for interval in intervals) is stable


@given(blocks(largest=4))
def test_just_inside_an_end_is_stable_and_the_end_is_not(block):
    for interval in gain_intervals(block):
        for end, inward in ((interval.lower, 1), (interval.upper, -1)):
            if end.low is None:
                continue
            step = inward * F(1, 10**9) * max(abs(end.low), F(1, 10**9))
            if holds(interval, end.low + step):
                assert routh(closed_loop(block, end.low + step))
            assert end.exact is None or not routh(closed_loop(block, end.exact))
            assert end.value.low <= end.low <= end.high <= end.value.high
            assert end.value.width <= 1e-12 * abs(end.value.low)


# s^3 + (a+b) s^2 + ab s + k: Hurwitz if and only if 0 < k < ab(a+b), roots on the axis at w^2 = ab
@given(st.fractions(F(1, 50), 100, max_denominator=50), st.fractions(F(1, 50), 100, max_denominator=50))
def test_three_lags_with_an_integrator(a, b):
    block = RationalPlant([1], [1, a + b, a * b, 0])
    (interval,) = gain_intervals(block)
    limit = a * b * (a + b)
    assert interval.lower.exact == 0
    assert interval.upper.low <= limit <= interval.upper.high
    assert interval.upper.frequencies == pytest.approx([math.sqrt(a * b)])
    found = hurwitz_limit(block)
    assert F(found.low) <= limit <= F(found.high)
    assert found.width <= 1e-12 * found.low


@given(
    blocks(largest=5), st.fractions(F(1, 50), 50, max_denominator=50), st.fractions(F(1, 50), 50, max_denominator=50)
)
def test_the_unit_of_time_changes_nothing_and_a_gain_divides(block, speed, gain):
    def scaled(coefficients, factor):
        return [factor * c * speed ** (-power) for power, c in enumerate(reversed(coefficients))][::-1]

    faster = RationalPlant(scaled(block.numerator, gain), scaled(block.denominator, F(1)))
    before, after = gain_intervals(block), gain_intervals(faster)
    assert len(before) == len(after)
    for old, new in zip(before, after, strict=True):
        for x, y in ((old.lower, new.lower), (old.upper, new.upper)):
            assert (x.low is None) == (y.low is None)
            assert x.low is None or (x.low <= gain * y.high and gain * y.low <= x.high)
            frequencies = [speed * w if 0 < w < math.inf else w for w in x.frequencies]
            assert y.frequencies == pytest.approx(frequencies, rel=1e-9)


def test_the_gain_of_the_discrete_example_is_exactly_25_over_23():
    # z^2 + (2k - 1/2) z + 23k/25: roots leave the disc together when their product is 1
    block = RationalPlant([2, F(23, 25)], [1, F(-1, 2), 0], dt=1)
    (interval,) = gain_intervals(block)
    assert interval.upper.exact == F(25, 23)
    # cos w = -(2k - 1/2)/2 there
    assert interval.upper.frequencies == pytest.approx([math.acos(-(2 * 25 / 23 - 0.5) / 2)])
    assert interval.lower.exact == F(-25, 146)  # 1 + k H(1) = 0
    assert is_stable_gain(block, F(25, 23) - F(1, 10**30))
    assert not is_stable_gain(block, F(25, 23))


@pytest.mark.parametrize(
    ("numerator", "denominator", "limit"),
    [
        ([1, "-0.2", "-0.1"], [1, 2, 1, 1], 4.5894542),
        ([1, 0, 0], [1, ".2", 6, ".1", 1], math.inf),
        ([-1, 0, 0], [1, ".2", 6, ".1", 1], 3.5),
        ([1, 0, 0], [1, ".0003", 10, ".0021", 9], math.inf),
        ([-1, 0, 0], [1, ".0003", 10, ".0021", 9], 12 / 7),
        ([1, 0, 0], [1, 2, 2, 1], math.inf),
        ([1], [1, 3, 3, 1], 8),
        ([1, -1, 10], [1, 1, 25], 1),
        ([1], [1, 1, 1, 0], 1),
    ],
)
def test_published_limits(numerator, denominator, limit):
    found = hurwitz_limit(RationalPlant(exact(*numerator), exact(*denominator)))
    assert found.middle == pytest.approx(limit, rel=1e-8)


@pytest.mark.parametrize(
    ("numerator", "denominator", "limit"),
    [
        ([".1", 0], [1, "-1.8", ".81"], 36.1),
        ([1, "-1.95", ".9", ".05"], [1, "-2.8", "3.5", "-2.412", ".7209"], 2.7455),
        ([-1, "1.95", "-.9", "-.05"], [1, "-2.8", "3.5", "-2.412", ".7209"], 0.312370),
        (["-.5", ".1"], [1, "-.9", ".79", ".089"], 2.4475),
    ],
)
def test_published_limits_in_discrete_time(numerator, denominator, limit):
    found = hurwitz_limit(RationalPlant(exact(*numerator), exact(*denominator), dt=1))
    assert found.middle == pytest.approx(limit, rel=2e-6)


# d + k n = s^3 + (1 + e) s^2 + (1 + e) s + 1 + 2e, e = k - 1; Routh: e > -1/2 and (1 + e)^2 > 1 + 2e, that is e != 0
def test_roots_that_only_touch_the_axis_split_an_interval():
    block = RationalPlant([1, 1, 2], [1, 0, 0, -1])
    below, above = gain_intervals(block)
    assert (below.lower.exact, below.upper.exact, above.lower.exact) == (F(1, 2), 1, 1)
    assert above.upper.value.high == math.inf
    assert below.upper.frequencies == pytest.approx([1.0])
    assert hurwitz_limit(block, F(3, 4)).high == 1
    assert hurwitz_limit(block, F(1)).high == math.inf
    assert unstable_gain(block, Sector(F(3, 4), 2)) == 1
    assert unstable_gain(block, Sector(1, 2)) == 1  # +-i on the axis: no single pole at 0, so the lower end counts


@pytest.mark.parametrize(
    ("top", "bottom", "dt"),
    [
        ([1], [1, 0, 0], None),
        ([1, 1], [1, 0, 0], None),  # every k > 0 is stable: s^2 + k s + k
        ([1, 0], [1, 0, 1], None),  # s^2 + k s + 1; under phi = 0 the solutions swing for ever
        ([1, "-1/2"], [1, -2, 1], 1),  # z = 1 twice; z^2 - (2 - k) z + 1 - k/2
        ([1], [1, 1], 1),  # z = -1
    ],
)
def test_a_lower_gain_that_leaves_more_than_one_pole_at_zero_refutes_every_class(top, bottom, dt):
    block = RationalPlant(exact(*map(str, top)), exact(*map(str, bottom)), dt)
    found = max_sector(block)
    assert (found.verdict, found.refuted_at, found.hurwitz.high) == (Verdict.REFUTED, 0, 0)
    assert found.witness.data["gain"] == "0"
    assert hurwitz_largest(block).verdict is Verdict.REFUTED
    assert unstable_gain(block, Sector(0, F(1, 8))) is not None


def test_one_simple_pole_at_zero_refutes_nothing():
    assert max_sector(([1], [1, 0])).refuted_at is None
    assert max_sector(([1], [1, -1]), lower=1).refuted_at is None  # 1/(s - 1 + 1)


def test_two_frequencies_with_the_same_irrational_gain():
    # d + k n = (s + 2 + k)(s^2 + 3 + k)(s^2 + 5 + k) for k^2 = 2, both roots
    block = RationalPlant([1, 2, 12, 8, 33], [1, 2, 8, 20, 17, 50])
    double = [end for end in gain_ends(block) if len(end.frequencies) == 2]
    for end, root in zip(double, (-math.sqrt(2), math.sqrt(2)), strict=True):
        assert end.value.middle == pytest.approx(root, rel=1e-15)
        assert end.frequencies == pytest.approx([math.sqrt(3 + root), math.sqrt(5 + root)])
        assert end.exact is None
    assert isinstance(unstable_gain(RationalPlant([1], [1, 1, 1, 0]), Sector(0, 2)), Fraction)


@pytest.mark.parametrize(
    ("numerator", "denominator", "expected"),
    [
        ([1], [1, 0, 1], []),  # H real on the axis: roots symmetric to it for every gain
        ([1], [1, 0, 0], []),
        ([1, 1], [1, 0, 0], [(0, math.inf)]),
        ([0], [1, 1], [(-math.inf, math.inf)]),
        ([0], [1, -1], []),
        ([3], [1], [(-math.inf, -1 / 3), (-1 / 3, math.inf)]),
        ([1, 2], [1, 1], [(-math.inf, -1), (-0.5, math.inf)]),  # a pole passes through infinity at 1 + k D = 0
        ([1, 2], [1, 2], [(-math.inf, -1), (-1, math.inf)]),
        ([1, -2], [1, -2], []),
        ([1, 0], [1, 1, 0], []),
        ([1, 0], [1, 0, 1], [(0, math.inf)]),
        ([12], [1, 2, -3], [(0.25, math.inf)]),
    ],
)
def test_degenerate_blocks(numerator, denominator, expected):
    found = gain_intervals(RationalPlant(numerator, denominator))
    ends = [end.value.middle for one in found for end in (one.lower, one.upper)]
    assert ends == pytest.approx([end for pair in expected for end in pair])


# s^3 + 3 s^2 + 3 s + 1 + k (s^2 + 4): Routh (3 + k) 3 > 1 + 4 k, that is k < 8; the zeros +-2i are the limit k -> inf
def test_zeros_on_the_axis_are_no_ends():
    (interval,) = gain_intervals(RationalPlant([1, 0, 4], [1, 3, 3, 1]))
    assert (interval.lower.exact, interval.upper.exact) == (F(-1, 4), 8)


def test_a_gain_very_close_to_an_irrational_end_is_told_apart():
    block = RationalPlant([1, 2, 12, 8, 33], [1, 2, 8, 20, 17, 50])  # roots on the axis at k = sqrt 2, see above
    scale = 10**400
    below = F(math.isqrt(2 * scale**2), scale)
    for mark, side in ((below, "above"), (below + F(1, scale), "below")):
        end = next(end for end in gain_ends(block, (mark,)) if abs(end.value.middle - math.sqrt(2)) < 1e-9)
        assert end.exact is None
        assert end.low > mark if side == "above" else end.high < mark


def test_a_hidden_mode_at_minus_one_leaves_no_gain():
    assert gain_intervals(RationalPlant([1, 1], [1, F(1, 2), F(-1, 2)], dt=1)) == ()
    assert gain_intervals(RationalPlant([0], [1, 1], dt=1)) == ()


def test_the_answer_never_speaks_of_nonlinear_laws():
    answer = hurwitz_largest(RationalPlant([1], [1, 3, 2, 0]))
    assert answer.verdict is Verdict.INCONCLUSIVE
    assert answer.evidence is Evidence.CERTIFIED
    assert answer.largest.low < 6 <= answer.largest.high
    assert answer.largest.low > 6 * (1 - 1e-12)
    nothing = hurwitz_largest(RationalPlant([1], [1, 0, 1]))
    assert nothing.verdict is Verdict.REFUTED
    assert nothing.witness == "phi = 0"
    assert hurwitz_largest(RationalPlant([12], [1, 2, -3]), lower=F(1, 4)).largest.low == math.inf


def test_a_sector_with_an_unstable_gain_is_refuted_by_it():
    block = RationalPlant([1], [1, 3, 2, 0])
    assert hurwitz_criterion(block, Sector(0, 5)).verdict is Verdict.INCONCLUSIVE
    assert hurwitz_criterion(block, Sector(0, 6)).witness == "phi = 6 sigma"
    refuted = hurwitz_criterion(block, Sector(-1, 5))
    assert refuted.verdict is Verdict.REFUTED
    assert hurwitz_criterion(RationalPlant([1], [1, 1]), Sector(-math.inf, 0)).verdict is Verdict.REFUTED


@given(st.fractions(-9, 9, max_denominator=1000), st.fractions(F(1, 10**6), 1))
def test_the_simplest_fraction_of_an_interval(low, width):
    high = low + width
    found = simplest_between(low, high)
    assert low <= found <= high
    smaller = range(1, min(found.denominator, 200))
    assert all(math.ceil(low * q) > math.floor(high * q) for q in smaller)


# Lur'e's indirect control x' = -x + xi, xi' = u, sigma = r xi - c x: H = (r s + r - c)/(s (s + 1))
@pytest.mark.parametrize(
    ("r", "c", "refusal"), [(2, 1, None), (1, 2, "residue .* is -1;"), (1, 1, "s = 0 is not seen")]
)
def test_indirect_control(r, c, refusal):
    block = RationalPlant([r, r - c], [1, 1, 0])
    if refusal is None:
        assert check_plant(block).case == "critical"
    else:
        with pytest.raises(AssumptionError, match=refusal):
            check_plant(block)


@pytest.mark.parametrize(
    ("block", "lower", "error", "words"),
    [
        (RationalPlant([1, 1], [1, 0, 0]), F(0), AssumptionError, "multiplicity 2"),
        (RationalPlant([1], [1, 0, 1]), F(0), AssumptionError, "2 poles on the imaginary axis; no linear gain"),
        (RationalPlant([12], [1, 2, -3]), F(0), AssumptionError, r"1 pole in the right .* gain in \(0.25, inf\)"),
        (RationalPlant([1], [1, 1], dt=1), F(0), AssumptionError, "1 pole on the unit circle"),
        (RationalPlant([1, 1], [1, F(1, 2), F(-1, 2)], dt=1), F(0), AssumptionError, "z = -1 is not seen"),
        (RationalPlant([1, -2], [1, -1, -2]), F(0), AssumptionError, "not strictly in the left half-plane"),
        (RationalPlant([1, 0], [1, 1]), F(-1), InputError, "not well posed"),
        (None, F(0), InputError, "give a RationalPlant"),
    ],
)
def test_refusals_name_the_reason(block, lower, error, words):
    with pytest.raises(error, match=words):
        check_plant(block, lower=lower)


def test_an_unstable_block_is_admitted_once_shifted():
    assert check_plant(RationalPlant([12], [1, 2, -3]), lower=F(1, 2)).case == "stable"
    assert check_plant(RationalPlant([12], [1, 2, -3]), lower=F(1, 4)).case == "critical"


@pytest.mark.parametrize(
    ("direct", "lower", "upper", "expected"),
    [
        (1, 0, 5, True),
        (-1, 0, F(1, 2), True),
        (-1, 0, 1, False),
        (-1, 2, 5, True),
        (-1, 0, 5, False),
        (0, -3, math.inf, True),
        (1, -2, math.inf, False),
        (1, -2, F(-3, 2), True),
        (-1, 0, math.inf, False),
    ],
)
def test_well_posed_means_no_gain_with_a_vanishing_return_difference(direct, lower, upper, expected):
    block = RationalPlant([direct, 1], [1, 1])
    assert well_posed(block, upper, lower=F(lower)) is expected
    if not expected:
        with pytest.raises(InputError, match="not well posed"):
            require_well_posed(block, upper, lower=F(lower))

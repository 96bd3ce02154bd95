"""Every positive answer of the published tables gets a certificate at the criterion's reach, and none beyond."""

import copy
import itertools
import json
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.answers.rods import rod_largest
from analysis.certificates.arithmetic import Form, Rejected
from analysis.certificates.balls import box
from analysis.certificates.checker import Proved, check
from analysis.certificates.covers import ORDER, CoverTests, Uncovered, cover, quick_reach
from analysis.certificates.drafts import completed
from analysis.certificates.multipliers import rod_circle_bound, rod_theta
from analysis.certificates.proposals import answer_draft, certified, energy_draft
from analysis.certificates.systems import laws_of, system_of
from analysis.criteria.circle import circle_criterion, circle_largest
from analysis.criteria.hurwitz import hurwitz_largest
from analysis.criteria.jury_lee import jury_lee_criterion, jury_lee_largest
from analysis.criteria.off_axis import off_axis_criterion, off_axis_largest
from analysis.criteria.park import park_criterion, park_largest
from analysis.criteria.popov import popov_criterion, popov_largest
from analysis.criteria.tsypkin import tsypkin_criterion, tsypkin_largest
from analysis.criteria.zames_falb import zames_falb_largest
from analysis.criteria.zames_falb_discrete import zames_falb_discrete_largest
from analysis.dead_time import criteria as dead_time
from analysis.evidence import Verdict
from lure.delay import DelayBlock
from lure.errors import AssumptionError, InputError
from lure.law_class import LawClass
from lure.loop_library import builtin_loops
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds
from lure.state_space import StateSpaceBlock
from lure.systems import builtin_system
from lure.upwind import upwind
from lure.waves import RodBlock

CLOSE, ZAMES_FALB = Fraction(1, 10**6), Fraction(1, 10**3)


def exact(numerator, denominator, dt=None):
    """A block of decimals."""
    return RationalBlock([Fraction(c) for c in numerator.split()], [Fraction(c) for c in denominator.split()], dt)


DISCRETE = {
    1: exact("0.1 0", "1 -1.8 0.81", 1),
    2: exact("1 -1.95 0.9 0.05", "1 -2.8 3.5 -2.412 0.7209", 1),
    3: exact("-1 1.95 -0.9 -0.05", "1 -2.8 3.5 -2.412 0.7209", 1),
    5: exact("-0.5 0.1", "1 -0.9 0.79 0.089", 1),
    6: exact("2 0.92", "1 -0.5 0", 1),
}
CONTINUOUS = {
    1: exact("1 -0.2 -0.1", "1 2 1 1"),
    3: exact("1 0 0", "1 0.2 6 0.1 1"),
    4: exact("-1 0 0", "1 0.2 6 0.1 1"),
    5: exact("1 0 0", "1 0.0003 10 0.0021 9"),
    6: exact("-1 0 0", "1 0.0003 10 0.0021 9"),
    7: exact("1 0 0", "1 2 2 1"),
}
THIRD_ORDER = exact("1", "1 3 2 0")


def raised(certificate, factor):
    """The same certificate for a class that is larger by a factor."""
    larger = {
        key: value for key, value in copy.deepcopy(certificate).items() if key not in ("hypotheses", "conclusion")
    }
    if larger["proof"]["method"] == "polynomial":
        larger["proof"] = {"method": "polynomial"}
    laws = larger["laws"]
    low = Fraction(laws["sector"][0])
    high = str(low + (Fraction(laws["sector"][1]) - low) * factor)
    laws["sector"][1] = high
    if laws["slope"] is not None and laws["slope"][1] != "inf":
        laws["slope"][1] = high
    return larger


def assert_sharp(block, answer, within=CLOSE):
    """A certificate close to the reach of the criterion, accepted as text, and rejected a millionth beyond it."""
    assert answer.verdict is Verdict.PROVED
    found = certified(block, answer)
    lower = Fraction(answer.law_class.sector.lower)
    reach = Fraction(answer.largest.low) - lower
    assert reach * (1 - within) <= found.upper - lower <= reach
    assert isinstance(check(json.dumps(found.proved.certificate)), Proved)
    if math.isfinite(answer.largest.high):  # no multiplier reaches it
        beyond = (Fraction(answer.largest.high) - lower) / (found.upper - lower) * (1 + CLOSE)
        with pytest.raises(Rejected):
            check(completed(raised(found.proved.certificate, beyond)))
    return found


# G. Zames-Falb tables: J. Carrasco et al. 2019; see DISCRETE.  The circle criterion for example 1, say, reaches 0.7934.
@pytest.mark.parametrize(
    ("example", "circle", "tsypkin"),
    [(1, 0.7934, 3.8), (2, 0.1984, 0.2427), (3, 0.1379, 0.1379), (5, 1.0273, 1.0273), (6, 0.651, 0.651)],
)
def test_discrete_circle_and_difference_criteria_are_certified_where_they_end(example, circle, tsypkin):
    block = DISCRETE[example]
    assert float(assert_sharp(block, circle_largest(block)).upper) == pytest.approx(circle, abs=6e-5)
    assert float(assert_sharp(block, tsypkin_largest(block)).upper) == pytest.approx(tsypkin, abs=6e-5)
    assert_sharp(block, jury_lee_largest(block))


@pytest.mark.parametrize(
    ("example", "odd", "reach"),
    [
        pytest.param(1, True, 13.5115, marks=pytest.mark.slow),
        (1, False, 13.0283),
        pytest.param(2, True, 1.1056, marks=pytest.mark.slow),
        pytest.param(2, False, 0.80274, marks=pytest.mark.slow),
        pytest.param(3, True, 0.3121, marks=pytest.mark.slow),
        (3, False, 0.3121),
        pytest.param(5, True, 2.4475, marks=pytest.mark.slow),
        (5, False, 2.4475),
        (6, True, 1.087),
        (6, False, 0.91146),
    ],
)
def test_discrete_zames_falb_multipliers_are_certified(example, odd, reach):
    found = assert_sharp(DISCRETE[example], zames_falb_discrete_largest(DISCRETE[example], odd=odd))
    assert float(found.upper) == pytest.approx(reach, rel=2e-4)
    assert found.proved.certificate["laws"]["odd"] is odd


@pytest.mark.parametrize(
    ("example", "circle", "popov_nonnegative", "popov", "park"),
    [
        (1, 1.24307, 1.24307, 1.763614, 4.5894),
        (3, 0.326273, 0.326273, 0.384166, 0.788),
        (4, 0.308094, 0.364103, 0.364166, 0.708),
        (5, 4.00040e-4, 0.00183159, 0.001833696, 0.0018333),
        (6, 3.99960e-4, 3.99960e-4, 0.001832717, 0.0018325),
        (7, 8.12086, 8.12086, 8.89898, math.inf),
    ],
)
def test_continuous_criteria_are_certified_where_they_end(example, circle, popov_nonnegative, popov, park):
    block = CONTINUOUS[example]
    answers = (
        (circle_largest(block), circle),
        (popov_largest(block, sign="nonnegative"), popov_nonnegative),
        (popov_largest(block), popov),
        (park_largest(block), park),
    )
    for answer, reach in answers:
        assert float(answer.largest.low) == pytest.approx(reach, rel=2e-3)
        if math.isfinite(reach):
            assert_sharp(block, answer)
    assert_sharp(block, off_axis_largest(block))


@pytest.mark.parametrize(
    ("example", "odd", "least"),
    [
        (1, False, 4.5894),
        pytest.param(3, False, 2.08, marks=pytest.mark.slow),
        pytest.param(4, False, 1.32, marks=pytest.mark.slow),
        pytest.param(5, False, 0.0056, marks=pytest.mark.slow),
        pytest.param(5, True, 0.0058, marks=pytest.mark.slow),
        pytest.param(6, False, 0.0056, marks=pytest.mark.slow),
        pytest.param(6, True, 0.0058, marks=pytest.mark.slow),
        (7, False, 1e4),
    ],
)
def test_continuous_zames_falb_multipliers_are_certified(example, odd, least):
    block = CONTINUOUS[example]
    answer = zames_falb_largest(block, odd=odd)
    found = certified(block, answer)
    assert found.upper >= Fraction(least)
    assert isinstance(check(json.dumps(found.proved.certificate)), Proved)
    if math.isfinite(answer.largest.low):
        assert found.upper >= Fraction(answer.largest.low) * (1 - ZAMES_FALB)
    limit = hurwitz_largest(block).largest.high
    if math.isfinite(limit):
        with pytest.raises(Rejected):
            check(completed(raised(found.proved.certificate, Fraction(limit) / found.upper)))


# One simple pole at 0; limits in closed form, by the critical points of Re[(1 + i w theta) H].
@pytest.mark.parametrize(
    ("block", "circle", "popov"),
    [
        (exact("1", "1 1 0"), 1, math.inf),
        (exact("1", "1 3 2 0"), Fraction(4, 3), 6),
        (exact("1", "1 1 1 0"), Fraction(3, 4), 1),
        (exact("1", "1 0.1 1 0"), Fraction(9975, 100000), Fraction(1, 10)),
        (exact("1 2", "1 1 0"), 1, math.inf),
        (exact("1 1", "1 2 0"), math.inf, math.inf),
        (exact("2 1", "1 1 0"), math.inf, math.inf),  # indirect control with r = 2, c = 1
    ],
    ids=str,
)
def test_the_critical_case_is_certified(block, circle, popov):
    for answer, reach in ((circle_largest(block), circle), (popov_largest(block), popov)):
        if reach == math.inf:
            found = certified(block, answer)
            assert found.upper == "finite"
        else:
            found = assert_sharp(block, answer)
            assert found.upper >= reach * (1 - CLOSE)
        assert "set of equilibria" in found.proved.claim


# Popov reaches the Hurwitz limit of each: 8, 5/2, 1 (the last with theta = -3/7 and a direct term).
@pytest.mark.parametrize(
    ("block", "circle", "hurwitz"),
    [
        (exact("1", "1 3 3 1"), 4, 8),
        (RationalBlock([24], [1, 6, 11, 6]), 1.164456, 2.5),
        (exact("1 -1 10", "1 1 25"), 0.532958, 1),
    ],
    ids=str,
)
def test_companions_and_their_linear_gains_are_certified(block, circle, hurwitz):
    assert float(assert_sharp(block, circle_largest(block)).upper) == pytest.approx(circle, rel=1e-6)
    assert float(assert_sharp(block, popov_largest(block)).upper) == pytest.approx(hurwitz, rel=1e-9)
    gains = certified(block, hurwitz_largest(block))
    assert gains.proved.certificate["laws"]["linear"] is True
    assert hurwitz * (1 - CLOSE) < gains.upper < hurwitz
    with pytest.raises(Rejected):
        check(completed(raised(gains.proved.certificate, Fraction(hurwitz) / gains.upper)))


@pytest.mark.parametrize("name", sorted(builtin_loops()))
def test_every_proof_about_a_built_in_loop_has_a_certificate(name):
    block = builtin_loops()[name].block
    for largest in (circle_largest, popov_largest, off_axis_largest, park_largest, tsypkin_largest, jury_lee_largest):
        try:
            answer = largest(block)
        except (AssumptionError, InputError):
            continue
        if answer.verdict is Verdict.PROVED and math.isfinite(answer.largest.low):
            assert_sharp(block, answer)
        elif answer.verdict is Verdict.PROVED:
            found = certified(block, answer)
            assert found.upper == "finite" or found.upper >= 10**6


def test_hidden_modes_stay_in_the_system_and_forbid_unbounded_laws():
    # (s + 3)/((s + 3)(s + 1)^3): the circle criterion reaches 4 and Popov's 8, as without the factor s + 3
    block = exact("1 3", "1 6 12 10 3")
    found = assert_sharp(block, popov_largest(block))
    assert found.upper > 8 * (1 - CLOSE)
    assert len(found.proved.certificate["system"]["denominator"]) == 5
    # 1/s with the hidden mode s + 1: every finite k, but not all of them at once
    integrator = exact("1 1", "1 1 0")
    assert certified(integrator, popov_largest(integrator)).upper == "finite"
    with pytest.raises(Rejected, match="hidden modes"):
        check(completed(answer_draft(integrator, popov_largest(integrator), "inf")))


@pytest.mark.parametrize(
    ("block", "lower"),
    [
        (exact("12", "1 2 -3"), Fraction(1, 2)),  # 4/((s - 1)(s/3 + 1)), stable for gains above 1/4
        (exact("1", "1 3 3 1"), Fraction(-1, 2)),
        (exact("1 -1 10", "1 1 25"), Fraction(1, 10)),
        (exact("1", "1 3 2 0"), Fraction(1, 3)),
    ],
    ids=str,
)
def test_the_loop_is_shifted_by_the_lower_bound(block, lower):
    for largest in (circle_largest, popov_largest, off_axis_largest, park_largest):
        answer = largest(block, lower=lower)
        if math.isfinite(answer.largest.low):
            assert assert_sharp(block, answer).proved.certificate["laws"]["sector"][0] == str(lower)
        else:
            assert certified(block, answer).proved.certificate["laws"]["sector"][0] == str(lower)


def test_the_mirrored_circle_criterion_is_certified():
    # phi in [-inf, k] for -1/(s + 1) is -phi in [-k, inf] for 1/(s + 1): positive real after the shift if k < 1
    block = RationalBlock([-1], [1, 1])
    found = certified(block, circle_criterion(block, Sector(-math.inf, Fraction(1, 2))))
    assert found.proved.certificate["multiplier"] == {"mirrored": True}
    assert found.proved.certificate["laws"]["sector"] == ["-inf", "1/2"]
    with pytest.raises(Rejected):
        certified(block, circle_criterion(block, Sector(-math.inf, Fraction(1, 2))), Fraction(1))
    # the loop with the gain 0, the upper end, has a pole at 0: only the mirrored one covers it
    block = RationalBlock([-1], [1, 1, 0])
    found = certified(block, circle_criterion(block, Sector(Fraction(-1, 2), 0)))
    assert found.proved.certificate["multiplier"] == {"mirrored": True}


def test_a_discrete_integrator_is_critical():
    # Re 1/(e^{iw} - 1) = -1/2 at every w: k up to 2, where z - 1 + k has the root -1
    block = RationalBlock([1], [1, -1], 1)
    found = assert_sharp(block, circle_largest(block))
    assert found.upper >= 2 * (1 - CLOSE)
    assert "set of equilibria" in found.proved.claim


def test_laws_without_any_bound_are_certified_where_the_criterion_covers_them():
    block = exact("1", "1 1 0")  # theta > 1 gives Re[(1 + i w theta) H] = (theta - 1)/(1 + w^2)
    found = certified(block, popov_criterion(block, Sector(0, math.inf), theta=2), "inf")
    assert found.upper == "inf"
    assert found.proved.certificate["laws"]["sector"] == ["0", "inf"]


# exp(-s T)/(s + 1): the circle criterion reaches -1/inf Re H.
@pytest.mark.parametrize(
    "text", ["exp(-s/2)/(s + 1)", "exp(-0.3*s)/(s*(s + 1))", "(1 + exp(-s))/(s + 2)^2", "2/(s + 3) + exp(-2*s)/(s + 1)"]
)
def test_blocks_with_dead_time_are_certified_by_covers(text):
    block = DelayBlock.parse(text.replace("^", "**"))
    for largest in (dead_time.circle_largest, dead_time.popov_largest):
        try:
            answer = largest(block)
        except AssumptionError:
            continue
        found = assert_sharp(block, answer) if math.isfinite(answer.largest.low) else certified(block, answer)
        assert found.proved.certificate["proof"]["method"] == "cover"
        assert len(found.proved.certificate["proof"]["boxes"]) < 200


@pytest.mark.parametrize("cells", [1, 10, 200])
def test_the_scheme_of_the_rod_is_certified_by_structure(cells):
    scheme = upwind(builtin_system("paper-rod").rod, cells)
    popov = certified(scheme, rod_largest(scheme, "popov"))
    assert popov.upper == "inf"
    circle = certified(scheme, rod_largest(scheme, "circle"))
    bound = rod_circle_bound(scheme.rod)
    assert bound * (1 - CLOSE) < circle.upper < bound
    with pytest.raises(Rejected):
        completed(answer_draft(scheme, rod_largest(scheme, "circle"), bound))
    energy = check(completed(energy_draft(scheme)))
    assert isinstance(energy, Proved)
    assert energy.theorem == "rod-energy"


def test_the_rod_itself_is_certified_by_its_energy():
    block = RodBlock(builtin_system("paper-rod").rod)
    proved = check(completed(energy_draft(block)))
    assert proved.certificate["system"]["kind"] == "rod"
    assert proved.certificate["laws"]["sector"] == ["0", "inf"]


def test_a_matched_dashpot_takes_any_multiplier():
    # Z = A sqrt(rho E) = 1/2 exactly
    rod = builtin_system("paper-rod").rod
    matched = type(rod)(
        youngs_modulus=4, density=1, length=1, area=Fraction(1, 4), damping=Fraction(1, 2), compliance=1
    )
    assert rod_theta(matched) == Fraction(1, 2)  # the travel time L sqrt(rho/E)
    assert rod_circle_bound(matched) is None
    scheme = upwind(matched, 5)
    assert certified(scheme, rod_largest(scheme, "popov")).upper == "inf"


def test_a_rod_that_does_not_damp_has_no_multiplier():
    rod = builtin_system("paper-rod").rod
    free = type(rod)(youngs_modulus=4, density=1, length=1, area=1, damping=0, compliance=1)
    with pytest.raises(AssumptionError, match="positive"):
        rod_theta(free)


@given(
    poles=st.lists(st.integers(1, 20), min_size=1, max_size=4),
    gain=st.integers(1, 50),
    zero=st.integers(-5, 5),
    unit=st.sampled_from([Fraction(1), Fraction(1, 1000), Fraction(1000)]),
)
def test_random_lags_are_certified_at_the_very_number_reported(poles, gain, zero, unit):
    # s -> s/unit changes no reach; every reported number is exact, so no step down is needed
    denominator = [Fraction(1)]
    for pole in poles:
        denominator = [
            a + b for a, b in zip([*denominator, 0], [0, *(c * pole * unit for c in denominator)], strict=True)
        ]
    block = RationalBlock(
        [gain * unit ** len(poles) * zero * zero + gain] if len(poles) < 2 else [gain, zero], denominator
    )
    for largest in (circle_largest, popov_largest):
        answer = largest(block)
        if answer.verdict is Verdict.PROVED and math.isfinite(answer.largest.low):
            assert certified(block, answer).upper == Fraction(answer.largest.low)


def test_an_answer_that_says_too_much_is_lowered_and_not_stretched():
    block = CONTINUOUS[3]
    answer = circle_largest(block)
    reach = Fraction(answer.largest.low)
    too_much = reach * (1 + Fraction(1, 10**13))
    assert reach * (1 - Fraction(1, 10**9)) <= certified(block, answer, too_much).upper < too_much
    with pytest.raises(Rejected):
        certified(block, answer, 2 * reach)


@pytest.mark.parametrize("k", [Fraction(1, 3), Fraction(3, 10)])
def test_a_class_that_was_asked_about_is_certified_as_it_stands(k):
    block, bounds = CONTINUOUS[3], SlopeBounds(0, k)
    answers = (popov_criterion(block, Sector(0, k)), park_criterion(block, bounds), off_axis_criterion(block, bounds))
    for answer in answers:
        found = certified(block, answer, numbers="decimals as written")
        assert found.upper == k
        assert found.proved.certificate["numbers"] == "decimals as written"
    discrete = DISCRETE[6]
    for answer in (tsypkin_criterion(discrete, bounds), jury_lee_criterion(discrete, bounds)):
        assert certified(discrete, answer).upper == k


def test_where_no_one_multiplier_serves_every_finite_k_a_large_number_is_certified():
    block = CONTINUOUS[7]
    answer = park_largest(block)
    assert answer.largest.low == math.inf
    assert certified(block, answer).upper >= 10**9
    with pytest.raises(AssumptionError, match="give a number"):
        answer_draft(block, answer, "finite")


def test_boxes_are_neighbours_that_pass_and_end_where_the_tail_begins():
    def reach(a, most):
        return min(most, Fraction(1, 8) if a < 2 else Fraction(1))

    found = cover(CoverTests(reach, lambda a, b: False, lambda a: a >= 5, Fraction(1)))
    boxes = [[Fraction(end) for end in box] for box in found]
    assert boxes[0][0] == 0
    assert 5 <= boxes[-1][1] < 6
    assert all(one[1] == two[0] for one, two in itertools.pairwise(boxes))
    assert all(b - a <= reach(a, 1) for a, b in boxes)


def test_where_the_quick_test_would_need_tiny_boxes_the_slow_one_is_asked():
    def reach(a, most):
        return Fraction(1, 2**20) if 1 <= a < Fraction(3, 2) else most

    def inside(a, b):
        return b - a <= Fraction(1, 8)

    boxes = cover(CoverTests(reach, inside, lambda a: a >= 2, Fraction(1)))
    widths = {Fraction(b) - Fraction(a) for a, b in boxes if 1 <= Fraction(a) < Fraction(3, 2)}
    assert widths <= {Fraction(1, 16), Fraction(1, 4)}
    assert len(boxes) < 20


@pytest.mark.parametrize(
    ("fails", "reason"), [("inside", "does not pass"), ("beyond", "not outweighed"), ("length", "up to")]
)
def test_no_cover_is_no_proof(fails, reason):
    tests = CoverTests(
        lambda a, most: Fraction(1, 2**11 if fails == "length" else 2**20),
        lambda a, b: fails != "inside",
        lambda a: fails != "beyond" and a >= 2,
        Fraction(1),
    )
    with pytest.raises(Uncovered, match=reason):
        cover(tests)


@given(
    delays=st.lists(st.fractions(Fraction(1, 10), 5, max_denominator=20), min_size=1, max_size=2, unique=True),
    numbers=st.lists(st.fractions(-5, 5, max_denominator=10), min_size=9, max_size=9),
    left=st.fractions(0, 10, max_denominator=64),
)
def test_what_passes_the_quick_test_passes_the_checkers(delays, numbers, left):
    # the polynomial below Re F is built twice, in balls and in rationals: a length that is long enough must serve both
    u, v = iter(numbers), iter(reversed(numbers))
    F = Form({(Fraction(0), n): (abs(next(u)) + 1, Fraction(0)) for n in range(3)})
    F = F + Form({(tau, n): (next(u), next(v)) for tau in delays for n in range(3)})
    length = quick_reach(F, left, Fraction(16), critical=False)
    if length > Fraction(1, 2**20):
        assert box(F, left, left + length, ORDER)


def test_systems_are_written_in_exact_numbers():
    assert system_of(exact("0.1 0", "1 -1.8 0.81", 1)) == {
        "kind": "transfer",
        "time": "discrete",
        "numerator": ["1/10", "0"],
        "denominator": ["1", "-9/5", "81/100"],
    }
    assert system_of(DelayBlock.parse("exp(-s/2)/(s + 1) + 1/(s + 1)"))["terms"] == [["0", ["1"]], ["1/2", ["1"]]]
    half = system_of(StateSpaceBlock([[0, 1], [-2, -0.1]], [0, 1], [1, 0]))
    assert half["A"][1] == ["-2", str(Fraction(-0.1))]
    scheme = system_of(upwind(builtin_system("paper-rod").rod, 10))
    assert (scheme["E"], scheme["A"], scheme["k"], scheme["cells"]) == ("288000000", "1/40000", "1/5000", 10)
    with pytest.raises(InputError, match="exact data"):
        system_of(object())


def test_infinite_ends_of_a_class_say_which_kind_they_are():
    steep = LawClass(sector=Sector(0, 2), slope=SlopeBounds(0, math.inf))
    assert laws_of(steep, unbounded=False)["slope"] == ["0", "inf"]
    endless = LawClass.slope_restricted(0, math.inf, odd=True)
    assert laws_of(endless, unbounded=False)["slope"] == ["0", "finite"]
    assert laws_of(endless, unbounded=True)["sector"] == ["0", "inf"]
    assert laws_of(endless, unbounded=True, linear=True)["linear"] is True

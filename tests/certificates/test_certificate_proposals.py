"""Every positive answer of the published tables gets a certificate at the criterion's reach, and none beyond."""

import json
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plants import CONTINUOUS, DISCRETE
from plants import block as exact
from sharpness import CLOSE, ZAMES_FALB, assert_sharp, raised

from lure.analysis.certificates import blocks
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, check, inequality, polynomial_proof
from lure.analysis.certificates.drafts import _popov_polynomial, completed
from lure.analysis.certificates.proposals import certified, drafts
from lure.analysis.certificates.states import classes
from lure.analysis.certificates.systems import class_entry, system_of
from lure.analysis.inequality.gains import hurwitz_largest
from lure.analysis.theorems.circle import circle_criterion, circle_largest
from lure.analysis.theorems.differences import JURY_LEE, TSYPKIN, jury_lee_largest, tsypkin_largest
from lure.analysis.theorems.off_axis import off_axis_criterion, off_axis_largest
from lure.analysis.theorems.park import park_criterion, park_largest
from lure.analysis.theorems.popov import popov_criterion, popov_largest
from lure.analysis.theorems.zames_falb import zames_falb_largest
from lure.analysis.theorems.zames_falb_discrete import zames_falb_discrete_largest
from lure.analysis.verdict import Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.files.builtin import builtin_loops
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.rod.discretisation import upwind
from lure.rod.systems import builtin_system


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


@pytest.mark.slow_for("3-False-0.3121")
@pytest.mark.parametrize(
    ("example", "odd", "reach"),
    [
        pytest.param(1, True, 13.5115, marks=pytest.mark.thorough),
        (1, False, 13.0283),
        pytest.param(2, True, 1.1056, marks=pytest.mark.thorough),
        pytest.param(2, False, 0.80274, marks=pytest.mark.slow),
        pytest.param(3, True, 0.3121, marks=pytest.mark.thorough),
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
        pytest.param(3, False, 2.25, marks=pytest.mark.thorough),
        pytest.param(4, False, 1.34, marks=pytest.mark.thorough),
        pytest.param(5, False, 0.08, marks=pytest.mark.thorough),
        pytest.param(5, True, 0.11, marks=pytest.mark.thorough),
        pytest.param(6, False, 0.08, marks=pytest.mark.thorough),
        pytest.param(6, True, 0.108, marks=pytest.mark.thorough),
        (7, False, 1e4),
    ],
)
def test_continuous_zames_falb_multipliers_are_certified(example, odd, least):
    block = CONTINUOUS[example]
    answer = zames_falb_largest(block, odd=odd)
    assert answer.largest.low >= least
    found = certified(block, answer)
    assert found.upper >= Fraction(least) * (1 - ZAMES_FALB)
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
        (RationalPlant([24], [1, 6, 11, 6]), 1.164456, 2.5),
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
        check(completed(next(drafts(integrator, popov_largest(integrator), "inf"))[1]))


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
    block = RationalPlant([-1], [1, 1])
    found = certified(block, circle_criterion(block, Sector(-math.inf, Fraction(1, 2))))
    assert found.proved.certificate["multiplier"] == {"mirrored": True}
    assert found.proved.certificate["laws"]["sector"] == ["-inf", "1/2"]
    with pytest.raises(Rejected):
        certified(block, circle_criterion(block, Sector(-math.inf, Fraction(1, 2))), Fraction(1))
    # the loop with the gain 0, the upper end, has a pole at 0: only the mirrored one covers it
    block = RationalPlant([-1], [1, 1, 0])
    found = certified(block, circle_criterion(block, Sector(Fraction(-1, 2), 0)))
    assert found.proved.certificate["multiplier"] == {"mirrored": True}


def test_a_discrete_integrator_is_critical():
    # Re 1/(e^{iw} - 1) = -1/2 at every w: k up to 2, where z - 1 + k has the root -1
    block = RationalPlant([1], [1, -1], 1)
    found = assert_sharp(block, circle_largest(block))
    assert found.upper >= 2 * (1 - CLOSE)
    assert "set of equilibria" in found.proved.claim


def test_laws_without_any_bound_are_certified_where_the_criterion_covers_them():
    block = exact("1", "1 1 0")  # theta > 1 gives Re[(1 + i w theta) H] = (theta - 1)/(1 + w^2)
    found = certified(block, popov_criterion(block, Sector(0, math.inf), theta=2), "inf")
    assert found.upper == "inf"
    assert found.proved.certificate["laws"]["sector"] == ["0", "inf"]


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
    block = RationalPlant(
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
    for answer in (TSYPKIN.decide(discrete, bounds), JURY_LEE.decide(discrete, bounds)):
        assert certified(discrete, answer).upper == k


def test_where_no_one_multiplier_serves_every_finite_k_a_large_number_is_certified():
    block = CONTINUOUS[7]
    answer = park_largest(block)
    assert answer.largest.low == math.inf
    assert certified(block, answer).upper >= 10**9
    assert next(drafts(block, answer, "finite"))[0] >= 10**9


def test_systems_are_written_in_exact_numbers():
    assert system_of(exact("0.1 0", "1 -1.8 0.81", 1)) == {
        "kind": "transfer",
        "time": "discrete",
        "numerator": ["1/10", "0"],
        "denominator": ["1", "-9/5", "81/100"],
    }
    assert system_of(DelayPlant.parse("exp(-s/2)/(s + 1) + 1/(s + 1)"))["terms"] == [["0", ["1"]], ["1/2", ["1"]]]
    half = system_of(StateSpace([[0, 1], [-2, -0.1]], [0, 1], [1, 0]))
    assert half["A"][1] == ["-2", str(Fraction(-0.1))]
    scheme = system_of(upwind(builtin_system("paper-rod").rod, 10))
    assert (scheme["E"], scheme["A"], scheme["k"], scheme["cells"]) == ("288000000", "1/40000", "1/5000", 10)
    with pytest.raises(InputError, match="exact data"):
        system_of(object())


def test_infinite_ends_of_a_class_say_which_kind_they_are():
    steep = NonlinearityClass(sector=Sector(0, 2), slope=SlopeBounds(0, math.inf))
    assert class_entry(steep, unbounded=False)["slope"] == ["0", "inf"]
    endless = NonlinearityClass.slope_restricted(0, math.inf, odd=True)
    assert class_entry(endless, unbounded=False)["slope"] == ["0", "finite"]
    assert class_entry(endless, unbounded=True)["sector"] == ["0", "inf"]
    assert class_entry(endless, unbounded=True, linear=True)["linear"] is True


COEFFICIENTS = st.lists(st.fractions(min_value=-3, max_value=3, max_denominator=7), min_size=1, max_size=4)


@given(COEFFICIENTS, COEFFICIENTS, st.sampled_from(["0", "-1/2", "2/3"]), st.sampled_from(["4", "finite"]))
def test_the_polynomial_of_a_draft_is_that_of_the_checker(top, bottom, lower, upper):
    laws = {"sector": [lower, upper], "slope": None, "odd": False, "time_varying": False, "linear": False}
    system = system_of(RationalPlant(top, [1, *bottom])) if len(top) <= len(bottom) + 1 else None
    for theorem, multiplier in (("circle", {}), ("popov", {"theta": "3/5"})) if system is not None else ():
        draft = {"theorem": theorem, "multiplier": multiplier, "system": system, "laws": laws}
        quick = _popov_polynomial(draft)
        try:
            F, _, critical, _ = inequality(theorem, multiplier, blocks.block(system), classes(laws))
            own = polynomial_proof(F, critical=critical, bounded=upper != "finite")
        except Rejected:
            continue
        assert quick == own or quick is None or critical

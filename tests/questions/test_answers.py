"""Two-sided answers: what is proved stays below what is refuted, whatever the plant, its realisation and its units."""

import json
import math
import sys
from dataclasses import replace
from fractions import Fraction

import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import (
    AssumptionError,
    ExpressionNonlinearity,
    InputError,
    Loop,
    NonlinearityClass,
    RationalPlant,
    Sector,
    SlopeBounds,
)
from lure.analysis.certificates.second import recheck
from lure.analysis.questions import analyse, answers, max_sector, max_slope, search
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.files.builtin import builtin_loop
from lure.plants.delay import DelayPlant
from lure.rod import RodPlant, builtin_system, upwind

THIRD = RationalPlant([1], [1, 3, 2, 0])
CARRASCO_6 = RationalPlant([2, Fraction("0.92")], [1, Fraction("-0.5"), 0], dt=1)


def test_popov_in_the_critical_case_is_a_closed_form():
    # 1/(s(s+1)(s+2)): Routh gives 6; theta = 3/2 reaches it
    found = max_sector(THIRD, criterion="popov")
    assert (found.verdict, found.evidence) == (Verdict.PROVED, Evidence.CERTIFIED)
    assert 6 * (1 - 1e-8) < found.largest.low < 6 <= found.largest.high * (1 + 1e-12)
    assert found.theta == pytest.approx(1.5, rel=1e-3)
    assert found.hurwitz == Bracket(6, 6)
    assert found.closed


@pytest.mark.slow
def test_monotone_and_odd_laws_have_different_answers():
    # example 6: a monotone nonlinearity of slope 175/192 has an orbit of period 3, while linear gains are stable up to
    # 25/23
    monotone, odd = max_slope(CARRASCO_6), max_slope(CARRASCO_6, odd=True)
    assert 0.9114 < monotone.largest.low < 175 / 192
    assert monotone.refuted_at == pytest.approx(175 / 192, rel=1e-15)
    assert monotone.largest.high == monotone.refuted_at
    assert monotone.witness is not None
    assert monotone.witness.evidence is Evidence.CERTIFIED
    assert 1.0869 < odd.largest.low < 25 / 23
    assert odd.refuted_at >= 25 / 23


@pytest.mark.parametrize(
    ("block", "slope", "largest"),
    [
        (RationalPlant([1], [1, 3, 3, 1]), 8, {"circle": 4, "popov": 8}),  # Re H and Popov's line in closed form
        (RationalPlant([1], [1, 1, 0]), math.inf, {"circle": 1, "popov": math.inf}),
    ],
)
def test_each_criterion_by_name_reaches_its_own_limit(block, slope, largest):
    for criterion, k in largest.items():
        found = max_sector(block, criterion=criterion)
        assert found.criterion == criterion
        assert found.largest.low == pytest.approx(k, rel=1e-8)
        assert found.largest.low <= k
        assert found.hurwitz.high >= slope * (1 - 1e-12)


def test_an_answer_is_no_truth_value_and_reads_as_a_sentence():
    found = max_sector(THIRD)
    with pytest.raises(TypeError, match="three values"):
        bool(found)
    start = "Every solution converges to the set of equilibria for every phi, time-invariant, in the sector [0, 5.99"
    assert str(found).startswith(start)
    assert "<b>PROVED</b>" in found._repr_html_()


def test_an_answer_goes_to_json_without_nan_or_infinity():
    data = json.loads(json.dumps(max_sector(RationalPlant([1], [1, 1, 0])).to_dict(), allow_nan=False))
    assert {
        "criterion",
        "largest",
        "theta",
        "multiplier",
        "verdict",
        "evidence",
        "hurwitz",
        "refuted_at",
        "witness",
    } <= set(data)
    assert data["largest"] == ["inf", "inf"]
    assert data["hurwitz"] == ["inf", "inf"]


def test_a_gain_that_no_sector_can_exclude_refutes():
    # 1/(s - 1): phi = 0 lies in every sector [0, k]
    found = max_sector(RationalPlant([1], [1, -1]))
    assert found.verdict is Verdict.REFUTED
    assert found.witness is not None
    assert found.refuted_at == 0


def test_an_unstable_block_has_a_sector_away_from_zero():
    # 4/((s - 1)(s/3 + 1)) is stable for gains above 1/4
    block = RationalPlant([12], [1, 2, -3])
    found = max_sector(block, lower=1, criterion="circle")
    assert found.verdict is Verdict.PROVED
    assert found.largest.low > 1


@pytest.mark.slow
def test_dead_time_has_two_sides_too():
    found = max_sector(DelayPlant.parse("exp(-s/2)/s"))
    assert found.largest.low == pytest.approx(math.pi, rel=1e-7)
    assert found.refuted_at >= math.pi
    assert found.verdict is Verdict.PROVED


def test_a_limit_beyond_the_doubles_is_between_the_last_double_and_its_name():
    # -k 10^-300/(s + 10^300) is stable for k < 10^600
    found = max_sector(RationalPlant([Fraction(-1, 10**300)], [1, Fraction(10) ** 300]))
    assert (found.largest.low, found.refuted_at) == (sys.float_info.max, math.inf)
    assert "[0, 1.797693e+308]" in str(found)
    assert "just above 1e+600" in str(found)


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (lambda: max_sector(THIRD, criterion="popv"), "did you mean 'popov'"),
        (lambda: max_sector(THIRD, criterion="park"), "needs slope bounds"),
        (lambda: max_sector(CARRASCO_6, criterion="popov"), "continuous"),
        (lambda: max_slope(THIRD, criterion="tsypkin"), "discrete"),
        (lambda: max_sector(THIRD, criterion="popov", time_varying=True), "time-invariant"),
        (lambda: max_sector(THIRD, lower=math.nan), "finite number"),
        (lambda: max_sector(([1, 0], [1])), "improper"),
    ],
)
def test_a_question_without_an_answer_is_refused_in_a_sentence(question, words):
    with pytest.raises((InputError, AssumptionError), match=words):
        question()


def test_a_proof_above_a_refutation_is_not_reported(monkeypatch):
    stray = max_sector(CARRASCO_6).witness
    monkeypatch.setattr(search, "linear_witnesses", lambda asked, limit: [stray])
    with pytest.raises(answers.ContradictionError, match="one of the two is wrong"):
        max_sector(THIRD)


GAINS = st.fractions(min_value=Fraction(1, 50), max_value=50, max_denominator=50)
ROOTS = st.fractions(min_value=Fraction(1, 20), max_value=5, max_denominator=20)


@st.composite
def blocks(draw):
    """Stable blocks from known poles, some nearly on the axis, some nearly cancelled."""
    den = [Fraction(1)]
    num = [Fraction(draw(st.sampled_from([-2, 1, 5])))]

    def times(p, q):
        out = [Fraction(0)] * (len(p) + len(q) - 1)
        for i, a in enumerate(p):
            for j, b in enumerate(q):
                out[i + j] += a * b
        return out

    for _ in range(draw(st.integers(1, 3))):
        w, damping = draw(ROOTS), draw(st.sampled_from([Fraction(1, 1000), Fraction(1, 10), Fraction(1)]))
        den = times(den, [Fraction(1), 2 * damping * w, w * w] if draw(st.booleans()) else [Fraction(1), w])
        if draw(st.booleans()) and len(num) < len(den) - 1:
            num = times(num, [Fraction(1), draw(st.sampled_from([w + Fraction(1, 10**6), -w, w / 2]))])
    return RationalPlant(num, den)


@given(blocks())
@settings(max_examples=15, deadline=None)
def test_the_criteria_keep_their_order_and_none_reaches_the_linear_limit(block):
    circle, popov = max_sector(block, criterion="circle"), max_sector(block, criterion="popov")
    assert circle.largest.low <= popov.largest.low * (1 + 1e-7)
    for found in (circle, popov):
        assert found.largest.low < found.hurwitz.high or found.hurwitz.high == math.inf


@given(blocks(), GAINS, GAINS)
@settings(max_examples=10, deadline=None)
def test_units_of_time_and_gain_do_not_matter(block, gain, scale):
    n, d = len(block.numerator) - 1, block.order
    # H(s / scale) * gain
    num = [c * gain * scale ** (d - n + i) for i, c in enumerate(block.numerator)]
    den = [c * scale**i for i, c in enumerate(block.denominator)]
    other = RationalPlant(num, den)
    for criterion in ("circle", "popov"):
        a, b = max_sector(block, criterion=criterion), max_sector(other, criterion=criterion)
        if math.isinf(a.largest.low) or math.isinf(b.largest.low):
            assert a.largest.low == b.largest.low
        else:
            assert a.largest.low == pytest.approx(float(gain) * b.largest.low, rel=1e-6)


@pytest.mark.slow
def test_analyse_decides_the_class_asked_about():
    inside = analyse(Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 5)), name="x"))
    assert inside.verdict is Verdict.PROVED
    assert "PROVED  x" in str(inside)
    outside = analyse(Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 7))))
    assert outside.verdict is Verdict.REFUTED
    assert outside.evidence is Evidence.CERTIFIED
    varying = analyse(Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 5), time_varying=True)))
    assert varying.verdict is not Verdict.PROVED
    assert any("time-invariance" in hint for hint in varying.hints)


def test_the_scheme_and_the_rod_are_proved_each_by_its_theorem():
    rod = builtin_system("paper-rod").rod
    scheme, itself = max_sector(upwind(rod, 10)), max_sector(RodPlant(rod), criterion="circle")
    assert (scheme.verdict, scheme.largest.low) == (Verdict.PROVED, math.inf)
    assert str(scheme).startswith("Every motion of the scheme with 10 cells converges")
    assert "the scheme with 10 cells</caption>" in scheme._repr_html_()
    assert scheme.to_dict()["subject"] == "the scheme with 10 cells"
    assert str(itself).startswith("Every motion of the rod of finite energy comes to rest, its end at a zero")
    assert itself.proof.certificate["system"]["kind"] == "rod"
    varying = max_sector(RodPlant(rod), time_varying=True)  # where the end may stop at no zero of phi
    assert "and the pressure of every contact is square integrable for every phi, time-varying" in str(varying)
    assert not varying.conclusion.attracts
    # (1 - |a|)^2/(4 |a| d T) of the paper's rod
    assert itself.largest.low == pytest.approx(8.0000002, rel=1e-7)


def test_a_dashpot_that_feeds_energy_in_refutes_every_class():
    rod = replace(builtin_system("paper-rod").rod, damping=-1e-4)
    for plant in (upwind(rod, 10), RodPlant(rod)):
        found = [max_sector(plant), max_slope(plant, odd=True), max_sector(plant, time_varying=True)]
        assert {(one.verdict, one.refuted_at) for one in found} == {(Verdict.REFUTED, 0.0)}
        assert recheck(found[0].refutation.certificate).accepted


@pytest.mark.slow
def test_blocks_too_large_for_exact_polynomials_are_certified_by_matrices_from_both_sides():
    # sixty-one equal lags in cascade: 1/(s + 1)^61 is real at omega = tan(pi/61), the gain limit is sec(pi/61)^61
    n = 61
    A = [[-1 if i == j else (1 if i == j + 1 else 0) for j in range(n)] for i in range(n)]
    found = max_sector((A, [1] + [0] * (n - 1), [0] * (n - 1) + [1], 0), criterion="popov")
    assert (found.verdict, found.evidence) == (Verdict.PROVED, Evidence.CERTIFIED)
    assert found.largest.low < math.cos(math.pi / n) ** -n < found.refuted_at
    assert found.refuted_at - found.largest.low < 1e-6
    with pytest.raises(InputError, match="finite number"):
        max_sector(([[float("nan")]], [1], [1], 0))


def decide(block, **properties):
    return analyse(Problem.about(block, NonlinearityClass(**properties)))


# phi = lower sigma lies in each class and leaves a pole at 0 (z = 1): every state is an equilibrium of that loop
@pytest.mark.parametrize(
    ("block", "sector"),
    [
        (RationalPlant([1], [1, -1]), Sector(1, 3)),
        (RationalPlant([1], [1, 1]), Sector(-1, 3)),
        (RationalPlant([1], [1, -2], dt=1), Sector(1, Fraction(5, 2))),
    ],
)
def test_a_pole_at_zero_of_the_shifted_loop_forbids_that_zero_attracts_all(block, sector):
    found = decide(block, sector=sector)
    assert "attracts" not in found.statement
    assert all("attracts" not in str(row) for row in found.rows if row.question == "sector")
    assert any(f"pole at {'z = 1' if block.dt else '0'}" in note for note in found.not_shown)


@pytest.mark.slow
def test_with_a_direct_term_a_bare_sector_is_not_enough_for_popov():
    # phi = 25 sigma (1 + sin(400 ln |sigma|)) lies in [0, 50], and sigma + 2 phi(sigma) = y has many solutions: the
    # state can grow by jumps between them, though Popov's inequality holds for every finite k
    block = RationalPlant([2, Fraction(1, 5), 1], [1, Fraction(1, 5), 3])
    assert decide(block, sector=Sector(0, 50)).verdict is Verdict.INCONCLUSIVE
    assert decide(block, sector=Sector(0, 50), slope=SlopeBounds(0, 50)).verdict is Verdict.PROVED
    assert "increasing" in str(max_sector(block, criterion="popov"))


def test_a_class_without_an_upper_bound_is_more_than_every_finite_one():
    # s/(s^2 + s + 1) is positive real but not strictly so: phi = t^2 sigma lies in [0, inf], and x need not vanish
    block = RationalPlant([1, 0], [1, 1, 1])
    varying = decide(block, sector=Sector(0, math.inf), time_varying=True)
    assert varying.verdict is not Verdict.PROVED


@pytest.mark.slow
def test_only_a_member_of_the_very_class_refutes_it():
    # phi = 0 is no member of the sector [.1, .8], nor a nonlinearity without symmetry of the odd ones
    tighter = RationalPlant([1], [1, Fraction("-1.2"), Fraction("0.15")], dt=1)
    found = decide(tighter, sector=Sector(Fraction("0.1"), Fraction("0.8")), slope=SlopeBounds(0, Fraction("0.8")))
    assert found.verdict is not Verdict.REFUTED
    block = RationalPlant(
        [1, Fraction("-1.95"), Fraction("0.9"), Fraction("0.05")],
        [1, Fraction("-2.8"), Fraction("3.5"), Fraction("-2.412"), Fraction("0.7209")],
        dt=1,
    )
    odd = decide(block, sector=Sector(0, 0.3161589031990729), odd=True)
    assert odd.verdict is not Verdict.REFUTED or odd.asked.witness.odd


def test_no_word_rounds_a_proof_up():
    # -1/(s + 1): phi = sigma makes every state an equilibrium; [0, 1] is not stable and must not be printed as proved
    block = RationalPlant([-1], [1, 1])
    for found in (
        max_sector(block, criterion="circle"),
        max_sector(block),
        max_slope(block, criterion="zames-falb", search="linear"),
    ):
        assert found.largest.low < 1
        assert "[0, 1]" not in str(found) + found.reason
        assert "up to 1 " not in found.reason + " "


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (lambda: max_slope(THIRD, odd="no"), "odd is 'no'"),
        (lambda: max_sector(THIRD, time_varying=1), "time_varying is 1"),
        (lambda: max_sector(THIRD, search="FULL"), "search is 'FULL'"),
        (lambda: max_sector(THIRD, criterion=None), "criterion is None"),
        (lambda: max_slope(DelayPlant.parse("exp(-s)/(s + 1)"), criterion="off-axis"), "moderate order"),
    ],
)
def test_options_and_extremes_are_refused_in_a_sentence(question, words):
    with pytest.raises((InputError, AssumptionError), match=words):
        question()


@pytest.mark.slow
def test_a_limit_at_zero_above_a_negative_lower_end_is_searched_too():
    # -(s + 1)/s^2: s^2 - k s - k is stable for k < 0 only
    block = RationalPlant([-1, -1], [1, 0, 0])
    found = max_sector(block, lower=-1, time_varying=True, search="full")
    assert found.hurwitz == Bracket(0, 0)
    assert found.largest.low <= 0


@pytest.mark.slow
def test_smooth_formulas_are_known_to_be_locally_lipschitz():
    smooth = ExpressionNonlinearity("tanh(sigma) + sigma**3/3", sector=Sector(0, math.inf))
    rough = ExpressionNonlinearity("sign(sigma)*sqrt(abs(sigma))", sector=Sector(0, math.inf))
    assert smooth.locally_lipschitz
    assert not rough.locally_lipschitz
    plant = RationalPlant([1], [1, 1])
    assert analyse(Loop(plant, smooth)).verdict is Verdict.PROVED
    found = analyse(Loop(plant, rough))
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "not known to be locally Lipschitz" in found.statement


@pytest.mark.slow
def test_a_class_below_the_nonlinear_counterexample_is_refuted_by_the_gain():
    # with a class that ends at 1/10, below 0.396, only phi = 0 belongs to it
    loop = builtin_loop("leonov-bragin-kuznetsov")
    found = analyse(loop.block, SlopeBounds(0, Fraction(1, 10)))
    assert found.verdict is Verdict.REFUTED
    assert found.shown.certificate["proof"]["method"] == "linear-gain"


@pytest.mark.parametrize(
    ("plant", "lower"),
    [
        (([1], [1, 0, Fraction(-1, 10)]), Fraction(1, 10)),  # 1/s^2 with the gain 1/10, which is no double
        (([1, -1], [1, 0, 1]), 0),  # +-i with the gain 0; the gain 1 leaves one pole at 0 and one at -1
    ],
)
def test_a_lower_gain_with_poles_on_the_axis_refutes_every_class(plant, lower):
    found = max_sector(plant, lower=lower)
    assert (found.verdict, found.evidence) == (Verdict.REFUTED, Evidence.CERTIFIED)
    assert Fraction(found.witness.data["gain"]) == lower


@given(blocks())
@settings(max_examples=sampled(2, of=5), deadline=None)
def test_slopes_reach_no_less_than_sectors_and_no_further_than_gains(block):
    popov = max_sector(block, criterion="popov")
    for odd in (False, True):
        slope = max_slope(block, odd=odd, criterion="zames-falb", search="linear")
        assert slope.largest.low >= popov.largest.low * (1 - 1e-6)
        assert slope.largest.low < slope.hurwitz.high or slope.hurwitz.high == math.inf


@given(blocks(), st.lists(st.integers(-3, 3), min_size=30, max_size=30))
@settings(max_examples=10, deadline=None)
def test_the_basis_of_the_states_does_not_matter(block, numbers):
    # companion form, then x = T z with T unit lower triangular: exact in fractions
    n = block.order
    top = [Fraction(0)] * (n + 1 - len(block.numerator)) + list(block.numerator)
    A = [[Fraction(int(j == i + 1)) for j in range(n)] for i in range(n - 1)]
    A.append([-c for c in block.denominator[:0:-1]])
    C = [top[n - j] - top[0] * block.denominator[n - j] for j in range(n)]
    T = [
        [Fraction(1 if i == j else numbers[i * n + j] if j < i and i * n + j < 30 else 0) for j in range(n)]
        for i in range(n)
    ]
    inverse = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
    for i in range(n):
        for j in range(i):
            inverse[i] = [a - T[i][j] * b for a, b in zip(inverse[i], inverse[j], strict=True)]

    def product(p, q):
        return [[sum(a * b for a, b in zip(row, column, strict=True)) for column in zip(*q, strict=True)] for row in p]

    turned = product(product(inverse, A), T)
    B = [row[-1] for row in inverse]
    found = max_sector((turned, B, product([C], T)[0], top[0]), criterion="popov")
    assert found.largest == max_sector(block, criterion="popov").largest


def test_a_gain_that_only_makes_other_equilibria_is_refuted_just_above():
    # -1/(s + 1): at k = 1 the pole arrives at 0, and sectors [0, 1] converge to their equilibria, as those of 1/s do
    found = max_sector(([-1], [1, 1]))
    assert found.largest.low < 1 < found.refuted_at < 1 + 1e-11
    assert found.closed
    assert "does not converge to an equilibrium" in found.refutation.claim


def test_what_is_proved_up_to_0_meets_what_is_refuted_there():
    # -s/(s^2 + 1): s^2 - k s + 1 is stable for k < 0 alone, and Re H = 0 on the axis proves all of these sectors
    found = max_sector(([-1, 0], [1, 0, 1]), lower=-1)
    assert -1e-6 < found.largest.low < 0 == found.refuted_at
    assert found.closed


def test_a_class_that_is_never_stable_names_the_gains_that_are():
    # 4/((s - 1)(s/3 + 1)): s^2/3 + 2 s/3 - 1 + 4 k has its roots on the left from k = 1/4 on
    found = max_sector("4/((s-1)*(s/3+1))")
    assert found.verdict is Verdict.REFUTED
    assert str(found).endswith("give a lower gain in (0.25, inf)).")


# exp(-s)/(s + 1): Re H >= -|H| >= -1, so that the circle criterion proves [0, 1) at least, and with it [1/10, 1/2]
@pytest.mark.slow
def test_behind_a_dead_time_a_positive_lower_end_is_proved():
    found = analyse(
        "exp(-s)/(s+1)", NonlinearityClass(sector=Sector(Fraction(1, 10), Fraction(1, 2)), time_varying=True)
    )
    assert found.verdict is Verdict.PROVED
    assert "in the sector [0.1, 0.5], by the criterion piecewise-circle" in found.statement

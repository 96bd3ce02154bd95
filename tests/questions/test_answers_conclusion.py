"""The verdict, the class and the sentence come from the certificate, after it was compared with what was asked."""

import copy
import pickle
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from lure import (
    FrequencyData,
    InputError,
    Loop,
    NonlinearityClass,
    RationalPlant,
    Saturation,
    Sector,
    SlopeBounds,
    StateSpace,
    as_plant,
)
from lure.analysis import check
from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure, complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.systems import class_entry, nonlinearity_class_of
from lure.analysis.questions import advice, analyse, answers, max_sector, max_slope, search, table
from lure.analysis.questions.certify import certify
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.conclusion import MismatchError, _refuted, conclusion_of
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.search import Attempts
from lure.analysis.questions.table import class_dict, table_row
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.files.builtin import builtin_loop
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.family import PlantFamily

THIRD = RationalPlant([1], [1, 3, 2, 0])
ODD = NonlinearityClass.slope_restricted(0, 1, odd=True)
PD = as_plant("4*(1 + s/10)/(s*(s + 1))")  # C = 4 (1 + s/10) on 1/(s (s + 1)): one pole at 0
DT6 = builtin_loop("dt-6").block


class InASector:
    """A function that says its sector and nothing of its regularity."""

    sector = Sector(0, 2)

    def __call__(self, sigma):
        """Twice tanh."""
        return 2 * np.tanh(sigma)


def sector(low, high, **more):
    return NonlinearityClass(sector=Sector(low, high), **more)


def about(block, nonlinearity_class, nonlinearity=None):
    return analyse(Problem.about(block, nonlinearity_class, nonlinearity=nonlinearity))


def decided(problem, rows):
    """What follows from the certificates of the rows."""
    found = search.Attempts(problem)
    search._known(found, lambda: rows)
    return answers.certification_of(found, rows)


# the class ------------------------------------------------------------------------------------------------------------


def test_a_filter_that_lets_everything_through_proves_nothing(monkeypatch):
    # Carrasco's example 6: proved for odd nonlinearities up to 1.0869, refuted for a monotone one at 175/192 = .9115
    monotone = NonlinearityClass.slope_restricted(0, 1)
    for place in (advice, search):
        monkeypatch.setattr(place, "serves", lambda row, nonlinearity_class: True)
    found = about(DT6, monotone)
    assert found.verdict is Verdict.REFUTED
    assert "odd" not in found.statement
    assert found.shown.certificate["laws"]["odd"] is False


@pytest.fixture(scope="module")
def proofs():
    odd = max_slope(DT6, odd=True).proof
    popov = max_sector(THIRD).proof
    return {"odd": (DT6, odd), "popov": (THIRD, popov)}


@pytest.mark.slow_for("odd-asked0-PROVED")
@pytest.mark.parametrize(
    ("which", "asked", "verdict"),
    [
        ("odd", NonlinearityClass.slope_restricted(0, 1, odd=True), Verdict.PROVED),
        ("odd", NonlinearityClass.slope_restricted(0, 1), Verdict.INCONCLUSIVE),
        ("odd", NonlinearityClass.slope_restricted(0, Fraction(11, 10), odd=True), Verdict.INCONCLUSIVE),
        ("odd", NonlinearityClass.slope_restricted(Fraction(-1, 10), 1, odd=True), Verdict.INCONCLUSIVE),
        ("odd", sector(0, 1, odd=True), Verdict.INCONCLUSIVE),
        (
            "odd",
            NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(0, 1), odd=True, time_varying=True),
            Verdict.INCONCLUSIVE,
        ),
        ("popov", sector(0, 5), Verdict.PROVED),
        ("popov", sector(1, 5, odd=True), Verdict.PROVED),
        ("popov", sector(0, 6), Verdict.INCONCLUSIVE),
        ("popov", sector(0, 5, time_varying=True), Verdict.INCONCLUSIVE),
        ("popov", sector(-1, 5), Verdict.INCONCLUSIVE),
    ],
)
def test_a_proof_is_one_of_the_classes_inside_its_own(proofs, which, asked, verdict):
    block, proof = proofs[which]
    found = conclusion_of(Problem.about(block, asked), proof)
    assert found.verdict is verdict
    assert (found.shown is proof) == (found.verdict is Verdict.PROVED)
    if found.verdict is Verdict.PROVED:  # in words: the class and the numbers of the certificate
        top = "1.086956" if which == "odd" else "5.999999999"
        assert found.nonlinearity_class.endswith(f"[0, {top}]")
        assert found.nonlinearity_class.startswith(
            "odd phi with slope in" if which == "odd" else "phi, time-invariant,"
        )
        assert found.evidence is Evidence.CERTIFIED
    else:
        assert found.reason
        assert found.code is codes.NO_MULTIPLIER


# H(inf) = 1.  sigma + phi(sigma) = y has one solution: circle assumes it; Popov's criterion, whose theorem composes phi
# with the inverse, is refused for a class that does not promise it, unless a largest class is asked for
@pytest.mark.parametrize(
    ("theorem", "kind", "nonlinearity", "code"),
    [
        ("circle", "class", None, None),
        ("circle", "class", InASector(), None),
        ("popov", "class", None, codes.SEVERAL_SOLUTIONS),
        ("popov", "class", InASector(), codes.SEVERAL_SOLUTIONS),
        ("popov", "sector", None, None),
    ],
)
def test_what_a_theorem_assumes_is_said_or_refused(theorem, kind, nonlinearity, code):
    asked = replace(Problem.about(as_plant("(s+2)/(s+1)"), sector(0, 2), nonlinearity=nonlinearity), kind=kind)
    more = {"theorem": theorem, "multiplier": {"theta": "1"} if theorem == "popov" else {}}
    draft = {"verdict": "PROVED", "system": dict(asked.system), "laws": dict(asked.class_entry), **more}
    shown = complete_and_check(draft | {"proof": {"method": "polynomial"}})
    found = conclusion_of(asked, shown)
    assert found.code is code
    assert (shown.assumed in found.assumed) is (shown.assumed in found.headline) is (code is None)


def test_a_certificate_about_another_loop_is_a_bug_and_no_answer(proofs):
    _, proof = proofs["popov"]
    with pytest.raises(MismatchError, match="another system"):
        conclusion_of(Problem.about(RationalPlant([1], [1, 3, 2, 1]), sector(0, 5)), proof)
    with pytest.raises(MismatchError, match="no proof and no refutation"):
        conclusion_of(Problem.about(THIRD, sector(0, 5)), type("Forged", (), {"certificate": proof.certificate})())
    nothing = conclusion_of(Problem.about(THIRD, sector(0, 5)), None)
    assert nothing.verdict is Verdict.INCONCLUSIVE
    with pytest.raises(TypeError, match="do not fit"):
        replace(nothing, verdict=Verdict.PROVED)
    with pytest.raises(TypeError, match="three values"):
        bool(nothing)


@pytest.mark.parametrize(
    ("asked", "verdict"),
    [
        (sector(0, 7), Verdict.REFUTED),
        (sector(0, 7, odd=True), Verdict.REFUTED),
        (NonlinearityClass.slope_restricted(0, 7, odd=True), Verdict.REFUTED),
        (NonlinearityClass(sector=Sector(0, 6), slope=SlopeBounds(-1, 8)), Verdict.REFUTED),
        (sector(0, 7, time_varying=True), Verdict.REFUTED),
        (sector(0, 5), Verdict.INCONCLUSIVE),
        (sector(1, 7), Verdict.INCONCLUSIVE),
        (NonlinearityClass(sector=Sector(0, 5), slope=SlopeBounds(-1, 8)), Verdict.INCONCLUSIVE),
    ],
)
def test_a_refutation_is_one_of_the_classes_around_its_own(asked, verdict):
    # phi = 6 sigma is odd, has slope 6, and lies in the sector [0, 6]
    shown = max_sector(THIRD).refutation
    assert shown.certificate["laws"]["sector"] == ["0", "6"]
    found = conclusion_of(Problem.about(THIRD, asked), shown)
    assert found.verdict is verdict
    if verdict is Verdict.REFUTED:
        assert found.headline == "Some odd linear phi with slope in [0, 6] destabilises the loop: phi = 6 sigma."


def test_a_refuted_class_is_rounded_outwards():
    shown = max_sector(THIRD).refutation
    laws = {**shown.certificate["laws"], "slope": ["1/3", "20/3"], "sector": ["1/3", "20/3"]}
    found = _refuted(
        Problem.about(THIRD, sector(0, 7)), SimpleNamespace(certificate={**shown.certificate, "laws": laws}), None
    )
    assert found.nonlinearity_class == "odd linear phi with slope in [0.3333333, 6.666667]"


def test_other_equilibria_refute_nothing_where_an_end_of_the_class_is_critical():
    # 1/s: phi = 0 leaves every state an equilibrium; the loop of [0, 1] converges to its equilibria
    lag = RationalPlant([-1], [1, 1])  # phi = sigma: s + 1 - 1 = s
    shown = check(
        {
            "format": "lure-certificate/1",
            "verdict": "REFUTED",
            "convention": "sigma = H mu, mu = -phi(sigma)",
            "numbers": "rationals",
            "system": {"kind": "transfer", "time": "continuous", "numerator": ["-1"], "denominator": ["1", "1"]},
            "laws": class_entry(sector(0, 2), unbounded=False),
            "law": None,
            "theorem": "counterexample",
            "multiplier": {},
            "conclusion": "",
            "hypotheses": {},
            "proof": {"method": "linear-gain", "gain": "1"},
        },
        draft=True,
    )
    assert "equilibria other than 0" in shown.claim
    assert conclusion_of(Problem.about(lag, sector(0, 2)), shown).verdict is Verdict.REFUTED
    assert conclusion_of(Problem.about(lag, sector(0, 3)), shown).verdict is Verdict.REFUTED
    shifted = conclusion_of(Problem.about(lag, sector(-1, 2)), shown)
    assert shifted.headline.startswith("Some phi, time-invariant, in the sector [0, 2] gives the loop other equilibria")


def test_the_class_of_a_certificate_is_a_class_again():
    for given in (ODD, sector(Fraction(-1, 3), 2, time_varying=True), sector(0, float("inf"))):
        assert nonlinearity_class_of(class_entry(given, unbounded=True)) == given
        assert nonlinearity_class_of(class_entry(given, unbounded=False)) == given


def test_what_does_not_fit_does_not_end_the_search(proofs, monkeypatch):
    # the circle criterion says less than Popov's of THIRD; the refutation of a larger class fits none of [0, 5]
    _, popov = proofs["popov"]
    short = max_sector(THIRD, lower=Fraction(1, 10), criterion="circle").proof
    monkeypatch.setattr(search, "_proofs", lambda *_: iter((short, popov)))
    assert about(THIRD, sector(0, 5)).verdict is Verdict.PROVED
    monkeypatch.setattr(search, "_proofs", lambda *_: iter((short,)))
    found = about(THIRD, sector(0, 5))
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.reason == "what is proved ends at 5.999999999, and the smallest class refuted ends at 6"


@pytest.mark.parametrize(
    ("asked", "row"),
    [
        (sector(0, 1), "sector"),
        (sector(0, 1, odd=True), "sector"),
        (sector(0, 1, time_varying=True), "varying"),
        (NonlinearityClass.slope_restricted(0, 1), "slope"),
        (ODD, "odd"),
    ],
)
def test_the_row_of_a_class_is_that_of_its_kind(asked, row):
    kinds = [("sector", False, True), ("sector", False, False), ("slope", False, False), ("slope", True, False)]
    names = ("varying", "sector", "slope", "odd")
    rows = [
        SimpleNamespace(name=name, question=q, odd=o, time_varying=v)
        for name, (q, o, v) in zip(names, kinds, strict=True)
    ]
    assert advice.row_asked(rows, asked).name == row
    assert advice.row_asked(rows[:1], asked) is rows[0]


@pytest.mark.slow
def test_any_row_may_decide_and_without_a_class_the_best_does():
    third, short, never = max_sector(THIRD), max_slope(THIRD, criterion="circle"), max_sector("1/(s - 1)")
    rows = [never, third, short, short]
    asked = Problem.about(THIRD, NonlinearityClass.slope_restricted(0, 5))
    assert short.largest.low < 5  # the row of the class asked about says less than Popov's of the sector
    assert decided(asked, rows).verdict is Verdict.PROVED
    steep = Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 5), slope=SlopeBounds(0, 100)))
    assert decided(steep, rows).verdict is Verdict.PROVED  # for any slope
    lag, varying = max_sector("1/(s + 1)"), max_sector("1/(s + 1)", time_varying=True)  # both for every finite k
    for rows, best in (((third, never), third), ((lag, varying), lag)):
        assert table._farthest(list(rows)) is table._farthest(list(rows[::-1])) is best


def row_of(lower, k=1.0, *, critical=False):
    return SimpleNamespace(
        verdict=Verdict.PROVED, lower=Fraction(lower), largest=Bracket(k, k), critical=critical, class_name=""
    )


def test_of_poles_nothing_is_said_that_was_neither_counted_nor_proved():
    stable, some = (PlantFamily.of_coefficients([1], [1, "a"], {"a": (low, 2)}) for low in (1, -1))
    assert (table._case(stable, []), table._case(some, [])) == (None, "unstable")
    assert table._case(stable, [row_of("-1/2")]) == "stable"  # of every plant: phi = 0 is a member
    assert table._case(stable, [row_of("1/2")]) is None
    assert table._case(some, [row_of("3/2")]) == "unstable"
    late = as_plant("1/(s + 1 + 2*exp(-s))")  # a class that begins at 1 says nothing of its poles
    assert (table._case(late, [row_of(1)]), table._case(late, [row_of(0, critical=True)])) == (None, "critical")
    wide = [
        StateSpace(np.diag(np.r_[last, -np.arange(1.0, 62.0)]), np.ones(62), np.ones(62)) for last in (-1.0, 0.0, 1.0)
    ]
    assert [table._case(one, []) for one in wide] == [None, None, "unstable"]  # too many to be counted
    assert [table._case(one, [row_of(0, critical=True)]) for one in wide[:2]] == ["critical"] * 2


@pytest.mark.parametrize(
    ("A", "said"), [([[-1, 5], [0, -2]], "stable"), ([[0, 5], [0, -2]], "critical"), ([[0, 1], [-1, 0]], "unstable")]
)
def test_the_poles_of_several_channels_are_counted_exactly(A, said):
    asked = channel_problem((A, np.eye(2), np.eye(2), np.zeros((2, 2))), [sector(1, 2)] * 2)
    assert table._channel_case(asked, []) == said
    nothing, delayed = ((Fraction(0),) * 2,) * 2, ((Fraction(1, 9), Fraction(0)), (Fraction(0),) * 2)
    inner = DelayMatrix(base=asked.plant, late=((Fraction(1), nothing),), inner=(delayed,))
    assert table._channel_case(replace(asked, plant=inner), []) is None


# reasons and advice ---------------------------------------------------------------------------------------------------


def test_a_pi_servo_with_a_saturation_gets_advice_that_can_be_followed():
    # 0.8 (1 + 1/(0.5 s)) on 10/(s (0.1 s + 1)(0.02 s + 1)): two poles at 0, so that phi = 0, in [0, 1], is not stable
    found = analyse(Loop(as_plant("0.8*(1 + 1/(0.5*s))*10/(s*(0.1*s + 1)*(0.02*s + 1))"), Saturation()))
    assert found.verdict is Verdict.REFUTED
    assert found.conclusion.headline == "Some odd phi with slope in [0, 1] destabilises the loop: phi = 0."
    assert "What the loop does with saturation" in found.statement
    assert not any(hint.startswith("take classes whose lower end") for hint in found.hints)
    assert any("anti-windup" in hint and "lure region" in hint for hint in found.hints)


def test_the_reason_and_its_code_come_first():
    endless = about(RationalPlant([1, 0], [1, 1, 1]), sector(0, float("inf"), time_varying=True))
    assert (endless.verdict, endless.code) == (Verdict.INCONCLUSIVE, codes.EVERY_FINITE)
    assert endless.reason
    assert f"({endless.code.identifier})" in endless.statement
    search_limited = about(builtin_loop("ct-7").block, sector(0, 1000))
    assert (search_limited.verdict, search_limited.code) == (Verdict.INCONCLUSIVE, codes.NO_MULTIPLIER)
    assert endless.to_dict()["code"] == "LURE-I020"


# one search that served the class tells more than one that does not serve it; the time that is over more than both
@pytest.mark.parametrize(
    ("ended", "code", "search"),
    [
        (["NOT_APPLICABLE", "NO_MULTIPLIER", "NOT_APPLICABLE"], "NO_MULTIPLIER", 1),
        (["NO_MULTIPLIER", "NO_MULTIPLIER"], "NO_MULTIPLIER", 1),
        (["NOT_APPLICABLE", "NOT_APPLICABLE"], "NOT_APPLICABLE", 1),
        (["NO_MULTIPLIER", "OUT_OF_TIME", "NOT_APPLICABLE"], "OUT_OF_TIME", 1),
    ],
)
def test_of_several_searches_that_showed_nothing_the_most_telling_is_named(ended, code, search):
    failures = [Failure(search=f"search {i}", code=getattr(codes, name), detail="why") for i, name in enumerate(ended)]
    found = answers.certification_of(Attempts(Problem.about(THIRD, sector(0, 7)), failures), [])
    assert (found.code, found.detail) == (getattr(codes, code), f"search {search}: why")


def test_every_finite_bound_is_not_the_class_without_one():
    row = max_sector("1/(s^2 + s + 1)").to_dict()
    assert row["answers"][0]["class"].endswith("in the sector [0, inf)")
    assert "in between nothing was shown" in str(max_sector(builtin_loop("triple-lag").block, criterion="circle"))


def test_one_bound_reads_the_same_everywhere():
    # Routh: 1/(s (s + 1)(s + 2)) has its gain limit at 6, and 57/10 below has its double above
    found = max_sector(as_plant("6/(5.7*s*(s + 1)*(s + 2))"))
    assert found.refuted_text == "5.7"
    assert found.proved_text == "5.699999999"
    assert "[0, 5.699999999]" in str(found)
    assert "phi = 5.7 sigma" in str(found)
    assert found.gap == "closed"
    for end, gap in ((5.7001, "closed to 2e-05"), (6.0, "open")):
        assert replace(found, refuted_at=end, witness=replace(found.witness, k=end)).gap == gap
    assert replace(found, refuted_at=None, witness=None).gap == "open"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"largest": Bracket(5.9, 6.0)}, "is more than its certificate proves"),
        ({"lower": Fraction(-1, 10)}, "is more than its certificate proves"),
        ({"refuted_at": 5.8}, "is not the end of the class that is refuted"),
        ({"refuted_at": 5.6, "k": 5.6, "largest": Bracket(0.0, 5.6)}, "is less than its certificate refutes"),
    ],
)
@pytest.mark.parametrize("again", [lambda it: pickle.loads(pickle.dumps(it)), copy.copy, copy.deepcopy])
def test_an_answer_that_was_changed_is_compared_with_its_certificates_when_it_arrives(changes, reason, again):
    # Popov's criterion proves [0, k] for k < 5.7, and the gain 5.7 is not stable
    found = again(max_sector(as_plant("6/(5.7*s*(s + 1)*(s + 2))")))
    for name, value in changes.items():
        if name == "k":
            object.__setattr__(found, "witness", replace(found.witness, k=value))
        else:
            object.__setattr__(found, name, value)
    with pytest.raises(MismatchError, match=reason):
        again(found)


@pytest.mark.slow
def test_without_a_class_the_row_that_reaches_farthest_is_said():
    # 1/(s + 1)^3: the circle criterion reaches 4 for nonlinearities that vary, Popov's 8, Routh's limit, for those that
    # do not
    found = analyse(RationalPlant([1], [1, 3, 3, 1]))
    assert found.conclusion.nonlinearity_class.endswith("[0, 7.999999999]")
    assert "time-varying" not in found.conclusion.nonlinearity_class
    assert found.statement.startswith("The point 0 attracts every solution for every ")


def test_how_far_a_criterion_reaches_is_said_of_the_larger_class():
    said = about(THIRD, sector(0, 5)).statement
    assert said.endswith("by the criterion popov (certified), which proves up to 5.999999999.")
    assert "in the sector [0, 5], by" in said
    one_sided = RationalPlant([Fraction("0.1"), 0], [1, Fraction("-1.8"), Fraction("0.81")], dt=1)
    tsypkin = max_slope(one_sided, criterion="tsypkin", search="linear")  # slopes >= 0 without a bound, sector to 3.8
    assert tsypkin.proof.certificate["laws"]["slope"][1] in ("finite", "inf")
    assert tsypkin.proved_text.startswith("3.79999")
    said = conclusion_of(
        Problem.about(one_sided, NonlinearityClass.slope_restricted(0, 3)), tsypkin.proof, larger=tsypkin.proof
    )
    assert f"which proves up to {tsypkin.proved_text}." in said.sentence


@pytest.mark.parametrize(
    ("block", "varying", "theorem"), [("(s + 2)/(s + 1)", True, "circle"), ("1/(s + 1)", False, "popov")]
)
def test_a_class_without_an_upper_bound_is_proved_where_one_certificate_covers_it(block, varying, theorem):
    found = about(as_plant(block), sector(0, float("inf"), time_varying=varying))
    assert found.verdict is Verdict.PROVED
    assert found.shown.theorem == theorem
    assert found.shown.certificate["laws"]["sector"] == ["0", "inf"]
    assert "in the sector [0, inf]" in found.statement
    assert found.reason == ""


@pytest.mark.slow
def test_advice_names_the_farthest_bound_that_would_be_proved():
    # 1/(s + 1)^3: 4 for nonlinearities that vary, 8 for those that do not
    found = about(RationalPlant([1], [1, 3, 3, 1]), sector(0, 9))
    assert found.hints == ("an upper bound of 7.999999999 instead of 9 would be proved",)
    assert about(RationalPlant([1], [1, 3, 3, 1]), sector(0, 7)).hints == ()


# H(inf) = 1/10: of a sector Popov's criterion assumes that sigma + phi(sigma)/10 rises, and certify refuses that; slope
# bounds show it.  The circle criterion, 2.6 < 3, and for time-invariant phi up to 3.07
def test_advice_is_no_class_that_would_be_refused_for_what_it_does_not_promise():
    block = RationalPlant([Fraction(1, 10), Fraction(1, 10), Fraction(1, 10), 1], [1, 2, 2, 1])
    varying = max_sector(block, time_varying=True, criterion="circle")
    rows = [varying, max_sector(block, criterion="popov"), *[max_slope(block, criterion="popov", search="linear")] * 2]
    ends = [row.largest.low for row in rows]
    assert ends[0] < 3 < ends[1] == ends[2]
    open_ = SimpleNamespace(verdict=Verdict.INCONCLUSIVE)
    less = f"an upper bound of {varying.proved_text} instead of 3 would be proved"
    slopes = f"slope bounds of phi would be enough (popov reaches {rows[2].proved_text})"
    for one in (sector(0, 3, time_varying=True), sector(0, 3)):
        assert advice.hints(Problem.about(block, one), rows, (), open_) == (less, slopes)


def test_what_is_said_of_a_class_that_is_never_stable():
    never, lag = max_sector("1/(s - 1)"), max_sector("1/(s + 1)")
    assert str(never).startswith("Not stable for phi, time-invariant, in the sector [0, k], whatever k > 0; phi = 0: ")
    assert (never.meaning, lag.meaning) == ("", "The point 0 attracts every solution")


@pytest.mark.parametrize(
    ("plant", "upper", "verdict"),
    [("1/(s + 1)", 1, Verdict.REFUTED), ("-1/(s + 1)", Fraction(1, 2), Verdict.PROVED)],
)
def test_a_class_without_a_lower_end_is_decided_as_by_certify(plant, upper, verdict):
    # s + 1 + g has its root right of 0 for g < -1; s + 1 - g left of it for all g < 1
    nonlinearity_class = sector(float("-inf"), upper)
    found, certified = analyse(plant, nonlinearity_class), certify(plant, nonlinearity_class)
    assert found.verdict is certified.verdict is verdict
    assert found.shown.certificate == certified.certificate
    assert [row.lower for row in found.rows] == [0] * 4


@pytest.mark.parametrize(("dt", "said"), [(None, None), (Fraction(1, 2), "1/2")])
def test_the_document_of_a_block_has_its_step(dt, said):
    half = StateSpace([[0.0, 0.5], [-0.25, 0.5]], [0.0, 1.0], [1.0, 0.0], dt=dt)
    found = about(half, None).to_dict()
    assert found["block"]["dt"] == said
    assert found["block"]["denominator"] is None
    lag = "1/(s + 1)" if dt is None else "0.2/(z - 1/2)"
    assert about(as_plant(lag, dt=dt), None).to_dict()["block"]["dt"] == said


def test_a_class_as_data():
    bounds = {"sector": [0.0, 1.0], "odd": True, "time_varying": False, "text": str(ODD)}
    assert class_dict(ODD) == {**bounds, "slope": [0.0, 1.0]}
    open_ended = sector(0, float("inf"), time_varying=True)
    found = {"sector": [0.0, "inf"], "slope": None, "odd": False, "time_varying": True, "text": str(open_ended)}
    assert class_dict(open_ended) == found


def test_a_counterexample_to_a_class_counts_for_the_larger_one_where_it_is_nearer():
    third = max_sector(THIRD)  # refuted at 6
    far = replace(third, refuted_at=8.0, witness=replace(third.witness, k=8.0))
    none, shifted = replace(third, refuted_at=None, witness=None), replace(third, lower=Fraction(1, 10))
    assert [row.refuted_at for row in answers._spread([far, third])] == [6.0, 6.0]
    assert [row.refuted_at for row in answers._spread([third, far])] == [6.0, 8.0]
    assert [row.refuted_at for row in answers._spread([far, shifted])] == [8.0, 6.0]
    assert [row.refuted_at for row in answers._spread([far, none])] == [8.0, None]


# what people write ----------------------------------------------------------------------------------------------------


def test_a_witness_is_true_and_none_is_not():
    assert max_sector(THIRD).witness
    assert not max_sector("1/(s + 1)").witness
    with pytest.raises(TypeError, match="three values"):
        bool(max_sector(THIRD))


def test_measured_data_certify_nothing_not_even_that_nothing_is_known():
    data = FrequencyData([0.1, 1.0, 2.0], [1.0, 0.5, 0.1 - 0.2j], 1.0)
    for found in (max_sector(data), max_slope(data)):
        assert found.verdict is Verdict.INCONCLUSIVE
        assert f"[0, k] ({found.reason})." in str(found)
        assert "stable up to" not in found._repr_html_()  # nothing is known of linear gains
        assert {found.evidence, found.conclusion.evidence, *(each.evidence for each in found.answers)} == {
            Evidence.OBSERVED
        }


def test_bounds_alone_are_a_class():
    block = RationalPlant([1], [1, 3, 3, 1])  # 1/(s + 1)^3: the circle criterion reaches 4, Popov's 8
    assert certify(block, Sector(0, 3)).certificate["laws"]["sector"] == ["0", "3"]
    assert certify(block, SlopeBounds(0, 3)).certificate["laws"]["slope"] == ["0", "3"]
    with pytest.raises(InputError):
        certify(block, (0, 3))


# the class of nonlinearities that jump, in both checkers
# ------------------------------------------------------------------------

ROUGH = {"sector": ["0", "2"], "slope": None, "odd": True, "time_varying": False, "linear": False, "regularity": "any"}


def rough(system, **changes):
    return {
        "format": "lure-certificate/1",
        "verdict": "PROVED",
        "convention": "sigma = H mu, mu = -phi(sigma)",
        "numbers": "rationals",
        "system": {"kind": "transfer", "time": "discrete", **system},
        "laws": ROUGH,
        "law": None,
        "theorem": "circle",
        "multiplier": {},
        "proof": {"method": "polynomial"},
        **changes,
    }


LAG = {"numerator": ["1/5"], "denominator": ["1", "-1/2"]}
SLOPES = {**ROUGH, "slope": ["0", "2"]}


@pytest.mark.parametrize(
    ("draft", "accepted"),
    [
        (rough(LAG), True),
        (rough(LAG, laws={**ROUGH, "time_varying": True, "odd": False}), True),
        (rough({"numerator": ["1/5", "0"], "denominator": ["1", "-1/2"]}), False),  # H(inf) = 1/5
        (rough({"numerator": ["1/5"], "denominator": ["1", "-1"]}), False),  # a pole at z = 1
        (rough({**LAG, "denominator": ["1", "1"], "time": "continuous"}), False),
        (rough(LAG, theorem="tsypkin", multiplier={"q": "1"}, laws=SLOPES), False),
        (rough(LAG, theorem="zames-falb", multiplier={"taps": [[1, "1/2"]]}, laws=SLOPES), False),
        (rough(LAG, theorem="hurwitz", laws={**ROUGH, "linear": True}), False),
        (rough(LAG, laws={**ROUGH, "regularity": "none"}), False),
    ],
)
def test_both_checkers_let_laws_jump_only_where_the_proof_never_uses_continuity(draft, accepted):
    smooth = {**draft, "laws": {key: value for key, value in draft["laws"].items() if key != "regularity"}}
    proof = complete_and_check(smooth)  # without the key each of them is a proof
    assert recheck(proof.certificate).accepted
    words = {"class": proof.facts["class"].replace("locally Lipschitz", "continuous or not")}
    forged = {**proof.certificate, "laws": draft["laws"], "hypotheses": {**proof.facts, **words}}
    assert recheck(forged).accepted is accepted
    if accepted:
        assert check(forged).facts == {**proof.facts, **words}
    else:
        with pytest.raises(ValueError, match=r"Lipschitz|continuous|constant gains|regularity"):
            check(forged)


# the table ------------------------------------------------------------------------------------------------------------


def test_a_row_says_what_is_proved_refuted_and_left_open():
    third, endless, never = max_sector(THIRD), max_sector("1/(s + 1)"), max_sector("1/(s - 1)")
    assert table_row(third)[1:] == ("popov", "5.999999999", "certified", "6", "linear gain", "closed")
    assert table_row(endless)[1:] == ("circle", "inf", "certified", "-", "-", "closed")
    assert table_row(never)[1:] == ("-", "-", "-", "0", "linear gain", "closed")
    assert (endless.closed, never.closed, endless.gap) == (True, True, "closed")
    assert str(endless).endswith("(circle, certified).")
    assert str(third).endswith("; phi = 6 sigma: the loop is not asymptotically stable (certified).")
    assert "in between" in str(max_sector(builtin_loop("triple-lag").block, criterion="circle"))
    with pytest.raises(TypeError, match="is not what follows"):
        replace(third, verdict=Verdict.REFUTED)


def test_of_two_rows_of_one_reach_the_one_without_time_is_said():
    # 1/(s + 1): every finite sector, by the circle criterion and whatever the nonlinearities
    found = analyse(RationalPlant([1], [1, 1]))
    assert found.conclusion.nonlinearity_class.endswith("[0, inf)")
    assert found.verdict is Verdict.PROVED

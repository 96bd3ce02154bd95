"""One question, one certificate: verdicts turn at the limit, and a larger class stands in where a theorem needs it."""

import math
from fractions import Fraction

import numpy as np
import pytest
from asking import THIRD, asked, sector
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import (
    Cubic,
    DeadZone,
    ExpressionNonlinearity,
    FrequencyData,
    Loop,
    NonlinearityClass,
    PiecewiseLinear,
    RationalPlant,
    Saturation,
    Sector,
    SlopeBounds,
    StateSpace,
    Tanh,
)
from lure.analysis.certificates import codes, drafts
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.systems import class_entry, nonlinearity_entry
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.questions.certify import METHODS, ProofOptions, certify, text_of
from lure.analysis.questions.problem import posed
from lure.analysis.verdict import Verdict
from lure.errors import InputError
from lure.rod import NormalCompliance

# verdicts -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("j", [10, 30, 60])
def test_the_verdict_turns_at_the_limit(j):
    below, above = (Fraction(6) * (1 + sign * Fraction(1, 2**j)) for sign in (-1, 1))
    found = asked(THIRD, sector(0, below))
    assert found.verdict is Verdict.PROVED
    assert isinstance(found.shown, Proved)
    assert found.certificate["laws"]["sector"] == ["0", str(below)]
    for k in (Fraction(6), above):
        against = asked(THIRD, sector(0, k))
        assert against.verdict is Verdict.REFUTED
        assert isinstance(against.shown, Refuted)


@pytest.mark.slow
@settings(max_examples=30)
@given(
    roots=st.lists(st.fractions(Fraction(1, 5), 5, max_denominator=20), min_size=2, max_size=4),
    top=st.lists(st.integers(-3, 3), min_size=1, max_size=2),
    k=st.fractions(Fraction(1, 10), 20, max_denominator=50),
)
def test_what_is_proved_lies_below_the_linear_limit_and_what_is_refuted_is_accepted(roots, top, k):
    denominator = [Fraction(1)]
    for root in roots:
        denominator = [a + root * b for a, b in zip([*denominator, 0], [0, *denominator], strict=True)]
    if not any(top):
        return
    block = RationalPlant(top, denominator)
    limit = hurwitz_limit(block)
    for criterion in ("circle", "popov", "hurwitz"):
        found = asked(block, sector(0, k), criterion)
        if found.verdict is Verdict.PROVED:
            assert k <= limit.high
        elif found.verdict is Verdict.REFUTED:
            assert k >= limit.low
        if found.shown is not None:
            again = check(text_of(found.certificate))
            assert (again.claim, type(again)) == (found.shown.claim, type(found.shown))
        else:
            assert found.code is not None
            assert found.failures


def test_the_certificate_is_about_exactly_the_class_asked():
    # sector [0, 1] within slopes [0, 5]: Popov proves it from the sector alone
    tight = NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(0, 5), odd=True)
    assert asked(THIRD, tight).certificate["laws"] == class_entry(tight, unbounded=True)
    # Park needs slopes: the sector [0, 3] of slopes [0, 3.5] is certified with both
    block = RationalPlant([1, Fraction("-0.2"), Fraction("-0.1")], [1, 2, 1, 1])
    wide = NonlinearityClass(sector=Sector(0, 3), slope=SlopeBounds(0, Fraction(7, 2)))
    assert asked(block, wide, "park").certificate["laws"] == class_entry(wide, unbounded=True)


def test_a_law_goes_into_its_certificate():
    found = certify(Loop(THIRD, Saturation(gain=5, limit=2)))
    assert found.verdict is Verdict.PROVED
    assert found.certificate["law"]["points"] == [["-2/5", "-2"], ["0", "0"], ["2/5", "2"]]
    assert "law" in found.shown.facts


def test_a_question_without_a_class_is_refused():
    with pytest.raises(InputError, match="no class of nonlinearities is given"):
        certify(THIRD)
    with pytest.raises(InputError, match="did you mean 'popov'"):
        asked(THIRD, sector(0, 1), "popof")
    with pytest.raises(InputError, match=r"Ways\.method is 'matrx'; choose from best, polynomial"):
        ProofOptions(method="matrx")
    with pytest.raises(InputError, match=r"Ways\.numbers is 'floats'"):
        ProofOptions(numbers="floats")
    for seconds in (0, -1, math.nan, math.inf):
        with pytest.raises(InputError, match=r"Ways\.seconds is"):
            ProofOptions(seconds=seconds)
    with pytest.raises(TypeError, match="three outcomes"):
        bool(asked(THIRD, sector(0, 1)))


# s^2/(s^4 + s^3/5 + 6 s^2 + s/10 + 1): Popov's criterion reaches 0.384, every linear gain is stable
RESONANT = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [-1.0, -0.1, -6.0, -0.2]]


@pytest.mark.parametrize(
    ("block", "nonlinearity_class", "code"),
    [
        (FrequencyData([1.0, 2.0], [1.0, 0.5], None), sector(0, 1), codes.SAMPLED),
        (StateSpace(RESONANT, [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]), sector(0, 1), codes.COMPUTED),
    ],
)
def test_what_cannot_be_decided_has_a_code(block, nonlinearity_class, code):
    found = certify(block, nonlinearity_class)
    assert (found.verdict, found.code, found.certificate) == (Verdict.INCONCLUSIVE, code, None)
    assert str(code) in str(found)


def test_a_block_of_doubles_is_refuted_by_a_form():
    # 1/(s + 1) + 1/(s + 2) with the other sign: 1 = 3 k/2 puts a root at 0
    block = StateSpace([[-1.0, 0.0], [0.0, -2.0]], [1.0, 1.0], [-1.0, -1.0])
    found = certify(block, sector(0, 5))
    assert found.verdict is Verdict.REFUTED
    assert found.certificate["proof"]["method"] == "matrix-gain"
    assert certify(block, sector(0, Fraction(2, 3) - Fraction(1, 10**6))).verdict is Verdict.PROVED
    assert certify(block, sector(0, Fraction(2, 3) + Fraction(1, 10**6))).verdict is Verdict.REFUTED


def test_a_block_of_doubles_is_proved_by_matrices():
    # 1/((s+1)(s+2)), its entries exact doubles; the circle criterion reaches 17.48
    block = StateSpace([[0.0, 1.0], [-2.0, -3.0]], [0.0, 1.0], [1.0, 0.0])
    found = certify(block, sector(0, 17))
    assert found.verdict is Verdict.PROVED
    assert (found.shown.theorem, found.certificate["proof"]["method"]) == ("circle", "matrix")
    further = certify(block, sector(0, 100))
    assert (further.verdict, further.shown.theorem) == (Verdict.PROVED, "popov")


# parts ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("nonlinearity", "kind"),
    [
        (Saturation(gain=2, limit=1), "piecewise-linear"),
        (DeadZone(width=1, gain=3), "piecewise-linear"),
        (PiecewiseLinear([(-1, -3), (2, 6), (4, 7)], left_slope=0, right_slope=Fraction(1, 2)), "piecewise-linear"),
        (NormalCompliance(stiffness=4, exponent=1), "piecewise-linear"),
        (ExpressionNonlinearity(text="max(sigma, 0)", sector=Sector(0, 1)), "piecewise-linear"),
        (Tanh(scale=2, gain=3), "tanh"),
    ],
)
def test_a_law_in_a_certificate_is_the_law(nonlinearity, kind):
    written = nonlinearity_entry(nonlinearity)
    assert written["kind"] == kind
    x = np.linspace(-5, 5, 41)
    if kind == "tanh":
        values = float(Fraction(written["height"])) * np.tanh(float(Fraction(written["rate"])) * x)
    else:
        points = [(float(Fraction(s)), float(Fraction(v))) for s, v in written["points"]]
        (x0, y0), (x1, y1) = points[0], points[-1]
        inner = np.interp(x, [p[0] for p in points], [p[1] for p in points])
        left, right = float(Fraction(written["left"])), float(Fraction(written["right"]))
        values = np.where(x < x0, y0 + left * (x - x0), np.where(x > x1, y1 + right * (x - x1), inner))
    assert values == pytest.approx(nonlinearity(x), abs=1e-12)


@pytest.mark.parametrize(
    "nonlinearity", [Cubic(cubic=1), ExpressionNonlinearity(text="sin(sigma)", sector=Sector(-1, 1)), None]
)
def test_a_law_that_can_only_be_declared_stays_out(nonlinearity):
    assert nonlinearity_entry(nonlinearity) is None


BOUNDS = st.tuples(st.sampled_from(["-inf", "-1", "0"]), st.sampled_from(["1/2", "1", "finite", "inf"]))
NONLINEARITIES = st.fixed_dictionaries(
    {
        "sector": BOUNDS.map(list),
        "slope": st.one_of(st.none(), BOUNDS.map(list)),
        "odd": st.booleans(),
        "time_varying": st.booleans(),
        "linear": st.booleans(),
    }
)


@given(a=NONLINEARITIES, b=NONLINEARITIES, c=NONLINEARITIES)
def test_containment_is_an_order(a, b, c):
    assert contains(a, a)
    assert not (contains(a, b) and contains(b, c)) or contains(a, c)
    if contains(a, b) and contains(b, a):
        assert a == b


def test_containment_knows_which_class_is_larger():
    plain = {"sector": ["0", "1"], "slope": None, "odd": False, "time_varying": False, "linear": False}
    for change in ({"sector": ["0", "1/2"]}, {"slope": ["0", "1"]}, {"odd": True}, {"linear": True}):
        assert contains(plain, {**plain, **change})
        assert not contains({**plain, **change}, plain)
    varying = {**plain, "time_varying": True}
    assert contains(varying, plain)
    assert not contains(plain, varying)
    finite, none = {**plain, "sector": ["0", "finite"]}, {**plain, "sector": ["0", "inf"]}
    assert contains(finite, plain)
    assert contains(none, finite)
    assert not contains(finite, none)
    assert not contains(plain, finite)


def test_a_larger_class_stands_in_where_a_theorem_needs_it():
    tight = NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(0, 2))
    question = posed(THIRD, tight, criterion="best", finite=False)
    draft = {**asked(THIRD, NonlinearityClass.slope_restricted(0, 2)).certificate}
    calls = []
    original = drafts.checked

    def only_larger(candidate):
        calls.append(candidate["laws"]["sector"])
        if len(calls) == 1:
            raise Rejected("slope = sector is needed")
        return original(candidate)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drafts, "checked", only_larger)
        shown = drafts.check_for_class(question, draft)
    assert calls == [["0", "1"], ["0", "2"]]
    assert shown.certificate["laws"]["sector"] == ["0", "2"]


def test_a_smaller_class_never_stands_in():
    question = posed(THIRD, sector(0, 7), criterion="best", finite=False)
    with pytest.raises(Rejected):
        drafts.check_for_class(question, asked(THIRD, sector(0, 5)).certificate)


def test_the_options_of_the_command_are_those_of_the_question():
    from lure.analysis.cli import certificates

    assert certificates.METHODS == METHODS


def test_the_text_of_a_certificate_has_an_entry_a_line_where_there_are_several():
    assert text_of({"multiplier": {"theta": "1"}, "laws": {"odd": False, "slope": None}}).splitlines() == [
        "{",
        '"laws": {',
        '  "odd": false,',
        '  "slope": null',
        "},",
        '"multiplier": {"theta": "1"}',
        "}",
    ]

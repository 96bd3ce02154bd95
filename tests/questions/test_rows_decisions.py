"""What an analysis and its rows say, one decision at a time, of findings that are made up."""

from contextlib import nullcontext
from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from worded import PLAIN, shown

from lure import InputError, NonlinearityClass, RationalPlant, Saturation, Sector, SlopeBounds, as_plant
from lure.analysis.numerics.doubles import bound_above, double_above, double_below
from lure.analysis.questions import answers, table
from lure.analysis.questions.channel_map import Ray, StabilityMap
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channels import Factors
from lure.analysis.questions.largest import MismatchError, StabilityBound
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.search import Attempts, Findings
from lure.analysis.questions.table import LoopAnalysis
from lure.analysis.verdict import Bracket, Evidence, Verdict, Witness
from lure.classes import Diagonal
from lure.files.builtin import builtin_loop

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
OWN = NonlinearityClass
LAG = RationalPlant([1], [1, 1])
LAGS = as_plant(([[-1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))))
TWO = Diagonal((OWN(sector=Sector(0, 1)),) * 2)
TIME = "The time allowed ended the search (LURE-I007): these are the best bounds so far."


def member(k, description="a relay destabilises the loop", refutation=None):
    given = {"kind": "periodic orbit", "evidence": Evidence.CERTIFIED, "slope_restricted": True, "odd": True}
    return Witness(k=k, description=description, refutation=refutation, **given)


def bound(**more):
    """A largest class as it is read, whatever its certificates."""
    one = object.__new__(StabilityBound)
    found = {"question": "sector", "criterion": "popov", "odd": False, "time_varying": False, "lower": F(0)}
    found |= {"largest": Bracket(1 / 3, 8.0), "verdict": PROVED, "refuted_at": None, "witness": None, "trivial": None}
    found |= {"classes": None, "answers": (), "theta": None, "evidence": Evidence.CERTIFIED, "stopped": None}
    found |= {"conclusion": SimpleNamespace(headline="0 attracts."), "reason": "", "subject": "", "critical": False}
    found |= {"hurwitz": Bracket(2 / 3, 8.0)}
    for name, value in (found | more).items():
        object.__setattr__(one, name, value)
    return one


ORBIT = {"witness": member(2 / 3), "refuted_at": 2 / 3}
NEVER = "Not stable for phi, time-invariant, in the sector [0, k], whatever k"
RINGS = "a relay destabilises the loop (certified)"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({}, "0 attracts (popov, certified)."),
        ({"stopped": "time"}, f"0 attracts (popov, certified). {TIME}"),
        (ORBIT, f"0 attracts (popov, certified); {RINGS}; in between nothing was shown."),
        (ORBIT | {"largest": Bracket(2 / 3, 2 / 3)}, f"0 attracts (popov, certified); {RINGS}."),
        (ORBIT | {"verdict": REFUTED}, f"{NEVER} >= 0.6666667; {RINGS}."),
        (ORBIT | {"verdict": REFUTED, "reason": "why"}, f"{NEVER} >= 0.6666667; {RINGS} (why)."),
        (
            {"verdict": REFUTED, "trivial": member(0.0, "phi = 0 does"), "witness": member(2 / 3), "refuted_at": 0.0},
            f"{NEVER} > 0; phi = 0 does (certified); from k = 0.6666667 on also {RINGS}.",
        ),
        (
            {"verdict": OPEN},
            "Not proved; the inequality of popov holds for [0, 0.3333333] (certified).",
        ),
        (
            {"verdict": OPEN, "largest": Bracket(inf, inf)},
            "Not proved; the inequality of popov holds for [0, inf) (certified).",
        ),
        (
            {"verdict": OPEN, "lower": F(1, 3), "largest": Bracket(0.25, 1)},
            "Nothing is proved for phi, time-invariant, in the sector [0.3333334, k].",
        ),
        (ORBIT | {"verdict": OPEN, "largest": Bracket(0, 1)}, f"[0, k]; {RINGS}; in between nothing was shown."),
    ],
)
def test_a_largest_class_is_told(more, said):
    assert str(bound(**more)) == said or (said[0] == "[" and str(bound(**more)).endswith(said))


GIVEN = {"classes": TWO, "lower": F(0)}
RELUS = {"classes": Diagonal((OWN.relu(),) * 2)}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"verdict": OPEN, "reason": "why"}, "Nothing is proved for any factor (why)."),
        (
            ORBIT | {"verdict": OPEN, "reason": "why", "stopped": "time"},
            "Nothing is proved for any factor (why); a relay, within 0.6666667 times, destabilises the loop "
            f"(certified). {TIME}",
        ),
        (
            {"verdict": REFUTED, "witness": member(0.0), "refuted_at": 0.0},
            "A relay, members whatever the factor, destabilises the loop (certified).",
        ),
        (
            ORBIT | {"verdict": REFUTED, "witness": member(2 / 3, "a solution grows")},
            "A solution grows (within 0.6666667 times) (certified).",
        ),
        (ORBIT | RELUS | {"verdict": REFUTED}, "A relay, at 0.6666667 times, destabilises the loop (certified)."),
    ],
)
def test_a_largest_factor_is_told(more, said):
    assert str(bound(**GIVEN | more)) == said


def proved(laws, **more):
    return SimpleNamespace(proof=shown(laws=laws), search_limited=False, **more)


def test_a_proved_factor_is_told_with_what_was_tried():
    one = SimpleNamespace(proof=shown(), search_limited=False)
    found = bound(**GIVEN, answers=(one,))
    assert str(found) == "0 attracts: the upper bounds times 0.3333333 (popov, certified)."
    one.search_limited = True
    assert "0.3333333, the largest factor tried (popov" in str(found)
    assert (found.proved_up_to, bound(**RELUS, answers=(one,)).proved_up_to) == (
        "0.3333333, the largest k tried",
        "0.3333333 alone",
    )
    assert (bound(**GIVEN).proved_text, bound(verdict=OPEN, answers=(one,)).proved_text) == ("", "")


# 57/10 lies between two doubles: the text is that of the certificate, on both sides
def test_ends_that_are_no_doubles_are_said_as_they_stand_in_the_certificate():
    laws, end = {**PLAIN, "sector": ["0", "57/10"]}, F(57, 10)
    low, high = double_below(end), double_above(end)
    one = SimpleNamespace(proof=shown(laws=laws), search_limited=False)
    assert bound(largest=Bracket(low, inf), answers=(one,)).proved_text == "5.7"
    refuted = SimpleNamespace(certificate={"laws": laws})
    assert bound(witness=member(high, refutation=refuted), refuted_at=high).refuted_text == "5.7"
    both = {"witness": member(9.0), "trivial": member(high, refutation=refuted), "refuted_at": high}
    assert (bound(**both).refuted_text, bound(**both).witness_text) == ("5.7", "9")
    assert bound(**both, classes=TWO).refuted_text == bound_above(high)


@pytest.mark.parametrize(
    ("more", "said", "notes"),
    [
        ({}, ("0.3333333", "popov, theta = 0.6666667 s", "-"), 2),
        ({"verdict": OPEN, "reason": "why"}, ("nothing is proved", "why", "-"), 1),
        ({"verdict": OPEN}, ("nothing is proved", "-", "-"), 1),
        (ORBIT | {"verdict": OPEN, "subject": "the rod"}, ("nothing is proved", "-", RINGS), 1),
    ],
)
def test_a_largest_class_as_a_page(more, said, notes):
    row = {"criterion": "circle", "verdict": OPEN, "evidence": "e", "reason": "x", "search_limited": False}
    tried = [SimpleNamespace(**row, largest=Bracket(end, inf), proof=shown()) for end in (0.0, 0.25)]
    one = bound(theta=2 / 3, answers=tuple(tried), **more)
    page = one._page()
    rows = dict(page.rows)
    assert (rows["proved up to k ="], rows.get("proved by", rows.get("why")), rows["refuted by"]) == said
    assert rows["linear gains"] == "stable up to 0.6666666"
    assert len(page.notes) == notes
    assert [each[2:4] for each in page.below[0].rows] == [("-", "-"), ("e", "0.25")]
    assert page.title.endswith("[0, k], the rod" if "subject" in more else "[0, k]")


# the class of a certificate is not smaller than what is said to be proved, nor larger than what is refuted
def test_factors_are_compared_with_their_certificates():
    laws = channel_problem(LAGS, [Sector(0, 1)] * 2).class_entry
    half = {"channels": [{**PLAIN, "sector": ["0", "1/2"]}] * 2, "repeated": False}
    for end, fits in ((0.5, True), (1.0, True), (1.5, False)):
        one = bound(**GIVEN | {"largest": Bracket(end, end), "answers": (proved(laws),)})
        if fits:
            one._compare_factors(TWO)
        else:
            with pytest.raises(MismatchError, match="more than its certificate proves"):
                one._compare_factors(TWO)
    refuted = SimpleNamespace(certificate={"laws": half})
    for at, fits in ((0.5, True), (0.75, True), (0.25, False), (0.0, True)):
        one = bound(**GIVEN | {"verdict": OPEN, "witness": member(at, refutation=refuted), "refuted_at": at})
        if fits:
            one._compare_factors(TWO)
        else:
            with pytest.raises(MismatchError, match="less than its certificate refutes"):
                one._compare_factors(TWO)
    for more in ({"refuted_at": 1.0}, {"witness": member(1.0, refutation=refuted)}):
        with pytest.raises(MismatchError, match="is not the factor of the classes that are refuted"):
            bound(**GIVEN | {"verdict": OPEN} | more)._compare_factors(TWO)


# the analysis --------------------------------------------------------------------------------------------------------


class Concluded(SimpleNamespace):
    """A conclusion with its sentence."""

    def __str__(self):
        return "Nothing is decided: because."


def analysis(problem=None, **more):
    problem = problem or Problem.about(LAG, OWN(sector=Sector(0, 1)), name="lag")
    conclusion = Concluded(verdict=OPEN, evidence=Evidence.CERTIFIED, reason="why", code=None, shown=None)
    given = {"case": None, "gains": None, "rows": (), "asked": None, "conclusion": conclusion, "hints": ("x",)}
    return LoopAnalysis(**{"problem": problem, "not_shown": ("y",)} | given | more)


@pytest.mark.parametrize(
    ("asked", "known", "said"),
    [
        (None, False, ""),
        (bound(verdict=OPEN, reason="no sector; give another"), False, "no sector; give another"),
        (bound(verdict=OPEN, reason="no sector; give another"), True, "no sector"),
        (bound(verdict=OPEN, reason="because"), False, ""),
        (bound(reason="no sector"), False, ""),
    ],
)
def test_why_nothing_is_proved_is_said_once(asked, known, said):
    phi = Saturation(gain=1, limit=1) if known else None
    found = analysis(Problem.about(LAG, OWN(sector=Sector(0, 1)), nonlinearity=phi), asked=asked)
    assert found._unproved() == said
    assert (f"Nothing is proved: {said}." in str(found)) is bool(said)


MAP = StabilityMap(
    lower=(F(0), F(0)),
    asked=(F(1), F(1)),
    rays=(Ray(k1=1, k2=1, proved_k1=1 / 3, proved_k2=2, refuted_k1=3, refuted_k2=4, criterion=""),),
)
HALF = StabilityMap(lower=(F(0), F(0)), asked=(F(1), F(1)), rays=())


def test_what_stands_below_the_table():
    assert analysis()._below_table() == "Linear gains for which the loop is stable: not computed."
    assert analysis(gains=())._below_table().endswith("stable: none.")
    assert analysis(gains=("(0, 1)", "(2, 3)"))._below_table().endswith("stable: (0, 1), (2, 3).")
    several = channel_problem(LAGS, [Sector(0, 1)] * 2)
    factors = analysis(several)._below_table()
    assert factors.startswith("The numbers are factors of every upper bound of: ")
    assert analysis(several, map=HALF)._below_table() == factors
    assert analysis(several, map=MAP)._below_table() == (
        f"{factors} Pairs (k1, k2) of upper bounds that are proved, with all smaller ones: (0.3333333, 2)."
    )
    assert ": H = " in str(analysis())
    assert ": H = " not in str(analysis(several))


def test_what_ended_a_search_is_said_in_the_analysis():
    rows = (bound(), bound(stopped="time"), bound(stopped="interrupt"))
    assert (analysis().stopped, analysis(rows=rows[:1]).stopped, analysis(rows=rows).stopped) == (None, None, "time")
    assert (TIME in str(analysis(rows=rows)), TIME in str(analysis(rows=rows[:1]))) == (True, False)
    assert (TIME in analysis(rows=rows)._page().notes, TIME in analysis(rows=rows[:1])._page().notes) == (True, False)
    data = analysis(rows=rows[:1])._columns()
    assert (data["proved_up_to"].values, str(data["refuted_at"].values)) == ([1 / 3], "[nan]")


# a row of the table: what is proved, by what, and every member that refutes
def test_a_row_of_the_table():
    both = bound(**ORBIT | {"trivial": member(0.0)})
    assert table.table_row(both)[4:6] == ("0.6666667", "periodic orbit, periodic orbit")
    assert table.table_row(bound())[1:6] == ("popov", "", "certified", "-", "-")
    assert table.table_row(bound(verdict=OPEN))[1:6] == ("-", "-", "-", "-", "-")


def test_certificates_are_listed_once_each_that_of_the_verdict_first():
    first, second, third = shown("a"), shown("b"), shown("c")
    one = bound(answers=(SimpleNamespace(proof=second), SimpleNamespace(proof=None), SimpleNamespace(proof=first)))
    object.__setattr__(one, "witness", member(1.0, refutation=third))
    found = analysis(rows=(one, one))
    found.conclusion.shown = first
    assert found.certificates == (first, second, third)


# of a loop with a class the rows begin where it does; constant gains are asked of a criterion of their own
@pytest.mark.parametrize(
    ("loop", "given", "lowers", "beside"),
    [
        ("1/(s+1)", None, (0, 0), 0),
        ("1/(s+1)", Sector(F(1, 2), 1), (F(1, 2), F(1, 2)), 1),
        ("1/(s+1)", SlopeBounds(-1, 1), (-1, -1), 1),
        ("1/(s+1)", OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 1)), (0, -1), 1),
        ("1/(s+1)", Sector(-inf, 1), (0, 0), 1),
        ("exp(-s)/(s+1)", Sector(0, 1), (0, 0), 1),
        ("exp(-s)/(s+1)", Sector(F(1, 2), 1), (F(1, 2), F(1, 2)), 1),
        ("1/(s+1)", OWN.constant_gain(0, 1), (0, 0), 0),
    ],
)
@pytest.mark.parametrize("stopped", [None, "time", "interrupt"])
def test_what_an_analysis_asks(loop, given, lowers, beside, stopped, monkeypatch):
    asked, limits = [], []

    def ask(problems, **_ways):
        asked.append(list(problems))
        ends = [float(i) for i, one in enumerate(problems) if one.kind != "class"]
        found = [bound(largest=Bracket(end, inf), stopped=stopped if end == 2 else None) for end in ends]
        return found + [SimpleNamespace(conclusion="decided") for one in problems if one.kind == "class"]

    class Found:
        def __init__(self, **given):
            vars(self).update(given)

    monkeypatch.setattr(table, "answers", ask)
    monkeypatch.setattr(table, "time_limit", lambda seconds: limits.append(seconds) or nullcontext())
    monkeypatch.setattr(table, "LoopAnalysis", Found)
    for name in ("_not_shown", "hints"):
        monkeypatch.setattr(table, name, lambda *_given: ())
    found = table.analyse(loop, given)
    kinds = [(one.question, one.odd, one.time_varying, one.lower) for one in asked[0][:4]]
    assert kinds == [
        ("sector", False, True, lowers[0]),
        ("sector", False, False, lowers[0]),
        ("slope", False, False, lowers[1]),
        ("slope", True, False, lowers[1]),
    ]
    assert len(asked[0]) == 4 + beside
    linear = isinstance(given, OWN) and given.linear
    assert len(asked) == 1 + linear
    assert (found.conclusion == "decided") is (given is not None)
    assert [one.largest.low for one in found.rows] == [3, 2, 1, 0]
    assert (found.asked is None) is (given is None)
    assert limits == [table.GRACE if stopped == "time" else None]  # where the time is over, a little for linear gains


# answers -------------------------------------------------------------------------------------------------------------


def test_what_is_not_known_yet_is_of_its_kind():
    own = Problem.about(LAG, OWN(sector=Sector(0, 1)))
    assert isinstance(answers._nothing_yet(own), Attempts)
    scalar = answers._nothing_yet(Problem.largest(LAG, "sector", lower=F(1, 3)))
    assert isinstance(scalar, Findings)
    assert (scalar.hurwitz.low <= F(1, 3), scalar.hurwitz.high) == (True, inf)
    assert isinstance(answers._nothing_yet(channel_problem(LAGS, [Sector(0, 1)] * 2, kind="sector")), Factors)


def test_a_largest_class_of_a_singular_loop_is_refused():
    plant = RationalPlant([-1, 0], [1, 1])
    with pytest.raises(InputError, match="not well posed"):
        answers.answer(Problem.largest(plant, "sector", lower=F(1)))


def test_options_of_one_channel_are_refused_beside_classes():
    plant = builtin_loop("triple-lag").block
    for more in ({"lower": 1}, {"time_varying": True}):
        with pytest.raises(InputError):
            answers.max_sector(plant, [Sector(0, 1)], **more)
    with pytest.raises(InputError):
        answers.max_slope(plant, [Sector(0, 1)], odd=True)


# a class whose bounds begin above 0 is asked once more as it is, where it was asked from 0 on as a list; and so is one
# that stands beside such a list
@pytest.mark.parametrize(
    ("lowers", "moved", "verdict", "again"),
    [
        ((F(1),), (True,), OPEN, [0]),
        ((F(0),), (True,), OPEN, []),
        ((F(1),), (False,), OPEN, []),
        ((F(1),), (True,), PROVED, []),
        ((F(0), F(0)), (True, False), OPEN, [1]),
        ((F(1), F(0)), (True, False), OPEN, [0, 1]),
        ((F(0), F(1)), (False, False), OPEN, []),
    ],
)
@pytest.mark.parametrize("better", [True, False])
def test_what_is_asked_once_more(lowers, moved, verdict, again, better, monkeypatch):
    asked = [Problem.about(LAG, OWN(sector=Sector(low, 2)), name=f"{i}") for i, low in enumerate(lowers)]
    as_list = channel_problem(([[-1]], [[1]], [[1]], [[0]]), [Sector(0, 2)])
    other = dict(zip([one.name for one in asked], moved, strict=True))
    calls, decided = [], SimpleNamespace(verdict=verdict)

    def search(found, _rows, **_ways):
        calls.append([one.asked.name for one in found])
        if better and len(calls) > 1:
            found[0].certification = "better"

    monkeypatch.setattr(answers, "splits_of", lambda _problems: ())
    monkeypatch.setattr(answers, "as_one_channel", lambda one: as_list if other[one.name] else one)
    monkeypatch.setattr(answers, "search_for", search)
    monkeypatch.setattr(answers, "certification_of", lambda _found, _rows: decided)
    found = answers.answers(asked)
    assert calls[1:] == [[f"{i}"] for i in again]
    assert found == ["better" if better and i in again else decided for i in range(len(asked))]


# what was asked as a list of one is said as of one channel, unless a class is held against its factors
def test_rows_of_lists_are_said_as_of_one_channel(monkeypatch):
    scalar = Problem.largest(LAG, "sector", lower=F(0))
    listed = channel_problem(LAGS, [Sector(0, 1)] * 2, kind="sector")
    monkeypatch.setattr(answers, "largest_of", lambda _one: SimpleNamespace(refuted_at=None, said="scalar"))
    monkeypatch.setattr(answers, "bound_of_factors", lambda *_given: "as one channel")
    monkeypatch.setattr(Factors, "bound", property(lambda _self: "factors"))
    found = [Findings(scalar, hurwitz=Bracket(0, inf)), Factors(listed), Attempts(listed)]
    problems = [scalar, scalar, listed]
    assert [getattr(one, "said", one) for one in answers._rows(problems, found)] == ["scalar", "as one channel"]
    assert answers._rows(problems, found, factors=True) == ["factors"]
    assert answers._rows([listed], [Factors(listed)]) == ["factors"]


# of several channels: every kind, then the class itself; a map of two; what is asked is a row of its own
@pytest.mark.parametrize(
    ("classes", "kind", "seconds", "mapped"),
    [
        ([Sector(0, 1)] * 2, "class", 10, True),
        ([Sector(0, 1)] * 2, "sector", None, True),
        (TWO, "class", None, True),
        (Diagonal(TWO.classes, repeated=True), "class", 10, False),
    ],
)
def test_what_an_analysis_of_several_channels_asks(classes, kind, seconds, mapped, monkeypatch):
    heard, told = {}, []

    def ask(problems, **ways):
        heard.update(ways, problems=list(problems))
        ways["progress"]("a step", 0.5)
        rows = [bound(classes=one.classes, largest=Bracket(float(i), inf)) for i, one in enumerate(problems)]
        return [row for row, one in zip(rows, problems, strict=True) if one.kind != "class"] + [
            SimpleNamespace(conclusion="decided") for one in problems if one.kind == "class"
        ]

    def draw(_problem, **ways):
        heard["map"] = ways["seconds"]
        ways["progress"]("a ray", 0.5)
        return "a map"

    class Found:
        def __init__(self, **given):
            vars(self).update(given)

    monkeypatch.setattr(table, "answers", ask)
    monkeypatch.setattr(table, "stability_map", draw)
    monkeypatch.setattr(table, "LoopAnalysis", Found)
    monkeypatch.setattr(table, "channel_hints", lambda *_given: ("a hint",))
    monkeypatch.setattr(table, "_not_shown", lambda *_given: ())
    problem = channel_problem(LAGS, classes, kind=kind)
    found = table._of_channels(problem, seconds, lambda step, done: told.append((step, done)))
    share = 0.6 if mapped else 1.0
    assert heard["seconds"] == (None if seconds is None else share * seconds)
    assert told == [("a step", share * 0.5), *([("a ray", share + (1 - share) * 0.5)] if mapped else [])]
    assert (found.map, "map" in heard) == (("a map" if mapped else None), mapped)
    assert not mapped or heard["map"] == (None if seconds is None else pytest.approx(0.4 * seconds))
    assert (heard["problems"][-1] == problem) is (kind == "class")
    assert [one.largest.low for one in found.rows] == sorted((one.largest.low for one in found.rows), reverse=True)
    assert (found.hints, found.gains) == (("a hint",) if kind == "class" else (), None)
    assert (found.asked is None) is (kind != "class")
    assert found.asked is None or found.asked.classes == problem.classes
    assert (found.conclusion == "decided") is (kind == "class")

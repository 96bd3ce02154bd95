"""What is said of a class, and why: rows that are made up, one decision at a time."""

from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from worded import shown

from lure import NonlinearityClass, RationalPlant, Saturation, Sector, SlopeBounds, StateSpace, as_plant, nonlinearities
from lure.analysis.certificates import codes
from lure.analysis.certificates.drafts import Failure
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.numerics.doubles import double_above
from lure.analysis.questions import advice, answers, largest, max_sector, problem, table
from lure.analysis.questions.answers import ContradictionError
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.conclusion import MismatchError
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.search import Attempts, Findings
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict, Witness
from lure.classes import Diagonal
from lure.plants.block import StructuredPlant

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
OWN = NonlinearityClass
LAG, THIRD = RationalPlant([1], [1, 1]), RationalPlant([1], [1, 3, 2, 0])
LAGS = as_plant(([[-1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))))


def row(end=4, question="sector", **more):
    """A row of which the classes up to an end are proved."""
    found = {"verdict": PROVED, "largest": Bracket(end, end), "lower": 0, "time_varying": False, "odd": False}
    found |= {"criterion": "popov", "proviso": "", "question": question, "proved_up_to": f"{end:g}", "stopped": None}
    found |= {"refuted_at": None, "refuted_text": "", "answers": (), "critical": False}
    return SimpleNamespace(**found | more)


KINDS = [row(1, time_varying=True), row(2), row(3, "slope"), row(4, "slope", odd=True)]


@pytest.mark.parametrize(
    ("one", "asked", "serving"),
    [
        (OWN(sector=Sector(0, 1)), 1, [False, True, False, False]),
        (OWN(sector=Sector(0, 1), odd=True), 1, [False, True, False, False]),
        (OWN.slope_restricted(0, 1), 2, [False, True, True, False]),
        (OWN.slope_restricted(0, 1, odd=True), 3, [False, True, True, True]),
        (OWN(sector=Sector(0, 1), time_varying=True), 0, [True, False, False, False]),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(0, 1), odd=True, time_varying=True), 0, [True] + [False] * 3),
    ],
)
def test_which_rows_are_about_a_class(one, asked, serving):
    assert advice.row_asked(KINDS, one) is KINDS[asked]
    found = [advice.serves(each, one) for each in KINDS]
    assert (found[1:] if not one.time_varying else found) == (serving[1:] if not one.time_varying else serving)
    assert advice.row_asked(KINDS[:1], one) is KINDS[0]


OUTSIDE = Failure(search="x", code=codes.OUTSIDE_CLASS, detail="not inside")
ROUGH = Failure(search="x", code=codes.NOT_LIPSCHITZ, detail="rough")
TRIED = SimpleNamespace(code=codes.NO_MULTIPLIER.identifier, reason="None was found.")
RESIDUE = SimpleNamespace(code=codes.RESIDUE.identifier, reason="The residue is negative.")
WORSE = min((codes.NO_MULTIPLIER, codes.RESIDUE), key=codes.WORST.index)
TOLD = {codes.NO_MULTIPLIER: "None was found", codes.RESIDUE: "The residue is negative"}[WORSE]


# first that the phi does not belong; then that the time was over, that no theorem begins so low, that the end is open
@pytest.mark.parametrize(
    ("asked", "missed", "code", "said"),
    [
        (row(2), [ROUGH, OUTSIDE], codes.OUTSIDE_CLASS, "not inside"),
        (row(2), [ROUGH], codes.NOT_LIPSCHITZ, "rough"),
        (row(2), [], codes.NO_MULTIPLIER, "what is proved ends at 2"),
        (
            row(2, refuted_at=7, refuted_text="7"),
            [],
            codes.NO_MULTIPLIER,
            "what is proved ends at 2, and the smallest class refuted ends at 7",
        ),
        (row(2, stopped="time"), [], codes.OUT_OF_TIME, "the search was stopped: what is proved ends at 2"),
        (
            row(2, stopped="time", verdict=OPEN, refuted_at=7, refuted_text="7"),
            [],
            codes.OUT_OF_TIME,
            "the search was stopped: nothing is proved, and the smallest class refuted ends at 7",
        ),
        (row(2, lower=1), [], codes.DEAD_TIME, "with dead time the theorems are about classes from 0 on"),
        (
            row(inf),
            [],
            codes.EVERY_FINITE,
            "every finite upper bound is proved, and a class without any holds nonlinearities beyond all of them",
        ),
        (row(2, verdict=OPEN), [], codes.NO_MULTIPLIER, "nothing is proved"),
        (row(2, verdict=OPEN, answers=(TRIED, RESIDUE)), [], WORSE, TOLD),
        (row(2, verdict=OPEN, answers=(RESIDUE, TRIED)), [], WORSE, TOLD),
    ],
)
def test_why_a_class_is_not_decided(asked, missed, code, said):
    assert advice.why(asked, [asked], OWN(sector=Sector(0, 9)), missed) == (code, said)


def test_what_is_proved_of_rows_that_do_not_serve_is_not_counted():
    rows = [row(9, time_varying=True, verdict=OPEN), row(2), row(3, "slope")]
    assert advice.why(rows[1], rows, OWN(sector=Sector(0, 9)), [])[1] == "what is proved ends at 2"
    assert advice.why(rows[1], rows, OWN.slope_restricted(0, 9), [])[1] == "what is proved ends at 3"


# park's theorem composes others: what it assumes of a sector slopes would show
@pytest.mark.parametrize(
    ("more", "promised"),
    [({}, True), ({"verdict": OPEN}, False), ({"proviso": "x"}, False), ({"proviso": "x", "question": "slope"}, True)],
)
def test_what_is_assumed_of_a_composed_theorem_is_not_promised(more, promised):
    composed = next(one.name for one in advice.TABLE if one.composed)
    assert advice._promised(row(**{"criterion": composed} | more)) is promised
    plain = next(one.name for one in advice.TABLE if not one.composed)
    assert advice._promised(row(**{"criterion": plain} | more)) is (more.get("verdict") is not OPEN)


class Slowly:
    """A gain that falls from 2 to 0, and is 1 at a million."""

    sector = Sector(0, 2)

    def __call__(self, sigma):
        """A quotient."""
        return 2 * sigma / (1 + abs(sigma) / 1e6)


# phi falls from the gain 2 to 0: small signals are stable with gains in (1, inf), large ones not
@pytest.mark.parametrize(
    ("nonlinearity", "local"),
    [(Saturation(gain=2, limit=1), True), (Saturation(gain=F(1, 2), limit=1), False), (Slowly(), False)],
)
def test_a_local_question_is_advised_where_small_signals_are_stable(nonlinearity, local):
    said = advice._local(nonlinearity, gain_intervals(RationalPlant([1], [1, -1])), "(1, inf)")
    assert "falls to 0; criteria for classes need another phi" in said[0]
    assert len(said) == 1 + local


# of what is not known anything is possible; of what is shown to be otherwise nothing
@pytest.mark.parametrize(
    ("provenance", "slopes", "odd", "found"),
    [
        ("CHECKED", None, False, [True, False, False]),
        ("CHECKED", SlopeBounds(0, 1), True, [True, True, True]),
        ("CHECKED", SlopeBounds(0, 1), False, [True, True, False]),
        ("DECLARED", None, False, [True, True, True]),
    ],
)
def test_a_property_is_possible_until_it_is_shown_not_to_be(provenance, slopes, odd, found, monkeypatch):
    from_where = getattr(nonlinearities.Provenance, provenance)
    known = SimpleNamespace(
        slope_bounds=SimpleNamespace(provenance=from_where, value=slopes),
        odd=SimpleNamespace(provenance=from_where, value=odd),
    )
    monkeypatch.setattr(nonlinearities, "properties", lambda _one: known)
    names = ("time-invariance", "slope bounds", "slope bounds and oddness")
    assert [advice._possible(name, "a phi") for name in names] == found


class Named(StructuredPlant):
    """A plant with a name."""

    name, order = "the rod", None

    def transfer(self, s):
        """Nothing."""
        return 0 * s

    def certificate_system(self):
        """Of no kind."""
        return {"kind": "rod"}


def test_a_plant_with_a_name_is_asked_about_as_it_is():
    plant = Named()
    found = problem._parts(plant, discretised=False)
    assert (found[0] is plant, found[1:]) == (True, (None, problem._EVERY))
    assert problem.plant_given(plant) is plant
    assert Problem.about(plant, OWN(sector=Sector(0, 1))).subject == "the rod"
    assert Problem.about(LAG, OWN(sector=Sector(0, 1))).subject == ""


# answers --------------------------------------------------------------------------------------------------------------


def test_without_rows_or_failures_no_criterion_serves():
    found = answers.certification_of(Attempts(Problem.about(THIRD, OWN(sector=Sector(0, 7)))), [])
    assert (found.code, found.detail) == (codes.NOT_APPLICABLE, "all: no criterion serves such a class")
    assert [one.search for one in found.failures] == ["all"]
    known = Attempts(Problem.about(THIRD, OWN(sector=Sector(0, 7))), [], found)
    assert answers.certification_of(known, [row(2)] * 2) is found


# of one channel with rows beside it the rows say why; a class without a lower end and several channels ask the searches
@pytest.mark.parametrize(
    ("problem", "by_rows"),
    [
        (Problem.about(THIRD, OWN(sector=Sector(0, 7))), True),
        (Problem.about(THIRD, OWN(sector=Sector(-inf, 7))), False),
        (Problem.about(THIRD, OWN(sector=Sector(0, 1), slope=SlopeBounds(-inf, 2))), False),
        (channel_problem(LAGS, [Sector(0, 1)] * 2), False),
    ],
)
def test_the_rows_say_why_a_class_is_not_decided(problem, by_rows):
    failure = Failure(search="a search", code=codes.PRECISION, detail="digits")
    found = answers.certification_of(Attempts(problem, [failure]), [row(2), row(2, "slope")])
    assert found.failures == (failure,)
    assert (found.detail, found.code) == (
        ("what is proved ends at 2", codes.NO_MULTIPLIER) if by_rows else ("a search: digits", codes.PRECISION)
    )


def result(verdict=OPEN, low=2.0, high=5.0, **more):
    made = {"criterion": "popov", "nonlinearity_class": OWN(sector=Sector(0, 3)), "evidence": Evidence.COMPUTED}
    return CriterionResult(**made | {"verdict": verdict, "largest": Bracket(low, high), "theorem": "Popov"} | more)


def member(k, shown=None):
    return Witness(
        kind="periodic orbit",
        k=k,
        evidence=Evidence.OBSERVED,
        slope_restricted=True,
        odd=True,
        description="it rings",
        refutation=shown,
    )


# an upper end is the least of what linear gains, counterexamples and, asked for by name, the criterion leave
@pytest.mark.parametrize(
    ("criterion", "witnesses", "limit", "largest_", "refuted_at"),
    [
        ("best", [], Bracket(0, 8), Bracket(2, 8), None),
        ("popov", [], Bracket(0, 8), Bracket(2, 5), None),
        ("best", [member(7.0)], Bracket(0, 8), Bracket(2, 7), 7.0),
        ("best", [member(7.0), member(6.0)], Bracket(0, 8), Bracket(2, 6), 6.0),
        ("best", [member(9.0)], Bracket(0, 8), Bracket(2, 8), 9.0),
        ("best", [member(1.0)], Bracket(0, 8), Bracket(2, 2), 1.0),
    ],
)
def test_both_ends_of_a_largest_class(criterion, witnesses, limit, largest_, refuted_at):
    asked = Problem.largest(LAG, "sector", lower=F(0), criterion=criterion)
    findings = Findings(asked, [result()], hurwitz=limit, witnesses=witnesses)
    found = answers.largest_of(findings)
    assert (found.largest, found.refuted_at, found.hurwitz) == (largest_, refuted_at, limit)
    assert (found.verdict, found.trivial) == (OPEN, None)
    assert found.evidence is Evidence.COMPUTED
    assert found.proviso == ""


# phi = lower sigma refutes every class, where it is unstable; a nonlinear member beside it is the witness
@pytest.mark.parametrize(
    ("shown_", "limit", "lower", "witness", "trivial", "evidence"),
    [
        ((None, None), Bracket(0, 0), False, 0, None, Evidence.COMPUTED),
        (("first", None), Bracket(0, 0), False, 0, None, Evidence.OBSERVED),
        (("first", "second"), Bracket(0, 0), False, 1, 0, Evidence.OBSERVED),
        ((None, "second"), Bracket(0, 0), False, 0, None, Evidence.COMPUTED),
        (("first", "second"), Bracket(0, 8), True, 1, 0, Evidence.OBSERVED),
        (("first", "second"), Bracket(0, 8), False, 0, None, Evidence.COMPUTED),
    ],
)
def test_what_refutes_every_class_stands_beside_what_refutes_larger_ones(
    shown_, limit, lower, witness, trivial, evidence, monkeypatch
):
    heard, made = [], {}
    both = [member(5.0, shown_[1]), member(3.0, shown_[0])]
    monkeypatch.setattr(answers, "refutes_lower", lambda _one: lower)
    monkeypatch.setattr(answers, "_concluded", lambda *given: heard.append(given) or SimpleNamespace(verdict=OPEN))
    monkeypatch.setattr(answers, "StabilityBound", lambda **given: made.update(given))
    asked = Problem.largest(LAG, "sector", lower=F(0))
    answers.largest_of(Findings(asked, [result()], hurwitz=limit, witnesses=both))
    ordered = both[::-1]
    assert made["witness"] is ordered[witness]
    assert made["trivial"] is (None if trivial is None else ordered[trivial])
    assert (made["refuted_at"], made["evidence"]) == (3.0, evidence)
    against = shown_[witness] if evidence is Evidence.OBSERVED else None
    assert heard[0][2:] == (against, made["trivial"])


def test_a_proof_beyond_a_counterexample_is_a_contradiction():
    asked = Problem.largest(LAG, "sector", lower=F(0))
    for k in (2.0, 1.5):
        with pytest.raises(ContradictionError, match="and it rings"):
            answers.largest_of(Findings(asked, [result(PROVED)], hurwitz=Bracket(0, 8), witnesses=[member(k)]))


# why nothing was shown: the search that could not be made, the time, the interruption
@pytest.mark.parametrize(
    ("verdict", "stopped", "said"),
    [
        (PROVED, "time", "why"),
        (OPEN, None, "left out; why"),
        (OPEN, "time", "the time allowed is over (LURE-I007)"),
        (OPEN, "interrupt", "interrupted"),
    ],
)
def test_the_reason_of_a_largest_class(verdict, stopped, said):
    findings = SimpleNamespace(stopped=stopped, left_out="left out; ")
    assert answers._reason(findings, result(verdict, reason="why")) == said


# what nothing is shown of is named by the class [lower, inf), for a proof by the end of what is proved
def test_the_class_that_is_concluded_about():
    asked = Problem.largest(LAG, "slope", lower=F(0), odd=True)
    found = answers._concluded(asked, result(reason="why"), None)
    assert found.headline == "Nothing is decided for odd phi with slope in [0, inf)."
    assert (found.evidence, found.reason) == (Evidence.COMPUTED, "why")
    for low, end in ((1.0, "[1, inf)"), (0.5, "[1, inf)"), (2.0, "[1, 2]")):  # what is proved ends at the lower end
        nothing = answers._concluded(Problem.largest(LAG, "sector", lower=F(1)), result(PROVED, low, inf), None)
        assert nothing.headline == f"Nothing is decided for phi, time-invariant, in the sector {end}."
    proof = max_sector(LAG, criterion="circle", lower=1).proof
    about = Problem.largest(LAG, "sector", lower=F(1))
    for low in (3.0, inf):  # the class in the words of the certificate
        told = answers._concluded(about, result(PROVED, low, inf), proof)
        assert (
            told.headline == "The point 0 attracts every solution for every phi, time-varying, in the sector [1, inf)."
        )
    with pytest.raises(MismatchError, match="Please report the block"):
        answers._concluded(Problem.largest(LAG, "sector", lower=F(-1)), result(PROVED, 3.0, inf), proof)


# a counterexample at the same k, which refutes all of the smaller class, refutes all of the larger one too
@pytest.mark.parametrize(
    ("trivial", "own", "at", "found"),
    [
        ("phi = 0", None, 2.0, ("phi = 0", "smaller", 2.0)),
        ("phi = 0", None, 1.0, (None, "larger", 1.0)),
        ("phi = 0", "own", 2.0, ("own", "larger", 2.0)),
        (None, None, 2.0, (None, "larger", 2.0)),
        (None, None, 3.0, (None, "smaller", 2.0)),
        ("phi = 0", None, None, ("phi = 0", "smaller", 2.0)),
    ],
)
def test_a_counterexample_to_every_class_is_one_to_the_larger_ones(trivial, own, at, found, monkeypatch):
    monkeypatch.setattr(answers, "replace", lambda one, **more: SimpleNamespace(**vars(one) | more))
    larger, smaller = row(1, verdict=OPEN, refuted_at=at), row(1, verdict=OPEN, refuted_at=2.0)
    larger.witness, larger.trivial = "larger", own
    smaller.witness, smaller.trivial = "smaller", trivial
    one = answers._spread([larger, smaller])[0]
    assert (one.trivial, one.witness, one.refuted_at) == found
    with pytest.raises(ContradictionError, match="popov proves up to 2, and smaller at 2"):
        answers._spread([row(2, witness="x", trivial=None), smaller])


# the largest class ---------------------------------------------------------------------------------------------------


def bound(**more):
    """A largest class as it is read, whatever its certificates."""
    one = object.__new__(StabilityBound)
    found = {"question": "sector", "criterion": "popov", "odd": False, "time_varying": False, "lower": F(0)}
    found |= {"largest": Bracket(4.0, 8.0), "verdict": PROVED, "refuted_at": None, "witness": None, "trivial": None}
    found |= {"classes": None, "answers": (), "theta": None, "evidence": Evidence.CERTIFIED, "stopped": None}
    for name, value in (found | more).items():
        object.__setattr__(one, name, value)
    return one


# within one part in a million proved and refuted are one; a small gap is said
@pytest.mark.parametrize(
    ("more", "gap"),
    [
        ({}, "open"),
        ({"refuted_at": 4.0}, "closed"),
        ({"refuted_at": 4.000003}, "closed"),
        ({"refuted_at": 4.001}, "closed to 0.0002"),
        ({"refuted_at": 5.0}, "open"),
        ({"refuted_at": 4.001, "verdict": OPEN}, "open"),
        ({"largest": Bracket(inf, inf)}, "closed"),
        ({"verdict": REFUTED, "refuted_at": 0.0}, "closed"),
        ({"verdict": REFUTED, "refuted_at": 1.0}, "open"),
        ({"verdict": REFUTED, "lower": F(1, 3), "refuted_at": double_above(F(1, 3))}, "closed"),
    ],
)
def test_a_gap_is_closed_small_or_open(more, gap):
    assert bound(**more).gap == gap
    assert bound(**more).closed is (gap == "closed")


@pytest.mark.parametrize(
    ("more", "name"),
    [
        ({}, "sector"),
        ({"time_varying": True}, "sector, time-varying"),
        ({"question": "slope"}, "slope"),
        ({"question": "slope", "odd": True}, "slope, odd"),
        ({"classes": Diagonal((OWN.relu(),) * 2)}, "ReLU"),
    ],
)
def test_a_class_has_a_name(more, name):
    assert bound(**more).class_name == name


# refuted for every k, or from the k of the certificate on
@pytest.mark.parametrize(
    ("lower", "at", "said"),
    [
        (F(0), 0.0, "whatever k > 0"),
        (F(1, 3), double_above(F(1, 3)), "whatever k > 0.3333334"),
        (F(0), 2.0, "whatever k >= 2"),
    ],
)
def test_for_which_k_a_class_is_refuted(lower, at, said):
    assert bound(verdict=REFUTED, lower=lower, refuted_at=at, witness=member(at)).refuted_ends == said


def test_proved_and_refuted_meet_within_a_millionth():
    assert [largest.meet(*ends) for ends in ((inf, inf), (1, inf), (1, 1), (1, 1 + 9e-7), (1, 1 + 2e-6), (-2, -1))] == [
        *(True, False, True, True, False, False)
    ]
    assert largest.meet(-1, -1 + 9e-7)


# the text of the certificate's own bound, where the number is that bound as a double; else the number
def test_a_bound_is_said_from_its_certificate():
    laws = {"sector": ["0", "1/3"], "slope": None}
    refuted = SimpleNamespace(certificate={"laws": laws})
    assert largest._end_text(member(double_above(F(1, 3)), refuted), double_above(F(1, 3))) == "0.3333334"
    assert largest._end_text(None, 0.5) == largest._end_text(member(0.5), 0.5) == "0.5"
    assert largest.only_class(SimpleNamespace(certificate={"laws": {"channels": [laws]}})) == laws
    ends = [(F(0), F(2)), (F(-1), F(3))]
    both = SimpleNamespace(certificate={"laws": {"sector": ["0", "2"], "slope": ["-1", "3"]}, "proof": {"method": "x"}})
    assert largest._ends(both) == ends
    assert largest._needed(both) == 3
    both.certificate["proof"] = {"method": "linear-gain", "gain": "1/2"}
    assert largest._needed(both) == F(1, 2)
    both.certificate["proof"] = {"method": "late-gains", "gains": ["1/4", "9"]}
    assert largest._needed(both) == F(1, 4)


# the analysis ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rows", "plant", "found"),
    [
        ([], RationalPlant([1], [1, 1]), "stable"),
        ([], RationalPlant([1], [1, 1, 0]), "critical"),
        ([], RationalPlant([1], [1, -1]), "unstable"),
        ([], as_plant("exp(-s)/(s+1)"), "stable"),
        ([], StateSpace([[-1.0]], [1.0], [1.0]), "stable"),
        ([row(4)], StateSpace([[1.0]], [1.0], [1.0]), "stable"),
        ([row(4, critical=True)], StateSpace([[1.0]], [1.0], [1.0]), "critical"),
        ([row(4, critical=True, lower=-1)], StateSpace([[1.0]], [1.0], [1.0]), "stable"),
        ([row(4, lower=1)], StateSpace([[1.0]], [1.0], [1.0]), "unstable"),
        ([row(-1, lower=-2)], StateSpace([[1.0]], [1.0], [1.0]), "unstable"),
        ([row(4, verdict=OPEN)], StateSpace([[1.0]], [1.0], [1.0]), "unstable"),
        ([row(4, verdict=OPEN), row(4)], StateSpace([[1.0]], [1.0], [1.0]), "stable"),
    ],
)
def test_the_case_of_a_plant(rows, plant, found):
    assert table._case(plant, rows) == found


# of many states only poles far outside are seen; of a box unstable ones alone decide
def test_the_case_of_a_large_plant(monkeypatch):
    monkeypatch.setattr(table, "MAX_EXACT_STATES", 1)
    for (a, dt), case in {(1.0, None): "unstable", (-1.0, None): None, (2.0, 1): "unstable", (0.5, 1): None}.items():
        assert table._poles(StateSpace(np.diag([a, 0.0]), [1.0, 1.0], [1.0, 1.0], dt=dt)) == case
    assert table._poles(StateSpace(np.diag([1e-9, -1.0]), [1.0, 1.0], [1.0, 1.0])) is None
    assert [table._together(one) for one in (["stable"], ["stable"] * 2, ["stable", "unstable"])] == [
        *("stable", None, "unstable")
    ]


def test_the_row_that_reaches_farthest_is_proved():
    varying, open_ = row(4, time_varying=True), row(9, verdict=OPEN)
    assert table._farthest([varying, row(3), open_]) is varying
    same = row(4)
    assert table._farthest([varying, same, open_]) is same
    assert table._farthest([open_, row(5, verdict=OPEN)]) is open_


@pytest.mark.parametrize(
    ("bounds", "start"), [(Sector(-inf, 1), 0), (Sector(F(1, 3), 1), F(1, 3)), (SlopeBounds(-1, 1), -1)]
)
def test_where_the_rows_begin(bounds, start):
    assert table._start(bounds) == start


# where a pole at 0 stays, 0 need not attract; with a phi of which it is shown others are named
@pytest.mark.parametrize(
    ("critical", "nonlinearity", "attracts", "said"),
    [
        (False, "", True, None),
        (True, "", True, None),
        (True, "", False, "that 0 attracts every solution: the loop"),
        (True, "tanh", True, "that 0 attracts every solution with another phi than tanh: the loop"),
        (True, "tanh", False, "that 0 attracts every solution: the loop"),
    ],
)
def test_what_must_not_be_read_into_an_analysis(critical, nonlinearity, attracts, said):
    found = SimpleNamespace(shown=None, nonlinearity=nonlinearity, attracts=attracts)
    notes = table._not_shown(LAG, [row(critical=False), row(critical=critical)], found)
    assert len(notes) == 2 + (said is not None)
    assert said is None or (notes[0].startswith(said) and "a pole at 0, and" in notes[0])
    sampled = table._not_shown(
        RationalPlant([1], [1, 1], 1), [row(critical=True)], SimpleNamespace(**vars(found) | {"attracts": False})
    )
    assert "a pole at z = 1, and" in sampled[0]
    for regularity, rest in ((None, 2), ("any", 1)):
        found.shown = shown(laws={"regularity": regularity})
        assert len(table._not_shown(LAG, [row()], found)) == rest

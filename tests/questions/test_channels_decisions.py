"""How the largest factor of several channels is looked for and told, and what a problem is, one decision at a time."""

from dataclasses import replace
from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from worded import PLAIN, shown

from lure import (
    AssumptionError,
    InputError,
    NonlinearityClass,
    RationalPlant,
    Saturation,
    Sector,
    SlopeBounds,
    StateSpace,
    as_plant,
)
from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import MOVES
from lure.analysis.certificates.drafts import Failure
from lure.analysis.questions import channels, problem, table
from lure.analysis.questions.answers import ContradictionError
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import KINDS, PARAMETRIC, STORED
from lure.analysis.questions.channels import Factors, channel_bound
from lure.analysis.questions.conclusion import MismatchError
from lure.analysis.questions.problem import Problem, posed
from lure.analysis.verdict import Bracket, Verdict
from lure.classes import Diagonal
from lure.errors import Reason
from lure.files.builtin import builtin_loop
from lure.nonlinearities import Quantiser
from lure.plants.delay_matrix import one_channel_of
from lure.plants.frequency_data import FrequencyData

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
OWN = NonlinearityClass
LAGS = as_plant(([[-1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))))
UNIT = [Sector(0, 1)] * 2


def asking(classes=UNIT, kind="sector", plant=LAGS, **more):
    return replace(channel_problem(plant, classes, kind=kind), **more)


# the member ----------------------------------------------------------------------------------------------------------


def member(proof, **more):
    laws = {"channels": [PLAIN, PLAIN], "repeated": False}
    return shown(MOVES, **{"laws": laws, "proof": proof} | more)


POINTS = {"points": [["0", "0"]], "left": "2", "right": "2"}
GAINS = {"method": "linear-gains", "gains": ["1", "2"]}


@pytest.mark.parametrize(
    ("proof", "kind", "jumps", "odd", "data"),
    [
        (GAINS, "linear gains", False, True, {"gains"}),
        ({"method": "switched-gains", "gains": [["1"], ["2"]]}, "switched gain", True, True, {"gains"}),
        ({"method": "switched-gain", "gains": ["1", "2"]}, "switched gain", True, True, {"gains"}),
        ({"method": "ramped-gains", "gains": [["1"], ["2"]]}, "varying gain", True, True, {"gains"}),
        (
            {"method": "flow-orbit", **POINTS, "durations": ["1"], "half": True},
            "periodic orbit",
            False,
            True,
            {"points", "durations"},
        ),
        (
            {"method": "flow-orbit", **POINTS, "durations": ["1"], "half": False},
            "periodic orbit",
            False,
            False,
            {"points", "durations"},
        ),
        ({"method": "equilibrium", "nonlinearities": [POINTS]}, "equilibrium", False, False, {"nonlinearities"}),
        (
            {"method": "signal", "slopes": ["1"], "inputs": [["1"]], "gains": ["3"]},
            "disturbance",
            False,
            True,
            {"slopes", "inputs"},
        ),
        ({"method": "relu-ray", "gains": [["1", "0"]]}, "ray", False, True, {"gains"}),
        (
            {"method": "part", "channels": [2], "kind": "transfer", "proof": {"method": "linear-gain", "gain": "1"}},
            *("linear gains", False, True, {"gain", "channels"}),
        ),
    ],
)
def test_the_member_of_a_refutation(proof, kind, jumps, odd, data):
    found = channels._witness(member(proof), 2.0)
    assert (found.kind, found.time_varying, found.odd, set(found.data), found.k) == (kind, jumps, odd, data, 2)
    grows = "a solution grows without bound, "
    assert found.description.startswith(grows) is (kind == "ray")


def test_the_member_of_a_family_has_its_parameters():
    system = {"kind": "family", "parameters": [["a", "1", "2"], ["b", "0", "1"]]}
    found = channels._witness(member({"method": "member", "at": ["3/2", "1"], "proof": GAINS}, system=system), 2.0)
    assert found.data == {"parameters": {"a": "3/2", "b": "1"}, "gains": ["1", "2"]}


# one criterion --------------------------------------------------------------------------------------------------------


def criterion(name="diagonal-circle", **row):
    made = {"title": "A theorem", "linear": False, "slope": False, "odd": False, "time_varying": True}
    kind = row.pop("kind", 0)
    return SimpleNamespace(name=name, kind=kind, row=SimpleNamespace(**made | row))


FAILED = Failure(search="x", code=codes.NO_MULTIPLIER, detail="no numbers")


@pytest.mark.parametrize(
    ("found", "known", "reason"),
    [
        (None, F(0), "no multiplier was found"),
        (None, F(2), "no multiplier was found that proves more than the factor 2, which is proved"),
        (FAILED, F(2), "no numbers"),
    ],
)
def test_a_criterion_that_shows_nothing(found, known, reason):
    one = channels._answer(asking(), criterion(), found, known)
    assert (one.verdict, one.reason, one.largest) == (OPEN, reason, Bracket(0, inf))


@pytest.mark.parametrize(
    ("one", "multiplier", "formula", "theorem"),
    [
        (criterion(), {"lambda": ["1"]}, "Lambda", "A theorem, with a multiplier for each channel"),
        (criterion(), {"theta": ["0", "0"]}, "Lambda", "A theorem, with a multiplier for each channel"),
        (criterion(), {"theta": ["0", "1/2"]}, "Lambda + s Theta", "A theorem, with a multiplier for each channel"),
        (criterion(kind=STORED), {"theta": ["1"]}, KINDS[STORED][2], f"A theorem, with {KINDS[STORED][1]}"),
        (criterion(linear=True), {"theta": ["1"]}, None, "A theorem"),
    ],
)
def test_a_criterion_that_proves_a_factor(one, multiplier, formula, theorem):
    proof = SimpleNamespace(certificate={"multiplier": multiplier}, facts={"class": "x", "poles": "stable"})
    found = channels._answer(asking(), one, (F(1, 3), proof), F(0))
    assert (found.verdict, found.reason) == (PROVED, "proved for the upper bounds times 0.3333333")
    assert (found.multiplier, found.theorem) == (formula, theorem)
    assert found.hypotheses == ("poles: stable",)
    assert found.classes.upper == (F(1, 3), F(1, 3))
    assert found.largest.low <= F(1, 3)


# the answer ----------------------------------------------------------------------------------------------------------


def concluded(verdict):
    return SimpleNamespace(verdict=verdict, shown=None if verdict is OPEN else "shown")


def test_a_proof_beyond_a_refutation_is_a_contradiction():
    for low in (F(2), F(3)):
        with pytest.raises(ContradictionError, match="and 2 refuted"):
            channel_bound(asking(), (low, shown()), (F(2), member(GAINS)))


@pytest.mark.parametrize("verdict", [PROVED, OPEN])
def test_a_refutation_that_does_not_fit_is_a_mistake(verdict, monkeypatch):
    monkeypatch.setattr(channels, "conclusion_of", lambda *_: concluded(verdict))
    with pytest.raises(MismatchError, match="Please report"):
        channel_bound(asking(), None, (F(2), member(GAINS)))
    if verdict is OPEN:
        with pytest.raises(MismatchError, match="Please report"):
            channel_bound(asking(), (F(1), shown()), None)


# upper ends: a member of constant gains limits linear gains too; of ReLUs other factors are other functions
@pytest.mark.parametrize(
    ("classes", "against", "largest", "hurwitz", "refuted_at"),
    [
        (UNIT, None, (0, inf), (0, inf), None),
        (UNIT, (F(2), GAINS), (0, 2), (0, 2), 2),
        (UNIT, (F(2), {"method": "switched-gains", "gains": [["1"], ["2"]]}), (0, 2), (0, inf), 2),
        (UNIT, (F(2), {"method": "equilibrium", "nonlinearities": [POINTS]}), (0, 2), (0, inf), 2),
        (UNIT, (F(0), GAINS), (0, 0), (0, 0), 0),
        ([OWN.relu()] * 2, (F(2), GAINS), (0, inf), (0, inf), 2),
        ([OWN.relu()] * 2, (F(0), GAINS), (0, 0), (0, 0), 0),
    ],
)
def test_both_ends_of_a_largest_factor(classes, against, largest, hurwitz, refuted_at, monkeypatch):
    def follows(_asked, accepted, **_more):
        return concluded(OPEN if accepted is None else REFUTED)

    made = {}
    monkeypatch.setattr(channels, "conclusion_of", follows)
    monkeypatch.setattr(channels, "undecided", lambda *_: concluded(OPEN))
    monkeypatch.setattr(channels, "StabilityBound", lambda **given: made.update(given))
    channel_bound(asking(classes), None, None if against is None else (against[0], member(against[1])), reason="why")
    ends = [(one.low, one.high) for one in (made["largest"], made["hurwitz"])]
    assert (ends, made["refuted_at"]) == ([largest, hurwitz], refuted_at)
    assert made["verdict"] is (REFUTED if against is not None and not against[0] else OPEN)
    assert (made["critical"], made["proviso"], made["criterion"], made["multiplier"]) == (False, "", "", None)
    assert (made["witness"] is None) is (against is None)


# the largest factor tried is no end of the criterion, where nothing refutes it
@pytest.mark.parametrize(("share", "against", "limited"), [(16, False, False), (4, False, True), (4, True, False)])
def test_a_factor_that_was_the_largest_tried(share, against, limited, monkeypatch):
    made = {}
    monkeypatch.setattr(channels, "conclusion_of", lambda _a, one, **_m: concluded(PROVED if one is proof else REFUTED))
    monkeypatch.setattr(channels, "StabilityBound", lambda **given: made.update(given))
    proof = shown()
    proof.facts, proof.assumed, proof.theorem = {"residue": "x"}, "", "circle"
    answer = channels._answer(asking(), criterion(), None, F(0))
    factor = F(channels.LARGEST) / share
    beyond = (factor * 2, member(GAINS)) if against else None
    first, last = (replace(answer, multiplier=one, parameters={"of": one}) for one in ("first", "last"))
    channel_bound(asking(), (factor, proof), beyond, [first, last])
    assert [one.search_limited for one in made["answers"]] == [limited, False]
    assert (made["multiplier"], made["parameters"]) == ("first", {"of": "first"})
    assert (made["critical"], made["criterion"], made["verdict"]) == (True, "circle", PROVED)


@pytest.mark.parametrize(
    ("kind", "classes", "question"),
    [
        ("slope", [SlopeBounds(0, 1)] * 2, "slope"),
        ("sector", [SlopeBounds(0, 1)] * 2, "sector"),
        ("class", [SlopeBounds(0, 1)] * 2, "slope"),
        ("class", UNIT, "sector"),
    ],
)
def test_what_bounds_the_classes_of_an_answer(kind, classes, question):
    assert channel_bound(asking(classes, kind), None, None, reason="why").question == question


# why nothing is proved: the last criterion's reason, or the time
def test_what_follows_from_what_was_found(monkeypatch):
    heard = []
    monkeypatch.setattr(channels, "channel_bound", lambda *given, **more: heard.append((given, more)))
    failed = channels._answer(asking(), criterion(), FAILED, F(0))
    best = replace(failed, largest=Bracket(2, inf), verdict=PROVED)
    for found, reason in (
        (Factors(asking()), "no criterion was asked"),
        (Factors(asking(), left_out="left out; "), "left out; no criterion was asked"),
        (Factors(asking(), [failed, replace(failed, reason="last")]), "last"),
        (Factors(asking(), [failed], stopped="interrupt"), "no numbers"),
        (Factors(asking(), [failed], stopped="time"), f"the time allowed is over ({codes.OUT_OF_TIME.identifier})"),
        (Factors(asking(), [failed], stopped="time", proofs=[(F(1), "a")]), ""),
    ):
        assert found.bound is None
        assert heard[-1][1]["reason"] == reason
        assert heard[-1][1]["stopped"] == found.stopped
    both = Factors(asking(), [failed, best], proofs=[(F(1), "a"), (F(3), "b"), (F(2), "c")])
    assert (both.known, both.empty, both.bound) == (3, False, None)
    assert heard[-1][0][1] == (3, "b")
    assert [one.verdict for one in heard[-1][0][3]] == [PROVED, OPEN]
    assert Factors(asking()).empty
    assert not Factors(asking(), against=(F(1), "x")).empty
    assert Factors(asking()).known == 0


# what was asked before -----------------------------------------------------------------------------------------------


VARYING = [OWN(sector=Sector(0, 1), time_varying=True)] * 2


@pytest.mark.parametrize(
    ("row", "classes", "tried", "sees"),
    [
        ({}, VARYING, True, False),
        ({}, VARYING, False, True),
        ({"slope": True}, VARYING, True, True),
        ({"odd": True}, VARYING, True, True),
        ({"time_varying": False}, UNIT, True, True),
        ({"time_varying": False}, VARYING, True, False),
        ({"kind": PARAMETRIC}, UNIT, True, True),
        ({"kind": PARAMETRIC}, VARYING, True, False),
        ({}, UNIT, True, False),
    ],
)
def test_which_criteria_see_more_of_smaller_classes(row, classes, tried, sees):
    before = SimpleNamespace(classes=asking(VARYING).classes, answers=[SimpleNamespace(criterion="x")])
    if tried:
        before.answers.append(SimpleNamespace(criterion="diagonal-circle"))
    assert bool(channels._sees(criterion(**row), asking(classes), before)) is sees


@pytest.mark.parametrize(
    ("classes", "stopped", "larger"),
    [
        (VARYING, None, True),
        (VARYING, "time", False),
        ([Sector(0, 2)] * 2, None, False),
        ([SlopeBounds(0, 1)] * 2, None, False),
        (None, None, False),
        ([Sector(-1, 1)] * 2, None, False),
    ],
)
def test_which_answers_are_about_larger_classes(classes, stopped, larger):
    row = SimpleNamespace(classes=None if classes is None else asking(classes).classes, stopped=stopped)
    assert bool(channels._larger(row, asking(UNIT))) is larger


def test_a_member_of_smaller_classes_is_carried_over(monkeypatch):
    heard = []

    def refute(_asked, alpha, proof):
        heard.append((alpha, proof))
        return "again"

    monkeypatch.setattr(channels, "refutation", refute)
    refuted = SimpleNamespace(certificate={"proof": "gains"})
    row = {"classes": asking().classes, "refutation": refuted}
    assert channels._against(asking(), SimpleNamespace(**row, refuted_at=2.0)) == (2, "again")
    assert channels._against(asking(), SimpleNamespace(**row, refuted_at=0.0)) == (0, "again")
    assert heard == [(2, "gains"), (1, "gains")]
    assert channels._against(asking(), SimpleNamespace(classes=asking().classes, refutation=None)) is None
    monkeypatch.setattr(channels, "_at_once", lambda _asked: None)
    monkeypatch.setattr(channels, "members_refuting", lambda _asked, most: ("searched", most))
    assert channels._against(asking(), None) == ("searched", inf)
    together = SimpleNamespace(classes=asking(Diagonal((OWN(sector=Sector(0, 1)),) * 2, repeated=True)).classes)
    together.refutation = refuted
    assert channels._against(asking(), together) == ("searched", inf)
    monkeypatch.setattr(channels, "refutation", lambda *_: None)
    assert channels._against(asking(), SimpleNamespace(**row, refuted_at=2.0)) == ("searched", inf)


# 10^140 and its inverse are the ends of what is asked, where factors are
@pytest.mark.parametrize(
    ("upper", "refused"),
    [(10**139, False), (10**141, True), (F(1, 10**139), False), (F(1, 10**141), True), (0, False), (-(10**141), True)],
)
def test_upper_bounds_whose_factors_are_no_doubles(upper, refused):
    asked = asking([Sector(-(10**142), upper), Sector(0, 1)])
    channels.require_range(replace(asked, kind="class"))
    channels.require_range(Problem.largest(RationalPlant([1], [1, 1]), "sector", lower=F(0)))
    if refused:
        with pytest.raises(InputError, match="the upper bound of channel 1 is"):
            channels.require_range(asked)
    else:
        channels.require_range(asked)


# 1 + D L is singular for D = -1 and the gain 1
@pytest.mark.parametrize(("direct", "lower", "posed_"), [(-1, 1, False), (-1, 0, True), (0, 1, True), (-1, 2, True)])
def test_a_loop_without_one_solution_is_refused(direct, lower, posed_):
    plant = as_plant(([[-1]], [[1, 0]], [[1], [0]], [[direct, 0], [0, 0]]))
    asked = asking([Sector(lower, 3), Sector(0, 1)], plant=plant)
    if posed_:
        channels.require_well_posed(asked)
        return
    with pytest.raises(InputError, match="= 0 for the gains 1, 0 at"):
        channels.require_well_posed(asked)
    assert [name for name, _ in channels.proposals(replace(asked, kind="class"))] == ["constant gains"]


def test_no_theorem_is_left_to_the_criteria():
    with channels._left_to_criteria():
        raise AssumptionError("x", code=Reason.NOT_APPLICABLE)
    with pytest.raises(AssumptionError), channels._left_to_criteria():
        raise AssumptionError("x", code=Reason.CRITICAL)


# the plan ------------------------------------------------------------------------------------------------------------


NAMES = {"g": "constant gains", "s": "switched gains", "p": "periodic solutions", "r": "rays of ReLUs"}


def run(steps):
    taken = []
    for name, step in steps:
        taken.append(name)
        step()
    return taken


# criteria while a gap is left, of a kind that shows something the first; then gains that jump, then orbits
@pytest.mark.parametrize(
    ("against", "shows", "steps"),
    [
        (None, {}, ["g", "a", "b", "c", "s", "p"]),
        ((F(0), "x"), {}, ["g"]),
        ((F(2), "x"), {"a": F(1)}, ["g", "a", "c", "s", "p"]),
        ((F(2), "x"), {"a": F(2) * (1 - F(1, 10**7))}, ["g", "a"]),
        ((F(2), "x"), {"a": F(2) * (1 - F(1, 10**5))}, ["g", "a"]),
        ((F(2), "x"), {"a": F(2) * (1 - F(1, 10**3))}, ["g", "a", "c", "s"]),
        ((F(2), "x"), {"b": F(1), "c": F(3, 2)}, ["g", "a", "b", "c", "s", "p"]),
    ],
)
def test_the_plan_of_a_largest_factor(against, shows, steps, monkeypatch):
    rows = [criterion("a"), criterion("b"), criterion("c", kind=1)]

    def far(_asked, one, known, most):
        assert known == max((shows[name] for name in shows if name < one.name), default=0)
        assert most == (inf if against is None else against[0])
        shown_ = SimpleNamespace(certificate={"multiplier": {}}, facts={})
        return (shows[one.name], shown_) if one.name in shows else None

    monkeypatch.setattr(channels, "criteria_for", lambda _asked: rows)
    monkeypatch.setattr(channels, "_against", lambda *_: against)
    monkeypatch.setattr(channels, "farthest", far)
    for name in ("switching_refuting", "orbits_refuting", "rays_refuting"):
        monkeypatch.setattr(channels, name, lambda *_: None)
    found = Factors(asking())
    assert run(channels.factor_steps(found, ())) == [NAMES.get(one, one) for one in steps]
    assert found.complete
    assert found.against == against
    assert [factor for factor, _ in found.proofs] == list(shows.values())
    with pytest.raises(InputError, match="an upper bound is not positive"):
        next(channels.factor_steps(Factors(asking([Sector(-1, 0), Sector(0, 1)])), ()))


def test_a_linear_criterion_ends_the_plan_and_relus_have_rays(monkeypatch):
    linear = SimpleNamespace(certificate={"multiplier": {}}, facts={})
    monkeypatch.setattr(channels, "criteria_for", lambda _asked: [criterion("a", linear=True), criterion("c", kind=1)])
    monkeypatch.setattr(channels, "_against", lambda *_: None)
    monkeypatch.setattr(channels, "farthest", lambda *_: (F(1), linear))
    for name in ("switching_refuting", "orbits_refuting", "rays_refuting"):
        monkeypatch.setattr(channels, name, lambda *_: (F(7), "against"))
    found = Factors(asking())
    assert run(channels.factor_steps(found, ())) == [NAMES[one] if one != "a" else one for one in "gasp"]
    assert found.against == (7, "against")
    relus = Factors(asking([OWN.relu()] * 2))
    assert run(channels.factor_steps(relus, ()))[2] == NAMES["r"]
    stopped = Factors(asking(), stopped="time")
    assert run(channels.factor_steps(stopped, ())) == [NAMES["g"]]
    assert not stopped.complete


# one class: gains, criteria, then what moves; beside largest factors what was accepted for them
@pytest.mark.parametrize(
    ("classes", "rows", "names"),
    [
        (UNIT, [], ["constant gains", "a", "periodic solutions"]),
        (VARYING, [], ["constant gains", "a", "switched gains", "periodic solutions"]),
        (UNIT, [("wider", 3)], ["constant gains", "a", "wider"]),
        (UNIT, [("narrow", F(1, 2))], ["constant gains", "the largest factor"]),
        ([OWN.relu()] * 2, [("wider", 3)], ["constant gains", "a", "periodic solutions"]),
    ],
)
def test_the_proposals_for_one_class(classes, rows, names, monkeypatch):
    monkeypatch.setattr(channels, "criteria_for", lambda _asked: [criterion("a")])
    made = []
    for theorem, end in rows:
        laws = asking([Sector(0, end)] * 2, "class").class_entry
        made.append(
            SimpleNamespace(proof=shown(theorem=theorem, laws=laws), refutations=(), classes=None, stopped=None)
        )
    found = list(channels.proposals(asking(classes, "class"), made))
    assert [name for name, _ in found] == names
    if rows:
        assert found[0][1]() is None
    if names[-1] == "wider":
        assert found[-1][1]() is made[0].proof


def test_what_was_refuted_of_a_factor_refutes_the_class_that_contains_it():
    inner, outer = (
        SimpleNamespace(certificate={"laws": asking([Sector(0, end)] * 2, "class").class_entry}) for end in (F(1, 2), 2)
    )
    rows = [SimpleNamespace(proof=None, refutations=(outer, inner), classes=None, stopped=None)]
    assert dict(channels.proposals(asking(kind="class"), rows))["constant gains"]() is inner


# problems ------------------------------------------------------------------------------------------------------------


UNSTABLE = RationalPlant([1], [1, -1])


@pytest.mark.parametrize(
    ("one", "lower", "endless"),
    [
        (OWN(sector=Sector(F(1, 2), 1)), F(1, 2), False),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 2)), -1, False),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(-inf, 2)), None, True),
        (OWN(sector=Sector(-inf, 1)), None, True),
        (OWN(sector=Sector(0, 1)), 0, False),
    ],
)
def test_where_a_class_begins(one, lower, endless):
    asked = Problem.about(UNSTABLE, one)
    assert asked.endless_below is endless
    if lower is not None:
        assert asked.lower == lower
    assert asking().lower == 0


@pytest.mark.parametrize(
    ("plant", "given", "said"),
    [
        (([[-1]], [[1, 1]], [[1]], [[0, 0]]), [Sector(0, 1)], "need as many of both"),
        ((np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0)), np.eye(2)), UNIT, "the plant has no state"),
        (LAGS, [Sector(0, 1)], "one class is given for 2 channels"),
        (LAGS, [Sector(0, 1)] * 3, "3 classes are given for 2 channels"),
        (([[-1]], [[1]], [[1]], [[0]]), UNIT, "2 classes are given for one channel"),
        (LAGS, [Sector(0, 1), Sector(0, inf)], "channel 2 has the bounds \\[0, inf\\]"),
        (LAGS, [Sector(-inf, 1), Sector(0, 1)], "channel 1 has the bounds \\[-inf, 1\\]"),
        (([[-1]], [[1]], [[1]], [[0]]), [Sector(0, inf)], "the class has the bounds"),
    ],
)
def test_what_is_no_problem_of_several_channels(plant, given, said):
    with pytest.raises(InputError, match=said):
        channel_problem(as_plant(plant), given)


def test_a_problem_is_what_was_asked():
    linear = OWN.constant_gain(0, 1)
    assert Problem.about(UNSTABLE, linear).linear
    assert not Problem.about(StateSpace([[-1.0]], [1.0], [1.0]), linear).linear
    assert Problem.about(UNSTABLE, None, name="x").name == "x"
    largest = Problem.largest(UNSTABLE, "slope", lower=F(0), odd=True, time_varying=False)
    assert (largest.question, largest.odd, largest.time_varying, largest.assuming) == ("slope", True, False, True)
    assert Problem.largest(UNSTABLE, "sector", lower=F(0), time_varying=True).time_varying
    assert not Problem.about(UNSTABLE, OWN(sector=Sector(0, 1))).assuming
    both = asking([OWN(sector=Sector(0, 1), odd=True, time_varying=True), Sector(0, 1)])
    assert (both.odd, both.time_varying, both.given) == (False, True, None)
    assert asking([SlopeBounds(0, 1), Sector(0, 1)]).question == "sector"
    assert both.scaled(F(1)) is both
    assert both.scaled(F(2)).classes.upper == (2, 2)
    assert (both == both.scaled(F(2)), both == asking(both.classes), both == 1) == (False, True, False)
    assert Problem.about(UNSTABLE, OWN(sector=Sector(0.1, 1e22))).spelled == {F(0.1): "0.1"}
    assert Problem.about(UNSTABLE, linear).block == UNSTABLE


# a quantiser has no slopes and jumps: in continuous time nothing is proved of it, with z and no direct term it is
@pytest.mark.parametrize(
    ("plant", "provable"),
    [
        (UNSTABLE, False),
        (RationalPlant([1], [1, F(1, 2)], 1), True),
        (RationalPlant([1, 1], [1, F(1, 2)], 1), False),
        (StateSpace([[0.5]], [1.0], [1.0], dt=1), True),
    ],
)
def test_what_jumps_is_provable_where_the_next_state_is_defined(plant, provable):
    found = Problem.about(plant, OWN(sector=Sector(0, 2)), nonlinearity=Quantiser(step=1))
    assert (found.rough, found.provable) == (True, provable)
    assert Problem.about(plant, OWN(sector=Sector(0, 2)), nonlinearity=Saturation(gain=1, limit=1)).provable
    assert not replace(found, untested=True).provable


def test_a_loop_is_closed_once():
    loop = builtin_loop("dead-zone")
    assert problem.loop_given(loop) is loop
    with pytest.raises(InputError, match="closes the loop itself"):
        problem.loop_given(loop, "tanh(sigma)")
    open_ = replace(loop, nonlinearity=None, nonlinearity_class=None)
    closed = problem.loop_given(open_, "tanh(sigma)")
    assert (closed.name, closed.block, str(closed.nonlinearity)) == (loop.name, loop.block, "tanh(sigma)")
    assert problem.loop_given("1/(s+1)", Sector(0, 1)).nonlinearity_class == OWN(sector=Sector(0, 1))
    assert problem.loop_given("1/(s+1)", Sector(0, 1)).name == "loop"


# what is measured is refused with its reason; hurwitz is about gains alone
def test_what_is_posed():
    measured = FrequencyData([0.1, 1.0], [1 + 0j, 0.5 + 0j])
    found = posed(measured, OWN(sector=Sector(0, 1)), criterion="best", finite=False)
    assert [one.code for one in found.refusals] == [codes.SAMPLED]
    assert "known at 2 frequencies" in found.refusals[0].detail
    with pytest.raises(AssumptionError) as caught:
        problem.certifiable(measured)
    assert caught.value.code is Reason.SAMPLED
    rough = replace(builtin_loop("dead-zone"), nonlinearity=Quantiser(step=1), nonlinearity_class=None)
    assert [one.code for one in posed(rough, None, criterion="best", finite=False).refusals] == [codes.NOT_LIPSCHITZ]
    assert posed(rough, None, criterion="hurwitz", finite=False).nonlinearity is None
    assert posed(rough, OWN(sector=Sector(0, 1)), criterion="best", finite=False).refusals == ()
    linear = posed(UNSTABLE, OWN.constant_gain(0, 1), criterion="best", finite=True)
    assert (linear.criterion, linear.finite) == ("hurwitz", True)
    assert posed(UNSTABLE, OWN.constant_gain(0, 1), criterion="circle", finite=False).criterion == "circle"
    with pytest.raises(InputError, match="no class of nonlinearities is given"):
        posed(UNSTABLE, None, criterion="best", finite=False)


# the document --------------------------------------------------------------------------------------------------------


def test_a_loop_as_data():
    one = table._loop(Problem.about(as_plant("exp(-s)/(s+1)"), OWN(sector=Sector(0, 1))))
    assert (one["block"]["terms"], one["block"]["denominator"]) == ([["1", ["1"]]], ["1", "1"])
    assert ("feedback" in one["block"], one["law"], one["class"]["sector"]) == (False, None, [0.0, 1.0])
    late = table._loop(Problem.about(as_plant("1/(s + 1 + exp(-s))"), None))
    assert late["block"]["feedback"] == [["1", ["1"]]]
    assert late["class"] is None
    several = table._loop(asking(kind="class"))
    assert [each["name"] for each in several["channels"]] == ["channel 1", "channel 2"]
    assert (several["repeated"], "classes" in several, several["channels"][0]["law"]) == ([1, 1], True, None)
    assert "classes" not in table._loop(asking())
    neutral = one_channel_of(as_plant("1/(s + 2 + s*exp(-s)/5)"))  # x'(t) + x'(t - 1)/5 = -2 x + mu
    asked = Problem(plant=neutral, classes=Diagonal((OWN(sector=Sector(0, 1)),)), kind="class")
    assert table._loop(asked)["block"]["matrices"]["rates"] == [[[["0"]], [["-1/5"]]]]
    assert "channels" not in one

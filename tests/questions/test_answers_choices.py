"""What the questions choose, refuse and name, one decision at a time."""

from dataclasses import replace
from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from worded import PLAIN, shown

from lure import (
    AssumptionError,
    DeadZone,
    InputError,
    NonlinearityClass,
    RationalPlant,
    Saturation,
    Sector,
    SlopeBounds,
    StateSpace,
    as_plant,
)
from lure.analysis.cli import performance
from lure.analysis.cli.loops import lines
from lure.analysis.inequality.gains import gain_intervals
from lure.analysis.questions import advice, max_sector, problem, steady, table, tolerances
from lure.analysis.questions.channel_hypotheses import constant_gains_of, groups_of
from lure.analysis.questions.channel_kinds import channel_hints
from lure.analysis.questions.channel_map import stability_map
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for, proved_whole
from lure.analysis.questions.channels import _ends_before
from lure.analysis.questions.conclusion import _member, _refuted, _takes_a_value_twice, conclusion_of
from lure.analysis.questions.energy import energy_bounds
from lure.analysis.questions.gain import LONGEST, _last_channels, _window, gain_problem
from lure.analysis.questions.problem import Problem
from lure.analysis.questions.regions import AttractedSet
from lure.analysis.questions.worst_plants import _moved, least
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.analysis.wording import counterexample
from lure.classes import Diagonal
from lure.files import parse_system
from lure.nonlinearities import ExpressionNonlinearity, PiecewiseLinear, Quantiser
from lure.plants.family import PlantFamily

OPEN = SimpleNamespace(verdict=Verdict.INCONCLUSIVE)
UNIT = Saturation(gain=1, limit=1)
UNIT_CLASS = NonlinearityClass.slope_restricted(0, 1)
UNSTABLE = RationalPlant([1], [1, -1])  # gains in (1, inf)


@pytest.mark.parametrize(
    ("window", "dt", "said"),
    [(None, None, 0), (1, 1, 1), (LONGEST, 1, LONGEST)]
    + [(one, 1, "give a number of samples from 1 to") for one in (True, 0, LONGEST + 1, 2.0, "2")]
    + [(2, None, "in continuous time")],
)
def test_a_window_is_a_number_of_samples(window, dt, said):
    asked = SimpleNamespace(plant=SimpleNamespace(dt=dt))
    if isinstance(said, int):
        assert _window(window, asked) == said
    else:
        with pytest.raises(InputError, match=said):
            _window(window, asked)


def test_energy_is_refused_of_play_in_any_channel():
    plant = [[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]
    with pytest.raises(InputError, match="energy and peak are bounded for sectors, slopes and norm-bounded"):
        energy_bounds(plant, [Sector(0, 1), NonlinearityClass.hysteretic("play")], {"Bw": [[1], [0]], "Cz": [[1, 0]]})


# phi = 6 sigma is not in [0, 5]: beside another counterexample it is named of the classes that hold it
@pytest.mark.parametrize(("upper", "named"), [(5, False), (7, True)])
def test_a_second_counterexample_is_named_where_the_class_holds_it(upper, named):
    beside = max_sector(RationalPlant([1], [1, 3, 2, 0])).refutation
    first = {**beside.certificate, "laws": {**PLAIN, "sector": ["0", "5"]}}
    asked = Problem.about(RationalPlant([1], [1, 3, 2, 0]), NonlinearityClass(sector=Sector(0, upper)))
    found = _refuted(asked, SimpleNamespace(certificate=first), beside)
    assert (found.verdict, "destabilises the loop too" in found.sentence) == (Verdict.REFUTED, named)


# of phi with a lower end inside (1, inf), or of none, a class from a stable gain on; a saturation falls to gains of 0
@pytest.mark.parametrize(
    ("nonlinearity", "said"),
    [
        (None, "take classes whose lower end is a stable linear gain, inside one of (1, inf)"),
        (
            parse_system(
                '[plant]\ntransfer = "1/(s-1)"\n[nonlinearity]\nkind = "expression"\n'
                'expression = "2*sigma + tanh(sigma)"\nsector = [2, 3]\n',
                name="",
                source="",
            ).nonlinearity,
            "take classes whose",
        ),
        (Saturation(gain=2, limit=1), "no class whose lower end is a stable gain, inside (1, inf), contains"),
    ],
)
def test_a_lower_end_is_advised_where_phi_can_have_it(nonlinearity, said):
    problem = SimpleNamespace(given=None, nonlinearity=nonlinearity)
    rows = [SimpleNamespace(verdict=Verdict.INCONCLUSIVE)] * 2
    assert advice.hints(problem, rows, gain_intervals(UNSTABLE), OPEN)[0].startswith(said)
    rows[1] = SimpleNamespace(verdict=Verdict.PROVED)
    assert advice.hints(problem, rows, gain_intervals(UNSTABLE), OPEN) == ()
    assert advice.hints(problem, rows[:1], (), OPEN) == ()


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("2", [2]),
        ("0.5, 1/3", [F(1, 2), F(1, 3)]),
        ("1:4:3", [1, 2, 4]),
        ("1:2:2", [1, 2]),
        ("0.1:10:3", [F(1, 10), 1, 10]),
    ],
)
def test_frequencies_are_a_list_or_equal_ratios(text, found):
    assert performance._frequencies(text) == found
    assert len(performance._frequencies("1:2")) == 25
    assert len(performance._frequencies("1:2:1000")) == 1000


@pytest.mark.parametrize(
    "text", ["", "a", "1,", "1/0", "0:1", "2:1", "1:1", "1:2:1", "1:2:1001", "1:2:3:4", "1:2:x", "1/0:2"]
)
def test_what_are_no_frequencies_is_refused(text):
    with pytest.raises(InputError, match=r"--omega is .*; give"):
        performance._frequencies(text)


@pytest.mark.parametrize(("share", "found"), [(F(1, 4), 2), (F(-1, 8), F(1, 2)), (1, 4), (-1, 0)])
def test_a_search_for_a_plant_stays_in_the_box(share, found):
    assert _moved((7, F(1), 7), 1, ((0, 9), (0, 4), (0, 9)), share) == (7, found, 7)


def largest(**more):
    """An answer about one channel, up to 4, before a linear limit of 8."""
    found = {"classes": None, "verdict": Verdict.PROVED, "witness": None, "refuted_at": None, "lower": F(0)}
    found |= {"hurwitz": Bracket(8, 8), "multiplier": "1", "theta": None, "unfinished": "", "reason": ""}
    found |= {"largest": Bracket(4, 4), "about": "phi with slope in", "search_limited": False, "criterion": "popov"}
    found |= {"evidence": Evidence.CERTIFIED, "conclusion": SimpleNamespace(headline="0 attracts."), "closed": False}
    return SimpleNamespace(**found | more)


FIRST, LAST = "0 attracts, by popov (certified).", "Linear gains are stable up to 8."
OPEN_ = {"verdict": Verdict.INCONCLUSIVE, "largest": Bracket(0, 0)}


@pytest.mark.parametrize(
    ("more", "stable", "said"),
    [
        ({}, None, [FIRST, LAST]),
        ({"multiplier": ""}, None, [FIRST, LAST]),
        ({"search_limited": True}, None, ["0 attracts, the largest k tried, by popov (certified).", LAST]),
        (
            {"multiplier": "1 + theta s", "theta": 2 / 3},
            None,
            [FIRST, LAST, "Multiplier: 1 + theta s, theta = 0.6666667."],
        ),
        ({"multiplier": "1 + theta s"}, None, [FIRST, LAST, "Multiplier: 1 + theta s."]),
        ({"multiplier": "1 + z^-1", "theta": 0.5}, None, [FIRST, LAST, "Multiplier: 1 + z^-1."]),
        ({"multiplier": "1", "unfinished": "So far."}, None, [FIRST, LAST, "So far."]),
        ({"reason": "why"}, (), [FIRST, "No linear gain makes the loop stable."]),
        (
            {**OPEN_, "reason": "why", "multiplier": "x"},
            None,
            ["Nothing is proved for phi with slope in [0, k].", LAST, "Reason: why."],
        ),
        (
            {**OPEN_, "hurwitz": Bracket(0, 0)},
            None,
            [
                "Nothing is proved for phi with slope in [0, k].",
                "Linear gains at the lower end of the class are not stable.",
            ],
        ),
    ],
)
def test_a_largest_class_is_told_in_lines(more, stable, said):
    assert lines(largest(**more), stable=stable) == said


def reaching(end, question="sector", **more):
    """A row of which the classes up to an end are proved."""
    row = {"verdict": Verdict.PROVED, "largest": Bracket(end, end), "lower": 0, "time_varying": False, "odd": False}
    row |= {"criterion": "popov", "proviso": "", "question": question, "proved_up_to": f"{end:g}"}
    return SimpleNamespace(**row | more)


# what serves the class and reaches farthest is named, if it reaches beyond the lower end and not as far as was asked;
# else the first row of a stronger property that reaches far enough
@pytest.mark.parametrize(
    ("low", "high", "ends", "said"),
    [
        (0, 9, (3, 4, 5, 6), ["an upper bound of 4 instead of 9 would be proved"]),
        (4, 9, (3, 4, 5, 6), []),
        (5, 9, (3, 4, 5, 6), []),
        (0, 4, (3, 4, 5, 6), ["slope bounds of phi would be enough (popov reaches 5)"]),
        (0, 5.5, (3, 4, 5, 6), ["an upper bound of 4 instead", "slope bounds and oddness of phi would be enough"]),
        (0, 5.5, (7, 4, 5, 6), ["slope bounds and oddness of phi would be enough"]),
        (-1, 9, (3, 4, 5, 6), []),
        (0, inf, (3, 4, 5, inf), ["an upper bound of 4 instead of inf would be proved"]),
    ],
)
def test_what_would_be_proved_is_advised(low, high, ends, said):
    rows = [reaching(end) for end in ends[:2]] + [reaching(end, "slope") for end in ends[2:]]
    rows[0].time_varying = rows[3].odd = True
    problem = SimpleNamespace(given=NonlinearityClass(sector=Sector(low, high)), nonlinearity=None)
    found = advice.hints(problem, rows, (), OPEN)
    assert len(found) == len(said)
    assert all(map(str.startswith, found, said))
    assert advice.hints(problem, rows, (), SimpleNamespace(verdict=Verdict.PROVED)) == ()


# a dead zone comes to the slope 1, so that no smaller bound is one of it, and a proof up to 0.99 is about others
def test_a_bound_that_the_nonlinearity_exceeds_is_said_to_be_one():
    rows, given = [reaching(0.99)] * 4, NonlinearityClass(sector=Sector(0, 1))
    (found,) = advice.hints(SimpleNamespace(given=given, nonlinearity=DeadZone(width=1, gain=1)), rows, (), OPEN)
    assert found.endswith("instead of 1 would be proved, in which dead zone of |sigma| <= 1, then slope 1 does not lie")
    (found,) = advice.hints(SimpleNamespace(given=given, nonlinearity=Saturation(gain=F(1, 2))), rows, (), OPEN)
    assert found.endswith("would be proved")


def test_slopes_that_begin_below_are_served_by_a_row_of_slopes_that_does_too():
    both = NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(-1, 2))
    assert advice.serves(reaching(4), both)
    assert not advice.serves(reaching(4, "slope"), both)
    assert advice.serves(reaching(4, "slope", lower=-1), both)
    assert not advice.serves(reaching(4, lower=1), both)


@pytest.mark.parametrize(
    ("verdict", "factor", "others", "said"),
    [
        (Verdict.INCONCLUSIVE, 0.5, (0.9,), ["upper bounds 0.5 times those given would be proved"]),
        (Verdict.INCONCLUSIVE, 0, (1, 2), ["'sector' in every channel would be enough (popov reaches the factor 1)"]),
        (Verdict.INCONCLUSIVE, 0, (0.9, 2), ["'sector' in every channel would be enough (popov reaches the factor 2)"]),
        (Verdict.PROVED, 0.5, (1, 2), []),
    ],
)
def test_of_several_channels_one_kind_that_is_enough_is_advised(verdict, factor, others, said):
    classes = Diagonal((NonlinearityClass(sector=Sector(0, 1)),) * 2)
    own, *rows = (reaching(end, proved_text=f"{end:g}", classes=classes) for end in (factor, *others))
    rows.append(reaching(3, classes=None))
    problem, conclusion = SimpleNamespace(classes=classes), SimpleNamespace(verdict=verdict)
    assert list(channel_hints(problem, own, rows, conclusion)) == said
    assert channel_hints(problem, None, rows[:0], conclusion) == ()
    assert channel_hints(problem, replace_verdict(own), rows[:0], conclusion) == ()


def replace_verdict(row):
    return SimpleNamespace(**vars(row) | {"verdict": Verdict.INCONCLUSIVE})


# sigma + D phi: with D = 1 quotients 1 + q of slopes q, of both signs where a slope is below -1; with -1 it has one
# value on a piece.  sin has slopes from -1 to 1
@pytest.mark.parametrize(
    ("nonlinearity", "direct", "found"),
    [
        (PiecewiseLinear([(0, 0), (1, 2), (2, F(3, 2))], left_slope=0, right_slope=0), "1", False),
        (PiecewiseLinear([(0, 0), (1, 2), (2, 1)], left_slope=0, right_slope=0), "1", True),
        (PiecewiseLinear([(0, 0), (1, 2), (2, F(3, 2))], left_slope=0, right_slope=0), "3", True),
        (PiecewiseLinear([(0, 0), (1, 2), (2, 1)], left_slope=0, right_slope=0), "-1/3", False),
        (PiecewiseLinear([(0, 0), (1, 2), (2, 1)], left_slope=0, right_slope=0), "-1/2", True),
        (ExpressionNonlinearity("sin(sigma)"), "1/2", False),
        (ExpressionNonlinearity("sin(sigma)"), "-1/2", False),
        (ExpressionNonlinearity("sin(sigma)"), "2", True),
        (ExpressionNonlinearity("sin(sigma)"), "-2", True),
    ],
)
def test_a_value_is_taken_twice_where_quotients_have_both_signs(nonlinearity, direct, found):
    system = {"kind": "transfer", "numerator": [direct, "1"], "denominator": ["1", "1"]}
    assert _takes_a_value_twice(nonlinearity, SimpleNamespace(certificate={"system": system})) is found


def test_forms_are_about_the_channels_of_each_kind():
    own = NonlinearityClass
    each = own.relu(), own(sector=Sector(0, 1)), own.delayed(1), own.slope_restricted(0, 1, odd=True)
    classes = Diagonal((*each, own.slope_restricted(0, 2), own.slope_restricted(0, 2)), repeated=(1, 1, 1, 1, 2))
    found = groups_of(SimpleNamespace(classes=classes))
    assert [tuple(one)[:2] for one in found] == [
        *[("relu", (0,)), ("operator", (2,)), ("sector", (1,)), ("odd", (3,)), ("monotone", (4, 5))]
    ]


# Bw and Cz are about states, which a transfer function does not name; what goes through it is not
@pytest.mark.parametrize(
    ("performance", "refused"),
    [
        ({"Dsigmaw": [[1]], "Dzmu": [[1]]}, False),
        ({"Bw": [[1]], "Dzmu": [[1]]}, True),
        ({"Dsigmaw": [[1]], "Cz": [[1]]}, True),
    ],
)
def test_an_input_of_states_is_refused_of_a_transfer_function(performance, refused):
    plant, matrices = as_plant("1/(s+1)"), as_plant(([[-1]], [[1]], [[1]], [[0]]))
    assert gain_problem(matrices, [Sector(0, 1)], performance)[1].inputs == 1
    if refused:
        with pytest.raises(InputError, match="are about states, and the plant is given without"):
            gain_problem(plant, [Sector(0, 1)], performance)
    else:
        assert gain_problem(plant, [Sector(0, 1)], performance)[1].inputs == 1


def criterion_result(verdict, **more):
    one = NonlinearityClass(sector=Sector(0, 3))
    made = {"criterion": "popov", "nonlinearity_class": one, "evidence": Evidence.COMPUTED, "largest": Bracket(2, 2)}
    return CriterionResult(verdict=verdict, theorem="Popov", reason="Why.", **made | more)


# evidence is of a verdict or a margin; without both there is none to speak of
@pytest.mark.parametrize(
    ("found", "said"),
    [
        (criterion_result(Verdict.INCONCLUSIVE), "popov: INCONCLUSIVE, largest k 2"),
        (criterion_result(Verdict.INCONCLUSIVE, margin=Bracket(-1, -1)), "popov: INCONCLUSIVE (computed), largest k 2"),
        (criterion_result(Verdict.PROVED), "popov: PROVED (computed), largest k 2"),
    ],
)
def test_a_criterion_says_its_evidence_where_it_has_some(found, said):
    assert str(found).startswith(said)
    assert str(found).endswith(". Why.")
    assert found.class_words == str(found.nonlinearity_class)  # of no certificate
    proved = replace(found, verdict=Verdict.PROVED, shown=shown())
    assert proved.class_words == "phi, time-invariant, in the sector [0, 2]"  # of the certificate
    several = Diagonal((NonlinearityClass(sector=Sector(0, 1)),) * 2)
    assert replace(found, classes=several).class_words == str(several)


# with the gains 0 in the classes a proof says that all poles are stable; of classes that begin above they are counted
@pytest.mark.parametrize(
    ("low", "critical", "said"),
    [(0, False, "stable"), (0, True, "critical"), (1, False, "unstable"), (1, True, "unstable")],
)
def test_a_proof_says_nothing_of_poles_where_0_is_no_gain_of_the_classes(low, critical, said):
    asked = channel_problem(([[1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))), [Sector(low, 2)] * 2)
    assert table._channel_case(asked, [reaching(2, critical=critical)]) == said
    assert table._channel_case(asked, [reaching(2, critical=critical, verdict=Verdict.INCONCLUSIVE)]) == "unstable"


def test_classes_of_a_steady_response_are_listed_or_one():
    one, plant = NonlinearityClass.slope_restricted(0, 1), ([1], [1, 1])
    for given in (one, [one], Diagonal((one,))):
        assert steady._posed(plant, given, {"amplitude": 1, "omega": 1}, None).classes.classes == (one,)


# each parameter moves in its own way; what is rounded is about, and gains that change are counted beyond the second
@pytest.mark.parametrize(
    ("at", "rates", "gains", "said"),
    [
        (
            [["1", "5"], ["2", "5"]],
            ["inf", "0"],
            [["1"], ["1"]],
            "a jumping to and fro between 1 and 2, b = 5 and the gain 1",
        ),
        (
            [["1", "5"], ["2", "6"]],
            ["inf", "1"],
            [["1", "2"], ["1", "2"]],
            "a jumping to and fro between 1 and 2, b going to and fro between 5 and 6 and the gains 1, 2",
        ),
        (
            [["1", "5"], ["1/3", "5"]],
            ["2", "0"],
            [["1"], ["1/3"]],
            "a going to and fro between about 0.33333 and 1, b = 5 and gains that jump between about (1) and (0.33333) "
            "over and over",
        ),
        (
            [["1", "5"]] * 3,
            [],
            [["0"], ["1"], ["2"]],
            "a = 1, b = 5 and gains that jump between (0) and (1) and 1 more over and over",
        ),
    ],
)
def test_parameters_that_move_are_said_one_by_one(at, rates, gains, said):
    system = {"kind": "family", "parameters": [["a", "0", "2"], ["b", "5", "6"]]} | ({"rates": rates} if rates else {})
    member = shown("", system=system, proof={"method": "members", "at": at, "gains": gains})
    assert counterexample(member) == f"parameters with {said}"


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ({"proved_text": "0.5", "refuted_at": None}, "what is proved ends at 0.5 times the upper bounds"),
        ({"proved_text": "", "refuted_at": None}, "why"),
        ({"proved_text": "", "refuted_at": 2, "refuted_text": "2"}, "why, and the smallest factor refuted is 2"),
    ],
)
def test_why_the_largest_factor_is_below_1(row, said):
    with pytest.raises(AssumptionError, match=f"^{said}$"):
        _ends_before(SimpleNamespace(stopped=None, reason="why", **row))
    with pytest.raises(TimeoutError):
        _ends_before(SimpleNamespace(stopped="time", reason="why", **row))


def test_the_worst_plant_of_a_box_is_inside_it_or_at_its_end():
    family = SimpleNamespace(box=((F(0), F(1)), (F(2), F(4))), middle=(F(1, 2), F(3)), at=lambda point: point)
    family.corners = iter([(F(a), F(b)) for a in (0, 1) for b in (2, 4)])
    (a, b), found = least(family, lambda one: float((one[0] - F(3, 10)) ** 2 - one[1]))
    assert b == 4
    assert abs(a - F(3, 10)) < F(1, 100)
    assert found == float((a - F(3, 10)) ** 2 - 4)


def test_what_has_no_margins_is_refused():
    family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)})
    with pytest.raises(InputError, match="has no lower bound; give one"):
        tolerances(family, NonlinearityClass(sector=Sector(-inf, 1)))
    with pytest.raises(InputError, match="parameters"):
        tolerances(UNSTABLE, Sector(0, 1))


# two lags: the map is of two different functions with upper bounds above 0
def test_a_map_is_of_two_upper_bounds_that_grow():
    plant = [[-1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))
    below = [Sector(-2, -1), Sector(0, 1)]
    for given in (below, [NonlinearityClass.relu()] * 2):
        assert stability_map(channel_problem(plant, given)) is None
    assert stability_map(channel_problem(plant, Diagonal((UNIT_CLASS,) * 2, repeated=True))) is None


# x' = -x in so many digits that matrices are the shorter description, for criteria that take matrices
@pytest.mark.parametrize(("criterion", "kind"), [("best", StateSpace), ("circle", StateSpace), ("park", RationalPlant)])
def test_matrices_are_taken_by_criteria_for_matrices(criterion, kind, monkeypatch):
    monkeypatch.setattr(problem, "LONG", 1)
    plant = as_plant(([[-1, 1], [0, -2]], [[0], [1]], [[1, 0]], [[0]]))
    assert isinstance(problem.posed(plant, UNIT_CLASS, criterion=criterion, finite=True).plant, kind)


# a function that jumps has no slopes, and one that is shown not to be odd stays so; a class alone may have both
@pytest.mark.parametrize(
    ("nonlinearity", "slopes", "both"),
    [
        (None, True, True),
        (Saturation(gain=2, limit=1), True, True),
        (Quantiser(step=1), False, False),
        (PiecewiseLinear([(0, 0), (1, 1)], left_slope=0, right_slope=0), True, False),
    ],
)
def test_advice_is_of_a_property_that_phi_can_have(nonlinearity, slopes, both):
    names = ("time-invariance", "slope bounds", "slope bounds and oddness")
    assert [advice._possible(name, nonlinearity) for name in names] == [True, slopes, both]


def test_constant_gains_are_linear_and_do_not_change():
    own = NonlinearityClass
    classes = (own.constant_gain(0, 1), own(sector=Sector(0, 1)), own.constant_gain(0, 2), own.constant_gain(0, 2))
    asked = SimpleNamespace(classes=Diagonal(classes, repeated=(1, 1, 2)))
    assert constant_gains_of(asked) == [range(1), range(2, 4)]


# of a plant with 3 inputs and outputs, 1 or 2 classes leave 2 or 1 for w and z; 3 leave none
@pytest.mark.parametrize("m", [1, 2, 3])
def test_the_last_channels_are_those_beyond_the_classes(m):
    plant = as_plant((-np.eye(3), np.eye(3), np.eye(3), np.zeros((3, 3))))
    rest, stated = _last_channels(plant, m)
    assert (rest.inputs, None if stated is None else (stated.inputs, stated.outputs)) == {
        1: (1, (2, 2)),
        2: (2, (1, 1)),
        3: (3, None),
    }[m]


def test_a_question_keeps_what_was_asked():
    assert Problem.about(UNSTABLE, None).lower == 0
    asked = [Problem.about(UNSTABLE, UNIT_CLASS, nonlinearity=one) for one in (None, UNIT, Saturation(gain=1, limit=2))]
    several = [channel_problem(([1], [1, 1]), [one]) for one in (UNIT, Saturation(gain=1, limit=2))]
    assert len({one.text for one in (*asked, *several)}) == 5
    told = table.class_dict(NonlinearityClass.constant_gain(0, 1)), table.class_dict(NonlinearityClass.relu())
    assert [(one.get("linear"), one.get("relu")) for one in told] == [(True, None), (None, True)]


def test_a_state_has_the_size_of_the_set():
    curve = AttractedSet(kind="curve", volume=1, proof=shown(), points=((0, 0), (2, 0), (0, 2)))
    assert curve.contains((F(1, 2), F(1, 2)))
    for state in ((1,), (1, 2, 3)):
        with pytest.raises(InputError, match="and the set has 2"):
            curve.contains(state)


class Saying:
    """A function that says its sector, and what else it is given."""

    sector = Sector(0, 2)

    def __init__(self, **said):
        vars(self).update(said)

    def __call__(self, sigma):
        """Twice tanh."""
        return 2 * np.tanh(sigma)


SECTOR = "if phi lies in the sector"


# what nothing shows is said to be declared; that phi is Lipschitz is named where slopes do not imply it
@pytest.mark.parametrize(
    ("said", "laws", "words"),
    [
        ({}, {}, f"{SECTOR} you declare and is locally Lipschitz, of which nothing is declared"),
        ({}, {"slope": ["0", "2"]}, f"{SECTOR} and has the slopes you declare"),
        ({}, {"regularity": "any"}, f"{SECTOR} you declare"),
        ({"locally_lipschitz": True}, {}, f"{SECTOR} and is as regular as you declare"),
        (
            {"locally_lipschitz": True},
            {"slope": ["0", "2"], "odd": True},
            f"{SECTOR} and has the slopes and is odd as you declare",
        ),
        ({"locally_lipschitz": True}, {"regularity": "any"}, f"{SECTOR} you declare"),
        ({"locally_lipschitz": False}, {"regularity": "any"}, f"{SECTOR} you declare"),
        ({"locally_lipschitz": False}, {}, "Saying is not known to be locally Lipschitz"),
    ],
)
def test_what_is_declared_of_a_function_is_said(said, laws, words):
    standing = "declared" if words.startswith("if") else ""
    assert _member(Saying(**said), PLAIN | laws) == (standing, words)


DECLARED = "lies in the sector you declare and is locally Lipschitz, of which nothing is declared"


# two lags apart: of each channel it is said what nothing shows, and of none where all is checked
@pytest.mark.parametrize(
    ("known", "told", "membership"),
    [
        ([UNIT, UNIT], "", "checked"),
        ([Saying(), UNIT], f"phi_1 {DECLARED}", "declared"),
        ([Saying(), Saying()], f"phi_1 {DECLARED} and phi_2 {DECLARED}", "declared"),
    ],
)
def test_what_is_declared_of_each_channel_is_said(known, told, membership):
    asked = channel_problem(([[-1, 0], [0, -1]], np.eye(2), np.eye(2), np.zeros((2, 2))), known)
    proofs = (proved_whole(asked, one) for one in criteria_for(asked))
    found = conclusion_of(asked, next(filter(None, proofs)))
    assert (found.membership, found.assumed) == (membership, (told,) if told else ())
    assert found.headline.endswith(f", if {told}." if told else "phi_2 = saturation min(max(sigma, -1), 1).")


BESIDE = '[plant]\ntransfer = "1/(s+1)"\n[nonlinearity]\nkind = "tanh"\ngain = 2\nscale = 1\n[class]\n{}\n'


# slopes that are stated stand; with a sector alone nothing is known of differences, and phi's own slopes do
@pytest.mark.parametrize(("stated", "slope"), [("slope = [0, 3]", (0, 3)), ("sector = [0, 3]", (0, 2))])
def test_a_steady_response_uses_the_slopes_that_are_stated(stated, slope):
    found = steady._posed(
        parse_system(BESIDE.format(stated), name="", source=""), None, {"amplitude": 1, "omega": 1}, None
    )
    (one,) = found.classes.classes
    assert (None if one.slope is None else (one.slope.lower, one.slope.upper)) == slope

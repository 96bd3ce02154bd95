"""What a gain, an energy and a problem are asked of and told as, one decision at a time."""

from dataclasses import replace
from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from worded import PLAIN

from lure import InputError, NonlinearityClass, Sector, SlopeBounds, as_plant
from lure.analysis.certificates.checker import UNLIMITED
from lure.analysis.questions import energy, gain
from lure.analysis.questions.energy import EnergyBounds, energy_bounds
from lure.analysis.questions.gain import GainBound, gain_problem, l2_gain
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.classes import Diagonal
from lure.files import parse_system
from lure.files.builtin import builtin_loop
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.family import PlantFamily
from lure.plants.performance import Performance

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
OWN = NonlinearityClass
LAG, SEEN = ([[-1]], [[1]], [[1]], [[0]]), {"Bw": [[1]], "Cz": [[1]]}
UNIT = Diagonal((OWN(sector=Sector(0, 1)),))


def factors(verdict=PROVED, **more):
    found = {"verdict": verdict, "evidence": Evidence.CERTIFIED, "criterion": "circle", "reason": "why"}
    found |= {"stopped": None, "witness": None, "proviso": "", "proof": None, "refutation": None, "unfinished": ""}
    return SimpleNamespace(**found | more)


def bound(low=0.0, high=2.0, **more):
    given = {"gain": Bracket(low, high), "classes": UNIT, "performance": Performance.given(SEEN), "plant": None}
    return GainBound(**given | {"factors": factors()} | more)


MEMBER = SimpleNamespace(description="phi = 2 sigma, gives the loop a larger L2 gain")
LISTED = SimpleNamespace(description="the gains 1, 2 give the loop a larger L2 gain")
GIVEN = "phi in the sector [0, 1]"


@pytest.mark.parametrize(
    ("one", "verdict", "said"),
    [
        (bound(), PROVED, f"The L2 gain from w to z is at most 2 for {GIVEN} (circle, certified)."),
        (
            bound(at_input=True, incremental=True),
            PROVED,
            f"The incremental L2 gain from w, added to mu, to z = sigma is at most 2 for {GIVEN} (circle, certified).",
        ),
        (
            bound(1 / 3, 2 / 3, factors=factors(witness=MEMBER, proviso="for which x", unfinished="So far.")),
            PROVED,
            f"The L2 gain from w to z is at most 0.6666667 for {GIVEN}, for which x (circle, certified); a member "
            "has a gain above 0.3333333, with phi = 2 sigma. So far.",
        ),
        (
            bound(1.0, factors=factors(witness=LISTED)),
            PROVED,
            f"The L2 gain from w to z is at most 2 for {GIVEN} (circle, certified); a member has a gain above 1: the "
            "gains 1, 2.",
        ),
        (
            bound(0, inf, factors=factors(OPEN)),
            OPEN,
            f"No bound of the L2 gain from w to z is proved for {GIVEN} (why).",
        ),
        (
            bound(inf, inf, factors=factors(REFUTED, witness=MEMBER)),
            REFUTED,
            f"No L2 gain from w to z is finite for all members of the class ({GIVEN}): {MEMBER.description}.",
        ),
        (
            bound(0, inf, factors=factors(REFUTED, witness=MEMBER)),
            OPEN,
            f"No bound of the L2 gain from w to z is proved for {GIVEN} ({MEMBER.description}, and it is not shown "
            "that w moves what grows and z sees it: the gain may be finite, and no theorem here proves one of an "
            "unstable loop).",
        ),
    ],
)
def test_a_gain_is_told_from_both_sides(one, verdict, said):
    assert (one.verdict, str(one)) == (verdict, said)
    assert ("no bound" in one._repr_html_()) is (one.gain.high == inf)


@pytest.mark.parametrize(
    ("low", "high", "closed"),
    [(2, 2, True), (inf, inf, True), (1.999, 2, True), (1.997, 2, False), (3, inf, False), (1998, 2000, True)],
)
def test_a_gain_is_closed_within_a_thousandth(low, high, closed):
    assert bound(float(low), float(high)).closed is closed


# a stop comes near to its largest gain with a large width, a play with a small one, and to 0 the other way
@pytest.mark.parametrize(
    ("kind", "number", "wide"),
    [("stop", "1", "large"), ("stop", "0", "small"), ("play", "1", "small"), ("play", "0", "large")],
)
def test_no_gain_is_a_play_or_a_stop(kind, number, wide):
    laws = {"channels": [{}, {"memory": kind}, {"operator": "performance"}]}
    shown = SimpleNamespace(certificate={"laws": laws, "proof": {"gains": ["5", number, "1"]}})
    one = bound(1.0, factors=factors(refutation=shown, witness=LISTED))
    assert one._widths() == f"a {kind} of {wide} width"
    assert f"a gain above 1, near the gains 1, 2 (a {kind} of {wide} width)." in str(one)
    assert bound()._widths() == ""


# the channel from z to w has the norm unit/gamma: what is proved up to k ends the gain at 1/(unit k)
@pytest.mark.parametrize(
    ("answer", "found"),
    [
        ({"largest": Bracket(2, 2), "refuted_at": 4.0}, (0.25, 0.5)),
        ({"largest": Bracket(2, 2)}, (0, 0.5)),
        ({"largest": Bracket(0, 0)}, (0, inf)),
        ({"largest": Bracket(2, 2), "verdict": OPEN}, (0, inf)),
        ({"largest": Bracket(0, 0), "verdict": REFUTED, "refuted_at": 0.0, "endless": UNLIMITED}, (inf, inf)),
        ({"largest": Bracket(0, 0), "verdict": REFUTED, "refuted_at": 0.0, "endless": "else"}, (0, inf)),
    ],
)
def test_a_gain_is_the_inverse_of_what_is_shown_of_its_channel(answer, found, monkeypatch):
    shown = None if "endless" not in answer else SimpleNamespace(certificate={"conclusion": answer.pop("endless")})
    heard = []

    def ask(problem, **_ways):
        heard.append(problem)
        return factors(**{"refutation": shown, "refuted_at": None} | answer)

    monkeypatch.setattr(gain, "answer", ask)
    one = l2_gain(LAG, [Sector(0, 1)], SEEN, worst=True, incremental=False)
    unit = heard[0].classes.classes[-1].sector.upper
    scaled = one.gain.low * float(unit), one.gain.high * float(unit)
    assert scaled == tuple(map(pytest.approx, found))
    assert (heard[0].worst, heard[0].window, one.at_input, one.incremental) == (True, 0, False, False)
    sampled = as_plant(([[F(1, 2)]], [[1]], [[1]], [[0]]), dt=1)
    assert l2_gain(sampled, [SlopeBounds(0, 1)], window=3, incremental=True).at_input
    assert (heard[1].window, heard[1].worst) == (3, False)
    assert heard[1].classes.classes[0].time_varying


# the unit of the channel is a power of two, about the inverse of the gain of the loop at the lower bounds
@pytest.mark.parametrize(
    ("plant", "lower", "size", "unit"),
    [
        (([[-1]], [[4]], [[1]], [[0]]), [], 1, F(1, 4)),
        (([[-2]], [[1]], [[1]], [[0]]), [], 1, 2),
        (([[-1]], [[1]], [[1]], [[1]]), [], 1, F(1, 2)),
        (([[-1, 0], [0, -1]], np.eye(2), [[1, 0], [0, 8]], np.zeros((2, 2))), [0], 1, F(1, 8)),
        (([[-1, 0], [1, -1]], np.eye(2), [[1, 0], [0, 1]], np.zeros((2, 2))), [7], 1, 1),
        (([[-1]], [[1, 1]], [[1], [1]], np.zeros((2, 2))), [7], 1, 8),
        (([[0]], [[1]], [[1]], [[0]]), [], 1, F(1, 128)),
        (as_plant(([[F(1, 2)]], [[1]], [[1]], [[0]]), dt=1), [], 1, F(1, 2)),
        (([[-1, 0], [0, -1]], np.eye(2), np.eye(2), [[-1, 0], [0, 4]]), [1], 1, 1),
    ],
)
def test_the_unit_of_a_gain(plant, lower, size, unit):
    classes = Diagonal(tuple(OWN(sector=Sector(one, 9)) for one in lower)) if lower else SimpleNamespace(lower=())
    found = gain._unit(gain.channel_plants(plant), classes, size)
    assert found == unit or (unit == F(1, 128) and found < F(1, 64))


FINITE = "an L2 gain needs finite bounds"


def test_what_a_gain_is_asked_of():
    problem, stated, own, beside = gain_problem(LAG, Sector(0, 1), SEEN)
    assert (own, beside, stated.Bw) == (UNIT, False, ((1,),))
    assert [one.operator for one in problem.classes.classes] == ["", "performance"]
    assert gain_problem(LAG, Sector(0, 1), None)[3]
    several = gain_problem(LAG, UNIT, {"Bw": [[1, 2]], "Cz": [[1]]})[0].classes
    assert (len(several.blocks), len(several.classes)) == (2, 3)
    for given in (Sector(0, inf), [Sector(0, inf)], Diagonal((OWN(sector=Sector(-inf, 0)),))):
        with pytest.raises(InputError, match=FINITE):
            gain_problem(LAG, given, SEEN)
    loop = parse_system(
        "[plant]\nA = [[-1]]\nB = [[1]]\nC = [[1]]\n[class]\nsector = [0, 2]\n[performance]\nBw = [[3]]\nCz = [[1]]\n",
        name="",
        source="",
    )
    problem, stated, own, beside = gain_problem(loop, None, None)
    assert (own.upper, beside, stated.Bw) == ((2,), False, ((3,),))
    assert gain_problem(loop, [Sector(0, 1)], None)[2] == UNIT
    assert gain_problem(loop, None, SEEN)[1].Bw == ((1,),)
    assert gain_problem(loop, [Sector(0, 1)], SEEN, incremental=False)[0].classes.classes[0].time_varying is False
    for given in (LAG, builtin_loop("triple-lag").block):
        with pytest.raises(InputError, match="no class of nonlinearities is given"):
            gain_problem(given, None, SEEN)
    wider = as_plant(([[-1]], [[1, 3]], [[1], [5]], [[0, 0], [0, 7]]))
    open_ = replace(loop, block=wider, nonlinearity_class=None, performance=None)
    for given, classes in ((wider, UNIT), (wider, [Sector(0, 1)]), (open_, [Sector(0, 1)])):
        problem, stated, own, beside = gain_problem(given, classes, None)
        assert (stated.Bw, stated.Cz, stated.Dzw, own, beside) == (((3,),), ((5,),), ((7,),), UNIT, False)


# a state has names where matrices were given, and where there is none
@pytest.mark.parametrize(
    ("plant", "without"),
    [
        ("1/(s+1)", True),
        ("exp(-s)/(s+1)", True),
        ("2", False),
        (LAG, False),
        (PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)}), True),
        (parse_system('[plant]\ntransfer = "1/(s+1)"\n', name="", source=""), True),
    ],
)
def test_states_that_nobody_named(plant, without):
    assert gain._without_states(plant) is without


# differences see slopes alone, as gains that depend on time; what is linear stays
@pytest.mark.parametrize(
    ("one", "found"),
    [
        (OWN.slope_restricted(0, 2), OWN(sector=Sector(0, 2), time_varying=True)),
        (OWN.constant_gain(0, 2), OWN.constant_gain(0, 2)),
        (OWN.delayed(1), OWN.delayed(1)),
        (OWN.norm_bounded(1, dynamics="linear time-invariant"), None),
        (OWN(sector=Sector(0, 2)), "nothing is known"),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(0, 2)), "nothing is known"),
        (OWN(sector=Sector(0, 2), slope=SlopeBounds(-1, 2)), "nothing is known"),
        (OWN.relu(), "nothing is known"),
        (OWN.hysteretic("play"), "nothing is known"),
        (OWN.norm_bounded(1), "nothing is known"),
    ],
)
def test_what_differences_of_solutions_see(one, found):
    if isinstance(found, str):
        with pytest.raises(InputError, match=f"channel 2 is .*{found}"):
            gain._differences(Diagonal((OWN.slope_restricted(0, 2), one)))
    else:
        assert gain._differences(Diagonal((one, one), repeated=True)) == Diagonal((found or one,) * 2, repeated=True)


THREE = as_plant(([[-1]], [[2, 3, 4]], [[5], [6], [7]], [[0, 11, 12], [13, 0, 14], [15, 16, 0]]))


# of the last inputs and outputs w and z are made, each matrix in its place
def test_the_last_channels_are_w_and_z():
    own, stated = gain._last_channels(THREE, 1)
    assert (own.B, own.C, own.D) == (((2,),), ((5,),), ((0,),))
    assert (stated.Bw, stated.Cz, stated.Dzw) == (((3, 4),), ((6,), (7,)), ((0, 14), (16, 0)))
    assert (stated.Dzmu, stated.Dsigmaw) == (((13,), (15,)), ((11, 12),))
    own, stated = gain._last_channels(THREE, 2)
    assert (own.B, own.D, stated.Bw, stated.Dzmu) == (((2, 3),), ((0, 11), (13, 0)), ((4,),), ((15, 16),))
    for rows, m in (((2, 1), 1), ((1, 2), 1), ((2, 2), 2)):
        plant = as_plant(([[-1]], [[1] * rows[0]], [[1]] * rows[1], np.zeros(rows[::-1])))
        assert gain._last_channels(plant, m) == (plant, None)


def test_the_last_channels_of_a_plant_with_dead_time():
    late = as_plant([["exp(-s)/(s+1)", "1/(s+2)"], ["1/(s+3)", "exp(-2*s)/(s+4)"]])
    assert isinstance(late, DelayMatrix)
    own, stated = gain._last_channels(late, 1)
    assert (own.inputs, own.outputs, stated.inputs, stated.outputs) == (1, 1, 1, 1)
    for (delay, first), (same, last), (whole, rows) in zip(own.late, stated.late, late.late, strict=True):
        assert (delay, first, same, last) == (whole, rows[:1], whole, rows[1:])
    assert gain._last_channels(late, 2) == (late, None)


def test_w_is_added_to_mu_where_nothing_is_said():
    found = gain._at_the_input(([[-1]], [[2]], [[3]], [[4]]))
    assert (found.Bw, found.Cz, found.Dzw, found.Dzmu, found.Dsigmaw) == (((2,),), ((3,),), ((4,),), ((4,),), ((4,),))
    assert gain._at_the_input("exp(-s)/(s+1)").late == gain.late_plant("exp(-s)/(s+1)").late != ()


# energy ---------------------------------------------------------------------------------------------------------------


PROOF = SimpleNamespace(
    certificate={"laws": {"channels": [PLAIN, {**PLAIN, "operator": "performance"}], "repeated": False}}, assumed=""
)
TOLD = "For phi, time-invariant, in the sector [0, 2]: "


@pytest.mark.parametrize(
    ("initial", "peak", "reason", "said"),
    [
        (1 / 3, inf, "why", "without disturbance the energy of z is at most 0.3333334 |x(0)|^2 (certified) (why)."),
        (inf, 1 / 3, "", "from rest |z(t)|^2 is at most 0.3333334 times the energy of w (certified)."),
        (inf, inf, "why", "No quadratic function was found (why)."),
    ],
)
def test_energy_is_told(initial, peak, reason, said):
    found = EnergyBounds(initial=initial, peak=peak, reason=reason, proofs=(PROOF,))
    assert str(found) == (said if said.startswith("No") else TOLD + said)


# c > 1/(weight r^2) for P = 1; c > weight Cz Cz'
def test_the_numbers_of_energy_follow_from_P():
    asked = gain_problem(LAG, Sector(0, 1), {"Bw": [[1]], "Cz": [[3]]})[0]
    first = energy._constant(asked, [[F(1)]], F(2), F(1, 2), peak=False)
    assert 2 < first <= 2 * (1 + 2e-9)
    second = energy._constant(asked, [[F(1)]], F(2), F(1, 2), peak=True)
    assert 18 < second <= 18 * (1 + 2e-9)
    seen = gain_problem(LAG, Sector(0, 1), {"Bw": [[1, 0]], "Cz": [[3], [4]]})[0]
    assert energy._constant(seen, [[F(1)]], F(1), F(1), peak=True) == pytest.approx(25, rel=2e-9)
    assert energy._constant(asked, [[F(-1)]], F(2), F(1, 2), peak=False) is None
    two = gain_problem(([[-1, 0], [0, -1]], [[1], [1]], [[1, 1]], 0), Sector(0, 1), {"Bw": [[1], [0]], "Cz": [[1, 2]]})[
        0
    ]
    P = [[F(2), F(1)], [F(1), F(2)]]  # eigenvalues 1 and 3; P^-1 = [[2, -1], [-1, 2]]/3
    assert energy._constant(two, P, F(1), F(1), peak=False) == pytest.approx(3, rel=2e-9)
    assert energy._constant(two, P, F(1), F(1), peak=True) == pytest.approx(2, rel=2e-9)


def test_the_spread_of_a_quadratic_function_is_exact():
    shown = SimpleNamespace(certificate={"proof": {"P": [["2"], ["1", "2"]]}})
    assert 3 < energy._spread(shown) <= 3 * (1 + 3e-9)
    assert energy._spread(SimpleNamespace(certificate={"proof": {"P": [["1"], ["1", "1"]]}})) is None
    assert energy._root_above(F(2)) ** 2 >= 2
    assert [energy._root_above(F(one)) for one in (4, F(9, 4), 1)] == [2, 1.5, 1]
    assert energy._above([[F(2)]], F(1), 1)
    assert not energy._above([[F(2)]], F(2), 1)
    assert energy._above([[F(2)]], F(3), -1)


def test_a_bound_of_a_solution_is_told():
    proof = SimpleNamespace(certificate={"laws": PLAIN}, theorem="circle", assumed="")
    given = {"rate": F(1, 3), "constant": 4 / 3, "proof": proof}
    end = " for phi, time-invariant, in the sector [0, 2] (circle, certified)."
    assert str(energy.Overshoot(**given)) == f"|x(t)| <= 1.333334 |x(0)| exp(-0.3333333 t){end}"
    assert str(energy.Overshoot(**given, discrete=True)) == f"|x(t)| <= 1.333334 |x(0)| 0.3333334^t (t in samples){end}"


@pytest.mark.parametrize(
    ("plant", "classes", "rate", "said"),
    [
        ("1/(s+1)", [Sector(0, 1)], 0.5, "the number c is about states"),
        (LAG, None, 0.5, "no class of nonlinearities is given"),
        (as_plant(([[F(1, 2)]], [[1]], [[1]], [[0]]), dt=1), [Sector(0, F(1, 4))], 0, "give a factor above 0"),
    ],
)
def test_a_number_c_is_refused(plant, classes, rate, said):
    with pytest.raises(InputError, match=said):
        energy.overshoot(plant, classes, rate)


# the circle criterion shows no gain of 1/(s - 1), and a direct term has no peak
def test_energy_is_infinite_where_nothing_shows_it():
    found = energy_bounds(([[1]], [[1]], [[1]], [[0]]), [Sector(0, 3)], SEEN)
    assert (found.initial, found.peak, found.reason) == (inf, inf, "the circle criterion shows no gain")
    for plant, said in (("exp(-s)/(s+1)", "dead time"),):
        with pytest.raises(InputError, match=f"not bounded beside {said}"):
            energy_bounds(plant, [Sector(0, 1)], {"Dsigmaw": [[1]], "Dzmu": [[1]]})
    with pytest.raises(InputError, match="which are not given"):
        energy_bounds(LAG, [Sector(0, 1)])


# |z|^2 = z1^2 + z2^2 <= c with z = Cz x, x'P x <= weight: c > weight lambda_max(Cz P^-1 Cz') = 2, a double just above
def test_the_bound_of_a_peak_of_two_outputs_is_no_larger_than_it_has_to_be():
    one = [[F(1), F(0)], [F(0), F(1)]]
    plant, classes = SimpleNamespace(C=[[F(9), F(9)], *one]), SimpleNamespace(performance=(None, None))
    found = energy._constant(SimpleNamespace(plant=plant, classes=classes), one, F(2), F(1), peak=True)
    assert 2 < found < 2 * (1 + 1e-6)

"""What a steady response says, asks and refuses, one decision at a time, of findings that are made up."""

from fractions import Fraction as F
from functools import partial
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from lure import InputError, NonlinearityClass, Saturation, Sector, SlopeBounds, as_plant
from lure.analysis.questions import steady
from lure.analysis.questions.steady import SteadyPoint, SteadyResponse, steady_response
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.classes import Diagonal
from lure.files import parse_system
from lure.nonlinearities import ExpressionNonlinearity
from lure.plants.performance import Forcing

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
OWN = NonlinearityClass
SLOPE, SINE = OWN.slope_restricted(0, 1), {"amplitude": 1, "omega": 2}
LAG = ([1], [1, 1])
CERTIFIED, COMPUTED = Evidence.CERTIFIED, Evidence.COMPUTED


def point(**more):
    given = {"omega": 2.0, "amplitude": Bracket(1 / 3, 2 / 3), "sigma": (), "computed": 0.5, "error": 0.1}
    return SteadyPoint(**given | {"harmonics": 8, "residual": 0.0, "evidence": CERTIFIED} | more)


BAND = "the amplitude of z is between 0.3333333 and 0.6666667 (certified)"
ONE = "the amplitude of one steady response"


@pytest.mark.parametrize(
    ("more", "said", "attracts"),
    [
        ({"alone": True}, f"at 2 rad/s {BAND}", True),
        ({"alone": True, "omega": 0.0}, f"to the constant input {BAND}", True),
        ({"alone": True, "evidence": COMPUTED}, "at 2 rad/s the amplitude of z is about 0.5 (computed)", True),
        ({}, f"at 2 rad/s {ONE} is between 0.3333333 and 0.6666667 (certified)", True),
        (
            {"periods": 3, "evidence": COMPUTED, "multiplier": 0.5},
            f"at 2 rad/s {ONE}, repeated after 3 periods of the input, is about 0.5 (computed), attracts what is near",
            True,
        ),
        ({"multiplier": 2.0}, f"at 2 rad/s {ONE} is between 0.3333333 and 0.6666667 (certified), repels what", False),
        ({"multiplier": 1 - 1e-7}, "(certified), neither attracts nor repels what is near (computed)", False),
        ({"multiplier": 1 + 1e-7}, "(certified), neither attracts nor repels what is near (computed)", False),
        ({"multiplier": 1 - 1e-5}, "(certified), attracts what is near (computed)", True),
    ],
)
def test_a_response_is_told(more, said, attracts):
    found = point(**more)
    assert str(found).startswith(said) or str(found).endswith(said)
    assert found.attracts is attracts


SHOWN, AGAINST = SimpleNamespace(certificate={}, theorem="circle"), SimpleNamespace(certificate={})


def rate(verdict=PROVED, time="continuous", **more):
    found = {"verdict": verdict, "time": time, "rate": Bracket(1 / 3, 2 / 3), "proof": SHOWN, "refutation": AGAINST}
    found |= {"criterion": "circle", "witness": "with the gain 3", "stopped": None}
    return SimpleNamespace(**found | more)


def response(differences=None, **more):
    return SteadyResponse(classes=Diagonal((SLOPE,)), differences=differences, **more)


GIVEN = "phi with slope in [0, 1]"
NEVER = "the slopes of phi are not bounded, and no theorem here is about such differences"


# a constant gain refutes differences of the class, not of a phi that is given, nor where it may be no member
@pytest.mark.parametrize(
    ("found", "verdict", "ends", "criterion", "against"),
    [
        (response(), OPEN, (-inf, inf), "", None),
        (response(rate()), PROVED, (1 / 3, 2 / 3), "circle", AGAINST),
        (response(rate(REFUTED)), REFUTED, (1 / 3, 2 / 3), "", AGAINST),
        (response(rate(REFUTED), known=("tanh",)), OPEN, (1 / 3, inf), "", None),
        (response(rate(REFUTED), outside=True), OPEN, (1 / 3, inf), "", None),
        (response(rate(PROVED, "discrete"), known=("tanh",)), PROVED, (0, 2 / 3), "circle", None),
        (response(rate(PROVED, "discrete")), PROVED, (1 / 3, 2 / 3), "circle", AGAINST),
        (response(rate(OPEN), several=("two",)), REFUTED, (1 / 3, 2 / 3), "", AGAINST),
        (response(rate(OPEN)), OPEN, (1 / 3, 2 / 3), "", AGAINST),
    ],
)
def test_what_follows_from_differences(found, verdict, ends, criterion, against):
    assert (found.verdict, found.rate.low, found.rate.high) == (verdict, *ends)
    assert (found.criterion, found.refutation) == (criterion, against)
    assert found.evidence is (None if verdict is OPEN else CERTIFIED)
    assert (found.proof, found.gain) == (None if found.differences is None else SHOWN, inf)
    discrete = found.differences is not None and found.differences.time == "discrete"
    assert found._sides == ((against, SHOWN) if discrete else (found.proof, against))
    assert found.certificates["gain"] is None


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (response(), f"It is not decided whether one solution attracts all others for {GIVEN}: {NEVER}."),
        (
            response(rate(OPEN)),
            f"It is not decided whether one solution attracts all others for {GIVEN}: the circle criterion does not "
            "prove that differences of solutions decay.",
        ),
        (
            response(rate(REFUTED), known=("tanh",)),
            "It is not decided whether one solution attracts all others for tanh: differences decay for no class that "
            "contains the slopes: with the gain 3 a solution does not, and multipliers of Popov or Zames and Falb say "
            "nothing of differences.",
        ),
        (
            response(rate(REFUTED, refutation=None), known=("tanh",)),
            "It is not decided whether one solution attracts all others for tanh: the circle criterion does not prove "
            "that differences of solutions decay.",
        ),
        (
            response(rate(), known=("tanh", "tanh"), assumed="whose slopes are as declared"),
            "One solution is bounded on the whole time axis, and every other approaches it like exp(-0.3333333 t), "
            "whatever the bounded input, for tanh, whose slopes are as declared (circle, certified).",
        ),
        (
            response(rate(time="discrete"), open_reason="why"),
            "One solution is bounded on the whole time axis, and every other approaches it like 0.6666667^t (t "
            f"in samples), whatever the bounded input, for {GIVEN} (circle, certified). How large it is, is not known: "
            "why.",
        ),
        (
            response(rate(REFUTED)),
            f"Not every loop has a solution that attracts all others for {GIVEN}: with the gain 3 differences of "
            "solutions do not decay.",
        ),
        (response(several=("two",), response=(point(),)), f"No solution attracts all others for {GIVEN}: two."),
        (
            response(several=("two", "three", "four")),
            f"No solution attracts all others for {GIVEN}: two. 2 more frequencies have several.",
        ),
        (
            response(rate(OPEN), stopped="time", response=(point(alone=True),)),
            f" decay. At 2 rad/s {BAND}. The time allowed ended the search (LURE-I007): these are the best bounds so "
            "far.",
        ),
    ],
)
def test_a_steady_response_is_told(found, said):
    assert str(found) == said if said[0] != " " else str(found).endswith(said)


# of many responses the largest and the first are in the sentence
@pytest.mark.parametrize(("count", "named"), [(12, 12), (13, 2), (1, 1)])
def test_of_many_responses_two_are_named(count, named):
    rows = tuple(point(omega=1.0 + i, computed=float(i == 3), alone=True) for i in range(count))
    found = response(rate(), response=rows)
    assert str(found).count("rad/s") == named
    assert (f" {count - named} more responses are in --json alone." in str(found)) is (count > named)
    assert ("At 4 rad/s" in str(found), "At 5 rad/s" in str(found)) == (count > 1, count == 12)
    assert found.drawn is (count > 3)


def test_a_constant_response_is_not_drawn():
    assert not response(response=(point(omega=0.0),)).drawn
    assert not response(response=(point(computed=0.0),)).drawn
    assert response(response=(point(omega=0.0), point())).drawn


# what is asked --------------------------------------------------------------------------------------------------------


TEXT = '[plant]\ntransfer = "1/(s+1)"\n{}[forcing]\namplitude = 3\nomega = 4\n'


def loop(closed):
    return parse_system(TEXT.format(closed), name="", source="")


def test_what_a_system_says_is_asked_where_nothing_else_is():
    own = loop('[nonlinearity]\nkind = "tanh"\ngain = 2\nscale = 1\n')
    asked = steady._posed(own, None, None, None)
    assert (asked.forcing.omega, len(asked.known), asked.performance) == ((4,), 1, None)
    assert steady._posed(own, None, SINE, None).forcing.omega == (2,)
    assert steady._posed(own, SLOPE, None, None).known == ()
    assert steady._posed(own, SLOPE, None, None).classes == Diagonal((SLOPE,))
    with pytest.raises(InputError, match="no class of nonlinearities is given; give"):
        steady._posed(loop(""), None, None, None)
    given = steady._posed(LAG, "tanh(sigma)", SINE, {"Dsigmaw": [[1]], "Dzmu": [[1]]})
    assert (given.known[0].text, given.performance.inputs) == ("tanh(sigma)", 1)
    sampled = as_plant(([[F(1, 2)]], [[1]], [[1]], [[0]]), dt=1)
    assert steady._posed(sampled, SLOPE, None, None).H.dt == 1
    listed = steady._posed((-np.eye(2), np.eye(2), np.eye(2), 0 * np.eye(2)), [Saturation(), Saturation()], None, None)
    assert len(listed.classes.blocks) == 1  # one function twice
    several = steady._posed(
        (-np.eye(2), np.eye(2), np.eye(2), 0 * np.eye(2)), ["tanh(sigma)", Saturation()], None, None
    )
    assert len(several.classes.blocks) == 2


@pytest.mark.parametrize(
    ("plant", "given", "forcing", "said"),
    [
        (LAG, None, None, "give one with slope bounds, or a nonlinearity"),
        (LAG, ["tanh(sigma)"] * 2, None, "2 classes are given, and the plant has"),
        (([[-1]], [[1, 1]], [[1]], [[0, 0]]), ["tanh(sigma)"], None, "1 class is given, and the plant has"),
        (LAG, SLOPE, {"amplitude": [1, 1], "omega": 1}, "forcing has 2 entries, and w has 1"),
        (
            as_plant([["1/(s+1)", "0"], ["0", "1/(s+1)"]]),
            [SLOPE] * 2,
            {"amplitude": 1, "omega": 1},
            "forcing has 1 entry, and w has 2",
        ),
    ],
)
def test_what_does_not_fit_a_steady_response_is_refused(plant, given, forcing, said):
    with pytest.raises(InputError, match=said):
        steady._posed(plant, given, forcing, None)


@pytest.mark.parametrize(
    ("one", "narrow"),
    [
        (SLOPE, False),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 1)), True),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(0, 2)), True),
        (OWN(sector=Sector(0, 1)), False),
        (OWN.relu(), True),
        (OWN.constant_gain(0, 1), False),
    ],
)
def test_where_a_constant_gain_may_be_no_member(one, narrow):
    assert bool(steady._narrow(one)) is narrow


# gains between the slopes that vary; without finite ones nothing, for a class a refusal
@pytest.mark.parametrize(
    ("one", "found"),
    [
        (SLOPE, OWN(sector=Sector(0, 1), time_varying=True)),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 2)), OWN(sector=Sector(-1, 2), time_varying=True)),
        (OWN.constant_gain(0, 1), OWN.constant_gain(0, 1)),
        (OWN(sector=Sector(0, 1)), None),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(0, inf)), None),
        (OWN(sector=Sector(0, 1), slope=SlopeBounds(-inf, 1)), None),
        (OWN.hysteretic("play"), None),
        (OWN.norm_bounded(1), None),
    ],
)
def test_what_differences_of_two_solutions_see(one, found):
    for classes, where in ((Diagonal((one,)), "the class is"), (Diagonal((SLOPE, one)), "channel 2 is")):
        if found is None:
            assert steady._differences(classes, known=True) is None
            with pytest.raises(InputError, match=where):
                steady._differences(classes, known=False)
        else:
            assert steady._differences(classes, known=False).classes[-1] == found
    same = Diagonal((SLOPE, SLOPE), repeated=True)
    assert steady._differences(same, known=True).repeated == same.repeated


# frequencies ascending, each once, in discrete time as angles; without an amplitude the constant alone
@pytest.mark.parametrize(
    ("forcing", "dt", "found"),
    [
        ({"amplitude": 1, "omega": [2, 1, 2]}, None, [(0.5, 1), (1, 2)]),
        ({"amplitude": 1, "omega": [2]}, F(1, 4), [(1, F(1, 2))]),
        ({"constant": 3}, None, [(1, 0)]),
        ({"amplitude": 1}, None, [(F(1, 2), 7), (1, 9)]),
        ({"amplitude": 1}, F(2), [(F(1, 2), 7), (1, 9)]),
    ],
)
def test_the_inputs_are_one_for_each_frequency(forcing, dt, found):
    around = SimpleNamespace(frequencies=lambda: [F(7), F(9)])
    waves = list(steady._waves(around, Forcing.given(forcing), dt))
    assert [(done, wave.omega) for done, wave in waves] == found

    last = waves[-1][1]
    assert (last.constant, last.amplitude) == (((3,), (0,)) if "constant" in forcing else ((0,), (1,)))


def test_why_there_is_no_band_is_said_with_the_frequencies():
    assert steady._missing([]) == ""
    assert steady._missing([("why", "1"), ("else", "2")]) == "why at 1, 2 rad/s"
    assert steady._missing([("why", "1")] * 12).endswith(" 1 rad/s")
    assert steady._missing([("why", "1")] * 13) == "why at 13 frequencies"


def test_two_solutions_are_told():
    at = "to the input of 2 rad/s there is a steady response of amplitude 0.3333333 to 0.6666667"
    other = point(amplitude=Bracket(1 / 9, 2 / 9))
    assert steady._both(point(), other) == f"{at}, and another of 0.1111111 to 0.2222223 (certified)"
    assert steady._both(point(periods=3), None).startswith(f"{at} that repeats after 3 periods of it only, and so")


def test_a_gain_to_take_out_is_in_the_middle_of_the_slopes():
    assert steady._inside(Saturation(gain=3, limit=1)) == F(3, 2)
    assert steady._inside(ExpressionNonlinearity("sigma^3 + sigma/3")) == F(1, 3)


# a known phi whose differences decay has a band at each frequency; where they do not, several are looked for, in
# continuous time alone
@pytest.mark.parametrize(
    ("given", "verdict", "dt", "gain", "asked"),
    [
        ("tanh(sigma)", PROVED, None, 2.0, "_points"),
        ("tanh(sigma)", PROVED, None, inf, "no incremental gain is proved"),
        ("tanh(sigma)", OPEN, None, 2.0, "_tried"),
        ("sigma^3", PROVED, None, 2.0, "_tried"),
        ("tanh(sigma)", OPEN, 1, 2.0, ""),
        ("tanh(sigma)", PROVED, 1, 2.0, "_points"),
        (SLOPE, PROVED, None, 2.0, ""),
    ],
)
def test_how_a_response_is_looked_for(given, verdict, dt, gain, asked, monkeypatch):
    heard, told = [], []

    def points(*_given):
        heard.append("_points")
        yield from ((0.5, point(), "why"), (1.0, point(omega=3.0), ""))

    def tried(*_given):
        heard.append("_tried")
        yield 0.5, [point()], "two"
        yield 1.0, [point()], ""

    found = SimpleNamespace(gain=Bracket(0, gain), proof=None)
    monkeypatch.setattr(steady, "difference_rate", lambda *_args, **_ways: rate(verdict))
    monkeypatch.setattr(steady, "l2_gain", lambda *_args: found)
    monkeypatch.setattr(steady, "_points", points)
    monkeypatch.setattr(steady, "_tried", tried)
    plant = LAG if dt is None else as_plant(([[F(1, 2)]], [[1]], [[1]], [[0]]), dt=dt)
    ways = {"progress": lambda step, done: told.append((step, done))}
    one = steady_response(plant, given, {"amplitude": 1, "omega": 2}, **ways)
    assert heard == ([asked] if asked.startswith("_") else [])
    if asked == "_points":
        assert told == [("the incremental gain", 0.5), ("harmonic balance", 0.8), ("harmonic balance", 1)]
        assert (len(one.response), one.open_reason, one.several) == (2, "why at 2 rad/s", ())
    elif asked == "_tried":
        assert told == [("several solutions", 0.75), ("several solutions", 1)]
        assert (len(one.response), one.several) == (2, ("two",))
    else:
        assert (one.open_reason, one.response) == (asked, ())
    assert steady_response(plant, given).response == ()


# beside a resonance of the loop with the input other gains are taken out: the first by which it is far enough from one
@pytest.mark.parametrize(
    ("resonances", "direct", "used"),
    [
        ([1e-2], 0, 0),
        ([1e-4, 2e-4, 5e-3, 1e-2, 0.5], 0, 2),
        ([1e-4, 2e-4, 3e-4, 9e-4, 4e-4], 0, 3),
        ([1e-4], 1, 0),
        ([1e-10, 1e-10, 1e-10, 1e-10, 1e-10], 0, None),
        ([1e-10], 1, None),
    ],
)
def test_a_gain_at_which_the_loop_does_not_resonate_is_taken_out(resonances, direct, used, monkeypatch):
    made, solved, asked_at = [], [], []

    def read(i, base):
        return resonances[i] if base == 2 / 6 else 1.0

    def around(_H, _performance, _known, gains):
        one = SimpleNamespace(gains=gains, D=np.array([[direct]]), size=lambda omega: asked_at.append(omega) or 2.0)
        one.resonance = partial(read, len(made))
        made.append(one)
        return one

    monkeypatch.setattr(steady, "ForcedLoop", SimpleNamespace(around=around))
    monkeypatch.setattr(steady, "solutions", lambda loop, _wave: solved.append(loop) or ())
    asked = SimpleNamespace(H=None, performance=None, known=(Saturation(gain=2, limit=1),))
    asked.forcing = Forcing.given({"amplitude": 1, "constant": 0, "omega": [2]})
    found = list(steady._tried(asked))
    assert found == ([] if used is None else [(1, [], "")])
    assert solved == ([] if used is None else [made[used]])
    shares = [0, F(1, 20), F(1, 2), F(-1, 20), 2][: len(resonances)]
    assert [one.gains for one in made] == [[(1 + share,) * 2] for share in shares]
    assert asked_at == [pytest.approx(2 * 1.2937)] * (len(resonances) > 1)
    asked.forcing = Forcing.given({"constant": 1})
    assert list(steady._tried(asked)) == []


# two that exist: one that repeats after several periods alone shows it, else the first and one that is apart from it
@pytest.mark.parametrize(
    ("shown", "said"),
    [
        ([], ""),
        ([("a", False)], ""),
        ([("a", False), ("b", False)], "a b"),
        ([("a", False), ("a", False)], ""),
        ([("a", False), ("b", False), ("c", False)], "a c"),
        ([("a", False), ("b", True), ("c", False)], "b None"),
        ([None, ("a", False), ("b", False)], "a b"),
    ],
)
def test_of_two_responses_it_is_said_that_they_exist(shown, said, monkeypatch):
    def existing(_loop, found):
        if found is None:
            return None
        name, subharmonic = found
        return SimpleNamespace(name=name, subharmonic=subharmonic, apart=lambda other: other.name != name)

    loop = SimpleNamespace(D=np.array([[1.0]]), resonance=lambda _base: 1.0)
    monkeypatch.setattr(steady, "ForcedLoop", SimpleNamespace(around=lambda *_given: loop))
    monkeypatch.setattr(steady, "solutions", lambda *_given: shown)
    monkeypatch.setattr(steady, "existing", existing)
    monkeypatch.setattr(steady, "multiplier", lambda *_given: 0.5)
    monkeypatch.setattr(steady, "_row", lambda _loop, found, one, largest: None if found is None else found[0])
    monkeypatch.setattr(steady, "_both", lambda row, other: f"{row} {other}")
    asked = SimpleNamespace(H=None, performance=None, known=(Saturation(gain=2, limit=1),))
    asked.forcing = Forcing.given({"amplitude": 1, "omega": [2]})
    ((done, rows, told),) = steady._tried(asked)
    assert (done, told) == (1, said)
    assert rows == [None if one is None else one[0] for one in shown]


# what nothing shows is computed alone
@pytest.mark.parametrize("largest", [0.5, inf])
def test_one_solution_is_a_row(largest):
    wave = SimpleNamespace(omega=F(2), periods=3)
    found = SimpleNamespace(wave=wave, peak=0.5, count=8, missed=0.25)
    one = steady._row(SimpleNamespace(channels=2), found, None, largest)
    assert (one.evidence, one.amplitude, one.error, one.residual) == (COMPUTED, Bracket(0, inf), inf, 0.25)
    assert (one.sigma, one.multiplier, one.alone) == ((Bracket(0, inf),) * 2, None if largest == inf else 0.5, False)
    band = SimpleNamespace(z=Bracket(1, 2), sigma=(Bracket(3, 4),), error=0.125, residual=0.0625)
    shown = steady._row(SimpleNamespace(channels=1), found, band, alone=True)
    assert (shown.evidence, shown.amplitude, shown.error, shown.residual) == (CERTIFIED, band.z, 0.125, 0.0625)
    assert (shown.periods, shown.harmonics, shown.computed, shown.alone) == (3, 8, 0.5, True)

"""What the questions and commands about several channels, boxes and a named criterion decide, one at a time."""

from dataclasses import replace
from fractions import Fraction as F
from math import inf
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from worded import shown

from lure import InputError, NonlinearityClass, RationalPlant, Sector, SlopeBounds, as_plant
from lure.analysis.questions import certify as certifying
from lure.analysis.questions import channel_hypotheses as permitted
from lure.analysis.questions import channel_kinds as kinds
from lure.analysis.questions import channel_map as mapping
from lure.analysis.questions import worst_plants
from lure.analysis.questions.certify import ProofOptions, certify, text_of
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.classes import Diagonal
from lure.errors import AssumptionError
from lure.files.builtin import builtin_loop
from lure.plants.family import PlantFamily

OWN = NonlinearityClass
LAG = [[-1, 0], [0, -1]]


def about(*classes, repeated=False):
    """A question of which the classes alone are looked at."""
    return SimpleNamespace(classes=Diagonal(classes, repeated=repeated))


def two_lags(direct=((0, 0), (0, 0)), given=None, A=LAG, dt=None):
    given = [Sector(0, 1)] * 2 if given is None else given
    plant = (A, np.eye(2), np.eye(2), [list(row) for row in direct])
    return channel_problem(as_plant(plant, dt=dt), given)


# what a criterion is about is said where it is a model; a counterexample is no proof
def test_a_criterion_of_a_model_says_so():
    one = {"criterion": "popov", "nonlinearity_class": OWN(sector=Sector(0, 3)), "evidence": Evidence.COMPUTED}
    loop = CriterionResult(verdict=Verdict.INCONCLUSIVE, largest=Bracket(2, 2), theorem="Popov", reason="Why.", **one)
    scheme = replace(loop, model="scheme")
    assert "popov criterion</" in loop._repr_html_()
    assert "popov criterion for the N-cell scheme</" in scheme._repr_html_()
    assert "about the scheme, not about the rod" in scheme._repr_html_()
    assert "not about the rod" not in loop._repr_html_()
    assert str(scheme).startswith("popov, scheme, sector [0, 3]: INCONCLUSIVE, largest k 2")
    assert "model" not in loop.to_dict()
    assert (scheme.to_dict()["model"], scheme.to_dict()["name"]) == ("scheme", "popov")
    assert replace(loop, verdict=Verdict.REFUTED, shown=shown()).proof is None


# a key a line, those that the format orders first; what holds several entries has a line for each
def test_a_certificate_is_written_in_the_order_of_the_format():
    given = {"zeta": 1, "system": {"kind": "transfer", "time": "continuous"}, "multiplier": {"theta": "1"}, "format": 2}
    written = '{\n"format": 2,\n"system": {\n  "kind": "transfer",\n  "time": "continuous"\n},\n'
    assert text_of(given) == written + '"multiplier": {"theta": "1"},\n"zeta": 1\n}\n'
    assert text_of({"alpha": 1, "proof": {}}) == '{\n"proof": {},\n"alpha": 1\n}\n'


@pytest.mark.parametrize("seconds", [0, -1, inf])
def test_a_time_allowed_is_positive_and_finite(seconds):
    assert ProofOptions(seconds=0.5).seconds == 0.5
    for given, said in (({"seconds": seconds}, "Ways.seconds"), ({"method": "x"}, "method"), ({"numbers": "x"}, "num")):
        with pytest.raises(InputError, match=said):
            ProofOptions(**given)


# the question in full: classes in a list, a delay plant among them; one class; what the loop says of its own
@pytest.mark.parametrize(
    ("loop", "given", "several", "upper"),
    [
        ("exp(-s)/(s+1)", [Sector(0, 1)], True, 1),
        (([1], [1, 1]), Sector(0, 2), False, 2),
        (builtin_loop("dead-zone"), None, False, None),
        ("1/(s+1)", "tanh(sigma)", False, None),
        (builtin_loop("dead-zone"), Sector(0, 2), False, 2),
    ],
)
def test_what_certify_asks(loop, given, several, upper, monkeypatch):
    asked, heard = [], []

    def ask(problem, **ways):
        asked.append((problem, ways["seconds"], ways["numbers"]))
        if ways["progress"] is not None:
            ways["progress"]("a step", 0.5)
        return "the answer"

    monkeypatch.setattr(certifying, "answer", ask)
    assert certify(loop, given) == "the answer"
    ways = ProofOptions(criterion="circle", seconds=3, numbers="decimals as written")
    assert certify(loop, given, ways=ways, progress=heard.append) == "the answer"
    (first, *plain), (second, *more) = asked
    assert (first.criterion, plain) == ("best", [None, "rationals"])
    assert (second.criterion, more) == ("circle", [3, "decimals as written"])
    assert (first.kind, first.several, heard) == ("class", several, ["a step"])
    assert upper is None or first.classes.classes[0].sector.upper == upper
    assert upper is not None or first.nonlinearity is not None


def test_certify_asks_about_classes_that_are_given():
    with pytest.raises(InputError, match="no class of nonlinearities is given"):
        certify((LAG, np.eye(2), np.eye(2), np.zeros((2, 2))))


# the middle, the corners, four more of 65 along each side, the same ones every time; then steps of a quarter, which
# are a quarter of themselves where no neighbour is better, until they are below 2^-20
def test_the_plants_that_are_looked_at_are_the_same_every_time():
    seen = []
    family = SimpleNamespace(box=((F(0), F(1)),), middle=(F(1, 2),), at=lambda point: seen.append(point) or point)
    family.corners = iter([(F(0),), (F(1),)])
    at, found = worst_plants.least(family, lambda one: float(abs(one[0] - F(1, 2))), looks=1000)
    dice = Random(1)
    more = [F(dice.randrange(65), 64) for _ in range(4)]
    steps = [F(1, 2) + sign * F(1, 4**n) for n in range(1, 10) for sign in (1, -1)]
    assert [point for (point,) in seen] == list(dict.fromkeys([F(1, 2), F(0), F(1), *more, *steps]))
    assert (at, found) == ((F(1, 2),), 0)


def test_no_more_plants_are_looked_at_than_allowed():
    seen = []
    family = SimpleNamespace(box=((F(0), F(1)),), middle=(F(1, 2),), at=lambda point: seen.append(point) or point)
    family.corners = iter([(F(0),), (F(1),)])
    dice = Random(1)
    first = {F(1, 2), F(0), F(1), *(F(dice.randrange(65), 64) for _ in range(4))}
    worst_plants.least(family, lambda one: float(abs(one[0] - F(1, 3))), looks=len(first))
    assert len(seen) == len(first)


# 1/(s + a): Popov reaches as far as one likes; of 1/((s + a)(s + 1)(s + 2)) gains up to (a + 1)(a + 2) 3 are stable
def test_the_worst_plant_of_a_criterion_is_the_one_it_reaches_least_for():
    family = PlantFamily.of_coefficients([1], [1, "a", 3, 1], {"a": (2, 4)})
    assert worst_plants.cheaply_worst(family, F(0)) == (2,)  # gains k with 3 a > 1 + k
    sampled = PlantFamily.of_coefficients(["b"], [1, F(-1, 2)], {"b": (1, 2)}, dt=1)
    assert worst_plants.cheaply_worst(sampled, F(0)) == (2,)  # gains k with 2 b k < 3


# Popov's terms need an output without a direct term, and a phi that is a function of sigma alone
@pytest.mark.parametrize(
    ("direct", "second", "free"),
    [
        (((0, 0), (0, 0)), OWN(sector=Sector(0, 1)), [True, True]),
        (((0, 1), (0, 0)), OWN(sector=Sector(0, 1)), [False, True]),
        (((0, 0), (0, 0)), OWN(sector=Sector(0, 1), time_varying=True), [True, False]),
        (((0, 0), (0, 0)), OWN.norm_bounded(1), [True, False]),
    ],
)
def test_popov_terms_need_no_direct_term(direct, second, free):
    assert permitted.free_channels(two_lags(direct, [OWN(sector=Sector(0, 1)), second])) == free


# x1' = u1 has the eigenvalue 0, x1+ = x1 + u1 has z = 1; a double one is covered by no theorem, and is one all the same
@pytest.mark.parametrize(
    ("A", "dt", "critical", "covered"),
    [
        (LAG, None, False, True),
        ([[0, 0], [0, -1]], None, True, True),
        ([[0, 1], [0, 0]], None, True, False),
        ([[1, 0], [0, 0]], 1, True, True),
        ([[0, 0], [0, 0]], 1, False, True),
    ],
)
def test_an_eigenvalue_0_of_the_loop_is_seen(A, dt, critical, covered):
    asked = two_lags(A=A, dt=dt)
    assert permitted.is_critical(asked) is critical
    if covered:
        assert (permitted.modes_of(asked) is not None) is critical
    if critical:
        with pytest.raises(AssumptionError):
            permitted.require_no_zero(asked)
    else:
        permitted.require_no_zero(asked)


BOTH = {"sector": Sector(0, 1), "slope": SlopeBounds(0, 1)}


@pytest.mark.parametrize(
    ("classes", "found"),
    [
        ((OWN(**BOTH),), True),
        ((OWN(**BOTH), OWN.performance()), True),
        ((OWN(**BOTH), OWN(**BOTH)), True),
        ((OWN(**BOTH), OWN(sector=Sector(0, 1))), False),
        ((OWN(**BOTH, time_varying=True),), False),
        ((OWN(sector=Sector(0, 1), slope=SlopeBounds(0, inf)),), False),
        ((OWN(sector=Sector(0, 1), slope=SlopeBounds(-inf, 1)),), False),
        ((OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 1)),), False),
        ((OWN(**BOTH), OWN(sector=Sector(0, 1), slope=SlopeBounds(-1, 1))), False),
    ],
)
def test_kernels_beside_integrators_need_slopes_from_the_lower_end_on(classes, found):
    assert permitted.rising(about(*classes)) is found


# a form for slopes where these are the bounds; else one for the sector, and one for each side that they do not exceed
@pytest.mark.parametrize(
    ("slope", "more", "sloped", "found"),
    [
        (None, {}, False, ["sector"]),
        ((0, 1), {}, True, ["monotone"]),
        ((0, 1), {"odd": True}, True, ["odd"]),
        ((0, 1), {"time_varying": True}, False, ["sector"]),
        ((0, 2), {}, True, ["sector", "rising"]),
        ((-1, 1), {}, True, ["sector", "falling"]),
        ((-1, 2), {}, True, ["sector"]),
        ((0, 2), {"odd": True}, True, ["sector", "odd rising"]),
        ((-1, 1), {"odd": True}, True, ["sector", "odd falling"]),
        ((0, inf), {}, False, ["sector", "rising"]),
        ((-inf, 1), {}, False, ["sector", "falling"]),
    ],
)
def test_which_forms_a_class_permits(slope, more, sloped, found):
    one = OWN(sector=Sector(0, 1), slope=None if slope is None else SlopeBounds(*slope), **more)
    assert permitted.sloped_channels(about(one)) == [sloped]
    assert [group[0] for group in permitted.groups_of(about(one))] == found
    twice = permitted.groups_of(about(one, one, repeated=True))
    places = [(0,), (1,)] if found[0] == "sector" else []
    assert [tuple(group[1]) for group in twice] == places + [(0, 1)] * (len(twice) - len(places))


def test_operators_and_gains_that_stay_as_they_are():
    fixed, varying = OWN.norm_bounded(1, dynamics="linear time-invariant"), OWN.norm_bounded(1)
    asked = about(fixed, varying)
    assert permitted.fixed_operators(asked) == [range(1)]
    slow = OWN.varying_gain(0, 1, rate=1)
    assert permitted.constant_gains_of(about(OWN.constant_gain(0, 1), slow)) == [range(1)]


@pytest.mark.parametrize(
    ("one", "named"),
    [
        (OWN(sector=Sector(0, 1)), "sector"),
        (OWN(sector=Sector(0, 1), time_varying=True), "sector, time-varying"),
        (OWN(**BOTH), "slope"),
        (OWN(**BOTH, odd=True), "slope, odd"),
        (OWN(**BOTH, odd=True, time_varying=True), "sector, time-varying"),
        (OWN.constant_gain(0, 1), "gain"),
        (OWN.relu(), "ReLU"),
        (OWN.hysteretic("play"), "play"),
        (OWN.norm_bounded(1), "operator"),
        (OWN.delayed(1), "delay"),
    ],
)
def test_a_kind_has_a_name(one, named):
    assert kinds.kind_name(Diagonal((one,))) == named
    assert kinds.kind_name(Diagonal((one, one))) == named
    assert kinds.kind_name(Diagonal((one, OWN(sector=Sector(-1, 1))))).partition("/")[0] == named


def test_repeated_nonlinearities_are_named():
    one, two = OWN(**BOTH), OWN(sector=Sector(0, 1))
    assert kinds.kind_name(Diagonal((one,) * 2, repeated=True)) == "slope, the same in all channels"
    assert kinds.kind_name(Diagonal((one, one, two), repeated=(2, 1))) == "slope/sector, some the same"
    block = OWN.full_block(0, 1)
    assert kinds.kind_name(Diagonal((block, block), repeated=True)) == "full-block sector, the same in all channels"


LOOP = builtin_loop("dead-zone")


@pytest.mark.parametrize(
    ("loop", "given", "several"),
    [
        ("1/(s+1)", None, False),
        ("1/(s+1)", OWN(sector=Sector(0, 1)), False),
        ("1/(s+1)", OWN.relu(), True),
        ("1/(s+1)", OWN.norm_bounded(1), True),
        ("1/(s+1)", OWN.hysteretic("stop"), True),
        ("1/(s+1)", OWN.varying_gain(0, 1, rate=1), True),
        ("1/(s+1)", [Sector(0, 1)], True),
        ("1/(s+1)", {"a": Sector(0, 1)}, True),
        ("1/(s+1)", Diagonal((OWN.relu(),)), True),
        ((LAG, np.eye(2), np.eye(2), np.zeros((2, 2))), None, True),
        (LOOP, None, False),
        (LOOP, Sector(0, 1), False),
        (replace(LOOP, nonlinearity=None, nonlinearity_class=None), [Sector(0, 1)], True),
        (two_lags(), None, True),
        (Problem.about(RationalPlant([1], [1, 1]), OWN(sector=Sector(0, 1))), None, False),
    ],
)
def test_what_is_a_question_about_several_channels(loop, given, several):
    assert kinds.has_channels(loop, given) is several
    with pytest.raises(InputError, match="closes the loop itself"):
        kinds.has_channels(LOOP, [Sector(0, 1)])


# larger classes first, those asked about among them, each once; gains and ReLUs stay in all; a repeated one comes apart
# where it may depend on time
@pytest.mark.parametrize(
    ("classes", "repeated", "found"),
    [
        ((OWN(sector=Sector(0, 1)),) * 2, False, ["sector, time-varying", "sector", "slope", "slope, odd"]),
        ((OWN(sector=Sector(0, 1), odd=True),) * 2, False, ["sector, time-varying", "sector", "sector", "slope"]),
        ((OWN.constant_gain(0, 1),) * 2, False, ["gain"]),
        ((OWN.relu(),) * 2, False, ["ReLU"]),
        ((OWN.constant_gain(0, 1), OWN(**BOTH)), False, ["gain/sector, time-varying", "gain/sector", "gain/slope"]),
        (
            (OWN(**BOTH),) * 2,
            True,
            [
                "sector, time-varying",
                *(f"{one}, the same in all channels" for one in ("sector", "slope", "slope, odd")),
            ],
        ),
    ],
)
def test_the_kinds_that_are_asked_about(classes, repeated, found):
    asked = kinds.channel_kinds(two_lags(given=Diagonal(classes, repeated=repeated)))
    assert [kinds.kind_name(one.classes) for one in asked][: len(found)] == found
    assert (len(asked) == 1) is (len(found) == 1)
    assert [one.kind for one in asked] == [
        "sector" if "sector" in kinds.kind_name(one.classes) else "slope" for one in asked
    ]
    assert all(one.classes.upper == (1, 1) for one in asked)


# t (k1, k2): seven ratios of powers of two about that of the classes asked about, three where a direction takes seconds
@pytest.mark.parametrize(
    ("plant", "classes", "ratios", "words"),
    [
        ((LAG, np.eye(2), np.eye(2), np.zeros((2, 2))), [Sector(0, 1), Sector(0, 3)], 7, "upper bound in channel"),
        ((LAG, np.eye(2), np.eye(2), np.zeros((2, 2))), [Sector(0, 1), OWN.varying_gain(0, 3, rate=1)], 3, "upper"),
        ([["exp(-s)/(s+1)", "0"], ["0", "1/(s+1)"]], [Sector(0, 1), Sector(0, 3)], 3, "upper bound in channel"),
        (
            (LAG, np.eye(2), np.eye(2), np.zeros((2, 2))),
            [Sector(0, 1), OWN.delayed(3)],
            7,
            "delay bound in channel 2 [s]",
        ),
    ],
)
def test_the_directions_of_a_map(plant, classes, ratios, words, monkeypatch):
    asked, told = [], []

    def nothing(problem):
        asked.append(problem)
        return SimpleNamespace(proof=None, refutation=None, refuted_at=None, criterion="")

    monkeypatch.setattr(mapping, "answer", nothing)
    problem = channel_problem(as_plant(plant), classes, late=True)
    found = mapping.stability_map(problem, progress=lambda step, done: told.append((step, done)))
    powers = [-5, -2.5, -1, 0, 1, 2.5, 5] if ratios == 7 else [-2.5, 0, 2.5]
    upper = [tuple(map(float, one.classes.upper)) for one in asked]
    assert upper == [pytest.approx((2 ** max(-e, 0), 3 * 2 ** max(e, 0))) for e in powers]
    assert {one.kind for one in asked} == {"sector"}
    assert told == [(f"map of (k1, k2), direction {i + 1} of {ratios}", i / ratios) for i in range(ratios)]
    assert (found.asked, found.lower) == ((1, 3), (0, 0))
    assert words in found.bounded[1]
    assert found.bounded[0] == "k\u2081, upper bound in channel 1"
    assert [(ray.k1, ray.k2) for ray in found.rays] == upper
    assert mapping.stability_map(problem, seconds=1e-9).rays == ()


def test_a_complete_answer_is_a_ray_of_the_map(monkeypatch):
    problem = two_lags()
    row = {"classes": problem.classes, "proof": None, "refutation": None, "refuted_at": None, "criterion": "known"}
    monkeypatch.setattr(mapping, "_DIRECTIONS", (0.0,))
    monkeypatch.setattr(
        mapping, "answer", lambda _one: SimpleNamespace(**row | {"proof": True, "largest": Bracket(2, 2)})
    )
    for stopped, proved in (("time", 2), (None, None)):
        known = [SimpleNamespace(**row, stopped=stopped)]
        assert mapping.stability_map(problem, known=known).rays[0].proved_k1 == proved
    late = channel_problem(
        as_plant((LAG, np.eye(2), np.eye(2), np.zeros((2, 2))), dt=1), [Sector(0, 1), OWN.delayed(2)]
    )
    assert mapping.stability_map(late).bounded[1] == "delay bound in channel 2 [samples]"


def ray(proved=(None, None), refuted=(None, None)):
    ends = dict(zip(("proved_k1", "proved_k2", "refuted_k1", "refuted_k2"), (*proved, *refuted), strict=True))
    return mapping.Ray(k1=1, k2=1, criterion="", **ends)


# rectangles below what is proved and beyond what is refuted, none inside another
def test_a_map_is_read_as_rectangles():
    rays = [
        ray((1, 5), (4, 8)),
        ray((3, 3), (5, 5)),
        ray((2, 3), (5, 6)),
        ray((4, 1), (9, 4)),
        ray((None, 9), (1, None)),
    ]
    found = mapping.StabilityMap(lower=(F(0), F(0)), asked=(F(1), F(1)), rays=tuple(rays))
    assert found.proved == ((1, 5), (3, 3), (4, 1))
    assert found.refuted == ((4, 8), (5, 5), (9, 4))
    said = {(3, 3): "PROVED", (1, 5): "PROVED", (4, 2): "INCONCLUSIVE", (5, 5): "REFUTED", (6, 9): "REFUTED"}
    assert {point: str(found.verdict(*point)) for point in said} == said
    assert found.verdict(5, 4.5) is found.verdict(4, 5) is Verdict.INCONCLUSIVE
    for point in ((0, 1), (1, 0), (-1, 1)):
        with pytest.raises(InputError, match="no upper bounds above"):
            found.verdict(*point)


# of a member in one channel the other gain is any; an operator counts with all of its class
def test_a_ray_is_refuted_from_the_gains_of_the_member_on():
    classes = Diagonal((OWN(sector=Sector(0, 1)), OWN(sector=Sector(-1, 1))))
    row = {"proof": None, "criterion": "", "refuted_at": 3.0, "largest": Bracket(2, 2)}

    def found(member, of=classes, **more):
        refutation = SimpleNamespace(certificate={"proof": member})
        one = mapping._ray((F(1), F(2)), SimpleNamespace(**row | more, refutation=refutation), of)
        return one.refuted_k1, one.refuted_k2, one.proved_k2, one.criterion

    assert found({"gains": ["1", "1/2"]}) == (1, 0.5, None, "")
    assert found({"channels": [1], "gains": ["1", "7"]}) == (1, -1, None, "")
    assert found({"method": "orbit"}) == (3, 6, None, "")
    assert found({"method": "orbit"}, refuted_at=None)[:2] == (None, None)
    assert found({"gains": ["1", "0"]}, Diagonal((classes.classes[0], OWN.norm_bounded(1))))[:2] == (1, 6)
    assert found({"gains": ["1", "1"]}, proof=True, criterion="circle")[2:] == (4, "circle")

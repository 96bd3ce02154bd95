"""What a certificate says in words: its class, its numbers rounded to the safe side, its member, what it assumes."""

import re
from fractions import Fraction
from math import inf
from pathlib import Path
from types import SimpleNamespace

import pytest
from worded import KNOWN, PLAIN, shown

from lure import InputError, NonlinearityClass, Sector, SlopeBounds, as_plant
from lure.analysis import certify, wording
from lure.analysis.certificates.checker import (
    BOUNDED,
    CONVERGES,
    FINITE_ENERGY,
    MOVES,
    OTHERS,
    UNLIMITED,
    UNSOLVABLE,
)
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.states import assumed, classes, keeps
from lure.analysis.cli.loops import lines
from lure.analysis.numerics.doubles import bound_above, bound_below
from lure.analysis.questions import analyse, max_slope
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.questions.channel_kinds import kind_name
from lure.analysis.questions.channel_map import Ray, StabilityMap
from lure.analysis.questions.energy import EnergyBounds
from lure.analysis.questions.gain import _differences
from lure.analysis.report.loop.write import class_words as row_words
from lure.analysis.verdict import Verdict
from lure.analysis.wording import class_words, counterexample, destroys, interval, meaning, plants_words, proviso
from lure.classes import Diagonal
from lure.plants.family import PlantFamily

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, "phi, time-invariant, in the sector [0, 2]"),
        ({"time_varying": True}, "phi, time-varying, in the sector [0, 2]"),
        ({"odd": True}, "odd phi, time-invariant, in the sector [0, 2]"),
        ({"linear": True}, "linear phi in the sector [0, 2]"),
        ({"slope": ["0", "2"]}, "phi with slope in [0, 2]"),
        ({"slope": ["-1", "3"]}, "phi with slope in [-1, 3], in the sector [0, 2]"),
        ({"slope": ["0", "2"], "odd": True, "time_varying": True}, "time-varying odd phi with slope in [0, 2]"),
        ({"slope": ["0", "2"], "odd": True, "linear": True}, "odd linear phi with slope in [0, 2]"),
        ({"regularity": "any"}, "phi, continuous or not, time-invariant, in the sector [0, 2]"),
        ({"sector": ["0", "finite"]}, "phi, time-invariant, in the sector [0, inf)"),
        ({"sector": ["0", "inf"]}, "phi, time-invariant, in the sector [0, inf]"),
        ({"sector": ["-inf", "1/2"]}, "phi, time-invariant, in the sector [-inf, 0.5]"),
        ({"sector": ["1/3", "2/3"]}, "phi, time-invariant, in the sector [0.3333334, 0.6666666]"),
    ],
)
def test_a_class_in_words(changes, words):
    assert class_words({**PLAIN, **changes}) == words


def test_bounds_are_rounded_into_a_class_that_is_proved_and_out_of_one_that_is_refuted():
    thirds = {**PLAIN, "sector": ["1/3", "2/3"], "slope": ["-1/3", "7/3"]}
    assert class_words(thirds) == "phi with slope in [-0.3333333, 2.333333], in the sector [0.3333334, 0.6666666]"
    outwards = "phi with slope in [-0.3333334, 2.333334], in the sector [0.3333333, 0.6666667]"
    assert class_words(thirds, inwards=False) == outwards
    assert interval(["1/3", "1"], spelled={Fraction(1, 3): "1/3"}) == "[1/3, 1]"


@pytest.mark.parametrize(
    ("value", "below", "above"),
    [
        (2 / 3, "0.6666666", "0.6666667"),
        (Fraction(57, 10), "5.7", "5.7"),
        (5.7, "5.7", "5.700000001"),  # the double is above 57/10
        (0.3, "0.2999999999", "0.3"),  # and this one below 3/10
        (6 * (1 - 1e-12), "5.999999999", "6"),
        (1e12, "1e12", "1e12"),
        (1.5e9, "1.5e9", "1.5e9"),
        (123456789.0, "123456700", "123456800"),
        (-2 / 3, "-0.6666667", "-0.6666666"),
        (1234.5678, "1234.567", "1234.568"),
        (1.23 - 1e-9, "1.229999998", "1.229999999"),  # ten digits just below a number of up to three
        (1.234 - 1e-9, "1.233999", "1.234"),
        (Fraction(1, 10**6) / 3, "3.333333e-07", "3.333334e-07"),
        (float("inf"), "inf", "inf"),
        (0.0, "0", "0"),
    ],
)
def test_a_bound_is_rounded_once_and_to_the_safe_side(value, below, above):
    assert (bound_below(value), bound_above(value)) == (below, above)


def test_what_is_proved_of_a_box_is_rounded_into_it():
    # lower bounds are rounded up and upper ones down; so the rate: 2/3 is above .6666666
    system = {"kind": "family", "parameters": [["a", "1/3", "2/3"], ["b", "1", "1"]], "rates": ["2/3", "0"]}
    rate = "that changes by at most 0.6666666 in a unit of time"
    assert plants_words(system) == f" for every a in [0.3333334, 0.6666666] {rate}"
    wide = plants_words(system, inwards=False)  # what is refuted holds a member at an end
    assert wide == f" for every a in [0.3333333, 0.6666667] {rate.replace('6 in', '7 in')}"
    assert plants_words({**system, "rates": ["inf", "0"]}).endswith(" that changes at any speed")
    low, high = Fraction(10**16 + 1, 3 * 10**16), Fraction(2 * 10**16 - 1, 3 * 10**16)
    family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (low, high)})
    (said,) = re.findall(r"a in \[(.*), (.*)\]$", family.ranges)
    assert low < Fraction(said[0]) < Fraction(said[1]) < high


@pytest.mark.parametrize(("lower", "said"), [(0.0, "0"), (0.1, "0.1"), (1 / 3, "0.3333334"), (-1 / 3, "-0.3333333")])
def test_the_classes_of_a_report_begin_no_lower_than_what_is_proved(lower, said):
    assert row_words({"lower": lower, "question": "sector", "time_varying": False}) == f"sector [{said}, k]"


def test_no_bound_is_rounded_to_the_nearest_number():
    told = [path for room in ("questions", "cli", "report") for path in (ROOT / "analysis" / room).rglob("*.py")]
    nearest = re.compile(r"\{[^{}]*\.(?:low|high)\b[^{}]*:\.\d+g\}")
    assert [one for path in told for one in nearest.findall(path.read_text("utf-8"))] == []


def test_what_is_proved_is_the_conclusion_of_the_certificate():
    assert meaning(shown()) == "The point 0 attracts every solution"
    assert meaning(shown(CONVERGES)) == "Every solution converges to the set of equilibria"
    assert meaning(shown(BOUNDED), "the scheme") == "Every motion of the scheme is bounded"
    assert meaning(shown(FINITE_ENERGY)).endswith("with inputs to the block and initial functions of finite energy")


BENT = {"method": "orbit", "points": [["-1", "0"], ["0", "0"], ["1", "0"]], "left": "3/2", "right": "3/2"}
FLAT = {"method": "flow-orbit", "points": [["-2", "-4"], ["0", "0"], ["2", "4"]], "left": "0", "right": "0"}
FLAT |= {"durations": ["1", "1/2"], "half": True}  # twice 3/2 s
SKEW = {"method": "orbit", "points": [["-1", "0"], ["0", "0"], ["2", "0"]], "left": "3/2", "right": "3/2"}


@pytest.mark.parametrize(
    ("conclusion", "proof", "does", "nonlinearity"),
    [
        (MOVES, {"method": "linear-gain", "gain": "6"}, "destabilises the loop", "phi = 6 sigma"),
        (MOVES, {"method": "matrix-gain", "gain": "0"}, "destabilises the loop", "phi = 0"),
        (MOVES, {"method": "linear-gain", "gain": "1/3"}, "destabilises the loop", "phi = 1/3 sigma"),
        (OTHERS, {"method": "linear-gain", "gain": "1"}, "gives the loop other equilibria than 0", "phi = sigma"),
        (
            UNSOLVABLE,
            {"method": "linear-gain", "gain": "-1"},
            "leaves the loop without exactly one solution",
            "phi = -sigma",
        ),
        (
            MOVES,
            {"method": "crossing", "gains": ["2", "2.5"]},
            "destabilises the loop",
            "phi = k sigma with k about 2",
        ),
        (
            MOVES,
            {"method": "switched-gain", "gains": ["3", "1", "2"]},
            "destabilises the loop",
            "phi = k(t) sigma with k(t) between 1 and 3, over and over again",
        ),
        (MOVES, BENT, "makes the loop oscillate", "a dead zone of +-1 with slope 1.5"),
        (OTHERS, BENT, "gives the loop other equilibria than 0", "a dead zone of +-1 with slope 1.5"),
        (MOVES, FLAT, "makes the loop oscillate", "a saturation with slope 2 up to +-2, period 3 s"),
        (MOVES, SKEW, "makes the loop oscillate", "a piecewise linear phi with 2 corners and slopes from 0 to 1.5"),
        (
            MOVES,
            {**BENT, "right": "2"},
            "makes the loop oscillate",
            "a piecewise linear phi with 2 corners and slopes from 0 to 2",
        ),
        (
            MOVES,
            {**FLAT, "left": "1", "right": "1", "half": False},
            "makes the loop oscillate",
            "a piecewise linear phi with 2 corners and slopes from 1 to 2, period 1.5 s",
        ),
        (MOVES, {"method": "structure"}, "destabilises the loop", "a nonlinearity of the class"),
    ],
)
def test_a_counterexample_is_named(conclusion, proof, does, nonlinearity):
    found = shown(conclusion, "counterexample", proof=proof)
    assert (destroys(found), counterexample(found)) == (does, nonlinearity)


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        (["0", "1/2"], "the gains 0, 0.5"),
        (["0"] * 64 + ["1/2"], "the gains 0 (64 times), 0.5"),
        (["1"] * 9, "the gain 1 in all of 9 channels"),
    ],
)
def test_equal_gains_of_many_channels_are_counted(gains, said):
    laws = {"channels": [{"kind": "sector"}] * len(gains)}
    assert counterexample(shown(MOVES, laws=laws, proof={"method": "linear-gains", "gains": gains})) == said


@pytest.mark.parametrize("method", ["linear-gains", "late-gains", "late-turns", "late-crossing"])
def test_the_channel_from_z_to_w_has_no_gain_in_words(method):
    laws = {"channels": [PLAIN, {**PLAIN, "operator": "performance"}], "repeated": False}
    gains = ["1/3", "0"]
    found = shown(
        UNLIMITED, laws=laws, proof={"method": method, "gains": [gains] if method == "late-crossing" else gains}
    )
    assert counterexample(found) == "phi = 1/3 sigma"
    assert destroys(found).startswith("gives the loop a transfer function")


@pytest.mark.parametrize(("more", "said"), [(0, ""), (1, " and 1 more")])
def test_gains_beyond_two_are_counted(more, said):
    proof = {"method": "switched-gains", "gains": [["1", "0"], ["0", "1"]] + [["1", "1"]] * more}
    laws = {"channels": [PLAIN] * 2}
    assert (
        counterexample(shown(MOVES, laws=laws, proof=proof))
        == f"the gains (1, 0), then (0, 1){said}, over and over again"
    )


# Rounded numbers may behave otherwise: phi = -2/3 sigma and a = 2/3 are on the edge, and with a = .66667 the loop of
# 1/(s + a) is stable.  What is not named exactly is said to be about that.
@pytest.mark.parametrize(
    ("proof", "said"),
    [
        ({"method": "linear-gain", "gain": "-2/3"}, "phi = -2/3 sigma at a = 2/3"),
        ({"method": "linear-gain", "gain": "1"}, "phi = sigma at a about 0.66666667"),
        ({"method": "switched-gain", "gains": ["0", "2/3"]}, "phi = k(t) sigma with k(t) between 0 and about 0.66667"),
        (
            {"method": "switched-gains", "gains": [["1", "0"], ["0", "2/3"]]},
            "the gains about (1, 0), then (0, 0.66667)",
        ),
        ({"method": "ramped-gains", "gains": [["1/3"], ["2"]]}, "gains that go linearly from about (0.33333) to (2)"),
        ({"method": "relu-ray", "gains": [["1/3", "1"]]}, "that along which the gains are about (0.33333, 1)"),
        (
            {"method": "relu-ray", "gains": [["1", "0"], ["0", "1"]]},
            "the gains are (1, 0), then (0, 1), again and again",
        ),
        ({"method": "delayed-members", "delays": ["1/3"], "gains": ["0"]}, "a delay of about 0.33333"),
        (
            {"method": "delayed-gains", "channel": 1, "samples": 2, "gains": ["2/3"]},
            "in channel 1 and the gains about 0.6",
        ),
        (
            {"method": "linear-gains", "gains": ["0"], "matrices": [[["1/3", "1"]]]},
            "matrix of gains about [0.33333, 1]",
        ),
        ({**BENT, "left": "2/3", "right": "2/3"}, "a dead zone of +-1 with slope about 0.66667"),
        ({**SKEW, "right": "2/3"}, "slopes from 0 to 1.5"),
        ({**SKEW, "left": "5/3"}, "slopes from 0 to about 1.6667"),
    ],
)
def test_a_rounded_number_of_a_counterexample_is_said_to_be_one(proof, said):
    at = "2/3" if "gain" in proof and proof["gain"] != "1" else "2000000000003/3000000000000"
    system = {"kind": "family", "parameters": [["a", "2/3", "1"]]}
    member = {"method": "member", "at": [at], "proof": proof}
    laws = {"channels": [{"kind": "sector"}], "repeated": False}
    assert said in counterexample(shown(MOVES, system=system, laws=laws, proof=member))


def test_a_long_number_of_a_certificate_is_rounded_and_said_to_be():
    long = f"slope from 0 up to {2 * 10**300 + 1}/3 (about 6.67e+299), rates up to 1/3 (about 0.3)"
    assert wording.plain(long) == "slope from 0 up to about 6.66666667e+299, rates up to 1/3 (about 0.3)"
    assert wording.plain("no motion comes to rest") == "no motion comes to rest"
    assert wording.plain(f"a gain of -{10**300 + 1}.") == "a gain of about -1e+300."
    below = f"up to {Fraction(4 - 2**-50)} (about 4)"  # not what a reader gave: 4 is no member
    assert wording.plain(below) == below
    assert wording.plain(f"from {Fraction(0.7)} (about 0.7), D = {Fraction(0.1)}") == "from about 0.7, D about 0.1"
    assert wording.plain(f"up to {10**59}; x_{10**70}, {'1' * 5000}") == f"up to {10**59}; x_{10**70}, {'1' * 5000}"


# phi = -1/3 sigma leaves a pole at 1/3: the classes begin at -1/3, and -.3333333 is above it
def test_classes_that_are_never_stable_begin_no_higher_than_what_is_refuted():
    found = max_slope(([1], [1, 0, 0, Fraction(1, 3)]), lower=Fraction(-1, 3), search="linear")
    assert found.verdict is Verdict.REFUTED
    assert str(found).startswith("Not stable for phi with slope in [-0.3333334, k]")
    assert lines(found, stable=None)[0].startswith("Not stable for every phi with slope in [-0.3333334, k]")
    row = {"lower": -1 / 3, "question": "slope", "odd": False}
    assert row_words(row, inwards=False) == "slope in [-0.3333334, k]"


@pytest.mark.parametrize(("size", "said"), [(7e307, "7e[+]307"), (1e-307, "1e-307")])
def test_bounds_whose_factors_are_no_doubles_are_refused_by_their_channel(size, said):
    plant = as_plant([["1/(s+1)", "0"], ["0", "1/(s+3)"]])
    with pytest.raises(InputError, match=f"the upper bound of channel 2 is {said}, .* between 1e-140 and 1e[+]140"):
        max_slope(plant, [SlopeBounds(0, 1), SlopeBounds(0, size)])
    assert certify(plant, [Sector(0, 1), Sector(0, size)]).verdict is Verdict.PROVED


def ray(proved, refuted):
    ends = dict(zip(("proved_k1", "proved_k2", "refuted_k1", "refuted_k2"), (*proved, *refuted), strict=True))
    return Ray(k1=1, k2=1, criterion="circle", **ends)


# what is proved holds for smaller bounds in both channels, what is refuted for larger ones
@pytest.mark.parametrize(
    ("k1", "k2", "verdict"),
    [
        *((1, 2, "PROVED"), (2, 1, "PROVED"), (0.5, 2, "PROVED"), (1, 0.5, "PROVED")),
        *((1.01, 2, "INCONCLUSIVE"), (1, 2.01, "INCONCLUSIVE"), (2, 1.01, "INCONCLUSIVE"), (2.99, 9, "INCONCLUSIVE")),
        *((3, 2, "REFUTED"), (9, 2, "REFUTED"), (3, 9, "REFUTED"), (3, 1.99, "INCONCLUSIVE")),
    ],
)
def test_a_map_is_proved_below_its_corners_and_refuted_beyond(k1, k2, verdict):
    none, nowhere = (None, None), (5, 5)
    rays = (ray((1, 2), none), ray((2, 1), (3, 2)), ray((0.5, 0.5), nowhere), ray(none, none))
    found = StabilityMap(lower=(Fraction(0), Fraction(0)), asked=(Fraction(1), Fraction(1)), rays=rays)
    assert (found.proved, found.refuted) == (((1, 2), (2, 1)), ((3, 2),))
    assert found.verdict(k1, k2).name == verdict
    for below in ((0, k2), (k1, 0)):
        with pytest.raises(InputError, match="no upper bounds above the lower ones"):
            found.verdict(*below)


# the second corner is inside the first but for the last of its digits, which are not printed
def test_a_corner_inside_another_as_printed_is_not_listed():
    rays = (ray((96, 1.49999984849), (None, None)), ray((0.5, 1.49999984859), (None, None)))
    found = StabilityMap(lower=(Fraction(0), Fraction(0)), asked=(Fraction(1), Fraction(1)), rays=rays)
    assert found.proved == ((0.5, 1.49999984859), (96, 1.49999984849))
    assert found.proved_texts == (("96", "1.499999848"),)


@pytest.mark.parametrize(
    "given", [{"seconds": 0}, {"seconds": -1.0}, {"seconds": inf}, {"method": ""}, {"numbers": "x"}]
)
def test_options_that_are_none_are_refused(given):
    with pytest.raises(InputError, match=f"Ways.{next(iter(given))} is "):
        ProofOptions(**given)
    assert ProofOptions(seconds=1e-9).seconds == 1e-9


KINDS = [
    ([NonlinearityClass.norm_bounded(1)] * 2, "operator"),
    ([NonlinearityClass.constant_gain(0, 1), NonlinearityClass.relu()], "gain/ReLU"),
    ([NonlinearityClass.delayed(1), NonlinearityClass.hysteretic("play")], "delay/play"),
    ([NonlinearityClass.delayed(1, varying=True)] * 2, "varying delay"),
    (
        [NonlinearityClass.slope_restricted(0, 1), NonlinearityClass.slope_restricted(0, 1, odd=True)],
        "slope/slope, odd",
    ),
    ([KNOWN.classes[0], NonlinearityClass(sector=Sector(0, 1), time_varying=True)], "sector/sector, time-varying"),
]


@pytest.mark.parametrize(("classes", "words"), KINDS)
def test_classes_are_named_by_their_kinds(classes, words):
    assert kind_name(Diagonal(tuple(classes))) == words
    if len({*classes}) == 1:
        assert kind_name(Diagonal(tuple(classes), repeated=True)) == f"{words}, the same in all channels"


# of their differences an operator that is linear is what it was, a function is a gain that varies between its slopes
def test_an_incremental_gain_is_of_the_slopes():
    linear = NonlinearityClass.norm_bounded(1, dynamics="linear time-invariant")
    slopes = NonlinearityClass.slope_restricted(-1, 2, odd=True)
    found = _differences(Diagonal((linear, NonlinearityClass.constant_gain(0, 1), slopes)))
    varying = NonlinearityClass(sector=Sector(-1, 2), time_varying=True)
    assert found.classes == (linear, NonlinearityClass.constant_gain(0, 1), varying)
    narrow = NonlinearityClass(sector=Sector(0, 1), slope=SlopeBounds(-1, 2))
    for one in (narrow, KNOWN.classes[0], NonlinearityClass.relu(), NonlinearityClass.hysteretic("stop")):
        with pytest.raises(InputError, match=r"channel 2 is .* of whose differences nothing is known"):
            _differences(Diagonal((linear, one)))


def test_the_energy_is_that_of_the_classes_of_the_certificate():
    laws = {"channels": [PLAIN, {**PLAIN, "operator": "performance", "sector": ["-1", "1"]}], "repeated": False}
    told = SimpleNamespace(certificate={"laws": laws}, assumed="so")
    found = EnergyBounds(initial=2 / 3, peak=inf, reason="why", proofs=(told,))
    head = "For phi, time-invariant, in the sector [0, 2], for which so: without disturbance the energy of z is at most"
    assert str(found) == f"{head} 0.6666667 |x(0)|^2 (certified) (why)."
    assert str(EnergyBounds(initial=inf, peak=inf, reason="why")) == "No quadratic function was found (why)."


def direct(d, **nonlinearities):
    system = {"kind": "state-space", "d": d} if "/" in d else None
    system = system or {"kind": "transfer", "numerator": [d, "1"], "denominator": ["1", "1"]}
    return {"system": system, "laws": {**PLAIN, **nonlinearities}}


SOLUTION = "sigma + D phi(sigma) = y, D = {}, has exactly one solution sigma for every y"


@pytest.mark.parametrize(
    ("theorem", "direct", "changes", "words"),
    [
        ("circle", "0", {}, ""),
        ("circle", "1", {}, SOLUTION),
        ("popov", "1/2", {}, "sigma + D phi(sigma), D = {}, is increasing with a locally Lipschitz inverse"),
        ("circle", "1", {"linear": True}, ""),
        ("circle", "1", {"slope": ["0", "2"]}, ""),
        ("circle", "1", {"slope": ["-2", "2"]}, SOLUTION),  # 1 + D phi' changes its sign
        ("circle", "1", {"slope": ["-1", "2"]}, SOLUTION),
        ("circle", "-2", {"sector": ["1", "2"], "slope": ["1", "2"]}, ""),  # negative throughout
        ("circle", "-1", {"slope": ["0", "2"]}, SOLUTION),
        ("circle", "1", {"slope": ["0", "inf"]}, SOLUTION),
    ],
)
def test_one_solution_is_shown_by_slopes_or_assumed(theorem, direct, changes, words):
    assert assumed(theorem, Fraction(direct), classes({**PLAIN, **changes})) == words.format(direct)


def test_what_is_assumed_of_the_class_is_a_proviso():
    assert proviso(SimpleNamespace(assumed="phi is so")) == "for which phi is so"
    assert proviso(SimpleNamespace(assumed="")) == ""
    assert proviso(SimpleNamespace(assumed=f"D = {Fraction(0.1)}")) == "for which D about 0.1"  # no double is one tenth


def test_a_sign_is_kept_from_the_lower_end_of_the_sector_on():
    one, plain, below = Fraction(1), classes(PLAIN), classes({**PLAIN, "sector": ["-2", "2"]})
    assert keeps(one, plain, (0, 5))
    assert not keeps(one, below, (0, 5))  # 1 - 2 < 0 at the lower end
    assert not keeps(one, plain, (0, float("inf")))
    assert not keeps(one, plain, (-float("inf"), 0))
    assert not keeps(one, classes({**PLAIN, "sector": ["-inf", "2"]}), (0, 1))
    assert not keeps(one, plain, plain.slope)


def test_the_direct_term_of_a_system():
    found = [
        wording.direct_term(system)
        for system in (
            {"kind": "transfer", "numerator": ["4", "1"], "denominator": ["2", "1"]},
            {"kind": "transfer", "numerator": ["1"], "denominator": ["2", "1"]},
            {"kind": "state-space", "d": "3"},
            {"kind": "delay", "terms": []},
        )
    ]
    assert found == [2, 0, 3, 0]


WIDE = {**PLAIN, "sector": ["-1", "3"]}


@pytest.mark.parametrize(
    ("larger", "smaller", "inside"),
    [
        ({}, {}, True),
        (WIDE, {}, True),
        ({}, WIDE, False),
        ({}, {"sector": ["0", "3"]}, False),
        ({}, {"sector": ["-1", "2"]}, False),
        ({}, {"sector": ["-inf", "2"]}, False),
        ({"sector": ["-inf", "2"]}, {"sector": ["-inf", "1"]}, True),
        ({"sector": ["0", "finite"]}, {"sector": ["0", "9"]}, True),
        ({"sector": ["0", "finite"]}, {"sector": ["0", "inf"]}, False),
        ({"sector": ["0", "inf"]}, {"sector": ["0", "finite"]}, True),
        ({"sector": ["0", "9"]}, {"sector": ["0", "finite"]}, False),
        ({"sector": ["1", "inf"]}, {"sector": ["0", "finite"]}, False),
        ({"odd": True}, {}, False),
        ({}, {"odd": True}, True),
        ({"odd": True}, {"linear": True}, True),
        ({}, {"time_varying": True}, False),
        ({"time_varying": True}, {}, True),
        ({"linear": True}, {}, False),
        ({}, {"linear": True}, True),
        ({"slope": ["0", "2"]}, {}, False),
        ({"slope": ["0", "2"]}, {"slope": ["0", "2"]}, True),
        ({"slope": ["0", "2"]}, {"slope": ["-1", "2"]}, False),
        ({"slope": ["0", "2"]}, {"slope": ["0", "inf"]}, False),
        ({"slope": ["0", "2"]}, {"linear": True}, True),
        ({"slope": ["1", "2"]}, {"linear": True}, False),
        ({}, {"slope": ["0", "1"]}, True),
        ({"regularity": "any"}, {}, True),
        ({}, {"regularity": "any"}, False),
        ({"regularity": "any"}, {"regularity": "any"}, True),
        ({}, {"regularity": "any", "linear": True}, True),
    ],
)
def test_one_class_inside_another(larger, smaller, inside):
    assert contains({**PLAIN, **larger}, {**PLAIN, **smaller}) is inside


def test_a_refuted_class_says_why_no_criterion_applies():
    found = analyse("(0.8+1.6/s)*10/(s*(0.1*s+1)*(0.02*s+1))", "min(max(sigma,-1),1)")
    assert found.verdict is Verdict.REFUTED
    said = " ".join(str(found).split())
    assert said.count("the pole at s = 0 has multiplicity 2; the critical case needs a simple one") == 1
    assert "give a positive lower gain" not in said  # none contains a saturation

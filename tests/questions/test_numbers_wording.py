"""What rates, regions, gains, responses and tolerances say: numbers rounded to the safe side, members, assumptions."""

from dataclasses import replace
from fractions import Fraction
from math import inf
from types import SimpleNamespace

import pytest
from worded import KNOWN, PLAIN, shown

from lure import Sector
from lure.analysis.certificates.checker import (
    CONVERGES,
)
from lure.analysis.questions import steady as steady_module
from lure.analysis.questions.decay import RateBound
from lure.analysis.questions.gain import GainBound
from lure.analysis.questions.margins import Margin, Tolerances, tolerances
from lure.analysis.questions.regions import AttractedSet, OutsideSet, RegionOfAttraction
from lure.analysis.questions.steady import SteadyPoint, SteadyResponse
from lure.analysis.report.loop.asked import ASKED
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.files import parse_system
from lure.plants.family import PlantFamily


def seen(time="continuous", rate=None, assumed="", method="", **more):
    """What was accepted of a rate; of a member with the gain 1 or gains that jump where there is a method."""
    system = {"time": time, **more}
    found = {"system": system, "laws": PLAIN | {"sector": ["1/3", "2/3"]}, "proof": {"method": method, "gain": "1"}}
    return SimpleNamespace(
        certificate=found | ({} if rate is None else {"rate": rate}), theorem="circle", assumed=assumed
    )


RATE = "solution satisfies |x(t)| <= c {} with one c for phi{} (circle, certified)"
PUSHED = "m exp(-1 t), m the greatest |x| before t = 0,"
OUT = "Not every solution decays for all members of the class (phi, time-invariant, in the sector [{}, {}]): "
OUT = OUT.format("0.3333333", "0.6666667")  # what is refuted is rounded outwards: the member is in it


@pytest.mark.parametrize(
    ("time", "ends", "proof", "member", "verdict", "closed", "said"),
    [
        ("continuous", (2 / 3, inf), {"rate": "2/3"}, None, "PROVED", False, ("|x(0)| exp(-0.6666666 t)", "")),
        ("discrete", (0, 2 / 3), {"rate": "2/3"}, None, "PROVED", False, ("|x(0)| 0.6666667^t (t in samples)", "")),
        ("continuous", (1, inf), {"rate": "1", "late": []}, None, "PROVED", False, (PUSHED, "")),
        (
            "discrete",
            (0, 0.5),
            {"rate": "1/2", "assumed": "so"},
            None,
            "PROVED",
            False,
            ("|x(0)| 0.5^t (t in samples)", ", for which so"),
        ),
        ("continuous", (-2 / 3, inf), {"rate": "-2/3"}, None, "INCONCLUSIVE", False, ("|x(0)| exp(0.6666667 t)", "")),
        ("continuous", (0, 1), {}, {"rate": "1"}, "INCONCLUSIVE", False, ("|x(0)| exp(0 t)", "")),
        ("discrete", (0.5, 1), {}, {"rate": "1/2"}, "INCONCLUSIVE", False, ("|x(0)| 1^t (t in samples)", "")),
        ("continuous", (0, 0), {}, {}, "REFUTED", True, ("|x(0)| exp(0 t)", "")),
        ("continuous", (1, 1.000001), {"rate": "1"}, {"rate": "1.000001"}, "PROVED", True, ("|x(0)| exp(-1 t)", "")),
        ("continuous", (1, 1.00001), {"rate": "1"}, {"rate": "1.00001"}, "PROVED", False, ("|x(0)| exp(-1 t)", "")),
        ("continuous", (-inf, -2 / 3), None, {"rate": "-2/3"}, "REFUTED", False, None),
        ("discrete", (1, inf), None, {}, "REFUTED", False, None),
        ("discrete", (4 / 3, inf), None, {"rate": "4/3", "method": "switched-gain"}, "REFUTED", False, None),
        ("discrete", (0.5, inf), None, {"rate": "1/2"}, "INCONCLUSIVE", False, None),
        ("continuous", (-inf, 2 / 3), None, {"rate": "2/3"}, "INCONCLUSIVE", False, None),
    ],
)
def test_a_rate_is_said_to_the_safe_side(time, ends, proof, member, verdict, closed, said):
    sides = [None if given is None else seen(time, **{"method": "linear-gain"} | given) for given in (proof, member)]
    reason = "" if verdict == "PROVED" else "why"
    made = {"rate": Bracket(*ends), "classes": KNOWN, "nonlinearity_class": "phi", "reason": reason}
    found = RateBound(time=time, proof=sides[0], refutation=sides[1], **made)
    assert (found.verdict.name, found.closed) == (verdict, closed)
    slow = {"2/3": "decays no faster than exp(-0.6666667 t)", "-2/3": "grows at least like exp(0.6666666 t)"}
    unit = " (t in samples)" if proof is None else ""
    slow |= {"4/3": f"grows at least like 1.333333^t{unit}", "1/2": f"decays no faster than 0.5^t{unit}"}
    slow |= {"1": "decays no faster than exp(-1 t)", "1.000001": "decays no faster than exp(-1.000001 t)"}
    slow |= {"1.00001": "decays no faster than exp(-1.00001 t)", None: "does not decay"}
    other = "gains that jump" if "method" in (member or {}) else "phi = sigma"
    against = "" if member is None else f"with {other} a solution {slow[member.get('rate')]}"
    parts = {
        "PROVED": ["Every ", against],
        "REFUTED": [f"{OUT}{against}; every " if said else OUT + against, ""],
        "INCONCLUSIVE": ["No decay is proved; every " if said else "No rate is proved for phi", against],
    }[verdict]
    parts[0] += RATE.format(*said) if said else ""
    assert str(found) == "; ".join(filter(None, parts)) + "."


UNIT = ((Fraction(1), Fraction(0)), (Fraction(0), Fraction(1)))
THIRDS = (Fraction(-1, 3), Fraction(2, 3))
CORNERS = ((Fraction(0), Fraction(0)), (Fraction(1), Fraction(1)))


def attracted(kind, volume=2 / 3, conclusion="", **more):
    return AttractedSet(kind=kind, volume=volume, proof=shown(conclusion), **more)


@pytest.mark.parametrize(
    ("states", "sets", "area", "said"),
    [
        (1, [attracted("interval", interval=THIRDS)], 1, "starts between -0.3333333333 and 0.6666666666 tends to 0."),
        (
            1,
            [attracted("interval", interval=(-inf, inf))],
            inf,
            "PROVED: every solution tends to 0, wherever it starts.",
        ),
        (2, [attracted("everything", inf)], inf, "PROVED: every solution tends to 0, wherever it starts."),
        (
            2,
            [attracted("everything", inf, CONVERGES)],
            inf,
            "it converges to the set of equilibria, and 0 is the only one.",
        ),
        (
            2,
            [attracted("ellipsoid", P=UNIT)],
            2 / 3,
            "in the ellipsoid x^T P x <= 1 tends to 0; its area is at least 0.6666666.",
        ),
        (3, [attracted("level set", P=UNIT)], 2 / 3, "int phi_i <= 1 tends to 0; its volume is at least 0.6666666."),
        (
            2,
            [attracted("curve", points=CORNERS)],
            2 / 3,
            "within a closed curve of 2 points tends to 0; its area is at least 0.6666666.",
        ),
        (2, [attracted("ellipsoid", P=UNIT)] * 3, 4 / 3, "Together with 2 more the area is at least 1.333333."),
        (2, [], 0, "INCONCLUSIVE: no set of starts is proved to be attracted by 0: why."),
    ],
)
def test_a_region_is_said_to_the_safe_side(states, sets, area, said):
    verdict = Verdict.PROVED if sets else Verdict.INCONCLUSIVE
    beyond = OutsideSet(kind="interval", interval=THIRDS, proof=shown())
    more = {"reason": "why", "outside": (beyond,) if states == 1 else ()}
    found = RegionOfAttraction(
        verdict=verdict, states=states, sets=tuple(sets), area=(area, 4 / 3), reach=2 / 3, **more
    )
    lines = found.lines()
    assert any(line.endswith(said) for line in lines)
    assert ("wherever it starts" in " ".join(lines)) == (area == inf)
    assert f"The {({1: 'length', 2: 'area'}).get(states, 'volume')} of the region is at most 1.333334." in lines
    assert ("No solution that starts from 0.6666666667 on or up to -0.3333333334 tends to 0." in lines) == (states == 1)
    assert ("It holds the points asked about times 0.6666666." in lines) == bool(sets)
    assert ("Why." in lines) == bool(sets)


def gained(low, high, verdict, proviso="", **more):
    told = SimpleNamespace(description="phi = 2 sigma gives the loop a larger L2 gain")
    sides = {"witness": told if low else None, "proof": None, "refutation": None, "proviso": proviso}
    factors = SimpleNamespace(verdict=verdict, evidence=Evidence.CERTIFIED, criterion="circle", reason="why", **sides)
    factors.stopped, factors.unfinished = None, ""
    return GainBound(gain=Bracket(low, high), classes=KNOWN, performance=None, plant=None, factors=factors, **more)


MEMBER = "a member has a gain above 0.3333333, with phi = 2 sigma."


@pytest.mark.parametrize(
    ("found", "verdict", "said"),
    [
        (
            gained(1 / 3, 2 / 3, Verdict.PROVED),
            "PROVED",
            ("The L2 gain from w to z is at most 0.6666667 for phi", MEMBER),
        ),
        (
            gained(0, 2 / 3, Verdict.PROVED, "for which so"),
            "PROVED",
            ("The L2", "[0, 1], for which so (circle, certified)."),
        ),
        (
            gained(0, 1, Verdict.PROVED, incremental=True),
            "PROVED",
            ("The incremental L2 gain from w to z is", "certified)."),
        ),
        (
            gained(inf, inf, Verdict.REFUTED, at_input=True),
            "REFUTED",
            ("No L2 gain from w, added to mu, to z = sigma is finite for all members of the class (phi in", ""),
        ),
        (
            gained(1 / 3, inf, Verdict.REFUTED),
            "INCONCLUSIVE",
            ("No bound of the L2 gain from w to z is proved for", MEMBER),
        ),
        (
            gained(1 / 3, inf, Verdict.INCONCLUSIVE),
            "INCONCLUSIVE",
            ("No bound of the L2 gain", "[0, 1] (why); " + MEMBER),
        ),
    ],
)
def test_a_gain_is_said_to_the_safe_side(found, verdict, said):
    assert (found.verdict.name, found.closed) == (verdict, verdict == "REFUTED")
    assert str(found).startswith(said[0])
    assert str(found).endswith(said[1])


@pytest.mark.parametrize(
    ("found", "most", "least"),
    [
        (gained(1 / 3, 2 / 3, Verdict.PROVED), "0.6666667", "0.3333333"),
        (gained(1 / 3, inf, Verdict.INCONCLUSIVE), "no bound", "0.3333333"),
        (gained(inf, inf, Verdict.REFUTED), "no bound", "every bound"),
    ],
)
def test_a_gain_on_its_page_is_that_of_its_sentence(found, most, least):
    rows = dict(found._page().rows)
    assert (rows["at most"], rows["above"]) == (most, least)
    assert (rows["proved by"], rows["by the member"]) == ("circle", found.witness)


def steady(verdict, rate=(2 / 3, 1.0), time="continuous", **more):
    sides = {"proof": SimpleNamespace(theorem="circle"), "refutation": "shown", "witness": "with phi = sigma"}
    found = SimpleNamespace(verdict=verdict, rate=Bracket(*rate), time=time, criterion="circle", **sides)
    return SteadyResponse(classes=KNOWN, differences=found, **more)


ONE, UNKNOWN = (
    "One solution is bounded on the whole time axis, and every other approaches it like ",
    "It is not decided whether",
)


@pytest.mark.parametrize(
    ("found", "verdict", "rate", "said"),
    [
        (steady(Verdict.PROVED), "PROVED", (2 / 3, 1), ONE + "exp(-0.6666666 t), whatever"),
        (
            steady(Verdict.PROVED, (0.2, 2 / 3), "discrete"),
            "PROVED",
            (0.2, 2 / 3),
            ONE + "0.6666667^t (t in samples), whatever",
        ),
        (
            steady(Verdict.REFUTED),
            "REFUTED",
            (2 / 3, 1),
            "Not every loop has a solution that attracts all others for phi",
        ),
        (steady(Verdict.REFUTED, known=("tanh",)), "INCONCLUSIVE", (2 / 3, inf), UNKNOWN),  # no gain is tanh
        (steady(Verdict.REFUTED, outside=True), "INCONCLUSIVE", (2 / 3, inf), UNKNOWN),
        (steady(Verdict.REFUTED, (0.2, 1.5), "discrete", outside=True), "INCONCLUSIVE", (0, 1.5), UNKNOWN),
        (
            steady(Verdict.PROVED, several=("two exist",)),
            "REFUTED",
            (2 / 3, 1),
            "No solution attracts all others for phi",
        ),
        (steady(Verdict.INCONCLUSIVE), "INCONCLUSIVE", (2 / 3, 1), UNKNOWN),
    ],
)
def test_a_steady_response_is_that_of_what_was_asked(found, verdict, rate, said):
    assert (found.verdict.name, (found.rate.low, found.rate.high)) == (verdict, rate)
    assert str(found).startswith(said)
    assert (found.criterion, found.evidence is None) == ("circle" * (verdict == "PROVED"), verdict == "INCONCLUSIVE")
    assert (found.refutation is None) == bool(found.known or found.outside)


LOOP = """
[plant]
A = [[-1]]
B = [[1]]
C = [[1]]
[class]
slope = [0, 1]
[performance]
Bw = [[1]]
Cz = [[7]]
[forcing]
amplitude = 3
omega = 2
"""


def test_what_a_system_says_of_its_input_holds_where_nothing_else_is_given():
    system = parse_system(LOOP, name="loop", source="a file")
    own, other = steady_module._posed(system, None, None, None), {"Bw": [[1]], "Cz": [[9]]}
    assert (own.performance.Cz, own.forcing.amplitude) == (((7,),), (3,))
    assert steady_module._posed(system, None, None, other).performance.Cz == ((9,),)
    assert steady_module._posed(system, None, {"amplitude": 5, "omega": 1}, None).forcing.amplitude == (5,)


def row_of(evidence, *, alone):
    size, error = Bracket(1, 2), {"error": 0.0, "harmonics": 1, "residual": 0.0}
    return SteadyPoint(omega=1.0, amplitude=size, sigma=(), computed=1.0, evidence=evidence, alone=alone, **error)


@pytest.mark.parametrize(
    ("evidence", "alone", "caption"),
    [
        ("CERTIFIED", True, "Blue bars: certified at that frequency, from whatever start; between them nothing is."),
        ("CERTIFIED", False, "Orange and grey bars: steady responses that exist, certified, where others may."),
        ("COMPUTED", False, "Crosses: harmonic balance, in floating point."),
    ],
)
def test_a_figure_of_responses_says_which_are_certified(evidence, alone, caption):
    found = replace(steady(Verdict.INCONCLUSIVE), response=(row_of(Evidence[evidence], alone=alone),))
    assert ASKED["steady"].caption(found) == caption


BOTH = "a steady response of amplitude 0.3333333 to 0.6666667, and another of 3 to 4 (certified)"
PAST = "a steady response of amplitude 0.3333333 to 0.6666667 that repeats after 3 periods of it only, and so another,"


# Each solution with whether it is shown to exist, as a subharmonic or not; the last, whether two are apart
@pytest.mark.parametrize(
    ("kinds", "apart", "said"),
    [
        *(((None, None), True, ""), ((0,), True, ""), ((0, None), True, ""), ((0, 0), False, "")),
        *(((0, 0), True, BOTH), ((0, None, 0), True, BOTH), ((None, 1), False, PAST), ((1, 0), True, PAST)),
    ],
)
def test_two_steady_responses_refute_where_both_exist_and_are_apart(monkeypatch, kinds, apart, said):
    told = {
        "solutions": lambda *_: kinds,
        "existing": lambda _, kind: None if kind is None else SimpleNamespace(subharmonic=kind, apart=lambda _: apart),
        "multiplier": lambda *_: inf,
    }
    used = []

    def row(_, kind, shown, *_rest):
        size = Bracket(3, 4) if used else Bracket(1 / 3, 2 / 3)
        used.extend([1] * (shown is not None))
        return SimpleNamespace(omega=1.3, amplitude=size, periods=3 if kind else 1)

    for name, made in (told | {"_row": row}).items():
        monkeypatch.setattr(steady_module, name, made)
    asked = steady_module._posed(([1], [1, 1, 1]), "sigma^3", {"amplitude": 1, "omega": 1.3}, None)
    ((_, rows, found),) = steady_module._tried(asked)
    assert (len(rows), said in found, bool(found)) == (len(kinds), True, bool(said))


@pytest.mark.parametrize(
    ("verdict", "ends", "said"),
    [
        ("PROVED", (("2/3", "7/3"), ("1/3", "8/3")), ["Proved for phi, for which so, and every a in [1, 2]. "]),
        (
            "PROVED",
            (("2/3", "7/3"), ("1/3", "8/3")),
            ["in [0.6666667, 2.333333] (66.6 % wider), not in [0.3333333, 2.666667]"],
        ),
        (
            "INCONCLUSIVE",
            (("4/3", "5/3"), None),
            ["Undecided", "[1.333334, 1.666666] (66.7 % narrower), and nothing farther"],
        ),
        (
            "REFUTED",
            (None, ("1", "2")),
            ["Refuted for phi and some a in [1, 2]. ", "not in [1, 2] (as given) (certified)."],
        ),
        ("INCONCLUSIVE", (None, None), ["Undecided for phi and every a in [1, 2]. ", ": nothing is shown."]),
    ],
)
def test_tolerances_are_rounded_inwards(verdict, ends, said):
    boxes = [None if box is None else (tuple(map(Fraction, box)),) for box in ends]
    sides = [None if box is None else SimpleNamespace(assumed="so") for box in boxes]
    kept = dict(zip(("proved", "refuted", "proof", "refutation"), (*boxes, *sides), strict=True))
    margin = Margin(parameters=("a",), width=Bracket(0, inf), **kept)
    family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (1, 2)})
    found = Tolerances(family=family, verdict=Verdict[verdict], nonlinearity_class="phi", margins=(margin,))
    assert all(words in str(found) for words in said)
    assert ("certified" in str(found)) == any(ends)
    # without a margin, as when the time was over, what the box given is proved with is assumed all the same
    alone = replace(found, margins=(), stopped="time", shown=SimpleNamespace(assumed="so"))
    assert alone.assumed == "for which so" * (verdict == "PROVED")
    assert "How far" not in str(alone)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("b",), "b: may be in [0, 2] (as given), not in [0, 2.5] (25 % wider)"),
        (
            ("a", "b"),
            "all together: proved for a in [1, 2], b in [0, 2] (as given), "
            "not for all of a in [1, 2.5], b in [0, 2.5] (50 % wider)",
        ),
        (("a",), "a: may be in [1, 2] (as given), not in [1, 2.5] (50 % wider)"),
    ],
)
def test_of_several_parameters_each_range_has_its_name(names, said):
    family = PlantFamily.of_coefficients(["b"], [1, "a"], {"a": (1, 2), "b": (0, 2)})
    boxes = family.box, tuple((low, Fraction(5, 2)) for low, _ in family.box)
    margin = Margin(parameters=names, width=Bracket(1, inf), proved=boxes[0], refuted=boxes[1])
    assert margin.words(family) == said


def test_refuted_tolerances_are_of_no_smaller_class():
    family = PlantFamily.of_coefficients([1], [1, "a"], {"a": (Fraction(1, 3), 2)})
    said = str(tolerances(family, Sector(Fraction(-2, 3), Fraction(1, 3))))
    assert said.startswith(
        "Refuted for phi, time-invariant, in the sector [-0.6666667, 0.3333334] and some a in [1/3, 2]"
    )

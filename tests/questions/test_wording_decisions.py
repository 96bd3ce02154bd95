"""What a certificate is said to show, one decision at a time, of certificates that are made up."""

from fractions import Fraction as F
from types import SimpleNamespace

import pytest
from worded import PLAIN, shown

from lure import NonlinearityClass, RationalPlant, Saturation, Sector, as_plant
from lure.analysis import wording
from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import CONVERGES, MOVES, SLOPED
from lure.analysis.certificates.drafts import Failure
from lure.analysis.questions import conclusion as concluding
from lure.analysis.questions import max_sector
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.conclusion import (
    Certification,
    Conclusion,
    MismatchError,
    _above_the_critical_gain,
    _critical_gain,
    _end,
    _rests_at_zero_only,
    conclusion_of,
    undecided,
)
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Evidence, Verdict
from lure.analysis.wording import class_words, counterexample, destroys
from lure.classes import FULL_BLOCK
from lure.nonlinearities import DeadZone, PiecewiseLinear, Quantiser

PROVED, REFUTED, OPEN = Verdict.PROVED, Verdict.REFUTED, Verdict.INCONCLUSIVE
COMPOSED = next(one.name for one in concluding.TABLE if one.composed)
PERFORMANCE = {**PLAIN, "operator": "performance"}
OPERATOR = {**PLAIN, "operator": "norm-bounded"}
STEPS = {"method": "signal", "inputs": [["1"]] * 3, "slopes": ["1"]}
LEVEL = {"points": [["0", "0"], ["1", "0"]], "left": "0", "right": "0"}
RAMP = {"points": [["0", "0"]], "left": "2", "right": "2"}


def member(proof, *laws, repeated=False):
    channels = list(laws) or [PLAIN]
    return shown(MOVES, laws={"channels": channels, "repeated": repeated}, proof=proof)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (member({"method": "linear-members", "gains": ["2", "9"], "operators": []}, PLAIN, OPERATOR), "the gain 2"),
        (
            member({"method": "linear-members", "gains": ["2", "9"], "operators": [1]}, PLAIN, OPERATOR),
            "the gain 2 and all-pass operators",
        ),
        (member({"method": "linear-members", "gains": ["9"], "operators": [1]}, OPERATOR), "all-pass operators"),
        (member({"method": "linear-members", "gains": ["9"], "operators": []}, OPERATOR), "the linear loop"),
        (
            member({"method": "delayed-members", "delays": ["1/2", "2"], "gains": ["3", "9"]}, PLAIN, OPERATOR),
            "a delay of 0.5 and a delay of 2 and the gain 3",
        ),
        (member({"method": "delayed-members", "delays": ["1/2"], "gains": ["9"]}, OPERATOR), "a delay of 0.5"),
        (member(STEPS), "a disturbance of 3 samples, from rest,"),
        (member(STEPS | {"times": [1]}), "a disturbance of 3 steps, from rest,"),
        (member(STEPS | {"slopes": [[["1"], ["2"]]]}), "a disturbance of 3 samples, from rest, with gains that jump"),
        (
            member(
                {"method": "delayed-gains", "channel": 2, "delays": ["0", "1/2"], "gains": ["3", "9"]}, PLAIN, OPERATOR
            ),
            "a delay of 0.5 in channel 2 and the gains 3",
        ),
        (
            member({"method": "delayed-gains", "channel": 1, "samples": 4, "gains": ["9"]}, OPERATOR),
            "a delay of 4 samples in channel 1",
        ),
        (
            member(
                {"method": "linear-gains", "gains": ["3", "9"], "matrices": [[["1", "2"], ["0", "1"]]]}, PLAIN, OPERATOR
            ),
            "the gain 3 and the matrix of gains [1, 2; 0, 1]",
        ),
        (
            member({"method": "linear-gains", "gains": ["9"], "matrices": [[["1"]], [["2"]]]}, OPERATOR),
            "the matrix of gains [1] and the matrix of gains [2]",
        ),
        (
            member({"method": "ramped-gains", "gains": [["1"], ["2"], ["3"]]}),
            "from (1) to (2) and 1 more, over and over again",
        ),
        (
            member({"method": "relu-ray", "gains": [["1"], ["0"], ["1"]]}),
            "are (1), then (0), then (1), again and again",
        ),
        (
            member({"method": "relu-ray", "gains": [["1"]] * 4}),
            "are (1), then (1), then (1) and 1 more, again and again",
        ),
        (member({"method": "relu-ray", "gains": [["1"]]}), "that along which the gains are (1)"),
        (member({"method": "linear-gains", "gains": ["1"] * 8}, *[PLAIN] * 8), "the gains 1, 1, 1, 1, 1, 1, 1, 1"),
        (member({"method": "linear-gains", "gains": ["1"] * 9}, *[PLAIN] * 9), "the gain 1 in all of 9 channels"),
        (member({"method": "linear-gains", "gains": ["1"]}), "the gain 1"),
        (
            member({"method": "linear-gains", "gains": ["1", "2", "9"]}, PLAIN, PLAIN, PERFORMANCE),
            "the constant gains 1, 2",
        ),
        (
            member({"method": "linear-gains", "gains": ["1/3", "2", "9"]}, PLAIN, PLAIN, PERFORMANCE),
            "the constant gains about 0.33333, 2",
        ),
        (
            member(
                {"method": "memory-orbit", "gains": ["1/2", "2"], "durations": ["1", "1/2"]},
                {**PLAIN, "memory": "play"},
                PLAIN,
            ),
            "a play of slope 0.5, the gain 2, of any width, period 3 s",
        ),
        (
            member({"method": "orbit", "scale": "1/2", "u": ["1", "2", "3"]}),
            "a phi that is linear between 3 points and their multiples by powers of 0.5",
        ),
        (
            member({"method": "equilibrium", "nonlinearities": [RAMP, LEVEL]}),
            "phi = 2 sigma; a piecewise linear phi with 0 corners and slopes from 0 to 0",
        ),
        (
            member({"method": "sampled-orbit", "nonlinearities": [RAMP], "inputs": [1, 2, 3], "half": True}),
            "phi = 2 sigma, period 6 samples",
        ),
        (
            member({"method": "sampled-orbit", "nonlinearities": [RAMP], "inputs": [1, 2, 3], "half": False}),
            "phi = 2 sigma, period 3 samples",
        ),
        (
            member({"method": "flow-orbit", "nonlinearities": [RAMP, RAMP], "durations": ["1"], "half": True}),
            "phi = 2 sigma; phi = 2 sigma, period 2 s",
        ),
    ],
)
def test_a_member_is_named(found, said):
    assert counterexample(found).endswith(said)


# a part of the loop is one of its own: its channels by their numbers, its classes without the others
@pytest.mark.parametrize(
    ("channels", "kind", "proof", "said"),
    [
        ([2], "transfer", {"method": "linear-gain", "gain": "3"}, "phi = 3 sigma in channel 2"),
        ([1, 3], "multivariable", {"method": "linear-gains", "gains": ["1", "2"]}, "the gains 1, 2 in channels 1, 3"),
        (
            [2, 3],
            "multivariable",
            {"method": "linear-members", "gains": ["1", "2"], "operators": []},
            "the gain 2 in channels 2, 3",
        ),
    ],
)
def test_a_member_of_a_part_is_named_with_its_channels(channels, kind, proof, said):
    laws = {"channels": [PLAIN, OPERATOR, PLAIN], "repeated": [1, 1, 1]}
    found = shown(MOVES, laws=laws, proof={"method": "part", "channels": channels, "kind": kind, "proof": proof})
    assert counterexample(found) == said
    assert wording.method_of(found) == proof["method"]
    inner = wording._one(found).certificate
    assert ("channels" in inner["laws"]) is (kind == "multivariable")
    assert "channels" not in inner["laws"] or inner["laws"]["repeated"] == [1] * len(channels)


# a nonlinearity makes, several gains make
@pytest.mark.parametrize(
    ("found", "said"),
    [
        (member({"method": "linear-gains", "gains": ["1", "2"]}, PLAIN, PLAIN), "destabilise the loop"),
        (member({"method": "linear-gains", "gains": ["1"]}), "destabilises the loop"),
        (member({"method": "switched-gains", "gains": [["1"], ["2"]]}), "destabilise the loop"),
        (
            member({"method": "delayed-gains", "channel": 2, "samples": 1, "gains": ["3", "9"]}, PLAIN, OPERATOR),
            "destabilise the loop",
        ),
        (
            member({"method": "delayed-gains", "channel": 1, "samples": 1, "gains": ["9"]}, OPERATOR),
            "destabilises the loop",
        ),
        (member({"method": "linear-gains", "gains": ["9"], "matrices": [[["1"]]]}, OPERATOR), "destabilises the loop"),
        (
            member({"method": "linear-gains", "gains": ["9"], "matrices": [[["1"]]] * 2}, OPERATOR),
            "destabilise the loop",
        ),
        (member({"method": "relu-ray", "gains": [["1"]]}), "lets a solution grow without bound"),
        (member({"method": "orbit", "scale": "1/2", "u": ["1"]}), "makes the loop oscillate"),
    ],
)
def test_what_a_member_does_agrees_with_it(found, said):
    assert destroys(found) == said


@pytest.mark.parametrize(
    ("inwards", "rates", "said"),
    [
        (True, None, " for every a in [0.3333334, 0.6666666]"),
        (False, None, " for every a in [0.3333333, 0.6666667]"),
        (
            True,
            ["1/3", "0"],
            " for every a in [0.3333334, 0.6666666] that changes by at most 0.3333333 in a unit of time",
        ),
        (
            False,
            ["1/3", "0"],
            " for every a in [0.3333333, 0.6666667] that changes by at most 0.3333334 in a unit of time",
        ),
        (True, ["inf", "0"], " for every a in [0.3333334, 0.6666666] that changes at any speed"),
    ],
)
def test_plants_are_named_with_what_moves(inwards, rates, said):
    system = {"kind": "family", "parameters": [["a", "1/3", "2/3"], ["b", "1", "1"]]}
    system |= {} if rates is None else {"rates": rates}
    assert wording.plants_words(system, inwards=inwards) == said
    assert wording.plants_words({"kind": "transfer"}) == ""


THIRDS = {"sector": ["-1/3", "1/3"], "slope": None, "odd": False, "time_varying": False, "linear": False}


@pytest.mark.parametrize(
    ("laws", "proved", "refuted"),
    [
        ({"memory": "play", "slope": ["0", "1/3"]}, "play phi of a slope in [0, 0.3333333]", "[0, 0.3333334]"),
        ({"relu": True, "slope": ["0", "1"]}, "phi = max(sigma, 0)", "phi = max(sigma, 0)"),
        ({"relu": True, "slope": ["0", "1/3"]}, "phi = 0.3333333 max(sigma, 0)", "phi = 0.3333334 max(sigma, 0)"),
        (
            {"relu": True, "slope": ["1/3", "1"]},
            "phi = max(sigma, 0) + 0.3333334 min(sigma, 0)",
            "phi = max(sigma, 0) + 0.3333333 min(sigma, 0)",
        ),
        (THIRDS | {"rate": "2/3"}, "[-0.3333333, 0.3333333], its gain at a rate of at most 0.6666666", "0.6666667"),
        (THIRDS | {"operator": FULL_BLOCK}, "in the full-block sector [-0.3333333, 0.3333333]", "0.3333334]"),
    ],
)
def test_a_class_is_rounded_to_the_side_that_is_shown(laws, proved, refuted):
    assert class_words(laws).endswith(proved)
    assert class_words(laws, inwards=False).endswith(refuted)


# the gain from w to z is the inverse of its bound: one above it is proved, one below refuted
def test_bounds_of_operators_are_rounded_to_the_side_that_is_shown():
    norm, gain = ({**THIRDS, "operator": one} for one in ("norm-bounded", "performance"))
    gain["sector"] = ["-3/2", "3/2"]
    assert ("0.3333333" in class_words(norm), "0.3333334" in class_words(norm, inwards=False)) == (True, True)
    assert ("0.6666667" in class_words(gain), "0.6666666" in class_words(gain, inwards=False)) == (True, True)
    spelled = {F(1, 3): "a third"}
    assert "a third" in class_words(norm, spelled=spelled)
    assert wording.interval(["-inf", "1/3"], spelled=spelled) == "[-inf, a third]"


@pytest.mark.parametrize(
    ("repeated", "blocks"),
    [(False, [[0], [1], [2]]), (True, [[0, 1, 2]]), ([2, 1], [[0, 1], [2]]), ([1, 2], [[0], [1, 2]])],
)
def test_which_channels_have_the_same_nonlinearity(repeated, blocks):
    found = wording.same_in({"channels": [PLAIN] * 3, "repeated": repeated})
    assert [list(one) for one in found] == blocks


@pytest.mark.parametrize(
    ("conclusion", "subject", "said"),
    [
        ("0 attracts every motion", "", "The point 0 attracts every solution"),
        ("every motion is bounded, and a motion is", "", "Every solution is bounded, and a motion is"),
        ("every motion converges", "the rod", "Every motion of the rod converges"),
        ("every motion comes to rest", "", "Every motion comes to rest"),
        ("every motion tends to a zero of the law", "", "Every solution tends to a zero of the nonlinearity"),
    ],
)
def test_a_conclusion_is_in_the_words_of_the_field(conclusion, subject, said):
    assert wording.meaning(shown(conclusion), subject) == said


# 24 characters are read as they stand; more are a double's, or rounded beyond 60
@pytest.mark.parametrize(
    ("number", "said"),
    [
        ("1" * 24, "1" * 24),
        ("1" * 25, "1" * 25),
        (str(F(0.1)), "about 0.1"),
        ("1" * 60, "1" * 60),
        ("1" * 61, "about 1.11111111e+60"),
    ],
)
def test_long_numbers_are_rounded(number, said):
    assert wording.plain(f"up to {number}") == f"up to {said}"


def test_a_loop_is_told_with_long_parts_cut_off():
    certificate = {"convention": "C", "system": {"kind": "x", "A": "y" * 300}}
    assert wording.loop_words(certificate) == f"C; kind x, A {'y' * 300}"
    certificate["system"]["A"] = "y" * 301
    assert wording.loop_words(certificate | {"law": "tanh"}) == f"C; kind x, A {'y' * 300} ..., phi tanh"


@pytest.mark.parametrize(
    ("graph", "said"),
    [
        ({"points": [["-1", "-2"], ["1", "2"]], "left": "0", "right": "0"}, "a saturation with slope 2 up to +-1"),
        ({"points": [["-1", "-2"], ["1", "2"]], "left": "1", "right": "1"}, "with 2 corners and slopes from 1 to 2"),
        ({"points": [["-1", "0"], ["1", "0"]], "left": "3", "right": "3"}, "a dead zone of +-1 with slope 3"),
        ({"points": [["-1", "-2"], ["2", "2"]], "left": "0", "right": "0"}, "with 2 corners and slopes from 0 to"),
        ({"points": [["-1", "-1"], ["0", "0"], ["1", "1"]], "left": "0", "right": "0"}, "a saturation with slope 1"),
        ({"points": [["-1", "-2"], ["0", "0"], ["1", "1"]], "left": "0", "right": "0"}, "with 3 corners and slopes"),
        ({"points": [["0", "0"]], "left": "2", "right": "3"}, "with 1 corners and slopes from 2 to 3"),
        ({"points": [["1", "1"], ["0", "0"], ["-1", "-1"]], "left": "1", "right": "0"}, "with 1 corners and slopes"),
    ],
)
def test_a_graph_is_named(graph, said):
    found = wording._graph(graph)
    assert found.startswith(said) or found.startswith(f"a piecewise linear phi {said}")


def test_a_direct_term_is_the_quotient_of_the_first_coefficients():
    transfer = {"kind": "transfer", "numerator": ["3", "1"], "denominator": ["2", "1"]}
    assert wording.direct_term(transfer) == F(3, 2)
    assert wording.direct_term(transfer | {"denominator": ["2", "1", "1"]}) == 0
    assert wording.direct_term({"kind": "state-space", "d": "1/3"}) == F(1, 3)
    assert wording.direct_term(transfer | {"kind": "delay"}) == 0


# what follows ---------------------------------------------------------------------------------------------------------


THIRD = RationalPlant([1], [1, 3, 2, 0])


@pytest.mark.parametrize(
    ("top", "said"), [("finite", "every finite bound"), ("inf", "up to inf"), ("1/3", "up to 0.3333333")]
)
def test_the_end_of_a_larger_class(top, said):
    assert _end(SimpleNamespace(certificate={"laws": {**PLAIN, "sector": ["0", top]}})) == said


@pytest.mark.parametrize(
    ("theorem", "multiplier", "gain"),
    [(next(iter(SLOPED)), {}, -1), ("circle", {"mirrored": True}, 2), ("circle", {}, 0)],
)
def test_the_gain_by_which_a_proof_shifts_the_loop(theorem, multiplier, gain):
    found = shown(theorem=theorem, laws={**PLAIN, "slope": ["-1", "3"]}, multiplier=multiplier)
    assert _critical_gain(found) == gain


@pytest.mark.parametrize(
    ("conclusion", "theorem", "sector", "above"),
    [
        (CONVERGES, next(iter(SLOPED)), ["1", "2"], True),
        (CONVERGES, next(iter(SLOPED)), ["0", "2"], False),
        (CONVERGES, "circle", ["1", "2"], False),
        ("0 attracts every motion", next(iter(SLOPED)), ["1", "2"], False),
    ],
)
def test_0_is_the_only_equilibrium_where_the_sector_begins_above_the_critical_gain(conclusion, theorem, sector, above):
    laws = {**PLAIN, "sector": sector, "slope": ["0", "2"]}
    assert _above_the_critical_gain(shown(conclusion, theorem, laws=laws)) is above
    several = {"channels": [laws], "repeated": False}
    assert not _above_the_critical_gain(shown(conclusion, theorem, laws=several))


CRITICAL = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "0"]}
SETS = "every motion converges to the set of equilibria"


# phi(sigma) = l sigma at 0 only: a saturation, not a dead zone; with l = 1 a saturation is sigma up to its limit
@pytest.mark.parametrize(
    ("phi", "more", "only"),
    [
        (Saturation(gain=1, limit=1), {}, True),
        (DeadZone(width=1), {}, False),
        (Saturation(gain=1, limit=1), {"laws": {**PLAIN, "sector": ["1", "2"]}}, False),
        (Saturation(gain=2, limit=1), {"laws": {**PLAIN, "sector": ["-1", "2"]}}, True),
        (Saturation(gain=1, limit=1), {"system": CRITICAL | {"kind": "rod"}}, False),
        (Saturation(gain=1, limit=1), {"conclusion": CONVERGES}, False),
    ],
)
def test_where_a_nonlinearity_rests_at_0_only(phi, more, only):
    given = {"conclusion": SETS, "theorem": "circle", "system": CRITICAL, "multiplier": {}}
    assert _rests_at_zero_only((phi,), shown(**given | more)) is (only or (more.get("conclusion") == SETS))
    laws = {"channels": [PLAIN, {**PLAIN, "slope": ["-1", "2"]}], "repeated": False}
    several = shown(SETS, "circle", laws=laws, system={"kind": "multivariable"}, multiplier={})
    assert _rests_at_zero_only((phi, Saturation(gain=1, limit=1)), several) is (not isinstance(phi, DeadZone))


def test_nothing_follows_from_a_certificate_of_another_loop():
    proof = max_sector(THIRD).proof
    asked = Problem.about(RationalPlant([1], [1, 1]), NonlinearityClass(sector=Sector(0, 1)))
    with pytest.raises(MismatchError, match="about another system"):
        conclusion_of(asked, proof)
    same = Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 1)))
    with pytest.raises(MismatchError, match="no proof and no refutation"):
        conclusion_of(same, SimpleNamespace(certificate=proof.certificate))
    assert conclusion_of(same, None).reason == "nothing was accepted by the checker"
    larger = conclusion_of(same, proof, larger=proof)
    assert larger.sentence.endswith(f"(certified), which proves {_end(proof)}.")
    assert conclusion_of(same, proof).sentence.endswith("(certified).")


def test_what_is_undecided_names_the_class_the_plants_and_the_nonlinearity():
    phi = Saturation(gain=1, limit=1)
    asked = Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 1)), nonlinearity=phi)
    found = undecided(asked, "why", code=codes.PRECISION, evidence=Evidence.COMPUTED)
    head = "Nothing is decided for phi, time-invariant, in the sector [0, 1], nor for saturation min(max(sigma, -1), 1)"
    assert (found.headline, found.evidence) == (f"{head}.", Evidence.COMPUTED)
    assert found.sentence == f"{head}: why ({codes.PRECISION.identifier})."
    alone = undecided(Problem.about(THIRD, NonlinearityClass(sector=Sector(0, 1))), "why")
    assert alone.headline == "Nothing is decided for phi, time-invariant, in the sector [0, 1]."


def test_a_verdict_has_a_certificate_and_what_is_open_has_none():
    given = {"evidence": Evidence.CERTIFIED, "headline": "", "sentence": "said"}
    for verdict, proof in ((PROVED, None), (REFUTED, None), (OPEN, shown())):
        with pytest.raises(TypeError, match="do not fit together"):
            Conclusion(verdict=verdict, shown=proof, **given)


# the claim of a scheme or of the rod itself is without load; what is open has its code
@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("transfer", "PROVED: a claim"),
        ("rod", "PROVED: without load, a claim"),
        ("rod-scheme", "PROVED: of the upwind scheme without load, a claim"),
        (None, f"INCONCLUSIVE ({codes.PRECISION}): a claim"),
    ],
)
def test_a_certification_is_told(kind, said):
    given = {"evidence": Evidence.CERTIFIED, "headline": "", "sentence": "said"}
    if kind is None:
        one = Conclusion(verdict=OPEN, code=codes.PRECISION, **given)
    else:
        one = Conclusion(verdict=PROVED, shown=shown(system={"kind": kind}), **given)
    failure = Failure(search="a search", code=codes.RESIDUE, detail="no")
    found = Certification(conclusion=one, detail="a claim", failures=(failure,))
    assert str(found) == said
    assert (found.certificate is None) is (kind is None)
    if kind is None:
        assert f"{codes.PRECISION.identifier}, {codes.PRECISION.title}" in found._repr_html_()
        assert "Searches that showed nothing" in found._repr_html_()
        assert "Searches that" not in Certification(conclusion=one, detail="a claim")._repr_html_()


WIDE = {**PLAIN, "sector": ["0", "17/3"]}  # 17/3 = 5.666..., of which less is said
ABOUT = "phi, time-invariant, in the sector [0, 5.666666]"
REST = "Every solution converges to the set of equilibria"


def follows(phi=None, high=5, larger=None, **more):
    asked = Problem.about(THIRD, NonlinearityClass(sector=Sector(0, high)), nonlinearity=phi)
    given = {"conclusion": SETS, "theorem": "popov", "laws": WIDE, "system": dict(asked.system), "multiplier": {}}
    assumed = more.pop("assumed", "")
    proof = shown(**given | more)
    proof.assumed = assumed
    return concluding._proved(asked, proof, larger)


SATURATION = "saturation min(max(sigma, -1), 1)"
DEAD = "dead zone of |sigma| <= 1, then slope 1"


# what is proved of a class is said of it, of a member by name; an assumption stands beside what it is assumed of
@pytest.mark.parametrize(
    ("given", "head", "after", "attracts", "assumed"),
    [
        ({}, f"{REST} for every {ABOUT}", "", False, ()),
        (
            {"assumed": "x holds", "theorem": "circle"},
            f"{REST} for every {ABOUT} for which x holds",
            *("", False, ("x holds",)),
        ),
        (
            {"phi": Saturation(gain=1, limit=1)},
            f"Every solution converges to 0 with {SATURATION}",
            f": every solution converges to the set of equilibria for every {ABOUT} (the nonlinearity is checked to be "
            "one), and it vanishes at 0 only",
            True,
            (),
        ),
        (
            {"phi": DeadZone(width=1)},
            f"{REST} with {DEAD}",
            f", as for every {ABOUT} (the nonlinearity is checked to be one)",
            False,
            (),
        ),
        (
            {"phi": DeadZone(width=1), "conclusion": "0 attracts every motion"},
            f"The point 0 attracts every solution with {DEAD}",
            f", as for every {ABOUT} (the nonlinearity is checked to be one)",
            True,
            (),
        ),
        (
            {"conclusion": CONVERGES, "theorem": next(iter(SLOPED)), "laws": {**WIDE, "slope": ["-1", "17/3"]}},
            "Every solution converges to 0 for every phi with slope in [-1, 5.666666], in the sector [0, 5.666666]",
            "",
            True,
            (),
        ),
    ],
)
def test_what_is_proved_is_said(given, head, after, attracts, assumed):
    if "slope" in str(given.get("laws")):
        asked = Problem.about(THIRD, NonlinearityClass.slope_restricted(0, 5))
        proof = shown(**given, system=dict(asked.system), multiplier={})
        proof.assumed = ""
        found = concluding._proved(asked, proof, None)
    else:
        found = follows(**given)
    by = given.get("theorem", "popov")
    assert (found.headline, found.attracts, found.assumed) == (f"{head}.", attracts, assumed)
    assert found.sentence == f"{head}{after}, by the criterion {by} (certified)."
    assert found.membership == ("checked" if "phi" in given else "")
    assert found.verdict is PROVED
    if "laws" not in given:
        assert str(follows(**given, larger=shown())) == f"{found.sentence[:-1]}, which proves up to 2."


# of play the class is no part of what is proved; of a quantiser regularity is missing alone
@pytest.mark.parametrize(
    ("given", "code", "said"),
    [
        ({"high": 6}, codes.NO_MULTIPLIER, f"what is proved is about {ABOUT}, which does not contain the class asked"),
        (
            {"phi": Quantiser(step=1)},
            codes.NOT_LIPSCHITZ,
            f"what is proved is about {ABOUT}, and mid-tread quantiser of step 1 is not known to be locally Lipschitz",
        ),
        ({"theorem": COMPOSED, "assumed": "x"}, codes.SEVERAL_SOLUTIONS, "which the class does not promise; slope"),
    ],
)
def test_what_is_not_proved_is_not_said(given, code, said):
    found = follows(**given)
    assert (found.verdict, found.code) == (OPEN, code)
    assert said in found.reason


# x + phi(x)/2 = y has one solution for slopes from 0 to 1: nothing is left to assume
@pytest.mark.parametrize(
    ("direct", "phi", "theorem", "said"),
    [
        ("1/2", Saturation(gain=1, limit=1), "circle", ()),
        ("-1/2", Saturation(gain=1, limit=1), "circle", ()),
        ("-2", Saturation(gain=1, limit=1), "circle", "some y have several"),
        ("-1", Saturation(gain=1, limit=1), "circle", "some y have several"),
        ("-1/2", Saturation(gain=1, limit=1), COMPOSED, ()),
    ],
)
def test_what_slopes_show_is_not_assumed(direct, phi, theorem, said):
    plant = RationalPlant([F(direct), 1], [1, 1])
    asked = Problem.about(plant, NonlinearityClass(sector=Sector(0, 1)), nonlinearity=phi)
    proof = shown(theorem=theorem, laws=dict(asked.class_entry), system=dict(asked.system), multiplier={})
    proof.assumed = "some y have one"
    found = concluding._proved(asked, proof, None)
    if said:
        assert (found.verdict, found.code) == (OPEN, codes.SEVERAL_SOLUTIONS)
        assert said in found.reason
    else:
        assert (found.verdict, found.assumed) == (PROVED, ())


# slopes of 2 and more, of which 1 - slope/2 is 0 or below: sigma - phi(sigma)/2 is constant on a piece
def test_a_graph_that_is_constant_on_a_piece_has_no_one_solution():
    steep = PiecewiseLinear([(0, 0), (1, 4)], left_slope=2, right_slope=2)
    assert concluding._takes_a_value_twice(steep, shown(system={"kind": "state-space", "d": "-1/2"}))
    assert not concluding._takes_a_value_twice(steep, shown(system={"kind": "state-space", "d": "-1"}))


def test_members_of_several_classes_are_said_in_the_plural():
    plant = as_plant(([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]]))
    asked = channel_problem(plant, [Saturation(gain=1, limit=1)] * 2)
    proof = shown(laws=dict(asked.class_entry), system=dict(asked.system), multiplier={})
    proof.assumed = ""
    found = concluding._proved(asked, proof, shown())
    assert "(each nonlinearity is checked to be one), by the criterion circle (certified)." in found.sentence

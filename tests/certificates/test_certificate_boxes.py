"""Certificates about every plant of a box of parameters: both checkers, and what neither may accept."""

import json
from fractions import Fraction
from importlib import resources

import jsonschema
import pytest

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.systems import system_of
from lure.plants.family import PlantFamily
from tests.support.tampering import assert_both_reject, edited

SCHEMA = json.loads(resources.files("lure.analysis.certificates").joinpath("schema.json").read_text("utf-8"))
SECOND = PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 2), "b": (Fraction(1, 2), 1)})
LAWS = {"sector": ["0", "3"], "slope": None, "odd": False, "time_varying": False, "linear": False}
CUT = {"parameter": 0, "at": "3/2", "below": {"multiplier": {"theta": "1"}}, "above": {"multiplier": {"theta": "2"}}}


def draft(family=SECOND, theorem="popov", tree=None, **laws):
    proof = {"method": "boxes", "boxes": CUT if tree is None else tree}
    return {"verdict": "PROVED", "system": system_of(family), "laws": LAWS | laws, "theorem": theorem, "proof": proof}


def refusal(family, at, gain):
    proof = {"method": "member", "at": at, "proof": {"method": "linear-gain", "gain": gain}}
    return {
        **{"verdict": "REFUTED", "system": system_of(family), "laws": LAWS | {"sector": ["0", gain]}},
        **{"theorem": "counterexample", "proof": proof},
    }


@pytest.fixture(scope="module")
def proof():
    return complete_and_check(draft()).certificate


def test_both_accept_two_boxes_and_say_for_which_plants(proof):
    jsonschema.Draft202012Validator(SCHEMA).validate(dict(proof))
    shown = check(dict(proof))
    assert isinstance(shown, Proved)
    assert "a in [1, 2], b in [1/2, 1]" in shown.claim
    assert recheck(proof).accepted


# F of the circle criterion for b/(s^2 + s + a), [0, k]: |d|^2 + k b (a - x), x = omega^2, |d|^2 = (a - x)^2 + x.  It is
# least, over x, at x = a + (k b - 1)/2, where it is a - (1 - k b)^2/4: positive for k b < 1 + 2 sqrt(a), first lost at
# a = b = 1: k < 3.  So the circle proves [0, 2.99] for all of the box, and [0, 3] of no box with that corner.
def test_the_circle_criterion_is_sharp_at_the_corner_it_fails_first():
    found = complete_and_check(draft(theorem="circle", tree={"multiplier": {}}, sector=["0", "2999/1000"]))
    assert recheck(found.certificate).accepted
    assert_both_reject(edited(found.certificate, "laws", "sector", 1, value="3"))
    assert_both_reject(edited(found.certificate, "proof", "boxes", "multiplier", value={"mirrored": True}))


def test_a_wide_box_needs_more_than_one():
    wide = PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 8), "b": (Fraction(1, 2), 1)})
    cuts = {"multiplier": {}}
    for at in ("6", "4", "3", "2"):
        cuts = {"parameter": 0, "at": at, "below": {"multiplier": {}}, "above": cuts}
    one, more = (draft(wide, "circle", tree, sector=["0", "5/2"]) for tree in ({"multiplier": {}}, cuts))
    with pytest.raises(Rejected, match="F > 0"):
        complete_and_check(one)
    assert recheck(complete_and_check(more).certificate).accepted


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proof", "boxes"), {"multiplier": {"theta": "-1"}}),
        (("proof", "boxes", "below"), {}),
        (("proof", "boxes", "below"), None),
        (("proof", "boxes", "at"), "2"),
        (("proof", "boxes", "at"), "1"),
        (("proof", "boxes", "parameter"), 2),
        (("proof", "boxes", "above", "multiplier", "theta"), "-1/2"),
        (("system", "parameters", 0, 1), "-1"),  # a box with an unstable plant
        (("system", "parameters", 0, 2), "1"),  # no interval
        (("system", "parameters", 1, 0), "a"),
        (("system", "terms", 0, "denominator", 1), "-1"),
        (("system", "terms", 0, "denominator", 0), "0"),
        (("system", "terms", 0, "numerator", 0), "1"),  # a direct term
        (("system", "terms", 1, "powers", 1), -1),
        (("system", "terms", 1, "powers"), [0]),
        (("multiplier",), {"theta": "1"}),
        (("theorem",), "zames-falb"),
        (("laws", "time_varying"), True),
    ],
)
def test_neither_accepts_a_change(proof, path, value):
    assert_both_reject(edited(proof, *path, value=value))


# without the kernel F is that of Popov's criterion, which holds; the kernel's own part is no polynomial in omega
def test_neither_accepts_a_kernel_that_is_a_delay():
    kernels = [{"coefficient": "1/4", "delay": "1"}]
    tree = {"multiplier": {"theta": "2", "kernels": kernels}}
    sharp = draft(theorem="zames-falb", tree=tree, sector=["0", "1"], slope=["0", "1"])
    with pytest.raises(Rejected, match="kernels that are delays"):
        complete_and_check(sharp)
    lagging = [{"coefficient": "1/4", "rate": "1", "order": 1, "side": "causal"}]
    found = complete_and_check(edited(sharp, "proof", "boxes", "multiplier", "kernels", value=lagging)).certificate
    assert_both_reject(edited(found, "proof", "boxes", "multiplier", "kernels", value=kernels))


def test_neither_accepts_a_box_that_is_left_out_or_made_wider(proof):
    # b up to 10 keeps F > 0 by Popov's multiplier; a from 1/100 on does not with these two
    assert_both_reject(edited(edited(proof, "system", "parameters", 0, 1, value="-1/100"), "hypotheses", value={}))
    alone = edited(proof, "proof", "boxes", value=lambda tree: {**tree, "above": {}})
    assert_both_reject(alone)
    with pytest.raises(Rejected, match="hypotheses"):
        check(edited(proof, "hypotheses", "parameters", value="for all constant a"))


# b/(s (s + a)) with a in [1, 2]: d(0) = 0 for every a, residue b/a: convergence to the set of equilibria, by Popov
def test_a_pole_at_zero_of_all_plants_is_the_critical_case_and_one_that_moves_is_none():
    box = {"a": (1, 2), "b": (1, 2)}
    steady = PlantFamily.of_formula("b/(s*(s+a))", box)
    found = complete_and_check(draft(steady, tree={"multiplier": {"theta": "2"}}))
    assert found.claim.startswith("every motion converges to the set of equilibria")
    assert recheck(found.certificate).accepted
    moving = PlantFamily.of_formula("b/((s+b-1)*(s+a))", box)
    with pytest.raises(Rejected):
        complete_and_check(draft(moving, tree={"multiplier": {"theta": "2"}}))
    negative = PlantFamily.of_formula("(b - 1.5)/(s*(s+a))", box)
    with pytest.raises(Rejected):
        complete_and_check(draft(negative, tree={"multiplier": {"theta": "2"}}))


def test_a_resonance_inside_the_box_is_not_overlooked():
    # (s^2 + a)^2-like: d = s^2 + (b - 1)^2 s + 1 is on the axis for b = 1 alone, a point inside the box [0, 2]
    family = PlantFamily.of_coefficients(["a"], [1, "b^2 - 2*b + 1", 1], {"a": (1, 2), "b": (0, 2)})
    for tree in (
        {"multiplier": {"theta": "1"}},
        {"parameter": 1, "at": "2/3", **{n: {"multiplier": {"theta": "1"}} for n in ("below", "above")}},
    ):
        with pytest.raises(Rejected):
            complete_and_check(draft(family, tree=tree, sector=["0", "1/1000"]))


def test_a_refutation_names_one_plant_of_the_box():
    # b/((s+1)(s+a)(s+2)) with a = b = 1: d = (s+1)^2 (s+2), Routh: k = 18 at the limit
    family = PlantFamily.of_formula("b/((s+1)*(s+a)*(s+2))", {"a": (1, 2), "b": (1, 2)})
    found = complete_and_check(refusal(family, ["1", "1"], "18"))
    assert isinstance(found, Refuted)
    assert found.facts["parameters"] == "a = 1, b = 1"
    jsonschema.Draft202012Validator(SCHEMA).validate(dict(found.certificate))
    assert recheck(found.certificate).accepted
    for path, value in (
        (("proof", "at"), ["1/2", "1"]),  # outside
        (("proof", "at"), ["2", "1"]),  # a plant that is stable: 36 > 18
        (("proof", "at"), ["1"]),
        (("proof", "proof", "gain"), "17"),
        (("proof", "proof"), {"method": "member", "at": ["1", "1"], "proof": found.certificate["proof"]["proof"]}),
    ):
        assert_both_reject(edited(found.certificate, *path, value=value))


# What holds at every node of a box and fails between two of them: c(p) = 1 - 64 (p - 1/8)^2 is 1 at 1/8, and not
# positive at 0, 1/4, 1/2, 3/4, 1.
PEAK, DIP = "64*(p - 1/8)^2 - 1", "64*(p - 1/8)^2 - 1/2"


@pytest.mark.parametrize(
    ("plants", "theorem", "multiplier", "end", "conclusion"),
    [
        # -c/(s + 1): with the gain 3/2 the pole is at 3/2 - 1 > 0 for p = 1/8
        (([PEAK], [1, 1], {"p": (0, 1)}), "circle", {}, "3/2", "0 attracts every motion"),
        # n/(s (s + 1)) with n(1/8) = -1/2: F > 0 for small gains, and the residue is negative
        (
            *(([DIP], [1, 1, 0], {"p": (0, 1)}), "popov", {"theta": "1"}, "1/10"),
            "every motion converges to the set of equilibria",
        ),
        # H = 0, whose F is 0 for every bound; the plant swings for ever where p = 1
        (([0], [1, "(p - 1)^2", 1], {"p": (0, 2.25)}), "circle", {}, "finite", "0 attracts every motion"),
    ],
)
def test_neither_overlooks_what_fails_between_the_nodes(proof, plants, theorem, multiplier, end, conclusion):
    family = PlantFamily.of_coefficients(*plants)
    one = draft(family, theorem, {"multiplier": multiplier}, sector=["0", end])
    assert_both_reject({**proof, **one, "conclusion": conclusion})

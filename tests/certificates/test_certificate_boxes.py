"""Certificates about every plant of a box of parameters: both checkers, and what neither may accept."""

from contextlib import nullcontext
from fractions import Fraction
from itertools import product
from math import comb, prod

import pytest
from certificate_format import FORMAT
from flint import fmpq_mat

from lure.analysis.certificates import boxes
from lure.analysis.certificates.arithmetic import Form, Malformed, Rejected, real
from lure.analysis.certificates.blocks import block
from lure.analysis.certificates.checker import Proved, Refuted, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import boxes as second
from lure.analysis.certificates.second import channel_boxes
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.systems import system_of
from lure.plants.family import PlantFamily
from tests.support.tampering import assert_both_reject, edited, refused_again

SECOND = PlantFamily.of_coefficients(["b"], [1, 1, "a"], {"a": (1, 2), "b": (Fraction(1, 2), 1)})
LAWS = {"sector": ["0", "3"], "slope": None, "odd": False, "time_varying": False, "linear": False}
LOWER, SECTOR, ALPHA = ("laws", "sector", 0), ("laws", "sector", 1), ("proof", "boxes", "multiplier", "alpha")
A_LOW, A_HIGH = (("system", "parameters", 0, end) for end in (1, 2))
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
    FORMAT.validate(dict(proof))
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
        (("proof", "boxes", "below", "parameter"), 0),
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


# b/(z - a): 1/k - b/(1 + a) > 0 at z = -1, k < 5/4 for a = 1/4 and b = 1, and with a = 1 k < 2; b/(s^2 + s + a) beyond
# the 3 of the circle
@pytest.mark.parametrize(
    ("plants", "theorem", "multiplier", "end", "edits"),
    [
        ((["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (0.5, 1)}, 1), "circle", {}, "124/100", [(SECTOR, "125/100")]),
        ((["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (0.5, 1)}, 1), "circle", {}, "124/100", [(A_LOW, "1/5")]),
        ((["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (0.5, 1)}, 1), "circle", {}, "124/100", [(A_HIGH, "1")]),
        ((["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (0.5, 1)}, 1), "circle", {}, "124/100", [(A_HIGH, "2")]),
        ((["b"], [1, -1], {"b": (0.5, 1)}, 1), "circle", {}, "199/100", [(SECTOR, "2")]),
        ((["b"], [1, -1], {"b": (0.5, 1)}, 1), "circle", {}, "199/100", [(A_LOW, "-1/100"), (SECTOR, "1/100")]),
        ((["b"], [1, -1], {"b": (0.5, 1)}, 1), "circle", {}, "199/100", [(A_LOW, "0"), (SECTOR, "1/100")]),
        ((["b"], [1, 1, "a"], {"a": (1, 1.1), "b": (0.9, 1)}), "off-axis-circle", {"alpha": "1"}, "5", [(ALPHA, "-1")]),
        # b/(s + a), and b/(z - a), are stable down to the gain -1 and -1/2, for a = b = 1 and a = 1/2, b = 1
        ((["b"], [1, "a"], {"a": (1, 2), "b": (0.5, 1)}), "circle", {}, "2", [(LOWER, "-99/100"), (LOWER, "-101/100")]),
        (
            *((["b"], [1, "-a"], {"a": (0.25, 0.5), "b": (0.5, 1)}, 1), "circle", {}, "1"),
            [(LOWER, "-49/100"), (LOWER, "-51/100")],
        ),
        # b/(a s + 1), whose pole goes to infinity
        ((["b"], ["a", 1], {"a": (1, 2), "b": (0.5, 1)}), "circle", {}, "1/10", [(A_LOW, "0")]),
        ((["b"], ["a", 1], {"a": (1, 2), "b": (0.5, 1)}), "circle", {}, "1/10", [(SECTOR, "inf")]),
        ((["b"], [1, 1, "a"], {"a": (1, 1.1), "b": (0.9, 1)}), "off-axis-circle", {"alpha": "1"}, "5", [(ALPHA, "0")]),
    ],
)
def test_boxes_in_discrete_time_and_off_the_axis_are_sharp(plants, theorem, multiplier, end, edits):
    slope = ["0", end] if theorem == "off-axis-circle" else None
    given = draft(
        PlantFamily.of_coefficients(*plants), theorem, {"multiplier": multiplier}, sector=["0", end], slope=slope
    )
    found = complete_and_check(given).certificate
    assert recheck(found).accepted
    for i, (path, value) in enumerate(edits):
        found = edited(found, *path, value=value)
        if path == LOWER and i == 0:
            found = complete_and_check(found).certificate
            assert recheck(found).accepted
    assert_both_reject(found)


# exp(-t s)/(s + a): |H| <= 1, so that [0, 1/2] is proved; the forms of a box are those of the plant without feedback
@pytest.mark.parametrize("lower", ["1/10", "-1/10"])
def test_beside_parameters_and_dead_time_the_classes_begin_at_zero(lower):
    family = PlantFamily.of_formula("exp(-t*s)/(s + a)", {"a": (1, 2), "t": (0, 1)})
    found = complete_and_check(draft(family, "circle", {"multiplier": {}}, sector=["0", "1/2"]))
    assert recheck(found.certificate).accepted
    with pytest.raises(Rejected, match="the classes begin at 0"):
        complete_and_check(draft(family, "circle", {"multiplier": {}}, sector=[lower, "1/2"]))
    assert refused_again(edited(found.certificate, "laws", "sector", 0, value=lower))


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
    FORMAT.validate(dict(found.certificate))
    assert recheck(found.certificate).accepted
    for path, value in (
        (("proof", "at"), ["1/2", "1"]),  # outside
        (("proof", "at"), ["2", "1"]),  # a plant that is stable: 36 > 18
        (("proof", "at"), ["1"]),
        (("proof", "method"), "one"),
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


F = Fraction
NAMES = [["p", "1/2", "3"], ["q", "-1", "2"]]
LATE = {
    **{"kind": "delay-family", "time": "continuous", "parameters": NAMES, "delay": ["4", "1", "-2"]},
    "terms": [
        {"powers": [0, 0], "numerator": ["0", "1", "2"], "denominator": ["1", "3", "5"]},
        {"powers": [1, 2], "numerator": ["0", "0", "4"], "denominator": ["2", "1", "0"]},
        {"powers": [3, 0], "numerator": ["0", "6", "0"], "denominator": ["0", "1", "1"]},
    ],
}
ROWS = [{side: [[str(3 * i + k + 1)]] for k, side in enumerate("ABCD")} for i in range(2)]
SEVERAL = {
    **{"kind": "varying-family", "time": "continuous", "parameters": NAMES, "rates": ["1", "0"]},
    "terms": [
        {"powers": [0, 0], "common": "2", **ROWS[0]},
        {"powers": [2, 1], "common": "3", **ROWS[1], "D": [["-9"]]},
        {"powers": [1, 0], "common": "0", "A": [["7"]], "B": [["0"]], "C": [["0"]], "D": [["0"]]},
    ],
}


def value(p, t):
    """A polynomial in several t at one of them, in the arithmetic of the second checker."""
    weighed = [
        second.to_fmpq(prod((v**i for v, i in zip(t, powers, strict=True)), start=F(1))) * c for powers, c in p.items()
    ]
    return sum(weighed[1:], weighed[0])


def test_the_second_checker_has_the_same_plants_of_a_box():
    late, several = second.read_plants(LATE), channel_boxes.read_plants(SEVERAL)
    point = [F(2), F(3, 2)]
    assert (late.waits(late.box), late.degrees) == ((F(1, 2), 9), (3, 2))
    assert late.at(point) == boxes.plants(LATE).at(point)
    one, found = boxes.matrices(SEVERAL).plant(point), several.at(point)
    assert [[[F(v) for v in row] for row in found[name]] for name in "ABCD"] == [one.A, one.B, one.C, one.D]
    assert (several.pattern, several.rates) == (fmpq_mat([[1]]), (1, 0))
    # within a part of the box: p = 3/4 + t_1/2, q = -1/2 + 2 t_2
    part, t = ((F(3, 4), F(5, 4)), (F(-1, 2), F(3, 2))), (F(1, 3), F(3, 5))
    point = [F(3, 4) + t[0] / 2, F(-1, 2) + 2 * t[1]]
    ((_, top),) = late.at(point)["terms"]
    for side, own in zip(late.within(part), (top, late.at(point)["denominator"]), strict=True):
        assert value(side, t) == second.from_descending([F(v) for v in own])
    c, *rest = (value(side, t) for side in several.within(part))
    for side, own in zip(rest, (several.at(point)[name] for name in "ABCD"), strict=True):
        assert side / c[0, 0] == fmpq_mat([[second.to_fmpq(F(v)) for v in row] for row in own])


def test_a_polynomial_is_a_mean_of_its_bernstein_coefficients():
    p = {(0, 0): F(1), (3, 0): F(-5), (1, 2): F(7), (2, 1): F(1, 3)}
    direct = [
        sum(c * F(comb(i, a) * comb(j, b), comb(3, a) * comb(2, b)) for (a, b), c in p.items())
        for i, j in product(range(4), range(3))
    ]
    assert sorted(second.bernstein(p, (3, 2))) == sorted(direct)


def test_one_plant_of_a_box_has_the_powers_of_its_parameters():
    H, p, q = boxes.plants(LATE), F(2), F(3, 2)
    assert H.waits(H.box) == (F(1, 2), 9)  # 4 + p - 2 q
    assert H.degrees == [3, 2]
    one, pq = H.at([p, q]), p * q**2
    assert one["terms"] == [["3", [str(1 + 6 * p**3), str(2 + 4 * pq)]]]
    assert one["denominator"] == [str(1 + 2 * pq), str(3 + pq + p**3), str(5 + p**3)]
    found, other = H.block([p, q], F(3)), block(one)
    assert (found.n, found.d, found.order, found.delayed) == (other.n, other.d, 2, True)
    sampled = LATE | {"kind": "family", "time": "discrete"}
    del sampled["delay"]
    H = boxes.plants(sampled)
    assert H.block([p, q], F(3))._replace(direct=F(0)) == block(H.at([p, q]))
    several = boxes.matrices(SEVERAL)
    c, Q = 2 + 3 * p**2 * q, p**2 * q
    one = several.plant([p, q])
    assert (
        [[(1 + 4 * Q + 7 * p) / c]],
        [[(2 + 5 * Q) / c]],
        [[(3 + 6 * Q) / c]],
        [[(4 - 9 * Q) / c]],
    ) == (one.A, one.B, one.C, one.D)
    assert several.pattern == [[13]]
    assert several.common([p, q]) == c
    unit, common, *rows = boxes.Integers.of(several).at([p, q])
    assert F(common) / unit == c
    assert [[F(v) / unit for v in row] for row in rows] == [
        [c * one.A[0][0], -c * one.B[0][0]],
        [c * one.C[0][0], -c * one.D[0][0]],
    ]
    # the degrees of c, (A, B), (C, D) are 2, 2, 2 in p: c (A, B) has 4, and with P(p) one or two more
    assert [several.degrees(*both) for both in ((False, False), (False, True), (True, True))] == [
        [4, 2],
        [5, 3],
        [5, 3],
    ]
    for theta, fine in (([F(0)], True), ([F(1)], False)):
        with nullcontext() if fine else pytest.raises(Rejected, match="sigma changes"):
            several.still(theta)
    several._replace(rates=[F(0), F(0)]).still([F(1)])


@pytest.mark.parametrize(
    ("system", "edits"),
    [
        (LATE, {("delay",): ["-5/2", "1", "0"]}),  # from -2 on
        (LATE, {("delay",): ["0", "0", "0"]}),
        (LATE, {("delay",): ["4", "1"]}),
        (LATE, {("time",): "discrete"}),
        (LATE, {("parameters", 0, 2): "1/2"}),
        (LATE, {("parameters", 1, 0): "p"}),
        (LATE, {("parameters", 1, 0): "1"}),
        (LATE, {("parameters", 1, 0): None}),
        (LATE, {("parameters",): []}),
        (LATE, {("terms",): []}),
        (LATE, {("terms", 1, "powers"): [0, 0]}),
        (LATE, {("terms", 1, "powers"): [1]}),
        (LATE, {("terms", 1, "powers"): [1, -1]}),
        (LATE, {("terms", 1, "numerator"): ["0", "1"]}),
        (LATE, {("terms", 1, "numerator"): ["0", "1"], ("terms", 1, "denominator"): ["0", "1"]}),
        (LATE, {("kind",): "delay"}),
        (SEVERAL, {("rates",): ["1"]}),
        (SEVERAL, {("rates",): ["0", "0"]}),
        (SEVERAL, {("rates",): ["1", "-1"]}),
        (SEVERAL, {("terms", 1, "powers"): [0, 0]}),
        (SEVERAL, {("terms", 1, "A"): [["1", "1"], ["1", "1"]]}),
        (SEVERAL, {("terms", 1, "D"): [["1"], ["1"]]}),
        (SEVERAL, {("terms", 1, "D"): []}),
        (SEVERAL, {("kind",): "family"}),
        (SEVERAL, {("terms",): [{"powers": [0, 0], "common": "1", "A": [], "B": [], "C": [[]], "D": [["0"]]}]}),
    ],
)
def test_boxes_that_say_something_else_are_not_read(system, edits):
    read = boxes.plants if system is LATE else boxes.matrices
    read(system)
    for path, value in edits.items():
        system = edited(system, *path, value=value)
    with pytest.raises((Rejected, Malformed)):
        read(system)
    if edits == {("parameters", 1, 0): "1"}:  # any text is a name there
        return
    with pytest.raises(NotShown):
        (channel_boxes.read_plants if read is boxes.matrices else second.read_plants)(system)


# L |k^2 - Z^2|/(k A E) and (L/E) (max(q, 1/q) - 1), q = k^2/(A^2 rho E), at all corners of three boxes
def test_no_rod_of_a_box_is_harder_than_the_two():
    for k in ((1, 2), (5, 40), (10, 12)):
        box = {"E": (2, 3), "rho": (3, 5), "L": (1, 2), "A": (1, 4), "k": k}
        given = {"kind": "rod-family", "parameters": [[name, *map(str, ends)] for name, ends in box.items()]}

        def hard(E, rho, L, A, k):
            q = F(k * k) / (A * A * rho * E)
            return L * abs(k * k - A * A * rho * E) / F(k * A * E), F(L) / E * (max(q, 1 / q) - 1)

        two = [hard(*(int(rod[name]) for name in box)) for rod in boxes.hardest(given)[0]]
        corners = [hard(*point) for point in product(*box.values())]
        assert [max(one) for one in zip(*two, strict=True)] == [max(one) for one in zip(*corners, strict=True)]
        for j, wrong in product(range(5), (["3", "1"], ["0", "1"], ["1"])):
            if j < 4 or wrong != ["0", "1"]:
                with pytest.raises(Malformed):
                    boxes.rods(edited(given, "parameters", j, value=[given["parameters"][j][0], *wrong]))
        with pytest.raises(Malformed):
            boxes.rods(edited(given, "parameters", value=lambda rows: rows[::-1]))


def test_the_leaves_cover_their_box_and_no_interval_that_changes_is_cut():
    def cut(j, at, below, above):
        return {"parameter": j, "at": at, "below": below, "above": above}

    def leaf(i):
        return {"multiplier": i}

    box = [(F(0), F(2)), (F(0), F(3))]
    tree = cut(0, "1/2", leaf(1), cut(1, "1", leaf(2), cut(0, "1", leaf(3), leaf(4))))
    assert sorted((data, part) for part, data in boxes.leaves(tree, box, [F(0), F(0)])) == [
        (1, [(0, F(1, 2)), (0, 3)]),
        (2, [(F(1, 2), 2), (0, 1)]),
        (3, [(F(1, 2), 1), (1, 3)]),
        (4, [(1, 2), (1, 3)]),
    ]
    for wrong in (
        cut(0, "0", leaf(1), leaf(2)),
        cut(0, "2", leaf(1), leaf(2)),
        cut(1, "1", cut(1, "2", 1, 2), leaf(2)),
    ):
        with pytest.raises((Rejected, Malformed)):
            list(boxes.leaves(wrong, box))
        with pytest.raises(NotShown):
            list(second.leaves(wrong, tuple(box)))
    with pytest.raises(Rejected, match="that changes is cut"):
        list(boxes.leaves(tree, box, [F(0), F(1)]))


# a + 10 (omega^2 - 1)^2 + 2 cos(omega T) is a - 2 at omega = 1 for T = pi, just behind an end of 3.13 to 3.83, between
# the end and the middle of 2.9 to 3.6: there 2 cos is -1.9999 and -1.942, in the middles -1.887 and -1.988
@pytest.mark.parametrize(
    ("ends", "a", "holds"),
    [
        (("3.13", "3.83"), "1.99995", False),
        (("3.13", "3.83"), "2.05", True),
        (("2.9", "3.6"), "1.991", False),
        (("2.9", "3.6"), "2.2", True),
        (("2.9", "3"), "2.01", True),
        (("2.9", "3"), "1.95", False),
        (("3", "3"), "1.99", True),  # cos 3 = -.98999, at most -.99 near by
        (("3", "3"), "1.97", False),
    ],
)
def test_a_dead_time_between_its_ends_is_not_overlooked(ends, a, holds):
    low, high = map(F, ends)
    late = Form({((low + high) / 2, 0): (F(2), F(0))})
    with nullcontext() if holds else pytest.raises(Rejected, match="not shown"):
        boxes.waiting(real(F(a) + 10, 0, -20, 0, 10), late, (low, high), 4, critical=False)

"""Certificates about several channels and every plant of a box: both checkers, and what neither may accept."""

from dataclasses import replace
from fractions import Fraction

import pytest
from certificate_format import FORMAT
from flint import fmpq, fmpq_mat

from lure import NonlinearityClass, Sector
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import channel_boxes
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.systems import class_entries, system_of
from lure.analysis.questions.gain import l2_gain
from lure.classes import Diagonal
from lure.plants.channel_family import ChannelFamily
from tests.support.tampering import assert_both_reject, edited

BOX = {"a": (1, 2), "m": (Fraction(4, 5), Fraction(6, 5))}
# m x' = -a x + mu: V = P x^2, sector [0, 1]
FIRST = ChannelFamily.of_matrices([["-a/m"]], [["1/m"]], [[1]], None, BOX)
# x' = -a x + u, u = -phi(-x): sigma = -x, H = -1/(s + a): constant gains g shift the pole to g - a, stable for g < 1
AGAINST = ChannelFamily.of_matrices([["-a"]], [[1]], [[-1]], None, {"a": (1, 2)})


def draft(family, leaf, theorem="diagonal-circle", *, classes=None):
    own = Diagonal(classes or (NonlinearityClass(sector=Sector(0, 1)),))
    tree = leaf if "below" in leaf else {"multiplier": leaf}
    return {
        **{"verdict": "PROVED", "system": system_of(family), "laws": class_entries(own)},
        **{"theorem": theorem, "multiplier": {}, "proof": {"method": "boxes", "boxes": tree}},
    }


def leaf(P, weight, **more):
    return {"lambda": [weight], "P": P, "exponent": 0, **more}


@pytest.fixture(scope="module")
def proof():
    # (x, phi): 2 a p x^2 + 2 p x phi - 2 l phi (x - phi) = 2 a p x^2 + 2 l phi^2 with p = l: positive definite
    return complete_and_check(draft(FIRST, leaf([[["1"]], [["0"]], [["0"]]], "1"))).certificate


def test_both_accept_a_box_with_a_denominator_and_say_for_which_plants(proof):
    FORMAT.validate(dict(proof))
    shown = check(dict(proof))
    assert isinstance(shown, Proved)
    assert shown.claim.endswith("for all constant a in [1, 2], m in [4/5, 6/5]")
    assert recheck(proof).accepted


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proof", "boxes", "multiplier", "P"), [[["-1"]], [["0"]], [["0"]]]),
        (("proof", "boxes", "multiplier", "P"), [[["1"]], [["-1"]], [["0"]]]),  # V = 0 where t_1 = 1
        (("proof", "boxes", "multiplier", "P"), [[["1"]], [["0"]]]),
        (("proof", "boxes", "multiplier", "P"), []),
        (("proof", "boxes", "multiplier", "P"), None),
        (("proof", "boxes", "multiplier", "lambda"), ["-1"]),
        (("proof", "boxes", "multiplier", "lambda"), ["1", "1"]),
        (("proof", "boxes", "multiplier", "theta"), ["1"]),
        (("proof", "boxes", "multiplier", "exponent"), -1),
        (("proof", "boxes"), {"parameter": 0, "at": "3/2", "below": {}, "above": {}}),
        (("proof", "boxes"), {}),
        (("proof", "boxes"), None),
        (("proof", "method"), "matrix"),
        (("multiplier",), {"lambda": ["1"]}),
        (("theorem",), "full-block-circle"),
        (("theorem",), "diagonal-popov"),
        (("rate",), "9/10"),  # a = 1, m = 6/5 has 5/6
        (("system", "kind"), "family"),
        (("system", "kind"), "multivariable"),
        (("system", "parameters", 0, 1), "-1"),  # an unstable plant
        (("system", "parameters", 1, 1), "-1"),  # m passes 0
        (("system", "parameters", 1, 1), "0"),
        (("system", "parameters", 0, 2), "1"),
        (("system", "parameters", 1, 0), "a"),
        (("system", "terms", 0, "powers"), [0]),
        (("system", "terms", 0, "common"), "-1"),
        (("system", "terms", 1, "A"), [["1"], ["1"]]),
        (("system", "terms", 1, "D"), [["-5"]]),
        (("laws", "channels", 0, "sector", 1), "20"),
    ],
)
def test_neither_accepts_a_change(proof, path, value):
    if path == ("rate",):
        assert_both_reject({**proof, "rate": value})
    else:
        assert_both_reject(edited(proof, *path, value=value))


# H = -1/(s + a), [0, k]: F of P = p, lambda = l: (x, phi) -> 2 a p x^2 - 2 p x phi (mu = -phi) ... - 2 l phi (k sigma -
# phi), sigma = -x: 2 a p x^2 + (2 p + 2 l k) x phi + 2 l phi^2: 4 a p l > (p + l k)^2, best p = l k: a > k
def test_the_circle_criterion_is_sharp_for_all_plants():
    def shown(k):
        given = (NonlinearityClass(sector=Sector(0, Fraction(k)), time_varying=True),)
        return complete_and_check(draft(AGAINST, leaf([[["1"]]], str(1 / Fraction(k))), classes=given))

    assert recheck(shown("999/1000").certificate).accepted
    with pytest.raises(Rejected):
        shown("1")
    assert_both_reject(edited(shown("999/1000").certificate, "laws", "channels", 0, "sector", 1, value="1"))


# x' = -a x - phi, V = x^2 + 10 int phi, lambda = 1, [0, 10]: 2 a x^2 + 2 (1 + 5 a - 10) x phi + 12 phi^2, of which the
# determinant is positive for (5 a - 9)^2 < 24 a; with theta = 0 for 81 < 4 a
@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("laws", {"time_varying": True}),
        ("laws", {"sector": ["0", "11"]}),
        ("leaf", {"theta": ["0"]}),
        ("leaf", {"theta": ["-5"]}),
        ("leaf", {"theta": ["5", "0"]}),
        ("leaf", {"theta": []}),
        ("theorem", "diagonal-circle"),
        ("time", "discrete"),
        ("D", "1/1000"),
        ("moving C", "1/1000"),
    ],
)
def test_popovs_terms_in_a_box_are_of_functions_of_the_state(path, value):
    plant = ChannelFamily.of_matrices([["-a"]], [[1]], [[1]], None, {"a": (1, 2)})
    given = leaf([[["1"]], [["0"]]], "1", theta=["5"])
    own = (NonlinearityClass(sector=Sector(0, 10)),)
    found = complete_and_check(draft(plant, given, "diagonal-popov", classes=own)).certificate
    assert recheck(found).accepted
    if path == "laws":
        changed = edited(found, "laws", "channels", 0, value=lambda one: one | value)
    elif path == "leaf":
        changed = edited(found, "proof", "boxes", "multiplier", value=lambda one: one | value)
    elif path == "time":
        changed = edited(found, "system", "time", value=value)
    elif path == "moving C":
        changed = edited(edited(found, "system", "kind", value="varying-family"), "system", "rates", value=["1/100"])
        changed["system"]["terms"][-1]["C"] = [[value]]
    else:
        changed = (
            edited(found, "theorem", value=value)
            if path == "theorem"
            else edited(found, "system", "terms", 0, path, value=[[value]])
        )
    assert_both_reject(changed)


def test_a_plant_between_the_corners_is_not_overlooked():
    # x' = (64 (p - 1/8)^2 - 1/2) x: -1/2 at p = 1/8, 1/2 at 0 and 1/4; and the other way round
    for sign, box in (("", (0, 1)), ("-", (0, Fraction(1, 4)))):
        entry = f"{sign}(64*(p - 1/8)^2 - 1/2)"
        family = ChannelFamily.of_matrices([[entry]], [[1]], [[1]], None, {"p": box})
        for tree in (leaf([[["1"]]], "1"), leaf([[["1"]], [["1"]]], "1")):
            with pytest.raises((Rejected, Malformed)):
                complete_and_check(draft(family, tree))


def test_a_parameter_that_no_entry_has_leaves_the_others_their_values():
    # x' = (8 p (1 - p) - 1) x: -1 at p = 0 and 1, 1 in the middle; with q the degrees of p and q are 2 and 0
    entry = leaf([[["1"]]], "1")
    for a, stable in (("8*p*(1 - p) - 1", False), ("p*(1 - p) - 1", True)):
        family = ChannelFamily.of_matrices([[a]], [[1]], [[1]], None, {"p": (0, 1)})
        alone = draft(family, entry)
        system = edited(alone["system"], "parameters", value=lambda rows: [*rows, ["q", "0", "1"]])
        for term in system["terms"]:
            term["powers"].append(0)
        both = {**alone, "system": system}
        if stable:
            assert recheck(complete_and_check(both).certificate).accepted
        else:
            with pytest.raises(Rejected):
                complete_and_check(both)


@pytest.mark.slow
def test_a_gain_is_that_of_every_plant_and_its_member_one_of_the_box():
    # x' = -a x + w - phi, z = x: 1/a with phi = 0, and the circle criterion proves no more than 1 at a = 1
    family = ChannelFamily.of_matrices([["-a"]], [[1]], [[1]], None, {"a": (1, 2)})
    found = l2_gain(family, [Sector(0, 1)], {"Bw": [[1]], "Cz": [[1]]})
    assert 0.999 < found.gain.low < 1 < found.gain.high < 1.001
    high, low = found.certificates["high"], found.certificates["low"]
    for one in (high, low):
        FORMAT.validate(dict(one))
        assert recheck(one).accepted
    radius = Fraction(high["laws"]["channels"][1]["sector"][1])
    smaller = [str(v) for v in (-radius * Fraction(101, 100), radius * Fraction(101, 100))]
    assert_both_reject(edited(high, "laws", "channels", 1, "sector", value=smaller))
    assert_both_reject(edited(low, "proof", "at", value=["2"]))
    assert_both_reject(edited(low, "proof", "at", value=["1/2"]))
    assert_both_reject(edited(low, "proof", value=dict(low["proof"]["proof"])))


# at a = 1 + t_1 and m = 4/5 + 2/5 t_2, against V' and the forms of the classes one by one
@pytest.mark.parametrize("discrete", [False, True])
def test_the_forms_of_the_second_checker_are_those_of_each_plant(discrete):
    F, exact = Fraction, channel_boxes.to_fmpq
    rows = [["-a/m", "1"], ["0", "-2"]], [["1/m", "1"], ["2", "a/m"]], [["1", "3"], ["a/m", "1/m"]]
    family = ChannelFamily.of_matrices(*rows, [["0", "0"], ["1", "2/m"]], BOX, *([1] if discrete else []))
    plants, bounds = channel_boxes.read_plants(system_of(family)), [(F(-1, 2), F(3)), (F(-1), F(2))]
    sides = tuple(plants.within(plants.box))
    P = {(0, 0): fmpq_mat([[3, 1], [1, 2]]), (1, 0): fmpq_mat([[1, 2], [2, -1]]), (0, 1): fmpq_mat([[0, 1], [1, 1]])}
    weights, theta, more = [F(2), F(1, 3)], [F(0) if discrete else F(-3, 4), F(0)], [(F(1, 5), F(-1, 7), F(2, 3)), None]
    least, falls = channel_boxes._forms(P, (weights, theta, more), bounds, sides, discrete=discrete)

    def at(p, t):
        weighed = [exact(t[0] ** i * t[1] ** j) * M for (i, j), M in p.items()]
        return sum(weighed[1:], weighed[0])

    def form(M, x, y):
        return (x.transpose() * M * y)[0, 0]

    x, phi = fmpq_mat([[2], [-1]]), fmpq_mat([[3], [5]])
    both = fmpq_mat([*x.tolist(), *phi.tolist()])
    for t in ((F(1, 3), F(1, 2)), (F(0), F(1))):
        point = plants.at([1 + t[0], F(4, 5) + F(2, 5) * t[1]])
        A, B, C, D = (fmpq_mat([[exact(F(v)) for v in row] for row in point[name]]) for name in "ABCD")
        c, Q, moved, sigma = at(sides[0], t)[0, 0], at(P, t), A * x - B * phi, C * x - D * phi
        fall, low = form(Q, x, x) - form(Q, moved, moved) if discrete else -2 * form(Q, x, moved), Q
        for i, ends in enumerate(bounds):
            (a, b), weight, turn = map(exact, ends), exact(weights[i]), exact(theta[i])
            s, f, row = sigma[i, 0], phi[i, 0], fmpq_mat([C.tolist()[i]])
            fall -= 2 * weight * (f - a * s) * (b * s - f) + 2 * turn * f * (row * moved)[0, 0]
            low += min(turn * a, turn * b) * row.transpose() * row
            if turn != 0:
                p, q, r = map(exact, more[i])
                fall -= p * s * s + 2 * q * (f - a * s) * s + r * (f - a * s) ** 2
        assert form(at(falls, t), both, both) == c * c * fall
        assert at(least, t) == c * c * low
    # -c^2 sum t_j' x'P_j x for the extreme t_j', a' = 1/2 of the width 1, m' = 1 of 2/5
    moving = replace(plants, rates=(F(1, 2), F(1)), discrete=False)
    found = [form(at(one, t), both, both) for one in channel_boxes._drifts(P, sides[0], moving, (plants.box, 2))]
    first, last = (form(P[k], x, x) for k in ((1, 0), (0, 1)))
    assert sorted(found) == sorted(-c * c * (i * first / 2 + j * last * fmpq(5, 2)) for i in (1, -1) for j in (1, -1))

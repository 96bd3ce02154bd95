"""Forms of several samples of several nonlinearities: what is proved, and what both checkers reject."""

import copy
import json
from dataclasses import replace
from fractions import Fraction as F
from types import SimpleNamespace

import numpy as np
import pytest
from flint import fmpq_mat
from handwritten import nonlinearities, operator
from second_plants import asked as as_asked
from second_plants import assert_accepted_if, unit
from tampering import assert_both_reject, edited

from lure import SlopeBounds, as_plant
from lure.analysis import certify, max_slope
from lure.analysis.certificates import channels, windows
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.second import windows as second
from lure.analysis.certificates.second.channels import read_classes
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.questions.certify import ProofOptions
from lure.plants.multivariable import MultivariablePlant

SIXTH = ([[F(1, 2), 0], [1, 0]], [[1], [0]], [[2, F("0.92")]], [[0]])  # example 6: (2 z + 0.92)/(z^2 - z/2)


def twice(M):
    width = len(M[0])
    return [[*row, *[0] * width] for row in M] + [[*[0] * width, *row] for row in M]


@pytest.fixture(scope="module")
def found():
    """Two copies of example 6 beside each other, with a nonlinearity each."""
    plant = MultivariablePlant(*map(twice, SIXTH), dt=1)
    return max_slope(plant, [SlopeBounds(0, 1), SlopeBounds(0, 1)], criterion="order-cones")


# Block-diagonal: what one loop reaches, 0.876480 with two samples (0.651041 by the circle criterion).
@pytest.mark.slow
def test_two_loops_side_by_side_are_proved_as_far_as_one(found):
    assert found.criterion == "order-cones"
    assert found.largest.low == pytest.approx(0.87648, abs=3e-5)
    assert found.refuted_at > 0.9
    text = json.dumps(found.proof.certificate)
    assert isinstance(check(text), Proved)
    assert recheck(text).accepted


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("multiplier", "windows", 0, 2, 0), "-1"),
        (("multiplier", "windows", 1, 3, 3), lambda v: f"-{v}"),
        (("multiplier", "windows"), lambda v: v[:1]),
        (("multiplier", "windows"), lambda v: [v[0], v[1][:2]]),
        (("multiplier", "odd"), [True, False]),
        (("proof", "P", 0, 0), lambda v: str(-int(v))),
        (("proof", "P"), lambda v: v[:-1]),
        (("proof", "exponent"), lambda v: v + 1),
        (("laws", "channels", 0, "slope"), None),
        (("laws", "channels", 1, "time_varying"), True),
        (("laws", "channels", 0, "slope"), ["0", "9/10"]),
        (("system", "time"), "continuous"),
        (("system", "A", 0, 0), "3/2"),
        (("system", "D"), [["0", "1"], ["1", "0"]]),
    ],
)
def test_what_was_tampered_with_is_rejected_by_both(found, path, value):
    assert_both_reject(edited(found.proof.certificate, *path, value=value))


def test_a_direct_term_from_one_channel_to_the_next_counts():
    # proved up to .8743 with two samples: of another D the inequality fails, of a cycle of channels all
    plant = as_plant([["(2*z + 0.92)/(z^2 - z/2)", "1/(5*z)"], ["1/2", "1/(2*z - 1)"]], dt=1)
    ways = ProofOptions(criterion="coupled-windows")
    shown = certify(plant, [SlopeBounds(0, F("0.874"))] * 2, ways=ways).shown
    assert recheck(shown.certificate).accepted
    for D in ([["0", "0"], ["-1/2", "0"]], [["0", "0"], ["3/5", "0"]], [["0", "1/5"], ["1/2", "0"]]):
        assert_both_reject(edited(shown.certificate, "system", "D", value=D))


# P has either sign, so that a mode which nothing sees or drives can satisfy the inequality and grow: x+ = 2 x with
# V = -x^2. That the loop is stable at its least slopes is shown apart.
def test_an_unstable_mode_that_the_inequality_does_not_see_is_rejected(found):
    certificate = copy.deepcopy(dict(found.proof.certificate))
    system, proof = certificate["system"], certificate["proof"]
    n, unit = len(system["A"]), str(-(2 ** proof["exponent"]))
    grown = copy.deepcopy(certificate)
    grown["system"]["A"] = [[*row, "0"] for row in system["A"]] + [["0"] * n + ["2"]]
    grown["system"]["B"] = [*system["B"], ["0", "0"]]
    grown["system"]["C"] = [[*row, "0"] for row in system["C"]]
    P = [[*row[:n], *(["0"] if i >= n else []), *row[n:]] for i, row in enumerate(proof["P"])]
    grown["proof"]["P"] = [*P[:n], ["0"] * n + [unit], *P[n:]]
    assert_both_reject(grown)
    grown["system"]["A"][-1][-1] = "1/2"  # with V = x^2 the same mode, stable, is no obstacle
    grown["proof"]["P"][n][n] = unit.removeprefix("-")
    assert isinstance(check(json.dumps(grown), draft=True), Proved)
    assert recheck(json.dumps({**grown, **check(json.dumps(grown), draft=True).certificate})).accepted


def numbers(rows):
    return [[F(v) for v in row] for row in rows]


# rows and columns add up to 0 at least; ``summed``: entries of one distance in time are taken together.  At rate 1/2
# 1 beside the diagonal weighs 2 in the row of the earlier sample and 1/2 in the column where sums are taken, and (k, l)
# weighs 2^(k + l) where none are
@pytest.mark.parametrize(
    ("Q", "count", "options", "holds"),
    [
        ([["1"]], 1, {}, True),
        ([["-1/9"]], 1, {}, False),
        ([["1", "-1"], ["0", "1"]], 1, {}, True),
        ([["9/10", "-1"], ["0", "2"]], 1, {}, False),
        ([["2", "-1"], ["0", "9/10"]], 1, {}, False),
        ([["2", "-1"], ["-1", "1"]], 1, {}, True),
        ([["1", "1/9"], ["0", "1"]], 1, {}, False),
        ([["1", "1"], ["1", "1"]], 1, {"odd": True}, True),
        ([["1", "1"], ["11/10", "2"]], 1, {"odd": True}, False),
        ([["1", "-1"], ["0", "0"]], 1, {}, False),
        ([["1", "-1"], ["0", "0"]], 1, {"summed": True}, True),
        ([["1/2", "-1"], ["0", "1/2"]], 1, {"summed": True}, True),
        ([["1", "-1"], ["-1/9", "0"]], 1, {"summed": True}, False),
        ([["1", "-1"], ["1", "0"]], 1, {"summed": True}, False),  # not of one distance
        ([["1", "1"], ["-1", "1"]], 1, {"summed": True, "odd": True}, True),
        ([["1", "1"], ["-1", "0"]], 1, {"summed": True, "odd": True}, False),
        # two channels, one and two samples
        ([["1", "-1"], ["0", "1"]], 2, {"summed": True}, True),
        ([["1", "-1"], ["0", "9/10"]], 2, {"summed": True}, False),
        ([["1", "0", "0", "-1"], ["0", "1", "0", "0"], ["0"] * 4, ["0"] * 4], 2, {"summed": True}, True),
        ([["1", "0", "0", "-1"], ["0", "9/10", "0", "0"], ["0"] * 4, ["0"] * 4], 2, {"summed": True}, False),
        ([["1", "-1", "0", "0"], ["0", "1", "0", "0"], ["0", "0", "0", "1/9"], ["0"] * 4], 2, {"summed": True}, True),
        # at a rate
        ([["2", "-1"], ["0", "0"]], 1, {"summed": True, "rate": F(1, 2)}, True),
        ([["19/10", "-1"], ["0", "0"]], 1, {"summed": True, "rate": F(1, 2)}, False),
        ([["0", "-1"], ["0", "2"]], 1, {"summed": True, "rate": F(1, 2)}, True),
        ([["0", "-1"], ["0", "19/10"]], 1, {"summed": True, "rate": F(1, 2)}, False),
        ([["0", "0"], ["-1", "2"]], 1, {"summed": True, "rate": F(1, 2)}, True),
        ([["0", "0"], ["-1", "19/10"]], 1, {"summed": True, "rate": F(1, 2)}, False),
        ([["2", "0"], ["-1", "0"]], 1, {"summed": True, "rate": F(1, 2)}, True),
        ([["19/10", "0"], ["-1", "0"]], 1, {"summed": True, "rate": F(1, 2)}, False),
        ([["2", "-1"], ["0", "1/2"]], 1, {"rate": F(1, 2)}, True),
        ([["19/10", "-1"], ["0", "1/2"]], 1, {"rate": F(1, 2)}, False),
        ([["2", "-1"], ["0", "49/100"]], 1, {"rate": F(1, 2)}, False),
        ([["2", "-1", "0", "0"], ["0", "2", "0", "0"], ["0"] * 4, ["0"] * 4], 2, {"rate": F(1, 2)}, True),
        ([["1", "-1", "0", "0"], ["0", "1", "0", "0"], ["0"] * 4, ["0"] * 4], 2, {"rate": F(1, 2)}, True),
    ],
)
def test_forms_are_doubly_dominant(Q, count, options, holds):
    options = {"summed": False, "odd": False} | options
    rate, odd = options.get("rate", F(1)), options["odd"]
    with assert_accepted_if(holds):
        rows = second._slowed(numbers(Q), count, rate)
        second._require_dominant(rows, count, over_time=options["summed"], odd=odd, rate=rate)
    if holds:
        windows.dominant(numbers(Q), count, **options)
        return
    with pytest.raises(Rejected):
        windows.dominant(numbers(Q), count, **options)


BOUNDS = [(F(-1), F(2)), (F(1, 2), F(3))]
SLOPE, RELU = nonlinearities(0, 1, slope=True), nonlinearities(0, 1, slope=True, relu=True)
ROWS = [["2", "-1"], ["0", "1"]]
KNOWN = {"kind": "monotone", "channels": [1], "rows": ROWS}


def forms(given, classes, samples=2, summed=False, repeated=False):
    asked = channels.channels({"channels": classes, "repeated": repeated}, len(classes))
    return windows.coupled(given, asked, samples, summed)


def plant_of(classes, repeated=False):
    """A plant of the second checker with these classes."""
    m = len(classes)
    own, firsts = read_classes(SimpleNamespace(nonlinearities={"channels": classes, "repeated": repeated}), m)
    none = as_asked([[0]], [[0] * m], [[0]] * m, [[0] * m] * m, discrete=True)
    return replace(none, nonlinearities=own, repeated=firsts)


def again(given, classes, samples=2, summed=False, repeated=False):
    """The same as the second checker reads them."""
    return second.read_forms(given, plant_of(classes, repeated), samples, over_time=summed)


# w'M w for w = (u, v): 2 u'Q v; rising 2 u'Q (u + v); falling 2 v'Q (u + v)
@pytest.mark.parametrize(
    ("kind", "law", "value", "bounds"),
    [
        ("monotone", SLOPE, lambda u, Q, v: 2 * u @ Q @ v, (0, 1)),
        ("odd", SLOPE | {"odd": True}, lambda u, Q, v: 2 * u @ Q @ v, (0, 1)),
        ("rising", nonlinearities(0, 2, slope=["0", "inf"]), lambda u, Q, v: 2 * u @ Q @ (u + v), (0, 2)),
        ("falling", nonlinearities(0, 2, slope=["-inf", "2"]), lambda u, Q, v: 2 * v @ Q @ (u + v), (0, 2)),
        ("sector", nonlinearities(0, 2), lambda u, Q, v: 2 * u @ np.diag([2, 1]) @ v, (0, 2)),
    ],
)
def test_what_a_form_is_of(kind, law, value, bounds):
    rows = [["2", "0"], ["0", "1"]] if kind == "sector" else ROWS
    ((where, M),), ends = forms([{"kind": kind, "channels": [1], "rows": rows}], [law])
    M, Q = np.array(M, dtype=float), np.array([[2, -1], [0, 1]])
    assert (where, ends) == ([0], [bounds])
    assert np.array_equal(M, M.T)
    same = again([{"kind": kind, "channels": [1], "rows": rows}], [law])
    assert (same.each[0].channels, same.bounds) == ([0], [bounds])
    N = np.array([[float(v.p) / float(v.q) for v in row] for row in same.each[0].M.tolist()])
    for w in np.random.default_rng(1).normal(size=(5, 4)):
        assert w @ M @ w == pytest.approx(value(w[:2], Q, w[2:]))
        assert w @ N @ w == pytest.approx(value(w[:2], Q, w[2:]))


@pytest.mark.parametrize(
    ("given", "classes", "options"),
    [
        ([KNOWN, KNOWN], [SLOPE], {}),
        ([KNOWN | {"channels": [1, 1]}], [SLOPE], {}),
        ([KNOWN | {"channels": [2]}], [SLOPE], {}),
        ([KNOWN | {"channels": [0]}], [SLOPE], {}),
        ([KNOWN | {"channels": []}], [SLOPE], {}),
        ([KNOWN | {"rows": ROWS[:1]}], [SLOPE], {}),
        ([KNOWN | {"kind": "even"}], [SLOPE], {}),
        ([KNOWN | {"kind": "odd"}], [SLOPE], {}),
        ([KNOWN], [nonlinearities(0, 1)], {}),  # no slopes
        ([KNOWN], [nonlinearities(0, "inf", slope=["0", "inf"])], {}),
        ([KNOWN], [SLOPE | {"time_varying": True}], {}),
        ([KNOWN], [SLOPE | {"regularity": "any"}], {}),
        ([KNOWN], [operator("any", 1)], {}),
        ([KNOWN | {"kind": "rising"}], [nonlinearities(0, 2, slope=["-1", "2"])], {}),
        ([KNOWN | {"kind": "falling"}], [nonlinearities(0, 2, slope=["0", "3"])], {}),
        ([KNOWN | {"kind": "odd rising"}], [nonlinearities(0, 2, slope=["0", "3"])], {}),
        ([KNOWN | {"kind": "sector"}], [SLOPE], {}),  # an entry beside the diagonal
        ([KNOWN | {"kind": "sector", "rows": [["-1", "0"], ["0", "1"]]}], [SLOPE], {}),
        ([], [nonlinearities(0, "inf")], {}),
        ([KNOWN | {"channels": [1, 2]}], [SLOPE] * 2, {"samples": 1}),  # two functions
        ([KNOWN | {"rows": [["1", "-1"], ["0", "0"]]}], [SLOPE], {}),
        ([{"kind": "relu", "channels": [1], "rows": [["0"], ["0", "0"]]}], [SLOPE], {"samples": 1}),
        ([{"kind": "relu", "channels": [1], "rows": [["0"], ["0", "0"]]}], [RELU], {"samples": 1, "summed": True}),
        ([{"kind": "relu", "channels": [1], "rows": [["-1"], ["0", "0"]]}], [RELU], {"samples": 1}),
        ([{"kind": "relu", "channels": [1], "rows": [["0"], ["0", "-1"]]}], [RELU], {"samples": 1}),
        ([{"kind": "relu", "channels": [1], "rows": [["0"], ["0", "0"], ["1", "1", "0"], ["0"] * 4]}], [RELU], {}),
        ([{"kind": "relu", "channels": [1], "rows": [["0"], ["0", "0"], ["0"] * 3, ["1", "0", "0", "0"]]}], [RELU], {}),
    ],
)
def test_forms_that_may_be_negative_are_refused(given, classes, options):
    with pytest.raises((Rejected, Malformed)):
        forms(given, classes, **options)
    with pytest.raises(NotShown):
        again(given, classes, **options)


def test_windows_have_the_same_number_of_samples():
    one, two = [["1/100"], ["1/4", "1/100"]], [["1/50"], ["0", "1/50"], ["1", "0", "1/50"], ["0", "1", "0", "1/50"]]
    asked = channels.channels({"channels": [SLOPE] * 2, "repeated": False}, 2)
    assert windows.of_orders({"windows": [two, two], "odd": [False] * 2}, asked).samples == 2
    plant = plant_of([SLOPE] * 2)
    found = second._ordered_forms({"windows": [two, two], "odd": [False] * 2}, plant)
    assert (found.samples, found.bounds, [form.channels for form in found.each]) == (2, [(0, 1)] * 2, [[0], [1]])
    assert found.each[0].M[0, 2] == 1
    for given in ([one, two], [two, one], [[], []], [two]):
        with pytest.raises(Malformed):
            windows.of_orders({"windows": given, "odd": [False] * 2}, asked)
        with pytest.raises(NotShown):
            second._ordered_forms({"windows": given, "odd": [False] * 2}, plant)
    for change in ({"slope": None}, {"time_varying": True}, {"slope": ["0", "inf"], "sector": ["0", "inf"]}):
        with pytest.raises(NotShown):
            second._ordered_forms({"windows": [two] * 2, "odd": [False] * 2}, plant_of([SLOPE, SLOPE | change]))
    with pytest.raises(NotShown, match="odd"):
        second._ordered_forms({"windows": [two] * 2, "odd": [False, True]}, plant)


# x_1 = (phi, sigma) of two channels at two times, and the bounds [-1, 2] and [1/2, 3]
def test_forms_are_about_phi_less_the_bounds_of_each_channel():
    lines = unit(8)
    at = [second.cut(lines, k, 2) for k in (0, 2, 4, 6)]
    M = fmpq_mat([[i * j + (i == j) for j in range(8)] for i in range(8)])
    N = fmpq_mat([[1, 2, 0, 1]] * 4)
    given = second.Forms(2, [second.Form([0, 1], M), second.Form([1], N)], BOUNDS)
    phi, sigma = [2, -1, 3, 5], [1, 4, -2, 7]
    x = fmpq_mat([[v] for v in (*phi, *sigma)])
    u = [phi[2 * t + i] - BOUNDS[i][0] * sigma[2 * t + i] for t in range(2) for i in range(2)]
    v = [BOUNDS[i][1] * sigma[2 * t + i] - phi[2 * t + i] for t in range(2) for i in range(2)]
    both, last = (fmpq_mat([[second.to_fmpq(F(e))] for e in own]) for own in ((*u, *v), (u[1], u[3], v[1], v[3])))
    exact = both.transpose() * M * both + last.transpose() * N * last
    assert x.transpose() * second._total(given, at[:2], at[2:]) * x == exact
    # of one sample, in (sigma, psi) with psi = u: v = w sigma - psi
    one = [{"kind": "monotone", "channels": [1, 2], "rows": [["2", "-1"], ["0", "1"]]}]
    Pi, ends = second.static_form(one, plant_of([nonlinearities(-2, 1, slope=True)] * 2, True))
    z, Q = fmpq_mat([[5], [7], [2], [3]]), fmpq_mat([[2, -1], [0, 1]])
    assert (z.transpose() * Pi * z)[0, 0] == 2 * (fmpq_mat([[2, 3]]) * Q * fmpq_mat([[15 - 2], [21 - 3]]))[0, 0]
    assert ends == [(-2, 1)] * 2


# equilibria N of A~ N = N, and He of the sum of M_uv on what is seen of them
@pytest.mark.parametrize(
    ("A", "N", "Q", "change", "holds"),
    [
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], {}, True),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[2, 1], [0, 1]], {}, True),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[2, 3], [0, 1]], {}, False),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 0]], {}, False),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[-1, 0], [0, -1]], {}, False),
        ([[1, 0], [0, 1]], [[1], [0]], [[1, 0], [0, 1]], {}, False),  # of two
        ([[1, 0], [0, F(1, 2)]], [[1], [0]], [[1, 0], [0, 0]], {}, True),
        ([[1, 0], [0, F(1, 2)]], [[1], [0]], [[0, 0], [0, 1]], {}, False),
        ([[1, 0], [0, -1]], [[1], [0]], [[1, 0], [0, 1]], {}, False),
        ([[1, 1], [0, 1]], [[1], [0]], [[1, 0], [0, 1]], {}, False),  # one eigenvector of two
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], {"slope": None}, False),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], {"slope": ["-1/9", "1"]}, False),
        ([[1, 0], [0, 1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], {"time_varying": True}, False),
    ],
)
def test_forms_over_all_time_move_every_equilibrium(A, N, Q, change, holds):
    plant = plant_of([SLOPE, SLOPE | change])
    zero, Q, N = fmpq_mat(2, 2), fmpq_mat(Q), fmpq_mat(N)
    forms = second.Forms(1, [second.Form([0, 1], second.joined(zero, Q, zero))], [(F(0), F(1))] * 2)
    with assert_accepted_if(holds):
        second._require_settling(plant, fmpq_mat([[second.to_fmpq(F(v)) for v in row] for row in A]), forms, N, N)
    squared = second.Forms(1, [second.Form([0, 1], second.joined(zero, Q, Q))], forms.bounds)
    with pytest.raises(NotShown):
        second._require_settling(plant, fmpq_mat([[1, 0], [0, 1]]), squared, unit(2), unit(2))


def test_forms_of_several_channels_and_rectifiers_are_taken():
    one = {"channels": [1, 2], "rows": [["1", "-1"], ["0", "1"]]}
    assert forms([KNOWN | one], [SLOPE] * 2, samples=1, repeated=True)[1] == [(0, 1)] * 2
    both = [KNOWN | {"kind": "sector", "rows": [["1", "0"], ["0", "1"]]}, KNOWN | {"kind": "rising"}]
    assert len(forms(both, [SLOPE])[0]) == len(again(both, [SLOPE]).each) == 2
    assert again([KNOWN | one], [SLOPE] * 2, samples=1, repeated=True).bounds == [(0, 1)] * 2
    # u >= 0 >= v and u_k v_k = 0: any entry of (k, p + k), else of its sign
    rows = [["1"], ["1", "1"], ["5", "-1", "1"], ["-1", "-5", "1", "1"]]
    ((_, M),), _ = forms([{"kind": "relu", "channels": [1], "rows": rows}], [RELU])
    assert M[3] == [-1, -5, 1, 1]
    again_M = again([{"kind": "relu", "channels": [1], "rows": rows}], [RELU]).each[0].M
    assert again_M.tolist()[3] == [-1, -5, 1, 1]
    with pytest.raises(NotShown, match="locally Lipschitz"):  # one of them
        again([KNOWN], [SLOPE, nonlinearities(0, 1) | {"regularity": "any"}])


# x' = -phi, x+ = x - phi: (1, 0) is an equilibrium with phi = 0; of x' = 0 (1, 1) is one, too, with phi = sigma
@pytest.mark.parametrize(
    ("sides", "discrete", "low", "M", "zero", "holds"),
    [
        ("0111", False, 0, [[0], [0, 1]], [[1, 0]], True),
        ("1111", True, 0, [[0], [0, 1]], [[1, 0]], True),
        ("0111", True, 0, [[0], [0, 1]], [[1, 0]], False),
        ("1111", False, 0, [[0], [0, 1]], [[1, 0]], False),
        ("0111", False, 0, [[0], [0, 1]], [[2, 0]], False),
        ("0111", False, 0, [[0], [0, 1]], [[0, 0]], False),
        ("0111", False, 0, [[0], [0, 1]], [[1, 1]], False),
        ("0111", False, 1, [[0], [0, 1]], [[1, 0]], False),
        ("0111", False, 0, [[1], [0, 1]], [[1, 0]], False),  # V' does not vanish there
        ("0111", False, 0, [[0], [1, 1]], [[1, 0]], False),
        ("0101", False, 0, [[0], [0, 1]], [[1, 0]], False),  # which sigma does not see
        ("0111", False, 0, [[0], [0, 1]], [[1, 0], [1, 0]], False),
        ("0111", False, 0, [[0], [0, 1]], [], False),
        ("0011", False, 1, [[1], [-1, 1]], [[1, 1]], True),
        ("0011", False, 0, [[1], [-1, 1]], [[1, 1]], False),
    ],
)
def test_a_form_is_taken_beside_its_equilibria(sides, discrete, low, M, zero, holds):
    A, B, C, _ = ([[F(v)]] for v in sides)
    given = numbers(M), channels.Plant(A, B, C, [[F(0)]], discrete), [F(low)], [[str(v) for v in row] for row in zero]
    if holds:
        assert windows.at_rest(*given) == [[F(1)]]
        return
    with pytest.raises((Rejected, Malformed)):
        windows.at_rest(*given)

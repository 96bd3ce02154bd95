"""What mutants of the second checker lived through: each line here fails where one of its hypotheses is left out."""

import copy
import json
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path

import pytest
from certificate_family import draft, nonlinearities, refutation, transfer
from flint import arb, arb_mat, fmpq, fmpq_mat, fmpq_poly
from second_plants import PLAIN, assert_accepted_if
from tampering import assert_both_reject, edited, refused_again

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import counterexamples, recheck
from lure.analysis.certificates.second.axis import require_same
from lure.analysis.certificates.second.channel_gains import _ramp
from lure.analysis.certificates.second.classes import NO_REST
from lure.analysis.certificates.second.frequencies import require_vertices
from lure.analysis.certificates.second.gains import positive_root, require_crossing, unstable_kind
from lure.analysis.certificates.second.numerics import ball, to_fmpq, working_precision
from lure.analysis.certificates.second.orbits import Stay, Watched, _Equations
from lure.analysis.certificates.second.reading import NotShown, count, mapping, number
from lure.analysis.certificates.second.systems import Delayed, Rational, States

STORED = json.loads((Path(__file__).parents[1] / "support" / "certificates.json").read_text())
SWITCHED = [name for name, one in STORED.items() if one["proof"]["method"] == "switched-gain"]


@pytest.mark.parametrize("name", SWITCHED)
def test_each_of_the_gains_that_jump_lies_in_the_class(name):
    certificate = copy.deepcopy(STORED[name])
    assert recheck(certificate).accepted
    gains = [Fraction(g) for g in certificate["proof"]["gains"]]
    assert min(gains) < max(gains)
    top = (min(gains) + max(gains)) / 2  # some gains are in this class, and not all
    certificate["laws"]["sector"][1] = str(top)
    assert "not in the class" in recheck(certificate).reason


def test_the_coefficients_written_are_not_those_of_the_negative_inequality():
    own = fmpq_poly([1, 2, 3])
    require_same(2 * own, own, [])
    with pytest.raises(NotShown, match="not those of the inequality"):
        require_same(-own, own, [])


# det(1 + D G) = 1 - g: it vanishes at the gain 1 and at no smaller one
@pytest.mark.parametrize(("width", "regular"), [(Fraction(9, 10), True), (Fraction(1), False), (Fraction(2), False)])
def test_a_loop_is_well_posed_at_the_vertices_too(width, regular):
    D = fmpq_mat([[-1]])
    if regular:
        require_vertices(D, [width])
        return
    with pytest.raises(NotShown, match="vanishes"):
        require_vertices(D, [width])


@pytest.mark.parametrize("value", [3, [1], None, {1: 2}])
def test_what_is_no_object_of_json_is_refused(value):
    with pytest.raises(NotShown, match="object is missing"):
        mapping(value)


@pytest.mark.parametrize(("read", "value"), [(number, 0.5), (number, True), (number, None), (count, -1), (count, True)])
def test_what_is_no_number_of_a_file_is_refused(read, value):
    with pytest.raises(NotShown):
        read(value)


# sigma+ + sigma = -3 u, u = -phi = -1 for sigma = 1 and 2
def test_an_orbit_with_a_constant_input_does_not_rest():
    flat = {"points": [["0", "0"], ["1", "1"], ["2", "1"]], "left": "1", "right": "1/2", "u": ["-1", "-1"]}
    given = transfer("-3", "1 1", "discrete"), nonlinearities("1/2", "1")
    found = dict(complete_and_check(refutation(*given, {"method": "orbit", **flat, "sigma": ["1", "2"]})).certificate)
    assert found["conclusion"] == NO_REST
    assert recheck(found).accepted


@pytest.mark.parametrize(
    ("change", "fits"),
    [
        ({}, True),
        ({"gains": ["0", "1"]}, False),
        ({"times": ["1", "2"]}, False),
        ({"times": ["1", "2", "0"]}, False),
        ({"times": ["1", "2", "-1/2"]}, False),
        ({"gains": ["0", "1", "3"]}, False),
        ({"gains": ["0", "1", "-1"]}, False),
        ({"gains": [], "times": []}, False),
    ],
)
@pytest.mark.parametrize("free", [{"time_varying": True}, {}, {"time_varying": True, "linear": True}])
def test_gains_that_jump_beside_a_dead_time_are_of_the_class(monkeypatch, change, fits, free):
    monkeypatch.setattr(counterexamples, "require_returning", lambda *_: None)
    loop = Delayed(terms=((Fraction(1), fmpq_poly([1])),), d=fmpq_poly([1, 1]))
    proof = {
        "method": "switched-gain",
        "gains": ["0", "1", "2"],
        "times": ["1", "2", "3"],
        "multiplier": ["1"],
        "bits": 64,
    }
    with assert_accepted_if(fits and free == {"time_varying": True}):
        counterexamples._require_jumps(proof | change, loop, replace(PLAIN, upper=Fraction(2), slope=None, **free))


def test_an_orbit_has_as_many_durations_as_pieces():
    for found in (one for one in STORED.values() if one["proof"]["method"] == "flow-orbit"):
        assert recheck(found).accepted
        for name, kept in product(("pieces", "durations", "state"), (slice(-1), slice(1), slice(0))):
            assert refused_again(edited(found, "proof", name, value=lambda rows, kept=kept: rows[kept]))


# y = sin t, which is 1 at pi/2 and below 0 from pi on; it begins at 0, where it ascends
@pytest.mark.parametrize(
    ("low", "high", "enters", "duration", "stays"),
    [
        (Fraction(-1, 2), Fraction(9, 10), 0, Fraction(5, 2), False),
        (Fraction(-1, 2), Fraction(11, 10), 0, Fraction(5, 2), True),
        (Fraction(-1, 10), Fraction(2), 0, Fraction(7, 2), False),
        (Fraction(-1, 10), Fraction(2), 0, Fraction(3), True),
        (Fraction(0), None, 1, Fraction(3), True),
        (Fraction(0), None, 1, Fraction(7, 2), False),
    ],
)
def test_a_solution_stays_on_its_piece_from_beginning_to_end(low, high, enters, duration, stays):
    G = (
        (Fraction(0), Fraction(1), Fraction(0)),
        (Fraction(-1), Fraction(0), Fraction(0)),
        (Fraction(0), Fraction(0), Fraction(0)),
    )
    one = Watched(row=(Fraction(1), Fraction(0), Fraction(0)), low=low, high=high, enters=enters, leaves=0)
    with working_precision(128):
        equations = _Equations(2, [Stay(G=G, entry=one.row, watched=(one,))], half=False)
        start = arb_mat([[0], [1], [1]])
        assert equations.on_its_piece(0, one, start, arb(fmpq(duration.numerator, duration.denominator))) is stays


# G(t) = a + (b - a) t/T commutes with itself at all times: exp(T (a + b)/2)
@pytest.mark.parametrize(("first", "last", "time"), [(1, 3, 1), (3, -1, 2), (-1, 1, Fraction(1, 3))])
def test_a_gain_that_goes_linearly_acts_by_its_mean(first, last, time):
    with working_precision(128):
        found = _ramp(arb_mat([[first]]), arb_mat([[last]]), ball(time))[0, 0]
        exact = (ball(time) * (first + last) / 2).exp()
        assert found.overlaps(exact)
        assert abs(found - exact) < arb(2) ** -100


# s + 1 + g n_0 exp(-s) is 1 + g n_0 at 0; a pole at 0 at the least gain of a class is its critical case
@pytest.mark.parametrize(
    ("top", "below", "gain", "kind"),
    [
        (2, [1, 1], Fraction(-3, 4), "no rest"),
        (2, [1, 1], Fraction(-1, 2), "equilibria"),
        (2, [1, 1], Fraction(-1, 4), None),
        (Fraction(1, 2), [1, 1], Fraction(-1), None),
        (1, [0, 1], Fraction(0), None),
        (1, [0, 1], Fraction(-1), "no rest"),
    ],
)
def test_a_gain_beside_a_dead_time_by_its_sign_at_0(top, below, gain, kind):
    loop = Delayed(terms=((Fraction(1), fmpq_poly([to_fmpq(Fraction(top))])),), d=fmpq_poly(below))
    if kind is None:
        with pytest.raises(NotShown, match="critical case" if gain == 0 else "no real root"):
            positive_root(loop, gain, Fraction(0))
        return
    assert positive_root(loop, gain, Fraction(-5)) == kind


def test_a_pole_at_0_within_a_class_rests_anywhere():
    loop = Delayed(terms=((Fraction(1), fmpq_poly([1])),), d=fmpq_poly([0, 1]))
    assert positive_root(loop, Fraction(0), Fraction(-1, 2)) == "equilibria"


# two eigenvalues 0 (z = 1): with two eigenvectors every solution is constant, with one some grow like t
@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(("coupling", "kind"), [(0, "equilibria"), (1, "no rest")])
def test_eigenvectors_at_rest_are_counted(discrete, coupling, kind):
    one, zero = Fraction(int(discrete)), Fraction(0)
    state = States(A=((one, Fraction(coupling)), (zero, one)), b=(zero, zero), c=(zero, zero), d=zero)
    assert unstable_kind(Rational(discrete=discrete, states=state, given=None), zero) == kind


# s + 1/2 + g exp(-s) has the root i w where w cos w + sin w/2 = 0, w = 1.8366, g = 1.9034; with no term there is none
@pytest.mark.parametrize(("top", "holds"), [([1], True), ([], False)])
def test_a_loop_without_a_numerator_has_the_roots_of_its_denominator(top, holds):
    loop = Delayed(terms=((Fraction(1), fmpq_poly(top)),), d=fmpq_poly([fmpq(1, 2), 1]))
    gains, band = (Fraction(1), Fraction(3)), (Fraction(1), Fraction(5, 2))
    if holds:
        require_crossing(loop, gains, band)
        return
    with pytest.raises(NotShown):
        require_crossing(loop, gains, band)


# 1 + g D vanishes for g = 2, or -2, between the two gains
@pytest.mark.parametrize(("direct", "low", "high"), [("-1/2", 1, 3), ("1/2", -3, 1)])
def test_no_gain_between_two_may_be_without_solution(direct, low, high):
    state = States(A=((Fraction(-1),),), b=(Fraction(1),), c=(Fraction(1),), d=Fraction(direct))
    loop = Rational(discrete=False, states=state, given=None)
    with pytest.raises(NotShown, match="has no solution"):
        require_crossing(loop, (Fraction(low), Fraction(high)), (Fraction(0), Fraction(1)))


def multivariable(A, B, C, D=None, **more):
    direct = D or [["0"] * len(C) for _ in C]
    return {"kind": "multivariable", "time": "continuous", "A": A, "B": B, "C": C, "D": direct, **more}


# one gain g in both channels of x' = -x - c (g x + g x): the sum of all four corners is 4 (s + 1 + c) for g in [0, 1]
ONE_GAIN = draft(
    multivariable([["-1"]], [["1", "1"]], [["-1/4"], ["-1/4"]]),
    {"channels": [nonlinearities("0", "1", linear=True)] * 2, "repeated": True},
    "constant-gains",
    {},
    {"method": "hull", "tree": {"omega": [], "directions": [["1", "0"]]}},
)
SCALED = refutation(  # sigma+ = u = -sigma/2
    transfer("1", "1 0", "discrete"),
    nonlinearities("0", "1"),
    {"method": "orbit", "scale": "-1/2", "u": ["-1/2"], "sigma": ["1"]},
) | {"rate": "1/2"}


UNIT, UNIT_OFF = ([[str(v * (i == j)) for j in range(2)] for i in range(2)] for v in (1, -1))
FULL = nonlinearities("-9/10", "9/10", time_varying=True) | {"operator": "full block"}


def late(A, B, C, D, *times):
    return multivariable(A, B, C, D, late=list(times)) | {"kind": "multivariable delay"}


DIP = draft(
    late([["0", "1"], ["-9/4", "-3/20"]], [["0"], ["1"]], [["0", "-3/40"]], [["0"]], ["1", [["0", "1/100"]]]),
    {"channels": [nonlinearities("0", "1", time_varying=True)], "repeated": False},
    "piecewise-circle",
    {"lambda": ["1"], "pieces": [[None], [None]]},
    {"method": "pieces", "ends": ["1"]},
)


def performance(bound):
    return nonlinearities(f"-{bound}", bound, time_varying=True) | {"operator": "performance"}


def slow_gain(low, high, rate):
    ends = {"slope": [low, high], "odd": True, "linear": True, "time_varying": True, "rate": rate}
    return nonlinearities(low, high) | ends


SLOW = draft(
    multivariable([["-1"]], [["1", "1"]], [["1"], ["1"]]),
    {"channels": [slow_gain("0", "1", "1"), nonlinearities("0", "1")], "repeated": False},
    "parameter-dependent",
    {"lambda": [["1"]], "theta": ["1"]},
    {"method": "spline", "degree": 1, "pieces": [1], "P": [[["1"]], [["1"]]], "exponent": 0},
)


def on_a_line(interval, cuts, pieces, verdict="PROVED"):
    graph = {"kind": "piecewise-polynomial", "cuts": cuts, "pieces": pieces}
    theorem = "scalar" if verdict == "PROVED" else "counterexample"
    proof = {"method": "signs", "interval": interval}
    return draft(multivariable([["-1"]], [["1"]], [["1"]]), {"graphs": [graph]}, theorem, {}, proof, verdict=verdict)


CUBE = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "3", "1"]}  # below 8
LAWS = ("laws", "channels")
FORGED = {  # what both checkers accept, and what is then changed, so that it would be false, or is not shown
    "a gain in two channels, unstable": (ONE_GAIN, {("system", "C"): [["-3/4"], ["-3/4"]]}),
    "gains that are functions": (ONE_GAIN, {(*LAWS, 0, "linear"): False, (*LAWS, 1, "linear"): False}),
    "gains above the largest": (
        draft(CUBE, nonlinearities("-1/2", "79/10", linear=True), "hurwitz", {}),
        {("laws", "sector"): ["-1/2", "17/2"]},
    ),
    # 1 + u Re H > 0 for -1/(s (s - 1)), whose residue at 0 is 1 and which has the pole 1
    "a pole beside that at 0": (
        draft(transfer("1", "1 1 0"), nonlinearities("0", "1/2"), "circle", {}),
        {("system", "numerator"): ["-1"], ("system", "denominator"): ["1", "-1", "0"]},
    ),
    "a numerator of a higher degree": (
        draft(transfer("1", "1 1"), nonlinearities("0", "1"), "circle", {}),
        {("system", "numerator"): ["1", "1", "1"]},
    ),
    # exp(t/2), and exp(-t) for t = -1/2
    "gains for a negative time": (
        refutation(
            transfer("1", "1 -1"),
            nonlinearities("0", "1/2", time_varying=True),
            {"method": "switched-gain", "gains": ["0"], "times": ["1/2"], "squarings": 4, "bits": 96},
        ),
        {("system", "denominator"): ["1", "1"], ("proof", "times"): ["-1/2"]},
    ),
    # sigma+ = u = -phi(sigma): 1, -1, 1, ... with phi = sigma; phi(-1) = -1/2 is in the class
    "an orbit off its graph": (
        refutation(
            transfer("1", "1 0", "discrete"),
            nonlinearities("0", "1"),
            {
                "method": "orbit",
                "points": [["-1", "-1"], ["0", "0"], ["1", "1"]],
                "left": "0",
                "right": "0",
                "u": ["-1", "1"],
                "sigma": ["1", "-1"],
            },
        ),
        {("proof", "points", 0, 1): "-1/2"},
    ),
    "a scaled orbit below its sector": (SCALED, {("laws", "sector"): ["3/4", "1"]}),
    "a scaled orbit above its sector": (SCALED, {("laws", "sector"): ["0", "1/4"]}),
    "a scaled orbit with phi(0) = -1": (  # sigma+ = sigma/2 + u
        SCALED,
        {
            ("system", "denominator"): ["1", "-1/2"],
            ("proof", "sigma"): ["0", "1"],
            ("proof", "u"): ["1", "-1/2"],
            ("proof", "scale"): "1/4",
        },
    ),
    "a scaled orbit at rest": (SCALED, {("proof", "sigma"): ["0"], ("proof", "u"): ["0"]}),
    "a scaled orbit in continuous time": (SCALED, {("system", "time"): "continuous"}),
    # x' = -x - phi(x): phi = -x^3 leaves (-1, 1) to 0; -2 x for x < 0 does not
    "signs on one side": (
        on_a_line(["-1", "1"], [], [["0", "0", "0", "-1"]]),
        {("laws", "graphs", 0, "cuts"): ["0"], ("laws", "graphs", 0, "pieces"): [["0", "-2"], ["0"]]},
    ),
    "signs beyond a cut at the end": (
        on_a_line(["-1", "1"], [], [["0", "0", "0", "-1"]], verdict="REFUTED"),
        {("laws", "graphs", 0, "cuts"): ["-1", "1"], ("laws", "graphs", 0, "pieces"): [["0"]] * 3},
    ),
    # q' = v, v' = -v - phi(q) + w, z = v, V = v^2 + 2 int phi: (v - w)^2; with no weights and V = 0 nothing is said
    "a gain without a weight": (
        draft(
            multivariable([["0", "1"], ["0", "-1"]], [["0", "0"], ["1", "1"]], UNIT),
            {"channels": [nonlinearities("0", "5"), performance("1")], "repeated": False},
            "diagonal-popov",
            {"lambda": ["0", "1/2"], "theta": ["1", "0"]},
            {"method": "matrix", "P": [["0"], ["0", "1"]], "exponent": 0, "semidefinite": True},
        ),
        {
            ("multiplier",): {"lambda": ["0", "0"], "theta": ["0", "0"]},
            ("proof", "P"): [["0"], ["0", "0"]],
            (*LAWS, 1, "sector"): ["-100", "100"],
        },
    ),
    # i w + g exp(-i w) = 0 for g = w = pi/2 = 1.570796...
    "a crossing beside its gains": (
        refutation(
            late([["0"]], [["1"]], [["0"]], [["0"]], ["1", [["1"]]]),
            {"channels": [nonlinearities("0", "2", time_varying=True)], "repeated": False},
            {
                "method": "late-crossing",
                "gains": [["157/100"], ["15716/10000"]],
                "frequencies": ["15706/10000", "15710/10000"],
                "turn": ["0", "1"],
            },
        ),
        {("proof", "gains"): [["157/100"], ["15707/10000"]]},
    ),
    # exp(-s)/(s + 1) and the gain -1/2: 1/|T| = .52439 at 1/10, whatever the phase of the input
    "a gain of an input with another phase": (
        refutation(
            late([["-1"]], [["1", "1"]], [["0"], ["0"]], [["0", "0"]] * 2, ["1", [["1"], ["1"]]]),
            {"channels": [nonlinearities("-1/2", "1/2", time_varying=True), performance("10/19")], "repeated": False},
            {
                "method": "delayed-members",
                "gains": ["-1/2", "0"],
                "delays": [],
                "omega": "1/10",
                "input": [["3/5", "4/5"]],
            },
        ),
        {(*LAWS, 1, "sector"): ["-1/2", "1/2"]},
    ),
    # x' = -(1 + g) x, V = P x^2 with P from 3 to 1 for g from 1 to 2: -V' is 12 - 2 |g'| to 6 - 2 |g'| at its least
    "a gain that changes too fast": (
        draft(
            multivariable([["-1"]], [["1"]], [["1"]]),
            {"channels": [slow_gain("1", "2", "5/2")], "repeated": False},
            "parameter-dependent",
            {"lambda": [[]], "theta": []},
            {"method": "spline", "degree": 1, "pieces": [1], "P": [[["3"]], [["1"]]], "exponent": 0},
        ),
        {(*LAWS, 0, "rate"): "4"},
    ),
    # x' = -(1 + g) x - phi(x), V = x^2 + 2 int phi, lambda = 1: 2 (1 + g) x^2 + 2 (1 + g) x phi + 4 phi^2
    "Popov's term in samples beside a gain": (SLOW, {("system", "time"): "discrete", ("system", "A"): [["1"]]}),
    "Popov's term of a function that depends on time": (SLOW, {(*LAWS, 1, "time_varying"): True}),
    "Popov's term of an output with a direct term": (SLOW, {("system", "D", 1, 1): "1/100"}),
    # -2 z w_0 s/(s^2 + 2 z w_0 s + w_0^2), z = 1/20, is -1 at w_0 and small elsewhere: twice that at 3/2, and at 5/2
    "a dip beyond the last piece": (DIP, {("system", "C"): [["0", "-3/10"]]}),
    "a dip farther out": (
        DIP,
        {("system", "C"): [["0", "-1/2"]], ("system", "A"): [["0", "1"], ["-25/4", "-1/4"]]},
    ),
    # 1 + (1 + theta w^2)/(1 + w^2): with theta = -2 below 0 from w = 1.42 on alone
    "Popov's term far out": (
        draft(
            multivariable([["-1"]], [["1"]], [["1"]]),
            {"channels": [nonlinearities("0", "1")], "repeated": False},
            "piecewise-popov",
            {"lambda": ["1"], "theta": ["2"], "pieces": [[None], [None]]},
            {"method": "pieces", "ends": ["5/4"]},
        ),
        {("multiplier", "theta"): ["-2"]},
    ),
    # exp(-T s)/s, T <= 1: 1/u - T sin(w T)/(w T) + theta cos(w T) > 0 for u = 1/3 and a small theta of either sign
    "Popov's term below 0 beside dead times and a pole at 0": (
        draft(
            {
                **{
                    "kind": "delay-family",
                    "time": "continuous",
                    "parameters": [["T", "1/2", "1"]],
                    "delay": ["0", "1"],
                },
                "terms": [{"powers": [0], "numerator": ["0", "1"], "denominator": ["1", "0"]}],
            },
            nonlinearities("0", "1/3"),
            "popov",
            {},
            {"method": "boxes", "boxes": {"multiplier": {"theta": "1/100"}}},
        ),
        {("proof", "boxes", "multiplier", "theta"): "-1/100"},
    ),
    "two weights of a full block": (
        draft(
            late(UNIT_OFF, UNIT, [["0", "0"]] * 2, [["0", "0"]] * 2, ["1", UNIT]),
            {"channels": [FULL] * 2, "repeated": True},
            "piecewise-circle",
            {"lambda": ["1", "1"], "pieces": [[None] * 2] * 2},
            {"method": "pieces", "ends": ["1"]},
        ),
        {("multiplier", "lambda"): ["1", "2"]},
    ),
    "a channel without an upper bound": (
        draft(
            late([["-2"]], [["1"]], [["0"]], [["0"]], ["1", [["1"]]]),
            {"channels": [nonlinearities("-1", "0", time_varying=True)], "repeated": False},
            "piecewise-circle",
            {"lambda": ["1"], "pieces": [[None], [None]]},
            {"method": "pieces", "ends": ["1"]},
        ),
        {(*LAWS, 0, "sector"): ["-1", "inf"]},
    ),
}


@pytest.mark.parametrize("name", FORGED)
def test_neither_checker_accepts_what_is_forged(name):
    given, edits = FORGED[name]
    found = dict(complete_and_check(copy.deepcopy(given)).certificate)
    assert recheck(found).accepted, recheck(found).reason
    for path, value in edits.items():
        found = edited(found, *path, value=value)
    assert_both_reject(found)

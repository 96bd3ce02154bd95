"""Guards of the first checker that no other of its tests held, by mutants that lived; values are worked out here."""

from fractions import Fraction as F

import pytest
from certificate_family import draft, nonlinearities

from lure.analysis.certificates import memory, pieces, windows
from lure.analysis.certificates.arithmetic import IllPosed, Rejected
from lure.analysis.certificates.channels import Plant, channels
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.memory import from_rest
from lure.analysis.certificates.second import recheck
from lure.analysis.certificates.systems import system_of
from lure.plants.family import PlantFamily


# g (1, 1) = (1, 1) for g = 1; for (1, 0) the least squares give g = 1/2 and (1/2, 1/2)
def test_each_row_has_to_fit():
    rows = [[F(1)]], [[F(1)]]
    assert from_rest(*rows, [[F(1), F(1)]]) == [[F(1)]]
    assert from_rest(*rows, [[F(1), F(1)], [F(1), F(0)]]) is None
    assert from_rest(*rows, [[F(1), F(0)], [F(1), F(1)]]) is None


# s + K e^-s has 2 roots to the right for K between pi/2 and 5 pi/2, 2 more with every 2 pi; s - 1 + g e^-s/10 has one
# for g < 1, and none just beyond; what comes back late in the state counts as the gain does
@pytest.mark.parametrize(
    ("A", "back", "delay", "gain", "roots"),
    [
        (0, 0, 1, F(1), 0),
        (0, 0, 1, F(2), 2),
        (0, 0, 1, F(9), 4),
        (0, 0, 1, F(-1), 1),
        (1, 0, F(1, 10), F(1, 2), 1),
        (1, 0, F(1, 10), F(2), 0),
        (0, -9, 1, F(0), 4),
        (1, F(1, 2), F(1, 10), F(0), 1),
    ],
)
def test_roots_of_a_loop_with_dead_time_are_counted(A, back, delay, gain, roots):
    inner = ([[F(back)]],) if back else ()
    plant = Plant([[F(A)]], [[F(1)]], [[F(0)]], [[F(0)]], False, ((F(delay), [[F(1)]]),), inner)
    assert pieces.right_roots(plant, [gain])[0] == roots


# (s - 2)/(s + 1), gains from 1/4 on: (1 + g) s + 1 - 2 g, a pole at 0 for g = 1/2; V = x^2, and H(inf) = 1
@pytest.mark.parametrize(("upper", "proved"), [("49/100", True), ("51/100", False)])
def test_a_form_falls_up_to_the_gain_with_a_pole_at_zero_also_beside_a_feedthrough(upper, proved):
    system = {"kind": "transfer", "time": "continuous", "numerator": ["1", "-2"], "denominator": ["1", "1"]}
    proof = {"method": "powers", "power": 1, "P": [["1"]], "lower": [["0"]], "upper": [["0"]]}
    laws = nonlinearities("1/4", upper, time_varying=True)
    given = draft(system, laws, "homogeneous-lyapunov", {}, proof)
    if proved:
        assert recheck(complete_and_check(given).certificate).accepted
        return
    with pytest.raises(Rejected, match="falls with the gain at the upper end"):
        complete_and_check(given)


# -1 - 1/(s + 1): the gain g leaves -1 + g/(1 - g), which is stable for g < 1/2 and again for g > 1, -3 for 2: V falls
# for the gains at both ends, and 1 + g H(inf) vanishes in between
@pytest.mark.parametrize(("low", "high", "proved"), [("0", "49/100", True), ("0", "2", False), ("1/4", "5/4", False)])
def test_a_form_that_falls_at_both_ends_needs_a_loop_in_between(low, high, proved):
    system = {"kind": "transfer", "time": "continuous", "numerator": ["-1", "-2"], "denominator": ["1", "1"]}
    proof = {"method": "powers", "power": 1, "P": [["1"]], "lower": [["0"]], "upper": [["0"]]}
    found = draft(system, nonlinearities(low, high, time_varying=True), "homogeneous-lyapunov", {}, proof)
    if proved:
        assert recheck(complete_and_check(found).certificate).accepted
        return
    with pytest.raises(IllPosed):
        complete_and_check(found)


# A form of ReLUs on the channels of a ReLU and of an operator: the operator alone forbids it, and one that is no ReLU.
@pytest.mark.parametrize("kind", ["sector", "relu"])
def test_no_form_has_an_operator_among_its_channels(kind):
    law = {"sector": ["0", "1"], "slope": ["0", "1"], "odd": False, "time_varying": False, "linear": False}
    operator = law | {"sector": ["-1", "1"], "slope": None, "time_varying": True, "operator": "any"}
    asked = channels({"channels": [law | ({"relu": True} if kind == "relu" else {}), operator], "repeated": False}, 2)
    rows = [["1", "0"], ["0", "1"]] if kind == "sector" else [["0"] * (i + 1) for i in range(4)]
    with pytest.raises(Rejected, match="an operator has a weight"):
        windows.coupled([{"kind": kind, "channels": [1, 2], "rows": rows}], asked, 1, summed=False)


# (a s + 1)/(s^2 + s + 1) has H(inf) = 0, (a s^2 + 1)/(s^2 + s + 1) the value a in one of its two terms
def test_a_term_of_the_numerator_may_not_feed_through():
    def given(numerator):
        family = PlantFamily.of_coefficients(numerator, [1, 1, 1], {"a": (1, 2)})
        laws = nonlinearities("0", "1/100")
        tree = {"multiplier": {}}
        return draft(system_of(family), laws, "circle", {}, {"method": "boxes", "boxes": tree})

    assert check(complete_and_check(given(["a", 1])).certificate)
    with pytest.raises(Rejected, match=r"H\(inf\) = 0 is needed"):
        complete_and_check(given(["a", 0, 1]))


# Where phi_i = k_i sigma_i the inequalities below storage functions are equalities, so that what is added to V moves at
# the rate that is added: sum 2 (a z)(b z), z = (y, phi'), of a form in (y, phi); A and C = B' are such that Theta H(0)
# is symmetric.  With A = 0 in the second state phi = f y
GAINS = [F(1, 2), F(1, 3)]
ROOM, FREE = [[F(-3), F(1)], [F(1), F(-2)]], [[F(-3), F(0)], [F(0), F(0)]]


def storing(A, kinds, discrete):
    m = len(kinds)
    B = [[F(1), F(-4)], [F(2), F(5)]] if m == 2 else [[F(0)], [F(1)]]
    laws = [nonlinearities(0, k, slope=["0", str(k)]) for k in GAINS[:m]]
    laws = [law | ({"memory": kind} if kind else {}) for law, kind in zip(laws, kinds, strict=True)]
    T = [[v + (i == j) * discrete for j, v in enumerate(row)] for i, row in enumerate(A)]
    H = Plant(T, B, [list(row) for row in zip(*B, strict=True)], [[F(0)] * m] * m, discrete)
    return H, channels({"channels": laws, "repeated": False}, m)


@pytest.mark.parametrize(
    ("A", "kinds", "theta"),
    [
        (ROOM, ("stop", ""), (0, 0)),
        (ROOM, ("play", ""), (2, 0)),
        (ROOM, ("play", "play"), (2, 3)),
        (ROOM, ("play", "stop"), (2, 2)),
        (ROOM, ("play", "play"), (-2, -2)),
        (ROOM, ("", ""), (2, 2)),
        (FREE, ("stop",), (2,)),
        (FREE, ("play",), (2,)),
    ],
)
def test_storage_functions_have_their_signs_and_a_symmetric_form(A, kinds, theta):
    for discrete in (False, True):
        with pytest.raises(Rejected):
            memory.storages(*storing(A, kinds, discrete), [F(t) for t in theta])


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(
    ("A", "kinds", "theta"),
    [
        (ROOM, ("play", "play"), (2, 2)),
        (ROOM, ("stop", "stop"), (-2, -2)),
        (ROOM, ("play", ""), (2, 2)),
        (ROOM, ("stop", ""), (-2, -2)),
        (FREE, ("stop",), (-2,)),
    ],
)
def test_storage_functions_move_as_is_said_where_their_inequalities_are_sharp(A, kinds, theta, discrete):
    H, asked = storing(A, kinds, discrete)
    gains, given = GAINS[: len(kinds)], (H, asked, [F(t) for t in theta])
    if A is FREE and discrete:
        with pytest.raises(Rejected, match="an eigenvalue 1"):
            memory.storages(*given)
        return
    pairs, V = memory.storages(*given)

    def along(M, x):
        return [sum((v * w for v, w in zip(row, x, strict=True)), F(0)) for row in M]

    def at(x):
        phi = [k * v for k, v in zip(gains, along(H.C, x), strict=True)]
        return [v - w for v, w in zip(along(A, x), along(H.B, phi), strict=True)], phi

    for x in ([F(1), F(0)], [F(2), F(-3)], [F(-1), F(7)]):
        y, phi = at(x)
        moved, turned = at(y)  # y' and phi', in discrete time the differences
        z, rate = ([*y, *phi], [*moved, *turned]) if A is ROOM else (y, moved)
        ends = [z, [v + w for v, w in zip(z, rate, strict=True)]]
        first, last = (sum(v * w for v, w in zip(along(V, one), one, strict=True)) for one in ends)
        change = last - first if discrete else 2 * sum(v * w for v, w in zip(along(V, z), rate, strict=True))
        whole = [*y, *turned]
        assert change == 2 * sum(along([a], whole)[0] * along([b], whole)[0] for a, b in pairs)

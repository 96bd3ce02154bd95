"""What a checker with one wrong sign, bound or constant would answer otherwise; each value is worked out beside it."""

import json
import math
from fractions import Fraction as F

import pytest
from certificate_family import ROD, SCHEME, certificate, changed, delayed, on_both, refutation, transfer

from lure.analysis.certificates import arithmetic as exact
from lure.analysis.certificates import balls, blocks, checker, states
from lure.analysis.certificates.arithmetic import INF, Form, Malformed, Rejected, real
from lure.analysis.certificates.balls import Ball
from lure.analysis.certificates.blocks import block, realised, rod
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.refutations import flow_orbit_proof
from lure.analysis.certificates.states import Family, inside, known, piecewise, solvable
from lure.analysis.counterexamples.linear import companion
from lure.analysis.counterexamples.piecewise import Flow, PiecewiseLoop, returns
from lure.nonlinearities.piecewise_linear import Graph
from lure.plants.rational import RationalPlant

SWING = [[F(0), F(1), F(0)], [F(-1), F(0), F(0)], [F(0), F(0), F(0)]]
DRIFT = [[F(0), F(1), F(0)], [F(0), F(0), F(0)], [F(0), F(0), F(0)]]
ONE = 2**128


def family(low, high, *, slope=(-INF, INF), endless=(False, False), linear=False):
    return Family((low, high), slope, endless, False, False, linear)


# -- matrices ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bits", [64, 68])  # 2^69 > 256^7 7! > 2^68: at 68 bits one term more than without the factor 2
def test_the_error_of_an_exponential_counts_every_rounding(bits):
    # exp(0): X = 0 +- 1 unit; the rule for products of numbers is "|X| e_Y + e_X |Y| and 2 units"
    one, e, total, rest, j = 2**bits, 1, 1, 2 ** (bits + 1), 0
    term = one
    while rest:
        j += 1
        e = ((term + e) * 1 + e * 1 >> bits) + 2  # |term| e_X + e_term |X|, |X| = 0 + 1
        term, e = 0, e // j + 2
        total, rest = total + e, rest // (256 * j)
    total += 1  # the terms left out
    for _ in range(8):
        total = (2 * (one + total) * total >> bits) + 2
    assert balls.exponential([[F(0)]], F(1), bits) == Ball([[one]], total, bits)


def test_products_are_cut_off_at_32_times_their_digits():
    assert balls.product(Ball([[2**31]], 0, 2), Ball([[2**30]], 0, 2)).rows == [[2**59]]  # 32 + 31 < 64 digits
    with pytest.raises(Rejected, match="too large"):
        balls.product(Ball([[2**31]], 0, 2), Ball([[2**31]], 0, 2))


def test_definiteness_of_rows_of_unlike_size():
    assert not balls.positive_definite([[2**200], [2**125, 2**10]])  # 2^210 - 2^250 < 0
    assert not balls.positive_definite([[2**200], [2**106, 2**10]])
    assert balls.positive_definite([[2**200], [2**104, 2**10]])  # 2^210 - 2^208
    # a gap of 2^-487 is beyond the 480 digits that are tried
    assert not balls.positive_definite([[2**1000], [2**1000, 2**1000 + 2**513]])
    assert balls.positive_definite([[2**1000], [2**1000, 2**1000 + 2**525]])


# -- signs -------------------------------------------------------------------------------------------------------------


def test_a_dip_inside_is_seen_where_the_ends_are_positive():
    assert not exact.positive([F(1), F(-3), F(1)], F(0), F(5))  # roots at 0.38 and 2.62
    assert not exact.positive([F(0), F(1)], F(0), F(5))
    # x^4/6 - x^3 is least at 9/2, -22.8 there, and 0 at 0 and 6
    assert exact.positive([F(23), F(0), F(0), F(-1), F(1, 6)], F(0), F(6))
    assert not exact.positive([F(20), F(0), F(0), F(-1), F(1, 6)], F(0), F(6))


def test_a_box_takes_off_twice_the_error_of_the_cosine():
    # at the point omega = 1 the remainder of Taylor's formula is 0: left is cos - 2 e - K
    E = balls.exponential([[F(0), F(-1)], [F(1), F(0)]], F(1), 160)
    for spare, holds in ((0, False), (1, True), (-1, False)):
        K = F(E.rows[0][0] - 2 * E.error - spare, 2**160)
        assert balls.box(Form({(F(1), 0): (F(1), F(0))}) + real(-K), F(1), F(1), 8) is holds


def test_a_box_is_over_omega_squared_only_if_the_first_two_vanish():
    assert not balls.box(real(-1, 0, 5), F(0), F(1), 4, True)
    assert not balls.box(real(0, -1, 5), F(0), F(1), 4, True)


# -- motions between two sides -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1, -1])
def test_one_step_of_a_swing_to_the_last_unit(sign, monkeypatch):
    # y = cos s on one step h = 1/2.  Each a_j is off by e: R by 3 units (columns), times |X| = 1, and 2:
    # e = 3 + 1 + 1.  v = 0.  turn = sum j (|a_j| + e), j = 2..11, + 2 12 (1/2)^12/12! in units of 2^-64 and one, + 1
    monkeypatch.setattr(states, "DEEPEST", 0)
    e = 5
    series = sum(j * round(F(ONE, 2**j * math.factorial(j))) for j in range(2, 12, 2)) + e * sum(range(2, 12))
    rest = int(F(24 * 2**64, 2**12 * math.factorial(12))) + 1
    turn = series + rest * 2**64 + 1
    X = Ball([[sign * ONE], [0], [ONE]], 0, 128)
    for spare, stays in ((0, False), (1, True)):
        edge = sign * F(ONE - 2 * e - turn - spare, ONE)
        sides = (edge, INF) if sign > 0 else (-INF, edge)
        r = F(1, 2**90)
        assert inside(SWING, X, (F(1, 2) - r, r), on_both(sides)) is stays
    # and a time known no better than it is long is not known
    assert not inside(SWING, X, (F(1, 4), F(1, 4)), on_both((-F(2), F(2))))
    assert inside(SWING, X, (F(3, 8), F(1, 8)), on_both((-F(2), F(2))))
    assert not inside(SWING, X, (F(1, 2), r), on_both((-F(2), F(2))))  # 2 |G| h > 1


@pytest.mark.parametrize("sign", [1, -1])
def test_leaving_a_side_takes_more_speed_than_the_error(sign, monkeypatch):
    # y = x2 s, h = 1/2: v = x2/2 units, e = 0 + 1 + 1, turn = 65 e + 0 + 1 = 131: y' > 0 is shown from v = 134 on
    monkeypatch.setattr(states, "DEEPEST", 0)
    r = F(1, 2**90)
    sides = (F(0), INF) if sign > 0 else (-INF, F(0))
    for speed, stays in ((266, False), (268, True)):
        X = Ball([[0], [sign * speed], [0]], 0, 128)
        assert inside(DRIFT, X, (F(1, 2) - r, r), on_both(sides)) is stays


@pytest.mark.parametrize(
    ("start", "peak"),
    [((F(0), F(1)), "pi/2, in the second quarter"), ((F(-15, 17), F(-8, 17)), "3.63, in the last quarter")],
)
def test_no_part_of_a_stay_is_left_out(start, peak):
    X = balls.ball([[v] for v in (*start, F(1))], 128)  # y goes up to 1 at one time within 4, and to -1
    assert inside(SWING, X, (F(4), F(1, 10**12)), on_both((F(-2), F(101, 100)))), peak
    assert not inside(SWING, X, (F(4), F(1, 10**12)), on_both((F(-2), F(99, 100)))), peak


def bent(radius, direct=F(0), left="0", right="1"):
    """Two pieces, x' = -phi(x), stays of one unit of time: never an orbit, whatever the radius."""
    proof = {
        "method": "flow-orbit",
        "points": [["0", "0"]],
        "left": left,
        "right": right,
        "pieces": [0, 1],
        "durations": ["1", "1"],
        "state": ["1"],
        "half": False,
        "inverse": [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]],
        "radius": radius,
        "bits": 64,
    }
    return states.flow_orbit(([[F(0)]], [F(1)], [F(1)], direct), family(F(0), F(2)), proof)


def test_the_radius_of_an_orbit_is_below_a_quarter_of_every_stay():
    for radius, reason in (("1/4", "positive and small"), ("249/1000", "no contraction"), ("0", "positive and small")):
        with pytest.raises(Rejected, match=reason):
            bent(radius)
    with pytest.raises(Rejected, match=r"1 \+ slope H\(inf\) > 0"):
        bent("1/10", F(-2), "2", "3/2")  # 1 - 2 2 and 1 - 2 3/2 are < 0, while 1 - 2 + 2 and 1 - 2 + 3/2 are not


# -- classes of nonlinearities
# ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("direct", "low", "slopes", "fails"),
    [
        (F(-2), F(1), [F(1), F(2)], "does not increase"),  # -1, -1, -3
        (F(-2), F(1), [F(1), F(1, 2)], "changes its sign"),  # -1, -1, 0
        (F(-2), F(0), [F(0), F(1)], "changes its sign"),  # 1, 1, -1
        (F(-3, 2), F(0), [F(0), F(1)], "changes its sign"),  # 1, 1, -1/2
        (F(-1), F(0), [F(0), F(1)], "changes its sign"),  # 1, 1, 0
        (F(-9, 10), F(0), [F(0), F(1)], ""),
    ],
)
def test_the_loop_is_solvable_if_one_sign_is_kept(direct, low, slopes, fails):
    nonlinearities = family(low, F(2))
    if not fails:
        assert solvable(direct, nonlinearities, slopes) == {"solvable": states.SOLVABLE}
    else:
        with pytest.raises(Rejected, match=fails):
            solvable(direct, nonlinearities, slopes)


def test_without_bounds_on_the_slopes_solvability_is_assumed():
    nonlinearities = family(F(0), F(1), slope=(F(0), INF))
    assert solvable(F(1), nonlinearities, [F(0), F(1)]) == {"solvable": states.SOLVABLE}
    assert solvable(F(1), nonlinearities._replace(slope=(F(0), F(1))), [F(1)])["solvable"].endswith("over the class")


def test_a_saturating_law_has_a_height_and_a_rate():
    nonlinearity = {"kind": "tanh", "height": "2", "rate": "1/2"}
    assert known(nonlinearity, family(F(0), F(1)))[1] == [0, 1]
    for part in ({"height": "0"}, {"rate": "0"}, {"height": "-2", "rate": "-1/2"}):
        with pytest.raises(Rejected, match="not in the class"):
            known({**nonlinearity, **part}, family(F(0), F(1)))
    with pytest.raises(Malformed, match="points are pairs"):
        piecewise("", "0", "0")


# -- multipliers -------------------------------------------------------------------------------------------------------


def kernels(*coefficients):
    return {"theta": "0", "kernels": [{"coefficient": c, "delay": str(i)} for i, c in enumerate(coefficients, 1)]}


@pytest.mark.parametrize(
    ("coefficients", "odd"), [((), False), (("1/4",), False), (("1/4", "-1/4"), True), (("-1/4",), True)]
)
def test_one_negative_kernel_needs_odd_laws(coefficients, odd):
    B = block(transfer("1", "1 1"))
    assert checker.multiplier("zames-falb", kernels(*coefficients), B, True)[-1] is odd


def test_the_masses_of_kernels_reach_one_only_with_a_bound():
    B = block(transfer("1", "1 1"))
    assert checker.multiplier("zames-falb", kernels("1/2", "1/2"), B, False)[-1] is False
    for masses, unbounded in ((("1/2", "1/2"), True), (("1/2", "5/8"), False), (("1/2", "-5/8"), True)):
        with pytest.raises(Rejected, match="the masses add up"):
            checker.multiplier("zames-falb", kernels(*masses), B, unbounded)


def test_the_number_and_the_order_of_kernels_are_limited():
    assert len(blocks.kernels(kernels(*["1/999"] * 400), False)[1]) == 400
    with pytest.raises(Malformed, match="taps or kernels"):
        blocks.kernels(kernels(*["1/999"] * 401), False)
    with pytest.raises(Malformed, match="a tap is a pair"):
        blocks.kernels({"taps": [{"0": 1, "1": "1/2"}]}, True)
    item = {"coefficient": "1/2", "rate": "1", "order": 20, "side": "causal"}
    assert blocks.kernels({"theta": "0", "kernels": [item]}, False)[1][0][3] == 20


def test_a_mirrored_class_has_a_bound_below():
    nonlinearities = family(F(0), INF)
    assert checker.unbounded("circle", {}, nonlinearities)
    assert not checker.unbounded("circle", {"mirrored": True}, nonlinearities)


# -- constant gains ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("numerator", "denominator", "high", "stable"),
    [
        ("0", "1 1", INF, True),  # H = 0
        ("1", "1 1", INF, True),
        ("1 2", "1 1", INF, True),
        ("-2 0 0", "1 2 1", INF, False),  # 2 w^2 - 2 w^4
        ("-1", "1 1", INF, False),  # 1 - g
        ("-1 1", "1 1", INF, False),  # 1 - g at infinity
        ("-1 2", "1 1", F(1), False),  # (1 - g) s + 1 + 2 g loses its root at g = 1
        ("-1 2", "1 1", F(9, 10), True),
        ("-2 0 0", "1 2 1", F(1), False),  # (1 - 2 g) s^2: 1 + 4 w^2 - w^4 at g = 1
        ("-2 0 0", "1 2 1", F(49, 100), True),
    ],
)
def test_constant_gains_up_to_the_limit_of_high_frequencies(numerator, denominator, high, stable):
    B, nonlinearities = block(transfer(numerator, denominator)), family(F(0), high, linear=True)
    if stable:
        assert set(checker.linear(B, nonlinearities)) == {"stable", "gains"}
    else:
        with pytest.raises(Rejected, match="has a root on the axis, or in the limit"):
            checker.linear(B, nonlinearities)


# -- the rod -----------------------------------------------------------------------------------------------------------


def test_the_rod_at_the_least_theta():
    # L |k^2 - Z^2|/(k A E) = 3 16/(5 1/2 4) = 24/5
    for theta, nonlinearities, holds in (
        ("24/5", family(F(0), F(9)), True),
        ("24/5", family(F(0), INF, endless=(False, True)), True),
        ("24/5", family(F(0), INF, endless=(True, True)), False),
        ("241/50", family(F(0), INF, endless=(True, True)), True),
        ("239/50", family(F(0), F(9)), False),
    ):
        if holds:
            assert checker.structure("rod-popov", {"theta": theta}, SCHEME, nonlinearities)[0] == checker.CONVERGES
        else:
            with pytest.raises(Rejected, match="theta is below 24/5"):
                checker.structure("rod-popov", {"theta": theta}, SCHEME, nonlinearities)


def test_the_matched_rod_has_no_reach_beyond_every_finite_bound():
    matched = {**SCHEME, "k": "3"}  # k = Z: the reach is infinite
    assert checker.structure("rod-circle", {}, matched, family(F(0), INF))[0] == checker.CONVERGES
    with pytest.raises(Rejected, match="the sector must end below"):
        checker.structure("rod-circle", {}, matched, family(F(0), INF, endless=(True, True)))
    with pytest.raises(Malformed, match="of no kind"):
        rod({**ROD, "kind": "beam"})
    assert len(realised(SCHEME, F(0))[1]) == 7
    with pytest.raises(Rejected, match="begin at 0"):
        realised(SCHEME, F(1))
    for without in (transfer("1", "1"), delayed([("1", "1")], "1 1")):
        with pytest.raises(Rejected, match="a rational block with a state"):
            realised(without, F(0))


# -- whole certificates ------------------------------------------------------------------------------------------------

REFUSED = [
    # (s + 2)(s + 1)/(s + 1)^2: positive real, with a mode that H does not show
    ("circle, no bound", {"system": transfer("1 3 2", "1 2 1")}, "no hidden modes"),
    # (z + 1)/(z - 1/2) vanishes at z = -1
    ("circle, no bound", {"system": transfer("1 1", "1 -1/2", "discrete")}, "limit of high frequencies"),
    ("popov, matrix", {"laws.sector": ["0", "finite"], "multiplier.theta": "-1"}, "the inequality of P fails"),
    ("hurwitz", {"proof": {"method": "polynomial", "variable": "omega"}}, "constant gains are proved by polynomials"),
    # s^2 - s + 1 > 0 for every s >= 0, and has its roots on the right
    (
        "linear gain, dead time",
        {"system": delayed([("1", "1")], "1 -1 1"), "proof.gain": "0"},
        "no root s >= 0 is shown",
    ),
]
SHOWN = [
    ("linear gain, dead time", {"system": delayed([("1", "1")], "1 -1 1"), "proof.gain": "-3/2"}, "has a motion"),
    ("linear gain, dead time", {"system": delayed([("1", "1")], "1 1 -1"), "proof.gain": "0"}, "has a motion"),
    (
        "linear gain, discrete",
        {"system": transfer("1", "1 0", "discrete"), "proof.gain": "1"},
        "has a motion",
    ),  # z = -1
    ("linear gain", {"system": transfer("1", "1 -1 0"), "proof.gain": "0"}, "has a motion"),  # s (s - 1)
    (
        "linear gain, discrete",
        {"system": transfer("1", "1 -1/2", "discrete"), "laws.sector": ["-1", "0"], "proof.gain": "-1/2"},
        "equilibria other than 0",
    ),
    ("crossing, rational", {"laws.sector": ["5", "7"]}, "has a motion"),
    ("linear gain", {"laws.sector": ["0", "17/2"]}, "has a motion"),
    ("linear gain", {"laws.sector": ["17/2", "9"]}, "has a motion"),
    # Re n d* = 6 + 2 w^2 + Re exp(-i w)(3 - w^2 - 4 i w)/10
    (
        "circle, dead time",
        {"system": delayed([("0", "1 2"), ("1", "1/10")], "1 4 3"), "laws.sector": ["0", "finite"]},
        "0 attracts every motion",
    ),
]


@pytest.mark.parametrize(("name", "changes", "reason"), REFUSED)
def test_one_hypothesis_short_is_refused(name, changes, reason):
    with pytest.raises(Rejected, match=reason):
        complete_and_check(changed(name, changes))


@pytest.mark.parametrize(("name", "changes", "conclusion"), SHOWN)
def test_what_just_holds_is_said(name, changes, conclusion):
    assert conclusion in complete_and_check(changed(name, changes)).certificate["conclusion"]


def test_the_root_is_said_in_the_variable_of_the_block():
    changes = {"system": transfer("1", "1 -1/2", "discrete"), "laws.sector": ["-1", "0"], "proof.gain": "-1/2"}
    assert "at z = 1 for g" in complete_and_check(changed("linear gain, discrete", changes)).facts["root"]
    assert checker.main([]) == 2


def test_a_motion_over_kinks_off_the_axis():
    # 1/4 + s/(s^2 - s/5 + 1) with slope 1/10 up to |sigma| = 1, where phi = 1/10, and 1 beyond: y = sigma + phi/4 there
    top, bottom = [F(1, 4), F(19, 20), F(1, 4)], [F(1), F(-1, 5), F(1)]
    graph = Graph.through([(-1, F(-1, 10)), (0, 0), (1, F(1, 10))], 1, 1)
    stays = Flow(PiecewiseLoop.of(companion(RationalPlant(top, bottom)), graph)).passages([2.0, 0.0], 400.0)
    first, last = returns(stays)
    record = {
        "points": [["-1", "-1/10"], ["0", "0"], ["1", "1/10"]],
        "left_slope": "1",
        "right_slope": "1",
        "pieces": [stay.piece for stay in stays[first:last]],
        "durations": [stay.duration for stay in stays[first:last]],
        "state": [float(v) for v in stays[first].state],
        "half": False,
    }
    system, given = transfer("1/4 19/20 1/4", "1 -1/5 1"), certificate("flow-orbit")["laws"]
    made = refutation(system, given, flow_orbit_proof(system, given, record))
    assert "a periodic motion" in complete_and_check(made).facts["orbit"]


def test_in_discrete_time_an_unstable_state_has_no_matrix():
    # A = 3/2, P = 16: P - 9/4 P < 0; A = 1/2: 16 - 4 > 0, b P A = 8 = c and 2/w - 16 = 16 for w = 1/16
    proof = {"method": "matrix", "P": [["16"]], "exponent": 0, "zero": None}
    assert states.matrix_facts([[F(1, 2)]], [F(1)], [F(8)], F(0), F(1, 16), F(0), True, proof)["stable"]
    with pytest.raises(Rejected, match="the inequality of P fails"):
        states.matrix_facts([[F(3, 2)]], [F(1)], [F(24)], F(0), F(1, 16), F(0), True, proof)
    # P/2^100 = 1 for 1/(s + 1): 2 P = 2, P b = c, 2/k = 2
    far = {"method": "matrix", "P": [[str(2**100)]], "exponent": 100, "zero": None}
    assert states.matrix_facts([[F(-1)]], [F(1)], [F(1)], F(0), F(1), F(0), False, far)["stable"]
    with pytest.raises(Rejected, match="the inequality of P fails"):
        states.matrix_facts([[F(1)]], [F(1)], [F(1)], F(0), F(1), F(0), False, far)


@pytest.mark.parametrize("name", ["popov", "zames-falb", "circle, discrete"])
def test_another_polynomial_is_none_of_the_claim(name):
    given = certificate(name)
    for part in ({"coefficients": ["1"]}, {"limits": ["1", "1"]}, {"variable": "omega^3"}, {"more": "1"}):
        with pytest.raises(Rejected, match="F is another polynomial"):
            check(json.dumps({**given, "proof": {**given["proof"], **part}}))


def test_a_state_beside_the_orbit_is_none():
    first, second = certificate("flow-orbit")["proof"]["state"]
    for shift, holds in ((F(0), True), (F(1, 10**4), False)):
        made = changed("flow-orbit", {"proof.state": [str(F(first) + shift), str(F(second) + shift)]})
        if holds:
            assert complete_and_check(made)
        else:
            with pytest.raises(Rejected, match="no contraction"):
                complete_and_check(made)


@pytest.mark.parametrize(("a", "b", "holds"), [(F(1), F(3, 2), True), (F(1), F(8, 5), False), (F(5), F(6), True)])
def test_a_cosine_on_a_box_away_from_0(a, b, holds):
    # cos omega > 0 up to pi/2 = 1.5708, and from 3 pi/2 = 4.712 to 5 pi/2
    assert balls.box(Form({(F(1), 0): (F(1), F(0))}), a, b, 24) is holds

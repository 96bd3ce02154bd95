"""Curves, graphs and regions of the second checker: formulas by themselves, and by hand what is sharp."""

from fractions import Fraction as F

import pytest
from flint import fmpq, fmpq_mat, fmpq_poly
from handwritten import loop
from second_plants import assert_accepted_if
from tampering import assert_both_reject

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import curves, graphs
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown


def piecewise(*pieces, cuts=()):
    return graphs.Graph(cuts=tuple(map(F, cuts)), pieces=tuple(map(fmpq_poly, pieces)))


def data(*pieces, cuts=(-1, 1)):
    return {"kind": "piecewise-polynomial", "cuts": list(map(str, cuts)), "pieces": [list(map(str, p)) for p in pieces]}


def flow(A, b, c, graph):
    """``x' = A x - b phi(c x)`` in the plane."""
    F_, Y = [[*row, -v] for row, v in zip(A, b, strict=True)], [[*c, 0]]
    return graphs.Loop(F=fmpq_mat(F_), Y=fmpq_mat(Y), D=fmpq_mat(1, 1), discrete=False, graphs=(graph,))


AROUND = [(4, 0), (3, 3), (0, 4), (-3, 3), (-4, 0), (-3, -3), (0, -4), (3, -3), (4, 0)]


def around(which, size, points):
    rows = [[str(size * F(v)) for v in point] for point in points]
    return which, curves.curve_of(which, rows)


# z_1' = z_1 - phi(z_1), z_2' = -2 z_2, x = (2 z_1 - z_2, z_1 + z_2) rests at sqrt(3)/2 (2, 1), and the ray along (2, 1)
# leaves the octagon at 12/7, on the edge from (4, 0) to (3, 3); at -12/7 where the other half alone turns back
FULL, RIGHT, LEFT = (
    piecewise([0, -2, 0, 4]),
    piecewise([], [0, -2, 0, 4], cuts=[0]),
    piecewise([0, -2, 0, 4], [], cuts=[0]),
)


def aside(graph):
    S = fmpq_mat([[2, -1], [1, 1]])
    A, b, c = S * fmpq_mat([[1, 0], [0, -2]]) * S.inv(), S * fmpq_mat([[1], [0]]), fmpq_mat([[1, 0]]) * S.inv()
    return flow(A.tolist(), b.entries(), c.entries(), graph)


@pytest.mark.parametrize("graph", [FULL, RIGHT, LEFT])
@pytest.mark.parametrize("points", [AROUND, AROUND[::-1], [*AROUND[:-1], (3, 0)]])
@pytest.mark.parametrize(("size", "alone"), [("505/1000", True), ("506/1000", False)])
def test_equilibria_beside_the_axes_are_found(graph, points, size, alone):
    given = around(aside(graph), F(size), points)
    with assert_accepted_if(alone):
        curves.require_one_equilibrium(*given)


# a parabola from (4, 0) to (0, 4) that bends inwards to (3/2, 3/2) is looked at as far as its chord: on (2, 1) at 4/3
def test_equilibria_between_a_parabola_and_its_chord_are_not_excluded():
    for size, alone in ((F(64, 100), True), (F(70, 100), False), (F(80, 100), False)):
        points = [(4, 0), (F(3, 2), F(3, 2), 0, 4), (-4, 0), (0, -4), (4, 0)]
        with assert_accepted_if(alone):
            curves.require_one_equilibrium(*around(aside(RIGHT), size, points))


# x_1' = -x_1 + phi(x_1): phi = 0, from 1/2 on 2 x - 1, from 1 on 1 touches x_1 at the cut 1 alone, or with the other
# sign at -1; x_1' = -phi(x_1) rests wherever phi = 0
@pytest.mark.parametrize("sign", [1, -1])
def test_an_equilibrium_at_a_cut_is_none_the_less_one(sign):
    pieces, cuts = [[], [-1 * sign, 2], [sign]], [F(sign, 2), sign]
    graph = piecewise(*pieces[::sign], cuts=cuts[::sign])
    for size, alone in (("99/400", True), ("101/400", False)):
        with assert_accepted_if(alone):
            curves.require_one_equilibrium(*around(flow([[-1, 0], [0, -1]], [-1, 0], [1, 0], graph), F(size), AROUND))
    with assert_accepted_if(False):
        curves.require_one_equilibrium(*around(flow([[0, 0], [0, -1]], [1, 0], [1, 0], graph), F(1, 100), AROUND))
    with assert_accepted_if(False):  # where nothing moves x_2
        curves.require_one_equilibrium(*around(flow([[1, 0], [0, 0]], [1, 0], [1, 0], FULL), F(1, 100), AROUND))


# on x_1 = 1 it is x_1' = -1 + phi(3 x_2), phi a peak at 1, between 1/2 and 3/2
@pytest.mark.parametrize(("peak", "crossed"), [(F(99, 100), True), (F(101, 100), False)])
@pytest.mark.parametrize(("low", "high"), [(-1, 1), (F(1, 4), F(2, 5)), (F(-1, 2), F(2, 3)), (F(3, 10), 2)])
@pytest.mark.parametrize("way", [1, -1])
def test_an_edge_is_cut_where_sigma_meets_a_corner(peak, crossed, low, high, way):
    up = 2 * to_fmpq(peak)
    graph = piecewise([], [-up / 2, up], [3 * up / 2, -up], [], cuts=["1/2", 1, "3/2"])
    corners = tuple((fmpq(1), to_fmpq(F(v))) for v in (low, high)[::way])
    with assert_accepted_if(crossed):
        curves.require_crossed(flow([[-1, 0], [0, 0]], [-1, 0], [0, 3], graph), [curves.Arc(corners=corners)], way)


@pytest.mark.parametrize(
    ("p", "positive"),
    [
        ([], False),
        ([1], True),
        ([-1], False),
        ([0, 1], False),
        ([1, -1], False),
        ([101, -100], True),
        ([1, -2], False),
        ([fmpq(1, 4), -1, 1], False),
        ([fmpq(26, 100), -1, 1], True),
        ([fmpq(1, 4), 0, -1, 0, 1], False),  # (t^2 - 1/2)^2
        ([fmpq(26, 100), 0, -1, 0, 1], True),
        ([2, 0, 0, -1], True),
    ],
)
def test_what_is_positive_from_0_to_1(p, positive):
    assert curves._positive_on_unit(fmpq_poly(p)) is positive


# (x - 1)(x - 2)^2 and (3 - x)(x - 2)^2 on [1, 3], and with (x - 2)^2 + 1/9
@pytest.mark.parametrize(("more", "strictly"), [(0, False), (fmpq(1, 9), True)])
def test_a_double_root_beside_one_at_an_end_is_seen(more, strictly):
    for line in ([-1, 1], [3, -1]):
        p = fmpq_poly(line) * (fmpq_poly([-2, 1]) ** 2 + more)
        assert graphs.nonnegative_between(p, F(1), F(3))
        assert graphs.positive_inside(p, F(1), F(3)) is strictly


def test_arcs_and_edges_along_a_ray_have_their_corners():
    first, control, last = ((fmpq(a), fmpq(b)) for a, b in ((1, 5), (-2, 7), (4, -3)))
    for k in (0, 1):
        bent = curves.Arc(corners=(first, control, last)).coordinate(k)
        assert [bent(fmpq(t, 2)) for t in range(3)] == [first[k], (first[k] + 2 * control[k] + last[k]) / 4, last[k]]
        straight = curves.Arc(corners=(first, last)).coordinate(k)
        assert [straight(fmpq(t)) for t in range(2)] == [first[k], last[k]]
    ray = curves.Curve(sense=1, start=first, factor=F(1), arcs=()).along_ray(F(1, 2), F(3))
    assert ray.corners == ((fmpq(1, 2), fmpq(5, 2)), (3, 15))


def test_a_graph_of_a_multiple_and_the_form_of_a_rate():
    line, bend = fmpq_poly([1, 2]), fmpq_poly([1, 2, 3])
    graph = graphs.Graph(cuts=(F(-1), F(2)), pieces=(line, bend, line))
    for scale in (F(2), F(-2)):
        found = graphs.pieces_of(graph, scale)
        low, high = sorted((-1 / scale, 2 / scale))
        assert [(a, b) for a, b, _ in found] == [(None, low), (low, high), (high, None)]
        assert [p(fmpq(5)) for *_, p in found] == [q(to_fmpq(5 * scale)) for q in (line, bend, line)]
    assert graphs.read_graph({"kind": "signed", "top": "2"}) == graphs.Graph(sector=(F(0), F(2)), reach=F(0))
    z, P = fmpq_mat([[2], [-1], [3]]), fmpq_mat([[2, 1], [1, 5]])
    plane = flow([[-1, 2], [0, -3]], [1, 2], [1, 3], line_graph := piecewise([0, 1]))
    x, rate = fmpq_mat([[2], [-1]]), plane.F * z
    V, moved = (x.transpose() * P * x)[0, 0], (x.transpose() * P * rate)[0, 0]
    after = (rate.transpose() * P * rate)[0, 0]
    assert (z.transpose() * plane.form(P, F(1, 3)) * z)[0, 0] == 2 * moved - V / 3
    sampled = graphs.Loop(F=plane.F, Y=plane.Y, D=plane.D, discrete=True, graphs=(line_graph,))
    assert (z.transpose() * sampled.form(P, F(1, 3)) * z)[0, 0] == after - V * 4 / 3


@pytest.mark.parametrize(
    ("given", "wrong"),
    [
        ({"kind": "signed", "top": "1/9"}, {"top": "0"}),
        ({"kind": "signed", "top": "1/9"}, {"top": "-1/9"}),
        ({"kind": "sector", "sector": ["1/2", "1/2"], "reach": "1/9"}, {"sector": ["1/2", "1/3"]}),
        ({"kind": "sector", "sector": ["1/2", "1/2"], "reach": "1/9"}, {"reach": "0"}),
        ({"kind": "sector", "sector": ["1/2", "1/2"], "reach": "1/9"}, {"reach": "-1/9"}),
        (data([-1], [0, 1], [1]), {"cuts": ["1", "1"]}),
        (data([-1], [0, 1], [1]), {"cuts": ["-1"]}),
        (data([-1], [0, 1], [1]), {"cuts": ["-1", "2"]}),
        (data([-1], [0, 1], [1]), {"kind": "piecewise"}),
        (data([0, 1], [0, 1], cuts=[0]), {"pieces": [["1", "1"], ["1", "1"]]}),
    ],
)
def test_what_is_no_nonlinearity_is_not_read(given, wrong):
    graphs.read_graph(given)
    with pytest.raises(NotShown):
        graphs.read_graph(given | wrong)


# Regions by hand


def region(system, data, theorem, multiplier, proof):
    verdict = "REFUTED" if theorem == "counterexample" else "PROVED"
    return {"verdict": verdict, "system": system, "laws": {"graphs": data}, "theorem": theorem, "proof": proof} | {
        "multiplier": multiplier
    }


SATURATION = data([-1], [0, 1], [1])


# x' = -phi(x), phi in [1/2, 1] up to 2, V = p x^2 + 2 theta int phi, with the weight 1: -V' is at least x^2 +
# 2 (p - 3/2) x phi + 2 (theta + 1) phi^2, positive definite for 2 (theta + 1) > (p - 3/2)^2
def by_integrals(p, theta, least, **more):
    term = {"channel": 1, "weight": "1", "sector": ["1/2", "1"], "reach": "2"}
    integral = {"channel": 1, "theta": str(theta), "reach": "2", "least": str(least)}
    proof = {"method": "level-set", "P": [[str(p)]], "integrals": [integral]} | more
    return region(loop([[0]], [[1]], [[1]], [[0]]), [SATURATION], "local-popov", {"terms": [term]}, proof)


# x' = 2 x - 2 phi_1, sigma_1 = x - phi_2/2, phi_i = sigma_i + p_i, |p_i| <= 1: x' = x + p_2 - 2 p_1, and with weights
# 2/3 and 1/3 V' - (V - 1) >= q x^2 + 2 q x (p_2 - 2 p_1) + 2/3 p_1^2 + 1/3 p_2^2, positive definite for q < 1/9
def outwards(Q, weights=("2/3", "1/3")):
    sides = [[2]], [[2, 0]], [[1], [1]], [[0, "1/2"], [0, 0]]
    proof = {"method": "growth", "Q": [[Q]], "rate": "1", "weights": list(weights)}
    return region(loop(*sides), [data([-1, 1], [0, 2], [1, 1])] * 2, "counterexample", {}, proof)


@pytest.mark.parametrize(
    ("accepted", "refused"),
    [
        (by_integrals("3/2", 2, "3/4"), by_integrals("3/2", 2, "76/100")),
        (by_integrals("3/2", "-9/10", 1), by_integrals("3/2", "-1", 1)),
        (by_integrals("3/2", "-9/10", 1), by_integrals("3/2", "-9/10", "99/100")),
        (by_integrals("39/10", 2, "3/4"), by_integrals("4", 2, "3/4")),  # 2.4^2 = 5.76 and 2.5^2 = 6.25
        (by_integrals("3/2", 2, 0), by_integrals("1/4", 2, 0)),  # x^2 < 4 where V >= p x^2 is below 1
        (outwards("11/100"), outwards("112/1000")),
        (outwards("11/100"), outwards("11/100", ("7/10", "1/3"))),
        (outwards("11/100"), outwards("11/100", ("1/3", "2/3"))),
    ],
)
def test_regions_by_hand_are_sharp(accepted, refused):
    found = dict(complete_and_check(accepted).certificate)
    assert recheck(found).accepted
    assert_both_reject({**found, **refused})

"""Regions of attraction: certificates by hand, sharp, what neither checker accepts, and the arithmetic of graphs."""

from fractions import Fraction as F
from itertools import pairwise

import pytest
from flint import fmpq_mat, fmpq_poly
from handwritten import loop
from second_plants import assert_accepted_if
from tampering import assert_both_reject, edited

from lure.analysis.certificates import regions
from lure.analysis.certificates.arithmetic import INF, Malformed, Rejected
from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import curves, graphs
from lure.analysis.certificates.second import regions as second
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import Document, NotShown


def polynomials(*pieces, cuts=()):
    listed = [[str(v) for v in p] for p in pieces]
    return {"kind": "piecewise-polynomial", "cuts": [str(v) for v in cuts], "pieces": listed}


CUBIC = polynomials([0, 0, 0, 1])
SATURATION = polynomials([-1], [0, 1], [1], cuts=(-1, 1))
DEAD = polynomials([1, 1], [0], [-1, 1], cuts=(-1, 1))


def draft(system, graphs, theorem, multiplier, proof):
    verdict = "REFUTED" if theorem == "counterexample" else "PROVED"
    laws = {"graphs": graphs}
    found = {"verdict": verdict, "system": system, "laws": laws, "theorem": theorem, "proof": proof}
    return found | {"multiplier": multiplier}


def signs(system, graph, end, theorem="scalar"):
    return draft(system, [graph], theorem, {}, {"method": "signs", "interval": [f"-{end}", end]})


# x' = -x + x^3; x+ = x/2 + x^3 and -x/2 - x^3: |f| < |x| for x^2 < 1/2; x' = -x - 3 dead(-2 x), 5 x - 3 for x > 1/2
FLOW, MAP = loop([[-1]], [[-1]], [[1]], [[0]]), loop([["1/2"]], [[-1]], [[1]], [[0]], "discrete")
TURN, FAR = loop([["-1/2"]], [[1]], [[1]], [[0]], "discrete"), loop([[-1]], [[3]], [[-2]], [[0]])
# x' = x - sat(2 x), V = x^2/c^2, c = .9, h = 1.1: with the weight .9 a form of determinant > 0; with [2/3, 1] as sector
# for |2 x| <= 3/2 V = 2 x^2 and the weight 6/5: 2.4 x^2 - 4 x phi + 2.4 phi^2
SADDLE = loop([[1]], [[1]], [[2]], [[0]])
HELD = draft(
    SADDLE,
    [SATURATION],
    "local-circle",
    {"terms": [{"channel": 1, "weight": "9/10", "row": ["11/10"]}]},
    {"method": "ellipsoid", "P": [["100/81"]]},
)
SECTOR = {"channel": 1, "weight": "6/5", "sector": ["2/3", "1"], "reach": "3/2"}
NEAR = draft(SADDLE, [SATURATION], "local-circle", {"terms": [SECTOR]}, {"method": "ellipsoid", "P": [["2"]]})
# x' = -x + w beside a channel that moves nothing: 2 x^2 - 2 x w + w^2/E, of determinant 2/E - 1, E < 2
PUSHED = draft(
    loop([[-1]], [[0]], [[1]], [[0]]),
    [{"kind": "sector", "sector": ["-1", "1"], "reach": "10"}],
    "local-circle",
    {"terms": [{"channel": 1, "weight": "1/1000", "sector": ["-1", "1"], "reach": "10"}]},
    {"method": "ellipsoid", "P": [["1"]], "energy": "199/100", "Bw": [["1"]]},
)
# x' = x - 2 sat(x), V = q x^2: V' - (V - 1) >= q x^2 - 4 q x p + p^2, of determinant q - 4 q^2, q < 1/4
GROWS = draft(
    loop([[1]], [[2]], [[1]], [[0]]),
    [SATURATION],
    "counterexample",
    {},
    {"method": "growth", "Q": [["24/100"]], "rate": "1", "weights": ["1"]},
)
# x' = -x beside sigma_1 = x - phi_2 with |x| <= 1 and |phi_2| <= 1
THROUGH = draft(
    loop([[-1]], [[0, 0]], [[1], [1]], [[0, 1], [0, 0]]),
    [{"kind": "sector", "sector": ["-1", "1"], "reach": "21/10"}, SATURATION],
    "local-circle",
    {
        "terms": [
            {"channel": 1, "weight": "1/1000", "sector": ["-1", "1"], "reach": "21/10"},
            {"channel": 2, "weight": "1/10", "row": ["1/2"]},
        ]
    },
    {"method": "ellipsoid", "P": [["1"]]},
)
ACCEPTED = {
    "through": THROUGH,
    "flow": signs(FLOW, CUBIC, "1"),
    "map": signs(MAP, CUBIC, "7/10"),
    "turning map": signs(TURN, CUBIC, "7/10"),
    "far": signs(FAR, DEAD, "3/5"),
    "outside": signs(FLOW, CUBIC, "1", "counterexample"),
    "outside the map": signs(MAP, CUBIC, "71/100", "counterexample"),
    "outside the turning map": signs(TURN, CUBIC, "71/100", "counterexample"),
    "held": HELD,
    "near": NEAR,
    "pushed": PUSHED,
    "grows": GROWS,
}
END = ("proof", "interval")
TWO = loop([[-1, 0], [0, 1]], [[-1], [0]], [[1, 0]], [[0]])
SEEN = loop([[-1]], [[-1, 0]], [[1], [1]], [[0, 1], [0, 0]])


@pytest.mark.parametrize("name", ACCEPTED)
def test_both_checkers_accept_a_region_by_hand(name):
    found = dict(complete_and_check(ACCEPTED[name]).certificate)
    assert recheck(found).accepted, recheck(found).reason


@pytest.mark.parametrize(
    ("name", "edits"),
    [
        ("flow", {END: ["-101/100", "101/100"]}),
        ("flow", {END: ["-1", "101/100"]}),
        ("flow", {END: ["-101/100", "1"]}),
        ("flow", {END: ["0", "1"]}),
        ("flow", {END: ["-1", "0"]}),
        ("flow", {END: ["1", "-1"]}),
        ("flow", {END: ["-inf", "inf"]}),
        ("flow", {("system",): TWO}),
        ("flow", {("system",): SEEN, ("laws", "graphs"): [CUBIC, CUBIC]}),
        ("flow", {("system", "B"): [["1"]], ("system", "A"): [["1"]]}),
        ("flow", {("laws", "graphs", 0): {"kind": "sector", "sector": ["0", "1"], "reach": "1"}}),
        ("flow", {("laws", "graphs", 0): polynomials([0, 0, 0, 1], [0, 0, 0, 2], cuts=("1/2",))}),  # it jumps
        ("flow", {("laws", "graphs", 0): polynomials([1, 0, 0, 1])}),  # phi(0) = 1
        ("flow", {("laws", "graphs", 0): polynomials([0, 0, 0, 1], [0, 0, 0, 1], [0, 0, 0, 1], cuts=(1, -1))}),
        ("flow", {("theorem",): "local-circle"}),
        ("map", {END: ["-71/100", "71/100"]}),
        ("map", {END: ["-7/10", "3/5"]}),
        # to the left -9/10 x, which jumps to the right; and turned round
        ("map", {END: ["-inf", "7/10"], ("laws", "graphs", 0): polynomials([0, "-7/5"], [0, 0, 0, 1], cuts=(0,))}),
        ("map", {END: ["-7/10", "inf"], ("laws", "graphs", 0): polynomials([0, 0, 0, 1], [0, "-7/5"], cuts=(0,))}),
        ("turning map", {END: ["-71/100", "71/100"]}),
        ("far", {END: ["-61/100", "61/100"]}),
        ("far", {END: ["-3/5", "61/100"]}),
        # x' = x - (2 x)^3 up to 1/2, which rests at 8^(-1/2); beyond -x/2 - 1/4, below 0 from 0 on
        (
            "far",
            {
                ("system",): loop([[1]], [[1]], [[2]], [[0]]),
                ("laws", "graphs", 0): polynomials(["-1/4", "3/4"], [0, 0, 0, 1], ["1/4", "3/4"], cuts=(-1, 1)),
            },
        ),
        ("outside", {END: ["-99/100", "99/100"]}),
        ("outside", {END: ["-99/100", "1"]}),
        ("outside", {END: ["-1", "99/100"]}),
        ("outside", {END: ["-inf", "inf"]}),
        ("outside the map", {END: ["-7/10", "7/10"]}),
        ("outside the turning map", {END: ["-7/10", "7/10"]}),
        ("held", {("proof", "P"): [["9/10"]]}),  # a solution leaves
        ("held", {("proof", "P"): [["121/100"]]}),  # the strip is touched
        ("held", {("multiplier", "terms", 0, "row"): ["10/9"]}),
        ("held", {("multiplier", "terms", 0, "weight"): "-9/10"}),
        ("held", {("multiplier", "terms", 0, "weight"): "0"}),
        ("held", {("multiplier", "terms", 0, "channel"): 2}),
        ("held", {("laws", "graphs", 0): polynomials([-1], [0, 1], ["9/10"], cuts=(-1, "9/10"))}),
        ("held", {("laws", "graphs", 0): polynomials(["-9/10"], [0, 1], [1], cuts=("-9/10", 1))}),
        ("held", {("laws", "graphs", 0): CUBIC}),
        ("near", {("proof", "P"): [["16/9"]]}),
        ("near", {("multiplier", "terms", 0, "reach"): "8/5"}),
        ("near", {("multiplier", "terms", 0, "reach"): "14/10"}),
        ("near", {("multiplier", "terms", 0, "sector"): ["67/100", "1"]}),
        ("near", {("multiplier", "terms", 0, "sector"): ["2/3", "99/100"]}),
        ("near", {("multiplier", "terms", 0, "reach"): "-3/2"}),
        ("near", {("multiplier", "terms"): []}),
        ("near", {("multiplier", "terms"): [SECTOR | {"weight": "17/10"}, SECTOR | {"weight": "-1/2"}]}),
        ("near", {("system", "time"): "discrete"}),
        ("near", {("proof", "P"): [["-2"]]}),
        ("pushed", {("proof", "energy"): "201/100"}),
        ("pushed", {("proof", "energy"): "-1"}),
        ("pushed", {("proof", "Bw"): [["11/10"]]}),
        ("pushed", {("proof", "P"): [["11/10"]]}),
        ("pushed", {("laws", "graphs", 0, "reach"): "9"}),
        ("pushed", {("laws", "graphs", 0, "sector"): ["-2", "1"]}),
        ("pushed", {("multiplier", "terms"): []}),
        ("through", {("laws", "graphs", 1): polynomials([-2], [0, 1], [1], cuts=(-2, 1))}),
        ("through", {("laws", "graphs", 1): polynomials([-1], [0, 1], [2], cuts=(-1, 2))}),
        ("through", {("system", "D"): [["0", "12/10"], ["0", "0"]]}),
        ("through", {("system", "D"): [["0", "-12/10"], ["0", "0"]]}),
        ("grows", {("proof", "Q"): [["26/100"]]}),
        ("grows", {("proof", "weights"): ["101/100"]}),
        ("grows", {("proof", "weights"): ["-1"]}),
        ("grows", {("proof", "rate"): "-1"}),
        ("grows", {("proof", "rate"): "99/100"}),
        ("grows", {("system", "A"): [["-1"]]}),
        ("grows", {("laws", "graphs", 0): polynomials([-1], [0, 1], [2], cuts=(-1, 2))}),
        ("grows", {("laws", "graphs", 0): polynomials([-2], [0, 1], [1], cuts=(-2, 1))}),
        ("grows", {("laws", "graphs", 0): DEAD}),
    ],
)
def test_neither_accepts_another_region(name, edits):
    found = complete_and_check(ACCEPTED[name]).certificate
    for path, value in edits.items():
        found = edited(found, *path, value=value)
    assert_both_reject(found)


@pytest.mark.parametrize(
    ("p", "low", "high", "ever", "strictly"),
    [
        ([], 0, 1, True, False),
        ([0, 1], 0, 1, True, True),
        ([0, 1], -1, 1, False, False),
        ([1, -1], 0, 1, True, True),
        ([1, -1], 0, 2, False, False),
        ([0, -1], -INF, 0, True, True),
        ([0, 1], -INF, 0, False, False),
        ([0, 1], 0, INF, True, True),
        ([0, 0, 1], 0, INF, True, True),
        ([0, 0, -1], 0, INF, False, False),
        ([0, 0, 0, -1], -INF, 0, True, True),
        ([2, -3, 1], 1, 2, False, False),
        ([-2, 3, -1], 1, 2, True, True),
        ([2, -3, 1], 2, INF, True, True),
        ([2, -3, 1], -INF, 1, True, True),
    ],
)
def test_where_a_polynomial_is_never_negative(p, low, high, ever, strictly):
    given = [F(v) for v in p], *(v if abs(v) == INF else F(v) for v in (low, high))
    assert (regions.never_negative(*given), regions.never_negative(*given, True)) == (ever, strictly)
    again = fmpq_poly(p), *(None if abs(v) == INF else F(v) for v in (low, high))
    assert (graphs.nonnegative_between(*again), graphs.positive_inside(*again)) == (ever, strictly)


@pytest.mark.parametrize(
    ("data", "low", "high", "reach", "holds"),
    [
        (SATURATION, "1/2", 1, 2, True),
        (SATURATION, "51/100", 1, 2, False),
        (SATURATION, "1/2", "99/100", 2, False),
        (polynomials(["-1/2"], [0, 1], [1], cuts=("-1/2", 1)), "1/2", 1, 2, False),
        (polynomials(["-1/2"], [0, 1], [1], cuts=("-1/2", 1)), "1/4", 1, 2, True),
        (DEAD, 0, "1/2", 2, True),
        (DEAD, 0, "49/100", 2, False),
        (CUBIC, 0, 4, 2, True),
        (CUBIC, 0, "39/10", 2, False),
        ({"kind": "sector", "sector": ["0", "1"], "reach": "2"}, 0, 1, 2, True),
        ({"kind": "sector", "sector": ["0", "1"], "reach": "2"}, 0, 1, "201/100", False),
        ({"kind": "sector", "sector": ["0", "1"], "reach": "2"}, "1/100", 1, 2, False),
        ({"kind": "sector", "sector": ["0", "1"], "reach": "2"}, 0, "99/100", 2, False),
    ],
)
def test_a_nonlinearity_is_in_a_sector_up_to_its_reach(data, low, high, reach, holds):
    assert regions.graph(data).within(F(low), F(high), F(reach)) is holds
    assert second._in_sector(graphs.read_graph(data), F(low), F(high), F(reach)) is holds


# 2 int phi: sigma^2; sigma^4/2; of the saturation 2 sigma - 1 beyond 1, at 2 three quarters of sigma^2
@pytest.mark.parametrize(
    ("data", "least", "sign", "holds"),
    [
        (polynomials([0, 1]), 1, 1, True),
        (polynomials([0, 1]), "101/100", 1, False),
        (polynomials([0, 1]), 1, -1, True),
        (polynomials([0, 1]), "99/100", -1, False),
        (CUBIC, 0, 1, True),
        (CUBIC, "1/100", 1, False),
        (CUBIC, 2, -1, True),
        (CUBIC, "199/100", -1, False),
        (SATURATION, "3/4", 1, True),
        (SATURATION, "76/100", 1, False),
        (SATURATION, 1, -1, True),
        (polynomials(["-1/2"], [0, 1], [1], cuts=("-1/2", 1)), "3/4", 1, False),  # 7/16 on the left
        (polynomials(["-1/2"], [0, 1], [1], cuts=("-1/2", 1)), "7/16", 1, True),
        (polynomials(["-1"], [0, 1], ["1/2"], cuts=(-1, "1/2")), "7/16", 1, True),
        (polynomials(["-1"], [0, 1], ["1/2"], cuts=(-1, "1/2")), "44/100", 1, False),
    ],
)
def test_the_integral_of_a_nonlinearity_is_bounded(data, least, sign, holds):
    assert regions.graph(data).bounded(F(least), F(2), sign) is holds
    assert second._integral_bounded(graphs.read_graph(data), F(least), F(2), above=sign > 0) is holds


@pytest.mark.parametrize(
    ("data", "clip"),
    [
        (SATURATION, (0, 1, 1, 1)),
        (polynomials([-2], [0, 1], [3], cuts=(-2, 3)), (0, 1, 2, 3)),
        (polynomials(["-1/2", "1/2"], [0, 1], ["1/2", "1/2"], cuts=(-1, 1)), ("1/2", 1, "1/2", "1/2")),
        (polynomials([1], [0, -1], [-2], cuts=(-1, 2)), (0, -1, 2, 1)),
        (DEAD, (1, 0, 1, 1)),
        (CUBIC, None),
        (polynomials([-1], [0, 1], ["1/2", "1/2"], cuts=(-1, 1)), None),
        (polynomials([0], [0, 0, 1], [1], cuts=(0, 1)), None),
        (polynomials([0], [0, 1], [1], cuts=(0, 1)), None),
    ],
)
def test_lines_with_limits_on_both_sides(data, clip):
    again = graphs.read_graph(data).clip
    if clip is None:
        assert again is None
        with pytest.raises((Rejected, Malformed)):
            regions.graph(data).clip()
        return
    outer, middle, low, high = map(F, clip)
    assert regions.graph(data).clip() == (outer, middle, low, high)
    assert again == (outer, middle, -low, high)


def plant(A, B, C, D, *, discrete=False):
    return Plant(*([[F(v) for v in row] for row in side] for side in (A, B, C, D)), discrete=discrete)


def rows(M):
    return fmpq_mat([[to_fmpq(F(v)) for v in row] for row in M])


def again(H, *data):
    """The same loop as the second checker has it."""
    A, B, C, D = map(rows, H[:4])
    sides, own = {"F": second._beside(A, -B), "Y": second._beside(C, -D), "D": D}, tuple(map(graphs.read_graph, data))
    return graphs.Loop(**sides, discrete=H.discrete, graphs=own)


def document(H, data, theorem, multiplier, proof):
    """What the second checker reads."""
    sides = {name: [[str(v) for v in row] for row in side] for name, side in zip("ABCD", H[:4], strict=True)}
    system = {"kind": "multivariable", "time": "discrete" if H.discrete else "continuous", **sides}
    verdict = "REFUTED" if theorem == "counterexample" else "PROVED"
    given = {"verdict": verdict, "system": system, "theorem": theorem, "multiplier": multiplier, "proof": proof}
    return Document(
        **given, nonlinearities={"graphs": data}, nonlinearity=None, conclusion="", hypotheses={}, rate=None
    )


INTEGRAL = {"channel": 1, "theta": "2", "reach": "2", "least": "3/4"}
SECTOR_ALONE = {"kind": "sector", "sector": ["0", "1"], "reach": "2"}


# V = x^2 + 4 int phi is at least x^2 + 2 (3/4) x^2, and V' has 4 phi x' more
def test_what_an_integral_adds():
    below, ((weight, phi, rate),), strips = regions.integrated(
        plant([[-1]], [[3]], [[2]], [[0]]), [regions.graph(SATURATION)], [INTEGRAL], [[F(1)]]
    )
    assert (below, strips) == ([[1 + 2 * F(3, 4) * 4]], [([2], 2)])
    assert (weight, phi, rate) == (4, [0, 1], [-2, -6])


@pytest.mark.parametrize(
    ("H", "graph", "change"),
    [
        (plant([[-1]], [[3]], [[2]], [[0]], discrete=True), SATURATION, {}),
        (plant([[-1]], [[3]], [[2]], [["1/9"]]), SATURATION, {}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SECTOR_ALONE, {"least": "0"}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"reach": "0"}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"reach": "-2"}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"reach": "21/10"}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"least": "76/100"}),
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"theta": "-2"}),  # of the other sign it is a bound from above
        (plant([[-1]], [[3]], [[2]], [[0]]), SATURATION, {"channel": 2}),
    ],
)
def test_integrals_that_do_not_fit_are_refused(H, graph, change):
    with pytest.raises((Rejected, Malformed)):
        regions.integrated(H, [regions.graph(graph)], [INTEGRAL | change], [[F(1)]])
    with pytest.raises(NotShown):
        second._with_integrals(again(H, graph), fmpq_mat([[1]]), [INTEGRAL | change])


# x' = -x + phi(x), y' = -y: between 1/2 and 2 x' = 99 x - 50 > 0, and what phi is beyond 2 would turn it round
@pytest.mark.parametrize(
    ("ends", "control"), [(("7/10", "7/10"), None), (("7/10", "7/10"), ("3/4", 0)), (("6/5", "17/10"), None)]
)
def test_arcs_are_crossed_as_the_piece_says_in_which_they_lie(ends, control):
    H = plant([[-1, 0], [0, -1]], [[-1], [0]], [[1, 0]], [[0]])
    data = polynomials([0], [-50, 100], [-250, 200], cuts=("1/2", 2))
    graph = regions.graph(data)
    first, last = map(F, ends)
    arc = (first, F(-1, 10)), control and tuple(map(F, control)), (last, F(1, 10))
    regions.crossed(H, [graph], [arc], -1)
    with pytest.raises(Rejected):
        regions.crossed(H, [graph], [arc], 1)
    corners = tuple(tuple(map(to_fmpq, point)) for point in arc if point)
    curves.require_crossed(again(H, data), [curves.Arc(corners=corners)], -1)
    with pytest.raises(NotShown):
        curves.require_crossed(again(H, data), [curves.Arc(corners=corners)], 1)


# x' = x - phi(x), phi = -2 x + 4 x^3, rests at sqrt(3)/2 = .8660
@pytest.mark.parametrize(("size", "alone"), [("866/1000", True), ("867/1000", False)])
def test_equilibria_within_a_curve_are_found(size, alone):
    r = F(size)
    ends = [(r, F(0)), (F(0), r), (-r, F(0)), (F(0), -r), (r, F(0))]
    arcs = [(p, None, q) for p, q in pairwise(ends)]
    data = polynomials([0, "-2", 0, 4])
    graph = regions.graph(data)
    for H in (
        plant([[1, 0], [0, -2]], [[1], [0]], [[1, 0]], [[0]]),
        plant([[-2, 0], [0, 1]], [[0], [1]], [[0, 1]], [[0]]),
    ):
        with assert_accepted_if(alone):
            curve = curves.curve_of(again(H, data), listed(ends))
            curves.require_one_equilibrium(again(H, data), curve)
        if alone:
            regions.still(H, graph, 1, arcs)
            continue
        with pytest.raises(Rejected, match="equilibrium"):
            regions.still(H, graph, 1, arcs)


# x' = -x beside channels that move nothing, sigma_1 = x - phi_2/2: with |phi_2| <= 1 and |sigma_1| <= 2 on the
# ellipsoid |x| <= 3/2, P = 4/9 and more
BESIDE = plant([[-1]], [[0, 0]], [[1], [1]], [[0, "1/2"], [0, 0]])
LOCAL = {"channel": 1, "weight": "1/100", "sector": ["-1", "1"], "reach": "2"}
CLIPPED = {"channel": 2, "weight": "1/100", "row": ["0"]}
UNKNOWN = {"kind": "sector", "sector": ["-1", "1"], "reach": "2"}
OWN = {"channel": 2, "weight": "1/100", "sector": ["-1", "1"], "reach": "1"}


@pytest.mark.parametrize(
    ("H", "own", "term", "P", "holds"),
    [
        (BESIDE, SATURATION, CLIPPED, "45/100", True),
        (BESIDE, SATURATION, CLIPPED, "44/100", False),
        (BESIDE._replace(D=[[0, F(-1, 2)], [0, 0]]), SATURATION, CLIPPED, "44/100", False),
        (BESIDE._replace(D=[[0, F(4)], [0, 0]]), SATURATION, CLIPPED, "1000", False),
        (BESIDE, polynomials([-1], [0, 1], [2], cuts=(-1, 2)), CLIPPED, "99/100", False),  # |phi_2| <= 2
        (BESIDE, polynomials([-1], [0, 1], [2], cuts=(-1, 2)), CLIPPED, "101/100", True),
        (BESIDE, DEAD, {**CLIPPED, "weight": "0"}, "1000", False),  # not bounded
        (BESIDE, UNKNOWN, {**OWN}, "101/100", True),  # |x| <= 1, |phi_2| <= 1 there
        (BESIDE, UNKNOWN, {**OWN}, "99/100", False),
        (BESIDE, UNKNOWN, {**OWN, "sector": ["-1/2", "1/2"]}, "101/100", False),
        (BESIDE, UNKNOWN, {**OWN, "sector": ["-1", "3"]}, "45/100", False),  # 3 of phi_2 would be too much
        (BESIDE, UNKNOWN, {**OWN, "sector": ["-3", "1"]}, "101/100", False),
        (BESIDE, UNKNOWN, {**OWN, "sector": ["-3", "1"], "reach": "1/2"}, "401/100", True),
        (BESIDE, UNKNOWN, {**OWN, "reach": "3"}, "101/100", False),
        (BESIDE, UNKNOWN, {**CLIPPED}, "101/100", False),
    ],
)
def test_what_enters_sigma_at_once_narrows_the_ellipsoid(H, own, term, P, holds):
    # phi_2 has a term of its own; phi_1 is known up to |sigma_1| = 2 alone
    data = [UNKNOWN, own]
    proof = {"method": "ellipsoid", "P": [[P]]}
    given = H, [*map(regions.graph, data)], {"terms": [LOCAL, term]}, proof, False
    with assert_accepted_if(holds):
        assert second.shown(document(H, data, "local-circle", given[2], proof)) == second.INSIDE
    if holds:
        assert regions.ellipsoid(*given)
        for change in ({"weight": "0"}, {"reach": "21/10"}):
            terms = {"terms": [LOCAL | change, term]}
            with pytest.raises(Rejected):
                regions.ellipsoid(*given[:2], terms, proof, False)
            with pytest.raises(NotShown):
                second.shown(document(H, data, "local-circle", terms, proof))
    else:
        with pytest.raises((Rejected, Malformed)):
            regions.ellipsoid(*given)


# Around 0 by hand: x' = a x - y, y' = x + a y turns at the rate 1 and grows like e^(a t)
AROUND = [(4, 0), (3, 3), (0, 4), (-3, 3), (-4, 0), (-3, -3), (0, -4), (3, -3), (4, 0)]
NOTHING = polynomials([0])
NONE = regions.graph(NOTHING)


def turning(a, way=1):
    return plant([[a, -way], [way, a]], [[0], [0]], [[1, 0]], [[0]])


def listed(points, factor=1):
    return [[str(factor * F(v)) for v in row] for row in points]


@pytest.mark.parametrize(
    ("points", "found"),
    [
        (AROUND, (1, 1)),
        (AROUND[::-1], (-1, 1)),
        ([*AROUND[:-1], (5, 0)], (1, F(5, 4))),
        ([*AROUND[:-1], (3, 0)], (1, F(3, 4))),
        (AROUND[:-1], None),
        (AROUND[:5], None),
        (AROUND[4:], None),
        (AROUND + AROUND[1:], None),
        ([*AROUND[:-1], (4, 1)], None),
        ([*AROUND[:3], (3, 3), *AROUND[3:]], None),
        ([*AROUND[:3], *AROUND[4:3:-1], *AROUND[3:]], None),
        ([(4, 0), (0, 4), (0, 5), (-4, 0), (0, -4), (4, 0)], None),  # along the ray
        ([(4, 0), (-4, 0), (0, -4), (4, 0)], None),  # through 0
        ([(4, 0), (4, 4, 0, 4), (-4, 4, -4, 0), (-4, -4, 0, -4), (4, -4, 4, 0)], (1, 1)),
        ([(4, 0), (4, -4, 0, 4), (-4, 4, -4, 0), (-4, -4, 0, -4), (4, -4, 4, 0)], None),
        ([(4, 0), (0, 4), (-4, 4, -4, 0), (-4, -4, 0, -4), (4, -4, 4, 0)], (1, 1)),
        ([(4, 0, 0), (0, 4), (-4, 0), (0, -4), (4, 0)], None),
        ([(4, 0), (0, 4, 0), (-4, 0), (0, -4), (4, 0)], None),
    ],
)
def test_curves_go_once_around(points, found):
    if found is None:
        with pytest.raises((Rejected, Malformed)):
            regions.once_around(turning(1), [NONE], listed(points))
        with pytest.raises(NotShown):
            curves.curve_of(again(turning(1), NOTHING), listed(points))
        return
    curve = curves.curve_of(again(turning(1), NOTHING), listed(points))
    assert (curve.sense, curve.factor) == found
    assert [one.corners for one in curve.arcs] == [
        tuple((to_fmpq(F(p[k])), to_fmpq(F(p[k + 1]))) for p in (before[-2:], after) for k in range(0, len(p), 2))
        for before, after in pairwise(points)
    ]
    sense, factor, arcs = regions.once_around(turning(1), [NONE], listed(points))
    assert (sense, factor) == found
    assert len(arcs) == len(points) - 1
    assert [q for _, _, q in arcs] == [p for p, *_ in arcs[1:]] + [tuple(map(F, points[-1][-2:]))]


@pytest.mark.parametrize(
    ("H", "graph"),
    [
        (turning(1)._replace(discrete=True), NOTHING),
        (turning(1)._replace(D=[[F(1)]]), NOTHING),
        (plant([[1]], [[0]], [[1]], [[0]]), NOTHING),
        (turning(1), UNKNOWN),
    ],
)
def test_curves_are_about_two_states_and_known_nonlinearities(H, graph):
    with pytest.raises(Rejected):
        regions.once_around(H, [regions.graph(graph)], listed(AROUND))
    with pytest.raises(NotShown):
        curves.curve_of(again(H, graph), listed(AROUND))


# on the edge of the octagon from (4, 0) to (3, 3) the normal is (3, 1): (3, 1).(a x - y, x + a y) = 12 a + x - 3 y is
# between 12 a - 6 and 12 a + 4; on the next one between 12 a - 4 and 12 a + 6: outwards for a > 1/2, inwards for < -1/2
@pytest.mark.parametrize(
    ("a", "way", "points", "holds"),
    [
        ("51/100", 1, AROUND, True),
        ("49/100", 1, AROUND, False),
        ("-51/100", 1, AROUND, False),
        ("51/100", -1, AROUND, True),
        ("51/100", 1, AROUND[::-1], True),
        ("51/100", 1, [*AROUND[:-1], ("41/10", 0)], True),
        ("51/100", -1, [*AROUND[:-1], ("41/10", 0)], False),  # the edge between is crossed inwards
        ("51/100", 1, [*AROUND[:-1], ("39/10", 0)], False),
        ("51/100", -1, [("39/10", 0), *AROUND[1:]][::-1], False),
    ],
)
def test_curves_are_crossed_outwards(a, way, points, holds):
    given = turning(a, way), [NONE], {"method": "curve", "points": listed(points)}
    with assert_accepted_if(holds):
        assert second.shown(document(given[0], [NOTHING], "counterexample", {}, given[2])) == second.AROUND
    with pytest.raises(NotShown):
        second.shown(document(given[0], [NOTHING], "counterexample", {}, {**given[2], "orbit": True}))
    if holds:
        assert regions.curve(*given)
        with pytest.raises((Rejected, Malformed)):  # 0 repels what is near
            regions.curve(*given[:2], {**given[2], "orbit": [True]})
    else:
        with pytest.raises(Rejected):
            regions.curve(*given)


# turns from 4 to 39/10 and on to 19/5; |x|^2 is 18 at most on the first, 17.1 on the second, and has to be at most
# 1/level at the end of the last one alone: 1/15.21 = .065746, 1/14.44 = .069252
FIRST = [*AROUND[:-1], ("39/10", 0)]
SECOND = [*((F(39, 40) * x, F(39, 40) * y) for x, y in AROUND[:-1]), ("19/5", 0)]
LATER = [*((F(38, 40) * x, F(38, 40) * y) for x, y in AROUND[:-1]), ("37/10", 0)]


@pytest.mark.parametrize(
    ("a", "way", "turns", "level", "holds"),
    [
        ("-3/5", 1, [FIRST], "1/18", True),
        ("-3/5", 1, [FIRST], "657/10000", True),
        ("-3/5", 1, [FIRST], "658/10000", False),
        ("-3/5", 1, [FIRST, SECOND], "692/10000", True),
        ("-3/5", 1, [FIRST, SECOND], "693/10000", False),
        ("-3/5", 1, [FIRST, LATER], "1/100", False),  # it starts within the end of the first
        ("-3/5", 1, [FIRST, [*SECOND[1:-1], SECOND[0], (F(29, 10), F(29, 10))]], "1/100", False),  # on another ray
        ("-3/5", 1, [FIRST, [*FIRST[:-1][::-1][-1:], *FIRST[1:-1][::-1], ("39/10", 0)]], "1/100", False),
        ("-49/100", 1, [FIRST], "1/18", False),
        ("3/5", 1, [FIRST], "1/18", False),
        ("-3/5", 1, [AROUND], "1/18", False),
        ("-3/5", 1, [[*AROUND[:-1], ("41/10", 0)]], "1/100", False),
        ("-3/5", -1, [FIRST], "1/18", False),  # solutions come back over the ray
        ("-3/5", 1, [], "1/18", False),
    ],
)
def test_turns_are_crossed_inwards(a, way, turns, level, holds):
    H, term = turning(a, way), {"channel": 1, "weight": "1/1000", "sector": ["-1", "1"], "reach": "100"}
    proof = {"method": "spiral", "P": [[level], ["0", level]], "turns": [listed(one) for one in turns]}
    given = H, [NONE], {"terms": [term]}, proof
    with assert_accepted_if(holds):
        assert second.shown(document(H, [NOTHING], "planar", given[2], proof)) == second.WITHIN
    if holds:
        assert regions.spiral(*given)
    else:
        with pytest.raises((Rejected, Malformed)):
            regions.spiral(*given)

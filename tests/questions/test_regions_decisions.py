"""What is said of sets that 0 attracts, and how they are chosen, one decision at a time."""

from fractions import Fraction as F
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from lure import InputError, Saturation, as_plant
from lure.analysis.certificates.checker import CONVERGES
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.ellipsoids import Local, ellipsoid
from lure.analysis.questions import regions
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.region_areas import form_said
from lure.analysis.questions.region_proofs import proved_ellipsoid, unstable_near_0
from lure.analysis.questions.region_sets import matrix_of, plus, shape_of
from lure.analysis.questions.regions import AttractedSet, OutsideSet, RegionOfAttraction, region
from lure.analysis.verdict import Verdict
from lure.nonlinearities import Cubic, PiecewiseLinear

PROVED, OPEN = Verdict.PROVED, Verdict.INCONCLUSIVE
POINTS = ((F(0), F(0)), (F(2), F(0)), (F(0), F(2)))


def proof(conclusion="every motion from it tends to 0", **inner):
    certificate = {"conclusion": conclusion, "proof": {"method": "ellipsoid"} | inner, "system": {"C": [["1", "0"]]}}
    return SimpleNamespace(certificate=certificate, theorem="region")


def inside(kind="ellipsoid", volume=1 / 3, **more):
    given = {"P": ((F(1, 3),),)} if kind in ("ellipsoid", "level set") else {}
    return AttractedSet(**{"kind": kind, "volume": volume, "proof": proof()} | given | more)


def outside(kind="curve", **more):
    return OutsideSet(**{"kind": kind, "proof": proof()} | more)


def found(sets=(), beyond=(), area=(0.0, None), **more):
    given = {"verdict": PROVED if sets else OPEN, "states": 2, "sets": tuple(sets), "outside": tuple(beyond)}
    return RegionOfAttraction(**given | {"area": area} | more)


WHOLE = "PROVED: every solution tends to 0, wherever it starts"
EXACT = "sets[0].P has it exactly, in Python and in the JSON."
CURVE = {"kind": "curve", "points": POINTS}


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (found(reason="why"), ["INCONCLUSIVE: no set of starts is proved to be attracted by 0: why."]),
        (
            found([inside("everything", inf, proof=proof(CONVERGES))], area=(inf, inf)),
            [f"{WHOLE}: it converges to the set of equilibria, and 0 is the only one."],
        ),
        (found([inside("everything", inf)], area=(inf, inf)), [f"{WHOLE}."]),
        (found([inside("interval", inf, interval=(-inf, inf))], area=(inf, inf)), [f"{WHOLE}."]),
        (
            found([inside("interval", interval=(F(-1, 3), F(2, 3)))], area=(1 / 3, 1 / 3), states=1),
            [
                "PROVED: every solution that starts between -0.3333333333 and 0.6666666666 tends to 0.",
                "The length of the region is at most 0.3333334.",
            ],
        ),
        (
            found([inside(**CURVE)], area=(0.5, None)),
            [
                "PROVED: every solution that starts within a closed curve of 3 points tends to 0; its area is at least "
                "0.3333333.",
                "Together with 0 more the area is at least 0.5.",
            ],
        ),
        (
            found([inside(), inside()], area=(1 / 3, inf), reach=2 / 3, states=3),
            [
                "PROVED: every solution that starts in the ellipsoid x^T P x <= 1 tends to 0; its volume is at least "
                "0.3333333.",
                f"P = [[0.3333334]], rounded so that its ellipsoid lies inside; {EXACT}",
                "It holds the points asked about times 0.6666666.",
            ],
        ),
        (
            found([inside("level set", integrals=({"theta": "1/3", "channel": 2},))], area=(1 / 3, 2.0)),
            [
                "PROVED: every solution that starts in the level set x^T P x + 2 sum theta_i int phi_i <= 1 tends to "
                "0; its area is at least 0.3333333.",
                f"P = [[0.3333334]], theta_2 = 0.3333333, rounded; {EXACT}",
                "The area of the region is at most 2.",
            ],
        ),
        (
            found([inside(**CURVE)], [outside(points=POINTS, proof=proof(orbit=1))], area=(1 / 3, None)),
            [
                "PROVED: every solution that starts within a closed curve of 3 points tends to 0; its area is at least "
                "0.3333333.",
                "No solution that starts on or outside another one, of 3 points, does. A periodic solution runs "
                "between them.",
            ],
        ),
        (
            found((), [outside(points=POINTS, proof=proof(orbit=1))], reason="why"),
            [
                "INCONCLUSIVE: no set of starts is proved to be attracted by 0: why.",
                "No solution that starts on or outside a closed curve, of 3 points, tends to 0. A periodic solution "
                "lies within.",
            ],
        ),
        (
            found((), [outside(points=POINTS)], reason="why"),
            [
                "INCONCLUSIVE: no set of starts is proved to be attracted by 0: why.",
                "No solution that starts on or outside a closed curve, of 3 points, tends to 0.",
            ],
        ),
        (
            found((), [outside("ellipsoid", Q=((F(1),),))], reason="why"),
            [
                "INCONCLUSIVE: no set of starts is proved to be attracted by 0: why.",
                "No solution that starts where x^T Q x > 1 tends to 0.",
                "Q = [[1]], rounded so that this holds for it too; outside[0].Q has it exactly, in Python and in the "
                "JSON.",
            ],
        ),
        (
            found([inside("everything", inf)], area=(inf, inf), reason="what is survived is not known"),
            [f"{WHOLE}.", "What is survived is not known."],
        ),
        (
            found([inside("everything", inf)], area=(inf, inf), reason="x", reachable="So far."),
            [f"{WHOLE}.", "So far."],
        ),
    ],
)
def test_a_region_is_told(one, said):
    assert one.lines() == said
    assert one.criterion == ("region" if one.sets else "")
    assert one._sides == (one.sets[0].proof if one.sets else None, one.outside[0].proof if one.outside else None)


# the ends of an interval are rounded into what is said: inwards of what is attracted, outwards of what is not
@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ((F(-1, 3), F(2, 3)), "from 0.6666666667 on or up to -0.3333333334"),
        ((F(-1, 3), inf), "up to -0.3333333334"),
        ((-inf, F(2, 3)), "from 0.6666666667 on"),
    ],
)
def test_starts_beyond_an_interval_are_told(ends, said):
    one = found((), [outside("interval", interval=ends)], reason="why", states=1)
    assert one.lines()[1:] == [f"No solution that starts {said} tends to 0."]


def test_a_large_matrix_is_not_written_out():
    for n, begin in ((6, "P = [[1, 0, 0, 0, 0, 0]"), (7, "P has 7 rows; sets[2].P has it exactly")):
        (said,) = form_said("P", tuple(tuple(F(i == j) for j in range(n)) for i in range(n)), 2)
        assert said.startswith(begin)
    assert form_said("P", None) == []


# V = x^2 on a line, an ellipsoid in the plane; a closed curve; an open interval
@pytest.mark.parametrize(
    ("one", "held", "not_held"),
    [
        (inside(P=((F(1), F(0)), (F(0), F(4)))), [(1, 0), (0, F(1, 2))], [(1, F(1, 100)), (0, F(51, 100))]),
        (inside("interval", interval=(F(-1), F(2))), [(0,), (F(199, 100),)], [(-1,), (2,), (3,)]),
        (inside("interval", interval=(-inf, inf)), [(10**9,)], []),
        (inside("everything"), [(1, 2, 3), (5,)], []),
    ],
)
def test_which_states_a_set_holds(one, held, not_held):
    assert [one.contains(state) for state in held] == [True] * len(held)
    assert [one.contains(state) for state in not_held] == [False] * len(not_held)
    assert one.bounded is (one.P is not None)
    for size in (0, 4):
        if one.kind != "everything":
            with pytest.raises(InputError, match=f"state has {size} entries"):
                one.contains([1] * size)


# V = x'P x + 2 theta int_0^x1 sat, with sat(s) = s up to 1: x1^2/2 up to 1, then |x1| - 1/2; up to |x1| = 2
def test_integrals_are_part_of_a_set():
    laws = {"graphs": [{"cuts": ["-1", "1"], "pieces": [["-1"], ["0", "1"], ["1"]]}]}
    shown = proof()
    shown.certificate["laws"] = laws
    given = {"channel": 1, "theta": "1/8", "reach": "2", "least": "1/2"}
    one = inside("level set", P=((F(1, 8), F(0)), (F(0), F(1))), integrals=(given,), proof=shown)
    exact = {(1, 0): F(1, 4), (2, 0): F(1, 2) + F(3, 8), (-2, 0): F(7, 8), (F(201, 100), 0): 2, (1, 1): F(5, 4)}
    assert {point: one.exactly([F(v) for v in point]) for point in exact} == exact
    points = np.array([[1.0, 0.0], [2.0, 0.0], [2.01, 0.0], [1.0, 1.0]])
    assert one.values(points).tolist() == pytest.approx([0.25, 0.875, inf, 1.25])
    assert one.least().tolist() == [[0.125 + 1 / 16, 0], [0, 1]]
    assert (one.contains((2, 0)), one.contains((2, 1))) == (True, False)


def test_the_largest_multiple_of_points_that_a_set_holds():
    disc = inside(P=((F(1), F(0)), (F(0), F(1))))
    reach = regions._reach(disc, np.array([[3.0, 4.0], [0.0, 1.0]]))
    assert 0.2 * (1 - 1e-14) < reach <= 0.2
    assert 5 * (1 - 1e-14) < regions._reach(disc, np.array([[0.2, 0.0]])) <= 5
    assert plus([[F(1), F(2)], [F(2), F(5)]], F(3), [F(1), F(-1)]) == ((4, -1), (-1, 8))


# what the signs of x' show of one state
@pytest.mark.parametrize(
    ("first", "second", "area", "verdict"),
    [
        (["-1", "2"], ["-1", "2"], (3, 3), PROVED),
        (["-1", "2"], ["-inf", "2"], (3, inf), PROVED),
        (["-1", "2"], None, (3, None), PROVED),
        (["-inf", "2"], ["-1", "2"], (inf, inf), PROVED),
        (["-inf", "inf"], None, (inf, inf), PROVED),
        (None, ["-1", "2"], (0, 3), OPEN),
        (None, None, (0, None), OPEN),
    ],
)
def test_the_region_of_one_state(first, second, area, verdict):
    ends = [None if one is None else proof(interval=one) for one in (first, second)]
    one = regions._of_signs(*ends, SimpleNamespace(order=1), None)
    assert (one.area, one.verdict, len(one.sets), len(one.outside)) == (
        area,
        verdict,
        first is not None,
        second is not None,
    )
    assert (one.reason == "no interval around 0 was found on which |x| falls") is (first is None)
    if first == ["-1", "2"]:
        assert (one.sets[0].interval, one.sets[0].volume) == ((-1, 2), 3)
    if first == ["-inf", "2"]:
        assert one.sets[0].interval == (-inf, 2)


# a closed curve that adds less than a hundred thousandth to the others is left out, the first set never
def test_sets_that_add_nothing_are_left_out():
    square = ((F(-1), F(-1)), (F(1), F(-1)), (F(1), F(1)), (F(-1), F(1)))
    small, large = (inside("level set", corners=tuple((s * x, s * y) for x, y in square)) for s in (F(1), F(2)))
    blank = inside("level set")
    sets, area = regions._needed([large, small, blank])
    assert (sets, area) == ([large, small, blank], pytest.approx(16, rel=1e-8))
    assert area <= 16


# steps of the search and what ends it
@pytest.mark.parametrize(
    ("ellipsoid", "grown", "everywhere", "said"),
    [
        (None, None, None, "no invariant ellipsoid was found"),
        (TimeoutError, None, None, "the time allowed is over"),
        (None, None, "whole", "everything"),
        (None, "beyond", "whole", "no invariant ellipsoid was found"),
    ],
)
def test_what_a_region_is_where_no_ellipsoid_is_found(ellipsoid, grown, everywhere, said, monkeypatch):
    def search(*_given):
        if ellipsoid is not None:
            raise ellipsoid

    monkeypatch.setattr(regions, "sign_interval", lambda *_: None)
    monkeypatch.setattr(regions, "proved_ellipsoid", search)
    beyond = None if grown is None else proof()
    if beyond is not None:
        beyond.certificate["proof"] |= {"Q": [["1"], ["0", "1"]], "exponent": 0}
    monkeypatch.setattr(regions, "proved_growth", lambda *_: beyond)
    monkeypatch.setattr(regions, "proved_everywhere", lambda *_: None if everywhere is None else proof())
    monkeypatch.setattr(regions, "matrix_of", lambda *_: ((F(1), F(0)), (F(0), F(1))))
    found, shape = SimpleNamespace(order=2, D=((0,),)), SimpleNamespace(reach=None, pieces=())
    one = regions._answered((found, [shape]), (found, [shape]), None, None)
    if said == "everything":
        assert (one.verdict, one.sets[0].kind, one.area) == (PROVED, "everything", (inf, inf))
        local = regions._answered((found, [SimpleNamespace(reach=F(1))]), (found, [shape]), None, None)
        assert local.verdict is OPEN  # a class known on an interval only
        return
    assert (one.verdict, one.reason, one.sets) == (OPEN, said, ())
    assert one.stopped == ("time" if ellipsoid else None)
    assert len(one.outside) == (grown is not None)
    assert one.area[0] == 0
    assert one.area[1] is None if grown is None else 3.14159 < one.area[1] < 3.1416


def test_time_is_that_of_the_plant():
    plants = [None, SimpleNamespace(dt=None), SimpleNamespace(dt=F(1))]
    assert [found(plant=plant).discrete for plant in plants] == [False, False, True]


def test_a_plant_without_states_has_no_region():
    with pytest.raises(InputError, match="the plant has no states"):
        region("2", Saturation(gain=F(1, 4), limit=1))


# Loops that are linear near 0, and not asymptotically stable there.  In continuous time a solution that tends to 0 ends
# in the stable subspace, which has volume 0, and so have its images back in time.


# x' = x - x/2; s^2 - s/2 - 1 + 4; s^2 + 4, whose solutions are periodic; s^2 - 1 + s - 1 = (s - 1)(s + 2)
@pytest.mark.parametrize(
    ("plant", "gain"),
    [(([1], [1, -1]), F(1, 2)), (([1], [1, F(-1, 2), -1]), 4), (([1], [1, 0, 0]), 4), (([1, -1], [1, 0, -1]), 1)],
)
def test_in_continuous_time_no_set_is_attracted_then(plant, gain):
    answer = region(plant, Saturation(gain=gain, limit=1))
    assert (answer.verdict, answer.sets, answer.area) == (Verdict.REFUTED, (), (0.0, 0.0))
    near = "near 0 the loop is linear and not asymptotically stable, so that almost no solution tends to 0"
    assert answer.lines()[0] == f"REFUTED: {near}."
    high = answer.certificates["high"]
    assert high["proof"] == {"method": "linear-gains", "gains": [str(gain)]}
    assert recheck(high).accepted


# z^2 - 1.9 z + 0.98 and a slope of 1 near 0: z^2 - 1.8 z + 1, of two roots of modulus 1
def test_in_discrete_time_nothing_follows_about_sets():
    answer = region(as_plant("(0.1*z + 0.02)/(z^2 - 1.9*z + 0.98)", dt=1), Saturation(gain=1, limit=1))
    near = "near 0 the loop is linear and not asymptotically stable"
    assert answer.lines()[0] == f"INCONCLUSIVE: no set of starts is proved to be attracted by 0: {near}."
    assert (answer.refutation, answer.area[0]) == (None, 0.0)


def folded(*points, ends=(0, 0)):
    """Points of mu = -phi, (0, 0) among them, as a nonlinearity."""
    left, right = (-slope for slope in ends)
    return PiecewiseLinear([(a, -b) for a, b in points], left_slope=left, right_slope=right)


def returning():
    """x+ = clip(h1(x), -b, b), y+ = clip(h2(x), -b, b), b = b(y): with it 0 is unstable and attracts a neighbourhood.

    For |y| <= 1/2, b = 2 and (x, y) goes to (h1, h2)(x), which is (2 x, 0) for |x| <= 1/2 and, as x goes on to 1, leads
    from (1, 0) over (1, 1) and (0, 1) to (0, 0).  From there all goes to 0: h(0) = h(1) = 0 and b(1) = 0.
    """
    h1 = [(F(1, 2), 1), (F(5, 8), 1), (F(3, 4), 0)]
    h2 = [(F(1, 2), 0), (F(5, 8), 1), (F(3, 4), 1), (1, 0)]
    h1, h2 = (folded(*[(-a, -b) for a, b in h[::-1]], (0, 0), *h) for h in (h1, h2))
    b = folded((-1, -2), (F(-1, 2), 0), (0, 0), (F(1, 2), 0), (1, -2))  # b(y) - 2
    above, below = (
        folded((-2, -2), (0, 0), ends=(-1, 1)),
        folded((0, 0), (2, -2), ends=(-1, 1)),
    )  # |s + 2| - 2, |s - 2| - 2
    C = [[1, 0], [1, 0], [0, 1], *[[0, 0]] * 4]
    D = [[0] * 7, [0] * 7, [0] * 7, *([*one, sign, 0, 0, 0, 0] for one in ([1, 0], [0, 1]) for sign in (1, -1))]
    B = [[0, 0, 0, F(1, 2), F(-1, 2), 0, 0], [0, 0, 0, 0, 0, F(1, 2), F(-1, 2)]]
    return as_plant(([[0, 0], [0, 0]], B, C, D), dt=1), [h1, h2, b, above, below, above, below]


def test_an_unstable_0_may_attract_a_neighbourhood_in_discrete_time():
    plant, laws = returning()
    assert unstable_near_0(plant, list(map(shape_of, laws))) is not None
    x, y = (part.ravel() for part in np.meshgrid(np.linspace(-1, 1, 65), np.linspace(-0.5, 0.5, 9)))
    for _ in range(9):  # 1/32 doubles four times
        mu = np.zeros((7, len(x)))
        for i, (c, d) in enumerate(zip(plant.doubles()[2], plant.doubles()[3], strict=True)):
            mu[i] = -laws[i](c @ [x, y] + d @ mu)
        x, y = plant.doubles()[1] @ mu
    assert not x.any()
    assert not y.any()


@pytest.mark.slow
def test_nothing_else_is_said_of_it():
    answer = region(*returning())
    assert (answer.verdict, answer.sets) == (OPEN, ())
    assert str(answer).endswith("near 0 the loop is linear and not asymptotically stable.")


# sigma = x + 3 sat(sigma), with a cycle: near x = 0 there is also sigma = 3, where the loop is another
def test_nothing_is_said_where_sigma_need_not_be_near_0():
    plant = channel_plant(as_plant(([[1]], [[1]], [[1]], [[-3]])))
    assert unstable_near_0(plant, [shape_of(Saturation(limit=1))]) is None


# x' = -x - phi, q' = x - q: q acts on nothing, so a set may be made longer along q for ever, and none is the largest.
# phi = -x^3: x tends to 0 from between -1 and 1, whatever q is
@pytest.mark.slow
def test_a_state_that_sigma_does_not_see_leaves_the_others_their_region():
    downstream = channel_plant(as_plant(([[-1, 0], [1, -1]], [1, 0], [1, 0], 0)))
    falling = shape_of(Cubic(linear=0, cubic=-1))
    found = proved_ellipsoid(downstream, [falling], None)
    assert found is not None
    P = np.array(matrix_of(found.certificate), dtype=float)
    widths = np.sqrt(np.diag(np.linalg.inv(P)))
    assert 0.9 < widths[0] < 1
    assert 10 < widths[1] < 1e7


# the same loop with the sector [-1/2, 0] on |x| <= 1/2: x goes as far as that, and q a hundred times as far as at first
def test_an_ellipsoid_is_not_made_longer_for_ever_along_a_state_that_is_not_seen():
    plant = [np.array(part, dtype=float) for part in ([[-1, 0], [1, -1]], [[1], [0]], [[1, 0]], [[0]])]
    found = ellipsoid(plant, [Local(-0.5, 0.0, None, 0.5)], discrete=False)
    widths = np.sqrt(np.diag(np.linalg.inv(found.P)))
    assert widths == pytest.approx([0.5, 50], rel=0.5)


# a phase-locked loop with proportional and integral paths that cancel: sigma = x1 + x2 has sigma' = -2 sin(sigma), and
# no sigma sees x1 - x2. A sector of sin on 2^24, of no set at all, was bounded for minutes, and nothing proved
@pytest.mark.slow
def test_an_interval_that_no_set_goes_through_is_not_looked_at():
    found = region(([[0, 1], [0, -1]], [1, 1], [1, 1], 0), "sin(sigma)")
    assert found.verdict is Verdict.PROVED
    assert found.sets[0].contains([1.5, 1.5])
    assert not any(one.contains([1.6, 1.6]) for one in found.sets)  # sigma > pi


# x1' = x2, x2' = x1 + mu, sigma = 3 x1 + 4 x2 + mu/10 feeds through to itself, and no ellipsoid is looked for:
# that none was found is no reason
def test_where_a_channel_feeds_through_to_itself_the_reason_says_so():
    found = region(as_plant(([[0, 1], [1, 0]], [0, 1], [3, 4], F(1, 10))), Saturation())
    assert (found.verdict, found.reason[:50]) == (OPEN, "a channel feeds through D back to itself, directly")


# x1' = x1 + mu, x2' = -x2 + mu, sigma = x1: the axis of x2 may be as long as one likes, and the area is any number
def test_a_size_beside_a_state_that_is_not_seen_is_said_to_say_little():
    told = "No sigma sees some of the states: a set may be made longer along them, and so the area says little."
    assert told in region(as_plant(([[1, 0], [0, -1]], [1, 1], [1, 0], 0)), Saturation(gain=2)).lines()
    assert told not in region(as_plant(([[0, 1], [1, 0]], [0, 1], [3, 4], 0)), Saturation()).lines()

"""Curves in the plane on both sides of a periodic solution that repels: sharp, checked twice, and attacked."""

from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pytest
from depth import sampled
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp
from tampering import assert_both_reject, edited

from lure import Saturation, as_plant
from lure.analysis import check, region
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.region_areas import area, level_polygon, polygon_within, union_below
from lure.analysis.questions.region_curves import gauge, within
from lure.nonlinearities import Cubic

# Van der Pol's oscillator back in time: x' = -x + x^3/3 - y, y' = x.  The region ends at its periodic solution.
OSCILLATOR = as_plant(([[-1, -1], [1, 0]], [1, 0], [1, 0], 0))
INWARD = Cubic(linear=0, cubic=Fraction(-1, 3))
# Antistable, x'' = x'/2 - x - sat(x + 2 x'): the region is bounded by one periodic solution (Hu, Lin, Qiu 2001).
HELD = as_plant(([[0, 1], [-1, "0.5"]], [0, 1], [1, 2], 0))


def area_of_orbit(field, start):
    """The area within the periodic solution that attracts back in time, by Green's theorem along it."""

    def back(_, z):
        rate = -np.asarray(field(z))[:2]
        return [*rate, (z[0] * rate[1] - z[1] * rate[0]) / 2]

    def around(_, z):
        return z[1]

    around.direction = 1
    found = solve_ivp(back, (0, 150), [*start, 0], rtol=1e-11, atol=1e-12, events=around)
    return abs(found.y_events[0][-1][2] - found.y_events[0][-2][2])


@pytest.fixture(scope="module")
def oscillator():
    return region(OSCILLATOR, INWARD)


@pytest.fixture(scope="module")
def held():
    return region(HELD, Saturation())


# With slope 1 the eigenvalues -1/2 and -1 are real: no solution goes around 0 near it, each turn leaves the ellipsoid.
@pytest.mark.slow
def test_a_spiral_ends_in_the_ellipsoid_where_no_solution_winds_around_0():
    found = region(as_plant(([[0, "-0.5"], [1, "1.5"]], [0, 1], [0, 3], 0)), Saturation())
    low, high = found.area
    truth = area_of_orbit(lambda z: (-z[1] / 2, z[0] + 1.5 * z[1] - np.clip(3 * z[1], -1, 1)), [0.3, 0.3])
    assert low < truth < high < 1.003 * low
    assert recheck(found.proof.certificate).accepted


@pytest.mark.slow
def test_the_area_within_van_der_pols_oscillation_is_enclosed(oscillator):
    truth = area_of_orbit(lambda z: (-z[0] + z[0] ** 3 / 3 - z[1], z[0]), [1, 0])
    low, high = oscillator.area
    assert low < truth < high < 1.003 * low
    assert [one.kind for one in oscillator.sets] == ["curve", "level set", "ellipsoid"]
    assert "No solution that starts on or outside another one" in str(oscillator)


@pytest.mark.slow
def test_the_area_of_an_antistable_loop_under_saturation_is_enclosed(held):
    truth = area_of_orbit(lambda z: (z[1], z[1] / 2 - z[0] - np.clip(z[0] + 2 * z[1], -1, 1)), [1, 0])
    low, high = held.area
    assert low < truth < high < 1.006 * low


@pytest.mark.slow
def test_both_checkers_accept_the_curves(oscillator, held):
    for found in (oscillator, held):
        for shown in (found.proof, found.refutation):
            assert check(shown.certificate).claim.startswith(recheck(shown.certificate).reason)


def wound_back(rows):
    """The same curve in the other sense."""
    points = [rows[-1][-2:]]
    for before, row in zip(rows[-2::-1], rows[:0:-1], strict=True):
        points.append([*row[:-2], *before[-2:]])
    return points


def times(factor):
    """Every coordinate by a factor."""
    return lambda rows: [[str(Fraction(v) * factor) for v in row] for row in rows]


@pytest.mark.parametrize(
    "change",
    [
        wound_back,
        lambda rows: rows[: len(rows) // 2],
        lambda rows: [*rows, *rows[1:]],  # twice around
        lambda rows: rows[:1] + rows[2:],
        lambda rows: [*rows[:-1], [str(Fraction(v) / 2) for v in rows[-1]]],
        lambda rows: [[v, w] for *_, v, w in rows],  # chords in place of parabolas
        lambda rows: [[*rows[0], *rows[0]], *rows[1:]],
        lambda rows: [],
    ],
)
def test_a_curve_that_is_tampered_with_is_rejected(oscillator, change):
    assert_both_reject(edited(oscillator.refutation.certificate, "proof", "points", value=change))
    assert_both_reject(edited(oscillator.proof.certificate, "proof", "turns", 0, value=change))


@pytest.mark.slow
def test_a_curve_may_move_away_from_the_periodic_solution_but_not_across_it(oscillator):
    for shown, path, away in ((oscillator.proof, ("turns", 0), -1), (oscillator.refutation, ("points",), 1)):
        fine, wrong = (
            edited(shown.certificate, "proof", *path, value=times(1 + Fraction(side * away, 100))) for side in (1, -1)
        )
        assert check(fine, draft=True).claim.startswith(recheck(fine).reason)
        assert recheck(fine).accepted
        assert_both_reject(wrong)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("proof", "turns"), lambda turns: turns[:-1]),  # the last turn ends outside of the ellipsoid
        (("proof", "turns"), lambda turns: turns[:1] + turns[2:]),  # a turn is missing
        (("proof", "turns"), lambda turns: turns[::-1]),
        (("proof", "turns"), []),
        (("proof", "P"), [["1/1000"], ["0", "1/1000"]]),
        (("system", "time"), "discrete"),
        (("system", "A", 0, 0), "1"),
        (("laws", "graphs", 0, "pieces", 0, 3), "-3"),
        (("theorem",), "local-circle"),
        (("conclusion",), "every motion tends to 0"),
    ],
)
def test_a_spiral_that_is_tampered_with_is_rejected(oscillator, path, value):
    assert_both_reject(edited(oscillator.proof.certificate, *path, value=value), stored=path == ("conclusion",))


@pytest.mark.slow
def test_a_parabola_stays_in_one_piece_of_the_saturation(held):
    # every straight edge written as a parabola is the same edge, but those across a corner are then refused
    rows = held.refutation.certificate["proof"]["points"]
    sigma = [Fraction(row[-2]) + 2 * Fraction(row[-1]) for row in rows]
    across = [i for i in range(1, len(rows)) if any(sigma[i - 1] < cut < sigma[i] for cut in (-1, 1))]
    assert across
    for place, (before, row) in enumerate(pairwise(rows), 1):
        if len(row) == 2:
            middle = [str((Fraction(a) + Fraction(b)) / 2) for a, b in zip(before[-2:], row, strict=True)]
            bent = edited(held.refutation.certificate, "proof", "points", place, value=[*middle, *row])
            refused = any(
                min(sigma[place - 1 : place + 1]) < cut < max(sigma[place - 1 : place + 1]) for cut in (-1, 1)
            )
            assert recheck(bent).accepted is not refused
            if refused:
                assert_both_reject(bent)


def test_another_equilibrium_within_the_first_turn_is_not_overlooked(oscillator):
    # x' = -x - phi(x) - y, y' = x + ... : with phi = -2 x the determinant of A - B C changes its sign and 0 is a saddle
    graphs = {"kind": "piecewise-polynomial", "cuts": [], "pieces": [["0", "-3/2", "0", "1/8"]]}
    changed = edited(oscillator.proof.certificate, "laws", "graphs", 0, value=graphs)
    assert_both_reject(edited(changed, "system", "A", value=[["-1", "-1"], ["1", "-1"]]))


def test_a_periodic_solution_is_claimed_of_a_stable_equilibrium_that_is_alone(oscillator):
    certificate = oscillator.refutation.certificate
    assert certificate["conclusion"].endswith("and within it there is a periodic motion")
    assert "A periodic solution runs between them." in str(oscillator)
    assert_both_reject(edited(certificate, "proof", "orbit", value=False))
    assert_both_reject(edited(certificate, "theorem", value="planar"))
    # x' = -x + x^3/3 + x/2 - y has the curve too, but with x/2 more, 0 repels
    for slope, stable in (("-1/2", True), ("-3/2", False)):
        moved = edited(certificate, "laws", "graphs", 0, "pieces", 0, value=["0", slope, "0", "-1/3"])
        shown = recheck(edited(moved, "proof", "points", value=times(Fraction(3, 2))))
        assert shown.accepted is stable
        assert stable or "0 is not shown to attract" in shown.reason
        if not stable:
            assert_both_reject(edited(moved, "proof", "points", value=times(Fraction(3, 2))))


def test_the_area_of_a_union_is_that_of_the_largest_in_each_direction():
    # two rectangles across each other: 4 x 2 and 2 x 4 have 8 + 8 - 4 in common
    wide = [(Fraction(x), Fraction(y)) for x, y in ((2, -1), (2, 1), (-2, 1), (-2, -1))]
    tall = [(-y, x) for x, y in wide]
    assert float(union_below([wide])) == pytest.approx(8, rel=1e-8)
    assert union_below([wide]) < 8
    # where edges cross between two rays the larger triangle alone counts, less than the union
    assert 8 < union_below([wide, tall]) < 12
    inner = [(x / 2, y / 2) for x, y in wide]
    assert union_below([wide, inner]) == union_below([wide])


def test_a_polygon_within_a_curve_is_nearly_the_curve(oscillator):
    points = oscillator.sets[0].points
    corners = polygon_within(points)
    assert all(within(points, corner) for corner in corners)
    assert 0.999 * area(points) < union_below([corners]) < area(points)
    ellipse = polygon_within(oscillator.sets[-1].P)
    assert 0.999 * oscillator.sets[-1].volume < union_below([ellipse]) < oscillator.sets[-1].volume


# Khalil, Nonlinear Systems: x'' + x' + x - x^3/3 = 0 with saddles at +-sqrt(3), and V = 3 x^2/4 - x^4/12 + x x'/2 +
# x'^2/2, which falls on V < 9/8, |x| < sqrt(3), a set that is not convex, of area 7.408
@pytest.mark.slow
def test_a_spring_that_softens_has_a_level_set_that_is_larger_than_a_published_one():
    spring = as_plant(([[0, 1], [-1, -1]], [0, 1], [1, 0], 0))
    found = region(spring, Cubic(linear=0, cubic=Fraction(-1, 3)))
    first = found.sets[0]
    assert (first.kind, first.convex) == ("level set", False)
    assert 7.408 * 1.2 < first.volume < found.area[0]
    assert recheck(dict(first.proof.certificate)).accepted
    weights = np.random.default_rng(0).dirichlet([1, 1, 1], size=200)  # of points of triangles
    corners = np.array(first.corners, dtype=float)
    triangles = np.stack([0 * corners, corners, np.roll(corners, -1, axis=0)], axis=1)
    points = np.einsum("kc,kcx->kx", weights, triangles)
    assert all(first.contains(point) for point in points.tolist())
    x = corners
    for _ in range(500):
        half = x + 0.01 * np.column_stack([x[:, 1], -x[:, 0] + x[:, 0] ** 3 / 3 - x[:, 1]])
        x = x + 0.02 * np.column_stack([half[:, 1], -half[:, 0] + half[:, 0] ** 3 / 3 - half[:, 1]])
    assert np.abs(x).max() < 0.05
    assert not any(first.contains([side * 1.7330, 0]) for side in (1, -1))  # beyond sqrt(3) solutions leave


@pytest.mark.slow
def test_a_polygon_within_the_unit_disc_is_smaller_the_less_is_known_of_the_bend():
    def value(points):
        return (points**2).sum(axis=1)

    def polygon(bend, *, convex):
        form = ((Fraction(bend), Fraction(0)), (Fraction(0), Fraction(bend)))
        return level_polygon(value, lambda x: x[0] ** 2 + x[1] ** 2, form, np.eye(2), convex=convex)

    sizes = [float(union_below([polygon(bend, convex=bend > 0)])) for bend in (1, -1, -20)]
    assert sizes[0] == pytest.approx(100 * np.sin(2 * np.pi / 200), rel=2e-6)
    assert sizes[0] > sizes[1] > sizes[2] > 0.9 * np.pi
    assert polygon(-1000, convex=False) == []


@pytest.mark.slow
def test_membership_is_exact_and_agrees_with_the_drawing(oscillator):
    points = oscillator.sets[0].points
    rng = np.random.default_rng(7)
    places = rng.uniform(-2.5, 2.5, (400, 2))
    values = gauge(points)(places)
    clear = np.abs(values - 1) > 1e-3
    inside = [within(points, tuple(map(Fraction, place))) for place in places.tolist()]
    assert [bool(v) for v in (values < 1)[clear]] == [v for v, told in zip(inside, clear, strict=True) if told]
    assert abs(float(area(points)) / (25 * (values < 1).mean()) - 1) < 0.1
    assert oscillator.sets[0].contains([0, 0])
    assert not oscillator.sets[0].contains([2.5, 0])


@pytest.mark.slow
def test_nothing_leaves_the_inner_curve_and_nothing_comes_in_through_the_outer(held):
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    inner, outer = (gauge(points)(rays) for points in (held.sets[0].points, held.outside[0].points))
    z = np.concatenate([0.999 * rays / inner[:, None], 1.001 * rays / outer[:, None]])

    def rate(z):
        x, y = z.T
        return np.stack([y, y / 2 - x - np.clip(x + 2 * y, -1, 1)], axis=1)

    for _ in range(12000):
        z = np.where(np.abs(z) < 1e3, z + 0.005 * rate(z + 0.0025 * rate(z)), z)
    size = np.linalg.norm(z, axis=1)
    assert size[:60].max() < 0.1
    assert size[60:].min() > 3


@pytest.mark.parametrize(
    "plant", [as_plant(([["0.5", 1], [-1, "0.5"]], [0, 1], [1, 2], 0), dt=1), as_plant(([1], [1, -1]))]
)
def test_curves_are_for_two_states_in_continuous_time(plant):
    assert all(one.kind != "curve" for one in region(plant, Saturation(gain=2)).sets)


@pytest.mark.slow
def test_two_channels_have_an_outer_curve(held):
    # the same loop with its saturation in two halves
    twice = as_plant(([[0, 1], [-1, "0.5"]], [[0, 0], [1, 1]], [[1, 2], [1, 2]], [[0, 0], [0, 0]]))
    found = region(twice, [Saturation(gain="0.5", limit="0.5")] * 2)
    assert found.area[1] == pytest.approx(held.area[1], rel=1e-3)
    assert recheck(found.refutation.certificate).accepted


@pytest.mark.slow
def test_a_region_between_saddles_is_larger_than_its_ellipsoid():
    # x'' = x - x'/10 - sat(3 x + x'/5): saddles at +-1, where x = sat
    found = region(as_plant(([[0, 1], [1, "-0.1"]], [0, 1], [3, "0.2"], 0)), Saturation())
    first, opposite, level, second = found.sets
    assert [one.kind for one in found.sets] == ["curve", "curve", "level set", "ellipsoid"]
    assert first.volume == opposite.volume > 1.2 * level.volume > 1.2 * second.volume
    assert not first.contains([1, 0])
    # the nonlinearity is odd: the curve through the opposite points is another one, accepted by itself
    assert recheck(opposite.proof.certificate).accepted
    count = sampled(24, of=64)
    middles = [Fraction(2 * i + 1 - count, count) * Fraction(6, 5) for i in range(count)]
    inside = [*product(middles, middles)]
    own, other = ([within(one.points, place) for place in inside] for one in (first, opposite))
    assert other == [within(first.points, (-a, -b)) for a, b in inside]
    hit = (
        np.mean([a or b or level.contains(c) or second.contains(c) for a, b, c in zip(own, other, inside, strict=True)])
        * 2.4**2
    )
    assert found.area[0] > 1.3 * first.volume
    assert found.area[0] == pytest.approx(hit, rel=0.05)


@pytest.mark.slow
def test_the_curves_are_drawn(oscillator):
    axes = oscillator.plot(Figure().subplots())
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels[:2] == ["never tends to 0", "tends to 0 (curve)"]

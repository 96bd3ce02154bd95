"""The two enclosures beneath the bounds, against values in ball arithmetic at points: expansions at ends, and jets."""

import math
import random
from fractions import Fraction

import pytest
from flint import arb

from lure import SlopeBounds
from lure.analysis.nonlinearity import nonlinearity_bounds
from lure.analysis.nonlinearity.expansion import Stretch, Unsettled, enclosure_at_end, expanded
from lure.analysis.nonlinearity.jets import Span, jet, over_sigma, values_by_branch
from lure.analysis.nonlinearity.pieces import difference_vanishes
from lure.analysis.nonlinearity.rational import Candidate, Cover, tightened
from lure.analysis.numerics.precision import working_precision
from lure.expressions import Expression
from lure.expressions.regularity import hull
from lure.expressions.rigorous import ball, enclosure
from lure.expressions.tree import derivative

BITS = 160
FORMULAS = [
    "sigma",
    "3*sigma**2 - sigma/7",
    "1/(1 + sigma)",
    "sigma**3/(2 + sigma**2)",
    "sqrt(4 + sigma**2)",
    "abs(sigma)**1.5",
    "abs(sigma)**0.3 + sigma",
    "tanh(sigma)",
    "tanh(3*sigma)**2 - 1",
    "atan(sigma)*sigma",
    "sin(sigma)",
    "cos(sigma**2)/(1 + sigma**2)",
    "exp(sigma)",
    "exp(-sigma**2)*sigma",
    "sigma**2*exp(-abs(sigma))",
    "exp(sigma)/sigma**5",
    "(exp(sigma) - 1)/(exp(sigma) + 1)",
    "exp(sigma) - exp(sigma - 1/(1 + sigma**2))",
    "log(2 + exp(sigma))",
    "log(3 + abs(sigma))/sigma",
    "tanh(exp(sigma))",
    "exp(sigma - exp(sigma))",
    "sqrt(exp(sigma) + sigma**2)",
    "max(tanh(sigma), sigma/2)",
    "min(sin(sigma), 0.3)",
    "abs(sin(sigma))*sigma",
    "where(sigma > 5, sigma, tanh(sigma))",
    "atan(exp(sigma) - 2)",
    "sin(exp(sigma))",
]


def trees():
    for text in FORMULAS:
        tree = Expression.parse(text, variables=("sigma",)).tree
        yield text, tree
        yield f"({text})'", derivative(tree, "sigma")


TREES = list(trees())
NAMES = [name for name, _ in TREES]


def held(m, t):
    """What an expansion says of the value at ``t``, from its definition."""
    total = Span.of(sum((c * t ** ball(e) for e, c in m.terms.items()), arb(0)))
    total += m.rest * Span.of(t ** ball(m.order))
    if m.growth is not None:
        growth = held(m.growth, t)
        total *= Span(growth.low.exp().lower(), growth.high.exp().upper())
    return total


@pytest.mark.parametrize(
    ("end", "side", "name", "tree"),
    [
        pytest.param(*end, *tree, marks=[pytest.mark.thorough] * ((row + column) % 5 not in (0, 2)))  # two of each tree
        for column, end in enumerate(
            [(Fraction(0), 1), (Fraction(0), -1), (math.inf, -1), (-math.inf, 1), (Fraction(2), 1)]
        )
        for row, tree in enumerate(TREES)
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_expansion_holds_every_value_of_its_stretch(name, tree, end, side):
    source = random.Random(name)
    with working_precision(BITS):
        for stage in (1, 3, 6, 12):
            stretch = Stretch(ball(Fraction(1, 2**stage)))
            try:
                m = expanded(tree, end, side, stretch)
                cover, _ = enclosure_at_end(m, stretch, end, side)
            except Unsettled:
                continue
            for _ in range(6):
                t = Fraction(source.randint(1, 2**20), 2**20) * Fraction(1, 2**stage) ** source.choice([1, 1, 2])
                x = end + side * t if isinstance(end, Fraction) else (1 / t if end > 0 else -1 / t)
                value = enclosure(tree, {"sigma": ball(x)})
                if not value.is_finite():
                    continue
                assert held(m, ball(t)).ball.overlaps(value), (name, end, stage, float(t))
                assert not value < exactly(cover.low)
                assert not value > exactly(cover.high)


def exactly(bound):
    return arb(bound) if isinstance(bound, float) else ball(bound)


def test_most_of_them_settle():
    """The test above would pass if nothing were ever settled."""
    with working_precision(BITS):
        settled = 0
        for _, tree in TREES:
            for end in (math.inf, -math.inf):
                stretch = Stretch(ball(Fraction(1, 2**12)))
                try:
                    cover, limit = enclosure_at_end(expanded(tree, end, -1, stretch), stretch, end, -1)
                except Unsettled:
                    continue
                settled += limit is not None or math.inf not in (abs(cover.low), abs(cover.high))
    assert settled >= 0.85 * 4 * len(FORMULAS)


@pytest.mark.parametrize(("name", "tree"), TREES, ids=NAMES)
def test_a_jet_holds_values_and_slopes_at_every_point_of_its_box(name, tree):
    source = random.Random(name)
    slope = derivative(tree, "sigma")
    curvature = derivative(slope, "sigma")
    with working_precision(BITS):
        for _ in range(12):
            centre = Fraction(source.randint(-6000, 6000), 1000)
            radius = Fraction(1, 2 ** source.randint(1, 20))
            box = ball(centre - radius).union(ball(centre + radius))
            value, first, second = jet(tree, box)
            by_branch = values_by_branch(tree, box)
            for _ in range(4):
                x = centre + radius * Fraction(source.randint(-100, 100), 100)
                truth = enclosure(tree, {"sigma": ball(x)})
                assert value.is_nan() or truth.is_nan() or value.overlaps(truth)
                assert by_branch is None or truth.is_nan() or any(v.is_nan() or v.overlaps(truth) for v in by_branch)
                tangent = enclosure(slope, {"sigma": ball(x)})
                assert first.is_nan() or tangent.is_nan() or first.overlaps(tangent)
                bend = enclosure(curvature, {"sigma": ball(x)}) / 2
                assert second.is_nan() or bend.is_nan() or second.overlaps(bend)


@pytest.mark.parametrize("text", FORMULAS)
@pytest.mark.parametrize("side", [1, -1])
def test_cancelling_sigma_changes_no_value(text, side):
    tree = Expression.parse(text, variables=("sigma",)).tree
    with working_precision(BITS):
        for k in (-3, -1, 0, 1, 2):
            x = side * Fraction(10) ** k * Fraction(7, 5)
            whole = enclosure(tree, {"sigma": ball(x)}) / ball(x)
            cancelled = enclosure(over_sigma(tree, side), {"sigma": ball(x)})
            assert whole.overlaps(cancelled)


def test_a_box_around_a_kink_has_the_slopes_of_both_sides():
    with working_precision(BITS):
        tree = Expression.parse("abs(sigma) + max(sigma, 3*sigma)", variables=("sigma",)).tree
        _, slope, bend = jet(tree, arb(0, 0.5))
        assert slope.contains(arb(0))  # -1 + 1 on the left
        assert slope.contains(arb(4))  # 1 + 3 on the right
        assert bend.is_nan()


def test_products_of_intervals_keep_their_signs():
    # as balls, [0, 1] times [0, 1] reaches below zero
    unit = Span(arb(0), arb(1))
    assert (unit * unit).low == 0
    assert (unit * unit).high == 1
    assert (-unit + unit).low == -1
    assert Span(arb(-2), arb(3)).size.high == 3


@pytest.mark.parametrize(
    ("text", "x", "vanishes"),
    [
        ("tanh(x - 1) + tanh(1)", 0, True),
        ("2*sin(x/3 - 1) + sin(1) + sin(1)", 0, True),
        ("exp(2*x) - exp(2)", 1, True),
        ("cos(x - 2) - cos(2)", 0, True),
        ("sqrt(2 + x)*tanh(1) - sqrt(2)*tanh(1 - x)", 0, True),
        ("exp(sin(1 + x)) - exp(sin(1))", 0, True),
        ("tanh(x - 1) - tanh(1)", 0, False),
        ("cos(x) - 1", 0, True),
        ("x*(1/tanh(x))", 0, False),  # tends to 1
        ("1/tanh(x) - 1/tanh(2*x)", 0, False),  # does not tend
        ("sin(exp(x)) - sin(exp(1))", 0, False),
        ("where(tanh(x + 1) > 0, 1, 2) - where(tanh(x + 1) > 0, 2, 1)", 0, False),
    ],
)
def test_constants_that_cancel_are_seen(text, x, vanishes):
    tree = Expression.parse(text.replace("x", "sigma").replace("esigmap", "exp"), variables=("sigma",)).tree
    nothing = Expression.parse("0", variables=("sigma",)).tree
    assert difference_vanishes(tree, nothing, Fraction(x)) is vanishes
    value = enclosure(tree, {"sigma": ball(Fraction(x))})
    assert (value.is_finite() and bool(abs(value) < 1e-10)) is vanishes


@pytest.mark.parametrize(("name", "tree"), TREES, ids=NAMES)
def test_a_hull_holds_every_value_between_its_ends(name, tree):
    source = random.Random(name)
    with working_precision(BITS):
        for _ in range(12):
            low, high = sorted(Fraction(source.randint(-6000, 6000), 1000) for _ in range(2))
            low = source.choice([low, min(high, Fraction(0))])
            within = hull(tree, *source.choice([(low, high), (-math.inf, high), (low, math.inf)]))
            for _ in range(4):
                truth = enclosure(tree, {"sigma": ball(low + (high - low) * Fraction(source.randint(0, 100), 100))})
                assert not truth < exactly(within[0])
                assert not truth > exactly(within[1])


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("1 + sin(5*sigma)", 0, 2),
        ("-(2 - cos(sigma)/3)", Fraction(-7, 3), Fraction(-5, 3)),
        ("1 - tanh(abs(sigma))**2", 0, 1),
        ("exp(-sigma**2)*sin(sigma)", -1, 1),
        ("(sigma**2 + 2)**-1", 0, Fraction(1, 2)),
        ("3/(2 + sin(sigma))", 1, 3),
        ("1/sigma", -math.inf, math.inf),
        ("exp(sigma)*sign(sigma)", -math.inf, math.inf),
        ("where(sigma > 1, 3, cos(sigma))", -1, 3),
        ("max(abs(sigma), 1)", 1, math.inf),
        ("atan(sigma)", -2, 2),
        ("pi*sin(sigma)", -4, 4),
        ("log(2 + abs(sigma))", 0, math.inf),
        ("sqrt(4 + abs(sigma))", 1, math.inf),
        ("abs(sigma)**1.5", 0, math.inf),
        ("((((1e100 + abs(sin(sigma)))**32)**32)**32)**2", 0, math.inf),  # too long, and rounded outwards
    ],
)
def test_a_hull_is_read_off_the_formula(text, low, high):
    assert hull(Expression.parse(text, variables=("sigma",)).tree, -math.inf, math.inf) == (low, high)


def test_bounds_that_hold_by_the_formula_are_free_of_rounding():
    # phi/sigma = 1 + sin(5 sigma); phi' = 1 + sin(sigma) of the other
    found = nonlinearity_bounds("sigma*(1 + sin(5*sigma))")
    assert (found.sector_lower.outer, found.sector_upper.outer) == (0, 2)
    assert str(found.sector) == "[0, 2]"
    assert "sector [0, 2]" in str(found)
    assert 0 <= found.sector_lower.inner < Fraction(1, 10**40)  # a point where it is taken is irrational
    assert nonlinearity_bounds("sigma - cos(sigma) + 1").slope == SlopeBounds(0, 2)


def test_a_hull_makes_no_bound_where_none_was_shown():
    covers = [Cover(low=-math.inf, high=Fraction(3))]
    values = [Candidate(value=(Fraction(-1), Fraction(1)), place=Fraction(1), inside=True)]
    found, kept = tightened(values, covers, (Fraction(0), Fraction(2)))
    assert kept == [Cover(low=-math.inf, high=Fraction(2))]
    assert found[0].value == (0, 1)

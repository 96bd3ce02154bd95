"""Every draw lies in its class, draws come close to both bounds, and shrink to simple nonlinearities."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from depth import sampled
from flint import fmpq, fmpq_poly
from hypothesis import Phase, find, given, settings
from hypothesis import strategies as st

from lure import ExpressionNonlinearity, Sector
from lure.analysis.numerics.polynomial import is_hurwitz
from lure.analysis.testing.strategies import (
    known_blocks,
    lurie_blocks,
    monotone_graphs,
    monotone_members,
    sector_graphs,
    sector_members,
)
from lure.errors import InputError
from lure.nonlinearities import GraphNonlinearity, Provenance, check_declared, properties

BOUNDS = st.tuples(st.fractions(-3, 3, max_denominator=7), st.fractions(F(1, 7), 4, max_denominator=7)).map(
    lambda pair: (pair[0], pair[0] + pair[1])
)
SETTINGS = settings(
    derandomize=True,
    database=None,
    deadline=None,
    max_examples=sampled(150, of=2000),
    phases=set(Phase) - {Phase.explain},  # `find` gives the example alone
)


def graph_of(nonlinearity):
    """The exact graph of a nonlinearity, None if it is not piecewise linear."""
    return nonlinearity.graph if isinstance(nonlinearity, GraphNonlinearity | ExpressionNonlinearity) else None


def contains(outer, inner):
    return outer.lower <= inner.lower and inner.upper <= outer.upper


@given(st.data(), BOUNDS)
def test_members_lie_in_their_sector(data, bounds):
    nonlinearity = data.draw(sector_members(*bounds))
    graph = graph_of(nonlinearity)
    if graph is not None:
        assert all(bounds[0] <= chord <= bounds[1] for chord, _ in graph.chords)
    else:
        check_declared(nonlinearity)  # a formula: its word, put to the test
        assert contains(Sector(*bounds), nonlinearity.sector)


@given(st.data(), st.sampled_from([(0, math.inf), (-math.inf, F(1, 3)), (-math.inf, math.inf), (F(-2), math.inf)]))
def test_members_of_half_lines(data, bounds):
    nonlinearity = data.draw(sector_members(*bounds))
    known = properties(nonlinearity)
    assert known.sector.provenance is Provenance.CHECKED
    assert contains(Sector(*bounds), known.sector.value)


@given(st.data(), st.fractions(F(1, 7), 4, max_denominator=7), st.booleans())
def test_monotone_members_have_their_slopes(data, k, odd):
    nonlinearity = data.draw(monotone_members(k, odd=odd))
    graph = graph_of(nonlinearity)
    slopes = graph.slopes if graph is not None else (nonlinearity.slope_bounds.lower, nonlinearity.slope_bounds.upper)
    assert 0 <= min(slopes) <= max(slopes) <= k
    assert nonlinearity.odd or not odd
    if graph is None:
        check_declared(nonlinearity)
    elif odd:
        assert graph.odd
    # and by the values alone
    sigma = np.sort(np.concatenate([-np.logspace(-3, 3, 200), [0.0], np.logspace(-3, 3, 200)]))
    phi = nonlinearity(sigma)
    assert phi[200] == 0
    steps = np.diff(phi)
    assert (steps >= -1e-9).all()
    assert (steps <= float(k) * np.diff(sigma) * (1 + 1e-9) + 1e-12).all()


@given(monotone_members(math.inf))
def test_monotone_members_without_a_bound_on_the_slope(nonlinearity):
    assert properties(nonlinearity).slope_bounds.value.lower >= 0


@given(st.data(), BOUNDS, st.sampled_from([F(1, 10**6), F(1), F(1000)]))
def test_knots_are_of_the_scale_asked_for(data, bounds, scale):
    nonlinearity = data.draw(sector_graphs(*bounds, scale=scale))
    assert all(scale / 10 <= abs(x) <= 40 * scale for x in nonlinearity.breakpoints if x != 0)


@pytest.mark.slow_for("<lambda>2", "<lambda>1")
@pytest.mark.parametrize(
    "reached",
    [
        lambda nonlinearity: (
            graph_of(nonlinearity) is not None and {chord for chord, _ in graph_of(nonlinearity).chords} >= {-1, 2}
        ),
        lambda nonlinearity: (
            graph_of(nonlinearity) is not None
            and min(graph_of(nonlinearity).slopes) < -1
            and max(graph_of(nonlinearity).slopes) > 2
        ),
        lambda nonlinearity: (
            graph_of(nonlinearity) is None and "sin" in str(nonlinearity) and nonlinearity(1.5 * math.pi) < 0.1
        ),
        lambda nonlinearity: (
            graph_of(nonlinearity) is not None and graph_of(nonlinearity).slopes == (F(2), F(2))
        ),  # the bound itself
        lambda nonlinearity: graph_of(nonlinearity) is not None and graph_of(nonlinearity).slopes == (F(-1), F(-1)),
        lambda nonlinearity: not nonlinearity.odd,
        lambda nonlinearity: type(nonlinearity).__name__ in ("Tanh", "ShiftedNonlinearity"),
    ],
)
def test_what_is_worth_drawing_is_drawn(reached):
    assert find(
        sector_members(-1, 2).filter(
            lambda nonlinearity: graph_of(nonlinearity) is None or len(graph_of(nonlinearity).slopes) > 1
        ),
        reached,
        settings=settings(SETTINGS, phases=[Phase.generate]),  # any of them will do
    )


def test_both_bounds_of_the_slope_are_reached():
    nonlinearity = find(
        monotone_members(3),
        lambda nonlinearity: set(getattr(graph_of(nonlinearity), "slopes", ())) >= {0, 3},
        settings=SETTINGS,
    )
    assert len(graph_of(nonlinearity).slopes) <= 4  # a saturation at most


@pytest.mark.slow
def test_the_simplest_laws():
    anything = lambda nonlinearity: True
    assert str(find(sector_members(0, 2), anything, settings=SETTINGS)) == "2*sigma"
    assert str(find(monotone_members(F(1, 2)), anything, settings=SETTINGS)) == "1/2*sigma"
    assert str(find(lurie_blocks(), anything, settings=SETTINGS)) == "1 / (s + 1)"
    # a nonlinearity that bends only on the right: one knot, at 1
    bent = find(
        sector_graphs(0, 2),
        lambda nonlinearity: nonlinearity.exact(F(1)) == 2 and nonlinearity.exact(F(3)) < 2,
        settings=SETTINGS,
    )
    assert len(bent.breakpoints) <= 3


def reversed_over_y(coefficients):
    """``(1 - w)^n d((1 + w)/(1 - w))``: Hurwitz if and only if ``d`` has its roots inside the unit circle."""
    w = fmpq_poly([0, 1])
    n = len(coefficients) - 1
    return sum(
        ((1 + w) ** (n - i) * (1 - w) ** i * fmpq(c.numerator, c.denominator) for i, c in enumerate(coefficients)),
        start=fmpq_poly([0]),
    )


@given(st.data(), st.booleans(), st.booleans(), st.integers(1, 5))
def test_blocks_have_the_poles_they_were_made_from(data, critical, discrete, order):
    known = data.draw(known_blocks(order=order, critical=critical, discrete=discrete))
    block = known.block
    assert block.order == order
    assert block.feedthrough == 0
    assert block.dt == (1 if discrete else None)
    poles = [complex(*map(float, pole)) for pole in known.poles]
    poles += [pole.conjugate() for pole in poles if pole.imag]
    expected = np.poly(poles)
    assert np.allclose(np.array(block.denominator, dtype=float), expected, rtol=1e-9, atol=1e-9)
    rest = list(block.denominator)
    if critical:
        # divide by s (z - 1): exactly, by Horner
        at = 1 if discrete else 0
        quotient = [F(0)]
        for c in rest:
            quotient.append(quotient[-1] * at + c)
        assert quotient.pop() == 0
        rest = quotient[1:]
        numerator, denominator = (
            sum(c * at ** (len(p) - 1 - i) for i, c in enumerate(p)) for p in (block.numerator, rest)
        )
        assert numerator / denominator > 0  # the residue
    if discrete:
        assert is_hurwitz(reversed_over_y(rest))
    else:
        assert is_hurwitz(fmpq_poly([fmpq(c.numerator, c.denominator) for c in reversed(rest)]))


@pytest.mark.slow
@given(
    sector_members(F(-1, 2), 2, memory=True), st.lists(st.fractions(-3, 3, max_denominator=9), min_size=1, max_size=8)
)
def test_a_law_with_memory_stays_in_the_sector(nonlinearity, inputs):
    value = nonlinearity.respond(inputs)
    sigma = inputs[-1]
    assert F(-1, 2) * sigma**2 <= sigma * value <= 2 * sigma**2
    assert contains(Sector(F(-1, 2), 2), nonlinearity.sector)


def test_memory_is_remembered():
    nonlinearity = find(
        sector_members(0, 1, memory=True),
        lambda nonlinearity: nonlinearity.respond([F(0), F(1)]) != nonlinearity.respond([F(2), F(1)]),
        settings=SETTINGS,
    )
    assert nonlinearity.respond([F(0), F(1)]) == nonlinearity.rising.exact(F(1))
    assert nonlinearity.respond([F(2), F(1)]) == nonlinearity.falling.exact(F(1))


@pytest.mark.parametrize(
    "refused",
    [
        lambda: sector_members(2, 1),
        lambda: sector_members(0, "2"),
        lambda: monotone_members(0),
        lambda: monotone_members(-1),
        lambda: sector_graphs(0, 1, scale=0),
        lambda: lurie_blocks(order=0),
        lambda: lurie_blocks(order=(3, 2)),
    ],
)
def test_what_makes_no_sense_is_refused_at_once(refused):
    with pytest.raises(InputError):
        refused()


@given(monotone_graphs(math.inf, odd=True))
def test_odd_graphs_are_odd(nonlinearity):
    assert nonlinearity.graph.odd

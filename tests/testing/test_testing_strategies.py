"""Every draw lies in its class, draws come close to both bounds, and shrink to simple laws."""

import math
from fractions import Fraction as F

import numpy as np
import pytest
from flint import fmpq, fmpq_poly
from hypothesis import find, given, settings
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
SETTINGS = settings(derandomize=True, database=None, deadline=None, max_examples=2000)


def graph_of(law):
    """The exact graph of a law, None if it is not piecewise linear."""
    return law.graph if isinstance(law, GraphNonlinearity | ExpressionNonlinearity) else None


def contains(outer, inner):
    return outer.lower <= inner.lower and inner.upper <= outer.upper


@given(st.data(), BOUNDS)
def test_members_lie_in_their_sector(data, bounds):
    law = data.draw(sector_members(*bounds))
    graph = graph_of(law)
    if graph is not None:
        assert all(bounds[0] <= chord <= bounds[1] for chord, _ in graph.chords)
    else:
        check_declared(law)  # a formula: its word, put to the test
        assert contains(Sector(*bounds), law.sector)


@given(st.data(), st.sampled_from([(0, math.inf), (-math.inf, F(1, 3)), (-math.inf, math.inf), (F(-2), math.inf)]))
def test_members_of_half_lines(data, bounds):
    law = data.draw(sector_members(*bounds))
    known = properties(law)
    assert known.sector.provenance is Provenance.CHECKED
    assert contains(Sector(*bounds), known.sector.value)


@given(st.data(), st.fractions(F(1, 7), 4, max_denominator=7), st.booleans())
def test_monotone_members_have_their_slopes(data, k, odd):
    law = data.draw(monotone_members(k, odd=odd))
    graph = graph_of(law)
    slopes = graph.slopes if graph is not None else (law.slope_bounds.lower, law.slope_bounds.upper)
    assert 0 <= min(slopes) <= max(slopes) <= k
    assert law.odd or not odd
    if graph is None:
        check_declared(law)
    elif odd:
        assert graph.odd
    # and by the values alone
    sigma = np.sort(np.concatenate([-np.logspace(-3, 3, 200), [0.0], np.logspace(-3, 3, 200)]))
    phi = law(sigma)
    assert phi[200] == 0
    steps = np.diff(phi)
    assert (steps >= -1e-9).all()
    assert (steps <= float(k) * np.diff(sigma) * (1 + 1e-9) + 1e-12).all()


@given(monotone_members(math.inf))
def test_monotone_members_without_a_bound_on_the_slope(law):
    assert properties(law).slope_bounds.value.lower >= 0


@given(st.data(), BOUNDS, st.sampled_from([F(1, 10**6), F(1), F(1000)]))
def test_knots_are_of_the_scale_asked_for(data, bounds, scale):
    law = data.draw(sector_graphs(*bounds, scale=scale))
    assert all(scale / 10 <= abs(x) <= 40 * scale for x in law.breakpoints if x != 0)


@pytest.mark.parametrize(
    "reached",
    [
        lambda law: graph_of(law) is not None and {chord for chord, _ in graph_of(law).chords} >= {-1, 2},
        lambda law: graph_of(law) is not None and min(graph_of(law).slopes) < -1 and max(graph_of(law).slopes) > 2,
        lambda law: graph_of(law) is None and "sin" in str(law) and law(1.5 * math.pi) < 0.1,
        lambda law: graph_of(law) is not None and graph_of(law).slopes == (F(2), F(2)),  # the bound itself
        lambda law: graph_of(law) is not None and graph_of(law).slopes == (F(-1), F(-1)),
        lambda law: not law.odd,
        lambda law: type(law).__name__ in ("Tanh", "ShiftedNonlinearity"),
    ],
)
def test_what_is_worth_drawing_is_drawn(reached):
    assert find(
        sector_members(-1, 2).filter(lambda law: graph_of(law) is None or len(graph_of(law).slopes) > 1),
        reached,
        settings=SETTINGS,
    )


def test_both_bounds_of_the_slope_are_reached():
    law = find(monotone_members(3), lambda law: set(getattr(graph_of(law), "slopes", ())) >= {0, 3}, settings=SETTINGS)
    assert len(graph_of(law).slopes) <= 4  # a saturation at most


def test_the_simplest_laws():
    anything = lambda law: True  # noqa: E731
    assert str(find(sector_members(0, 2), anything, settings=SETTINGS)) == "2*sigma"
    assert str(find(monotone_members(F(1, 2)), anything, settings=SETTINGS)) == "1/2*sigma"
    assert str(find(lurie_blocks(), anything, settings=SETTINGS)) == "1 / (s + 1)"
    # a law that bends only on the right: one knot, at 1
    bent = find(sector_graphs(0, 2), lambda law: law.exact(F(1)) == 2 and law.exact(F(3)) < 2, settings=SETTINGS)
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


@given(
    sector_members(F(-1, 2), 2, memory=True), st.lists(st.fractions(-3, 3, max_denominator=9), min_size=1, max_size=8)
)
def test_a_law_with_memory_stays_in_the_sector(law, inputs):
    value = law.respond(inputs)
    sigma = inputs[-1]
    assert F(-1, 2) * sigma**2 <= sigma * value <= 2 * sigma**2
    assert contains(Sector(F(-1, 2), 2), law.sector)


def test_memory_is_remembered():
    law = find(
        sector_members(0, 1, memory=True),
        lambda law: law.respond([F(0), F(1)]) != law.respond([F(2), F(1)]),
        settings=SETTINGS,
    )
    assert law.respond([F(0), F(1)]) == law.rising.exact(F(1))
    assert law.respond([F(2), F(1)]) == law.falling.exact(F(1))


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
def test_odd_graphs_are_odd(law):
    assert law.graph.odd

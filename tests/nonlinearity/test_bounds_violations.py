"""Points at which a nonlinearity leaves its bounds: checked here with exact or high-precision values."""

import math
from fractions import Fraction

import numpy as np
import pytest
from bound_nonlinearities import INF, nonlinearities

from lure.analysis.nonlinearity import nonlinearity_bounds, violation
from lure.analysis.verdict import Evidence
from lure.classes import Sector, SlopeBounds
from lure.expressions import Expression
from lure.nonlinearities import Quantiser, Saturation

CASES = [
    ("tanh(x)", Sector(0, 0.5), math.tanh),
    ("tanh(x)", Sector(0.1, 1), math.tanh),
    ("tanh(x)", SlopeBounds(0, 0.9), math.tanh),
    ("tanh(x)", SlopeBounds(0.1, 2), math.tanh),
    ("sin(x)", Sector(-0.21, 1), math.sin),
    ("sin(x)", SlopeBounds(-0.99, 2), math.sin),
    ("x**3", Sector(0, 100), lambda x: x**3),
    ("exp(x) - 1", Sector(0.01, INF), lambda x: math.expm1(x)),
    ("where(x > 1, 2*x, x)", SlopeBounds(0, 1000), lambda x: 2 * x if x > 1 else x),
    ("where(x > 1, x, 2*x)", SlopeBounds(-1000, 3), lambda x: x if x > 1 else 2 * x),
    ("where(x == 1, 5, x)", Sector(0, 2), lambda x: 5 if x == 1 else x),
    ("x/(1 + x**2)", SlopeBounds(-0.124, 1), lambda x: x / (1 + x * x)),
    (Quantiser(step=1), Sector(0, 1.99), lambda x: math.copysign(math.floor(abs(x) + 0.5), x)),
    (Saturation(gain=2, limit=1), Sector(0.001, 2), lambda x: min(max(2 * x, -1), 1)),
]


@pytest.mark.parametrize(
    ("nonlinearity", "bounds", "value"), CASES, ids=[f"{nonlinearity}, {bounds}" for nonlinearity, bounds, _ in CASES]
)
def test_the_point_violates(nonlinearity, bounds, value):
    found = violation(nonlinearity, bounds)
    assert found.evidence is Evidence.CERTIFIED
    x = [float(point) for point in found.points]
    phi = [float(value(point)) for point in x]
    slope = phi[0] / x[0] if len(x) == 1 else (phi[1] - phi[0]) / (x[1] - x[0])
    assert slope == pytest.approx(float(found.value), rel=1e-6)
    assert slope < bounds.lower or slope > bounds.upper
    assert ("phi(sigma)/sigma" if len(x) == 1 else "difference quotient") in str(found)


def test_points_stay_on_the_interval():
    assert violation("x**3", Sector(0, 2), on=(-1, 1)) is None
    found = violation("x**3", Sector(0, 0.9), on=(-1, 1))
    assert abs(found.points[0]) <= 1
    pair = violation("x**3", SlopeBounds(0, 2.9), on=(-1, 1))
    assert all(abs(x) <= 1 for x in pair.points)


@pytest.mark.slow
def test_every_bound_just_too_narrow_is_refuted_with_a_point():
    share = Fraction(1, 1000)
    for made in nonlinearities(7, piecewise_linear=15, polynomial=15, rational=10):
        expression = Expression.parse(made.text, variables=("x",))
        for bounds, kind in ((made.sector, Sector), (made.slope, SlopeBounds)):
            if bounds is None or bounds[0] == bounds[1]:
                continue
            room = share * (bounds[1] - bounds[0])
            for narrower in ((bounds[0] + room, bounds[1]), (bounds[0], bounds[1] - room)):
                found = violation(made.text, kind(*narrower), on=made.on)
                values = [expression.exact(x=x) for x in found.points]
                rise, run = values[-1] - (values[0] if len(values) == 2 else 0), found.points[-1]
                run -= found.points[0] if len(values) == 2 else 0
                assert rise / run == found.value
                assert not narrower[0] <= found.value <= narrower[1]
            assert violation(made.text, kind(*bounds), on=made.on) is None


def test_a_function_is_refuted_by_what_it_returns():
    found = violation(np.tanh, Sector(0, 0.9))
    assert found.evidence is Evidence.OBSERVED
    x = float(found.points[0])
    assert np.tanh(x) / x > 0.9
    pair = violation(np.tanh, SlopeBounds(0, 0.9))
    x, y = map(float, pair.points)
    assert (np.tanh(y) - np.tanh(x)) / (y - x) > 0.9


def test_what_was_found_before_is_used():
    found = nonlinearity_bounds("tanh(x)")
    assert violation("tanh(x)", Sector(0, 0.5), found=found).to_dict()["bound"] == "1/2"


def test_a_law_derived_from_one_of_the_library_is_known_by_its_values_alone():
    class Tenfold(Saturation):
        def __call__(self, sigma):
            return 10 * super().__call__(sigma)

    found = nonlinearity_bounds(Tenfold())
    assert (found.evidence, float(found.sector_upper.inner)) == (Evidence.OBSERVED, pytest.approx(10))
    assert nonlinearity_bounds(Saturation()).evidence is Evidence.CERTIFIED


def test_only_what_was_shown_is_called_refuted():
    seen = violation(lambda sigma: 2 * sigma, Sector(0, 1))
    shown = violation("2*sigma", Sector(0, 1))
    assert (seen.evidence, shown.evidence) == (Evidence.OBSERVED, Evidence.CERTIFIED)
    assert "REFUTED" not in seen._repr_html_()
    assert "<b>OBSERVED</b>" in seen._repr_html_()
    assert "<b>REFUTED</b>" in shown._repr_html_()

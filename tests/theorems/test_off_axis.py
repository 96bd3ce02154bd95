"""The off-axis circle criterion: published plants, sharp limits, refusals, symmetries."""

import math
from fractions import Fraction

import numpy as np
import pytest
from plants import CONTINUOUS, block

from lure import Sector
from lure.analysis.theorems.off_axis import off_axis_criterion, off_axis_largest
from lure.analysis.theorems.park import park_largest
from lure.analysis.theorems.popov import popov_criterion
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import SlopeBounds
from lure.errors import AssumptionError, InputError


# 1/(s+1)^3 meets the negative real axis at -1/8 for omega = sqrt 3; the tangent there has the line's direction, and
# alpha = dRe/dIm = sqrt 3: arg of dH/domega = -3i/(1+i sqrt 3)^4 is -pi/2 - 4 pi/3 = pi/6 (mod 2 pi)
def test_the_best_line_for_three_equal_poles_is_the_tangent_at_the_crossing():
    answer = off_axis_largest(block([1], [1, 3, 3, 1]))
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert answer.largest.low < 8 <= answer.largest.high
    assert answer.largest.width < 1e-9
    assert float(Fraction(answer.parameters["alpha"])) == pytest.approx(math.sqrt(3), rel=1e-4)
    assert answer.worst_frequency == pytest.approx(math.sqrt(3), rel=1e-6)


# theta = 0 and alpha = 0 are the same inequality: 1/(s^2+s+1) reaches 3 there
@pytest.mark.parametrize(("k", "proved"), [(Fraction("2.999999"), True), (3, False), (Fraction("3.000001"), False)])
def test_a_vertical_line_is_the_circle_criterion(k, proved):
    plant = block([1], [1, 1, 1])
    answer = off_axis_criterion(plant, SlopeBounds(0, k), alpha=Fraction(0))
    circle = popov_criterion(plant, Sector(0, k), theta=0)
    assert (answer.verdict is Verdict.PROVED) == proved
    assert answer.margin.middle == pytest.approx(circle.margin.middle, abs=1e-9)
    assert answer.worst_frequency == pytest.approx(math.sqrt(2), rel=1e-5)


@pytest.mark.parametrize(
    ("example", "expected"),
    [
        (1, 3.980051058),
        (3, 0.5491287411),
        (4, 0.5091305008),
        (5, 0.00120021),
        (6, 0.00119979),
        (7, 22.97031038),
    ],
)
def test_published_plants_are_bracketed_and_sampled(example, expected):
    plant = CONTINUOUS[example]
    answer = off_axis_largest(plant)
    assert answer.largest.low == pytest.approx(expected, rel=1e-8)
    assert answer.largest.width <= 1e-9 * expected
    alpha, k = float(Fraction(answer.parameters["alpha"])), answer.largest.low
    w = np.concatenate([np.geomspace(1e-5, 1e5, 20001), answer.worst_frequency * (1 + np.linspace(-1e-3, 1e-3, 2001))])
    values = ((1 + 1j * alpha) * (plant.transfer(1j * w) + 1 / k)).real
    assert np.min(values) > -1e-9 / k
    assert off_axis_criterion(plant, SlopeBounds(0, k)).verdict is Verdict.PROVED
    assert off_axis_criterion(plant, SlopeBounds(0, answer.largest.high)).verdict is Verdict.INCONCLUSIVE


def test_where_every_finite_k_is_in_reach_each_is_proved():
    for plant in (block([1], [1, 1]), block([1], [1, 1, 1]), block([1, 3], [1, 3, 3, 1])):
        assert off_axis_largest(plant).largest.low == math.inf
        assert off_axis_criterion(plant, SlopeBounds(0, 1e9)).verdict is Verdict.PROVED


@pytest.mark.parametrize(
    ("plant", "match"),
    [
        (block([-1], [1, 1, 0]), "residue"),
        (block([1], [1, 0], 1), "continuous time"),
        (block([1], [1, -1]), "right"),
    ],
)
def test_a_block_outside_the_theorem_is_refused(plant, match):
    for largest in (off_axis_largest, park_largest):
        with pytest.raises(AssumptionError, match=match):
            largest(plant)


def test_bounds_and_lines_that_are_not_finite_are_refused():
    with pytest.raises(AssumptionError, match="finite slope bounds"):
        off_axis_criterion(block([1], [1, 1]), SlopeBounds(0, math.inf))
    with pytest.raises(InputError, match="finite number"):
        off_axis_criterion(block([1], [1, 1]), SlopeBounds(0, 1), alpha=math.nan)

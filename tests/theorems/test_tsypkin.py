"""Tsypkin's criterion and that of Jury and Lee: published numbers, sharp from both sides, refusals."""

import math
from fractions import Fraction

import numpy as np
import pytest
from plants import CIRCLE, DISCRETE, discrete

from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.theorems.differences import (
    JURY_LEE,
    TSYPKIN,
    jury_lee_largest,
    tsypkin_largest,
)
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant

OMEGA = np.linspace(0, math.pi, 100_001)
Z = np.exp(1j * OMEGA)


def tsypkin_side(H, k, q):
    return 1 / k + ((1 + q * (1 - 1 / Z)) * H).real


def jury_lee_side(H, k, q):
    return 1 / k + ((1 + q * (Z - 1)) * H).real - q * k / 2 * np.abs((Z - 1) * H) ** 2


@pytest.mark.parametrize(("example", "published"), [(1, 3.8000), (2, 0.2427), (3, 0.1379), (5, 1.0273), (6, 0.6510)])
def test_the_published_values_of_tsypkins_criterion(example, published):
    answer = tsypkin_largest(DISCRETE[example])
    assert answer.largest.low == pytest.approx(published, abs=5.1e-5)
    assert answer.largest.high - answer.largest.low < 1e-9 * answer.largest.high
    assert answer.verdict is Verdict.PROVED
    assert answer.evidence is Evidence.CERTIFIED
    assert answer.nonlinearity_class.slope.upper == math.inf


@pytest.mark.parametrize("example", DISCRETE)
@pytest.mark.parametrize(("largest", "side"), [(tsypkin_largest, tsypkin_side), (jury_lee_largest, jury_lee_side)])
def test_the_inequality_holds_on_a_dense_sample_and_no_weight_does_better(example, largest, side):
    plant = DISCRETE[example]
    answer = largest(plant)
    H = plant.transfer(Z)
    k, q = answer.largest.low, float(Fraction(answer.parameters["q"]))
    assert side(H, k, q).min() > -1e-9
    assert answer.largest.low < answer.largest.high <= hurwitz_limit(plant).high
    assert answer.largest.low >= CIRCLE[example] - 5e-5
    for other in (0.0, *np.logspace(-4, 6, 41)):
        assert side(H, 1.0001 * answer.largest.high, other).min() < 0


def test_jury_lee_beats_the_circle_criterion_where_published_examples_let_it():
    assert jury_lee_largest(DISCRETE[1]).largest.low > 3.79
    assert jury_lee_largest(DISCRETE[6]).largest.low > 0.684
    assert jury_lee_largest(DISCRETE[6]).nonlinearity_class.slope.lower == -math.inf


@pytest.mark.parametrize("criterion", [TSYPKIN, JURY_LEE], ids=["tsypkin", "jury-lee"])
def test_neither_end_moves_without_notice(criterion):
    inequality = criterion.inequality(DISCRETE[2], Fraction(0))
    best = inequality.best()
    q, k = best.multiplier["q"], Fraction(best.largest.low)
    assert inequality.decide({"q": q}, k)
    assert not inequality.decide({"q": q}, k * (1 + Fraction(1, 10**6)))
    assert not inequality.decide({"q": 2 * q}, k)
    assert inequality.decide({"q": Fraction(0)}, k / 100)
    assert not inequality.decide({"q": Fraction(-1, 100)}, k / 100)  # the inequality holds, the theorem does not
    assert inequality.least({"q": Fraction(-1, 100)}, k / 100)[0].low > 0


@pytest.mark.parametrize("criterion", [TSYPKIN, JURY_LEE], ids=["tsypkin", "jury-lee"])
def test_one_class(criterion):
    reach = criterion.largest(DISCRETE[1]).largest.low
    beyond = criterion.decide(DISCRETE[1], SlopeBounds(0, 1.001 * reach))
    assert beyond.verdict is Verdict.INCONCLUSIVE
    assert beyond.margin.high < 0
    with pytest.raises(AssumptionError, match="finite slope bounds"):
        criterion.decide(DISCRETE[1], SlopeBounds(0, math.inf))


@pytest.mark.parametrize("largest", [tsypkin_largest, jury_lee_largest])
def test_refusals(largest):
    with pytest.raises(AssumptionError, match="residue"):
        largest(discrete([-1], [1, -1]))
    with pytest.raises(InputError, match="dt is None"):
        largest(RationalPlant([1], [1, 1]))


def test_the_algebraic_loop_decides_which_slopes_are_covered():
    # sigma + D phi(sigma) = r: steep slopes are harmless for D > 0, negative ones for D < 0
    positive, negative = discrete([1, "-.2"], [1, "-.9"]), discrete([-1, "-.2"], [1, "-.9"])
    assert tsypkin_largest(positive).nonlinearity_class.slope.upper == math.inf
    assert jury_lee_largest(positive).nonlinearity_class.slope.lower == 0
    bounded = tsypkin_largest(negative)
    assert bounded.nonlinearity_class.slope.upper == bounded.largest.low < 1
    assert jury_lee_largest(negative).nonlinearity_class.slope.lower == -math.inf


@pytest.mark.parametrize("largest", [tsypkin_largest, jury_lee_largest])
def test_a_positive_real_block_admits_every_sector(largest):
    assert largest(discrete([2, 0], [2, -1])).largest.low == math.inf
    assert 1 - 1e-9 < largest(discrete([1], [1, 0])).largest.low < 1

"""Criteria on samples: a bound on what they can reach, and never a proof."""

import math

import numpy as np
import pytest

from lure import AssumptionError
from lure.analysis.theorems.other_plants import largest
from lure.analysis.verdict import Evidence, Verdict
from lure.plants.frequency_data import FrequencyData

OMEGA = np.geomspace(1e-2, 1e2, 4001)


def data(H):
    return FrequencyData(OMEGA, H(1j * OMEGA))


def test_samples_bound_the_reach_from_above_and_prove_nothing():
    # 1/(s + 1)^3: min Re H = -1/4 at w = sqrt 3... circle 4, Popov 8 with theta = 1
    H = data(lambda s: 1 / (s + 1) ** 3)
    for name, exact in (("circle", 4), ("popov", 8)):
        found = largest(H, name)
        assert (found.verdict, found.evidence) == (Verdict.INCONCLUSIVE, Evidence.OBSERVED)
        assert found.largest.low == 0
        assert exact <= found.largest.high < exact * (1 + 1e-4)
    assert found.theta == pytest.approx(1, abs=1e-2)


def test_a_passive_measurement_bounds_nothing():
    assert largest(data(lambda s: 1 / (s + 1)), "circle").largest.high == math.inf


def test_no_other_criterion_is_evaluated_on_samples():
    with pytest.raises(AssumptionError, match="ask circle"):
        largest(data(lambda s: 1 / (s + 1)), "park")


@pytest.mark.parametrize("name", ["circle", "popov"])
def test_a_sample_at_a_pole_is_named(name):
    samples = FrequencyData(np.array([0.5, 1.0, 2.0]), np.array([1, math.inf, 0.1 - 1j]))
    with pytest.raises(AssumptionError, match="not finite at 1 rad/s, a pole on the axis; leave it out"):
        largest(samples, name)

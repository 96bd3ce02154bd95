"""Decay rates for every plant of a box, of one channel and of several: formulas, changed certificates, members."""

import math
from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from tampering import assert_both_reject, edited
from test_channel_rates import ending, popov_serves_slopes

from lure import NonlinearityClass, Sector, SlopeBounds
from lure.analysis.certificates.second import recheck
from lure.analysis.questions.decay import decay_rate
from lure.analysis.verdict import Verdict
from lure.plants.channel_family import ChannelFamily
from lure.plants.family import PlantFamily

F = Fraction


@pytest.fixture(scope="module")
def pair():
    """``x' = -a x - phi_1``, ``y' = -b y - phi_2``, a in [1, 2], b in [2, 3]: the rate is 1, of a = 1, phi_1 = 0."""
    sides = [["-a", 0], [0, "-b"]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], None
    family = ChannelFamily.of_matrices(*sides, {"a": (1, 2), "b": (2, 3)})
    return decay_rate(family, [Sector(0, 1)] * 2)


@pytest.fixture(scope="module")
def friction():
    """A mass with friction d in [4/5, 1], slopes from 1 to 29."""
    return decay_rate(PlantFamily.of_formula("1/(s*(s + d))", {"d": (0.8, 1)}), SlopeBounds(1, 29))


def test_two_channels_have_the_rate_of_the_slowest_plant(pair):
    assert pair.verdict is Verdict.PROVED
    assert 0.999 < pair.rate.low <= 1.0 <= pair.rate.high < 1 + 1e-9
    assert "a = 1" in pair.witness
    assert "; phi_2, time-invariant, in the sector [0, 1] and every a in [1, 2], b in [2, 3] (" in str(pair)
    assert pair.plot().lines  # of the plant in the middle
    for shown in (pair.proof, pair.refutation):
        assert recheck(dict(shown.certificate)).accepted


@pytest.mark.slow
def test_popovs_terms_serve_a_box_as_far_as_its_worst_plant(friction):
    truth = ending(lambda a: popov_serves_slopes(0.8, a), 1e-3, 0.4)  # d = 4/5
    assert friction.criterion == "diagonal-popov"
    assert truth * (1 - 2e-3) < friction.rate.low < truth
    assert recheck(dict(friction.proof.certificate)).accepted


def test_in_discrete_time_the_factor_is_that_of_the_worst_plant():
    # x+ = a x - phi, phi = g x: |a - g| <= max(a, 1/10 - a) = 9/10
    family = ChannelFamily.of_matrices(
        [["a", 0], [0, "a/2"]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], None, {"a": (0.5, 0.9)}, 1
    )
    found = decay_rate(family, [Sector(0, F(1, 10))] * 2)
    assert found.rate.high == pytest.approx(0.9, rel=3e-4)
    assert found.rate.low <= 0.9 <= found.rate.high
    assert recheck(dict(found.proof.certificate)).accepted


def leaf(certificate):
    """The path to the multiplier of the first box."""
    path = ["proof", "boxes"]
    part = certificate["proof"]["boxes"]
    while "multiplier" not in part:
        path, part = [*path, "below"], part["below"]
    return [*path, "multiplier"]


def test_changed_certificates_are_rejected_by_both(pair, friction):
    own, other = friction.proof.certificate, pair.proof.certificate
    path = leaf(own)
    for wrong in (
        edited(own, "rate", value=lambda text: str(F(text) * F(21, 20))),
        edited(other, "rate", value="1001/1000"),
        edited(own, *path, "theta", 0, value=lambda text: str(F(text) * 2)),
        edited(own, *path, "theta", 0, value=lambda text: str(F(text) / 2)),
        edited(own, "system", "parameters", 0, value=["d", "3/4", "1"]),
        edited(own, "laws", "channels", value=lambda each: [one | {"slope": None} for one in each]),
        edited(own, "laws", "channels", value=lambda each: [one | {"time_varying": True} for one in each]),
        {key: value for key, value in pair.refutation.certificate.items() if key != "rate"},
        edited(pair.refutation.certificate, "rate", value="999/1000"),
        edited(pair.refutation.certificate, "proof", "at", 0, value="1/2"),
    ):
        assert_both_reject(wrong)


def test_a_plant_that_does_not_decay_is_named():
    family = ChannelFamily.of_matrices([["a", 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], None, {"a": (-1, 0)})
    found = decay_rate(family, [Sector(0, 1)] * 2)
    assert found.verdict is Verdict.REFUTED
    assert "at a = 0" in found.witness


# x' = A(p) x - B g C x for random p and constant gains g: real parts against what is proved
def test_random_members_of_random_boxes_decay_at_the_rate_that_is_proved():
    random, loops, members = np.random.default_rng(5), sampled(1, of=400), 2000
    for _ in range(loops):
        A, B, C = (np.round(random.normal(size=shape), 1) for shape in ((2, 2), (2, 2), (2, 2)))
        A = A - round(float(np.linalg.eigvals(A).real.max()) + 1, 1) * np.eye(2)
        rows = [[f"({A[i, j]:.1f}) + ({A[i, 0]:.1f})*p/4 + q*{int(i == j)}/8" for j in range(2)] for i in range(2)]
        exact = [[[str(v) for v in row] for row in side.tolist()] for side in (B, C)]
        family = ChannelFamily.of_matrices(rows, *exact, None, {"p": (-1, 1), "q": (-1, 1)})
        found = decay_rate(family, [NonlinearityClass(sector=Sector(0, F(1, 4)))] * 2)
        p, q = random.choice([-1.0, 1.0], (2, members)) * random.random((2, members)) ** 0.2
        gains = random.choice([0.0, 0.25], (members, 2)) * random.random((members, 2)) ** 0.2
        whole = A + p[:, None, None] / 4 * A[:, :1] + q[:, None, None] / 8 * np.eye(2)
        slowest = np.linalg.eigvals(whole - B @ (gains[:, :, None] * C)).real.max()
        assert found.rate.low <= -slowest + 1e-9
        assert found.rate.high >= found.rate.low
        assert math.isfinite(found.rate.high)

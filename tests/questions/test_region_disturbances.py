"""How large a disturbance a loop survives: sharp for one state, checked twice, tampered with, and attacked."""

from fractions import Fraction

import numpy as np
import pytest
from depth import rarely
from tampering import assert_both_reject, edited

from lure import InputError, Saturation, as_plant
from lure.analysis import region
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.files import parse_system
from lure.nonlinearities.base import LocalSector

# x'' = x'/2 - x - sat(x + 2 x') + w
HELD = as_plant(([[0, 1], [-1, "0.5"]], [0, 1], [1, 2], 0))


@pytest.fixture(scope="module")
def held():
    return region(HELD, Saturation(), disturbance=[[0], [1]])


@pytest.mark.slow
def test_the_energy_of_one_state_is_sharp():
    # x' = -x - phi + w with 0 <= phi/x known for |x| <= 1 alone: with phi = 0 the least energy that brings x from 0 to
    # 1 is 2, by w = 2 x along x' = x, and V = x^2 shows that less does not
    found = region(as_plant(([[-1]], [1], [1], 0)), LocalSector(0, 1, radius=1), disturbance=[[1]])
    assert 2 * (1 - 1e-5) < found.reachable.energy < 2
    # x+ = x/2 - phi + w: x(t) = sum 2^-k w_(t-k), at most sqrt(4/3 energy), so 3/4
    found = region(as_plant(([["1/2"]], [1], [1], 0), dt=1), LocalSector(0, "1/2", radius=1), disturbance=[[1]])
    assert 0.75 * (1 - 1e-5) < found.reachable.energy < 0.75


@pytest.mark.slow
def test_both_checkers_accept_it_and_no_more(held):
    certificate = held.reachable.proof.certificate
    assert check(certificate).claim.startswith(recheck(certificate).reason)
    assert "returns to 0 (certified)" in str(held)
    for path, value in (
        (("proof", "energy"), lambda energy: str(Fraction(energy) * Fraction(1001, 1000))),
        (("proof", "energy"), "0"),
        (("proof", "energy"), "-1"),
        (("proof", "Bw"), [["0"], ["2"]]),
        (("proof", "Bw"), [["0", "1"]]),
        (("proof", "Bw"), []),
        (("proof", "P"), lambda P: [[str(Fraction(v) * 2) for v in row] for row in P]),
        (("multiplier", "terms", 0, "weight"), "0"),
        (("theorem",), "local-popov"),
    ):
        assert_both_reject(edited(certificate, *path, value=value))
    without = edited(certificate, "proof", value=lambda proof: {key: proof[key] for key in ("method", "P", "Bw")})
    assert_both_reject(without)
    stays = edited(certificate, "conclusion", value=lambda text: text.replace("energy at most", "any energy, such as"))
    assert_both_reject(stays, stored=True)


@pytest.mark.slow
@pytest.mark.parametrize("push", rarely([1.5, 2.0, 3.0, 30.0], 2.0, 3.0))
def test_no_disturbance_of_that_energy_leaves_the_ellipsoid(held, push):
    # w along B'Px pushes V up the fastest, from a small start; when its energy is spent the state returns
    P = np.array(held.reachable.P, dtype=float)
    left, x, step, most = held.reachable.energy, np.array([0.0, 0.0]), 1e-3, 0.0
    for k in range(40000):
        w = push * (x @ P[:, 1] + (1e-3 if k < 10 else 0.0))
        w = w if left > 0 else 0.0
        left -= w * w * step
        x = x + step * np.array([x[1], x[1] / 2 - x[0] - np.clip(x[0] + 2 * x[1], -1, 1) + w])
        most = max(most, x @ P @ x)
    assert 0.05 < most < 1
    assert np.linalg.norm(x) < 0.2


def test_the_performance_of_a_file_is_what_w_moves():
    text = """
[plant]
A = [[1]]
B = [[1]]
C = [[2]]
[nonlinearity]
kind = "saturation"
gain = 1
limit = 1
[performance]
Bw = [[1]]
Cz = [[1]]
"""
    found = region(parse_system(text, name="held", source="a text"))
    assert found.reachable.Bw == ((1,),)
    assert found.to_dict()["reachable"]["energy"] > 0.49
    seen = region(parse_system(text + "Dsigmaw = [[1]]\n", name="held", source="a text"))
    assert (
        0 < seen.reachable.energy < found.reachable.energy
    )  # w = -x/5 would do more against x' = -x + w than for sigma
    assert seen.reachable.Dsigmaw == ((1,),)


# A plant x' = x - sat(3 (x - w) + 2 q) with an integrator of the error, q' = x - w, and a reference w
TRACKING = """
[plant]
A = [[1, 0], [1, 0]]
B = [[1], [0]]
C = [[3, 2]]
[nonlinearity]
kind = "saturation"
gain = 1
limit = 1
[performance]
Bw = [[0], [-1]]
Dsigmaw = [[-3]]
Cz = [[1, 0]]
"""


@pytest.fixture(scope="module")
def tracking():
    return region(parse_system(TRACKING, name="tracking", source="a text")).reachable


@pytest.mark.slow
def test_a_reference_that_enters_sigma_is_survived_up_to_an_energy(tracking):
    certificate = dict(tracking.proof.certificate)
    assert check(certificate).claim.startswith(recheck(certificate).reason)
    assert "sigma = C x + D mu + Dsigmaw w" in certificate["conclusion"]
    for path, value in (
        (("proof", "energy"), lambda energy: str(Fraction(energy) * Fraction(1001, 1000))),
        (("proof", "Dsigmaw"), [["-31/10"]]),
        (("proof", "Dsigmaw"), [["-3", "0"]]),
        (("proof", "Dsigmaw"), []),
        (("proof", "Bw"), [["0"], ["-11/10"]]),
    ):
        assert_both_reject(edited(certificate, *path, value=value))
    without = edited(certificate, "proof", value=lambda proof: {key: proof[key] for key in proof if key != "Dsigmaw"})
    assert_both_reject(without)


@pytest.mark.slow
def test_no_reference_of_that_energy_leaves_the_ellipsoid(tracking):
    rng, step, count = np.random.default_rng(0), 2e-3, 200
    P, x = np.array(tracking.P, dtype=float), np.zeros((count, 2))
    push, omega = rng.uniform(-5, 5, count), rng.uniform(0, 4, count)
    left, most = np.full(count, tracking.energy), np.zeros(count)
    for k in range(2500):
        g, inside = x @ P, np.abs(x @ [3, 2]) < 1
        w = push * (3 * g[:, 0] * inside - g[:, 1]) + np.sin(omega * k * step) * (np.arange(count) % 2)
        w = np.where(left > 0, w + 0.02 * (k < 5), 0.0)
        left -= w**2 * step
        rate = np.column_stack([x[:, 0] - np.clip(x @ [3, 2] - 3 * w, -1, 1), x[:, 0] - w])
        x = x + step * rate
        most = np.maximum(most, np.einsum("ki,ij,kj->k", x, P, x))
    assert 0.3 < most.max() < 1


@pytest.mark.slow
def test_w_moves_no_sigma_that_is_known_on_an_interval_alone():
    text = TRACKING.replace('kind = "saturation"\ngain = 1\nlimit = 1', 'kind = "tanh"')
    found = region(parse_system(text, name="tracking", source="a text"))
    assert found.reachable is None
    assert "W moves sigma of channel 1 beyond every interval" in str(found)


@pytest.mark.parametrize("given", [[[1]], [[1], [1, 2]], [[], []], [["a"], [1]]])
def test_a_disturbance_that_is_none_is_refused(given):
    with pytest.raises(InputError, match="disturbance"):
        region(HELD, Saturation(), disturbance=given)

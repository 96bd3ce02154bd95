"""The energy of z after a push and its peak under a disturbance of bounded energy, against exact values."""

import json
from fractions import Fraction as F

import numpy as np
import pytest

from lure import InputError, NonlinearityClass, Sector, as_plant
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions import energy
from lure.analysis.questions.energy import energy_bounds
from lure.files import parse_system

LAG, SEEN = ([[-1]], [[1]], [[1]], [[0]]), {"Bw": [[1]], "Cz": [[1]]}
OSCILLATOR = (([[F(-1, 5), -1], [1, 0]], [[1], [0]], [[1, 1]], 0), [Sector(0, 1)], {"Bw": [[1], [0]], "Cz": [[1, 1]]})


# the slowest member decides, and it is linear: x' = -a x + w has int x^2 = x(0)^2/(2 a) and, with w = e^(a t) until t,
# x(t)^2 = int w^2/(2 a); x+ = a x + w has 1/(1 - a^2) for both
@pytest.mark.parametrize(
    ("plant", "given", "truth"),
    [
        (LAG, Sector(0, 1), 1 / 2),
        (LAG, Sector(F(-1, 2), 1), 1),
        (LAG, NonlinearityClass.norm_bounded(F(1, 2)), 1),
        (as_plant(([[0]], [[1]], [[1]], [[0]]), dt=1), Sector(F(-1, 2), F(1, 4)), 4 / 3),
    ],
)
def test_one_state_has_the_constants_of_its_slowest_member(plant, given, truth):
    found = energy_bounds(plant, [given], SEEN)
    assert truth < found.initial < truth * (1 + 1e-5)
    assert truth < found.peak < truth * (1 + 1e-5)
    assert all(recheck(json.loads(json.dumps(one.certificate))).accepted for one in found.proofs)


def test_units_of_the_disturbance_and_the_output_go_into_the_constants():
    found = energy_bounds(LAG, [Sector(0, 1)], {"Bw": [[F(1, 1000)]], "Cz": [[20]]})
    assert found.initial == pytest.approx(200, rel=1e-5)  # 20^2/2
    assert found.peak == pytest.approx(2e-4, rel=1e-5)


def test_what_is_assumed_of_the_nonlinearity_is_said():
    direct = ([[-2]], [[1]], [[1]], [[F(-1, 2)]])  # sigma - phi(sigma)/2 = y
    found = energy_bounds(direct, [Sector(0, 1)], SEEN)
    assert found.assumed == "for which " + found.proofs[0].assumed == "for which " + found.proofs[1].assumed
    assert str(found).startswith(f"For phi, time-varying, in the sector [0, 1], {found.assumed}: without disturbance")
    found = energy_bounds(LAG, [Sector(0, 1)], {**SEEN, "Dzw": 1})
    assert found.assumed == ""
    assert " |x(0)|^2 (certified) (z has" in str(found)


def test_a_direct_term_has_no_peak():
    found = energy_bounds(LAG, [Sector(0, 1)], {**SEEN, "Dzw": 1})
    assert found.initial == pytest.approx(0.5, rel=1e-4)
    assert found.to_dict()["peak"] == "inf"
    assert "a direct term" in found.reason


@pytest.mark.slow
def test_no_solution_of_an_oscillator_with_jumping_gains_does_more():
    found, step = energy_bounds(*OSCILLATOR), 0.02
    rng = np.random.default_rng(3)
    A = np.array([[-0.2, -1], [1, 0]])
    x, energy = rng.normal(size=(400, 2)), np.zeros(400)
    start, gains = (x**2).sum(1), np.zeros(400)
    for t in range(3000):
        if t % 25 == 0:  # sometimes the gain that pushes, sometimes any
            sigma, fast = x.sum(1), x[:, 0]
            gains = np.where(rng.random(400) < 0.8, (sigma * fast < 0) * 1.0, rng.random(400))
        for _ in range(2):
            mu = -gains * x.sum(1)
            x = x + step / 2 * (x @ A.T + np.outer(mu, [1, 0]))
            energy += step / 2 * x.sum(1) ** 2
    assert 3 < (energy / start).max() < found.initial


def test_what_is_not_covered_is_refused_or_left_open():
    found = energy_bounds(([[0]], [[1]], [[1]], [[0]]), [Sector(0, 1)], {"Bw": [[1]], "Dzmu": [[1]]})
    assert found.to_dict()["initial"] == "inf"
    assert "the circle criterion shows no gain" in str(found)
    with pytest.raises(InputError, match="w and z, which are not given"):
        energy_bounds(LAG, [Sector(0, 1)])
    box = '[plant]\nA = [["-a"]]\nB = [[1]]\nC = [[1]]\n[plant.parameters]\na = [1, 2]\n[class]\nsector = [0, 1]\n'
    with pytest.raises(InputError, match="not bounded beside parameters"):
        energy_bounds(parse_system(box + "[performance]\nBw = [[1]]\nCz = [[1]]\n", name="box", source="here"))


@pytest.mark.slow
def test_the_command_says_both(lure, tmp_path):
    text = (
        "[plant]\nA = [[-1]]\nB = [[1]]\nC = [[1]]\n[class]\nsector = [0, 1]\n[performance]\nBw = [[1]]\nCz = [[1]]\n"
    )
    (tmp_path / "loop.toml").write_text(text)
    status, out, _ = lure("gain", str(tmp_path / "loop.toml"), "--energy", "--json")
    assert status == 0
    assert json.loads(out)["energy"]["initial"] == pytest.approx(0.5, rel=1e-5)


def test_a_margin_that_shows_nothing_is_followed_by_a_larger_one(monkeypatch):
    asked, bounded = [], energy._bounded

    def only_at_the_last(*given, peak):
        asked.append((given[-1], peak))
        return bounded(*given, peak=peak) if given[-1] == energy._MARGINS[-1] else None

    monkeypatch.setattr(energy, "_bounded", only_at_the_last)
    found = energy_bounds(LAG, [Sector(0, 1)], SEEN)
    assert asked == [(margin, peak) for peak in (False, True) for margin in energy._MARGINS]
    assert 0.5 < found.initial < 0.51  # above that of the test before, whose margin is smaller
    assert found.reason == ""
    monkeypatch.setattr(energy, "_bounded", lambda *_given, peak: None)
    assert energy_bounds(LAG, [Sector(0, 1)], SEEN).reason == "no quadratic function was found"

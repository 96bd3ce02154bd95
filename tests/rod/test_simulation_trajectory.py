"""What a trajectory of the scheme reports, what contradicts the theory, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from simulated import FLYING, rod

from lure import InputError
from lure.analysis.rod.energy import deflated_coordinate
from lure.analysis.rod.simulation import contradictions, simulate
from lure.rod import Scenario, initial_state, upwind


def test_frames_carry_both_waves_and_the_boundary_conditions():
    its = rod()
    scenario = Scenario.parse(displacement="0.1*cos(x)", velocity="0.3", force="0.2*t")
    run = simulate(upwind(its, 6), scenario, until=4.0, frames=9, samples=30)
    assert run.frames_r1.shape == run.frames_r2.shape == run.frames_v.shape == (9, 7)
    assert run.frames_t == pytest.approx(np.linspace(0, 4, 9))
    assert run.frames_x == pytest.approx(np.linspace(0, 3, 7))
    r1, r2 = scenario.waves(its, run.frames_x)
    assert run.frames_r1[0, 1:] == pytest.approx(r1[1:])
    assert run.frames_r2[0, :-1] == pytest.approx(r2[:-1])
    sent = -its.reflection * run.frames_r2[:, 0] + 2 * its.input_gain * 0.2 * run.frames_t
    assert run.frames_r1[:, 0] == pytest.approx(sent)
    assert run.frames_v == pytest.approx((run.frames_r1 + run.frames_r2) / 2)
    assert simulate(upwind(its, 6), scenario, until=4.0).frames_r1.size == 0


def test_a_trajectory_is_read_only_and_says_what_it_is():
    run = simulate(upwind(rod(), 4), FLYING, until=6.0, samples=11)
    assert run.t.size == 11
    assert run.u_end == pytest.approx(run.z + 0.2)
    assert run.p == pytest.approx(np.maximum(run.z, 0) / 0.1)
    assert run.zeta[0] == pytest.approx(
        float(deflated_coordinate(upwind(rod(), 4), initial_state(upwind(rod(), 4), FLYING)))
    )
    with pytest.raises(ValueError, match="read-only"):
        run.z[0] = 1.0
    assert str(run).startswith("scheme of 4 cells up to 6 s: 1 contact, largest z = 0.0")
    assert "No contact or release is missed" in run.method


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"energy_increase": 1e-6}, "the energy rises by 1e-06 J between two samples"),
        ({"zeta_increase": 1e-6}, "the deflated coordinate zeta rises by 1e-06 m"),
        ({"lyapunov_increase": 1e-6}, "the Popov-Lyapunov function rises by 1e-06 Pa s"),
        ({"energy_increase": np.nan}, "the energy rises by nan J"),
        ({"energy_residual": 1e-3}, "the energy identity is off by 0.001 of the energies"),
        ({"energy_residual": np.nan}, "the energy identity is off by nan"),
        ({"z": np.array([0.0, 1e9])}, "|z| reaches 1e+09 m, above the bound"),
        ({"rest_position": 0.1, "rest_is_final": True}, "the rod comes to rest at z = 0.1 m, inside the obstacle"),
        ({"ended_early": "it stopped"}, "the run ended early, though the motion is bounded: it stopped"),
    ],
)
def test_each_contradiction_has_its_sentence(change, sentence):
    run = simulate(upwind(rod(), 4), FLYING, until=6.0, samples=101)
    assert contradictions(run) == ()
    (found,) = contradictions(replace(run, **change))
    assert sentence in found


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"until": 0.0}, "simulation.until is 0.0; give a positive number of seconds"),
        ({"until": np.inf}, "simulation.until is inf"),
        ({"until": True}, "simulation.until is True"),
        ({"until": "1"}, "simulation.until is '1'"),
        ({"samples": 1}, "simulation.samples is 1; give a whole number from 2"),
        ({"frames": 1}, "simulation.frames is 1; give a whole number from 2"),
        ({"tolerance": 0.0}, "simulation.tolerance is 0.0; give a number from 1e-12 to 1e-3"),
        ({"until": 1e8}, r"simulation.until is 1e\+08 s: .* 2.1e\+09 cell .* at most 9.38e\+06 s, or at most 1 cells"),
        ({"samples": 10**7}, "simulation.samples is 10000000; with 4 cells give at most"),
    ],
)
def test_a_request_that_cannot_be_met_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        simulate(upwind(rod(), 4), FLYING, **{"until": 1.0, **change})


def test_too_many_cells_too_stiff_a_contact_and_undefined_data_are_refused():
    with pytest.raises(InputError, match=r"simulation.cells is 1001; give at most 1000"):
        simulate(upwind(rod(), 1001), FLYING, until=1.0)
    with pytest.raises(InputError, match=r"rod.compliance is 1e-20: .* give a larger compliance"):
        simulate(upwind(rod(compliance=1e-20), 4), FLYING, until=1.0)
    with pytest.raises(InputError, match=r"initial.u1 is inf at x = 3 m"):
        simulate(upwind(rod(), 4), Scenario.parse(velocity="1/(x - 3)"), until=1.0)
    with pytest.raises(InputError, match=r"force.g has no finite value at t = 0\.\d+ s"):
        simulate(upwind(rod(), 4), Scenario.parse(force="log(0.5 - t)"), until=1.0)

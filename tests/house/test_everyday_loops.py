"""A sample of the campaign over everyday loops: commands, checkers, simulation and Python objects agree."""

import importlib.util
from pathlib import Path

import pytest
from depth import thorough

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "everyday_loops.py"
SPEC = importlib.util.spec_from_file_location("everyday_loops", SCRIPT)
campaign = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(campaign)
LOOPS = {loop.name: loop for loop in campaign.loops()}
SAMPLE = list(LOOPS)[3 :: 37 if thorough() else 111]


def test_there_are_at_least_three_hundred_loops_and_every_kind_of_nonlinearity():
    assert len(LOOPS) >= 300
    kinds = campaign.nonlinearities(1)
    assert {kind for kind in kinds for name in LOOPS if name.endswith(f"-{kind}")} == set(kinds)


@pytest.mark.slow_for("hydraulic-varying", "lag-cubic", "sampled-unstable-formula")
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("name", SAMPLE)
def test_commands_checkers_and_simulation_agree(name, tmp_path):
    found, verdict = campaign.faults(LOOPS[name], tmp_path)
    assert found == []
    assert verdict in campaign.STATUS

"""What ``lure`` hands out, what that loads, and folders of the user's own that have a name of ours."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lure
import lure.analysis
from lure import InputError, Loop, Saturation, simulate
from lure.files.builtin import builtin_loop
from lure.rod import builtin_system

ROOT = Path(__file__).parents[2]


def test_the_questions_are_asked_of_lure_itself():
    assert lure.max_sector is lure.analysis.max_sector
    assert lure.max_slope is lure.analysis.max_slope
    assert lure.analyse is lure.analysis.analyse
    assert lure.certify is lure.analysis.certify
    assert lure.simulate is lure.analysis.simulate
    assert lure.report is lure.analysis.report.report_on


def test_few_names_are_handed_out_and_those_of_the_rod_by_its_rooms():
    assert len(lure.__all__) <= 36
    assert len(lure.analysis.__all__) <= 16
    assert {"Rod", "exact_motion", "upwind"} <= set(lure.rod.__all__)
    assert {"compare", "bifurcation"} <= set(lure.analysis.rod.__all__)


def test_every_name_is_there():
    for package in (lure, lure.analysis, lure.rod, lure.analysis.rod):
        assert [name for name in package.__all__ if not hasattr(package, name)] == []


def test_importing_lure_loads_nothing_but_its_lists_of_names():
    script = "import sys; import lure; print(*sorted(m for m in sys.modules if m.startswith('lure')))"
    run = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["lure", "lure.extensions", "lure.lazy"]


# Somebody's folder "analysis", beside the script and on the path.
@pytest.mark.parametrize("where", ["beside", "on the path"])
def test_an_analysis_folder_of_the_users_own_is_in_nobodys_way(tmp_path, where):
    own = tmp_path / "analysis"
    own.mkdir()
    (own / "__init__.py").write_text("raise RuntimeError('not the one that was asked for')\n")
    script = tmp_path / "mine.py"
    script.write_text(
        "from lure.analysis import max_sector\nprint(max_sector(([1], [1, 3, 2, 0])).verdict)\n"
        "import sys\nfrom lure.analysis.cli import main\nsys.exit(main())\n"
    )
    beside = tmp_path if where == "beside" else ROOT
    paths = [str(ROOT)] if where == "beside" else [str(tmp_path), str(ROOT)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    command = [sys.executable, str(script), "max-sector", "--num", "1", "--den", "1 3 2 0"]
    found = subprocess.run(command, cwd=beside, env=environment, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("PROVED\n")
    assert "popov" in found.stdout


# 1/(s + 1) with phi = sigma: x' = -2 x, and sigma(1) = exp(-2).
def test_a_plant_and_a_nonlinearity_are_simulated():
    found = simulate(([1], [1, 1]), lambda sigma: sigma, x0=[1], until=1)
    assert found.sigma[-1] == pytest.approx(np.exp(-2), rel=1e-8)
    assert len(found.t) == 2001


# Its state is that of the matrices it was given by: C x0 = 3, where the companion form would have sigma = 16.
def test_the_first_state_is_that_of_the_matrices():
    plant = ([[-1, 3], [0, -2]], [[1], [2]], [[1, 1]], 0)
    found = simulate(Loop(plant, Saturation()), x0=[1, 2], until=1, samples=11)
    assert (found.sigma[0], len(found.t)) == (3, 11)


# x+ = x/2 - phi(x), phi the saturation: 4, 1, -1/2, 1/4.
def test_a_loop_in_discrete_time_is_simulated():
    assert simulate("1/(z - 1/2)", Saturation(), x0=[4], until=3).sigma.tolist() == [4, 1, -0.5, 0.25]


def test_a_system_from_a_file_is_simulated_with_its_own_nonlinearity():
    system = builtin_loop("kalman-fitts")
    found = simulate(system, x0=np.ones(system.block.order), until=1.0)
    assert np.isfinite(found.sigma).all()


def test_a_rod_is_simulated_with_its_own_loads():
    system = builtin_system("paper-rod")
    found = simulate(system, until=0.01, samples=5)
    assert (found.contact, len(found.t)) == (False, 5)


@pytest.mark.parametrize(
    ("arguments", "settings", "sentence"),
    [
        ((([1], [1, 1]), Saturation()), {"x0": [1]}, "until is missing"),
        ((([1], [1, 1]), Saturation()), {"until": 1}, "a first state x0"),
        ((([1], [1, 1]),), {"until": 1, "x0": [1]}, "with a nonlinearity"),
        ((([1], [1, 1]), Saturation()), {"until": 1, "x0": [1, 2]}, "give 1 finite numbers"),
        ((([1], [1, 1]), Saturation()), {"until": 0, "x0": [1]}, "give a positive time"),
        (("exp(-s)/(s + 1)", Saturation()), {"until": 1, "x0": [1]}, "no finite state"),
        ((lure.rod.upwind(builtin_system("paper-rod").rod, 5),), {"until": 1}, "with a Scenario"),
    ],
)
def test_what_cannot_be_simulated_is_refused_in_a_sentence(arguments, settings, sentence):
    with pytest.raises(InputError, match=sentence):
        simulate(*arguments, **settings)

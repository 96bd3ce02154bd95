"""A newcomer's walk: from an empty folder and a wheel to a report, a notebook and a test of one's own nonlinearity."""

import json
import re
import tarfile
import zipfile

import pytest
from installed import Environment, built

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    return built(tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def plain(tmp_path_factory, packages):
    return Environment(tmp_path_factory.mktemp("plain"), packages[1])


def test_the_wheel_has_what_runs_and_the_sdist_what_explains(packages):
    sdist, wheel = packages
    shipped = set(zipfile.ZipFile(wheel).namelist())
    tops = {name.split("/")[0] for name in shipped if ".dist-info" not in name}
    assert tops == {"lure", "pytest_lure.py"}
    for name in (
        "lure/py.typed",
        "lure/analysis/report/schema.json",
        "lure/analysis/measured/example.csv",
        "lure/__init__.pyi",
        "lure/analysis/starters/50-your-own-loop.py",
        "lure/analysis/starters/nonlinearity_test.txt",
    ):
        assert name in shipped
    (points,) = (name for name in shipped if name.endswith("entry_points.txt"))
    assert "[pytest11]\nlure = pytest_lure\n" in zipfile.ZipFile(wheel).read(points).decode()
    with tarfile.open(sdist) as archive:
        kept = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    assert {"README.md", "LICENSE", "constraints.txt", "Makefile", "notebooks/10-the-paper.py"} <= kept
    assert {"tests/house/test_newcomer.py", "docs/index.md", ".ci/run"} <= kept


def test_from_an_empty_folder_to_a_report_on_ones_own_loop(plain, tmp_path):
    where = plain.run(
        "python", "-c", "import lure.analysis; print(lure.__file__, lure.analysis.__file__)", cwd=tmp_path
    )
    assert all(str(plain.bin.parent) in path for path in where.split())
    plain.run("lure", "doctor", cwd=tmp_path)

    plain.run("lure", "init", "--loop", "plant.toml", cwd=tmp_path)
    file = tmp_path / "plant.toml"
    text = file.read_text(encoding="utf-8")
    assert "sector = [0, 5.9]" in text
    said = plain.run("lure", "report", "plant.toml", cwd=tmp_path)  # Popov reaches 6: H = 1/(s(s+1)(s+2))
    assert said.startswith("PROVED")
    report = json.loads((tmp_path / "lure-report" / "report.json").read_text(encoding="utf-8"))
    assert report["conclusion"]["verdict"] == "PROVED"
    certificates = sorted((tmp_path / "lure-report" / "certificates").glob("*.json"))
    assert certificates
    assert "ACCEPTED" in plain.run("lure", "verify", certificates[0], cwd=tmp_path)

    file.write_text(text.replace("gain = 5 ", "gain = 6.5 ").replace("[0, 5.9]", "[0, 6.5]"), encoding="utf-8")
    plain.run(
        "lure", "analyse", "plant.toml", cwd=tmp_path, status=11
    )  # the linear gain 6.5 is in the class, and unstable


def test_from_an_empty_folder_to_an_answer_about_a_rod(plain, tmp_path):
    plain.run("lure", "init", "rod.toml", cwd=tmp_path)
    file = tmp_path / "rod.toml"
    text = file.read_text(encoding="utf-8")
    assert "compliance = 1  " in text
    file.write_text(text.replace("compliance = 1  ", "compliance = 0.1"), encoding="utf-8")
    assert plain.run("lure", "certify", "rod.toml", cwd=tmp_path).startswith("PROVED")
    assert (tmp_path / "certificate.json").exists()


@pytest.mark.thorough  # in the environment of the tests, without a wheel: test_starters.py
def test_from_an_empty_folder_to_a_notebook_and_a_test_of_ones_own_nonlinearity(plain, tmp_path_factory):
    folder, own = tmp_path_factory.mktemp("own"), plain
    own.add("testing")
    own.run("lure", "init", "--notebook", "my-loop.ipynb", cwd=folder)
    cells = json.loads((folder / "my-loop.ipynb").read_text(encoding="utf-8"))["cells"]
    own.run("lure", "init", "--notebook", "my-loop.py", cwd=folder)
    assert cells[0]["source"][0].lstrip("# \n") in (folder / "my-loop.py").read_text(encoding="utf-8")
    # with another plant, about which less is computed: the one of the notebook is that of `make notebooks`
    script = (folder / "my-loop.py").read_text(encoding="utf-8")
    quick, changed = re.subn(r"(?m)^PLANT = .*$", "PLANT = control.tf([1], [1, -0.5], 1)", script)
    assert changed == 1
    (folder / "my-loop.py").write_text(quick, encoding="utf-8")
    own.run("python", "my-loop.py", cwd=folder)

    own.run("lure", "init", "--test", "test_phi.py", cwd=folder)
    text = (folder / "test_phi.py").read_text(encoding="utf-8")
    assert "LOWER, UPPER = 0, 20\n" in text
    halved = text.replace("LOWER, UPPER = 0, 20\n", "LOWER, UPPER = 0, 10\n")
    (folder / "test_half.py").write_text(halved, encoding="utf-8")
    said = own.run("python", "-m", "pytest", "--lure-evidence", cwd=folder, status=1)  # the plugin is found by itself
    assert "2 failed, 2 passed" in said
    assert "leaves the sector [0, 10]" in said  # 20 sigma near 0

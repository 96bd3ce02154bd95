"""Sweeps: rows are the answers of the plain questions, nothing is lost or done twice, bad studies are refused."""

import contextlib
import json
import math
import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

from lure.analysis.sweeps import run as runs
from lure.analysis.sweeps import sweep
from lure.analysis.sweeps.page import _figures, page_of
from lure.analysis.sweeps.reading import study_of
from lure.analysis.sweeps.rows import answered
from lure.analysis.sweeps.run import opened
from lure.analysis.sweeps.store import Store
from lure.errors import InputError

# 1/(s(s+a)(s+2)): Routh gives the largest linear gain 2a(a+2), and Popov's criterion proves the whole sector below it.
LOOP = """
[plant]
num = [1]
den = [1, 3, 2, 0]
"""
ROD = {"system": "paper-rod", "ask": "rod", "over": {"rod.damping": [-1e-4, 0, 2e-4, 1e-3], "rod.compliance": [1, 10]}}


@pytest.fixture
def loops(tmp_path):
    """A study of third-order loops, one of which has no sector."""
    (tmp_path / "loop.toml").write_text(LOOP)
    dens = [[1, a + 2, 2 * a, 0] for a in (1, 2, 3)]
    return {"system": "loop.toml", "ask": "sector", "chunk": 1, "over": {"plant.den": [*dens, "nonsense"]}}, tmp_path


@pytest.mark.slow
def test_the_rows_of_rods_are_those_of_the_energy_theorem(tmp_path):
    found = sweep(ROD, tmp_path / "rods.zarr")
    counts = (found.points, found.proved, found.refuted, found.inconclusive, found.failed)
    assert counts == (8, 4, 2, 2, 0)
    data = opened(tmp_path / "rods.zarr")
    assert list(data["verdict"].sel({"rod.compliance": 1}).values) == ["REFUTED", "INCONCLUSIVE", "PROVED", "PROVED"]
    assert (data["verdict"] == data["scheme_verdict"]).all()
    # -ln|a|/(2T) with a = (k - Z)/(k + Z), Z = A sqrt(rho E) = 1.2 and T = L sqrt(rho/E) = 1/6000
    k = np.array([2e-4, 1e-3])
    expected = -np.log((1.2 - k) / (1.2 + k)) * 6000 / 2
    np.testing.assert_allclose(data["slowest_decay"].values[2:, 0], expected, rtol=1e-12)
    assert data["largest_low"].attrs["units"] == "Pa/m"
    assert data["rod.damping"].attrs["units"] == "N s/m"
    assert np.isinf(data["largest_low"].values[2:]).all()


@pytest.mark.slow
def test_a_sweep_of_sectors_agrees_with_routh_and_a_point_that_fails_is_a_row(loops):
    study, folder = loops
    found = sweep(study_of(study, folder=folder), folder / "loops.zarr", certificates="all")
    assert (found.proved, found.failed, found.computed_now) == (3, 1, 4)
    data = opened(folder / "loops.zarr")
    np.testing.assert_allclose(data["largest_low"].values[:3], [6, 16, 30], rtol=1e-6)
    assert data["error"].values[3].startswith("plant.den")
    assert np.isnan(data["largest_low"].values[3])
    assert found.checked_again == 1
    page = page_of(folder / "loops.zarr")
    assert "3 PROVED" in page
    assert "failed: plant.den" in page
    assert "all converge to equilibria" in page
    assert "a rod without load" not in page
    again = sweep(study_of(study, folder=folder), folder / "loops.zarr")
    assert again.computed_now == 0


# a tie of circle and Popov, a critical case, Popov alone, REFUTED, a plant that is not stable, slopes
PLANTS = [
    ("sector", "[1]", "[1, 1]"),
    ("sector", "[1]", "[1, 3, 2, 0]"),
    ("sector", "[1, 0.5]", "[1, 1, 2, 1]"),
    ("sector", "[-1]", "[1, 3, 2, 1]"),
    ("sector", "[1]", "[1, -1, 2]"),
    ("slope", "[1]", "[1, 2, 2, 1]"),
    ("slope", "[1, 0]", "[1, 0.4, 2, 0.3, 0.5]"),
]


def words(row):
    """The row as text, nan equal to nan, without the time taken."""
    return {key: repr(value) for key, value in row.items() if key != "seconds"}


@pytest.mark.parametrize(("question", "num", "den"), PLANTS)
def test_a_row_is_that_of_the_plain_question(loops, question, num, den):
    study, folder = loops
    source = study_of({**study, "over": {"plant.num": [[1]]}}, folder=folder).source
    place = [f"plant.num={num}", f"plant.den={den}"]
    quick, plain = (answered(source, place, question, plain=each) for each in (False, True))
    assert words(quick.row) == words(plain.row)
    assert quick.certificates == plain.certificates


@pytest.mark.slow
def test_slopes_of_a_class_that_depends_on_time_are_not_asked(loops):
    study, folder = loops
    source = study_of({**study, "over": {"plant.num": [[1]]}}, folder=folder).source
    place = ["plant.num=[1]", "plant.den=[1, 2, 2, 1]", "class.sector=[0, 1]", "class.time_varying=true"]
    assert "nonlinearities that do not" in answered(source, place, "slope", plain=False).row["error"]
    assert answered(source, place, "sector", plain=False).row["verdict"] == "PROVED"


@pytest.mark.parametrize(
    "place",
    [["rod.damping=2e-4"], ["rod.damping=-1e-4"], ["rod.damping=0"], ["rod.damping=2 Z", "rod.exponent=0.5"]],
    ids=str,
)
def test_a_row_of_a_rod_is_that_of_the_plain_question(place):
    source = study_of(ROD).source
    for each in (place, [*place, "rod.compliance=3e-7"], [*place, "discretisation.cells=4"]):  # the second: from memory
        quick, plain = (answered(source, each, "rod", plain=plainly) for plainly in (False, True))
        assert words(quick.row) == words(plain.row)
        assert quick.certificates == plain.certificates


@pytest.mark.slow
def test_an_interrupted_sweep_goes_on_where_it_stopped(loops, monkeypatch):
    study, folder = loops
    study = study_of(study, folder=folder)
    whole = sweep(study, folder / "whole.zarr")
    begun = []

    def stopped(*given):
        begun.append(given)
        if len(begun) == 3:
            raise KeyboardInterrupt
        return answered(*given)

    answered = runs.answered
    monkeypatch.setattr(runs, "answered", stopped)
    with pytest.raises(KeyboardInterrupt):
        sweep(study, folder / "parts.zarr")
    monkeypatch.setattr(runs, "answered", answered)
    rest = sweep(study, folder / "parts.zarr")
    assert rest.computed_now == 2
    assert (rest.done, rest.proved) == (whole.done, whole.proved)
    first, second = (opened(folder / name).drop_vars("seconds") for name in ("whole.zarr", "parts.zarr"))
    assert first.drop_attrs().identical(second.drop_attrs())


def test_an_answer_cut_by_an_interrupt_is_not_kept(loops, monkeypatch):
    study, folder = loops
    answered = runs.answered

    def cut(*given, **options):  # as a search does that hands back what it has so far
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        return answered(*given, **options)

    monkeypatch.setattr(runs, "answered", cut)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts beside itself ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            sweep(study_of(study, folder=folder), folder / "cut.zarr")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert list((folder / "cut.zarr" / ".lure" / "done").iterdir()) == []


def of_zeros(path):
    """A file as long as before, of which nothing came to the disk."""
    path.write_bytes(bytes(path.stat().st_size))


@pytest.mark.parametrize("harm", [Path.unlink, lambda path: path.write_bytes(b""), of_zeros])
@pytest.mark.parametrize("what", [".lure/done/1", "verdict/c/1"])
def test_a_chunk_without_its_marker_or_its_whole_files_is_not_taken_for_done(loops, harm, what):
    study, folder = loops
    study = study_of({**study, "over": {"plant.num": [[1], [2]]}}, folder=folder)
    sweep(study, folder / "loops.zarr")
    harm(folder / "loops.zarr" / what)  # as after a power cut
    assert sweep(study, folder / "loops.zarr").computed_now == 1
    assert list(opened(folder / "loops.zarr")["verdict"].values) == ["PROVED", "PROVED"]


def test_a_damaged_file_is_named_where_its_chunk_is_not_computed_anew(tmp_path):
    study = study_of({**ROD, "over": {"rod.damping": [1e-4]}})
    store = Store(tmp_path / "rods.zarr", study)
    store.make()
    store.write(0, [{"verdict": "PROVED"}], [])
    file = store.path / "verdict" / "c" / "0"
    of_zeros(file)
    with pytest.raises(InputError, match=f"{file} is damaged, as after a power cut; give the same lure sweep again"):
        page_of(store.path)
    (store.path / ".lure" / "whole.json").write_text("{}")  # put together, where no chunk is left to be computed
    with pytest.raises(InputError, match="where it says this too, remove the store first"):
        store.there()


def test_a_store_that_another_process_has_made_meanwhile_is_taken(tmp_path):
    first, second, other = (
        Store(tmp_path / "rods.zarr", study_of({**ROD, "over": {"rod.damping": [value]}})) for value in (1, 1, 2)
    )
    first.make()
    first.write(0, [{"verdict": "PROVED"}], [])
    second.make()
    assert second.done() == {0}
    with pytest.raises(InputError, match="holds another study"):
        other.make()
    assert [entry.name for entry in tmp_path.iterdir()] == ["rods.zarr"]


def test_zarr_reads_the_files_of_chunks_also_at_an_edge(tmp_path):
    study = study_of({**ROD, "chunk": 4, "over": {"rod.damping": [1e-4, 2e-4], "rod.compliance": [1, 2, 3, 4, 5]}})
    store = Store(tmp_path / "rods.zarr", study)
    store.make()
    assert study.chunk == (1, 4)
    store.write(2, [{"verdict": "PROVED", "theta": math.pi, "error": "caf\u00e9"}] * 3 + [{"verdict": ""}], [])
    store.write(3, [{"verdict": "REFUTED", "theta": -math.inf}], [])
    data = opened(store.path)
    assert data["verdict"].values.tolist() == [[""] * 5, ["PROVED"] * 3 + ["", "REFUTED"]]
    assert data["error"].values[1, 2:].tolist() == ["caf\u00e9", "", ""]
    np.testing.assert_array_equal(data["theta"].values, [[np.nan] * 5, [np.pi] * 3 + [np.nan, -np.inf]])
    assert store.counts() == ({"PROVED": 3, "failed": 1, "REFUTED": 1}, "caf\u00e9")


def test_a_row_that_was_changed_is_noticed(tmp_path):
    import zarr

    study = study_of({**ROD, "over": {"rod.damping": [2e-4]}})
    sweep(study, tmp_path / "rods.zarr")
    decay = zarr.open_group(tmp_path / "rods.zarr", mode="r+")["slowest_decay"]
    decay[0] = np.nextafter(decay[0], 2)  # a file as long as before
    with pytest.raises(RuntimeError, match=r"rod\.damping=0\.0002: slowest_decay is 1\.0.*, and 1\.0.* in"):
        sweep(study, tmp_path / "rods.zarr")


def test_the_store_says_how_many_rows_were_computed_again_also_of_a_run_that_was_resumed(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "ONE_IN", 3)
    study = study_of({**ROD, "chunk": 4, "over": {"rod.damping": {"from": 1e-4, "to": 1e-2, "count": 10}}})
    store = Store(tmp_path / "rods.zarr", study)
    store.make()
    job = runs.Job(path=str(store.path), study=study, digest=study.digest, keep="none", seconds=None)
    runs.computed(1, job)  # as in a run that was killed after one chunk
    assert sweep(study, store.path).computed_now == 6
    assert opened(store.path).attrs["checked_again"] == 10 // 3  # of all rows, those of the run before among them


def test_only_sweeps_import_what_sweeps_need():
    import ast

    import lure

    top = Path(lure.__file__).parent
    found, packages = set(), {"zarr", "dask", "distributed"}
    for path in [*top.rglob("*.py"), *(top / "analysis").rglob("*.py")]:  # a link, which rglob does not follow
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if any(name in text for name in packages) else ():
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if {name.partition(".")[0] for name in names} & packages:
                found.add(path.relative_to(top).as_posix())
    inside = {"analysis/sweeps/store.py", "analysis/sweeps/cluster.py"}
    assert found == inside


@pytest.mark.slow
def test_a_figure_of_a_page_with_several_questions_says_what_is_drawn_and_in_which_unit():
    import xarray

    over = ("question", "a")
    data = xarray.Dataset(
        {
            "verdict": (over, [["PROVED"] * 2] * 2),
            "criterion": (over, [["popov"] * 2] * 2),
            "error": (over, [[""] * 2] * 2),
            "low": (over, [[1.0, 2.0]] * 2, {"long_name": "lower end of the gain, of the rate", "units": "1"}),
        },
        coords={"question": ["gain", "rate"], "a": [1.0, 2.0]},
    )
    titles = [figure.spec.title for figure in _figures(data, [])]
    measured = ["lower end of the L2 gain", "lower end of the rate, 1/s in continuous time and a factor per sample"]
    assert [title.startswith(one) for title, one in zip(titles[1::2], measured, strict=True)] == [True, True]


@pytest.mark.slow
def test_a_page_has_maps_and_the_points_to_look_at(tmp_path):
    over = {"rod.damping": [-1e-4, 0, 2e-4, 1e-3], "discretisation.cells": [2, 5, 9], "rod.compliance": [1, 10]}
    sweep({**ROD, "over": over}, tmp_path / "rods.zarr")
    page = page_of(tmp_path / "rods.zarr", lambda number, system, settings: f"{system}-{number}-{len(settings)}")
    assert "12 PROVED, 6 INCONCLUSIVE, 6 REFUTED" in page
    assert "rod.compliance = 10" in page  # the third dimension, in its middle and at its end
    assert "rod.compliance = 1. Each" in page
    assert "--set discretisation.cells=2 " in page  # a whole number, as --set takes it
    assert '<a href="paper-rod-1-3">' in page
    assert "PROVED, the least of all, 1 1/s: decay of the slowest wave mode of the rod, of its linear part" in page


# 1/(s^2 - s + 2) is not stable with the gain 0: both questions of one point are refuted, and it is listed once
@pytest.mark.slow
def test_a_point_to_look_at_is_listed_once_for_all_its_questions(tmp_path):
    (tmp_path / "loop.toml").write_text("[plant]\nnum = [1]\nden = [1, -1, 2]\n[class]\nsector = [0, 1]\n")
    study = study_of({"system": "loop.toml", "ask": ["sector", "class"], "over": {"plant.num": [[1]]}}, folder=tmp_path)
    assert str(study) == "loop.toml, asked for sector and class: 1 value of plant.num"
    sweep(study, tmp_path / "loop.zarr")
    page = page_of(tmp_path / "loop.zarr")
    assert page.count("<td>refuted</td>") == 1
    assert "<h1>1 point, asked for sector and class</h1>" in page


def test_three_questions_are_listed_with_one_and(tmp_path):
    (tmp_path / "loop.toml").write_text(LOOP + "[class]\nsector = [0, 1]\n")
    asked = {"system": "loop.toml", "ask": ["sector", "slope", "rate"], "over": {"plant.num": [[1]]}}
    assert "asked for sector, slope and rate: 1 value" in str(study_of(asked, folder=tmp_path))


@pytest.mark.thorough
def test_the_points_of_a_page_have_their_reports(tmp_path, lure):
    sweep({**ROD, "over": {"rod.damping": [2e-4]}}, tmp_path / "rods.zarr")
    assert lure("sweep", str(tmp_path / "rods.zarr"), "--report", "--points")[0] == 0
    assert '<a href="rods-points/1/report.html">' in (tmp_path / "rods.html").read_text()
    assert (tmp_path / "rods-points" / "1" / "report.html").is_file()


@pytest.mark.thorough
def test_killed_processes_lose_nothing(tmp_path):
    import psutil

    over = {"rod.damping": {"from": 1e-4, "to": 1e-2, "count": 400}}
    study = study_of({"system": "paper-rod", "ask": "rod", "chunk": 10, "over": over})
    stop = threading.Event()

    def kill():
        seen = 0
        while not stop.wait(0.2):
            done = len(list((tmp_path / "killed.zarr").glob(".lure/done/[0-9]*")))
            if done <= seen:
                continue
            seen = done + 4
            for child in psutil.Process().children(recursive=True)[-1:]:
                os.kill(child.pid, signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        found = sweep(study, tmp_path / "killed.zarr", workers=2)
    finally:
        stop.set()
        killer.join()
    assert found.lost > 2
    plain = sweep(study, tmp_path / "plain.zarr")
    assert (found.done, found.proved) == (plain.done, plain.proved) == (400, 400)
    first, second = (opened(tmp_path / f"{name}.zarr").drop_vars("seconds") for name in ("killed", "plain"))
    assert first.drop_attrs().identical(second.drop_attrs())


def test_an_even_grid_holds_the_decimals_that_it_is_written_with():
    # steps of 0.1 from -0.1: as doubles the second is 1.4e-17, a rod with another verdict than the undamped one
    study = study_of({**ROD, "over": {"rod.damping": {"from": -0.1, "to": 0.2, "count": 4}}})
    assert study.axes[0].values == ("-0.1", "0.0", "0.1", "0.2")


@pytest.mark.slow
def test_points_are_drawn_alike_for_one_seed(tmp_path):
    tables = {
        "system": "paper-rod",
        "ask": "rod",
        "over": {
            "rod.damping": {"between": [1e-4, 1e-2], "spacing": "log"},
            "rod.gap": {"mean": 0.02, "deviation": 1e-3},
        },
        "draw": {"count": 5, "seed": 3, "method": "sobol"},
    }
    first, second = study_of(tables), study_of(tables)
    assert [first.settings((i,)) for i in range(5)] == [second.settings((i,)) for i in range(5)]
    damping = first.drawn["rod.damping"]
    assert ((damping >= 1e-4) & (damping <= 1e-2)).all()
    assert math.isclose(study_of({**tables, "draw": {"count": 1024}}).drawn["rod.gap"].mean(), 0.02, rel_tol=0.01)
    found = sweep(first, tmp_path / "drawn.zarr")
    assert found.proved == 5
    data = opened(tmp_path / "drawn.zarr")
    assert list(data.coords) == ["rod.damping", "rod.gap"]
    assert "5 PROVED" in page_of(tmp_path / "drawn.zarr")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"ask": "sectors"}, "ask is 'sectors'; give one of rod, sector"),
        ({"ask": "sector"}, "ask is 'sector', and paper-rod is a rod; ask 'rod'"),
        ({"over": {}}, "over is empty; give a table"),
        ({"over": {"rod.dampin": [1]}}, "[over]: unknown key rod.dampin; did you mean rod.damping?"),
        ({"over": {}, "boxes": {"rod.dampin": [1, 2]}}, "[boxes]: unknown key rod.dampin; did you mean rod.damping?"),
        ({"over": {"rod.damping": []}}, "over.rod.damping is an empty array"),
        ({"over": {"rod.damping": {"from": 0, "to": 1, "count": 2, "spacing": "log"}}}, "give positive ends"),
        ({"over": {"rod.damping": {"from": 0, "to": 1, "count": 0}}}, "over.rod.damping.count is 0"),
        ({"over": {"rod.damping": {"from": 0, "to": 1, "step": 2}}}, "unknown key over.rod.damping.step"),
        ({"draw": {"count": 3}}, "over.rod.damping is [-0.0001, 0, 0.0002, 0.001]; with [draw] give"),
        ({"draw": {"count": 3}, "over": {"rod.damping": {"between": [2, 1]}}}, "give the smaller end first"),
        ({"ask": []}, "ask is an empty array"),
        ({"over": {"rod.damping": [1e-4, 1e-4]}}, "over.rod.damping has a value twice"),
        ({"over": {"rod.damping": {"from": 0, "to": 1, "count": 1}}}, "has the count 1 from 0 to 1; give at least 2"),
        (
            {"over": {"rod.damping": {"from": 1, "to": 1, "count": 3}}},
            "the count 3 from 1 to 1; give two ends that dif",
        ),
        ({"plant": {"num": [1]}}, "this is the file of a system; a study is one more file, which names it"),
        ({"systm": 1}, "unknown key 'systm' of a study; did you mean 'system'? it has"),
        ({"chunk": -1}, "chunk is -1"),
        ({"system": 3}, "system is 3"),
    ],
)
def test_a_study_that_is_no_good_is_refused_in_a_sentence(change, sentence):
    with pytest.raises(InputError) as error:
        study_of({**ROD, **change})
    assert sentence in str(error.value)


def test_a_folder_and_a_word_for_a_truth_value_are_refused_in_a_sentence(tmp_path, lure):
    status, _, err = lure("sweep", ".")
    assert (status, ". is a folder; give the TOML file of a study" in " ".join(err.split())) == (2, True)
    (tmp_path / "loop.toml").write_text(f"{LOOP}[class]\nslope = [0, 1]\nodd = true\n")
    with pytest.raises(InputError, match=r"over.class.odd has 'maybe'; give true or false"):
        study_of({"system": "loop.toml", "ask": "slope", "over": {"class.odd": ["maybe"]}}, folder=tmp_path)


def test_another_study_does_not_go_into_the_same_store(tmp_path):
    sweep({**ROD, "over": {"rod.damping": [1e-4]}}, tmp_path / "rods.zarr")
    with pytest.raises(InputError, match="holds another study; give another -o"):
        sweep({**ROD, "over": {"rod.damping": [2e-4]}}, tmp_path / "rods.zarr")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes").write_text("mine")
    with pytest.raises(InputError, match="exists and is no sweep of lure"):
        sweep({**ROD, "over": {"rod.damping": [2e-4]}}, tmp_path / "mine")


@pytest.mark.slow
def test_the_command_prints_counts_and_writes_a_page(tmp_path, lure, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text('system = "paper-rod"\nask = "rod"\n[over]\nrod.damping = [1e-4, 0]\n')
    status, out, _ = lure("sweep", "study.toml", "--json")
    found = json.loads(out)
    assert status == 0
    assert {found[name] for name in ("points", "done", "computed_now")} == {2}
    assert (found["proved"], found["inconclusive"], found["failed"]) == (1, 1, 0)
    assert lure("sweep", "study.zarr", "--report")[0] == 0
    page = (tmp_path / "study.html").read_text()
    assert "lure report paper-rod --set rod.damping=0.0" in page
    assert "PROVED is about a rod without load: every motion of finite energy comes to rest." in page

"""Cells of a grid proved as a whole, points where the verdict changes, and regions of attraction in a sweep."""

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

from lure.analysis.cli import sweeps as commands
from lure.analysis.plots.studies import Plane, covered, values_drawn, verdicts_drawn
from lure.analysis.sweeps import sweep
from lure.analysis.sweeps.boundary import stores
from lure.analysis.sweeps.page import page_of
from lure.analysis.sweeps.reading import study_of
from lure.analysis.sweeps.rows import answered
from lure.analysis.sweeps.run import opened
from lure.errors import InputError

# k/(s (s + 1)(s + a)): by Routh the largest linear gain is a (a + 1)/k, and Popov's criterion proves all below it.
SERVO = '[plant]\ntransfer = "k/(s*(s + 1)*(s + a))"\n[plant.parameters]\nk = 1.0\na = 2.0\n[class]\nsector = [0, 4]\n'
ROD = {"system": "paper-rod", "ask": "rod", "over": {"rod.damping": [1e-4]}}
A, K = "plant.parameters.a", "plant.parameters.k"


@pytest.fixture
def servo(tmp_path):
    """Makes studies of a servo with two parameters."""
    (tmp_path / "servo.toml").write_text(SERVO)
    return lambda **tables: study_of({"system": "servo.toml", "ask": "class", **tables}, folder=tmp_path)


@pytest.mark.slow
def test_each_cell_is_proved_for_all_plants_in_it(servo, tmp_path):
    study = servo(ask="sector", boxes={A: {"from": 1, "to": 3, "count": 2}}, over={K: [1, 2]})
    found = sweep(study, tmp_path / "boxes.zarr")
    assert (found.points, found.proved) == (4, 4)
    assert "2 values of plant.parameters.k x 2 intervals of plant.parameters.a" in str(found)
    data = opened(tmp_path / "boxes.zarr")
    assert data["plant.parameters.a bounds"].values.tolist() == [[1, 2], [2, 3]]
    # least at the lower end of each interval of a: 1 (1 + 1)/k and 2 (2 + 1)/k
    np.testing.assert_allclose(data["largest_low"].values, [[2, 6], [1, 3]], rtol=1e-6)
    assert (data["largest_low"].values < [[2, 6], [1, 3]]).all()
    assert (data["refuted_at"].values >= [[2, 6], [1, 3]]).all()


@pytest.mark.slow
def test_points_are_put_where_the_verdict_changes(servo, tmp_path):
    study = servo(refine="boundary", over={A: {"from": 1, "to": 3, "count": 3}, K: [0.5, 1]})
    found = sweep(study, tmp_path / "refined.zarr")
    # sector [0, 4] is proved where a (a + 1) > 4 k; at a = 1 and k = 0.5 both are 2, which an end of the sector refutes
    data = opened(tmp_path / "refined.zarr")
    assert data["verdict"].values.tolist() == [["REFUTED", "REFUTED"], ["PROVED", "PROVED"], ["PROVED", "PROVED"]]
    assert found.refined == 10
    last = opened(stores(tmp_path / "refined.zarr")[-1])
    for k, a, verdict in zip(last[K].values, last[A].values, last["verdict"].values, strict=True):
        edge = (np.sqrt(1 + 16 * k) - 1) / 2
        assert abs(a - edge) <= 1 / 32
        assert (a > edge) == (verdict == "PROVED")
    again = sweep(study, tmp_path / "refined.zarr")
    assert (again.computed_now, again.refined) == (0, 10)


def test_a_region_has_its_size_in_the_row(tmp_path):
    # x' = x - sat(g x) limited at 1: for g > 1 all between -1 and 1 tends to 0, and nothing else; for g < 1 nothing
    (tmp_path / "loop.toml").write_text(
        '[plant]\nnum = [1]\nden = [1, -1]\n[nonlinearity]\nkind = "saturation"\ngain = 2\nlimit = 1\n'
    )
    tables = {"system": "loop.toml", "ask": "region", "over": {"nonlinearity.gain": [0.5, 2, 3]}}
    found = sweep(study_of(tables, folder=tmp_path), tmp_path / "regions.zarr")
    assert (found.proved, found.refuted) == (2, 1)
    data = opened(tmp_path / "regions.zarr")
    assert data["low"].values.tolist() == data["high"].values.tolist() == [0, 2, 2]


def drawn(plane):
    """The axes with the verdicts of a plane."""
    axes = Figure().add_subplot()
    verdicts_drawn(plane, ax=axes)
    return axes


def test_colours_cover_what_was_asked_and_no_more():
    # intervals of a at k = 1 and k = 3: bars at these two, nothing at k = 2
    coordinates = {"k": [1.0, 3.0], "a": [1.5, 2.5], "a bounds": (("a", "end"), [[1.0, 2.0], [2.0, 3.0]])}
    data = xarray.Dataset({"verdict": (("k", "a"), [["PROVED", "REFUTED"], ["PROVED", "PROVED"]])}, coordinates)
    data["error"] = xarray.full_like(data["verdict"], "")
    plane = Plane(data, ("k", "a"), "")
    axes = drawn(plane)
    assert len(axes.collections) == 2  # one of what is proved, one of what is refuted
    bars = [bar.tolist() for lines in axes.collections for bar in lines.get_segments()]
    assert sorted(bars) == [[[1, 1], [1, 2]], [[1, 2], [1, 3]], [[3, 1], [3, 2]], [[3, 2], [3, 3]]]
    assert covered(plane).startswith("Each bar is one interval of a at one value of k")
    assert covered(Plane(data.isel(k=0), ("a",), "")).startswith("Each mark is about a whole interval of a")
    axes = drawn(Plane(data.transpose("a", "k", ...), ("a", "k"), ""))
    bars = [bar.tolist() for lines in axes.collections for bar in lines.get_segments()]
    assert sorted(bars) == [[[1, 1], [2, 1]], [[1, 3], [2, 3]], [[2, 1], [3, 1]], [[2, 3], [3, 3]]]
    # many points: cells, which end where the points end
    wide = xarray.Dataset(
        {"verdict": (("k", "a"), np.full((50, 40), "PROVED"))}, {"k": np.arange(50), "a": np.arange(40)}
    )
    plane = Plane(wide.assign(error=xarray.full_like(wide["verdict"], "")), ("k", "a"), "")
    box = drawn(plane).collections[0].get_coordinates()
    assert (box.min(), box[..., 0].max(), box[..., 1].max()) == (0, 49, 39)
    assert covered(plane) == "Each colour is the answer at one point: nothing is said of what lies between."


def test_points_that_failed_are_drawn_and_words_stand_along_their_axis():
    words = ["1/s", "a formula that is longer", "true"]
    data = xarray.Dataset({"verdict": (("f", "a"), [["PROVED", "", ""]] * 3)}, {"f": words, "a": [1.0, 2.0, 3.0]})
    data["error"] = (("f", "a"), [["", "no plant", ""]] * 3)  # and the third is not computed yet
    axes = drawn(Plane(data, ("f", "a"), ""))
    assert [line.get_label() for line in axes.lines] == ["proved", "failed"]
    assert axes.lines[1].get_xydata().tolist() == [[0, 2], [1, 2], [2, 2]]
    assert [each.get_text() for each in axes.get_xticklabels()] == ["1/s", "a formula that …", "true"]


def test_values_of_few_points_are_marks_and_infinite_ones_are_told_apart():
    values, along = [[1.0, 2.0, np.inf], [3.0, np.nan, np.inf], [4.0, 5.0, 6.0]], ("k", "a")
    mass = ("a", [1.0, 2.0, 3.0], {"units": "kg"})
    few = xarray.Dataset({"largest_low": (along, values, {"units": "1"})}, {"k": [1.0, 2.0, 3.0], "a": mass})
    few["verdict"] = few["largest_low"].isnull()
    axes = Figure().add_subplot()
    values_drawn(Plane(few, along, ""), "largest_low", ax=axes)
    (marks,) = axes.collections  # no cells, and no contours, between the points
    assert sorted(marks.get_array()) == [1, 2, 3, 4, 5, 6]
    (endless,) = axes.lines
    assert (endless.get_label(), endless.get_xydata().tolist()) == ("inf", [[1, 3], [2, 3]])
    axes = Figure().add_subplot()
    values_drawn(Plane(few.isel(k=0), ("a",), ""), "largest_low", ax=axes)
    assert [line.get_label() for line in axes.lines if line.get_label() == "inf"] == ["inf"]
    assert axes.lines[-1].get_xdata().tolist() == [3]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("a [kg]", "largest_low")


def test_where_every_point_failed_the_summary_and_the_page_say_so(servo, tmp_path):
    found = sweep(servo(over={"plant.transfer": ["1/(", "2/("]}), tmp_path / "failed.zarr")
    assert (found.failed, found.checked_again) == (2, 0)
    assert "Every point failed: nothing is said of any. The first that failed: plant" in str(found)
    assert str(found).endswith(".")
    assert "agrees" not in str(found)
    page = page_of(tmp_path / "failed.zarr")
    assert "every point failed" in page
    assert "and agree" not in page
    study = tmp_path / "none.toml"
    study.write_text('system = "third-order"\nask = "sector"\n[over]\n"plant.den" = ["nonsense"]\n')
    assert commands.sweep(study, quiet=True) == 2  # the exit status
    with pytest.raises(InputError, match=r"give \S*failed.zarr, the store that lure sweep wrote"):
        page_of(tmp_path / "failed.toml")


@pytest.mark.parametrize(
    ("tables", "sentence"),
    [
        ({"boxes": {A: [1]}}, "boxes.plant.parameters.a is '[1]'; give the edges"),
        ({"boxes": {A: [2, 1]}}, "give the edges of the cells, at least two, ascending"),
        ({"boxes": {A: {"from": 3, "to": 1, "count": 2}}}, "from 3 down to 1; give the smaller end first"),
        ({"boxes": {A: {"from": 1, "to": 2, "count": 0}}}, "boxes.plant.parameters.a.count is 0"),
        ({"boxes": {}}, "give a table [boxes]"),
        ({"boxes": {A: [1, 2]}, "over": {A: [1, 2]}}, "is in [over] and in [boxes]"),
        ({"boxes": {A: [1, 2]}, "refine": "boundary"}, "refine stands beside [boxes]"),
        ({"boxes": {"plant.dt": [1, 2]}}, "[boxes] takes what may be an interval"),
        ({"boxes": {"plant.parameters.b": [1, 2]}}, "[plant.parameters] has no b; it has k, a"),
        ({"over": {A: [1, "2"], "class.sector": [[0, 1]]}, "refine": "boundary"}, "class.sector is no number"),
        ({"over": {A: [1, "x"]}}, "over.plant.parameters.a has 'x'; give a finite number"),
        ({"over": {A: [float("nan"), 1]}}, "over.plant.parameters.a has 'nan'; give a finite number"),
        ({"over": {A: [1]}, "ask": "region"}, "servo.toml has no [nonlinearity]"),
        ({"system": "paper-rod", "ask": "rod", "boxes": {"rod.gap": [1, 2]}}, "[boxes] takes what may be an interval"),
        ({"boxes": {"class.sector": [1, 2]}}, "boxes.class.sector is no number of servo.toml; give values"),
        (
            {"over": {"class.sector": [[0, "inf"]]}, "ask": "gain"},
            "ask is 'gain', and no point can be asked that: an L2 gain",
        ),
        ({"over": {A: [1]}, "system": None}, "system is missing; give"),
        ({"over": {A: {"from": 1, "to": 2}}}, "over.plant.parameters.a.count is missing; give"),
        ({"over": {A: [1, 2]}, "refine": 3}, "refine is 3; give 'boundary'"),
        ({"over": {A: {"between": [1, 2]}}, "draw": {"count": 2}, "refine": "boundary"}, "refine stands beside [draw]"),
    ],
)
def test_what_cannot_be_cut_or_refined_is_refused(servo, tables, sentence):
    with pytest.raises(InputError) as error:
        servo(**tables)
    assert sentence in str(error.value)


def test_each_box_of_rods_is_proved_for_all_rods_in_it(tmp_path):
    # k > 0 is proved, k < 0 refuted, and at k = 0 nothing is known
    boxes = {"rod.damping": [-2e-4, -1e-4, 0, 2e-4, 1e-3], "rod.compliance": [1, 10]}
    found = sweep({"system": "paper-rod", "ask": "rod", "boxes": boxes}, tmp_path / "rods.zarr")
    assert (found.proved, found.refuted, found.inconclusive, found.failed) == (1, 2, 1, 0)
    data = opened(tmp_path / "rods.zarr").isel({"rod.compliance": 0})
    assert data["verdict"].values.tolist() == ["REFUTED", "REFUTED", "INCONCLUSIVE", "PROVED"]
    # (E/L) min(k, Z)^2/|k^2 - Z^2| of the paper's rod, Z = 1.2, is least at an end of the box: at k = 2e-4
    least, _ = (answered(study_of(ROD).source, [f"rod.damping={k}"], "rod").row["circle"] for k in ("2e-4", "1e-3"))
    assert data["circle"].values[-1] == least
    assert np.isnan(data["slowest_decay"].values).all()

"""Results as Datasets, plain JSON and python-control responses: the same numbers, with units, names and evidence."""

import sys

import control
import numpy as np
import pytest
import xarray
from matplotlib import pyplot
from matplotlib.axes import Axes
from refusals import refusal
from results import FREE, RESULTS, STRUCK, cells, scheme

from lure.analysis.measured import Measurements, report_from_data, sector_from_data
from lure.analysis.rod.plots.motion import plot_convergence, plot_motion
from lure.analysis.rod.runs import sampled_motion
from lure.rod import Numerics, Scenario, exact_motion, initial_state
from lure.rod.galerkin import NonuniformRod, galerkin
from lure.rod.motion import Boundary
from lure.rod.scheme import structured_motion

MOTIONS = [
    "exact motion",
    "Galerkin run",
    "structured motion",
    "trajectory",
    "sampled scheme",
    "sampled Galerkin",
    "sampled rod",
]
DRAWN = [
    "trajectory",
    "sampled rod",
    "sampled Galerkin",
    "comparison",
    "confirmation",
    "response",
    "bifurcation",
    "basin",
    "measurements",
    "measured sector",
    "compliance fit",
    "measured report",
    "broken",
]


@pytest.mark.parametrize("name", MOTIONS)
def test_python_control_gets_the_output_and_the_inputs_of_the_loop(name):
    motion = RESULTS[name]()
    found = motion.to_control(21) if name == "exact motion" else motion.to_control()
    table = motion.to_xarray(21) if name == "exact motion" else motion.to_xarray()
    assert isinstance(found, control.TimeResponseData)
    assert found.output_labels == ["z [m]"]
    assert found.input_labels == ["mu = -p [Pa]", "g [N]"]
    assert found.time.tolist() == table.t.values.tolist()
    assert np.ravel(found.outputs).tolist() == table.z.values.tolist()
    assert found.inputs[0].tolist() == (0.0 - table.contact_stress.values).tolist()
    # the force of the system is 0.01 sin(4000 t) N
    assert found.inputs[1] == pytest.approx(0.01 * np.sin(4000 * found.time), abs=1e-15)


def test_cells_have_outputs_and_no_inputs():
    motion = RESULTS["cells in the plane"]()
    found = motion.to_control()
    assert found.output_labels[:3] == ["f(x[0, 0])", "f(x[0, 1])", "f(x[0, 2])"]
    assert found.outputs[4].tolist() == motion.output[:, 1, 1].tolist()
    assert found.inputs is None


def test_the_exact_motion_and_its_samples_are_one_dataset():
    motion = RESULTS["exact motion"]()
    found = motion.to_xarray(21, places=3)
    xarray.testing.assert_identical(sampled_motion(motion, 21, places=3).to_xarray(), found)


@pytest.mark.parametrize(
    ("name", "series"),
    [
        ("trajectory", {"z": "z", "contact_stress": "p", "energy": "energy", "force": "force"}),
        ("Galerkin run", {"z": "z", "energy": "energy", "coefficients": "coefficients", "dissipated": "dissipated"}),
        ("structured motion", {"z": "z", "wave": "wave"}),
        ("cells on a line", {"x": "x", "output": "output"}),
        ("response", {"z": "z", "v": "v"}),
        ("basin", {"rest_low": "low", "settled": "settled", "impacts": "impacts"}),
        ("measurements", {"displacement": "displacement", "load": "load", "line": "lines"}),
    ],
)
def test_the_numbers_are_those_of_the_result(name, series):
    result = RESULTS[name]()
    found = result.to_xarray()
    for label, field in series.items():
        assert found[label].values.tolist() == np.asarray(getattr(result, field)).tolist(), label


def test_the_force_of_a_trajectory_is_that_of_its_system():
    run = RESULTS["trajectory"]()
    assert run.force == pytest.approx(0.01 * np.sin(4000 * run.t), abs=1e-12)
    assert not RESULTS["trajectory without load"]().force.any()


def test_a_sweep_with_values_of_different_lengths_is_filled_with_nan():
    found = RESULTS["bifurcation"]()
    table = found.to_xarray()
    for i, point in enumerate(found.points):
        assert table.poincare_z.values[i, : len(point.poincare)].tolist() == point.poincare[:, 0].tolist()
    assert table.value.values.tolist() == [0.2, 0.7]


def test_both_motions_of_a_confirmation_keep_their_own_time():
    found = RESULTS["confirmation"]()
    table = found.to_xarray()
    for side, name in ((found.rod, "rod"), (found.scheme, "scheme")):
        assert table[f"z_{name}"].dims == (f"t_{name}",)
        assert table[f"z_{name}"].values.tolist() == side.curves.z.tolist()
    assert found.to_dict()["rod"]["energy"]["holds"] is found.rod.energy.holds


@pytest.mark.slow
def test_with_memory_each_row_has_the_mean_of_its_branch():
    up = np.linspace(-2e-4, 1e-3, 120)
    u = np.concatenate([up, up[::-1]])
    bulge = 10 * np.clip(1 - np.abs(u - 5e-4) / 5e-4, 0, 1) * (np.arange(240) >= 120)
    load = 1e5 * np.maximum(u, 0) - bulge + np.random.default_rng(0).standard_normal(240)
    data = Measurements.from_arrays(u, load)
    found = sector_from_data(data)
    table = found.to_xarray()
    assert table.branch.values[[0, 200]].tolist() == ["loading", "unloading"]
    for nonlinearity, direction in zip(found.nonlinearities, ("loading", "unloading"), strict=True):
        rows = data.rows(direction)
        assert table["mean"].values[rows].tolist() == nonlinearity(u[rows]).tolist()
    merged = report_from_data(data, fit=True).to_xarray()
    assert merged.sizes["fit_row"] == 120
    assert merged.sizes["row"] == 240


@pytest.mark.parametrize("name", DRAWN)
def test_a_figure_goes_where_it_is_asked_to_go(name):
    figure, axes = pyplot.subplots()
    drawn = RESULTS[name]().plot(ax=axes)
    first = drawn[0] if isinstance(drawn, tuple) else drawn
    assert isinstance(first, Axes)
    assert first is axes
    pyplot.close(figure)


@pytest.mark.parametrize("name", ["exact motion", "Galerkin run", "structured motion"])
def test_a_motion_is_drawn_with_its_obstacle_and_says_what_moved(name):
    motion = RESULTS[name]()
    figure, axes = pyplot.subplots()
    assert plot_motion(motion, ax=axes) is axes
    end = next(line for line in axes.lines if line.get_label().startswith("end"))
    table = motion.to_xarray()
    assert np.nanmax(end.get_ydata()) == pytest.approx(table.u_end.values.max(), rel=1e-12)
    assert "obstacle at 5×10⁻⁵ m" in [text.get_text() for text in axes.get_legend().get_texts()]
    title = axes.get_title(loc="left")
    assert ("not the rod (observed)" in title) is (name != "exact motion")
    pyplot.close(figure)


@pytest.mark.parametrize("shape", [(2,), (2, 3), (4, 4)])
def test_cells_are_drawn_as_lines_or_as_a_picture(shape):
    figure, axes = pyplot.subplots()
    plot_motion(cells(shape), ax=axes)
    count = int(np.prod(shape))
    assert len(axes.lines) == (count if count <= 12 else 0)
    assert len(axes.collections) == (0 if count <= 12 else 1)
    assert axes.get_title(loc="left") == f"{count} cells (observed)"
    pyplot.close(figure)


def test_errors_are_drawn_against_the_width():
    found = RESULTS["convergence"]()
    figure, axes = pyplot.subplots()
    plot_convergence(found, ax=axes)
    assert axes.lines[0].get_xydata().tolist() == [
        [h, error.h1] for h, error in zip(found.widths, found.errors, strict=True)
    ]
    pyplot.close(figure)


def test_bounds_are_drawn_with_the_law_they_are_of():
    figure, axes = pyplot.subplots()
    assert RESULTS["nonlinearity bounds"]().plot("max(x, 0)**1.5", ax=axes) is axes
    pyplot.close(figure)


@pytest.mark.parametrize("name", ["exact motion", "trajectory", "measured sector"])
def test_without_xarray_one_sentence_says_what_to_install(name, monkeypatch):
    result = RESULTS[name]()
    monkeypatch.setitem(sys.modules, "xarray", None)
    assert refusal(result.to_xarray) == 'a Dataset needs xarray: pip install "lure[netcdf]"'


def test_a_clamped_end_has_no_dashpot_force():
    found = exact_motion(STRUCK.rod, STRUCK.scenario, 1e-3, boundary=Boundary(clamped=True)).to_xarray(5)
    assert "dashpot_force" not in found
    assert found.attrs["method_boundary_at_0"] == "clamped"


# of a motion that forgot its beginning the end is known from `since` on, the whole rod a round trip 2 T = 1/3 ms later
def test_a_motion_that_forgot_its_beginning_is_sampled_where_it_is_known():
    motion = exact_motion(STRUCK.rod, STRUCK.scenario, 0.01, numerics=Numerics(keep=6))
    assert motion.since > 0
    assert motion.to_control(5).time[0] == motion.since
    assert motion.to_xarray(5, places=3).t.values[0] == pytest.approx(motion.since + 1 / 3e3, rel=1e-12)


def test_a_run_from_a_state_has_no_force():
    start = initial_state(scheme(20), FREE.scenario)
    found = structured_motion(scheme(20), start, 1e-4, samples=5)
    assert found.to_control().inputs[1].tolist() == [0.0] * 5
    assert found.to_dict()["scenario"] is None
    assert "force_g" not in found.to_xarray().attrs


def test_the_rod_of_a_galerkin_run_may_vary_along_its_length():
    rod = NonuniformRod.parse(
        length=1, area="1+x/2", youngs_modulus=1, density=1, damping=1, compliance=1, exponent=1.5, gap=0.5
    )
    run = galerkin(rod, space="cosine", order=4).simulate(Scenario.parse(velocity=1), until=2, samples=5)
    found = run.to_xarray()
    assert found.attrs["rod_area"] == "1+x/2"
    assert found.attrs["rod_compliance_units"] == "m1.5 Pa-1"
    assert "node" not in found.coords
    assert run.to_dict()["rod"]["exponent"] == 1.5


@pytest.mark.parametrize(
    ("samples", "places", "sentence"),
    [(1, 0, "samples is 1"), (True, 0, "samples is True"), (5, 1, "fields is 1"), (5, -2, "fields is -2")],
)
def test_a_number_of_samples_that_is_none_is_refused(samples, places, sentence):
    assert sentence in refusal(RESULTS["exact motion"]().to_xarray, samples, places=places)
    if not places:
        assert sentence in refusal(RESULTS["exact motion"]().to_control, samples)

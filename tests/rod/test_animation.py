"""Pictures of motions: what is drawn is the motion, at the scale that is said, and only where it may be drawn."""

import shutil
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from PIL import Image
from refusals import refusal
from runs import thrown, thrown_end

from lure.analysis.rod.plots.animation import Picture, animate, exaggeration
from lure.analysis.rod.plots.run import (
    envelope,
    plot_run_dashpot,
    plot_run_end,
    plot_run_energy,
    plot_run_stress,
    plot_space_time,
    run_page,
    space_time_page,
)
from lure.analysis.rod.runs import Along, Performed, Request, perform, sampled_motion
from lure.analysis.rod.runs.drawing import Film, drawn_instants, film, usual_span
from lure.files import find_system
from lure.rod import Scenario
from lure.rod.motion import Boundary, exact_motion

STRUCK = find_system("paper-rod", ["rod.gap=5e-5", "rod.compliance=1e-9"])
T = STRUCK.rod.travel_time


def performed():
    motion = thrown()
    return Performed(run=sampled_motion(motion, 41), motion=motion)


@cache
def resting(gap):
    return perform(find_system("paper-rod", [f"rod.gap={gap}"]), Request(until=1e-5, samples=2)).run


def moved(u, gap=0.02):
    """A film of the paper's rod with other displacements."""
    u = np.asarray(u, dtype=float)
    along = Along(x=np.linspace(0.0, 1.0, u.shape[1]), v=0 * u, w=0 * u, u=u)
    return Film(run=resting(gap), t=np.zeros(len(u)), along=along, trace_t=np.arange(2.0), trace_u=np.zeros(2))


# the rod seems to move by at most 0.16 L: 0.16/1e-4 = 1600 -> 1000, 0.16/3e-5 = 5333 -> 5000, 0.16/0.16 = 1
@pytest.mark.parametrize(("size", "factor"), [(1e-4, 1000.0), (3e-5, 5000.0), (7e-5, 2000.0), (0.16, 1.0), (0.0, 1.0)])
def test_displacements_are_exaggerated_by_a_round_factor(size, factor):
    assert exaggeration(moved([[-size, size]], gap=1000)) == (pytest.approx(factor), 0.0)


def test_the_obstacle_counts_if_it_is_near():
    near, far = moved([[-1e-4, 1e-4]], gap="5e-4"), moved([[-1e-4, 1e-4]], gap="7e-4")  # 5 and 7 times the motion
    assert exaggeration(near) == (200.0, 0.0)  # 0.16/5e-4 = 320
    assert exaggeration(far) == (1000.0, 0.0)


def test_a_rod_that_drifted_is_counted_from_where_it_is():
    factor, origin = exaggeration(moved([[0.0199, 0.0201]]))
    assert (factor, origin) == (pytest.approx(1000.0), pytest.approx(0.02))
    assert exaggeration(moved([[0.0, 2e-4]], gap=1000))[1] == 0.0


@given(st.floats(1e-9, 1e3), st.floats(-1, 1))
def test_the_factor_is_the_largest_round_one_that_keeps_the_rod_in_bounds(size, share):
    factor, origin = exaggeration(moved([[-size, share * size]], gap=1e9))
    reach = factor * max(abs(-size - origin), abs(share * size - origin))
    assert 0.16 / 2.5 * (1 - 1e-9) < reach <= 0.16 * (1 + 1e-9)


def test_a_frame_shows_the_rod_where_it_is_and_how_it_is_stressed():
    shown = film(performed(), None, frames=9)
    figure = Figure()
    Picture(shown, figure, "a title").show(3)  # t = 0.75, in contact
    axes, trace = figure.axes[0], figure.axes[1]
    bodies = axes.collections[0]
    factor, origin = exaggeration(shown)
    corners = np.array([path.vertices[:2, 0] for path in bodies.get_paths()])
    places = shown.along.x + factor * (shown.along.u[3] - origin)
    assert corners[:, 0] == pytest.approx(places[:-1])
    assert corners[:, 1] == pytest.approx(places[1:])
    stress = shown.along.w[3]
    colours = np.asarray(bodies.get_array())
    assert colours == pytest.approx(0.5 * (stress[1:] + stress[:-1]))
    # E = 1 and w = (r2 - r1)/2.  At t = 3/4 the obstacle's r2 = -1 has come as far as x = 3/4 and so has r1 = -a = -1/2
    # from x = 0: beyond, r1 = 1 and w = -1; before, r2 = 1 and w = 3/4
    assert colours[151:] == pytest.approx(-1.0)
    assert colours[:149] == pytest.approx(0.75)
    marker = trace.lines[-1]
    assert (marker.get_xdata()[0], marker.get_ydata()[0]) == pytest.approx((0.75, 0.5))
    assert any("contact" in text.get_text() for text in axes.texts)
    assert f"displacements ×{factor:g}" in axes.get_xlabel()
    said = " ".join(text.get_text() for text in figure.texts)
    assert "a title" in said
    assert "the rod itself (computed)" in said


def test_a_frame_in_flight_says_so():
    figure = Figure()
    Picture(film(performed(), None, frames=9), figure, "").show(1)  # t = 1/4
    assert any("flight" in text.get_text() for text in figure.axes[0].texts)


@pytest.mark.slow
def test_a_gif_has_every_frame_and_the_same_bytes_twice(tmp_path):
    shown = film(performed(), None, frames=2)
    told = []
    for name in ("a.gif", "b.gif"):
        animate(shown, tmp_path / name, title="", tell=lambda stage, done: told.append(done))
    assert told == [0.5, 1.0] * 2
    with Image.open(tmp_path / "a.gif") as found:
        assert found.n_frames == 2
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.gif").read_bytes()


@pytest.mark.slow
def test_a_folder_gets_numbered_frames(tmp_path):
    (tmp_path / "frames").mkdir()
    animate(film(performed(), None, frames=11), tmp_path / "frames", title="")
    assert sorted(path.name for path in (tmp_path / "frames").iterdir()) == [f"frame-{i:02}.png" for i in range(11)]


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_mp4(tmp_path):
    animate(film(performed(), None, frames=3), tmp_path / "run.mp4", title="")
    assert (tmp_path / "run.mp4").read_bytes()[4:8] == b"ftyp"


@pytest.mark.slow
def test_a_command_writes_an_animation_and_nothing_else(lure, here):
    arguments = ("--until", "1e-4", "--animation", "frames", "--samples", "4", "--method", "scheme")
    status, out, err = lure("simulate", "paper-rod", *arguments)
    assert (status, err) == (0, "")
    assert out.endswith("Written: frames\n")
    assert len(list((here / "frames").iterdir())) == 4
    assert [path.name for path in here.iterdir()] == ["frames"]


def test_a_short_motion_is_shown_whole_and_a_long_one_around_its_strongest_impact():
    short = perform(STRUCK, Request(until=15 * T, samples=2), energy=False).run
    assert usual_span(short) == (0.0, 15 * T)
    long = perform(STRUCK, Request(until=30 * T, samples=2), energy=False).run
    assert usual_span(long) == (0.0, pytest.approx(10 * T))  # contact at 0.75 T
    hit = perform(find_system("paper-rod", ["initial.u1=1"]), Request(until=0.03, samples=2), energy=False).run
    first, last = usual_span(hit)
    strongest = max(hit.impacts, key=lambda impact: impact.impulse)
    assert first < strongest.start < last
    assert last - first == pytest.approx(10 * T)
    assert strongest.start > 10 * T


def test_the_film_of_a_motion_is_the_motion():
    done = performed()
    shown = film(done, (0.25, 1.25), frames=5)
    x = np.linspace(0.0, 1.0, 201)
    assert shown.t.tolist() == [0.25, 0.5, 0.75, 1.0, 1.25]
    assert shown.along.v.tolist() == done.motion.velocity(shown.t[:, None], x[None, :]).tolist()
    assert shown.along.u[4].tolist() == done.motion.displacement(1.25, x).tolist()
    assert shown.trace_u == pytest.approx(thrown_end(shown.trace_t), abs=1e-12)


@pytest.mark.slow
def test_the_film_of_samples_is_a_choice_of_them():
    done = perform(STRUCK, Request(until=6 * T, samples=61, method="galerkin", order=9, places=5))
    shown = film(done, (T, 4 * T), frames=16)
    kept = [int(np.argmin(np.abs(done.run.t - t))) for t in shown.t]
    assert kept == list(range(10, 41, 2))
    assert shown.along.u.tolist() == done.run.along.u[kept].tolist()


@pytest.mark.parametrize(
    ("span", "sentence"),
    [
        ((0.5, 0.5), "span is 0.5 to 0.5 s; give two instants in order in [0, 2] s"),
        ((-1.0, 1.0), "span is -1 to 1 s; give two"),
        ((0.0, 2.1), "span is 0 to 2.1 s; give two"),
    ],
)
def test_spans_that_are_refused(span, sentence):
    assert refusal(film, performed(), span, frames=3).startswith(sentence)


def test_a_span_too_long_for_its_waves_is_refused():
    motion = exact_motion(thrown().rod, Scenario.parse(velocity="x"), 90.0, boundary=Boundary(rigid=True))
    done = Performed(run=sampled_motion(motion, 3, energy=False), motion=motion)
    assert "81 transits of the rod; a picture shows the waves of at most 80" in refusal(film, done, (0, 81.0), frames=3)
    assert len(film(done, (0.0, 80.0), frames=3, displaced=False).t) == 3


def test_samples_too_far_apart_are_refused():
    def done(samples):
        return perform(STRUCK, Request(until=6 * T, samples=samples, method="scheme", cells=5, places=6))

    assert refusal(film, done(24), None, frames=9).endswith("seen give at least 25, or a shorter time")
    assert len(film(done(25), None, frames=25).t) == 25


def test_the_end_is_drawn_as_it_moves_with_its_contact():
    run = performed().run
    axes = plot_run_end(run, ax=Figure().add_subplot())
    curve = axes.lines[0]
    assert curve.get_xdata().tolist() == run.t.tolist()
    assert curve.get_ydata().tolist() == run.u_end.tolist()
    (bars,) = axes.collections
    assert bars.get_paths()[0].get_extents().intervalx == pytest.approx([0.5, 1.0])
    assert any(line.get_ydata()[0] == 0.5 for line in axes.lines[1:])


@pytest.mark.parametrize(
    ("draw", "name"), [(plot_run_stress, "stress"), (plot_run_dashpot, "dashpot_force"), (plot_run_energy, "energy")]
)
def test_the_other_panels_draw_their_series(draw, name):
    run = performed().run
    axes = draw(run, ax=Figure().add_subplot())
    assert axes.lines[0].get_ydata().tolist() == getattr(run, name).tolist()


def test_what_a_method_does_not_give_is_said():
    run = perform(STRUCK, Request(until=1e-3, samples=9, method="scheme", cells=1200)).run
    for draw in (plot_run_dashpot, plot_run_energy):
        axes = draw(run, ax=Figure().add_subplot())
        assert not axes.lines
        assert axes.texts[0].get_text() == "not given by this method"


def test_an_obstacle_out_of_view_is_named():
    run = perform(find_system("paper-rod"), Request(until=1e-3, samples=9)).run
    axes = plot_run_end(run, ax=Figure().add_subplot())
    assert axes.get_ylim()[1] < 0.02
    assert axes.texts[0].get_text() == "obstacle at 0.02 m, outside this view"
    assert plot_run_stress(run, ax=Figure().add_subplot()).texts[0].get_text() == "no contact"


def test_space_time_draws_the_fields_and_the_contact():
    shown = film(performed(), None, frames=21, displaced=False)
    for which, values in (("velocity", shown.along.v), ("stress", shown.along.w)):
        axes = plot_space_time(shown, which, ax=Figure().add_subplot())
        assert np.asarray(axes.collections[0].get_array()).reshape(values.shape).tolist() == values.tolist()
        assert axes.lines[0].get_ydata() == pytest.approx([0.5, 1.0])


def test_pages_take_the_place_of_their_axes_and_of_nothing_else():
    run, shown = performed().run, film(performed(), None, frames=5, displaced=False)
    for page, what, panels in ((run_page, run, 4), (space_time_page, shown, 2)):
        figure = Figure()
        other, place = figure.subplots(1, 2)
        drawn = page(what, title="a title", ax=place)
        assert len(drawn) == panels
        assert place not in figure.axes
        assert other in figure.axes
        assert not other.has_data()


@given(st.floats(501.0, 1e6), st.floats(0.5, 8.0))
def test_samples_of_a_long_motion_meet_its_swings_in_every_phase(transits, period):
    t = drawn_instants((3.0, 3.0 + transits), 1.0)
    assert len(t) == 20001
    assert (t[0], t[-1]) == (3.0, 3.0 + transits)
    assert (np.diff(t) > 0).all()
    phases = np.sort(t[5000:5200] / period % 1.0)
    reached = period * 20001 / transits  # samples in a period: if many, the stretch of 200 must hold some periods
    if reached < 40:
        assert np.diff(phases, append=phases[0] + 1.0).max() < 0.12  # evenly spread ones 0.005


def test_samples_of_a_short_motion_follow_it():
    assert drawn_instants((0.0, 10.0), 1.0).tolist() == np.linspace(0.0, 10.0, 401).tolist()
    assert len(drawn_instants((1.0, 501.0), 1.0)) == 20001


@given(st.integers(4001, 20000), st.integers(0, 2**32 - 1))
def test_thinning_keeps_the_extremes_and_the_ends(size, seed):
    values = np.random.default_rng(seed).integers(-300, 300, size).astype(float)
    t = np.arange(len(values), dtype=float)
    kept_t, kept = envelope(t, values)
    assert len(kept) <= 2 * 800 + 2
    assert (kept.min(), kept.max()) == (values.min(), values.max())
    assert (kept_t[0], kept_t[-1]) == (0.0, t[-1])
    assert kept.tolist() == values[kept_t.astype(int)].tolist()


def test_thinning_leaves_few_points_alone():
    t = np.arange(4000.0)
    assert envelope(t, t)[0] is t

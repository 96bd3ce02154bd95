"""Figures of long runs, and the commands that make them: the numbers of the results, one sentence per refusal."""

import json
import math
import re
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from depth import rarely
from matplotlib import pyplot
from matplotlib.figure import Figure
from motions import unit_rod

from lure.analysis.plots import render
from lure.analysis.rod.plots.response import (
    plot_basin,
    plot_bifurcation,
    plot_history,
    plot_impulses,
    plot_poincare,
    plot_response,
    plot_response_spectrum,
)
from lure.analysis.rod.response import Plan, Sweep, basin, bifurcation, response
from lure.rod.motion import Boundary

MATCHED = unit_rod(damping=1.0, gap=0)
RIGID = Plan(settle=20, run=8, samples=16, boundary=Boundary(rigid=True))
RUNS = {
    "seen": partial(response, MATCHED, "0.3 + sin(t)", plan=RIGID),
    "free": partial(response, unit_rod(damping=1.0, gap=50), "sin(t)", plan=Plan(settle=20, run=8)),
    "late": partial(response, unit_rod(damping=0.6, gap=0), "0.3 + 0.9*sin(t/2)", plan=Plan(settle=0, run=8)),
    "swept": partial(bifurcation, MATCHED, "0.3 + sin(w*t)", "w", [0.8, 1.0, 1.5], sweep=Sweep(plan=RIGID)),
    "places": partial(basin, unit_rod(damping=0.6, compliance=0.05, gap=0.2), [-0.2, 0.0, 0.1], [0.0, 0.1, 0.5]),
}


@cache
def ran(name):
    return RUNS[name]()


DRAWINGS = {
    "history": lambda **given: plot_history(ran("seen"), **given),
    "points": lambda **given: plot_poincare(ran("seen"), **given),
    "spectrum": lambda **given: plot_response_spectrum(ran("seen"), **given),
    "impulses": lambda **given: plot_impulses(ran("seen"), **given),
    "all": lambda **given: plot_response(ran("seen"), **given),
    "all, free": lambda **given: plot_response(ran("free"), **given),
    "all, irregular": lambda **given: plot_response(ran("late"), **given),
    "sweep": lambda **given: plot_bifurcation(ran("swept"), **given),
    "basin": lambda **given: plot_basin(ran("places"), **given),
}
ROD = """
name = "matched bar"
[rod]
youngs_modulus = 1
density = 1
length = 1
area = 1
damping = 1
compliance = 1
[force]
g = "0.3 + sin(t)"
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", rarely(DRAWINGS, "all", "all, free", "all, irregular"))
def test_a_figure_is_drawn_on_the_axes_given_and_is_the_same_every_time(name):
    figure = Figure()
    axes = figure.add_subplot()
    assert DRAWINGS[name](ax=axes) is axes
    assert pyplot.get_fignums() == []
    assert render(DRAWINGS[name], name="x") == render(DRAWINGS[name], name="x")


def test_the_history_shows_the_motion_against_periods_and_the_contact():
    axes = plot_history(ran("seen"), ax=Figure().add_subplot())
    (motion,) = [line for line in axes.lines if line.get_label().startswith("z =")]
    t, z = motion.get_data()
    assert t[-1] == pytest.approx(ran("seen").t[-1] / (2 * math.pi))
    assert z == pytest.approx(ran("seen").z[-z.size :])
    assert len(axes.collections[0].get_paths()) in (6, 7)  # six periods of one contact each, cut at both ends
    assert axes.get_ylabel() == "z [m]"
    labels = [text.get_text() for text in axes.texts]
    assert labels == ["−0.7", "1.3"]


def test_points_and_orbit_of_a_motion_that_repeats():
    axes = plot_poincare(ran("seen"), ax=Figure().add_subplot())
    orbit, points = axes.lines[:2]
    assert len(orbit.get_xdata()) == ran("seen").plan.samples + 1
    assert np.ptp(points.get_xdata()) < 1e-9
    assert axes.get_title(loc="left") == "periodic, 1 × period of the force"


def test_all_impacts_are_in_the_histogram():
    axes = plot_impulses(ran("seen"), ax=Figure().add_subplot())
    assert sum(patch.get_height() for patch in axes.patches) == ran("seen").impact_impulses.size
    assert [tick for tick in axes.get_yticks() if tick % 1] == []
    assert "no impact" in plot_impulses(ran("free"), ax=Figure().add_subplot()).texts[0].get_text()


def test_a_sweep_shows_every_point_and_keeps_its_range_when_it_is_interrupted():
    axes = plot_bifurcation(ran("swept"), ax=Figure().add_subplot())
    drawn = sum(len(line.get_xdata()) for line in axes.lines if line.get_marker() == ".")
    assert drawn == 3 * 9
    low, high = axes.get_xlim()
    assert low < 0.8 < 1.5 < high


def test_a_drawing_of_an_interrupted_run_says_that_it_is_not_all():
    swept, places = ran("swept"), ran("places")
    for found, draw, part in ((swept, plot_bifurcation, "only 3 of 3 values"), (places, plot_basin, "motions done")):
        drawn = [draw(one, ax=Figure().add_subplot()) for one in (found, replace(found, complete=False))]
        said = [" ".join([axes.get_title(loc="left"), *(text.get_text() for text in axes.texts)]) for axes in drawn]
        assert [part in words for words in said] == [False, True]


def test_the_places_are_those_found():
    axes = plot_basin(ran("places"), ax=Figure().add_subplot())
    assert axes.collections[0].get_array().data == pytest.approx(ran("places").high)


# 'z moves less than 0 m' said what no motion can
def test_a_rod_that_does_not_move_is_said_not_to_move():
    regime = replace(ran("seen").regime, kind="rest", range=0.0, seen=64)
    assert str(regime) == "At rest: z does not move during the 64 periods watched."
    assert str(replace(regime, range=1e-17)) == "At rest: z moves by 1e-17 m in all during the 64 periods watched."


# the bounds of a place at 0 are 0 to rounding, and a number of impacts that is 0 is none
def test_the_places_are_said_without_rounding_errors_and_without_up_to_0_impacts():
    places = ran("places")
    high = np.where(places.high == places.high.max(), -1.4e-20, places.high)
    none = replace(places, high=high, impacts=np.zeros_like(places.impacts))
    assert re.search(r"They lie at z = -\S+ m to 0 m, without an impact\.\n", str(none))
    assert "m, after up to 1 impact.\n" in str(replace(none, impacts=np.ones_like(places.impacts)))


@pytest.fixture
def rod(here):
    (here / "rod.toml").write_text(ROD)
    return "rod.toml"


@pytest.mark.slow
def test_the_command_response_says_and_draws_what_the_function_finds(lure, here, rod):
    status, out, err = lure("response", rod, "--rigid", "--settle", "20", "--periods", "8", "--plot", "a.png")
    assert (status, err) == (0, "")
    assert out.endswith("\n\nWritten: a.png\n")
    assert "Repeats every period of the force" in out
    assert "Evidence: observed" in out
    assert max(map(len, out.splitlines())) <= 80
    assert (here / "a.png").read_bytes().startswith(b"\x89PNG")
    again = lure("response", rod, "--plot", "a.png")
    assert again == (2, "", "lure: 'a.png' exists; give another name, or --replace to replace it\n")
    options = ("--rigid", "--settle", "20", "--periods", "8", "--samples", "16", "--json", "-q")
    status, out, err = lure("response", rod, *options, "--plot", "a.png", "--replace")
    assert (status, err) == (0, "")
    found = json.loads(out)
    # anew: that of the figures may have run before anything was compiled
    again = response(MATCHED, "0.3 + sin(t)", plan=RIGID)
    assert found == json.loads(json.dumps(again.to_dict())) | {"force": "0.3 + sin(t)"}


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("response", "kalman-fitts"), "is a Lur'e loop; give a rod"),
        (("response", "paper-rod", "--force", "exp(t)"), "no period of 'exp(t)' follows"),
        (("response", "paper-rod", "--force", "sin("), "--force"),
        (("response", "paper-rod", "--plot", "a.jpg"), "ends in .svg or .png"),
        (("response", "paper-rod", "--plot", "no/a.png"), "'no' is no directory"),
        (("response", "paper-rod", "--periods", "2"), "run, the periods watched, is 2"),
        (("bifurcation", "paper-rod", "--parameter", "F", "--from", "0", "--to", "1"), "there is no parameter 'F'"),
        (
            ("bifurcation", "paper-rod", "--parameter", "gap", "--from", "0", "--to", "1", "--sweep", "x"),
            "--sweep is 'x'",
        ),
        (
            ("bifurcation", "paper-rod", "--parameter", "gap", "--from", "0", "--to", "1", "--count", "0"),
            "--count asks for 0",
        ),
        (("basin", "paper-rod", "--set", "force.g=sin(t)"), "under a load does not come to rest"),
        (("basin", "paper-rod", "--offset", "0", "1", "0"), "--offset asks for 0 values"),
    ],
)
def test_a_refusal_is_one_sentence_and_status_2(lure, options, sentence):
    status, out, err = lure(*options)
    assert (status, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


SWEEP = ("--force", "0.3 + sin(w*t)", "--parameter", "w", "--from", "0.8", "--to", "1.6", "--count", "3", "--rigid")


@pytest.mark.slow
def test_an_interrupted_sweep_is_printed_and_drawn_as_far_as_it_went(lure, here, rod, monkeypatch):
    options = ("bifurcation", rod, *SWEEP, "--settle", "20", "--periods", "8")
    whole = lure(*options, "--json")
    assert whole[0] == 0
    from lure.analysis.rod import response

    run = response.bifurcation

    def cut(*arguments, sweep):
        def progress(text, share):
            if share > 0.5:
                raise KeyboardInterrupt

        return run(*arguments, sweep=Sweep(plan=sweep.plan, start=sweep.start, progress=progress))

    monkeypatch.setattr(response, "bifurcation", cut)
    status, out, err = lure(*options, "--json", "--plot", "part.svg", "-q")
    assert (status, err) == (130, "lure: interrupted\n")
    part = json.loads(out)
    assert (part["complete"], len(part["values"])) == (False, 3)
    assert part["points"] == json.loads(whole[1])["points"][:2]
    assert (here / "part.svg").read_text().startswith("<?xml")


def test_the_command_basin_says_where_the_rod_rests(lure, here, rod):
    options = ("--set", "force.g=0", "--set", "rod.damping=0.5", "--set", "rod.gap=1", "--velocity", "0", "0.4", "3")
    status, out, _ = lure("basin", rod, *options, "--plot", "b.svg", "-q")
    assert status == 0
    assert "3 of 3 resting places are known, 3 of them with no contact to come, 3 without any." in " ".join(out.split())
    found = json.loads(lure("basin", rod, *options, "--json")[1])
    assert found["rest_high_m"] == [[pytest.approx(rest, abs=1e-12)] for rest in (-1, -0.6, -0.2)]  # M v0/k - gap


def test_the_help_shows_examples_within_80_columns(lure):
    for command in ("response", "bifurcation", "basin"):
        text = lure(command, "--help")[1]
        assert max(map(len, text.splitlines())) <= 80
        assert text.index("Examples:") < text.index("Options:")

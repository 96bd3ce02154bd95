"""Several known nonlinearities simulated: against solutions by hand, what a run is called, and the report's figure."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from matplotlib.figure import Figure

from lure import DeadZone, Diagonal, InputError, NonlinearityClass, Saturation, analyse, as_plant, builtin_loop
from lure.analysis.counterexamples.channel_solutions import Hysteron, channel_solutions
from lure.analysis.counterexamples.trajectories import Finding
from lure.analysis.plots import plot_channels
from lure.analysis.report.loop.figures import loop_figures
from lure.analysis.report.loop.observed import observed
from lure.analysis.report.loop.write import build_loop_report
from lure.analysis.report.parts import ContradictionError
from lure.analysis.verdict import Verdict
from lure.files.system import LoopSystem

SATURATION = Saturation(gain=1, limit=1)


# 1/(s+1): while sigma >= 1, sigma' = -sigma - 1, so sigma = (s + 1) e^-t - 1 until e^t = (s + 1)/2; then -2 sigma
def test_channels_apart_are_solved_as_by_hand():
    runs = channel_solutions(as_plant([["1/(s+1)", "0"], ["0", "1/(s+1)"]]), (SATURATION,) * 2, "two saturations")
    assert [run.finding for run in runs] == [Finding.CONVERGES] * 3
    for run in runs:
        for channel in range(2):
            start, sign = abs(run.sigma[0, channel]), np.sign(run.sigma[0, channel])
            switch = np.log(max((start + 1) / 2, 1.0))
            after = min(start, 1.0) * np.exp(-2 * (run.t - switch))
            by_hand = np.where(run.t < switch, (start + 1) * np.exp(-run.t) - 1, after)
            assert np.allclose(run.sigma[:, channel], sign * by_hand, atol=1e-6 * start)
            assert np.allclose(run.mu[:, channel], -np.clip(run.sigma[:, channel], -1, 1), atol=1e-12)
    assert max(abs(runs[2].sigma[0])) > 30


# H = 1 + 1/(z - 1/2): sigma = x - phi; within the limits sigma = x/2 = phi and x_next = x/2 - x/2 = 0
def test_a_direct_term_in_discrete_time_is_solved_and_the_loop_is_dead_beat():
    plant = as_plant([["(z+0.5)/(z-0.5)", "0"], ["0", "(z+0.5)/(z-0.5)"]], dt=1)
    small = channel_solutions(plant, (SATURATION,) * 2, "two saturations")[1]
    assert abs(small.sigma[0]).max() > 0.1
    assert abs(small.sigma[1:]).max() < 1e-12


# beyond its width the dead zone has the gain 20, and 1/(s+1)^3 stands 8
@pytest.mark.slow
def test_what_grows_is_called_so_and_contradicts_a_proof():
    plant, gentle = as_plant([["1/(s+1)^3", "0"], ["0", "1/(s+1)"]]), DeadZone(gain=2, width=1)
    system = LoopSystem(name="pair", title="", block=plant, nonlinearities=(gentle, gentle))
    found = analyse(system)
    assert found.verdict is Verdict.PROVED
    seen = observed(found)
    assert seen.sentences[0].startswith("3 simulated solutions")
    axes = plot_channels(seen.trajectories[0], ax=Figure().add_subplot())
    assert [line.get_label() for line in axes.lines[:2]] == ["channel 1", "channel 2"]
    steep = replace(found.problem, known=(DeadZone(gain=20, width=1), gentle))
    assert Finding.GROWS in [run.finding for run in channel_solutions(plant, steep.known, "")]
    with pytest.raises(ContradictionError, match="is contradicted by a simulated solution"):
        observed(replace(found, problem=steep))


@pytest.mark.thorough
@pytest.mark.usefixtures("sketched")
def test_the_report_draws_the_channels():
    plant = as_plant([["1/(s+1)", "1/(s+2)"], ["0", "1/(s+1)"]])
    report = build_loop_report(LoopSystem(name="pair", title="", block=plant, nonlinearities=(SATURATION,) * 2))
    assert "all converged to 0" in report.observed[0]
    figure = loop_figures(report)[-1]
    assert figure.spec.name == "channels-1"
    assert "observed, no proof" in figure.spec.caption
    assert report.trajectories[0].sigma.shape == (400, 2)


# 1/s with a stop of slope 2: from sigma = s > 1, xi = 1 the rate is -2 xi, and xi falls with sigma at once: sigma = s -
# 1 + e^(-2 t).  With a play p = sigma - 1 stays where it is until sigma < p - 1: sigma' = -2 p, then -2 (sigma + 1)
def test_a_stop_is_followed_as_by_hand():
    runs = channel_solutions(as_plant([["1/s", "0"], ["0", "1/(s+1)"]]), (Hysteron(True, 2.0), SATURATION), "")
    for run in runs:
        start, sign = abs(run.sigma[0, 0]), np.sign(run.sigma[0, 0])
        inner = min(start, 1.0)
        assert np.allclose(run.sigma[:, 0], sign * (start - inner + inner * np.exp(-2 * run.t)), atol=1e-5 * start)
    assert Finding.RESTS in {run.finding for run in runs}


def test_a_play_is_followed_as_by_hand():
    runs = channel_solutions(as_plant([["1/s", "0"], ["0", "1/(s+1)"]]), (Hysteron(False, 2.0), SATURATION), "")
    for run in runs:
        start, sign = abs(run.sigma[0, 0]), np.sign(run.sigma[0, 0])
        p = max(start - 1, 0.0)
        turn = 1 / p if p else np.inf  # after a way of 2
        later = -1 + p * np.exp(-2 * (np.maximum(run.t, turn) - turn)) if p else start
        assert np.allclose(
            sign * run.sigma[:, 0], np.where(run.t < turn, start - 2 * p * run.t, later), atol=1e-4 * start
        )


# x+ = x - phi, phi = xi/2: from xi = 1 both fall by a half of xi, so that x rests 1 lower
def test_a_stop_in_discrete_time_comes_to_rest_where_it_should():
    stop = Hysteron(True, 0.5)
    for run in channel_solutions(as_plant([["1/(z-1)", "0"], ["0", "1/z"]], dt=1), (stop, SATURATION), ""):
        first = run.sigma[0, 0]
        assert run.sigma[-1, 0] == pytest.approx(first - np.clip(first, -1, 1), abs=1e-9)
    with pytest.raises(InputError, match="beside D = 0 alone"):
        channel_solutions(as_plant([["1+1/(z-0.5)", "0"], ["0", "1/z"]], dt=1), (stop, SATURATION), "")


@pytest.mark.slow
def test_members_of_the_classes_of_several_channels_are_simulated_in_the_report():
    classes = [NonlinearityClass.hysteretic("stop", 2), NonlinearityClass.slope_restricted(0, 1)]
    found = analyse(as_plant([["1/(s+1)^3", "0"], ["1/(s+1)", "1/(s+1)"]]), classes, seconds=1)
    seen = observed(found)
    kinds = ("a saturation between", "a dead zone between", "the gain 1")
    assert len(seen.sentences) == 3
    for sentence, kind in zip(seen.sentences, kinds, strict=True):
        assert sentence.startswith("phi_1 a stop of slope 2, phi_2")
        assert kind in sentence
    assert len(seen.trajectories) == 9
    operator = NonlinearityClass.norm_bounded(Fraction(1, 10))
    beside = replace(found.problem, classes=Diagonal((operator, classes[1])))
    assert not observed(replace(found, problem=beside)).sentences


# 0 attracts every solution of this loop (slopes up to 0.5236), slowly
def test_a_slow_decay_is_not_called_rest():
    system = builtin_loop("fetzer-scherer")
    steep = Saturation(gain=0.5, limit=0.5)
    findings = {run.finding for run in channel_solutions(system.block, (steep,) * 4, "")}
    assert findings <= {Finding.CONVERGES, Finding.OPEN}


# a sampling time that is not stated counts as 1, which is so many samples
@pytest.mark.parametrize(("entry", "dt", "unit"), [("1/z", True, "samples"), ("1/z", 0.5, "s"), ("1/(s+1)", None, "s")])
def test_times_are_in_samples_where_no_sampling_time_is_stated(entry, dt, unit):
    plant = as_plant([[entry, "0"], ["0", entry]], dt=dt)
    one = channel_solutions(plant, (SATURATION,) * 2, "")[0]
    assert one.unit == unit
    assert plot_channels(one, ax=Figure().add_subplot()).figure.axes[-1].get_xlabel() == f"t [{unit}]"

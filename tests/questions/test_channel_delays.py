"""Delays known by their bound in several channels: both sides of the largest factor against exact crossings."""

import math
import re

import pytest

from lure import InputError, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis import l2_gain
from lure.files import find_system
from lure.files.loop import loop_to_toml


# x' = -a x - b x(t - tau), b > a >= 0, is stable up to omega tau = pi - arg(b/(a + i omega)), omega^2 = b^2 - a^2
@pytest.mark.parametrize(("a", "b"), [(0, 1), (1, 2)])
def test_a_constant_delay_is_refuted_at_its_crossing_and_proved_close_to_it(a, b):
    omega = math.sqrt(b * b - a * a)
    crossing = (math.pi - math.atan2(omega, a)) / omega
    found = max_sector(as_plant(f"{b}/(s+{a})"), [NonlinearityClass.delayed(1)])
    assert found.refuted_at == pytest.approx(crossing, rel=1e-6)
    assert 0.999 * crossing < found.largest.low < crossing
    assert found.criterion == "piecewise-circle"
    assert found.witness.kind == "delay"
    assert "delay phi = sigma(t - tau), tau in [0," in str(found)


def test_a_varying_delay_has_the_bound_of_small_gain():
    # x' = -x(t - tau(t)): |s/(s + 1)| <= 1, so h < 1; and the delay of every size is harmless where |h| < 1 everywhere
    found = max_sector(as_plant("1/s"), [NonlinearityClass.delayed(1, varying=True)])
    assert found.largest.low == pytest.approx(1, rel=1e-6)
    assert certify(as_plant("0.9/(s+1)"), [NonlinearityClass.delayed(1000)]).verdict.name == "PROVED"


def test_delays_beside_a_sector_from_a_file(tmp_path):
    # x' = -x - x(t - tau)/2 - phi, phi in [0, 1]: with phi = 0 stable for every tau, as 1/2 < 1
    path = tmp_path / "loop.toml"
    path.write_text(
        '[plant]\ntransfer = [["0.5/(s+1)", "1/(s+1)"], ["0.5/(s+1)", "1/(s+1)"]]\n'
        "[[class]]\ndelay = 0.3\n[[class]]\nsector = [0, 1]\n"
    )
    system = find_system(str(path), [])
    assert str(system.classes) == "delay phi_1 = sigma(t - tau), tau in [0, 0.3]; phi_2 in the sector [0, 1]"
    shown = certify(system)
    assert shown.verdict.name == "PROVED"
    again = tmp_path / "again.toml"
    again.write_text(loop_to_toml(system))
    assert find_system(str(again), []).classes == system.classes


@pytest.mark.slow
def test_two_delays_and_a_gain_beside_one_meet_what_is_sampled():
    # x' = -x(t - tau_1) - x(t - tau_2): both at one delay h are the worst, 2 h = pi/2 = 1.5708
    both = as_plant([["1/s", "1/s"]] * 2)
    assert certify(both, [NonlinearityClass.delayed(0.784)] * 2).verdict.name == "PROVED"
    # G/(1 + G e^(-i w tau)), G = .5/(s^2 + s/4 + 1), tau <= 1/2: 29.0517 at tau = 1/2, on 40001 frequencies
    plant, on = ([[0, 1], [-1, -0.25]], [[0], [1]], [[0.5, 0]], [[0]]), {"Bw": [[0], [1]], "Cz": [[0.5, 0]]}
    found = l2_gain(plant, [NonlinearityClass.delayed(0.5)], on, criterion="piecewise-circle")
    assert 29.0516 < found.gain.high < 29.0516 * 1.002
    assert 29.05 < found.gain.low < found.gain.high  # a delay of 1/2
    assert "a delay of 0.5" in str(found)


LAGGING = as_plant([["0", "-1"], ["1/s", "0"]])
SERIES = [NonlinearityClass.delayed(1), NonlinearityClass(sector=Sector(0.01, 2))]


@pytest.mark.slow
def test_the_gain_beside_a_sector_is_part_of_the_counterexample():
    # x' = -k x(t - tau), k in [0, 2 alpha] in series with a delay up to alpha: 2 alpha^2 = pi/2
    found = max_sector(LAGGING, SERIES, criterion="circle")
    assert found.refuted_at == pytest.approx(math.sqrt(math.pi / 4), rel=1e-6)
    delay = re.search(r"a delay of about (\S+) in", str(found.witness.description))
    assert delay is not None
    assert float(delay[1]) == pytest.approx(found.refuted_at, abs=5e-6)  # the class has delays up to its factor


@pytest.mark.thorough
def test_scalings_reach_far_in_a_series_of_a_delay_and_a_sector():
    assert max_sector(LAGGING, SERIES).largest.low > 0.8 * math.sqrt(math.pi / 4)


def test_a_delay_that_changes_slowly_lies_between(tmp_path):
    # x' = -x(t - tau(t)): 1 at any rate, pi/2 for a constant delay; below Myshkis' 3/2, which is for any rate
    slow = NonlinearityClass.delayed(1, rate=0.5)
    found = max_sector(as_plant("1/s"), [slow])
    assert 1.2 < found.largest.low < 1.5
    assert "tau in [0, 1.22" in str(found)
    assert "|tau'| <= 0.5" in str(found)
    path = tmp_path / "loop.toml"
    path.write_text("[plant]\nnum = [0.9]\nden = [1, 1]\n[[class]]\ndelay = 1000\nrate = 0.1\n")
    system = find_system(str(path), [])
    assert certify(system).verdict.name == "PROVED"
    again = tmp_path / "again.toml"
    again.write_text(loop_to_toml(system))
    assert find_system(str(again), []).classes == system.classes
    with pytest.raises(InputError, match="the rate of a delay is 1"):
        NonlinearityClass.delayed(1, rate=1)


# x+ = x - .3 x(t - k) is stable below 2 sin(pi/(2 (2 k + 1))): .3473 for k = 4, .2846 for k = 5.  Varying: from w to
# sigma(t) - sigma(t - 1) there is .3 (z - 1)/(z (z - .7)), at most .6/1.7 at z = -1
@pytest.mark.parametrize(("varying", "low"), [(False, 4), (True, 17 / 6)])
def test_delays_of_whole_samples(varying, low):
    found = max_sector(as_plant("0.3/(z-1)", dt=1), [NonlinearityClass.delayed(1, varying=varying)])
    assert low * (1 - 1e-6) < found.largest.low < (low * (1 + 1e-6) if varying else 5)
    assert found.refuted_at == 5
    assert "a delay of 5 samples in channel 1" in str(found)


def test_a_bound_that_is_no_delay_and_a_cycle_in_d_are_refused():
    with pytest.raises(InputError, match="the bound of a delay is 0"):
        NonlinearityClass.delayed(0)
    shown = certify(as_plant([["1/(s+1)+1", "0"], ["0", "1/(s+1)"]]), [NonlinearityClass.delayed(1)] * 2)
    assert shown.verdict.name == "INCONCLUSIVE"
    assert "cycle" in str(shown.reason if hasattr(shown, "reason") else shown)


def test_a_loop_singular_in_floating_point_hides_no_gain():
    # without the delay det(A - B diag(1, g) C) = 1.515625 - 3.578125 g, 0 at g = 0.42358: no gain above it is finite
    plant = ([[-1.875, 0], [1, -0.375]], [[1, 0.5], [1, 1.5]], [[0.25, 0.25], [0.25, -1]], [[0, 0]] * 2)
    classes = [NonlinearityClass.delayed(0.75), NonlinearityClass.slope_restricted(0, 1)]
    found = l2_gain(plant, classes, {"Bw": [[0], [0.5]], "Cz": [[1, 0]]}, criterion="piecewise-circle")
    assert (found.verdict.name, found.gain.low) == ("REFUTED", math.inf)
    assert found.witness.startswith("the constant gains 1, 1 give the loop a transfer function from w to z with a pole")

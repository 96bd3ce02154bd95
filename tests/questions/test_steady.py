"""Steady responses against closed forms, against simulations from many starts, and where nothing may be said."""

import json
import math
from fractions import Fraction as F

import numpy as np
import pytest

from lure import Cubic, DeadZone, InputError, NonlinearityClass, Saturation, SlopeBounds, Tanh, as_plant, certify
from lure.analysis import Verdict, l2_gain, steady_response
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.cli import main
from lure.analysis.forced import balance
from lure.analysis.forced.balance import Balanced, Wave, _shortened
from lure.analysis.forced.band import residual
from lure.analysis.forced.loop import ForcedLoop
from lure.analysis.numerics.evidence import Bracket, Evidence
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.energy import overshoot
from lure.analysis.questions.steady import SteadyPoint
from lure.files.system import LoopSystem
from lure.nonlinearities import ExpressionNonlinearity, PiecewiseLinear

RESONANT = ([1], [1, 1, 1])
FILE = """
[plant]
num = [1]
den = [1, 1, 1]
[nonlinearity]
kind = "saturation"
gain = 1
limit = 1
[class]
sector = [0, 1]
[forcing]
amplitude = 3
omega = 1
unit = "mm"
"""


# below the limit of the saturation the loop is H/(1 + H) = 1/(s^2 + s + 2): amplitude 1/|2 - omega^2 + i omega|
@pytest.mark.parametrize("omega", [3])
def test_a_loop_that_stays_on_its_line_has_the_closed_form_to_all_digits(omega):
    found = steady_response(RESONANT, Saturation(), {"amplitude": 1, "omega": omega}).response[0]
    truth = 1 / math.hypot(2 - omega**2, omega)
    assert found.amplitude.low <= truth * (1 + 1e-15)
    assert truth * (1 - 1e-15) <= found.amplitude.high
    assert found.amplitude.width < 1e-10 * truth


# |H| = 1/|(2 + i w)(1 + i w) + 1/2|: between two of 128 samples the peak hid up to 3e-4 of itself, in four digits
def test_the_computed_amplitude_is_no_sample_beside_the_peak():
    plant = ([1], [1, 3, 2])
    row = steady_response(plant, Saturation(gain=F(1, 2), limit=1), {"amplitude": 1, "omega": F(1, 10)}).response[0]
    assert row.amplitude.low == pytest.approx(1 / abs((2 + 0.1j) * (1 + 0.1j) + 0.5), rel=1e-9)
    assert row.computed == pytest.approx(row.amplitude.low, rel=3e-6)


# sigma = H(0) (w - phi(sigma)), H(0) = 1: w = 2 + phi(2) leads to 2
@pytest.mark.slow_for("phi1-2.964027580075817")
@pytest.mark.parametrize(("phi", "w"), [(Saturation(), 3), (Tanh(), 2 + math.tanh(2))])
def test_a_constant_input_has_its_equilibrium(phi, w):
    found = steady_response(RESONANT, phi, {"constant": w}).response[0]
    assert found.omega == 0
    assert found.amplitude.low - 1e-12 <= 2 <= found.amplitude.high + 1e-12
    assert found.amplitude.width < 1e-12


def test_a_direct_term_goes_into_the_band():  # H = (s + 2)/(s + 1), constant w = 3: sigma = 2 (3 - sat), H(0) = 2
    found = steady_response(([1, 2], [1, 1]), Saturation(), {"constant": 3, "amplitude": F(1, 10), "omega": 20})
    at = found.response[0].amplitude
    assert 4 < at.low <= 4 + 0.1 * abs((20j + 2) / (20j + 1)) <= at.high < 4.11  # sigma > 1, where sat stays 1


def simulated(phi, wave, starts, periods=12, steps=200):
    """Peak of |sigma| over the last period from each start, by Runge and Kutta's method."""
    A, B, C = np.array([[0, 1], [-1, -1.0]]), np.array([[0], [1.0]]), np.array([[1.0, 0]])  # of RESONANT
    omega, amplitude, constant = wave
    step, x, peak = 2 * math.pi / omega / steps, starts.copy(), 0.0

    def rate(t, x):
        return x @ A.T + np.outer(constant + amplitude * np.sin(omega * t) - np.asarray(phi(x @ C[0])), B[:, 0])

    for k in range(periods * steps):
        t = k * step
        one = rate(t, x)
        two = rate(t + step / 2, x + step / 2 * one)
        three = rate(t + step / 2, x + step / 2 * two)
        x = x + step / 6 * (one + 2 * two + 2 * three + rate(t + step, x + step * three))
        if k >= (periods - 1) * steps:
            peak = np.maximum(peak, np.abs(x @ C[0]))
    return peak


ROOTED = ExpressionNonlinearity("sigma/(1 + sigma**2)**0.5")
BENT = PiecewiseLinear([(-1, F(-1, 2)), (0, 0), (2, 2)], left_slope=F(1, 4), right_slope=F(1, 2))


@pytest.mark.slow
@pytest.mark.parametrize("phi", [BENT, pytest.param(ROOTED, marks=pytest.mark.thorough)])
def test_simulations_from_any_start_end_inside_the_band(phi):
    wave = (1.25, 2.0, 0.5)
    found = steady_response(RESONANT, phi, {"amplitude": 2, "constant": F(1, 2), "omega": F(5, 4)}).response[0]
    assert found.amplitude.width < 5e-3 * found.amplitude.low
    peaks = simulated(phi, wave, np.random.default_rng(1).normal(0, 10, (20, 2)))
    assert (found.amplitude.low - 3e-4 <= peaks).all()
    assert (peaks <= found.amplitude.high + 1e-4).all()


# x' = -x - phi + w: differences decay like exp(-(1 + g) t), g between the slopes, so that 1 + l is the rate
@pytest.mark.parametrize(("slopes", "rate"), [((0, 1), 1), ((F(-1, 2), 1), F(1, 2)), ((2, 5), 3)])
def test_the_rate_of_attraction_is_that_of_the_slowest_gain(slopes, rate):
    found = steady_response(([1], [1, 1]), SlopeBounds(*slopes))
    assert found.verdict is Verdict.PROVED
    assert found.rate.low == pytest.approx(float(rate), rel=1e-5)
    assert found.rate.low <= rate <= found.rate.high
    assert recheck(json.loads(json.dumps(found.certificates["low"]))).accepted


# 1/(s (s + 1)) has a pole at 0: with phi = 0 nothing attracts; 1/(s - 1) is stable for gains above 1
@pytest.mark.parametrize(
    ("plant", "slopes", "verdict"),
    [
        (([1], [1, 1, 0]), (0, 1), Verdict.REFUTED),
        (([1], [1, 1, 0]), (F(1, 10), F(1, 2)), Verdict.PROVED),
        (([1], [1, -1]), (2, 3), Verdict.PROVED),
        (([1], [1, -1]), (F(1, 2), 3), Verdict.REFUTED),
    ],
)
def test_poles_on_the_axis_and_beyond(plant, slopes, verdict):
    assert steady_response(plant, SlopeBounds(*slopes)).verdict is verdict


def test_a_constant_gain_says_nothing_against_a_saturation():
    found = steady_response(([1], [1, 1, 0]), Saturation())
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.refutation is None
    assert "with phi = 0" in found.reason


def test_popov_proves_stability_where_nothing_is_proved_of_differences():
    found = steady_response(([1], [1, F(1, 5), 1]), SlopeBounds(0, 10))  # Popov's criterion: every slope
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.rate.low < 0  # how fast a difference may grow


@pytest.mark.parametrize(
    ("given", "forcing", "message"),
    [
        (SlopeBounds(0, math.inf), None, "give finite ones"),
        (Saturation(), {"omega": 1}, "neither amplitude nor constant"),
        (Saturation(), {"amplitude": 1, "omega": -1}, "omega is -1"),
        (Saturation(), {"amplitude": [1, 2], "omega": 1}, "2 entries"),
        (Saturation(), {"amplitude": 1, "frequency": 1}, "'frequency'"),
    ],
)
def test_bad_input_is_one_sentence(given, forcing, message):
    with pytest.raises(InputError, match=message):
        steady_response(RESONANT, given, forcing)


@pytest.mark.slow
def test_the_command_tells_the_same_as_json(tmp_path, capsys):
    (tmp_path / "a.toml").write_text(FILE)
    certificate, figure = tmp_path / "rate.json", tmp_path / "a.svg"
    files = ["-o", str(certificate), "--plot", str(figure), "--csv", str(tmp_path / "curve.csv")]
    status = main(["steady", str(tmp_path / "a.toml"), "--json", "-q", *files])
    data = json.loads(capsys.readouterr().out)
    assert status == 0  # the class says nothing of slopes, the nonlinearity does
    assert data["verdict"] == "PROVED"
    low, high = data["response"][0]["amplitude"]
    assert 2.68 < low < 2.69 < high < 2.7
    assert recheck(json.loads(certificate.read_text())).accepted
    head, *rows = (line.split(",") for line in (tmp_path / "curve.csv").read_text().splitlines())
    assert head[:3] == ["omega [rad/s]", "at least [mm]", "at most [mm]"]
    assert [list(map(float, row[:3])) for row in rows] == [
        [one["omega"], *one["amplitude"]] for one in data["response"]
    ]
    assert "[mm]" in figure.read_text()
    assert main(["steady", str(tmp_path / "a.toml"), "--omega", "0:1"]) == 2
    assert "--omega is '0:1'" in capsys.readouterr().err


# Duffing x'' + x'/10 + x + x^3/25 = cos(1.3 t): by one harmonic A^2 ((1 + 3 A^2/100 - 1.69)^2 + 0.0169) = 1 has three
# roots, the middle one unstable (Kovacic, Brennan, The Duffing Equation, 2011, chapter 5)
@pytest.mark.slow
def test_a_duffing_equation_jumps_between_two_certified_responses():
    roots = np.sqrt(sorted(np.roots([9e-4, -0.0414, 0.69**2 + 0.0169, -1]).real))
    found = steady_response(([1], [1, F(1, 10), 1]), Cubic(cubic=F(1, 25)), {"amplitude": 1, "omega": F(13, 10)})
    assert found.verdict is Verdict.REFUTED
    assert [row.computed for row in found.response] == pytest.approx(roots, rel=0.02)
    assert [row.multiplier < 1 for row in found.response] == [True, False, True]
    for row in found.response:
        assert row.evidence is Evidence.CERTIFIED
        assert row.amplitude.width < 1e-9
        assert not row.alone
    assert "another of 5.31929" in str(found)


# x'' + 2 x' + x^3 = f: without a gain the linear part has the pole 0, a multiple of the frequency of any input.  At the
# end of each period of 2 pi/3 the simulation has the same peak.
@pytest.mark.slow
def test_a_linear_part_that_resonates_with_the_input_is_taken_around_another_gain(monkeypatch):
    monkeypatch.setattr(balance, "_STARTS", 2)
    monkeypatch.setattr(balance, "_RANDOM", 0)
    found = steady_response(([1], [1, 2, 0]), Cubic(), {"amplitude": 9, "omega": 3})
    (row,) = found.response
    assert row.evidence is Evidence.CERTIFIED
    x, v, step, peak = 0.0, 0.0, 1e-3, 0.0
    for k in range(20_000):  # by the midpoint rule
        w = 9 * math.sin(3 * (k + 0.5) * step)
        middle = x + step / 2 * v, v + step / 2 * (w - 2 * v - x**3)
        x, v = x + step * middle[1], v + step * (w - 2 * middle[1] - middle[0] ** 3)
        peak = max(peak, abs(x)) if k > 17_800 else 0.0
    assert row.amplitude.low - 1e-5 < peak < row.amplitude.high + 1e-5


# without friction sum |G(i k omega)|^2 has no Gramian; with a little both ways agree
def test_harmonics_are_summed_where_the_linear_part_keeps_its_energy():
    for friction, gramian in ((F(1, 100), True), (0, False)):
        loop = ForcedLoop.around(channel_plant(([1, 1], [1, friction, 1])), None, [Cubic()], [(F(0), F(0))])
        omega, whole = F(3, 2), np.arange(1, 200_000) * 1.5
        sizes = np.abs((1j * whole + 1) / (1 - whole**2 + 1j * float(friction) * whole)) ** 2
        truth = math.sqrt(1 + 2 * sizes.sum())
        summed = float(loop._summed(omega)[0])
        assert truth < summed < 1.002 * truth
        assert float(loop.smoothing(omega)[0]) == pytest.approx(truth if gramian else summed, rel=1e-5)


def test_a_solution_that_keeps_its_distance_from_others_is_not_said_to_attract():
    given = {"omega": 1.0, "amplitude": Bracket(1.0, 1.1), "sigma": (), "computed": 1.05, "error": 0.1, "harmonics": 8}
    one = SteadyPoint(**given, residual=0.0, evidence=Evidence.CERTIFIED, multiplier=1 - 1e-12)
    assert not one.attracts
    assert "neither attracts nor repels" in str(one)


def test_a_solution_of_one_period_found_over_three_is_one_of_one_period():
    psi = np.array([[0.5, 0, 0, 1 + 1j, 0, 0, 0.25]], complex)
    wave = Wave((F(0),), (F(1),), F(1), periods=3)
    short = _shortened(Balanced(wave, psi, 0.0, 0.0, 0.0))
    assert (short.wave.periods, short.psi.tolist()) == (1, [[0.5, 1 + 1j, 0.25]])
    psi[0, 1] = 0.1
    assert _shortened(Balanced(wave, psi, 0.0, 0.0, 0.0)).wave.periods == 3


# with phi = -2 sigma the loop is 1/(s^2 + s/2.5 - 1), which has a root on the right: e^(0.8 t) and no faster
def test_the_certificate_is_of_the_answer_and_of_no_growth_bound(tmp_path, capsys):
    file, kept = tmp_path / "a.toml", tmp_path / "kept.json"
    file.write_text("[plant]\nnum = [1]\nden = [1, 0.4, 1]\n[class]\nslope = [-2, 0]\n")
    assert main(["steady", str(file), "-o", str(kept)]) == 11
    assert "the member whose differences do not decay" in " ".join(capsys.readouterr().out.split())
    written = json.loads(kept.read_text())
    assert written["verdict"] == "REFUTED"
    assert recheck(written).accepted
    file.write_text("[plant]\nnum = [1]\nden = [1, 0.2, 1]\n[class]\nslope = [0, 10]\n")  # a growth bound is known
    assert main(["steady", str(file), "-o", str(tmp_path / "none.json")]) == 10
    assert "There is no certificate of the answer" in " ".join(capsys.readouterr().out.split())
    assert not (tmp_path / "none.json").exists()


# max(0, s)/2, slopes in [0, 1/2], known to no ball where sigma passes 0
@pytest.mark.slow
def test_an_amplitude_that_is_not_enclosed_leaves_convergence_proved(tmp_path, capsys):
    file = tmp_path / "a.toml"
    law = 'kind = "normal compliance"\nstiffness = 0.5\nexponent = 1'
    file.write_text(
        f"[plant]\nnum = [1]\nden = [1, 1.2, 1]\n[nonlinearity]\n{law}\n"
        "[forcing]\namplitude = 2\nomega = [0.5, 1, 1.5]\n"
    )
    assert main(["steady", str(file), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["verdict"] == "PROVED"
    assert [row["evidence"] for row in data["response"]] == ["computed"] * 3
    assert [row["amplitude"] for row in data["response"]] == [[0, None]] * 3
    assert data["reason"] == "phi has no slope that is known everywhere on the way of sigma at 0.5, 1, 1.5 rad/s"
    assert main(["steady", str(file)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(f"At {omega} rad/s the amplitude of z is about" in said for omega in ("0.5", "1", "1.5"))


@pytest.mark.slow
def test_more_than_twelve_frequencies_are_counted_and_one_channel_has_no_number():
    found = steady_response(([1], [1, 1]), Saturation(), {"amplitude": F(1, 2), "omega": list(range(1, 14))})
    assert "12 more responses are in --json alone" in str(found)  # that at 1 rad/s is the largest and the first
    with pytest.raises(InputError, match=r"^the class has the bounds"):
        steady_response(RESONANT, SlopeBounds(0, math.inf))


@pytest.mark.thorough
def test_a_gap_has_two_attracting_responses():
    found = steady_response(([1], [1, F(1, 10), 1]), DeadZone(gain=5), {"amplitude": 1, "omega": F(8, 5)})
    small, unstable, large = found.response
    assert small.amplitude.low <= 1 / math.hypot(1 - 2.56, 0.16) <= small.amplitude.high  # inside the gap it is linear
    assert small.multiplier < 1 < unstable.multiplier
    assert large.multiplier < 1
    assert found.verdict is Verdict.REFUTED
    assert 2.1 < large.amplitude.low < large.amplitude.high < 2.103


# x'' + x'/20 + x + x^3 = 5 cos 6t: a third of the frequency is locked in, about where 1 + 3/4 (A^2 + 2 F^2) = 4
@pytest.mark.thorough
def test_a_subharmonic_refutes_by_itself():
    found = steady_response(([1], [1, F(1, 20), 1]), Cubic(), {"amplitude": 5, "omega": 6})
    assert found.verdict is Verdict.REFUTED
    assert [row.periods for row in found.response if row.evidence is Evidence.CERTIFIED] == [1, 3]


# 10 tanh has two steady responses to 3 sin 2t, of amplitudes .458 and 5.03, while every constant gain up to 10 has one;
# and sigma + sin(5 sigma)/2 has slopes up to 3.5, so that a band for slopes up to 1 holds it not
@pytest.mark.parametrize(
    ("formula", "stated", "words"),
    [
        ("10*tanh(sigma)", NonlinearityClass.constant_gain(0, 10), "is given beside it"),
        ("10*tanh(sigma)", NonlinearityClass.varying_gain(0, 10, rate=1), "is given beside it"),
        ("tanh(sigma)", NonlinearityClass.relu(), "is given beside it"),
        ("sigma + sin(5*sigma)/2", NonlinearityClass.slope_restricted(0, 1), "is asked about in a class with"),
    ],
)
@pytest.mark.parametrize("ask", [steady_response, l2_gain, overshoot, certify])
def test_a_nonlinearity_outside_of_the_class_beside_it_is_refused(formula, stated, words, ask):
    block = as_plant(([[0, 1], [-1, F(-1, 10)]], [0, 1], [1, 0], 0))
    given = {"block": block, "nonlinearity": ExpressionNonlinearity(formula), "nonlinearity_class": stated}
    forced = {"forcing": {"amplitude": 3, "omega": 2}} if ask is steady_response else {}
    with pytest.raises(InputError, match=words):
        ask(LoopSystem(name="", title="", source="", **given), **forced)


def test_a_root_that_has_no_slope_at_0_is_left_open():
    found = steady_response(RESONANT, ExpressionNonlinearity("sign(sigma)*abs(sigma)**0.5"), {"constant": 1})
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "not bounded" in found.reason


@pytest.mark.thorough
def test_no_second_response_is_invented():  # slopes are not bounded, so that nothing is proved either
    found = steady_response(([1], [1, 1, 1]), Cubic(), {"amplitude": F(1, 10), "omega": 1})
    assert found.verdict is Verdict.INCONCLUSIVE
    assert len(found.response) == 1
    assert "not bounded" in found.reason


def test_the_residual_of_harmonics_is_enclosed():  # of sat on 2 sin, with what one harmonic misses in closed form
    loop = ForcedLoop.around(channel_plant(RESONANT), None, [Saturation()], [(F(0), F(0))])
    wave = Wave((F(0),), (F(2),), F(1))  # H(i) = -i: sigma = 2 sin(t - pi/2) without psi
    psi = np.zeros((1, 2), complex)
    found = residual(loop, Balanced(wave, psi, 0.0, 0.0, 0.0))
    angle = math.asin(1 / 2)  # the mean of min(|2 sin|, 1)^2 is (2/pi) (4 (angle/2 - sin(2 angle)/4) + pi/2 - angle)
    truth = math.sqrt(2 / math.pi * (4 * (angle / 2 - math.sin(2 * angle) / 4) + math.pi / 2 - angle))
    assert truth <= float(found.mean) <= truth * (1 + 1e-3)
    assert 1 <= float(found.largest) <= 1.01
    first = abs(2 * (angle - math.sin(angle) * math.cos(angle)) + 2 * math.cos(angle)) * 2 / math.pi / 2
    assert first <= float(found.low[0][1]) <= first * (1 + 1e-3)

"""The number c beside a rate: exact cases, members that are simulated, and what is refused."""

import json
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lure import AssumptionError, InputError, NonlinearityClass, RationalPlant, Sector, SlopeBounds, as_plant
from lure.analysis.certificates.second import recheck
from lure.analysis.questions.energy import _spread, overshoot
from lure.files import parse_system

F = Fraction
VARYING = NonlinearityClass(sector=Sector(0, F(1, 2)), time_varying=True)
OSCILLATOR = ([[0, 1], [-1, -1]], [[0], [1]], [[1, 0]], [[0]])


def test_one_state_goes_nowhere_before_it_decays():
    # x' = -x - phi(x): |x(t)| <= |x(0)| e^-t, and P is a number
    found = overshoot(([[-1]], [[1]], [[1]], [[0]]), [VARYING], F(1, 2))
    assert 1 <= found.constant <= 1 + 1e-8
    assert recheck(dict(found.proof.certificate)).accepted


def test_what_is_assumed_of_the_nonlinearity_is_said():
    # y = sigma - phi(sigma)/2 has one sigma for each y for slopes below 2, which a sector does not bound
    direct = ([[-2]], [[1]], [[1]], [[F(-1, 2)]])
    found = overshoot(direct, [Sector(0, 1)], F(1, 2))
    assert found.assumed == found.to_dict()["assumed"] == "for which " + found.proof.assumed
    assert f"in the sector [0, 1], {found.assumed} (diagonal-circle" in str(found)
    assert overshoot(direct, [SlopeBounds(0, 1)], F(1, 2)).assumed == ""


@pytest.mark.parametrize(("computed", "square"), [((1, 4), 4), ((2, 4), None), ((1, 2), None), ((-1, 4), None)])
def test_eigenvalues_in_floating_point_are_not_believed(monkeypatch, computed, square):
    # 1 and 4 are those of the matrix: what is computed beside it gives no c, and no smaller one
    monkeypatch.setattr(np.linalg, "eigvalsh", lambda _: np.array(computed, dtype=float))
    shown = SimpleNamespace(certificate={"proof": {"P": [["1"], ["0", "4"]]}})
    found = _spread(shown)
    assert found is None if square is None else square < found < square * (1 + 1e-8)


def test_no_member_that_jumps_goes_farther():
    found = overshoot(OSCILLATOR, [VARYING], F(1, 4))
    A, B, C = (np.array(side, dtype=float) for side in OSCILLATOR[:3])
    random, h, farthest = np.random.default_rng(5), 0.02, 0.0
    x = random.normal(size=(400, 2))
    x /= np.linalg.norm(x, axis=1)[:, None]
    for step in range(300):
        if step % 13 == 0:
            gains = np.where(random.random(400) < 0.5, 0, 0.5)

        def rate(x, gains=gains):
            return x @ A.T - (gains * (x @ C[0]))[:, None] * B[:, 0]

        middle = rate(x + h / 2 * rate(x))
        x = x + h * middle
        farthest = max(farthest, np.linalg.norm(x, axis=1).max() * np.exp(0.25 * (step + 1) * h))
    assert 1.1 < farthest < found.constant


# xi+ = A xi/r with a normal A = a 1, so that every P > 0 serves where |a| < r; the one that is found has a c >= 1
@settings(max_examples=10, deadline=None)
@given(st.fractions(F(1, 10), F(1, 2), max_denominator=20), st.fractions(F(3, 5), F(9, 10), max_denominator=20))
def test_in_discrete_time_powers_stay_below(a, r):
    A = np.array([[float(a), 0.3], [0.0, float(a)]])
    plant = as_plant(([[a, F(3, 10)], [0, a]], [[0], [F(1, 100)]], [[1, 0]], [[0]]), dt=1)
    try:
        found = overshoot(plant, [VARYING], r)
    except AssumptionError:
        return
    powers = [np.linalg.norm(np.linalg.matrix_power(A, t), 2) / float(r) ** t for t in range(40)]
    assert max(powers) <= found.constant
    assert "^t (t in samples) for phi" in str(found)


def test_a_rate_that_is_not_true_or_a_loop_without_states_is_refused():
    with pytest.raises(AssumptionError, match="no quadratic function shows the rate"):
        overshoot(OSCILLATOR, [VARYING], 0.45)  # a gain that jumps decays like .4201
    for wrong in (0, float("nan")):
        with pytest.raises(InputError, match="rate is"):
            overshoot(as_plant(([[0]], [[1]], [[1]], [[0]]), dt=1), [VARYING], wrong)
    with pytest.raises(InputError, match="about states, and the plant is given without"):
        overshoot(RationalPlant([1], [1, 1]), [VARYING], F(1, 2))


def test_a_nonlinearity_stands_for_its_class():
    A, B, C, _ = OSCILLATOR
    text = f"[plant]\nA = {A}\nB = {B}\nC = {C}\n[nonlinearity]\nkind = 'saturation'\nslope = 0.25\nlimit = 1\n"
    loop = parse_system(text, name="loop", source="loop.toml")
    found, same = (
        overshoot(loop, rate=F(1, 8)),
        overshoot(OSCILLATOR, [NonlinearityClass.slope_restricted(0, F(1, 4), odd=True)], F(1, 8)),
    )
    assert (found.constant, str(found)) == (same.constant, str(same))


@pytest.mark.slow
def test_the_command_says_it_at_nine_tenths_of_the_rate(lure, tmp_path):
    (tmp_path / "loop.toml").write_text(
        "[plant]\nA = [[0, 1], [-1, -1]]\nB = [[0], [1]]\nC = [[1, 0]]\n"
        "[class]\nsector = [0, 0.5]\ntime_varying = true\n"
    )
    status, out, _ = lure("rate", "loop.toml", "--constant", "--json")
    data = json.loads(out)
    assert status == 0
    assert F(data["constant"]["rate"]) == pytest.approx(0.9 * data["rate"][0], rel=1e-5)
    assert 1 < data["constant"]["constant"] < 4
    loop = (tmp_path / "loop.toml").read_text()  # of the rate by Popov's criterion no quadratic function shows .9
    (tmp_path / "still.toml").write_text(loop.replace("0.5]", "1]").replace("time_varying = true", ""))
    data = json.loads(lure("rate", "still.toml", "--constant", "--json")[1])
    assert F(data["constant"]["rate"]) == pytest.approx(0.5 * data["rate"][0], rel=1e-5)
    (tmp_path / "bare.toml").write_text("[plant]\nnum = [1]\nden = [1, 1]\n[class]\nsector = [0, 0.5]\n")
    assert lure("rate", "bare.toml", "--constant")[2].startswith("lure: the number c is about states")

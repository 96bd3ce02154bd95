"""`analyse` on several channels: the same sections as for one, and with two the map of their upper bounds."""

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from lure import (
    InputError,
    NonlinearityClass,
    Saturation,
    Sector,
    SlopeBounds,
    analyse,
    as_plant,
    builtin_loop,
    certify,
    report,
)
from lure.analysis import Verdict
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.plots.regions import plot_map
from lure.analysis.questions import channel_map
from lure.analysis.questions.channel_kinds import kind_name
from lure.analysis.questions.channel_problem import channel_problem

# sigma_1 = mu_2/(s+1), sigma_2 = -mu_1/(s+1)^2: det(1 + H G) = 1 + g_1 g_2/(s+1)^3, stable for 0 <= g_1 g_2 < 8, which
# Popov's criterion proves (Arcak and Sontag); with bounds of 2 the factor sqrt(2)
RING = builtin_loop("secant-ring")


@pytest.fixture(scope="module")
def found():
    return analyse(RING)


@pytest.mark.slow
def test_the_classes_asked_about_and_every_factor_of_them(found):
    assert found.verdict is Verdict.PROVED
    assert "phi_1, time-invariant, in the sector [0, 2]; phi_2" in found.statement
    assert found.asked.classes == RING.classes
    assert [kind_name(row.classes) for row in found.rows][-1] == "sector, time-varying"
    for row in found.rows[:3]:
        assert row.closed
        assert row.largest.low == pytest.approx(2**0.5, rel=1e-6)
        assert row.largest.low < 2**0.5 < row.refuted_at
    assert found.rows[-1].largest.low < 1.3  # the circle criterion
    assert all(recheck(dict(one.certificate)).accepted for one in found.certificates)


@pytest.mark.slow
def test_the_map_is_a_staircase_below_and_above_the_hyperbola(found):
    assert len(found.map.proved) == len(found.map.refuted) == 7
    for k1, k2 in found.map.proved:
        assert 8 * (1 - 1e-5) < k1 * k2 < 8
        assert found.map.verdict(0.999 * k1, 0.999 * k2) is Verdict.PROVED
    for k1, k2 in found.map.refuted:
        assert 8 < k1 * k2 < 8 * (1 + 1e-5)
        assert found.map.verdict(k1, 2 * k2) is Verdict.REFUTED
    (a, b), (c, d) = found.map.proved[:2]
    assert found.map.verdict((a + c) / 2, (b + d) / 2) is Verdict.INCONCLUSIVE
    with pytest.raises(InputError, match="no upper bounds above the lower ones"):
        found.map.verdict(0, 1)
    data = found.map.to_xarray()
    assert data.sizes == {"ray": 7}
    assert float(data.proved_k1[0] * data.proved_k2[0]) == pytest.approx(8, rel=1e-5)


def test_the_map_is_drawn_and_marks_what_was_asked(found):
    axes = plot_map(found.map, ax=Figure().add_subplot())
    labels = axes.get_legend_handles_labels()[1]
    assert labels == ["proved", "open", "refuted", "asked about"]
    assert axes.get_xlim()[0] == 0


def test_the_text_and_the_data(found):
    text = str(found)
    assert text.startswith("PROVED  secant-ring: 3 states, 2 inputs and 2 outputs")
    assert "The numbers are factors of every upper bound of: phi_1 in the sector [0, 2]" in text
    assert max(map(len, text.split("\n"))) <= 100
    data = json.loads(json.dumps(found.to_dict()))
    assert [one["class"]["sector"] for one in data["channels"]] == [[0, 2], [0, 2]]
    assert data["repeated"] == [1, 1]
    assert len(data["map"]["rays"]) == 7
    assert data["answers"][0]["classes"]["repeated"] is False


@pytest.mark.slow
def test_without_a_class_the_largest_slope_in_every_channel(monkeypatch):
    monkeypatch.setattr(channel_map, "_DIRECTIONS", (0.0,))
    alone = analyse(as_plant([["1/(s+1)^2", "0"], ["0", "1/(s+2)"]]))
    assert alone.asked is None
    assert alone.problem.kind == "slope"
    assert alone.verdict is Verdict.PROVED  # both parts are stable for every slope
    assert "the largest k tried" in str(alone)


def test_nonlinearities_that_are_known_are_members_of_their_classes():
    plant = RING.block
    known = certify(plant, [Saturation(gain=1, limit=1), "2*tanh(sigma)"])
    assert known.verdict is Verdict.PROVED
    assert known.conclusion.membership == "checked"
    assert "phi_2 = 2*tanh(sigma)" in known.conclusion.headline
    assert certify(plant, [Saturation(gain=3, limit=1), "3*tanh(sigma)"]).verdict is Verdict.REFUTED
    same = channel_problem(plant, [Saturation(gain=1, limit=1), Saturation(gain=1, limit=1)])
    assert same.classes.repeated  # equal ones are one nonlinearity
    with pytest.raises(InputError, match=r"channel 2: .*locally Lipschitz"):
        certify(plant, [Saturation(gain=1, limit=1), "sign(sigma)*min(abs(sigma), 1)**(1/2)"])


def test_classes_beside_a_loop_that_has_its_own_are_refused():
    with pytest.raises(InputError, match="closes the loop itself"):
        analyse(RING, [Sector(0, 1), Sector(0, 1)])
    with pytest.raises(InputError, match="no class of nonlinearities is given"):
        certify(RING.block)


@pytest.mark.slow
def test_the_report_has_the_channels_and_the_map(found, tmp_path, monkeypatch):
    from lure.analysis.report.loop import write

    monkeypatch.setattr(write, "analyse", lambda *_args, **_options: found)
    report(RING, output=tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text()
    assert "<h2>The channels</h2>" in page
    assert "The upper bounds k₁ and k₂ of the two channels" in page
    assert "μᵢ = −φᵢ(σᵢ), 2 channels" in page
    assert (tmp_path / "out" / "figures" / "map.svg").exists()
    data = json.loads((tmp_path / "out" / "report.json").read_text())
    assert data["system"]["map"]["rays"][0]["criterion"] == "diagonal-popov"
    assert len(data["certificates"]) == len(list((tmp_path / "out" / "certificates").iterdir()))


def test_slopes_are_asked_of_classes_with_slopes():
    assert channel_problem(RING.block, [SlopeBounds(0, 1)] * 2, kind="slope").question == "slope"


def test_gains_that_jump_refute_where_all_of_them_are_members():
    class Shown:
        def __init__(self, gains):
            self.certificate = {"proof": {"gains": gains}}

    class Found:
        proof, criterion = None, ""
        refutation = Shown([["1", "1/2"], ["0", "3"]])

    ray = channel_map._ray((1, 2), Found, RING.classes)
    assert (ray.refuted_k1, ray.refuted_k2) == (1, 3)
    Found.refutation = Shown(["2", "0"])
    assert channel_map._ray((1, 2), Found, RING.classes).refuted_k1 == 2


# every linear gain is stable, and tanh makes the loop oscillate (Fitts): a class of constant gains is not one of slopes
def test_a_class_of_constant_gains_in_one_channel_is_decided_by_root_counts():
    gains = NonlinearityClass.constant_gain
    assert certify(builtin_loop("kalman-fitts").block, gains(0, 5)).verdict is Verdict.PROVED
    assert analyse("1/(s+2)", gains(0, 7)).shown.theorem == "hurwitz"
    assert certify("1/(s+1)^3", NonlinearityClass.constant_gain(0, 8)).verdict is Verdict.REFUTED
    delayed = certify("exp(-s)/(s+1)", NonlinearityClass.constant_gain(0, 1))
    assert delayed.verdict is Verdict.PROVED  # by a criterion for sectors
    with pytest.raises(InputError, match="constant gains that are not odd"):
        NonlinearityClass(sector=Sector(0, 1), linear=True)


@pytest.mark.slow
def test_the_map_of_a_delay_begins_at_no_delay(monkeypatch):
    # channel 2 alone: 1 + 4 e^(-tau s)/(s + 1), |4/(i w + 1)| = 1 at w = sqrt(15): unstable from
    # tau = (pi - atan(sqrt(15)))/sqrt(15) on; channel 1 is stable for every bound
    monkeypatch.setattr(channel_map, "_DIRECTIONS", (0.0,))
    plant = as_plant([["1/(s+1)", "0"], ["0", "4/(s+1)"]])
    map_ = analyse(plant, [SlopeBounds(0, 1), NonlinearityClass.delayed(0.2)]).map
    limit = (np.pi - np.arctan(15**0.5)) / 15**0.5
    assert map_.lower == (0, 0)
    assert [ray.proved_k2 < limit for ray in map_.rays] == [True]
    assert [ray.refuted_k2 == pytest.approx(limit, rel=1e-3) and ray.refuted_k2 > limit for ray in map_.rays] == [True]
    axes = plot_map(map_, ax=Figure().add_subplot())
    assert axes.get_ylim()[0] == 0 < axes.get_ylim()[1]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("k₁, upper bound in channel 1", "delay bound in channel 2 [s]")

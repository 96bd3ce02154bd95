"""One nonlinearity around a plant with dead time, its class beginning above 0, or below, or where nothing is stable."""

import math
from dataclasses import replace
from fractions import Fraction
from functools import partial

import numpy as np
import pytest

from lure import NonlinearityClass, Sector, SlopeBounds
from lure.analysis import analyse, certify, check, max_sector, max_slope
from lure.analysis.certificates.second import recheck
from lure.analysis.counterexamples.channel_gains import LateGains
from lure.analysis.questions.conclusion import MismatchError
from lure.analysis.verdict import Verdict
from lure.errors import InputError

# exp(-s/5)/(s - 1): a root i w with the gain k has k cos(w/5) = 1 and w = k sin(w/5), so w = tan(w/5), first at 7.15971
_ENDS = {"exp(-s)/s": (Fraction(1, 2), math.pi / 2), "exp(-s/5)/(s-1)": (2, 7.22965), "exp(-s)/(s+1)": (-0.5, 2.261826)}


@pytest.mark.parametrize("question", [max_sector, pytest.param(partial(max_slope, odd=True), marks=pytest.mark.slow)])
@pytest.mark.slow_for("exp(-s/5)/(s-1)", "exp(-s)/(s+1)")
@pytest.mark.parametrize("plant", _ENDS)
def test_sectors_and_slopes_end_at_the_linear_gain(plant, question):
    lower, end = _ENDS[plant]
    found = question(plant, lower=lower)
    assert found.verdict is Verdict.PROVED
    assert end * (1 - 2e-5) < found.largest.low < end * (1 + 1e-6) < found.refuted_at * (1 + 2e-6) < end * (1 + 2e-5)
    assert found.lower == Fraction(lower)
    assert found.classes is None
    assert found.meaning.startswith("The point 0 attracts every solution")
    for shown in (found.proof, found.refutation):
        assert check(shown.certificate)
        assert recheck(shown.certificate).accepted


@pytest.mark.slow_for("exp(-s)/(s + exp", "exp(-s)/(s - 1")
@pytest.mark.parametrize(
    ("plant", "lower", "end"),
    [
        ("exp(-s)/(s + exp(-s))", 0, math.pi / 2 - 1),  # exp(-s)/s with one more
        ("-1/(s + 1 + exp(-s)/2)", 0, 1.5),  # s + 1 + exp(-s)/2 - k is 0 at 0
        ("(0.4*s - 0.3)/(s^2 + 2.3*s + 2.2 - 1.5*(s + 1)*exp(-s/10))", 1, 7 / 3),  # 0.7 - 0.3 k at 0
        # 1 - 2 cos(w/10) = k cos(w), w - 2 sin(w/10) = k sin(w): w = 2.0897011 and k = 1.9286822513
        ("exp(-s)/(s - 1 + 2*exp(-s/10))", 0, 1.9286822513),
        ("exp(-s)/(s - 1)/(1 + 2*exp(-s/10)/(s - 1))", 0, 1.9286822513),
    ],
)
def test_delays_in_the_denominator_end_at_the_linear_gain(plant, lower, end):
    found = max_sector(plant, lower=lower)
    assert found.verdict is Verdict.PROVED
    assert end * (1 - 3e-5) < found.largest.low < end < found.refuted_at * (1 + 1e-10) < end * (1 + 3e-5)
    (best,) = (one for one in found.answers if one.proof is found.proof)  # of a criterion, in k and not in factors
    assert best.largest.low == pytest.approx(found.largest.low, rel=1e-12)
    if lower:
        said = float(best.reason.removeprefix("proved up to "))  # rounded down
        assert found.largest.low - 1e-6 * end < said <= found.largest.low
    for shown in (found.proof, found.refutation):
        assert check(shown.certificate)
        assert recheck(shown.certificate).accepted


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "end"),
    [
        # w + arctan(w) = pi + arctan(w/2) and k^2 = (1 + w^2)/(4 + w^2): w = 2.8683; 1 + k exp(-s) far out
        ("(s + 2)*exp(-s)/(s + 1)", 0.8686926736),
        # 3 w^2/4 + 1 = k^2 and w cos(w) + sin(w) + w/2 = 0: w = 2.4407
        pytest.param("exp(-s)/(s + 1 + s*exp(-s)/2)", 2.338295859, marks=pytest.mark.slow),
    ],
)
def test_neutral_equations_end_at_the_linear_gain(text, end):
    found = max_sector(text)
    assert found.verdict is Verdict.PROVED
    assert end * (1 - 4e-3) < found.largest.low < end < found.refuted_at < end * (1 + 2e-5)
    for shown in (found.proof, found.refutation):
        assert check(shown.certificate)
        assert recheck(shown.certificate).accepted


def test_a_neutral_equation_of_which_nothing_is_proved_is_not_refuted_by_a_gain_far_above_0():
    # stable, as 1 + .6 z + .6 z^2 has zeros with |z| > 1, and .6 + .6 > 1 proves nothing; the gain k puts a root at
    # i w where w (.6 + 1.6 cos w) + sin w = 0 and k = .4 w sin w - cos w: w = 2.21505, k = 1.309017
    found = max_sector("exp(-s)/(s + 1 + 0.6*s*exp(-s) + 0.6*s*exp(-2*s))")
    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.refuted_at == pytest.approx(1.309017, rel=1e-6)


@pytest.mark.slow
def test_a_plant_whose_poles_are_not_counted_is_not_refuted_by_a_gain_above_0():
    # next to 2i a root lies e exp(-2i)/(4i (1 + 2i)) to the left, e = 10^-12, so that the plant is stable, and with
    # gains below e it stays so; the count does not tell the root from one on the axis
    found = max_sector("exp(-s)/((s^2 + 4)*(s + 1) - exp(-s)/10^12)")
    assert (found.verdict, found.reason.endswith("on the axis, or near it")) == (Verdict.INCONCLUSIVE, True)
    assert found.refuted_at == pytest.approx(1e-6)


@pytest.mark.slow_for("-1/2 - 2/3/(s + 3 - exp(-s))")
@pytest.mark.parametrize("text", ["-1/2 - exp(-s)/(s + 3)", "-1/2 - 2/3/(s + 3 - exp(-s))"])
def test_a_direct_term_without_dead_time_needs_slopes(text):
    # H(0) = -1/2 - 1/3, and Re H is least there: the gain 6/5 puts a root at 0
    found = max_slope(text)
    assert found.largest.low == pytest.approx(1.2, rel=1e-4)
    assert found.refuted_at == pytest.approx(1.2, rel=1e-4)
    assert recheck(found.proof.certificate).accepted
    assert max_sector(text).verdict is not Verdict.PROVED


@pytest.mark.slow
def test_an_unstable_delay_in_the_denominator_is_refuted_and_a_gain_of_the_class_helps():
    # s + 2 exp(-s): 2 > pi/2; 1/(s - 1 + exp(-s)/2): s - 1/2 at 0
    for plant in ("1/(s + 2*exp(-s))", "1/(s - 1 + exp(-s)/2)"):
        assert max_sector(plant).verdict is Verdict.REFUTED
        assert certify(plant, SlopeBounds(0, 1)).verdict is Verdict.REFUTED
    assert max_sector("1/(s + 2*exp(-s))", lower=3).largest.low > 100  # |i w + 3| > 2
    endless = certify("1/(s + 1 + exp(-s)/2)", Sector(0, math.inf))
    assert endless.verdict is Verdict.INCONCLUSIVE
    assert analyse("1/(s + 1 + exp(-s)/2)").case == "stable"


def test_a_pole_at_0_with_a_residue_below_0_is_answered():
    text = "(1.25*s^2 + 2*s + 1)*exp(-s)/(s^3 + 3.5*s^2 + 3.25*s - 1.5 + (1.5 - 0.75*s^2 - 0.25*s)*exp(-2*s))"
    assert max_sector(text.replace("(1.25", "-(1.25")).verdict is not Verdict.PROVED


@pytest.mark.slow
def test_a_sector_that_varies_with_time_ends_where_the_circle_criterion_does():
    found, omega = max_sector("exp(-s)/s", lower=0.5, time_varying=True), np.linspace(1e-3, 50, 200_000)
    H = np.exp(-1j * omega) / (1j * omega)

    def least(k: float) -> float:
        return float(((1 + k * H) * np.conj(1 + H / 2)).real.min())

    assert least(found.largest.low) > 0 > least(found.largest.low * 1.001)
    assert found.criterion == "piecewise-circle"


@pytest.mark.slow
def test_one_class_is_decided_as_far_and_analysed():
    assert certify("exp(-s)/s", Sector(0.5, 1.5707)).verdict is Verdict.PROVED
    assert certify("exp(-s)/s", Sector(0.5, 1.570795)).verdict is Verdict.PROVED  # from 0 on, as before
    assert certify("exp(-s)/s", SlopeBounds(0.5, 1.5708)).verdict is Verdict.REFUTED
    found = analyse("exp(-s)/s", "0.5*sigma + tanh(sigma)/2")
    assert found.verdict is Verdict.PROVED
    assert found.conclusion.attracts
    assert [row.lower for row in found.rows] == [Fraction(1, 2)] * 4
    assert found.asked.proved_text == "1.570796"


@pytest.mark.parametrize(
    ("plant", "lower", "gain"),
    [
        ("exp(-s)/s^2", 0, 1e-6),
        ("-exp(-s)/s", 0, 1e-6),
        ("exp(-s)/(s-1)", 0, 0),
        ("exp(-s)/(s-1)", 0.5, 0.5),
        ("exp(-s)/s", -0.5, -0.5),
    ],
)
@pytest.mark.slow
def test_plants_that_small_gains_destabilise_are_refuted(plant, lower, gain):
    # with s > 0: s = k exp(-s) has a root for every k > 0; s - 1 + k exp(-s) is below 0 at s = 0 for k < 1; s^2 + k
    # exp(-s) has the roots i sqrt(k) exp(-s/2), of real part about k/2
    found = max_sector(plant, lower=lower)
    assert found.verdict is Verdict.REFUTED
    assert found.refuted_at == pytest.approx(gain, abs=1e-6)
    assert check(found.refutation.certificate)
    assert recheck(found.refutation.certificate).accepted
    assert certify(plant, Sector(lower, 1)).verdict is Verdict.REFUTED
    varying = NonlinearityClass(sector=Sector(lower, 1), time_varying=True)
    assert analyse(plant, varying).verdict is Verdict.REFUTED


@pytest.mark.slow
def test_without_a_counterexample_the_search_begins_above_the_lower_bound(monkeypatch):
    monkeypatch.setattr(LateGains, "best", lambda _search: None)
    found = max_slope("exp(-s)/s", lower=0.5)
    assert found.largest.low == pytest.approx(math.pi / 2, rel=1e-4)


def test_gains_below_0_may_refute_every_class():
    # -exp(-s)/(s + 1) with -k is exp(-s)/(s + 1) with k: roots on the axis at 2.261826; at the gain 1 a root 0
    found = max_sector("-exp(-s)/(s+1)", lower=-3)
    assert found.verdict is Verdict.REFUTED
    assert found.refuted_at == -3
    assert max_sector("-exp(-s)/(s+1)", lower=-2).largest.low == pytest.approx(1, rel=1e-4)


@pytest.mark.slow
def test_more_than_the_certificate_shows_is_refused():
    found = max_sector("exp(-s)/s", lower=0.5)
    for changed in ({"lower": Fraction(0)}, {"largest": replace(found.largest, low=1.5709, high=1.6)}):
        with pytest.raises(MismatchError):
            replace(found, **changed)
    never = max_sector("exp(-s)/s", lower=2)
    with pytest.raises(MismatchError):
        replace(max_sector("-exp(-s)/s"), refuted_at=1e-9, witness=replace(never.witness, k=1e-9))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "circle", "end"),
    [
        # 1/k + Re H is least beside the resonance at 2, where linear gains have no root: they end at 3.6545
        ("1/(s^2 + s/5 + 4) + exp(-s)/8", 0.8, 3.6545311),
        ("(s^2 + 1)*exp(-s)/(s^2 + s + 4)", 0.796, 0.8005410),
    ],
)
def test_slopes_in_neutral_equations_are_proved_by_kernels(text, circle, end):
    found = max_slope(text)
    assert found.criterion == "late-zames-falb"
    assert end * (1 - 3e-5) < found.largest.low < end < found.refuted_at < end * (1 + 1e-5)
    (weaker,) = (one for one in found.answers if one.criterion == "piecewise-circle")
    assert weaker.largest.low < circle
    for shown in (found.proof, found.refutation):
        assert check(shown.certificate)
        assert recheck(shown.certificate).accepted
    assert max_sector(text).largest.low < circle  # where nothing is known of slopes


def test_a_criterion_of_slopes_is_not_for_sectors_of_neutral_equations():
    with pytest.raises(InputError, match=r"choose from best, popov, piecewise-popov, circle, piecewise-circle$"):
        max_sector("1/(s^2 + s/5 + 4) + exp(-s)/8", criterion="late-zames-falb")

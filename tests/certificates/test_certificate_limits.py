"""Certificates of linear limits: accepted from the limit on and not below, crossings and roots enclosed."""

from fractions import Fraction as F

import numpy as np
import pytest
from counterexamples import BIT, checked, rejected
from hypothesis import given
from hypothesis import strategies as st
from plants import DISCRETE
from plants import block as exact
from tampering import edited

from lure.analysis.certificates.checker import Refuted
from lure.analysis.certificates.refutations import crossing_proof, refutation_draft, smallest_class
from lure.analysis.counterexamples.linear import linear_witness
from lure.analysis.inequality.delay import Delayed
from lure.analysis.questions.counterexample_search import _dead_time_gain
from lure.errors import AssumptionError
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant


@pytest.mark.parametrize(
    ("block", "k"),
    [
        (exact([1], [1, 3, 3, 1]), F(8)),
        (exact([1], [1, 3, 2, 0]), F(6)),
        (DISCRETE[1], F(361, 10)),
        (DISCRETE[6], F(25, 23)),
    ],
)
def test_a_linear_gain_refutes_from_the_limit_on_and_not_below(block, k):
    draft = refutation_draft(block, linear_witness(block))
    assert draft["laws"] == {
        "sector": ["0", str(k)],
        "slope": ["0", str(k)],
        "odd": True,
        "time_varying": False,
        "linear": True,
    }
    assert isinstance(checked(draft), Refuted)
    assert "stable" in rejected(edited(draft, "proof", "gain", value=str(k - BIT)))
    wide = {**draft["laws"], "sector": ["0", "inf"], "slope": None, "odd": False, "linear": False}
    assert isinstance(checked(refutation_draft(block, linear_witness(block), wide)), Refuted)


# The limit of the third plant is irrational; Nyquist: .312370.
def test_an_irrational_limit_is_enclosed_by_its_crossing():
    gains = (F("0.31236"), F("0.31238"))
    draft = refutation_draft(DISCRETE[3], linear_witness(DISCRETE[3]))
    draft = edited(edited(draft, "laws", "sector", value=["0", "1"]), "laws", "slope", value=None)
    draft["proof"] = crossing_proof(DISCRETE[3], gains)
    assert isinstance(checked(draft), Refuted)
    for moved in (gains[0] - F(1, 1000), gains[1] - F(1, 10**4)), (gains[0] + F(1, 10**4), gains[1] + F(1, 1000)):
        assert "root" in rejected(edited(draft, "proof", "gains", value=[str(g) for g in moved]))
        with pytest.raises(AssumptionError, match="axis"):
            crossing_proof(DISCRETE[3], moved)
    assert "class" in rejected(edited(draft, "laws", "sector", value=["0", "3123/10000"]))


# d + g n = s^3 + (1 + e) s^2 + (1 + e) s + 1 + 2 e, e = g - 1: roots touch the axis at i for e = 0, stable beside it.
def test_roots_that_only_touch_the_axis_are_located():
    low, high = (F(w) for w in crossing_proof(exact([1, 1, 2], [1, 0, 0, -1]), (F(9, 10), F(11, 10)))["frequencies"])
    assert low < 1 < high
    assert high - low < F(1, 2**90)


# exp(-s)/(s + 1): tan w = -w first at w = 2.028757838..., 1 + g H = 0 for g = (1 + w^2)^(1/2) = 2.261826333...
@pytest.mark.parametrize(
    ("text", "omega", "k"),
    [
        ("exp(-s)/(s + 1)", 2.028757838, 2.261826333),
        ("exp(-s)/s", np.pi / 2, np.pi / 2),
        ("exp(-s/2)/(s**2 + s + 1)", None, None),
        ("(1 + 2*exp(-3*s))/(s**2 + s + 2)", None, None),
    ],
)
def test_a_limit_with_dead_time_is_accepted(text, omega, k):
    block = DelayPlant.parse(text)
    limit = Delayed.of(block).gains()
    draft = refutation_draft(block, _dead_time_gain(block, limit, F(0)))
    assert isinstance(checked(draft), Refuted)
    low, high = (float(F(w)) for w in draft["proof"]["frequencies"])
    assert omega is None or low == pytest.approx(omega, rel=1e-9) == high
    assert k is None or float(F(draft["laws"]["sector"][1])) == pytest.approx(k, rel=1e-9)
    below = [str(F(limit.low) * (1 - BIT)), str(F(limit.low))]
    assert "root" in rejected(edited(draft, "proof", "gains", value=below))


# s + 2 - g e^-s vanishes at 0 for g = 2; for g > 2 it is negative there and positive for large s: a root s > 0.
@pytest.mark.parametrize("sign", [1, -1])
def test_a_gain_with_dead_time_is_refuted_by_a_root_on_the_positive_axis(sign):
    block = DelayPlant({F(1): (F(-sign),)}, (F(sign), F(2 * sign)))
    draft = refutation_draft(block, _dead_time_gain(block, Delayed.of(block).gains(), F(0)))
    assert draft["proof"] == {"method": "linear-gain", "gain": "2"}
    assert "equilibria other than 0" in checked(draft).claim
    wide = edited(draft, "laws", "sector", value=["0", "3"])
    wide["laws"]["slope"] = None
    assert "does not converge" in checked(edited(wide, "proof", "gain", value=str(2 + BIT))).claim
    assert "root" in rejected(edited(wide, "proof", "gain", value=str(2 - BIT)))


# -1/(s (s + 1)) has a negative residue: every small gain destabilises; of the gain 0 it cannot be said in that class.
def test_where_small_gains_destabilise_one_of_them_is_taken():
    block = exact([-1], [1, 1, 0])
    witness = linear_witness(block)
    assert witness.data["gain"] == "0"
    draft = refutation_draft(
        block, witness, {**smallest_class(block, witness), "sector": ["0", "1/100"], "slope": None}
    )
    assert 0 < F(draft["proof"]["gain"]) <= F(1, 100)
    assert "does not converge" in checked(draft).claim


def test_an_equilibrium_refutes_nothing_in_the_critical_case():
    block = exact([1], [1, -1], dt=1)
    point = {"method": "orbit", "points": [["0", "0"], ["1", "0"], ["2", "1"]], "left": "0", "right": "1"}
    nonlinearities = {"sector": ["0", "1"], "slope": None, "odd": False, "time_varying": False, "linear": False}
    draft = refutation_draft(block, linear_witness(block), nonlinearities)
    draft["proof"] = {**point, "u": ["0"], "sigma": ["1"]}
    assert "equilibrium" in rejected(draft)
    inside = edited(draft, "system", "denominator", value=["1", "1/2"])  # 3/2 sigma = u has no equilibrium for phi >= 0
    assert rejected(inside)


# Every stable loop with real poles and a positive gain: where a linear gain destabilises, a certificate says so.
@given(st.lists(st.fractions(F(-9, 10), F(9, 10), max_denominator=20), min_size=2, max_size=4), st.booleans())
def test_every_linear_limit_has_its_certificate(poles, discrete):
    bottom = [F(1)]
    for pole in poles:
        bottom = np.polymul(bottom, [1, -pole if discrete else 1 + pole])
    block = RationalPlant([1], bottom, dt=1 if discrete else None)
    witness = linear_witness(block)
    if witness is not None:
        assert isinstance(checked(refutation_draft(block, witness)), Refuted)

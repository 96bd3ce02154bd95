"""The conclusion in words: verdict by the sign of the damping, and nothing said that was not shown."""

from fractions import Fraction

import pytest

from analysis.conclusion import conclusion
from analysis.evidence import Verdict
from lure import Scenario, builtin_system, upwind
from lure.systems import rod_from_exact


def concluded(scenario=None, **changes):
    rod = builtin_system("paper-rod").rod
    rod = rod_from_exact({**rod.exact, **{name: Fraction(value) for name, value in changes.items()}})
    return conclusion(upwind(rod, 10), scenario or Scenario())


@pytest.mark.parametrize(
    ("damping", "verdict"),
    [
        ("2e-4", Verdict.PROVED),
        ("1.2", Verdict.PROVED),
        ("1e9", Verdict.PROVED),
        ("0", Verdict.INCONCLUSIVE),
        ("-2e-4", Verdict.REFUTED),
        ("-5", Verdict.REFUTED),
    ],
)
def test_the_sign_of_the_damping_decides(damping, verdict):
    result = concluded(damping=damping)
    assert result.verdict is verdict
    assert (result.proofs != ()) == (verdict is Verdict.PROVED)


@pytest.mark.parametrize("exponent", ["1/2", "1", "3/2", "3"])
def test_every_exponent_has_the_half_line_of_equilibria(exponent):
    result = concluded(exponent=exponent)
    assert result.verdict is Verdict.PROVED
    assert "half-line" in result.stationary_set
    regular = "nondecreasing" if exponent == "1/2" else "locally Lipschitz"
    assert any(regular in row for row in result.assumptions)


@pytest.mark.parametrize("damping", ["2e-4", "0", "-1"])
def test_asymptotic_stability_is_never_claimed(damping):
    result = concluded(damping=damping)
    claimed = " ".join((result.statement, result.stationary_set, result.resting_place))
    assert "asymptotically stable" not in claimed


@pytest.mark.parametrize("load", [{"force": "sin(t)"}, {"body_force": "x"}])
def test_nothing_is_claimed_about_a_forced_motion(load):
    free, forced = concluded(), concluded(Scenario.parse(**load))
    assert "nothing is claimed" in forced.statement
    assert "nothing is claimed" not in free.statement
    assert any("forced motion" in row for row in forced.not_shown)


# a steady push g > 0 holds the rod against the obstacle at p(z) = g/A > 0, and zeta' = g/k - (A/k) p: neither the
# half-line nor a resting place at zeta(0) is right under load
@pytest.mark.parametrize("damping", ["2e-4", "0", "-1"])
@pytest.mark.parametrize("load", [{"force": 1}, {"body_force": "x"}])
def test_equilibria_and_resting_place_are_those_without_load(load, damping):
    free, forced = concluded(damping=damping), concluded(Scenario.parse(**load), damping=damping)
    assert forced.stationary_set == f"without load, {free.stationary_set}"
    assert forced.resting_place.startswith("none is claimed")
    assert (free.resting_place == "none is claimed") == (damping != "2e-4")


# k < -Z and m = 2: the linear gain that destabilises the sector is not the law of this rod, which E' = -k v(t,0)^2 >= 0
# is about
@pytest.mark.parametrize("exponent", ["1/2", "1", "2"])
@pytest.mark.parametrize("damping", ["-2e-4", "-5"])
def test_what_is_refuted_is_refuted_for_the_law_of_this_rod_too(damping, exponent):
    assert "no motion that starts with energy comes to rest" in concluded(damping=damping, exponent=exponent).statement


def test_a_conclusion_has_no_truth_value():
    with pytest.raises(TypeError, match="three answers"):
        bool(concluded())

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


def test_a_conclusion_has_no_truth_value():
    with pytest.raises(TypeError, match="three answers"):
        bool(concluded())

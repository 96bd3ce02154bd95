"""Rates by multipliers of Zames and Falb as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text

SLOPED = {"sector": ["0", "1"], "slope": ["0", "1"], "time_varying": False, "linear": False}
LAG = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "3", "1"]}
STEPS = {"kind": "transfer", "time": "discrete", "numerator": ["1/4"], "denominator": ["1", "-1/4", "0"]}


def shown(system, multiplier, rate, *, odd=False):
    """The checker's answer about slopes from 0 to 1."""
    draft = {"verdict": "PROVED", "system": system, "laws": SLOPED | {"odd": odd}, "theorem": "zames-falb"}
    return complete_and_check(
        draft | {"multiplier": multiplier, "rate": rate, "proof": {"method": "polynomial", "variable": "omega^2"}}
    )


def lag():
    """At ``s - 1/8`` the lag is below ``(8/7)^3``, and the kernel weighs ``(1/4)/(1 +- 1/16)``, ``theta`` 1/8 more."""
    kernels = [{"coefficient": "-1/4", "rate": "2", "order": 1, "side": "causal"}]
    return shown(LAG, {"theta": "1", "kernels": kernels}, "1/8", odd=True)


def steps():
    """At ``3 z/4`` the tap ``-2`` weighs ``(1/8) (4/3)^2`` and ``(1/8) (3/4)^2``."""
    return shown(STEPS, {"taps": [[1, "1/2"], [-2, "1/8"]]}, "3/4")


def alone():
    """Popov's term alone: the form is above 0 as with a kernel of less weight."""
    return shown(LAG, {"theta": "1", "kernels": []}, "1/8")


def test_the_theorem_is_about_the_plant_itself_and_has_one_factor_for_all_solutions():
    text = coq_text(lag())
    assert "Definition denominator : list R := [1; 3; 3; 1].\nDefinition num : list R := [1].\n" in text
    assert (
        """Theorem decays : zames_falb_theorem_at_rate -> exists c, forall (phi : R -> R) (xi : nat -> R -> R),
  sloped true 0 1 phi -> flow_of numerator denominator phi xi -> decays_in_time c (1 / 8) 3 xi.
"""
        in text
    )
    assert """Theorem decays : zames_falb_theorem_at_rate_in_steps -> exists c, forall (phi : R -> R) (xi : nat -> R),
  sloped false 0 1 phi -> steps_of numerator denominator phi xi -> decays_in_steps c (3 / 4) 2 xi.
""" in coq_text(steps())
    assert "; ." not in coq_text(alone())  # no word stands for the signs of kernels where there are none


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("made", "falsified"),
    [
        (lag, [("-1 / 4)", "-5 / 4)"), ("time c (1 / 8)", "time c (1 / 4)"), ("sloped true 0 1", "sloped false 0 1")]),
        (alone, [("time c (1 / 8)", "time c (1 / 4)"), ("sloped false 0 1", "sloped false 0 2")]),
        (steps, [("steps c (3 / 4)", "steps c (2 / 3)"), ("sloped false 0 1", "sloped false 0 2")]),
    ],
)
def test_rates_compile_and_falsified_ones_do_not(library, made, falsified):
    text = coq_text(made())
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in falsified:
        assert not compiled(library, changed(text, right, wrong))[0]

"""Gains from w to z that are larger, or infinite, as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.errors import InputError

LAW = {"sector": ["0", "1/2"], "slope": None, "odd": False, "time_varying": False, "linear": False}
LAG = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": [["1", "1"]], "C": [["1"], ["1"]]}
LAG |= {"D": [["0", "0"], ["0", "0"]]}
SPRING = LAG | {"A": [["0", "1"], ["-1", "-1/10"]], "B": [["0", "0"], ["1", "1"]], "C": [["1", "0"], ["1", "0"]]}
TWO = SPRING | {"B": [["0", "1", "0"], ["1", "0", "1"]], "C": [["1", "0"], ["1", "0"], ["0", "1"]]}
TWO |= {"D": [["0"] * 3] * 3}


def larger(system, least, **proof):
    """The file of a gain above ``1/least``, or of an infinite one."""
    own = LAW | {"sector": [f"-{least}", least], "time_varying": True, "operator": "performance"}
    count = len(system["D"]) - 1
    laws = {"channels": [LAW, *[own] * count], "repeated": [1, count]}
    draft = {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "multiplier": {}}
    return coq_text(complete_and_check(draft | {"proof": proof}))


def member(system, least, gains, omega, *given):
    """That of constant gains and an input with a frequency."""
    return larger(system, least, method="linear-members", gains=gains, operators=[], omega=omega, input=[*given])


def lag():
    """``1/(s + 1)`` is 1 at 0, above 99/100: from rest to the constant 1."""
    return member(LAG, "100/99", ["0", "0"], "0", ["1", "0"])


def resonance():
    """``1/(s^2 + s/10 + 3/2)`` with the gain 1/2 at ``omega = 6/5``: above 1/(.06 + .12) > 5."""
    return member(SPRING, "1/5", ["1/2", "0"], "6/5", ["1", "0"])


def turning():
    """Inputs 1 and i at ``omega = 1``: ``x_1 = 20 - i``, ``x_2 = i x_1 - 1``, and ``|z| = 20 |w|``, above 3."""
    return member(TWO, "1/3", ["0", "0", "0"], "1", ["1", "0"], ["0", "1"])


def samples():
    """``1/(z - 1/2)`` is 2 at 1: above 199/100."""
    return member(LAG | {"time": "discrete", "A": [["1/2"]]}, "100/199", ["0", "0"], "0", ["1", "0"])


def unlimited():
    """``1/s`` with the gain 0."""
    return larger(LAG | {"A": [["0"]]}, "1", method="linear-gains", gains=["0", "0"], unlimited=[1, 1])


def undamped():
    """``1/(s^2 + 1)`` with the gain 0."""
    system = SPRING | {"A": [["0", "1"], ["-1", "0"]]}
    return larger(system, "1", method="linear-gains", gains=["0", "0"], unlimited=[1, 1])


def leaving():
    """``1/(s - 1)`` with the gain 0."""
    return larger(LAG | {"A": [["1"]]}, "1", method="linear-gains", gains=["0", "0"], unlimited=[1, 1])


def growing():
    """``1/(z^2 - z/2 + 2)`` with the gain 0, whose poles have the modulus sqrt 2 and irrational parts."""
    system = SPRING | {"time": "discrete", "A": [["0", "1"], ["-2", "1/2"]]}
    return larger(system, "1", method="linear-gains", gains=["0", "0"], unlimited=[1, 1])


def both():
    """Of two inputs and outputs and the gain 1/2 the first output of the second input, through ``-1/(z^2 + 5/2)``."""
    system = TWO | {"time": "discrete", "A": [["0", "1"], ["-2", "0"]]}
    return larger(system, "1", method="linear-gains", gains=["1/2", "0", "0"], unlimited=[1, 2])


CASES = {  # what the theorem ends with, and what is not true
    lag: ("exists t, 0 < t /\\ (9801 / 10000) * (Ew t - Ew 0) < Ez t - Ez 0", "9801 / 10000", "1"),
    resonance: ("exists t, 0 < t /\\ 25 * (Ew t - Ew 0) < Ez t - Ez 0", "25 * (Ew", "36 * (Ew"),
    turning: ("exists t, 0 < t /\\ 9 * (Ew t - Ew 0) < Ez t - Ez 0", "9 * (Ew", "900 * (Ew"),
    samples: (
        "sum_f_R0 (fun t => w 1%nat t ^ 2) k < sum_f_R0 (fun t => output0 x w t ^ 2) k",
        "(39601 / 10000) * sum",
        "4 * sum",
    ),
    unlimited: ("forall c, exists t, 0 < t /\\ c * (Ew t - Ew 0) < Ez t - Ez 0", "1 * w 1%nat", "(-1) * w 1%nat"),
    leaving: ("forall c, exists t, 0 < t /\\ c * (Ew t - Ew 0) < Ez t - Ez 0", "1 * x 0%nat t", "2 * x 0%nat t"),
    growing: ("forall c, exists k, c * sum_f_R0 (fun t => w 1%nat t ^ 2) k <", "(-2) * x 0%nat", "(1 / 2) * x 0%nat"),
    both: (
        "sum_f_R0 (fun t => output0 x w t ^ 2 + output1 x w t ^ 2) k",
        "c * sum_f_R0 (fun t => w 1%nat t ^ 2 + w 2%nat t ^ 2) k < sum_f_R0 (fun t => output0 x w t ^ 2 +",
        "c * sum_f_R0 (fun t => w 1%nat t ^ 2 + w 2%nat t ^ 2) k < sum_f_R0 (fun t => 0 * output0 x w t ^ 2 -",
    ),
    undamped: ("forall c, exists t, 0 < t /\\ c * (Ew t - Ew 0) < Ez t - Ez 0", "(-1) * x 0%nat", "(-2) * x 0%nat"),
}


@pytest.mark.parametrize("written", CASES)
def test_more_comes_through_than_the_gain_allows_from_rest(written):
    stated = (text := written())[text.rindex("Theorem exceeds") : text.rindex("Proof.")]
    assert CASES[written][0] in stated
    assert "0 <= g0 <= (1 / 2) /\\" in stated  # the class
    assert f"x 0%nat {'0%nat' if written in (samples, growing, both) else '0'} = 0 /\\" in stated


def test_an_input_of_the_frequency_0_is_constant_later_on():
    assert "Definition x0 : R -> R := wave [0; 0; 3; (-2)] 1 0 0." in lag()  # t^2 (3 - 2 t) up to 1


def test_an_infinite_gain_by_a_pole_elsewhere_is_refused():
    for system, said in (
        (LAG | {"A": [["1"]], "time": "discrete"}, "no quadratic form was found that does not fall"),
        (SPRING | {"A": [["0", "1"], ["2", "0"]]}, "no rational frequency was found"),  # sqrt 2
    ):
        with pytest.raises(InputError, match=said):
            larger(system, "1", method="linear-gains", gains=["0", "0"], unlimited=[1, 1])


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("written", CASES)
def test_it_compiles_and_what_is_falsified_does_not(written, library):
    text = written()
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    place = text.rindex("Theorem exceeds")
    for right, wrong in (CASES[written][1:], ("x 0%nat 0", "x 0%nat 1")):
        assert not compiled(library, text[:place] + changed(text[place:], right, wrong))[0], (right, wrong)

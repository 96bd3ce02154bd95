"""Refutations of rates as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.analysis.export.pacing import pacing_text
from lure.errors import InputError

LAG = {"kind": "transfer", "time": "discrete", "numerator": ["1"], "denominator": ["2", "-1"]}
SECOND = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "2"]}
SPRING = {"kind": "state-space", "time": "continuous", "A": [["0", "1"], ["-1", "-1/10"]], "b": ["0", "1"]}
SPRING |= {"c": ["1", "0"], "d": "0"}


def slower(system, upper, rate, **proof):
    """The file of gains in [0, upper] with which a solution falls more slowly."""
    laws = {"sector": ["0", upper], "slope": None, "odd": False, "time_varying": True, "linear": False}
    draft = {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "multiplier": {}}
    return coq_text(complete_and_check(draft | {"rate": rate, "proof": proof}))


# 2 z - 1 + g: the root is 1/2 at g = 0; (s + 1)(s + 2) + g: -3/2 +- i/2 at g = 1/2
def resting():
    return slower(LAG, "1/2", "1/2", method="linear-gain", gain="0")


def turning():
    return slower(SECOND, "1/2", "2", method="linear-gain", gain="1/2")


def switched():
    """With half the damping as the rate the product of the multipliers is 1."""
    times = {"times": ["4/5", "3/2"], "squarings": 3, "bits": 96}
    return slower(SPRING, "3", "1/20", method="switched-gain", gains=["3", "0"], **times)


def in_steps():
    """``2 x+ = (1 - g) x`` is slower than ``(2/5)^t`` with gains of 0 and 1/10 in turn."""
    return slower(LAG, "1/2", "2/5", method="switched-gain", gains=["0", "1/10"], squarings=4, bits=96)


CASES = {
    resting: "~ (forall k, (k < 1)%nat -> Un_cv (fun t => x k t / (1 / 2) ^ t) 0)",
    turning: "forall c : nat -> R, ~ (forall k, (k < 2)%nat -> tends_to (fun t => exp (2 * t) * x k t) (c k))",
    switched: "forall B, exists t, 0 <= t /\\ B < exp ((1 / 20) * t) ^ 2 * norm2 [x 0%nat t; x 1%nat t]",
    in_steps: "forall B, ~ (forall t, norm2 [x 0%nat t] / ((2 / 5) ^ t) ^ 2 <= B)",
}


@pytest.mark.parametrize("written", CASES)
def test_what_is_slower_is_a_solution_of_the_loop_itself(written):
    text = written()
    stated = text[text.rindex("Theorem moves") :]
    assert f"  {CASES[written]}.\n" in stated
    flow = {
        resting: "x 0%nat (S t) = (1 / 2) * x 0%nat t + (-1) * w 0%nat t)",
        turning: "t ((-2) * x 0%nat t + (-3) * x 1%nat t + (-1) * w 0%nat t))",
        switched: "t ((-1) * x 0%nat t + (-1 / 10) * x 1%nat t + (-1) * w 0%nat t))",
        in_steps: "x 0%nat (S t) = (1 / 2) * x 0%nat t + (-1) * w 0%nat t)",
    }
    assert flow[written] in stated


def test_other_refutations_of_rates_are_refused():
    with pytest.raises(InputError, match="it is a refutation of a rate by late-turns, of a plant of the kind delay"):
        pacing_text({"proof": {"method": "late-turns"}, "system": {"kind": "delay"}}, "")


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("written", "pairs"),
    [
        (resting, [("(1 / 2) ^ t) 0)", "(2 / 3) ^ t) 0)"), ("(S t) = (1 / 2)", "(S t) = (1 / 3)")]),
        (turning, [("exp (2 * t) * x k t) (c", "exp (1 * t) * x k t) (c"), ("0 <= g0 <= (1 / 2)", "1 <= g0 <= 2")]),
        (switched, [("exp ((1 / 20) * t) ^ 2 * norm2", "exp ((1 / 10) * t) ^ 2 * norm2")]),
        (in_steps, [("((2 / 5) ^ t) ^ 2", "((1 / 5) ^ t) ^ 2")]),
    ],
)
def test_slower_solutions_compile_and_falsified_ones_do_not(library, written, pairs):
    text = written()
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    whole = text.rindex("Theorem moves")
    for right, wrong in pairs:
        assert not compiled(library, text[:whole] + changed(text[whole:], right, wrong))[0], (right, wrong)

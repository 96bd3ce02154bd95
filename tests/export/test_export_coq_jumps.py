"""Gains that jump in continuous time as files for Coq: true ones compile, falsified ones do not."""

import math
from fractions import Fraction

import pytest
from replayed import KEPT, changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text, jumping
from lure.errors import InputError

# x'' + x'/10 + x = -g x with g = 3 for the time 4/5 and 0 for 3/2: half a turn of the angular frequency 2, and of 1
SPRING = {"A": [["0", "1"], ["-1", "-1/10"]], "time": "continuous"}
STATES = {**SPRING, "kind": "state-space", "b": ["0", "1"], "c": ["1", "0"], "d": "0"}
TWO = {**SPRING, "kind": "multivariable", "B": [["0", "0"], ["1", "1/2"]], "C": [["1", "0"], ["1", "1/10"]]}
TWO["D"] = [["0", "0"], ["1/10", "0"]]


def switched(system, **proof):
    """The file of the spring, in states, or with a second gain of what the first one leaves."""
    one = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    laws = one | {"sector": ["0", "3"]}
    if system is TWO:
        laws = {"channels": [laws, one | {"sector": ["-1", "1"]}], "repeated": False}
    draft = {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "multiplier": {}}
    proof = {"times": ["4/5", "3/2"], "squarings": 4, "bits": 96} | proof
    return coq_text(complete_and_check(draft | {"proof": proof}))


def in_states():
    return switched(STATES, method="switched-gain", gains=["3", "0"])


def of_two():
    return switched(TWO, method="switched-gains", gains=[["3", "1"], ["0", "-1/2"]])


def falsified(library, text, *pairs):
    """Whether it compiles, rests on the axioms alone, and no change of its theorem or its lists does."""
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in pairs:
        assert not compiled(library, changed(text, right, wrong))[0], (right, wrong)


def test_a_solution_with_jumps_is_continuous_and_not_bounded():
    text = coq_text(check(KEPT["switched gain"]))
    stated = text[text.rindex("Theorem moves") :]
    assert "  (forall t, 0 <= g0 t <= 3) /\\\n" in stated
    assert "(forall j t, jump j <= t < jump (S j) -> g0 t = repeated gains0 j)" in stated
    assert "(forall k t, (k < 2)%nat -> continuity_pt (xi k) t)" in stated
    assert "(forall t, along den xi t = - (g0 t * along num xi t))" in stated
    assert "  forall B, exists t, 0 <= t /\\ B < norm2 [xi 0%nat t; xi 1%nat t].\n" in stated
    assert "Definition times : list R := [(4 / 5); (3 / 2)].\nDefinition gains0 : list R := [3; 0]." in text


def test_the_values_of_channels_with_a_feedthrough_are_told():
    text = of_two()
    assert "(forall t, w 1%nat t = g1 t * (1 * x 0%nat t + (1 / 10) * x 1%nat t + (-1 / 10) * w 0%nat t))" in text
    assert "w 0%nat t = g0 t * (1 * x 0%nat t))" in in_states()


def test_forms_with_too_few_terms_or_that_do_not_drop_are_not_taken():
    # x' = x/2 for the time 1 and Q' = -Q - w, w = DROP: Q = Q/e - w (1 - 1/e) - 2 DROP
    (stay,) = jumping._growth([[[Fraction(1, 2)]]], [Fraction(1)]).stays
    (Q,) = stay.Q
    assert Q[0][0] == pytest.approx(-jumping.DROP * (1 + 2 / (1 - math.exp(-1))), abs=1)
    assert not jumping._piece_holds(stay, Q, Q, 1, jumping.DROP)
    assert jumping._piece_holds(stay, Q, Q, 8, jumping.DROP)
    assert not jumping._piece_holds(stay, Q, [[Q[0][0] + 2 * jumping.DROP]], 8, jumping.DROP)
    assert not jumping._piece_holds(stay, [[-Q[0][0]]], [[-Q[0][0]]], 8, jumping.DROP)


def test_gains_that_would_take_too_long_are_refused(monkeypatch):
    monkeypatch.setattr(jumping, "MOST_STEPS", 3)
    with pytest.raises(InputError, match="its period is 4 steps long; up to 3 have an export"):
        in_states()
    monkeypatch.setattr(jumping, "MOST_STAYS", 1)
    with pytest.raises(InputError, match="it has 2 states and 2 stays"):
        in_states()


@needs_coq
@pytest.mark.thorough
def test_gains_that_jump_compile_and_falsified_ones_do_not(library):
    falsified(
        library,
        coq_text(check(KEPT["switched gain"])),
        ("0 <= g0 t <= 3", "0 <= g0 t <= 2"),
        ("Definition den : list R := [1; (1 / 10)", "Definition den : list R := [1; (-1 / 10)"),
        ("Definition times : list R := [(4 / 5)", "Definition times : list R := [(6 / 5)"),
        ("Definition gains0 : list R := [3;", "Definition gains0 : list R := [2;"),
        ("Definition forms0 : list triangle := [[(-", "Definition forms0 : list triangle := [[("),
        ("B < norm2 [xi 0%nat t; xi 1%nat t]", "B < norm2 [xi 0%nat t]"),
    )


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("written", "pairs"),
    [
        (in_states, [("(-1 / 10) * x 1%nat t + (-1) * w 0", "(1 / 10) * x 1%nat t + (-1) * w 0")]),
        (of_two, [("(-1 / 10) * w 0%nat t))", "(1 / 10) * w 0%nat t))"), ("(-1) <= g1 t <= 1", "0 <= g1 t <= 1")]),
    ],
)
def test_gains_that_jump_of_a_plant_of_matrices_compile_and_falsified_ones_do_not(library, written, pairs):
    falsified(library, written(), *pairs)

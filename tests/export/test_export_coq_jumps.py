"""Gains in turn, and forms that grow with constant ones, as files for Coq: true ones compile, falsified ones do not."""

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


# x+ = (x_2, x_2/2 - g_1 x_1 - g_2 (x_2 - g_1 x_1/5))
STEPS = {"kind": "multivariable", "time": "discrete", "A": [["0", "1"], ["0", "1/2"]], "B": [["0", "0"], ["1", "1"]]}
STEPS |= {"C": [["1", "0"], ["0", "1"]], "D": [["0", "0"], ["1/5", "0"]]}
# x_1' = (g - 1) x_1 beside 1/((s + 1)(s + 2)) + 1/(s + 1): no channel moves both
APART = {**TWO, "A": [["-1", "0", "0"], ["0", "-2", "1"], ["0", "0", "-1"]], "B": [["1", "0"], ["0", "0"], ["0", "1"]]}
APART |= {"C": [["-1", "0", "0"], ["0", "1", "1"]], "D": [["0", "0"], ["0", "0"]]}


def refuted_by(system, gains, *, repeated=False, **proof):
    """The file of gains of a plant in states: the classes are [0, 3] and [-1, 1], or [0, 3] of both."""
    one = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    laws = one | {"sector": ["0", "3"]}
    if system["kind"] == "multivariable":
        laws = {"channels": [laws, laws if repeated else one | {"sector": ["-1", "1"]}], "repeated": repeated}
    draft = {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "multiplier": {}}
    return coq_text(complete_and_check(draft | {"proof": proof | {"gains": gains}}))


def in_states():
    times = {"times": ["4/5", "3/2"], "squarings": 4, "bits": 96}
    return refuted_by(STATES, ["3", "0"], method="switched-gain", **times)


def of_two():
    times = {"times": ["4/5", "3/2"], "squarings": 4, "bits": 96}
    return refuted_by(TWO, [["3", "1"], ["0", "-1/2"]], method="switched-gains", **times)


def undamped():
    """``x'' + g x = 0``: the product of the multipliers is 1."""
    system = STATES | {"A": [["0", "1"], ["0", "0"]]}
    times = {"times": ["3/4", "3/2"], "squarings": 6, "bits": 128}
    return refuted_by(system, ["3", "1"], method="switched-gain", **times)


def in_steps():
    gains = [["3/2", "1/10"], ["0", "-1/10"], ["3/2", "0"]]
    return refuted_by(STEPS, gains, method="switched-gains", squarings=4, bits=96)


def apart():
    return refuted_by(APART, ["2", "2"], repeated=True, method="linear-gains")


def apart_in_steps():
    system = APART | {"time": "discrete", "A": [["1/2", "0", "0"], ["0", "1/2", "1"], ["0", "0", "1/3"]]}
    return refuted_by(system, ["2", "1"], method="linear-gains")


def assert_only_what_is_true_compiles(library, text, *pairs):
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
    assert "Definition durations : list R := [(4 / 5); (3 / 2)].\nDefinition gains0 : list R := [3; 0]." in text


def test_the_values_of_channels_with_a_feedthrough_are_told():
    text = of_two()
    assert "(forall t, w 1%nat t = g1 t * (1 * x 0%nat t + (1 / 10) * x 1%nat t + (-1 / 10) * w 0%nat t))" in text
    assert "w 0%nat t = g0 t * (1 * x 0%nat t))" in in_states()


def test_forms_with_too_few_terms_or_that_do_not_drop_are_not_taken():
    # x' = x/2 for the time 1 and Q' = -Q - w, w = drop: Q = Q/e - w (1 - 1/e) - 2 drop
    found = jumping.growth([[[Fraction(1, 2)]]], [Fraction(1)])
    (stay,), drop = found.stays, found.drop
    (Q,) = stay.Q
    assert Q[0][0] == pytest.approx(-drop * (1 + 2 / (1 - math.exp(-1))), abs=1)
    assert not jumping._piece_holds(stay, (Q, Q), 1, drop)
    assert jumping._piece_holds(stay, (Q, Q), 8, drop)
    assert not jumping._piece_holds(stay, (Q, [[Q[0][0] + 2 * drop]]), 8, drop)
    assert not jumping._piece_holds(stay, ([[-Q[0][0]]],) * 2, 8, drop)


def test_gains_that_would_take_too_long_are_refused(monkeypatch):
    monkeypatch.setattr(jumping, "MOST_STEPS", 3)
    with pytest.raises(InputError, match="its period is 4 steps long; up to 3 have an export"):
        in_states()
    monkeypatch.setattr(jumping, "MOST_STEPS", 4)
    monkeypatch.setattr(jumping, "MOST_WORK", 1000)
    with pytest.raises(InputError, match="its numbers have too many digits for the steps of its period"):
        in_states()
    monkeypatch.setattr(jumping, "MOST_STAYS", 1)
    with pytest.raises(InputError, match="it has 2 states and 2 stays"):
        in_states()


@needs_coq
@pytest.mark.thorough
def test_gains_that_jump_compile_and_falsified_ones_do_not(library):
    assert_only_what_is_true_compiles(
        library,
        coq_text(check(KEPT["switched gain"])),
        ("0 <= g0 t <= 3", "0 <= g0 t <= 2"),
        ("Definition den : list R := [1; (1 / 10)", "Definition den : list R := [1; (-1 / 10)"),
        ("Definition durations : list R := [(4 / 5)", "Definition durations : list R := [(6 / 5)"),
        ("Definition gains0 : list R := [3;", "Definition gains0 : list R := [2;"),
        ("Definition forms0 : list triangle := [[(-", "Definition forms0 : list triangle := [[("),
        ("B < norm2 [xi 0%nat t; xi 1%nat t]", "B < norm2 [xi 0%nat t]"),
    )


def test_constant_gains_where_no_channel_moves_all_states_are_shown_by_a_form():
    text = apart()
    assert "Theorem moves : exists (g0 : R) (x w : nat -> R -> R),\n  0 <= g0 <= 3 /\\\n" in text  # one gain in both
    assert "(forall t, w 1%nat t = g0 * (1 * x 1%nat t + 1 * x 2%nat t))" in text
    assert "  forall B, exists t, 0 <= t /\\ B < norm2 [x 0%nat t; x 1%nat t; x 2%nat t].\n" in text
    assert "  forall B, ~ (forall t, norm2 [x 0%nat t; x 1%nat t; x 2%nat t] <= B).\n" in apart_in_steps()
    text = coq_text(check(KEPT["matrix gain"]))  # of one channel by its root
    assert "forall c : nat -> R, ~ (forall k, (k < 2)%nat -> tends_to (x k) (c k))" in text


SIGN = ("(-1) * x 0%nat t + (-1) * w 0%nat t", "(-1) * x 0%nat t + 1 * w 0%nat t")


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("written", "pairs"),
    [
        (in_states, [("(-1 / 10) * x 1%nat t + (-1) * w 0", "(1 / 10) * x 1%nat t + (-1) * w 0")]),
        (of_two, [("(-1 / 10) * w 0%nat t))", "(1 / 10) * w 0%nat t))"), ("(-1) <= g1 t <= 1", "0 <= g1 t <= 1")]),
        (undamped, [("(in_turn (1 / 8)", "(in_turn (-1 / 8)")]),
        (in_steps, [("(-1 / 5) * w 0%nat t))", "(1 / 5) * w 0%nat t))"), ("[-147; 40]", "[-147; -40]")]),
        (apart, [SIGN, ("0 <= g0 <= 3", "0 <= g0 <= 1"), ("list triangle := [[(-", "list triangle := [[(")]),
        (apart_in_steps, [("(1 / 2) * x 0%nat t + (-1) * w", "(1 / 2) * x 0%nat t + 1 * w")]),
    ],
)
def test_plants_of_matrices_compile_and_falsified_ones_do_not(library, written, pairs):
    assert_only_what_is_true_compiles(library, written(), *pairs)

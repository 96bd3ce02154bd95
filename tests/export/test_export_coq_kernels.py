"""Kernels between several channels as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.errors import InputError

SLOPED = {"sector": ["-1/2", "1"], "slope": ["-1/2", "1"], "odd": True, "time_varying": False, "linear": False}


def shown(*, D="0", repeated=True, given=None, sector="1", gain=None, **more):
    """``sigma_1 = x_1``, ``sigma_2 = x_1/4 + x_2 + mu_1/4``: ``He (1 + 3/2 H) > 0`` after the shift, by far.

    With a ``gain`` ``w`` stands beside ``mu_1`` in ``x_1'``, and ``z = x_2``.
    """
    system = {"kind": "multivariable", "time": "continuous", "A": [["-1", "0"], ["0", "-2"]]}
    system |= {"B": [["1", "1/4"], ["0", "1"]], "C": [["1", "0"], ["1/4", "1"]], "D": [["0", D], ["1/4", "0"]]}
    kernels = [
        {"channels": [1, 1], "coefficient": "-1/2", "rate": "1", "order": 2, "side": "causal"},
        {"channels": [2, 1], "coefficient": "1/8", "rate": "3/2", "order": 1, "side": "anticausal"},
    ]
    gamma = [["1", "-1/16" if repeated else "0"], ["0", "1"]]
    multiplier = {
        "gamma": gamma,
        "theta": ["1/4" if D == "0" else "0", "0"],
        "kernels": kernels if given is None else given,
    }
    laws = {"channels": [SLOPED | {"sector": ["-1/2", sector]}] * 2, "repeated": repeated}
    if gain is not None:
        system |= {"B": [["1", "1/4", "1"], ["0", "1", "0"]], "C": [["1", "0"], ["1/4", "1"], ["0", "1"]]}
        system["D"] = [["0", D, "0"], ["1/4", "0", "0"], ["0", "0", "0"]]
        ends = [f"-1/{gain}", f"1/{gain}"]
        outer = {"sector": ends, "slope": None, "odd": False, "time_varying": True, "linear": False}
        laws = {"channels": [*laws["channels"], outer | {"operator": "performance"}], "repeated": [2, 1]}
        gamma = [[*row, "0"] for row in gamma] + [["0", "0", "8"]]
        multiplier |= {"gamma": gamma, "theta": [*multiplier["theta"], "0"]}
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": "matrix-zames-falb"}
    return complete_and_check(draft | {"multiplier": multiplier, "proof": {"method": "determinant"}} | more)


def test_the_theorem_is_about_the_plant_and_the_nonlinearities():
    text = coq_text(shown())
    assert "Definition A : rows := [[(-1); 0]; [0; (-2)]].\n" in text
    assert "Definition of : list nat := [0; 0]%nat.\n" in text  # one nonlinearity in both
    assert (
        """Theorem stable : matrix_zames_falb_theorem -> forall (phi : nat -> R -> R) (x w : nat -> R -> R),
  of_class true (-1 / 2) 1 (phi 0%nat) ->
  loop_of A B C0 D of phi x w -> forall k, (k < 2)%nat -> tends_to (x k) 0.
"""
        in text
    )
    apart = coq_text(shown(repeated=False, given=[]))
    assert "  of_class false (-1 / 2) 1 (phi 0%nat) -> of_class false (-1 / 2) 1 (phi 1%nat) ->\n" in apart


def test_what_the_theorem_does_not_cover_is_refused():
    with pytest.raises(InputError, match="by states and the channels before it"):
        coq_text(shown(D="1/100"))
    with pytest.raises(InputError, match="bounds of the sectors have to be those of the slopes, and finite"):
        coq_text(shown(sector="1/2"))


@needs_coq
@pytest.mark.thorough
def test_kernels_compile_and_falsified_ones_do_not(library):
    text = coq_text(shown())
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    entry = text[text.index("Definition P") :].split("[[", 1)[1].split("]", 1)[0]
    for right, wrong in (
        ("A : rows := [[(-1); 0]", "A : rows := [[(1); 0]"),
        ("of_class true (-1 / 2) 1 (phi", "of_class true (-1 / 2) 2 (phi"),
        ("Definition gamma : list R := [1; 1]", "Definition gamma : list R := [1 / 2; 1]"),  # the kernels weigh 9/16
        ("2%nat, true", "2%nat, false"),
        (f"[[{entry}]", f"[[-{entry}]"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


def test_a_rate_and_a_gain_are_about_the_plant_itself():
    text = coq_text(shown(rate="1/8"))
    assert "Definition A0 : rows := [[(-1); 0]; [0; (-2)]].\n" in text
    assert "Lemma moved : plus_on_diagonal (1 / 8) A0 = A.\n" in text
    assert (
        """Theorem decays : matrix_zames_falb_theorem_at_rate -> exists c, forall (phi : nat -> R -> R)
  (x w : nat -> R -> R), of_class true (-1 / 2) 1 (phi 0%nat) ->
  loop_of A0 B C0 D of phi x w -> decays_in_time c (1 / 8) 2 x.
"""
        in text
    )
    assert """  (Ez Ew : R -> R) (s : R), of_class true (-1 / 2) 1 (phi 0%nat) ->
  driven_by 2 A B C0 D of phi x w -> continuity (w 2%nat) ->
  energy 2 3 (sigma_at C0 D x w) Ez -> energy 2 3 w Ew -> 0 < s -> x 0%nat s = 0 -> x 1%nat s = 0 ->
  forall t, s <= t -> Ez t - Ez s <= 64 * (Ew t - Ew s).
""" in coq_text(shown(gain=8))


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("more", "falsified"),
    [
        ({"rate": "1/8"}, [("A0 : rows := [[(-1); 0]", "A0 : rows := [[1; 0]"), ("c (1 / 8) 2 x", "c (1 / 4) 2 x")]),
        ({"rate": "1/8"}, [("list R := [1; 1]", "list R := [5 / 9; 1]"), ("lass true", "lass false")]),  # 9/16 and more
        (
            {"gain": 8},
            [
                ("<= 64 *", "<= 63 *"),
                ("driven_by 2", "driven_by 3"),
                ("list R := [1; 1; 8]", "list R := [1 / 2; 1; 8]"),
            ],
        ),
        ({"gain": 8}, [("(1 / 8))]", "(1 / 7))]"), ("1]; [0; 1]]", "1]; [9; 1]]")]),
    ],
)
def test_rates_and_gains_compile_and_falsified_ones_do_not(library, more, falsified):
    text = coq_text(shown(**more))
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in falsified:
        assert not compiled(library, changed(text, right, wrong))[0], wrong

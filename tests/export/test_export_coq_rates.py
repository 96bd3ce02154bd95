"""Rates and gains as files for Coq: true ones compile, falsified ones do not."""

import re
from fractions import Fraction

import pytest
from replayed import changed, compiled, needs_coq, proved, resting_on_axioms

from lure import RationalPlant, Sector
from lure.analysis import decay_rate, l2_gain
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text


# 2 xi(t+1) - xi(t) = -phi: gains from 0 to 1/2 leave (1 - g)/2, from 1/4 to 1/2, so that 1/2 is the rate of the class.
@needs_coq
@pytest.mark.thorough
def test_a_rate_in_discrete_time_compiles_and_a_faster_one_does_not(library):
    system = {"kind": "transfer", "time": "discrete", "numerator": ["1"], "denominator": ["2", "-1"]}
    text = coq_text(proved(system, "1/2", varying=True, rate="3/5"))
    assert "forall k t, norm2 (state xi (k + t)%nat) <= (171 / 171) * (3 / 5) ^ (2 * k) * norm2 (state xi t)." in text
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (
        ("(3 / 5) ^", "(2 / 5) ^"),
        ("products (3) 5", "products (2) 5"),
        ("in_sector 0 (1", "in_sector 0 (9"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


# (s + 1)(s + 2) + g: both roots are at -3/2 +- i sqrt(g - 1/4), from g = 1/4 on; the slowest one is -1 at g = 0.
@needs_coq
@pytest.mark.thorough
def test_rates_in_continuous_time_compile(library):
    plant = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "2"]}
    text = coq_text(proved(plant, "1/2", rate="3/4"))
    assert "forall s t, 0 < s -> s <= t -> norm2 (state xi t) <= " in text
    ok, said = compiled(library, text)
    assert ok, said
    assert not compiled(library, text.replace("3 / 4", "5 / 4").replace("(3) 4", "(5) 4"))[0]
    law = {"sector": ["0", "1/2"], "slope": None, "odd": False, "time_varying": True, "linear": False}
    plant = {
        "kind": "multivariable",
        "time": "continuous",
        "A": [["-1", "0"], ["1", "-2"]],
        "B": [["1", "0"], ["0", "1"]],
    }
    plant |= {"C": [["0", "1"], ["1", "0"]], "D": [["0", "0"], ["0", "0"]]}
    draft = {"verdict": "PROVED", "system": plant, "laws": {"channels": [law] * 2, "repeated": False}, "rate": "1/8"}
    draft |= {"theorem": "diagonal-circle", "multiplier": {"lambda": ["1", "1"]}, "proof": {"method": "determinant"}}
    ok, said = compiled(library, coq_text(complete_and_check(draft)))
    assert ok, said


def weighed(sign):
    """Popov's terms with a rate: ``s^2 + s + 1`` falls, with ``-s/10`` in place of ``s`` some solution grows."""
    plant = RationalPlant([1], [1, 1 if sign > 0 else Fraction(-1, 10), 1])
    return coq_text(decay_rate(plant, Sector(0, 1)).proof)


def test_popovs_terms_have_a_rate_with_an_integral_of_phi():
    text = weighed(1)
    stated = text[text.rindex("Theorem decays") : text.rindex("Proof.")]
    assert "(in_sector 0 1 phi) ->\n  (integral_of Phi phi) ->" in stated
    assert "norm2 (state x w t) <= " in stated
    assert "Definition high : list term := [(" in text


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("sign", [1, -1])
def test_popovs_terms_with_a_rate_compile_and_what_is_falsified_does_not(sign, library):
    text = weighed(sign)
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    (a,) = set(
        re.findall(
            r"exp \(- \(2 \* (\(.*?\)) \* \(t - s\)\)\)", text[text.rindex("Theorem decays") :].split("Proof")[0]
        )
    )
    p, q = a[1:-1].split(" / ")
    for right, wrong in (
        (f"({p}) {q} ", f"({int(p) + int(q)}) {q} "),
        ("in_sector 0 1", "in_sector 0 2"),
        ("(integral_of Phi phi) ->", "(integral_of phi Phi) ->"),
        (f"2 * {a} *", f"2 * ({p} / 2) *"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], (right, wrong)


def gain(name="diagonal-circle"):
    """``x' = -x - phi(x) + w``, ``z = x``: the gain is 1, for ``phi = 0``.

    With ``V = x^2`` and ``2 phi (x - phi) >= 0`` what is left is ``2 x^2 - 2 x w + 2 phi^2 >= x^2 - w^2``.  The full
    block is that product and a thousandth of ``x^2 + phi^2``.  Beside a
    state with ``y' = x``, which nothing depends on, ``V`` is semidefinite.
    """
    beside, popov = name == "beside", name.endswith("popov")
    law = {"sector": ["0", "1"], "slope": None, "odd": False, "time_varying": not popov, "linear": False}
    ends = {"sector": ["-100/101", "100/101"], "time_varying": True, "operator": "performance"}
    plant = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": [["1", "1"]]}
    plant |= {"C": [["1"], ["1"]], "D": [["0", "0"], ["0", "0"]]}
    laws = {"channels": [law, law | ends], "repeated": False}
    given = {"lambda": ["1", "1/2"], **({"theta": ["1/8", "0"]} if popov else {})}
    proof = {"method": "determinant"}
    if name.startswith("full-block"):
        given |= {"lambda": ["0", "1/2"], "Pi": [["1/1000"], ["1", "-1999/1000"]]}
        proof = {"method": "matrix", "exponent": 0, "P": [["1"]]}
    if beside:
        plant |= {"A": [["-1", "0"], ["1", "0"]], "B": [["1", "1"], ["0", "0"]], "C": [["1", "0"], ["1", "0"]]}
        proof = {"method": "matrix", "exponent": 0, "P": [["1"], ["0", "0"]], "semidefinite": True}
    draft = {"verdict": "PROVED", "system": plant, "laws": laws, "multiplier": given, "proof": proof}
    return complete_and_check(draft | {"theorem": "diagonal-circle" if beside else name})


def test_a_gain_is_said_of_the_energies_of_w_and_z():
    text = coq_text(gain())
    for name in ("beside", "full-block-circle"):
        assert "forall t, s <= t -> Ez t - Ez s <= (10201 / 10000) * (Ew t - Ew s)." in coq_text(gain(name))
    assert "(forall t, 0 < t -> derivable_pt_lim Ez t (output x w t ^ 2)) ->" in text
    assert "forall t, s <= t -> Ez t - Ez s <= (10201 / 10000) * (Ew t - Ew s)." in text
    found = l2_gain("1/(z - 1/2)", Sector(0, 0.5)).proof  # 1/(z - 1/2 + g), g from 0 to 1/2: 2
    text = coq_text(found)
    assert "forall k, sum_f_R0 (fun t => output x w t ^ 2) k" in text
    assert "(x 0%nat 0%nat = 0) ->" in text


@needs_coq
@pytest.mark.slow
@pytest.mark.parametrize("name", ["diagonal-circle", "diagonal-popov", "full-block-popov", "beside"])
def test_a_gain_compiles_and_what_is_falsified_does_not(name, library):
    text = coq_text(gain(name))
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("(10201 / 10000) * (Ew", "(9999 / 10000) * (Ew"),
        ("in_sector 0 1", "in_sector (-1) 1"),
        ("(-1) * x 0%nat t", "(-9 / 10) * x 0%nat t"),
        ("(x 0%nat s = 0) ->", "(x 0%nat s = 1) ->"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


@needs_coq
@pytest.mark.thorough
def test_a_gain_in_discrete_time_compiles_and_a_smaller_one_does_not(library):
    text = coq_text(l2_gain("1/(z - 1/2)", Sector(0, 0.5)).proof)
    ok, said = compiled(library, text)
    assert ok, said
    (bound,) = re.findall(r"<= (\(.*\)) \* sum_f_R0", text)
    assert not compiled(library, changed(text, f"<= {bound}", "<= 3"))[0]

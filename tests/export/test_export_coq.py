"""Certificates as files for Coq: true ones compile, falsified ones do not."""

import json
import math
import re
from fractions import Fraction
from pathlib import Path

import pytest
from plants import ODD, SIXTH, TURNED
from replayed import KEPT, LOOP, changed, compiled, names, needs_coq, proved, resting_on_axioms

from lure import RationalPlant
from lure.analysis import analyse, certify
from lure.analysis.certificates import arithmetic as exact
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.systems import system_of
from lure.analysis.export import coq_text, powers
from lure.analysis.export.circle import tree
from lure.analysis.export.orbits import orbit_text
from lure.analysis.export.quadratic import definite, matrix_of, nonnegative, rounded, shortest
from lure.analysis.export.relying import halves
from lure.analysis.export.waves import ONE, Waves, angle
from lure.errors import InputError
from lure.files.builtin import builtin_loop, loop_names
from lure.plants.state_space import StateSpace

THIRD = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "2", "0"]}


def popov():
    return proved(THIRD, "59/10", "popov", {"theta": "3/2"})


def steps():
    """``2 xi(t+1) - xi(t) = -phi(xi(t))``: ``Re 1/(2 z - 1) >= -1/3``, so that the circle criterion proves below 3."""
    system = {"kind": "transfer", "time": "discrete", "numerator": ["1"], "denominator": ["2", "-1"]}
    return proved(system, "5/4")


@needs_coq
@pytest.mark.thorough
def test_popov_in_the_critical_case_compiles_and_rests_on_the_axioms_of_the_reals_alone(library):
    text = coq_text(popov())
    assert "1 * xi 3%nat t + 3 * xi 2%nat t + 2 * xi 1%nat t" in text  # the plant's own coefficients
    assert "(in_sector 0 (59 / 10) phi)" in text
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (("tends_to (xi 0%nat) c", "tends_to (xi 0%nat) 0"), ("0 * c = - phi", "1 * c = - phi")):
        assert not compiled(library, changed(text, right, wrong))[0]
    assert resting_on_axioms(said)


def test_a_file_holds_no_lemma_that_nothing_after_it_uses():
    text = coq_text(popov())
    found = names(text.partition(LOOP)[0])
    assert {"qf_add", "tends_to"} < {*found}
    for name in found:
        after = re.split(rf"^\w+ {name}\b", text, maxsplit=1, flags=re.MULTILINE)[1]
        assert re.search(rf"\b{name}\b", after), name
    assert text.count("(* ----") > 4
    assert not re.search(r"---- \*\)\s+\(\* ----", text)


# The denominator of 2/(s^3 + 3 s^2 + 2 s - 1) with the gain 1/2 is s^3 + 3 s^2 + 2 s, as that of THIRD.
CRITICAL = {"kind": "transfer", "time": "continuous", "numerator": ["2"], "denominator": ["1", "3", "2", "-1"]}
STEPPED = {"kind": "transfer", "time": "discrete", "numerator": ["1", "0"], "denominator": ["1", "-2", "1/2"]}
INTEGRATOR = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "0"]}


def rings(*, varying=False):
    """``x1' = x2 - x1 - phi(x1 + 2 x2)``, ``x2' = x1 - x2``, by a matrix."""
    draft = matrix_draft(StateSpace([[-1, 1], [1, -1]], [1, 0], [1, 2]), Fraction(1))
    draft["laws"] |= {"time_varying": varying}
    return coq_text(complete_and_check(draft))


def test_in_the_critical_case_the_state_converges_to_an_equilibrium():
    draft = proved(CRITICAL, "3", "popov", {"theta": "3/2"}, lower="1/2")
    assert (
        "  tends_to (xi 1%nat) 0 /\\ tends_to (xi 2%nat) 0 /\\\n  exists c, tends_to (xi 0%nat) c /\\\n"
        "    ((forall y, continuity_pt phi y) -> (-1) * c = - phi (2 * c)).\n"
    ) in coq_text(draft)
    assert "  exists c, tends_to (xi 0%nat) c.\nProof." in coq_text(proved(INTEGRATOR, "5", varying=True))
    stepped = coq_text(proved(STEPPED, "3/4", lower="1/2"))  # z^2 - 3/2 z + 1/2 with the gain 1/2
    assert (
        "  exists c, Un_cv xi c /\\\n    ((forall y, continuity_pt phi y) -> (-1 / 2) * c = - phi (1 * c))." in stepped
    )
    text = rings()
    assert "exists c, tends_to (x 0%nat) (1 * c) /\\ tends_to (x 1%nat) (1 * c) /\\\n" in text
    assert "(forall y, continuity_pt phi y) -> 0 * c = 1 * phi (3 * c))." in text


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("number", range(8))
def test_the_critical_case_compiles_and_what_is_falsified_does_not(number, library):
    text = [
        lambda: coq_text(proved(CRITICAL, "3", "popov", {"theta": "3/2"}, lower="1/2")),
        lambda: coq_text(proved(INTEGRATOR, "5", varying=True)),
        lambda: coq_text(proved(INTEGRATOR, "finite")),
        lambda: coq_text(proved(THIRD | {"numerator": ["1", "1"], "denominator": ["1", "2", "0"]}, "finite")),
        rings,
        lambda: rings(varying=True),
        lambda: coq_text(proved(STEPPED, "3/4", lower="1/2")),
        lambda: coq_text(proved(STEPPED | {"denominator": ["1", "-3/2", "1/2"]}, "1/4", varying=True)),
    ][number]()
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("(-1) * c = - phi (2 * c)", "(-1) * c = - phi (3 * c)"),
        ("in_sector 0 5 (phi t)", "in_sector (-1) 5 (phi t)"),
        ("tends_to (x 1%nat) (1 * c)", "tends_to (x 1%nat) (2 * c)"),
        ("0 * c = 1 * phi", "0 * c = 1 + phi"),
        ("Un_cv xi c", "Un_cv xi 0"),
        ("in_sector 0 (1 / 4)", "in_sector (-1) (1 / 4)"),
    ):
        assert right not in text or not compiled(library, changed(text, right, wrong))[0]


@needs_coq
@pytest.mark.slow
def test_discrete_time_compiles(library):
    text = coq_text(steps())
    assert "Un_cv xi 0" in text
    ok, said = compiled(library, text)
    assert ok, said


@needs_coq
@pytest.mark.thorough
def test_every_finite_bound_compiles_where_nothing_is_left_at_infinite_frequency(library):
    """``Re (s + 1)/(s (s + 2)) = 1/(4 + omega^2)``, from the product with the conjugate of the denominator."""
    plant = {"kind": "transfer", "time": "continuous", "numerator": ["1", "1"], "denominator": ["1", "2", "0"]}
    text = coq_text(proved(plant, "finite"))
    assert "(K : R) (phi : R -> R) (xi : nat -> R -> R),\n  (0 < K) ->\n  (in_sector 0 K phi) ->" in text
    ok, said = compiled(library, text)
    assert ok, said
    assert not compiled(library, text.replace("+ 2 * xi 1%nat t", "+ (1 / 2) * xi 1%nat t"))[0]  # Re H < 0 far out
    varying = coq_text(proved(plant, "finite", varying=True))
    assert "(forall t, in_sector 0 K (phi t)) ->" in varying
    ok, said = compiled(library, varying)
    assert ok, said


@needs_coq
@pytest.mark.thorough
def test_several_channels_compile_from_a_determinant(library):
    shown = certify(builtin_loop("secant-ring")).shown  # the class of the file: both sectors are [0, 2]
    assert (shown.theorem, shown.certificate["proof"]["method"]) == ("diagonal-popov", "determinant")
    text = coq_text(shown)
    assert "(in_sector 0 2 phi1) ->\n  (in_sector 0 2 phi2) ->" in text
    ok, said = compiled(library, text)
    assert ok, said
    assert not compiled(library, text.replace("in_sector 0 2 phi2", "in_sector 0 9 phi2"))[0]


# H = diag(1/(s + 1), 1/(s + 2)), phi_1 in [-1/2, 1], phi_2 in [0, 5]: Pi is 2 y z + sigma^2/4 with y = phi - l sigma,
# z = u sigma - phi, 1/4 at every vertex of the gains; or by cones, N the form 2 y z, with phi^2/4 beside it
def full_block(*, cones=False, **rate):
    law = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    laws = {"channels": [law | {"sector": ends} for ends in (["-1/2", "1"], ["0", "5"])], "repeated": False}
    plant = {
        "kind": "multivariable",
        "time": "continuous",
        "A": [["-1", "0"], ["0", "-2"]],
        "D": [["0", "0"], ["0", "0"]],
    }
    plant |= {"B": [["1", "0"], ["0", "1"]], "C": [["1", "0"], ["0", "1"]]}
    c = "-7/4" if cones else "-2"
    part = [["0"], ["0", "0"], ["1", "0", "0"], ["0", "1", "0", "0"]]
    data = {"Pi": [["5/4"], ["0", "1/4"], ["1/2", "0", c], ["0", "5", "0", c]]} | ({"N": [part, part]} if cones else {})
    draft = {"verdict": "PROVED", "system": plant, "laws": laws, "theorem": "full-block-circle", "multiplier": data}
    return coq_text(
        complete_and_check(draft | rate | {"proof": {"method": "matrix", "P": [["1"], ["0", "4"]], "exponent": 0}})
    )


@pytest.mark.parametrize("cones", [False, True])
def test_a_full_block_is_tested_for_the_gains_of_both_classes(cones):
    assert "box : list (ratio * ratio) := [((2, -1), (1, 1)); ((1, 0), (1, 5))]%Z." in full_block(cones=cones)


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("rate", [{}, {"rate": "1/50"}])
@pytest.mark.parametrize("cones", [False, True])
def test_full_blocks_compile_and_falsified_ones_do_not(cones, rate, library):
    text = full_block(cones=cones, **rate)
    assert "(forall t, in_sector 0 5 (phi2 t)) ->" in text
    assert ("exp (- (2 * (1 / 50) * (t - s)))" in text) == bool(rate)
    ok, said = compiled(library, text)
    assert ok, said
    block = "Definition block : list (list Z) := [["
    first, wrong = ("[[5; 2;", "[[1; 2;") if not (cones or rate) else (block, f"{block}-")
    for right, other in (
        (first, wrong),  # one digit of Pi, or one sign
        ("((1, 0), (1, 5))", "((1, 0), (1, 6))"),  # the box of the test is no longer that of the class
        ("in_sector 0 5", "in_sector 0 6"),
        ("((-2) * x 1%nat t", "(2 * x 1%nat t"),  # one sign of the plant
    ):
        assert not compiled(library, changed(text, right, other))[0]


# 1 + 2/(s + 1), theta = 1/4: 1/3 + 1 + Re (1 + i w/4) 2/(1 + i w) = 4/3 + (2 + w^2/2)/(1 + w^2) > 0; psi in [0, 3/4]
@needs_coq
@pytest.mark.thorough
def test_popov_with_a_feedthrough_compiles_and_falsified_files_do_not(library):
    plant = {"kind": "transfer", "time": "continuous", "numerator": ["1", "3"], "denominator": ["1", "1"]}
    text = coq_text(proved(plant, "3", "popov", {"theta": "1/4"}))
    assert "(in_sector 0 3 phi) ->\n  (forall s, psi (s + 1 * phi s) = phi s) ->" in text
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (("in_sector 0 3 phi", "in_sector 0 4 phi"), ("psi (s + 1 * phi s)", "psi (s + 2 * phi s)")):
        assert not compiled(library, changed(text, right, wrong))[0]


# s^2 + s + 1 in [0, 7/2] (the circle criterion ends at 3), in states, and with 1/7 beside it, where 7 becomes 7/(1 + 1)
@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("form", ["polynomials", "matrices", "feedthrough"])
def test_forms_of_higher_degree_compile_and_falsified_ones_do_not(form, library):
    kept, upper, place = KEPT["homogeneous-lyapunov"], "(7 / 2)", "1 * xi 1%nat t"
    if form == "matrices":
        states = {"A": [["0", "1"], ["-1", "-1"]], "b": ["0", "1"], "c": ["1", "0"], "d": "0"}
        kept, place = kept | {"system": {"kind": "state-space", "time": "continuous", **states}}, "(-1) * x 1%nat t"
    if form == "feedthrough":
        laws, tops = kept["laws"] | {"sector": ["0", "7"]}, {"numerator": ["1/7", "1/7", "8/7"]}
        kept, upper = kept | {"laws": laws, "system": kept["system"] | tops}, "7"
    text = coq_text(complete_and_check(kept))
    assert f"(forall t, in_sector 0 {upper} (phi t)) ->" in text
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        (f"in_sector 0 {upper}", "in_sector 0 (19 / 2)"),
        (f" {place}", f" (-2) * {place.partition('* ')[2]}"),
        ("Definition P : list (list Z) := [[", "Definition P : list (list Z) := [[-"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], right


# (2 x + 3 y)^2 + y^2/2^30 leaves 2^-30 beside a square: seen with 2^40 in front, where what is cut off is below 4
def test_what_a_step_cuts_off_is_made_up_for():
    square = [(1 << 40, [2, 3], [2, 3])]
    assert definite([*square, (1 << 10, [0, 1], [0, 1])], 2)
    assert not definite(square, 2)
    assert not definite([*square, (-1, [0, 1], [0, 1])], 2)


# 2^40 (x^2 + y^2): entries 2^41 of which k digits are cut off and that give way by 2 leave something for k <= 39
def test_digits_are_cut_off_while_the_form_is_seen():
    assert shortest([(1 << 40, [1, 0], [1, 0]), (1 << 40, [0, 1], [0, 1])], 2) == 39
    assert shortest([(1, [1, 1], [1, 1])], 2) == -1


@needs_coq
@pytest.mark.slow
def test_falsified_files_do_not_compile(library):
    text, own = coq_text(popov()), coq_text(popov()).partition(LOOP)[2]
    P = re.search(r"Definition P .*?:= \[\[(\d+);", own, re.DOTALL)[1]
    for right, wrong in (
        ("+ 3 * xi 2%nat t", "+ 2 * xi 2%nat t"),  # one digit of the plant
        ("+ 2 * xi 1%nat t", "+ (-2) * xi 1%nat t"),  # one sign of it
        ("in_sector 0 (59 / 10)", "in_sector 0 (69 / 10)"),  # 6 is the end
        (f"[[{P};", f"[[-{P};"),
    ):
        assert right in own
        ok, said = compiled(library, text.replace(right, wrong))
        assert not ok
        assert "Error" in said


def exported(name):
    """The file of a kept certificate, or why there is none."""
    try:
        return coq_text(check(KEPT[name])), ""
    except InputError as refusal:
        return None, str(refusal)


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("name", list(KEPT))
def test_every_kept_certificate_is_exported_and_compiles_or_is_refused(name, library):
    text, refusal = exported(name)
    if text is None:
        assert refusal.startswith("this certificate cannot be exported to Coq: ")
    else:
        ok, said = compiled(library, text)
        assert ok, said


# the circle criterion ends at .8956675152815 for this plant; so close by a P that doubles are sure of is none
@pytest.mark.slow
def test_close_to_the_end_of_the_criterion_a_form_is_found_in_exact_numbers():
    top, bottom = ["400", "-200", "400"], ["1", "60", "1100", "6000"]
    plant = {"kind": "transfer", "time": "continuous", "numerator": top, "denominator": bottom}
    end = "4033727888069593/4503599627370496"
    laws = {"sector": ["0", end], "slope": None, "odd": False, "time_varying": True, "linear": False}
    draft = {"verdict": "PROVED", "system": plant, "laws": laws, "theorem": "circle", "multiplier": {}}
    text = coq_text(complete_and_check(draft | {"proof": {"method": "polynomial"}}))
    assert f"in_sector 0 ({end.replace('/', ' / ')}) (phi t)" in text


def slopes(system, upper, theorem, multiplier):
    """A draft for slopes in [0, upper]."""
    ends = ["0", upper]
    laws = {"sector": ends, "slope": ends, "odd": False, "time_varying": False, "linear": False}
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": theorem, "multiplier": multiplier}
    return coq_text(complete_and_check(draft | {"proof": {"method": "polynomial"}}))


@needs_coq
@pytest.mark.thorough
def test_an_inequality_and_poles_compile_and_the_theorem_relied_on_is_named(library):
    lag = {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "3", "3", "1"]}
    text = slopes(lag, "7", "park", {"theta": "1", "tau": "1/10"})  # 1/(s + 1)^3: stable for gains below 8
    assert "Theorem stable : park_criterion -> forall (phi : R -> R) (xi : nat -> R -> R),\n  phi 0 = 0 ->" in text
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (("num den 0 7", "num den 0 9"), ("[1; 3; 3; 1].", "[1; 3; 3; -1].")):
        assert right in text
        assert not compiled(library, text.replace(right, wrong))[0]


def test_angles_are_enclosed_and_waves_that_reach_the_rest_have_no_intervals():
    for p, q in ((0, 1), (1, 3), (355, 113), (1000, 7)):
        c, s, off = angle(p, q)
        assert off < ONE >> 40
        assert (c / ONE, s / ONE) == pytest.approx((math.cos(p / q), math.sin(p / q)), abs=1e-11)
    assert angle(10**4, 1) is None
    for size, held in ((Fraction(99, 100), True), (Fraction(101, 100), False)):  # 1 - size cos(3 omega)
        assert (
            Waves.of(exact.real(1) + exact.Form({(Fraction(3), 0): (-size, Fraction(0))})).found() is not None
        ) is held


@needs_coq
@pytest.mark.thorough
def test_kernels_that_are_delays_compile_and_what_is_falsified_does_not(library):
    text = coq_text(check(KEPT["zames-falb, dead time"]))
    assert "Theorem stable : zames_falb_theorem_for_delays -> forall (phi : R -> R)" in text
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    kernel, widths = "[((1 / 8), (1 / 2))]", "widths : list Z := ["
    for right, wrong in (
        (kernel, "[((1 / 7), (1 / 2))]"),
        (kernel, "[((1 / 8), (2 / 3))]"),
        (widths, widths + "900000; "),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


# dt-6 with the form of three samples and the plant of docs/theory/order-cones.md, beyond all Zames-Falb multipliers
@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("odd", [False, True])
def test_order_cones_compile_and_falsified_ones_do_not(odd, library):
    plant, upper, form = (TURNED, "143/100", ODD) if odd else (builtin_loop("dt-6").block, "9/10", SIXTH)
    system, ends = system_of(plant), ["0", upper]
    laws = {"sector": ends, "slope": ends, "odd": odd, "time_varying": False, "linear": False}
    multiplier = {"taps": [], "window": [line.split() for line in form.splitlines()], "odd": odd}
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": "order-cone", "multiplier": multiplier}
    text = coq_text(complete_and_check(draft | {"proof": {"method": "polynomial"}}))
    top, bottom = upper.split("/")
    assert f"slope_class {str(odd).lower()} 0 ({top} / {bottom}) phi -> steps_of num den phi xi -> Un_cv xi 0." in text
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (
        ("Definition M : list (list Z) := [[", "Definition M : list (list Z) := [[-"),
        (f"num den 0 ({top} / {bottom})", f"num den 0 (2{top} / {bottom})"),
        ("Definition num : list R := [", "Definition num : list R := [2 * "),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


def test_a_form_is_copositive_by_halves():
    assert halves([[1, 2], [2, 1]]) == "(Leaf [(0, [4]); (0, [])])"  # x^2 + 4 x y + y^2
    assert halves([[1, -1], [-1, 1]]) == "(Leaf [(0, [0]); (0, [])])"  # a square
    with pytest.raises(InputError, match="too little room"):
        halves([[1, -2], [-2, 1]])


def test_a_witness_splits_where_a_polynomial_comes_near_to_0():
    assert tree([1, 0, 2]) == "Signs"
    assert tree([80, -77, 20]).startswith("(Split ")  # least at 77/40: 80 - 77^2/80 = 5.9


def certificates_in(found, depth=6):
    """All certificates in an answer."""
    own = getattr(found, "certificate", None)
    if isinstance(own, dict) and "format" in own:
        yield own
    parts = [getattr(found, name, None) for name in getattr(type(found), "__dataclass_fields__", {})]
    parts += found if isinstance(found, list | tuple) else found.values() if isinstance(found, dict) else []
    for part in parts if depth else ():
        yield from certificates_in(part, depth - 1)


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("name", loop_names())
def test_what_is_shown_of_the_built_in_loops_compiles_or_is_refused(name, library):
    for text in sorted({json.dumps(dict(one)) for one in certificates_in(analyse(builtin_loop(name)))}):
        try:
            written = coq_text(check(text))
        except InputError:
            continue
        ok, said = compiled(library, written)
        assert ok, said


def test_lagranges_reduction_tells_forms_that_are_nowhere_negative():
    square = (1, [1, -2], [1, -2])  # (x - 2 y)^2, singular
    assert nonnegative([square], 2)
    assert nonnegative([square, (3, [0, 1], [0, 1])], 2)
    assert not nonnegative([square, (-1, [0, 1], [0, 1])], 2)
    assert not nonnegative([(1, [0, 1], [1, 0])], 2)  # x y
    assert matrix_of([square], 2) == [[2, -4], [8]]  # twice the form: x^2 - 4 x y + 4 y^2, entries beside once


def test_a_rounded_matrix_is_symmetric_and_near():
    P = [[Fraction(4), Fraction(1, 3)], [Fraction(1, 3), Fraction(1, 700)]]
    found = rounded(P, 16)
    assert found[0][1] == found[1][0]
    assert all(
        abs(v - w) < Fraction(1, 1000)
        for row, other in zip(P, found, strict=True)
        for v, w in zip(row, other, strict=True)
    )


def beside():
    """``1/(s + 2)`` and ``1/(s (s + 1))``, the state of the first between those of the second."""
    system = {
        **{"kind": "multivariable", "time": "continuous"},
        "A": [["0", "0", "1"], ["0", "-2", "0"], ["0", "0", "-1"]],
        "B": [["0", "0"], ["1", "0"], ["0", "1"]],
        "C": [["0", "1", "0"], ["1", "0", "0"]],
        "D": [["0", "0"], ["0", "0"]],
    }
    one = {"slope": None, "odd": False, "time_varying": False, "linear": False}
    classes = [{**one, "sector": ["0", upper]} for upper in ("5", "9")]
    first = {"channels": [1], "states": [2], "kind": "multivariable", "theorem": "diagonal-circle"}
    first |= {"multiplier": {"lambda": ["1"]}, "proof": {"method": "matrix", "P": [["4"]], "exponent": 0}}
    # |d|^2/9 + Re (1 + i w) n d* = x (1 + x)/9
    second = {"channels": [2], "states": [1, 3], "kind": "transfer", "theorem": "popov", "multiplier": {"theta": "1"}}
    second["proof"] = {"method": "polynomial", "variable": "omega^2", "coefficients": ["1", "1"], "limits": ["1", "1"]}
    draft = {"verdict": "PROVED", "system": system, "laws": {"channels": classes, "repeated": False}}
    proof = {"method": "parts", "parts": [first, second]}
    return complete_and_check({**draft, "theorem": "parts", "multiplier": {}, "proof": proof})


def test_loops_side_by_side_are_a_module_each_and_one_theorem():
    text = coq_text(beside())
    stated = text[text.rindex("Theorem stable") :]
    assert "(forall t, 0 < t -> derivable_pt_lim (x 0%nat) t (1 * x 2%nat t))" in stated
    assert "  tends_to (x 1%nat) 0 /\\ tends_to (x 2%nat) 0.\n" in stated  # in the order of the parts
    assert text.count("Module Part") == 2


@needs_coq
@pytest.mark.thorough
def test_loops_side_by_side_compile_and_what_is_falsified_does_not(library):
    text = coq_text(beside())
    ok, said = compiled(library, text)
    assert ok, said
    whole = text.rindex("Theorem stable")
    for old, new in (
        ("tends_to (x 2%nat) 0", "tends_to (x 0%nat) 0"),  # the integrator, which need not tend to 0
        ("derivable_pt_lim (x 1%nat) t ((-2)", "derivable_pt_lim (x 1%nat) t (2"),
        ("(in_sector 0 9 phi2)", "(in_sector 0 10 phi2)"),
    ):
        assert text.count(old, whole) == 1
        assert not compiled(library, text[:whole] + text[whole:].replace(old, new))[0]


def integrating(*, discrete=False):
    """``x1' = -phi1``, ``x2' = -x2 - phi1 - phi2``; in samples ``x1+ = x1 - phi1``, ``x2+ = x2/2 - phi2``.

    There, with ``P = 1``, ``V - V+ - 2 phi1 (x1 - phi1) - 2 phi2 (x2/2 - phi2)`` is ``phi1^2 + 3/4 x2^2 + phi2^2``.
    """
    one = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    uppers = ("1", "1/2") if discrete else ("1", "1")
    laws = {"channels": [{**one, "sector": ["0", upper]} for upper in uppers], "repeated": False}
    system = {"kind": "multivariable", "time": "discrete" if discrete else "continuous", "D": [["0", "0"], ["0", "0"]]}
    system |= {
        "A": [["1", "0"], ["0", "1/2"]] if discrete else [["0", "0"], ["0", "-1"]],
        "C": [["1", "0"], ["0", "1"]],
    }
    system |= {"B": [["1", "0"], ["0" if discrete else "1", "1"]]}
    proof = {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0, "zero": [["1", "0", "0", "0"]]}
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "theorem": "diagonal-circle"}
    proof = proof if discrete else {"method": "determinant"}
    return coq_text(complete_and_check(draft | {"multiplier": {"lambda": ["1", "1"]}, "proof": proof}))


def test_beside_eigenvalues_0_of_several_channels_the_rest_tends_to_0():
    text = integrating()
    assert "(x 1%nat) t ((-1) * x 1%nat t + (-1) * w 0%nat t + (-1) * w 1%nat t)) ->\n  tends_to (x 1%nat) 0.\n" in text
    assert "\n  Un_cv (x 1%nat) 0.\n" in integrating(discrete=True)


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("discrete", [False, True])
def test_eigenvalues_0_of_several_channels_compile_and_what_is_falsified_does_not(discrete, library):
    text = integrating(discrete=discrete)
    ok, said = compiled(library, text)
    assert ok, said
    right, wrong = ("(1 / 2) * x 1%nat t", "(3 / 2) * x 1%nat t") if discrete else ("(-1) * x 1%nat t", "1 * x 1%nat t")
    end = "Un_cv" if discrete else "tends_to"
    for old, new in (
        (right, wrong),
        (f"{end} (x 1%nat) 0", f"{end} (x 0%nat) 0"),
        ("in_sector 0 1", "in_sector (-1) 1"),
    ):
        assert not compiled(library, changed(text, old, new))[0]


def joined(*, turned=False):
    """``x' = -x - phi(x)``, ``y' = -2 y - phi(y)``: the second drives the first; or turned, in ``x`` and ``x + y``."""
    if turned:
        sides = ([["-1", "0"], ["1", "-2"]], [["1", "0"], ["1", "1"]], [["1", "0"], ["-1", "1"]])
    else:
        sides = ([["-1", "7"], ["0", "-2"]], [["1", "7"], ["0", "1"]], [["1", "0"], ["0", "1"]])
    system = {"kind": "multivariable", "time": "continuous", "D": [["0", "0"], ["0", "0"]]}
    system |= dict(zip("ABC", sides, strict=True))
    one = {"slope": None, "odd": False, "time_varying": True, "linear": False}
    laws = {"channels": [{**one, "sector": ["-1/2", "1"]}, {**one, "sector": ["0", "5"]}], "repeated": False}
    parts = [
        {"channels": [i], "states": [i], "kind": "multivariable", "theorem": "diagonal-circle"}
        | {"multiplier": {"lambda": ["1"]}, "proof": {"method": "matrix", "P": [[P]], "exponent": 0}}
        for i, P in ((2, "4"), (1, "1"))
    ]
    proof = {"method": "parts", "parts": parts} | ({"basis": [["1", "0"], ["1", "1"]]} if turned else {})
    draft = {"verdict": "PROVED", "system": system, "laws": laws, "multiplier": {}, "proof": proof}
    return coq_text(complete_and_check(draft | {"theorem": "parts" if turned else "cascade"}))


def test_parts_that_drive_others_are_one_theorem():
    text = joined()
    assert "derivable_pt_lim (x 0%nat) t ((-1) * x 0%nat t + 7 * x 1%nat t + (-1) * w 0%nat t + (-7)" in text
    assert "  tends_to (x 0%nat) 0 /\\ tends_to (x 1%nat) 0.\nProof." in text
    assert "Module" not in text


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("turned", [False, True])
def test_parts_that_drive_others_compile_and_what_is_falsified_does_not(turned, library):
    text = joined(turned=turned)
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (
        ("(-2) * x 1%nat t", "2 * x 1%nat t"),
        ("(-2) * x 1%nat t", "7 * x 0%nat t + (-2) * x 1%nat t"),  # each drives the other
        ("in_sector 0 5", "in_sector (-3) 5"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


def test_what_has_no_export_is_refused_in_a_sentence():
    for name, method in (("popov", "cover"), ("hurwitz", "polynomial"), ("rod-energy", "structure")):
        (one, *_) = (c for c in KEPT.values() if (c["theorem"], c["proof"]["method"]) == (name, method))
        with pytest.raises(InputError, match="cannot be exported to Coq: "):
            coq_text(check(one))
    with pytest.raises(InputError, match="it is a refutation by memory-orbit"):
        orbit_text({"proof": {"method": "memory-orbit"}}, "")


def test_a_form_that_would_take_coq_minutes_is_refused(monkeypatch):
    monkeypatch.setattr(powers, "MOST_PRODUCTS", 2)  # the kept form, of degree 4 in two states, is in x^2, x y and y^2
    with pytest.raises(InputError, match="a form in 3 products of powers takes Coq minutes; those in up to 2 have"):
        coq_text(check(KEPT["homogeneous-lyapunov"]))


def test_the_command_writes_a_file_and_refuses_names_that_coqc_does_not_take(lure, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    draft = matrix_draft(RationalPlant([1], [1, 1]), Fraction(5))
    Path("proof.json").write_text(json.dumps(dict(complete_and_check(draft).certificate)))
    status, out, err = lure("export", "proof.json", "-o", "loop.v")
    assert status == 0
    assert "coqc loop.v" in out + err
    assert Path("loop.v").read_text("utf-8").endswith("Print Assumptions stable.\n")
    for arguments, said in (
        (("export", "--coq", "proof.json", "-o", "a-loop.v"), "coqc takes names"),
        (("export", "--coq", "proof.json", "-o", "loop.v"), "exists"),
        (("export", "--coq", "missing.json", "-o", "other.v"), "does not exist"),
        (("export", "--coq", "loop.v", "-o", "loop.v"), "'loop.v' is no certificate"),  # before that it exists
    ):
        status, out, err = lure(*arguments)
        assert status == 2
        assert said in err
    assert not Path("other.v").exists()

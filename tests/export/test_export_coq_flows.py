"""Continuous time as files for Coq, periodic solutions and forms beside a pole at 0: falsified ones do not compile."""

from dataclasses import replace

import pytest
from replayed import KEPT, changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text, returning
from lure.analysis.export.quadratic import apart
from lure.errors import InputError

# s/(s^2 - s/5 + 1) with a saturation: x'' = x'/5 - x - phi(x'), whose limit cycle enters and leaves the line twice
SATURATED = KEPT["flow-orbit, half"]


def test_the_theorem_is_about_the_plant_and_its_class():
    text = coq_text(check(SATURATED))
    assert "Definition num : list R := [1; 0].\nDefinition den : list R := [1; (-1 / 5); 1].\n" in text
    assert """
  (in_sector 0 1 phi /\\ slopes_in 0 1 phi) /\\
  flow_of num den phi xi /\\
  forall c, ~ tends_to (xi 1%nat) c.
""" in text[text.rindex("Theorem moves") :]


@pytest.mark.parametrize(("longest", "stays"), [(10, [1, 0, 1, 2]), (6, [1, 0, 0, 1, 2, 2])])
def test_half_a_period_is_followed_by_its_mirror_image(monkeypatch, longest, stays):
    monkeypatch.setattr(returning, "LONGEST", (longest,))  # the stays beyond the kinks are cut in two, or not
    whole, half = (returning._Orbit(KEPT[name]).pieces for name in ("flow-orbit", "flow-orbit, half"))
    assert half == whole == stays


def test_where_seldom_cut_stays_do_not_hold_they_are_cut_more_often(monkeypatch):
    monkeypatch.setattr(returning, "LONGEST", (10, 6))
    monkeypatch.setattr(returning._Orbit, "work", lambda _self, stays, _bits: returning.MOST_WORK - (len(stays) >= 6))
    assert len(returning._Orbit(SATURATED).found.stays) == 6


def test_a_start_beside_the_orbit_fails_the_test_that_coq_makes():
    found = returning._Orbit(SATURATED).found
    assert not found.wrong
    first, *others = found.stays
    beside = replace(first, start=[first.start[0] + (found.S >> 4), *first.start[1:]])
    assert returning._Numbers([beside, *others], found.W, found.S.bit_length() - 1).wrong


def test_a_feedthrough_and_steps_of_many_digits_are_refused(monkeypatch):
    with pytest.raises(InputError, match="not one of two polynomials without a feedthrough"):
        coq_text(check(KEPT["flow-orbit, direct"]))
    monkeypatch.setattr(returning, "MOST_WORK", 1)
    with pytest.raises(InputError, match="so many digits that Coq would take minutes"):
        coq_text(check(SATURATED))


@needs_coq
@pytest.mark.slow
def test_orbits_compile_and_falsified_ones_do_not(library):
    text = coq_text(check(SATURATED))
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    stay = text[text.index("Definition stay0") :].split("matrix1 ", 1)[1].split(" ", 1)[0]
    for right, wrong in (
        ("[1; (-1 / 5); 1]", "[1; (1 / 5); 1]"),
        ("[1; (-1 / 5); 1]", "[1; (-1 / 4); 1]"),
        ("slopes_in 0 1 phi", "slopes_in 0 (1 / 2) phi"),
        (f"matrix1 {stay} ", f"matrix1 {int(stay) + (int(stay) >> 9)} "),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], (right, wrong)


# 1/(s (s + 1)) in [0, 5/4], V of degree 4: x_1 + x_2 stays where it is with the gain 0.  In states too, and for phi
# that does not depend on time, for which the limit is an equilibrium
SETTLING = KEPT["homogeneous-lyapunov, critical"]
STATES = {"kind": "state-space", "time": "continuous", "A": [["0", "1"], ["0", "-1"]], "b": ["0", "1"], "d": "0"}


def settling(form):
    if form == "polynomials":
        return SETTLING
    if form == "matrices":
        return SETTLING | {"system": STATES | {"c": ["1", "0"]}}
    return SETTLING | {"laws": SETTLING["laws"] | {"time_varying": False}}


def test_a_pole_at_0_beside_a_direct_term_has_no_export():
    wider = {"system": SETTLING["system"] | {"numerator": ["1/10", "1/10", "1"]}}
    wider |= {"laws": SETTLING["laws"] | {"sector": ["0", "10/9"]}}  # 10/9 of H + 1/10 is 1 of H
    with pytest.raises(InputError, match="its pole at 0 is beside a direct term"):
        coq_text(complete_and_check(SETTLING | wider))


def test_a_form_in_which_the_first_variable_stands_is_not_apart_from_it():
    assert apart([(1, [0, 1], [0, 1])], 2)
    assert not apart([(1, [0, 1], [0, 1]), (1, [1, 0], [1, 0])], 2)
    assert not apart([(1, [0, 1], [0, 1]), (1, [1, 0], [0, 1])], 2)
    assert not apart([(-1, [0, 1], [0, 1])], 2)


@needs_coq
@pytest.mark.slow_for("matrices", "invariant")
@pytest.mark.parametrize(
    ("form", "place", "end"),
    [
        ("polynomials", "1 * xi 1%nat t", "tends_to (xi 1%nat) 0 /\\\n  exists c, tends_to (xi 0%nat) c."),
        ("matrices", "(-1) * x 1%nat t", "exists c, tends_to (x 0%nat) (1 * c) /\\ tends_to (x 1%nat) (0 * c)."),
        ("invariant", "1 * xi 1%nat t", "((forall y, continuity_pt phi y) -> 0 * c = - phi (1 * c))."),
    ],
)
def test_forms_beside_a_pole_at_0_compile_and_falsified_ones_do_not(form, place, end, library):
    text = coq_text(complete_and_check(settling(form)))
    assert end in text
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("in_sector 0 (5 / 4)", "in_sector 0 4"),
        (f" {place}", f" (-2) * {place.partition('* ')[2]}"),
        ("Definition P : list (list Z) := [[", "Definition P : list (list Z) := [[1"),
        ("powers_fall 1", "powers_fall 0"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], right

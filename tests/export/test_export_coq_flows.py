"""Periodic solutions in continuous time as files for Coq: true ones compile, falsified ones do not."""

from dataclasses import replace

import pytest
from replayed import KEPT, changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.checker import check
from lure.analysis.export import coq_text, returning
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

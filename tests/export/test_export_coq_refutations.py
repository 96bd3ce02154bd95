"""Refutations as files for Coq: true ones compile, falsified ones do not."""

import re
from fractions import Fraction

import pytest
from replayed import KEPT, changed, compiled, names, needs_coq

from lure import Sector
from lure.analysis import certify
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.systems import system_of
from lure.analysis.export import coq_text
from lure.errors import InputError
from lure.files.builtin import builtin_loop


@pytest.fixture(scope="module")
def orbit():
    """Of discrete example 6: sigma = 154/125, 192/125 and their negatives, phi odd in the sector [0, 125/192]."""
    samples = {"u": ["0", "-1", "0", "1"], "sigma": ["154/125", "192/125", "-154/125", "-192/125"]}
    points = [["-192/125", "-1"], ["-154/125", "0"], ["0", "0"], ["154/125", "0"], ["192/125", "1"]]
    proof = {"method": "orbit", "points": points, "left": "0", "right": "0", **samples}
    laws = {"sector": ["0", "125/192"], "slope": None, "odd": True, "time_varying": False, "linear": False}
    system = builtin_loop("dt-6").block
    draft = {"verdict": "REFUTED", "system": system_of(system), "laws": laws, "theorem": "counterexample"}
    return coq_text(complete_and_check(draft | {"multiplier": {}, "proof": proof}))


@needs_coq
@pytest.mark.thorough
def test_an_orbit_compiles_and_another_does_not(orbit, library):
    assert "exists (phi : R -> R) (sigma : nat -> R)," in orbit
    ok, said = compiled(library, orbit)
    assert ok, said
    assert "in_sector 0 (125 / 192)" in orbit
    assert not compiled(library, orbit.replace("in_sector 0 (125 / 192)", "in_sector 0 (124 / 192)"))[0]


def unstable(n, d, upper, gain, time="continuous"):
    """A constant gain that refutes a sector."""
    laws = {"sector": ["0", upper], "slope": None, "odd": False, "time_varying": False, "linear": False}
    system = {"kind": "transfer", "time": time, "numerator": n.split(), "denominator": d.split()}
    draft = {"verdict": "REFUTED", "system": system, "laws": laws, "theorem": "counterexample", "multiplier": {}}
    return coq_text(complete_and_check(draft | {"proof": {"method": "linear-gain", "gain": gain}}))


# (s + 1)^3 + 8 has the roots +-i sqrt 3.
@needs_coq
@pytest.mark.thorough
def test_a_gain_with_a_pair_of_roots_on_the_axis_compiles(library):
    text = coq_text(check(KEPT["linear gain"]))
    assert "  0 <= g <= 9 /\\\n" in text
    start = Fraction(re.search(r"set \(w := \((\d+ / \d+)\)", text)[1].replace(" ", ""))
    assert start**2 < 3 < (start + Fraction(1, 20)) ** 2
    ok, said = compiled(library, text)
    assert ok, said
    assert not compiled(library, changed(text, "0 <= g <= 9", "0 <= g <= 7"))[0]


# (s^2 + 2)(s + 3) for the last gain of the class; z^2 + (2 g - 1/2) z + 1, also for the last; s^2;
# s - 1 + g; s^2 - s + 1 + g, whose roots have the real part 1/2 for every g; z - 2 + g, without an upper bound;
# z^2 - 3 z + 4 + g, of modulus 2 and above; z^2 - z/2 + g, of modulus 1 for g = 1; -1, of the gain that a matrix shows.
@needs_coq
@pytest.mark.thorough
def test_gains_with_roots_of_other_kinds_compile(library):
    texts = [
        unstable("1", "1 3 2 0", "6", "6"),
        unstable("2 23/25", "1 -1/2 0", "25/23", "25/23", "discrete"),
        unstable("1 1", "1 0 0", "1", "0"),
        unstable("1", "1 -2 1", "1", "0", "discrete"),
        unstable("1", "1 -1", "1/2", "1/4"),
        unstable("1", "1 -1 1", "1", "1/2"),
        unstable("1", "1 -2", "inf", "1/4", "discrete"),
        unstable("1", "1 -3 4", "1/2", "1/4", "discrete"),
        coq_text(check(KEPT["linear gain, discrete"])),
        coq_text(check(KEPT["matrix gain, discrete"])),
        coq_text(check(KEPT["crossing, rational"])),
    ]
    for text in texts:
        ok, said = compiled(library, text)
        assert ok, said


# z^2 - z/2 + g, gains 3/2, 0, 3/2 in turn: the period has the eigenvalues -11/8 and 0
@needs_coq
@pytest.mark.thorough
def test_gains_in_turn_compile_in_discrete_time_and_falsified_ones_do_not(library):
    text = coq_text(check(KEPT["switched gain, discrete"]))
    assert (
        "  (forall t, 0 <= g t <= (3 / 2)) /\\\n  (forall t, shifts den xi t = - (g t * shifts num xi t)) /\\" in text
    )
    ok, said = compiled(library, text)
    assert ok, said
    for right, wrong in (
        ("0 <= g t <= (3 / 2)", "0 <= g t <= (1 / 2)"),
        ("Definition den : list R := [1; (-1 / 2)", "Definition den : list R := [1; (1 / 2)"),
        ("Definition gains : list R := [(3 / 2); 0", "Definition gains : list R := [0; 0"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


TWICE = {
    **{"kind": "multivariable", "time": "continuous"},  # 1/((s + 1) (s + 2)^2) by a chain, its end back to the middle
    "A": [["-1", "1", "0"], ["0", "-2", "1"], ["0", "0", "-2"]],
    "B": [["0", "0"], ["0", "1"], ["1", "0"]],
    "C": [["1", "0", "0"], ["0", "0", "1"]],
    "D": [["0", "0"], ["0", "0"]],
}
STEPS = {
    **{"kind": "multivariable", "time": "discrete", "A": [["0", "1"], ["-1/2", "0"]], "B": [["0", "1/3"], ["1", "0"]]},
    **{"C": [["1", "0"], ["0", "1"]], "D": [["0", "0"], ["1/5", "0"]]},
}


def refuted_by(system, *gains):
    one = {"slope": None, "odd": False, "time_varying": False, "linear": False}
    classes = [{**one, "sector": ["0", upper]} for upper in ("60", "1")]
    draft = {"verdict": "REFUTED", "system": system, "laws": {"channels": classes, "repeated": False}}
    proof = {"method": "linear-gains", "gains": list(gains)}
    return complete_and_check({**draft, "theorem": "counterexample", "multiplier": {}, "proof": proof})


def test_gains_of_several_channels_move_the_states_of_the_plant():
    text = coq_text(refuted_by(TWICE, "50", "1/8"))
    stated = text[text.rindex("Theorem moves") :]
    assert "derivable_pt_lim (x 1%nat) t ((-2) * x 1%nat t + 1 * x 2%nat t + (-1) * w 1%nat t)" in stated
    assert "(forall t, w 1%nat t = g1 * (1 * x 2%nat t))" in stated
    assert "~ (forall k, (k < 3)%nat -> tends_to (x k) (c k))" in stated
    apart = {**TWICE, "A": [["-1", "0", "0"], ["0", "-2", "0"], ["0", "0", "3"]]}  # no input moves all of them
    assert "  forall B, exists t, 0 <= t /\\ B < norm2 [x 0%nat t;" in coq_text(refuted_by(apart, "0", "0"))
    with pytest.raises(InputError, match="no forms of few enough digits"):
        coq_text(refuted_by({**apart, "A": [*apart["A"][:2], ["0", "0", "0"]]}, "0", "0"))


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(("system", "gains"), [(TWICE, ("50", "1/8")), (STEPS, ("2", "1/2"))])
def test_gains_of_several_channels_compile_and_what_is_falsified_does_not(library, system, gains):
    text = coq_text(refuted_by(system, *gains))
    ok, said = compiled(library, text)
    assert ok, said
    whole = text.rindex("Theorem moves")
    entry = "(-2) * x 1%nat" if system is TWICE else "(-1 / 2) * x 0%nat"
    for old, new in ((entry, entry.replace("(-", "(")), ("0 <= g0 <= 60", "0 <= g0 <= 1")):
        assert text.count(old, whole) == 1
        assert not compiled(library, text[:whole] + text[whole:].replace(old, new))[0]


@pytest.mark.parametrize("name", ["orbit", "equilibrium", "switched gain", "switched gain, discrete", "linear gain"])
def test_a_whole_file_defines_no_name_twice(name):
    """The tests compile the lemmas apart, where a name may come again; ``coqc`` refuses it in one file."""
    found = names(coq_text(check(KEPT[name])))
    assert len(found) == len({*found})


# s^2 (s + 1), (z - 1)^2: beside constants, which are equilibria, t is a solution
@pytest.mark.parametrize(("loop", "limit"), [(("-1", "1 1 0 0"), "tends_to (xi 0%nat)"), (("1", "1 -2 1"), "Un_cv xi")])
def test_a_double_root_of_constants_is_no_equilibrium(loop, limit):
    text = unstable(*loop, "1", "0", "discrete" if limit == "Un_cv xi" else "continuous")
    assert f"  forall c, ~ {limit} c.\nProof." in text


# 1 - g for g = 1
def test_no_other_solution_stands_for_what_was_refuted():
    with pytest.raises(InputError, match="not well posed"):
        unstable("-1 -3", "1 1", "3", "1")


END = "1076421883593683/439804651110400"  # d + END n has roots of modulus 1 + 1e-15: too near for their place


# (s - 1) (s + 2 + g), whose root 1 no gain moves: constants for g = -2 are equilibria, which do not stand for it
@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("loop", "grows"),
    [
        (("-1 1", "1 1 -2", "3", "0"), "forall B, exists t, 0 <= t /\\ B < norm2"),
        (("-1/2 1/10", "1 -9/10 79/100 89/1000", END, END, "discrete"), "forall B, ~ (forall t, norm2"),
    ],
)
def test_a_gain_whose_root_is_not_placed_is_shown_by_a_form(loop, grows, library):
    text = unstable(*loop)
    assert grows in text[text.rindex("Theorem moves") :]
    ok, said = compiled(library, text)
    assert ok, said
    end = text.rindex("Theorem moves")
    assert not compiled(library, text[:end] + changed(text[end:], "1 * x 1%nat t", "(-1) * x 1%nat t"))[0]


@pytest.mark.parametrize("plant", ["exp(-s)/(s+1)", "exp(-s)/(s+1+exp(-s)/2)", "1/(s^2+s/5+4)+exp(-s)/8"])
def test_a_plant_with_dead_time_is_refused_for_its_dead_time(plant):
    found = certify(plant, Sector(0, Fraction(1, 4)))
    with pytest.raises(InputError, match="its plant has dead time, beside which there is no export"):
        coq_text(check(found.certificate))

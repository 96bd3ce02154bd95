"""Orbits and equilibria of several channels as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.errors import InputError

LINE = {"points": [["0", "0"]], "left": "0", "right": "1"}


def shown(time, A, laws, *, repeated=False, **proof):
    """``x+ = A x - B phi(x)``, or the same of ``x'``, ``phi`` with slopes in [0, 1]."""
    one = {"sector": ["0", "1"], "slope": ["0", "1"], "odd": False, "time_varying": False, "linear": False} | laws
    system = {"kind": "multivariable", "time": time, "A": A, "B": [["-2", "-1"], ["9/2", "3"]]}
    system |= {"C": [["1", "0"], ["0", "1"]], "D": [["0", "0"], ["0", "0"]]}
    draft = {"verdict": "REFUTED", "system": system, "laws": {"channels": [one, one], "repeated": repeated}}
    return complete_and_check({**draft, "theorem": "counterexample", "multiplier": {}, "proof": proof})


def resting(time="continuous", **laws):
    """At rest ``sigma = (2, -9/2) phi_1 + (1, -3) phi_2``: ``(1, -9/4)`` with ``phi = max(sigma, 0)/2`` in both."""
    A = [["-1", "0"], ["0", "-1"]] if time == "continuous" else [["0", "0"], ["0", "0"]]
    half = LINE | {"right": "1/2"}
    given = {"nonlinearities": [half], "inputs": ["1/2", "0"], "state": ["1", "-9/4"]}
    return coq_text(shown(time, A, laws, repeated=True, method="equilibrium", **given))


def turning():
    """``(-3, 9/2) - (-2, 9/2) = (-1, 0)`` follows on ``(1, 0)``, with ``phi_1 = sigma`` and ``phi_2 = 0``."""
    A = [["-3", "0"], ["9/2", "1/2"]]
    line = {"points": [["0", "0"]], "left": "1", "right": "1"}
    given = {"nonlinearities": [line, line | {"left": "0", "right": "0"}], "inputs": [["1", "0"]], "state": ["1", "0"]}
    return coq_text(shown("discrete", A, {"odd": True}, method="sampled-orbit", half=True, **given))


def test_a_state_that_stays_is_a_solution_of_the_plant():
    text = resting()
    stated = text[text.rindex("Theorem moves") :]
    assert "(in_sector 0 1 phi0 /\\ slopes_in 0 1 phi0)" in stated
    assert "(forall t, w 1%nat t = phi0 (1 * x 1%nat t))" in stated  # one nonlinearity in both
    assert "derivable_pt_lim (x 0%nat) t ((-1) * x 0%nat t + 2 * w 0%nat t + 1 * w 1%nat t)" in stated
    assert "  ~ tends_to (x 0%nat) 0.\n" in stated
    endless = resting(sector=["0", "finite"], slope=None)
    assert (
        "(in_sector 0 1 phi0 /\\ (exists a b, slopes_in a b phi0)) /\\" in endless
    )  # a smaller class, with finite bounds
    with pytest.raises(InputError, match="slope bounds beyond those of the sector"):
        resting(slope=["-1", "2"])


def test_an_orbit_of_several_channels_goes_on_with_its_negative():
    text = turning()
    assert "Definition x0 : list R := [1; (-1)]." in text
    assert "slopes_in 0 1 phi1 /\\ odd phi1)" in text
    assert "  forall c, ~ Un_cv (x 0%nat) c.\n" in text


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("time", ["continuous", "discrete"])
def test_an_equilibrium_compiles_and_what_is_falsified_does_not(library, time):
    text = resting(time)
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        ("in_sector 0 1 phi0", "in_sector 0 (1 / 3) phi0"),  # the slope is 1/2
        ("2 * w 0%nat t + 1 * w 1", "(-2) * w 0%nat t + 1 * w 1"),
        ("[1; (-9 / 4)]", "[1; (-8 / 4)]"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0]


@needs_coq
@pytest.mark.thorough
def test_an_orbit_of_several_channels_compiles_and_what_is_falsified_does_not(library):
    text = turning()
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    whole = text.rindex("Theorem moves")
    for right, wrong in (
        ("(-3) * x 0%nat t", "3 * x 0%nat t"),
        ("odd phi1", "odd phi1 /\\ slopes_in 2 3 phi1"),
        ("~ Un_cv (x 0%nat) c", "~ Un_cv (x 1%nat) c"),  # which is 0 at all times
    ):
        assert text.count(right, whole) == 1
        assert not compiled(library, text[:whole] + text[whole:].replace(right, wrong))[0]

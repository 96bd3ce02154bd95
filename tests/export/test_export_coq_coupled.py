"""Forms of channels with one nonlinearity, and what slope bounds say of integrals, as files for Coq."""

import pytest
from replayed import changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text

SLOPED = {"sector": ["0", "1"], "slope": ["0", "1"], "odd": False, "time_varying": False, "linear": False}


def coupled(time="continuous", rows=(("1", "-1/2"), ("-1/4", "1")), *, kind="monotone", theta=None, **more):
    """``V = |x|^2``: of ``(x, w)`` ``[[2, B - Q'], [B' - Q, Q + Q']] > 0``; in steps, ``A = 0``, with half of ``Q``.

    There it is ``[[1, -Q'], [-Q, Q + Q' - B'B]]``.
    """
    A = [["-1", "0"], ["0", "-1"]] if time == "continuous" else [["0", "0"], ["0", "0"]]
    system = {"kind": "multivariable", "time": time, "A": A, "B": [["1/2", "-1/4"], ["1/4", "1/2"]]}
    system |= {"C": [["1", "0"], ["0", "1"]], "D": [["0", "0"], ["0", "0"]]}
    form = {"channels": [1, 2], "kind": kind, "rows": rows}
    one = SLOPED | {"odd": kind == "odd"}
    draft = {"verdict": "PROVED", "system": system, "laws": {"channels": [one, one], "repeated": True}}
    draft |= {"theorem": "coupled-circle", "multiplier": {"forms": [form]}}
    if theta is not None:
        draft |= {"theorem": "coupled-popov", "multiplier": {"forms": [form], "theta": theta}}
    return complete_and_check(draft | {"proof": {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0}} | more)


HALVED = [["1/2", "-1/4"], ["-1/8", "1/2"]]
SIGNED = [["1", "-1/2"], ["1/4", "1"]]  # 1/4 is for odd ones


def alone():
    """``V = x^2 + 6 int phi``, ``x' = -x - w/4``: ``V' + V/2 + 7/2 w (x - w) = -3/2 x^2 - 3 w x - 5 w^2 + 3 int phi``.

    By slopes from 0 to 1 ``int phi <= w x - w^2/2``: it is at most ``-3/2 x^2 - 13/2 w^2 < 0``.  By the sector
    alone ``int phi <= x^2/2``, and nothing is left of ``x^2``.
    """
    system = {"kind": "multivariable", "time": "continuous", "A": [["-1"]], "B": [["1/4"]], "C": [["1"]], "D": [["0"]]}
    multiplier = {"forms": [{"channels": [1], "kind": "monotone", "rows": [["7/4"]]}], "theta": ["3"]}
    draft = {"verdict": "PROVED", "system": system, "laws": {"channels": [SLOPED], "repeated": False}}
    draft |= {"theorem": "coupled-popov", "multiplier": multiplier, "rate": "1/4"}
    return complete_and_check(draft | {"proof": {"method": "matrix", "P": [["1"]], "exponent": 0}})


def test_one_nonlinearity_has_one_name_and_its_slope_bounds():
    text = coq_text(coupled(rate="1/4", theta=["1/8", "0"]))
    stated = text[text.rindex("Theorem decays") :]
    assert "forall (phi Phi1 : R -> R) (x w : nat -> R -> R),\n  (sloped false 0 1 phi) ->\n" in stated
    assert "(integral_of Phi1 phi)" in stated
    assert "(forall t, 0 < t -> w 1%nat t = phi (sigma2 x w t))" in stated
    text = coq_text(coupled("discrete", HALVED))
    assert "Definition block : list (list Z) := [[0; 0; 8; -4]; [0; 0; -2; 8]; [8; -2; 0; 0]; [-4; 8; 0; 0]]%Z." in text
    assert "(sloped true 0 1 phi)" in coq_text(coupled(rows=SIGNED, kind="odd"))
    assert "  (sloped false 0 1 phi) ->\n  (integral_of Phi phi) ->\n" in coq_text(alone())


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(
    ("shown", "falsified"),
    [
        (lambda: coupled(rate="1/4", theta=["1/8", "0"]), [("(1 / 4) * (t - s)", "(1 / 2) * (t - s)")]),
        (lambda: coupled("discrete", HALVED), [("sloped false 0 1", "in_sector 0 1")]),
        (alone, [("sloped false 0 1", "in_sector 0 1"), ("(1 / 4) * (t - s)", "(1 / 2) * (t - s)")]),
        (lambda: coupled(rows=SIGNED, kind="odd"), [("sloped true 0 1", "sloped false 0 1")]),
    ],
)
def test_coupled_forms_compile_and_falsified_ones_do_not(library, shown, falsified):
    text = coq_text(shown())
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in falsified:
        assert not compiled(library, changed(text, right, wrong))[0], wrong

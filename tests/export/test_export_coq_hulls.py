"""Forms of higher degree in discrete time as files for Coq: true ones compile, falsified ones do not."""

import pytest
from replayed import KEPT, changed, compiled, needs_coq, resting_on_axioms

from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.export import coq_text
from lure.errors import InputError

# 1/(z^2 - z + 1/2) in [0, 12/25]: the circle criterion ends at .4472, linear gains at 1/2; with 1/12 beside it 12/25
# becomes 1/2
KIND = KEPT["homogeneous-lyapunov, discrete"]
STATES = {"kind": "state-space", "time": "discrete", "A": [["0", "1"], ["-1/2", "1"]], "b": ["0", "1"]}
FORMS = {
    "polynomials": {},
    "matrices": {"system": STATES | {"c": ["1", "0"], "d": "0"}},
    "feedthrough": {
        "system": KIND["system"] | {"numerator": ["1/12", "-1/12", "25/24"]},
        "laws": KIND["laws"] | {"sector": ["0", "1/2"]},
    },
    "invariant": {"laws": KIND["laws"] | {"time_varying": False}},
}


@needs_coq
@pytest.mark.slow_for("matrices", "feedthrough", "invariant")
@pytest.mark.parametrize(
    ("form", "place", "end"),
    [
        ("polynomials", "(1 / 2) * xi t", "Un_cv xi 0."),
        ("matrices", "(-1 / 2) * x 0%nat t", "Un_cv (x 0%nat) 0 /\\ Un_cv (x 1%nat) 0."),
        ("feedthrough", "(1 / 2) * xi t", "Un_cv xi 0."),
        ("invariant", "(1 / 2) * xi t", "Un_cv xi 0."),
    ],
)
def test_forms_in_discrete_time_compile_and_falsified_ones_do_not(form, place, end, library):
    text = coq_text(complete_and_check(KIND | FORMS[form]))
    upper = "(1 / 2)" if form == "feedthrough" else "(12 / 25)"
    assert end in text
    ok, said = compiled(library, text)
    assert ok, said
    assert resting_on_axioms(said)
    for right, wrong in (
        (f"in_sector 0 {upper}", "in_sector 0 (51 / 100)"),
        (f" {place}", f" (9 / 10) * {place.partition('* ')[2]}"),
        ("Definition P : list (list Z) := [[", "Definition P : list (list Z) := [[-"),
        ("Definition upper_loop : list (list Z) := [[", "Definition upper_loop : list (list Z) := [[1"),
    ):
        assert not compiled(library, changed(text, right, wrong))[0], right


# V = 2 (x_1^2 + x_2^2)^2 + 198 x_1^2 x_2^2 falls along x+ = .9 x_1 (1 - g, g) for g = 0, 1, and grows for g = 1/2
@needs_coq
@pytest.mark.slow
def test_a_form_that_grows_between_the_ends_compiles(library):
    system = STATES | {"A": [["9/10", "0"], ["0", "0"]], "b": ["9/10", "-9/10"], "c": ["1", "0"], "d": "0"}
    zero = [["0"], ["0", "0"], ["0", "0", "0"]]
    proof = {"method": "powers", "power": 2, "P": [["2"], ["0", "200"], ["1", "0", "2"]], "lower": zero, "upper": zero}
    laws = KIND["laws"] | {"sector": ["0", "1"]}
    ok, said = compiled(library, coq_text(complete_and_check(KIND | {"system": system, "laws": laws, "proof": proof})))
    assert ok, said


def test_a_form_that_hardly_falls_has_no_export(monkeypatch):
    monkeypatch.setattr("lure.analysis.export.hulls.MOST_CLOSE", 1)
    with pytest.raises(InputError, match="leaves too little room"):
        coq_text(complete_and_check(KIND))

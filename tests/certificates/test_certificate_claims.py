"""What a certificate may claim: no more than was shown, of the class that is meant, and not both answers at once.

Each case was once accepted, or could be told wrongly.
"""

import pytest

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.drafts import complete_and_check

# H = -1/2 + 1/(s (s + 1/100)), a direct term; the nonlinearity has chords in [1/10, 9/10] and one piece of slope 5/2:
# there sigma + H(inf) phi(sigma) falls, the loop jumps between two solutions, and each jump feeds energy in.
FOLDED = {
    "kind": "transfer",
    "time": "continuous",
    "numerator": ["-1/2", "-1/200", "1"],
    "denominator": ["1", "1/100", "0"],
}
STEEP = {
    "kind": "piecewise-linear",
    "points": [["-3/2", "-27/20"], ["-1", "-1/10"], ["0", "0"], ["1", "1/10"], ["3/2", "27/20"]],
    "left": "1/2",
    "right": "1/2",
}
POLYNOMIAL, STRUCTURE = {"method": "polynomial"}, {"method": "structure"}


def transfer(top, bottom, time="continuous"):
    return {"kind": "transfer", "time": time, "numerator": top.split(), "denominator": bottom.split()}


def nonlinearities(low, high, slope=None):
    return {"sector": [low, high], "slope": slope, "odd": False, "time_varying": False, "linear": False}


def proved(system, bounds, theorem, multiplier, nonlinearity=None):
    return complete_and_check(
        {
            "verdict": "PROVED",
            "system": system,
            "laws": bounds,
            "law": nonlinearity,
            "theorem": theorem,
            "multiplier": multiplier,
            "proof": POLYNOMIAL,
        }
    )


def refuted(system, bounds, proof, nonlinearity=None):
    return complete_and_check(
        {
            "verdict": "REFUTED",
            "system": system,
            "laws": bounds,
            "law": nonlinearity,
            "theorem": "counterexample",
            "proof": proof,
        }
    )


def test_a_law_that_leaves_the_loop_several_solutions_is_no_member():
    with pytest.raises(Rejected, match="changes its sign over the slopes of the nonlinearity"):
        proved(FOLDED, nonlinearities("0", "1"), "popov", {"theta": "101"}, nonlinearity=STEEP)


def test_what_is_assumed_of_a_direct_term_is_part_of_the_claim():
    assert (
        "sigma + H(inf) phi(sigma) increasing"
        in proved(FOLDED, nonlinearities("0", "1"), "popov", {"theta": "101"}).claim
    )


def test_slope_bounds_show_it_where_they_keep_the_sign():
    # 1 - s/2 > 0 for slopes s up to 1, not up to 3
    shown = proved(FOLDED, nonlinearities("0", "1", ["0", "1"]), "popov", {"theta": "101"})
    assert "increasing" not in shown.claim
    assert "keeps its sign over the class" in shown.facts["solvable"]
    assert "increasing" in proved(FOLDED, nonlinearities("0", "1", ["0", "3"]), "popov", {"theta": "101"}).claim


def test_a_class_that_no_law_belongs_to_is_no_class():
    with pytest.raises(Malformed, match="no nonlinearity has both"):
        proved(transfer("1", "1 1"), nonlinearities("0", "2", ["3", "4"]), "circle", {})


@pytest.mark.parametrize(
    ("top", "bottom", "time", "bounds", "question"),
    [
        (
            "1",
            "1 1 0",
            "continuous",
            nonlinearities("-1", "2", ["0", "2"]),
            (nonlinearities("0", "2", ["0", "2"]), "popov", {"theta": "1"}),
        ),
        (
            "-1",
            "1 1 0",
            "continuous",
            nonlinearities("-1/2", "0"),
            (nonlinearities("-1/2", "0"), "circle", {"mirrored": True}),
        ),
        (
            "-1",
            "1 -1",
            "discrete",
            nonlinearities("-1", "0"),
            (nonlinearities("-1", "0"), "circle", {"mirrored": True}),
        ),
    ],
)
def test_no_class_gets_both_answers(top, bottom, time, bounds, question):
    # the gain 0 at an end of these classes leaves a pole at 0 (z = 1), and convergence to the equilibria is proved
    block = transfer(top, bottom, time)
    assert "set of equilibria" in proved(block, *question).claim
    with pytest.raises(Rejected, match="critical case"):
        refuted(block, bounds, {"method": "linear-gain", "gain": "0"})


def test_a_counterexample_names_no_other_law():
    # 1/(s + 1) with -2 sigma escapes; with tanh, of the same class, it does not
    tanh = {"kind": "tanh", "height": "1", "rate": "1"}
    gain = {"method": "linear-gain", "gain": "-2"}
    assert "does not converge" in refuted(transfer("1", "1 1"), nonlinearities("-2", "2"), gain).claim
    with pytest.raises(Rejected, match="no given nonlinearity"):
        refuted(transfer("1", "1 1"), nonlinearities("-2", "2"), gain, nonlinearity=tanh)


def test_residues_are_those_of_the_variable_they_are_named_in():
    # 1/(z - 1) has the residue 1 at z = 1; s-plane images have half of it
    shown = proved(transfer("1", "1 -1", "discrete"), nonlinearities("0", "1"), "circle", {})
    assert "residue 1 > 0 at a simple root z = 1" in shown.facts["stable"]


def test_a_mirrored_criterion_says_of_which_block_it_speaks():
    shown = proved(transfer("-1 0", "1 1"), nonlinearities("-2", "0"), "circle", {"mirrored": True})
    assert shown.facts["well-posed"].startswith("for -H, -phi")
    assert "H(inf) = 1" in shown.facts["well-posed"]

"""Several nonlinearities and integrators: certificates by hand, and what neither checker accepts."""

import json
import random
from fractions import Fraction as F

import pytest
from certificate_format import FORMAT
from tampering import changed, refused_again

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck

CONVERGES, BOUNDED = "every motion converges to the set of equilibria", "every motion is bounded"


def nonlinearity(low, high, **more):
    found = {"sector": [low, high], "slope": None, "odd": False, "time_varying": False, "linear": False}
    return found | more


# x_0' = R mu with R = [[2, 1], [1, 2]], x_1' = -x_1 + mu_1, sigma = (x_01 - x_1, x_02), phi_i in [0, 1/2]: with
# lambda = 2, Lambda = 1, P_0 = R^-1 = [[2, -1], [-1, 2]]/3 and P_1 = 1 the form -V' - 2 sum lambda phi (sigma/2 - phi)
# is 2 x_1^2 + 4 x_1 phi_1 + 4 phi_1^2 + 4 phi_2^2, positive definite; times 3 all are integers
SYSTEM = {
    "kind": "multivariable",
    "time": "continuous",
    "A": [["0", "0", "0"], ["0", "0", "0"], ["0", "0", "-1"]],
    "B": [["2", "1"], ["1", "2"], ["1", "0"]],
    "C": [["1", "0", "-1"], ["0", "1", "0"]],
    "D": [["0", "0"], ["0", "0"]],
}
ZERO = [["1", "0", "0", "0", "0"], ["0", "1", "0", "0", "0"]]
MATRIX = {
    "verdict": "PROVED",
    "system": SYSTEM,
    "laws": {"channels": [nonlinearity("0", "1/2")] * 2, "repeated": False},
    "theorem": "diagonal-circle",
    "multiplier": {"lambda": ["6", "6"]},
    "proof": {"method": "matrix", "P": [["2"], ["-1", "2"], ["0", "0", "3"]], "exponent": 0, "zero": ZERO},
}
DETERMINANT = {**MATRIX, "proof": {"method": "determinant"}}
# theta adds 2 theta_1 phi_1 (phi_1 + phi_2 + x_1) + 2 theta_2 phi_2 (phi_1 + 2 phi_2) to three times the form
POPOV = {**MATRIX, "theorem": "diagonal-popov", "multiplier": {"lambda": ["6", "6"], "theta": ["1/2", "-1/4"]}}
# in discrete time x_0+ = x_0 + R mu takes phi' R phi from the form, of phi in [0, 1/4] with sigma = x_0: it is then
# 3/4 x_1^2 + x_1 phi_1 - phi_1^2 + 8 |phi|^2 - 2 (phi_1^2 + phi_1 phi_2 + phi_2^2), positive definite
DISCRETE = {
    **MATRIX,
    "system": SYSTEM
    | {
        "time": "discrete",
        "A": [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1/2"]],
        "C": [["1", "0", "0"], ["0", "1", "0"]],
    },
    "laws": {"channels": [nonlinearity("0", "1/4")] * 2, "repeated": False},
    "multiplier": {"lambda": ["12", "12"]},
}
# the same loop as MATRIX after A is moved by gains 1/2, -1/2, which are then the lower bounds: phi = L sigma at rest
SHIFTED = {
    **MATRIX,
    "system": SYSTEM | {"A": [["1", "-1/2", "-1"], ["1/2", "-1", "-1/2"], ["1/2", "0", "-3/2"]]},
    "laws": {"channels": [nonlinearity("1/2", "1"), nonlinearity("-1/2", "0")], "repeated": False},
    "proof": MATRIX["proof"] | {"zero": [["1", "0", "0", "1/2", "0"], ["0", "1", "0", "0", "-1/2"]]},
}
PROOFS = {"matrix": MATRIX, "determinant": DETERMINANT, "popov": POPOV, "discrete": DISCRETE, "shifted": SHIFTED}
PROOFS |= {
    f"{name}, by a determinant": PROOFS[name] | {"proof": {"method": "determinant"}} for name in ("popov", "shifted")
}


@pytest.mark.parametrize("name", PROOFS)
def test_a_proof_by_hand_is_accepted_by_both_checkers_and_keeps_the_schema(name):
    shown = complete_and_check(PROOFS[name])
    accepted = json.loads(json.dumps(dict(shown.certificate)))
    assert shown.claim.startswith(CONVERGES)
    assert recheck(accepted).accepted
    FORMAT.validate(accepted)
    if "popov" not in name:
        varying = changed(
            PROOFS[name],
            "laws",
            "channels",
            0,
            nonlinearity(*PROOFS[name]["laws"]["channels"][0]["sector"], time_varying=True),
        )
        bounded = dict(complete_and_check(varying).certificate)
        assert bounded["conclusion"] == BOUNDED
        assert recheck(bounded).accepted
        for said in (CONVERGES, "0 attracts every motion"):  # more than was shown
            with pytest.raises(Rejected):
                check(bounded | {"conclusion": said})
            assert not recheck(bounded | {"conclusion": said}).accepted


TAMPERED = {
    "a digit of P": ("matrix", ("proof", "P", 2, ["0", "0", "4000"])),
    "P_0 changed": ("matrix", ("proof", "P", 1, ["-1", "3"])),
    "P_0 mixed with P_1": ("matrix", ("proof", "P", 2, ["1", "0", "3"])),
    "another sign": ("matrix", ("proof", "P", [["-2"], ["1", "-2"], ["0", "0", "-3"]])),
    "no equilibria": ("matrix", ("proof", {k: v for k, v in MATRIX["proof"].items() if k != "zero"})),
    "one equilibrium less": ("matrix", ("proof", "zero", ZERO[:1])),
    "none": ("matrix", ("proof", "zero", [])),
    "the same twice": ("matrix", ("proof", "zero", ZERO[:1] * 2)),
    "no equilibrium": ("matrix", ("proof", "zero", [ZERO[0], ["0", "1", "1", "0", "0"]])),
    "phi is not L sigma": ("matrix", ("proof", "zero", [ZERO[0], ["0", "1", "0", "0", "1"]])),
    "phi is not L sigma, shifted": ("shifted", ("proof", "zero", ZERO)),
    "other weights": ("matrix", ("multiplier", "lambda", ["6", "5"])),
    "other weights, by a determinant": ("determinant", ("multiplier", "lambda", ["6", "5"])),
    "wider than the weights permit": ("determinant", ("laws", "channels", 0, nonlinearity("0", "1"))),
    "wider": ("matrix", ("laws", "channels", [nonlinearity("0", "5")] * 2)),
    "wider, by a determinant": ("determinant", ("laws", "channels", [nonlinearity("0", "5")] * 2)),
    "wider, discrete": ("discrete", ("laws", "channels", [nonlinearity("0", "1")] * 2)),
    "unstable beside": ("matrix", ("system", "A", 2, ["0", "0", "1"])),
    "unstable beside, by a determinant": ("determinant", ("system", "A", 2, ["0", "0", "1"])),
    "a Jordan block": ("matrix", ("system", "A", 0, ["0", "1", "0"])),
    "a Jordan block, by a determinant": ("determinant", ("system", "A", 0, ["0", "1", "0"])),
    "a negative eigenvalue of R": ("determinant", ("system", "B", [["1", "2"], ["2", "1"], ["1", "0"]])),
    "a negative residue": ("determinant", ("system", "B", [["-2", "-1"], ["-1", "-2"], ["1", "0"]])),
    "R is not symmetric": ("determinant", ("system", "B", [["2", "0"], ["1", "2"], ["1", "0"]])),
    "R is not symmetric, by P": ("matrix", ("system", "B", [["2", "0"], ["1", "2"], ["1", "0"]])),
    "an integrator that no channel sees": ("determinant", ("system", "C", [["1", "0", "-1"], ["1", "0", "0"]])),
    "unseen, by P": ("matrix", ("system", "C", [["1", "0", "-1"], ["1", "0", "0"]])),
    "one that no channel moves": ("determinant", ("system", "B", [["2", "1"], ["2", "1"], ["1", "0"]])),
    "it has jumps": ("determinant", ("laws", "channels", 0, "regularity", "any")),
    "Popov's term of one that depends on time": ("popov", ("laws", "channels", 0, "time_varying", True)),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_what_was_tampered_with_is_accepted_by_neither(name):
    draft, path = TAMPERED[name]
    with pytest.raises((Rejected, Malformed)):
        complete_and_check(changed(PROOFS[draft], *path))
    accepted = json.loads(json.dumps(dict(complete_and_check(PROOFS[draft]).certificate)))
    with pytest.raises((Rejected, Malformed)):
        check(changed(accepted, *path))
    assert refused_again(changed(accepted, *path))


def test_an_unmoved_and_unseen_integrator_is_left_out_of_no_sentence():
    # beside MATRIX x_3' = 0, which nothing sees: with P_33 = 1 V does not rise, but sigma does not tell where x_3 is
    wide = {"A": [[*row, "0"] for row in SYSTEM["A"]] + [["0"] * 4], "B": [*SYSTEM["B"], ["0", "0"]]}
    system = SYSTEM | wide | {"C": [[*row, "0"] for row in SYSTEM["C"]]}
    zero = [[*v[:3], "0", *v[3:]] for v in ZERO] + [["0", "0", "0", "1", "0", "0"]]
    proof = MATRIX["proof"] | {"P": [*MATRIX["proof"]["P"], ["0", "0", "0", "1"]], "zero": zero}
    for one in (proof, {"method": "determinant"}):
        with pytest.raises((Rejected, Malformed)):
            complete_and_check(MATRIX | {"system": system, "proof": one})
        whole = dict(complete_and_check(MATRIX).certificate)
        assert refused_again(whole | {"system": system, "proof": one})


def two_states(A, seen):
    """``x' = A x - phi`` in the channels that are seen, ``V = |x|^2``: the form is ``-2 |phi|^2`` for phi in [0, 1]."""
    side = [[str(int(i == j and i < seen)) for j in range(2)] for i in range(2)]
    system = {"kind": "multivariable", "time": "continuous", "A": A, "B": side, "C": side, "D": [["0", "0"]] * 2}
    proof = {"method": "matrix", "P": [["1"], ["0", "1"]], "exponent": 0, "zero": [["1", *"000"], ["0", "1", *"00"]]}
    laws = {"channels": [nonlinearity("0", "1")] * 2, "repeated": False}
    return MATRIX | {"system": system, "laws": laws, "multiplier": {"lambda": ["1", "1"]}, "proof": proof}


# x_1' = -phi_1, x_2' = -phi_2 converges; with x_1' = x_2, x_2' = -x_1 and phi = 0 the solutions go round, though V does
# not rise; and where sigma_2 = 0 for all x_2, phi_2 may vanish at 0 only and x_2 stays where it is
@pytest.mark.parametrize("why", ["an oscillation", "unseen"])
def test_where_v_does_not_fall_there_are_equilibria_that_sigma_tells_apart(why):
    still = [["0", "0"], ["0", "0"]]
    fine = dict(complete_and_check(two_states(still, 2)).certificate)
    assert recheck(fine).accepted
    draft = two_states([["0", "1"], ["-1", "0"]] if why == "an oscillation" else still, 2 - (why == "unseen"))
    with pytest.raises(Rejected, match="no equilibrium" if why == "an oscillation" else "does not see them all"):
        complete_and_check(draft)
    assert refused_again(fine | {"system": draft["system"]})


def test_a_left_eigenvector_is_no_equilibrium():
    # x_1' = -phi_1, x_2' = x_1 - x_2 - phi_2: (1, 0) A = 0 and the form vanishes at (1, 0), with A (1, 0)' not 0
    fine = dict(complete_and_check(two_states([["0", "0"], ["0", "0"]], 2)).certificate)
    draft = two_states([["0", "0"], ["1", "-1"]], 2)
    draft["proof"]["zero"] = draft["proof"]["zero"][:1]
    with pytest.raises(Rejected, match="no equilibrium"):
        complete_and_check(draft)
    assert refused_again(fine | {"system": draft["system"], "proof": draft["proof"]})


def test_p_that_mixes_integrators_with_the_rest_is_seen_where_the_inputs_do_not_show_it():
    # 40 times P of MATRIX, and a symmetric matrix that B' maps to 0 for x_01 and x_02: V' is indefinite near x_1 = 0
    mixed = MATRIX["proof"] | {"P": [["76"], ["-38", "79"], ["6", "-3", "120"]]}
    draft = MATRIX | {"multiplier": {"lambda": ["240", "240"]}, "proof": mixed}
    with pytest.raises(Rejected, match="does not vanish"):
        complete_and_check(draft)
    whole = dict(complete_and_check(MATRIX).certificate)
    assert refused_again(whole | {"multiplier": draft["multiplier"], "proof": mixed})


def test_v_falls_for_random_members_of_the_class():
    # phi_i = g_i sigma_i with g_i in [0, 1/2]: V' <= -(|x_1|^2 + |phi|^2)/10 with V of MATRIX, by hand above
    rng = random.Random(20261122)
    A, B, C = ([[F(v) for v in row] for row in SYSTEM[name]] for name in "ABC")
    rows = [[F(v) for v in row] for row in MATRIX["proof"]["P"]]
    for _ in range(300):
        x = [F(rng.randint(-9, 9), 4) for _ in range(3)]
        phi = [F(rng.randint(0, 4), 8) * sum(c * v for c, v in zip(row, x, strict=True)) for row in C]
        rate = [
            sum(a * v for a, v in zip(row, x, strict=True)) - sum(b * v for b, v in zip(side, phi, strict=True))
            for row, side in zip(A, B, strict=True)
        ]
        falls = sum(2 * rows[max(i, j)][min(i, j)] * x[i] * rate[j] for i in range(3) for j in range(3))
        assert falls <= -(x[2] ** 2 + phi[0] ** 2 + phi[1] ** 2) / 10

"""Blocks given by matrices, certified from both sides without a characteristic polynomial: sharp, as the exact way."""

import json
import math
from fractions import Fraction

import numpy as np
import pytest
from tampering import refused_again

from lure import Saturation, Sector, StateSpace, as_plant
from lure.analysis import analyse, max_sector, max_slope, report_on
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second import recheck
from lure.analysis.counterexamples.linear import growing_gains
from lure.analysis.inequality.gains import hurwitz_limit
from lure.analysis.questions.problem import by_matrices
from lure.analysis.theorems.circle import circle_largest
from lure.analysis.theorems.other_plants import largest
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.errors import AssumptionError
from lure.plants.matrices import rational_block


def dense(n, *, seed=0, dt=None):
    """A random stable block: spectral abscissa -1/10, or spectral radius 9/10."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / math.sqrt(n)
    poles = np.linalg.eigvals(A)
    A = A * 0.9 / np.abs(poles).max() if dt is not None else A - (poles.real.max() + 0.1) * np.eye(n)
    return StateSpace(A, rng.standard_normal(n), rng.standard_normal(n), dt=dt)


def modes(n):
    """Lightly damped oscillators in parallel, in a dense orthonormal basis."""
    rng = np.random.default_rng(1)
    w, zeta, gain = np.geomspace(1, 30, n // 2), rng.uniform(0.02, 0.2, n // 2), rng.normal(size=n // 2)
    A = np.zeros((n, n))
    for i in range(n // 2):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0, w[i]], [-w[i], -2 * zeta[i] * w[i]]]
    b, c = np.tile([0.0, 1.0], n // 2) * np.repeat(w, 2), np.repeat(gain, 2) * np.tile([1.0, 0.0], n // 2)
    basis, _ = np.linalg.qr(rng.normal(size=A.shape))
    return StateSpace(basis @ A @ basis.T, basis @ b, c @ basis.T)


def both_accept(found):
    """Proof and refutation, as text, before both checkers."""
    for shown in (found.proof, found.refutation):
        text = json.dumps(dict(shown.certificate))
        assert check(text).claim == shown.claim
        assert recheck(text).accepted, recheck(text).reason
    return True


def exact(block):
    return rational_block(block.A.tolist(), block.B.tolist(), block.C.tolist(), block.D, dt=block.dt)


@pytest.mark.slow_for("dense 20", "modes 20")
@pytest.mark.parametrize("block", [dense(12, seed=2), dense(20), modes(20)], ids=["dense 12", "dense 20", "modes 20"])
def test_matrices_and_exact_polynomials_agree(block):
    found, polynomial = max_sector(block), exact(block)
    reach = max(circle_largest(polynomial).largest, popov_largest(polynomial).largest, key=lambda one: one.low)
    limit = hurwitz_limit(polynomial)
    assert (found.verdict, found.evidence) == (Verdict.PROVED, Evidence.CERTIFIED)
    assert reach.high * (1 - 1e-7) < found.largest.low < reach.high
    assert limit.low < found.refuted_at < limit.high * (1 + 1e-9)
    assert found.hurwitz.low == found.largest.low
    assert found.hurwitz.high == found.refuted_at == found.largest.high
    assert both_accept(found)


@pytest.mark.parametrize("criterion", ["circle", "popov"])
def test_the_end_of_a_named_criterion_is_enclosed(criterion):
    block = modes(14)
    answer = {"circle": circle_largest, "popov": popov_largest}[criterion](exact(block))
    found = max_sector(block, criterion=criterion)
    assert found.largest.low <= answer.largest.high
    assert answer.largest.low <= found.largest.high
    assert found.largest.high - found.largest.low < 1e-7 * found.largest.high


# A symmetric, b = c: H = sum b_i^2/(s + p_i) has a positive real part, falling to 0: every finite k is proved.  For
# -H the least real part is -H(0) = -b'A^-1 b at omega = 0, where a linear gain puts a root at 0: circle = Hurwitz.
@pytest.mark.slow_for("30")
@pytest.mark.parametrize("n", [3, 30])
def test_a_symmetric_block_is_sharp_from_both_sides(n):
    rng = np.random.default_rng(4)
    basis, _ = np.linalg.qr(rng.normal(size=(n, n)))
    A, b = -(basis * rng.uniform(0.5, 20, n)) @ basis.T, rng.normal(size=n)
    A = (A + A.T) / 2
    limit = 1 / float(b @ np.linalg.solve(-A, b))
    found = max_sector(StateSpace(A, b, -b), time_varying=True)
    assert found.largest.low == pytest.approx(limit, rel=1e-9)
    assert found.largest.low < found.refuted_at == pytest.approx(limit, rel=1e-9)
    assert found.proof.certificate["laws"]["time_varying"] is True
    assert both_accept(found)
    passive = max_sector(StateSpace(A, b, b))
    assert (passive.largest.low, passive.refuted_at) == (math.inf, None)
    assert recheck(dict(passive.proof.certificate)).accepted


@pytest.mark.slow
def test_a_lower_end_and_a_direct_term_shift_the_loop():
    # 12/(s^2 + 2 s - 3) is unstable; with the gain 1/2 the loop is s^2 + 2 s + 3, and no larger gain destabilises it
    block = StateSpace([[0, 1], [3, -2]], [0, 1], [12, 0])
    found, polynomial = max_sector(block, lower=Fraction(1, 2)), exact(block)
    reach = popov_largest(polynomial, lower=Fraction(1, 2)).largest
    assert reach.low == math.inf == found.largest.high
    assert (found.lower, found.verdict, found.search_limited) == (Fraction(1, 2), Verdict.PROVED, True)
    assert "largest k for which a certificate was tried" in found.reason  # c b = 0: no matrix shows every finite k
    assert recheck(dict(found.proof.certificate)).accepted
    # 1/(s + 1)^3 - 1/8 is real at omega = sqrt(3), -1/8 - 1/8 there: gains below 4
    lag = StateSpace([[0, 1, 0], [0, 0, 1], [-1, -3, -3]], [0, 0, 1], [1, 0, 0], -0.125)
    found = max_slope(lag)
    assert found.largest.low < 4 < found.refuted_at < 4 * (1 + 1e-9)
    assert both_accept(found)
    shifted = max_slope(lag, lower=1)
    assert shifted.largest.low < 4 < shifted.refuted_at < 4 * (1 + 1e-9)
    assert both_accept(shifted)


@pytest.mark.slow_for("24")
@pytest.mark.parametrize("n", [8, 24])
def test_discrete_time_by_the_inequality_of_stein(n):
    block = dense(n, seed=5, dt=1)
    found, polynomial = max_sector(block), exact(block) if n == 8 else None
    assert found.verdict is Verdict.PROVED
    assert found.criterion == "circle"
    assert both_accept(found)
    if polynomial is not None:
        reach, limit = circle_largest(polynomial).largest, hurwitz_limit(polynomial)
        assert reach.high * (1 - 1e-6) < found.largest.low < reach.high
        assert limit.low < found.refuted_at < limit.high * (1 + 1e-6)


def test_a_block_that_is_not_stable_is_refuted_and_one_on_the_axis_is_not_decided():
    unstable = max_sector(StateSpace([[0.5, 1.0], [0.0, -1.0]], [0, 1], [1, 1]))
    assert (unstable.verdict, unstable.refuted_at) == (Verdict.REFUTED, 0.0)
    assert recheck(dict(unstable.refutation.certificate)).accepted
    critical = max_sector(StateSpace([[0.0, 1.0], [0.0, -1.0]], [0, 1], [1, 0]))
    assert critical.verdict is Verdict.INCONCLUSIVE
    assert critical.refuted_at is None
    assert "pole at 0" in critical.reason


# what doubles say is proposed and never believed: here they are wrong by a tenth, on either side
def test_a_search_that_is_wrong_costs_an_answer_and_never_makes_one(monkeypatch):
    from lure.analysis.certificates import by_matrices as ladder
    from lure.analysis.counterexamples import linear as growing

    block = dense(16, seed=9)
    limit = hurwitz_limit(exact(block)).middle
    true = growing._first
    monkeypatch.setattr(growing, "_first", lambda family: 0.9 * true(family))
    monkeypatch.setattr(ladder, "STEPS_DOWN", (-0.1, -0.05, 1e-10))
    found = max_sector(StateSpace(block.A, block.B, block.C))
    assert found.refuted_at is None
    assert found.largest.low < limit


@pytest.mark.slow
@pytest.mark.parametrize("part", ["proof", "refutation"])
def test_a_changed_matrix_is_refused_by_both_checkers(part):
    shown = getattr(max_sector(dense(20)), part)
    rng = np.random.default_rng(0)
    for _ in range(12):
        made = json.loads(json.dumps(dict(shown.certificate)))
        rows = made["proof"]["P"]
        i = int(rng.integers(len(rows)))
        rows[i][i] = str(-int(rows[i][i]))  # V is as large along one axis, of the other sign
        with pytest.raises(Rejected):
            check(made)
        assert refused_again(made)
    made = json.loads(json.dumps(dict(shown.certificate)))
    made["system"]["c"] = [str(-Fraction(v)) for v in made["system"]["c"]]
    with pytest.raises(Rejected):
        check(made)
    assert refused_again(made)


@pytest.mark.slow
def test_long_polynomials_of_matrices_of_doubles_go_by_the_matrices():
    large, small = dense(28), dense(12)
    given = as_plant((large.A, large.B, large.C))
    assert by_matrices(given).A.tolist() == large.A.tolist()
    assert max_sector((large.A, large.B, large.C)).largest.low == max_sector(large).largest.low
    assert by_matrices(as_plant((small.A, small.B, small.C))) is None
    lags = [[-1 if i == j else int(i == j + 1) for j in range(40)] for i in range(40)]  # short numbers: exact
    assert by_matrices(as_plant((lags, [1] + [0] * 39, [0] * 39 + [1]))) is None
    thirds = [[Fraction(v) / 3 for v in row] for row in large.A.tolist()]  # no doubles
    assert by_matrices(rational_block(thirds, large.B.tolist(), large.C.tolist())) is None


def test_other_criteria_are_not_for_matrices():
    with pytest.raises(AssumptionError, match="moderate order"):
        max_slope(dense(12), criterion="park")
    with pytest.raises(AssumptionError, match="ask circle"):
        largest(dense(4, dt=1), "popov")
    assert growing_gains(StateSpace([[-1.0]], [1.0], [1.0])) == []  # 1/(s + 1): every gain is stable


@pytest.mark.slow
@pytest.mark.parametrize(
    "block",
    [
        pytest.param(dense(40), id="dense 40"),
        pytest.param(dense(60, seed=3), id="dense 60", marks=pytest.mark.thorough),
        pytest.param(modes(100), id="modes 100", marks=pytest.mark.thorough),
    ],
)
def test_large_blocks_are_certified_from_both_sides(block):
    found = max_slope(block)
    assert (found.verdict, found.evidence) == (Verdict.PROVED, Evidence.CERTIFIED)
    at = found.refuted_at
    ahead, supporting_proof = (
        np.linalg.eigvals(block.A - k * at * np.outer(block.B, block.C)) for k in (1 - 1e-6, 1 + 1e-6)
    )
    assert ahead.real.max() < 0 < supporting_proof.real.max()
    assert both_accept(found)


@pytest.mark.slow
def test_an_analysis_of_many_states_decides_the_class_of_its_law():
    block = dense(28)
    limit = max_sector(block)
    for plant in (block, as_plant((block.A, block.B, block.C))):
        proved = analyse(plant, Saturation(gain=0.99 * limit.largest.low))
        assert (proved.verdict, proved.case) == (Verdict.PROVED, "stable")
        assert recheck(dict(proved.shown.certificate)).accepted
        refuted = analyse(plant, Sector(0, 1.01 * limit.refuted_at))
        assert refuted.verdict is Verdict.REFUTED
        assert refuted.to_dict()["block"]["matrices"]["order"] == 28
        assert json.loads(json.dumps(refuted.to_dict()))["block"]["denominator"] is None


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("plant", [dense(28), dense(24, seed=5, dt=1)], ids=["continuous", "discrete"])
def test_a_report_on_many_states_draws_its_plots(plant, tmp_path):
    report = report_on(plant, Saturation(gain=0.02), output=tmp_path / "report")
    assert report.analysis.verdict is Verdict.PROVED
    page = next((tmp_path / "report").glob("*.html")).read_text("utf-8")
    assert "state space of order" in page
    assert "Nyquist" in page


# without a matrix the numbers stay, as what they are
def test_where_no_matrix_is_accepted_the_answer_is_computed_and_says_why(monkeypatch):
    from lure.analysis.certificates import by_matrices as ladder

    monkeypatch.setattr(ladder, "STEPS_DOWN", (-0.01,))
    found = max_sector(dense(14, seed=11), criterion="circle")
    assert (found.verdict, found.evidence) == (Verdict.INCONCLUSIVE, Evidence.COMPUTED)
    assert found.reason.startswith("computed in floating point, not certified: ")
    assert found.proof is None

"""Several nonlinearities and integrators: plants with a known answer, from both sides, and what is not certified."""

from fractions import Fraction as F

import numpy as np
import pytest
from depth import rarely

from lure import NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis import analyse
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality import channels
from lure.analysis.inequality.zero_modes import zero_modes
from lure.analysis.verdict import Verdict
from lure.errors import AssumptionError

ONE = Sector(0, 1)
CONVERGES = "every motion converges to the set of equilibria"
# 1/(s (s + a) (s + b)) is stable for constant gains below a b (a + b), Routh, and Popov's criterion reaches as far; one
# of several loops without coupling goes first: 6 of 1/(s (s + 1)(s + 2)) and 12 of 1/(s (s + 1)(s + 3))
PARTS = (("1/(s*(s+1)*(s+2))", 6), ("1/(s*(s+1)*(s+3))", 12), ("1/s", np.inf))


def rows(plant):
    return [np.array([[F(v) for v in row] for row in side], dtype=object) for side in (plant.A, plant.B, plant.C)]


def beside(*transfers):
    m = len(transfers)
    return as_plant([[transfers[i] if i == j else "0" for j in range(m)] for i in range(m)])


def similar(plant, T):
    """The plant in the states ``T x``."""
    A, B, C = rows(plant)
    T = np.array([[F(v) for v in row] for row in T], dtype=object)
    n = len(T)
    inverse = np.array([[F(round(v)) for v in row] for row in np.linalg.inv(T.astype(float))], dtype=object)
    assert (T @ inverse == np.eye(n, dtype=int)).all()
    D = [[0] * len(C)] * len(C)
    return as_plant(((T @ A @ inverse).tolist(), (T @ B).tolist(), (C @ inverse).tolist(), D))


def unimodular(n):
    """Ones on the diagonal and beside it: the inverse has integers."""
    return np.eye(n, dtype=int) + np.eye(n, k=1, dtype=int)


@pytest.mark.slow_for("plant2")
@pytest.mark.parametrize(
    "plant",
    [
        beside(PARTS[0][0], PARTS[1][0]),
        beside(PARTS[2][0], PARTS[0][0]),
        similar(beside(PARTS[1][0], PARTS[0][0]), unimodular(6)),
    ],
)
def test_loops_beside_each_other_reach_as_far_as_the_least(plant):
    found = max_sector(plant, [ONE] * 2)
    assert found.largest.low == pytest.approx(6, rel=1e-5)
    assert found.refuted_at == pytest.approx(6, rel=1e-8)
    assert found.proof.certificate["conclusion"] == CONVERGES
    assert found.critical
    assert recheck(dict(found.proof.certificate)).accepted


@pytest.mark.slow
def test_by_a_matrix_as_far_as_by_a_determinant(monkeypatch):
    monkeypatch.setattr(channels, "MOST_STATES", 0)
    found = max_sector(similar(beside(PARTS[0][0], PARTS[1][0]), unimodular(6)), [ONE] * 2)
    assert found.largest.low == pytest.approx(6, rel=1e-5)
    assert found.proof.certificate["proof"]["method"] == "matrix"
    assert recheck(dict(found.proof.certificate)).accepted


# R mu = T diag(2, 1) T^-1: x' = -R phi is stable for all gains if R is symmetric positive definite, and if D R D^-1 is
@pytest.mark.parametrize("R", [((2, 1), (1, 2)), ((2, 4), (F(1, 4), 2)), ((1, -1), (-1, 3))])
def test_integrators_alone_have_no_limit(R):
    plant = as_plant(([[0, 0]] * 2, R, [[1, 0], [0, 1]], [[0, 0]] * 2))
    found = max_sector(plant, [ONE] * 2)
    assert found.largest.low > 1e4
    assert found.refuted_at is None
    assert recheck(dict(found.proof.certificate)).accepted


def test_samples_of_integrators_reach_as_far_as_constant_gains():
    # x+ = x - phi and x+ = x - 2 phi: the gains 2 and 1 give the eigenvalue -1
    plant = as_plant(([[1, 0], [0, 1]], [[1, 0], [0, 2]], [[1, 0], [0, 1]], [[0, 0]] * 2), dt=1)
    found = max_sector(plant, [ONE] * 2)
    assert found.largest.low == pytest.approx(1, rel=1e-5)
    assert found.refuted_at == pytest.approx(1, rel=1e-8)
    assert recheck(dict(found.proof.certificate)).accepted


def test_where_the_solutions_go_depends_on_what_is_known():
    plant = beside(PARTS[0][0], "1/(s*(s+1))")
    known = certify(plant, ["tanh(sigma)", "sigma/(1+sigma**2)"])
    assert known.conclusion.meaning == "Every solution converges to 0"
    flat = certify(plant, ["tanh(sigma)", "max(sigma, 0)"])  # one that is 0 for all sigma < 0
    assert flat.conclusion.meaning == "Every solution converges to the set of equilibria"
    assert not flat.conclusion.attracts
    moving = certify(beside(PARTS[0][0], "1/s"), [NonlinearityClass(sector=ONE, time_varying=True)] * 2)
    assert moving.conclusion.meaning == "Every solution is bounded"


@pytest.mark.slow
def test_an_analysis_says_that_the_plant_has_integrators():
    found = analyse(as_plant(([[0, 0]] * 2, ((2, 1), (1, 2)), ((1, 0), (0, 1)), [[0, 0]] * 2)), [ONE] * 2)
    assert (found.case, found.verdict) == ("critical", Verdict.PROVED)
    assert "the loop with the smallest gain of the class has a pole at 0" in found.not_shown[0]
    sampled = analyse(as_plant("1/(10*(z-1))", dt=1), ONE)
    assert "the loop with the smallest gain of the class has a pole at z = 1, and the class" in sampled.not_shown[0]


def matrices(B, C, A=((0, 0, 0), (0, 0, 0), (0, 0, -1))):
    return as_plant((A, B, C, [[0, 0]] * 2))


SEEN = ((1, 0, 1), (0, 1, 0))
REFUSED = {
    "a negative eigenvalue": (matrices(((1, 2), (2, 1), (1, 1)), SEEN), "Lambda R has a negative eigenvalue"),
    "no symmetry": (matrices(((1, 1), (0, 1), (1, 1)), SEEN), "no weights > 0"),
    "no symmetry, of three": (
        as_plant(([[0] * 3] * 3, ((3, 1, 1), (1, 3, 2), (1, 1, 3)), np.eye(3, dtype=int).tolist(), [[0] * 3] * 3)),
        "no weights > 0",
    ),
    "unseen": (matrices(((2, 1), (1, 2), (1, 1)), ((1, 0, 1), (1, 0, 0))), "do not move or see all"),
    "unmoved": (matrices(((1, 2), (1, 2), (1, 1)), SEEN), "do not move or see all"),
    "a Jordan block": (matrices(((0, 1), (1, 0), (1, 1)), SEEN, ((0, 1, 0), (0, 0, 0), (0, 0, -1))), "multiplicity"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_integrators_without_the_hypotheses_are_refused(name):
    plant, why = REFUSED[name]
    with pytest.raises(AssumptionError, match=why):
        zero_modes(plant.A, plant.B, plant.C, discrete=False)


@pytest.mark.slow_for("unseen")
@pytest.mark.parametrize("name", rarely(REFUSED, "no symmetry", "no symmetry, of three", "unmoved"))
def test_integrators_without_the_hypotheses_are_not_certified(name):
    plant, _ = REFUSED[name]
    found = certify(plant, [ONE] * plant.inputs)
    assert found.verdict is not Verdict.PROVED


@pytest.mark.slow
def test_a_residue_with_a_negative_eigenvalue_is_refuted_by_small_gains():
    found = max_sector(REFUSED["a negative eigenvalue"][0], [ONE] * 2)
    assert found.proof is None
    assert found.refuted_at < 1e-3

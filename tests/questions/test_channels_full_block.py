"""Several nonlinearities that interact: full-block multipliers from one side, gains that jump from the other."""

from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from scipy.linalg import expm
from tampering import assert_both_reject, edited

from lure import Diagonal, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis import Verdict
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples.switched import switched_witness
from lure.analysis.questions.channel_proofs import Criterion, proved_whole
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import TABLE

ONE = Sector(0, 1)
MOVING = NonlinearityClass(sector=ONE, time_varying=True)


def rows(text):
    return [line.split() for line in text.split(";")]


# Veenman, Scherer, Koroglu (IQClab, Demo_006), theirs is positive feedback: B and D with the other sign here
VEENMAN = as_plant((rows("-.4 -1; 1 0"), rows(".2 1 .25; 0 0 0"), rows("1 0; 0 1; 0 0"), rows("0 0 0; 0 0 0; 0 -1 0")))
# Fetzer, Scherer (2017), example 4.9, the other sign
OPPOSITE = as_plant(
    (
        rows("-4 -3 0; 2 0 0; -1 -1 -2"),
        rows("0 4 1 3; 2 0 3 1; 1 0 3 1"),
        rows("-.1 -.2 1; -1 -.3 .1; -.2 .1 1; .1 -.2 .2"),
    )
)


def second(found):
    """Both certificates again, by the second checker."""
    assert all(recheck(dict(one.certificate)).accepted for one in (found.proof, found.refutation) if one is not None)
    return found


def double(text):
    return float(Fraction(text))


# largest factors with full-block multipliers, recomputed by others at the vertices of the gains with R < 0: .798467 and
# .678574; concave in each gain is less than R < 0, and the orthants of the first plant show a little more, which
# other processors reach to the 1e-4 at which the search ends
@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "others", "ours"),
    [
        (VEENMAN, 0.798467, 0.79998),
        (OPPOSITE, 0.678574, 0.678573),
    ],
)
def test_full_block_multipliers_reach_what_others_computed_and_gains_that_jump_refute_beyond(plant, others, ours):
    found = second(max_sector(plant, [MOVING] * plant.inputs))
    assert found.criterion == "full-block-circle"
    assert others - 1e-6 < found.largest.low == pytest.approx(ours, rel=1e-4)
    assert found.largest.low < found.refuted_at == pytest.approx(1.2609737 if plant is VEENMAN else 0.7129, rel=1e-3)
    proof = found.refutation.certificate["proof"]
    A, B, C, D = plant.doubles()
    for share, grows in ((1 + 1e-6, True), (1 - 1e-5, False)):  # the state over one period
        whole = np.eye(len(A))
        for row, time in zip(proof["gains"], proof["times"], strict=True):
            G = share * np.diag([double(g) for g in row])
            whole = expm((A - B @ G @ np.linalg.solve(np.eye(len(G)) + D @ G, C)) * double(time)) @ whole
        assert bool(np.abs(np.linalg.eigvals(whole)).max() > 1) is grows
    half = found.proof.certificate["multiplier"]["Pi"]  # nonnegative for the class, not for one twice as large
    Pi = np.array([[double(half[max(i, j)][min(i, j)]) for j in range(2 * len(D))] for i in range(2 * len(D))])
    rng = np.random.default_rng(7)
    gain, sigma = rng.random((2000, len(D))) ** 0.3 * found.largest.low, rng.normal(size=(2000, len(D)))
    for share, holds in ((1, True), (2, False)):
        y = np.hstack([sigma, share * gain * sigma])
        assert bool(np.einsum("ki,ij,kj->k", y, Pi, y).min() >= 0) is holds


@pytest.mark.slow
def test_channels_that_do_not_interact_are_refuted_as_the_worst_of_them_by_gains_that_jump():
    # 1/(s^2 + s/2 + 1) with a gain that jumps grows before the circle criterion's bound is doubled; 1/(s + 9) is idle
    alone = switched_witness(as_plant("1/(s^2+s/2+1)"))
    plant = as_plant([["1/(s^2+s/2+1)", "0"], ["0", "1/(s+9)"]])
    found = second(max_sector(plant, [MOVING] * 2))
    assert found.refuted_at == pytest.approx(alone.k, rel=1e-5)
    assert "over and over" in str(found)
    still = max_sector(plant, [ONE, MOVING])  # 1/(s^2 + s/2 + 1) is stable with every constant gain
    assert still.refuted_at is None


@pytest.mark.slow
def test_in_discrete_time_gains_alternate():
    # gains alpha, alpha and 0, 0 in turn: M = A (A - alpha B C) = [[0, 9/16 - 3 alpha/4], [-9/16, -9/16 - 3 alpha/8]]
    # has the eigenvalue -1 where 1 - 9/16 - 3 alpha/8 + 81/256 - 27 alpha/64 = 0: alpha = 193/204; constant ones 37/36
    plant = as_plant(([["-3/4", "-3/4"], ["3/4", 0]], [[0, "1/2"], ["1/2", -1]], [[0, -1], [0, 1]]), dt=1)
    found = second(max_sector(plant, [MOVING] * 2))
    assert found.refuted_at == pytest.approx(193 / 204, rel=1e-6)
    assert 0.5 < found.largest.low < 193 / 204 < found.refuted_at
    assert certify(plant, [NonlinearityClass(sector=Sector(0, 0.95), time_varying=True)] * 2).verdict is Verdict.REFUTED


def gains(*tops):
    return [NonlinearityClass.constant_gain(0, top) for top in tops]


@pytest.mark.slow
def test_unknown_constant_gains_are_decided_up_to_those_that_destabilise():
    found = second(max_sector(OPPOSITE, gains(1, 1, 1, 1)))
    assert found.criterion == "constant-gains"
    assert found.refuted_at == pytest.approx(0.76766233, rel=1e-6)
    assert found.refuted_at * (1 - 2e-4) < found.largest.low < found.refuted_at
    assert "time-invariant" not in str(found)
    # for this plant no constant gains are known that destabilise; nonlinearities are proved up to 2.588854
    assert certify(VEENMAN, gains(50, 50, 50)).verdict is Verdict.PROVED


@pytest.mark.parametrize("discrete", [False, True])
def test_random_gains_of_a_proved_box_are_stable_and_some_just_beyond_are_not(discrete):
    rng = np.random.default_rng(20261122)
    for _ in range(sampled(1, of=40)):
        A, B, C = rng.integers(-8, 9, (3, 3)) / 8, rng.integers(-4, 5, (3, 2)) / 4, rng.integers(-4, 5, (2, 3)) / 4
        D = rng.integers(-1, 2, (2, 2)) / 8
        size = np.abs(np.linalg.eigvals(A)).max() + 0.1
        A = np.round(A / size * 0.75, 2) if discrete else A - np.round(size, 2) * np.eye(3)
        found = second(max_sector(as_plant((A, B, C, D), dt=1 if discrete else None), gains(1, 2)))
        assert found.verdict is Verdict.PROVED
        low = found.largest.low
        if found.refuted_at is not None:
            assert low < found.refuted_at < low * (1 + 1e-3)
        for share in rng.random((50, 2)) ** 0.2:
            G = np.diag(share * low * [1, 2])
            poles = np.linalg.eigvals(A - B @ G @ np.linalg.solve(np.eye(2) + D @ G, C))
            assert (np.abs(poles).max() < 1) if discrete else (poles.real.max() < 0)


@pytest.mark.slow
def test_one_gain_in_two_channels_is_proved_where_two_gains_destabilise():
    # x' = -x - g x + h x: with one gain g = h it is -1 whatever it is, with two gains g = 0, h = 1 it is 0
    plant = as_plant(([["-1"]], [[1, -1]], [[1], [1]], [[0, 0], [0, 0]]))
    apart = second(max_sector(plant, gains(1, 1)))
    assert apart.largest.low < 1 == pytest.approx(apart.refuted_at, rel=1e-6)
    one = second(max_sector(plant, Diagonal(tuple(gains(1, 1)), repeated=True)))
    assert one.largest.low > 3
    assert one.refuted_at is None
    assert certify(plant, gains(0.9, 5)).verdict is Verdict.REFUTED


# The plant of docs/theory/full-block.md in two channels, an integrator in a third: with full-block multipliers 2.51077,
# as without it, diagonal ones end at 2.48705; in discrete time z = (1 + s)/(1 - s)
PAIR = [["1/(s+1)", "2/(s+2)", "0"], ["-2/(s+3)", "1/(s+1)^2", "0"], ["0", "0", "1/(s*(s+100))"]]
FULL = Criterion("full-block-circle", next(row for row in TABLE if row.name == "circle"))


def beside_an_integrator(k, *, discrete=False, kinds=(MOVING,) * 3):
    plant = [[one.replace("s", "((z-1)/(z+1))") if discrete else one for one in row] for row in PAIR]
    asked = Problem(plant=as_plant(plant, dt=1 if discrete else None), classes=Diagonal(kinds), kind="class")
    return proved_whole(asked.scaled(Fraction(k)), FULL)


@pytest.fixture(scope="module")
def integrating():
    return beside_an_integrator("2.51")


@pytest.mark.parametrize("discrete", [False, True])
def test_full_blocks_beside_an_integrator_reach_as_far_as_without(discrete, integrating):
    shown = beside_an_integrator("2.51", discrete=True) if discrete else integrating
    assert shown.certificate["conclusion"] == "every motion is bounded"
    assert recheck(dict(shown.certificate)).accepted
    assert beside_an_integrator("2.512", discrete=discrete) is None


def test_functions_that_do_not_vary_converge():
    shown = beside_an_integrator("2.5", kinds=(NonlinearityClass(sector=ONE),) * 3)
    assert shown.certificate["conclusion"] == "every motion converges to the set of equilibria"


def test_the_form_is_nonnegative_for_every_gain_of_the_class(integrating):
    half = [[double(v) for v in row] for row in integrating.certificate["multiplier"]["Pi"]]
    Pi = np.array([[half[max(i, j)][min(i, j)] for j in range(6)] for i in range(6)])
    rng = np.random.default_rng(0)
    sigma, gains = rng.normal(size=(2000, 3)), 2.51 * rng.choice([0, 1, 0.5, 0.9], size=(2000, 3))
    w = np.hstack([sigma, gains * sigma])
    values = np.einsum("ki,ij,kj->k", w, Pi, w) / np.abs(Pi).max()
    assert values.min() > -1e-12
    beyond = np.hstack([sigma, 2.6 * np.sign(gains) * sigma])  # not for larger gains
    assert np.einsum("ki,ij,kj->k", beyond, Pi, beyond).min() < 0


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("multiplier", "Pi", 2, 2), "-1"),  # sigma_3^2: below 0 where the integrator rests
        (("multiplier", "Pi", 2, 2), "1"),  # and the inequality is no equality there
        (("multiplier", "Pi", 2, 0), "1"),
        (("multiplier", "Pi", 5, 2), lambda v: str(Fraction(v) * 2)),
        (("multiplier", "Pi", 3, 3), "1"),
        (("multiplier", "Pi", 0, 0), lambda v: str(-Fraction(v))),
        (("proof", "zero"), lambda rows: [*rows, rows[0]]),
        (("proof", "zero", 0, 0), "1"),
        (("proof",), lambda proof: {key: value for key, value in proof.items() if key != "zero"}),
        (("laws", "channels", 0, "sector"), ["0", "3"]),
        (("system", "C", 2, 5), lambda v: str(Fraction(v) + 1)),
    ],
)
def test_a_full_block_beside_an_integrator_that_was_tampered_with_is_rejected_by_both(integrating, path, value):
    assert_both_reject(edited(integrating.certificate, *path, value=value))

"""Several nonlinearities: the largest factor from both sides, on published plants and where the answer is exact."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy import linalg

from lure import (
    Diagonal,
    InputError,
    NonlinearityClass,
    Sector,
    SlopeBounds,
    as_plant,
    builtin_loop,
    certify,
    max_sector,
    max_slope,
)
from lure.analysis import Verdict, analyse
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.inequality.shifted_loop import ShiftedLoop
from lure.analysis.questions.answers import ContradictionError, answer
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for, farthest
from lure.analysis.questions.channel_refutations import gains_refuting
from lure.analysis.questions.channels import channel_bound
from lure.analysis.questions.conclusion import MismatchError
from lure.analysis.questions.problem import Problem
from lure.plants.multivariable import MultivariablePlant

ONE, UNIT = Sector(0, 1), SlopeBounds(0, 1)
MOVING = NonlinearityClass(sector=ONE, time_varying=True)


def rows(text):
    return [line.split() for line in text.split(";")]


# Veenman, Scherer, Koroglu (IQClab, Demo_006), theirs is positive feedback: B and D with the other sign here
VEENMAN = as_plant((rows("-.4 -1; 1 0"), rows(".2 1 .25; 0 0 0"), rows("1 0; 0 1; 0 0"), rows("0 0 0; 0 0 0; 0 -1 0")))
# Fetzer, Scherer (2017), example 4.9
STATE, OUT = rows("-4 -3 0; 2 0 0; -1 -1 -2"), rows("-.1 -.2 1; -1 -.3 .1; -.2 .1 1; .1 -.2 .2")
FETZER = as_plant((STATE, rows("0 -4 -1 -3; -2 0 -3 -1; -1 0 -3 -1"), OUT))
OPPOSITE = as_plant((STATE, rows("0 4 1 3; 2 0 3 1; 1 0 3 1"), OUT))


ILL_POSED = as_plant(([["-1"]], [[1, 1]], [[1], [1]], [[-1, 0], [0, 0]]))
CONSTANT = MultivariablePlant((), (), ((), ()), ((Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))))


def second(found):
    """Both certificates again, by the second checker."""
    shown = [one for one in (found.proof, found.refutation) if one is not None]
    assert shown
    assert all(recheck(dict(one.certificate)).accepted for one in shown)
    return found


# largest factors of the circle criterion with diagonal multipliers, recomputed by others with semidefinite programmes
@pytest.mark.parametrize(
    ("plant", "largest"),
    [(VEENMAN, 0.767134), (FETZER, 0.523596), pytest.param(OPPOSITE, 0.670053, marks=pytest.mark.thorough)],
    ids=["1.1", "1.2", "1.2-"],
)
@pytest.mark.slow
def test_published_plants_reach_what_others_computed(plant, largest):
    found = second(max_slope(plant, [UNIT] * plant.inputs, criterion="diagonal-circle"))
    assert found.verdict is Verdict.PROVED
    assert found.largest.low == pytest.approx(largest, abs=1e-6)
    assert found.refuted_at is None or found.refuted_at > found.largest.low


def test_popovs_terms_close_the_gap_of_a_published_plant():
    found = second(max_slope(OPPOSITE, [UNIT] * 4))
    assert found.closed  # proved up to 0.7676623; published with theta >= 0: 0.699833
    assert found.criterion == "diagonal-popov"
    gains = np.array([float(double(g)) for g in found.refutation.certificate["proof"]["gains"]])
    A, B, C, _ = OPPOSITE.doubles()
    assert np.linalg.eigvals(A - B @ np.diag(gains) @ C).real.max() > 0
    inside = gains * (found.largest.low / found.refuted_at) * (1 - 1e-9)
    assert np.linalg.eigvals(A - B @ np.diag(inside) @ C).real.max() < 1e-9


def double(text):
    top, _, bottom = text.partition("/")
    return int(top) / int(bottom or "1")


@pytest.mark.slow
def test_one_nonlinearity_in_all_channels_is_refuted_by_equal_gains_or_by_an_equilibrium():
    one = NonlinearityClass.slope_restricted(0, 1)
    found = second(max_slope(FETZER, Diagonal((one,) * 4, repeated=True)))
    # equal gains are stable up to 0.698325; 0.523596 is what multipliers prove that do not know that it is one
    assert found.criterion == "matrix-zames-falb"
    assert found.largest.low == pytest.approx(0.681838, abs=1e-6)
    assert found.refuted_at == pytest.approx(0.681838, abs=1e-6)
    assert found.witness.kind == "equilibrium"
    odd = Diagonal((replace(one, odd=True),) * 4, repeated=True)
    _, shown = gains_refuting(channel_problem(FETZER, odd), most=float("inf"))
    gains = shown.certificate["proof"]["gains"]
    assert len(set(gains)) == 1
    assert double(gains[0]) == pytest.approx(0.698325, abs=1e-6)
    A, B, C, _ = FETZER.doubles()
    assert np.linalg.eigvals(A - double(gains[0]) * B @ C).real.max() >= 0
    assert np.linalg.eigvals(A - (double(gains[0]) - 1e-6) * B @ C).real.max() < 0


# channels that do not interact: 1/(s + 1)^3 is stable up to k = 8, 1/(s + 1)^4 up to 4, and Popov's criterion shows it
def test_the_answer_for_channels_that_do_not_interact_is_the_least_of_theirs():
    plant = as_plant([["1/(s+1)^3", "0"], ["0", "1/(s+1)^4"]])
    for uppers, factor in (((1, 1), 4), ((4, 1), 2), ((16, 1), 0.5)):
        found = second(max_sector(plant, [Sector(0, top) for top in uppers]))
        assert found.largest.low == pytest.approx(factor, rel=1e-4)
        assert found.largest.low < factor <= found.refuted_at < factor * (1 + 1e-6)


@pytest.mark.parametrize("odd", [False, True])
def test_loops_side_by_side_have_kernels_of_their_own(odd):
    # s^3 + (2 + k) s^2 + (1 - k/5) s + 1 - k/10 is stable up to (2 + k)(1 - k/5) = 1 - k/10, which kernels reach and
    # Popov's terms, which serve the other loop up to 8, do not: they end at 1.76
    plant = as_plant([["(s^2-s/5-1/10)/(s^3+2*s^2+s+1)", "0"], ["0", "1/(s+1)^3"]])
    found = max_slope(plant, [NonlinearityClass.slope_restricted(0, 1, odd=odd)] * 2)
    limit = (0.7 + (0.7**2 + 0.8) ** 0.5) / 0.4
    assert found.largest.low == pytest.approx(limit, rel=1e-3)
    assert found.largest.low < limit < found.refuted_at < limit * (1 + 1e-6)


@pytest.mark.slow
def test_permuted_and_scaled_channels_have_the_same_answer():
    A, B, C, D = VEENMAN.doubles()
    turn = np.array([2, 0, 1])
    scale = np.diag([4.0, 0.5, 2.0])  # sigma -> S sigma, mu -> mu/S: phi_i -> phi_i/s_i^2
    plant = as_plant((A, B[:, turn] @ scale, scale @ C[turn], scale @ D[np.ix_(turn, turn)] @ scale))
    found = second(max_slope(plant, [SlopeBounds(0, 1 / s**2) for s in np.diag(scale)], criterion="diagonal-circle"))
    assert found.largest.low == pytest.approx(0.767134, abs=1e-6)


# positive systems with positive feedback, H = -G: stable for every member as long as alpha rho(G(0)) < 1, in discrete
# time rho(G(1)); the diagonal multipliers w_i/v_i of Perron's vectors of G(0) prove it, equal gains refute it beyond
@pytest.mark.parametrize("discrete", [False, True])
def test_a_positive_system_is_answered_as_its_linear_gain(discrete):
    rng = np.random.default_rng(5)
    for n, m in ((3, 2), (5, 3)):
        B, C = (rng.integers(0, 4, (n, m)) + 1) / 4, (rng.integers(0, 4, (m, n)) + 1) / 8
        A = rng.integers(0, 4, (n, n)) / 16 / n
        A = A if discrete else A - 2 * np.eye(n)
        gain = C @ np.linalg.solve((np.eye(n) if discrete else np.zeros((n, n))) - A, B)
        exact = 1 / np.abs(np.linalg.eigvals(gain)).max()
        found = second(max_sector(as_plant((A, -B, C), dt=1 if discrete else None), [MOVING] * m))
        assert found.criterion == "diagonal-circle" if discrete else found.criterion.startswith("diagonal-")
        assert found.largest.low == pytest.approx(exact, rel=1e-5)
        assert found.refuted_at == pytest.approx(exact, rel=1e-5)
        assert found.refuted_at > found.largest.low


def test_a_channel_with_a_lower_bound_below_zero_and_an_unstable_plant():
    # 1/(s - 1) with phi in [2, u]: stable for every u, at phi = 2 sigma the pole is -1; and 1/(s + 1)^3 up to 8
    plant = as_plant([["1/(s-1)", "0"], ["0", "1/(s+1)^3"]])
    found = second(max_sector(plant, [Sector(2, 3), Sector(-0.5, 1)]))
    assert found.largest.low == pytest.approx(8, rel=1e-4)
    below = max_sector(plant, [Sector(0, 3), ONE])
    assert below.verdict is Verdict.REFUTED
    assert "whatever the factor" in str(below)


@pytest.mark.slow
def test_lower_bounds_far_above_zero_do_not_hide_small_factors():
    # 1/(s + 1)^3 is stable with gains up to 8: the factor 4; from 0.75 on the upper bound 2 is above the lower one 1.5
    plant = as_plant([["1/(s+1)^3", "0"], ["0", "1/(s+1)"]])
    varying = [NonlinearityClass(sector=Sector(1.5, 2), time_varying=True)] * 2
    assert 1 < max_sector(plant, varying, criterion="diagonal-circle").largest.low < 4


@pytest.mark.slow
def test_one_class_is_decided_as_it_is_given():
    assert certify(FETZER, [SlopeBounds(0, 0.5)] * 4).verdict is Verdict.PROVED
    refuted = certify(FETZER, [SlopeBounds(0, 0.6)] * 4)
    assert refuted.verdict is Verdict.REFUTED
    assert refuted.certificate["laws"]["channels"][0]["slope"] == ["0", str(Fraction(0.6))]
    same = certify(FETZER, Diagonal((NonlinearityClass.slope_restricted(0, 0.6),) * 4, repeated=True))
    assert same.verdict is Verdict.PROVED
    assert recheck(dict(same.certificate)).accepted


def test_the_sentence_is_from_the_certificates():
    found = max_slope(FETZER, [UNIT] * 4, criterion="diagonal-circle")
    assert "phi_4 with slope in [0, 0.523596]" in str(found)
    assert "destabilise the loop (certified)" in str(found)
    assert found.meaning == "The point 0 attracts every solution"
    with pytest.raises(TypeError, match="three values"):
        bool(found)


def test_a_certificate_about_something_else_is_no_answer():
    asked = channel_problem(FETZER, [UNIT] * 4, kind="slope", criterion="diagonal-circle")
    found = answer(asked)
    low, high = Fraction(found.largest.low), Fraction(found.refuted_at)
    for other in (
        Problem(plant=OPPOSITE, classes=asked.classes, kind="slope"),
        Problem(plant=FETZER, classes=asked.classes.scaled(Fraction(2)), kind="slope"),
    ):
        with pytest.raises(MismatchError):
            channel_bound(other, (low, found.proof), None)
    for proof, against in (
        ((2 * low, found.proof), None),  # more than is proved
        (None, (low, found.refutation)),  # less than is refuted
        ((low, found.refutation), None),
        (None, (high, found.proof)),
    ):
        with pytest.raises((MismatchError, KeyError)):
            channel_bound(asked, proof, against)
    repeated = replace(asked, classes=Diagonal(asked.classes.classes, repeated=True))
    with pytest.raises(MismatchError):  # the gains are not equal
        channel_bound(repeated, None, (high, found.refutation))


def test_a_proof_and_a_refutation_that_overlap_are_a_bug():
    asked = channel_problem(FETZER, [UNIT] * 4, kind="slope", criterion="diagonal-circle")
    found = answer(asked)
    low = Fraction(found.largest.low)
    with pytest.raises(ContradictionError):
        channel_bound(asked, (low, found.proof), (low / 2, found.refutation))


def test_the_time_allowed_is_kept_and_said():
    found = max_slope(FETZER, [UNIT] * 4, seconds=1e-6)
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "Nothing is proved" in str(found)


@pytest.mark.slow
def test_a_search_that_fails_proves_nothing(monkeypatch):
    monkeypatch.setattr(ShiftedLoop, "solutions", lambda *_: 1 / 0)
    found = max_slope(VEENMAN, [UNIT] * 3, criterion="full-block-popov")
    assert found.verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: max_sector(FETZER, [ONE] * 3), "3 classes are given for 4 channels; give one for each, in order"),
        (lambda: max_sector(as_plant((STATE, rows("1 0; 0 1; 0 0"), [1, 0, 0])), [ONE]), "need as many of both"),
        (
            lambda: max_sector(FETZER),
            r"4 inputs and 4 outputs: .* such as \[SlopeBounds\(0, 1\)\] \* 4, else choose a pair",
        ),
        (lambda: max_sector(FETZER, [Sector(0, float("inf"))] * 4), "give finite ones, such as"),
        (lambda: max_sector(FETZER, [ONE, 3.5, ONE, ONE]), "number 2 of what closes the channels: 3.5 is a number"),
        (lambda: max_slope(FETZER, [ONE] * 4), "the class of channel 1 has no slope bounds"),
        (lambda: max_sector(as_plant([["1/(s+1)", "0"], ["0", "1/(s+1)"]]), {"a": ONE, "b": ONE}), "no names"),
        (lambda: max_sector(ILL_POSED, [Sector(1, 2), ONE]), r"det\(1 \+ D L\) = 0 for the gains 1, 0"),
        (lambda: max_sector(CONSTANT, [ONE, ONE]), "the plant has no state"),
        (lambda: max_sector(FETZER, [ONE] * 4, criterion="park"), "does not answer this question"),
        (lambda: max_sector(FETZER, [ONE] * 4, lower=1), "lower is given beside classes"),
        (lambda: max_slope(FETZER, [UNIT] * 4, odd=True), "odd is given beside classes"),
        (lambda: max_sector(FETZER, [Sector(-2, -1)] * 4), "upper bound is not positive"),
    ],
)
def test_bad_input_is_one_sentence(ask, said):
    with pytest.raises(InputError, match=said):
        ask()


def test_gains_below_zero_destabilise_whatever_the_factor():
    # x' = -x/2 - g1 x + g2 x: stable for (-1, -1) and (0, 0), not for (-1, -1/4), which every [-1, alpha]^2 contains
    plant = as_plant(([["-1/2"]], [[1, 1]], [[1], [-1]], [[0, 0], [0, 0]]))
    found = max_sector(plant, [Sector(-1, 1), Sector(-1, 1)])
    assert found.verdict is Verdict.REFUTED
    assert (found.refuted_at, found.proof) == (0.0, None)
    first, second = map(Fraction, found.refutation.certificate["proof"]["gains"])
    assert -1 <= first <= 0
    assert -1 <= second <= 0
    assert second - first >= Fraction(1, 2)
    assert "whatever the factor" in str(found)


@pytest.mark.parametrize(
    ("D", "classes", "factor"),
    [
        ([[-1, 0], [0, 0]], [ONE, ONE], 1),  # 1 - g1
        ([[0, 1], [1, 0]], [SlopeBounds(0, 2)] * 2, Fraction(1, 2)),  # 1 - g1 g2
        ([[0, 2], [1, 0]], [ONE, ONE], Fraction(1) / 2**0.5),  # 1 - 2 g1 g2
    ],
)
def test_gains_for_which_the_loop_has_no_solution_refute(D, classes, factor):
    # slower than its gains: x' = -10 x - ..., so that D alone decides
    plant = as_plant(([[-10]], [["1/100", "1/100"]], [["1/100"], ["1/100"]], D))
    found = second(max_sector(plant, classes))
    assert found.largest.low < factor <= found.refuted_at < factor * (1 + 1e-6)
    assert "exactly one solution" in str(found)
    gains = [*map(Fraction, found.refutation.certificate["proof"]["gains"])]
    assert (1 + D[0][0] * gains[0]) * (1 + D[1][1] * gains[1]) == D[0][1] * D[1][0] * gains[0] * gains[1]


def test_lower_bounds_for_which_the_loop_has_no_solution_refute_the_class_as_it_is():
    found = certify(ILL_POSED, [Sector(1, 2), ONE])
    assert found.verdict is Verdict.REFUTED
    assert found.certificate["proof"]["gains"] == ["1", "0"]


@pytest.mark.slow
def test_poles_at_zero_that_the_theorem_does_not_cover_are_refused_unless_the_lower_bounds_move_them():
    plant = as_plant([["1/s", "1/s"], ["1/(s+1)", "1/(s^2+s)"]])
    critical = certify(plant, [ONE] * 2)
    assert (critical.verdict, critical.conclusion.code.identifier) == (Verdict.INCONCLUSIVE, "LURE-I012")
    assert "no weights > 0 make Lambda R symmetric, R = [[1, 1], [0, 1]]" in str(critical)
    assert certify(plant, [Sector(0.1, 0.2)] * 2).verdict is Verdict.PROVED
    double = max_sector(as_plant([["1/s^2", "0"], ["0", "1/(s+1)"]]), [ONE] * 2)
    assert double.verdict is Verdict.REFUTED  # with the gain 0 some solution grows like t


def test_gains_that_leave_an_eigenvalue_on_the_axis_refute():
    # 1 + g/(s + 1)^3: s = +-i sqrt(3) at g = 8; x+ = -x/2 - g x/2: z = -1 at g = 1, but not an integrator at g = 0
    for plant, sector in (("1/(s+1)^3", Sector(0, 8)), ("0.5/(z+0.5)", Sector(-1, 1))):
        assert certify(plant, [sector]).verdict is Verdict.REFUTED
    assert certify(as_plant([["1/s", "0"], ["0", "1/(s+1)"]]), [Sector(0, 1)] * 2).verdict is Verdict.PROVED


@pytest.mark.slow
def test_one_odd_nonlinearity_twice_of_the_same_signal():
    # published with the IQC toolbox (D'Amato): sigma_1 = sigma_2 = (1/(s + 1) - 1/(s + 1.01)) phi = .01 phi/((s + 1)
    # (s + 1.01)) is stable for slopes below 101; as two nonlinearities, of which one may be 0, below 1
    plant = as_plant([["-1/(s+1)", "1/(s+1.01)"]] * 2)
    odd = NonlinearityClass.slope_restricted(0, 1, odd=True)
    found = max_slope(plant, Diagonal((odd, odd), repeated=True))
    assert 96 < found.largest.low < 101 < found.refuted_at < 101.001
    assert max_slope(plant, [odd, odd]).refuted_at < 1.001


@pytest.mark.slow
def test_a_rectifier_around_one_channel():
    # x+ = x/2 - k max(x, 0): below 0 it decays by itself, so that every k serves; a gain fails from 3/2 on
    plant, relu = as_plant(([1], [1, "-1/2"]), dt=1), NonlinearityClass.relu(0, 2)
    found = certify(plant, relu)
    assert found.verdict is Verdict.PROVED
    assert str(found).startswith("PROVED")
    assert certify(plant, Sector(0, 2)).verdict is Verdict.REFUTED
    assert max_sector(plant, [NonlinearityClass.relu()]).largest.low > 100  # the largest ones are lost in rounding
    assert certify("exp(-s)/(s+1)", relu).verdict is Verdict.PROVED  # gains are stable below 2.2618
    # the certificate speaks of no slope class, nor that of a slope class of more than its bounds
    about = found.shown.certificate["laws"]
    slopes = certify(plant, [SlopeBounds(0, 1)]).shown.certificate["laws"]
    assert not contains(about, slopes)
    assert contains(slopes, certify(plant, [NonlinearityClass.relu()]).shown.certificate["laws"])


@pytest.mark.thorough
def test_a_hundred_rectifiers():
    # x+ = A x + B w, w = max(C x, 0) in 100 channels; |A| = 0.7 and |B| |C| k < 0.3, so that |x+| <= (0.7 + 0.3) |x|
    rng = np.random.default_rng(20261122)
    A, B, C = (rng.normal(size=size) for size in ((8, 8), (8, 100), (100, 8)))
    sides = [side / np.linalg.norm(side, 2) for side in (0.7 * A, B, C)]
    sides[0] *= 0.7
    whole = [[[Fraction(round(v * 1000), 1000) for v in row] for row in side.tolist()] for side in sides]
    plant = MultivariablePlant(*whole, [[Fraction(0)] * 100] * 100, dt=1)
    found = certify(plant, Diagonal((NonlinearityClass.relu(0, Fraction(1, 4)),) * 100, repeated=True))
    assert found.verdict is Verdict.PROVED
    assert recheck(dict(found.shown.certificate)).accepted


@pytest.mark.slow
def test_a_factor_of_rectifiers_is_proved_alone():
    # mutual inhibition, x_1' = -x_1 - k max(x_2, 0) and the same turned round, is stable for every k, gains for k < 1
    plant = as_plant(([[-1, 0], [0, -1]], [[0, 1], [1, 0]], [[1, 0], [0, 1]]))
    found = max_sector(plant, [NonlinearityClass.relu()] * 2)
    assert found.largest.low > 1  # two gains of 1 leave an eigenvalue 0: the factor is that of ReLUs
    assert "slope in" not in str(found)
    assert found.proved_up_to.endswith(" alone")
    assert found.hurwitz.low == 0
    shown = analyse(plant, [NonlinearityClass.relu(0, 3)] * 2)
    assert (shown.conclusion.verdict, shown.map, shown.hints) == (Verdict.PROVED, None, ())
    assert "phi_1 = 3 max(sigma, 0); phi_2 = 3 max(sigma, 0)" in shown.conclusion.headline
    assert not contains(found.proof.certificate["laws"], shown.problem.class_entry)


# Drummond, Guiver and Turner (2022), example 3: A is Metzler, B and C are nonnegative, so that ReLUs are as unstable as
# the gain k for which A + k C is singular, 89.909; floating point says that the forms serve up to 262144
@pytest.mark.parametrize("unit", [1, 1000])
def test_forms_of_rectifiers_reach_the_gain_of_a_positive_loop_in_any_unit(unit):
    A, C = (
        [["-.99", ".01", ".01"], [".01", "-9.99", ".01"], [".01", ".01", "-99.99"]],
        [[0, 1, 1], [0, 0, 1], [0, 0, 1]],
    )
    plant = as_plant(
        (A, [[-1, 0, 0], [0, -1, 0], [0, 0, -1]], [[unit * v for v in row] for row in C], np.zeros((3, 3)))
    )
    relus = Diagonal((NonlinearityClass.relu(),) * 3, repeated=True)
    found = max_sector(plant, relus, criterion="coupled-circle")
    assert 89.8 < found.largest.low * unit < 89.91


# Turner, Kerr and Sofrony (2015), example 17, sampled every 10 ms as by Richardson and others (2024): positive to the
# eye, as ReLUs are refuted from the linear gain .0844829 on; a bound of the order of 1/16 had no unit of its own: .0840
@pytest.mark.slow
def test_forms_of_two_samples_reach_the_gain_of_a_sampled_positive_loop():
    A = rows(
        "-5.4966 -1.7013 -1.7006 -1.0871 -.3885 -.256; 8 0 0 0 0 0; 0 2 0 0 0 0; 0 0 2 0 0 0; 0 0 0 2 0 0; 0 0 0 0 .5 0"
    )
    B = rows(
        ".5751 .384 .0158 .6315; .4514 .6831 .0164 .7176; .0439 .0928 .1901 .6927; .0272 .0353 .5869 .0841;"
        ".3127 .6124 .0576 .4544; .0129 .6085 .3676 .4418"
    )
    C = rows(
        ".3533 .7275 .4508 .2548 .9084 .0784; .1536 .4784 .7159 .8656 .2319 .6408; .6756 .5548 .8928 .2324 .2393 .1909;"
        ".6992 .121 .2731 .8049 .0498 .8439"
    )
    both = np.zeros((10, 10))
    both[:6] = np.hstack([np.array(side, dtype=float) for side in (A, B)]) / 100
    sampled = np.round(linalg.expm(both), 5)
    plant = as_plant((sampled[:6, :6], -sampled[:6, 6:], np.array(C, dtype=float), np.zeros((4, 4))), dt=0.01)
    relus = Diagonal((NonlinearityClass.relu(),) * 4, repeated=True)
    asked = replace(channel_problem(plant, relus, kind="sector", criterion="coupled-windows"), window=2)
    factor, shown = farthest(asked, criteria_for(asked)[0], Fraction(0), float("inf"))
    assert 0.0843 < factor < 0.0844829
    assert recheck(dict(shown.certificate)).accepted


def test_a_factor_of_rectifiers_is_refuted_alone():
    # x_1' = -x_1 + k max(x_1, 0) grows for k > 1, the other one, x_2' = -2 x_2 + k max(x_2, 0), for k > 2
    plant = as_plant(([[-1, 0], [0, -2]], [[-1, 0], [0, -1]], [[1, 0], [0, 1]]))
    found = second(max_sector(plant, [NonlinearityClass.relu()] * 2))
    assert found.largest.low < 1 < found.refuted_at < 1 + 2e-6
    assert found.largest.high == float("inf")  # nothing is said of larger factors
    assert f"at {found.refuted_text} times" in str(found)


# orders of sums led to 4.3366, 4.3376 and 4.3381; the search goes on while its programmes say that more is to be had
@pytest.mark.thorough
def test_the_slope_of_three_channels_does_not_depend_on_the_order_of_sums():
    found = max_slope(builtin_loop("veenman-scherer-koroglu"), [NonlinearityClass.slope_restricted(0, 1)] * 3)
    assert found.largest.low > 4.3377


# IQCbeta's iqc_d_slope_odd_test, by Megretski: sigma_1 = sigma_2, so that outputs are equal, and the loop is one of
# 0.01/((s + 1)(s + 1.01)), stable up to 101; the diagonal multiplier knows nothing of this and stops at 1.  Masses in
# the programme's solution that were a little negative left nothing of a multiplier that served up to 97.
@pytest.mark.slow
def test_one_nonlinearity_with_equal_arguments_is_proved_far_beyond_diagonal_multipliers():
    plant = as_plant([["-1/(s + 1)", "1/(s + 1.01)"]] * 2)
    one = NonlinearityClass.slope_restricted(0, 1, odd=True)
    found = max_slope(plant, Diagonal((one, one), repeated=(2,)))
    assert found.criterion == "matrix-zames-falb"
    assert 95 < found.largest.low < 101 < found.refuted_at < 101.001

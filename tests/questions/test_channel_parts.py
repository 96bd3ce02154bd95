"""Loops side by side are answered as the loops that they are, and one certificate holds what was accepted of each."""

from fractions import Fraction

import numpy as np
import pytest
from depth import sampled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

from lure import Diagonal, NonlinearityClass, Sector, as_plant, certify, max_sector, max_slope
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.questions.answers import answer, answers
from lure.analysis.questions.channel_map import _ray
from lure.analysis.questions.channel_parts import in_parts, splits_of
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for
from lure.analysis.questions.channels import _answer
from lure.analysis.verdict import Verdict

SLOPE, SECTOR = NonlinearityClass.slope_restricted(0, 1), NonlinearityClass(sector=Sector(0, 1))
VARYING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)
THIRD, INTEGRATOR = "1/(s+1)^3", "1/(s*(s+1)*(s+2))"
CT1 = "(s^2-s/5-1/10)/(s^3+2*s^2+s+1)"


def parts_of(problems):
    """The parts of the first way to take a plant apart."""
    return next((split.parts for split in splits_of(problems)), [])


def beside(*formulas):
    return as_plant([[one if i == j else "0" for j in range(len(formulas))] for i, one in enumerate(formulas)])


def seconded(found):
    """The answer, its certificates accepted by the second checker too."""
    shown = [one for one in (found.proof, found.refutation) if one is not None]
    opinions = [recheck(dict(one.certificate)) for one in shown]
    assert opinions
    assert all(one.accepted for one in opinions), opinions
    return found


# CT 1 alone reaches 4.589454 with kernels, 1/(s(s+1)(s+2)) 6 and 1/(s+1)^3 8 by Popov's criterion; kernels beside a
# pole at 0 of another loop were sought for all of them together
def test_the_default_is_no_worse_beside_a_pole_at_zero_than_for_each_loop():
    found = seconded(max_slope(beside(INTEGRATOR, CT1, THIRD), [SLOPE] * 3))
    limit = (0.7 + (0.7**2 + 0.8) ** 0.5) / 0.4  # s^3 + (2 + k) s^2 + (1 - k/5) s + 1 - k/10, by Hurwitz
    assert limit * (1 - 1e-6) < found.largest.low < limit <= found.refuted_at < limit * (1 + 1e-6)
    assert (found.criterion, found.critical) == ("parts", True)
    assert found.meaning == "Every solution converges to the set of equilibria"
    assert set(found.parameters) == {"channel 1", "channel 2", "channel 3"}


# 1/(s + 1)^2 with a gain that jumps is stable up to 16.85, which forms of higher degree nearly show, and the circle
# criterion, the only one for several channels, up to 8
@pytest.mark.slow
def test_criteria_of_one_channel_serve_a_loop_beside_others():
    found = seconded(max_sector(beside("1/(s+1)^2", "1/(s+1)"), [VARYING] * 2))
    assert 16.5 < found.largest.low < found.refuted_at
    assert found.refutation.certificate["proof"]["method"] == "part"
    assert found.refuted_at == pytest.approx(16.847136, abs=1e-5)
    assert (found.witness.kind, found.witness.data["channels"]) == ("switched gain", [1])
    assert found.witness.description.endswith("over and over again in channel 1 destabilises the loop")
    ray = _ray((Fraction(1), Fraction(1)), found, found.classes)  # in the map of both it refutes whatever the other is
    assert (ray.proved_k1, ray.refuted_k1, ray.refuted_k2) == (found.largest.low, found.refuted_at, 0)


@st.composite
def loops(draw):
    """Loops of one channel and up to three states, of eighths, and what turns their states and channels."""
    seed, discrete = draw(st.integers(0, 2**32 - 1)), draw(st.booleans())
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(rng.integers(2, 4)):
        k = rng.integers(1, 4)
        A = np.round(8 * rng.normal(size=(k, k))) / 8
        if discrete:
            A = np.round(A * rng.uniform(0.3, 0.9) / max(np.abs(np.linalg.eigvals(A)).max(), 0.1) * 64) / 64
        else:
            A = A - (np.round(8 * np.linalg.eigvals(A).real.max()) / 8 + rng.integers(1, 9) / 8) * np.eye(k)
        found.append((A, *(np.round(8 * rng.normal(size=shape)) / 8 for shape in ((k, 1), (1, k)))))
    return found, rng, discrete


# A solution for the classes is one of each channel: the answer is the least of theirs, from both sides.
@settings(max_examples=sampled(2, of=1000))
@given(loops(), st.sampled_from([SECTOR, SLOPE, VARYING]))
def test_the_answer_is_the_least_of_those_of_the_channels_alone(drawn, one):
    parts, rng, discrete = drawn
    dt = 1 if discrete else None
    ask = max_sector if one.slope is None else max_slope
    own = {"search": "full"} | ({"time_varying": one.time_varying} if one.slope is None else {})
    alone = [ask(as_plant(part, dt=dt), **own) for part in parts]
    A, B, C = (block_diag(*side) for side in zip(*parts, strict=True))
    states, channels = rng.permutation(len(A)), rng.permutation(len(C))
    plant = as_plant((A[np.ix_(states, states)], B[np.ix_(states, channels)], C[np.ix_(channels, states)]), dt=dt)
    found = seconded(ask(plant, [one] * len(parts)))
    low, high = min(each.largest.low for each in alone), min(each.refuted_at or np.inf for each in alone)
    assert found.largest.low == pytest.approx(min(low, 1e6), rel=1e-9)
    assert (found.refuted_at or np.inf) == pytest.approx(high, rel=1e-9)


@pytest.mark.slow
def test_one_class_is_proved_or_refuted_with_all_parts_or_by_one():
    plant = beside(INTEGRATOR, "2/(s+1)^3")
    proved = certify(plant, [Sector(0, 5), Sector(0, 3.9)])
    assert proved.verdict is Verdict.PROVED
    assert [part["theorem"] for part in proved.certificate["proof"]["parts"]] == ["popov", "popov"]
    assert recheck(proved.certificate).accepted
    refuted = certify(plant, [Sector(0, 5), Sector(0, 4.1)])
    assert refuted.verdict is Verdict.REFUTED
    assert recheck(refuted.certificate).accepted
    open_ = certify(beside("1/(s+1)^2", THIRD), [NonlinearityClass(sector=Sector(0, 17), time_varying=True)] * 2)
    assert open_.verdict is Verdict.REFUTED  # 1/(s + 1)^3 ends at 8
    undecided = certify(
        beside("1/(s+1)^2", "1/(s+1)"), [NonlinearityClass(sector=Sector(0, 16.7), time_varying=True)] * 2
    )
    assert undecided.verdict is Verdict.INCONCLUSIVE
    assert undecided.detail.startswith("channel 1: ")


def test_a_nonlinearity_that_is_repeated_is_one_of_each_part():
    both = Diagonal((SLOPE, SLOPE), repeated=True)
    found = seconded(max_slope(beside(CT1, THIRD), both))
    assert found.largest.low == max_slope(beside(CT1, THIRD), [SLOPE] * 2).largest.low
    assert found.proof.certificate["laws"]["repeated"] is True


def test_an_operator_on_several_channels_joins_their_loops():
    plant, one = beside("1/(s+1)", "1/(s+2)"), NonlinearityClass.norm_bounded(1)
    for repeated, parts in ((False, 2), (True, 0)):
        problem = channel_problem(plant, Diagonal((one, one), repeated=repeated), kind="sector")
        assert len(parts_of([problem])) == parts


def test_what_is_one_loop_or_is_asked_of_one_criterion_is_not_taken_apart():
    plant = beside(THIRD, "1/(s+1)")
    asked = {"kind": "sector", "criterion": "popov"}
    assert parts_of([channel_problem(plant, [SECTOR] * 2, **asked)]) == []
    assert max_sector(plant, [SECTOR] * 2, criterion="popov").criterion == "diagonal-popov"
    joined = as_plant([[THIRD, "1/(s+5)"], ["1/(s+7)", "1/(s+1)"]])
    assert parts_of([channel_problem(joined, [SECTOR] * 2, kind="sector")]) == []
    relu = NonlinearityClass.relu()
    assert parts_of([channel_problem(plant, [relu, SECTOR], kind="sector")]) == []
    assert len(parts_of([channel_problem(plant, [relu, SECTOR])])) == 2


@pytest.mark.slow
def test_hidden_modes_and_channels_without_states_belong_to_a_part():
    A = [[-1, 0, 0], [0, -2, 0], [0, 0, 1]]  # the last is a mode that no channel sees, and not stable
    B, C = [[1, 0, 0], [0, 1, 0], [0, 0, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, 0]]
    problem = channel_problem(as_plant((A, B, C, np.zeros((3, 3)))), [SECTOR] * 3, kind="sector")
    first, second = parts_of([problem])
    assert (first.channels, first.states, second) == ((0, 2), (0, 2), ((1,), (1,)))
    assert answer(problem).verdict is Verdict.REFUTED
    A[2][2] = -1
    found = seconded(max_sector(as_plant((A, B, C, np.zeros((3, 3)))), [SECTOR] * 3))
    assert found.largest.low > 1e5


# with the factor 8/10 the class [0, 10] of the first ends where its loop does, and beyond 9/10 the other has a class:
# each factor is refuted; (s + 1)^-2 ends between 16.52, which is proved, and 16.85, and 84/100 of 20 is 16.8
@pytest.mark.slow
def test_a_factor_that_leaves_a_channel_no_class_is_not_proved():
    found = max_sector(beside(THIRD, "1/(s+1)"), [Sector(0, 10), Sector(0.9, 1)])
    assert (found.verdict, found.refuted_at) == (Verdict.REFUTED, 0)
    jumping = NonlinearityClass(sector=Sector(0, 20), time_varying=True)
    found = max_sector(beside("1/(s+1)^2", "1/(s+1)"), [jumping, Sector(0.84, 1)])
    assert found.verdict is Verdict.INCONCLUSIVE
    assert "upper bound of a channel is not above its lower one" in found.reason
    assert found.refuted_at == pytest.approx(16.847136 / 20, abs=1e-6)


@pytest.mark.slow
def test_dead_times_in_one_loop_leave_the_others_their_own_theorems():
    found = seconded(max_slope(beside("exp(-s)/(s+1)", "2/(s+1)^3"), [SLOPE] * 2))
    alone = max_slope("exp(-s)/(s+1)")
    assert found.largest.low == alone.largest.low  # 2.26183
    assert "initial functions of finite energy" in found.meaning


def test_a_criterion_that_proves_no_more_says_so():
    problem = channel_problem(beside(THIRD, "1/(s+1)"), [SECTOR] * 2, kind="sector", criterion="full-block-popov")
    (criterion,) = criteria_for(problem)
    assert _answer(problem, criterion, None, Fraction(0)).reason == "no multiplier was found"
    told = "no multiplier was found that proves more than the factor 2, which is proved"
    assert _answer(problem, criterion, None, Fraction(2)).reason == told


# 1/(s + 1)^3 reaches 8, CT 1 4.589454 and 1/(s + 2)^3 64, whatever stands beside the diagonal: of a cascade the gains
# that destabilise are those of a part; states are mixed in the realisation of the transfer matrix
@pytest.mark.parametrize(
    "rows",
    [
        [[CT1, "1/(s+5)"], ["0", THIRD]],
        [["1/(s+2)^3", "0", "0"], ["0", THIRD, "0"], ["3/(s+4)", "-1/(s+7)", CT1]],
    ],
)
def test_a_cascade_is_answered_as_the_loops_that_drive_one_another(rows):
    found = seconded(max_slope(as_plant(rows), [SLOPE] * len(rows)))
    limit = (0.7 + (0.7**2 + 0.8) ** 0.5) / 0.4
    assert found.criterion == "cascade"
    assert limit * (1 - 1e-6) < found.largest.low < limit <= found.refuted_at < limit * (1 + 1e-6)
    assert found.meaning == "The point 0 attracts every solution"


@pytest.mark.slow
def test_a_cascade_in_samples_may_be_driven_at_once_and_in_continuous_time_not():
    plant = as_plant([["z/(10*(z-1/2)^2)", "1/2"], ["0", "1/(z-1/2)"]], dt=1)
    assert seconded(max_slope(plant, [SLOPE] * 2)).criterion == "cascade"  # 1/(z - 1/2) ends at 3/2
    direct = as_plant([[THIRD, "1/2"], ["0", "1/(s+1)"]])
    assert parts_of([channel_problem(direct, [SECTOR] * 2, kind="sector")]) == []
    resting = as_plant([[THIRD, "1/(s+2)"], ["0", INTEGRATOR]])  # a pole at 0
    assert parts_of([channel_problem(resting, [SECTOR] * 2, kind="sector")]) == []


@pytest.mark.thorough
def test_gains_that_jump_refute_a_cascade_as_they_do_one_of_its_loops():
    found = seconded(max_sector(as_plant([["1/(s+1)^2", "1/(s+5)"], ["0", "1/(s+1)"]]), [VARYING] * 2))
    assert 16 < found.largest.low < found.refuted_at < 16.85


def test_where_a_part_is_refused_the_whole_is_asked_as_before():
    problem = channel_problem(beside(THIRD, "1/(s+1)"), [SECTOR] * 2, kind="sector")

    def refusing(own, seconds, tell):
        return answers(own) if own[0].plant.order == 3 else certify(object())

    assert in_parts([problem], next(splits_of([problem])), refusing, None, None) is None
    assert Fraction(8) - Fraction(answer(problem).largest.low) < Fraction(1, 10**6)

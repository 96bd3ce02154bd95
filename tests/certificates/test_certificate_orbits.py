"""Certificates of orbits and switched gains: published ones are accepted, whatever is off by a little is not."""

from fractions import Fraction as F

import numpy as np
import pytest
from counterexamples import BIT, checked, rejected
from depth import rarely
from flint import arb
from hypothesis import given
from hypothesis import strategies as st
from plants import DISCRETE
from plants import block as exact
from tampering import edited

from lure.analysis.certificates.arithmetic import Malformed
from lure.analysis.certificates.balls import exponential
from lure.analysis.certificates.checker import Refuted, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.refutations import refutation_draft
from lure.analysis.counterexamples.linear import balls
from lure.analysis.counterexamples.orbit import accept_orbit
from lure.analysis.counterexamples.oscillation import oscillation_witness
from lure.analysis.counterexamples.periodic_discrete import periodic_witness_discrete, sector_witness_discrete
from lure.analysis.counterexamples.search import accept_orbit_continuous
from lure.analysis.counterexamples.switched import switched_witness, switched_witness_discrete
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import Evidence, Witness
from lure.errors import AssumptionError
from lure.nonlinearities import Saturation
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

FITTS = RationalPlant(
    [1, 0, 0], np.polymul([1, F(3, 50), F(9, 10000) + F("0.81")], [1, F(3, 50), F(9, 10000) + F("1.21")])
)
FITTS_SEED = (-0.8568501753859451, 1.5659435663914607, 0.5061096169300414, -1.061805076491118)
BRAGIN = RationalPlant([F("10.1"), 10, 0, 0], np.polymul([1, 0, 1], [1, 1, 1]))


def recorded(slope, state, durations, pieces):
    """A record of a half orbit of a saturation with kinks at -1 and 1, as ``oscillation_witness`` writes it."""
    data = {
        "points": [["-1", f"-{slope}"], ["1", slope]],
        "left_slope": "0",
        "right_slope": "0",
        "pieces": pieces,
        "durations": durations,
        "state": state,
        "half": True,
    }
    return Witness(
        kind="periodic orbit",
        k=float(F(slope)),
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description="",
        data=data,
    )


BRAGIN_ORBIT = recorded(
    "7133387840928541/18014398509481984",
    [0.7633138297082308, -0.24407501863487496, -0.28760256672698326, 0.18574511557127055],
    [1.8611495171054306, 3.402380445846665],
    [1, 2],
)


def fields_of(witness):
    names = ("kind", "k", "evidence", "slope_restricted", "odd", "time_varying", "description", "data")
    return {name: getattr(witness, name) for name in names}


@pytest.fixture(scope="module")
def flow():
    return refutation_draft(BRAGIN, BRAGIN_ORBIT)


@pytest.fixture(scope="module")
def example_6():
    points = [("-74498/72625", "-192/415"), ("-36864/72625", "-192/415"), ("192/175", 1)]
    witness = accept_orbit(DISCRETE[6], points, ["192/415", "192/415", -1])
    return refutation_draft(DISCRETE[6], witness)


@pytest.fixture(scope="module")
def switching():
    """The switching that ``switched_witness`` finds for ``1/(s + 1)^3``."""
    top = "25511631710321/4398046511104"
    times = ["158166302505/137438953472", "764953515829/549755813888"]
    data = {"lower": "0", "upper": top, "gains": ["0", top], "times": times}
    record = {"kind": "switched gain", "k": float(F(top)), "data": data, "time_varying": True}
    return refutation_draft(RationalPlant([1], [1, 3, 3, 1]), Witness(**{**fields_of(BRAGIN_ORBIT), **record}))


@pytest.mark.slow
def test_fitts_counterexample_with_a_saturation_is_accepted():
    witness = accept_orbit_continuous(FITTS, Saturation(gain=100), FITTS_SEED, 11.917)
    draft = refutation_draft(FITTS, witness)
    assert draft["laws"]["slope"] == ["0", "100"]
    assert isinstance(checked(draft), Refuted)
    narrower = str(100 - BIT)
    assert "class" in rejected(edited(draft, "laws", "slope", value=["0", narrower]))


def test_leonov_bragin_kuznetsov_orbit_is_accepted(flow):
    found = checked(flow)
    assert isinstance(found, Refuted)
    assert "periodic" in found.facts["orbit"]
    assert flow["laws"]["slope"][1] == "7133387840928541/18014398509481984"  # linear gains are stable up to 1000/101
    assert flow["laws"]["odd"]


@pytest.mark.slow
@pytest.mark.parametrize("block", [pytest.param(FITTS, marks=pytest.mark.thorough), BRAGIN])
def test_what_the_search_finds_is_accepted(block):
    assert isinstance(checked(refutation_draft(block, oscillation_witness(block, odd=True))), Refuted)


# With y = sigma + d phi the loop of H + d and phi is that of H and psi(y) = phi(sigma): s turns into s/(1 - d s), and a
# kink of psi at y = 1 into one at sigma = 1 - d s.
def test_feedthrough_moves_the_kinks_only():
    d, s = F(1, 4), F(BRAGIN_ORBIT.data["points"][1][1])
    bottom = BRAGIN.denominator
    block = RationalPlant(np.polyadd([d * c for c in bottom], list(BRAGIN.numerator)), bottom)
    kink = str(1 - d * s)
    data = {**BRAGIN_ORBIT.data, "points": [[f"-{kink}", f"-{s}"], [kink, str(s)]]}
    draft = refutation_draft(block, Witness(**{**fields_of(BRAGIN_ORBIT), "data": data}))
    assert F(draft["laws"]["slope"][1]) == s / (1 - d * s)
    assert isinstance(checked(draft), Refuted)


@pytest.mark.slow
def test_the_whole_orbit_is_accepted_as_the_half_is():
    data = BRAGIN_ORBIT.data
    whole = {
        **data,
        "pieces": [*data["pieces"], *(2 - p for p in data["pieces"])],
        "durations": 2 * data["durations"],
        "half": False,
    }
    draft = refutation_draft(BRAGIN, Witness(**{**fields_of(BRAGIN_ORBIT), "data": whole}))
    assert isinstance(checked(draft), Refuted)


@pytest.mark.slow
def test_an_orbit_in_matrices_is_accepted():
    A = [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1, -1]]
    block = StateSpace(A, [10, 10.125, 0, -1], [1, 0, -10.125, -0.125])
    loop = (A, [10, F(81, 8), 0, -1], [1, 0, F(-81, 8), F(-1, 8)])
    witness = accept_orbit_continuous(loop, Saturation(gain=1), (0, -20, 0, 0), 9.0)
    assert isinstance(checked(refutation_draft(block, witness)), Refuted)


def test_a_class_smaller_by_one_bit_is_not_refuted(flow, example_6):
    for draft in (flow, example_6):
        for name in ("sector", "slope"):
            low, high = (F(end) for end in draft["laws"][name])
            assert isinstance(checked(edited(draft, "laws", name, value=[str(low), str(high + BIT)])), Refuted)
            assert "class" in rejected(edited(draft, "laws", name, value=[str(low), str(high - BIT)]))
            assert "class" in rejected(edited(draft, "laws", name, value=[str(low + BIT), str(high)]))
        assert "class" in rejected(edited(draft, "laws", "linear", value=True))


@pytest.mark.parametrize("entry", ["state", "durations"])
def test_a_state_or_duration_may_miss_the_orbit_by_no_more_than_the_radius(flow, entry):
    radius, value = F(flow["proof"]["radius"]), F(flow["proof"][entry][0])
    inside, outside = str(value + radius / 2**20), str(value + 2 * radius)
    assert isinstance(checked(edited(flow, "proof", entry, 0, value=inside)), Refuted)
    assert "contraction" in rejected(edited(flow, "proof", entry, 0, value=outside))


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("pieces", [2, 1]),
        ("pieces", [1, 0]),
        ("pieces", [1, 1]),
        ("half", False),
        ("radius", "1/10"),
        ("radius", "0"),
        ("bits", 64),
        ("left", "1/1000"),  # not odd
        ("inverse", [["0"] * 6] * 6),
    ],
)
def test_a_flow_orbit_with_one_wrong_entry_is_rejected(flow, entry, value):
    assert rejected(edited(flow, "proof", entry, value=value))


def test_half_an_orbit_needs_an_odd_law(flow):
    nonlinearities = {**flow["laws"], "odd": False}
    assert isinstance(checked({**flow, "laws": nonlinearities}), Refuted)
    assert "odd" in rejected(
        edited({**flow, "laws": nonlinearities}, "proof", "left", value="1/1000")
    )  # on a piece not in the half


# Against the balls of another library, at far more bits.
@given(st.lists(st.fractions(-20, 20, max_denominator=50), min_size=4, max_size=4), st.integers(64, 300))
def test_the_ball_of_an_exponential_holds_it(entries, bits):
    G = [entries[:2], entries[2:]]
    found = exponential(G, F(3, 7), bits)
    with working_precision(800):
        true = (balls(G) * ball(F(3, 7))).exp()
        rows = [[abs(true[i, j] * arb(2) ** bits - found.rows[i][j]) for j in range(2)] for i in range(2)]
        assert all(row[0] + row[1] <= found.error for row in rows)


def test_an_orbit_of_another_block_is_rejected(flow):
    assert "contraction" in rejected(edited(flow, "system", "numerator", 1, value=str(10 + F(1, 2**60))))


# Beyond half the orbit's peak the nonlinearity turns up again: closure and levels hold, but y does not stay on its
# piece.
@pytest.mark.slow
def test_an_orbit_that_leaves_its_pieces_is_rejected(flow):
    slope = F(flow["laws"]["slope"][1])
    turned = edited(flow, "proof", "points", value=[["-2", f"-{slope}"], *flow["proof"]["points"], ["2", str(slope)]])
    turned["proof"] |= {"left": str(slope), "right": str(slope), "pieces": [p + 1 for p in flow["proof"]["pieces"]]}
    assert "stay" in rejected(turned)
    far = edited(turned, "proof", "points", 0, value=["-100", f"-{slope}"])
    assert isinstance(checked(edited(far, "proof", "points", -1, value=["100", str(slope)])), Refuted)


@pytest.mark.parametrize(
    ("plant", "odd", "period", "k"),
    [
        (1, True, 6, 13.5755),
        (2, True, 4, 1.10566),
        (2, False, 5, 0.80276),
        (3, True, 8, 0.3349),
        (6, False, 3, 0.911459),
    ],
)
def test_published_orbits_of_discrete_loops_are_accepted(plant, odd, period, k):
    witness = periodic_witness_discrete(DISCRETE[plant], odd=odd, periods=[period])
    draft = refutation_draft(DISCRETE[plant], witness)
    assert float(F(draft["laws"]["slope"][1])) < k
    assert draft["laws"]["odd"] == odd
    assert f"after {period} samples" in checked(draft).facts["orbit"]


def test_example_6_is_refuted_from_exactly_175_192_on(example_6):
    assert example_6["laws"]["slope"] == ["0", "175/192"]
    assert isinstance(checked(example_6), Refuted)
    assert "class" in rejected(edited(example_6, "laws", "odd", value=True))


def test_sector_orbits_claim_no_slope():
    draft = refutation_draft(DISCRETE[6], sector_witness_discrete(DISCRETE[6], periods=range(1, 5)))
    assert draft["laws"]["slope"] is None
    assert isinstance(checked(draft), Refuted)


@pytest.mark.parametrize("entry", ["u", "sigma"])
@pytest.mark.parametrize("sample", [0, 2])
def test_an_orbit_with_one_sample_moved_is_rejected(example_6, entry, sample):
    value = F(example_6["proof"][entry][sample])
    assert "sample" in rejected(edited(example_6, "proof", entry, sample, value=str(value + BIT)))


def test_an_orbit_with_a_point_of_the_law_moved_is_rejected(example_6):
    for i, (x, w) in enumerate(example_6["proof"]["points"]):
        assert rejected(edited(example_6, "proof", "points", i, value=[x, str(F(w) - BIT)]))


def test_the_orbit_at_rest_and_the_orbit_of_another_block_are_rejected(example_6):
    rest = edited(edited(example_6, "proof", "u", value=["0"]), "proof", "sigma", value=["0"])
    assert "vanishes" in rejected(rest)
    assert "difference" in rejected(edited(example_6, "system", "numerator", 1, value="24/25"))


def test_switched_gains_are_accepted_and_need_laws_that_vary(switching):
    found = checked(switching)
    assert isinstance(found, Refuted)
    assert 4 < float(F(switching["laws"]["sector"][1])) < 8  # 1/(s+1)^3: circle criterion 4, every linear gain up to 8
    assert "vary" in rejected(edited(switching, "laws", "time_varying", value=False))
    low, high = (F(end) for end in switching["laws"]["sector"])
    assert "class" in rejected(edited(switching, "laws", "sector", value=[str(low), str(high - BIT)]))


def test_switched_gains_that_do_not_grow_are_rejected(switching):
    m = switching["proof"]["squarings"]
    assert "growth" in rejected(edited(switching, "proof", "squarings", value=m - 1))
    calm = [str(F(g) / 2) for g in switching["proof"]["gains"]]  # inside the circle criterion's sector [0, 4)
    assert "growth" in rejected(edited(switching, "proof", "gains", value=calm))
    stretched = [str(F(t) * F(21, 20)) for t in switching["proof"]["times"]]
    assert "growth" in rejected(edited(switching, "proof", "times", value=stretched))


@pytest.mark.slow
@pytest.mark.parametrize("block", [exact([1], [1, 1, 1]), exact([1, 0, 0], [1, 2, 2, 1])])
def test_the_switchings_found_are_accepted(block):
    assert isinstance(checked(refutation_draft(block, switched_witness(block))), Refuted)


@pytest.mark.parametrize("plant", rarely([6, 1], 1))
def test_switched_gains_in_discrete_time_are_accepted(plant):
    draft = refutation_draft(DISCRETE[plant], switched_witness_discrete(DISCRETE[plant]))
    assert "times" not in draft["proof"]
    assert isinstance(checked(draft), Refuted)


def test_only_certified_witnesses_become_certificates():
    witness = Witness(**{**fields_of(BRAGIN_ORBIT), "evidence": Evidence.COMPUTED})
    with pytest.raises(AssumptionError, match="certified"):
        refutation_draft(BRAGIN, witness)


@pytest.mark.parametrize("name", ["flow", "example_6", "switching"])
def test_a_proof_with_an_entry_missing_or_too_many_is_no_certificate(name, request):
    draft = request.getfixturevalue(name)
    complete = completed(draft)
    for key in draft["proof"]:
        if key != "method":
            proof = {other: value for other, value in draft["proof"].items() if other != key}
            with pytest.raises(Malformed):
                check({**complete, "proof": proof})
    with pytest.raises(Malformed):
        check({**complete, "proof": {**draft["proof"], "note": "1"}})

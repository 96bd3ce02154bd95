"""One function of several channels in a full-block sector: exact values, inclusions, files, tampering."""

from fractions import Fraction

import numpy as np
import pytest
from tampering import assert_both_reject, edited

from lure import Diagonal, InputError, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis import decay_rate, l2_gain
from lure.analysis.certificates.drafts import contains
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.verdict import Verdict
from lure.analysis.wording import proviso
from lure.files import loop_to_toml, parse_system

NAMED = {"name": "loop", "source": "loop.toml"}
BLOCK = NonlinearityClass.full_block


def pair(low, high, **more):
    return Diagonal((BLOCK(low, high, **more),) * 2, repeated=True)


def both_sides(rows, classes, dt=None):
    found = max_sector(as_plant(rows, dt=dt), classes)
    assert all(recheck(dict(one.certificate)).accepted for one in (found.proof, found.refutation))
    return found.largest.low, found.refuted_at


# H = h I: gains c + r Q have the eigenvalues g, |g - c| <= r, among them c + i r, so that the limit is that of Re h >
# -1/k.  Of 1/(s + 1)^3 the least real part is -1/4 at omega = 1 (gains alone: 8).  Of 1/(2 z - 1) it is -1/3 at z = -1.
# H = J/(s + 1), J = [[0, 1], [-1, 0]], in [-k, k]: |H| <= 1, and mu = -Q sigma with Q = J leaves s + 1 - k, limit 1,
# while gains g_1, g_2 alone leave (s + 1)^2 + g_1 g_2: the same limit, at g_1 = -g_2
@pytest.mark.slow
@pytest.mark.parametrize(
    ("rows", "low", "dt", "limit"),
    [
        pytest.param([["1/(s+1)^3", "0"], ["0", "1/(s+1)^3"]], 0, None, 4, marks=pytest.mark.thorough),
        ([["1/(2*z-1)", "0"], ["0", "1/(2*z-1)"]], 0, 1, 3),
        ([["0", "1/(s+1)"], ["-1/(s+1)", "0"]], -1, None, 1),
    ],
)
def test_a_full_block_sector_ends_where_matrices_of_gains_destabilise(rows, low, dt, limit):
    proved, refuted = both_sides(rows, pair(low, 1), dt)
    assert limit * (1 - 1e-4) < proved < limit < refuted < limit * (1 + 1e-6)


def test_turning_the_channels_changes_nothing():
    # T H T' with T = [[3, 4], [-4, 3]]/5: phi is a member if and only if T' phi(T .) is one
    H = [["1/(s+1)", "1/(s+2)"], ["-1/(s+3)", "2/(s+1)^3"]]
    T = np.array([[3, 4], [-4, 3]])
    turned = [
        ["+".join(f"({T[i, k] * T[j, h]})*({H[k][h]})/25" for k in range(2) for h in range(2)) for j in range(2)]
        for i in range(2)
    ]
    for rows in (H, turned):
        assert certify(rows, pair(0, 1.9)).verdict is Verdict.PROVED  # up to 1.906, and refuted from 2.466 on
        assert certify(rows, pair(0, 2.47)).verdict is Verdict.REFUTED


def test_a_function_of_the_block_is_more_than_one_in_each_channel():
    rows = [["1/(s+1)^3", "0"], ["0", "1/(s+1)^3"]]
    apart = max_sector(as_plant(rows), [Sector(0, 1)] * 2)
    assert apart.largest.low > 7.99  # 1/(s + 1)^3 alone: 8
    assert certify(rows, pair(0, 5)).verdict is Verdict.REFUTED
    assert certify(rows, pair(0, 3.9)).verdict is Verdict.PROVED


@pytest.mark.slow
def test_beside_other_classes_and_from_w_to_z():
    lag = BLOCK(0, 1)
    rows = [["1/(s+1)^3", "0", "0"], ["0", "1/(s+1)^3", "0"], ["0", "0", "1/(s+1)^3"]]
    for top, verdict in ((3.99, Verdict.PROVED), (4.01, Verdict.REFUTED)):
        beside = Diagonal((NonlinearityClass(sector=Sector(0, top)), *[BLOCK(0, top)] * 2), repeated=(1, 2))
        assert certify(rows, beside).verdict is verdict
    delayed = Diagonal((NonlinearityClass.delayed(1), lag, lag), repeated=(1, 2))
    half = certify([["0.5/(s+1)", "0", "0"], ["0", "1/(s+1)", "0.1"], ["0", "0", "1/(s+2)"]], delayed)
    assert half.verdict is Verdict.PROVED
    # x' = -x - phi + w, z = x: phi = 0 is a member, and the least gain of all, 1, is reached with it
    plane = ([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, 1]], [[0, 0], [0, 0]])
    gain = l2_gain(plane, pair(0, 1), {"Bw": [[1], [0]], "Cz": [[1, 0]]})
    assert gain.gain.high == pytest.approx(1, rel=1e-3)


def test_a_direct_term_within_the_block_leaves_its_solutions_assumed():
    rows = [["1/(s+1)", "0.1"], ["0.1", "1/(s+1)"]]
    assert "has a solution" in proviso(certify(rows, pair(0, 1)).shown)
    assert not proviso(certify([["1/(s+1)", "0"], ["0", "1/(s+1)"]], pair(0, 1)).shown)


# H = J/(s + 1) as above in [-1/2, 1/2]: s + 1 = 1/2 at least.  1/(2 z - 1) twice, in [0, 1/2]: z = 1/2 without phi, and
# He H(z/2) + 2 > 0 on the circle of this radius, where H(z/2) = 1/(z - 1)
@pytest.mark.parametrize(
    ("rows", "low", "dt", "rate"),
    [
        ([["0", "1/(s+1)"], ["-1/(s+1)", "0"]], -0.5, None, 0.5),
        ([["1/(2*z-1)", "0"], ["0", "1/(2*z-1)"]], 0, 1, 0.5),
    ],
)
def test_a_function_at_each_time_in_the_sector_has_a_rate(rows, low, dt, rate):
    found = decay_rate(as_plant(rows, dt=dt), pair(low, 0.5))
    assert found.rate.low == pytest.approx(rate, rel=1e-6)
    assert found.rate.high == pytest.approx(rate, rel=1e-6)
    assert all(recheck(dict(one.certificate)).accepted for one in (found.proof, found.refutation))
    laws = [{**one, "operator": "any", "time_varying": True} for one in found.proof.certificate["laws"]["channels"]]
    if low:  # an operator may have a memory, which a rate makes larger
        assert_both_reject(edited(dict(found.proof.certificate), "laws", "channels", value=laws))


@pytest.mark.slow
def test_members_refute_an_operator_beside_a_block():
    A, B = [[-0.9, 0.56], [0.14, -4.46]], [[-1, -0.3, -1], [2.2, 2.2, -0.7]]
    plant = as_plant((A, B, [[0.3, -1.1], [-1.7, 0], [-1.6, -0.7]], [[0, 0.9, 0.2], [0, 0, 0.9], [0, 0, 0]]))
    one = NonlinearityClass.norm_bounded(0.9, dynamics="scalar linear time-invariant")
    shown = certify(plant, Diagonal((one, BLOCK(0, 0.9), BLOCK(0, 0.9)), repeated=(1, 2)))
    assert shown.verdict is Verdict.REFUTED
    data = dict(shown.shown.certificate)
    assert data["proof"]["method"] == "linear-members"
    assert recheck(data).accepted
    for gains in (["0", "2", "0"], ["1/2", "1/2", "0"]):  # beyond the sector; beside an operator in its channel
        assert_both_reject(edited(data, "proof", "gains", value=gains))


@pytest.mark.slow
def test_beside_dead_times_a_block_has_one_weight():
    # exp(-s)/(s + 1) twice: Re H = (cos w - w sin w)/(1 + w^2) > -1/k, which is the circle criterion of one channel
    w = np.linspace(1, 3, 100_001)
    limit = -1 / ((np.cos(w) - w * np.sin(w)) / (1 + w**2)).min()
    rows = [["exp(-s)/(s+1)", "0"], ["0", "exp(-s)/(s+1)"]]
    data = dict(certify(rows, pair(0, 0.995 * limit)).shown.certificate)
    assert recheck(data).accepted
    assert_both_reject(edited(data, "multiplier", "lambda", 0, value="1/2"))
    assert_both_reject(edited(data, "system", "D", value=[["0", "1/999999"], ["0", "0"]]))  # phi_1 is of sigma_2 too
    for i in range(2):
        assert_both_reject(edited(data, "laws", "channels", i, "sector", 1, value=str(Fraction(1.001 * limit))))


def test_files_have_the_size_beside_the_sector():
    text = '[plant]\ntransfer = [["1/(s+1)^3", "0"], ["0", "1/(s+1)^3"]]\n[[class]]\nsector = [0, 1]\nsize = 2\n'
    loop = parse_system(text, **NAMED)
    assert str(loop.classes) == "(phi_1, phi_2) in the full-block sector [0, 1]"
    assert parse_system(loop_to_toml(loop), **NAMED).classes == loop.classes
    for wrong in ("odd = true", "slope = [0, 1]", "repeated = 2"):
        with pytest.raises(InputError, match="size is given without norm, or beside other keys"):
            parse_system(text + wrong, **NAMED)
    with pytest.raises(InputError, match="finite bounds of its sector"):
        BLOCK(0, np.inf)


def test_inclusions_between_classes():
    entry = {"sector": ["0", "1"], "slope": None, "odd": False, "time_varying": False, "linear": False}
    block, moving = entry | {"operator": "full block"}, {"operator": "full block", "time_varying": True}
    assert contains(block | moving, block)
    assert not contains(block, block | moving)
    assert not contains(block, block | {"sector": ["0", "2"]})
    assert not contains(entry | {"operator": "any", "time_varying": True, "sector": ["-1", "1"]}, block)


PLANT = as_plant([["1/(s+1)", "1/(s+2)"], ["-1/(s+3)", "2/(s+1)^3"]])


def test_neither_checker_takes_what_is_not_of_the_class():
    proved = dict(certify(PLANT, pair(0, 1)).shown.certificate)
    weights = proved["multiplier"]["lambda"]
    assert weights[0] == weights[1]
    assert_both_reject(edited(proved, "multiplier", "lambda", 0, value="1/3"))  # the sum alone has a sign
    for bound in ("50", "-1"):
        for i in range(2):
            assert_both_reject(edited(proved, "laws", "channels", i, "sector", 1, value=bound))
    assert_both_reject(edited(proved, "laws", "channels", value=lambda both: [one | {"rate": "1/2"} for one in both]))
    assert_both_reject(edited(proved, "laws", "channels", value=lambda both: [one | {"odd": True} for one in both]))
    refuted = dict(certify(PLANT, pair(0, 3)).shown.certificate)
    (matrix,) = refuted["proof"]["matrices"]
    twice = [[str(2 * Fraction(v)) for v in row] for row in matrix]  # unstable as well, and beyond the sector
    assert_both_reject(edited(refuted, "proof", "matrices", 0, value=twice))
    assert_both_reject(edited(refuted, "proof", "matrices", 0, value=[["0", "0"], ["0", "0"]]))  # stable
    assert_both_reject(edited(refuted, "proof", "matrices", value=[matrix, matrix]))
    assert_both_reject(edited(refuted, "proof", "matrices", 0, value=[matrix[0]]))
    assert_both_reject(edited(refuted, "proof", "gains", value=["4", "0"]))
    alone = [{key: value for key, value in one.items() if key != "operator"} for one in refuted["laws"]["channels"]]
    assert_both_reject(
        edited(refuted, "laws", value={"channels": alone, "repeated": False})
    )  # sectors have no matrices


# The falsifier: phi = (c + r Q(sigma)) sigma with |Q| <= 1 that turns with sigma, of which (phi - l sigma)'(u sigma -
# phi) >= 0 at every sample.  With different weights in the channels the sum is negative for some member.
def test_random_members_keep_the_constraint_and_break_that_of_different_weights():
    rng = np.random.default_rng(1)
    sigma, low, high = rng.normal(size=(500, 2)), -0.5, 2.0
    angle = rng.normal(size=500) + np.abs(sigma).sum(axis=1)
    turned = np.stack([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
    share = rng.uniform(0, 1, size=(500, 1))
    phi = (low + high) / 2 * sigma + (high - low) / 2 * share * (turned @ sigma[..., None])[..., 0]
    products = (phi - low * sigma) * (high * sigma - phi)
    assert products.sum(axis=1).min() > -1e-12
    assert (products @ [1, 0.5]).min() < -0.1

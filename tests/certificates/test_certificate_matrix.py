"""Certificates with a matrix P: by hand, sharp from both sides, tampered with, and with solvers that fail."""

import json
import math
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from lure import RationalPlant, StateSpace
from lure.analysis.certificates import balls, riccati
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.balls import positive_definite
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.inequality.state_space import StatesInequality
from lure.analysis.rod.certificates import energy_matrix, energy_theta
from lure.analysis.theorems.circle import circle_largest
from lure.analysis.theorems.popov import popov_largest
from lure.errors import AssumptionError
from lure.rod import builtin_system, upwind
from lure.rod.parameters import Rod

ROD = builtin_system("paper-rod").rod
LAG, CHAIN = RationalPlant([1], [1, 3, 3, 1]), RationalPlant([1], [1, 3, 2, 0])
PLANTS = {
    "1": ([1, "-0.2", "-0.1"], [1, 2, 1, 1]),
    "3": ([1, 0, 0], [1, "0.2", 6, "0.1", 1]),
    "4": ([-1, 0, 0], [1, "0.2", 6, "0.1", 1]),
    "5": ([1, 0, 0], [1, "0.0003", 10, "0.0021", 9]),
    "6": ([-1, 0, 0], [1, "0.0003", 10, "0.0021", 9]),
    "7": ([1, 0, 0], [1, 2, 2, 1]),
    "chain": ([1], [1, 3, 2, 0]),
    "resonant integrator": ([1], [1, "0.1", 1, 0]),
    "feedthrough": ([1, -1, 10], [1, 1, 25]),
}


def plant(name):
    return RationalPlant(*([Fraction(v) for v in part] for part in PLANTS[name]))


def proved(draft):
    return check(json.dumps(completed(draft)))


def by_hand(block, upper, P, *, theta=None, zero=None):
    """The draft of a certificate with a P of our own."""
    draft = matrix_draft(RationalPlant([1], [1, 1]), Fraction(1))
    numerator, denominator = ([str(v) for v in part] for part in (block.numerator, block.denominator))
    time = "continuous" if block.dt is None else "discrete"
    draft["system"] = {"kind": "transfer", "time": time, "numerator": numerator, "denominator": denominator}
    draft["laws"]["sector"] = ["0", str(upper)]
    if theta is not None:
        draft |= {"theorem": "popov", "multiplier": {"theta": str(theta)}}
    return draft | {"proof": {"method": "matrix", "P": P, "exponent": 0, "zero": zero}}


# 1/(s(s+1)): A = [[0, 1], [0, -1]], x0 = (1, 0), l = (1, 1), so w' = -w + mu, zeta' = mu, sigma = -w + zeta and the
# matrix is [[2 P, theta - 1 - P], [., 2/k]]: with P = 1 and theta = 0 it is positive definite exactly for k < 1, the
# limit of the circle criterion; with theta = 2 it is diagonal, and every k is proved.
INTEGRATOR = RationalPlant([1], [1, 1, 0])
ZERO = {"right": ["1", "0"], "left": ["1", "1"], "pivot": 0}


@pytest.mark.parametrize("j", [3, 20, 60, 100])
def test_the_integrator_by_hand_is_sharp_at_one(j):
    below = Fraction(2**j - 1, 2**j)
    assert isinstance(proved(by_hand(INTEGRATOR, below, [["1"]], zero=ZERO)), Proved)
    for k in (1, 2 - below):
        with pytest.raises(Rejected, match="inequality"):
            completed(by_hand(INTEGRATOR, k, [["1"]], zero=ZERO))


def test_the_integrator_by_hand_has_every_sector_with_theta_two():
    found = proved(by_hand(INTEGRATOR, 10**30, [["1"]], theta=2, zero=ZERO))
    assert found.facts["residue"].startswith("rho = 1 > 0")
    with pytest.raises(Rejected, match="inequality"):  # 2/k = 0: not strict in the limit of high frequencies
        completed(by_hand(INTEGRATOR, "inf", [["1"]], theta=2, zero=ZERO))


@pytest.mark.parametrize(
    "zero",
    [
        {"right": ["0", "1"], "left": ["1", "1"], "pivot": 1},  # A x0 is not 0
        {"right": ["1", "0"], "left": ["1", "0"], "pivot": 0},  # l A is not 0
        {"right": ["1", "0"], "left": ["1", "1"], "pivot": 1},  # x0[pivot] = 0
        {"right": ["0", "0"], "left": ["1", "1"], "pivot": 0},
        {"right": ["1", "0"], "left": ["0", "0"], "pivot": 0},
        {"right": ["1"], "left": ["1", "1"], "pivot": 0},
    ],
)
def test_a_zero_eigenvalue_that_is_none_is_rejected(zero):
    with pytest.raises(Rejected):
        completed(by_hand(INTEGRATOR, "1/2", [["1"]], zero=zero))


def test_a_negative_residue_and_a_double_zero_are_rejected():
    with pytest.raises(Rejected, match="residue"):
        completed(by_hand(RationalPlant([-1], [1, 1, 0]), "1/2", [["1"]], zero=ZERO))
    double = {"right": ["1", "0"], "left": ["0", "1"], "pivot": 0}  # (s + 1)/s^2: A = [[0, 1], [0, 0]], l x0 = 0
    with pytest.raises(Rejected, match="l x0 = 0"):
        completed(by_hand(RationalPlant([1, 1], [1, 0, 0]), "1/2", [["1"]], zero=double))
    with pytest.raises(AssumptionError):
        matrix_draft(RationalPlant([1, 1], [1, 0, 0]), Fraction(1, 2), theta=Fraction(1))


# 1/(z - 1/2): least real part -1/(1 + 1/2) at z = -1, so the circle criterion ends at k = 3/2.  There P = 1:
# [[3/4, 1/2], [1/2, 2/k - 1]] is positive definite exactly for 2/k - 1 > 1/3.
@pytest.mark.parametrize("j", [5, 60])
def test_a_discrete_block_by_hand_is_sharp(j):
    block, step = RationalPlant([1], [1, Fraction(-1, 2)], dt=1), Fraction(1, 2**j)
    assert isinstance(proved(by_hand(block, Fraction(3, 2) - step, [["1"]])), Proved)
    for k in (Fraction(3, 2), Fraction(3, 2) + step):
        with pytest.raises(Rejected, match="inequality"):
            completed(by_hand(block, k, [["1"]]))


@pytest.mark.parametrize("theta", [None, Fraction(1), Fraction(-1)])
def test_an_unstable_block_is_never_proved_whatever_p(theta):
    block = RationalPlant([1], [1, -1])  # the matrix of the inequality is positive definite for P < 0 alone
    for P in ("-3", "-1", "0", "1", "3"):
        with pytest.raises(Rejected):
            completed(by_hand(block, "1/2", [[P]], theta=theta))
    with pytest.raises(AssumptionError):
        matrix_draft(block, Fraction(1, 2), theta=theta)


@given(st.lists(st.integers(-6, 6), min_size=10, max_size=10), st.integers(1, 4))
def test_positive_definite_agrees_with_the_leading_minors(entries, n):
    rows = iter(entries)
    M = [[next(rows) + (7 if i == j else 0) for j in range(i + 1)] for i in range(n)]
    full = [[M[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]
    minors = [minor([row[: m + 1] for row in full[: m + 1]]) for m in range(n)]
    assert positive_definite(M) == all(m > 0 for m in minors)


def minor(M):
    """Determinant by expansion along the first row."""
    if not M:
        return 1
    return sum((-1) ** j * v * minor([row[:j] + row[j + 1 :] for row in M[1:]]) for j, v in enumerate(M[0]))


@pytest.mark.parametrize("j", [1, 10, 60, 200])
@pytest.mark.parametrize("shift", [0, 300])
def test_positive_definite_is_sharp_and_does_not_depend_on_scale(j, shift):
    big = 2**j  # determinants: 2^j, 0 and -2^j; rows may be of very different size
    for off, expected in ((1, True), (0, False), (-1, False)):
        M = [[big], [big << shift, (big + off) << 2 * shift]]
        assert positive_definite(M) is expected


@pytest.mark.parametrize("wrong", [lambda v: math.isqrt(v) // 2 + 1, lambda v: 1, lambda v: 2 * math.isqrt(v)])
@pytest.mark.parametrize("off", [0, -1])
def test_a_wrong_factor_makes_nothing_positive_definite(monkeypatch, wrong, off):
    monkeypatch.setattr(balls, "math", SimpleNamespace(isqrt=wrong))
    assert not positive_definite([[4 << 40], [6 << 40, (9 << 40) + off]])


def test_positive_definite_weighs_the_remainder_against_its_diagonal(monkeypatch):
    # a = 2^30 - 5: the first pass subtracts 2^31 and takes roots; one too large leaves 9 on the diagonal, a beside it
    a = 2**30 - 5
    M = [[a * a + 2**31], [a, 2**60 - 1]]
    assert positive_definite(M)
    monkeypatch.setattr(balls, "math", SimpleNamespace(isqrt=lambda v: math.isqrt(v) + 1))
    assert not positive_definite(M)


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("criterion", ["circle", "popov"])
def test_certificates_reach_the_limit_of_the_criterion_and_no_further(name, criterion):
    block = plant(name)
    answer = (circle_largest if criterion == "circle" else popov_largest)(block)
    theta = None if criterion == "circle" else Fraction(answer.parameters["theta"])
    draft = matrix_draft(block, Fraction(answer.largest.low) * (1 - Fraction(1, 10**6)), theta=theta)
    assert isinstance(proved(draft), Proved)
    above = Fraction(answer.largest.high) * (1 + Fraction(1, 10**9))
    draft["laws"]["sector"][1] = str(above)
    with pytest.raises(Rejected, match="inequality"):
        completed(draft)
    with pytest.raises(AssumptionError):
        matrix_draft(block, above, theta=theta)


coefficient = st.fractions(Fraction(1, 4), 4, max_denominator=8)


@given(top=st.tuples(coefficient, coefficient), bottom=st.tuples(coefficient, coefficient), discrete=st.booleans())
def test_random_blocks_are_certified_below_the_limit_of_the_circle_criterion_alone(top, bottom, discrete):
    if discrete:  # poles in (0, 1), signs of both kinds
        a, b = (v / 5 for v in bottom)
        block = RationalPlant([top[0], -top[1]], [1, -a - b, a * b], dt=1)
    else:
        block = RationalPlant([top[0], -top[1]], [1, *bottom])
    limit = circle_largest(block).largest
    draft = matrix_draft(block, Fraction(limit.low) * (1 - Fraction(1, 10**6)))
    assert isinstance(proved(draft), Proved)
    with pytest.raises(AssumptionError):
        matrix_draft(block, Fraction(limit.high) * (1 + Fraction(1, 10**6)))


# (d, n) = (s^2 + 2 s - 3, 12): stable for gains above 1/4 alone.
def test_a_shifted_loop_is_proved_from_a_stabilising_gain_on():
    block = RationalPlant([12], [1, 2, -3])
    assert isinstance(proved(matrix_draft(block, Fraction(10), lower=Fraction(1, 2), theta=Fraction(1, 2))), Proved)
    for lower in (Fraction(1, 5), Fraction(0)):
        with pytest.raises(AssumptionError):
            matrix_draft(block, Fraction(10), lower=lower, theta=Fraction(1, 2))


def test_a_shifted_loop_with_feedthrough_matches_the_loop_shifted_by_hand():
    # H = (s^2 + 2 s + 12)/(s^2 + 2 s - 3), lower end 1/2: (d + n/2) = (3 s^2 + 6 s + 6)/2
    block, shifted = RationalPlant([1, 2, 12], [1, 2, -3]), RationalPlant([2, 4, 24], [3, 6, 6])
    limit = circle_largest(shifted).largest.low
    width = Fraction(3) if math.isinf(limit) else Fraction(limit) * (1 - Fraction(1, 10**6))
    found = proved(matrix_draft(block, width + Fraction(1, 2), lower=Fraction(1, 2)))
    assert "H(inf) = 2/3" in found.facts["well-posed"]
    assert isinstance(proved(matrix_draft(shifted, width)), Proved)


@given(st.data())
def test_a_changed_certificate_next_to_the_limit_is_rejected(data):
    draft = completed(matrix_draft(LAG, Fraction(7999, 1000), theta=Fraction(1)))
    rows, kind = draft["proof"]["P"], data.draw(st.sampled_from(["digit", "sign", "theta", "exponent", "sector"]))
    i = data.draw(st.integers(0, len(rows) - 1))
    j = data.draw(st.integers(0, i))
    if kind == "digit":  # the leading one
        digits = rows[i][j].lstrip("-")
        other = data.draw(st.sampled_from([d for d in "123456789" if d != digits[0]]))
        rows[i][j] = rows[i][j].replace(digits, other + digits[1:])
    elif kind == "sign":
        rows[i][j] = str(-int(rows[i][j]))
    elif kind == "theta":
        draft["multiplier"]["theta"] = data.draw(st.sampled_from(["-1", "0", "2", "9/10", "11/10"]))
    elif kind == "exponent":
        draft["proof"]["exponent"] += data.draw(st.sampled_from([-1, 1]))
    else:
        draft["laws"]["sector"][1] = data.draw(st.sampled_from(["8", "8001/1000", "9", "inf", "finite"]))
    with pytest.raises(Rejected):
        check(draft)


def test_two_digits_of_p_do_not_pass_next_to_the_limit():
    draft = matrix_draft(LAG, Fraction(7999, 1000), theta=Fraction(1))
    rows = [[Fraction(int(v)) for v in row] for row in draft["proof"]["P"]]
    draft["proof"]["P"] = [[str(int(float(f"{float(v):.1e}"))) for v in row] for row in rows]
    with pytest.raises(Rejected, match=r"inequality of P fails|P > 0 fails"):
        completed(draft)


def garbage(matrix, **options):
    n = len(matrix)
    return np.eye(n), np.random.default_rng(0).normal(size=(n, n)), n // 2


def not_a_number(matrix, **options):
    n = len(matrix)
    return np.eye(n), np.full((n, n), np.nan), n // 2


def never(matrix, **options):
    raise np.linalg.LinAlgError("no convergence")


@pytest.mark.parametrize("solver", [garbage, not_a_number, never])
def test_a_solver_that_fails_costs_an_answer_and_never_makes_one(monkeypatch, solver):
    monkeypatch.setattr(riccati, "linalg", SimpleNamespace(**vars(scipy.linalg) | {"schur": solver}))
    monkeypatch.setattr(riccati, "PRECISIONS", ())
    with pytest.raises(AssumptionError, match="no matrix P was found"):
        matrix_draft(LAG, Fraction(7), theta=Fraction(1))


@pytest.mark.parametrize("name", ["5", "chain", "feedthrough"])
def test_more_digits_serve_where_doubles_find_nothing(monkeypatch, name):
    block = plant(name)
    answer = popov_largest(block)
    monkeypatch.setattr(riccati, "linalg", SimpleNamespace(**vars(scipy.linalg) | {"schur": never}))
    k = Fraction(answer.largest.low) * (1 - Fraction(1, 10**6))
    assert isinstance(proved(matrix_draft(block, k, theta=Fraction(answer.parameters["theta"]))), Proved)


@pytest.mark.parametrize("units", [(-2.0, -2.0), (-8.0, 2.0)])
def test_units_of_either_sign_take_the_same_places(units):
    # x_i = u_i z_i: P_ij = Q_ij/(u_i u_j), so that -8, 2 in place of 8, 2 turns the sign of P_12 and nothing else
    found = []
    for each in (units, tuple(map(abs, units))):
        scaled = riccati.Scaled(
            A=np.diag([-1.0, -2.0]), b=np.ones(2), q=np.full(2, 0.5), r=2.0, units=np.array(each), doubt=0.0
        )
        Q = scaled.solution(0.25, 0.25)
        found.append((scaled.rounded(Q, scaled.margin(Q), 0), scaled.refined(Q, 0.25, 0.25)))
        for one in found[-1]:
            P = [[v / 2**one.exponent for v in row] for row in one.rows]
            exact = Q / np.outer(each, each)
            assert np.allclose([*P[0], *P[1]], [exact[0, 0], exact[1, 0], exact[1, 1]], rtol=0, atol=2**-one.exponent)
    for turned, plain in zip(*found, strict=True):
        assert (turned.exponent, turned.rows[0], turned.rows[1][1]) == (plain.exponent, plain.rows[0], plain.rows[1][1])
        assert turned.rows[1][0] == math.copysign(plain.rows[1][0], math.prod(units))


# x' = -x + xi, xi' = mu, sigma = r xi - c x: H = (r (s + 1) - c)/(s (s + 1)), residue r - c.
@pytest.mark.parametrize(("r", "c"), [(2, 1), (1, 2), (1, 1)])
def test_indirect_control_is_proved_for_a_positive_residue_alone(r, c):
    block = StateSpace([[-1, 1], [0, 0]], [0, 1], [-c, r])
    if r > c:
        found = proved(matrix_draft(block, "inf", theta=Fraction(3, 2)))
        assert found.facts["residue"].startswith("rho = 1 > 0")
        return
    with pytest.raises(AssumptionError):
        matrix_draft(block, Fraction(1, 10), theta=Fraction(1))


@pytest.mark.parametrize("theta", [Fraction(0), Fraction(1, 50)])
def test_a_dense_block_of_order_41_is_certified_at_nine_tenths_of_the_limit(theta):
    rng = np.random.default_rng(7)
    A = rng.standard_normal((41, 41))
    A -= (np.linalg.eigvals(A).real.max() + 0.5) * np.eye(41)
    block = StateSpace(A, rng.standard_normal(41), rng.standard_normal(41))
    largest = StatesInequality(block, Fraction(0), weighted=True).best().largest
    found = proved(matrix_draft(block, Fraction(largest.low) * Fraction(9, 10), theta=theta or None))
    assert found.certificate["numbers"] == "doubles, exactly"
    with pytest.raises(AssumptionError):
        matrix_draft(block, Fraction(largest.high) * Fraction(11, 10), theta=theta or None)


@pytest.mark.parametrize("cells", [1, 10, pytest.param(200, marks=pytest.mark.thorough)])
def test_the_energy_of_the_scheme_proves_every_sector_with_a_multiple_of_the_identity(cells):
    scheme = upwind(ROD, cells)
    theta = energy_theta(scheme)
    draft = matrix_draft(scheme, "inf", theta=theta)
    rows = draft["proof"]["P"]
    assert len(rows) == 2 * cells
    assert {v for row in rows for v in row[:-1]} <= {"0"}
    assert {row[-1] for row in rows} == {str(theta * 4 / cells)}  # theta/(2 s d), s d = N/(rho L), rho = 8, L = 1
    assert proved(draft).facts["residue"].startswith("rho = 1/8 > 0")  # A/k


def test_the_energy_of_the_scheme_needs_the_theta_it_asks_for():
    scheme = upwind(ROD, 10)
    theta = energy_theta(scheme)
    least = next(theta * j / 100 for j in range(100, 0, -1) if energy_matrix(scheme, theta * (j - 1) / 100) is None)
    assert theta * Fraction(7, 10) < least < theta * Fraction(9, 10)  # EASE = 5/4, rounded up to four binary places
    draft = matrix_draft(scheme, "inf", theta=theta)
    for part, holds in ((Fraction(101, 100), True), (Fraction(98, 100), False)):
        unit = least * part / Fraction(5, 2)  # 2 s d = 5/2
        draft["multiplier"]["theta"] = str(least * part)
        whole = round(unit * 2**60)
        draft["proof"] |= {"exponent": 60, "P": [["0"] * i + [str(whole)] for i in range(20)]}
        if holds:
            assert isinstance(proved(draft), Proved)
        else:
            with pytest.raises(Rejected, match="inequality"):
                completed(draft)


# k < Z: K = (E/L) k^2/(Z^2 - k^2) = 11.52/(1.44 - 4e-8) is the limit of the circle criterion, of the rod and for any N.
@pytest.mark.parametrize("cells", [10, pytest.param(200, marks=pytest.mark.thorough)])
def test_the_scheme_is_proved_next_to_the_limit_of_the_circle_criterion(cells):
    k, square = Fraction(1, 5000), Fraction(144, 100)
    limit = 288_000_000 * k**2 / (square - k**2)
    draft = matrix_draft(upwind(ROD, cells), limit * (1 - Fraction(1, 10**6)))
    assert isinstance(proved(draft), Proved)


def test_a_matched_rod_and_one_of_irrational_impedance():
    matched = Rod(
        youngs_modulus=288e6, density=8, length=1, area=Fraction(1, 40000), damping=Fraction(6, 5), compliance=1
    )
    assert isinstance(proved(matrix_draft(upwind(matched, 10), "inf", theta=Fraction(1, 1000))), Proved)
    with pytest.raises(AssumptionError, match="irrational"):
        matrix_draft(
            upwind(Rod(youngs_modulus=2, density=1, length=1, area=1, damping=1, compliance=1), 2), Fraction(1)
        )
    with pytest.raises(AssumptionError, match="damping"):
        energy_theta(upwind(Rod(youngs_modulus=1, density=1, length=1, area=1, damping=-2, compliance=1), 2))


def test_a_proof_by_a_matrix_is_of_the_laws_that_vary_in_time_only_without_theta():
    for theta, holds in ((None, True), (Fraction(1), False)):
        draft = matrix_draft(LAG, Fraction(3), theta=theta)
        draft["laws"]["time_varying"] = True
        if holds:
            assert isinstance(proved(draft), Proved)
        else:
            with pytest.raises(Rejected):
                completed(draft)

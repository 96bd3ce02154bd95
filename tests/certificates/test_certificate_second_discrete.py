"""The second checker in discrete time and on constant gains, sharp on both sides of every limit."""

from fractions import Fraction as F

import pytest
from handwritten import EQUILIBRIA, GAINS, THIRD, accepted, nonlinearities, polynomial, proved, transfer


def in_tangent(p):
    """(1 + x)^deg p((1 - x)/(1 + x)) for ascending coefficients of p."""
    n = len(p) - 1
    total = [F(0)] * (n + 1)
    for i, c in enumerate(p):
        term = [F(c)]
        for factor in [(1, -1)] * i + [(1, 1)] * (n - i):
            term = [
                (term[j] * factor[0] if j < len(term) else 0) + (term[j - 1] * factor[1] if j else 0)
                for j in range(len(term) + 1)
            ]
        total = [a + b for a, b in zip(total, term, strict=True)]
    return total


# 1/(z - 1/2): 5/4 - c + k (c - 1/2) at c = (1 - x)/(1 + x) is (2 k + 1 + (9 - 6 k) x)/4/(1 + x): k < 3/2.
@pytest.mark.parametrize(("k", "good"), [(F(149, 100), True), (F(3, 2), False), (F(151, 100), False)])
def test_the_circle_criterion_in_discrete_time(k, good):
    system = transfer([1], [1, "-1/2"], "discrete")
    certificate = proved(
        system, nonlinearities(0, k, time_varying=True), "circle", {}, polynomial([2 * k + 1, 9 - 6 * k])
    )
    assert accepted(certificate) is good


# 1/(z - 1): Re H = -1/2: k < 2 (at k = 2 the gain puts a root at -1); F = (2/k - 1)(1 - c), 1 - c divided out.
@pytest.mark.parametrize(("k", "good"), [(F(199, 100), True), (F(2), False)])
def test_the_critical_case_in_discrete_time(k, good):
    proof = polynomial([2 / k - 1])
    certificate = proved(transfer([1], [1, -1], "discrete"), nonlinearities(0, k), "circle", {}, proof, EQUILIBRIA)
    assert accepted(certificate) is good


# 0.1 z/(z - 0.9)^2: |d|^2 = (1.81 - 1.8 c)^2, Re[n conj(d)] = 0.181 c - 0.18, Re[(1 - 1/z) n conj(d)] =
# -0.2 c^2 + 0.361 c - 0.161; the limit is 19/5 (Carrasco et al. 2019, example 1).
@pytest.mark.parametrize(("k", "good"), [(F("3.7999"), True), (F("3.8001"), False)])
def test_tsypkin(k, good):
    system, q = transfer(["1/10", 0], [1, "-9/5", "81/100"], "discrete"), F(41282051, 10**7)
    square = [F("3.2761"), F("-6.516"), F("3.24")]
    in_cosine = [a / k + b + q * c for a, b, c in zip(square, (F("-.18"), F(".181"), 0), TSYPKIN_SLOPE, strict=True)]
    proof = polynomial(in_tangent(in_cosine))
    certificate = proved(system, nonlinearities(0, k, slope=["0", "inf"]), "tsypkin", {"q": str(q)}, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, k)})
    assert not accepted({**certificate, "laws": nonlinearities(0, k, slope=["-1", str(k)])})
    assert not accepted({**certificate, "multiplier": {"q": "-1"}})


TSYPKIN_SLOPE = (F("-.161"), F(".361"), F("-.2"))


# (2 z + 0.92)/(z^2 - z/2): |d|^2 = 1.25 - c, Re[n conj(d)] = 1.84 c^2 + 1.54 c - 1.92, Re[(z - 1) n conj(d)] =
# 3.46 - 1.62 c - 1.84 c^2, |z - 1|^2 |n|^2 = (2 - 2 c)(4.8464 + 3.68 c); the limit is 0.684932.
@pytest.mark.parametrize(("k", "good"), [(F("0.6849"), True), (F("0.6850"), False)])
def test_jury_lee(k, good):
    system, q = transfer([2, "23/25"], [1, "-1/2", 0], "discrete"), F(38889, 25000)
    loss = [F("9.6928"), F("7.36") - F("9.6928"), F("-7.36")]
    in_cosine = [
        F("1.25") / k - F("1.92") + q * F("3.46") - q * k / 2 * loss[0],
        -1 / k + F("1.54") - q * F("1.62") - q * k / 2 * loss[1],
        F("1.84") - q * F("1.84") - q * k / 2 * loss[2],
    ]
    proof = polynomial(in_tangent(in_cosine))
    certificate = proved(system, nonlinearities(0, k, slope=["-inf", str(k)]), "jury-lee", {"q": str(q)}, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, k, slope=["-inf", "1"])})
    assert not accepted({**certificate, "laws": nonlinearities(0, k)})


# Every finite k: 1 + (1/2)/(z - 1/2) = z/(z - 1/2) has Re > 0; n conj(d) = 1 - z/2, U = 1 - c/2.  D = 1 > 0, so that
# Jury and Lee's nonlinearities need a slope from 0 on; with q > 0 they cannot have every finite bound.
def test_every_finite_bound_in_discrete_time():
    system, proof = transfer([1, 0], [1, "-1/2"], "discrete"), polynomial([F(1, 2), F(3, 2)])
    both, above = nonlinearities(0, "finite", slope=True), nonlinearities(0, "finite", slope=["-inf", "finite"])
    assert accepted(proved(system, both, "jury-lee", {"q": "0"}, proof))
    assert not accepted(proved(system, above, "jury-lee", {"q": "0"}, proof))
    assert not accepted(proved(system, both, "jury-lee", {"q": "1"}, proof))
    assert accepted(proved(system, nonlinearities(0, "inf"), "circle", {}, proof))
    assert not accepted(proved(system, nonlinearities(0, "inf", slope=True), "tsypkin", {"q": "0"}, proof))


def cosines(harmonics):
    """Ascending coefficients in c of sum a_j cos(j w), a_j = harmonics[j] + harmonics[-j]."""
    top = max(abs(j) for j in harmonics)
    chebyshev = [[F(1)], [F(0), F(1)]]
    while len(chebyshev) <= top:
        last, before = chebyshev[-1], chebyshev[-2]
        chebyshev.append([2 * a - b for a, b in zip([0, *last], [*before, 0, 0], strict=True)])
    total = [F(0)] * (top + 1)
    for j, a in harmonics.items():
        for i, c in enumerate(chebyshev[abs(j)]):
            total[i] += a * c
    return total


# The same block: a monotone nonlinearity of slope 175/192 has an orbit of period 3, and no multiplier reaches it.
@pytest.mark.parametrize(("k", "good"), [(F("0.9114"), True), (F(175, 192), False)])
def test_zames_falb_in_discrete_time(k, good):
    taps = {-2: F(23036336077, 200000000000), 1: F(442409159307, 500000000000)}
    inner = {1: F("1.54") - F(1, 2) / k, 2: F(".92"), 0: F("1.25") / k - 1, -1: -F(1, 2) / k}  # exponents of 1/z
    product = {}
    for i, m in [(0, F(1)), *((i, -h) for i, h in taps.items())]:
        for j, g in inner.items():
            product[i + j] = product.get(i + j, F(0)) + m * g
    proof = polynomial(in_tangent(cosines(product)))
    system = transfer([2, "23/25"], [1, "-1/2", 0], "discrete")
    written = {"taps": [[i, str(h)] for i, h in taps.items()]}
    certificate = proved(system, nonlinearities(0, k, slope=True), "zames-falb", written, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, k)})
    assert not accepted({**certificate, "multiplier": {"taps": [[-2, "1/10"], [1, "9/10"]]}})
    assert not accepted({**certificate, "multiplier": {"taps": [[-2, "-1/10"], [1, "4/5"]]}})


@pytest.mark.parametrize(("k", "good"), [(8 - F(1, 2**60), True), (F(8), False), (F(9), False)])
def test_every_constant_gain_below_eight(k, good):
    certificate = proved(THIRD, nonlinearities(0, k, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": nonlinearities(0, k)})


# s^2/(..) of the Kalman conjecture is stable for every gain k >= 0; the integrator 1/s is not at k = 0.
def test_every_finite_constant_gain():
    kalman = transfer([1, 0, 0], [1, ".12", "2.0254", ".121308", ".98191881"])
    assert accepted(
        proved(kalman, nonlinearities(0, "finite", linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    )
    assert not accepted(
        proved(kalman, nonlinearities(-1, "finite", linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    )
    integrator = transfer([1], [1, 0])
    assert not accepted(
        proved(integrator, nonlinearities(0, 1, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    )
    assert accepted(
        proved(integrator, nonlinearities("1/9", 1, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    )


# d = z - 1/2: the root 1/2 - g is inside the circle up to g = 3/2; there it is -1.
@pytest.mark.parametrize(("k", "good"), [("149/100", True), ("3/2", False)])
def test_constant_gains_in_discrete_time(k, good):
    system = transfer([1], [1, "-1/2"], "discrete")
    assert (
        accepted(proved(system, nonlinearities(0, k, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS))
        is good
    )


# 1/(z - 1/2), k = 1: 3/4 + q (-2 c^2 + 3 c/2 + 1/2); -z/(10 (z - 1/2)), q = 0, k = 1: 1.15 - 0.95 c;
# z/(z - 1/2) without 1/k: 1 - c/2 + q (-c^2 + 3 c/2 - 1/2).
def test_hypotheses_in_discrete_time_that_nothing_else_would_catch():
    lag, monotone = transfer([1], [1, "-1/2"], "discrete"), nonlinearities(0, 1, slope=["0", "inf"])
    for q, good in ((F(1, 10), True), (F(-1, 10), False)):
        proof = polynomial(in_tangent([F(3, 4) + q / 2, q * F(3, 2), -2 * q]))
        assert accepted(proved(lag, monotone, "tsypkin", {"q": str(q)}, proof)) is good
    negative, proof = transfer(["-1/10", 0], [1, "-1/2"], "discrete"), polynomial(in_tangent([F("1.15"), F("-.95")]))
    assert accepted(proved(negative, nonlinearities(0, 1, slope=True), "tsypkin", {"q": "0"}, proof))
    assert not accepted(proved(negative, monotone, "tsypkin", {"q": "0"}, proof))
    lead, every = transfer([1, 0], [1, "-1/2"], "discrete"), nonlinearities(0, "finite", slope=True)
    proof = polynomial(in_tangent([F("0.95"), F("-0.35"), F("-0.1")]))
    assert not accepted(proved(lead, every, "jury-lee", {"q": "1/10"}, proof))

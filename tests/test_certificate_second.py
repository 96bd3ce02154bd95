"""The second checker of certificates on certificates written by hand, sharp on both sides of every limit."""

import cmath
import json
import math
from fractions import Fraction as F
from functools import reduce
from itertools import pairwise
from math import gcd, lcm

import pytest
from flint import fmpq_poly
from hypothesis import given
from hypothesis import strategies as st

from analysis.certificates.second import axis, recheck
from analysis.certificates.second.classes import graph
from analysis.certificates.second.shifting import Shifted
from analysis.refutation.piecewise import Flow, PiecewiseLoop, returns
from analysis.refutation.realisation import companion
from lure.rational import RationalBlock

ATTRACTS = "0 attracts every motion"
EQUILIBRIA = "every motion converges to the set of equilibria"
BOUNDED = "every motion is bounded"
DELAYED = "0 attracts every motion with inputs and initial functions of finite energy"
AT_REST = "every motion of finite energy comes to rest, its end at a zero of the law"
GAINS = "every constant gain of the class makes the loop asymptotically stable"
NO_REST = "a loop of the class has a motion that does not converge to an equilibrium"
OTHERS = "a loop of the class has equilibria other than 0"


def transfer(numerator, denominator, time="continuous"):
    return {
        "kind": "transfer",
        "time": time,
        "numerator": [str(F(c)) for c in numerator],
        "denominator": [str(F(c)) for c in denominator],
    }


def laws(lower, upper, **more):
    """`slope=True` takes the bounds of the sector."""
    ends = [str(lower), str(upper)]
    slope = ends if more.get("slope") is True else more.get("slope")
    flags = {name: more.get(name, False) for name in ("odd", "time_varying", "linear")}
    return {"sector": ends, "slope": slope, **flags}


def whole(coefficients):
    """The same up to a positive factor, in coprime integers."""
    exact = [F(c) for c in coefficients]
    scale = lcm(*(c.denominator for c in exact))
    integers = [int(c * scale) for c in exact]
    shared = reduce(gcd, integers) or 1
    return [str(c // shared) for c in integers]


def polynomial(coefficients, variable="omega^2"):
    return {"method": "polynomial", "variable": variable, "coefficients": whole(coefficients), "limits": ["1", "1"]}


def matrix(rows, zero=None, exponent=0):
    return {"method": "matrix", "P": [[str(v) for v in row] for row in rows], "exponent": exponent, "zero": zero}


def proved(system, class_, theorem, multiplier, proof, conclusion=ATTRACTS, **more):
    return {
        "format": "lure-certificate/1",
        "verdict": "PROVED",
        "convention": "sigma = H mu, mu = -phi(sigma)",
        "numbers": "rationals",
        "system": system,
        "laws": class_,
        "law": None,
        "theorem": theorem,
        "multiplier": multiplier,
        "conclusion": conclusion,
        "hypotheses": {"poles": "counted"},
        "proof": proof,
        **more,
    }


def refuted(system, class_, proof, conclusion=NO_REST):
    return proved(system, class_, "counterexample", {}, proof, conclusion, verdict="REFUTED")


def accepted(certificate):
    """The answer for the mapping, which is that for the text."""
    answer = recheck(certificate).accepted
    assert recheck(json.dumps(certificate)).accepted is answer
    return answer


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


# --- the circle criterion ---------------------------------------------------------------------------------------------

OSCILLATOR = transfer([1], [1, 1, 1])


def circle_of_oscillator(k, ratio=F(1, 2), **more):
    # k ((1 - x) + D/k) with D = (1 - x)^2 + 4 ratio^2 x
    system = transfer([1], [1, 2 * ratio, 1])
    coefficients = [1 + k, 4 * ratio**2 - 2 - k, 1]
    return proved(system, laws(0, k, **more), "circle", {}, polynomial(coefficients))


# For ratio = 1/2 the polynomial x^2 - (k + 1) x + k + 1 has the discriminant (k + 1)(k - 3).
@pytest.mark.parametrize(
    ("k", "good"), [("299/100", True), (3 - F(1, 2**60), True), (3, False), (3 + F(1, 2**60), False)]
)
def test_the_circle_criterion_is_sharp_at_three(k, good):
    assert accepted(circle_of_oscillator(F(k))) is good
    assert accepted(circle_of_oscillator(F(k), time_varying=True)) is good


# In general -1/min Re H = 4 ratio (1 + ratio): the discriminant of the polynomial above vanishes there.
@given(
    ratio=st.fractions(min_value=F(1, 50), max_value=F(7, 10), max_denominator=60),
    j=st.integers(1, 60),
    side=st.sampled_from([-1, 1]),
)
def test_the_circle_criterion_is_sharp_for_every_damping(ratio, j, side):
    limit = 4 * ratio * (1 + ratio)
    assert accepted(circle_of_oscillator(limit * (1 + side * F(1, 2**j)), ratio)) is (side < 0)
    assert not accepted(circle_of_oscillator(limit, ratio))


# (s + 1)/(s^2 + 3 s + 3): (1 + iw)(3 - x - 3 iw) has the real part 3 + 2 x, D = x^2 + ..: w^2 Re H tends to 2.
def test_laws_without_a_bound_need_strict_positive_realness():
    lead = transfer([1, 1], [1, 3, 3])
    for upper in ("finite", "inf"):
        assert accepted(proved(lead, laws(0, upper), "circle", {}, polynomial([3, 2])))
    # (s + 1)/(s^2 + s + 1): U = 1, and w^2 Re H tends to 0
    slow = transfer([1, 1], [1, 1, 1])
    assert accepted(proved(slow, laws(0, "finite"), "circle", {}, polynomial([1])))
    assert not accepted(proved(slow, laws(0, "inf"), "circle", {}, polynomial([1])))
    # s/(s^2 + s + 1): U = x vanishes at 0: every finite bound, but not none
    wash = transfer([1, 0], [1, 1, 1])
    assert accepted(proved(wash, laws(0, "finite"), "circle", {}, polynomial([0, 1])))
    assert not accepted(proved(wash, laws(0, "inf"), "circle", {}, polynomial([0, 1])))
    # a hidden mode at -2: |d|^2 Re H = 4 + x
    hidden = transfer([1, 3, 2], [1, 3, 3, 2])
    assert accepted(proved(hidden, laws(0, "finite"), "circle", {}, polynomial([4, 1])))
    assert not accepted(proved(hidden, laws(0, "inf"), "circle", {}, polynomial([4, 1])))


# 1/(s + 1) with the mode s + h hidden; F (h^2 + x) with F = 1 + (1 + x)/k.
@pytest.mark.parametrize(("mode", "good"), [("1/1000000", True), ("0", False), ("-1/1000000", False)])
def test_a_hidden_mode_must_be_strictly_stable(mode, good):
    h = F(mode)
    certificate = proved(transfer([1, h], [1, 1 + h, h]), laws(0, 1), "circle", {}, polynomial([2, 1]))
    assert accepted(certificate) is good


# 12/((s - 1)(s + 3)) in [1, 2]: d + n = s^2 + 2 s + 9, U = 12 (9 - x), D = (9 - x)^2 + 4 x, F = 12 (9 - x) + D.
def test_an_unstable_block_is_shifted_by_the_lower_bound():
    unstable = transfer([12], [1, 2, -3])
    assert accepted(proved(unstable, laws(1, 2), "circle", {}, polynomial([189, -26, 1])))
    assert not accepted(proved(unstable, laws(0, 2), "circle", {}, polynomial([189, -26, 1])))
    assert not accepted(proved(unstable, laws("1/4", 2), "circle", {}, polynomial([189, -26, 1])))


# -1/(s + 1) in [-k, 0] is 1/(s + 1) in [0, k]: F = 1 + (1 + x)/k; for "-inf" strictly positive real.
def test_the_mirrored_circle_criterion():
    system = transfer([-1], [1, 1])
    assert accepted(proved(system, laws(-5, 0), "circle", {"mirrored": True}, polynomial([6, 1])))
    assert accepted(proved(system, laws("-inf", 0), "circle", {"mirrored": True}, polynomial([1])))
    assert not accepted(proved(system, laws("-inf", 0), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, laws("-5", "1"), "circle", {"mirrored": True}, polynomial([6, 1])))


# H = 1/s: Re H = 0 after the pole is divided out, F = 1/k; time-varying laws give boundedness alone.
def test_the_critical_case_promises_equilibria_or_boundedness():
    integrator = transfer([1], [1, 0])
    fixed, varying = laws(0, 5), laws(0, 5, time_varying=True)
    assert accepted(proved(integrator, fixed, "circle", {}, polynomial([1]), EQUILIBRIA))
    assert accepted(proved(integrator, varying, "circle", {}, polynomial([1]), BOUNDED))
    for class_, sentence in ((fixed, ATTRACTS), (fixed, BOUNDED), (varying, EQUILIBRIA), (varying, ATTRACTS)):
        assert not accepted(proved(integrator, class_, "circle", {}, polynomial([1]), sentence))
    assert not accepted(proved(transfer([-1], [1, 0]), fixed, "circle", {}, polynomial([1]), EQUILIBRIA))
    assert not accepted(proved(transfer([1, 1], [1, 0, 0]), fixed, "circle", {}, polynomial([1]), EQUILIBRIA))


# H = (1 - s)/(1 + s), D = -1: 1 + k D vanishes at k = 1; U = Re (1 - iw)^2 = 1 - x, F = 1 - x + (1 + x)/k.
@pytest.mark.parametrize(("k", "good"), [(F(99, 100), True), (F(1), False), (F(101, 100), False)])
def test_the_loop_must_be_well_posed(k, good):
    certificate = proved(transfer([-1, 1], [1, 1]), laws(0, k), "circle", {}, polynomial([1 + k, 1 - k]))
    assert accepted(certificate) is good


def test_a_sector_across_the_ill_posed_gain_is_refused_where_the_inequality_holds():
    # D = -2 and l = 1: d + n = -s - 1 + ..., H = (-2 s - 2)/(s + 1) = -2 with a hidden mode, 1 + k D < 0 throughout
    # [1, k]: one sign, and the shifted block is 2, whose F = (2 + 1/w)(1 + x)
    system = transfer([-2, -2], [1, 1])
    assert accepted(proved(system, laws(1, 3), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, laws("1/4", 3), "circle", {}, polynomial([1])))
    assert not accepted(proved(system, laws("1/2", 3), "circle", {}, polynomial([1])))


# --- Popov ------------------------------------------------------------------------------------------------------------

LAG = transfer([1], [1, 3, 2, 0])


# 1/(s (s + 1)(s + 2)): (x^2 + 5 x + 4)/k - 3 + theta (2 - x); with theta = 3/2 it is (x - 2)^2/6 at k = 6.
@pytest.mark.parametrize(
    ("k", "good"), [(F(599, 100), True), (6 - F(1, 2**60), True), (F(6), False), (F(601, 100), False)]
)
def test_popov_is_sharp_at_six(k, good):
    coefficients = [4 / k - 3 + 3, 5 / k - F(3, 2), 1 / k]
    certificate = proved(LAG, laws(0, k), "popov", {"theta": "3/2"}, polynomial(coefficients), EQUILIBRIA)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k, time_varying=True)})
    assert not accepted({**certificate, "multiplier": {"theta": "-3/2"}})
    assert not accepted({**certificate, "conclusion": ATTRACTS})


# 1/(s (s + 1)): U = -1 (x divided out), D = 1 + x, -omega Im H D = 1 there: F = (1 + x)/k - 1 + theta.
def test_popov_for_laws_without_a_bound():
    integral = transfer([1], [1, 1, 0])

    def certificate(theta, upper):
        return proved(integral, laws(0, upper), "popov", {"theta": theta}, polynomial([F(theta) - 1]), EQUILIBRIA)

    assert accepted(certificate("1", "finite"))
    assert not accepted(certificate("999/1000", "finite"))
    assert accepted(certificate("1001/1000", "inf"))
    assert not accepted(certificate("1", "inf"))


# 1/(s+1)^3: D = (1 + x)^3, U = 1 - 3 x, -w Im H D = x (3 - x); with theta = 1: (1 + x)^3/k + 1 - x^2, which at k = 8
# has the double root 3.
def test_popov_of_a_stable_block_reaches_the_linear_limit():
    system = transfer([1], [1, 3, 3, 1])
    k = F(799, 100)
    coefficients = [1 / k + 1, 3 / k, 3 / k - 1, 1 / k]
    assert accepted(proved(system, laws(0, k), "popov", {"theta": "1"}, polynomial(coefficients)))
    coefficients = [F(1, 8) + 1, F(3, 8), F(3, 8) - 1, F(1, 8)]
    assert not accepted(proved(system, laws(0, 8), "popov", {"theta": "1"}, polynomial(coefficients)))


# (s^2 - s + 10)/(s^2 + s + 25), D = 1: n conj(d) = (10 - x - iw)(25 - x - iw) = (10 - x)(25 - x) - x - iw (35 - 2 x).
def test_a_direct_term_with_a_negative_theta_needs_slope_bounds():
    system, k, theta = transfer([1, -1, 10], [1, 1, 25]), F(9, 10), F(-3, 7)
    D = [F(625), F(-49), F(1)]
    U = [F(250), F(-36), F(1)]
    coefficients = [D[0] / k + U[0], D[1] / k + U[1] + theta * 35, D[2] / k + U[2] - 2 * theta]

    def certificate(slope):
        return proved(system, laws(0, k, slope=slope), "popov", {"theta": str(theta)}, polynomial(coefficients))

    assert accepted(certificate(["0", "inf"]))
    assert accepted(certificate(["-99/100", "inf"]))  # 1 + D slope > 0
    assert not accepted(certificate(["-1", "inf"]))
    assert not accepted(certificate(None))
    # without them the file must say what it assumes
    said = {"solvable": "assumed: sigma + H(inf) phi(sigma) is increasing with a locally Lipschitz inverse"}
    assert accepted({**certificate(None), "hypotheses": said})
    assert not accepted({**certificate(None), "hypotheses": {"solvable": "checked"}})


# --- restricted slopes ------------------------------------------------------------------------------------------------

THIRD = transfer([1], [1, 3, 3, 1])


# 1/(s+1)^3: (1 + w^2)^3/k + 1 - 3 w^2 - alpha w (w^2 - 3); at k = 8, w^2 = 3 it vanishes for every alpha.
@pytest.mark.parametrize(("k", "good"), [(F(79, 10), True), (F(8), False)])
def test_off_axis_circle(k, good):
    coefficients = [1 / k + 1, F(21, 4), 3 / k - 3, F(-7, 4), 3 / k, 0, 1 / k]
    proof = polynomial(coefficients, "omega")
    certificate = proved(THIRD, laws(0, k, slope=True), "off-axis-circle", {"alpha": "7/4"}, proof)
    assert accepted(certificate) is good
    for class_ in (laws(0, k), laws(0, k, slope=["0", "8"]), laws(0, k, slope=["-1", str(k)])):
        assert not accepted({**certificate, "laws": class_})
    # the class of the slopes is what counts: a smaller sector is a smaller class, a larger one the same
    for class_ in (laws(0, 1, slope=["0", str(k)], odd=True), laws(-1, "inf", slope=["0", str(k)])):
        assert accepted({**certificate, "laws": class_}) is good


# (1 + x/10)((1 + x)^3/k + 1 - 3 x) + 13/10 x (3 - x), which has the double root 3 at k = 8.
@pytest.mark.parametrize(("k", "good"), [(F(79, 10), True), (8 - F(1, 10**6), True), (F(8), False)])
def test_park(k, good):
    first = [1 / k + 1, 3 / k - 3, 3 / k, 1 / k]
    coefficients = [a + b / 10 for a, b in zip([*first, F(0)], [F(0), *first], strict=True)]
    coefficients[1] += F(39, 10)
    coefficients[2] -= F(13, 10)
    multiplier = {"theta": "13/10", "tau": "1/10"}
    certificate = proved(THIRD, laws(0, k, slope=True), "park", multiplier, polynomial(coefficients))
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k)})
    assert not accepted({**certificate, "multiplier": {"theta": "13/10", "tau": "-1/10"}})


def kernel(coefficient, **more):
    return {"coefficient": str(coefficient), **more}


# M = 1 - (1/2)/(1 + s) on 1/(s+1)^3: twice the inequality times 1 + x is 1 + 2 x - 7 x^2 + (1 + 2 x)(1 + x)^3/k,
# positive for k = 5 (6, 15, -26, 7, 2) and negative at x = 3/2 for k = 8.
@pytest.mark.parametrize(("k", "good"), [(F(5), True), (F(8), False)])
def test_zames_falb_with_a_density(k, good):
    multiplier = {"theta": "0", "kernels": [kernel("1/2", rate="1", order=1, side="causal")]}
    coefficients = [1 + 1 / k, 2 + 5 / k, 9 / k - 7, 7 / k, 2 / k]
    certificate = proved(THIRD, laws(0, k, slope=True), "zames-falb", multiplier, polynomial(coefficients))
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k)})


# 1/(s + 1) with M = 1 + (1/2)/(1 + s), k = 1: |d|^2 (H + 1) = 2 + x - iw, times (1 + x) M = 1 + x + (1 - iw)/2:
# (2 + x)(3/2 + x) - x/2 = 3 + 3 x + x^2.
def test_negative_coefficients_need_odd_laws():
    multiplier = {"theta": "0", "kernels": [kernel("-1/2", rate="1", order=1, side="causal")]}
    system, written = transfer([1], [1, 1]), polynomial([3, 3, 1])
    assert accepted(proved(system, laws(0, 1, slope=True, odd=True), "zames-falb", multiplier, written))
    assert not accepted(proved(system, laws(0, 1, slope=True), "zames-falb", multiplier, written))


# The same block, M = 1 - c/(1 + s) for every finite k: Re[M H] (1 + x)^2 = 1 + x - c (1 - x).
@pytest.mark.parametrize(("c", "good"), [("99/100", True), ("1", False), ("101/100", False)])
def test_every_finite_slope_needs_less_than_the_whole_mass(c, good):
    multiplier = {"theta": "0", "kernels": [kernel(c, rate="1", order=1, side="causal")]}
    written = polynomial([1 - F(c), 1 + F(c)])
    certificate = proved(transfer([1], [1, 1]), laws(0, "finite", slope=True), "zames-falb", multiplier, written)
    assert accepted(certificate) is good


def cover(*ends, order=8):
    return {
        "method": "cover",
        "boxes": [[str(a), str(b)] for a, b in pairwise(ends)],
        "order": order,
    }


# 1/(s+1)^3 and M = 1 - exp(-s)/10: at k = 8, w^2 = 3, H + 1/k = 0 and the inequality vanishes; at k = 5/2 circle has
# 0.4 - 0.25 = 0.15 to spare, while the kernel takes at most |H + 1/k|/10 <= 0.14.
def test_zames_falb_with_a_delay_by_a_cover():
    multiplier = {"theta": "0", "kernels": [kernel("1/10", delay="1")]}
    certificate = proved(THIRD, laws(0, "5/2", slope=True), "zames-falb", multiplier, cover(0, 1, 3))
    assert accepted(certificate)
    assert not accepted({**certificate, "laws": laws(0, 8, slope=True)})
    for boxes in ([["0", "1"], ["2", "3"]], [["1", "3"]], [["0", "1"], ["1", "1"]], [], [["0", "1"], ["1/2", "3"]]):
        assert not accepted({**certificate, "proof": {"method": "cover", "boxes": boxes, "order": 8}})
    two = [kernel("1/2", delay="1"), kernel("501/1000", delay="-1")]
    assert not accepted({**certificate, "multiplier": {"theta": "0", "kernels": two}})


# The inequality once more in complex arithmetic: Re[M (H + 1/w) + i w theta H] |d|^2 and the denominators of M.
@given(
    omega=st.floats(0.01, 5),
    delays=st.lists(st.fractions(min_value=-3, max_value=3, max_denominator=9), max_size=3),
    rates=st.lists(st.tuples(st.integers(1, 3), st.integers(1, 3), st.sampled_from([1, -1])), max_size=3),
    theta=st.fractions(min_value=-2, max_value=2, max_denominator=9),
    dead=st.sampled_from([0, F(1, 2), 2]),
)
def test_the_inequality_is_that_of_complex_arithmetic(omega, delays, rates, theta, dead):
    n, d, ease = [F(2), F(-1), F(3)], [F(5), F(1), F(4), F(1)], F(2, 7)
    block = Shifted(
        n=((F(dead), fmpq_poly([2, -1, 3])), (F(1), fmpq_poly([1]))),
        d=fmpq_poly([5, 1, 4, 1]),
        discrete=False,
        plant=None,
        case="stable",
    )
    listed = [(F(1, 5), delay) for delay in delays] + [(F(-1, 7), (F(a), n, side)) for a, n, side in rates]
    multiplier = axis.kernels(theta, listed)
    found = axis.curve(block, multiplier, ease)
    s = 1j * omega
    top = sum(float(c) * s**i for i, c in enumerate(n)) * cmath.exp(-s * float(dead)) + cmath.exp(-s)
    bottom = sum(float(c) * s**i for i, c in enumerate(d))
    M = 1 - sum(cmath.exp(-s * float(delay)) for delay in delays) / 5
    M += sum((a / (a + side * s)) ** order for a, order, side in rates) / 7
    H = top / bottom
    below = float_at(multiplier.below, omega**2)
    expected = (M * (H + float(ease)) + s * float(theta) * H).real * abs(bottom) ** 2 * below
    value = sum(
        float_at(U, omega**2) * math.cos(tau * omega) + omega * float_at(V, omega**2) * math.sin(tau * omega)
        for tau, (U, V) in found.terms.items()
    )
    assert value == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(bottom) ** 2 * below)


def float_at(p, x):
    return sum(float(F(int(c.p), int(c.q))) * x**i for i, c in enumerate(p.coeffs()))


# exp(-s)/(s + 1): Re H = (cos w - w sin w)/(1 + w^2) is least near w = 1.4476, where it is -0.467760: k < 2.13784.
@pytest.mark.parametrize(("k", "good"), [("2137/1000", True), ("2138/1000", False)])
def test_the_circle_criterion_with_dead_time(k, good):
    system = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
    certificate = proved(system, laws(0, k, time_varying=True), "circle", {}, cover(0, 2, 5), DELAYED)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "conclusion": ATTRACTS})


# exp(-s)/(s (s + 1)) crosses at w tan w = 1, w = 0.860334, with the gain w sqrt(1 + w^2) = 1.134914: Popov reaches it.
@pytest.mark.parametrize(("k", "good"), [("1134/1000", True), ("1135/1000", False)])
def test_popov_with_dead_time_and_an_integrator(k, good):
    system = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1", "0"]}
    multiplier = {"theta": "160291/131072"}
    certificate = proved(system, laws(0, k), "popov", multiplier, cover(0, 1, 4), EQUILIBRIA)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "multiplier": {"theta": "-1"}})
    # w is not the sector's when its lower end is not 0
    assert not accepted({**certificate, "laws": laws("1/1000", k)})


# --- discrete time ----------------------------------------------------------------------------------------------------


# 1/(z - 1/2): 5/4 - c + k (c - 1/2) at c = (1 - x)/(1 + x) is (2 k + 1 + (9 - 6 k) x)/4/(1 + x): k < 3/2.
@pytest.mark.parametrize(("k", "good"), [(F(149, 100), True), (F(3, 2), False), (F(151, 100), False)])
def test_the_circle_criterion_in_discrete_time(k, good):
    system = transfer([1], [1, "-1/2"], "discrete")
    certificate = proved(system, laws(0, k, time_varying=True), "circle", {}, polynomial([2 * k + 1, 9 - 6 * k]))
    assert accepted(certificate) is good


# 1/(z - 1): Re H = -1/2: k < 2 (at k = 2 the gain puts a root at -1); F = (2/k - 1)(1 - c), 1 - c divided out.
@pytest.mark.parametrize(("k", "good"), [(F(199, 100), True), (F(2), False)])
def test_the_critical_case_in_discrete_time(k, good):
    proof = polynomial([2 / k - 1])
    certificate = proved(transfer([1], [1, -1], "discrete"), laws(0, k), "circle", {}, proof, EQUILIBRIA)
    assert accepted(certificate) is good


# 0.1 z/(z - 0.9)^2: |d|^2 = (1.81 - 1.8 c)^2, Re[n conj(d)] = 0.181 c - 0.18, Re[(1 - 1/z) n conj(d)] =
# -0.2 c^2 + 0.361 c - 0.161; the limit is 19/5 (Carrasco et al. 2019, example 1).
@pytest.mark.parametrize(("k", "good"), [(F("3.7999"), True), (F("3.8001"), False)])
def test_tsypkin(k, good):
    system, q = transfer(["1/10", 0], [1, "-9/5", "81/100"], "discrete"), F(41282051, 10**7)
    square = [F("3.2761"), F("-6.516"), F("3.24")]
    in_cosine = [a / k + b + q * c for a, b, c in zip(square, (F("-.18"), F(".181"), 0), TSYPKIN_SLOPE, strict=True)]
    proof = polynomial(in_tangent(in_cosine))
    certificate = proved(system, laws(0, k, slope=["0", "inf"]), "tsypkin", {"q": str(q)}, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k)})
    assert not accepted({**certificate, "laws": laws(0, k, slope=["-1", str(k)])})
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
    certificate = proved(system, laws(0, k, slope=["-inf", str(k)]), "jury-lee", {"q": str(q)}, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k, slope=["-inf", "1"])})
    assert not accepted({**certificate, "laws": laws(0, k)})


# Every finite k: 1 + (1/2)/(z - 1/2) = z/(z - 1/2) has Re > 0; n conj(d) = 1 - z/2, U = 1 - c/2.  D = 1 > 0, so that
# Jury and Lee's laws need a slope from 0 on; with q > 0 they cannot have every finite bound.
def test_every_finite_bound_in_discrete_time():
    system, proof = transfer([1, 0], [1, "-1/2"], "discrete"), polynomial([F(1, 2), F(3, 2)])
    both, above = laws(0, "finite", slope=True), laws(0, "finite", slope=["-inf", "finite"])
    assert accepted(proved(system, both, "jury-lee", {"q": "0"}, proof))
    assert not accepted(proved(system, above, "jury-lee", {"q": "0"}, proof))
    assert not accepted(proved(system, both, "jury-lee", {"q": "1"}, proof))
    assert accepted(proved(system, laws(0, "inf"), "circle", {}, proof))
    assert not accepted(proved(system, laws(0, "inf", slope=True), "tsypkin", {"q": "0"}, proof))


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


# The same block: a monotone law of slope 175/192 has an orbit of period 3, and no multiplier reaches it.
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
    certificate = proved(system, laws(0, k, slope=True), "zames-falb", written, proof)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k)})
    assert not accepted({**certificate, "multiplier": {"taps": [[-2, "1/10"], [1, "9/10"]]}})
    assert not accepted({**certificate, "multiplier": {"taps": [[-2, "-1/10"], [1, "4/5"]]}})


# --- constant gains ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("k", "good"), [(8 - F(1, 2**60), True), (F(8), False), (F(9), False)])
def test_every_constant_gain_below_eight(k, good):
    certificate = proved(THIRD, laws(0, k, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "laws": laws(0, k)})


# s^2/(..) of the Kalman conjecture is stable for every gain k >= 0; the integrator 1/s is not at k = 0.
def test_every_finite_constant_gain():
    kalman = transfer([1, 0, 0], [1, ".12", "2.0254", ".121308", ".98191881"])
    assert accepted(proved(kalman, laws(0, "finite", linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS))
    assert not accepted(proved(kalman, laws(-1, "finite", linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS))
    integrator = transfer([1], [1, 0])
    assert not accepted(proved(integrator, laws(0, 1, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS))
    assert accepted(proved(integrator, laws("1/9", 1, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS))


# d = z - 1/2: the root 1/2 - g is inside the circle up to g = 3/2; there it is -1.
@pytest.mark.parametrize(("k", "good"), [("149/100", True), ("3/2", False)])
def test_constant_gains_in_discrete_time(k, good):
    system = transfer([1], [1, "-1/2"], "discrete")
    assert accepted(proved(system, laws(0, k, linear=True), "hurwitz", {}, {"method": "polynomial"}, GAINS)) is good


# --- matrices ---------------------------------------------------------------------------------------------------------


def state_space(A, b, c, d=0, time="continuous"):
    rows = [[str(v) for v in row] for row in A]
    sides = {"b": [str(v) for v in b], "c": [str(v) for v in c]}
    return {"kind": "state-space", "time": time, "A": rows, **sides, "d": str(d)}


# 1/(s + 1), P = p: [[2 p, 1 - p], [., 2/w]] > 0 iff (1 - p)^2 < 4 p/w; w = 8, p = 2: 1 = 1.
def test_a_lyapunov_matrix_of_order_one():
    system = state_space([[-1]], [1], [1])
    assert accepted(proved(system, laws(0, 7), "circle", {}, matrix([[2]])))
    assert accepted(proved(system, laws(0, 7, time_varying=True), "circle", {}, matrix([[16]], exponent=3)))
    assert not accepted(proved(system, laws(0, 8), "circle", {}, matrix([[2]])))
    assert not accepted(proved(system, laws(0, 8), "circle", {}, matrix([[-1]])))
    assert not accepted(proved(system, laws(0, 7), "circle", {}, matrix([[2]]), EQUILIBRIA))


# 1/(s (s + 1)) = 1/s - 1/(s + 1), deflated A = -1, b = 1, c = -1, rho = 1, P = 1:
# [[2, theta - 2], [., 2/w]]; theta = 0: w < 1; theta = 2: every finite w.
@pytest.mark.parametrize(
    ("theta", "w", "good"), [(0, "99/100", True), (0, "1", False), (2, "1000000", True), (1, "5", False)]
)
def test_a_lyapunov_matrix_in_the_critical_case(theta, w, good):
    zero = {"right": ["1", "0"], "left": ["1", "1"], "pivot": 0}
    for system in (transfer([1], [1, 1, 0]), state_space([[0, 1], [0, -1]], [0, 1], [1, 0])):
        certificate = proved(system, laws(0, w), "popov", {"theta": str(theta)}, matrix([[1]], zero), EQUILIBRIA)
        assert accepted(certificate) is good
        for wrong in ({"right": ["1", "1"]}, {"left": ["1", "0"]}, {"pivot": 1}):
            assert not accepted({**certificate, "proof": matrix([[1]], {**zero, **wrong})})
        assert not accepted({**certificate, "proof": matrix([[1], [0, 1]])})


# 1/(z - 1/2), P = 1: [[3/4, 1/2], [., 2/w - 1]] > 0 iff w < 3/2; 1/(z - 1): 2/w - 1 > 0 iff w < 2.
def test_lyapunov_matrices_in_discrete_time():
    stable = state_space([["1/2"]], [1], [1], time="discrete")
    assert accepted(proved(stable, laws(0, "149/100"), "circle", {}, matrix([[1]])))
    assert not accepted(proved(stable, laws(0, "3/2"), "circle", {}, matrix([[1]])))
    integrator, zero = transfer([1], [1, -1], "discrete"), {"right": ["1"], "left": ["1"], "pivot": 0}
    assert accepted(proved(integrator, laws(0, "199/100"), "circle", {}, matrix([], zero), EQUILIBRIA))
    assert not accepted(proved(integrator, laws(0, 2), "circle", {}, matrix([], zero), EQUILIBRIA))


# (s + 2)/(s + 1) = 1 + 1/(s + 1) in [1, k]: shifted by 1 it is 1/2 + (1/4)/(s + 3/2); b = c = 1/2 or b = 1, c = 1/4.
def test_the_factor_of_a_direct_term_may_be_on_either_side():
    system = transfer([1, 2], [1, 1])
    for p in ("2", "4", "32"):  # p b = c up to the factor 1/p in P: p = 1 for b = c, 1/4 and 4 for the others
        assert accepted(proved(system, laws(1, 9), "circle", {}, matrix([[p]], exponent=2)))
    assert not accepted(proved(system, laws(1, 9), "circle", {}, matrix([["1000000"]])))


# n = 20 equal lags in parallel: A = -I, b = c = 1, P = I: P b = c, so that M = diag(2 .., 2/w) for every w.
def test_a_larger_lyapunov_matrix():
    n = 20
    A = [[-int(i == j) for j in range(n)] for i in range(n)]
    system, P = state_space(A, [1] * n, [1] * n), [[int(i == j) for j in range(i + 1)] for i in range(n)]
    assert accepted(proved(system, laws(0, 10**9), "circle", {}, matrix(P)))
    P[n - 1][0] = 1  # I + e_n e_1' + e_1 e_n' is singular
    assert not accepted(proved(system, laws(0, 10**9), "circle", {}, matrix(P)))


# The scheme with k = Z, E = rho = L = A = 1 and one cell: y1' = -y1, y2' = y1 - y2 + 2 mu, z' = y1 + mu, so that
# l = (1, 0, 1), rho = 1, deflated A = [[-1, 0], [1, -1]], b = (0, 2), c = (-1, 0).  With P = theta = 1 the matrix is
# [[2, -1, 0], [-1, 2, -2], [0, -2, 2/w + 2]]: its determinant 6/w - 2 is positive for w < 3.
@pytest.mark.parametrize(("w", "good"), [("299/100", True), ("3", False)])
def test_the_scheme_of_the_rod_by_a_matrix(w, good):
    scheme = {"kind": "rod-scheme", "E": "1", "rho": "1", "L": "1", "A": "1", "k": "1", "cells": 1}
    zero = {"right": ["0", "0", "1"], "left": ["1", "0", "1"], "pivot": 2}
    proof = matrix([[1], [0, 1]], zero)
    certificate = proved(scheme, laws(0, w), "popov", {"theta": "1"}, proof, EQUILIBRIA)
    assert accepted(certificate) is good
    assert not accepted({**certificate, "system": {**scheme, "E": "2"}})  # sqrt(rho E) is irrational
    assert not accepted({**certificate, "system": {**scheme, "k": "2"}})  # then l is (1, -1/3, 4/3)


# --- the rod ----------------------------------------------------------------------------------------------------------


def rod(k="1/5000", cells=10):
    """The rod of the paper: Z = 1.2 N s/m, Z^2 = 36/25."""
    found = {"kind": "rod", "E": "288000000", "rho": "8", "L": "1", "A": "1/40000", "k": k}
    return {**found, "kind": "rod-scheme", "cells": cells} if cells else found


STRUCTURE = {"method": "structure"}


# L |k^2 - Z^2|/(k A E) = (36/25 - 1/25000000)/(36/25) = 35999999/36000000 s.
@pytest.mark.parametrize(("theta", "good"), [("35999999/36000000", True), ("35999998/36000000", False)])
def test_popov_for_the_scheme(theta, good):
    certificate = proved(rod(), laws(0, "finite"), "rod-popov", {"theta": theta}, STRUCTURE, EQUILIBRIA)
    assert accepted(certificate) is good
    assert accepted({**certificate, "laws": laws(0, 1)}) is good
    assert not accepted({**certificate, "laws": laws(0, "inf")})
    assert not accepted({**certificate, "system": rod(cells=None)})
    assert not accepted({**certificate, "laws": laws(-1, 1)})
    assert accepted({**certificate, "laws": laws(0, "inf"), "multiplier": {"theta": "1"}})


# (E/L) k^2/(Z^2 - k^2) = 11.52/(36/25 - 1/25000000) = 288000000/35999999.
@pytest.mark.parametrize(("k", "good"), [(8, True), ("288000000/35999999", False), ("finite", False)])
def test_the_circle_criterion_for_the_scheme(k, good):
    certificate = proved(rod(), laws(0, k), "rod-circle", {}, STRUCTURE, EQUILIBRIA)
    assert accepted(certificate) is good
    varying = {**certificate, "laws": laws(0, k, time_varying=True)}
    assert not accepted(varying)
    assert accepted({**varying, "conclusion": BOUNDED}) is good
    matched = {**certificate, "system": rod("6/5"), "laws": laws(0, "finite")}  # k = Z reflects nothing: Re H = 0
    assert accepted(matched)


def test_the_energy_of_a_scheme_of_a_hundred_thousand_cells():
    assert recheck(proved(rod(cells=100_000), laws(0, "inf"), "rod-energy", {}, STRUCTURE, AT_REST)).accepted


@pytest.mark.parametrize("cells", [None, 1, 2, 7])
def test_the_energy_of_the_rod(cells):
    certificate = proved(rod(cells=cells), laws(0, "inf"), "rod-energy", {}, STRUCTURE, AT_REST)
    assert accepted(certificate)
    for k in ("0", "-1/5000"):
        assert not accepted({**certificate, "system": rod(k, cells=cells)})
    assert not accepted({**certificate, "laws": laws(0, "inf", time_varying=True)})
    assert not accepted({**certificate, "laws": laws("-1/10", "inf")})
    assert not accepted({**certificate, "conclusion": EQUILIBRIA})


# Z = 6/5: -Z < k < 0 grows with phi = 0; k < -Z grows with every positive gain.
def test_a_dashpot_that_drives():
    for cells in (None, 10):
        assert accepted(refuted(rod("-1/5000", cells), laws(0, 1), STRUCTURE))
        assert not accepted(refuted(rod("-1/5000", cells), laws("1/10", 1), STRUCTURE))
        assert accepted(refuted(rod("-2", cells), laws("1/10", "inf"), STRUCTURE))
        assert not accepted(refuted(rod("-2", cells), laws(-1, 0), STRUCTURE))
        for k in ("0", "-6/5", "1"):
            assert not accepted(refuted(rod(k, cells), laws(0, 1), STRUCTURE))


# --- refutations ------------------------------------------------------------------------------------------------------


# (s + 1)^3 + g has the roots +- i sqrt(3) at g = 8.
@pytest.mark.parametrize(("gain", "good"), [("8", True), ("9", True), ("7999/1000", False), ("11", False)])
def test_a_linear_gain(gain, good):
    assert accepted(refuted(THIRD, laws(0, 10), {"method": "linear-gain", "gain": gain})) is good


# s + 1 - g: a root 0 at g = 1 is a line of equilibria; two of them, s^2 for g = 1, are a ramp.
def test_a_linear_gain_with_a_root_at_zero():
    proof = {"method": "linear-gain", "gain": "1"}
    single = refuted(transfer([-1], [1, 1]), laws(0, 2), proof, OTHERS)
    assert accepted(single)
    # at the upper end it is the critical case of -H, in which convergence to the equilibria can be proved
    assert not accepted(refuted(transfer([-1], [1, 1]), laws(0, 1), proof, OTHERS))
    assert not accepted({**single, "conclusion": NO_REST})
    assert accepted(refuted(transfer([-1, -1], [1, 1, 1]), laws(0, 1), proof, NO_REST))
    # the class of an integrator has other equilibria anyway
    critical = refuted(transfer([1], [1, 0]), laws(0, 1), {"method": "linear-gain", "gain": "0"}, OTHERS)
    assert not accepted(critical)
    # of -1/s no class is a critical case: small gains are unstable
    assert accepted({**critical, "system": transfer([-1], [1, 0])})
    # two equal states at rest, x' = 0, are equilibria, not a ramp
    resting = state_space([[-1, 0], [0, -1]], [1, 0], [-1, 0])
    assert accepted(refuted(resting, laws(0, 2), proof, OTHERS))


def test_a_linear_gain_in_discrete_time():
    system = transfer([1], [1, "-1/2"], "discrete")
    assert accepted(refuted(system, laws(0, 2), {"method": "linear-gain", "gain": "3/2"}))  # root -1
    assert not accepted(refuted(system, laws(0, 2), {"method": "linear-gain", "gain": "149/100"}))
    assert accepted(refuted(system, laws(-1, 2), {"method": "linear-gain", "gain": "-1/2"}, OTHERS))  # root 1


# (s + 1)^3 + 8 at i sqrt(3) = 1.732..; exp(-s)/(s + 1): w + atan w = pi at w = 2.0288, gain sqrt(1 + w^2) = 2.2618.
def test_a_crossing():
    def proof(gains, band):
        return {"method": "crossing", "gains": list(gains), "frequencies": list(band)}

    assert accepted(refuted(THIRD, laws(0, 9), proof(("79/10", "81/10"), ("17/10", "9/5"))))
    assert not accepted(refuted(THIRD, laws(0, 9), proof(("79/10", "799/100"), ("17/10", "9/5"))))
    assert not accepted(refuted(THIRD, laws(0, 9), proof(("79/10", "81/10"), ("9/5", "2"))))
    assert not accepted(refuted(THIRD, laws(0, 8), proof(("79/10", "81/10"), ("17/10", "9/5"))))
    dead = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1"]}
    assert accepted(refuted(dead, laws(0, 3), proof(("2261/1000", "2262/1000"), ("2", "21/10"))))
    assert not accepted(refuted(dead, laws(0, 3), proof(("2262/1000", "2263/1000"), ("2", "21/10"))))


# x'' + x'/50 + (1 + g) x = 0: a stiff spring on the way in (a quarter period pi/(2 sqrt 3) = 0.907), a soft one on the
# way out (pi/2 = 1.571) makes a swing grow by sqrt(3) each time.
def test_switched_gains():
    system = transfer([1], [1, "1/50", 1])
    proof = {
        "method": "switched-gain",
        "gains": ["2", "0"],
        "times": ["907/1000", "1571/1000"],
        "squarings": 5,
        "bits": 256,
    }
    varying = laws(0, 2, time_varying=True)
    assert accepted(refuted(system, varying, proof))
    assert not accepted(refuted(system, laws(0, 2), proof))
    assert not accepted(refuted(system, laws(0, 1, time_varying=True), proof))
    assert not accepted(refuted(system, varying, {**proof, "gains": ["0", "0"]}))
    # z+ = (1/2 - g) z: -3/2 and 1/2 in turn shrink by 3/4, -3/2 and -3/2 grow
    lag = transfer([1], [1, "-1/2"], "discrete")
    pattern = {"method": "switched-gain", "gains": ["2", "0"], "squarings": 5, "bits": 256}
    assert not accepted(refuted(lag, varying, pattern))
    assert accepted(refuted(lag, varying, {**pattern, "gains": ["2", "2", "2", "0"]}))


# Period 3 of y+ = y/2 + 2 u + (23/25) u_prev with a monotone law of slope 175/192 (Carrasco et al. 2019, example 6).
ORBIT = {
    "method": "orbit",
    "points": [["-36864/72625", "-192/415"], ["0", "0"], ["192/175", "1"]],
    "left": "0",
    "right": "0",
    "u": ["192/415", "192/415", "-1"],
    "sigma": ["-36864/72625", "-74498/72625", "192/175"],
}


def test_an_orbit_in_discrete_time():
    system = transfer([2, "23/25"], [1, "-1/2", 0], "discrete")
    sigma = ORBIT["sigma"]
    found = [{**ORBIT, "sigma": list(order)} for order in (sigma, [sigma[1], sigma[0], sigma[2]])]
    slopes = laws(0, "175/192", slope=True)
    assert sorted(accepted(refuted(system, slopes, proof)) for proof in found) == [False, True]
    right = next(proof for proof in found if accepted(refuted(system, slopes, proof)))
    assert not accepted(refuted(system, laws(0, "175/192", slope=True, odd=True), right))
    assert not accepted(refuted(system, laws(0, "174/192", slope=True), right))
    assert not accepted(refuted(system, slopes, {**right, "u": ["192/415", "192/415", "-2"]}))
    assert not accepted(refuted(system, slopes, right, OTHERS))
    # hidden modes do not matter: (z - 1/2) z times z - 2
    hidden = transfer([2, "-77/25", "-46/25"], [1, "-5/2", 1, 0], "discrete")
    assert accepted(refuted(hidden, slopes, right))


# -1/2/(z - 1/2): sigma = -(1/2) u/(1/2) = -u at rest: with phi(1) = 1 the state stays; the origin does not count.
def test_a_constant_orbit_is_an_equilibrium():
    system = transfer(["-1/2"], [1, "-1/2"], "discrete")
    proof = {"method": "orbit", "points": [["1", "1"]], "left": "1", "right": "0", "u": ["-1"], "sigma": ["1"]}
    assert accepted(refuted(system, laws(0, 2), proof, OTHERS))
    assert not accepted(refuted(system, laws(0, 2), proof, NO_REST))
    assert not accepted(refuted(system, laws(0, 2), {**proof, "u": ["0"], "sigma": ["0"]}, OTHERS))


def flow_orbit():
    """x'' - x'/5 + x + phi(x') = 0 with a dead zone: Van der Pol's oscillator in pieces, from a simulation."""
    block = RationalBlock([1, 0], [1, F(-1, 5), 1])
    law = graph([["-1", "0"], ["1", "0"]], "1", "1")
    passages = Flow(PiecewiseLoop.of(companion(block), law)).passages([2.0, 0.0], 400.0)
    first, last = returns(passages)
    stays = passages[first:last]
    return {
        "method": "flow-orbit",
        "points": [["-1", "0"], ["1", "0"]],
        "left": "1",
        "right": "1",
        "pieces": [stay.piece for stay in stays],
        "durations": [str(F(stay.duration)) for stay in stays],
        "state": [str(F(value)) for value in stays[0].state],
        "half": False,
        "inverse": [["1"]],
        "radius": "1/1000000",
        "bits": 256,
    }


def test_an_orbit_in_continuous_time():
    system, proof = transfer([1, 0], [1, "-1/5", 1]), flow_orbit()
    assert accepted(refuted(system, laws(0, 1, slope=True, odd=True), proof))
    assert not accepted(refuted(system, laws(0, "1/2", slope=True), proof))
    assert not accepted(refuted(system, laws(0, 1), {**proof, "pieces": proof["pieces"][:-1]}))
    # with a damper instead nothing can go round
    damped = transfer([1, 0], [1, "1/5", 1])
    assert not accepted(refuted(damped, laws(0, 1), proof))


# --- the file ---------------------------------------------------------------------------------------------------------

GOOD = circle_of_oscillator(F(2))


def test_one_law_must_be_in_the_class():
    clipped = {"kind": "piecewise-linear", "points": [["-1", "-1"], ["1", "1"]], "left": "0", "right": "0"}
    smooth = {"kind": "tanh", "height": "4", "rate": "1/2"}
    for law in (clipped, smooth):
        assert accepted({**GOOD, "law": law})
        assert accepted({**GOOD, "law": law, "laws": laws(0, 2, slope=True, odd=True)})
    for law in (
        {**clipped, "points": [["-1", "-3"], ["1", "1"]]},  # not through the origin
        {**clipped, "left": "3"},  # leaves the sector
        {**clipped, "points": [["1", "1"], ["-1", "-1"]]},
        {**smooth, "rate": "51/100"},
        {**smooth, "height": "-4"},
        {"kind": "sine"},
    ):
        assert not accepted({**GOOD, "law": law})
    one_sided = {"kind": "piecewise-linear", "points": [["0", "0"]], "left": "0", "right": "1"}
    assert accepted({**GOOD, "law": one_sided})
    assert not accepted({**GOOD, "law": one_sided, "laws": laws(0, 2, odd=True)})
    assert not accepted({**GOOD, "law": one_sided, "laws": laws(0, 2, linear=True)})
    assert not accepted({**GOOD, "law": one_sided, "laws": laws(0, 2, slope=["1/2", "2"])})


@pytest.mark.parametrize("key", sorted(GOOD))
def test_every_key_is_needed_and_no_other_is_known(key):
    assert accepted(GOOD)
    assert not accepted({name: value for name, value in GOOD.items() if name != key})
    assert not accepted({**GOOD, key + "_": GOOD[key]})
    assert not accepted({**GOOD, key: 0.5})


@pytest.mark.parametrize(
    "change",
    [
        {"format": "lure-certificate/2"},
        {"verdict": "REFUTED"},
        {"verdict": "MAYBE"},
        {"convention": "sigma = H mu, mu = phi(sigma)"},
        {"numbers": "guesses"},
        {"theorem": "popov"},
        {"theorem": "tsypkin"},
        {"theorem": "rod-energy"},
        {"multiplier": {"theta": "0"}},
        {"conclusion": ATTRACTS + "."},
        {"hypotheses": {"poles": 3}},
        {"proof": polynomial([3, -3, 2])},
        {"proof": polynomial([3, -3, 1], "omega")},
        {"proof": {"method": "structure"}},
        {"laws": laws(0, 2.0)},
        {"laws": laws(0, "2/0")},
        {"laws": laws(0, "2e0")},
        {"laws": laws(0, "nan")},
        {"laws": laws(2, 0)},
        {"laws": laws(2, 2)},
        {"laws": laws(0, 2, odd=1)},
        {"system": transfer([-1], [1, 1, 1])},
        {"system": transfer([1, 0, 0, 1], [1, 1, 1])},
        {"system": transfer([1], [0])},
        {"system": {**OSCILLATOR, "time": "sampled"}},
        {"system": {**OSCILLATOR, "numerator": [1]}},
        {"system": rod()},
    ],
    ids=str,
)
def test_nothing_is_believed(change):
    assert accepted(GOOD)
    assert not accepted({**GOOD, **change})


def test_hostile_files_are_refused():
    text = json.dumps(GOOD)
    assert recheck(text).accepted
    assert recheck(text.encode()).accepted
    for wrong in (
        text.replace('"law": null', '"law": null, "law": null'),
        text.replace('"law": null', '"law": NaN'),
        "[" * 100_000,
        "",
        b"\xff\xfe",
        "{}",
        "null",
        text.replace('["0", "2"]', '["0", "' + "9" * 300_000 + '"]'),
    ):
        assert wrong != text
        assert not recheck(wrong).accepted


# --- one hypothesis at a time: everything else, the polynomial too, is as it should be -------------------------------


def test_hypotheses_that_nothing_else_would_catch():
    third = [F(6, 5), F(3, 5), F(-2, 5), F(1, 5)]  # (1 + x)^3/5 + 1 - x^2
    popov = proved(THIRD, laws(0, 5), "popov", {"theta": "1"}, polynomial(third))
    assert accepted(popov)
    assert not accepted({**popov, "laws": laws(0, 5, time_varying=True)})
    # Park's criterion does not cover the pole at 0, Popov's does: (1 + x)/1 - 1 + 2
    integral, two = transfer([1], [1, 1, 0]), polynomial([2, 1])
    assert accepted(proved(integral, laws(0, 1, slope=True), "popov", {"theta": "2"}, two, EQUILIBRIA))
    assert not accepted(proved(integral, laws(0, 1, slope=True), "park", {"theta": "2", "tau": "0"}, two, EQUILIBRIA))
    # (s + 1)/(s^2 + 3 s + 3) is strictly positive real, but the mode -2 is hidden: (3 + 2 x)(4 + x)
    hidden, written = transfer([1, 3, 2], [1, 5, 9, 6]), polynomial([12, 11, 2])
    assert accepted(proved(hidden, laws(0, "finite"), "circle", {}, written))
    assert not accepted(proved(hidden, laws(0, "inf"), "circle", {}, written))


# 1/(z - 1/2), k = 1: 3/4 + q (-2 c^2 + 3 c/2 + 1/2); -z/(10 (z - 1/2)), q = 0, k = 1: 1.15 - 0.95 c;
# z/(z - 1/2) without 1/k: 1 - c/2 + q (-c^2 + 3 c/2 - 1/2).
def test_hypotheses_in_discrete_time_that_nothing_else_would_catch():
    lag, monotone = transfer([1], [1, "-1/2"], "discrete"), laws(0, 1, slope=["0", "inf"])
    for q, good in ((F(1, 10), True), (F(-1, 10), False)):
        proof = polynomial(in_tangent([F(3, 4) + q / 2, q * F(3, 2), -2 * q]))
        assert accepted(proved(lag, monotone, "tsypkin", {"q": str(q)}, proof)) is good
    negative, proof = transfer(["-1/10", 0], [1, "-1/2"], "discrete"), polynomial(in_tangent([F("1.15"), F("-.95")]))
    assert accepted(proved(negative, laws(0, 1, slope=True), "tsypkin", {"q": "0"}, proof))
    assert not accepted(proved(negative, monotone, "tsypkin", {"q": "0"}, proof))
    lead, every = transfer([1, 0], [1, "-1/2"], "discrete"), laws(0, "finite", slope=True)
    proof = polynomial(in_tangent([F("0.95"), F("-0.35"), F("-0.1")]))
    assert not accepted(proved(lead, every, "jury-lee", {"q": "1/10"}, proof))


# 1/(s - 1), P = -1, w = 1/2: M = [[2, 2], [2, 4]] > 0 although nothing is stable; -1/s: corner 2/w > 0, residue -1;
# diag(1, 1/2), b = (1, 1), c = (1, 0): [[3 p/4, -p/2], [., 2/w - 1 - p]], p = 1/1024.
def test_hypotheses_of_matrices_that_nothing_else_would_catch():
    assert not accepted(proved(state_space([[1]], [1], [1]), laws(0, "1/2"), "circle", {}, matrix([[-1]])))
    zero = {"right": ["1"], "left": ["1"], "pivot": 0}
    assert accepted(proved(transfer([1], [1, 0]), laws(0, 9), "circle", {}, matrix([], zero), EQUILIBRIA))
    assert not accepted(proved(transfer([-1], [1, 0]), laws(0, 9), "circle", {}, matrix([], zero), EQUILIBRIA))
    two = state_space([[1, 0], [0, "1/2"]], [1, 1], [1, 0], time="discrete")
    both = {"right": ["1", "0"], "left": ["1", "0"], "pivot": 0}
    for w, good in (("199/100", True), ("21/10", False)):
        proof = matrix([[1]], both, exponent=10)
        assert accepted(proved(two, laws(0, w), "circle", {}, proof, EQUILIBRIA)) is good


# The block of the dead-time test in time 2 t: the same limit 1.134914, twice the theta.
@pytest.mark.parametrize(("k", "good"), [("1134/1000", True), ("1135/1000", False)])
def test_dead_time_and_an_integrator_in_another_unit_of_time(k, good):
    system = {"kind": "delay", "terms": [["2", ["1"]]], "denominator": ["4", "2", "0"]}
    certificate = proved(system, laws(0, k), "popov", {"theta": "160291/65536"}, cover(0, 1, 4), EQUILIBRIA)
    assert accepted(certificate) is good


def test_a_stable_gain_has_no_other_equilibria():
    assert not accepted(refuted(THIRD, laws(0, 10), {"method": "linear-gain", "gain": "7"}, OTHERS))

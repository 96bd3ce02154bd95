"""Lyapunov functions of degree 4 and more: the lifted system, both deciders, the criterion, and forged certificates."""

import copy
import itertools
import json
from fractions import Fraction as F

import numpy as np
import pytest
from certificate_family import OSCILLATOR, QUARTIC, accepted, certificate, changed, draft, nonlinearities
from depth import sampled
from flint import fmpq
from hypothesis import given, settings
from hypothesis import strategies as st
from tampering import assert_both_reject, refused_again

from lure import RationalPlant, Sector
from lure.analysis import max_sector
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.powers import lifted, monomials, substituted, vanishes
from lure.analysis.certificates.proposals import certified
from lure.analysis.certificates.second import powers
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.theorems import homogeneous
from lure.analysis.theorems.homogeneous import homogeneous_criterion, homogeneous_largest
from lure.analysis.theorems.table import BEST, theorems_for
from lure.analysis.verdict import Verdict
from lure.errors import AssumptionError

NAME = "homogeneous-lyapunov"
RESONANT, THIRD = RationalPlant([1], [1, F(1, 5), 1]), RationalPlant([1], [1, 3, 3, 1])


def value(proof, x):
    """``m' P m``."""
    m = [np.prod([v**n for v, n in zip(x, e, strict=True)]) for e in monomials(len(x), proof["power"])]
    rows = [[F(v) for v in row] for row in proof["P"]]
    return sum((2 - (i == j)) * v * m[i] * m[j] for i, row in enumerate(rows) for j, v in enumerate(row))


def half_turn(k, damping=0.2):
    """By how much the worst gain in ``[0, k]`` stretches a half turn of ``x1'' + damping x1' + (1 + g) x1 = 0``.

    ``x1' x1 < 0``: the largest gain gives the greatest speed at ``x1 = 0``; ``x1' x1 > 0``: gain 0 the farthest turn.
    """

    def quarter(stiffness, start):
        root = np.sqrt(complex((damping / 2) ** 2 - stiffness))
        a, b = -damping / 2 + root, -damping / 2 - root
        p = (start[1] - b * start[0]) / (a - b)
        q = start[0] - p

        def at(t):
            return (p * np.exp(a * t) + q * np.exp(b * t)).real, (p * a * np.exp(a * t) + q * b * np.exp(b * t)).real

        which = 0 if start[1] == 0 else 1  # until x1 = 0, or x1' = 0
        low, high = 0.0, np.pi / abs(root.imag) * 0.999
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if at(middle)[which] * at(0)[which] > 0 or middle == 0 else (low, middle)
        return at(low)

    _, speed = quarter(1 + k, (1.0, 0.0))
    far, _ = quarter(1.0, (0.0, speed))
    return abs(far)


# -- the lifted system ------------------------------------------------------------------------------------------------


@settings(max_examples=sampled(5, of=500))
@given(data=st.data(), n=st.integers(1, 3), p=st.integers(1, 3))
def test_the_products_of_states_change_as_their_matrix_says(data, n, p):
    entries = st.fractions(-3, 3, max_denominator=5)
    A = [[data.draw(entries) for _ in range(n)] for _ in range(n)]
    x = [data.draw(entries) for _ in range(n)]
    m, speed = monomials(n, p), [sum(a * v for a, v in zip(row, x, strict=True)) for row in A]
    # d/dt of x_i .. x_j is the part of (x_i + x_i' h) .. (x_j + x_j' h) that is linear in h
    for row, e in zip(lifted(A, m), m, strict=True):
        linear = F(0)
        for i, times in enumerate(e):
            others = [v ** (f - (h == i)) for h, (v, f) in enumerate(zip(x, e, strict=True)) if f - (h == i) >= 0]
            linear += times * speed[i] * np.prod(others, dtype=object) if times else 0
        products = [np.prod([v**f for v, f in zip(x, g, strict=True)], dtype=object) for g in m]
        assert sum(v * q for v, q in zip(row, products, strict=True)) == linear


@settings(max_examples=sampled(5, of=500))
@given(data=st.data(), n=st.integers(1, 3), p=st.integers(1, 3))
def test_the_products_of_the_next_states_are_those_of_their_matrix(data, n, p):
    entries = st.fractions(-3, 3, max_denominator=5)
    A = [[data.draw(entries) for _ in range(n)] for _ in range(n)]
    x = [data.draw(entries) for _ in range(n)]
    m, later = monomials(n, p), [sum(a * v for a, v in zip(row, x, strict=True)) for row in A]
    for row, e in zip(substituted(A, m), m, strict=True):
        seen = sum(v * np.prod([F(y) ** k for y, k in zip(x, f, strict=True)]) for v, f in zip(row, m, strict=True))
        wanted = np.prod([F(y) ** k for y, k in zip(later, e, strict=True)])
        assert seen == wanted
        of_second = powers._moved({e: fmpq(2)}, tuple(tuple(line) for line in A))
        assert of_second == {f: 2 * fmpq(v.numerator, v.denominator) for v, f in zip(row, m, strict=True) if v}


def test_the_forms_that_vanish_on_products_are_those_with_no_coefficient():
    m = monomials(2, 2)
    assert m == [(2, 0), (1, 1), (0, 2)]
    assert vanishes([[0, 0, -1], [0, 2, 0], [-1, 0, 0]], m)  # -2 x1^2 x2^2 + 2 (x1 x2)^2
    assert not vanishes([[0, 0, -1], [0, 1, 0], [-1, 0, 0]], m)
    assert not vanishes([[1, 0, 0], [0, 0, 0], [0, 0, 0]], m)


# -- certificates -----------------------------------------------------------------------------------------------------


def made(upper="7/2", system=OSCILLATOR, lower="0", varying=True, **changes):
    return draft(system, nonlinearities(lower, upper, time_varying=varying), NAME, {}, {**QUARTIC, **changes})


# -V' = m' G m with P, Z of the page docs/theory/homogeneous-lyapunov.md; at the gain 0, where x1' = x2, x2' = -x1 - x2:
# L = (0 2 0; -1 -1 1; 0 -2 -2), L'P + P L = (-12 ..) has the corner 2 (L'P)_11 = -2 P_12 = -12
def test_the_certificate_of_the_page_is_accepted_by_both_checkers():
    found = accepted(made())
    assert isinstance(found, Proved)
    assert found.certificate == certificate(NAME)
    assert recheck(found.certificate).accepted
    assert recheck(found.certificate).reason == "0 attracts every motion"
    assert accepted(made(varying=False)) is not None  # fewer nonlinearities
    assert theorems_for(RationalPlant([1], [1, 1, 1]), "sector", "homogeneous", time_varying=True)[0].name == NAME


ANY = [["99"], ["0", "99"], ["0", "0", "99"]]
FORGED = {
    "a larger class": made(upper="4"),
    "a smaller lower end": made(lower="-1"),
    "no upper end": made(upper="finite"),
    "another plant": made(system={**OSCILLATOR, "denominator": ["1", "1/2", "1"]}),
    "discrete time": made(system={**OSCILLATOR, "time": "discrete"}),
    "dead time": made(system={"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "1", "1"]}),
    "P of the circle": made(P=[["1"], ["0", "1"], ["0", "0", "1"]]),
    # x' = (1 - g) x: V = -x^4 falls, and is not positive
    "a loop that grows": draft(
        {"kind": "transfer", "time": "continuous", "numerator": ["1"], "denominator": ["1", "-1"]},
        nonlinearities("0", "1/2", time_varying=True),
        NAME,
        {},
        {"method": "powers", "power": 2, "P": [["-1"]], "lower": [["0"]], "upper": [["0"]]},
    ),
    "P with the other sign": made(P=[["-24"], ["-6", "-11"], ["-7", "-4", "-3"]]),
    "no forms that vanish": made(lower=[["0"], ["0", "0"], ["0", "0", "0"]]),
    "the forms exchanged": made(lower=QUARTIC["upper"], upper=QUARTIC["lower"]),
    # with any Z whatever G > 0 is no feat
    "a form that does not vanish": made(upper="4") | {"proof": {**QUARTIC, "upper": ANY}},
    "half a form": made() | {"proof": {**QUARTIC, "upper": [["0"], ["0", "30"], ["-14", "0", "0"]]}},
    "another degree": made(power=1),
    "a degree beyond all": made(power=10**6),
    "another theorem": made() | {"theorem": "circle"},
    "a multiplier": made() | {"multiplier": {"theta": "1"}},
    "with a matrix": made() | {"proof": {"method": "matrix", "P": [["2"], ["1", "2"]], "exponent": 0, "zero": None}},
    "with a polynomial": made() | {"proof": {"method": "polynomial"}},
    "constant gains beyond": made() | {"laws": nonlinearities("0", "9", linear=True)},
    "laws that jump": made() | {"laws": {**nonlinearities("0", "7/2", time_varying=True), "regularity": "any"}},
    "a rate": made() | {"rate": "1/10"},
    "0 as a pole": made(system={**OSCILLATOR, "denominator": ["1", "1", "0"]}),
    "fewer rows": made(P=QUARTIC["P"][:2]),
    "a fraction": made(P=[["49/2"], *QUARTIC["P"][1:]]),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_certificate_is_refused_by_both_checkers(name):
    forged = copy.deepcopy(FORGED[name])
    with pytest.raises((Rejected, ValueError)):
        completed(forged)
    whole = {**certificate(NAME), **forged}
    assert refused_again(json.dumps(whole))


# 1/(s^2 + s): V' = 0 with the gain 0 on the line of rest, so that solutions are bounded, and no more for phi(t, sigma)
CRITICAL = "homogeneous-lyapunov, critical"


@pytest.mark.parametrize(("varying", "words"), [(True, "is bounded"), (False, "converges to the set of equilibria")])
def test_with_a_pole_at_0_a_form_that_does_not_grow_bounds_the_solutions(varying, words):
    found = accepted(changed(CRITICAL, {"laws.time_varying": varying}))
    assert f"every motion {words}" == found.certificate["conclusion"]
    assert recheck(found.certificate).accepted


# P = 2 V of the family: V = z^4 + 2 z^2 w^2 - z w^3 + w^4 as (1 2 1; 2 6 7/2; 1 7/2 3)
@pytest.mark.parametrize(
    "changes",
    [
        {"proof.P": [["2"], ["3", "12"], ["2", "7", "6"]]},  # V' of order |x_1|^3 x_2 on both sides of the line
        {"proof.P": [["2"], ["4", "13"], ["2", "7", "6"]]},
        {"proof.lower": [["1"], ["0", "0"], ["0", "0", "0"]]},
        {"proof.lower": [["0"], ["0", "20"], ["-10", "0", "0"]]},  # z^4 in G: no square of it is left out
        {"laws.sector": ["0", "2"]},
        {"laws.sector": ["-1/100", "5/4"]},  # a pole to the right of 0
        {"system.denominator": ["1", "1", "0", "0"]},
        {"system.denominator": ["1", "-1", "0"]},
        {"rate": "1/10"},
    ],
)
def test_with_a_pole_at_0_neither_checker_accepts_a_form_that_grows(changes):
    assert_both_reject({**certificate(CRITICAL), **changed(CRITICAL, changes)})


# x1'' + x1' + g x1 = 0, g in [0, k]: the worst gain is k until x1 = 0, then 0 for ever, up to |x1| = |x1'|.  From rest
# at 1 the speed there is k^(1/2) exp(-t/2), tan(omega t) = -2 omega, omega^2 = k - 1/4: it is 1 for k = 3.04480
def test_two_states_with_a_pole_at_0_are_proved_close_to_the_worst_gain():
    found = max_sector(RationalPlant([1], [1, 1, 0]), time_varying=True)
    assert 2.7 < found.largest.low < 3.0447
    assert found.proof.certificate["conclusion"] == "every motion is bounded"
    assert recheck(found.proof.certificate).accepted
    proof, x, step, seen = found.proof.certificate["proof"], np.array([1.0, -0.5]), 1e-3, list[float]()
    for gain in np.random.default_rng(8).choice([0.0, found.largest.low], 200):
        seen.append(float(value(proof, x)))
        for _ in range(50):
            half = x + step / 2 * np.array([x[1], -gain * x[0] - x[1]])
            x = x + step * np.array([half[1], -gain * half[0] - half[1]])
    assert all(v <= u * (1 + 1e-12) for u, v in itertools.pairwise(seen))


# 1/(s (s + a)) is that of a = 1 in other units of time, gains times a^2; third, a pole at 0 with the gain 2 alone
@pytest.mark.parametrize(
    ("plant", "sector"),
    [
        (RationalPlant([1], [1, F(1, 1000), 0]), Sector(0, 2e-6)),
        (RationalPlant([1], [F(1, 10**9), F(1, 10**18), 0]), Sector(0, 2e-27)),
        (RationalPlant([1], [F(1, 7), F(22, 3), 0]), Sector(0, 500)),
        (RationalPlant([1], [1, 1, -2]), Sector(2, 4)),
        (RationalPlant([1], [1, 2, 1, 0]), Sector(0, F(4, 5))),  # the circle criterion ends at 1/2
        (RationalPlant([1], [1, 3, F(26, 7), F(3, 2), 0]), Sector(0, F(11, 20))),
    ],
)
def test_a_pole_at_0_in_other_units_shifted_and_of_higher_order_is_covered(plant, sector):
    answer = homogeneous_criterion(plant, sector)
    shown = certified(plant, answer).proved
    assert shown.certificate["conclusion"] == "every motion is bounded"
    assert recheck(shown.certificate).accepted
    assert "boundedness only" in answer.reason


# 1/(s^2 + a s + a^2) is that of a = 1 in other units of time, gains times a^2: the circle criterion ends at 3 a^2
@pytest.mark.parametrize("a", [F(1, 10**9), F(1), F(10**9)])
def test_a_sector_is_proved_with_the_same_degree_whatever_the_unit_of_time(a):
    answer = homogeneous_criterion(RationalPlant([1], [1, a, a * a]), Sector(0, F(7, 2) * a * a))
    assert (answer.verdict, answer.parameters["power"]) == (Verdict.PROVED, "2")


# -- discrete time ----------------------------------------------------------------------------------------------------

DISCRETE = "homogeneous-lyapunov, discrete"


def test_in_discrete_time_a_form_that_falls_at_both_ends_attracts_all():
    found = accepted(changed(DISCRETE, {}))
    assert found.certificate["conclusion"] == "0 attracts every motion"
    assert "V(x+) < V(x) for x != 0 with the gains 0, 12/25;" in found.certificate["hypotheses"]["inequality"]
    assert recheck(found.certificate).accepted


@pytest.mark.parametrize(
    "changes",
    [
        {"laws.sector": ["0", "1/2"]},  # 1/(z^2 - z + 1/2): |z| = 1 with the gain 1/2
        {"laws.sector": ["-3/5", "12/25"]},  # z = 1 with the gain -1/2
        {"laws.sector": ["0", "11/20"]},
        {"system.denominator": ["1", "-1", "1"]},
        {"system.time": "continuous"},
        {"proof.power": 1},
        {"rate": "99/100"},
    ],
)
def test_in_discrete_time_neither_checker_accepts_what_is_not_shown(changes):
    assert_both_reject({**certificate(DISCRETE), **changed(DISCRETE, changes)})


# V = 2 (x_1^2 + x_2^2)^2 + 198 x_1^2 x_2^2 falls along x+ = .9 x_1 (1 - g, g) for g = 0 and g = 1; from (1, 0) it grows
# for g = 1/2, to .45^4 (8 + 198) = 8.4: the loop decays all the same, x_1 by .9 (1 - g)
def test_in_discrete_time_a_form_need_not_fall_between_the_ends():
    states = {"A": [["9/10", "0"], ["0", "0"]], "b": ["9/10", "-9/10"], "c": ["1", "0"], "d": "0"}
    system, given = {"kind": "state-space", "time": "discrete", **states}, nonlinearities(0, 1, time_varying=True)
    zero = [["0"], ["0", "0"], ["0", "0", "0"]]
    proof = {"method": "powers", "power": 2, "P": [["2"], ["0", "200"], ["1", "0", "2"]], "lower": zero, "upper": zero}
    found = accepted(draft(system, given, NAME, {}, proof))
    assert recheck(found.certificate).accepted
    assert value(proof, [1, 0]) == 2
    assert value(proof, [F(9, 20), F(9, 20)]) == 206 * F(9, 20) ** 4


def test_in_discrete_time_the_largest_class_is_close_to_what_products_of_gains_allow():
    found = max_sector(RationalPlant([1], [1, -1, F(1, 2)], 1), time_varying=True)
    assert 0.499 < found.largest.low < 0.5  # the circle criterion ends at 5^(-1/2)
    assert recheck(found.proof.certificate).accepted
    third = homogeneous_largest(RationalPlant([1], [1, F(-3, 2), F(3, 4), F(-1, 8)], 1))  # 1/(z - 1/2)^3
    ends = [np.array([[0, 1, 0], [0, 0, 1], [0.125 - k, -0.75, 1.5]]) for k in (0, third.largest.low)]
    longest = [np.linalg.multi_dot([*pick, np.eye(3)]) for pick in itertools.product(ends, repeat=9)]
    radius = max(float(np.abs(np.linalg.eigvals(one)).max()) for one in longest) ** (1 / 9)
    assert 0.97 < radius < 1


def test_in_discrete_time_a_pole_at_1_is_not_covered():
    with pytest.raises(AssumptionError, match="does not cover a pole at z = 1"):
        homogeneous_criterion(RationalPlant([1], [1, -1, 0], 1), Sector(0, F(1, 2)))


# -- the criterion ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def resonant():
    """The answer of the criterion among those to a question, and the sentence of the question."""
    found = max_sector(RESONANT, time_varying=True)
    return next(answer for answer in found.answers if answer.criterion == NAME), str(found)


# With two states the worst gain is known, for the bound from above; the circle criterion ends at .44.
@pytest.mark.slow
def test_two_states_are_proved_up_to_the_worst_gain(resonant):
    low, high = 0.44, 2.0
    while high - low > 1e-6:
        k = (low + high) / 2
        low, high = (k, high) if half_turn(k) < 1 else (low, k)
    answer, sentence = resonant
    assert 0.985 * low < answer.largest.low < low  # .7201 of .7279
    assert answer.verdict is Verdict.PROVED
    assert f"({NAME}, certified)" in sentence


def test_both_checkers_accept_it_and_its_function_falls_along_switched_solutions(resonant):
    made, top = resonant[0].proof.certificate, resonant[0].largest.low
    assert made["laws"]["sector"] == ["0", str(F(top))]
    assert made["laws"]["time_varying"] is True
    assert recheck(made).accepted
    x, step, seen = np.array([1.0, 0.3]), 1e-3, list[float]()
    random = np.random.default_rng(7)
    for gain in random.choice([0.0, top], 200):
        seen.append(float(value(made["proof"], x)))
        for _ in range(20):
            half = x + step / 2 * np.array([x[1], -(1 + gain) * x[0] - x[1] / 5])
            x = x + step * np.array([half[1], -(1 + gain) * half[0] - half[1] / 5])
    assert all(v < u for u, v in itertools.pairwise(seen))


# 1/(s + 1)^3: the circle criterion ends at 4, a gain that switches between 0 and 5.8007 destabilises.
@pytest.mark.slow
def test_the_lowest_degree_that_serves_is_used_and_none_serves_where_gains_are_unstable():
    assert homogeneous_criterion(THIRD, Sector(0, 5)).parameters["power"] == "2"
    found = homogeneous_criterion(THIRD, Sector(0, F("5.6")))
    assert (found.verdict, found.parameters["power"]) == (Verdict.PROVED, "3")
    left = homogeneous_criterion(THIRD, Sector(0, 9))
    assert left.verdict is Verdict.INCONCLUSIVE
    assert left.reason == "no form of degree up to 12 was found; the circle criterion proves every k up to 3.999999999"


# a gain that switches destabilises from 3.91652 on; forms of degree 8 end at 3.7907
@pytest.mark.slow
def test_one_class_is_proved_by_forms_of_degree_12_within_two_percent_of_a_switched_gain():
    plant = RationalPlant([1, 2], [1, 2, 3, 1])
    found = homogeneous_criterion(plant, Sector(0, F(385, 100)))
    assert (found.verdict, found.parameters["power"]) == (Verdict.PROVED, "6")
    shown = certified(plant, found).proved
    assert recheck(shown.certificate).accepted
    first = {**shown.certificate, "laws": {**shown.certificate["laws"], "sector": ["0", "392/100"]}}
    assert refused_again(first)


@pytest.mark.slow
def test_who_asks_for_it_by_name_gets_the_highest_degree(monkeypatch):
    monkeypatch.setattr(homogeneous, "HIGHEST", {3: 3})
    monkeypatch.setattr(homogeneous, "QUICK", {3: 2})
    ends = [max_sector(THIRD, criterion=name, time_varying=True).largest.low for name in ("best", "homogeneous")]
    assert 5.3 < ends[0] < 5.36 < 5.6 < ends[1] < 5.6524  # degrees 4 and 6


# H + D has the gain g/(1 + g D) in the place of g: [0, k] of H is [0, k/(1 - k D)] of H + D.
def test_a_direct_term_and_a_shift_move_the_class():
    top = F(7, 2)
    D = F(1, 10)
    plant = RationalPlant([D, D, 1 + D], [1, 1, 1])
    shown = certified(plant, homogeneous_criterion(plant, Sector(0, top / (1 + F(1, 1000) - top * D)))).proved
    assert recheck(shown.certificate).accepted
    assert "sigma + D phi(sigma) = y" in shown.assumed
    ahead = RationalPlant([1], [1, 1, 2])  # H/(1 + H)
    assert homogeneous_criterion(ahead, Sector(-1, F(5, 2))).verdict is Verdict.PROVED
    unstable = RationalPlant([1], [1, 1, F(-1, 2)])  # stable with gains above 1/2
    assert homogeneous_criterion(unstable, Sector(F(3, 2), 5)).verdict is Verdict.PROVED
    with pytest.raises(AssumptionError, match="1 pole in the right half-plane"):
        homogeneous_criterion(unstable, Sector(0, 5))


@pytest.mark.parametrize(
    ("plant", "sector", "words"),
    [
        (RationalPlant([1], [1, 1, 0, 0]), Sector(0, 1), "has multiplicity 2"),
        (RationalPlant([1], [1, 1]), Sector(0, 1), "of order 2 to 5"),
        (RationalPlant([1], [1, 6, 15, 20, 15, 6, 1]), Sector(0, 1), "of order 2 to 5"),
        (RationalPlant([1, 0], [1, 1, 1]), Sector(0, 1), "the circle criterion proves every finite k"),
        (RationalPlant([1], [1, 1, 1]), Sector(0, float("inf")), "finite ends"),
    ],
)
def test_what_is_not_covered_is_said(plant, sector, words):
    with pytest.raises(AssumptionError, match=words):
        homogeneous_criterion(plant, sector)


@pytest.mark.slow
def test_it_is_asked_about_sectors_after_the_other_criteria():
    assert [row.name for row in theorems_for(RESONANT, "sector", BEST, time_varying=True)] == ["circle", NAME]
    assert [row.name for row in theorems_for(RESONANT, "sector", BEST)] == ["circle", "popov", NAME]
    assert NAME not in [row.name for row in theorems_for(RESONANT, "slope", BEST)]
    limited = homogeneous_largest(
        RationalPlant([1, 2], [1, 1, 1])
    )  # Re[(1 + s) H] > 0: doubled from 8.5 on, as far as it goes
    assert limited.search_limited
    assert "the largest that was tried, all linear gains are stable" in limited.reason
    closed = max_sector(RationalPlant([1], [1, 1]), time_varying=True)  # every k, by the circle criterion
    assert [answer.criterion for answer in closed.answers if answer.verdict is Verdict.PROVED] == ["circle"]

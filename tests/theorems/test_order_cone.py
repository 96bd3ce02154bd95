"""Forms of several samples: the order cones, both deciders of them, and the criterion beyond Zames-Falb multipliers."""

import json
from fractions import Fraction as F

import pytest
from depth import sampled
from flint import fmpq, fmpq_mat
from hypothesis import given, settings
from hypothesis import strategies as st
from plants import DISCRETE, ODD, SIXTH, TURNED, discrete
from tampering import refused_again

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.proposals import certified
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.order import require_positive_on_orders, strictly_copositive
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.states import copositive, order_cones, order_positive
from lure.analysis.certificates.systems import system_of
from lure.analysis.inequality.order_cones import OrderCones
from lure.analysis.inequality.unit_circle import DiscretePlant
from lure.analysis.theorems.order_cone import certificate_multiplier, order_cone_criterion, order_cone_largest
from lure.analysis.theorems.phase_limit import phase_limit
from lure.analysis.verdict import Verdict
from lure.arrays import np
from lure.classes import SlopeBounds
from lure.errors import InputError


def rows(text):
    return [line.split() for line in text.splitlines()]


def exact(text):
    return [[F(v) for v in row] for row in rows(text)]


def symmetric(lower):
    return [[lower[max(i, j)][min(i, j)] for j in range(len(lower))] for i in range(len(lower))]


def draft(plant, k, window, *, odd, taps=()):
    bounds = ["0", k]
    laws = {"sector": bounds, "slope": bounds, "odd": odd, "time_varying": False, "linear": False}
    multiplier = {"taps": list(taps), "window": window, "odd": odd}
    theorem = {"theorem": "order-cone", "multiplier": multiplier, "proof": {"method": "polynomial"}}
    return {"verdict": "PROVED", "system": system_of(plant), "laws": laws, **theorem}


def accepted(certificate):
    """Whether both checkers accept a draft; they must agree."""
    try:
        shown = completed(certificate)
    except Rejected:
        whole = {
            **certificate,
            "proof": {"method": "polynomial", "variable": "omega^2", "coefficients": [], "limits": []},
        }
        assert refused_again(json.dumps(whole))
        return False
    assert isinstance(check(json.dumps(shown)), Proved)
    assert recheck(json.dumps(shown)).accepted
    return True


# -- the cones ---------------------------------------------------------------------------------------------------------


# (p + 1)! orderings of the samples and 0, each with its reverse; p! 2^p for odd, each with its negative
@pytest.mark.parametrize(("samples", "monotone", "odd"), [(1, 1, 1), (2, 3, 4), (3, 12, 24), (4, 60, 192)])
def test_there_is_a_cone_for_each_ordering(samples, monotone, odd):
    for which, count in ((False, monotone), (True, odd)):
        found = [tuple(map(tuple, steps)) for steps in order_cones(samples, which)]
        assert len(set(found)) == len(found) == count
        assert all(fmpq_mat(list(map(list, steps))).det() != 0 for steps in found)


def graph(chance, samples, k, odd):
    """Samples of a piecewise linear ``phi`` with slopes in ``[0, k]``, as ``(phi, k sigma - phi)``."""
    knots = np.sort(chance.normal(size=9)) if not odd else np.sort(np.abs(chance.normal(size=9)))
    slopes = k * chance.choice([0.0, 1.0, chance.uniform()], size=10)
    sigma = chance.normal(size=samples)

    def integral(x):
        ends = np.concatenate([[-50.0 if not odd else 0.0], knots, [50.0]])
        return sum(s * (np.clip(x, a, b) - a) for s, a, b in zip(slopes, ends[:-1], ends[1:], strict=True))

    phi = np.sign(sigma) * integral(np.abs(sigma)) if odd else integral(sigma) - integral(np.zeros(1))
    return np.concatenate([phi, k * sigma - phi])


# The falsifier: what the deciders call positive is so on samples of nonlinearities of the class.
@pytest.mark.parametrize(("text", "odd"), [(SIXTH, False), (ODD, True)])
def test_an_accepted_form_is_nonnegative_on_samples_of_every_nonlinearity(text, odd):
    M, chance = np.array(symmetric(exact(text)), dtype=float), np.random.default_rng(7)
    for _ in range(sampled(300, of=20_000)):
        w = graph(chance, 3, chance.uniform(0.1, 3), odd)
        assert w @ M @ w >= -1e-9 * np.abs(M).max() * (w @ w)


def test_a_form_for_odd_nonlinearities_goes_red_for_one_that_is_not():
    lower = exact(ODD)
    assert order_positive(symmetric(lower), True)
    assert not order_positive(symmetric(lower), False)
    require_positive_on_orders(lower, odd=True)
    with pytest.raises(NotShown, match="not positive for an ordering"):
        require_positive_on_orders(lower, odd=False)
    least, points = OrderCones(3, odd=False).least(np.array(symmetric(lower), dtype=float))
    u, v = np.split(
        points[0], 2
    )  # samples of a nonlinearity of slope in [0, 1], sigma = u + v, at which it is negative
    assert least < -10
    assert all(
        (u[i] - u[j]) * (u[i] + v[i] - u[j] - v[j]) >= 0 <= (v[i] - v[j]) * (u[i] + v[i] - u[j] - v[j])
        for i in range(3)
        for j in range(i)
    )


# Copositivity by the equation of the least value, and by Keller's theorem, of matrices at and around the boundary.
@settings(max_examples=sampled(60, of=3000))
@given(st.lists(st.integers(-4, 4), min_size=21, max_size=21), st.integers(0, 6))
def test_the_deciders_of_copositivity_agree(entries, lift):
    lower = [[F(entries[i * (i + 1) // 2 + j] + (lift if i == j else 0)) for j in range(i + 1)] for i in range(6)]
    C = symmetric(lower)
    other = strictly_copositive(fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in C]))
    assert not copositive(C) or other  # the first may leave a singular case undecided
    if copositive(C) is not other:
        assert copositive([[v + F(i == j, 10**6) for j, v in enumerate(row)] for i, row in enumerate(C)])
    simplex = np.random.default_rng(len(entries)).dirichlet([0.5] * 6, 200)
    if other:
        assert (np.einsum("si,ij,sj->s", simplex, np.array(C, dtype=float), simplex) > 0).all()


# Horn's form is copositive, and neither nonnegative nor positive semidefinite nor a sum of such; on the boundary: it
# vanishes at (1, 1, 0, 0, 0).
def test_horns_form_lies_on_the_boundary():
    signs = {0: 1, 1: -1, 2: 1, 3: 1, 4: -1}
    for lift, expected in ((F(1, 1000), True), (F(-1, 1000), False)):
        assert copositive([[F(signs[(i - j) % 5]) + lift * (i == j) for j in range(5)] for i in range(5)]) is expected


# -- the criterion -----------------------------------------------------------------------------------------------------


# 175/192 = 0.911458... destabilises (period 3); three samples prove 0.9114, without any taps.
def test_the_sixth_example_is_proved_up_to_its_counterexample():
    assert accepted(draft(DISCRETE[6], "4557/5000", rows(SIXTH), odd=False))
    assert not accepted(draft(DISCRETE[6], "175/192", rows(SIXTH), odd=False))


# No Zames-Falb multiplier of any length proves 1.415: its dual at period 6, checked in balls.
def test_forms_of_samples_go_beyond_every_zames_falb_multiplier():
    limit = phase_limit(DiscretePlant.of(TURNED, F(0), "test"), 6, odd=True)
    assert limit.k < 1.415
    assert accepted(draft(TURNED, "143/100", rows(ODD), odd=True))
    assert not accepted(draft(TURNED, "11/7", rows(ODD), odd=True))  # where linear gains end


@pytest.mark.slow
def test_two_samples_are_searched_for_and_certified():
    found = order_cone_largest(DISCRETE[6], odd=False, window=2, taps=0)
    assert found.largest.low == pytest.approx(0.87648, abs=2e-5)  # 0.876480, the semidefinite programme in Clarabel
    shown = certified(DISCRETE[6], found)
    assert shown.upper == F(found.largest.low)
    text = json.dumps(shown.proved.certificate)
    assert isinstance(check(text), Proved)
    assert recheck(text).accepted
    # with v = k sigma - phi for a smaller k it is another matrix, and serves
    smaller = certificate_multiplier(found.parameters, F(1, 2), odd=False)
    assert smaller["window"] != certificate_multiplier(found.parameters, shown.upper, odd=False)["window"]
    assert accepted(draft(DISCRETE[6], "1/2", smaller["window"], odd=False))


@pytest.mark.thorough
def test_three_samples_are_found_for_the_sixth_example():
    found = order_cone_largest(DISCRETE[6], odd=False, window=3, taps=0)
    assert 0.9114 < found.largest.low < 175 / 192
    assert order_cone_largest(DISCRETE[1], odd=False, window=3, taps=0).largest.low == pytest.approx(1.8984, abs=1e-3)
    assert order_cone_largest(TURNED, odd=True, window=3, taps=3).largest.low > 1.4415


@pytest.mark.thorough
def test_four_samples_are_found_for_the_first_example():
    assert order_cone_largest(DISCRETE[1], odd=False, window=4, taps=0).largest.low == pytest.approx(3.674, abs=5e-3)


def test_one_class_is_decided_and_the_class_beyond_is_not():
    found = order_cone_criterion(DISCRETE[5], SlopeBounds(0, 2.4), odd=False)
    assert found.verdict is Verdict.PROVED
    assert found.margin.low > 0
    assert order_cone_criterion(DISCRETE[5], SlopeBounds(0, 2.4476), odd=False).verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("name", "value"), [("window", 0), ("window", 5), ("window", True), ("taps", -1), ("taps", 1.5)]
)
def test_numbers_out_of_range_are_refused(name, value):
    with pytest.raises(InputError, match=f"order_cone_largest: {name} is {value}; give a whole number from [01] to "):
        order_cone_largest(DISCRETE[6], odd=False, **{name: value})


# -- tampering ---------------------------------------------------------------------------------------------------------


def changed(text, row, column, value):
    found = rows(text)
    found[row][column] = value
    return found


@pytest.mark.parametrize(
    "window",
    [
        changed(SIXTH, 3, 1, "-50147/5"),  # an entry that an ordering asks to be larger
        changed(SIXTH, 0, 0, "-1"),
        [[f"-{v}".replace("--", "") for v in row] for row in rows(SIXTH)],
        rows(SIXTH)[:4],  # two samples are another form
        [],  # the circle criterion
    ],
)
def test_a_form_that_was_tampered_with_is_rejected_by_both(window):
    assert not accepted(draft(DISCRETE[6], "4557/5000", window, odd=False))


def test_what_is_proved_of_odd_nonlinearities_is_rejected_for_others():
    good = draft(TURNED, "143/100", rows(ODD), odd=True)
    for laws_odd, form_odd in ((False, True), (False, False), (True, False)):
        laws = {**good["laws"], "odd": laws_odd}
        assert not accepted({**good, "laws": laws, "multiplier": {**good["multiplier"], "odd": form_odd}})


@pytest.mark.parametrize(
    "bounds",
    [
        {"slope": None},
        {"time_varying": True},
        {"sector": ["0", "inf"], "slope": ["0", "inf"]},
        {"sector": ["0", "finite"], "slope": ["0", "finite"]},
    ],
)
def test_a_class_that_the_theorem_does_not_cover_is_rejected(bounds):
    good = draft(DISCRETE[6], "4557/5000", rows(SIXTH), odd=False)
    assert not accepted({**good, "laws": {**good["laws"], **bounds}})


# The loop shifted by 1/10: the class [1/10, 1/10 + k] of H is [0, k] of H/(1 + H/10).
def test_a_shift_of_the_class_is_a_shift_of_the_loop():
    shifted = discrete("2 0.92", "1 -0.3 0.092")
    good = draft(DISCRETE[6], "4557/5000", rows(SIXTH), odd=False)
    back = {"sector": ["-1/10", "4057/5000"], "slope": ["-1/10", "4057/5000"]}
    assert accepted({**good, "system": system_of(shifted), "laws": {**good["laws"], **back}})

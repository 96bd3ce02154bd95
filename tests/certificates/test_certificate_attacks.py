"""No certificate on the wrong side of a limit, however close, and one on the right side."""

import math
from fractions import Fraction

import numpy as np
import pytest
from certificate_family import accepted, draft, nonlinearities, refutation
from hypothesis import given
from hypothesis import strategies as st
from tampering import refused_again

from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.second import recheck
from lure.analysis.inequality.gains import hurwitz_largest
from lure.errors import AssumptionError
from lure.plants.rational import RationalPlant

F = Fraction
ratios = st.builds(F, st.integers(1, 40), st.integers(1, 20))
signed = st.builds(F, st.integers(-40, 40), st.integers(1, 20))
shares = st.builds(F, st.integers(-8, 8), st.just(32))  # of four masses: together at most 1
steps = st.integers(1, 60)


def system_of(numerator, denominator, time="continuous"):
    return {
        "kind": "transfer",
        "time": time,
        "numerator": [str(c) for c in numerator],
        "denominator": [str(c) for c in denominator],
    }


@st.composite
def third_order(draw):
    """b/((s + p)(s + q)(s + r)), r perhaps 0, with the largest stable gain (a1 a2 - a0)/b by Routh.

    Popov's criterion with theta = a2/a1 reaches it: with x = omega^2, |d|^2 + k b Re[(1 + i omega theta) conj(d)] is
    linear in k, |d|^2 at k = 0 and (x - a1)^2 (x + F(0)/a1^2) at the end.
    """
    p, q, b, r = draw(ratios), draw(ratios), draw(ratios), draw(st.just(F(0)) | ratios)
    a2, a1, a0 = p + q + r, p * q + p * r + q * r, p * q * r
    return system_of([b], [1, a2, a1, a0]), (a1 * a2 - a0) / b, a2 / a1


@st.composite
def second_order_discrete(draw):
    """b/(z^2 + a z + c) with roots inside: largest stable gain by Jury, |c + k b| < 1 and |a| < 1 + c + k b."""
    p, q = draw(st.builds(F, st.integers(-15, 15), st.just(16))), draw(st.builds(F, st.integers(-15, 15), st.just(16)))
    b, a, c = draw(signed.filter(bool)), -p - q, p * q
    return system_of([b], [1, a, c], "discrete"), (1 - c) / b if b > 0 else (1 + c - abs(a)) / -b


@st.composite
def multipliers(draw, discrete):
    """A theorem of the right time, any multiplier of its form, and what it needs of the class."""
    q, theta = draw(ratios), draw(signed)
    if discrete:
        taps = [[i, str(draw(shares))] for i in draw(st.lists(st.integers(-3, 3).filter(bool), max_size=4))]
        names = {"circle": {}, "zames-falb": {"taps": taps}}
        names |= {name: {"q": str(q)} for name in ("tsypkin", "tsypkin-odd", "jury-lee")}
    else:
        kernels = [
            {
                "coefficient": str(draw(shares)),
                "rate": str(draw(ratios)),
                "order": draw(st.integers(1, 2)),
                "side": side,
            }
            for side in draw(st.lists(st.sampled_from(["causal", "anticausal"]), max_size=2))
        ]
        names = {
            "circle": {},
            "popov": {"theta": str(theta)},
            "off-axis-circle": {"alpha": str(theta)},
            "park": {"theta": str(theta), "tau": str(q)},
            "zames-falb": {"theta": str(theta), "kernels": kernels},
        }
    name = draw(st.sampled_from(list(names)))
    return name, names[name]


def claim(system, k, theorem, multiplier, lower=0):
    """The smallest class with these bounds that the theorem is about."""
    sloped = {"circle": None, "popov": None, "hurwitz": None}.get(theorem, True)
    return draft(
        system,
        nonlinearities(lower, k, slope=sloped, odd=sloped is True, linear=theorem == "hurwitz"),
        theorem,
        multiplier,
    )


@given(plant=third_order(), j=steps, data=st.data())
def test_nothing_is_proved_at_the_last_stable_gain_or_beyond_it(plant, j, data):
    system, limit, _ = plant
    theorem, multiplier = data.draw(multipliers(discrete=False))
    for k in (limit, limit * (1 + F(1, 2**j))):
        assert accepted(claim(system, k, theorem, multiplier)) is None
        assert accepted(claim(system, k, "hurwitz", {})) is None


@given(plant=second_order_discrete(), j=steps, data=st.data())
def test_nothing_is_proved_at_the_last_stable_gain_or_beyond_it_in_discrete_time(plant, j, data):
    system, limit = plant
    theorem, multiplier = data.draw(multipliers(discrete=True))
    for k in (limit, limit * (1 + F(1, 2**j))):
        assert accepted(claim(system, k, theorem, multiplier)) is None
        assert accepted(claim(system, k, "hurwitz", {})) is None


@given(plant=third_order(), j=steps)
def test_constant_gains_and_popov_are_accepted_up_to_the_last_stable_gain(plant, j):
    system, limit, theta = plant
    k = limit * (1 - F(1, 2**j))
    found = accepted(claim(system, k, "popov", {"theta": str(theta)}))
    assert isinstance(found, Proved)
    assert recheck(found.certificate).accepted
    slopes = {"theta": str(theta), "kernels": []}
    shown = accepted(claim(system, k, "zames-falb", slopes))  # with a pole at 0 too
    assert isinstance(shown, Proved)
    assert recheck(shown.certificate).accepted
    assert isinstance(accepted(claim(system, k, "hurwitz", {}, lower=k / 2)), Proved)
    assert accepted(claim(system, limit * (1 + F(1, 2**j)), "popov", {"theta": str(theta)}, lower=k / 2)) is None


# of what is proved of constant gains nothing follows for tanh, whose slopes they are
def test_tanh_is_no_constant_gain():
    draft_of = claim(system_of([1], [1, 3, 3, 1]), F(7), "hurwitz", {})
    shown = accepted(draft_of).certificate
    assert recheck(shown).accepted
    tanh = {"kind": "tanh", "height": "1", "rate": "1"}
    assert accepted({**draft_of, "law": tanh}) is None
    assert refused_again({**shown, "law": tanh})


# (4 s + 1)/(s + 1)^4: with x = w^2 Im n d* is w x (4 x - 20), 0 at 0 too; at x = 5 Re n d* = 1 + 10 x - 15 x^2 is -324,
# and |d|^2 = 6^4: constant gains are stable below 1296/324 = 4
@pytest.mark.parametrize(("k", "fine"), [(F(399, 100), True), (F(4), False), (F(5), False)])
def test_constant_gains_where_the_phase_starts_flat(k, fine):
    found = accepted(claim(system_of([4, 1], [1, 4, 6, 4, 1]), k, "hurwitz", {}))
    assert isinstance(found, Proved) is fine
    if found is not None:
        assert recheck(found.certificate).accepted


@given(plant=third_order() | second_order_discrete(), j=steps)
def test_a_linear_gain_refutes_at_the_last_stable_gain_and_not_below(plant, j):
    system, limit = plant[:2]

    def refuted(gain):
        return accepted(
            refutation(system, nonlinearities(0, 2 * limit, linear=True), {"method": "linear-gain", "gain": str(gain)})
        )

    assert isinstance(refuted(limit), Refuted)
    assert isinstance(refuted(limit * (1 + F(1, 2**j))), Refuted)
    assert refuted(limit * (1 - F(1, 2**j))) is None
    assert refuted(limit * (2 + F(1, 2**j))) is None  # outside the class


@given(plant=third_order(), j=steps, band=st.sampled_from([F(1, 3), F(1, 2**20)]))
def test_a_crossing_is_shown_where_there_is_one_and_not_below(plant, j, band):
    # at the limit the roots are +-i sqrt(a1)
    system, limit, _ = plant
    root = F(math.sqrt(F(system["denominator"][2])))
    frequencies = [str(root * (1 - band)), str(root * (1 + band))]

    def shown(low, high):
        proof = {"method": "crossing", "frequencies": frequencies, "gains": [str(low), str(high)]}
        return accepted(refutation(system, nonlinearities(0, 2 * limit), proof))

    assert shown(limit / 2, limit * (1 - F(1, 2 ** (j + 1)))) is None
    assert shown(limit * (1 + F(1, 2**j)), limit * 2) is None
    if band < F(1, 2**10):
        found = shown(limit * F(1023, 1024), limit * F(1025, 1024))
        assert isinstance(found, Refuted)
        assert recheck(found.certificate).accepted


@given(plant=third_order() | second_order_discrete(), data=st.data())
def test_one_gain_all_the_time_refutes_nothing_where_it_is_stable(plant, data):
    system, limit = plant[:2]
    gain = limit * data.draw(st.builds(F, st.integers(1, 63), st.just(64)))
    proof = {
        "method": "switched-gain",
        "gains": [str(gain)] * 2,
        "squarings": data.draw(st.integers(0, 40)),
        "bits": 128,
    }
    if system["time"] == "continuous":
        proof["times"] = [str(data.draw(ratios)), "1"]
    found = accepted(refutation(system, nonlinearities(0, limit, time_varying=True), proof))
    # for the first powers the trace can exceed the order only if an eigenvalue of the period is outside
    assert found is None


# Re 1/(s^2 + 2 r s + 1) is least 1/(4 r (1 + r)) below 0; for b/(z - a), 0 <= a < 1, Re H is least at z = -1; and for
# b/z^n it is -b.  Each limit is rational, and the criterion fails at it.
@given(share=st.builds(F, st.integers(1, 15), st.just(16)), b=ratios, n=st.integers(1, 4), j=steps)
def test_the_circle_criterion_is_accepted_up_to_its_limit(share, b, n, j):
    ratio = share / 2
    plants = [
        (system_of([b], [1, 2 * ratio, 1]), 4 * ratio * (1 + ratio) / b),
        (system_of([b], [1, -share], "discrete"), (1 + share) / b),
        (system_of([b], [1] + [0] * n, "discrete"), 1 / b),
    ]
    for system, limit in plants:
        below, at, above = (accepted(claim(system, limit * (1 + x * F(1, 2**j)), "circle", {})) for x in (-1, 0, 1))
        assert isinstance(below, Proved)
        assert recheck(below.certificate).accepted
        assert at is above is None


@pytest.mark.parametrize(
    ("block", "limit", "theta", "reach"),
    [
        (RationalPlant([1], [1, 3, 2, 0]), 6, F(3, 2), 30),
        (RationalPlant([1], [1, 3, 3, 1]), 8, F(1), 30),
        (RationalPlant([1], [1, 1, 1]), 3, None, 40),
        (RationalPlant([1], [1, 3, 2, 0]), F(4, 3), None, 40),
        (RationalPlant([1], [1, F(-1, 2)], 1), F(3, 2), None, 40),
        (RationalPlant([1], [1, 0, 0], 1), 1, None, 25),
    ],
    ids=str,
)
def test_matrices_reach_close_to_the_limit_and_serve_nothing_beyond(block, limit, theta, reach):
    for j in (1, 5, 10, 20, reach, 45, 60):
        try:
            made = matrix_draft(block, limit * (1 - F(1, 2**j)), theta=theta)
        except AssumptionError:
            assert j > reach
            continue
        found = accepted(made)
        assert isinstance(found, Proved)
        assert recheck(found.certificate).accepted
        for beyond in (limit, limit * (1 + F(1, 2**j))):
            made["laws"]["sector"][1] = str(F(beyond))
            assert accepted(made) is None
    with pytest.raises(AssumptionError):
        matrix_draft(block, F(limit), theta=theta)


@given(
    top=st.lists(signed, min_size=1, max_size=3),
    poles=st.lists(ratios, min_size=1, max_size=2),
    pair=st.tuples(ratios, ratios),
    j=steps,
    data=st.data(),
)
def test_no_multiplier_passes_an_irrational_limit(top, poles, pair, j, data):
    denominator = np.poly([-p for p in poles]).astype(object)
    bottom = np.convolve(
        [F(c).limit_denominator(10**6) for c in denominator], [F(1), 2 * pair[0], pair[0] ** 2 + pair[1]]
    )
    if not any(top):
        return
    block = RationalPlant(top, list(bottom))
    high = hurwitz_largest(block).largest.high
    if not math.isfinite(high):
        return
    k, system = F(high) * (1 + F(1, 2**j)), system_of(top, bottom)
    theorem, multiplier = data.draw(multipliers(discrete=False))
    assert accepted(claim(system, k, theorem, multiplier)) is None
    assert accepted(claim(system, k, "hurwitz", {})) is None
    mirrored = system_of([-c for c in top], bottom)
    assert accepted(draft(mirrored, nonlinearities(-k, 1), "circle", {"mirrored": True})) is None

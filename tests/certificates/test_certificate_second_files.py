"""The second checker on files with one thing wrong: a key, a hypothesis, a phi outside its class, hostile text."""

import json
from fractions import Fraction as F

import pytest
from certificate_family import certificate
from handwritten import (
    ATTRACTS,
    EQUILIBRIA,
    THIRD,
    accepted,
    circle_of_oscillator,
    nonlinearities,
    polynomial,
    proved,
    rod,
    transfer,
)
from tampering import refused_again

from lure.analysis.certificates.second import recheck

OSCILLATOR = transfer([1], [1, 1, 1])
GOOD = circle_of_oscillator(F(2))


def test_one_law_must_be_in_the_class():
    clipped = {"kind": "piecewise-linear", "points": [["-1", "-1"], ["1", "1"]], "left": "0", "right": "0"}
    smooth = {"kind": "tanh", "height": "4", "rate": "1/2"}
    for nonlinearity in (clipped, smooth):
        assert accepted({**GOOD, "law": nonlinearity})
        assert accepted({**GOOD, "law": nonlinearity, "laws": nonlinearities(0, 2, slope=True, odd=True)})
    for nonlinearity in (
        {**clipped, "points": [["-1", "-3"], ["1", "1"]]},  # not through the origin
        {**clipped, "left": "3"},  # leaves the sector
        {**clipped, "points": [["1", "1"], ["-1", "-1"]]},
        {**smooth, "rate": "51/100"},
        {**smooth, "height": "-4"},
        {"kind": "sine"},
    ):
        assert not accepted({**GOOD, "law": nonlinearity})
    one_sided = {"kind": "piecewise-linear", "points": [["0", "0"]], "left": "0", "right": "1"}
    assert accepted({**GOOD, "law": one_sided})
    assert not accepted({**GOOD, "law": one_sided, "laws": nonlinearities(0, 2, odd=True)})
    assert not accepted({**GOOD, "law": one_sided, "laws": nonlinearities(0, 2, linear=True)})
    assert not accepted({**GOOD, "law": one_sided, "laws": nonlinearities(0, 2, slope=["1/2", "2"])})


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
        {"laws": nonlinearities(0, 2.0)},
        {"laws": nonlinearities(0, "2/0")},
        {"laws": nonlinearities(0, "2e0")},
        {"laws": nonlinearities(0, "nan")},
        {"laws": nonlinearities(2, 0)},
        {"laws": nonlinearities(2, 2)},
        {"laws": nonlinearities(0, 2, odd=1)},
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
        assert refused_again(wrong)


def test_hypotheses_that_nothing_else_would_catch():
    third = [F(6, 5), F(3, 5), F(-2, 5), F(1, 5)]  # (1 + x)^3/5 + 1 - x^2
    popov = proved(THIRD, nonlinearities(0, 5), "popov", {"theta": "1"}, polynomial(third))
    assert accepted(popov)
    assert not accepted({**popov, "laws": nonlinearities(0, 5, time_varying=True)})
    # both cover the pole at 0, the conclusion is weaker: (1 + x)/1 - 1 + 2; with alpha = 2 the phase of the pole turns,
    # omega (1 + omega^2) - omega + 2
    integral, two = transfer([1], [1, 1, 0]), polynomial([2, 1])
    for name, given in (("popov", {"theta": "2"}), ("park", {"theta": "2", "tau": "0"})):
        assert accepted(proved(integral, nonlinearities(0, 1, slope=True), name, given, two, EQUILIBRIA))
        assert not accepted(proved(integral, nonlinearities(0, 1, slope=True), name, given, two))
    turned = {"method": "polynomial", "variable": "omega", "coefficients": ["2", "0", "0", "1"], "limits": ["2", "1"]}
    for alpha, good in ((2, True), (-2, False)):
        given = {"alpha": str(alpha)}
        laws = nonlinearities(0, 1, slope=True)
        assert accepted(proved(integral, laws, "off-axis-circle", given, turned, EQUILIBRIA)) is good
    # (s + 1)/(s^2 + 3 s + 3) is strictly positive real, but the mode -2 is hidden: (3 + 2 x)(4 + x)
    hidden, written = transfer([1, 3, 2], [1, 5, 9, 6]), polynomial([12, 11, 2])
    assert accepted(proved(hidden, nonlinearities(0, "finite"), "circle", {}, written))
    assert not accepted(proved(hidden, nonlinearities(0, "inf"), "circle", {}, written))


def test_numbers_on_which_nothing_rests_are_read():
    proof = GOOD["proof"]
    first, last = proof["limits"]
    assert accepted({**GOOD, "proof": {**proof, "limits": [str(F(first) / 7), str(F(last) / 7)]}})  # F before reduction
    wrong = ([], [first], [first, last, last], [first, str(2 * F(last))], [f"-{first}", f"-{last}"], [first, "x"])
    for limits in wrong:
        assert not accepted({**GOOD, "proof": {**proof, "limits": limits}})
    assert not accepted({**GOOD, "system": {**OSCILLATOR, "numerator": []}})
    late = {"kind": "delay", "terms": [["1", []]], "denominator": ["1", "1"]}
    assert "numerator" in recheck({**GOOD, "system": late}).reason


def test_the_inverse_of_an_orbit_is_square():
    orbit = certificate("flow-orbit, half")
    for inverse in (orbit["proof"]["inverse"][1:], [row[1:] for row in orbit["proof"]["inverse"]]):
        assert "square" in recheck({**orbit, "proof": {**orbit["proof"], "inverse": inverse}}).reason


def test_a_number_that_is_no_double_is_refused_in_a_sentence():  # found by fuzzing
    late = {"kind": "delay", "terms": [["1", ["1"]]], "denominator": ["1", "9" * 1000, "1"]}
    cover = {"method": "cover", "boxes": [["0", "1"]], "order": 8}
    refusal = recheck(
        json.dumps({**GOOD, "system": late, "theorem": "popov", "multiplier": {"theta": "1/8"}, "proof": cover})
    )
    assert (refusal.accepted, refusal.reason) == (False, "a number is too large for a double")

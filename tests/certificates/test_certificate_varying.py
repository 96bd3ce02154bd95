"""Plants whose parameters change with time, at any speed or slowly: exact limits, and what no checker may accept."""

from fractions import Fraction
from functools import cache
from math import inf

import pytest
from certificate_format import FORMAT
from depth import sampled

from lure import NonlinearityClass, Sector, max_sector
from lure.analysis import decay_rate, l2_gain
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.systems import system_of
from lure.errors import InputError
from lure.files.loop import loop_to_toml
from lure.files.reading import parse_system
from lure.plants.channel_family import ChannelFamily
from tests.support.tampering import assert_both_reject, edited

KIND = NonlinearityClass(sector=Sector(0, 1), time_varying=True)
LAWS = {"slope": None, "odd": False, "time_varying": False, "linear": False}
FILE = """
[plant]
A = [[0, 1], ["-a", -1]]
B = [[0], [1]]
C = [[1, 0]]
[plant.parameters]
a = { between = [1, 2], %s }
[class]
sector = [0, 1.9]
time_varying = true
"""


def spring(*rate, dt=None):
    """``x'' + x' + a x = mu``, ``sigma = x``, ``a`` in ``[1, 2]``."""
    return ChannelFamily.of_matrices([[0, 1], ["-a", -1]], [[0], [1]], [[1, 0]], None, {"a": (1, 2, *rate)}, dt)


@pytest.fixture(scope="module")
def largest():
    return cache(lambda rate: max_sector(spring(rate), [KIND]))


# With phi = g(t) sigma and a(t) the spring is x'' + x' + q(t) x = 0, q in [1, 2 + k] whatever it does.  A quadratic
# function that falls for all such q is the circle criterion of 1/(s^2 + s + 1) with k + 1 < 3: k = 2.  For a constant
# a it is k < 1 + 2 sqrt(a) >= 3; a slow one is between.
@pytest.mark.slow
def test_one_quadratic_function_serves_up_to_the_circle_criterion_of_both(largest):
    free, middle, slow = (largest(rate).largest.low for rate in (inf, 1, Fraction(1, 100)))
    assert 2 * (1 - 2e-4) < free < 2 < middle < slow < 3
    assert slow > 2.98
    for found in map(largest, (inf, 1, Fraction(1, 100))):
        FORMAT.validate(dict(found.proof.certificate))
        assert recheck(found.proof.certificate).accepted
    assert "every a in [1, 2] that changes at any speed" in str(largest(inf))
    assert "a in [1, 2] (by at most 1/100 in a unit of time)" in largest(Fraction(1, 100)).proof.claim


def test_neither_accepts_faster_parameters_larger_classes_or_other_rates(largest):
    for rate in sampled((1,), of=(inf, 1, Fraction(1, 100))):
        proof = largest(rate).proof.certificate
        assert_both_reject(edited(proof, "laws", "channels", 0, "sector", 1, value="301/100"))
    proof = largest(1).proof.certificate
    for path, value in (
        (("system", "rates"), ["inf"]),
        (("system", "rates"), ["2"]),
        (("system", "rates"), ["-1"]),
        (("system", "rates"), ["0"]),
        (("system", "rates"), []),
        (("system", "rates"), ["1", "1"]),
        (("system", "rates"), None),
        (("system", "parameters", 0, 2), "5/2"),
        (("system", "kind"), "channel-family"),
        (("system", "time"), "discrete"),
        (("rate",), "1/1000"),
    ):
        assert_both_reject(edited(proof, *path, value=value))
    leaf = proof["proof"]["boxes"]
    halves = {"parameter": 0, "at": "3/2", "below": leaf, "above": leaf}
    assert_both_reject(edited(proof, "proof", "boxes", value=halves))


# x' = -x + mu, sigma = c x: V = p x^2 + 2 theta int phi falls for a constant c; sigma' has c' x where c changes
def test_popovs_term_needs_an_output_that_does_not_change():
    def draft(c, *rate):
        family = ChannelFamily.of_matrices([[-1]], [[1]], [[c]], None, {"c": (1, 2, *rate)})
        given = {"lambda": ["1"], "P": [[["4"]]], "theta": ["1/2"], "exponent": 0}
        proof = {"method": "boxes", "boxes": {"multiplier": given}}
        laws = {"channels": [LAWS | {"sector": ["0", "1"]}], "repeated": False}
        parts = {"verdict": "PROVED", "system": system_of(family), "laws": laws, "theorem": "diagonal-popov"}
        return parts | {"multiplier": {}, "proof": proof}

    shown = complete_and_check(draft("c")).certificate
    assert recheck(shown).accepted
    for rate in ("inf", "1/10"):
        turned = {**shown["system"], "kind": "varying-family", "rates": [rate]}
        assert_both_reject(edited(shown, "system", value=turned))


# x+ = a x - phi, a in [0, 1/2] at any speed, phi in [0, k]: a - g in [-k, 1/2], so that k < 1; P is one number
@pytest.mark.slow
def test_samples_may_jump_whatever_the_rate():
    for rate in (inf, Fraction(1, 10)):
        family = ChannelFamily.of_matrices([["a"]], [[1]], [[1]], None, {"a": (0, Fraction(1, 2), rate)}, dt=1)
        found = max_sector(family, [KIND])
        assert 1 - 2e-4 < found.largest.low < 1 <= found.refuted_at < 1 + 1e-6
        assert recheck(found.proof.certificate).accepted
        assert recheck(found.refutation.certificate).accepted
        leaf = found.proof.certificate["proof"]["boxes"]["multiplier"]
        more = {**leaf, "P": [leaf["P"][0], [["1"]]]}
        assert_both_reject(edited(found.proof.certificate, "proof", "boxes", "multiplier", value=more))


@pytest.mark.parametrize("how", ["varying = true", "rate = 0.1"])
def test_a_file_says_how_a_parameter_changes_and_reads_back(how):
    system = parse_system(FILE % how, name="own", source="here")
    assert system.block == spring(inf if "true" in how else Fraction(1, 10))
    assert parse_system(loop_to_toml(system), name="own", source="here").block == system.block


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("varying = false", "varying is false; give true"),
        ("rate = 0", "rate is 0; give a positive number"),
        ("rate = -1", "rate is -1; give a positive number"),
        ("speed = 1", "give { between"),
        ("rate = 1, varying = true", "give { between"),
    ],
)
def test_what_does_not_say_how_it_changes_is_refused(how, said):
    with pytest.raises(InputError, match=said):
        parse_system(FILE % how, name="own", source="here")


# a in [1, 2] at any speed is a gain g(t) = a - 1 in a second channel, in the sector [0, 1]: by one quadratic function,
# and one constraint on (x, g x) alone, which loses nothing, both ask for the same inequality.  A slow a gets less
# through than a quick one and more than a constant one, and is no slower to settle
@pytest.mark.slow
def test_gains_and_rates_where_a_parameter_jumps_are_those_of_a_gain_that_does(largest):
    seen = {"Bw": [[0], [1]], "Cz": [[1, 0]]}
    both = ([[0, 1], [-1, -1]], [[0, 0], [1, 1]], [[1, 0], [1, 0]], 0)
    kinds = [NonlinearityClass(sector=Sector(0, Fraction(1, 5)), time_varying=True)]
    gains = {rate: l2_gain(spring(*rate), kinds, seen) for rate in ((inf,), (1,), ())}
    rates = {rate: decay_rate(spring(*rate), kinds) for rate in ((inf,), (1,), ())}
    assert gains[inf,].gain.high == pytest.approx(l2_gain(both, [KIND, *kinds], seen).gain.high, rel=2e-3)
    assert rates[inf,].rate.low == pytest.approx(decay_rate(both, [KIND, *kinds]).rate.low, rel=1e-3)
    assert gains[inf,].gain.high > gains[1,].gain.high > gains[()].gain.high
    assert rates[inf,].rate.low < rates[1,].rate.low < rates[()].rate.low
    assert "a in [1, 2] that changes by at most 1 in a unit of time" in str(gains[1,])
    for found in (gains[inf,], gains[1,], rates[inf,], rates[1,]):
        for one in found.certificates.values():
            FORMAT.validate(dict(one))
            assert recheck(one).accepted
    gain, rate = gains[1,].certificates["high"], rates[1,].certificates["low"]
    faster = Fraction(rate["rate"]) + Fraction(1, 100)
    smaller = str(Fraction(gain["laws"]["channels"][1]["sector"][1]) * Fraction(21, 20))
    for one, path, value in (
        (gain, ("system", "rates"), ["2"]),
        (gain, ("system", "rates"), ["inf"]),
        (gain, ("system", "kind"), "channel-family"),
        (gain, ("laws", "channels", 1, "sector"), [f"-{smaller}", smaller]),
        (rate, ("system", "rates"), ["2"]),
        (rate, ("rate",), str(faster)),
    ):
        assert_both_reject(edited(one, *path, value=value))


def test_questions_that_are_about_constants_are_refused():
    with pytest.raises(InputError, match="give the plant by A, B and C"):
        parse_system(
            '[plant]\ntransfer = "1/(s+a)"\n[plant.parameters]\na = {between=[1,2], rate=1}', name="a", source="b"
        )

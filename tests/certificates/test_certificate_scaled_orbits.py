"""Solutions in samples that repeat on another scale: slower than those of constant gains, and what neither accepts."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from tampering import assert_both_reject, edited

from lure import InputError, SlopeBounds, methods
from lure.analysis import decay_rate
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.counterexamples import scaled_orbits
from lure.analysis.export.coq import coq_text


@cache
def nesterov():
    """Nesterov's method with slopes in [1, 4]: constant gains decay like 1/2 = 1 - 1/sqrt(4), some phi more slowly."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(scaled_orbits, "PERIODS", (5,))
        return decay_rate(methods.nesterov(1, 4), SlopeBounds(1, 4), worst=True)


@pytest.fixture
def certificate():
    return nesterov().refutation.certificate


@pytest.mark.slow
def test_a_nonlinearity_is_slower_than_every_constant_gain(certificate):
    found, slowest = nesterov(), decay_rate(methods.nesterov(1, 4), SlopeBounds(1, 4)).rate.low
    assert slowest == pytest.approx(0.5, abs=1e-6)
    assert 0.52 < found.rate.low < found.rate.high
    assert "a phi that is linear between 5 points and their multiples by powers of" in str(found)
    assert check(certificate).certificate == certificate
    assert recheck(certificate).accepted


def test_the_solution_is_one_of_the_method_in_floating_point(certificate):
    # x+ = (4 x - x_before)/3 - phi(sigma)/4, sigma = (4 x - x_before)/3; phi from the file, by its scale
    proof = certificate["proof"]
    scale, u, sigma = float(Fraction(proof["scale"])), *([float(Fraction(v)) for v in proof[k]] for k in ("u", "sigma"))
    size, points = abs(scale), []
    for k in range(-3, 4):
        points += [(abs(x) * size**k, -w * np.sign(x) * size**k) for x, w in zip(sigma, u, strict=True)]
    xs, ws = np.array(sorted(points)).T
    assert scale < 0, "phi is odd"
    slopes = np.diff(ws) / np.diff(xs)
    assert slopes.min() >= 1 - 1e-6
    assert slopes.max() <= 4 + 1e-6
    assert slopes.max() > 3.9, "not nearly linear"
    # two values of sigma give those that follow: sigma = y + (y - before)/3, y' = sigma - phi(sigma)/4
    before, y = None, None
    for t in range(4):
        y = sigma[t] - np.sign(sigma[t]) * np.interp(abs(sigma[t]), xs, ws) / 4
        if before is not None:
            assert sigma[t + 1] == pytest.approx(y + (y - before) / 3, rel=1e-9, abs=1e-12)
        before = y


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("rate",), "56/100"),  # faster than the solution falls
        (("rate",), "-1/2"),
        (("proof", "scale"), lambda s: str(Fraction(s) * Fraction(101, 100))),
        (("proof", "scale"), "1"),
        (("proof", "u", 0), lambda v: str(Fraction(v) + Fraction(1, 10**9))),
        (("proof", "sigma", 1), lambda v: str(Fraction(v) + Fraction(1, 10**9))),
        (("laws",), lambda one: one | {"slope": ["1", "39/10"], "sector": ["1", "39/10"]}),
        (("laws",), lambda one: one | {"slope": ["101/100", "4"], "sector": ["101/100", "4"]}),
        (("laws", "linear"), True),
        (("system", "numerator", 0), lambda v: str(Fraction(v) * 2)),
        (("proof", "u"), lambda u: ["0"] * len(u)),
    ],
)
def test_neither_checker_accepts_another_solution_or_class(certificate, path, value):
    assert_both_reject(edited(certificate, *path, value=value))


def test_without_its_rate_the_file_claims_nothing(certificate):
    assert_both_reject({key: part for key, part in certificate.items() if key != "rate"})


def test_no_file_for_coq_is_written_of_it(certificate):
    with pytest.raises(InputError, match="a refutation of a rate by orbit"):
        coq_text(nesterov().refutation)

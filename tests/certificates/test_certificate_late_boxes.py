"""Certificates about plants with parameters and a dead time: both checkers, for every dead time of an interval."""

from contextlib import nullcontext
from fractions import Fraction
from math import pi

import pytest
from certificate_format import FORMAT
from flint import fmpq_poly

from lure import max_sector
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second.cover import require_whatever_delay
from lure.analysis.certificates.second.numerics import to_fmpq
from lure.analysis.certificates.second.opinion import recheck
from lure.analysis.certificates.second.reading import NotShown
from lure.analysis.certificates.systems import system_of
from lure.plants.family import PlantFamily
from tests.support.tampering import assert_both_reject, edited

LAWS = {"sector": ["0", "3/4"], "slope": None, "odd": False, "time_varying": False, "linear": False}
REST = PlantFamily.of_formula("exp(-T*s)/s", {"T": (1, 2)})
SWING = PlantFamily.of_formula("exp(-T*s)/(s^2 + s/10 + 1)", {"T": (Fraction("1.2"), Fraction("1.95"))})


def draft(family, theorem, tree, end, **laws):
    proof = {"method": "boxes", "boxes": tree}
    laws = LAWS | {"sector": ["0", end]} | laws
    return {"verdict": "PROVED", "system": system_of(family), "laws": laws, "theorem": theorem, "proof": proof}


def cut(at, *leaves):
    """Neighbouring intervals of the first parameter."""
    below, *rest = leaves
    return {"parameter": 0, "at": at[0], "below": below, "above": cut(at[1:], *rest)} if rest else below


@pytest.fixture(scope="module")
def proof():
    return complete_and_check(draft(REST, "popov", {"multiplier": {"theta": "81/100"}}, "785/1000")).certificate


# exp(-T s)/s: x' = -k x(t - T) is stable for k T < pi/2.  Popov, with u = omega T: 1/k - T sin(u)/u + theta cos(u) has
# at u = pi/2 the value 1/k - 2 T/pi and the slope 4 T/pi^2 - theta: for T = 2 theta = 8/pi^2 = .8106 reaches pi/4.
def test_an_integrator_is_proved_up_to_the_largest_dead_time_and_no_farther(proof):
    FORMAT.validate(dict(proof))
    assert recheck(proof).accepted
    assert proof["hypotheses"]["parameters"] == "for all constant T in [1, 2]"
    assert_both_reject(edited(proof, "laws", "sector", 1, value="786/1000"))
    assert_both_reject(edited(proof, "system", "time", value="discrete"))


@pytest.mark.slow
def test_the_search_finds_both_ends():
    found = max_sector(REST)
    assert pi / 4 * (1 - 1e-6) < found.largest.low < pi / 4 <= found.refuted_at < pi / 4 * (1 + 1e-6)
    assert found.refutation.facts["parameters"] == "T = 2"
    assert recheck(found.proof.certificate).accepted
    FORMAT.validate(dict(found.refutation.certificate))
    assert recheck(found.refutation.certificate).accepted
    assert_both_reject(edited(found.refutation.certificate, "proof", "at", 0, value="1"))
    assert_both_reject(edited(found.refutation.certificate, "proof", "at", 0, value="21/10"))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("system", "delay"), ["0", "-1"]),
        (("system", "delay"), ["0", "0"]),
        (("system", "delay"), ["1", "1"]),  # 2 to 3
        (("system", "delay"), ["0", "1", "0"]),
        (("system", "delay"), ["0"]),
        (("system", "delay"), []),
        (("system", "parameters", 0, 2), "21/10"),
        (("system", "parameters", 0, 1), "-1/10"),
        (("system", "time"), "discrete"),
        (("system", "kind"), "family"),
        (("system", "kind"), "delay"),
        (("system", "terms", 0, "denominator", 1), "-1/10"),  # an unstable pole in place of that at 0
        (("system", "terms", 0, "numerator", 1), "-1"),  # a residue that is negative
        (("system", "terms", 0, "numerator", 0), "1/10"),  # a direct term
        (("proof", "boxes", "multiplier", "theta"), "-1"),
        (("proof", "boxes", "multiplier", "theta"), "0"),
        (("theorem",), "circle"),
        (("theorem",), "park"),
        (("laws", "sector", 0), "-1/10"),
        (("laws", "sector", 1), "finite"),
        (("laws", "sector", 1), "inf"),
        (("laws", "time_varying"), True),
        (("rate",), "1/100"),  # exp(-T (s - a)) is not exp(-T s)
    ],
)
def test_neither_accepts_a_change(proof, path, value):
    assert_both_reject(edited(proof, *path, value=value))


def test_neither_says_that_initial_functions_do_not_matter(proof):
    assert_both_reject(edited(proof, "conclusion", value="0 attracts every motion"), stored=True)


# Near omega = 1, |H| = 10.0125 at most, and -i exp(-i T) = -1 for T = pi/2, inside [1.2, 1.95], while at both ends Re H
# stays above -9.8: 1/k = 9.8 is enough for the ends alone.  For all T the first checker needs a third corner at 10.0125
# over 1 - x^2/2, x = .375: below 10.9.
@pytest.mark.slow
def test_what_fails_between_the_ends_of_the_dead_time_alone_is_not_overlooked():
    found = complete_and_check(draft(SWING, "circle", {"multiplier": {}}, "10/109", time_varying=True)).certificate
    assert recheck(found).accepted
    assert_both_reject(edited(found, "laws", "sector", 1, value="10/98"))
    for at in ("1.2", "1.95"):
        narrow = PlantFamily.of_formula(
            "exp(-T*s)/(s^2 + s/10 + 1)", {"T": (Fraction(at), Fraction(at) + Fraction(1, 99))}
        )
        ends = complete_and_check(draft(narrow, "circle", {"multiplier": {}}, "10/98", time_varying=True))
        assert ends.claim.startswith("0 attracts every motion with inputs")
        assert recheck(ends.certificate).accepted


# A + 2 cos(omega T), A = a + 10 (omega^2 - 1)^2: for a = 1.9 it is -0.1 at omega = 1, T = 3 pi; at T = 6.2 and 12.6,
# near 2 pi and 4 pi wherever A < 2, it is positive, and it rises from the first or falls to the last
@pytest.mark.parametrize("a", ["1.9", "2.1"])
def test_a_cosine_that_turns_more_than_once_between_the_ends_is_not_taken_for_monotone(a):
    parts = (fmpq_poly([to_fmpq(Fraction(a) + 10), -20, 10]), fmpq_poly([2]), fmpq_poly([]))
    with nullcontext() if a == "2.1" else pytest.raises(NotShown, match="between the ends of the dead time"):
        require_whatever_delay(parts, (Fraction("6.2"), Fraction("12.6")), 2, critical=False)


# k exp(-T s)/(s + 1), k, T <= 1: linear gains are stable up to sqrt(1 + omega^2) = 2.2618, omega cot(omega) = -1
def test_the_dead_time_may_begin_at_zero_and_stand_beside_others():
    family = PlantFamily.of_formula("exp(-T*s)*k/(s + 1)", {"T": (0, 1), "k": (Fraction(1, 2), 1)})
    found = complete_and_check(draft(family, "popov", cut(["1/2"], *[{"multiplier": {"theta": "1/4"}}] * 2), "2"))
    assert recheck(found.certificate).accepted
    assert_both_reject(edited(found.certificate, "laws", "sector", 1, value="2262/1000"))

"""``1 + k H(inf) > 0`` is a hypothesis of its own: with a Popov term the inequality alone does not imply it."""

from fractions import Fraction

import pytest

from lure.analysis.certificates import checker
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.theorems.kernels import Multiplier, check
from lure.analysis.theorems.park import park_criterion, park_largest
from lure.analysis.theorems.zames_falb import recheck, zames_falb_largest
from lure.classes import SlopeBounds
from lure.errors import InputError
from lure.plants.rational import RationalPlant

# H = -2 s/(s + 1), k = 1, theta = 10: Re[H + 1 + 10 i w H] = 1 + 18 w^2/(1 + w^2) >= 1, times 1 + x: 1 + 19 x.
# But H(inf) = -2: for phi = sigma/2, sigma = c x + sigma has no solution unless c x = 0.
BLOCK, THETA = RationalPlant([-2, 0], [1, 1]), Fraction(10)
CLAIM = {
    "format": checker.FORMAT,
    "verdict": "PROVED",
    "convention": checker.CONVENTION,
    "numbers": "rationals",
    "system": {"kind": "transfer", "time": "continuous", "numerator": ["-2", "0"], "denominator": ["1", "1"]},
    "laws": {"sector": ["0", "1"], "slope": ["0", "1"], "odd": False, "time_varying": False, "linear": False},
    "law": None,
    "conclusion": "",
    "hypotheses": {},
    "proof": {"method": "polynomial", "variable": "omega^2", "coefficients": ["1", "19"], "limits": ["1", "19"]},
}
THEOREMS = {
    "popov": {"theta": "10"},
    "park": {"theta": "10", "tau": "0"},
    "zames-falb": {"theta": "10", "kernels": []},
}


def test_the_inequality_alone_holds():
    assert check(TransferPolynomials.of(BLOCK), Fraction(1), Multiplier(THETA, ())).holds


def test_the_criteria_stop_at_the_gain_that_has_no_solution():
    with pytest.raises(InputError, match="not well posed"):
        park_criterion(BLOCK, SlopeBounds(0, 1), theta=THETA, tau=Fraction(0))
    for found in (park_largest(BLOCK), zames_falb_largest(BLOCK, odd=False)):
        assert found.largest.low < 0.5 <= found.largest.high
    for k, proved in (("49/100", True), ("1/2", False), ("1", False), ("inf", False)):
        assert recheck(BLOCK, {"lower": "0", "k": k, "odd": False, "theta": "10", "kernels": []}) is proved


@pytest.mark.parametrize("theorem", THEOREMS)
def test_the_checker_refuses_the_class_that_holds_it(theorem):
    claim = CLAIM | {"theorem": theorem, "multiplier": THEOREMS[theorem]}
    with pytest.raises(checker.Rejected, match="vanishes for a gain"):
        checker.check(claim, draft=True)


def test_an_assumption_that_no_member_meets_proves_nothing():
    # H(inf) = 130/69, so that sigma + H(inf) phi falls for phi = -1.3 sigma; and theta < 0 needs it to increase
    block = {"kind": "transfer", "time": "continuous", "numerator": ["-13/10", "-2/5", "37/20"]}
    block["denominator"] = ["-69/100", "1503/1000", "15123/400"]
    laws = CLAIM["laws"] | {"sector": ["-13/10", "-1299/1000"], "slope": ["-13/10", "inf"]}
    draft = {"verdict": "PROVED", "system": block, "laws": laws, "theorem": "popov", "multiplier": {"theta": "-11/5"}}
    with pytest.raises(checker.Rejected, match="does not increase"):
        complete_and_check(draft | {"proof": {"method": "polynomial"}})

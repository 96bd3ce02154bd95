"""What just suffices is accepted, with the conclusion that follows; certificates once accepted stay accepted."""

import json
import re

import pytest
from certificate_family import (
    BIPROPER,
    DISCRETE,
    DRAFTS,
    LAG_1,
    LEAD,
    LIMITER,
    LOADED,
    OSCILLATOR,
    QUARTERS,
    ROD,
    STEEP,
    certificate,
    changed,
    delayed,
    transfer,
)

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.second import recheck

ACCEPTED = [
    ("popov, dead time", {"multiplier.theta": "0", "laws.sector": ["0", "3/4"]}),
    ("circle, dead time", {"system": delayed([("0", "1/4"), ("1", "1/2")], "1 1")}),
    # |H| = 1/2 at omega^2 = 3: beyond 2 the absolute values do, beyond 3/2 they do not
    ("circle, dead time", {"laws.sector": ["0", "2"], "proof.boxes": QUARTERS}),
    ("tsypkin", {"system": LOADED, "laws.sector": ["0", "1/2"], "laws.slope": ["0", "1/2"], "multiplier.q": "1/16"}),
    ("jury-lee", {"system": LEAD, "laws.sector": ["0", "1/2"], "laws.slope": ["0", "1/2"], "multiplier.q": "1/16"}),
    ("circle, no bound", {"system": transfer("1 0", "1 1 1"), "laws.sector": ["0", "finite"]}),
    ("circle, no bound", {"system": transfer("1 0", "1 -1/2", "discrete")}),
    ("circle, no bound", {"system": BIPROPER}),
    ("popov, every finite bound", {"system": BIPROPER, "laws.sector": ["0", "inf"], "multiplier.theta": "-1/10"}),
    ("popov, every finite bound", {"system": transfer("1 1", "1 3 3"), "laws.sector": ["0", "inf"]}),
    ("hurwitz", {"system": transfer("1 0", "1 1 1"), "laws.sector": ["0", "inf"]}),
    ("hurwitz", {"system": OSCILLATOR, "laws.sector": ["0", "finite"]}),
    ("hurwitz", {"system": BIPROPER, "laws.sector": ["-1/4", "inf"]}),
    ("hurwitz", {"system": transfer("1 1", "1 1 1"), "laws.sector": ["0", "inf"]}),
    ("zames-falb", {"laws.sector": ["0", "finite"], "laws.slope": ["0", "finite"], "multiplier.theta": "2"}),
    (
        "zames-falb, odd",
        {"laws.sector": ["0", "1"], "laws.slope": ["0", "1"], "multiplier.kernels.1.coefficient": "-1/2"},
    ),
    ("park", {"multiplier.tau": "0", "multiplier.theta": "1"}),
    ("hurwitz", {"system": DISCRETE, "laws.sector": ["0", "99/100"]}),
    ("popov, tanh", {"laws.sector": ["0", "1"]}),
    ("popov", {"law": {**LIMITER, "right": "0"}, "laws.odd": True}),
    ("popov", {"law": {**LIMITER, "points": [["0", "0"]], "right": "1/2"}, "laws.slope": ["0", "1/2"]}),
    ("switched gain, discrete", {"system": STEEP, "laws.sector": ["0", "9"], "proof.gains": ["7/2"]}),
    (
        "switched gain, discrete",
        {
            "system": transfer("1", "1" + " 0" * 64, "discrete"),
            "laws.sector": ["0", "2"],
            "proof.gains": ["2"],
            "proof.squarings": 6,
        },
    ),
    ("switched gain", {"proof.bits": 4096}),
    ("circle, state space", {"system.d": "1/2"}),
    # P = 1: -(A P + P A) = 2, -P b + c = 0, 2/k = 2
    ("circle, matrix", {"system": LAG_1, "laws.sector": ["0", "1"], "proof.P": [["1"]], "proof.exponent": 0}),
    ("orbit", {"system": transfer("-2 -1", "1 0", "discrete")}),  # 1 + g H(inf) = -1 everywhere
    ("tsypkin", {"system": transfer("1 0", "1 -1/2", "discrete"), "laws.sector": ["0", "finite"]}),
    ("circle, mirrored", {"system": transfer("-1 -2", "1 1"), "laws.sector": ["-inf", "1/4"]}),
    ("zames-falb, dead time", {"multiplier.kernels.0.delay": "-1/2"}),
    ("flow-orbit", {"proof.radius": "193/100000000"}),
    ("flow-orbit, half", {"proof.radius": "480/10000000"}),
    ("flow-orbit, direct", {"proof.radius": "508/10000000"}),
    ("linear gain, dead time", {"proof.gain": "-3/2"}),
    ("linear gain", {"laws.sector": ["8", "9"], "proof.gain": "8"}),
    ("linear gain", {"laws.slope": ["17/2", "9"]}),
]
CONCLUSIONS = [
    ("linear gain", {"system": BIPROPER, "laws.sector": ["-2", "0"], "proof.gain": "-1"}, "not well posed"),
    ("linear gain", {"system": BIPROPER, "laws.sector": ["-2", "0"], "proof.gain": "-1/2"}, "equilibria other than 0"),
    ("linear gain", {"system": BIPROPER, "laws.sector": ["-2", "0"], "proof.gain": "-3/4"}, "has a motion"),
    ("linear gain, dead time", {"proof.gain": "-1"}, "equilibria other than 0"),
    ("linear gain, dead time", {"proof.gain": "-3/2"}, "has a motion"),
    ("equilibrium", {}, "equilibria other than 0"),
    ("popov, shifted, piecewise linear", {}, "0 attracts every motion"),
    ("circle, critical", {}, "every motion is bounded"),
    ("circle, critical", {"laws.time_varying": False}, "converges to the set of equilibria"),
    ("popov, dead time", {}, "inputs to the block and initial functions of finite energy"),
    ("rod-circle", {}, "every motion is bounded"),
    ("rod-circle", {"laws.time_varying": False}, "converges to the set of equilibria"),
    ("rod-popov", {"system": ROD}, "of finite energy comes to rest, its end at a zero of the law"),
    ("rod-circle", {"system": ROD}, "of finite energy comes to rest, and the pressure of every contact is square"),
    ("rod-circle", {"system": ROD, "laws.time_varying": False}, "comes to rest, its end at a zero of the law"),
]


def assert_confirmed(found):
    """The second checker agrees."""
    opinion = recheck(found.certificate)
    assert opinion.accepted, opinion.reason


@pytest.mark.parametrize(("name", "changes"), ACCEPTED)
def test_what_has_every_hypothesis_is_accepted(name, changes):
    assert_confirmed(complete_and_check(changed(name, changes)))


@pytest.mark.parametrize(("name", "changes", "conclusion"), CONCLUSIONS)
def test_the_conclusion_is_the_one_that_follows(name, changes, conclusion):
    found = complete_and_check(changed(name, changes))
    assert conclusion in found.certificate["conclusion"]
    assert_confirmed(found)


@pytest.mark.parametrize(
    ("k", "words"), [("999999/999998", "up to 999999/999998$"), ("1000001/1000000", "about 1.000001")]
)
def test_long_bounds_are_also_said_in_decimals(k, words):
    found = complete_and_check(changed("popov", {"laws.sector": ["0", k]}))
    assert re.search(words, found.facts["class"])


@pytest.mark.parametrize("name", DRAFTS)
def test_a_certificate_once_accepted_is_accepted(name):
    found = check(json.dumps(certificate(name)))
    assert found.certificate == certificate(name)
    assert type(found).__name__.upper() == certificate(name)["verdict"]
    assert found.claim.startswith(certificate(name)["conclusion"])


@pytest.mark.parametrize("name", DRAFTS)
def test_what_the_checker_makes_of_a_draft_is_accepted(name):
    found = complete_and_check(DRAFTS[name]())
    if certificate(name)["proof"]["method"] not in ("matrix", "flow-orbit"):  # those are found in floating point
        assert found.certificate == certificate(name)


@pytest.mark.parametrize("slope", [["3/2", "2"], ["-2", "-1"]])
def test_a_class_without_a_law_is_refused(slope):
    with pytest.raises((Rejected, Malformed), match="no nonlinearity has both"):
        complete_and_check(changed("popov", {"laws.sector": ["0", "1"], "laws.slope": slope}))


def test_a_class_is_said_in_words():
    found = complete_and_check(changed("popov", {"laws.slope": ["-inf", "finite"]})).facts["class"]
    assert found.endswith("phi(sigma)/sigma from 0 up to 59/10, slope from -inf up to any finite bound")

"""What the tests of certificates share: a certificate close to the reach of a criterion, and one beyond it."""

import copy
import json
import math
from fractions import Fraction

import pytest

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.proposals import certified
from lure.analysis.verdict import Verdict

CLOSE, ZAMES_FALB = Fraction(1, 10**6), Fraction(1, 10**3)


def raised(certificate, factor):
    """The same certificate for a class that is larger by a factor."""
    larger = {
        key: value for key, value in copy.deepcopy(certificate).items() if key not in ("hypotheses", "conclusion")
    }
    if larger["proof"]["method"] == "polynomial":
        larger["proof"] = {"method": "polynomial"}
    nonlinearities = larger["laws"]
    low = Fraction(nonlinearities["sector"][0])
    high = str(low + (Fraction(nonlinearities["sector"][1]) - low) * factor)
    nonlinearities["sector"][1] = high
    if nonlinearities["slope"] is not None and nonlinearities["slope"][1] != "inf":
        nonlinearities["slope"][1] = high
    return larger


def assert_sharp(block, answer, within=CLOSE):
    """A certificate close to the reach of the criterion, accepted as text, and rejected a millionth beyond it."""
    assert answer.verdict is Verdict.PROVED
    found = certified(block, answer)
    lower = Fraction(answer.nonlinearity_class.sector.lower)
    reach = Fraction(answer.largest.low) - lower
    assert reach * (1 - within) <= found.upper - lower <= reach
    assert isinstance(check(json.dumps(found.proved.certificate)), Proved)
    if math.isfinite(answer.largest.high):  # no multiplier reaches it
        beyond = (Fraction(answer.largest.high) - lower) / (found.upper - lower) * (1 + CLOSE)
        with pytest.raises(Rejected):
            check(completed(raised(found.proved.certificate, beyond)))
    return found

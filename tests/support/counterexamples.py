"""What the tests of refuting certificates share: published counterexamples, drafts, and one entry changed."""

from fractions import Fraction as F

import pytest

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.drafts import completed

BIT = F(1, 2**200)


def checked(draft):
    return check(completed(draft))


def rejected(draft):
    with pytest.raises(Rejected) as reason:
        checked(draft)
    return str(reason.value)

"""What tests of tampering share: a certificate with a change, which neither checker may accept."""

import json
from unittest.mock import patch

import pytest
from depth import thorough

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.checker import check
from lure.analysis.certificates.second import question
from lure.analysis.certificates.second.opinion import recheck

FOLLOWS = "what follows is"  # the beginning of what the second checker says where the sentence alone is another


def edited(certificate, *path, value):
    """A copy of a certificate with one part set to a value, or to what a function makes of it."""
    found = part = json.loads(json.dumps(dict(certificate)))
    *inner, last = path
    for key in inner:
        part = part[key]
    part[last] = value(part[last]) if callable(value) else value
    return found


def changed(certificate, *path_and_value):
    """As :func:`edited`; the value stands after the path."""
    *path, value = path_and_value
    return edited(certificate, *path, value=value)


def assert_both_reject(certificate, *, stored=False):
    """Neither checker accepts it: the first not even as a draft, whose stored findings do not count.

    What is refused as a draft is refused as it stands: the checker goes the same way to the findings, which it then
    compares.  The second does not even with the sentence and the polynomial that follow, which after a change may be
    others.  With ``stored`` the change is in these findings, so that a draft would be right.
    """
    assert "format" in certificate, "what is no certificate yet is refused for the keys that it lacks"
    text = json.dumps(certificate)
    with pytest.raises((Rejected, Malformed)):
        check(text, draft=not stored)
    if stored:
        assert not recheck(text).accepted
    else:
        if thorough():
            with pytest.raises((Rejected, Malformed)):
                check(text)
        assert refused_again(text)


def refused_again(certificate):
    """Whether the second checker refuses a certificate whatever sentence and polynomial it shows."""
    with patch.object(question, "require_same"):  # on which nothing rests
        refusal = recheck(certificate)
    return not refusal.accepted and not refusal.reason.startswith(FOLLOWS)

"""lure.analysis.verdict: verdicts without a truth value, evidence in order, brackets that hold their number."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lure.analysis.verdict import INFINITE, Bracket, Evidence, Verdict

numbers = st.floats(allow_nan=False)


@pytest.mark.parametrize("verdict", list(Verdict))
def test_a_verdict_has_no_truth_value(verdict):
    with pytest.raises(
        TypeError, match=rf"^a verdict has three values; compare it, as in `verdict is Verdict\.{verdict}`$"
    ):
        bool(verdict)
    with pytest.raises(TypeError):
        not verdict  # noqa: B018  the operator is what is tested


def test_there_are_three_verdicts_that_print_as_their_names():
    assert [str(verdict) for verdict in Verdict] == ["PROVED", "REFUTED", "INCONCLUSIVE"]


def test_evidence_is_ordered_from_observed_to_certified():
    order = [Evidence.OBSERVED, Evidence.COMPUTED, Evidence.CERTIFIED]
    assert sorted(reversed(order)) == order
    for weaker, stronger in pairwise(order):
        assert weaker < stronger
        assert stronger > weaker
        assert weaker <= stronger
        assert not weaker >= stronger
    assert max(order) is Evidence.CERTIFIED
    assert [str(evidence) for evidence in order] == ["observed", "computed", "certified"]


def test_evidence_does_not_compare_with_anything_else():
    with pytest.raises(TypeError):
        assert Evidence.OBSERVED < 1


@given(a=numbers, b=numbers)
def test_the_middle_of_a_bracket_lies_in_it(a, b):
    bracket = Bracket(min(a, b), max(a, b))
    if not math.isinf(bracket.low) and not math.isinf(bracket.high):
        assert bracket.low <= bracket.middle <= bracket.high
        assert bracket.width >= 0


def test_an_infinite_bracket_is_a_number_too():
    assert (INFINITE.middle, INFINITE.width, str(INFINITE)) == (math.inf, 0.0, "inf")
    assert Bracket(1.0, math.inf).middle == math.inf


@pytest.mark.parametrize(("low", "high"), [(1.0, 0.0), (math.nan, 1.0), (0.0, math.nan), (math.inf, -math.inf)])
def test_a_bracket_that_contains_nothing_is_refused(low, high):
    with pytest.raises(ValueError, match=rf"^Bracket needs low <= high; got {low}, {high}$"):
        Bracket(low, high)


def test_a_bracket_prints_both_ends_unless_they_are_one():
    assert str(Bracket(0.5, 0.5)) == "0.5"
    assert str(Bracket(-1.0, 2.0)) == "-1 .. 2"

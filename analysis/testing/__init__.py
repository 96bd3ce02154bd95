"""Assertions that guard the sector or the slope of a nonlinearity, and Hypothesis strategies for laws and blocks.

The assertions need neither pytest nor Hypothesis; :mod:`analysis.testing.strategies` needs Hypothesis.  Nothing is
loaded until it is used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from analysis.handing_out import handing_out

if TYPE_CHECKING:
    from analysis.testing.assertions import assert_in_sector as assert_in_sector
    from analysis.testing.assertions import assert_monotone as assert_monotone
    from analysis.testing.assertions import assert_odd as assert_odd
    from analysis.testing.assertions import assert_slope_restricted as assert_slope_restricted
    from analysis.testing.result import Checked as Checked
    from analysis.testing.result import LawViolation as LawViolation
    from analysis.testing.result import Violation as Violation

_HOMES = {
    "Checked": "result",
    "LawViolation": "result",
    "Violation": "result",
    "assert_in_sector": "assertions",
    "assert_monotone": "assertions",
    "assert_odd": "assertions",
    "assert_slope_restricted": "assertions",
}

__getattr__, __dir__ = handing_out(__name__, _HOMES)  # loaded when they are used

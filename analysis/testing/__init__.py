"""Assertions that guard the sector or the slope of a nonlinearity, and Hypothesis strategies for laws and blocks.

The assertions need neither pytest nor Hypothesis; :mod:`analysis.testing.strategies` needs Hypothesis.  Nothing is
loaded until it is used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

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


def __getattr__(name: str) -> object:
    """The assertions and their results, loaded when they are used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'analysis.testing' has no attribute {name!r}")
    return getattr(import_module(f"analysis.testing.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})

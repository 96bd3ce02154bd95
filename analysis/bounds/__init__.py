"""Sector and slope bounds of laws, from both sides, and points that violate a bound."""

from analysis.bounds.law import law_bounds as law_bounds
from analysis.bounds.result import Extreme as Extreme
from analysis.bounds.result import LawBounds as LawBounds
from analysis.bounds.violating import Violation as Violation
from analysis.bounds.violating import violation as violation

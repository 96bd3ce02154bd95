"""Popov's criterion."""

from __future__ import annotations

from analysis.criteria.rod_popov import rod_circle_criterion as circle_criterion
from analysis.criteria.rod_popov import rod_popov_criterion as popov_criterion

__all__ = ["circle_criterion", "popov_criterion"]

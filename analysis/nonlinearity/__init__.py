"""Sector and slope bounds of nonlinearities, from both sides, and points that violate a bound."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

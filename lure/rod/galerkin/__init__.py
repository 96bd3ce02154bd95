"""The weak form of the rod in finite-dimensional spaces, section 3 of the paper: matrices, motion, energy, errors."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

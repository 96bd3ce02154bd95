"""Figures of the rod: its spectrum, its motions, comparisons, responses and those of the paper."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

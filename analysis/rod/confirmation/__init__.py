"""Confirmation: the exact motions of the rod and of its scheme, held side by side against what was shown of each."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

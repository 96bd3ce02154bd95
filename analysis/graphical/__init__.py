"""Drawings for people who decide by looking: Popov and Nyquist plots that say what they do not prove."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

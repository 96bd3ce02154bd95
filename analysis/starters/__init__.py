"""Files to start from: a notebook about one's own loop, and a test that guards one's own nonlinearity."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

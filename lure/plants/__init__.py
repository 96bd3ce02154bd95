"""Blocks from whatever a user has: objects of python-control and scipy.signal, matrices, coefficients, text."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

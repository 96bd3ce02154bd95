"""Cellular neural networks: cloning templates on a line or in the plane, and the paper's rod as one of them."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

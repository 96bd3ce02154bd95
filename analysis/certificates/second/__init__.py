"""A second checker of certificates, on python-flint, written from the theorems and not from the first checker."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

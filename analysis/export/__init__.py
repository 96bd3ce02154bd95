"""Certificates for other programs: as a file that a proof assistant checks."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

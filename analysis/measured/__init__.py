"""Measured laws: displacement and force from files, the sector of the mean law, the compliance law fitted."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

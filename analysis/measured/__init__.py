"""Measured nonlinearities: displacement and force from files, the sector of their mean, the compliance law fitted."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

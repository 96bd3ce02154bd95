"""The exact motion of the rod beside its approximations: integrators of the scheme, Galerkin, one table."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

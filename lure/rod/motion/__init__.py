"""The motion of the rod itself, with contact, to rounding: no grid, no time step."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

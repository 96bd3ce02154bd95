"""The upwind scheme by its structure: jumps of any length for very many cells, and contact event to event."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

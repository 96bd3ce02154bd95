"""The upwind scheme followed exactly in time: jumps of any length, contact event to event, steps under any load."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

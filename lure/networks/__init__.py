"""Neural networks as controllers: read from files, and closed around a plant as a loop with one channel a neuron."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

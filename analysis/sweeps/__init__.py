"""Many loops: a system, what is varied and what is asked become a labelled data set of answers."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

"""The page on which a loop is explored: static files, in which a browser runs the exact core and both checkers."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

"""What can be said about a Lur'e loop, by what means, and with which margin."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

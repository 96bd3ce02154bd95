"""Two-sided answers: how far a class is proved stable, and where a member of it destabilises the loop."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

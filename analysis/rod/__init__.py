"""What can be said of the rod and of its scheme: proofs, spectrum, motions, and the paper reproduced."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

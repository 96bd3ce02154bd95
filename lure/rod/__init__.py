"""The paper's rod: parameters, transfer function, the upwind scheme, weak form, network, and the exact motion."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

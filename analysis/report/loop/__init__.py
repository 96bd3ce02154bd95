"""The report on any Lur'e loop: one table of classes, what proves and what refutes them, as HTML and JSON."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

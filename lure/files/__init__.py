"""Systems as TOML files: read with every number exact, checked, changed from the command line, and written back."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

"""The `lure` command: thin, no mathematics.  Nothing heavy is imported before a command needs it."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

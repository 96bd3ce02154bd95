"""Figures: results in, axes out.  matplotlib is imported here and for the rod's figures only, when something is drawn.

Every function draws on the axes it is given (a new pyplot figure without them), returns them, shows nothing and leaves
matplotlib's settings alone.
"""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

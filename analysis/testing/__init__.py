"""Assertions that guard the sector or the slope of a nonlinearity, and Hypothesis strategies for classes and blocks.

The assertions need neither pytest nor Hypothesis; :mod:`lure.analysis.testing.strategies` needs Hypothesis.  Nothing is
loaded until it is used.
"""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

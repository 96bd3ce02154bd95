"""Formulas for nonlinearities and signals from files: parsed by a whitelist, never evaluated by Python or sympy."""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

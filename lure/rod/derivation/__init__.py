"""The paper's derivation, replayed in sympy: from Hamilton's principle to the scheme, its spectrum and its misprints.

``derivation()`` returns the steps in order, each with a residual that is zero; ``misprints()`` returns the formulas of
the paper that do not follow, each with a difference that is not.  The other functions return the pieces.
Importing this package imports sympy; ``import lure`` does not import this package.
"""

from lure.lazy import lazy_exports

__getattr__, __dir__, __all__ = lazy_exports(__name__, __file__)

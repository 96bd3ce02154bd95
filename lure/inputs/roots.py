"""Polynomials multiplied out exactly from roots in floating point."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from lure.errors import InputError
from lure.exact import exact_number

_SAME = 1e-12


def polynomial_of_roots(roots: Iterable[complex], name: str = "roots") -> list[Fraction]:
    """Coefficients of ``prod (s - r)``, highest power first, every double taken exactly.

    Parameters
    ----------
    roots : iterable of complex
        Complex ones in conjugate pairs; a pair that agrees only to a few rounding errors counts as the root of the
        pair with positive imaginary part and its exact conjugate.
    name : str
        What they are, for errors.

    Raises
    ------
    InputError
        A root is not finite, or a complex one has no conjugate.
    """
    left = [complex(root) for root in roots]
    product = [Fraction(1)]
    for i, root in enumerate(left):
        for part in (root.real, root.imag):
            exact_number(part, f"{name}[{i}]")
    upper = [root for root in left if root.imag > 0]
    lower = [root for root in left if root.imag < 0]
    for root in upper:
        match = min(lower, key=lambda other: abs(other - root.conjugate()), default=None)
        if match is None or abs(match - root.conjugate()) > _SAME * abs(root):
            raise InputError(f"{name} holds {root:.6g} without its conjugate: the coefficients are complex; add it")
        lower.remove(match)
        x, y = Fraction(root.real), Fraction(root.imag)
        product = _times(product, [Fraction(1), -2 * x, x * x + y * y])
    if lower:
        raise InputError(f"{name} holds {lower[0]:.6g} without its conjugate: the coefficients are complex; add it")
    for root in left:
        if root.imag == 0:
            product = _times(product, [Fraction(1), -Fraction(root.real)])
    return product


def _times(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    result = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return result

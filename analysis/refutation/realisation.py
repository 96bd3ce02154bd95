"""State equations of a block with exact coefficients, and what a gain in the loop makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from flint import arb_mat
from numpy.typing import ArrayLike, NDArray

from analysis.exact_matrix import exact_entry
from analysis.precision import ball
from lure.errors import InputError
from lure.rational import RationalBlock

Row = tuple[Fraction, ...]


@dataclass(frozen=True, slots=True)
class Realisation:
    r"""``x' = A x + b mu``, ``sigma = c x + d mu`` (in discrete time ``x+``), every entry a Fraction.

    Attributes
    ----------
    A : tuple of tuples
        (n, n), row by row.
    b, c : tuple
        (n,).
    d : Fraction
        Feedthrough ``H(infinity)``.
    """

    A: tuple[Row, ...]
    b: Row
    c: Row
    d: Fraction

    @property
    def order(self) -> int:
        """Number of states."""
        return len(self.b)

    def closed(self, k: Fraction) -> tuple[Row, ...]:
        """``A - b c k/(1 + k d)``: the loop with ``mu = -k sigma``; needs ``1 + k d != 0``."""
        gain = k / (1 + k * self.d)
        return tuple(
            tuple(a - gain * bi * cj for a, cj in zip(row, self.c, strict=True))
            for row, bi in zip(self.A, self.b, strict=True)
        )


def companion(block: RationalBlock) -> Realisation:
    """The controllable companion form: ``x = (y, y', ..., y^(n-1))`` with ``d(p) y = mu``, ``sigma = n(p) y``.

    Hidden modes are kept: they are unobservable in this form.
    """
    n, d = block.order, block.feedthrough
    low = tuple(reversed(block.denominator))[:n]
    top = (*reversed(block.numerator), *[Fraction(0)] * (n + 1 - len(block.numerator)))
    rows = [tuple(Fraction(int(j == i + 1)) for j in range(n)) for i in range(n - 1)]
    last = [tuple(-a for a in low)] if n else []
    b = tuple(Fraction(int(i == n - 1)) for i in range(n))
    return Realisation((*rows, *last), b, tuple(t - d * a for t, a in zip(top[:n], low, strict=True)), d)


def realisation(block: RationalBlock | tuple[ArrayLike, ArrayLike, ArrayLike]) -> Realisation:
    """The companion form of a block, or matrices ``(A, b, c)`` without feedthrough as they are.

    Raises
    ------
    InputError
        The shapes do not fit, or an entry is not a finite number.
    """
    if isinstance(block, RationalBlock):
        return companion(block)
    A, b, c = (np.asarray(part, dtype=object) for part in block)
    n = A.shape[0] if A.ndim == 2 else -1
    if A.shape != (n, n) or b.size != n or c.size != n:
        raise InputError(f"a realisation needs A (n, n), b (n,), c (n,); got A {A.shape}, b {b.shape}, c {c.shape}")
    rows = tuple(tuple(exact_entry(A[i, j], f"A[{i}, {j}]") for j in range(n)) for i in range(n))
    sides = [
        tuple(exact_entry(v, f"{name}[{i}]") for i, v in enumerate(side.ravel()))
        for name, side in zip("bc", (b, c), strict=True)
    ]
    return Realisation(rows, sides[0], sides[1], Fraction(0))


def doubles(rows: Sequence[Row]) -> NDArray[np.float64]:
    """Exact rows rounded to doubles."""
    return np.array([[float(value) for value in row] for row in rows], dtype=float).reshape(len(rows), -1)


def balls(rows: Sequence[Sequence[Fraction]]) -> arb_mat:
    """Exact rows as balls, as narrow as the working precision allows."""
    return arb_mat([[ball(value) for value in row] for row in rows])

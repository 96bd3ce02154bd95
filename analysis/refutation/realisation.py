"""Exact state equations from a block or from matrices, and their entries as doubles and as balls."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from flint import arb_mat
from numpy.typing import ArrayLike, NDArray

from analysis.exact_matrix import exact_entry
from analysis.precision import ball
from lure.errors import InputError
from lure.rational import RationalBlock
from lure.realisation import Realisation as Realisation
from lure.realisation import Row as Row
from lure.realisation import companion as companion


def realisation(block: RationalBlock | tuple[ArrayLike, ArrayLike, ArrayLike]) -> Realisation:
    """The companion form of a block, or matrices ``(A, b, c)`` without feedthrough as they are.

    States of witnesses and certificates are those of the companion form.  The states that the user of a block knows,
    those of the matrices it was given by, are in :attr:`lure.rational.RationalBlock.realisation`; simulations that
    are held against a proof use those.

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

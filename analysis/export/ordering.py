"""That a form of samples is nonnegative for all orders of the samples, in the words of Coq: `cones.v`, `orders.v`."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product

from lure.analysis.certificates.channels import triangle
from lure.analysis.export.quadratic import semidefinite, whole
from lure.analysis.export.words import integers, refused

Whole = list[list[int]]
DEEPEST = 40


def window_of(given: list[list[str]]) -> tuple[Whole, int]:
    """The form of a certificate, a lower triangle, with integers, and what it was multiplied by."""
    M = triangle(given, len(given))
    entries, q = whole([v for row in M for v in row])
    return [entries[i : i + len(M)] for i in range(0, len(entries), len(M))], q


def witnesses(M: Whole, *, odd: bool) -> str:
    """For each order a subdivision of its cone, on the parts of which ``M`` is ``N + S``: a list of ``halves``.

    Raises
    ------
    refused
        An ``InputError``: ``M`` leaves too little room.
    """
    count = len(M) // 2
    found = []
    for signs, order in _cases(count, odd=odd):
        at = {i: order.index(i) for i in range(count + 1)}
        rows = [[signs[i - 1] * ((h < at[i]) - (h < at[0])) for h in range(count)] for i in range(1, count + 1)]
        rows = [[*row, *[0] * count] for row in rows] + [[*[0] * count, *row] for row in rows]
        found.append(halves(_seen(M, rows)))
    return f"[{'; '.join(found)}]"


def _seen(M: Whole, rows: Whole) -> Whole:
    """``rows' M rows``."""
    left = [[sum(v * row[j] for v, row in zip(line, rows, strict=True)) for j in range(len(rows[0]))] for line in M]
    size = range(len(rows[0]))
    return [[sum(row[i] * other[j] for row, other in zip(rows, left, strict=True)) for j in size] for i in size]


def halves(C: Whole, depth: int = 0) -> str:
    """A subdivision of ``x >= 0`` into cones on which ``x'Cx`` is seen to be nonnegative, as Coq's ``halves``.

    Parameters
    ----------
    C : list of list of int
        Symmetric, copositive.
    depth : int
        How often a cone was halved.

    Raises
    ------
    refused
        An ``InputError``: ``C`` leaves too little room.
    """
    size = range(len(C))
    upper = [[2 * v for v in row[i:]] for i, row in enumerate(C)]
    if semidefinite([[a, *(min(v, 0) for v in rest)] for a, *rest in upper]):
        return "(Leaf [" + "; ".join(f"(0, {integers([max(v, 0) for v in rest])})" for _, *rest in upper) + "])"
    if depth == DEEPEST or min(C[i][i] for i in size) < 0:
        raise refused("its form of several samples leaves too little room")
    i, j = min(
        ((i, j) for i in size for j in range(i)),
        key=lambda pair: Fraction(
            C[pair[0]][pair[1]] * abs(C[pair[0]][pair[1]]), 1 + C[pair[0]][pair[0]] * C[pair[1]][pair[1]]
        ),
    )
    parts = []
    for kept, moved in ((i, j), (j, i)):  # e_moved gives way to e_kept + e_moved
        rows = [[int(a == b) + int(a == kept and b == moved) for b in size] for a in size]
        parts.append(halves(_seen(C, rows), depth + 1))
    return f"(Halve {i} {j} {' '.join(parts)})"


def _cases(count: int, *, odd: bool) -> Iterator[tuple[list[int], list[int]]]:
    """Signs and orders, one after the other as ``cases`` of the Coq files has them."""
    if not odd:
        yield from (([1] * count, p) for q in _orders(count) for p in _insertions(0, q))
        return
    for signs in product((1, -1), repeat=count):
        yield from (([*signs], [0, *p]) for p in _orders(count))


def _orders(count: int) -> list[list[int]]:
    """All orders of 1 to ``count``."""
    return [q for p in _orders(count - 1) for q in _insertions(count, p)] if count else [[]]


def _insertions(i: int, p: list[int]) -> list[list[int]]:
    """``p`` with ``i`` at each place."""
    return [[*p[:j], i, *p[j:]] for j in range(len(p) + 1)]

"""Exact numbers as doubles and as short text, rounded in a stated direction; doubles as a certificate states them."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from lure.exact import square_root
from lure.record.values import Towards, rounded

# Exact numbers rounded to doubles, and doubles to text, in a stated direction.


def double_below(value: Fraction) -> float:
    """The largest double not above an exact number; ``-inf`` below all of them."""
    try:
        nearest = float(value)
    except OverflowError:
        return sys.float_info.max if value > 0 else -math.inf
    return nearest if Fraction(nearest) <= value else math.nextafter(nearest, -math.inf)


def double_above(value: Fraction) -> float:
    """The least double not below an exact number; ``inf`` above all of them."""
    return -double_below(-value) + 0.0  # of 0 without a sign


def text_below(value: float | Fraction, digits: int = 10) -> str:
    """Some digits of a number, rounded down: what is proved up to it is proved up to what is printed."""
    return rounded(value, "below", digits)


def text_above(value: float | Fraction, digits: int = 10) -> str:
    """Some digits of a number, rounded up."""
    return rounded(value, "above", digits)


def bound_below(value: float | Fraction) -> str:
    """A bound for text, console, pages and plots alike, rounded down: seven digits, or ten just below a short number.

    Examples
    --------
    >>> bound_below(2 / 3), bound_below(1e12), bound_below(Fraction(59, 10))
    ('0.6666666', '1e12', '5.9')
    """
    return _bound(value, "below")


def bound_above(value: float | Fraction) -> str:
    """The same rounded up: what is refuted from the bound on is refuted from what is printed on.

    Examples
    --------
    >>> bound_above(2 / 3), bound_above(5.7), bound_above(Fraction(57, 10))
    ('0.6666667', '5.700000001', '5.7')
    """
    return _bound(value, "above")


def _bound(value: float | Fraction, towards: Towards) -> str:
    if isinstance(value, float) and not math.isfinite(value):
        return f"{value:g}"
    nearest = f"{float(value):.7g}"
    short = len(nearest.split("e")[0].replace(".", "").strip("-0")) <= 3
    text = rounded(value, towards, 10 if short and Fraction(nearest) != value else 7)
    if not (text.isdigit() and text.endswith("0" * 7)):
        return text
    digits = text.rstrip("0")
    return f"{digits[0]}{'.' if digits[1:] else ''}{digits[1:]}e{len(text) - 1}"


def form_text(rows: Sequence[Sequence[Fraction]], towards: Towards) -> str:
    """A symmetric matrix as text: the form ``x' P x`` of what is printed is nowhere below, or above, the exact one.

    Parameters
    ----------
    rows : sequence of sequences of Fraction
        (n, n).
    towards : {"above", "below"}
        Where the form is rounded: ``{x : x' P x <= 1}`` of one rounded above lies within the exact set.

    Notes
    -----
    What an entry beside the diagonal loses goes to the diagonal, as ``2 |e x y| <= |e| (r x^2 + y^2/r)``.

    Examples
    --------
    >>> third = Fraction(1, 3)
    >>> form_text([[1, third], [third, 1]], "above"), form_text([[1, third], [third, 1]], "below")
    ('[[1.000001, 0.3333333], [0.3333333, 1.000001]]', '[[0.9999999, 0.3333333], [0.3333333, 0.9999999]]')
    """
    texts = [[rounded(v, "nearest", 7) for v in row] for row in rows]
    for i, row in enumerate(rows):
        lost = Fraction(0)
        for j in set(range(len(rows))) - {i}:
            first, second = (rows[k][k] for k in sorted((i, j)))
            root = square_root(Fraction(first) / second) if first > 0 and second > 0 else 1.0
            r = Fraction(root) if 0 < root < math.inf else Fraction(1)
            lost += abs(Fraction(texts[i][j]) - row[j]) * (r if i < j else 1 / r)
        texts[i][i] = rounded(row[i] + lost if towards == "above" else row[i] - lost, towards, 7)
    return f"[{', '.join('[' + ', '.join(row) + ']' for row in texts)}]"


# What a search found in floating point, in the rational numbers of a certificate.


def decimals(values: Iterable[float]) -> list[Fraction]:
    """Twelve digits of each number."""
    return [Fraction(f"{v:.12g}") for v in values]


def places(size: float, bits: int) -> int:
    """The exponent ``e >= 0`` with which ``size`` has so many bits before the point as ``2^e size``."""
    return max(0, bits - math.floor(math.log2(max(size, 1e-300))))


def triangle(P: Iterable[Sequence[float]], exponent: int) -> list[list[int]]:
    """The lower triangle of a matrix times ``2^exponent``, rounded to whole numbers."""
    return [[round(Fraction(float(v)) * 2**exponent) for v in row[: i + 1]] for i, row in enumerate(P)]


def triangle_texts(P: Iterable[Sequence[object]]) -> list[list[str]]:
    """The lower triangle of an exact matrix, or of one already, as a certificate has it."""
    return [[str(v) for v in row[: i + 1]] for i, row in enumerate(P)]


def matrix_proof(P: Iterable[Sequence[float]], size: float, bits: int) -> dict[str, Any]:
    """``proof`` of a certificate by a Lyapunov matrix; ``size``: an entry of this size keeps so many bits."""
    exponent = places(size, bits)
    return {"method": "matrix", "P": triangle_texts(triangle(P, exponent)), "exponent": exponent}

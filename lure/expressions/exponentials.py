"""Formulas of time as sums of ``t^k e^{lambda t}``: exact, where a formula is one.

Between the instants at which its conditions change, a formula made of ``+ - *``, whole powers, constants, ``t``, and
``exp``, ``sin`` and ``cos`` of straight lines is such a sum; everything else is not, and is reported as None.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from lure.arrays import np
from lure.expressions.expression import closure
from lure.expressions.rigorous import holds, value
from lure.expressions.tree import Apply, Node, Number, Variable, names

Sum: TypeAlias = Mapping[tuple[complex, int], complex]
"""Weights of ``t^k e^{lambda t}`` by ``(lambda, k)``, ``lambda`` in 1/s."""

MOST_TERMS = 64
LARGEST_POWER = 8


def exponentials(node: Node, variable: str, inside: Fraction) -> Sum | None:
    r"""The sum that a formula is around a point, or None.

    Parameters
    ----------
    node : Node
        A formula of one variable, each of whose conditions compares straight lines with rational coefficients (so that
        :meth:`lure.expressions.Expression.breakpoints` knows them all).
    variable : str
        Its name.
    inside : Fraction
        A point between two neighbouring breakpoints; the answer holds from the one to the other.

    Returns
    -------
    Mapping or None
        Weights of ``t^k e^{lambda t}``, conjugate rates with conjugate weights; at most 64 terms and ``k <= 8``.

    Examples
    --------
    >>> from lure.expressions import Expression
    >>> wave = Expression.parse("3*cos(2*t) if t > 1 else t", variables=("t",))
    >>> exponentials(wave.tree, "t", Fraction(0))
    {(0j, 1): (1+0j)}
    >>> exponentials(wave.tree, "t", Fraction(2))
    {(2j, 0): (1.5+0j), (-2j, 0): (1.5+0j)}
    """
    if not names(node):
        with np.errstate(all="ignore"):
            number = float(closure(node)({}))
        return {(0j, 0): complex(number)} if math.isfinite(number) else None
    if isinstance(node, Variable):
        return {(0j, 1): 1.0 + 0j}
    assert isinstance(node, Apply), "a number has no variables"
    chosen = _chosen(node, {variable: inside})
    if chosen is not None:
        sign, branch = chosen
        return _scaled(exponentials(branch, variable, inside), sign)
    if node.operation == "sign":
        inner = value(node.arguments[0], {variable: inside})
        return {(0j, 0): complex((inner > 0) - (inner < 0))}
    parts = [exponentials(part, variable, inside) for part in node.arguments]
    known = [part for part in parts if part is not None]
    return _combined(node, known) if len(known) == len(parts) else None


def _chosen(node: Apply, point: Mapping[str, Fraction]) -> tuple[float, Node] | None:
    """The part that ``where``, ``min``, ``max`` or ``abs`` stands for at a point, and its sign."""
    if node.operation == "where":
        condition, yes, no = node.arguments
        return 1.0, yes if holds(condition, point) else no
    if node.operation in ("min", "max"):
        first, second = node.arguments
        below = value(first, point) < value(second, point)
        return 1.0, first if below is (node.operation == "min") else second
    if node.operation == "abs":
        return (1.0 if value(node.arguments[0], point) >= 0 else -1.0), node.arguments[0]
    return None


def _combined(node: Apply, parts: list[Sum]) -> Sum | None:
    match node.operation:
        case "+":
            return _added(parts[0], parts[1])
        case "-":
            return _added(parts[0], _scaled(parts[1], -1.0))
        case "neg":
            return _scaled(parts[0], -1.0)
        case "*":
            return _multiplied(parts[0], parts[1])
        case "/":
            divisor = _constant(parts[1])
            return _scaled(parts[0], 1.0 / divisor) if divisor else None
        case "**":
            return _power(parts[0], node.arguments[1])
        case "exp" | "sin" | "cos":
            return _wave(node.operation, parts[0])
        case _:
            return None


def _added(left: Sum | None, right: Sum | None) -> Sum | None:
    if left is None or right is None:
        return None
    total = dict(left)
    for key, weight in right.items():
        total[key] = total.get(key, 0j) + weight
    return _kept(total)


def _scaled(terms: Sum | None, factor: float) -> Sum | None:
    return None if terms is None else _kept({key: factor * weight for key, weight in terms.items()})


def _multiplied(left: Sum, right: Sum) -> Sum | None:
    total: dict[tuple[complex, int], complex] = {}
    for (rate, power), weight in left.items():
        for (other, degree), factor in right.items():
            key = (rate + other, power + degree)
            total[key] = total.get(key, 0j) + weight * factor
    return _kept(total)


def _power(base: Sum, exponent: Node) -> Sum | None:
    if not isinstance(exponent, Number) or exponent.value.denominator != 1:
        return None
    if not 0 <= int(exponent.value) <= MOST_TERMS:
        return None
    result: Sum | None = {(0j, 0): 1.0 + 0j}
    for _ in range(int(exponent.value)):
        result = None if result is None else _multiplied(result, base)
    return result


def _wave(operation: str, inner: Sum) -> Sum | None:
    """``exp``, ``sin`` or ``cos`` of a straight line with real coefficients."""
    if not set(inner) <= {(0j, 0), (0j, 1)}:
        return None
    start, slope = inner.get((0j, 0), 0j).real, inner.get((0j, 1), 0j).real
    if operation == "exp":
        size = math.exp(start) if start < 700.0 else math.inf
        return _kept({(complex(slope), 0): complex(size)})
    half = 0.5 * cmath.rect(1.0, start) * (1.0 if operation == "cos" else -1j)
    return _added({(complex(0.0, slope), 0): half}, {(complex(0.0, -slope), 0): half.conjugate()})


def _constant(terms: Sum) -> float | None:
    return terms[0j, 0].real if set(terms) == {(0j, 0)} else None


def _kept(terms: Mapping[tuple[complex, int], complex]) -> Sum | None:
    """Terms with a weight; None if there are too many, or one is not finite."""
    kept = {key: weight for key, weight in terms.items() if weight}
    sound = all(cmath.isfinite(rate) and cmath.isfinite(weight) for (rate, _), weight in kept.items())
    powers = max((power for _, power in kept), default=0)
    return kept if sound and len(kept) <= MOST_TERMS and powers <= LARGEST_POWER else None

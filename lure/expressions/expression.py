"""A formula given as text: parsed by a whitelist, evaluated in floats, exactly or as balls, differentiated."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from numbers import Integral
from typing import TYPE_CHECKING, Any, TypeAlias

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError
from lure.expressions import rigorous as balls
from lure.expressions.parser import FUNCTIONS, KEYWORDS, parse
from lure.expressions.tree import ZERO, Apply, Node, Number, decimal, depth, derivative, names, render, size, switches
from lure.record import described, quantity

if TYPE_CHECKING:
    from flint import arb

# The numpy back-end: a tree becomes nested closures over numpy's own functions.

# Scalars, arrays and, inside conditions, arrays of bool: numpy's broadcasting is what gives them one shape.
Values: TypeAlias = Any
Closure: TypeAlias = Callable[[Mapping[str, Values]], Values]

_FUNCTIONS: dict[str, Callable[[], Callable[..., Values]]] = {  # numpy's own, looked up when a tree is compiled
    "+": lambda: np.add,
    "-": lambda: np.subtract,
    "*": lambda: np.multiply,
    "/": lambda: np.divide,
    "**": lambda: np.power,
    "neg": lambda: np.negative,
    "<": lambda: np.less,
    "<=": lambda: np.less_equal,
    ">": lambda: np.greater,
    ">=": lambda: np.greater_equal,
    "==": lambda: np.equal,
    "!=": lambda: np.not_equal,
    "and": lambda: np.logical_and,
    "or": lambda: np.logical_or,
    "not": lambda: np.logical_not,
    "where": lambda: np.where,
    "min": lambda: np.minimum,
    "max": lambda: np.maximum,
    "abs": lambda: np.abs,
    "sign": lambda: np.sign,
    "sin": lambda: np.sin,
    "cos": lambda: np.cos,
    "tan": lambda: np.tan,
    "tanh": lambda: np.tanh,
    "atan": lambda: np.arctan,
    "exp": lambda: np.exp,
    "log": lambda: np.log,
    "sqrt": lambda: np.sqrt,
}


def closure(node: Node) -> Closure:
    """A function of the variables' arrays; both branches of a condition are evaluated, the untaken one is discarded."""
    if isinstance(node, Number):
        constant = float(node.value)
        return lambda values: constant
    if not isinstance(node, Apply):
        name = node.name
        return lambda values: values[name]
    if node.operation == "pi":
        return lambda values: math.pi
    return _applied(_FUNCTIONS[node.operation](), [closure(part) for part in node.arguments])


def _applied(function: Callable[..., Values], parts: list[Closure]) -> Closure:
    if len(parts) == 1:
        (only,) = parts
        return lambda values: function(only(values))
    if len(parts) == 2:
        first, second = parts
        return lambda values: function(first(values), second(values))
    return lambda values: function(*(part(values) for part in parts))


# A number given as a Python object, as the text that means it exactly.


def literal(number: int | float | Fraction | Decimal, *, field: str) -> str:
    """A number as the text that means it exactly."""
    if isinstance(number, bool) or not isinstance(number, Integral | float | Fraction | Decimal):
        raise InputError(f"{field}: expected a number or a formula but found a {type(number).__name__}.")
    if not (
        number.is_finite() if isinstance(number, Decimal) else isinstance(number, Integral) or math.isfinite(number)
    ):
        raise InputError(f"{field}: the number must be finite but is {number}.")
    text = None
    if isinstance(number, Decimal):
        small = not number or (abs(number.adjusted()) <= 400 and len(number.as_tuple().digits) <= 500)
        text = decimal(Fraction(number) if number else Fraction(0)) if small else None
    elif isinstance(number, float):
        text = decimal(Fraction(float.__repr__(number)))
    elif isinstance(number, Fraction):
        text = decimal(number)
    else:
        text = decimal(Fraction(int(number)))
    if text is None:
        raise InputError(
            f"{field}: the number is not zero and not between 1e-300 and 1e300 in size with at most 100 digits."
        )
    return text


_MAX_DERIVED_SIZE = 20_000
_MAX_DERIVED_DEPTH = 200


@described(frozen=True, kw_only=True)
class Expression:
    r"""A formula in named variables, safe to take from a file; make one with :meth:`parse`.

    Numbers are exact: ``0.1`` means 1/10 in every back-end until the last rounding.  The grammar is Python's for
    ``+ - * / **``, comparisons (chained, too), ``and or not`` and ``a if condition else b``, with the functions ``abs
    atan cos exp log max min sign sin sqrt tan tanh where(condition, a, b)`` and ``pi``.  Exponents are rational
    constants of size at most 32.  Conditions are not numbers: ``(t < 1)*t`` is refused, ``where(t < 1, t, 0)`` is not.

    Two expressions are equal if their text and their variables are; ``t + t`` and ``2*t`` are not.

    Examples
    --------
    >>> ramp = Expression.parse("t/2 if t < 1 else 0.5", variables=("t",), field="force.g")
    >>> ramp(t=[0.0, 0.5, 3.0])
    array([0.  , 0.25, 0.5 ])
    >>> ramp.exact(t=Fraction(1, 3)), ramp.breakpoints("t", 0, 10)
    (Fraction(1, 6), (Fraction(1, 1),))
    >>> print(ramp.derivative("t"))
    where(t < 1, 0.5, 0)
    """

    source: str = quantity("The text, without blanks around it")
    variables: tuple[str, ...] = quantity('Names the text may use, e.g. ``("t", "x")``')
    tree: Node = quantity("What the text means; :meth:`parse` and :meth:`derivative` supply it", hidden=True)

    @cached_property
    def _closure(self) -> Closure:
        """The tree compiled to closures, once."""
        return closure(self.tree)

    def __reduce__(self) -> tuple[Callable[..., Expression], tuple[str, tuple[str, ...], Node]]:
        """Pickle without the closures, for worker processes."""
        return _restored, (self.source, self.variables, self.tree)

    def __str__(self) -> str:
        """The text."""
        return self.source

    @classmethod
    def parse(
        cls, text: str | int | float | Fraction | Decimal, *, variables: tuple[str, ...], field: str = "expression"
    ) -> Expression:
        """Read a formula, or a number as a constant formula.

        Parameters
        ----------
        text : str, int, float, Fraction or Decimal
            A float counts as the shortest decimal that names it, so ``0.1`` and ``"0.1"`` are the same expression.
        variables : tuple of str
            Names the text may use; plain identifiers that are not functions, keywords or ``pi``.
        field : str
            Where the text stands, for error messages: ``force.g``.

        Raises
        ------
        InputError
            One sentence with the field, the column and what is allowed.  Limits: 1024 characters, 200 numbers, names
            and operations, 30 levels, 100 digits, constants of size 1e-300 to 1e300.
        ValueError
            ``variables`` holds something that cannot be a variable.
        """
        for name in variables:
            if not re.fullmatch(r"[A-Za-z_][A-Za-z_0-9]*", name) or name in (*FUNCTIONS, *KEYWORDS, "pi"):
                raise ValueError(f"Expression.parse cannot use {name!r} as the name of a variable.")
        source = (text if isinstance(text, str) else literal(text, field=field)).strip(" \t\r\n")
        tree = parse(text if isinstance(text, str) else source, variables=variables, field=field)
        return cls(source=source, variables=variables, tree=tree)

    def __call__(self, **arrays: ArrayLike) -> NDArray[np.float64]:
        """Values in double precision.

        Parameters
        ----------
        **arrays : array_like
            One for each variable the text uses; they broadcast against each other, and a constant takes their shape.

        Returns
        -------
        NDArray[np.float64]
            A new array of the broadcast shape.  Where the formula is undefined or overflows it is nan or infinite,
            without a warning: **callers check** ``np.isfinite``.  A comparison with nan is False.

        Raises
        ------
        TypeError
            A variable is missing, or the expression has no variable of that name.
        """
        self._check_names(arrays)
        values = {name: np.asarray(array, dtype=np.float64) for name, array in arrays.items()}
        shape = np.broadcast_shapes(*(value.shape for value in values.values())) if len(values) != 1 else None
        with np.errstate(all="ignore"):
            result = self._closure(values)
        found = np.empty(next(iter(values.values())).shape if shape is None else shape)
        found[...] = result
        return found

    def exact(self, **fractions: Fraction | int) -> Fraction:
        """Exact value at rational values of the variables; a condition evaluates only the branch it selects.

        Raises
        ------
        InputError
            A function without rational values (``sin``, ``sqrt``, ``pi``, ``x**0.5``, ...) is met, the formula is
            undefined there, or an intermediate number needs more than 65536 bits.
        TypeError
            A variable is missing, unknown or not rational (floats are refused: they would be read as binary).
        """
        self._check_names(fractions)
        for name, number in fractions.items():
            if not isinstance(number, Fraction | int):
                raise TypeError(f"Expression.exact needs Fractions; {name} is a {type(number).__name__}.")
        return balls.value(self.tree, {name: Fraction(number) for name, number in fractions.items()})

    def ball(self, **arb_values: arb) -> arb:
        """Ball that contains the value at every point of the given balls at which the formula has one.

        A nan ball says that nothing is known: the formula may be undefined somewhere in the balls, or they are wide.
        An undecided condition gives the hull of both branches, so the ball of a jump covers the jump.  The precision is
        ``flint.ctx.prec``, set by the caller.

        Raises
        ------
        TypeError
            A variable is missing or unknown.
        """
        self._check_names(arb_values)
        return balls.enclosure(self.tree, arb_values)

    def derivative(self, variable: str) -> Expression:
        r"""Partial derivative with respect to one of the variables, **almost everywhere**.

        .. math:: |u|' = \mathrm{sign}(u)\,u', \qquad \mathrm{sign}(u)' = 0, \qquad
            \min(u, v)' = u' \text{ where } u < v \text{ else } v'

        and conditions are differentiated branch by branch.  At a kink the value is one side's (0 for ``abs``); a jump
        contributes nothing, so an enclosure of the derivative bounds difference quotients only if there are no jumps.
        Outside the domain of the formula (``log(x)``, ``x < 0``) the derivative may have a value that means nothing.

        Raises
        ------
        ValueError
            The expression has no variable of that name.
        InputError
            A repeated derivative has grown past 20000 operations.
        """
        self._check_variable(variable)
        tree = derivative(self.tree, variable)
        if size(tree) > _MAX_DERIVED_SIZE or depth(tree) > _MAX_DERIVED_DEPTH:
            raise InputError(
                f"the derivative of {self.source[:40]!r} is too large; differentiate a shorter expression."
            )
        return Expression(source=render(tree), variables=self.variables, tree=tree)

    @property
    def is_constant(self) -> bool:
        """Whether no variable is left in the formula."""
        return not names(self.tree)

    @property
    def is_zero(self) -> bool:
        """Whether the formula is visibly zero: ``0.5 - 1/2`` and ``0*sin(t)`` count, ``t - t`` does not."""
        return self.tree == ZERO

    def breakpoints(
        self, variable: str, low: Fraction | int | float, high: Fraction | int | float
    ) -> tuple[Fraction, ...] | None:
        """Points in the open interval where the formula may change its branch, sorted; None if they are not all known.

        Between neighbours every condition, ``abs``, ``sign``, ``min`` and ``max`` keeps its side, so the formula is one
        smooth piece wherever its functions are.  Known means: every condition is linear in ``variable`` with rational
        coefficients and free of the other variables.  A listed point need not be a kink.

        Raises
        ------
        ValueError
            The expression has no variable of that name.
        """
        self._check_variable(variable)
        points = switches(self.tree, variable)
        return None if points is None else tuple(sorted(point for point in points if low < point < high))

    def _check_variable(self, variable: str) -> None:
        if variable not in self.variables:
            raise ValueError(
                f"the expression {self.source[:40]!r} has the variables {self.variables}, not {variable!r}."
            )

    def _check_names(self, given: Collection[str]) -> None:
        missing, unknown = names(self.tree) - set(given), set(given) - set(self.variables)
        if missing or unknown:
            raise TypeError(
                f"the expression {self.source[:40]!r} of {self.variables} was given {sorted(given)}; "
                f"missing {sorted(missing)}, unknown {sorted(unknown)}."
            )


def _restored(source: str, variables: tuple[str, ...], tree: Node) -> Expression:
    return Expression(source=source, variables=variables, tree=tree)

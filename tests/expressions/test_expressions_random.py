"""Random formulas: the three back-ends and the derivative agree."""

import ast
from dataclasses import dataclass
from fractions import Fraction

import pytest
from depth import sampled
from formulas import TX, arb, contains
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import depth, size

# Random expressions.

CONSTANTS = ["0", "1", "2", "0.5", "1.25", "3"]
LEAVES = st.sampled_from(["t", "x", *CONSTANTS])


def conditions(values):
    compared = st.builds("{} {} {}".format, values, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), values)
    chained = st.builds("{} < {} <= {}".format, values, values, values)
    joined = st.builds("({}) {} not ({})".format, compared, st.sampled_from(["and", "or"]), compared)
    return compared | chained | joined


def deeper(values):
    binary = st.builds("({} {} {})".format, values, st.sampled_from(["+", "-", "*", "/"]), values)
    flat = st.builds("({} {} {} {} {})".format, values, st.sampled_from("+-*"), values, st.sampled_from("+-*"), values)
    power = st.builds(
        "({}{}**{})".format, st.sampled_from(["", "-"]), values, st.sampled_from(["0", "1", "2", "3", "-1"])
    )
    called = st.builds("{}({})".format, st.sampled_from(["abs", "sign", "-", "+"]), values)
    paired = st.builds("{}({}, {})".format, st.sampled_from(["min", "max"]), values, values)
    branched = st.builds("({} if {} else {})".format, values, conditions(values), values)
    where = st.builds("where({}, {}, {})".format, conditions(values), values, values)
    return binary | flat | power | called | paired | branched | where


RATIONAL = st.recursive(LEAVES, deeper, max_leaves=10)
POINTS = st.fractions(-3, 3, max_denominator=7)


def parsed(text):
    """Random text divides by zero now and then (``1/(2 - 2)``); that is refused and no test of the back-ends."""
    try:
        return Expression.parse(text, variables=TX)
    except InputError as refusal:
        assume("division by zero" not in str(refusal))
        raise


def exact(expression, **point):
    try:
        return expression.exact(**point)
    except InputError:
        assume(False)


@dataclass(frozen=True, eq=False)
class Dual:
    """``value + slope*d`` with ``d*d = 0``: differentiates while it computes, independently of any tree."""

    value: Fraction
    slope: Fraction = Fraction(0)

    def __add__(self, other):
        return Dual(self.value + other.value, self.slope + other.slope)

    def __sub__(self, other):
        return Dual(self.value - other.value, self.slope - other.slope)

    def __mul__(self, other):
        return Dual(self.value * other.value, self.slope * other.value + self.value * other.slope)

    def __truediv__(self, other):
        return Dual(self.value / other.value, (self.slope * other.value - self.value * other.slope) / other.value**2)

    def __pow__(self, other):
        n = other.value
        return Dual(self.value**n, 0 if n == 0 else n * self.value ** (n - 1) * self.slope)

    def __neg__(self):
        return Dual(-self.value, -self.slope)

    def __pos__(self):
        return self

    def __lt__(self, other):
        return self.value < other.value

    def __le__(self, other):
        return self.value <= other.value

    def __gt__(self, other):
        return self.value > other.value

    def __ge__(self, other):
        return self.value >= other.value

    def __eq__(self, other):
        return self.value == other.value

    def __ne__(self, other):
        return self.value != other.value

    __hash__ = None


def sign(dual):
    return Dual(Fraction((dual.value > 0) - (dual.value < 0)))


class _Dualised(ast.NodeTransformer):
    def visit_Constant(self, node):
        return ast.Call(ast.Name("number", ast.Load()), [ast.Constant(str(node.value))], [])


def python_value(text, t, x):
    """Python's own reading of the text, on dual numbers in the direction of ``t``: an oracle for grammar and slope."""
    tree = ast.fix_missing_locations(_Dualised().visit(ast.parse(text, mode="eval")))
    names = {
        "t": Dual(t, Fraction(1)),
        "x": Dual(x),
        "number": lambda digits: Dual(Fraction(digits)),
        "sign": sign,
        "abs": lambda u: sign(u) * u,
        "min": lambda u, v: u if u < v else v,
        "max": lambda u, v: u if u > v else v,
        "where": lambda condition, u, v: u if condition else v,
    }
    return eval(compile(tree, "oracle", "eval"), {"__builtins__": {}}, names)


@pytest.mark.slow
@given(text=RATIONAL, t=POINTS, x=POINTS)
@settings(max_examples=sampled(100, of=300))
@example(text="(-t**2)", t=Fraction(2), x=Fraction(0))
@example(text="(x/t)", t=Fraction(2), x=Fraction(3))
def test_exact_value_and_exact_derivative_are_those_of_python_on_dual_numbers(text, t, x):
    expression = parsed(text)
    try:
        expected = python_value(text, t, x)  # computes both branches of where: a zero divisor there is no test
    except ZeroDivisionError:
        assume(False)
    assert expression.exact(t=t, x=x) == expected.value
    assert expression.derivative("t").exact(t=t, x=x) == expected.slope


@given(text=RATIONAL, t=st.integers(-12, 12), x=st.integers(-12, 12))
@settings(max_examples=sampled(100, of=300))
def test_numpy_agrees_with_exact_arithmetic(text, t, x):
    # Multiples of 1/4 are floats, so most comparisons are exact.  Where rounding may decide a branch, the balls say so.
    point = {"t": Fraction(t, 4), "x": Fraction(x, 4)}
    expression = parsed(text)
    expected = exact(expression, **point)
    floats = expression.ball(**{name: arb(value, radius=1e-12) for name, value in point.items()})
    assume(floats.is_finite())
    assume(floats.rad() < 1e-6 * (1 + abs(expected)))
    got = expression(t=[float(point["t"])], x=float(point["x"]))
    assert got == pytest.approx(float(expected), rel=1e-9, abs=1e-9)


@pytest.mark.slow
@given(text=RATIONAL, t=POINTS, x=POINTS, radius=st.sampled_from([0, 1e-9, 0.1, 1, 4]), offset=st.fractions(-1, 1))
@settings(max_examples=sampled(100, of=300))
@example(text="(t**2)", t=Fraction(0), x=Fraction(0), radius=1, offset=Fraction(1))
def test_a_ball_contains_the_exact_values_of_its_points_and_of_the_derivative(text, t, x, radius, offset):
    function = parsed(text)
    inside = t + offset * Fraction(radius)
    balls = {"t": arb(t, radius), "x": arb(x)}
    assert contains(balls["t"], inside)
    for expression in (function, function.derivative("t")):
        value = exact(expression, t=inside, x=x)
        enclosure = expression.ball(**balls)
        assert enclosure.is_nan() or contains(enclosure, value)


@given(text=RATIONAL, variable=st.sampled_from(TX))
def test_the_text_of_a_derivative_reads_back_as_the_same_expression(text, variable):
    slope = parsed(text).derivative(variable)
    assume(len(str(slope)) <= 1024 and size(slope.tree) <= 100 and depth(slope.tree) <= 15)  # else it may be refused
    again = Expression.parse(str(slope), variables=TX)
    assert again == slope
    assert again.tree == slope.tree

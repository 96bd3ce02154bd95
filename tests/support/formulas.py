"""What the tests of expressions share: short ways to read a formula, and exact comparison with balls."""

from fractions import Fraction

import flint

from lure.expressions import Expression

TX = ("t", "x")


def of_t(text, **options):
    return Expression.parse(text, variables=("t",), field="force.g", **options)


def arb(value, radius=0):
    return flint.arb(flint.fmpq(value.numerator, value.denominator), float(radius))


def rational(exact_ball):
    mantissa, exponent = exact_ball.man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def contains(ball, value):
    """Decided in rationals: a Fraction made an arb is a ball itself, and wider than a point."""
    if not ball.is_finite():
        return not ball.is_nan()
    return abs(value - rational(ball.mid())) <= rational(ball.rad())

"""Power series of functions that the ball library has not, without overflow and cancellation."""

from __future__ import annotations

from fractions import Fraction

from flint import arb, arb_series

from lure.expressions.tree import ONE, Apply, Node, Number


def tanh_series(s: arb_series) -> arb_series:
    """``tanh`` of a series, from one exponential that cannot overflow where the sign is known."""
    if s[0] < 0:
        return -tanh_series(-s)
    two = arb_series([arb(2)], s.prec)
    one = arb_series([arb(1)], s.prec)
    return two / (one + (-two * s).exp()) - one


def sech_square_series(s: arb_series) -> arb_series:
    """``1 - tanh^2`` of a series."""
    if s[0] < 0:
        return sech_square_series(-s)
    small = (arb_series([arb(-2)], s.prec) * s).exp()
    one = arb_series([arb(1)], s.prec)
    return arb_series([arb(4)], s.prec) * small / ((one + small) * (one + small))


def inside_sech_square(node: Apply) -> Node | None:
    """``u`` where the node is ``1 - tanh(u)**2``, as derivatives write it."""
    if node.operation != "-" or node.arguments[0] != ONE:
        return None
    square = node.arguments[1]
    if not isinstance(square, Apply) or square.operation != "**" or square.arguments[1] != Number(Fraction(2)):
        return None
    inner = square.arguments[0]
    return inner.arguments[0] if isinstance(inner, Apply) and inner.operation == "tanh" else None

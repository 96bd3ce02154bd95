"""The infimum of the Popov expression of a block with dead time: branch and bound, and a tail."""

from __future__ import annotations

from flint import arb

from analysis.dead_time.response import DelayResponse, Number
from analysis.minimum import Minimum, minimum

RELATIVE_WIDTH = "1e-9"
MAX_QUADRUPLINGS = 8


def popov_infimum(response: DelayResponse, theta: arb, start: float) -> Minimum:
    """Bracket on ``inf Re[(1 + i w theta) H]`` over ``w >= 0``, where it is finite.

    Parameters
    ----------
    response : DelayResponse
        The response.
    theta : arb
        Multiplier [s].
    start : float
        A frequency beyond all features [rad/s]; doubled until the tail lies above the minimum found before it.
    """

    def value(omega: Number) -> Number:
        """The Popov expression at one frequency."""
        real, slope = response.parts(omega)
        return real + theta * slope

    quadruplings, before = 0, arb("-inf")
    while True:
        found = minimum(value, arb(0), arb(start), width=lambda best: abs(best) * arb(RELATIVE_WIDTH) + arb("1e-30"))
        tail = response.tail(arb(start), theta)
        near = found.high >= 0 and tail > -abs(found.high) * arb("1e-3") - arb("1e-9")
        stuck = before.is_finite() and not tail > before + abs(before) * arb("1e-2")  # it tends to less
        if tail >= found.high or near or stuck or quadruplings == MAX_QUADRUPLINGS:
            break
        start, quadruplings, before = 4 * start, quadruplings + 1, tail
    low = found.low if tail >= found.low else tail
    if not low.is_finite():
        low = arb("-inf")
    return Minimum(low=low, high=found.high, where=found.where, closed=found.closed and bool(low == found.low))

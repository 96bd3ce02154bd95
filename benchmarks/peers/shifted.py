"""An independent solution of the rod in figure 8: its waves as constants on cells that move by whole cells."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Array = NDArray[np.float64]


def shifted_waves(rod: Rod, scenario: Scenario, until: float, cells: int) -> tuple[Array, Array]:
    """Times [s] and ``z`` [m] every ``T/cells``, by the delay equation with cell means: second order in the cell.

    With ``W`` constant on a cell, ``z' = W - r z`` in contact, ``r = d/eps``, has the mean ``z phi_1 + W h phi_2``, and
    what returns is ``V = W - 2 r z`` in the mean.  No difference of nearly equal numbers enters, however soft the
    obstacle.  Linear gain; no body force.
    """
    h, rate, echo = rod.travel_time / cells, rod.mobility / rod.compliance, -rod.reflection
    count = math.ceil(until / h)
    middle = (np.arange(cells) + 0.5) * (rod.length / cells)
    forward, backward = scenario.waves(rod, middle)
    sent = 2.0 * rod.input_gain * scenario.force(t=(np.arange(count) + 0.5) * h)
    incoming = [*forward[::-1].tolist(), *(echo * backward).tolist()]
    push = [0.0] * cells + sent.tolist()
    z, path = scenario.contact_coordinate(rod), []
    path.append(z)
    for i in range(count):
        w, left, mean = incoming[i] + push[i], h, 0.0
        while left > 0.0:
            touching = z > 0.0 or (z == 0.0 and w > 0.0)
            span = min(left, _until_zero(z, w, rate if touching else 0.0))
            one, two = _phi(rate * span if touching else 0.0)
            inside = span * (z * one + w * span * two)
            mean += inside if touching else 0.0
            z = 0.0 if span < left else z + w * span - (rate * inside if touching else 0.0)
            left -= span
        incoming.append(echo * (w - 2.0 * rate * mean / h))
        path.append(z)
    return np.arange(count + 1) * h, np.array(path)


def _until_zero(z: float, w: float, rate: float) -> float:
    """How long until ``z' = w - rate z`` reaches zero; inf if it does not."""
    if z == 0.0 or z * w >= 0.0:
        return math.inf
    return -z / w if rate == 0.0 else math.log1p(-rate * z / w) / rate


def _phi(x: float) -> tuple[float, float]:
    """``(1 - e^{-x})/x`` and ``(x - 1 + e^{-x})/x^2``."""
    if x < 1e-3:
        return 1.0 - x / 2.0 + x * x / 6.0 - x**3 / 24.0, 0.5 - x / 6.0 + x * x / 24.0 - x**3 / 120.0
    one = -math.expm1(-x) / x
    return one, (1.0 - one) / x

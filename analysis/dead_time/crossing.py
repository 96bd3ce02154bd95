"""The smallest linear gain at which a block with dead time puts roots on the imaginary axis, bracketed rigorously."""

from __future__ import annotations

import math

import numpy as np
from flint import arb

from analysis.dead_time.response import DelayResponse
from analysis.evidence import Bracket
from analysis.precision import outward
from lure.delay import DelayBlock

SLACK = "1e-10"
MAX_BOXES = 200_000
SAMPLES = 20_001


def gain_limit(block: DelayBlock, response: DelayResponse, start: float) -> Bracket:
    r"""Bracket on the supremum of ``k`` such that ``1 + kappa H`` has all roots in ``Re s < 0`` for ``0 < kappa <= k``.

    The equation is of retarded type: its roots in ``Re s >= 0`` stay bounded and move continuously with the gain, and
    for small gains there are none.  The first ones arrive on the axis, where ``Im H = 0`` and ``kappa = -1/Re H``.

    Parameters
    ----------
    block : DelayBlock
        The block, for a first guess in floating point.
    response : DelayResponse
        Its response.
    start : float
        A frequency beyond all features [rad/s].
    """
    best = _largest_crossing(block, response, start)
    limit = best * (1 + arb(SLACK))
    end = start
    while not response.magnitude(arb(end)) < (limit if best > 0 else arb("1e-6")):
        end *= 2
        if end > 1e9:
            return Bracket(0.0, math.inf)
    if not best > 0:
        limit = arb("1e-6")
    if not _none_beyond(response, limit, end):
        return Bracket(0.0, outward(1 / best, 1 / best).high if best > 0 else math.inf)
    return outward(1 / limit, 1 / best if best > 0 else arb("inf"))


def _largest_crossing(block: DelayBlock, response: DelayResponse, start: float) -> arb:
    """A lower bound, attained at a crossing, on ``-Re H`` over the crossings; 0 if none was found."""
    best = arb(0)
    if not response.critical:
        at_zero = -response.parts(arb(0))[0]
        best = at_zero.lower() if at_zero > 0 else best
    omega = np.concatenate([np.geomspace(start * 1e-6, start, SAMPLES), np.linspace(start / SAMPLES, start, SAMPLES)])
    omega.sort()
    values = block.transfer(1j * omega)
    turns = np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    order = sorted(turns.tolist(), key=lambda i: float(values.real[i]))
    for i in order[:3]:
        left, right = arb(float(omega[i])), arb(float(omega[i + 1]))
        sign = response.parts(left)[1] > 0
        if not response.parts(left)[1] * response.parts(right)[1] < 0:
            continue
        for _ in range(60):
            middle = ((left + right) / 2).mid()
            slope = response.parts(middle)[1]
            if not (slope > 0 or slope < 0):
                break
            left, right = (middle, right) if (slope > 0) == sign else (left, middle)
        value = (-response.parts(left.union(right))[0]).lower()
        best = value if value > best else best
    return best


def _none_beyond(response: DelayResponse, limit: arb, end: float) -> bool:
    """Whether every crossing on ``(0, end]`` has ``-Re H <= limit``."""
    stack = [(arb(0), arb(end))]
    for _ in range(MAX_BOXES):
        if not stack:
            return True
        left, right = stack.pop()
        real, slope = response.parts(left.union(right))
        at_origin = left == 0 and not response.critical  # w Im H has a root at 0 that is a crossing only if H(0) < 0
        if -real <= limit or (slope > 0 or slope < 0):
            continue
        if at_origin and right < arb("1e-12"):
            return False
        middle = ((left + right) / 2).mid()
        stack += [(left, middle), (middle, right)]
    return False

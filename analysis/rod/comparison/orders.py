"""Observed orders: how the error of a family of models shrinks with their cells or elements."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.comparison.reference import Reference
from lure.analysis.rod.comparison.result import Order, Row

Array = NDArray[np.float64]

_FLOOR, _ROUNDING = 100.0, 1e-13


def mean_square(error: Array, t: Array) -> float:
    """Root of the mean square over the time, by the trapezoidal rule.

    Parameters
    ----------
    error, t : ndarray
        (n,) values and their instants [s].
    """
    return math.sqrt(float(np.trapezoid(error**2, t)) / float(t[-1] - t[0]))


def with_orders(rows: list[Row], exact: Reference, tolerances: tuple[float, float]) -> tuple[Row, ...]:
    """The rows with the orders against the next coarser of the family that was run.

    Parameters
    ----------
    rows : list of Row
        By size within each family.
    exact : Reference
        What they are held against.
    tolerances : (float, float)
        Relative tolerance of the time steps of the schemes and of the Galerkin models: errors within a hundred times
        that of the amplitude say nothing about an order.
    """
    done: list[Row] = []
    last: dict[str, Row] = {}
    rounding = _ROUNDING * (float(np.abs(exact.u).max()) + abs(exact.motion.rod.gap))
    for row in rows:
        coarse = last.get(row.family)
        if not row.refused:
            last[row.family] = row
        if row.refused or coarse is None:
            done.append(row)
            continue
        tolerance = tolerances[0 if row.family == "scheme" else 1]
        floor = _FLOOR * tolerance * exact.amplitude + rounding
        ratio = math.log(coarse.width / row.width)
        order = Order(
            coarser=coarse.size,
            before=_order(coarse.before_error, row.before_error, ratio, floor),
            whole=_order(coarse.l2_error, row.l2_error, ratio, floor),
        )
        done.append(replace(row, order=order))
    return tuple(done)


def _order(coarse: float | None, fine: float | None, ratio: float, floor: float) -> float | None:
    if coarse is None or fine is None or not min(coarse, fine) > floor:
        return None
    return math.log(coarse / fine) / ratio

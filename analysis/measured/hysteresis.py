"""Whether loading and unloading follow one law, and what correlated errors do to such questions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analysis.measured.loops import has_loop
from analysis.measured.mean_law import LEAST_ROWS, MeanLaw, mean_law
from analysis.measured.measured_sector import Hysteresis
from analysis.measured.measurements import Direction, Measurements

Array = NDArray[np.float64]
_DIRECTIONS: tuple[Direction, Direction] = ("loading", "unloading")
_PLACES = 65
_CORRELATED = 2.6
_ROUNDING = 1e-12


def branch_rows(measurements: Measurements) -> list[NDArray[np.intp]]:
    """The rows on loading and those on unloading, if both have enough for a mean law; else an empty list.

    Parameters
    ----------
    measurements : Measurements
        What is cut.
    """
    rows = [measurements.rows(direction) for direction in _DIRECTIONS]
    enough = all(part.size >= LEAST_ROWS and np.unique(measurements.displacement[part]).size >= 4 for part in rows)
    return rows if enough else []


def hysteresis_of(measurements: Measurements) -> Hysteresis | None:
    """The loop between loading and unloading; None where there is none to be seen, or there are no two branches.

    Whether there is one is decided by ``has_loop``; its size is that between the mean laws
    of the two directions.

    Parameters
    ----------
    measurements : Measurements
        In the order of recording.
    """
    rows = branch_rows(measurements)
    if not rows or not has_loop(measurements):
        return None
    origin = 0.5 * float(measurements.displacement.min() + measurements.displacement.max())
    laws = [mean_law(measurements.displacement[r] - origin, measurements.load[r], free=True) for r in rows]
    places = np.linspace(max(law.knots[0] for law in laws), min(law.knots[-1] for law in laws), _PLACES)
    apart = laws[0](places) - laws[1](places)
    i = int(np.argmax(np.abs(apart)))
    return Hysteresis(
        width=float(abs(apart[i])),
        at=float(places[i]) + origin,
        share=float(abs(apart[i])) / float(max(np.abs(law.values).max() for law in laws)),
        dissipated=float(np.trapezoid(apart, places)),
        rows=(rows[0].size, rows[1].size),
        branches=len(measurements.branches),
    )


def correlation_of(law: MeanLaw) -> float:
    """Correlation of the errors of neighbouring rows; 0 where it is no more than chance, or errors are rounding.

    Parameters
    ----------
    law : MeanLaw
        With the residuals in the order of recording.
    """
    scores = np.delete(law.scores, law.outliers)
    exact = float(law.noise(law.values).max()) < _ROUNDING * float(np.abs(law.values).max())
    if exact or not scores.any():
        return 0.0
    found = float(np.sum(scores[1:] * scores[:-1]) / np.sum(scores**2))
    return min(found, 0.99) if found * math.sqrt(scores.size) > _CORRELATED else 0.0


def widening(law: MeanLaw) -> float:
    """By how much errors that form a first-order autoregressive sequence widen an interval; 1 if they look independent.

    Parameters
    ----------
    law : MeanLaw
        With the residuals in the order of recording.
    """
    correlation = correlation_of(law)
    return math.sqrt((1 + correlation) / (1 - correlation))

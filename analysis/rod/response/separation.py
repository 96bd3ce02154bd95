r"""Two motions that part: how fast a small difference grows, as it was seen.

A second motion gets a small push ``delta g(t)`` for one period when the watch begins; up to then the two are the same
to the last bit.  The slope of ``ln sup |z_2 - z_1|`` over the periods is observed evidence about these two motions.
It estimates the largest Lyapunov exponent of the motion if that exists and the run is long enough, and proves neither
that the motion is chaotic nor that it is not.
"""

from __future__ import annotations

import numpy as np

from lure.analysis.rod.response.recording import Array
from lure.errors import InputError
from lure.expressions import Expression
from lure.record import Record, quantity
from lure.rod.scenario import Scenario

PUSH = 1e-9
_NOISE, _LARGE = 1e-13, 1e-2
_FEWEST = 4


class Separation(Record):
    """How the distance of two nearby motions changed."""

    distance: Array = quantity("(R,) largest ``|z_2 - z_1|`` in each period of the watch", "m")
    rate: float = quantity(
        "Slope of its logarithm over ``periods`` [1/s]; negative if the motions come together; nan if there were "
        "fewer than 4 periods above rounding and below a hundredth of the range of ``z``"
    )
    periods: tuple[int, int] = quantity("First period used, and the one after the last")

    def __str__(self) -> str:
        first, last = self.periods
        if np.isnan(self.rate):
            return "The distance of two nearby motions left the range in which a rate can be read within 4 periods."
        what = "grew" if self.rate > 0 else "shrank"
        return (
            f"The distance of two nearby motions {what} at {abs(self.rate):.4g} 1/s on average, as seen over periods "
            f"{first + 1} to {last}."
        )


def pushed(scenario: Scenario, start: float, period: float) -> Scenario:
    """The scenario with its force enlarged by 1e-9 of itself for one period.

    Parameters
    ----------
    scenario : Scenario
        It must have a force.
    start, period : float
        When the push begins, and how long it lasts [s].

    Raises
    ------
    InputError
        There is no force, or its formula leaves no room for the push.
    """
    force = scenario.force
    if force.is_zero:
        raise InputError("force.g is zero; a separation is measured with a push of the force, give a force or leave it")
    text = f"({force})*(1 + where(t < {start!r}, 0, where(t < {start + period!r}, {PUSH!r}, 0)))"
    return Scenario(
        force=Expression.parse(text, variables=("t",), field="force.g"),
        body_force=scenario.body_force,
        displacement=scenario.displacement,
        velocity=scenario.velocity,
    )


def separation(first: Array, second: Array, period: float) -> Separation:
    """The rate at which two motions part.

    Parameters
    ----------
    first, second : ndarray
        (R, q) samples of ``z``: ``q`` phases of ``R`` periods [m].
    period : float
        Of the force [s].
    """
    distance = np.abs(second - first).max(axis=1)
    size, level = float(np.ptp(first)), float(np.abs(first).max())
    readable = (distance > max(_NOISE * level, 1e-300)) & (distance < _LARGE * size)
    start = 1  # the push itself lasts one period
    stop = start + int(np.argmin(np.append(readable[start:], False)))
    rate = np.nan
    if stop - start >= _FEWEST:
        rate = float(np.polyfit(np.arange(start, stop), np.log(distance[start:stop]), 1)[0]) / period
    return Separation(distance=distance, rate=rate, periods=(start, stop))

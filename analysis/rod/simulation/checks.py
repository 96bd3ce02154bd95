"""What is refused before a simulation starts, each with the number that is too large and one that is not."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.loads import Loads
from lure.analysis.rod.simulation.ring import Ring
from lure.errors import InputError
from lure.rod.upwind import UpwindScheme

LARGEST_CELLS = 1000
LARGEST_WORK = 2e8
_LARGEST_TABLE = 5e7
_STIFFEST = 1e9
_LARGEST_STATE = 1e100


def check_request(scheme: UpwindScheme, *, until: float, samples: int, frames: int, tolerance: float) -> None:
    """Refuse a run that is not well posed or would take minutes.

    Raises
    ------
    InputError
        With the field, the value and what would do.
    """
    if isinstance(until, bool) or not isinstance(until, int | float) or not 0.0 < until < math.inf:
        raise InputError(f"simulation.until is {until!r}; give a positive number of seconds")
    _check_count("simulation.samples", samples, 2)
    if frames != 0:
        _check_count("simulation.frames", frames, 2)
    if not 1e-12 <= tolerance <= 1e-3:
        raise InputError(f"simulation.tolerance is {tolerance!r}; give a number from 1e-12 to 1e-3")
    N = scheme.cells
    if N > LARGEST_CELLS:
        raise InputError(
            f"simulation.cells is {N}; give at most {LARGEST_CELLS}: every step moves {2 * N} waves and there are "
            f"{scheme.rate:.3g} of them a second, so that a finer grid takes minutes for what a coarser one shows"
        )
    work = 2.0 * N * scheme.rate * until
    if work > LARGEST_WORK:
        fewer = int(math.sqrt(LARGEST_WORK * scheme.rod.travel_time / (2.0 * until)))
        coarser = f", or at most {fewer} cells" if fewer else ""
        raise InputError(
            f"simulation.until is {until:g} s: with {N} cells that is {work:.2g} cell updates, more than "
            f"{LARGEST_WORK:g}; give at most {LARGEST_WORK / (2.0 * N * scheme.rate):.3g} s{coarser}"
        )
    if (samples + frames) * scheme.order > _LARGEST_TABLE:
        most = int(_LARGEST_TABLE / scheme.order)
        raise InputError(
            f"simulation.samples is {samples}; with {N} cells give at most {most} samples and frames together"
        )


def check_motion(ring: Ring, loads: Loads, state: NDArray[np.float64], until: float) -> None:
    """Refuse initial data that are not finite, and contact too stiff for double precision.

    Raises
    ------
    InputError
        With the field, the value and what would do.
    """
    if not np.isfinite(state).all():
        raise InputError(
            "initial.u0 and initial.u1 have no finite value at some grid point; give formulas defined on [0, L]"
        )
    largest = float(np.abs(state).max())
    if largest != 0.0 and not 1.0 / _LARGEST_STATE < largest < _LARGEST_STATE:
        raise InputError(
            f"initial.u0 and initial.u1 start a motion of size {largest:.3g} in SI units, whose energy leaves the "
            f"range of double precision (from {1.0 / _LARGEST_STATE:g} to {_LARGEST_STATE:g}); rescale the units"
        )
    force = np.abs(loads.force_at(np.linspace(0.0, until, 257))).max()
    pressed = float(ring.push(np.maximum(state[-1:] * ring.rate, 0.0))[0])
    speed = max(float(np.abs(state[:-1]).max()), ring.force_gain * float(force), pressed)
    depth = float(ring.penetration(np.array(speed)))
    if speed > _STIFFEST * depth:
        raise InputError(
            f"rod.compliance is {1.0 / ring.stiffness:g}: the obstacle stops an end that moves at {speed:.3g} m/s in "
            f"{depth / speed:.1g} of the time a wave takes for one cell, which double precision cannot follow (limit "
            f"{1.0 / _STIFFEST:g}); give a larger compliance"
        )


def _check_count(field: str, value: object, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= 10**7:
        raise InputError(f"{field} is {value!r}; give a whole number from {least} to 10000000")

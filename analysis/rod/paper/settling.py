"""How long the released rod rings: settling times from closed forms, for the scheme and for the rod itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError
from lure.record import Record, quantity
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.motion import Motion, exact_motion
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario, initial_state
from lure.rod.transfer import RodPlant

PAPER_SETTLING = 1.11e-3
BANDS = (0.05, 0.02)
_PER_TRANSIT = 64

Signal = Callable[[NDArray[np.float64]], NDArray[np.float64]]


class Settling(Record):
    r"""How the released end comes to rest, without force or contact: a slow drift and a ringing.

    ``u(t, L) = rest + drift e^{-t/slow} + ringing(t)``: the drift is the one non-oscillating mode, the ringing is all
    the others.
    """

    cells: int | None = quantity("``N`` of the scheme; None for the rod itself")
    rest: float = quantity("where the released end comes to rest, ``u(inf, L)``", "m", dims="", key="rest_position")
    drift: float = quantity("Coefficient of the non-oscillating mode", "m", key="")
    slow: float = quantity("time constant of the mode that does not oscillate", "s", dims="", key="slow_time_constant")
    fast: float = quantity("time constant of the first oscillating mode", "s", dims="", key="elastic_time_constant")
    band_5: float = quantity(
        "time after which the ringing stays within 5 % of its initial size", "s", dims="", key="settling_time_5_percent"
    )
    band_2: float = quantity(
        "time after which the ringing stays within 2 % of its initial size", "s", dims="", key="settling_time_2_percent"
    )
    left: float = quantity(
        "largest ringing from the paper's 1.11e-3 s on, as a share of the initial one",
        "1",
        dims="",
        key="ringing_left_at_1.11e-3_s",
    )

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data."""
        return {"model": "rod" if self.cells is None else "scheme", **super().to_dict()}


def scheme_settling(rod: Rod, scenario: Scenario, cells: int) -> Settling:
    r"""Settling of the ``N``-cell scheme, from its eigenvectors.

    The ring is f-circulant: with ``gamma_m = (-a)^{1/2N} e^{i pi m/N}`` its eigenvalues are ``s(gamma_m - 1)`` and its
    eigenvectors ``gamma_m^{-j}``, so ``u(t, L) = rest + sum_m w_m e^{lambda_m t}`` at any ``t`` without an integrator.

    ``rod``: ``0 < k < Z``; ``scenario``: initial data, no loads; ``cells``: ``N``.

    Raises
    ------
    AssumptionError
        There is a load, or not ``0 < k < Z``.

    Notes
    -----
    COMPUTED: floating point.  The sum of ``|w_m|`` bounds the ringing after the time searched back from; the last
    crossing before it is located between samples, 64 to a transit.
    """
    _check(rod, scenario)
    scheme = upwind(rod, cells)
    values, weights = _modes(scheme, initial_state(scheme, scenario))
    still = int(np.argmin(np.abs(values)))
    ringing = np.arange(2 * cells) != still

    def signal(t: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is to settle, at the times ``t``."""
        return np.asarray((weights[ringing] * np.exp(np.multiply.outer(t, values[ringing]))).sum(axis=-1).real)

    start = rod.gap + scenario.contact_coordinate(rod)
    fast = -1.0 / float(values[ringing].real.max())
    size, envelope = abs(float(signal(np.zeros(1))[0])), float(np.abs(weights[ringing]).sum())
    band_5, band_2 = (
        _last_outside(signal, band * size, fast * math.log(envelope / (band * size)), rod.travel_time) for band in BANDS
    )
    return Settling(
        cells=cells,
        rest=start - float(weights.sum().real),
        drift=float(weights[still].real),
        slow=-1.0 / float(values[still].real),
        fast=fast,
        band_5=band_5,
        band_2=band_2,
        left=_largest_after(signal, rod) / size,
    )


def rod_settling(rod: Rod, scenario: Scenario) -> Settling:
    r"""Settling of the rod itself, from its exact motion.

    With ``lambda = ln(-a)/2T`` every mode of the rod decays alike: ``u(t, L) = rest + e^{lambda t} q(t)`` with ``q`` of
    period ``2T``; the drift is the mean of ``q``.

    ``rod``: the rod, ``0 < k < Z``.  ``scenario``: initial data; no loads.

    Raises
    ------
    AssumptionError
        There is a load, not ``0 < k < Z``, or the end reaches the obstacle.
    """
    _check(rod, scenario)
    T = rod.travel_time
    decay = RodPlant(rod).log_reflection / (2 * T)
    late = [T * math.ceil(math.log(band) / decay / T + 2) for band in BANDS]  # q has its kinks at multiples of T
    motion = _in_free_flight(rod, scenario, max(late) + 2 * T)
    start, back = motion.end_displacement([0.0, 2 * T])
    rest = float(start + (back - start) / (2 * rod.damping * rod.input_gain))
    nodes, gauss = np.polynomial.legendre.leggauss(8)
    halves = T * np.concatenate((0.5 * (nodes + 1), 0.5 * (nodes + 3)))
    periodic = (motion.end_displacement(halves) - rest) * np.exp(-decay * halves)
    drift = float(0.25 * np.tile(gauss, 2) @ periodic)

    def signal(t: NDArray[np.float64]) -> NDArray[np.float64]:
        """What is to settle, at the times ``t``."""
        return motion.end_displacement(t) - rest - drift * np.exp(decay * t)

    size = abs(float(signal(np.zeros(1))[0]))
    band_5, band_2 = (_last_outside(signal, band * size, end, T) for band, end in zip(BANDS, late, strict=True))
    return Settling(
        cells=None,
        rest=rest,
        drift=drift,
        slow=-1.0 / decay,
        fast=-1.0 / decay,
        band_5=band_5,
        band_2=band_2,
        left=_largest_after(signal, rod) / size,
    )


def _in_free_flight(rod: Rod, scenario: Scenario, until: float) -> Motion:
    """The exact motion, in longer and longer parts: one that touches is not followed for long after."""
    span = 8 * rod.travel_time
    while True:
        motion = exact_motion(rod, scenario, min(span, until))
        if motion.impacts:
            raise AssumptionError(
                f"settling is that of a rod in free flight; its end reaches the obstacle at t = "
                f"{motion.impacts[0].start:.6g} s"
            )
        if span >= until:
            return motion
        span *= 4


def _check(rod: Rod, scenario: Scenario) -> None:
    if not scenario.free:
        raise AssumptionError("settling is that of the released rod; the scenario has a load, give g = 0 and f = 0")
    if not 0 < rod.damping < rod.impedance:
        raise AssumptionError(
            f"settling needs 0 < k < Z for its drifting mode; k = {rod.damping:g}, Z = {rod.impedance:g}"
        )


def _modes(scheme: UpwindScheme, state: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues of the ring and the weight of each in ``z``, for a state in the ordering (39)."""
    N = scheme.cells
    values = scheme.eigenvalues()
    gamma = 1.0 + values / scheme.rate
    shares = gamma[:, None] ** np.arange(2 * N) @ state[:-1] / (2 * N)
    return values, np.asarray(shares * gamma ** (1 - N) / values)


def _last_outside(signal: Signal, level: float, end: float, transit: float) -> float:
    """Last time at which ``|signal| > level``, given that there is none after ``end``; searched backwards."""
    step = transit / _PER_TRANSIT
    while end > 0.0:
        times = np.maximum(end - step * np.arange(_PER_TRANSIT + 1), 0.0)
        outside = np.nonzero(np.abs(signal(times)) > level)[0]
        if outside.size:
            low, high = float(times[outside[0]]), float(times[max(outside[0] - 1, 0)])
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if abs(float(signal(np.array([middle]))[0])) > level else (low, middle)
            return high
        end -= transit
    return 0.0


def _largest_after(signal: Signal, rod: Rod) -> float:
    """Largest ``|signal|`` during one round trip after the paper's settling time; later ones are smaller."""
    step = rod.travel_time / _PER_TRANSIT
    first = math.ceil(PAPER_SETTLING / step)
    times = np.append(PAPER_SETTLING, step * np.arange(first, first + 2 * _PER_TRANSIT + 1))
    return float(np.abs(signal(times)).max())

"""The scheme of the rod as an ordinary differential equation for general integrators, written to be fast in them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lure.rod import Rod, Scenario, initial_state, upwind

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Lines:
    """``N`` cells under ``g = amplitude sin(omega t)``, the waves of each node side by side.

    In the order ``xi2^0, xi1^1, xi2^1, xi1^2 .. xi2^{N-1}, xi1^N, z`` the Jacobian has two bands on either side, which
    a banded solver can use; in the order (39) it has a corner.

    Attributes
    ----------
    rod, cells : Rod, int
        The rod and ``N``.
    amplitude, omega : float
        [N], [rad/s].
    displacement : str
        Initial displacement ``u0(x)``.
    """

    rod: Rod
    cells: int
    amplitude: float
    omega: float
    displacement: str
    calls: list[int] = field(default_factory=lambda: [0])

    @property
    def start(self) -> Array:
        """(2N+1,) the initial state."""
        N = self.cells
        plain = initial_state(upwind(self.rod, N), Scenario.parse(displacement=self.displacement))
        mixed = np.empty_like(plain)
        mixed[0 : 2 * N : 2], mixed[1 : 2 * N : 2], mixed[-1] = plain[2 * N - 1 : N - 1 : -1], plain[:N], plain[-1]
        return mixed

    def slopes(self) -> Callable[[float, Array], Array]:
        """The right-hand side, with its constants at hand: four numpy calls."""
        rod, calls = self.rod, self.calls
        s, a, d, stiffness = (
            rod.wave_speed * self.cells / rod.length,
            rod.reflection,
            rod.mobility,
            1.0 / rod.compliance,
        )
        push, omega, size = 2.0 * s * rod.input_gain * self.amplitude, self.omega, 2 * self.cells + 1

        def slopes(t: float, y: Array) -> Array:
            """Rates of change [1/s of the units of the state]."""
            calls[0] += 1
            out = np.empty(size)
            np.subtract(y[1:-3:2], y[3:-1:2], out=out[3:-1:2])
            np.subtract(y[2:-1:2], y[0:-3:2], out=out[0:-3:2])
            z, last = y[-1], y[-2]
            give = d * stiffness * z if z > 0.0 else 0.0
            out[1] = -a * y[0] - y[1]
            out[-3] = last - 2.0 * give - y[-3]
            out *= s
            out[1] += push * math.sin(omega * t)
            out[-1] = last - give
            return out

        return slopes


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Answer:
    """What an integrator found, and what it took.

    Attributes
    ----------
    z : ndarray
        (k,) contact coordinate at the times asked for [m].
    cpu : float
        Process time [s].
    calls : int
        Evaluations of the right-hand side.
    """

    z: Array
    cpu: float
    calls: int


def measured(lines: Lines, solve: Callable[[], Array]) -> Answer:
    """The answer of an integrator and the process time it took."""
    lines.calls[0] = 0
    before = time.process_time()
    z = solve()
    return Answer(z=z, cpu=time.process_time() - before, calls=lines.calls[0])


def lsoda(lines: Lines, times: Array, tolerance: float) -> Answer:
    """Scipy's ``solve_ivp(method="LSODA")`` as it stands: it takes the Jacobian as full."""
    from scipy.integrate import solve_ivp

    slopes, span = lines.slopes(), (float(times[0]), float(times[-1]))
    options = {"rtol": tolerance, "atol": 1e-3 * tolerance, "t_eval": times}
    return measured(lines, lambda: np.asarray(solve_ivp(slopes, span, lines.start, method="LSODA", **options).y[-1]))


def banded_lsoda(lines: Lines, times: Array, tolerance: float) -> Answer:
    """Scipy's ``odeint``, the same code with less Python around it, told of the two bands on either side."""
    from scipy.integrate import odeint

    options = {"rtol": tolerance, "atol": 1e-3 * tolerance, "mxstep": 10**8, "tfirst": True, "ml": 2, "mu": 2}
    return measured(lines, lambda: np.asarray(odeint(lines.slopes(), lines.start, times, **options)[:, -1]))


def cvode(lines: Lines, times: Array, tolerance: float) -> Answer | None:
    """CVODE of SUNDIALS through scikit-sundae, banded BDF; None if that is not installed."""
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        return None
    slopes = lines.slopes()

    def filled(t: float, y: Array, rates: Array) -> None:
        """Write the rates where CVODE reads them."""
        rates[:] = slopes(t, y)

    options = {"rtol": tolerance, "atol": 1e-3 * tolerance, "max_num_steps": 10**8}
    solver = CVODE(filled, method="BDF", linsolver="band", lband=2, uband=2, **options)
    return measured(lines, lambda: np.asarray(solver.solve(times, lines.start).y[:, -1]))

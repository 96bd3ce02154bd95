"""What an integration of the scheme returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.rod.upwind import UpwindScheme

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class SchemeRun:
    """A motion of the scheme as an integrator gives it; OBSERVED evidence, about the scheme and not about the rod.

    Attributes
    ----------
    scheme : UpwindScheme
        The scheme.
    method : str
        The integrator.
    t, z : ndarray
        (samples,) instants [s] and contact coordinate ``u(t, L) - gap`` [m].
    velocity : ndarray or None
        (samples,) ``z' = v(t, L)`` [m/s]; None if the method does not tell.
    energy : ndarray or None
        (samples,) :func:`lure.analysis.rod.energy.discrete_energy` [J]; None if the method does not tell.
    contacts : tuple of (float, float)
        Beginning and end of every contact [s]; 0 and the end of the run if it began or was cut there.
    state : ndarray or None
        (2N+1,) at the end, in the ordering of the scheme; None if the method does not tell.
    steps, evaluations : int or None
        Time steps, and evaluations of the right-hand side; None where there are none or they are not told.
    cpu_seconds : float
        CPU time of the process [s].
    """

    scheme: UpwindScheme
    method: str
    t: Array
    z: Array
    velocity: Array | None
    energy: Array | None
    contacts: tuple[tuple[float, float], ...]
    state: Array | None
    steps: int | None
    evaluations: int | None
    cpu_seconds: float

    @property
    def u_end(self) -> Array:
        """(samples,) ``u(t, L)`` [m]."""
        return self.z + self.scheme.rod.gap

    def __str__(self) -> str:
        """One sentence."""
        touched = len(self.contacts)
        contact = "no contact" if not touched else "1 contact" if touched == 1 else f"{touched} contacts"
        work = "" if self.evaluations is None else f", {self.evaluations} evaluations"
        return (
            f"scheme of {self.scheme.cells} cells by {self.method} up to {self.t[-1]:.6g} s: {contact}{work}, "
            f"{self.cpu_seconds:.2g} s of CPU"
        )

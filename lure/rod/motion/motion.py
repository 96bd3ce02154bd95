"""The answer: what is known of a motion at any time and place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from lure.errors import InputError
from lure.record import by_value
from lure.rod.motion.chebyshev import Array
from lure.rod.motion.end_law import Boundary
from lure.rod.motion.fields import Fields
from lure.rod.motion.impacts import Impact
from lure.rod.motion.record import Series
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import control
    import xarray


@by_value
@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    r"""A motion of the rod itself, without grid or time step; make one with :func:`exact_motion`.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Loads and initial data.
    boundary : Boundary
        Boundary conditions beyond the paper's.
    until : float
        End of the motion [s].
    since : float
        Start of what was kept [s].
    impacts : tuple of Impact
        In order; the last is not closed if the end still touches the obstacle.
    crossings : int
        Passages between segments of the law.
    energy_residual : float
        Largest ``|work of the waves on the end - loss there - change of A P(z)|`` since the start, relative to the
        largest energy that passed the end in one round trip or was stored in the obstacle.  In the rod and at
        ``x = 0`` the balance ``E' = -k v(t,0)^2 + g v(t,0) + int f v dx`` holds identically for waves that are shifted.
    error : float
        Sum of the estimates of all local errors, as displacement [m].  How the motion enlarges them (impacts may) is
        not in it: compare two values of ``Numerics.degree``.
    note : str
        What the computation put in place of the data, or nothing.
    compiled : bool
        Whether compiled code computed it; see :class:`lure.rod.motion.Numerics`.
    fields : Fields
        The waves as they were kept; :meth:`waves` and the methods beside it read them.
    """

    rod: Rod
    scenario: Scenario
    boundary: Boundary
    until: float
    since: float
    impacts: tuple[Impact, ...]
    crossings: int
    energy_residual: float
    error: float
    note: str
    compiled: bool
    fields: Fields

    def z(self, t: ArrayLike) -> Array:
        """Contact coordinate ``u(t, L) - gap`` [m] at ``since <= t <= until`` [s], elementwise."""
        return self._end(t, "z")

    def end_displacement(self, t: ArrayLike) -> Array:
        """``u(t, L)`` [m], elementwise."""
        return self.z(t) + self.rod.gap

    def end_velocity(self, t: ArrayLike) -> Array:
        """``v(t, L)`` [m/s], elementwise; at a jump the value after it."""
        return 0.5 * (self._end(t, "wave") + self._end(t, "returned"))

    def contact_stress(self, t: ArrayLike) -> Array:
        """``p(z)``, for a rigid obstacle its reaction [Pa], elementwise."""
        return self._end(t, "push") * ((1.0 + self.boundary.end_damping / self.rod.impedance) / self.rod.mobility)

    def dashpot_velocity(self, t: ArrayLike) -> Array:
        """``v(t, 0)`` [m/s], elementwise; times as for :meth:`waves`."""
        times = np.asarray(t, dtype=float)
        return self.velocity(times, np.zeros(times.shape))

    def dashpot_force(self, t: ArrayLike) -> Array:
        """``k v(t, 0)``, what the dashpot holds back [N], elementwise.

        Raises
        ------
        InputError
            The end is clamped: there is no dashpot.
        """
        if self.boundary.clamped:
            raise InputError("the end x = 0 is clamped and has no dashpot force; read the stress from strain(t, 0)")
        return np.asarray(self.rod.damping * self.dashpot_velocity(t))

    def waves(self, t: ArrayLike, x: ArrayLike) -> tuple[Array, Array]:
        """``r1 = v - c w`` and ``r2 = v + c w`` [m/s] at ``(t, x)``, elementwise; from ``since + 2T`` or 0 on.

        Raises
        ------
        InputError
            A point lies outside the rod or the times that are kept.
        """
        return self.fields.waves(np.asarray(t, dtype=float), np.asarray(x, dtype=float))

    def velocity(self, t: ArrayLike, x: ArrayLike) -> Array:
        """``v(t, x)`` [m/s]; arguments and errors as for :meth:`waves`."""
        forward, backward = self.waves(t, x)
        return 0.5 * (forward + backward)

    def strain(self, t: ArrayLike, x: ArrayLike) -> Array:
        """``w = u_x(t, x)`` [-]; arguments and errors as for :meth:`waves`."""
        forward, backward = self.waves(t, x)
        return (backward - forward) / (2.0 * self.rod.wave_speed)

    def displacement(self, t: float, x: ArrayLike) -> Array:
        """``u(t, x)`` [m] at one time and any places, by integrating the strain from ``x = L``."""
        integral = self.fields.integral_to_end(t, np.asarray(x, dtype=float))
        return np.asarray(self.end_displacement(t) - integral)

    def energies(self, t: ArrayLike) -> Array:
        """``E(t) = A int (rho v^2 + E w^2)/2 dx + A P(z)`` [J], elementwise; times and errors as for :meth:`waves`."""
        times = np.asarray(t, dtype=float)
        waves = self.fields.wave_energies(times.ravel()).reshape(times.shape)
        if self._rigid:
            return waves
        law = self.boundary.law or self.rod.law
        return np.asarray(waves + self.rod.area * law.primitive(self.z(times)))

    def energy(self, t: float) -> float:
        """The same at one instant."""
        return float(self.energies(t))

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.rod.motion.sampling import motion_dict

        return motion_dict(self)

    def to_xarray(self, samples: int = 2001, *, places: int = 0) -> xarray.Dataset:
        """The motion at evenly spaced instants, as an ``xarray.Dataset`` with units, signs and every parameter.

        Parameters
        ----------
        samples : int
            Number of instants.  At a jump a sample is the value after it.
        places : int
            Number of places along the rod at which velocity, strain and displacement are kept; 0 for none.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s], ``impact`` (the contacts, of the whole motion) and, if fields were asked for, ``x``
            [m].  The attributes say that it is a motion of the rod itself, COMPUTED, and what its error is.  Above
            20001 samples the energy is left out, since it costs more than all else.

        Raises
        ------
        InputError
            ``samples`` or ``places`` is out of range, or xarray is not installed.
        """
        from lure.rod.motion.sampling import motion_dataset

        return motion_dataset(self, samples, places)

    def to_control(self, samples: int = 2001) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N].

        With a body force or initial data the outputs do not follow from these inputs alone.

        Parameters
        ----------
        samples : int
            Number of instants, evenly spaced.

        Raises
        ------
        InputError
            ``samples`` is out of range.
        """
        from lure.rod.motion.sampling import motion_response

        return motion_response(self, samples)

    def _repr_html_(self) -> str:
        from lure.rod.motion.sampling import motion_html

        return motion_html(self)

    @property
    def _rigid(self) -> bool:
        return self.boundary.rigid or bool(self.note)

    def _end(self, t: ArrayLike, name: Series) -> Array:
        times = np.asarray(t, dtype=float)
        if not np.all((times >= self.since) & (times <= self.until)):
            raise InputError(f"t leaves the motion; give times in [{self.since:g}, {self.until:g}] s")
        return self.fields.at_end(times / self.rod.travel_time, name)

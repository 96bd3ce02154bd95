"""What a Galerkin run returns: coefficients, the end of the rod, energy, and the bound of Lemma 3.2."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from lure.errors import AssumptionError, InputError
from lure.galerkin.model import GalerkinModel
from lure.scenario import Scenario

if TYPE_CHECKING:
    import control
    import xarray

Array = NDArray[np.float64]
Method = Literal["DOP853", "Radau"]
METHODS: tuple[Method, ...] = ("DOP853", "Radau")


@dataclass(frozen=True, kw_only=True, slots=True)
class Touch:
    """One stretch of contact, ``z > 0``.

    Attributes
    ----------
    start, end : float
        [s]; 0 and the end of the run if it began or was cut there.
    """

    start: float
    end: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class GalerkinRun:
    """A motion of ``u_m``, with what the existence proof says of it.

    It is a motion of the semi-discrete problem: OBSERVED evidence about the rod, at best.  That its energy obeys the
    bound of Lemma 3.2 shows that the run is sound, not that it is near the motion of the rod.

    Attributes
    ----------
    model : GalerkinModel
        The rod and the space.
    scenario : Scenario
        Loads and initial data.
    t : ndarray
        (samples,) instants [s].
    states : ndarray
        (samples, 2m+5) rows of ``lure.galerkin.equations.Equations``.
    contacts : tuple of Touch
        Every stretch of contact, in order.
    steps : int
        Time steps taken.
    method : {"DOP853", "Radau"}
        Integrator.
    """

    model: GalerkinModel
    scenario: Scenario
    t: Array
    states: Array
    contacts: tuple[Touch, ...]
    steps: int
    method: Method

    @property
    def coefficients(self) -> Array:
        """(samples, m) ``a``, coefficients of the displacement [m]."""
        return self.states[:, : self.model.space.order]

    @property
    def velocities(self) -> Array:
        """(samples, m) ``b = a'``, coefficients of the velocity [m/s]."""
        return self.states[:, self.model.space.order : 2 * self.model.space.order]

    @property
    def u_end(self) -> Array:
        """(samples,) ``u_m(t, L)`` [m]."""
        return np.asarray(self.coefficients @ self.model.space.right)

    @property
    def z(self) -> Array:
        """(samples,) ``u_m(t, L) - gap`` [m]."""
        return self.u_end - self.model.rod.gap

    @property
    def contact_stress(self) -> Array:
        """(samples,) ``p(z)`` [Pa]."""
        return self.model.rod.law(self.z)

    @property
    def energy(self) -> Array:
        """(samples,) ``E_m`` [J]."""
        return self.model.energy(self.coefficients, self.velocities)

    @property
    def dissipated(self) -> Array:
        """(samples,) ``int_0^t k u_t(s,0)^2 ds``, lost in the dashpot [J]."""
        return self.states[:, -5]

    @property
    def supplied(self) -> Array:
        """(samples,) ``int_0^t (g u_t(s,0) + int f u_t dx) ds``, work of the loads [J]."""
        return self.states[:, -4]

    @property
    def impulse(self) -> Array:
        """(samples,) ``int_0^t A(L) p ds``, given to the obstacle [N s]."""
        return self.states[:, -1]

    @property
    def energy_residual(self) -> float:
        """Largest ``|E_m(t) - E_m(0) + dissipated - supplied|`` over the samples, relative to the largest of these [-].

        The identity is exact for ``u_m``, so this is the error of the time integration alone; 0 if all vanish.
        """
        energy = self.energy
        parts = (energy, self.dissipated, self.supplied)
        size = max(float(np.abs(part).max()) for part in parts)
        return float(np.abs(energy - energy[0] + self.dissipated - self.supplied).max()) / size if size else 0.0

    @property
    def gronwall_bound(self) -> Array | None:
        """(samples,) :meth:`bound` at the lemma's own rate, 1/s [J]; None where :meth:`bound` has none."""
        try:
            return self.bound()
        except AssumptionError:
            return None

    def bound(self, rate: float = 1.0) -> Array:
        r"""The bound of Lemma 3.2 on ``E_m`` along the run, with all constants [J]; ``inf`` above the largest double.

        .. math::

            E_m(t) \le \Big( E_m(0) + \frac{1}{2k} \int_0^t g^2\,ds
                + \frac{1}{2\lambda} \int_0^t\!\!\int_0^L \frac{f^2}{\rho A}\,dx\,ds \Big) e^{\lambda t},
            \qquad \lambda > 0 .

        From ``E_m' = -k v_0^2 + g v_0 + int f u_t``, with ``g v_0 <= g^2/(2k) + k v_0^2/2`` and
        ``int f u_t <= int f^2/(2 lambda rho A) + lambda int rho A u_t^2/2``, and Gronwall's inequality.  The paper
        takes ``E = k = rho = A = 1`` and ``lambda = 1``, which has the unit 1/s.  Hence ``int rho A u_t^2 dx`` and
        ``int A E u_x^2 dx`` are at most **twice** the bound (the paper's last two lines leave out the 2, and the dot).

        Parameters
        ----------
        rate : float
            ``lambda`` [1/s].  Without body force the smaller the better; with it about ``1/t`` serves best at ``t``.

        Raises
        ------
        InputError
            ``rate`` is not a positive finite number.
        AssumptionError
            ``k < 0``, or ``k = 0`` under a force ``g``: energy then enters at a rate no energy bounds.
        """
        if not 0.0 < rate < math.inf:
            raise InputError(f"rate is {rate!r}; give a positive number in 1/s")
        k, force, body = self.model.rod.damping, self.states[:, -3], self.states[:, -2]
        if k < 0 or (k == 0 and force[-1] > 0):
            raise AssumptionError(
                f"the bound of Lemma 3.2 needs k > 0, or k = 0 and no force g; the damping is {k:g} N s/m"
            )
        given = (force / (2.0 * k) if k > 0 else 0.0) + body / (2.0 * rate)
        base = np.asarray(self.energy[0] + given)
        with np.errstate(over="ignore", divide="ignore"):
            return np.asarray(np.exp(np.log(base) + rate * self.t))

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.galerkin.export import run_dict

        return run_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The motion as an ``xarray.Dataset``: the ends, the energy account and all coefficients, with units.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s], ``basis`` (with the coordinate ``node`` [m] for elements) and ``contact``; the
            attributes say that it is OBSERVED and a motion in this space, not of the rod.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.galerkin.export import run_dataset

        return run_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        from lure.galerkin.export import run_response

        return run_response(self)

    def _repr_html_(self) -> str:
        from lure.galerkin.export import run_html

        return run_html(self)

    def __str__(self) -> str:
        """One sentence."""
        space, touched = self.model.space, len(self.contacts)
        contact = "no contact" if not touched else "1 contact" if touched == 1 else f"{touched} contacts"
        return (
            f"Galerkin {space.name} of dimension {space.order} up to {self.t[-1]:.6g} s: {contact}, largest z = "
            f"{self.z.max():.9g} m at the samples, energy identity to {self.energy_residual:.1g}"
        )

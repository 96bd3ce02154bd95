"""What a simulation returns, and in which ways it can contradict what was shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.record import by_value
from lure.rod.upwind import Form, UpwindScheme

if TYPE_CHECKING:
    import control
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]

_TRUSTED_RESIDUAL = 1e-7


@dataclass(frozen=True, kw_only=True, slots=True)
class Contact:
    """One stretch of contact.

    Attributes
    ----------
    start, end : float
        When the end of the rod touched and left the obstacle [s].
    peak_penetration : float
        Largest ``z`` in between, over all instants [m].
    impulse : float
        ``A int p dt`` [N s].
    open : bool
        Whether the run began or ended in this contact, so that it is seen in part only.
    """

    start: float
    end: float
    peak_penetration: float
    impulse: float
    open: bool


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Trajectory:
    r"""A simulated motion of the ``N``-cell scheme, with what holds along it.

    It is OBSERVED evidence: it can contradict a verdict (:func:`contradictions`) and never proves one.  It is a motion
    of the scheme, whose waves lose more energy than the rod's.

    Attributes
    ----------
    scheme : UpwindScheme
        What moved.
    cells, form, damping, loaded
        ``N``, the form of the scheme, ``k`` [N s/m], and whether a load acts.
    t, z, u_end, p : ndarray
        (samples,) instants [s], ``z = u(t,L) - gap`` [m], ``u(t,L)`` [m], contact stress [Pa].
    force : ndarray
        (samples,) the force ``g`` on the end ``x = 0`` [N].
    energy : ndarray
        (samples,) :func:`lure.analysis.rod.energy.discrete_energy` [J].
    zeta : ndarray or None
        (samples,) :func:`lure.analysis.rod.energy.deflated_coordinate` [m]; None for ``k = 0``.
    lyapunov : ndarray or None
        (samples,) :func:`lure.analysis.rod.energy.lyapunov_function` [Pa s]; None for ``k <= 0`` or under load.
    lyapunov_theta : float or None
        Its multiplier ``theta_E`` [s].
    contacts : tuple of Contact
        Every stretch of contact.
    contact : bool
        Whether there was any.
    max_gap_coordinate : float
        Largest ``z`` over all instants, not over samples [m].
    energy_residual : float
        Largest error of the integrated energy identity, ``|E(t) - E(0) + int (dissipation - supply)|``, over the ends
        of all steps, relative to the largest of the energies and of the two integrals.  The integrals are Gauss
        quadratures of the motion with the law and the loads themselves.
    energy_increase, zeta_increase, lyapunov_increase : float or None
        Largest rise between two samples [J], [m], [Pa s], zero if there is none; None where none is forbidden
        (under load, and for ``k < 0``; for ``k = 0`` only the energy is watched).
    energy_allowance, zeta_allowance, lyapunov_allowance : float
        What the arithmetic may be expected to add to those [J], [m], [Pa s].
    bound : float or None
        Largest ``|z|`` that the Lyapunov function allows, given its first value [m].
    rest_position : float or None
        ``zeta`` at the end: where the rod comes to rest if no contact follows [m]; None under load and for ``k <= 0``.
    rest_limit : float or None
        The rod comes to rest at or below this, ``min(0, zeta)``, whatever follows [m].
    rest_is_final : bool
        Whether no contact can follow: the waves left, undamped, do not reach the obstacle.
    event_resolution : float
        How far rounding may have moved a beginning or an end of contact [s]; zero without events.
    error_estimate : float
        Largest difference of ``z`` from a second run with other, shorter steps [m]: observed, not proved.  nan if there
        was none, because the first took too many steps.
    method : str
        How the motion was computed, and how it is known that no contact was missed.
    ended_early : str or None
        Why the run stopped before its end, if it did.
    frames_t, frames_x, frames_r1, frames_r2, frames_v : ndarray
        (frames,), (N+1,) and (frames, N+1): both waves and the velocity in space and time [s], [m], [m/s]; empty unless
        frames were asked for.
    """

    scheme: UpwindScheme
    cells: int
    form: Form
    damping: float
    loaded: bool
    t: Array
    z: Array
    u_end: Array
    p: Array
    force: Array
    energy: Array
    zeta: Array | None
    lyapunov: Array | None
    lyapunov_theta: float | None
    contacts: tuple[Contact, ...]
    max_gap_coordinate: float
    energy_residual: float
    energy_increase: float | None
    zeta_increase: float | None
    lyapunov_increase: float | None
    energy_allowance: float
    zeta_allowance: float
    lyapunov_allowance: float
    bound: float | None
    rest_position: float | None
    rest_limit: float | None
    rest_is_final: bool
    event_resolution: float
    error_estimate: float
    method: str
    ended_early: str | None
    frames_t: Array
    frames_x: Array
    frames_r1: Array
    frames_r2: Array
    frames_v: Array

    @property
    def contact(self) -> bool:
        """Whether the end of the rod touched the obstacle."""
        return bool(self.contacts)

    def __str__(self) -> str:
        """One sentence."""
        touched = len(self.contacts)
        contact = "no contact" if not touched else "1 contact" if touched == 1 else f"{touched} contacts"
        return (
            f"scheme of {self.cells} cells up to {self.t[-1]:.6g} s: {contact}, largest z = "
            f"{self.max_gap_coordinate:.9g} m (+/- {self.error_estimate:.1g} m), energy identity to "
            f"{self.energy_residual:.1g}"
        )

    def to_dict(self) -> dict[str, object]:
        """What is said of the motion as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.analysis.rod.simulation.export import trajectory_dict

        return trajectory_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The motion as an ``xarray.Dataset`` with units, signs and every parameter.

        Returns
        -------
        xarray.Dataset
            Dimensions ``t`` [s], ``contact`` and, if frames were kept, ``frame`` [s] and ``x`` [m]; the attributes say
            that it is OBSERVED and a motion of the scheme, not of the rod.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.simulation.export import trajectory_dataset

        return trajectory_dataset(self)

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        from lure.analysis.rod.simulation.export import trajectory_response

        return trajectory_response(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The end of the rod; see :func:`lure.analysis.plots.plot_end_motion`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_motion import plot_end_motion

        return plot_end_motion(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.simulation.export import trajectory_html

        return trajectory_html(self)


def contradictions(trajectory: Trajectory) -> tuple[str, ...]:
    r"""Sentences for the ways in which a run contradicts what was shown of the scheme.

    Without loads and for ``k > 0`` the energy, ``zeta`` and the Popov-Lyapunov function never rise, the latter bounds
    ``z`` for ever, and a motion that has come to rest has ``z <= 0``.  Under loads, and for ``k < 0``, only the energy
    identity is left to check; for ``k = 0`` also the energy.

    Parameters
    ----------
    trajectory : Trajectory
        A simulation.

    Returns
    -------
    tuple of str
        Empty if nothing contradicts, which proves nothing.
    """
    found = []
    watched = (
        ("energy", trajectory.energy_increase, trajectory.energy_allowance, "J"),
        ("deflated coordinate zeta", trajectory.zeta_increase, trajectory.zeta_allowance, "m"),
        ("Popov-Lyapunov function", trajectory.lyapunov_increase, trajectory.lyapunov_allowance, "Pa s"),
    )
    for name, rise, allowance, unit in watched:
        if rise is not None and not rise <= allowance:
            found.append(
                f"the {name} rises by {rise:.3g} {unit} between two samples, where it must not; rounding explains "
                f"{allowance:.1g} {unit}"
            )
    if not trajectory.energy_residual <= _TRUSTED_RESIDUAL:
        found.append(
            f"the energy identity is off by {trajectory.energy_residual:.2g} of the energies, more than "
            f"{_TRUSTED_RESIDUAL:g}: the run cannot be trusted"
        )
    largest = float(np.abs(trajectory.z).max())
    if trajectory.bound is not None and not largest <= trajectory.bound * (1.0 + 1e-9):
        found.append(
            f"|z| reaches {largest:.6g} m, above the bound {trajectory.bound:.6g} m of the Popov-Lyapunov function"
        )
    rest = trajectory.rest_position
    if rest is not None and trajectory.rest_is_final and not rest <= trajectory.zeta_allowance:
        found.append(f"the rod comes to rest at z = {rest:.6g} m, inside the obstacle")
    if trajectory.ended_early is not None and trajectory.bound is not None:
        found.append(f"the run ended early, though the motion is bounded: {trajectory.ended_early}")
    return tuple(found)

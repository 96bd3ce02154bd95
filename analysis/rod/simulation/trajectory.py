"""What a simulation returns, in which ways it can contradict what was shown, and what it was held against."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lure.analysis.drawing import drawn
from lure.arrays import Reals as Array
from lure.plants.multivariable import counted
from lure.record import Column, Page, quantity
from lure.rod import datasets
from lure.rod.datasets import SERIES, STRESS, Contact, number_of_contacts
from lure.rod.discretisation import Form
from lure.rod.scheme.motion import SchemeMotion

if TYPE_CHECKING:
    import control


_TRUSTED_RESIDUAL = 1e-7
_NUMBERS = (
    "max_gap_coordinate",
    "energy_residual",
    "energy_increase",
    "zeta_increase",
    "lyapunov_increase",
    "lyapunov_theta",
    "bound",
    "rest_position",
    "rest_limit",
    "event_resolution",
    "error_estimate",
)


class Trajectory(SchemeMotion):
    r"""A simulated motion of the ``N``-cell scheme, with what holds along it.

    It is OBSERVED evidence: it can contradict a verdict (:func:`contradictions`) and never proves one.  It is a motion
    of the scheme, whose waves lose more energy than the rod's.
    """

    _heading: ClassVar[str] = "Simulated motion of the upwind scheme"

    cells: int = quantity("``N``")
    form: Form = quantity("The form of the scheme")
    damping: float = quantity("``k``", "N s m-1", key="")
    loaded: bool = quantity("Whether a load acts")
    z: Array = quantity(*SERIES["z"], dims="t")
    u_end: Array = quantity(*SERIES["u_end"], dims="t")
    p: Array = quantity(*SERIES["stress"], dims="t", name=STRESS)
    force: Array = quantity("force g on the end x = 0, positive along x", "N", dims="t")
    energy: Array = quantity(*SERIES["energy"], dims="t")
    zeta: Array | None = quantity(
        "deflated coordinate, constant in free flight without load; None for ``k = 0``", "m", dims="t"
    )
    lyapunov: Array | None = quantity(
        "Popov-Lyapunov function with the multiplier lyapunov_theta; None for ``k <= 0`` or under load",
        "Pa s",
        dims="t",
    )
    lyapunov_theta: float | None = quantity("Its multiplier ``theta_E``", "s")
    contacts: tuple[Contact, ...] = quantity("Every stretch of contact", dims="contact", name="contact_", each=Contact)
    max_gap_coordinate: float = quantity("Largest ``z`` over all instants, not over samples", "m")
    energy_residual: float = quantity(
        "Largest error of the integrated energy identity, ``|E(t) - E(0) + int (dissipation - supply)|``, over the "
        "ends of all steps, relative to the largest of the energies and of the two integrals.  The integrals are Gauss "
        "quadratures of the motion with the nonlinearity and the loads themselves"
    )
    energy_increase: float | None = quantity(
        "Largest rise of the energy between two samples [J], zero if there is none; None where none is forbidden "
        "(under load, and for ``k < 0``; for ``k = 0`` only the energy is watched)"
    )
    zeta_increase: float | None = quantity("The same of ``zeta``", "m")
    lyapunov_increase: float | None = quantity("The same of the Popov-Lyapunov function", "Pa s")
    energy_allowance: float = quantity("What the arithmetic may be expected to add to the energy", "J", key="")
    zeta_allowance: float = quantity("The same for ``zeta``", "m", key="")
    lyapunov_allowance: float = quantity("The same for the Popov-Lyapunov function", "Pa s", key="")
    bound: float | None = quantity("Largest ``|z|`` that the Lyapunov function allows, given its first value", "m")
    rest_position: float | None = quantity(
        "``zeta`` at the end: where the rod comes to rest if no contact follows [m]; None under load and for ``k <= 0``"
    )
    rest_limit: float | None = quantity(
        "The rod comes to rest at or below this, ``min(0, zeta)``, whatever follows", "m"
    )
    rest_is_final: bool = quantity("Whether no contact can follow: the waves left, undamped, do not reach the obstacle")
    event_resolution: float = quantity(
        "How far rounding may have moved a beginning or an end of contact [s]; zero without events"
    )
    error_estimate: float = quantity(
        "Largest difference of ``z`` from a second run with other, shorter steps [m]: observed, not proved.  nan if "
        "there was none, because the first took too many steps"
    )
    method: str = quantity("How the motion was computed, and how it is known that no contact was missed")
    ended_early: str | None = quantity("Why the run stopped before its end, if it did")
    frames_t: Array = quantity("time of a frame; none unless frames were asked for", "s", dims="frame", name="frame")
    frames_x: Array = quantity(datasets.PLACE, "m", dims="x", name="x")
    frames_r1: Array = quantity("forward wave ``r1 = v - c w``", "m s-1", dims="frame x", name="r1")
    frames_r2: Array = quantity("backward wave ``r2 = v + c w``", "m s-1", dims="frame x", name="r2")
    frames_v: Array = quantity("velocity, positive along x", "m s-1", dims="frame x", name="v")

    @property
    def contact(self) -> bool:
        """Whether the end of the rod touched the obstacle."""
        return bool(self.contacts)

    def __str__(self) -> str:
        """One sentence."""
        contact = number_of_contacts(len(self.contacts))
        return (
            f"scheme of {counted(self.cells, 'cell')} up to {self.t[-1]:.6g} s: {contact}, largest z = "
            f"{self.max_gap_coordinate:.9g} m (+/- {self.error_estimate:.1g} m), energy identity to "
            f"{self.energy_residual:.1g}"
        )

    @property
    def how(self) -> str:
        """How the motion was computed."""
        return self.method

    def _columns(self) -> dict[str, Column]:
        found = super()._columns()
        return found if self.frames_t.size else {k: v for k, v in found.items() if not {"frame", "x"} & {*v.dims}}

    def _attributes(self) -> dict[str, object]:
        numbers = {name: getattr(self, name) for name in _NUMBERS}
        known = {name: value for name, value in numbers.items() if value is not None}
        return {**super()._attributes(), **known, "loaded": int(self.loaded)} | (
            {"ended_early": self.ended_early} if self.ended_early else {}
        )

    def to_control(self) -> control.TimeResponseData:
        """The motion as python-control has it: output ``sigma = z`` [m], inputs ``mu = -p(z)`` [Pa] and ``g`` [N]."""
        return datasets.loop_response(f"the scheme, N = {self.cells}", self.t, self.z, self.p, self.force)

    def _page(self) -> Page:
        against = contradictions(self)
        rows: list[tuple[str, object]] = [
            ("what moved", self.about),
            ("time", f"0 s to {self.t[-1]:g} s, {self.t.size} samples" + (", under load" if self.loaded else "")),
            ("contacts", len(self.contacts) or "none"),
            ("largest z", f"{self.max_gap_coordinate:.9g} m, over all instants"),
            ("error of z", f"{self.error_estimate:.1g} m, the difference from a second run with shorter steps"),
            ("energy identity", f"relative residual {self.energy_residual:.1g}"),
        ]
        if self.rest_limit is not None:
            final = (
                f"at z = {self.rest_position:.9g} m" if self.rest_is_final else f"at some z <= {self.rest_limit:.6g} m"
            )
            rows.append(("comes to rest", final))
        if self.ended_early:
            rows.append(("ended early", self.ended_early))
        rows.append(("against what was shown", "; ".join(against) or "nothing contradicts, which proves nothing"))
        title = f"simulated motion of the scheme, N = {self.cells}"
        return Page(title, rows, verdict="OBSERVED", notes=(self.comment,))

    plot = drawn("The end of the rod; see :func:`lure.analysis.rod.plots.plot_end_motion`.")


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


def compared(run: Trajectory) -> tuple[str, ...]:
    """What the simulated motion was held against; empty for a rod that stays at rest, which tests nothing.

    Without load and with ``k > 0`` the Popov-Lyapunov function and zeta have to fall and the resting place to follow;
    else only the energy identity is compared.
    """
    if not run.energy.any():
        return ()
    balance = "energy identity"
    return (balance,) if run.lyapunov is None else (balance, "Popov-Lyapunov function", "zeta", "resting place")

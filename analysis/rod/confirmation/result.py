"""What two motions, that of the rod and that of its scheme, say of what was shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]
Kind = Literal["decay", "undamped", "growth", "load"]

AGREEMENT = 1e-9


@dataclass(frozen=True, kw_only=True, slots=True)
class Quantity:
    """Something that must not rise (or, for the energy of a rod with ``k < 0``, not fall) along a motion.

    Attributes
    ----------
    start, end : float
        Its first and its last value.
    against : float
        Largest step between two samples in the direction in which it must not go, zero if there is none, relative to
        ``scale``.
    allowance : float
        What the arithmetic may be expected to add to that, relative to ``scale``.
    scale : float
        Its largest size.
    """

    start: float
    end: float
    against: float
    allowance: float
    scale: float

    @property
    def holds(self) -> bool:
        """Whether it goes nowhere it must not, up to rounding."""
        return self.against <= self.allowance


@dataclass(frozen=True, kw_only=True, slots=True)
class Rest:
    """A resting place that was predicted, and what the motion shows.

    Attributes
    ----------
    predicted : float
        From the initial data and the impulses of the contacts alone, ``zeta(0) - (1/k) sum of impulses`` [m].
    shown : float
        ``z`` of the motion when its ringing has decayed [m].
    at : float
        When [s].
    way : str
        How the motion was continued to then.
    difference : float
        ``|predicted - shown|``, relative to the scale.
    allowance : float
        What the arithmetic may be expected to add to that, relative to the scale.
    scale : float
        Largest ``|z|`` along the motion or at rest [m].
    """

    predicted: float
    shown: float
    at: float
    way: str
    difference: float
    allowance: float
    scale: float

    @property
    def agrees(self) -> bool:
        """Whether the two agree to 1e-9."""
        return self.difference <= AGREEMENT


@dataclass(frozen=True, kw_only=True, slots=True)
class Curves:
    """One motion, sampled, for figures: instants [s] and values; None for what is not defined."""

    t: Array
    z: Array
    zeta: Array | None
    energy: Array | None
    lyapunov: Array | None


@dataclass(frozen=True, kw_only=True, slots=True)
class Side:
    """One of the two motions.

    Attributes
    ----------
    model : str
        ``"rod"`` or ``"scheme, N = .."``.
    until : float
        How far it was followed [s].
    contacts : int
        Number of contacts until then.
    highest : float
        Largest ``z`` over all instants until then [m].
    energy_residual : float
        Largest error of the energy balance, relative to the largest energy that passed.
    energy, lyapunov, zeta : Quantity or None
        What must not rise; None where nothing is claimed.
    lyapunov_theta : float or None
        Multiplier of the Lyapunov function [s].
    momentum : float or None
        Largest ``|zeta(t) - zeta(0) + (1/k) int A p|``, relative to the largest ``|z|`` or ``|zeta|``: whether ``zeta``
        is constant in free flight and falls by the impulse over ``k`` in a contact.
    rest : Rest or None
        The resting place; None if none is claimed or none was reached.
    open_end : str or None
        Why there is no resting place, or why the motion was not followed to the end.
    curves : Curves
        The motion, for figures.
    """

    model: str
    until: float
    contacts: int
    highest: float
    energy_residual: float
    energy: Quantity | None
    lyapunov: Quantity | None
    lyapunov_theta: float | None
    zeta: Quantity | None
    momentum: float | None
    rest: Rest | None
    open_end: str | None
    curves: Curves


@dataclass(frozen=True, kw_only=True, slots=True)
class Confirmation:
    """Two motions from the same data side by side; OBSERVED, it can contradict a verdict and never proves one.

    Attributes
    ----------
    kind : {"decay", "undamped", "growth", "load"}
        What is confirmed: ``k > 0``, ``k = 0`` or ``k < 0`` without loads; or a motion under load.
    rod, scheme : Side or None
        The two motions; None if there is none.
    rod_skipped, scheme_skipped : str or None
        Why.
    contradictions : tuple of str
        Ways in which the motion of the rod, or a resting place, contradicts what was shown, beyond rounding.
    """

    kind: Kind
    rod: Side | None
    scheme: Side | None
    rod_skipped: str | None
    scheme_skipped: str | None
    contradictions: tuple[str, ...]

    @property
    def compared(self) -> tuple[str, ...]:
        """What the motion of the rod was held against, and passed; empty for a rod that stays at rest."""
        if self.rod is None or not self.rod.curves.z.size or self._still:
            return ()
        found = ["energy balance"]
        for name, quantity in (
            ("energy", self.rod.energy),
            ("Lyapunov functional", self.rod.lyapunov),
            ("zeta", self.rod.zeta),
        ):
            found += [name] if quantity is not None else []
        return (*found, "resting place") if self.rod.rest is not None else tuple(found)

    @property
    def agrees(self) -> bool | None:
        """Whether the motion of the rod bears out all that it was held against; None where that is nothing."""
        if self.contradictions:
            return False
        return True if self.compared else None

    @property
    def _still(self) -> bool:
        return self.rod is not None and self.rod.energy is not None and self.rod.energy.scale == 0.0

    def to_dict(self) -> dict[str, object]:
        """What is said of the two motions as plain JSON data; the curves are in :meth:`to_xarray`."""
        from lure.analysis.rod.confirmation.export import confirmation_dict

        return confirmation_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The curves of both motions as an ``xarray.Dataset``, each along a time of its own [s], with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.confirmation.export import confirmation_dataset

        return confirmation_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """The contact coordinate of both; see :func:`lure.analysis.plots.plot_both_ends`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_comparison import plot_both_ends

        return plot_both_ends(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.confirmation.export import confirmation_html

        return confirmation_html(self)

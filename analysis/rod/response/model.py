"""The answer to a long run."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.response.plan import Plan, Settling
from lure.analysis.rod.response.regime import Regime, Transients
from lure.analysis.rod.response.separation import Separation
from lure.analysis.rod.response.statistics import Balance, Impulses, Spectrum
from lure.analysis.verdict import Evidence
from lure.record import by_value
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.style import Axes

Array = NDArray[np.float64]
_HARMONICS = 9


@by_value
@dataclass(frozen=True, kw_only=True, eq=False)
class Response:
    """What a rod does under a periodic load after a while; make one with :func:`response`.

    Its numbers are those of the rod itself, not of a scheme, and of one motion: other initial data may lead elsewhere,
    and what follows the watch was not computed.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Loads and initial data.
    plan : Plan
        What was asked for.
    period : float
        Period of the loads that ``multiple`` counts in [s]; a multiple of the least one, perhaps.
    period_source : {"formula", "given", "constant load"}
        Proved from the formula, the user's word, or the round trip ``2T`` in place of a period.
    settling : Settling
        How long was waited.
    regime : Regime
        The kind of motion seen.
    transients : Transients
        Whether it was still changing.
    t, z, v : ndarray
        (n+1,) samples of the watch: time [s], contact coordinate [m], velocity ``z'`` [m/s].
    poincare : ndarray
        (R+1, 2) points ``(z, z')`` at whole periods of the load [m, m/s].
    contacts : tuple of (float, float)
        Intervals of contact, cut to the watch [s].
    impact_impulses : ndarray
        (j,) ``A int p dt`` of each contact that begins during the watch and ends [N s].
    duty : float
        Share of the watch in contact [-].
    impulses : Impulses
        Statistics of the impacts.
    balance : Balance or None
        Momentum per period; None with a body force, a clamped end, or a watch that begins within one transit.
    spectrum : Spectrum
        Amplitudes of ``z``.
    separation : Separation or None
        How two nearby motions part, if asked for.
    energy_residual, error : float
        Of the motion, see :class:`lure.rod.motion.Motion`.
    """

    rod: Rod
    scenario: Scenario
    plan: Plan
    period: float
    period_source: str
    settling: Settling
    regime: Regime
    transients: Transients
    t: Array
    z: Array
    v: Array
    poincare: Array
    contacts: tuple[tuple[float, float], ...]
    impact_impulses: Array
    duty: float
    impulses: Impulses
    balance: Balance | None
    spectrum: Spectrum
    separation: Separation | None
    energy_residual: float
    error: float

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: a motion followed for a finite time."""
        return Evidence.OBSERVED

    @property
    def harmonics(self) -> tuple[float, ...]:
        """Amplitudes of ``z`` at 0, 1, .., 8 times the frequency of the load [m]."""
        return tuple(self.spectrum.harmonic(order, self.period) for order in range(_HARMONICS))

    def __str__(self) -> str:
        said = [
            f"Rod under g = {self.scenario.force}: period {self.period:.6g} s ({self.period_source}).",
            str(self.settling),
            str(self.regime),
            str(self.transients),
            self._touching(),
        ]
        if self.balance is not None:
            said.append(
                f"Momentum per period: force {self.balance.force:.6g}, contact {self.balance.contact:.6g}, dashpot "
                f"{self.balance.dashpot:.6g}, left over {self.balance.left:.3g} N s."
            )
        if self.separation is not None:
            said.append(str(self.separation))
        said.append(
            f"Evidence: {self.evidence}; one exact motion of the rod from one start, watched for a finite time."
        )
        return "\n".join(said)

    def _touching(self) -> str:
        hits = self.impulses
        if not self.contacts:
            return "No contact during the watch."
        often = "1 impact" if hits.per_period == 1 else f"{hits.per_period:.4g} impacts"
        said = f"In contact {100.0 * self.duty:.4g} % of the time, {often} a period"
        if hits.count > hits.unfinished:
            said += f", impulse {hits.least:.4g} to {hits.largest:.4g} N s (mean {hits.mean:.4g})"
        return said + (f", peak stress {hits.peak_stress:.4g} Pa." if hits.count else ".")

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON: numbers with their units in the names, None for what is not finite."""
        regime, hits, settled = self.regime, self.impulses, self.settling
        return {
            "force": str(self.scenario.force),
            "period_s": self.period,
            "period_source": self.period_source,
            "settle_s": settled.time,
            "settle_periods": settled.periods,
            "wave_time_constant_s": plain(settled.wave_time),
            "contact_time_constant_s": settled.contact_time,
            "settle_note": settled.note,
            "watched_periods": len(self.poincare) - 1,
            "regime": regime.kind,
            "multiple": regime.multiple,
            "mismatch": regime.mismatch,
            "periods_seen": regime.seen,
            "range_m": regime.range,
            "drift_m_per_period": regime.step,
            "transients": self.transients.trend,
            "contact_duty": self.duty,
            "impacts_per_period": hits.per_period,
            "impacts": hits.count,
            "impulse_mean_Ns": plain(hits.mean),
            "impulse_deviation_Ns": plain(hits.deviation),
            "impulse_least_Ns": plain(hits.least),
            "impulse_largest_Ns": plain(hits.largest),
            "peak_stress_Pa": hits.peak_stress,
            "momentum_per_period_Ns": None
            if self.balance is None
            else {
                "force": self.balance.force,
                "contact": self.balance.contact,
                "dashpot": self.balance.dashpot,
                "left": self.balance.left,
            },
            "harmonics_m": [plain(value) for value in self.harmonics],
            "separation_rate_per_s": None if self.separation is None else plain(self.separation.rate),
            "poincare": self.poincare.tolist(),
            "energy_residual": self.energy_residual,
            "error_m": self.error,
            "evidence": str(self.evidence),
        }

    def to_xarray(self) -> xarray.Dataset:
        """Samples, stroboscopic points, spectrum and contacts as an ``xarray.Dataset`` with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.response.export import response_dataset

        return response_dataset(self)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """History, stroboscopic points, spectrum and impulses; see :func:`lure.analysis.plots.plot_response`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.rod_response import plot_response

        return plot_response(self, ax=ax)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.response.export import response_html

        return response_html(self)


def plain(value: float) -> float | None:
    """A number for JSON; None in place of nan and infinity."""
    return value if math.isfinite(value) else None

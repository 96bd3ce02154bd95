"""How fast the first elastic modes decay in flight: in the rod, in its scheme, in a Galerkin space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.spectrum import wave_mode
from lure.rod.galerkin import GalerkinModel
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Array = NDArray[np.float64]
ModeDecay = tuple[float | None, ...]

MODES = 3
LARGEST_DENSE = 400
_PER_TRANSIT = 64


def wave_decay(rod: Rod, cells: int | None) -> ModeDecay:
    """Decay rates ``-Re`` of the modes 1, 2, 3 of the rod or of its scheme, in closed form [1/s].

    For the rod ``-ln|a|/(2T)``, the same for all; for ``k = Z`` there are no modes (None), and in the scheme all decay
    at its own rate ``s``.

    Parameters
    ----------
    rod : Rod
        The rod.
    cells : int or None
        ``N`` of the scheme; None for the rod itself.
    """
    if rod.reflection == 0.0:
        rate = None if cells is None else rod.wave_speed * cells / rod.length
        return (rate,) * MODES
    return tuple(
        0.0 - wave_mode(rod, m, cells).real if cells is None or m <= cells else None for m in range(1, MODES + 1)
    )


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class GalerkinModes:
    """Free flight of a Galerkin model as a sum of modes, ``u(t, L) = Re sum_j w_j e^{lambda_j t}``.

    Attributes
    ----------
    values, weights : ndarray
        (2m,) eigenvalues of ``M lambda^2 + C lambda + K`` [1/s] and weights of the initial data [m].
    """

    values: NDArray[np.complex128]
    weights: NDArray[np.complex128]

    @property
    def oscillating(self) -> NDArray[np.bool_]:
        """Which of them oscillate."""
        return np.asarray(np.abs(self.values.imag) > 1e-6 * np.abs(self.values).max())

    @property
    def decay(self) -> ModeDecay:
        """Decay rates of the first three elastic modes, by frequency [1/s]; None where there are fewer."""
        found = sorted((value for value in self.values[self.oscillating] if value.imag > 0), key=lambda v: v.imag)
        rates: list[float | None] = [0.0 - float(value.real) for value in found[:MODES]]
        return (*rates, *[None] * (MODES - len(rates)))

    def ringing_left(self, since: float, rod: Rod) -> float:
        """Largest ringing in the round trip from ``since`` [s] on, as a share of the initial one [-]."""
        ringing = self.oscillating
        values, weights = self.values[ringing], self.weights[ringing]
        step = rod.travel_time / _PER_TRANSIT
        times = since + step * np.arange(2 * _PER_TRANSIT + 1)
        signal = (weights * np.exp(np.multiply.outer(np.append(0.0, times), values))).sum(axis=-1).real
        return float(np.abs(signal[1:]).max() / abs(signal[0]))


def galerkin_modes(model: GalerkinModel, scenario: Scenario) -> GalerkinModes | None:
    """Modes of a Galerkin model from its matrices, by a dense solver; None above 400 dimensions.

    Parameters
    ----------
    model : GalerkinModel
        The matrices.
    scenario : Scenario
        Initial data; its loads do not count.
    """
    m = model.space.order
    if m > LARGEST_DENSE:
        return None
    from scipy.linalg import eig

    step = np.zeros((2 * m, 2 * m))
    step[:m, m:] = np.eye(m)
    step[m:, :m] = -model.solve_mass(model.stiffness.toarray())
    step[m:, m:] = -model.solve_mass(model.damping.toarray())
    values, vectors = eig(step)
    start = np.concatenate(model.project(scenario.displacement, scenario.velocity))
    shares = np.linalg.solve(vectors, start.astype(complex))
    return GalerkinModes(values=np.asarray(values), weights=np.asarray((model.space.right @ vectors[:m]) * shares))

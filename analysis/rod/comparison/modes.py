"""How fast the first elastic modes decay in flight, and what that makes of the paper's settling time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.paper.settling import PAPER_SETTLING, Settling
from lure.analysis.rod.spectrum import wave_mode
from lure.record import Record, described, quantity
from lure.rod.galerkin import GalerkinModel
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.systems import builtin_system

ModeDecay = tuple[float | None, ...]

MODES = 3
LARGEST_DENSE = 400
_PER_TRANSIT = 64
COARSE = 10
_SETTLED, _RINGS = 0.05, 0.9


def wave_decay(rod: Rod, cells: int | None) -> ModeDecay:
    """Decay rates ``-Re`` of the modes 1, 2, 3 of the rod or of its scheme, in closed form [1/s].

    For the rod ``-ln|a|/(2T)``, the same for all; for ``k = Z`` there are no modes (None), and in the scheme all decay
    at its own rate ``s``.

    ``cells``: ``N`` of the scheme; None for the rod itself.
    """
    if rod.reflection == 0.0:
        rate = None if cells is None else rod.wave_speed * cells / rod.length
        return (rate,) * MODES
    return tuple(
        0.0 - wave_mode(rod, m, cells).real if cells is None or m <= cells else None for m in range(1, MODES + 1)
    )


@described(frozen=True, kw_only=True, slots=True, eq=False)
class GalerkinModes:
    """Free flight of a Galerkin model as a sum of modes, ``u(t, L) = Re sum_j w_j e^{lambda_j t}``."""

    values: NDArray[np.complex128] = quantity("(2m,) eigenvalues of ``M lambda^2 + C lambda + K`` [1/s]")
    weights: NDArray[np.complex128] = quantity("(2m,) weights of the initial data", "m")

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

    ``scenario``: initial data; its loads do not count.
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


class SettlingRow(Record):
    """How one method lets the released end come to rest."""

    method: str = quantity("The method, with its size")
    band_5: float | None = quantity(
        "Time after which the ringing stays within 5 % of its initial size; None where it was not computed", "s"
    )
    fast: float | None = quantity("Time constant of the first elastic mode", "s")
    left: float = quantity("Largest ringing from the paper's ``t = 1.11e-3 s`` on, as a share of the initial one [-]")


def from_closed_form(method: str, settling: Settling) -> SettlingRow:
    """A row of the rod or of a scheme."""
    return SettlingRow(method=method, band_5=settling.band_5, fast=settling.fast, left=settling.left)


def from_modes(method: str, modes: GalerkinModes, rod: Rod) -> SettlingRow:
    """A row of a Galerkin model."""
    slowest = modes.decay[0]
    return SettlingRow(
        method=method,
        band_5=None,
        fast=1.0 / slowest if slowest else None,
        left=modes.ringing_left(PAPER_SETTLING, rod),
    )


def is_the_papers(rod: Rod, scenario: Scenario) -> bool:
    """Whether this is the release of the paper's figures 6 and 7, whatever the obstacle is made of."""
    paper = builtin_system("paper-rod")
    same = ("youngs_modulus", "density", "length", "area", "damping")
    return (
        all(rod.exact[name] == paper.rod.exact[name] for name in same)
        and scenario.free
        and scenario.displacement.tree == paper.scenario.displacement.tree
        and scenario.velocity.is_zero
    )


def verdict(rod_left: float, schemes: dict[int, float]) -> str:
    """What the numbers of this run show of the paper's claim, in one or two sentences.

    ``rod_left``: share of the ringing that the rod keeps at the paper's settling time; ``schemes``: the same for every
    number of cells.
    """
    if not schemes:
        return "No scheme was run, so nothing is said about the settling time of the paper."
    coarse, fine = min(schemes), max(schemes)
    kept = ", ".join(f"{100 * left:.3g} % with N = {cells}" for cells, left in sorted(schemes.items()))
    numbers = f"{kept}, and {100 * rod_left:.4g} % in the rod itself"
    if not (coarse <= COARSE and schemes[coarse] < _SETTLED and rod_left > _RINGS):
        return f"At the paper's settling time, {PAPER_SETTLING:g} s, this much of the ringing is left: {numbers}."
    said = f"The settling time of the paper is numerical dissipation: at t = {PAPER_SETTLING:g} s there is left of the "
    said += f"ringing {numbers}."
    if schemes[fine] > 2.0 * schemes[coarse]:
        said += f" That h = 1/{fine} gives the same as h = 1/{coarse} is refuted by these numbers."
    return said

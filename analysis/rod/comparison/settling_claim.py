"""The paper's settling time, held against every method: whether it is a property of the rod or of its scheme."""

from __future__ import annotations

from lure.analysis.rod.comparison.modes import GalerkinModes
from lure.analysis.rod.paper.settling import PAPER_SETTLING, Settling
from lure.record import Record, quantity
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.systems import builtin_system

COARSE = 10
_SETTLED, _RINGS = 0.05, 0.9


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

    Parameters
    ----------
    rod_left : float
        Share of the ringing that the rod keeps at the paper's settling time.
    schemes : dict of int to float
        The same for every number of cells.
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

"""What a reproduction of the paper consists of: claims, peaks of the forced figures, settling times."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from lure.analysis.rod.paper.settling import Settling
from lure.analysis.verdict import Evidence
from lure.rod.upwind import Form

if TYPE_CHECKING:
    import xarray

SCHEMA = "lure-paper/1"
_WIDTH = 112
Variant = Literal[
    "as-printed",
    "as-printed-200",
    "corrected",
    "corrected-200",
    "corrected-rescaled",
    "corrected-rescaled-200",
    "rod",
    "rod-rescaled",
]
TITLES: dict[Variant, str] = {
    "as-printed": "scheme as printed, N = 10",
    "as-printed-200": "scheme as printed, N = 200",
    "corrected": "scheme corrected, N = 10",
    "corrected-200": "scheme corrected, N = 200",
    "corrected-rescaled": "scheme corrected, N = 10, force / 60000",
    "corrected-rescaled-200": "scheme corrected, N = 200, force / 60000",
    "rod": "the rod itself",
    "rod-rescaled": "the rod itself, force / 60000",
}


@dataclass(frozen=True, kw_only=True, slots=True)
class Peak:
    """How far the end of the rod gets in figure 8, 9 or 10, in one variant.

    Attributes
    ----------
    figure : int
        8, 9 or 10.
    variant : str
        ``as-printed`` drops the factor ``s`` from the force; ``rescaled`` divides the force by ``c 10/L = 60000 1/s``.
    cells : int or None
        ``N``; None for the rod itself.
    form : {"corrected", "as-printed"} or None
        Form of the scheme; None for the rod itself.
    amplitude : float
        Amplitude of the force [N].
    largest_z : float
        Largest ``z = u(t, L) - gap`` on ``[0, 5 s]`` [m].
    at : float
        When [s].
    contacts : int
        Number of contact intervals.
    evidence : Evidence
        COMPUTED for the rod (step halved), OBSERVED for a simulation.
    """

    figure: int
    variant: Variant
    cells: int | None
    form: Form | None
    amplitude: float
    largest_z: float
    at: float
    contacts: int
    evidence: Evidence

    @property
    def contact(self) -> bool:
        """Whether the end reaches into the obstacle."""
        return self.largest_z > 0


@dataclass(frozen=True, kw_only=True, slots=True)
class PaperClaim:
    """One claim of the paper and what becomes of it.

    Attributes
    ----------
    key : str
        Short name.
    where : str
        Place in the paper.
    claim : str
        The claim.
    as_printed, corrected, rod : str
        What the system as printed gives, what the corrected one gives, what the rod itself does.
    survives : bool
        Whether the claim holds for the corrected scheme at every ``N`` and for the rod, with the printed parameters.
    sentence : str
        The finding in one sentence, with its number.
    evidence : Evidence
        What the finding rests on.
    """

    key: str
    where: str
    claim: str
    as_printed: str
    corrected: str
    rod: str
    survives: bool
    sentence: str
    evidence: Evidence

    def __str__(self) -> str:
        mark = "survives" if self.survives else "FAILS"
        rows = [("as printed", self.as_printed), ("corrected", self.corrected), ("the rod", self.rod)]
        lines = [f"{mark:<9} {self.claim} ({self.where})"]
        for label, text in (*rows, ("finding", f"{self.sentence} [{self.evidence}]")):
            lines += textwrap.wrap(
                text, _WIDTH, initial_indent=f"{'':10}{label:<11} ", subsequent_indent=" " * 22, break_on_hyphens=False
            )
        return "\n".join(lines)


@dataclass(frozen=True, kw_only=True, slots=True)
class PaperTable:
    """The paper, reproduced: its claims, the peaks of figures 8 to 10, the settling of figures 6 and 7.

    Attributes
    ----------
    claims : tuple of PaperClaim
        In the order of the paper.
    peaks : tuple of Peak
        Figures 8 to 10, every variant.
    settling : tuple of Settling
        The scheme with ``N = 10`` and ``N = 200``, and the rod itself.
    """

    claims: tuple[PaperClaim, ...]
    peaks: tuple[Peak, ...]
    settling: tuple[Settling, ...]

    def claim(self, key: str) -> PaperClaim:
        """The claim with that short name.

        Raises
        ------
        KeyError
            There is none.
        """
        return {claim.key: claim for claim in self.claims}[key]

    def peak(self, figure: int, variant: Variant) -> Peak:
        """The peak of a figure in a variant.

        Raises
        ------
        KeyError
            There is none.
        """
        return {(peak.figure, peak.variant): peak for peak in self.peaks}[figure, variant]

    def to_dict(self) -> dict[str, object]:
        """Plain JSON data: ``schema``, ``claims``, ``figures`` (number, then variant) and ``settling``."""
        figures: dict[str, dict[str, object]] = {}
        for peak in self.peaks:
            figures.setdefault(str(peak.figure), {})[peak.variant] = {
                "largest_z": peak.largest_z,
                "at": peak.at,
                "contact": peak.contact,
                "contact_count": peak.contacts,
                "cells": peak.cells,
                "form": peak.form,
                "force_amplitude": peak.amplitude,
                "evidence": str(peak.evidence),
            }
        names = ("key", "where", "claim", "as_printed", "corrected", "rod", "survives", "sentence")
        return {
            "schema": SCHEMA,
            "claims": [
                {name: getattr(claim, name) for name in names} | {"evidence": str(claim.evidence)}
                for claim in self.claims
            ],
            "figures": figures,
            "settling": [
                {
                    "model": "rod" if found.cells is None else "scheme",
                    "cells": found.cells,
                    "rest_position": found.rest,
                    "slow_time_constant": found.slow,
                    "elastic_time_constant": found.fast,
                    "settling_time_5_percent": found.band_5,
                    "settling_time_2_percent": found.band_2,
                    "ringing_left_at_1.11e-3_s": found.left,
                }
                for found in self.settling
            ],
        }

    def to_xarray(self) -> xarray.Dataset:
        """Peaks of the figures and settling times as an ``xarray.Dataset`` with units.

        Returns
        -------
        xarray.Dataset
            Peaks along ``figure`` and ``variant``, nan and False where a variant was not run; settling along ``model``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.rod.paper.export import table_dataset

        return table_dataset(self)

    def _repr_html_(self) -> str:
        from lure.analysis.rod.paper.export import table_html

        return table_html(self)

    def peak_table(self) -> str:
        """Largest ``z`` of figures 8 to 10 in every variant, as text."""
        numbers = sorted({peak.figure for peak in self.peaks})
        rows = [f"{'largest z [m]':42}" + "".join(f"{f'figure {number}':>24}" for number in numbers)]
        for variant, title in TITLES.items():
            found = [peak for peak in self.peaks if peak.variant == variant]
            cells = (f"{peak.largest_z:.6g} {'contact' if peak.contact else 'free':>8}" for peak in found)
            if found:
                rows.append(f"{title:<42}" + "".join(f"{cell:>24}" for cell in cells))
        return "\n".join(rows)

    def __str__(self) -> str:
        survivors = sum(claim.survives for claim in self.claims)
        head = f"{survivors} of {len(self.claims)} claims of the paper survive."
        return "\n\n".join([head, self.peak_table(), *map(str, self.claims)])

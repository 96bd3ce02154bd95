"""What a reproduction of the paper consists of: claims, peaks of the forced figures, settling times."""

from __future__ import annotations

import textwrap
from typing import Any, Literal

import numpy as np

from lure.analysis.rod.paper.settling import Settling
from lure.analysis.verdict import Evidence
from lure.record import Column, Page, Record, derived, quantity
from lure.rod.discretisation import Form

SCHEMA = "lure-paper/1"
_WIDTH = 112
_COMMENT = (
    "A variant says what moved: the N-cell scheme (OBSERVED) or the rod itself (COMPUTED); a peak of the one is not a "
    "peak of the other."
)
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


class Peak(Record):
    """How far the end of the rod gets in figure 8, 9 or 10, in one variant."""

    figure: int = quantity("8, 9 or 10", key="")
    variant: Variant = quantity(
        "``as-printed`` drops the factor ``s`` from the force; ``rescaled`` divides it by ``c 10/L = 60000 1/s``",
        key="",
    )
    cells: int | None = quantity("``N``; None for the rod itself")
    form: Form | None = quantity("Form of the scheme; None for the rod itself")
    amplitude: float = quantity("Amplitude of the force", "N", key="force_amplitude")
    largest_z: float = quantity("largest ``z = u(t, L) - gap`` on ``[0, 5 s]``", "m")
    at: float = quantity("instant of largest_z", "s")
    contacts: int = quantity("number of contact intervals", key="contact_count")
    evidence: Evidence = quantity("COMPUTED for the rod (step halved), OBSERVED for a simulation")

    @property
    @derived()
    def contact(self) -> bool:
        """Whether the end reaches into the obstacle."""
        return self.largest_z > 0


class PaperClaim(Record):
    """One claim of the paper and what becomes of it."""

    key: str = quantity("Short name")
    where: str = quantity("Place in the paper")
    claim: str = quantity("The claim")
    as_printed: str = quantity("What the system as printed gives")
    corrected: str = quantity("What the corrected one gives")
    rod: str = quantity("What the rod itself does")
    survives: bool = quantity(
        "Whether the claim holds for the corrected scheme at every ``N`` and for the rod, with the printed parameters"
    )
    sentence: str = quantity("The finding in one sentence, with its number")
    evidence: Evidence = quantity("What the finding rests on")

    def __str__(self) -> str:
        mark = "survives" if self.survives else "FAILS"
        rows = [("as printed", self.as_printed), ("corrected", self.corrected), ("the rod", self.rod)]
        lines = [f"{mark:<9} {self.claim} ({self.where})"]
        for label, text in (*rows, ("finding", f"{self.sentence} [{self.evidence}]")):
            lines += textwrap.wrap(
                text, _WIDTH, initial_indent=f"{'':10}{label:<11} ", subsequent_indent=" " * 22, break_on_hyphens=False
            )
        return "\n".join(lines)


class PaperTable(Record):
    """The paper, reproduced: its claims, the peaks of figures 8 to 10, the settling of figures 6 and 7."""

    claims: tuple[PaperClaim, ...] = quantity("In the order of the paper")
    peaks: tuple[Peak, ...] = quantity("Figures 8 to 10, every variant")
    settling: tuple[Settling, ...] = quantity(
        "The scheme with ``N = 10`` and ``N = 200``, and the rod itself", dims="model", each=Settling
    )

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

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: ``schema``, ``claims``, ``figures`` (number, then variant) and ``settling``."""
        figures: dict[str, dict[str, object]] = {}
        for peak in self.peaks:
            figures.setdefault(str(peak.figure), {})[peak.variant] = peak.to_dict()
        found = super().to_dict()
        return {"schema": SCHEMA, "claims": found["claims"], "figures": figures, "settling": found["settling"]}

    def _columns(self) -> dict[str, Column]:
        """Peaks along ``figure`` and ``variant``, nan where a variant was not run; settling along ``model``."""
        figures = sorted({peak.figure for peak in self.peaks})
        variants = [variant for variant in TITLES if any(peak.variant == variant for peak in self.peaks)]
        found = {name: np.full((len(figures), len(variants)), np.nan) for name in ("largest_z", "at", "contacts")}
        for peak in self.peaks:
            for name, values in found.items():
                values[figures.index(peak.figure), variants.index(peak.variant)] = getattr(peak, name)
        both, titles = ("figure", "variant"), [TITLES[variant] for variant in variants]
        models = ["the rod itself" if row.cells is None else f"scheme, N = {row.cells}" for row in self.settling]
        return super()._columns() | {
            "largest_z": Column(both, found["largest_z"], "m", "largest z = u(t, L) - gap on [0, 5 s]; nan if not run"),
            "at": Column(both, found["at"], "s", "instant of largest_z"),
            "contacts": Column(both, found["contacts"], "1", "number of contact intervals"),
            "figure": Column(("figure",), figures, "1", "number of the figure"),
            "variant": Column(("variant",), titles, "1", "what moved, and with which force"),
            "model": Column(("model",), np.array(models, dtype=object), "1", "what settles"),
        }

    def _attributes(self) -> dict[str, object]:
        return {"title": "The paper, reproduced", "comment": _COMMENT}

    def _page(self) -> Page:
        rows = [
            (claim.claim, claim.where, "survives" if claim.survives else "FAILS", claim.sentence, claim.evidence)
            for claim in self.claims
        ]
        survivors = sum(claim.survives for claim in self.claims)
        title = f"{survivors} of {len(self.claims)} claims of the paper survive"
        return Page(title, rows, head=("claim", "where", "", "finding", "evidence"), notes=(_COMMENT,))

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

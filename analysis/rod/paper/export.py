"""The reproduced paper as a Dataset and an HTML table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lure.analysis.rod.paper.model import TITLES
from lure.record import html_table
from lure.rod.datasets import Column, dataset

if TYPE_CHECKING:
    import xarray

    from lure.analysis.rod.paper.model import PaperTable

_SETTLING = {
    "rest": ("m", "where the released end comes to rest, u(inf, L)"),
    "slow": ("s", "time constant of the mode that does not oscillate"),
    "fast": ("s", "time constant of the first oscillating mode"),
    "band_5": ("s", "time after which the ringing stays within 5 % of its initial size"),
    "band_2": ("s", "time after which the ringing stays within 2 % of its initial size"),
    "left": ("1", "largest ringing from the paper's 1.11e-3 s on, as a share of the initial one"),
}
_COMMENT = (
    "A variant says what moved: the N-cell scheme (OBSERVED) or the rod itself (COMPUTED); a peak of the one is not a "
    "peak of the other."
)


def table_dataset(table: PaperTable) -> xarray.Dataset:
    """The Dataset of :meth:`lure.analysis.rod.paper.PaperTable.to_xarray`.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    figures = sorted({peak.figure for peak in table.peaks})
    variants = [variant for variant in TITLES if any(peak.variant == variant for peak in table.peaks)]
    shape, both = (len(figures), len(variants)), ("figure", "variant")
    largest, at, contacts = (np.full(shape, np.nan) for _ in range(3))
    for peak in table.peaks:
        place = figures.index(peak.figure), variants.index(peak.variant)
        largest[place], at[place], contacts[place] = peak.largest_z, peak.at, peak.contacts
    variables = {
        "largest_z": Column(both, largest, "m", "largest z = u(t, L) - gap on [0, 5 s]; nan if not run"),
        "at": Column(both, at, "s", "instant of largest_z"),
        "contacts": Column(both, contacts, "1", "number of contact intervals"),
    }
    for name, (unit, text) in _SETTLING.items():
        variables[name] = Column(("model",), [getattr(row, name) for row in table.settling], unit, text)
    titles = np.array([TITLES[variant] for variant in variants], dtype=object)
    models = ["the rod itself" if row.cells is None else f"scheme, N = {row.cells}" for row in table.settling]
    coordinates = {
        "figure": Column(("figure",), figures, "1", "number of the figure"),
        "variant": Column(("variant",), titles, "1", "what moved, and with which force"),
        "model": Column(("model",), np.array(models, dtype=object), "1", "what settles"),
    }
    return dataset(variables, coordinates, {"title": "The paper, reproduced", "comment": _COMMENT})


def table_html(table: PaperTable) -> str:
    """A table for notebooks: a row for each claim."""
    rows = [
        (claim.claim, claim.where, "survives" if claim.survives else "FAILS", claim.sentence, claim.evidence)
        for claim in table.claims
    ]
    survivors = sum(claim.survives for claim in table.claims)
    title = f"{survivors} of {len(table.claims)} claims of the paper survive"
    return html_table(title, rows, head=("claim", "where", "", "finding", "evidence"), notes=(_COMMENT,))

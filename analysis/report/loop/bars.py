"""The bar of a class: how far it is proved, from where it is refuted, what is open, and what was asked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

Data = dict[str, Any]

_WIDE = 30.0  # beyond this ratio of its numbers a bar is logarithmic


@dataclass(frozen=True, kw_only=True, slots=True)
class Bar:
    """One class as a bar, in percent of its width.

    Attributes
    ----------
    name : str
        The class.
    key : str
        Where its numbers stand in the document.
    row : dict
        Its numbers.
    pieces : tuple of (str, float)
        ``proved``, ``open`` or ``refuted``, and the width of that piece.
    asked : float or None
        Place of the upper end that was asked about.
    logarithmic : bool
        Whether equal steps are equal ratios.
    """

    name: str
    key: str
    row: Data
    pieces: tuple[tuple[str, float], ...]
    asked: float | None
    logarithmic: bool


def bar(name: str, key: str, row: Data, asked: float | None) -> Bar:
    """The bar of one row of the table.

    Parameters
    ----------
    name : str
        The class.
    key : str
        Where the row stands in the document.
    row : dict
        One of the document's ``answers``.
    asked : float or None
        The upper end asked about.
    """
    start, proved, refuted = float(row["lower"]), _proved(row), math.inf
    if row["verdict"] == "REFUTED":
        refuted = start
    elif row["refuted_at"] is not None:
        refuted = proved if row["gap"].startswith("closed") else float(row["refuted_at"])
    inner = [value for value in (proved, refuted, asked) if value is not None and start < value < math.inf]
    end = 1.25 * max(inner) if start == 0 and inner else start + 1.25 * ((max(inner, default=start + 1.0)) - start)
    wide = start == 0 and bool(inner) and end > _WIDE * min(inner)
    first = 0.4 * min(inner) if wide else start

    def place(value: float) -> float:
        """Where a number stands, in percent."""
        inside = min(max(value, first), end)
        share = math.log(inside / first) / math.log(end / first) if wide else (inside - first) / (end - first)
        return 100.0 * share

    marks = [("proved", place(proved)), ("open", place(min(max(refuted, proved), end))), ("refuted", 100.0)]
    pieces, before = [], 0.0
    for kind, until in marks:
        if until > before:
            pieces.append((kind, until - before))
            before = until
    at = None if asked is None else place(asked)
    return Bar(name=name, key=key, row=row, pieces=tuple(pieces), asked=at, logarithmic=wide)


def _proved(row: Data) -> float:
    return float(row["largest"][0]) if row["verdict"] == "PROVED" else float(row["lower"])

"""A loop's analysis as plain text, at most 100 columns wide."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from analysis.answers.largest import UNFINISHED, Largest, proved_up_to
from analysis.evidence import Verdict

if TYPE_CHECKING:
    from analysis.answers.table import LoopAnalysis

WIDTH = 100
HEAD = ("class", "criterion", "proved up to", "evidence", "refuted at", "by", "gap")


def table(found: LoopAnalysis) -> str:
    """Verdict, table of classes, gains, hints and what was not shown.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    blocks = [
        f"{found.verdict}  {found.subject.name}: H = {found.subject.block}",
        textwrap.fill(found.statement, WIDTH),
        *([textwrap.fill(f"Nothing is proved: {why}.", WIDTH)] if (why := unproved(found)) else []),
        *([] if found.stopped is None else [UNFINISHED[found.stopped]]),
        columns([HEAD, *(table_row(row) for row in found.rows)]),
        textwrap.fill(f"Linear gains for which the loop is stable: {gains_words(found)}.", WIDTH),
        *(textwrap.fill(f"To decide more: {hint}.", WIDTH) for hint in found.hints),
        *(textwrap.fill(f"Not shown: {note}.", WIDTH) for note in found.not_shown),
    ]
    return "\n\n".join(blocks)


def unproved(found: LoopAnalysis) -> str:
    """Why nothing was proved of the class asked about, where the statement does not say it; empty elsewhere.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    asked = found.asked
    if asked is None or Verdict.PROVED in (found.verdict, asked.verdict):
        return ""
    why = asked.reason if found.subject.law is None else asked.reason.partition("; give ")[0]  # see the hints
    return "" if why in found.statement else why


def gains_words(found: LoopAnalysis) -> str:
    """The intervals of stable linear gains in words.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    return "not computed" if found.gains is None else ", ".join(map(str, found.gains)) or "none"


def class_name(row: Largest) -> str:
    """The class of a row in a few words.

    Parameters
    ----------
    row : Largest
        The row.
    """
    if row.question == "sector":
        return "sector, time-varying" if row.time_varying else "sector"
    return "slope, odd" if row.odd else "slope"


def columns(rows: list[tuple[str, ...]]) -> str:
    """Rows of equal length as aligned columns.

    Parameters
    ----------
    rows : list of tuple of str
        The head first.
    """
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(line.rstrip() for line in lines)


def table_row(row: Largest) -> tuple[str, ...]:
    """A class of laws as the cells under :data:`HEAD`.

    Parameters
    ----------
    row : Largest
        The answer for that class.
    """
    proved = row.verdict is Verdict.PROVED
    return (
        class_name(row),
        row.criterion if proved else "-",
        proved_up_to(row) if proved else "-",
        str(row.evidence) if proved else "-",
        row.refuted_text or "-",
        ", ".join(witness.kind for witness in (row.trivial, row.witness) if witness is not None) or "-",
        row.gap,
    )

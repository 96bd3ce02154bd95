"""Answers as tables for a notebook and as datasets: the verdict, what it rests on, and what it does not say."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from analysis.doubles import bound_below
from analysis.evidence import Verdict
from lure.showing import html_table, plain, xarray_or_refusal

if TYPE_CHECKING:
    import xarray

    from analysis.answer import Answer
    from analysis.answers.largest import Largest
    from analysis.answers.table import LoopAnalysis

_BEYOND = "Not shown: a rate of decay, a bound on the size of the motion, anything about external inputs."
_CHECK = "Check it again: analysis.check(result.{}.certificate), in exact arithmetic."


def largest_html(found: Largest) -> str:
    """One answer: both sides of it, and every criterion that was tried.

    Parameters
    ----------
    found : Largest
        The answer.
    """
    from analysis.answers.largest import proved_up_to

    proved = found.verdict is Verdict.PROVED
    theta = "" if found.theta is None else f", theta = {found.theta:.7g} s"
    rows = [
        ("proved up to k =", proved_up_to(found) if proved else "nothing is proved"),
        ("proved by", f"{found.criterion}{theta}") if proved else ("why", found.reason or "-"),
        ("evidence", found.evidence),
        ("refuted from k =", found.refuted_text or "-"),
        ("refuted by", "; ".join(str(one) for one in (found.trivial, found.witness) if one is not None) or "-"),
        ("linear gains", f"stable up to {bound_below(found.hurwitz.low)}"),
        ("in a sentence", str(found)),
    ]
    notes = [_BEYOND]
    notes += [_CHECK.format("proof")] if proved else []
    notes += [_CHECK.format("refutation")] if found.refutation is not None else []
    head = ("criterion", "verdict", "evidence", "largest k", "why")
    tried = [
        (one.criterion, one.verdict, one.evidence, bound_below(one.largest.low), one.reason)
        if one.largest.low > found.lower
        else (one.criterion, one.verdict, "-", "-", one.reason)
        for one in found.answers
    ]
    title = f"{found.about} [{found.lower}, k]" + (f", {found.subject}" if found.subject else "")
    table = html_table(title, rows, verdict=str(found.verdict), notes=notes)
    return table + html_table("Every criterion that was tried", tried, head=head)


def answer_html(answer: Answer) -> str:
    """One criterion's answer.

    Parameters
    ----------
    answer : Answer
        The answer.
    """
    rows: list[tuple[str, object]] = [
        ("class", answer.law_class),
        ("evidence", answer.evidence),
        ("largest k", answer.largest),
        ("multiplier", answer.multiplier or "-"),
        ("margin", "-" if answer.margin is None else answer.margin),
        ("theorem", answer.theorem),
        ("reason", answer.reason),
        *(("hypothesis", text) for text in answer.hypotheses),
    ]
    return html_table(f"{answer.criterion} criterion", rows, verdict=str(answer.verdict), notes=[_BEYOND])


def analysis_html(found: LoopAnalysis) -> str:
    """The table of classes, with the verdict on the class asked about and what was not shown.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    from analysis.answers.largest import UNFINISHED
    from analysis.answers.text import HEAD, gains_words, table_row

    notes = [
        found.statement,
        *([] if found.stopped is None else [UNFINISHED[found.stopped]]),
        f"Evidence: {found.evidence}. Linear gains for which the loop is stable: {gains_words(found)}.",
        *(f"To decide more: {hint}." for hint in found.hints),
        *(f"Not shown: {note}." for note in found.not_shown),
        *([] if found.shown is None else [_CHECK.format("shown")]),
    ]
    title = f"{found.subject.name}: H = {found.subject.block}"
    return html_table(title, [table_row(row) for row in found.rows], head=HEAD, verdict=str(found.verdict), notes=notes)


def largest_dataset(found: Largest) -> xarray.Dataset:
    """Every criterion that was tried, over the dimension ``criterion``.

    Parameters
    ----------
    found : Largest
        The answer.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    xr = xarray_or_refusal("Largest.to_xarray")
    answers = found.answers
    variables = {
        "low": ("criterion", [one.largest.low for one in answers], {"long_name": "every class up to it, if PROVED"}),
        "high": ("criterion", [one.largest.high for one in answers], {"long_name": "nothing can be said from it on"}),
        "theta": ("criterion", [_number(one.theta) for one in answers], {"units": "s"}),
        "verdict": ("criterion", [str(one.verdict) for one in answers]),
        "evidence": ("criterion", [str(one.evidence) for one in answers]),
    }
    attributes = {
        "question": found.question,
        "lower": float(found.lower),
        "verdict": str(found.verdict),
        "evidence": str(found.evidence),
        "refuted_at": _number(found.refuted_at),
        "comment": str(found),
    }
    coordinates = {"criterion": [one.criterion for one in answers]}
    made: xarray.Dataset = xr.Dataset(variables, coords=coordinates, attrs=attributes)
    return made


def analysis_dataset(found: LoopAnalysis) -> xarray.Dataset:
    """The table of classes, over the dimension ``law_class``; nan where nothing is proved or refuted.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.

    Raises
    ------
    InputError
        xarray is not installed.
    """
    from analysis.answers.text import class_name

    xr = xarray_or_refusal("LoopAnalysis.to_xarray")
    rows = found.rows
    reach = [row.largest.low if row.verdict is Verdict.PROVED else math.nan for row in rows]
    variables = {
        "proved_up_to": ("law_class", reach),
        "refuted_at": ("law_class", [_number(row.refuted_at) for row in rows]),
        "criterion": ("law_class", [row.criterion for row in rows]),
        "verdict": ("law_class", [str(row.verdict) for row in rows]),
        "evidence": ("law_class", [str(row.evidence) for row in rows]),
        "closed": ("law_class", [row.closed for row in rows]),
    }
    attributes = {
        "title": found.subject.name,
        "block": str(found.subject.block),
        "verdict": str(found.verdict),
        "evidence": str(found.evidence),
        "comment": found.statement,
        "not_shown": plain(found.not_shown),
    }
    coordinates = {"law_class": [class_name(row) for row in rows]}
    made: xarray.Dataset = xr.Dataset(variables, coords=coordinates, attrs=attributes)
    return made


def _number(value: float | None) -> float:
    return math.nan if value is None else value

"""``analyse``: every class and every criterion for one loop, in one table, and the verdict on the class asked about."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from lure.analysis.certificates.sealing import Failure, guarded
from lure.analysis.deadline import check_seconds, time_limit
from lure.analysis.drawing import drawing
from lure.analysis.inequality.gains import GainInterval, gain_intervals
from lure.analysis.inequality.plant import Case, TransferPolynomials
from lure.analysis.numerics.doubles import json_number
from lure.analysis.questions.advice import hints
from lure.analysis.questions.conclusion import Conclusion
from lure.analysis.questions.findings import asked_row, decided
from lure.analysis.questions.largest import UNFINISHED, StabilityBound, Stopped, proved_up_to
from lure.analysis.questions.problem import Problem, Subject, loop_given, subject
from lure.analysis.questions.questions import ContradictionError, found_for, largest_of
from lure.analysis.theorems.table import Question
from lure.analysis.verdict import Bracket, Evidence, Verdict
from lure.arrays import np
from lure.errors import AssumptionError
from lure.exact import exact_number
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    import xarray

    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.codes import Code
    from lure.analysis.drawing import Axes
    from lure.classes import NonlinearityClass

# A loop's analysis as plain data, the ``loop`` part of ``report.json``.


def analysis_dict(found: LoopAnalysis) -> dict[str, Any]:
    """The analysis as a dictionary of plain values; infinite numbers are the text ``inf``.

    Parameters
    ----------
    found : LoopAnalysis
        The analysis.
    """
    return {
        **_subject(found.subject),
        "case": found.case,
        "verdict": str(found.verdict),
        "evidence": str(found.evidence),
        "statement": found.statement,
        "headline": found.conclusion.headline,
        "meaning": found.conclusion.meaning,
        "law_class": found.conclusion.law_class,
        "membership": found.conclusion.membership,
        "attracts": found.conclusion.attracts,
        "reason": found.reason,
        "code": None if found.code is None else found.code.identifier,
        "gains": None if found.gains is None else [str(interval) for interval in found.gains],
        "answers": [row.to_dict() for row in found.rows],
        "hints": list(found.hints),
        "not_shown": list(found.not_shown),
        "stopped": found.stopped,
    }


def _subject(about: Subject) -> dict[str, Any]:
    block = about.block
    data: dict[str, Any] = {"text": str(block), "denominator": None}
    if isinstance(block, StateSpace):
        step = None if block.dt is None else str(block.dt)
        data |= {"numerator": None, "terms": None, "dt": step, "matrices": block.to_dict()}
        return {**_named(about), "block": data}
    data["denominator"] = [str(c) for c in block.denominator]
    if isinstance(block, RationalPlant):
        data |= {
            "numerator": [str(c) for c in block.numerator],
            "terms": None,
            "dt": None if block.dt is None else str(block.dt),
        }
    else:
        terms = [[str(delay), [str(c) for c in top]] for delay, top in block.terms]
        data |= {"numerator": None, "terms": terms, "dt": None}
    return {**_named(about), "block": data}


def _named(about: Subject) -> dict[str, Any]:
    return {
        "name": about.name,
        "title": about.title,
        "source": about.source,
        "law": None if about.law is None else str(about.law),
        "class": None if about.law_class is None else class_dict(about.law_class),
    }


def class_dict(law_class: NonlinearityClass) -> dict[str, Any]:
    """A class of laws as plain data.

    Parameters
    ----------
    law_class : NonlinearityClass
        The class.
    """
    slope = law_class.slope
    return {
        "sector": [json_number(float(law_class.sector.lower)), json_number(float(law_class.sector.upper))],
        "slope": None if slope is None else [json_number(float(slope.lower)), json_number(float(slope.upper))],
        "odd": law_class.odd,
        "time_varying": law_class.time_varying,
        "text": str(law_class),
    }


# A loop's analysis as plain text, at most 100 columns wide.

if TYPE_CHECKING:
    pass

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


def class_name(row: StabilityBound) -> str:
    """The class of a row in a few words.

    Parameters
    ----------
    row : StabilityBound
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


def table_row(row: StabilityBound) -> tuple[str, ...]:
    """A class of laws as the cells under :data:`HEAD`.

    Parameters
    ----------
    row : StabilityBound
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


Progress = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True, slots=True)
class LoopAnalysis:
    r"""What was found about ``sigma = H mu``, ``mu = -phi(sigma)``.

    Attributes
    ----------
    subject : Subject
        The loop: its name, block, law and the class asked about.
    case : {"stable", "critical", "unstable"}
        Its poles: all stable, one simple one at 0 (``z = 1``) besides stable ones, or anything else.
    gains : tuple of GainInterval or None
        All linear gains for which the loop is stable; None where they were not computed.
    rows : tuple of StabilityBound
        One for each class of laws, farthest reach first.
    asked : StabilityBound or None
        The row of that class.
    conclusion : Conclusion
        What follows for the class asked about and the nonlinearity given; without a class for the row that reaches
        farthest.
    hints : tuple of str
        What would decide more: a smaller sector, a property of ``phi``.
    not_shown : tuple of str
        What must not be read into it.
    """

    subject: Subject
    case: Case
    gains: tuple[GainInterval, ...] | None
    rows: tuple[StabilityBound, ...]
    asked: StabilityBound | None
    conclusion: Conclusion
    hints: tuple[str, ...]
    not_shown: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """On the class asked about; without one PROVED if any row proves anything."""
        return self.conclusion.verdict

    @property
    def evidence(self) -> Evidence:
        """What the verdict rests on."""
        return self.conclusion.evidence

    @property
    def statement(self) -> str:
        """The verdict in one sentence."""
        return str(self.conclusion)

    @property
    def reason(self) -> str:
        """Why nothing is decided; empty for PROVED and REFUTED."""
        return self.conclusion.reason

    @property
    def code(self) -> Code | None:
        """The code of the reason; ``lure explain`` says more.  None for PROVED and REFUTED."""
        return self.conclusion.code

    @property
    def shown(self) -> Proved | Refuted | None:
        """What the checker accepted of it, with its certificate; None for INCONCLUSIVE."""
        return self.conclusion.shown

    @property
    def certificates(self) -> tuple[Proved | Refuted, ...]:
        """Everything the checker accepted: of the verdict first, then of every answer and counterexample, once each."""
        answers = [answer.proof for row in self.rows for answer in row.answers]
        found = [self.shown, *answers, *(one for row in self.rows for one in row.refutations)]
        return tuple({repr(shown.certificate): shown for shown in found if shown is not None}.values())

    @property
    def stopped(self) -> Stopped | None:
        """What ended the search for a row before it was complete; None if nothing did."""
        return next((row.stopped for row in self.rows if row.stopped is not None), None)

    def __bool__(self) -> bool:
        raise TypeError("an analysis has three answers; compare analysis.verdict")

    def __str__(self) -> str:

        return table(self)

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar a class: proved up to its end, refuted from its cross on, unknown in between.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)(self.rows, [class_name(row) for row in self.rows], ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``."""
        return analysis_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The table of classes, over the dimension ``law_class``; nan where nothing is proved or refuted.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.questions.largest import analysis_dataset

        return analysis_dataset(self)

    def _repr_html_(self) -> str:
        from lure.analysis.questions.largest import analysis_html

        return analysis_html(self)


_GRACE = 1.0  # [s] to say what was found, when the time for the search is over
_ROWS: tuple[tuple[Question, bool, bool], ...] = (
    ("sector", False, True),
    ("sector", False, False),
    ("slope", False, False),
    ("slope", True, False),
)


def analyse(
    loop: object, nonlinearity: object = None, *, seconds: float | None = None, progress: Progress | None = None
) -> LoopAnalysis:
    """Every criterion for every kind of class, with the lower end of the class asked about.

    Parameters
    ----------
    loop : LoopSystem, Loop or block
        A system from a file, a block with a law, or a block alone, whatever :func:`lure.plants.as_plant` takes; without
        a law or a class the classes ``[0, k]`` are looked at.
    nonlinearity : object
        What closes the loop around a block: a law, a formula as text, ``control.saturation_nonlinearity``, or the class
        asked about as a ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``.
    seconds : float or None
        Time allowed to the criteria and searches; when it is over the best rows so far are shown, with ``stopped``.
    progress : callable, optional
        Called as ``progress(step, done)`` when a step begins, ``0 <= done <= 1``.

    Returns
    -------
    LoopAnalysis
        With ``rows``, one :class:`StabilityBound` a kind of class, and ``asked`` for the class of the loop.

    Raises
    ------
    AssumptionError
        The class has no finite lower end, or no criterion applies to the block.
    ContradictionError
        What is proved and what is refuted overlap: a bug.

    Examples
    --------
    >>> from lure import Saturation
    >>> found = analyse("1/(s+1)", Saturation(gain=2))
    >>> print(found.verdict)
    PROVED
    """
    check_seconds(seconds)
    about = subject(loop_given(loop, nonlinearity))
    block, law_class = about.block, about.law_class
    lower = {"sector": Fraction(0), "slope": Fraction(0)}
    if law_class is not None:
        lower["sector"] = _finite(law_class.sector.lower)
        lower["slope"] = lower["sector"] if law_class.slope is None else _finite(law_class.slope.lower)
    if isinstance(block, DelayPlant):  # its criteria begin at 0, whatever the class
        lower = dict.fromkeys(lower, Fraction(0))
    questions = [
        Problem.largest(block, question, lower=lower[question], odd=odd, time_varying=varying)
        for question, odd, varying in _ROWS
    ]
    rows = [largest_of(each) for each in found_for(questions, seconds=seconds, progress=progress)]
    rows = _spread(rows)
    with time_limit(_GRACE if any(row.stopped == "time" for row in rows) else None):
        gains = _gains(block)
        conclusion = decided(about, rows)
    return LoopAnalysis(
        subject=about,
        case=_case(block, rows),
        gains=gains,
        rows=tuple(sorted(rows, key=lambda row: (row.verdict is not Verdict.PROVED, -row.largest.low))),
        asked=asked_row(rows, law_class),
        conclusion=conclusion,
        hints=hints(about, rows, gains or (), conclusion),
        not_shown=_not_shown(block, rows, conclusion),
    )


def _gains(block: RationalPlant | DelayPlant | StateSpace) -> tuple[GainInterval, ...] | None:
    """The intervals of stable linear gains; None where there is no way or no time to compute them."""
    found = guarded("linear gains", lambda: gain_intervals(block)) if isinstance(block, RationalPlant) else None
    return None if isinstance(found, Failure) else found


def _case(block: RationalPlant | DelayPlant | StateSpace, rows: list[StabilityBound]) -> Case:
    if isinstance(block, StateSpace):
        shown = any(row.verdict is Verdict.PROVED and row.lower == 0 for row in rows)
        poles = np.linalg.eigvals(block.A)
        inside = poles.real < 0 if block.dt is None else np.abs(poles) < 1
        return "stable" if shown or inside.all() else "unstable"
    rational = block if isinstance(block, RationalPlant) else RationalPlant([1], block.denominator)
    return TransferPolynomials.of(rational).case


def _finite(bound: float | Fraction) -> Fraction:
    if bound == -math.inf:
        raise AssumptionError("the class has no lower end: no criterion here reaches -inf; give a finite lower bound")
    return exact_number(bound, "lower")


def _spread(rows: list[StabilityBound]) -> list[StabilityBound]:
    """A counterexample to a class refutes the larger ones before it too, if they begin at the same gain."""
    found = list(rows)
    for place in range(len(found) - 2, -1, -1):
        larger, smaller = found[place], found[place + 1]
        if smaller.refuted_at is None or larger.lower != smaller.lower:
            continue
        if smaller.trivial is not None and larger.trivial is None and larger.refuted_at == smaller.refuted_at:
            found[place] = replace(larger, trivial=smaller.trivial, witness=smaller.witness)
        elif larger.refuted_at is None or smaller.refuted_at < larger.refuted_at:
            low, high = larger.largest.low, smaller.refuted_at
            if larger.verdict is Verdict.PROVED and low >= high:
                raise ContradictionError(f"{larger.criterion} proves up to {low!r}, and {smaller.witness} at {high!r}")
            largest = Bracket(low, max(low, min(larger.largest.high, high)))
            witness, trivial = smaller.witness, smaller.trivial
            found[place] = replace(larger, refuted_at=high, witness=witness, trivial=trivial, largest=largest)
    return found


def _not_shown(
    block: RationalPlant | DelayPlant | StateSpace, rows: list[StabilityBound], found: Conclusion
) -> tuple[str, ...]:
    notes = ["a rate of decay, a bound on the size of the motion, anything about external inputs"]
    if found.shown is None or found.shown.certificate["laws"].get("regularity") is None:
        notes.insert(0, "anything about laws that are not locally Lipschitz")
    if any(row.critical for row in rows):
        of = f" with another phi than {found.nonlinearity}" if found.attracts and found.nonlinearity else ""
        notes.insert(
            0,
            f"that 0 attracts every motion{of}: the loop with the smallest gain of the class has a pole at 0, and the "
            "class contains laws with more equilibria than 0",
        )
    return tuple(notes)

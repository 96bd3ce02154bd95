"""``analyse``: every class and every criterion for one loop, in one table, and the verdict on the class asked about."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from analysis.answers.catalogue import Question
from analysis.answers.decision import asked_row, decided, hints
from analysis.answers.largest import Largest
from analysis.answers.questions import ContradictionError, max_sector, max_slope
from analysis.answers.subject import Subject, subject
from analysis.criteria.hurwitz import GainInterval, gain_intervals
from analysis.evidence import Bracket, Evidence, Verdict
from analysis.plant import Case, Plant
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.exact import exact_number
from lure.rational import RationalBlock

if TYPE_CHECKING:
    import xarray

    from analysis.certificates.checker import Proved, Refuted
    from analysis.plots.responses import Axes

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
    gains : tuple of GainInterval
        All linear gains for which the loop is stable.
    rows : tuple of Largest
        One for each class of laws, farthest reach first.
    asked : Largest or None
        The row of that class.
    verdict : Verdict
        On the class asked about; without one PROVED if any row proves anything.
    evidence : Evidence
        What the verdict rests on.
    statement : str
        The verdict in one sentence.
    shown : Proved, Refuted or None
        What the checker accepted of it, with its certificate; None for INCONCLUSIVE.
    hints : tuple of str
        What would decide more: a smaller sector, a property of ``phi``.
    not_shown : tuple of str
        What must not be read into it.
    """

    subject: Subject
    case: Case
    gains: tuple[GainInterval, ...]
    rows: tuple[Largest, ...]
    asked: Largest | None
    verdict: Verdict
    evidence: Evidence
    statement: str
    shown: Proved | Refuted | None
    hints: tuple[str, ...]
    not_shown: tuple[str, ...]

    def __post_init__(self) -> None:
        if (self.shown is None) != (self.verdict is Verdict.INCONCLUSIVE):
            raise TypeError(f"{self.verdict} and what the checker accepted do not fit together")

    @property
    def certificates(self) -> tuple[Proved | Refuted, ...]:
        """Everything the checker accepted: of the verdict first, then of every answer and counterexample, once each."""
        answers = [answer.proof for row in self.rows for answer in row.answers]
        found = [self.shown, *answers, *(row.refutation for row in self.rows)]
        return tuple({repr(shown.certificate): shown for shown in found if shown is not None}.values())

    def __bool__(self) -> bool:
        raise TypeError("an analysis has three answers; compare analysis.verdict")

    def __str__(self) -> str:
        from analysis.answers.text import table

        return table(self)

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar a class: proved up to its end, refuted from its cross on, unknown in between.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from analysis.answers.text import class_name
        from analysis.plots.loops import plot_reach

        return plot_reach(self.rows, [class_name(row) for row in self.rows], ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``."""
        from analysis.answers.document import analysis_dict

        return analysis_dict(self)

    def to_xarray(self) -> xarray.Dataset:
        """The table of classes, over the dimension ``law_class``; nan where nothing is proved or refuted.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from analysis.answers.showing import analysis_dataset

        return analysis_dataset(self)

    def _repr_html_(self) -> str:
        from analysis.answers.showing import analysis_html

        return analysis_html(self)


_ROWS: tuple[tuple[Question, bool, bool], ...] = (
    ("sector", False, True),
    ("sector", False, False),
    ("slope", False, False),
    ("slope", True, False),
)


def analyse(loop: object, *, progress: Progress | None = None) -> LoopAnalysis:
    """Every criterion for every kind of class, with the lower end of the class asked about.

    Parameters
    ----------
    loop : LoopSystem, Loop or block
        A system from a file, a block with a law, or a block alone, whatever :func:`lure.inputs.as_block` takes; without
        a law or a class the classes ``[0, k]`` are looked at.
    progress : callable, optional
        Called as ``progress(stage, done)``, ``0 <= done <= 1``.

    Returns
    -------
    LoopAnalysis
        With ``rows``, one :class:`Largest` a kind of class, and ``asked`` for the class of the loop.

    Raises
    ------
    AssumptionError
        The class has no finite lower end, or no criterion applies to the block.
    ContradictionError
        What is proved and what is refuted overlap: a bug.

    Examples
    --------
    >>> from lure import Loop, Saturation, as_block
    >>> found = analyse(Loop(as_block("1/(s+1)"), Saturation(gain=2)))
    >>> print(found.verdict)
    PROVED
    """
    say = progress or (lambda _stage, _done: None)
    about = subject(loop)
    block, law_class = about.block, about.law_class
    case = _case(block)
    lower = {"sector": Fraction(0), "slope": Fraction(0)}
    if law_class is not None:
        lower["sector"] = _finite(law_class.sector.lower)
        lower["slope"] = lower["sector"] if law_class.slope is None else _finite(law_class.slope.lower)
    rows: list[Largest] = []
    for step, (question, odd, varying) in enumerate(_ROWS):
        say(_title(question, odd=odd, varying=varying), step / len(_ROWS))
        if question == "sector":
            rows.append(max_sector(block, lower=lower["sector"], time_varying=varying, search="full"))
        else:
            rows.append(max_slope(block, lower=lower["slope"], odd=odd))
    rows = _spread(rows)
    verdict, evidence, statement, shown = decided(about, rows)
    gains = gain_intervals(block) if isinstance(block, RationalBlock) else ()
    return LoopAnalysis(
        subject=about,
        case=case,
        gains=gains,
        rows=tuple(sorted(rows, key=lambda row: (row.verdict is not Verdict.PROVED, -row.largest.low))),
        asked=asked_row(rows, law_class),
        verdict=verdict,
        evidence=evidence,
        statement=statement,
        shown=shown,
        hints=hints(rows, law_class, gains, verdict),
        not_shown=_not_shown(block, rows),
    )


def _case(block: RationalBlock | DelayBlock) -> Case:
    rational = block if isinstance(block, RationalBlock) else RationalBlock([1], block.denominator)
    return Plant.of(rational).case


def _finite(bound: float | Fraction) -> Fraction:
    if bound == -math.inf:
        raise AssumptionError("the class has no lower end: no criterion here reaches -inf; give a finite lower bound")
    return exact_number(bound, "lower")


def _title(question: Question, *, odd: bool, varying: bool) -> str:
    if question == "sector":
        return f"sector, {'time-varying' if varying else 'time-invariant'} laws"
    return f"slope, {'odd' if odd else 'monotone'} laws"


def _spread(rows: list[Largest]) -> list[Largest]:
    """A counterexample to a class refutes the larger ones before it too, if they begin at the same gain."""
    found = list(rows)
    for place in range(len(found) - 2, -1, -1):
        larger, smaller = found[place], found[place + 1]
        if smaller.refuted_at is None or larger.lower != smaller.lower:
            continue
        if larger.refuted_at is None or smaller.refuted_at < larger.refuted_at:
            low, high = larger.largest.low, smaller.refuted_at
            if larger.verdict is Verdict.PROVED and low >= high:
                raise ContradictionError(f"{larger.criterion} proves up to {low!r}, and {smaller.witness} at {high!r}")
            largest = Bracket(low, max(low, min(larger.largest.high, high)))
            found[place] = replace(larger, refuted_at=high, witness=smaller.witness, largest=largest)
    return found


def _not_shown(block: RationalBlock | DelayBlock, rows: list[Largest]) -> tuple[str, ...]:
    notes = ["a rate of decay, a bound on the size of the motion, anything about external inputs"]
    if getattr(block, "dt", None) is None:
        notes.insert(0, "anything about laws that are not locally Lipschitz")
    if any(row.critical for row in rows):
        notes.insert(
            0,
            "that 0 attracts every motion: the loop with the smallest gain of the class has a pole at 0, and the class "
            "contains laws with more equilibria than 0",
        )
    return tuple(notes)

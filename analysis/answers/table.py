"""``analyse``: every class and every criterion for one loop, in one table, and the verdict on the class asked about."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from analysis.answers.catalogue import Question
from analysis.answers.largest import Largest, rounded_down
from analysis.answers.questions import max_sector, max_slope
from analysis.answers.subject import Subject, subject
from analysis.criteria.hurwitz import GainInterval, gain_intervals
from analysis.evidence import Evidence, Verdict
from analysis.plant import Case, Plant
from lure.delay import DelayBlock
from lure.errors import AssumptionError
from lure.exact import exact_number
from lure.law_class import LawClass
from lure.rational import RationalBlock

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
    hints: tuple[str, ...]
    not_shown: tuple[str, ...]

    def __bool__(self) -> bool:
        raise TypeError("an analysis has three answers; compare analysis.verdict")

    def __str__(self) -> str:
        from analysis.answers.text import table

        return table(self)


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

    Raises
    ------
    AssumptionError
        The class has no finite lower end, or no criterion applies to the block.
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
    asked = _asked(rows, law_class)
    verdict, evidence, statement = _decided(about, rows, asked)
    return LoopAnalysis(
        subject=about,
        case=case,
        gains=gain_intervals(block) if isinstance(block, RationalBlock) else (),
        rows=tuple(sorted(rows, key=lambda row: (row.verdict is not Verdict.PROVED, -row.largest.low))),
        asked=asked,
        verdict=verdict,
        evidence=evidence,
        statement=statement,
        hints=_hints(rows, law_class, verdict),
        not_shown=_not_shown(case, lower["sector"]),
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


def _asked(rows: list[Largest], law_class: LawClass | None) -> Largest | None:
    """The row whose class is that of the question."""
    if law_class is None:
        return None
    if law_class.time_varying:
        return rows[0]
    if law_class.slope is None:
        return rows[1]
    return rows[3] if law_class.odd else rows[2]


def _decided(about: Subject, rows: list[Largest], asked: Largest | None) -> tuple[Verdict, Evidence, str]:
    law_class = about.law_class
    if law_class is None or asked is None:
        best = max(rows, key=lambda row: (row.verdict is Verdict.PROVED, row.largest.low))
        return best.verdict, best.evidence, str(best)
    upper = law_class.sector.upper
    serving = [row for row in rows if _serves(row, law_class)]
    for row in serving:
        end = law_class.slope.upper if row.question == "slope" and law_class.slope is not None else upper
        if row.verdict is Verdict.PROVED and end <= row.largest.low:
            how = f"by the criterion {row.criterion} ({row.evidence}), which reaches {rounded_down(row.largest.low)}"
            said = f"{_meaning(about.block, row)} for every {law_class}, {how}."
            if _rough(about):
                return Verdict.INCONCLUSIVE, row.evidence, _ROUGH.format(law=about.law, said=said)
            return Verdict.PROVED, row.evidence, said
    end = upper if law_class.slope is None else law_class.slope.upper
    witness = asked.witness
    if witness is not None and asked.refuted_at is not None and asked.refuted_at <= end:
        inside = law_class.slope is None or law_class.sector.upper == law_class.slope.upper
        if inside:
            return (
                Verdict.REFUTED,
                witness.evidence,
                f"The loop is not stable for every {law_class}: {witness}. Whether a given law of the class is "
                "destabilising is another question.",
            )
    reach = max((row.largest.low for row in serving if row.verdict is Verdict.PROVED), default=None)
    far = "nothing is proved" if reach is None else f"what is proved ends at {rounded_down(reach)}"
    against = (
        "" if asked.refuted_at is None else f", and the smallest destabilising member found has {asked.refuted_at:.7g}"
    )
    return Verdict.INCONCLUSIVE, Evidence.CERTIFIED, f"Nothing is decided for {law_class}: {far}{against}."


_ROUGH = (
    "Nothing is decided for {law}, which is not locally Lipschitz, as the theorems for continuous time assume. "
    "For the laws that are: {said}"
)


def _rough(about: Subject) -> bool:
    """Whether there is a law, and it lacks the regularity that the theorems for continuous time assume."""
    continuous = getattr(about.block, "dt", None) is None
    return continuous and about.law is not None and not getattr(about.law, "locally_lipschitz", True)


def _meaning(block: RationalBlock | DelayBlock, row: Largest) -> str:
    """What is proved of the motions: the weakest conclusion of the theorems for such a block."""
    if _case(block) != "critical" or row.lower > 0:
        return "The point 0 attracts every motion"
    return "Every motion is bounded" if row.time_varying else "Every motion converges to the set of equilibria"


def _serves(row: Largest, law_class: LawClass) -> bool:
    """Whether the class asked about is contained in the class of the row, but for its upper end."""
    if law_class.time_varying:
        return row.time_varying
    if row.question == "slope":
        return law_class.slope is not None and (law_class.odd or not row.odd)
    return True


def _hints(rows: list[Largest], law_class: LawClass | None, verdict: Verdict) -> tuple[str, ...]:
    """Which property, if the law has it, would decide the question."""
    if law_class is None or verdict is Verdict.PROVED:
        return ()
    end = law_class.sector.upper
    hints: list[str] = []
    serving = [row.largest.low for row in rows if _serves(row, law_class) and row.verdict is Verdict.PROVED]
    if serving and max(serving) > law_class.sector.lower:
        hints.append(f"an upper bound of {rounded_down(max(serving))} instead of {float(end):.7g} would be proved")
    names = ("time-varying", "time-invariance", "slope bounds", "slope bounds and oddness")
    for name, row in zip(names, rows, strict=True):
        if not _serves(row, law_class) and row.verdict is Verdict.PROVED and end <= row.largest.low:
            hints.append(f"{name} of phi would be enough ({row.criterion} reaches {rounded_down(row.largest.low)})")
            break
    return tuple(hints)


def _not_shown(case: Case, lower: Fraction) -> tuple[str, ...]:
    notes = ["no rate of decay, no bound on the size of the motion, and nothing about external inputs"]
    if case == "critical" and lower == 0:
        notes.insert(
            0,
            "the block has a pole at 0 and the class contains laws that vanish on an interval: motions converge to the "
            "set of equilibria, to 0 alone only if phi vanishes nowhere else",
        )
    return tuple(notes)

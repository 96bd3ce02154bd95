"""``analyse``: every class and every criterion for one loop, in one table, and the verdict on the class asked about."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from flint import fmpq_mat, fmpq_poly

from lure.analysis.certificates.drafts import Failure, guarded
from lure.analysis.deadline import check_seconds, time_limit
from lure.analysis.drawing import drawing
from lure.analysis.inequality.gains import GainInterval, gain_intervals
from lure.analysis.inequality.plant import Case, TransferPolynomials
from lure.analysis.numerics.polynomial import to_descending, to_fmpq
from lure.analysis.questions.advice import hints, row_asked
from lure.analysis.questions.answers import answers
from lure.analysis.questions.channel_kinds import channel_hints, channel_kinds, has_channels
from lure.analysis.questions.channel_map import StabilityMap, stability_map
from lure.analysis.questions.channel_problem import channel_problem, loop_plant
from lure.analysis.questions.conclusion import Conclusion
from lure.analysis.questions.largest import CHECK, UNFINISHED, StabilityBound, Stopped, number_or_nan
from lure.analysis.questions.problem import Plant, Problem, loop_given, problem_of
from lure.analysis.questions.search import GRACE
from lure.analysis.theorems.table import Question
from lure.analysis.verdict import Evidence, Verdict
from lure.arrays import np
from lure.classes import Sector, SlopeBounds
from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay import DelayPlant
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.family import PlantFamily
from lure.plants.matrices import MAX_EXACT_STATES
from lure.plants.multivariable import MultivariablePlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import Column, Page, Record, plain, quantity
from lure.record.base import aligned

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.certificates.codes import Code
    from lure.analysis.drawing import Axes
    from lure.classes import NonlinearityClass

# A loop's analysis as plain data, the ``loop`` part of ``report.json``.


def _loop(problem: Problem) -> dict[str, Any]:
    plant, given = problem.plant, problem.given
    step = plant.dt
    data: dict[str, Any] = {"text": str(plant), "denominator": None, "numerator": None, "terms": None}
    data["dt"] = None if step is None else str(step)
    data |= {"any_period": True} if getattr(plant, "any_period", False) else {}
    if isinstance(plant, StateSpace | MultivariablePlant):
        data["matrices"] = plant.to_dict()
    elif isinstance(plant, DelayMatrix):
        late = [[str(delay), [[str(v) for v in row] for row in rows]] for delay, rows in plant.late]
        inner = [[[str(v) for v in row] for row in rows] for rows in plant.inner]
        data["matrices"] = {**plant.base.to_dict(), "late": late, **({"inner": inner} if inner else {})}
        if plant.rates:
            data["matrices"]["rates"] = [
                [[[str(v) for v in row] for row in side] for side in one] for one in plant.rates
            ]
    elif isinstance(plant, PlantFamily | ChannelFamily):
        if isinstance(plant, PlantFamily):
            data["numerator"], data["denominator"] = plant.sides
            if plant.delay:
                data["delay"] = plant.wait_text
        else:
            data["matrices"] = plant.sides
        pairs = zip(plant.names, plant.box, strict=True)
        data["parameters"] = {name: [str(low), str(high)] for name, (low, high) in pairs}
    elif isinstance(plant, RationalPlant | DelayPlant):
        data["denominator"] = [str(c) for c in plant.denominator]
        if isinstance(plant, RationalPlant):
            data["numerator"] = [str(c) for c in plant.numerator]
        else:
            data["terms"] = [[str(delay), [str(c) for c in top]] for delay, top in plant.terms]
            if plant.feedback:
                data["feedback"] = [[str(delay), [str(c) for c in top]] for delay, top in plant.feedback]
    return {
        "name": problem.name,
        "title": problem.title,
        "source": problem.source,
        "law": None if problem.nonlinearity is None else str(problem.nonlinearity),
        "class": None if given is None else class_dict(given),
        "block": data,
        **(_channels(problem) if problem.several else {}),
    }


def _channels(problem: Problem) -> dict[str, Any]:
    """What is asked and known of each of several channels."""
    names = () if isinstance(problem.plant, ChannelFamily) else loop_plant(problem.plant).names
    return {
        "channels": [
            {
                "name": names[i] if names else f"channel {i + 1}",
                "class": class_dict(one),
                "law": str(problem.known[i]) if problem.known else None,
            }
            for i, one in enumerate(problem.classes.classes)
        ],
        "repeated": [len(block) for block in problem.classes.blocks],
        **({"classes": problem.classes.to_dict()} if problem.kind == "class" else {}),
    }


def class_dict(nonlinearity_class: NonlinearityClass) -> dict[str, Any]:
    """A class of nonlinearities as plain data."""
    slope = nonlinearity_class.slope
    return {
        "sector": [plain(float(nonlinearity_class.sector.lower)), plain(float(nonlinearity_class.sector.upper))],
        "slope": None if slope is None else [plain(float(slope.lower)), plain(float(slope.upper))],
        "odd": nonlinearity_class.odd,
        "time_varying": nonlinearity_class.time_varying,
        "text": str(nonlinearity_class),
        **({"linear": True} if nonlinearity_class.linear else {}),
        **({"relu": True} if nonlinearity_class.rectifier else {}),
    }


# A loop's analysis as plain text, at most 100 columns wide.

WIDTH = 100
HEAD = ("class", "criterion", "proved up to", "evidence", "refuted at", "by", "gap")


def table_row(row: StabilityBound) -> tuple[str, ...]:
    """A class of nonlinearities as the cells under :data:`HEAD`.

    ``row``: the answer for that class.
    """
    proved = row.verdict is Verdict.PROVED
    return (
        row.class_name,
        row.criterion if proved else "-",
        row.proved_up_to if proved else "-",
        str(row.evidence) if proved else "-",
        row.refuted_text or "-",
        ", ".join(witness.kind for witness in (row.trivial, row.witness) if witness is not None) or "-",
        row.gap,
    )


Progress = Callable[[str, float], None]


class LoopAnalysis(Record):
    r"""What was found about ``sigma = H mu``, ``mu = -phi(sigma)``."""

    problem: Problem = quantity("The loop: its name, plant, nonlinearity and the class asked about")
    case: Case | None = quantity(
        "Its poles, of every plant: all stable; one simple one at 0 (``z = 1``), or of several channels some, besides "
        "stable ones; or anything else, with parameters of some plants.  None where that was not decided"
    )
    gains: tuple[GainInterval, ...] | None = quantity(
        "All linear gains for which the loop is stable; None where they were not computed"
    )
    rows: tuple[StabilityBound, ...] = quantity("One for each class of nonlinearities, largest sector first")
    asked: StabilityBound | None = quantity("The row of that class")
    conclusion: Conclusion = quantity(
        "What follows for the class asked about and the nonlinearity given; without a class for the row that reaches "
        "farthest"
    )
    hints: tuple[str, ...] = quantity("What would decide more: a smaller sector, a property of ``phi``")
    not_shown: tuple[str, ...] = quantity("What must not be read into it")
    map: StabilityMap | None = quantity(
        "With two channels, for which upper bounds of the two the loop is proved stable, refuted, or neither",
        default=None,
    )
    _no_truth = "an analysis has three answers; compare analysis.verdict"

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

    def _unproved(self) -> str:
        """Why nothing was proved of the class asked about, where the statement does not say it; empty elsewhere."""
        asked = self.asked
        if asked is None or Verdict.PROVED in (self.verdict, asked.verdict):
            return ""
        known = self.problem.nonlinearity is not None
        why = asked.reason.partition("; give ")[0] if known else asked.reason  # see the hints
        return "" if why in self.statement else why

    def _below_table(self) -> str:
        """What the numbers of the table are, with several channels; else the stable linear gains."""
        if not self.problem.several:
            return f"Linear gains for which the loop is stable: {self._gains_words()}."
        factors = f"The numbers are factors of every upper bound of: {self.problem.classes}; lower bounds stay."
        if self.map is None or not (self.map.proved and self.map.refuted):
            return factors
        corners = ", ".join(f"({a}, {b})" for a, b in self.map.proved_texts)
        return f"{factors} Pairs (k1, k2) of upper bounds that are proved, with all smaller ones: {corners}."

    def _gains_words(self) -> str:
        """The intervals of stable linear gains in words."""
        return "not computed" if self.gains is None else ", ".join(map(str, self.gains)) or "none"

    def __str__(self) -> str:
        blocks = [
            f"{self.verdict}  {self.problem.name}: {'' if self.problem.several else 'H = '}{self.problem.plant}",
            textwrap.fill(self.statement, WIDTH),
            *([textwrap.fill(f"Nothing is proved: {why}.", WIDTH)] if (why := self._unproved()) else []),
            *([] if self.stopped is None else [UNFINISHED[self.stopped]]),
            "\n".join(aligned([HEAD, *(table_row(row) for row in self.rows)])),
            textwrap.fill(self._below_table(), WIDTH),
            *(textwrap.fill(f"To decide more: {hint}.", WIDTH) for hint in self.hints),
            *(textwrap.fill(f"Not shown: {note}.", WIDTH) for note in self.not_shown),
        ]
        return "\n\n".join(blocks)

    def plot(self, ax: Axes | None = None) -> Axes:
        """One bar a class: proved up to its end, refuted from its cross on, unknown in between; ``map.plot`` for two.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)(self.rows, [row.class_name for row in self.rows], ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``."""
        return {
            **_loop(self.problem),
            "case": self.case,
            "verdict": str(self.verdict),
            "evidence": str(self.evidence),
            "statement": self.statement,
            "headline": self.conclusion.headline,
            "meaning": self.conclusion.meaning,
            "law_class": self.conclusion.nonlinearity_class,
            "membership": self.conclusion.membership,
            "assumed": list(self.conclusion.assumed),
            "attracts": self.conclusion.attracts,
            "reason": self.reason,
            "code": None if self.code is None else self.code.identifier,
            "gains": None if self.gains is None else [str(interval) for interval in self.gains],
            "answers": [row.to_dict() for row in self.rows],
            "hints": list(self.hints),
            "not_shown": list(self.not_shown),
            "stopped": self.stopped,
            **({} if self.map is None else {"map": self.map.to_dict()}),
        }

    def _columns(self) -> dict[str, Column]:
        """The table of classes, over the dimension ``nonlinearity_class``; nan where nothing is proved or refuted."""
        along, rows = ("law_class",), self.rows
        proved = [row.largest.low if row.verdict is Verdict.PROVED else math.nan for row in rows]
        return {
            "law_class": Column(along, [row.class_name for row in rows], "1", "kind of the class"),
            "proved_up_to": Column(along, proved, "1", "largest k proved"),
            "refuted_at": Column(along, [number_or_nan(row.refuted_at) for row in rows], "1", "smallest k refuted"),
            "criterion": Column(along, [row.criterion for row in rows], "1", "criterion with the largest class"),
            "verdict": Column(along, [str(row.verdict) for row in rows], "1", "whether something is proved"),
            "evidence": Column(along, [str(row.evidence) for row in rows], "1", "what it rests on"),
            "closed": Column(along, [row.closed for row in rows], "1", "whether proved and refuted meet"),
        }

    def _attributes(self) -> dict[str, object]:
        return {
            "title": self.problem.name,
            "block": str(self.problem.plant),
            "verdict": str(self.verdict),
            "evidence": str(self.evidence),
            "comment": self.statement,
            "not_shown": list(self.not_shown),
        }

    def _page(self) -> Page:
        """The table of classes, with the verdict on the class asked about and what was not shown."""
        notes = [
            self.statement,
            *([] if self.stopped is None else [UNFINISHED[self.stopped]]),
            f"Evidence: {self.evidence}. {self._below_table()}",
            *(f"To decide more: {hint}." for hint in self.hints),
            *(f"Not shown: {note}." for note in self.not_shown),
            *([] if self.shown is None else [CHECK.format("shown")]),
        ]
        title = f"{self.problem.name}: H = {self.problem.plant}"
        return Page(title, [table_row(row) for row in self.rows], head=HEAD, verdict=str(self.verdict), notes=notes)


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
        A system from a file, a block with a nonlinearity, or a block alone, whatever :func:`lure.plants.as_plant`
        takes; without a nonlinearity or a class the classes ``[0, k]`` are looked at.
    nonlinearity : object
        What closes the loop around a block: a nonlinearity, a formula as text, ``control.saturation_nonlinearity``, or
        the class asked about as a ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``.
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
        No criterion applies to the block.
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
    if has_channels(loop, nonlinearity):
        return _of_channels(channel_problem(loop, nonlinearity, late=True), seconds, progress)
    problem = problem_of(loop_given(loop, nonlinearity))
    plant, given = problem.plant, problem.given
    lower = dict.fromkeys(("sector", "slope"), Fraction(0))
    if given is not None and not (isinstance(plant, DelayPlant) and given.sector.lower in (0, -math.inf)):
        lower = {"sector": _start(given.sector), "slope": _start(given.slope or given.sector)}
    asked = [
        Problem.largest(plant, question, lower=lower[question], odd=odd, time_varying=varying)
        for question, odd, varying in _ROWS
    ]
    beside = (
        [] if given is None or problem.linear else [problem]
    )  # constant gains are decided by a criterion of their own
    found = answers([*asked, *beside], seconds=seconds, progress=progress)
    found += answers([problem], seconds=seconds) if problem.linear else []
    rows = [row for row in found if isinstance(row, StabilityBound)]
    conclusion = _farthest(rows).conclusion if given is None else found[-1].conclusion
    with time_limit(GRACE if any(row.stopped == "time" for row in rows) else None):
        gains = _gains(plant)
    return LoopAnalysis(
        problem=problem,
        case=_case(plant, rows),
        gains=gains,
        rows=tuple(sorted(rows, key=lambda row: (row.verdict is not Verdict.PROVED, -row.largest.low))),
        asked=None if given is None else row_asked(rows, given),
        conclusion=conclusion,
        hints=hints(problem, rows, gains or (), conclusion),
        not_shown=_not_shown(problem.plant, rows, conclusion),
    )


def _of_channels(problem: Problem, seconds: float | None, progress: Progress | None) -> LoopAnalysis:
    """The same of several channels: the classes asked about, every factor of them, and with less or more assumed."""
    tell, two = (
        progress or (lambda _step, _done: None),
        len(problem.classes.blocks) == len(problem.classes.classes) == 2,
    )
    share = 0.6 if two else 1.0
    kinds = channel_kinds(problem)
    asked = problem.kind == "class"
    found = answers(
        [*kinds, *([problem] if asked else [])],
        seconds=None if seconds is None else share * seconds,
        progress=lambda step, done: tell(step, share * done),
    )
    rows = [row for row in found if isinstance(row, StabilityBound)]
    map_of_two = None
    if two:
        drawn = guarded(
            "the map",
            lambda: stability_map(
                problem,
                known=rows,
                seconds=None if seconds is None else (1 - share) * seconds,
                progress=lambda step, done: tell(step, share + (1 - share) * done),
            ),
            passing=(InputError,),
        )
        map_of_two = None if isinstance(drawn, Failure) else drawn
    conclusion = found[-1].conclusion if asked else _farthest(rows).conclusion
    row = next((each for each in rows if each.classes == problem.classes), None)
    return LoopAnalysis(
        problem=problem,
        case=_channel_case(problem, rows),
        gains=None,
        rows=tuple(sorted(rows, key=lambda each: (each.verdict is not Verdict.PROVED, -each.largest.low))),
        asked=row if asked else None,
        conclusion=conclusion,
        hints=channel_hints(problem, row, rows, conclusion) if asked else (),
        not_shown=_not_shown(problem.plant, rows, conclusion),
        map=map_of_two,
    )


def _channel_case(problem: Problem, rows: list[StabilityBound]) -> Case | None:
    """By a proof with the gains 0 as a member, else by an exact count of the poles, where there are few."""
    zero = not any(problem.classes.lower) and not problem.classes.rectified
    proved = [row for row in rows if zero and row.verdict is Verdict.PROVED]
    if proved:
        return "critical" if any(row.critical for row in proved) else "stable"
    if isinstance(problem.plant, DelayMatrix) and problem.plant.inner:
        return None
    return _together([_poles(one) for one in _rational_parts(problem)])


def _poles(plant: StateSpace | MultivariablePlant) -> Case | None:
    """The case of a plant, exactly; of many states only poles that are far outside are seen, in floating point."""
    A = plant.A.tolist() if isinstance(plant, StateSpace) else plant.A
    if plant.order <= MAX_EXACT_STATES:
        d = fmpq_mat([[to_fmpq(v) for v in row] for row in A]).charpoly() if plant.order else fmpq_poly([1])
        return TransferPolynomials.of(RationalPlant([1], to_descending(d), plant.dt)).case
    poles = np.linalg.eigvals(np.array(A, dtype=float))
    outside = poles.real if plant.dt is None else np.abs(poles) - 1
    return "unstable" if (outside > 1e-6 * np.abs(poles).max()).any() else None


def _together(cases: Sequence[Case | None]) -> Case | None:
    """The case of one plant, or of several out of a box, of which unstable ones alone decide."""
    return cases[0] if len(cases) == 1 else "unstable" if "unstable" in cases else None


def _rational_parts(problem: Problem) -> list[MultivariablePlant]:
    """The plant, without what arrives late; of a box of plants those in the middle and at its corners."""
    if isinstance(problem.plant, ChannelFamily):
        return [problem.plant.at(point) for point in (problem.plant.middle, *problem.plant.corners)]
    plant = loop_plant(problem.plant)
    return [plant.base if isinstance(plant, DelayMatrix) else plant]


def _farthest(rows: list[StabilityBound]) -> StabilityBound:
    """The row that says most where no class is asked about."""
    return max(rows, key=lambda row: (row.verdict is Verdict.PROVED, row.largest.low, not row.time_varying))


def _gains(block: Plant) -> tuple[GainInterval, ...] | None:
    """The intervals of stable linear gains; None where there is no way or no time to compute them."""
    found = guarded("linear gains", lambda: gain_intervals(block)) if isinstance(block, RationalPlant) else None
    return None if isinstance(found, Failure) else found


def _case(block: Plant, rows: list[StabilityBound]) -> Case | None:
    """By an exact count of the poles, or by a proof with ``phi = 0`` as a member; None where neither decides."""
    if isinstance(block, RationalPlant | DelayPlant) and not getattr(block, "feedback", ()):
        rational = block if isinstance(block, RationalPlant) else RationalPlant([1], block.denominator)
        return TransferPolynomials.of(rational).case
    for row in rows:
        if row.verdict is Verdict.PROVED and row.lower <= 0 <= row.largest.low:
            return "critical" if row.critical and row.lower == 0 else "stable"
    if isinstance(block, PlantFamily):
        points = (block.middle, *block.corners)
        return _together([TransferPolynomials.of(block.undelayed(point)).case for point in points])
    return _poles(block) if isinstance(block, StateSpace) else None


def _start(bounds: Sector | SlopeBounds) -> Fraction:
    """Where the rows begin: at the lower end of the class, or at 0 where that has none."""
    return Fraction(0) if bounds.lower == -math.inf else exact_number(bounds.lower, "lower")


def _not_shown(plant: Plant, rows: list[StabilityBound], found: Conclusion) -> tuple[str, ...]:
    notes = ["a rate of decay, a bound on the size of the solution, anything about external inputs"]
    if found.shown is None or found.shown.certificate["laws"].get("regularity") is None:
        notes.insert(0, "anything about nonlinearities that are not locally Lipschitz")
    if any(row.critical for row in rows) and (found.nonlinearity or not found.attracts):
        of = f" with another phi than {found.nonlinearity}" if found.attracts and found.nonlinearity else ""
        notes.insert(
            0,
            f"that 0 attracts every solution{of}: the loop with the smallest gain of the class has a pole at "
            f"{'0' if plant.dt is None else 'z = 1'}, and the class contains nonlinearities with more equilibria than "
            "0",
        )
    return tuple(notes)

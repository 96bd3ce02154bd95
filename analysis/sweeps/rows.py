"""One point of a sweep: the question asked and its answer as a row of named values."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, cast

from lure.analysis import questions  # each function is imported when a question needs it: processes start sooner
from lure.errors import AssumptionError, InputError, Reason
from lure.extensions import extension
from lure.files.reading import SystemSource

if TYPE_CHECKING:
    from lure.analysis.questions.largest import StabilityBound
    from lure.classes import NonlinearityClass
    from lure.files.system import LoopSystem

Row = dict[str, Any]
Kind = Literal["text", "number"]
Certificate = Mapping[str, Any]


class Variable(NamedTuple):
    """A variable of the data set: what it holds, in which unit, and what it says."""

    kind: Kind
    unit: str
    text: str


VARIABLES: dict[str, Variable] = {
    "verdict": Variable("text", "1", "PROVED, REFUTED or INCONCLUSIVE; empty where the point failed"),
    "evidence": Variable("text", "1", "what the verdict rests on: certified, computed or observed"),
    "largest_low": Variable("number", "1", "largest k proved, rounded down; inf: every finite k"),
    "largest_high": Variable("number", "1", "no larger k can be proved, rounded up"),
    "refuted_at": Variable("number", "1", "smallest k with a destabilising member that was found"),
    "low": Variable("number", "1", "lower end of the gain, of the rate, or of the size of the region"),
    "high": Variable("number", "1", "upper end of the gain, of the rate, or of the size of the region"),
    "criterion": Variable("text", "1", "the theorem behind the verdict"),
    "margin": Variable("number", "1", "least value of the frequency inequality for a class that is given"),
    "slowest_decay": Variable("number", "1/s", "decay of the slowest wave mode of the rod, of its linear part"),
    "theta": Variable("number", "s", "multiplier of Popov's criterion"),
    "code": Variable("text", "1", "why the verdict is INCONCLUSIVE, or LURE-I007 where the time allowed was over"),
    "error": Variable("text", "1", "why the point failed, in one sentence; empty where it did not"),
    "seconds": Variable("number", "s", "time taken"),
    "scheme_verdict": Variable("text", "1", "as verdict, of the scheme with N cells"),
    "scheme_largest_low": Variable("number", "Pa/m", "as largest_low, of the scheme"),
    "scheme_slowest_decay": Variable("number", "1/s", "decay of the slowest wave mode of the scheme"),
    "circle": Variable(
        "number", "Pa/m", "the circle criterion holds for [0, k] below it, for the rod and every scheme"
    ),
}
_USED = {
    "rod": (
        "verdict evidence largest_low largest_high refuted_at criterion margin slowest_decay theta code error seconds "
        "scheme_verdict scheme_largest_low scheme_slowest_decay circle"
    ),
    "sector": "verdict evidence largest_low largest_high refuted_at criterion margin theta code error seconds",
    "slope": "verdict evidence largest_low largest_high refuted_at criterion margin theta code error seconds",
    "class": "verdict evidence criterion theta code error seconds",
    "gain": "verdict evidence low high criterion code error seconds",
    "rate": "verdict evidence low high criterion code error seconds",
    "region": "verdict evidence low high criterion code error seconds",
}
_MEASURES = {
    "gain": ("1", "the L2 gain"),
    "rate": ("1/s or 1", "the rate, 1/s in continuous time and a factor per sample in discrete time"),
    "region": ("1", "the size of the region"),
}
_MOMENT = 0.01  # [s]
APART = ("seconds",)  # what differs between two runs of the same study


def variables(ask: tuple[str, ...]) -> dict[str, Variable]:
    """The variables of the answers to some questions."""
    used = {name for question in ask for name in _USED[question].split()}
    found = {name: one for name, one in VARIABLES.items() if name in used}
    if "rod" in ask:
        found |= {name: found[name]._replace(unit="Pa/m") for name in ("largest_low", "largest_high", "refuted_at")}
    if len(ask) == 1 and ask[0] in _MEASURES:
        unit, measure = _MEASURES[ask[0]]
        found |= {
            end: Variable("number", unit, f"{name} end of {measure}")
            for end, name in (("low", "lower"), ("high", "upper"))
        }
    return found


@dataclass(frozen=True, slots=True)
class Answered:
    """A row, and the certificates of what it says."""

    row: Row
    certificates: tuple[Certificate, ...] = ()


def answered(
    source: SystemSource, settings: list[str], question: str, seconds: float | None = None, *, plain: bool = False
) -> Answered:
    """The answer of one point; a point that fails is a row with its sentence.

    Parameters
    ----------
    source : SystemSource
        The system.
    settings : list of str
        What the point changes.
    question : str
        One of the questions.
    seconds : float or None
        Time allowed.
    plain : bool
        Whether it is asked as a user asks it, with every sentence and criterion; the row is the same.
    """
    begun = time.perf_counter()
    try:
        system = source.changed(settings)
        found = _ASKED[question](system, seconds, plain=plain)
    except (InputError, AssumptionError) as error:
        found = Answered({"verdict": "", "error": str(error), "code": str(error.code or "")})
    except (ArithmeticError, RuntimeError, MemoryError) as error:  # a point never ends a run; its row says so
        found = Answered({"verdict": "", "error": f"{type(error).__name__}: {error}"})
    found.row["seconds"] = time.perf_counter() - begun
    return found


def refusal(source: SystemSource, settings: list[str], question: str) -> str:
    """Why a point that is read cannot be asked this question, as far as a moment shows; else empty.

    ``source``, ``settings``, ``question``: as for :func:`answered`.
    """
    try:
        system = source.changed(settings)
    except InputError:  # that point fails, whatever it is asked
        return ""
    try:
        _ASKED[question](system, _MOMENT, plain=False)
    except (InputError, AssumptionError) as error:
        return str(error)
    except (ArithmeticError, RuntimeError, MemoryError):
        return ""
    return ""


class Ask(Protocol):
    """A question."""

    def __call__(self, system: Any, seconds: float | None, *, plain: bool) -> Answered:  # noqa: ANN401  (any system)
        """Its answer for a system, found within so many seconds, as a user asks it or not."""


def _own(system: Any, seconds: float | None, *, plain: bool) -> Answered:  # noqa: ANN401  (a system with a row of its own)
    """What a kind of system that is no loop says of itself, such as a rod."""
    row = extension("sweep", system)
    assert row is not None, "the study has seen that there is one"
    found: Answered = row(system, seconds, plain=plain)
    return found


def _largest(question: Literal["sector", "slope"]) -> Ask:
    """The largest sector or slope bound; with several channels the largest factor of the upper bounds."""

    def found(system: LoopSystem, seconds: float | None, *, plain: bool) -> Answered:
        """The row of the largest sector or slope."""
        from lure.analysis.questions.answers import answer, largest_plant, max_sector, max_slope
        from lure.analysis.questions.problem import Problem

        ask: Any = max_sector if question == "sector" else max_slope
        if system.classes is not None:
            bound = ask(system.block, system.classes, seconds=seconds)
        else:
            given = system.nonlinearity_class
            if question == "slope" and given is not None and given.time_varying:
                raise InputError(
                    "the class depends on time, and slopes are asked of nonlinearities that do not; ask for the sector"
                )
            low = given.sector.lower if given is not None and given.sector.lower > -math.inf else 0
            more: dict[str, Any] = {} if given is None else _said(question, given)
            if plain:
                bound = ask(system.block, lower=low, seconds=seconds, **more)
            else:
                more["search"] = "linear" if question == "sector" else "full"
                problem = Problem.largest(largest_plant(system.block), question, lower=Fraction(low), **more)
                bound = cast("StabilityBound", answer(problem, seconds=seconds, brief=True))
        best = bound.answers[0] if bound.answers else None
        row = {
            "verdict": str(bound.verdict),
            "evidence": str(bound.evidence),
            "largest_low": bound.largest.low,
            "largest_high": bound.largest.high,
            "refuted_at": math.nan if bound.refuted_at is None else bound.refuted_at,
            "criterion": bound.criterion,
            "margin": math.nan if best is None or best.margin is None else best.margin.low,
            "theta": math.nan if bound.theta is None else bound.theta,
            "code": _code(bound, bound.conclusion.code),
        }
        sides = (bound.conclusion.shown, None if bound.witness is None else bound.witness.refutation)
        return Answered(row, tuple(one.certificate for one in sides if one is not None))

    return found


def _said(question: str, given: NonlinearityClass) -> dict[str, Any]:
    return {"time_varying": given.time_varying} if question == "sector" else {"odd": given.odd}


def _class(system: LoopSystem, seconds: float | None, *, plain: bool) -> Answered:
    """The class of the file, or that of its nonlinearity."""
    from lure.analysis.questions.certify import ProofOptions, certify

    found = certify(system, ways=ProofOptions(seconds=seconds))
    shown, code = found.shown, found.conclusion.code
    row = {
        "verdict": str(found.verdict),
        "evidence": str(found.conclusion.evidence),
        "criterion": "" if shown is None else str(shown.theorem),
        "theta": math.nan,
        "code": "" if code is None else code.identifier,
    }
    return Answered(row, () if shown is None else (shown.certificate,))


def _code(bound: Any, code: Any) -> str:  # noqa: ANN401  (any answer, and the code of one that is open)
    """Why an answer is open, or that its time was over."""
    if bound.stopped == "time":
        return str(Reason.OUT_OF_TIME)
    return "" if code is None else str(code.identifier)


def _both_ways(question: Literal["l2_gain", "decay_rate"], name: str) -> Ask:
    """A question whose answer is a bracket: a gain or a rate."""

    def found(system: LoopSystem, seconds: float | None, *, plain: bool) -> Answered:
        """The row of a gain or a rate."""
        bound = getattr(questions, question)(system, seconds=seconds)
        bracket = getattr(bound, name)
        row = {
            "verdict": str(bound.verdict),
            "evidence": str(bound.evidence),
            "low": bracket.low,
            "high": bracket.high,
            "criterion": bound.criterion,
            "code": _code(bound, getattr(bound, "code", None)),
        }
        sides = (bound.proof, bound.refutation)
        return Answered(row, tuple(one.certificate for one in sides if one is not None))

    return found


def _region(system: LoopSystem, seconds: float | None, *, plain: bool) -> Answered:
    """Length, area or volume of the region of attraction of 0."""
    from lure.analysis.questions.regions import region

    found = region(system, seconds=seconds)
    low, high = found.area
    row = {
        "verdict": str(found.verdict),
        "evidence": str(found.evidence),
        "low": low,
        "high": math.inf if high is None else high,
        "criterion": found.criterion,
        "code": str(Reason.OUT_OF_TIME) if found.stopped == "time" else "",
    }
    sides = (found.proof, found.refutation)
    return Answered(row, tuple(one.certificate for one in sides if one is not None))


_ASKED: Mapping[str, Ask] = {
    "rod": _own,
    "sector": _largest("sector"),
    "slope": _largest("slope"),
    "class": _class,
    "gain": _both_ways("l2_gain", "gain"),
    "rate": _both_ways("decay_rate", "rate"),
    "region": _region,
}

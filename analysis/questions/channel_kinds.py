"""Several nonlinearities: the kinds of classes that an analysis asks about beside the given, and what would help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lure.analysis.numerics.doubles import bound_below
from lure.analysis.questions.conclusion import Conclusion
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Verdict
from lure.classes import FULL_BLOCK, Diagonal, NonlinearityClass, Sector, SlopeBounds
from lure.errors import InputError
from lure.files.system import LoopSystem, ManyChannels
from lure.loop import Loop, LoopModel
from lure.plants import as_plant
from lure.plants.block import StructuredPlant

_KINDS = ("sector, time-varying", "sector", "slope", "slope, odd")


def has_channels(loop: object, given: object) -> bool:
    """Whether a question is about several channels: the plant has them, or a list says what closes each.

    ``loop``, ``given``: what :func:`lure.analysis.analyse` takes.

    Raises
    ------
    InputError
        A system that says itself what closes the loop has classes beside it.
    """
    one = isinstance(given, NonlinearityClass) and (
        given.rectifier or given.operator or given.memory or given.rate is not None
    )
    if one or isinstance(given, Diagonal | list | tuple | Mapping):
        if isinstance(loop, LoopSystem) and not loop.open:
            raise InputError(
                "a LoopSystem closes the loop itself and classes are given beside it; leave one of the two out, or "
                "give the plant alone, loop.block"
            )
        return True
    if isinstance(loop, Problem):
        return loop.several
    if isinstance(loop, LoopSystem):
        return isinstance(loop.block, ManyChannels)
    if isinstance(loop, Loop | LoopModel | StructuredPlant):
        return False
    return isinstance(as_plant(loop), ManyChannels)


def channel_kinds(problem: Problem) -> list[Problem]:
    """The questions for the largest factors of an analysis: larger classes before smaller ones, the given one too.

    Constant gains stay constant gains in each, and ReLUs stay such; the bounds are those of the classes given.

    ``problem``: the question about several nonlinearities.
    """
    classes = [problem.classes]
    for kind in _KINDS:
        known = [bool(one.linear or one.rectifier or one.operator or one.memory) for one in problem.classes.classes]
        if all(known):
            break
        changed = tuple(
            one if keeps else _of_kind(one, kind) for one, keeps in zip(problem.classes.classes, known, strict=True)
        )
        same = problem.classes.repeated if kind != _KINDS[0] else _apart(problem.classes)
        classes.append(Diagonal(changed, repeated=same))
    unique = list(dict.fromkeys(classes))
    unique.sort(key=lambda one: [_KINDS.index(_kind(each)) for each in one.classes if not each.operator])
    return [
        replace(problem, classes=one, kind="sector" if "sector" in kind_name(one) else "slope", known=())
        for one in unique
    ]


def _named(one: NonlinearityClass) -> str:
    if one.memory or "delay" in one.operator:
        return one.memory or one.operator
    if one.operator == FULL_BLOCK:
        return "full-block sector"
    return "operator" if one.operator else "gain" if one.linear else "ReLU" if one.rectifier else _kind(one)


def _apart(classes: Diagonal) -> bool | tuple[int, ...]:
    """Every nonlinearity by itself, operators as they are."""
    sizes = [(len(block),) if block in classes.operators else (1,) * len(block) for block in classes.blocks]
    return tuple(size for block in sizes for size in block) if classes.operators else False


def _kind(one: NonlinearityClass) -> str:
    if one.time_varying:
        return _KINDS[0]
    return _KINDS[1] if one.slope is None else _KINDS[3 if one.odd else 2]


def _of_kind(one: NonlinearityClass, kind: str) -> NonlinearityClass:
    """The class with the same bounds and other properties."""
    low, high = one.gains
    slope = SlopeBounds(low, high) if "slope" in kind else None
    return NonlinearityClass(
        sector=Sector(low, high), slope=slope, odd="odd" in kind, time_varying="time-varying" in kind
    )


def kind_name(classes: Diagonal) -> str:
    """The classes in a few words; ``classes``: of several channels."""
    kinds = list(dict.fromkeys(map(_named, classes.classes)))
    same = ", some the same" if classes.repeated else ""
    if len(classes.blocks) == 1:
        same = ", the same in all channels" if len(classes.classes) > 1 else ""
    return (kinds[0] if len(kinds) == 1 else "/".join(kinds)) + same


def channel_hints(
    problem: Problem, asked: StabilityBound | None, rows: Sequence[StabilityBound], conclusion: Conclusion
) -> tuple[str, ...]:
    """What would decide more: a smaller factor, a property that the classes do not have.

    ``problem``: the question about several nonlinearities; ``asked``: the largest factor of its classes; ``rows``:
    those of all kinds; ``conclusion``: what follows for the classes asked about.
    """
    if conclusion.verdict is Verdict.PROVED or problem.classes.rectified:
        return ()
    found: list[str] = []
    if asked is not None and asked.verdict is Verdict.PROVED and asked.largest.low > 0:
        found.append(f"upper bounds {bound_below(asked.largest.low)} times those given would be proved")
    enough = [row for row in rows if row.verdict is Verdict.PROVED and row.largest.low >= 1 and row.classes is not None]
    found += [
        f"'{kind_name(row.classes)}' in every channel would be enough ({row.criterion} reaches the factor "
        f"{row.proved_text})"
        for row in enough[:1]
        if row.classes is not None
    ]
    return tuple(found)

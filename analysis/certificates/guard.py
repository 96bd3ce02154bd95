"""Searches that may fail in any way, kept from taking the answer with them: an exception becomes a code."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from analysis.certificates.codes import Code, code_for

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True, slots=True)
class Failure:
    """A search that showed nothing.

    Attributes
    ----------
    search : str
        Which one.
    code : Code
        How it ended.
    detail : str
        The sentence or the exception behind the code.
    """

    search: str
    code: Code
    detail: str

    def __str__(self) -> str:
        return f"{self.search}: {self.code.title} ({self.code.identifier}): {self.detail}"


def guarded(search: str, work: Callable[[], T], *, passing: tuple[type[Exception], ...] = ()) -> T | Failure:
    """What the work returns, or its failure; the user's interrupt passes.

    Parameters
    ----------
    search : str
        A name for the work.
    work : callable
        Called without arguments.
    passing : tuple of type
        Exceptions that are the caller's to answer.

    Notes
    -----
    ``KeyboardInterrupt``, ``SystemExit`` and ``GeneratorExit`` are no results of a search, and pass.
    """
    try:
        return work()
    except BaseException as error:  # a panic of a compiled solver is no Exception
        if isinstance(error, (KeyboardInterrupt, SystemExit, GeneratorExit, *passing)):
            raise
        sentence = " ".join(str(error).split())
        named = type(error).__name__ in ("AssumptionError", "InputError", "Rejected", "Malformed", "Uncovered")
        detail = sentence if named and sentence else f"{type(error).__name__}: {sentence}".rstrip(": ")
        return Failure(search=search, code=code_for(error), detail=detail[:400])

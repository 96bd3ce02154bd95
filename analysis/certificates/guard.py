"""Searches that may fail in any way, kept from taking the answer with them: an exception becomes a code."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import TypeVar

from analysis.certificates.codes import Code, code_for

T = TypeVar("T")
_AGAIN = 0.5  # [s] until a search that swallowed the first TimeoutError gets another


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


@contextmanager
def time_limit(seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Raise ``TimeoutError`` in the body when the time is over; yields a function that says whether it is.

    Parameters
    ----------
    seconds : float or None
        Time allowed; None for ever.

    Notes
    -----
    By an alarm where the system has one and this is the main thread, repeated for a search that swallows it; it waits
    for compiled code to return.  Elsewhere the body has to ask.
    """
    if seconds is None:
        yield lambda: False
        return
    end = time.monotonic() + seconds
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        yield lambda: time.monotonic() >= end
        return

    def over(_signal: int, _frame: FrameType | None) -> None:
        """The alarm."""
        raise TimeoutError(f"the time allowed, {seconds:g} s, is over")

    before = signal.signal(signal.SIGALRM, over)
    signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
    try:
        yield lambda: time.monotonic() >= end
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)

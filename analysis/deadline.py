"""The time allowed to a question: an alarm where there is one, and a checkpoint inside every long loop everywhere."""

from __future__ import annotations

import contextlib
import math
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import FrameType

from lure.errors import InputError

_AGAIN = 0.5  # [s] until a search that swallowed the first TimeoutError gets another
_OVER = "the time allowed is over"
_ERRORS = "_ufunc_config.py"  # numpy's file with its error state
_END: ContextVar[float] = ContextVar("_END", default=math.inf)


def time_left() -> float:
    """Seconds until the time allowed is over, negative afterwards; ``inf`` without a limit."""
    return _END.get() - time.monotonic()


def check_seconds(seconds: object) -> None:
    """Refuse what is no time allowed; ``seconds``: a positive number, or None for no limit.

    Raises
    ------
    InputError
        It is something else.
    """
    number = isinstance(seconds, int | float) and not isinstance(seconds, bool) and 0 < seconds < math.inf
    if seconds is not None and not number:
        raise InputError(f"seconds is {seconds!r:.40}; give a positive number of seconds, or None for no limit")


def checkpoint() -> None:
    """Return at once, if the time allowed is not over.

    Long loops call it once a round: the limit then holds in every thread and where the system has no alarm.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    if time_left() <= 0:
        raise TimeoutError(_OVER)


@contextmanager
def time_limit(seconds: float | None) -> Iterator[Callable[[], bool]]:
    """Raise ``TimeoutError`` in the body when the time is over; yields a function that says whether it is.

    ``seconds``: time allowed; None for no limit but one that is already in force, which is never prolonged.

    Notes
    -----
    By :func:`checkpoint` in the long loops, in every thread and on every system.  By an alarm besides, where the system
    has one and this is the main thread, repeated for a search that swallows it; it waits for compiled code to return,
    and for an import to be complete: a package whose import is broken off cannot be imported again in the process.
    An error that a library makes of the ``TimeoutError`` is one again when it leaves the body.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    if seconds is None:
        yield lambda: time_left() <= 0
        return
    token = _END.set(min(_END.get(), time.monotonic() + seconds))
    try:
        if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
            yield lambda: time_left() <= 0
            return
        with _alarm(max(time_left(), 1e-6)):
            yield lambda: time_left() <= 0
    except Exception as error:  # whatever a library makes of the alarm
        if time_left() <= 0 and any(isinstance(one, TimeoutError) for one in _behind(error)):
            raise TimeoutError(_OVER) from error
        raise
    finally:
        _END.reset(token)


def _behind(error: BaseException) -> Iterator[BaseException]:
    """What an error was made of: numpy turns whatever it meets into its own ``ValueError``."""
    behind = error.__cause__ or error.__context__
    while behind is not None:
        yield behind
        behind = behind.__cause__ or behind.__context__


def _unbroken(frame: FrameType | None) -> bool:
    """Whether the alarm goes off where nothing may be broken off: in an import, on the way into or out of a limit.

    An alarm in between would leave the repeated one on for good.  Nor where numpy sets or resets what it does with
    floating-point errors: with the caller, later, a division would raise what an eigenvalue routine has it raise.
    """
    while frame is not None:
        place, name = frame.f_code.co_filename, frame.f_code.co_name
        if (
            place == "<frozen importlib._bootstrap>"
            or place.endswith(_ERRORS)
            or (place == __file__ and name in ("time_limit", "_alarm"))
        ):
            return True
        if place == contextlib.__file__ and name in ("__enter__", "__exit__"):
            return True
        frame = frame.f_back
    return False


@contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    """A ``TimeoutError`` in the main thread after so many seconds; an alarm that was set before is set again."""

    def over(_signal: int, frame: FrameType | None) -> None:
        """The alarm."""
        if not _unbroken(frame):
            raise TimeoutError(_OVER)

    begun = time.monotonic()
    before = signal.signal(signal.SIGALRM, over)
    remaining, interval = signal.getitimer(signal.ITIMER_REAL)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds, _AGAIN)
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if remaining > 0:
            signal.setitimer(signal.ITIMER_REAL, max(remaining - (time.monotonic() - begun), 1e-6), interval)

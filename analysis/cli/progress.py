"""Progress on stderr: a bar on a terminal, a line now and then in a log, and every step with its time if asked for."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

Tell: TypeAlias = Callable[..., None]
PATIENCE = 2.0  # [s] until a bar is shown
SIGN = 30.0  # [s] between signs of life where no bar can be shown


@contextmanager
def progress(*, quiet: bool, verbose: bool = False) -> Iterator[Tell | None]:
    """A function ``tell(stage, done=None)`` that shows a stage and the share done, or None with ``quiet``.

    A bar appears after two seconds if stderr is a terminal, and nothing remains of it on the screen; ``NO_COLOR`` is
    honoured.  Elsewhere a line on stderr says every half minute what is going on.  With ``verbose`` each stage is a
    line on stderr instead, with the time it took.
    """
    if quiet:
        yield None
        return
    shown = _Lines() if verbose else _Bar() if sys.stderr.isatty() else _Signs()
    try:
        yield shown.tell
    finally:
        shown.close()


class _Lines:
    """Every stage as a line, once it is over."""

    def __init__(self) -> None:
        self.stage = ""
        self.begun = time.monotonic()

    def tell(self, stage: str, done: float | None = None) -> None:
        """The next stage."""
        self.close()
        self.stage, self.begun = stage, time.monotonic()

    def close(self) -> None:
        """The last stage is over."""
        if self.stage:
            print(f"{time.monotonic() - self.begun:9.3f} s  {self.stage}", file=sys.stderr, flush=True)
        self.stage = ""


class _Signs:
    """A line every half minute, for whoever reads a log."""

    def __init__(self) -> None:
        self.stage, self.share = "at work", ""
        self.begun = time.monotonic()
        self.over = threading.Event()
        threading.Thread(target=self._say, daemon=True).start()

    def tell(self, stage: str, done: float | None = None) -> None:
        """The next stage, or how much of it is done."""
        self.stage, self.share = stage, "" if done is None else f"{math.floor(100 * done)} % done, "

    def close(self) -> None:
        """Say no more."""
        self.over.set()

    def _say(self) -> None:
        while not self.over.wait(SIGN):
            print(
                f"lure: {self.stage}, {self.share}after {time.monotonic() - self.begun:.0f} s",
                file=sys.stderr,
                flush=True,
            )


class _Bar:
    """A bar that appears when the work takes long."""

    def __init__(self) -> None:
        self.stage: tuple[str, float | None] = ("starting", None)
        self.bars: Progress | None = None
        self.task: TaskID | None = None
        self.over = False
        self.lock = threading.RLock()
        self.timer = threading.Timer(PATIENCE, self._show)
        self.timer.daemon = True
        self.timer.start()

    def tell(self, stage: str, done: float | None = None) -> None:
        """Move the bar to a stage."""
        with self.lock:
            self.stage = (stage, done)
            self._update()

    def close(self) -> None:
        """Take the bar away, or never show it."""
        self.timer.cancel()
        with self.lock:
            self.over = True
            if self.bars is not None:
                self.bars.stop()

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        columns = (
            SpinnerColumn(),
            BarColumn(bar_width=20),
            TimeElapsedColumn(),
            TextColumn("{task.description}", markup=False),
        )
        with self.lock:
            if self.over:
                return
            self.bars = Progress(*columns, console=Console(stderr=True), transient=True)
            self.task = self.bars.add_task("starting", total=None)
            self._update()
            self.bars.start()

    def _update(self) -> None:
        stage, done = self.stage
        if self.bars is not None and self.task is not None:
            self.bars.update(self.task, description=stage, total=None if done is None else 1.0, completed=done)

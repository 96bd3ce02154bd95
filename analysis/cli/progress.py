"""Progress on stderr, where somebody watches it, and the steps with their times, where somebody asks for them."""

from __future__ import annotations

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


@contextmanager
def progress(*, quiet: bool, verbose: bool = False) -> Iterator[Tell | None]:
    """A function ``tell(stage, done=None)`` that shows a stage and the share done, or None where nobody watches.

    A bar appears after two seconds if stderr is a terminal, and nothing remains of it on the screen; ``NO_COLOR`` is
    honoured.  With ``verbose`` each stage is a line on stderr instead, with the time it took.  With ``quiet`` there is
    neither.
    """
    if quiet or not (verbose or sys.stderr.isatty()):
        yield None
        return
    shown = _Lines() if verbose else _Bar()
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

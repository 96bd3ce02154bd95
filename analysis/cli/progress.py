"""Progress on stderr, where somebody watches it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

Tell: TypeAlias = Callable[..., None]


@contextmanager
def progress(*, quiet: bool) -> Iterator[Tell | None]:
    """A function ``tell(stage, done=None)`` that shows a stage and the share done, or None where nobody watches.

    Nobody does if stderr is not a terminal or with ``quiet``.  ``NO_COLOR`` is honoured, and nothing remains on the
    screen afterwards.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task("starting", total=None)

        def tell(stage: str, done: float | None = None) -> None:
            """Move the bar to a stage."""
            bars.update(task, description=stage, total=None if done is None else 1.0, completed=done)

        yield tell

"""When a motion is compiled: no compilation longer than the run it saves, unless it is asked for."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from typing import Any

from lure.errors import InputError
from lure.rod.motion.windows import Problem

_TRIP, _COMPILE, _LOAD = 5e-4, 20.0, 1.0  # [s] a round trip without compilation, compilation, loading what was compiled


def applicable(problem: Problem) -> bool:
    """Whether all segments of the law are straight or rigid."""
    return all(segment.power == 1.0 for segment in problem.law.segments)


def compilation_pays(problem: Problem, wish: bool | None) -> bool:  # noqa: FBT001  (an option passed on)
    """Whether to compile: if asked to, or if it costs less than it saves.

    Raises
    ------
    InputError
        Compilation is asked for and numba is not installed.
    """
    if wish is False:
        return False
    if find_spec("numba") is None:
        if wish:
            raise InputError('Numerics.compiled needs numba: pip install "lure[fast]"')
        return False
    if not applicable(problem):
        return False
    if wish or _loaded():
        return True
    seconds = 0.5 * problem.transits * _TRIP
    return seconds > _COMPILE or (seconds > _LOAD and _kept())


def _loaded() -> bool:
    """Whether this process has compiled the engine, or read it from disk."""
    module: Any = sys.modules.get("lure.rod.motion.kernel_window")
    return module is not None and bool(getattr(module.run, "signatures", None))


def _kept() -> bool:
    """Whether an earlier process has left the compiled engine on disk."""
    from lure.rod.motion.jit import on_disk
    from lure.rod.motion.kernel_window import run

    return bool(on_disk(run))

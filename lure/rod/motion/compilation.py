"""Which functions of the kernel are compiled, when that pays, and where numba keeps them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from lure.errors import InputError
from lure.rod.motion.kernel_run import renamed, run, run_powers
from lure.rod.motion.kernel_series import PARTS

if TYPE_CHECKING:
    from lure.rod.motion.sources import Problem

COMPILE, LOAD = 25.0, 1.0  # [s] compilation; loading what was compiled
Kernel = Callable[..., Any]
_KERNELS: dict[Kernel, Kernel] = {}


def compilation_pays(problem: Problem, wish: bool | None, seconds: float = 0.0) -> bool:  # noqa: FBT001  (an option)
    """Whether to compile: if asked to, if it was done before, or if it costs less than it saves.

    ``seconds``: what is left is likely to take so long as it stands [s].

    Raises
    ------
    InputError
        Compilation is asked for and numba is not installed.
    """
    if wish is False:
        return False
    if _compiled_before(kernel_of(problem)):
        return True
    if not wish and seconds <= LOAD:
        return False
    if find_spec("numba") is None:
        if wish:
            raise InputError('Numerics.compiled needs numba: pip install "lure[fast]"')
        return False
    return bool(wish) or seconds > COMPILE or bool(_on_disk(compiled_kernel(kernel_of(problem))))


def reader(function: Kernel) -> Kernel | None:
    """A function that reads what was computed: compiled where this process has compiled the kernel, else None."""
    return compiled_kernel(function) if any(map(_compiled_before, (run, run_powers))) else None


def _compiled_before(function: Kernel) -> bool:
    """In this process."""
    return bool(getattr(_KERNELS.get(function), "signatures", None))


def kernel_of(problem: Problem) -> Kernel:
    """The kernel with or without power laws."""
    return run_powers if any(segment.power != 1.0 for segment in problem.nonlinearity.segments) else run


def compiled_kernel(function: Kernel) -> Kernel:
    """A function of the kernel, compiled at its first call with all it calls, and kept on disk."""
    if function in _KERNELS:
        return _KERNELS[function]
    from numba import njit

    _register()
    # numba looks at the file of the function only; the name tells of all files what it keeps was compiled from
    parts = sorted(Path(__file__).parent.glob("kernel_*.py"))
    mark = sha256(b"".join(path.read_bytes() for path in parts)).hexdigest()[:12]
    marked = renamed(function, f"{function.__name__}_{mark}", function.__defaults__)
    try:
        made: Any = njit(cache=True, error_model="numpy")(marked)
    except RuntimeError:  # there is no place on disk to keep it
        made = njit(error_model="numpy")(marked)
    _KERNELS[function] = made
    return cast(Kernel, made)


@cache
def _register() -> None:
    """Let numba compile the functions of the kernel where compiled code calls them; they stay as they are."""
    from numba.extending import register_jitable

    for function, inline in PARTS:
        register_jitable(error_model="numpy", forceinline=inline)(function)


def _on_disk(made: Any) -> list[Path]:  # noqa: ANN401  (numba has no types)
    """Index files of what earlier processes compiled."""
    place = getattr(getattr(made, "stats", None), "cache_path", None)
    return list(Path(str(place)).glob(f"*.{made.__name__}-*.nbi")) if place else []

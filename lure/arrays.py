"""numpy and scipy, each loaded when it is first used: what is exact does without them."""

import sys
from collections.abc import Callable, Iterable
from functools import cache, cached_property, wraps
from importlib import import_module
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_R = TypeVar("_R")


class _Later:
    """The names of a module, which the first that is asked for imports."""

    def __init__(self, module: str) -> None:
        self._name = module

    @cached_property
    def _module(self) -> ModuleType:
        try:
            return import_module(self._name)
        except ModuleNotFoundError as error:
            package = self._name.partition(".")[0]
            raise ModuleNotFoundError(f"this step needs {package}, which cannot be imported", name=package) from error

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (whatever the module calls by that name)
        found = getattr(self._module, name)
        if self._name == "numpy":  # asked for in inner loops: kept here, where Python looks before it calls this
            setattr(self, name, found)
        return found


np, linalg, optimize, integrate = map(_Later, ("numpy", "scipy.linalg", "scipy.optimize", "scipy.integrate"))
ArrayLike = NDArray = Reals = Complexes = Any  # for annotations, which nothing evaluates


@cache
def _libraries() -> Any:  # noqa: ANN401  (what sets the threads of those that are loaded)
    from threadpoolctl import ThreadpoolController

    assert np.array, "numpy is loaded, with its library"
    assert linalg.inv, "scipy is, with another one"
    return ThreadpoolController()


def one_thread(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """The function with linear algebra on one thread: with some hundred rows threads cost more than they save.

    Where more programs run than there are processors, they wait for each other many times as long as one would take.
    """

    @wraps(function)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        """The function, on one thread."""
        with _libraries().limit(limits=1, user_api="blas"):
            return function(*args, **kwargs)

    return limited


def in_doubles(rows: Iterable[Iterable[Any]]) -> Reals:
    """A matrix that is given row by row, each entry rounded to a double."""
    return np.array([[float(v) for v in row] for row in rows])


def balanced(A: NDArray) -> tuple[NDArray, NDArray]:
    """``A_ij u_j/u_i`` with powers of two ``u`` that even out rows and columns, and these units.

    Notes
    -----
    scipy reads the units as numbers of rows, too, and warns of those beyond 2^63, though none are exchanged here.
    """
    with np.errstate(invalid="ignore"):
        even, (units, _) = linalg.matrix_balance(A, permute=False, separate=True)
    return even, units


def is_array(value: object) -> bool:
    """Whether a value is an array of numpy; where numpy is not loaded there is none."""
    return sys.modules.get("numpy") is not None and isinstance(value, np.ndarray)

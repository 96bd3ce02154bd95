"""numpy and scipy, each loaded when it is first used: what is exact does without them."""

import sys
from functools import cached_property
from importlib import import_module
from types import ModuleType
from typing import Any


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


def balanced(A: NDArray) -> tuple[NDArray, NDArray]:
    """``A_ij u_j/u_i`` with powers of two ``u`` that even out rows and columns, and these units.

    Parameters
    ----------
    A : ndarray, shape (n, n)
        A matrix.

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

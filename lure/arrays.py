"""numpy and scipy, each loaded when it is first used: what is exact does without them."""

import sys
from importlib import import_module
from typing import Any


class _Later:
    """The names of a module; the first that is asked for imports it."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401  (whatever the module calls by that name)
        try:
            module = import_module(self._module)
        except ModuleNotFoundError as error:
            package = self._module.partition(".")[0]
            raise ModuleNotFoundError(f"this step needs {package}, which cannot be imported", name=package) from error
        found = getattr(module, name)
        setattr(self, name, found)
        return found


np, linalg, optimize, integrate = map(_Later, ("numpy", "scipy.linalg", "scipy.optimize", "scipy.integrate"))
ArrayLike = NDArray = Reals = Complexes = Any  # for annotations, which nothing evaluates


def is_array(value: object) -> bool:
    """Whether a value is an array of numpy; where numpy is not loaded there is none."""
    return sys.modules.get("numpy") is not None and isinstance(value, np.ndarray)

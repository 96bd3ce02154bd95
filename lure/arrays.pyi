from collections.abc import Callable, Iterable
from typing import Any, ParamSpec, TypeVar

import numpy
from numpy.typing import ArrayLike as ArrayLike
from numpy.typing import NDArray as NDArray
from typing_extensions import TypeIs

np = numpy
linalg: Any
optimize: Any
integrate: Any
Reals = NDArray[numpy.float64]
Complexes = NDArray[numpy.complex128]

_P = ParamSpec("_P")
_R = TypeVar("_R")

def one_thread(function: Callable[_P, _R]) -> Callable[_P, _R]: ...
def in_doubles(rows: Iterable[Iterable[Any]]) -> Reals: ...
def balanced(A: NDArray[numpy.float64]) -> tuple[Reals, Reals]: ...
def is_array(value: object) -> TypeIs[NDArray[Any]]: ...

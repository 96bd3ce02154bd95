"""Objects are their values: copies and pickles of them are equal, whatever arrays and mappings they hold."""

from __future__ import annotations

import copyreg
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def read_only(values: Mapping[Any, Any]) -> MappingProxyType[Any, Any]:
    """A read-only copy of a mapping.

    Parameters
    ----------
    values : Mapping
        The mapping.
    """
    return MappingProxyType(dict(values))


def _reduced(view: MappingProxyType[Any, Any]) -> tuple[Any, ...]:
    return read_only, (dict(view),)


copyreg.pickle(MappingProxyType, _reduced)  # read-only views are part of results, and Python pickles none


def by_value(cls: type[T]) -> type[T]:
    """Give a dataclass ``==`` and ``hash`` by its fields, for classes that hold arrays, mappings or sparse matrices.

    Parameters
    ----------
    cls : type
        The dataclass, ``eq=False``; fields with ``compare=False`` do not count.

    Returns
    -------
    type
        The same class.  ``==`` gives True or False and never an array: types, shapes and entries are equal, and where
        one is nan, so is the other.

    Examples
    --------
    >>> import numpy as np
    >>> from lure import FrequencyData
    >>> FrequencyData(np.array([1.0]), np.array([2j])) == FrequencyData([1], [2j])
    True
    """

    def equal(self: T, other: object) -> bool:
        return True if self is other else same(self, other) if type(self) is type(other) else NotImplemented

    def hashed(self: T) -> int:
        return hash(_digest(self))

    setattr(cls, "__eq__", equal)  # noqa: B010
    setattr(cls, "__hash__", hashed)  # noqa: B010
    return cls


def same(one: object, other: object) -> bool:
    """Whether two objects have the same values, entry by entry.

    Parameters
    ----------
    one, other : object
        Arrays, sparse matrices, mappings, sequences, dataclasses, or anything else with ``==``.
    """
    if one is other:
        return True
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return _same_arrays(one, other)
    if type(one) is not type(other):
        return isinstance(one, int | float) and isinstance(other, int | float) and one == other
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one) if f.compare)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same(value, other[key]) for key, value in one.items())
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if hasattr(one, "toarray") and hasattr(other, "toarray"):
        return _same_arrays(one.toarray(), other.toarray())
    return bool(one == other) or bool(one != one and other != other)


def _same_arrays(one: object, other: object) -> bool:
    if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)) or one.shape != other.shape:
        return False
    inexact = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return bool(np.array_equal(one, other, equal_nan=inexact))


def _digest(value: object) -> object:
    """Something that can be hashed, equal where the values are the same."""
    if isinstance(value, int | float | str | bytes | None):
        return value if value == value else "nan"
    if is_dataclass(value):
        parts = (_digest(getattr(value, field.name)) for field in fields(value) if field.compare)
        return (type(value).__name__, *parts)
    if isinstance(value, tuple | list):
        return tuple(map(_digest, value))
    if isinstance(value, Mapping):
        return frozenset(value)
    return getattr(value, "shape", type(value).__name__)

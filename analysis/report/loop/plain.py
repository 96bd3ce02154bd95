"""Results as plain data, whatever numbers they hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from numbers import Real
from typing import Any


def plain(value: object) -> Any:  # noqa: ANN401  (JSON data)
    """The same with nothing in it but texts, finite numbers, truth values, None, lists and dictionaries.

    Parameters
    ----------
    value : object
        Numbers, texts, mappings and sequences, nested.  An infinity becomes the text ``inf`` or ``-inf``, NaN becomes
        None, an exact fraction the text ``p/q``, and anything unknown what ``str`` makes of it.

    Examples
    --------
    >>> from fractions import Fraction
    >>> plain({"k": Fraction(1, 3), "reach": (1.5, math.inf, math.nan)})
    {'k': '1/3', 'reach': [1.5, 'inf', None]}
    """
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(entry) for entry in value]
    if isinstance(value, float) or (isinstance(value, Real) and not hasattr(value, "denominator")):
        size = float(value)
        if math.isnan(size):
            return None
        return size if math.isfinite(size) else "inf" if size > 0 else "-inf"
    return str(value)

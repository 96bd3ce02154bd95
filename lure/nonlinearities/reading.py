"""Nonlinearities from other packages: what python-control calls a nonlinearity."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar, cast

from lure.classes import Sector, SlopeBounds
from lure.errors import InputError, closest
from lure.nonlinearities.base import Nonlinearity, NormalCompliance, exact_parameter
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.named import Cubic, Quantiser, Tanh
from lure.nonlinearities.piecewise_linear import (
    IDEAL_RELAY,
    DeadZone,
    LeakyReLU,
    PiecewiseLinear,
    ReLU,
    Saturation,
    relay_with_slope,
)
from lure.nonlinearities.shifted import MovedNonlinearity

# Nonlinearities from the tables of a system file: a kind and named values.

Bounds = TypeVar("Bounds", Sector, SlopeBounds)


class _Kind:
    """How one kind of nonlinearity is made, which keys it takes, which of them it needs, and other names for them."""

    def __init__(self, make: Callable[..., Nonlinearity], needs: str = "", takes: str = "", aliases: str = "") -> None:
        self.make = make
        self.needs = tuple(needs.split())
        self.keys = (*self.needs, *takes.split())
        self.aliases = dict(pair.split("=") for pair in aliases.split())


def _expression(expression: object, **values: object) -> ExpressionNonlinearity:
    bounds: dict[str, object] = {}
    if "sector" in values:
        bounds["sector"] = _bounds(values.pop("sector"), "sector", Sector)
    if "slope" in values:
        bounds["slope_bounds"] = _bounds(values.pop("slope"), "slope", SlopeBounds)
    return ExpressionNonlinearity(expression, **values, **bounds)  # type: ignore[arg-type]  # it checks them


def _through_points(name: str, **values: object) -> PiecewiseLinear:
    given: dict[str, Any] = values
    if "file" in given:
        if "points" in given:
            raise InputError(f"the nonlinearity {name!r} has both points and a file; give one of them")
        file = given.pop("file")
        if not isinstance(file, str | Path):
            raise InputError(f"the nonlinearity's file is {file!r:.60}; give the path of a CSV file in quotes")
        return PiecewiseLinear.from_csv(file, **given)
    missing = [key for key in ("points", "left_slope", "right_slope") if key not in given]
    if missing:
        raise InputError(
            f"the nonlinearity {name!r} needs {' and '.join(missing)}, or a file; it takes "
            f"{', '.join(_KINDS[name].keys)}"
        )
    return PiecewiseLinear(given.pop("points"), **given)


_KINDS: dict[str, _Kind] = {
    "saturation": _Kind(Saturation, needs="gain limit", takes="lower_limit", aliases="slope=gain"),
    "relay with slope": _Kind(relay_with_slope, needs="gain level", aliases="slope=gain"),
    "dead zone": _Kind(DeadZone, needs="width gain", aliases="slope=gain"),
    "cubic": _Kind(Cubic, needs="cubic", takes="linear"),
    "tanh": _Kind(Tanh, takes="scale gain", aliases="slope=gain"),
    "relu": _Kind(ReLU, takes="gain", aliases="slope=gain"),
    "leaky relu": _Kind(LeakyReLU, needs="negative_slope", takes="positive_slope"),
    "quantiser": _Kind(Quantiser, needs="step", takes="kind"),
    **{
        name: _Kind(partial(_through_points, name), takes="points left_slope right_slope file")
        for name in ("piecewise linear", "table")
    },
    "normal compliance": _Kind(NormalCompliance, needs="stiffness", takes="exponent"),
    "expression": _Kind(
        _expression,
        needs="expression",
        takes="sector slope odd locally_lipschitz",
        aliases="text=expression formula=expression nonlinearity=expression slope_bounds=slope",
    ),
}
_WITH_MEMORY = (
    "backlash",
    "hysteresis",
    "relay hysteresis",
    "relay with hysteresis",
    "play",
    "stop",
    "preisach",
    "prandtl ishlinskii",
    "bouc wen",
    "friction hysteresis",
    "dahl",
    "lugre",
    "rate limiter",
    "rate limit",
)
_SPELLINGS = {
    "quantizer": "quantiser",
    "deadzone": "dead zone",
    "leakyrelu": "leaky relu",
    "relay": "relay with slope",
    "piecewise": "piecewise linear",
    "sat": "saturation",
    "contact": "normal compliance",
}
_CLOSE = 0.7
LAW_KINDS = tuple(_KINDS)
"""The kinds of nonlinearity that a table of a system file may name."""


def nonlinearity_from_table(kind: str, values: Mapping[str, object]) -> Nonlinearity:
    """The nonlinearity that a table of a system file describes.

    Parameters
    ----------
    kind : str
        One of ``LAW_KINDS``, in small or capital letters; ``-`` and ``_`` count as a space.
    values : Mapping of str to object
        The nonlinearity's parameters by name.  Numbers are ints, Fractions or Decimals (a float means the double it
        is); bounds are pairs, in which ``inf`` may stand; points are pairs.  With ``at`` and ``within`` it is counted
        from there: :class:`~lure.nonlinearities.MovedNonlinearity`.

    Raises
    ------
    InputError
        The kind or a key is unknown, a key is missing, or a value is refused by the nonlinearity.

    Examples
    --------
    >>> print(nonlinearity_from_table("saturation", {"gain": 2, "limit": Fraction(1, 2)}))
    saturation min(max(2 sigma, -0.5), 0.5)
    """
    name = _kind(kind)
    entry, given = _KINDS[name], dict(values)
    if "at" in given or "within" in given:
        at, within = (exact_parameter(given.pop(key, 0), f"the nonlinearity's {key}") for key in ("at", "within"))
        return MovedNonlinearity(nonlinearity_from_table(kind, given), at, within)
    if name == "relay with slope" and "gain" not in given and "slope" not in given:
        raise InputError(IDEAL_RELAY)
    for alias, key in entry.aliases.items():
        if alias in given:
            if key in given:
                raise InputError(
                    f"the nonlinearity {name!r} has both {alias} and {key}, which mean the same; give one of them"
                )
            given[key] = given.pop(alias)
    for key in given:
        if key not in entry.keys:
            raise InputError(_unknown_key(name, str(key), entry.keys))
    missing = [key for key in entry.needs if key not in given]
    if missing:
        raise InputError(f"the nonlinearity {name!r} needs {' and '.join(missing)}; it takes {', '.join(entry.keys)}")
    if name == "relay with slope" and _infinite(given["gain"]):
        raise InputError(IDEAL_RELAY)
    return entry.make(**given)


def _kind(kind: str) -> str:
    if not isinstance(kind, str):
        raise InputError(f"the kind of a nonlinearity is {kind!r:.60}; give one of {', '.join(_KINDS)}")
    word = " ".join(kind.lower().replace("-", " ").replace("_", " ").split())
    word = _SPELLINGS.get(word, word)
    if word in _KINDS:
        return word
    if word == "ideal relay":
        raise InputError(IDEAL_RELAY)
    if word in _WITH_MEMORY or "hysteresis" in word or "backlash" in word:
        raise InputError(
            f"the kind {kind[:60]!r} has a memory, its output depends on the past of sigma, and the theory here is for "
            "memoryless nonlinearities mu = -phi(sigma)"
        )
    close = closest(word, [*_KINDS, *_SPELLINGS], cutoff=_CLOSE)
    meant = f"did you mean {_SPELLINGS.get(close, close)!r}? " if close else ""
    raise InputError(f"unknown kind of nonlinearity {kind[:60]!r}; {meant}the kinds are {', '.join(_KINDS)}")


def _unknown_key(name: str, key: str, keys: tuple[str, ...]) -> str:
    close = closest(key.lower(), keys, cutoff=_CLOSE)
    meant = f"did you mean {close}? " if close else ""
    return f"the nonlinearity {name!r} has no key {key[:60]!r}; {meant}it takes {', '.join(keys)}"


def _infinite(value: object) -> bool:
    return isinstance(value, float | Decimal) and value == math.inf


def _bounds(value: object, key: str, make: type[Bounds]) -> Bounds:
    if isinstance(value, make):
        return value
    if isinstance(value, str) or not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError(
            f"the nonlinearity's {key} is {value!r:.60}; give a pair of numbers, [lower, upper], inf allowed"
        )
    return make(*(_bound(bound, f"{key}[{i}]") for i, bound in enumerate(value)))


def _bound(value: object, name: str) -> float | Fraction:
    if isinstance(value, str) and value.strip().lower().lstrip("+-") in ("inf", "infinity"):
        return -math.inf if value.strip().startswith("-") else math.inf
    if isinstance(value, float | Decimal) and abs(value) == math.inf:
        return math.inf if value > 0 else -math.inf
    return exact_parameter(value, name)


_WANTED = (
    "a nonlinearity says in which sector it lies: give one of lure.nonlinearities, or "
    "ExpressionNonlinearity('sigma/(1 + abs(sigma))', sector=Sector(0, 1))"
)


def as_nonlinearity(source: object) -> Nonlinearity:
    """The nonlinearity that ``source`` describes.

    Parameters
    ----------
    source : object
        A nonlinearity, returned as it is; ``control.saturation_nonlinearity(ub, lb)``, whose graph is known exactly; or
        a formula in ``sigma``.

    Raises
    ------
    InputError
        It is a nonlinearity with a memory (relay with hysteresis, backlash), to which no sector condition applies, or
        nothing says in which sector it lies.

    Examples
    --------
    >>> import control
    >>> print(as_nonlinearity(control.saturation_nonlinearity(2)))
    saturation min(max(sigma, -2), 2)
    """
    if hasattr(source, "sector") and callable(source):
        return cast("Nonlinearity", source)
    if isinstance(source, str):
        return ExpressionNonlinearity(source)
    if is_control_nonlinearity(source):
        nonlinearity = control_saturation(source)
        if nonlinearity is not None:
            return nonlinearity
        if not source._isstatic():  # type: ignore[attr-defined]  # what that class offers
            raise InputError(
                f"{type(source).__name__} has a memory: its output depends on the past of sigma, and a sector bounds "
                "memoryless nonlinearities mu = -phi(sigma); lure.analysis.describing_function(it, amplitude) is a hint"
            )
    if isinstance(source, Real):  # a pair of bounds that was taken for two channels
        raise InputError(
            f"{source!r:.60} is a number and no nonlinearity; give the class asked about as Sector(0, 1) or "
            "SlopeBounds(0, 1), or one nonlinearity such as Saturation()"
        )
    raise InputError(f"{source!r:.60} has no sector; {_WANTED}")


def is_control_nonlinearity(source: object) -> bool:
    """Whether something is what python-control calls a ``DescribingFunctionNonlinearity``; ``source``: anything."""
    control = sys.modules.get("control")  # an object of a package that is not loaded cannot exist
    return control is not None and isinstance(source, control.DescribingFunctionNonlinearity)


def control_saturation(source: object) -> Saturation | None:
    """``control.saturation_nonlinearity`` as a saturation of the library, None for everything else.

    ``source``: anything; of a class derived from that one the graph is unknown.
    """
    control = sys.modules.get("control")
    if control is None or type(source) is not control.saturation_nonlinearity:
        return None
    return Saturation(limit=source.ub, lower_limit=source.lb)  # type: ignore[attr-defined]  # what that class offers

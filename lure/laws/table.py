"""Laws from the tables of a system file: a kind and named values."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TypeVar

from lure.errors import InputError
from lure.exact import exact_number
from lure.laws.formula import ExpressionLaw
from lure.laws.piecewise import IDEAL_RELAY, DeadZone, LeakyReLU, ReLU, Saturation, relay_with_slope
from lure.laws.points import PiecewiseLinear
from lure.laws.quantiser import Quantiser
from lure.laws.smooth import Cubic, Tanh
from lure.nonlinearity import Nonlinearity, NormalCompliance
from lure.sector import Sector, SlopeBounds

Bounds = TypeVar("Bounds", Sector, SlopeBounds)


class _Kind:
    """How one kind of law is made, which keys it takes, and which of them it needs."""

    def __init__(self, make: Callable[..., Nonlinearity], needs: str = "", takes: str = "") -> None:
        self.make = make
        self.needs = tuple(needs.split())
        self.keys = (*self.needs, *takes.split())


def _expression(**values: object) -> ExpressionLaw:
    bounds: dict[str, object] = {"sector": _bounds(values.pop("sector"), "sector", Sector)}
    if "slope_bounds" in values:
        bounds["slope_bounds"] = _bounds(values.pop("slope_bounds"), "slope_bounds", SlopeBounds)
    return ExpressionLaw(**values, **bounds)  # type: ignore[arg-type]  # it checks them


_KINDS: dict[str, _Kind] = {
    "saturation": _Kind(Saturation, needs="gain limit", takes="lower_limit"),
    "relay with slope": _Kind(relay_with_slope, needs="gain level"),
    "dead zone": _Kind(DeadZone, needs="width gain"),
    "cubic": _Kind(Cubic, needs="cubic", takes="linear"),
    "tanh": _Kind(Tanh, takes="scale gain"),
    "relu": _Kind(ReLU, takes="gain"),
    "leaky relu": _Kind(LeakyReLU, needs="negative_slope", takes="positive_slope"),
    "quantiser": _Kind(Quantiser, needs="step", takes="kind"),
    "piecewise linear": _Kind(PiecewiseLinear, needs="points left_slope right_slope"),
    "normal compliance": _Kind(NormalCompliance, needs="stiffness", takes="exponent"),
    "expression": _Kind(_expression, needs="text sector", takes="slope_bounds odd locally_lipschitz"),
}
_SPELLINGS = {
    "quantizer": "quantiser",
    "deadzone": "dead zone",
    "leakyrelu": "leaky relu",
    "relay": "relay with slope",
    "piecewise": "piecewise linear",
    "table": "piecewise linear",
    "sat": "saturation",
    "contact": "normal compliance",
}
_KEYS = {"slope": "gain", "law": "text", "formula": "text"}
LAW_KINDS = tuple(_KINDS)
"""The kinds of law that a table of a system file may name."""


def law_from_table(kind: str, values: Mapping[str, object]) -> Nonlinearity:
    """The law that a table of a system file describes.

    Parameters
    ----------
    kind : str
        One of ``LAW_KINDS``, in small or capital letters; ``-`` and ``_`` count as a space.
    values : Mapping of str to object
        The law's parameters by name.  Numbers are ints, Fractions or Decimals (a float means the double it is); bounds
        are pairs, in which ``inf`` may stand; points are pairs.

    Raises
    ------
    InputError
        The kind or a key is unknown, a key is missing, or a value is refused by the law.

    Examples
    --------
    >>> print(law_from_table("saturation", {"gain": 2, "limit": Fraction(1, 2)}))
    saturation min(max(2 sigma, -0.5), 0.5)
    """
    name = _kind(kind)
    entry, given = _KINDS[name], dict(values)
    if name == "relay with slope" and "gain" not in given and "slope" not in given:
        raise InputError(IDEAL_RELAY)
    for alias, key in _KEYS.items():
        if alias in given and alias not in entry.keys and key in entry.keys and key not in given:
            given[key] = given.pop(alias)
    for key in given:
        if key not in entry.keys:
            raise InputError(_unknown_key(name, str(key), entry.keys))
    missing = [key for key in entry.needs if key not in given]
    if missing:
        raise InputError(f"the law {name!r} needs {' and '.join(missing)}; it takes {', '.join(entry.keys)}")
    if name == "relay with slope" and _infinite(given["gain"]):
        raise InputError(IDEAL_RELAY)
    return entry.make(**given)


def _kind(kind: str) -> str:
    if not isinstance(kind, str):
        raise InputError(f"the kind of a law is {kind!r:.60}; give one of {', '.join(_KINDS)}")
    word = " ".join(kind.lower().replace("-", " ").replace("_", " ").split())
    word = _SPELLINGS.get(word, word)
    if word in _KINDS:
        return word
    if word == "ideal relay":
        raise InputError(IDEAL_RELAY)
    close = difflib.get_close_matches(word[:40], [*_KINDS, *_SPELLINGS], n=1)
    meant = f"did you mean {_SPELLINGS.get(close[0], close[0])!r}? " if close else ""
    raise InputError(f"unknown kind of law {kind[:60]!r}; {meant}the kinds are {', '.join(_KINDS)}")


def _unknown_key(name: str, key: str, keys: tuple[str, ...]) -> str:
    close = difflib.get_close_matches(key[:40].lower(), keys, n=1)
    meant = f"did you mean {close[0]}? " if close else ""
    return f"the law {name!r} has no key {key[:60]!r}; {meant}it takes {', '.join(keys)}"


def _infinite(value: object) -> bool:
    return isinstance(value, float | Decimal) and value == math.inf


def _bounds(value: object, key: str, make: type[Bounds]) -> Bounds:
    if isinstance(value, make):
        return value
    if isinstance(value, str) or not isinstance(value, list | tuple) or len(value) != 2:
        raise InputError(f"the law's {key} is {value!r:.60}; give a pair of numbers, [lower, upper], inf allowed")
    return make(*(_bound(bound, f"{key}[{i}]") for i, bound in enumerate(value)))


def _bound(value: object, name: str) -> float | Fraction:
    if isinstance(value, str) and value.strip().lower().lstrip("+-") in ("inf", "infinity"):
        return -math.inf if value.strip().startswith("-") else math.inf
    if isinstance(value, float | Decimal) and abs(value) == math.inf:
        return math.inf if value > 0 else -math.inf
    return exact_number(value, name)

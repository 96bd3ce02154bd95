"""What records are made of: values that compare, numbers as text, plain data, variables of Datasets, HTML tables."""

from __future__ import annotations

import copyreg
import decimal
import html
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from lure.errors import InputError

if TYPE_CHECKING:
    from types import ModuleType

    import xarray
    from numpy.typing import ArrayLike, NDArray

_NUMBERS = (int, float, Fraction)
Towards = Literal["nearest", "below", "above"]
_ROUNDING = {"nearest": decimal.ROUND_HALF_EVEN, "below": decimal.ROUND_FLOOR, "above": decimal.ROUND_CEILING}

# Numbers for people and for machines.


def rounded(value: float | Fraction, towards: Towards = "nearest", digits: int = 10) -> str:
    """Some digits of a number: the only place in which a number that bounds something becomes text.

    Parameters
    ----------
    value : float or Fraction
        The number.
    towards : {"nearest", "below", "above"}
        ``below`` for a number up to which something is shown, and for the lower end of what encloses something;
        ``above`` for the other ends: what is printed then holds as well.
    digits : int
        How many.

    Examples
    --------
    >>> rounded(2 / 3, "below", 4), rounded(2 / 3, "above", 4), rounded(Fraction(-2, 3), "above", 4)
    ('0.6666', '0.6667', '-0.6666')
    """
    if value == 0 or (isinstance(value, float) and not math.isfinite(value)):
        return f"{float(value):g}"
    top, bottom = map(decimal.Decimal, value.as_integer_ratio())
    found = decimal.Context(prec=digits, rounding=_ROUNDING[towards]).divide(top, bottom)
    text = f"{found:f}" if -5 < found.adjusted() < digits + 6 else f"{found:e}"
    mantissa, _, exponent = text.partition("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    return f"{mantissa}e{int(exponent):+03d}" if exponent else mantissa


def decimal_text(value: float | Fraction, digits: int = 6) -> str:
    """The nearest decimal of some digits, for people: it bounds nothing; long numbers have an exponent.

    Parameters
    ----------
    value : float or Fraction
        The number, of any size.
    digits : int
        How many.

    Examples
    --------
    >>> decimal_text(Fraction(-2, 3)), decimal_text(123456789), decimal_text(Fraction(10**400))
    ('-0.666667', '1.23457e+08', '1e+400')
    """
    text = rounded(value, "nearest", digits)
    if len(text.lstrip("-")) <= digits or not text.lstrip("-").isdigit():
        return text
    mantissa, exponent = f"{decimal.Decimal(text).normalize():e}".split("e")
    return f"{mantissa}e{int(exponent):+03d}"


def exact_text(value: float | Fraction, digits: int = 6) -> str:
    """A number for people: the decimal where that is exact, else ``p/q`` where that is short, else the decimal.

    Parameters
    ----------
    value : float or Fraction
        The number, of any size.
    digits : int
        How many the decimal has.

    Examples
    --------
    >>> exact_text(Fraction(1, 8)), exact_text(Fraction(-2, 3)), exact_text(Fraction(0.1))
    ('0.125', '-2/3', '0.1')
    """
    text = decimal_text(value, digits)
    short = (
        isinstance(value, Fraction) and value.denominator != 1 and max(abs(value.numerator), value.denominator) < 10**4
    )
    return str(value) if short and Fraction(text) != value else text


def value_text(name: str, value: Fraction, digits: int = 8) -> str:
    """A number with its name: ``a = 2/3``, or ``a about 0.33333333`` where it is rounded and may behave otherwise.

    Parameters
    ----------
    name : str
        Its name.
    value : Fraction
        The number.
    digits : int
        How many are shown of a long one.
    """
    text = exact_text(value, digits)
    return f"{name} = {text}" if Fraction(text) == value else f"{name} about {text}"


def plain(value: object) -> object:
    """A value as plain JSON data, for ``to_dict``: exact numbers as text ``p/q``, infinite ones ``inf``, nan as None.

    Mappings, sequences, arrays and sets are gone through; complex numbers become pairs; an object with ``to_dict`` is
    asked for it, and any other is shown as its ``str``.

    Parameters
    ----------
    value : object
        Anything.

    Examples
    --------
    >>> from fractions import Fraction
    >>> plain({"k": Fraction(1, 3), "reach": float("inf"), "points": (1, 2.5)})
    {'k': '1/3', 'reach': 'inf', 'points': [1, 2.5]}
    """
    np = sys.modules.get("numpy")
    if np is not None and isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else None if math.isnan(value) else "inf" if value > 0 else "-inf"
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, Fraction | Enum):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, Sequence | set | frozenset):
        return [plain(item) for item in value]
    own = getattr(value, "to_dict", None)
    return own() if callable(own) else str(value)


def finite(value: float | None) -> float | None:
    """A number, None in place of nan and infinity.

    Parameters
    ----------
    value : float or None
        The number.
    """
    return value if value is not None and math.isfinite(value) else None


# What xarray takes.


def xarray_or_refusal(what: str = "to_xarray") -> ModuleType:
    """The package xarray, which is optional.

    Parameters
    ----------
    what : str
        What needs it, for the error.

    Raises
    ------
    InputError
        It is not installed; the sentence says which extra to install.
    """
    try:
        return import_module("xarray")
    except ImportError:
        raise InputError(f'{what} needs xarray: pip install "lure[netcdf]"') from None


class Column(NamedTuple):
    """A variable of a Dataset: its dimensions, its values, and what it may not go without.

    Attributes
    ----------
    dims : tuple of str
        Names of the dimensions; none for a single value.
    values : array_like
        Numbers, truth values or texts.
    unit : str
        As the CF conventions write it (``m s-1``), ``1`` for a pure number.
    meaning : str
        What it is, with its sign.
    more : Mapping or None
        Further attributes.
    aside : bool
        Whether it is a coordinate, though it is not called like its dimension.
    """

    dims: tuple[str, ...]
    values: ArrayLike
    unit: str
    meaning: str
    more: Mapping[str, object] | None = None
    aside: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """How many there are along each dimension."""
        found: tuple[int, ...] = import_module("numpy").shape(self.values)
        return found

    def variable(self) -> tuple[tuple[str, ...], NDArray[Any], dict[str, object]]:
        """The same as xarray takes it, with values of its own."""
        import numpy as np

        text = isinstance(self.values, tuple | list) and any(isinstance(value, str) for value in self.values)
        values = np.array(self.values, dtype=object if text else None)
        return self.dims, values, {"units": self.unit, "long_name": self.meaning, **(self.more or {})}


def dataset(
    variables: Mapping[str, Column],
    coordinates: Mapping[str, Column],
    attributes: Mapping[str, object],
) -> xarray.Dataset:
    """A Dataset in which every variable and coordinate has ``units`` and a ``long_name``.

    Parameters
    ----------
    variables, coordinates : Mapping of str to Column
        By name.
    attributes : Mapping
        Attributes of the whole, such as ``subject`` and ``evidence``: numbers and texts.

    Raises
    ------
    InputError
        xarray is not installed.

    Examples
    --------
    >>> t = Column(("t",), [0.0, 0.5], "s", "time")
    >>> found = dataset({"z": Column(("t",), [0.0, 1.0], "m", "a place")}, {"t": t}, {"evidence": "observed"})
    >>> found.z.attrs["units"], found.sizes["t"]
    ('m', 2)
    """
    made: xarray.Dataset = xarray_or_refusal("a Dataset").Dataset(
        {name: column.variable() for name, column in variables.items()},
        coords={name: column.variable() for name, column in coordinates.items()},
        attrs=dict(attributes),
    )
    return made


def numbered(dim: str, count: int, meaning: str = "") -> Column:
    """A coordinate that counts from 1.

    Parameters
    ----------
    dim : str
        Its dimension.
    count : int
        How many there are.
    meaning : str
        What it counts, if not things of that name in order.
    """
    numbers = import_module("numpy").arange(1, count + 1)
    return Column((dim,), numbers, "1", meaning or f"number of the {dim}, in order")


# Tables for notebooks.

_LEFT = ' style="text-align:left"'
_CAPTION = ' style="text-align:left;min-width:min(32em,90vw)"'
_LONGEST = 400


def html_table(
    title: str,
    rows: Sequence[Sequence[object]],
    *,
    head: Sequence[str] = (),
    verdict: str = "",
    notes: Sequence[str] = (),
) -> str:
    """A table for ``_repr_html_``: semantic, everything escaped, no script, no colour of its own.

    Whatever theme the notebook has, light or dark, the table takes its colours from it.

    Parameters
    ----------
    title : str
        What the object is about, the caption.
    rows : sequence of sequence
        Cells, as objects whose ``str`` is shown; the first of a row is its heading.  A cell longer than 400
        characters is cut short, and says so.
    head : sequence of str
        Headings of the columns; without it rows are pairs of a name and a value.
    verdict : str
        Stands before the title, in bold: ``PROVED``, ``OBSERVED`` and the like.
    notes : sequence of str
        Sentences below the table, one each: what was not shown, and where to look.

    Returns
    -------
    str
        One ``<div>`` with a ``<table>`` in it.

    Examples
    --------
    >>> html_table("H < 1", [("order", 3)], verdict="PROVED").startswith("<div><table>")
    True
    """
    bold = f"<b>{_cell(verdict)}</b> " if verdict else ""
    parts = [f"<div><table><caption{_CAPTION}>{bold}{html.escape(title)}</caption>"]
    if head:
        cells = "".join(f'<th scope="col"{_LEFT}>{_cell(name)}</th>' for name in head)
        parts.append(f"<thead><tr>{cells}</tr></thead>")
    parts.append("<tbody>\n" + "\n".join(_row(row) for row in rows) + "</tbody></table>")
    parts.extend(f"<p><em>{html.escape(note)}</em></p>" for note in notes)
    return "".join(parts) + "</div>"


def _row(cells: Sequence[object]) -> str:
    first, *rest = cells
    values = "".join(f"<td{_LEFT}>{_cell(value)}</td>" for value in rest)
    return f'<tr><th scope="row"{_LEFT}>{_cell(first)}</th>{values}</tr>'


def _cell(value: object) -> str:
    text = str(value)
    if len(text) > _LONGEST:
        text = f"{text[:_LONGEST]}... ({len(text)} characters)"
    return html.escape(text)


# Objects are their values: copies and pickles of them are equal, whatever arrays and mappings they hold.


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


def same(one: object, other: object) -> bool:
    """Whether two objects have the same values, entry by entry.

    Parameters
    ----------
    one, other : object
        Arrays, sparse matrices, mappings, sequences, dataclasses, or anything else with ``==``.
    """
    if one is other:
        return True
    np = sys.modules.get("numpy")  # where it was not imported there is no array
    if np is not None and (isinstance(one, np.ndarray) or isinstance(other, np.ndarray)):
        return _same_arrays(one, other)
    if type(one) is not type(other):
        return isinstance(one, _NUMBERS) and isinstance(other, _NUMBERS) and one == other
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
    import numpy as np

    if not (isinstance(one, np.ndarray) and isinstance(other, np.ndarray)) or one.shape != other.shape:
        return False
    inexact = one.dtype.kind in "fc" and other.dtype.kind in "fc"
    return bool(np.array_equal(one, other, equal_nan=inexact))


def digest(value: object) -> object:
    """Something that can be hashed, equal where the values are the same.

    ``value``: as for :func:`same`.
    """
    if isinstance(value, int | float | Fraction | str | bytes | None):
        return value if value == value else "nan"
    if is_dataclass(value):
        parts = (digest(getattr(value, field.name)) for field in fields(value) if field.compare)
        return (type(value).__name__, *parts)
    if isinstance(value, tuple | list):
        return tuple(map(digest, value))
    if isinstance(value, Mapping):
        return frozenset(value)
    return getattr(value, "shape", type(value).__name__)

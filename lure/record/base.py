"""The base of every result: what its fields declare once becomes JSON, a Dataset, an HTML table, text and equality."""

from __future__ import annotations

import dataclasses
import inspect
import json
import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from enum import Enum
from fractions import Fraction
from functools import cached_property
from importlib import import_module
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, TypeVar, cast, dataclass_transform

from lure.record.values import Column, Towards, dataset, digest, html_table, numbered, plain, rounded, same

if TYPE_CHECKING:
    import xarray

T = TypeVar("T")


# What a field declares.


@dataclass(frozen=True, kw_only=True, slots=True)
class Declared:
    """What a field or a property of a :class:`Record` declares; made by :func:`quantity` and :func:`derived`."""

    meaning: str = ""
    unit: str = ""
    dims: tuple[str, ...] | None = None
    key: str | None = None
    name: str = ""
    label: str | None = None
    form: str | Callable[[Any], object] = ".6g"
    plainly: Callable[[Any], object] | None = None
    inline: bool = False
    each: type[Record] | None = None

    def shown(self, value: object) -> object:
        """The value as a cell of a table."""
        if callable(self.form):
            return self.form(value)
        if value is None or isinstance(value, str | bool | int | Enum) or not isinstance(value, float | Fraction):
            return "-" if value is None else value
        if self.form in ("below", "above", "nearest"):
            return rounded(value, cast(Towards, self.form), 6)
        return "-" if math.isnan(value) else format(float(value), self.form)


def quantity(  # noqa: PLR0913  (a field has many faces, all with defaults)
    meaning: str,
    unit: str = "",
    *,
    dims: str | None = None,
    key: str | None = None,
    name: str = "",
    label: str | None = None,
    form: str | Callable[[Any], object] = ".6g",
    plainly: Callable[[Any], object] | None = None,
    inline: bool = False,
    each: type[Record] | None = None,
    hidden: bool = False,
    init: bool = True,
    default: Any = dataclasses.MISSING,  # noqa: ANN401  (of any type)
    default_factory: Any = dataclasses.MISSING,  # noqa: ANN401  (as in dataclasses.field)
) -> Any:  # noqa: ANN401  (as dataclasses.field)
    """A field of a :class:`Record` with what it is, said once.

    Parameters
    ----------
    meaning : str
        What it is, with its sign: the entry of the docstring and the ``long_name`` of a Dataset.
    unit : str
        As the CF conventions write it (``m s-1``), ``1`` for a pure number.
    dims : str, optional
        Dimensions of the variable in the Dataset, separated by spaces, ``""`` for a single number; without it the field
        is none.  The variable that is called like its only dimension is the coordinate; a dimension without one is
        numbered from 1.
    key : str, optional
        In the dictionary; its own name if not given, and left out if ``""`` or if it is a curve (``dims``).
    name : str
        In the Dataset, if not its own; what stands in front of the names, for records in a row.
    label : str, optional
        Heading of its row or column in the table; left out if ``""``.
    form : str or callable
        How a number is written there: a format, ``below`` or ``above`` for a bound that is rounded that way, or a
        function; ``rows`` for a row of its own for each entry.
    plainly : callable, optional
        What the dictionary holds, if not :func:`plain` data of the value.
    inline : bool
        Whether what the value, a record, declares is taken in as if it stood here.
    each : type, optional
        Type of the records of a tuple along ``dims``: each of their single numbers and texts becomes a variable.
    hidden : bool
        Whether it takes no part in comparisons, texts and the dictionary, as what only a drawing needs.
    init : bool
        Whether it is given when the record is made; False for what is computed then.
    default, default_factory
        As for ``dataclasses.field``.
    """
    declared = Declared(
        meaning=meaning,
        unit=unit,
        dims=None if dims is None else tuple(dims.split()),
        key="" if hidden or (key is None and dims and each is None) else key,
        name=name,
        label="" if hidden else label,
        form=form,
        plainly=plainly,
        inline=inline,
        each=each,
    )
    more: dict[str, Any] = {"default": default, "default_factory": default_factory, "init": init}
    return field(repr=not hidden, compare=not hidden, metadata={"declared": declared}, **more)


def derived(unit: str = "", **more: Any) -> Callable[[T], T]:  # noqa: ANN401  (those of `quantity`)
    """Declare a property of a :class:`Record`, below ``@property``; its meaning is the first line of its docstring.

    Parameters
    ----------
    unit : str
        As for :func:`quantity`.
    **more
        The other options of :func:`quantity`.
    """

    def mark(function: T) -> T:
        """Note what the property is; its docstring says the meaning."""
        meaning = re.sub(r" *\[[^]]*\](?=[.;]|$)|\.$", "", (function.__doc__ or "").partition("\n")[0])
        meaning = re.sub(r"^\([\w+, ]*\) *", "", meaning)
        function.__declared__ = quantity(meaning, unit, **more).metadata["declared"]  # type: ignore[attr-defined]  # functions take attributes
        return function

    return mark


@dataclass_transform(field_specifiers=(quantity, field))
def described(**options: bool) -> Callable[[type[T]], type[T]]:
    """A data class whose fields, made with :func:`quantity`, say once what they are: from that follows its docstring.

    It has nothing else of a :class:`Record`, which a result is: this is for what is passed on inside a computation.

    Parameters
    ----------
    **options
        Those of ``dataclasses.dataclass``.

    Examples
    --------
    >>> @described(frozen=True)
    ... class Span:
    ...     '''Part of a motion.'''
    ...
    ...     start: float = quantity("When it begins", "s")
    >>> Span(0.5), Span.__doc__.splitlines()[-2:]
    (Span(start=0.5), ['start : float', '    When it begins [s].'])
    """

    def made(cls: type[T]) -> type[T]:
        """The data class, its fields in its docstring."""
        found = dataclass(**options)(cls)
        found.__doc__ = _documented(found)
        return found

    return made


# The base.


class Page(NamedTuple):
    """What a record shows to people, as tables in a notebook or as text; the arguments of :func:`html_table`."""

    title: str
    rows: Sequence[Sequence[object]]
    head: Sequence[str] = ()
    verdict: str = ""
    notes: Sequence[str] = ()
    below: Sequence[Page] = ()

    def html(self) -> str:
        """The page and those below it as tables."""
        table = html_table(self.title, self.rows, head=self.head, verdict=self.verdict, notes=self.notes)
        return table + "".join(page.html() for page in self.below)

    def __str__(self) -> str:
        cells = [
            [str(cell) for cell in row] for row in ([list(self.head)] if self.head else []) + list(map(list, self.rows))
        ]
        lines = [f"  {line}" for line in aligned(cells)]
        return "\n".join([f"{self.verdict} {self.title}".strip(), *lines, *self.notes, *map(str, self.below)])


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows of text as lines with their cells in columns; the last cells of a row may be missing."""
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


@dataclass_transform(eq_default=False, frozen_default=True, kw_only_default=True, field_specifiers=(quantity, field))
class Record:
    """The base of a result: a subclass becomes a frozen dataclass, and says in its fields what it holds.

    A field made with :func:`quantity`, or a property marked with :func:`derived`, declares its meaning, unit, dimension
    and rounding.  From that follow the docstring, plain data, JSON, a Dataset, a table and text; equality, hash, copies
    and pickles are by value: ``==`` gives True or False and never an array; types, shapes and entries are equal, and
    where one is nan, so is the other.  A subclass says ``_kind``, what the dictionary calls it, ``_said``, the key
    under which it holds the text, and for the table ``_title``, ``_verdict`` and ``_notes``.  Where the declarations do
    not say all, it overrides :meth:`to_dict`, ``_columns``, ``_attributes``, ``_rows`` or ``_page``.

    Examples
    --------
    >>> class Hit(Record):
    ...     '''A hit.'''
    ...
    ...     at: float = quantity("instant of contact", "s")
    ...     stress: float = quantity("largest stress", "Pa", key="peak", form="above")
    >>> Hit(at=0.5, stress=2 / 3).to_dict()
    {'at': 0.5, 'peak': 0.6666666666666666}
    >>> print(Hit(at=0.5, stress=2 / 3))
    hit
      at [s]       0.5
      stress [Pa]  0.666667
    """

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]
    _kind: ClassVar[str] = ""
    _said: ClassVar[str] = ""
    _no_truth: ClassVar[str] = ""

    def __init_subclass__(cls, *, kw_only: bool = True) -> None:
        super().__init_subclass__()
        own = bool(inspect.get_annotations(cls))  # without fields of its own it is made as its base is
        dataclass(init=own, frozen=True, kw_only=kw_only, eq=False)(cls)
        cls.__doc__ = _documented(cls)

    def __eq__(self, other: object) -> bool:
        return self is other or same(self, other) if type(self) is type(other) else NotImplemented

    def __hash__(self) -> int:
        return self._hashed

    def __bool__(self) -> bool:
        if self._no_truth:
            raise TypeError(self._no_truth)
        return True

    @cached_property
    def _hashed(self) -> int:
        return hash(digest(self))

    def __getstate__(self) -> dict[str, Any]:
        """Without what cached properties keep, which is made again."""
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @classmethod
    def _declared(cls) -> Iterator[tuple[str, Declared]]:
        for each in fields(cls):
            yield each.name, each.metadata.get("declared") or Declared()
        for base in reversed(cls.__mro__):
            for name, member in vars(base).items():
                if isinstance(member, property) and (found := getattr(member.fget, "__declared__", None)):
                    yield name, found

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: exact numbers as text ``p/q``, infinite ones as ``inf``, None for what is not known."""
        found: dict[str, Any] = {"kind": self._kind} if self._kind else {}
        for name, declared in self._declared():
            if declared.inline and isinstance(value := getattr(self, name), Record):
                found |= value.to_dict()
            elif declared.key != "":
                found[declared.key or name] = (declared.plainly or plain)(getattr(self, name))
        return found | ({self._said: str(self)} if self._said else {})

    def to_json(self) -> str:
        """The same as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, ensure_ascii=False)

    def to_xarray(self) -> xarray.Dataset:
        """What has dimensions as an ``xarray.Dataset`` with units and meanings; what else is known is in ``attrs``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        columns = self._columns()
        of = {dim: size for column in columns.values() for dim, size in zip(column.dims, column.shape, strict=True)}
        columns |= {dim: numbered(dim, size) for dim, size in of.items() if dim not in columns}
        own = {name for name, column in columns.items() if column.dims == (name,) or column.aside}
        return dataset(
            {name: column for name, column in columns.items() if name not in own},
            {name: columns[name] for name in columns if name in own},
            self._attributes(),
        )

    def _columns(self) -> dict[str, Column]:
        """The variables and coordinates of the Dataset."""
        found: dict[str, Column] = {}
        for name, declared in self._declared():
            value = getattr(self, name)
            if declared.inline and isinstance(value, Record):
                found |= value._columns()
            elif declared.each is not None and declared.dims is not None:
                found |= _in_a_row(value, declared)
            elif declared.dims is not None and value is not None:
                found[declared.name or name] = Column(declared.dims, value, declared.unit, _words(declared.meaning))
        return found

    def _attributes(self) -> dict[str, object]:
        """The attributes of the Dataset."""
        return {name: str(getattr(self, name)) for name in ("evidence", "comment") if hasattr(self, name)}

    @property
    def _title(self) -> str:
        return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(self).__name__).lower()

    @property
    def _verdict(self) -> str:
        return ""

    @property
    def _notes(self) -> Sequence[str]:
        return ()

    def _rows(self) -> Iterator[tuple[object, ...]]:
        """The rows of the table: those that the fields declare."""
        for name, declared in self._declared():
            if declared.label != "" and not declared.dims and declared.each is None:
                unit = f" [{declared.unit}]" if declared.unit not in ("", "1") else ""
                label, value = declared.label or f"{name.replace('_', ' ')}{unit}", getattr(self, name)
                if declared.form == "rows":
                    yield from ((label, entry) for entry in value)
                else:
                    yield label, declared.shown(value)

    def _page(self) -> Page:
        """What is shown to people."""
        return Page(self._title, tuple(self._rows()), verdict=self._verdict, notes=self._notes)

    def _repr_html_(self) -> str:
        return self._page().html()

    def __str__(self) -> str:
        return str(self._page())


def _in_a_row(records: Sequence[Record], declared: Declared) -> dict[str, Column]:
    """A variable for each single number and text that the records of a tuple declare."""
    assert declared.each is not None, "asked with a type only"
    assert declared.dims is not None, "asked with dimensions only"
    np, found = import_module("numpy"), {}
    kinds = {each.name: str(each.type) for each in fields(declared.each)}
    for name, inner in declared.each._declared():
        if inner.dims == ():
            values = [getattr(record, name) for record in records]
            kind = {"bool": bool, "int": int, "str": object}.get(kinds.get(name, ""), float)
            known = np.array([math.nan if value is None else value for value in values], dtype=kind)
            label = declared.dims[0] if inner.name == "*" else declared.name + (inner.name or name)
            found[label] = Column(declared.dims, known, inner.unit, _words(inner.meaning))
    return found


def _words(meaning: str) -> str:
    """A meaning without the marks of reStructuredText."""
    text = re.sub(r":\w+:`[.~]*([^`]*)`", r"\1", meaning).replace("``", "").replace("**", "")
    return text.rstrip(".")


def _choices(cls: type[Any], name: str) -> str:
    """The type of a field as the reference has it: the values of a Literal, else its name."""
    kind = vars(sys.modules[cls.__module__]).get(name)
    choices = getattr(kind, "__args__", ()) if isinstance(kind, type(Literal[0])) else ()
    name = re.sub(r"NDArray\[[^]]*\]|\bArray\b", "ndarray", name)
    return "{" + ", ".join(map(repr, choices)) + "}" if choices else name


def _documented(cls: type[Any]) -> str:
    """The docstring with the declared fields as its attributes."""
    said = []
    for each in fields(cls):
        found = each.metadata.get("declared")
        if found and found.meaning:
            meaning = found.meaning.rstrip(".")
            unit = f" [{'-' if found.unit == '1' else found.unit}]" if found.unit else ""
            along = f"({', '.join(found.dims)}{',' * (len(found.dims) == 1)}) " if found.dims else ""
            said.append(f"{each.name} : {_choices(cls, str(each.type))}\n    {along}{meaning}{unit}.")
    if not said:
        return cls.__doc__ or ""
    head, *tail = re.split(r"\n(?=[A-Z]\w+\n---)", inspect.cleandoc(cls.__doc__ or ""), maxsplit=1)
    return "\n".join([f"{head.rstrip()}\n\nAttributes\n----------", *said, *(f"\n{part}" for part in tail)]) + "\n"

"""One kind of system file: its keys, how it becomes a system, and pydantic's findings as one sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lure.errors import InputError, closest
from lure.files.values import shown
from lure.record import described, quantity

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError
    from pydantic_core import ErrorDetails

_closest = partial(closest, cutoff=0.7)


class NamedSystem(Protocol):
    """What a file or a built-in means: a loop with a name."""

    @property
    def name(self) -> str:
        """Name for the report."""

    @property
    def title(self) -> str:
        """One line that says what it is."""

    @property
    def source(self) -> str:
        """Where it comes from."""


class Build(Protocol):
    """From the checked tables of a file to its system."""

    def __call__(self, tables: Any, *, title: str, source: str, folder: Path) -> NamedSystem:  # noqa: ANN401  (the model of the kind)
        """The system; ``title`` should the file have none, ``folder`` where the files lie that it names."""


@described(frozen=True, kw_only=True)
class FileKind:
    """One kind of file, with the built-in systems of that kind; registered for the type of its systems."""

    word: str = quantity("What its systems are, in a word")
    tables: Mapping[str, type[BaseModel]] = quantity("The model of each table; the first tells the kind")
    model: type[BaseModel] = quantity("The model of a whole file")
    build: Build = quantity("The system of checked tables")
    written: Callable[[Any], dict[str, object]] = quantity("The tables that mean a system")
    names: Callable[[], Sequence[str]] = quantity("Names of the built-in systems")
    builtin: Callable[[str], NamedSystem] = quantity("The built-in system of a name")
    texts: tuple[str, ...] = quantity("Keys whose value is a text, whatever it looks like")
    single: tuple[str, ...] = quantity("Keys outside the tables", default=("name",))
    letters: Mapping[str, str] = quantity("Symbols of the formulas and the keys they stand for", default_factory=dict)
    free: str = quantity("The table that takes keys besides those of its model; empty if there is none", default="")
    beside: tuple[str, ...] = quantity("First tables of other kinds that stand in files of this one", default=())

    @property
    def first(self) -> str:
        """The table that every file of the kind has."""
        return next(iter(self.tables))

    @cached_property
    def keys(self) -> list[str]:
        """Every key there is, ``rod.length`` and ``name``."""
        return [*self.single, *(f"{table}.{key}" for table, model in self.tables.items() for key in model.model_fields)]

    def __str__(self) -> str:
        ending = "s" if len(self.single) > 1 else ""
        listed = ", ".join(f"[{table}]" for table in self.tables)
        return f"a system has the key{ending} {' and '.join(self.single)} and the tables {listed}"


def refusal(error: ValidationError, kind: FileKind, tables: Mapping[str, object]) -> InputError:
    """The first problem as a sentence, with the number of others.

    ``error``: what pydantic found.  ``tables``: the file; in an array of tables the sentence says which one is meant.

    Notes
    -----
    Unknown keys come first, since a misspelt key is also a missing one; a missing key that such a sentence proposes is
    not counted again.
    """
    details = error.errors(include_url=False)
    unknown = [item for item in details if item["type"] == "extra_forbidden"]
    proposed = {nearest_key(_path(item), kind) for item in unknown}
    problems = [_which(item, tables) + unknown_key(_path(item), kind) for item in unknown]
    missing = [item for item in details if item["type"] == "missing" and _path(item) not in proposed]
    problems += [_which(item, tables) + _missing(item, kind) for item in missing]
    wrong = [item for item in details if item["type"] not in ("extra_forbidden", "missing")]
    problems += [_which(item, tables) + _wrong(item, kind) for item in wrong]
    more = f" (and {len(problems) - 1} more to mend)" if len(problems) > 1 else ""
    return InputError(f"{problems[0]}{more}")


def nearest_key(key: str, kind: FileKind) -> str | None:
    """The key or table that a misspelt dotted key most likely means."""
    table, _, last = key.rpartition(".")
    if last in kind.letters:
        return kind.letters[last]
    if table in kind.tables:
        inside = _closest(last, kind.tables[table].model_fields)
        if inside:
            return f"{table}.{inside}"
    elif not table:
        first = _closest(last, [*kind.single, *kind.tables])
        if first:
            return first
    elsewhere = {candidate.rpartition(".")[2]: candidate for candidate in reversed(kind.keys)}
    whole = None if last in elsewhere else _closest(key, kind.keys)
    if whole:
        return whole
    end = _closest(last, elsewhere)
    return elsewhere[end] if end else None


def unknown_key(key: str, kind: FileKind) -> str:
    """Sentence on a key that does not exist: what was meant, and what is allowed there."""
    table = key.rpartition(".")[0]
    near = nearest_key(key, kind)
    hint = f"did you mean {near}? " if near else ""
    allowed = f"[{table}] takes {', '.join(kind.tables[table].model_fields)}" if table in kind.tables else str(kind)
    return f"unknown key {shown(key)[1:-1]}; {hint}{allowed}"


def _path(item: ErrorDetails) -> str:
    """The dotted key, without the place in an array of tables."""
    return ".".join(str(part) for part in item["loc"] if not isinstance(part, int))


def _which(item: ErrorDetails, tables: Mapping[str, object]) -> str:
    """Which table of an array is meant, to stand before the sentence; empty for a table that stands alone."""
    name, *place = item["loc"]
    many = isinstance(tables.get(str(name)), list) and place and isinstance(place[0], int)
    return f"[[{name}]] number {int(place[0]) + 1}: " if many else ""


def _missing(item: ErrorDetails, kind: FileKind) -> str:
    path = _path(item)
    if path in kind.tables:
        fields = kind.tables[path].model_fields
        plain = [key for key, entry in fields.items() if not str(entry.description).startswith("a table")]
        required = [key for key, entry in fields.items() if entry.is_required()] or plain[:2]
        return f"the table [{path}] is missing; give it with {', '.join(required)}"
    table, _, key = path.partition(".")
    return f"{path} is missing; give {kind.tables[table].model_fields[key].description}"


def _wrong(item: ErrorDetails, kind: FileKind) -> str:
    if item["type"] == "value_error":
        return str(item["ctx"]["error"]).rstrip(".")
    path = _path(item)
    if path in kind.tables:
        return f"{path} is {shown(item['input'])}; give a table that starts with the line [{path}]"
    raise AssertionError(f"{path}: no sentence for pydantic's {item['type']}")

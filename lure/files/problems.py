"""pydantic's findings as one sentence: the field, the value and the fix."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from lure.errors import InputError
from lure.files.values import shown
from lure.rod.file import TABLES, dotted_keys

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError
    from pydantic_core import ErrorDetails

_CLOSE = 0.7
_LETTERS = {
    "E": "rod.youngs_modulus",
    "rho": "rod.density",
    "L": "rod.length",
    "A": "rod.area",
    "k": "rod.damping",
    "eps": "rod.compliance",
    "m": "rod.exponent",
    "N": "discretisation.cells",
}


@dataclass(frozen=True, kw_only=True)
class Vocabulary:
    """The keys of one kind of file.

    Attributes
    ----------
    tables : Mapping of str to type
        The model of each table.
    single : tuple of str
        Keys outside the tables.
    letters : Mapping of str to str
        Symbols of the formulas and the keys they stand for.
    """

    tables: Mapping[str, type[BaseModel]]
    single: tuple[str, ...] = ("name",)
    letters: Mapping[str, str] = field(default_factory=dict)

    @property
    def keys(self) -> list[str]:
        """Every key there is, ``rod.length`` and ``name``."""
        return dotted_keys(self.tables, self.single)

    def __str__(self) -> str:
        ending = "s" if len(self.single) > 1 else ""
        listed = ", ".join(f"[{table}]" for table in self.tables)
        return f"a system has the key{ending} {' and '.join(self.single)} and the tables {listed}"


ROD_FILE = Vocabulary(tables=TABLES, letters=_LETTERS)


def refusal(error: ValidationError, words: Vocabulary = ROD_FILE) -> InputError:
    """The first problem as a sentence, with the number of others.

    Parameters
    ----------
    error : ValidationError
        What pydantic found.
    words : Vocabulary
        The keys of the file.

    Notes
    -----
    Unknown keys come first, since a misspelt key is also a missing one; a missing key that such a sentence proposes is
    not counted again.
    """
    details = error.errors(include_url=False)
    unknown = [".".join(map(str, item["loc"])) for item in details if item["type"] == "extra_forbidden"]
    proposed = {nearest_key(key, words) for key in unknown}
    problems = [unknown_key(key, words) for key in unknown]
    problems += [_missing(item, words) for item in details if item["type"] == "missing" and _path(item) not in proposed]
    problems += [_wrong(item, words) for item in details if item["type"] not in ("extra_forbidden", "missing")]
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return InputError(f"{problems[0]}{more}")


def nearest_key(key: str, words: Vocabulary = ROD_FILE) -> str | None:
    """The key or table that a misspelt dotted key most likely means.

    >>> nearest_key("rod.dampng"), nearest_key("rod.eps"), nearest_key("cell"), nearest_key("rods")
    ('rod.damping', 'rod.compliance', 'discretisation.cells', 'rod')
    """
    table, _, last = key.rpartition(".")
    if last in words.letters:
        return words.letters[last]
    if table in words.tables:
        inside = _closest(last, words.tables[table].model_fields)
        if inside:
            return f"{table}.{inside}"
    elif not table:
        first = _closest(last, [*words.single, *words.tables])
        if first:
            return first
    elsewhere = {candidate.rpartition(".")[2]: candidate for candidate in reversed(words.keys)}
    whole = None if last in elsewhere else _closest(key, words.keys)
    if whole:
        return whole
    end = _closest(last, elsewhere)
    return elsewhere[end] if end else None


def unknown_key(key: str, words: Vocabulary = ROD_FILE) -> str:
    """Sentence on a key that does not exist: what was meant, and what is allowed there."""
    table = key.rpartition(".")[0]
    near = nearest_key(key, words)
    hint = f"did you mean {near}? " if near else ""
    allowed = f"[{table}] takes {', '.join(words.tables[table].model_fields)}" if table in words.tables else str(words)
    return f"unknown key {shown(key)[1:-1]}; {hint}{allowed}"


def _closest(word: str, known: Iterable[str]) -> str | None:
    found = difflib.get_close_matches(word[:40].lower(), known, n=1, cutoff=_CLOSE)
    return found[0] if found else None


def _path(item: ErrorDetails) -> str:
    return ".".join(map(str, item["loc"]))


def _missing(item: ErrorDetails, words: Vocabulary) -> str:
    path = _path(item)
    if path in words.tables:
        fields = words.tables[path].model_fields
        required = [key for key, entry in fields.items() if entry.is_required()] or list(fields)[:2]
        return f"the table [{path}] is missing; give it with {', '.join(required)}"
    table, _, key = path.partition(".")
    return f"{path} is missing; give {words.tables[table].model_fields[key].description}"


def _wrong(item: ErrorDetails, words: Vocabulary) -> str:
    if item["type"] == "value_error":
        return str(item["ctx"]["error"]).rstrip(".")
    path = _path(item)
    if path in words.tables:
        return f"{path} is {shown(item['input'])}; give a table that starts with the line [{path}]"
    raise AssertionError(f"{path}: no sentence for pydantic's {item['type']}")

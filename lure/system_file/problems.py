"""pydantic's findings as one sentence: the field, the value and the fix."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

from lure.errors import InputError
from lure.system_file.schema import TABLES, dotted_keys
from lure.system_file.values import shown

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

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
_KNOWN = f"a system has the key name and the tables {', '.join(f'[{table}]' for table in TABLES)}"


def refusal(error: ValidationError) -> InputError:
    """The first problem as a sentence, with the number of others.

    Unknown keys come first, since a misspelt key is also a missing one; a missing key that such a sentence proposes is
    not counted again.
    """
    details = error.errors(include_url=False)
    unknown = [".".join(map(str, item["loc"])) for item in details if item["type"] == "extra_forbidden"]
    proposed = {nearest_key(key) for key in unknown}
    problems = [unknown_key(key) for key in unknown]
    problems += [_missing(item) for item in details if item["type"] == "missing" and _path(item) not in proposed]
    problems += [_wrong(item) for item in details if item["type"] not in ("extra_forbidden", "missing")]
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return InputError(f"{problems[0]}{more}")


def nearest_key(key: str) -> str | None:
    """The key or table that a misspelt dotted key most likely means.

    >>> nearest_key("rod.dampng"), nearest_key("rod.eps"), nearest_key("cell"), nearest_key("rods")
    ('rod.damping', 'rod.compliance', 'discretisation.cells', 'rod')
    """
    table, _, last = key.rpartition(".")
    if last in _LETTERS:
        return _LETTERS[last]
    if table in TABLES:
        inside = _closest(last, TABLES[table].model_fields)
        if inside:
            return f"{table}.{inside}"
    elif not table:
        first = _closest(last, ["name", *TABLES])
        if first:
            return first
    elsewhere = {candidate.rpartition(".")[2]: candidate for candidate in reversed(dotted_keys())}
    whole = None if last in elsewhere else _closest(key, dotted_keys())
    if whole:
        return whole
    end = _closest(last, elsewhere)
    return elsewhere[end] if end else None


def unknown_key(key: str) -> str:
    """Sentence on a key that does not exist: what was meant, and what is allowed there."""
    table = key.rpartition(".")[0]
    near = nearest_key(key)
    hint = f"did you mean {near}? " if near else ""
    allowed = f"[{table}] takes {', '.join(TABLES[table].model_fields)}" if table in TABLES else _KNOWN
    return f"unknown key {shown(key)[1:-1]}; {hint}{allowed}"


def _closest(word: str, known: Iterable[str]) -> str | None:
    found = difflib.get_close_matches(word[:40].lower(), known, n=1, cutoff=0.6)
    return found[0] if found else None


def _path(item: ErrorDetails) -> str:
    return ".".join(map(str, item["loc"]))


def _missing(item: ErrorDetails) -> str:
    path = _path(item)
    if path in TABLES:
        required = [key for key, field in TABLES[path].model_fields.items() if field.is_required()]
        return f"the table [{path}] is missing; give it with {', '.join(required)}"
    table, _, key = path.partition(".")
    return f"{path} is missing; give {TABLES[table].model_fields[key].description}"


def _wrong(item: ErrorDetails) -> str:
    if item["type"] == "value_error":
        return str(item["ctx"]["error"]).rstrip(".")
    path = _path(item)
    if path in TABLES:
        return f"{path} is {shown(item['input'])}; give a table that starts with the line [{path}]"
    raise AssertionError(f"{path}: no sentence for pydantic's {item['type']}")

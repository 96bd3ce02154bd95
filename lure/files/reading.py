"""From the name of a built-in, a file or a text to a checked rod or loop."""

from __future__ import annotations

import difflib
import stat
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from lure.errors import InputError
from lure.files.builtin import builtin_loop, loop_names
from lure.files.loop import built_loop, is_plant_file, loop_tables
from lure.files.problems import ROD_FILE, Vocabulary, refusal, unknown_key
from lure.files.schema import PLANT_FILE, PLANT_TEXTS, PlantTables
from lure.files.system import LoopSystem
from lure.files.values import exact_decimal, number_or_text, shown, shown_path
from lure.rod.file import TEXT_KEYS, SystemTables, built_system, system_tables
from lure.rod.systems import RodSystem, builtin_system, builtin_systems

MAX_BYTES = 64 * 1024
_MAX_DOTS = 1000
Tables: TypeAlias = dict[str, Any]


def find_system(reference: str, settings: Sequence[str] = ()) -> RodSystem | LoopSystem:
    """The system a user names: a built-in, else a file (the name ends in ``.toml``, or something of that name exists).

    Parameters
    ----------
    reference : str
        ``"paper-rod"``, ``"kalman-fitts"`` or the path of a TOML file.
    settings : sequence of str
        Changes made before anything is checked, each as ``"rod.damping=8e-4"``; the last of two for one key counts.

    Raises
    ------
    InputError
        There is no such system, or :func:`read_system` refuses it.

    Examples
    --------
    >>> system = find_system("paper-rod", ["rod.damping=8e-4"])
    >>> system.name, system.rod.damping
    ('paper-rod (changed)', 0.0008)
    """
    if reference in builtin_systems() or reference in loop_names():
        system = builtin_system(reference) if reference in builtin_systems() else builtin_loop(reference)
        if not settings:
            return system
        tables = system_tables(system) if isinstance(system, RodSystem) else loop_tables(system)
        tables = _changed(tables, settings, ROD_FILE if isinstance(system, RodSystem) else PLANT_FILE)
        name = system.name if tables.get("name") == system.name else None
        tables["name"] = f"{name} (changed)" if name else tables.get("name")
        if tables.get("title") == system.title:
            del tables["title"]
        changes = _changes(settings)
        return _checked(tables, title=system.title + changes, source=system.source + changes)
    path = Path(reference)
    if reference.endswith(".toml") or path.exists():
        return read_system(path, settings)
    names = [*builtin_systems(), *loop_names()]
    near = difflib.get_close_matches(reference, names, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise InputError(
        f"there is no built-in system {reference!r}; {hint}choose from those that lure systems lists, or give the path "
        "of a TOML file"
    )


def read_system(path: Path, settings: Sequence[str] = ()) -> RodSystem | LoopSystem:
    """The system in a TOML file, every decimal taken exactly (``0.1`` is 1/10).

    Parameters
    ----------
    path : Path
        An ordinary file.
    settings : sequence of str
        As for :func:`find_system`.

    Raises
    ------
    InputError
        The file cannot be read, is not UTF-8 text of at most 64 KiB, does not parse, or holds unknown keys or wrong
        values.  One sentence: the field, the value and the fix, with the number of further problems.
    """
    return parse_system(_text(path), name=path.stem, source=path.name, settings=settings, folder=path.parent)


def parse_system(
    text: str, *, name: str, source: str, settings: Sequence[str] = (), folder: Path = Path()
) -> RodSystem | LoopSystem:
    """The system in the text of a TOML file: a loop if it has a table ``[plant]``, else a rod.

    Parameters
    ----------
    text : str
        The text.
    name : str
        Name of the system, should the text give none.
    source : str
        Where the text comes from, for messages and for the ``source`` of the system.
    settings : sequence of str
        As for :func:`find_system`.
    folder : Path
        Where the files lie that the text names; the working directory by default.

    Raises
    ------
    InputError
        As for :func:`read_system`.

    Examples
    --------
    >>> from lure.files import template
    >>> system = parse_system(template(), name="rod", source="the template")
    >>> system.rod.exact["damping"], system.cells
    (Fraction(1, 5000), 10)
    """
    label = shown_path(source)
    # the time and memory tomllib needs grow with the square of the parts of a dotted key
    if max(line.count(".") for line in text.split("\n")) > _MAX_DOTS:
        raise InputError(f"{label} has a line with more than {_MAX_DOTS} points; no key is nested like that")
    try:
        tables = tomllib.loads(text, parse_float=exact_decimal)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{label} does not parse as TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{label} does not parse as TOML: brackets are nested too deeply") from None
    except ValueError:  # int() of more than 4300 digits
        raise InputError(f"{label} does not parse as TOML: a whole number has more than 4300 digits") from None
    plant = is_plant_file(tables)
    tables = _changed(tables, settings, PLANT_FILE if plant else ROD_FILE)
    tables.setdefault("name", shown(name)[1:-1] or ("loop" if plant else "rod"))
    changes = _changes(settings)
    title = f"the {'loop' if plant else 'rod'} of {label}{changes}"
    return _checked(tables, title=title, source=f"{label}{changes}", folder=folder)


def _text(path: Path) -> str:
    label = shown_path(str(path))
    try:
        kind = path.stat().st_mode
        content = b""
        if stat.S_ISREG(kind):  # nothing is read from a pipe or a device, which could go on for ever
            with path.open("rb") as file:
                content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{label} does not exist; `lure init {label}` writes a file to start from") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{label} cannot be read ({reason}); give a readable TOML file") from None
    if not stat.S_ISREG(kind):
        raise InputError(
            f"{label} is {'a directory' if stat.S_ISDIR(kind) else 'not an ordinary file'}; give a TOML file"
        )
    if len(content) > MAX_BYTES:
        raise InputError(f"{label} is larger than {MAX_BYTES // 1024} KiB; a system file is a page of text")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{label} is not UTF-8 text (byte {content[error.start]:#04x} at position {error.start}); save it as UTF-8"
        ) from None


def _changes(settings: Sequence[str]) -> str:
    return "".join(f"; with {shown(setting.strip())[1:-1]}" for setting in settings)


def _changed(tables: Tables, settings: Sequence[str], words: Vocabulary) -> Tables:
    changed = {key: dict(value) if isinstance(value, dict) else value for key, value in tables.items()}
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals:
            raise InputError(f"--set {shown(setting)[1:-1]}: give KEY=VALUE, such as --set rod.damping=8e-4")
        if not key:
            raise InputError(f"--set {shown(setting)[1:-1]}: the key is missing; give one such as rod.damping=8e-4")
        if key not in words.keys and not (words is PLANT_FILE and key.startswith("nonlinearity.")):
            raise InputError(f"--set: {unknown_key(key, words)}")
        table, _, last = key.rpartition(".")
        target = changed.setdefault(table, {}) if table else changed
        if isinstance(target, dict):  # otherwise the file is wrong here, and is told so when it is checked
            target[last] = _value(key, text, words)
    return changed


def _value(key: str, text: str, words: Vocabulary) -> object:
    if key in (TEXT_KEYS if words is ROD_FILE else PLANT_TEXTS):
        return text
    if words is PLANT_FILE and text in ("true", "false"):
        return text == "true"
    return number_or_text(text)


def _checked(tables: Tables, *, title: str, source: str, folder: Path = Path()) -> RodSystem | LoopSystem:
    plant = is_plant_file(tables)
    try:
        if plant:
            return built_loop(PlantTables.model_validate(tables), title=title, source=source, folder=folder)
        checked = SystemTables.model_validate(tables)
    except ValidationError as error:
        raise refusal(error, PLANT_FILE if plant else ROD_FILE) from None
    return built_system(checked, title=title, source=source)

"""From the name of a built-in, a file or a text to a checked system."""

from __future__ import annotations

import re
import stat
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from lure.errors import InputError, closest, did_you_mean
from lure.extensions import extensions
from lure.files.kinds import FileKind, NamedSystem, refusal, unknown_key
from lure.files.loop import PLANT_FILE
from lure.files.values import exact_decimal, number_or_text, shown, shown_path
from lure.record import described, quantity

MAX_BYTES = 64 * 1024
_MAX_DOTS = 1000
Tables: TypeAlias = dict[str, Any]


def kinds() -> list[FileKind]:
    """The kinds of files that are read: those registered as ``system file``, and files with a ``[plant]``."""
    return [*extensions("system file"), PLANT_FILE]


def kind_of(tables: Tables) -> FileKind:
    """The kind of a file: by its tables, else by what is written like one of them, else the first.

    Raises
    ------
    InputError
        The file is of two kinds.
    """
    if PLANT_FILE.first in tables and tables.keys() <= {*PLANT_FILE.tables, *PLANT_FILE.single}:
        return PLANT_FILE  # of no other kind, which need not be imported
    known = kinds()
    told = [kind for kind in known if kind.first in tables]
    told = [kind for kind in told if not any(kind.first in other.beside for other in told)]
    if len(told) > 1:
        raise InputError(f"the file has both [{told[0].first}] and [{told[1].first}]; give one of them, or two files")
    if told:
        return told[0]
    for kind in known:
        if any(table in tables for table in kind.tables):
            return kind
    for kind in known:  # keys of its first table, without the line that begins it
        if tables.keys() & {*kind.tables[kind.first].model_fields, *kind.letters}:
            return kind
    names = [*(table for kind in known for table in kind.tables), "name", "title"]
    near = {closest(key, names, cutoff=0.6) for key in tables} - {None}
    return next((kind for kind in reversed(known) if near & set(kind.tables)), known[0])


def find_system(reference: str, settings: Sequence[str] = ()) -> NamedSystem:
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
    return system_source(reference).changed(settings)


@described(frozen=True, kw_only=True)
class SystemSource:
    """A system read once, of which many variants are asked."""

    kind: FileKind = quantity("The kind of its file")
    tables: Tables = quantity("The tables that mean it, unchanged")
    name: str = quantity("Of the system, as are ``title`` and ``source``")
    title: str
    source: str
    folder: Path = quantity("Where the files lie that the tables name", default=Path())
    builtin: NamedSystem | None = quantity("The built-in system, if it is one", default=None)

    def changed(self, settings: Sequence[str] = ()) -> NamedSystem:
        """The system with some values changed.

        ``settings``: as for :func:`find_system`.

        Raises
        ------
        InputError
            A key or a value is no good.
        """
        if self.builtin is not None and not settings:
            return self.builtin
        tables = _changed(self.tables, settings, self.kind)
        if self.builtin is None:
            tables.setdefault("name", self.name)
        else:
            name = self.name if tables.get("name") == self.name else None
            tables["name"] = f"{name} (changed)" if name else tables.get("name")
            if tables.get("title") == self.title:
                del tables["title"]
        changes = "".join(f"; with {shown(setting.strip())[1:-1]}" for setting in settings)
        title, source = self.title + changes, self.source + changes
        return _checked(tables, self.kind, title=title, source=source, folder=self.folder)

    def check_key(self, key: str, where: str) -> None:
        """Refuse a key that no file of this kind has.

        ``key``: as before the ``=`` of a setting; ``where``: where it was given, for the message.

        Raises
        ------
        InputError
            There is no such key.
        """
        _changed(self.tables, [f"{key}=0"], self.kind, where)


def system_source(reference: str) -> SystemSource:
    """What the variants of one system are made from; it is read, and not yet checked.

    ``reference``: as for :func:`find_system`.

    Raises
    ------
    InputError
        There is no such system, or it cannot be read.
    """
    file = reference.endswith(".toml")
    names = {} if file else {name: kind for kind in kinds() for name in kind.names()}
    if reference in names:
        kind = names[reference]
        system = kind.builtin(reference)
        name, title, tables = system.name, system.title, kind.written(system)
        return SystemSource(kind=kind, tables=tables, name=name, title=title, source=system.source, builtin=system)
    path, beside = Path(reference), f"{reference}.toml"
    try:
        there, meant = path.exists(), Path(beside).is_file()
    except OSError:  # no name of a file
        there = meant = False
    if file or there:
        return _source_of(_text(path), name=path.stem, source=path.name, folder=path.parent)
    hint = f"did you mean {beside!r}? " if meant else did_you_mean(reference, names, cutoff=0.6)
    if any(mark in reference for mark in "(^*"):
        raise InputError(
            f"there is no built-in system {shown(reference)}; give a formula as lure max-sector --transfer "
            f"{shown(reference)}, or as transfer = {shown(reference)} below [plant] in a TOML file"
        )
    raise InputError(
        f"there is no built-in system {shown(reference)}; {hint}choose from those that lure systems lists, or give the "
        "path of a TOML file"
    )


def read_system(path: Path, settings: Sequence[str] = ()) -> NamedSystem:
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
) -> NamedSystem:
    """The system in the text of a TOML file, of the kind that its tables tell: a loop if it has a ``[plant]``.

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
    >>> from lure.files import plant_template
    >>> print(parse_system(plant_template(), name="loop", source="the template").block)
    1 / (s^3 + 3 s^2 + 2 s)
    """
    return _source_of(text, name=name, source=source, folder=folder).changed(settings)


def tables_of(text: str, label: str) -> Tables:
    """The tables of a TOML file, every decimal exact; ``label``: what messages call the file.

    Raises
    ------
    InputError
        It does not parse.
    """
    # the time and memory tomllib needs grow with the square of the parts of a dotted key
    if max(line.count(".") for line in text.split("\n")) > _MAX_DOTS:
        raise InputError(f"{label} has a line with more than {_MAX_DOTS} points; no key is nested like that")
    try:
        return tomllib.loads(text, parse_float=exact_decimal)
    except tomllib.TOMLDecodeError as error:
        both = [
            word for word in ("class", "nonlinearity") if _stands(f"[{word}]", text) and _stands(f"[[{word}]]", text)
        ]
        if both:
            raise InputError(
                f"{label} has both [{both[0]}] and [[{both[0]}]]; give [{both[0]}] for one channel, or "
                f"[[{both[0]}]] for each of several, in order"
            ) from None
        raise InputError(f"{label} does not parse as TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{label} does not parse as TOML: brackets are nested too deeply") from None
    except ValueError:  # int() of more than 4300 digits
        raise InputError(f"{label} does not parse as TOML: a whole number has more than 4300 digits") from None


def _source_of(text: str, *, name: str, source: str, folder: Path) -> SystemSource:
    label = shown_path(source)
    tables = tables_of(text, label)
    if not tables:
        raise InputError(f"{label} is empty; `lure init --loop` writes a loop to start from, `lure init` a rod")
    kind = kind_of(tables)
    called = shown(name)[1:-1] or kind.word
    title = f"the {kind.word} of {label}"
    return SystemSource(kind=kind, tables=tables, name=called, title=title, source=label, folder=folder)


_DATA = {
    ".mat": "in Python as_plant takes what scipy.io.loadmat reads, as_plant((m['A'], m['B'], m['C'], m['D']))",
    ".csv": "in Python FrequencyData(omega, response) is a measured H, and lure sector bounds a measured nonlinearity",
}


def _text(path: Path) -> str:
    label = shown_path(str(path))
    if (hint := _DATA.get(path.suffix.lower())) and path.is_file():
        raise InputError(f"{label} is data, and a system is a TOML file (lure init --loop writes one); {hint}")
    try:
        kind = path.stat().st_mode
        content = b""
        if stat.S_ISREG(kind):  # nothing is read from a pipe or a device, which could go on for ever
            with path.open("rb") as file:
                content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise InputError(
            f"{label} does not exist; `lure init --loop {label}` writes a loop to start from, `lure init {label}` a rod"
        ) from None
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


def _stands(head: str, text: str) -> bool:
    """Whether a line of the text begins a table."""
    return any("".join(line.split("#")[0].split()) == head for line in text.split("\n"))


def _changed(tables: Tables, settings: Sequence[str], kind: FileKind, where: str = "--set") -> Tables:
    changed = {key: _copied(value) for key, value in tables.items()}
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        if not equals:
            raise InputError(f"--set {shown(setting)[1:-1]}: give KEY=VALUE, such as --set rod.damping=8e-4")
        if not key:
            raise InputError(f"--set {shown(setting)[1:-1]}: the key is missing; give one such as rod.damping=8e-4")
        key, place = _placed(key)
        table, _, last = key.rpartition(".")
        inner = table in kind.keys  # an entry of a table within a table: the file tells
        if not inner and key not in kind.keys and not (kind.free and key.startswith(f"{kind.free}.")):
            raise InputError(f"{where}: {unknown_key(key, kind)}")
        outer = changed.setdefault(table, {}) if table and not inner else changed
        target = _inner(changed, table, last, kind, where) if inner else outer
        if isinstance(target, list):
            if place is None or not 0 < place <= len(target):
                raise InputError(
                    f"{where}: the file has {len(target)} tables [[{table}]]; say which one, such as "
                    f"{table}.{len(target)}.{last}"
                )
            target = target[place - 1]
        elif place is not None:
            raise InputError(f"{where}: there is no array of tables [[{table}]]; give {key}")
        if isinstance(target, dict):  # otherwise the file is wrong here, and is told so when it is checked
            target[last] = _value(key, text, kind)
    return changed


def _inner(changed: Tables, key: str, last: str, kind: FileKind, where: str) -> object:
    """A table within a table, such as ``plant.parameters``, that the file has with such an entry; it may be changed."""
    table, _, name = key.rpartition(".")
    outer = changed.get(table)
    inner = outer.get(name) if isinstance(outer, dict) else None
    if isinstance(inner, list | str | int | float):
        named = f", or name a constant of it in [{table}.parameters]" if f"{table}.parameters" in kind.keys else ""
        raise InputError(f"{where}: {key} is no table, and {key}.{last} no key; change {key} as a whole{named}")
    if not isinstance(outer, dict) or not isinstance(inner, dict):
        raise InputError(f"{where}: the {kind.word} has no table [{key}]; give it in the file")
    if last not in inner:
        hint = did_you_mean(last, map(str, inner))
        raise InputError(f"{where}: [{key}] has no {shown(last)[1:-1]}; {hint}it has {', '.join(map(str, inner))}")
    outer[name] = found = dict(inner)
    return found


def _copied(value: object) -> object:
    """A table, or an array of tables, that may be changed; nothing deeper is."""
    if isinstance(value, list):
        return [dict(each) if isinstance(each, dict) else each for each in value]
    return dict(value) if isinstance(value, dict) else value


def _placed(key: str) -> tuple[str, int | None]:
    """``class.2.sector`` as ``class.sector`` and 2: the number, from 1, of a table in an array."""
    parts = key.split(".")
    if len(parts) == 3 and re.fullmatch(r"[0-9]{1,3}", parts[1]):
        return f"{parts[0]}.{parts[2]}", int(parts[1])
    return key, None


def _value(key: str, text: str, kind: FileKind) -> object:
    if key in kind.texts:
        return text
    if kind.free and text in ("true", "false"):  # elsewhere there are no truth values
        return text == "true"
    if text.startswith("[") and "{" not in text:
        try:
            read = tomllib.loads(f"value = {text}", parse_float=exact_decimal)
        except (ValueError, RecursionError):  # no TOML: a pair such as [0, 1/3], or a mistake that is told as text
            return text
        return read["value"] if len(read) == 1 else text
    return number_or_text(text)


def _checked(tables: Tables, kind: FileKind, *, title: str, source: str, folder: Path = Path()) -> NamedSystem:
    try:
        checked = kind.model.model_validate(tables)
    except ValidationError as error:
        raise refusal(error, kind, tables) from None
    return kind.build(checked, title=title, source=source, folder=folder)

"""The directives ``toml-keys`` and ``nonlinearity-kinds``: what a system file may hold, read off its models."""

from __future__ import annotations

import re
import types
import typing
from fractions import Fraction

from docutils import nodes
from docutils.statemachine import StringList
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from lure_docs.escaping import escaped

_WORDS = {
    Fraction: "number",
    int: "whole number",
    bool: "true or false",
    "Expression": "formula",
    tuple[Fraction, ...]: "list of numbers",
    tuple[str, ...]: "list of texts",
    tuple[Fraction | str, ...]: "list of numbers",
    dict[str, typing.Any]: "table",
    list[typing.Any]: "list of rows",
    tuple[float | Fraction, float | Fraction]: "two numbers, inf allowed",
    tuple[int, int]: "two whole numbers, or one",
}


class Keys(SphinxDirective):
    """Tables of the keys of a ``rod`` file, of one of ``rods``, or of a ``plant`` file."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """One table for the keys outside every table of the file, and one for each table."""
        from lure.files.schema import PLANT_TABLES, PlantTables
        from lure.rod.assembly_file import ASSEMBLY_FILE, AssemblyTables
        from lure.rod.file import TABLES, SystemTables

        whole: type[BaseModel]
        whole, tables = {
            "plant": (PlantTables, PLANT_TABLES),
            "rod": (SystemTables, TABLES),
            "rods": (AssemblyTables, ASSEMBLY_FILE.tables),
        }[self.arguments[0]]
        lines = _table("At the top of the file", whole, leave_out=set(whole.model_fields) - {"name", "title"})
        for name, model in tables.items():
            lines += _table(f"[{name}]", model, leave_out=set())
        return self.parse_text_to_nodes(StringList(lines, source=whole.__module__))


def _table(title: str, model: type[BaseModel], leave_out: set[str]) -> list[str]:
    lines = [
        f".. rubric:: {title}",
        "",
        ".. list-table::",
        "   :class: keys",
        "   :header-rows: 1",
        "   :widths: 20 22 12 16 30",
        "",
    ]
    lines += _row("Key", "Type", "Unit", "Default", "Meaning")
    for name, field in model.model_fields.items():
        if name not in leave_out:
            meaning, unit = _meaning(field)
            lines += _row(f"``{name}``", _type(field), escaped(unit), _default(field), escaped(meaning))
    return [*lines, ""]


def _row(first: str, *others: str) -> list[str]:
    return [f"   * - {first}", *(f"     - {cell}" for cell in others)]


def _meaning(field: FieldInfo) -> tuple[str, str]:
    """The description without its unit, and the unit."""
    text = field.description or ""
    found = re.search(r"\s*\[([^\]]+)\]$", text)
    return (text[: found.start()], found[1].replace("-", "")) if found else (text, "")


def _type(field: FieldInfo) -> str:
    kind = field.annotation
    if isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
        kind = next(part for part in typing.get_args(kind) if part is not type(None))
    if typing.get_origin(kind) is typing.Annotated:
        kind = typing.get_args(kind)[0]
    if typing.get_origin(kind) is typing.Literal:
        return " or ".join(f'``"{choice}"``' for choice in typing.get_args(kind))
    if kind is str:
        return "formula in quotes" if "formula" in (field.description or "") else "text"
    return _WORDS.get(kind) or _WORDS[getattr(kind, "__name__", "")]


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.default
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"``{str(value).lower()}``"
    if isinstance(value, tuple):
        return ", ".join(f"``{one}``" for one in value)
    return f'``"{value}"``' if isinstance(value, str) else f"``{value}``"


class Kinds(SphinxDirective):
    """Each kind of nonlinearity that ``[nonlinearity]`` takes, with its parameters."""

    def run(self) -> list[nodes.Node]:
        """Read off the table by which the nonlinearities are made."""
        from lure.nonlinearities.reading import _KINDS, _SPELLINGS

        lines = [".. list-table::", "   :class: keys", "   :header-rows: 1", "   :widths: 22 26 26 26", ""]
        lines += _row("``kind``", "needs", "may have", "see")
        for name, entry in _KINDS.items():
            needed = ", ".join(f"``{key}``" for key in entry.needs)
            more = ", ".join(f"``{key}``" for key in entry.keys if key not in (*entry.needs, "kind"))
            make = getattr(entry.make, "func", entry.make)  # of a partial: what it calls
            role = "class" if isinstance(make, type) else "func"
            made = f"{make.__module__}.{make.__qualname__}"
            stands_for = {
                "_expression": ":class:`~lure.ExpressionNonlinearity`",
                "_through_points": ":class:`~lure.PiecewiseLinear`",
            }
            seen = stands_for.get(make.__qualname__, f":{role}:`~{made}`")
            lines += _row(f'``"{name}"``', needed, more, seen)
        others = ", ".join(f'``"{word}"`` for ``"{name}"``' for word, name in sorted(_SPELLINGS.items()))
        lines += [
            "",
            f"Small and capital letters mean the same, as do blanks, ``-`` and ``_``.  Read as well: {others}.",
            "",
        ]
        return self.parse_text_to_nodes(StringList(lines, source="lure.nonlinearities.reading"))


def setup(app: Sphinx) -> None:
    """Register the directives."""
    app.add_directive("toml-keys", Keys)
    app.add_directive("nonlinearity-kinds", Kinds)

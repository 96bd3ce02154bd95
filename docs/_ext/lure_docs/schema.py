"""The directive ``json-schema``: a published JSON schema as tables, a section for each of its parts.

A schema of many parts has several pages: ``:whole:`` shows the schema and where each part is, a list of names in the
directive's content those parts.  Sphinx warns of a part that is on no page, or on two.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any, ClassVar, TypeAlias

from docutils import nodes
from docutils.parsers.rst import directives
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from lure_docs.escaping import escaped

Part: TypeAlias = dict[str, Any]


class Schema(SphinxDirective):
    """The schema ``schema.json`` of a package; labels of its parts begin with the word given second."""

    required_arguments = 2
    option_spec: ClassVar = {"whole": directives.flag}
    has_content = True

    def run(self) -> list[nodes.Node]:
        """The whole first, then its parts in the order of the file; or what the options ask for."""
        package, label = self.arguments
        schema = json.loads(files(package).joinpath("schema.json").read_text(encoding="utf-8"))
        lines, level = [], "-"
        if not self.content:
            lines += [escaped(schema["description"]), ""]
            if "oneOf" in schema:
                lines += [f"It is {_type(schema, label)}.", ""]
            else:
                lines += [*_keys(schema, label), *_theorems(schema, label)]
            lines, level = [*lines, "", "Parts", "-----", ""], "~"
        if "whole" in self.options:
            whole = self._parsed(lines, package)
            whole[-1] += self._places(schema, label)
            return whole
        for name in " ".join(self.content).split() or schema["$defs"]:
            part, title = schema["$defs"][name], name.replace("_", " ")
            lines += ["", f".. _{label}-{name}:", "", title, level * len(title), ""]
            lines += _object(part, label) if part.get("properties") else _plain(part, label)
        return self._parsed(lines, package)

    def _parsed(self, lines: list[str], source: str) -> list[nodes.Node]:
        return self.parse_text_to_nodes(StringList(lines, source=source), allow_section_headings=True)

    def _places(self, schema: Part, label: str) -> nodes.Node:
        """A link to each part, which has the anchor that the part has on its own page."""
        links = nodes.paragraph()
        for name in schema["$defs"]:
            (line,) = self._parsed([_type({"$ref": name}, label)], label)
            links += nodes.inline("", "", *line.children, ids=[f"{label}-{name}".replace("_", "-")])
            links += nodes.Text(" · ")
        return links


def _object(part: Part, label: str) -> list[str]:
    return [escaped(part.get("description", "")), "", *_keys(part, label)]


def _plain(part: Part, label: str) -> list[str]:
    words = escaped(part.get("description", ""))
    return [f"{words} *Type:* {_type(part, label)}.".strip(), ""]


def _keys(part: Part, label: str) -> list[str]:
    """One row for each key, those of inner objects with a point; what need not be there says so."""
    lines = [".. list-table::", "   :class: keys", "   :header-rows: 1", "   :widths: 34 26 40", ""]
    for row in (("Key", "Type", "Meaning"), *_rows(part, label, "")):
        lines += [f"   * - {row[0]}", *(f"     - {cell}" for cell in row[1:])]
    return [*lines, ""]


def _rows(part: Part, label: str, before: str) -> list[tuple[str, str, str]]:
    found = []
    for name, inner in part.get("properties", {}).items():
        optional = "" if name in part.get("required", ()) else "Optional. "
        meaning = f"{optional}{escaped(inner.get('description', ''))}".strip()
        found.append((f"``{before}{name}``", _type(inner, label), meaning))
        items = inner.get("items") if isinstance(inner.get("items"), dict) else None
        found += _rows(inner, label, f"{before}{name}.")
        found += _rows(items, label, f"{before}{name}[].") if items else []
    return found


def _type(part: Part, label: str) -> str:
    """The type of a value in words, with links to parts that have a name."""
    if "$ref" in part:
        name = part["$ref"].rpartition("/")[2]
        return f":ref:`{name.replace('_', ' ')} <{label}-{name}>`"
    if "const" in part:
        return f"``{json.dumps(part['const'])}``"
    if "enum" in part:
        return " or ".join(f"``{json.dumps(value)}``" for value in part["enum"])
    for word in ("oneOf", "anyOf"):
        if word in part:
            return " or ".join(_type(choice, label) for choice in part[word])
    if part.get("prefixItems"):
        return f"list of {len(part['prefixItems'])}: {', '.join(_type(entry, label) for entry in part['prefixItems'])}"
    kind = part.get("type")
    if kind == "array" and isinstance(part.get("items"), dict):
        return f"list; each {_type(part['items'], label)}"
    if kind == "object" and isinstance(part.get("additionalProperties"), dict):
        return f"object; each value {_type(part['additionalProperties'], label)}"
    kinds = kind if isinstance(kind, list) else [kind or "anything"]
    return " or ".join({"array": "list", "string": "text"}.get(word, word) for word in kinds)


def _theorems(schema: Part, label: str) -> list[str]:
    """What a certificate holds, theorem by theorem."""
    lines = [".. list-table::", "   :class: keys", "   :header-rows: 1", "   :widths: 18 28 24 30", ""]
    for row in (("``theorem``", "``system.kind``", "``multiplier``", "``proof``"), *_choices(schema, label)):
        lines += [f"   * - {row[0]}", *(f"     - {cell}" for cell in row[1:])]
    return ["Which parts belong together:", "", *lines, ""]


def _choices(schema: Part, label: str) -> list[tuple[str, ...]]:
    rows = []
    for choice in schema["allOf"]:
        asked, then = choice["if"]["properties"], choice["then"]
        of_families = then.get("if", {}).get("properties", {})
        parts = [then["properties"]] if "properties" in then else []
        if of_families:
            parts = [then["else"]["properties"], of_families | then["then"]["properties"]]
        for part in parts:
            if set(asked) == {"theorem"} and "proof" in part:
                named = asked["theorem"]
                system = part.get("system", {}).get("properties", {}).get("kind", {})
                shown = (system, part.get("multiplier"), part.get("proof"))
                theorems = named["enum"] if "enum" in named else [named["const"]]
                cells = (_type(each, label) if each else "" for each in shown)
                rows.append((", ".join(f"``{theorem}``" for theorem in theorems), *cells))
    return rows


def setup(app: Sphinx) -> None:
    """Register the directive."""
    app.add_directive("json-schema", Schema)

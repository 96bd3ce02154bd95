"""The directive ``api``: a summary table of the names it lists, then each of them in full."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.ext.napoleon.docstring import NumpyDocstring
from sphinx.util.docutils import SphinxDirective

from lure_docs.listing import groups, home, kind, listed, resolved


class Api(SphinxDirective):
    """One list of names for the table at the top and for the entries below it."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """The tables, one a group, then a section for each group."""
        try:
            listed = groups(self.content)
            lines = [line for title, names in listed for line in _table(title, names)]
            lines += [line for title, names in listed for line in _entries(title, names)]
        except (LookupError, ValueError) as error:
            raise self.error(str(error)) from error
        source = self.get_source_info()[0]
        return self.parse_text_to_nodes(StringList(lines, source=source), allow_section_headings=True)


def _table(title: str, names: list[str]) -> list[str]:
    listed = [f"   ~{name}" for name in names]
    return [f".. rubric:: {title}", "", ".. autosummary::", "   :nosignatures:", "", *listed, ""]


def _entries(title: str, names: list[str]) -> list[str]:
    lines = ["", title, "-" * len(title), ""]
    for name in names:
        found = resolved(name)
        what = kind(found)
        lines.append(f".. auto{what}:: {name}")
        if inspect.isclass(found):
            lines += _options(found)
        if isinstance(found, Path):
            lines.append("   :no-value:")
        lines.append("")
    return lines


def _options(found: type) -> list[str]:
    """Members with a docstring; values of a nonlinearity or a block; the base that holds what several classes share."""
    options = ["   :members:"]
    call = vars(found).get("__call__")
    if call is not None and call.__doc__:
        options.append("   :special-members: __call__")
    ours = [name for name in map(home, found.__bases__) if name and name.startswith("lure.")]
    if ours and listed().issuperset(ours):
        options.append("   :show-inheritance:")
    return options


def numbered(_app: Sphinx, _what: str, name: str, _found: object, _options: object, lines: list[str]) -> None:
    """Make the numbered references of a docstring unlike those of the others on its page.

    Parameters
    ----------
    name : str
        The object whose docstring it is.
    lines : list of str
        The docstring, changed in place.
    """
    own = {found[1] for line in lines if (found := re.match(r"\s*\.\. \[(\d+)\]", line))}
    for i, line in enumerate(lines):
        lines[i] = re.sub(r"\[(\d+)\](?=_|\s)", lambda n: f"[#{name}-{n[1]}]" if n[1] in own else n[0], line)


def signed(
    _app: Sphinx, what: str, _name: str, found: object, _options: object, signature: str | None, _returned: str | None
) -> tuple[str | None, str | None] | None:
    """What stands behind a name: how a thing is called or made, and what a function gives.

    A class that lists its attributes and has no value by default is made by lure: its parameters are left out.

    Parameters
    ----------
    what : str
        What autodoc calls the object.
    found : object
        The object.
    signature : str or None
        Its parameters, in brackets.
    """
    text = getattr(found, "__doc__", None) or ""
    if getattr(found, "_is_protocol", False):
        return "", None
    if what == "class" and "=" not in (signature or "") and "Attributes\n" in text:
        return "", None
    kind = getattr(found, "__annotations__", {}).get("return") if what in ("function", "method") else None
    named = not isinstance(kind, str) or kind == "None" or re.search(r"^ *(Returns|Yields)\n", text, re.MULTILINE)
    return None if named else (signature, kind)


class Attributes:
    """Docstrings of properties and data, in which napoleon would take what stands before a colon for a type."""

    def __init__(self) -> None:
        self.given: list[str] = []

    def keep(self, _app: Sphinx, _what: str, _name: str, _found: object, _options: object, lines: list[str]) -> None:
        """Remember the docstring as it is."""
        self.given = list(lines)

    def put(  # noqa: PLR0913  (these are what Sphinx gives)
        self, app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]
    ) -> None:
        """Convert it as that of a function, whose sections it may have."""
        if what in ("attribute", "data", "property"):
            lines[:] = NumpyDocstring(self.given, app.config, app, "function", name, found, options).lines()


def setup(app: Sphinx) -> None:
    """Register the directive, and what is done to docstrings."""
    app.add_directive("api", Api)
    attributes = Attributes()
    app.connect("autodoc-process-docstring", attributes.keep, priority=400)  # napoleon's is 500
    app.connect("autodoc-process-docstring", attributes.put, priority=600)
    app.connect("autodoc-process-docstring", numbered, priority=700)
    app.connect("autodoc-process-signature", signed)

"""The directive ``api``: a summary table of the names it lists, and each of them in full.

Up to :data:`MOST` names stand in full below the table; where there are more, each has a page of its own, which is
written into ``docs/reference/api`` before Sphinx reads, and which git ignores.
"""

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

MOST = 4  # names in full on one page
_API = re.compile(r"^\.\. api::\n((?:\n| {3}.*\n)+)", re.MULTILINE)


class Api(SphinxDirective):
    """One list of names for the table at the top and for the entries below it."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """The tables, one a group, then a section for each group."""
        try:
            listed = groups(self.content)
            lines = [line for title, names in listed for line in _table(title, names)]
            if not _apart(listed):
                lines += [line for title, names in listed for line in _entries(title, names)]
        except (LookupError, ValueError) as error:
            raise self.error(str(error)) from error
        source = self.get_source_info()[0]
        return self.parse_text_to_nodes(StringList(lines, source=source), allow_section_headings=True)


def _apart(listed: list[tuple[str, list[str]]]) -> bool:
    return sum(len(names) for _, names in listed) > MOST


def write_pages(app: Sphinx) -> None:
    """Write the pages of single names; one that has not changed keeps its date, one that is not listed goes."""
    folder = Path(app.srcdir) / "reference" / "api"
    folder.mkdir(exist_ok=True)
    written = set[Path]()
    for page in sorted(folder.parent.glob("*.rst")):
        text = page.read_text(encoding="utf-8")
        for found in _API.findall(text + "\n"):
            listed = groups(line.removeprefix("   ") for line in found.splitlines())
            for name in (name for _, names in listed if _apart(listed) for name in names):
                short = name.rpartition(".")[2]
                lines = [
                    ":orphan:",
                    "",
                    short,
                    "=" * len(short),
                    "",
                    f"One of :doc:`../{page.stem}`.",
                    "",
                    *_entry(name),
                ]
                file, text = folder / f"{name}.rst", "\n".join(lines)
                written.add(file)
                if not file.exists() or file.read_text(encoding="utf-8") != text:
                    file.write_text(text, encoding="utf-8")
    for file in set(folder.glob("*.rst")) - written:
        file.unlink()


def _table(title: str, names: list[str]) -> list[str]:
    listed = [f"   ~{name}" for name in names]
    return [f".. rubric:: {title}", "", ".. autosummary::", "   :nosignatures:", "", *listed, ""]


def _entries(title: str, names: list[str]) -> list[str]:
    return ["", title, "-" * len(title), "", *(line for name in names for line in _entry(name))]


def _entry(name: str) -> list[str]:
    found = resolved(name)
    lines = [f".. auto{kind(found)}:: {name}"]
    if inspect.isclass(found):
        lines += _options(found)
    if isinstance(found, Path):
        lines.append("   :no-value:")
    return [*lines, ""]


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
    app.connect("builder-inited", write_pages)
    attributes = Attributes()
    app.connect("autodoc-process-docstring", attributes.keep, priority=400)  # napoleon's is 500
    app.connect("autodoc-process-docstring", attributes.put, priority=600)
    app.connect("autodoc-process-docstring", numbered, priority=700)
    app.connect("autodoc-process-signature", signed)

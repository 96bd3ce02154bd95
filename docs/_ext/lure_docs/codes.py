"""The directive ``inconclusive-codes``: every code of ``lure explain``, with what it says."""

from __future__ import annotations

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from lure_docs.escaping import escaped


class Codes(SphinxDirective):
    """A table of all codes, then a section for each."""

    def run(self) -> list[nodes.Node]:
        """Read off the registry that ``lure explain`` prints."""
        from lure.analysis.certificates.codes import CODES

        lines = [".. list-table::", "   :widths: 15 85", ""]
        for code in CODES:
            lines += [f"   * - :ref:`{code.identifier} <{code.identifier}>`", f"     - {escaped(code.title)}"]
        for code in CODES:
            title = f"{code.identifier}: {escaped(code.title)}"
            lines += ["", f".. _{code.identifier}:", "", title, "-" * len(title), ""]
            lines += [f"**What happened.** {escaped(code.happened)}", ""]
            lines += [f"**What it means.** {escaped(code.means)}", "", "**What to try**", ""]
            lines += [f"- {_attempt(text)}" for text in code.tries]
        return self.parse_text_to_nodes(StringList(lines, source="lure explain"), allow_section_headings=True)


def _attempt(text: str) -> str:
    """A sentence of the explanation, its command, if it ends in one, as code."""
    head, colon, command = text.rpartition(": lure ")
    return f"{escaped(head)}: ``lure {command}``" if colon else escaped(text)


def setup(app: Sphinx) -> None:
    """Register the directive."""
    app.add_directive("inconclusive-codes", Codes)

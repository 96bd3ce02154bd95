"""What a phone needs of a page: tables whose rows can stand as cards, one cell below the other with its heading.

A table of numbers stays one, and scrolls; no number is broken.

The heading of its column goes into each cell as an attribute, which ``_static/site.css`` shows on narrow screens alone;
so it is neither read twice nor found twice by the search.
"""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from docutils import nodes

if TYPE_CHECKING:
    from sphinx.application import Sphinx


def stack(_app: Sphinx, document: nodes.document, _name: str) -> None:
    """Mark each table that has a head, and label its cells from the second column on, where there are three or more."""
    for group in document.findall(nodes.tgroup):
        head = group.next_node(nodes.thead)
        if head is None or any("morecols" in entry or "morerows" in entry for entry in group.findall(nodes.entry)):
            continue
        titles = [entry.astext() for entry in head[-1]]
        cells = [entry for row in group.next_node(nodes.tbody) for entry in row[1:]]
        if len(titles) > 3 and all(re.fullmatch(r"[\d .]*", entry.astext()) for entry in cells):
            group.parent["classes"].append("numbers")
            continue
        group.parent["classes"].append("stacked")
        for row in group.next_node(nodes.tbody) if len(titles) > 2 else ():
            for entry, title in list(zip(row, titles, strict=True))[1:]:
                if title and entry.astext().strip():
                    label = f'<span class="heading" data-heading="{escape(title)}"></span>'
                    entry[0].insert(0, nodes.raw("", label, format="html"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Label the cells of every page."""
    app.connect("doctree-resolved", stack)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

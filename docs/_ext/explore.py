"""The page in the browser as part of the site, and links into it: ``{explore} num=1&den=1,3,2,0&k=5`` is a loop.

What the page needs is fetched once, through npm and pip.  Where it is not at hand the site is built without the page
and without the links, and the log says why.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.util import logging

from lure.analysis.explore import write_page
from lure.analysis.explore.runtime import runtime
from lure.errors import InputError

if TYPE_CHECKING:
    from sphinx.application import Sphinx

FOLDER = "explore"
_LOG = logging.getLogger(__name__)


class explore(nodes.paragraph):
    """A link to the page, with the loop that it opens with."""


class Explore(Directive):
    """``{explore}`` with the address of a loop, and its name as content where a page has several."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """The link, to be written where its page is known."""
        return [explore(state=self.arguments[0], name=" ".join(self.content) or "this loop")]


def link(app: Sphinx, document: nodes.document, name: str) -> None:
    """Put links in the places of the nodes; nothing where there is no page."""
    for node in list(document.findall(explore)):
        here = os.path.dirname(name) or "."
        address = f"{os.path.relpath(f'{FOLDER}/index.html', here)}#{node['state']}"
        text = nodes.reference("", f"Explore {node['name']} in the browser", refuri=address, internal=True)
        node.replace_self(nodes.paragraph("", "", text, classes=["explore"]) if app.config.explore_there else [])


def prepare(app: Sphinx) -> None:
    """See whether the page can be written."""
    try:
        app.config.explore_there = bool(app.config.explore_page and runtime())
    except InputError as refusal:
        app.config.explore_there = False
        _LOG.info("the site has no page to explore loops on: %s", refusal)


def write(app: Sphinx, error: Exception | None) -> None:
    """Write the page into the site."""
    if error is None and app.config.explore_there:
        write_page(Path(app.outdir) / FOLDER)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the setting ``explore_page``: 0 leaves the page and its links out."""
    app.add_config_value("explore_page", default=True, rebuild="env")
    app.add_config_value("explore_there", default=False, rebuild="html")
    app.add_node(explore)
    app.add_directive("explore", Explore)
    app.connect("builder-inited", prepare)
    app.connect("doctree-resolved", link)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""The directive ``lure-help``: what ``lure COMMAND --help`` prints, for one command or for all of them."""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def names() -> list[str]:
    """Every command, in the order of ``lure --help``."""
    import typer

    from lure.analysis.cli.__main__ import app

    return list(getattr(typer.main.get_command(app), "commands"))  # noqa: B009  # not of every command's type


def help_text(*command: str) -> str:
    """What ``lure COMMAND --help`` prints on a terminal of 80 columns.

    Parameters
    ----------
    command : str
        The command; none for the help of ``lure`` itself.
    """
    from lure.analysis.cli import main

    out = io.StringIO()
    with contextlib.redirect_stdout(out), _columns():
        main([*command, "--help"])
    return out.getvalue().rstrip("\n")


@contextlib.contextmanager
def _columns() -> Iterator[None]:
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "80"
    try:
        yield
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before


class Help(SphinxDirective):
    """Without an argument the help of ``lure`` itself; with ``all`` a section for each command."""

    optional_arguments = 1

    def run(self) -> list[nodes.Node]:
        """The help as it is printed."""
        if not self.arguments:
            return [_block()]
        wanted = names() if self.arguments == ["all"] else self.arguments
        return [_section(name) for name in wanted]


def _section(name: str) -> nodes.section:
    title = nodes.title("", f"lure {name}")
    return nodes.section("", title, _block(name), ids=[f"lure-{name}"], names=[f"lure {name}"])


def _block(*command: str) -> nodes.literal_block:
    text = help_text(*command)
    return nodes.literal_block(text, text, language="text", classes=["help"])


def setup(app: Sphinx) -> None:
    """Register the directive."""
    app.add_directive("lure-help", Help)

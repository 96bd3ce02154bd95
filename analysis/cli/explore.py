"""The command ``lure explore``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.options import Quiet, app, refused


@app.command(help=texts.EXPLORE)
def explore(
    system: Annotated[
        str | None,
        typer.Argument(metavar="SYSTEM", help="The loop that the page opens with.", show_default=False),
    ] = None,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where to write.")] = Path("lure-page"),
    quiet: Quiet = False,
) -> None:
    """Write the page."""
    from lure.analysis.explore import write_page
    from lure.files import find_system
    from lure.files.system import LoopSystem

    chosen = None if system is None else find_system(system)
    if chosen is not None and not isinstance(chosen, LoopSystem):
        raise refused(f"{system} is not a loop with one block H; the page opens with such a one, or without a SYSTEM")
    page = write_page(output, chosen)
    if not quiet:
        print(f"The page is {page}; open it in a browser, or put the folder on any web server")

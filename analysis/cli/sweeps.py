"""The command ``lure sweep``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.options import (
    Json,
    Output,
    Quiet,
    Seconds,
    Verbose,
    app,
    option,
)
from lure.errors import InputError

if TYPE_CHECKING:
    from lure.analysis.sweeps.run import Keep


@app.command(help=texts.SWEEP)
def sweep(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="A TOML file; with --report a store.")],
    output: Annotated[Path | None, option("-o --output", "STORE", "The data set; else STUDY with .zarr.")] = None,
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Processes.")] = 1,
    scheduler: Annotated[str | None, option("--scheduler", "ADDRESS", "A Dask scheduler.")] = None,
    certificates: Annotated[
        str, typer.Option("--certificates", metavar="WHICH", help="To keep: none, sample or all.")
    ] = "none",
    report: Annotated[bool, typer.Option("--report", help="Write the page of a store.")] = False,
    points: Annotated[
        bool, typer.Option("--points", help="With --report: a report of each point that it lists.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a page that exists.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Answer a question for every point of a study."""
    if not (find_spec("zarr") and find_spec("xarray")):  # asked, not imported, which takes half a second
        raise InputError("sweeps need Zarr and xarray; install the extra: pip install 'lure[sweep]'")
    if not study.name:
        raise InputError(f"{study} is a folder; give the TOML file of a study, or --report for the page of a store")
    if report:
        from lure.analysis.output import write_new
        from lure.analysis.sweeps.page import page_of

        target = output or study.with_suffix(".html")
        write_new(target, page_of(study, _reports_beside(target) if points else None), force=force)
        if not quiet:
            print(f"The page is {target}")
        return 0
    from lure.analysis.sweeps.run import sweep as run

    target = output or study.with_suffix(".zarr")
    out = Output(as_json=as_json, quiet=quiet, verbose=verbose)
    with out.progress() as tell:
        found = run(
            study,
            target,
            workers=workers,
            scheduler=scheduler,
            certificates=cast("Keep", certificates),
            seconds=seconds,
            progress=tell,
        )
    out.results(found.to_dict(), [str(found)])
    if not as_json and not quiet:
        print(f'Open it: xarray.open_zarr("{target}"); a page: lure sweep {target} --report')
    return 2 if found.failed == found.answers else 0  # nothing is said of any point


def _reports_beside(page: Path) -> Callable[[int, str, Sequence[str]], str]:
    """Writes the report of a point into a folder beside the page, and gives the link to it."""
    from lure.analysis.report.reporting import page_of, report_on
    from lure.errors import AssumptionError, InputError
    from lure.files import find_system

    folder = page.with_name(f"{page.stem}-points")

    def written(number: int, system: str, settings: Sequence[str]) -> str:
        """The report of one point."""
        target = folder / str(number)
        try:
            report_on(find_system(system, settings), output=target)
        except (InputError, AssumptionError):  # the point failed, and its row says so
            return ""
        return page_of(target).relative_to(page.parent).as_posix()

    return written

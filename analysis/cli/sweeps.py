"""The command ``lure sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.options import (
    Json,
    Quiet,
    Seconds,
    Verbose,
    app,
    check_seconds,
    option,
    print_json,
    print_wrapped,
    refused,
)
from lure.analysis.cli.progress import progress

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
    force: Annotated[bool, typer.Option("--force", help="Replace a page that exists.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Answer a question for every point of a study."""
    check_seconds(seconds)
    try:
        import xarray  # noqa: F401  (said in one sentence where it is missing)
        import zarr  # noqa: F401
    except ImportError:
        raise refused("sweeps need Zarr and xarray; install the extra: pip install 'lure[sweep]'") from None
    if report:
        from lure.analysis.output import write_new
        from lure.analysis.sweeps.page import page_of

        target = output or study.with_suffix(".html")
        write_new(target, page_of(study), force=force)
        if not quiet:
            print(f"The page is {target}")
        return 0
    from lure.analysis.sweeps.run import sweep as run

    target = output or study.with_suffix(".zarr")
    with progress(quiet=quiet, verbose=verbose) as tell:
        found = run(
            study,
            target,
            workers=workers,
            scheduler=scheduler,
            certificates=cast("Keep", certificates),
            seconds=seconds,
            progress=tell,
        )
    if as_json:
        print_json(found.to_dict())
    else:
        print_wrapped([str(found)])
        if not quiet:
            print(f'Open it: xarray.open_zarr("{target}"); a page: lure sweep {target} --report')
    return 0

"""The command ``lure simulate``."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from analysis.cli.certificates import app as app
from analysis.cli.commands import Json, Quiet, Settings
from analysis.cli.refused import refused

if TYPE_CHECKING:
    from analysis.runs import Performed, Request
    from lure.systems import RodSystem

HELP = """Follow one motion of a rod, and write or draw it.

\b
Examples:
  lure simulate paper-rod --until 0.01
  lure simulate paper-rod --until 10 --method exact -o run.nc
  lure simulate rod.toml --set rod.gap=5e-5 --plot run.svg
  lure simulate paper-rod --method scheme --cells 200 --plot scheme.png
  lure simulate paper-rod --method galerkin --space P2 --order 101
  lure simulate rod.toml --rigid --animation run.gif --space-time run.png
  lure simulate rod.toml --span 0.678 0.681 --animation run.mp4

\b
Methods:
  exact     the rod itself along its characteristics, to rounding
  scheme    the upwind scheme of --cells N, without error in time
  galerkin  the weak form in --space P1, P2 or cosine of --order m
  LSODA, RK45, DOP853, Radau, BDF, CVODE
            a general integrator on the scheme of --cells N
Only `exact` is a motion of the rod; every result says what moved.

\b
A file run.nc is netCDF 4 (needs lure[netcdf]); figures are SVG or PNG;
animations GIF, MP4 (needs ffmpeg) or, without a suffix, a folder of PNG.
All appear together when all is done; what exists is kept without --replace.

\b
Exit status: 0 done, 2 bad input, 1 a bug in lure, 130 interrupted.
"""


@app.command(help=HELP)
def simulate(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file.")],
    until: Annotated[
        float | None,
        typer.Option("--until", metavar="S", help="End of the motion; else that of the system.", show_default=False),
    ] = None,
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="How; see above.")] = "exact",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write netCDF.", show_default=False)
    ] = None,
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Instants kept, evenly spaced.")] = 2001,
    fields: Annotated[
        int, typer.Option("--fields", metavar="NX", help="Keep v, u_x, u at NX places, too.", show_default=False)
    ] = 0,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the motion of the end.", show_default=False)
    ] = None,
    space_time: Annotated[
        Path | None, typer.Option("--space-time", metavar="FILE", help="Draw x against t.", show_default=False)
    ] = None,
    animation: Annotated[
        Path | None, typer.Option("--animation", metavar="FILE", help="Draw the rod moving.", show_default=False)
    ] = None,
    span: Annotated[
        tuple[float, float] | None,
        typer.Option("--span", metavar="A B", help="Stretch of time to draw [s].", show_default=False),
    ] = None,
    boundary: Annotated[
        str, typer.Option("--boundary", metavar="NAME", help="End x = 0: dashpot, free, matched or clamped.")
    ] = "dashpot",
    end_damping: Annotated[
        float, typer.Option("--end-damping", metavar="K", help="Dashpot at x = L [N s/m].", show_default=False)
    ] = 0.0,
    rigid: Annotated[bool, typer.Option("--rigid", help="A rigid obstacle.")] = False,
    cells: Annotated[
        int | None,
        typer.Option("--cells", metavar="N", help="Cells of the scheme; else the system's.", show_default=False),
    ] = None,
    space: Annotated[
        str | None, typer.Option("--space", metavar="NAME", help="P1, P2 or cosine; else P1.", show_default=False)
    ] = None,
    order: Annotated[
        int | None,
        typer.Option("--order", metavar="M", help="Dimension of the Galerkin space; else 51.", show_default=False),
    ] = None,
    set_: Settings = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace files that exist.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compute a motion, print a summary, write and draw what was asked for."""
    chosen = _rod_system(system, set_ or [])
    from analysis.runs import Request

    request = Request(
        until=chosen.until if until is None else until,
        method=method,
        samples=samples,
        places=fields,
        boundary=boundary,
        end_damping=end_damping,
        rigid=rigid,
        cells=cells,
        space=space,
        order=order,
    )
    results = {"output": output, "plot": plot, "space-time": space_time, "animation": animation}
    targets = {kind: path for kind, path in results.items() if path is not None}
    _check(targets, (request, chosen), span, replace=replace)

    from analysis.cli.progress import progress
    from analysis.runs.drawing import Wanted, write_results
    from analysis.runs.request import for_drawing, perform
    from analysis.runs.writing import written

    drawn = bool({"space-time", "animation"} & set(targets))
    with progress(quiet=quiet) as tell:
        done = perform(chosen, for_drawing(request, chosen) if drawn else request, progress=tell)
        with written(list(targets.values()), replace=replace) as places:
            named = {kind: places[path] for kind, path in targets.items()}
            wanted = Wanted(places=named, title=f"{chosen.name}: {chosen.title}", span=span, fields=fields > 0)
            write_results(done, wanted, tell=tell)
    _say(done, chosen, targets, as_json=as_json, quiet=quiet)


def _rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.system_file import find_system
    from lure.systems import RodSystem

    chosen = find_system(reference, settings)
    if not isinstance(chosen, RodSystem):
        raise refused(
            f"{chosen.name} is a Lur'e loop, and lure simulate follows rods; give a rod such as paper-rod, or a TOML "
            "file with a table [rod]"
        )
    return chosen


def _check(
    targets: dict[str, Path], asked: tuple[Request, RodSystem], span: tuple[float, float] | None, *, replace: bool
) -> None:
    """Refuse what cannot be written or drawn before anything is computed."""
    from analysis.runs.drawing import check_drawings
    from analysis.runs.writing import check_netcdf, check_targets

    request, system = asked
    check_drawings(targets, request, system.rod.travel_time, span)
    check_targets(list(targets.values()), replace=replace)
    if "output" in targets:
        check_netcdf()


def _say(done: Performed, system: RodSystem, targets: dict[str, Path], *, as_json: bool, quiet: bool) -> None:
    from analysis.cli.wrapping import wrapped
    from analysis.runs.summary import summary_dict, summary_lines

    if as_json:
        print(json.dumps(summary_dict(done.run, system.name), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        print("\n".join(line for text in summary_lines(done.run, system.name) for line in wrapped(text, indent=2)))
    if targets and not quiet:
        names = " and ".join(map(str, targets.values()))
        print(("" if as_json else "\n") + f"Written: {names}", file=sys.stderr if as_json else sys.stdout)

"""The commands about long runs: ``response``, ``bifurcation``, ``basin``."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from lure.analysis.cli.certificates import app as app
from lure.analysis.cli.commands import Json, Quiet, Settings
from lure.analysis.cli.commands import app as app_responding
from lure.analysis.cli.progress import refused
from lure.analysis.cli.texts import AS_PRINTED, BASIN, BIFURCATION, COMPARE, RESPONSE

if TYPE_CHECKING:
    from lure.analysis.plots import Draw
    from lure.analysis.rod.comparison import Comparison
    from lure.analysis.rod.plots.comparison import FileKind
    from lure.analysis.rod.response import Basin, Bifurcation, Plan, Response
    from lure.analysis.rod.response.sweeping import Order
    from lure.analysis.rod.runs import Performed, Request
    from lure.rod.scenario import Scenario
    from lure.rod.systems import RodSystem

# The command ``lure compare``.

KINDS = ("svg", "png", "pdf")
NONE = "none"


@app.command(help=COMPARE)
def compare(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file with one.")
    ] = "paper-rod",
    until: Annotated[
        float | None,
        typer.Option("--until", metavar="S", help="End of the motion; else that of the system.", show_default=False),
    ] = None,
    cells: Annotated[
        str, typer.Option("--cells", metavar="N,N,..", help="Cells of the scheme, or none.")
    ] = "10,50,200",
    galerkin: Annotated[
        str, typer.Option("--galerkin", metavar="SPACE:M,..", help="Galerkin spaces P1, P2, cosine, or none.")
    ] = "P1:51,P2:51,cosine:50",
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="What integrates the scheme.")] = "exact",
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Instants compared, evenly spaced.")] = 2001,
    plot: Annotated[
        Path | None,
        typer.Option("--plot", metavar="FILE", help="Draw all of them: .svg, .png or .pdf.", show_default=False),
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")] = False,
    set_: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the system; repeatable."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare, print the table, and draw it where asked for."""
    sizes, spaces = _cells(cells), _spaces(galerkin)
    chosen = _rod_system(system, set_ or [])
    kind = _checked_plot(plot, replace=replace)
    from lure.analysis.cli.progress import progress
    from lure.analysis.rod.comparison import SchemeMethod
    from lure.analysis.rod.comparison import compare as run

    with progress(quiet=quiet) as tell:
        found = run(
            chosen.rod,
            chosen.scenario,
            chosen.until if until is None else until,
            cells=sizes,
            galerkin=cast("Any", spaces),  # names are checked where the spaces are made
            method=cast("SchemeMethod", method),
            samples=samples,
            progress=tell,
        )
        if plot is not None and kind is not None:
            _draw(found, plot, kind, replace=replace)
    print(json.dumps(found.to_dict(), indent=2, ensure_ascii=False, allow_nan=False) if as_json else f"{found}")
    if plot is not None and not quiet:
        print(("" if as_json else "\n") + f"Written: {plot}", file=sys.stderr if as_json else sys.stdout)


def _cells(text: str) -> list[int]:
    if text.strip() == NONE:
        return []
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise refused(f"--cells is {text!r:.60}; give whole numbers such as 10,50,200, or none") from None


def _spaces(text: str) -> list[tuple[str, int]]:
    if text.strip() == NONE:
        return []
    found = []
    for part in text.split(","):
        name, _, order = part.strip().partition(":")
        try:
            found.append((name, int(order)))
        except ValueError:
            raise refused(f"--galerkin is {text!r:.60}; give pairs such as P1:51,cosine:50, or none") from None
    return found


def _rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.files import find_system
    from lure.rod.systems import RodSystem

    chosen = find_system(reference, settings)
    if not isinstance(chosen, RodSystem):
        raise refused(
            f"{chosen.name} is a Lur'e loop, and lure compare moves rods; give a rod such as paper-rod, or a TOML file "
            "with a table [rod]"
        )
    if chosen.form != "corrected":
        raise refused(
            f"{chosen.name} has the form {chosen.form}, which is no scheme of its rod; give it as "
            "--set discretisation.form=corrected, with the force divided by c N/L"
        )
    return chosen


def _checked_plot(plot: Path | None, *, replace: bool) -> FileKind | None:
    """The kind of figure; a place that cannot be written to is refused before anything is computed."""
    if plot is None:
        return None
    kind = plot.suffix.lower().removeprefix(".")
    if kind not in KINDS:
        raise refused(f"--plot is {str(plot)!r:.80}; give a name that ends in .svg, .png or .pdf")
    from lure.analysis.rod.runs.drawing import check_targets

    check_targets([plot], replace=replace)
    return cast("FileKind", kind)


def _draw(found: Comparison, plot: Path, kind: FileKind, *, replace: bool) -> None:
    from lure.analysis.rod.plots.comparison import comparison_file
    from lure.analysis.rod.runs.drawing import written

    picture = comparison_file(found, kind)
    with written([plot], replace=replace) as places:
        places[plot].write_bytes(picture)


# The command ``lure simulate``.

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
    chosen = _simulating_rod_system(system, set_ or [])
    from lure.analysis.rod.runs import Request

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

    from lure.analysis.cli.progress import progress
    from lure.analysis.rod.runs.drawing import Wanted, write_results, written
    from lure.analysis.rod.runs.request import for_drawing, perform

    drawn = bool({"space-time", "animation"} & set(targets))
    with progress(quiet=quiet) as tell:
        done = perform(chosen, for_drawing(request, chosen) if drawn else request, progress=tell)
        with written(list(targets.values()), replace=replace) as places:
            named = {kind: places[path] for kind, path in targets.items()}
            wanted = Wanted(places=named, title=f"{chosen.name}: {chosen.title}", span=span, fields=fields > 0)
            write_results(done, wanted, tell=tell)
    _say(done, chosen, targets, as_json=as_json, quiet=quiet)


def _simulating_rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.files import find_system
    from lure.rod.systems import RodSystem

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
    from lure.analysis.rod.runs.drawing import check_drawings, check_netcdf, check_targets

    request, system = asked
    check_drawings(targets, request, system.rod.travel_time, span)
    check_targets(list(targets.values()), replace=replace)
    if "output" in targets:
        check_netcdf()


def _say(done: Performed, system: RodSystem, targets: dict[str, Path], *, as_json: bool, quiet: bool) -> None:
    from lure.analysis.cli.texts import wrapped
    from lure.analysis.rod.runs.sampled import summary_dict, summary_lines

    if as_json:
        print(json.dumps(summary_dict(done.run, system.name), indent=2, ensure_ascii=False, allow_nan=False))
    else:
        print("\n".join(line for text in summary_lines(done.run, system.name) for line in wrapped(text, indent=2)))
    if targets and not quiet:
        names = " and ".join(map(str, targets.values()))
        print(("" if as_json else "\n") + f"Written: {names}", file=sys.stderr if as_json else sys.stdout)


System = Annotated[str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file.")]
Force = Annotated[
    str | None,
    typer.Option("--force", metavar="EXPR", help="Force g(t) [N]; else that of the system.", show_default=False),
]
Settle = Annotated[
    float | None,
    typer.Option("--settle", metavar="S", help="Time before the watch; else 12 time constants.", show_default=False),
]
Periods = Annotated[int, typer.Option("--periods", metavar="N", help="Periods of the force watched.")]
Period = Annotated[
    float | None,
    typer.Option("--period", metavar="S", help="Period of the force, if the formula hides it.", show_default=False),
]
Samples = Annotated[int, typer.Option("--samples", metavar="N", help="Samples in a period.")]
Tolerance = Annotated[float, typer.Option("--tolerance", metavar="R", help="How closely a motion must repeat.")]
Rigid = Annotated[bool, typer.Option("--rigid", help="A rigid obstacle.")]
Plot = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw it: .svg or .png.", show_default=False)]
Replace = Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")]
Grid = tuple[float, float, int]
_OPEN = 10
_INTERRUPTED = 130


@app_responding.command(help=RESPONSE)
def response(
    system: System,
    force: Force = None,
    settle: Settle = None,
    periods: Periods = 64,
    period: Period = None,
    samples: Samples = 64,
    tolerance: Tolerance = 1e-6,
    separation: Annotated[
        bool, typer.Option("--separation", help="Follow a second motion nearby, at twice the cost.")
    ] = False,
    rigid: Rigid = False,
    set_: Settings = None,
    plot: Plot = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Watch the response of a rod."""
    chosen = _responding_rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    from lure.analysis.cli.progress import progress
    from lure.analysis.rod.response import response as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=separation)
    scenario = _scenario(chosen, force)
    with progress(quiet=quiet) as tell:
        found = run(chosen.rod, scenario, plan=plan, progress=tell)
    from lure.analysis.rod.plots.response import plot_response

    _responding_say(found, as_json=as_json, note=_note(chosen, force))
    _responding_draw(plot, partial(plot_response, found), (9.6, 7.0), quiet=quiet, as_json=as_json, replace=replace)


@app_responding.command(help=BIFURCATION)
def bifurcation(
    system: System,
    parameter: Annotated[str, typer.Option("--parameter", metavar="NAME", help="What is varied.")],
    first: Annotated[float, typer.Option("--from", metavar="A", help="Its first value, in SI units.")],
    last: Annotated[float, typer.Option("--to", metavar="B", help="Its last value.")],
    count: Annotated[int, typer.Option("--count", metavar="N", help="How many values, evenly spaced.")] = 50,
    force: Force = None,
    way: Annotated[str, typer.Option("--sweep", metavar="WAY", help="separate, up or down; see above.")] = "separate",
    settle: Settle = None,
    periods: Periods = 64,
    period: Period = None,
    samples: Samples = 16,
    tolerance: Tolerance = 1e-6,
    rigid: Rigid = False,
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Processes.")] = 1,
    set_: Settings = None,
    plot: Plot = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Watch the response at several values of a parameter; 130 if it was interrupted."""
    if way not in ("separate", "up", "down"):
        raise refused(f"--sweep is {way!r:.40}; choose from separate, up, down")
    chosen = _responding_rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    values = _grid((first, last, count), "--count")
    from lure.analysis.cli.progress import progress
    from lure.analysis.rod.response import Sweep
    from lure.analysis.rod.response import bifurcation as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=False)
    text = str(chosen.scenario.force) if force is None else force
    with progress(quiet=quiet) as tell:
        sweep = Sweep(plan=plan, order=cast("Order", way), start=chosen.scenario, workers=workers, progress=tell)
        found = run(chosen.rod, text, parameter, values, sweep=sweep)
    from lure.analysis.rod.plots.response import plot_bifurcation

    _responding_say(found, as_json=as_json, note=_note(chosen, force))
    if found.points:
        _responding_draw(
            plot, partial(plot_bifurcation, found), (6.6, 4.4), quiet=quiet, as_json=as_json, replace=replace
        )
    return 0 if found.complete else _INTERRUPTED


@app_responding.command(help=BASIN)
def basin(
    system: System,
    offset: Annotated[
        Grid,
        typer.Option("--offset", metavar="A B N", help="Displacements added [m]: N from A to B.", show_default=False),
    ] = (0.0, 0.0, 1),
    velocity: Annotated[
        Grid,
        typer.Option("--velocity", metavar="A B N", help="Velocities added [m/s]: N from A to B.", show_default=False),
    ] = (0.0, 0.0, 1),
    set_: Settings = None,
    plot: Plot = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Find the resting places; 10 if one is not known, 130 if it was interrupted."""
    chosen = _responding_rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    offsets, velocities = _grid(offset, "--offset"), _grid(velocity, "--velocity")
    from lure.analysis.cli.progress import progress
    from lure.analysis.rod.response import basin as run

    with progress(quiet=quiet) as tell:
        found = run(chosen.rod, offsets, velocities, start=chosen.scenario, progress=tell)
    from lure.analysis.rod.plots.response import plot_basin

    _responding_say(found, as_json=as_json)
    if (found.impacts >= 0).any():
        _responding_draw(plot, partial(plot_basin, found), (5.6, 4.0), quiet=quiet, as_json=as_json, replace=replace)
    if not found.complete:
        return _INTERRUPTED
    return 0 if found.known.all() else _OPEN


def _responding_rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.files import find_system
    from lure.rod.systems import RodSystem

    chosen = find_system(reference, settings)
    if not isinstance(chosen, RodSystem):
        raise refused(f"{chosen.name} is a Lur'e loop; give a rod such as paper-rod, or a TOML file with a table [rod]")
    return chosen


def _scenario(system: RodSystem, force: str | None) -> Scenario:
    if force is None:
        return system.scenario
    from dataclasses import replace

    from lure.expressions import Expression

    return replace(system.scenario, force=Expression.parse(force, variables=("t",), field="--force"))


def _plan(
    times: tuple[float | None, float | None, float], counts: tuple[int, int], *, rigid: bool, separation: bool
) -> Plan:
    from lure.analysis.rod.response import Plan
    from lure.rod.motion import Boundary

    settle, period, tolerance = times
    run, samples = counts
    return Plan(
        settle=settle,
        run=run,
        period=period,
        samples=samples,
        tolerance=tolerance,
        separation=separation,
        boundary=Boundary(rigid=rigid),
    )


def _grid(asked: Grid, name: str) -> list[float]:
    import numpy as np

    first, last, count = asked
    if not 1 <= count <= 100_000:
        raise refused(f"{name} asks for {count} values; give 1 to 100000")
    values: list[float] = np.linspace(first, last, count).tolist()
    return values


def _check_figure(plot: Path | None, *, replace: bool) -> None:
    """Refuse a figure that cannot be written before anything is computed."""
    if plot is None:
        return
    if plot.suffix.lower() not in (".svg", ".png"):
        raise refused(f"--plot is {str(plot)!r}; give a name that ends in .svg or .png")
    from lure.analysis.rod.runs.drawing import check_targets

    check_targets([plot], replace=replace)


def _note(system: RodSystem, force: str | None) -> str:
    """What is to be said of the force of a system whose scheme is as printed; a force on the command line is plain."""
    return AS_PRINTED if system.form == "as-printed" and force is None else ""


def _responding_say(found: Response | Bifurcation | Basin, *, as_json: bool, note: str = "") -> None:
    """Print a result as JSON or in lines of 80 columns."""
    if as_json:
        said = found.to_dict() | ({"note": note.removeprefix("Note: ")} if note else {})
        print(json.dumps(said, indent=2, ensure_ascii=False, allow_nan=False))
        return
    from lure.analysis.cli.texts import wrapped

    lines = [*str(found).split("\n"), *([note] if note else [])]
    print("\n".join(line for text in lines for line in wrapped(text, indent=2)))


def _responding_draw(
    plot: Path | None, draw: Draw, size: tuple[float, float], *, quiet: bool, as_json: bool, replace: bool
) -> None:
    if plot is None:
        return
    from lure.analysis.plots import render
    from lure.analysis.rod.runs.drawing import written

    picture = render(draw, name=plot.stem, size=size)
    with written([plot], replace=replace) as places:
        if plot.suffix.lower() == ".svg":
            places[plot].write_text(picture.svg, encoding="utf-8")
        else:
            places[plot].write_bytes(picture.png)
    if not quiet:
        print(("" if as_json else "\n") + f"Written: {plot}", file=sys.stderr if as_json else sys.stdout)

"""The commands that follow rods: ``compare``, ``simulate``, ``response``, ``bifurcation``, ``basin``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from lure.analysis.cli import texts
from lure.analysis.cli.options import (
    Figure,
    Json,
    Output,
    Quiet,
    Replace,
    Rigid,
    Settings,
    app,
    assembly_named,
    check_figure,
    option,
    print_json,
    rod_named,
)
from lure.errors import InputError

if TYPE_CHECKING:
    from lure.analysis.rod.plots.comparison import FileKind
    from lure.analysis.rod.response import Basin, Bifurcation, Plan, Response
    from lure.analysis.rod.response.sweeping import Order
    from lure.analysis.rod.runs import Request
    from lure.rod.assembly import RodAssembly
    from lure.rod.scenario import Scenario
    from lure.rod.systems import RodSystem

NONE = "none"
System = Annotated[str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file.")]
Until = Annotated[float | None, option("--until", "S", "End of the motion; else that of the system.")]


@app.command(help=texts.COMPARE)
def compare(
    system: Annotated[
        str, typer.Argument(metavar="SYSTEM", help="A built-in rod or a TOML file with one.")
    ] = "paper-rod",
    until: Until = None,
    cells: Annotated[
        str, typer.Option("--cells", metavar="N,N,..", help="Cells of the scheme, or none.")
    ] = "10,50,200",
    galerkin: Annotated[
        str, typer.Option("--galerkin", metavar="SPACE:M,..", help="Galerkin spaces P1, P2, cosine, or none.")
    ] = "P1:51,P2:51,cosine:50",
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="What integrates the scheme.")] = "exact",
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Instants compared, evenly spaced.")] = 2001,
    plot: Annotated[Path | None, option("--plot", "FILE", "Draw all of them: .svg, .png or .pdf.")] = None,
    replace: Replace = False,
    set_: Settings = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare, print the table, and draw it where asked for."""
    sizes, spaces = _cells(cells), _spaces(galerkin)
    chosen = rod_named(system, set_, doing=", and lure compare moves rods")
    if chosen.form != "corrected":
        raise InputError(
            f"{chosen.name} has the form {chosen.form}, which is no scheme of its rod; give it as "
            "--set discretisation.form=corrected, with the force divided by c N/L"
        )
    check_figure(plot, replace=replace, kinds=(".svg", ".png", ".pdf"))
    from lure.analysis.rod.comparison import SchemeMethod
    from lure.analysis.rod.comparison import compare as run

    out = Output(as_json=as_json, quiet=quiet)
    with out.progress() as tell:
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
        if plot is not None:
            from lure.analysis.output import written
            from lure.analysis.rod.plots.comparison import comparison_file

            picture = comparison_file(found, cast("FileKind", plot.suffix.lower()[1:]))
            with written([plot], replace=replace) as places:
                places[plot].write_bytes(picture)
    if as_json:
        print_json(found.to_dict())
    else:
        print(found)
    if plot is not None:
        out.note(f"Written: {plot}")


def _cells(text: str) -> list[int]:
    if text.strip() == NONE:
        return []
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--cells is {text!r:.60}; give whole numbers such as 10,50,200, or none") from None


def _spaces(text: str) -> list[tuple[str, int]]:
    if text.strip() == NONE:
        return []
    found = []
    for part in text.split(","):
        name, _, order = part.strip().partition(":")
        try:
            found.append((name, int(order)))
        except ValueError:
            raise InputError(f"--galerkin is {text!r:.60}; give pairs such as P1:51,cosine:50, or none") from None
    return found


@app.command(help=texts.SIMULATE)
def simulate(
    system: System,
    until: Until = None,
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="How; see above.")] = "exact",
    output: Annotated[Path | None, option("--output -o", "FILE", "Write netCDF.")] = None,
    samples: Annotated[int, typer.Option("--samples", metavar="N", help="Instants kept, evenly spaced.")] = 2001,
    fields: Annotated[int, option("--fields", "NX", "Keep v, u_x, u at NX places, too.")] = 0,
    plot: Annotated[Path | None, option("--plot", "FILE", "Draw the motion of the end.")] = None,
    space_time: Annotated[Path | None, option("--space-time", "FILE", "Draw x against t.")] = None,
    animation: Annotated[Path | None, option("--animation", "FILE", "Draw the rod moving.")] = None,
    span: Annotated[tuple[float, float] | None, option("--span", "A B", "Stretch of time to draw [s].")] = None,
    boundary: Annotated[
        str, typer.Option("--boundary", metavar="NAME", help="End x = 0: dashpot, free, matched or clamped.")
    ] = "dashpot",
    end_damping: Annotated[float, option("--end-damping", "K", "Dashpot at x = L [N s/m].")] = 0.0,
    rigid: Rigid = False,
    cells: Annotated[int | None, option("--cells", "N", "Cells of the scheme; else the system's.")] = None,
    space: Annotated[str | None, option("--space", "NAME", "P1, P2 or cosine; else P1.")] = None,
    order: Annotated[int | None, option("--order", "M", "Dimension of the Galerkin space; else 51.")] = None,
    set_: Settings = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace files that exist.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compute a motion, print a summary, write and draw what was asked for."""
    out = Output(as_json=as_json, quiet=quiet, replace=replace)
    several = assembly_named(system, set_)
    if several is not None:
        plain = (method, fields, boundary, end_damping, rigid, cells, space, order, space_time, animation, span)
        if plain != ("exact", 0, "dashpot", 0.0, False, None, None, None, None, None, None):
            raise InputError(
                f"{several.words} have one motion, exact, with the options --until, --samples, --output and --plot; "
                "leave out the others, which are for one rod"
            )
        results = {"output": output, "plot": plot}
        _simulate_several(several, until, results, samples, out)
        return
    chosen = rod_named(system, set_, doing=", and lure simulate follows rods")
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
    _perform((request, chosen), targets, span, out)


def _simulate_several(
    rods: RodAssembly,
    until: float | None,
    results: dict[str, Path | None],
    samples: int,
    out: Output,
) -> None:
    """Follow rods with several contacts, write and draw what was asked for, and say what it showed."""
    if not rods.scenarios:
        raise InputError("nothing moves: give a [[rod]] u0, u1 or g")
    targets = {kind: path for kind, path in results.items() if path is not None}
    check_figure(targets.get("plot"), replace=out.replace)
    from lure.analysis.output import check_targets, written
    from lure.analysis.rod.assembly import motion_sentences
    from lure.analysis.rod.runs.drawing import check_netcdf, check_netcdf_name, write_dataset
    from lure.rod.assembly_motion import assembly_motion

    if "output" in targets:
        check_netcdf_name(targets["output"])
    check_targets(list(targets.values()), replace=out.replace)
    if "output" in targets:
        check_netcdf()
    with out.progress() as tell:
        if tell:
            tell("the motion of the rods", 0.0)
        motion = assembly_motion(rods, until=until)
        sampled = motion.sampled(samples)
    if "output" in targets:
        with written([targets["output"]], replace=out.replace) as places:
            write_dataset(sampled.to_xarray(), places[targets["output"]])
    from lure.analysis.rod.plots import plot_assembly_contacts

    out.draw(targets.get("plot"), partial(plot_assembly_contacts, motion), (6.6, 4.4))
    out.results(motion.to_dict(), [f"{text[0].upper()}{text[1:]}." for text in motion_sentences(motion)])
    if targets:
        out.note(f"Written: {' and '.join(map(str, targets.values()))}")


def _check(
    targets: dict[str, Path], asked: tuple[Request, RodSystem], span: tuple[float, float] | None, *, replace: bool
) -> None:
    """Refuse what cannot be written or drawn before anything is computed."""
    from lure.analysis.output import check_targets
    from lure.analysis.rod.runs.drawing import check_drawings, check_netcdf

    request, system = asked
    check_drawings(targets, request, system.rod.travel_time, span)
    check_targets(list(targets.values()), replace=replace)
    if "output" in targets:
        check_netcdf()


def _perform(
    asked: tuple[Request, RodSystem],
    targets: dict[str, Path],
    span: tuple[float, float] | None,
    out: Output,
) -> None:
    """Compute the motion, write and draw it, and say what it is."""
    from lure.analysis.output import written
    from lure.analysis.rod.runs.drawing import Wanted, write_results
    from lure.analysis.rod.runs.request import for_drawing, perform
    from lure.analysis.rod.runs.sampled import summary_dict, summary_lines

    request, system = asked
    drawn = bool({"space-time", "animation"} & set(targets))
    with out.progress() as tell:
        done = perform(system, for_drawing(request, system) if drawn else request, progress=tell)
        with written(list(targets.values()), replace=out.replace) as places:
            named = {kind: places[path] for kind, path in targets.items()}
            wanted = Wanted(places=named, title=f"{system.name}: {system.title}", span=span, fields=request.places > 0)
            write_results(done, wanted, tell=tell)
    out.results(summary_dict(done.run, system.name), summary_lines(done.run, system.name))
    if targets:
        out.note(f"Written: {' and '.join(map(str, targets.values()))}")


Force = Annotated[str | None, option("--force", "EXPR", "Force g(t) [N]; else that of the system.")]
Settle = Annotated[float | None, option("--settle", "S", "Time before the watch; else 12 time constants.")]
Periods = Annotated[int, typer.Option("--periods", metavar="N", help="Periods of the force watched.")]
Period = Annotated[float | None, option("--period", "S", "Period of the force, if the formula hides it.")]
Samples = Annotated[int, typer.Option("--samples", metavar="N", help="Samples in a period.")]
Tolerance = Annotated[float, typer.Option("--tolerance", metavar="R", help="How closely a motion must repeat.")]
Grid = tuple[float, float, int]
_OPEN = 10
_INTERRUPTED = 130


@app.command(help=texts.RESPONSE)
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
    plot: Figure = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Watch the response of a rod."""
    chosen = rod_named(system, set_)
    check_figure(plot, replace=replace)
    from lure.analysis.rod.response import response as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=separation)
    scenario = _scenario(chosen, force)
    out = Output(as_json=as_json, quiet=quiet, replace=replace)
    with out.progress() as tell:
        found = run(chosen.rod, scenario, plan=plan, progress=tell)
    _say(found, out, _note(chosen, force))
    out.figure(plot, found.plot, (9.6, 7.0))


@app.command(help=texts.BIFURCATION)
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
    plot: Figure = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Watch the response at several values of a parameter; 130 if it was interrupted."""
    if way not in ("separate", "up", "down"):
        raise InputError(f"--sweep is {way!r:.40}; choose from separate, up, down")
    chosen = rod_named(system, set_)
    check_figure(plot, replace=replace)
    values = _grid((first, last, count), "--count")
    from lure.analysis.rod.response import Sweep
    from lure.analysis.rod.response import bifurcation as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=False)
    text = str(chosen.scenario.force) if force is None else force
    out = Output(as_json=as_json, quiet=quiet, replace=replace)
    with out.progress() as tell:
        sweep = Sweep(plan=plan, order=cast("Order", way), start=chosen.scenario, workers=workers, progress=tell)
        found = run(chosen.rod, text, parameter, values, sweep=sweep)
    _say(found, out, _note(chosen, force))
    if found.points:
        out.figure(plot, found.plot, (6.6, 4.4))
    return 0 if found.complete else _INTERRUPTED


@app.command(help=texts.BASIN)
def basin(
    system: System,
    offset: Annotated[Grid, option("--offset", "A B N", "Displacements added [m]: N from A to B.")] = (0.0, 0.0, 1),
    velocity: Annotated[Grid, option("--velocity", "A B N", "Velocities added [m/s]: N from A to B.")] = (0.0, 0.0, 1),
    set_: Settings = None,
    plot: Figure = None,
    replace: Replace = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Find the resting places; 10 if one is not known, 130 if it was interrupted."""
    chosen = rod_named(system, set_)
    check_figure(plot, replace=replace)
    offsets, velocities = _grid(offset, "--offset"), _grid(velocity, "--velocity")
    from lure.analysis.rod.response import basin as run

    out = Output(as_json=as_json, quiet=quiet, replace=replace)
    with out.progress() as tell:
        found = run(chosen.rod, offsets, velocities, start=chosen.scenario, progress=tell)
    _say(found, out)
    if (found.impacts >= 0).any():
        out.figure(plot, found.plot, (5.6, 4.0))
    if not found.complete:
        return _INTERRUPTED
    return 0 if found.known.all() else _OPEN


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
        raise InputError(f"{name} asks for {count} values; give 1 to 100000")
    values: list[float] = np.linspace(first, last, count).tolist()
    return values


def _note(system: RodSystem, force: str | None) -> str:
    """What is to be said of the force of a system whose scheme is as printed; a force on the command line is plain."""
    return texts.AS_PRINTED if system.form == "as-printed" and force is None else ""


def _say(found: Response | Bifurcation | Basin, out: Output, note: str = "") -> None:
    """Print a result, with a note if there is one."""
    more, said = ({"note": note.removeprefix("Note: ")}, [note]) if note else ({}, [])
    out.results(found.to_dict() | more, [*str(found).split("\n"), *said])

"""The commands about long runs: ``response``, ``bifurcation``, ``basin``."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from analysis.cli.commands import Json, Quiet, Settings
from analysis.cli.commands import app as app
from analysis.cli.refused import refused
from analysis.cli.responding_texts import AS_PRINTED, BASIN, BIFURCATION, RESPONSE

if TYPE_CHECKING:
    from analysis.plots import Draw
    from analysis.response import Basin, Bifurcation, Plan, Response
    from analysis.response.sweeping import Order
    from lure.scenario import Scenario
    from lure.systems import RodSystem

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


@app.command(help=RESPONSE)
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
    chosen = _rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    from analysis.cli.progress import progress
    from analysis.response import response as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=separation)
    scenario = _scenario(chosen, force)
    with progress(quiet=quiet) as tell:
        found = run(chosen.rod, scenario, plan=plan, progress=tell)
    from analysis.plots.response import plot_response

    _say(found, as_json=as_json, note=_note(chosen, force))
    _draw(plot, partial(plot_response, found), (9.6, 7.0), quiet=quiet, as_json=as_json, replace=replace)


@app.command(help=BIFURCATION)
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
    chosen = _rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    values = _grid((first, last, count), "--count")
    from analysis.cli.progress import progress
    from analysis.response import Sweep
    from analysis.response import bifurcation as run

    plan = _plan((settle, period, tolerance), (periods, samples), rigid=rigid, separation=False)
    text = str(chosen.scenario.force) if force is None else force
    with progress(quiet=quiet) as tell:
        sweep = Sweep(plan=plan, order=cast("Order", way), start=chosen.scenario, workers=workers, progress=tell)
        found = run(chosen.rod, text, parameter, values, sweep=sweep)
    from analysis.plots.sweeps import plot_bifurcation

    _say(found, as_json=as_json, note=_note(chosen, force))
    if found.points:
        _draw(plot, partial(plot_bifurcation, found), (6.6, 4.4), quiet=quiet, as_json=as_json, replace=replace)
    return 0 if found.complete else _INTERRUPTED


@app.command(help=BASIN)
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
    chosen = _rod_system(system, set_ or [])
    _check_figure(plot, replace=replace)
    offsets, velocities = _grid(offset, "--offset"), _grid(velocity, "--velocity")
    from analysis.cli.progress import progress
    from analysis.response import basin as run

    with progress(quiet=quiet) as tell:
        found = run(chosen.rod, offsets, velocities, start=chosen.scenario, progress=tell)
    from analysis.plots.sweeps import plot_basin

    _say(found, as_json=as_json)
    if (found.impacts >= 0).any():
        _draw(plot, partial(plot_basin, found), (5.6, 4.0), quiet=quiet, as_json=as_json, replace=replace)
    if not found.complete:
        return _INTERRUPTED
    return 0 if found.known.all() else _OPEN


def _rod_system(reference: str, settings: list[str]) -> RodSystem:
    from lure.system_file import find_system
    from lure.systems import RodSystem

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
    from analysis.response import Plan
    from lure.motion import Boundary

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
    from analysis.runs.writing import check_targets

    check_targets([plot], replace=replace)


def _note(system: RodSystem, force: str | None) -> str:
    """What is to be said of the force of a system whose scheme is as printed; a force on the command line is plain."""
    return AS_PRINTED if system.form == "as-printed" and force is None else ""


def _say(found: Response | Bifurcation | Basin, *, as_json: bool, note: str = "") -> None:
    """Print a result as JSON or in lines of 80 columns."""
    if as_json:
        said = found.to_dict() | ({"note": note.removeprefix("Note: ")} if note else {})
        print(json.dumps(said, indent=2, ensure_ascii=False, allow_nan=False))
        return
    from analysis.cli.wrapping import wrapped

    lines = [*str(found).split("\n"), *([note] if note else [])]
    print("\n".join(line for text in lines for line in wrapped(text, indent=2)))


def _draw(
    plot: Path | None, draw: Draw, size: tuple[float, float], *, quiet: bool, as_json: bool, replace: bool
) -> None:
    if plot is None:
        return
    from analysis.plots import render
    from analysis.runs.writing import written

    picture = render(draw, name=plot.stem, size=size)
    with written([plot], replace=replace) as places:
        if plot.suffix.lower() == ".svg":
            places[plot].write_text(picture.svg, encoding="utf-8")
        else:
            places[plot].write_bytes(picture.png)
    if not quiet:
        print(("" if as_json else "\n") + f"Written: {plot}", file=sys.stderr if as_json else sys.stdout)

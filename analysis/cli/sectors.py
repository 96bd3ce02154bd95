"""The command ``lure sector``."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lure.analysis.cli.commands import Json, Quiet, Seconds, check_seconds
from lure.analysis.cli.commands import app as app
from lure.analysis.cli.progress import refused
from lure.analysis.cli.texts import SECTOR

if TYPE_CHECKING:
    from lure.analysis.measured import MeasuredReport
    from lure.analysis.nonlinearity import NonlinearityBounds, Violation
    from lure.analysis.nonlinearity.result import Bound, Quantity
    from lure.analysis.plots import Draw
    from lure.analysis.verdict import Verdict
    from lure.classes import Sector, SlopeBounds

# ``lure sector`` with a file of measured data.

_SHOWN, _OPEN = 0, 10


@dataclass(frozen=True, kw_only=True, slots=True)
class Reading:
    """What of the file is read, and how: the options of the command."""

    displacement: str | None
    force: str | None
    units: str | None
    area: float | None
    origin: str
    confidence: float
    fit: bool


def measured(file: Path, reading: Reading, claim: Sector | SlopeBounds | None, *, as_json: bool) -> MeasuredReport:
    """Read the file, and print what its data show.

    Parameters
    ----------
    file : Path
        Columns of displacement and force.
    reading : Reading
        The options.
    claim : Sector or SlopeBounds, optional
        Bounds the data are compared with.
    as_json : bool
        Whether JSON is printed.
    """
    from lure.analysis.measured import read_measurements, report_from_data

    origin: float | str = "gap" if reading.origin == "gap" else _number(reading.origin)
    data = read_measurements(
        file,
        displacement=reading.displacement,
        force=reading.force,
        units=None if reading.units is None else _units(reading.units),
        area=reading.area,
    )
    found = report_from_data(data, confidence=reading.confidence, origin=origin, fit=reading.fit)
    if as_json:
        document = found.to_dict()
        if claim is not None:
            document["within"] = {"lower": str(claim.lower), "upper": str(claim.upper), "inside": inside(found, claim)}
        print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))
        return found
    from lure.analysis.cli.texts import wrapped

    lines = str(found).split("\n")
    if claim is not None:
        yes = "within" if inside(found, claim) else "not within"
        lines.append(f"The measured bounds are {yes} {claim} (observed: neither proves nor refutes anything).")
    print("\n".join(part for line in lines for part in wrapped(line, indent=4 if line.startswith(" ") else 2)))
    return found


def inside(found: MeasuredReport, claim: Sector | SlopeBounds) -> bool:
    """Whether the measured bounds lie within others, and the element showed no memory.

    Parameters
    ----------
    found : MeasuredReport
        The data.
    claim : Sector or SlopeBounds
        The others.
    """
    from lure.classes import Sector

    sector = found.sector
    pair = (sector.lower, sector.upper) if isinstance(claim, Sector) else (sector.slope_lower, sector.slope_upper)
    return sector.memoryless and claim.lower <= pair[0].bound and pair[1].bound <= claim.upper


def status(found: MeasuredReport, claim: Sector | SlopeBounds | None) -> int:
    """0 where the data have finite bounds with a confidence, within those asked for; 10 otherwise, and with memory.

    Parameters
    ----------
    found : MeasuredReport
        The data.
    claim : Sector or SlopeBounds, optional
        The bounds asked for.
    """
    sector = found.sector
    sure = sector.stated and sector.bounded
    return _SHOWN if sure and (claim is None or inside(found, claim)) else _OPEN


def drawing(found: MeasuredReport) -> tuple[Draw, tuple[float, float]]:
    """What draws the report, and how large [inch].

    Parameters
    ----------
    found : MeasuredReport
        The data.
    """
    from lure.analysis.plots.measured import SIZE, plot_measured

    return partial(plot_measured, found.sector, fit=found.fit), SIZE


def _units(text: str) -> tuple[str, str]:
    """The two units of ``mm,N``."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 2 or not all(parts):
        from lure.analysis.measured.table import EXAMPLES

        raise refused(f"--units is {text!r:.40}; give the two units as in --units mm,N, each for example of {EXAMPLES}")
    return parts[0], parts[1]


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise refused(f"--origin is {text!r:.40}; give a displacement in the SI unit, or gap")
    return value


_SECTORS_SHOWN, _SECTORS_OPEN, _VIOLATED = 0, 10, 11
_SIZE = (5.4, 3.9)
Pair = tuple[str, str]


@app.command(help=SECTOR)
def sector(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="Measured data: CSV of displacement and force.", show_default=False),
    ] = None,
    expr: Annotated[
        str | None, typer.Option("--expr", metavar="EXPR", help="A law in sigma, or in x.", show_default=False)
    ] = None,
    on: Annotated[
        Pair | None,
        typer.Option("--on", metavar="LOW HIGH", help="The interval; else all of R.", show_default=False),
    ] = None,
    slope: Annotated[bool, typer.Option("--slope", help="Ask for the slopes, not the sector.")] = False,
    within: Annotated[
        Pair | None,
        typer.Option("--within", metavar="LOWER UPPER", help="Bounds to hold, inf allowed.", show_default=False),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw it: .svg or .png.", show_default=False)
    ] = None,
    replace: Annotated[bool, typer.Option("--replace", help="Replace the figure if it exists.")] = False,
    displacement: Annotated[
        str | None,
        typer.Option("--displacement", metavar="NAME", help="Column of the file, or its number.", show_default=False),
    ] = None,
    force: Annotated[
        str | None,
        typer.Option("--force", metavar="NAME", help="Column of force or stress, likewise.", show_default=False),
    ] = None,
    units: Annotated[
        str | None,
        typer.Option("--units", metavar="U,F", help="Units of the two, as mm,N or V,V.", show_default=False),
    ] = None,
    area: Annotated[
        float | None,
        typer.Option("--area", metavar="M2", help="Area to divide the force by [m^2].", show_default=False),
    ] = None,
    origin: Annotated[
        str, typer.Option("--origin", metavar="M", help="Displacement where sigma = 0 [m], or gap: as fitted.")
    ] = "0",
    confidence: Annotated[float, typer.Option("--confidence", metavar="C", help="Of the measured bounds.")] = 0.95,
    fit: Annotated[bool, typer.Option("--fit", help="Fit normal compliance to the file.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Bound a law, or measured data; 11 if a bound that was to hold does not, 10 if that is open."""
    if (file is None) == (expr is None):
        raise refused("give a law with --expr, or a file of measured data, and not both; see lure sector --help")
    check_seconds(seconds)
    _check_figure(plot, replace=replace)
    if expr is None:
        assert file is not None, "one of the two is given"
        if on is not None:
            raise refused("--on goes with --expr; measured data say nothing outside their own range")

        asked = None if within is None else _claim(within, slope=slope)
        reading = Reading(
            displacement=displacement,
            force=force,
            units=units,
            area=area,
            origin=origin,
            confidence=confidence,
            fit=fit,
        )
        data = measured(file, reading, asked, as_json=as_json)
        if plot is not None:
            draw, size = drawing(data)
            _write(plot, draw, size, replace=replace)
            _say_written(plot, as_json=as_json, quiet=quiet)
        return status(data, asked)
    if fit or (displacement, force, units, area, origin, confidence) != (None, None, None, None, "0", 0.95):
        raise refused(
            "--displacement, --force, --units, --area, --origin, --confidence and --fit go with a file of measured data"
        )
    interval = None if on is None else tuple(_finite(text, "--on") for text in on)
    claim = None if within is None else _claim(within, slope=slope)
    from lure.analysis.nonlinearity import nonlinearity_bounds, violation

    found = nonlinearity_bounds(expr, on=interval, seconds=seconds)
    verdict = None if claim is None else found.within(claim)
    shown = None if claim is None else violation(expr, claim, on=interval, found=found)
    quantity: Quantity = "slope" if slope else "sector"
    if as_json:
        print(json.dumps(_document(found, quantity, claim, verdict, shown), indent=2, ensure_ascii=False))
    else:
        print(_text(found, quantity, claim, verdict, shown))
    if plot is not None:
        _draw(plot, expr, found, quantity=quantity, replace=replace)
        _say_written(plot, as_json=as_json, quiet=quiet)
    return _status(found, quantity, verdict, shown)


def _status(found: NonlinearityBounds, quantity: Quantity, verdict: Verdict | None, shown: Violation | None) -> int:
    from lure.analysis.verdict import Verdict

    if verdict is not None:
        if verdict is Verdict.PROVED:
            return _SECTORS_SHOWN
        return _VIOLATED if shown is not None else _SECTORS_OPEN
    pair = found.extremes(quantity)
    known = all(part is not None and math.isfinite(part.gap) for part in pair)
    return _SECTORS_SHOWN if known else _SECTORS_OPEN


def _text(
    found: NonlinearityBounds,
    quantity: Quantity,
    claim: Sector | SlopeBounds | None,
    verdict: Verdict | None,
    shown: Violation | None,
) -> str:
    from lure.analysis.cli.texts import wrapped
    from lure.analysis.verdict import Verdict

    lines = found.lines(quantity)
    if claim is not None:
        what = "slopes" if quantity == "slope" else "law"
        where = f"{'slope bounds' if quantity == 'slope' else 'sector'} {claim}"
        if shown is not None:
            lines.append(f"The {what} leave{'' if quantity == 'slope' else 's'} the {where}: {shown}.")
        elif verdict is Verdict.PROVED:
            lines.append(f"The {what} lie{'' if quantity == 'slope' else 's'} within the {where} ({found.evidence}).")
        else:
            lines.append(
                f"Whether the {what} stay{'' if quantity == 'slope' else 's'} within the {where} is not decided."
            )
    return "\n".join(part for line in lines for part in wrapped(line, indent=2))


def _document(
    found: NonlinearityBounds,
    quantity: Quantity,
    claim: Sector | SlopeBounds | None,
    verdict: Verdict | None,
    shown: Violation | None,
) -> dict[str, object]:
    document: dict[str, object] = {"schema": "lure-sector/1", **found.to_dict()}
    if claim is not None:
        document["within"] = {
            "quantity": quantity,
            "lower": str(claim.lower),
            "upper": str(claim.upper),
            "verdict": str(verdict),
            "violation": None if shown is None else shown.to_dict(),
        }
    return document


def _claim(pair: Pair, *, slope: bool) -> Sector | SlopeBounds:
    from lure.classes import Sector, SlopeBounds

    lower, upper = (_bound(text, "--within") for text in pair)
    return SlopeBounds(lower, upper) if slope else Sector(lower, upper)


def _bound(text: str, name: str) -> Bound:
    if text.strip().lower() in ("inf", "+inf", "-inf"):
        return -math.inf if text.strip().startswith("-") else math.inf
    return _finite(text, name)


def _finite(text: str, name: str) -> Fraction:
    """A number as it is written, exactly: 0.1 is 1/10."""
    try:
        if len(text) > 60 or abs(int(text.lower().partition("e")[2] or 0)) > 300:
            raise ValueError
        return Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise refused(f"{name} has {text!r:.60}; give a number such as 0.5, 1e-3 or 1/3") from None


def _check_figure(plot: Path | None, *, replace: bool) -> None:
    """Refuse a figure that cannot be written before anything is computed."""
    if plot is None:
        return
    if plot.suffix.lower() not in (".svg", ".png"):
        raise refused(f"--plot is {str(plot)!r}; give a name that ends in .svg or .png")
    from lure.analysis.rod.runs.drawing import check_targets

    check_targets([plot], replace=replace)


def _draw(plot: Path, law: str, found: NonlinearityBounds, *, quantity: Quantity, replace: bool) -> None:
    from lure.analysis.plots.sectors import plot_law_sector, plot_law_slope

    draw = plot_law_slope if quantity == "slope" else plot_law_sector
    _write(plot, partial(draw, law, found), _SIZE, replace=replace)


def _write(plot: Path, draw: Draw, size: tuple[float, float], *, replace: bool) -> None:
    from lure.analysis.plots import render
    from lure.analysis.rod.runs.drawing import written

    picture = render(draw, name=plot.stem, size=size)
    with written([plot], replace=replace) as places:
        if plot.suffix.lower() == ".svg":
            places[plot].write_text(picture.svg, encoding="utf-8")
        else:
            places[plot].write_bytes(picture.png)


def _say_written(plot: Path, *, as_json: bool, quiet: bool) -> None:
    if not quiet:
        print(("" if as_json else "\n") + f"Written: {plot}", file=sys.stderr if as_json else sys.stdout)

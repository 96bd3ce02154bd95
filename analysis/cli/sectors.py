"""The command ``lure sector``."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from lure.analysis.cli.options import (
    Figure,
    Json,
    Output,
    Quiet,
    Replace,
    Seconds,
    app,
    check_figure,
    option,
    print_json,
    print_wrapped,
)
from lure.analysis.cli.texts import SECTOR
from lure.errors import InputError

if TYPE_CHECKING:
    from lure.analysis.measured import MeasuredReport
    from lure.analysis.nonlinearity import NonlinearityBounds, Violation
    from lure.analysis.nonlinearity.result import Bound, Quantity
    from lure.analysis.plots import Draw
    from lure.analysis.verdict import Verdict
    from lure.classes import Sector, SlopeBounds

_SHOWN, _OPEN, _VIOLATED = 0, 10, 11
Pair = tuple[str, str]
Drawing: TypeAlias = "Callable[[], tuple[Draw, tuple[float, float]]]"  # what draws, and how large [inch]


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


def _of_data(file: Path, reading: Reading, claim: Sector | SlopeBounds | None, *, as_json: bool) -> tuple[int, Drawing]:
    """Read the file and print what its data show, compared with the claim: the exit status, and what to draw.

    The status is 0 where the data have finite bounds with a confidence, within those asked for; 10 otherwise, and with
    memory.
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
    within = claim is None or _inside(found, claim)
    if as_json:
        document = found.to_dict()
        if claim is not None:
            document["within"] = {"lower": str(claim.lower), "upper": str(claim.upper), "inside": within}
        print_json(document)
    else:
        lines = str(found).split("\n")
        if claim is not None:
            yes = "within" if within else "not within"
            lines.append(f"The measured bounds are {yes} {claim} (observed: neither proves nor refutes anything).")
        print_wrapped(lines, nested=4)
    sure = found.sector.stated and found.sector.bounded
    return _SHOWN if sure and within else _OPEN, partial(_data_drawn, found)


def _inside(found: MeasuredReport, claim: Sector | SlopeBounds) -> bool:
    """Whether the measured bounds lie within others, and the element showed no memory."""
    from lure.classes import Sector

    sector = found.sector
    pair = (sector.lower, sector.upper) if isinstance(claim, Sector) else (sector.slope_lower, sector.slope_upper)
    return sector.memoryless and claim.lower <= pair[0].bound and pair[1].bound <= claim.upper


def _data_drawn(found: MeasuredReport) -> tuple[Draw, tuple[float, float]]:
    from lure.analysis.plots.measured import SIZE, plot_measured

    return partial(plot_measured, found.sector, fit=found.fit), SIZE


def _units(text: str) -> tuple[str, str]:
    """The two units of ``mm,N``."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 2 or not all(parts):
        from lure.analysis.measured.table import EXAMPLES

        raise InputError(
            f"--units is {text!r:.40}; give the two units as in --units mm,N, each for example of {EXAMPLES}"
        )
    return parts[0], parts[1]


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"--origin is {text!r:.40}; give a displacement in the SI unit, or gap")
    return value


@app.command(help=SECTOR)
def sector(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="Measured data: CSV of displacement and force.", show_default=False),
    ] = None,
    expr: Annotated[str | None, option("--expr", "EXPR", "A nonlinearity in sigma, or in x.")] = None,
    on: Annotated[Pair | None, option("--on", "LOW HIGH", "The interval; else all of R.")] = None,
    slope: Annotated[bool, typer.Option("--slope", help="Ask for the slopes, not the sector.")] = False,
    within: Annotated[Pair | None, option("--within", "LOWER UPPER", "Bounds to hold, inf allowed.")] = None,
    plot: Figure = None,
    replace: Replace = False,
    displacement: Annotated[str | None, option("--displacement", "NAME", "Column of the file, or its number.")] = None,
    force: Annotated[str | None, option("--force", "NAME", "Column of force or stress, likewise.")] = None,
    units: Annotated[str | None, option("--units", "U,F", "Units of the two, as mm,N or V,V.")] = None,
    area: Annotated[float | None, option("--area", "M2", "Area to divide the force by [m^2].")] = None,
    origin: Annotated[
        str, typer.Option("--origin", metavar="M", help="Displacement where sigma = 0 [m], or gap: as fitted.")
    ] = "0",
    confidence: Annotated[float, typer.Option("--confidence", metavar="C", help="Of the measured bounds.")] = 0.95,
    fit: Annotated[bool, typer.Option("--fit", help="Fit normal compliance to the file.")] = False,
    seconds: Seconds = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Bound a nonlinearity, or measured data; 11 if a bound that was to hold does not, 10 if that is open."""
    if (file is None) == (expr is None):
        raise InputError(
            "give a nonlinearity with --expr, or a file of measured data, and not both; see lure sector --help"
        )
    check_figure(plot, replace=replace)
    claim = None if within is None else _claim(within, slope=slope)
    if expr is not None:
        if fit or (displacement, force, units, area, origin, confidence) != (None, None, None, None, "0", 0.95):
            raise InputError(
                "--displacement, --force, --units, --area, --origin, --confidence and --fit go with a file of measured "
                "data"
            )
        status, drawing = _of_nonlinearity(expr, on, claim, slope=slope, seconds=seconds, as_json=as_json)
    else:
        assert file is not None, "one of the two is given"
        with suppress(OSError):  # a name that is no path at all is refused when it is read
            if not file.exists():
                raise InputError(f"{str(file)!r:.60} is no file; give measured data, or a formula with --expr")
        if on is not None:
            raise InputError("--on goes with --expr; measured data say nothing outside their own range")
        reading = Reading(
            displacement=displacement,
            force=force,
            units=units,
            area=area,
            origin=origin,
            confidence=confidence,
            fit=fit,
        )
        status, drawing = _of_data(file, reading, claim, as_json=as_json)
    if plot is not None:
        Output(as_json=as_json, quiet=quiet, replace=replace).figure(plot, *drawing())
    return status


def _of_nonlinearity(
    nonlinearity: str,
    on: Pair | None,
    claim: Sector | SlopeBounds | None,
    *,
    slope: bool,
    seconds: float | None,
    as_json: bool,
) -> tuple[int, Drawing]:
    """Bound a nonlinearity and print it: the exit status, and what to draw."""
    from lure.analysis.nonlinearity import nonlinearity_bounds, violation

    interval = None if on is None else tuple(_finite(text, "--on") for text in on)
    found = nonlinearity_bounds(nonlinearity, on=interval, seconds=seconds)
    verdict = None if claim is None else found.within(claim)
    shown = None if claim is None else violation(nonlinearity, claim, on=interval, found=found)
    quantity: Quantity = "slope" if slope else "sector"
    said = (found, quantity, claim, verdict, shown)
    Output(as_json=as_json).results(_document(*said), _lines(*said))
    return _status(found, quantity, verdict, shown), partial(_nonlinearity_drawn, nonlinearity, found, slope=slope)


def _nonlinearity_drawn(
    nonlinearity: str, found: NonlinearityBounds, *, slope: bool
) -> tuple[Draw, tuple[float, float]]:
    from lure.analysis.plots.sectors import plot_nonlinearity_sector, plot_nonlinearity_slope

    return partial(plot_nonlinearity_slope if slope else plot_nonlinearity_sector, nonlinearity, found), (5.4, 3.9)


def _status(found: NonlinearityBounds, quantity: Quantity, verdict: Verdict | None, shown: Violation | None) -> int:
    from lure.analysis.verdict import Verdict

    if verdict is not None:
        if verdict is Verdict.PROVED:
            return _SHOWN
        return _VIOLATED if shown is not None else _OPEN
    pair = found.extremes(quantity)
    known = all(part is not None and math.isfinite(part.gap) for part in pair)
    return _SHOWN if known else _OPEN


def _lines(
    found: NonlinearityBounds,
    quantity: Quantity,
    claim: Sector | SlopeBounds | None,
    verdict: Verdict | None,
    shown: Violation | None,
) -> list[str]:
    from lure.analysis.verdict import Verdict

    lines = found.lines(quantity)
    if claim is not None:
        what = "slopes" if quantity == "slope" else "nonlinearity"
        where = f"{'slope bounds' if quantity == 'slope' else 'sector'} {claim}"
        if shown is not None:
            lines.append(f"The {what} leave{'' if quantity == 'slope' else 's'} the {where}: {shown}.")
        elif verdict is Verdict.PROVED:
            lines.append(f"The {what} lie{'' if quantity == 'slope' else 's'} within the {where} ({found.evidence}).")
        else:
            lines.append(
                f"Whether the {what} stay{'' if quantity == 'slope' else 's'} within the {where} is not decided."
            )
    return lines


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
    if lower > upper:
        raise InputError(f"--within is {' '.join(pair)}; the first number must be smaller than the second")
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
        raise InputError(f"{name} has {text!r:.60}; give a number such as 0.5, 1e-3 or 1/3") from None

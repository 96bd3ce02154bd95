"""``lure sector`` with a file of measured data."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.cli.refused import refused

if TYPE_CHECKING:
    from analysis.measured import MeasuredReport
    from analysis.plots import Draw
    from lure.sector import Sector, SlopeBounds

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
    from analysis.measured import read_measurements, report_of

    origin: float | str = "gap" if reading.origin == "gap" else _number(reading.origin)
    data = read_measurements(
        file,
        displacement=reading.displacement,
        force=reading.force,
        units=None if reading.units is None else _units(reading.units),
        area=reading.area,
    )
    found = report_of(data, confidence=reading.confidence, origin=origin, fit=reading.fit)
    if as_json:
        document = found.to_dict()
        if claim is not None:
            document["within"] = {"lower": str(claim.lower), "upper": str(claim.upper), "inside": inside(found, claim)}
        print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))
        return found
    from analysis.cli.wrapping import wrapped

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
    from lure.sector import Sector

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
    from analysis.plots.measured import SIZE, plot_measured

    return partial(plot_measured, found.sector, fit=found.fit), SIZE


def _units(text: str) -> tuple[str, str]:
    """The two units of ``mm,N``."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 2 or not all(parts):
        from analysis.measured.units import EXAMPLES

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

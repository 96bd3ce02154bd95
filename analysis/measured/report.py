"""Everything that is said of one file of measurements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from lure.analysis.drawing import drawing
from lure.analysis.measured.compliance import ComplianceFit, fit_compliance
from lure.analysis.measured.measured_sector import MeasuredSector
from lure.analysis.measured.reading import Measurements, read_measurements
from lure.analysis.measured.sector import sector_from_data
from lure.errors import AssumptionError, InputError
from lure.record import Record, quantity

if TYPE_CHECKING:
    import xarray

    from lure.analysis.drawing import Axes

SCHEMA = "lure-measured/1"


class MeasuredReport(Record):
    """The measurements, their sector, and the fit of normal compliance where it was asked for."""

    sector: MeasuredSector = quantity("Bounds on the mean nonlinearity; holds the measurements")
    fit: ComplianceFit | None = quantity("The fit")

    @property
    def measurements(self) -> Measurements:
        """What was read."""
        return self.sector.measurements

    def plot(self, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
        """The data, the nonlinearity, its sector, the fit if there is one, and the residuals.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: tuple[Axes, Axes] = drawing(self.sector)(self.sector, fit=self.fit, ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """The report as plain data."""
        return {"schema": SCHEMA, **super().to_dict()}

    def to_xarray(self) -> xarray.Dataset:
        """The Dataset of the sector, with that of the fit in it where there is one.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        whole = self.sector.to_xarray()
        if self.fit is None:
            return whole
        fitted = self.fit.to_xarray()
        if self.fit.branch is not None:  # rows of one branch only
            fitted = fitted.rename({"row": "fit_row", "displacement": "fit_displacement", "load": "fit_load"})
            fitted = fitted.drop_vars(["line", "branch"])
        merged: xarray.Dataset = whole.merge(fitted, combine_attrs="override", compat="equals")
        return merged.assign_attrs(fit_comment=self.fit.conclusion)

    def _repr_html_(self) -> str:
        parts = [self.measurements, self.sector, self.fit] if self.fit else [self.measurements, self.sector]
        return "\n".join(part._repr_html_() for part in parts)

    def __str__(self) -> str:
        parts = [str(self.measurements), str(self.sector)]
        return "\n".join([*parts, str(self.fit)] if self.fit else parts)


def report_from_data(
    source: str | Path | Measurements, *, confidence: float = 0.95, origin: float | str = 0.0, fit: bool = False
) -> MeasuredReport:
    """Sector, slope bounds and, if asked for, the fitted compliance nonlinearity of measurements.

    Parameters
    ----------
    source : str, Path or Measurements
        A file or text as :func:`read_measurements` takes it, or what it returned.
    confidence : float
        Of every interval.
    origin : float or str
        Displacement [m] at which ``sigma = 0``; ``gap`` takes the fitted gap, without its uncertainty.
    fit : bool
        Whether normal compliance is fitted.

    Raises
    ------
    InputError
        The file or an argument is no good, or the fit was asked for and cannot be made.

    Examples
    --------
    >>> from lure.analysis.measured import EXAMPLE
    >>> report_from_data(EXAMPLE, fit=True).fit.parameters["m"].value
    1.5
    """
    measurements = source if isinstance(source, Measurements) else read_measurements(source)
    if isinstance(origin, str) and origin != "gap":
        raise InputError(f"origin is {origin!r:.40}; give a displacement in the SI unit, or 'gap'")
    try:
        fitted = fit_compliance(measurements, confidence=confidence) if fit or origin == "gap" else None
    except AssumptionError as error:
        raise InputError(f"normal compliance cannot be fitted: {error}") from None
    place = fitted.parameters["gap"].value if fitted is not None and isinstance(origin, str) else float(origin)
    found = sector_from_data(measurements, confidence=confidence, origin=place)
    return MeasuredReport(sector=found, fit=fitted if fit else None)

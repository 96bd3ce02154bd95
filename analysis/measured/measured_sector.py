"""What measurements say about a sector, and on which assumptions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lure.analysis.measured.mean_law import BENT, MeanLaw
from lure.analysis.measured.measurements import Measurements
from lure.analysis.numerics.doubles import json_number
from lure.analysis.verdict import Evidence
from lure.classes import Sector, SlopeBounds
from lure.record import by_value

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.measured import Axes

_ASSUMED = (
    "each load is f(sigma) plus an independent normal error of mean 0 and standard deviation s0 + s1 |f|, unknown",
    "displacements have no error, or one whose effect on the load is part of that scatter",
    "{} f(0) = 0, continuous and affine between the knots",
)
MEMORY = (
    "Loading and unloading differ by more than noise: the element has memory, no memoryless law describes it, and no "
    "criterion for memoryless laws (circle, Popov, Zames-Falb) applies."
)
TO_TRY = (
    "Sweep again at half the speed. If the loop becomes thinner, the element is viscous: measure the force against the "
    "velocity, and put the damping into the linear part. If it stays, it is backlash, friction or plasticity, which "
    "needs a model with memory; look for play in the mounting first."
)


@dataclass(frozen=True, kw_only=True, slots=True)
class Bound:
    """A bound with its confidence, the extreme of the fitted law, and the ``sigma`` [m] that sets the bound."""

    bound: float
    fitted: float
    at: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Outlier:
    """A reading left out of the fit.

    Attributes
    ----------
    index : int
        Its row, from 0.
    line : int
        Its line in the file, from 1.
    score : float
        Its residual in standard deviations.
    """

    index: int
    line: int
    score: float


@dataclass(frozen=True, kw_only=True, slots=True)
class Hysteresis:
    """How far loading and unloading lie apart.

    Attributes
    ----------
    width : float
        Largest difference of the mean loads at one displacement [unit of the load].
    at : float
        Where, displacement [m].
    share : float
        The width as a share of the largest mean load.
    dissipated : float
        Area between loading and unloading [unit of the load times m], over the displacements of both.
    rows : tuple of int
        Rows on loading and on unloading.
    branches : int
        How many branches there are.
    """

    width: float
    at: float
    share: float
    dissipated: float
    rows: tuple[int, int]
    branches: int


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class MeasuredSector:
    """Bounds on the chords and slopes of the mean law behind measurements; see :func:`sector_of` for the assumptions.

    Attributes
    ----------
    measurements : Measurements
        What they are about.
    confidence : float
        With which all four bounds hold at once, if the assumptions do and the law is ``resolved``.
    origin : float
        Displacement [m] at which ``sigma = 0``.
    lower, upper : Bound
        Of ``f(sigma)/sigma`` [unit of the load / m].
    slope_lower, slope_upper : Bound
        Of the slope.
    laws : tuple of MeanLaw
        The fitted law; with hysteresis that of loading and that of unloading.
    outliers : tuple of Outlier
        Readings left out.
    hysteresis : Hysteresis or None
        Where the branches lie apart.
    warnings : tuple of str
        Assumptions that the data contradict, and what was done.
    multipliers : tuple of float
        For each law, how many standard errors the simultaneous intervals reach to either side.
    """

    measurements: Measurements
    confidence: float
    origin: float
    lower: Bound
    upper: Bound
    slope_lower: Bound
    slope_upper: Bound
    laws: tuple[MeanLaw, ...]
    outliers: tuple[Outlier, ...]
    hysteresis: Hysteresis | None
    warnings: tuple[str, ...]
    multipliers: tuple[float, ...]

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: a sample proves nothing for every ``sigma``."""
        return Evidence.OBSERVED

    @property
    def memoryless(self) -> bool:
        """Whether no hysteresis was seen; not seeing it does not prove that there is none."""
        return self.hysteresis is None

    @property
    def resolved(self) -> bool:
        """Whether twice as many pieces fit no better; where they do, the bounds are estimates without a confidence."""
        return all(law.curved >= BENT for law in self.laws)

    @property
    def stated(self) -> bool:
        """Whether the bounds are stated with the confidence: no loop was seen, and the law is ``resolved``."""
        return self.memoryless and self.resolved

    @property
    def bounded(self) -> bool:
        """Whether the chords have a finite bound on either side."""
        return math.isfinite(self.lower.bound) and math.isfinite(self.upper.bound)

    @property
    def how_sure(self) -> str:
        """The confidence in words, or that none is stated."""
        return f"with {100 * self.confidence:g} % confidence" if self.stated else "without a stated confidence"

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What the confidence rests on."""
        law = "f is one law without memory,"
        if not self.memoryless:
            law = "loading has one mean law f, unloading another, each"
        elif not self.measurements.branches:
            law = "f is one law without memory (a single sweep, or rows in no order, cannot show a loop),"
        return (*_ASSUMED[:2], _ASSUMED[2].format(law))

    @property
    def domain(self) -> tuple[float, float]:
        """Between which ``sigma`` [m] there are measurements."""
        u = self.measurements.displacement
        return float(u.min()) - self.origin + 0.0, float(u.max()) - self.origin + 0.0  # no minus before a zero

    @property
    def sector(self) -> Sector:
        """The bounds as a sector: what the user may vouch for, never what was proved."""
        return Sector(self.lower.bound, self.upper.bound)

    @property
    def slope(self) -> SlopeBounds:
        """The slope bounds, likewise."""
        return SlopeBounds(self.slope_lower.bound, self.slope_upper.bound)

    @property
    def conclusion(self) -> str:
        """What holds, and on which conditions."""
        low, high = self.domain
        where = f"for sigma in [{low:.4g}, {high:.4g}] {self.measurements.displacement_unit}"
        if not self.memoryless:
            return f"{self._loop} The element has memory: no sector is stated for it (observed, not proved)."
        unit = self.measurements.stiffness_unit
        slopes = f"slopes in [{_down(self.slope_lower.bound)}, {_up(self.slope_upper.bound)}] {unit}"
        if not self.resolved:
            return (
                f"F{where[1:]}, the mean law is estimated to {self._chords('lie')} and to have "
                f"{slopes}; no confidence is stated, since the law bends within its pieces, against what is assumed, "
                "and nothing is known outside this range (observed, not proved)."
            )
        return (
            f"With {100 * self.confidence:g} % confidence, {where}, the mean law {self._chords('lies')} and has "
            f"{slopes}, if the assumptions hold; nothing is known outside this range (observed, not proved)."
        )

    def _chords(self, lies: str) -> str:
        """Where the chords lie, as a predicate; what is infinite is no bound and is not written as one."""
        low, high, unit = self.lower.bound, self.upper.bound, self.measurements.stiffness_unit
        have = "have" if lies == "lie" else "has"
        if self.bounded:
            return f"{lies} in the sector [{_down(low)}, {_up(high)}] {unit}"
        if math.isfinite(low):
            return f"{have} chords of at least {_down(low)} {unit}, without a bound above,"
        if math.isfinite(high):
            return f"{have} chords of at most {_up(high)} {unit}, without a bound below,"
        return f"{lies} in no sector that the data bound"

    @property
    def _loop(self) -> str:
        """The loop, named."""
        assert self.hysteresis is not None, "asked with a loop only"
        h, data = self.hysteresis, self.measurements
        return (
            f"Loading and unloading follow different laws: on {h.branches} branches there is a loop of area "
            f"{abs(h.dissipated):.3g} {data.area_unit}, {h.width:.3g} {data.unit} wide at u = {h.at:.3g} "
            f"{data.displacement_unit}, which is {100 * h.share:.3g} % of the largest load."
        )

    def plot(self, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
        """Data, law with its band, sector and residuals; see :func:`lure.analysis.plots.plot_measured`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.measured import plot_measured

        return plot_measured(self, ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data; infinite numbers are the text ``inf``."""
        bounds = {name: getattr(self, name) for name in ("lower", "upper", "slope_lower", "slope_upper")}
        return {
            "measurements": self.measurements.to_dict(),
            "confidence": self.confidence if self.stated else None,
            "resolved": self.resolved,
            "evidence": str(self.evidence),
            "origin": self.origin,
            "domain": list(self.domain),
            "unit": self.measurements.stiffness_unit,
            **{
                name: {"bound": json_number(b.bound), "fitted": json_number(b.fitted), "at": b.at}
                for name, b in bounds.items()
            },
            "laws": [
                {
                    "knots": law.knots.tolist(),
                    "values": law.values.tolist(),
                    "noise": {"constant": law.noise.constant, "proportional": law.noise.proportional},
                    "curved": law.curved,
                }
                for law in self.laws
            ],
            "outliers": [{"row": o.index, "line": o.line, "deviations": o.score} for o in self.outliers],
            "memoryless": self.memoryless,
            "hysteresis": None
            if self.hysteresis is None
            else {name: getattr(self.hysteresis, name) for name in ("width", "at", "share", "dissipated", "branches")},
            "assumptions": list(self.assumptions),
            "warnings": [*([MEMORY, TO_TRY] if self.hysteresis else []), *self.warnings],
            "conclusion": self.conclusion,
        }

    def to_xarray(self) -> xarray.Dataset:
        """Rows with the mean law, its error and outliers, and the four bounds, as an ``xarray.Dataset`` with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.measured.export import sector_dataset

        return sector_dataset(self)

    def _repr_html_(self) -> str:
        from lure.analysis.measured.export import sector_html

        return sector_html(self)

    def __str__(self) -> str:
        unit = self.measurements.unit
        lines = [self.conclusion]
        pieces = " and ".join(str(law.knots.size - 1) for law in self.laws)
        both = "" if self.memoryless else "to both mean branches, as an estimate: "
        chords = f"chords {self.lower.fitted:.4g} .. {self.upper.fitted:.4g}, " if self.bounded else ""
        lines.append(
            f"  fitted: {both}{chords}slopes {self.slope_lower.fitted:.4g} .. {self.slope_upper.fitted:.4g} "
            f"{self.measurements.stiffness_unit} on {pieces} pieces"
        )
        for law in self.laws:
            lines.append(
                f"  noise: {law.noise.constant:.3g} {unit} + {100 * law.noise.proportional:.2g} % of the load "
                "(standard deviation)"
            )
        if self.outliers:
            shown = ", ".join(f"line {o.line} ({o.score:+.1f})" for o in self.outliers[:8])
            more = ", ..." if len(self.outliers) > 8 else ""
            lines.append(f"  outliers, left out: {shown}{more} ({len(self.outliers)} in all; residual in deviations)")
        if self.hysteresis:
            lines.append(f"  warning: {MEMORY}")
            lines.append(f"  to try: {TO_TRY}")
        lines += [f"  warning: {text}" for text in self.warnings]
        rests = self.assumptions if self.memoryless else ()  # nothing is stated that would rest on them
        return "\n".join([*lines, *(f"  assumed: {text}" for text in rests)])


def _down(value: float, digits: int = 4) -> str:
    from lure.analysis.numerics.doubles import text_below

    return text_below(value, digits) if math.isfinite(value) else f"{value:g}"


def _up(value: float, digits: int = 4) -> str:
    from lure.analysis.numerics.doubles import text_above

    return text_above(value, digits) if math.isfinite(value) else f"{value:g}"

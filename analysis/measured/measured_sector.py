"""What measurements say about a sector, and on which assumptions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.drawing import drawing
from lure.analysis.measured.mean_nonlinearity import BENT, MeanNonlinearity
from lure.analysis.measured.measurements import SHOWN, Measurements
from lure.analysis.verdict import Evidence
from lure.classes import Sector, SlopeBounds
from lure.record import Column, Page, Record, derived, plain, quantity, rounded

if TYPE_CHECKING:
    from lure.analysis.drawing import Axes

_SIDES = ("lower", "upper", "slope_lower", "slope_upper")
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


class Bound(Record):
    """A bound with its confidence, the extreme of the fitted law, and the ``sigma`` [m] that sets the bound."""

    bound: float = quantity("The bound")
    fitted: float = quantity("The extreme of the fitted law")
    at: float = quantity("``sigma`` that sets the bound", "m")


class Outlier(Record):
    """A reading left out of the fit."""

    index: int = quantity("Its row, from 0", key="row")
    line: int = quantity("Its line in the file, from 1")
    score: float = quantity("Its residual in standard deviations", key="deviations")


class Hysteresis(Record):
    """How far loading and unloading lie apart."""

    width: float = quantity("Largest difference of the mean loads at one displacement", "unit of the load")
    at: float = quantity("Where, displacement", "m")
    share: float = quantity("The width as a share of the largest mean load")
    dissipated: float = quantity(
        "Area between loading and unloading, over the displacements of both", "unit of the load times m"
    )
    rows: tuple[int, int] = quantity("Rows on loading and on unloading", key="")
    branches: int = quantity("How many branches there are")


class MeasuredSector(Record):
    """Bounds on chords and slopes of the mean law behind measurements; assumptions: :func:`sector_from_data`."""

    measurements: Measurements = quantity("What they are about")
    confidence: float = quantity(
        "With which all four bounds hold at once, if the assumptions do and the law is ``resolved``"
    )
    origin: float = quantity("Displacement [m] at which ``sigma = 0``")
    lower: Bound = quantity("Lower bound of ``f(sigma)/sigma``", "unit of the load / m")
    upper: Bound = quantity("Upper bound of the same", "unit of the load / m")
    slope_lower: Bound = quantity("Lower bound of the slope", "unit of the load / m")
    slope_upper: Bound = quantity("Upper bound of the slope", "unit of the load / m")
    laws: tuple[MeanNonlinearity, ...] = quantity(
        "The fitted law; with hysteresis that of loading and that of unloading", key=""
    )
    outliers: tuple[Outlier, ...] = quantity("Readings left out")
    hysteresis: Hysteresis | None = quantity("Where the branches lie apart")
    warnings: tuple[str, ...] = quantity("Assumptions that the data contradict, and what was done")
    multipliers: tuple[float, ...] = quantity(
        "For each law, how many standard errors the simultaneous intervals reach to either side", key=""
    )

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: a sample proves nothing for every ``sigma``."""
        return Evidence.OBSERVED

    @property
    @derived()
    def memoryless(self) -> bool:
        """Whether no hysteresis was seen; not seeing it does not prove that there is none."""
        return self.hysteresis is None

    @property
    @derived()
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
    @derived()
    def assumptions(self) -> tuple[str, ...]:
        """What the confidence rests on."""
        law = "f is one law without memory,"
        if not self.memoryless:
            law = "loading has one mean law f, unloading another, each"
        elif not self.measurements.branches:
            law = "f is one law without memory (a single sweep, or rows in no order, cannot show a loop),"
        return (*_ASSUMED[:2], _ASSUMED[2].format(law))

    @property
    @derived()
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
    @derived()
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
        made: tuple[Axes, Axes] = drawing(self)(self, ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data; infinite numbers are the text ``inf``."""
        laws = [
            {"knots": plain(law.knots), "values": plain(law.values), "noise": plain(law.noise), "curved": law.curved}
            for law in self.laws
        ]
        return super().to_dict() | {
            "confidence": self.confidence if self.stated else None,
            "unit": self.measurements.stiffness_unit,
            "laws": laws,
            "warnings": [*([MEMORY, TO_TRY] if self.hysteresis else []), *self.warnings],
        }

    def _columns(self) -> dict[str, Column]:
        """Rows with the mean law, its error and outliers, and the four bounds; nan on rows of the other branch."""
        data, of = self.measurements, ("row",)
        rows = [np.arange(len(data))] if self.memoryless else [data.rows("loading"), data.rows("unloading")]
        mean, error, score = (np.full(len(data), np.nan) for _ in range(3))
        for law, part in zip(self.laws, rows, strict=True):
            sigma = data.displacement[part] - self.origin
            mean[part], error[part], score[part] = law(sigma), law.error(sigma), law.scores
        outlier = np.zeros(len(data), dtype=bool)
        outlier[[one.index for one in self.outliers]] = True
        shift, unit, place = data.displacement - self.origin, data.stiffness_unit, data.displacement_unit
        sides, to = [getattr(self, name) for name in _SIDES], ("bound",)
        return data._columns() | {
            "sigma": Column(of, shift, place, "displacement less the origin"),
            "mean": Column(of, mean, data.unit, "fitted mean law, of the branch where there are two"),
            "error": Column(of, error, data.unit, "standard error of the mean law, for one place alone"),
            "score": Column(of, score, "1", "residual in standard deviations"),
            "outlier": Column(of, outlier, "1", "whether the row was left out"),
            "limit": Column(to, [side.bound for side in sides], unit, "bound on chords or slopes of the mean law"),
            "fitted": Column(to, [side.fitted for side in sides], unit, "extreme of the fitted law"),
            "limit_at": Column(to, [side.at for side in sides], place, "sigma that sets the bound"),
            "bound": Column(to, np.array(_SIDES, dtype=object), "1", "of f(sigma)/sigma, or of the slope"),
        }

    def _attributes(self) -> dict[str, object]:
        return self.measurements._attributes() | {
            "title": "Sector of a measured law",
            "evidence": str(self.evidence),
            "comment": self.conclusion,
            "confidence": self.confidence if self.stated else "none is stated",
            "origin": self.origin,
            "origin_units": self.measurements.displacement_unit,
            "assumptions": "; ".join(self.assumptions),
            "warnings": "; ".join(self.warnings),
            "memoryless": int(self.memoryless),
        }

    def _page(self) -> Page:
        unit, place = self.measurements.stiffness_unit, self.measurements.displacement_unit
        rows = []
        for name in _SIDES:
            side: Bound = getattr(self, name)
            bound = rounded(side.bound, "below" if name.endswith("lower") else "above", 6)
            rows.append((name.replace("_", ", "), bound, f"{side.fitted:.6g}", f"{side.at:.4g} {place}"))
        head = ("bound", f"{self.how_sure} [{unit}]", f"of the fitted law [{unit}]", "set at sigma")
        notes = [self.conclusion, *([MEMORY, TO_TRY] if self.hysteresis else []), *self.warnings]
        notes += [*left_out(self.outliers), *(f"Assumed: {text}." for text in self.assumptions)]
        return Page(f"sector of {self.measurements.source}", rows, head, "OBSERVED", notes)

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


def left_out(outliers: tuple[Outlier, ...]) -> list[str]:
    """A sentence about the rows left out, if there are any."""
    shown = ", ".join(f"line {one.line} ({one.score:+.1f} deviations)" for one in outliers[:SHOWN])
    more = f", ... ({len(outliers)} in all)" if len(outliers) > SHOWN else ""
    return [f"Outliers, left out: {shown}{more}."] if outliers else []


def _down(value: float) -> str:
    return rounded(value, "below", 4)


def _up(value: float) -> str:
    return rounded(value, "above", 4)

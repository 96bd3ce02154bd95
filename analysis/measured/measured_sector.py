"""What measurements say about a sector, on which assumptions; and what follows for a loop, measured beside proved."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from lure.analysis.drawing import drawn
from lure.analysis.measured.mean_nonlinearity import BENT, MeanNonlinearity
from lure.analysis.measured.reading import SHOWN, Measurements
from lure.analysis.numerics.doubles import text_below
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector, SlopeBounds
from lure.errors import AssumptionError
from lure.record import Column, Page, Record, derived, plain, quantity, rounded

if TYPE_CHECKING:
    from lure.analysis.questions import StabilityBound
    from lure.plants.block import Plant
    from lure.record.values import Towards

# What measurements say about a sector, and on which assumptions.

_SIDES = ("lower", "upper", "slope_lower", "slope_upper")
_ASSUMED = (
    "each load is f(sigma) plus an independent normal error of mean 0 and standard deviation s0 + s1 |f|, unknown",
    "displacements have no error, or one whose effect on the load is part of that scatter",
    "{} f(0) = 0, continuous and affine between the knots",
)
MEMORY = (
    "Loading and unloading differ by more than noise: the element has memory, no memoryless nonlinearity describes it, "
    "and no "
    "criterion for memoryless nonlinearities (circle, Popov, Zames-Falb) applies."
)
TO_TRY = (
    "Sweep again at half the speed. If the loop becomes thinner, the element is viscous: measure the force against the "
    "velocity, and put the damping into the linear part. If it stays, it is backlash, friction or plasticity, which "
    "needs a model with memory; look for play in the mounting first."
)


class Bound(Record):
    """A bound with its confidence, the extreme of the fitted curve, and the ``sigma`` [m] that sets the bound."""

    bound: float = quantity("The bound")
    fitted: float = quantity("The extreme of the fitted nonlinearity")
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
    """Bounds on chords and slopes of a measured mean nonlinearity; assumptions: :func:`sector_from_data`."""

    measurements: Measurements = quantity("What they are about")
    confidence: float = quantity(
        "With which all four bounds hold at once, if the assumptions do and the nonlinearity is ``resolved``"
    )
    origin: float = quantity("Displacement [m] at which ``sigma = 0``")
    lower: Bound = quantity("Lower bound of ``f(sigma)/sigma``", "unit of the load / m")
    upper: Bound = quantity("Upper bound of the same", "unit of the load / m")
    slope_lower: Bound = quantity("Lower bound of the slope", "unit of the load / m")
    slope_upper: Bound = quantity("Upper bound of the slope", "unit of the load / m")
    nonlinearities: tuple[MeanNonlinearity, ...] = quantity(
        "The fitted nonlinearity; with hysteresis that of loading and that of unloading", key=""
    )
    outliers: tuple[Outlier, ...] = quantity("Readings left out")
    hysteresis: Hysteresis | None = quantity("Where the branches lie apart")
    warnings: tuple[str, ...] = quantity("Assumptions that the data contradict, and what was done")
    multipliers: tuple[float, ...] = quantity(
        "For each nonlinearity, how many standard errors the simultaneous intervals reach to either side", key=""
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
        """Whether twice as many pieces fit no better, of rows enough to see it; else the bounds are estimates alone."""
        return all(nonlinearity.resolved for nonlinearity in self.nonlinearities)

    @property
    def sparse(self) -> bool:
        """Whether it is not ``resolved`` because the rows are too few, and not because it was seen to bend."""
        return all(one.curved >= BENT for one in self.nonlinearities) and not self.resolved

    @property
    def stated(self) -> bool:
        """Whether the bounds are stated with the confidence: no loop was seen, and the nonlinearity is ``resolved``."""
        return self.memoryless and not self.doubt

    @property
    def doubt(self) -> str:
        """Why no confidence is stated where no loop was seen; empty where it is."""
        if any(nonlinearity.twofold for nonlinearity in self.nonlinearities):
            return "the readings lie in two groups, above and below one curve"
        if self.resolved:
            return ""
        if self.sparse:
            return "the rows are too few to see it bend within its pieces"
        return "the nonlinearity bends or jumps within its pieces, against what is assumed"

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
        nonlinearity = "f is one nonlinearity without memory,"
        if not self.memoryless:
            nonlinearity = "loading has one mean nonlinearity f, unloading another, each"
        elif not self.measurements.branches:
            nonlinearity = (
                "f is one nonlinearity without memory (a single sweep, or rows in no order, cannot show a loop),"
            )
        return (*_ASSUMED[:2], _ASSUMED[2].format(nonlinearity))

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
        if self.doubt:
            return (
                f"F{where[1:]}, the mean nonlinearity is estimated to {self._chords('lie')} and to have "
                f"{slopes}; no confidence is stated, since {self.doubt}, "
                "and nothing is known outside this range (observed, not proved)."
            )
        return (
            f"With {100 * self.confidence:g} % confidence, {where}, the mean nonlinearity {self._chords('lies')} and "
            f"has "
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
            f"Loading and unloading follow different nonlinearities: on {h.branches} branches there is a loop of area "
            f"{abs(h.dissipated):.3g} {data.area_unit}, {h.width:.3g} {data.unit} wide at u = {h.at:.3g} "
            f"{data.displacement_unit}, which is {100 * h.share:.3g} % of the largest load."
        )

    plot = drawn(
        "Data, nonlinearity with its band, sector and residuals; see :func:`lure.analysis.plots.plot_measured`."
    )

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data; infinite numbers are the text ``inf``."""
        nonlinearities = [
            {
                "knots": plain(nonlinearity.knots),
                "values": plain(nonlinearity.values),
                "noise": plain(nonlinearity.noise),
                "curved": nonlinearity.curved,
            }
            for nonlinearity in self.nonlinearities
        ]
        return super().to_dict() | {
            "confidence": self.confidence if self.stated else None,
            "unit": self.measurements.stiffness_unit,
            "laws": nonlinearities,
            "warnings": [*([MEMORY, TO_TRY] if self.hysteresis else []), *self.warnings],
        }

    def _columns(self) -> dict[str, Column]:
        """Rows with the fitted mean, its error and outliers, and the four bounds; nan on rows of the other branch."""
        data, of = self.measurements, ("row",)
        rows = [np.arange(len(data))] if self.memoryless else [data.rows("loading"), data.rows("unloading")]
        mean, error, score = (np.full(len(data), np.nan) for _ in range(3))
        for nonlinearity, part in zip(self.nonlinearities, rows, strict=True):
            sigma = data.displacement[part] - self.origin
            mean[part], error[part], score[part] = nonlinearity(sigma), nonlinearity.error(sigma), nonlinearity.scores
        outlier = np.zeros(len(data), dtype=bool)
        outlier[[one.index for one in self.outliers]] = True
        shift, unit, place = data.displacement - self.origin, data.stiffness_unit, data.displacement_unit
        sides, to = [getattr(self, name) for name in _SIDES], ("bound",)
        return data._columns() | {
            "sigma": Column(of, shift, place, "displacement less the origin"),
            "mean": Column(of, mean, data.unit, "fitted mean nonlinearity, of the branch where there are two"),
            "error": Column(of, error, data.unit, "standard error of the mean nonlinearity, for one place alone"),
            "score": Column(of, score, "1", "residual in standard deviations"),
            "outlier": Column(of, outlier, "1", "whether the row was left out"),
            "limit": Column(
                to, [side.bound for side in sides], unit, "bound on chords or slopes of the mean nonlinearity"
            ),
            "fitted": Column(to, [side.fitted for side in sides], unit, "extreme of the fitted nonlinearity"),
            "limit_at": Column(to, [side.at for side in sides], place, "sigma that sets the bound"),
            "bound": Column(to, np.array(_SIDES, dtype=object), "1", "of f(sigma)/sigma, or of the slope"),
        }

    def _attributes(self) -> dict[str, object]:
        return self.measurements._attributes() | {
            "title": "Sector of a measured nonlinearity",
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
        head = ("bound", f"{self.how_sure} [{unit}]", f"of the fitted nonlinearity [{unit}]", "set at sigma")
        notes = [self.conclusion, *([MEMORY, TO_TRY] if self.hysteresis else []), *self.warnings]
        notes += [*left_out(self.outliers), *(f"Assumed: {text}." for text in self.assumptions)]
        return Page(f"sector of {self.measurements.source}", rows, head, "OBSERVED", notes)

    def __str__(self) -> str:
        unit = self.measurements.unit
        lines = [self.conclusion]
        pieces = " and ".join(str(nonlinearity.knots.size - 1) for nonlinearity in self.nonlinearities)
        both = "" if self.memoryless else "to both mean branches, as an estimate: "
        chords = f"chords {self.lower.fitted:.4g} .. {self.upper.fitted:.4g}, " if self.bounded else ""
        lines.append(
            f"  fitted: {both}{chords}slopes {self.slope_lower.fitted:.4g} .. {self.slope_upper.fitted:.4g} "
            f"{self.measurements.stiffness_unit} on {pieces} pieces"
        )
        for nonlinearity in self.nonlinearities:
            lines.append(
                f"  noise: {nonlinearity.noise.constant:.3g} {unit} + {100 * nonlinearity.noise.proportional:.2g} % of "
                f"the load "
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


def _down(value: float | Fraction) -> str:
    return rounded(value, "below", 4)


def _up(value: float | Fraction) -> str:
    return rounded(value, "above", 4)


class MeasuredMargin(Record):
    """A measured sector beside the largest sector for which a loop is proved stable."""

    measured: MeasuredSector = quantity("The measurements", key="")
    sector: Sector = quantity(
        "What is compared: the measured bounds times ``gain``, its lower end raised to 0 if ``assume_nonnegative``",
        plainly=lambda sector: plain([float(sector.lower), float(sector.upper)]),
    )
    proved: StabilityBound = quantity(
        "The answer of :func:`lure.analysis.max_sector`: from the lower end of ``sector``, or 0 if that is above it"
    )
    gain: float = quantity("Unit of ``phi`` in the loop per unit of the load")
    assume_nonnegative: bool = quantity("Whether ``sigma phi(sigma) >= 0`` is the word of the user")

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: the chain is as strong as the measurements."""
        return Evidence.OBSERVED

    @property
    @derived()
    def margin(self) -> float:
        """By which share of its size the measured upper bound could grow up to the proved one; negative: not inside."""
        proved, measured = self.proved.largest.low, self.sector.upper
        if self.proved.verdict is not Verdict.PROVED:
            return -1.0
        if math.inf in (proved, measured):
            return math.inf if proved == math.inf else -1.0
        room = Fraction(proved) - Fraction(measured)
        return float(room / abs(Fraction(measured))) if measured else math.inf if room >= 0 else -1.0

    @property
    @derived()
    def inside(self) -> bool:
        """Whether the measured sector lies inside the proved one and the element showed no memory."""
        return self.measured.memoryless and self.proved.verdict is Verdict.PROVED and self.margin >= 0

    @property
    @derived()
    def conclusion(self) -> str:
        """What follows, and on which conditions."""
        if not self.measured.memoryless:
            return f"Nothing follows for the loop. {MEMORY}"
        if self.proved.verdict is not Verdict.PROVED:
            return self._not_proved
        proved = f"[{_up(self.proved.lower)}, {text_below(self.proved.largest.low, 6)}]"
        low, high = self.measured.domain
        if not self.inside:
            return (
                f"Nothing follows for the loop: the measured sector {_shown(self.sector)} is not inside the proved one "
                f"{proved}; that does not show that the loop is unstable."
            )
        word = " That the nonlinearity never has the wrong sign is assumed." if self.assume_nonnegative else ""
        where = f"for sigma in [{low:.4g}, {high:.4g}] {self.measured.measurements.displacement_unit}"
        share = "any amount" if self.margin == math.inf else f"{rounded(100 * self.margin, 'below', 3)} %"
        return (
            f"The measured sector {_shown(self.sector)} lies inside the proved one {proved}: its upper bound could "
            f"grow by {share}. The loop is therefore stable in the sense of the theorem if the nonlinearity stays in "
            f"the measured sector: observed {self.measured.how_sure} {where}, under the assumptions of the "
            f"measurement; outside that range it is assumed.{word}"
        )

    @property
    def _not_proved(self) -> str:
        """Why nothing is proved, and what the user may know that the measurements do not show."""
        said = f"Nothing follows for the loop: no sector from {float(self.proved.lower):.4g} upwards is proved stable"
        reason = self.proved.reason
        if self.assume_nonnegative or self.sector.lower >= 0 or "no linear gain" in reason:
            return said + (f" ({reason})." if reason else ".")
        reason = reason.partition("; give a lower gain")[0]  # the lower end is measured, not chosen
        return (
            said + (f" ({reason}). " if reason else ". ") + "The measured lower bound is below 0, and noise alone can "
            "do that. If you know that load and displacement never have opposite signs, sigma phi(sigma) >= 0, give "
            "assume_nonnegative=True: the sector then begins at 0, by your assumption."
        )

    def _page(self) -> Page:
        margin = "any amount" if math.isinf(self.margin) else f"{rounded(100 * self.margin, 'below', 3)} %"
        measured = _interval(float(self.sector.lower), float(self.sector.upper), ("below", "above"))
        rows = [
            ("measured, times gain", measured, self.evidence),
            ("proved stable", _interval(float(self.proved.lower), self.proved.largest.low), self.proved.evidence),
            ("room above the measured one", margin if self.inside else "-", ""),
        ]
        verdict, head = "INSIDE" if self.inside else "NOTHING FOLLOWS", ("sector", "", "evidence")
        return Page("measured sector beside the proved one", rows, head, verdict, (self.conclusion,))

    def __str__(self) -> str:
        return self.conclusion


def margin_from_data(
    measured: MeasuredSector,
    block: Plant | object,
    *,
    gain: float = 1.0,
    assume_nonnegative: bool = False,
    criterion: str = "best",
) -> MeasuredMargin:
    """Compare a measured sector with the largest one for which a loop is proved stable.

    ``sigma = H mu``, ``mu = -phi(sigma)`` with ``phi = gain * load`` and ``sigma`` the displacement [m] from the
    origin of the measurement.

    Parameters
    ----------
    measured : MeasuredSector
        From :func:`sector_from_data`.
    block : object
        The linear block, as :func:`lure.analysis.max_sector` takes it.
    gain : float
        Unit of ``phi`` in the loop per unit of the load, positive.
    assume_nonnegative : bool
        Take the user's word for ``sigma phi(sigma) >= 0``.  Noise alone puts the measured lower bound of a contact law
        a little below 0, and loops with a pole at 0 tolerate no negative chord.
    criterion : str
        As for :func:`lure.analysis.max_sector`.

    Returns
    -------
    MeasuredMargin
        The measured and the proved sector, the margin between them, and what follows.

    Raises
    ------
    AssumptionError
        The measured sector has no lower bound, be it for an offset or a loop, or the criterion does not apply.
    InputError
        The block or a number is no good.

    Examples
    --------
    >>> from lure.analysis.measured import example_measurements, sector_from_data
    >>> sector = sector_from_data(example_measurements())
    >>> found = margin_from_data(sector, ([1e4], [1, 300, 2e4, 0]), gain=0.005, assume_nonnegative=True)
    >>> found.inside
    True
    """
    from lure.analysis.questions import max_sector
    from lure.exact import exact_number

    exact = exact_number(gain, "gain")
    if exact <= 0:
        raise AssumptionError(f"gain is {float(exact):g}; give a positive number")
    low, high = measured.lower.bound, measured.upper.bound
    if assume_nonnegative:
        low = max(low, 0.0)
    if low == -math.inf and not measured.memoryless:
        raise AssumptionError(f"nothing follows for the loop: {MEMORY[0].lower()}{MEMORY[1:]}")
    if low == -math.inf:
        raise AssumptionError(
            "the measured sector has no lower bound, since the load does not vanish at sigma = 0; correct the offset "
            "or give another origin"
        )
    scaled = [bound if math.isinf(bound) else exact * Fraction(bound) for bound in (low, max(high, low))]
    upper = scaled[1] if scaled[1] > scaled[0] else math.inf
    lower = min(scaled[0], Fraction(0))
    proved = max_sector(block, criterion=criterion, lower=lower)
    return MeasuredMargin(
        measured=replace(measured),
        sector=Sector(scaled[0], upper),
        proved=proved,
        gain=float(exact),
        assume_nonnegative=assume_nonnegative,
    )


def _interval(low: float, high: float, towards: tuple[Towards, Towards] = ("above", "below")) -> str:
    """What is proved, rounded inwards, if not said otherwise."""
    return f"[{rounded(low, towards[0], 6)}, {rounded(high, towards[1], 6)}]"


def _shown(sector: Sector) -> str:
    return f"[{_down(sector.lower)}, {_up(sector.upper)}]"

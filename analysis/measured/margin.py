"""From a measured sector to a verdict on a loop: what is measured beside what is proved."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.measured.measured_sector import MEMORY, MeasuredSector
from lure.analysis.numerics.doubles import text_below
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector
from lure.errors import AssumptionError
from lure.record import Page, Record, derived, plain, quantity, rounded

if TYPE_CHECKING:
    from lure.analysis.questions import StabilityBound
    from lure.plants.block import Plant
    from lure.record.values import Towards


class MeasuredMargin(Record):
    """A measured sector beside the largest sector for which a loop is proved stable."""

    measured: MeasuredSector = quantity("The measurements", key="")
    sector: Sector = quantity(
        "What is compared: the measured bounds times ``gain``, with the lower one raised to 0 if ``vouched``",
        plainly=lambda sector: plain([float(sector.lower), float(sector.upper)]),
    )
    proved: StabilityBound = quantity(
        "The answer of :func:`lure.analysis.max_sector`: from the lower end of ``sector``, or 0 if that is above it"
    )
    gain: float = quantity("Unit of ``phi`` in the loop per unit of the load")
    vouched: bool = quantity("Whether ``sigma phi(sigma) >= 0`` is the word of the user")

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: the chain is as strong as the measurements."""
        return Evidence.OBSERVED

    @property
    @derived()
    def margin(self) -> float:
        """Largest proved upper bound over the measured one, less 1; negative where that is not inside."""
        if self.proved.verdict is not Verdict.PROVED or self.sector.upper == math.inf:
            return -1.0 if self.proved.largest.low < math.inf or self.proved.verdict is not Verdict.PROVED else math.inf
        if self.sector.upper <= 0:
            return math.inf
        return float(self.proved.largest.low / float(self.sector.upper)) - 1

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
        proved = f"[{float(self.proved.lower):.4g}, {text_below(self.proved.largest.low, 6)}]"
        low, high = self.measured.domain
        if not self.inside:
            return (
                f"Nothing follows for the loop: the measured sector {_shown(self.sector)} is not inside the proved one "
                f"{proved}; that does not show that the loop is unstable."
            )
        word = " It is the user's word that the law never has the wrong sign." if self.vouched else ""
        where = f"for sigma in [{low:.4g}, {high:.4g}] {self.measured.measurements.displacement_unit}"
        share = "any amount" if self.margin == math.inf else f"{100 * self.margin:.3g} %"
        return (
            f"The measured sector {_shown(self.sector)} lies inside the proved one {proved}: its upper bound could "
            f"grow by {share}. The loop is therefore stable in the sense of the theorem if the law stays in the "
            f"measured sector: observed {self.measured.how_sure} {where}, under the assumptions of the measurement; "
            f"outside that range it is assumed.{word}"
        )

    @property
    def _not_proved(self) -> str:
        """Why nothing is proved, and what the user may know that the measurements do not show."""
        said = f"Nothing follows for the loop: no sector from {float(self.proved.lower):.4g} upwards is proved stable"
        reason = self.proved.reason
        if self.vouched or self.sector.lower >= 0 or "no linear gain" in reason:
            return said + (f" ({reason})." if reason else ".")
        reason = reason.partition("; give a lower gain")[0]  # the lower end is measured, not chosen
        return (
            said + (f" ({reason}). " if reason else ". ") + "The measured lower bound is below 0, and noise alone can "
            "do that. If you know that load and displacement never have opposite signs, sigma phi(sigma) >= 0, give "
            "vouched=True: the sector then begins at 0, on your word."
        )

    def _page(self) -> Page:
        margin = "any amount" if math.isinf(self.margin) else f"{100 * self.margin:.3g} %"
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
    vouched: bool = False,
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
    vouched : bool
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
    >>> found = margin_from_data(sector, ([1e4], [1, 300, 2e4, 0]), gain=0.005, vouched=True)
    >>> found.inside
    True
    """
    from lure.analysis.questions import max_sector
    from lure.exact import exact_number

    exact = exact_number(gain, "gain")
    if exact <= 0:
        raise AssumptionError(f"gain is {float(exact):g}; give a positive number")
    low, high = measured.lower.bound, measured.upper.bound
    if vouched:
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
        measured=replace(measured), sector=Sector(scaled[0], upper), proved=proved, gain=float(exact), vouched=vouched
    )


def _interval(low: float, high: float, towards: tuple[Towards, Towards] = ("above", "below")) -> str:
    """What is proved, rounded inwards, if not said otherwise."""
    return f"[{rounded(low, towards[0], 6)}, {rounded(high, towards[1], 6)}]"


def _shown(sector: Sector) -> str:
    return f"[{float(sector.lower):.4g}, {float(sector.upper):.4g}]"

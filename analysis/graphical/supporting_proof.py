"""What the drawings share: the figure inside a page, the words for a range of frequencies, a number of the caller's."""

from __future__ import annotations

import hashlib
import html
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from lure.analysis.certificates.theory import theory_of
from lure.analysis.drawing import drawing, drawn
from lure.analysis.theorems.circle import circle_criterion
from lure.analysis.theorems.popov import popov_criterion
from lure.analysis.verdict import CriterionResult, Evidence, Verdict
from lure.classes import Sector
from lure.errors import InputError
from lure.exact import exact_number
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.record import Record, derived, quantity

if TYPE_CHECKING:
    import control

    from lure.analysis.drawing import Draw
    from lure.analysis.graphical.axis import Drawable
    from lure.analysis.questions import StabilityBound

# What the two responses share: the least value drawn, what stands behind the drawing, and its plain forms.

ROUNDING = 1e-11  # of the size of a curve: closer than this it touches


def least(distances: NDArray[np.float64]) -> int | None:
    """Where the least finite distance stands; None where there is none.

    ``distances``: (m,) distances, nan or infinite where there is nothing to see.
    """
    seen = np.where(np.isfinite(distances), distances, np.inf)
    return int(np.argmin(seen)) if np.isfinite(seen).any() else None


class Drawn(Record, ABC):
    """The base of both responses: a curve at finitely many frequencies, and what stands behind the region beside it."""

    block: Drawable = quantity(
        "The block", plainly=lambda block: block_text(block), form=lambda block: block_text(block)
    )
    omega: NDArray[np.float64] = quantity("frequency", "rad/s", dims="omega", key="omega")
    values: NDArray[np.complex128] = quantity("(m,) values of ``H``; nan where a pole is met", key="")
    k: float | None = quantity(
        "Upper end of the sector, possibly ``inf``; None where nothing is drawn beside the curve"
    )
    found: StabilityBound | None = quantity(
        "What :func:`lure.analysis.max_sector` says, where the sector was taken from it"
    )
    answer: CriterionResult | None = quantity(
        "What the criterion says of exactly this sector, where numbers of it were given"
    )
    reason: str = quantity("Why nothing stands behind what is drawn, or there is nothing; empty where something does")
    _said = "sentence"
    _criterion: ClassVar[str] = ""
    _drawn: ClassVar[tuple[str, ...]] = ()
    _no_truth = "a drawing proves nothing; look at response.answer or response.found"

    @property
    @derived("1", dims="omega", key="real")
    def real(self) -> NDArray[np.float64]:
        """(m,) Re H."""
        return self.values.real

    @property
    @derived("1", dims="omega", key="imag")
    def imag(self) -> NDArray[np.float64]:
        """(m,) Im H."""
        return self.values.imag

    @property
    @abstractmethod
    def distances(self) -> NDArray[np.float64]:
        """(m,) distance of each point from what is forbidden, negative inside it; nan where there is none."""

    @property
    def worst(self) -> int | None:
        """Where in ``omega`` the least of them stands; None where there is none."""
        return least(self.distances)

    @property
    @derived()
    def margin_seen(self) -> float | None:
        """Least of them over the points drawn, negative where the curve enters what is forbidden: OBSERVED."""
        return None if self.worst is None else float(self.distances[self.worst])

    @property
    @derived("rad/s")
    def worst_seen(self) -> float | None:
        """The frequency at which it is seen."""
        return None if self.worst is None else float(self.omega[self.worst])

    @property
    @derived()
    def evidence(self) -> Evidence:
        """OBSERVED: what a drawing is.  See ``answer`` and ``found`` for what is proved."""
        return Evidence.OBSERVED

    @property
    @abstractmethod
    def sector_text(self) -> str:
        """The sector, for people, never larger than it is."""

    @property
    def support(self) -> tuple[bool, str]:
        """Whether something proves the sector, and what it is, or why nothing does."""
        answer, found = self.answer, self.found
        if answer is not None and answer.verdict is Verdict.PROVED and not self.reason:
            return True, f"{self._criterion} for the sector {self.sector_text} ({answer.evidence}): {answer.reason}"
        if found is not None and found.verdict is Verdict.PROVED and not self.reason:
            return True, str(found).removesuffix(".")
        return False, self.reason.removesuffix(".")

    @property
    def supporting_proof(self) -> str:
        """What proves the sector, or that nothing here does, and why."""
        proved, words = self.support
        return f"what does: {words}" if proved else f"nor does anything here: {words}"

    plot = drawn("The curve, what is forbidden to it, the sector and the least distance seen.")

    def to_control(self) -> control.FrequencyResponseData:
        """The values drawn as a ``control.FrequencyResponseData``."""
        import control

        return control.FrequencyResponseData(self.values, self.omega, dt=float(self.block.dt or 0))

    def _attributes(self) -> dict[str, object]:
        numbers = {name: getattr(self, name) for name in (*self._drawn, "margin_seen")}
        known = {name: value for name, value in numbers.items() if value is not None}
        return {**known, "evidence": str(self.evidence), "comment": str(self)}

    @property
    def _verdict(self) -> str:
        return str(self.evidence).upper()

    def _region(self) -> Iterator[tuple[object, ...]]:
        """The rows on what is drawn beside the curve."""
        yield "sector", self.sector_text

    def _rows(self) -> Iterator[tuple[object, ...]]:
        yield "block", block_text(self.block)
        yield "drawn", span_text(self.omega)
        yield from self._region()
        if self.margin_seen is not None:
            yield "least distance seen", f"{self.margin_seen:.6g}"
        proved, words = self.support
        yield "what proves it", words if proved else f"nothing here: {words}"

    def _repr_html_(self) -> str:
        return with_figure(lambda *, ax: self.plot(ax), super()._repr_html_(), alt=f"{self._title}: {self}")


# A Popov multiplier for a curve that is only drawn: the line with the most room, of those the simplest.

_HALVINGS = 60
_ANY = 1e-4  # of the size of the curve: where 1/k = 0, all room vanishes at infinity
Floats = NDArray[np.float64]


def searched_theta(x: Floats, y: Floats, k: float) -> float:
    r"""The ``theta`` nearest to 0 for which the points keep half of the best room from the line, or the best there is.

    The room is ``min_i (1/k + x_i - theta y_i)``, concave and piecewise linear in ``theta``; its maximum is found by
    halving, to about twice the rounding error.  Where some ``theta`` leaves room, the line returned leaves at least
    half of the most (for ``k = inf`` any); where none does, it falls short by the least.

    ``x``, ``y``: (m,) ``Re H`` and ``omega Im H`` at the points drawn, finite; ``k``: upper end of the sector, positive
    or ``inf``.

    Returns
    -------
    float
        ``theta`` [s], of either sign; for ``k = inf`` not negative, as Popov's theorem asks.
    """
    inverse_gain = 0.0 if np.isinf(k) else 1.0 / k
    start = float(np.min(x)) + inverse_gain  # theta = 0 leaves that much
    low, high = start, max(start, inverse_gain or float(np.max(np.abs(x))))
    if start < high and _window(x, y, inverse_gain - high, k) is None:
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if _window(x, y, inverse_gain - middle, k) is None:
                high = middle
            else:
                low = middle
        best = low
    else:
        best = high
    level = max(start, (_ANY if np.isinf(k) else 0.5) * best) if best > 0 else best
    left, right = _window(x, y, inverse_gain - level, k) or (0.0, 0.0)
    return min(max(0.0, left), right)


def _window(x: Floats, y: Floats, inverse_gain: float, k: float) -> tuple[float, float] | None:
    """All ``theta`` with ``inverse_gain + x - theta y >= 0`` at every point, None if there are none."""
    room = x + inverse_gain
    if bool((room[y == 0] < 0).any()):
        return None
    up, down = y > 0, y < 0
    with np.errstate(over="ignore"):  # a point with y next to nothing asks for nothing that doubles could say
        right = float(np.min(room[up] / y[up])) if up.any() else np.inf
        left = float(np.max(room[down] / y[down])) if down.any() else -np.inf
    left = max(left, 0.0) if np.isinf(k) else left
    return (left, right) if left <= right and np.isfinite(min(max(0.0, left), right)) else None


_LONGEST = 160


def criterion_asked(
    block: RationalPlant | StructuredPlant, criterion: str, sector: Sector, theta: Fraction | None = None
) -> tuple[CriterionResult, str]:
    """What a criterion says of one sector, and why nothing rests on that; empty where something does.

    ``theta``: Popov's multiplier [s]; None for the best one.

    Raises
    ------
    AssumptionError, InputError
        As the criterion.
    """
    if isinstance(block, RationalPlant):
        asked = (
            circle_criterion(block, sector) if criterion == "circle" else popov_criterion(block, sector, theta=theta)
        )
        return asked, "" if asked.verdict is Verdict.PROVED else asked.reason
    theory = theory_of(block)
    answer = theory.inequality(criterion, sector, None if theta is None else float(theta))
    return answer, "" if answer.verdict is Verdict.PROVED else answer.reason


def with_figure(draw: Draw, table: str, *, alt: str) -> str:
    """A figure as inline SVG, on white, above a table.

    Parameters
    ----------
    draw : callable
        Draws on the axes it is given as ``ax``.
    table : str
        HTML.
    alt : str
        What the figure shows, for who cannot see it; also what its identifiers are salted with.
    """
    name = "figure-" + hashlib.sha256((alt + table).encode()).hexdigest()[:12]
    svg: str = drawing(draw, task="file")(draw, name=name, size=(5.4, 3.8), suffixes=[".svg"]).svg
    label = f'role="img" aria-label="{html.escape(alt)}" style="max-width:100%;height:auto"'
    svg = svg[svg.index("<svg") :].replace("<svg", f"<svg {label}", 1)
    return f'<figure style="margin:0;max-width:40em">{svg}</figure>{table}'


def block_text(block: Drawable) -> str:
    """The block in a few words: its formula if that is short."""
    if isinstance(block, RationalPlant | DelayPlant):
        text = str(block)
        return f"H = {text}" if len(text) <= _LONGEST else f"H of order {len(block.denominator) - 1}"
    if isinstance(block, FrequencyData):
        return "a measured response"
    return block.name if isinstance(block, StructuredPlant) else str(block)


def span_text(omega: NDArray[np.float64]) -> str:
    """Where a curve was evaluated; ``omega``: (m,) frequencies [rad/s]."""
    return f"at {omega.size} frequencies from {omega[0]:.4g} to {omega[-1]:.4g} rad/s"


def bound(value: object, name: str) -> float | Fraction:
    """A bound of a sector as it is given, exact unless it is ``inf``.

    ``value``: a number; ``name``: what it is, for the error.

    Raises
    ------
    InputError
        It is no number.
    """
    if isinstance(value, float) and value == math.inf:
        return value
    return exact_number(value, name)


def upper_end(k: object, lower: Fraction) -> float | Fraction:
    """The upper end of a sector, which lies above the lower one; ``k``: a number.

    Raises
    ------
    InputError
        It is no number, or does not lie above.
    """
    end = bound(k, "k")
    if end <= lower:
        raise InputError(f"k is {float(end):g}; give the upper end of a sector, above its lower end {float(lower):g}")
    return end

"""What is found of a nonlinearity: bounds on its chords and slopes from both sides, and where they are attained."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, TypeAlias

from lure.analysis.drawing import drawing
from lure.analysis.numerics.doubles import text_above, text_below
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import Sector, SlopeBounds
from lure.errors import AssumptionError
from lure.exact import nearest_double
from lure.record import Column, Page, Record, quantity
from lure.record.values import exact_text

if TYPE_CHECKING:
    from lure.analysis.drawing import Axes

_SIDES = ("sector_lower", "sector_upper", "slope_lower", "slope_upper")


Bound: TypeAlias = Fraction | float
"""A Fraction, or a float that is an infinity."""
Place: TypeAlias = Fraction | tuple[Fraction, Fraction] | str
"""A point, an interval that contains one, or in words: ``"sigma -> 0+"``, ``"sigma -> inf"``, ``"a jump at 1"``."""
Quantity = Literal["sector", "slope"]
_LARGEST = 1.7976931348623157e308
QUANTITIES: tuple[Quantity, ...] = ("sector", "slope")


def _json(value: Bound) -> dict[str, object] | str:
    """An exact number as text beside the nearest double, an infinity as text."""
    if isinstance(value, float):
        return "inf" if value > 0 else "-inf"
    try:
        nearest: object = float(value)
    except OverflowError:
        nearest = None
    return {"exact": str(value), "double": nearest}


def _places(at: Place) -> object:
    return at if isinstance(at, str) else [_json(x) for x in ([at] if isinstance(at, Fraction) else at)]


class Extreme(Record):
    """A least or largest value over all ``sigma`` of the domain, enclosed."""

    inner: Bound = quantity(
        "What is reached or approached (inf or -inf for growth without bound), or beyond it", plainly=_json
    )
    outer: Bound = quantity(
        "What no value passes; the true bound lies between ``inner`` and ``outer``, which are equal where it is exact",
        plainly=_json,
    )
    at: Place = quantity(
        "Where ``inner`` is reached or approached: a point, an interval that contains one, or words", plainly=_places
    )
    attained: bool = quantity(
        "Whether it is known that the nonlinearity takes the bound at a point, rather than approaches it"
    )

    @property
    def exact(self) -> bool:
        """Whether the bound is known exactly."""
        return self.inner == self.outer

    @property
    def gap(self) -> float:
        """``|outer - inner|``; 0 where both are the same infinity, inf where one is infinite."""
        if self.inner == self.outer:
            return 0.0
        if math.inf in (abs(self.inner), abs(self.outer)):
            return math.inf
        return abs(nearest_double(Fraction(self.outer) - Fraction(self.inner)))

    @property
    def where(self) -> str:
        """The place in words."""
        if isinstance(self.at, str):
            return f"as {self.at}" if "->" in self.at else self.at
        point = self.at if isinstance(self.at, Fraction) else (self.at[0] + self.at[1]) / 2
        return f"at sigma = {exact_text(point, 10)}" if self.attained else f"near sigma = {exact_text(point, 10)}"

    @property
    def known(self) -> str:
        """How well it is known, in words."""
        if self.exact:
            return "exact"
        return f"to within {self.gap:.1e}" if math.isfinite(self.gap) else "no bound is shown"

    @property
    def cells(self) -> tuple[str, str, str]:
        """Value, place and how well it is known, for tables."""
        return exact_text(self.inner, 10), self.where, self.known

    def _page(self) -> Page:
        names = ("value", "where", "known", "attained")
        rows = [*zip(names, (*self.cells, "yes" if self.attained else "no"), strict=True)]
        return Page("least or largest value", rows)

    def __str__(self) -> str:
        return f"{exact_text(self.inner, 10)} {self.where}"


class NonlinearityBounds(Record):
    """Sector and slope bounds of one nonlinearity on one domain."""

    nonlinearity: str = quantity("The nonlinearity in words")
    sector_lower: Extreme = quantity("Infimum of ``phi(sigma)/sigma`` over the ``sigma != 0`` of the domain")
    sector_upper: Extreme = quantity("Supremum of the same")
    slope_lower: Extreme | None = quantity(
        "Infimum of ``(phi(x) - phi(y))/(x - y)`` over the domain; None where nothing was shown or asked"
    )
    slope_upper: Extreme | None = quantity("Supremum of the same; None likewise")
    evidence: Evidence = quantity(
        "CERTIFIED: every ``outer`` was shown in exact or ball arithmetic, under ``assumptions``. OBSERVED: a "
        "sample; then every ``outer`` is infinite, since a sample bounds nothing between its points"
    )
    on: tuple[Fraction, Fraction] | None = quantity(
        "The closed interval, None for all real numbers", plainly=lambda on: on and _places(on)
    )
    assumptions: tuple[str, ...] = quantity(
        "What the user vouches for, in sentences; empty where nothing is assumed", default=()
    )
    notes: tuple[str, ...] = quantity("What was not shown, in sentences", default=())

    @property
    def sector(self) -> Sector:
        """The smallest sector of doubles or exact numbers that contains it; a sampled one holds the sample only.

        Of a straight line both bounds are its gain: :meth:`lure.classes.Sector.line`, which no theorem takes.
        """
        lower, upper = self._outer(self.sector_lower, self.sector_upper)
        return Sector.line(Fraction(lower)) if lower == upper else Sector(lower, upper)

    @property
    def slope(self) -> SlopeBounds:
        """The smallest slope bounds, as for ``sector``.

        Raises
        ------
        AssumptionError
            No slope bounds were found; the message says why.
        """
        if self.slope_lower is None or self.slope_upper is None:
            why = f": {self.notes[0]}" if self.notes else ""
            raise AssumptionError(f"the nonlinearity {self.nonlinearity:.60} has no slope bounds that were shown{why}")
        lower, upper = self._outer(self.slope_lower, self.slope_upper)
        return SlopeBounds.line(Fraction(lower)) if lower == upper else SlopeBounds(lower, upper)

    def within(self, bounds: Sector | SlopeBounds) -> Verdict:
        """Whether the nonlinearity lies within a sector or slope bounds on its domain.

        PROVED needs certified evidence (under ``assumptions``, if there are any); REFUTED means that some chord slope,
        or difference quotient, passes a bound: ask :func:`lure.analysis.nonlinearity.violation` for one.
        """
        low, high = self.extremes("sector" if isinstance(bounds, Sector) else "slope")
        if low is None or high is None:
            return Verdict.INCONCLUSIVE
        if low.inner < bounds.lower or high.inner > bounds.upper:
            return Verdict.REFUTED
        if self.evidence is Evidence.CERTIFIED and low.outer >= bounds.lower and high.outer <= bounds.upper:
            return Verdict.PROVED
        return Verdict.INCONCLUSIVE

    def _columns(self) -> dict[str, Column]:
        """The four bounds along ``bound``: nearest doubles, and where they are reached."""
        sides = [getattr(self, name) for name in _SIDES]
        unit, of = "unit of phi / unit of sigma", ("bound",)
        inner = [math.nan if side is None else nearest_double(side.inner) for side in sides]
        outer = [math.nan if side is None else nearest_double(side.outer) for side in sides]
        attained = [side is not None and side.attained for side in sides]
        at = ["" if side is None else side.where for side in sides]
        reached = "what is reached or approached, nearest double; nan where nothing was shown"
        return {
            "inner": Column(of, inner, unit, reached),
            "outer": Column(of, outer, unit, "what no value passes, nearest double; infinite for a sample"),
            "attained": Column(
                of, attained, " 1", "whether it is known that the nonlinearity takes the bound at a point"
            ),
            "at": Column(of, at, "1", "where inner is reached or approached, in words"),
            "bound": Column(of, _SIDES, "1", "of phi(sigma)/sigma, or of difference quotients"),
        }

    def _attributes(self) -> dict[str, object]:
        comment = "Nearest doubles of the bounds; to_dict has the exact numbers, and sector and slope round outwards."
        return {
            "law": self.nonlinearity,
            "domain": self._domain,
            "evidence": str(self.evidence),
            "assumptions": "; ".join(self.assumptions),
            "notes": "; ".join(self.notes),
            "comment": comment,
        }

    def _page(self) -> Page:
        rows = []
        for name in _SIDES:
            side: Extreme | None = getattr(self, name)
            cells = ("not shown", "", "") if side is None else side.cells
            if side is not None and self.evidence is Evidence.CERTIFIED:
                cells = (stated(side, -1 if "lower" in name else 1, certified=True), *cells[1:])
            rows.append((name.replace("_", ", "), *cells))
        given = [f"Assumed: {text}." for text in self.assumptions]
        sampled = ["A sample bounds nothing between its points."] if self.evidence is Evidence.OBSERVED else []
        head, notes = ("bound", "value", "where", "known"), (*given, *self.notes, *sampled)
        return Page(f"{self.nonlinearity}, {self._domain}", rows, head, str(self.evidence).upper(), notes)

    @property
    def _domain(self) -> str:
        return "all real sigma" if self.on is None else f"sigma in [{exact_text(self.on[0])}, {exact_text(self.on[1])}]"

    def plot(self, nonlinearity: object, *, ax: Axes | None = None) -> Axes:
        """The nonlinearity with the wedge of its sector; see :func:`lure.analysis.plots.plot_nonlinearity_sector`.

        Parameters
        ----------
        nonlinearity : nonlinearity of lure.nonlinearities, Expression, str or callable
            The nonlinearity that was bounded: the bounds know its name only.
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        made: Axes = drawing(self)(nonlinearity, self, ax=ax)
        return made

    def __str__(self) -> str:
        return "\n".join(self.lines(*QUANTITIES))

    def lines(self, *quantities: Quantity) -> list[str]:
        """What was found of the sector, the slopes or both, in lines."""
        domain = "" if self.on is None else f" for sigma in [{exact_text(self.on[0])}, {exact_text(self.on[1])}]"
        given = f", given that {'; '.join(self.assumptions)}" if self.assumptions else ""
        lines = [f"{self.nonlinearity}{domain} ({self.evidence}{given})"]
        for name in quantities:
            low, high = self.extremes(name)
            if low is None or high is None:
                lines.append(f"  {name}  not shown")
                continue
            certified = self.evidence is Evidence.CERTIFIED
            lines.append(f"  {name} [{stated(low, -1, certified=certified)}, {stated(high, 1, certified=certified)}]")
            sides = (("lower", low), ("upper", high))
            lines += [f"    {side} {_told(found, certified=certified)}" for side, found in sides]
        others = [f"the {name} bound" for name in QUANTITIES if name not in quantities]
        return [*lines, *(f"  {note}" for note in self.notes if not any(note.startswith(other) for other in others))]

    def extremes(self, quantity: Quantity) -> tuple[Extreme | None, Extreme | None]:
        """The least and the largest value of one of the two."""
        if quantity == "sector":
            return self.sector_lower, self.sector_upper
        return self.slope_lower, self.slope_upper

    def _outer(self, low: Extreme, high: Extreme) -> tuple[Bound, Bound]:
        shown = self.evidence is Evidence.CERTIFIED
        lower = below(low.outer if shown else low.inner, exact=low.exact or not shown)
        upper = above(high.outer if shown else high.inner, exact=high.exact or not shown)
        return lower, upper


def below(value: Bound, *, exact: bool = False) -> Bound:
    """The number itself if it is exact and a double can stand for it, else the largest double not above it."""
    return _double(value, -math.inf, exact=exact)


def above(value: Bound, *, exact: bool = False) -> Bound:
    """The number itself if it is exact and a double can stand for it, else the least double not below it."""
    return _double(value, math.inf, exact=exact)


def _double(value: Bound, towards: float, *, exact: bool) -> Bound:
    if isinstance(value, float):
        return value
    try:
        nearest = float(value)
    except OverflowError:
        return towards if (value > 0) == (towards > 0) else Fraction(1 if value > 0 else -1) * Fraction(_LARGEST)
    if nearest == value or (exact and nearest != 0):
        return value
    beyond = nearest > value if towards > 0 else nearest < value
    found = nearest if beyond else math.nextafter(nearest, towards)
    return Fraction(found) if math.isfinite(found) else found


def stated(found: Extreme, side: int, *, certified: bool) -> str:
    """A bound for people, ten digits: one that holds, rounded outwards; of a sample, what was seen.

    Parameters
    ----------
    found : Extreme
        The bound.
    side : {-1, 1}
        -1 for a lower bound, 1 for an upper one.
    certified : bool
        Whether ``outer`` was shown.
    """
    value = found.outer if certified else found.inner
    text = exact_text(value, 10)
    if not certified or isinstance(value, float) or "/" in text or Fraction(text) == value:
        return text
    return text_below(value) if side < 0 else text_above(value)


def _told(found: Extreme, *, certified: bool) -> str:
    if found.exact:
        word = "attained" if found.attained else "approached"
        return f"{word} {found.where}" if "->" in str(found.at) or not isinstance(found.at, str) else found.where
    if isinstance(found.outer, float):
        value = f"{exact_text(found.inner, 10)} " if certified else ""  # else it is in the line above
        return f"{value}seen {found.where}; no bound is shown"
    return f"{found.where}, known to within {found.gap:.1e}"

"""Whether a given nonlinearity belongs to a class: what was checked, what is only declared, and what is false."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from enum import Enum
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal, TypeVar

from lure.analysis.nonlinearity.bounds import bounds_of_known, cuts_of, has_values, jumps_of, nonlinearity_bounds
from lure.analysis.nonlinearity.pieces import Known, Piece, Value, known_nonlinearity
from lure.analysis.nonlinearity.rational import BITS, Candidate, TooLarge
from lure.analysis.nonlinearity.result import Bound, Extreme, NonlinearityBounds, above, below, stated
from lure.analysis.nonlinearity.search import Effort, NotEnclosed
from lure.analysis.nonlinearity.shape import ZeroSet, known_odd, zero_set
from lure.analysis.nonlinearity.violations import Violation, violation
from lure.analysis.numerics.precision import working_precision
from lure.analysis.verdict import Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.expressions.regularity import nature
from lure.nonlinearities import (
    ExpressionNonlinearity,
    MovedNonlinearity,
    Properties,
    Property,
    Provenance,
    Quantiser,
    ShiftedNonlinearity,
    check_declared,
    properties,
    shifted_class,
)
from lure.nonlinearities import nonlinearity_class as smallest_class
from lure.nonlinearities.base import NamedNonlinearity, Nonlinearity
from lure.nonlinearities.formula import VARIABLE
from lure.nonlinearities.properties import nonlinearity_text, require_given_alone
from lure.nonlinearities.reading import as_nonlinearity
from lure.nonlinearities.shifted import shifted_bound
from lure.record import described, quantity
from lure.record.values import exact_text

T = TypeVar("T")
Name = Literal["sector", "slope", "odd", "time-invariance", "regularity"]
Regularity = Literal["locally Lipschitz", "continuous", "none", "unknown"]
_EFFORT = 40_000.0  # about two seconds
_WIDEST = 100
_WORD = "the word of whoever gave it"
_QUANTITIES = {"sector": "phi(sigma)/sigma", "slope": "(phi(x) - phi(y))/(x - y)"}
_TRIED = tuple(Fraction(n, d) for n, d in ((1, 1), (1, 2), (2, 1), (1, 10), (10, 1), (3, 7), (1, 100), (37, 10)))


class Status(Enum):
    """How a property of a nonlinearity is known."""

    CHECKED = "checked"
    DECLARED = "declared"
    VIOLATED = "violated"

    def __str__(self) -> str:
        return self.value


@described(frozen=True, kw_only=True, slots=True)
class MemberProperty:
    """One property that a class demands, for one nonlinearity."""

    name: Name = quantity("The property")
    status: Status = quantity(
        "CHECKED: shown for every ``sigma``.  DECLARED: neither shown nor disproved; it is the word of whoever gave "
        "the nonlinearity, or asked about a class that contains it.  VIOLATED: shown to be false"
    )
    how: str = quantity("How it is known, in one sentence without a full stop")
    points: tuple[Fraction, ...] = quantity(
        "Of a violation: ``sigma``, or two between which the difference quotient leaves the slope bounds", default=()
    )
    value: Bound | None = quantity("Of a violation: the value found there", default=None)
    bound: Bound | None = quantity("Of a violation: the bound of the class that it passes", default=None)
    certified: Bound | None = quantity(
        "Of a violation of a sector or of slope bounds: the certified bound, which no value passes", default=None
    )

    def __str__(self) -> str:
        return f"{self.name} ({self.status}: {self.how})"


@described(frozen=True, kw_only=True, slots=True)
class Membership:
    """What is known of one nonlinearity as a member of one class."""

    nonlinearity: str = quantity("The nonlinearity in words")
    nonlinearity_class: NonlinearityClass = quantity("The class")
    properties: tuple[MemberProperty, ...] = quantity(
        "The sector; slope, oddness and time-invariance where the class demands them"
    )
    regularity: Regularity = quantity(
        "The most that is known or declared: ``none`` is one that jumps, ``unknown`` one of which nothing is known"
    )
    regularity_property: MemberProperty = quantity(
        "Whether the regularity was checked, or is declared; VIOLATED for a declaration that is false"
    )
    zeros: ZeroSet | None = quantity("Every ``sigma`` with ``phi(sigma) = 0``, None where the set is not known")

    @property
    def status(self) -> Status:
        """VIOLATED if a property of the class is false, CHECKED if all were shown; the regularity is not among them."""
        statuses = {known.status for known in self.properties}
        return next((s for s in (Status.VIOLATED, Status.DECLARED) if s in statuses), Status.CHECKED)

    @property
    def violated(self) -> MemberProperty | None:
        """The first property that is false, None if there is none."""
        every = (*self.properties, self.regularity_property)
        return next((known for known in every if known.status is Status.VIOLATED), None)

    @property
    def declared(self) -> tuple[MemberProperty, ...]:
        """The properties of the class that are only declared."""
        return tuple(known for known in self.properties if known.status is Status.DECLARED)

    def regular(self, needed: Literal["locally Lipschitz", "continuous", "none"]) -> Status:
        """Whether the nonlinearity is as regular as a theorem needs.

        Parameters
        ----------
        needed : {"locally Lipschitz", "continuous", "none"}
            What the theorem assumes.

        Returns
        -------
        Status
            VIOLATED also where nothing is known or declared of the regularity: then the theorem may not be used.
        """
        order = {"none": 0, "unknown": 0, "continuous": 1, "locally Lipschitz": 2}
        if order[self.regularity] < order[needed]:
            return Status.VIOLATED
        return Status.CHECKED if needed == "none" else self.regularity_property.status

    def __str__(self) -> str:
        return f"{self.nonlinearity}: {self.status} member of the class of all {self.nonlinearity_class}"


@described(frozen=True, kw_only=True, slots=True)
class Examined:
    """A given nonlinearity after its declarations were put to the test, and the class that is asked about it."""

    nonlinearity: Nonlinearity = quantity(
        "The nonlinearity; a formula that declares no sector carries the certified one here"
    )
    nonlinearity_class: NonlinearityClass = quantity(
        "The class given, else the smallest that the nonlinearity is declared or known to belong to"
    )
    membership: Membership = quantity(
        "What is known of the nonlinearity as a member of this class; nothing in it is VIOLATED"
    )


def examined(nonlinearity: object, nonlinearity_class: NonlinearityClass | None = None) -> Examined:
    """A nonlinearity as an analysis takes it: what it declares is tested, what it leaves out is certified.

    Parameters
    ----------
    nonlinearity : Nonlinearity, or control.saturation_nonlinearity
        The nonlinearity.
    nonlinearity_class : NonlinearityClass, optional
        The class asked about; by default that of the nonlinearity.

    Raises
    ------
    InputError
        A declaration is false: the message names the point, the value and the certified bound.  Or the formula has no
        value somewhere, or declares no sector and none was certified.
    AssumptionError
        A sample contradicts what is declared of a function that is known by its values alone.
    """
    phi = _with_certified(as_nonlinearity(nonlinearity))
    own = _declared_class(phi)
    found = membership(phi, own)
    _demand_true(found, "declared to have", "declare what holds")
    if found.status is not Status.CHECKED:
        _sampled(phi)
    if nonlinearity_class is not None and nonlinearity_class != own:
        found = membership(phi, nonlinearity_class)
        _demand_true(found, "asked about in a class with", "give a class that contains it")
    if type(phi) is ExpressionNonlinearity and found.regularity == "locally Lipschitz" and not phi.locally_lipschitz:
        said: dict[str, Any] = {"sector": phi.sector, "slope_bounds": phi.slope_bounds, "odd": phi.odd}
        phi = ExpressionNonlinearity(phi.text, locally_lipschitz=True, **said)
    asked = own if nonlinearity_class is None else nonlinearity_class
    return Examined(nonlinearity=phi, nonlinearity_class=asked, membership=found)


def require_members(nonlinearities: Iterable[Nonlinearity], classes: Iterable[NonlinearityClass]) -> None:
    """Refuse a nonlinearity that lies outside of the class that is given for it, as one of constant gains.

    Raises
    ------
    InputError
        The message names both, and a point where there is one.
    """
    for one, own in zip(nonlinearities, classes, strict=False):
        require_given_alone(own)
        examined(one, own)


def _declared_class(phi: Nonlinearity) -> NonlinearityClass:
    try:
        return smallest_class(phi)
    except AssumptionError:  # its exact graph contradicts what it declares, which membership then says with a point
        sector, slope = phi.sector, getattr(phi, "slope_bounds", None)
        if slope is not None:
            sector = Sector(max(sector.lower, slope.lower), min(sector.upper, slope.upper))
        return NonlinearityClass(sector=sector, slope=slope, odd=bool(getattr(phi, "odd", False)))


def _sampled(phi: Nonlinearity) -> None:
    """Refuse what a sample disproves: of a formula it is confirmed in balls, and so an error of the input."""
    try:
        check_declared(phi)
    except AssumptionError as error:
        if isinstance(phi, ExpressionNonlinearity):
            raise InputError(str(error), code=error.code) from None
        raise


def _demand_true(found: Membership, words: str, fix: str) -> None:
    known = found.violated
    if known is None:
        return
    asked = found.nonlinearity_class
    what = {
        "sector": f"the sector {asked.sector}",
        "slope": f"the slope bounds {asked.slope}",
        "odd": "the property odd",
        "time-invariance": "no dependence on time",
        "regularity": "the property locally Lipschitz",
    }[known.name]
    raise InputError(f"the nonlinearity {found.nonlinearity!r:.60} is {words} {what}, but {known.how}; {fix}")


def _with_certified(phi: Nonlinearity) -> Nonlinearity:
    """A formula that declares no sector, with the sector, slope bounds and oddness that are certified."""
    if type(phi) is MovedNonlinearity:
        return MovedNonlinearity(_with_certified(phi.nonlinearity), phi.at, phi.within)
    if type(phi) is not ExpressionNonlinearity or phi.sector_declared or phi.sector != Sector(-math.inf, math.inf):
        return phi
    if phi.graph is not None and phi.graph.is_line:
        raise InputError(f"the nonlinearity {phi.text!r:.60} is a straight line; a linear gain belongs into the block")
    found = certified_bounds(phi)
    if found is None or _loose(found.sector_lower, found.sector_upper):
        raise InputError(
            f"the nonlinearity {phi.text!r:.60} declares no sector, and none could be certified; declare one, such as "
            "sector = [0, 5]"
        )
    low, high = _shown(found, "sector")
    least, most = found.slope_lower, found.slope_upper
    slope = None if least is None or most is None or _loose(least, most) else found.slope
    if slope is not None and slope.upper - slope.lower > _WIDEST * (high - low):
        slope = None  # no criterion gains from them, and the question would be put for a class beyond all interest
    odd = phi.odd or bool(known_odd(phi.expression, VARIABLE))
    said: dict[str, Any] = {"sector": Sector(below(low), above(high)), "slope_bounds": slope, "odd": odd}
    return ExpressionNonlinearity(phi.text, locally_lipschitz=phi.locally_lipschitz, **said)


def _loose(low: Extreme, high: Extreme) -> bool:
    """Whether bounds were given up far from the values seen."""
    size = max((abs(end.inner) for end in (low, high) if isinstance(end.inner, Fraction)), default=Fraction(0))
    return low.gap > size or high.gap > size


def membership(nonlinearity: object, nonlinearity_class: NonlinearityClass) -> Membership:
    """What is known of a nonlinearity as a member of a class, each property with its provenance.

    Parameters
    ----------
    nonlinearity : Nonlinearity, or control.saturation_nonlinearity
        Nonlinearities of the library are compared in closed form; formulas are bounded over all of R in exact or ball
        arithmetic, with a limited effort; a function of the user's is declared.
    nonlinearity_class : NonlinearityClass
        The class.

    Raises
    ------
    InputError
        It is no memoryless nonlinearity, or its formula has no value somewhere.

    Notes
    -----
    CHECKED means shown for every ``sigma``.  A formula for which neither side could be shown stays DECLARED.

    Examples
    --------
    >>> from lure import ExpressionNonlinearity, Saturation
    >>> print(membership(Saturation(gain=2), NonlinearityClass.slope_restricted(0, 2, odd=True)))
    saturation min(max(2 sigma, -1), 1): checked member of the class of all odd phi with slope in [0, 2]
    >>> steep = ExpressionNonlinearity("3*tanh(sigma)", sector=Sector(0, 2))
    >>> found = membership(steep, NonlinearityClass(sector=Sector(0, 2)))
    >>> found.status is Status.VIOLATED, found.regularity, str(found.zeros)
    (True, 'locally Lipschitz', '{0}')
    """
    phi = as_nonlinearity(nonlinearity)
    if isinstance(phi, NamedNonlinearity) and not isinstance(phi, ShiftedNonlinearity):
        return _membership(phi, nonlinearity_class)
    return _membership.__wrapped__(phi, nonlinearity_class)


@lru_cache(maxsize=128)  # nonlinearities of the library are equal if their numbers are
def _membership(phi: Nonlinearity, nonlinearity_class: NonlinearityClass) -> Membership:
    if isinstance(phi, ShiftedNonlinearity) and known_nonlinearity(phi, -math.inf, math.inf) is None:
        inner = membership(phi.nonlinearity, shifted_class(nonlinearity_class, -phi.gain))
        return _shifted(inner, phi, nonlinearity_class)
    try:
        known_of = properties(phi)
    except AssumptionError:  # an exact graph contradicts what is declared: it is then looked at as any formula is
        known_of = None
    found = [_bounded(phi, nonlinearity_class.sector, known_of)]
    if nonlinearity_class.slope is not None:
        found.append(_bounded(phi, nonlinearity_class.slope, known_of))
    if nonlinearity_class.odd:
        found.append(_odd(phi, known_of))
    if not nonlinearity_class.time_varying:
        found.append(_time_invariance(phi))
    regularity, how = _regularity(phi, known_of)
    return Membership(
        nonlinearity=nonlinearity_text(phi),
        nonlinearity_class=nonlinearity_class,
        properties=tuple(found),
        regularity=regularity,
        regularity_property=how,
        zeros=zero_set(phi),
    )


def _shifted(inner: Membership, phi: ShiftedNonlinearity, nonlinearity_class: NonlinearityClass) -> Membership:
    """What is known of a shifted nonlinearity from what is known before the shift."""

    def moved(known: MemberProperty) -> MemberProperty:
        """Chords and slopes, less the gain."""
        if known.name not in _QUANTITIES:
            return known
        ends = [None if x is None else shifted_bound(x, phi.gain) for x in (known.value, known.bound, known.certified)]
        how = f"before the shift by {exact_text(phi.gain)}: {known.how}"
        return replace(known, how=how, value=ends[0], bound=ends[1], certified=ends[2])

    found = tuple(moved(known) for known in inner.properties)
    words = nonlinearity_text(phi)
    return replace(inner, nonlinearity=words, nonlinearity_class=nonlinearity_class, properties=found, zeros=None)


def certified_properties(nonlinearity: Nonlinearity) -> Properties:
    """What is known of a nonlinearity, as :func:`lure.nonlinearities.properties` says, and what is certified here.

    ``nonlinearity``: a nonlinearity whose declarations hold, such as that of :class:`Examined`.

    Raises
    ------
    AssumptionError
        A declared property of a piecewise linear formula is false.
    """
    known_of, own = properties(nonlinearity), smallest_class(nonlinearity)
    found = membership(nonlinearity, own)
    checked = {known.name: known.how for known in found.properties if known.status is Status.CHECKED}
    if found.regularity_property.status is Status.CHECKED:
        checked["regularity"] = found.regularity_property.how
    sector, slope, odd, regularity = known_of.sector, known_of.slope_bounds, known_of.odd, known_of.regularity
    if regularity.provenance is Provenance.DECLARED and "regularity" in checked and found.regularity != "none":
        regularity = Property(value=found.regularity, provenance=Provenance.CHECKED, how=checked["regularity"])
    return Properties(
        sector=_upgraded(sector, checked.get("sector")),
        slope_bounds=slope if slope.value is None else _upgraded(slope, checked.get("slope")),
        odd=_upgraded(odd, checked.get("odd")),
        regularity=regularity,
    )


def _upgraded(known: Property[T], how: str | None) -> Property[T]:
    if how is None or known.provenance is Provenance.CHECKED:
        return known
    return Property(value=known.value, provenance=Provenance.CHECKED, how=how)


def certified_bounds(nonlinearity: object) -> NonlinearityBounds | None:
    """Certified sector and slope bounds of a nonlinearity over all of R, found with a limited effort.

    Returns
    -------
    NonlinearityBounds or None
        None for a nonlinearity known by its values alone, and for a formula that could not be enclosed everywhere.

    Raises
    ------
    InputError
        The formula has no value at some point.
    """
    if type(nonlinearity) is ExpressionNonlinearity:
        return _bounds_of_text(nonlinearity.text)
    return _bounds(nonlinearity)


@lru_cache(maxsize=64)
def _bounds_of_text(text: str) -> NonlinearityBounds | None:
    return _bounds(text)


def _bounds(phi: object) -> NonlinearityBounds | None:
    try:
        if isinstance(phi, Quantiser | MovedNonlinearity):
            return nonlinearity_bounds(phi)
        known = _known(phi)
        if known is None:
            return None
        found = bounds_of_known(known, -math.inf, math.inf, Effort(_EFFORT))
        return found if has_values(known, found) else None
    except (TooLarge, NotEnclosed):
        return None


def _known(phi: object) -> Known | None:
    return known_nonlinearity(phi, -math.inf, math.inf)


def _bounded(phi: Nonlinearity, bounds: Sector | SlopeBounds, known_of: Properties | None) -> MemberProperty:
    """The sector or the slope bounds."""
    is_sector = isinstance(bounds, Sector)
    name: Name = "sector" if is_sector else "slope"
    own = None if known_of is None else known_of.sector if is_sector else known_of.slope_bounds
    if (
        own is not None
        and own.provenance is Provenance.CHECKED
        and own.value is not None
        and _inside(own.value, bounds)
    ):
        return MemberProperty(name=name, status=Status.CHECKED, how=own.how)
    found = certified_bounds(phi)
    if found is None:
        return MemberProperty(name=name, status=Status.DECLARED, how=_WORD)
    if found.within(bounds) is Verdict.REFUTED:
        return _violated(found, bounds, violation(phi, bounds, found=found))
    low, high = _shown(found, name)
    span = f"{_QUANTITIES[name]} in [{exact_text(low, 10)}, {exact_text(high, 10)}] for every sigma"
    if bounds.lower <= low and high <= bounds.upper:
        return MemberProperty(name=name, status=Status.CHECKED, how=f"certified: {span}")
    return MemberProperty(name=name, status=Status.DECLARED, how=f"{_WORD}; certified is only {span}")


def _inside(inner: Sector | SlopeBounds, outer: Sector | SlopeBounds) -> bool:
    return outer.lower <= inner.lower and inner.upper <= outer.upper


def _shown(found: NonlinearityBounds, name: Name) -> tuple[Bound, Bound]:
    """What is certified of the chords or the slopes: slope bounds are bounds of the sector too."""
    spans = [found.extremes("slope")]
    if name == "sector":
        spans.append(found.extremes("sector"))
    lows = [low.outer for low, _ in spans if low is not None]
    highs = [high.outer for _, high in spans if high is not None]
    return max(lows, default=-math.inf), min(highs, default=math.inf)


def _violated(found: NonlinearityBounds, bounds: Sector | SlopeBounds, at: Violation | None) -> MemberProperty:
    name: Name = "sector" if isinstance(bounds, Sector) else "slope"
    low, high = found.extremes(name)  # type: ignore[arg-type]  # one of the two it takes
    assert low is not None, "what was refuted was found"
    assert high is not None, "what was refuted was found"
    above = high.inner > bounds.upper
    beyond, bound = (high, bounds.upper) if above else (low, bounds.lower)
    where = str(at) if at is not None else f"{_QUANTITIES[name]} passes {exact_text(bound)} {beyond.where}"
    certified, side = stated(beyond, 1 if above else -1, certified=True), "at most" if above else "at least"
    return MemberProperty(
        name=name,
        status=Status.VIOLATED,
        how=f"{where}; the certified bound is {side} {certified}",
        points=() if at is None else at.points,
        value=beyond.inner if at is None else at.value,
        bound=bound,
        certified=beyond.outer,
    )


def _odd(phi: Nonlinearity, known_of: Properties | None) -> MemberProperty:
    if known_of is not None and known_of.odd.provenance is Provenance.CHECKED and known_of.odd.value:
        return MemberProperty(name="odd", status=Status.CHECKED, how=known_of.odd.how)
    if type(phi) is ExpressionNonlinearity and known_odd(phi.expression, VARIABLE):
        return MemberProperty(name="odd", status=Status.CHECKED, how="read off the formula")
    known = _known_or_none(phi)
    for x in () if known is None else (*_TRIED, *(abs(cut) for cut in cuts_of(known) if cut != 0)):
        total = _mirrored_sum(known.value, x) if known is not None else None
        if total is not None:
            return MemberProperty(
                name="odd",
                status=Status.VIOLATED,
                how=f"phi(sigma) + phi(-sigma) = {exact_text(total, 10)} at sigma = {exact_text(x)}, and not 0",
                points=(x,),
                value=total,
                bound=Fraction(0),
            )
    return MemberProperty(name="odd", status=Status.DECLARED, how=_WORD)


def _mirrored_sum(value: Callable[[Fraction], Value], x: Fraction) -> Fraction | None:
    """A value of ``phi(x) + phi(-x)`` if it is certainly not 0."""
    try:
        spans = [found if isinstance(found, tuple) else (found, found) for found in (value(x), value(-x))]
    except InputError:
        return None
    low, high = spans[0][0] + spans[1][0], spans[0][1] + spans[1][1]
    return low if low > 0 else high if high < 0 else None


def _known_or_none(phi: object) -> Known | None:
    try:
        return _known(phi)
    except TooLarge:
        return None


def _time_invariance(phi: Nonlinearity) -> MemberProperty:
    if type(phi) in (Quantiser, ExpressionNonlinearity, MovedNonlinearity) or _known_or_none(phi) is not None:
        how = "a formula or a graph in sigma alone"
        return MemberProperty(name="time-invariance", status=Status.CHECKED, how=how)
    how = "a function known by its values is taken to give one value for each sigma"
    return MemberProperty(name="time-invariance", status=Status.DECLARED, how=how)


def _regularity(phi: Nonlinearity, known_of: Properties | None) -> tuple[Regularity, MemberProperty]:
    """The most that is known, and else what is declared."""
    jumping = "discontinuous" in f"{getattr(phi, 'regularity', '')}"
    declared = bool(getattr(phi, "locally_lipschitz", not jumping))  # one that says nothing is taken to be
    if known_of is not None and known_of.regularity.provenance is Provenance.CHECKED:
        rough: Regularity = "none" if "discontinuous" in known_of.regularity.value else "continuous"
        words: Regularity = "locally Lipschitz" if declared else rough
        if words != "continuous" or type(phi) is not ExpressionNonlinearity:
            return words, _regular(Status.CHECKED, known_of.regularity.how)
    known = _known_or_none(phi)
    jumps = None if known is None else _jumps(known)
    if jumps:
        return "none", _regular(Status.VIOLATED if declared else Status.CHECKED, f"phi has {jumps[0].place}")
    found = certified_bounds(phi)
    if known is not None and found is not None and jumps is not None:
        slope = found.slope_lower, found.slope_upper
        if all(end is not None and isinstance(end.outer, Fraction) for end in slope):
            return "locally Lipschitz", _regular(Status.CHECKED, f"certified: slopes in {found.slope}")
        if all(_smooth(piece) for piece in known.pieces):
            how = "its branches meet, and each is smooth up to its ends"
            return "locally Lipschitz", _regular(Status.CHECKED, how)
        if not declared:
            return "continuous", _regular(Status.CHECKED, "its branches meet, and each has values everywhere")
    if type(phi) is ExpressionNonlinearity and phi.nature is not None and phi.nature.continuous and not declared:
        return "continuous", _regular(Status.CHECKED, "read off the formula")
    silent = not (jumping or hasattr(phi, "locally_lipschitz"))
    how = "nothing is declared, and it is taken to be" if silent else _WORD
    return ("locally Lipschitz" if declared else "none" if jumping else "unknown"), _regular(Status.DECLARED, how)


def _jumps(known: Known) -> list[Candidate] | None:
    """The jumps, none where the form of the formula excludes them; None if it is not known whether there are any."""
    if known.continuous:
        return []
    if not known.whole:
        return None
    with working_precision(BITS):
        return jumps_of(known)


def _smooth(piece: Piece) -> bool:
    """Whether the nonlinearity on a piece is visibly locally Lipschitz up to the ends of the piece."""
    if piece.ratio is not None:
        ends = [end for end in (piece.low, piece.high) if isinstance(end, Fraction)]
        return all(piece.ratio.at(end) is not None for end in ends)
    visible = nature(piece.tree)
    return visible is not None and visible.lipschitz


def _regular(status: Status, how: str) -> MemberProperty:
    return MemberProperty(name="regularity", status=status, how=how)

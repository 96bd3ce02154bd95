"""What is known of a nonlinearity, as a table and as plain data; declared properties put to the test by samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from lure.arrays import NDArray, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError, Reason, demand_whole
from lure.exact import Exact, exact_number
from lure.expressions.rigorous import ball
from lure.nonlinearities.base import Nonlinearity, NormalCompliance
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.named import Cubic, Quantiser, Tanh
from lure.nonlinearities.piecewise_linear import DeadZone, Graph, LeakyReLU, PiecewiseLinear, ReLU, Saturation
from lure.nonlinearities.shifted import MovedNonlinearity, ShiftedNonlinearity
from lure.record import Page, described, plain, quantity
from lure.record.values import exact_text

if TYPE_CHECKING:
    from flint import arb

# Declared properties put to the test: a sample can falsify them, and never prove them.

DECADES = (-12, 12)
_ROUNDING = 1e-9
_SUSPECTS = 50
_BITS = 256


def check_declared(nonlinearity: Nonlinearity, *, samples: int = 4000, scale: Exact = 1) -> None:
    """Look for a ``sigma`` that contradicts what a nonlinearity declares of itself.

    Tried are 0, points spaced evenly in the logarithm from ``1e-12 scale`` to ``1e12 scale`` on both sides, and the
    breakpoints of the nonlinearity with their near surroundings.  Passing proves nothing: the properties stay declared.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        The nonlinearity; looked at are its ``sector`` and, where it has them, ``slope_bounds`` and ``odd``.
    samples : int
        Number of sampled points, at least 10.
    scale : int, float, Fraction or Decimal
        Size of ``sigma`` around which to look, positive.

    Raises
    ------
    AssumptionError
        A property is false; the message names ``sigma``, the value found and the bound.
    InputError
        ``samples`` or ``scale`` is not as described.

    Notes
    -----
    The suspicion comes from floating point.  Against a formula it is confirmed in ball arithmetic before it is raised;
    for any other nonlinearity a relative violation of 1e-9 counts as rounding, and so does an absolute error in ``phi``
    of 4e-15 of its largest value for ``|sigma| <= scale``.

    Examples
    --------
    >>> from lure import ExpressionNonlinearity, Sector
    >>> check_declared(ExpressionNonlinearity("tanh(sigma)", sector=Sector(0, 1)))  # nothing was found
    >>> check_declared(ExpressionNonlinearity("2*tanh(sigma)", sector=Sector(0, 1)))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    lure.errors.AssumptionError: the nonlinearity '2*tanh(sigma)' is declared to have the sector [0, 1], but phi...
    """
    demand_whole("check_declared: samples", samples, 10)
    unit = exact_number(scale, "check_declared: scale")
    if unit <= 0:
        raise InputError(f"check_declared: scale is {float(unit):g}; give a positive number")
    sample = _Sample(nonlinearity, samples, float(unit))
    x, phi = sample.x, sample.phi
    with np.errstate(all="ignore"):
        sample.check(nonlinearity.sector, phi / x, sample.noise / np.abs(x), [(1, 0)])
        slope: SlopeBounds | None = getattr(nonlinearity, "slope_bounds", None)
        if slope is not None:
            steps = np.diff(x)
            noise = (2 * sample.noise + 1e-15 * (np.abs(phi[1:]) + np.abs(phi[:-1]))) / steps
            sample.check(slope, np.diff(phi) / steps, noise, [(1, 1), (-1, 0)])
        if getattr(nonlinearity, "odd", False):
            sample.check_odd()


class _Sample:
    """Sorted points without 0, symmetric to it, at which the nonlinearity has a finite value, and these values."""

    def __init__(self, nonlinearity: Nonlinearity, samples: int, scale: float) -> None:
        sizes = scale * np.logspace(*DECADES, samples // 2)
        kinks = np.array([abs(float(point)) for point in getattr(nonlinearity, "breakpoints", ())][:1000])
        near = [kinks * (1 + shift) for shift in (0.0, 1e-3, -1e-3, 1e-6, -1e-6)]
        sizes = np.unique(np.concatenate([sizes, *near]))
        x = np.concatenate([-sizes[sizes > 0][::-1], sizes[sizes > 0]])
        with np.errstate(all="ignore"):
            phi, at_zero = (
                np.asarray(nonlinearity(x), dtype=float),
                float(np.asarray(nonlinearity(np.zeros(1)), dtype=float)[0]),
            )
        self.nonlinearity, self.name = (
            nonlinearity,
            repr(nonlinearity.text)[:60]
            if isinstance(nonlinearity, ExpressionNonlinearity)
            else type(nonlinearity).__name__,
        )
        if at_zero != 0:
            raise AssumptionError(
                f"the nonlinearity {self.name} has phi(0) = {at_zero:g}; a nonlinearity must vanish at 0",
                code=Reason.OUTSIDE_CLASS,
            )
        if np.isnan(phi).any():
            raise AssumptionError(
                f"the nonlinearity {self.name} has no value at sigma = {x[np.isnan(phi)][0]:.17g}",
                code=Reason.OUTSIDE_CLASS,
            )
        finite = np.isfinite(phi)
        self.x, self.phi = x[finite], phi[finite]
        inner = np.abs(self.phi[np.abs(self.x) <= scale])
        self.noise = 4e-15 * float(inner.max(initial=0.0))

    def check(
        self,
        bounds: Sector | SlopeBounds,
        values: NDArray[np.float64],
        noise: NDArray[np.float64],
        combination: list[tuple[int, int]],
    ) -> None:
        """Compare chords, or difference quotients, with their bounds; the combination of values says which they are."""
        for sign, bound in ((1, bounds.upper), (-1, bounds.lower)):
            if bound in (math.inf, -math.inf):
                continue
            excess = sign * (values - float(bound))
            if not isinstance(self.nonlinearity, ExpressionNonlinearity):
                excess -= _ROUNDING * (np.abs(values) + abs(float(bound))) + noise
            i = self._worst(excess, partial(self._beyond, combination=combination, sign=sign, limit=Fraction(bound)))
            if i is None:
                continue
            kind = "the sector" if isinstance(bounds, Sector) else "the slope bounds"
            what = "phi(sigma)/sigma at" if isinstance(bounds, Sector) else "the difference quotient to the right of"
            raise AssumptionError(
                f"the nonlinearity {self.name} is declared to have {kind} {bounds}, but {what} sigma = "
                f"{self.x[i]:.17g} is {values[i]:.12g}; declare bounds that hold",
                code=Reason.OUTSIDE_CLASS,
            )

    def check_odd(self) -> None:
        """Compare the values with those at the mirrored points."""
        mirrored = np.asarray(self.nonlinearity(-self.x), dtype=float)
        excess = np.abs(self.phi + mirrored)
        if not isinstance(self.nonlinearity, ExpressionNonlinearity):
            excess -= _ROUNDING * (np.abs(self.phi) + np.abs(mirrored)) + 2 * self.noise
        excess[np.isnan(excess)] = math.inf
        i = self._worst(excess, lambda i: bool(self._ball(self.x[i]) + self._ball(-self.x[i]) != 0))
        if i is not None:
            raise AssumptionError(
                f"the nonlinearity {self.name} is declared odd, but phi({self.x[i]:.17g}) = {self.phi[i]:.12g} and "
                f"phi({-self.x[i]:.17g}) = {mirrored[i]:.12g}; declare odd = False",
                code=Reason.OUTSIDE_CLASS,
            )

    def _worst(self, excess: NDArray[np.float64], certain: Callable[[int], bool]) -> int | None:
        """The point of largest excess, if it is positive and, for a formula, certain."""
        suspects = np.flatnonzero(excess > 0)
        suspects = suspects[np.argsort(-excess[suspects])]
        if not isinstance(self.nonlinearity, ExpressionNonlinearity):
            return int(suspects[0]) if len(suspects) else None
        spread = suspects[np.unique(np.linspace(0, len(suspects) - 1, _SUSPECTS).astype(int))] if len(suspects) else []
        return next((int(i) for i in spread if certain(int(i))), None)

    def _beyond(self, i: int, *, combination: list[tuple[int, int]], sign: int, limit: Fraction) -> bool:
        """Whether the ``i``-th chord or difference quotient is certainly beyond its bound."""
        import flint

        with flint.ctx.workprec(_BITS):
            top, bottom = flint.arb(0), flint.arb(0)
            for weight, offset in combination:
                x = float(self.x[i + offset])
                top, bottom = top + weight * self._ball(x), bottom + weight * flint.arb(x)
            return bool(sign * (top / bottom - ball(limit)) > 0)

    def _ball(self, x: float) -> arb:
        import flint

        assert isinstance(self.nonlinearity, ExpressionNonlinearity), "only formulas have enclosures"
        with flint.ctx.workprec(_BITS):
            return self.nonlinearity.expression.ball(sigma=flint.arb(float(x)))


# What is known of a nonlinearity, and whether it was checked or is its author's word.

T = TypeVar("T")

_FROM_POINTS = "exact, read off the points and the slopes outside them"
_PROOFS: dict[type, str] = {
    **dict.fromkeys((Saturation, DeadZone, ReLU, LeakyReLU, PiecewiseLinear), _FROM_POINTS),
    Cubic: "closed form: phi(sigma)/sigma = a + b sigma^2 and phi' = a + 3 b sigma^2",
    Tanh: "closed form: phi' = (gain/scale)/cosh^2(sigma/scale) falls from gain/scale to 0",
    Quantiser: "closed form: |phi - sigma| <= step/2, and phi = 0 for |sigma| < step/2",
    NormalCompliance: "closed form: a power of max(sigma, 0)",
}
_WORD = "the word of the nonlinearity's author"


class Provenance(Enum):
    """Whether a property was checked for every ``sigma``, or is declared and believed."""

    DECLARED = "declared"
    CHECKED = "checked"

    def __str__(self) -> str:
        return self.value


@described(frozen=True, kw_only=True, slots=True)
class Property(Generic[T]):
    """A property with its provenance and, in one sentence, how it is known."""

    value: T = quantity("The property")
    provenance: Provenance = quantity("Whether it was checked, or is declared and believed")
    how: str = quantity("How it is known")

    def __str__(self) -> str:
        return f"{self.value} ({self.provenance}: {self.how})"


@described(frozen=True, kw_only=True, slots=True)
class Properties:
    """What is known of a nonlinearity."""

    sector: Property[Sector] = quantity("Bounds on ``phi(sigma)/sigma``")
    slope_bounds: Property[SlopeBounds | None] = quantity(
        "Bounds on the difference quotients; None where there are none, or none are known"
    )
    odd: Property[bool] = quantity("False where the nonlinearity is not known to be odd")
    regularity: Property[str] = quantity("Continuity and smoothness in words; ``unknown`` where nothing is")


def properties(nonlinearity: Nonlinearity) -> Properties:
    """What is known of a nonlinearity, each property with its provenance.

    Nonlinearities of the library are known in closed form.  A formula is checked if it is piecewise linear, which is
    recognised exactly; of others the regularity is, where the form of the formula shows it.  Everything else is
    declared: a sample, however dense, checks nothing for every ``sigma``.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        Any nonlinearity.

    Raises
    ------
    AssumptionError
        A declared property of a piecewise linear formula is false.

    Examples
    --------
    >>> from lure import ExpressionNonlinearity, Saturation
    >>> print(properties(Saturation(gain=2)).sector)
    [0, 2] (checked: exact, read off the points and the slopes outside them)
    >>> print(properties(ExpressionNonlinearity("tanh(sigma)", sector=Sector(0, 1))).sector)
    [0, 1] (declared: the word of the nonlinearity's author)
    """
    if type(nonlinearity) is ShiftedNonlinearity:
        inner, note = properties(nonlinearity.nonlinearity), f"; shifted by {exact_text(nonlinearity.gain)}"
        return Properties(
            sector=Property(value=nonlinearity.sector, provenance=inner.sector.provenance, how=inner.sector.how + note),
            slope_bounds=Property(
                value=nonlinearity.slope_bounds,
                provenance=inner.slope_bounds.provenance,
                how=inner.slope_bounds.how + note,
            ),
            odd=inner.odd,
            regularity=inner.regularity,
        )
    if type(nonlinearity) is MovedNonlinearity:
        inner = properties(nonlinearity.nonlinearity)
        of = inner.slope_bounds
        how = "chords of tanh are no steeper than a tangent" if type(nonlinearity.nonlinearity) is Tanh else ""
        how = "read off the points" if nonlinearity.centre is not None else how or "chords are means of slopes"
        return Properties(
            sector=Property(value=nonlinearity.sector, provenance=of.provenance, how=f"{of.how}; {how}"),
            slope_bounds=Property(value=nonlinearity.slope_bounds, provenance=of.provenance, how=of.how),
            odd=Property(value=False, provenance=Provenance.CHECKED, how="not known to be, where it is counted from"),
            regularity=inner.regularity,
        )
    if type(nonlinearity) is ExpressionNonlinearity and nonlinearity.graph is not None:
        _compare(nonlinearity, nonlinearity.graph)
        return _all(nonlinearity, Provenance.CHECKED, "the formula is piecewise linear: " + _FROM_POINTS)
    if type(nonlinearity) is ExpressionNonlinearity:
        return _of_formula(nonlinearity)
    proof = _PROOFS.get(type(nonlinearity))
    return (
        _all(nonlinearity, Provenance.DECLARED, _WORD)
        if proof is None
        else _all(nonlinearity, Provenance.CHECKED, proof)
    )


def nonlinearity_class(nonlinearity: Nonlinearity) -> NonlinearityClass:
    """The smallest class known to contain this nonlinearity: a theorem for the class is one for the nonlinearity.

    Parameters
    ----------
    nonlinearity : Nonlinearity
        Any nonlinearity; the sector is narrowed to the slope bounds, which ``phi(0) = 0`` allows.

    Raises
    ------
    AssumptionError
        A declared property of a piecewise linear formula is false.
    InputError
        The declared sector and slope bounds have nothing in common.

    Examples
    --------
    >>> from lure import DeadZone
    >>> print(nonlinearity_class(DeadZone(width=1, gain=2)))
    odd phi with slope in [0, 2]
    """
    known = properties(nonlinearity)
    sector, slope = known.sector.value, known.slope_bounds.value
    if slope is not None:
        sector = Sector(max(sector.lower, slope.lower), min(sector.upper, slope.upper))
    return NonlinearityClass(sector=sector, slope=slope, odd=known.odd.value)


def require_given_alone(asked: NonlinearityClass) -> None:
    """Refuse a class beside which no nonlinearity may be given: constant gains, ReLUs, operators, play and stop.

    Raises
    ------
    InputError
        It is one of these.
    """
    if asked.linear or asked.rectifier or asked.memory or asked.operator:
        raise InputError(f"the class is {asked} alone, and a nonlinearity is given beside it; leave one of the two out")


def _all(nonlinearity: Nonlinearity, provenance: Provenance, how: str) -> Properties:
    """Every property of the nonlinearity with one provenance; what the nonlinearity does not say is not known."""

    def known(value: T, *, missing: bool) -> Property[T]:
        """A property of this provenance."""
        if missing:
            return Property(value=value, provenance=Provenance.DECLARED, how="nothing is declared")
        return Property(value=value, provenance=provenance, how=how)

    checked = provenance is Provenance.CHECKED
    slope: SlopeBounds | None = getattr(nonlinearity, "slope_bounds", None)
    regularity = str(getattr(nonlinearity, "regularity", "unknown"))
    return Properties(
        sector=known(nonlinearity.sector, missing=False),
        slope_bounds=known(slope, missing=slope is None and not checked),
        odd=known(bool(getattr(nonlinearity, "odd", False)), missing=not hasattr(nonlinearity, "odd")),
        regularity=known(regularity, missing=regularity == "unknown"),
    )


def _of_formula(nonlinearity: ExpressionNonlinearity) -> Properties:
    """What is declared of a formula, with the regularity that its form shows."""
    declared = _all(nonlinearity, Provenance.DECLARED, _WORD)
    visible = nonlinearity.visibly_lipschitz or not nonlinearity.locally_lipschitz
    if not visible or nonlinearity.regularity == "unknown":
        return declared
    how = "read off the formula: it is made of functions with this property, each inside its domain"
    return replace(declared, regularity=Property(value=nonlinearity.regularity, provenance=Provenance.CHECKED, how=how))


def _compare(nonlinearity: ExpressionNonlinearity, graph: Graph) -> None:
    """Refuse what is declared of a formula whose exact graph contradicts it."""
    sector, slope = nonlinearity.sector, nonlinearity.slope_bounds
    for chord, where in graph.chords:
        _inside(nonlinearity, ("the sector", "phi(sigma)/sigma", where), chord, sector)
    for value in graph.slopes if slope is not None else ():
        _inside(nonlinearity, ("the slope bounds", "the slope", "on one of its pieces"), value, slope)
    if nonlinearity.odd and not graph.odd:
        x = next((x for x in graph.knots if graph.exact(-x) != -graph.exact(x)), 2 * max(map(abs, graph.knots)) + 1)
        raise AssumptionError(
            f"the nonlinearity {nonlinearity.text!r:.60} is declared odd, but phi({exact_text(x)}) = "
            f"{exact_text(graph.exact(x))} and "
            f"phi({exact_text(-x)}) = {exact_text(graph.exact(-x))}; declare odd = False",
            code=Reason.OUTSIDE_CLASS,
        )


def _inside(
    nonlinearity: ExpressionNonlinearity,
    words: tuple[str, str, str],
    value: Fraction,
    bounds: Sector | SlopeBounds | None,
) -> None:
    if bounds is not None and not bounds.lower <= value <= bounds.upper:
        declared, quantity, where = words
        raise AssumptionError(
            f"the nonlinearity {nonlinearity.text!r:.60} is declared to have {declared} {bounds}, but {quantity} is "
            f"{exact_text(value)} {where}; declare bounds that hold",
            code=Reason.OUTSIDE_CLASS,
        )


def nonlinearity_dict(nonlinearity: Nonlinearity) -> dict[str, Any]:
    """A nonlinearity as plain JSON data: its kind, parameters and properties, each with its provenance.

    ``nonlinearity``: the nonlinearity.  A declared property that its own formula contradicts is reported as
    ``contradicted``.
    """
    data: dict[str, Any] = {
        "kind": type(nonlinearity).__name__,
        "text": nonlinearity_text(nonlinearity),
        "parameters": _parameters(nonlinearity),
    }
    known, against = _known(nonlinearity)
    for name, found in known.items():
        value, standing, how = found
        data[name] = {"value": value, "standing": standing, "how": how}
    return {**data, "contradicted": against}


def nonlinearity_page(nonlinearity: Nonlinearity) -> Page:
    """A nonlinearity as a table."""
    known, against = _known(nonlinearity)
    rows = [(name.replace("_", " "), value, standing, how) for name, (value, standing, how) in known.items()]
    notes = ["It enters the loop as mu = -phi(sigma)."] if against is None else [f"CONTRADICTED: {against}"]
    return Page(
        f"phi: {nonlinearity_text(nonlinearity)}", rows, head=("", "value", "standing", "how it is known"), notes=notes
    )


def nonlinearity_text(nonlinearity: Nonlinearity) -> str:
    """A nonlinearity in words: what it prints, or the name of its class with its parameters."""
    if type(nonlinearity).__str__ is not object.__str__:
        return str(nonlinearity)
    given = ", ".join(f"{name} = {value}" for name, value in _parameters(nonlinearity).items())
    return f"{type(nonlinearity).__name__}({given})" if given else type(nonlinearity).__name__


def _known(nonlinearity: Nonlinearity) -> tuple[dict[str, tuple[str, str, str]], str | None]:
    """Each property as text with its provenance; and what contradicts it, if anything does."""
    try:
        found = properties(nonlinearity)
    except AssumptionError as error:
        return {"sector": (str(nonlinearity.sector), "declared", "the word of the nonlinearity's author")}, str(error)
    slope, odd = found.slope_bounds, found.odd
    return {
        "sector": _row(found.sector, str(found.sector.value)),
        "slope": _row(slope, "not known to be bounded" if slope.value is None else str(slope.value)),
        "odd": _row(odd, "yes" if odd.value else "not known to be"),
        "regularity": _row(found.regularity, found.regularity.value),
    }, None


def _row(known: Property[Any], value: str) -> tuple[str, str, str]:
    return value, str(known.provenance), known.how


def _parameters(nonlinearity: Nonlinearity) -> dict[str, Any]:
    if not is_dataclass(nonlinearity):
        return {}
    return {
        field.name: plain(getattr(nonlinearity, field.name))
        for field in fields(nonlinearity)
        if field.init and field.repr
    }

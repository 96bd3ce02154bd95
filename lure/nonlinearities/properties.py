"""What is known of a nonlinearity, as a table and as plain data; declared properties put to the test by samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from lure.arrays import NDArray, np
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, InputError, Reason
from lure.exact import Exact, exact_number
from lure.nonlinearities.base import Nonlinearity, NormalCompliance, number_text
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.named import Cubic, Quantiser, Tanh
from lure.nonlinearities.piecewise_linear import DeadZone, Graph, LeakyReLU, PiecewiseLinear, ReLU, Saturation
from lure.nonlinearities.shifted import ShiftedNonlinearity
from lure.record import Page, plain

if TYPE_CHECKING:
    from flint import arb

# Declared properties put to the test: a sample can falsify them, and never prove them.

DECADES = (-12, 12)
_ROUNDING = 1e-9
_SUSPECTS = 50
_BITS = 256


def check_declared(law: Nonlinearity, *, samples: int = 4000, scale: Exact = 1) -> None:
    """Look for a ``sigma`` that contradicts what a law declares of itself.

    Tried are 0, points spaced evenly in the logarithm from ``1e-12 scale`` to ``1e12 scale`` on both sides, and the
    breakpoints of the law with their near surroundings.  Passing proves nothing: the properties stay declared.

    Parameters
    ----------
    law : Nonlinearity
        The law; looked at are its ``sector`` and, where it has them, ``slope_bounds`` and ``odd``.
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
    for any other law a relative violation of 1e-9 counts as rounding, and so does an absolute error in ``phi`` of 4e-15
    of its largest value for ``|sigma| <= scale``.

    Examples
    --------
    >>> from lure import ExpressionNonlinearity, Sector
    >>> check_declared(ExpressionNonlinearity("tanh(sigma)", sector=Sector(0, 1)))  # nothing was found
    >>> check_declared(ExpressionNonlinearity("2*tanh(sigma)", sector=Sector(0, 1)))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    lure.errors.AssumptionError: the nonlinearity '2*tanh(sigma)' is declared to have the sector [0, 1], but phi...
    """
    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 10:
        raise InputError(f"check_declared: samples is {samples!r:.60}; give a whole number of at least 10")
    unit = exact_number(scale, "check_declared: scale")
    if unit <= 0:
        raise InputError(f"check_declared: scale is {float(unit):g}; give a positive number")
    sample = _Sample(law, samples, float(unit))
    x, phi = sample.x, sample.phi
    with np.errstate(all="ignore"):
        sample.check(law.sector, phi / x, sample.noise / np.abs(x), [(1, 0)])
        slope: SlopeBounds | None = getattr(law, "slope_bounds", None)
        if slope is not None:
            steps = np.diff(x)
            noise = (2 * sample.noise + 1e-15 * (np.abs(phi[1:]) + np.abs(phi[:-1]))) / steps
            sample.check(slope, np.diff(phi) / steps, noise, [(1, 1), (-1, 0)])
        if getattr(law, "odd", False):
            sample.check_odd()


class _Sample:
    """Sorted points without 0, symmetric to it, at which the law has a finite value, and these values."""

    def __init__(self, law: Nonlinearity, samples: int, scale: float) -> None:
        sizes = scale * np.logspace(*DECADES, samples // 2)
        kinks = np.array([abs(float(point)) for point in getattr(law, "breakpoints", ())][:1000])
        near = [kinks * (1 + shift) for shift in (0.0, 1e-3, -1e-3, 1e-6, -1e-6)]
        sizes = np.unique(np.concatenate([sizes, *near]))
        x = np.concatenate([-sizes[sizes > 0][::-1], sizes[sizes > 0]])
        with np.errstate(all="ignore"):
            phi, at_zero = np.asarray(law(x), dtype=float), float(np.asarray(law(np.zeros(1)), dtype=float)[0])
        self.law, self.name = (
            law,
            repr(law.text)[:60] if isinstance(law, ExpressionNonlinearity) else type(law).__name__,
        )
        if at_zero != 0:
            raise AssumptionError(
                f"the nonlinearity {self.name} has phi(0) = {at_zero:g}; a nonlinearity must vanish at 0",
                code=Reason.FOREIGN_LAW,
            )
        if np.isnan(phi).any():
            raise AssumptionError(
                f"the nonlinearity {self.name} has no value at sigma = {x[np.isnan(phi)][0]:.17g}",
                code=Reason.FOREIGN_LAW,
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
            if not isinstance(self.law, ExpressionNonlinearity):
                excess -= _ROUNDING * (np.abs(values) + abs(float(bound))) + noise
            i = self._worst(excess, partial(self._beyond, combination=combination, sign=sign, limit=Fraction(bound)))
            if i is None:
                continue
            kind = "the sector" if isinstance(bounds, Sector) else "the slope bounds"
            what = "phi(sigma)/sigma at" if isinstance(bounds, Sector) else "the difference quotient to the right of"
            raise AssumptionError(
                f"the nonlinearity {self.name} is declared to have {kind} {bounds}, but {what} sigma = "
                f"{self.x[i]:.17g} is {values[i]:.12g}; declare bounds that hold",
                code=Reason.FOREIGN_LAW,
            )

    def check_odd(self) -> None:
        """Compare the values with those at the mirrored points."""
        mirrored = np.asarray(self.law(-self.x), dtype=float)
        excess = np.abs(self.phi + mirrored)
        if not isinstance(self.law, ExpressionNonlinearity):
            excess -= _ROUNDING * (np.abs(self.phi) + np.abs(mirrored)) + 2 * self.noise
        excess[np.isnan(excess)] = math.inf
        i = self._worst(excess, lambda i: bool(self._ball(self.x[i]) + self._ball(-self.x[i]) != 0))
        if i is not None:
            raise AssumptionError(
                f"the nonlinearity {self.name} is declared odd, but phi({self.x[i]:.17g}) = {self.phi[i]:.12g} and "
                f"phi({-self.x[i]:.17g}) = {mirrored[i]:.12g}; declare odd = False",
                code=Reason.FOREIGN_LAW,
            )

    def _worst(self, excess: NDArray[np.float64], certain: Callable[[int], bool]) -> int | None:
        """The point of largest excess, if it is positive and, for a formula, certain."""
        suspects = np.flatnonzero(excess > 0)
        suspects = suspects[np.argsort(-excess[suspects])]
        if not isinstance(self.law, ExpressionNonlinearity):
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
            exact = flint.arb(flint.fmpq(limit.numerator, limit.denominator))
            return bool(sign * (top / bottom - exact) > 0)

    def _ball(self, x: float) -> arb:
        import flint

        assert isinstance(self.law, ExpressionNonlinearity), "only formulas have enclosures"
        with flint.ctx.workprec(_BITS):
            return self.law.expression.ball(sigma=flint.arb(float(x)))


# What is known of a law, and whether it was checked or is its author's word.

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


@dataclass(frozen=True, kw_only=True, slots=True)
class Property(Generic[T]):
    """A property with its provenance and, in one sentence, how it is known.

    Attributes
    ----------
    value : Sector, SlopeBounds, bool or str
        The property.
    provenance : Provenance
        Whether it was checked, or is declared and believed.
    how : str
        How it is known.
    """

    value: T
    provenance: Provenance
    how: str

    def __str__(self) -> str:
        return f"{self.value} ({self.provenance}: {self.how})"


@dataclass(frozen=True, kw_only=True, slots=True)
class Properties:
    """What is known of a law.

    Attributes
    ----------
    sector : Property of Sector
        Bounds on ``phi(sigma)/sigma``.
    slope_bounds : Property of SlopeBounds or None
        Bounds on the difference quotients; None where there are none, or none are known.
    odd : Property of bool
        False where the law is not known to be odd.
    regularity : Property of str
        Continuity and smoothness in words; ``unknown`` where nothing is.
    """

    sector: Property[Sector]
    slope_bounds: Property[SlopeBounds | None]
    odd: Property[bool]
    regularity: Property[str]


def properties(law: Nonlinearity) -> Properties:
    """What is known of a law, each property with its provenance.

    Laws of the library are known in closed form.  A formula is checked if it is piecewise linear, which is recognised
    exactly; of others the regularity is, where the form of the formula shows it.  Everything else is declared: a
    sample, however dense, checks nothing for every ``sigma``.

    Parameters
    ----------
    law : Nonlinearity
        Any law.

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
    if type(law) is ShiftedNonlinearity:
        inner, note = properties(law.law), f"; shifted by {number_text(law.gain)}"
        return Properties(
            sector=Property(value=law.sector, provenance=inner.sector.provenance, how=inner.sector.how + note),
            slope_bounds=Property(
                value=law.slope_bounds, provenance=inner.slope_bounds.provenance, how=inner.slope_bounds.how + note
            ),
            odd=inner.odd,
            regularity=inner.regularity,
        )
    if type(law) is ExpressionNonlinearity and law.graph is not None:
        _compare(law, law.graph)
        return _all(law, Provenance.CHECKED, "the formula is piecewise linear: " + _FROM_POINTS)
    if type(law) is ExpressionNonlinearity:
        return _of_formula(law)
    proof = _PROOFS.get(type(law))
    return _all(law, Provenance.DECLARED, _WORD) if proof is None else _all(law, Provenance.CHECKED, proof)


def law_class(law: Nonlinearity) -> NonlinearityClass:
    """The smallest class of laws known to contain this one: a theorem for the class is one for the law.

    Parameters
    ----------
    law : Nonlinearity
        Any law; the sector is narrowed to the slope bounds, which ``phi(0) = 0`` allows.

    Raises
    ------
    AssumptionError
        A declared property of a piecewise linear formula is false.
    InputError
        The declared sector and slope bounds have nothing in common.

    Examples
    --------
    >>> from lure import DeadZone
    >>> print(law_class(DeadZone(width=1, gain=2)))
    odd phi with slope in [0, 2]
    """
    known = properties(law)
    sector, slope = known.sector.value, known.slope_bounds.value
    if slope is not None:
        sector = Sector(max(sector.lower, slope.lower), min(sector.upper, slope.upper))
    return NonlinearityClass(sector=sector, slope=slope, odd=known.odd.value)


def _all(law: Nonlinearity, provenance: Provenance, how: str) -> Properties:
    """Every property of the law with one provenance; what the law does not say is not known."""

    def known(value: T, *, missing: bool) -> Property[T]:
        """A property of this provenance."""
        if missing:
            return Property(value=value, provenance=Provenance.DECLARED, how="nothing is declared")
        return Property(value=value, provenance=provenance, how=how)

    checked = provenance is Provenance.CHECKED
    slope: SlopeBounds | None = getattr(law, "slope_bounds", None)
    regularity = str(getattr(law, "regularity", "unknown"))
    return Properties(
        sector=known(law.sector, missing=False),
        slope_bounds=known(slope, missing=slope is None and not checked),
        odd=known(bool(getattr(law, "odd", False)), missing=not hasattr(law, "odd")),
        regularity=known(regularity, missing=regularity == "unknown"),
    )


def _of_formula(law: ExpressionNonlinearity) -> Properties:
    """What is declared of a formula, with the regularity that its form shows."""
    declared = _all(law, Provenance.DECLARED, _WORD)
    visible = law.visibly_lipschitz or not law.locally_lipschitz
    if not visible or law.regularity == "unknown":
        return declared
    how = "read off the formula: it is made of functions with this property, each inside its domain"
    return replace(declared, regularity=Property(value=law.regularity, provenance=Provenance.CHECKED, how=how))


def _compare(law: ExpressionNonlinearity, graph: Graph) -> None:
    """Refuse what is declared of a formula whose exact graph contradicts it."""
    sector, slope = law.sector, law.slope_bounds
    for chord, where in graph.chords:
        _inside(law, ("the sector", "phi(sigma)/sigma", where), chord, sector)
    for value in graph.slopes if slope is not None else ():
        _inside(law, ("the slope bounds", "the slope", "on one of its pieces"), value, slope)
    if law.odd and not graph.odd:
        x = next((x for x in graph.knots if graph.exact(-x) != -graph.exact(x)), 2 * max(map(abs, graph.knots)) + 1)
        raise AssumptionError(
            f"the nonlinearity {law.text!r:.60} is declared odd, but phi({number_text(x)}) = "
            f"{number_text(graph.exact(x))} and "
            f"phi({number_text(-x)}) = {number_text(graph.exact(-x))}; declare odd = False",
            code=Reason.FOREIGN_LAW,
        )


def _inside(
    law: ExpressionNonlinearity, words: tuple[str, str, str], value: Fraction, bounds: Sector | SlopeBounds | None
) -> None:
    if bounds is not None and not bounds.lower <= value <= bounds.upper:
        declared, quantity, where = words
        raise AssumptionError(
            f"the nonlinearity {law.text!r:.60} is declared to have {declared} {bounds}, but {quantity} is "
            f"{number_text(value)} {where}; declare bounds that hold",
            code=Reason.FOREIGN_LAW,
        )


def law_dict(law: Nonlinearity) -> dict[str, Any]:
    """A law as plain JSON data: its kind, parameters and properties, each with its provenance.

    Parameters
    ----------
    law : Nonlinearity
        The law.  A declared property that its own formula contradicts is reported as ``contradicted``.
    """
    data: dict[str, Any] = {"kind": type(law).__name__, "text": law_text(law), "parameters": _parameters(law)}
    known, against = _known(law)
    for name, found in known.items():
        value, standing, how = found
        data[name] = {"value": value, "standing": standing, "how": how}
    return {**data, "contradicted": against}


def law_page(law: Nonlinearity) -> Page:
    """A law as a table.

    Parameters
    ----------
    law : Nonlinearity
        The law.
    """
    known, against = _known(law)
    rows = [(name.replace("_", " "), value, standing, how) for name, (value, standing, how) in known.items()]
    notes = ["It enters the loop as mu = -phi(sigma)."] if against is None else [f"CONTRADICTED: {against}"]
    return Page(f"phi: {law_text(law)}", rows, head=("", "value", "standing", "how it is known"), notes=notes)


def law_text(law: Nonlinearity) -> str:
    """A law in words: what it prints, or the name of its class with its parameters.

    Parameters
    ----------
    law : Nonlinearity
        Any law.
    """
    if type(law).__str__ is not object.__str__:
        return str(law)
    given = ", ".join(f"{name} = {value}" for name, value in _parameters(law).items())
    return f"{type(law).__name__}({given})" if given else type(law).__name__


def _known(law: Nonlinearity) -> tuple[dict[str, tuple[str, str, str]], str | None]:
    """Each property as text with its provenance; and what contradicts it, if anything does."""
    try:
        found = properties(law)
    except AssumptionError as error:
        return {"sector": (str(law.sector), "declared", "the word of the nonlinearity's author")}, str(error)
    slope, odd = found.slope_bounds, found.odd
    return {
        "sector": _row(found.sector, str(found.sector.value)),
        "slope": _row(slope, "not known to be bounded" if slope.value is None else str(slope.value)),
        "odd": _row(odd, "yes" if odd.value else "not known to be"),
        "regularity": _row(found.regularity, found.regularity.value),
    }, None


def _row(known: Property[Any], value: str) -> tuple[str, str, str]:
    return value, str(known.provenance), known.how


def _parameters(law: Nonlinearity) -> dict[str, Any]:
    if not is_dataclass(law):
        return {}
    return {field.name: plain(getattr(law, field.name)) for field in fields(law) if field.init and field.repr}

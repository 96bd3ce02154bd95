"""The nonlinearity under test, and the search for the simplest point at which it breaks what is asserted of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Literal, TypeAlias

from lure.arrays import ArrayLike, NDArray, Reals, np
from lure.errors import InputError
from lure.exact import Exact
from lure.expressions import Expression
from lure.expressions.tree import names
from lure.record import described, quantity

# The nonlinearity under test, whatever it came as: one function from arrays of doubles to arrays of doubles.

_PROBES = (-1.25, -0.5, 0.0, 0.5, 1.25)
_MOST_BREAKPOINTS = 1000


class NotANumber(Exception):
    """The nonlinearity has no finite real value at a point; ``sigma`` is the point, the text says what came instead.

    ``cause``: what came, or was raised; numbers and what arithmetic raises depend on the point.
    """

    def __init__(self, sigma: float, what: str, cause: object) -> None:
        super().__init__(what)
        self.sigma = sigma
        self.elsewhere = isinstance(cause, complex | float | ArithmeticError | ValueError)


@dataclass(slots=True)
class Subject:
    """A nonlinearity to be tested.

    Attributes
    ----------
    name : str
        What messages call it.
    nonlinearity : object
        What was given: an exact nonlinearity or a formula as :func:`lure.analysis.nonlinearity.nonlinearity_bounds`
        takes it, or a callable.
    call : callable
        Its values.
    known : bool
        Whether it is a formula or a nonlinearity of the library, which can be decided by more than sampling.
    breakpoints : tuple of float
        Where its slope is known to change.
    vectorised : bool
        Whether ``call`` takes arrays.
    coarseness : float
        Rounding unit of the numbers it returns, in units of that of doubles: 1, or 2^29 for single precision.
    evaluations : int
        How often a value was asked for.
    """

    name: str
    nonlinearity: object
    call: Callable[..., object] = field(compare=False)
    known: bool = False
    breakpoints: tuple[float, ...] = ()
    vectorised: bool = True
    coarseness: float = 1.0
    evaluations: int = 0

    def __call__(self, sigma: Reals) -> Reals:
        """Values at a one-dimensional array of points.

        Raises
        ------
        NotANumber
            One of them is not a finite real number.
        """
        self.evaluations += sigma.size
        if not self.vectorised:
            return np.array([self.at(float(point)) for point in sigma])
        values = self._array(sigma)
        if values is None or not np.isfinite(values).all():
            return np.array([self.at(float(point)) for point in sigma])
        return values

    def anyhow(self, sigma: Reals) -> Reals:
        """Values of a nonlinearity that takes arrays, infinite or nan where floating point has no better."""
        values = self._array(sigma)
        return np.full(sigma.shape, np.nan) if values is None else values

    def at(self, sigma: float) -> float:
        """The value at one point.

        Raises
        ------
        NotANumber
            It is not a finite real number.
        """
        try:
            with np.errstate(all="ignore"):
                value = self.call(sigma)
        except Exception as error:  # whatever the nonlinearity raises is what the message is about
            says = f" ({error})" if str(error) else ""
            raise NotANumber(sigma, f"raises {type(error).__name__}{says}"[:160], error) from None
        number = _real(value)
        if number is None or not math.isfinite(number):
            what = f"is {value!r:.60}" if number is None else f"is {number}"
            raise NotANumber(sigma, what, value if number is None else number)
        return number

    def _array(self, sigma: Reals) -> Reals | None:
        """Values for an array; None if they are not real numbers of its shape."""
        try:
            with np.errstate(all="ignore"):
                values = np.asarray(self.call(sigma))
            return None if values.shape != sigma.shape or values.dtype.kind not in "fiub" else values.astype(float)
        except Exception:  # the scalar calls that follow say what is wrong
            return None


def subject(phi: object) -> Subject:
    """The nonlinearity as something to evaluate.

    Parameters
    ----------
    phi : callable, nonlinearity of lure.nonlinearities, Expression or str
        A text is a formula in ``sigma`` or ``x``.  A callable is called with arrays if it answers an array as it
        answers each of its numbers, else with one float at a time.

    Raises
    ------
    InputError
        It is none of these, or does not give the same value twice.
    """
    if isinstance(phi, str):
        phi = _parsed(phi)
    if isinstance(phi, Expression):
        variable = next(iter(names(phi.tree)), phi.variables[0])
        return Subject(str(phi)[:60], phi, partial(_value, phi, variable), known=True)
    if not callable(phi):
        raise InputError(
            f"phi is {phi!r:.60}; give a function, a nonlinearity of lure.nonlinearities or a formula in sigma as text"
        )
    module = type(phi).__module__
    known = module.startswith("lure.") and hasattr(phi, "sector")
    points = tuple(float(point) for point in tuple(getattr(phi, "breakpoints", ()))[:_MOST_BREAKPOINTS])
    found = Subject(_name(phi), phi, phi, known=known, breakpoints=points)
    found.vectorised = known or _takes_arrays(found)
    found.coarseness = 1.0 if known else _coarseness(found)
    return found


def _value(expression: Expression, variable: str, sigma: ArrayLike) -> object:
    return expression(**{variable: sigma})


def _parsed(text: str) -> Expression:
    try:
        return Expression.parse(text, variables=("sigma",), field="phi")
    except InputError as error:
        try:
            return Expression.parse(text, variables=("x",), field="phi")
        except InputError:
            raise InputError(str(error)) from None  # without the parser's frames, which a failed test would show


def _takes_arrays(found: Subject) -> bool:
    """Whether an array is answered as its numbers are; refuses what depends on more than ``sigma``."""
    probes = np.array(_PROBES)
    try:
        alone = [found.at(point) for point in _PROBES]
        again = [found.at(point) for point in reversed(_PROBES)][::-1]
    except NotANumber:
        alone, again = [math.nan], [math.nan]  # not defined at every probe: ask for numbers one at a time
    if alone != again and not math.isnan(alone[0]):
        i = next(i for i, (a, b) in enumerate(zip(alone, again, strict=True)) if a != b)
        raise InputError(
            f"{found.name} gives {alone[i]:.6g} and then {again[i]:.6g} for the same sigma = {_PROBES[i]:g}; a sector "
            "and a slope are those of a function of sigma alone, without memory or chance (of play and friction with "
            "memory see NonlinearityClass.hysteretic)"
        )
    together = found._array(probes)
    return together is not None and len(alone) == len(probes) and np.allclose(together, alone, rtol=1e-12, atol=0.0)


def _coarseness(found: Subject) -> float:
    """How much coarser than doubles the numbers are that a nonlinearity returns."""
    try:
        with np.errstate(all="ignore"):
            kind = np.asarray(found.call(_PROBES[-1])).dtype
    except Exception:  # said when it is tested
        return 1.0
    return max(float(np.finfo(kind).eps / np.finfo(float).eps), 1.0) if kind.kind == "f" else 1.0


def _name(phi: object) -> str:
    if hasattr(phi, "sector"):
        return str(getattr(phi, "text", type(phi).__name__))[:60]
    name = getattr(phi, "__name__", "phi")
    return "phi" if name == "<lambda>" else name


def _real(value: object) -> float | None:
    """A single real number as a double, None for anything else."""
    item = getattr(value, "item", None)
    if item is not None and getattr(value, "size", None) == 1:
        value = item()
    if isinstance(value, bool | int | float | Fraction) or type(value).__name__ == "Decimal":
        try:
            return float(value)  # type: ignore[arg-type]  # or a Decimal
        except OverflowError:
            return math.inf
    return None


# Where a nonlinearity is tested: an interval, and the points of it that are tried first.

_DECADES = (-12.0, 12.0)
_SHARE_OF_LINEAR = 0.25
_NEAR = (0.0, 1e-3, -1e-3, 1e-6, -1e-6, 1e-9, -1e-9)


@described(frozen=True, kw_only=True, slots=True)
class Domain:
    """The interval ``[low, high]`` in doubles."""

    low: float = quantity("Its lower end; ``-1e12`` stands for all of R where nothing was given")
    high: float = quantity("Its upper end; ``1e12`` likewise")
    given: tuple[Fraction, Fraction] | None = quantity("The ends as they were given, None for all of R")
    scale: float = quantity("The evenly spaced points have at most this size")

    def __str__(self) -> str:
        return f"[{self.low:g}, {self.high:g}]"

    def points(self, samples: int, breakpoints: Sequence[float]) -> NDArray[np.float64]:
        """Ascending points: many decades on both sides of 0, evenly spaced ones, and some near breakpoints."""
        reach = max(abs(self.low), abs(self.high))
        top = np.log10(reach)
        sizes = np.logspace(min(_DECADES[0], top - 12.0), top, max(samples * 3 // 8, 4))
        linear = np.linspace(
            max(self.low, -self.scale), min(self.high, self.scale), int(samples * _SHARE_OF_LINEAR) + 2
        )
        kinks = np.array([b for b in breakpoints if np.isfinite(b)], dtype=float)
        near = [kinks + shift * np.maximum(np.abs(kinks), 1e-3 * self.scale) for shift in _NEAR]
        x = np.unique(np.concatenate([-sizes, sizes, linear, *near, [0.0, self.low, self.high]]))
        return np.asarray(x[(x >= self.low) & (x <= self.high)])

    @property
    def rounding_scale(self) -> float:
        """Size of ``sigma`` below which ``phi`` is taken to carry the rounding of its largest value there."""
        return min(self.scale, 1.0)

    @property
    def unit(self) -> float:
        """The power of ten in which simple numbers of the interval are written."""
        return 1.0 if self.given is None else float(f"1e{math.floor(math.log10(self.scale))}")

    def holds(self, sigma: float) -> bool:
        """Whether a point belongs to the interval."""
        return self.low <= sigma <= self.high


def domain(on: tuple[Exact, Exact] | None) -> Domain:
    """The interval of a test; ``on``: ends, exact numbers; None for all of R, of which ``|sigma| <= 1e12`` is sampled.

    Raises
    ------
    InputError
        It is not a pair of numbers in ascending order.
    """
    if on is None:
        return Domain(low=-1e12, high=1e12, given=None, scale=1.0)
    from lure.analysis.nonlinearity.pieces import domain as exact_interval

    given = exact_interval(on)
    assert given is not None, "it was given"
    ends = float(given[0]), float(given[1])
    return Domain(low=ends[0], high=ends[1], given=given, scale=max(map(abs, ends)))


# How far a nonlinearity is outside what is asserted of it, and how much of that may be rounding.

_RELATIVE = 1e-12
_ABSOLUTE = 4e-15
_ARGUMENT = 2e-15
_VALUE = 1e-15


@dataclass(frozen=True, kw_only=True, slots=True)
class Limits:
    """What a quantity must lie between, and by how much it may miss: ``lower - tolerance`` to ``upper + tolerance``."""

    lower: float | Fraction
    upper: float | Fraction
    tolerance: float

    @property
    def size(self) -> float:
        """The larger of the finite bounds, in size; 0 if there is none."""
        return max((abs(float(b)) for b in (self.lower, self.upper) if abs(b) != math.inf), default=0.0)

    @property
    def sides(self) -> tuple[int, ...]:
        """1 if there is an upper bound, -1 if there is a lower one."""
        return tuple(side for side, bound in ((1, self.upper), (-1, self.lower)) if abs(bound) != math.inf)

    def outside(self, values: Reals) -> Reals:
        """Signed distance to the limits without the tolerance, positive outside; ``-inf`` where nothing bounds."""
        return np.maximum(values - float(self.upper), float(self.lower) - values)


Kind: TypeAlias = Literal["sector", "slope", "odd"]


@described(frozen=True, kw_only=True, slots=True)
class Measure:
    """A quantity of a nonlinearity that must lie between limits, and what rounding may do to it."""

    kind: Kind = quantity(
        "``phi(sigma)/sigma`` for ``sigma`` not 0; ``(phi(y) - phi(x))/(y - x)`` for neighbouring points ``x < y``; "
        "``phi(sigma) + phi(-sigma)``, which is 0 for an odd nonlinearity"
    )
    subject: Subject = quantity("The nonlinearity")
    limits: Limits = quantity("What the quantity must lie between")
    noise: float = quantity("The absolute rounding error of the nonlinearity near 0")

    @property
    def width(self) -> int:
        """How many points one value of the quantity belongs to."""
        return 2 if self.kind == "slope" else 1

    def look(self, x: Reals) -> tuple[Reals, Reals]:
        """The quantity at ascending points, and its excess: how far it lies outside limits, tolerance and rounding.

        A quotient carries the rounding of the values and that of the argument inside the nonlinearity.
        """
        phi, coarse, size = self.subject(x), self.subject.coarseness, self.limits.size
        with np.errstate(over="ignore"):
            if self.kind == "sector":
                values = sizes = phi / x
                room = self.noise / np.abs(x)
            elif self.kind == "odd":
                values = phi + self.subject(-x)
                sizes, room = np.maximum(np.abs(phi), np.abs(values)), np.full(x.size, 2 * self.noise)
            else:
                values = sizes = np.diff(phi) / np.diff(x)
                largest, places = (np.abs(part[1:]) + np.abs(part[:-1]) for part in (phi, x))
                argument = _ARGUMENT * places * np.maximum(np.abs(values), size)
                room = (2 * self.noise + coarse * (_VALUE * largest + argument)) / np.diff(x)
            allowance = self.limits.tolerance + coarse * _RELATIVE * np.maximum(np.abs(sizes), size) + room
        excess = self.limits.outside(values) - allowance
        return values, np.where(np.isnan(excess), -np.inf, excess)


def rounding(subject: Subject, x: Reals, where: Domain) -> float:
    """The absolute rounding error granted to a nonlinearity in doubles: 4e-15 of its largest value near 0."""
    inner = x[np.abs(x) <= where.rounding_scale]
    return subject.coarseness * _ABSOLUTE * float(np.abs(subject(inner)).max(initial=0.0))


# The search for a point, or a pair of points, at which a nonlinearity breaks what is asserted of it.

_JUMPS, _PEAKS, _PAIRS = 24, 12, 16
_HALVINGS, _STEPS = 52, 40
_PARTS, _ROUNDS = 8, 18
_CLOSEST = 1e-7

Worst: TypeAlias = tuple[float, tuple[float, ...]]
"""The largest excess over limits and allowance (positive: a violation), and the point or pair where it is."""


def worst(measure: Measure, x: Reals) -> Worst:
    """The worst point or pair found: on the grid, and then where the quantity changes most or is largest.

    Parameters
    ----------
    measure : Measure
        What is measured.
    x : NDArray[np.float64]
        Ascending points to begin with, without 0 unless slopes are measured.

    Notes
    -----
    Of points, the intervals over which the quantity changes most are halved towards the larger change, which finds the
    two sides of a jump to the last digit; then the distance to the limits is maximised by a bounded search between the
    neighbours of the largest local maxima.  A spike that leaves no trace on the points is not found.

    A quotient over an interval is a mean of those over its parts: consecutive pairs are the worst of all pairs of
    points.  The search divides the worst intervals, with their neighbours, until they are ``1e-7`` of ``|sigma|`` long.
    """
    values, best = _worst(measure, x)
    if best[0] > 0 or x.size < 3:
        return best
    for found in (_closer if measure.kind == "slope" else _between)(measure, x, values):
        best = max(best, found)
        if best[0] > 0:
            break
    return best


def _worst(measure: Measure, x: Reals) -> tuple[Reals, Worst]:
    """The quantity at points, and the worst of them."""
    values, excess = measure.look(x) if x.size else (x, x)
    if excess.size == 0:
        return values, (-np.inf, ())
    i = int(np.argmax(excess))
    return values, (float(excess[i]), tuple(map(float, x[i : i + measure.width])))


def _between(measure: Measure, x: Reals, values: Reals) -> Iterator[Worst]:
    """The worst points beside what looks like jumps, and at local maxima between the points."""
    yield _worst(measure, _beside_jumps(measure, x, values))[1]
    for side in measure.limits.sides:
        yield _worst(measure, _peaks(measure, x, side * values, side))[1]


def _closer(measure: Measure, x: Reals, values: Reals) -> Iterator[Worst]:
    """The worst pairs of the steepest intervals and of those where the slope changes most."""
    turns = np.argsort(-np.abs(np.diff(values, prepend=values[0])))[:_PAIRS]
    for side in measure.limits.sides:
        for i in sorted({*_local_maxima(side * values)[:_PAIRS], *turns}):
            yield _divided(measure, float(x[max(i - 1, 0)]), float(x[min(i + 2, x.size - 1)]), side)


def _beside_jumps(measure: Measure, x: Reals, values: Reals) -> Reals:
    """Points on both sides of the largest changes between neighbours of one sign."""
    changes = np.where(x[:-1] * x[1:] > 0, np.abs(np.diff(values)), 0.0)
    chosen = np.argsort(-changes)[:_JUMPS]
    chosen = chosen[changes[chosen] > 0]
    low, high, at_low, at_high = x[chosen], x[chosen + 1], values[chosen], values[chosen + 1]
    met = [low, high]
    for _ in range(_HALVINGS):
        middle = 0.5 * low + 0.5 * high
        inner = (middle > low) & (middle < high)
        if not inner.any():
            break
        low, high, at_low, at_high, middle = (a[inner] for a in (low, high, at_low, at_high, middle))
        at_middle = measure.look(middle)[0]
        met.append(middle)
        left = np.abs(at_middle - at_low) >= np.abs(at_high - at_middle)
        low, at_low = np.where(left, low, middle), np.where(left, at_low, at_middle)
        high, at_high = np.where(left, middle, high), np.where(left, at_middle, at_high)
    return np.concatenate(met)


def _peaks(measure: Measure, x: Reals, values: Reals, side: int) -> Reals:
    """Points towards the local maxima of the values, by a bounded search between the neighbours of the largest."""
    from scipy.optimize import minimize_scalar

    met: list[float] = []

    def inwards(sigma: float) -> float:
        """What is minimised."""
        met.append(float(sigma))
        return -side * float(measure.look(np.array([sigma]))[0][0])

    for i in _local_maxima(values)[:_PEAKS]:
        low, high = float(x[max(i - 1, 0)]), float(x[min(i + 1, x.size - 1)])
        for a, b in ((low, float(x[i])), (float(x[i]), high)):
            if a < b and a * b > 0:
                options = {"maxiter": _STEPS, "xatol": 1e-12 * (b - a)}
                minimize_scalar(inwards, bounds=(a, b), method="bounded", options=options)
    return np.array(met)


def _local_maxima(values: Reals) -> NDArray[np.intp]:
    """Indices of local maxima that are higher than a neighbour, the highest first."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    left, right = values - padded[:-2], values - padded[2:]
    with np.errstate(invalid="ignore"):
        found = np.flatnonzero((left >= 0) & (right >= 0) & ((left > 0) | (right > 0)))
    return np.asarray(found[np.argsort(-values[found], kind="stable")])


def _divided(measure: Measure, low: float, high: float, side: int) -> Worst:
    """The worst pair of an interval, which is divided around the steepest part again and again."""
    best: Worst = (-np.inf, ())
    for _ in range(_ROUNDS):
        x = np.unique(np.linspace(low, high, _PARTS + 1))
        if x.size < 3 or (high - low) / _PARTS < _CLOSEST * max(abs(low), abs(high)):
            break
        values, found = _worst(measure, x)
        best = max(best, found)
        i = int(np.argmax(side * values))
        low, high = float(x[max(i - 1, 0)]), float(x[min(i + 2, x.size - 1)])
    return best


_PLAIN = (1.0, 2.0, 0.5, 3.0, 10.0, 0.1, 5.0, 0.2, 1.5, 100.0, 0.01, 1000.0, 0.001)
_SHARE = 0.2
_DIGITS = 17
_HALF = 0.5


def simplest(
    excess: Callable[[tuple[float, ...]], float], worst: Worst, *, size: float, unit: float = 1.0
) -> tuple[float, ...]:
    """A point or a pair of numbers of few digits with a violation worth showing.

    Parameters
    ----------
    excess : callable
        How far a point or a pair violates, positive if it does; ``-inf`` where nothing is asserted.
    worst : (excess, place)
        The violation to begin with.
    size : float
        Size of the bounds: a violation of a fifth of it is worth showing, however large the worst is.
    unit : float
        Power of ten in which plain numbers are tried.
    """
    most, places = worst
    enough = _SHARE * min(most, size if size > 0 else 1.0)
    tried = _pairs(places[0], places[1], unit) if len(places) > 1 else _points(places[0], unit)
    return next((place for place in tried if excess(place) >= enough), places)


def _points(worst: float, unit: float) -> Iterator[tuple[float]]:
    for plain in _plain(unit):
        yield (plain,)
        yield (-plain,)
    for digits in range(1, _DIGITS + 1):
        step = _step(worst, digits)
        steps = round(worst / step)
        for number in (steps, steps + 1, steps - 1):
            yield (float(f"{number * step:.{digits}g}"),)


def _pairs(low: float, high: float, unit: float) -> Iterator[tuple[float, float]]:
    for plain in _plain(unit):
        for sign in (1.0, -1.0) if high > 0 else (-1.0, 1.0):
            for shares in ((0, 1), (1, 2), (_HALF, 1)):
                first, second = sorted(sign * share * plain + 0.0 for share in shares)
                yield first, second
    middle = 0.5 * low + 0.5 * high
    for digits in range(1, _DIGITS + 1):
        step = _step(max(abs(low), abs(high)), digits)
        numbers = [math.floor(middle / step) + shift for shift in (-1, 0, 1, 2)]
        grid = [float(f"{number * step:.{digits}g}") for number in numbers]
        for i, j in ((1, 2), (0, 1), (2, 3), (0, 2), (1, 3)):
            if grid[i] < grid[j]:
                yield grid[i], grid[j]


def _plain(unit: float) -> list[float]:
    """The plainest numbers, in a unit."""
    return [float(f"{plain * unit:.3g}") for plain in _PLAIN]


def _step(value: float, digits: int) -> float:
    """The last of so many decimal digits of a number."""
    return float(f"1e{math.floor(math.log10(abs(value))) - digits + 1}") or 5e-324 if value else 1e-12

"""The law under test, whatever it came as: one function from arrays of doubles to arrays of doubles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial

from lure.arrays import ArrayLike, Reals, np
from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import names

_PROBES = (-1.25, -0.5, 0.0, 0.5, 1.25)
_MOST_BREAKPOINTS = 1000


class NotANumber(Exception):
    """The law has no finite real value at a point; ``sigma`` is the point, the text says what came instead."""

    def __init__(self, sigma: float, what: str) -> None:
        super().__init__(what)
        self.sigma = sigma


@dataclass(slots=True)
class Subject:
    """A law to be tested.

    Attributes
    ----------
    name : str
        What messages call it.
    law : object
        What was given: an exact law or a formula as :func:`lure.analysis.nonlinearity.nonlinearity_bounds` takes it,
        or a callable.
    call : callable
        Its values.
    known : bool
        Whether it is a formula or a law of the library, which can be decided by more than sampling.
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
    law: object
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
        """Values of a law that takes arrays, infinite or nan where floating point has no better."""
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
        except Exception as error:  # whatever the law raises is what the message is about
            says = f" ({error})" if str(error) else ""
            raise NotANumber(sigma, f"raises {type(error).__name__}{says}"[:160]) from None
        number = _real(value)
        if number is None or not math.isfinite(number):
            raise NotANumber(sigma, f"is {value!r:.60}" if number is None else f"is {number}")
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
    """The law as something to evaluate.

    Parameters
    ----------
    phi : callable, law of lure.nonlinearities, Expression or str
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
            f"phi is {phi!r:.60}; give a function, a law of lure.nonlinearities or a formula in sigma as text"
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
    except InputError:
        try:
            return Expression.parse(text, variables=("x",), field="phi")
        except InputError:
            pass
        raise


def _takes_arrays(found: Subject) -> bool:
    """Whether an array is answered as its numbers are; refuses a law whose value depends on more than ``sigma``."""
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
            "and a slope are those of a function of sigma alone, without memory or chance"
        )
    together = found._array(probes)
    return together is not None and len(alone) == len(probes) and np.allclose(together, alone, rtol=1e-12, atol=0.0)


def _coarseness(found: Subject) -> float:
    """How much coarser than doubles the numbers are that a law returns."""
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

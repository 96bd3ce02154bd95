"""Loops: block and nonlinearity, a gain moved between the two, and the loop as a system of python-control."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, cast

from lure.arrays import Reals, np
from lure.classes import NonlinearityClass
from lure.errors import InputError, Reason
from lure.exact import Exact, exact_number
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.shifted import shifted_class
from lure.plants.block import LinearBlock, Plant, StructuredPlant
from lure.plants.conversion import exact_block, one_channel
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Names
from lure.plants.state_space import StateSpace
from lure.record import Record, quantity
from lure.record.values import exact_text

if TYPE_CHECKING:
    from collections.abc import Callable

    import control

# The loop: a block in negative feedback with a nonlinearity.


class LoopModel(ABC):
    """A model that is a loop by itself, such as a rod at an obstacle."""

    @abstractmethod
    def parts(self, *, discretised: bool) -> tuple[StructuredPlant, Nonlinearity | None]:
        """Its plant, or an approximation of it by finitely many states, and its nonlinearity if it is one alone."""


class Loop(Record, kw_only=False):
    r"""A Lur'e loop ``sigma = H mu``, ``mu = -phi(sigma)``.

    The minus sign stands here and nowhere else: blocks carry ``H`` from ``mu`` to ``sigma``, nonlinearities return
    ``phi``.

    Parameters
    ----------
    block : Block
        The linear part; a system of python-control or scipy.signal, coefficients or a formula become the block that
        :func:`lure.as_plant` makes of them.
    nonlinearity : Nonlinearity
        The nonlinearity, with the sector its author vouches for; ``control.saturation_nonlinearity`` becomes a
        ``Saturation``.

    Raises
    ------
    InputError
        The block is none, or the nonlinearity has no sector, or a memory.

    Examples
    --------
    >>> from lure import Saturation
    >>> print(Loop(([1], [1, 3, 2, 0]), Saturation(gain=5)).nonlinearity.sector)
    [0, 5]
    """

    block: Plant
    nonlinearity: Nonlinearity = quantity("", key="law")
    _kind = "loop"
    _title = "Loop: sigma = H mu, mu = -phi(sigma)"

    def __post_init__(self) -> None:
        if not hasattr(self.block, "transfer"):
            from lure.plants.conversion import one_channel

            object.__setattr__(self, "block", one_channel(self.block))
        if not hasattr(self.nonlinearity, "sector"):
            from lure.nonlinearities.reading import as_nonlinearity

            object.__setattr__(self, "nonlinearity", as_nonlinearity(self.nonlinearity))

    def to_control(self, *, pade: int | None = None) -> control.NonlinearIOSystem:
        """The closed loop as a nonlinear system of python-control, with a load ``r`` added to ``mu``.

        ``x' = A x + B mu``, ``sigma = C x + D mu``, ``mu = r - phi(sigma)`` (or ``x[k+1] = ..``): input ``r``, output
        ``sigma``.  Where the block was given by matrices these are its matrices, and its states with their names: an
        initial state means what it means there.  Else they are the controllable companion form of the transfer
        function, hidden modes kept.

        Parameters
        ----------
        pade : int, optional
            Order of the approximation that stands for a dead time; without it a dead time is refused.

        Raises
        ------
        InputError
            The block has no states (a measurement, or the rod itself), or a direct term ``D`` with which the loop
            need not define ``sigma``: ``1 + D k <= 0`` for a slope ``k`` of the nonlinearity, or its slopes are not
            known.

        Notes
        -----
        For ``control.input_output_response``.  A simulation is one solution: it proves nothing about the others.

        Examples
        --------
        >>> import control
        >>> from lure.nonlinearities import Saturation
        >>> closed = Loop(control.tf([1], [1, 0]), Saturation()).to_control()
        >>> closed.nstates, closed.input_labels, closed.output_labels
        (1, ['r'], ['sigma'])
        """
        return closed_loop(self.block, self.nonlinearity, pade=pade)

    def _rows(self) -> Iterator[tuple[object, ...]]:
        return loop_rows(self.block, self.nonlinearity)


def loop_rows(block: object, nonlinearity: object) -> Iterator[tuple[str, str]]:
    """What the table of a loop says about its two parts.

    ``block``, ``nonlinearity``: the parts; the nonlinearity may be missing.
    """
    from lure.nonlinearities.properties import nonlinearity_text

    formula = type(block).__str__ not in (object.__str__, Record.__str__)
    yield "H", str(block) if formula else type(block).__name__
    if nonlinearity is not None:
        known = cast("Nonlinearity", nonlinearity)
        yield "phi", nonlinearity_text(known)
        yield "sector of phi", str(known.sector)


class Transformed(Record):
    r"""A loop with part of the nonlinearity's gain moved into the block; stable exactly if the original is.

    With ``psi(sigma) = phi(sigma) - gain sigma``, the loops ``sigma = H mu, mu = -phi(sigma)`` and
    ``sigma = H' nu, nu = -psi(sigma)``, ``H' = H/(1 + gain H)``, have the same solutions.

    """

    block: RationalPlant = quantity("``H'``, hidden modes of ``H`` kept", label="H'")
    nonlinearity_class: NonlinearityClass = quantity(
        "The class of ``psi``", key="class", label="psi", form=lambda known: str(known).replace("phi", "psi")
    )
    gain: Fraction = quantity(
        "What was moved from the nonlinearity into the block, in total", label="gain moved", form=str
    )
    steps: tuple[str, ...] = quantity("What was replaced by what, one line each", label="")
    _kind = "transformed loop"
    _title = "The same loop, with a gain moved from the nonlinearity into the block"

    def undo(self, k: Exact) -> Fraction | float:
        """A gain ``k`` (of ``psi``) as one of the original ``phi``: ``k + gain``, exactly; an infinite ``k`` stays.

        Raises
        ------
        InputError
            ``k`` is not a number.
        """
        if isinstance(k, float) and math.isinf(k):
            return k
        return exact_number(k, "Transformed.undo: k") + self.gain

    def undo_bracket(self, low: float, high: float) -> tuple[float, float]:
        """Bounds on a gain of ``psi`` as bounds on one of the original nonlinearity, in doubles rounded outwards.

        The lower bound never rises: a class ``[lower, k]`` proved for the shifted loop up to ``low`` is proved for the
        original up to the first of the two.

        Raises
        ------
        InputError
            A bound is not a number.
        """
        return _rounded(self.undo(low), -math.inf), _rounded(self.undo(high), math.inf)

    def then(self, gain: Exact) -> Transformed:
        """The loop after one more pole shift; see :func:`pole_shift`.

        Raises
        ------
        InputError
            As for :func:`pole_shift`.
        """
        further = pole_shift(self.block, self.nonlinearity_class, gain)
        return Transformed(
            block=further.block,
            nonlinearity_class=further.nonlinearity_class,
            gain=self.gain + further.gain,
            steps=(*self.steps, *further.steps),
        )

    def to_control(self) -> control.TransferFunction:
        """The shifted block ``H'`` as a ``control.TransferFunction``."""
        return self.block.to_control()

    @property
    def _notes(self) -> tuple[str, ...]:
        return self.steps

    def __str__(self) -> str:
        return "\n".join(self.steps)


def sector_shift(block: object, nonlinearity_class: NonlinearityClass) -> Transformed:
    """The same loop with the sector ``[k1, k2]`` brought to ``[0, k2 - k1]``.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        The block ``H``: whatever :func:`lure.as_plant` makes a ``RationalPlant`` of.
    nonlinearity_class : NonlinearityClass
        Its sector has a finite lower bound ``k1``; slope bounds move along, parity and time dependence stay.

    Returns
    -------
    Transformed
        The block ``H/(1 + k1 H)`` with the class of ``phi - k1 sigma``.

    Raises
    ------
    InputError
        ``k1`` is ``-inf``, or the loop is not well posed: ``1 + k1 H(inf) = 0``.

    Examples
    --------
    >>> from lure.classes import Sector
    >>> shifted = sector_shift(RationalPlant([1], [1, 1, -1]), NonlinearityClass(sector=Sector(2, 5)))
    >>> print(shifted)
    phi in the sector [2, 5] is replaced by psi(sigma) = phi(sigma) - 2 sigma: psi in the sector [0, 3]
    H = 1 / (s^2 + s - 1) is replaced by H/(1 + 2 H) = 1 / (s^2 + s + 1)
    a gain k of psi is the gain k + 2 of phi
    >>> shifted.undo(3)
    Fraction(5, 1)
    """
    lower = nonlinearity_class.sector.lower
    if lower == -math.inf:
        raise InputError(
            f"sector_shift needs a finite lower bound, and the sector is {nonlinearity_class.sector}; state the "
            f"mirrored loop "
            "instead: k2 sigma - phi(sigma) lies in [0, inf], with the block -H/(1 + k2 H)",
            code=Reason.NO_LOWER_END,
        )
    return pole_shift(block, nonlinearity_class, lower)


def pole_shift(block: object, nonlinearity_class: NonlinearityClass, gain: Exact) -> Transformed:
    """The same loop with ``gain`` moved from the nonlinearity into the block, which moves the block's poles.

    An unstable or critical block is made stable by a gain for which the linear loop is; ``-gain`` undoes it.

    Parameters
    ----------
    block : RationalPlant, control or scipy.signal system, (numerator, denominator), (A, B, C, D), text
        The block ``H``: whatever :func:`lure.as_plant` makes a ``RationalPlant`` of.
    nonlinearity_class : NonlinearityClass
        The class of ``phi``.
    gain : int, float, Fraction or Decimal
        Finite.

    Returns
    -------
    Transformed
        The block ``H/(1 + gain H) = n/(d + gain n)`` with the class of ``phi - gain sigma``.

    Raises
    ------
    InputError
        ``gain`` is not a finite number, or the loop is not well posed: ``1 + gain H(inf) = 0``.

    Examples
    --------
    >>> from lure import Sector
    >>> shifted = pole_shift(RationalPlant([1], [1, -1]), NonlinearityClass(sector=Sector(2, 4)), gain=2)
    >>> print(shifted.block, "|", shifted.nonlinearity_class)
    1 / (s + 1) | phi in the sector [0, 2]
    """
    g, exact = exact_number(gain, "pole_shift: gain"), exact_block(block, "a loop shift")
    if g == 0:
        return Transformed(
            block=exact, nonlinearity_class=nonlinearity_class, gain=g, steps=("nothing is shifted: the gain is 0",)
        )
    moved, shifted = shifted_block(exact, g), shifted_class(nonlinearity_class, g)
    size = exact_text(abs(g))
    sign, back = ("-", "+") if g > 0 else ("+", "-")
    steps = (
        f"{nonlinearity_class} is replaced by psi(sigma) = phi(sigma) {sign} {size} sigma: "
        f"{str(shifted).replace('phi', 'psi')}",
        f"H = {exact} is replaced by H/(1 {back} {size} H) = {moved}",
        f"a gain k of psi is the gain k {back} {size} of phi",
    )
    return Transformed(block=moved, nonlinearity_class=shifted, gain=g, steps=steps)


def shifted_block(block: RationalPlant, gain: Fraction) -> RationalPlant:
    """``H/(1 + gain H) = n/(d + gain n)``, hidden modes kept.

    ``block``: the block ``H = n/d``; ``gain``: the feedback around it.

    Raises
    ------
    InputError
        ``1 + gain H(inf) = 0``: the feedback has no proper closed loop.
    """
    if 1 + gain * block.feedthrough == 0:
        raise InputError(
            f"the loop is not well posed: 1 + gain D = 0 with gain = {exact_text(gain)} and D = H(inf) = "
            f"{exact_text(block.feedthrough)}; choose another gain",
            code=Reason.ILL_POSED,
        )
    pairs = zip_longest(reversed(block.denominator), reversed(block.numerator), fillvalue=Fraction(0))
    closed = [d + gain * n for d, n in pairs]
    return RationalPlant(block.numerator, closed[::-1], block.dt)


def _rounded(value: Fraction | float, towards: float) -> float:
    """The double nearest to an exact number on the side named."""
    if isinstance(value, float):
        return value
    try:
        nearest = float(value)
    except OverflowError:
        nearest = math.copysign(math.inf, value)
        return nearest if nearest == towards else math.nextafter(nearest, 0.0)
    wrong = nearest > value if towards < 0 else nearest < value
    return math.nextafter(nearest, towards) if wrong else nearest


# The closed loop as a nonlinear system of python-control.


@dataclass(frozen=True, eq=False, slots=True)
class _Realised:
    """``x' = A x + B mu``, ``sigma = C x + D mu``; ``dt = 0`` in continuous time, True where no period is stated."""

    A: Reals
    B: Reals
    C: Reals
    D: float
    dt: float | bool
    names: Names | None = None


def closed_loop(block: object, nonlinearity: Nonlinearity, *, pade: int | None = None) -> control.NonlinearIOSystem:
    """The loop with a load ``r``: ``mu = r - phi(sigma)``; see :meth:`lure.Loop.to_control`.

    Parameters
    ----------
    block : object
        The linear part; one that holds a ``LinearPlant`` as its ``block`` stands for that.
    nonlinearity : Nonlinearity
        What closes the loop.
    pade : int, optional
        Order of the approximation of a dead time.

    Raises
    ------
    InputError
        The block has no states, or its direct term ``D`` leaves ``sigma + D phi(sigma)`` without an inverse.
    """
    import control

    linear = _realised(block, pade)
    if linear.D:
        _demand_solvable(nonlinearity, linear.D)

    def force(x: Reals, r: Reals) -> tuple[float, float]:
        """``sigma`` and ``mu = r - phi(sigma)``, where ``sigma = C x + D mu``."""
        free = float(linear.C @ x) + linear.D * float(r[0])
        sigma = _solved(nonlinearity, linear.D, free) if linear.D else free
        return sigma, float(r[0]) - float(nonlinearity(sigma))

    def rate(_t: float, x: Reals, r: Reals, _params: dict[str, Any]) -> Reals:
        """``A x + B mu``: the derivative, or the next state."""
        return np.asarray(linear.A @ x + linear.B * force(x, r)[1])

    def output(_t: float, x: Reals, r: Reals, _params: dict[str, Any]) -> Reals:
        """``sigma``."""
        return np.array([force(x, r)[0]])

    make: Callable[..., control.NonlinearIOSystem] = control.nlsys
    states = len(linear.B) if linear.names is None else list(linear.names.states)
    return make(rate, output, inputs=["r"], outputs=["sigma"], states=states, dt=linear.dt, name="lure")


def _realised(block: object, pade: int | None) -> _Realised:
    block = getattr(block, "block", block)
    if isinstance(block, LinearBlock):
        return _Realised(block.dense(), block.b1, block.c, 0.0, 0.0)
    if isinstance(block, DelayPlant):
        block = one_channel(block.to_control(pade=pade))
    if isinstance(block, StateSpace):
        return _Realised(block.A, block.B, block.C, block.D, block.period, block.names)
    if not isinstance(block, RationalPlant) or block.order == 0:
        raise InputError(
            f"a {type(block).__name__} without states cannot be simulated; give coefficients of order 1 or more, "
            "matrices or a formula in s or z"
        )
    equations = block.realisation
    return _Realised(*equations.doubles(), block.period, equations.names)


def _demand_solvable(nonlinearity: Nonlinearity, direct: float) -> None:
    """Refuse a direct term with which the loop need not define ``sigma``."""
    bounds = getattr(nonlinearity, "slope_bounds", None)
    ends = () if bounds is None else (bounds.lower, bounds.upper)
    if not ends or not all(math.isfinite(end) and 1 + direct * end > 0 for end in ends):
        known = "unknown" if bounds is None else str(bounds)
        raise InputError(
            f"the block has the direct term D = {direct:g}: the loop is only sure to define sigma where 1 + D k > 0 "
            f"for every slope k of phi, and these are {known}; give a nonlinearity whose slopes allow it"
        )


def _solved(nonlinearity: Nonlinearity, direct: float, free: float) -> float:
    """The one ``sigma`` with ``sigma + D phi(sigma) = free``: the sector says between which two numbers it lies."""
    from scipy.optimize import brentq

    slopes = nonlinearity.slope_bounds  # type: ignore[attr-defined]  # _demand_solvable has seen them
    ends = sorted(free / (1.0 + direct * float(end)) for end in (slopes.lower, slopes.upper))
    low, high = ends[0] - 1e-12 * abs(ends[0]), ends[1] + 1e-12 * abs(ends[1])
    if low == high:
        return low
    return float(
        brentq(lambda sigma: sigma + direct * float(nonlinearity(sigma)) - free, low, high, xtol=1e-300, rtol=1e-14)
    )

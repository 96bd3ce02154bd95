"""Rational transfer functions with exact coefficients, in continuous and in discrete time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from lure.arrays import ArrayLike, NDArray, np
from lure.errors import InputError, Reason
from lure.exact import Exact, exact_number, nearest_double
from lure.plants.realisation import Realisation, companion
from lure.record import Record, derived, quantity
from lure.record.values import decimal_text

if TYPE_CHECKING:
    import control

MAX_ORDER = 1000


class RationalPlant(Record):
    r"""A block ``sigma = H mu`` with ``H = numerator / denominator``, coefficients exact and in descending powers.

    The denominator is the characteristic polynomial of the system behind ``H``: a factor common to both is kept, as a
    mode that input or output does not see, and the order is the degree of the denominator.  In a loop
    ``mu = -phi(sigma)``, see :class:`lure.loop.Loop`.

    Parameters
    ----------
    numerator, denominator : sequence of int, float, Fraction or Decimal
        Coefficients of ``s`` (continuous time) or ``z`` (discrete time), highest power first; leading zeros are dropped
        and both are divided by the leading coefficient of the denominator.  A float means the double it is; pass
        ``Fraction("0.1")`` for one tenth.
    dt : int, float, Fraction, True or None
        Sampling time [s] of a discrete-time block; True where its period is not stated, which counts as 1; None for
        continuous time.
    matrices : Realisation or None
        The matrices that the block was given by, for whoever needs its states: python-control, simulations, initial
        states.  What is proved of a block is about ``H``, and two blocks are equal if their ``H`` and ``dt`` are.

    Raises
    ------
    InputError
        A coefficient is not a finite number, the denominator is zero, ``H`` is improper, its order exceeds 1000,
        ``dt`` is not positive, or the matrices have another number of states.

    Examples
    --------
    >>> block = RationalPlant([1], [1, 3, 2, 0])
    >>> print(block, block.order)
    1 / (s^3 + 3 s^2 + 2 s) 3
    """

    numerator: tuple[Fraction, ...] = quantity("", label="")
    denominator: tuple[Fraction, ...] = quantity("", label="")
    dt: Fraction | None = quantity("", label="time", form=lambda dt: time_text(dt))
    matrices: Realisation | None = quantity("", hidden=True)
    any_period: bool = quantity("", hidden=True)
    _kind, _said = "rational block", "text"
    _notes = ("From mu to sigma; in a loop mu = -phi(sigma).",)

    def __init__(
        self,
        numerator: Sequence[Exact],
        denominator: Sequence[Exact],
        dt: int | float | Fraction | None = None,
        *,
        matrices: Realisation | None = None,
    ) -> None:
        top, bottom = _coefficients(numerator, "numerator"), _coefficients(denominator, "denominator")
        if not bottom:
            raise InputError("the denominator is zero; give its coefficients, highest power first")
        if len(top) > len(bottom):
            raise InputError(
                f"the transfer function is improper: the numerator has degree {len(top) - 1}, the denominator "
                f"{len(bottom) - 1}; give a denominator of at least the numerator's degree"
            )
        if len(bottom) - 1 > MAX_ORDER:
            raise InputError(f"RationalPlant has order {len(bottom) - 1}; exact polynomials stop at {MAX_ORDER}")
        step = sampling_period(dt, "RationalPlant.dt")
        if matrices is not None and matrices.order != len(bottom) - 1:
            raise InputError(
                f"RationalPlant.matrices have {matrices.order} states and the denominator has degree "
                f"{len(bottom) - 1}; give the matrices of this block"
            )
        lead = bottom[0]
        object.__setattr__(self, "numerator", tuple(c / lead for c in top) or (Fraction(0),))
        object.__setattr__(self, "denominator", tuple(c / lead for c in bottom))
        object.__setattr__(self, "dt", step)
        object.__setattr__(self, "matrices", matrices)
        object.__setattr__(self, "any_period", dt is True)

    @property
    @derived()
    def order(self) -> int:
        """Degree of the denominator: the number of states behind ``H``."""
        return len(self.denominator) - 1

    @property
    @derived(key="", label="H(infinity)", form=lambda value: decimal_text(value))
    def feedthrough(self) -> Fraction:
        """``H(infinity)``, the direct term ``D``."""
        return self.numerator[0] if len(self.numerator) == len(self.denominator) else Fraction(0)

    @property
    def realisation(self) -> Realisation:
        """State equations: the matrices that the block was given by, else the companion form of its coefficients.

        For everything that has states: a simulation, an initial state.  The companion form of a finely sampled plant
        loses its stability when it is rounded to doubles; the matrices that somebody works with do not.
        """
        return companion(self) if self.matrices is None else self.matrices

    @property
    def period(self) -> float | Literal[True]:
        """The sampling time as python-control has it: 0 in continuous time, True where none is stated."""
        return True if self.any_period else float(self.dt or 0)

    @property
    def variable(self) -> str:
        """``s`` in continuous time, ``z`` in discrete time."""
        return "s" if self.dt is None else "z"

    def transfer(self, s: ArrayLike) -> NDArray[np.complex128]:
        """``H`` at complex ``s`` (or ``z``), elementwise, in floating point; not finite at a pole."""
        # s = q x with a power of two q near the size of the points: what then underflows beside the largest
        # coefficient is negligible there
        points = np.asarray(s, dtype=complex)
        q = _power_of_two(points)
        values, sizes = [], []
        for side in (self.numerator, self.denominator):
            scaled = [c * q ** (len(side) - 1 - i) for i, c in enumerate(side)]
            sizes.append(max(abs(c) for c in scaled))
            with np.errstate(over="ignore", invalid="ignore"):
                values.append(np.polyval([float(c / (sizes[-1] or 1)) for c in scaled], points / float(q)))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray(values[0] / values[1] * nearest_double(sizes[0] / sizes[1]))

    def to_control(self) -> control.TransferFunction | control.StateSpace:
        """The block for python-control: its matrices with their names if it was given by matrices, else coefficients.

        Returns
        -------
        control.StateSpace or control.TransferFunction
            Entries rounded to doubles, which changes nothing where they are doubles.

        Raises
        ------
        InputError
            A number exceeds the largest double.
        """
        import control

        if self.matrices is not None:
            return self.matrices.to_control(dt=self.period)

        try:
            top, bottom = ([float(c) for c in side] for side in (self.numerator, self.denominator))
        except OverflowError:
            raise InputError(
                "a coefficient of this block exceeds the largest double, 1.8e308; rescale the unit of time",
                code=Reason.RANGE,
            ) from None
        return control.TransferFunction(top, bottom, self.period)

    def __str__(self) -> str:
        top, bottom = polynomial_text(self.numerator, self.variable), polynomial_text(self.denominator, self.variable)
        if self.order == 0:
            return top
        sides = [f"({side})" if " " in side else side for side in (top, bottom)]
        return " / ".join(sides)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: coefficients as text ``p/q``, highest power first, exactly; the matrices if it has any."""
        return super().to_dict() | ({} if self.matrices is None else {"matrices": self.matrices.to_dict()})

    @property
    def _title(self) -> str:
        return f"H({self.variable}) = {self}"

    def _repr_latex_(self) -> str:
        top, bottom = (_latex(polynomial_text(side, self.variable)) for side in (self.numerator, self.denominator))
        fraction = top if self.order == 0 else rf"\frac{{{top}}}{{{bottom}}}"
        return rf"$\displaystyle H({self.variable}) = {fraction}$"


def sampling_period(dt: object, name: str) -> Fraction | None:
    """A sampling time as it is kept: an exact number, 1 where True says that none is stated.

    ``dt``: a positive number, True, or None for continuous time; ``name``: what it is, for errors.

    Raises
    ------
    InputError
        It is none of these.
    """
    if dt is None or dt is True:
        return None if dt is None else Fraction(1)
    step = exact_number(dt, name)
    if step <= 0:
        raise InputError(f"{name} is {float(step):g}; give a positive time, or None for continuous time")
    return step


def time_text(dt: Fraction | None) -> str:
    """The kind of time, in words; ``dt``: sampling time [s]."""
    return "continuous" if dt is None else f"discrete, dt = {float(dt):g} s"


def polynomial_text(coefficients: Sequence[Fraction], variable: str) -> str:
    """A polynomial as people write it: ``s^3 + 3 s^2 - 0.5 s``; coefficients as decimals of up to six digits."""
    parts: list[str] = []
    degree = len(coefficients) - 1
    for power, value in zip(range(degree, -1, -1), coefficients, strict=True):
        if value == 0:
            continue
        size = decimal_text(abs(value))
        letter = "" if power == 0 else variable if power == 1 else f"{variable}^{power}"
        term = letter if size == "1" and letter else f"{size} {letter}".strip()
        sign = "-" if value < 0 else "+"
        parts.append(f"{sign} {term}" if parts else f"-{term}" if value < 0 else term)
    return " ".join(parts) or "0"


def _latex(text: str) -> str:
    """A polynomial as LaTeX: exponents and powers of ten in braces."""
    powers = re.sub(r"e([+-])0*(\d+)", lambda m: rf"\cdot 10^{{{m[1].strip('+')}{m[2]}}}", text)
    return re.sub(r"\^(\d+)", r"^{\1}", powers)


def _power_of_two(points: NDArray[np.complex128]) -> Fraction:
    sizes = np.abs(points)
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    return Fraction(2) ** round(float(np.median(np.log2(sizes)))) if sizes.size else Fraction(1)


def _coefficients(values: Sequence[Exact], name: str) -> list[Fraction]:
    try:
        listed = list(values)
    except TypeError:
        raise InputError(f"RationalPlant.{name} is {values!r}; give a list of coefficients") from None
    exact = [
        value if isinstance(value, Fraction) else exact_number(value, f"RationalPlant.{name}[{i}]")
        for i, value in enumerate(listed)
    ]
    while exact and exact[0] == 0:
        exact.pop(0)
    return exact

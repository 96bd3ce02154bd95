"""A discrete-time block on the unit circle: what the slope criteria in discrete time have in common."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from flint import fmpq, fmpq_poly

from lure.analysis.inequality.checks import admitted_plant
from lure.analysis.numerics.polynomial import from_descending, to_fmpq, to_fraction
from lure.analysis.numerics.trigonometric import Laurent
from lure.arrays import NDArray, np
from lure.exact import nearest_double
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

STEPS_BACK = (1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5)
LEAST_INVERSE = 1e-12


@described(frozen=True, slots=True)
class DiscretePlant:
    r"""The block ``H = n/d`` behind ``psi(sigma) = phi(sigma) - lower sigma``, in powers of ``z``.

    With ``mu = -phi(sigma)`` and the given ``H_0 = n/d_0`` it is ``H = H_0/(1 + lower H_0)``, ``d = d_0 + lower n``.
    """

    n: Laurent = quantity("Numerator")
    d: Laurent = quantity("Denominator")
    lower: Fraction = quantity("The slope taken out of ``phi``")

    @classmethod
    def of(cls, block: RationalPlant, lower: Fraction, criterion: str, *, critical: bool = False) -> DiscretePlant:
        """The block after the shift by ``lower``.

        Parameters
        ----------
        block : RationalPlant
            In discrete time.
        lower : Fraction
            Lower slope of the class.
        criterion : str
            Who asks, for the messages.
        critical : bool
            Whether a simple pole at ``z = 1`` is covered.

        Raises
        ------
        InputError
            The block is in continuous time, or ``1 + lower D = 0``.
        AssumptionError
            A pole of the shifted block, hidden modes included, does not lie inside the unit circle.
        """
        admitted_plant(block, lower, criterion, discrete=True, critical=critical)
        n = from_descending(block.numerator)
        return cls(Laurent(n), Laurent(from_descending(block.denominator) + to_fmpq(lower) * n), lower)

    @property
    def feedthrough(self) -> Fraction:
        """``H(infinity)``."""
        degree = self.d.p.degree()
        return to_fraction(self.n.p[degree] / self.d.p[degree])

    @property
    def critical(self) -> bool:
        """Whether ``d`` has its root ``z = 1``."""
        return bool(self.d.p(fmpq(1)) == 0)

    @property
    def cross(self) -> Laurent:
        """``n`` times the conjugate of ``d``: ``H = cross / |d|^2`` on the circle."""
        return self.n * self.d.conjugate()

    @property
    def square(self) -> fmpq_poly:
        """``|d|^2`` as a polynomial in ``c = cos w``, positive on ``[-1, 1]``."""
        return (self.d * self.d.conjugate()).real_part()

    def well_posed(self, K: Fraction) -> bool:
        """Whether ``1 + kappa D > 0`` for ``kappa`` in ``[0, K]``: ``sigma + D phi(sigma) = r`` has one solution."""
        return 1 + K * self.feedthrough > 0

    @property
    def gain(self) -> Fraction:
        """The unit in which the searches measure ``H``, so that no number leaves the range of doubles."""
        top = max((abs(c) for c in self.n.p.coeffs()), default=fmpq(1))
        return to_fraction(top / max(abs(c) for c in self.d.p.coeffs()))

    def coefficients(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Numerator and denominator of ``H / gain``, descending powers, rounded to doubles."""
        top, bottom = list(reversed(self.n.p.coeffs())), list(reversed(self.d.p.coeffs()))
        return _floats(top), _floats(bottom)


def largest_certified(discrete: DiscretePlant, inverse: float, certified: Callable[[Fraction], bool]) -> float:
    """The first double ``k`` below a guess, in growing steps, with ``certified(k - lower)``; NaN if there is none.

    Parameters
    ----------
    discrete : DiscretePlant
        The block, with its ``lower`` and its ``gain``.
    inverse : float
        ``1/(k - lower)`` in units of ``gain``, to try first; not trusted.
    certified : callable
        Exact test of a width ``k - lower``.
    """
    if not math.isfinite(inverse):
        return math.nan
    guess = 1 / (Fraction(max(inverse, LEAST_INVERSE)) * discrete.gain)
    for step in STEPS_BACK:
        k = nearest_double(discrete.lower + guess * (1 - Fraction(step)))
        if math.isfinite(k) and Fraction(k) > discrete.lower and certified(Fraction(k) - discrete.lower):
            return k
    return math.nan


def _floats(values: list[fmpq]) -> NDArray[np.float64]:
    scale = max((abs(value) for value in values), default=fmpq(1))
    return np.array([float(to_fraction(value / scale)) for value in values])

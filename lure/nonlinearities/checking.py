"""Declared properties put to the test: a sample can falsify them, and never prove them."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING

from lure.arrays import NDArray, np
from lure.classes import Sector, SlopeBounds
from lure.errors import AssumptionError, InputError
from lure.exact import Exact, exact_number
from lure.nonlinearities.formula import ExpressionNonlinearity
from lure.nonlinearities.protocol import Nonlinearity

if TYPE_CHECKING:
    from flint import arb

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
    lure.errors.AssumptionError: the law '2*tanh(sigma)' is declared to have the sector [0, 1], but phi(sigma)/sigma ...
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
            raise AssumptionError(f"the law {self.name} has phi(0) = {at_zero:g}; a law must vanish at 0")
        if np.isnan(phi).any():
            raise AssumptionError(f"the law {self.name} has no value at sigma = {x[np.isnan(phi)][0]:.17g}")
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
                f"the law {self.name} is declared to have {kind} {bounds}, but {what} sigma = {self.x[i]:.17g} is "
                f"{values[i]:.12g}; declare bounds that hold"
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
                f"the law {self.name} is declared odd, but phi({self.x[i]:.17g}) = {self.phi[i]:.12g} and "
                f"phi({-self.x[i]:.17g}) = {mirrored[i]:.12g}; declare odd = False"
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

"""The uniform quantiser: a law with jumps, known by its sector alone."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from lure.arrays import ArrayLike, NDArray, np
from lure.classes import Sector
from lure.errors import InputError
from lure.nonlinearities.base import Parameter, assign, number_text, positive

QuantiserKind = Literal["mid-tread"]


@dataclass(frozen=True, slots=True)
class Quantiser:
    r"""Rounding to the nearest multiple of ``step``, halves away from 0; the sector is ``[0, 2]``, whatever the step.

    ``phi`` jumps, so that it has no slope bounds, and in continuous time a loop with it is a differential inclusion:
    theorems for locally Lipschitz laws do not apply.  In discrete time sector criteria do.

    Parameters
    ----------
    step : int, float, Fraction, Decimal or str
        Positive [unit of sigma].
    kind : {"mid-tread"}
        A quantiser with 0 among its levels.  The mid-riser, which jumps at 0, lies in no sector with a finite bound.

    Raises
    ------
    InputError
        ``step`` is not a positive finite number, or the kind is another.

    Examples
    --------
    >>> law = Quantiser(step=1)
    >>> print(law([0.49, 0.5, -2.5]), law.sector, law.slope_bounds)
    [ 0.  1. -3.] [0, 2] None
    """

    step: Fraction
    kind: QuantiserKind

    def __init__(self, *, step: Parameter = 1, kind: QuantiserKind = "mid-tread") -> None:
        if kind != "mid-tread":
            raise InputError(
                f"Quantiser.kind is {kind!r:.60}; only 'mid-tread' is offered: a mid-riser jumps at sigma = 0 and lies "
                "in no sector with a finite bound"
            )
        assign(self, step=positive(step, "Quantiser.step"), kind=kind)

    @property
    def sector(self) -> Sector:
        """``[0, 2]``: 0 up to half a step, 2 at half a step."""
        return Sector(0, 2)

    @property
    def slope_bounds(self) -> None:
        """None: a jump has no finite slope."""
        return

    @property
    def odd(self) -> bool:
        """True: halves are rounded away from 0."""
        return True

    @property
    def regularity(self) -> str:
        """Continuity in words."""
        return "piecewise constant, discontinuous"

    @property
    def locally_lipschitz(self) -> bool:
        """False."""
        return False

    def exact(self, sigma: Fraction) -> Fraction:
        """Value at an exact point, exactly."""
        level = int(abs(sigma) / self.step + Fraction(1, 2)) * self.step
        return level if sigma >= 0 else -level

    def __call__(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Values ``phi(sigma)``, elementwise."""
        return np.asarray(float(self.step) * self._level(sigma))

    def slope(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """Zero: the derivative wherever there is one; it says nothing about the jumps."""
        x = np.asarray(sigma, dtype=float)
        return np.where(np.isnan(x), x, 0.0)

    def primitive(self, sigma: ArrayLike, /) -> NDArray[np.float64]:
        """``int_0^sigma phi``, elementwise: a continuous polygon."""
        step = float(self.step)
        with np.errstate(over="ignore", invalid="ignore"):
            n = np.abs(self._level(sigma))
            return np.asarray(step * n * (np.abs(np.asarray(sigma, dtype=float)) - 0.5 * step * n))

    def _level(self, sigma: ArrayLike) -> NDArray[np.float64]:
        with np.errstate(over="ignore", invalid="ignore"):
            steps = np.asarray(sigma, dtype=float) / float(self.step)
            size = np.abs(steps)
            whole = np.floor(size)
            level = np.copysign(whole + (size - whole >= 0.5), steps)
            return np.asarray(level + 0.0)  # no negative zeros

    def __str__(self) -> str:
        return f"mid-tread quantiser of step {number_text(self.step)}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data: parameters, and what is known with its provenance."""
        from lure.nonlinearities.properties import law_dict

        return law_dict(self)

    def _repr_html_(self) -> str:
        from lure.nonlinearities.properties import law_html

        return law_html(self)

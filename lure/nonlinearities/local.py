"""What is known of a nonlinearity on an interval around 0 alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from lure.errors import InputError
from lure.nonlinearities.base import exact_parameter


@dataclass(frozen=True, slots=True)
class LocalSector:
    """Every locally Lipschitz ``phi(t, sigma)`` with ``lower <= phi/sigma <= upper`` for ``0 < |sigma| <= radius``.

    Nothing is said of it beyond, so that it is a class for :func:`lure.analysis.region` alone.  In files it is a
    ``[class]`` with ``sector`` and ``on = [-a, b]``, of which the smaller end is the radius.

    Attributes
    ----------
    lower, upper, radius : int, float, Fraction or str
        Exact numbers; a float means the double it is.

    Raises
    ------
    InputError
        A number is none, the bounds are not in order, or the radius is not positive.
    """

    lower: Any
    upper: Any
    radius: Any

    def __post_init__(self) -> None:
        for name in ("lower", "upper", "radius"):
            object.__setattr__(self, name, exact_parameter(getattr(self, name), f"LocalSector.{name}"))
        if not self.lower < self.upper or self.radius <= 0:
            raise InputError(
                f"LocalSector is [{self.lower}, {self.upper}] for |sigma| <= {self.radius}; give two bounds in order, "
                "and a positive radius"
            )

    def __str__(self) -> str:
        return f"phi in the sector [{self.lower}, {self.upper}] for |sigma| <= {self.radius}"

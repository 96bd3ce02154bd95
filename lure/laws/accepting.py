"""Laws from other packages: what python-control calls a nonlinearity."""

from __future__ import annotations

import sys
from typing import cast

from lure.errors import InputError
from lure.laws.piecewise import Saturation
from lure.nonlinearity import Nonlinearity

_WANTED = (
    "a law says in which sector it lies: give one of lure.laws, or ExpressionLaw('sigma/(1 + abs(sigma))', "
    "sector=Sector(0, 1))"
)


def as_law(source: object) -> Nonlinearity:
    """The law that ``source`` describes.

    Parameters
    ----------
    source : object
        A law, returned as it is, or ``control.saturation_nonlinearity(ub, lb)``, whose graph is known exactly.

    Raises
    ------
    InputError
        It is a nonlinearity with a memory (relay with hysteresis, backlash), to which no sector condition applies, or
        nothing says in which sector it lies.

    Examples
    --------
    >>> import control
    >>> print(as_law(control.saturation_nonlinearity(2)))
    saturation min(max(sigma, -2), 2)
    """
    if hasattr(source, "sector") and callable(source):
        return cast("Nonlinearity", source)
    control = sys.modules.get("control")  # an object of a package that is not loaded cannot exist
    if control is not None and isinstance(source, control.DescribingFunctionNonlinearity):
        if type(source) is control.saturation_nonlinearity:  # of a class derived from it the graph is unknown
            return Saturation(limit=source.ub, lower_limit=source.lb)
        if not source._isstatic():
            raise InputError(
                f"{type(source).__name__} has a memory: its force depends on the past, and a sector bounds laws "
                "mu = -phi(sigma) without one; describe the loop by its describing function in python-control"
            )
    raise InputError(f"{source!r:.60} has no sector; {_WANTED}")

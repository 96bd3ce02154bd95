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
    if is_control_nonlinearity(source):
        law = control_saturation(source)
        if law is not None:
            return law
        if not source._isstatic():  # type: ignore[attr-defined]  # what that class offers
            raise InputError(
                f"{type(source).__name__} has a memory: its output depends on the past of sigma, and a sector bounds "
                "memoryless nonlinearities mu = -phi(sigma); analysis.describing_function(it, amplitude) is a hint"
            )
    raise InputError(f"{source!r:.60} has no sector; {_WANTED}")


def is_control_nonlinearity(source: object) -> bool:
    """Whether something is what python-control calls a ``DescribingFunctionNonlinearity``.

    Parameters
    ----------
    source : object
        Anything.
    """
    control = sys.modules.get("control")  # an object of a package that is not loaded cannot exist
    return control is not None and isinstance(source, control.DescribingFunctionNonlinearity)


def control_saturation(source: object) -> Saturation | None:
    """``control.saturation_nonlinearity`` as a saturation of the library, None for everything else.

    Parameters
    ----------
    source : object
        Anything; of a class derived from that one the graph is unknown.
    """
    control = sys.modules.get("control")
    if control is None or type(source) is not control.saturation_nonlinearity:
        return None
    return Saturation(limit=source.ub, lower_limit=source.lb)  # type: ignore[attr-defined]  # what that class offers

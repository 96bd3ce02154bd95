"""The exact block behind whatever a user has, for what can only be done exactly."""

from __future__ import annotations

from lure.errors import InputError
from lure.inputs import as_block
from lure.rational import RationalBlock


def exact_block(source: object, what: str) -> RationalBlock:
    """The rational block that ``source`` describes.

    Parameters
    ----------
    source : object
        Whatever :func:`lure.as_block` takes.
    what : str
        What needs it, for the error.

    Raises
    ------
    InputError
        It has a dead time, is measured, or is too large for exact coefficients.

    Examples
    --------
    >>> import control
    >>> print(exact_block(control.tf([1], [1, 1]), "this"))
    1 / (s + 1)
    """
    found = as_block(source)
    if not isinstance(found, RationalBlock):
        raise InputError(
            f"{what} needs exact coefficients, and a {type(found).__name__} has none; give coefficients, matrices of "
            "up to 60 states, or a formula without dead time"
        )
    return found

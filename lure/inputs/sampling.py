"""Sampling times: what a source and its user say of time, brought to one answer."""

from __future__ import annotations

from fractions import Fraction
from typing import Final, Literal

from lure.errors import InputError
from lure.exact import exact_number

ANY_PERIOD: Final = "any"
Stated = Fraction | str | None  # 0 continuous, positive discrete, ANY_PERIOD discrete, None: nothing is said


def stated(dt: object, name: str = "dt") -> Stated:
    """What ``dt`` says in python-control's convention.

    Parameters
    ----------
    dt : object
        None: nothing; 0: continuous time; True: discrete time of unspecified period; a positive number: that period.
    name : str
        Where it stands, for errors.

    Raises
    ------
    InputError
        It is False, negative, not finite or not a number.
    """
    if hasattr(dt, "item") and getattr(dt, "ndim", None) == 0:
        dt = dt.item()
    if dt is None or dt is True:
        return None if dt is None else ANY_PERIOD
    if dt is False:
        raise InputError(f"{name} is False; give 0 or None for continuous time, True or a period for discrete time")
    value = exact_number(dt, name)
    if value < 0:
        raise InputError(f"{name} is {float(value):g}; give a positive period, or 0 for continuous time")
    return value


def sampling_time(given: object, own: object = None, *, name: str = "dt") -> Fraction | Literal[True] | None:
    """The sampling time that a caller's ``dt`` and the source's own one agree on.

    Parameters
    ----------
    given : object
        The caller's word, in python-control's convention: None, 0, True or a positive number.
    own : object
        The source's own ``dt``, in the same convention.
    name : str
        What the source is, for errors.

    Returns
    -------
    Fraction, True or None
        None for continuous time, also if neither says anything; True for discrete time of unspecified period.

    Raises
    ------
    InputError
        One of them is not a sampling time, or they contradict each other.

    Examples
    --------
    >>> sampling_time(None, 0), sampling_time(True), sampling_time(0.5, True)
    (None, True, Fraction(1, 2))
    """
    caller, source = stated(given), stated(own, f"{name}.dt")
    if caller is None or caller == source:
        return _period(source)
    if source is None or (source == ANY_PERIOD and caller):
        return _period(caller)
    if caller == ANY_PERIOD and source:
        return _period(source)
    if isinstance(caller, Fraction) and isinstance(source, Fraction) and caller and float(caller) == float(source):
        return caller  # the decimal that the source holds as a double
    raise InputError(f"dt is {_words(caller)} but {name} is in {_words(source)}; leave dt out or convert the system")


def _period(value: Stated) -> Fraction | Literal[True] | None:
    if value == ANY_PERIOD:
        return True
    return value if isinstance(value, Fraction) and value else None


def _words(value: Stated) -> str:
    if value == ANY_PERIOD:
        return "discrete time"
    return f"discrete time of period {float(value):g}" if isinstance(value, Fraction) and value else "continuous time"

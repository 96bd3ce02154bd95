"""The exceptions worth catching: one for wrong data, one for a theorem whose hypothesis fails; each names its code."""

import difflib
import math
from collections.abc import Iterable
from enum import StrEnum
from numbers import Integral


class Reason(StrEnum):
    """Why a question stays open: the code of an exception, explained in :mod:`lure.analysis.certificates.codes`."""

    NO_MULTIPLIER = "LURE-I001"
    NOT_APPLICABLE = "LURE-I002"
    REJECTED = "LURE-I003"
    SOLVER_FAILED = "LURE-I004"
    NO_NUMBERS = "LURE-I005"
    PRECISION = "LURE-I006"
    OUT_OF_TIME = "LURE-I007"
    OUT_OF_MEMORY = "LURE-I008"
    SAMPLED = "LURE-I009"
    COMPUTED = "LURE-I010"
    NO_LOWER_END = "LURE-I011"
    CRITICAL = "LURE-I012"
    DOUBLE_ZERO = "LURE-I013"
    RESIDUE = "LURE-I014"
    ILL_POSED = "LURE-I015"
    NOT_LIPSCHITZ = "LURE-I016"
    OUTSIDE_CLASS = "LURE-I017"
    UNSTABLE = "LURE-I018"
    HIDDEN_MODE = "LURE-I019"
    EVERY_FINITE = "LURE-I020"
    SEVERAL_SOLUTIONS = "LURE-I021"
    DEAD_TIME = "LURE-I022"
    UNPROVED_ORBIT = "LURE-I023"
    UNDAMPED = "LURE-I024"
    RANGE = "LURE-I025"
    DISAGREEMENT = "LURE-I026"
    UNEXPECTED = "LURE-I027"
    NO_PACKAGE = "LURE-I028"


class _CodedError(ValueError):
    def __init__(self, message: str, *, code: Reason = Reason.NOT_APPLICABLE) -> None:
        super().__init__(message)
        self.code = code


class InputError(_CodedError):
    """Wrong data: the message names the field, the value found and the fix.

    Parameters
    ----------
    message : str
        One sentence.
    code : Reason
        Why the question stays open where a search ends so.
    """


class AssumptionError(_CodedError):
    """A theorem was asked for where one of its hypotheses does not hold; the message carries the number.

    Parameters
    ----------
    message : str
        One sentence.
    code : Reason
        Why the question stays open where a search ends so.
    """


# Sentences and checks that many refusals share.


def closest(word: str, known: Iterable[str], *, cutoff: float = 0.5) -> str | None:
    """The known name that resembles a word, in capitals or not, None where none does.

    Parameters
    ----------
    word : str
        What was given.
    known : iterable of str
        The names.
    cutoff : float
        How much of a name must be the same, from 0 to 1.
    """
    names = {name.lower(): name for name in known}
    near = difflib.get_close_matches(word[:40].lower(), names, n=1, cutoff=cutoff)
    return names[near[0]] if near else None


def did_you_mean(word: str, known: Iterable[str], *, cutoff: float = 0.5) -> str:
    """The clause ``did you mean ...?`` with the name that resembles a word, empty where none does; see `closest`."""
    near = closest(word, known, cutoff=cutoff)
    return f"did you mean {near!r}? " if near else ""


def demand_whole(name: str, value: object, least: int, most: int | None = None) -> None:
    """Refuse what is no whole number of a range.

    Parameters
    ----------
    name : str
        What it is, the subject of the sentence.
    value : object
        What was given; a truth value is no number.
    least : int
        The smallest that is allowed.
    most : int or None
        The largest, if there is one.

    Raises
    ------
    InputError
        It is none.
    """
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= value <= (math.inf if most is None else most):  # type: ignore[operator]  # a number
        fix = f"of at least {least}" if most is None else f"from {least} to {most}"
        raise InputError(f"{name} is {value!r:.60}; give a whole number {fix}")


def demand_seconds(name: str, value: object) -> None:
    """Refuse what is no length of time: positive and finite.

    ``name``: what it is, the subject of the sentence; ``value``: what was given.

    Raises
    ------
    InputError
        It is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise InputError(f"{name} is {value!r:.60}; give a positive number of seconds")

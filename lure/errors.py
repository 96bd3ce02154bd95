"""The exceptions worth catching: one for wrong data, one for a theorem whose hypothesis fails; each names its code."""

from enum import StrEnum


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

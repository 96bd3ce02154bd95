"""What a certificate file says: exact numbers, counts, flags and nothing else; everything unexpected is refused."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpz

OUT_OF_TIME = "the time allowed for checking is over"
LARGEST_FILE = 200_000_000
LONGEST_NUMBER = 200_000
LARGEST_COUNT = 10**9
NUMBER = re.compile(r"-?[0-9]+(/[0-9]+)?")
FORMAT = "lure-certificate/1"
CONVENTION = "sigma = H mu, mu = -phi(sigma)"
ORIGINS = ("rationals", "decimals as written", "doubles, exactly")
FIELDS = [
    *("format", "verdict", "convention", "numbers", "system", "laws", "law"),
    *("theorem", "multiplier", "conclusion", "hypotheses", "proof"),
]


class NotShown(ValueError):
    """The certificate does not show what it claims, or is no certificate."""


LONGEST = 600.0  # [s] for a certificate, as for the first checker
_END: ContextVar[float] = ContextVar("_END", default=math.inf)


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """The time allowed; :func:`tick` ends the check when it is over."""
    token = _END.set(time.monotonic() + seconds)
    try:
        yield
    finally:
        _END.reset(token)


def tick() -> None:
    """Called in every long loop."""
    require(time.monotonic() < _END.get(), OUT_OF_TIME)


def require(condition: object, reason: str) -> None:
    """Go on only if the condition is exactly True: an undecided comparison is not.

    Raises
    ------
    NotShown
        It is not.
    """
    if condition is not True:
        raise NotShown(reason)


@dataclass(frozen=True, kw_only=True, slots=True)
class Document:
    """The parts of a certificate; mappings are still as in the file."""

    verdict: str
    system: Mapping[str, object]
    nonlinearities: Mapping[str, object]
    nonlinearity: Mapping[str, object] | None
    theorem: str
    multiplier: Mapping[str, object]
    conclusion: str
    hypotheses: Mapping[str, object]
    proof: Mapping[str, object]
    rate: Fraction | None = None


def read(certificate: Mapping[str, object] | str | bytes) -> Document:
    """The parts of a certificate file, or of what was read from one.

    Raises
    ------
    NotShown
        It is not of the format: a key is missing, unknown or given twice, or a value is of the wrong kind.
    """
    if isinstance(certificate, str | bytes):
        require(len(certificate) <= LARGEST_FILE, "the file is too large")
        try:
            certificate = json.loads(
                certificate, object_pairs_hook=_once, parse_float=_no_float, parse_constant=_no_float
            )
        except NotShown:
            raise
        except (ValueError, RecursionError) as error:  # also of whole numbers of more than 4300 digits
            raise NotShown(f"it is no JSON, or none that is read: {error}"[:200]) from None
    paced = ["rate"] if "rate" in mapping(certificate) else []
    found = record(certificate, *FIELDS, *paced)
    require(found["format"] == FORMAT, f"the format is not {FORMAT}")
    require(found["convention"] == CONVENTION, f"the sign convention is not {CONVENTION}")
    require(found["numbers"] in ORIGINS, "numbers does not say where they came from")
    hypotheses = mapping(found["hypotheses"])
    require(all(isinstance(t, str) for t in hypotheses.values()), "hypotheses are not texts")
    return Document(
        verdict=text(found["verdict"]),
        system=mapping(found["system"]),
        nonlinearities=mapping(found["laws"]),
        nonlinearity=None if found["law"] is None else mapping(found["law"]),
        theorem=text(found["theorem"]),
        multiplier=mapping(found["multiplier"]),
        conclusion=text(found["conclusion"]),
        hypotheses=hypotheses,
        proof=mapping(found["proof"]),
        rate=number(found["rate"]) if paced else None,
    )


def mapping(value: object) -> Mapping[str, object]:
    """A JSON object."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise NotShown("a JSON object is missing")
    return value


def record(value: object, *names: str) -> Mapping[str, object]:
    """A JSON object with exactly these keys."""
    found = mapping(value)
    require(set(found) == set(names), f"keys are {sorted(found)[:20]}; they must be {sorted(names)}")
    return found


def text(value: object) -> str:
    """A JSON string."""
    if not isinstance(value, str):
        raise NotShown("a text is missing")
    return value


def flag(value: object) -> bool:
    """A JSON boolean."""
    if not isinstance(value, bool):
        raise NotShown("true or false is missing")
    return value


def count(value: object, *, least: int = 0) -> int:
    """A JSON integer, not too large."""
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= LARGEST_COUNT:
        raise NotShown(f"a count of at least {least} is missing")
    return value


def listed(value: object) -> Sequence[object]:
    """A JSON list."""
    if not isinstance(value, list | tuple):
        raise NotShown("a list is missing")
    return value


def number(value: object) -> Fraction:
    """The rational number written ``p`` or ``p/q``."""
    tick()
    if not isinstance(value, str) or len(value) > LONGEST_NUMBER or not NUMBER.fullmatch(value):
        raise NotShown("an exact number, text p or p/q, is missing")
    top, _, bottom = value.partition("/")
    denominator = int(fmpz(bottom or "1"))
    require(denominator > 0, "a denominator is zero")
    return Fraction(int(fmpz(top)), denominator)


def whole(value: object) -> fmpz:
    """The integer written as text."""
    exact = number(value)
    require(exact.denominator == 1, "an integer is missing")
    return fmpz(exact.numerator)


def numbers(value: object) -> list[Fraction]:
    """A list of exact numbers."""
    return [number(entry) for entry in listed(value)]


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    require(len(found) == len(pairs), "a key is given twice")
    return found


def _no_float(written: str) -> object:
    raise NotShown(f"the number {written[:20]} is neither a count nor text")

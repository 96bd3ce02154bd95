"""The last step of every search: what it proposes goes through the checker, as the text it will have in a file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import combinations
from typing import Any, Protocol, TypeVar

from flint import fmpq_poly, fmpz_poly

from lure.analysis.certificates.arithmetic import Malformed, Rejected, parsed
from lure.analysis.certificates.blocks import block, paced
from lure.analysis.certificates.checker import (
    CONVENTION,
    FORMAT,
    Proved,
    Refuted,
    check,
    inequality,
    polynomial_proof,
    unbounded,
)
from lure.analysis.certificates.codes import Code, code_for
from lure.analysis.certificates.states import classes
from lure.analysis.deadline import time_left
from lure.analysis.numerics.polynomial import X, even_odd, from_descending, to_fmpq, to_fraction
from lure.analysis.wording import same_in
from lure.classes import OPERATORS
from lure.errors import AssumptionError, InputError
from lure.record import described, quantity

# Searches that may fail in any way, kept from taking the answer with them: an exception becomes a code.

T = TypeVar("T")


@described(frozen=True, kw_only=True, slots=True)
class Failure:
    """A search that showed nothing."""

    search: str = quantity("Which one")
    code: Code = quantity("How it ended")
    detail: str = quantity("The sentence or the exception behind the code")

    def __str__(self) -> str:
        return f"{self.search}: {self.code.title} ({self.code.identifier}): {self.detail}"


def guarded(search: str, work: Callable[[], T], *, passing: tuple[type[Exception], ...] = ()) -> T | Failure:
    """What the work returns, or its failure; the user's interrupt passes.

    ``search``: a name for the work; ``work``: called without arguments; ``passing``: exceptions that are the caller's
    to answer.

    Notes
    -----
    ``KeyboardInterrupt``, ``SystemExit`` and ``GeneratorExit`` are no results of a search, and pass.
    """
    try:
        return work()
    except BaseException as error:  # a panic of a compiled solver is no Exception
        if isinstance(error, (KeyboardInterrupt, SystemExit, GeneratorExit, *passing)):
            raise
        sentence = " ".join(str(error).split())
        spoken = (AssumptionError, InputError, Rejected, Malformed, ModuleNotFoundError, TimeoutError)
        named = isinstance(error, spoken)
        detail = sentence if named and sentence else f"{type(error).__name__}: {sentence}".rstrip(": ")
        return Failure(search=search, code=code_for(error), detail=detail[:400])


# Certificates in the making: the parts of a certificate that the checker arrives at by itself, filled in.

LONGEST = 600.0  # [s] for one check


def complete_and_check(draft: Mapping[str, Any]) -> Proved | Refuted:
    """What the checker makes of a draft: its ``certificate`` is complete, with polynomial, conclusion and hypotheses.

    Parameters
    ----------
    draft : Mapping
        ``verdict``, ``system``, ``laws``, ``theorem`` and ``proof``, in the format of
        ``notebooks/notes/0008-certificates.md``; ``multiplier``, ``law`` and ``numbers`` where they are not empty.

    Raises
    ------
    ValueError
        ``Rejected`` or ``Malformed``: the draft proves nothing.
    """
    certificate: dict[str, Any] = {
        "format": FORMAT,
        "convention": CONVENTION,
        "numbers": "rationals",
        "law": None,
        "multiplier": {},
        **draft,
        "conclusion": "",
        "hypotheses": {},
    }
    if certificate["proof"].get("method") == "polynomial" and certificate["theorem"] != "hurwitz":
        quick = _popov_polynomial(certificate)
        if quick is not None:
            return check({**certificate, "proof": quick}, draft=True, seconds=_seconds())
        nonlinearities, name, data = classes(certificate["laws"]), certificate["theorem"], certificate["multiplier"]
        system, rate = certificate["system"], None
        if "rate" in certificate:
            rate = Fraction(certificate["rate"])
            system = paced(system, rate)
        F, _, critical, _ = inequality(name, data, block(system), nonlinearities, rate)
        certificate["proof"] = polynomial_proof(F, critical=critical, bounded=not unbounded(name, data, nonlinearities))
    return check(certificate, draft=True, seconds=_seconds())


def _seconds() -> float:
    return max(min(time_left(), LONGEST), 0.0)


def _popov_polynomial(certificate: Mapping[str, Any]) -> dict[str, Any] | None:
    """``w (Re n d* - theta omega Im n d*) + |d|^2`` over ``omega^2``, ``d`` shifted: the checker's own is the same.

    None for another theorem than circle and Popov in continuous time, or for other classes than ``[l, k]``.
    """
    name, data, system = certificate["theorem"], certificate["multiplier"], certificate["system"]
    own = {"circle": set[str](), "popov": {"theta"}}
    if name not in own or set(data) != own[name] or "rate" in certificate or system.get("kind") != "transfer":
        return None
    ends = certificate["laws"]["sector"]
    if system["time"] != "continuous" or {"-inf", "inf"} & set(ends):
        return None
    low, theta = Fraction(ends[0]), to_fmpq(Fraction(data.get("theta", "0")))
    n, d = (from_descending([Fraction(c) for c in system[side]]) for side in ("numerator", "denominator"))
    (ne, no), (de, do) = even_odd(n), even_odd(d + to_fmpq(low) * n)
    F = ne * de + X * no * do + theta * X * (ne * do - no * de)
    if ends[1] != "finite":
        F = to_fmpq(Fraction(ends[1]) - low) * F + de * de + X * do * do
    return None if F.degree() < 0 or F[0] == 0 else _over_the_square(F)


def _over_the_square(F: fmpq_poly) -> dict[str, Any]:
    whole = F.numer()
    coefficients = [str(int(c)) for c in (whole // fmpz_poly([whole.content()])).coeffs()]
    limits = [str(to_fraction(F[0])), str(to_fraction(F[F.degree()]))]
    return {"method": "polynomial", "variable": "omega^2", "coefficients": coefficients, "limits": limits}


def completed(draft: Mapping[str, Any]) -> dict[str, Any]:
    """The certificate of a draft; see :func:`complete_and_check`.

    Raises
    ------
    ValueError
        ``Rejected`` or ``Malformed``: the draft proves nothing.
    """
    return dict(complete_and_check(draft).certificate)


Draft = Mapping[str, Any]


class Asked(Protocol):
    """A question about one class, as far as a certificate has to fit it."""

    @property
    def class_entry(self) -> Mapping[str, Any]:
        """The class as it stands in a certificate."""

    @property
    def nonlinearity_entry(self) -> Mapping[str, Any] | None:
        """The nonlinearity as it stands in a certificate; None if there is none."""


def check_for_class(question: Asked, draft: Draft) -> Proved | Refuted:
    """What the checker makes of a draft, stated for exactly the class asked about; else for a larger one.

    ``draft``: a certificate without what the checker fills in, of a proof or a refutation.

    Raises
    ------
    Rejected
        The checker accepts neither.
    """
    nonlinearity = (
        None
        if question.nonlinearity_entry is None or draft["verdict"] == "REFUTED"
        else dict(question.nonlinearity_entry)
    )
    asked = {**draft, "laws": dict(question.class_entry), "law": nonlinearity}
    try:
        return checked(asked)
    except Rejected:
        if draft["verdict"] == "REFUTED" or not contains(draft["laws"], question.class_entry):
            raise
        return checked({**draft, "law": nonlinearity})


def checked(draft: Draft) -> Proved | Refuted:
    """What the checker makes of the certificate of a draft, which read again from its text is the same.

    ``draft``: a certificate without what the checker fills in.

    Raises
    ------
    Rejected
        It proves nothing, or its text says something else.
    """
    found = complete_and_check(draft)
    if parsed(json.dumps(dict(found.certificate))) != found.certificate:
        raise Rejected("the text of the certificate says something else")
    return found


def contains(larger: Mapping[str, Any], smaller: Mapping[str, Any]) -> bool:
    """Whether every nonlinearity of one class is in another, both as they stand in a certificate.

    ``larger``, ``smaller``: ``laws`` of a certificate.
    """
    if "channels" in larger or "channels" in smaller:
        return _each_contains(larger, smaller)
    if "relu" in larger and ("relu" not in smaller or smaller["slope"] != larger["slope"]):
        return False  # it has one member
    if "operator" in larger or "operator" in smaller:
        kinds = larger.get("operator"), smaller.get("operator")
        slow = "rate" not in larger or kinds[1] == "delay" or "rate" in smaller
        slow = slow and Fraction(smaller.get("rate", "0")) <= Fraction(larger.get("rate", "1"))
        slow = slow and (larger["time_varying"] or not smaller["time_varying"])
        return (slow and _inside(smaller["sector"], larger["sector"])) and (
            kinds[0] == kinds[1]
            or kinds in (("varying delay", "delay"), *combinations(OPERATORS, 2))  # each is among those before it
        )
    if "memory" in larger or "memory" in smaller:
        return larger.get("memory") == smaller.get("memory") and _inside(smaller["slope"], larger["slope"])
    line = smaller["linear"]  # phi = g sigma is odd, does not jump, and has the slope that its sector bounds
    slope = smaller["sector"] if line and smaller["slope"] is None else smaller["slope"]
    return (
        _inside(smaller["sector"], larger["sector"])
        and (larger["slope"] is None or (slope is not None and _inside(slope, larger["slope"])))
        and (smaller["odd"] or line or not larger["odd"])
        and (larger["time_varying"] or not smaller["time_varying"])
        and (line or not larger["linear"])
        and ("rate" not in larger or Fraction(smaller.get("rate", "0")) <= Fraction(larger["rate"]))
        and (line or larger.get("regularity") == "any" or smaller.get("regularity") is None)
    )


def _each_contains(larger: Mapping[str, Any], smaller: Mapping[str, Any]) -> bool:
    """The same of several channels; what one says of the same nonlinearity in several channels, the other says too."""
    if not ("channels" in larger and "channels" in smaller and len(larger["channels"]) == len(smaller["channels"])):
        return False
    whole, same = ({(b[0], i) for b in same_in(one) for i in b} for one in (larger, smaller))
    firsts = {i: first for first, i in same}
    alike = all(firsts[first] == firsts[i] for first, i in whole)
    if any("operator" in one for each in (larger, smaller) for one in each["channels"]):
        alike = alike and same_in(larger) == same_in(smaller)  # one operator in two channels is not one in each
    return alike and all(map(contains, larger["channels"], smaller["channels"]))


def _inside(inner: list[str], outer: list[str]) -> bool:
    below = outer[0] == "-inf" or (inner[0] != "-inf" and Fraction(outer[0]) <= Fraction(inner[0]))
    if outer[1] in ("inf", "finite") or inner[1] in ("inf", "finite"):
        return below and (outer[1] == "inf" or (outer[1] == "finite" and inner[1] != "inf"))
    return below and Fraction(inner[1]) <= Fraction(outer[1])

"""One question, one certificate: the proof or the refutation of exactly the class asked about, or a code."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from lure.analysis.certificates import codes
from lure.analysis.certificates.checker import ORIGINS, Proved, Refuted
from lure.analysis.certificates.codes import Code
from lure.analysis.certificates.proposals import Numbers
from lure.analysis.certificates.sealing import Failure, guarded
from lure.analysis.deadline import time_limit
from lure.analysis.questions.conclusion import conclusion_of
from lure.analysis.questions.problem import Problem, class_given, loop_given, posed
from lure.analysis.questions.proof_search import searches
from lure.analysis.verdict import Verdict
from lure.errors import InputError

Method = Literal["best", "polynomial", "matrix", "cover", "structure"]
METHODS: tuple[str, ...] = get_args(Method)
_ORDER = (
    *("format", "verdict", "convention", "numbers", "system", "laws", "law", "theorem", "multiplier"),
    *("conclusion", "hypotheses", "proof"),
)


@dataclass(frozen=True, kw_only=True, slots=True)
class ProofOptions:
    """How to look for a proof.

    Attributes
    ----------
    criterion : str
        A criterion by name, or ``best``: all that apply, cheapest first.  ``hurwitz`` is about linear gains alone.
    method : {"best", "polynomial", "matrix", "cover", "structure"}
        The kind of proof.
    finite : bool
        Whether an infinite upper end means every law with some finite bound, whichever.
    seconds : float or None
        Time allowed; None for no limit.
    numbers : {"rationals", "decimals as written", "doubles, exactly"}
        Where the numbers came from, for the file.

    Raises
    ------
    InputError
        There is no such method or origin, or no time at all is allowed.
    """

    criterion: str = "best"
    method: Method = "best"
    finite: bool = False
    seconds: float | None = None
    numbers: Numbers = "rationals"

    def __post_init__(self) -> None:
        for name, value, known in (("method", self.method, METHODS), ("numbers", self.numbers, ORIGINS)):
            if value not in known:
                raise InputError(f"Ways.{name} is {value!r:.40}; choose from {', '.join(known)}")
        if self.seconds is not None and not 0 < self.seconds < math.inf:
            raise InputError(f"Ways.seconds is {self.seconds}; give a positive number, or None for no limit")


@dataclass(frozen=True, kw_only=True, slots=True)
class Certification:
    """What came of a question.

    Attributes
    ----------
    verdict : Verdict
        PROVED or REFUTED only with a certificate that the checker accepted.
    shown : Proved, Refuted or None
        What the checker made of it; ``shown.certificate`` is the certificate.
    code : Code or None
        Why it is INCONCLUSIVE; None otherwise.
    detail : str
        One sentence: the claim, or what stood in the way.
    failures : tuple of Failure
        Every search that showed nothing, in the order they were made.
    assumed : tuple of str
        What the verdict assumes and nothing shows, in clauses: what is only declared of the given nonlinearity, and
        with ``H(inf) != 0`` that the equation of the loop has one solution.
    """

    verdict: Verdict
    shown: Proved | Refuted | None = None
    code: Code | None = None
    detail: str
    failures: tuple[Failure, ...] = field(default=())
    assumed: tuple[str, ...] = ()

    @property
    def certificate(self) -> Mapping[str, Any] | None:
        """The certificate, ready to be written as JSON; None if there is none."""
        return None if self.shown is None else self.shown.certificate

    def __bool__(self) -> bool:
        raise TypeError("a certification has three outcomes; compare certification.verdict")

    def __str__(self) -> str:
        return f"{self.verdict}: {self.detail}" if self.code is None else f"{self.verdict} ({self.code}): {self.detail}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data, the certificate with it."""
        from lure.analysis.certificates.representation import failure_dict, shown_dict

        return {
            "verdict": str(self.verdict),
            "code": None if self.code is None else self.code.identifier,
            "detail": self.detail,
            "shown": None if self.shown is None else shown_dict(self.shown),
            "assumed": list(self.assumed),
            "failures": [failure_dict(failure) for failure in self.failures],
            "sentence": str(self),
        }

    def _repr_html_(self) -> str:
        from lure.analysis.certificates.representation import accepted_html
        from lure.record import html_table

        tried = [(one.search, f"{one.code.title} ({one.code.identifier})", one.detail) for one in self.failures]
        head = ("search", "how it ended", "why")
        failed = html_table("Searches that showed nothing", tried, head=head) if tried else ""
        if self.shown is not None:
            return accepted_html(self.shown, self.assumed) + failed
        rows = [("why", self.detail)]
        if self.code is not None:
            rows.insert(0, ("code", f"{self.code.identifier}, {self.code.title}"))
        notes = ["That nothing was shown says nothing about the loop: it may be stable or not."]
        return html_table("No certificate was found", rows, verdict=str(self.verdict), notes=notes) + failed


def certify(
    loop: object,
    nonlinearity: object = None,
    *,
    ways: ProofOptions | None = None,
    progress: Callable[[str], None] | None = None,
) -> Certification:
    r"""A certificate for one loop and one class of laws, ``sigma = H mu``, ``mu = -phi(sigma)``.

    A search proposes, the checker decides.  Whatever happens inside a search, an exception of a solver, NaN, too few
    digits, the end of the time allowed, ends INCONCLUSIVE with a code and never as a proof.

    Parameters
    ----------
    loop : LoopSystem, LoopModel, Loop, or anything :func:`lure.plants.as_plant` takes
        The loop.
    nonlinearity : object
        The class of laws, as a ``NonlinearityClass``, a ``Sector`` or ``SlopeBounds``; by default that of the loop, or
        the smallest that its law is known to belong to.  Or, around a block, a law: an object, a formula as text,
        ``control.saturation_nonlinearity``.
    ways : Ways, optional
        Which criterion, which kind of proof, how long.
    progress : callable, optional
        Told the name of each search as it begins.

    Returns
    -------
    Certification
        PROVED or REFUTED with a certificate about exactly this class, or a larger one that contains it; else
        INCONCLUSIVE with a code.

    Raises
    ------
    InputError
        The loop or the class is no good, no class is given, or there is no such criterion.

    Notes
    -----
    Linear gains are tried first, then the criteria, cheapest first, then the searches for counterexamples.

    Examples
    --------
    >>> from lure import Sector
    >>> print(certify(([1], [1, 3, 2, 0]), Sector(0, 5)).verdict)
    PROVED
    """
    chosen = ways or ProofOptions()
    law_class = class_given(nonlinearity)
    if law_class is None:
        loop = loop_given(loop, nonlinearity)
    problem = posed(loop, law_class, criterion=chosen.criterion, finite=chosen.finite, method=chosen.method)
    told = None if progress is None else lambda step, _done: progress(step)
    return certification(problem, seconds=chosen.seconds, numbers=chosen.numbers, progress=told)


def certification(
    problem: Problem,
    *,
    seconds: float | None = None,
    numbers: Numbers = "rationals",
    progress: Callable[[str, float], None] | None = None,
) -> Certification:
    """What comes of a question about one class.

    Parameters
    ----------
    problem : Problem
        Of the kind ``class``.
    seconds : float or None
        Time allowed.
    numbers : {"rationals", "decimals as written", "doubles, exactly"}
        Where the numbers came from, for the file.
    progress : callable, optional
        Told each search as it begins, with 0: how many follow is not known.
    """
    say = progress or (lambda _step, _done: None)

    def limited() -> Certification:
        """The searches, within the time allowed."""
        with time_limit(seconds) as over:
            return _searched(problem, numbers, over, say)

    found = guarded("the search", limited)
    return found if isinstance(found, Certification) else _inconclusive([found])


def text_of(certificate: Mapping[str, Any]) -> str:
    """A certificate as the text of a file, ASCII, a key a line, in the order of the format.

    Parameters
    ----------
    certificate : Mapping
        A certificate.
    """
    ordered = sorted(certificate.items(), key=lambda item: _ORDER.index(item[0]) if item[0] in _ORDER else len(_ORDER))
    entries = (f"{json.dumps(key)}: {_value(value)}" for key, value in ordered)
    return "{\n" + ",\n".join(entries) + "\n}\n"


def _value(value: object) -> str:
    if isinstance(value, Mapping) and len(value) > 1:
        return "{\n" + ",\n".join(f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in value.items()) + "\n}"
    return json.dumps(value)


def _searched(
    problem: Problem, numbers: Numbers, over: Callable[[], bool], say: Callable[[str, float], None]
) -> Certification:
    failures: list[Failure] = list(problem.refusals)
    pending: Iterator[tuple[str, Callable[[], Proved | Refuted | Failure | None]]] = searches(problem, numbers=numbers)
    for name, search in pending:
        if over():
            failures.append(Failure(search=name, code=codes.OUT_OF_TIME, detail="the time allowed is over"))
            break
        say(name, 0.0)
        found = guarded(name, search)
        if isinstance(found, Proved | Refuted):
            follows = conclusion_of(problem, found)
            if follows.shown is not None:
                return Certification(
                    verdict=follows.verdict,
                    shown=found,
                    detail=found.claim,
                    failures=tuple(failures),
                    assumed=follows.assumed,
                )
            found = Failure(search=name, code=follows.code or codes.REJECTED, detail=follows.reason)
        if isinstance(found, Failure):
            failures.append(found)
            if found.code is codes.OUT_OF_TIME:
                break
    return _inconclusive(failures)


def _inconclusive(failures: list[Failure]) -> Certification:
    if not failures:
        failures = [Failure(search="all", code=codes.NOT_APPLICABLE, detail="no criterion serves such a class")]
    some = any(failure.code is codes.NO_MULTIPLIER for failure in failures)
    told = [f for f in failures if not (some and f.code is codes.NOT_APPLICABLE)]
    worst = min(reversed(told), key=lambda failure: codes.WORST.index(failure.code))
    return Certification(
        verdict=Verdict.INCONCLUSIVE,
        code=worst.code,
        detail=f"{worst.search}: {worst.detail}",
        failures=tuple(failures),
    )

"""What one criterion says about one block: how far it reaches, on what evidence, and what it needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from lure.analysis.numerics.doubles import json_number
from lure.analysis.numerics.evidence import INFINITE as INFINITE
from lure.analysis.numerics.evidence import Bracket as Bracket
from lure.analysis.numerics.evidence import Evidence as Evidence
from lure.analysis.wording import BEYOND, class_words
from lure.classes import NonlinearityClass
from lure.record import html_table, plain

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted

# The vocabulary of every result: what was concluded, and on what kind of evidence.


class Verdict(Enum):
    """A three-valued answer; it has no truth value, so that ``if verdict:`` cannot be written by mistake.

    Examples
    --------
    >>> bool(Verdict.INCONCLUSIVE)
    Traceback (most recent call last):
        ...
    TypeError: a verdict has three values; compare it, as in `verdict is Verdict.INCONCLUSIVE`
    """

    PROVED = "PROVED"
    REFUTED = "REFUTED"
    INCONCLUSIVE = "INCONCLUSIVE"

    def __bool__(self) -> bool:
        raise TypeError(f"a verdict has three values; compare it, as in `verdict is Verdict.{self.name}`")

    def __str__(self) -> str:
        return self.value


# Destabilising members of a class of laws: the other side of every answer.

Kind = Literal["linear gain", "switched gain", "periodic orbit", "simulated orbit"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Witness:
    r"""A law in a class ``[lower, k]`` with which ``sigma = H mu``, ``mu = -phi(sigma)`` does not come to rest at 0.

    Attributes
    ----------
    kind : {"linear gain", "switched gain", "periodic orbit", "simulated orbit"}
        ``simulated orbit`` is never more than observed.
    k : float
        Upper bound of the smallest class ``[lower, k]`` that contains the law, rounded up where it is not exact.
    evidence : Evidence
        CERTIFIED: an exact or interval argument; COMPUTED: floats with an error estimate; OBSERVED: a simulation.
    slope_restricted : bool
        Whether the law has slope in ``[lower, k]``; else it only lies in the sector.
    odd, time_varying : bool
        Properties of the law.
    description : str
        One sentence: the law and what the loop does with it.
    data : Mapping
        What is needed to check it again: points of the law, orbit, gains and times; exact numbers as ``p/q``.
    refutation : Refuted or None
        What the checker accepted of it, with its certificate; None where it was not asked.
    """

    kind: Kind
    k: float
    evidence: Evidence
    slope_restricted: bool
    odd: bool
    time_varying: bool = False
    description: str
    data: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    refutation: Refuted | None = None

    def __str__(self) -> str:
        return f"{self.description} ({self.evidence})"


Needs = Literal["slope", "odd", "time-invariant"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Answer:
    r"""The reach of a criterion for ``mu = -phi(sigma)``, ``sigma = H mu``.

    Attributes
    ----------
    criterion : str
        One of the names in :data:`lure.analysis.theorems.table.CRITERIA`.
    theorem : str
        The theorem by name, with its source.
    largest : Bracket
        The largest ``k`` of the classes ``[lower, k]``, ``lower`` that of ``law_class``.  ``low``: every class
        ``[lower, k]`` with finite ``k <= low`` is proved if ``verdict`` is PROVED.  ``high``: the criterion (for
        ``zames-falb`` in continuous time: any criterion) can say nothing at or above it.
    law_class : NonlinearityClass
        The class of laws the answer is about, at ``k = largest.low`` or at the ``k`` asked about.
    verdict : Verdict
        PROVED: the classes up to ``largest.low`` (or the class asked about) are absolutely stable.  REFUTED: with a
        destabilising member in ``witness``.  INCONCLUSIVE: see ``reason``.
    evidence : Evidence
        What ``largest.low`` and the verdict rest on.
    needs : tuple of {"slope", "odd", "time-invariant"}
        Properties of ``phi`` beyond its sector that the theorem needs.
    theta : float or None
        Popov multiplier [s] used at ``largest.low``.
    multiplier : str or None
        The multiplier as a formula.
    parameters : Mapping
        Numbers behind ``multiplier``, exact ones as text ``p/q``, enough to check the inequality again.
    margin : Bracket or None
        Infimum over frequency of the left-hand side of the inequality for the class asked about.
    worst_frequency : float or None
        Where the inequality is tight [rad/s, in discrete time rad per sample]; ``inf`` if only in the limit.
    hypotheses : tuple of str
        Each hypothesis of the theorem, with how it was checked or that it is assumed.
    reason : str
        One sentence: what was shown, or why nothing was and what to try.
    witness : str or None
        The destabilising member behind REFUTED.
    proof : Proved or None
        What the checker accepted of a PROVED answer, with its certificate; None where it was not asked.
    search_limited : bool
        Whether ``largest.low`` is no end of the criterion, but the largest ``k`` for which a certificate was tried.
    """

    criterion: str
    theorem: str
    largest: Bracket
    law_class: NonlinearityClass
    verdict: Verdict
    evidence: Evidence
    needs: tuple[Needs, ...] = ()
    theta: float | None = None
    multiplier: str | None = None
    parameters: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    margin: Bracket | None = None
    worst_frequency: float | None = None
    hypotheses: tuple[str, ...] = ()
    reason: str = ""
    witness: str | None = None
    proof: Proved | None = None
    search_limited: bool = False

    def __bool__(self) -> bool:
        raise TypeError("a criterion has three answers; compare answer.verdict")

    def __str__(self) -> str:
        return f"{self.criterion}: {self.verdict} ({self.evidence}), largest k {self.largest}. {self.reason}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``."""
        return {
            "criterion": self.criterion,
            "theorem": self.theorem,
            "largest": [json_number(self.largest.low), json_number(self.largest.high)],
            "class": str(self.law_class) if self.proof is None else class_words(self.proof.certificate["laws"]),
            "verdict": str(self.verdict),
            "evidence": str(self.evidence),
            "needs": list(self.needs),
            "theta": json_number(self.theta),
            "multiplier": self.multiplier,
            "parameters": plain(self.parameters),
            "margin": None if self.margin is None else [json_number(self.margin.low), json_number(self.margin.high)],
            "worst_frequency": json_number(self.worst_frequency),
            "hypotheses": list(self.hypotheses),
            "reason": self.reason,
        }

    def _repr_html_(self) -> str:
        rows: list[tuple[str, object]] = [
            ("class", self.law_class),
            ("evidence", self.evidence),
            ("largest k", self.largest),
            ("multiplier", self.multiplier or "-"),
            ("margin", "-" if self.margin is None else self.margin),
            ("theorem", self.theorem),
            ("reason", self.reason),
            *(("hypothesis", text) for text in self.hypotheses),
        ]
        return html_table(f"{self.criterion} criterion", rows, verdict=str(self.verdict), notes=[BEYOND])

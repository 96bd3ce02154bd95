"""What one criterion says about one block: how far it reaches, on what evidence, and what it needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

from analysis.evidence import Bracket, Evidence, Verdict
from lure.law_class import LawClass

if TYPE_CHECKING:
    from analysis.certificates.checker import Proved

Needs = Literal["slope", "odd", "time-invariant"]


@dataclass(frozen=True, kw_only=True, slots=True)
class Answer:
    r"""The reach of a criterion for ``mu = -phi(sigma)``, ``sigma = H mu``.

    Attributes
    ----------
    criterion : str
        ``circle``, ``popov``, ``off-axis-circle``, ``park``, ``zames-falb``, ``tsypkin``, ``jury-lee``, ``hurwitz``.
    theorem : str
        The theorem by name, with its source.
    largest : Bracket
        The largest ``k`` of the classes ``[lower, k]``, ``lower`` that of ``law_class``.  ``low``: every class
        ``[lower, k]`` with finite ``k <= low`` is proved if ``verdict`` is PROVED.  ``high``: the criterion (for
        ``zames-falb`` in continuous time: any criterion) can say nothing at or above it.
    law_class : LawClass
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
    capped : bool
        Whether ``largest.low`` is no end of the criterion, but the largest ``k`` for which a certificate was tried.
    """

    criterion: str
    theorem: str
    largest: Bracket
    law_class: LawClass
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
    capped: bool = False

    def __bool__(self) -> bool:
        raise TypeError("a criterion has three answers; compare answer.verdict")

    def __str__(self) -> str:
        return f"{self.criterion}: {self.verdict} ({self.evidence}), largest k {self.largest}. {self.reason}"

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; infinite numbers are the text ``inf``."""
        from analysis.answers.largest import answer_dict

        return answer_dict(self)

    def _repr_html_(self) -> str:
        from analysis.answers.showing import answer_html

        return answer_html(self)

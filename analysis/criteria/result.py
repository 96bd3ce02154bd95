"""What a frequency criterion found: one record for every criterion and model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from analysis.evidence import Bracket, Evidence, Verdict
from lure.sector import Sector

if TYPE_CHECKING:
    from analysis.certificates.checker import Proved, Refuted

CriterionName = Literal["popov", "circle"]
Model = Literal["scheme", "rod", "loop"]


@dataclass(frozen=True, kw_only=True, slots=True)
class CriterionResult:
    r"""A frequency criterion for one block and one sector.

    The inequality is ``1/upper + Re[(1 + i omega theta) H(i omega)] > 0`` on ``[0, inf]``, both limits included, for
    ``mu = -phi(sigma)``, ``phi`` in ``[0, upper]``; the circle criterion is ``theta = 0``.

    Attributes
    ----------
    name : {"popov", "circle"}
        The criterion.
    model : {"scheme", "rod", "loop"}
        What the result is about: the N-cell scheme, the rod itself, or, for drawing, the block of some other loop.
    sector : Sector
        The sector asked about [Pa/m].
    verdict : Verdict
        PROVED if the inequality was certified over all frequencies; INCONCLUSIVE otherwise (a criterion that fails
        refutes nothing); REFUTED only with a destabilising member of the class.
    evidence : Evidence
        What the numbers rest on.
    theta : float or None
        Multiplier used [s]; None where the criterion does not apply.
    smallest_theta : Bracket or None
        Infimum of the multipliers ``theta >= 0`` that work for this sector [s] (zero for the circle criterion);
        None where none works or none is needed.
    margin : Bracket or None
        Infimum over ``[0, inf]`` of the left-hand side for ``theta`` [m/Pa].
    worst_frequency : float or None
        Where the margin is attained [rad/s]; ``inf`` if only in the limit.
    largest_sector : Bracket or None
        Supremum of the ``upper`` that the criterion reaches, over all ``theta >= 0`` [Pa/m].
    reason : str
        One sentence: what was shown, or why nothing was and what to try.
    hypotheses : tuple of str
        Hypotheses of the theorem, each with how it was checked.
    witness : str or None
        The destabilising example behind REFUTED.
    shown : Proved, Refuted or None
        What the checker accepted of it, with its certificate; None where it was not asked.
    """

    name: CriterionName
    model: Model
    sector: Sector
    verdict: Verdict
    evidence: Evidence
    theta: float | None
    smallest_theta: Bracket | None
    margin: Bracket | None
    worst_frequency: float | None
    largest_sector: Bracket | None
    reason: str
    hypotheses: tuple[str, ...] = ()
    witness: str | None = None
    shown: Proved | Refuted | None = None

    def __bool__(self) -> bool:
        raise TypeError("a criterion has three answers; compare result.verdict")

    def __str__(self) -> str:
        head = (
            f"{self.name.capitalize()} criterion, {self.model}, sector {self.sector}: {self.verdict} ({self.evidence})"
        )
        if self.theta is None or self.margin is None:
            return f"{head}. {self.reason}"
        return (
            f"{head}; theta = {self.theta:.6g} s, margin {self.margin.low:.6g} m/Pa at {self.worst_frequency:.6g} rad/s"
        )

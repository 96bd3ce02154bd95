"""What a frequency criterion found: one record for every criterion and model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from analysis.evidence import Bracket, Evidence, Verdict
from lure.sector import Sector
from lure.showing import html_table, plain

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

    @property
    def evidence_shown(self) -> Evidence | None:
        """The evidence, where there is a verdict or a number it is the evidence of; None where nothing was decided."""
        numbers = (self.margin, self.smallest_theta, self.largest_sector)
        decided = self.verdict is not Verdict.INCONCLUSIVE
        return self.evidence if decided or any(number is not None for number in numbers) else None

    def __bool__(self) -> bool:
        raise TypeError("a criterion has three answers; compare result.verdict")

    def __str__(self) -> str:
        head = f"{self.name.capitalize()} criterion, {self.model}, sector {self.sector}: {self.verdict}"
        head += f" ({self.evidence_shown})" if self.evidence_shown is not None else ""
        if self.theta is None or self.margin is None:
            return f"{head}. {self.reason}"
        return (
            f"{head}; theta = {self.theta:.6g} s, margin {self.margin.low:.6g} m/Pa at {self.worst_frequency:.6g} rad/s"
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; exact bounds are text ``p/q``, infinite ones ``inf``."""
        names = ("name", "model", "sector", "verdict", "evidence", "theta", "smallest_theta", "margin",
                 "worst_frequency", "largest_sector", "reason", "hypotheses", "witness")  # fmt: skip
        return {"kind": "criterion", **{name: plain(getattr(self, name)) for name in names}, "sentence": str(self)}

    def _repr_html_(self) -> str:
        about = {"scheme": "the N-cell scheme", "rod": "the rod itself"}.get(self.model, "the block of a loop")
        rows = [
            ("sector", f"{self.sector} Pa/m"),
            ("evidence", self.evidence_shown or "-"),
            ("theta", "-" if self.theta is None else f"{self.theta:.7g} s"),
            ("margin", "-" if self.margin is None else f"{self.margin} m/Pa"),
            ("reaches", "-" if self.largest_sector is None else f"{self.largest_sector} Pa/m"),
            ("reason", self.reason),
            *(("hypothesis", text) for text in self.hypotheses),
        ]
        notes = ["A criterion that fails refutes nothing."]
        if self.model == "rod":
            notes.append("The verdict on the motions of the rod rests on its energy theorem, not on this inequality.")
        if self.model == "scheme":
            notes.append("What holds for the scheme is about the scheme, not about the rod.")
        title = f"{self.name.capitalize()} inequality for {about}"
        return html_table(title, rows, verdict=str(self.verdict), notes=notes)

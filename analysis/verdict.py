"""What one criterion says about one block: the largest class it proves, on what evidence, and what it needs."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, cast

from lure.analysis.numerics.evidence import INFINITE as INFINITE
from lure.analysis.numerics.evidence import Bracket as Bracket
from lure.analysis.numerics.evidence import Evidence as Evidence
from lure.analysis.numerics.evidence import ends
from lure.analysis.wording import BEYOND, class_words
from lure.classes import Diagonal, NonlinearityClass, Sector
from lure.errors import Reason
from lure.record import Record, derived, plain, quantity

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


# Destabilising members of a class of nonlinearities: the other side of every answer.

Kind = Literal[
    "linear gain",
    "linear gains",
    "switched gain",
    "varying gain",
    "periodic orbit",
    "simulated orbit",
    "disturbance",
    "delay",
    "ray",
    "equilibrium",
]


class Witness(Record):
    r"""A member of a class ``[lower, k]`` with which ``sigma = H mu``, ``mu = -phi(sigma)`` does not come to rest."""

    kind: Kind = quantity("``simulated orbit`` is never more than observed")
    k: float = quantity(
        "Upper bound of the smallest class ``[lower, k]`` that contains the nonlinearity, rounded up where it is not "
        "exact",
        form="above",
    )
    evidence: Evidence = quantity(
        "CERTIFIED: an exact or interval argument; COMPUTED: floats with an error estimate; OBSERVED: a simulation"
    )
    slope_restricted: bool = quantity(
        "Whether the nonlinearity has slope in ``[lower, k]``; else it only lies in the sector", key=""
    )
    odd: bool = quantity("Whether the nonlinearity is odd", key="")
    time_varying: bool = quantity("Whether the nonlinearity depends on time", key="", default=False)
    description: str = quantity("One sentence: the nonlinearity and what the loop does with it")
    data: Mapping[str, object] = quantity(
        "What is needed to check it again: points of the nonlinearity, orbit, gains and times; exact numbers as "
        "``p/q``",
        label="",
        default_factory=lambda: MappingProxyType({}),
    )
    refutation: Refuted | None = quantity(
        "What the checker accepted of it, with its certificate; None where it was not asked",
        key="",
        label="",
        default=None,
    )
    _title = "a destabilising member of the class"

    def __str__(self) -> str:
        return f"{self.description} ({self.evidence})"


Needs = Literal["slope", "odd", "time-invariant"]
Model = Literal["", "scheme", "rod", "loop"]
_ABOUT = {"scheme": "the N-cell scheme", "rod": "the rod itself", "loop": "the block of a loop"}
_BESIDE = {
    "rod": ("What holds for the rod is about the partial differential equation, not about its scheme.",),
    "scheme": ("What holds for the scheme is about the scheme, not about the rod.",),
}


class CriterionResult(Record):
    r"""What a criterion says of ``mu = -phi(sigma)``, ``sigma = H mu``: of its largest class, or of one class.

    The inequality of Popov's criterion is ``1/k + Re[(1 + i omega theta) H(i omega)] > 0`` on ``[0, inf]``, both limits
    included, for ``phi`` in ``[0, k]``; that of the circle criterion has ``theta = 0``.
    """

    criterion: str = quantity("One of the names in :data:`lure.analysis.theorems.table.CRITERIA`", label="")
    nonlinearity_class: NonlinearityClass = quantity(
        "The class of nonlinearities the answer is about, at ``k = largest.low`` or at the ``k`` asked about; with "
        "several channels that of the first, see ``classes``",
        key="",
        label="class",
    )
    verdict: Verdict = quantity(
        "PROVED: the classes up to ``largest.low`` (or the class asked about) are absolutely stable.  REFUTED: with a "
        "destabilising member in ``witness``.  INCONCLUSIVE: see ``reason``",
        label="",
    )
    evidence: Evidence = quantity("What ``largest.low`` and the verdict rest on", label="")
    largest: Bracket = quantity(
        "The largest ``k`` of the classes ``[lower, k]``, ``lower`` that of ``nonlinearity_class``.  ``low``: every "
        "class "
        "``[lower, k]`` with finite ``k <= low`` is proved if ``verdict`` is PROVED.  ``high``: the criterion (for "
        "``zames-falb`` in continuous time: any criterion) can say nothing at or above it",
        plainly=ends,
        label="largest k",
    )
    needs: tuple[Needs, ...] = quantity(
        "Properties of ``phi`` beyond its sector that the theorem needs", label="", default=()
    )
    theta: float | None = quantity("Popov multiplier used at ``largest.low``", "s", label="", default=None)
    multiplier: str | None = quantity(
        "The multiplier as a formula", form=lambda multiplier: multiplier or "-", default=None
    )
    parameters: Mapping[str, object] = quantity(
        "Numbers behind ``multiplier``, exact ones as text ``p/q``, enough to check the inequality again",
        label="",
        default_factory=lambda: MappingProxyType({}),
    )
    margin: Bracket | None = quantity(
        "Infimum over frequency of the left-hand side of the inequality for the class asked about",
        plainly=ends,
        default=None,
    )
    worst_frequency: float | None = quantity(
        "Where the inequality is tight, in discrete time per sample; ``inf`` if only in the limit",
        "rad/s",
        label="",
        default=None,
    )
    theorem: str = quantity("The theorem by name, with its source")
    reason: str = quantity("One sentence: what was shown, or why nothing was and what to try", default="")
    hypotheses: tuple[str, ...] = quantity(
        "Each hypothesis of the theorem, with how it was checked or that it is assumed",
        label="hypothesis",
        form="rows",
        default=(),
    )
    witness: str | None = quantity("The destabilising member behind REFUTED", key="", label="", default=None)
    shown: Proved | Refuted | None = quantity(
        "What the checker accepted of it, with its certificate; None where it was not asked",
        key="",
        label="",
        default=None,
    )
    model: Model = quantity(
        "What it is about, if not the plant that was given: the N-cell scheme, the rod itself (``k`` is then "
        "in Pa/m and the margin in m/Pa) or, for drawing, the block of some other loop",
        key="",
        label="",
        default="",
    )
    smallest_theta: Bracket | None = quantity(
        "Infimum of the multipliers ``theta >= 0`` that work for this sector, where that was looked for",
        "s",
        key="",
        label="",
        default=None,
    )
    code: Reason = quantity("Why it is INCONCLUSIVE, where it is", key="", label="", default=Reason.NO_MULTIPLIER)
    search_limited: bool = quantity(
        "Whether ``largest.low`` is no end of the criterion, but the largest ``k`` for which a certificate was tried",
        key="",
        label="",
        default=False,
    )
    classes: Diagonal | None = quantity(
        "With several channels their classes at the factor ``largest.low``", key="", label="", default=None
    )
    _no_truth = "a criterion has three answers; compare result.verdict"

    @property
    @derived(key="class", label="")
    def class_words(self) -> str:
        """The class of the certificate in words; without one ``nonlinearity_class``."""
        if self.proof is None:
            return str(self.classes or self.nonlinearity_class)
        return class_words(self.proof.certificate["laws"])

    @property
    def proof(self) -> Proved | None:
        """What the checker accepted of a PROVED answer; None where it was not asked."""
        return cast("Proved | None", self.shown) if self.verdict is Verdict.PROVED else None

    @property
    def sector(self) -> Sector:
        """The sector of the class."""
        return self.nonlinearity_class.sector

    @property
    @derived(key="", label="evidence", form=lambda shown: "-" if shown is None else str(shown))
    def evidence_shown(self) -> Evidence | None:
        """The evidence, where there is a verdict or a margin it is the evidence of; None where nothing was decided."""
        return self.evidence if self.verdict is not Verdict.INCONCLUSIVE or self.margin is not None else None

    @property
    def _title(self) -> str:
        return f"{self.criterion} criterion" + (f" for {_ABOUT[self.model]}" if self.model else "")

    @property
    def _verdict(self) -> str:
        return str(self.verdict)

    @property
    def _notes(self) -> tuple[str, ...]:
        return (BEYOND, *_BESIDE.get(self.model, ()))

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data; of a model also what it is and which sector was asked about."""
        found = super().to_dict()
        if self.model:
            found |= {"name": self.criterion, "model": self.model, "sector": plain(self.sector)}
            found |= {"smallest_theta": plain(self.smallest_theta), "largest_sector": found["largest"]}
        return found

    def __str__(self) -> str:
        about = f", {self.model}, sector {self.sector}" if self.model else ""
        evidence = "" if self.evidence_shown is None else f" ({self.evidence})"
        return f"{self.criterion}{about}: {self.verdict}{evidence}, largest k {self.largest}. {self.reason}"

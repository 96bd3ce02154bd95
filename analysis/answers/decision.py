"""The verdict on the class asked about, from the table of classes."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from analysis.answers.certifying import unbounded_proof, with_law
from analysis.answers.largest import Largest, proved_up_to, rounded_down
from analysis.answers.subject import Subject
from analysis.criteria.circle import circle_criterion
from analysis.criteria.hurwitz import GainInterval
from analysis.criteria.popov import popov_criterion
from analysis.evidence import Evidence, Verdict
from lure.errors import AssumptionError
from lure.law_class import LawClass
from lure.rational import RationalBlock
from lure.sector import Sector, SlopeBounds

if TYPE_CHECKING:
    from analysis.certificates.checker import Proved, Refuted

Decision = tuple[Verdict, Evidence, str, "Proved | Refuted | None"]

_ROUGH = (
    "Nothing is decided for {law}, not known to be locally Lipschitz, as the theorems for continuous time assume. For "
    "the laws that are: {said}"
)


def asked_row(rows: list[Largest], law_class: LawClass | None) -> Largest | None:
    """The row whose class is that of the question, of the four in their order of the table."""
    if law_class is None:
        return None
    if law_class.time_varying:
        return rows[0]
    if law_class.slope is None:
        return rows[1]
    return rows[3] if law_class.odd else rows[2]


def decided(about: Subject, rows: list[Largest]) -> Decision:
    """Verdict, evidence, a sentence and what the checker accepted of it, on the class asked about.

    Without a class on the row that reaches farthest.
    """
    law_class, asked = about.law_class, asked_row(rows, about.law_class)
    if law_class is None or asked is None:
        best = max(rows, key=lambda row: (row.verdict is Verdict.PROVED, row.largest.low, not row.time_varying))
        return (
            best.verdict,
            best.evidence,
            str(best),
            best.refutation if best.verdict is Verdict.REFUTED else best.proof,
        )
    return (
        _proved(about, [asked, *(row for row in rows if row is not asked)], law_class)
        or _refuted(asked, law_class)
        or _open(asked, [row for row in rows if serves(row, law_class)], law_class)
    )


def _proved(about: Subject, rows: list[Largest], law_class: LawClass) -> Decision | None:
    for row in rows:
        slope = law_class.slope if row.question == "slope" else None
        end = law_class.sector.upper if slope is None else slope.upper
        if not (serves(row, law_class) and row.verdict is Verdict.PROVED and end <= row.largest.low):
            continue
        if row.proviso and not _solvable(about, law_class):
            continue
        proof = row.proof if end < math.inf else _unbounded(about, row, law_class)
        if proof is not None:
            how = f"by the criterion {row.criterion} ({row.evidence}), which reaches {proved_up_to(row)}"
            proviso = f" {row.proviso}" if row.proviso and law_class.slope is None else ""
            said = f"{row.meaning} for every {law_class}{proviso}, {how}."
            if _rough(about):
                return Verdict.INCONCLUSIVE, row.evidence, _ROUGH.format(law=about.law, said=said), None
            return Verdict.PROVED, row.evidence, said, with_law(proof, about.law)
    return None


def _unbounded(about: Subject, row: Largest, law_class: LawClass) -> Proved | None:
    """What is accepted of the class without an upper bound: every finite ``k`` is less than that.

    ``sigma^3`` lies in ``[0, inf]`` and in no ``[0, k]``.
    """
    block = about.block
    if not isinstance(block, RationalBlock):
        return None
    sector = Sector(row.lower, math.inf)
    criterion = circle_criterion if law_class.time_varying else popov_criterion
    try:
        return unbounded_proof(block, criterion(block, sector), time_varying=law_class.time_varying)
    except AssumptionError:
        return None


def _refuted(asked: Largest, law_class: LawClass) -> Decision | None:
    """Refuted only by a member of the very class: the row may assume less than the question does."""
    witness, bounds = asked.witness, law_class.slope or law_class.sector
    tighter = law_class.slope is not None and (
        (law_class.sector.lower, law_class.sector.upper) != (law_class.slope.lower, law_class.slope.upper)
    )
    if (
        witness is None
        or witness.refutation is None
        or asked.refuted_at is None
        or tighter
        or not asked.refuted_at <= bounds.upper
    ):
        return None
    if (law_class.odd and not witness.odd) or (law_class.slope is not None and not witness.slope_restricted):
        return None
    return (
        Verdict.REFUTED,
        witness.evidence,
        f"The loop is not stable for every {law_class}: {witness}. Whether a given law of the class destabilises is "
        "another question.",
        witness.refutation,
    )


def _open(asked: Largest, serving: list[Largest], law_class: LawClass) -> Decision:
    reach = max((row.largest.low for row in serving if row.verdict is Verdict.PROVED), default=None)
    far = "nothing is proved" if reach is None else f"what is proved ends at {rounded_down(reach)}"
    found = asked.refuted_at
    if any(row.proviso and law_class.sector.upper <= row.largest.low for row in serving):
        far = "Popov's criterion proves it for laws " + next(row.proviso for row in serving if row.proviso)
        far += ", which the class does not promise; slope bounds would"
    elif reach == math.inf:
        far = "every finite upper bound is proved, and a class without any holds laws beyond all of them"
    against = "" if found is None else f", and the smallest destabilising member found has {found:.7g}"
    return Verdict.INCONCLUSIVE, Evidence.CERTIFIED, f"Nothing is decided for {law_class}: {far}{against}.", None


def _rough(about: Subject) -> bool:
    """Whether there is a law, and it lacks the regularity that the theorems for continuous time assume."""
    continuous = getattr(about.block, "dt", None) is None
    return continuous and about.law is not None and not getattr(about.law, "locally_lipschitz", True)


def _solvable(about: Subject, law_class: LawClass) -> bool:
    """Whether slope bounds of the class or the law keep ``1 + D phi'`` positive: the loop then defines ``sigma``."""
    if not isinstance(about.block, RationalBlock):
        return False
    slope = law_class.slope or getattr(about.law, "slope_bounds", None)
    if not isinstance(slope, SlopeBounds):
        return False
    ends = (slope.lower, slope.upper)
    return all(math.isfinite(end) and 1 + about.block.feedthrough * Fraction(end) > 0 for end in ends)


def serves(row: Largest, law_class: LawClass) -> bool:
    """Whether the class asked about is contained in the class of the row, but for its upper end."""
    if law_class.time_varying:
        return row.time_varying
    if row.question == "slope":
        return law_class.slope is not None and (law_class.odd or not row.odd)
    return True


def hints(
    rows: list[Largest], law_class: LawClass | None, gains: tuple[GainInterval, ...], verdict: Verdict
) -> tuple[str, ...]:
    """What would decide more: a smaller class, another lower end, a property the law may have."""
    if verdict is Verdict.PROVED:
        return ()
    found: list[str] = []
    if gains and all(row.verdict is not Verdict.PROVED for row in rows):
        spans = ", ".join(str(gain) for gain in gains)
        found.append(f"take classes whose lower end is a stable linear gain, inside one of {spans}")
    if law_class is None:
        return tuple(found)
    end = law_class.sector.upper
    serving = [row.largest.low for row in rows if serves(row, law_class) and row.verdict is Verdict.PROVED]
    if serving and law_class.sector.lower < max(serving) < end:
        found.append(f"an upper bound of {rounded_down(max(serving))} instead of {float(end):.7g} would be proved")
    names = ("time-varying", "time-invariance", "slope bounds", "slope bounds and oddness")
    for name, row in zip(names, rows, strict=True):
        if not serves(row, law_class) and row.verdict is Verdict.PROVED and end <= row.largest.low and end < math.inf:
            found.append(f"{name} of phi would be enough ({row.criterion} reaches {proved_up_to(row)})")
            break
    return tuple(found)

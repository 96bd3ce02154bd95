"""Why a class is not decided, as a code and a sentence, and what can be done about it; nothing here is a verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from lure.analysis.certificates import codes
from lure.analysis.inequality.gains import GainInterval
from lure.analysis.numerics.doubles import bound_below
from lure.analysis.questions.conclusion import Conclusion
from lure.analysis.questions.largest import StabilityBound
from lure.analysis.questions.problem import Problem
from lure.analysis.theorems.table import TABLE
from lure.analysis.verdict import Verdict
from lure.arrays import np
from lure.classes import NonlinearityClass
from lure.nonlinearities.base import Nonlinearity

if TYPE_CHECKING:
    from lure.analysis.certificates.codes import Code
    from lure.analysis.certificates.drafts import Failure

_SPECIFIC = (codes.OUTSIDE_CLASS, codes.NOT_LIPSCHITZ, codes.SEVERAL_SOLUTIONS)
_WITHOUT = "nothing is proved"


def row_asked(rows: Sequence[StabilityBound], nonlinearity_class: NonlinearityClass) -> StabilityBound:
    """The row whose class is of the kind asked about; where there is none, the first.

    ``rows``: what is known of the largest classes.
    """
    varying = nonlinearity_class.time_varying
    slope = nonlinearity_class.slope is not None and not varying
    kind = ("slope" if slope else "sector", slope and nonlinearity_class.odd, varying)
    return next((row for row in rows if (row.question, row.odd, row.time_varying) == kind), rows[0])


def serves(row: StabilityBound, nonlinearity_class: NonlinearityClass) -> bool:
    """Whether the class of the row may contain the class asked about: what is worth trying, and no verdict."""
    if not _low_enough(row, nonlinearity_class):
        return False
    if nonlinearity_class.time_varying:
        return row.time_varying
    if row.question == "slope":
        return nonlinearity_class.slope is not None and (nonlinearity_class.odd or not row.odd)
    return True


def _low_enough(row: StabilityBound, nonlinearity_class: NonlinearityClass) -> bool:
    """Whether the classes of the row begin at or below the class asked about."""
    bounds = nonlinearity_class.slope if row.question == "slope" else None
    return row.lower <= (bounds or nonlinearity_class.sector).lower


def why(
    asked: StabilityBound, rows: list[StabilityBound], nonlinearity_class: NonlinearityClass, missed: Sequence[Failure]
) -> tuple[Code, str]:
    """Why the class asked about is not decided.

    ``asked``: the row of the class asked about; ``missed``: what was accepted and does not fit, each with its reason.

    Returns
    -------
    tuple of Code, str
        The code, and a sentence without a capital or a full stop.
    """
    for specific in _SPECIFIC:
        for found in missed:
            if found.code is specific:
                return specific, found.detail
    proved = max(
        (row.largest.low for row in rows if serves(row, nonlinearity_class) and row.verdict is Verdict.PROVED),
        default=None,
    )
    against = "" if asked.refuted_at is None else f", and the smallest class refuted ends at {asked.refuted_text}"
    if asked.stopped is not None:
        return codes.OUT_OF_TIME, f"the search was stopped: {_WITHOUT if proved is None else _ends(proved)}{against}"
    if not _low_enough(asked, nonlinearity_class):
        return codes.DEAD_TIME, f"with dead time the theorems are about classes from 0 on{against}"
    if proved == math.inf:
        far = "every finite upper bound is proved, and a class without any holds nonlinearities beyond all of them"
        return codes.EVERY_FINITE, far + against
    if proved is not None:
        return codes.NO_MULTIPLIER, f"{_ends(proved)}{against}"
    said = [(codes.REGISTRY[answer.code], answer.reason) for answer in asked.answers if answer.reason]
    code, reason = min(said, key=lambda one: codes.WORST.index(one[0]), default=(codes.NO_MULTIPLIER, _WITHOUT))
    return code, reason.rstrip(".") + against


def _ends(proved: float) -> str:
    return f"what is proved ends at {bound_below(proved)}"


def hints(
    problem: Problem, rows: list[StabilityBound], gains: tuple[GainInterval, ...], conclusion: Conclusion
) -> tuple[str, ...]:
    """What would decide more: a smaller class, another lower end, a property that the given phi can have.

    ``problem``: the loop; ``rows``: the rows in the order of the table; ``gains``: all stable linear gains;
    ``conclusion``: what follows for the class asked about.
    """
    nonlinearity_class, nonlinearity = problem.given, problem.nonlinearity
    if conclusion.verdict is Verdict.PROVED:
        return ()
    found: list[str] = []
    if gains and all(row.verdict is not Verdict.PROVED for row in rows):
        spans = ", ".join(str(gain) for gain in gains)
        if nonlinearity is None or any(_inside(nonlinearity.sector.lower, gain) for gain in gains):
            found.append(f"take classes whose lower end is a stable linear gain, inside one of {spans}")
        else:
            found += _local(nonlinearity, gains, spans)
    if nonlinearity_class is None:
        return tuple(found)
    end = nonlinearity_class.sector.upper
    serving = [row.largest.low for row in rows if serves(row, nonlinearity_class) and _promised(row)]
    if serving and nonlinearity_class.sector.lower < max(serving) < end:
        text = f"an upper bound of {bound_below(max(serving))} instead of {float(end):.7g} would be proved"
        own = nonlinearity is None or nonlinearity.sector.upper <= max(serving)
        found.append(text if own else f"{text}, in which {nonlinearity} does not lie")
    names = ("time-varying", "time-invariance", "slope bounds", "slope bounds and oddness")
    for name, row in zip(names, rows, strict=True):
        enough = _promised(row) and end <= row.largest.low and end != math.inf
        if serves(row, nonlinearity_class) or not enough or not _low_enough(row, nonlinearity_class):
            continue
        if _possible(name, nonlinearity):
            found.append(f"{name} of phi would be enough ({row.criterion} reaches {row.proved_up_to})")
            break
    return tuple(found)


def _promised(row: StabilityBound) -> bool:
    """Whether something is proved of the row, and nothing is assumed for which one class is refused: slopes show it."""
    composed = any(one.composed and one.name == row.criterion for one in TABLE)
    return row.verdict is Verdict.PROVED and not (composed and row.proviso and row.question == "sector")


def _inside(gain: float | Fraction, interval: GainInterval) -> bool:
    return interval.lower.value.high < gain < interval.upper.value.low


def _local(nonlinearity: Nonlinearity, gains: tuple[GainInterval, ...], spans: str) -> list[str]:
    """Advice for a nonlinearity whose gain ``phi(sigma)/sigma`` falls to one that is not stable."""
    from lure.nonlinearities.properties import nonlinearity_text

    with np.errstate(all="ignore"):
        small, large = (float(np.asarray(nonlinearity(sigma))) / sigma for sigma in (1e-6, 1e6))
    low = float(nonlinearity.sector.lower)
    said = [
        f"no class whose lower end is a stable gain, inside {spans}, contains {nonlinearity_text(nonlinearity)}: "
        f"phi(sigma)/sigma falls to {low:.7g}; criteria for classes need another phi, or a plant stable with that gain"
    ]
    if any(_inside(small, gain) for gain in gains) and abs(large - low) < 1e-3 * abs(small - low):
        said.append(
            "for small sigma the gain is stable: ask lure region from where solutions tend to 0, perhaps from "
            "everywhere; or take a phi whose gain does not vanish at infinity, or, where a controller integrates, an "
            "anti-windup compensator"
        )
    return said


def _possible(name: str, nonlinearity: Nonlinearity | None) -> bool:
    """Whether the given phi can have the property: one that jumps has no slope bounds, one that is not odd stays so."""
    if nonlinearity is None:
        return True
    from lure.nonlinearities import Provenance, properties

    known = properties(nonlinearity)
    if "slope" in name and known.slope_bounds.provenance is Provenance.CHECKED and known.slope_bounds.value is None:
        return False
    return not ("odd" in name and known.odd.provenance is Provenance.CHECKED and not known.odd.value)

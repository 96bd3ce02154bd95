"""Proofs by a matrix, as close as rounding allows to what the circle or Popov's criterion reaches in doubles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from types import MappingProxyType

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.proposals import LARGE
from lure.analysis.certificates.sealing import settled
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import double_below
from lure.analysis.theorems.table import Upper, row_of
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.arrays import np
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError
from lure.plants.state_space import StateSpace

STEPS_DOWN = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.999999)

LARGER = (Fraction(1), Fraction(2), Fraction(4))
SMALLER = (Fraction(1, 16), Fraction(1, 256), Fraction(1, 4096))


def certified_by_matrix(block: StateSpace, answer: Answer) -> Answer:
    """The answer with what the checker accepted of it; INCONCLUSIVE where it accepted nothing.

    Parameters
    ----------
    block : StateSpace
        The block.
    answer : Answer
        Of :func:`lure.analysis.inequality.state_space.state_space_largest`, or a refusal, which stays as it is.

    Returns
    -------
    Answer
        PROVED with ``proof``, ``largest.low`` the upper end of the class that was accepted: a relative step of 1e-10
        below the computed one, or a larger step where rounding errors ask for it.  Where every finite ``k`` seems to be
        reached, that is proved, or else a large ``k``, and the answer is ``search_limited``.
    """
    if answer.theta is None:  # the criterion does not apply
        return answer
    lower, reason = Fraction(answer.law_class.sector.lower), "the criterion reaches no class"
    varying, infinite = row_of(answer.criterion, block).time_varying, answer.largest.low == math.inf
    for upper, theta in _proposals(block, answer, lower):
        checkpoint()
        try:
            draft = matrix_draft(block, upper, lower=lower, theta=theta)
            draft["laws"] |= {"time_varying": varying}
            proved = settled(draft)
        except (AssumptionError, Rejected) as refusal:
            reason = str(refusal)
            continue
        if not isinstance(proved, Proved):
            continue
        low = math.inf if isinstance(upper, str) else double_below(upper)
        search_limited = infinite and low < math.inf
        tried = f"{low:g}".replace("e+", "e")
        return replace(
            answer,
            largest=Bracket(low, max(low, answer.largest.high)),
            law_class=NonlinearityClass(sector=Sector(lower, low), time_varying=varying),
            theta=float(theta or 0),
            parameters=MappingProxyType({} if theta is None else {"theta": str(theta)}),
            verdict=Verdict.PROVED,
            evidence=Evidence.CERTIFIED,
            hypotheses=tuple(f"{name}: {fact}" for name, fact in proved.facts.items()),
            proof=proved,
            search_limited=search_limited,
            reason=f"{tried} is the largest k for which a certificate was tried" if search_limited else "",
        )
    return replace(answer, reason=f"computed in floating point, not certified: {reason}")


def _proposals(block: StateSpace, answer: Answer, lower: Fraction) -> Iterator[tuple[Upper, Fraction | None]]:
    """Upper ends to try, the largest first, each with ``theta``; doubles, so that what is printed is what is proved."""
    low = answer.largest.low
    theta = None if row_of(answer.criterion, block).time_varying else Fraction(str(answer.parameters["theta"]))
    if low == math.inf:
        if theta is not None:  # at infinite frequency theta > 0 has to help
            unit = theta or Fraction(1 / float(np.linalg.norm(block.A, 2)))
            yield from (("finite", unit * factor) for factor in (*LARGER, *(() if theta else SMALLER)))
        omega = np.geomspace(1e-4, 3.0, 20) * (1.0 if block.dt is not None else float(np.linalg.norm(block.A, 2)))
        values = block.transfer(np.exp(1j * omega) if block.dt is not None else 1j * omega)
        size = float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))
        unit = Fraction(10) ** (-round(math.log10(size)) if size > 0 else 0)
        yield from ((lower + large * unit, theta) for large in LARGE)
        return
    tried = lower
    for step in STEPS_DOWN:
        upper = Fraction(double_below(lower + (Fraction(low) - lower) * (1 - Fraction(step))))
        if lower < upper != tried:
            tried = upper
            yield upper, theta

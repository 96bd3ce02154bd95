"""Proofs by a matrix, as close as rounding allows to what the circle or Popov's criterion reaches in doubles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial

from lure.analysis.certificates.matrix import matrix_draft
from lure.analysis.certificates.proposals import LARGE
from lure.analysis.certificates.theory import Draft, theory_of
from lure.analysis.inequality.state_space import StatesInequality
from lure.analysis.numerics.doubles import double_below
from lure.analysis.theorems.table import Upper, row_of
from lure.analysis.verdict import CriterionResult
from lure.arrays import np
from lure.classes import NonlinearityClass
from lure.errors import AssumptionError, Reason
from lure.plants.block import StructuredPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

STEPS_DOWN = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.999999)

LARGER = (Fraction(1), Fraction(2), Fraction(4))
SMALLER = (Fraction(1, 16), Fraction(1, 256), Fraction(1, 4096))


def matrix_drafts(block: StateSpace, answer: CriterionResult) -> Iterator[tuple[Upper, Draft]]:
    """The proofs to try of what the circle or Popov's criterion reaches in doubles, the largest class first.

    ``answer``: of the criterion, computed.

    Yields
    ------
    tuple of Fraction or str, dict
        The upper end of the class: a relative step of 1e-10 below the computed one, or a larger step where rounding
        errors ask for it; where every finite ``k`` seems to be reached, that, or else a large ``k``.

    Raises
    ------
    AssumptionError
        For no class a matrix was found; nothing follows about the loop.
    """
    lower, reason = Fraction(answer.nonlinearity_class.sector.lower), "the criterion reaches no class"
    varying, found = row_of(answer.criterion, block).time_varying, False
    for upper, theta in _proposals(block, answer, lower):
        try:
            draft = matrix_draft(block, upper, lower=lower, theta=theta)
        except AssumptionError as refusal:
            reason = str(refusal)
            continue
        draft["laws"] |= {"time_varying": varying}
        found = True
        yield upper, draft
    if not found:
        raise AssumptionError(reason)


def _proposals(block: StateSpace, answer: CriterionResult, lower: Fraction) -> Iterator[tuple[Upper, Fraction | None]]:
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


# One class: of the circle and Popov's criterion, with the multipliers that are worth a try.

_GUESSES = ("1", "1/10", "10")  # [s]


def class_drafts(
    plant: object, nonlinearity_class: NonlinearityClass, criterion: str, *, finite: bool
) -> Iterator[tuple[str, Callable[[], Draft]]]:
    """Drafts for a plant without an exact criterion behind them, cheapest first.

    Parameters
    ----------
    plant : StateSpace or StructuredPlant
        The plant, of finitely many states.
    nonlinearity_class : NonlinearityClass
        The class.
    criterion : str
        ``circle``, ``popov`` or ``best``.
    finite : bool
        Whether an infinite upper end means every nonlinearity with some finite bound.

    Yields
    ------
    tuple of str, callable
        The name of the criterion, and what makes the draft or raises ``AssumptionError``.
    """
    draft = partial(_class_draft, plant, nonlinearity_class, finite=finite)
    if criterion in ("best", "circle"):
        yield "circle, by matrices", partial(draft, None)
    if criterion in ("best", "popov") and not nonlinearity_class.time_varying and getattr(plant, "dt", None) is None:
        for theta in _thetas(plant, nonlinearity_class.sector.lower):
            yield f"popov, by matrices, theta = {float(theta):.6g}", partial(draft, theta)


def answer_draft(
    plant: object, nonlinearity_class: NonlinearityClass, answer: CriterionResult, *, finite: bool
) -> Draft:
    """A draft by a matrix for what a criterion proved of a rational plant.

    ``answer``: of the circle or Popov's criterion, PROVED for the class; ``finite``: whether an infinite upper end
    means every nonlinearity with some finite bound.

    Raises
    ------
    AssumptionError
        It is another criterion, or no matrix was found.
    """
    row = row_of(answer.criterion, plant)
    if not row.matrix:
        raise AssumptionError(
            f"the criterion {answer.criterion} needs no matrix: --method polynomial or cover shows it"
        )
    given = "" if row.time_varying else str(answer.parameters.get("theta", "0"))
    theta = Fraction(1) if "inf" in given else Fraction(given) if given else None
    return _class_draft(plant, nonlinearity_class, theta, finite=finite)


def _class_draft(
    plant: object, nonlinearity_class: NonlinearityClass, theta: Fraction | None, *, finite: bool
) -> Draft:
    sector = nonlinearity_class.sector
    infinite = isinstance(plant, StructuredPlant) and plant.order is None
    if infinite or not isinstance(plant, RationalPlant | StateSpace | StructuredPlant):
        raise AssumptionError(
            f"a proof by matrices is for blocks with finitely many states, not a {type(plant).__name__}"
        )
    if sector.lower == -math.inf:
        raise AssumptionError(
            "the class has no finite lower end, and a proof by matrices begins at one", code=Reason.NO_LOWER_END
        )
    upper: Upper = Fraction(sector.upper) if sector.upper != math.inf else "finite" if finite else "inf"
    return matrix_draft(plant, upper, lower=Fraction(sector.lower), theta=theta)


def _thetas(plant: object, lower: float | Fraction) -> Iterator[Fraction]:
    """Popov multipliers worth a try: those of its structure, the one that floating point finds best, some guesses."""
    if isinstance(plant, StructuredPlant):
        yield from theory_of(plant).thetas()
    elif isinstance(plant, StateSpace) and lower != -math.inf:
        try:
            best = (StatesInequality(plant, Fraction(lower), weighted=True).best().multiplier or {}).get("theta")
        except AssumptionError:  # an eigenvalue at 0, perhaps: the matrix inequality has a critical case of its own
            best = None
        found = (Fraction(best).limit_denominator(10**6) or Fraction(best),) if best else map(Fraction, _GUESSES)
        yield from found

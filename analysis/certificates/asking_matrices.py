"""Proofs by matrices asked for: of the circle and Popov's criterion, with the multipliers that are worth a try."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any

from analysis.answer import Answer
from analysis.certificates.matrix import matrix_draft
from analysis.certificates.multipliers import Upper, rod_theta
from analysis.certificates.posing import Question
from analysis.certificates.proposals import Numbers
from analysis.certificates.scheme_energy import energy_theta
from lure.errors import AssumptionError
from lure.rational import RationalBlock
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme

Draft = dict[str, Any]
_GUESSES = ("1", "1/10", "10")  # [s]


def matrix_drafts(question: Question, numbers: Numbers) -> Iterator[tuple[str, Callable[[], Draft]]]:
    """Drafts of proofs by matrices for a block without an exact criterion behind them, cheapest first.

    Parameters
    ----------
    question : Question
        About a ``StateSpaceBlock`` or an ``UpwindScheme``.
    numbers : str
        Where the numbers came from.

    Yields
    ------
    tuple of str, callable
        The name of the criterion, and what makes the draft or raises ``AssumptionError``.
    """
    wanted, varying = question.criterion, question.law_class.time_varying
    continuous = getattr(question.block, "dt", None) is None
    if wanted in ("best", "circle"):
        yield "circle, by matrices", lambda: _draft(question, None, numbers)
    if wanted in ("best", "popov") and not varying and continuous:
        for theta in _thetas(question):
            yield f"popov, by matrices, theta = {float(theta):.6g}", partial(_draft, question, theta, numbers)


def draft_by_matrix(question: Question, answer: Answer, numbers: Numbers) -> Draft:
    """A draft by a matrix for what a criterion proved.

    Parameters
    ----------
    question : Question
        About a rational block.
    answer : Answer
        Of the circle or Popov's criterion, PROVED for the class.
    numbers : str
        Where the numbers came from.

    Raises
    ------
    AssumptionError
        It is another criterion, or no matrix was found.
    """
    if answer.criterion not in ("circle", "popov"):
        raise AssumptionError(
            f"the criterion {answer.criterion} needs no matrix: --method polynomial or cover shows it"
        )
    theta = None
    if answer.criterion == "popov":
        given = str(answer.parameters.get("theta", "0"))
        theta = Fraction(1) if "inf" in given else Fraction(given)
    return _draft(question, theta, numbers)


def _draft(question: Question, theta: Fraction | None, numbers: Numbers) -> Draft:
    block, sector = question.block, question.law_class.sector
    if not isinstance(block, RationalBlock | StateSpaceBlock | UpwindScheme):
        raise AssumptionError(
            f"a proof by matrices is for blocks with finitely many states, not a {type(block).__name__}"
        )
    if sector.lower == -math.inf:
        raise AssumptionError("the class has no finite lower end, and a proof by matrices begins at one")
    endless: Upper = "finite" if question.finite else "inf"
    upper: Upper = endless if sector.upper == math.inf else Fraction(sector.upper)
    draft = matrix_draft(block, upper, lower=Fraction(sector.lower), theta=theta)
    return {**draft, "numbers": numbers}


def _thetas(question: Question) -> Iterator[Fraction]:
    """Popov multipliers worth a try: the energy's of a rod, the one that floating point finds best, some guesses."""
    block = question.block
    if isinstance(block, UpwindScheme):
        yield rod_theta(block.rod)
        yield energy_theta(block)
        return
    lower = question.law_class.sector.lower
    if not isinstance(block, StateSpaceBlock) or lower == -math.inf:
        return
    from analysis.criteria.state_space import state_space_largest

    try:
        found = state_space_largest(block, "popov", lower=Fraction(lower))
    except AssumptionError:  # an eigenvalue at 0, perhaps: the matrix inequality has a critical case of its own
        yield from map(Fraction, _GUESSES)
        return
    if found.theta:
        yield Fraction(found.theta).limit_denominator(10**6) or Fraction(found.theta)
    else:
        yield from map(Fraction, _GUESSES)

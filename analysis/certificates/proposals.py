"""Certificates for what the criteria proved, by the polynomial, cover and structure methods: proposed, then checked."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, Literal

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.covers import Uncovered, cover_proof, has_delays
from lure.analysis.certificates.drafts import complete_and_check
from lure.analysis.certificates.multipliers import multipliers
from lure.analysis.certificates.systems import class_entry, system_of, text
from lure.analysis.certificates.theory import Draft, theory_of
from lure.analysis.deadline import checkpoint
from lure.analysis.theorems.table import Upper, row_of
from lure.analysis.verdict import CriterionResult
from lure.arrays import np
from lure.plants.block import StructuredPlant
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

Numbers = Literal["rationals", "decimals as written", "doubles, exactly"]

DOUBLES_BELOW = 3
STEPS_DOWN = (1e-15, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7)
FARTHER_DOWN = (1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 5e-4, 9e-4, 1e-2, 1e-1)
LARGE = (10**12, 10**9, 10**6, 10**3)


@described(frozen=True, kw_only=True, slots=True)
class Certified:
    """A certificate that the checker accepted."""

    proved: Proved = quantity("What it proves; ``proved.certificate`` is the certificate")
    upper: Upper = quantity(
        "Upper end of the class certified: it can be below the one asked for, and the claim then has to be lowered"
    )


def certified(
    block: RationalPlant | DelayPlant | StateSpace | StructuredPlant,
    answer: CriterionResult,
    upper: Upper | None = None,
    *,
    numbers: Numbers = "rationals",
) -> Certified:
    r"""A certificate for an answer that the checker accepted.

    Multipliers beside that of the answer are tried, and then smaller classes: the next doubles below, relative steps
    from 1e-15 on, up to 1e-1 where the inequality has delays; for ``"finite"`` where no one multiplier serves, large
    numbers.

    Parameters
    ----------
    block : RationalPlant, DelayPlant, StateSpace or StructuredPlant
        The block of the answer.
    answer : CriterionResult
        An answer whose verdict is PROVED; of ``hurwitz`` and of a ``StateSpace`` whatever its verdict.
    upper : Fraction or {"finite", "inf"}, optional
        Upper end of the class; by default that of ``answer.nonlinearity_class``, or ``"finite"`` where that is
        infinite.
    numbers : str
        Where the coefficients came from.

    Returns
    -------
    Certified
        With what was proved, and how far.

    Raises
    ------
    Rejected
        The checker accepted none; the reason is that of the likeliest.
    """
    first: Rejected | None = None
    for smaller, draft in drafts(block, answer, upper):
        checkpoint()
        try:
            proof = cover_proof(draft) if has_delays(draft) else draft["proof"]
            proved = complete_and_check({"numbers": numbers, **draft, "proof": proof})
        except (Rejected, Uncovered) as refusal:
            first = first or (refusal if isinstance(refusal, Rejected) else Rejected(str(refusal)))
            continue
        if isinstance(proved, Proved):
            return Certified(proved=proved, upper=smaller)
    raise first or Rejected(f"no multiplier of {answer.criterion} to propose")


def drafts(
    block: RationalPlant | DelayPlant | StateSpace | StructuredPlant,
    answer: CriterionResult,
    upper: Upper | None = None,
) -> Iterator[tuple[Upper, Draft]]:
    """The certificates to try for an answer, the likeliest first, without a cover and what the checker fills in.

    Parameters
    ----------
    block : RationalPlant, DelayPlant, StateSpace or StructuredPlant
        The block of the answer.
    answer : CriterionResult
        As for :func:`certified`.
    upper : Fraction or {"finite", "inf"}, optional
        Upper end of the class.

    Yields
    ------
    tuple of Fraction or str, dict
        The upper end of the class, that asked for or a smaller one, and the draft.
    """
    if isinstance(block, StructuredPlant):
        yield from theory_of(block).drafts(answer, upper)
        return
    if isinstance(block, StateSpace):
        from lure.analysis.certificates.by_matrices import matrix_drafts

        yield from matrix_drafts(block, answer)
        return
    system = system_of(block)
    for smaller in _uppers(block, answer, _default(answer) if upper is None else upper):
        nonlinearities = _nonlinearities(block, answer, smaller)
        for multiplier in multipliers(block, answer, smaller):
            proof = row_of(answer.criterion, block).proof_of(block, answer, smaller)
            if proof is not None:
                theorem = {"theorem": answer.criterion, "multiplier": multiplier, "proof": proof}
                yield smaller, {"verdict": "PROVED", "system": system, "laws": nonlinearities, **theorem}


def _nonlinearities(block: RationalPlant | DelayPlant, answer: CriterionResult, upper: Upper) -> dict[str, Any]:
    """The class of the answer with another upper end."""
    given = answer.nonlinearity_class
    nonlinearities = class_entry(given, unbounded=False, linear=row_of(answer.criterion, block).linear)
    top = upper if isinstance(upper, str) else text(upper)
    nonlinearities["sector"][1] = top
    if given.slope is not None and not _no_upper_slope(block, answer):
        nonlinearities["slope"][1] = top
    return nonlinearities


def _no_upper_slope(block: RationalPlant | DelayPlant, answer: CriterionResult) -> bool:
    """Whether the nonlinearities of the answer may be steeper than their sector: not where ``H(inf) < 0``."""
    direct = isinstance(block, RationalPlant) and block.feedthrough < 0
    return row_of(answer.criterion, block).free == "above" and not direct


def _default(answer: CriterionResult) -> Upper:
    upper = answer.nonlinearity_class.sector.upper
    return "finite" if upper == math.inf else Fraction(upper)


def _uppers(block: RationalPlant | DelayPlant, answer: CriterionResult, upper: Upper) -> Iterator[Upper]:
    """The end asked for, then smaller ones."""
    yield upper
    lower = answer.nonlinearity_class.sector.lower
    if lower == -math.inf:
        return
    low = Fraction(lower)
    if isinstance(upper, str):
        yield from (low + size * _unit(block) for size in LARGE)
        return
    doubles, value = list[Fraction](), math.nextafter(float(upper), -math.inf)
    for _ in range(DOUBLES_BELOW):
        doubles.append(Fraction(value))
        value = math.nextafter(value, -math.inf)
    steps = FARTHER_DOWN if _delayed(block, answer) else STEPS_DOWN
    yield from (smaller for smaller in doubles if low < smaller < upper)
    yield from (upper - (upper - low) * Fraction(step) for step in steps)


def _delayed(block: RationalPlant | DelayPlant, answer: CriterionResult) -> bool:
    kernels = answer.parameters.get("kernels")
    return isinstance(block, DelayPlant) or (isinstance(kernels, list) and any("delay" in kernel for kernel in kernels))


def _unit(block: RationalPlant | DelayPlant) -> Fraction:
    """A power of ten of about the size of ``1/|H|``."""
    omega = np.geomspace(1e-4, 3.0, 40)
    discrete = isinstance(block, RationalPlant) and block.dt is not None
    size = np.abs(block.transfer(np.exp(1j * omega) if discrete else 1j * omega))
    largest = float(np.max(size[np.isfinite(size)], initial=0.0))
    return Fraction(10) ** -round(math.log10(largest)) if largest > 0 else Fraction(1)

"""Questions about blocks given by matrices: answered by matrix inequalities where exact polynomials are too large."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import lru_cache, partial
from typing import TYPE_CHECKING, cast

from lure.analysis.deadline import checkpoint
from lure.analysis.verdict import Answer, Witness
from lure.errors import AssumptionError, InputError
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

if TYPE_CHECKING:
    from lure.analysis.certificates.checker import Proved, Refuted
    from lure.analysis.inequality.state_space import Criterion

LONG = 30_000  # binary digits of the characteristic polynomial from which on matrices are faster


def by_matrices(block: RationalPlant) -> StateSpace | None:
    """The matrices that a block was given by, where its polynomials are too long to work with; else None.

    Parameters
    ----------
    block : RationalPlant
        The block.  Its entries have to be doubles, so that both are the same system.
    """
    given = block.matrices
    if given is None or sum(c.numerator.bit_length() + c.denominator.bit_length() for c in block.denominator) < LONG:
        return None
    entries = [v for row in (*given.A, given.b, given.c, (given.d,)) for v in row]
    if any(Fraction(float(v)) != v for v in entries):
        return None
    return StateSpace(*given.doubles(), block.dt)


def state_space_answer(block: StateSpace, name: str, lower: Fraction) -> Answer:
    """What a criterion reaches in floating point, for :func:`.proved_answer` to certify.

    Parameters
    ----------
    block : StateSpace
        The block.
    name : str
        The criterion.
    lower : Fraction
        Lower end of the sectors.

    Raises
    ------
    AssumptionError
        It is none of the criteria for matrices, or does not apply.
    """
    from lure.analysis.inequality.state_space import state_space_largest

    if name not in ("circle", "popov"):
        raise AssumptionError(
            f"for a block of order {block.order} given by matrices there are circle and popov (in continuous time), "
            f"not {name}; give coefficients for the exact criteria"
        )
    return state_space_largest(block, cast("Criterion", name), lower=lower)


@lru_cache(maxsize=4)
def growing_gain(block: StateSpace, lower: Fraction) -> Witness | None:
    """The smallest linear gain for which the checker accepts that a motion grows; None where none is found.

    Parameters
    ----------
    block : StateSpace
        The block.
    lower : Fraction
        Least gain.

    Raises
    ------
    TimeoutError
        The time allowed is over.
    """
    from lure.analysis.certificates.sealing import Failure, guarded

    passing = (AssumptionError, InputError, OverflowError, ModuleNotFoundError, TimeoutError)
    found = guarded("linear gains", partial(_growing, block, lower), passing=passing)
    return None if isinstance(found, Failure) else found


def _growing(block: StateSpace, lower: Fraction) -> Witness | None:
    from lure.analysis.certificates.checker import Refuted
    from lure.analysis.certificates.sealing import guarded
    from lure.analysis.counterexamples.linear import growing_gains

    for witness in growing_gains(block, lower=lower):
        checkpoint()
        found = guarded(witness.kind, partial(_settled, block, witness), passing=(TimeoutError,))
        if isinstance(found, Refuted):
            return replace(witness, refutation=found)
    return None


def _settled(block: StateSpace, witness: Witness) -> Proved | Refuted:
    from lure.analysis.certificates.refutations import refutation_draft
    from lure.analysis.certificates.sealing import settled

    return settled(refutation_draft(block, witness, numbers="doubles, exactly"))

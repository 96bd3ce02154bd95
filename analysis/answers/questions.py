"""``max_sector`` and ``max_slope``: the largest class that is stable, and the smallest found that is not."""

from __future__ import annotations

import math

from analysis.answers.catalogue import BEST
from analysis.answers.largest import Largest
from analysis.answers.models import Asked, Block, Search, answers, critical, hurwitz, proviso, witnesses
from analysis.evidence import Bracket, Verdict
from lure.errors import InputError
from lure.exact import Exact, exact_number
from lure.frequency_data import FrequencyData
from lure.inputs import as_block
from lure.state_space import StateSpaceBlock
from lure.upwind import UpwindScheme
from lure.waves import RodBlock


class ContradictionError(RuntimeError):
    """A proof and a refutation of the same class: one of the two is wrong, and neither is reported."""


def max_sector(
    block: object,
    *,
    criterion: str = BEST,
    lower: Exact = 0,
    time_varying: bool = False,
    search: Search = "linear",
) -> Largest:
    r"""The largest ``k`` such that the loop is stable for every ``phi`` in the sector ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\varphi(\sigma), \qquad
        \mathrm{lower}\, \sigma^2 \le \sigma\, \varphi(\sigma) \le k\, \sigma^2.

    Where the loop with the gain ``lower`` has a pole at 0, only convergence to the set of equilibria is claimed
    (boundedness if ``phi`` depends on time); see ``meaning`` and ``proviso`` of the answer.

    Parameters
    ----------
    block : RationalBlock, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_block` takes, or an ``UpwindScheme`` or ``RodBlock``.
    criterion : str
        ``circle``, ``popov``, ``hurwitz`` (linear gains only), or ``best``: the farthest of all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the sector; for an unstable block take one for which the linear loop is stable.
    time_varying : bool
        Whether ``phi`` may depend on time.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or among all kinds known (seconds).

    Returns
    -------
    Largest
        With ``largest``, ``hurwitz``, ``verdict``, ``evidence``, ``theta``, ``refuted_at`` and more; ``bool()`` raises.

    Raises
    ------
    InputError
        The block or a number is no good, or there is no such criterion.
    AssumptionError
        The criterion does not apply to such a block or class.
    ContradictionError
        What is proved and what is refuted overlap: a bug.

    Examples
    --------
    >>> found = max_sector(([1], [1, 3, 2, 0]), criterion="popov")
    >>> print(found.verdict, round(found.largest.low, 6), round(found.theta, 6))
    PROVED 6.0 1.5
    """
    _checked(criterion, search, time_varying=time_varying)
    return _answer(
        Asked(
            block=_block(block),
            question="sector",
            criterion=criterion,
            lower=exact_number(lower, "lower"),
            odd=False,
            time_varying=time_varying,
            search=search,
        )
    )


def max_slope(
    block: object,
    *,
    odd: bool = False,
    criterion: str = BEST,
    lower: Exact = 0,
    search: Search = "full",
) -> Largest:
    r"""The largest ``k`` such that the loop is stable for every time-invariant ``phi`` with slope in ``[lower, k]``.

    .. math:: \sigma = H \mu, \qquad \mu = -\varphi(\sigma), \qquad \varphi(0) = 0, \\
        \mathrm{lower} \le \frac{\varphi(x) - \varphi(y)}{x - y} \le k \quad (x \ne y).

    Merely monotone and odd laws are kept apart: a bound for odd ones can be false for the others.

    Parameters
    ----------
    block : RationalBlock, control or scipy.signal system, (numerator, denominator), (A, B, C, D)
        The linear block, whatever :func:`lure.as_block` takes, or an ``UpwindScheme`` or ``RodBlock``.
    odd : bool
        Whether ``phi(-sigma) = -phi(sigma)`` is assumed.
    criterion : str
        One of :data:`analysis.answers.catalogue.CRITERIA`, or ``best``: the farthest of all that apply.
    lower : int, float, Fraction or Decimal
        Lower end of the slope.
    search : {"linear", "full"}
        Where to look for destabilising members: among linear gains, or for periodic orbits too (seconds).

    Returns
    -------
    Largest
        With ``largest``, ``refuted_at``, ``witness``, ``hurwitz``, ``verdict``, ``evidence``, ``multiplier`` and more.

    Raises
    ------
    InputError
        The block or a number is no good, or there is no such criterion.
    AssumptionError
        The criterion does not apply to such a block or class.
    ContradictionError
        What is proved and what is refuted overlap: a bug.

    Examples
    --------
    >>> found = max_slope(([1], [1, 2, 2, 1]), search="linear")
    >>> print(found.verdict, found.criterion, round(found.largest.low, 6), found.refuted_at)
    PROVED park 3.0 3.0
    """
    _checked(criterion, search, odd=odd)
    return _answer(
        Asked(
            block=_block(block),
            question="slope",
            criterion=criterion,
            lower=exact_number(lower, "lower"),
            odd=odd,
            time_varying=False,
            search=search,
        )
    )


def _checked(criterion: object, search: object, **flags: object) -> None:
    """The options, before anything is computed from them."""
    for name, value in flags.items():
        if not isinstance(value, bool):
            raise InputError(f"{name} is {value!r:.40}; give True or False")
    if search not in ("linear", "full"):
        raise InputError(f"search is {search!r:.40}; give 'linear' or 'full'")
    if not isinstance(criterion, str):
        raise InputError(f"criterion is {criterion!r:.40}; give its name as text")


def _block(block: object) -> Block:
    return block if isinstance(block, UpwindScheme | RodBlock) else as_block(block)


def _answer(asked: Asked) -> Largest:
    try:
        limit = hurwitz(asked)
        found = answers(asked)
        against = witnesses(asked, limit)
    except OverflowError:
        raise InputError(
            f"a gain or frequency of {asked.block} exceeds the range of doubles, 1e-308 to 1e308; rescale the units"
        ) from None
    best, witness = found[0], against[0] if against else None
    refuted_at = None if witness is None else witness.k
    if best.verdict is Verdict.PROVED and refuted_at is not None and best.largest.low >= refuted_at:
        raise ContradictionError(
            f"{best.criterion} proves [{asked.lower}, {best.largest.low!r}], and {witness} destabilises at "
            f"{refuted_at!r}; one of the two is wrong: please report the block {asked.block}"
        )
    ceiling = min(limit.high, math.inf if refuted_at is None else refuted_at)
    if asked.criterion != BEST or isinstance(asked.block, StateSpaceBlock | FrequencyData):
        ceiling = min(ceiling, best.largest.high)
    refuted = limit.high <= asked.lower and witness is not None and witness.refutation is not None
    return Largest(
        question=asked.question,
        odd=asked.odd,
        time_varying=asked.time_varying,
        lower=asked.lower,
        critical=critical(asked),
        proviso=proviso(asked, best.criterion),
        criterion=best.criterion,
        largest=Bracket(best.largest.low, max(best.largest.low, ceiling)),
        hurwitz=limit,
        verdict=Verdict.REFUTED if refuted else best.verdict,
        evidence=witness.evidence if refuted and witness is not None else best.evidence,
        theta=best.theta,
        multiplier=best.multiplier,
        parameters=best.parameters,
        refuted_at=refuted_at,
        witness=witness,
        answers=tuple(found),
        reason=best.reason,
        subject=f"the scheme with {asked.block.cells} cells" if isinstance(asked.block, UpwindScheme) else "",
    )

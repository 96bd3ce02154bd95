"""Switched gains in discrete time: a gain that jumps between the ends of the sector so that the loop grows."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import cast

import numpy as np
from flint import arb_mat
from numpy.typing import NDArray

from analysis.criteria.gain_ends import simplest_between
from analysis.deadline import checkpoint
from analysis.evidence import Evidence
from analysis.precision import working_precision
from analysis.refutation.linear import linear_witness, refutes_lower
from analysis.refutation.orbit import shifted_block
from analysis.refutation.periodic_discrete import proposals, searched_lower
from analysis.refutation.realisation import Realisation, balls, companion, doubles
from analysis.refutation.rounding import rounded_up, short
from analysis.witness import Witness
from lure.errors import InputError
from lure.rational import RationalBlock

Floats = NDArray[np.float64]

MAX_ORDER = 60  # above it the companion form in doubles is no guide
MAX_PERIOD = 10  # every pattern up to it is tried,
MAX_RUNS = 40  # and up to this one those of two runs
_LADDER = ((1e-9, 256), (1e-8, 1024), (1e-6, 1024), (1e-4, 4096))  # how far above k, and bits of the balls
_SQUARINGS = 48
_ROUNDS = 40
_GAIN = 1e-7  # relative: a smaller improvement is none


def switched_witness_discrete(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain ``phi(t, sigma) = k(t) sigma`` that repeats a pattern of ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -k(t) sigma`` the state over one period is multiplied by ``M``, the product of
    ``A - b c k(t)/(1 + k(t) D)``.  If ``M`` has an eigenvalue outside the unit disc some motion grows without bound.
    Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalBlock
        In discrete time.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    Witness or None
        CERTIFIED, ``k`` just above the smallest found, below the smallest destabilising linear gain; None if nothing
        was found, the loop is not stable at ``lower``, or the order is 0 or above 60.

    Raises
    ------
    InputError
        The block is in continuous time.

    Notes
    -----
    Candidates, in floating point: the patterns of periodic motions in the sector of period up to 24, all patterns of
    period up to 10, two runs up to 40, and what changes of single samples reach from them.  If all eigenvalues of
    ``M`` lay in the closed unit disc, ``|tr M^N| <= n`` for every ``N``; the opposite is shown in ball arithmetic for
    a power of two ``N`` and the exact gains.
    """
    if block.dt is None:
        raise InputError("switched_witness_discrete needs a block in discrete time; give dt")
    lower = Fraction(lower)
    linear = linear_witness(block, lower=lower)
    if not 0 < block.order <= MAX_ORDER or refutes_lower(linear):
        return None
    lower = searched_lower(block, lower, linear)
    k = np.inf if linear is None else linear.k
    pattern: tuple[int, ...] = ()
    for proposal in proposals(shifted_block(block, lower), ("sector",), k - float(lower), range(1, 25))[:1]:
        k = float(lower) + 1 / proposal.reach
        pattern = tuple(int(step > 1e-9) for step in proposal.mixture)
    system = companion(block)
    if np.isfinite(k):
        pattern, k = _improved(system, float(lower), k, pattern)
    return _certified(system, lower, k, pattern) if pattern else None


def _improved(system: Realisation, lower: float, k: float, pattern: tuple[int, ...]) -> tuple[tuple[int, ...], float]:
    """The pattern that grows most at ``k``, and the lowest ``k`` at which it does by bisection, again and again."""
    listed = _necklaces(MAX_PERIOD) + _two_runs(MAX_RUNS)
    for _ in range(_ROUNDS):
        high = lower + (k - lower) * (1 - _GAIN)
        radius = _radii(system, sorted({*listed, *_changed(pattern)}, key=len), lower, high)
        best = max(radius, key=lambda found: radius[found])
        if not radius[best] > 1 + 1e-9:
            break
        pattern, low = best, lower
        for _ in range(50):
            middle = 0.5 * (low + high)
            if _radii(system, [best], lower, middle)[best] > 1:
                high = middle
            else:
                low = middle
        k = high
    return pattern, k


def _necklaces(longest: int) -> list[tuple[int, ...]]:
    """Every pattern of zeros and ones, neither constant, up to shifts and repetition."""
    found = []
    for p in range(2, longest + 1):
        checkpoint()
        for word in itertools.product((0, 1), repeat=p):
            if all(word < word[i:] + word[:i] for i in range(1, p)):
                found.append(word)
    return found


def _two_runs(longest: int) -> list[tuple[int, ...]]:
    """A run of zeros and a run of ones."""
    return [(0,) * zeros + (1,) * (p - zeros) for p in range(MAX_PERIOD + 1, longest + 1) for zeros in range(1, p)]


def _changed(pattern: tuple[int, ...]) -> list[tuple[int, ...]]:
    """The patterns one sample flipped, left out or repeated away."""
    parts = [(pattern[:i], pattern[i], pattern[i + 1 :]) for i in range(len(pattern))]
    return [
        head + middle + tail for head, g, tail in parts for middle in ((1 - g,), (), (g, g)) if head or middle or tail
    ]


def _radii(
    system: Realisation, patterns: Sequence[tuple[int, ...]], lower: float, k: float
) -> dict[tuple[int, ...], float]:
    """Spectral radius over one period, to the power of one over the period."""
    step = np.array([doubles(system.closed(Fraction(gain))) for gain in (lower, k)])
    result: dict[tuple[int, ...], float] = {}
    for p, group in itertools.groupby(patterns, key=len):
        words = list(group)
        product = step[[word[0] for word in words]]
        for t in range(1, p):
            product = step[[word[t] for word in words]] @ product
        radius = np.abs(np.linalg.eigvals(product)).max(axis=1) ** (1 / p)
        result.update(zip(words, radius.tolist(), strict=True))
    return result


def _certified(system: Realisation, lower: Fraction, k: float, pattern: tuple[int, ...]) -> Witness | None:
    for excess, bits in _LADDER:
        width = Fraction(k) - lower
        upper = simplest_between(lower + width * (1 + Fraction(excess) / 2), lower + width * (1 + Fraction(excess)))
        gains = [upper if g else lower for g in pattern]
        if not _grows(system, gains, bits):
            continue
        text = _runs(["k" if g else short(lower) for g in pattern])
        return Witness(
            kind="switched gain",
            k=rounded_up(upper),
            evidence=Evidence.CERTIFIED,
            slope_restricted=True,
            odd=True,
            time_varying=True,
            description=f"phi(t, sigma) = k(t) sigma, k(t) repeating {text}, k = {short(upper)}: motions grow for ever",
            data={"k": str(upper), "lower": str(lower), "period": len(gains), "gains": [str(g) for g in gains]},
        )
    return None


def _runs(words: Sequence[str]) -> str:
    """The words, three and more alike together: ``0 k k``, ``5 times 0, 3 times k``."""
    runs = [(word, len(list(same))) for word, same in itertools.groupby(words)]
    if max(count for _, count in runs) < 3:
        return " ".join(words)
    return ", ".join(word if count == 1 else f"{count} times {word}" for word, count in runs)


def _grows(system: Realisation, gains: Sequence[Fraction], bits: int) -> bool:
    """Whether the product over one period is proved to have an eigenvalue outside the unit disc."""
    if any(1 + gain * system.d == 0 for gain in gains):
        return False
    with working_precision(bits):
        product = arb_mat([[int(i == j) for j in range(system.order)] for i in range(system.order)])
        for gain in gains:
            product = balls(system.closed(gain)) * product
        for _ in range(_SQUARINGS):
            if abs(product.trace()) > system.order:
                return True
            product = product * product
    return False


def verify_switched_discrete(block: RationalBlock, data: Mapping[str, object]) -> bool:
    """Whether the gains of a record lie in its ``[lower, k]`` and make the loop grow, proved in ball arithmetic.

    Parameters
    ----------
    block : RationalBlock
        In discrete time.
    data : Mapping
        As in ``Witness.data`` of kind ``switched gain`` in discrete time: ``k``, ``lower``, ``gains`` as text ``p/q``.

    Returns
    -------
    bool
        False also if it could not be decided, or an entry is missing or is not a number.
    """
    try:
        k, lower = Fraction(cast("str", data["k"])), Fraction(cast("str", data["lower"]))
        gains = [Fraction(gain) for gain in cast("list[str]", data["gains"])]
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return False
    if block.dt is None or not gains or not all(lower <= gain <= k for gain in gains):
        return False
    return any(_grows(companion(block), gains, bits) for bits in (256, 1024, 4096))

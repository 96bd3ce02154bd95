"""Switched gains in discrete time: a gain that jumps between the ends of the sector so that the loop grows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType
from typing import cast

from flint import arb_mat

from lure.analysis.counterexamples.linear import Realisation, balls, companion, doubles, linear_witness, refutes_lower
from lure.analysis.counterexamples.orbit import shifted_block
from lure.analysis.counterexamples.periodic_discrete import SECTOR_PERIODS, proposals, searched_lower
from lure.analysis.counterexamples.switching_search import Pattern, SwitchingSearch
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.gains import hurwitz_limit, simplest_between
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import rounded_up, short
from lure.analysis.numerics.polynomial import positive_root_count, real_roots, to_fmpq
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Evidence, Witness
from lure.arrays import np
from lure.errors import InputError
from lure.plants.rational import RationalPlant

# Switched gains that make a loop grow, proved in ball arithmetic.

MAX_ORDER = 24  # above it the companion form of doubles is no guide
SQUARINGS = 60
BITS = 320


def switched_witness(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain that jumps periodically between ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -phi``, ``phi(t, sigma) = k(t) sigma``, the state over one period is multiplied by
    ``M = ... exp(A_k t_2) exp(A_lower t_1)``, ``A_k = A - b c k/(1 + k d)``.  If ``M`` has an eigenvalue outside the
    unit disc, some motion grows without bound, and no criterion for time-varying ``phi`` in the sector ``[lower, k]``
    (the circle criterion's class) can hold.  Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalPlant
        In continuous time.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    Witness or None
        ``k`` is the smallest found, a rational just above the value where the growth of the best switching vanishes; it
        is not proved to be the smallest.  None: discrete time, order 0 or above 24, a loop that is already unstable at
        ``lower``, a block for which ``1/(k - lower) + Re H`` is positive for every ``k``, or nothing found below the
        first gain that is itself unstable.

    Notes
    -----
    Times and gains are looked for in floating point: the best of a grid of two times, then the switching function
    (derivative of the spectral radius by the gain at each instant) decides where to add switches, then the times are
    refined and ``k`` is lowered.  The result is CERTIFIED: if all eigenvalues of ``M`` lay in the closed unit disc,
    ``|tr M^N| <= n`` for every ``N``; the opposite is shown in ball arithmetic for a power of two ``N``, for the exact
    rational times and gain.
    """
    if block.dt is not None or not 0 < block.order <= MAX_ORDER:
        return None
    plant = TransferPolynomials.of(block)
    if plant.shifted(lower).poles.right > 0:
        return None
    circle, omega = circle_reach(plant, lower)
    search = SwitchingSearch(companion(block), lower, circle, omega, hurwitz_limit(block, lower).high)
    with np.errstate(all="ignore"):  # products overflow where the loop grows fast; such values are never chosen
        found = search.run()
    return None if found is None else _certified(search.system, lower, found)


def circle_reach(plant: TransferPolynomials, lower: Fraction) -> tuple[float, float]:
    """Where the circle criterion stops, in doubles, and at which frequency: nothing below it is worth a search."""
    response = plant.shifted(lower).response()
    slope = response.U.derivative() * response.D - response.U * response.D.derivative()
    if positive_root_count(response.D) > 0:
        return float(lower), math.sqrt(float(next(x for x in real_roots(response.D) if x > 0)))
    stationary = [float(x) for x in real_roots(slope) if x > 0] if slope.degree() > 0 else []
    values = [
        (float(response.U(at) / response.D(at)), float(at))
        for at in (to_fmpq(x) for x in (0.0, *stationary))
        if response.D(at) != 0
    ]
    least, x = min(values, default=(0.0, 0.0))
    return (float(lower) - 1 / least if least < 0 else math.inf), math.sqrt(x)


def growing(system: Realisation, gains: Sequence[Fraction], times: Sequence[Fraction]) -> bool:
    r"""Whether a loop with these gains for these times, over and over, is proved to have motions that grow.

    Parameters
    ----------
    system : Realisation
        The block.
    gains, times : sequence of Fraction
        ``mu = -gain sigma`` for each time [s] in turn.

    Returns
    -------
    bool
        True is a proof that the matrix of one period has an eigenvalue outside the unit disc; False says nothing.
    """
    with working_precision(BITS):
        product = balls([[Fraction(int(i == j)) for j in range(system.order)] for i in range(system.order)])
        for gain, time in zip(gains, times, strict=True):
            product = (balls(system.closed(gain)) * ball(time)).exp() * product
        for _ in range(SQUARINGS):
            if abs(product.trace()) > system.order:
                return True
            product = product * product
    return False


def _certified(system: Realisation, lower: Fraction, found: Pattern) -> Witness | None:
    times = [_short(t, 40) for t in found.times]
    for excess in (1e-9, 1e-8, 1e-7, 1e-6, 1e-5):
        k = _short(float(lower) + (found.k - float(lower)) * (1 + excess), 45)
        gains = [lower, k] * (len(times) // 2)
        if growing(system, gains, times):
            break
    else:
        return None
    period = float(sum(times))
    with working_precision(BITS):
        bound = outward(ball(k), ball(k)).high
    ends = f"{float(lower):g} and {float(k):.9g}"
    text = f"phi(t, sigma) = k(t) sigma, k(t) switching between {ends} with period {period:.6g} s"
    return Witness(
        kind="switched gain",
        k=bound,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        time_varying=True,
        description=f"{text}: a motion grows without bound",
        data=MappingProxyType(
            {"lower": str(lower), "upper": str(k), "gains": [str(g) for g in gains], "times": [str(t) for t in times]}
        ),
    )


def _short(value: float, bits: int) -> Fraction:
    """A double cut to so many bits."""
    mantissa, exponent = math.frexp(value)
    return Fraction(round(math.ldexp(mantissa, bits))) * Fraction(2) ** (exponent - bits)


SWITCHED_DISCRETE_MAX_ORDER = 60  # above it the companion form in doubles is no guide
MAX_PERIOD = 10  # every pattern up to it is tried,
MAX_RUNS = 40  # and up to this one those of two runs
_LADDER = ((1e-9, 256), (1e-8, 1024), (1e-6, 1024), (1e-4, 4096))  # how far above k, and bits of the balls
_SQUARINGS = 48
_ROUNDS = 40
_GAIN = 1e-7  # relative: a smaller improvement is none


def switched_witness_discrete(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain ``phi(t, sigma) = k(t) sigma`` that repeats a pattern of ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -k(t) sigma`` the state over one period is multiplied by ``M``, the product of
    ``A - b c k(t)/(1 + k(t) D)``.  If ``M`` has an eigenvalue outside the unit disc some motion grows without bound.
    Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalPlant
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
    if not 0 < block.order <= SWITCHED_DISCRETE_MAX_ORDER or refutes_lower(linear):
        return None
    lower = searched_lower(block, lower, linear)
    k = np.inf if linear is None else linear.k
    pattern: tuple[int, ...] = ()
    for proposal in proposals(shifted_block(block, lower), ("sector",), k - float(lower), tuple(SECTOR_PERIODS))[:1]:
        k = float(lower) + 1 / proposal.reach
        pattern = tuple(int(step > 1e-9) for step in proposal.mixture)
    system = companion(block)
    if np.isfinite(k):
        pattern, k = _improved(system, float(lower), k, pattern)
    return _switched_discrete_certified(system, lower, k, pattern) if pattern else None


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


def _switched_discrete_certified(
    system: Realisation, lower: Fraction, k: float, pattern: tuple[int, ...]
) -> Witness | None:
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


def verify_switched_discrete(block: RationalPlant, data: Mapping[str, object]) -> bool:
    """Whether the gains of a record lie in its ``[lower, k]`` and make the loop grow, proved in ball arithmetic.

    Parameters
    ----------
    block : RationalPlant
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

"""Switched gains that make a loop grow, proved in ball arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from types import MappingProxyType

import numpy as np

from analysis.criteria.hurwitz import hurwitz_limit
from analysis.evidence import Evidence
from analysis.plant import Plant
from analysis.polynomial import positive_root_count, real_roots, to_fmpq
from analysis.precision import ball, outward, working_precision
from analysis.refutation.realisation import Realisation, balls, companion
from analysis.refutation.switching_search import Pattern, SwitchingSearch
from analysis.witness import Witness
from lure.rational import RationalBlock

MAX_ORDER = 24  # above it the companion form of doubles is no guide
SQUARINGS = 60
BITS = 320


def switched_witness(block: RationalBlock, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain that jumps periodically between ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -phi``, ``phi(t, sigma) = k(t) sigma``, the state over one period is multiplied by
    ``M = ... exp(A_k t_2) exp(A_lower t_1)``, ``A_k = A - b c k/(1 + k d)``.  If ``M`` has an eigenvalue outside the
    unit disc, some motion grows without bound, and no criterion for time-varying ``phi`` in the sector ``[lower, k]``
    (the circle criterion's class) can hold.  Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalBlock
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
    plant = Plant.of(block)
    if plant.shifted(lower).poles.right > 0:
        return None
    circle, omega = circle_reach(plant, lower)
    search = SwitchingSearch(companion(block), lower, circle, omega, hurwitz_limit(block, lower).high)
    with np.errstate(all="ignore"):  # products overflow where the loop grows fast; such values are never chosen
        found = search.run()
    return None if found is None else _certified(search.system, lower, found)


def circle_reach(plant: Plant, lower: Fraction) -> tuple[float, float]:
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

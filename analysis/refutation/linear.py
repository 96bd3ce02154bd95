"""Linear gains that destabilise: members of every class of laws."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import cast

from analysis.criteria.gain_ends import GainEnd, gain_ends, simplest_between
from analysis.criteria.hurwitz import gain_intervals, is_stable_gain
from analysis.evidence import Evidence
from analysis.refutation.rounding import rounded_up, short
from analysis.witness import Witness
from lure.rational import RationalBlock

_ABOVE = Fraction(1, 10**12)  # relative distance of a rational gain from an irrational limit


def linear_witness(
    block: RationalBlock, *, lower: Fraction = Fraction(0), bound: Fraction | float = math.inf
) -> Witness | None:
    r"""The smallest gain of ``[lower, bound]`` for which the loop ``mu = -k sigma`` is not asymptotically stable.

    A linear law is odd, time-invariant and of slope in every ``[lower, k']``, ``k' >= k``: it refutes every class.
    Where the loop is only marginal at ``lower`` but stable just above it, the class meant is that of ``(lower, k]``.

    Parameters
    ----------
    block : RationalBlock
        The block, in continuous or discrete time.
    lower : Fraction
        Least gain.
    bound : Fraction or float
        Largest gain of interest.

    Returns
    -------
    Witness or None
        CERTIFIED by exact root counts; None if every gain of the interval is stable.  At a rational limit the gain is
        the limit itself, with roots on the axis; at an irrational one a rational number just above it.

    Notes
    -----
    ``data`` holds ``gain`` and ``lower`` as text ``p/q``; where the loop is stable again just above an irrational
    limit, ``gain_low`` and ``gain_high`` instead: the one gain between them with roots on the axis.
    """
    lower = Fraction(lower)
    for interval in gain_intervals(block):
        starts, ends = interval.lower, interval.upper
        begins = starts.exact == lower or starts.high is None or starts.high <= lower
        if begins and (ends.low is None or lower < ends.low) and lower != ends.exact:
            found = None if ends.low is None else _at(block, lower, ends)
            return None if found is None or found.k > bound else found
    return _gain(block, lower, lower) if lower <= bound else None


def _at(block: RationalBlock, lower: Fraction, end: GainEnd) -> Witness:
    """The witness at the end of the stable gains from ``lower``."""
    if end.exact is not None:
        return _gain(block, lower, end.exact)
    limit = cast("Fraction", end.high)
    above = [other.low for other in gain_ends(block, (lower,)) or () if other.low is not None and other.low > limit]
    far = limit + abs(limit) * _ABOVE
    gain = simplest_between((limit + far) / 2, far)
    if (not above or gain < above[0]) and not is_stable_gain(block, gain):
        return _gain(block, lower, gain)
    k = end.value.high
    text = f"phi = k sigma with k = {k:.10g}: roots on the axis, a periodic motion"
    return _witness(k, text, {"lower": str(lower), "gain_low": str(end.low), "gain_high": str(end.high)})


def _gain(block: RationalBlock, lower: Fraction, gain: Fraction) -> Witness:
    solvable = 1 + gain * block.feedthrough != 0
    text = "the loop is not asymptotically stable" if solvable else "the loop has no solution, 1 + k H(inf) = 0"
    return _witness(rounded_up(gain), f"phi = {short(gain)} sigma: {text}", {"lower": str(lower), "gain": str(gain)})


def _witness(k: float, text: str, data: Mapping[str, object]) -> Witness:
    return Witness(
        kind="linear gain",
        k=k,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=text,
        data=data,
    )

"""Linear gains that destabilise: members of every class of laws."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import cast

from analysis.criteria.gain_ends import GainEnd, gain_ends, simplest_between
from analysis.criteria.hurwitz import is_stable_gain
from analysis.evidence import Evidence
from analysis.plant import Plant
from analysis.refutation.rounding import rounded_up, short
from analysis.witness import Witness
from lure.rational import RationalBlock

_ABOVE = Fraction(1, 10**12)  # relative distance of a rational gain from an irrational limit


def linear_witness(
    block: RationalBlock, *, lower: Fraction = Fraction(0), bound: Fraction | float = math.inf
) -> Witness | None:
    r"""The smallest gain of ``[lower, bound]`` for which the loop ``mu = -k sigma`` is not asymptotically stable.

    A linear law is odd, time-invariant and of slope in every ``[lower, k']``, ``k' >= k``: it refutes every class.
    In the critical case at ``lower`` (one simple pole at 0 or ``z = 1``, the others stable) the class meant is that of
    ``(lower, k]``.  A multiple pole at 0 or any other pole on the axis is no such case: there ``phi = lower sigma``, a
    member of every class, has solutions that grow or swing for ever.

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
    ends = gain_ends(block, (lower,)) or ()
    above = [end for end in ends if end.low is not None and end.low > lower]
    case, near = Plant.of(block).shifted(lower).case, lower
    if case == "critical":
        near = (lower + above[0].low) / 2 if above and above[0].low is not None else lower + 1
    if case == "unstable" or not is_stable_gain(block, near):
        found = _gain(block, lower, lower)
    elif above:
        found = _at(block, lower, above[0])
    else:
        return None
    return found if found.k <= bound else None


def refutes_lower(linear: Witness | None) -> bool:
    """Whether the gain of a :func:`linear_witness` is the lower bound itself: no larger class can be stable."""
    return linear is not None and "gain" in linear.data and linear.data["gain"] == linear.data.get("lower")


def _at(block: RationalBlock, lower: Fraction, end: GainEnd) -> Witness:
    """The witness at a gain with roots on the axis, the loop being stable between ``lower`` and it."""
    if end.exact is not None:
        return _gain(block, lower, end.exact)
    limit = cast("Fraction", end.high)
    far = limit + abs(limit) * _ABOVE
    gain = simplest_between((limit + far) / 2, far)
    if not is_stable_gain(block, gain):
        return _gain(block, lower, gain)
    k = end.value.high
    text = f"phi = k sigma with k = {k:.10g}: roots on the axis, a periodic motion"
    return _witness(k, text, {"lower": str(lower), "gain_low": str(end.low), "gain_high": str(end.high)})


def _gain(block: RationalBlock, lower: Fraction, gain: Fraction) -> Witness:
    solvable = 1 + gain * block.feedthrough != 0
    text = "the loop is not asymptotically stable" if solvable else "the loop has no solution, 1 + k H(inf) = 0"
    law = f"phi = {short(gain)} sigma" if gain else "phi = 0"
    return _witness(rounded_up(gain), f"{law}: {text}", {"lower": str(lower), "gain": str(gain)})


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

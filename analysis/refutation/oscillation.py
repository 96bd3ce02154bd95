"""Laws of restricted slope with a self-oscillation though every linear gain is stable, in continuous time."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from analysis.criteria.hurwitz import hurwitz_limit
from analysis.evidence import Evidence
from analysis.plant import Plant
from analysis.precision import ball, outward, working_precision
from analysis.refutation.following import settled
from analysis.refutation.orbit_search import OrbitSearch, Oscillation
from analysis.refutation.piecewise import PiecewiseLoop, saturation
from analysis.refutation.realisation import Realisation, companion
from analysis.refutation.simulated import followed
from analysis.refutation.switched import circle_reach
from analysis.refutation.validated import Itinerary, proved, refined
from analysis.witness import Witness
from lure.errors import InputError
from lure.laws.graph import Graph
from lure.rational import RationalBlock

MAX_ORDER = 16


def oscillation_witness(
    block: RationalBlock, *, odd: bool, lower: Fraction = Fraction(0), k: Fraction | None = None
) -> Witness | None:
    r"""A piecewise-linear ``phi`` with slopes in ``[lower, k]`` whose loop has a periodic motion.

    The loop is ``sigma = H mu``, ``mu = -phi(sigma)``.  The motion's existence refutes global asymptotic stability for
    the class of all ``phi`` with slope in ``[lower, k]``; whether the motion attracts is not asked.

    Parameters
    ----------
    block : RationalBlock
        In continuous time.
    odd : bool
        Whether only odd laws are wanted.  The laws tried are odd either way: they belong to both classes.
    lower : Fraction
        Least slope.
    k : Fraction or None
        Largest slope allowed; None for the smallest that is found.

    Returns
    -------
    Witness or None
        CERTIFIED where Krawczyk's test proves the orbit, else COMPUTED.  ``k`` is the smallest found, not proved to be
        the smallest.  None: discrete time, order 0 or above 16, a loop that is unstable at ``lower`` or just above, or
        nothing found with ``k`` below the first unstable linear gain (a linear gain is the better witness there).

    Notes
    -----
    Relay loops, the limit of steep saturations, have orbits that follow from a few times by Newton's method.  They are
    followed from there while the slope of the saturation falls, down to the fold where they vanish.  Orbits of
    saturations and dead zones with smaller slopes come from harmonic balance with four odd harmonics and are followed
    likewise.  Feedthrough ``d`` is first absorbed: with ``y = sigma + d phi`` the block is ``H - d`` and slopes turn
    into ``s/(1 + d s)``.
    """
    witness = _smallest(block, lower)
    fits = witness is not None and (k is None or Fraction(witness.k) <= k) and (witness.odd or not odd)
    return witness if fits else None


@lru_cache(maxsize=64)
def _smallest(block: RationalBlock, lower: Fraction) -> Witness | None:
    """The witness with the smallest ``k`` found."""
    if block.dt is not None or not 0 < block.order <= MAX_ORDER:
        return None
    plant = Plant.of(block)
    if plant.shifted(lower).poles.right > 0:
        return None
    start, stable = circle_reach(plant, lower)[0], hurwitz_limit(block, lower)
    if start == math.inf or stable.low <= lower:  # no gain above the lower one is stable
        return None
    system, d, limit = companion(block), block.feedthrough, stable.high
    search = OrbitSearch(
        system=replace(system, d=Fraction(0)),
        lower=lower / (1 + d * lower),
        limit=absorbed(limit, float(d)),
        start=absorbed(start, float(d)),
        numerator=np.array([float(c) for c in reversed(system.c)]),
        denominator=np.array([float(c) for c in block.denominator]),
    )
    with np.errstate(all="ignore"):  # Newton's method may run off; what is not finite is dropped
        candidates = search.candidates()[:4]
    for found in candidates:
        witness = _witness(system, found)
        if witness is not None and witness.k < limit:
            return witness
    return None


def absorbed(slope: float, d: float) -> float:
    """``s/(1 + d s)``, infinity included."""
    if slope == math.inf:
        return 1 / d if d > 0 else math.inf
    return slope / (1 + d * slope) if 1 + d * slope > 0 else math.inf


def restored(law: Graph, d: Fraction) -> Graph:
    """``phi(sigma)`` for the law ``psi(y)`` with ``y = sigma + d phi``, ``phi = psi``."""
    points = [(y - d * law.exact(y), law.exact(y)) for y in law.kinks]
    left, right = (s / (1 - d * s) for s in (law.slopes[0], law.slopes[-1]))
    return Graph.through(points, left, right)


def _witness(system: Realisation, found: Oscillation) -> Witness | None:
    """The witness a little above the fold, proved if possible."""
    weaker = None
    for excess in (1e-5, 1e-4, 4e-4, 2e-3, 1e-2):
        parameter = Fraction(float(f"{found.parameter * (1 + excess):.12g}"))
        law = restored(saturation(*found.slopes(parameter)), system.d)
        try:
            loop = PiecewiseLoop.of(system, law)
        except InputError:
            return weaker
        near = settled(loop, found.orbit)
        orbit = None if near is None else refined(loop, near.exact())
        if orbit is None:
            continue
        if proved(loop, orbit):
            return orbit_witness(loop, orbit, Evidence.CERTIFIED)
        weaker = weaker if weaker is not None else orbit_witness(loop, orbit, Evidence.COMPUTED)
    return weaker


def orbit_witness(loop: PiecewiseLoop, orbit: Itinerary, evidence: Evidence) -> Witness:
    """The witness for an orbit of a piecewise-linear loop.

    Parameters
    ----------
    loop : PiecewiseLoop
        The loop.
    orbit : Itinerary
        Its orbit.
    evidence : Evidence
        CERTIFIED if ``validated.proved`` holds.
    """
    law = loop.law
    with working_precision(128):
        top = ball(max(law.slopes))
        k = outward(top, top).high
    points = ", ".join(f"({float(x):.6g}, {float(law.exact(x)):.6g})" for x in law.kinks)
    left, right = float(law.slopes[0]), float(law.slopes[-1])
    state = [float(v) for v in orbit.state]
    visited = followed(loop, np.array(state), np.linspace(0.0, orbit.period, 401)).sigma
    return Witness(
        kind="periodic orbit",
        k=k,
        evidence=evidence,
        slope_restricted=True,
        odd=law.odd,
        description=f"phi piecewise linear through {points}, slope {left:.6g} to the left, {right:.6g} to the right: "
        f"a periodic motion with period {orbit.period:.7g} s",
        data=MappingProxyType(
            {
                "points": [[str(x), str(law.exact(x))] for x in law.kinks],
                "left_slope": str(law.slopes[0]),
                "right_slope": str(law.slopes[-1]),
                "period": orbit.period,
                "pieces": list(orbit.pieces),
                "durations": [float(t) for t in orbit.durations],
                "state": state,
                "half": orbit.half,
                "visited": [float(np.nanmin(visited)), float(np.nanmax(visited))],
            }
        ),
    )

"""All ways to refute a class for one plant, smallest class first; solutions claimed to disprove it, checked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from types import MappingProxyType

from lure.analysis.counterexamples.linear import linear_witness, realisation, refutes_lower
from lure.analysis.counterexamples.oscillation import orbit_witness
from lure.analysis.counterexamples.periodic_discrete import periodic_witness_discrete, sector_witness_discrete
from lure.analysis.counterexamples.piecewise import Flow, Itinerary, Passage, PiecewiseLoop, proved, refined, returns
from lure.analysis.counterexamples.simulated import Characteristic, Plant, graph_of, simulate_loop
from lure.analysis.counterexamples.switched import switched_witness_discrete
from lure.analysis.verdict import Evidence, Witness
from lure.arrays import ArrayLike, np
from lure.plants.rational import RationalPlant

# Solutions claimed to disprove stability, checked: a nonlinearity, a first state, a period.

PERIODS = 200
SMOOTH_PERIODS = 40
RETURN = 1e-6


def accept_orbit_continuous(block: Plant, nonlinearity: Characteristic, x0: ArrayLike, period: float) -> Witness | None:
    r"""The witness for a self-oscillation of ``sigma = H mu``, ``mu = -phi(sigma)`` claimed to start near ``x0``.

    Parameters
    ----------
    block : RationalPlant or (A, b, c)
        In continuous time; matrices exact or doubles, without feedthrough, ``x' = A x + b mu``, ``sigma = c x``.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``.
    x0 : array_like
        (n,) state on the orbit, or from which the solution comes close to it within 200 periods; in the companion form
        of a ``RationalPlant``.
    period : float
        Approximate period [s].

    Returns
    -------
    Witness or None
        For a piecewise-linear nonlinearity an orbit near the solution is refined by Newton's method and proved by
        Krawczyk's test: CERTIFIED.  Where that fails, and for any other nonlinearity, ``simulated orbit``, OBSERVED:
        after 40 periods the solution returns to its state within 1e-6 of its size, and has not shrunk.  None if it does
        neither: nothing follows.
    """
    graph = graph_of(nonlinearity)
    if graph is not None and not graph.is_line:
        loop = PiecewiseLoop.of(realisation(block), graph)
        orbit = _piecewise_orbit(loop, x0, period)
        if orbit is not None:
            return orbit_witness(loop, orbit, Evidence.CERTIFIED)
    return _observed(block, nonlinearity, x0, period)


def accept_escape(block: Plant, nonlinearity: Characteristic, x0: ArrayLike, until: float) -> Witness | None:
    """The witness for a solution of ``sigma = H mu``, ``mu = -phi(sigma)`` that seems to grow without bound: OBSERVED.

    Parameters
    ----------
    block : RationalPlant or (A, b, c)
        The linear part.
    nonlinearity : Graph, nonlinearity of the library or callable
        ``phi``.
    x0 : array_like
        (n,) first state.
    until : float
        Length of the run [s].

    Returns
    -------
    Witness or None
        If ``|sigma|`` ends above ten times its first value and grows over each of the last four quarters; else None.
    """
    motion = simulate_loop(block, nonlinearity, x0, until)
    quarters = [float(np.abs(part).max()) for part in np.array_split(motion.sigma, 5)]
    grows = all(b > 1.05 * a for a, b in pairwise(quarters))
    if not (grows and quarters[-1] > 10 * abs(float(motion.sigma[0])) and math.isfinite(quarters[-1])):
        return None
    text = f"|sigma| grows from {abs(float(motion.sigma[0])):.4g} to {quarters[-1]:.4g} within {until:g} s"
    return _simulated(
        nonlinearity, text, {"state": [float(v) for v in np.ravel(x0)], "until": until, "note": motion.note}
    )


def _piecewise_orbit(loop: PiecewiseLoop, x0: ArrayLike, period: float) -> Itinerary | None:
    """An orbit near the solution from ``x0``, proved, or None."""
    flow = Flow(loop)
    passages = flow.passages(x0, 2.5 * period)
    first = 1 if len(passages) > 1 else 0
    laps = [(j, passages[j].start - passages[first].start) for j in range(first + 1, len(passages))]
    guesses = [
        (first, j) for j, lap in laps if passages[j].piece == passages[first].piece and abs(lap - period) < 0.1 * period
    ]
    found = _proved(loop, passages, guesses)
    if found is not None:
        return found
    passages = flow.passages(x0, PERIODS * period)
    again = returns(passages)
    return None if again is None else _proved(loop, passages, [again])


def _proved(loop: PiecewiseLoop, passages: list[Passage], spans: list[tuple[int, int]]) -> Itinerary | None:
    """The first orbit proved among these stretches of the solution."""
    for i, j in spans:
        stretch = passages[i:j]
        whole = Itinerary(
            pieces=tuple(p.piece for p in stretch),
            durations=tuple(Fraction(p.duration) for p in stretch),
            state=tuple(Fraction(float(v)) for v in stretch[0].state),
            half=False,
        )
        orbit = refined(loop, whole)
        if orbit is not None and proved(loop, orbit):
            return orbit
    return None


def _observed(block: Plant, nonlinearity: Characteristic, x0: ArrayLike, period: float) -> Witness | None:
    """The orbit as a simulation shows it, or None."""
    long = simulate_loop(block, nonlinearity, x0, SMOOTH_PERIODS * period, samples=40 * SMOOTH_PERIODS)
    quarter = len(long.sigma) // 4
    early, late = (float(np.abs(part).max()) for part in (long.sigma[quarter : 2 * quarter], long.sigma[-quarter:]))
    if not (np.isfinite(long.states).all() and late > 0.99 * early > 0):
        return None
    start = long.states[-1]
    lap = simulate_loop(block, nonlinearity, start, 1.2 * period, samples=4001)
    misses = np.where(lap.t < 0.8 * period, math.inf, np.abs(lap.states - start).max(axis=1))
    found = float(lap.t[int(misses.argmin())])
    for _ in range(4):  # the time at which the solution is nearest to its first state, by Newton's method
        lap = simulate_loop(block, nonlinearity, start, found, samples=4001)
        speed = (lap.states[-1] - lap.states[-2]) / (lap.t[-1] - lap.t[-2])
        found -= float((lap.states[-1] - start) @ speed / (speed @ speed))
    miss = float(np.abs(lap.states[-1] - start).max() / np.abs(start).max())
    if not miss < RETURN:
        return None
    text = f"the solution returns to its state after {found:.7g} s within {miss:.1g} of its size"
    return _simulated(
        nonlinearity, text, {"state": [float(v) for v in start], "period": found, "miss": miss, "note": long.note}
    )


def _simulated(nonlinearity: Characteristic, text: str, data: Mapping[str, object]) -> Witness:
    """An observed witness for the smallest class known to hold the nonlinearity."""
    slopes, sector = getattr(nonlinearity, "slope_bounds", None), getattr(nonlinearity, "sector", None)
    bounds = slopes if slopes is not None else sector
    upper = math.inf if bounds is None else float(bounds.upper)
    return Witness(
        kind="simulated orbit",
        k=upper,
        evidence=Evidence.OBSERVED,
        slope_restricted=slopes is not None and math.isfinite(upper),
        odd=bool(getattr(nonlinearity, "odd", False)),
        description=f"phi = {nonlinearity}: {text}",
        data=MappingProxyType(dict(data)),
    )


def refute(
    block: RationalPlant, *, slope: bool, odd: bool, time_varying: bool, lower: Fraction = Fraction(0)
) -> tuple[Witness, ...]:
    r"""Destabilising members ``phi`` of a class, ``mu = -phi(sigma)``, ``sigma = H mu``, in ascending order of ``k``.

    Each refutes the class ``[lower, k']`` for every ``k' >= k``.  Nothing follows from what is not found.

    Parameters
    ----------
    block : RationalPlant
        The block, in continuous or discrete time.
    slope : bool
        Whether the nonlinearities have slope in ``[lower, k]``; else they lie in that sector only.
    odd : bool
        Whether the nonlinearities are odd.
    time_varying : bool
        Whether the nonlinearities may vary with time.
    lower : Fraction
        Lower bound of slope or sector.  Where the loop is only marginal there, the class is that of ``(lower, k]``.

    Returns
    -------
    tuple of Witness
        At most one of each kind; a nonlinear one only if its ``k`` is below that of the linear gain.  In continuous
        time it is looked for too where the gain ``lower`` itself refutes every class, with poles on the axis.

    Examples
    --------
    >>> block = RationalPlant([1], [1, 2, 2, 1])
    >>> for found in refute(block, slope=False, odd=False, time_varying=True):
    ...     print(f"{found.kind} from {found.k:.3f} on ({found.evidence})")
    switched gain from 2.502 on (certified)
    linear gain from 3.000 on (certified)
    """
    lower = Fraction(lower)
    found = [linear_witness(block, lower=lower)]
    if block.dt is None:
        if 1 + lower * block.feedthrough != 0:
            found += _continuous(block, lower, slope=slope, odd=odd, time_varying=time_varying)
    elif not refutes_lower(found[0]):
        found += _discrete(block, lower, slope=slope, odd=odd, time_varying=time_varying)
    return tuple(sorted((witness for witness in found if witness is not None), key=lambda witness: witness.k))


def _discrete(
    block: RationalPlant, lower: Fraction, *, slope: bool, odd: bool, time_varying: bool
) -> list[Witness | None]:
    if time_varying:
        return [switched_witness_discrete(block, lower=lower)]
    if slope:
        return [periodic_witness_discrete(block, odd=odd, lower=lower)]
    return [sector_witness_discrete(block, odd=odd, lower=lower)]


def _continuous(
    block: RationalPlant, lower: Fraction, *, slope: bool, odd: bool, time_varying: bool
) -> list[Witness | None]:
    from lure.analysis.counterexamples.oscillation import oscillation_witness, sector_witness, wave_witness
    from lure.analysis.counterexamples.switched import switched_witness

    if time_varying:
        return [switched_witness(block, lower=lower)]
    found = [oscillation_witness(block, odd=odd, lower=lower), wave_witness(block, odd=odd, lower=lower)]
    found += [] if slope else [sector_witness(block, lower=lower)]
    return [min((one for one in found if one is not None), key=lambda one: one.k, default=None)]

"""Popov's criterion in the critical case of a simple zero eigenvalue, and the circle criterion, for the rod."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flint import arb

from analysis.criteria.damping import check_sector, model_of, without_damping
from analysis.criteria.result import CriterionName, CriterionResult
from analysis.criteria.ring import Ring, popov_minimum, precision_for, smallest_multiplier
from analysis.evidence import INFINITE, Bracket, Evidence, Verdict
from analysis.minimum import Minimum
from analysis.precision import ball, outward, working_precision
from lure.errors import AssumptionError, InputError
from lure.sector import Sector
from lure.upwind import UpwindScheme
from lure.waves import RodBlock

THETA_EASE = 1.25


def rod_popov_criterion(
    block: UpwindScheme | RodBlock, sector: Sector, *, theta: float | None = None
) -> CriterionResult:
    r"""Popov's frequency inequality for the rod or its scheme, certified over all frequencies.

    For ``mu = -phi(sigma)`` and ``phi`` in ``[0, k]`` brackets

    .. math:: m(\theta) = \inf_{\omega \in [0, \infty]} \{ 1/k + \mathrm{Re}[(1 + i\omega\theta) H(i\omega)] \},

    the values at both ends being limits (``H`` has a simple pole at zero with residue ``rho_0 = A/k_dashpot > 0``).

    *Scheme.* If ``m > 0``, for every time-invariant locally Lipschitz ``phi`` in the sector every solution is bounded
    and converges to a point of ``{waves at rest, phi(z) = 0}`` [1]_, [2]_; that is asymptotic stability of the origin
    only if ``phi`` vanishes at 0 alone.  *Rod.* The verdict about the rod is that of
    :func:`analysis.conclusion.conclusion`, from an energy theorem; with ``theta >= 0`` the inequality is a second proof
    of it (note 11), which nothing here rests on.

    If ``m <= 0`` nothing follows: the criterion is sufficient, not necessary.

    Parameters
    ----------
    block : UpwindScheme or RodBlock
        The N-cell scheme, or the rod itself.
    sector : Sector
        ``[0, k]``, ``0 < k <= inf`` [Pa/m].
    theta : float, optional
        Multiplier ``theta >= 0`` [s].  By default 1.25 times the smallest one that serves the unbounded sector, and at
        least the travel time, so that one multiplier covers obstacles of every stiffness.

    Returns
    -------
    CriterionResult
        REFUTED for ``k_dashpot < 0`` with a destabilising member; INCONCLUSIVE for ``k_dashpot = 0``.

    Raises
    ------
    AssumptionError
        The sector does not start at zero, or ``theta`` is negative or not finite.
    InputError
        No ``theta`` was given, and the one needed lies outside the range of doubles.

    Notes
    -----
    Closed form in python-flint balls; branch and bound on one period of the phase, no grid.  Cost independent of ``N``.
    Parameters mean the exact numbers of :attr:`lure.rod.Rod.exact`.  Negative ``theta``, legal for finite ``k``, is not
    offered: some ``theta > 0`` serves every ``k`` here.

    References
    ----------
    .. [1] M. A. Aizerman and F. R. Gantmacher, Absolute Stability of Regulator Systems, Holden-Day, 1964.
    .. [2] A. Kh. Gelig, G. A. Leonov, V. A. Yakubovich, Stability of Nonlinear Systems with Nonunique Equilibrium
       State, Nauka, 1978.

    Examples
    --------
    >>> from lure import Sector, builtin_system, upwind
    >>> print(rod_popov_criterion(upwind(builtin_system("paper-rod").rod, 10), Sector(0, 1)).verdict)
    PROVED
    """
    check_sector(sector)
    if theta is not None and not (theta >= 0 and math.isfinite(theta)):
        raise AssumptionError(f"popov_criterion needs a finite theta >= 0; got {theta}")
    refused = without_damping("popov", block, sector)
    if refused is not None:
        return refused
    _, cells = model_of(block)
    with working_precision(precision_for(block.rod, cells)):
        ring = Ring.of(block.rod, cells)
        ease = _ease(sector) / ring.scale
        unbounded = smallest_multiplier(ring, arb(0))
        if theta is None:
            theta = max(THETA_EASE * float(-unbounded.low * ring.travel_time), float(ring.travel_time))
            if not math.isfinite(theta):
                raise InputError(
                    "the multiplier that Popov's criterion needs for this rod exceeds the largest double, about "
                    "1e308 s; rescale the units"
                )
        needed = smallest_multiplier(ring, ease)
        found = popov_minimum(ring, ball(theta) / ring.travel_time, ease)
        smallest = outward(-needed.high * ring.travel_time, -needed.low * ring.travel_time)
        return _result(_Question("popov", block, sector, theta), ring, found, smallest, INFINITE)


def rod_circle_criterion(block: UpwindScheme | RodBlock, sector: Sector) -> CriterionResult:
    r"""The circle criterion, ``1/k + Re H(i omega) > 0`` on ``[0, inf]``, certified over all frequencies.

    It is Popov's inequality with ``theta = 0`` and asks more; in return the conclusion of boundedness covers
    time-varying ``phi(t, sigma)`` in the sector.  Answers and errors as for :func:`rod_popov_criterion`.

    Parameters
    ----------
    block : UpwindScheme or RodBlock
        The N-cell scheme, or the rod itself.
    sector : Sector
        ``[0, k]``, ``0 < k <= inf`` [Pa/m].
    """
    check_sector(sector)
    refused = without_damping("circle", block, sector)
    if refused is not None:
        return refused
    _, cells = model_of(block)
    with working_precision(precision_for(block.rod, cells)):
        ring = Ring.of(block.rod, cells)
        ease = _ease(sector) / ring.scale
        found = popov_minimum(ring, arb(0), ease)
        response = popov_minimum(ring, arb(0), arb(0))
        low = -1 / (ring.scale * response.low) if response.low < 0 else arb("inf")
        high = -1 / (ring.scale * response.high) if response.high < 0 else arb("inf")
        largest = outward(low, high)
        return _result(_Question("circle", block, sector, 0.0), ring, found, None, largest)


def _ease(sector: Sector) -> arb:
    return arb(0) if sector.upper == math.inf else 1 / ball(sector.upper)


@dataclass(frozen=True, slots=True)
class _Question:
    name: CriterionName
    block: UpwindScheme | RodBlock
    sector: Sector
    theta: float


def _result(
    asked: _Question, ring: Ring, found: Minimum, smallest: Bracket | None, largest: Bracket
) -> CriterionResult:
    model, _ = model_of(asked.block)
    low, high = ring.scale * found.low, ring.scale * found.high
    holds = bool(low > 0)
    margin, omega = outward(low, high), ring.frequency(found.where)
    if holds:
        reason = f"the inequality holds at every frequency; its least value is {margin.low:.6g} m/Pa"
    elif high < 0:
        reason = (
            f"the inequality fails by {-margin.high:.6g} m/Pa at {omega:.6g} rad/s, from which nothing follows "
            f"about the "
            f"loop; {_advice(asked.name, smallest, largest)}"
        )
    else:
        reason = f"the margin {margin} m/Pa is not bounded away from zero; {_advice(asked.name, smallest, largest)}"
    return CriterionResult(
        name=asked.name,
        model=model,
        sector=asked.sector,
        verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        theta=asked.theta,
        smallest_theta=smallest,
        margin=margin,
        worst_frequency=omega,
        largest_sector=largest,
        reason=reason,
        hypotheses=_hypotheses(asked, margin, holds=holds),
    )


def _advice(name: CriterionName, smallest: Bracket | None, largest: Bracket) -> str:
    if name == "circle":
        return f"the circle criterion reaches the sector [0, {largest.low:.6g}]: ask Popov's for more"
    return f"take theta above {smallest.high:.6g} s" if smallest else "take a larger theta"


def _hypotheses(asked: _Question, margin: Bracket, *, holds: bool) -> tuple[str, ...]:
    rod, sector = asked.block.rod, asked.sector
    inequality = f"inequality on [0, inf], limits included: bounded below by {margin.low:.6g} m/Pa in ball arithmetic"
    members = f"phi time-invariant, locally Lipschitz, in the sector {sector}: assumed of the class"
    if not rod.law.locally_lipschitz:
        members += (
            f"; it fails for this rod's own law, which is not Lipschitz at z = 0 (m = {rod.exponent:g} < 1): "
            "the energy theorem covers that law, this criterion does not"
        )
    return (
        f"zero eigenvalue simple: checked, k = {rod.damping:g} N s/m is not zero",
        f"all other modes decay: checked, |a| < 1 because 0 < k (a = {rod.reflection:.10g})",
        f"residue at zero positive: checked, A/k = {rod.residue_at_zero:.6g} m/(Pa s)",
        inequality if holds else "inequality on [0, inf]: not established",
        members,
    )

"""Popov's criterion in the critical case of a simple zero eigenvalue, and the circle criterion, for rod and scheme."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

from flint import arb, arb_series

from lure.analysis.numerics.minimum import Minimum, minimum
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import INFINITE, Bracket, CriterionResult, Evidence, Model, Verdict
from lure.arrays import np
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, InputError, Reason
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme
from lure.rod.parameters import Rod
from lure.rod.transfer import RodPlant

# What the sign of the damping decides about the rod before any frequency is looked at.


def model_of(block: UpwindScheme | RodPlant) -> tuple[Model, int | None]:
    """What a result about ``block`` is about, and its number of cells."""
    return ("scheme", block.cells) if isinstance(block, UpwindScheme) else ("rod", None)


def check_sector(sector: Sector) -> None:
    """Refuse a sector that the critical case does not admit.

    Raises
    ------
    AssumptionError
        The sector does not start at zero, or holds no positive slope.
    """
    if sector.lower != 0 or not sector.upper > 0:
        raise AssumptionError(
            f"the criteria for the rod need a sector [0, k] with k > 0; got {sector}: shift the loop first"
        )


def without_damping(name: str, block: UpwindScheme | RodPlant, sector: Sector) -> CriterionResult | None:
    """The answer for ``k <= 0``, where no criterion applies; None for ``k > 0``.

    ``k < 0`` is refuted by a member of the class.  For ``-Z < k < 0`` that is ``phi = 0``: the mode ``m = 0`` grows.
    For ``k < -Z`` it is any linear gain ``kappa > 0``: on ``s > 0``, ``1 + kappa H(s)`` is continuous, tends to minus
    infinity
    at 0 (the residue ``A/k`` is negative) and to 1 at infinity, so the loop has a positive real pole.
    """
    model, cells = model_of(block)
    damping = block.rod.exact["damping"]
    if damping > 0:
        return None
    if damping == 0:
        reason = (
            "the zero eigenvalue is double (damping k = 0): the critical case of Popov's theorem needs a simple one; "
            "nothing dissipates in the rod, and a rod that flies away never returns; give a damping k > 0"
        )
        verdict, evidence, witness = Verdict.INCONCLUSIVE, Evidence.CERTIFIED, None
    else:
        witness = destabilising_example(block.rod, cells, sector)
        reason = f"the dashpot feeds energy in (damping k = {float(damping):g} N s/m < 0): {witness}"
        verdict, evidence = Verdict.REFUTED, Evidence.CERTIFIED
    return CriterionResult(
        criterion=name,
        model=model,
        theorem=f"{name} criterion, which needs a dashpot that damps",
        nonlinearity_class=NonlinearityClass(sector=sector),
        largest=Bracket(0.0, math.inf),
        verdict=verdict,
        evidence=evidence,
        reason=reason,
        witness=witness,
    )


def destabilising_example(rod: Rod, cells: int | None, sector: Sector) -> str:
    """A member of the sector that destabilises a rod with ``k < 0``, in one sentence."""
    if rod.reflection < 0:
        period = 2.0 * rod.travel_time
        growth = RodPlant(rod).log_reflection
        rate = (
            growth / period if cells is None else rod.wave_speed * cells / rod.length * math.expm1(growth / (2 * cells))
        )
        return f"with phi = 0 (no contact) the rod recedes from the obstacle at a speed that grows as exp({rate:.6g} t)"
    slope = f"{float(sector.upper):g}" if math.isfinite(sector.upper) else f"{1.0 / rod.compliance:g}"
    return (
        f"with phi = {slope} sigma the loop has a positive real pole, because the residue of H at zero is "
        f"{rod.residue_at_zero:.6g} m/(Pa s) < 0"
    )


# Popov's criterion in the critical case of a simple zero eigenvalue, and the circle criterion, for the rod.

# The Popov expression of the rod and of its schemes, bounded over all frequencies in ball arithmetic.
#
# With ``q^{2N} = r e^{-i psi}`` on the imaginary axis (``r = 1``, ``psi = 2 omega T`` for the rod itself),
#
# .. math::
#
#     \mathrm{Re}[(1 + i\omega\theta) H] = d\,T\,F, \qquad
#     F = \frac{2 a r\,g + \vartheta (1 - a^2 r^2)}{1 + a^2 r^2 + 2 a r \cos\psi}, \qquad
#     g = \frac{\sin\psi}{\omega T}, \quad \vartheta = \theta / T .
#
# ``psi`` runs over ``[0, N pi)``; three facts, proved in ``notebooks/notes/0004-popov-for-the-rod.md``, reduce every
# question to ``[0, 2 pi]``: wherever ``F < vartheta`` (``vartheta >= 0``), ``F`` falls as ``r`` or ``1/omega`` grows
# (the
# latter for ``a sin psi <= 0``), and flipping the sign of a positive ``a sin psi`` lowers it.

RELATIVE_WIDTH = "1e-10"
Number = TypeVar("Number", arb, arb_series)


@described(frozen=True, kw_only=True, slots=True)
class RodResponse:
    """The rod (``cells=None``) or its scheme, in balls; ``0 < k < inf``."""

    sign: int = quantity("Sign of ``a``, decided exactly: -1 for ``k < Z``, 0 for ``k = Z``, 1 for ``k > Z``")
    size: arb = quantity("``|a|``")
    defect: arb = quantity("``1 - |a| = 2 min(k, Z)/(k + Z)``, free of cancellation")
    mobility: arb = quantity("``d`` [m/(Pa s)]")
    travel_time: arb = quantity("``T``", "s")
    cells: int | None = quantity("``N``")

    @classmethod
    def of(cls, rod: Rod, cells: int | None) -> RodResponse:
        """The response of a rod with ``k > 0``, at the current working precision."""
        exact = rod.exact
        k, stiffness = exact["damping"], exact["density"] * exact["youngs_modulus"]
        excess = k * k - exact["area"] ** 2 * stiffness
        root = ball(stiffness).sqrt()
        Z, damping = ball(exact["area"]) * root, ball(k)
        least = Z if excess > 0 else damping
        return cls(
            sign=(excess > 0) - (excess < 0),
            size=abs(ball(excess)) / (damping + Z) ** 2,
            defect=2 * least / (damping + Z),
            mobility=1 / root,
            travel_time=ball(exact["length"]) * ball(exact["density"]).sqrt() / ball(exact["youngs_modulus"]).sqrt(),
            cells=cells,
        )

    @property
    def scale(self) -> arb:
        """``d T`` [m/Pa], the unit of ``F``."""
        return self.mobility * self.travel_time

    @property
    def one_minus_square(self) -> arb:
        """``1 - a^2``."""
        return self.defect * (1 + self.size)

    @property
    def last_angle(self) -> arb:
        """End of the interval of ``psi`` that decides: ``2 pi``, or ``pi`` for ``N = 1``."""
        return arb.pi() if self.cells == 1 else 2 * arb.pi()

    def frequency(self, psi: arb) -> float:
        """``omega`` [rad/s] at the angle ``psi``; ``inf`` at the end of the range of a scheme."""
        if self.cells is None:
            return float(psi / (2 * self.travel_time))
        phi = psi / (2 * self.cells)
        if not phi.cos() > 0:
            return math.inf
        return float(self.cells * phi.tan() / self.travel_time)

    def parts(self, psi: Number) -> tuple[Number, Number]:
        """``r`` and ``g`` on ``0 <= psi <= 2 pi``; a series needs a constant term that is not zero."""
        sinc = psi.sinc() if isinstance(psi, arb) else psi.sin() / psi
        if self.cells is None:
            return 1 + 0 * psi, 2 * sinc
        N = self.cells
        phi = psi / (2 * N)
        s, c = phi.sin_cos() if isinstance(phi, arb) else (phi.sin(), phi.cos())
        cotangent = c / phi.sinc() if isinstance(phi, arb) else phi * c / s
        return c ** (2 * N), 2 * sinc * cotangent

    def denominator(self, psi: Number, r: Number) -> Number:
        """``1 + a^2 r^2 + 2 a r cos psi`` as a sum of squares, with no cancellation near ``|a| r = 1``."""
        half = psi / 2
        wave = half.cos() if self.sign > 0 else half.sin()
        return self.gap(r) ** 2 + 4 * self.size * r * wave * wave

    def gap(self, r: Number) -> Number:
        """``1 - |a| r``."""
        return self.defect + self.size * (1 - r)


def popov_minimum(rod: RodResponse, multiplier: arb, inverse_gain: arb) -> Minimum:
    """Bracket on ``inverse_gain + inf F`` over all frequencies for ``vartheta = multiplier >= 0``, and the angle of it.

    ``inverse_gain = 1/(d T k_upper)``.  For a scheme the limit ``omega -> inf`` is ``F = vartheta``.
    """
    a = rod.sign * rod.size
    if rod.sign == 0:
        return _exactly(inverse_gain + multiplier, arb(0))
    if rod.sign > 0 and rod.cells == 1 and multiplier == 0:
        # sin psi >= 0 on [0, pi]: F >= 0, and F -> 0 at the end
        return _exactly(inverse_gain, rod.last_angle)
    at_zero = multiplier * rod.one_minus_square - 4 * rod.size
    if rod.sign < 0 and at_zero <= 0:
        # numerator >= at_zero and denominator >= (1 - |a|)^2 wherever F < 0, both attained at psi = 0
        return _exactly(inverse_gain + at_zero / rod.defect**2, arb(0))

    def value(psi: Number) -> Number:
        """The expression at one angle."""
        r, g = rod.parts(psi)
        numerator = 2 * a * r * g + multiplier * rod.gap(r) * (1 + rod.size * r)
        return inverse_gain + numerator / rod.denominator(psi, r)

    # |g| <= 2 and r <= 1: the numerator is at least at_zero, the denominator at most (1 + |a|)^2
    floor = inverse_gain + at_zero / (1 + rod.size) ** 2 if at_zero >= 0 else None
    found = minimum(value, arb(0), rod.last_angle, width=lambda best: abs(best) * arb(RELATIVE_WIDTH), floor=floor)
    if rod.cells is not None and inverse_gain + multiplier <= found.low:
        return _exactly(inverse_gain + multiplier, rod.last_angle)
    return found


def smallest_multiplier(rod: RodResponse, inverse_gain: arb) -> Minimum:
    """Bracket on the negative of the smallest ``vartheta >= 0`` that works, for ``inverse_gain = 1/(d T k_upper)``.

    ``vartheta`` works at an angle iff it exceeds ``G = -(inverse_gain D + 2 a r g)/(1 - a^2 r^2)`` there; the result
    brackets ``min(0, inf -G)``.  For ``a < 0`` the supremum lies at ``omega = 0``, for every ``N`` and for the rod; for
    ``a > 0``
    a positive supremum lies in ``(pi, 2 pi)``.
    """
    a = rod.sign * rod.size
    if rod.sign == 0 or (rod.sign > 0 and rod.cells == 1):
        return _exactly(arb(0), arb(0))
    if rod.sign < 0:
        needed = (4 * rod.size - inverse_gain * rod.defect**2) / rod.one_minus_square
        return _clipped(_exactly(-needed, arb(0)))

    def value(psi: Number) -> Number:
        """The expression at one angle."""
        r, g = rod.parts(psi)
        return (inverse_gain * rod.denominator(psi, r) + 2 * a * r * g) / (rod.gap(r) * (1 + rod.size * r))

    def width(best: arb) -> arb:
        """Bracket width to stop at."""
        return abs(best) * arb(RELATIVE_WIDTH) + (inverse_gain + 1) * arb("1e-25")

    return _clipped(minimum(value, arb.pi(), 2 * arb.pi(), width=width))


def _exactly(value: arb, where: arb) -> Minimum:
    return Minimum(low=value.lower(), high=value.upper(), where=where, closed=True)


def _clipped(found: Minimum) -> Minimum:
    zero = arb(0)
    low = found.low if found.low < 0 else zero
    high = found.high if found.high < 0 else zero
    return Minimum(low=low, high=high, where=found.where, closed=found.closed)


def precision_for(rod: Rod, cells: int | None) -> int:
    """Bits that leave about 100 good ones after the cancellations near ``|a| = 1`` and for many cells."""
    exact = rod.exact
    # (k/Z)^2 as a fraction: the ratio of two doubles need not be one
    square = exact["damping"] ** 2 / (exact["area"] ** 2 * exact["density"] * exact["youngs_modulus"])
    octaves = abs(square.numerator.bit_length() - square.denominator.bit_length()) // 2 + 1 if square else 0
    return min(4096, 128 + 4 * octaves + 2 * (cells or 1).bit_length())


THETA_EASE = 1.25


def rod_popov_criterion(
    block: UpwindScheme | RodPlant, sector: Sector, *, theta: float | None = None
) -> CriterionResult:
    r"""Popov's frequency inequality for the rod or its scheme, certified over all frequencies.

    For ``mu = -phi(sigma)`` and ``phi`` in ``[0, k]`` brackets

    .. math:: m(\theta) = \inf_{\omega \in [0, \infty]} \{ 1/k + \mathrm{Re}[(1 + i\omega\theta) H(i\omega)] \},

    the values at both ends being limits (``H`` has a simple pole at zero with residue ``rho_0 = A/k_dashpot > 0``).

    *Scheme.* If ``m > 0``, for every time-invariant locally Lipschitz ``phi`` in the sector every solution is bounded
    and converges to a point of ``{waves at rest, phi(z) = 0}`` [1]_, [2]_; that is asymptotic stability of the origin
    only if ``phi`` vanishes at 0 alone.  *Rod.* The verdict about the rod is that of
    :func:`lure.analysis.rod.conclusion.conclusion`, from an energy theorem; with ``theta >= 0`` the inequality is a
    second proof
    of it (note 11), which nothing here rests on.

    If ``m <= 0`` nothing follows: the criterion is sufficient, not necessary.

    Parameters
    ----------
    block : UpwindScheme or RodPlant
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
    Parameters mean the exact numbers of :attr:`lure.rod.parameters.Rod.exact`.  Negative ``theta``, legal for finite
    ``k``, is not
    offered: some ``theta > 0`` serves every ``k`` here.

    References
    ----------
    .. [1] M. A. Aizerman and F. R. Gantmacher, Absolute Stability of Regulator Systems, Holden-Day, 1964.
    .. [2] A. Kh. Gelig, G. A. Leonov, V. A. Yakubovich, Stability of Nonlinear Systems with Nonunique Equilibrium
       State, Nauka, 1978.

    Examples
    --------
    >>> from lure import Sector
    >>> from lure.rod import builtin_system, upwind
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
        rod = RodResponse.of(block.rod, cells)
        inverse_gain = _ease(sector) / rod.scale
        unbounded = smallest_multiplier(rod, arb(0))
        if theta is None:
            theta = max(THETA_EASE * float(-unbounded.low * rod.travel_time), float(rod.travel_time))
            if not math.isfinite(theta):
                raise InputError(
                    "the multiplier that Popov's criterion needs for this rod exceeds the largest double, about "
                    "1e308 s; rescale the units",
                    code=Reason.RANGE,
                )
        needed = smallest_multiplier(rod, inverse_gain)
        found = popov_minimum(rod, ball(theta) / rod.travel_time, inverse_gain)
        smallest = outward(-needed.high * rod.travel_time, -needed.low * rod.travel_time)
        return _result(_Question("popov", block, sector, theta), rod, found, smallest, INFINITE)


def rod_circle_criterion(block: UpwindScheme | RodPlant, sector: Sector) -> CriterionResult:
    r"""The circle criterion, ``1/k + Re H(i omega) > 0`` on ``[0, inf]``, certified over all frequencies.

    It is Popov's inequality with ``theta = 0`` and asks more; in return the conclusion of boundedness covers
    time-varying ``phi(t, sigma)`` in the sector.  Answers and errors as for :func:`rod_popov_criterion`.

    Parameters
    ----------
    block : UpwindScheme or RodPlant
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
        rod = RodResponse.of(block.rod, cells)
        inverse_gain = _ease(sector) / rod.scale
        found = popov_minimum(rod, arb(0), inverse_gain)
        response = popov_minimum(rod, arb(0), arb(0))
        low = -1 / (rod.scale * response.low) if response.low < 0 else arb("inf")
        high = -1 / (rod.scale * response.high) if response.high < 0 else arb("inf")
        largest = outward(low, high)
        return _result(_Question("circle", block, sector, 0.0), rod, found, None, largest)


def _ease(sector: Sector) -> arb:
    return arb(0) if sector.upper == math.inf else 1 / ball(sector.upper)


@dataclass(frozen=True, slots=True)
class _Question:
    name: str
    block: UpwindScheme | RodPlant
    sector: Sector
    theta: float


def _result(
    asked: _Question, rod: RodResponse, found: Minimum, smallest: Bracket | None, largest: Bracket
) -> CriterionResult:
    model, _ = model_of(asked.block)
    low, high = rod.scale * found.low, rod.scale * found.high
    holds = bool(low > 0)
    margin, omega = outward(low, high), rod.frequency(found.where)
    if holds:
        reason = f"the inequality holds at every frequency; its least value is {margin.low:.6g} m/Pa"
    elif high < 0:
        reason = (
            f"the inequality fails by {-margin.high:.6g} m/Pa at {omega:.6g} rad/s, from which nothing follows about "
            f"the loop; {_advice(asked.name, smallest, largest)}"
        )
    else:
        reason = f"the margin {margin} m/Pa is not bounded away from zero; {_advice(asked.name, smallest, largest)}"
    popov = asked.name == "popov"
    return CriterionResult(
        criterion=asked.name,
        model=model,
        theorem=f"{asked.name} criterion in the critical case of a simple zero eigenvalue",
        nonlinearity_class=NonlinearityClass(sector=asked.sector, time_varying=not popov),
        needs=("time-invariant",) if popov else (),
        multiplier=f"1 + {asked.theta:.6g} s" if popov else "1",
        verdict=Verdict.PROVED if holds else Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        theta=asked.theta,
        smallest_theta=smallest,
        margin=margin,
        worst_frequency=omega,
        largest=largest,
        reason=reason,
        hypotheses=_hypotheses(asked, margin, holds=holds),
    )


def _advice(name: str, smallest: Bracket | None, largest: Bracket) -> str:
    if name == "circle":
        return f"the circle criterion holds in the sector [0, {largest.low:.6g}]: ask Popov's for more"
    return f"take theta above {smallest.high:.6g} s" if smallest else "take a larger theta"


def _hypotheses(asked: _Question, margin: Bracket, *, holds: bool) -> tuple[str, ...]:
    rod, sector = asked.block.rod, asked.sector
    inequality = f"inequality on [0, inf], limits included: bounded below by {margin.low:.6g} m/Pa in ball arithmetic"
    members = f"phi time-invariant, locally Lipschitz, in the sector {sector}: assumed of the class"
    if not rod.nonlinearity.locally_lipschitz:
        members += (
            f"; it fails for this rod's own nonlinearity, which is not Lipschitz at z = 0 (m = {rod.exponent:g} < 1): "
            "the energy theorem covers that nonlinearity, this criterion does not"
        )
    return (
        f"zero eigenvalue simple: checked, k = {rod.damping:g} N s/m is not zero",
        f"all other modes decay: checked, |a| < 1 because 0 < k (a = {rod.reflection:.10g})",
        f"residue at zero positive: checked, A/k = {rod.residue_at_zero:.6g} m/(Pa s)",
        inequality if holds else "inequality on [0, inf]: not established",
        members,
    )


def rod_criteria(scheme: UpwindScheme) -> tuple[CriterionResult, ...]:
    """Popov's and the circle criterion, for the scheme and for the rod, in the sector of the rod's contact law.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, with its rod.

    Returns
    -------
    tuple of CriterionResult
        Popov and circle for the scheme, then for the rod.
    """
    sector, rod = scheme.rod.nonlinearity.sector, RodPlant(scheme.rod)
    return (
        rod_popov_criterion(scheme, sector),
        rod_circle_criterion(scheme, sector),
        rod_popov_criterion(rod, sector),
        rod_circle_criterion(rod, sector),
    )


# The responses that the criteria rest on, computed twice.

_LARGEST_DENSE, _QUICK = 200, 50  # cells


@described(frozen=True, kw_only=True, slots=True)
class ResponseCheck:
    """The frequency response of a scheme by python-control and by the closed form."""

    frequencies: int = quantity("Number of frequencies compared, 0 if skipped")
    lowest: float = quantity("The lowest of them [rad/s]")
    highest: float = quantity("The highest [rad/s]")
    difference: float | None = quantity("Largest relative difference")
    skipped: str | None = quantity("Why nothing was compared")

    def __str__(self) -> str:
        if self.difference is None:
            return f"python-control was not asked: {self.skipped}."
        return (
            f"python-control and the closed form agree within {self.difference:.1e} (relative) at {self.frequencies} "
            f"frequencies from {self.lowest:.3g} to {self.highest:.3g} rad/s."
        )


def response_check(scheme: UpwindScheme) -> ResponseCheck:
    """Compare ``H_N(i omega)`` from the matrices (python-control) with the closed form.

    The two share the parameters and nothing else.  At 200 frequencies up to 50 cells, at 20 up to 200 cells; above
    that, where a dense response takes minutes; the
    verdicts do not rest on it.
    """
    slow, fast = 1e-3 / scheme.rod.travel_time, 4.0 * scheme.rate
    if scheme.cells > _LARGEST_DENSE:
        reason = f"a dense response of order {scheme.order} takes too long (limit: {_LARGEST_DENSE} cells)"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    if not scheme.rod.damping:
        reason = "with k = 0 the poles lie on the imaginary axis"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    frequencies = 200 if scheme.cells <= _QUICK else 20
    omega = np.geomspace(slow, fast, frequencies)
    closed = scheme.transfer(1j * omega)
    try:
        response = np.asarray(scheme.frequency_response(omega).frdata).ravel()
    except np.linalg.LinAlgError:
        reason = "its matrices are singular to working precision at some frequency"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    difference = float(np.max(np.abs(response - closed) / np.abs(closed)))
    return ResponseCheck(frequencies=frequencies, lowest=slow, highest=fast, difference=difference, skipped=None)

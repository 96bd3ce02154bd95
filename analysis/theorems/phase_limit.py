"""The dual of the Zames-Falb search at the harmonics of a period: a slope that no multiplier of any length reaches."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import acb, arb, fmpq

from lure.analysis.inequality.unit_circle import DiscretePlant
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.theorems.fir import SampledResponse
from lure.arrays import Reals, np, optimize
from lure.record import described, quantity

BITS = 128
ROUNDS = 30
LARGEST = 1e9  # a limit whose 1/k is larger in the units of the plant is not compared
STEPS_UP = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)


@described(frozen=True, kw_only=True, slots=True)
class PhaseLimit:
    r"""Weights ``alpha_r`` at ``w_r = 2 pi r / period`` ruling out every Zames-Falb multiplier at the slope ``k``."""

    k: float = quantity("Upper slope of the class ``[lower, k]``, rounded up; the same holds for every larger one")
    period: int = quantity("Period in samples")
    weights: tuple[float, ...] = quantity(
        "``alpha_0, ..., alpha_(period // 2)``, each the double it is; a guess at an orbit's power spectrum"
    )
    odd: bool = quantity("Whether the multipliers ruled out are those for odd ``phi`` (taps of either sign)")


def phase_limit(discrete: DiscretePlant, period: int, *, odd: bool, below: float = math.inf) -> PhaseLimit | None:
    r"""The slope from which the harmonics of one period rule out every Zames-Falb multiplier; None if they do not.

    Every multiplier is a mean of ``1`` and of ``1 - z^-i``, ``i != 0`` (for odd ``phi`` also of ``1 + z^-i``), so that
    nonnegative ``alpha_r``, not all zero, with

    .. math:: \sum_r \alpha_r\, \mathrm{Re}\,[(1 \mp e^{-i w_r j})(H(e^{i w_r}) + 1/k)] \le 0
        \quad \text{and} \quad \sum_r \alpha_r\, \mathrm{Re}\,[H(e^{i w_r}) + 1/k] \le 0

    leave no multiplier with a positive left-hand side [1]_.  At harmonics ``w_r = 2 pi r / period`` only ``j`` modulo
    the period matters: finitely many inequalities, checked with balls.

    Parameters
    ----------
    discrete : DiscretePlant
        The stable block.
    period : int
        At least 2.
    odd : bool
        Which multipliers.
    below : float
        A limit that is known: one that is not lower is not looked for.

    Notes
    -----
    This bounds the reach of the criterion.  It does not show that a loop is unstable.

    References
    ----------
    .. [1] J. Zhang, J. Carrasco, W. P. Heath, Duality bounds for discrete-time Zames-Falb multipliers, IEEE Trans.
       Automatic Control 67 (2022).
    """
    numerator, denominator = discrete.coefficients()
    H = SampledResponse.of(numerator, denominator).at(2 * np.pi * np.arange(period // 2 + 1) / period)
    if not np.all(np.isfinite(H)):
        return None
    factors = _factors(period, odd=odd)
    multipliers = np.array([[_value(r * shift, period, sign) for r in range(len(H))] for sign, shift in factors])
    width = (below - float(discrete.lower)) * float(discrete.gain)
    known = 1 / width if width > 1 / LARGEST else 0.0
    found = _best_weights((multipliers * H).real, multipliers.real, known)
    if found is None:
        return None
    weights, inverse = found
    exact = [Fraction(w) for w in weights.tolist()]
    for step in STEPS_UP:
        trial = Fraction(inverse * (1 - step)) * discrete.gain
        if trial > 0 and _rules_out(discrete, exact, (period, trial), factors):
            with working_precision(BITS):
                k = outward(ball(discrete.lower), ball(discrete.lower + 1 / trial)).high
            return PhaseLimit(k=k, period=period, weights=tuple(weights.tolist()), odd=odd)
    return None


def lowest_phase_limit(
    discrete: DiscretePlant, periods: range, *, odd: bool, below: float = math.inf
) -> PhaseLimit | None:
    """The lowest of the limits of several periods; None if none is lower than what is known.

    Parameters
    ----------
    discrete : DiscretePlant
        The stable block.
    periods : range
        Each at least 2.
    odd, below : bool, float
        As for :func:`phase_limit`.
    """
    lowest = None
    for period in periods:
        found = phase_limit(discrete, period, odd=odd, below=below)
        if found is not None and found.k < below:
            lowest, below = found, found.k
    return lowest


def _factors(period: int, *, odd: bool) -> list[tuple[int, int]]:
    """``(sign, shift)`` of ``1 - sign z^-shift``; sign 0 is the multiplier 1."""
    shifts = range(1, period)
    return [(0, 0), *((1, j) for j in shifts), *((-1, j) for j in shifts if odd)]


def _value(steps: int, period: int, sign: int) -> complex:
    return 0j if _vanishes(steps, period, sign) else complex(1 - sign * np.exp(-2j * np.pi * (steps % period) / period))


def _vanishes(steps: int, period: int, sign: int) -> bool:
    return (sign == 1 and steps % period == 0) or (sign == -1 and 2 * steps % (2 * period) == period)


def _best_weights(A: Reals, B: Reals, known: float) -> tuple[Reals, float] | None:
    """Weights and the largest ``x > known`` with ``(A + x B) weights <= 0``, by Dinkelbach's method, or None."""
    count = A.shape[1]
    weights, x = np.full(count, 1 / count), known
    scale = np.abs(A).max(axis=1)
    scale = np.maximum(scale, 1e-12 * scale.max() or 1.0)
    for _ in range(ROUNDS):
        current = A + x * B
        slack = np.maximum(B @ weights, 1e-9) * scale.max()
        result = optimize.linprog(
            np.append(np.zeros(count), -1.0),
            A_ub=np.column_stack([current, slack]) / scale[:, None],
            b_ub=np.zeros(len(A)),
            A_eq=np.append(np.ones(count), 0.0)[None, :],
            b_eq=[1.0],
            bounds=[(0, None)] * count + [(None, None)],
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if result.x is None or not np.all(np.isfinite(result.x)):
            break
        trial = np.clip(result.x[:count], 0, None)
        top, bottom = -(A @ trial), B @ trial
        used = bottom > 1e-13
        new = float(np.min(top[used] / bottom[used])) if used.any() else 0.0
        if not new > x * (1 + 1e-14):
            break
        weights, x = trial, new
    return (weights, x) if x > known else None


def _rules_out(
    discrete: DiscretePlant, weights: list[Fraction], point: tuple[int, Fraction], factors: list[tuple[int, int]]
) -> bool:
    """Whether every sum is certainly not positive; ``point`` holds the period and ``1/k``."""
    period, inverse = point
    if not (all(w >= 0 for w in weights) and any(w > 0 for w in weights)):
        return False
    with working_precision(BITS):
        terms: list[tuple[int, acb]] = []
        for r, weight in enumerate(weights):
            if weight > 0:
                z = _root_of_unity(2 * r, period)
                H = _horner(discrete.n.p.coeffs(), z) / _horner(discrete.d.p.coeffs(), z)
                terms.append((r, (H + ball(inverse)) * ball(weight)))
        for sign, shift in factors:
            present = [
                (term * (1 - sign * _root_of_unity(-2 * r * shift, period))).real
                for r, term in terms
                if not _vanishes(r * shift, period, sign)
            ]
            if present and not sum(present, arb(0)) <= 0:
                return False
    return True


def _root_of_unity(half_turns: int, period: int) -> acb:
    """``exp(pi i half_turns / period)``."""
    return acb(to_fmpq(Fraction(half_turns, period))).exp_pi_i()


def _horner(coefficients: list[fmpq], z: acb) -> acb:
    value = acb(0)
    for c in reversed(coefficients):
        value = value * z + arb(c)
    return value

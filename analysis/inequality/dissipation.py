r"""Diagonal multipliers for plants with few states, in floating point: semidefinite programmes over all frequencies.

As :mod:`lure.analysis.inequality.channels`, without its samples.  By Kalman, Yakubovich and Popov (Rantzer 1996)
``F(omega) >= t N`` at all frequencies if, with ``v = mu`` and any symmetric ``P``,

.. math:: v'\Lambda (W^{-1} v + \sigma) + v'\Theta \sigma' - \frac{d}{dt}\, x'Px \ge t\, v'Nv

(in discrete time the difference of ``x'Px``).  ``N = Lambda W^{-1}`` of the multiplier before, and the factor is raised
to what the multiplier found serves: Dinkelbach's form of Newton's method for the generalised eigenvalue.  Nothing here
is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Callable

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.kernel_cone import KernelCone
from lure.analysis.inequality.kernels import Found
from lure.analysis.numerics.semidefinite import Block, proposed, roughly, symmetric_basis
from lure.arrays import NDArray, np

MOST_STATES = 12  # beyond it programmes over samples are faster
_ROUNDS, _ROUGH, _ENOUGH, _FAR, _ABOVE, _LARGEST_THETA = 12, 0.03, 1e-5, 1e-3, 1.01, 1e4


def applies(cone: KernelCone) -> bool:
    """Whether the multipliers of a cone are diagonal, of functions, and the states are few."""
    return len(cone.plant.A) <= MOST_STATES and not (
        cone.pairs or cone.ratios or cone.turning is not None or cone.plant.operators
    )


def largest(
    cone: KernelCone, widths: Callable[[float], NDArray[np.float64]], start: float, most: float
) -> Found | None:
    """The multiplier found that serves farthest, None if none was found.

    Parameters
    ----------
    cone : KernelCone
        The multipliers, to which this one is added as the last found.
    widths : callable
        (m,) of a factor, increasing with it.
    start : float
        The factor to begin with.
    most : float
        More is not asked.
    """
    best, last, margin, farthest = Found.none(len(cone.odd)), Found.none(len(cone.odd)), np.inf, 0.0
    while widths(start).min() <= 0:  # at the lower bounds
        start *= _ABOVE
    factor = cone.reached(last, widths, start, (best.factor, most), rough=True) or start
    for _ in range(_ROUNDS):
        checkpoint()
        rough = margin > _ROUGH
        found = _solved(cone, widths(factor), last, rough=rough)
        if found is None:
            break
        last, margin = found
        reached = cone.reached(last, widths, factor, (best.factor, most), rough=rough)
        farthest = max(farthest, reached)
        if rough and reached >= most:
            reached, rough = cone.reached(last, widths, most, (best.factor, most)), False
        if not rough:
            best = last._replace(factor=reached) if reached > best.factor else best
            if abs(margin) < _ENOUGH or best.factor >= most:
                break
        if reached == 0:
            break
        factor = reached
    if not best.factor or best.factor < farthest * (1 - _FAR):
        return cone.largest(widths, best.factor or start, most)
    return cone.remember(best)


def _solved(cone: KernelCone, widths: NDArray[np.float64], last: Found, *, rough: bool) -> tuple[Found, float] | None:
    """The multiplier with ``sum lambda_i/w_i = 1`` and the largest ``t``, and ``t``; None if the solver has none."""
    plant = cone.plant
    (n, m), free = plant.B.shape, [i for i in range(plant.B.shape[1]) if plant.free[i]]
    basis, moves = symmetric_basis(n), np.hstack([plant.A, plant.B])
    states, inputs = np.eye(n, n + m), np.eye(m, n + m, n)
    K = len(basis)
    slopes = np.zeros((K + m + len(free) + 1, n + m, n + m))
    inner = states.T @ basis
    slopes[:K] = inner @ states - moves.T @ basis @ moves if plant.discrete else -2 * (inner @ moves)
    for i, row in enumerate(np.hstack([plant.C, plant.D])):
        slopes[K + i] = np.outer(inputs[i], row + inputs[i] / widths[i])
    for k, i in enumerate(free, K + m):
        rate = plant.own[i] @ moves
        slopes[k] = np.outer(inputs[i], rate + plant.jump[i] @ inputs) * plant.unit
    slopes[-1, n:, n:] = -np.diag(last.gamma / widths)
    slopes = (slopes + slopes.swapaxes(1, 2)) / 2
    constant, shares = slopes[K] * widths[0], widths[0] / widths[1:]  # the first weight is what the others leave
    slopes[K + 1 : K + m] -= shares[:, None, None] * slopes[K]
    slopes = np.delete(slopes, K, axis=0)
    rows = np.zeros((m + 2 * len(free) + 1, len(slopes)))
    rows[: m - 1, K : K + m - 1] = -np.eye(m - 1)
    rows[m - 1, K : K + m - 1] = 1 / widths[1:]
    turned = np.eye(len(free))
    rows[m:-1, K + m - 1 : -1] = np.vstack([turned, -turned])
    rows[-1, -1] = 1.0
    limits = np.concatenate([np.zeros(m - 1), [1.0], np.full(2 * len(free), _LARGEST_THETA), [1e3]])
    solve = roughly if rough else proposed
    x = solve(np.eye(len(slopes))[-1], [Block(constant, slopes)], rows, limits)
    if x is None:
        return None
    gamma, theta = np.empty(m), np.zeros(m)
    gamma[1:] = np.maximum(x[K : K + m - 1], 0)
    gamma[0] = max(widths[0] * (1 - (gamma[1:] / widths[1:]).sum()), 0.0)
    theta[free] = x[K + m - 1 : -1] * plant.unit
    return Found(0.0, gamma, theta, [], np.zeros(0)), float(x[-1])

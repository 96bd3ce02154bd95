"""Kernels of loops side by side: those of each are sought by themselves, so that none is weighed against another."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from lure.analysis.inequality.kernel_cone import KernelCone
from lure.analysis.inequality.kernels import Found
from lure.arrays import NDArray, np

if TYPE_CHECKING:
    from lure.analysis.inequality.shifted_loop import Widths

_NOTHING = 1e-11  # relative: an entry of H that is rounding


def farthest_kernels(cone: KernelCone, widths: Widths, start: float, most: float) -> Found | None:
    """The multiplier found that serves farthest, of loops side by side one for each; None if none was found.

    Of odd nonlinearities it is sought with kernels of one sign as well, which the search with both may miss.

    Parameters
    ----------
    cone : KernelCone
        The multipliers.
    widths : callable
        (m,) of a factor, increasing with it.
    start : float
        The factor to begin with.
    most : float
        More is not asked.
    """
    apart = _apart(cone)
    if len(apart) < 2:
        return _either_sign(cone, widths, start, most)
    found = Found.none(len(cone.odd))
    for channels in apart:

        def own(factor: float, channels: list[int] = channels) -> NDArray[np.float64]:
            """The widths of these channels."""
            return np.asarray(widths(factor)[channels])

        part = _either_sign(_alone(cone, channels), own, start, most)
        if part is None:
            return None
        found.gamma[channels], found.theta[channels], most = part.gamma, part.theta, min(most, part.factor)
        moved = [one._replace(row=channels[one.row], column=channels[one.column]) for one in part.kernels]
        found = found._replace(kernels=found.kernels + moved, masses=np.append(found.masses, part.masses))
    return cone.remember(found._replace(factor=most))


def _either_sign(cone: KernelCone, widths: Widths, start: float, most: float) -> Found | None:
    found = cone.largest(widths, start, most)
    if not any(cone.odd) or cone.gains or cone.wide or (found is not None and found.factor >= most):
        return found
    monotone = replace(cone, odd=[False] * len(cone.odd))
    other = monotone.largest(widths, start if found is None else found.factor, most)
    return other if other is not None and (found is None or other.factor > found.factor) else found


def _apart(cone: KernelCone) -> list[list[int]]:
    """The channels of each of the loops that do not interact, where all are functions of one channel each."""
    m, H = len(cone.odd), np.abs(np.where(np.isfinite(cone.H), cone.H, 0)).max(axis=0)
    if cone.plant.operators or cone.gains or cone.wide or cone.fixed or cone.ratios or cone.scaled or cone.rate:
        return [[*range(m)]]
    joined = (_NOTHING * np.sqrt(np.outer(H.max(axis=1), H.max(axis=0))) < H) | np.eye(m, dtype=bool)
    for block in cone.blocks:
        joined[np.ix_([*block], [*block])] = True
    joined = np.linalg.matrix_power((joined | joined.T).astype(float), m) > 0
    return [[*map(int, np.flatnonzero(row))] for i, row in enumerate(joined) if not row[:i].any()]


def _alone(cone: KernelCone, channels: list[int]) -> KernelCone:
    """The multipliers of some channels."""
    plant, at = cone.plant, {i: k for k, i in enumerate(channels)}
    free = [plant.free[i] for i in channels]
    own = replace(
        plant,
        B=plant.B[:, channels],
        C=plant.C[channels],
        D=plant.D[np.ix_(channels, channels)],
        lower=np.zeros(len(channels)),
        free=free,
    )
    blocks = [[at[i] for i in block] for block in cone.blocks if block[0] in at]
    return KernelCone(own, blocks, [cone.odd[i] for i in channels])

"""The smallest destabilising linear gain of a block given by matrices: found in floating point, for the checker."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals

from analysis.criteria.state_space import state_space_family
from analysis.evidence import Evidence
from analysis.hamiltonian import HamiltonianFamily
from analysis.refutation.rounding import rounded_up
from analysis.witness import Witness
from lure.errors import AssumptionError
from lure.state_space import StateSpaceBlock

NEAR_AXIS = 1e-4
ABOVE = 1e-6  # relative distance above a gain at which the loop has to be unstable
BELOW = (1 - ABOVE, 0.99, 0.9, 0.7, 0.5, 0.3, 0.1, 0.03, 0.01, 0.001)
FAR = np.geomspace(1e-3, 1e12, 31)
HALVINGS, STEPS = 60, 40
JUST_ABOVE = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)

Array = NDArray[np.float64]


def growing_gains(block: StateSpaceBlock, *, lower: Fraction = Fraction(0)) -> list[Witness]:
    r"""Gains just above the largest stable one, with which the loop ``mu = -k sigma`` seems to be unstable.

    Gains with roots on the axis are ``-1/H(i omega)`` where ``H`` is real: at the zeros of ``H(s) - H(-s)``, which are
    eigenvalues of a pencil of twice the order.  The smallest of them is taken behind which the loop is unstable, or a
    smaller one that the eigenvalues of the closed loop show.

    Parameters
    ----------
    block : StateSpaceBlock
        The block, in continuous or discrete time.
    lower : Fraction
        Least gain.

    Returns
    -------
    list of Witness
        Ascending; the first of which the checker accepts the certificate is the counterexample.  Empty where no gain
        was found.

    """
    try:
        limit = _first(state_space_family(block, lower))
    except AssumptionError:  # the loop with the least gain itself is not stable, as far as doubles can tell
        return [_witness(lower, lower)]
    if limit is None:
        return []
    gains = [float(lower) + limit * (1 + step) for step in JUST_ABOVE]
    return [_witness(Fraction(gain), lower) for gain in gains if math.isfinite(gain)]


def _first(family: HamiltonianFamily) -> float | None:
    """The least gain above 0 with which the shifted loop loses stability; None if none was seen."""
    unstable = (gain for gain in _crossings(family) if not _stable(family, gain * (1 + ABOVE)))
    found = next(unstable, None)
    sought = [gain for gain in FAR if not _stable(family, gain)] if found is None else [found * part for part in BELOW]
    for gain in sought:
        if not _stable(family, gain):
            found = _bisected(family, gain)
    return found


def _crossings(family: HamiltonianFamily) -> list[float]:
    """Positive gains ``-1/H`` where ``H(i omega)`` is real, ascending."""
    n = family.B.size
    left, right = np.zeros((2 * n + 1, 2 * n + 1)), np.eye(2 * n + 1)
    left[:n, :n], left[n:-1, n:-1], right[-1, -1] = family.A, -family.A, 0.0
    left[:-1, -1], left[-1, :-1] = np.tile(family.B, 2), np.tile(family.C, 2)
    with np.errstate(all="ignore"):
        zeros = eigvals(left, right, check_finite=False)
    zeros = zeros[np.isfinite(zeros)]
    near = np.abs(zeros.real) <= NEAR_AXIS * np.abs(zeros)
    values = [family.response(_real(family, omega)).real for omega in np.unique(np.abs(zeros.imag[near])).tolist()]
    return sorted(-1 / value for value in (*values, family.response(0.0).real, family.direct) if value < 0)


def _real(family: HamiltonianFamily, omega: float) -> float:
    """The frequency nearby where ``H`` is real, by the secant method."""
    before, here = omega * (1 - 1e-6), omega
    was, now = family.response(before).imag, family.response(here).imag
    for _ in range(STEPS):
        if now == was or abs(here - before) <= 1e-16 * abs(here):
            break
        following = here - now * (here - before) / (now - was)
        if not abs(following - omega) <= 1e-3 * omega:
            break
        before, was, here, now = here, now, following, family.response(following).imag
    return here if abs(now) <= abs(was) else before


def _stable(family: HamiltonianFamily, gain: float) -> bool:
    direct = 1 + gain * family.direct
    if direct <= 0:
        return False
    closed = family.A - gain / direct * np.outer(family.B, family.C)
    return bool(np.max(np.linalg.eigvals(closed).real) < 0)


def _bisected(family: HamiltonianFamily, unstable: float) -> float:
    """A gain up to an unstable one at which stability is lost."""
    low, high = 0.0, unstable
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _stable(family, middle) else (low, middle)
    return high


def _witness(gain: Fraction, lower: Fraction) -> Witness:
    return Witness(
        kind="linear gain",
        k=rounded_up(gain),
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"phi = k sigma with k = {float(gain):.10g}: a motion grows",
        data={"lower": str(lower), "gain": str(gain)},
    )

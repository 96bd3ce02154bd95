"""The smallest destabilising linear gain of a block given by matrices: found in floating point, for the checker."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import cast

from flint import arb_mat

from lure.analysis.inequality.gains import GainEnd, gain_ends, is_stable_gain, simplest_between
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.state_space import HamiltonianFamily, state_space_family
from lure.analysis.numerics.doubles import double_above
from lure.analysis.numerics.exact_matrix import exact_entry
from lure.analysis.numerics.precision import ball
from lure.analysis.verdict import Evidence, Witness
from lure.analysis.wording import linear_gain
from lure.arrays import ArrayLike, NDArray, linalg, np
from lure.errors import AssumptionError, InputError, Reason
from lure.plants.rational import RationalPlant
from lure.plants.realisation import Realisation as Realisation
from lure.plants.realisation import Row as Row
from lure.plants.realisation import companion as companion
from lure.plants.state_space import StateSpace

# Exact state equations from a block or from matrices, and their entries as doubles and as balls.

_CONDITION = 1e6  # of eigenvectors; above it ``exp(A t)`` is computed without them


def realisation(block: RationalPlant | tuple[ArrayLike, ArrayLike, ArrayLike]) -> Realisation:
    """The companion form of a block, or matrices ``(A, b, c)`` without feedthrough as they are.

    States of witnesses and certificates are those of the companion form.  The states that the user of a block knows,
    those of the matrices it was given by, are in :attr:`lure.plants.rational.RationalPlant.realisation`; simulations
    that
    are held against a proof use those.

    Raises
    ------
    InputError
        The shapes do not fit, or an entry is not a finite number.
    """
    if isinstance(block, RationalPlant):
        return companion(block)
    A, b, c = (np.asarray(part, dtype=object) for part in block)
    n = A.shape[0] if A.ndim == 2 else -1
    if A.shape != (n, n) or b.size != n or c.size != n:
        raise InputError(
            f"a realisation needs A (n, n), b (n,), c (n,); got A {A.shape}, b {b.shape}, c {c.shape}",
            code=Reason.NO_NUMBERS,
        )
    rows = tuple(tuple(exact_entry(A[i, j], f"A[{i}, {j}]") for j in range(n)) for i in range(n))
    sides = [
        tuple(exact_entry(v, f"{name}[{i}]") for i, v in enumerate(side.ravel()))
        for name, side in zip("bc", (b, c), strict=True)
    ]
    return Realisation(rows, sides[0], sides[1], Fraction(0))


def balls(rows: Sequence[Sequence[Fraction]]) -> arb_mat:
    """Exact rows as balls, as narrow as the working precision allows."""
    return arb_mat([[ball(value) for value in row] for row in rows])


class Exponential:
    """``exp(A t) = I + V (exp(D t) - 1) V^-1`` for many times, in doubles; without ``V`` where it is ill-conditioned.

    Parameters
    ----------
    matrix : ndarray
        ``A = V D V^-1``, (n, n).

    Notes
    -----
    For short times it is near ``I`` to full relative precision: ``V exp(D t) V^-1`` is not, and would seem to grow.
    """

    def __init__(self, matrix: NDArray[np.float64]) -> None:
        self.matrix, self.one = matrix, np.eye(len(matrix))
        self.values, self.right = np.linalg.eig(matrix)
        self.left = np.linalg.inv(self.right) if np.linalg.cond(self.right) < _CONDITION else None

    def over(self, times: ArrayLike) -> NDArray[np.float64]:
        """``exp(A t)`` of one time, (n, n); of an array of times, a stack of them."""
        t = np.asarray(times, dtype=float)[..., None, None]
        if self.left is None:
            return np.asarray(linalg.expm(self.matrix * t))
        change = (self.right * np.expm1(t * self.values)) @ self.left
        return np.asarray(self.one + change.real)


# Linear gains that destabilise: members of every class of nonlinearities.

_ABOVE = Fraction(1, 10**12)  # relative distance of a rational gain from an irrational limit


def linear_witness(
    block: RationalPlant, *, lower: Fraction = Fraction(0), bound: Fraction | float = math.inf
) -> Witness | None:
    r"""The smallest gain of ``[lower, bound]`` for which the loop ``mu = -k sigma`` is not asymptotically stable.

    A linear gain is odd, time-invariant and of slope in every ``[lower, k']``, ``k' >= k``: it refutes every class.
    In the critical case at ``lower`` (one simple pole at 0 or ``z = 1``, the others stable) the class meant is that of
    ``(lower, k]``.  A multiple pole at 0 or any other pole on the axis is no such case: there ``phi = lower sigma``, a
    member of every class, has solutions that grow or swing for ever.

    Parameters
    ----------
    block : RationalPlant
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
    case, near = TransferPolynomials.of(block).shifted(lower).case, lower
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


def _at(block: RationalPlant, lower: Fraction, end: GainEnd) -> Witness:
    """The witness at a gain with roots on the axis, the loop being stable between ``lower`` and it."""
    if end.exact is not None:
        return _gain(block, lower, end.exact)
    limit = cast("Fraction", end.high)
    far = limit + abs(limit) * _ABOVE
    gain = simplest_between((limit + far) / 2, far)
    if not is_stable_gain(block, gain):
        return _gain(block, lower, gain)
    k = end.value.high
    text = f"phi = k sigma with k = {k:.10g}: roots on the axis, a periodic solution"
    return _witness(k, text, {"lower": str(lower), "gain_low": str(end.low), "gain_high": str(end.high)})


def _gain(block: RationalPlant, lower: Fraction, gain: Fraction) -> Witness:
    solvable = 1 + gain * block.feedthrough != 0
    text = "the loop is not asymptotically stable" if solvable else "the loop has no solution, 1 + k H(inf) = 0"
    return _witness(double_above(gain), f"{linear_gain(gain)}: {text}", {"lower": str(lower), "gain": str(gain)})


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


NEAR_AXIS = 1e-4
ABOVE = 1e-6  # relative distance above a gain at which the loop has to be unstable
BELOW = (1 - ABOVE, 0.99, 0.9, 0.7, 0.5, 0.3, 0.1, 0.03, 0.01, 0.001)
FAR = [10 ** (i / 2) for i in range(-6, 25)]
HALVINGS, STEPS = 60, 40
JUST_ABOVE = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)


def growing_gains(block: StateSpace, *, lower: Fraction = Fraction(0)) -> list[Witness]:
    r"""Gains just above the largest stable one, with which the loop ``mu = -k sigma`` seems to be unstable.

    Gains with roots on the axis are ``-1/H(i omega)`` where ``H`` is real: at the zeros of ``H(s) - H(-s)``, which are
    eigenvalues of a pencil of twice the order.  The smallest of them is taken behind which the loop is unstable, or a
    smaller one that the eigenvalues of the closed loop show.

    ``block``: the block, in continuous or discrete time; ``lower``: least gain.

    Returns
    -------
    list of Witness
        Ascending; the first of which the checker accepts the certificate is the counterexample.  Empty where no gain
        was found.

    """
    try:
        limit = _first(state_space_family(block, lower))
    except AssumptionError:  # the loop with the least gain itself is not stable, as far as doubles can tell
        return [_state_space_witness(lower, lower)]
    if limit is None:
        return []
    gains = [float(lower) + limit * (1 + step) for step in JUST_ABOVE]
    return [_state_space_witness(Fraction(gain), lower) for gain in gains if math.isfinite(gain)]


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
        zeros = linalg.eigvals(left, right, check_finite=False)
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


def _state_space_witness(gain: Fraction, lower: Fraction) -> Witness:
    return Witness(
        kind="linear gain",
        k=double_above(gain),
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        description=f"phi = k sigma with k = {float(gain):.10g}: a solution grows",
        data={"lower": str(lower), "gain": str(gain)},
    )

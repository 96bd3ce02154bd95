"""The multipliers to try in a certificate for what a criterion proved: those of its answer, and some beside them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction

from lure.analysis.theorems.table import Multiplier, Upper, row_of
from lure.analysis.verdict import CriterionResult, Verdict
from lure.arrays import NDArray, Reals, linalg, np, optimize
from lure.classes import Sector
from lure.errors import AssumptionError
from lure.plants.delay import DelayPlant
from lure.plants.rational import RationalPlant

# How much room a frequency inequality leaves, in floating point: at the frequencies of the poles, and in the dips.

FAR = 24
NEAR = 6
MOST_POINTS = 1000
LOWEST = 6
SAME = 1e-9


def slack(A: Reals, b: Reals, q: Reals, r: float) -> tuple[float, float]:
    r"""``(eps, delta)``, about largest, with ``r - delta + 2 Re q x >= eps |x|^2`` for ``x = (i omega - A)^{-1} b``.

    ``A``, ``b``, ``q``, ``r``: shapes ``(n, n)``, ``(n,)``, ``(n,)``; ``n >= 1``.

    Returns
    -------
    tuple of float
        Half of the least value, and half of what that leaves.  Looked at are the frequencies of the poles, points
        about them, and local minima: estimates.

    Raises
    ------
    AssumptionError
        ``r + 2 Re q x`` is not positive at one of them, or all eigenvalues of ``A`` are zero.
    """
    triangle, basis = linalg.schur(A, output="complex")
    inward, outward = basis.conj().T @ b, q @ basis
    points = _frequencies(np.diag(triangle))

    def at(omega: float) -> tuple[float, float]:
        """``r + 2 Re q x`` and ``|x|^2`` at one frequency."""
        shifted = -triangle
        shifted.flat[:: b.size + 1] += 1j * omega
        x, _ = linalg.lapack.ztrtrs(shifted, inward)
        return r + 2.0 * float((outward @ x).real), float(np.vdot(x, x).real)

    seen = [at(omega) for omega in points.tolist()]
    values = np.array([value for value, _ in seen])
    lowest = [float(points[int(np.argmin(values))]), *_dips(lambda omega: at(omega)[0], points, values)]
    deep = [at(omega) for omega in lowest]
    least, where = min((value, omega) for (value, _), omega in zip(deep, lowest, strict=True))
    if not min(least, r) > 0:
        raise AssumptionError(f"the frequency inequality fails near {where:.6g} rad/s; no matrix P can prove it")
    delta = min(least, r) / 2
    room = [(value - delta) / size for value, size in seen + deep if size > 0]
    return (min(room) / 2 if room else 1.0), delta


def _dips(function: Callable[[float], float], points: Reals, values: Reals) -> list[float]:
    """Where the lowest local minima are, between the neighbours of the points that show them."""
    inner = 1 + np.flatnonzero((values[1:-1] <= values[:-2]) & (values[1:-1] <= values[2:]))
    found = []
    for i in sorted(inner.tolist(), key=lambda i: float(values[i]))[:LOWEST]:
        within = (float(points[i - 1]), float(points[i + 1]))
        near = {"xatol": 1e-9 * within[1]}
        found.append(optimize.minimize_scalar(function, bounds=within, method="bounded", options=near).x)
    return [float(x) for x in found]


def _frequencies(poles: NDArray[np.complex128]) -> Reals:
    """Zero, the frequencies of the poles and points about them, as close as their damping, and some far away."""
    size, width, at = np.abs(poles), np.abs(poles.real), np.abs(poles.imag)
    size = np.unique(size[size > 0])
    if not size.size:
        raise AssumptionError("all eigenvalues of A are zero; no matrix P can prove anything of it")
    reach = np.geomspace(1 / 16, 64, min(max(MOST_POINTS // size.size, 2), NEAR))
    spread = np.concatenate([-reach, [0.0], reach])
    close = (at[:, None] + width[:, None] * spread[None, :]).ravel()
    far = np.geomspace(1.5, 1e6, FAR)
    between = np.sqrt(size[1:] * size[:-1])
    return apart(np.concatenate([[0.0], size[0] / far, size, between, size[-1] * far, close[close > 0]]))


def apart(points: Reals) -> Reals:
    """Points in ascending order, one of those that differ by rounding alone: neighbours then enclose a minimum.

    ``points``: numbers, not negative.
    """
    ordered = np.unique(points)
    return np.asarray(ordered[np.append(True, np.diff(ordered) > SAME * ordered[1:])])


def multipliers(block: RationalPlant | DelayPlant, answer: CriterionResult, upper: Upper) -> Iterator[Multiplier]:
    """The multipliers to try, the likeliest first.

    Parameters
    ----------
    block : RationalPlant or DelayPlant
        The block of the answer.
    answer : CriterionResult
        What was proved.
    upper : Fraction or {"finite", "inf"}
        Upper end of the class to certify.

    Yields
    ------
    dict
        ``multiplier`` of a certificate with the theorem of that name.

    Notes
    -----
    Where ``theta`` (``alpha``, ``tau``) grows without bound with ``k``, no one multiplier serves every finite ``k``,
    and for ``"finite"`` there is nothing to try; for one number the criterion is asked again.
    """
    row = row_of(answer.criterion, block)
    yield from row.multipliers(answer, upper)
    # an answer about every finite k: its multiplier need not serve any one of them
    if isinstance(upper, Fraction) and isinstance(block, RationalPlant) and answer.largest.low == math.inf:
        bounds = Sector(answer.nonlinearity_class.sector.lower, upper)
        again = row.decide(block, bounds, odd=answer.nonlinearity_class.odd)
        if again.verdict is Verdict.PROVED:
            yield from row.multipliers(again, upper)

"""Popov's criterion for large state-space blocks in floating point: computed, never certified."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from types import MappingProxyType
from typing import Literal

from flint import fmpq

from lure.analysis.inequality.multiplier_search import Cut, SearchResult, mixture, search
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.numerics.refined import Refined, exact_dot
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Verdict
from lure.arrays import ArrayLike, NDArray, linalg, np
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, InputError, Reason

TOLERANCE = fmpq(1, 10**8)
NEAR_AXIS = 1e-3
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
GOLDEN_STEPS = 40
LOWEST = 6
WATCHED = 24
ROUNDING = fmpq(1, 2**52)
SHARP, FLANKS = 1e-2, [-2.5, -1.0, -0.4, 0.4, 1.0, 2.5]
FAR = 40


def popov_largest_computed(
    A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike = 0.0, *, sign: Literal["both", "nonnegative"] = "both"
) -> CriterionResult:
    r"""The largest ``k`` of Popov's inequality on ``[0, k]`` for ``x' = A x + B mu``, ``sigma = C x + D mu``, computed.

    As :func:`lure.analysis.theorems.popov.popov_largest`, for blocks too large for exact polynomials (400 states take
    seconds).  Levels of ``Re[(1 + i omega theta) H]`` are read off the eigenvalues of a Hamiltonian matrix [1]_, so
    that no grid decides; but these are floating point, and the verdict is INCONCLUSIVE whatever they say.

    Both ends allow for the rounding errors: at the frequencies that decide, ``H`` is computed with a known error
    (``lure.analysis.numerics.refined``).  ``high`` is a bound from these values; ``low`` falls short of the least of
    them by four times what the rounding of ``A`` was seen to change there.  So the bracket widens with
    ``eps |A|/gamma`` for modes of damping ``gamma``.

    Parameters
    ----------
    A, B, C : array_like
        Shapes ``(n, n)``, ``(n,)`` or ``(n, 1)``, ``(n,)`` or ``(1, n)``; ``A`` with all eigenvalues in the open left
        half-plane [1/s].
    D : array_like
        Direct term, one number.
    sign : {"both", "nonnegative"}
        Whether negative ``theta`` is admitted.

    Returns
    -------
    CriterionResult
        ``largest`` is computed on both sides, relative width about 1e-8, more where modes are lightly damped; ``theta``
        [s] belongs to ``largest.low``.

    Raises
    ------
    InputError
        Shapes do not fit, or an entry is not finite.
    AssumptionError
        An eigenvalue of ``A`` is not in the open left half-plane, or not by more than rounding changes it; the critical
        case cannot be told in floating point.

    References
    ----------
    .. [1] S. Boyd, V. Balakrishnan, P. Kabamba, Math. Control Signals Systems 2 (1989) 207-219.

    Examples
    --------
    >>> answer = popov_largest_computed([[0, 1, 0], [0, 0, 1], [-1, -3, -3]], [0, 0, 1], [1, 0, 0])
    >>> round(answer.largest.low, 6), answer.evidence
    (8.0, <Evidence.COMPUTED: 'computed'>)
    """
    family = HamiltonianFamily.of(A, B, C, D)
    cuts = [*family.samples(), family.at_infinity, Cut(to_fmpq(family.direct), fmpq(0))]
    found = search(family, cuts, lambda level: level, nonnegative=sign == "nonnegative", tolerance=TOLERANCE)
    return _answer(family, found, _floor(family, found))


@dataclass(frozen=True, slots=True, eq=False)
class HamiltonianFamily:
    """``Re[(1 + i omega theta) H(i omega)]`` of a stable state-space block.

    Attributes
    ----------
    A, B, C : ndarray
        Shapes ``(n, n)``, ``(n,)``, ``(n,)``.
    direct : float
        ``D``.
    marks, at_marks : ndarray
        Where the search begins [rad/s], and ``H`` there.
    triangle, inward, outward, basis : ndarray
        Complex Schur form of ``A`` with ``B`` and ``C`` in its basis, and that basis.
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    direct: float
    marks: NDArray[np.float64] = field(repr=False)
    at_marks: NDArray[np.complex128] = field(repr=False)
    triangle: NDArray[np.complex128] = field(repr=False)
    inward: NDArray[np.complex128] = field(repr=False)
    outward: NDArray[np.complex128] = field(repr=False)
    basis: NDArray[np.complex128] = field(repr=False)

    @classmethod
    def of(
        cls, A: ArrayLike, B: ArrayLike, C: ArrayLike, D: ArrayLike, *, proposing: bool = False
    ) -> HamiltonianFamily:
        """Checked arrays, and the Schur form; ``proposing`` for something that the checker decides afterwards.

        Raises
        ------
        InputError
            Shapes do not fit, or an entry is not finite.
        AssumptionError
            ``A`` is not Hurwitz or, unless proposing, not by more than rounding moves its eigenvalues.
        """
        a, b, c, d = (np.array(part, dtype=float) for part in (A, B, C, D))
        b, c = b.ravel(), c.ravel()
        if a.ndim != 2 or a.shape != (b.size, b.size) or b.size != c.size or d.size != 1 or b.size == 0:
            raise InputError(
                f"a block needs A (n, n), B (n,), C (n,) and one D; got {a.shape}, {b.shape}, {c.shape}, {d.shape}",
                code=Reason.NO_NUMBERS,
            )
        if not all(np.isfinite(part).all() for part in (a, b, c, d)):
            raise InputError("an entry of A, B, C or D is not finite; give finite numbers", code=Reason.NO_NUMBERS)
        triangle, basis = linalg.schur(a, output="complex")
        _demand_stable(a, certain=not proposing)
        marks, bare = _marks(np.diag(triangle)), np.zeros(0, dtype=complex)
        family = cls(a, b, c, float(d.ravel()[0]), marks, bare, triangle, basis.conj().T @ b, c @ basis, basis)
        return replace(family, at_marks=np.array([family.response(float(omega)) for omega in marks]))

    def response(self, omega: float) -> complex:
        """``H(i omega)``."""
        shifted = 1j * omega * np.eye(self.B.size) - self.triangle
        return complex(self.outward @ linalg.solve_triangular(shifted, self.inward, check_finite=False)) + self.direct

    @property
    def refined(self) -> Refined:
        """The same values with a known error, at the cost of a residual each."""

        def solve(omega: float, v: NDArray[np.complex128], trans: Literal[0, 1] = 0) -> NDArray[np.complex128]:
            """``(i omega - A)^-1 v``, or with the transposed matrix."""
            basis = self.basis.conj() if trans else self.basis
            shifted = 1j * omega * np.eye(self.B.size) - self.triangle
            inner = linalg.solve_triangular(shifted, basis.conj().T @ v, trans=trans, check_finite=False)
            return np.asarray(basis @ inner)

        return Refined(self.A, self.B, self.C, self.direct, solve, lambda omega, v: solve(omega, v, 1))

    def cut(self, omega: float) -> Cut:
        """The bound from one frequency."""
        value = self.response(omega)
        return Cut(to_fmpq(value.real), to_fmpq(-omega * value.imag), to_fmpq(omega))

    @property
    def at_infinity(self) -> Cut:
        """The limit of the bounds."""
        return Cut(to_fmpq(self.direct), to_fmpq(exact_dot(self.C, self.B)))

    def samples(self) -> list[Cut]:
        """The cuts of the marks."""
        slopes = -self.marks * self.at_marks.imag
        rows = zip(self.at_marks.real, slopes, self.marks, strict=True)
        return [Cut(to_fmpq(float(u)), to_fmpq(float(w)), to_fmpq(float(omega))) for u, w, omega in rows]

    def violations(self, theta: fmpq, level: fmpq) -> list[Cut]:
        """Frequencies below a level, as far as floating point can tell: between its crossings, and near the marks."""
        t, m = float(to_fraction(theta)), float(to_fraction(level))
        return [self.cut(omega) for omega in self.dips(t, m, LOWEST) if not self.value(omega, t) >= m]

    def dips(self, t: float, m: float, count: int) -> list[float]:
        """The lowest local minima of ``Re[(1 + i omega t) H]`` over the marks and next to the crossings of ``m``."""
        crossings = self.crossings(t, m)
        inner = np.sqrt(crossings[1:] * crossings[:-1]) if crossings.size else crossings
        ends = [crossings[0] / 2, crossings[-1] * 2] if crossings.size else []
        extra = np.concatenate([crossings, inner, ends])
        there = np.array([self.response(float(omega)) for omega in extra], dtype=complex)
        points, first = np.unique(np.concatenate([self.marks, extra]), return_index=True)
        response = np.concatenate([self.at_marks, there])[first]
        values = response.real - t * points * response.imag
        lowest = sorted(_dips(values), key=lambda i: values[i])[:count]
        return [self._lowest(points, i, t) for i in lowest if points[i] > 0]

    def nearby(self, cuts: Sequence[Cut], theta: fmpq) -> list[Cut]:
        """Nothing: the crossings show where to look."""
        return []

    def bound(self, support: Sequence[Cut]) -> fmpq:
        """The upper bound from the points of some cuts: the worst that the known errors of ``H`` there allow."""
        corners = [self._corners(cut) for cut in support]
        if any(not ends for ends in corners):
            return fmpq(0)
        return max(mixture(choice) for choice in product(*corners))

    def _corners(self, cut: Cut) -> list[Cut]:
        """The cut of a point, ``U`` as high as its error allows, for both ends of ``W``; none if it says nothing."""
        if cut.x is None:
            rounding = abs(cut.w) * ROUNDING
            return [Cut(cut.u, cut.w - rounding), Cut(cut.u, cut.w + rounding)] if rounding else [cut]
        omega = float(to_fraction(cut.x))
        value, error = self.refined.response(omega)
        if error == math.inf:
            return []
        u, w, spread = value.real + error, -omega * value.imag, omega * error
        ends = [Cut(to_fmpq(u), to_fmpq(w - spread)), Cut(to_fmpq(u), to_fmpq(w + spread))]
        return ends if ends[0].w * cut.w > 0 < ends[1].w * cut.w or not cut.w else []

    def value(self, omega: float, theta: float) -> float:
        """``Re[(1 + i omega theta) H]`` at one frequency."""
        there = self.response(omega)
        return there.real - theta * omega * there.imag

    def crossings(self, theta: float, level: float) -> NDArray[np.float64]:
        """Frequencies at which the level may be crossed: eigenvalues of the Hamiltonian matrix near the axis."""
        row = self.C + theta * (self.C @ self.A)
        weight = 2.0 * (self.direct + theta * float(self.C @ self.B) - level)
        if not weight > 0:
            return np.abs(np.diag(self.triangle))
        corner = self.A - np.outer(self.B, row) / weight
        matrix = np.block([[corner, -np.outer(self.B, self.B) / weight], [np.outer(row, row) / weight, -corner.T]])
        found = linalg.eigvals(matrix, check_finite=False)
        near = np.abs(found.real) <= NEAR_AXIS * np.abs(found)
        return np.unique(np.abs(found.imag[near & (found.imag != 0)]))

    def _lowest(self, points: NDArray[np.float64], i: int, theta: float) -> float:
        """The least value next to a point, by golden section on a logarithmic scale."""
        low = math.log(points[i - 1]) if i > 0 and points[i - 1] > 0 else math.log(points[i] / 4)
        high = math.log(points[i + 1]) if i + 1 < points.size else math.log(points[i] * 4)
        one, two = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        at_one, at_two = (self.value(math.exp(point), theta) for point in (one, two))
        for _ in range(GOLDEN_STEPS):
            if at_one < at_two:
                high, two, at_two = two, one, at_one
                one = high - GOLDEN * (high - low)
                at_one = self.value(math.exp(one), theta)
            else:
                low, one, at_one = one, two, at_two
                two = low + GOLDEN * (high - low)
                at_two = self.value(math.exp(two), theta)
        best = math.exp(one if at_one < at_two else two)
        return best if self.value(best, theta) < self.value(float(points[i]), theta) else float(points[i])


def _floor(family: HamiltonianFamily, found: SearchResult) -> float:
    """What ``Re[(1 + i omega theta) H]`` stays above, rounding allowed for; -inf if nothing can be said.

    At the lowest minima of the values as computed the value with a known error is taken.  The difference of the two
    shows what the rounding of ``A`` moved; the true minimum lies at most about that much below, and four times that is
    allowed.
    """
    if found.theta is None:
        return -math.inf
    theta, level = float(to_fraction(found.theta)), float(to_fraction(found.level))
    floor = min(level, family.direct + theta * exact_dot(family.C, family.B))
    for omega in [0.0, *family.dips(theta, level, WATCHED)]:
        refined, error = family.refined.response(omega)
        exact, seen = refined.real - theta * omega * refined.imag, family.value(omega, theta)
        allowed = math.hypot(1.0, theta * omega) * error + 4.0 * abs(exact - seen)
        floor = min(floor, exact - allowed) if math.isfinite(allowed) else -math.inf
    return floor


def _demand_stable(A: NDArray[np.float64], *, certain: bool) -> None:
    """Refuse a matrix that is not Hurwitz, to be certain by more than rounding moves its eigenvalues."""
    poles, left, right = linalg.eig(A, left=True, right=True, check_finite=False)
    aligned = np.abs(np.einsum("ij,ij->j", left.conj(), right))
    with np.errstate(divide="ignore"):
        moved = 4.0 * np.finfo(float).eps * np.linalg.norm(A, 2) / aligned
    worst = int(np.argmax(poles.real + np.where(np.isfinite(moved), moved, 0.0)))
    rightmost = float(np.max(poles.real))
    if not rightmost < 0:
        raise AssumptionError(
            f"A has an eigenvalue with real part {rightmost:.3g} 1/s, and it must be stable; a block with a pole "
            "at 0 needs exact coefficients: give a RationalPlant",
            code=Reason.CRITICAL,
        )
    rightmost = float(poles[worst].real)
    if certain and not rightmost + moved[worst] < 0:
        raise AssumptionError(
            f"A has an eigenvalue with real part {rightmost:.3g} 1/s, which rounding alone may change by "
            f"{moved[worst]:.2g}, so that doubles cannot tell whether it is stable; give exact coefficients"
        )


def _dips(values: NDArray[np.float64]) -> list[int]:
    """Places of the local minima."""
    padded = np.concatenate([[np.inf], values, [np.inf]])
    return [int(i) for i in np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))]


def _marks(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Zero, the frequencies of the poles and the flanks of sharp resonances, points between them, and some far away."""
    sharp = poles[np.abs(poles.real) < SHARP * np.abs(poles)]
    flanks = np.abs(sharp.imag)[:, None] + sharp.real[:, None] * np.array(FLANKS)
    marks = np.unique(np.concatenate([np.abs(poles), np.abs(poles.imag), flanks.ravel()]))
    marks = marks[marks > 1e-12 * marks[-1]]
    far = np.geomspace(1.5, 1e7, FAR)
    return np.unique(np.concatenate([[0.0], marks[0] / far, marks, np.sqrt(marks[1:] * marks[:-1]), marks[-1] * far]))


def _answer(family: HamiltonianFamily, found: SearchResult, floor: float) -> CriterionResult:
    top = float(to_fraction(found.upper_bound.value))
    high = math.nextafter(-1.0 / top, math.inf) if top < 0 else math.inf
    low = 0.0 if floor == -math.inf else math.nextafter(-1.0 / min(floor, -sys.float_info.min), 0.0)
    x = found.upper_bound.support[0].x
    return CriterionResult(
        criterion="popov",
        theorem="Popov's criterion, theta of either sign",
        largest=Bracket(min(low, high), high),
        nonlinearity_class=NonlinearityClass(sector=Sector(0, low if low > 0 else math.inf)),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.COMPUTED,
        needs=("time-invariant",),
        theta=None if found.theta is None else float(to_fraction(found.theta)),
        multiplier="1 + theta s",
        parameters=MappingProxyType({} if found.theta is None else {"theta": str(found.theta)}),
        worst_frequency=math.inf if x is None else float(to_fraction(x)),
        hypotheses=(
            f"A Hurwitz: computed, largest real part {float(np.max(np.diag(family.triangle).real)):.3g} 1/s",
            "inequality on [0, inf], limit included: computed from a Hamiltonian matrix, rounding allowed for",
            "phi time-invariant, locally Lipschitz, in the sector: assumed of the class",
        ),
        reason="computed in floating point, not certified; give exact coefficients to have it certified",
    )

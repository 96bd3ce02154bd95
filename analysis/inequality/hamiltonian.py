"""Levels of ``Re[(1 + i omega theta) H]`` of large state-space blocks in floating point: computed, never certified."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from flint import fmpq

from lure.analysis.inequality.multiplier_search import Cut, mixture
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.arrays import NDArray, linalg, np
from lure.errors import AssumptionError, Reason
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

TOLERANCE = fmpq(1, 10**8)
NEAR_AXIS = 1e-3
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
GOLDEN_STEPS = 40
LOWEST = 6
SHARP, FLANKS = 1e-2, [-2.5, -1.0, -0.4, 0.4, 1.0, 2.5]
FAR = 40


@described(frozen=True, slots=True, eq=False)
class HamiltonianFamily:
    """``Re[(1 + i omega theta) H(i omega)]`` of a stable state-space block."""

    A: NDArray[np.float64] = quantity("(n, n)")
    B: NDArray[np.float64] = quantity("(n,)")
    C: NDArray[np.float64] = quantity("(n,)")
    direct: float = quantity("``D``")
    marks: NDArray[np.float64] = quantity("Where the search begins", "rad/s", hidden=True)
    at_marks: NDArray[np.complex128] = quantity("``H`` there", hidden=True)
    triangle: NDArray[np.complex128] = quantity("Complex Schur form of ``A``", hidden=True)
    inward: NDArray[np.complex128] = quantity("``B`` in its basis", hidden=True)
    outward: NDArray[np.complex128] = quantity("``C`` in its basis", hidden=True)

    @classmethod
    def of(cls, block: StateSpace) -> HamiltonianFamily:
        """The arrays of a block in continuous time, and their Schur form.

        Raises
        ------
        AssumptionError
            ``A`` is not Hurwitz, as far as doubles can tell.
        """
        triangle, basis = linalg.schur(block.A, output="complex")
        rightmost = float(np.max(np.diag(triangle).real))
        if not rightmost < 0:
            raise AssumptionError(
                f"A has an eigenvalue with real part {rightmost:.3g} 1/s, and it must be stable; a block with a pole "
                "at 0 needs exact coefficients: give a RationalPlant",
                code=Reason.CRITICAL,
            )
        marks, bare = _marks(np.diag(triangle)), np.zeros(0, dtype=complex)
        inward, outward = basis.conj().T @ block.B, block.C @ basis
        family = cls(block.A, block.B, block.C, block.D, marks, bare, triangle, inward, outward)
        return replace(family, at_marks=np.array([family.response(float(omega)) for omega in marks]))

    def response(self, omega: float) -> complex:
        """``H(i omega)``."""
        shifted = 1j * omega * np.eye(self.B.size) - self.triangle
        return complex(self.outward @ linalg.solve_triangular(shifted, self.inward, check_finite=False)) + self.direct

    def cut(self, omega: float) -> Cut:
        """The bound from one frequency."""
        value = self.response(omega)
        return Cut(to_fmpq(value.real), to_fmpq(-omega * value.imag), to_fmpq(omega))

    @property
    def at_infinity(self) -> Cut:
        """The limit of the bounds."""
        return Cut(to_fmpq(self.direct), to_fmpq(float(self.C @ self.B)))

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
        """The upper bound from some cuts, as they were computed."""
        return mixture(support)

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

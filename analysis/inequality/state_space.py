"""The circle and Popov's criterion for blocks given by matrices, searched for in floating point, bounded in balls.

Levels of ``Re[(1 + i omega theta) H]`` of large blocks are those of a Hamiltonian matrix: computed, never certified.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import acb, acb_mat, arb, fmpq

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.multiplier_search import CAP, Cut, mixture, search
from lure.analysis.inequality.protocol import Best, Grounds
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import Bracket, Evidence
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
BITS = 128
ROUNDS = 30
NEXT = 1e-11  # relative step below the least value found so far, at which its absence is asked


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


@dataclass(frozen=True, slots=True)
class _Least:
    """The least value of ``Re[(1 + i omega theta) H]``, and the points that bound it for every ``theta``."""

    value: float
    omega: float
    theta: float
    points: tuple[Cut, ...]


def shifted_states(block: StateSpace, lower: Fraction) -> StateSpace:
    """The block ``H/(1 + lower H)`` of the loop shifted by the lower end of a sector, in doubles.

    Raises
    ------
    AssumptionError
        The loop with this gain has no solution.
    """
    gain = float(lower)
    if not gain:
        return block
    if 1 + gain * block.D == 0:
        raise AssumptionError(
            f"with the gain {gain:g} the loop has no solution: 1 + gain D = 0; take another lower end"
        )
    beta = 1 / (1 + gain * block.D)
    A = block.A - gain * beta * np.outer(block.B, block.C)
    return StateSpace(A, beta * block.B, beta * block.C, beta * block.D, block.dt)


def state_space_family(block: StateSpace, lower: Fraction = Fraction(0)) -> HamiltonianFamily:
    r"""The block with ``mu = -lower sigma - ..`` closed around it, in doubles and continuous time.

    Discrete time is mapped by ``z = (1 + s)/(1 - s)``: with ``J = (A + 1)^{-1}`` the matrices are ``1 - 2 J``,
    ``J B``, ``2 C J`` and ``D - C J B``.

    ``lower``: the gain.

    Raises
    ------
    AssumptionError
        The loop with this gain is not stable as far as doubles can tell, or has no solution.
    """
    closed = shifted_states(block, lower)
    if block.dt is not None:
        A, b, c, d = closed.A, closed.B, closed.C, closed.D
        try:
            J = np.linalg.inv(A + np.eye(b.size))
        except np.linalg.LinAlgError:
            raise AssumptionError("A has the eigenvalue -1: the block is not stable") from None
        closed = StateSpace(np.eye(b.size) - 2 * J, J @ b, 2 * c @ J, d - float(c @ J @ b))
    return HamiltonianFamily.of(closed)


@described(frozen=True, slots=True)
class StatesInequality:
    r"""``1/(k - lower) + Re[(1 + i omega theta) P(i omega)] > 0`` of a plant in doubles: computed, its upper end shown.

    Levels of ``Re[(1 + i omega theta) P]`` are read off the eigenvalues of Hamiltonian matrices [1]_, so that no grid
    is needed.  At the one or two frequencies where the inequality is tight ``P = H/(1 + lower H)`` is enclosed in
    balls: from ``largest.high`` on it fails there for every ``theta``, which is certified.  A matrix ``P`` that the
    checker accepts makes a proof of it.

    References
    ----------
    .. [1] S. Boyd, V. Balakrishnan, P. Kabamba, Math. Control Signals Systems 2 (1989) 207-219.
    """

    block: StateSpace = quantity("The plant")
    lower: Fraction = quantity("Lower end of the classes")
    weighted: bool = quantity(
        "Whether there is a ``theta``, in continuous time; else it is 0, as in the circle criterion"
    )

    @property
    def grounds(self) -> Grounds:
        """All of it in doubles."""
        direct = Fraction(self.block.D)
        return Grounds(
            lower=self.lower,
            direct=direct / (1 + self.lower * direct),
            discrete=self.block.dt is not None,
            poles="the loop with the lower gain stable: computed in floating point",
            means="eigenvalues of Hamiltonian matrices in floating point",
            evidence=Evidence.COMPUTED,
        )

    def best(self, enough: Fraction | None = None) -> Best:
        """The best multiplier and how far it seems to go.

        Raises
        ------
        AssumptionError
            The loop with the lower gain is not stable as far as doubles can tell, or time is discrete and there is to
            be a ``theta``.
        """
        block, lower = self.block, self.lower
        if self.weighted and block.dt is not None:
            raise AssumptionError("Popov's criterion is for continuous time; ask circle")
        family = state_space_family(block, lower)
        least = _popov(family) if self.weighted else _real_part(family)
        low = float(lower) - 1.0 / least.value if least.value < 0 else math.inf
        high = _above(block, lower, least.points)
        return Best(
            multiplier={"theta": Fraction(least.theta)} if self.weighted else {},
            largest=Bracket(min(low, high), high),
            worst_frequency=2 * math.atan(least.omega) if block.dt is not None else least.omega,
            formula="1 + theta s" if self.weighted else "1",
            reason="computed in floating point, not certified",
        )


def _real_part(family: HamiltonianFamily) -> _Least:
    """The circle criterion, ``theta = 0``: a level just below the least value found until no frequency is below it."""
    least = min([*family.samples(), Cut(to_fmpq(family.direct), fmpq(0))], key=lambda cut: cut.u)
    for _ in range(ROUNDS):
        checkpoint()
        level = least.u - to_fmpq(NEXT) * abs(least.u)
        found = family.violations(fmpq(0), level)
        if not found:
            break
        least = min(found, key=lambda cut: cut.u)
    return _Least(float(to_fraction(least.u)), _omega(least), 0.0, (Cut(least.u, fmpq(0), least.x),))


def _popov(family: HamiltonianFamily) -> _Least:
    cuts = [*family.samples(), family.at_infinity, Cut(to_fmpq(family.direct), fmpq(0))]
    found = search(family, cuts, lambda level: level, tolerance=TOLERANCE)
    if found.theta is None:
        raise AssumptionError("no multiplier was found: every level fails, as far as doubles can tell")
    value, points = float(to_fraction(found.level)), found.upper_bound.support
    return _Least(
        value if found.upper_bound.value < 0 else 0.0, _omega(points[0]), float(to_fraction(found.theta)), points
    )


def _omega(cut: Cut) -> float:
    return math.inf if cut.x is None else float(to_fraction(cut.x))


def _above(block: StateSpace, lower: Fraction, points: Sequence[Cut]) -> float:
    """A ``k`` at which the inequality fails at one of the frequencies, whatever ``theta``, enclosed; inf for none.

    ``1/w + u_j + theta w_j > 0`` at two frequencies, weighted by ``|w_2|`` and ``|w_1|`` of opposite signs.
    """
    with working_precision(BITS):
        enclosed = [_enclosed(block, lower, cut) for cut in points if cut != CAP]
        values = [value for value in enclosed if value is not None]
        if len(values) != len(points):
            return math.inf
        if len(values) == 1:
            bound = values[0][0]
        else:
            (u, w), (v, t) = values
            if not w * t < 0:
                return math.inf
            bound = (u * abs(t) + v * abs(w)) / (abs(t) + abs(w))
        if not bound < 0:
            return math.inf
        return math.nextafter(float((ball(lower) - 1 / bound).upper()), math.inf)


def _enclosed(block: StateSpace, lower: Fraction, cut: Cut) -> tuple[arb, arb] | None:
    """``Re H`` and ``-omega Im H`` of the shifted loop at the frequency of a cut, in balls."""
    d, gain = ball(Fraction(block.D)), ball(lower)
    if cut.x is None and cut.w == 0:  # the limit of Re H alone
        return (d / (1 + gain * d), arb(0)) if block.dt is None else _value(block, gain, acb(-1), arb(0))
    if cut.x is None:
        direct = 1 / (1 + gain * d)
        product = sum((ball(Fraction(x)) * ball(Fraction(y)) for x, y in zip(block.B, block.C, strict=True)), arb(0))
        return d * direct, product * direct * direct
    omega = ball(to_fraction(cut.x))
    s = acb(0, omega)
    return _value(block, gain, s if block.dt is None else (1 + s) / (1 - s), omega)


def _value(block: StateSpace, gain: arb, s: acb, omega: arb) -> tuple[arb, arb] | None:
    rows = [[s - arb(v) if i == j else acb(-v) for j, v in enumerate(row)] for i, row in enumerate(block.A.tolist())]
    try:
        x = acb_mat(rows).solve(acb_mat([[v] for v in block.B.tolist()]))
    except ZeroDivisionError:
        return None
    open_loop = sum((acb(v) * x[i, 0] for i, v in enumerate(block.C.tolist())), acb(arb(block.D)))
    closed = open_loop / (1 + gain * open_loop)
    return closed.real, -omega * closed.imag

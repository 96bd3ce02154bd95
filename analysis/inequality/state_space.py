"""The circle and Popov's criterion for blocks given by matrices, searched for in floating point, bounded in balls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import acb, acb_mat, arb, fmpq

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.hamiltonian import TOLERANCE, HamiltonianFamily
from lure.analysis.inequality.multiplier_search import CAP, Cut, search
from lure.analysis.inequality.protocol import Best, Grounds
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.verdict import Bracket, Evidence
from lure.arrays import np
from lure.errors import AssumptionError
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

BITS = 128
ROUNDS = 30
NEXT = 1e-11  # relative step below the least value found so far, at which its absence is asked


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

    Parameters
    ----------
    block : StateSpace
        The block.
    lower : Fraction
        The gain.

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

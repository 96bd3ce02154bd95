r"""The loop of several channels shifted by the lower bounds, in floating point, and ``P`` by Riccati equations.

With ``phi = l sigma + psi``, ``psi_i`` lies in ``[0, w_i]``.  A quadratic constraint ``(sigma, psi)' Pi (sigma, psi)
>= 0`` and Popov's terms serve if

.. math:: -\begin{pmatrix} -H \\ 1 \end{pmatrix}^* \Pi \begin{pmatrix} -H \\ 1 \end{pmatrix}
    + i \omega \Theta H - i \omega H^* \Theta > 0

at every frequency, infinity included; in discrete time at ``z = e^{i omega}``, ``Theta = 0``.  Which ``Pi`` there are
is the matter of the classes that build on this one.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, TypeAlias

from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import places, triangle
from lure.arrays import NDArray, Reals, balanced, linalg, np
from lure.errors import AssumptionError
from lure.record import described, quantity

Widths: TypeAlias = "Callable[[float], NDArray[np.float64]]"  # of a factor: (m,)

LARGEST = 1e6  # the largest factor that is tried
MEETING = 1e-7  # relative: so near to what is refuted nothing more is asked
_GRID, _DECADES, _MANY = 100, 4, 40
_SLACKS = (1e-2, 1e-3, 1e-1, 0.5, 0.2, 1e-4)
_BITS = 56  # of the smallest entry on the diagonal of P


class Proposal(NamedTuple):
    """``multiplier`` and ``proof`` of a certificate."""

    multiplier: dict[str, Any]
    proof: dict[str, Any]


@described()
class ChannelSearch(ABC):
    """What may prove the classes of several channels: lower bounds, which stay, and widths above them."""

    A: Reals = quantity("(n, n) [floating point]")
    B: Reals = quantity("(n, m) [floating point]")
    C: Reals = quantity("(m, n) [floating point]")
    D: Reals = quantity("(m, m) [floating point]")
    lower: Reals = quantity("(m,) lower bounds")
    precision: ClassVar[float] = 1e-7  # relative, to which a largest factor is worth its time

    def largest(self, widths: Widths, start: float, most: float) -> float:
        """The largest factor for which something was found, by halving; 0 if nothing.

        Parameters
        ----------
        widths : callable
            (m,) of a factor, increasing with it; not positive where there is no class.
        start : float
            A factor that is known to serve, or 0.
        most : float
            Only smaller factors are of interest.
        """
        margins = dict[float, float]()

        def serves(factor: float) -> bool:
            """Whether the margin for the widths at a factor, which is noted, is positive."""
            found = widths(factor)
            margins[factor] = self.margin(found) if found.min() > 0 else -math.inf
            return margins[factor] > 0

        low, high = self._between(serves, start, most, margins)
        if low and math.isfinite(min(margins.values(), default=math.inf)):
            serves(low)
        while high - low > self.precision * high:
            checkpoint()
            middle = _extrapolated(margins, low, high, 0.9 * self.precision * high)
            if middle is None:
                middle = (low + high) / 2 if low > high / 8 else math.sqrt(low * high) if low else high / 8
            if middle * LARGEST < min(most, 1.0) / LARGEST:
                return 0.0
            low, high = (middle, high) if serves(middle) else (low, middle)
        return low

    def _between(
        self, serves: Callable[[float], bool], known: float, most: float, margins: dict[float, float] | None = None
    ) -> tuple[float, float]:
        """A factor that serves, or what is known to begin with, and one that does not; just below ``most`` first."""
        if most < math.inf:
            near = [most * (1 - step) for step in (MEETING, 1e-4)]
            told = {} if margins is None else margins  # of a finite margin a line tells more than another try
            tried = (alpha for alpha in near if alpha == near[0] or math.isinf(told.get(near[0], math.inf)))
            served = next((alpha for alpha in tried if serves(alpha)), None)
            return (served, served * (1 + 1e-16)) if served == near[0] else (served or known, most)
        low, high = known, max(2 * known, 1.0)
        while high < LARGEST and serves(high):
            low, high = high, 4 * high
        return (low, low) if high >= LARGEST else (low, high)

    def margin(self, widths: NDArray[np.float64]) -> float:
        """How far something serves for these widths, not positive where nothing does; infinite where that is unknown.

        ``widths``: (m,) upper bounds less lower ones.
        """
        return math.inf if self.serves(widths) else -math.inf

    @abstractmethod
    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether something was found for these widths; ``widths``: (m,) upper bounds less lower ones."""

    @abstractmethod
    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """What to put into a certificate, the likeliest first, for the loop as it was given; nothing if none serve.

        ``widths``, ``lower``: upper bounds less lower ones, and these.
        """


def _extrapolated(margins: dict[float, float], low: float, high: float, step: float) -> float | None:
    """Where the margins of the two largest factors that serve vanish on a line; None for the middle instead."""
    known = sorted(factor for factor, margin in margins.items() if 0 < margin < math.inf)[-2:]
    if len(known) < 2 or len(margins) % 4 == 0:
        return None
    first, second = (margins[factor] for factor in known)
    if not first > second:
        return None
    found = known[1] + (known[1] - known[0]) * second / (first - second)
    return min(max(found, low + step), high - step)


@described()
class ShiftedLoop(ChannelSearch):
    """The inequality of one plant and lower bounds, for any widths ``w``; the others: see :class:`ChannelSearch`.

    Raises
    ------
    AssumptionError
        The loop with the gains ``lower`` is not well posed, or not asymptotically stable.
    """

    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    popov: bool = quantity("Whether a certificate states ``theta``")
    discrete: bool = quantity("Whether in discrete time")
    operators: Sequence[Sequence[int]] = quantity(
        "The channels of each operator: ``|mu_b| <= w |sigma_b|``, the shift being 0", default=()
    )

    def __post_init__(self) -> None:
        m, gain = len(self.D), np.diag(self.lower)
        self.own = self.C
        whole = np.eye(m) + self.D @ gain
        if abs(np.linalg.det(whole)) < 1e-12:
            raise AssumptionError("the loop is not well posed with the gains at the lower bounds")
        inverse = np.linalg.inv(whole)
        self.C, self.D = inverse @ self.C, inverse @ self.D
        self.A, self.B = self.A - self.B @ gain @ self.C, self.B @ (np.eye(m) - gain @ self.D)
        self.jump = self._apart()
        even, self.units = balanced(self.A)
        self.A, self.B = np.asarray(even), self.B / self.units[:, None]
        self.C, self.own = self.C * self.units, self.own * self.units
        poles = np.linalg.eigvals(self.A).astype(complex)
        inside = np.abs(poles).max() < 1 if self.discrete else poles.real.max() < 0
        if not inside:
            raise AssumptionError("the loop with the gains at the lower bounds is not asymptotically stable")
        self.omega = self._frequencies(poles)
        try:
            self.states, self.H = self.response(self.omega)
        except np.linalg.LinAlgError:  # an eigenvalue 0 that rounding has put inside
            raise AssumptionError("the loop with the gains at the lower bounds has an eigenvalue on the axis") from None
        self.unit = float(np.abs(poles).min() or 1.0) ** -1 if not self.discrete else 1.0

    def _apart(self) -> NDArray[np.float64]:
        """What is in ``i omega H`` beside the loop, once eigenvalues 0 are taken out of it; here there are none."""
        return np.zeros_like(self.D)

    def _frequencies(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        if self.discrete:
            near = np.abs(np.angle(poles))
            return np.unique(np.concatenate([np.linspace(0, np.pi, 2 * _GRID), near]))
        size = np.abs(poles)
        low, high = size.min() / 10**_DECADES, size.max() * 10**_DECADES
        around = [np.abs(p.imag) + abs(p.real) * np.linspace(-3, 3, 13) for p in poles]
        points = np.concatenate([[0.0], np.geomspace(low, high, 3 * _GRID), *around])
        return np.append(np.unique(points[points >= 0]), np.inf)

    @cached_property
    def modal(self) -> tuple[NDArray[np.complex128], ...] | None:
        """Eigenvalues, eigenvectors and ``B`` in their basis for many states, if that loses few digits; else None."""
        if len(self.A) < _MANY:
            return None
        values, turn = np.linalg.eig(self.A)
        return (values, turn, np.linalg.solve(turn, self.B.astype(complex))) if np.linalg.cond(turn) < 1e6 else None

    def response(self, omega: NDArray[np.float64]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """``(i omega - A)^-1 B`` and ``H``; at infinity 0 and ``D``.

        Parameters
        ----------
        omega : ndarray
            (k,) frequencies [rad/s].
        """
        points = np.exp(1j * omega) if self.discrete else 1j * np.where(np.isinf(omega), 0, omega)
        if self.modal is None:
            states = np.linalg.solve(points[:, None, None] * np.eye(len(self.A)) - self.A, self.B.astype(complex))
        else:
            values, turn, inputs = self.modal
            states = turn @ (inputs / (points[:, None, None] - values[:, None]))
        states[np.isinf(omega)] = 0
        return np.asarray(states, dtype=complex), np.asarray(self.C @ states + self.D, dtype=complex)

    def turned(
        self, omega: NDArray[np.float64], states: NDArray[np.complex128], H: NDArray[np.complex128]
    ) -> NDArray[np.complex128]:
        """``i omega H`` in the rows where it is used; at infinity ``C B``.

        ``omega``: (k,) frequencies [rad/s]; ``states``, ``H``: (k, n, m) and (k, m, m), as :meth:`response` has them.
        """
        through, direct = self.rates
        return np.asarray(np.where(np.asarray(self.free)[None, :, None], through @ states + direct, 0))

    @property
    def rates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What Popov's terms multiply, of the states and of the inputs: ``sigma' = C (A x + B mu)``."""
        return self.own @ self.A, self.own @ self.B + self.jump

    @property
    def acting(self) -> NDArray[np.float64]:
        """1 for the channels of operators, 0 for others: (m,)."""
        found = np.zeros(len(self.D))
        found[[i for block in self.operators for i in block]] = 1.0
        return found

    def form(self, weights: NDArray[np.float64], widths: NDArray[np.float64]) -> NDArray[np.float64]:
        """``Pi`` of ``2 a psi (w sigma - psi)``, for operators of ``2 a (w^2 sigma^2 - psi^2)``, in ``(sigma, psi)``.

        ``weights``, ``widths``: (m,) ``a`` and ``w``.
        """
        whole = weights * widths  # first: the square of a width can be beyond the largest double
        side, square = whole * (1 - self.acting), 2 * whole * self.acting * widths
        return np.block([[np.diag(square), np.diag(side)], [np.diag(side), -2 * np.diag(weights)]])

    def popovs(self, theta: Sequence[Fraction]) -> dict[str, Any]:
        """Popov's part of the multiplier of a certificate, empty for the circle criterion; ``theta``: Popov's terms."""
        return {"theta": [*map(str, theta)]} if self.popov else {}

    def solutions(
        self, Pi: NDArray[np.float64], theta: Sequence[Fraction], lower: Sequence[Fraction]
    ) -> Iterator[dict[str, Any]]:
        """Proofs by ``P``, for the loop as it was given, in units of ``2^-exponent``.

        ``Pi``: (2m, 2m) of the quadratic constraint in ``(sigma, psi)``; ``theta``, ``lower``: Popov's terms, and the
        shift.
        """
        low = np.diag([float(t * v) for t, v in zip(theta, lower, strict=True)])
        for Q in self.matrices(Pi, theta):
            rows, exponent = self.integers(Q - self.own.T @ low @ self.own)
            yield {"method": "matrix", "P": [[*map(str, row)] for row in rows], "exponent": exponent}

    def matrices(self, Pi: NDArray[np.float64], theta: Sequence[Fraction]) -> Iterator[NDArray[np.float64]]:
        """Solutions of the inequality for the shifted loop in its balanced states, (n, n).

        ``Pi``: (2m, 2m) of the quadratic constraint in ``(sigma, psi)``; ``theta``: Popov's terms.
        """
        turn = np.array([float(v) for v in theta])[:, None]
        m, H, (through, direct) = len(turn), self.H, self.rates
        Q, S, R = Pi[:m, :m], Pi[:m, m:], Pi[m:, m:]
        adjoint = H.conj().swapaxes(1, 2)
        inner = S.T @ H + turn * self.turned(self.omega, self.states, H) - adjoint @ Q @ H / 2
        F = np.linalg.eigvalsh(inner + inner.conj().swapaxes(1, 2) - R)[:, 0]
        size = np.linalg.norm(self.states, 2, axis=(1, 2)) ** 2
        with np.errstate(divide="ignore"):
            room = float(np.min(np.where(size > 0, F / size, np.inf)))
        room = 1.0 if math.isinf(room) else room  # integrators alone have no states here
        side = S - Q @ self.D
        N = self.C.T @ side + (0 if self.discrete else (turn * through).T)
        corner = side.T @ self.D + self.D.T @ S - R
        rate = turn * direct
        corner = corner if self.discrete else corner + rate + rate.T
        for share in _SLACKS if room > 0 else ():
            checkpoint()
            P = self._riccati(self.C.T @ Q @ self.C + share * room * np.eye(len(self.A)), N, corner)
            if P is not None:
                yield P

    def _riccati(
        self, cost: NDArray[np.float64], N: NDArray[np.float64], R: NDArray[np.float64]
    ) -> NDArray[np.float64] | None:
        solve = linalg.solve_discrete_are if self.discrete else linalg.solve_continuous_are
        try:
            with np.errstate(all="ignore"):
                P = solve(self.A, self.B, cost, -(R + R.T) / 2, s=-N)
        except (np.linalg.LinAlgError, ValueError):
            return None
        return (P + P.T) / 2 if np.isfinite(P).all() else None

    def integers(self, P: NDArray[np.float64]) -> tuple[list[list[int]], int]:
        """The lower triangle of a matrix, in the states of the plant, as integers times ``2^-exponent``.

        ``P``: (n, n) in the balanced states.
        """
        P = P / self.units[:, None] / self.units[None, :]
        exponent = places(float(np.abs(np.diag(P)).min()), _BITS)
        return triangle(P, exponent), exponent

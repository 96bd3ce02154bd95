r"""A plant with dead times in feedback with constant gains, checked again: ``x'(t) = A x(t) + sum_k A_k x(t - T_k)``.

With ``mu = w - L sigma`` and ``K = (1 + D L)^-1``, ``A - B L K C``, ``A_k - B L K C_k``; its response is ``(K C + sum
e^{-s T_k} K C_k)(s - M(s))^-1 B (1 - L K D) + K D``.  In neutral equations read ``C_k + s D_k`` for ``C_k`` and ``A_k
+ s E_k`` for ``A_k``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate, pairwise, product
from typing import TypeVar

from flint import acb, acb_mat, acb_series, arb, arb_mat, fmpq, fmpq_mat, fmpq_poly, fmpq_series

from lure.analysis.certificates.second.channels import Asked, diagonal, stacked
from lure.analysis.certificates.second.numerics import SERIES_TERMS, ball, on_axis, right_zeros, to_fmpq
from lure.analysis.certificates.second.question import read_kernels
from lure.analysis.certificates.second.reading import require, tick
from lure.analysis.certificates.second.systems import Delayed

Series = list[list[acb_series]]
Arriving = list[tuple[acb_mat, acb_mat, *tuple[arb_mat, ...]]]
_T = TypeVar("_T", acb_series, fmpq_series)
_LARGEST = 64


@dataclass(frozen=True, slots=True)
class Kernels:
    """``M = gamma - sum c (a/(a + side s))^n``, ``gamma`` given beside them: ``(c, a, n, side)``, side 1 or -1."""

    terms: tuple[tuple[Fraction, Fraction, int, int], ...] = ()

    @classmethod
    def read(cls, value: object) -> Kernels:
        """Those of a certificate, of which none is a delay."""
        found = list[tuple[Fraction, Fraction, int, int]]()
        for c, kernel in read_kernels({"theta": "0", "kernels": value})[1]:
            require(isinstance(kernel, tuple), "a kernel is a delay")
            found += [(c, *kernel)] if isinstance(kernel, tuple) else []
        return cls(tuple(found))

    @property
    def mass(self) -> Fraction:
        """``sum |c|``."""
        return sum((abs(c) for c, *_ in self.terms), Fraction(0))

    @property
    def monotone(self) -> bool:
        """Whether no ``c`` is below 0."""
        return all(c >= 0 for c, *_ in self.terms)

    def near(self, gamma: Fraction, s: acb_series) -> acb_series:
        """``M`` at ``s``, on the axis."""
        found = 0 * s + acb(ball(gamma))
        for c, rate, order, side in self.terms:
            lag, power = acb(ball(rate)) / (s * side + acb(ball(rate))), 0 * s + acb(1)
            for _ in range(order):
                power = power * lag
            found = found - power * ball(c)
        return found

    def far(self, gamma: Fraction, u: arb) -> acb:
        """``M`` at ``s = i/u``, where ``u`` may contain 0: a kernel is ``(a u/(a u + side i))^n``."""
        found = acb(ball(gamma))
        for c, rate, order, side in self.terms:
            lag = acb(ball(rate) * u)
            found -= (lag / (lag + acb(0, side))) ** order * ball(c)
        return found


NONE = Kernels()


@dataclass(frozen=True, slots=True)
class LateLoop:
    """The closed loop: what arrives late of the state is ``(T, A_k, C_k)``, and of ``x'`` ``(E_k, D_k)``."""

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    D: fmpq_mat
    late: tuple[tuple[Fraction, fmpq_mat, fmpq_mat], ...]
    rates: tuple[tuple[fmpq_mat, fmpq_mat], ...]
    pace: Fraction | None
    together: bool = False  # whether far out all phases are those of one turn

    @classmethod
    def of(cls, asked: Asked, gains: Sequence[Fraction]) -> LateLoop:
        """The plant with these gains; ``gains``: ``L``."""
        L, one = diagonal(gains), diagonal([Fraction(1)] * len(gains))
        whole = one + asked.D * L
        require(bool(whole.det() != 0), "the loop with the gains by which it is shifted is not well posed")
        K = whole.inv()
        back = asked.B * L * K
        inner = asked.inner or [0 * asked.A] * len(asked.late)
        late = tuple((tau, own - back * C, K * C) for (tau, C), own in zip(asked.late, inner, strict=True))
        moved = asked.rates or [(0 * C, 0 * asked.A) for _, C in asked.late]
        rates = tuple((E - back * D, K * D) for D, E in moved)
        sides = asked.A - back * asked.C, asked.B * (one - L * K * asked.D), K * asked.C, K * asked.D
        return cls(*sides, late, rates, asked.pace)

    def _grown(self, tau: Fraction) -> arb:
        """By what the solutions times ``e^(a t)`` that arrive so late are larger."""
        return grown(self.pace, tau)

    def right_roots(self, zeros: int = 0) -> int:
        """How many zeros with ``Re s >= 0`` ``chi(s)/s^r`` has, ``chi = det(s - M(s))``, none lying on the axis.

        ``zeros``: ``r``, how often 0 is one of ``chi``.

        Raises
        ------
        NotShown
            They are not counted.
        """
        n = self.A.nrows()

        def turn(a: Fraction | None, b: Fraction) -> acb:
            """``g = chi/s^n``, or of ``chi/s^r`` near 0, as :func:`right_zeros` asks."""
            if not zeros or a != 0:
                return self._turn(a, b)
            wide = acb_series([acb(0, arb(0).union(ball(b))), acb(1)])
            near: acb = self.adjugate(wide)[0][zeros] * acb(0, -1) ** (n - zeros)
            return near

        return right_zeros(n - zeros, turn, lambda a, b: on_axis(self.determinant, a, b) * acb(0, -1) ** n)

    def _turn(self, a: Fraction | None, b: Fraction) -> acb:
        """``g = chi/s^n``, as :func:`right_zeros` asks."""
        n, omega = self.A.nrows(), ball(b) if a is None else ball(a).union(ball(b))
        any_phase = acb(arb(0, 1), arb(0, 1))
        M, one = acb_mat(self.A), acb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        for (tau, A, _), (E, _) in zip(self.late, self.rates, strict=True):
            wait = (any_phase if a is None else (acb(0, -omega) * ball(tau)).exp()) * self._grown(tau)
            M, one = M + acb_mat(A) * wait, one - acb_mat(E) * wait
        if a == 0:
            return acb_mat.det(one * acb(omega) + M * acb(0, 1))
        small = acb(0, (1 / omega).union(arb(0)) if a is None else 1 / omega)
        return acb_mat.det(one + M * small)

    def adjugate(self, s: acb_series) -> tuple[acb_series, list[list[acb_series]]]:
        """``chi = det(s - M)`` and ``chi H``; ``s``: anywhere."""
        return _cramer(*self._sides(s), [[0 * s + acb(arb(v)) for v in row] for row in self.D.tolist()])

    def at_zero(self) -> tuple[fmpq_series, list[list[fmpq_series]]]:
        """The same about 0, exactly, without a pace."""
        s = fmpq_series([0, 1])
        waits = [fmpq_series([0, -to_fmpq(tau)]).exp() for tau, _, _ in self.late]
        waits = [0 * s + 1, *waits, *(s * wait for wait in waits)]

        def total(*parts: fmpq_mat) -> list[list[fmpq_series]]:
            """The sum of matrices, those that arrive late included."""
            rows = [[[M[i, j] for M in parts] for j in range(parts[0].ncols())] for i in range(parts[0].nrows())]
            return [
                [
                    sum((wait * fmpq_series([v]) for wait, v in zip(waits, entry, strict=False) if v != 0), 0 * s)
                    for entry in row
                ]
                for row in rows
            ]

        n = self.A.nrows()
        M = total(self.A, *(A for _, A, _ in self.late), *(E for E, _ in self.rates))
        outputs = total(self.C, *(C for _, _, C in self.late), *(D for _, D in self.rates))
        own = [[(s if i == j else 0 * s) - M[i][j] for j in range(n)] for i in range(n)]
        return _cramer([[*a, *b] for a, b in zip(own, total(self.B), strict=True)], outputs, total(self.D))

    @property
    def turning(self) -> list[int]:
        """The dead times with which ``x'`` arrives, or all."""
        arrives = [any(v != 0 for side in pair for v in side.entries()) for pair in self.rates]
        return [k for k, one in enumerate(arrives) if one or self.together]

    @property
    def steps(self) -> list[int]:
        """The dead times of :attr:`turning` as multiples of the largest number of which all of them are."""
        times = [self.late[k][0] for k in self.turning]
        unit = math.lcm(*(tau.denominator for tau in times))
        whole = [int(tau * unit) for tau in times]
        return [step // math.gcd(*whole) for step in whole]

    def at_any_phase(self, u: arb, arcs: Sequence[tuple[Fraction, Fraction]]) -> Arriving | None:
        """What arrives of ``H`` and of ``s H`` without dead time, and with each, ``|s| = 1/u``, for any waits inside.

        In neutral equations for arcs of the phases that ``x'`` arrives with, which are then in the first.

        ``u``: ``1/omega``; it may contain 0.  ``arcs``: two ends for each of :attr:`turning` [turns].

        Returns
        -------
        list of (acb_mat, acb_mat) or None
            (p, m) each, without the phase of the output's own dead time, the first with what no entry of ``H`` is
            larger than, whatever the phases of the outputs; None if nothing is shown.
        """
        n, over, any_phase = self.A.nrows(), acb(0, -u), acb(arb(0, 1), arb(0, 1))
        phases = [any_phase] * len(self.late)
        for k, (start, end) in zip(self.turning, arcs, strict=True):
            phases[k] = acb(0, ball(start).union(ball(end)) * 2 * arb.pi()).exp()
        M, one = acb_mat(self.A), acb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        for wait, (tau, A, _), (E, _) in zip(phases, self.late, self.rates, strict=True):
            M, one = M + acb_mat(A) * (wait * self._grown(tau)), one - acb_mat(E) * wait
        try:
            states = (one - M * over).solve(acb_mat(self.B))
        except ZeroDivisionError:
            return None
        turned, apart = acb_mat(self.C) * states, Arriving()
        plain = turned * over + acb_mat(self.D)
        most = _sizes(plain)
        for k, ((tau, _, C), (_, D)) in enumerate(zip(self.late, self.rates, strict=True)):
            side = acb_mat(C) * states * acb(self._grown(tau))
            h = side * over + acb_mat(D) * states  # s H is not asked for in rows with D
            if k in self.turning:
                plain, turned, most = plain + h * phases[k], turned + side * phases[k], most + _sizes(h)
            else:
                apart.append((h, side))
        return [(plain, turned, most), *apart]

    def at(self, omega: arb) -> acb_mat:
        """The transfer matrix at ``i omega`` [rad/s]."""
        n, M, C, s = self.A.nrows(), acb_mat(self.A), acb_mat(self.C), acb(0, omega)
        for (tau, A, outputs), (E, D) in zip(self.late, self.rates, strict=True):
            wait = (-s * ball(tau)).exp() * self._grown(tau)
            M, C = M + (acb_mat(A) + acb_mat(E) * s) * wait, C + (acb_mat(outputs) + acb_mat(D) * s) * wait
        one = acb_mat([[int(i == j) for j in range(n)] for i in range(n)])
        return C * (one * s - M).solve(acb_mat(self.B)) + acb_mat(self.D)

    def at_rest(self, border: tuple[int, int] | None = None) -> fmpq:
        """:meth:`determinant` at 0, exactly, without a pace; ``border``: an output and an input."""
        A, C = self.A, self.C
        for _, own, outputs in self.late:
            A, C = A + own, C + outputs
        if border is None:
            return (-A).det()
        i, j = border
        n = A.nrows()
        rows = [[*(-A[h, k] for k in range(n)), self.B[h, j]] for h in range(n)]
        return fmpq_mat([*rows, [*(-C[i, k] for k in range(n)), self.D[i, j]]]).det()

    def determinant(self, s: acb_series, border: tuple[int, int] | None = None) -> acb_series:
        """``det(s - M(s))``, or ``det [[s - M, b_j], [-c_i, d_ij]]``, as a series by elimination, or unbounded.

        Parameters
        ----------
        s : acb_series
            Anywhere.
        border : (int, int), optional
            An output and an input.
        """
        states, outputs = self._sides(s)
        n = len(states)
        rows = [row[:n] for row in states]
        if border is not None:
            i, j = border
            direct = 0 * s + acb(arb(self.D[i, j]))
            rows = [[*row[:n], row[n + j]] for row in states] + [[*(-v for v in outputs[i]), direct]]
        found = 0 * s + acb(1)
        for k in range(len(rows)):
            tick()
            best = max(range(k, len(rows)), key=lambda h: float(rows[h][k][0].mid().abs_upper()))
            if best != k:
                rows[k], rows[best], found = rows[best], rows[k], -found
            found = found * rows[k][k]
            below = [
                h for h in range(k + 1, len(rows)) if not all(rows[h][k][i].is_zero() for i in range(SERIES_TERMS))
            ]
            if below and rows[k][k][0].contains(0):  # a pivot that may vanish
                return acb_series([acb(arb(0, math.inf), arb(0, math.inf))] * SERIES_TERMS)
            for h in below:
                factor = rows[h][k] / rows[k][k]
                rows[h] = [v - factor * w for v, w in zip(rows[h], rows[k], strict=True)]
        return found

    def _sides(self, s: acb_series) -> tuple[Series, Series]:
        """Rows of ``(s - M(s), B)``, and of what shows the states to the outputs."""
        n, m = self.A.nrows(), self.B.ncols()
        waits = [(s * -ball(tau)).exp() * acb(self._grown(tau)) for tau, _, _ in self.late]
        waits += [s * wait for wait in waits]

        def total(first: fmpq_mat, others: Sequence[fmpq_mat], i: int, j: int) -> acb_series:
            """An entry of one matrix and of those that arrive late."""
            found = 0 * s + acb(arb(first[i, j]))
            for wait, one in zip(waits, others, strict=True):
                found = found + wait * acb(arb(one[i, j])) if one[i, j] != 0 else found
            return found

        inner = [*(A for _, A, _ in self.late), *(E for E, _ in self.rates)]
        outer = [*(C for _, _, C in self.late), *(D for _, D in self.rates)]
        rows = [
            [
                *((s if i == j else 0 * s) - total(self.A, inner, i, j) for j in range(n)),
                *(0 * s + acb(arb(self.B[i, j])) for j in range(m)),
            ]
            for i in range(n)
        ]
        return rows, [[total(self.C, outer, i, k) for k in range(n)] for i in range(self.C.nrows())]

    def response(self, s: acb_series) -> Series | None:
        """Rows of the transfer matrix as series; None if ``s - M(s)`` may be singular.

        ``s``: on the axis.
        """
        n, m = self.A.nrows(), self.B.ncols()
        rows, outputs = self._sides(s)
        for k in range(n):
            tick()
            best = max(range(k, n), key=lambda i: float(rows[i][k][0].mid().abs_upper()))
            rows[k], rows[best] = rows[best], rows[k]
            if rows[k][k][0].contains(0):
                return None
            rows[k] = [v / rows[k][k] for v in rows[k]]
            for i in (i for i in range(n) if i != k):
                factor = rows[i][k]
                rows[i] = [v - factor * w for v, w in zip(rows[i], rows[k], strict=True)]
        states = [row[n:] for row in rows]
        return [
            [sum((outputs[i][k] * states[k][j] for k in range(n)), 0 * s + acb(arb(self.D[i, j]))) for j in range(m)]
            for i in range(self.C.nrows())
        ]


def _sizes(H: acb_mat) -> arb_mat:
    """Bounds of the entries."""
    return arb_mat([[h.abs_upper() for h in row] for row in H.tolist()])


def _cramer(states: list[list[_T]], outputs: list[list[_T]], D: list[list[_T]]) -> tuple[_T, list[list[_T]]]:
    """``det P`` and ``det P (C P^-1 B + D)``, rows of ``(P, B)`` given, by Faddeev and Leverrier.

    Nothing is divided by, but the numbers from 1 to the order.
    """
    n, nothing = len(states), 0 * states[0][0]
    own, found = [row[:n] for row in states], [[nothing + int(i == j) for j in range(n)] for i in range(n)]
    adjoint, c = found, nothing
    for k in range(1, n + 1):
        tick()
        adjoint = found
        found = _product(own, adjoint)
        c = sum((found[i][i] for i in range(n)), nothing) / -k
        found = [[v + c if i == j else v for j, v in enumerate(row)] for i, row in enumerate(found)]
    sign = (-1) ** n  # det P = (-1)^n c, and adj P = -(-1)^n times the last matrix
    inner = _product(outputs, _product(adjoint, [row[n:] for row in states]))
    return c * sign, [[(c * d - v) * sign for v, d in zip(*rows, strict=True)] for rows in zip(inner, D, strict=True)]


def _product(P: list[list[_T]], Q: list[list[_T]]) -> list[list[_T]]:
    columns = [*zip(*Q, strict=True)]
    return [[sum((u * v for u, v in zip(row, column, strict=True)), 0 * row[0]) for column in columns] for row in P]


def late_companion(system: Delayed, gain: Fraction) -> LateLoop:
    """The loop of one channel with a gain: ``(d + g n_0) y + sum (q_T + g n_T) y(t - T) = 0``, ``x = (y, y', ..)``.

    ``system``: the plant; ``n_0`` is of a lower degree than ``d``.  ``gain``: ``g``, which may depend on time.
    """
    n = system.d.degree()
    require(n > 0, "the plant has no states")
    parts = dict[Fraction, fmpq_poly]()
    for tau, p in [(Fraction(0), system.d), *system.back, *((tau, to_fmpq(gain) * p) for tau, p in system.terms)]:
        parts[tau] = parts.get(tau, fmpq_poly([])) + p

    def states(p: fmpq_poly, *, shift: bool) -> fmpq_mat:
        """The companion matrix, of what arrives late its last row alone."""
        rows = [[int(shift and j == i + 1) for j in range(n)] for i in range(n - 1)]
        return fmpq_mat([*rows, [-p[j] / system.d[n] for j in range(n)]])

    nothing = fmpq_mat(n, n)
    late = tuple((tau, states(p, shift=False), nothing) for tau, p in sorted(parts.items()) if tau)
    rates = tuple((nothing, nothing) for _ in late)
    return LateLoop(states(parts[Fraction(0)], shift=True), nothing, nothing, nothing, late, rates, None)


def require_returning(stays: Sequence[LateLoop], times: Sequence[Fraction], ends: Sequence[Fraction]) -> None:
    """Check that gains which jump leave a solution ``x(t + P) = rho x(t)``, ``rho`` real between two, ``|rho| > 1``.

    With parts of the length ``h``, of which ``P`` and the dead times are multiples, the states at the beginnings of all
    parts of a period, ``Z``, are those at their ends, moved on by one part: ``Z_next - Phi Z = 0``.  At a pace the
    multiplier of the solution times ``e^(a t)`` is ``rho e^(a P)``.

    Parameters
    ----------
    stays : sequence of LateLoop
        The loops with the gains, in turn.
    times : sequence of Fraction
        How long each of them holds [s].
    ends : sequence of Fraction
        The two numbers.

    Raises
    ------
    NotShown
        The determinant has one sign, or none is shown, or the numbers lie inside.
    """
    first, period, jumps = stays[0], sum(times, Fraction(0)), [*accumulate(times)]
    h, n = period, first.A.nrows()
    for tau, _, _ in first.late:
        while tau:
            h, tau = tau, h % tau  # Euclid's algorithm
    count = int(period / h)
    require(len(ends) == 2 and ends[0] < ends[1] and ends[0] * ends[1] > 0, "there are no two multipliers of one sign")
    require(0 < count * n <= _LARGEST, "the period and the dead times have too small a common part")
    cuts, signs = sorted({jump % h for jump in jumps} | {Fraction(0), h}), list[bool]()
    for end in ends:
        rho, whole = ball(end) * grown(first.pace, period), arb_mat(count * n, count * n, [0] * (count * n) ** 2)
        require(bool(abs(rho) >= 1), "a multiplier lies inside the unit circle")
        for k in range(count * n):
            whole[k, k] = arb(1)
        for a, b in pairwise(cuts):
            tick()
            rates = arb_mat(count * n, count * n, [0] * (count * n) ** 2)
            for part in range(count):
                loop = stays[sum(jump <= part * h + (a + b) / 2 for jump in jumps)]
                arriving = [(Fraction(0), loop.A, arb(1))]
                arriving += [(tau, A, loop._grown(tau)) for tau, A, _ in loop.late]
                for tau, A, factor in arriving:
                    laps, place = divmod(part - int(tau / h), count)
                    factor = factor * rho**laps
                    for i, j in product(range(n), repeat=2):
                        rates[part * n + i, place * n + j] += factor * arb(A[i, j])
            whole = (rates * ball(b - a)).exp() * whole
        for part in range(count):
            for i in range(n):
                after = (part + 1) % count
                whole[part * n + i, after * n + i] -= arb(1) if after else rho
        found = whole.det()
        require(bool(found != 0), "the sign of a determinant is not shown")
        signs.append(bool(found > 0))
    require(signs[0] is not signs[1], "the determinant does not change its sign")


def grown(pace: Fraction | None, tau: Fraction) -> arb:
    """``e^(a T)``.

    ``pace``: the rate ``a``; None for 0.  ``tau``: the dead time ``T``.
    """
    return ball((pace or Fraction(0)) * tau).exp()


def opened(asked: Asked) -> tuple[Asked, list[Fraction]]:
    """The plant with the late states as outputs and inputs of its own, one for each that comes back, and their gains.

    ``x' = A x + B mu + sum_i e_i nu_i``, ``nu_i = -tau_i`` with ``tau_i = -sum_k e_i' (A_k x + E_k x')(t - T_k)``.
    """
    n, m = asked.A.nrows(), asked.D.nrows()
    back = [*asked.inner, *(E for _, E in asked.rates)]
    rows = [i for i in range(n) if any(A[i, j] != 0 for A in back for j in range(n))]
    if not rows:
        return asked, []
    r = len(rows)
    units = fmpq_mat([[int(i == k) for k in rows] for i in range(n)])
    seen = [(tau, stacked(C, -units.transpose() * A)) for (tau, C), A in zip(asked.late, asked.inner, strict=True)]
    B = stacked(asked.B.transpose(), units.transpose()).transpose()
    D = stacked(stacked(asked.D.transpose(), fmpq_mat(r, m)).transpose(), fmpq_mat(r, m + r))
    moved = tuple((stacked(own, -units.transpose() * E), 0 * E) for own, E in asked.rates)
    wider = replace(asked, B=B, C=stacked(asked.C, fmpq_mat(r, n)), D=D, late=tuple(seen), inner=(), rates=moved)
    return wider, [Fraction(1)] * r

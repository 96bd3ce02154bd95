"""A loop with an input around constant gains, in exact numbers, and its nonlinearities with their derivatives."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from flint import acb, acb_mat, arb, arb_mat, fmpq, fmpq_mat, fmpq_poly

from lure.analysis.nonlinearity.jets import jet
from lure.analysis.nonlinearity.pieces import known_nonlinearity, tree_of
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import Complexes, Reals, np
from lure.errors import InputError
from lure.nonlinearities import ExpressionNonlinearity, GraphNonlinearity
from lure.nonlinearities.base import Nonlinearity
from lure.nonlinearities.piecewise_linear import Graph
from lure.nonlinearities.reading import control_saturation
from lure.plants.channel_family import ChannelFamily
from lure.plants.multivariable import MultivariablePlant
from lure.plants.performance import Performance, Rows
from lure.record import described, quantity

# Nonlinearities with their first two derivatives on intervals, in ball arithmetic.

Curve = Callable[[arb], tuple[arb, arb, arb]]
"""``phi``, ``phi'`` and ``phi''`` on a ball; at a kink ``phi'`` is the hull of the slopes and ``phi''`` is nan."""


def curve_of(nonlinearity: Nonlinearity) -> Curve:
    """The enclosures of a nonlinearity; ``nonlinearity``: piecewise linear, named or a formula.

    Raises
    ------
    InputError
        It is known by its values alone.
    """
    given: object = control_saturation(nonlinearity) or nonlinearity
    own = callable(given) and getattr(type(given).__call__, "__module__", "").startswith("lure.")
    if own and isinstance(given, GraphNonlinearity | ExpressionNonlinearity) and given.graph is not None:
        return _bends(given.graph)
    polynomial = polynomial_of(nonlinearity) if own else None
    if polynomial is not None:
        return _horner(polynomial)
    tree = tree_of(given) if own else None
    if tree is None:
        raise InputError(
            f"the nonlinearity is {str(nonlinearity)[:60]}, known by its values alone, of which no enclosure follows; "
            "give a formula, points, or one of the named kinds"
        )

    def curve(box: arb) -> tuple[arb, arb, arb]:
        """From the series of the formula."""
        value, slope, bend = jet(tree, box)
        return value, slope, 2 * bend

    return curve


def polynomial_of(nonlinearity: Nonlinearity) -> fmpq_poly | None:
    """A nonlinearity that is a polynomial; None for others.

    ``nonlinearity``: one that has enclosures.
    """
    known = known_nonlinearity(nonlinearity, -math.inf, math.inf)
    ratios = [piece.ratio for piece in known.pieces] if known is not None else [None]
    ratio = ratios[0]
    if ratio is None or ratio.poles.degree() > 0 or any(other != ratio for other in ratios):
        return None
    return ratio.top / ratio.bottom[0]


def _horner(polynomial: fmpq_poly) -> Curve:
    """The enclosures of a polynomial."""
    series = [polynomial, polynomial.derivative(), polynomial.derivative().derivative()]
    with working_precision(_BITS):
        rows = [[arb(c) for c in reversed(one.coeffs())] for one in series]

    def curve(box: arb) -> tuple[arb, arb, arb]:
        """By Horner's rule."""
        found = list[arb]()
        for row in rows:
            value = row[0] if row else arb(0)
            for c in row[1:]:
                value = value * box + c
            found.append(value)
        return found[0], found[1], found[2]

    return curve


def _bends(graph: Graph) -> Curve:
    """The enclosures of a piecewise linear graph."""
    kinks = graph.kinks
    inside = [(x + y) / 2 for x, y in pairwise(kinks)]
    places = [kinks[0] - 1, *inside, kinks[-1] + 1] if kinks else [Fraction(0)]
    slopes = [graph.slopes[bisect_left(graph.knots, x)] for x in places]
    points = (kinks[0], *kinks) if kinks else (Fraction(0),)
    lines = [(ball(x), ball(graph.exact(x)), ball(s)) for x, s in zip(points, slopes, strict=True)]

    at = [ball(x) for x in kinks]

    def curve(box: arb) -> tuple[arb, arb, arb]:
        """From the lines that meet the ball."""
        below, past = sum(x < box for x in at), sum(x > box for x in at)  # what is not certain counts as inside
        parts = lines[below : len(lines) - past]
        values = [y + s * (box - x) for x, y, s in parts]
        value, slope = values[0], parts[0][2]
        for other, (_, _, s) in zip(values[1:], parts[1:], strict=True):
            value, slope = value.union(other), slope.union(s)
        return value, slope, arb(0) if len(parts) == 1 else arb("nan")

    return curve


MOST_STATES = 24
_SUMMED, _MOST_SUMMED = 512, 8192
_BITS = 192
_POINTS, _DECADE, _SHARE, _HALF_TURN = 25, 10.0, 1e-9, 3.14


@described(frozen=True)
class ForcedLoop:
    r"""The loop with an input, and gains ``g_i`` taken out of its nonlinearities.

    .. math:: \dot x = A x + B \nu + E w, \quad (\sigma, z) = C x + D \nu + F w, \quad
        \nu_i = -\psi_i(\sigma_i), \quad \psi_i(\sigma) = \phi_i(\sigma) - g_i \sigma,

    in discrete time with ``x+``.  If the slopes of ``phi_i`` lie in ``[l_i, k_i]`` and ``g_i`` in their middle, the
    differences of ``psi_i`` are at most ``kappa_i = (k_i - l_i)/2`` times those of ``sigma_i``.
    """

    A: fmpq_mat = quantity("Exactly, as the others")
    B: fmpq_mat
    C: fmpq_mat = quantity("The rows of ``sigma``, then those of ``z``, as in ``D`` and ``F``")
    D: fmpq_mat
    E: fmpq_mat
    F: fmpq_mat
    gains: tuple[Fraction, ...] = quantity("``g``")
    spread: tuple[Fraction, ...] = quantity("``kappa``")
    nonlinearities: tuple[Nonlinearity, ...] = quantity("``phi``")
    curves: tuple[Curve, ...] = quantity("Their enclosures")
    degrees: tuple[int | None, ...] = quantity("Of those that are polynomials")
    discrete: bool = quantity("Whether in discrete time")

    @classmethod
    def around(
        cls,
        H: MultivariablePlant,
        performance: Performance | None,
        nonlinearities: Sequence[Nonlinearity],
        slopes: Sequence[tuple[Fraction, Fraction]],
    ) -> ForcedLoop:
        """The loop around the middle of the slopes.

        Parameters
        ----------
        H : MultivariablePlant
            The plant.
        performance : Performance or None
            Where ``w`` enters and what ``z`` is; without one ``w`` is added to ``mu`` where it enters the plant, and
            ``z`` is ``sigma``.
        nonlinearities : sequence of Nonlinearity
            One for each channel.
        slopes : sequence of pairs of Fraction
            Bounds of their difference quotients.

        Raises
        ------
        InputError
            The plant has more than 24 states, ``1 + D g`` is singular, or a nonlinearity is known by its values alone.
        """
        if H.order > MOST_STATES:
            raise InputError(f"the plant has {H.order} states; steady responses are enclosed for up to {MOST_STATES}")
        m, (Bw, Cz, Dzw, Dzmu, Dsw) = H.inputs, _sides(H, performance)
        A, B, C, D = (
            _flint(rows, (len(rows), width)) for rows, width in ((H.A, H.order), (H.B, m), (H.C, H.order), (H.D, m))
        )
        gains = tuple((low + high) / 2 for low, high in slopes)
        G = _flint([[g * (i == j) for j in range(m)] for i, g in enumerate(gains)], (m, m))
        one = _flint([[Fraction(i == j) for j in range(m)] for i in range(m)], (m, m))
        whole = one + D * G
        if whole.det() == 0:
            raise InputError("the loop has no solution with constant gains in the middle of the slopes")
        turn = whole.inv()  # sigma = turn (C x + D nu + Dsw w)
        S, N, W = turn * C, turn * D, turn * Dsw
        sides = {"A": A - B * G * S, "B": B - B * G * N, "E": Bw - B * G * W}
        sides |= {"C": _stacked(S, Cz - Dzmu * G * S), "D": _stacked(N, Dzmu - Dzmu * G * N)}
        return cls(
            **sides,
            F=_stacked(W, Dzw - Dzmu * G * W),
            gains=gains,
            spread=tuple((high - low) / 2 for low, high in slopes),
            nonlinearities=tuple(nonlinearities),
            curves=tuple(map(curve_of, nonlinearities)),
            degrees=tuple(None if one is None else int(one.degree()) for one in map(polynomial_of, nonlinearities)),
            discrete=H.dt is not None,
        )

    @property
    def order(self) -> int:
        """Number of states."""
        return int(self.A.nrows())

    @property
    def channels(self) -> int:
        """Number of nonlinearities ``m``."""
        return len(self.gains)

    @property
    def inputs(self) -> int:
        """Length of ``w``."""
        return int(self.F.ncols())

    @property
    def outputs(self) -> int:
        """Length of ``z``."""
        return int(self.F.nrows()) - self.channels

    @cached_property
    def doubles(self) -> tuple[Reals, ...]:
        """``A``, ``B``, ``C``, ``D``, ``E`` and ``F`` in doubles."""
        return tuple(_doubles(side) for side in (self.A, self.B, self.C, self.D, self.E, self.F))

    def frequencies(self) -> list[Fraction]:
        """Frequencies around those of the loop, in discrete time angles up to half a turn, with few digits."""
        values = np.linalg.eigvals(self.doubles[0])
        sizes = np.abs(np.log(values[values != 0])) if self.discrete else np.abs(values)
        seen = sizes[sizes > _SHARE * sizes.max()] if sizes.size and sizes.max() > 0 else np.ones(1)
        low, high = float(seen.min()) / _DECADE, float(seen.max()) * _DECADE
        if self.discrete:
            low, high = min(low, _HALF_TURN / _DECADE), _HALF_TURN
        return [Fraction(f"{value:.3g}") for value in np.geomspace(low, high, _POINTS)]

    def responses(self, omega: float, count: int) -> tuple[Complexes, Complexes]:
        """From harmonics ``0, ..., count`` of ``nu`` and of ``w`` to those of ``(sigma, z)``, in floating point.

        ``omega``: the frequency [rad/s]; ``count``: how many harmonics.
        """
        A, B, C, D, E, F = self.doubles
        points = 1j * omega * np.arange(count + 1)
        points = np.exp(points) if self.discrete else points
        states = np.linalg.solve(points[:, None, None] * np.eye(len(A)) - A, np.hstack([B, E]).astype(complex))
        whole = C @ states + np.hstack([D, F])
        return whole[..., : self.channels], whole[..., self.channels :]

    def resonance(self, omega: float) -> float:
        """How near an eigenvalue of ``A`` is to a multiple of ``i omega``, relative, in doubles; ``omega`` in rad/s."""
        values = np.linalg.eigvals(self.doubles[0])
        nearest = 1j * omega * np.round(values.imag / omega)
        return float((np.abs(values - nearest) / (np.abs(values) + omega)).min(initial=1.0))

    def size(self, omega: float) -> float:
        """The largest ``|sigma_i|`` that a ``nu_j`` of amplitude 1 makes, in floating point; 1 where it makes none.

        ``omega``: the frequency [rad/s], that of no eigenvalue.
        """
        A, B, C, *_ = self.doubles
        found = C[: self.channels] @ np.linalg.solve(1j * omega * np.eye(len(A)) - A, B.astype(complex))
        return float(np.abs(found).max()) or 1.0

    def beyond(self, omega: float, count: int, whole: Reals) -> float:
        """Which share of ``whole``, what :meth:`smoothing` says, is due to harmonics above these, in floating point.

        ``omega``: the frequency [rad/s]; ``count``: how many harmonics are not; ``whole``: for each row.
        """
        inner = self.responses(omega, count)[0] - self.doubles[3]
        low = (np.abs(inner) ** 2).sum(axis=2)
        left = whole**2 - 2 * low.sum(axis=0) + low[0]
        return float(np.sqrt(np.clip(left / np.maximum(whole, 1e-300) ** 2, 0, 1)).max())

    def response(self, omega: Fraction, harmonic: int) -> acb_mat:
        """From a harmonic of ``(nu, w)`` to that of ``(sigma, z)``, in balls.

        ``omega``: the frequency [rad/s]; ``harmonic``: which.
        """
        at = acb(0, ball(omega * harmonic))
        at = at.exp() if self.discrete else at
        inward = [[*left, *right] for left, right in zip(self.B.tolist(), self.E.tolist(), strict=True)]
        direct = acb_mat([[*left, *right] for left, right in zip(self.D.tolist(), self.F.tolist(), strict=True)])
        left = acb_mat(
            [[at * (i == j) - acb(arb(v)) for j, v in enumerate(row)] for i, row in enumerate(self.A.tolist())]
        )
        return acb_mat(self.C.tolist()) * left.solve(acb_mat(inward)) + direct

    def smoothing(self, omega: Fraction) -> list[arb]:
        r"""For each row of ``(sigma, z)``, ``D nu`` left out, what it is at most where ``nu`` has the mean square 1.

        .. math:: |y(t)| \le \|g\| \Big(\int_0^T |\nu|^2\Big)^{1/2}, \quad g(t) = c\, e^{At} (1 - e^{AT})^{-1} B, \quad
            \int_0^T |g|^2 = \mathrm{tr}\, M' (X - e^{A'T} X e^{AT}) M, \quad A'X + X A = -c'c,

        ``M = (1 - e^(AT))^-1 B``: the periodic solution is the convolution with ``g`` over a period.

        ``omega``: the frequency [rad/s]; 0 for constant signals.
        """
        with working_precision(_BITS):
            return self._smoothing(omega)

    def _smoothing(self, omega: Fraction) -> list[arb]:
        rows = self.C.nrows()
        if not omega or self.discrete:
            constant = self.response(Fraction(0), 0)
            inner = [[constant[i, j].real - arb(self.D[i, j]) for j in range(self.channels)] for i in range(rows)]
            return [sum((v * v for v in row), arb(0)).sqrt() for row in inner]
        T = 2 * arb.pi() / ball(omega)
        A, B = arb_mat(self.A.tolist()), arb_mat(self.B.tolist())
        E = (A * T).exp()
        one = arb_mat([[arb(i == j) for j in range(self.order)] for i in range(self.order)])
        try:
            begun = (one - E).solve(B)  # of the periodic response to an impulse in every period
            ended, gramians = E * begun, self.observability
        except ZeroDivisionError:
            return self._summed(omega)
        found = list[arb]()
        for X in gramians:
            energy = (begun.transpose() * X * begun).trace() - (ended.transpose() * X * ended).trace()
            found.append((T * energy.nonnegative_part()).sqrt())
        return found

    def _summed(self, omega: Fraction) -> list[arb]:
        r"""The same where ``A`` has eigenvalues ``s`` and ``-s``: ``(sum |G(i k omega)|^2)^(1/2)``, part of it bounded.

        ``|c (s - A)^{-1} B| <= |c B|/|s| + |c A| |B|/(|s| (|s| - |A|))`` for ``|s| > |A|``.
        """
        rows, at = range(self.C.nrows()), ball(omega)
        A, B, C = (arb_mat(side.tolist()) for side in (self.A, self.B, self.C))
        a, b = (_length(side.tolist()) for side in (A, B))
        last = max(_SUMMED, math.ceil(float(2 * a / at)))
        if last > _MOST_SUMMED:
            return [arb("inf")] * len(rows)
        total = [arb(0)] * len(rows)
        for k in range(last + 1):
            whole = self.response(omega, k)
            for r in rows:
                size = sum((abs(whole[r, i] - arb(self.D[r, i])) ** 2 for i in range(self.channels)), arb(0))
                total[r] += size * (2 if k else 1)
        found, direct, through = list[arb](), C * B, C * A
        for r, part in enumerate(total):
            size = _length([direct.tolist()[r]]) + _length([through.tolist()[r]]) * b / (at * last - a)
            found.append((part + 2 * size**2 / (at**2 * last)).sqrt())  # sum of 1/k^2 beyond the last: below 1/last
        return found

    @cached_property
    def observability(self) -> list[arb_mat]:
        """For each row ``c`` of ``C`` the ``X`` with ``A'X + X A = -c'c``, in balls."""
        n = self.order
        pairs = [(i, j) for i in range(n) for j in range(i + 1)]
        at = {pair: k for k, pair in enumerate(pairs)} | {(j, i): k for k, (i, j) in enumerate(pairs)}
        A = self.A.tolist()
        left = [[fmpq(0)] * len(pairs) for _ in pairs]
        for k, (i, j) in enumerate(pairs):
            for h in range(n):
                left[k][at[h, j]] += A[h][i]
                left[k][at[i, h]] += A[h][j]
        right = [[-row[i] * row[j] for row in self.C.tolist()] for i, j in pairs]
        solved = arb_mat(left).solve(arb_mat(right))
        rows = range(self.C.nrows())
        return [arb_mat([[solved[at[i, j], r] for j in range(n)] for i in range(n)]) for r in rows]


def _length(rows: Sequence[Sequence[arb]]) -> arb:
    """The square root of the sum of all squares."""
    return sum((v * v for row in rows for v in row), arb(0)).sqrt()


def _sides(H: MultivariablePlant, performance: Performance | None) -> list[fmpq_mat]:
    """``Bw``, ``Cz``, ``Dzw``, ``Dzmu`` and ``Dsigmaw``."""
    n, m = H.order, H.inputs
    if performance is None:
        return [_flint(rows, shape) for rows, shape in ((H.B, (n, m)), (H.C, (m, n)), *[(H.D, (m, m))] * 3)]
    if isinstance(performance.beside(H), ChannelFamily):
        raise InputError("performance holds parameters, and steady responses are of one plant; give numbers")
    p, q = performance.inputs, performance.outputs
    shapes = {"Bw": (n, p), "Cz": (q, n), "Dzw": (q, p), "Dzmu": (q, m), "Dsigmaw": (m, p)}
    return [_flint(getattr(performance, name), shape) for name, shape in shapes.items()]


def _flint(rows: Rows | Sequence[Sequence[Fraction]], shape: tuple[int, int]) -> fmpq_mat:
    """The matrix; zeros where none is given."""
    if not rows or not shape[1]:
        return fmpq_mat(*shape)
    return fmpq_mat([[to_fmpq(v) for v in row] for row in rows])


def _stacked(top: fmpq_mat, bottom: fmpq_mat) -> fmpq_mat:
    rows = top.tolist() + bottom.tolist()
    return fmpq_mat(rows) if rows and rows[0] else fmpq_mat(len(rows), top.ncols())


def _doubles(side: fmpq_mat) -> Reals:
    rows = [[int(v.p) / int(v.q) for v in row] for row in side.tolist()]
    return np.array(rows, dtype=float).reshape(side.nrows(), side.ncols())

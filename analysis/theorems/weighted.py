"""Multipliers for a decay rate, weighed by its powers, Zames-Falb ones by linear programmes: in floating point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from lure.analysis.deadline import checkpoint
from lure.analysis.theorems.fir import NORM, SampledResponse
from lure.arrays import NDArray, Reals, np, optimize
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Multiplier = dict[str, Any]
_THIN = 16  # of the frequencies of a response, every so manieth to begin with
_ROUNDS = 12
_LEAST = 1e-10  # relative to |G + 1/w|: less is rounding
_DIGITS = 10**12
_WORTH = 1e-6
_SMALL = 1e-9
_ON_THE_AXIS = 1e-12  # of the largest pole: nearer ones are poles on the axis


@described(frozen=True, kw_only=True, slots=True)
class WeightedTaps:
    r"""The search for ``M(z) = 1 - sum h_i z^-i`` with ``Re[M(z) (G(r z) + 1/w)] > 0`` on the circle.

    .. math:: \sum |h_i|\, r^i \le 1, \qquad \sum |h_i|\, r^{-i} \le 1,

    with ``h_i >= 0`` unless ``phi`` is odd; see ``docs/theory/rates.md``.
    """

    plant: RationalPlant = quantity("In discrete time")
    lower: Fraction = quantity("The slopes are those in ``[lower, lower + width]``; ``G = H/(1 + lower H)``")
    width: Fraction
    odd: bool = quantity("Whether taps may be negative")

    sizes: ClassVar[tuple[int, ...]] = (1, 2, 5, 10)

    @property
    def polynomials(self) -> tuple[list[Fraction], list[Fraction]]:
        """Numerator and denominator of ``G``, descending, of one length."""
        bottom = list(self.plant.denominator)
        top = [Fraction(0)] * (len(bottom) - len(self.plant.numerator)) + list(self.plant.numerator)
        return top, [d + self.lower * n for n, d in zip(top, bottom, strict=True)]

    def response(self, rate: float) -> SampledResponse | None:
        """``G(r z)`` on the circle; None where a pole is not inside, or so close that a sample meets it."""
        top, bottom = self.polynomials
        powers = rate ** np.arange(len(bottom) - 1, -1, -1.0)
        n, d = (np.array([float(c) for c in side]) * powers for side in (top, bottom))
        if np.max(np.abs(np.roots(d)), initial=0.0) >= 1 - _ON_THE_AXIS:
            return None
        sampled = SampledResponse.of(n, d)
        return sampled if np.isfinite(sampled.at(sampled.omega)).all() else None

    def multiplier(self, rate: float, size: int) -> Multiplier | None:
        """Taps up to a shift that seem to serve a rate, the margin being as large as it can; None if none do.

        ``size``: the largest ``|i|``.
        """
        found, _ = self.taps(rate, size)
        return None if found is None else {"taps": [[i, str(h)] for i, h in found.items()]}

    def margin(self, rate: float, size: int) -> float:
        """How far the taps serve a rate; negative or 0, how much they lack.

        ``size``: the largest ``|i|``.
        """
        return self.taps(rate, size)[1]

    def taps(self, rate: float, length: int) -> tuple[dict[int, Fraction] | None, float]:
        """Taps up to a shift and their margin; None if none serve.

        ``length``: the largest ``|i|``.
        """
        response = self.response(rate)
        if response is None:
            return None, -1.0
        shifts = np.array([i for i in range(-length, length + 1) if i], dtype=float)
        inverse, omega = 1 / float(self.width), response.omega[::_THIN]
        for _ in range(_ROUNDS):
            checkpoint()
            found, margin = self._programme(response.at(omega) + inverse, omega, shifts, rate)
            if found is None:
                return None, margin

            def violation(at: Reals, h: Reals = found) -> Reals:
                """How far the inequality fails."""
                G = response.at(at) + inverse
                M = 1 - np.exp(-1j * at[:, None] * shifts) @ h
                return np.asarray(-(M * G).real / np.abs(G))

            worst, peaks = response.maximum(violation)
            if worst < 0:
                cut = (math.trunc(h * _DIGITS) for h in found.tolist())
                taps = {int(i): Fraction(h, _DIGITS) for i, h in zip(shifts, cut, strict=True) if h}
                return taps, min(margin, -worst)
            fresh = np.setdiff1d(peaks, omega)
            if not fresh.size:
                break
            omega = np.union1d(omega, fresh)
        return None, 0.0

    def _programme(
        self, G: NDArray[np.complex128], omega: Reals, shifts: Reals, rate: float
    ) -> tuple[Reals | None, float]:
        """The taps with the largest margin at these frequencies, and it; None if it is none."""
        scale = np.abs(G)
        rows = (np.exp(-1j * np.outer(omega, shifts)) * G[:, None]).real / scale[:, None]
        masses = np.array([rate**shifts, rate**-shifts])
        if self.odd:
            rows, masses = np.hstack([rows, -rows]), np.hstack([masses, masses])
        count = rows.shape[1]
        x, margin = _optimum(
            np.vstack([np.column_stack([rows, np.ones(len(omega))]), np.column_stack([masses, np.zeros(2)])]),
            np.concatenate([G.real / scale, [NORM, NORM]]),
            [(0, None)] * count + [(None, 1)],
        )
        if x is None:
            return None, margin
        x = np.clip(x[:count], 0, None)
        return np.asarray(x[: count // 2] - x[count // 2 :] if self.odd else x), margin


@described(frozen=True, kw_only=True, slots=True)
class WeightedKernels:
    r"""The search for ``M(s) = 1 + theta s - sum c_j h_j``, ``h_j = a/(a + s)`` or ``a/(a - s)``.

    ``Re[M (G(s - rate) + 1/w)] > 0`` on the axis, ``sum |c_j| h_j(rate) <= 1 + theta rate`` and ``sum |c_j| h_j(-rate)
    <= 1 - theta rate``; see ``docs/theory/rates.md``.  Attributes are those of :class:`WeightedTaps`, in continuous
    time.
    """

    plant: RationalPlant = quantity("In continuous time")
    lower: Fraction = quantity("The slopes are those in ``[lower, lower + width]``")
    width: Fraction
    odd: bool = quantity("Whether kernels may be negative")

    sizes: ClassVar[tuple[int, ...]] = (0, 6)

    def multiplier(self, rate: float, size: int) -> Multiplier | None:
        """A weight ``theta`` and kernels that seem to serve a rate; None if none do.

        ``rate``: the rate [1/s]; ``size``: how many rates of kernels there are, each on both sides.
        """
        return self._sought(rate, size)[0]

    def margin(self, rate: float, size: int) -> float:
        """How far they serve a rate; negative or 0, how much they lack.

        ``rate``: the rate [1/s]; ``size``: how many rates of kernels there are, each on both sides.
        """
        return self._sought(rate, size)[1]

    def _sought(self, rate: float, size: int) -> tuple[Multiplier | None, float]:
        """Both."""
        bottom = np.array([float(c) for c in self.plant.denominator])
        top = np.concatenate(
            [np.zeros(len(bottom) - len(self.plant.numerator)), [float(c) for c in self.plant.numerator]]
        )
        below = bottom + float(self.lower) * top
        poles = np.roots(below)
        scale = float(np.abs(poles).max(initial=rate)) or 1.0
        if np.max(poles.real, initial=-math.inf) >= -rate - _ON_THE_AXIS * scale:
            return None, -1.0
        steps = [Fraction(v).limit_denominator(1000) for v in scale * np.geomspace(0.1, 30, size)]
        rates = [Fraction(rate).limit_denominator(1000) + Fraction(1, 500) + step for step in steps]
        basis = [(a, side) for a in rates for side in (1, -1)]

        def response(omega: Reals) -> NDArray[np.complex128]:
            """``G(i omega - rate)``."""
            s = 1j * omega - rate
            return np.asarray(np.polyval(top, s) / np.polyval(below, s))

        near = [abs(p.imag) + np.linspace(-5, 5, 101) * abs(p.real + rate) for p in poles]
        fine = np.unique(np.abs(np.concatenate([[0.0], scale * np.geomspace(1e-4, 1e4, 3000), *near])))
        omega = fine[::_THIN]
        for _ in range(_ROUNDS):
            checkpoint()
            found, margin = self._programme(response(omega), omega, basis, rate, scale)
            if found is None:
                return None, margin
            values = self._rows(response(fine), fine, basis, scale) @ found
            if values.min() > 0:
                return self._written(found, basis), min(margin, float(values.min()))
            least = np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1)) & (values < _LEAST))
            fresh = np.setdiff1d(np.append(fine[least], fine[int(values.argmin())]), omega)
            if not fresh.size:
                break
            omega = np.union1d(omega, fresh)
        return None, 0.0

    def _rows(
        self, G: NDArray[np.complex128], omega: Reals, basis: Sequence[tuple[Fraction, int]], scale: float
    ) -> Reals:
        """``Re[M (G + 1/w)]`` of 1, of ``theta`` and of each ``c``, over its size."""
        whole = G + 1 / float(self.width)
        kernels = [-float(a) / (float(a) + 1j * side * omega) * whole for a, side in basis]
        signed = [-one for one in kernels] if self.odd else []
        rows = np.stack([whole, 1j * omega * G, *kernels, *signed], axis=1).real
        return np.asarray(rows / (np.abs(whole) * (1 + omega / scale))[:, None])

    def _programme(
        self,
        G: NDArray[np.complex128],
        omega: Reals,
        basis: Sequence[tuple[Fraction, int]],
        rate: float,
        scale: float,
    ) -> tuple[Reals | None, float]:
        """1, ``theta`` and the ``c`` with the largest margin at these frequencies, and it; None if it is none."""
        rows = self._rows(G, omega, basis, scale)
        weights = [[float(a) / (float(a) + side * s) for a, side in basis] for s in (rate, -rate)]
        masses = np.array([[-rate, *weights[0]], [rate, *weights[1]]])
        if self.odd:
            masses = np.hstack([masses, masses[:, 1:]])
        count = masses.shape[1]
        x, margin = _optimum(
            np.vstack([np.column_stack([-rows[:, 1:], np.ones(len(omega))]), np.column_stack([masses, [0, 0]])]),
            np.concatenate([rows[:, 0], [NORM, NORM]]),
            [(None, None)] + [(0, None)] * (count - 1) + [(None, 1)],
        )
        return (None if x is None else np.concatenate([[1.0], x[:1], np.clip(x[1:count], 0, None)])), margin

    def _written(self, found: Reals, basis: Sequence[tuple[Fraction, int]]) -> Multiplier:
        """The multiplier of a certificate, rounded towards 0."""
        cut = [Fraction(math.trunc(float(v) * _DIGITS), _DIGITS) for v in found[1:]]
        c = cut[1 : len(basis) + 1]
        if self.odd:
            c = [plus - minus for plus, minus in zip(c, cut[len(basis) + 1 :], strict=True)]
        kernels = [
            {"coefficient": str(v), "rate": str(a), "order": 1, "side": "causal" if side > 0 else "anticausal"}
            for v, (a, side) in zip(c, basis, strict=True)
            if abs(v) > _SMALL
        ]
        return {"theta": str(cut[0]), "kernels": kernels}


@described(frozen=True, kw_only=True)
class WeightedCircle:
    r"""The circle criterion at a rate, in floating point: ``Re[p q^*] > 0`` where ``p = d + u n`` and ``q = d + l n``.

    Of the weighted plant, with all roots of ``q`` inside.  At its least value the polynomial is flat or at an end, so
    that no frequencies are sampled.
    """

    plant: RationalPlant = quantity("The plant, in either time")
    lower: Fraction = quantity("Lower end of the sector")
    upper: Fraction = quantity("Upper end of the sector")

    @cached_property
    def _sides(self) -> tuple[Reals, Reals, float]:
        """``p`` and ``q`` without a rate, over their largest parts; how large a root of ``q`` is, or its real part."""
        n, d = self.plant.numerator, self.plant.denominator
        top = [Fraction(0)] * (len(d) - len(n)) + [*n]
        sums = ([Fraction(b) + gain * t for b, t in zip(d, top, strict=True)] for gain in (self.upper, self.lower))
        p, q = (np.array([float(v / (max(map(abs, side)) or 1)) for v in side]) for side in sums)
        roots = np.roots(q)
        return p, q, float(np.max(roots.real if self.plant.dt is None else np.abs(roots), initial=-math.inf))

    def margin(self, rate: float) -> float:
        """The least ``Re[p q^*]``, over what its terms add up to without their signs; ``-inf`` if ``q`` is unstable."""
        (p, q, largest), discrete = self._sides, self.plant.dt is not None
        if largest >= (rate if discrete else -rate):
            return -math.inf
        p, q = (_paced(side, rate, discrete=discrete) for side in (p, q))
        if discrete:  # sum c_k cos(k omega), and cos(k omega) are Chebyshev's polynomials of cos omega
            lags = np.correlate(p, q, "full")
            c = lags[len(p) - 1 :] + np.concatenate([[0.0], lags[: len(p) - 1][::-1]])
            where, value, size = np.polynomial.chebyshev.chebroots, np.polynomial.chebyshev.chebval, np.abs(c).sum()
            flat, ends = where(np.polynomial.chebyshev.chebder(c)) if len(c) > 2 else np.zeros(0), (-1.0, 1.0)
            x = np.append(np.clip(flat.real, -1, 1), ends)
            return float(np.min(value(x, c)) / size)
        turn = 1j ** np.arange(len(p))[::-1]
        whole = np.polymul(p * turn, np.conj(q * turn)).real[::2]  # even in omega
        x = np.append(np.maximum(np.roots(np.polyder(whole)).real, 0), 0.0)
        at, least = (np.asarray(np.polyval(c, x)) for c in (whole, np.abs(whole)))  # both are 0 for a root of p at 0
        values = np.append(at / np.where(least > 0, least, 1.0), np.sign(whole[0]))
        return float(np.min(values))


def _optimum(A: Reals, b: Reals, bounds: Sequence[tuple[float | None, float | None]]) -> tuple[Reals | None, float]:
    """The ``x`` with ``A x <= b`` whose last entry, the margin, is the largest, and it; None if it is none.

    With a pole on the axis, where entries are infinite, nothing is served.
    """
    if not (np.all(np.isfinite(A)) and np.all(np.isfinite(b))):
        return None, -1.0
    result = optimize.linprog(
        np.append(np.zeros(A.shape[1] - 1), -1.0),
        A_ub=A,
        b_ub=b,
        bounds=bounds,
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    x = result.x
    if x is None or not np.all(np.isfinite(x)):
        return None, -_LEAST
    return (np.asarray(x), float(x[-1])) if x[-1] > _LEAST else (None, min(float(x[-1]), -_LEAST))


def _paced(p: Reals, rate: float, *, discrete: bool) -> Reals:
    """``p(r z)`` or ``p(s - a)``, descending."""
    powers = np.arange(len(p) - 1, -1, -1)
    return p * rate**powers if discrete else np.poly1d(p)(np.poly1d([1.0, -rate])).coeffs


def closest(
    search: WeightedTaps | WeightedKernels, end: float, easy: float, close: float, *, proved: bool
) -> tuple[float, int] | None:
    """The rate nearest to ``end`` that seems to be served, and by a multiplier of which size; None for none.

    Parameters
    ----------
    search : WeightedTaps or WeightedKernels
        The search.
    end : float
        Beyond it nothing is true.
    easy : float
        Where to begin: proved already, or what shows least.
    close : float
        How near to end.
    proved : bool
        Whether ``easy`` is proved already: then only what is nearer counts.
    """
    best: tuple[float, int] | None = None
    for size in search.sizes:
        start = easy if best is None else best[0]
        first = start + _WORTH * (end - start) if proved or best is not None else start
        ahead = search.margin(first, size)
        if ahead <= 0:
            continue
        served = first
        if abs(first - end) > close:
            margins = {first: ahead, end: min(search.margin(end, size), -_LEAST)}  # beyond it nothing is true

            def margin(rate: float, size: int = size, margins: dict[float, float] = margins) -> float:
                """The same, looked at once."""
                if rate not in margins:
                    margins[rate] = search.margin(rate, size) or -_LEAST
                return margins[rate]

            optimize.brentq(margin, first, end, xtol=close / 2, rtol=1e-12)
            served = min((rate for rate, found in margins.items() if found > 0), key=lambda rate: abs(rate - end))
        best = served, size
        if abs(served - end) <= 2 * close:
            break
    return best

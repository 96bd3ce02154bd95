"""Zames-Falb taps for a decay rate, weighed by powers of it: linear programmes propose, in floating point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from lure.analysis.deadline import checkpoint
from lure.analysis.theorems.fir import NORM, SampledResponse
from lure.arrays import NDArray, Reals, np, optimize
from lure.plants.rational import RationalPlant

LENGTHS = (1, 2, 5, 10)
_THIN = 16  # of the frequencies of a response, every so manieth to begin with
_ROUNDS = 12
_LEAST = 1e-10  # relative to |G + 1/w|: less is rounding
_DIGITS = 10**12
_WORTH = 1e-6


@dataclass(frozen=True, kw_only=True, slots=True)
class WeightedTaps:
    r"""The search for ``M(z) = 1 - sum h_i z^-i`` with ``Re[M(z) (G(r z) + 1/w)] > 0`` on the circle.

    .. math:: \sum |h_i|\, r^i \le 1, \qquad \sum |h_i|\, r^{-i} \le 1,

    with ``h_i >= 0`` unless ``phi`` is odd; see ``docs/theory/rates.md``.

    Attributes
    ----------
    plant : RationalPlant
        In discrete time.
    lower, width : Fraction
        The slopes are those in ``[lower, lower + width]``; ``G = H/(1 + lower H)``.
    odd : bool
        Whether taps may be negative.
    """

    plant: RationalPlant
    lower: Fraction
    width: Fraction
    odd: bool

    @property
    def polynomials(self) -> tuple[list[Fraction], list[Fraction]]:
        """Numerator and denominator of ``G``, descending, of one length."""
        bottom = list(self.plant.denominator)
        top = [Fraction(0)] * (len(bottom) - len(self.plant.numerator)) + list(self.plant.numerator)
        return top, [d + self.lower * n for n, d in zip(top, bottom, strict=True)]

    def response(self, rate: float) -> SampledResponse | None:
        """``G(r z)`` on the circle; None where a pole is not inside."""
        top, bottom = self.polynomials
        powers = rate ** np.arange(len(bottom) - 1, -1, -1.0)
        n, d = (np.array([float(c) for c in side]) * powers for side in (top, bottom))
        if np.max(np.abs(np.roots(d)), initial=0.0) >= 1:
            return None
        return SampledResponse.of(n, d)

    def taps(self, rate: float, length: int) -> dict[int, Fraction] | None:
        """Taps up to a shift that seem to serve a rate, the margin being as large as it can; None if none do.

        Parameters
        ----------
        rate : float
            The rate.
        length : int
            The largest ``|i|``.
        """
        response = self.response(rate)
        if response is None:
            return None
        shifts = np.array([i for i in range(-length, length + 1) if i], dtype=float)
        inverse, omega = 1 / float(self.width), response.omega[::_THIN]
        for _ in range(_ROUNDS):
            checkpoint()
            found = self._programme(response.at(omega) + inverse, omega, shifts, rate)
            if found is None:
                return None

            def violation(at: Reals, h: Reals = found) -> Reals:
                """How far the inequality fails."""
                G = response.at(at) + inverse
                M = 1 - np.exp(-1j * at[:, None] * shifts) @ h
                return np.asarray(-(M * G).real / np.abs(G))

            worst, peaks = response.maximum(violation)
            if worst < 0:
                cut = (math.trunc(h * _DIGITS) for h in found.tolist())
                return {int(i): Fraction(h, _DIGITS) for i, h in zip(shifts, cut, strict=True) if h}
            fresh = np.setdiff1d(peaks, omega)
            if not fresh.size:
                return None
            omega = np.union1d(omega, fresh)
        return None

    def _programme(self, G: NDArray[np.complex128], omega: Reals, shifts: Reals, rate: float) -> Reals | None:
        """The taps with the largest margin at these frequencies; None if it is none."""
        scale = np.abs(G)
        rows = (np.exp(-1j * np.outer(omega, shifts)) * G[:, None]).real / scale[:, None]
        masses = np.array([rate**shifts, rate**-shifts])
        if self.odd:
            rows, masses = np.hstack([rows, -rows]), np.hstack([masses, masses])
        count = rows.shape[1]
        result = optimize.linprog(
            np.append(np.zeros(count), -1.0),
            A_ub=np.vstack([np.column_stack([rows, np.ones(len(omega))]), np.column_stack([masses, np.zeros(2)])]),
            b_ub=np.concatenate([G.real / scale, [NORM, NORM]]),
            bounds=[(0, None)] * count + [(None, 1)],
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if result.x is None or not np.all(np.isfinite(result.x)) or result.x[-1] <= _LEAST:
            return None
        x = np.clip(np.asarray(result.x[:count]), 0, None)
        return np.asarray(x[: count // 2] - x[count // 2 :] if self.odd else x)

    def best(self, low: float, high: float, close: float, lengths: Sequence[int] = LENGTHS) -> tuple[float, int] | None:
        """The smallest rate within ``[low, high]`` that seems to be served, and by which length; None for none.

        Parameters
        ----------
        low, high : float
            Where to look.
        close : float
            How near to end.
        lengths : sequence of int
            The largest shifts to try, ascending; the last ones only while they help.
        """
        best: tuple[float, int] | None = None
        for length in lengths:
            top = high if best is None else best[0]
            if best is None and self.taps(top, length) is None:
                continue
            if best is not None and self.taps(top - _WORTH * (top - low), length) is None:
                continue
            bottom = low
            while top - bottom > close:
                middle = 0.5 * (bottom + top)
                if self.taps(middle, length) is None:
                    bottom = middle
                else:
                    top = middle
            if best is None or top < best[0]:
                best = top, length
            if best[0] - low <= 2 * close:
                break
        return best

"""Search, in floating point, for the taps of a finite impulse response multiplier: proposals, never evidence."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq_poly

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.unit_circle import DiscretePlant
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.trigonometric import Laurent, nonnegative_on_circle, positive_on_circle
from lure.arrays import NDArray, Reals, np, optimize
from lure.record import described, quantity

# Multipliers of finite impulse response with exact taps, and the exact test of the Zames-Falb inequality.

Taps = Mapping[int, Fraction]


@dataclass(frozen=True, kw_only=True, slots=True)
class Multiplier:
    r"""``M(z) = 1 - sum_i h_i z^-i`` with exact taps ``h_i``, ``i != 0``.

    Raises
    ------
    ValueError
        A tap at shift 0.
    """

    taps: Taps

    def __post_init__(self) -> None:
        if 0 in self.taps:
            raise ValueError("Multiplier.taps holds the shift 0; its coefficient is 1")

    def legal(self, *, odd: bool) -> bool:
        """Whether ``sum |h_i| < 1`` and, unless ``phi`` is odd, every ``h_i >= 0``."""
        return sum(abs(h) for h in self.taps.values()) < 1 and (odd or all(h >= 0 for h in self.taps.values()))

    @property
    def laurent(self) -> Laurent:
        """As a Laurent polynomial."""
        reach = max((abs(i) for i in self.taps), default=0)
        coefficients = [to_fmpq(-self.taps.get(reach - j, Fraction(0))) for j in range(2 * reach + 1)]
        coefficients[reach] = to_fmpq(1)
        return Laurent(fmpq_poly(coefficients), reach)

    def __str__(self) -> str:
        parts = ["M(z) = 1"]
        for i, h in sorted(self.taps.items()):
            power = "z" if i == -1 else f"z^{-i}"
            parts.append(f"{'-' if h > 0 else '+'} {float(abs(h)):.8g} {power}")
        return " ".join(parts)


def inequality(discrete: DiscretePlant, multiplier: Multiplier, width: Fraction | None) -> fmpq_poly:
    """``|d|^2 Re[M (H + 1/width)]`` on the circle as a polynomial in ``cos w``; without ``1/width`` if it is None.

    With a simple pole at ``z = 1`` it is divided by ``1 - cos w``.
    """
    sum_ = discrete.cross
    if width is not None:
        sum_ = sum_ + (discrete.d * discrete.d.conjugate()).scaled(1 / width)
    found = (multiplier.laurent * sum_).real_part()
    return found // fmpq_poly([1, -1]) if discrete.critical else found


def certifies(discrete: DiscretePlant, multiplier: Multiplier, width: Fraction, *, odd: bool) -> bool:
    r"""Whether the multiplier proves the classes of slopes in ``[0, width]`` stable for ``H``, decided exactly.

    Parameters
    ----------
    discrete : DiscretePlant
        The block.
    multiplier : Multiplier
        Any taps.
    width : Fraction
        Upper slope, positive.
    odd : bool
        Whether ``phi`` is known to be odd.
    """
    return (
        width > 0
        and multiplier.legal(odd=odd)
        and discrete.well_posed(width)
        and positive_on_circle(inequality(discrete, multiplier, width))
    )


def certifies_every(discrete: DiscretePlant, multiplier: Multiplier, *, odd: bool) -> bool:
    """The same for every finite width at once: ``Re[M H] >= 0``, since ``Re M > 0``."""
    return (
        multiplier.legal(odd=odd)
        and discrete.feedthrough >= 0
        and nonnegative_on_circle(inequality(discrete, multiplier, None))
    )


NORM = 1 - 1e-9
COARSE, FINE = 200, 4000
ZOOMS, ZOOM_POINTS = 5, 17
ROUNDS = 40
RELATIVE_STEP = 1e-11


@described(frozen=True, slots=True)
class SampledResponse:
    """``H(exp(i w))`` in floating point, on a grid of the upper half circle that is denser where a pole is near."""

    numerator: Reals = quantity("Descending powers of ``z``")
    denominator: Reals = quantity("Descending powers of ``z``")
    omega: Reals = quantity("Frequencies [rad per sample], ascending, 0 and pi included")

    @classmethod
    def of(cls, numerator: Reals, denominator: Reals, *, least: float = 0.0) -> SampledResponse:
        """The response of ``numerator / denominator`` from the frequency ``least`` on."""
        parts = [np.linspace(0, np.pi, FINE)]
        spread = np.concatenate([-np.logspace(-3, 2, 60)[::-1], [0.0], np.logspace(-3, 2, 60)])
        for pole in np.roots(denominator):
            parts.append(abs(np.angle(pole)) + max(abs(1 - abs(pole)), 1e-12) * spread)
        return cls(numerator, denominator, np.unique(np.clip(np.concatenate(parts), least, np.pi)))

    def at(self, omega: Reals) -> NDArray[np.complex128]:
        """``H`` at these frequencies; not finite where a pole is too near for doubles."""
        z = np.exp(1j * omega)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return np.asarray(np.polyval(self.numerator, z) / np.polyval(self.denominator, z))

    def maximum(self, f: Callable[[Reals], Reals]) -> tuple[float, Reals]:
        """The largest value of ``f`` seen, refined between grid points, and the frequencies of its local maxima.

        Values that are not numbers are passed over.
        """

        def g(omega: Reals) -> Reals:
            """The function to be maximised, ``-inf`` where it is not a number."""
            found = f(omega)
            return np.where(np.isnan(found), -np.inf, found)

        values = g(self.omega)
        padded = np.concatenate([[-np.inf], values, [-np.inf]])
        peaks = np.flatnonzero((values > padded[:-2]) & (values >= padded[2:]))
        left = self.omega[np.maximum(peaks - 1, 0)]
        right = self.omega[np.minimum(peaks + 1, len(values) - 1)]
        inside = np.linspace(0, 1, ZOOM_POINTS)
        rows = np.arange(len(peaks))
        found = self.omega[peaks]
        for _ in range(ZOOMS):
            mesh = left[:, None] + (right - left)[:, None] * inside
            best = np.argmax(g(mesh.ravel()).reshape(mesh.shape), axis=1)
            found = mesh[rows, best]
            left, right = mesh[rows, np.maximum(best - 1, 0)], mesh[rows, np.minimum(best + 1, ZOOM_POINTS - 1)]
        tight = np.concatenate([found, self.omega[peaks]])
        return float(np.max(g(tight), initial=-np.inf)), tight


@dataclass(frozen=True, kw_only=True, slots=True)
class Proposal:
    """Taps ``h_i`` at the shifts ``i`` of ``M(z) = 1 - sum h_i z^-i``, and the ``1/k`` they seem to reach.

    ``tight`` are the frequencies at which ``-Re[M H]/Re[M]`` has its highest local maxima.
    """

    shifts: tuple[int, ...]
    taps: Reals
    inverse: float
    tight: Reals


def evaluated(response: SampledResponse, shifts: tuple[int, ...], taps: Reals) -> Proposal:
    """The proposal of these taps: ``1/k`` above the largest ``-Re[M H]/Re[M]``, refined between grid points."""
    used = np.flatnonzero(taps)
    where = np.asarray(shifts, dtype=float)[used]

    def ratio(omega: Reals) -> Reals:
        """``1/k`` that each frequency asks for; ``inf`` where the multiplier cannot serve it."""
        M = 1 - np.exp(-1j * omega[:, None] * where) @ taps[used]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            value = -(M * response.at(omega)).real / M.real
        return np.asarray(np.where(M.real > 0, value, np.inf))

    inverse, tight = response.maximum(ratio)
    return Proposal(shifts=shifts, taps=taps, inverse=inverse, tight=tight)


def best_taps(response: SampledResponse, length: int, *, odd: bool, start: Proposal | None = None) -> Proposal:
    r"""Taps at shifts up to ``length`` either way that minimise ``max_w -Re[M H]/Re[M]``, with ``sum |h_i| < 1``.

    Dinkelbach's method: at the present ``1/k`` a linear program over the taps maximises ``t`` in
    ``Re[M (H + 1/k)] >= t Re[M_present]/k`` at a few frequencies; the local maxima of the ratio then join them.

    Parameters
    ----------
    response : SampledResponse
        The block.
    length : int
        Largest shift.
    odd : bool
        Whether taps may be negative.
    start : Proposal, optional
        Where to begin, of at most this length; the circle criterion (no taps) without it.

    Returns
    -------
    Proposal
        Never worse than ``start``.
    """
    shifts = tuple(i for i in range(-length, length + 1) if i)
    taps = np.zeros(len(shifts))
    if start is not None:
        for i, value in zip(start.shifts, start.taps, strict=True):
            taps[shifts.index(i)] = value
    best = evaluated(response, shifts, taps)
    active = np.union1d(np.linspace(response.omega[0], np.pi, COARSE), best.tight)
    for _ in range(ROUNDS):
        checkpoint()
        found = _linear_program(response.at(active) + best.inverse, active, best, odd=odd)
        if found is None:
            break
        trial = evaluated(response, shifts, found)
        step = best.inverse - trial.inverse
        fresh = np.setdiff1d(trial.tight, active)
        if step > 0:
            best = trial
        if step <= RELATIVE_STEP * abs(best.inverse) and (step > 0 or not fresh.size):
            break
        active = np.union1d(active, fresh)
    return best


def _linear_program(G: NDArray[np.complex128], omega: Reals, best: Proposal, *, odd: bool) -> Reals | None:
    omega, G = omega[np.isfinite(G)], G[np.isfinite(G)]
    if not math.isfinite(best.inverse):
        return None
    shifted = np.exp(-1j * np.outer(omega, best.shifts))
    scale = np.abs(G) + abs(best.inverse)
    scale[scale == 0] = 1.0
    rows = (shifted * G[:, None]).real / scale[:, None]
    if odd:
        rows = np.hstack([rows, -rows])
    weight = np.maximum((1 - shifted @ best.taps).real, 1e-9) * abs(best.inverse) / scale
    count = rows.shape[1]
    result = optimize.linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.vstack([np.column_stack([rows, weight]), np.append(np.ones(count), 0.0)]),
        b_ub=np.append(G.real / scale, NORM),
        bounds=[(0, None)] * count + [(None, None)],
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if result.x is None or not np.all(np.isfinite(result.x)):
        return None
    x = np.clip(np.asarray(result.x[:count]), 0, None)
    x *= min(1.0, NORM / max(float(x.sum()), NORM))
    return np.asarray(x[: count // 2] - x[count // 2 :] if odd else x)

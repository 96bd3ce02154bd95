"""The dual of the Zames-Falb search in continuous time: a slope that no multiplier with a Popov term reaches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, fmpq_poly

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.inequality.polynomial import RationalInequality
from lure.analysis.numerics.doubles import double_above, text_above
from lure.analysis.numerics.polynomial import to_fraction
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.theorems.kernel_search import Scaled, around
from lure.arrays import NDArray, Reals, np, optimize
from lure.exact import Exact, exact_number
from lure.plants.rational import RationalPlant
from lure.record import Record, derived, described, quantity

TITLE = "the limit of the criterion of Zames and Falb"
BITS = 96
BOXES = 400_000
HARMONICS = 40_000
STEPS = (6, 8, 10, 12, 14)  # the comb begins at the unit of the plant over 2^6, and is refined
CLOSE = 1e-3  # of what is proved: then the comb is fine enough
TOLERANCE = 1e-4  # of the bisection
FAR = 1e9  # in place of every slope, in the units of the plant
STEPS_UP = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1)
ROUNDS = 60
OVER = 16  # samples a shortest period
LEAST = 1e-9  # of the slack: less is none
_OPTIONS = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


class MultiplierLimit(Record):
    r"""Frequencies ``n w_0`` and weights that rule out every Zames-Falb multiplier for the slopes ``[lower, k]``.

    It bounds the reach of a criterion.  It does not show that a loop is unstable.
    """

    k: Fraction = quantity("No multiplier proves ``[lower, k]``, nor any larger class", plainly=str)
    odd: bool = quantity("Whether the multipliers are those for odd ``phi``, with kernels of either sign")
    lower: Fraction = quantity("Lower end of the classes", plainly=str)
    base: Fraction = quantity("``w_0``", "rad/s", plainly=str)
    harmonics: tuple[int, ...] = quantity("``n``, positive")
    weights: tuple[Fraction, ...] = quantity(
        "Weight of each, positive", plainly=lambda weights: [str(weight) for weight in weights]
    )

    @property
    @derived()
    def frequencies(self) -> tuple[float, ...]:
        """The frequencies ``n w_0`` [rad/s]."""
        return tuple(float(n * self.base) for n in self.harmonics)

    def __str__(self) -> str:
        kind = "odd nonlinearities" if self.odd else "monotone nonlinearities"
        return (
            f"No multiplier of Zames and Falb with a Popov term proves {kind} with slopes in [{self.lower}, k] for any "
            f"k from {text_above(float(self.k))} on (weights at {len(self.harmonics)} frequencies, certified); whether "
            "these loops are stable is another question."
        )


def multiplier_limit(
    block: RationalPlant, *, odd: bool, lower: Exact = 0, above: float = 0.0, below: float = math.inf
) -> MultiplierLimit | None:
    r"""A slope from which no Zames-Falb multiplier with a Popov term proves anything, in continuous time.

    The multipliers of :func:`.zames_falb_largest` are ``M = 1 - int exp(-i w tau) dm(tau)`` with ``|m| <= 1``, of which
    ``m >= 0`` unless ``phi`` is odd, beside ``i w theta``.  With ``F = H + 1/(k - lower)``, ``w_r = n_r w_0`` and
    weights ``a_r >= 0``, not all 0, let

    .. math:: \sum_r a_r w_r\, \mathrm{Im}\, F(i w_r) = 0, \qquad
        g_{\pm}(\tau) = \sum_r a_r\, \mathrm{Re}\,[(1 \mp e^{-i w_r \tau}) F(i w_r)] \le 0
        \quad\text{for all } \tau

    (``g_-`` for odd ``phi`` only).  The mean of ``g_+`` over a period is ``sum a_r Re F <= 0``, and the sum of the
    left-hand side ``Re[M F + i w theta H]`` with these weights is a mean of that and of ``g(tau)``: not positive,
    whatever the multiplier, here and for every larger ``k`` [1]_ [2]_.

    Parameters
    ----------
    block : RationalPlant
        In continuous time; with the gain ``lower`` stable, or with a simple pole at 0.
    odd : bool
        Which multipliers.
    lower : number
        Lower end of the classes.
    above : float
        A slope that is proved, from which on is searched; 0 if none is known.
    below : float
        A limit that is known: one that is not lower is not looked for.

    Returns
    -------
    MultiplierLimit or None
        None if none was found, which means nothing.  What is found has passed :func:`rules_out`.

    Raises
    ------
    AssumptionError, InputError
        The plant is none that the criterion is for.

    References
    ----------
    .. [1] U. Jonsson, M.-C. Laiou, Stability analysis of systems with nonlinearities, 35th IEEE Conf. Decision and
       Control (1996).
    .. [2] S. Wang, J. Carrasco, W. P. Heath, Phase limitations of Zames-Falb multipliers, IEEE Trans. Automatic
       Control 63 (2018).

    Examples
    --------
    >>> block = RationalPlant([-1, 0, 0], [1, Fraction("0.2"), 6, Fraction("0.1"), 1])
    >>> limit = multiplier_limit(block, odd=True, above=1.3424)
    >>> 1.3424 < limit.k < 1.3429
    True
    """
    start = exact_number(lower, "lower")
    plant = RationalInequality.of(block, start, TITLE, critical=True).plant
    if plant.d.degree() == 0 or plant.n.degree() < 0:
        return None
    scaled = Scaled.of(plant)
    reach = float((Fraction(max(above, float(start))) - start) * scaled.gain)
    most = math.inf if below == math.inf else float((Fraction(below) - start) * scaled.gain)
    best: MultiplierLimit | None = None
    comb, known = None, (reach, most)
    for step in STEPS:
        comb = Comb.of(scaled, step, odd=odd, coarser=comb)
        found = comb.lowest(*known)
        if found is None:
            continue
        limit = _settled(plant, scaled, comb, found, start)
        if limit is not None and (best is None or limit.k < best.k):
            best = limit
        if found[0] <= reach * (1 + CLOSE) or known[1] <= found[0] * (1 + CLOSE):
            break
        known = reach, found[0]
    return best if best is None or best.k < below else None


def _settled(
    plant: TransferPolynomials, scaled: Scaled, comb: Comb, found: tuple[float, dict[int, float]], lower: Fraction
) -> MultiplierLimit | None:
    """The limit with exact weights, at the slope found or a little above it, that has passed the check."""
    width, weights = found
    base = comb.base * scaled.unit
    harmonics = tuple(sorted(weights))
    values = [_response(plant, n * base) for n in harmonics]
    exact = _balanced([Fraction(weights[n]) for n in harmonics], harmonics, [im for _, im in values])
    if exact is None:
        return None
    for step in STEPS_UP:
        k = lower + Fraction(double_above(Fraction(width * (1 + step)) / scaled.gain))
        limit = MultiplierLimit(k=k, odd=comb.odd, lower=lower, base=base, harmonics=harmonics, weights=exact)
        if _excluded(limit, values):
            return limit
    return None


def _balanced(
    weights: list[Fraction], harmonics: Sequence[int], imaginary: list[Fraction]
) -> tuple[Fraction, ...] | None:
    """The weights with one of them changed, so that ``sum a n Im F = 0`` exactly; None if none can be."""
    moments = [a * n * y for a, n, y in zip(weights, harmonics, imaginary, strict=True)]
    surplus = sum(moments, Fraction(0))
    if surplus == 0:
        return tuple(weights)
    against = [i for i, moment in enumerate(moments) if moment * surplus < 0]
    if not against:
        return None
    i = max(against, key=lambda j: abs(moments[j]))
    changed = weights[i] - surplus / (harmonics[i] * imaginary[i])
    return (*weights[:i], changed, *weights[i + 1 :]) if changed > 0 else None


# The check: exact, but for the sign of trigonometric polynomials over one period, which balls decide.


def rules_out(block: RationalPlant, limit: MultiplierLimit) -> bool:
    """Whether weights rule out every multiplier, from the plant and these numbers alone; ``limit``: what is claimed.

    Raises
    ------
    AssumptionError, InputError
        The plant is none that the criterion is for.
    """
    plant = RationalInequality.of(block, limit.lower, TITLE, critical=True).plant
    sizes = {len(limit.harmonics), len(limit.weights), len(set(limit.harmonics))}
    legal = limit.base > 0 and limit.k > limit.lower and len(sizes) == 1 and bool(limit.harmonics)
    if not (legal and min(limit.harmonics) >= 1 and min(limit.weights) > 0):
        return False
    return _excluded(limit, [_response(plant, n * limit.base) for n in limit.harmonics])


def _response(plant: TransferPolynomials, omega: Fraction) -> tuple[Fraction, Fraction]:
    """``H(i w)``, exactly."""
    (a, b), (c, d) = (_on_axis(p, omega) for p in (plant.n, plant.d))
    square = c * c + d * d
    return (a * c + b * d) / square, (b * c - a * d) / square


def _on_axis(p: fmpq_poly, omega: Fraction) -> tuple[Fraction, Fraction]:
    parts = [Fraction(0)] * 4
    for i, c in enumerate(p.coeffs()):
        parts[i % 4] += to_fraction(c) * omega**i
    return parts[0] - parts[2], parts[1] - parts[3]


def _excluded(limit: MultiplierLimit, values: list[tuple[Fraction, Fraction]]) -> bool:
    inverse = 1 / (limit.k - limit.lower)
    terms = [
        (n, a * (re + inverse), a * im) for n, a, (re, im) in zip(limit.harmonics, limit.weights, values, strict=True)
    ]
    if sum((n * y for n, _, y in terms), Fraction(0)) != 0 or sum((x for _, x, _ in terms), Fraction(0)) > 0:
        return False
    # g_+ vanishes at 0 with its derivative: near 0 its sign is that of the second derivative
    bend = sum((n * n * x for n, x, _ in terms), Fraction(0))
    if bend >= 0:
        return False
    third = sum((n**3 * (abs(x) + abs(y)) for n, x, y in terms), Fraction(0))
    away = -bend / third  # |g'''| <= third, so that g'' < 0 closer to 0 than this
    with working_precision(BITS):
        wave = _Wave.of(terms)
        end = 2 * arb.pi() - ball(away)
        if not wave.at_most_zero(ball(away), end, sign=1):
            return False
        return not limit.odd or wave.at_most_zero(arb(0), 2 * arb.pi(), sign=-1)


@dataclass(frozen=True, slots=True)
class _Wave:
    """``sum x (1 -+ cos n t) -+ y sin n t`` in balls, with a bound on its second derivative."""

    terms: tuple[tuple[int, arb, arb], ...]
    mean: arb
    bend: arb

    @classmethod
    def of(cls, terms: list[tuple[int, Fraction, Fraction]]) -> _Wave:
        """From multiples of a frequency and their two coefficients."""
        balls = tuple((n, ball(x), ball(y)) for n, x, y in terms)
        bend = sum((n * n * (x * x + y * y).sqrt() for n, x, y in balls), arb(0))
        return cls(balls, sum((x for _, x, _ in balls), arb(0)), bend.upper())

    def at_most_zero(self, low: arb, high: arb, *, sign: int) -> bool:
        """Whether it is not positive from one end to the other; False where that stays open."""
        left, right = low.lower(), high.upper()
        count = 2 * max(n for n, _, _ in self.terms)
        ends = [(left + (right - left) * i / count).mid() for i in range(1, count)]
        boxes = list(zip([left, *ends], [*ends, right], strict=True))
        for _ in range(BOXES):
            if not boxes:
                return True
            a, b = boxes.pop()
            middle, half = ((a + b) / 2).mid(), ((b - a) / 2).upper()
            value, slope = self.mean, arb(0)
            for n, x, y in self.terms:
                s, c = (n * middle).sin_cos()
                value -= sign * (x * c + y * s)
                slope += n * (x * s - y * c)
            half += abs((a + b) / 2 - middle).upper()
            if value + (abs(slope) + self.bend * half / 2) * half <= 0:
                continue
            if value > 0:
                return False
            boxes += [(a, middle), (middle, b)]
        return False


# The search, in doubles: a linear programme over frequencies and delays, both added where they help.


@described(slots=True)
class Comb:
    """Multiples of one frequency, in the units of :class:`.Scaled`, and the programme for their weights."""

    base: Fraction = quantity("The frequency")
    harmonics: NDArray[np.int64] = quantity("The multiples that may have weights, ascending")
    values: NDArray[np.complex128] = quantity("``H`` there")
    odd: bool = quantity("Which multipliers are to be ruled out")
    columns: NDArray[np.int64] = quantity("Places in ``harmonics`` that the programme has")
    angles: Reals = quantity("The delays of its rows, times ``base``, in ``(-pi, pi)``")

    @classmethod
    def of(cls, scaled: Scaled, step: int, *, odd: bool, coarser: Comb | None) -> Comb:
        """The comb of the unit over ``2^step``; delays and frequencies of a coarser one are kept."""
        search = scaled.search("none")
        base = Fraction(1, 2**step)
        high = min(search.far / 3, float(HARMONICS * base))
        near = around(search.poles, 120)
        omega = np.concatenate([np.geomspace(search.low / 20, high, 300), near[near < high]])
        n = np.unique(np.round(omega / float(base)).astype(int))
        if high / float(base) < 1000:
            n = np.arange(1, int(high / float(base)) + 1)
        angles = np.pi * np.geomspace(1e-3, 1, 12) / max(int(search.unit / float(base)), 1)
        angles = np.concatenate([angles, -angles])
        columns = np.arange(0, len(n), max(len(n) // 80, 1))
        if coarser is not None:
            ratio = float(base / coarser.base)
            held = np.round(coarser.harmonics[coarser.columns] / ratio).astype(int)
            n = np.unique(np.concatenate([n, *(held + i for i in range(-6, 7))]))
            columns, angles = np.searchsorted(n, held), np.concatenate([angles, coarser.angles * ratio])
        keep = n > 0
        columns = np.unique(columns - np.count_nonzero(~keep))
        n = n[keep]
        return cls(base, n, search.response(n * float(base)), odd, columns[columns >= 0], angles)

    def lowest(self, reach: float, most: float) -> tuple[float, dict[int, float]] | None:
        """The smallest width found at which weights rule out all multipliers, and these; None if there is none."""
        if self.weights(min(most, FAR)) is None:
            return None
        low, best = reach, None
        trial = max(reach, 1e-6) * (1 + CLOSE / 2)
        growth = 4 * CLOSE
        while best is None:
            high = min(trial, most * (1 - CLOSE / 2))
            if high <= low:
                return None
            found = self.weights(high)
            if found is not None:
                best = high, found
            elif high < trial or trial > FAR:
                return None
            else:
                low, trial, growth = high, trial * (1 + growth), min(4 * growth, 8.0)
        while best[0] > max(low, 1e-12) * (1 + TOLERANCE) and best[0] > reach * (1 + CLOSE / 4):
            middle = math.sqrt(max(low, 1e-12) * best[0])
            found = self.weights(middle)
            if found is None:
                low = middle
            else:
                best = middle, found
        return best

    def weights(self, width: float) -> dict[int, float] | None:
        """Weights over harmonics that seem to rule out all multipliers at this width; None if there are none."""
        for _ in range(ROUNDS):
            checkpoint()
            solved = self._solve(width)
            if solved is None:
                return None
            slack, weights, price = solved
            if slack < LEAST:
                new = self._dearer(price)
                if new.size == 0:
                    return None
                self.columns = np.union1d(self.columns, new)
                continue
            peaks, worst = self._peaks(weights, width, slack)
            if worst <= 0:
                return {int(self.harmonics[i]): float(a) for i, a in weights.items()}
            self.angles = np.unique(np.concatenate([self.angles, peaks]))
            new = self._dearer(price)
            self.columns = np.union1d(self.columns, new)
        return None

    def _sampled(self, places: NDArray[np.int64], width: float) -> tuple[Reals, Reals, NDArray[np.complex128]]:
        F = self.values[places] + 1 / width
        return np.asarray(self.harmonics[places], dtype=float), np.abs(F), F

    def _rows(self, places: NDArray[np.int64], width: float) -> tuple[Reals, Reals]:
        """``g`` over its scale for every delay and harmonic, its second derivative at 0 last, and the moments."""
        n, size, F = self._sampled(places, width)
        unit = 1 / float(self.base)
        turns = np.outer(self.angles, n)
        wave = np.cos(turns) * F.real + np.sin(turns) * F.imag
        rows = (F.real - wave) / np.minimum(1, (unit * self.angles) ** 2)[:, None]
        parts = [rows, (F.real + wave)] if self.odd else [rows]
        parts.append((n / unit)[None, :] ** 2 * F.real)
        return np.vstack(parts) / size, n / unit * F.imag / size

    def _solve(self, width: float) -> tuple[float, dict[int, float], Reals] | None:
        """The slack, weights over places, and what a unit of every harmonic would cost."""
        rows, moments = self._rows(self.columns, width)
        count = len(self.columns)
        result = optimize.linprog(
            np.append(np.zeros(count), -1.0),
            A_ub=np.column_stack([rows, np.ones(len(rows))]),
            b_ub=np.zeros(len(rows)),
            A_eq=np.vstack([np.append(np.ones(count), 0.0), np.append(moments, 0.0)]),
            b_eq=[1.0, 0.0],
            bounds=[(0, None)] * count + [(None, None)],
            method="highs-ds",
            options=_OPTIONS,
        )
        if result.status != 0:
            return None
        prices = -np.asarray(result.ineqlin.marginals)
        used = np.flatnonzero(prices > 0)
        every, turning = self._priced(used, prices, width)
        cost = every - result.eqlin.marginals[0] - result.eqlin.marginals[1] * turning
        size = np.abs(self.values[self.columns] + 1 / width)
        held = {
            int(place): float(x / s) for place, x, s in zip(self.columns, result.x[:-1], size, strict=True) if x > 1e-12
        }
        return float(result.x[-1]), held, cost

    def _priced(self, used: NDArray[np.int64], prices: Reals, width: float) -> tuple[Reals, Reals]:
        """The rows in use, weighted by their prices, and the moments, for every harmonic."""
        places = np.arange(len(self.harmonics))
        n, size, F = self._sampled(places, width)
        unit, count = 1 / float(self.base), len(self.angles)
        total = np.zeros(len(places))
        for row in used:
            if row == (1 + self.odd) * count:
                total += prices[row] * (n / unit) ** 2 * F.real
                continue
            angle = self.angles[row % count]
            wave = np.cos(angle * n) * F.real + np.sin(angle * n) * F.imag
            scale = min(1.0, (unit * angle) ** 2) if row < count else 1.0
            total += prices[row] * (F.real - wave if row < count else F.real + wave) / scale
        return total / size, n / unit * F.imag / size

    def _dearer(self, cost: Reals) -> NDArray[np.int64]:
        """Harmonics that would raise the slack, at the local minima of their cost."""
        padded = np.concatenate([[math.inf], cost, [math.inf]])
        least = np.flatnonzero((cost <= padded[:-2]) & (cost < padded[2:]) & (cost < -1e-9))
        least = least[np.argsort(cost[least])][:12]
        return np.asarray(np.setdiff1d(least, self.columns))

    def _peaks(self, weights: dict[int, float], width: float, slack: float) -> tuple[Reals, float]:
        """Angles of the highest peaks of ``g``, and the highest value less a part of the slack."""
        places = np.array(list(weights))
        n, _, F = self._sampled(places, width)
        x, y = (np.array(list(weights.values())) * part for part in (F.real, F.imag))
        count = OVER * int(n.max())
        fine = np.pi * np.linspace(-1, 1, count + 1)[1:]
        wave = np.zeros(count)
        for m, c, s in zip(n, x, y, strict=True):
            turned = np.exp(1j * (fine * m))
            wave += c * turned.real + s * turned.imag
        angles: list[Reals] = []
        worst = -math.inf
        for sign in (1, -1) if self.odd else (1,):
            value = x.sum() - sign * wave
            inner = np.flatnonzero((value >= np.roll(value, 1)) & (value > np.roll(value, -1)) & (value > -0.1))
            at = self._refined(fine[inner], n, (sign * x, sign * y), 2 * math.pi / count)
            if sign == 1:
                at = at[np.abs(at) > 1e-3 * float(self.base)]
            turns = np.outer(at, n)
            height = x.sum() - sign * (np.cos(turns) @ x + np.sin(turns) @ y)
            height /= np.minimum(1, (at / float(self.base)) ** 2) if sign == 1 else 1.0
            high = np.argsort(-height)[:25]
            high = high[height[high] > -0.9 * slack]
            angles.append(at[high])
            worst = max(worst, float(np.max(height, initial=-math.inf)))
        return np.concatenate(angles), worst

    @staticmethod
    def _refined(angles: Reals, n: Reals, parts: tuple[Reals, Reals], step: float) -> Reals:
        """Maxima of ``-(x cos n t + y sin n t)`` near these angles, by Newton's method."""
        x, y = parts
        at = angles.copy()
        for _ in range(4):
            turns = np.outer(at, n)
            slope = np.sin(turns) @ (n * x) - np.cos(turns) @ (n * y)
            bend = np.cos(turns) @ (n * n * x) + np.sin(turns) @ (n * n * y)
            with np.errstate(divide="ignore", invalid="ignore"):
                move = np.where(bend < 0, -slope / bend, 0.0)
            at = np.clip(at + np.clip(move, -step / 2, step / 2), angles - step, angles + step)
        return at

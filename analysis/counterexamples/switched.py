"""Switched gains in discrete time: a gain that jumps between the ends of the sector so that the loop grows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType
from typing import cast

from flint import arb_mat

from lure.analysis.counterexamples.linear import (
    Exponential,
    Realisation,
    balls,
    companion,
    linear_witness,
    refutes_lower,
)
from lure.analysis.counterexamples.orbit import shifted_block
from lure.analysis.counterexamples.periodic_discrete import SECTOR_PERIODS, proposals, searched_lower
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.gains import hurwitz_limit, simplest_between
from lure.analysis.inequality.plant import TransferPolynomials
from lure.analysis.numerics.doubles import double_above
from lure.analysis.numerics.polynomial import positive_root_count, real_roots, to_fmpq
from lure.analysis.numerics.precision import ball, outward, working_precision
from lure.analysis.verdict import Evidence, Witness
from lure.arrays import NDArray, Reals, in_doubles, np, optimize
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.record import described, quantity
from lure.record.values import exact_text

# The search for a switched gain that makes a loop grow, in floating point: a proposal, never a proof.

MAX_SWITCHES = 12
RUNGS = 45
ROUNDING = 1e-12
MAX_EXPONENTIALS = 60_000  # up to order 5, then fewer: a few seconds
GRID_COST = 1_500  # a grid of 48 x 48 products, in exponentials


@dataclass(frozen=True, slots=True)
class Pattern:
    """Durations in which the gain is ``lower, k, lower, k, ...``, and the ``k`` at which the loop starts to grow."""

    times: Reals
    k: float


@described(frozen=True, slots=True)
class SwitchingSearch:
    """The search for one block."""

    system: Realisation = quantity("The block")
    lower: Fraction = quantity("Lower gain")
    circle: float = quantity("Where the circle criterion stops: nothing below it is worth a search")
    omega: float = quantity("At which frequency it stops there", "rad/s")
    limit: float = quantity("The first gain that is itself unstable: nothing at or above it is wanted")
    spent: list[int] = quantity(
        "Matrix exponentials computed so far; past a limit nothing grows any more, and the search ends with what it "
        "has",
        default_factory=lambda: [0],
        hidden=True,
    )
    known: dict[float, Exponential] = quantity(
        "Exponentials of the closed-loop matrices by gain", default_factory=dict, hidden=True
    )

    def closed(self, k: float) -> Exponential:
        """Of ``A - b c k/(1 + k d)``, remembered: it is computed exactly and asked for again and again."""
        if k not in self.known:
            self.known[k] = Exponential(in_doubles(self.system.closed(Fraction(k))))
        return self.known[k]

    def growth(self, times: Reals, k: float) -> float:
        """Logarithm of the spectral radius over the period, per unit of time; ``-inf`` once the work is used up.

        What may be rounding is none: over short periods, or with a pole on the axis, it would seem to grow.
        """
        self.spent[0] += len(times)
        checkpoint()
        if self.spent[0] * max(1, self.system.order // 3) > MAX_EXPONENTIALS:
            return -math.inf
        radius = _radius(self.transition(times, k))
        if not 0 < radius < math.inf:
            return -math.inf
        grown = math.log(radius)
        return grown / float(times.sum()) if abs(grown) > ROUNDING else 0.0

    def transition(self, times: Reals, k: float) -> Reals:
        """The matrix of one period."""
        pair = self.closed(float(self.lower)), self.closed(k)
        product = np.eye(self.system.order)
        with np.errstate(all="ignore"):
            steps = [one.over(times[i::2]) for i, one in enumerate(pair)]
            for i in range(len(times)):
                product = steps[i % 2][i // 2] @ product
        return product

    def run(self) -> Pattern | None:
        """The pattern with the smallest ``k`` found, or None."""
        if not self.circle < math.inf:
            return None
        floor, best = float(self.lower), None
        reach = self.circle - floor if self.circle > floor else 1e-3 * min(self.limit - floor, 1.0)
        for i in range(1, RUNGS):
            k = min(floor + reach * 1.3**i, self.limit)
            best = self.two_times(k)
            if best is not None or k >= self.limit:
                break
        if best is None:
            return None
        for _ in range(6):
            polished = self.polish(best)
            richer = self.more_switches(polished)
            settled = richer is None or richer.k > polished.k * (1 - 1e-7)
            best = polished if richer is None or richer.k > polished.k else richer
            if settled:
                break
        return best if best.k < self.limit else None

    def above(self, k: float, factor: float) -> float:
        """``lower + (k - lower) factor``."""
        return float(self.lower) + (k - float(self.lower)) * factor

    def two_times(self, k: float) -> Pattern | None:
        """The two durations found with the largest growth, if the loop grows with them."""
        starts = [self.best_of_grid(k)]
        if self.omega > 0:  # the gain turns twice as fast as the solution
            starts.append(np.full(2, math.pi / (2 * self.omega)))
        found = max((self.faster(times, k) for times in starts), key=lambda times: self.growth(times, k))
        return Pattern(found, k) if self.growth(found, k) > 0 else None

    def best_of_grid(self, k: float) -> Reals:
        """The two durations of a grid with the largest growth."""
        self.spent[0] += GRID_COST
        pair = self.closed(float(self.lower)), self.closed(k)
        rates = np.abs(np.concatenate([one.values for one in pair]))
        rates = rates[rates > 1e-6 * rates.max()]
        times = np.geomspace(0.05 / rates.max(), 8 / rates.min(), 48)
        with np.errstate(all="ignore"):
            low, high = (one.over(times) for one in pair)
            products = np.einsum("aij,bjk->abik", high, low)
            finite = np.isfinite(products).all(axis=(-1, -2))
            radius = np.abs(np.linalg.eigvals(np.where(finite[..., None, None], products, 0.0))).max(axis=-1)
            rate = np.nan_to_num(np.log(radius) / (times[:, None] + times[None, :]), nan=-np.inf)
        j, i = np.unravel_index(int(rate.argmax()), rate.shape)
        return np.array([times[i], times[j]])

    def faster(self, times: Reals, k: float) -> Reals:
        """Times near the given ones with the largest growth."""

        def slowness(logarithms: Reals) -> float:
            """Negative growth, for a minimiser."""
            return -self.growth(np.exp(logarithms), k) if np.abs(logarithms).max() < 60 else math.inf

        options = {"xatol": 1e-7, "fatol": 1e-14, "maxiter": 150 * len(times)}
        found: Reals = optimize.minimize(slowness, np.log(times), method="Nelder-Mead", options=options).x
        return np.exp(found)

    def polish(self, pattern: Pattern) -> Pattern:
        """Lower ``k`` with the times fixed, then better the times with ``k`` fixed, until neither helps."""
        for _ in range(12):
            k = self.threshold(pattern)
            times = self.faster(pattern.times, k)
            done = abs(k - pattern.k) <= 1e-10 * abs(k)
            pattern = Pattern(times, k)
            if done:
                break
        return Pattern(pattern.times, self.threshold(pattern))

    def threshold(self, pattern: Pattern) -> float:
        """Where the growth with these times vanishes, at or below the pattern's ``k``."""
        high, low = pattern.k, max(self.circle, self.above(pattern.k, 0.5))
        while self.growth(pattern.times, low) > 0 and low > self.circle:
            high, low = low, max(self.circle, self.above(low, 0.5))
        if low >= high or not self.growth(pattern.times, low) < 0 < self.growth(pattern.times, high):
            return pattern.k
        return float(
            optimize.brentq(lambda k: self.growth(pattern.times, k), low, high, xtol=1e-13 * (high - low), rtol=1e-13)
        )

    def more_switches(self, pattern: Pattern) -> Pattern | None:
        """A pattern with a smaller ``k`` that the switching function leads to, or None."""
        best = None
        for repeat in (1, 2):
            times = np.tile(pattern.times, repeat)
            bins = _Bins(self, pattern.k, float(times.sum()), 120)
            richer = bins.improved(times)
            if richer is None or len(richer) > MAX_SWITCHES:
                continue
            richer = self.faster(richer, pattern.k)
            if self.growth(richer, pattern.k) > 0:
                candidate = Pattern(richer, self.threshold(Pattern(richer, pattern.k)))
                best = candidate if best is None or candidate.k < best.k else best
        return best


class _Bins:
    """One period cut into equal bins, each with one of the two gains."""

    def __init__(self, search: SwitchingSearch, k: float, period: float, count: int) -> None:
        self.edges = period * (np.arange(count) + 0.5) / count
        self.width = period / count
        with np.errstate(all="ignore"):
            self.steps = [search.closed(gain).over(self.width) for gain in (float(search.lower), k)]

    def improved(self, times: Reals) -> Reals | None:
        """Durations after the gain of every bin has been given the sign of the switching function, while that helps."""
        choice = (np.searchsorted(np.cumsum(times), self.edges, side="right") % 2).astype(int)
        radius, slope = self.slope(choice)
        first = choice
        for _ in range(30):
            for share in (1.0, 0.3, 0.1, 0.03):
                gain = np.where(choice == 1, -slope, slope)  # of changing the bin
                flip = gain > np.quantile(gain, 1 - share) if share < 1 else gain > 0
                trial = np.where(flip & (gain > 0), 1 - choice, choice)
                better, derivative = self.slope(trial)
                if better > radius * (1 + 1e-12):
                    choice, radius, slope = trial, better, derivative
                    break
            else:
                break
        return None if choice is first else self.durations(choice)

    def slope(self, choice: NDArray[np.int_]) -> tuple[float, Reals]:
        """Spectral radius, and its first-order change if a bin went from ``lower`` to ``k``."""
        n = len(self.steps[0])
        before = [np.eye(n)]
        for c in choice:
            before.append(self.steps[c] @ before[-1])
        if not np.isfinite(before[-1]).all():
            return 0.0, np.zeros(len(choice))
        values, left, right = _eigenvectors(before[-1])
        at = int(np.abs(values).argmax())
        y, x, value = left[at], right[:, at], values[at]
        if not 0 < abs(value) < math.inf:
            return 0.0, np.zeros(len(choice))
        change = self.steps[1] - self.steps[0]
        slopes, row = np.empty(len(choice)), y
        for i in range(len(choice) - 1, -1, -1):
            slopes[i] = (np.conj(value) * (row @ change @ before[i] @ x)).real / abs(value)
            row = row @ self.steps[choice[i]]
        return float(abs(value)), slopes

    def durations(self, choice: NDArray[np.int_]) -> Reals | None:
        """Lengths of the runs, from the start of a run of ``lower``."""
        starts = np.flatnonzero((choice == 0) & (np.roll(choice, 1) == 1))
        if len(starts) == 0:
            return None
        turned = np.roll(choice, -int(starts[0]))
        edges = np.flatnonzero(np.diff(turned)) + 1
        return np.diff(np.concatenate([[0], edges, [len(turned)]])) * self.width


def _radius(matrix: Reals) -> float:
    """Spectral radius; 0 for a matrix that is not finite, so that it is never taken for growth."""
    return float(np.abs(np.linalg.eigvals(matrix)).max()) if np.isfinite(matrix).all() else 0.0


def _eigenvectors(matrix: Reals) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues, left eigenvectors as rows with ``y x = 1``, right eigenvectors as columns."""
    values, right = np.linalg.eig(matrix)
    left = np.linalg.pinv(right)
    return values.astype(complex), left.astype(complex), right.astype(complex)


# Switched gains that make a loop grow, proved in ball arithmetic.

MAX_ORDER = 24  # above it the companion form of doubles is no guide
SQUARINGS = 60
BITS = 320
_EXCESSES = [Fraction(1, 10**digits) for digits in (8, 7, 6, 5)]  # how far above k, relative
_NEAR = Fraction(1, 10**6), Fraction(1, 10**12)  # of the times: at the best ones the growth is flat


def switched_witness(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain that jumps periodically between ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -phi``, ``phi(t, sigma) = k(t) sigma``, the state over one period is multiplied by
    ``M = ... exp(A_k t_2) exp(A_lower t_1)``, ``A_k = A - b c k/(1 + k d)``.  If ``M`` has an eigenvalue outside the
    unit disc, some solution grows without bound, and no criterion for time-varying ``phi`` in the sector ``[lower, k]``
    (the circle criterion's class) can hold.  Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalPlant
        In continuous time.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    Witness or None
        ``k`` is the smallest found, a rational just above the value where the growth of the best switching vanishes; it
        is not proved to be the smallest.  None: discrete time, order 0 or above 24, a loop that is already unstable at
        ``lower``, a block for which ``1/(k - lower) + Re H`` is positive for every ``k``, or nothing found below the
        first gain that is itself unstable.

    Notes
    -----
    Times and gains are looked for in floating point: the best of a grid of two times, then the switching function
    (derivative of the spectral radius by the gain at each instant) decides where to add switches, then the times are
    refined and ``k`` is lowered.  The result is CERTIFIED: if all eigenvalues of ``M`` lay in the closed unit disc,
    ``|tr M^N| <= n`` for every ``N``; the opposite is shown in ball arithmetic for a power of two ``N``, for the exact
    rational times and gain.
    """
    if block.dt is not None or not 0 < block.order <= MAX_ORDER:
        return None
    plant = TransferPolynomials.of(block)
    if plant.shifted(lower).poles.right > 0:
        return None
    circle, omega = circle_reach(plant, lower)
    search = SwitchingSearch(companion(block), lower, circle, omega, hurwitz_limit(block, lower).high)
    with np.errstate(all="ignore"):  # products overflow where the loop grows fast; such values are never chosen
        found = search.run()
    return None if found is None else _certified(search.system, lower, found)


def circle_reach(plant: TransferPolynomials, lower: Fraction) -> tuple[float, float]:
    """Where the circle criterion stops, in doubles, and at which frequency: nothing below it is worth a search."""
    response = plant.shifted(lower).response
    slope = response.U.derivative() * response.D - response.U * response.D.derivative()
    if positive_root_count(response.D) > 0:
        return float(lower), math.sqrt(float(next(x for x in real_roots(response.D) if x > 0)))
    stationary = [float(x) for x in real_roots(slope) if x > 0] if slope.degree() > 0 else []
    values = [
        (float(response.U(at) / response.D(at)), float(at))
        for at in (to_fmpq(x) for x in (0.0, *stationary))
        if response.D(at) != 0
    ]
    least, x = min(values, default=(0.0, 0.0))
    return (float(lower) - 1 / least if least < 0 else math.inf), math.sqrt(x)


def growing(system: Realisation, gains: Sequence[Fraction], times: Sequence[Fraction]) -> bool:
    r"""Whether a loop with these gains for these times, over and over, is proved to have solutions that grow.

    ``gains``, ``times``: ``mu = -gain sigma`` for each time [s] in turn.

    Returns
    -------
    bool
        True is a proof that the matrix of one period has an eigenvalue outside the unit disc; False says nothing.
    """
    with working_precision(BITS):
        product = balls([[Fraction(int(i == j)) for j in range(system.order)] for i in range(system.order)])
        for gain, time in zip(gains, times, strict=True):
            product = (balls(system.closed(gain)) * ball(time)).exp() * product
        for _ in range(SQUARINGS):
            if abs(product.trace()) > system.order:
                return True
            product = product * product
    return False


def _certified(system: Realisation, lower: Fraction, found: Pattern) -> Witness | None:
    width = Fraction(found.k) - lower
    for excess, near in itertools.product(_EXCESSES, _NEAR):
        k = simplest_between(lower + width * (1 + excess / 2), lower + width * (1 + excess))
        times = [simplest_between(t * (1 - near), t * (1 + near)) for t in map(Fraction, found.times)]
        gains = [lower, k] * (len(times) // 2)
        if growing(system, gains, times):
            break
    else:
        return None
    period = float(sum(times))
    with working_precision(BITS):
        bound = outward(ball(k), ball(k)).high
    ends = f"{float(lower):g} and {float(k):.9g}"
    text = f"phi(t, sigma) = k(t) sigma, k(t) switching between {ends} with period {period:.6g} s"
    return Witness(
        kind="switched gain",
        k=bound,
        evidence=Evidence.CERTIFIED,
        slope_restricted=True,
        odd=True,
        time_varying=True,
        description=f"{text}: a solution grows without bound",
        data=MappingProxyType(
            {"lower": str(lower), "upper": str(k), "gains": [str(g) for g in gains], "times": [str(t) for t in times]}
        ),
    )


SWITCHED_DISCRETE_MAX_ORDER = 60  # above it the companion form in doubles is no guide
MAX_PERIOD = 10  # every pattern up to it is tried,
MAX_RUNS = 40  # and up to this one those of two runs
_LADDER = ((1e-9, 256), (1e-8, 1024), (1e-6, 1024), (1e-4, 4096))  # how far above k, and bits of the balls
_SQUARINGS = 48
_ROUNDS = 40
_GAIN = 1e-7  # relative: a smaller improvement is none


def switched_witness_discrete(block: RationalPlant, *, lower: Fraction = Fraction(0)) -> Witness | None:
    r"""A gain ``phi(t, sigma) = k(t) sigma`` that repeats a pattern of ``lower`` and ``k`` and makes the loop grow.

    For ``sigma = H mu``, ``mu = -k(t) sigma`` the state over one period is multiplied by ``M``, the product of
    ``A - b c k(t)/(1 + k(t) D)``.  If ``M`` has an eigenvalue outside the unit disc some solution grows without bound.
    Nothing is said about time-invariant ``phi``.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    lower : Fraction
        Lower end of the sector.

    Returns
    -------
    Witness or None
        CERTIFIED, ``k`` just above the smallest found, below the smallest destabilising linear gain; None if nothing
        was found, the loop is not stable at ``lower``, or the order is 0 or above 60.

    Raises
    ------
    InputError
        The block is in continuous time.

    Notes
    -----
    Candidates, in floating point: the patterns of periodic solutions in the sector of period up to 24, all patterns of
    period up to 10, two runs up to 40, and what changes of single samples reach from them.  If all eigenvalues of
    ``M`` lay in the closed unit disc, ``|tr M^N| <= n`` for every ``N``; the opposite is shown in ball arithmetic for
    a power of two ``N`` and the exact gains.
    """
    if block.dt is None:
        raise InputError("switched_witness_discrete needs a block in discrete time; give dt")
    lower = Fraction(lower)
    linear = linear_witness(block, lower=lower)
    if not 0 < block.order <= SWITCHED_DISCRETE_MAX_ORDER or refutes_lower(linear):
        return None
    lower = searched_lower(block, lower, linear)
    k = np.inf if linear is None else linear.k
    pattern: tuple[int, ...] = ()
    for proposal in proposals(shifted_block(block, lower), ("sector",), k - float(lower), tuple(SECTOR_PERIODS))[:1]:
        k = float(lower) + 1 / proposal.reach
        pattern = tuple(int(step > 1e-9) for step in proposal.mixture)
    system = companion(block)
    if np.isfinite(k):
        pattern, k = _improved(system, float(lower), k, pattern)
    return _switched_discrete_certified(system, lower, k, pattern) if pattern else None


def _improved(system: Realisation, lower: float, k: float, pattern: tuple[int, ...]) -> tuple[tuple[int, ...], float]:
    """The pattern that grows most at ``k``, and the lowest ``k`` at which it does by bisection, again and again."""
    listed = _necklaces(MAX_PERIOD) + _two_runs(MAX_RUNS)
    for _ in range(_ROUNDS):
        high = lower + (k - lower) * (1 - _GAIN)
        radius = _radii(system, sorted({*listed, *_changed(pattern)}, key=len), lower, high)
        best = max(radius, key=lambda found: radius[found])
        if not radius[best] > 1 + 1e-9:
            break
        pattern, low = best, lower
        for _ in range(50):
            middle = 0.5 * (low + high)
            if _radii(system, [best], lower, middle)[best] > 1:
                high = middle
            else:
                low = middle
        k = high
    return pattern, k


def _necklaces(longest: int) -> list[tuple[int, ...]]:
    """Every pattern of zeros and ones, neither constant, up to shifts and repetition."""
    found = []
    for p in range(2, longest + 1):
        checkpoint()
        for word in itertools.product((0, 1), repeat=p):
            if all(word < word[i:] + word[:i] for i in range(1, p)):
                found.append(word)
    return found


def _two_runs(longest: int) -> list[tuple[int, ...]]:
    """A run of zeros and a run of ones."""
    return [(0,) * zeros + (1,) * (p - zeros) for p in range(MAX_PERIOD + 1, longest + 1) for zeros in range(1, p)]


def _changed(pattern: tuple[int, ...]) -> list[tuple[int, ...]]:
    """The patterns one sample flipped, left out or repeated away."""
    parts = [(pattern[:i], pattern[i], pattern[i + 1 :]) for i in range(len(pattern))]
    return [
        head + middle + tail for head, g, tail in parts for middle in ((1 - g,), (), (g, g)) if head or middle or tail
    ]


def _radii(
    system: Realisation, patterns: Sequence[tuple[int, ...]], lower: float, k: float
) -> dict[tuple[int, ...], float]:
    """Spectral radius over one period, to the power of one over the period."""
    step = np.array([in_doubles(system.closed(Fraction(gain))) for gain in (lower, k)])
    result: dict[tuple[int, ...], float] = {}
    for p, group in itertools.groupby(patterns, key=len):
        words = list(group)
        product = step[[word[0] for word in words]]
        for t in range(1, p):
            product = step[[word[t] for word in words]] @ product
        radius = np.abs(np.linalg.eigvals(product)).max(axis=1) ** (1 / p)
        result.update(zip(words, radius.tolist(), strict=True))
    return result


def _switched_discrete_certified(
    system: Realisation, lower: Fraction, k: float, pattern: tuple[int, ...]
) -> Witness | None:
    for excess, bits in _LADDER:
        width = Fraction(k) - lower
        upper = simplest_between(lower + width * (1 + Fraction(excess) / 2), lower + width * (1 + Fraction(excess)))
        gains = [upper if g else lower for g in pattern]
        if not _grows(system, gains, bits):
            continue
        text = _runs(["k" if g else exact_text(lower, 10) for g in pattern])
        return Witness(
            kind="switched gain",
            k=double_above(upper),
            evidence=Evidence.CERTIFIED,
            slope_restricted=True,
            odd=True,
            time_varying=True,
            description=f"phi(t, sigma) = k(t) sigma, k(t) repeating {text}, k = {exact_text(upper, 10)}: "
            "solutions grow for ever",
            data={"k": str(upper), "lower": str(lower), "period": len(gains), "gains": [str(g) for g in gains]},
        )
    return None


def _runs(words: Sequence[str]) -> str:
    """The words, three and more alike together: ``0 k k``, ``5 times 0, 3 times k``."""
    runs = [(word, len(list(same))) for word, same in itertools.groupby(words)]
    if max(count for _, count in runs) < 3:
        return " ".join(words)
    return ", ".join(word if count == 1 else f"{count} times {word}" for word, count in runs)


def _grows(system: Realisation, gains: Sequence[Fraction], bits: int) -> bool:
    """Whether the product over one period is proved to have an eigenvalue outside the unit disc."""
    if any(1 + gain * system.d == 0 for gain in gains):
        return False
    with working_precision(bits):
        product = arb_mat([[int(i == j) for j in range(system.order)] for i in range(system.order)])
        for gain in gains:
            product = balls(system.closed(gain)) * product
        for _ in range(_SQUARINGS):
            if abs(product.trace()) > system.order:
                return True
            product = product * product
    return False


def verify_switched_discrete(block: RationalPlant, data: Mapping[str, object]) -> bool:
    """Whether the gains of a record lie in its ``[lower, k]`` and make the loop grow, proved in ball arithmetic.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    data : Mapping
        As in ``Witness.data`` of kind ``switched gain`` in discrete time: ``k``, ``lower``, ``gains`` as text ``p/q``.

    Returns
    -------
    bool
        False also if it could not be decided, or an entry is missing or is not a number.
    """
    try:
        k, lower = Fraction(cast("str", data["k"])), Fraction(cast("str", data["lower"]))
        gains = [Fraction(gain) for gain in cast("list[str]", data["gains"])]
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return False
    if block.dt is None or not gains or not all(lower <= gain <= k for gain in gains):
        return False
    return any(_grows(companion(block), gains, bits) for bits in (256, 1024, 4096))

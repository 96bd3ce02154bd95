"""Park's and Zames-Falb multipliers for plants with dead time: searched for in doubles, proved by the checkers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.delay import Delayed, DelayInequality, raised
from lure.analysis.inequality.protocol import Best, Grounds
from lure.analysis.numerics.doubles import text_above
from lure.analysis.theorems.criterion import LATE_CONCLUSIONS, Criterion
from lure.analysis.theorems.kernel_search import (
    NEAR_ZERO,
    TOLERANCE,
    Column,
    Family,
    Search,
    around,
    increasing,
    short,
)
from lure.analysis.theorems.kernels import Delay, Gamma, Side
from lure.analysis.theorems.park import PARK
from lure.analysis.theorems.zames_falb import kernel_criterion
from lure.analysis.verdict import Bracket, CriterionResult, Evidence
from lure.arrays import NDArray, Reals, np
from lure.plants.delay import DelayPlant
from lure.record import described, quantity

# For slopes in ``[0, k]`` and a plant with dead time ``H`` is stable, or has one simple pole at 0 besides.  The
# theorems ask for what they ask of rational plants (Zames and Falb 1968 is about convolution operators):
#
# .. math:: \mathrm{Re}[M(i\omega)(H(i\omega) + 1/k) + i\omega\theta H(i\omega)] \ge \delta > 0 .
#
# What is found here is a proposal.  Both checkers cover the axis by balls.

THEOREM = "{}; for convolution operators G. Zames and P. L. Falb, SIAM J. Control 6 (1968) 89-108"
STEPS, NARROW, BELOW, LEAST, LARGEST = 24, 1e-4, 4e-7, 1e-3, 1e6
TAUS = 25
KEPT = 0.01  # the same of |H + 1/k| where the phases of what comes late are kept
LEFT, LONGEST = 0.02, 12.0  # of 1/k beyond all frequencies, and the longest delay of a kernel: covers stay short
RATES, ORDERS = 13, (1, 3)
PHASES, MOST_PHASES, BEYOND = 16, 400, 1e3  # of what comes late, for its last dead time, and how far out
FAR_DELAYS = 20.0  # of the longest dead time: below, the phases of a kernel are searched


class _LateSearch(Search):
    """What the searches of loops with dead time share."""

    def _closed_loop(self, k: float) -> NDArray[np.complex128]:
        """Where ``|1 + k H|`` is small, as lightly damped roots."""
        omega = np.linspace(0, self.far / 2, 4000)[1:]
        size = np.abs(1 + k * self.response(omega))
        near = np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] <= size[2:]) & (size[1:-1] < 1)) + 1
        return np.asarray(omega[near] * (1j - 1e-2 * size[near]))


@dataclass(slots=True)
class DelayedSearch(_LateSearch):
    """The linear programme of :class:`.Search` with the response of a plant with dead time.

    Attributes
    ----------
    plant : DelayPlant
        The plant; ``numerator`` holds that of its first term, for the frequencies to look at.
    """

    plant: DelayPlant = field(kw_only=True)

    @classmethod
    def of(cls, plant: DelayPlant, family: Family, *, odd: bool) -> DelayedSearch:
        """The search for a plant, with kernels of some kind."""
        numerator, denominator = (np.array([float(c) for c in p]) for p in (plant.terms[0][1], plant.denominator))
        return cls(numerator, denominator, odd=odd, family=family, plant=plant)

    def __post_init__(self) -> None:
        Search.__post_init__(self)
        latest = max(float(delay) for delay, _ in (*self.plant.terms, *self.plant.feedback))
        self.far = max(self.far, FAR_DELAYS / latest) if latest else self.far
        if self.plant.feedback:
            at_rest = self.plant.denominator[-1] + sum(q[-1] for _, q in self.plant.feedback) == 0
            self.drift = self.low if at_rest else 0.0
            self.rows = increasing(self.rows[self.rows > 0], [self.low * NEAR_ZERO] if at_rest else [0.0])
        self.rows = increasing(self.rows, np.linspace(0, self.far, 200)[1:])
        self.lags = self.lags[self.lags * self.unit <= LONGEST]
        self.columns = [
            column
            for column in self.columns
            if not (isinstance(column[1], Delay) and abs(column[1].delay) * self.unit > LONGEST)
        ]

    def response(self, omega: Reals) -> NDArray[np.complex128]:
        """``H(i w)``."""
        return self.plant.transfer(1j * omega)

    def _at_infinity(self, k: float) -> Reals:
        """The inequality in the limit, with all delays at their worst phase, and something left of it."""
        degree = len(self.plant.denominator) - 1
        lead = {delay: float(top[0]) for delay, top in self.plant.terms if len(top) == degree}
        own, late = lead.get(Fraction(0), 0.0), sum(abs(c) for delay, c in lead.items() if delay)
        own, late = (value / float(self.plant.denominator[0]) for value in (own, late))
        masses = [1.0 if isinstance(kernel, Delay) else 0.0 for _, kernel in self.columns]
        rows = np.array([[*masses, -(own + sign * late) * self._theta_unit * k, 1.0] for sign in (1, -1)])
        return np.asarray(rows / (1 - LEFT))

    def park(self, k: float, theta: float, tau: float) -> float:
        """The least value of Park's inequality over ``1 + tau w^2``, relative to ``|H + 1/k|``, on the fine grid."""
        omega = self._fine(k)
        H = self.response(omega)
        values = (H + 1 / k).real + theta * (1j * omega * H).real / (1 + tau * omega**2)
        return float(np.min(values / self.size(omega, H + 1 / k)))


@dataclass(slots=True)
class LoopSearch(_LateSearch):
    """The linear programme with the response of a loop with dead times in one channel, of neutral type or not.

    Far out, where it does not settle, it is looked at over a period of what comes late, or at as many phases.

    Attributes
    ----------
    loop : callable
        ``H`` at some frequencies, after the shift by the lower slope.
    waits : sequence of Fraction
        The dead times.
    free : bool
        Whether there is a Popov term.
    """

    loop: Callable[[Reals], NDArray[np.complex128]] = field(kw_only=True)
    waits: Sequence[Fraction] = field(kw_only=True)
    free: bool = field(kw_only=True)

    def __post_init__(self) -> None:
        Search.__post_init__(self)
        self.far = max(self.far, FAR_DELAYS / float(max(self.waits)))
        fine = increasing(np.geomspace(self.low / 1e3, self.far, 2000), np.linspace(0, self.far, 4000))
        size = np.abs(self.response(fine))
        tops = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
        self.rows = increasing(self.rows, np.linspace(0, self.far, 200), fine[tops], self._beyond())

    def _first_columns(self) -> list[Column]:
        """Few kernels of low orders: the products of their denominators are what the checkers take long for."""
        sides: tuple[Side, ...] = ("causal", "anticausal")
        rates = np.geomspace(0.01, 100, RATES) * self.unit
        return [
            (sign, Gamma(short(rate), order, side))
            for rate in rates
            for order in ORDERS
            for side in sides
            for sign in ((1, -1) if self.odd else (1,))
        ]

    def _beyond(self) -> Reals:
        unit = math.lcm(*(tau.denominator for tau in self.waits))
        step = Fraction(math.gcd(*(int(tau * unit) for tau in self.waits)), unit)
        count = min(PHASES * int(max(self.waits) / step), MOST_PHASES)
        start = BEYOND * max(self.far, 100 * self.unit)
        return np.asarray(start + np.linspace(0, 2 * math.pi / float(step), count, endpoint=False))

    def response(self, omega: Reals) -> NDArray[np.complex128]:
        """``H(i w)``."""
        return self.loop(omega)

    def _fine(self, k: float) -> Reals:
        return increasing(Search._fine(self, k), self._beyond())

    def _at_infinity(self, k: float) -> Reals:
        """The inequality far out, where kernels are gone, and something left of it: else covers do not end."""
        omega = self._beyond()
        H = self.response(omega)
        scale = np.abs(H + 1 / k)
        room = (H + 1 / k).real / scale - KEPT
        turns = -(1j * omega * H).real * self._theta_unit / scale
        last, short = np.where(room > 0, 0.0, 1 / TOLERANCE), np.where(room > 0, room, 1.0)
        return np.column_stack([np.zeros((omega.size, len(self.columns))), turns / short, last])

    @property
    def _theta_unit(self) -> float:
        return 1 / self.unit if self.free else 0.0


@described(frozen=True, kw_only=True, slots=True)
class DelayedSlopes:
    """The inequality of Park or of Zames and Falb for a plant with dead time: computed, for the checkers to prove."""

    popov: DelayInequality = quantity("Popov's, which is theirs with the multiplier 1")
    odd: bool = quantity("Whether coefficients may be negative")
    kernels: bool = quantity("Whether for Zames and Falb")

    @classmethod
    def of(cls, block: DelayPlant, lower: Fraction, *, odd: bool = False, kernels: bool = True) -> DelayedSlopes:
        """The inequality of a plant.

        Raises
        ------
        AssumptionError
            The plant is not covered.
        """
        return cls(popov=DelayInequality.of(block, lower, weighted=True), odd=odd, kernels=kernels)

    @property
    def plant(self) -> Delayed:
        """The plant."""
        return self.popov.plant

    @property
    def grounds(self) -> Grounds:
        """Those of Popov's inequality, computed."""
        found = self.popov.grounds
        return Grounds(
            lower=found.lower,
            critical=found.critical,
            poles=found.poles,
            means="a linear programme in doubles",
            evidence=Evidence.COMPUTED,
        )

    def best(self, enough: Fraction | None = None) -> Best:
        """The farthest multiplier found; nothing goes beyond the stable linear gains."""
        gains, plant, lower = self.plant.gains(), self.plant.block, self.popov.lower
        families: tuple[Family, ...] = ("gamma", "both") if self.kernels else ("none",)
        searches = [DelayedSearch.of(plant, family, odd=self.odd) for family in families]
        peak = float(np.max(searches[0].size(searches[0].rows, searches[0].response(searches[0].rows))))
        found = _farthest(self._kernels if self.kernels else _park, searches, min(gains.low, LARGEST / peak))
        if found is None:
            said = "no multiplier was found, and Popov's criterion may say more"
            return Best(multiplier=None, largest=raised(Bracket(0.0, gains.high), lower), reason=said)
        k, multiplier, formula = found
        ends = raised(Bracket(k, gains.high), lower)
        limit = f"linear gains are stable only below {text_above(ends.high)}"
        return Best(multiplier=multiplier, largest=ends, formula=formula, limit=limit)

    def _kernels(self, searches: Sequence[DelayedSearch], k: float) -> Found | None:
        """A Zames-Falb multiplier for one class, with delays in it where others do not serve."""
        for search in searches:
            found = search.propose(k)
            if found is not None and found.least > TOLERANCE:
                return found.multiplier.to_parameters(), str(found.multiplier)
        return None


Found = tuple[dict[str, object], str]
Trial = Callable[[Sequence[DelayedSearch], float], Found | None]


def _park(searches: Sequence[DelayedSearch], k: float) -> Found | None:
    """Park's multiplier for one class: for each ``tau`` on a grid the best ``theta``, by a linear programme."""
    from scipy.optimize import linprog

    (search,) = searches
    omega = increasing(search.rows, around(search._closed_loop(k), 30))
    H = search.response(omega)
    scale = search.size(omega, H + 1 / k)
    for tau in np.append(0.0, np.geomspace(1e-4, 1e4, TAUS)) / search.unit**2:
        weight = (1j * omega * H).real / (1 + tau * omega**2) / search.unit
        result = linprog(
            [0.0, -1.0],
            A_ub=np.column_stack([-weight / scale, np.ones(omega.size)]),
            b_ub=(H + 1 / k).real / scale,
            bounds=[(None, None), (None, 1)],
            method="highs",
        )
        if result.status == 0 and result.x[1] > TOLERANCE:
            theta, square = short(float(result.x[0]) / search.unit), short(float(tau))
            if search.park(k, float(theta), float(square)) > TOLERANCE:
                return {"theta": theta, "tau": square}, f"1 + {float(theta):.6g} s - {float(square):.6g} s^2"
    return None


def _farthest(
    trial: Trial, searches: Sequence[DelayedSearch], high: float
) -> tuple[float, dict[str, object], str] | None:
    """The largest ``k`` up to one, with its multiplier, by bisection; None if there is none within a factor."""
    found, k, low = None, high * (1 - BELOW), high * LEAST
    for _ in range(STEPS):
        checkpoint()
        given = trial(searches, k)
        if given is not None:
            found, low = (k, *given), k
        else:
            high = k
        if high - low <= NARROW * low:
            break
        k = math.sqrt(low * high)
    return found


def first_order_largest(plant: DelayPlant, *, lower: Fraction = Fraction(0), odd: bool = False) -> CriterionResult:
    """The largest slope that Park's multiplier reaches with dead time, computed: the checkers prove it, or not.

    Parameters
    ----------
    plant : DelayPlant
        Stable, or with one simple pole at 0 besides.
    lower : Fraction
        Lower end of the slopes.
    odd : bool
        Of no use here.

    Raises
    ------
    AssumptionError
        The plant is not covered.
    """
    return _computed(PARK, odd=odd, kernels=False).largest(plant, lower=lower)


def kernels_largest(plant: DelayPlant, *, lower: Fraction = Fraction(0), odd: bool = False) -> CriterionResult:
    """The same for Zames-Falb multipliers, for odd nonlinearities of either sign.

    ``plant``, ``lower``: as for :func:`first_order_largest`; ``odd``: whether ``phi`` is known to be odd.

    Raises
    ------
    AssumptionError
        As :func:`first_order_largest`.
    """
    return _computed(kernel_criterion(odd=odd, effort="quick"), odd=odd, kernels=True).largest(plant, lower=lower)


def _computed(criterion: Criterion, *, odd: bool, kernels: bool) -> Criterion:
    """A criterion of rational plants, for those with dead time."""
    return replace(
        criterion,
        theorem=THEOREM.format(criterion.theorem),
        inequality=partial(DelayedSlopes.of, odd=odd, kernels=kernels),
        conclusions=LATE_CONCLUSIONS,
    )

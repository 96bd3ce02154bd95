"""Decay rates of several nonlinearities: what is proved at a rate, and the slowest gains, constant or not.

With dead time: the circle criterion of the weighted loop, and slower constant gains.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, ClassVar

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.blocks import paced
from lure.analysis.certificates.checker import Proved, Refuted
from lure.analysis.certificates.drafts import checked, guarded
from lure.analysis.certificates.systems import texts
from lure.analysis.counterexamples.channel_gains import GainsAround
from lure.analysis.counterexamples.channel_switching import MOST_STATES, Pattern, SwitchedGains
from lure.analysis.counterexamples.late_switching import LateRoots, LateSwitching
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.shifted_loop import Proposal
from lure.analysis.questions.channel_pieces import PiecewiseProofs
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.channel_proofs import criteria_for, proved_whole
from lure.analysis.questions.channel_rates import weighed_searches
from lure.analysis.questions.channel_refutations import narrowed
from lure.analysis.questions.channels import require_well_posed
from lure.analysis.questions.problem import Problem
from lure.analysis.wording import class_words, plants_words
from lure.arrays import NDArray, Reals, np
from lure.classes import FULL_BLOCK, NonlinearityClass
from lure.errors import AssumptionError, InputError
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant
from lure.record import described, quantity

CLOSE = Fraction(1, 10**4)
FORMS = ("diagonal-circle", "coupled-circle", "full-block-circle", "constant-gains")  # of one sample: not weighed
_VERTICES, _DRAWN, _KEPT, _BESIDE, _ROUNDS, _SEED = 10, 400, 6, 40, 14, 20261122
_BACK = (1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)  # from what a pattern seems to reach
_BITS = (256, 1024)
_HALVINGS, _FEW, _APART, _SHARE = 22, 12, 5e-10, 1e-6
_BACK_LATE = (0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5)  # where the proof of a rate that seems to serve is not accepted


def accepted(draft: dict[str, Any]) -> Proved | Refuted | None:
    """What the checker makes of a draft; None if it refuses.

    ``draft``: a certificate without what the checker fills in.
    """
    checkpoint()
    try:
        return checked(draft)
    except Rejected:
        return None


def about_words(base: Mapping[str, Any], *, inwards: bool = True) -> str:
    """The classes of a draft or certificate in words, and the box where there is one.

    ``base``: with ``laws`` and ``system``.  ``inwards``: whether bounds are rounded into the class, as for a proof;
    else out of it, as for a refutation.
    """
    plants = plants_words(base["system"], inwards=inwards)
    return class_words(base["laws"], inwards=inwards) + (plants and f" and{plants.removeprefix(' for')}")


def require_states(order: int) -> None:
    """Refuse a plant without states; ``order``: their number.

    Raises
    ------
    InputError
        There are none.
    """
    if not order:
        raise InputError("the plant has no states, so that nothing decays; give one that has, or ask lure certify")


def require_bounds(own: NonlinearityClass) -> None:
    """Refuse a class whose sector has an infinite bound.

    Raises
    ------
    InputError
        It has one.
    """
    if math.inf in map(abs, (own.sector.lower, own.sector.upper)):
        raise InputError(
            f"decay rates are shown of classes with finite bounds, and {own} has none; give a sector of two numbers"
        )


@described()
class RateSearch:
    """The searches for a rate, and what those about all kinds of plants have in common."""

    asked: Problem = quantity("The question about the classes as they are")
    close = CLOSE

    @property
    def discrete(self) -> bool:
        """Whether in discrete time."""
        return self.asked.plant.dt is not None

    @cached_property
    def base(self) -> dict[str, Any]:
        """What all drafts have in common."""
        return {"system": dict(self.asked.system), "laws": dict(self.asked.class_entry)}

    @property
    def words(self) -> str:
        """The classes in words, and the box where there is one."""
        return about_words(self.base)

    def require_functions(self) -> None:
        """Refuse classes of operators; functions of several channels in a full-block sector are none.

        Raises
        ------
        InputError
            A class is one.
        """
        if any(one.operator not in ("", FULL_BLOCK) for one in self.asked.classes.classes):
            raise InputError(
                "decay rates are not shown of operators, and a class here is one, such as a delay; lure certify and "
                "lure max-sector decide whether the loop is stable"
            )

    @property
    def fastest(self) -> float:
        """A rate that no proof exceeds, where no gain has one: nothing is then proved."""
        return 0.0

    def refuted_by(self, rate: Fraction, proof: Mapping[str, Any], **more: object) -> Refuted | None:
        """What is accepted against a rate.

        Parameters
        ----------
        rate : Fraction
            The rate; 0 in continuous time for the loop itself.
        proof : Mapping
            The proof of the certificate.
        **more
            What else stands in it.
        """
        draft = {"verdict": "REFUTED", **self.base, "theorem": "counterexample", "proof": dict(proof), **more}
        found = accepted({**draft, "rate": str(rate)}) if rate else accepted(draft) or accepted({**draft, "rate": "0"})
        return found if isinstance(found, Refuted) else None

    def expected(self, _easy: Fraction, hard: Fraction) -> float:
        """Where the criteria seem to end between two rates; as here, that may not be known beforehand."""
        return float(hard)

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates that gains that jump seem to have, and their proofs; here they are not looked at."""
        return iter(())

    def rescaled(self, _known: float, _most: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates between two, and their proofs, by solutions that repeat on another scale; here none are looked for."""
        return iter(())

    def lasting(self) -> Refuted | None:
        """A member with a solution that does not decay, no constant gain; here none is looked for."""
        return None


@dataclass
class SeveralChannels(RateSearch):
    """The searches for several nonlinearities, at a rate."""

    _tried: ClassVar = _DRAWN, _KEPT, _BESIDE, _ROUNDS

    def __post_init__(self) -> None:
        self.require_functions()
        require_states(len(self.plant.A))
        require_well_posed(self.asked)

    @cached_property
    def plant(self) -> MultivariablePlant:
        """The plant."""
        return channel_plant(self.asked.plant)

    def prove(self, rate: Fraction) -> Proved | None:
        """What is accepted of a rate, by the matrices of the weighted loop."""
        system = paced(self.base["system"], rate)
        A, B, C, D = (tuple(tuple(map(Fraction, row)) for row in system[side]) for side in "ABCD")
        scaled = replace(self.asked, plant=MultivariablePlant(A, B, C, D, self.plant.dt), kind="class")
        for criterion in criteria_for(scaled):
            if criterion.name in FORMS:
                work = partial(proved_whole, scaled, criterion)  # eigenvalues on the axis are not for all of them
                shown = guarded(criterion.name, work, passing=(TimeoutError,))
                found = self._of_rate(shown, rate) if isinstance(shown, Proved) else None
                if isinstance(found, Proved):
                    return found
        return None

    def _of_rate(self, shown: Proved, rate: Fraction) -> Proved | Refuted | None:
        """What was shown of the weighted loop, as it is of the loop."""
        given = shown.certificate
        kept = {key: given[key] for key in ("verdict", "theorem", "multiplier", "proof")}
        return accepted({**kept, **self.base, "rate": str(rate)})

    @cached_property
    def slowest(self) -> tuple[float, Sequence[Fraction]]:
        """The rate of the slowest constant gains found, in floating point, and the gains; NaN for none."""
        classes = self.asked.classes
        if classes.rectified:  # no gain is a member
            return math.nan, ()
        lower, upper = (np.array([float(v) for v in side]) for side in (classes.lower, classes.upper))
        blocks, (drawn, kept, beside, rounds) = narrowed(self.asked).classes.blocks, self._tried
        random = np.random.default_rng(_SEED)

        def spread(shares: Reals) -> Reals:
            """The gains of these shares of the intervals, one for each nonlinearity."""
            whole = np.empty((len(shares), len(lower)))
            for j, block in enumerate(blocks):
                whole[:, list(block)] = shares[:, [j]]
            return np.asarray(lower + whole * (upper - lower))

        ends = (
            np.array(np.meshgrid(*[[0.0, 1.0]] * min(len(blocks), _VERTICES)))
            .reshape(min(len(blocks), _VERTICES), -1)
            .T
        )
        vertices = np.concatenate([ends, random.integers(0, 2, (len(ends), len(blocks) - ends.shape[1]))], axis=1)
        trial = np.concatenate([vertices, random.uniform(0, 1, (drawn, len(blocks)))])
        values = self._slowness(spread(trial))
        for k in range(rounds):
            checkpoint()
            best = np.argsort(-values, kind="stable")[:kept]
            near = np.repeat(trial[best], beside, axis=0)
            near += random.normal(0, 0.3 * 0.45**k, near.shape) * (random.random(near.shape) < 0.6)
            trial = np.concatenate([trial[best], np.clip(near, 0, 1)])
            values = np.concatenate([values[best], self._slowness(spread(trial[len(best) :]))])
        share = trial[int(np.argmax(values))]
        share = np.where(share < 1e-6, 0.0, np.where(share > 1 - 1e-6, 1.0, share))
        best_value = float(self._slowness(spread(share[None]))[0])
        exact = [Fraction(0)] * len(lower)
        for j, block in enumerate(blocks):
            for i in block:
                low, high = classes.lower[i], classes.upper[i]
                exact[i] = low + Fraction(float(share[j])) * (high - low)
        return (best_value if self.discrete else -best_value), exact

    def _slowness(self, gains: Reals) -> Reals:
        """The spectral radius or abscissa of the loop with constant gains, a row for each."""
        values = np.linalg.eigvals(GainsAround(*self.plant.doubles()).closed_by(gains))
        return np.asarray(np.abs(values).max(axis=1) if self.discrete else values.real.max(axis=1))

    @cached_property
    def fastest(self) -> float:
        """The rate of the loop with the gains at the lower bounds, which no proof exceeds."""
        value = float(self._slowness(np.array([[float(v) for v in self.asked.classes.lower]]))[0])
        return value if self.discrete else -value

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate, by constant gains.

        ``rate``: the rate; 0 in continuous time for the loop itself.
        """
        return self.refuted_by(rate, {"method": "linear-gains", "gains": texts(self.slowest[1])})

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates that gains that jump seem to have, and their proofs."""
        classes = self.asked.classes
        varying = tuple(one.time_varying and not one.linear for one in classes.classes)
        gains = classes.lower, classes.upper
        for rate, ends, proof in jumps(
            self.plant, gains, varying, narrowed(self.asked).classes.blocks, self.slowest[0]
        ):
            rows = [texts([gains[end][i] for i, end in enumerate(row)]) for row in ends]
            yield rate, {"method": "switched-gains", "gains": rows} | proof

    def by_multipliers(self, end: Fraction | None, known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """What multipliers of several samples, kernels and Popov's terms prove, each better than what is known."""
        hard = self.fastest if end is None else float(end)
        hard = max(hard, self.fastest) if self.discrete else min(hard, self.fastest)
        for search in () if self.asked.classes.operators else weighed_searches(self.asked):
            easy = float(known) if known is not None else float(self.discrete)
            for rate, proposal in search.farthest(easy, hard):
                shown = accepted({"verdict": "PROVED", **self.base, **proposal, "rate": str(rate)})
                if isinstance(shown, Proved):
                    known = rate
                    yield rate, shown
                    break


def jumps(
    plant: MultivariablePlant,
    gains: tuple[Sequence[Fraction], Sequence[Fraction]],
    varying: tuple[bool, ...],
    blocks: Sequence[range],
    slowest: float,
) -> Iterator[tuple[Fraction, list[tuple[int, ...]], dict[str, Any]]]:
    """Gains that jump between the ends of their intervals and are slower than constant ones: for a certificate.

    ``gains``: lower and upper ends; ``varying``: which gains may jump; ``blocks``: the channels of each; ``slowest``:
    the rate of constant gains.

    Yields
    ------
    tuple
        A rate, the end of each channel step after step, and the rest of the proof; the slowest first.
    """
    A, B, C, D = plant.doubles()
    discrete = plant.dt is not None
    if not any(varying) or not 0 < len(A) <= MOST_STATES or not math.isfinite(slowest) or (discrete and slowest <= 0):
        return
    weighted = (A / slowest, B / slowest, C, D) if discrete else (A + slowest * np.eye(len(A)), B, C, D)
    low, high = (np.array([float(v) for v in side]) for side in gains)
    search = SwitchedGains(*weighted, low, high, varying=varying, blocks=tuple(blocks), discrete=discrete)
    hits: list[tuple[float, NDArray[np.int_], Pattern]] = []
    with np.errstate(all="ignore"):
        for ends in search.sets():
            for _, found in search.at(ends, 1.0):
                pattern = search.faster(ends, found, 1.0)
                hits.append((search.growth(ends, pattern, 1.0) / sum(pattern.times), ends, pattern))
    for growth, ends, pattern in sorted(hits, key=lambda hit: -hit[0])[:2]:
        if growth <= 1e-9:
            return
        which, times = list(pattern.which), [Fraction(t).limit_denominator(10**9) for t in pattern.times]
        if discrete:
            which = [w for w, t in zip(pattern.which, pattern.times, strict=True) for _ in range(round(t))]
            times = [Fraction(1)] * len(which)
        period = float(sum(times))
        for back, bits in ((back, bits) for back in _BACK for bits in _BITS):
            left = back * (1.0 if discrete else max(abs(slowest), growth))
            rate = slowest * math.exp(growth - left) if discrete else slowest - growth + left
            squarings = min(max(math.ceil(math.log2((math.log(4 * len(A)) + 2) / (left * period))) + 2, 0), 64)
            rows = [tuple(int(v) for v in ends[w]) for w in which]
            proof = {"squarings": squarings, "bits": bits} | ({} if discrete else {"times": texts(times)})
            yield Fraction(rate).limit_denominator(10**12), rows, proof


# With ``xi = x e^(a t)`` what arrives ``T`` late is ``e^(a T)`` times as large, ``e^(-(s - a) T) = e^(a T) e^(-s T)``,
# a number that the checkers enclose; sectors stay, of nonlinearities that depend on time.


@dataclass
class LateChannels(SeveralChannels):
    """The searches for a plant with dead times and a class in each of its channels, at a rate."""

    close = Fraction(1, 10**5)
    _tried: ClassVar = 24, 2, 12, 8

    def __post_init__(self) -> None:
        self.require_functions()
        require_states(self.late.order)
        self.late.require_retarded("decay rates")
        if any(math.inf in map(abs, one.gains) or one.memory or one.rectifier for one in self.asked.classes.classes):
            raise InputError(
                "beside dead times rates are shown of sectors, slope bounds and constant gains with two finite bounds; "
                "give such classes"
            )

    @property
    def late(self) -> DelayMatrix:
        """The plant."""
        assert isinstance(self.asked.plant, DelayMatrix), "made for those"
        return self.asked.plant

    def prove(self, rate: Fraction) -> Proved | None:
        """What is accepted of a rate."""
        return self._proved(rate, None)

    def _proved(self, rate: Fraction, free: Sequence[bool] | None) -> Proved | None:
        """The same, with Popov's terms in some channels, or without."""
        proposal = None if self._close(rate) else self._proposal(rate, free)
        if proposal is None:
            return None
        theorem = "piecewise-circle" if free is None else "piecewise-popov"
        draft = {"verdict": "PROVED", **self.base, "theorem": theorem, "rate": str(rate)}
        found = accepted({**draft, "multiplier": proposal.multiplier, "proof": proposal.proof})
        return found if isinstance(found, Proved) else None

    def _close(self, rate: Fraction) -> bool:
        """Whether a rate is so near to that of the slowest gains that the second checker may not tell them apart."""
        slowest, gains = self.slowest
        return (any(gains) or bool(self.late.inner)) and abs(float(rate) - slowest) < _APART * abs(slowest)

    def _proposal(self, rate: Fraction, free: Sequence[bool] | None, *, exactly: bool = True) -> Proposal | None:
        """A multiplier, in floating point alone or as the checker wants it."""
        checkpoint()
        try:
            return PiecewiseProofs(self.asked, free, rate).at(Fraction(1), exactly=exactly)
        except AssumptionError:
            return None

    def expected(self, easy: Fraction, hard: Fraction) -> float:
        """Where the circle criterion seems to end between two rates, in floating point.

        ``easy``, ``hard``: the rates, of which the second is wanted.
        """
        return self._end(float(easy), float(hard), None, _HALVINGS)

    def _end(self, low: float, high: float, free: Sequence[bool] | None, halvings: int) -> float:
        """Where proposals end between two rates: often close to the second, which is looked at first."""
        near = high + _SHARE * (low - high)
        for k in range(halvings):
            middle = (low + high) / 2 if k else near
            if self._proposal(Fraction(f"{middle:.12g}"), free, exactly=False) is None:
                high = middle
            elif k:
                low = middle
            else:
                return near
        return low

    @cached_property
    def _roots(self) -> LateRoots:
        return LateRoots(self.late)

    def _slowness(self, gains: Reals) -> Reals:
        """The real part of the rightmost root of the loop, for each row of gains; of a single loop with all digits."""
        if len(gains) == 1:
            return np.array([self._roots.rightmost(gains[0]).real])
        return np.array([self._roots.spectrum(row)[0].real for row in gains])

    @property
    def patterns(self) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates that gains that jump seem to have, and their proofs."""
        classes = self.asked.classes
        ends = classes.lower, classes.upper
        low, high = (np.array([float(v) for v in side]) for side in ends)
        varying = tuple(one.time_varying and not one.linear for one in classes.classes)
        for rate, one in LateSwitching(self.late, low, high, varying, classes.blocks).slower(self.slowest[0]):
            rows = [texts([ends[end][i] for i, end in enumerate(row)]) for row in one.ends]
            yield rate, {"method": "switched-gains", "gains": rows, **one.numbers}

    def by_multipliers(self, end: Fraction | None, known: Fraction | None) -> Iterator[tuple[Fraction, Proved]]:
        """What Popov's terms prove, of functions whose slopes are within their bounds, better than what is known.

        ``end``, ``known``: what no rate exceeds, and what is proved.
        """
        classes, base = self.asked.classes.classes, self.late.base.D
        free = [
            not (one.time_varying or one.linear or any(row))
            and one.slope is not None
            and one.gains == (one.slope.lower, one.slope.upper)
            for one, row in zip(classes, base, strict=True)
        ]
        if known is None or not any(free):
            return
        easy, hard = float(known), self.fastest if end is None else min(float(end), self.fastest)
        reached = self._end(easy, hard, free, _FEW)
        for back in _BACK_LATE if reached > easy else ():
            rate = Fraction(f"{reached - back * (reached - easy):.9g}")
            if rate > known and (shown := self._proved(rate, free)) is not None:
                yield rate, shown
                return

    def refute(self, rate: Fraction) -> Refuted | None:
        """What is accepted against a rate, by constant gains with a root farther to the right."""
        if self._close(rate):
            return None
        gains, draft = texts(self.slowest[1]), {"verdict": "REFUTED", **self.base, "theorem": "counterexample"}
        found = accepted({**draft, "proof": {"method": "late-turns", "gains": gains}, "rate": str(rate)})
        return found if isinstance(found, Refuted) else None

"""Several nonlinearities at a rate: multipliers that weigh, and how far each kind of them goes, in floating point."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.frequencies import MOST_CHANNELS
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.channels import MOST_STATES, ChannelInequality
from lure.analysis.inequality.coupled_forms import CoupledForms
from lure.analysis.inequality.gains import simplest_between
from lure.analysis.inequality.kernel_cone import KernelCone
from lure.analysis.inequality.kernels import multiplier
from lure.analysis.questions.channel_hypotheses import free_channels, groups_of, sloped_channels
from lure.analysis.questions.channel_problem import channel_plant
from lure.analysis.questions.problem import Problem
from lure.arrays import Reals, np
from lure.errors import AssumptionError
from lure.record import described, quantity

_CLOSE, _WORTH = 2e-5, 1e-4  # relative: where halving ends, and what is worth a certificate
_STEPS_BACK = (1e-5, 1e-4, 1e-3, 1e-2, 0.1)
_SAMPLES = (2, 3, 6)


@described()
class WeighedSearch(ABC):
    """One kind of multipliers for the loops of the solutions times ``r^-t``, or ``e^(a t)``."""

    asked: Problem = quantity("The question about the classes as they are")

    def __post_init__(self) -> None:
        plant, classes = channel_plant(self.asked.plant), self.asked.classes
        self.discrete, self.sides = plant.dt is not None, plant.doubles()
        self.widths = [high - low for high, low in zip(classes.upper, classes.lower, strict=True)]
        self.wide = np.array([float(v) for v in self.widths])
        self.lower = np.array([float(v) for v in classes.lower])

    def loop(self, rate: Fraction) -> tuple[Reals, Reals, Reals, Reals]:
        """``A``, ``B``, ``C`` and ``D`` of these solutions."""
        (A, B, C, D), r = self.sides, float(rate)
        return (A / r, B / r, C, D) if self.discrete else (A + r * np.eye(len(A)), B, C, D)

    @abstractmethod
    def proposals(self, rate: Fraction) -> Iterator[dict[str, Any]]:
        """Theorem, multiplier and proof for a certificate; nothing where none are found."""

    def serves(self, rate: float) -> bool:
        """Whether multipliers were found for a rate, before they are rounded."""
        checkpoint()
        try:
            return next(self.proposals(Fraction(rate)), None) is not None
        except (AssumptionError, Rejected, np.linalg.LinAlgError):
            return False

    def farthest(self, easy: float, hard: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Rates and what may prove them, the best first.

        ``easy``, ``hard``: a rate that is known, and one that none exceeds.
        """
        scale = max(abs(hard), 1e-3) if self.discrete else max(abs(easy), abs(hard))
        if not math.isfinite(hard) or not abs(easy - hard) > 2 * _WORTH * scale:
            return
        if not self.serves(easy + (hard - easy) * 1e-3):
            return
        low, high = easy + (hard - easy) * 1e-3, hard
        near = hard + (easy - hard) * min(_CLOSE * scale / abs(hard - easy), 0.5)
        if self.serves(near):
            low = high = near
        while abs(high - low) > _CLOSE * scale:
            middle = (low + high) / 2
            low, high = (middle, high) if self.serves(middle) else (low, middle)
        for step in _STEPS_BACK:
            rate = simplest_between(*sorted(Fraction(low + (easy - low) * part) for part in (step, 1.5 * step)))
            for one in self.proposals(rate):
                yield rate, one


@described()
class _Forms(WeighedSearch):
    """Forms of so many samples; of one, with Popov's terms."""

    samples: int = quantity("Number of samples", default=1)

    def proposals(self, rate: Fraction) -> Iterator[dict[str, Any]]:
        """See :class:`WeighedSearch`."""
        one = self.samples == 1
        free = free_channels(self.asked) if one else [False] * len(self.lower)
        within = [
            family.slope is not None and (family.slope.lower, family.slope.upper) == family.gains
            for family in self.asked.classes.classes
        ]
        search = CoupledForms(
            *self.loop(rate),
            self.lower,
            groups_of(self.asked),
            self.samples,
            free,
            popov=one,
            discrete=self.discrete,
            rate=rate,
            sloped=within,
        )
        for found in search.proposals(self.widths, self.asked.classes.lower) if search.possible else ():
            yield {
                "theorem": "coupled-popov" if one else "coupled-windows",
                "multiplier": found.multiplier,
                "proof": found.proof,
            }


@dataclass
class _Kernels(WeighedSearch):
    """Kernels, in continuous time."""

    def proposals(self, rate: Fraction) -> Iterator[dict[str, Any]]:
        """See :class:`WeighedSearch`."""
        sloped, classes = sloped_channels(self.asked), self.asked.classes
        ends = list(zip(classes.lower, classes.upper, strict=True))
        for i, one in enumerate(classes.classes):
            if sloped[i] and one.slope is not None:
                ends[i] = Fraction(one.slope.lower), Fraction(one.slope.upper)
        lower, widths = np.array([float(low) for low, _ in ends]), [high - low for low, high in ends]
        free = [one and other for one, other in zip(free_channels(self.asked), sloped, strict=True)]
        plant = ChannelInequality(*self.loop(rate), lower, free, popov=True, discrete=False)
        blocks = [block for block in classes.blocks if sloped[block[0]]]
        cone = KernelCone(plant, blocks, [one.odd for one in classes.classes], rate=float(rate))
        wide = np.array([float(v) for v in widths])
        if not cone.rates:  # no kernel falls faster than it is weighed
            return
        found = cone.largest(lambda factor: factor * wide, 1.0, 1.001)
        if found is not None and found.factor > 1:
            stated = multiplier(found, widths, rate=rate)
            yield {"theorem": "matrix-zames-falb", "multiplier": stated, "proof": {"method": "determinant"}}


def weighed_searches(asked: Problem) -> list[WeighedSearch]:
    """The kinds of multipliers that there are for these classes, the cheapest first."""
    plant, sloped = channel_plant(asked.plant), sloped_channels(asked)
    kernels = any(sloped) and len(sloped) <= MOST_CHANNELS and len(plant.A) <= MOST_STATES
    if plant.dt is None:
        found: list[WeighedSearch] = [_Forms(asked)] if any(free_channels(asked)) else []
        return found + [_Kernels(asked)] * kernels
    several = any(sloped) or asked.classes.rectified
    return [_Forms(asked, samples) for samples in _SAMPLES] if several else []

"""What a criterion asks of an inequality over all frequencies, whatever decides it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, Protocol

from lure.analysis.verdict import Bracket, Evidence
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

ScalarPlant = RationalPlant | DelayPlant | StateSpace | FrequencyData
Multiplier = Mapping[str, Any]
Proves = Callable[[Multiplier], bool]


@described(frozen=True, kw_only=True, slots=True)
class Grounds:
    """What an answer rests on besides the inequality itself: the loop with the gain ``lower`` closed, and the means."""

    lower: Fraction = quantity("Lower end of the classes")
    direct: Fraction = quantity("The direct term of ``H/(1 + lower H)``", default=Fraction(0))
    critical: bool = quantity("Whether it has a pole at 0 (``z = 1``)", default=False)
    discrete: bool = quantity("Whether time is discrete", default=False)
    poles: str = quantity("Where its poles are, and how that was checked")
    means: str = quantity("By what means the inequality is decided")
    evidence: Evidence = quantity(
        "What that is worth; short of CERTIFIED nothing is proved by it", default=Evidence.CERTIFIED
    )


@described(frozen=True, kw_only=True, slots=True)
class Best:
    """How far the multipliers of a cone go."""

    multiplier: Multiplier | None = quantity(
        "The weights by name, or taps, or kernels; an infinite weight must grow with ``k``.  None if none was certified"
    )
    largest: Bracket = quantity(
        "The largest ``k``; of an inequality that is decided both ends are exact statements, infinite where every "
        "finite ``k`` is proved"
    )
    points: tuple[Fraction | None, ...] = quantity(
        "Where the inequality is tight, as values of its variable; None is infinity", default=()
    )
    worst_frequency: float | None = quantity(
        "The first of them as a frequency [rad/s; rad per sample]; None where it is not known", default=None
    )
    margin: Bracket | None = quantity("The infimum of ``F`` for the largest ``k``, where it was computed", default=None)
    formula: str = quantity("The multiplier as a formula, where the weights do not say it", default="")
    limit: str = quantity(
        "Why no multiplier goes farther, where the points do not show it; or how one serves every finite ``k``",
        default="",
    )
    reason: str = quantity("Why nothing can be said of a class, where nothing can", default="")
    search_limited: bool = quantity("Whether ``largest.low`` is no end, but the largest ``k`` tried", default=False)


class Bounding(Protocol):
    """``F(omega; multiplier, k) > 0`` for one plant and the classes ``[lower, k]``, whatever bounds the ``k``."""

    @property
    def grounds(self) -> Grounds:
        """The loop with the lower gain closed, and by what means the inequality is decided."""
        ...

    def best(self, enough: Fraction | None = None) -> Best:
        """The largest ``k`` over the cone of multipliers; a dear search may stop at one that is enough."""
        ...


class Inequality(Bounding, Protocol):
    """One that is decided for any multiplier of the cone and any class."""

    def serving(self, best: Best, proves: Proves) -> Multiplier:
        """The best multiplier or one beside it that proves a class; where none does, a finite one all the same."""
        ...

    def decide(self, multiplier: Multiplier, upper: Fraction) -> bool:
        """Whether the multiplier proves the class ``[lower, upper]``, at every frequency."""
        ...

    def least(self, multiplier: Multiplier, upper: Fraction | float) -> tuple[Bracket, float]:
        """The infimum of ``F`` over frequency, and where it is attained [rad/s; rad per sample]."""
        ...

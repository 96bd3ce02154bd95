"""Two nonlinearities: the map of their upper bounds ``(k1, k2)``, proved, refuted, open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, cast

from lure.analysis.deadline import time_limit
from lure.analysis.drawing import drawn
from lure.analysis.numerics.doubles import bound_below, double_above, double_below
from lure.analysis.questions.answers import answer
from lure.analysis.verdict import Evidence, Verdict
from lure.classes import DELAYS, Diagonal
from lure.errors import InputError
from lure.plants.channel_family import ChannelFamily
from lure.plants.delay_matrix import DelayMatrix
from lure.record import Record, quantity

if TYPE_CHECKING:
    from lure.analysis.questions.largest import StabilityBound
    from lure.analysis.questions.problem import Problem

_DIRECTIONS = (-5.0, -2.5, -1.0, 0.0, 1.0, 2.5, 5.0)  # powers of 2 of k2/k1, beside that of the classes asked about
_FEW = (-2.5, 0.0, 2.5)  # of gains that change slowly and beside dead times, which take seconds each


_UNIT = "unit of phi / unit of sigma"


class Ray(Record):
    """One direction of the map: how far the classes with the upper bounds ``t (k1, k2)`` are known from both sides."""

    k1: float = quantity("upper bound of channel 1 in this direction", _UNIT, dims="")
    k2: float = quantity("upper bound of channel 2 in this direction", _UNIT, dims="")
    proved_k1: float | None = quantity("proved with this upper bound in channel 1 and `proved_k2` in 2", _UNIT, dims="")
    proved_k2: float | None = quantity("upper bound of channel 2 that is proved", _UNIT, dims="")
    refuted_k1: float | None = quantity(
        "refuted from this upper bound in channel 1 and `refuted_k2` in 2 on", _UNIT, dims=""
    )
    refuted_k2: float | None = quantity("upper bound of channel 2 from which on it is refuted", _UNIT, dims="")
    criterion: str = quantity("the theorem of the proof; empty without one", "1", dims="")


class StabilityMap(Record):
    """For which upper bounds ``(k1, k2)`` of two nonlinearities the loop is stable; lower bounds and kinds stay.

    What is proved for a pair holds for every smaller one, since its classes are contained; a member that refutes a pair
    lies in the classes of every larger one.  So both regions are unions of rectangles.
    """

    lower: tuple[Fraction, Fraction] = quantity("where the classes begin")
    asked: tuple[Fraction, Fraction] = quantity("the upper bounds asked about")
    rays: tuple[Ray, ...] = quantity("from channel 1 to channel 2", dims="ray", each=Ray)
    bounded: tuple[str, str] = quantity(
        "what is bounded, for the drawing",
        hidden=True,
        default=("k₁, upper bound in channel 1", "k₂, upper bound in channel 2"),
    )
    evidence: Evidence = quantity("of both regions", default=Evidence.CERTIFIED)
    _kind = "stability map"
    _title = "Upper bounds of two nonlinearities"

    @property
    def proved(self) -> tuple[tuple[float, float], ...]:
        """Corners of rectangles that are proved, ``k1`` ascending, none inside another."""
        found = [(ray.proved_k1, ray.proved_k2) for ray in self.rays]
        return _outer([(a, b) for a, b in found if a is not None and b is not None], 1)

    @property
    def proved_texts(self) -> tuple[tuple[str, str], ...]:
        """The corners that are proved in words, rounded down, none inside another as they are printed."""
        said = [(bound_below(a), bound_below(b)) for a, b in self.proved]
        printed = {(float(a), float(b)): (a, b) for a, b in said}
        return tuple(printed[corner] for corner in _outer(list(printed), 1))

    @property
    def refuted(self) -> tuple[tuple[float, float], ...]:
        """Corners from which on all is refuted, ``k1`` ascending, none beyond another."""
        found = [(ray.refuted_k1, ray.refuted_k2) for ray in self.rays]
        return _outer([(a, b) for a, b in found if a is not None and b is not None], -1)

    def verdict(self, k1: float, k2: float) -> Verdict:
        """What is known of the classes with these upper bounds.

        Parameters
        ----------
        k1, k2 : float
            Upper bounds above the lower ones.

        Raises
        ------
        InputError
            They are not.
        """
        if not (k1 > self.lower[0] and k2 > self.lower[1]):
            raise InputError(f"({k1}, {k2}) are no upper bounds above the lower ones; give larger ones")
        if any(k1 <= a and k2 <= b for a, b in self.proved):
            return Verdict.PROVED
        return Verdict.REFUTED if any(k1 >= a and k2 >= b for a, b in self.refuted) else Verdict.INCONCLUSIVE

    plot = drawn("The plane of ``(k1, k2)``: proved, refuted, open.")


def _outer(corners: list[tuple[float, float]], sign: int) -> tuple[tuple[float, float], ...]:
    """Those that no other dominates."""
    kept = {
        (a, b)
        for a, b in corners
        if not any(sign * (c - a) >= 0 and sign * (d - b) >= 0 and (c, d) != (a, b) for c, d in corners)
    }
    return tuple(sorted(kept))


def stability_map(
    problem: Problem,
    *,
    known: Sequence[StabilityBound] = (),
    seconds: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> StabilityMap | None:
    """The map of a problem with two channels, ray by ray; None where it has no two different nonlinearities.

    Parameters
    ----------
    problem : Problem
        About one class, or largest ones.
    known : sequence of StabilityBound
        Complete answers about the same plant, one of which may be that of a ray.
    seconds : float or None
        Time allowed; the rays that were followed until then are the map.
    progress : callable, optional
        Told each ray and the share done.
    """
    if len(problem.classes.blocks) != 2 or len(problem.classes.classes) != 2 or min(problem.classes.upper) <= 0:
        return None
    if problem.classes.rectified:  # ReLUs of smaller slopes are others
        return None
    k1, k2 = problem.classes.upper
    dear = isinstance(problem.plant, DelayMatrix | ChannelFamily) or any(
        one.rate is not None for one in problem.classes.classes
    )
    along = _FEW if dear else _DIRECTIONS
    directions = [(k1 * Fraction(2 ** max(-e, 0.0)), k2 * Fraction(2 ** max(e, 0.0))) for e in along]
    rays, tell = list[Ray](), progress or (lambda _step, _done: None)
    with time_limit(seconds) as over:
        for i, direction in enumerate(directions):
            if over():
                break
            tell(f"map of (k1, k2), direction {i + 1} of {len(directions)}", i / len(directions))
            classes = _towards(problem.classes, direction)
            same = [row for row in known if row.classes == classes and row.stopped is None]
            found = same[0] if same else answer(replace(problem, classes=classes, kind="sector", known=()))
            rays.append(_ray(direction, cast("StabilityBound", found), problem.classes))
    late = [one.operator in DELAYS for one in problem.classes.classes]
    lower = [Fraction(0) if own else end for own, end in zip(late, problem.classes.lower, strict=True)]
    unit = "s" if problem.plant.dt is None else "samples"
    words = [
        f"delay bound in channel {i} [{unit}]" if own else f"k{'₁₂'[i - 1]}, upper bound in channel {i}"
        for i, own in enumerate(late, 1)
    ]
    return StabilityMap(lower=(lower[0], lower[1]), asked=(k1, k2), rays=tuple(rays), bounded=(words[0], words[1]))


def _towards(classes: Diagonal, ends: tuple[Fraction, Fraction]) -> Diagonal:
    """The classes with upper bounds in proportion to ``ends``: of each channel all of them times one factor."""
    pairs = zip(classes.classes, ends, classes.upper, strict=True)
    return Diagonal(tuple(one.scaled(end / high) for one, end, high in pairs))


def _ray(direction: tuple[Fraction, Fraction], found: StabilityBound, classes: Diagonal) -> Ray:
    """What is known in a direction; an operator is no gain, and refuted with all of its class."""
    proof, against = found.proof, found.refutation
    proved, refuted = list[float | None]([None, None]), list[float | None]([None, None])
    if proof is not None:
        factor = Fraction(found.largest.low)
        proved = [double_below(factor * end) for end in direction]
    if against is not None:
        member = against.certificate["proof"]
        gains = member.get("gains")  # of gains that jump those of each stay
        stays = gains if gains and isinstance(gains[0], list) else [gains]
        for i, one in enumerate(classes.classes):
            if i + 1 not in member.get("channels", [i + 1]):
                refuted[i] = double_above(classes.lower[i])  # one channel alone
            elif gains and not one.operator:
                refuted[i] = double_above(max(Fraction(row[i]) for row in stays))
            elif found.refuted_at is not None:  # with all of its class
                refuted[i] = double_above(Fraction(found.refuted_at) * direction[i])
    return Ray(
        k1=float(direction[0]),
        k2=float(direction[1]),
        proved_k1=proved[0],
        proved_k2=proved[1],
        refuted_k1=refuted[0],
        refuted_k2=refuted[1],
        criterion="" if proof is None else found.criterion,
    )

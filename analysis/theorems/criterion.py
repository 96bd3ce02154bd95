"""The answer of a criterion with one inequality: the largest class it proves, and whether it proves one class."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from types import MappingProxyType
from typing import Any, cast

from lure.analysis.inequality.checks import require_well_posed
from lure.analysis.inequality.protocol import Best, Bounding, Grounds, Inequality, Multiplier, ScalarPlant
from lure.analysis.numerics.doubles import double_below, text_above, text_below
from lure.analysis.verdict import Bracket, CriterionResult, Evidence, Needs, Verdict
from lure.classes import NonlinearityClass, Sector, SlopeBounds
from lure.errors import AssumptionError, Reason
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

Bound = Fraction | float
_BESIDE_ZERO = Fraction(1, 10**12)
CONCLUSION = "0 is globally asymptotically stable for every nonlinearity of the class"
STATIONARY = (
    "every solution is bounded and converges to a point of the stationary set, 0 being asymptotically stable only if "
    "phi vanishes at 0 alone"
)
LATE_CONCLUSIONS = (  # with dead time
    "0 is globally attractive for inputs to the block and initial functions of finite energy",
    "every solution converges to the stationary set",
)
INVERTIBLE = "sigma + D phi(sigma) invertible with a locally Lipschitz inverse (H has a direct term D): assumed"
SLOPE = "phi time-invariant with slope within the bounds, phi(0) = 0: assumed of the class; it need not be odd"
SLOPE_ODD = "phi time-invariant and odd with slope within the bounds: assumed of the class"


def _never(_inequality: Inequality, _multiplier: Multiplier) -> bool:
    return False


def slope_class(lower: Bound, upper: Bound, _direct: Fraction, *, odd: bool = False) -> NonlinearityClass:
    """The nonlinearities with slope in ``[lower, upper]``, all or the odd ones."""
    return NonlinearityClass.slope_restricted(lower, upper, odd=odd)


def sector_class(lower: Bound, upper: Bound, _direct: Fraction, *, time_varying: bool = False) -> NonlinearityClass:
    """The nonlinearities in the sector ``[lower, upper]``."""
    return NonlinearityClass(sector=Sector(lower, upper), time_varying=time_varying)


@described(frozen=True, kw_only=True, slots=True)
class Criterion:
    """What sets one criterion apart from the others."""

    name: str = quantity("The name of its row in the table")
    title: str = quantity("Its name in sentences")
    theorem: str = quantity("The theorem with its source")
    formula: str = quantity("The multiplier, or the left-hand side with it")
    inequality: Callable[[Any, Fraction], Bounding] = quantity(
        "The inequality of a plant and a lower end; it refuses what the theorem does not cover"
    )
    nonlinearities: Callable[[Bound, Bound, Fraction], NonlinearityClass] = quantity(
        "The class that the theorem is about, from both ends of the sector and the direct term of the shifted plant",
        default=slope_class,
    )
    assumed: str = quantity("What is assumed of the class; ``{class}`` stands for it", default=SLOPE)
    kind: str = quantity(
        "What is searched for: a multiplier, a line, a weight; empty where nothing is", default="multiplier"
    )
    needs: tuple[Needs, ...] = quantity(
        "Properties of the class beyond its sector", default=("slope", "time-invariant")
    )
    legal: str = quantity("What was checked of the multiplier itself", default="")
    composed: bool = quantity("Whether a direct term asks for more than ``1 + k D > 0``", default=False)
    endless: Callable[[Any, Multiplier], bool] = quantity(
        "Whether a multiplier proves the nonlinearities that no gain bounds; without it a class has finite bounds",
        default=_never,
    )
    conclusions: tuple[str, str] = quantity(
        "What follows of the loop where its poles are stable, and in the critical case",
        default=(CONCLUSION, STATIONARY),
    )

    def largest(self, block: ScalarPlant, *, lower: Fraction = Fraction(0)) -> CriterionResult:
        """The largest class that the criterion proves from the lower end on.

        Parameters
        ----------
        block : RationalPlant, DelayPlant, StateSpace or FrequencyData
            The plant, of a kind that the inequality is for.
        lower : Fraction
            Lower end of the classes.

        Raises
        ------
        AssumptionError, InputError
            The theorem does not cover the plant.
        """
        return self.answer(self.inequality(block, Fraction(lower)))

    def answer(self, inequality: Bounding) -> CriterionResult:
        """The same for an inequality at hand."""
        best, grounds = inequality.best(), inequality.grounds
        upper, short = best.largest.low, double_below(grounds.lower * _BESIDE_ZERO)
        if short < upper < 0:  # a class below 0 that reaches to 0 has no largest double: they end at 5e-324
            best, upper = replace(best, largest=Bracket(short, best.largest.high)), short
        proved = best.multiplier is not None and upper > grounds.lower
        blank = _blank(self, grounds, (grounds.lower, upper if proved else math.inf), best, holds=proved)
        reason = _largest(self, grounds, best) if proved else "no k that a double can state was reached"
        return replace(blank, reason=best.reason or reason, search_limited=best.search_limited)

    def decide(
        self, block: RationalPlant, bounds: Sector | SlopeBounds, *, multiplier: Multiplier | None = None
    ) -> CriterionResult:
        """Whether the criterion proves one class.

        Parameters
        ----------
        block : RationalPlant
            The plant.
        bounds : Sector or SlopeBounds
            Both ends of the class.
        multiplier : Mapping, optional
            Its weights by name; by default the best ones.

        Returns
        -------
        CriterionResult
            PROVED or INCONCLUSIVE, which says nothing about the loop; ``margin`` is the infimum over frequency of the
            left-hand side.

        Raises
        ------
        AssumptionError
            A bound is infinite that the theorem needs finite; the theorem does not cover the plant.
        InputError
            ``1 + k H(inf) = 0`` for some ``k`` within the bounds.
        """
        lower, upper = bounds.lower, bounds.upper
        if lower == -math.inf or (upper == math.inf and self.endless is _never):
            slopes = "slope" in self.needs
            wanted = "finite slope bounds" if slopes else "a finite lower end of the sector"
            raise AssumptionError(
                f"{self.title} needs {wanted}, and the class is {bounds}; give numbers",
                code=Reason.NOT_APPLICABLE if slopes else Reason.NO_LOWER_END,
            )
        inequality = cast("Inequality", self.inequality(block, Fraction(lower)))  # of a rational plant it is decided
        require_well_posed(block, upper, lower=inequality.grounds.lower)

        def proves(multiplier: Multiplier) -> bool:
            """Whether a multiplier proves the class, exactly."""
            if upper == math.inf:
                return self.endless(inequality, multiplier)
            return inequality.decide(multiplier, Fraction(upper))

        best, grounds = inequality.best(None if upper == math.inf else Fraction(upper)), inequality.grounds
        if best.reason:
            return replace(_blank(self, grounds, (lower, upper), best, holds=False), reason=best.reason)
        used = multiplier or inequality.serving(best, proves)
        holds = proves(used)
        margin, worst = inequality.least(used, upper)
        if holds:
            margin = Bracket(max(margin.low, 0.0), margin.high)
        said = f"the inequality holds at every frequency, the margin is {margin}; {_conclusion(self, grounds)}"
        reason = said if holds else _shortfall(self, grounds, (margin, worst), best.largest, upper)
        blank = _blank(self, grounds, (lower, upper), replace(best, multiplier=used), holds=holds)
        return replace(blank, margin=margin, worst_frequency=worst, reason=reason)


def slope_criterion(*, odd: bool, **parts: Any) -> Criterion:  # noqa: ANN401  (the other fields)
    """A criterion for monotone nonlinearities, or for odd ones.

    Parameters
    ----------
    odd : bool
        Which of the two.
    **parts
        The other fields of :class:`Criterion`.
    """
    return Criterion(
        nonlinearities=partial(slope_class, odd=odd),
        assumed=SLOPE_ODD if odd else SLOPE,
        needs=("slope", "odd", "time-invariant") if odd else ("slope", "time-invariant"),
        **parts,
    )


def _blank(
    criterion: Criterion, grounds: Grounds, bounds: tuple[Bound, Bound], used: Best, *, holds: bool
) -> CriterionResult:
    """What is the same for every question: the answer about the class with these bounds."""
    nonlinearities = criterion.nonlinearities(*bounds, grounds.direct)
    return CriterionResult(
        criterion=criterion.name,
        theorem=criterion.theorem,
        largest=used.largest,
        nonlinearity_class=nonlinearities,
        verdict=Verdict.PROVED if holds and grounds.evidence is Evidence.CERTIFIED else Verdict.INCONCLUSIVE,
        evidence=grounds.evidence,
        needs=criterion.needs,
        theta=_theta(used.multiplier),
        multiplier=used.formula or criterion.formula,
        parameters=_parameters(used, bounds[1], holds=holds),
        margin=used.margin,
        worst_frequency=used.worst_frequency,
        hypotheses=_hypotheses(criterion, grounds, nonlinearities, holds=holds),
    )


def _theta(multiplier: Multiplier | None) -> float | None:
    """The weight of ``s``, where there is one."""
    theta = None if multiplier is None else multiplier.get("theta")
    return float(Fraction(theta)) if isinstance(theta, str) else None if theta is None else float(theta)


def _parameters(used: Best, upper: Bound, *, holds: bool) -> MappingProxyType[str, object]:
    weights = (used.multiplier or {}).items()
    found: dict[str, object] = {
        name: str(value) if isinstance(value, Fraction | float) else value for name, value in weights
    }
    if used.points:
        found["points"] = tuple("inf" if x is None else str(x) for x in used.points)
    if used.multiplier is not None and (holds or upper != math.inf):
        found["k"] = "inf" if upper == math.inf else str(Fraction(upper))
    return MappingProxyType(found)


def _conclusion(criterion: Criterion, grounds: Grounds) -> str:
    return criterion.conclusions[grounds.critical]


def _largest(criterion: Criterion, grounds: Grounds, best: Best) -> str:
    largest, multiplier = best.largest, best.multiplier or {}
    if largest.low == math.inf:
        growing = [name for name, value in multiplier.items() if isinstance(value, float)]
        how = f"the larger k, the larger |{growing[0]}|" if growing else f"one {criterion.kind} serves them all"
        said = f", {best.limit or how}" if criterion.kind else ""
        return f"every finite k is proved{said}; {_conclusion(criterion, grounds)}"
    limit = f", since {best.limit}" if best.limit else ""
    beyond = f"and no {criterion.kind} reaches {text_above(largest.high, 15)}{limit}"
    if not criterion.kind:
        beyond = f"and from {text_above(largest.high, 15)} on the inequality fails"
    if largest.high == math.inf:
        beyond = "and what others reach is not known"
    verb = "proved" if grounds.evidence is Evidence.CERTIFIED else grounds.evidence
    return f"every k up to {text_below(largest.low, 15)} is {verb}, {beyond}; {_conclusion(criterion, grounds)}"


def _shortfall(
    criterion: Criterion, grounds: Grounds, least: tuple[Bracket, float], largest: Bracket, upper: Bound
) -> str:
    if upper == math.inf:
        return (
            "the inequality for nonlinearities that no gain bounds is not established; the sectors [lower, k] are "
            f"proved for every k up to {text_below(largest.low)}"
        )
    margin, worst = least
    unit = "rad per sample" if grounds.discrete else "rad/s"
    fails = f"fails by {-margin.high:.6g} at {worst:.6g} {unit}" if margin.high < 0 else "is not strict"
    if not criterion.kind:
        proved = f"; every k up to {text_below(largest.low)} is proved" if largest.low > grounds.lower else ""
        return f"the inequality {fails}, from which nothing follows for the loop{proved}"
    return (
        f"the inequality {fails} with this {criterion.kind}, from which nothing follows for the loop; with the best "
        f"{criterion.kind} the largest k is {largest}"
    )


def _hypotheses(
    criterion: Criterion, grounds: Grounds, nonlinearities: NonlinearityClass, *, holds: bool
) -> tuple[str, ...]:
    where = "on the unit circle" if grounds.discrete else "on [0, inf], limits included"
    if criterion.composed:
        solvable = (INVERTIBLE,) if grounds.direct else ()
    else:
        solvable = ("1 + k H(inf) > 0: checked" if grounds.direct else "no direct term: checked",)
    return (
        grounds.poles,
        f"inequality {where}: {f'holds, by {grounds.means}' if holds else 'not established'}",
        *((criterion.legal,) if criterion.legal else ()),
        *solvable,
        criterion.assumed.format(**{"class": nonlinearities}),
    )

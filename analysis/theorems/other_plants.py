"""The circle and Popov's criterion for plants that are not rational: dead time, matrices in doubles, samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

from lure.analysis.inequality.delay import Delayed, DelayInequality, raised
from lure.analysis.inequality.protocol import Bounding, ScalarPlant
from lure.analysis.inequality.samples import SampledInequality
from lure.analysis.inequality.state_space import StatesInequality
from lure.analysis.theorems.criterion import CONCLUSION, LATE_CONCLUSIONS, STATIONARY, Criterion, sector_class
from lure.analysis.verdict import CriterionResult, Evidence, Verdict
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant
from lure.plants.frequency_data import FrequencyData
from lure.plants.state_space import StateSpace


def _pair(
    inequality: Callable[..., Bounding],
    circle: str,
    popov: str,
    conclusions: tuple[str, str] = (CONCLUSION, STATIONARY),
) -> dict[str, Criterion]:
    """Both criteria, with the sources of their theorems, by name."""
    common: dict[str, Any] = {"formula": "1 + theta s", "conclusions": conclusions}
    return {
        "circle": Criterion(
            name="circle",
            title="the circle criterion",
            theorem=circle,
            inequality=partial(inequality, weighted=False),
            nonlinearities=partial(sector_class, time_varying=True),
            assumed="phi continuous, in the sector: assumed of the class",
            needs=(),
            kind="",
            **common,
        ),
        "popov": Criterion(
            name="popov",
            title="Popov's criterion",
            theorem=popov,
            inequality=partial(inequality, weighted=True),
            nonlinearities=sector_class,
            assumed="phi time-invariant, continuous, in the sector: assumed of the class",
            needs=("time-invariant",),
            kind="theta >= 0",
            **common,
        ),
    }


_BOOK = "C. A. Desoer and M. Vidyasagar, Feedback Systems: Input-Output Properties, 1975"
_MATRIX = "by a matrix inequality (Yakubovich 1962, Kalman 1963)"
_CRITERIA: dict[type[ScalarPlant], dict[str, Criterion]] = {
    DelayPlant: _pair(
        DelayInequality.of,
        f"circle criterion for a convolution kernel in L1 ({_BOOK}, ch. V)",
        f"Popov's criterion for a convolution kernel in L1, or an integrator besides ({_BOOK}, ch. VI)",
        LATE_CONCLUSIONS,
    ),
    StateSpace: _pair(StatesInequality, f"the circle criterion, {_MATRIX}", f"Popov's criterion, {_MATRIX}"),
    FrequencyData: _pair(
        SampledInequality,
        "circle criterion, at sampled frequencies only",
        "popov criterion, at sampled frequencies only",
    ),
}


def largest(plant: ScalarPlant, criterion: str, *, lower: Fraction = Fraction(0)) -> CriterionResult:
    """The largest class of a criterion for a plant that is not rational.

    With dead time it is proved, in doubles computed (a matrix that the checker accepts proves it), from samples
    observed.

    Parameters
    ----------
    plant : DelayPlant, StateSpace or FrequencyData
        The plant.
    criterion : {"circle", "popov", "hurwitz"}
        The criterion; linear gains with dead time only.
    lower : Fraction
        Lower end of the classes, of a ``FrequencyData`` 0.

    Raises
    ------
    AssumptionError
        The plant is not covered, or the criterion is not evaluated for such a plant.
    """
    if criterion == "hurwitz" and isinstance(plant, DelayPlant):
        return _linear_gains(plant, lower)
    found = _CRITERIA[type(plant)].get(criterion)
    if found is None or (criterion == "popov" and plant.dt is not None):
        known = "circle" if plant.dt is not None else "circle or popov"
        raise AssumptionError(
            f"the criterion {criterion} is not evaluated for a {type(plant).__name__}; ask {known}, or give "
            "coefficients for the exact criteria",
            code=Reason.SAMPLED if isinstance(plant, FrequencyData) else Reason.COMPUTED,
        )
    answer = found.largest(plant, lower=lower)
    return replace(answer, code=Reason.SAMPLED) if answer.evidence is Evidence.OBSERVED else answer


def _linear_gains(plant: DelayPlant, lower: Fraction) -> CriterionResult:
    """The answer of linear gains alone; it proves nothing about nonlinearities."""
    limit = raised(Delayed.of(plant, lower).gains(), lower)
    return CriterionResult(
        criterion="hurwitz",
        theorem="Nyquist's criterion for a retarded equation",
        largest=limit,
        nonlinearity_class=NonlinearityClass(sector=Sector(lower, limit.low if limit.low > lower else math.inf)),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.CERTIFIED,
        reason="stability of every linear gain in a sector does not prove that of its nonlinear members",
    )

"""Circle and Popov criteria on measured frequency responses: bounds on their reach, and no proof."""

from __future__ import annotations

import math

from flint import fmpq

from lure.analysis.inequality.multiplier_search import CAP, TOLERANCE, Cut, admissible, choice, upper_bound
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.verdict import Answer, Bracket, Evidence, Verdict
from lure.arrays import np
from lure.classes import NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.frequency_data import FrequencyData

_REASON = (
    "nothing is known between and beyond the {count} frequencies, nor of the poles: at them alone the {name} criterion "
    "allows up to {reach:.6g}; fit a model to certify a sector"
)


def largest_sampled(data: FrequencyData, name: str) -> Answer:
    r"""How far a criterion can reach at best, judged at the frequencies of a measurement.

    ``1/k + Re[(1 + i omega theta) H(i omega)] >= 0`` must hold at each of them; ``theta = 0`` for the circle criterion.

    Parameters
    ----------
    data : FrequencyData
        The measurement.
    name : {"circle", "popov"}
        The criterion.

    Returns
    -------
    Answer
        INCONCLUSIVE on observed evidence: ``largest.low`` is 0, ``largest.high`` what the samples allow.

    Raises
    ------
    AssumptionError
        There is no such criterion for samples, or one of them is not finite: a pole on the axis.
    """
    if name not in ("circle", "popov") or (name == "popov" and data.dt is not None):
        raise AssumptionError(
            f"the criterion {name} is not evaluated on samples of this kind; ask circle", code=Reason.SAMPLED
        )
    if not np.isfinite(data.response).all():
        place = float(data.omega[int(np.argmin(np.isfinite(data.response)))])
        raise AssumptionError(
            f"the response is not finite at {place:g} rad/s, a pole on the axis; leave it out", code=Reason.UNSTABLE
        )
    theta, least = (0.0, float(data.response.real.min())) if name == "circle" else _best(data)
    reach = -1 / least if least < 0 else math.inf
    expression = data.response.real - theta * data.omega * data.response.imag
    return Answer(
        criterion=name,
        theorem=f"{name} criterion, at sampled frequencies only",
        largest=Bracket(0.0, reach),
        nonlinearity_class=NonlinearityClass(sector=Sector(0, reach), time_varying=name == "circle"),
        verdict=Verdict.INCONCLUSIVE,
        evidence=Evidence.OBSERVED,
        theta=theta if name == "popov" else None,
        worst_frequency=float(data.omega[int(np.argmin(expression))]),
        hypotheses=("all poles stable: assumed", "the inequality between the samples: not known"),
        reason=_REASON.format(count=len(data.omega), name=name, reach=reach),
        code=Reason.SAMPLED,
    )


def _best(data: FrequencyData) -> tuple[float, float]:
    """The multiplier that raises the least value over the samples most, and that value: at most 0."""
    slopes = -data.omega * data.response.imag
    rows = zip(data.response.real.tolist(), slopes.tolist(), strict=True)
    cuts = [CAP, *(Cut(to_fmpq(u), to_fmpq(w)) for u, w in rows)]
    top = upper_bound(cuts).value
    window = admissible(cuts, top + TOLERANCE * top)  # None: only a theta that grows without bound comes close
    theta = fmpq(0) if window is None else choice(window)
    return float(to_fraction(theta)), float(to_fraction(top))

"""Circle and Popov criteria on measured frequency responses: bounds on their reach, and no proof."""

from __future__ import annotations

import math
from fractions import Fraction

from flint import fmpq

from lure.analysis.inequality.multiplier_search import CAP, TOLERANCE, Cut, admissible, choice, upper_bound
from lure.analysis.inequality.protocol import Best, Grounds
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.verdict import Bracket, Evidence
from lure.arrays import np
from lure.errors import AssumptionError, Reason
from lure.plants.frequency_data import FrequencyData
from lure.record import described, quantity


@described(frozen=True, slots=True)
class SampledInequality:
    r"""``1/k + Re[(1 + i omega theta) H(i omega)] >= 0`` at the frequencies of a measurement, which proves nothing."""

    data: FrequencyData = quantity("The measurement")
    lower: Fraction = quantity("0: the response of a shifted loop is not looked at")
    weighted: bool = quantity("Whether there is a ``theta``; else it is 0, as in the circle criterion")

    @property
    def grounds(self) -> Grounds:
        """Nothing is known but the samples."""
        return Grounds(
            lower=self.lower,
            discrete=self.data.dt is not None,
            poles="all poles stable: assumed",
            means="samples, and nothing is known between them",
            evidence=Evidence.OBSERVED,
        )

    def best(self, enough: Fraction | None = None) -> Best:
        """What the samples allow at best.

        Raises
        ------
        AssumptionError
            A sample is not finite: a pole on the axis.
        """
        data = self.data
        if not np.isfinite(data.response).all():
            place = float(data.omega[int(np.argmin(np.isfinite(data.response)))])
            raise AssumptionError(
                f"the response is not finite at {place:g} rad/s, a pole on the axis; leave it out", code=Reason.UNSTABLE
            )
        theta, least = _best(data) if self.weighted else (0.0, float(data.response.real.min()))
        allowed = -1 / least if least < 0 else math.inf
        expression = data.response.real - theta * data.omega * data.response.imag
        return Best(
            multiplier={"theta": Fraction(theta)} if self.weighted else {},
            largest=Bracket(0.0, allowed),
            worst_frequency=float(data.omega[int(np.argmin(expression))]),
            formula="1 + theta s" if self.weighted else "1",
            reason=f"nothing is known between and beyond the {len(data.omega)} frequencies, nor of the poles: at them "
            f"alone the inequality allows up to {allowed:.6g}; fit a model to certify a sector",
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

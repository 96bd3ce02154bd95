"""Every criterion for a rod and its scheme, and the responses they rest on computed twice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lure.analysis.rod.popov import rod_circle_criterion, rod_popov_criterion
from lure.analysis.verdict import CriterionResult
from lure.rod.discretisation import UpwindScheme
from lure.rod.transfer import RodPlant

LARGEST_DENSE_CELLS = 200
QUICK_CELLS = 50


def rod_criteria(scheme: UpwindScheme) -> tuple[CriterionResult, ...]:
    """Popov's and the circle criterion, for the scheme and for the rod, in the sector of the rod's contact law.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, with its rod.

    Returns
    -------
    tuple of CriterionResult
        Popov and circle for the scheme, then for the rod.
    """
    sector, rod = scheme.rod.nonlinearity.sector, RodPlant(scheme.rod)
    return (
        rod_popov_criterion(scheme, sector),
        rod_circle_criterion(scheme, sector),
        rod_popov_criterion(rod, sector),
        rod_circle_criterion(rod, sector),
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class ResponseCheck:
    """The frequency response of a scheme by python-control and by the closed form.

    Attributes
    ----------
    frequencies : int
        Number of frequencies compared, 0 if skipped.
    lowest, highest : float
        Their range [rad/s].
    difference : float or None
        Largest relative difference.
    skipped : str or None
        Why nothing was compared.
    """

    frequencies: int
    lowest: float
    highest: float
    difference: float | None
    skipped: str | None

    def __str__(self) -> str:
        if self.difference is None:
            return f"python-control was not asked: {self.skipped}."
        return (
            f"python-control and the closed form agree within {self.difference:.1e} (relative) at {self.frequencies} "
            f"frequencies from {self.lowest:.3g} to {self.highest:.3g} rad/s."
        )


def response_check(scheme: UpwindScheme) -> ResponseCheck:
    """Compare ``H_N(i omega)`` from the matrices (python-control) with the closed form.

    The two share the parameters and nothing else.  At 200 frequencies up to 50 cells, at 20 up to 200 cells; above
    that, where a dense response takes minutes; the
    verdicts do not rest on it.
    """
    slow, fast = 1e-3 / scheme.rod.travel_time, 4.0 * scheme.rate
    if scheme.cells > LARGEST_DENSE_CELLS:
        reason = f"a dense response of order {scheme.order} takes too long (limit: {LARGEST_DENSE_CELLS} cells)"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    if not scheme.rod.damping:
        reason = "with k = 0 the poles lie on the imaginary axis"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    frequencies = 200 if scheme.cells <= QUICK_CELLS else 20
    omega = np.geomspace(slow, fast, frequencies)
    closed = scheme.transfer(1j * omega)
    try:
        response = np.asarray(scheme.frequency_response(omega).frdata).ravel()
    except np.linalg.LinAlgError:
        reason = "its matrices are singular to working precision at some frequency"
        return ResponseCheck(frequencies=0, lowest=slow, highest=fast, difference=None, skipped=reason)
    difference = float(np.max(np.abs(response - closed) / np.abs(closed)))
    return ResponseCheck(frequencies=frequencies, lowest=slow, highest=fast, difference=difference, skipped=None)

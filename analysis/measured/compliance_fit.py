"""A fitted law of normal compliance with what is known of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.measured.mean_law import Noise
from lure.analysis.measured.measured_sector import Outlier
from lure.analysis.measured.measurements import Direction, Measurements
from lure.analysis.numerics.doubles import json_number
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError
from lure.nonlinearities.protocol import NormalCompliance
from lure.record import by_value

if TYPE_CHECKING:
    import xarray

    from lure.analysis.plots.measured import Axes

NAMES = ("eps", "gap", "m")
_MISFIT = 0.01


@dataclass(frozen=True, kw_only=True, slots=True)
class Parameter:
    """A fitted parameter.

    Attributes
    ----------
    value : float
        Its best value.
    error : float
        Standard uncertainty, linearised.
    single : tuple of float
        Interval for this parameter alone, from its profile likelihood; ends may be infinite.
    joint : tuple of float
        Side of the box around the likelihood region of all three parameters: all three lie within theirs at once with
        at least the confidence.
    """

    value: float
    error: float
    single: tuple[float, float]
    joint: tuple[float, float]


@by_value
@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class ComplianceFit:
    """``p = max(u - gap, 0)^m / eps`` fitted to measurements; see :func:`fit_compliance` for the assumptions.

    Attributes
    ----------
    measurements : Measurements
        The rows fitted.
    confidence : float
        Of the intervals.
    parameters : Mapping of str to Parameter
        ``eps`` [m^m / unit of the load], ``gap`` [m], ``m`` [-].
    correlation : ndarray
        (3, 3) of ``log eps``, ``gap``, ``m``, linearised.
    noise : Noise
        Standard deviation of a reading.
    scores : ndarray
        (n,) residuals in standard deviations.
    outliers : tuple of Outlier
        Rows left out; ``index`` is that in the whole file.
    misfit : float
        p-value of this law against a free one: small means that the data contradict the law.
    explained : float
        Weighted share of the variance of the load that the law explains.
    in_contact : int
        Rows beyond the fitted gap.
    branch : str or None
        The branch fitted, None for all rows.
    note : str
        A remark on hysteresis, or nothing.
    """

    measurements: Measurements
    confidence: float
    parameters: Mapping[str, Parameter]
    correlation: NDArray[np.float64]
    noise: Noise
    scores: NDArray[np.float64]
    outliers: tuple[Outlier, ...]
    misfit: float
    explained: float
    in_contact: int
    branch: Direction | None
    note: str

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: a fit proves nothing of the law."""
        return Evidence.OBSERVED

    @property
    def law(self) -> NormalCompliance:
        """The fitted law of the penetration ``u - gap``, as a rod takes it if the load is a stress.

        Raises
        ------
        AssumptionError
            ``1/eps`` is not a finite double.
        """
        eps = self.parameters["eps"].value
        if not 1e-300 < eps < 1e300:
            raise AssumptionError(f"eps is {eps:g}, and 1/eps no double; give the measurements in other units")
        return NormalCompliance(stiffness=1 / eps, exponent=self.parameters["m"].value)

    def __call__(self, displacement: ArrayLike) -> NDArray[np.float64]:
        """The fitted load [unit of the load] at a displacement [m], elementwise."""
        return self.law(np.asarray(displacement, dtype=float) - self.parameters["gap"].value)

    @property
    def stated(self) -> bool:
        """Whether the intervals have the confidence: the data show no loop and do not contradict the law."""
        return not self.note and self.misfit >= _MISFIT

    @property
    def conclusion(self) -> str:
        """The fit in a sentence, with what it rests on."""
        eps, gap, m = (self.parameters[name] for name in NAMES)
        sure = f"all three within at once with at least {100 * self.confidence:g} % confidence, if the law and "
        sure += "independent normal errors are assumed (observed, not proved)."
        if not self.stated:
            sure = "no confidence is stated, since the data contradict the law (observed, not proved)."
        return (
            f"Fitted p = max(u - gap, 0)^m / eps: eps = {eps.value:.4g} in {_span(eps.joint)} m^m/"
            f"{self.measurements.unit}, gap = {gap.value:.5g} in {_span(gap.joint)} m, m = {m.value:.4g} in "
            f"{_span(m.joint)}; {sure}"
        )

    def plot(self, *, ax: Axes | None = None) -> tuple[Axes, Axes]:
        """The data, the fitted law and the residuals; see :func:`lure.analysis.plots.plot_compliance`.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from lure.analysis.plots.measured import plot_compliance

        return plot_compliance(self, ax=ax)

    def to_xarray(self) -> xarray.Dataset:
        """Rows with the fitted load, and the parameters with their intervals, as an ``xarray.Dataset`` with units.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        from lure.analysis.measured.export import fit_dataset

        return fit_dataset(self)

    def _repr_html_(self) -> str:
        from lure.analysis.measured.export import fit_html

        return fit_html(self)

    def to_dict(self) -> dict[str, Any]:
        """The fit as plain data; infinite numbers are the text ``inf``."""
        unit = self.measurements.unit
        units = {"eps": f"m^m/{unit}", "gap": "m", "m": "1"}
        return {
            "evidence": str(self.evidence),
            "confidence": self.confidence,
            "branch": self.branch,
            "parameters": {
                name: {
                    "value": found.value,
                    "standard_uncertainty": json_number(found.error),
                    "single": [json_number(end) for end in found.single],
                    "joint": [json_number(end) for end in found.joint],
                    "unit": units[name],
                }
                for name, found in self.parameters.items()
            },
            "correlation": {"of": ["log eps", "gap", "m"], "matrix": self.correlation.tolist()},
            "noise": {"constant": self.noise.constant, "proportional": self.noise.proportional},
            "outliers": [{"row": o.index, "line": o.line, "deviations": o.score} for o in self.outliers],
            "rows": len(self.measurements),
            "in_contact": self.in_contact,
            "misfit": self.misfit,
            "explained": self.explained,
            "warnings": list(self.warnings),
            "conclusion": self.conclusion,
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """What speaks against the fit."""
        found = [self.note] if self.note else []
        if self.misfit < _MISFIT:
            found.append(
                f"The data contradict the law (p = {self.misfit:.1g} against a free one): the intervals say nothing."
            )
        return tuple(found)

    def __str__(self) -> str:
        lines = [self.conclusion]
        for name in NAMES:
            p = self.parameters[name]
            lines.append(f"  {name} = {p.value:.5g} +- {p.error:.2g}, alone in {_span(p.single)}")
        pairs = ", ".join(
            f"{('log eps', 'gap', 'm')[i]} and {('log eps', 'gap', 'm')[j]} {self.correlation[i, j]:+.3f}"
            for i, j in ((0, 1), (0, 2), (1, 2))
        )
        lines.append(f"  correlations: {pairs}")
        lines.append(
            f"  {self.in_contact} of {len(self.measurements)} rows in contact, {100 * self.explained:.2f} % of the "
            f"variance explained, noise {self.noise.constant:.3g} {self.measurements.unit} + "
            f"{100 * self.noise.proportional:.2g} % of the load, p = {self.misfit:.2g} against a free law"
        )
        if self.outliers:
            lines.append(
                f"  outliers, left out: {', '.join(f'line {o.line} ({o.score:+.1f})' for o in self.outliers[:8])}"
            )
        return "\n".join([*lines, *(f"  warning: {text}" for text in self.warnings)])


def _span(ends: tuple[float, float]) -> str:
    return f"[{ends[0]:.4g}, {ends[1]:.4g}]"

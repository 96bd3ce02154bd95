"""A fitted law of normal compliance with what is known of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.analysis.drawing import drawing
from lure.analysis.measured.mean_nonlinearity import Noise
from lure.analysis.measured.measured_sector import Outlier, left_out
from lure.analysis.measured.measurements import Direction, Measurements
from lure.analysis.verdict import Evidence
from lure.errors import AssumptionError
from lure.nonlinearities.protocol import NormalCompliance
from lure.record import Column, Page, Record, derived, quantity

if TYPE_CHECKING:
    from lure.analysis.drawing import Axes

NAMES = ("eps", "gap", "m")
_MISFIT = 0.01


class Parameter(Record):
    """A fitted parameter."""

    value: float = quantity("Its best value")
    error: float = quantity("Standard uncertainty, linearised", key="standard_uncertainty")
    single: tuple[float, float] = quantity(
        "Interval for this parameter alone, from its profile likelihood; ends may be infinite"
    )
    joint: tuple[float, float] = quantity(
        "Side of the box around the likelihood region of all three parameters: all three lie within theirs at "
        "once with at least the confidence"
    )


class ComplianceFit(Record):
    """``p = max(u - gap, 0)^m / eps`` fitted to measurements; see :func:`fit_compliance` for the assumptions."""

    measurements: Measurements = quantity("The rows fitted", key="rows", plainly=len)
    confidence: float = quantity("Of the intervals")
    parameters: Mapping[str, Parameter] = quantity("``eps`` [m^m / unit of the load], ``gap`` [m], ``m`` [-]", key="")
    correlation: NDArray[np.float64] = quantity("(3, 3) of ``log eps``, ``gap``, ``m``, linearised", key="")
    noise: Noise = quantity("Standard deviation of a reading")
    scores: NDArray[np.float64] = quantity("(n,) residuals in standard deviations", key="")
    outliers: tuple[Outlier, ...] = quantity("Rows left out; ``index`` is that in the whole file")
    misfit: float = quantity("p-value of this law against a free one: small means that the data contradict the law")
    explained: float = quantity("Weighted share of the variance of the load that the law explains")
    in_contact: int = quantity("Rows beyond the fitted gap")
    branch: Direction | None = quantity("The branch fitted, None for all rows")
    note: str = quantity("A remark on hysteresis, or nothing", key="")

    @property
    @derived()
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
    @derived()
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
        made: tuple[Axes, Axes] = drawing(self)(self, ax=ax)
        return made

    def to_dict(self) -> dict[str, Any]:
        """The fit as plain data; infinite numbers are the text ``inf``."""
        units = {"eps": f"m^m/{self.measurements.unit}", "gap": "m", "m": "1"}
        return super().to_dict() | {
            "parameters": {name: found.to_dict() | {"unit": units[name]} for name, found in self.parameters.items()},
            "correlation": {"of": ["log eps", "gap", "m"], "matrix": self.correlation.tolist()},
        }

    def _columns(self) -> dict[str, Column]:
        """Rows with the fitted load, and the three parameters, which have units of their own, with their intervals."""
        data, of = self.measurements, ("parameter", "parameter_")
        found = data._columns() | {
            "fitted_load": Column(("row",), self(data.displacement), data.unit, "load of the fitted law"),
            "fit_score": Column(("row",), self.scores, "1", "residual of the fit in standard deviations"),
            "correlation": Column(of, self.correlation, "1", "correlation of log eps, gap and m, linearised"),
            "end": Column(("end",), np.array(["low", "high"], dtype=object), "1", "end of an interval"),
        }
        units = {"eps": f"m{self.parameters['m'].value:.6g} {data.unit}-1", "gap": "m", "m": "1"}
        for name, parameter in self.parameters.items():
            unit, joint = units[name], f"interval of {name} with all three inside at once"
            error = f"standard uncertainty of {name}, linearised"
            found[f"fit_{name}"] = Column((), parameter.value, unit, f"fitted {name} of max(u - gap, 0)^m / eps")
            found[f"fit_{name}_error"] = Column((), parameter.error, unit, error)
            found[f"fit_{name}_joint"] = Column(("end",), parameter.joint, unit, joint)
        names = np.array(["log eps", "gap", "m"], dtype=object)
        return found | {dim: Column((dim,), names, "1", "parameter of the law") for dim in of}

    def _attributes(self) -> dict[str, object]:
        return self.measurements._attributes() | {
            "title": "Normal compliance fitted to measurements",
            "evidence": str(self.evidence),
            "comment": self.conclusion,
            "confidence": self.confidence,
            "warnings": "; ".join(self.warnings),
        }

    def _page(self) -> Page:
        units = {"eps": f"m^m/{self.measurements.unit}", "gap": "m", "m": "1"}
        rows = [
            (f"{name} [{units[name]}]", f"{p.value:.6g}", f"{p.error:.2g}", _span(p.single, 5), _span(p.joint, 5))
            for name, p in self.parameters.items()
        ]
        head = ("parameter", "value", "uncertainty", "interval, alone", "interval, all three at once")
        notes = [self.conclusion, *self.warnings, *left_out(self.outliers)]
        return Page("p = max(u - gap, 0)^m / eps, fitted", rows, head, "OBSERVED", notes)

    @property
    @derived()
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


def _span(ends: tuple[float, float], digits: int = 4) -> str:
    return f"[{ends[0]:.{digits}g}, {ends[1]:.{digits}g}]"

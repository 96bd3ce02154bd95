"""What a Popov plot shows, and what stands behind it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.answer import Answer
from analysis.answers import Largest
from analysis.criteria.result import CriterionResult
from analysis.doubles import text_below
from analysis.evidence import Evidence
from analysis.graphical.axis import Drawable
from analysis.graphical.behind import ROUNDING, behind, drawn_dataset, drawn_dict, least, proof_row
from analysis.graphical.page import block_text, span_text, with_figure
from lure.showing import html_table
from lure.values import by_value

if TYPE_CHECKING:
    import control
    import xarray

    from analysis.plots.responses import Axes

CRITERION = "Popov's criterion"


@by_value
@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PopovResponse:
    r"""A curve ``(Re H, omega Im H)``, the Popov line beside it, and what proves the sector of the line, if anything.

    For ``mu = -phi(sigma)``, ``sigma = H mu`` and the sector ``[0, k]`` the line ``Re H = theta omega Im H - 1/k``
    passes through ``-1/k`` with slope ``1/theta``; the criterion asks that the whole curve lie to its right.  The curve
    here is finitely many points: OBSERVED, whatever it looks like.

    Attributes
    ----------
    block : RationalBlock, DelayBlock, StateSpaceBlock, FrequencyData, UpwindScheme or RodBlock
        The block, in continuous time.
    omega : ndarray
        (m,) frequencies [rad/s].
    values : ndarray
        (m,) ``H(i omega)``; nan where a pole is met.
    k : float or None
        Upper end of the sector of the line, possibly ``inf``; None where there is no line to draw.
    theta : float or None
        Its multiplier [s].
    found : Largest or None
        What :func:`analysis.max_sector` says, where the line was taken from it.
    answer : Answer, CriterionResult or None
        What Popov's criterion says of exactly this line, where ``k`` or ``theta`` was given.
    reason : str
        Why nothing stands behind the line, or there is none; empty where something does.
    """

    block: Drawable
    omega: NDArray[np.float64]
    values: NDArray[np.complex128]
    k: float | None
    theta: float | None
    found: Largest | None
    answer: Answer | CriterionResult | None
    reason: str

    @property
    def expression(self) -> NDArray[np.float64]:
        """(m,) ``1/k + Re[(1 + i omega theta) H]``, the distance of each point from the line along the real axis."""
        if self.k is None or self.theta is None:
            return np.full(self.omega.size, np.nan)
        return 1.0 / self.k + self.values.real - self.theta * self.omega * self.values.imag

    @property
    def margin_seen(self) -> float | None:
        """Least of them over the points drawn, negative where the curve crosses the line: OBSERVED."""
        return None if self.worst is None else float(self.expression[self.worst])

    @property
    def worst(self) -> int | None:
        """Where in ``omega`` that is; None without a line."""
        return least(self.expression)

    @property
    def evidence(self) -> Evidence:
        """OBSERVED: what a drawing is.  See ``answer`` and ``found`` for what is proved."""
        return Evidence.OBSERVED

    @property
    def behind(self) -> str:
        """What proves the sector of the line, or that nothing here does, and why."""
        return behind(self, CRITERION)

    @property
    def sector_text(self) -> str:
        """The sector of the line, for people, never larger than it is."""
        if self.k is None:
            return "none"
        return f"[0, {text_below(self.k)}{')' if self.k == math.inf and self.answer is None else ']'}"

    def __bool__(self) -> bool:
        raise TypeError("a drawing proves nothing; look at response.answer or response.found")

    def __str__(self) -> str:
        head = f"Popov plot of {block_text(self.block)}, {span_text(self.omega)}"
        if self.k is None or self.theta is None:
            return f"{head}, without a line. A drawing proves nothing; {self.behind}."
        return f"{head}: {self._seen()} (observed). The drawing proves nothing; {self.behind}."

    def _seen(self) -> str:
        assert self.k is not None
        assert self.theta is not None
        line = f"the line through {-1.0 / self.k + 0.0:.6g} with theta = {self.theta:.6g} s"
        if self.margin_seen is None:
            return f"no point is finite beside {line}"
        x, y = self.values.real, self.theta * self.omega * self.values.imag
        size = float(np.nanmax(np.where(np.isfinite(x) & np.isfinite(y), np.abs(x) + np.abs(y), 0.0)))
        if abs(self.margin_seen) <= ROUNDING * size:
            return f"the curve touches {line}, to rounding"
        where = "to the right of" if self.margin_seen > 0 else "on the wrong side of"
        verb = "keeps at least" if self.margin_seen > 0 else "comes as far as"
        return f"the curve {verb} {abs(self.margin_seen):.4g} {where} {line}"

    def plot(self, ax: Axes | None = None) -> Axes:
        """The curve, the line with its forbidden side, the sector and the least distance seen.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; by default a new figure.
        """
        from analysis.plots.responses import plot_popov_response

        return plot_popov_response(self, ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON data, the curve with it; infinite numbers are the text ``inf``."""
        return drawn_dict(self, "popov response", {"k": self.k, "theta": self.theta})

    def to_xarray(self) -> xarray.Dataset:
        """The curve and its distance from the line over ``omega``, as real variables that netCDF can hold.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        variables = {
            "real": (self.values.real, "Re H"),
            "omega_imag": (self.omega * self.values.imag, "omega Im H"),
            "expression": (self.expression, "1/k + Re[(1 + i omega theta) H]"),
        }
        return drawn_dataset(self, variables, {"k": self.k, "theta": self.theta})

    def to_control(self) -> control.FrequencyResponseData:
        """The values drawn as a ``control.FrequencyResponseData``."""
        import control

        return control.FrequencyResponseData(self.values, self.omega)

    def _repr_html_(self) -> str:
        rows = [("block", block_text(self.block)), ("drawn", span_text(self.omega))]
        if self.k is not None and self.theta is not None:
            rows += [("sector of the line", self.sector_text), ("theta", f"{self.theta:.10g} s")]
        rows += [] if self.margin_seen is None else [("least distance seen", f"{self.margin_seen:.6g}")]
        rows.append(proof_row(self, CRITERION))
        note = "A drawing proves nothing between and beyond its points, and a line that is crossed refutes nothing."
        table = html_table("Popov plot", rows, verdict=str(self.evidence).upper(), notes=[note])
        return with_figure(lambda *, ax: self.plot(ax), table, alt=f"Popov plot: {self}")

"""A stretch of motion without change of contact, known at every instant of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.simulation.certify import Mesh, Root, Scan, mesh_of, peak, rounding, scan
from lure.analysis.rod.simulation.poisson import poisson_rows
from lure.analysis.rod.simulation.steps import Step, quadrature

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True)
class Segment:
    """A step, cut where contact begins or ends; read-only.

    Attributes
    ----------
    clock : tuple of float
        Start in units of ``1/s``, as a number and what rounding has taken from it.
    length : float
        Length in the same units; the step itself may be longer.
    contact : bool
        Whether the end is in contact with the obstacle.
    step : Step
        The motion.
    seen : Scan
        The contact coordinate on the pieces of the whole step.
    end : ndarray
        (2N+1,) scaled state at the end.
    event : Root or None
        The crossing that ends the segment.
    floor : float
        Scaled coordinate below which a touch is not told from none.
    """

    clock: tuple[float, float]
    length: float
    contact: bool
    step: Step
    seen: Scan
    end: Array
    event: Root | None
    floor: float

    def tau(self, t: Array, rate: float) -> Array:
        """Place of the instants ``t`` [s] in the segment."""
        return np.asarray(np.clip((t * rate - self.clock[0]) - self.clock[1], 0.0, self.length))

    def rows(self, tau: Array) -> Array:
        """Poisson weights at places in the segment."""
        return poisson_rows(tau, self.step.tables.columns)

    def stop(self, rate: float) -> float:
        """End of the segment [s]."""
        return (self.clock[0] + (self.clock[1] + self.length)) / rate

    def gauss(self) -> tuple[Array, Array, Array]:
        """Quadrature points and weights on the segment, and the Poisson weights there."""
        tables = self.step.tables
        if self.length == tables.length:
            return tables.gauss, tables.gauss_weights, tables.gauss_rows
        points, weights = quadrature(self.length)
        return points, weights, self.rows(points)

    def bounds(self) -> tuple[float, float]:
        """Largest value of the scaled coordinate at the edges, and a bound on the whole segment."""
        seen = self.seen if self.length == self.step.tables.length else scan(self.step.gap, self._mesh())
        return float(seen.values.max()), float(seen.uppers.max())

    def peak(self, known: float) -> float:
        """Largest scaled coordinate on the whole segment, or ``known`` if that is larger."""
        mesh = self._mesh()
        return peak(self.step.gap, mesh, known, rounding(self.step.gap, mesh))

    def _mesh(self) -> Mesh:
        tables = self.step.tables
        if self.length == tables.length:
            return tables.mesh
        inside = tables.mesh.edges < self.length
        inside[0] = True
        return mesh_of(np.append(tables.mesh.edges[inside], self.length), tables.columns)

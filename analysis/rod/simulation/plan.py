"""How long steps may be, and the tables of those already taken."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lure.analysis.rod.simulation.contact import Collocation, collocation
from lure.analysis.rod.simulation.poisson import poisson_columns, poisson_rows
from lure.analysis.rod.simulation.ring import Inputs, Ring, shifted
from lure.analysis.rod.simulation.steps import Tables, step_tables

_AMPLIFICATION = 100.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """Step lengths of a run and the tables it has made.

    Attributes
    ----------
    ring : Ring
        The scheme.
    longest : float
        Longest step in free flight, in units of ``1/s``.
    longest_contact : float
        Longest exact step in contact; zero where contact is collocated.
    tolerance : float
        Accuracy of a collocated step, relative to the speeds in the rod.
    """

    ring: Ring
    longest: float
    longest_contact: float
    tolerance: float
    _tables: dict[tuple[float, float], Tables] = field(default_factory=dict)
    _collocations: dict[float, Collocation] = field(default_factory=dict)

    def tables(self, length: float, kappa: float, *, reused: bool) -> Tables:
        """Tables for a length, kept if they will be ``reused``."""
        if not reused:
            return step_tables(self.ring, length, kappa, reused=False)
        if (length, kappa) not in self._tables:
            self._tables[length, kappa] = step_tables(self.ring, length, kappa, reused=True)
        return self._tables[length, kappa]

    def collocation(self, tables: Tables) -> Collocation:
        """Collocation matrices for a length, kept if the tables are."""
        if self._tables.get((tables.length, 0.0)) is not tables:
            return collocation(self.ring, tables)
        if tables.length not in self._collocations:
            self._collocations[tables.length] = collocation(self.ring, tables)
        return self._collocations[tables.length]


def plan_steps(ring: Ring, *, longest: float, tolerance: float) -> Plan:
    """Choose the step lengths.

    The powers of the shift must not outgrow what their Poisson average cancels: in free flight they do so only if the
    dashpot drives the rod, in contact if the spring is stiffer than about two cells of rod.

    Parameters
    ----------
    ring : Ring
        The scheme.
    longest : float
        Longest step wanted.
    tolerance : float
        Accuracy of a collocated step, relative to the speeds in the rod.
    """
    while longest * (ring.growth - 1.0) > 4.0:
        longest /= 4.0
    contact = longest if ring.exponent == 1.0 else 0.0
    probe = np.ones((2 * ring.cells + 1, 2))
    probe[:-1, 0], probe[1::2, 1] = 0.0, -1.0
    while contact > 0.0:
        columns = poisson_columns(contact * ring.growth)
        with np.errstate(over="ignore", invalid="ignore"):
            powers = shifted(ring, probe, columns, Inputs(kappa=ring.kappa)).gap
            sizes = poisson_rows(contact, columns) @ np.abs(powers)
        if sizes.max() <= _AMPLIFICATION * max(1.0, contact):
            break
        contact = contact / 4.0 if contact >= 0.05 * longest else 0.0
    return Plan(ring=ring, longest=longest, longest_contact=contact, tolerance=tolerance)

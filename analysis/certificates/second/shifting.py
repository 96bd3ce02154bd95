"""The loop shifted by the lower gain, its poles counted exactly, and whether it is well posed."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from flint import fmpq, fmpq_poly

from analysis.certificates.second.reading import NotShown, require
from analysis.certificates.second.systems import Delayed, Rational
from analysis.plant import Plant
from analysis.polynomial import is_hurwitz, root_counts, to_fraction

Case = Literal["stable", "critical"]


@dataclass(frozen=True, kw_only=True)
class Shifted:
    """The loop of ``phi - lower sigma``: ``n / (d + lower n)``, every pole stable or one simple one at 0 besides.

    Attributes
    ----------
    n : tuple of (Fraction, fmpq_poly)
        Delays and numerators; one without delay for a rational block.
    d : fmpq_poly
        In ``s`` or ``z``.
    plant : Plant or None
        None with dead time.
    case : {"stable", "critical"}
        Critical: a simple pole at ``s = 0`` (``z = 1``) whose residue is positive.
    """

    n: tuple[tuple[Fraction, fmpq_poly], ...]
    d: fmpq_poly
    discrete: bool
    plant: Plant | None
    case: Case

    @property
    def hidden(self) -> bool:
        """Whether ``n`` and ``d`` have a common factor; with dead time not decided, and so taken for granted."""
        return self.plant is None or self.plant.hidden.degree() > 0

    @property
    def feedthrough(self) -> Fraction:
        """``H(inf)`` after the shift."""
        if self.plant is None:
            return Fraction(0)
        n, degree = self.n[0][1], self.d.degree()
        return to_fraction(n[degree] / self.d[degree])


def shifted(system: Rational | Delayed, lower: Fraction) -> Shifted:
    """The loop after the shift by ``lower``; its poles are counted exactly, hidden modes included."""
    if isinstance(system, Delayed):
        require(lower == 0, "with dead time the lower bound must be 0")
        return _shifted_delayed(system)
    require(1 + lower * system.feedthrough != 0, "1 + l H(inf) vanishes: the loop is not well posed at its lower gain")
    plant = system.plant.shifted(lower)
    case = plant.case
    if case == "unstable":
        raise NotShown("the loop with the lower gain has a pole on the axis or beyond that is no simple one at 0")
    if case == "critical":
        require(plant.residue > 0, "the residue at the pole 0 is not positive")
        require(is_hurwitz(plant.hidden), "a hidden mode is not strictly stable")
    n, _ = system.polynomials
    return Shifted(n=((Fraction(0), n),), d=system.closed(lower), discrete=system.discrete, plant=plant, case=case)


def require_well_posed(direct: Fraction, lower: Fraction, upper: Fraction | str) -> None:
    """Check that ``1 + kappa D`` keeps its sign, without zero, for ``kappa`` in ``[lower, upper]``."""
    start = 1 + lower * direct
    good = start * (1 + upper * direct) > 0 if isinstance(upper, Fraction) else start != 0 and direct * start >= 0
    require(good, "1 + kappa H(inf) changes sign in the sector: the loop is not well posed")


def _shifted_delayed(system: Delayed) -> Shifted:
    counts = root_counts(system.d)
    critical = counts.axis == 1 and system.d[0] == 0
    require(counts.right == 0 and (counts.axis == 0 or critical), "a pole is not stable")
    if critical:
        residue = sum((n[0] for _, n in system.terms), fmpq(0)) / system.d[1]
        require(bool(residue > 0), "the residue at the pole 0 is not positive")
    case: Case = "critical" if critical else "stable"
    return Shifted(n=system.terms, d=system.d, discrete=False, plant=None, case=case)

"""Plants with parameters in a box and a dead time, in floating point: the best ``theta``, and where it serves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from lure.analysis.inequality.box_polynomials import Look, poles
from lure.arrays import NDArray, Reals, np
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant
from lure.plants.family import Box
from lure.plants.rational import RationalPlant

POINTS, CLOSE, STEPS, FAR = 1500, 60, 60, 0.8
ZERO = 1e-9  # of the fastest pole: a root that is meant to be at 0


def best_theta(plant: DelayPlant, *, turned: bool) -> tuple[float, float]:
    """The ``theta >= 0`` with which ``Re[(1 + i omega theta) H] + 1/k > 0`` goes farthest, and how far: estimates.

    Parameters
    ----------
    plant : DelayPlant
        The plant, of one dead time.
    turned : bool
        Whether there is a ``theta``; else it is 0.

    Raises
    ------
    AssumptionError
        A pole is not stable and no simple one at 0, or is one and ``theta`` is 0, or a term is not strictly proper.
    """
    top, bottom = ([float(c) for c in side] for side in (plant.terms[0][1], plant.denominator))
    order, roots = len(bottom) - 1, np.roots(bottom)
    size = np.abs(roots)
    still = size <= ZERO * max(size.max(), 1e-300)
    if (roots.real[~still] >= 0).any() or still.sum() > turned:
        raise AssumptionError(
            f"the plant {plant} has a pole that is not stable, or one at 0, which Popov's criterion alone covers; with "
            "dead time only stable plants, or a simple pole at 0 besides, are covered",
            code=Reason.DEAD_TIME,
        )
    if len(top) > order:
        raise AssumptionError(f"the plant {plant} is not strictly proper, which dead time needs", code=Reason.DEAD_TIME)
    wait = float(plant.terms[0][0])
    unit = max(*size, 1 / wait if wait else 0.0)
    own = np.concatenate([np.geomspace(1e-4, 30, POINTS) * unit, np.linspace(1e-3, 12, POINTS) * unit])
    near = (np.abs(roots.imag)[:, None] + np.abs(roots.real)[:, None] * np.linspace(-3, 3, CLOSE)).ravel()
    omega = np.unique(np.concatenate([own, near[near > 0]]))
    lead = top[0] / bottom[0] if len(top) == order else 0.0

    def lines(omega: Reals) -> tuple[Reals, Reals]:
        """``Re H`` and ``-omega Im H``, and what they come near to at high frequencies."""
        H = plant.transfer(1j * omega)
        return np.append(H.real, 0.0), np.append(-omega * H.imag, -abs(lead))

    def least(theta: float, lines: tuple[Reals, Reals]) -> tuple[float, int]:
        """The least value over the frequencies with one ``theta``, and where."""
        values = lines[0] + theta * lines[1]
        i = int(values.argmin())
        return float(values[i]), i

    known = lines(omega)
    theta = _highest(known) if turned else 0.0
    values = known[0] + theta * known[1]
    dips = 1 + np.flatnonzero((values[1:-2] <= values[:-3]) & (values[1:-2] <= values[2:-1]))
    for i in sorted(dips.tolist(), key=lambda i: float(values[i]))[:4]:
        omega = np.append(omega, np.linspace(omega[max(i - 1, 0)], omega[i + 1], CLOSE))
    known = lines(np.unique(omega))
    theta = _highest(known) if turned else 0.0
    low, _ = least(theta, known)
    return theta, -1 / low if low < 0 else math.inf


def _highest(lines: tuple[Reals, Reals]) -> float:
    """The ``theta >= 0`` at which the least of the lines ``a + theta b`` is highest."""
    a, b = lines
    low, high = 0.0, 1 / max(float(np.abs(b).max()), 1e-300)

    def rising(theta: float) -> bool:
        """Whether the smallest value still grows with ``theta``."""
        return bool(b[int((a + theta * b).argmin())] > 0)

    for _ in range(STEPS):
        if not rising(high):
            break
        low, high = high, 4 * high
    for _ in range(STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if rising(middle) else (low, middle)
    return low


class LateLook(Look):
    """The test of a box of plants with dead time, as the checker makes it, at many frequencies.

    Parameters
    ----------
    family : PlantFamily
        The plants.
    name : str
        The criterion.
    gains : tuple of Fraction
        The bounds of the class.
    """

    def _frequencies(self) -> Reals:
        """Those of the poles and of the turns of the dead time."""
        _, wait = self.family.waits(self.family.box)
        near = np.concatenate([poles(self.family.undelayed(p), Fraction(0)) for p in self._points()])
        sizes = np.append(np.abs(near[np.abs(near) > 0]), 1 / float(wait))
        far = np.geomspace(min(sizes) / 300, max(sizes) * 30, 200)
        even = np.linspace(0, 12, 400)[1:] / float(wait)
        close = (np.abs(near.imag)[:, None] + np.abs(near.real)[:, None] * np.linspace(-2, 2, 9)).ravel()
        return np.concatenate([far, even, close[close > 0]])

    def _forms(self, box: Box, cross: NDArray[np.complex128], square: Reals, omega: Reals) -> Reals:
        """The least coefficient of ``F`` with any dead time of the box."""
        low, high = (float(v) for v in self.family.waits(box))
        middle, x = (low + high) / 2, omega * (high - low) / 2
        plain, real, imaginary = (self._coefficients(part) for part in (square, cross.real, cross.imag))
        late = real + 1j * imaginary
        wide = 1 / np.maximum(1 - x**2 / 2, 0.5)
        turns = [np.exp(-1j * omega * low), np.exp(-1j * omega * high), wide * np.exp(-1j * omega * middle)]
        shown = np.minimum.reduce([plain + (late * turn).real for turn in turns])
        least: Reals = np.where(x < FAR, shown, plain - np.abs(late)).min(axis=tuple(range(plain.ndim - 1)))
        return least

    def widest(self, box: Box) -> int:
        """The parameter that changes the plants most over a box, by its share of the dead time, too.

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            Where the parameters are.
        """
        changes = self._changes(box)
        k = float(self.gains[1])
        n, d = self._at(np.array([float(low + high) / 2 for low, high in box]), self.sides)
        share = k * np.abs(n) / (np.abs(d) + k * np.abs(n))
        for j, (c, (low, high)) in enumerate(zip(self.family.delay[1:], box, strict=True)):
            turn = np.minimum(self.omega * float(abs(c) * (high - low)), 2.0)
            changes[j] += float(np.max(turn * share))
        return max(range(len(box)), key=changes.__getitem__)


def likeliest(plant: RationalPlant | DelayPlant, name: str, upper: Fraction) -> Mapping[str, Any] | None:
    """The multiplier of a criterion for a class ``[0, upper]``; None where it does not reach so far.

    Parameters
    ----------
    plant : DelayPlant
        The plant.
    name : {"circle", "popov"}
        The criterion.
    upper : Fraction
        The end of the class.

    Raises
    ------
    AssumptionError
        The plant is not covered.
    """
    assert isinstance(plant, DelayPlant), "asked of plants with dead time"
    theta, reach = best_theta(plant, turned=name == "popov")
    if not reach > upper:
        return None
    return {"theta": str(Fraction(f"{theta:.12g}"))} if name == "popov" else {}

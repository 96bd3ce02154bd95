"""Plants with parameters in a box, in floating point: whether one multiplier of a criterion serves a whole box.

With a dead time: the best ``theta``, and where it serves.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import islice
from typing import Any, TypeAlias

from lure.analysis.certificates.arithmetic import Form, Rejected, real
from lure.analysis.certificates.blocks import Block, multiplier
from lure.arrays import NDArray, Reals, np
from lure.errors import AssumptionError, Reason
from lure.plants.delay import DelayPlant
from lure.plants.family import Box, PlantFamily, Point
from lure.plants.rational import RationalPlant

MOST_CORNERS = 32
Sides: TypeAlias = "tuple[NDArray[np.complex128], NDArray[np.complex128]]"
POINTS, CLOSE, STEPS, FAR = 1500, 60, 60, 0.8
ZERO = 1e-9  # of the fastest pole: a root that is meant to be at 0


class Look:
    """The test of a box in floating point: Bernstein coefficients of ``F`` and of ``Re(c* d)`` at many frequencies.

    Parameters
    ----------
    family : PlantFamily
        The plants.
    name : str
        The criterion.
    gains : tuple of Fraction
        The bounds of the class.
    """

    def __init__(self, family: PlantFamily, name: str, gains: tuple[Any, Any]) -> None:
        self.family, self.name, self.gains = family, name, gains
        self.omega = np.unique(self._frequencies())
        self.sides = self._sides(self.omega)
        self.back = [_backwards(2 * d) for d in family.degrees]

    def _frequencies(self) -> Reals:
        """Those of the poles of some plants, and of some far away."""
        points = self._points()
        near_axis = (poles(self.family.undelayed(p), gain) for p in points for gain in self.gains if gain != math.inf)
        at = np.concatenate([*near_axis])
        if self.family.dt is None:
            size = np.abs(at[np.abs(at) > 0])
            size = size if size.size else np.ones(1)
            far = np.geomspace(min(size) / 300, max(size) * 300, 160)
            near = (np.abs(at.imag)[:, None] + np.abs(at.real)[:, None] * np.linspace(-2, 2, 9)).ravel()
        else:
            far = np.geomspace(1e-3, 1e3, 160)
            angle = np.angle(at)[:, None] + (1 - np.abs(at))[:, None] * np.linspace(-2, 2, 9)
            near = np.tan(np.clip(angle.ravel() / 2, -1.57, 1.57))
        near = near[(near > 1e-9) & (near < 1e9)]
        return np.concatenate([far, near])

    def _points(self) -> Iterator[Point]:
        yield self.family.middle
        yield from islice(self.family.corners, MOST_CORNERS)

    def _sides(self, omega: Reals) -> Sides:
        """``n_e`` and ``d_e`` of each term on the axis, all over the largest coefficient."""
        s = 1j * omega
        z = s if self.family.dt is None else (1 + s) / (1 - s)
        unit = max(abs(c) for term in self.family.terms for side in term[1:] for c in side)
        top, bottom = ([np.polyval([float(c / unit) for c in one[i]], z) for one in self.family.terms] for i in (1, 2))
        return np.asarray(top, dtype=complex), np.asarray(bottom, dtype=complex)

    def _at(self, nodes: Reals, sides: Sides) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """``n`` and ``d + l n`` on the axis at some plants: a row for each."""
        weights = np.stack([np.prod(nodes ** np.array(powers), axis=-1) for powers, *_ in self.family.terms], axis=-1)
        n, d = (np.asarray(weights @ side, dtype=complex) for side in sides)
        return n, np.asarray(d + float(self.gains[0]) * n)

    def passes(self, box: Box, data: Mapping[str, Any]) -> bool:
        """Whether all coefficients are positive, between the frequencies of the grid too, where they are least.

        Parameters
        ----------
        box : tuple of (Fraction, Fraction)
            Where the parameters are.
        data : Mapping
            The multiplier as it stands in a certificate.
        """
        discrete, delayed = self.family.dt is not None, bool(self.family.delay)
        one = Block(real(1), real(1), 0, Fraction(0), discrete=discrete, delayed=delayed)
        try:
            first, _, third, fourth, _ = multiplier(self.name, dict(data), one, self.gains[1] == math.inf)
        except Rejected:
            return False
        parts = (first, third, fourth)
        seen = self._least(box, parts, self.omega, self.sides)
        if not seen.min() > 0:
            return False
        dips = np.flatnonzero((seen[1:-1] <= seen[:-2]) & (seen[1:-1] <= seen[2:])) + 1
        for i in sorted(dips, key=seen.__getitem__)[:3]:
            omega = np.linspace(self.omega[i - 1], self.omega[i + 1], 41)
            if not self._least(box, parts, omega, self._sides(omega)).min() > 0:
                return False
        return True

    def _least(self, box: Box, parts: tuple[Form, Form, Form], omega: Reals, sides: Sides) -> Reals:
        """The least coefficient at each frequency, over ``|d|^2`` in the middle."""
        low_gain, k = self.gains
        m, e, r = (_values(part, omega) for part in parts)
        width = 1.0 if k == math.inf else float(k - low_gain)
        rest = (m.real * (k < math.inf), width**2 * r.real * (k < math.inf))  # each finite bound adds a positive term
        ends = np.array([(float(low), float(high)) for low, high in box])
        _, c = self._at(ends.mean(axis=1), sides)
        shape, size = [2 * d + 1 for d in self.family.degrees], np.abs(c) ** 2
        shares = np.moveaxis(np.indices(shape), 0, -1) / np.maximum(np.array(shape) - 1, 1)
        n, d = self._at(ends[:, 0] + (ends[:, 1] - ends[:, 0]) * shares, sides)
        cross = width * (m + e) * n * d.conj() / size
        least = self._forms(box, cross, (rest[0] * np.abs(d) ** 2 - rest[1] * np.abs(n) ** 2) / size, omega)
        apart = self._coefficients((c.conj() * d).real / size)
        floor = least + (1e-12 if k == math.inf else 0.0)
        return np.asarray(np.minimum(floor, apart.min(axis=tuple(range(len(shape))))))

    def _forms(self, _box: Box, cross: NDArray[np.complex128], square: Reals, _omega: Reals) -> Reals:
        """The least coefficient of ``F``, the real part of a multiple of ``n d*`` and what does not depend on that."""
        F = self._coefficients(cross.real + square)
        return np.asarray(F.min(axis=tuple(range(F.ndim - 1))))

    def _coefficients(self, values: Reals) -> Reals:
        """Bernstein coefficients from the values at the nodes."""
        for j, back in enumerate(self.back):
            values = np.moveaxis(np.tensordot(back, values, axes=(1, j)), 0, j)
        return values

    def widest(self, box: Box) -> int:
        """The parameter that changes the plants most over a box; ``box``: where the parameters are."""
        changes = self._changes(box)
        return max(range(len(box)), key=changes.__getitem__)

    def _changes(self, box: Box) -> list[float]:
        """How much each parameter changes the plants over a box."""
        middle = np.array([float(low + high) / 2 for low, high in box])
        k = float(self.gains[1] - self.gains[0]) if self.gains[1] != math.inf else 1.0
        n, d = self._at(middle, self.sides)
        size = np.abs(d) + k * np.abs(n)
        changes = list[float]()
        for j, ends in enumerate(box):
            pair = np.array([middle, middle])
            pair[:, j] = [float(end) for end in ends]
            (n0, n1), (d0, d1) = self._at(pair, self.sides)
            changes.append(float(np.max((np.abs(d1 - d0) + k * np.abs(n1 - n0)) / np.where(size > 0, size, 1.0))))
        return changes


def poles(plant: RationalPlant, gain: Fraction) -> NDArray[np.complex128]:
    """The poles of the loop with a gain, in floating point; ``gain``: ``mu = -gain sigma``."""
    n, d = ([float(c) for c in side] for side in (plant.numerator, plant.denominator))
    return np.asarray(np.roots(np.polyadd(d, float(gain) * np.array(n))), dtype=complex)


def _values(part: Form, omega: Reals) -> NDArray[np.complex128]:
    """A sum of ``(u + i v) omega^n`` in floating point."""
    total = np.zeros(omega.shape, dtype=complex)
    for (tau, n), (u, v) in part.items():
        total = total + complex(u, v) * omega**n * np.exp(-1j * float(tau) * omega)
    return total


def _backwards(degree: int) -> Reals:
    """From the values of a polynomial at ``k/degree`` to its Bernstein coefficients."""
    t = np.arange(degree + 1) / max(degree, 1)
    basis = [[math.comb(degree, i) * x**i * (1 - x) ** (degree - i) for i in range(degree + 1)] for x in t]
    return np.asarray(np.linalg.inv(np.array(basis)))


def best_theta(plant: DelayPlant, *, turned: bool) -> tuple[float, float]:
    """The ``theta >= 0`` with which ``Re[(1 + i omega theta) H] + 1/k > 0`` goes farthest, and how far: estimates.

    ``plant``: the plant, of one dead time.  ``turned``: whether there is a ``theta``; else it is 0.

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

        ``box``: where the parameters are.
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

r"""Where a Poisson average crosses zero, and how high it rises, on whole intervals and not on samples.

For ``z(tau) = sum_n w_n(tau) z_n`` with Poisson weights, ``z'' = sum_n w_n \Delta^2 z_n``, and for every ``tau`` in
``[l, r]`` the weights obey ``w_n(tau) <= e^{r-l} w_n(r)``.  Hence on all of ``[l, r]``

.. math:: z(\tau) \le \max(z(l), z(r)) + \tfrac{(r-l)^2}{8}\, e^{r-l} \sum_n w_n(r)\,|\Delta^2 z_n| ,

a bound by the chord; the same one order higher bounds ``z'``.  An interval on which it does not settle the sign is cut
in eight until it does, so that a crossing, or a pair of crossings, can hide only below rounding.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.scheme.poisson import parted, poisson_rows, poisson_weights, window

_PIECES = 8
_NARROW = 1e-13
_MEETS = 1e-12
FLOOR = 1e-12
_EFFORT = 400
_SHORT = 2.0
_LEFT_OUT = 1e-15
EPS = float(np.finfo(float).eps)


@described(frozen=True, kw_only=True, slots=True)
class Mesh:
    """Pieces of a step."""

    edges: Array = quantity("(k,) ascending, in units of ``1/s``")
    rows: Array = quantity("(k, columns) Poisson weights at the edges")
    chord: Array = quantity("(k-1,) ``width^2 e^width / 8`` of each piece")


@described(frozen=True, kw_only=True, slots=True)
class Scan:
    """A Poisson average on a mesh."""

    values: Array = quantity("(k,) at the edges")
    errors: Array = quantity("(k-1,) how far it can leave its chord on each piece")

    @property
    def uppers(self) -> Array:
        """Upper bound on each piece."""
        return np.asarray(np.maximum(self.values[:-1], self.values[1:]) + self.errors)

    @property
    def lowers(self) -> Array:
        """Lower bound on each piece."""
        return np.asarray(np.minimum(self.values[:-1], self.values[1:]) - self.errors)


@described(frozen=True, kw_only=True, slots=True)
class Root:
    """A crossing of zero."""

    tau: float = quantity("Where, from the start of the step, in units of ``1/s``")
    resolution: float = quantity("How far rounding may have moved it, in the same units")


def mesh_of(edges: Array, columns: int) -> Mesh:
    """The mesh with the given edges."""
    widths = np.diff(edges)
    return Mesh(edges=edges, rows=poisson_rows(edges, columns), chord=0.125 * widths**2 * np.exp(widths))


def scan(gap: Array, mesh: Mesh) -> Scan:
    """Values and chord errors of the average of a sequence (columns,)."""
    bends = np.abs(gap[2:] - 2.0 * gap[1:-1] + gap[:-2])
    return Scan(values=mesh.rows[:, : gap.size] @ gap, errors=mesh.chord * (mesh.rows[1:, : bends.size] @ bends))


def rounding(gap: Array, mesh: Mesh) -> float:
    """Rounding error to be expected in values of the average."""
    return 8.0 * EPS * float((mesh.rows @ np.abs(gap)).max())


def first_root(gap: Array, mesh: Mesh, seen: Scan, floor: float) -> Root | None:
    """First point at which the average rises above ``floor``, traced back to its crossing of zero.

    ``gap``: (columns,) sequence, whose average is not above ``floor`` at the first edge; ``mesh``: where to look;
    ``seen``: the average on that mesh; ``floor``: rounding error of a value, from :func:`rounding`.

    Returns
    -------
    Root or None
        None means: the average stays nonpositive on all pieces, up to ``floor``.
    """
    values, edges = seen.values, mesh.edges
    suspects = np.flatnonzero(seen.uppers > floor)
    if suspects.size == 0:
        return None
    slopes = scan(np.diff(gap), mesh)
    steepest, gentlest = slopes.uppers, slopes.lowers
    for j in suspects:
        left, right = float(edges[j]), float(edges[j + 1])
        crossed = bool(values[j + 1] > floor)
        if not crossed and values[j] <= floor and steepest[j] <= 0.0:
            continue  # it falls all along
        if right - left <= _NARROW * max(1.0, right) or (crossed and gentlest[j] > 0.0):
            if crossed:
                return _refined(gap, (left, right), float(values[j]), floor)
            continue
        finer = mesh_of(np.linspace(left, right, _PIECES + 1), gap.size)
        found = first_root(gap, finer, scan(gap, finer), floor)
        if found is not None:
            return found
    return None


def last_root(gap: Array, mesh: Mesh, before: float, floor: float, blur: float) -> Root:
    """Last upward crossing of zero at the resolution of the mesh, before a point at which the average is positive.

    A step known to ``blur`` only is given that much: what lies below it before the point is forgiven, and the crossing
    is as uncertain as that makes it.
    """
    edges = mesh.edges
    inside = edges < before
    negative = np.flatnonzero(mesh.rows[inside] @ gap <= 0.0)
    if negative.size == 0:
        return Root(tau=0.0, resolution=min(before, float(edges[1])))
    left = int(negative[-1])
    right = float(edges[left + 1]) if left + 1 < int(inside.sum()) else before
    return _refined(gap, (float(edges[left]), right), -0.0, floor, blur)


def peak(gap: Array, mesh: Mesh, known: float, floor: float) -> float:
    """Largest value on the mesh, or ``known`` if that is larger, to about ``floor``."""
    seen = scan(gap, mesh)
    best, uppers, edges = max(known, float(seen.values.max())), seen.uppers, mesh.edges
    for j in np.argsort(-uppers):
        if uppers[j] <= best + floor:
            break
        if edges[j + 1] - edges[j] > _NARROW * max(1.0, edges[j + 1]):
            best = peak(gap, mesh_of(np.linspace(edges[j], edges[j + 1], _PIECES + 1), gap.size), best, floor)
    return best


def _refined(gap: Array, bracket: tuple[float, float], at_left: float, floor: float, blur: float = 0.0) -> Root:
    """Newton's method kept in a bracket that holds a single crossing, or is a rounding wide."""
    (low, high), tau = bracket, bracket[1]
    slope = bend = 0.0
    for _ in range(100):
        row = poisson_rows(tau, gap.size)[0]
        value, slope = float(row @ gap), float(row[:-1] @ np.diff(gap))
        bend = float(np.abs(row[:-2] @ np.diff(gap, 2)))
        if at_left > 0.0:
            tau = bracket[0]
            break
        low, high = (low, tau) if value > 0.0 else (tau, high)
        if abs(value) <= 0.125 * floor or high - low <= 2.0 * EPS * max(1.0, high):
            break
        step = tau - value / slope if slope > 0.0 else low
        tau = step if low < step < high else 0.5 * (low + high)
    error = max(floor, blur)
    uncertain = max(abs(slope), np.sqrt(0.5 * error * bend))
    return Root(tau=tau, resolution=error / uncertain if uncertain > 0.0 else bracket[1] - bracket[0])


class Undecided(Exception):
    """The sequence is so much larger than its average that bounds of it settle nothing."""


@described(frozen=True, kw_only=True, slots=True, eq=False)
class Crossing:
    """The first crossing above zero of the Poisson average of a sequence."""

    values: Array = quantity("The sequence, as far as the windows of the weights reach")
    floor: float = quantity("What counts as zero")
    effort: list[int] = quantity("How many more intervals may be looked at", default_factory=lambda: [_EFFORT])

    def at(self, tau: float, differences: int = 0) -> float:
        """The average at ``tau``, or that of the first difference, which is its slope."""
        first, weights = poisson_weights(parted(tau))
        values = self.values[first : first + weights.size + differences]
        weights = weights[: values.size - differences]
        return float(weights @ (np.diff(values, differences) if differences else values))

    def first(self, left: float, right: float) -> float | None:
        """The first crossing in ``[left, right]``; raises :class:`Undecided` if that takes too long."""
        self.effort[0] -= 1
        if self.effort[0] < 0:
            raise Undecided
        start, stop = window(left)[0], window(right)[1] + 3
        inside = self.values[start:stop]
        if inside.max() <= self.floor:
            return None
        width = right - left
        chord = 0.125 * width * width
        at_left, at_right = self.at(left), self.at(right)
        if max(at_left, at_right) + chord * self.bend(left, right, 2) <= self.floor:
            return None
        if width <= _MEETS * max(1.0, right):
            return right if at_right > self.floor else None
        if at_right > self.floor and at_left <= self.floor:
            slope = min(self.at(left, 1), self.at(right, 1))
            if slope - chord * self.bend(left, right, 3) > 0.0:
                return self.zero(left, right)
        edges = np.linspace(left, right, _PIECES + 1)
        for low, high in pairwise(edges.tolist()):
            found = self.first(low, high)
            if found is not None:
                return found
        return None

    def bend(self, left: float, right: float, order: int) -> float:
        """Bound of the derivative of that order on ``[left, right]``: no average of differences exceeds the largest.

        On short intervals also ``e^{right - left}`` times their average at ``right``, since no weight exceeds its value
        there by more; what the window leaves out of it is below rounding of the largest.
        """
        largest = float(np.abs(np.diff(self.values[window(left)[0] : window(right)[1] + 3], order)).max(initial=0.0))
        if right - left > _SHORT:
            return largest
        first, weights = poisson_weights(parted(right))
        sizes = np.abs(np.diff(self.values[first : first + weights.size + order], order))
        average = float(weights[: sizes.size] @ sizes) + _LEFT_OUT * largest
        return min(largest, math.exp(right - left) * average)

    def zero(self, left: float, right: float) -> float:
        """The one zero between a value that is not positive and one that is, by Newton's method kept in its bracket."""
        tau = right
        for _ in range(100):
            value = self.at(tau)
            left, right = (left, tau) if value > 0.0 else (tau, right)
            if abs(value) <= 0.1 * self.floor or right - left <= _MEETS * max(1.0, right):
                break
            tau -= value / self.at(tau, 1)
            if not left < tau < right:
                tau = 0.5 * (left + right)
        return tau

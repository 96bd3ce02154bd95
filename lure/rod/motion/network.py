"""Rods with several contacts, moved by d'Alembert's formula: the waves that leave their ends, from event to event."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import field

import numpy as np

from lure.errors import AssumptionError, InputError, Reason
from lure.record import described, quantity
from lure.rod.datasets import Contact
from lure.rod.motion.pieces import (
    NARROWEST,
    Array,
    basis,
    distinct,
    fitted,
    products,
    restricted,
    supremum,
    tails,
    values,
)

DEGREE, MOST_STEPS = 16, 200_000
_SAME, _RESOLVED, _NOISE = 4e-14, 4e-15, 2e-15
_STIFF = 4.0
_FLIPS = 6  # changes of contact at one instant

Function = Callable[[Array], Array]


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Network:
    r"""Rods and contacts as numbers, times in a unit ``tau`` of the longest travel time.

    With the waves ``W`` and ``X`` that arrive at ``x = L`` and at ``x = 0`` and pressures ``p``,

    .. math:: F_L = -\Lambda p, \quad F_0 = g - \Lambda_0 p, \quad v(L) = W + F_L/Z, \quad v(0) = (1 - a) X/2 + b F_0,

    the waves ``V = W + 2 F_L/Z`` and ``U = -a X + 2 b F_0`` leave, ``sigma' = S v(L) + S_0 v(0) - w'``, and ``w' =
    sum_i A_i p_i/k_o``.
    """

    seconds: float = quantity("The unit of time", "s")
    travel: Array = quantity("(n,) ``T`` of each rod [unit of time]")
    reflection: Array = quantity("(n,) ``a``")
    gain: Array = quantity("(n,) ``b``")
    impedance: Array = quantity("(n,) ``Z``")
    damping: Array = quantity("(n,) ``k``")
    far: Array = quantity("(n, m) areas ``Lambda`` on which the pressures press at ``x = L`` [m^2]")
    near: Array = quantity("(n, m) areas ``Lambda_0`` on which they press at ``x = 0`` [m^2]")
    closing: Array = quantity("(m, n) ``S``")
    opening: Array = quantity("(m, n) ``S_0``")
    areas: Array = quantity("(m,) area of each contact [m^2]")
    compliance: Array = quantity("(m,) ``eps`` of each [m/Pa]")
    gaps: Array = quantity("(m,) gap of each", "m")
    plate: float = quantity("``1/k_o`` [m/(N s)], 0 for obstacles that do not move")

    @property
    def retreat(self) -> Array:
        """(m, m) ``M`` in ``sigma' = S W + S_0 ((1 - a) X/2 + b g) - M p`` [m/(Pa s)]."""
        own = self.closing @ (self.far / self.impedance[:, None]) + self.opening @ (self.gain[:, None] * self.near)
        return np.asarray(own + self.plate * self.areas[None, :])


class Line:
    """A wave where it leaves its end: series on pieces that follow each other."""

    def __init__(self, longest: float) -> None:
        self.longest, self.scale, self.error = longest, 0.0, 0.0
        self.low: list[float] = []
        self.high: list[float] = []
        self.series: list[Array] = []
        self.sums: list[float] = []
        """Integral of the wave up to the start of each piece."""
        self.squares: list[float] = []
        """Integral of its square up to there."""

    def append(self, low: float, high: float, series: Array) -> None:
        """The next piece, joined to the last one if they are one function."""
        self.scale = max(self.scale, float(np.abs(series).sum()))
        whole = self._joined(high, series) if self.low and high - self.low[-1] <= self.longest else None
        if whole is not None:
            self.high[-1], self.series[-1] = high, whole
            return
        sums, squares = self._totals(len(self.low) - 1, 1.0) if self.low else (0.0, 0.0)
        self.low.append(low)
        self.high.append(high)
        self.series.append(series)
        self.sums.append(sums)
        self.squares.append(squares)

    def _joined(self, high: float, series: Array) -> Array | None:
        """One series for the last piece and the next, if there is one."""
        last, low, middle = self.series[-1], self.low[-1], self.high[-1]
        if abs(last.sum() - (series[::2].sum() - series[1::2].sum())) > 10 * _RESOLVED * self.scale:
            return None
        space, both = basis(len(series) - 1), np.stack((last, series))
        t = low + 0.5 * (high - low) * (space.inner + 1.0)
        x = np.stack((2.0 * (t - low) / (middle - low) - 1.0, 2.0 * (t - middle) / (high - middle) - 1.0))
        left, right = values(both, np.clip(x, -1.0, 1.0))
        whole = space.from_inner @ np.where(t < middle, left, right)
        cut = ((middle - low) - (high - middle)) / (high - low)
        parts = restricted(np.stack((whole, whole)), np.array([-1.0, cut]), np.array([cut, 1.0]))
        miss = float(np.abs(parts - both).max())
        if miss > 2 * _RESOLVED * self.scale:
            return None
        self.error += miss * (high - low)
        return np.asarray(whole)

    def _totals(self, i: int, x: float) -> tuple[float, float]:
        """Integrals of the wave and of its square up to the place ``x`` of a piece."""
        half, part = 0.5 * (self.high[i] - self.low[i]), self.series[i]
        if x < 1.0:
            half, part = half * 0.5 * (x + 1.0), restricted(part[None], np.array([-1.0]), np.array([x]))[0]
        even = 2.0 / (1.0 - np.arange(0, len(part), 2) ** 2.0)
        return (
            self.sums[i] + half * float(part[::2] @ even),
            self.squares[i] + half * float(part @ products(len(part)) @ part),
        )

    def place(self, t: float) -> tuple[int, float]:
        """The piece of an instant, and the place in it; on an edge the piece to the right."""
        i = max(bisect_right(self.low, t + _SAME) - 1, 0)
        x = ((t - self.low[i]) - (self.high[i] - t)) / (self.high[i] - self.low[i])
        return i, min(max(x, -1.0), 1.0)

    def edge(self, t: float) -> float:
        """Where the piece of an instant ends."""
        return self.high[self.place(t)[0]]

    def on(self, low: float, high: float) -> Array:
        """The series on a stretch within one piece."""
        i, a = self.place(low)
        b = min(max(((high - self.low[i]) - (self.high[i] - high)) / (self.high[i] - self.low[i]), -1.0), 1.0)
        if a == -1.0 and b == 1.0:
            return self.series[i]
        return np.asarray(restricted(self.series[i][None], np.array([a]), np.array([b]))[0])

    def at(self, t: Array) -> Array:
        """Values (n,) at instants (n,); on an edge those from the right."""
        low, high = np.array(self.low), np.array(self.high)
        i = np.clip(np.searchsorted(low, t + _SAME, side="right") - 1, 0, len(low) - 1)
        x = np.clip(((t - low[i]) - (high[i] - t)) / (high[i] - low[i]), -1.0, 1.0)
        found = values(np.array(self.series)[i], x[:, None])[:, 0]
        return np.asarray(found)

    def totals(self, t: float) -> tuple[float, float]:
        """Integrals of the wave and of its square from the first instant to this one."""
        return self._totals(*self.place(t))


@described(kw_only=True, eq=False, slots=True)
class Step:
    """What happened between two instants, as series."""

    low: float = quantity("The first instant [unit of time]")
    high: float = quantity("The last [unit of time]")
    sigma: Array = quantity("(m, N+1) how far the contacts have closed", "m")
    far: Array = quantity("(n, N+1) displacement of the ends ``x = L``", "m")
    near: Array = quantity("(n, N+1) displacement of the ends ``x = 0``", "m")
    plate: Array = quantity("(1, N+1) displacement of the obstacle", "m")
    stress: Array = quantity("(m, N+1) pressures", "Pa")
    lost: float = quantity("Energy that left since the start, at ``high``", "J", default=0.0)


@described(kw_only=True, eq=False)
class Run:
    """A motion of a network as it is made; :meth:`steps` moves it."""

    network: Network = quantity("Rods and contacts")
    forward: list[Line] = quantity("``U`` from ``x = 0`` of each rod, from ``-T`` on")
    backward: list[Line] = quantity("``V`` from ``x = L`` of each rod, from ``-T`` on")
    forces: list[Function | None] = quantity("``g`` of each rod [N] at instants [unit of time]")
    edges: list[float] = quantity("Instants at which a force may change its formula")
    sigma: Array = quantity("Where the contacts are now")
    far: Array = quantity("Where the ends ``x = L`` are now")
    near: Array = quantity("Where the ends ``x = 0`` are now")
    plate: float = quantity("Where the obstacle is", "m", default=0.0)
    error: float = 0.0
    lost: float = 0.0
    contacts: list[list[Contact]] = field(init=False)

    def __post_init__(self) -> None:
        net = self.network
        self.touching = np.asarray(self.sigma > net.gaps)
        self._depth = np.maximum(self.sigma - net.gaps, 0.0)  # apart from sigma, whose rounding a stiff contact feels
        self.contacts = [[] for _ in net.gaps]
        self._open: list[tuple[float, float, float] | None] = [
            (0.0, 0.0, 0.0) if touching else None for touching in self.touching
        ]
        self._retreat, self._scale = net.retreat, max(line.scale for line in (*self.forward, *self.backward))

    def steps(self, until: float) -> Iterator[Step]:
        """Step by step from 0 to ``until`` [unit of time].

        Raises
        ------
        AssumptionError
            There are too many steps, or contact and flight cannot be told apart.
        """
        t, flips, count, limit = 0.0, 0, 0, math.inf
        shortest = float(self.network.travel.min())
        while t < until - _SAME:
            count += 1
            if count > MOST_STEPS:
                raise AssumptionError(
                    f"the motion takes more than {MOST_STEPS} steps before {t * self.network.seconds:.4g} s: its kinks "
                    "multiply; give a shorter time, or rods whose travel times have a simpler ratio",
                    code=Reason.RANGE,
                )
            end = min(t + min(shortest, limit), until, *self._ends(t))
            step, miss = self._solved(t, end)
            while miss > _RESOLVED * self._scale and end - t > NARROWEST:
                end = t + 0.5 * (end - t)
                step, miss = self._solved(t, end)
            limit = 4.0 * (end - t)
            event, those = self._first_event(step[0])
            if those and event - t <= _SAME:
                flips += 1
                if flips > _FLIPS * len(self.sigma):
                    raise AssumptionError(
                        f"contact and flight cannot be told apart at {t * self.network.seconds:.6g} s",
                        code=Reason.RANGE,
                    )
                self._flip(those, t)
                continue
            if those:
                step, miss = self._solved(t, event)
            self.error += miss * (step[0].high - t) * self.network.seconds
            flips = 0
            self._advance(*step)
            t = step[0].high
            if those:
                self._flip(those, t)
            yield step[0]
        for i, begun in enumerate(self._open):
            if begun is not None:
                self._close(i, until, closed=False)

    def _ends(self, t: float) -> Iterator[float]:
        """Where what arrives, or a force, changes its formula next."""
        for forth, back, T in zip(self.forward, self.backward, self.network.travel.tolist(), strict=True):
            for line in (forth, back):
                yield line.edge(t - T) + T
        yield from (edge for edge in self.edges if edge > t + _SAME)

    def _solved(self, low: float, high: float) -> tuple[tuple[Step, Array, Array, Array], float]:
        """A step with the contacts as they are, the waves that leave, losses, half its length; and what is left out."""
        net, space = self.network, basis(DEGREE)
        half, travel = 0.5 * (high - low) * net.seconds, net.travel.tolist()
        arriving = [line.on(low - T, high - T) for line, T in zip(self.forward, travel, strict=True)]
        back = [line.on(low - T, high - T) for line, T in zip(self.backward, travel, strict=True)]
        W, X = np.array(arriving), np.array(back)
        push = np.array([self._force(one, low, high) for one in self.forces])
        free = 0.5 * (1 - net.reflection[:, None]) * X + net.gain[:, None] * push
        drive = net.closing @ W + net.opening @ free
        p, those = np.zeros_like(drive), np.flatnonzero(self.touching)
        if those.size:
            stiff = self._retreat[np.ix_(those, those)] / net.compliance[those][None, :]
            y = self._linear(half, stiff, self._depth[those], drive[those])
            p[those] = y / net.compliance[those][:, None]
        F_far, F_near = -net.far @ p, push - net.near @ p
        v_far, v_near = W + F_far / net.impedance[:, None], free - net.gain[:, None] * (net.near @ p)
        U = -net.reflection[:, None] * X + 2 * net.gain[:, None] * F_near
        V = W + 2 * F_far / net.impedance[:, None]
        v_plate = net.plate * (net.areas @ p)[None]
        rate = drive - self._retreat @ p
        integral = half * space.integral.T

        def moved(start: Array, speed: Array) -> Array:
            """Displacements of what had ``start``."""
            found = speed @ integral
            found[:, 0] += start
            return np.asarray(found)

        step = Step(
            low=low,
            high=high,
            sigma=moved(self.sigma, rate),
            far=moved(self.far, v_far),
            near=moved(self.near, v_near),
            plate=moved(np.array([self.plate]), v_plate),
            stress=p,
        )
        squares = products(DEGREE + 1)
        lost = half * (
            float(net.damping @ np.einsum("ij,jk,ik->i", v_near, squares, v_near))
            - float(np.einsum("ij,jk,ik->", push, squares, v_near))
            + (float((v_plate @ squares @ v_plate.T)[0, 0]) / net.plate if net.plate else 0.0)
        )
        self._scale = max(self._scale, float(np.abs(U).sum(axis=1).max()), float(np.abs(V).sum(axis=1).max()))
        miss = float(tails(np.concatenate((U, V, rate))).max())
        return (step, U, V, np.array([lost, half])), miss

    def _force(self, force: Function | None, low: float, high: float) -> Array:
        space = basis(DEGREE)
        if force is None:
            return np.zeros(DEGREE + 1)
        return np.asarray(space.from_inner @ force(low + 0.5 * (high - low) * (space.inner + 1.0)))

    def _linear(self, half: float, stiff: Array, start: Array, drive: Array) -> Array:
        """Series of ``y' = drive - stiff y``, by collocation at the extrema of ``T_N``.

        Integrated, ``(1 + h S K) y = ..``, where little happens in a step; where ``y`` follows the drive, ``(D + h S) y
        = ..``, whose rounding does not grow with the stiffness.
        """
        space, size = basis(DEGREE), len(start)
        right, one = half * drive @ space.at_ends[1:].T, np.eye(size)
        if half * float(np.abs(stiff).max()) > _STIFF:
            derivative = (space.at_ends @ space.derivative @ space.from_ends)[1:]
            matrix = np.kron(one, derivative[:, 1:]) + half * np.kron(stiff, np.eye(DEGREE))
            y = np.linalg.solve(matrix, (right - np.outer(start, derivative[:, 0])).ravel())
        else:
            matrix = np.eye(size * DEGREE) + half * np.kron(stiff, space.collocation)
            y = np.linalg.solve(matrix, (start[:, None] + right @ space.collocation.T).ravel())
        return np.column_stack((start, y.reshape(size, DEGREE))) @ space.from_ends.T

    def _first_event(self, step: Step) -> tuple[float, list[int]]:
        """The first instant at which a contact closes or opens, and which do."""
        found: list[tuple[float, int]] = []
        size = float(np.abs(step.sigma).max()) + float(self.network.gaps.max())
        noise = _NOISE * (size + self._scale * (step.high - step.low) * self.network.seconds)
        for i, series in enumerate(step.sigma):
            inside = step.stress[i] * self.network.compliance[i] if self.touching[i] else -series
            if not self.touching[i]:
                inside[0] += self.network.gaps[i]
            x = _falls(inside, noise)
            if x is not None:
                found.append((step.low + 0.5 * (step.high - step.low) * (x + 1.0), i))
        if not found:
            return math.inf, []
        first = min(found)[0]
        return first, [i for at, i in found if at - first <= _SAME]

    def _advance(self, step: Step, U: Array, V: Array, losses: Array) -> None:
        """The end of the step is where the motion is."""
        for line, wave in zip((*self.forward, *self.backward), (*U, *V), strict=True):
            line.append(step.low, step.high, wave)
        self.sigma, self.far, self.near = (side.sum(axis=1) for side in (step.sigma, step.far, step.near))
        self.plate = float(step.plate.sum())
        self.lost += float(losses[0])
        step.lost = self.lost
        even = 2.0 / (1.0 - np.arange(0, DEGREE + 1, 2) ** 2.0)
        p = step.stress
        for i in np.flatnonzero(self.touching):
            self._depth[i] = self.network.compliance[i] * float(p[i].sum())
            start, impulse, peak = self._open[i] or (step.low, 0.0, 0.0)
            impulse += float(self.network.areas[i] * losses[1] * (p[i][::2] @ even))
            self._open[i] = (start, impulse, max(peak, supremum(p[i : i + 1])[0]))

    def _flip(self, those: list[int], t: float) -> None:
        """These contacts close or open now."""
        for i in those:
            self.sigma[i], self._depth[i] = self.network.gaps[i], 0.0
            self.touching[i] = not self.touching[i]
            if self.touching[i]:
                self._open[i] = (t, 0.0, 0.0)
            else:
                self._close(i, t, closed=True)

    def _close(self, i: int, t: float, *, closed: bool) -> None:
        begun = self._open[i]
        self._open[i] = None
        if begun is not None and (t > begun[0] or not closed):
            start, impulse, peak = begun
            second = self.network.seconds
            self.contacts[i].append(
                Contact(
                    start=start * second,
                    end=t * second,
                    impulse=impulse,
                    peak_stress=peak,
                    peak_penetration=peak * float(self.network.compliance[i]),
                    closed=closed,
                )
            )


def _falls(series: Array, noise: float) -> float | None:
    """The first place in ``[-1, 1]`` where a function falls below 0 by more than rounding; None if there is none.

    By the bound ``c_0 - sum |c_k|`` on whole intervals, which are halved until it decides or the function is monotone.
    """
    stack = [(-1.0, 1.0)]
    while stack:
        low, high = stack.pop()
        part = series if high - low == 2.0 else restricted(series[None], np.array([low]), np.array([high]))[0]
        if part[0] - np.abs(part[1:]).sum() >= -noise:
            continue
        slope = basis(len(part) - 1).derivative @ part
        steady = abs(slope[0]) > np.abs(slope[1:]).sum()
        first, last = float(part[::2].sum() - part[1::2].sum()), float(part.sum())
        if steady or high - low < 1e-13:
            if first <= 0.0 and min(first, last) < -noise:
                return low
            if last >= -noise:
                continue
            left, right = low, high
            for _ in range(60):
                middle = 0.5 * (left + right)
                if not left < middle < right:
                    break
                value = float(values(series[None], np.array([[middle]]))[0, 0])
                left, right = (middle, right) if value > 0.0 else (left, middle)
            return right
        middle = 0.5 * (low + high)
        stack += [(middle, high), (low, middle)]
    return None


def begun(function: Function, length: float, breaks: list[float], longest: float) -> Line:
    """The wave that left an end before the motion began, on ``[-length, 0]``, from its initial data.

    ``function``: its values at instants; ``length``: the travel time [unit of time]; ``breaks``: instants at which it
    may jump; ``longest``: the most that a piece spans.

    Raises
    ------
    InputError
        The data are not finite.
    """

    def noisy(t: Array) -> tuple[Array, Array]:
        """With the rounding of the instants."""
        value = function(t)
        return value, np.abs(function(np.minimum(t + 2.0**-52 * length, 0.0)) - value)

    pieces, error = fitted(noisy, distinct(breaks, -length, 0.0), DEGREE, 0.0)
    line = Line(longest)
    line.scale = float(np.abs(pieces.series).sum(axis=1).max(initial=0.0))
    if not math.isfinite(line.scale):
        raise InputError("the initial data are not finite; give a formula that is finite along the rod")
    for low, high, series in zip(pieces.edges[:-1], pieces.edges[1:], pieces.series, strict=True):
        line.append(float(low), float(high), series)
    line.error += error
    return line

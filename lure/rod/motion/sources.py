r"""What reaches the end ``x = L`` apart from echoes: initial waves, the force at ``x = 0`` and the body force.

Time is counted in transits ``T``.  Along a wave the body force adds ``f/(rho A)`` per second, so that

.. math:: W(t) = -a\,[V(t - 2T) + B_2(t - T)] + 2 b\,g(t - T) + B_1(t),

where ``B_1(t)``, ``B_2(t)`` are the integrals of ``f/(rho A)`` along the forward wave that reaches ``x = L`` and the
backward wave that reaches ``x = 0`` at ``t``, with ``f = 0`` before ``t = 0``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.calculus import switches
from lure.expressions.tree import COMPARISONS, Apply, Node, names
from lure.rod.motion.chebyshev import Array
from lure.rod.motion.end_law import Boundary
from lure.rod.motion.path_integral import along_path
from lure.rod.motion.pieces import Pieces, distinct, fitted
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Sources:
    """Loads and initial data of a rod, in transits.

    Attributes
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Loads and initial data.
    echo, force_gain : float
        ``-a`` [-] and ``2 b`` [m/(N s)] of the end ``x = 0``.
    degree : int
        Degree of the pieces.
    breaks : tuple of float
        Instants at which the force may change its formula [transits].
    body_breaks : tuple of (tuple of float, tuple of float)
        Instants [transits] and places [m] at which the body force may.
    """

    rod: Rod
    scenario: Scenario
    echo: float
    force_gain: float
    degree: int
    breaks: tuple[float, ...]
    body_breaks: tuple[tuple[float, ...], tuple[float, ...]]

    def initial_wave(self) -> tuple[Pieces, float]:
        """``W`` on the first window, ``(0, 2T)``, without loads, and the error of its pieces."""
        L = self.rod.length

        def at(tau: Array, place: Array) -> Array:
            """Forward data, then the echo of backward data."""
            forward, backward = self.scenario.waves(self.rod, np.clip(place, 0.0, L))
            return np.where(tau < 1.0, forward, self.echo * backward)

        def wave(tau: Array) -> tuple[Array, Array]:
            """The data, and what the rounding of the place does to them."""
            place = L * np.abs(1.0 - tau)
            value = at(tau, place)
            return value, np.abs(at(tau, place + 2.0**-52 * L) - value)

        edges = [1.0]
        for data in (self.scenario.displacement, self.scenario.velocity):
            for place in data.breakpoints("x", 0.0, L) or ():
                edges += [1.0 - float(place) / L, 1.0 + float(place) / L]
        return fitted(wave, distinct(edges, 0.0, 2.0), self.degree, 0.0)

    def loads(self, window: int, span: float, scale: float) -> tuple[Pieces, float] | None:
        """What the loads add to ``W`` at ``2 window + tau``, ``0 <= tau <= span``; None without loads."""
        if self.scenario.free:
            return None
        origin = 2.0 * window
        edges = distinct([point - origin for point in self.load_breaks()], 0.0, span)
        return fitted(lambda tau: self.added(origin + tau), edges, self.degree, scale)

    def load_breaks(self) -> list[float]:
        """Instants [transits] at which what the loads add to ``W`` may change its formula."""
        points = [1.0, *(point + 1.0 for point in self.breaks)]
        for point in (0.0, *self.body_breaks[0]) if not self.scenario.body_force.is_zero else ():
            points += [point, point + 1.0, point + 2.0]
            for place in self.body_breaks[1]:
                points += [point + s * place / self.rod.length + k for k in (0.0, 1.0, 2.0) for s in (-1, 1)]
        return points

    def added(self, t: Array) -> tuple[Array, Array]:
        """What the loads add at the instants, and its rounding."""
        value, noise = np.zeros(len(t)), np.zeros(len(t))
        if not self.scenario.force.is_zero:
            late = t - 1.0
            moved = late + 2.0**-51 * np.maximum(np.abs(t), 1.0)
            pushed, nearby = self.force_at(late), np.where(late > 0.0, self.force_at(moved), 0.0)
            value += self.force_gain * pushed
            noise += np.abs(self.force_gain * (nearby - pushed))
        if not self.scenario.body_force.is_zero:
            value += self.body(t, np.full(len(t), self.rod.length), 1) + self.echo * self.body(t - 1.0, 0.0 * t, -1)
            noise += 1e-14 * np.abs(value).max(initial=0.0)
        return value, noise

    def force_at(self, t: Array) -> Array:
        """``g`` [N] at the instants [transits]; zero before the start."""
        late = t > 0.0
        seconds = np.where(late, t, 0.0) * self.rod.travel_time
        value = np.where(late, self.scenario.force(t=seconds), 0.0)
        if not np.isfinite(value).all():
            bad = float(seconds[~np.isfinite(value)][0])
            raise InputError(f"force.g has no finite value at t = {bad:.6g} s; give a formula that is defined there")
        return value

    def body(self, t: Array, x: Array, direction: int) -> Array:
        """Integral of ``f/(rho A)`` [m/s] along the wave that is at ``x`` at ``t`` and runs in the direction."""
        L, T = self.rod.length, self.rod.travel_time
        length = np.clip(np.minimum(x / L if direction > 0 else 1.0 - x / L, t), 0.0, None)

        def rate(times: Array, places: Array) -> Array:
            """``T f/(rho A)``."""
            load = self.scenario.body_force(t=times * T, x=np.clip(places, 0.0, L))
            if not np.isfinite(load).all():
                raise InputError(
                    "force.f has no finite value somewhere on the rod; give a formula that is defined there"
                )
            return load * (T / (self.rod.density * self.rod.area))

        return along_path(rate, (t, x, direction * L, length), self.body_breaks)


def sources(rod: Rod, scenario: Scenario, boundary: Boundary, until: float, degree: int) -> Sources:
    """The sources up to ``until`` [s].

    Raises
    ------
    InputError
        A condition in the body force is not linear in ``t`` or in ``x`` alone.
    """
    body = scenario.body_force
    instants, places = (
        sorted(float(point) for point in _switches(body, variable) if 0 < point < high)
        for variable, high in (("t", until), ("x", rod.length))
    )
    breaks = scenario.force.breakpoints("t", 0.0, until) or ()
    T = rod.travel_time
    return Sources(
        rod=rod,
        scenario=scenario,
        echo=-1.0 if boundary.clamped else -rod.reflection,
        force_gain=0.0 if boundary.clamped else 2.0 * rod.input_gain,
        degree=degree,
        breaks=tuple(float(point) / T for point in breaks),
        body_breaks=(tuple(point / T for point in instants), tuple(places)),
    )


def _switches(body: Expression, variable: str) -> frozenset[Fraction]:
    """Where the body force changes its formula in one variable; conditions in the other variable alone do not count."""
    points: frozenset[Fraction] = frozenset()
    for condition in _conditions(body.tree):
        found = switches(condition, variable) if names(condition) <= {variable} else frozenset()
        if found is None or len(names(condition)) > 1:
            raise InputError(f"force.f is {str(body)[:60]!r}; give conditions that are linear in t alone or in x alone")
        points |= found
    return points


def _conditions(node: Node) -> Iterator[Node]:
    """Every comparison, ``abs``, ``sign``, ``min`` and ``max`` in the tree."""
    if isinstance(node, Apply):
        if node.operation in (*COMPARISONS, "abs", "sign", "min", "max"):
            yield node
        for part in node.arguments:
            yield from _conditions(part)

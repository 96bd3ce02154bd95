r"""What reaches the end ``x = L`` apart from echoes: initial waves, the force at ``x = 0`` and the body force.

Time is counted in transits ``T``.  Along a wave the body force adds ``f/(rho A)`` per second, so that

.. math:: W(t) = -a\,[V(t - 2T) + B_2(t - T)] + 2 b\,g(t - T) + B_1(t),

where ``B_1(t)``, ``B_2(t)`` are the integrals of ``f/(rho A)`` along the forward wave that reaches ``x = L`` and the
backward wave that reaches ``x = 0`` at ``t``, with ``f = 0`` before ``t = 0``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, names, switches
from lure.record import described, quantity
from lure.rod.motion.end_law import Boundary, EndLaw
from lure.rod.motion.kernel_series import BLOCK, PANEL, PANELS, Counts, growth
from lure.rod.motion.pieces import LOOKS, Array, Pieces, distinct, fitted
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_MOST_PANELS = 256
Path = tuple[Array, Array, float, Array]
SPAN = 2.0 * BLOCK
_NOISE = 1e-16
Load = tuple[Array, Counts]
NO_LOAD: Load = np.empty(0), np.empty(0, dtype=np.int64)


def load_of_a_block(degree: int, panels: int = 0) -> Load:
    """Room for the panels of a block, of none so far: for those that the kernel fills, at least."""
    count = max(panels, PANELS)
    return np.empty(count * (2 * (degree + 1) + PANEL)), np.full(count + 2, -1, dtype=np.int64)


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Sources:
    """Loads and initial data of a rod, in transits."""

    rod: Rod = quantity("The rod")
    scenario: Scenario = quantity("Loads and initial data")
    echo: float = quantity("``-a`` of the end ``x = 0`` [-]")
    force_gain: float = quantity("``2 b`` of the end ``x = 0`` [m/(N s)]")
    degree: int = quantity("Degree of the pieces")
    breaks: tuple[float, ...] = quantity("Instants at which the force may change its formula [transits]")
    body_breaks: tuple[tuple[float, ...], tuple[float, ...]] = quantity(
        "Instants [transits] and places [m] at which the body force may"
    )

    def initial_wave(self) -> tuple[Pieces, float]:
        """``W`` on the first window, ``(0, 2T)``, without loads, and the error of its pieces."""
        L = self.rod.length
        if not names(self.scenario.slope.tree) | names(self.scenario.velocity.tree):
            series = np.zeros((2, self.degree + 1))
            series[0, :1], backward = self.scenario.waves(self.rod, np.zeros(1))
            series[1, :1] = self.echo * backward
            return Pieces(np.array([0.0, 1.0, 2.0]), series), 0.0

        def at(tau: Array, place: Array) -> Array:
            """Forward data, then the echo of backward data."""
            forward, backward = self.scenario.waves(self.rod, np.clip(place, 0.0, L))
            return np.where(tau < 1.0, forward, self.echo * backward)

        def wave(tau: Array) -> tuple[Array, Array]:
            """The data, and what the rounding of the place does to them."""
            place, n = L * np.abs(1.0 - tau), len(tau)
            both = at(np.concatenate((tau, tau)), np.concatenate((place, place + 2.0**-52 * L)))
            return both[:n], np.abs(both[n:] - both[:n])

        edges = [1.0]
        for data in (self.scenario.displacement, self.scenario.velocity):
            for place in data.breakpoints("x", 0.0, L) or ():
                edges += [1.0 - float(place) / L, 1.0 + float(place) / L]
        mild = _mild(self.scenario.displacement.tree) and _mild(self.scenario.velocity.tree)
        return fitted(wave, distinct(edges, 0.0, 2.0), self.degree, 0.0, 0 if mild else LOOKS)

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


@described(frozen=True, kw_only=True, eq=False, slots=True)
class Problem:
    """What the windows of one motion share."""

    sources: Sources = quantity("Loads and initial data")
    nonlinearity: EndLaw = quantity("The obstacle")
    share: float = quantity("``1/(1 + k_L/Z)``")
    transits: float = quantity("Length of the motion in ``T``")


def along_path(
    rate: Callable[[Array, Array], Array], path: Path, breaks: tuple[tuple[float, ...], tuple[float, ...]]
) -> Array:
    """Integrals (n,) of ``rate(t - s, x - step s)`` over ``0 <= s <= length``: Gauss panels between its breaks.

    ``rate``: from instants and places (any shape) to values; ``path``: end of each path, instant (n,), place (n,),
    ``step`` (place per unit of time), and ``length`` (n,); ``breaks``: instants and places between which the rate is
    smooth.

    Raises
    ------
    InputError
        Panels of 16 points, up to 256 between two breaks, do not agree to rounding with half as many.
    """
    t, x, step, length = path
    cuts = [np.zeros(len(t)), length, *(t - instant for instant in breaks[0]), *((x - p) / step for p in breaks[1])]
    edges = np.sort(np.clip(np.column_stack(cuts), 0.0, length[:, None]), axis=1)
    panels, before = 1, _panels(rate, path, edges)
    while panels < _MOST_PANELS:
        panels *= 2
        inner = np.arange(panels) / panels
        fine = edges[:, :-1, None] + np.diff(edges)[:, :, None] * inner
        value = _panels(rate, path, np.column_stack((fine.reshape(len(t), -1), edges[:, -1])))
        if np.abs(value - before).max(initial=0.0) <= 2e-15 * np.abs(value).max(initial=0.0) * panels:
            return value
        before = value
    raise InputError("force.f oscillates too fast along the rod for 4096 points a transit; give a smoother body force")


def _panels(rate: Callable[[Array, Array], Array], path: Path, edges: Array) -> Array:
    t, x, step, _ = path
    half = 0.5 * np.diff(edges)
    s = edges[:, :-1, None] + half[:, :, None] * (_NODES + 1.0)
    values = rate(t[:, None, None] - s, x[:, None, None] - step * s)
    return np.asarray(((values @ _WEIGHTS) * half).sum(axis=1))


@described(kw_only=True, slots=True)
class Panels:
    """Makes the loads of one motion as Chebyshev series on panels, block after block of 16 round trips.

    A force that is a sum of exponentials needs none of it: see :func:`lure.rod.motion.kernel_run.force_panels`.
    """

    sources: Sources = quantity("The loads")
    transits: float = quantity("Length of the motion [transits]: loads are not asked for beyond")
    scale: float = quantity("A lower bound of the size of the wave when the next block begins [m/s]")

    def of(self, block: int) -> Load:
        """The panels of a block; blocks are asked for in order.

        Returns
        -------
        panels : ndarray
            For each panel its ends from the start of its block [transits], its largest value and its error [m/s], the
            ``N + 1`` coefficients, and bounds on the k-th coefficient of a part, per k-th power of its share of the
            width.
        heads : ndarray
            The block, the number of panels, and the degree of each.

        Raises
        ------
        InputError
            More than 5000 panels are needed in a round trip, or the load is not finite.
        """
        sources, origin = self.sources, SPAN * block
        end, last = min(SPAN, self.transits - origin), sources.degree
        points = [point - origin for point in sources.load_breaks()] + [2.0 * k for k in range(1, BLOCK)]
        looks = 0 if sources.scenario.body_force.is_zero and _mild(sources.scenario.force.tree) else LOOKS
        pieces, error = fitted(
            lambda tau: sources.added(origin + tau), distinct(points, 0.0, end), last, self.scale, looks
        )
        size, count = np.abs(pieces.series).sum(axis=1), len(pieces.series)
        self.scale = max(abs(sources.echo) ** BLOCK * self.scale, float(size.max()))
        seen = np.abs(pieces.series) > _NOISE * size[:, None]
        degree = np.where(seen.any(axis=1), last - seen[:, ::-1].argmax(axis=1), 0)
        series = np.where(np.arange(last + 1) <= degree[:, None], pieces.series, 0.0)
        load, heads = load_of_a_block(last, count)
        table = load.reshape(-1, 2 * (last + 1) + PANEL)[:count]
        table[:, 0], table[:, 1], table[:, 2], table[:, 3] = pieces.edges[:-1], pieces.edges[1:], size, error / end
        table[:, PANEL : PANEL + last + 1] = series
        table[:, PANEL + last + 1 :] = np.abs(series) @ growth(last).T
        heads[0], heads[1], heads[2 : 2 + count] = block, count, degree
        return load, heads


def _mild(node: Node) -> bool:
    if not isinstance(node, Apply):
        return True
    if node.operation in ("+", "-", "*", "neg", "sin", "cos", "pi"):
        return all(_mild(part) for part in node.arguments)
    if node.operation == "/":
        return _mild(node.arguments[0]) and not names(node.arguments[1])
    if node.operation == "**":
        base, exponent = node.arguments
        return _mild(base) and isinstance(exponent, Number) and exponent.value in (0, 1, 2, 3, 4)
    return not names(node)

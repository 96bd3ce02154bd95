r"""What reaches the end ``x = L`` apart from echoes: initial waves, the force at ``x = 0`` and the body force.

Time is counted in transits ``T``.  Along a wave the body force adds ``f/(rho A)`` per second, so that

.. math:: W(t) = -a\,[V(t - 2T) + B_2(t - T)] + 2 b\,g(t - T) + B_1(t),

where ``B_1(t)``, ``B_2(t)`` are the integrals of ``f/(rho A)`` along the forward wave that reaches ``x = L`` and the
backward wave that reaches ``x = 0`` at ``t``, with ``f = 0`` before ``t = 0``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

import numpy as np

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.tree import COMPARISONS, Apply, Node, Number, names, switches
from lure.record import described, quantity
from lure.rod.motion.end_law import Boundary, EndLaw
from lure.rod.motion.kernel_series import BLOCK, PANEL, Counts, growth
from lure.rod.motion.pieces import LOOKS, NARROWEST, SAME, Array, Pieces, basis, distinct, fitted, tails
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_MOST_PANELS = 256
Path = tuple[Array, Array, float, Array]
SPAN = 2.0 * BLOCK
_CHECKS = np.array([-0.97, -0.83, -0.64, -0.43, -0.29, -0.17, 0.11, 0.26, 0.38, 0.59, 0.71, 0.9])
_MOST = 5000
_NOISE = 1e-16
Load = tuple[Array, Counts]
NO_LOAD: Load = np.empty(0), np.empty(0, dtype=np.int64)


def load_of_a_block(degree: int) -> Load:
    """Room for the two panels that :func:`lure.rod.motion.kernel_run.force_panels` fills, of no block so far."""
    return np.empty(2 * (2 * (degree + 1) + PANEL)), np.full(5, -1, dtype=np.int64)


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

    Parameters
    ----------
    rate : callable
        From instants and places (any shape) to values.
    path : tuple
        End of each path: instant (n,), place (n,), ``step`` (place per unit of time), and ``length`` (n,).
    breaks : tuple
        Instants and places between which the rate is smooth.

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
    """Makes the loads of one motion as Chebyshev series on panels, block after block, over many round trips at once.

    A panel reaches over up to 16 round trips if the load is made of sines, cosines, sums and products, which 29 points
    show as they are; of other formulas (a pulse ``exp(-t**2)`` may hide between points) a panel reaches over one round
    trip at most, as in :meth:`Sources.loads`.  What a block of 16 round trips needs does not depend on how many blocks
    are asked for at once.
    """

    sources: Sources = quantity("The loads")
    transits: float = quantity("Length of the motion [transits]: loads are not asked for beyond")
    scale: float = quantity("A lower bound of the size of the wave when the next block begins [m/s]")
    width: float = quantity(
        "With which panels begin [transits]: what half of the panels of block 0 were cut down to", default=2.0
    )

    def over(self, first: int, count: int) -> Load:
        """The panels of blocks ``first .. first + count - 1``; blocks are asked for in order.

        Returns
        -------
        panels : ndarray
            For each panel its ends from the start of its block [transits], its largest value and its error [m/s], the
            ``N + 1`` coefficients, and bounds on the k-th coefficient of a part, per k-th power of its share of the
            width.
        heads : ndarray
            The first block, the first panel of each block, the number of panels, and the degree of each.

        Raises
        ------
        InputError
            More than 5000 panels are needed in a round trip, or the load is not finite.
        """
        if not _gentle(self.sources):
            return panel_table(first, count, [self._halved(number) for number in range(first, first + count)])
        block, low, high = self._begun(first, count)
        space = basis(self.sources.degree)
        nodes = np.concatenate((space.inner, _CHECKS))
        seen = np.polynomial.chebyshev.chebvander(_CHECKS, space.degree).T
        scales: Array | None = None
        done: list[tuple[Array, ...]] = []
        while low.size:
            half = 0.5 * (high - low)[:, None]
            t = SPAN * block[:, None] + (low[:, None] + half * (nodes + 1.0))
            flat, noise = (v.reshape(t.shape) for v in self.sources.added(t.ravel()))
            if scales is None:
                scales = self._scales(block - first, np.abs(flat).max(axis=1), count)
            series = _rowwise(flat[:, : space.degree + 1], space.from_inner.T)
            miss = np.abs(_rowwise(series, seen) - flat[:, space.degree + 1 :]).max(axis=1)
            miss = np.maximum(miss, tails(series))
            allowed = 3e-15 * scales[block - first] + 8.0 * noise.max(axis=1)
            good = (miss <= allowed) | (high - low < NARROWEST)
            size = np.abs(flat[good]).max(axis=1)
            tiny = np.maximum(_NOISE * size, 0.5 * noise[good].max(axis=1))
            done.append((block[good], low[good], high[good], series[good], size, miss[good], tiny))
            block, low, high = (v[~good] for v in (block, low, high))
            self._check(block, low)
            middle = 0.5 * (low + high)
            block, low, high = np.repeat(block, 2), _woven(low, middle), _woven(middle, high)
        if first == 0:
            self.width = float(np.median(np.concatenate([np.minimum(part[2] - part[1], 2.0) for part in done])))
        return panel_table(first, count, done)

    def _halved(self, number: int) -> tuple[Array, ...]:
        """The panels of one block as :func:`lure.rod.motion.pieces.fitted` finds kinks, jumps and pulses."""
        origin = SPAN * number
        end = min(SPAN, self.transits - origin)
        points = [point - origin for point in self.sources.load_breaks()] + [2.0 * k for k in range(1, BLOCK)]
        pieces, error = fitted(
            lambda tau: self.sources.added(origin + tau), distinct(points, 0.0, end), self.sources.degree, self.scale
        )
        size = np.abs(pieces.series).sum(axis=1)
        self.scale = max(abs(self.sources.echo) ** BLOCK * self.scale, float(size.max()))
        ones = np.ones(len(size))
        return (
            number * ones,
            pieces.edges[:-1],
            pieces.edges[1:],
            pieces.series,
            size,
            error / end * ones,
            _NOISE * size,
        )

    def _begun(self, first: int, count: int) -> tuple[Counts, Array, Array]:
        """Blocks and ends of the panels to begin with."""
        breaks = np.unique([b for b in self.sources.load_breaks() if SPAN * first < b < SPAN * (first + count)])
        owner = np.floor(breaks / SPAN).astype(np.int64)
        # where a block is not whole, panels begin and end with round trips, so that their halves meet the echoes' edges
        fine = np.full(count, self.width < 2.0)
        fine[owner - first] = True
        fine |= SPAN * (np.arange(first, first + count) + 1) > self.transits
        step = 2.0 ** math.ceil(math.log2(self.width))
        grid = step * np.arange(round(SPAN / step))
        block = np.repeat(np.arange(first, first + count), np.where(fine, len(grid), 1))
        low = np.concatenate([grid if many else grid[:1] for many in fine])
        inside = SPAN * block + low < self.transits - SAME
        block, low = block[inside], low[inside]
        high = np.minimum(low + np.where(fine[block - first], step, SPAN), self.transits - SPAN * block)
        if not breaks.size:
            return block, low, high
        place = breaks - SPAN * owner
        near = np.searchsorted(SPAN * block + low, breaks, side="right") - 1
        keep = (place > low[near] + SAME) & (place < high[near] - SAME)
        owner, place, near = owner[keep], place[keep], near[keep]
        block, low = np.concatenate((block, owner)), np.concatenate((low, place))
        order = np.lexsort((low, block))
        ends = np.concatenate((high, high[near]))[order]
        block, low = block[order], low[order]
        same = block[1:] == block[:-1]
        high = ends.copy()
        high[:-1][same] = np.minimum(high[:-1][same], low[1:][same])
        wide = high - low > SAME
        return block[wide], low[wide], high[wide]

    def _scales(self, block: Counts, size: Array, count: int) -> Array:
        """Size to which errors in each block are relative."""
        largest = np.zeros(count)
        np.maximum.at(largest, block, size)
        decay = abs(self.sources.echo) ** BLOCK
        found = np.empty(count)
        for i, new in enumerate(largest.tolist()):
            found[i] = self.scale = max(decay * self.scale, new)
        return found

    def _check(self, block: Counts, low: Array) -> None:
        """Refuse loads that need more than 5000 panels in a round trip."""
        if len(low) > _MOST // 2 and np.unique((SPAN * block + low) // 2.0, return_counts=True)[1].max() > _MOST // 2:
            raise InputError(
                f"the loads and initial data need more than {_MOST} pieces in one round trip; give smoother or slower "
                "ones"
            )


def _rowwise(rows: Array, matrix: Array) -> Array:
    """The product, whose rounding in one row does not depend on how many there are, as that of BLAS may."""
    return np.asarray(np.einsum("ij,jk->ik", rows, matrix))


def _woven(first: Array, second: Array) -> Array:
    return np.column_stack((first, second)).ravel()


def panel_table(first: int, count: int, done: Sequence[tuple[Array, ...]]) -> Load:
    """Panels of some blocks, see :meth:`Panels.over`, from their blocks, ends, series, sizes, errors and noise."""
    block, low, high, series, size, miss, tiny = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.lexsort((low, block))
    starts = np.searchsorted(block[order], np.arange(first, first + count + 1))
    low, high, series, size, miss, tiny = (part[order] for part in (low, high, series, size, miss, tiny))
    seen = np.abs(series) > tiny[:, None]
    last = series.shape[1] - 1
    degree = np.where(seen.any(axis=1), last - seen[:, ::-1].argmax(axis=1), 0)
    series = np.where(np.arange(last + 1) <= degree[:, None], series, 0.0)
    table = np.empty((len(low), 2 * last + 6))
    table[:, 0], table[:, 1], table[:, 2], table[:, 3] = low, high, size, miss
    table[:, 4 : last + 5], table[:, last + 5 :] = series, _rowwise(np.abs(series), growth(last).T)
    return table.ravel(), np.concatenate(([first], starts, degree)).astype(np.int64)


def _gentle(sources: Sources) -> bool:
    """Whether the loads are sums and products of sines, cosines and few powers."""
    scenario = sources.scenario
    return scenario.body_force.is_zero and _mild(scenario.force.tree)


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


def block_count(transits: float) -> int:
    """Number of blocks of a motion."""
    return math.ceil(transits / SPAN)

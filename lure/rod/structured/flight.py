"""Free flight of the upwind scheme in one jump of any length, for very many cells."""

from __future__ import annotations

import cmath
import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError
from lure.expressions import Expression
from lure.expressions.numeric import closure
from lure.expressions.rigorous import holds, value
from lure.expressions.tree import Apply, Node, Number, Variable, names
from lure.rod.scenario import Scenario, initial_state
from lure.rod.structured.ring import Mean, Modes, Ring, mean_of, poisson_weights
from lure.rod.upwind import UpwindScheme

# Formulas of time as sums of ``t^k e^{lambda t}``: exact, where a formula is one.
#
# Between the instants at which its conditions change, a formula made of ``+ - *``, whole powers, constants, ``t``, and
# ``exp``, ``sin`` and ``cos`` of straight lines is such a sum; everything else is not, and is reported as None.

Sum: TypeAlias = Mapping[tuple[complex, int], complex]
"""Weights of ``t^k e^{lambda t}`` by ``(lambda, k)``, ``lambda`` in 1/s."""

MOST_TERMS = 64
LARGEST_POWER = 8


def exponentials(node: Node, variable: str, inside: Fraction) -> Sum | None:
    r"""The sum that a formula is around a point, or None.

    Parameters
    ----------
    node : Node
        A formula of one variable, each of whose conditions compares straight lines with rational coefficients (so that
        :meth:`lure.expressions.Expression.breakpoints` knows them all).
    variable : str
        Its name.
    inside : Fraction
        A point between two neighbouring breakpoints; the answer holds from the one to the other.

    Returns
    -------
    Mapping or None
        Weights of ``t^k e^{lambda t}``, conjugate rates with conjugate weights; at most 64 terms and ``k <= 8``.

    Examples
    --------
    >>> from lure.expressions import Expression
    >>> wave = Expression.parse("3*cos(2*t) if t > 1 else t", variables=("t",))
    >>> exponentials(wave.tree, "t", Fraction(0))
    {(0j, 1): (1+0j)}
    >>> exponentials(wave.tree, "t", Fraction(2))
    {(2j, 0): (1.5+0j), (-2j, 0): (1.5+0j)}
    """
    if not names(node):
        with np.errstate(all="ignore"):
            number = float(closure(node)({}))
        return {(0j, 0): complex(number)} if math.isfinite(number) else None
    if isinstance(node, Variable):
        return {(0j, 1): 1.0 + 0j}
    assert isinstance(node, Apply), "a number has no variables"
    chosen = _chosen(node, {variable: inside})
    if chosen is not None:
        sign, branch = chosen
        return _scaled(exponentials(branch, variable, inside), sign)
    if node.operation == "sign":
        inner = value(node.arguments[0], {variable: inside})
        return {(0j, 0): complex((inner > 0) - (inner < 0))}
    parts = [exponentials(part, variable, inside) for part in node.arguments]
    known = [part for part in parts if part is not None]
    return _combined(node, known) if len(known) == len(parts) else None


def _chosen(node: Apply, point: Mapping[str, Fraction]) -> tuple[float, Node] | None:
    """The part that ``where``, ``min``, ``max`` or ``abs`` stands for at a point, and its sign."""
    if node.operation == "where":
        condition, yes, no = node.arguments
        return 1.0, yes if holds(condition, point) else no
    if node.operation in ("min", "max"):
        first, second = node.arguments
        below = value(first, point) < value(second, point)
        return 1.0, first if below is (node.operation == "min") else second
    if node.operation == "abs":
        return (1.0 if value(node.arguments[0], point) >= 0 else -1.0), node.arguments[0]
    return None


def _combined(node: Apply, parts: list[Sum]) -> Sum | None:
    match node.operation:
        case "+":
            return _added(parts[0], parts[1])
        case "-":
            return _added(parts[0], _scaled(parts[1], -1.0))
        case "neg":
            return _scaled(parts[0], -1.0)
        case "*":
            return _multiplied(parts[0], parts[1])
        case "/":
            divisor = _constant(parts[1])
            return _scaled(parts[0], 1.0 / divisor) if divisor else None
        case "**":
            return _power(parts[0], node.arguments[1])
        case "exp" | "sin" | "cos":
            return _wave(node.operation, parts[0])
        case _:
            return None


def _added(left: Sum | None, right: Sum | None) -> Sum | None:
    if left is None or right is None:
        return None
    total = dict(left)
    for key, weight in right.items():
        total[key] = total.get(key, 0j) + weight
    return _kept(total)


def _scaled(terms: Sum | None, factor: float) -> Sum | None:
    return None if terms is None else _kept({key: factor * weight for key, weight in terms.items()})


def _multiplied(left: Sum, right: Sum) -> Sum | None:
    total: dict[tuple[complex, int], complex] = {}
    for (rate, power), weight in left.items():
        for (other, degree), factor in right.items():
            key = (rate + other, power + degree)
            total[key] = total.get(key, 0j) + weight * factor
    return _kept(total)


def _power(base: Sum, exponent: Node) -> Sum | None:
    if not isinstance(exponent, Number) or exponent.value.denominator != 1:
        return None
    if not 0 <= int(exponent.value) <= MOST_TERMS:
        return None
    result: Sum | None = {(0j, 0): 1.0 + 0j}
    for _ in range(int(exponent.value)):
        result = None if result is None else _multiplied(result, base)
    return result


def _wave(operation: str, inner: Sum) -> Sum | None:
    """``exp``, ``sin`` or ``cos`` of a straight line with real coefficients."""
    if not set(inner) <= {(0j, 0), (0j, 1)}:
        return None
    start, slope = inner.get((0j, 0), 0j).real, inner.get((0j, 1), 0j).real
    if operation == "exp":
        size = math.exp(start) if start < 700.0 else math.inf
        return _kept({(complex(slope), 0): complex(size)})
    half = 0.5 * cmath.rect(1.0, start) * (1.0 if operation == "cos" else -1j)
    return _added({(complex(0.0, slope), 0): half}, {(complex(0.0, -slope), 0): half.conjugate()})


def _constant(terms: Sum) -> float | None:
    return terms[0j, 0].real if set(terms) == {(0j, 0)} else None


def _kept(terms: Mapping[tuple[complex, int], complex]) -> Sum | None:
    """Terms with a weight; None if there are too many, or one is not finite."""
    kept = {key: weight for key, weight in terms.items() if weight}
    sound = all(cmath.isfinite(rate) and cmath.isfinite(weight) for (rate, _), weight in kept.items())
    powers = max((power for _, power in kept), default=0)
    return kept if sound and len(kept) <= MOST_TERMS and powers <= LARGEST_POWER else None


# A force at ``x = 0`` as what enters a shift register.
#
# The Poisson average of ``n (n-1) .. (n-k+1) (1 + lambda)^{n-k}`` is ``tau^k e^{lambda tau}``.  So a force that is a
# sum
# of such terms, with ``lambda`` in units of ``s``, is a sequence ``g_n``, and the register that takes in ``2 b g_n`` at
# its ``n``-th step has the forced motion of the scheme as its average: no fit and no step, as without a force.

Array: TypeAlias = NDArray[np.float64]

_BLOCK = 1024
_ELSEWHERE = "lure.analysis.rod.simulation.simulate takes any load, up to 1000 cells"


@dataclass(frozen=True, kw_only=True, eq=False)
class Force:
    """A force in pieces, each a sum of exponentials times powers.

    Attributes
    ----------
    rate : float
        ``s`` of the scheme [1/s].
    gain : float
        What a unit of force adds to the first wave in a step of the register [m/(N s)].
    edges : tuple of Fraction
        Where the pieces meet [s].
    pieces : tuple of Sum
        One more than edges.
    """

    rate: float
    gain: float
    edges: tuple[Fraction, ...]
    pieces: tuple[Sum, ...]

    def end(self, clock: Fraction) -> Fraction | None:
        """Where the piece that begins at or contains ``clock`` ends, both in units of ``1/s``; None for the last."""
        place = bisect_right(self.edges, clock / Fraction(self.rate))
        return Fraction(self.rate) * self.edges[place] if place < len(self.edges) else None

    def reach(self, clock: Fraction) -> int:
        """Steps of the register over which the sequence of the piece at ``clock`` keeps the size of the force."""
        rates = [abs(rate) / self.rate for rate, _ in self._piece(clock)]
        fastest = max(rates, default=0.0)
        return max(1, int(min(1e9, fastest**-2 if fastest > 0.0 else math.inf)))

    def entering(self, clock: Fraction, count: int) -> Array:
        """(count,) what enters the first wave at the steps from ``clock`` on [m/s].

        Raises
        ------
        InputError
            The force grows beyond the range of doubles.
        """
        start = float(clock / Fraction(self.rate))
        waves: dict[int, list[tuple[complex, complex]]] = {}
        with np.errstate(over="ignore", invalid="ignore"):
            for (rate, power), weight in self._piece(clock).items():
                step = rate / self.rate
                size = self.gain * weight * (2.0 if rate.imag > 0.0 else 1.0) * complex(np.exp(rate * start))
                for k in range(power + 1) if rate.imag >= 0.0 else ():  # conjugates come in pairs
                    share = math.comb(power, k) * start ** (power - k) / self.rate**k
                    waves.setdefault(k, []).append((step, size * share * (1.0 + step) ** -k))
            total, falling, n = np.zeros(count), np.ones(1), np.arange(count, dtype=float)
            for k in range(max(waves, default=-1) + 1):
                total += falling * _powers(waves[k], count) if k in waves else 0.0
                falling = falling * (n - k)
        if not np.isfinite(total).all():
            raise InputError(f"force.g grows beyond the range of doubles after {start:.6g} s; give an earlier end")
        return total

    def _piece(self, clock: Fraction) -> Sum:
        return self.pieces[bisect_right(self.edges, clock / Fraction(self.rate))]


def _powers(waves: list[tuple[complex, complex]], count: int) -> Array:
    """The sum of ``Re[weight (1 + step)^n]`` over pairs of step and weight: blocks times a block."""
    sizes = np.array([0.5 * math.log1p(step.real * (2.0 + step.real) + step.imag**2) for step, _ in waves])
    growth = sizes + 1j * np.array([math.atan2(step.imag, 1.0 + step.real) for step, _ in waves])
    blocks = np.exp(np.multiply.outer(np.arange(0, count, _BLOCK), growth)) * np.array([weight for _, weight in waves])
    inside = np.exp(np.multiply.outer(growth, np.arange(_BLOCK)))
    product = np.hstack((blocks.real, -blocks.imag)) @ np.vstack((inside.real, inside.imag))
    return np.asarray(product.ravel()[:count])


def force_of(scheme: UpwindScheme, load: Expression, until: float) -> Force | None:
    """The force of a scenario on a scheme up to ``until`` [s]; None if it is zero.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme; its form scales the force.
    load : Expression
        ``g(t)`` [N].
    until : float
        Where the motion ends [s].

    Raises
    ------
    InputError
        The formula is not piece by piece a sum of powers times exponentials, or changes faster than cells are crossed.
    """
    if load.is_zero:
        return None
    edges = load.breakpoints("t", 0, until)
    if edges is None:
        raise InputError(
            f"force.g is {str(load)[:60]}; structured_motion needs to know where its pieces meet, and so "
            f"conditions that compare straight lines in t; {_ELSEWHERE}"
        )
    bounds = (Fraction(0), *edges, Fraction(until))
    pieces = []
    for left, right in pairwise(bounds):
        piece = exponentials(load.tree, "t", (left + right) / 2)
        if piece is None:
            raise InputError(
                f"force.g is {str(load)[:60]}; structured_motion takes sums and products of numbers, t (up to t**8), "
                f"and exp, sin and cos of straight lines in t, piece by piece; {_ELSEWHERE}"
            )
        pieces.append(piece)
    fastest = max((abs(rate) for piece in pieces for rate, _ in piece), default=0.0)
    if fastest >= scheme.rate:
        least = math.floor(scheme.cells * fastest / scheme.rate) + 1
        raise InputError(
            f"force.g changes at {fastest:.3g} 1/s, faster than the {scheme.cells} cells are crossed; give at least "
            f"{least} cells"
        )
    gain = 2.0 * scheme.rod.input_gain * (1.0 if scheme.form == "corrected" else 1.0 / scheme.rate)
    return Force(rate=scheme.rate, gain=gain, edges=edges, pieces=tuple(pieces))


Way = Literal["auto", "modes", "poisson"]

_FAINT, _LOUD = math.log(0.1), math.log(10.0)
_DEAD = 2000


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeFlight:
    r"""The scheme without contact and without loads, ``y' = A y``: any time in one step.

    Its ring of ``2N`` waves is f-circulant, ``f = -a``.  Two ways to ``exp(t A)``:

    - *modes*: a scaled FFT diagonalises it (:mod:`lure.rod.structured.ring`), cost ``O(N log N)`` for any time; for
      ``0.1 <= |a| <= 10``, since scaling costs a factor ``max(|a|, 1/|a|)`` in accuracy;
    - *Poisson*: ``exp(t A) = sum_n w_n S^n`` with Poisson weights of mean ``s t``, folded onto the ring and convolved;
      for every ``a``, also ``a = 0`` (``k = Z``) where the ring is one Jordan block and has no eigenvectors to speak
      of, and ``s t <= 1e13``.

    Make one with :func:`free_flight`.  Contact is not modelled: what is returned after the end has touched the obstacle
    is the motion of a rod without one; see :func:`lure.rod.structured.first_contact`.

    Attributes
    ----------
    ring : Ring
        The scheme and its state at the start.

    Notes
    -----
    It is a motion of the scheme, whose waves lose more energy than the rod's.  The mean ``s t`` is taken without
    rounding, so that times are as exact as the double ``s = c N/L``.
    """

    ring: Ring

    @cached_property
    def modes(self) -> Modes | None:
        """The scaled FFT of the start; None where it would lose digits."""
        return Modes(ring=self.ring) if _FAINT <= self.ring.log_echo <= _LOUD else None

    def state(self, t: float, *, way: Way = "auto") -> Array:
        """State (2N+1,) at one time, in the ordering of the scheme.

        Parameters
        ----------
        t : float
            Time, from 0 on [s].
        way : {"auto", "modes", "poisson"}
            How; ``"auto"`` takes the modes wherever they are accurate.

        Raises
        ------
        InputError
            The time is not a nonnegative number, the way does not apply, or the motion (``k < 0``) has grown beyond
            doubles.
        """
        return self.jumped(mean_of(self.ring.scheme.rate, t), way=way)

    def jumped(self, mean: Mean, *, way: Way = "auto") -> Array:
        """:meth:`state` at the time ``mean`` in units of ``1/s``."""
        scheme = self.ring.scheme
        with np.errstate(over="ignore", invalid="ignore"):
            waves, gap = self._by_modes(mean) if self._uses_modes(way) else self._by_poisson(mean)
        state = np.append(waves, gap / scheme.rate)
        if not np.isfinite(state).all():
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give an earlier time")
        return np.asarray(state[scheme.permutation])

    def end(self, t: ArrayLike) -> tuple[Array, Array]:
        """Contact coordinate ``z`` [m] and last forward wave ``y_N = z'`` [m/s] at the times ``t`` [s], elementwise.

        Parameters
        ----------
        t : array_like
            Times from 0 on.

        Raises
        ------
        InputError
            As for :meth:`state`.

        Notes
        -----
        A value costs ``O(sqrt(N))`` at most where modes serve: early by the Poisson weights, which are few then, later
        by the modes, of which few are left then.
        """
        times = np.asarray(t, dtype=float)
        pairs = np.array([self.end_at(mean_of(self.ring.scheme.rate, float(time))) for time in times.ravel()])
        pairs = pairs.reshape(*times.shape, 2)
        if not np.isfinite(pairs).all():
            raise InputError("the motion has grown beyond the range of doubles (damping < 0); give earlier times")
        return pairs[..., 0] / self.ring.scheme.rate, pairs[..., 1]

    def discrepancy(self, t: float) -> float:
        """Estimate of the error at ``t``: largest difference of the waves between the two ways.

        Parameters
        ----------
        t : float
            Time [s].

        Returns
        -------
        float
            Relative to the largest wave at the start.  Observed, not proved: the two share the initial state, the
            rate ``s`` and the echo ``f``, and nothing else.

        Raises
        ------
        InputError
            Only one of the ways applies.
        """
        largest = float(np.abs(self.ring.waves).max())
        one, two = self.state(t, way="modes"), self.state(t, way="poisson")
        keep = self.ring.scheme.permutation < 2 * self.ring.scheme.cells
        return float(np.abs(one - two)[keep].max()) / (largest or 1.0)

    def _uses_modes(self, way: Way) -> bool:
        if way not in ("auto", "modes", "poisson"):
            raise InputError(f"way is {way!r}; give auto, modes or poisson")
        if way == "modes" and self.modes is None:
            raise InputError(
                f"the scaled FFT loses too many digits for a = {-self.ring.echo:.6g}, outside 0.1 <= |a| <= 10; "
                'give way="poisson"'
            )
        return way != "poisson" and self.modes is not None

    def _by_modes(self, mean: Mean) -> tuple[Array, float]:
        assert self.modes is not None
        return self.modes.waves(mean), self.modes.end(mean)[0]

    def _by_poisson(self, mean: Mean) -> tuple[Array, float]:
        ring, size = self.ring, 2 * self.ring.scheme.cells
        n, weights = self._terms(mean)
        trips = n // size
        kernel = np.bincount(n - trips * size, weights=weights * ring.power(trips), minlength=size)
        product = np.fft.rfft(kernel, 2 * size) * np.fft.rfft(ring.waves, 2 * size)
        convolved = np.fft.irfft(product, 2 * size)
        return convolved[:size] + ring.echo * convolved[size:], float(weights @ ring.gaps(n))

    def end_at(self, mean: Mean) -> tuple[float, float]:
        """``s z`` and ``y_N`` [m/s] at the time ``mean`` in units of ``1/s``."""
        few = 18.0 * math.sqrt(mean.value) + 40.0 < 2 * self.ring.scheme.cells
        if self.modes is not None and not (few and 18.0 * math.sqrt(mean.value) < self.modes.active(mean.value)):
            return self.modes.end(mean)
        n, weights = self._terms(mean)
        return float(weights @ self.ring.gaps(n)), float(weights @ self.ring.leaving(n))

    def _terms(self, mean: Mean) -> tuple[NDArray[np.int64], Array]:
        """Indices and weights of the window, which echoes that grow must not carry away by a standard deviation."""
        ring = self.ring
        if ring.log_echo > 0.0 and mean.value * ring.log_echo**2 > 2.0 * ring.scheme.cells**2:
            raise InputError(f"a = {-ring.echo:.6g} amplifies the tail of the Poisson weights; give an earlier time")
        if ring.log_echo < _FAINT:  # a wave has sunk below the range of doubles after so many echoes
            mean = Mean(whole=min(mean.whole, _DEAD * ring.scheme.cells), rest=mean.rest)
        first, weights = poisson_weights(mean)
        return np.arange(first, first + weights.size), weights


def free_flight(scheme: UpwindScheme, start: Scenario | ArrayLike) -> FreeFlight:
    """Free flight of a scheme from the initial data of a scenario, or from a state.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme, in any ordering.
    start : Scenario or array_like
        Initial data, without loads; or a state (2N+1,) in the ordering of the scheme.

    Raises
    ------
    InputError
        The scenario has loads, or the state another shape or a number that is not finite.

    Examples
    --------
    >>> from lure import builtin_system, upwind
    >>> system = builtin_system("paper-rod")
    >>> flight = free_flight(upwind(system.rod, 1000), system.scenario)
    >>> z, _ = flight.end([0.0, system.rod.travel_time, 100.0])
    >>> (z + system.rod.gap).round(7)
    array([-1.0e-04,  9.5e-05,  1.0e-04])
    """
    if isinstance(start, Scenario):
        for name, load in (("g", start.force), ("f", start.body_force)):
            if not load.is_zero:
                raise InputError(
                    f"force.{name} is {load}; free_flight takes no loads, give 0 (structured_motion takes a force)"
                )
        state = initial_state(scheme, start)
    else:
        state = np.array(start, dtype=float)
    if state.shape != (scheme.order,) or not np.isfinite(state).all():
        raise InputError(f"start has shape {state.shape} or is not finite; give a state ({scheme.order},)")
    plain = state[np.argsort(scheme.permutation)]
    return FreeFlight(ring=Ring(scheme=scheme, waves=plain[:-1], gap=float(plain[-1]) * scheme.rate))


def later(flight: FreeFlight, shifts: int) -> FreeFlight:
    """The flight seen from ``shifts`` cell crossings later.

    Parameters
    ----------
    flight : FreeFlight
        The flight.
    shifts : int
        Whole number of units of ``1/s``.
    """
    state = flight.jumped(Mean(whole=shifts, rest=0.0))
    return free_flight(flight.ring.scheme, state)

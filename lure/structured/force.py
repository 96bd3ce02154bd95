r"""A force at ``x = 0`` as what enters a shift register.

The Poisson average of ``n (n-1) .. (n-k+1) (1 + lambda)^{n-k}`` is ``tau^k e^{lambda tau}``.  So a force that is a sum
of such terms, with ``lambda`` in units of ``s``, is a sequence ``g_n``, and the register that takes in ``2 b g_n`` at
its ``n``-th step has the forced motion of the scheme as its average: no fit and no step, as without a force.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError
from lure.expressions import Expression
from lure.structured.exponentials import Sum, exponentials
from lure.upwind import UpwindScheme

Array: TypeAlias = NDArray[np.float64]

_BLOCK = 1024
_ELSEWHERE = "analysis.simulation.simulate takes any load, up to 1000 cells"


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

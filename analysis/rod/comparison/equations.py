"""The ordinary differential equations of the upwind scheme under loads, folded so that they are banded."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.energy import discrete_energy
from lure.arrays import Reals as Array
from lure.record import described, quantity
from lure.rod.discretisation import UpwindScheme, upwind
from lure.rod.scenario import Scenario, initial_state

if TYPE_CHECKING:
    from scipy.sparse import csc_array


BAND = 2
_LOOKS = 1025


@described(frozen=True, kw_only=True, eq=False)
class SchemeEquations:
    """``y' = A y + b1 mu + b2 g + f``-terms of the scheme, ``mu = -p(z)``, with both waves of a place side by side.

    The folded state is ``[y_1, y_{2N}, y_2, y_{2N-1}, .., y_N, y_{N+1}, z]`` in the numbering of (39): the ring of the
    scheme is laid flat, and no equation reaches farther than two places, so that every matrix of an implicit method is
    banded.  A body force adds ``f/(rho A)`` to each wave where it stands.
    """

    scheme: UpwindScheme = quantity("The scheme; its own ordering does not matter here")
    scenario: Scenario = quantity("Loads and initial data")

    @cached_property
    def plain(self) -> UpwindScheme:
        """The scheme in the ordering (39)."""
        return upwind(self.scheme.rod, self.scheme.cells, form=self.scheme.form)

    @cached_property
    def fold(self) -> NDArray[np.intp]:
        """(2N+1,) ``folded = y_39[fold]``."""
        N = self.scheme.cells
        places = np.empty(2 * N + 1, dtype=np.intp)
        places[0 : 2 * N : 2] = np.arange(N)
        places[1 : 2 * N : 2] = np.arange(2 * N - 1, N - 1, -1)
        places[-1] = 2 * N
        return places

    @cached_property
    def start(self) -> Array:
        """(2N+1,) initial state, folded."""
        return np.asarray(initial_state(self.plain, self.scenario)[self.fold])

    def unfolded(self, states: Array) -> Array:
        """States (..., 2N+1) in the ordering (39)."""
        plain = np.empty_like(states)
        plain[..., self.fold] = states
        return plain

    def observed(self, states: Array) -> Array:
        """(k, 3) contact coordinate ``z`` [m], velocity ``v(t, L)`` [m/s] and energy [J] of folded states (k, 2N+1)."""
        z = states[:, -1]
        velocity = states[:, -3] - self.scheme.rod.mobility * self.scheme.rod.nonlinearity(z)
        return np.column_stack((z, velocity, discrete_energy(self.plain, self.unfolded(states))))

    @cached_property
    def _force_gain(self) -> float:
        """What ``g`` adds to ``y_1'`` [m/(N s^2)]."""
        return float(self.plain.b2[0])

    @cached_property
    def _grid(self) -> Array:
        return self.scheme.rod.length * np.arange(self.scheme.cells + 1) / self.scheme.cells

    def rate(self, t: float, y: Array, *, touching: bool, span: tuple[float, float]) -> Array:
        """``y'`` on one smooth piece: ``p = 0`` in flight and ``c_n |z|^m sign z`` in contact; folded (2N+1,).

        Raises
        ------
        InputError
            A load is not finite.
        """
        rod, N, s = self.scheme.rod, self.scheme.cells, self.scheme.rate
        force, body = self._loads(t, span)
        push = rod.mobility * rod.nonlinearity.continued(float(y[-1]))[0] if touching else 0.0
        change = np.empty(2 * N + 1)
        forward, backward = y[0 : 2 * N : 2], y[1 : 2 * N : 2]
        change[2 : 2 * N : 2] = s * (forward[:-1] - forward[1:])
        change[1 : 2 * N - 2 : 2] = s * (backward[1:] - backward[:-1])
        change[0] = -s * (forward[0] + rod.reflection * backward[0]) + self._force_gain * force
        change[2 * N - 1] = s * (forward[-1] - 2.0 * push - backward[-1])
        change[2 * N] = forward[-1] - push
        if body is not None:
            change[0 : 2 * N : 2] += body[1:]
            change[1 : 2 * N : 2] += body[:-1]
        return change

    def jacobian(self, y: Array, *, touching: bool) -> csc_array:
        """``dy'/dy`` (2N+1, 2N+1), sparse with two diagonals on either side [1/s]."""
        from scipy.sparse import csc_array

        rod = self.scheme.rod
        slope = rod.nonlinearity.continued(float(y[-1]))[1] if touching else 0.0
        free, pressed = self._slopes
        return csc_array(free - slope * pressed)

    @cached_property
    def _slopes(self) -> tuple[csc_array, csc_array]:
        """``A`` and ``b1 c^T``, folded."""
        from scipy.sparse import csc_array

        block, fold = self.plain.block, self.fold
        pressed = csc_array(block.b1[fold][:, None]) @ csc_array(block.c[fold][None, :])
        return csc_array(block.A[fold][:, fold]), pressed

    def speed(self, until: float) -> float:
        """A velocity of the size the data and the loads suggest, 1 if they suggest none [m/s]."""
        rod, times = self.scheme.rod, np.linspace(0.0, until, _LOOKS)
        span = (0.0, until)
        started = float(np.abs(self.start[:-1]).max())
        if self.scenario.free:
            return started or 1.0
        loads = [self._loads(float(t), span) for t in times]
        pushed = self._force_gain / self.scheme.rate * max(abs(force) for force, _ in loads)
        carried = rod.travel_time * max(0.0 if body is None else float(np.abs(body).max()) for _, body in loads)
        return max(started, pushed, carried) or 1.0

    def _loads(self, t: float, span: tuple[float, float]) -> tuple[float, Array | None]:
        """``g`` [N] and ``f/(rho A)`` (N+1,) [m/s^2], as :meth:`.Scenario.loads` reads them."""
        if self.scenario.free:
            return 0.0, None
        force, body = self.scenario.loads(t, self._grid, span)
        return force, None if body is None else body / (self.scheme.rod.density * self.scheme.rod.area)

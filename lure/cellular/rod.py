"""The paper's rod as cellular networks: its ring (42), and the closed network (48) with the contact cell in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lure.cellular.network import CellularNetwork
from lure.cellular.template import Array, Template
from lure.upwind import UpwindScheme


def rod_ring(scheme: UpwindScheme) -> CellularNetwork:
    r"""The ring of ``2N`` cells (42), templates (44)-(47), without the contact coordinate.

    ``T^A`` reads the cell before with weight ``s`` (the first cell reads the last with ``-s a``), ``T^C`` is ``s``
    (paper: 0, s, 0), the output linear.  Inputs: ``u_1 = g`` [N] with weight ``2 s b`` (``2 b`` as printed) and
    ``u_{N+1} = p`` [Pa] with weight ``-2 s d``.  The contact coordinate is the other "simple network" (43),
    ``z' = y_N - d p(z)``; :func:`rod_network` has it inside.

    Parameters
    ----------
    scheme : UpwindScheme
        Rod, number of cells and form; its ordering does not matter.

    Examples
    --------
    >>> from lure import builtin_system, upwind
    >>> rod_ring(upwind(builtin_system("paper-rod").rod, 10)).matrix().shape
    (20, 20)
    """
    N, s, rod = scheme.cells, scheme.rate, scheme.rod
    entry = 2.0 * rod.input_gain * (s if scheme.form == "corrected" else 1.0)
    return CellularNetwork(
        shape=(2 * N,),
        A=Template.varying({-1: lambda i: np.where(i == 0, -s * rod.reflection, s)}),
        B=Template.varying({0: lambda i: np.where(i == 0, entry, 0.0) - np.where(i == N, 2.0 * s * rod.mobility, 0.0)}),
        C=Template.varying({0: s}),
        output="linear",
        boundary="periodic",
    )


def rod_network(scheme: UpwindScheme, force: Callable[[float], float] | None = None) -> CellularNetwork:
    r"""The closed loop as one network of ``2N + 1`` cells in the ordering (48), with the cell equations (49).

    The contact cell ``z`` stands between the waves.  Its OUTPUT is the stress ``p(z)`` and those of all other cells are
    their states: it reads ``y_N`` and, with weight ``-d``, its own output; the next cell reads ``y_N`` two cells back,
    and that output with weight ``-2 s d``; every other cell the one before, as in (45).  ``C`` is ``s`` on the waves, 0
    at ``z``.  The neighbourhood has radius 2.

    Parameters
    ----------
    scheme : UpwindScheme
        Rod, number of cells and form; its ordering does not matter.
    force : function of t, optional
        ``g`` [N]; enters the first cell as the bias ``2 s b g``, or ``2 b g`` as printed.

    Notes
    -----
    States are in SI units and in the order of ``upwind(..., ordering="eq48")``; time in s.

    Examples
    --------
    >>> from lure import builtin_system, initial_state, upwind
    >>> system = builtin_system("paper-rod")
    >>> scheme = upwind(system.rod, 10, ordering="eq48")
    >>> run = rod_network(scheme).simulate(initial_state(scheme, system.scenario), until=2e-3)
    >>> bool(run.x[-1, 10] < 0)
    True
    """
    N, s, rod = scheme.cells, scheme.rate, scheme.rod
    d, a, z = rod.mobility, rod.reflection, scheme.cells
    entry = 2.0 * rod.input_gain * (s if scheme.form == "corrected" else 1.0)
    first = np.arange(2 * N + 1) == 0

    def before(i: NDArray[np.intp]) -> Array:
        """Weight of the cell before: ``-s a`` where the ring closes, the stress next to the contact, else the wave."""
        inner = np.where(i == z, 1.0, np.where(i == z + 1, -2.0 * s * d, s))
        return np.asarray(np.where(i == 0, -s * a, inner))

    def output(x: Array) -> Array:
        """``p(z)`` at the contact cell, the state elsewhere."""
        values = x.copy()
        values[z] = rod.law(x[z])
        return values

    return CellularNetwork(
        shape=(2 * N + 1,),
        A=Template.varying(
            {
                -2: lambda i: np.where(i == z + 1, s, 0.0),
                -1: before,
                0: lambda i: np.where(i == z, -d, 0.0),
            }
        ),
        C=Template.varying({0: lambda i: np.where(i == z, 0.0, s)}),
        bias=0.0 if force is None else lambda t: np.where(first, entry * force(t), 0.0),
        output=output,
        boundary="periodic",
    )

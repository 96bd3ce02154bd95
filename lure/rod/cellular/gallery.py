"""The paper's rod as cellular networks: its ring (42), and the closed network (48) with the contact cell in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lure.arrays import Reals as Array
from lure.rod.cellular.network import Boundary, CellularNetwork, Template
from lure.rod.discretisation import UpwindScheme

# Two classical networks: diffusion on a grid, and the edges of a black and white image.


def diffusion_network(
    shape: tuple[int, ...], rate: float, *, boundary: Boundary = "zero-flux", edge_state: float = 0.0
) -> CellularNetwork:
    r"""The heat equation on a grid: ``x' = rate * (sum of the neighbours - 2 dim x)``, linear output, no decay.

    Second differences: with spacing ``h`` and diffusivity ``D``, ``rate = D/h^2``.  Its modes are known:
    ``exp(-4 rate t sum_axes sin^2(phi/2))`` times ``sin`` or ``cos`` along each axis of ``n`` cells, with
    ``phi = 2 pi m/n`` (periodic), ``pi m/n`` (zero-flux, ``cos(phi (i + 1/2))``) or ``pi m/(n+1)`` (fixed at 0,
    ``sin(phi (i + 1))``).

    Parameters
    ----------
    shape : tuple of int
        Cells along each direction.
    rate : float
        Exchange between neighbours [1/unit of time].
    boundary : {"fixed", "zero-flux", "periodic"}
        What lies beyond the edge.
    edge_state : float
        Value there, for the fixed boundary.

    Examples
    --------
    >>> diffusion_network((4,), 2.0).matrix().toarray()[0]
    array([-2.,  2.,  0.,  0.])
    """
    line = [rate, -2.0 * rate, rate]
    plane = [[0.0, rate, 0.0], [rate, -4.0 * rate, rate], [0.0, rate, 0.0]]
    nothing = Template(((0,) * len(shape),), (0.0,))
    return CellularNetwork(
        shape=shape,
        A=Template.uniform(line if len(shape) == 1 else plane),
        C=nothing,
        output="linear",
        boundary=boundary,
        edge_state=edge_state,
    )


def edge_network(shape: tuple[int, int]) -> CellularNetwork:
    r"""Edges of a black (+1) and white (-1) image: a black pixel stays black iff one of its 8 neighbours is white.

    ``A`` has 1 in the middle, ``B`` 8 in the middle and -1 around, ``I = -1``; the image is the input and white beyond
    the edge.  Why it works: with ``w = B u + I`` a cell obeys ``x' = -x + f(x) + w``, alone.  A black pixel with ``n``
    white neighbours has ``w = 2n - 1``, a white pixel with ``m`` black ones ``w = -2m - 1``: always ``|w| >= 1``, so
    from EVERY initial state ``x`` goes to ``w + sign(w)``, and the output to ``sign(w)``.

    Parameters
    ----------
    shape : tuple of int
        Rows and columns.

    References
    ----------
    L. O. Chua, T. Roska, Cellular Neural Networks and Visual Computing, Cambridge (2002), the EDGE template; an edge
    template was among the first applications: L. O. Chua, L. Yang, "Cellular neural networks: applications", IEEE
    Trans. Circuits Syst. 35 (1988) 1273-1290.

    Examples
    --------
    >>> import numpy as np
    >>> image = -np.ones((5, 5))
    >>> image[1:4, 1:4] = 1.0
    >>> run = edge_network((5, 5)).simulate(0.0, u=image, until=50.0)
    >>> run.steady, run.output[-1, 2].round(6)
    (True, array([-1.,  1., -1.,  1., -1.]))
    """
    around = [[-1.0, -1.0, -1.0], [-1.0, 8.0, -1.0], [-1.0, -1.0, -1.0]]
    return CellularNetwork(
        shape=shape,
        A=Template.uniform([[1.0]]),
        B=Template.uniform(around),
        bias=-1.0,
        edge_state=-1.0,
        edge_input=-1.0,
    )


def rod_template(rate: float, reflection: float) -> Template:
    r"""Templates (44)-(47) of the rod's ring of ``2N`` cells, ``T^AC = T^A - T^C``.

    Inner cells ``2..2N`` carry ``[s, -s, 0]`` (45); the corner cell 1 reads the last cell with weight ``-s a`` in place
    of ``s`` (47).  Laid over the ring by :func:`.interconnection` it is f-circulant with ``f = -a``, and circulant (as
    the paper says) only for ``a = -1``, that is ``k = 0``.

    Parameters
    ----------
    rate : float
        ``s = c N / L`` [1/s].
    reflection : float
        ``a`` [-].
    """
    return Template(((-1,), (0,)), (lambda i: np.where(i == 0, -rate * reflection, rate), -rate))


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
    >>> from lure.rod import builtin_system, upwind
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
    >>> from lure.rod import builtin_system, initial_state, upwind
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
        values[z] = rod.nonlinearity(x[z])
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

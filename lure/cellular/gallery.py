"""Two classical networks: diffusion on a grid, and the edges of a black and white image."""

from __future__ import annotations

from lure.cellular.network import CellularNetwork
from lure.cellular.template import Boundary, Template


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

"""What Chua and Yang's energy says about a network, and under which hypotheses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.cellular.network import CellularNetwork, Signal
from lure.errors import AssumptionError

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True)
class ChuaYang:
    r"""Whether the hypotheses of Chua and Yang's convergence theorem hold.

    With the saturating output (41), constant bias and input, ``T^C`` diagonal and positive and ``T^A``, laid over the
    grid with its boundary, symmetric,

    .. math:: V(x) = -\tfrac12 f^T T^A f + \tfrac12 \sum_i C_i f_i^2 - w^T f, \qquad f = f(x), \quad w = B u + I,

    satisfies ``V' = - sum over |x_i| < 1 of (x_i')^2 <= 0`` and is bounded.  Every motion is bounded, and it converges
    to an equilibrium if the equilibria are isolated.  If moreover ``T^A_ii > C_i``, no cell of a stable equilibrium has
    ``|x_i| < 1``: the outputs are -1 or +1.  Nothing follows where a hypothesis fails; such a network may oscillate.

    Attributes
    ----------
    obstacle : str or None
        The first hypothesis that fails, in words; None if all hold.
    binary : bool
        Whether ``T^A_ii > C_i`` for all cells.  Says something only where ``obstacle`` is None.

    References
    ----------
    L. O. Chua, L. Yang, "Cellular neural networks: theory", IEEE Trans. Circuits Syst. 35 (1988) 1257-1272, Theorems
    3-5.
    """

    obstacle: str | None
    binary: bool

    @property
    def holds(self) -> bool:
        """Whether the hypotheses that were checked hold; that equilibria are isolated is not checked."""
        return self.obstacle is None

    def require(self) -> ChuaYang:
        """Itself if :attr:`holds`.

        Raises
        ------
        AssumptionError
            It does not; the message is the hypothesis that fails.
        """
        if self.obstacle is not None:
            raise AssumptionError(f"Chua and Yang's theorem does not apply: {self.obstacle}")
        return self

    def __str__(self) -> str:
        if self.obstacle is not None:
            return f"Chua and Yang's theorem says nothing: {self.obstacle}."
        outputs = "; at a stable one every output is -1 or +1" if self.binary else ""
        return (
            "Templates are symmetric and the decay positive: the energy of Chua and Yang falls, and every motion under "
            f"constant input converges to an equilibrium if the equilibria are isolated{outputs}."
        )


def chua_yang(network: CellularNetwork) -> ChuaYang:
    """Check the hypotheses of Chua and Yang's theorem on the interconnections of a network.

    Parameters
    ----------
    network : CellularNetwork
        The network; inputs are taken to be constant.

    Examples
    --------
    >>> from lure.cellular import edge_network
    >>> chua_yang(edge_network((3, 3))).holds
    True
    """
    n = network.size
    feedback, decay = network.feedback[:, :n].tocsr(), network.decay[:, :n].tocsr()
    own, difference = decay.diagonal(), abs(feedback - feedback.T)
    binary = bool((feedback.diagonal() > own).all())
    obstacle = None
    if network.output != "saturation":
        obstacle = "the output is not the saturation (41)"
    elif not network.autonomous:
        obstacle = "the bias changes in time"
    elif (network.decay.tocoo().coords[0] != network.decay.tocoo().coords[1]).any() or not (own > 0.0).all():
        obstacle = "the decay of a cell must be a positive multiple of its own state"
    elif difference.max() > 0.0:
        obstacle = f"the feedback is not symmetric; two of its weights differ by {difference.max():.6g}"
    return ChuaYang(obstacle=obstacle, binary=binary)


def chua_yang_energy(network: CellularNetwork, x: ArrayLike, u: Signal = 0.0) -> float:
    """The energy ``V`` of :class:`ChuaYang` at the states ``x`` under the constant inputs ``u``.

    Parameters
    ----------
    network : CellularNetwork
        A network to which the theorem applies.
    x : array_like
        States, an array of the shape of the grid.
    u : float or array_like
        Inputs.

    Raises
    ------
    AssumptionError
        A hypothesis fails, or the inputs are a function of time.
    """
    chua_yang(network).require()
    if callable(u):
        raise AssumptionError("Chua and Yang's theorem does not apply: the input changes in time")
    n, f = network.size, network.outputs(x).ravel()
    quadratic = network.decay[:, :n].diagonal() @ f**2 - f @ (network.feedback[:, :n] @ f)
    return float(0.5 * quadratic - network.drive(0.0, u) @ f)

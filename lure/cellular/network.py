"""A cellular neural network: cells on a line or in the plane that read their neighbours through cloning templates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.cellular.template import Boundary, Template, interconnection
from lure.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from lure.cellular.motion import CellularMotion

Array: TypeAlias = NDArray[np.float64]
Signal: TypeAlias = ArrayLike | Callable[[float], ArrayLike]
Output: TypeAlias = Literal["saturation", "linear"] | Callable[[Array], ArrayLike]


def saturation(x: ArrayLike) -> Array:
    """Output (41), the unit bipolar ramp ``f(x) = (|x+1| - |x-1|)/2``, elementwise.

    Parameters
    ----------
    x : array_like
        States.

    Examples
    --------
    >>> saturation([-3.0, 0.25, 7.0])
    array([-1.  ,  0.25,  1.  ])
    """
    return np.asarray(np.clip(np.asarray(x, dtype=float), -1.0, 1.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class CellularNetwork:
    r"""Cells that read their neighbours through cloning templates, the dynamics (40) of the paper.

    .. math:: \dot x_{ij} = \sum T^A_{ij,kl} f(x_{kl}) + \sum T^B_{ij,kl} u_{kl} - \sum T^C_{ij,kl} x_{kl} + I_{ij},

    sums over the neighbourhood of the cell.  The decay is SUBTRACTED: ``C`` with 1 in the middle is the usual ``-x``.
    Time is in the unit in which the templates are rates.

    Attributes
    ----------
    shape : tuple of int
        ``(n,)`` cells on a line or ``(rows, columns)`` in the plane.
    A : Template
        Output feedback.
    B : Template or None
        Control; None for none.
    C : Template or None
        State feedback; None for ``x`` itself, the classical decay with time constant 1.
    bias : float, array_like or function of t
        ``I``, one value for all or one for each cell; a function of time gives either.
    output : {"saturation", "linear"} or function
        ``f``: (41), ``f(x) = x``, or a function from the states of all cells (an array of ``shape``) to their outputs,
        which may treat cells differently as (49) asks.  Such a function must be elementwise and cannot be used with
        the fixed boundary, whose virtual cell it does not know.
    boundary : {"fixed", "zero-flux", "periodic"}
        What lies beyond the edge: a virtual cell whose state and input never change, the mirror image, or the other
        side.
    edge_state, edge_input : float
        State and input of the virtual cell of the fixed boundary.

    Raises
    ------
    InputError
        The shape is not one or two positive whole numbers, a template does not fit it, or an option is unknown.

    References
    ----------
    L. O. Chua, L. Yang, "Cellular neural networks: theory", IEEE Trans. Circuits Syst. 35 (1988) 1257-1272.
    L. O. Chua, T. Roska, "The CNN paradigm", IEEE Trans. Circuits Syst. I 40 (1993) 147-156.

    Examples
    --------
    Two cells that push each other to opposite sides:

    >>> pair = CellularNetwork(shape=(2,), A=Template.uniform([-1, 2, -1]), boundary="fixed")
    >>> pair.rhs(0.0, [0.5, -0.5])
    array([ 1., -1.])
    """

    shape: tuple[int, ...]
    A: Template
    B: Template | None = None
    C: Template | None = None
    bias: Signal = 0.0
    output: Output = "saturation"
    boundary: Boundary = "fixed"
    edge_state: float = 0.0
    edge_input: float = 0.0

    def __post_init__(self) -> None:
        if len(self.shape) not in (1, 2) or any(not isinstance(n, int) or n < 1 for n in self.shape):
            raise InputError(f"CellularNetwork.shape is {self.shape}; give one or two positive whole numbers")
        if not callable(self.output) and self.output not in ("saturation", "linear"):
            raise InputError(f"CellularNetwork.output is {self.output!r}; give saturation, linear or a function")
        if callable(self.output) and self.boundary == "fixed":
            raise InputError(
                'CellularNetwork: an output function has no virtual cell; give another boundary than "fixed"'
            )
        if not np.isfinite([self.edge_state, self.edge_input]).all():
            raise InputError("CellularNetwork.edge_state and edge_input must be finite numbers")
        self.feedback, self.control, self.decay  # noqa: B018  (built here, so that what does not fit is refused here)
        if not callable(self.bias):
            self.signal(self.bias, 0.0, "bias")

    @property
    def size(self) -> int:
        """Number of cells ``n``."""
        return int(np.prod(self.shape))

    @property
    def autonomous(self) -> bool:
        """Whether the bias is constant in time."""
        return not callable(self.bias)

    @cached_property
    def feedback(self) -> csr_array:
        """``T^A`` over the grid, (n, n+1), the virtual cell last."""
        return interconnection(self.A, self.shape, self.boundary)

    @cached_property
    def control(self) -> csr_array | None:
        """``T^B`` over the grid, (n, n+1), or None."""
        return None if self.B is None else interconnection(self.B, self.shape, self.boundary)

    @cached_property
    def decay(self) -> csr_array:
        """``T^C`` over the grid, (n, n+1)."""
        self_only = Template(((0,) * len(self.shape),), (1.0,))
        return interconnection(self.C or self_only, self.shape, self.boundary)

    def outputs(self, x: ArrayLike) -> Array:
        """``f(x)`` of states of the shape of the grid, or of any shape for a named output."""
        states = np.asarray(x, dtype=float)
        if callable(self.output):
            return np.asarray(self.output(states), dtype=float)
        return saturation(states) if self.output == "saturation" else states

    def signal(self, value: Signal, t: float, name: str) -> Array:
        """A bias or an input at time ``t`` as an array over the grid.

        Parameters
        ----------
        value : float, array_like or function of t
            The signal.
        t : float
            The time.
        name : str
            What an error calls it.

        Raises
        ------
        InputError
            It is not a finite number or an array over the grid of such.
        """
        values = np.asarray(value(t) if callable(value) else value, dtype=float)
        if values.shape not in ((), self.shape) or not np.isfinite(values).all():
            raise InputError(
                f"CellularNetwork: {name} has shape {values.shape} or is not finite; give a number or {self.shape}"
            )
        return np.broadcast_to(values, self.shape)

    def drive(self, t: float, u: Signal = 0.0) -> Array:
        """What does not depend on the state: ``B u + I``, the virtual cell's share of all templates included, (n,).

        Parameters
        ----------
        t : float
            The time.
        u : float, array_like or function of t
            Inputs of the cells.
        """
        total = self.signal(self.bias, t, "bias").ravel().copy()
        if self.control is not None:
            total += self.control @ np.append(self.signal(u, t, "u").ravel(), self.edge_input)
        if self.boundary == "fixed":
            edge = np.zeros(self.size + 1)
            edge[-1] = self.edge_state
            total += self.feedback @ self.outputs(edge) - self.decay @ edge
        return total

    def rhs(self, t: float, x: ArrayLike, u: Signal = 0.0) -> Array:
        """Right-hand side of (40), over the grid.

        Parameters
        ----------
        t : float
            The time; it matters only where the bias or the input is a function of it.
        x : array_like
            States, an array of ``shape``.
        u : float, array_like or function of t
            Inputs of the cells.

        Raises
        ------
        InputError
            The states have another shape, or the inputs do not fit the grid.
        """
        states = np.asarray(x, dtype=float)
        if states.shape != self.shape:
            raise InputError(f"CellularNetwork.rhs got states of shape {states.shape}; give {self.shape}")
        n = self.size
        own = self.feedback[:, :n] @ self.outputs(states).ravel() - self.decay[:, :n] @ states.ravel()
        return np.asarray(own + self.drive(t, u)).reshape(self.shape)

    def matrix(self) -> csr_array:
        """``T^A - T^C`` (n, n), row-major: with linear output, ``x' = matrix x + drive``.

        Raises
        ------
        InputError
            The output is not linear.
        """
        if self.output != "linear":
            raise InputError('CellularNetwork.matrix needs output="linear": any other network is not its matrix')
        n = self.size
        return (self.feedback[:, :n] - self.decay[:, :n]).tocsr()

    def simulate(
        self, x0: ArrayLike, *, until: float, u: Signal = 0.0, samples: int = 101, at_rest: float = 1e-8
    ) -> CellularMotion:
        """The motion from ``x0``, until it rests or the time is over.

        Parameters
        ----------
        x0 : array_like
            Initial states, a number or an array of ``shape``.
        until : float
            Longest time.
        u : float, array_like or function of t
            Inputs.
        samples : int
            Number of instants kept, evenly spaced from 0 to ``until``.
        at_rest : float
            The network rests where no state changes faster than this [unit of state / unit of time]; looked for only if
            bias and input are constant.

        Returns
        -------
        CellularMotion
            See there, also for what ``steady`` does not prove.
        """
        from lure.cellular.motion import Request, motion

        return motion(self, x0, u, Request(until=until, samples=samples, at_rest=at_rest))

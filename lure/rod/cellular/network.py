"""A cellular neural network: cells on a line or in the plane that read their neighbours through cloning templates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.record import described, quantity

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from lure.rod.cellular.motion import CellularMotion

# Cloning templates: how a cell weighs its neighbours, the same everywhere or varying with position.

Weight: TypeAlias = ArrayLike | Callable[..., ArrayLike]
Boundary = Literal["fixed", "zero-flux", "periodic"]
BOUNDARIES: tuple[Boundary, ...] = ("fixed", "zero-flux", "periodic")


@described(frozen=True, eq=False)
class Template:
    """Weights of a cell's neighbours: ``sum_o weights[o](cell) * value[cell + offsets[o]]``.

    Make one with :meth:`uniform` (translation-invariant) or :meth:`varying` (regularly varying).

    Raises
    ------
    InputError
        There is no neighbour, or the offsets are not all one or all two whole numbers.
    """

    offsets: tuple[tuple[int, ...], ...] = quantity(
        "Places of the neighbours relative to the cell, one or two numbers each"
    )
    weights: tuple[Weight, ...] = quantity(
        "For each neighbour a number, an array of the shape of the grid, or a function of the index arrays of the "
        "grid (``i`` in one dimension, ``i, j`` in two, counted from 0) [1/unit of time]"
    )

    def __post_init__(self) -> None:
        if not self.offsets or len(self.offsets) != len(self.weights):
            raise InputError(f"Template has {len(self.offsets)} offsets, {len(self.weights)} weights; give one of each")
        if len({len(offset) for offset in self.offsets}) != 1 or self.dimension not in (1, 2):
            raise InputError(f"Template.offsets is {self.offsets}; give one number each (1-D) or two each (2-D)")

    @classmethod
    def uniform(cls, weights: ArrayLike) -> Template:
        """The same weights at every cell.

        Parameters
        ----------
        weights : array_like
            ``(2r+1,)`` or ``(2r+1, 2r+1)``, the cell itself in the middle; entry ``[r+k, r+l]`` weighs the neighbour at
            ``(i+k, j+l)`` (a correlation: nothing is mirrored).

        Raises
        ------
        InputError
            The array has another shape or a number that is not finite.

        Examples
        --------
        >>> Template.uniform([1, -2, 1]).offsets
        ((-1,), (0,), (1,))
        """
        table = np.asarray(weights, dtype=float)
        if table.ndim not in (1, 2) or len(set(table.shape)) != 1 or table.shape[0] % 2 == 0:
            raise InputError(f"Template.uniform got weights of shape {table.shape}; give (2r+1,) or (2r+1, 2r+1)")
        radius = table.shape[0] // 2
        places = [tuple(int(k) - radius for k in place) for place in np.ndindex(table.shape)]
        kept = [place for place in places if table[tuple(k + radius for k in place)] != 0.0] or [(0,) * table.ndim]
        return cls(tuple(kept), tuple(float(table[tuple(k + radius for k in place)]) for place in kept))

    @classmethod
    def varying(cls, rules: Mapping[int, Weight] | Mapping[tuple[int, ...], Weight]) -> Template:
        """Weights that depend on the cell.

        Parameters
        ----------
        rules : mapping
            From the offset of a neighbour (a whole number in one dimension, a pair in two) to its weight: a number, an
            array over the grid, or a function of the index arrays.

        Examples
        --------
        A conductivity that grows along a line:

        >>> Template.varying({-1: lambda i: 1.0 + i, 0: lambda i: -2.0 - i, 1: 1.0}).dimension
        1
        """
        offsets = tuple((key,) if isinstance(key, int) else tuple(key) for key in rules)
        return cls(offsets, tuple(rules.values()))

    @property
    def dimension(self) -> int:
        """1 or 2."""
        return len(self.offsets[0])

    @property
    def radius(self) -> int:
        """``r`` of the neighbourhood ``N_r``: the largest offset in any direction."""
        return max(abs(k) for offset in self.offsets for k in offset)


def interconnection(template: Template, shape: tuple[int, ...], boundary: Boundary) -> csr_array:
    """The template laid over a grid: from the values of the cells, and of one virtual cell, to what each cell reads.

    Parameters
    ----------
    template : Template
        The template.
    shape : tuple of int
        Cells along each direction.
    boundary : {"fixed", "zero-flux", "periodic"}
        A neighbour beyond the edge is the virtual cell, the mirror image across the edge (cell -1 is cell 0), or the
        cell on the other side.

    Returns
    -------
    csr_array
        (n, n+1), row-major; the last column belongs to the virtual cell.

    Raises
    ------
    InputError
        Template and grid have different dimensions, the boundary is unknown, or a weight does not fit the grid or is
        not finite.
    """
    from scipy.sparse import coo_array

    if template.dimension != len(shape):
        raise InputError(
            f"a template of dimension {template.dimension} does not fit the grid {shape}; give one that does"
        )
    if boundary not in BOUNDARIES:
        raise InputError(f"boundary is {boundary!r}; give one of {', '.join(BOUNDARIES)}")
    size, reach = int(np.prod(shape)), template.radius
    cells, places = np.arange(size).reshape(shape), np.indices(shape)
    if boundary == "fixed":
        padded = np.pad(cells, reach, mode="constant", constant_values=size)
    else:
        padded = np.pad(cells, reach, mode="symmetric" if boundary == "zero-flux" else "wrap")
    rows, columns, entries = [], [], []
    for offset, weight in zip(template.offsets, template.weights, strict=True):
        read = padded[tuple(slice(reach + k, reach + k + n) for k, n in zip(offset, shape, strict=True))]
        values = np.asarray(weight(*places) if callable(weight) else weight, dtype=float)
        if values.shape not in ((), shape) or not np.isfinite(values).all():
            raise InputError(
                f"the weight at offset {offset} has shape {values.shape} or is not finite; give a number or {shape}"
            )
        values = np.broadcast_to(values, shape)
        used = values != 0.0
        rows.append(cells[used])
        columns.append(read[used])
        entries.append(values[used])
    places_of = (np.concatenate(rows), np.concatenate(columns))
    return coo_array((np.concatenate(entries), places_of), shape=(size, size + 1)).tocsr()


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


@described(frozen=True, kw_only=True, eq=False)
class CellularNetwork:
    r"""Cells that read their neighbours through cloning templates, the dynamics (40) of the paper.

    .. math:: \dot x_{ij} = \sum T^A_{ij,kl} f(x_{kl}) + \sum T^B_{ij,kl} u_{kl} - \sum T^C_{ij,kl} x_{kl} + I_{ij},

    sums over the neighbourhood of the cell.  The decay is SUBTRACTED: ``C`` with 1 in the middle is the usual ``-x``.
    Time is in the unit in which the templates are rates.

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

    shape: tuple[int, ...] = quantity("``(n,)`` cells on a line or ``(rows, columns)`` in the plane")
    A: Template = quantity("Output feedback")
    B: Template | None = quantity("Control; None for none", default=None)
    C: Template | None = quantity(
        "State feedback; None for ``x`` itself, the classical decay with time constant 1", default=None
    )
    bias: Signal = quantity(
        "``I``, a number for all or an array of one for each cell; a function of ``t`` gives either", default=0.0
    )
    output: Output = quantity(
        '``f``: ``"saturation"``, (41), ``"linear"``, ``f(x) = x``, or a function from the states of all cells (an '
        "array of ``shape``) to their outputs, which may treat cells differently as (49) asks.  Such a function "
        "must be elementwise and cannot be used with the fixed boundary, whose virtual cell it does not know",
        default="saturation",
    )
    boundary: Boundary = quantity(
        "What lies beyond the edge: a virtual cell whose state and input never change, the mirror image, or the "
        "other side",
        default="fixed",
    )
    edge_state: float = quantity("State of the virtual cell of the fixed boundary", default=0.0)
    edge_input: float = quantity("Its input", default=0.0)

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
        from lure.rod.cellular.motion import Request, motion

        return motion(self, x0, u, Request(until=until, samples=samples, at_rest=at_rest))

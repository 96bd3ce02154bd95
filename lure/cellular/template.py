"""Cloning templates: how a cell weighs its neighbours, the same everywhere or varying with position."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lure.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array: TypeAlias = NDArray[np.float64]
Weight: TypeAlias = ArrayLike | Callable[..., ArrayLike]
Boundary = Literal["fixed", "zero-flux", "periodic"]
BOUNDARIES: tuple[Boundary, ...] = ("fixed", "zero-flux", "periodic")


@dataclass(frozen=True, eq=False)
class Template:
    """Weights of a cell's neighbours: ``sum_o weights[o](cell) * value[cell + offsets[o]]``.

    Make one with :meth:`uniform` (translation-invariant) or :meth:`varying` (regularly varying).

    Attributes
    ----------
    offsets : tuple of tuple of int
        Places of the neighbours relative to the cell, one or two numbers each.
    weights : tuple
        For each neighbour a number, an array of the shape of the grid, or a function of the index arrays of the grid
        (``i`` in one dimension, ``i, j`` in two, counted from 0) [1/unit of time].

    Raises
    ------
    InputError
        There is no neighbour, or the offsets are not all one or all two whole numbers.
    """

    offsets: tuple[tuple[int, ...], ...]
    weights: tuple[Weight, ...]

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

"""Cloning templates of the rod's network and the block they assemble to, in the paper's three orderings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from lure.errors import InputError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Ordering = Literal["eq39", "eq42", "eq48"]
ORDERINGS: tuple[Ordering, ...] = ("eq39", "eq42", "eq48")


@dataclass(frozen=True, kw_only=True, slots=True)
class CloningTemplate:
    """One row rule of the network: ``cell' = sum_j weights[j] * state[cell + offsets[j]]``.

    ``offsets`` count along the ring of the ordering (42), so that offset -1 of the first cell is the last one.

    Attributes
    ----------
    cells : range or tuple of int
        Cells, counted from zero in the ordering (42), that the rule serves.
    offsets : tuple of int
        Neighbours read, relative to the cell.
    weights : tuple of float
        Weight of each neighbour [1/s].
    """

    cells: range | tuple[int, ...]
    offsets: tuple[int, ...]
    weights: tuple[float, ...]


def rod_templates(cells: int, rate: float, reflection: float) -> tuple[CloningTemplate, ...]:
    r"""Templates (44)-(47) of the rod's ring of ``2N`` cells.

    Inner cells ``2..2N`` carry ``T^AC = [s, -s, 0]`` (45); the corner cell 1 reads the last cell with weight ``-s a``
    in place of ``s`` (47).  The matrix is f-circulant with ``f = -a``, and circulant (as the paper says) only for
    ``a = -1``, that is ``k = 0``.

    Parameters
    ----------
    cells : int
        ``N >= 1``.
    rate : float
        ``s = c N / L`` [1/s].
    reflection : float
        ``a`` [-].
    """
    return (
        CloningTemplate(cells=(0,), offsets=(-1, 0), weights=(-rate * reflection, -rate)),
        CloningTemplate(cells=range(1, 2 * cells), offsets=(-1, 0), weights=(rate, -rate)),
    )


def assemble_ring(cells: int, templates: tuple[CloningTemplate, ...]) -> csr_array:
    """Interconnection matrix (2N, 2N) of the ring, in the ordering (42) [1/s].

    Parameters
    ----------
    cells : int
        ``N``.
    templates : tuple of CloningTemplate
        The rules, each with the cells it serves; those of :func:`rod_templates` for the rod.
    """
    from scipy.sparse import coo_array

    size = 2 * cells
    rows, columns, weights = [], [], []
    for template in templates:
        served = np.asarray(template.cells)
        for offset, weight in zip(template.offsets, template.weights, strict=True):
            rows.append(served)
            columns.append((served + offset) % size)
            weights.append(np.full(served.shape, weight))
    entries = (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns)))
    return coo_array(entries, shape=(size, size)).tocsr()


def ordering_permutation(cells: int, ordering: Ordering) -> NDArray[np.intp]:
    """Positions in the ordering (39) of the states listed in ``ordering``: ``y_ordering = y_39[permutation]``.

    ``eq39``: ``[xi1^1 .. xi1^N, xi2^{N-1} .. xi2^0, z]``.  ``eq42``: the same ring, with ``z`` kept as a network of its
    own, listed after it.  ``eq48``: ``z`` between the two waves.

    Parameters
    ----------
    cells : int
        ``N``.
    ordering : {"eq39", "eq42", "eq48"}
        Which one.

    Raises
    ------
    InputError
        The ordering is none of the three.
    """
    if ordering not in ORDERINGS:
        raise InputError(f"ordering is {ordering!r}; give one of {', '.join(ORDERINGS)}")
    ring = np.arange(2 * cells)
    contact = np.array([2 * cells])
    if ordering == "eq48":
        return np.concatenate((ring[:cells], contact, ring[cells:]))
    return np.concatenate((ring, contact))

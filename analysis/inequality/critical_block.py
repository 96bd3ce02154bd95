r"""Full-block multipliers of several channels beside eigenvalues 0 (in discrete time 1), proposed by one programme.

The form of ``Pi`` has to be nonnegative at the vertices of the gains and, with all of the inequality, 0 at the
equilibria ``sigma = C_0 x_0``, ``psi = 0``.  So it is 0, with its derivative, wherever ``Delta C_0 x_0 = 0`` at a
vertex.  These linear equations for ``Pi`` and for the rows of ``P`` that belong to ``x_0`` are solved in fractions, as
those of forms are (:mod:`lure.analysis.inequality.critical_forms`); the programme is about what they leave free.
Nothing here is believed: a checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import ClassVar, NamedTuple

from flint import fmpq, fmpq_mat

from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.full_block import MOST_CHANNELS, MOST_STATES
from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal
from lure.analysis.inequality.zero_modes import (
    Exact,
    Free,
    Loop,
    Rows,
    ZeroModes,
    diagonal,
    doubles,
    exact,
    floats,
    freed,
    null_rows,
)
from lure.analysis.numerics.doubles import decimals, triangle_texts
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

_SURE, _LARGEST, _LARGEST_THETA, _BITS = 1e-7, 100.0, 1e4, 56
_ROOMS = (1e-6, 1e-5, 1e-4)  # by which the form is positive where it need not be 0, so that rounding leaves it so


class _Rest(NamedTuple):
    """A solution: ``P`` on ``x_1``, the free unknowns, ``theta``."""

    P: Reals
    free: Reals
    theta: Reals


class _Vertex(NamedTuple):
    """``(1, Delta)``, ``Delta`` with entries 0 and 1, and where ``Delta sigma = 0`` for equilibria: one row each."""

    view: Exact
    still: Exact


@described()
class CriticalBlock(ChannelSearch):
    """The search for one plant; the others: see :class:`ChannelSearch`."""

    loop: Sequence[Rows] = quantity("``A``, ``B``, ``C`` and ``D`` exactly, shifted by the lower bounds")
    own: Rows = quantity("``C`` as it was given")
    modes: ZeroModes = quantity("The eigenvalues 0 (1) of the loop")
    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    popov: bool = quantity("Whether a certificate states ``theta``")
    discrete: bool = quantity("Whether in discrete time")
    precision: ClassVar[float] = 1e-6

    @property
    def possible(self) -> bool:
        """Whether the programme is small enough to be solved in seconds."""
        return len(self.A) <= MOST_STATES and len(self.D) <= MOST_CHANNELS

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme finds multipliers."""
        if not self.possible:
            return False
        loop = self._scaled([Fraction(float(w)) for w in widths])
        return self._programme(loop, self._freed(loop)) is not None

    def _scaled(self, widths: Sequence[Fraction]) -> Loop:
        """The loop from ``psi/w`` in the states ``(x_0, x_1)``."""
        A, B, C, D = self.modes.apart(self.loop)
        wide = np.array([fmpq(w.numerator, w.denominator) for w in widths], dtype=object)
        return Loop(A, B * wide, C, D * wide)

    @cached_property
    def _places(self) -> list[tuple[int, int]]:
        """The entries of ``P`` in the rows of ``x_0``."""
        return [(a, b) for a in range(self.modes.right.ncols()) for b in range(a, len(self.A))]

    @cached_property
    def _entries(self) -> list[tuple[int, int]]:
        """The entries of ``Pi``."""
        return [(i, j) for i in range(2 * len(self.D)) for j in range(i + 1)]

    @cached_property
    def _vertices(self) -> list[_Vertex]:
        m, outputs, found = len(self.D), self.modes.outputs, list[_Vertex]()
        one = np.eye(m, dtype=object)
        for pattern in product((0, 1), repeat=m):
            moved = [row for row, on in zip(outputs.tolist(), pattern, strict=True) if on]
            still = null_rows(fmpq_mat(moved)) if moved else diagonal([Fraction(1)] * outputs.ncols())
            rows = (still * outputs.transpose()).tolist()
            found.append(_Vertex(np.vstack([one, one * pattern]), np.array(rows, dtype=object).reshape(-1, m)))
        return found

    def _freed(self, loop: Loop) -> Free:
        """The equations for ``P`` in the rows of ``x_0``, and for ``Pi``."""
        A, B, C, D = loop
        (n, m), r, columns = B.shape, self.modes.right.ncols(), list[Exact]()
        moved = np.hstack([A, -B])
        seen = np.vstack([np.hstack([C, -D]), np.eye(n + m, dtype=object)[n:]])
        side = np.eye(n, n + m, dtype=object) - moved if self.discrete else -moved
        count = sum(m * len(one.still) for one in self._vertices)
        for a, b in self._places:
            column = np.zeros((r, n + m), dtype=object)
            column[a] += side[b]
            if a != b and b < r:
                column[b] += side[a]
            columns.append(np.concatenate([column.ravel(), np.zeros(count, dtype=object)]))
        for i, j in self._entries:
            parts = [-_twice(seen, i, j)[:r].ravel()]
            parts += [(one.still @ _twice(one.view, i, j)).ravel() for one in self._vertices]
            columns.append(np.concatenate(parts))
        return freed(np.array(columns, dtype=object).T, [False] * len(columns))

    def _programme(self, loop: Loop, given: Free, room: float = _ROOMS[0]) -> _Rest | None:
        """What is free, with a margin that is more than rounding; None if there is nothing."""
        checkpoint()
        A, B, C, D = map(floats, loop)
        (n, m), r, basis = B.shape, self.modes.right.ncols(), doubles(given.basis)
        moved, now, order = np.hstack([A, -B]), np.eye(n, n + m), len(self._places)
        seen = np.vstack([np.hstack([C, -D]), np.eye(n + m)[n:]])
        inner = np.zeros(((n - r) * (n - r + 1) // 2, n, n))
        inner[:, r:, r:] = symmetric_basis(n - r)
        outer = np.zeros((order, n, n))
        for k, (a, b) in enumerate(self._places):
            outer[k, a, b] = outer[k, b, a] = 1.0

        def falling(E: Reals) -> Reals:
            """What matrices ``P`` add to the fall of ``V``."""
            found = moved.T @ E @ moved - now.T @ E @ now if self.discrete else now.T @ E @ moved + moved.T @ E @ now
            return np.asarray(-found[:, r:, r:])

        form = np.array([_symmetric(2 * m, i, j) for i, j in self._entries])
        turned = [i for i in range(m) if self.free[i]]
        rates = [-np.outer(np.eye(n + m)[n + i], C[i] @ moved) for i in turned]
        turns = np.array([s * (t + t.T) for t in rates for s in (1, -1)]).reshape(-1, n + m, n + m)
        at = np.cumsum([0, len(inner), basis.shape[1], len(turns), 1])
        first, second = np.zeros((at[-1], n + m - r, n + m - r)), np.zeros((at[-1], n, n))
        first[: at[1]], second[: at[1]] = falling(inner), inner
        known = np.concatenate([falling(outer), -(seen.T @ form @ seen)[:, r:, r:]])
        first[at[1] : at[2]] = np.tensordot(basis.T, known, 1)
        second[at[1] : at[2]] = np.tensordot(basis[:order].T, outer, 1)
        first[at[2] : at[3]] = turns[:, r:, r:]
        for k, i in enumerate(turned):
            second[at[2] + 2 * k + 1] = -np.outer(C[i], C[i])
        first[-1, n - r :, n - r :], second[-1] = -np.eye(m), np.zeros((n, n))
        blocks = [Block(np.zeros(side.shape[1:]), side) for side in (first, second)]
        for one in self._vertices:
            beside = _beside(floats(one.still))
            view = floats(one.view) @ beside
            slopes = np.zeros((at[-1], view.shape[1], view.shape[1]))
            slopes[at[1] : at[2]] = np.tensordot(basis[order:].T, view.T @ form @ view, 1)
            if view.shape[1]:
                blocks.append(Block(-room * np.eye(view.shape[1]), slopes))
        found = proposed(np.eye(at[-1])[-1], blocks, *self._signed(basis[order:], at, room))
        if found is None or found[-1] <= _SURE:
            return None
        theta = np.zeros(m)
        theta[turned] = found[at[2] : at[3]][::2] - found[at[2] : at[3]][1::2]
        return _Rest(np.tensordot(found[: at[1]], inner, 1)[r:, r:], found[at[1] : at[2]], theta)

    def _signed(self, basis: Reals, at: NDArray[np.intp], room: float) -> tuple[Reals, Reals]:
        """Sizes, and that ``Pi`` is concave in each gain, as rows and what these are at most."""
        limits, m = Limits(int(at[-1])), len(self.D)
        for (i, j), row in zip(self._entries, basis, strict=True):
            terms = {int(at[1]) + int(k): float(row[k]) for k in np.flatnonzero(row)}
            if i == j and terms:
                limits.at_most(terms, _LARGEST if i < m else -room)
                limits.at_most({k: -v for k, v in terms.items()}, _LARGEST)
        for k in range(at[2], at[3]):
            limits.at_most({k: 1.0}, _LARGEST_THETA)
            limits.at_most({k: -1.0}, 0.0)
        limits.at_most({int(at[-1]) - 1: 1.0}, _LARGEST)
        return limits.arrays()

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded where the equations leave it free."""
        if not self.possible:
            return
        loop = self._scaled(widths)
        given = self._freed(loop)
        for room in _ROOMS:
            found = self._programme(loop, given, room)
            if found is not None:
                yield self._proposal(found, given, widths, lower)

    def _proposal(self, found: _Rest, given: Free, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Proposal:
        m, r = len(self.D), self.modes.right.ncols()
        unknowns = (given.basis * exact([[v] for v in decimals(found.free)])).entries()
        P, form = ([[fmpq(0)] * size for _ in range(size)] for size in (len(self.A), 2 * m))
        for (a, b), value in zip(self._places, unknowns, strict=False):
            P[a][b] = P[b][a] = value
        for (i, j), value in zip(self._entries, unknowns[len(self._places) :], strict=True):
            form[i][j] = form[j][i] = value
        exponent = _BITS - math.floor(math.log2(min([1.0, *np.abs(np.diag(found.P))])))
        for i, row in enumerate(found.P.tolist()):
            for j, v in enumerate(row[: i + 1]):
                P[r + i][r + j] = P[r + j][r + i] = fmpq(round(Fraction(v) * 2**exponent), 2**exponent)
        theta = [v / w for v, w in zip(decimals(found.theta), widths, strict=True)]
        whole, C = self.modes.turn.transpose() * fmpq_mat(P) * self.modes.turn, exact(self.own)
        whole -= C.transpose() * diagonal([t * v for t, v in zip(theta, lower, strict=True)]) * C
        entries, factor = whole.numer_denom()
        units = diagonal([*[Fraction(1)] * m, *(1 / w for w in widths)])
        shift = exact([[Fraction(i == j) - (j == i - m) * lower[j % m] for j in range(2 * m)] for i in range(2 * m)])
        Pi = factor * shift.transpose() * units * fmpq_mat(form) * units * shift
        zero = zip(*self.modes.right.tolist(), *(diagonal(lower) * self.modes.outputs).tolist(), strict=True)
        multiplier: dict[str, object] = {"Pi": triangle_texts(Pi.tolist())}
        multiplier |= {"theta": [str(int(factor) * v) for v in theta]} if self.popov else {}
        rows = triangle_texts(entries.tolist())
        proof = {"method": "matrix", "P": rows, "exponent": 0, "zero": [[*map(str, v)] for v in zero]}
        return Proposal(multiplier, proof)


def _symmetric(size: int, i: int, j: int) -> NDArray[np.float64]:
    """The matrix with 1 at two places."""
    found = np.zeros((size, size))
    found[i, j] = found[j, i] = 1.0
    return found


def _twice(view: Exact, i: int, j: int) -> Exact:
    """``view' E view`` for the matrix ``E`` with 1 at two places."""
    both = np.outer(view[i], view[j])
    return both + both.T if i != j else both


def _beside(rows: Reals) -> Reals:
    """An orthonormal basis of what is orthogonal to some rows, one column each."""
    count = rows.shape[1]
    if not len(rows):
        return np.eye(count)
    turn = np.linalg.svd(rows)[2]
    return np.asarray(turn[len(rows) :].T)

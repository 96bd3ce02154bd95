r"""Forms that couple channels and samples beside eigenvalues 0 (in discrete time 1), proposed by one programme.

After the shift by the lower bounds let ``x = N x_0 + X x_1`` (:mod:`lure.analysis.inequality.zero_modes`), so that
``x_0+ = x_0 - B_0 psi``.  The form of the inequality has to be 0, with its derivative, where ``x_1 = 0`` and ``psi =
0``: linear equations for the forms and the rows ``P_0`` of ``P`` that belong to ``x_0``, of which the checkers know
that they hold exactly.  They are solved in fractions; the programme is about what they leave free and about ``P`` on
``(x_1, psi)``.  Where an equation has terms of one sign, its unknowns are 0.  Nothing here is believed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

from flint import fmpq, fmpq_mat

from lure.analysis.certificates.channels import Plant
from lure.analysis.certificates.frequencies import shifted
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.coupled_forms import Cone, CoupledForms
from lure.analysis.inequality.shifted_loop import Proposal
from lure.analysis.inequality.zero_modes import (
    Exact,
    Free,
    Loop,
    ZeroModes,
    diagonal,
    doubles,
    exact,
    floats,
    fractions,
    freed,
)
from lure.analysis.numerics.doubles import decimals, triangle_texts
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

_SURE, _LARGEST, _LEAST, _BITS = 1e-7, 100.0, 1e-8, 56


class _Rest(NamedTuple):
    """A solution: ``P`` on ``(x_1, psi)``, the free unknowns, the forms at the start, ``theta``."""

    P: Reals
    free: Reals
    start: list[Reals]
    theta: Reals


@described(kw_only=True)
class CriticalForms(CoupledForms):
    """The search beside eigenvalues 0 (1); the others: see :class:`CoupledForms`."""

    plant: Plant = quantity("As it was given, exactly")
    least: Sequence[Fraction] = quantity("(m,) the lower bounds")
    modes: ZeroModes = quantity("The eigenvalues 0 of the loop with these")

    @cached_property
    def _loop(self) -> Loop:
        """The loop shifted by the lower bounds, in the states ``(x_0, x_1)``."""
        return self.modes.apart(shifted(self.plant, list(self.least)))

    def _window(self, loop: Loop, samples: int) -> tuple[Exact, Exact]:
        """The next state (``x'``) and all ``sigma``, of ``(x, psi_1, .., psi_T)``."""
        A, B, C, D = loop
        n, m = B.shape
        phi = np.eye(n + m * samples, dtype=object)[n:]
        x, states, sigma = np.eye(n, n + m * samples, dtype=object), list[Exact](), list[Exact]()
        for t in range(samples):
            at = phi[m * t : m * (t + 1)]
            sigma.append(C @ x - D @ at)
            x = A @ x - B @ at
            states.append(x)
        return states[0], np.vstack(sigma)

    def _parts(self, widths: Sequence[Fraction], samples: int) -> tuple[Exact, Exact]:
        """``u`` and ``v`` of all samples, of ``(x, psi_1, .., psi_T)``."""
        seen = self._window(self._loop, samples)[1]
        wide = np.array([fmpq(w.numerator, w.denominator) for w in widths] * samples, dtype=object)
        u = np.eye(seen.shape[1], dtype=object)[len(self.A) :]
        return u, wide[:, None] * seen - u

    def _freed(self, widths: Sequence[Fraction]) -> Free:
        """The equations: the columns of the inequality that belong to ``x_0`` are 0."""
        n, m, T, r = len(self.A), len(self.D), self.samples, self.modes.right.ncols()
        moved = self._window(self._loop, T)[0]
        now, (u, v) = np.eye(self.order, n + m * T, dtype=object), self._parts(widths, T)
        later = np.vstack([moved, np.eye(n + m * T, dtype=object)[n + m :]])
        side, columns, positive = now - later if self.discrete else -moved, list[Exact](), list[bool]()
        for a, b in self._places:
            column = np.zeros((r, n + m * T), dtype=object)
            column[a] += side[b]
            if a != b and b < r:
                column[b] += side[a]
            columns.append(column.ravel())
            positive.append(False)
        for group, cone in zip(self.groups, self.cones, strict=True):
            places = [m * t + i for t in range(T) for i in group.channels]
            w = np.concatenate(group.sides(u[places], v[places]))
            for one in cone.entries:
                if group.kind == "operator":
                    last = u[places[-len(group.channels) :]] + v[places[-len(group.channels) :]]
                    column = -np.sum([np.outer(row[:r], row) for row in last], axis=0)
                else:
                    left, right = w[one.row], w[one.column]
                    both = np.outer(left[:r], right) + np.outer(right[:r], left) * (one.row != one.column)
                    column = -one.sign * both
                columns.append(column.ravel())
                positive.append(not one.free)
        return freed(np.array(columns, dtype=object).T, positive)

    @cached_property
    def _places(self) -> list[tuple[int, int]]:
        """The entries of ``P`` in the rows of ``x_0``."""
        return [(a, b) for a in range(self.modes.right.ncols()) for b in range(a, self.order)]

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme finds forms."""
        exactly = [Fraction(float(w)) for w in widths]
        return self._programme(exactly, self._freed(exactly)) is not None

    def _programme(self, widths: Sequence[Fraction], given: Free) -> _Rest | None:
        """What is free, with a margin that is more than rounding; None if there is nothing, or too much."""
        if not self.possible:
            return None
        checkpoint()
        n, m, T, r, order = len(self.A), len(self.D), self.samples, self.modes.right.ncols(), self.order
        basis, wide, N = doubles(given.basis), np.array([float(w) for w in widths]), n + m * T
        size, moved = self._sized(wide), floats(self._window(self._loop, T)[0])
        u, v = map(floats, self._parts(widths, T))
        inner, outer = self._unknowns(size)
        C, turned = floats(self._loop[2]) * size[:n], [i for i in range(m) if self.free[i]]
        forms = [-self._products(g, c, u, v, T) for g, c in zip(self.groups, self.cones, strict=True)]
        known = np.concatenate([self._falling(outer, moved), *forms]) * np.outer(size, size)
        rates = [-np.outer(np.eye(N)[n + i], C[i] @ (moved / size[:n, None])) * np.outer(size, size) for i in turned]
        turns = np.array([s * self.unit * (t + t.T) for t in rates for s in (1, -1)]).reshape(-1, N, N)
        scale = np.outer(size[:order], size[:order])
        begun = [
            -self._products(g, c, u, v, T - 1)[:, :order, :order] * scale
            for g, c in zip(self.groups, self.starts, strict=False)
        ]
        at = np.cumsum([0, len(inner), basis.shape[1], len(turns), *map(len, begun), 1])
        first, second = np.zeros((at[-1], N - r, N - r)), np.zeros((at[-1], order, order))
        first[: at[1]] = (self._falling(inner, moved) * np.outer(size, size))[:, r:, r:]
        first[at[1] : at[2]] = np.tensordot(basis.T, known[:, r:, r:], 1)
        first[at[2] : at[3]] = turns[:, r:, r:]
        first[-1] = -np.eye(N - r)
        second[: at[1]] = inner * scale
        second[at[1] : at[2]] = np.tensordot(basis[: len(outer)].T, outer * scale, 1)
        for k, i in enumerate(turned):
            second[at[2] + 2 * k + 1] = -wide[i] * np.outer(C[i], C[i]) * self.unit
        for part, place in zip(begun, at[3:], strict=False):
            second[place : place + len(part)] = part
        blocks = [Block(np.zeros(first.shape[1:]), first)]
        if self.bounded:
            second[-1] = -np.eye(order)
            blocks.append(Block(np.zeros(second.shape[1:]), second))
        else:
            moves = np.zeros((at[-1], r, r))
            moves[at[1] : at[2]] = np.tensordot(basis[len(outer) :].T, self._moves(v, r) * scale[:r, :r], 1)
            blocks += [Block(-_SURE * np.eye(r), side) for side in (second[:, :r, :r], moves)]
        cost = np.eye(at[-1])[-1]
        found = proposed(cost, blocks, *self._signed(given, basis, at))
        if found is None or found[-1] <= _SURE:
            return None
        theta, each = np.zeros(m), [found[a:b] for a, b in pairwise(at)]
        theta[turned] = (each[2][::2] - each[2][1::2]) * self.unit
        return _Rest(np.tensordot(each[0], inner, 1)[r:, r:], each[1], each[3:-1], theta)

    def _unknowns(self, size: Reals) -> tuple[Reals, Reals]:
        """Matrices of the entries of ``P``: of those of ``(x_1, psi)`` in their units, of those of ``x_0``."""
        r, order = self.modes.right.ncols(), self.order
        inner = np.zeros(((order - r) * (order - r + 1) // 2, order, order))
        inner[:, r:, r:] = symmetric_basis(order - r) / np.outer(size[r:order], size[r:order])
        outer = np.zeros((len(self._places), order, order))
        for k, (a, b) in enumerate(self._places):
            outer[k, a, b] = outer[k, b, a] = 1.0
        return inner, outer

    def _falling(self, E: Reals, moved: Reals) -> Reals:
        """What matrices ``P`` add to the fall of ``V``."""
        N = moved.shape[1]
        now, later = np.eye(self.order, N), np.vstack([moved, np.eye(N)[len(moved) + len(self.D) :]])
        if self.discrete:
            return np.asarray(now.T @ E @ now - later.T @ E @ later)
        return np.asarray(-(now.T @ E @ moved + moved.T @ E @ now))

    def _sized(self, wide: Reals) -> Reals:
        """Units of ``x_0``, ``x_1`` and ``psi``: about as large as the inputs make them."""
        A, B, C, D = map(floats, self._loop)
        r = self.modes.right.ncols()
        inner = CoupledForms(
            *(A[r:, r:], B[r:], C[:, r:], D, 0 * self.lower),
            groups=[],
            samples=1,
            free=[],
            popov=False,
            discrete=self.discrete,
        )
        units = [np.abs(B[:r] * wide).max(axis=1), inner.scales(wide)[0] if len(A) > r else np.zeros(0)]
        return np.concatenate([*units, *[wide] * self.samples])

    def _moves(self, v: Reals, r: int) -> Reals:
        """``sum u'M_uv v + v'M_vu u`` of each unknown of the forms, for ``u = v = w sigma`` at the equilibria."""
        found, m = list[Reals](), len(self.D)
        for group, cone in zip(self.groups, self.cones, strict=True):
            places = [m * t + i for t in range(self.samples) for i in group.channels]
            w, p = v[places, :r], len(places)
            for one in cone.entries:
                product = one.sign * np.outer(w[one.column % p], w[one.row % p])
                found.append(product + product.T)
        return np.array(found)

    def _signed(self, given: Free, basis: Reals, at: NDArray[np.intp]) -> tuple[Reals, Reals]:
        """Signs, sums and sizes, as rows and what these are at most; those of the equations with some room."""
        limits, total, place = Limits(int(at[-1])), int(at[-1]), len(self._places)

        def terms(weights: dict[int, float]) -> dict[int, float]:
            """The free unknowns in a sum of unknowns."""
            row = sum(weight * basis[k] for k, weight in weights.items())
            return {int(at[1]) + int(j): float(np.asarray(row)[j]) for j in np.flatnonzero(row)}

        for cone in self.cones:
            for k, entry in enumerate(cone.entries, place):
                if k not in given.absent:
                    limits.at_most(terms({k: 1.0}), _LARGEST)
                    limits.at_most(terms({k: -1.0}), _LARGEST if entry.free else -_LEAST)
            for one in cone.sums:
                weights = {place + k: -float(factor) for k, factor in one.items() if place + k not in given.absent}
                if weights:
                    limits.at_most(terms(weights), -_LEAST)
            place += len(cone.entries)
        for k in range(at[2], at[3]):
            limits.at_most({k: 1.0}, 1e4)
            limits.at_most({k: -1.0}, 0.0)
        for cone, start in zip(self.starts, at[3:], strict=False):
            for k, entry in enumerate(cone.entries, int(start)):
                limits.at_most({k: 1.0}, _LARGEST)
                limits.at_most({k: -1.0}, _LARGEST if entry.free else 0.0)
            for one in cone.sums:
                limits.at_most({int(start) + k: -float(factor) for k, factor in one.items()}, 0.0)
        limits.at_most({total - 1: 1.0}, _LARGEST)
        return limits.arrays()

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded where the equations leave it free."""
        given = self._freed(widths)
        found = self._programme(widths, given)
        if found is None:
            return
        free = exact([[v] for v in decimals(found.free)])
        unknowns = [Fraction(int(v.p), int(v.q)) for v in (given.basis * free).entries()]
        forms, place = list[list[Fraction]](), len(self._places)
        for cone in self.cones:
            forms.append(unknowns[place : place + len(cone.entries)])
            place += len(cone.entries)
        theta = decimals(found.theta)
        whole, own = self._view().transpose() * self._whole(unknowns, found.P) * self._view(), exact(self.plant.C)
        if self.samples == 1:
            whole -= own.transpose() * diagonal([t * v for t, v in zip(theta, lower, strict=True)]) * own
        entries, common = whole.numer_denom()
        factor = int(common)
        start = [cone.rounded(x) for cone, x in zip(self.starts, found.start, strict=True)]
        multiplier: dict[str, Any] = {"forms": self._times(factor, self.cones, forms, self.samples)}
        weights = [Fraction(0)] * len(self.D)
        for group, x in zip(self.groups, forms, strict=True):
            for i in group.channels if group.kind == "operator" else ():
                weights[i] = factor * x[0] / (1 + (self.samples == 1))
        if any(group.kind == "operator" for group in self.groups):
            multiplier["lambda"] = [str(v) for v in weights]
        if self.samples > 1:
            begun = self._times(factor, self.starts, start, self.samples - 1) if self.bounded else None
            multiplier |= {"samples": self.samples, "start": begun}
        elif self.popov:
            multiplier["theta"] = [str(factor * v) for v in theta]
        rows = triangle_texts(entries.tolist())
        phi = diagonal(lower) * self.modes.outputs
        zero = [[*map(str, v)] for v in zip(*self.modes.right.tolist(), *phi.tolist(), strict=True)]
        yield Proposal(multiplier, {"method": "matrix", "P": rows, "exponent": 0, "zero": zero})

    def _whole(self, unknowns: Sequence[Fraction], inner: Reals) -> fmpq_mat:
        """``P`` of ``(x_0, x_1, psi_1, ..)``: the entries of ``x_0`` as they are, the others rounded."""
        P, r = [[fmpq(0)] * self.order for _ in range(self.order)], self.modes.right.ncols()
        for (a, b), value in zip(self._places, unknowns, strict=False):
            P[a][b] = P[b][a] = fmpq(value.numerator, value.denominator)
        exponent = _BITS - math.floor(math.log2(min([1.0, *np.abs(np.diag(inner))])))
        for i, row in enumerate(inner.tolist()):
            for j, v in enumerate(row[: i + 1]):
                P[r + i][r + j] = P[r + j][r + i] = fmpq(round(Fraction(v) * 2**exponent), 2**exponent)
        return fmpq_mat(P)

    def _times(
        self, factor: int, cones: Sequence[Cone], forms: Sequence[Sequence[Fraction]], samples: int
    ) -> list[Mapping[str, Any]]:
        return self.stated(cones, [[factor * v for v in x] for x in forms], samples)

    def _view(self) -> fmpq_mat:
        """``(x_0, x_1, psi_1, .., psi_(T - 1))`` of ``(x, phi_1, .., phi_(T - 1))``."""
        n, m, T = len(self.A), len(self.D), self.samples - 1
        if not T:
            return self.modes.turn
        sigma = self._window(Loop(*(fractions(exact(side)) for side in self.plant[:4])), T)[1]
        low = np.array([fmpq(v.numerator, v.denominator) for v in self.least] * T, dtype=object)
        psi = np.eye(n + m * T, dtype=object)[n:] - low[:, None] * sigma
        top = [[*row, *[fmpq(0)] * (m * T)] for row in self.modes.turn.tolist()]
        return fmpq_mat([*top, *([fmpq(v) for v in row] for row in psi.tolist())])

r"""Periodic solutions of several channels in discrete time, and equilibria: found in floating point, then made exact.

An equilibrium has a period of one sample; in continuous time, with ``R = H(0)``, there is no other.  With gains
``G`` beforehand, ``phi = G sigma + w``, ``sigma = -R w`` over one period.  On some channels ``w_i`` and
``k_i sigma_i - w_i`` are ordered alike, zero included, ``k_i`` being the width of the class; on the others ``w = 0``.
For one order of the samples ``w = V d``, ``d >= 0`` are the steps between neighbours, and the condition reads ``K A d
>= d`` with ``A = -V^-1 R V``: a matrix game, as for one channel in :mod:`.periodic_discrete`.  Orders come from
sinusoids near a frequency where the linear loop oscillates, and from exchanges of neighbours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import Any, NamedTuple

from flint import fmpq, fmpq_mat

from lure.analysis.certificates.channels import Plant, closed_loop
from lure.analysis.counterexamples.matrix_game import (
    Family,
    all_patterns,
    basis,
    neighbours,
    pattern_count,
    solve_games,
)
from lure.analysis.counterexamples.orbit import PiecewiseLinear
from lure.analysis.deadline import checkpoint
from lure.analysis.inequality.zero_modes import exact
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.arrays import Complexes, Reals, np
from lure.errors import InputError
from lure.record import described, quantity

_LONGEST, _MOST_SAMPLES, _ALL = 12, 36, 800
_SUBSETS, _WAVES, _RISES, _CLIMBS = 7, 3, 30, 12
_GAIN, _TINY, _NONE = 1e-9, 1e-12, 1e-200
_GIVEN = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)


class _Room(NamedTuple):
    """Where orbits are looked for: the blocks whose ``w`` is not 0, their samples, ``w[t + q] = twist w[t]``."""

    gains: list[Fraction]
    own: list[int]  # blocks
    response: Reals  # R, block after block, in each channel after channel
    H: Complexes
    q: int
    twist: int


class _Best(NamedTuple):
    """The least factor of one pattern: values of each block, and the steps."""

    alpha: float
    room: _Room
    values: list[Reals]


@described(frozen=True)
class SampledOrbits:
    """The search for one loop."""

    plant: Plant = quantity("Exactly")
    lower: Sequence[Fraction] = quantity("Lower bounds of the classes")
    upper: Sequence[Fraction] = quantity("Upper bounds of the classes, which are multiplied by the factor")
    blocks: Sequence[Sequence[int]] = quantity("The channels of each nonlinearity")
    families: Sequence[Family | str] = quantity(
        'Of each block, what a periodic solution has to keep; ``""``: a gain, which stays as it is'
    )
    odd: Sequence[bool] = quantity("Whether the nonlinearity of a block has to be odd")

    def found(self, known: Fraction, most: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Factors between two, the least first, and the proofs that they are refuted.

        ``known``: smaller ones are of no interest; ``most``: nor are larger ones.
        """
        best = list[_Best]()
        for room in self._rooms(known):
            checkpoint()
            one = self._least(room, best[-1].alpha if best else most)
            best += [] if one is None else [one]
        for one in best[::-1]:
            yield from self._exactly(one)

    def _width(self, room: _Room, alpha: float) -> Reals:
        """``k`` of each sample."""
        each = [float(self.upper[b[0]]) * alpha - float(self.lower[b[0]]) for b in self._own(room)]
        return np.repeat(each, [len(b) * room.q for b in self._own(room)])

    def _own(self, room: _Room) -> list[Sequence[int]]:
        return [self.blocks[k] for k in room.own]

    def _family(self, room: _Room, k: int) -> Family:
        kept: Family = "sector" if self.families[k] == "sector" else "odd"
        return kept if room.twist == -1 or self.families[k] != "monotone" else "monotone"

    def _rooms(self, known: Fraction) -> Iterator[_Room]:
        """The kinds of orbit, those of few blocks before those of more."""
        able = [k for k, family in enumerate(self.families) if family]
        subsets = [own for size in range(1, len(able) + 1) for own in combinations(able, size)][:_SUBSETS]
        for own in subsets:
            inside = [i for k in own for i in self.blocks[k]]
            ends = [list(self.lower)]
            if len(inside) < len(self.lower) and known > 0:
                ends.append(
                    [low if i in inside else max(known * self.upper[i], low) for i, low in enumerate(self.lower)]
                )
            for gains in ends:
                closed = closed_loop(
                    self.plant, [[g * (i == j) for j in range(len(gains))] for i, g in enumerate(gains)]
                )
                if closed is None:
                    continue
                A, B, C, D = (np.array([[float(v) for v in row] for row in side]) for side in closed[:4])
                longest = min(_LONGEST, _MOST_SAMPLES // len(inside)) if self.plant.discrete else 1
                for q in range(1, longest + 1):
                    for twist in (1, -1) if self.plant.discrete else (1,):
                        roots = np.exp(1j * np.pi * (2 * np.arange(q) + (twist < 0)) / q)
                        roots = roots if self.plant.discrete else np.zeros(1)
                        try:
                            states = np.linalg.solve(roots[:, None, None] * np.eye(len(A)) - A, B[None].astype(complex))
                        except np.linalg.LinAlgError:
                            continue
                        H = (C @ states + D)[:, inside][:, :, inside]
                        if np.abs(H).max(initial=0) > 1e9:
                            continue
                        wave = roots[None, :] ** np.arange(q)[:, None]
                        R = np.einsum("tk,kij,sk->itjs", wave, H, wave.conj()).real / q
                        size = len(inside) * q
                        yield _Room(gains, list(own), R.reshape(size, size), H, q, twist)

    def _patterns(self, room: _Room) -> list[list[Reals]]:
        """Orders of the samples of each block."""
        q, sizes = room.q, [len(b) * room.q for b in self._own(room)]
        if (every := self._all_patterns(room)) is not None:
            return every
        scale = np.array([float(self.upper[i]) for b in self._own(room) for i in b])
        tops: list[tuple[float, int, Complexes]] = []
        for at in range(q // 2 + 1 if room.twist > 0 else (q + 1) // 2):
            values, vectors = np.linalg.eig(-room.H[at] * scale)
            tops += [(abs(np.angle(value)), at, vectors[:, j]) for j, value in enumerate(values)]
        found: list[list[Reals]] = []
        t = np.arange(q)
        for _, at, shape in sorted(tops, key=lambda one: one[0])[:_WAVES]:
            turn = np.exp(1j * np.pi * (2 * at + (room.twist < 0)) / q * t)
            for phase in np.exp(1j * np.pi * (2 * np.arange(4) + 1) / (4 * q)):
                wave = (phase * shape[:, None] * turn).real.ravel() + 1e-9 * np.cos(7.0 * np.arange(len(shape) * q) + 1)
                parts = [np.asarray(part, dtype=float) for part in np.split(wave, np.cumsum(sizes)[:-1])]
                found.append(parts)
                if "monotone" in [self._family(room, own) for own in room.own]:
                    for share in (0.25, 0.5, 0.75):
                        ranks = [np.argsort(np.argsort(v)).astype(np.float64) for v in parts]
                        found.append([v + 0.5 - round(share * len(v)) for v in ranks])
        return found

    def _all_patterns(self, room: _Room) -> list[list[Reals]] | None:
        """All orders, up to shifts in time and a common sign, of one block or of one sample; None if they are many."""
        families, each = [self._family(room, k) for k in room.own], list[Reals]()
        if len(families) > 1 and room.q > 1:
            return None
        for block, family in zip(self._own(room), families, strict=True):
            c = len(block)
            if pattern_count(c * room.q, family) * c * math.prod(map(len, each)) > _ALL:
                return None
            rows = all_patterns(c * room.q, family).reshape(-1, c, room.q)  # the largest is in the first channel
            swaps = [[j, *(0 if i == j else i for i in range(1, c))] for j in range(c if family != "sector" else 1)]
            signs = (1,) if family == "monotone" or (not each and "monotone" not in families) else (1, -1)
            each.append(np.vstack([sign * rows[:, order].reshape(len(rows), -1) for order in swaps for sign in signs]))
        return [list(rows) for rows in product(*each)]

    def _steps(self, room: _Room, values: list[Reals]) -> Reals:
        """``V``, the blocks after one another."""
        V = np.zeros((len(room.response),) * 2)
        start = 0
        for k, part in zip(room.own, values, strict=True):
            end = start + len(part)
            V[start:end, start:end] = basis(part[None], self._family(room, k))[0]
            start = end
        return V

    def _least(self, room: _Room, most: float) -> _Best | None:
        """The least factor below ``most`` of the patterns, and of what exchanges of neighbours reach."""
        best, tried = None, self._patterns(room)
        for _ in range(_CLIMBS):
            one = self._of(room, tried, most * (1 - _GAIN)) if tried else None
            if one is None:
                break
            best, most = one, one.alpha
            tried = [
                [*one.values[:j], row, *one.values[j + 1 :]]
                for j, k in enumerate(room.own)
                for row in neighbours(one.values[j], self._family(room, k))
            ]
        return best

    def _of(self, room: _Room, tried: list[list[Reals]], alpha: float) -> _Best | None:
        """The least factor of some patterns, if one is below ``alpha``."""
        V = np.array([self._steps(room, values) for values in tried])
        A, places, best = np.linalg.solve(V, -room.response @ V), np.arange(len(tried)), None
        top = np.repeat([float(self.upper[b[0]]) for b in self._own(room)], [len(b) * room.q for b in self._own(room)])
        for _ in range(_RISES):
            wide = self._width(room, alpha)
            if wide.min() <= 0:
                break
            games = wide[:, None] * A[places] - np.eye(len(wide))
            solved = solve_games(games)
            keep = solved.value > _TINY * np.abs(games).max()
            places, mixtures = places[keep], solved.mixture[keep]
            if not len(places):
                break
            image = np.einsum("bij,bj->bi", A[places], mixtures)
            needed = np.where(mixtures > 0, np.inf, 0.0)
            np.divide(mixtures, image, out=needed, where=(mixtures > 0) & (image > _NONE))
            spare = wide - needed
            still = np.where(spare >= 0, 0.0, np.inf)  # an upper bound 0 is that for all factors
            factor = np.where(top > 0, alpha - spare / np.where(top > 0, top, 1.0), still).max(axis=1)
            at = int(factor.argmin())
            if not factor[at] < alpha:
                break
            best = _Best(float(factor[at]), room, tried[places[at]])
            alpha = best.alpha * (1 - _GAIN)
        return best

    def _exactly(self, one: _Best) -> Iterator[tuple[Fraction, dict[str, Any]]]:
        """Certificates of one orbit, a little above its factor."""
        room, V = one.room, self._steps(one.room, one.values)
        A = np.linalg.solve(V, -room.response @ V)
        for give in _GIVEN:
            alpha = one.alpha * (1 + give)
            solved = solve_games((self._width(room, alpha)[:, None] * A - np.eye(len(A)))[None])
            if not solved.value[0] > 0:
                continue
            d = [Fraction(round(v * 2**50), 2**50) for v in solved.mixture[0]]
            w = [sum(int(v) * x for v, x in zip(row, d, strict=True)) for row in V]
            proof = self._proof(room, [Fraction(v) for v in w])
            if proof is not None:
                yield Fraction(alpha), proof

    def _proof(self, room: _Room, w: list[Fraction]) -> dict[str, Any] | None:
        """The certificate of ``w``, whose ``x`` is the periodic one; None if points contradict one another."""
        gains, half, m = room.gains, room.twist == -1, len(self.lower)
        closed = closed_loop(self.plant, [[g * (i == j) for j in range(m)] for i, g in enumerate(gains)])
        inside = [i for b in self._own(room) for i in b]
        assert closed is not None, "it was"
        A, B, C, D = (exact(side) for side in closed[:4])
        n, zero = A.nrows(), fmpq(0)
        steps = []
        for t in range(room.q):
            row = [zero] * m
            for j, i in enumerate(inside):
                row[i] = to_fmpq(-w[j * room.q + t])
            steps.append(fmpq_mat([[v] for v in row]))
        total, power = fmpq_mat(n, 1), fmpq_mat([[fmpq(int(i == j)) for j in range(n)] for i in range(n)])
        whole = power
        for u in steps:
            total, whole = A * total + B * u, A * whole
        try:
            x = (power * fmpq(room.twist * self.plant.discrete) - whole).solve(total)
        except ZeroDivisionError:
            return None
        state, points, inputs = x, [list[tuple[Fraction, Fraction]]() for _ in self.blocks], list[list[str]]()
        for u in steps:
            sigma, values = C * x + D * u, list[str]()
            for i in range(m):
                at = to_fraction(sigma[i, 0])
                phi = gains[i] * at - to_fraction(u[i, 0])
                values.append(str(phi))
                points[next(k for k, b in enumerate(self.blocks) if i in b)].append((at, phi))
            inputs.append(values)
            x = A * x + B * u
        given = []
        for k, (block, own) in enumerate(zip(self.blocks, points, strict=True)):
            gain = str(gains[block[0]])
            try:
                graph = PiecewiseLinear.through(own if k in room.own else [], gains[block[0]], odd=half or self.odd[k])
            except InputError:
                return None
            listed = [[str(s), str(v)] for s, v in graph.points]
            given.append({"points": listed, "left": gain, "right": gain})
        said = {"nonlinearities": given, "state": [str(to_fraction(state[i, 0])) for i in range(n)]}
        if room.q == 1 and not half:
            return {"method": "equilibrium", "inputs": inputs[0], **said}
        return {"method": "sampled-orbit", "inputs": inputs, "half": half, **said}

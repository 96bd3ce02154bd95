r"""Forms that can only be semidefinite, beside eigenvalues 0: gains where ``w`` moves these, and what attracts all.

With ``V = x'Px + 2 sum theta_i int psi_i >= 0``, ``x(0) = 0``, it is enough for a gain that

.. math:: -\dot V - \sum 2 \lambda_i \psi_i (w_i \sigma_i - \psi_i) - |z|^2 + g |w|^2 \ge 0

as a form in ``(x, psi, w)``: then ``int |z|^2 <= g int |w|^2`` up to every time, whether 0 attracts or not.  Without
``w`` it is enough that ``V`` falls by some ``|phi|^2``, goes to infinity with ``x``, and no state is hidden.  Where the
form is 0 whatever the unknowns are, its derivative is, too: linear equations, solved in fractions, again and again.
The programme is about what they leave free.  Nothing here is believed: a checker decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from flint import fmpq, fmpq_mat

from lure.analysis.inequality.shifted_loop import ChannelSearch, Proposal, Widths
from lure.analysis.inequality.zero_modes import Exact, Rows, diagonal, exact, floats, fractions, freed, null_rows
from lure.analysis.numerics.doubles import triangle_texts
from lure.analysis.numerics.semidefinite import Block, Limits, proposed, symmetric_basis
from lure.arrays import NDArray, Reals, np
from lure.record import described, quantity

MOST_STATES, MOST_CHANNELS = 12, 6
_SURE, _LARGEST, _DIGITS = 1e-9, 1e6, 12


class Faces(NamedTuple):
    """What is left of a cone of forms where none can be definite: unknowns in a basis, ``P`` first.

    ``forms`` and ``P``: (unknowns, ., .); ``kept``: where they are not 0 whatever the unknowns are.
    """

    basis: fmpq_mat
    forms: Exact
    P: Exact
    kept: tuple[list[int], list[int]]


def faces(forms: Exact, positive: Sequence[bool], A: Rows, wanted: int, *, discrete: bool) -> Faces | None:
    """The unknowns for which a form in ``(x, ..)`` and ``P``, of the first unknowns, may be semidefinite.

    Where one of them is 0 whatever they are, so is its derivative, and unknowns that are not negative are 0 where it
    falls with all that it depends on: linear equations, again and again.

    Parameters
    ----------
    forms : ndarray
        (unknowns, size, size), exact.
    positive : sequence of bool
        Which unknowns are not negative.
    A : sequence of sequence of Fraction
        (n, n); the form is tried where its powers vanish, and along each variable.
    wanted : int
        An unknown that is not to be 0, counted from the end.
    discrete : bool
        Whether in discrete time.

    Returns
    -------
    Faces or None
        None if the unknown that is wanted has to be 0.
    """
    (count, size, _), n = forms.shape, len(A)
    P = np.zeros((count, n, n), dtype=object)
    P[: n * (n + 1) // 2] = symmetric_basis(n).astype(int).astype(object)
    still = exact(A) - diagonal([Fraction(int(discrete))] * n)
    rest = [*null_rows(still).tolist(), *null_rows(still * still).tolist()]
    tried = [[*row, *[fmpq(0)] * (size - n)] for row in rest]
    tried += [[fmpq(i == j) for j in range(size)] for i in range(size)]
    nothing = np.array([[fmpq(0)] * count], dtype=object)
    rows, gone = list[Exact](), (list[Exact](), list[Exact]())
    while True:
        found = freed(np.array(rows, dtype=object) if rows else nothing, positive)
        basis, before = fractions(found.basis), len(rows)
        if not any(basis[-wanted]):
            return None
        owner = [
            any(positive[k] and row[j] > 0 == sum(v != 0 for v in row) - 1 for k, row in enumerate(basis))
            for j in range(basis.shape[1])
        ]
        for M, zeros, width in ((forms, gone[0], size), (P, gone[1], n)):
            seen = list[tuple[Exact, Exact, Exact]]()
            for v in np.array(tried, dtype=object)[:, :width]:
                if any(v) and not any((v == other).all() for other in zeros):
                    flat = M @ v
                    seen.append((v, flat, flat @ v))
            ways = [_scaled((value @ basis).tolist()) for _, _, value in seen]
            for (v, flat, value), way in zip(seen, ways, strict=True):
                falls = all(own and c < 0 for own, c in zip(owner, way, strict=True) if c)
                if falls or tuple(-c for c in way) in ways:  # with another one of the other sign both are 0
                    zeros.append(v)
                    rows += [value, *flat.T]
        if len(rows) == before:
            break
    kept = []
    for zeros, width in zip(gone, (size, n), strict=True):
        reduced, rank = fmpq_mat([list(v) for v in zeros] or [[fmpq(0)] * width]).rref()
        pivots = [next(j for j in range(width) if reduced[i, j] != 0) for i in range(rank)]
        kept.append([j for j in range(width) if j not in pivots])
    return Faces(found.basis, forms, P, (kept[0], kept[1]))


def _scaled(values: Sequence[fmpq]) -> tuple[fmpq, ...]:
    """The same direction, the first entry that is not 0 being 1 or -1."""
    first = next((abs(v) for v in values if v != 0), fmpq(1))
    return tuple(fmpq(v) / first for v in values)


def blocks_of(found: Faces, *, room: bool) -> list[Block]:
    """The form and ``P`` without what is 0, as inequalities in the free unknowns, and with ``room`` in one more.

    ``found``: what is left of the cone; ``room``: whether the last unknown is a margin of both.
    """
    basis, blocks = floats(fractions(found.basis)), list[Block]()
    for M, kept in zip((found.forms, found.P), found.kept, strict=True):
        slopes = np.tensordot(basis.T, floats(M), 1)[:, kept][:, :, kept]
        slopes = np.concatenate([slopes, -np.eye(len(kept))[None]]) if room else slopes
        if kept:
            blocks.append(Block(np.zeros((len(kept),) * 2), slopes))
    return blocks


def everywhere(loop: Sequence[Rows], tops: Sequence[Fraction | None]) -> Iterator[Proposal]:
    """That 0 attracts everything: ``V = x'Px + 2 sum theta_i int phi_i`` falls with ``|phi|^2``, or ``sigma'phi``.

    Or by a form that keeps no ``phi`` at 0, which is for a checker to see.

    ``loop``: ``A``, ``B``, ``C`` and ``D``, exactly, in continuous time; ``tops``: for each channel the largest
    ``phi/sigma``, None without one.
    """
    n, m = len(loop[0]), len(loop[3])
    if n > MOST_STATES or m > MOST_CHANNELS:
        return
    turned = [i for i in range(m) if not any(loop[3][i])]
    places = list(zip(*np.tril_indices(n), strict=True))
    positive = [*(bool(i == j) for i, j in places), *[True] * (m + len(turned) + 1)]
    for falls in ("squares", "products", "integrals"):
        squares = falls != "products"
        inverse = [1 / top if top is not None and squares else Fraction(0) for top in tops]
        forms = _forms_everywhere(loop, inverse, turned, falls=falls)
        found = faces(forms, positive, loop[0], 1, discrete=False)
        free = None if found is None else _widest(found, len(places))
        if found is None or free is None:
            continue
        values = [Fraction(int(v.p), int(v.q)) for v in (found.basis * exact([[v] for v in free])).entries()]
        *rest, least = values[len(places) :]
        theta = [Fraction(0)] * m
        for i, v in zip(turned, rest[m:], strict=True):
            theta[i] = v + (least if falls == "integrals" else 0)
        half = [[str(values[i * (i + 1) // 2 + j]) for j in range(i + 1)] for i in range(n)]
        weights = [str(v + least if falls == "products" else v) for v in rest[:m]]
        stated = {"lambda": weights, "theta": [*map(str, theta)], "inverse": [*map(str, inverse)]}
        own = str(least if falls == "squares" else 0)
        yield Proposal(stated, {"method": "everywhere", "P": half, "least": [own] * m})


def _forms_everywhere(loop: Sequence[Rows], inverse: Sequence[Fraction], turned: Sequence[int], *, falls: str) -> Exact:
    """The form of each unknown: ``P``, ``lambda``, ``theta``, and how much ``V`` falls, or the least ``theta``."""
    A, B, C, D = (fractions(exact(side)) for side in loop)
    n, one = len(A), np.array([[fmpq(i == j) for j in range(sum(B.shape))] for i in range(sum(B.shape))])
    moved, seen, forms = np.hstack([A, -B]), np.hstack([C, -D]), list[Exact]()
    for E in symmetric_basis(n).astype(int).astype(object):
        side = one[:n].T @ E @ moved
        forms.append(-(side + side.T))
    rows = [(i, seen[i] - fmpq(c.numerator, c.denominator) * one[n + i]) for i, c in enumerate(inverse)]
    for i, row in [*rows, *((i, C[i] @ moved) for i in turned)]:
        side = np.outer(row, one[n + i])
        forms.append(-(side + side.T))
    own = [C[i] @ moved if i in turned else 0 * moved[0] for i in range(len(C))] if falls == "integrals" else seen
    last = one[n:].T @ (one[n:] if falls == "squares" else 2 * np.array(own))
    return np.array([*forms, -(last + last.T) / fmpq(2)], dtype=object)


def _widest(found: Faces, order: int) -> list[Fraction] | None:
    """The free unknowns with the largest margin of the forms, and of how much ``V`` falls; the first are of ``P``."""
    basis = floats(fractions(found.basis))
    d, limits = basis.shape[1], Limits(basis.shape[1] + 1)
    for k, row in enumerate(basis):
        terms = {int(j): float(row[j]) for j in np.flatnonzero(row)}
        limits.at_most(terms, 1.0)
        limits.at_most({j: -v for j, v in terms.items()}, 1.0 if k < order else 0.0)
    limits.at_most({int(j): -basis[-1, j] for j in np.flatnonzero(basis[-1])} | {d: 1.0}, 0.0)
    solved = proposed(np.eye(d + 1)[-1], blocks_of(found, room=True), *limits.arrays())
    if solved is None or solved[-1] <= _SURE:
        return None
    return [Fraction(f"{v:.{_DIGITS}g}") for v in solved[:-1]]


@described()
class RestingGain(ChannelSearch):
    """The search for one plant; the others: see :class:`ChannelSearch`."""

    loop: Sequence[Rows] = quantity("``A``, ``B``, ``C`` and ``D`` exactly, shifted by the lower bounds")
    given: Rows = quantity("``C`` as it was given")
    performance: range = quantity("The channels from ``z`` to ``w``, the last")
    free: Sequence[bool] = quantity("Which ``theta`` may differ from 0")
    popov: bool = quantity("Whether a certificate states ``theta``")
    discrete: bool = quantity("Whether in discrete time")

    @cached_property
    def _turned(self) -> list[int]:
        return [i for i in range(self.performance.start) if self.free[i]]

    def _forms(self, widths: Sequence[Fraction]) -> Exact:
        """The form of each unknown, exactly: ``P``, ``lambda``, ``theta``, then that of ``|z|^2`` and of ``|w|^2``."""
        A, B, C, D = (fractions(exact(side)) for side in self.loop)
        n, one = len(A), np.array([[fmpq(i == j) for j in range(sum(B.shape))] for i in range(sum(B.shape))])
        moved, seen, now, forms = np.hstack([A, -B]), np.hstack([C, -D]), one[:n], list[Exact]()
        for E in symmetric_basis(n).astype(int).astype(object):
            side = moved.T @ E @ moved - now.T @ E @ now if self.discrete else now.T @ E @ moved + moved.T @ E @ now
            forms.append(-side)
        for i in range(self.performance.start):
            own, w = one[n + i], fmpq(widths[i].numerator, widths[i].denominator)
            side = np.outer(w * seen[i] - own, own)
            forms.append(-(side + side.T))
        for i in self._turned:
            side = np.outer(C[i] @ moved, one[n + i])
            forms.append(-(side + side.T))
        z, beside = seen[[*self.performance]], one[[n + i for i in self.performance]]
        return np.array([*forms, -(z.T @ z), beside.T @ beside], dtype=object)

    def _cone(self, widths: Sequence[Fraction]) -> Faces | None:
        """What the equations leave free; None if ``z`` sees what nothing holds."""
        forms, n = self._forms(widths), len(self.A)
        positive = [bool(i == j) for i, j in zip(*np.tril_indices(n), strict=True)]
        positive += [True] * (len(forms) - len(positive))
        return faces(forms, positive, self.loop[0], 2, discrete=self.discrete)

    def _programme(self, cone: Faces, g: Fraction | None) -> Reals | None:
        """The least ``g``, the last unknown; or for a given one the unknowns with the largest margin, which is last."""
        basis, n = floats(fractions(cone.basis)), len(self.A)
        count, d = basis.shape
        room, limits = g is not None, Limits(d + (g is not None))
        for k in range(n * (n + 1) // 2, count - 2):
            limits.at_most({int(j): -basis[k, j] for j in np.flatnonzero(basis[k])}, 0.0)
        limits.at_most({d - 2: 1.0}, 1.0)
        limits.at_most({d - 2: -1.0}, -1.0)
        for j in range(d - 2):
            limits.at_most({j: 1.0}, _LARGEST)
            limits.at_most({j: -1.0}, _LARGEST)
        if g is None:
            return proposed(-np.eye(d)[-1], blocks_of(cone, room=room), *limits.arrays())
        limits.at_most({d - 1: 1.0}, float(g))
        limits.at_most({d: 1.0}, 1.0)
        return proposed(np.eye(d + 1)[-1], blocks_of(cone, room=room), *limits.arrays())

    @property
    def possible(self) -> bool:
        """Whether there are unknowns to search for, and few enough."""
        return len(self.A) <= MOST_STATES and len(self.D) <= MOST_CHANNELS

    def serves(self, widths: NDArray[np.float64]) -> bool:
        """Whether the programme has a solution."""
        return self._least(widths) * float(widths[-1]) ** 2 <= 1

    def largest(self, widths: Widths, start: float, most: float) -> float:
        """The factor of the least gain; see :class:`ChannelSearch`."""
        unit = float(widths(1.0)[-1])
        least = self._least(widths(1.0))
        return 0.0 if not 0 < least < np.inf else min(least**-0.5 / unit, most)

    def _least(self, widths: NDArray[np.float64]) -> float:
        cone = self._cone([Fraction(float(w)) for w in widths])
        found = None if cone is None else self._programme(cone, None)
        return np.inf if found is None or found[-1] <= 0 else float(found[-1])

    def proposals(self, widths: Sequence[Fraction], lower: Sequence[Fraction]) -> Iterator[Proposal]:
        """The solution of the programme, rounded where the equations leave it free."""
        cone, g = self._cone(widths), 1 / widths[-1] ** 2
        found = None if cone is None else self._programme(cone, g)
        if cone is None or found is None or found[-1] <= _SURE:
            return
        (n, m), own, columns = (len(self.A), len(self.D)), self.performance, cone.basis.ncols()
        free = [[Fraction(f"{v:.{_DIGITS}g}")] for v in found[: columns - 2]] + [[Fraction(1)], [g]]
        values = [Fraction(int(v.p), int(v.q)) for v in (cone.basis * exact(free)).entries()]
        P = [[Fraction(0)] * n for _ in range(n)]
        for (i, j), v in zip(zip(*np.tril_indices(n), strict=True), values, strict=False):
            P[i][j] = P[j][i] = v
        rest = values[n * (n + 1) // 2 :]
        weights = rest[: own.start] + [g / 2] * len(own)
        theta = [Fraction(0)] * m
        for k, v in zip(self._turned, rest[own.start :], strict=False):
            theta[k] = v
        C = exact(self.given)
        whole = exact(P) - C.transpose() * diagonal([t * low for t, low in zip(theta, lower, strict=True)]) * C
        entries, factor = whole.numer_denom()
        stated = {"lambda": [str(int(factor) * v) for v in weights]}
        stated |= {"theta": [str(int(factor) * v) for v in theta]} if self.popov else {}
        rows = triangle_texts(entries.tolist())
        yield Proposal(stated, {"method": "matrix", "P": rows, "exponent": 0, "semidefinite": True})

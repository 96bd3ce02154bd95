"""Periodic orbits of discrete-time loops: the smallest slope, or sector, that admits one of a short period."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from flint import fmpq, fmpq_mat

from lure.analysis.counterexamples.linear import linear_witness, refutes_lower
from lure.analysis.counterexamples.matrix_game import (
    EXHAUSTIVE,
    Family,
    all_patterns,
    basis,
    neighbours,
    pattern_count,
    sinusoids,
    solve_games,
)
from lure.analysis.counterexamples.orbit import PiecewiseLinear, orbit_witness, shifted_block, steady_state_map
from lure.analysis.inequality.gains import is_stable_gain
from lure.analysis.numerics.polynomial import to_fmpq, to_fraction
from lure.analysis.verdict import Witness
from lure.arrays import NDArray, Reals, np, optimize
from lure.errors import InputError
from lure.plants.rational import RationalPlant
from lure.record import described, quantity

# From a periodic orbit in floating point to one in rationals, checked exactly.


_LARGEST_EXACT = 12  # rows of a matrix whose characteristic polynomial is factored


@described(frozen=True, slots=True)
class Proposal:
    """An orbit in floating point: ``w = V d`` with ``V`` the basis of the pattern of ``values``."""

    reach: float = quantity("``1/k`` of the loop shifted to the lower bound zero")
    q: int = quantity("``w[t + q] = twist * w[t]``")
    twist: int
    family: Family = quantity("Which pattern of ``values`` is kept")
    values: Reals = quantity("(q,)")
    mixture: Reals = quantity("(q,)")


def exact_orbit(block: RationalPlant, lower: Fraction, proposal: Proposal, *, odd: bool = False) -> Witness | None:
    """The witness of a proposal: at its own ``k`` if that is rational, else at the next ``k`` above that can be proved.

    ``block``: the block before the shift; ``lower``: the lower bound; ``proposal``: found for the shifted block ``n /
    (d + lower n)``; ``odd``: whether the nonlinearity of a ``sector`` pattern has to be odd.

    Returns
    -------
    Witness or None
        None if no rational orbit nearby passes the exact check.
    """
    response = steady_state_map(shifted_block(block, lower), proposal.q, twist=proposal.twist)
    if response is None:
        return None
    V = fmpq_mat([[int(v) for v in row] for row in basis(proposal.values[None], proposal.family)[0]])
    A = V.solve(response * V) * fmpq(-1)
    for d in _candidates(A, proposal):
        w = V * d
        witness = _witness(block, lower, proposal, (w, response * w * fmpq(-1)), odd=odd)
        if witness is not None:
            return witness
    return None


def _witness(
    block: RationalPlant, lower: Fraction, proposal: Proposal, orbit: tuple[fmpq_mat, fmpq_mat], *, odd: bool
) -> Witness | None:
    w, sigma = ([to_fraction(side[i, 0]) for i in range(proposal.q)] for side in orbit)
    if proposal.twist == -1:
        w, sigma = ([*side, *(-value for value in side)] for side in (w, sigma))
    full = [value + lower * s for value, s in zip(w, sigma, strict=True)]
    try:
        nonlinearity = PiecewiseLinear.through(
            zip(sigma, full, strict=True), lower, odd=odd or proposal.family == "odd"
        )
        u = [-value for value in full]
        return orbit_witness(block, nonlinearity, u, sigma, slope_restricted=proposal.family != "sector")
    except InputError:
        return None


def _candidates(A: fmpq_mat, proposal: Proposal) -> list[fmpq_mat]:
    """Steps ``d`` with ``A d >= reach d`` exactly: an eigenvector of the steps in use, then interior points."""
    found = []
    vertex = _vertex(A, proposal)
    if vertex is not None:
        found.append(vertex)
    size = proposal.q
    numbers = np.array([[float(to_fraction(A[i, j])) for j in range(size)] for i in range(size)])
    for give in (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5):
        reach = Fraction(proposal.reach * (1 - give))
        solved = solve_games((numbers - float(reach) * np.eye(size))[None])
        if not solved.value[0] > 0:
            continue
        for bits in range(10, 64, 6):
            d = fmpq_mat([[fmpq(round(value * 2**bits), 2**bits)] for value in solved.mixture[0]])
            slack = A * d - d * to_fmpq(reach)
            if any(d[i, 0] > 0 for i in range(size)) and all(slack[i, 0] >= 0 for i in range(size)):
                found.append(d)
                break
    return found


def _vertex(A: fmpq_mat, proposal: Proposal) -> fmpq_mat | None:
    """The exact solution of ``(A d)_i = reach d_i`` on the rows in use, if its eigenvalue is rational."""
    size = proposal.q
    used = [i for i in range(size) if proposal.mixture[i] > 1e-9]
    if len(used) > _LARGEST_EXACT:
        return None
    block = fmpq_mat([[A[i, j] for j in used] for i in used])
    _, factors = block.charpoly().numer().factor()
    roots = [Fraction(-int(f[0]), int(f[1])) for f, _ in factors if f.degree() == 1]
    near = [root for root in roots if abs(float(root) / proposal.reach - 1) < 1e-7]
    if not near:
        return None
    vector = _null_vector(block, to_fmpq(near[0]))
    if vector is None:
        return None
    d = fmpq_mat(size, 1)
    for i, value in zip(used, vector, strict=True):
        d[i, 0] = value
    image = A * d
    fits = all(value > 0 for value in vector) and all(image[i, 0] >= 0 for i in range(size) if i not in used)
    return d if fits else None


def _null_vector(matrix: fmpq_mat, eigenvalue: fmpq) -> list[fmpq] | None:
    """The eigenvector of last entry 1, if the eigenvalue is simple and that entry is not zero."""
    n = matrix.nrows()
    reduced, rank = fmpq_mat(
        [[matrix[i, j] - (eigenvalue if i == j else 0) for j in range(n)] for i in range(n)]
    ).rref()
    if rank != n - 1 or any(reduced[i, i] != 1 for i in range(n - 1)):
        return None
    return [-reduced[i, n - 1] for i in range(n - 1)] + [fmpq(1)]


PERIODS = range(1, 29)
SECTOR_PERIODS = range(1, 25)
_GAIN = 1e-9  # relative: a smaller improvement is none
_CLIMBS = 30
_RISES = 60  # of the floor of one batch: near the best reach they may become ever smaller
_BATCH = 20_000


@dataclass(frozen=True, slots=True)
class _Room:
    """Where one kind of orbit is looked for: ``w = -u`` with ``w[t + q] = twist w[t]``."""

    response: Reals
    harmonics: NDArray[np.complex128]
    q: int
    twist: int
    family: Family

    def excluded(self, reach: float) -> bool:
        """Whether some multiplier shows that no such orbit has ``1/k >= reach`` (in floating point: to save time).

        Values ordered alike satisfy ``sum_t w[t] tau[t + j] <= sum_t w[t] tau[t]`` for every ``j``, for odd
        nonlinearities with either sign on the left.  With ``tau = -(G + 1/k) w`` none exist if ``Re[(1 - sum h_j z^-j)
        (H + 1/k)] > 0`` at all harmonics ``z`` for some ``sum |h_j| <= 1``, ``h >= 0`` unless odd; nonlinearities in a
        sector leave only ``h = 0``.
        """
        shifted = self.harmonics + reach
        if self.family == "sector" or self.q == 1:
            return bool(shifted.real.min() > 0)
        roots = _roots(self.q, self.twist)
        delayed = (roots[:, None] ** -np.arange(1, self.q)[None, :] * shifted[:, None]).real
        columns = np.hstack([delayed, -delayed]) if self.family == "odd" else delayed
        count = columns.shape[1]
        found = optimize.linprog(
            np.r_[np.zeros(count), -1],
            A_ub=np.vstack([np.hstack([columns, np.ones((self.q, 1))]), np.r_[np.ones(count), 0]]),
            b_ub=np.r_[shifted.real, 1],
            bounds=[(0, None)] * count + [(None, None)],
        )
        return bool(found.status == 0 and -found.fun > 1e-10 * np.abs(shifted).max())


def periodic_witness_discrete(
    block: RationalPlant, *, odd: bool, lower: Fraction = Fraction(0), periods: Iterable[int] = PERIODS
) -> Witness | None:
    r"""A monotone nonlinearity with slope in ``[lower, k]`` and a periodic orbit, for the smallest ``k`` found.

    An orbit ``sigma = G_p u`` of period ``p`` belongs to such a nonlinearity exactly if ``w = -u`` and ``sigma - w/k``
    are ordered alike, zero included (``lower = 0``; else the loop is shifted).  For one order ``w = V d``, ``d >= 0``
    are the steps between neighbours, and the condition reads ``A d >= d/k`` with ``A = -V^-1 G_p V``: the largest
    ``1/k`` is found from the values of matrix games.  All orders are tried for periods up to 8 (of odd nonlinearities
    7, or 14 if mirrored), the orders of sinusoids and what an ascent from them reaches for the others.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    odd : bool
        Whether the nonlinearity has to be odd.  If not, odd nonlinearities are looked for as well.
    lower : Fraction
        Lower bound of the slope.
    periods : iterable of int
        Periods tried.

    Returns
    -------
    Witness or None
        CERTIFIED, of ``k`` below the smallest destabilising linear gain.  None: nothing was found, which shows nothing.

    Raises
    ------
    InputError
        The block is in continuous time or a period is not positive.

    Notes
    -----
    The search is in floating point; the orbit is then made exact and checked by
    :func:`~lure.analysis.counterexamples.orbit.verify_periodic_discrete`.  With a simple pole at 1 (the critical
    case) the orbit
    is looked for in ``[e, k]`` with a small ``e > 0``, inside the class ``(0, k]``.  Orbits from phases of sinusoids:
    P. Seiler, J. Carrasco, IEEE Control Systems Letters 5 (2021) 1291-1296.
    """
    families: tuple[Family, ...] = ("odd",) if odd else ("monotone", "odd")
    return _search(block, families, Fraction(lower), periods)


def sector_witness_discrete(
    block: RationalPlant, *, odd: bool = False, lower: Fraction = Fraction(0), periods: Iterable[int] = SECTOR_PERIODS
) -> Witness | None:
    r"""A time-invariant nonlinearity in the sector ``[lower, k]`` with a periodic orbit, for the smallest ``k`` found.

    As :func:`periodic_witness_discrete`, but only the signs of ``w`` and of ``sigma - w/k`` have to agree, and equal
    ``sigma`` have equal ``w``; the slopes of the nonlinearity are not restricted.

    Parameters
    ----------
    block : RationalPlant
        In discrete time.
    odd : bool
        Whether the nonlinearity has to be odd.
    lower : Fraction
        Lower bound of the sector.
    periods : iterable of int
        Periods tried.

    Returns
    -------
    Witness or None
        CERTIFIED, of ``k`` below the smallest destabilising linear gain; None if nothing was found.

    Raises
    ------
    InputError
        The block is in continuous time or a period is not positive.
    """
    return _search(block, ("sector",), Fraction(lower), periods, odd=odd)


def _search(
    block: RationalPlant, families: tuple[Family, ...], lower: Fraction, periods: Iterable[int], *, odd: bool = False
) -> Witness | None:
    """The exact orbit of smallest ``k`` among the proposals that can be made exact."""
    if block.dt is None:
        raise InputError("orbits of difference equations need a block in discrete time; give dt")
    linear = linear_witness(block, lower=lower)
    if block.order == 0 or refutes_lower(linear):
        return None
    start = searched_lower(block, lower, linear)
    top = np.inf if linear is None else linear.k
    for proposal in proposals(shifted_block(block, start), families, top - float(start), tuple(periods)):
        witness = exact_orbit(block, start, proposal, odd=odd)
        if witness is not None:
            return witness
    return None


def searched_lower(block: RationalPlant, lower: Fraction, linear: Witness | None) -> Fraction:
    """The lower bound, or a gain just above it if the loop is only marginal there (and ``linear`` lies above it)."""
    if is_stable_gain(block, lower):
        return lower
    width = linear.k - float(lower) if linear is not None else 1 / max(abs(complex(block.transfer(-1.0))), 1e-9)
    return lower + Fraction(2) ** (math.floor(math.log2(width)) - 20)


@lru_cache(maxsize=64)
def proposals(
    block: RationalPlant, families: tuple[Family, ...], width: float, periods: tuple[int, ...]
) -> tuple[Proposal, ...]:
    """Orbits for the lower bound zero, of ``k`` below ``width``, smallest ``k`` first; in floating point.

    Those of the family ``sector`` belong to a nonlinearity that may vary with time.

    Raises
    ------
    InputError
        A period is not positive.
    """
    wanted = sorted(set(periods))
    if wanted and wanted[0] < 1:
        raise InputError(f"periods contains {wanted[0]}; give positive numbers of samples")
    found: list[Proposal] = []
    for p in wanted:
        for room in _rooms(block, families, p):
            floor = found[-1].reach if found else max(1 / width, 1e-7 * np.abs(room.response).max())
            floor *= 1 + _GAIN
            better = None if room.excluded(floor) else _best_pattern(room, floor)
            found += [] if better is None else [better]
    return tuple(found[::-1])


def _rooms(block: RationalPlant, families: tuple[Family, ...], p: int) -> list[_Room]:
    """The kinds of orbit of period ``p``: any, and for odd nonlinearities those whose second half mirrors the first."""
    kinds: list[tuple[int, int, Family]] = []
    for family in families:
        if family != "monotone" and p % 2 == 0:
            kinds.append((p // 2, -1, family))
        if not (family == "odd" and "monotone" in families):
            kinds.append((p, 1, family))
    found = []
    for q, twist, family in kinds:
        with np.errstate(invalid="ignore"):
            harmonics = np.asarray(block.transfer(_roots(q, twist)))
        if np.isfinite(harmonics).all():
            wave = _roots(q, twist)[None, :] ** np.arange(q)[:, None]
            response = ((wave * harmonics) @ wave.conj().T).real / q
            found.append(_Room(response, harmonics, q, twist, family))
    return found


def _roots(q: int, twist: int) -> NDArray[np.complex128]:
    """The ``z`` with ``z^q = twist``."""
    return np.asarray(np.exp(1j * (2 * np.pi * np.arange(q) + (0 if twist == 1 else np.pi)) / q), dtype=np.complex128)


def _best_pattern(room: _Room, floor: float) -> Proposal | None:
    """The pattern of largest ``1/k`` above the floor."""
    if pattern_count(room.q, room.family) * room.q**2 <= EXHAUSTIVE:
        return _reach(room, all_patterns(room.q, room.family), floor)
    angles = []
    for turns in np.arange(room.q // 2 + 1) + (0.5 if room.twist == -1 else 0.0):
        t = np.arange(room.q)
        wave = np.exp(2j * np.pi * turns * t / room.q)
        angles.append((abs(np.angle(-(room.response[0] @ wave.conj()).conj() - floor)), turns))
    best: Proposal | None = None
    for _, turns in sorted(angles)[:2]:
        seeds = sinusoids(room.q, turns, room.family)
        found = _climb(room, seeds, floor if best is None else best.reach * (1 + _GAIN))
        best = best if found is None else found
    return best


def _climb(room: _Room, seeds: Reals, floor: float) -> Proposal | None:
    """Steepest ascent of the game's value over neighbouring patterns, from the best seed; the floor rises with it."""
    best: Proposal | None = None
    current, held = seeds, -np.inf
    for _ in range(_CLIMBS):
        value = solve_games(_matrices(room, current, floor)).value
        place = int(np.nanargmax(value)) if np.isfinite(value).any() else 0
        if not value[place] > held:
            break
        start, held = current[place], float(value[place])
        if held > 0:
            found = _reach(room, start[None], floor)
            if found is not None:
                best, floor, held = found, found.reach * (1 + _GAIN), -_GAIN * found.reach
        current = neighbours(start, room.family)
    return best


def _matrices(room: _Room, values: Reals, reach: float) -> Reals:
    V = basis(values, room.family)
    return np.asarray(np.rint(np.linalg.inv(V)) @ (-room.response - reach * np.eye(room.q)) @ V)


def _reach(room: _Room, values: Reals, floor: float) -> Proposal | None:
    """The largest ``1/k`` above the floor over these patterns.

    A game of positive value at ``1/k`` has a mixture with ``A d >= (1/k + gain) d``: the best of them raises the
    floor for all, and only the games of positive value at the new floor stay.  After ``_RISES`` the reach found so far
    is taken: any above the floor is one of an orbit.
    """
    best: Proposal | None = None
    for start in range(0, len(values), _BATCH):
        alive = values[start : start + _BATCH]
        for _ in range(_RISES):
            games = _matrices(room, alive, floor)
            solved = solve_games(games)
            keep = solved.value > 1e-12 * np.abs(games).max()
            alive, games, mixtures = alive[keep], games[keep], solved.mixture[keep]
            if not len(alive):
                break
            image = np.einsum("bij,bj->bi", games, mixtures)
            used = mixtures > 1e-9
            gain = np.where(used, image / np.where(used, mixtures, 1.0), np.inf).min(axis=1)
            place = int(gain.argmax())
            if gain[place] <= 0:  # of positive value by rounding alone
                break
            best = Proposal(floor + float(gain[place]), room.q, room.twist, room.family, alive[place], mixtures[place])
            floor = best.reach * (1 + _GAIN)
    return best

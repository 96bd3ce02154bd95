r"""Harmonic balance over all graphs of a class: the nonlinearity of least factor for given waves is a linear programme.

Where ``sigma`` is given, the harmonics of ``phi(sigma)`` are linear in the slopes of ``phi``, one for each short piece
of its range, from ``l_i`` to ``alpha u_i``.  So the least ``alpha`` with ``c_h + H(i h omega) f_h = 0`` is found
without a guess of where the kinks are; what is missed is paid for.  Then waves and frequency move a little together
with the slopes, by linear programmes within a region of trust.  At the end nearly all slopes are at their bounds: a
staircase, of which :mod:`.balance` makes a solution.  Proposals, never proofs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from lure.analysis.counterexamples.balance import Side, Wave
from lure.analysis.deadline import checkpoint
from lure.arrays import Reals, np, optimize

if TYPE_CHECKING:
    from lure.analysis.counterexamples.balance import Balance

PIECES = 32  # to each side of 0
_ROUNDS, _TRUST, _LEAST, _PRICE, _MOST_KINKS = 40, 0.05, 1e-4, 12.0, 5
_POSED = 0.05
_SEED, _DRAWN, _BEST, _DETUNED = 3, 100, 3, (0.05, 0.25)


class Shaped(NamedTuple):
    """Waves with the slopes of the nonlinearities above their lower bounds, piece by piece, and what both cost.

    Of sectors the values above those of the lower bounds, point by point.
    """

    cost: float
    wave: Wave
    slopes: Reals


def shaped(balance: Balance, top: float) -> Iterator[Wave]:
    """Waves with two harmonics near resonances, and the graphs of least factor for them, both improved together.

    ``balance``: of a plant with two resonances or more; of others there are none.  ``top``: the largest factor of
    interest.
    """
    starts = [start for wave in _drawn(balance) if (start := best_graphs(balance, wave, _PRICE * top)) is not None]
    for start in sorted(starts, key=lambda one: one.cost)[:_BEST]:
        found = _improved(balance, start).wave
        if all(len(side.kinks) <= _MOST_KINKS for pair in found.sides for side in pair):
            yield found


def pointed(balance: Balance, top: float, count: int) -> Iterator[tuple[Wave, list[tuple[float, float]]]]:
    """Half waves as above, and the odd graph of least factor in a sector: its points, with the share of the sector.

    Parameters
    ----------
    balance : Balance
        Of one odd nonlinearity, and a plant with two resonances; of others there are none.
    top : float
        The largest factor of interest.
    count : int
        How many points to each side of 0.
    """
    poles = np.linalg.eigvals(balance.A)
    waves = _drawn(balance) if (poles.imag > np.abs(poles.real)).sum() > 1 else ()
    starts = [best_graphs(balance, wave, _PRICE * top, points=count) for wave in waves]
    known = sorted((start for start in starts if start is not None), key=lambda one: one.cost)
    found = [_improved(balance, start, count) for start in known[: 2 * _BEST]]
    for one in sorted(found, key=lambda one: one.cost):
        points = _Points(balance, one.wave, count)
        room = one.wave.alpha * points.upper - points.lower
        yield one.wave, [*zip(points.at, (one.slopes / np.maximum(room, 1e-300)).clip(0.0, 1.0).tolist(), strict=True)]


def _drawn(balance: Balance) -> Iterator[Wave]:
    """The fundamental near one resonance, another harmonic near the next, in any phase."""
    rng, m = np.random.default_rng(_SEED), len(balance.D)
    low, *others = (h for h in balance.harmonics if h)
    for _ in range(_DRAWN if len(balance.turning) > 1 else 0):
        first, second = np.sort(rng.choice(balance.turning, 2, replace=False))
        omega = float(first / low * math.exp(rng.choice(_DETUNED) * rng.normal()))
        nearest = second / omega + rng.normal()
        high = min(others, key=lambda h: abs(h - nearest))
        waves = np.zeros((m, len(balance.harmonics)), dtype=complex)
        for h, size in ((low, 1.0), (high, math.exp(rng.uniform(-3, 0.4)))):
            waves[:, balance.harmonics.index(h)] = size * np.exp(2j * math.pi * rng.random(m))
        yield Wave(1.0, omega, waves / np.linalg.norm(waves), ())


class _Pieces:
    """The graphs cut into short pieces, and what each adds to ``phi(sigma)`` with the slope 1."""

    def __init__(self, balance: Balance, wave: Wave) -> None:
        sigma, added, steep, owners = balance.sampled(wave), list[Reals](), list[Reals](), list[int]()
        for odd, block in zip(balance.odd, balance.blocks, strict=True):
            rows = sigma[[*block]]
            width = float(np.abs(rows).max()) / PIECES
            for way in (0.0,) if odd else (1.0, -1.0):
                size, sign = (np.maximum(way * rows, 0.0), way) if way else (np.abs(rows), np.sign(rows))
                for piece in range(PIECES):
                    within = np.clip(size - piece * width, 0.0, width)
                    for found, part in ((added, sign * within), (steep, (within > 0) & (within < width))):
                        found.append(np.zeros_like(sigma))
                        found[-1][[*block]] = part
                    owners.append(block[0])
        self.sigma, self.added, self.steep = sigma, np.array(added), np.array(steep)
        self.lower, self.upper = balance.lower[owners], balance.upper[owners]
        self.bottom = balance.lower[:, None]

    def well_posed(self, _balance: Balance) -> tuple[Reals, Reals]:
        """No condition: the bounds of the slopes are those of the class."""
        return np.zeros((0, len(self.lower))), np.zeros(0)


class _Points:
    """Points of odd graphs, and what the value 1 at each alone adds to ``phi(sigma)``."""

    def __init__(self, balance: Balance, wave: Wave, count: int) -> None:
        self.sigma, added, steep, owners, at = (
            balance.sampled(wave),
            list[Reals](),
            list[Reals](),
            list[int](),
            list[float](),
        )
        for block in balance.blocks:
            rows = self.sigma[[*block]]
            width = float(np.abs(rows).max()) / count
            for x in (width * (i + 1) for i in range(count)):
                off = (np.abs(rows) - x) / width
                here = np.abs(off) < 1
                for found, part in ((added, np.sign(rows) * (1 - np.abs(off))), (steep, -np.sign(off) / width)):
                    found.append(np.zeros_like(self.sigma))
                    found[-1][[*block]] = here * part
                owners.append(block[0])
                at.append(x)
        self.added, self.steep, self.at = np.array(added), np.array(steep), at
        self.lower, self.upper = (np.array(at) * side[owners] for side in (balance.lower, balance.upper))
        self.bottom = balance.lower[:, None]

    def well_posed(self, balance: Balance) -> tuple[Reals, Reals]:
        """``M v <= r``: with these values ``1 + D slope`` keeps a share of what the lower bound has, of one channel."""
        d, low = float(balance.D[0, 0]), float(balance.lower[0])
        steps = np.eye(len(self.at)) - np.eye(len(self.at), k=-1)
        kept = (1 - _POSED) * (1 + d * low) * self.at[0]
        return (-d * steps, np.full(len(self.at), kept)) if d else (steps[:0], np.zeros(0))


def best_graphs(
    balance: Balance, wave: Wave, price: float, near: tuple[Reals, float] | None = None, points: int = 0
) -> Shaped | None:
    """The graphs of least factor for given waves, and what they cost.

    Parameters
    ----------
    balance : Balance
        The loop.
    wave : Wave
        Of which only frequency and waves count.
    price : float
        Of a unit of what the balance misses, beside the factor.
    near : (ndarray, float), optional
        Slopes and a trust: then waves and frequency move with the slopes, by that share at most, to first order.
    points : int
        0 for bounds of the slopes; else how many points the graphs have on each side, in sectors, all odd.

    Returns
    -------
    Shaped or None
        None where the programme has no solution.
    """
    pieces = _Points(balance, wave, points) if points else _Pieces(balance, wave)
    m, count = wave.waves.shape
    slopes, trust = (np.zeros(len(pieces.lower)), 0.0) if near is None else near
    value = pieces.bottom * pieces.sigma + np.einsum("k,kiq->iq", slopes, pieces.added)
    slope = pieces.bottom + np.einsum("k,kiq->iq", slopes, pieces.steep)
    missed, moved = balance.linearised(wave, value, slope)
    H = balance.response(wave.omega)[0]
    by_slope = np.einsum("hij,kjh->ihk", H, pieces.added @ balance.analysis.T).reshape(m * count, -1)
    wanted = by_slope @ slopes - missed.ravel()
    n, steps, rows = len(slopes), (moved.shape[1] if near is not None else 0), 2 * m * count
    flat = np.stack([wave.waves.real, wave.waves.imag], axis=2)
    still = np.zeros((2, n + steps + 1 + 2 * rows))  # neither larger nor later
    still[:, n : n + flat.size] = [flat.ravel(), balance.later(wave)] if steps else 0.0
    parts = np.concatenate([by_slope, moved[:, :steps]], axis=1)
    equal = np.hstack([np.vstack([parts.real, parts.imag]), np.zeros((rows, 1)), np.eye(rows), -np.eye(rows)])
    sizes = np.repeat(np.maximum(np.linalg.norm(flat, axis=2), 0.02).ravel(), 2)
    reach = trust * np.append(sizes, 0.1)[:steps]
    free = [(0.0, None)] * (1 + 2 * rows)
    most = np.hstack([np.eye(n), np.zeros((n, steps)), -pieces.upper[:, None], np.zeros((n, 2 * rows))])
    posed, rest = pieces.well_posed(balance)
    found = optimize.linprog(
        np.concatenate([np.zeros(n + steps), [1.0], np.full(2 * rows, price)]),
        A_ub=np.vstack([most, np.pad(posed, ((0, 0), (0, steps + 1 + 2 * rows)))]),
        b_ub=np.concatenate([-pieces.lower, rest]),
        A_eq=np.vstack([equal, still]),
        b_eq=np.concatenate([wanted.real, wanted.imag, [0.0, 0.0]]),
        bounds=[(0.0, None)] * n + [(-size, size) for size in reach] + free,
        method="highs",
    )
    if found.status:
        return None
    step, alpha = found.x[n : n + steps], float(found.x[n + steps])
    if steps:
        change = step[:-1].reshape(flat.shape)
        waves = wave.waves + change[..., 0] + 1j * change[..., 1]
        wave = wave._replace(omega=wave.omega * math.exp(step[-1]), waves=waves / np.linalg.norm(waves))
    shares = found.x[:n] / np.maximum(alpha * pieces.upper - pieces.lower, 1e-300)
    sides = () if points else _staircases(balance, wave, shares)
    return Shaped(float(found.fun), wave._replace(alpha=alpha, sides=sides), found.x[:n])


def _improved(balance: Balance, start: Shaped, points: int = 0) -> Shaped:
    """Waves and graphs moved together, as long as the graphs that are best for the new waves are better."""
    trust = _TRUST
    price = _PRICE * max(start.wave.alpha, start.cost / 100)
    best = best_graphs(balance, start.wave, price, points=points) or start
    for _ in range(_ROUNDS):
        checkpoint()
        moved = best_graphs(balance, best.wave, price, (best.slopes, trust), points)
        found = None if moved is None else best_graphs(balance, moved.wave, price, points=points)
        if found is not None and found.cost < best.cost * (1 - 1e-7):
            best, trust = found, min(1.3 * trust, 4 * _TRUST)
        elif trust < _LEAST:
            break
        else:
            trust /= 2
    return best


def _staircases(balance: Balance, wave: Wave, shares: Reals) -> tuple[tuple[Side, Side], ...]:
    """The slopes, rounded to their bounds, as staircases."""
    sigma, sides, at = balance.sampled(wave), list[tuple[Side, Side]](), 0
    for odd, block in zip(balance.odd, balance.blocks, strict=True):
        width, pair = float(np.abs(sigma[[*block]]).max()) / PIECES, list[Side]()
        for _ in (1,) if odd else (1, -1):
            steep = shares[at : at + PIECES] > 0.5
            kinks = np.flatnonzero(steep[1:] != steep[:-1]) + 1
            pair.append(Side(bool(steep[0]), np.asarray(width * kinks, dtype=float)))
            at += PIECES
        sides.append((pair[0], pair[-1]))
    return tuple(sides)

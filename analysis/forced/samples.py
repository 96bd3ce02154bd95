r"""A loop in discrete time with a sampled sine: how far its steady solution is from a balance of harmonics, in balls.

With ``theta = omega dt`` the input is ``w_t = W(theta t)``, and where differences of solutions decay the steady
solution is ``X(theta t)`` with one continuous ``X`` on the circle, ``X(p + theta)`` being what the loop makes of
``X(p)`` and ``W(p)``.  As ``theta`` is rational and not 0 the phases ``theta t`` are dense on the circle, so that the
largest sample is the largest value of ``z`` over all phases.

Harmonics are responses at ``e^(i k theta)``, which do not fall with ``k``: a mean over the phases bounds no sample, and
what harmonics miss, ``e(p)``, is followed sample by sample instead:

.. math:: V(x_+) \le \rho^2 V(x) + \sum_i \beta_i e_i^2, \qquad V(x - \hat x) \le
    \max_p \sum_{j \ge 1} \rho^{2 (j - 1)} \sum_i \beta_i\, e_i(p - j \theta)^2,

for all ``|psi_i(sigma) - psi_i(\hat\sigma)| <= kappa_i |sigma_i - \hat\sigma_i|``, by one matrix inequality.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from flint import arb, arb_mat, fmpq, fmpq_mat

from lure.analysis.deadline import checkpoint
from lure.analysis.forced.balance import PEAK, Balanced, Wave, balanced, sampled
from lure.analysis.forced.band import BITS, Band, Residual, above, around, peak, residual
from lure.analysis.forced.loop import ForcedLoop
from lure.analysis.numerics.polynomial import to_fmpq
from lure.analysis.numerics.precision import ball, working_precision
from lure.analysis.numerics.semidefinite import Block, proposed, symmetric_basis
from lure.arrays import Complexes, Reals, linalg, np
from lure.record import described, quantity

_SHARES, _MARGIN, _DIGITS = (0.3, 0.6, 0.85), 1e-7, 12
_COUNTS, _CLOSE = (16, 64, 256), 2e-5
_ROUNDS, _ENOUGH, _SLOWLY = 4000, 1e-13, 0.999
_TAIL, _MOST_STEPS, _OFF, _ROUNDED, _EACH = 1e-6, 4096, 1e-3, 1e-9, 16


@described(frozen=True)
class Falling:
    """A function ``V = x'P x`` of the difference of two states: ``V(x+) <= rho2 V(x) + sum_i pushes_i e_i^2``."""

    P: fmpq_mat = quantity("Exactly")
    rho2: Fraction = quantity("Below 1")
    pushes: tuple[Fraction, ...] = quantity("``beta``, what is added to ``mu_i`` being off by ``e_i``")


def falling(loop: ForcedLoop, factor: float) -> Falling | None:
    """A function that falls along differences of solutions, checked in exact arithmetic; None where none is found.

    ``loop``: the loop, in discrete time.  ``factor``: a contraction factor per sample that is proved; others are tried
    between it and 1.

    Notes
    -----
    Of the functions with ``|C x|^2 <= V``, by a semidefinite programme, one about which ``sum_i beta_i/(1 - rho^2)`` is
    least.
    """
    best: tuple[float, Falling] | None = None
    for share in _SHARES:
        checkpoint()
        rho2 = Fraction(f"{factor**2 + share * (1 - factor**2):.9g}")
        found = _proposal(loop, float(rho2))
        shown = None if found is None else _checked(loop, rho2, *found)
        if shown is not None and (best is None or _size(shown) < best[0]):
            best = _size(shown), shown
    return None if best is None else best[1]


def _size(found: Falling) -> float:
    return float(sum(found.pushes) / (1 - found.rho2))


def _proposal(loop: ForcedLoop, rho2: float) -> tuple[Reals, Reals, Reals] | None:
    """``P``, the weights of the channels and ``beta`` in floating point."""
    A, B, C, D, *_ = loop.doubles
    n, m = loop.order, loop.channels
    units = linalg.matrix_balance(A, permute=False, separate=True)[1][0]
    A, B, C = A * units / units[:, None], B / units[:, None], C * units
    size = np.linalg.norm(C, axis=1, keepdims=True).max() or 1.0
    kappa, basis = np.array([float(v) for v in loop.spread]), symmetric_basis(n)
    wide, x = n + 2 * m, np.eye(n, n + 2 * m)
    moved, seen = np.hstack([A, B, -B]), np.hstack([C, D, -D])[:m]
    count = len(basis) + 2 * m
    slopes = np.zeros((count, wide, wide))
    for k, e in enumerate(basis):
        slopes[k] = rho2 * x.T @ e @ x - moved.T @ e @ moved
    for i in range(m):
        push, off = np.zeros((wide, wide)), np.zeros((wide, wide))
        push[n + i, n + i], off[n + m + i, n + m + i] = 1, 1
        slopes[len(basis) + i] = push - kappa[i] ** 2 * np.outer(seen[i], seen[i])
        slopes[len(basis) + m + i] = off
    scale = float(np.linalg.norm(B, 2) * np.linalg.norm(C, 2)) ** 2 or 1.0
    slopes[len(basis) + m :] *= scale
    tall = np.zeros((count, n, n))
    tall[: len(basis)] = basis
    least = C.T @ C + _MARGIN * size**2 * np.eye(n)
    limits = np.zeros((2 * m, count))
    limits[:, len(basis) :] = -np.eye(2 * m)
    cost = np.zeros(count)
    cost[len(basis) + m :] = -1
    blocks = [Block(-_MARGIN * size**2 * np.eye(wide), slopes), Block(-least, tall)]
    found = proposed(cost, blocks, limits, np.zeros(2 * m))
    if found is None:
        return None
    P = np.tensordot(found[: len(basis)], basis, 1) / units[:, None] / units
    return P, found[len(basis) : len(basis) + m], found[len(basis) + m :] * scale


def _checked(loop: ForcedLoop, rho2: Fraction, P: Reals, weights: Reals, pushes: Reals) -> Falling | None:
    """The proposal in exact numbers, if the inequality holds of them."""
    n, m = loop.order, loop.channels
    if not (np.isfinite(P).all() and np.isfinite(weights).all() and np.isfinite(pushes).all()):
        return None
    V = fmpq_mat([[to_fmpq(_short(P[max(i, j), min(i, j)])) for j in range(n)] for i in range(n)])
    lam, beta = [_short(max(v, 0.0)) for v in weights], [_short(max(v, 0.0)) for v in pushes]
    minus = fmpq_mat(n, m) - loop.B, fmpq_mat(loop.D.nrows(), m) - loop.D
    moved, seen = _beside(loop.A, loop.B, minus[0]), _beside(loop.C, loop.D, minus[1])
    whole = (fmpq_mat(n + 2 * m, n + 2 * m) - moved.transpose() * V * moved).tolist()
    rows = seen.tolist()
    for i in range(n):
        for j in range(n):
            whole[i][j] += to_fmpq(rho2) * V[i, j]
    for i, (weight, push, kappa) in enumerate(zip(lam, beta, loop.spread, strict=True)):
        whole[n + i][n + i] += to_fmpq(weight)
        whole[n + m + i][n + m + i] += to_fmpq(push)
        for r, a in enumerate(rows[i]):
            for c, b in enumerate(rows[i]):
                whole[r][c] -= to_fmpq(weight * kappa**2) * a * b
    held = positive_definite(V) and positive_definite(fmpq_mat(whole))
    return Falling(V, rho2, tuple(beta)) if held else None


def _short(value: float) -> Fraction:
    return Fraction(f"{value:.{_DIGITS}g}")


def _beside(*sides: fmpq_mat) -> fmpq_mat:
    return fmpq_mat([[v for row in rows for v in row] for rows in zip(*(side.tolist() for side in sides), strict=True)])


def positive_definite(side: fmpq_mat) -> bool:
    """Whether a symmetric matrix is positive definite: by its leading minors, exactly."""
    rows = side.tolist()
    return all(fmpq_mat([row[:k] for row in rows[:k]]).det() > 0 for k in range(1, len(rows) + 1))


def refined(loop: ForcedLoop, found: Balanced, count: int) -> Balanced:
    """More harmonics, by substitution, which converges where the circle criterion holds.

    ``found``: the balance to begin with; ``count``: how many harmonics.
    """
    start = balanced(loop, found.wave, found.psi, count) if count <= found.count else found
    psi = np.zeros((loop.channels, count + 1), complex)
    psi[:, : start.psi.shape[1]] = start.psi[:, : count + 1]
    whole, outer = loop.responses(float(found.wave.base), count)
    points = 1 << math.ceil(math.log2(8 * (count + 1)))
    forced = np.einsum("kij,jk->ik", outer, found.wave.harmonics(count))
    m, before, slow = loop.channels, math.inf, 0

    def missed(psi: Complexes) -> Reals:
        """By how much ``phi(sigma) - g sigma``, with the ``sigma`` that follows from ``psi``, is not ``psi``."""
        sigma = sampled(forced[:m] - np.einsum("kij,jk->ik", whole[:, :m], psi), points)
        gained = [
            np.asarray(f(s)) - float(g) * s for f, g, s in zip(loop.nonlinearities, loop.gains, sigma, strict=True)
        ]
        return np.array(gained) - sampled(psi.copy(), points)

    with np.errstate(all="ignore"):
        for _ in range(_ROUNDS):
            checkpoint()
            rest = missed(psi)
            off = np.fft.rfft(rest, axis=1)[:, : count + 1] * (2 / points)
            off[:, 0] = off[:, 0].real / 2
            size = float(np.abs(off).max())
            slow = slow + 1 if size > _SLOWLY * before else 0
            if not size > _ENOUGH * max(1.0, float(np.abs(psi).max())) or slow > 3:
                break
            psi, before = psi + off, size
    z = sampled((forced - np.einsum("kij,jk->ik", whole, psi))[m:], PEAK * points)
    top = math.sqrt(float((z**2).sum(axis=0).max()))
    return Balanced(found.wave, psi, size, float(np.abs(rest).max()), top)


def settled(loop: ForcedLoop, wave: Wave) -> Balanced:
    """So many harmonics that the band is narrow, or as many as are enclosed in half a second.

    ``wave``: the input, its frequency the angle between two samples.
    """
    found = balanced(loop, wave, np.zeros((loop.channels, 1), complex), _COUNTS[0])
    for count in _COUNTS:
        found = refined(loop, found, count)
        if found.missed < _CLOSE * found.peak:
            break
    return found


def sample_band(loop: ForcedLoop, found: Balanced, V: Falling) -> Band:
    """Largest samples of the steady solution near a balance.

    Parameters
    ----------
    loop : ForcedLoop
        The loop, in discrete time.
    found : Balanced
        The balance.
    V : Falling
        What falls along differences.

    Raises
    ------
    InputError
        A nonlinearity has no slope that is known on the way of ``sigma``.
    """
    missed = residual(loop, found, _EACH)
    with working_precision(BITS):
        reach = carried(missed, V, found.wave.omega).sqrt()
        inverse = arb_mat(V.P.tolist()).inv()
        sides = [reach * _length(row, inverse) for row in loop.C.tolist()]
        m, tops = loop.channels, [ball(float(one.max())) for one in missed.parts]
        through = [
            sum((abs(arb(v)) * ball(k) for v, k in zip(row, loop.spread, strict=True)), arb(0))
            for row in loop.D.tolist()
        ]
        direct = [sum((abs(arb(v)) * e for v, e in zip(row, tops, strict=True)), arb(0)) for row in loop.D.tolist()]
        share = max(through[:m], key=float)
        largest = max((a + b for a, b in zip(sides[:m], direct, strict=False)), key=float)
        off = largest / (1 - share) if share < 1 else arb("inf")
        errors = [(a + b + (k * off if k != 0 else 0)).upper() for a, b, k in zip(sides, direct, through, strict=True)]
        wide = sum((e * e for e in errors[m:]), arb(0)).sqrt().upper()
        sigma = tuple(around(peak([missed.rows[i]]), errors[i]) for i in range(m))
        z = around(peak(missed.rows[m:]), wide)
        return Band(sigma, z, above(wide), above(missed.mean))


def _length(row: Sequence[fmpq], inverse: arb_mat) -> arb:
    """What ``|c x|`` is at most where ``V(x) <= 1``."""
    c = arb_mat([list(row)])
    return (c * inverse * c.transpose())[0, 0].nonnegative_part().sqrt().upper()


def carried(missed: Residual, V: Falling, theta: Fraction) -> arb:
    """The largest sum of what a residual adds to ``V`` at the samples before, over all phases, from above.

    ``V``: the function; ``theta``: the angle between two samples.
    """
    beta = np.array([above(ball(one)) for one in V.pushes])
    cells = (beta[:, None] * np.array(missed.parts) ** 2).sum(axis=0) * (1 + _ROUNDED)
    count, rho2, weight = len(cells), above(ball(V.rho2)), 1.0
    total = np.zeros(count)
    steps = min(_MOST_STEPS, max(1, math.ceil(math.log(_TAIL * (1 - rho2)) / math.log(rho2))))
    for j in range(1, steps + 1):
        back = -float((ball(theta * j) * count / (2 * arb.pi())).mid())
        low, high = math.floor(back - _OFF), math.floor(back + _OFF) + 1  # the cells that may hold the phase
        total += weight * np.max([np.roll(cells, -k) for k in range(low, high + 1)], axis=0)
        weight *= rho2 * (1 + _ROUNDED)
    rest = weight / (1 - rho2) * float(cells.max()) * (1 + _ROUNDED)
    return ball(float(total.max()) * (1 + _ROUNDED) + rest * (1 + _ROUNDED))

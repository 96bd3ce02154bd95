"""Claim: no member gets more through than the gain that is proved, and none decays more slowly than the rate.

Random loops in both times, and for each many members and inputs, none of them known to the proofs.  Of rates: constant
gains; gains that jump, over and over again; piecewise linear functions with ``phi(q sigma) = q phi(sigma)``, which look
alike near 0 and far from it, so that one can watch them for as long as one likes.  Of gains: constant gains at many
frequencies, and nonlinear and varying members simulated in discrete time with noise and with sines.  ``python
attacked_gains_and_rates.py LOOPS`` takes so many loops of each kind; with 100 there are 200 000 attacks.
"""

import math
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction

import numpy as np

from lure import NonlinearityClass, Sector, SlopeBounds, as_plant
from lure.analysis import decay_rate, l2_gain
from lure.analysis.verdict import Verdict

Reals = np.ndarray
Matrices = tuple[Reals, Reals, Reals]
Class = Sector | SlopeBounds | NonlinearityClass
MEMBERS, LOOPS, PIECES, STEPS = 500, 5, 8, 1500
ROUNDING, LARGEST_C = 1e-9, 1e4  # the number c of a rate, of which nothing is proved


def loop(random: np.random.Generator, *, discrete: bool) -> Matrices:
    """A stable plant of order 2 or 3 with one channel, in short decimals."""
    n = int(random.integers(2, 4))
    A = random.normal(size=(n, n))
    values = np.linalg.eigvals(A)
    A = A / np.abs(values).max() * random.uniform(0.3, 0.9) if discrete else A - (values.real.max() + 0.4) * np.eye(n)
    return np.round(A, 3), np.round(random.normal(size=(n, 1)), 3), np.round(random.normal(size=(1, n)), 3)


def classes(kind: str, upper: float) -> Class:
    """A class with the upper bound."""
    if kind == "varying":
        return NonlinearityClass(sector=Sector(0, upper), time_varying=True)
    return Sector(0, upper) if kind == "sector" else SlopeBounds(0, upper)


def graphs(random: np.random.Generator, upper: float) -> tuple[Callable[[Reals], Reals], Reals]:
    """Members with slopes in ``[0, upper]`` and ``phi(q sigma) = q phi(sigma)``, and the ``q`` of each."""
    slopes = upper * np.where(
        random.random((MEMBERS, 2, PIECES)) < 0.5,
        random.integers(0, 2, (MEMBERS, 2, PIECES)),
        random.random((MEMBERS, 2, PIECES)),
    )
    slopes[::2, 1] = slopes[::2, 0]  # half of them odd
    width = random.uniform(0.2, 3.0, MEMBERS)  # of a period in log sigma
    edges = np.exp(width[:, None] * (np.arange(PIECES + 1) / PIECES - 1))
    rises = slopes * np.diff(edges, axis=1)[:, None, :]
    before = rises.sum(-1) * (np.exp(-width) / (1 - np.exp(-width)))[:, None]  # phi at 1/q
    left = before[:, :, None] + np.concatenate([np.zeros((MEMBERS, 2, 1)), np.cumsum(rises, -1)[..., :-1]], -1)
    row = np.arange(MEMBERS)

    def phi(sigma: Reals) -> Reals:
        size = np.abs(sigma) + 1e-290
        turns = np.floor(np.log(size) / width) + 1
        y = size * np.exp(-turns * width)
        k = np.clip(((np.log(y) / width + 1) * PIECES).astype(int), 0, PIECES - 1)
        side = (sigma < 0).astype(int)
        value = left[row, side, k] + slopes[row, side, k] * (y - edges[row, k])
        return np.asarray(np.sign(sigma) * value * np.exp(turns * width))

    return phi, np.exp(-width)


def followed(parts: Matrices, phi: Callable[[Reals], Reals], q: Reals, random: np.random.Generator) -> Reals:
    """How fast ``|x(t)|`` falls per step, from the first quarter on; states are scaled by powers of ``q``."""
    A, B, C = parts
    x, lost, early = random.normal(size=(MEMBERS, len(A))), np.zeros(MEMBERS), np.zeros(MEMBERS)
    for t in range(STEPS):
        x = x @ A.T - phi(x @ C[0])[:, None] * B[:, 0]
        size = np.linalg.norm(x, axis=1) + 1e-290
        scale = np.floor(np.log(size) / np.log(q)) * np.log(q)
        x, lost = x * np.exp(-scale)[:, None], lost + scale
        if t == STEPS // 4:
            early = lost + np.log(np.linalg.norm(x, axis=1) + 1e-290)
    return (lost + np.log(np.linalg.norm(x, axis=1) + 1e-290) - early) / (STEPS - 1 - STEPS // 4)


def jumping(
    parts: Matrices, upper: float, random: np.random.Generator, *, discrete: bool, constant: bool = False
) -> Reals:
    """The exponents of loops whose gain has some values in turn, or one: exact but for rounding."""
    A, B, C = parts
    count = 1 if constant else int(random.integers(2, 6))
    gains = np.where(random.random((MEMBERS, count)) < 0.5, random.integers(0, 2, (MEMBERS, count)), 0.5) * upper
    gains = gains if not constant else random.uniform(0, upper, (MEMBERS, 1))
    times, whole = np.ones((MEMBERS, count)), np.broadcast_to(np.eye(len(A)), (MEMBERS, *A.shape))
    if not discrete:
        times = random.uniform(0.05, 2.0, (MEMBERS, count))
    for k in range(count):
        closed = A - gains[:, k, None, None] * (B @ C)
        if not discrete:
            values, vectors = np.linalg.eig(closed)
            grown = np.exp(values * times[:, k, None])[:, None, :]
            closed = np.real((vectors * grown) @ np.linalg.inv(vectors))
        whole = closed @ whole
    radius = np.abs(np.linalg.eigvals(whole)).max(axis=1)
    return np.log(radius + 1e-290) / times.sum(axis=1)


def rates(random: np.random.Generator, loops: int) -> Iterator[tuple[int, float]]:
    """Of each loop the attacks, and the largest exponent of a member less that which is proved, over the latter."""
    done = 0
    while done < loops:
        discrete, kind = bool(random.integers(2)), str(random.choice(["varying", "sector", "slope"]))
        parts, upper = loop(random, discrete=discrete), float(np.round(random.uniform(0.02, 0.6), 3))
        found = decay_rate(given(parts, discrete=discrete), classes(kind, upper))
        if found.verdict is not Verdict.PROVED:
            continue
        done += 1
        proved = math.log(found.rate.high) if discrete else -found.rate.low
        for jumps in (kind != "varying", False) if kind == "varying" else (True,):
            exponents = jumping(parts, upper, random, discrete=discrete, constant=jumps)
            yield MEMBERS, float(exponents.max() - proved) / abs(proved)
        if discrete:
            slack = math.log(LARGEST_C) / (0.75 * STEPS)
            exponents = followed(parts, *graphs(random, upper), random)
            yield MEMBERS, float(exponents.max() - proved - slack) / abs(proved)


def given(parts: Matrices, *, discrete: bool) -> object:
    """The plant as it is handed over."""
    A, B, C = ([[Fraction(str(v)) for v in row] for row in side.tolist()] for side in parts)
    return as_plant((A, B, C, [[0]]), dt=1 if discrete else None)


def gains(random: np.random.Generator, loops: int) -> Iterator[tuple[int, float]]:
    """Of each loop the attacks, and the largest gain of a member over that which is proved, less 1."""
    done = 0
    while done < loops:
        discrete, kind = bool(random.integers(2)), str(random.choice(["varying", "sector", "slope"]))
        parts, upper = loop(random, discrete=discrete), float(np.round(random.uniform(0.02, 0.6), 3))
        A, B, C = parts
        Bw, Cz = np.round(random.normal(size=(len(A), 1)), 3), np.round(random.normal(size=(1, len(A))), 3)
        found = l2_gain(given(parts, discrete=discrete), [classes(kind, upper)], {"Bw": Bw.tolist(), "Cz": Cz.tolist()})
        if found.verdict is not Verdict.PROVED:
            continue
        done += 1
        constant = random.uniform(0, upper, MEMBERS)
        closed = A - constant[:, None, None] * (B @ C)
        points = np.exp(1j * np.linspace(0, math.pi, 60)) if discrete else 1j * np.geomspace(1e-3, 1e3, 120)
        pencil = points[:, None, None, None] * np.eye(len(A)) - closed
        seen = np.abs(Cz @ np.linalg.solve(pencil, np.broadcast_to(Bw + 0j, (*pencil.shape[:2], *Bw.shape))))
        yield MEMBERS, float(seen.max()) / found.gain.high - 1
        if discrete:
            omega = float(np.angle(points[int(seen.max(axis=(1, 2, 3)).argmax())]))
            yield MEMBERS, simulated((A, B, C, Bw, Cz), kind, upper, omega, random) / found.gain.high - 1


def simulated(parts: tuple[Reals, ...], kind: str, upper: float, omega: float, random: np.random.Generator) -> float:
    """The largest ``|z|/|w|`` over 300 samples from rest: a lower bound of the gain of each member."""
    A, B, C, Bw, Cz = parts
    phi, _ = graphs(random, upper)
    x, came, went = np.zeros((MEMBERS, len(A))), np.zeros(MEMBERS), np.zeros(MEMBERS)
    sine, phase = random.random(MEMBERS) < 0.7, random.uniform(0, 2 * math.pi, MEMBERS)
    for t in range(300):
        sigma, z = x @ C[0], x @ Cz[0]
        w = np.where(sine, np.sin(omega * t + phase), random.normal(size=MEMBERS)) * (t < 280)
        mu = phi(sigma)
        if kind == "varying":
            mu = np.where(random.random(MEMBERS) < 0.5, mu, upper * random.integers(0, 2, MEMBERS) * sigma)
        came, went = came + w * w, went + z * z
        x = x @ A.T - mu[:, None] * B[:, 0] + w[:, None] * Bw[:, 0]
    return float(np.sqrt(went / came).max())


def main(arguments: list[str]) -> int:
    """Attack, count, and say how near the worst came; 1 if anything proved is contradicted."""
    loops, good = int(arguments[0]) if arguments else LOOPS, True
    for name, attacks in (("rates", rates), ("gains", gains)):
        found = list(attacks(np.random.default_rng(20261123), loops))
        worst = max(beyond for _, beyond in found)
        print(f"{name}: {sum(count for count, _ in found)} attacks on {loops} loops, the worst {worst:+.2e} beyond")
        good = good and worst <= ROUNDING
    print("holds" if good else "DOES NOT HOLD")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

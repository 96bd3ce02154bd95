"""Claim: several nonlinearities, certificates included, take a fifth of the time of programmes that prove nothing.

Ten states and three channels: the largest factor of the sectors that diagonal multipliers (circle, Popov) and one
multiplier for all channels prove.  Ours: to 1e-7, with a certificate that the checker accepts.  Usual practice:
bisection to 1e-6 on the matrix inequality by cvxpy and Clarabel, which proves nothing, from twice the answer.  The
answers must agree to 1e-3, and each must take five times as long in cvxpy, in the median of the plants: processor time,
one thread each.  (Most of that is cvxpy's: parameters that are compiled once save it about two thirds.)

Then 60 states and four channels: the largest factor by static and by Popov's multipliers, certified in 10 s each;
200 states with five channels, the circle criterion with its multipliers given, ``P`` found and certified in 30 s; and
one ReLU in 100 channels of 100 states, certified in 60 s.
"""

import itertools
import math
import statistics
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from importlib.util import find_spec

import numpy as np

from lure import Diagonal, NonlinearityClass, Sector, as_plant, certify, max_sector
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.checker import Proved
from lure.analysis.certificates.drafts import checked
from lure.analysis.questions.channel_problem import channel_problem
from lure.analysis.questions.channel_proofs import criteria_for, farthest, searches
from lure.analysis.questions.problem import Problem
from lure.analysis.verdict import Verdict

Reals = np.ndarray
TOLERANCE, AGREEMENT, FASTER = 1e-6, 1e-3, 5.0
SECONDS = {60: 10.0, 200: 30.0, 100: 60.0}
VARYING = NonlinearityClass(sector=Sector(0, 1), time_varying=True)
PLAIN = NonlinearityClass(sector=Sector(0, 1))
ROWS = {
    "diagonal-circle": (VARYING, False, False),
    "diagonal-popov": (PLAIN, True, False),
    "full-block-circle": (VARYING, False, True),
}


def plant(n: int, m: int, seed: int) -> tuple[Reals, Reals, Reals]:
    """A dense stable plant; its states decay at rates from 0.3 on."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    A -= (np.linalg.eigvals(A).real.max() + 0.3) * np.eye(n)
    return A, rng.normal(size=(n, m)), rng.normal(size=(m, n)) / n


def solvable(parts: tuple[Reals, Reals, Reals], alpha: float, *, popov: bool, full: bool) -> bool:
    """Whether the matrix inequality has a solution for the sectors ``[0, alpha]``, by cvxpy and Clarabel."""
    import cvxpy as cp

    A, B, C = parts
    n, m = B.shape
    P, t = cp.Variable((n, n), symmetric=True), cp.Variable()
    edge, corner, limits = -alpha * (P @ B), np.zeros((m, m)), [t <= 1, cp.norm(P, "fro") <= 1e4]
    if full:  # psi = phi/alpha
        Pi = cp.Variable((2 * m, 2 * m), symmetric=True)
        Y = np.block([[C, np.zeros((m, m))], [np.zeros((m, n)), np.eye(m)]])
        form = Y.T @ Pi @ Y
        limits += [Pi[m + i, m + i] <= 0 for i in range(m)] + [cp.norm(Pi, "fro") <= 1e2]
        views = (np.vstack([np.eye(m), np.diag(ends)]) for ends in itertools.product((0.0, 1.0), repeat=m))
        limits += [view.T @ Pi @ view >> 0 for view in views]
    else:
        weights, theta = cp.Variable(m, nonneg=True), cp.Variable(m)
        L = cp.diag(weights)
        form = cp.bmat([[np.zeros((n, n)), C.T @ L], [L @ C, -2 * L]])
        limits += [weights <= 1, cp.abs(theta) <= 1e3] + ([] if popov else [theta == 0])
        edge += A.T @ C.T @ cp.diag(theta)
        corner = -alpha * (cp.diag(theta) @ (C @ B) + (C @ B).T @ cp.diag(theta))
    matrix = cp.bmat([[A.T @ P + P @ A, edge], [edge.T, corner]]) + form
    limits.append(matrix << -t * np.eye(n + m))
    problem = cp.Problem(cp.Maximize(t), limits)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem.solve(solver=cp.CLARABEL)
    if problem.status not in ("optimal", "optimal_inaccurate") or t.value <= 1e-9:
        return False
    return bool(np.linalg.eigvalsh((matrix.value + matrix.value.T) / 2).max() < 0)  # a margin alone is not always one


def bisected(holds: Callable[[float], bool], high: float) -> float:
    """The largest factor found, relative to ``TOLERANCE``."""
    low = 0.0
    while high - low > TOLERANCE * high:
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def compared(seed: int) -> dict[str, float]:
    """Each criterion for one plant: both answers, both times; the ratio of the times, 0 where the answers disagree."""
    parts, ratios = plant(10, 3, seed), dict[str, float]()
    for name, (one, popov, full) in ROWS.items():
        start = time.process_time()
        asked = channel_problem(as_plant(parts), [one] * 3, kind="sector", criterion=name)
        found = farthest(asked, criteria_for(asked)[0], Fraction(0), math.inf)
        ours = time.process_time() - start
        low = 0.0 if found is None else float(found[0])
        start = time.process_time()
        theirs = bisected(partial(solvable, parts, popov=popov, full=full), 2 * low)
        peer = time.process_time() - start
        print(f"{name:18} {low:.6f} certified, {ours:.2f} s; cvxpy {theirs:.6f}, {peer:.2f} s; ratio {peer / ours:.1f}")
        ratios[name] = peer / ours * (low >= theirs * (1 - AGREEMENT) > 0)
    return ratios


def given_multipliers(asked: Problem, weights: list[Fraction]) -> Proved | None:
    """A certificate of the circle criterion with these multipliers, its ``P`` by Riccati equations."""
    search, lower = next(iter(searches(asked, criteria_for(asked)[0]))), asked.classes.lower
    scaled = [w / (high - low) for w, high, low in zip(weights, asked.classes.upper, lower, strict=True)]
    plain, ends = (np.diag([float(w) for w in side]) for side in (weights, scaled))
    draft = {"verdict": "PROVED", "system": asked.system, "laws": asked.class_entry, "theorem": "diagonal-circle"}
    draft["multiplier"] = {"lambda": [*map(str, scaled)]}
    for proof in search.solutions(
        np.block([[0 * plain, plain], [plain, -2 * ends]]), [Fraction(0)] * len(weights), lower
    ):
        with suppress(Rejected):
            shown = checked(draft | {"proof": proof})
            return shown if isinstance(shown, Proved) else None
    return None


def large() -> bool:
    """The larger plants: whether each is proved, and in time."""
    good, asked = True, channel_problem(as_plant(plant(60, 4, 1)), [PLAIN] * 4, kind="sector")
    for name in ("diagonal-circle", "diagonal-popov"):
        start = time.perf_counter()
        found = farthest(asked, next(one for one in criteria_for(asked) if one.name == name), Fraction(0), math.inf)
        spent = time.perf_counter() - start
        print(f"{name:18} 60 states, 4 channels: {float(found[0]) if found else 0:.6f} certified, {spent:.1f} s")
        good &= found is not None and spent < SECONDS[60]
    asked = channel_problem(
        as_plant(plant(200, 5, 1)), [replace(VARYING, sector=Sector(0, 0.3))] * 5, criterion="diagonal-circle"
    )
    start = time.perf_counter()
    shown = given_multipliers(asked, [Fraction(1)] * 5)
    spent = time.perf_counter() - start
    print(f"given multipliers  200 states, 5 channels: {'PROVED' if shown else 'INCONCLUSIVE'}, {spent:.1f} s")
    good &= shown is not None and spent < SECONDS[200]
    random, one = np.random.default_rng(0), np.eye(100)
    network = as_plant((-one, -0.07 * random.normal(size=(100, 100)), one, 0 * one))  # x' = -x + W max(x, 0)
    start = time.perf_counter()
    found = certify(network, Diagonal((NonlinearityClass.relu(),) * 100, repeated=True))
    spent = time.perf_counter() - start
    print(f"{found.shown.theorem if found.shown else '-':18} one ReLU in 100 channels: {found.verdict}, {spent:.1f} s")
    return good and found.verdict is Verdict.PROVED and spent < SECONDS[100]


def main() -> int:
    """Compare answers, then times; 1 if they disagree or one is too slow."""
    good = True
    max_sector(as_plant(plant(2, 2, 0)), [VARYING] * 2)  # what is imported on first use
    if find_spec("cvxpy") is None:
        print("cvxpy is not installed: nothing to compare with", file=sys.stderr)
        good = False
    else:
        for full in (True, False):
            solvable(plant(2, 2, 0), 1.0, popov=True, full=full)
        ratios = [compared(seed) for seed in range(5)]
        for name in ROWS:
            middle = statistics.median(one[name] for one in ratios)
            print(f"{name:18} {middle:.1f} times as fast")
            good &= middle >= FASTER and min(one[name] for one in ratios) > 0
    good &= large()
    print("holds" if good else "DOES NOT HOLD")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())

"""Claim: Popov's largest sector and best multiplier, certified from both sides, are 100 times faster than by an SDP.

A block of order 40, 20 lightly damped modes.  Ours: exact cutting planes, one root count as the proof, relative width
1e-9 or less.  Usual practice: doubling, then bisection in ``k`` to 1e-6 on the KYP matrix inequality with ``P`` and
``theta`` free, by cvxpy and Clarabel (``cvxpy`` must be installed); it proves nothing.  The answers must agree to 1e-3,
which is what the inequality is good for here.  Then a dense block of 400 states in floating point: computed, not
certified.
"""

import sys
import time
from fractions import Fraction
from importlib.util import find_spec

import numpy as np

from lure.analysis.inequality.state_space import StatesInequality
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Evidence, Verdict
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace

MODES, TOLERANCE, AGREEMENT, RATIO, SECONDS = 20, 1e-6, 1e-3, 100, 60.0


def modal(modes: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``A, b, c`` of modes in parallel: ``sum g_i w_i^2 / (s^2 + 2 zeta_i w_i s + w_i^2)``."""
    rng = np.random.default_rng(seed)
    w = np.round(np.geomspace(1, 30, modes), 3)
    zeta, gain = np.round(rng.uniform(0.02, 0.2, modes), 3), np.round(rng.normal(size=modes), 3)
    a, b, c = np.zeros((2 * modes, 2 * modes)), np.zeros(2 * modes), np.zeros(2 * modes)
    for i in range(modes):
        a[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0, w[i]], [-w[i], -2 * zeta[i] * w[i]]]
        b[2 * i + 1], c[2 * i] = w[i], gain[i]
    return a, b, c


def exact(a: np.ndarray, c: np.ndarray) -> RationalPlant:
    """The same block as an exact fraction."""
    top, bottom = [Fraction(0)], [Fraction(1)]
    for i in range(c.size // 2):
        w, damping, gain = (decimal(v) for v in (a[2 * i, 2 * i + 1], -a[2 * i + 1, 2 * i + 1], c[2 * i]))
        mode = [Fraction(1), damping, w * w]
        scaled = [gain * w * w * d for d in bottom]
        top = added(multiplied(top, mode), scaled)
        bottom = multiplied(bottom, mode)
    return RationalPlant(top, bottom)


def decimal(value: float) -> Fraction:
    """The decimal of six digits that was meant."""
    return Fraction(f"{value:.6f}")


def multiplied(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    """The product of two polynomials, descending powers."""
    result = [Fraction(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return result


def added(p: list[Fraction], q: list[Fraction]) -> list[Fraction]:
    """Their sum."""
    size = max(len(p), len(q))
    p, q = ([Fraction(0)] * (size - len(side)) + side for side in (p, q))
    return [a + b for a, b in zip(p, q, strict=True)]


def feasible(a: np.ndarray, b: np.ndarray, c: np.ndarray, k: float) -> bool:
    """Whether Clarabel finds ``P`` and ``theta`` for the sector ``[0, k]``."""
    import cvxpy as cp

    n = b.size
    P, theta, margin = cp.Variable((n, n), symmetric=True), cp.Variable(), cp.Variable()
    side = P @ b[:, None] - 0.5 * (c + theta * (c @ a))[:, None]
    corner = cp.reshape(-1 / k - theta * float(c @ b), (1, 1), order="C")
    block = cp.bmat([[a.T @ P + P @ a, side], [side.T, corner]])
    problem = cp.Problem(cp.Maximize(margin), [block << -margin * np.eye(n + 1), margin <= 1, cp.norm(P, "fro") <= 1e4])
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.error.SolverError:
        return False
    return margin.value is not None and float(margin.value) > 1e-9


def main() -> int:
    """Compare answers, then times; 1 if they disagree or the ratio falls short."""
    a, b, c = modal(MODES, 1)
    block = exact(a, c)
    runs = []
    for _ in range(5):
        start = time.perf_counter()
        answer = popov_largest(block)
        runs.append(time.perf_counter() - start)
    ours = min(runs)
    largest = answer.largest
    print(f"order {block.order}: certified {largest.low:.13g} .. {largest.high:.13g}, theta {answer.theta:.6g} s")
    certified = answer.verdict is Verdict.PROVED and answer.largest.width <= 1e-9 * answer.largest.high

    if find_spec("cvxpy") is None:
        print("cvxpy is not installed: nothing to compare with")
        return 0 if certified else 1
    start, low, high = time.perf_counter(), 0.0, 1.0
    if feasible(a, b, c, high):
        while feasible(a, b, c, 2 * high):
            high *= 2
        low, high = high, 2 * high
    else:
        while not feasible(a, b, c, high / 2):
            high /= 2
        low = high / 2
    while high - low > TOLERANCE * high:
        k = (low + high) / 2
        low, high = (k, high) if feasible(a, b, c, k) else (low, k)
        print(f"cvxpy and Clarabel: {low:.8g} .. {high:.8g}, {time.perf_counter() - start:.0f} s", file=sys.stderr)
    peer = time.perf_counter() - start
    agrees = abs(high - answer.largest.middle) <= AGREEMENT * high
    print(f"cvxpy and Clarabel    {low:.8g} .. {high:.8g}, {peer:.3g} s")
    print(f"certified             {ours:.3g} s")
    print(f"ratio                 {peer / ours:,.0f}")

    rng = np.random.default_rng(2)
    a, b, c = modal(200, 3)
    q, _ = np.linalg.qr(rng.normal(size=a.shape))
    start = time.perf_counter()
    large = StatesInequality(StateSpace(q @ a @ q.T, q @ b, c @ q.T), Fraction(0), weighted=True)
    largest = large.best().largest
    took = time.perf_counter() - start
    print(f"order 400, dense: computed {largest.low:.8g} .. {largest.high:.8g} in {took:.1f} s")
    seconds = large.grounds.evidence is Evidence.COMPUTED and largest.low > 0 and took < SECONDS
    holds = certified and agrees and peer >= RATIO * ours and seconds
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

"""Random stable state-space blocks of doubles, certified from both sides: 40 states in 2 s, 60 in 5 s, 100 in 30 s.

Prints order, processor time of ``max_sector``, the bracket (proved below, refuted above) and its evidence.  The peer of
the proof alone, up to 40 states, is the same inequality by cvxpy and Clarabel, at a k 1e-3 below the certified one:
its status is no proof, and the least eigenvalue of the inequality with its ``P`` shows whether there is one.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python benchmarks/large_state_space.py
"""

from __future__ import annotations

import sys
import time

import numpy as np

from lure import StateSpace
from lure.analysis import max_sector
from lure.analysis.certificates.second import recheck
from lure.analysis.verdict import Evidence

SECONDS = {20: 1.0, 40: 2.0, 60: 5.0, 100: 30.0}
LARGEST_PEER = 40


def dense(n: int, seed: int) -> StateSpace:
    """Entries of a normal distribution, moved to the spectral abscissa -1/10."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) / np.sqrt(n)
    A -= (np.linalg.eigvals(A).real.max() + 0.1) * np.eye(n)
    return StateSpace(A, rng.standard_normal(n), rng.standard_normal(n))


def clarabel(block: StateSpace, k: float, theta: float) -> str:
    """Time, status and least eigenvalue of the inequality as Clarabel solves it."""
    try:
        import cvxpy as cp
    except ImportError:
        return "cvxpy is not installed"
    n, A, b, c = block.order, block.A, block.B[:, None], block.C[None, :]
    P = cp.Variable((n, n), symmetric=True)
    edge, corner = c.T + theta * A.T @ c.T, np.array([[2 / k + 2 * theta * float((c @ b)[0, 0])]])
    matrix = cp.bmat([[-(A.T @ P + P @ A), edge - P @ b], [(edge - P @ b).T, corner]])
    room = cp.Variable()
    unit = np.eye(n + 1)
    problem = cp.Problem(cp.Maximize(room), [matrix >> room * unit, P >> room * np.eye(n), room <= 1])
    start = time.process_time()
    try:
        problem.solve(solver="CLARABEL")
    except cp.SolverError as error:
        return f"fails after {time.process_time() - start:.1f} s: {error}"
    least = float("nan") if P.value is None else float(np.linalg.eigvalsh(matrix.value)[0])
    return f"{time.process_time() - start:6.1f} s, {problem.status}, least eigenvalue {least:.1e}"


def main() -> int:
    """One line a block; 1 if one is not certified in time, or the second checker disagrees."""
    holds = True
    for n, most in SECONDS.items():
        for seed in (0, 1):
            block = dense(n, seed)
            start = time.process_time()
            found = max_sector(block)
            seconds = time.process_time() - start
            shown = [one for one in (found.proof, found.refutation) if one is not None]
            agreed = bool(shown) and all(recheck(dict(one.certificate)).accepted for one in shown)
            good = agreed and seconds < most and found.evidence is Evidence.CERTIFIED
            holds = holds and good
            against = "none found" if found.refuted_at is None else f"{found.refuted_at:.10g}"
            print(
                f"n = {n:3d}: {seconds:5.2f} s, proved {found.largest.low:.10g}, refuted {against}, {found.evidence}, "
                f"{found.criterion}{'' if good else ': NOT IN TIME, OR NOT CERTIFIED'}"
            )
            if n <= LARGEST_PEER and np.isfinite(found.largest.low):
                print(f"         Clarabel: {clarabel(block, 0.999 * found.largest.low, found.theta or 0.0)}")
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

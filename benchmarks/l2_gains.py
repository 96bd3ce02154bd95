"""Claim: the L2 gain of six states and two channels, from both sides with certificates, takes under 5 s, and agrees.

Continuous time, gains between 0 and 1/4 that vary as they like: the least ``gamma`` of diagonal multipliers.  Usual
practice: one programme in ``gamma^2`` by cvxpy and Clarabel, which proves nothing.  The answers must agree to 1e-4;
processor time, one thread each, in the median of the plants.  (One programme is the quicker by far.)
"""

import statistics
import sys
import time
import warnings
from fractions import Fraction
from importlib.util import find_spec

import numpy as np

from lure import NonlinearityClass, Sector
from lure.analysis import l2_gain

Reals = np.ndarray
AGREEMENT, SECONDS, UPPER = 1e-4, 5.0, Fraction(1, 4)
VARYING = NonlinearityClass(sector=Sector(0, UPPER), time_varying=True)


def plant(seed: int, n: int = 6, m: int = 2) -> tuple[Reals, ...]:
    """A dense stable plant, a disturbance and an output, in short decimals."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    A -= (np.linalg.eigvals(A).real.max() + 0.5) * np.eye(n)
    sides = (rng.normal(size=(n, m)), rng.normal(size=(m, n)) / np.sqrt(n))
    return tuple(np.round(v, 3) for v in (A, *sides, rng.normal(size=(n, 1)), rng.normal(size=(1, n)) / np.sqrt(n)))


def programmed(parts: tuple[Reals, ...]) -> float:
    """The least gamma, by cvxpy and Clarabel."""
    import cvxpy as cp

    A, B, C, Bw, Cz = parts
    (n, m), p = B.shape, Bw.shape[1]
    P, square, weights = cp.Variable((n, n), symmetric=True), cp.Variable(), cp.Variable(m, nonneg=True)
    inputs = np.hstack([-B, Bw])  # of phi and w
    L, none = cp.diag(weights), np.zeros
    sector = cp.bmat([
        [none((n, n)), float(UPPER) * (C.T @ L), none((n, p))],
        [float(UPPER) * (L @ C), -2 * L, none((m, p))],
        [none((p, n)), none((p, m)), none((p, p))],
    ])  # fmt: skip
    gain = np.zeros((n + m + p, n + m + p))
    gain[:n, :n] = Cz.T @ Cz
    last = np.zeros_like(gain)
    last[n + m :, n + m :] = np.eye(p)
    falls = cp.bmat([[A.T @ P + P @ A, P @ inputs], [inputs.T @ P, none((m + p, m + p))]])
    problem = cp.Problem(cp.Minimize(square), [P >> 0, falls + sector + gain - square * last << 0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        problem.solve(solver=cp.CLARABEL)
    return float(np.sqrt(square.value))


def main() -> int:
    """Compare answers and look at the times; 1 if they disagree or ours takes too long."""
    if find_spec("cvxpy") is None:
        print("cvxpy is not installed: nothing to compare with", file=sys.stderr)
        return 1
    ours, theirs, good = [], [], True
    for seed in range(6):
        parts = plant(seed)
        A, B, C, Bw, Cz = (side.tolist() for side in parts)
        start = time.process_time()
        found = l2_gain(
            (A, B, C, np.zeros((2, 2)).tolist()), [VARYING] * 2, {"Bw": Bw, "Cz": Cz}, criterion="diagonal-circle"
        )
        ours.append(time.process_time() - start)
        start = time.process_time()
        peer = programmed(parts)
        theirs.append(time.process_time() - start)
        high = found.gain.high
        good = good and peer * (1 - AGREEMENT) <= high <= peer * (1 + AGREEMENT)
        print(f"{found.gain.low:.6g} .. {high:.6g} certified, {ours[-1]:.2f} s; cvxpy {peer:.6g}, {theirs[-1]:.2f} s")
    ratio = statistics.median(theirs[1:]) / statistics.median(ours[1:])  # the first imports
    print(f"{statistics.median(ours[1:]):.2f} s in the median, {ratio:.1f} times as fast as one programme")
    good = good and statistics.median(ours[1:]) < SECONDS
    print("holds" if good else "DOES NOT HOLD")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())

"""Claim: a certified region of a pendulum held by 64 neurons is four times as large as what the usual programme finds.

Theirs (Yin, Seiler, Arcak 2022): the intervals ``|v1| <= 0.1`` and ``|x1| <= 0.73``, sectors that follow from them, and
the least trace of ``P`` by cvxpy and Clarabel, which proves nothing; published weights, least trace 3.88723, area
1.74987.  Ours with the same intervals, the largest area, decided in rationals by the checker; and with intervals that
are searched.  Processor time, one thread each.
"""

import math
import sys
import time
from fractions import Fraction
from importlib.resources import files
from importlib.util import find_spec

import numpy as np

from lure.analysis.questions.region_proofs import proved_ellipsoid, proved_on
from lure.analysis.questions.region_sets import matrix_of, shape_of, volume_below
from lure.files import read_system

TRACE, AREA, SECONDS = 3.88723, 1.74987, 60.0


def peer() -> tuple[float, float]:
    """The least trace, and the area, by cvxpy and Clarabel."""
    import cvxpy as cp

    loop = read_system(files("lure.networks") / "pendulum.toml").block
    A, B, C, D = loop.doubles()
    n, m = B.shape
    reach = np.array([0.73] + [0.1] * 32)
    second = np.abs(D[33:65, 1:33]) @ np.tanh(reach[1:])
    third = np.abs(D[65:, 33:65]) @ np.tanh(second)
    ends = np.concatenate([reach[1:], second])
    low = np.concatenate([[0.0], np.tanh(ends) / ends, np.minimum(0.7 / third, 1.0)])
    high = np.concatenate([[1 - math.sin(0.73) / 0.73], np.ones(m - 1)])
    moved, kept = np.hstack([A, -B]), np.hstack([np.eye(n), np.zeros((n, m))])
    Y, phi = np.hstack([C, -D]), np.hstack([np.zeros((m, n)), np.eye(m)])
    P, weights = cp.Variable((n, n), symmetric=True), cp.Variable(m, nonneg=True)
    T = cp.diag(weights)
    product = (high[:, None] * Y - phi).T @ T @ (phi - low[:, None] * Y)
    matrix = moved.T @ P @ moved - kept.T @ P @ kept + product + product.T
    strips = [P >> np.outer(row, row) / c**2 for row, c in zip(C[:33], reach, strict=True)]
    problem = cp.Problem(cp.Minimize(cp.trace(P)), [matrix << -1e-9 * np.eye(n + m), *strips])
    problem.solve(solver=cp.CLARABEL)
    return float(np.trace(P.value)), math.pi / math.sqrt(float(np.linalg.det(P.value)))


def main() -> int:
    """Compare areas and times; 1 where ours is smaller or too slow."""
    system = read_system(files("lure.networks") / "pendulum.toml")
    shapes = [shape_of(one) for one in system.nonlinearities]
    states = [Fraction(73, 100), *[Fraction(1, 10)] * 32, *[None] * 33]
    start = time.process_time()
    same = proved_on(system.block, shapes, states, None)
    middle = time.process_time()
    own = proved_ellipsoid(system.block, shapes, None)
    end = time.process_time()
    assert same is not None
    assert own is not None
    small, large = (volume_below(matrix_of(one.certificate)) for one in (same, own))
    print(f"the same intervals: area {small:.5f} certified, {middle - start:.1f} s")
    print(f"searched intervals: area {large:.5f} certified, {end - middle:.1f} s")
    fine = small > AREA and large > 4 * AREA and end - middle < SECONDS
    if find_spec("cvxpy") is None:
        print("cvxpy is not installed: nothing to compare with", file=sys.stderr)
        return 0 if fine else 1
    start = time.process_time()
    trace, area = peer()
    print(f"cvxpy and Clarabel: trace {trace:.5f}, area {area:.5f}, {time.process_time() - start:.1f} s")
    return 0 if fine and abs(trace - TRACE) < 1e-2 else 1


if __name__ == "__main__":
    sys.exit(main())

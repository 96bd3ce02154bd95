"""Claim: a matrix certificate of order 41 is proposed and verified in a 20th of the time in which an SDP is solved.

Popov's inequality for a dense block of 41 states, 20 of its modes lightly damped, at 0.9 of the largest sector.  Ours:
``P`` from a Riccati equation, rounded to integers, and verified in exact arithmetic by the checker, which takes the
whole certificate from its JSON text.  Usual practice: the same matrix inequality with ``P`` free by cvxpy and Clarabel
(``cvxpy`` must be installed), which proves nothing.  They must agree that there is a ``P`` at 0.9 of the largest sector
and none at 1.1.  Times are of the processor, on one thread, ours the best of five.  Then order 401, where no SDP is
attempted: the scheme of the paper's rod with 200 cells, by its energy and next to the circle criterion's limit, and a
dense random block; proposed and verified, with times and the largest memory so far.
"""

import json
import resource
import sys
import time
from fractions import Fraction
from importlib.util import find_spec

import numpy as np

from lure.analysis.certificates.checker import Proved, check
from lure.analysis.certificates.drafts import completed
from lure.analysis.certificates.matrix import MatrixBlock, matrix_draft
from lure.analysis.inequality.state_space import StatesInequality
from lure.analysis.rod.certificates import energy_theta
from lure.analysis.theorems.table import Upper
from lure.errors import AssumptionError
from lure.plants.state_space import StateSpace
from lure.rod import builtin_system, upwind

MODES, CELLS, SHARE, OVER, RATIO, SECONDS, MEGABYTES = 20, 200, Fraction(9, 10), Fraction(11, 10), 20, 120.0, 500.0


def resonant(modes: int) -> StateSpace:
    """Modes in parallel and one real pole, in a random orthogonal basis."""
    rng = np.random.default_rng(1)
    n = 2 * modes + 1
    a, b, c = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    for i, w in enumerate(np.geomspace(1.0, 30.0, modes)):
        a[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0.0, w], [-w, -2.0 * rng.uniform(0.02, 0.2) * w]]
        b[2 * i + 1], c[2 * i] = w, rng.normal()
    a[-1, -1], b[-1], c[-1] = -1.0, 1.0, 1.0
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    return StateSpace(q @ a @ q.T, q @ b, c @ q.T)


def random_block(n: int) -> StateSpace:
    """A full random matrix, shifted so that its rightmost eigenvalue is at -1/2."""
    rng = np.random.default_rng(7)
    a = rng.standard_normal((n, n))
    a -= (np.linalg.eigvals(a).real.max() + 0.5) * np.eye(n)
    return StateSpace(a, rng.standard_normal(n), rng.standard_normal(n))


def certified(block: MatrixBlock, upper: Upper, theta: Fraction | None) -> tuple[float, float, int]:
    """Times to propose and to verify [s], and the length of the certificate; raises if it is not accepted."""
    start = time.process_time()
    text = json.dumps(completed(matrix_draft(block, upper, theta=theta)))
    proposed = time.process_time()
    if not isinstance(check(text), Proved):
        raise TypeError("a proof was expected")
    return proposed - start, time.process_time() - proposed, len(text)


def margin(block: StateSpace, k: float, theta: float) -> float:
    """The largest least eigenvalue, at most 1, of ``P`` and the matrix of the inequality that Clarabel finds."""
    import cvxpy as cp

    a, b, c, n = block.A, block.B, block.C, block.order
    P, level = cp.Variable((n, n), symmetric=True), cp.Variable()
    side = (c + theta * (c @ a))[:, None] - P @ b[:, None]
    corner = np.array([[2.0 / k + 2.0 * theta * float(c @ b)]])
    whole = cp.bmat([[-(a.T @ P + P @ a), side], [side.T, corner]])
    problem = cp.Problem(cp.Maximize(level), [whole >> level * np.eye(n + 1), P >> level * np.eye(n), level <= 1])
    problem.solve(solver=cp.CLARABEL)
    return -1.0 if level.value is None else float(level.value)


def against_clarabel() -> bool:
    """Whether order 41 agrees with Clarabel and is as much faster as claimed."""
    block = resonant(MODES)
    found = StatesInequality(block, Fraction(0), weighted=True).best()
    assert found.multiplier is not None
    theta = Fraction(found.multiplier["theta"]).limit_denominator(10**6)
    k, above = (Fraction(found.largest.low) * share for share in (SHARE, OVER))
    print(f"order {block.order}: largest k about {found.largest.low:.8g}, theta {float(theta):.6g} s")
    runs = [certified(block, k, theta) for _ in range(5)]
    proposing, verifying = min(run[0] for run in runs), min(run[1] for run in runs)
    print(f"proposed               {proposing:.3g} s, {runs[0][2] / 1e6:.2g} MB")
    print(f"verified               {verifying:.3g} s")
    try:
        matrix_draft(block, above, theta=theta)
        refused = False
    except AssumptionError as reason:
        print(f"at {float(OVER):g} of the largest k: {reason}")
        refused = True
    if find_spec("cvxpy") is None:
        print("cvxpy is not installed: nothing to compare with")
        return refused
    margin(random_block(2), 1e-3, 0.0)  # loads cvxpy
    start = time.process_time()
    inside = margin(block, float(k), float(theta))
    peer = time.process_time() - start
    outside = margin(block, float(above), float(theta))
    print(
        f"cvxpy and Clarabel     {peer:.3g} s, margin {inside:.3g}; at {float(OVER):g} of the largest k {outside:.3g}"
    )
    ratio = peer / (proposing + verifying)
    print(f"ratio                  {ratio:,.0f}   (claim: at least {RATIO})")
    return refused and inside > 0 >= outside and ratio >= RATIO


def large() -> bool:
    """Whether order 401 is proposed and verified within the time and memory claimed."""
    rod = builtin_system("paper-rod").rod
    scheme, holds = upwind(rod, CELLS), True
    square = rod.exact["area"] ** 2 * rod.exact["density"] * rod.exact["youngs_modulus"]
    k = rod.exact["damping"]
    limit = rod.exact["youngs_modulus"] / rod.exact["length"] * k**2 / (square - k**2)  # k < Z
    dense = random_block(2 * CELLS + 1)
    computed = StatesInequality(dense, Fraction(0), weighted=True).best().largest
    cases: list[tuple[str, MatrixBlock, Upper, Fraction | None]] = [
        ("rod, [0, inf), energy", scheme, "inf", energy_theta(scheme)),
        ("rod, circle, 1 - 1e-6", scheme, limit * (1 - Fraction(1, 10**6)), None),
        ("dense, circle, 0.9", dense, Fraction(computed.low) * SHARE, None),
    ]
    for name, block, upper, theta in cases:
        proposing, verifying, length = certified(block, upper, theta)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"order {2 * CELLS + 1}: {name:<22} proposed {proposing:5.1f} s, verified {verifying:5.1f} s, ", end="")
        print(f"{length / 1e6:.1f} MB of JSON, {peak:.0f} MB of memory")
        holds = holds and proposing + verifying < SECONDS and peak < MEGABYTES
    return holds


def main() -> int:
    """Order 401, then order 41 against Clarabel; 1 if a claim does not hold."""
    holds = [large(), against_clarabel()]
    print("holds" if all(holds) else "DOES NOT HOLD")
    return 0 if all(holds) else 1


if __name__ == "__main__":
    sys.exit(main())

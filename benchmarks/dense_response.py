"""Claim: the frequency response of a dense block is python-control's, at least 10 times faster.

Two blocks of 401 states at 2000 frequencies: a stable random one, every entry of its matrix nonzero, and the scheme of
the paper's rod stored densely.  Ours reduces the matrix to Hessenberg form and then solves in order n^2 operations a
frequency, once with the input and once, transposed, with the output, which also gives an estimate of the error;
python-control without slycot solves a dense system of equations for each frequency.  The values must agree to 1e-9
relative, for the rod's scheme ours also with its closed form, and there within the estimate (and
the rounding of the closed form, 1e-13).  Each at its best, since
other work on the machine can slow dense solves down: our fastest of several runs, the reductions included, and
python-control's fastest batch times the number of batches.
"""

import sys
import time

import control
import numpy as np

from lure.plants.state_space import StateSpace
from lure.rod import builtin_system, upwind

STATES, FREQUENCIES, BATCH = 401, 2000, 100
TOLERANCE, SPEED = 1e-9, 10


def random_block() -> StateSpace:
    """A full random matrix, shifted so that its rightmost eigenvalue is at -1/2."""
    generator = np.random.default_rng(7)
    A = generator.standard_normal((STATES, STATES))
    A -= (np.linalg.eigvals(A).real.max() + 0.5) * np.eye(STATES)
    return StateSpace(A, generator.standard_normal(STATES), generator.standard_normal(STATES))


def compared(name: str, block: StateSpace, omega: np.ndarray, exact: np.ndarray | None = None) -> bool:
    """Print both times and their ratio; whether values agree and the ratio is as claimed."""
    runs = []
    for _ in range(20):
        fresh = StateSpace(block.A, block.B, block.C)
        start = time.perf_counter()
        ours = fresh.frequency_response(omega)
        runs.append(time.perf_counter() - start)
    fast, runs = min(runs), []
    system, theirs = block.to_control(), np.empty(FREQUENCIES, dtype=complex)
    for first in range(0, FREQUENCIES, BATCH):
        batch = slice(first, first + BATCH)
        start = time.perf_counter()
        theirs[batch] = control.frequency_response(system, omega[batch]).frdata.ravel()
        runs.append(time.perf_counter() - start)
        print(f"python-control: {first + BATCH:4d} of {FREQUENCIES} frequencies, {sum(runs):.0f} s", file=sys.stderr)
    slow = min(runs) * len(runs)

    difference = float(np.max(np.abs(ours.response - theirs) / np.abs(theirs)))
    print(f"{name}: {block.order} states, {FREQUENCIES} frequencies from {omega[0]:.3g} to {omega[-1]:.3g} rad/s")
    print(f"  ours             {fast:.3g} s")
    print(f"  python-control   {slow:.3g} s, largest relative difference {difference:.1e}   (claim: {TOLERANCE:.0e})")
    print(f"  ratio            {slow / fast:,.0f}   (claim: at least {SPEED})")
    holds = difference <= TOLERANCE and slow >= SPEED * fast
    if exact is not None:
        away, estimate = np.abs(ours.response - exact), np.asarray(ours.error) + 1e-13 * np.abs(exact)
        worst, share = float(np.max(away / np.abs(exact))), float(np.max(away / estimate))
        print(f"  closed form      largest relative difference {worst:.1e}, {share:.2f} of the estimate")
        holds = holds and worst <= TOLERANCE and share <= 1
    return holds


def main() -> int:
    """Compare values, then times, for both blocks; 1 if the claim does not hold."""
    rod = builtin_system("paper-rod").rod
    scheme = upwind(rod, (STATES - 1) // 2)
    dense = StateSpace(scheme.block.dense(), scheme.block.b1, scheme.block.c)
    omega = np.geomspace(1e-3 / rod.travel_time, 4.0 * scheme.rate, FREQUENCIES)
    holds = [
        compared("random", random_block(), np.geomspace(1e-2, 1e3, FREQUENCIES)),
        compared("rod", dense, omega, scheme.transfer(1j * omega)),
    ]
    print("holds" if all(holds) else "DOES NOT HOLD")
    return 0 if all(holds) else 1


if __name__ == "__main__":
    sys.exit(main())

"""Claim: the closed form gives python-control's frequency response, at least 1000 times faster.

The paper's rod, 200 cells (401 states), 2000 frequencies from a thousandth of ``1/T`` to four times the rate
``s = c N/L`` of the scheme; values the same to 1e-8 relative.  At zero itself the response has a pole and there is
nothing to compare.  python-control solves a dense system for each frequency; sparse solves of the same matrices are
timed too, so that nobody takes the ratio for more than it is.  Each at its best, since other work on the machine can
slow dense solves down tenfold: the fastest of several runs, and python-control's fastest batch times their number.
"""

import sys
import time

import control
import numpy as np

from lure.rod import builtin_system, upwind

CELLS, FREQUENCIES, BATCH = 200, 2000, 100
TOLERANCE, SPEED = 1e-8, 1000


def main() -> int:
    """Compare values, then times; 1 if the claim does not hold."""
    rod = builtin_system("paper-rod").rod
    scheme = upwind(rod, CELLS)
    omega = np.geomspace(1e-3 / rod.travel_time, 4.0 * scheme.rate, FREQUENCIES)

    runs = []
    for _ in range(20):
        start = time.perf_counter()
        ours = scheme.transfer(1j * omega)
        runs.append(time.perf_counter() - start)
    closed, runs = min(runs), []
    for _ in range(3):
        start = time.perf_counter()
        solved = scheme.block.transfer(1j * omega)
        runs.append(time.perf_counter() - start)
    sparse, runs = min(runs), []
    system, theirs = scheme.to_control(), np.empty(FREQUENCIES, dtype=complex)
    for first in range(0, FREQUENCIES, BATCH):
        batch = slice(first, first + BATCH)
        start = time.perf_counter()
        theirs[batch] = control.frequency_response(system, omega[batch]).frdata.ravel()
        runs.append(time.perf_counter() - start)
        print(f"python-control: {first + BATCH:4d} of {FREQUENCIES} frequencies, {sum(runs):.0f} s", file=sys.stderr)
    dense = min(runs) * len(runs)

    difference = float(np.max(np.abs(ours - theirs) / np.abs(theirs)))
    second = float(np.max(np.abs(ours - solved) / np.abs(solved)))
    print(f"N = {CELLS}, {FREQUENCIES} frequencies from {omega[0]:.3g} to {omega[-1]:.3g} rad/s")
    print(f"closed form      {closed:.3g} s")
    print(f"python-control   {dense:.3g} s, largest relative difference {difference:.1e}   (claim: {TOLERANCE:.0e})")
    print(f"sparse solves    {sparse:.3g} s, largest relative difference {second:.1e}")
    print(f"ratio            {dense / closed:,.0f} to python-control   (claim: at least {SPEED:,})")
    print(f"                 {sparse / closed:,.0f} to sparse solves")
    holds = max(difference, second) <= TOLERANCE and dense >= SPEED * closed
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

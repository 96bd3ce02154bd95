"""Claim: Popov's inequality certified over ALL frequencies costs less than a look at it on a grid.

The paper's rod, 200 cells, nonlinearities of every stiffness (sector ``[0, inf)``).  Ours: verdict, margin, its
frequency and the smallest multiplier, in ball arithmetic.  Usual practice: the least value of ``Re[(1 + i omega theta)
H(i omega)]`` on 1000 frequencies, ``H`` by python-control.  The grid's minimum may not lie below the certified bound,
and not further above it than neighbouring points differ.  Each at its best, since other work on the machine can slow
dense solves down tenfold: the fastest of five runs, and the fastest of ten batches of the grid, times ten.

Then the same question with a multiplier one millionth too small: the inequality fails near zero, the grid passes it.
"""

import math
import sys
import time

import control
import numpy as np

from lure import Sector
from lure.analysis.rod.popov import rod_popov_criterion as popov_criterion
from lure.rod import builtin_system, upwind

CELLS, FREQUENCIES, BATCH = 200, 1000, 100
EVERY_STIFFNESS = Sector(0, math.inf)
ROUNDING = 1e-6  # of the grid's values, relative: python-control's error after the cancellation in the real part


def main() -> int:
    """Compare answers, then times; 1 if they disagree or the grid is faster."""
    rod = builtin_system("paper-rod").rod
    scheme = upwind(rod, CELLS)

    runs = []
    for _ in range(5):
        start = time.perf_counter()
        found = popov_criterion(scheme, EVERY_STIFFNESS)
        runs.append(time.perf_counter() - start)
    ours, runs = min(runs), []
    if found.theta is None or found.margin is None or found.smallest_theta is None:
        print(f"no inequality to compare: {found}")
        return 1
    theta, margin, smallest = found.theta, found.margin, found.smallest_theta

    system, parts = scheme.to_control(), []
    omega = np.geomspace(1e-3 / rod.travel_time, 4.0 * scheme.rate, FREQUENCIES)
    for first in range(0, FREQUENCIES, BATCH):
        start = time.perf_counter()
        parts.append(control.frequency_response(system, omega[first : first + BATCH]).frdata.ravel())
        runs.append(time.perf_counter() - start)
        print(f"python-control: {first + BATCH:4d} of {FREQUENCIES} frequencies, {sum(runs):.0f} s", file=sys.stderr)
    peer = min(runs) * len(runs)
    response = np.concatenate(parts)
    values = ((1.0 + 1j * omega * theta) * response).real
    lowest = int(np.argmin(values))
    near = values[max(lowest - 1, 0) : lowest + 2]
    resolution = float(near.max() - near.min())
    above = float(values[lowest]) - margin.low
    agrees = -ROUNDING * margin.low <= above <= resolution + ROUNDING * margin.low

    print(f"N = {CELLS}, sector {EVERY_STIFFNESS}, theta = {theta:.6g} s")
    print(f"certified      {margin.low:.9g} m/Pa at {found.worst_frequency:.6g} rad/s, {found.verdict}")
    print(f"               bracket {margin.width:.0e} wide; smallest theta {smallest.low:.9g} s")
    print(f"grid minimum   {values[lowest]:.9g} m/Pa at {omega[lowest]:.6g} rad/s")
    print(f"               {above:+.1e} from the bound, where neighbouring points differ by {resolution:.1e}")
    print("the two agree" if agrees else "THE TWO DISAGREE")
    print(f"python-control on the grid   {peer:.3g} s")
    print(f"certified                    {ours:.3g} s")
    print(f"ratio                        {peer / ours:,.0f}")

    short = (1.0 - 1e-6) * smallest.low
    failing = popov_criterion(scheme, EVERY_STIFFNESS, theta=short)
    seen = float(((1.0 + 1j * omega * short) * response).real.min())
    true = failing.margin.high if failing.margin else math.nan
    print("What a grid can never say: that nothing dips below zero between, below or above its points.")
    print(f"With theta = {short:.6f} s its minimum is {seen:+.3g} m/Pa, and the inequality seems to hold;")
    print(f"the true one is {true:+.3g} m/Pa, towards {failing.worst_frequency:g} rad/s: {failing.verdict}.")
    holds = agrees and peer > ours and seen > 0 > true
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

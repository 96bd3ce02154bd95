"""Claim: ``max_slope`` takes at most 5 times as long as ``max_sector`` where Park's criterion closes the gap.

And all of ``analyse`` takes under half a second for a loop of order 5.

Third-order plants on which Popov's criterion stops short of the Hurwitz limit and Park's reaches it, both sides
certified and closed; processor time, medians over plants.  No plant is asked about twice: nothing is remembered.
"""

import statistics
import sys
import time
from collections.abc import Callable
from fractions import Fraction

from lure import RationalPlant
from lure.analysis.questions import analyse, max_sector, max_slope

RATIO, LIMIT = 5.0, 0.5


def park(n: int) -> RationalPlant:
    """``(2 s^2 - s)/(s^3 + 2 s^2 + a s + 1)``, ``a`` near 2."""
    return RationalPlant([2, -1, 0], [1, 2, 2 + Fraction(n, 100), 1])


def fifth(n: int) -> RationalPlant:
    """``(s + 3)/((s + 1)(s + 2)(s^2 + s + a)(s + 5))``, ``a`` near 4."""
    a, den = 4 + Fraction(n, 100), [Fraction(1)]
    for factor in ([1, 1], [1, 2], [1, 1, a], [1, 5]):
        product = [Fraction(0)] * (len(den) + len(factor) - 1)
        for i, left in enumerate(den):
            for j, right in enumerate(factor):
                product[i + j] += left * right
        den = product
    return RationalPlant([1, 3], den)


def seconds(work: Callable[[], object]) -> float:
    """Processor time."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> int:
    """Ask, time, and say whether both claims hold."""
    max_slope(park(0)), analyse(fifth(0))  # what is imported and compiled once
    sectors, slopes, tables, closed = [], [], [], True
    for n in range(1, 12):
        block = park(n)
        sectors.append(seconds(lambda block=block: max_sector(block)))
        begun = time.process_time()
        found = max_slope(block)
        slopes.append(time.process_time() - begun)
        closed = closed and found.closed and found.criterion == "park"
        tables.append(seconds(lambda n=n: analyse(fifth(n))))
    sector, slope, table = (statistics.median(times) for times in (sectors, slopes, tables))
    print(f"max_sector: {sector * 1e3:.1f} ms; max_slope: {slope * 1e3:.1f} ms, {slope / sector:.1f} times")
    print(f"  closed by Park's criterion in every case: {closed}   (claim: at most {RATIO:g} times)")
    print(f"analyse, order 5: {table:.3f} s   (claim: under {LIMIT:g} s)")
    holds = closed and slope <= RATIO * sector and table < LIMIT
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

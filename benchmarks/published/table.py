"""Published numbers against ours, one line each: ours, theirs, ratio, evidence.  ``make benchmarks-table`` runs it.

Ends with status 1 if a published number is missed by more than one part in a thousand, or a proof of ours exceeds the
smallest published counterexample.
"""

from __future__ import annotations

import math
import sys
import time

from plants import Row, rows

from lure.analysis.questions import max_sector, max_slope
from lure.analysis.theorems.popov import popov_largest
from lure.analysis.verdict import Verdict
from lure.plants import as_plant

SLACK = 1e-3


def ours(row: Row) -> tuple[float, str]:
    """Our number for a row, and what it rests on."""
    block = as_plant((row.num, row.den), dt=row.dt)
    if row.nonnegative:
        found = popov_largest(block, sign="nonnegative")
        return found.largest.low, str(found.evidence)
    if row.criterion == "refuted":
        answer = max_slope(block, odd=row.odd, criterion="circle")
        assert answer.refuted_at is not None
        assert answer.witness is not None
        return answer.refuted_at, str(answer.witness.evidence)
    if row.criterion in ("circle", "popov", "hurwitz"):
        answer = max_sector(block, criterion=row.criterion)
        return (answer.hurwitz if row.criterion == "hurwitz" else answer.largest).low, str(answer.evidence)
    answer = max_slope(block, odd=row.odd, criterion=row.criterion, search="linear")
    return (answer.largest.low if answer.verdict is Verdict.PROVED else 0.0), str(answer.evidence)


def ratio(value: float, theirs: float) -> float:
    """Ours over theirs; 1 where both are infinite."""
    if math.isinf(value) and math.isinf(theirs):
        return 1.0
    return value / theirs


def main() -> int:
    """Print the table; the status says whether every number was reached."""
    short = 0
    print(f"{'plant':<24} {'criterion':<12} {'class':<9} {'ours':>14} {'theirs':>12} {'ratio':>10}  evidence   seconds")
    for row in rows():
        start = time.perf_counter()
        value, evidence = ours(row)
        kind = "odd" if row.odd else "theta>=0" if row.nonnegative else ""
        share = ratio(value, row.theirs)
        good = share <= 1 + SLACK if row.criterion == "refuted" else share >= 1 - SLACK
        short += not good
        print(
            f"{row.plant:<24} {row.criterion:<12} {kind:<9} {value:>14.9g} {row.theirs:>12.9g} {share:>10.6f}  "
            f"{evidence:<10} {time.perf_counter() - start:6.2f}{'' if good else '  SHORT'}",
            flush=True,
        )
    print(f"{short} of {len(rows())} fall short" if short else f"all {len(rows())} reached")
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main())

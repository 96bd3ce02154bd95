"""Claim: keeping the answers of a sweep costs at most 5 % of computing them, two processes share the work, rows agree.

The peer is a bare loop over the same points, in the same process, which keeps nothing and reads the system once, as
the sweep does.  Processor time; each is run twice, in turn, and the least counts.  What a sweep does besides, a
row in 1000 computed again and rechecked from the file on, is left out.  Two processes are timed by the clock, start of
both included, against one: at least 1.4 times as fast where two processors are free.  What the start takes, which is
the same for a million rods, is timed by a study of two chunks of one rod, and the ratio without it is printed besides.
"""

import sys
import tempfile
import time
import warnings
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np

from lure.analysis.sweeps import run as runs
from lure.analysis.sweeps import sweep
from lure.analysis.sweeps.reading import study_of
from lure.analysis.sweeps.rows import answered
from lure.analysis.sweeps.run import opened

SHARE, QUICKER, POINTS, RUNS = 1.05, 1.4, 20_000, 2
TABLES = {
    "system": "paper-rod",
    "ask": "rod",
    "over": {
        "rod.damping": {"from": 1e-4, "to": 1e-1, "count": POINTS // 4, "spacing": "log"},
        "rod.compliance": {"from": 0.1, "to": 10, "count": 4, "spacing": "log"},
    },
}


def start() -> float:
    """Seconds by the clock from which two processes are asked for two rods until both are answered."""
    two = {**TABLES, "over": {"rod.damping": [1e-4, 1e-1]}}
    with tempfile.TemporaryDirectory() as folder, mock.patch.object(runs, "computed_again", return_value=0):
        at = time.monotonic()
        sweep(replace(study_of(two), chunk_points=1), Path(folder) / "two.zarr", workers=2)
        return time.monotonic() - at


def main() -> int:
    """Run both in turn, compare every row, and say whether the claim holds."""
    warnings.simplefilter("ignore")  # Zarr's about data types
    study = study_of(TABLES)
    places = [place for number in range(study.chunks) for place in study.of_chunk(number)]
    answered(study.source, places[0], "rod")  # what is imported once
    bare, whole, clock, same = [], [], {1: list[float](), 2: list[float]()}, True
    for _ in range(RUNS):
        begun = time.process_time()
        rows = [answered(study.source, place, "rod").row for place in places]
        bare.append(time.process_time() - begun)
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(runs, "computed_again", return_value=0):
            begun, at = time.process_time(), time.monotonic()
            sweep(study, Path(folder) / "study.zarr")
            whole.append(time.process_time() - begun)
            clock[1].append(time.monotonic() - at)
            at = time.monotonic()
            sweep(study, Path(folder) / "two.zarr", workers=2)
            clock[2].append(time.monotonic() - at)
            data = opened(Path(folder) / "study.zarr").load()
        for name in ("slowest_decay", "theta", "circle"):
            same = same and np.array_equal(data[name].values.ravel(), [row[name] for row in rows])
        same = same and [row["verdict"] for row in rows] == list(data["verdict"].values.ravel())
    loop, kept, quicker = min(bare), min(whole), min(clock[1]) / min(clock[2])
    print(f"{POINTS} rods: {kept / POINTS * 1e3:.2f} ms each, without keeping anything {loop / POINTS * 1e3:.2f} ms")
    print(f"  ratio {kept / loop:.3f}   (claim: at most {SHARE:g}); every row is the same: {same}")
    begun = min(start() for _ in range(RUNS))
    print(f"  two processes are {quicker:.2f} times as fast as one   (claim: at least {QUICKER:g})")
    print(f"  without their start, {begun:.1f} s: {min(clock[1]) / (min(clock[2]) - begun):.2f} times")
    holds = same and kept <= SHARE * loop and quicker >= QUICKER
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

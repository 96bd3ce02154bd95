"""Claim: keeping the answers of a sweep costs at most 5 % of computing them, two processes share the work, rows agree.

The peer is a bare loop over the same points, in the same process, which keeps nothing and reads the system once, as
the sweep does.  Processor time, of which the speed of a processor shared with others drifts by more than the claim:
so the loop takes the points of two chunks between the two of the sweep, and the sums over two whole runs are
compared.  What a sweep does besides, a row in 1000 computed again and rechecked from the file on, is left out.  Two
processes are timed by the clock, start of both included, against one, each run in a process of its own that has
started none yet: at least 1.4 times as fast where two processors are free.  What the start takes, which is the same for
a million rods, is timed by a study of two chunks of one rod, and the ratio without it is printed besides.
"""

import gc
import multiprocessing
import sys
import tempfile
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any
from unittest import mock

from lure.analysis.sweeps import run as runs
from lure.analysis.sweeps import sweep
from lure.analysis.sweeps.reading import study_of
from lure.analysis.sweeps.rows import answered
from lure.analysis.sweeps.run import opened
from lure.analysis.sweeps.study import Study

COMPARED = ("verdict", "slowest_decay", "theta", "circle")
SHARE, QUICKER, POINTS, RUNS = 1.05, 1.4, 20_000, 2
TABLES = {
    "system": "paper-rod",
    "ask": "rod",
    "over": {
        "rod.damping": {"from": 1e-4, "to": 1e-1, "count": POINTS // 4, "spacing": "log"},
        "rod.compliance": {"from": 0.1, "to": 10, "count": 4, "spacing": "log"},
    },
}


TWO = {**TABLES, "chunk": 1, "over": {"rod.damping": [1e-4, 1e-1]}}


def clocked(tables: dict[str, Any], store: Path, workers: int) -> float:
    """Seconds by the clock of a sweep in this process, of a study that was read, without what is computed again."""
    warnings.simplefilter("ignore")  # Zarr's about data types
    study = study_of(tables)
    with mock.patch.object(runs, "computed_again", return_value=0):
        at = time.monotonic()
        sweep(study, store, workers=workers)
        return time.monotonic() - at


def seconds_of(tables: dict[str, Any], store: Path, workers: int) -> float:
    """The same in a process that has started no other before."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as alone:
        return alone.submit(clocked, tables, store, workers).result()


def start(workers: int) -> float:
    """Seconds by the clock from which processes are asked for two rods until both are answered."""
    with tempfile.TemporaryDirectory() as folder:
        return seconds_of(TWO, Path(folder) / "two.zarr", workers)


class Beside:
    """A bare loop over the points of a chunk that a sweep has just done, and of the one that it does next."""

    def __init__(self, study: Study) -> None:
        self.study, self.rows, self.seconds, self.chunks = study, list[tuple[object, ...]](), 0.0, 0

    def __call__(self, stage: str, done: float) -> None:
        """Take what is done now and was not before, whenever the sweep says how far it is."""
        over = round(done * self.study.chunks)
        while self.chunks < min(over + over % 2, self.study.chunks):
            places = list(self.study.of_chunk(self.chunks))
            begun = time.process_time()
            rows = [answered(self.study.source, place, "rod").row for place in places]
            self.seconds += time.process_time() - begun
            self.rows += [tuple(row[name] for name in COMPARED) for row in rows]
            self.chunks += 1


def main() -> int:
    """Run both in turn, compare every row, and say whether the claim holds."""
    warnings.simplefilter("ignore")  # Zarr's about data types
    study = study_of(TABLES)
    with tempfile.TemporaryDirectory() as folder:
        clocked(TWO, Path(folder) / "two.zarr", 1)  # what is imported once
    gc.freeze()  # and not looked through for garbage, which would cost one of the two a fifth of a second now and then
    loop, kept, clock, same = 0.0, 0.0, {1: list[float](), 2: list[float]()}, True
    for _ in range(RUNS):
        beside = Beside(study)
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(runs, "computed_again", return_value=0):
            begun = time.process_time()
            sweep(study, Path(folder) / "study.zarr", progress=beside)
            kept += time.process_time() - begun - beside.seconds
            loop += beside.seconds
            for workers, found in clock.items():
                found.append(seconds_of(TABLES, Path(folder) / f"{workers}.zarr", workers))
            data = opened(Path(folder) / "2.zarr").load()
        kept_rows = zip(*(data[name].values.ravel().tolist() for name in COMPARED), strict=True)
        same = same and list(kept_rows) == beside.rows
    quicker, points = min(clock[1]) / min(clock[2]), RUNS * POINTS
    print(f"{POINTS} rods: {kept / points * 1e3:.2f} ms each, without keeping anything {loop / points * 1e3:.2f} ms")
    print(f"  ratio {kept / loop:.3f}   (claim: at most {SHARE:g}); every row is the same: {same}")
    starts = {workers: min(start(workers) for _ in range(RUNS)) for workers in clock}
    alone = (min(clock[1]) - starts[1]) / (min(clock[2]) - starts[2])
    print(f"  two processes are {quicker:.2f} times as fast as one   (claim: at least {QUICKER:g})")
    print(f"  without the start, {starts[1]:.1f} s of one and {starts[2]:.1f} s of two: {alone:.2f} times")
    holds = same and kept <= SHARE * loop and quicker >= QUICKER
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

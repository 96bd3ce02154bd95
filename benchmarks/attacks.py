"""Claim: of random loops of all kinds, attacked by means of their own, no answer is false.

Loop ``i`` of a kind follows from the seed alone.  Each is asked about in two forms.  What is PROVED is attacked by
constant gains in balls, gains that jump, functions with corners, periodic solutions, dead times by the method of steps,
extreme members, plants of a box, values of a formula at many digits; what is REFUTED is replayed; both checkers see
every certificate, and two forms may not contradict each other.  ``campaign/`` has the attacks; none uses a multiplier,
a Lyapunov function of a proof or a search of the house.

``python attacks.py`` takes 100 000 loops of low order, on all processors, and of the other kinds what 20 s allow;
``--state FILE --seconds 3600`` goes on where ``FILE`` ends, a line a chunk of loops.  ``--kind KIND --loop I`` takes
one loop alone and says what it is, ``--table FILE`` adds up a file.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))  # attacks on several channels
from campaign.draws import SMALL
from campaign.kinds import KINDS, attack

SEED, CHUNK, CPU = 20261123, 50, 60.0  # [s] of a processor for one loop
LOW, SLICE = 100_000, 20.0  # loops of low order; [s] for the others
MOST = max(kind.share for kind in KINDS.values())


class OverTimeError(BaseException):
    """The processor time of a loop is over; no ``except Exception`` may hold it up."""


def expired(*_: object) -> None:
    """End the loop at hand."""
    raise OverTimeError


def random_of(kind: str, i: int) -> np.random.Generator:
    """The random numbers of loop ``i`` of a kind."""
    return np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(list(KINDS).index(kind), i)))


def guarded(kind: str, i: int) -> tuple[Counter[str], list[str]]:
    """The counts and the faults of a loop, whatever happens in it."""
    case: object = ""
    counts: Counter[str] = Counter()
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        try:
            signal.setitimer(signal.ITIMER_PROF, CPU)
            counts, faults, case = attack(kind, random_of(kind, i))
        except OverTimeError:
            faults = [f"not done within {CPU:g} s"]
        except Exception:  # whatever an attack raises is a fault, with its trace
            faults = [traceback.format_exc()]
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
    if np.geterrcall() is not None:  # an alarm within numpy's own routines; one loop is told of it, not all after it
        faults.append(f"left behind: {np.seterrcall(None)}")
    ours = [each for each in given if "/campaign/" not in each.filename]
    faults += sorted({f"{each.filename}:{each.lineno}: {each.message}" for each in ours})
    return counts + Counter(loops=1), [f"{kind} {i}: {said}  [{case}]" for said in faults]


def done(path: Path | None) -> tuple[Counter[str], dict[str, Counter[str]], list[str]]:
    """How far each kind has come in a file, its counts, and all faults; a line that was cut short is left out."""
    ends: Counter[str] = Counter()
    counts: dict[str, Counter[str]] = {}
    faults: list[str] = []
    for line in path.read_text(encoding="utf-8").splitlines() if path and path.exists() else []:
        try:
            chunk = json.loads(line)
        except ValueError:
            continue
        if chunk["from"] != ends[chunk["kind"]]:
            continue
        ends[chunk["kind"]] = chunk["to"]
        counts.setdefault(chunk["kind"], Counter()).update(chunk["counts"])
        faults += chunk["faults"]
    return ends, counts, faults


def kept(state: Path, chunk: dict[str, object]) -> None:
    """Add a chunk to a file; what a campaign that was killed left of a line gets its end first."""
    with state.open("ab+") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - 1))
        torn = file.read() not in (b"", b"\n")
        file.write(b"\n" * torn + json.dumps(chunk).encode() + b"\n")
        file.flush()
        os.fsync(file.fileno())


def campaign(state: Path | None, seconds: float, kinds: list[str], loops: int) -> int:
    """Take chunk after chunk and say what was found; the number of faults."""
    return summary(*run(state, seconds, kinds, loops))


def summary(counts: dict[str, Counter[str]], faults: list[str]) -> int:
    """Print what was found; the number of faults."""
    table(counts)
    loops = sum(found["loops"] for found in counts.values())
    print(f"{loops} loops, {len(faults)} faults   (claim: 0)")
    return len(faults)


def of_low_order(kind: str) -> tuple[dict[str, Counter[str]], list[str]]:
    """The first loops of a kind, its share of all of low order."""
    signal.signal(signal.SIGPROF, expired)
    return run(None, math.inf, [kind], math.ceil(LOW / len(SMALL)))


def run(state: Path | None, seconds: float, kinds: list[str], loops: int) -> tuple[dict[str, Counter[str]], list[str]]:
    """Take chunk after chunk, the kind that is farthest behind its share first; the counts and the faults."""
    ends, counts, faults = done(state)
    start, total = time.monotonic(), sum(ends.values())
    while time.monotonic() - start < seconds and sum(ends.values()) - total < loops:
        kind = min(kinds, key=lambda name: ends[name] / KINDS[name].share)
        size = max(1, round(CHUNK * KINDS[kind].share / MOST))
        tick, found, wrong = time.process_time(), Counter[str](), []
        for i in range(ends[kind], ends[kind] + size):
            more, said = guarded(kind, i)
            found += more
            wrong += said
        chunk = {"kind": kind, "from": ends[kind], "to": ends[kind] + size, "counts": found, "faults": wrong}
        chunk["cpu"] = round(time.process_time() - tick, 3)
        for said in wrong:
            print(said, flush=True)
        if state is not None:
            kept(state, chunk)
        ends[kind] += size
        counts.setdefault(kind, Counter()).update(found)
        faults += wrong
    return counts, faults


def table(counts: dict[str, Counter[str]]) -> None:
    """What was asked, answered and attacked, a line for each kind."""
    print(
        f"{'kind':<16}{'loops':>8}{'PROVED':>8}{'REFUTED':>9}{'open':>7}{'certificates':>14}{'attacks':>9}{'replayed':>10}"
    )
    for kind, found in counts.items():
        attacks = sum(n for name, n in found.items() if name.startswith("attack"))
        print(
            f"{kind:<16}{found['loops']:>8}{found['PROVED']:>8}{found['REFUTED']:>9}{found['INCONCLUSIVE']:>7}"
            f"{found['certificates']:>14}{attacks:>9}{found['replayed'] - found['not replayed']:>10}"
        )


def main() -> int:
    """Run the campaign; 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--state", type=Path, help="the file that chunks are added to; without it nothing is kept")
    parser.add_argument("--seconds", type=float, help="how long; without it and --loops see above")
    parser.add_argument("--loops", type=int, help="how many")
    parser.add_argument("--kind", action="append", choices=list(KINDS))
    parser.add_argument("--loop", type=int, help="this one alone, of the kind given")
    parser.add_argument("--table", type=Path, help="add up what a file has")
    chosen = parser.parse_args()
    signal.signal(signal.SIGPROF, expired)
    if chosen.loop is not None:
        counts, faults = guarded(chosen.kind[0], chosen.loop)
        print(json.dumps(counts, indent=1), *faults, sep="\n")
        return bool(faults)
    if chosen.table:
        _, found, faults = done(chosen.table)
        table(found)
        print(f"{len(faults)} faults", *faults, sep="\n")
        return bool(faults)
    if chosen.seconds is not None or chosen.loops is not None:
        seconds = math.inf if chosen.seconds is None else chosen.seconds
        return bool(campaign(chosen.state, seconds, chosen.kind or list(KINDS), chosen.loops or 10**9))
    with ProcessPoolExecutor() as pool:
        found = [
            *pool.map(of_low_order, SMALL),
            run(chosen.state, SLICE, [kind for kind in KINDS if kind not in SMALL], 10**9),
        ]
    counts = {kind: one for more, _ in found for kind, one in more.items()}
    return bool(summary(counts, [fault for _, faults in found for fault in faults]))


if __name__ == "__main__":
    sys.exit(main())

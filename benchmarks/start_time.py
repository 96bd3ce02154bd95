"""Claim: ``import lure`` takes at most 0.3 s more than ``import numpy``, ``lure --help`` 0.5 s more than bare Python.

Whole processes of the same interpreter, in turns; the first round, which warms the caches, is not counted.  Compared by
their medians, and beside them the peer, ``import control``.
"""

import statistics
import subprocess
import sys
import time

ROUNDS = 15
COMMANDS = {
    "python -c pass": ("-c", "pass"),
    "import numpy": ("-c", "import numpy"),
    "import lure": ("-c", "import lure"),
    "import control": ("-c", "import control"),
    "lure --help": ("-m", "lure.analysis.cli", "--help"),
}
CLAIMS = [("import lure", "import numpy", 0.3), ("lure --help", "python -c pass", 0.5)]


def seconds(arguments: tuple[str, ...]) -> float:
    """Wall time of one process that has to succeed."""
    start = time.perf_counter()
    subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
    return time.perf_counter() - start


def main() -> int:
    """Time all of them in turns; 1 if a claim does not hold."""
    rounds = [{name: seconds(arguments) for name, arguments in COMMANDS.items()} for _ in range(1 + ROUNDS)][1:]
    median = {name: statistics.median(times[name] for times in rounds) for name in COMMANDS}
    for name, value in median.items():
        print(f"{name:<15} {value:.3f} s, median of {ROUNDS}")
    holds = True
    for name, base, limit in CLAIMS:
        more = median[name] - median[base]
        holds = holds and more <= limit
        print(f"{name}: {more:.3f} s more than {base}   (claim: at most {limit:g})")
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

"""Claim: with warm caches the report takes at most 6 times as long as importing what it stands on.

``make report`` (the command behind it, if this runs outside the environment that make keeps) against
``python -c "import control, matplotlib.pyplot, sympy"``: whole processes of the same interpreter, in turns; the first
pair, which warms the caches, is not counted.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ROUNDS, RATIO = 5, 6.0
IMPORTS = "import control, matplotlib.pyplot, sympy"


def seconds(command: list[str]) -> float:
    """Wall time of a command that has to succeed."""
    environment = {
        name: value for name, value in os.environ.items() if name not in {"MAKEFLAGS", "MAKELEVEL", "MFLAGS"}
    }
    start = time.perf_counter()
    subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, check=True)
    return time.perf_counter() - start


def main() -> int:
    """Time both in turns; 1 if the claim does not hold."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "report"
        if Path(sys.prefix) == ROOT / ".venv":
            what, report = "make report", ["make", "report", f"ARGS=-o {target}"]
        else:
            what, report = "lure report", [sys.executable, "-m", "lure.analysis.cli", "report", "-o", str(target)]
        pairs = [(seconds(report), seconds([sys.executable, "-c", IMPORTS])) for _ in range(1 + ROUNDS)][1:]
        verdict = json.loads((target / "report.json").read_text(encoding="utf-8"))["conclusion"]["verdict"]
    ours, imports = (statistics.median(times) for times in zip(*pairs, strict=True))
    print(f"verdict of the report: {verdict}")
    print(f"{what:<13} {ours:.2f} s, median of {ROUNDS}")
    print(f"the imports   {imports:.2f} s")
    print(f"ratio         {ours / imports:.2f}   (claim: at most {RATIO:g})")
    holds = verdict == "PROVED" and ours <= RATIO * imports
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

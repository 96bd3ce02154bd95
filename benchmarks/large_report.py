"""Claim: a report for 100 000 cells needs less than 1 GB and less than a minute.

``lure report`` with everything but the simulation, which is skipped and said to be.  Memory is the peak of the child
process.  There is no peer to time: the dense matrix that python-control would need has 3.2e11 bytes.  Checked instead:
all verdicts are there, and with a stiff obstacle, where the margin is the response's own, that of the scheme has come
within a tenth of the rod's; the smallest multiplier is the same for every number of cells.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CELLS, MEMORY, SECONDS = 100_000, 1e9, 60.0
NEAR = {"margin": 0.1, "smallest_theta": 1e-6}
CHANGES = [f"discretisation.cells={CELLS}", "rod.compliance=1e-12"]


def main() -> int:
    """Write the report in a child process and look at it; 1 if the claim does not hold."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "report"
        command = [sys.executable, "-m", "lure.analysis.cli", "report", "paper-rod", "--quiet", "-o", str(target)]
        for change in CHANGES:
            command += ["--set", change]
        start = time.perf_counter()
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        elapsed = time.perf_counter() - start
        if run.returncode:
            print(run.stderr)
            return 1
        report = json.loads((target / "report.json").read_text(encoding="utf-8"))
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * (1 if sys.platform == "darwin" else 1024)

    popov = {row["model"]: row for row in report["criteria"] if row["name"] == "popov"}
    scheme, rod = popov["scheme"], popov["rod"]
    verdicts = {scheme["verdict"], rod["verdict"], report["conclusion"]["verdict"]}
    skipped = report["simulation"]["skipped"]
    print(
        f"N = {CELLS}, sector [0, 1e12] Pa/m; Popov: {scheme['verdict']} for the scheme, {rod['verdict']} for the rod"
    )
    for key in NEAR:
        print(f"{key:<16} {scheme[key]:.6g} in the scheme, {rod[key]:.6g} in the rod")
    print(f"simulation       {skipped or 'NOT SKIPPED'}")
    print(f"time             {elapsed:.2f} s   (claim: less than {SECONDS:.0f} s)")
    print(f"peak memory      {peak / 1e6:.0f} MB   (claim: less than {MEMORY / 1e6:.0f} MB)")
    near = all(abs(scheme[key] / rod[key] - 1.0) < tolerance for key, tolerance in NEAR.items())
    holds = verdicts == {"PROVED"} and near and bool(skipped) and elapsed < SECONDS and peak < MEMORY
    print("holds" if holds else "DOES NOT HOLD")
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())

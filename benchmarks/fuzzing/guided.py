"""The readers of ``fuzz_readers.py`` under Atheris: changes that reach new lines of ``lure`` are kept and built upon.

``python benchmarks/fuzzing/guided.py READER FOLDER STATE SECONDS`` needs Atheris 3 (``pip install atheris==3.0.0``).
``FOLDER`` holds the choices that reached something new, ``STATE`` the counts; with both a campaign goes on.
"""

from __future__ import annotations

import importlib
import sys
import time
from pathlib import Path

WATCHED = (
    *("lure.errors", "lure.exact", "lure.expressions", "lure.files", "lure.networks", "lure.nonlinearities"),
    *("lure.plants", "lure.bounds", "lure.classes", "lure.analysis.certificates.checker", "lure.analysis.measured"),
    *("lure.analysis.certificates.arithmetic", "lure.analysis.certificates.second.reading", "lure.analysis.cli"),
    *("lure.analysis.certificates.blocks", "lure.analysis.sweeps.reading"),
)


def main() -> None:
    """Fuzz until the time is over; what breaks the claim is printed and kept in ``FOLDER.faults``."""
    reader, folder, state, seconds = sys.argv[1:]
    atheris = importlib.import_module("atheris")
    sys.path.insert(0, str(Path(__file__).parents[1]))
    with atheris.instrument_imports(include=WATCHED):
        house = importlib.import_module("fuzz_readers")
        mutation = importlib.import_module("fuzzing.mutation")
        fuzz, corpus = house.readers()[reader]
        Path(folder).mkdir(parents=True, exist_ok=True)
        run = house.Campaign([reader], Path(state), Path(f"{folder}.faults"))
        end, saved = time.monotonic() + float(seconds), [time.monotonic()]

        def one(data: bytes) -> None:
            run.one(reader, fuzz, mutation.Choices(data), corpus)
            run.rounds += 1
            if time.monotonic() > min(end, saved[0] + 30):
                run.kept()
                saved[0] = time.monotonic()

        atheris.Setup([sys.argv[0], "-max_len=400", f"-max_total_time={seconds}", "-rss_limit_mb=3000", folder], one)
        house.limited()
        atheris.Fuzz()


if __name__ == "__main__":
    main()

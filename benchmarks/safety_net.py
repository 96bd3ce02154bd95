"""Claim: what the commands say stays what it was: built-in systems, random problems, certificates, published numbers.

``record DIR`` writes down, case by case, the exit status, the JSON and the certificates of every command on every
built-in system, of 5 000 random problems and of ``published/table.py``, and what both checkers say of each certificate.
``compare DIR`` puts the same questions to the code at hand and ranks what changed:

a. a verdict or an exit status, a certificate refused, no answer in time, or two results of which one must be false;
b. a bracket or the evidence is worse, or a key is gone;
c. a bracket or the evidence is better;
d. a new key;
e. anything else: words, multipliers, numbers, certificates.

Ends with status 1 if anything has rank a or b.  ``record`` takes up where it was stopped, and so does ``compare`` where
``--new`` names a folder for the answers (an empty one for each state of the code).  ``--draw N`` takes the first N
random problems and ``--only PREFIX`` the cases whose names begin so: builtin/report, random/, certificates/, published.
"""

import argparse
import contextlib
import hashlib
import io
import json
import math
import re
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from net.cases import Case, builtin_cases, random_case
from net.ranking import compare

from lure.analysis.cli import main as command

TABLE = Path(__file__).parent / "published" / "table.py"
ROW = re.compile(r"(.+?  +(?:(refuted)|\S+)(?: +(?:odd|theta>=0))?) +(\S+) +\S+ +\S+  (\w+) +[\d.]+(?:  (SHORT))?$")
PATIENCE = 4  # how many times longer than when it was recorded an answer may take before it counts as lost

Wanted = Callable[[Case], bool]


class OverTimeError(BaseException):
    """The time of a case is over; no ``except Exception`` of a command may hold it up."""


def said(*argv: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of a command."""
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as err:
        status = command(argv)
    return status, out.getvalue(), err.getvalue()


def answered(case: Case, home: Path, patience: float, judged: dict[str, str]) -> Case:
    """The case with what the command said, its certificates kept in ``home``, and the word of both checkers on them."""

    def over(_signal: int, _frame: object) -> None:
        raise OverTimeError

    with tempfile.TemporaryDirectory() as folder:
        for name, text in case["files"].items():
            Path(folder, name).write_text(text, encoding="utf-8")
        argv = [part.replace("DIR/", f"{folder}/").replace("STORED/", f"{home}/") for part in case["argv"]]
        signal.signal(signal.SIGPROF, over)
        signal.setitimer(signal.ITIMER_PROF, case["limit"] * patience, 1.0)
        try:
            status, out, err = said(*argv) if argv else published()
        except OverTimeError:
            return case | {"status": None, "out": "", "stderr": "over time", "certificates": {}, "checked": {}}
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        found: dict[str, str] = {}
        for path in sorted([*Path(folder).glob("certificate.json"), *Path(folder).glob("report/certificates/*.json")]):
            content = path.read_bytes()
            digest = hashlib.sha256(content).hexdigest()
            stored = home / "certificates" / f"{digest}.json"
            stored.parent.mkdir(parents=True, exist_ok=True)
            stored.write_bytes(content)
            base = re.sub(r"^\d+-", "", path.stem)
            found[f"{base}{sum(each.startswith(base) for each in found) or ''}"] = digest
            judged.setdefault(digest, str(said("verify", str(stored), "--second", "--json")[0]))
        out, err = (text.replace(folder, "DIR").replace(str(home), "STORED") for text in (out, err))
        checked = {name: judged[digest] for name, digest in found.items()}
        return case | {"status": status, "out": out, "stderr": err, "certificates": found, "checked": checked}


def published() -> tuple[int, str, str]:
    """The table of published numbers, as JSON: a proof should be large, a counterexample small."""
    done = subprocess.run([sys.executable, str(TABLE)], capture_output=True, text=True, check=False)
    rows: dict[str, dict[str, Any]] = {}
    for line in done.stdout.splitlines():
        if found := ROW.match(line):
            question, refuted, value, evidence, short = found.groups()
            ours = {"refuted_at": float(value)} if refuted else {"largest": [float(value), math.inf]}
            rows[" ".join(question.split())] = ours | {"evidence": evidence, "verdict": short or "reached"}
    return done.returncode, json.dumps(rows), done.stderr


def stored_cases(home: Path) -> Iterator[Case]:
    """Each stored certificate before both checkers."""
    for path in sorted((home / "certificates").glob("*.json")):
        argv = ["verify", f"STORED/certificates/{path.name}", "--second", "--json"]
        yield {"name": f"certificates/{path.name}", "argv": argv, "files": {}, "limit": 60}


def read(home: Path) -> dict[str, Case]:
    """The answered cases of a folder, by name; a last line that was cut off is none."""
    found, file = {}, home / "cases.jsonl"
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else []:
        with contextlib.suppress(ValueError):
            case = json.loads(line)
            found[case["name"]] = case
    return found


def run(cases: Iterable[Case], home: Path, *, store: Path, patience: float) -> dict[str, Case]:
    """Answer the cases that ``home`` does not hold yet; certificates of the arguments are looked for in ``store``."""
    home.mkdir(parents=True, exist_ok=True)
    done, judged = read(home), {}
    with (home / "cases.jsonl").open("a", encoding="utf-8") as file:
        file.write("\n" if done else "")  # after a line that was cut off
        for case in cases:
            if case["name"] not in done:
                place = store if case["name"].startswith("certificates/") else home
                done[case["name"]] = answered(case, place, patience, judged)
                print(json.dumps(done[case["name"]]), file=file, flush=True)
                if len(done) % 250 == 0:
                    print(f"{len(done)} cases", file=sys.stderr, flush=True)
    return done


def record(home: Path, wanted: Wanted) -> int:
    """Answer every case and let both checkers look at what was certified."""
    table = {"name": "published", "argv": [], "files": {}, "limit": 600}
    run(filter(wanted, [*builtin_cases(said), table, *map(random_case, range(5000))]), home, store=home, patience=1)
    done = run(filter(wanted, stored_cases(home)), home, store=home, patience=1)
    late = [name for name, case in done.items() if case["status"] is None]
    print(f"{len(done)} cases; {len(late)} not done in time and not compared: {' '.join(late)}")
    return 0


def compared(home: Path, new: Path, wanted: Wanted, *, rtol: float, most: int) -> int:
    """Ask again what was answered, and print the differences."""
    before = {name: case for name, case in read(home).items() if wanted(case) and case["status"] is not None}
    asked = ({key: case[key] for key in ("name", "argv", "files", "limit")} for case in before.values())
    return compare(before, run(asked, new, store=home, patience=PATIENCE), rtol=rtol, most=most)


def main() -> int:
    """Record, or compare; without arguments a few random problems, twice."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=("record", "compare"))
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--draw", type=int, default=5000, help="random problems, at most")
    parser.add_argument("--only", default="", help="cases whose names begin so")
    parser.add_argument("--new", type=Path, help="compare: folder for the answers of the code at hand")
    parser.add_argument("--rtol", type=float, default=1e-9, help="compare: smaller changes of a number are none")
    parser.add_argument("--most", type=int, default=5, help="compare: examples printed of each kind of difference")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    only, draw = (chosen.only, chosen.draw) if chosen.what else ("random/", 100)

    def wanted(case: Case) -> bool:
        name = case["name"]
        return name.startswith(only) and not (name.startswith("random/") and int(name[7:]) >= draw)

    with tempfile.TemporaryDirectory() as scratch:
        home, new = (
            (path or Path(scratch, kind)).resolve() for path, kind in ((chosen.folder, "old"), (chosen.new, "new"))
        )
        if chosen.what != "compare":
            record(home, wanted)
        return 0 if chosen.what == "record" else compared(home, new, wanted, rtol=chosen.rtol, most=chosen.most)


if __name__ == "__main__":
    sys.exit(main())

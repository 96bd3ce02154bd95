"""Claim: what is shown of the built-in loops goes into files for Coq that take less than a minute of processor each.

Every built-in loop is asked all questions (``QUESTIONS``), with classes of its own and others.  Each certificate that
an answer holds, of a proof or a refutation, is exported, and the file compiled; where there is no export the reason is
kept.  Without arguments a few questions.  ``python coq_files.py FOLDER`` asks all, goes on where ``FOLDER`` ends, and
compiles nothing twice that has not changed, for ``--seconds``; several processes may share a folder.  Seconds are those
of the processor, the lemmas that files share, compiled once, counted in each.  Ends with status 1 where a file does not
compile in time.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import math
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from lure import NonlinearityClass, Sector
from lure.analysis import analyse, certify, decay_rate, l2_gain, max_sector, max_slope, region
from lure.analysis.certificates.checker import check
from lure.analysis.export import coq_text
from lure.analysis.export.gaining import has_gain
from lure.analysis.questions.certify import ProofOptions
from lure.errors import InputError
from lure.files.builtin import builtin_loop, loop_names
from lure.files.system import LoopSystem

LIMIT, ALLOWED = 60, 60.0  # [s] of a processor for coqc, and for a question
LOOP = "(* ---- This loop ---- *)"
HEAD = "Require Import Reals ZArith List Lra Lia Bool common.\nImport ListNotations.\nOpen Scope R_scope.\n"
NAMES = re.compile(r"^(?:Definition|Fixpoint|Inductive|Lemma|Theorem) (\w+)", re.MULTILINE)
MODULES = re.compile(r"^Module (\w+)\.$.*?^End \1\.$", re.DOTALL | re.MULTILINE)
HALF, ONE, FOUR = Fraction(1, 2), Fraction(1), Fraction(4)


def several(loop: LoopSystem, one: object) -> object:
    """The class in each channel."""
    return one if loop.channels == 1 else [one] * loop.channels


def of_class(ask: Callable[..., object], one: NonlinearityClass, **more: object) -> Callable[[LoopSystem], object]:
    """A question about the plant of a loop and a class."""
    return lambda loop: ask(loop.block, several(loop, one), **more)


def slopes(k: Fraction, *, odd: bool = False) -> NonlinearityClass:
    """Slopes up to ``k``."""
    return NonlinearityClass.slope_restricted(0, k, odd=odd)


def sectors(k: Fraction, *, varying: bool = False) -> NonlinearityClass:
    """Sectors up to ``k``."""
    return NonlinearityClass(sector=Sector(0, k), time_varying=varying)


def own(ask: Callable[..., object], **more: object) -> Callable[[LoopSystem], object]:
    """A question about the loop with what it says of its nonlinearity."""
    return lambda loop: [] if loop.open else ask(loop, **more)


BY_MATRIX = ProofOptions(method="matrix", seconds=ALLOWED)
WAYS = {"ways": ProofOptions(seconds=ALLOWED)}
QUESTIONS: Mapping[str, Callable[[LoopSystem], object]] = {
    "analyse": lambda loop: analyse(loop, seconds=ALLOWED),
    "max-sector": lambda loop: [] if loop.channels > 1 else max_sector(loop.block),
    "max-sector, varying": lambda loop: [] if loop.channels > 1 else max_sector(loop.block, time_varying=True),
    "max-slope": lambda loop: [] if loop.channels > 1 else max_slope(loop.block),
    "max-slope, odd": lambda loop: [] if loop.channels > 1 else max_slope(loop.block, odd=True),
    "certify": own(certify, **WAYS),
    "sector 1/2": of_class(certify, sectors(HALF), **WAYS),
    "sector 1/2, by a matrix": of_class(certify, sectors(HALF), ways=BY_MATRIX),
    "sector 4": of_class(certify, sectors(FOUR), **WAYS),
    "sector 1, varying": of_class(certify, sectors(ONE, varying=True), **WAYS),
    "slope 1": of_class(certify, slopes(ONE), **WAYS),
    "slope 4, odd": of_class(certify, slopes(FOUR, odd=True), **WAYS),
    "gain": own(l2_gain, seconds=ALLOWED),
    "gain, sector 1/2": of_class(l2_gain, sectors(HALF), seconds=ALLOWED),
    "rate": own(decay_rate, seconds=ALLOWED),
    "rate, sector 1/2": of_class(decay_rate, sectors(HALF), seconds=ALLOWED),
    "rate, sector 1/2, varying": of_class(decay_rate, sectors(HALF, varying=True), seconds=ALLOWED),
    "region": own(region, seconds=ALLOWED),
    "region, saturation": lambda loop: region(loop.block, several(loop, "max(min(sigma, 1), -1)"), seconds=ALLOWED),
}


def certificates_in(found: object, depth: int = 6) -> Iterator[Mapping[str, Any]]:
    """All certificates in an answer."""
    held = getattr(found, "certificate", None)
    if isinstance(held, dict) and "format" in held:
        yield held
    parts = [getattr(found, name, None) for name in getattr(type(found), "__dataclass_fields__", {})]
    parts += found if isinstance(found, list | tuple) else found.values() if isinstance(found, dict) else []
    for part in parts if depth else ():
        yield from certificates_in(part, depth - 1)


def kind_of(data: Mapping[str, Any]) -> str:
    """What a certificate is, in a word or three."""
    proof, proved = data["proof"]["method"], data["verdict"] == "PROVED"
    graphs = isinstance(data["laws"], dict) and "graphs" in data["laws"]
    what = f"region, {proof}" if graphs else data["theorem"] if proved else proof
    about = ", gain" * has_gain(data) + ", rate" * ("rate" in data)
    return f"{'proved' if proved else 'refuted'}: {what}{about}"


class Folder:
    """What is known: answers in ``asked.jsonl``, compiled files in ``compiled.jsonl``, certificates beside them."""

    def __init__(self, home: Path) -> None:
        self.home = home
        (home / "certificates").mkdir(parents=True, exist_ok=True)

    def lines(self, name: str) -> dict[str, Any]:
        """The lines of a file, by their keys."""
        path = self.home / name
        rows = path.read_text("utf-8").splitlines() if path.exists() else []
        return dict(json.loads(row) for row in rows)

    def add(self, name: str, key: str, value: object) -> None:
        """A line more."""
        with (self.home / name).open("a", encoding="utf-8") as file:
            file.write(json.dumps([key, value]) + "\n")

    def ask(self, names: list[str], questions: Mapping[str, Callable[[LoopSystem], object]]) -> None:
        """Ask what was not asked yet."""
        done = self.lines("asked.jsonl")
        for name in names:
            for what, question in questions.items():
                if (key := f"{name}: {what}") in done:
                    continue
                begun, held, said = time.process_time(), list[str](), ""
                try:
                    for one in certificates_in(question(builtin_loop(name))):
                        text = json.dumps(dict(one), sort_keys=True)
                        held.append(hashlib.sha256(text.encode()).hexdigest()[:16])
                        (self.home / "certificates" / f"{held[-1]}.json").write_text(text, "utf-8")
                except InputError as error:
                    said = str(error)
                spent = time.process_time() - begun
                self.add("asked.jsonl", key, {"certificates": sorted({*held}), "said": said, "seconds": spent})

    def compile(self, text: str, end: float) -> dict[str, Any] | None:
        """Whether a file compiles, and its seconds, which another process may have found; None once it is too late."""
        key = hashlib.sha256(text.encode()).hexdigest()
        if key in (known := self.lines("compiled.jsonl")):
            return dict(known[key])
        if time.monotonic() > end:
            return None
        first, _, body = text.partition(LOOP)
        lemmas, before = self.lemmas(first.split("*)", 1)[1])
        found = NAMES.findall(MODULES.sub("", text))
        with tempfile.TemporaryDirectory() as place:
            ok, spent = coqc(Path(place), "loop", HEAD + body, "-Q", str(lemmas), "")
        result = {"ok": ok and len(found) == len({*found}), "seconds": round(before + spent, 1)}
        self.add("compiled.jsonl", key, result)
        return result

    def lemmas(self, text: str) -> tuple[Path, float]:
        """The folder of what files begin with, compiled, and the seconds that it took."""
        home = self.home / "lemmas" / hashlib.sha256(text.encode()).hexdigest()[:16]
        if not home.exists():
            place = Path(tempfile.mkdtemp(dir=self.home))
            ok, spent = coqc(place, "common", text)
            if not ok:
                raise RuntimeError(f"the lemmas in {place} do not compile")
            (place / "seconds").write_text(str(spent), "utf-8")
            home.parent.mkdir(exist_ok=True)
            with contextlib.suppress(OSError):  # another process was quicker
                place.rename(home)
        return home, float((home / "seconds").read_text("utf-8"))

    def exported(self) -> Iterator[tuple[str, str, str]]:
        """Kind, file and reason of each certificate, one of which is empty; of each kind one, then another of each.

        In an order by chance within a kind, so that processes that run at once are at different ones.
        """
        kinds = defaultdict[str, list[str]](list)
        for path in (self.home / "certificates").glob("*.json"):
            text = path.read_text("utf-8")
            kinds[kind_of(json.loads(text))].append(text)
        for texts in kinds.values():
            random.shuffle(texts)
        turns = (zip(kinds, turn, strict=True) for turn in zip_longest(*kinds.values()))
        for kind, text in chain.from_iterable(turns):
            if text is not None:
                try:
                    yield kind, coq_text(check(text, seconds=math.inf)), ""
                except InputError as error:
                    yield kind, "", str(error).partition("to Coq: ")[2] or str(error)

    def table(self, seconds: float) -> int:
        """Export, compile for so long, and print what came of it; 1 if a file does not compile in time."""
        rows, reasons, failed = defaultdict[str, Counter[str]](Counter), Counter[tuple[str, str]](), 0
        slowest, end = defaultdict[str, float](float), time.monotonic() + seconds
        for kind, text, reason in self.exported():
            rows[kind]["refused" if reason else "exported"] += 1
            if reason:
                reasons[kind, reason] += 1
            elif result := self.compile(text, end):
                held = result["ok"] and result["seconds"] <= LIMIT
                rows[kind]["compiled"] += held
                failed += not held
                slowest[kind] = max(slowest[kind], result["seconds"])
        rows["all"], slowest["all"] = sum(rows.values(), Counter[str]()), max(slowest.values(), default=0.0)
        print("| certificate | exported | refused | compiled | slowest, s |\n| --- | --- | --- | --- | --- |")
        for kind, row in sorted(rows.items(), key=lambda item: (item[0] == "all", item[0])):
            print(f"| {kind} | {row['exported']} | {row['refused']} | {row['compiled']} | {slowest[kind]:.1f} |")
        for (kind, reason), count in reasons.most_common():
            print(f"refused {count:3} {kind}: {reason}")
        print(f"{failed} do not compile within {LIMIT} s")
        return int(failed > 0)


def coqc(place: Path, name: str, text: str, *options: str) -> tuple[bool, float]:
    """Whether a file compiles, and the seconds of processor that it took."""
    (place / f"{name}.v").write_text(text, "utf-8")

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
        os.setpriority(os.PRIO_PROCESS, 0, max(10, os.getpriority(os.PRIO_PROCESS, 0)))

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    asked = ["coqc", *options, f"{name}.v"]
    done = subprocess.run(asked, cwd=place, capture_output=True, check=False, preexec_fn=limited)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.returncode == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Ask, export, compile, count."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, help="what is kept; without it a few questions, and nothing is")
    parser.add_argument("--loop", action="append", choices=loop_names(), help="these alone")
    parser.add_argument("--seconds", type=float, default=math.inf, help="how long files are compiled; 0: not at all")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    if shutil.which("coqc") is None:
        print("coqc is not installed: files are written, and not compiled")
        chosen.seconds = -1.0
    with tempfile.TemporaryDirectory() as scratch:
        folder = Folder((chosen.folder or Path(scratch)).resolve())
        few = {what: QUESTIONS[what] for what in ("sector 1/2", "sector 4", "rate, sector 1/2")}
        folder.ask(chosen.loop or list(loop_names() if chosen.folder else ("third-order",)),
                   QUESTIONS if chosen.folder else few)  # fmt: skip
        return folder.table(chosen.seconds)


if __name__ == "__main__":
    sys.exit(main())

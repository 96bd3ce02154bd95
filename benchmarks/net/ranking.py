"""What changed between two sets of answers, and whether it may."""

import json
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

from net.cases import Case

RANKS = {"a": "VERDICT CHANGED", "b": "WORSE", "c": "better", "d": "new key", "e": "other"}
TIMED = {"seconds", "cpu_seconds", "cost", "date", "versions", "source", "lure_version", "file", "inputs_sha256"}
TIMED |= {"method_compiled"}  # the engine of the rod is compiled once enough was asked of the process
VERDICTS = {"verdict", "status", "result", "attracts"}
BRACKETS = {"largest", "hurwitz", "bracket"}
EVIDENCE = ("observed", "computed", "certified")
LABELS = (("question", "odd", "time_varying"), ("criterion",), ("family", "size"), ("search",), ("theorem",), ("name",))
OPEN = ("/parameters", "/data", "/facts", "/witness", "/searches", "/simulated", "/impacts", "/contacts", "/stderr")


def leaves(value: object, path: str = "") -> Iterator[tuple[str, Any]]:
    """Path and value of what a JSON document holds; lists of tables by what their entries are about."""
    if isinstance(value, dict):
        if all(isinstance(value.get(side), dict) and "double" in value[side] for side in ("inner", "outer")):
            yield f"{path}/bracket", sorted(float(value[side]["double"]) for side in ("inner", "outer"))
        for key, each in value.items():
            if key not in TIMED:
                yield from leaves(each, f"{path}/{key}")
    elif isinstance(value, list) and any(isinstance(each, dict) for each in value):
        seen: Counter[str] = Counter()
        for each in value:
            names = next((names for names in LABELS if isinstance(each, dict) and names[0] in each), ())
            label = " ".join(str(each.get(name)) for name in names)
            seen[label] += 1
            yield from leaves(each, f"{path}[{label}{f' {seen[label]}' if seen[label] > 1 else ''}]")
    else:
        yield path, value


def content(case: Case) -> dict[str, Any]:
    """All that is compared of an answered case."""
    try:
        out = json.loads(case["out"])
    except ValueError:
        out = {"text": case["out"]}
    whole = {"status": case["status"], "stderr": case["stderr"], "checked": case["checked"], "out": out}
    return dict(leaves(whole | {"certificates": case["certificates"]}))


def number(value: object) -> float | None:
    """A number, infinite ones too, or None."""
    if isinstance(value, bool) or not isinstance(value, float | int | str):
        return None
    return float(value) if not isinstance(value, str) or value in ("inf", "-inf") else None


def shifts(old: list[Any], new: list[Any], rtol: float) -> str:
    """Rank of the change of a bracket."""
    (low, high), (newer, higher) = [[number(end) for end in ends] for ends in (old, new)]
    if None in (low, high, newer, higher):
        return "b" if None in (newer, higher) else "c"
    slack = rtol * max((abs(end) for end in (low, high) if math.isfinite(end)), default=0.0)
    if newer > high + slack or higher < low - slack:
        return "a"
    if newer < low - slack or higher > high + slack:
        return "b"
    return "c" if newer > low + slack or higher < high - slack else ""


def contradicts(path: str, before: dict[str, Any], after: dict[str, Any], rtol: float) -> bool:
    """Whether one code proves up to more than where the other has a counterexample, so that one of them is wrong."""
    table = path.rsplit("/", 1)[0]
    for proving, refuting in ((before, after), (after, before)):
        proved, refuted = proving.get(f"{table}/largest"), number(refuting.get(f"{table}/refuted_at"))
        low = number(proved[0]) if proved else None
        if low is not None and refuted is not None and low > refuted + rtol * abs(refuted):
            return True
    return False


def rank(path: str, before: dict[str, Any], after: dict[str, Any], rtol: float) -> str:
    """Rank of the difference at a path; empty within ``rtol``."""
    old, new, key = before.get(path), after.get(path), path.rsplit("/", 1)[-1]
    parents = {path[: place.start()] for place in re.finditer(r"[/\[]", path)}
    if path not in before:
        return "a" if "/checked/" in path and new != "0" else "e" if parents & set(before) else "d"
    if path not in after:
        swapped = parents & set(after) or any(other.startswith(f"{path}/") for other in after)
        return "e" if swapped or any(part in path for part in OPEN) else "b"
    if key in VERDICTS or "/checked/" in path:
        return "a"
    if key == "evidence" and {str(old).lower(), str(new).lower()} <= set(EVIDENCE):
        return "c" if EVIDENCE.index(str(new).lower()) > EVIDENCE.index(str(old).lower()) else "b"
    first, second = number(old), number(new)
    if key in {*BRACKETS, "refuted_at"} and (old is None or new is None):
        lost = "b" if new is None else "c"
        return "a" if contradicts(path, before, after, rtol) else lost
    if key in BRACKETS and len(old) == len(new) == 2:
        return "a" if contradicts(path, before, after, rtol) else shifts(old, new, rtol)
    if key == "refuted_at" and first is not None and second is not None:
        if contradicts(path, before, after, rtol):
            return "a"
        return "" if math.isclose(first, second, rel_tol=rtol) else "c" if second < first else "b"
    return "" if None not in (first, second) and math.isclose(first, second, rel_tol=rtol) else "e"


def compare(before: dict[str, Case], after: dict[str, Case], *, rtol: float, most: int) -> int:
    """Print what changed, the worst first; 1 if anything has rank a or b."""
    groups: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    same = 0
    for name, case in before.items():
        if name not in after or case["status"] is None:
            continue
        old, new = content(case), content(after[name])
        paths = [path for path in dict.fromkeys([*old, *new]) if old.get(path, path) != new.get(path, path)]
        if after[name]["status"] is None:
            paths = ["/status"]
        same += not paths
        for path in paths:
            kind = re.sub(r"\[.*?\]", "[]", path)
            if place := rank(path, old, new, rtol):
                was, now = (f"{side.get(path, 'nothing')}"[:160] for side in (old, new))
                groups[place, kind].append(f"{name} {path}: {was} -> {now}")
            else:
                groups["e", "numbers within the tolerance"].append(f"{name} {path}")
    for (place, kind), found in sorted(groups.items()):
        print(f"({place}) {RANKS[place]}: {kind}, {len(found)} times")
        print("".join(f"      {each}\n" for each in found[:most]), end="")
    counts = ", ".join(f"{sum(len(each) for (at, _), each in groups.items() if at == r)} of rank {r}" for r in RANKS)
    print(f"{sum(name in after for name in before)} cases, {same} the same; differences: {counts}")
    return int(any(place in "ab" for place, _ in groups))

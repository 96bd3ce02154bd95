"""Claim: whatever a file holds, its reader gives an answer or one sentence: no traceback, no hang, no flood of memory.

Each round takes a valid file of the repository (system files and studies of the documentation, of ``lure`` and of the
built-in loops, certificates, networks, tables of measurements, formulas), changes it in one to four places and reads
it.  Keys are deleted, doubled, moved and misspelt, values exchanged for others of any type, numbers for ``nan``,
``1e400`` and ten thousand digits, lists nested and lengthened, texts cut, mixed with control characters and with parts
of other files.  Allowed are an ``InputError`` or a refusal by the checkers that is one printable line.  Some of what is
still a system is asked about for a moment.  Of certificates that the first checker accepts as drafts the second has
to be convinced too.

``--seconds`` says how long, ``--seed`` where to begin, ``--reader`` which; ``--keep DIR`` keeps what breaks the claim.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import json
import re
import resource
import signal
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lure import AssumptionError, Expression, InputError
from lure.analysis import analyse
from lure.analysis.certificates import checker
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.second import recheck
from lure.analysis.measured.example import example_text
from lure.analysis.measured.reading import read_measurements
from lure.analysis.sweeps.reading import study_of
from lure.files import parse_system
from lure.networks.reading import read_network

ROOT = Path(__file__).parents[1]
HANGS, BYTES, LONGEST = 10.0, 6 * 2**30, 1000  # [s] of a processor, of address space, signs of a sentence
ODD_NUMBERS = (0, -1, 1, 2, 1e-320, 1e308, -0.0, 10**30, 10**400, float("nan"), float("inf"), -float("inf"), 0.1, True)
ODD_TEXTS = (
    *("", " ", "nan", "inf", "1e400", "-1/0", "1/3", "0x10", "9" * 10000, "\x00", "\u202e", "𝟙", "é", "a" * 5000),
    *("((" * 500, "s", "1/s", "sigma", "exp(-s)", "z", "1_0", "--1", "1;2", "[", "{a}", "\n", "true", "null"),
)
Random = np.random.Generator


class OverTimeError(BaseException):
    """A reader took too long; no ``except Exception`` may hold it up."""


def pick(rng: Random, among: Any) -> Any:  # noqa: ANN401  (an element of anything)
    """One of them."""
    return among[int(rng.integers(len(among)))]


def places(tree: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:  # noqa: ANN401  (JSON)
    """The paths of everything in a tree, but itself."""
    for key, value in tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ():
        yield (*at, key)
        yield from places(value, (*at, key))


def parent_of(tree: Any, path: tuple[Any, ...]) -> Any:  # noqa: ANN401  (JSON)
    """What holds the last part of the path."""
    for key in path[:-1]:
        tree = tree[key]
    return tree


def odd(rng: Random, value: Any, others: list[Any]) -> Any:  # noqa: ANN401  (JSON)
    """Something in place of a value: near to it, of another type, or from another file."""
    choice = rng.random()
    if choice < 0.25 and isinstance(value, int | float) and not isinstance(value, bool):
        return value * pick(rng, [-1, 2, 0.5, 1 + 1e-12, 1e6]) + pick(rng, [0, 0, 1])
    if choice < 0.4 and isinstance(value, str) and value:
        i = int(rng.integers(len(value)))
        return value[:i] + str(pick(rng, [*"0123456789-/.()*^se", "", pick(rng, ODD_TEXTS)])) + value[i + 1 :]
    if choice < 0.5:
        other = pick(rng, others)
        inside = list(places(other))
        path = pick(rng, inside) if inside else ()
        return copy.deepcopy(parent_of(other, path)[path[-1]]) if path else other
    if choice < 0.6:
        deep = value
        for _ in range(int(pick(rng, [1, 2, 30, 150]))):
            deep = [deep] if rng.random() < 0.7 else {"a": deep}
        return deep
    if choice < 0.65:
        return [value] * int(pick(rng, [0, 2, 50, 3000]))
    return pick(rng, [pick(rng, ODD_NUMBERS), pick(rng, ODD_TEXTS), [], {}, None, [[]], str(value)])


def mutated(rng: Random, tree: Any, others: list[Any]) -> Any:  # noqa: ANN401  (JSON)
    """A tree that is changed in one to four places."""
    tree = copy.deepcopy(tree)
    for _ in range(int(rng.integers(1, 5))):
        every = list(places(tree))
        if not every:
            return tree
        path = pick(rng, every)
        parent, key = parent_of(tree, path), path[-1]
        choice = rng.random()
        if choice < 0.15:
            del parent[key]
        elif choice < 0.25 and isinstance(parent, dict):
            parent[str(pick(rng, [*ODD_TEXTS, key + "s", key.upper(), pick(rng, every)[-1]]))] = copy.deepcopy(
                parent[key]
            )
        elif choice < 0.3 and isinstance(parent, list):
            parent.insert(int(rng.integers(len(parent) + 1)), copy.deepcopy(parent[key]))
        elif choice < 0.4:
            other = pick(rng, every)
            if other[: len(path)] != path and path[: len(other)] != other:
                parent_of(tree, other)[other[-1]], parent[key] = parent[key], parent_of(tree, other)[other[-1]]
        else:
            parent[key] = odd(rng, parent[key], others)
    return tree


def torn(rng: Random, text: str, others: list[str]) -> str:
    """A text that is cut, doubled or sprinkled in places."""
    for _ in range(int(rng.integers(1, 5))):
        i, j = sorted(int(v) for v in rng.integers(0, len(text) + 1, 2))
        other = pick(rng, others)
        a = int(rng.integers(0, len(other) + 1))
        text = pick(
            rng,
            [
                text[:i] + text[min(j, i + 20) :],
                text[:i] + str(pick(rng, ODD_TEXTS)) + text[i:],
                text[:i] + text[i : i + 30] * int(pick(rng, [2, 3, 200])) + text[i + 30 :],
                text[:i] + other[a : a + 40] + text[i:],
                text[:i] if rng.random() < 0.2 else text,
                text[:i] + str(pick(rng, list("()[]{}=,.\"'#\t\x00\x7f \n-+*/^e0"))) + text[i + 1 :],
            ],
        )
    return text[:200_000]


def toml_of(value: Any, *, top: bool = True) -> str:  # noqa: ANN401  (TOML)
    """A value as TOML; what it has no word for becomes a text."""
    if isinstance(value, dict):
        if top:
            plain = {k: v for k, v in value.items() if not isinstance(v, dict)}
            lines = [f"{json.dumps(k)} = {toml_of(v, top=False)}" for k, v in plain.items()]
            tables = [
                f"[{json.dumps(k)}]\n{toml_of(v, top=False)[1:-1]}"
                for k, v in value.items()
                if k not in plain and not v
            ]
            for k, v in value.items():
                if k not in plain and v:
                    tables.append(f"{json.dumps(k)} = {toml_of(v, top=False)}")
            return "\n".join([*lines, *sorted(tables, key=lambda line: line.startswith("["))]) + "\n"
        return "{" + ", ".join(f"{json.dumps(k)} = {toml_of(v, top=False)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml_of(v, top=False) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value) if not (isinstance(value, int) and abs(value) > 10**4000) else '"huge"'
    return json.dumps(str(value)).replace("\x7f", "\\u007f")


def blocks() -> list[dict[str, Any]]:
    """Every TOML file of the repository and of its documentation, as tables."""
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "lure").rglob("*.toml")]
    for page in [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]:
        for block in re.findall(r"```(?:{code-block} )?toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            texts.append("\n".join(line for line in block.splitlines() if not line.startswith(":")))
    found = []
    for text in texts:
        try:
            found.append(tomllib.loads(text))
        except tomllib.TOMLDecodeError:
            continue
    return found


def told(error: Exception) -> None:
    """A refusal is one printable line of moderate length."""
    said = str(error)
    if not said or not said.isprintable() or len(said) > LONGEST:
        raise RuntimeError(f"no sentence: {said[:300]!r}") from error


def ask_system(text: str, rng: Random, counts: Counter[str]) -> None:
    """A system file, now and then with a question about what it says."""
    try:
        system = parse_system(text, name="fuzzed", source="fuzzed.toml", settings=())
        counts["valid"] += 1
        str(system)
        if rng.random() < 0.05 and hasattr(system, "block"):
            counts["asked"] += 1
            str(analyse(system, seconds=0.3))
    except (InputError, AssumptionError) as error:
        told(error)


def fuzz_toml(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A system file."""
    text = toml_of(mutated(rng, pick(rng, corpus), corpus))
    text = torn(rng, text, [toml_of(pick(rng, corpus))]) if rng.random() < 0.3 else text
    yield_to(counts, text, lambda: ask_system(text, rng, counts))
    return text


def fuzz_study(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A study."""
    tree = mutated(rng, pick(rng, corpus), corpus)

    def read() -> None:
        try:
            study = study_of(tree, folder=ROOT / "lure" / "files")
            counts["valid"] += 1
            _ = study.points, str(study), study.chunks
        except (InputError, AssumptionError) as error:
            told(error)

    text = repr(tree)[:100_000]
    yield_to(counts, text, read)
    return text


def fuzz_certificate(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A certificate for both checkers, as it is, and as a draft that the first fills in."""
    tree = mutated(rng, pick(rng, corpus), corpus)
    text = json.dumps(tree)
    text = torn(rng, text, [json.dumps(pick(rng, corpus))]) if rng.random() < 0.1 else text

    def read() -> None:
        found = None
        try:
            found = checker.check(text, seconds=3, draft=bool(rng.random() < 0.8))
            counts["valid"] += 1
        except (Malformed, Rejected) as error:
            if not str(error) or "\n" in str(error):
                raise RuntimeError(f"no sentence: {str(error)[:300]!r}") from error
        opinion = recheck(text if found is None else dict(found.certificate), seconds=3)
        late = "time" in opinion.reason
        if found is not None and not opinion.accepted and not late:
            raise RuntimeError(f"the second checker refuses: {opinion.reason}")
        if found is None and opinion.accepted:
            counts["only the second accepts"] += 1
        if re.match(r"(?!JSONDecode|Unicode)\w*Error: ", opinion.reason):
            raise RuntimeError(f"the second checker breaks: {opinion.reason}")

    yield_to(counts, text, read)
    return text


def fuzz_network(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A network."""
    tree = mutated(rng, pick(rng, corpus), corpus)
    text = json.dumps(tree)
    text = torn(rng, text, [text]) if rng.random() < 0.2 else text

    def read() -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "network.json"
            path.write_text(text, encoding="utf-8", errors="surrogatepass")
            try:
                str(read_network(path))
                counts["valid"] += 1
            except InputError as error:
                told(InputError(str(error).replace(folder, "")))

    yield_to(counts, text, read)
    return text


def fuzz_table(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A table of measurements."""
    text = torn(rng, pick(rng, corpus), corpus)

    def read() -> None:
        try:
            with np.errstate(all="ignore"):
                str(read_measurements(text + "\n\n"))
            counts["valid"] += 1
        except InputError as error:
            told(error)

    yield_to(counts, text, read)
    return text


def fuzz_formula(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A formula."""
    text = torn(rng, pick(rng, corpus), corpus)[:3000]

    def read() -> None:
        try:
            found = Expression.parse(text, variables=("sigma", "t"), field="formula")
            counts["valid"] += 1
            with np.errstate(all="ignore"):
                found(sigma=np.array([0.0, 1.0, -3.0]), t=np.zeros(3))
        except (InputError, AssumptionError) as error:
            told(error)

    yield_to(counts, text, read)
    return text


def yield_to(counts: Counter[str], text: str, read: Callable[[], None]) -> None:
    """Read, within the time, and keep what was read where anything else than a refusal comes of it."""
    counts["read"] += 1
    try:
        signal.setitimer(signal.ITIMER_PROF, HANGS)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read()
    except OverTimeError:
        FAULT.extend([f"not read within {HANGS:g} s", text])
    except Exception:
        FAULT.extend([traceback.format_exc(), text])
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def fuzzed(fuzz: Callable[..., str], rng: Random, counts: Counter[str], corpus: list[Any]) -> None:
    """One file, if the changes make one."""
    with contextlib.suppress(OverflowError, RecursionError, ValueError):
        fuzz(rng, counts, corpus)


FAULT: list[str] = []
FORMULAS = (
    *("tanh(sigma) + sigma/(1 + sigma**2)", "min(1, max(-1, 2*sigma))", "abs(sigma)*sigma/(1+exp(-sigma**2))", "pi*t"),
    *("sqrt(1 + sigma**2) - 1", "sin(3*sigma)^2 + atan(sigma)", "log(1 + abs(sigma)) * cos(t)", "1/3*sigma - 2e-3"),
)


def readers() -> dict[str, tuple[Callable[[Random, Counter[str], list[Any]], str], list[Any]]]:
    """Every reader with the files it begins with."""
    certificates = list(json.loads((ROOT / "tests/support/certificates.json").read_text(encoding="utf-8")).values())
    network = json.loads((ROOT / "lure/networks/pendulum.json").read_text(encoding="utf-8"))
    tables = blocks()
    measured = [
        example_text()[:6000],
        "depth [um], force (mN)\n0, 0\n2, 8\n4, 16\n",
        "x;F\n0,0;1,5\n1,0;2,5\n2,0;3,5\n",
    ]
    return {
        "systems": (fuzz_toml, [one for one in tables if "ask" not in one]),
        "studies": (fuzz_study, [one for one in tables if "ask" in one]),
        "certificates": (fuzz_certificate, certificates),
        "networks": (fuzz_network, [network]),
        "tables": (fuzz_table, measured),
        "formulas": (fuzz_formula, list(FORMULAS)),
    }


def expired(*_: object) -> None:
    """End what is being read."""
    raise OverTimeError


def main() -> int:
    """Fuzz; 1 if the claim does not hold."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=12.0)
    parser.add_argument("--seed", type=int, default=20261123)
    parser.add_argument("--reader", choices=list(readers()))
    parser.add_argument("--keep", type=Path)
    chosen = parser.parse_args()
    signal.signal(signal.SIGPROF, expired)
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    every = {name: one for name, one in readers().items() if chosen.reader in (None, name)}
    counts, faults, start, rounds = {name: Counter[str]() for name in every}, Counter[str](), time.monotonic(), 0
    while time.monotonic() - start < chosen.seconds:
        for k, (name, (fuzz, corpus)) in enumerate(every.items()):
            FAULT.clear()
            fuzzed(fuzz, np.random.default_rng([chosen.seed, k, rounds]), counts[name], corpus)
            if not FAULT:
                continue
            last = FAULT[0].strip().splitlines()
            kind = f"{name}: {last[-1][:150]} {next((line.strip() for line in reversed(last) if 'File' in line), '')}"
            faults[kind] += 1
            if faults[kind] == 1:
                print(f"{kind}\n    {FAULT[1][:300]!r}", flush=True)
                if chosen.keep:
                    chosen.keep.mkdir(parents=True, exist_ok=True)
                    (chosen.keep / f"{name}-{rounds}.txt").write_text(
                        "\n\n".join(FAULT), encoding="utf-8", errors="replace"
                    )
        rounds += 1
    for name, found in counts.items():
        print(f"{name:<14}", ", ".join(f"{n} {what}" for what, n in found.items()))
    print(f"{sum(found['read'] for found in counts.values())} files, {sum(faults.values())} faults   (claim: 0)")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

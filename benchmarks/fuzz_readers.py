"""Claim: whatever a file holds, its reader gives an answer or one sentence: no traceback, no hang, no flood of memory.

Each round takes a valid file of the repository (system files and studies of the documentation, of ``lure`` and of the
built-in loops, certificates, networks as JSON, NumPy's, ONNX's and PyTorch's files, tables of measurements and of
points, formulas, transfer functions, command lines), changes it in one to four places and reads it.  Keys are deleted,
doubled, moved and misspelt, values exchanged for others of any type, numbers for ``nan``, ``1e400`` and ten thousand
digits, lists nested and lengthened, texts cut, mixed with control characters and with parts of other files, bytes
exchanged.  Allowed are an ``InputError`` or a refusal by the checkers that is one printable line; of a command the
status 2 with one line.  What is read has to be what is written: loops are written and read again, transfer functions,
formulas and networks read a second time by other means.  Some of what is still a system is asked about for a moment.
Of certificates that the first checker accepts as drafts the second has to be convinced too.

``--seconds`` says how long, ``--seed`` where to begin, ``--reader`` which; ``--keep DIR`` keeps what breaks the claim,
``--state FILE`` the counts, with which a campaign goes on.  ``fuzzing/guided.py`` lets a fuzzer choose the changes that
watches which lines they reach.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import importlib.util
import io
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
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing.mutation import Random, chipped, mutated, odd, pick, toml_of, torn
from fuzzing.second_readings import same_formula, same_network, same_system, same_transfer

from lure import AssumptionError, Expression, InputError
from lure.analysis import analyse
from lure.analysis.certificates import checker
from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.second import recheck
from lure.analysis.cli import main as lure
from lure.analysis.measured.example import example_text
from lure.analysis.measured.reading import read_measurements
from lure.analysis.sweeps.reading import study_of
from lure.files import parse_system
from lure.networks.reading import read_network
from lure.nonlinearities.points_file import points_from_csv
from lure.plants.text import parse_transfer

ROOT = Path(__file__).parents[1]
HANGS, BYTES, LONGEST = 10.0, 2**30, 1000  # [s] of a processor, of memory beside what was there, signs of a sentence


class OverTimeError(BaseException):
    """A reader took too long; no ``except Exception`` may hold it up."""


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
        same_system(system)
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

    def read(path: Path) -> None:
        network = read_network(path)
        counts["valid"] += 1
        str(network)
        same_network(text, network)

    yield_to(counts, text, lambda: ask_file(text.encode(errors="surrogatepass"), "network.json", read))
    return text


def fuzz_weights(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """Weights in a binary format: other arrays written as they should be, or some of the bytes exchanged."""
    suffix, data = pick(rng, corpus)
    if suffix == ".npz" and rng.random() < 0.5:
        data = archive(rng)
    if rng.random() < 0.8:
        data = chipped(rng, data)

    def read(path: Path) -> None:
        told = {"activation": "tanh"} if rng.random() < 0.9 else {}
        str(read_network(path, **told))
        counts["valid"] += 1

    yield_to(counts, suffix + data.hex(), lambda: ask_file(data, f"network{suffix}", read))
    return data.hex()


def archive(rng: Random) -> bytes:
    """Arrays of any type and shape under any name, of some of which less is there than their headers say."""
    with io.BytesIO() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as held:
            for name in {pick(rng, NAMED) for _ in range(int(rng.integers(1, 6)))}:
                shape = pick(rng, [(2, 2), (1, 2), (2, 1), (2,), (1,), (), (0, 2), (2, 0), (1, 1, 1), (30, 30), *VAST])
                kind = pick(
                    rng, ["<f8", "<f4", "<f2", "<i8", "|u1", "|b1", "<c16", "<U3", "|S2", "<M8[s]", ">f8", "|O"]
                )
                header = {"descr": kind, "fortran_order": bool(rng.random() < 0.2), "shape": shape}
                with io.BytesIO() as array:
                    np.lib.format.write_array_header_1_0(array, header)
                    size = 1 if shape in VAST else int(np.prod(shape)) * np.dtype(kind).itemsize
                    value = pick(rng, [1.0, -0.5, 0.0, np.nan, np.inf, 1e308, 5e-324])
                    body = np.full(size // 8 + 1, value).tobytes()[: max(0, size - (rng.random() < 0.1))]
                    held.writestr(f"{name}.npy", array.getvalue() + body)
        return file.getvalue()


def fuzz_points(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """The points of a nonlinearity."""
    text = torn(rng, pick(rng, corpus), corpus)

    def read(path: Path) -> None:
        points_from_csv(path)
        counts["valid"] += 1

    yield_to(counts, text, lambda: ask_file(text.encode(errors="surrogatepass"), "points.csv", read))
    return text


def ask_file(data: bytes, name: str, read: Callable[[Path], None]) -> None:
    """What a reader says of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        try:
            read(path)
        except InputError as error:
            told(InputError(str(error).replace(folder, "")))


def fuzz_transfer(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A transfer function."""
    text = torn(rng, pick(rng, corpus), corpus)[:3000]

    def read() -> None:
        try:
            plant = parse_transfer(text)
        except InputError as error:
            told(error)
        else:
            counts["valid"] += 1
            str(plant)
            same_transfer(text, plant)

    yield_to(counts, text, read)
    return text


def fuzz_command(rng: Random, counts: Counter[str], corpus: list[Any]) -> str:
    """A command line, one of its files changed too."""
    words, files = list(pick(rng, corpus[0])), dict(corpus[1])
    for _ in range(int(rng.integers(0, 4))):
        i, choice = int(rng.integers(len(words))), rng.random()
        other = pick(rng, pick(rng, corpus[0]))
        if choice < 0.2:
            words.insert(i, other)
        elif choice < 0.3 and len(words) > 1:
            del words[i]
        elif choice < 0.5:
            words[i] = other
        else:
            words[i] = str(odd(rng, words[i], [*corpus[0], words]))
    name = pick(rng, sorted(files))
    if rng.random() < 0.4:
        files[name] = torn(rng, files[name], [files[pick(rng, sorted(files))]])
    if {"--seconds", words[0]} & {"--seconds", *TIMED} == {"--seconds", words[0]}:
        words += ["--seconds", "0.3"]
    given = [word.replace("\0", "") for word in words]  # the operating system takes no other
    text = json.dumps([given, files[name]])

    def read() -> None:
        with (
            tempfile.TemporaryDirectory() as folder,
            contextlib.chdir(folder),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()) as stderr,
        ):
            for path, held in files.items():
                Path(path).write_text(held, encoding="utf-8", errors="surrogatepass")
            status = lure(given)
        said = stderr.getvalue().strip().splitlines()
        counts[f"status {status}"] += 1
        if status not in (0, 2, 10, 11) or (status == 2 and (not said or len(said[-1]) > LONGEST)):
            raise RuntimeError(f"status {status}: {said!r:.600}")
        if any("not enough memory" in line or "Traceback" in line for line in said):
            raise RuntimeError(f"{said!r:.600}")
        if status == 2 and not 1 <= sum(line.startswith("lure: ") for line in said) <= len(given):  # one for each file
            raise RuntimeError(f"no sentence: {said!r:.600}")

    if given and given[0] not in UNTRIED:
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
                same_formula(text, found, float(pick(rng, [0.0, 1.0, -3.0, 0.7])), 0.3)
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
    except Exception:  # anything but a refusal is what is looked for
        FAULT.extend([traceback.format_exc(), text])
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def fuzzed(fuzz: Callable[..., str], rng: Random, counts: Counter[str], corpus: list[Any]) -> None:
    """One file, if the changes make one that fits into memory."""
    with contextlib.suppress(MemoryError, OverflowError, RecursionError, ValueError):
        fuzz(rng, counts, corpus)


FAULT: list[str] = []
FORMULAS = (
    *("tanh(sigma) + sigma/(1 + sigma**2)", "min(1, max(-1, 2*sigma))", "abs(sigma)*sigma/(1+exp(-sigma**2))", "pi*t"),
    *("sqrt(1 + sigma**2) - 1", "sin(3*sigma)^2 + atan(sigma)", "log(1 + abs(sigma)) * cos(t)", "1/3*sigma - 2e-3"),
)


NAMED = ("W1", "W2", "W3", "b1", "b2", "layers.0.weight", "2.bias", "a/b", "1", "w" * 300)
VAST = ((10**5, 10**5), (2**40,), (3, 2**62), (-1, 2))
TRANSFERS = (
    *("1/(s*(s+1)*(s+2))", "z/(z-0.5)", "2 s (s+1)^3/(s^2+0.1s+1)^2", "-(s-1)/((s-1)*(s+2))", "1e-3/(.5*s+1.)**12"),
    *("1/s + 1/(s*(s+1))", "(1/s)/(1 + 1/s)", "(s^2-0.2s-0.1)/(s^3+2s^2+s+1)", "(z^2+1)/(z-1)^2/(z+0.25)"),
)
POINTS = ("sigma, phi\n-1, -2\n0, 0\n1, 0.5\n", "x;y\n# a comment\n0;0\n0,5;1,25\n2;2\n", "3 1e-2\n1 .5\n0 0\n")
COMMANDS = tuple(
    line.split()
    for line in """max-sector --num 1 --den 1,3,2,0 --criterion popov --json
max-slope --odd --transfer 1/(s+1)^3
max-slope --num 2,0.92 --den 1,-0.5,0 --dt 1
max-sector --transfer exp(-s)/(s+1) --lower 1/2
max-sector --system loop.toml
certify --num 1 --den 1,3,2,0 --sector 0 5.9 -o new.json --force
certify loop.toml --sector 0 2 --time-varying -o new.json
certify loop.toml --set class.sector=[0,7] -o new.json --quiet
analyse loop.toml --json
analyse third-order --verbose
verify --second certificate.json
verify certificate.json --json
explain LURE-I001
export --coq certificate.json -o -
sector --expr tanh(sigma)+sigma/3 --slope
sector table.csv --fit
gain performance.toml --json
rate loop.toml -o rate.json
region region.toml
systems third-order --toml
systems
init --loop new.toml
steady shaken.toml --omega 0.1:10:3
doctor""".splitlines()
)
TIMED = ("max-sector", "max-slope", "certify", "analyse", "sector", "gain", "rate", "region", "steady")
UNTRIED = (
    "report",
    "reproduce",
    "explore",
    "sweep",
    "compare",
    "simulate",
    "response",
    "bifurcation",
    "basin",
    "--install-completion",
)
LOOP = "[plant]\nnum = [1]\nden = [1, 3, 2, 0]\n[class]\nsector = [0, 3]\n"
FILES = {
    "loop.toml": LOOP,
    "performance.toml": "[plant]\nA = [[0, 1], [-2, -3]]\nB = [0, 1]\nC = [1, 0]\n[class]\nsector = [0, 1]\n"
    "[performance]\nBw = [[0], [1]]\nCz = [[1, 0]]\n",
    "region.toml": '[plant]\ntransfer = "1/(s^2+s-1)"\n[nonlinearity]\nkind = "saturation"\nlimit = 1\ngain = 3\n',
    "shaken.toml": '[plant]\nA = [[0, 1], [-2, -3]]\nB = [0, 1]\nC = [1, 0]\n[nonlinearity]\nkind = "saturation"\n'
    "limit = 1\ngain = 1\n[performance]\nBw = [[0], [1]]\nCz = [[1, 0]]\n[forcing]\namplitude = 1\nomega = 2\n",
    "table.csv": "depth [um], force (mN)\n" + "".join(f"{i}, {i * (40 + i % 3)}\n" for i in range(16)),
}


def networks() -> list[tuple[str, bytes]]:
    """Small networks in binary formats, of those whose packages are installed."""
    rows, last = np.array([[1.0, 0.5], [0.25, -1.0]]), np.array([[1.0, -0.5]])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "network"
        np.savez(path.with_suffix(".npz"), W1=rows, b1=rows[0], W2=last)
        if importlib.util.find_spec("onnx"):
            onnx = importlib.import_module("onnx")
            held = [
                onnx.numpy_helper.from_array(a.astype("f4"), n) for a, n in ((rows, "W"), (rows[0], "b"), (last, "V"))
            ]
            make = onnx.helper.make_node
            nodes = [
                make("Gemm", ["y", "W", "b"], ["v"], transB=1),
                make("LeakyRelu", ["v"], ["w"], alpha=0.1),
                make("Gemm", ["w", "V"], ["u"], transB=1),
            ]
            ends = [onnx.helper.make_tensor_value_info(name, 1, [1, n]) for name, n in (("y", 2), ("u", 1))]
            onnx.save(
                onnx.helper.make_model(onnx.helper.make_graph(nodes, "g", ends[:1], ends[1:], held)),
                path.with_suffix(".onnx"),
            )
        if importlib.util.find_spec("torch"):
            torch = importlib.import_module("torch")
            state = {"0.weight": rows, "0.bias": rows[0], "2.weight": last}
            torch.save({name: torch.from_numpy(array) for name, array in state.items()}, path.with_suffix(".pt"))
        return [(one.suffix, one.read_bytes()) for one in sorted(Path(folder).iterdir())]


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
        "networks": (fuzz_network, [network, *({"weights": [[[1, "1/2"]], [[-0.5]]], "activation": "relu"},)]),
        "tables": (fuzz_table, measured),
        "formulas": (fuzz_formula, list(FORMULAS)),
        "weights": (fuzz_weights, networks()),
        "points": (fuzz_points, list(POINTS)),
        "transfer functions": (fuzz_transfer, list(TRANSFERS)),
        "commands": (fuzz_command, [COMMANDS, FILES | {"certificate.json": json.dumps(certificates[0])}]),
    }


def expired(*_: object) -> None:
    """End what is being read."""
    raise OverTimeError


class Campaign:
    """Counts and faults of a run, kept in a file where one is given, so that the next goes on from there."""

    def __init__(self, names: list[str], state: Path | None, keep: Path | None) -> None:
        self.state, self.keep, self.rounds = state, keep, 0
        self.counts = {name: Counter[str]() for name in names}
        self.faults: Counter[str] = Counter()
        if state is not None and state.exists():
            held = json.loads(state.read_text(encoding="utf-8"))
            self.rounds, self.faults = held["rounds"], Counter(held["faults"])
            self.counts |= {name: Counter(found) for name, found in held["counts"].items()}

    def one(self, name: str, fuzz: Callable[..., str], rng: Random, corpus: list[Any]) -> bool:
        """Read one file; whether the claim holds."""
        FAULT.clear()
        fuzzed(fuzz, rng, self.counts.setdefault(name, Counter()), corpus)
        if not FAULT:
            return True
        last = FAULT[0].strip().splitlines()
        what = re.sub(r"[\d.]+", "#", last[-1][:120])
        kind = f"{name}: {what} {next((line.strip() for line in reversed(last) if 'File' in line), '')}"
        self.faults[kind] += 1
        if self.faults[kind] == 1:
            print(f"{kind}\n    {FAULT[1][:300]!r}", flush=True)
            if self.keep:
                self.keep.mkdir(parents=True, exist_ok=True)
                path = self.keep / f"{name}-{hashlib.sha256(kind.encode()).hexdigest()[:12]}.txt"
                path.write_text("\n\n".join(FAULT), encoding="utf-8", errors="replace")
        return False

    def kept(self) -> None:
        """Write down how far it has come."""
        if self.state is not None:
            fresh = self.state.with_suffix(".new")
            held = {"rounds": self.rounds, "counts": self.counts, "faults": self.faults}
            fresh.write_text(json.dumps(held, indent=1), encoding="utf-8")
            fresh.replace(self.state)


def limited() -> None:
    """End what takes too long, and refuse it memory."""
    signal.signal(signal.SIGPROF, expired)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + BYTES
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def main() -> int:
    """Fuzz; 1 if the claim does not hold."""
    every = readers()
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=12.0)
    parser.add_argument("--seed", type=int, default=20261123)
    parser.add_argument("--reader", action="append", choices=list(every))
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--state", type=Path)
    chosen = parser.parse_args()
    limited()
    run = Campaign(chosen.reader or list(every), chosen.state, chosen.keep)
    start = saved = time.monotonic()
    while time.monotonic() - start < chosen.seconds:
        for k, (name, (fuzz, corpus)) in enumerate(every.items()):
            if name in (chosen.reader or every):
                run.one(name, fuzz, np.random.default_rng([chosen.seed, k, run.rounds]), corpus)
        run.rounds += 1
        if time.monotonic() - saved > 60:
            run.kept()
            saved = time.monotonic()
    run.kept()
    for name, found in run.counts.items():
        print(f"{name:<20}", ", ".join(f"{n} {what}" for what, n in found.items()))
    files = sum(found["read"] for found in run.counts.values())
    print(f"{files} files, {sum(run.faults.values())} faults   (claim: 0)")
    return 1 if run.faults else 0


if __name__ == "__main__":
    sys.exit(main())

"""Mutants of both checkers, and of what chooses, compares and words above them: one place changed, the tests run.

    python benchmarks/mutants.py --draw 180 --seed 3 --seconds 3000
    python benchmarks/mutants.py --area checkers --only second.windows --draw 20 --tests "certificate_*windows"
    python benchmarks/mutants.py --area first --only certificates.gains --draw 40 --each 60
    python benchmarks/mutants.py --only lure.analysis.questions.search:_try --draw 1000

Operators as in ``notebooks/notes/0009-mutants-of-the-checker.md``, and the branches of a conditional exchanged.  Once,
and again when a module or a test file has changed, it is noted which lines of these modules each test reaches, and how
long it takes (``build/mutants``).  The tests are collected once; a mutant gets its code in a forked process in which no
function remembers anything, and the tests that reach its line run there, the quickest first, until one fails; the
longest are left out where all need more than ``--each`` seconds.  The draw takes the modules in turn.

Two things are said of each mutant: whether it ``changes`` a verdict, a class or a number of one of the probes,
everything that is said of them compared word by word (the words of ``TOLD`` and numbers, no layout); and whether it is
``killed``.  One that changes none of these and lives is for a reader to judge.  Of the checkers (``--area checkers``,
``--area first``) and of what words answers (``--area words``) only the second is asked.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import importlib
import inspect
import itertools
import json
import math
import os
import pkgutil
import random
import re
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import CodeType, FrameType, FunctionType, ModuleType

import pytest
from fuzzing.places import mutants

ROOT = Path(__file__).parents[1]
CACHE = ROOT / "build" / "mutants"
_ABOVE = """
analysis answers approved answers_capped answers_conclusion answers_wording conclusion findings loop_report one_answer
python_door report report_confirmation report_honesty report_opening results_html results_xarray showing"""
_OTHER_QUESTIONS = """
channel_analysis channel_parts channel_rates channels certify decay rates_of_boxes regions regions_everywhere
region_disturbances l2_gain gain_energy gain_signals overshoot tolerances two_sided cli_channels cli_loops"""
ROOMS = (
    "lure.analysis.questions",
    "lure.analysis.rod.theory",
    "lure.analysis.rod.conclusion",
    "lure.analysis.wording",
    "lure.analysis.report",
    "lure.analysis.rod.report",
)
_WORDS = """
answers answers_choices answers_decisions answers_told answers_equilibria answers_capped answers_conclusion
answers_wording numbers_wording findings gain_decisions rates_decisions steady_decisions regions_decisions
wording_decisions channels_decisions rows_decisions
certify certify_faults channels channel_analysis channel_parts channel_rates channel_operators channel_tolerances decay
rates_of_boxes regions region_disturbances regions_everywhere l2_gain gain_energy gain_signals overshoot steady
steady_samples tolerances two_sided problem cli_channels cli_choices cli_loops loop_report one_answer"""
WORDED = """
wording verdict cli.loops cli.performance questions.advice questions.answers questions.certify questions.channels
questions.channel_hypotheses questions.channel_kinds questions.channel_map questions.conclusion questions.decay
questions.energy questions.gain questions.largest questions.margins questions.problem questions.regions questions.steady
questions.table questions.worst_plants"""
DRAWN = ("diagram", "figures", "output", "pdf", "reporting")  # pictures and files, no words
_FIRST = """
arithmetic balls states blocks frequencies pieces channels memory signals gains windows parametric powers boxes several
regions parts checker"""
_OF_CHECKERS = (  # files of tests that ask them
    *(
        "certificate_*",
        "homogeneous",
        "order_cone",
        "region*",
        "channel_*",
        "channels_*",
        "one_late_channel",
    ),
    *("slopes_*", "gain_*", "l2_gain", "decay", "tolerances"),
)
SINGLE = {
    "lure.analysis.certificates.drafts": ("contains", "_inside"),
    "lure.analysis.numerics.doubles": ("_bound", "_directed"),
}
QUIET = ("-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", "not slow")
_LOOP = '[plant]\ntransfer = "{}"\n{}'
BUILT_IN = ("biproper", "contact", "dead-zone", "double-zero", "integrator-resonance", "triple-lag", "unstable-lag")
PROBES = {  # built-in loops of a tenth of a second, and these
    "declared": _LOOP.format(
        "(s+2)/(s+1)", '[nonlinearity]\nkind = "expression"\nexpression = "tanh(sigma)"\nsector = [0, 2]\n'
    ),
    "sampled": _LOOP.format("0.5/(z-0.5)", 'dt = 0.1\n[nonlinearity]\nkind = "quantiser"\nstep = 1\n'),
    "asked": _LOOP.format("1/(s+1)^3", "[class]\nsector = [0.5, 3]\nslope = [0.5, 3]\nodd = true\n"),
    "beyond": _LOOP.format("1/(s*(s+1)*(s+2))", "[class]\nsector = [0, 7]\n"),
    "late": _LOOP.format("exp(-s)/(s+1)", ""),
    "twice": _LOOP.format("(s+1)/s^2", "[class]\nsector = [0, inf]\n"),
}
_MATRICES = "[plant]\nA = {}\nB = {}\nC = {}\n{}"
_LAGS = "[[-1, 0], [1, -2]]", "[[1, 0], [0, 1]]", "[[0, 1], [-1, 0]]"
_SWING = _MATRICES.format("[[-0.2, -1], [1, 0]]", "[[1], [0]]", "[[1, 1]]", "[class]\nsector = [0, 1]\n{}")
_MOVED = "[performance]\nBw = [[1], [0]]\nCz = [[1, 1]]\n"
_BOX = '[plant]\nnum = [1]\nden = [1, "a"]\n[plant.parameters]\na = [1, 2]\n[class]\nsector = [{}, 1]\n'
OTHERS = {  # of several channels, a rate, a gain, a region, a box: the question, and the loop
    "channels": ("max_sector", _MATRICES.format(*_LAGS, "[[class]]\nsector = [0, 3]\n[[class]]\nslope = [0, 0.5]\n")),
    "repeated": (
        "certify",
        _MATRICES.format(*_LAGS, "[[class]]\nsector = [-1, 9]\ntime_varying = true\nrepeated = 2\n"),
    ),
    "decay": ("decay_rate", _SWING.format("time_varying = true\n")),
    "sampled": ("decay_rate", "[plant]\nnum = [0.1]\nden = [1, -1]\ndt = 1\n[class]\nslope = [1, 10]\n"),
    "gain": ("l2_gain", _SWING.format(_MOVED)),
    "held": (
        "region",
        _MATRICES.format("[[1]]", "[[1]]", "[[1]]", '[nonlinearity]\nkind = "saturation"\ngain = 2\nlimit = 1\n'),
    ),
    "pushed": (
        "region",
        _MATRICES.format(
            "[[0, 1], [-1, 0.5]]",
            "[[0], [1]]",
            "[[1, 2]]",
            '[nonlinearity]\nkind = "saturation"\ngain = 1\nlimit = 1\n',
        )
        + "[performance]\nBw = [[0], [1]]\nCz = [[1, 0]]\n",
    ),
    "box": ("certify", _BOX.format(0)),
    "wider": ("tolerances", _BOX.format(-0.5)),
    "slow": ("decay_rate", _BOX.format(0)),
}
RODS = {"proved": {}, "pushed": {"damping": "-2e-4"}, "free": {"damping": "0"}, "bent": {"exponent": "3/2"}}
TOLD = re.compile(
    r"PROVED|REFUTED|INCONCLUSIVE|certified|computed|observed|checked|declared|fails|assumed|odd|slope|sector|linear|"
    r"time-(?:in)?varia\w+|time-varying|every|some\b|no(?:ne|t|thing)?\b|true|false|null|circle|popov|energy|"
    r"converge\w*|attract\w*|oscillat\w*|destabilis\w*|rest\b|scheme|rod\b|agrees|differs|simple|double|closed|open|"
    r"[-−]?\d[\d.]*(?:e[-+]?\d+)?|\binf\b|∞|[\[\]()]",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Area:
    """What is mutated and asked: rooms or modules, the names of the files of tests, whether there are probes."""

    rooms: tuple[str, ...]
    named: tuple[str, ...]
    probes: bool = False

    @property
    def tests(self) -> tuple[str, ...]:
        """The files of tests."""
        found = (path for name in self.named for path in sorted((ROOT / "tests").rglob(f"test_{name}.py")))
        return tuple(path.relative_to(ROOT).as_posix() for path in found)


_CERTIFICATES = "lure.analysis.certificates"
_OF_FIRST = tuple(f"{_CERTIFICATES}.{name}" for name in _FIRST.split())
AREAS = {
    "above": Area(ROOMS, tuple((_ABOVE + _OTHER_QUESTIONS).split()), probes=True),
    "words": Area(tuple(f"lure.analysis.{name}" for name in WORDED.split()), tuple(_WORDS.split())),
    "first": Area(_OF_FIRST, _OF_CHECKERS),
    "checkers": Area((*_OF_FIRST, f"{_CERTIFICATES}.second"), _OF_CHECKERS),
}


@dataclass(frozen=True)
class Mutant:
    """One place changed: its module, its number there, its function, what was done, and the lines of its statement."""

    module: str
    place: int
    function: str
    said: str
    lines: range

    def __str__(self) -> str:
        return f"{self.module} {self.function} {self.said}"


def functions(code: CodeType) -> dict[str, CodeType]:
    """All code objects of a compiled module by qualified name."""
    found = {}
    for each in code.co_consts:
        if isinstance(each, CodeType):
            found |= {each.co_qualname: each, **functions(each)}
    return found


def patched(module: ModuleType, tree: ast.Module) -> set[str]:
    """Give every function of the module the code of the tree; references elsewhere see it too.  The names of them."""
    codes = functions(compile(tree, str(inspect.getsourcefile(module)), "exec"))
    holders = [module, *(v for v in vars(module).values() if inspect.isclass(v) and v.__module__ == module.__name__)]
    done = set()
    for holder in holders:
        for value in list(vars(holder).values()):
            for one in (value, *(getattr(value, name, None) for name in ("fget", "func", "__wrapped__", "__func__"))):
                if isinstance(one, FunctionType) and one.__qualname__ in codes:
                    new = codes[one.__qualname__]
                    if len(new.co_freevars) == len(one.__code__.co_freevars):
                        one.__code__ = new
                        done.add(new.co_name)
    return done


def clear_caches(names: tuple[str, ...]) -> None:
    """Forget what functions of the modules remember."""
    for name in names:
        for value in vars(importlib.import_module(name)).values():
            if hasattr(value, "cache_clear"):
                value.cache_clear()


def apart(work: Callable[[], int], seconds: float) -> int | None:
    """The status of some work in a process of its own, that prints nothing; None when its processor time was over."""
    child = os.fork()
    if not child:
        status = 9
        try:
            os.setsid()
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, 1)
            os.dup2(null, 2)
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 2))
            signal.alarm(20 * int(seconds) + 60)
            status = work()
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    return None if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


# which test reaches which line ----------------------------------------------------------------------------------------


class Watch:
    """A plugin that notes of each test how long it takes, whether it passes, and which lines of the modules it reaches.

    What the fixtures of a file reach counts for all tests of that file.
    """

    def __init__(self, files: dict[str, str]) -> None:
        self.files = files
        self.seconds: dict[str, float] = {}
        self.reached: dict[str, set[tuple[str, int]]] = {}
        self._now: set[tuple[str, int]] = set()
        self._left: dict[CodeType, set[int]] = {}

    def _call(self, frame: FrameType, _event: str, _arg: object) -> object:
        code = frame.f_code
        module = self.files.get(code.co_filename)
        if module is None:
            return None
        if code not in self._left:
            self._left[code] = {number for _, _, number in code.co_lines() if number}
        left = self._left[code]

        def line(frame: FrameType, event: str, _arg: object) -> object:
            if event == "line" and frame.f_lineno in left:
                self._now.add((module, frame.f_lineno))
                left.remove(frame.f_lineno)
                frame.f_trace_lines = bool(left)
            return line

        return line if left else None

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        """Note what the fixtures reach."""
        clear_caches(tuple(self.files.values()))
        begun = time.process_time()
        yield from self._watched(item.nodeid.partition("::")[0])
        self.seconds[item.nodeid] = time.process_time() - begun

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Note what the test reaches, and how long it takes."""
        begun = time.process_time()
        setup = self.seconds.pop(item.nodeid)
        yield from self._watched(item.nodeid)  # one that fails without a mutant is not asked about any
        self.seconds[item.nodeid] = setup + time.process_time() - begun

    def _watched(self, key: str) -> Iterator[None]:
        self._now, self._left = self.reached.setdefault(key, set()), {}
        sys.settrace(self._call)
        try:
            return (yield)
        finally:
            sys.settrace(None)


def reach(names: tuple[str, ...], tests: tuple[str, ...], cache: Path) -> dict[str, tuple[float, set[tuple[str, int]]]]:
    """Of each test the seconds and the lines it reaches; measured anew when its file or a module it reaches changed."""
    files = {str(inspect.getsourcefile(importlib.import_module(name))): name for name in names}
    state = {name: _digest(Path(file)) for file, name in files.items()}
    cache.mkdir(parents=True, exist_ok=True)
    found: dict[str, tuple[float, set[tuple[str, int]]]] = {}
    for test in tests:
        kept = cache / f"{Path(test).stem}.json"
        data = json.loads(kept.read_text()) if kept.exists() else None
        if data is None or any(({test: _digest(ROOT / test)} | state).get(name) != was for name, was in data["of"]):

            def measure(test: str = test, kept: Path = kept) -> int:
                watch = Watch(files)
                pytest.main([*QUIET[1:], test], plugins=[watch])
                of = [
                    (test, _digest(ROOT / test)),
                    *((m, state[m]) for m in {m for v in watch.reached.values() for m, _ in v}),
                ]
                reached = {key: sorted(lines) for key, lines in watch.reached.items()}
                kept.write_text(json.dumps({"of": of, "seconds": watch.seconds, "reached": reached}))
                return 0

            print("measured", test, "status", apart(measure, 900), flush=True)
            data = json.loads(kept.read_text())
        both = {name: {(m, line) for m, line in lines} for name, lines in data["reached"].items()}
        for name, seconds in data["seconds"].items():
            found[name] = seconds, both[name] | both.get(name.partition("::")[0], set())
    return found


def _digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16]


class Collected:
    """A plugin that collects the tests, does some work in their place, and runs tests in an order of its own."""

    def __init__(self, work: Callable[[], None]) -> None:
        self.work = work
        self.session: pytest.Session

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Do the work."""
        self.session = session
        self.work()
        return True

    def run(self, names: list[str]) -> int:
        """1 when one of these tests fails, which is the last to run, otherwise 0."""
        found = {item.nodeid: item for item in self.session.items}
        items = [found[name] for name in names]
        for item, after in itertools.zip_longest(items, items[1:]):
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=after)
            if self.session.testsfailed:
                return 1
        return 0


# what is said of the probes -------------------------------------------------------------------------------------------


def rods() -> dict[str, object]:
    """The reports on the rods; what the mutants change of them is made again by :func:`said`."""
    from fractions import Fraction

    from lure.analysis.rod.report import build_report
    from lure.rod import builtin_system
    from lure.rod.systems import rod_from_exact

    paper = builtin_system("paper-rod")
    found = {}
    for name, changes in RODS.items():
        exact = {**paper.rod.exact, **{key: Fraction(value) for key, value in changes.items()}}
        found[name] = build_report(replace(paper, rod=rod_from_exact(exact), cells=10, until=3e-3))
    return found


def said(reports: dict[str, object]) -> list[str]:
    """Every verdict, class and number that the probes are told, in order."""
    from markupsafe import Markup

    from lure.analysis import analyse, certify, decay_rate, l2_gain, max_sector, max_slope, region
    from lure.analysis.questions import tolerances
    from lure.analysis.report.loop.model import LoopReport
    from lure.analysis.report.loop.write import loop_page
    from lure.analysis.report.parts import certificate_files
    from lure.analysis.rod.conclusion import conclusion
    from lure.analysis.rod.popov import rod_criteria
    from lure.analysis.rod.report.build import checked_criteria
    from lure.analysis.rod.report.document import document
    from lure.analysis.rod.report.model import claims
    from lure.analysis.rod.report.output import page
    from lure.files import parse_system
    from lure.files.builtin import builtin_loop
    from lure.record import plain

    texts = []
    loops = [parse_system(text, name=name, source="a file") for name, text in PROBES.items()]
    for loop in (*map(builtin_loop, BUILT_IN), *loops):
        found = analyse(loop)
        report = LoopReport(analysis=found, observed=(), hints=(), command="", versions={"lure": ""})
        data = report.to_dict()
        texts += [json.dumps(data), str(report), loop_page(data, (), Markup("")), found._repr_html_()]
        texts += [str(found.to_xarray()), *certificate_files(found.certificates).values()]
    asked = {one.__name__: one for one in (certify, decay_rate, l2_gain, region, tolerances)}
    asked["max_sector"] = lambda loop: max_sector(loop.block, classes=loop.classes)
    for name, (question, text) in OTHERS.items():
        answer = asked[question](parse_system(text, name=name, source="a file"))
        sides = [getattr(answer, side, None) for side in ("proof", "refutation")]
        both = [getattr(answer, "certificate", None), *(getattr(side, "certificate", None) for side in sides)]
        texts += [str(answer), json.dumps(answer.to_dict()), answer._repr_html_(), json.dumps(plain(both))]
    one = max_slope(([1], [1, 2, 2, 1]), search="linear")
    texts += [str(one), json.dumps(one.to_dict()), one._repr_html_(), str(one.to_xarray())]
    for old in reports.values():
        scheme = old.scheme
        criteria = checked_criteria(scheme, rod_criteria(scheme))
        concluded = conclusion(scheme, old.system.scenario)
        shown = (*concluded.certificates, *(one.shown for one in criteria if one.shown is not None))
        new = replace(old, criteria=criteria, conclusion=concluded, certificates=shown)
        texts += [json.dumps(document(new)), str(new), page(document(new), claims(new), ()), new._repr_html_()]
        texts += [str(new.to_xarray()), *certificate_files(shown).values()]
    bare = (re.sub(r"<style.*?</style>|<svg.*?</svg>|style=\"[^\"]*\"", "", text, flags=re.DOTALL) for text in texts)
    return [word for text in bare for word in (*TOLD.findall(text), "\n")]


# ----------------------------------------------------------------------------------------------------------------------


class Runner:
    """Everything that does not change from mutant to mutant."""

    def __init__(self, area: str, names: tuple[str, ...], each: float, tests: tuple[str, ...]) -> None:
        asked = replace(AREAS[area], named=tests or AREAS[area].named)
        self.each, self.probes, self.names, self.files = each, asked.probes, names, asked.tests
        self.tests = reach(names, self.files, CACHE / area)
        self.rods = rods() if self.probes else {}
        self.base = said(self.rods) if self.probes else []
        self.fixtures = dict.fromkeys(self.files, 0.0)  # [s] before the first test of a file
        for name, (seconds, _) in self.tests.items():
            file = name.partition("::")[0]
            if 'scope="module"' in (ROOT / file).read_text("utf-8"):
                self.fixtures[file] = max(self.fixtures[file], seconds)
        self.collected = Collected(lambda: None)

    def judge(self, found: list[Mutant], end: float) -> Counter[tuple[str, str]]:
        """Judge mutants, print what is found, and count it; until some time is over."""
        counts: Counter[tuple[str, str]] = Counter()

        def work() -> None:
            clear_caches(self.names)
            for mutant in found:
                if time.monotonic() > end:
                    break
                changes, how = self.judged(mutant)
                counts[changes, how.partition(" (")[0]] += 1
                print(f"{changes}, {how}  {mutant}", flush=True)

        self.collected = Collected(work)
        pytest.main([*QUIET, "-q", "-s", *self.files], plugins=[self.collected])
        return counts

    def judged(self, mutant: Mutant) -> tuple[str, str]:
        """Whether a mutant changes what the probes are told, and what the tests say of it."""
        module, tree = importlib.import_module(mutant.module), _tree(mutant.module)
        next(itertools.islice(mutants(tree), mutant.place, None))
        ast.fix_missing_locations(tree)

        def probe() -> int:
            if mutant.function not in patched(module, tree):
                return 8
            return 0 if said(self.rods) == self.base else 1

        status = apart(probe, 120) if self.probes else 0
        changes = {0: "same", 8: "not put in place"}.get(-1 if status is None else status, "changes")
        return changes, self._tested(module, tree, mutant)

    def cost(self, name: str) -> float:
        """The seconds of a test alone, with the fixtures of its file."""
        return self.tests[name][0] + self.fixtures[name.partition("::")[0]]

    def _tested(self, module: ModuleType, tree: ast.Module, mutant: Mutant) -> str:
        lines = {(mutant.module, line) for line in mutant.lines}
        found = sorted((self.cost(name), name) for name, (_, seen) in self.tests.items() if lines & seen)
        if not found:
            return "not reached"
        total = itertools.accumulate(self.tests[name][0] for _, name in found)
        fit = max(sum(time <= self.each for time in total), 1)
        # those of a file one after another where they cost about as much, so that fixtures are made once
        names = [name for _, name in sorted(found[:fit], key=lambda one: (round(math.log2(one[0] + 0.01)), one[1]))]

        def run() -> int:
            return self.collected.run(names) if mutant.function in patched(module, tree) else 8

        status = apart(run, 20 + 2 * self.each)
        if status != 0:
            return {None: "timed out", 1: "killed", 8: "not put in place"}.get(status, f"status {status}")
        return "alive" if fit == len(found) else f"alive ({len(found) - fit} of {len(found)} tests left out)"


def _tree(name: str) -> ast.Module:
    return ast.parse(Path(str(inspect.getsourcefile(importlib.import_module(name)))).read_text("utf-8"))


def modules(area: str) -> tuple[str, ...]:
    """The modules that are mutated."""
    found = []
    for name in AREAS[area].rooms:
        room = importlib.import_module(name)
        inner = [one.name for one in pkgutil.walk_packages(getattr(room, "__path__", []), f"{name}.") if not one.ispkg]
        found += [one for one in inner or [name] if one.rpartition(".")[2] not in DRAWN]
    return (*found, *(SINGLE if AREAS[area].probes else ()))


def drawn(names: tuple[str, ...], only: str, seed: int) -> list[Mutant]:
    """All mutants, one of each module in turn, in random order."""
    within, _, what = only.partition(":")
    groups = []
    for name in names:
        every = [Mutant(name, i, *found) for i, found in enumerate(mutants(_tree(name)))]
        group = [
            one
            for one in every
            if within in name and what in ("", one.function, f"{one.function} {one.said}")
            if name not in SINGLE or one.function in SINGLE[name]
        ]
        random.Random(f"{seed} {name}").shuffle(group)
        groups.append(group)
    return [one for turn in itertools.zip_longest(*groups) for one in turn if one is not None]


def main() -> int:
    """Draw mutants and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draw", type=int, default=160, help="of each --only")
    parser.add_argument("--area", choices=list(AREAS), default="above")
    parser.add_argument("--skip", type=int, default=0, help="of the draw, looked at before")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=int, default=3600, help="for all")
    parser.add_argument("--each", type=float, default=20, help="of CPU for the tests of one mutant")
    parser.add_argument("--only", action="append", help="module, module:function, or module:what is printed")
    parser.add_argument(
        "--tests", action="append", help="files of tests, such as certificate_*; of more than these otherwise"
    )
    given = parser.parse_args()
    end = time.monotonic() + given.seconds
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    names = modules(given.area)
    found = [one for only in given.only or [""] for one in drawn(names, only, given.seed)[given.skip : given.draw]]
    counts = Runner(given.area, names, given.each, tuple(given.tests or ())).judge(found, end)
    print(f"{len(found)} mutants drawn, {sum(counts.values())} looked at: {dict(counts)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

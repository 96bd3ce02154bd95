"""Mutants of what chooses, compares and words above the checker: one place of a function changed, the tests run.

    python benchmarks/mutants.py --draw 160 --seed 2 --seconds 600
    python benchmarks/mutants.py --only analysis.answers.decision:decided --draw 1000

Operators as in ``notebooks/notes/0009-mutants-of-the-checker.md``, and the branches of a conditional exchanged.  The
tests run once, and it is noted how long each takes and which functions it enters.  Each mutant then gets its code in a
forked process, where tests that enter its function run, the quickest first and for some seconds, until one fails.  The
draw takes the modules in turn.  A mutant that would survive a longer test counts as alive.
"""

from __future__ import annotations

import argparse
import ast
import copy
import importlib
import inspect
import itertools
import os
import random
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType, FunctionType

import pytest

ROOT = Path(__file__).parents[1]
TESTS = tuple(
    f"tests/test_{name}.py"
    for name in (
        "answers_wording",
        "answers_conclusion",
        "answers_capped",
        "report_opening",
        "conclusion",
    )
)
TARGETS = (
    "analysis.answers.conclusion",
    "analysis.answers.wording",
    "analysis.answers.decision",
    "analysis.answers.advice",
    "analysis.answers.largest",
    "analysis.answers.questions",
    "analysis.answers.text",
    "analysis.answers.certifying",
    "analysis.answers.table",
    "analysis.answers.document",
    "analysis.conclusion",
    "analysis.report.loop.words",
    "analysis.report.loop.document",
    "analysis.report.loop.bars",
    "analysis.report.console",
    "analysis.report.html",
)
SINGLE = {"analysis.certificates.sealing": ("contains", "_inside"), "analysis.doubles": ("_bound", "_directed")}
SLOW = 4.0  # [s] beyond which a test is left out
QUIET = ("-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", "not slow")
SWAPS: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
}
_TYPED = ("isinstance", "getattr", "hasattr")  # exchanged arguments of these fail wherever the line is reached
NAMES = {"min": "max", "max": "min", "any": "all", "all": "any"}


def changed(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Every other node that may stand in the place of one, with what was done."""
    if isinstance(node, ast.Compare):
        for i, op in enumerate(node.ops):
            for new in SWAPS.get(type(op), ()):
                other = copy.deepcopy(node)
                other.ops[i] = new()
                yield f"{type(op).__name__} to {new.__name__}", other
    elif isinstance(node, ast.BinOp) and not isinstance(node.left, ast.JoinedStr):
        for new in SWAPS.get(type(node.op), ()):
            yield f"{type(node.op).__name__} to {new.__name__}", ast.BinOp(node.left, new(), node.right)
    elif isinstance(node, ast.BoolOp):
        yield "and/or", ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)
        for i in range(len(node.values)):
            rest = node.values[:i] + node.values[i + 1 :]
            yield f"operand {i} left out", rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield f"{type(node.op).__name__} left out", node.operand
    elif isinstance(node, ast.IfExp):
        yield "branches exchanged", ast.IfExp(node.test, node.orelse, node.body)
    elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
        for new in (not node.value,) if isinstance(node.value, bool) else (node.value + 1, node.value - 1):
            yield f"{node.value} to {new}", ast.Constant(new)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in NAMES:
        yield f"{node.id} to {NAMES[node.id]}", ast.Name(NAMES[node.id], ast.Load())
    elif isinstance(node, ast.Call) and len(node.args) == 2 and getattr(node.func, "id", "") not in _TYPED:
        yield "arguments exchanged", ast.Call(node.func, node.args[::-1], node.keywords)
    elif isinstance(node, ast.If) and not node.orelse:
        yield "if left out", ast.If(ast.Constant(value=False), node.body, [])
        yield "always", ast.If(ast.Constant(value=True), node.body, [])


def mutants(tree: ast.Module) -> Iterator[tuple[str, str, range]]:
    """Every mutant of a module: function, what was done, its lines; until the next the tree is that mutant."""
    for outer in ast.walk(tree):
        if not isinstance(outer, ast.FunctionDef):
            continue
        lines = range(min((outer, *outer.decorator_list), key=lambda node: node.lineno).lineno, outer.end_lineno + 1)
        for parent in ast.walk(outer):
            for name, value in ast.iter_fields(parent):
                if name in ("decorator_list", "annotation", "returns", "args"):
                    continue
                spots = list(enumerate(value)) if isinstance(value, list) else [(None, value)]
                for i, old in spots:
                    for said, new in changed(old) if isinstance(old, ast.AST) else ():
                        _put(parent, name, i, new)
                        yield outer.name, f"line {getattr(old, 'lineno', outer.lineno)}: {said}", lines
                        _put(parent, name, i, old)


def _put(parent: ast.AST, name: str, i: int | None, node: ast.AST) -> None:
    if i is None:
        setattr(parent, name, node)
    else:
        getattr(parent, name)[i] = node


def functions(code: CodeType) -> dict[str, CodeType]:
    """All code objects of a compiled module by qualified name."""
    found = {}
    for each in code.co_consts:
        if isinstance(each, CodeType):
            found |= {each.co_qualname: each, **functions(each)}
    return found


def patched(module: object, tree: ast.Module) -> set[str]:
    """Give every function of the module the code of the tree; references elsewhere see it too.  The names of them."""
    codes = functions(compile(tree, str(inspect.getsourcefile(module)), "exec"))  # type: ignore[arg-type]
    holders = [module, *(v for v in vars(module).values() if inspect.isclass(v) and v.__module__ == module.__name__)]  # type: ignore[attr-defined]
    done = set()
    for holder in holders:
        for value in list(vars(holder).values()):
            for one in (value, *(getattr(value, name, None) for name in ("fget", "__wrapped__", "__func__"))):
                if isinstance(one, FunctionType) and one.__qualname__ in codes:
                    new = codes[one.__qualname__]
                    if len(new.co_freevars) == len(one.__code__.co_freevars):
                        one.__code__ = new
                        done |= {new.co_name, *(code.co_name for code in functions(new).values())}
    return done


class Watch:
    """A plugin that notes of each test how long it takes and which functions it enters.

    What the fixtures of a file enter counts for all tests of that file.
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.entered: dict[str, set[tuple[str, int]]] = {}
        self._now: set[tuple[str, int]] = set()

    def _start(self, frame: FrameType, _event: str, _arg: object) -> None:
        self._now.add((frame.f_code.co_filename, frame.f_code.co_firstlineno))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        """Note what the fixtures enter."""
        begun = time.process_time()
        yield from self._watched(str(item.path))
        self.seconds[item.nodeid] = time.process_time() - begun

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Note what the test enters, and how long it takes."""
        begun = time.process_time()
        setup = self.seconds.pop(item.nodeid)
        yield from self._watched(item.nodeid)  # one that fails without a mutant is not asked about any
        self.seconds[item.nodeid] = setup + time.process_time() - begun

    def _watched(self, key: str) -> Iterator[None]:
        self._now = self.entered.setdefault(key, set())
        sys.settrace(self._start)
        try:
            return (yield)
        finally:
            sys.settrace(None)

    def concerned(self, file: str, lines: range, seconds: float) -> list[str]:
        """The tests that enter a function between these lines, the quickest first, as many as fit in the time."""
        found = []
        for name in sorted(self.seconds, key=self.seconds.__getitem__):
            seen = self.entered[name] | self.entered.get(str(ROOT / name.partition("::")[0]), set())
            if self.seconds[name] < SLOW and any(path == file and line in lines for path, line in seen):
                seconds -= self.seconds[name]
                if seconds < 0:
                    break
                found.append(name)
        return found


class Chosen:
    """A plugin that runs these tests in this order and no others."""

    def __init__(self, names: list[str]) -> None:
        self.place = {name: i for i, name in enumerate(names)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave the others out."""
        items[:] = sorted((i for i in items if i.nodeid in self.place), key=lambda item: self.place[item.nodeid])


def killed(module: object, tree: ast.Module, function: str, tests: list[str], seconds: int) -> str:
    """How a mutant ended: killed, timed out (as good), alive, never entered by a test, or not put in its place."""
    if not tests:
        return "not entered"
    child = os.fork()
    if not child:
        os.setsid()
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 1)
        os.dup2(null, 2)
        status = 9
        try:
            if function in patched(module, tree):
                signal.alarm(seconds)
                files = sorted({name.partition("::")[0] for name in tests})
                status = int(pytest.main([*QUIET, *files], plugins=[Chosen(tests)]))
        finally:
            os._exit(status)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "timed out"
    return {0: "alive", 1: "killed"}.get(os.WEXITSTATUS(status), f"not put in place ({os.WEXITSTATUS(status)})")


def _tree(name: str) -> ast.Module:
    return ast.parse(Path(str(inspect.getsourcefile(importlib.import_module(name)))).read_text("utf-8"))


def _drawn(only: str, seed: int) -> tuple[list[tuple[str, int, str, str, range]], int]:
    """All mutants, one of each module in turn, in random order; and their number."""
    module, _, within = only.partition(":")
    groups = []
    for name in (*TARGETS, *SINGLE):
        functions = SINGLE.get(name)
        group = [
            (name, i, function, said, lines)
            for i, (function, said, lines) in enumerate(mutants(_tree(name)))
            if module in name and within in ("", function, f"{function} {said}")
            if functions is None or function in functions
        ]
        random.Random(f"{seed} {name}").shuffle(group)
        groups.append(group)
    turns = [one for turn in itertools.zip_longest(*groups) for one in turn if one is not None]
    return turns, len(turns)


def main() -> int:
    """Draw mutants and print what became of them, survivors with their place."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draw", type=int, default=160)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=int, default=60, help="for all, the first run of the tests aside")
    parser.add_argument("--each", type=int, default=4, help="of CPU for the tests of one mutant")
    parser.add_argument("--only", action="append", help="module, module:function, or module:what is printed")
    given = parser.parse_args()
    os.chdir(ROOT)
    sys.path.insert(0, str(ROOT))
    watch = Watch()
    pytest.main([*QUIET[1:], *TESTS], plugins=[watch])  # also fills the caches that the forked processes inherit
    drawn, counts = [], dict.fromkeys(("killed", "timed out", "alive", "not entered"), 0)
    total = 0
    for only in given.only or [""]:
        some, number = _drawn(only, given.seed)
        drawn, total = drawn + some, total + number
    end = time.monotonic() + given.seconds
    for name, place, function, said, lines in drawn[: given.draw]:
        if time.monotonic() > end:
            break
        tree, module = _tree(name), importlib.import_module(name)
        next(itertools.islice(mutants(tree), place, None))
        tests = watch.concerned(str(inspect.getsourcefile(module)), lines, given.each)
        how = killed(module, ast.fix_missing_locations(tree), function, tests, 10 * given.each)
        counts[how] = counts.get(how, 0) + 1
        print(f"{how}  {name} {function} {said}", flush=True)
    print(f"{total} mutants, {sum(counts.values())} looked at: {counts}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

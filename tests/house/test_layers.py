"""The arrows between modules, and what no module may contain."""

import ast
import re
import subprocess
import sys
import unicodedata
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MODULES = sorted(
    path.relative_to(ROOT).as_posix() for package in ("lure", "analysis") for path in (ROOT / package).rglob("*.py")
)
DRAWING = re.compile(r"analysis/((rod/)?plots/.*|drawing\.py)")  # the last for the name of the type Axes alone
HEAVY = {"numpy", "control", "flint", "jinja2", "matplotlib", "pydantic", "rich", "scipy", "sympy", "typer"}
LONGEST = 600  # one concept a file; KERNEL below holds the files that are read as one argument
KERNEL = {"analysis/certificates/checker.py": 440}  # read from its first line to its last, as one argument
# Directories of one machine, Windows drives, package registries.  Written so that this file does not match itself.
MACHINE = re.compile(
    r"/(?:root|work|opt|farm|Users|home/\w+|tmp/bash_jobs)/|\b[A-Z]:\\{1,2}Users|pypi\.org|pythonhosted\.org"
)


def imported(tree):
    """Packages a module imports anywhere, by statement or by name in a call: the first two parts of their names."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (package(alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield package(node.module)
            yield from (package(f"{node.module}.{alias.name}") for alias in node.names if node.module == "lure")
        elif isinstance(node, ast.Call) and called(node) in {"__import__", "import_module"}:
            yield from (package(arg.value) for arg in node.args if isinstance(arg, ast.Constant))


def package(module):
    """`lure.analysis` for what is inside it; of other modules the first part of the name."""
    return "lure.analysis" if module.startswith("lure.analysis") else module.split(".")[0]


def called(call):
    """Last name of what is called: `f` of `f()` and of `module.f()`."""
    return getattr(call.func, "id", getattr(call.func, "attr", None))


def evaluates(tree):
    """Whether a builtin that runs text as Python is mentioned at all, called or handed on."""
    names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    of_builtins = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", None) in {"builtins", "__builtins__"}
    }
    return bool((names | of_builtins) & {"eval", "exec", "compile"})


@cache
def text_of(module):
    """The text as Python reads its names: other forms of a letter are that letter."""
    return unicodedata.normalize("NFKC", (ROOT / module).read_text(encoding="utf-8"))


@cache
def parsed(module):
    return ast.parse(text_of(module), module)


def naming(modules, *words):
    """Those that have one of the words in their text, or import by name: what the others import need not be read."""
    return [
        module for module in modules if any(word in text_of(module) for word in (*words, "__import__", "import_module"))
    ]


@cache
def packages(module):
    return frozenset(imported(parsed(module)))


@pytest.mark.parametrize(
    "text",
    [
        "import lure.analysis",
        "import lure.analysis.plots as p",
        "from lure.analysis import x",
        "from lure import analysis",
        "def f():\n    import os, lure.analysis",
        "importlib.import_module('lure.analysis.x')",
        "__import__('lure.analysis')",
    ],
)
def test_every_spelling_of_an_import_is_seen(text):
    assert "lure.analysis" in imported(ast.parse(text))


@pytest.mark.parametrize(
    "text", ["eval('1')", "f = exec", "builtins.eval('1')", "map(eval, x)", "compile(x, '', 'eval')"]
)
def test_every_spelling_of_eval_is_seen(text):
    assert evaluates(ast.parse(text))


@pytest.mark.parametrize("text", ["evalf()", "x.eval()", "re.compile('x')", "evaluate = 1", "'eval(1)'"])
def test_what_only_sounds_like_eval_is_let_through(text):
    assert not evaluates(ast.parse(text))


@pytest.mark.parametrize(
    "text", ["/root" + "/x", "'/home" + "/me/x'", "C:" + "\\Users\\me", "https://pypi" + ".org/simple"]
)
def test_every_spelling_of_a_machine_path_is_seen(text):
    assert MACHINE.search(text)


def test_both_packages_are_looked_at():
    assert {"lure/__init__.py", "analysis/__init__.py"} <= set(MODULES)


def test_the_systems_never_import_the_analysis():
    systems = naming((module for module in MODULES if module.startswith("lure/")), "analysis")
    assert [module for module in systems if "lure.analysis" in packages(module)] == []


def test_only_the_plots_import_matplotlib():
    others = naming((module for module in MODULES if not DRAWING.fullmatch(module)), "matplotlib", "mpl_toolkits")
    assert [module for module in others if {"matplotlib", "mpl_toolkits"} & packages(module)] == []


def test_importing_lure_loads_nothing_heavy():
    script = "import sys, lure; print(*{name.split('.')[0] for name in sys.modules})"
    run = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = set(run.stdout.split())
    assert "lure" in loaded
    assert not HEAVY & loaded


def test_a_module_fits_in_the_head():
    lines = {module: (ROOT / module).read_text(encoding="utf-8").count("\n") for module in MODULES}
    long = {module: count for module, count in lines.items() if count > KERNEL.get(module, LONGEST)}
    assert long == {}, "split each into two ideas"


def test_no_module_runs_text_as_python():
    assert [module for module in naming(MODULES, "eval", "exec", "compile") if evaluates(parsed(module))] == []


def test_no_file_names_a_directory_of_one_machine_or_a_registry():
    files = [path for path in (ROOT / "Makefile", ROOT / ".ci/run") if path.exists()]
    files += [path for pattern in ("*.toml", "*.txt", "*.md", "*.cff") for path in ROOT.glob(pattern)]
    folders = ("lure", "analysis", "tests", "benchmarks", "notebooks", "docs")
    files += [
        path
        for folder in folders
        for kind in ("py", "md", "rst", "toml", "json", "j2")
        for path in (ROOT / folder).rglob(f"*.{kind}")
    ]
    found = {path.relative_to(ROOT).as_posix(): MACHINE.findall(path.read_text(encoding="utf-8")) for path in files}
    assert {name: hits for name, hits in found.items() if hits} == {}

"""From a rational plant to a checked certificate and its sentence: the standard library and python-flint are enough."""

import ast
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
OTHERS = (
    *("numpy", "scipy", "matplotlib", "sympy", "pydantic", "control", "rich", "typer", "jinja2", "numba", "xarray"),
    *("threadpoolctl", "pandas", "llvmlite"),
)
CORE = (  # rooms and modules that are imported without the packages above
    *("lure/*.py", "lure/expressions/*.py", "lure/nonlinearities/*.py", "lure/plants/*.py"),
    *("analysis/__init__.py", "analysis/deadline.py", "analysis/verdict.py"),
    *("analysis/numerics/*.py", "analysis/inequality/*.py", "analysis/theorems/*.py", "analysis/questions/*.py"),
    *("analysis/certificates/**/*.py", "analysis/counterexamples/*.py", "analysis/nonlinearity/*.py"),
)
EXACT = (  # and of these, those that compute with nothing else: no array at all
    *("lure/bounds.py", "lure/classes.py", "lure/exact.py", "lure/expressions/rigorous.py", "lure/plants/text.py"),
    *("analysis/numerics/polynomial.py", "analysis/numerics/minimum.py", "analysis/numerics/trigonometric.py"),
    *("analysis/numerics/precision.py", "analysis/numerics/doubles.py"),
    *("analysis/inequality/polynomial.py", "analysis/inequality/plant.py", "analysis/inequality/checks.py"),
    *("analysis/inequality/gains.py", "analysis/inequality/multiplier_search.py"),
    *("analysis/theorems/circle.py", "analysis/theorems/popov.py", "analysis/theorems/park.py"),
    *("analysis/theorems/criterion.py", "analysis/theorems/differences.py", "analysis/theorems/off_axis.py"),
    *("analysis/certificates/checker.py", "analysis/certificates/states.py", "analysis/certificates/blocks.py"),
    *("analysis/certificates/channels.py", "analysis/certificates/several.py"),
    *(
        "analysis/certificates/gains.py",
        "analysis/certificates/memory.py",
        "analysis/certificates/signals.py",
        "analysis/certificates/windows.py",
        "analysis/certificates/parametric.py",
        "analysis/certificates/parts.py",
        "analysis/certificates/pieces.py",
        "analysis/certificates/powers.py",
        "analysis/certificates/boxes.py",
        "analysis/certificates/regions.py",
        "analysis/certificates/frequencies.py",
    ),
    *("analysis/certificates/arithmetic.py", "analysis/certificates/balls.py", "analysis/certificates/second/*.py"),
    *("analysis/certificates/codes.py", "analysis/certificates/drafts.py", "analysis/questions/conclusion.py"),
    *("analysis/questions/answers.py", "analysis/questions/search.py", "analysis/wording.py"),
)


def files(patterns):
    return sorted(path.relative_to(ROOT).as_posix() for pattern in patterns for path in ROOT.glob(pattern))


def at_import(nodes):
    """Modules that are imported when a module is, those of its functions and of type checkers left out."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield node.module
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from at_import(node.orelse)
        elif not isinstance(node, ast.FunctionDef):
            yield from at_import(ast.iter_child_nodes(node))


@cache
def needed(module):
    return set(at_import(ast.parse((ROOT / module).read_text(encoding="utf-8")).body))


def without(script):
    """What a script prints where none of the other packages can be imported."""
    head = f"import sys\nfor name in {OTHERS}:\n    sys.modules[name] = None\n"
    run = subprocess.run([sys.executable, "-c", head + script], cwd=ROOT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout


def foreign(module):
    """Packages that a module imports besides the standard library and flint."""
    beside = {path.stem for path in (ROOT / module).parent.glob("*.py")}  # the checker's files run as scripts, too
    packages = {name.split(".")[0] for name in needed(module)} - beside
    return packages - {"flint", "lure", *sys.stdlib_module_names}


def test_the_core_is_imported_with_the_standard_library_and_flint_alone():
    assert {module: names for module in files(CORE) if (names := foreign(module))} == {}


def test_what_is_exact_holds_no_array():
    assert [module for module in files(EXACT) if "lure.arrays" in needed(module)] == []


@pytest.mark.parametrize("module", files(["analysis/certificates/second/*.py"]))
def test_the_second_checker_shares_nothing_with_the_search_or_the_first_checker(module):
    tree = ast.parse((ROOT / module).read_text(encoding="utf-8"))
    names = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    names |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    foreign = {name for name in names if not f"{name}.".startswith("lure.analysis.certificates.second.")}
    assert {name.split(".")[0] for name in foreign} <= {"flint", *sys.stdlib_module_names}


def test_each_pattern_names_something():
    assert [pattern for pattern in (*CORE, *EXACT) if not list(ROOT.glob(pattern))] == []


@pytest.mark.parametrize(
    "text",
    ["import numpy", "try:\n    from numpy import pi\nexcept ImportError: pass", "class A:\n    import numpy.linalg"],
)
def test_every_import_of_a_module_is_seen(text):
    assert {name.split(".")[0] for name in at_import(ast.parse(text).body)} == {"numpy"}


# 1/(s^3 + 3 s^2 + 2 s): with the gain k the loop s^3 + 3 s^2 + 2 s + k is stable for 0 < k < 6 (Routh).  With theta =
# 3/2 is Re[(1 + i w theta) H(iw)] = -(3/2) w^2/((1 + w^2)(4 + w^2)) >= -1/6, at w^2 = 2: Popov proves every k < 6.
POPOV = """
from lure.analysis import max_sector, certify, check
from lure.analysis.certificates.second import recheck
from lure import NonlinearityClass, Sector
found = max_sector(([1], [1, 3, 2, 0]))
print(found)
print(type(check(found.proof.certificate)).__name__, recheck(found.proof.certificate).accepted)
print(recheck(found.witness.refutation.certificate).accepted)
for k in (5, 7):
    shown = certify(([1], [1, 3, 2, 0]), NonlinearityClass(sector=Sector(0, k)))
    print(shown.verdict, type(check(shown.certificate)).__name__, recheck(shown.certificate).accepted)
"""


@pytest.mark.slow
def test_a_sector_its_certificates_and_both_checkers_need_nothing_else():
    lines = without(POPOV).splitlines()
    assert lines[0] == (
        "Every solution converges to the set of equilibria for every phi, time-invariant, "
        "in the sector [0, 5.999999999] "
        "(popov, certified); phi = 6 sigma: the loop is not asymptotically stable (certified)."
    )
    assert lines[1:] == ["Proved True", "True", "PROVED Proved True", "REFUTED Refuted True"]


# s^3 + 2 s^2 + 2 s + 1 + k is stable for k < 3 (Routh: 2 * 2 > 1 + k); s^4 + 2 s^3 + 3 s^2 + (4 + k) s + 1 for
# (2 - k)(4 + k) > 4, k < sqrt(5) - 1; z^2 - z/2 + 1/4 + k for k < 3/4 (Jury).
@pytest.mark.slow
def test_slopes_need_nothing_else():
    wanted = {
        "([1], [1, 2, 2, 1])": ("popov", 3 * (1 - 1e-8), 3.0),
        "([1, 0], [1, 2, 3, 4, 1])": ("popov", 1.236067, 5**0.5 - 1),
        "'1/(z**2 - z/2 + 1/4)'": ("jury-lee", 0.75 * (1 - 1e-8), 0.75),
    }
    lines = without(
        f"from lure.analysis import max_slope\nfor plant in ({', '.join(wanted)}):\n"
        "    found = max_slope(plant, search='linear')\n"
        "    print(found.verdict, found.criterion, found.largest.low, found.refuted_at, found.evidence)"
    ).splitlines()
    for line, (criterion, low, refuted) in zip(lines, wanted.values(), strict=True):
        verdict, by, reached, at, evidence = line.split()
        assert (verdict, by, evidence) == ("PROVED", criterion, "certified")
        assert low <= float(reached) < float(at) == pytest.approx(refuted, rel=1e-6)


@pytest.mark.slow
def test_a_step_that_needs_another_package_is_left_out_and_says_so():
    late, taps = without(
        "from lure.analysis import max_sector, max_slope\nprint(max_sector('exp(-s)/(s + 1)').reason)\n"
        "found = max_slope('(2*z + 0.92)/(z**2 - 0.5*z)', search='linear')\n"
        "print(*(f'{each.criterion}: {each.reason}' for each in found.answers))"
    ).splitlines()
    assert "needs numpy, which cannot be imported" in late
    assert "zames-falb: this step needs numpy" in taps

"""Imports point down the floors of CONTRIBUTING.md, form no circle, and no general room knows the rod."""

import ast
import re
from collections import Counter, defaultdict
from fractions import Fraction
from functools import cache, partial
from importlib import import_module
from pathlib import Path

import pytest

from lure.analysis.drawing import drawing
from lure.extensions import SERVED, extension

ROOT = Path(__file__).parents[2]
ROD = {"lure/rod", "analysis/rod"}
MAY_KNOW_THE_ROD = ROD | {"analysis/cli", "lure", "analysis"}  # the top packages hand names out
TOP = {"lure", "analysis"}


def floors(text):
    """The rooms of the table of floors, from the bottom; within a row from left to right."""
    for line in text.splitlines():
        if re.match(r"\| `(?:lure|analysis)/", line):
            folder = ""
            for name in re.findall(r"`([\w/]+)`", line.split("|")[1]):
                folder = name.rpartition("/")[0] or folder
                yield f"{folder}/{name.rpartition('/')[2]}"


ORDER = {room: floor for floor, room in enumerate(floors((ROOT / "CONTRIBUTING.md").read_text("utf-8")))}


@cache
def sources():
    """Path of every module and stub by its name; a stub's name ends in `.pyi`."""
    found = {}
    for package, outer in (("lure", ""), ("analysis", "lure.")):
        for path in sorted((ROOT / package).rglob("*.py*")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            if path.suffix in {".py", ".pyi"} and parts[:2] != ("lure", "analysis"):
                name = outer + ".".join(parts).removesuffix(".__init__")
                found[name + path.suffix.removeprefix(".py")] = path
    return found


@cache
def exports(package):
    """Where a package's stub says that its names come from."""
    path = sources().get(f"{package}i")
    text = path.read_text("utf-8") if path is not None and path.suffix == ".pyi" else ""
    return {name: home for home, name in re.findall(r"^from (lure[\w.]*) import (\w+) as \w+", text, re.MULTILINE)}


@cache
def module_of(name):
    """The module that a dotted name is or lies in, behind what packages hand out."""
    outer, _, last = name.rpartition(".")
    while outer and name not in sources():
        if last in exports(outer):
            return module_of(f"{exports(outer)[last]}.{last}")
        name, (outer, _, last) = outer, outer.rpartition(".")
    return name


def imported(tree, package=""):
    """Modules of this house that a source names: imports at any depth, and texts that are a module's name."""
    for node in ast.walk(tree):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            home = ".".join(filter(None, [package if node.level else "", node.module]))
            names = [f"{home}.{alias.name}" for alias in node.names if alias.name != "__version__"]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            known = node.value.startswith("lure.") and re.fullmatch(r"lure(\.\w+)+(:\w+)?", node.value)
            names = [node.value] if known else []
        yield from (module_of(name.replace(":", ".")) for name in names if name.split(".")[0] == "lure")


def room_of(module):
    """The room of the table that a module lies in: the longest that fits."""
    path = module.removeprefix("lure.").replace(".", "/") if module.startswith("lure.analysis") else module
    parts = path.replace(".", "/").split("/")
    fitting = ("/".join(parts[:length]) for length in range(len(parts), 0, -1))
    return next(room for room in fitting if room in ORDER or room in TOP)


@cache
def arrows():
    """Rooms that import one another, each pair with the modules that do."""
    found = defaultdict(set)
    for name, path in sources().items():
        here = room_of(name.removesuffix("i") if path.suffix == ".pyi" else name)
        package = "lure." * (path.relative_to(ROOT).parts[0] != "lure") + ".".join(path.relative_to(ROOT).parts[:-1])
        for target in imported(ast.parse(path.read_text("utf-8"), str(path)), package):
            if room_of(target) != here:
                found[here, room_of(target)].add(path.relative_to(ROOT).as_posix())
    return found


def points_up(here, there):
    return here not in TOP and (there in TOP or ORDER[there] > ORDER[here])


def knows_the_rod(here, there):
    return there in ROD and here not in MAY_KNOW_THE_ROD


def in_circles(pairs):
    """Rooms from which imports lead back to them."""
    onward = defaultdict(set)
    for here, there in pairs:
        onward[here].add(there)

    def reached(room):
        seen, left = set(), list(onward[room])
        while left:
            if (one := left.pop()) not in seen:
                seen.add(one)
                left += onward[one]
        return seen

    return {room for room in list(onward) if room in reached(room)}


def test_the_table_of_floors_names_every_room_once():
    names = re.findall(r"^\| `.*$", (ROOT / "CONTRIBUTING.md").read_text("utf-8"), re.MULTILINE)
    assert Counter(floors("\n".join(names))).most_common(1)[0][1] == 1
    outside = {name for name in sources() if room_of(name.removesuffix("i")) in TOP} - {"lure", "lure.analysis"}
    assert {name for name in outside if not name.endswith("i")} == set()


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("import lure.analysis.report", "lure.analysis.report"),
        ("from lure.analysis import report", "lure.analysis.report"),
        ("from lure.rod import Rod", "lure.rod.parameters"),
        ("def f():\n    from lure.rod.parameters import Rod", "lure.rod.parameters"),
        ("if TYPE_CHECKING:\n    from lure.rod import motion as m", "lure.rod.motion"),
        ("import_module('lure.rod.discretisation')", "lure.rod.discretisation"),
        ("HOME = 'lure.rod.discretisation:upwind'", "lure.rod.discretisation"),
    ],
)
def test_every_spelling_of_an_import_is_seen(source, module):
    assert list(imported(ast.parse(source))) == [module]


def test_an_arrow_up_the_rod_and_a_circle_are_seen():
    assert points_up("lure/plants", "analysis/plots")
    assert points_up("analysis/report", "analysis")
    assert not points_up("analysis/plots", "lure/plants")
    assert knows_the_rod("analysis/plots", "lure/rod")
    assert not knows_the_rod("analysis/cli", "lure/rod")
    assert in_circles({("a", "b"), ("b", "c"), ("c", "b")}) == {"b", "c"}


def test_imports_point_down_and_no_general_room_knows_the_rod():
    found = {pair: sorted(who) for pair, who in arrows().items() if points_up(*pair) or knows_the_rod(*pair)}
    assert found == {}


def test_no_circle_between_rooms():
    assert in_circles(arrows()) == set()


def test_whoever_serves_a_type_from_above_is_there_and_so_is_the_type():
    assert {"drawing", "file"} <= set(SERVED)
    for place in (place for served in SERVED.values() for pair in served.items() for place in pair):
        module, name = place.split(":")
        assert hasattr(import_module(module), name), place


def test_the_nearest_base_that_is_served_is_found_and_else_nothing():
    assert extension("file", partial(print)).__name__ == "render"
    assert extension("drawing", Fraction(1)) is None
    with pytest.raises(TypeError, match="no drawing of a Fraction"):
        drawing(Fraction(1))

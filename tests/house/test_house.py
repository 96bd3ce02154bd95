"""What pyproject.toml, constraints.txt and the docstrings promise one another."""

import importlib
import inspect
import pkgutil
import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import lure

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PINS = [
    Requirement(line)
    for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").split("\n")
    if line[:1] not in ("", "#")
]
SUPPORTED = [entry.split()[-1] for entry in PROJECT["project"]["classifiers"] if re.search(r"Python :: 3\.\d+$", entry)]
WANTED = [
    requirement
    for group in (
        PROJECT["build-system"]["requires"],
        PROJECT["project"]["dependencies"],
        *PROJECT["project"]["optional-dependencies"].values(),
    )
    for requirement in map(Requirement, group)
    if requirement.name != "lure"
]


def exported():
    """Every function of ours that `lure`, `analysis` or a package inside them hands out."""
    inner = pkgutil.walk_packages(lure.__path__, "lure.")
    for home in (lure, *(importlib.import_module(module.name) for module in inner if module.ispkg)):
        for name in {*vars(home), *getattr(home, "__all__", ())}:
            member = getattr(home, name)
            if inspect.isfunction(member) and member.__module__.startswith("lure") and not name.startswith("_"):
                yield f"{home.__name__}.{name}", member


@pytest.mark.parametrize("python", SUPPORTED)
@pytest.mark.parametrize("wanted", WANTED, ids=str)
def test_constraints_pin_every_dependency_to_one_version_it_allows(wanted, python):
    pins = [
        pin
        for pin in PINS
        if canonicalize_name(pin.name) == canonicalize_name(wanted.name)
        and (pin.marker is None or pin.marker.evaluate({"python_version": python}))
    ]
    assert len(pins) == 1
    (pinned,) = pins[0].specifier
    assert pinned.operator == "=="
    assert wanted.specifier.contains(pinned.version)


def test_the_docstring_of_an_exported_function_names_each_of_its_arguments():
    silent = {
        name: [argument for argument in inspect.signature(function).parameters if argument not in words]
        for name, function in exported()
        for words in [set(re.findall(r"\w+", function.__doc__ or ""))]
    }
    assert {name: missing for name, missing in silent.items() if missing} == {}

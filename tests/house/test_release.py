"""What is published beside the wheel says what the package says: the version, what it needs, what the paper cites."""

import re
import tomllib
from pathlib import Path

import pytest

import lure

yaml = pytest.importorskip("yaml")
ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def read(name):
    """A file of the repository, as text."""
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_recipe_needs_what_the_wheel_needs():
    recipe = yaml.safe_load(read("recipe/recipe.yaml"))
    assert (recipe["package"]["name"], recipe["context"]["version"]) == ("lure", lure.__version__)
    names = {"matplotlib": "matplotlib-base"}  # conda-forge's matplotlib brings Qt along
    wanted = {re.sub(r"^[a-z-]+", lambda name: names.get(name[0], name[0]), need) for need in PROJECT["dependencies"]}
    found = {need.replace(" ", "") for need in recipe["requirements"]["run"]}
    assert found == wanted | {f"python{PROJECT['requires-python']}"}
    assert recipe["build"]["python"]["entry_points"] == [
        f"{name} = {door}" for name, door in PROJECT["scripts"].items()
    ]


def test_the_citation_names_the_version_and_the_paper_cites_what_is_listed():
    assert yaml.safe_load(read("CITATION.cff"))["version"] == lure.__version__
    head, text = read("paper/paper.md").removeprefix("---\n").split("\n---\n", 1)
    head = yaml.safe_load(head)
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(head)
    listed = re.findall(r"^@\w+\{(\w+),", read("paper/paper.bib"), re.MULTILINE)
    assert sorted(set(re.findall(r"@(\w+)", text))) == sorted(listed)
    drawn = set(re.findall(r"\]\((\w+\.svg)\)", text))
    assert drawn == set(re.findall(r"build/paper/(\w+\.svg)$", read("Makefile"), re.MULTILINE))

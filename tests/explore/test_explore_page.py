"""The folder of the page: whole, by itself, and never half written."""

import json
import re

import pytest

from lure.analysis.explore import runtime as runtimes
from lure.analysis.explore.build import packages, page_text, with_bytecode
from lure.analysis.explore.runtime import asset, content


@pytest.fixture
def fetched(monkeypatch, tmp_path):
    """A folder in the place of what is fetched from the package indices."""
    kept = tmp_path / "kept"
    kept.mkdir()
    (kept / "pyodide.mjs.js").write_text(asset("pyodide.mjs", b"export {}"), encoding="ascii")
    monkeypatch.setattr("lure.analysis.explore.build.runtime", lambda: kept)
    monkeypatch.setattr("lure.analysis.explore.build._node", lambda: None)
    return kept


@pytest.mark.slow
def test_the_page_is_a_folder_that_opens_with_the_loop(lure, here, fetched):
    (here / "plant.toml").write_text(
        '[plant]\ntransfer = "1/(s*(s+2/3))"\n[class]\nslope = [0, 5.9]\nodd = true\n', encoding="utf-8"
    )
    assert lure("explore", "plant.toml", "-o", "page")[0] == 0
    assert sorted(path.name for path in (here / "page").iterdir()) == ["assets", "explore.json", "index.html"]
    text = (here / "page/index.html").read_text("utf-8")
    start = json.loads(re.search(r'id="start">(.*?)</script>', text, re.DOTALL)[1])
    assert start["state"] == {
        **{"form": "num", "num": "1", "den": "1, 2/3, 0", "dt": ""},
        **{"class": "odd", "lower": "0", "k": "5.9"},
    }
    assert lure("explore", "-o", "page", "--quiet") == (0, "", "")  # its own folder is replaced


def test_the_page_asks_nobody_for_anything():
    text = page_text({"form": "num", "num": "1", "den": "1 1"})
    assert set(re.findall(r"https?://[\w.]+", text)) <= {"http://www.w3.org", "https://page.invalid"}
    assert re.findall(r'(?:src|href)="(?!#|data:)[^"]*"', text) == []
    assert re.findall(r"@\w+@", text) == []
    wanted = {"verdict", "reach", "k", "theta"}
    assert wanted <= set(re.findall(r'id="([\w-]+)"', text))


def test_every_field_has_a_label_and_a_place_for_its_sentence():
    text = page_text({})
    for name in re.findall(r'<(?:input|select) id="([\w-]+)"', text):
        if not name.endswith("-slider"):
            assert f'<label for="{name}">' in text
            assert f'id="{name}-error"' in text
        else:
            assert re.search(rf'id="{name}"[^>]*aria-label=', text)


def test_the_archive_holds_the_checkers_and_no_drawings():
    names = set(re.findall(rb"lure/[\w/]+\.pyi?", packages()))
    assert {b"lure/analysis/certificates/checker.py", b"lure/analysis/certificates/second/__init__.py"} <= names
    assert not [name for name in names if b"/plots/" in name or b"/cli/" in name]


@pytest.mark.parametrize("node", [None, ["false"], ["no-such-command"]])
def test_without_node_the_package_is_handed_over_as_sources(fetched, monkeypatch, node):
    monkeypatch.setattr("lure.analysis.explore.build._node", lambda: node)
    handed = with_bytecode(b"sources", fetched)
    assert [(name, content(text)) for name, text in handed.items()] == [("core.zip.js", b"sources")]
    assert [path.name for path in fetched.parent.iterdir()] == ["kept"]  # nothing unfinished is kept


def test_a_folder_with_something_else_is_left_alone(lure, here, fetched):
    (here / "page").mkdir()
    (here / "page/mine.txt").write_text("mine", encoding="utf-8")
    status, _, err = lure("explore", "-o", "page")
    assert (status, len(err.splitlines())) == (2, 1)
    assert "mine.txt" in err
    assert [path.name for path in (here / "page").iterdir()] == ["mine.txt"]


def test_a_loop_with_several_channels_is_refused_before_anything_is_fetched(lure, here, monkeypatch):
    monkeypatch.setattr("lure.analysis.explore.build.runtime", None)
    status, _, err = lure("explore", "secant-ring", "-o", "page")
    assert status == 2
    assert "rational transfer function of one channel" in err
    assert "its plant is a MultivariablePlant; ask the command lure analyse" in err
    assert not (here / "page").exists()


def test_a_file_in_place_of_the_folder_is_refused_before_anything_is_fetched(lure, here, monkeypatch):
    monkeypatch.setattr("lure.analysis.explore.build.runtime", None)
    (here / "page").write_text("mine", encoding="utf-8")
    status, _, err = lure("explore", "-o", "page")
    assert (status, err) == (2, "lure: 'page' is a file; give a directory with -o\n")


@pytest.mark.parametrize(
    ("npm", "said"),
    [
        (None, "there is no npm; install Node.js"),
        ("echo no network >&2; exit 1", "npm could not fetch what the page needs (no network)"),
        ("exit 0", "npm did not fetch pyodide-314.0.7.tgz as it was published"),
        ("while [ $# -gt 1 ]; do shift; done; echo other > $1/pyodide-314.0.7.tgz", "as it was published"),
    ],
)
def test_what_cannot_be_fetched_is_one_sentence_and_leaves_nothing(lure, here, monkeypatch, npm, said):
    (here / "bin").mkdir()
    if npm is not None:
        (here / "bin/npm").write_text(f"#!/bin/sh\n{npm}\n", encoding="ascii")
        (here / "bin/npm").chmod(0o755)
    monkeypatch.setenv("PATH", str(here / "bin"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(here / "cache"))
    monkeypatch.setattr(runtimes, "find_spec", lambda name: None)
    status, out, err = lure("explore", "-o", "page")
    assert (status, out, len(err.splitlines())) == (2, "", 1)
    assert said in err
    assert not (here / "page").exists()
    assert list((here / "cache/lure").iterdir()) == []


@pytest.mark.parametrize(
    ("found", "said"),
    [(None, "there is no pip"), pytest.param(object(), "pip could not fetch", marks=pytest.mark.slow)],
)
def test_a_wheel_that_cannot_be_fetched_is_one_sentence(lure, here, monkeypatch, found, said):
    monkeypatch.setenv("XDG_CACHE_HOME", str(here / "cache"))
    monkeypatch.setattr(runtimes, "_pyodide", lambda folder: folder)
    monkeypatch.setattr(runtimes, "find_spec", lambda name: found)
    monkeypatch.setattr(runtimes, "FLINT", "python_flint-0.0.0-none.whl")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    status, _, err = lure("explore", "-o", "page")
    assert (status, len(err.splitlines())) == (2, 1)
    assert said in err
    assert list((here / "cache/lure").iterdir()) == []

"""The documentation: ``make docs`` runs every block of code on every page, and builds them; the pages fit."""

import json
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest
from documents import Page, blocks, run_page, same

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
COLLECTED = {"notebooks", "notes", "project", "pictures", "_ext", "_static", "_templates"}
PAGES = sorted(path for path in DOCS.rglob("*.md") if path.relative_to(DOCS).parts[0] not in COLLECTED)


def named(path):
    """A page as a parameter."""
    return pytest.param(path, id=path.relative_to(DOCS).as_posix())


def module(name, path):
    """A module of `docs/`, which is no package."""
    spec = spec_from_file_location(name, path)
    found = sys.modules[name] = module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


links = module("docs_links", DOCS / "links.py")


@pytest.mark.pages
@pytest.mark.usefixtures("sketched")
@pytest.mark.parametrize("path", [named(path) for path in PAGES])
def test_what_a_page_shows_is_what_happens(path, tmp_path):
    fences = re.findall(
        r"^ *```(?:\{code-block\} +)?(?:python|console)$", path.read_text(encoding="utf-8"), re.MULTILINE
    )
    assert run_page(path, tmp_path) >= len(fences)  # and files besides


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(DOCS).as_posix())
def test_every_block_is_run_or_read(path):
    for block in blocks(path.read_text(encoding="utf-8")):
        if block.file is None and block.language == "json":
            json.loads(block.text)
        elif (
            block.file is None and block.language == "sh"
        ):  # shown to a shell: the commands after them are run elsewhere
            assert "$ " not in block.text, "prompts stand in `console`"
        elif block.file is None and path.parent.name != "theory":  # there, formulas and drawings without a language
            assert block.language in {"python", "console"}, f"{path.name}:{block.line}"
        if block.file is None and block.language == "python":
            assert ">>>" in block.text, f"{path.name}:{block.line}: no prompt"


def test_every_part_of_the_certificate_format_is_on_one_page():
    schema = json.loads((ROOT / "analysis/certificates/schema.json").read_text(encoding="utf-8"))
    pages = [path.read_text(encoding="utf-8") for path in DOCS.glob("reference/certificate-*.rst")]
    shown = [page.split(".. json-schema:: lure.analysis.certificates certificate")[1] for page in pages]
    parts = " ".join(text for text in shown if ":whole:" not in text).split()
    assert sorted(parts) == sorted(schema["$defs"])


def test_every_figure_of_the_theory_has_its_page_and_its_words():
    drawn = set(re.findall(r"^@figure\ndef (\w+)", (DOCS / "_ext/figures.py").read_text("utf-8"), re.MULTILINE))
    drawn |= set(re.findall(r"^def (\w+)\(ax", (DOCS / "_ext/channel_figures.py").read_text("utf-8"), re.MULTILINE))
    shown = re.compile(
        r"^```\{figure\} \.\./pictures/theory/([\w-]+)\.svg\n:alt: \S.*\n:figclass: plot\n\n\S", re.MULTILINE
    )
    pages = {path.stem: shown.findall(path.read_text("utf-8")) for path in (DOCS / "theory").glob("*.md")}
    assert {name: [name] for name in (one.replace("_", "-") for one in drawn)} == {k: v for k, v in pages.items() if v}


def test_a_page_that_is_wrong_is_found_out(tmp_path):
    wrong = tmp_path / "page.md"
    for text in (
        "```python\n>>> 1 + 1\n3\n```\n",
        "```{note}\nwords\n```\n\n```python\n>>> undefined\n```\n",
        "```console\n$ lure --version\nlure 17\n```\n",
        "```console\n$ lure explain LURE-I999\n```\n",
        '```{code-block} python\n:caption: f.py\n\nprint("a")\n```\n```console\n$ python f.py\nb\n```\n',
    ):
        wrong.write_text(text, encoding="utf-8")
        with pytest.raises(AssertionError):
            run_page(wrong, tmp_path)
    wrong.write_text(text.replace("\nb\n", "\na\n"), encoding="utf-8")
    run_page(wrong, tmp_path)


def test_blocks_are_those_of_the_page():
    page = (
        "````{note}\n```{code-block} toml\n:caption: a.toml\n\nx = 1\n```\n````\n\n"
        "```{figure} b.svg\nwords\n```\n```\nplain\n```\n"
    )
    assert [(found.language, found.file, found.text) for found in blocks(page)] == [
        ("toml", "a.toml", "x = 1\n"),
        ("", None, "plain\n"),
    ]
    with pytest.raises(AssertionError, match="line 2"):
        blocks("words\n```python\n>>> 1\n")


def test_numbers_agree_to_five_digits_and_dots_stand_for_anything():
    assert same("k = 5.99999999 ...", "k = 5.9999999\n  by popov")
    assert not same("k = 5.9999", "k = 6.0001")
    assert not same("status 10", "status 11")


def test_the_status_of_a_command_is_looked_at(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refuted = 'lure max-sector --transfer "1/(s-1)"'
    (block,) = blocks(f"```console\n$ {refuted}\n$ echo $?\n11\n```\n")
    Page("page.md").run(block)
    (block,) = blocks(f"```console\n$ {refuted}\n```\n")
    with pytest.raises(AssertionError, match="ended with 11"):
        Page("page.md").run(block)


def test_links_of_a_site(tmp_path):
    (tmp_path / "a.html").write_text(
        '<p id="here"><a href="#here">1</a><a href="b.html#there">2</a><img src="c.svg"><a href="http://x.org/">3</a>'
        '<a href="b.html#nowhere">4</a><a href="gone.html">5</a><a href="../up.html">6</a><a href="#gone">7</a></p>'
        '<script src="https://y.org/z.js"></script>',
        encoding="utf-8",
    )
    (tmp_path / "b.html").write_text('<a name="there" href="a.html">back</a>', encoding="utf-8")
    (tmp_path / "c.svg").write_text("<svg/>", encoding="utf-8")
    assert links.check(tmp_path) == (
        [
            "a.html: #gone: no such anchor",
            "a.html: ../up.html: leads out of the site",
            "a.html: b.html#nowhere: no such anchor",
            "a.html: gone.html: no such file",
            "a.html: https://y.org/z.js: fetched from another site",
        ],
        {"http://x.org/": "a.html", "https://y.org/z.js": "a.html"},
    )
    assert links.main([str(tmp_path)]) == 1


def test_links_between_files_of_the_repository_follow_them_to_their_pages():
    pytest.importorskip("jupytext")
    collect = module("docs_collect", DOCS / "_ext" / "collect.py")
    known = collect.pages()
    assert known["notebooks/10-the-paper.py"] == "notebooks/10-the-paper.ipynb"
    text = "[a rod](45-the-rod-solved-exactly.py#a), [note 5](notes/0005-energy-theorem.md), [b](#b), ![x](y.svg)"
    assert collect.relinked(text, "notebooks/10-the-paper.py", known) == (
        "[a rod](45-the-rod-solved-exactly.ipynb#a), [note 5](../notes/0005-energy-theorem.md), [b](#b), ![x](y.svg)"
    )
    text = (
        "[`tests/`](tests), [the checker](analysis/certificates/checker.py), [x](https://x.org/y.py), [t](docs/a/b.md)"
    )
    assert collect.relinked(text, "CONTRIBUTING.md", known | {"CONTRIBUTING.md": "project/contributing.md"}) == (
        "`tests/`, the checker (`analysis/certificates/checker.py`), [x](https://x.org/y.py), [t](../a/b.md)"
    )


def test_sliders_become_what_they_show(tmp_path):
    nbformat = pytest.importorskip("nbformat")
    collect = module("docs_collect", DOCS / "_ext" / "collect.py")
    new, view = nbformat.v4, {"application/vnd.jupyter.widget-view+json": {"model_id": "1"}}
    cell = new.new_code_cell("interact(f)", outputs=[new.new_output("display_data", data=view)])
    state = {"1": {"state": {}}, "2": {"state": {"outputs": [new.new_output("stream", text="k = 5")]}}}
    states = {"application/vnd.jupyter.widget-state+json": {"state": state}}
    document = new.new_notebook(cells=[cell], metadata={"widgets": states})
    collect.frozen(document)
    nbformat.validate(document)
    assert "widgets" not in document.metadata
    assert [out["text"] for out in document.cells[0].outputs] == [collect._HINT["text"], "k = 5"]


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.relative_to(DOCS).as_posix())
def test_a_page_links_to_no_address_but_those_of_sources(path):
    text = path.read_text(encoding="utf-8")
    assert not re.findall(r"<(?:script|iframe|link)\b", text)
    assert not re.findall(r"!\[[^\]]*\]\(http|(?:figure|image)\} http", text), "pictures are the site's own"

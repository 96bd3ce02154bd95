"""The links of the documentation into the page: each leads to a loop that is proved, with the line it draws."""

import json
import re
from pathlib import Path
from urllib.parse import parse_qsl

import pytest

from lure.analysis.explore import respond

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {path.relative_to(DOCS).as_posix(): path.read_text("utf-8") for path in sorted(DOCS.rglob("*.md"))}
LINKS = sorted({link for text in PAGES.values() for link in re.findall(r"^```\{explore\} (\S+)$", text, re.MULTILINE)})
ASKS = re.compile(r"popov_response\((?!\.\.\.)|popov_largest\((?!block, \*)")
OWN = ("notebooks/", "notes/", "project/")  # copies of what stands elsewhere


def ask(kind, link):
    return json.loads(
        respond(json.dumps({"ask": kind, **dict(parse_qsl(link.replace("+", "%2B"), strict_parsing=True))}))
    )


@pytest.mark.parametrize("link", LINKS)
def test_a_link_shows_a_proof(link):
    assert ask("class", link)["verdict"] == "PROVED"
    assert "theta" not in link or ask("line", link)["accepted"]


def test_every_popov_example_has_a_link():
    examples = {
        name
        for name, text in PAGES.items()
        if not name.startswith(OWN)
        and any(map(ASKS.search, re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)))
    }
    linked = {name for name, text in PAGES.items() if "```{explore}" in text}
    assert {"tutorial.md", "gallery.md", "theory/popov.md"} <= examples <= linked

"""The links of the documentation into the page: each leads to the verdict that its page tells, and its line."""

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


OTHERS = {"num=1&den=1,3,2,0&class=time-varying&k=2.95": "INCONCLUSIVE", "num=1&den=1,3,2,0&k=6": "REFUTED"}


@pytest.mark.slow_for("num=1&den=1,3,2,0&class=time-varying&k=2.95")
@pytest.mark.parametrize("link", LINKS)
def test_a_link_shows_what_its_page_tells(link):
    whole = link if "&k=" in link else f"{link}&k=0.5"  # without k: a class within the largest one
    assert ask("class", whole)["verdict"] == OTHERS.get(link, "PROVED")
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

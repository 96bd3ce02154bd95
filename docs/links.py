"""Links of a built site: every file and every anchor that a page names is there, and no page needs another site.

``python docs/links.py build/docs`` prints what is broken and ends with 1 if anything is; ``--external`` lists the
addresses of other sites, with the first page that names each.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_ADDRESSES = {"a": "href", "link": "href", "img": "src", "script": "src", "iframe": "src", "source": "src"}


@dataclass
class Links(HTMLParser):
    """What one page names (``targets``), those a browser fetches with it, and what may be named in it (``anchors``)."""

    targets: list[str] = field(default_factory=list)
    fetched: set[str] = field(default_factory=set)
    anchors: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the address and the anchors of an element."""
        values = dict(attrs)
        address = values.get(_ADDRESSES.get(tag, ""))
        if address:
            self.targets.append(address)
            if tag not in {"a", "link"} or values.get("rel") == "stylesheet":
                self.fetched.add(address)
        self.anchors.update(name for name in (values.get("id"), values.get("name")) if name)


def read(site: Path) -> dict[Path, Links]:
    """The links of every page of a site."""
    pages = {}
    for path in sorted(site.rglob("*.html")):
        if "_static" in path.parts:  # templates of the theme
            continue
        pages[path] = Links()
        pages[path].feed(path.read_text(encoding="utf-8"))
    return pages


def problem(page: Path, target: str, pages: dict[Path, Links], site: Path) -> str | None:
    """What is wrong with a link inside the site, or None."""
    parts = urlsplit(target)
    path = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if parts.path.startswith("/") or not path.is_relative_to(site):
        return "leads out of the site"
    if not path.is_file():
        return "no such file"
    anchor = unquote(parts.fragment)
    if anchor and "=" not in anchor and path in pages and anchor not in pages[path].anchors:
        return "no such anchor"
    return None


def check(site: Path) -> tuple[list[str], dict[str, str]]:
    """Broken links, one line each, and the addresses of other sites with a page that names them.

    Parameters
    ----------
    site : Path
        The folder that Sphinx wrote.

    Returns
    -------
    list of str, dict of str to str
        Both sorted.
    """
    site = site.resolve()
    pages = read(site)
    broken, outside = set(), {}
    for page, links in pages.items():
        name = page.relative_to(site).as_posix()
        for target in links.targets:
            if urlsplit(target).scheme in {"http", "https", "mailto"} or target.startswith("//"):
                outside.setdefault(target, name)
                if target in links.fetched:
                    broken.add(f"{name}: {target}: fetched from another site")
            elif not target.startswith("data:") and (wrong := problem(page, target, pages, site)):
                broken.add(f"{name}: {target}: {wrong}")
    return sorted(broken), dict(sorted(outside.items()))


def main(arguments: list[str]) -> int:
    """Print what is broken, or what leads outside; status 1 if anything is broken."""
    site = Path(next(word for word in arguments if not word.startswith("-")))
    broken, outside = check(site)
    if "--external" in arguments:
        print(*(f"{target}  ({page})" for target, page in outside.items()), sep="\n")
    print(*broken, sep="\n", end="\n" if broken else "")
    count = len(read(site))
    print(f"{count} pages, {len(broken)} broken links, {len(outside)} addresses of other sites, which were not fetched")
    return 1 if broken or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Pages that live elsewhere in the repository: the notebooks, the notes, the changelog and the guide for contributors.

Each is copied to its place in `docs/` (which git ignores) before Sphinx reads.  A notebook is taken as ``make
notebooks`` has run it, from ``build/notebooks``; one that was not run since its source changed is shown without its
outputs, and says so.  Links between these files follow them to their pages; a link to any other file of the repository
becomes text, since the site stands for itself.  The same holds for the pages written in `docs/`.
"""

from __future__ import annotations

import base64
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

import jupytext
import nbformat

if TYPE_CHECKING:
    from nbformat import NotebookNode
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]
EXECUTED = ROOT / "build" / "notebooks"
FOLDERS = ("notebooks", "notes", "project")
_LINK = re.compile(r"(?<!!)\[(?P<text>[^\]\[]*)\]\((?![a-z]+:)(?P<path>[^)#\s]+)(?P<anchor>#[^)\s]*)?\)")
_NOT_RUN = "```{note}\nShown without its outputs: `make notebooks` runs it.\n```"
_EMPTY = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNkYAAAAAYAAjCB0C8AAAAASUVORK5CYII="  # 1 by 1, clear
_SLIDERS = "application/vnd.jupyter.widget-view+json"
_STATES = "application/vnd.jupyter.widget-state+json"
_HINT = {"output_type": "stream", "name": "stdout", "text": "(Sliders, with a live kernel. Where they stand:)\n"}


def pages(root: Path = ROOT) -> dict[str, str]:
    """For each collected file, by its path in the repository, the path of its page in `docs/`."""
    found = {f"notebooks/{path.name}": f"notebooks/{path.stem}.ipynb" for path in root.glob("notebooks/[0-9]*.py")}
    found |= {f"notebooks/notes/{path.name}": f"notes/{path.name}" for path in root.glob("notebooks/notes/*.md")}
    project = {"CHANGELOG.md": "project/changelog.md", "CONTRIBUTING.md": "project/contributing.md"}
    return found | {name: page for name, page in project.items() if (root / name).exists()}


def relinked(text: str, source: str, known: dict[str, str]) -> str:
    """The Markdown of a file of the repository, its links made right for its page; those that lead nowhere are text."""
    here = os.path.dirname(known.get(source, source.removeprefix("docs/"))) or "."

    def link(match: re.Match[str]) -> str:
        target = os.path.normpath(os.path.join(os.path.dirname(source), match["path"])).replace(os.sep, "/")
        page = known.get(target) or (target.removeprefix("docs/") if target.startswith("docs/") else None)
        if page is not None:
            return f"[{match['text']}]({os.path.relpath(page, here).replace(os.sep, '/')}{match['anchor'] or ''})"
        words = match["text"]
        named = target in words or words.strip("`") == Path(target).name
        return words if named else f"{words} (`{target}`)"

    return _LINK.sub(link, text)


def notebook(source: str, known: dict[str, str], *, root: Path = ROOT, executed: Path = EXECUTED) -> NotebookNode:
    """The notebook of a source, with its outputs if it was run since the source changed."""
    path, run = root / source, executed / f"{Path(source).stem}.ipynb"
    fresh = run.exists() and run.stat().st_mtime >= path.stat().st_mtime
    document = nbformat.read(run, as_version=4) if fresh else jupytext.read(path)
    frozen(document)
    for cell in document.cells:
        if cell.cell_type == "markdown":
            cell.source = relinked(cell.source, source, known) + explored(cell)
    if not fresh:
        document.cells.insert(1, nbformat.v4.new_markdown_cell(_NOT_RUN))
    name = f"{Path(source).stem}.ipynb"
    document.cells.insert(1, nbformat.v4.new_markdown_cell(f"{{download}}`Download {name} <download/{name}>`"))
    return document


def explored(cell: NotebookNode) -> str:
    """A link to the page in the browser, under a cell whose metadata ``explore`` is the address of its loop."""
    return f"\n\n```{{explore}} {cell.metadata['explore']}\n```" if "explore" in cell.metadata else ""


def first_picture(document: NotebookNode) -> bytes:
    """The first figure of a notebook, to stand for it in the gallery; an empty one if it was not run."""
    outputs = (out for cell in document.cells for out in cell.get("outputs", ()))
    return base64.b64decode(
        next((out.data["image/png"] for out in outputs if "image/png" in out.get("data", ())), _EMPTY)
    )


def frozen(document: NotebookNode) -> None:
    """Put in the place of sliders what they show where they stand: a page has no kernel, and fetches no scripts."""
    states = document.metadata.pop("widgets", {}).get(_STATES, {}).get("state", {})
    shown = [out for model in states.values() for out in model["state"].get("outputs", ())]
    for cell in document.cells:
        outputs = cell.get("outputs", [])
        if any(_SLIDERS in out.get("data", {}) for out in outputs):
            kept = [out for out in outputs if _SLIDERS not in out.get("data", {})]
            cell.outputs = [nbformat.from_dict(out) for out in (_HINT, *shown, *kept)]


def collect(docs: Path, root: Path = ROOT) -> None:
    """Write every collected page; one that has not changed keeps its date, one without a source goes."""
    known = pages(root)
    for source, page in known.items():
        if source.endswith(".py"):
            document = notebook(source, known, root=root)
            text = nbformat.writes(document) + "\n"
            copy = docs / "notebooks" / "download" / Path(page).name  # as its author left it
            copy.parent.mkdir(parents=True, exist_ok=True)
            jupytext.write(jupytext.read(root / source), copy)
            picture = docs / "pictures" / "notebooks" / f"{Path(page).stem}.png"
            picture.parent.mkdir(parents=True, exist_ok=True)
            picture.write_bytes(first_picture(document))
        else:
            text = relinked((root / source).read_text(encoding="utf-8"), source, known)
        file = docs / page
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
    for folder in FOLDERS:
        for file in (docs / folder).glob("*.*"):
            if f"{folder}/{file.name}" not in known.values():
                file.unlink()


def relink(app: Sphinx, name: str, source: list[str]) -> None:
    """Make the links of a page written here right, which may lead to files of the repository as well."""
    if Path(app.env.doc2path(name)).suffix == ".md" and name.partition("/")[0] not in FOLDERS:
        source[0] = relinked(source[0], f"docs/{name}.md", pages())


def setup(app: Sphinx) -> dict[str, bool]:
    """Collect before Sphinx looks for its pages."""
    collect(Path(app.srcdir))
    app.connect("source-read", relink)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

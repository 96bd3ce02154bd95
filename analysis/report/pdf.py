"""The report as a PDF: the same page, with its details open and its figures as they are printed."""

from __future__ import annotations

import base64
import os
import re
import secrets
from contextlib import suppress
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from lure.errors import InputError

if TYPE_CHECKING:
    from lure.analysis.report.parts import Figure

MARK = b"% lure-report/1\n"
"""Last line of a PDF of ours, a comment: such a file may be replaced."""
_EXTRA = "pip install 'lure[pdf]', or print report.html from a browser"


def pdf_of(html: str) -> bytes:
    """A page of :mod:`lure.analysis.report` as PDF, A4.

    ``html``: the page, made for paper: its figures as images, nothing fetched from anywhere.

    Raises
    ------
    InputError
        weasyprint, or a library of the system that it needs, is not installed.
    """
    weasyprint = pdf_maker()
    nothing_fetched = weasyprint.urls.URLFetcher(allowed_protocols=("data",))
    document: bytes = weasyprint.HTML(string=html, url_fetcher=nothing_fetched).write_pdf()
    return document + MARK


def pdf_maker() -> Any:  # noqa: ANN401  (an optional module, without types)
    """The module ``weasyprint``.

    Raises
    ------
    InputError
        It is not installed, or a library of the system that it needs is not.
    """
    try:
        import weasyprint
    except (ImportError, OSError) as missing:  # OSError: the library is there, and pango is not
        name = getattr(missing, "name", None) or "pango"
        raise InputError(f"a PDF needs weasyprint ({name} is not installed): {_EXTRA}") from None
    return weasyprint


def embedded(figure: Figure) -> Markup:
    """A figure for a printed page, as an image."""
    return _image(figure.picture.svg, "figure", f"{figure.spec.title}. {figure.spec.caption}")


def printed_diagram(diagram: Markup) -> Markup:
    """A block diagram for a printed page, as an image in the colours of print.

    ``diagram``: from :func:`lure.analysis.report.diagram.block_diagram`.
    """
    css = resources.files("lure.analysis.report").joinpath("style.css").read_text("utf-8")
    paper = css[css.index("@media print") :]
    colours = dict(re.findall(r"(--[\w-]+): (#\w+);", paper[: paper.index("}")]))
    rules = "".join(re.findall(r"svg\.diagram (?:\.\w+(?:, svg\.diagram \.\w+)*|text) \{[^}]*\}", css))
    rules = re.sub(r"var\((--[\w-]+)\)", lambda name: colours[name.group(1)], rules.replace("svg.diagram ", ""))
    opened = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="440" height="218" viewBox="0 0 440 218"><style>{rules}</style>'
    )
    return _image(opened + str(diagram).partition(">")[2], "diagram", "Block diagram")


def _image(svg: str, kind: str, words: str) -> Markup:
    data = base64.b64encode(svg.encode()).decode()
    return Markup('<img class="{}" alt="{}" src="data:image/svg+xml;base64,{}">').format(kind, words, data)


def checked_pdf_target(path: Path) -> Path:
    """A file that a PDF may be written to; ``path``: the file, which need not exist.

    Raises
    ------
    InputError
        It exists and is no report of ours, or its directory does not exist.
    """
    label = repr(str(path))
    if not path.parent.is_dir():
        raise InputError(f"{label} cannot be written, since {str(path.parent)!r} is not a directory; make it first")
    if os.path.lexists(path) and not _ours(path):
        raise InputError(f"{label} exists and is not a report; give another name with -o")
    return path


def _ours(path: Path) -> bool:
    try:
        return path.is_file() and not path.is_symlink() and path.read_bytes().endswith(MARK)
    except OSError:
        return False


def write_pdf(document: bytes, path: Path) -> None:
    """Write a PDF in one step.

    ``document``: from :func:`pdf_of`; ``path``: from :func:`checked_pdf_target`.

    Raises
    ------
    InputError
        It cannot be written.
    """
    temporary = path.with_name(f".lure-{secrets.token_hex(4)}")
    try:
        temporary.write_bytes(document)
        temporary.replace(path)
    except OSError as error:
        with suppress(OSError):
            temporary.unlink()
        raise InputError(f"{str(path)!r} cannot be written ({error.strerror}); give another place with -o") from None

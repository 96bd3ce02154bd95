"""Paragraphs in lines of 80 columns."""

from __future__ import annotations

import textwrap

WIDTH = 80


def wrapped(text: str, *, indent: int) -> list[str]:
    """A paragraph in lines of 80 columns, the later ones indented; words longer than that stay whole.

    Parameters
    ----------
    text : str
        The paragraph; blanks before it indent the first line.
    indent : int
        Blanks before the second and later lines.
    """
    printable = "".join(sign if sign.isprintable() else ascii(sign)[1:-1] for sign in text)
    return textwrap.wrap(
        printable.strip(),
        WIDTH,
        initial_indent=" " * (len(printable) - len(printable.lstrip())),
        subsequent_indent=" " * indent,
        break_long_words=False,
        break_on_hyphens=False,
    )

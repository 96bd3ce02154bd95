"""Plain text as reStructuredText."""


def escaped(text: str) -> str:
    """The text with nothing in it that reStructuredText would read as markup.

    Parameters
    ----------
    text : str
        Any text.
    """
    return "".join(f"\\{sign}" if sign in "\\*`|_" else sign for sign in text)

"""Plain text as reStructuredText."""


def escaped(text: str) -> str:
    """The text with nothing in it that reStructuredText would read as markup, but for `code`.

    Parameters
    ----------
    text : str
        Any text.
    """
    parts = text.split("`")
    code = len(parts) % 2 == 1  # what stands between two backquotes
    signs = ["".join(f"\\{sign}" if sign in "\\*|_" else sign for sign in part) for part in parts]
    if not code:
        return "\\`".join(signs)
    return "".join(f"``{parts[i]}``" if i % 2 else signs[i] for i in range(len(parts)))

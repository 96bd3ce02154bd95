"""What the reference pages are made of: entries from docstrings, and tables from the code they describe."""

from sphinx.application import Sphinx

from lure_docs import codes, commands, entries, keys, references, schema


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives and the cross-references."""
    for part in (codes, commands, entries, keys, references, schema):
        part.setup(app)
    app.add_css_file("reference.css")
    return {"parallel_read_safe": True, "parallel_write_safe": True}

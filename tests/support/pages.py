"""Pages of notebooks as a reader sees them: they must parse, close everything and run nothing."""

import json
from html.parser import HTMLParser

VOID = {"br", "hr", "img", "path", "use", "rect", "stop", "circle", "metadata"}


class Reader(HTMLParser):
    """The text and tags of a page; fails on a tag that does not close."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.words = [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert tag in VOID or self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def read(page):
    """Tags and text of a page."""
    reader = Reader()
    reader.feed(page)
    reader.close()
    assert reader.open == []
    assert "script" not in reader.tags
    assert not {"#000", "#fff", "color:", "background"} & set(page.split("<svg")[0].split())
    return reader.tags, "".join(reader.words)


def page_with_its_data(found):
    """The text of a result's page, which says what it does not show; plain data has the same sentence."""
    _, text = read(found._repr_html_())
    assert "Not shown" in text or "proves nothing" in text
    assert json.loads(json.dumps(found.to_dict(), allow_nan=False))["sentence"] == str(found)
    return text

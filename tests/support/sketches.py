"""Figures with sketches in place of their files: drawn as ever, and not written, which takes most of the time."""

from contextlib import contextmanager
from pathlib import Path

import pytest

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><g id="sketch"/></svg>'


def _written(_figure, file, **_settings):
    Path(file).write_text(SVG, encoding="utf-8")


@contextmanager
def sketches():
    """Figures that are written here, by lure or by ``savefig``, are sketches."""
    with pytest.MonkeyPatch.context() as patch:
        backends = "matplotlib.backends.backend_"
        patch.setattr(f"{backends}svg.FigureCanvasSVG.print_svg", lambda _canvas, file, **_: file.write(SVG))
        patch.setattr(f"{backends}agg.FigureCanvasAgg.print_png", lambda _canvas, _file, **_: None)
        patch.setattr("matplotlib.figure.Figure.savefig", _written)
        yield

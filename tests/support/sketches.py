"""Reports with sketches in place of their figures: drawn as ever, and not written, which takes most of the time."""

from contextlib import contextmanager

import pytest


def sketch(draw, *, name, size=(4.4, 3.2)):
    """What :func:`lure.analysis.plots.render` returns, a few bytes long."""
    from matplotlib.figure import Figure

    from lure.analysis.plots.style import Picture

    draw(ax=Figure(figsize=size).add_subplot())
    return Picture(svg=f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><g id="{name}"/></svg>', png=b"")


@contextmanager
def sketches():
    """Reports that are written here have sketches."""
    with pytest.MonkeyPatch.context() as patch:
        for report in ("lure.analysis.report.loop", "lure.analysis.rod.report"):
            patch.setattr(f"{report}.figures.render", sketch)
        yield

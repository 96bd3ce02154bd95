"""The paper, reproduced: its figures, its claims, and what becomes of them."""

from __future__ import annotations

from pathlib import Path

from lure.analysis.rod.paper.claims import figure_claims, theory_claims
from lure.analysis.rod.paper.figures import PaperFigure as PaperFigure
from lure.analysis.rod.paper.figures import paper_figures as paper_figures
from lure.analysis.rod.paper.model import PaperClaim as PaperClaim
from lure.analysis.rod.paper.model import PaperTable as PaperTable
from lure.analysis.rod.paper.model import Peak as Peak
from lure.analysis.rod.paper.runs import PaperRuns as PaperRuns
from lure.analysis.rod.paper.runs import Progress as Progress
from lure.analysis.rod.paper.runs import paper_runs as paper_runs


def paper_table(runs: PaperRuns) -> PaperTable:
    """The claims, peaks and settling times that follow from the motions.

    Parameters
    ----------
    runs : PaperRuns
        From :func:`paper_runs`.
    """
    return PaperTable(
        claims=(*theory_claims(runs), *figure_claims(runs)),
        peaks=tuple(run.peak for run in runs.forced),
        settling=runs.settling,
    )


def reproduce_paper(directory: Path | None = None, *, progress: Progress | None = None) -> PaperTable:
    """Recompute the paper's figures 3 to 10 and put its claims to the test.

    Parameters
    ----------
    directory : Path, optional
        Where to write ``paper.html``, ``paper.json`` and ``figures/`` (SVG and PNG); nothing is written without it.
    progress : callable, optional
        Called as ``progress(stage, done)``, with the share ``0 <= done <= 1`` of the work behind it.

    Returns
    -------
    PaperTable
        ``print`` shows it as a table, ``to_dict()`` gives plain JSON.

    Notes
    -----
    The simulations are OBSERVED evidence, the motions of the rod itself COMPUTED; what is CERTIFIED says so.
    """
    runs = paper_runs(progress=progress)
    table = paper_table(runs)
    if directory is not None:
        from lure.analysis.rod.paper.figures import write_paper

        write_paper(table, runs, directory)
    return table

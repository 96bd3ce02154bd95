"""The motions behind the figures: the release of figures 3 to 7, the forced motions of figures 8 to 10."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.paper.modal import HarmonicForce, ModalBasis, modal_run
from lure.analysis.rod.paper.model import Peak, Variant
from lure.analysis.rod.paper.settling import Settling, rod_settling, scheme_settling
from lure.analysis.rod.paper.shift import rod_run
from lure.analysis.rod.simulation import Trajectory, simulate
from lure.analysis.verdict import Evidence
from lure.rod.discretisation import Form, upwind
from lure.rod.free_motion import FreeMotion, free_motion
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.systems import RodSystem, builtin_system

Progress = Callable[[str, float], None]
"""What is told of progress: a few words, and the part done from 0 to 1."""
COARSE, FINE = 10, 200
RELEASE = 2.5e-3
FORCED = (8, 9, 10)
AMPLITUDES = {8: 2.0, 9: 5.0, 10: 2.0}
OMEGA = 4.0
_SAMPLES = 5000


@dataclass(frozen=True, kw_only=True, slots=True)
class _Case:
    """A variant of figures 8 to 10: a form and a number of cells, or the rod itself; the force divided or not."""

    variant: Variant
    form: Form | None = None
    cells: int | None = None
    rescaled: bool = False


_CASES = (
    _Case(variant="as-printed", form="as-printed", cells=COARSE),
    _Case(variant="as-printed-200", form="as-printed", cells=FINE),
    _Case(variant="corrected", form="corrected", cells=COARSE),
    _Case(variant="corrected-200", form="corrected", cells=FINE),
    _Case(variant="corrected-rescaled", form="corrected", cells=COARSE, rescaled=True),
    _Case(variant="corrected-rescaled-200", form="corrected", cells=FINE, rescaled=True),
    _Case(variant="rod"),
    _Case(variant="rod-rescaled", rescaled=True),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class ForcedRun:
    """One motion of figures 8 to 10.

    Attributes
    ----------
    peak : Peak
        Which motion, and how far it gets.
    t, u : ndarray
        (n,) times [s] and displacement ``u(t, L)`` [m].
    contacts : tuple of (float, float)
        Contact intervals [s].
    """

    peak: Peak
    t: NDArray[np.float64]
    u: NDArray[np.float64]
    contacts: tuple[tuple[float, float], ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperRuns:
    """Everything computed for the paper's figures.

    Attributes
    ----------
    release : RodSystem
        Figures 3 to 7.
    coarse, fine : Trajectory
        Its scheme with ``N = 10`` and ``N = 200``, up to 2.5e-3 s, with frames.
    exact : FreeMotion
        Its exact motion, up to 5 s.
    settling : tuple of Settling
        ``N = 10``, ``N = 200``, the rod.
    forced : tuple of ForcedRun
        Figures 8 to 10 in every variant.
    """

    release: RodSystem
    coarse: Trajectory
    fine: Trajectory
    exact: FreeMotion
    settling: tuple[Settling, ...]
    forced: tuple[ForcedRun, ...]

    def run(self, figure: int, variant: Variant) -> ForcedRun:
        """The motion of a figure in a variant."""
        return {(run.peak.figure, run.peak.variant): run for run in self.forced}[figure, variant]


def paper_runs(*, progress: Progress | None = None) -> PaperRuns:
    """Compute the motions behind figures 3 to 10.

    Parameters
    ----------
    progress : callable, optional
        Called as ``progress(stage, done)``, with the share ``0 <= done <= 1`` of the work behind it.

    Notes
    -----
    The paper does not say how long figures 8 to 10 are; 5 s are three periods of ``sin 4t``.
    """
    say = progress or (lambda _stage, _done: None)
    say("figures 3 to 7", 0.0)
    release = builtin_system("paper-rod")
    rod, scenario = release.rod, release.scenario
    coarse, fine = (
        simulate(upwind(rod, cells), scenario, until=RELEASE, samples=1001, frames=121) for cells in (COARSE, FINE)
    )
    settling = (
        scheme_settling(rod, scenario, COARSE),
        scheme_settling(rod, scenario, FINE),
        rod_settling(rod, scenario),
    )
    exact = free_motion(rod, scenario, 5.0)
    forced: list[ForcedRun] = []
    bases: dict[tuple[Rod, int], ModalBasis] = {}
    for i, figure in enumerate(FORCED):
        say(f"figure {figure}", 0.1 + 0.3 * i)
        system = builtin_system(f"paper-rod-figure-{figure}")
        for cells in (COARSE, FINE):  # figures 9 and 10 share a rod, and finding its eigenvectors is most of the work
            bases.setdefault((system.rod, cells), ModalBasis(system.rod, cells))
        forced += [_forced_run(figure, system, case, bases) for case in _CASES]
    say("done", 1.0)
    return PaperRuns(release=release, coarse=coarse, fine=fine, exact=exact, settling=settling, forced=tuple(forced))


def _forced_run(figure: int, system: RodSystem, case: _Case, bases: dict[tuple[Rod, int], ModalBasis]) -> ForcedRun:
    amplitude = AMPLITUDES[figure] / (upwind(system.rod, COARSE).rate if case.rescaled else 1.0)
    displacement = system.scenario.displacement.source
    if case.cells is None or case.form is None:
        scenario = Scenario.parse(force=f"{amplitude!r}*sin({OMEGA!r}*t)", displacement=displacement)
        rod = rod_run(system.rod, scenario, system.until)
        kept = slice(None, None, max(1, len(rod.t) // _SAMPLES))
        t, z, contacts = rod.t[kept], rod.z[kept], rod.contacts
        at, largest = float(rod.t[np.argmax(rod.z)]), rod.largest_z
    else:
        release = Scenario.parse(displacement=displacement)
        force = HarmonicForce(amplitude=amplitude, omega=OMEGA)
        found = modal_run(bases[system.rod, case.cells], release, force, form=case.form, until=system.until)
        t, z, contacts = found.t, found.z, found.contacts
        at, largest = found.peak
    peak = Peak(
        figure=figure,
        variant=case.variant,
        cells=case.cells,
        form=case.form,
        amplitude=amplitude,
        largest_z=largest,
        at=at,
        contacts=len(contacts),
        evidence=Evidence.COMPUTED if case.cells is None else Evidence.OBSERVED,
    )
    return ForcedRun(peak=peak, t=t, u=z + system.rod.gap, contacts=contacts)

"""Samples of motions of the upwind scheme, event-exact: step by step, or by its structure for very many cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.runs.sampled import LOADED_CELLS, Along, SampledRun, check_samples
from lure.analysis.verdict import Evidence
from lure.errors import InputError
from lure.rod.motion import Impact
from lure.rod.scenario import Scenario
from lure.rod.scheme.motion import METHOD, scheme_words
from lure.rod.upwind import UpwindScheme

if TYPE_CHECKING:
    from lure.analysis.rod.simulation import Trajectory

Array = NDArray[np.float64]


def sampled_scheme(
    scheme: UpwindScheme, scenario: Scenario, until: float, *, samples: int = 2001, places: int = 0
) -> SampledRun:
    """Event-exact motion of the scheme.

    By :func:`lure.analysis.rod.simulation.simulate`, or by :func:`lure.rod.scheme.structured_motion` where that
    would take
    minutes: above 1000 cells, and for long runs of many cells.  The
    latter tells the end ``x = L`` only, and no energy.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    samples : int
        Number of instants.
    places : int
        0, or ``N + 1`` to keep the fields at the nodes of the scheme.

    Returns
    -------
    SampledRun
        OBSERVED evidence about the scheme, not about the rod.

    Raises
    ------
    InputError
        A request is out of range, or one of the two solvers refuses it.
    """
    check_samples(samples)
    nodes = scheme.cells + 1
    if places not in (0, nodes):
        raise InputError(
            f"fields is {places}; the scheme of {scheme.cells} cells has {nodes} nodes and nothing between them, give "
            f"{nodes}"
        )
    from lure.analysis.rod.simulation.simulate import LARGEST_WORK

    if scheme.cells > LOADED_CELLS and places:
        raise InputError(f"fields is {places}; above {LOADED_CELLS} cells only the end of the rod is kept, give none")
    short = scheme.cells <= LOADED_CELLS and 2.0 * scheme.cells * scheme.rate * until <= LARGEST_WORK
    if short or places:
        return _simulated(scheme, scenario, until, samples=samples, keep=places > 0)
    return _structured(scheme, scenario, until, samples=samples)


def _simulated(scheme: UpwindScheme, scenario: Scenario, until: float, *, samples: int, keep: bool) -> SampledRun:
    from lure.analysis.rod.simulation import simulate

    rod = scheme.rod
    run = simulate(scheme, scenario, until=until, samples=samples, frames=samples)
    if run.ended_early is not None:
        raise InputError(f"the motion of the scheme cannot be followed to {until:g} s: {run.ended_early}")
    v_0 = run.frames_v[:, 0].copy()
    impacts = [
        Impact(
            start=contact.start,
            end=contact.end,
            impulse=contact.impulse,
            peak_stress=float(rod.law(contact.peak_penetration)),
            closed=not (contact.open and contact.end >= until),
        )
        for contact in run.contacts
    ]
    return SampledRun(
        subject="scheme",
        about=scheme_words(scheme),
        evidence=Evidence.OBSERVED,
        method=run.method,
        rod=rod,
        scenario=scenario,
        t=run.t,
        z=run.z,
        u_end=run.u_end,
        stress=run.p,
        v_end=run.frames_v[:, -1].copy(),
        v_0=v_0,
        dashpot_force=rod.damping * v_0,
        energy=run.energy,
        impacts=tuple(impacts),
        energy_residual=run.energy_residual,
        error=run.error_estimate,
        error_is="largest difference of z from a second run with other, shorter steps; nothing of the scheme's "
        "distance from the rod",
        details={"cells": scheme.cells, "form": scheme.form, "event_resolution": run.event_resolution},
        along=_along(run, rod.wave_speed) if keep else None,
    )


def _along(run: Trajectory, wave_speed: float) -> Along:
    """The nodal fields.

    The strain of the cell between nodes ``i - 1`` and ``i`` is ``(r2^{i-1} - r1^i)/(2c)``, from the two waves that the
    scheme moves inside it; with the displacement summed up from these, ``u_i' = v_i`` holds exactly.
    """
    forward, backward = run.frames_r1, run.frames_r2
    stretched = np.diff(run.frames_x) * (backward[:, :-1] - forward[:, 1:]) / (2.0 * wave_speed)
    to_end = np.zeros(forward.shape)
    to_end[:, :-1] = np.cumsum(stretched[:, ::-1], axis=1)[:, ::-1]
    return Along(
        x=run.frames_x,
        v=run.frames_v,
        w=(backward - forward) / (2.0 * wave_speed),
        u=run.u_end[:, None] - to_end,
    )


def _structured(scheme: UpwindScheme, scenario: Scenario, until: float, *, samples: int) -> SampledRun:
    from lure.rod.scheme import structured_motion

    rod = scheme.rod
    run = structured_motion(scheme, scenario, until, samples=samples)
    stress = rod.law(run.z)
    return SampledRun(
        subject="scheme",
        about=scheme_words(scheme),
        evidence=Evidence.OBSERVED,
        method=METHOD,
        rod=rod,
        scenario=scenario,
        t=run.t,
        z=run.z,
        u_end=run.z + rod.gap,
        stress=stress,
        v_end=run.wave - rod.mobility * stress,
        impacts=tuple(
            Impact(start=start, end=end, impulse=math.nan, peak_stress=math.nan, closed=end < until)
            for start, end in run.contacts
        ),
        details={"cells": scheme.cells, "form": scheme.form},
    )

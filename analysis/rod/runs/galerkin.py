"""Samples of motions in a Galerkin space."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.runs.sampled import Along, SampledRun, check_places, check_samples
from lure.analysis.verdict import Evidence
from lure.rod.galerkin import GalerkinRun
from lure.rod.galerkin.spaces import SpaceName
from lure.rod.motion import Impact
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

Array = NDArray[np.float64]


def sampled_galerkin(  # noqa: PLR0913  (what, from where, in which space, and how much of it is kept)
    rod: Rod,
    scenario: Scenario,
    until: float,
    *,
    space: SpaceName,
    order: int,
    samples: int = 2001,
    places: int = 0,
) -> SampledRun:
    """Motion of ``u_m`` in a Galerkin space, :meth:`lure.rod.galerkin.GalerkinModel.simulate`.

    Parameters
    ----------
    rod : Rod
        The rod.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    space : {"P1", "P2", "cosine"}
        The elements.
    order : int
        ``m``, the dimension of the space.
    samples : int
        Number of instants.
    places : int
        Number of places along the rod at which the fields are kept; 0 for none.

    Returns
    -------
    SampledRun
        OBSERVED evidence about the Galerkin space, not about the rod.

    Raises
    ------
    InputError
        A request is out of range.
    AssumptionError
        The contact law is not Lipschitz.
    """
    from lure.rod.galerkin import galerkin

    check_samples(samples)
    if places:
        check_places(places, samples)
    model = galerkin(rod, space=space, order=order)
    run = model.simulate(scenario, until, samples=samples)
    v_0 = np.asarray(run.velocities @ model.space.left)
    return SampledRun(
        subject="Galerkin space",
        about=f"the Galerkin space {space} of dimension {order}, not the rod",
        evidence=Evidence.OBSERVED,
        method=f"weak form in {'cosine modes' if space == 'cosine' else f'{space} elements'}, integrated by scipy's "
        f"{run.method} between contacts and releases, which are located as events",
        rod=rod,
        scenario=scenario,
        t=run.t,
        z=run.z,
        u_end=run.u_end,
        stress=run.contact_stress,
        v_end=np.asarray(run.velocities @ model.space.right),
        v_0=v_0,
        dashpot_force=rod.damping * v_0,
        energy=run.energy,
        impacts=_impacts(run),
        energy_residual=run.energy_residual,
        details={"space": space, "order": order, "steps": run.steps},
        along=_along(run, places) if places else None,
    )


def _impacts(run: GalerkinRun) -> tuple[Impact, ...]:
    """The contacts; an impulse is known where a sample lies in flight on both sides of its contact."""
    found = []
    until = float(run.t[-1])
    ends = [touch.end for touch in run.contacts]
    for i, touch in enumerate(run.contacts):
        first = int(np.searchsorted(run.t, touch.start, side="right")) - 1
        last = min(int(np.searchsorted(run.t, min(touch.end, until))), len(run.t) - 1)
        alone = (i == 0 or run.t[first] >= ends[i - 1]) and (
            i + 1 == len(ends) or run.t[last] <= run.contacts[i + 1].start
        )
        impulse = float(run.impulse[last] - run.impulse[first]) if alone else math.nan
        closed = touch.end < until
        found.append(
            Impact(start=touch.start, end=min(touch.end, until), impulse=impulse, peak_stress=math.nan, closed=closed)
        )
    return tuple(found)


def _along(run: GalerkinRun, places: int) -> Along:
    space = run.model.space
    x = np.linspace(0.0, space.length, places)
    values, slopes = space.values(x), space.slopes(x)
    return Along(
        x=x,
        v=np.asarray((values @ run.velocities.T).T),
        w=np.asarray((slopes @ run.coefficients.T).T),
        u=np.asarray((values @ run.coefficients.T).T),
    )

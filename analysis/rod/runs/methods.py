"""Samples of the motion of the rod itself, of its scheme and of a Galerkin space."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

import numpy as np

from lure.analysis.rod.comparison.integrators import SchemeMethod, SchemeRun, by_structure, integrate
from lure.analysis.rod.runs.sampled import Along, SampledRun, check_places, check_samples
from lure.analysis.rod.simulation.simulate import LARGEST_CELLS, in_steps, simulate
from lure.analysis.rod.simulation.trajectory import Trajectory
from lure.analysis.verdict import Evidence
from lure.arrays import Reals as Array
from lure.errors import InputError
from lure.rod.discretisation import UpwindScheme
from lure.rod.galerkin import GalerkinRun, galerkin
from lure.rod.galerkin.spaces import SpaceName
from lure.rod.motion import Contact, Motion
from lure.rod.motion.sampling import evenly
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario
from lure.rod.scheme.motion import METHOD as BY_STRUCTURE
from lure.rod.scheme.motion import scheme_words

RTOL = 1e-8


def sampled_motion(
    motion: Motion,
    samples: int = 2001,
    *,
    places: int = 0,
    energy: bool = True,
    span: tuple[float, float] | None = None,
) -> SampledRun:
    """Samples of an exact motion, evenly spaced over a stretch of it.

    Parameters
    ----------
    motion : Motion
        From :func:`lure.rod.motion.exact_motion`.
    samples : int
        Number of instants.
    places : int
        Number of places along the rod at which the fields are kept; 0 for none.
    energy : bool
        Whether to compute the energy at every sample, which costs more than all else; never above 20001 samples.
    span : (float, float), optional
        First and last instant [s]; all that was kept by default.  Of a motion that forgot its beginning
        (``Numerics.keep``) that is a round trip less, for the whole rod to be known.

    Returns
    -------
    SampledRun
        COMPUTED evidence about the rod.  At a jump a sample is the value after it.  The impacts are those of the whole
        motion.

    Raises
    ------
    InputError
        ``samples``, ``places`` or ``span`` is out of range.
    """
    found = evenly(motion, samples, places=places, energy=energy, span=span)
    return SampledRun(evidence=Evidence.COMPUTED, **found)


def sampled_scheme(  # noqa: PLR0913  (what, from where, until when, by what, and how much of it is kept)
    scheme: UpwindScheme,
    scenario: Scenario,
    until: float,
    *,
    method: str = "scheme",
    samples: int = 2001,
    places: int = 0,
) -> SampledRun:
    """Motion of the scheme, from event to event or by an integrator.

    From event to event it is :func:`lure.analysis.rod.simulation.simulate`, or
    :func:`lure.rod.scheme.structured_motion` where that would take minutes: above 1000 cells, and for long runs of many
    cells.  The latter tells the end ``x = L`` only, and no energy.

    ``until``: end of the run [s]; ``method``: ``"scheme"``, event to event, or the integrator of
    :func:`lure.analysis.rod.comparison.integrate`; ``samples``: number of instants; ``places``: 0, or ``N + 1`` to keep
    the fields at the nodes of the scheme, of which an integrator keeps none.

    Returns
    -------
    SampledRun
        OBSERVED evidence about the scheme, not about the rod; the error of an integrator is not estimated.

    Raises
    ------
    InputError
        A request is out of range, scikit-sundae is missing, or the solver refuses it or gives up.
    """
    check_samples(samples)
    if method != "scheme":
        if places:
            raise InputError(f"fields is {places}; method {method} keeps the end of the rod only, give none")
        run = integrate(scheme, scenario, until, method=cast("SchemeMethod", method), rtol=RTOL, samples=samples)
        library = "SUNDIALS" if method == "CVODE" else "scipy"
        said = f"{method} of {library}, each step to {RTOL:g}, stopped at contact and release"
        details: dict[str, str | float] = {"integrator": method, "rtol": RTOL}
        return _of_run(run, scenario, said, details | ({"evaluations": run.evaluations} if run.evaluations else {}))
    nodes = scheme.cells + 1
    if places not in (0, nodes):
        raise InputError(
            f"fields is {places}; the scheme of {scheme.cells} cells has {nodes} nodes and nothing between them, give "
            f"{nodes}"
        )
    if scheme.cells > LARGEST_CELLS and places:
        raise InputError(f"fields is {places}; above {LARGEST_CELLS} cells only the end of the rod is kept, give none")
    if in_steps(scheme, until) or places:
        return _simulated(scheme, scenario, until, samples=samples, keep=places > 0)
    return _of_run(by_structure(scheme, scenario, until, samples), scenario, BY_STRUCTURE, {})


def _of_run(run: SchemeRun, scenario: Scenario, method: str, details: dict[str, str | float]) -> SampledRun:
    plain = _of_end(run.scheme, scenario, run.t, run.z, run.contacts)
    kept = {**plain.details, **details}
    return replace(plain, method=method, v_end=run.velocity, energy=run.energy, details=kept)


def _of_end(
    scheme: UpwindScheme, scenario: Scenario, t: Array, z: Array, contacts: tuple[tuple[float, float], ...]
) -> SampledRun:
    """What is known of every motion of the scheme: its end, and when that touched."""
    return SampledRun(
        subject="scheme",
        about=scheme_words(scheme),
        evidence=Evidence.OBSERVED,
        method="",
        rod=scheme.rod,
        scenario=scenario,
        t=t,
        z=z,
        u_end=z + scheme.rod.gap,
        stress=scheme.rod.nonlinearity(z),
        impacts=tuple(Contact(start=start, end=end, closed=end < float(t[-1])) for start, end in contacts),
        details={"cells": scheme.cells, "form": scheme.form},
    )


def _simulated(scheme: UpwindScheme, scenario: Scenario, until: float, *, samples: int, keep: bool) -> SampledRun:
    rod = scheme.rod
    run = simulate(scheme, scenario, until=until, samples=samples, frames=samples)
    if run.ended_early is not None:
        raise InputError(f"the motion of the scheme cannot be followed to {until:g} s: {run.ended_early}")
    v_0 = run.frames_v[:, 0].copy()
    plain = _of_end(scheme, scenario, run.t, run.z, ())
    return replace(
        plain,
        method=run.method,
        v_end=run.frames_v[:, -1].copy(),
        v_0=v_0,
        dashpot_force=rod.damping * v_0,
        energy=run.energy,
        impacts=run.contacts,
        energy_residual=run.energy_residual,
        error=run.error_estimate,
        error_is="largest difference of z from a second run with other, shorter steps; nothing of the scheme's "
        "distance from the rod",
        details={**plain.details, "event_resolution": run.event_resolution},
        along=_at_nodes(run, rod.wave_speed) if keep else None,
    )


def _at_nodes(run: Trajectory, wave_speed: float) -> Along:
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

    ``until``: end of the run [s]; ``order``: ``m``, the dimension of the space; ``samples``: number of instants;
    ``places``: number of places along the rod at which the fields are kept, 0 for none.

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
    check_samples(samples)
    if places:
        check_places(places, samples)
    model = galerkin(rod, space=space, order=order)
    run = model.simulate(scenario, until, samples=samples)
    v_0 = np.asarray(run.velocities @ model.space.left)
    return SampledRun(
        subject="Galerkin space",
        about=run.about,
        evidence=Evidence.OBSERVED,
        method=run.how,
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
        along=_in_space(run, places) if places else None,
    )


def _impacts(run: GalerkinRun) -> tuple[Contact, ...]:
    """The contacts; an impulse is known where a sample lies in flight on both sides of its contact."""
    found = []
    ends = [touch.end for touch in run.contacts]
    for i, touch in enumerate(run.contacts):
        first = int(np.searchsorted(run.t, touch.start, side="right")) - 1
        last = min(int(np.searchsorted(run.t, touch.end)), len(run.t) - 1)
        alone = (i == 0 or run.t[first] >= ends[i - 1]) and (
            i + 1 == len(ends) or run.t[last] <= run.contacts[i + 1].start
        )
        impulse = float(run.impulse[last] - run.impulse[first]) if alone else math.nan
        found.append(replace(touch, impulse=impulse))
    return tuple(found)


def _in_space(run: GalerkinRun, places: int) -> Along:
    space = run.model.space
    x = np.linspace(0.0, space.length, places)
    values, slopes = space.values(x), space.slopes(x)
    return Along(
        x=x,
        v=np.asarray((values @ run.velocities.T).T),
        w=np.asarray((slopes @ run.coefficients.T).T),
        u=np.asarray((values @ run.coefficients.T).T),
    )

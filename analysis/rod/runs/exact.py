"""Samples of the motion of the rod itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.runs.sampled import Along, SampledRun, check_places, instants
from lure.analysis.verdict import Evidence
from lure.rod.motion import Motion
from lure.rod.motion.sampling import ABOUT, ERROR, METHOD, boundary_attributes, whole_rod_since
from lure.rod.motion.sampling import MOST_ENERGIES as MOST_ENERGIES

Array = NDArray[np.float64]


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
    t = instants(*(span or (whole_rod_since(motion), motion.until)), samples)
    run = motion_at(motion, t)
    return replace(
        run,
        energy=motion.energies(t) if energy and samples <= MOST_ENERGIES else None,
        along=along_motion(motion, t, places) if places else None,
    )


def motion_at(motion: Motion, t: Array) -> SampledRun:
    """An exact motion at any increasing instants, without energy and fields.

    Parameters
    ----------
    motion : Motion
        The motion.
    t : ndarray
        (samples,) instants [s].

    Raises
    ------
    InputError
        They leave what was kept of the motion.
    """
    v_0 = motion.dashpot_velocity(t)
    return SampledRun(
        subject="rod",
        about=ABOUT,
        evidence=Evidence.COMPUTED,
        method=METHOD,
        rod=motion.rod,
        scenario=motion.scenario,
        t=t,
        z=motion.z(t),
        u_end=motion.end_displacement(t),
        stress=motion.contact_stress(t),
        v_end=motion.end_velocity(t),
        v_0=v_0,
        dashpot_force=None if motion.boundary.clamped else motion.dashpot_force(t),
        impacts=motion.impacts,
        energy_residual=motion.energy_residual,
        error=motion.error,
        error_is=ERROR,
        details={
            **boundary_attributes(motion.boundary),
            "law_crossings": motion.crossings,
            "compiled": int(motion.compiled),
        },
        note=motion.note,
    )


def along_motion(motion: Motion, t: Array, places: int, *, displaced: bool = True) -> Along:
    """Velocity, strain and displacement of an exact motion on a grid of instants and places.

    Parameters
    ----------
    motion : Motion
        The motion.
    t : ndarray
        (samples,) instants [s].
    places : int
        Number of places, evenly spaced from 0 to ``L``.
    displaced : bool
        Whether to compute the displacement, which costs more than the other two; else it is nan.

    Raises
    ------
    InputError
        ``places`` is out of range.
    """
    check_places(places, len(t))
    x = np.linspace(0.0, motion.rod.length, places)
    forward, backward = motion.waves(t[:, None], x[None, :])
    shown = np.full(forward.shape, np.nan)
    if displaced:
        shown = np.array([motion.displacement(float(instant), x) for instant in t])
    return Along(
        x=x,
        v=0.5 * (forward + backward),
        w=(backward - forward) / (2.0 * motion.rod.wave_speed),
        u=shown,
    )

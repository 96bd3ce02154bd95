"""Samples of motions of the scheme by general integrators."""

from __future__ import annotations

import math
from typing import cast

from lure.analysis.rod.comparison.integrators import SchemeMethod, integrate
from lure.analysis.rod.runs.sampled import SampledRun, check_samples
from lure.analysis.verdict import Evidence
from lure.rod.motion import Impact
from lure.rod.scenario import Scenario
from lure.rod.scheme.motion import scheme_words
from lure.rod.upwind import UpwindScheme

RTOL = 1e-8


def sampled_integration(
    scheme: UpwindScheme, scenario: Scenario, until: float, *, method: str, samples: int = 2001
) -> SampledRun:
    """Motion of the scheme by an integrator, :func:`lure.analysis.rod.comparison.integrators.integrate`.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the run [s].
    method : {"LSODA", "RK45", "DOP853", "Radau", "BDF", "CVODE"}
        The integrator.
    samples : int
        Number of instants.

    Returns
    -------
    SampledRun
        OBSERVED evidence about the scheme, not about the rod; the error is not estimated.

    Raises
    ------
    InputError
        An argument is out of range, scikit-sundae is missing, or the integrator gives up.
    """
    check_samples(samples)
    run = integrate(scheme, scenario, until, method=cast("SchemeMethod", method), rtol=RTOL, samples=samples)
    library = "SUNDIALS" if method == "CVODE" else "scipy"
    return SampledRun(
        subject="scheme",
        about=scheme_words(scheme),
        evidence=Evidence.OBSERVED,
        method=f"{method} of {library}, each step to {RTOL:g}, stopped at contact and release",
        rod=scheme.rod,
        scenario=scenario,
        t=run.t,
        z=run.z,
        u_end=run.u_end,
        stress=scheme.rod.law(run.z),
        v_end=run.velocity,
        energy=run.energy,
        impacts=tuple(
            Impact(start=start, end=end, impulse=math.nan, peak_stress=math.nan, closed=end < until)
            for start, end in run.contacts
        ),
        details={
            "cells": scheme.cells,
            "form": scheme.form,
            "integrator": method,
            "rtol": RTOL,
            **({} if run.evaluations is None else {"evaluations": run.evaluations}),
        },
    )

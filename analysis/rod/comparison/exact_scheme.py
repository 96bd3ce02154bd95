"""The motion of the scheme without a time step: the two event-exact solvers in the form of the others."""

from __future__ import annotations

import time

from lure.analysis.rod.comparison.scheme_run import SchemeRun
from lure.analysis.rod.simulation import simulate
from lure.analysis.rod.simulation.simulate import LARGEST_CELLS, LARGEST_WORK
from lure.errors import InputError
from lure.rod.scenario import Scenario
from lure.rod.scheme import structured_motion
from lure.rod.upwind import UpwindScheme, upwind


def exact_scheme(scheme: UpwindScheme, scenario: Scenario, until: float, samples: int) -> SchemeRun:
    """The scheme, event to event: :func:`simulate`, or :func:`structured_motion` where that would take too long.

    Parameters
    ----------
    scheme, scenario, until, samples
        See :func:`lure.analysis.rod.comparison.integrate`.

    Raises
    ------
    InputError
        What either of the two refuses; for more than 1000 cells under a load, with what to use instead.
    """
    short = scheme.cells <= LARGEST_CELLS and 2.0 * scheme.cells * scheme.rate * until <= LARGEST_WORK
    if not short and not scenario.free:
        raise InputError(
            f'method "exact" under a load takes at most {LARGEST_CELLS} cells and {LARGEST_WORK:g} cell updates; '
            f"{scheme.cells} cells up to {until:g} s are more, give LSODA or fewer cells"
        )
    before = time.process_time()
    if short:
        run = simulate(scheme, scenario, until=until, samples=samples)
        if run.ended_early is not None:
            raise InputError(f"until is {until:g} s, and the motion is followed to {run.t[-1]:g} s: {run.ended_early}")
        return SchemeRun(
            scheme=scheme,
            method="exact",
            t=run.t,
            z=run.z,
            velocity=None,
            energy=run.energy,
            contacts=tuple((contact.start, contact.end) for contact in run.contacts),
            state=None,
            steps=None,
            evaluations=None,
            cpu_seconds=time.process_time() - before,
        )
    plain = upwind(scheme.rod, scheme.cells)
    motion = structured_motion(plain, scenario, until, samples=samples)
    return SchemeRun(
        scheme=scheme,
        method="exact",
        t=motion.t,
        z=motion.z,
        velocity=motion.wave - scheme.rod.mobility * scheme.rod.law(motion.z),
        energy=None,
        contacts=motion.contacts,
        state=motion.state[scheme.permutation],
        steps=None,
        evaluations=None,
        cpu_seconds=time.process_time() - before,
    )

"""The exact motion of the rod and that of its scheme, side by side."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lure.analysis.rod.confirmation.result import Confirmation, Curves, Kind, Quantity, Side
from lure.analysis.rod.confirmation.rod_side import (
    contradictions_of_rest,
    contradictions_of_rod,
    rest_of_scheme,
    rod_side,
)
from lure.analysis.rod.simulation import Trajectory, simulate
from lure.errors import AssumptionError, InputError
from lure.expressions import Expression
from lure.rod.discretisation import UpwindScheme
from lure.rod.parameters import Rod
from lure.rod.scenario import Scenario

_MOST_STEPS, _STEP = 600.0, 64.0
_LARGEST_ECHO, _LARGEST_RATIO = 1e4, 1e12


def confirmation(scheme: UpwindScheme, scenario: Scenario, until: float, simulated: Trajectory | str) -> Confirmation:
    """Hold the motion of the rod and that of its scheme against what was shown of each.

    In the form ``"as-printed"`` a force ``g`` acts on the scheme as ``g/s`` would, ``s = c N/L``; the rod is given the
    force that the scheme feels.

    Parameters
    ----------
    scheme : UpwindScheme
        The scheme that is simulated, with its rod.
    scenario : Scenario
        Loads and initial data.
    until : float
        End of the motions that are shown [s].
    simulated : Trajectory or str
        A simulation of the scheme, or why there is none.

    Returns
    -------
    Confirmation
        OBSERVED: two motions.  They confirm or contradict a verdict; they never change one.
    """
    rod = scheme.rod
    kind = confirmed_kind(rod, scenario)
    side, skipped = None, None
    try:
        _demand_moderate(rod)
        side = rod_side(rod, _felt(scheme, scenario), until, kind)
    except (InputError, AssumptionError) as refusal:  # the verdicts do not rest on it
        skipped = str(refusal)
    other = None if isinstance(simulated, str) else scheme_side(scheme, simulated, scenario, kind, side)
    found = (() if side is None else contradictions_of_rod(side, kind)) + (
        () if other is None else contradictions_of_rest(other)
    )
    return Confirmation(
        kind=kind,
        rod=side,
        scheme=other,
        rod_skipped=skipped,
        scheme_skipped=simulated if isinstance(simulated, str) else None,
        contradictions=found,
    )


def _demand_moderate(rod: Rod) -> None:
    """Refuse a dashpot with which doubles cannot follow the energy of the rod.

    Raises
    ------
    AssumptionError
        Waves come back from the dashpot more than 1e4 times as high, or ``|k|/Z`` is beyond 1e12 or, not zero, below
        1e-12.
    """
    ratio, echo = abs(rod.damping) / rod.impedance, abs(rod.reflection)
    if echo > _LARGEST_ECHO:
        raise AssumptionError(
            f"rod.damping is so near to minus the impedance {rod.impedance:.6g} N s/m that a wave comes back "
            f"{echo:.2g} times as high from the dashpot, which doubles cannot follow; the exact motion was not computed"
        )
    if rod.damping and not 1 / _LARGEST_RATIO <= ratio <= _LARGEST_RATIO:
        raise AssumptionError(
            f"rod.damping is {ratio:.2g} times the impedance of the rod, beside which doubles lose one of the two; the "
            "exact motion was not computed"
        )


def _felt(scheme: UpwindScheme, scenario: Scenario) -> Scenario:
    """The scenario with the force that the scheme feels."""
    if scheme.form == "corrected" or scenario.force.is_zero:
        return scenario
    force = Expression.parse(f"({scenario.force})/({scheme.rate!r})", variables=("t",), field="force.g")
    return replace(scenario, force=force)


def confirmed_kind(rod: Rod, scenario: Scenario) -> Kind:
    """What a motion can be held against; ``rod``, ``scenario``: the rod, its loads and initial data."""
    if not scenario.free:
        return "load"
    if rod.exact["damping"] > 0:
        return "decay"
    return "undamped" if rod.exact["damping"] == 0 else "growth"


def scheme_side(scheme: UpwindScheme, run: Trajectory, scenario: Scenario, kind: Kind, rod: Side | None) -> Side:
    """The simulation of the scheme, in the terms of the comparison.

    ``run``: the motion of the scheme; ``kind``: what is confirmed; ``rod``: the motion of the rod, whose end says how
    long contact may be waited for.
    """
    side = Side(
        model=f"scheme, N = {scheme.cells}",
        until=float(run.t[-1]),
        contacts=len(run.contacts),
        highest=run.max_gap_coordinate,
        energy_residual=run.energy_residual,
        energy=_quantity(run.energy, run.energy_increase, run.energy_allowance),
        lyapunov=_quantity(run.lyapunov, run.lyapunov_increase, run.lyapunov_allowance),
        lyapunov_theta=run.lyapunov_theta,
        zeta=_quantity(run.zeta, run.zeta_increase, run.zeta_allowance),
        momentum=None,
        rest=None,
        open_end=run.ended_early,
        curves=Curves(
            t=run.t,
            z=run.z,
            zeta=run.zeta if kind == "decay" else None,
            energy=run.energy if kind != "load" else None,
            lyapunov=run.lyapunov,
        ),
    )
    if kind != "decay" or run.zeta is None:
        return side
    run = _longer(scheme, run, scenario, rod)
    rest = rest_of_scheme(scheme, scenario, run)
    side = replace(side, until=float(run.t[-1]), contacts=len(run.contacts), highest=run.max_gap_coordinate)
    side = replace(side, momentum=_momentum(run))
    if isinstance(rest, str):
        return replace(side, open_end=side.open_end or rest)
    return replace(side, rest=rest)


def _longer(scheme: UpwindScheme, run: Trajectory, scenario: Scenario, rod: Side | None) -> Trajectory:
    """The same motion for about as long as the rod was followed, if contact can still come and it costs little."""
    if run.rest_is_final or rod is None or rod.rest is None:
        return run
    longer = min(1.5 * rod.until, _MOST_STEPS * _STEP / scheme.rate)
    if longer <= float(run.t[-1]):
        return run
    try:
        return simulate(scheme, scenario, until=longer, samples=2001)
    except InputError:
        return run


def _momentum(run: Trajectory) -> float:
    """``|zeta - zeta(0) + impulse/k|`` at the end, relative to the largest ``|z|`` or ``|zeta|``."""
    assert run.zeta is not None
    impulse = math.fsum(contact.impulse for contact in run.contacts)
    miss = abs(float(run.zeta[-1]) - float(run.zeta[0]) + impulse / run.damping)
    scale = max(float(np.abs(run.zeta).max()), float(np.abs(run.z).max()))
    return miss / scale if scale > 0.0 else 0.0


def _quantity(values: object, rise: float | None, allowance: float) -> Quantity | None:
    if rise is None or not isinstance(values, np.ndarray):
        return None
    return Quantity.of(values, rise, allowance, float(np.abs(values).max()))

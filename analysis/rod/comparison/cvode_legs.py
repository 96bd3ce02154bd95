"""A leg by CVODE, through scikit-sundae, with contact and release as its roots."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lure.analysis.rod.comparison.equations import BAND
from lure.analysis.rod.comparison.legs import Counted, Leg, Walked, at_zero, stacked, stopping
from lure.errors import InputError

Array = NDArray[np.float64]
CvodeMethod = Literal["CVODE", "CVODE-Adams"]

_ROOT = 2
_MOST_STEPS = 10_000_000
_CLOSE = 1e-13
_FINER, _DEEPEST = 16, 3
_NEAR, _CELL, _GRAZE = 2.0, 0.5, 0.02
_SHARES = np.linspace(0.0, 1.0, 33)[1:-1]


def cvode_leg(leg: Leg, method: CvodeMethod, *, depth: int = 0) -> Walked:
    """Integrate a leg; ``"CVODE"`` by its BDF of order up to 5, ``"CVODE-Adams"`` of order up to 12.

    Newton's method with the banded Jacobian by difference quotients, which for these equations are exact to rounding
    where the law is linear.  CVODE compares signs at the ends of its steps; here they are also compared at every sample
    and at least every ``leg.longest``, near the obstacle twice for every cell a wave passes.  Where the cubic through
    ``z`` and ``z'`` at two such instants changes sign between them, or all but does, the stretch is run again with
    sixteen times as many; what neither shows is missed.

    Parameters
    ----------
    leg : Leg
        The piece.
    method : {"CVODE", "CVODE-Adams"}
        The family.
    depth : int
        How often the stretch was refined.

    Raises
    ------
    InputError
        scikit-sundae is not installed, or CVODE gives up.
    """
    rate = Counted(leg=leg)
    if leg.end - leg.start <= _CLOSE * leg.end:
        rest = leg.equations.observed(np.tile(leg.y, (leg.times.size, 1)))
        return Walked(t=leg.end, y=leg.y, rows=rest, left=False, steps=None, evaluations=0)
    solver = _solver(leg, method, rate)
    solver.init_step(leg.start, leg.y)
    close = leg.times <= leg.start * (1.0 + _CLOSE)  # CVODE does not start for so short a way
    rows, wanted = [leg.equations.observed(np.tile(leg.y, (int(close.sum()), 1)))], leg.times[~close]
    t, y, extra, watch = leg.start, leg.y, 0, leg.watch
    while t < leg.end:
        look = min(leg.end, t + _stride(leg, y), *wanted[:1].tolist())
        found = solver.step(look, method="normal", tstop=leg.end)
        if not found.success or not np.isfinite(found.y).all():
            raise InputError(stopping(leg, method, float(found.t), str(found.message)))
        new_t, new, root = float(found.t), np.array(found.y), found.status == _ROOT
        if not root and watch and float(leg.depth(new[-1:])[0]) < -leg.noise:
            new_t, new, root = t, y, True  # CVODE sees no change of sign where z starts from zero
        elif depth < _DEEPEST and not root and _doubtful(leg, (t, y), (new_t, new)):
            part = replace(leg, start=t, y=y, end=new_t, times=np.empty(0), longest=(new_t - t) / _FINER)
            again = cvode_leg(part, method, depth=depth + 1)
            extra += again.evaluations
            if again.left:
                new_t, new, root = again.t, again.y, True
        if not root and wanted.size and wanted[0] <= new_t:
            rows.append(leg.equations.observed(new[None, :]))
            wanted = wanted[1:]
        t, y, watch = new_t, new, True
        if root:
            break
    else:
        root = False
    y = at_zero(y) if root else y
    return Walked(t=t, y=y, rows=stacked(rows), left=root, steps=None, evaluations=rate.count + extra)


def _stride(leg: Leg, y: Array) -> float:
    """How long ``z`` need not be looked at: half a cell where it could reach the obstacle within two longest steps."""
    near = abs(float(y[-1])) <= _NEAR * leg.longest * float(np.abs(y[:-1]).max(initial=0.0))
    return min(leg.longest, _CELL / leg.equations.scheme.rate) if near else leg.longest


def _solver(leg: Leg, method: CvodeMethod, rate: Counted) -> Any:  # noqa: ANN401  (scikit-sundae has no types)
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        raise InputError(f'method {method!r} needs scikit-sundae: pip install "lure[cvode]"') from None

    class Event:
        """``z``, which ends the leg where it falls through zero in contact and rises through it in flight."""

        terminal = (True,)
        direction = (-1 if leg.touching else 1,)

        def __call__(self, _t: float, y: Array, out: Array) -> None:
            out[0] = y[-1]

    return CVODE(
        rate.into,
        method="Adams" if method == "CVODE-Adams" else "BDF",
        rtol=leg.rtol,
        atol=leg.atol,
        max_step=leg.longest,
        max_num_steps=_MOST_STEPS,
        linsolver="band",
        lband=BAND,
        uband=BAND,
        eventsfn=Event(),
        num_events=1,
    )


def _doubtful(leg: Leg, before: tuple[float, Array], after: tuple[float, Array]) -> bool:
    """Whether the cubic through ``z`` and ``z'`` at both instants takes the wrong sign between them, or nearly."""
    (t0, y0), (t1, y1) = before, after
    span, law, mobility = t1 - t0, leg.equations.scheme.rod.law, leg.equations.scheme.rod.mobility
    ends = np.array([y0[-1], y1[-1]])
    slopes = np.array([y0[-3], y1[-3]]) - (mobility * law(ends) if leg.touching else 0.0)
    s = _SHARES
    cubic = leg.depth(
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * ends[0]
        + s * (1.0 - s) ** 2 * span * slopes[0]
        + s**2 * (3.0 - 2.0 * s) * ends[1]
        - s**2 * (1.0 - s) * span * slopes[1]
    )
    least = float(cubic.min())
    return least < -leg.noise or least < min(float(leg.depth(ends).min()), _GRAZE * span * float(np.abs(slopes).max()))

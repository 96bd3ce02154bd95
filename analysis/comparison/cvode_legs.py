"""A leg by CVODE, through scikit-sundae, with contact and release as its roots."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from analysis.comparison.equations import BAND
from analysis.comparison.legs import Counted, Leg, Walked, at_zero, stacked, stopping
from lure.errors import InputError

Array = NDArray[np.float64]
CvodeMethod = Literal["CVODE", "CVODE-Adams"]

_ROOT = 2
_MOST_STEPS = 10_000_000
_FINER, _DEEPEST = 16, 3
_SHARES = np.linspace(0.0, 1.0, 33)[1:-1]


def cvode_leg(leg: Leg, method: CvodeMethod, *, depth: int = 0) -> Walked:
    """Integrate a leg; ``"CVODE"`` by its BDF of order up to 5, ``"CVODE-Adams"`` of order up to 12.

    Newton's method with the banded Jacobian by difference quotients, which for these equations are exact to rounding
    where the law is linear.  CVODE compares signs at the ends of its steps; here they are also compared at every sample
    and at least every ``leg.longest``, and where the cubic through ``z`` and ``z'`` at two such instants changes sign
    between them the stretch is run again with sixteen times as many.

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
    if leg.end - leg.start <= 1e-14 * leg.end:
        return Walked(t=leg.end, y=leg.y, rows=np.empty((0, 3)), left=False, steps=None, evaluations=0)
    solver = _solver(leg, method, rate)
    solver.init_step(leg.start, leg.y)
    rows, wanted = [], set(leg.times.tolist())
    t, y, extra, first = leg.start, leg.y, 0, leg.watch
    for look in _looks(leg).tolist():
        found = solver.step(look, method="normal", tstop=leg.end)
        if not found.success or not np.isfinite(found.y).all():
            raise InputError(stopping(leg, method, float(found.t), str(found.message)))
        new_t, new, root = float(found.t), np.array(found.y), found.status == _ROOT
        unseen = not root and first and float(leg.depth(new[-1:])[0]) < -leg.noise
        if unseen:  # CVODE sees no change of sign where z starts from zero
            new_t, new, root = t, y, True
        elif depth < _DEEPEST and not root and _hidden(leg, (t, y), (new_t, new)):
            part = replace(leg, start=t, y=y, end=new_t, times=np.empty(0), longest=(new_t - t) / _FINER)
            again = cvode_leg(part, method, depth=depth + 1)
            extra += again.evaluations
            if again.left:
                new_t, new, root = again.t, again.y, True
        if not root and look in wanted:
            rows.append(leg.equations.observed(new[None, :]))
        if root:
            count = rate.count + extra
            return Walked(t=new_t, y=at_zero(new), rows=stacked(rows), left=True, steps=None, evaluations=count)
        t, y, first = new_t, new, True
    return Walked(t=leg.end, y=y, rows=stacked(rows), left=False, steps=None, evaluations=rate.count + extra)


def _looks(leg: Leg) -> Array:
    """Instants to stop at: the samples, the end, and enough others, each after the start."""
    count = max(int(np.ceil((leg.end - leg.start) / leg.longest)), 1)
    even = np.linspace(leg.start, leg.end, count + 1)[1:]
    looks = np.union1d(even, leg.times)
    return looks[looks > leg.start * (1.0 + 1e-14)]


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


def _hidden(leg: Leg, before: tuple[float, Array], after: tuple[float, Array]) -> bool:
    """Whether the cubic through ``z`` and ``z'`` at both instants takes the wrong sign between them."""
    (t0, y0), (t1, y1) = before, after
    span, law, mobility = t1 - t0, leg.equations.scheme.rod.law, leg.equations.scheme.rod.mobility
    ends = np.array([y0[-1], y1[-1]])
    slopes = np.array([y0[-3], y1[-3]]) - (mobility * law(ends) if leg.touching else 0.0)
    s = _SHARES
    cubic = (
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * ends[0]
        + s * (1.0 - s) ** 2 * span * slopes[0]
        + s**2 * (3.0 - 2.0 * s) * ends[1]
        - s**2 * (1.0 - s) * span * slopes[1]
    )
    return bool(leg.depth(cubic).min() < -leg.noise)

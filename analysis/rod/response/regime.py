"""What kind of motion was seen: at rest, repeating, drifting, or none of these within the run."""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

import numpy as np

from lure.analysis.rod.response.recording import Array
from lure.record import Record, quantity

Kind = Literal["rest", "periodic", "drifting", "not seen to repeat"]
Trend = Literal["over", "died out", "still approaching", "still changing", "no trend seen"]
_TIMES = 4
_ROUNDING = 1e-12


class Regime(Record):
    """A motion as it was seen, over a finite time and from one start; it says nothing of other starts."""

    kind: Kind = quantity(
        "``drifting`` is periodic but for the same step in every period: a rod that is pulled away from its "
        "obstacle. ``not seen to repeat`` is no proof that the motion is not periodic: the period may be longer "
        "than a quarter of the run, or the motion not yet there",
        key="regime",
    )
    multiple: int | None = quantity(
        "``n``: it repeats after ``n`` periods of the force and was not seen to after fewer; None if it does not"
    )
    mismatch: float = quantity(
        "Largest distance of ``z`` from the last ``n`` periods, over all phases of the periods that were seen to "
        "repeat, relative to ``range``; for the best ``n`` and all periods if the motion was not seen to repeat "
        "[-]"
    )
    seen: int = quantity("Number of the last periods that agree", key="periods_seen")
    range: float = quantity("Largest minus least ``z`` during the watch, without the drift", "m", key="range_m")
    step: float = quantity("Drift of ``z`` in a period of the force", "m", key="drift_m_per_period", default=0.0)

    def __str__(self) -> str:
        if self.kind == "rest":
            return f"At rest: z moves less than {self.range:.3g} m during the {self.seen} periods watched."
        if self.multiple is None:
            return (
                f"Not seen to repeat: no multiple of the period of the force brings z back to better than "
                f"{self.mismatch:.2g} of its range during the watch.  This does not prove that the motion is chaotic."
            )
        often = "every period" if self.multiple == 1 else f"every {self.multiple} periods"
        drift = f", but for a drift of {self.step:.4g} m a period" if self.kind == "drifting" else ""
        return (
            f"Repeats {often} of the force{drift}, to {self.mismatch:.2g} of its range, seen over {self.seen} periods."
        )


class Transients(Record):
    """Whether the motion was still changing: the four quarters of the watch compared."""

    trend: Trend = quantity(
        "``over``: the motion repeats from the first period watched on (or is at rest). ``died out``: it repeats "
        "since later in the watch. ``still approaching``: it comes closer to repeating from quarter to quarter, "
        "to less than half of the first and a tenth of its range. ``still changing``: the mean or the size of "
        "``z`` moves one way through the four quarters, by more than a fifth of its size",
        key="transients",
    )
    means: tuple[float, ...] = quantity("Mean of ``z`` in each quarter", "m", key="")
    sizes: tuple[float, ...] = quantity("Standard deviation of ``z`` in each quarter", "m", key="")
    mismatches: tuple[float, ...] = quantity(
        "How far ``z`` is from ``n`` periods before, relative to its range, largest in each quarter, for the "
        "``n`` that fits the last quarter best [-]",
        key="",
    )

    def __str__(self) -> str:
        return {
            "over": "Transients are over: the motion is the same from the start of the watch to its end.",
            "died out": "Transients died out during the watch, before the periods that were seen to repeat.",
            "still approaching": "Transients are not over: the motion still comes closer to repeating; settle longer.",
            "still changing": "The motion was still changing during the watch; settle longer.",
            "no trend seen": "No trend was seen between the four quarters of the watch.",
        }[self.trend]


def observed_regime(table: Array, *, tolerance: float, unloaded: bool) -> tuple[Regime, Transients]:
    """Classify a motion from its samples.

    Parameters
    ----------
    table : ndarray
        (R, q) values of ``z``: ``q`` phases of ``R`` periods [m].
    tolerance : float
        How closely it must repeat, relative to its range.
    unloaded : bool
        Whether all loads are constant: a motion that does not move is then at rest.
    """
    size = float(np.ptp(table))
    rounding = _ROUNDING * float(np.abs(table).max())
    if size <= rounding or (unloaded and size <= tolerance * float(np.abs(table).max())):
        regime = Regime(kind="rest", multiple=None, mismatch=0.0, seen=len(table), range=size)
        return regime, _transients(table, regime, 1)
    found = _repeating(table, tolerance, rounding)
    if found is None:
        step = float(table[-1].mean() - table[0].mean()) / (len(table) - 1)
        level = table - step * (np.arange(len(table))[:, None] + np.arange(table.shape[1]) / table.shape[1])
        drifting = _repeating(level, tolerance, rounding) if abs(step) > tolerance * size else None
        if drifting is not None:
            found = Regime(
                kind="drifting",
                multiple=drifting.multiple,
                mismatch=drifting.mismatch,
                seen=drifting.seen,
                range=drifting.range,
                step=step,
            )
            table = level
    if found is not None:
        return found, _transients(table, found, found.multiple or 1)
    multiple = _best(table)
    worst = float(np.abs(table[multiple:] - table[:-multiple]).max()) / size
    regime = Regime(kind="not seen to repeat", multiple=None, mismatch=worst, seen=0, range=size)
    return regime, _transients(table, regime, multiple)


def _repeating(table: Array, tolerance: float, rounding: float) -> Regime | None:
    """The least ``n`` for which the last periods, half of the run and ``4 n`` at least, agree with the last ``n``."""
    periods, size = len(table), float(np.ptp(table))
    allowed = max(tolerance * size, rounding)
    for n in range(1, periods // _TIMES + 1):
        rows = np.arange(periods)
        last = table[periods - n + (rows - periods) % n]
        close = np.abs(table - last).max(axis=1) <= allowed
        seen = periods if close.all() else int(np.argmin(close[::-1]))
        if seen >= max(_TIMES * n, periods // 2):
            miss = float(np.abs(table - last)[periods - seen :].max()) / size
            return Regime(kind="periodic", multiple=n, mismatch=miss, seen=seen, range=size)
    return None


def _best(table: Array) -> int:
    """The ``n`` for which the last quarter comes closest to ``n`` periods before."""
    quarter = max(len(table) // 4, 1)
    misses = [
        float(np.abs(table[-quarter:] - table[-quarter - n : len(table) - n]).max())
        for n in range(1, max(len(table) // _TIMES, 1) + 1)
    ]
    return 1 + int(np.argmin(misses))


def _transients(table: Array, regime: Regime, multiple: int) -> Transients:
    quarters = np.array_split(np.arange(len(table)), 4)
    means = tuple(float(table[rows].mean()) for rows in quarters)
    sizes = tuple(float(table[rows].std()) for rows in quarters)
    away = np.abs(table[multiple:] - table[:-multiple]).max(axis=1) / (regime.range or 1.0)
    mismatches = tuple(float(part.max(initial=0.0)) for part in np.array_split(away, 4))
    return Transients(
        trend=_trend(regime, len(table), (means, sizes, mismatches)), means=means, sizes=sizes, mismatches=mismatches
    )


def _trend(regime: Regime, periods: int, quarters: tuple[tuple[float, ...], ...]) -> Trend:
    means, sizes, mismatches = quarters
    if regime.kind != "not seen to repeat":
        return "over" if regime.seen == periods else "died out"
    if mismatches[-1] < min(0.1, 0.5 * mismatches[0]) and all(b < a for a, b in pairwise(mismatches)):
        return "still approaching"
    moved = any(
        abs(values[-1] - values[0]) > 0.2 * max(sizes) and np.all(np.diff(values) * (values[-1] - values[0]) > 0.0)
        for values in (means, sizes)
    )
    return "still changing" if moved else "no trend seen"

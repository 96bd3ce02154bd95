"""Integrals of the body force along characteristics: Gauss panels between the places where it changes its formula."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lure.errors import InputError
from lure.rod.motion.chebyshev import Array

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_MOST_PANELS = 256

Path = tuple[Array, Array, float, Array]


def along_path(
    rate: Callable[[Array, Array], Array], path: Path, breaks: tuple[tuple[float, ...], tuple[float, ...]]
) -> Array:
    """Integrals (n,) of ``rate(t - s, x - step s)`` over ``0 <= s <= length``.

    Parameters
    ----------
    rate : callable
        From instants and places (any shape) to values.
    path : tuple
        End of each path: instant (n,), place (n,), ``step`` (place per unit of time), and ``length`` (n,).
    breaks : tuple
        Instants and places between which the rate is smooth.

    Raises
    ------
    InputError
        Panels of 16 points, up to 256 between two breaks, do not agree to rounding with half as many.
    """
    t, x, step, length = path
    cuts = [np.zeros(len(t)), length, *(t - instant for instant in breaks[0]), *((x - p) / step for p in breaks[1])]
    edges = np.sort(np.clip(np.column_stack(cuts), 0.0, length[:, None]), axis=1)
    panels, before = 1, _panels(rate, path, edges)
    while panels < _MOST_PANELS:
        panels *= 2
        inner = np.arange(panels) / panels
        fine = edges[:, :-1, None] + np.diff(edges)[:, :, None] * inner
        value = _panels(rate, path, np.column_stack((fine.reshape(len(t), -1), edges[:, -1])))
        if np.abs(value - before).max(initial=0.0) <= 2e-15 * np.abs(value).max(initial=0.0) * panels:
            return value
        before = value
    raise InputError("force.f oscillates too fast along the rod for 4096 points a transit; give a smoother body force")


def _panels(rate: Callable[[Array, Array], Array], path: Path, edges: Array) -> Array:
    t, x, step, _ = path
    half = 0.5 * np.diff(edges)
    s = edges[:, :-1, None] + half[:, :, None] * (_NODES + 1.0)
    values = rate(t[:, None, None] - s, x[:, None, None] - step * s)
    return np.asarray(((values @ _WEIGHTS) * half).sum(axis=1))

"""First states for simulations: along modes of the loop, where harmonic balance points, at scales of the law."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from analysis.refutation.simulated import Law, graph_of
from analysis.refutation.trajectories import BatchLoop, Reals

DECADES = (-9.0, 9.0)
_RANDOM = 4
_AMPLITUDES = 72
_PHASES = 32


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Starts:
    """First states of a batch of solutions.

    Attributes
    ----------
    states : ndarray
        (runs, n), in the coordinates of the :class:`~analysis.refutation.trajectories.BatchLoop`.
    texts : tuple of str
        Each of them in words.
    large : tuple of bool
        Whether ``|sigma|`` is far beyond the scales of the law, which then switches quickly and takes small steps.
    """

    states: Reals
    texts: tuple[str, ...]
    large: tuple[bool, ...]


_SPREAD = 10.0


def scales(law: Law) -> tuple[float, ...]:
    """Values of ``|sigma|`` at which the gain ``phi(sigma)/sigma`` changes, ascending, at most three; 1 if nowhere.

    Parameters
    ----------
    law : Graph, law of the library or callable
        ``phi``; the kinks of a piecewise-linear one are exact, any other is sampled from 1e-9 to 1e9.
    """
    graph = graph_of(law)
    if graph is not None:
        found = sorted({abs(float(x)) for x in graph.kinks if x})
    else:
        sizes = 10.0 ** np.linspace(*DECADES, 181)
        with np.errstate(all="ignore"):
            gains = np.array([np.asarray(law(s * sizes), dtype=float) / (s * sizes) for s in (1.0, -1.0)])
            gains = np.arcsinh(np.nan_to_num(gains) / max(float(np.nan_to_num(np.abs(gains[:, 0])).min()), 1e-12))
        steps = np.abs(np.diff(gains, axis=1)).max(axis=0)
        total = np.cumsum(steps)
        if total[-1] <= 1e-9:
            return (1.0,)
        found = [float(sizes[int(np.searchsorted(total, share * total[-1]))]) for share in (0.05, 0.5, 0.95)]
        found = [min(one, _SPREAD * found[0]) for one in found]  # a gain that swings for ever has no last bend
    found = [one for one in dict.fromkeys(found) if one > 0] or [1.0]
    return tuple(dict.fromkeys((found[0], found[len(found) // 2], found[-1])))


def starts(loop: BatchLoop, knees: tuple[float, ...], gain: float, *, seed: int = 0) -> Starts:
    """States along the modes of the loop with a medium gain, where harmonic balance points, and at random.

    Each is scaled so that the linear loop with the gain ``gain`` would reach ``|sigma|`` of a chosen size: small and
    large against the scales of the law, and near them.

    Parameters
    ----------
    loop : BatchLoop
        The loop.
    knees : tuple of float
        The scales of the law.
    gain : float
        A gain of the class.
    seed : int
        Of the random directions.
    """
    sizes = _sizes(knees)
    directions = [*_modes(loop.closed(gain)), *np.random.default_rng(seed).standard_normal((_RANDOM, loop.order))]
    response = _peaks(loop, gain)
    few = loop.order <= 3
    states, texts, large = [], [], []
    for i, direction in enumerate(directions):
        length = float(np.abs(direction).max())
        peak = float(np.abs(response @ direction).max())
        unit = direction / (peak if peak > 1e-9 * length * float(np.abs(response).max()) else length)
        for size in (sizes[i % len(sizes)], -sizes[(i + 2) % len(sizes)])[: 2 if few else 1]:
            states.append(size * unit)
            texts.append(f"|sigma| of about {abs(size):.3g}")
            large.append(abs(size) > 10 * knees[-1])
    return Starts(states=np.array(states).reshape(len(states), loop.order), texts=tuple(texts), large=tuple(large))


def balanced_starts(loop: BatchLoop, low: float, high: float) -> Starts:
    """States on the oscillations that harmonic balance suggests, or comes closest to; empty where no mode oscillates.

    For ``sigma = A sin(theta)`` the law acts as the gain ``N(A)``; where the least damped oscillating mode of the loop
    with that gain stops to decay, or decays least, its eigenvector of amplitude ``A`` is taken.  A hint and no more.

    Parameters
    ----------
    loop : BatchLoop
        The loop.
    low, high : float
        Least and largest scale of the law.
    """
    amplitudes = np.geomspace(0.3 * low, 300 * high, _AMPLITUDES)
    sines = np.sin((np.arange(_PHASES) + 0.5) * 2 * math.pi / _PHASES)
    with np.errstate(all="ignore"):
        values = np.asarray(loop.values((amplitudes[:, None] * sines).ravel()), dtype=float).reshape(_AMPLITUDES, -1)
        gains = 2 * (values * sines).mean(axis=1) / amplitudes
    rates, modes = np.full(_AMPLITUDES, -math.inf), np.zeros((_AMPLITUDES, loop.order), dtype=complex)
    for i, gain in enumerate(gains):
        if not math.isfinite(gain) or 1 + gain * loop.d <= 0:
            continue
        roots, vectors = np.linalg.eig(loop.closed(float(gain)))
        growth = np.log(np.maximum(np.abs(roots), 1e-300)) if loop.discrete else roots.real
        swing = np.where(np.abs(roots.imag) > 1e-6 * np.abs(roots).max(initial=0.0), growth, -math.inf)
        best = int(swing.argmax())
        rates[i], modes[i] = swing[best], vectors[:, best]
    signs = np.flatnonzero(np.sign(rates[1:]) * np.sign(rates[:-1]) < 0)
    chosen = [*signs[:3], int(rates.argmax())] if np.isfinite(rates).any() else []
    states = []
    for i in dict.fromkeys(chosen):
        output = abs(complex(loop.c @ modes[i]) / (1 + gains[i] * loop.d))
        if output > 1e-12 * float(np.abs(modes[i]).max()):
            states.append(amplitudes[i] / output * modes[i].real)
    texts = tuple("near an oscillation that harmonic balance suggests" for _ in states)
    return Starts(
        states=np.array(states).reshape(len(states), loop.order), texts=texts, large=tuple(False for _ in states)
    )


def _sizes(knees: tuple[float, ...]) -> tuple[float, ...]:
    """Sizes of ``|sigma|``: below the least scale of the law, at each, above the largest."""
    low, high = knees[0], knees[-1]
    return (0.03 * low, 1e3 * high, *(3.0 * knee for knee in knees), 30.0 * high, 0.9 * low)


def _modes(matrix: Reals) -> list[Reals]:
    """Real and imaginary parts of the eigenvectors, at most eight: slowest and fastest first."""
    roots, vectors = np.linalg.eig(matrix)
    order = np.argsort(-roots.real)
    found = [vectors[:, i] for i in order if roots[i].imag >= 0]
    parts = [part for v in found for part in ((v.real,) if np.abs(v.imag).max() < 1e-12 else (v.real, v.imag))]
    return [*parts[:4], *parts[4:][-4:]]


def _peaks(loop: BatchLoop, gain: float) -> Reals:
    """(instants, n): its product with a first state is ``sigma`` of the linear loop with this gain."""
    matrix, row = loop.closed(gain), loop.c / (1 + gain * loop.d)
    if loop.discrete:
        powers = [row]
        for _ in range(40):
            powers.append(powers[-1] @ matrix)
        return np.array(powers)
    return np.array([row @ expm(matrix * t) for t in (0.0, *np.geomspace(1e-3, 20.0, 40))])

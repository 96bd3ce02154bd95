"""Functions known by their values alone: what a sample shows, and what follows from a constant the user vouches for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from lure.analysis.nonlinearity.result import Extreme, NonlinearityBounds
from lure.analysis.verdict import Evidence
from lure.arrays import ArrayLike, NDArray, np
from lure.errors import AssumptionError, InputError
from lure.record.values import exact_text

DECADES = 9
_ROUNDS, _FINE = 12, 41
_ROUNDING = 1e-9
_ROOM = 1e-13  # about ten operations of doubles


@dataclass(frozen=True, slots=True)
class Sample:
    """Ascending points, without 0, at which the nonlinearity was asked, and what it answered."""

    x: NDArray[np.float64]
    phi: NDArray[np.float64]

    @property
    def chords(self) -> NDArray[np.float64]:
        """``phi(sigma)/sigma``."""
        return self.phi / self.x


def sampled(
    nonlinearity: Callable[[ArrayLike], ArrayLike], name: str, on: tuple[Fraction, Fraction] | None, samples: int
) -> tuple[Sample, Sample]:
    """The sample of a nonlinearity: evenly in the logarithm on both sides of 0, denser near the extremes found.

    Parameters
    ----------
    nonlinearity : callable
        Takes an array of floats, or one float.
    name : str
        The nonlinearity in words, for errors.
    on : tuple of Fraction, or None
        The interval; None for ``1e-9 <= |sigma| <= 1e9``.
    samples : int
        Number of points before refinement, at least 10.

    Returns
    -------
    tuple of Sample
        The sample, and the same with the point 0, for slopes.

    Raises
    ------
    InputError
        The nonlinearity has no finite value at a point, or does not vanish at 0.
    """
    low, high = (-(10.0**DECADES), 10.0**DECADES) if on is None else (float(on[0]), float(on[1]))
    x = _spread(low, high, samples)
    phi = _values(nonlinearity, name, x)
    zero = low <= 0 <= high
    if zero and (start := _values(nonlinearity, name, np.zeros(1))[0]) != 0:
        raise InputError(
            f"the nonlinearity {name:.60} has phi(0) = {start:.6g}; a sector needs a nonlinearity that vanishes at 0"
        )
    with np.errstate(over="ignore"):
        for _ in range(_ROUNDS):
            chords, steps = phi / x, np.diff(phi) / np.diff(x)
            near = {int(i) for i in (np.argmax(chords), np.argmin(chords))}
            near |= {int(i) for i in (np.argmax(steps), np.argmin(steps))}
            finer = [np.linspace(x[max(i - 1, 0)], x[min(i + 2, len(x) - 1)], _FINE) for i in near]
            gaps = [g for g in finer if g[-1] - g[0] > 1e-6 * max(abs(g[0]), abs(g[-1]))]
            if not gaps:
                break
            more = np.setdiff1d(np.concatenate(gaps), np.append(x, 0.0))
            x, phi = np.append(x, more), np.append(phi, _values(nonlinearity, name, more))
            order = np.argsort(x)
            x, phi = x[order], phi[order]
    place = int(np.searchsorted(x, 0.0))
    full = Sample(np.insert(x, place, 0.0), np.insert(phi, place, 0.0)) if zero else Sample(x, phi)
    return Sample(x, phi), full


def observed(sample: tuple[Sample, Sample], name: str, on: tuple[Fraction, Fraction] | None) -> NonlinearityBounds:
    """The extremes of a sample; they bound nothing between its points."""
    chords, places = sample[0].chords, sample[0].x
    x, phi = sample[1].x, sample[1].phi
    slopes = np.diff(phi) / np.diff(x)
    span = f"1e-{DECADES} <= |sigma| <= 1e{DECADES}" if on is None else "the interval"
    return NonlinearityBounds(
        nonlinearity=name,
        sector_lower=_seen(chords, places, np.argmin(chords), -math.inf),
        sector_upper=_seen(chords, places, np.argmax(chords), math.inf),
        slope_lower=_between(slopes, x, np.argmin(slopes), -math.inf),
        slope_upper=_between(slopes, x, np.argmax(slopes), math.inf),
        evidence=Evidence.OBSERVED,
        on=on,
        notes=(f"{len(places)} points of {span} were asked: nothing is shown between or beyond them",),
    )


def lipschitz_bounds(
    sample: tuple[Sample, Sample], name: str, on: tuple[Fraction, Fraction] | None, lipschitz: Fraction
) -> NonlinearityBounds:
    """Bounds that hold if the nonlinearity is Lipschitz with the constant, which the sample must not contradict.

    Between two points ``x < y`` of one side, ``phi`` lies below ``min(phi(x) + L (sigma - x), phi(y) + L (y - sigma))``
    and its chord is largest where the two meet.  Where 0 belongs to the interval only ``phi(0) = 0`` is left, hence
    ``|phi(sigma)/sigma| <= L``.

    Raises
    ------
    AssumptionError
        Two points of the sample have a difference quotient larger than the constant.
    """
    seen = observed(sample, name, on)
    x, phi = sample[1].x, sample[1].phi
    steps = np.diff(phi) / np.diff(x)
    noise = 4e-16 * (np.abs(phi[1:]) + np.abs(phi[:-1])) / np.diff(x)
    worst = int(np.argmax(np.abs(steps) - noise))
    if abs(steps[worst]) - noise[worst] > float(lipschitz) * (1 + _ROUNDING):
        raise AssumptionError(
            f"the nonlinearity {name:.60} is said to have the Lipschitz constant {exact_text(lipschitz)}, but its "
            "slope between "
            f"sigma = {x[worst]:.10g} and {x[worst + 1]:.10g} is {steps[worst]:.6g}; give a constant that holds"
        )
    zero = on is None or on[0] <= 0 <= on[1]
    low, high = (-lipschitz, lipschitz) if zero else _cones(sample[0], lipschitz)
    limits = (low, high, -lipschitz, lipschitz)
    parts = (seen.sector_lower, seen.sector_upper, seen.slope_lower, seen.slope_upper)
    found = [
        _bounded(part, limit, side)
        for part, limit, side in zip(parts, limits, (-1, 1, -1, 1), strict=True)
        if part is not None
    ]
    return NonlinearityBounds(
        nonlinearity=name,
        sector_lower=found[0],
        sector_upper=found[1],
        slope_lower=found[2],
        slope_upper=found[3],
        evidence=Evidence.CERTIFIED,
        on=on,
        assumptions=(
            f"|phi(x) - phi(y)| <= {exact_text(lipschitz)} |x - y|, which is assumed",
            "the function returns phi exactly" if not zero else "phi(0) = 0 exactly",
        ),
        notes=("the inner bounds are those of a sample",),
    )


def _cones(sample: Sample, lipschitz: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds on the chords between sampled points of one side of 0, with room for rounding."""
    x0, x1, y0, y1 = sample.x[:-1], sample.x[1:], sample.phi[:-1], sample.phi[1:]
    slope = float(lipschitz)
    found = [sample.chords]
    for sign in (1, -1):
        meeting = np.clip((x0 + x1) / 2 + sign * (y1 - y0) / (2 * slope), x0, x1)
        found.append((y0 + sign * slope * (meeting - x0)) / meeting)
    values = np.concatenate(found)
    room = _ROOM * (slope + float(np.abs(sample.chords).max()))
    return Fraction(float(values.min()) - room), Fraction(float(values.max()) + room)


def _spread(low: float, high: float, samples: int) -> NDArray[np.float64]:
    parts = []
    for side, far in ((1, high), (-1, -low)):
        near = max(side * (low if side > 0 else high), 0.0)
        if far <= 0 or far <= near:
            continue
        count = max(samples // 2, 5)
        start = near if near > 0 else far * 10.0 ** (-2 * DECADES if math.isclose(far, 10.0**DECADES) else -DECADES)
        sizes = np.concatenate([np.geomspace(start, far, count), np.linspace(start, far, count // 2)])
        parts.append(side * sizes)
    x = np.unique(np.concatenate(parts)) if parts else np.array([])
    return np.asarray(np.clip(x[x != 0], low, high))


def _values(nonlinearity: Callable[[ArrayLike], ArrayLike], name: str, x: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(all="ignore"):
        try:
            phi = np.asarray(nonlinearity(x), dtype=float)
            if phi.shape != x.shape:
                raise ValueError
        except (TypeError, ValueError):
            try:
                phi = np.array([float(np.asarray(nonlinearity(float(point)))) for point in x])
            except (ArithmeticError, TypeError, ValueError) as error:
                raise InputError(
                    f"the nonlinearity {name:.60} cannot be evaluated ({error}); give a function of one number"
                ) from None
    if not np.isfinite(phi).all():
        raise InputError(
            f"the nonlinearity {name:.60} has no finite value at sigma = {x[~np.isfinite(phi)][0]:.10g}; bound it "
            "on an interval where it has"
        )
    return phi


def _seen(values: NDArray[np.float64], places: NDArray[np.float64], i: np.intp, outer: float) -> Extreme:
    return Extreme(inner=Fraction(float(values[i])), outer=outer, at=Fraction(float(places[i])), attained=True)


def _between(values: NDArray[np.float64], x: NDArray[np.float64], i: np.intp, outer: float) -> Extreme:
    at = (Fraction(float(x[i])), Fraction(float(x[i + 1])))
    return Extreme(inner=Fraction(float(values[i])), outer=outer, at=at, attained=True)


def _bounded(part: Extreme, outer: Fraction, side: int) -> Extreme:
    """The extreme of a sample with a bound; what rounding put beyond it is cut off."""
    inner = min(part.inner, outer) if side > 0 else max(part.inner, outer)
    return Extreme(inner=inner, outer=outer, at=part.at, attained=part.attained)

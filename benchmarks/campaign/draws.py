"""Loops with one channel, drawn at random: plants of all kinds in short decimals, and classes about their ends."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from campaign.exact import Poly, Rational, furthest, times

from lure import NonlinearityClass, Sector, SlopeBounds

PLANTS = ("continuous", "discrete", "critical", "unstable", "scaled", "cancelling", "dead time")
SMALL = tuple(f"small {kind}" for kind in PLANTS if kind != "dead time")  # of one or two factors
INF = math.inf


@dataclass(frozen=True)
class Drawn:
    """A loop: its plant and its class."""

    plant: Rational
    one: NonlinearityClass

    def __str__(self) -> str:
        n, d = ([str(v) for v in side] for side in (self.plant.n, self.plant.d))
        time = "discrete" if self.plant.discrete else f"continuous, delay {self.plant.delay}"
        return f"n={n} d={d} {time}; {self.one!r}"


def short(value: float, digits: int = 2) -> Fraction:
    """A number rounded to some digits that count."""
    return Fraction(f"{value:.{digits}g}")


def stable_factor(rng: np.random.Generator, *, discrete: bool) -> Poly:
    """A factor with one or two stable roots."""
    pair = rng.random() < 0.4
    if discrete:
        r = short(rng.uniform(0.05, 0.98))
        return (
            [Fraction(1), short(2 * float(r) * math.cos(rng.uniform(0, math.pi))) * Fraction(99, 100), r * r]
            if (pair)
            else [Fraction(1), -r * rng.choice([1, 1, -1]).item()]
        )
    pole = short(10 ** rng.uniform(-1, 1))
    damping = short(10 ** rng.uniform(-2, 0.2))
    return [Fraction(1), 2 * damping * pole, pole * pole] if pair else [Fraction(1), pole]


def zero_factor(rng: np.random.Generator, *, discrete: bool) -> Poly:
    """A factor with one or two zeros, which may be anywhere."""
    factor = stable_factor(rng, discrete=discrete)
    if rng.random() < 0.3:
        factor = [v * (-1) ** i for i, v in enumerate(factor)]
    if rng.random() < 0.1:
        return [Fraction(1), Fraction(-1 if discrete else 0)]
    return [v * 2**i for i, v in enumerate(factor)] if discrete and rng.random() < 0.3 else factor


def rational(rng: np.random.Generator, kind: str, *, factors: int = 3) -> Rational:
    """A plant of a kind, with a denominator of at most so many factors beside those of the kind."""
    discrete = kind == "discrete" or (kind not in ("continuous", "dead time") and rng.random() < 0.4)
    origin = [Fraction(1), Fraction(-1 if discrete else 0)]
    d = times(*(stable_factor(rng, discrete=discrete) for _ in range(int(rng.integers(1, factors + 1)))))
    if kind == "critical":
        d = times(d, origin)
    if kind == "unstable":
        factor = stable_factor(rng, discrete=discrete)
        d = times(d, [v * Fraction("1.5") ** i for i, v in enumerate(factor)] if discrete else [
            v * (-1) ** i for i, v in enumerate(factor)
        ])  # fmt: skip
    n = [Fraction(1)]
    while rng.random() < 0.5 and len(n) < len(d):
        n = times(n, zero_factor(rng, discrete=discrete))
    while len(n) > len(d) or (len(n) == len(d) and rng.random() < 0.6):
        n = n[:-1] if len(n) > 1 else n
    n = [short(10 ** rng.uniform(-1, 1)) * (-1 if rng.random() < 0.15 else 1) * v for v in n]
    n = [Fraction(0)] if rng.random() < 0.002 else n
    plant = Rational(n, d, discrete=discrete)
    if kind == "cancelling":
        place = stable_factor(rng, discrete=discrete)
        place = [v * (-1 if rng.random() < 0.4 else 1) ** i for i, v in enumerate(place)]
        off = Fraction(0) if rng.random() < 0.4 else Fraction(10) ** -int(rng.integers(2, 14))
        near = [*place[:-1], place[-1] * (1 + off * (1 if rng.random() < 0.5 else -1))]
        plant = replace(plant, n=times(plant.n, near), d=times(plant.d, place))
    if kind == "scaled":
        plant = plant.scaled(*(Fraction(10) ** int(rng.integers(-8, 9)) for _ in range(2)))
    if kind == "dead time":
        plant = replace(plant, delay=short(10 ** rng.uniform(-2, 0.7)))
    while len(plant.n) > 1 and plant.n[0] == 0:
        plant = replace(plant, n=plant.n[1:])
    return plant


def screened(plant: Rational) -> tuple[float, float, float]:
    """A gain for which the linear loop is stable, if there is one, and roughly the ends of the gains about it."""
    n, d = ([float(v) for v in side] for side in (plant.n, plant.d))
    size = abs(d[-1]) / max(abs(n[-1]), 1e-3 * max(map(abs, n), default=1), 1e-300) or 1.0
    grid = size * np.concatenate([-np.geomspace(1e3, 1e-3, 40), [0], np.geomspace(1e-3, 1e3, 60)])
    good = furthest(plant.d, plant.n, grid, discrete=plant.discrete) < 0
    inside = np.flatnonzero(good)
    if not len(inside):
        return 0.0, -size, size
    start = 40 if good[40] else int(inside[len(inside) // 2])
    low = high = start
    while low > 0 and good[low - 1]:
        low -= 1
    while high + 1 < len(grid) and good[high + 1]:
        high += 1
    return float(grid[start]), float(grid[low]), float(grid[high])


def class_about(rng: np.random.Generator, plant: Rational) -> NonlinearityClass:
    """A class whose bounds lie about the ends of the gains for which the linear loop is stable."""
    centre, least, most = screened(plant)
    lower = Fraction(0)
    if centre != 0 or rng.random() < 0.25:
        lower = short(centre + rng.choice([-1, -0.5, 0, 0.2, 1.02]) * (centre - least) * rng.choice([0.5, 1]))
    reach = rng.choice([0.05, 0.3, 0.6, 0.9, 0.999, 1.001, 1.2, 3])
    upper: float | Fraction = lower + max(short((most - float(lower)) * reach, 4), Fraction(1, 10**12))
    if rng.random() < 0.07:
        upper = INF
    sector = Sector(lower, upper)
    form = rng.choice(
        ["sector", "varying", "slope", "odd", "wide", "gain", "slow"], p=[0.3, 0.2, 0.15, 0.15, 0.1, 0.07, 0.03]
    )
    if form == "varying":
        return NonlinearityClass(sector=sector, time_varying=True)
    if form in ("slope", "odd"):
        return NonlinearityClass.slope_restricted(lower, upper, odd=form == "odd")
    if form == "wide":
        width = (upper if upper < INF else lower + 1) - lower
        slope = SlopeBounds(lower - width * short(rng.uniform(0, 1)), upper + width * short(rng.uniform(0, 2)))
        return NonlinearityClass(sector=sector, slope=slope, odd=bool(rng.random() < 0.5))
    if upper < INF and form == "gain":
        return NonlinearityClass.constant_gain(lower, upper)
    if upper < INF and form == "slow":
        return NonlinearityClass.varying_gain(lower, upper, rate=short(float(upper - lower) * 10 ** rng.uniform(-3, 0)))
    return NonlinearityClass(sector=sector)


def drawn(rng: np.random.Generator, kind: str) -> Drawn:
    """A loop of a kind."""
    small = kind in SMALL
    plant = rational(rng, kind.removeprefix("small "), factors=2 if small else 3)
    return Drawn(plant, class_about(rng, plant))

"""One loop in many forms: coefficients, matrices, text, other units, mirrored, shifted.  The answers have to fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from campaign.draws import Drawn
from campaign.exact import Poly, Rational, plus

from lure import NonlinearityClass, Sector, SlopeBounds, as_plant

FORMS = ("coefficients", "matrices", "transposed", "basis", "text", "time", "gain", "mirror", "shift", "common factor")
LATE = ("text", "time", "gain")


@dataclass(frozen=True)
class Brought:
    """What is handed over, the loop that it is, and how its gains ``k`` follow from those of the first form."""

    name: str
    source: object
    case: Drawn
    factor: Fraction = Fraction(1)
    offset: Fraction = Fraction(0)


def text_of(side: Poly, variable: str) -> str:
    """A polynomial as a formula."""
    terms = [f"({v})*{variable}**{len(side) - 1 - i}" for i, v in enumerate(side) if v]
    return "+".join(terms) or "0"


def formula(plant: Rational) -> str:
    """The plant as a formula."""
    variable = "z" if plant.discrete else "s"
    late = f"exp(-({plant.delay})*s)*" if plant.delay else ""
    return f"{late}({text_of(plant.n, variable)})/({text_of(plant.d, variable)})"


def dt_of(plant: Rational) -> int | None:
    """The sampling time as the library takes it."""
    return 1 if plant.discrete else None


def plain(plant: Rational) -> object:
    """The block as coefficients, or as a formula with a dead time."""
    return as_plant(formula(plant) if plant.delay else (plant.n, plant.d), dt=dt_of(plant))


def rescaled(one: NonlinearityClass, factor: Fraction, offset: Fraction, paced: Fraction) -> NonlinearityClass:
    """The class with its gains times ``factor``, then more by ``offset``; a negative factor exchanges the ends."""

    def value(end: float | Fraction) -> float | Fraction:
        return Fraction(end) * factor + offset if abs(end) < math.inf else end * (1 if factor > 0 else -1)

    def ends(low: float | Fraction, high: float | Fraction) -> tuple[float | Fraction, float | Fraction]:
        a, b = value(low), value(high)
        return (a, b) if factor > 0 else (b, a)

    sector = Sector(*ends(one.sector.lower, one.sector.upper))
    slope = None if one.slope is None else SlopeBounds(*ends(one.slope.lower, one.slope.upper))
    rate = None if one.rate is None else one.rate * abs(factor) * paced
    return replace(one, sector=sector, slope=slope, rate=rate)


def brought(case: Drawn, name: str, rng: np.random.Generator) -> Brought:
    """The loop in a form."""
    plant, one = case.plant, case.one
    dt = dt_of(plant)
    if name == "coefficients" or (name in ("matrices", "transposed", "basis") and len(plant.d) == 1):
        return Brought(name, as_plant(([str(v) for v in plant.n], [str(v) for v in plant.d]), dt=dt), case)
    if name == "text":
        return Brought(name, as_plant(formula(plant), dt=dt), case)
    if name in ("matrices", "transposed", "basis"):
        A, b, c, d = plant.matrices()
        if name == "transposed":
            A, b, c = [list(column) for column in zip(*A, strict=True)], c, b
        if name == "basis":
            for _ in range(3):  # x_i + t x_j for x_i: A -> T A T^-1
                i, j = rng.integers(0, len(b), 2)
                t = Fraction(int(rng.integers(-3, 4)), 2)
                if i != j:
                    A[i] = [u + t * v for u, v in zip(A[i], A[j], strict=True)]
                    b[i] += t * b[j]
                    for row in A:
                        row[j] -= t * row[i]
                    c[j] -= t * c[i]
        return Brought(name, as_plant((A, [[v] for v in b], [c], [[d]]), dt=dt), case)
    if name == "time":
        unit = Fraction(10) ** int(rng.integers(-4, 5)) if not plant.discrete else Fraction(1)
        other = Drawn(plant.scaled(unit, Fraction(1)), rescaled(one, Fraction(1), Fraction(0), unit))
        return Brought(name, plain(other.plant), other)
    if name == "gain":
        share = Fraction(10) ** int(rng.integers(-6, 7))
        other = Drawn(plant.scaled(Fraction(1), share), rescaled(one, 1 / share, Fraction(0), Fraction(1)))
        return Brought(name, plain(other.plant), other, factor=1 / share)
    if name == "mirror":
        if one.sector.upper == math.inf or (one.slope is not None and one.slope.upper == math.inf):
            return brought(case, "coefficients", rng)
        other = Drawn(plant.scaled(Fraction(1), Fraction(-1)), rescaled(one, Fraction(-1), Fraction(0), Fraction(1)))
        return Brought(name, plain(other.plant), other, factor=Fraction(-1))
    if name == "shift":
        low = Fraction(one.sector.lower)
        if 1 + low * plant.through == 0:
            return brought(case, "coefficients", rng)
        moved = Rational(plant.n, plus(plant.d, plant.n, low), plant.discrete)
        other = Drawn(moved, rescaled(one, Fraction(1), -low, Fraction(1)))
        return Brought(name, plain(moved), other, offset=-low)
    if name == "common factor":
        factor = [Fraction(1), Fraction(1, 2)] if not plant.discrete else [Fraction(1), Fraction(-1, 3)]
        from campaign.exact import times

        other = Drawn(replace(plant, n=times(plant.n, factor), d=times(plant.d, factor)), one)
        return Brought(name, plain(other.plant), other)
    raise ValueError(name)

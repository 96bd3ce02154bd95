"""Loops with tolerances, with formulas for nonlinearities, and regions of attraction."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from fractions import Fraction

import mpmath
import numpy as np
from campaign.draws import Drawn, class_about, rational
from campaign.exact import Rational
from campaign.forms import formula
from campaign.members import constant
from campaign.replay import replayed
from campaign.single import Counts, checked

from lure import AssumptionError, InputError, Saturation, as_plant, certify
from lure.analysis import nonlinearity_bounds, region
from lure.analysis.questions.certify import ProofOptions
from lure.analysis.questions.regions import AttractedSet, OutsideSet
from lure.analysis.verdict import Verdict
from lure.nonlinearities import Cubic
from lure.plants.family import PlantFamily

SECONDS = 4.0
ATOMS = (
    *("tanh({a}*sigma)", "sin({a}*sigma)", "sigma", "atan({a}*sigma)", "sigma/(1+{a}*sigma**2)", "sigma**3"),
    *("sigma*exp(-{a}*sigma**2)", "sigma*cos({a}*sigma)", "abs(sigma)*sigma/(1+abs(sigma))", "log(1+{a}*abs(sigma))"),
    *("sigma/sqrt(1+{a}*sigma**2)", "exp({a}*sigma)-1", "abs(sigma)", "min({a}, max(-1, sigma))", "sigma**2"),
)


def box(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """A plant whose coefficients lie in intervals: corners and plants inside, with constant gains in balls."""
    counts = Counter[str]()
    plant = rational(rng, str(rng.choice(["continuous", "discrete", "critical"])))
    one = class_about(rng, plant)
    count = int(rng.integers(1, 3))
    sides = [list(plant.n), list(plant.d)]
    places = [
        (int(k), int(rng.integers(len(sides[k]) if k == 0 else len(sides[k]) - 1)) + (k == 1))
        for k in rng.integers(0, 2, count)
    ]
    places = sorted({(k, i) for k, i in places if sides[k][i]})
    bounds: dict[str, tuple[Fraction, Fraction]] = {}
    text = [[f"({v})" for v in side] for side in sides]
    for number, (k, i) in enumerate(places):
        share = Fraction(int(rng.integers(1, 40)), 100)
        ends = sorted((sides[k][i] * (1 - share), sides[k][i] * (1 + share)))
        bounds[f"p{number}"] = (ends[0], ends[1])
        text[k][i] = f"p{number}"
    case = (text, bounds, one, plant.discrete)
    if not bounds:
        return counts, [], case
    variable = "z" if plant.discrete else "s"
    written = ["+".join(f"{v}*{variable}**{len(side) - 1 - i}" for i, v in enumerate(side)) for side in text]
    try:
        family = PlantFamily.of_formula(f"({written[0]})/({written[1]})", bounds, dt=1 if plant.discrete else None)
        found = certify(family, one, ways=ProofOptions(seconds=SECONDS))
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return counts, [], case
    counts[str(found.verdict)] += 1
    if found.certificate is None:
        return counts, [], case
    counts["certificates"] += 1
    faults = [said] if (said := checked(found.certificate)) else []

    def at(values: dict[str, Fraction]) -> Rational:
        sides = [[values[v] if v in values else Fraction(v[1:-1]) for v in side] for side in text]
        return Rational(sides[0], sides[1], plant.discrete)

    if found.verdict is Verdict.REFUTED:
        proof = found.certificate["proof"]
        if proof["method"] == "member":
            names = [name for name, *_ in found.certificate["system"]["parameters"]]
            values = {name: Fraction(v) for name, v in zip(names, proof["at"], strict=True)}
            inside = all(bounds[name][0] <= v <= bounds[name][1] for name, v in values.items())
            counts["replayed"] += 1
            said = replayed(Drawn(at(values), one), proof["proof"]) if inside else f"{values} lies outside"
            counts["not replayed"] += said == "-"
            faults += [f"REFUTED: {said}"] if said not in ("", "-") else []
        return counts, faults, case
    inside = [
        {n: lo + (hi - lo) * Fraction(int(rng.integers(0, 101)), 100) for n, (lo, hi) in bounds.items()}
        for _ in range(4)
    ]
    for values in (
        *inside,
        *(dict(zip(bounds, corner, strict=True)) for corner in itertools.product(*bounds.values())),
    ):
        counts["attack: plants of the box"] += 1
        said = constant(Drawn(at(values), one), str(found.certificate["conclusion"]), rng)
        faults += [f"PROVED against {said} at {values}"] if said else []
    return counts, faults, case


def drawn_formula(rng: np.random.Generator) -> str:
    """A formula with ``phi(0) = 0`` from one to three parts."""
    parts = []
    for _ in range(int(rng.integers(1, 4))):
        a, b = (str(Fraction(int(rng.integers(1, 41)), 10)) for _ in range(2))
        sign = "-" if rng.random() < 0.25 else ""
        parts.append(f"{sign}({b})*" + str(rng.choice(ATOMS)).format(a=f"({a})"))
    return " + ".join(parts)


def formulas(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """A formula: its bounds against values at many digits, its class, and a loop with it followed from some starts."""
    counts = Counter[str]()
    text = drawn_formula(rng)
    plant = rational(rng, str(rng.choice(["continuous", "discrete", "critical"])))
    plant = plant.scaled(Fraction(1), Fraction(int(rng.integers(1, 100)), 100))
    case = (text, formula(plant))
    try:
        found = nonlinearity_bounds(text, seconds=SECONDS)
        counts["attack: values of a formula"] += 1
        faults = against_values(text, found, rng)
        loop = certify(
            as_plant((plant.n, plant.d), dt=1 if plant.discrete else None), text, ways=ProofOptions(seconds=SECONDS)
        )
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return counts, [], case
    counts[str(loop.verdict)] += 1
    if loop.certificate is None:
        return counts, faults, case
    counts["certificates"] += 1
    faults += [said] if (said := checked(loop.certificate)) else []
    if loop.verdict is Verdict.PROVED:
        laws = loop.certificate["laws"]
        sector = [
            float(Fraction(v)) if "in" not in v else math.inf * (-1 if v[0] == "-" else 1) for v in laws["sector"]
        ]
        shares = [v / x for x, v in values_of(text, rng, 40)]
        if not all(sector[0] - 1e-12 <= share <= sector[1] + 1e-12 for share in map(float, shares)):
            faults.append(f"the certificate is of the sector {sector}")
        if laws["odd"] and any(abs(v + w) > 1e-30 * (1 + abs(v)) for v, w in zip(*(
            [_value(text, s * x) for x in (mpmath.mpf("0.37"), mpmath.mpf(2), mpmath.mpf(11))] for s in (1, -1)
        ), strict=True)):  # fmt: skip
            faults.append("the certificate is of odd functions")
    return counts, faults, case


def _value(text: str, x: mpmath.mpf) -> mpmath.mpf:
    names = {"sigma": x, "abs": abs, "min": min, "max": max}
    known = ("tanh", "sin", "cos", "atan", "exp", "log", "sqrt")
    with mpmath.workdps(50):
        return mpmath.mpf(eval(text, {"__builtins__": {}}, names | {name: getattr(mpmath, name) for name in known}))


def values_of(text: str, rng: np.random.Generator, count: int) -> list[tuple[mpmath.mpf, mpmath.mpf]]:
    """Places, small and large, and the values there."""
    xs = [mpmath.mpf(float(s * 10 ** rng.uniform(-6, 2))) for s in rng.choice([-1, 1], count)]
    return [(x, _value(text, x)) for x in xs]


def against_values(text: str, found: object, rng: np.random.Generator) -> list[str]:
    """Shares and difference quotients that leave the bounds of a formula."""
    pairs, faults = values_of(text, rng, 60), []
    sector, slope = found.sector, found.slope  # type: ignore[attr-defined]  # bounds of a formula
    small = 1e-12  # constants of the formula are doubles here
    for x, v in pairs:
        if sector is not None and not sector.lower - small <= v / x <= sector.upper + small:
            faults.append(f"phi({x})/sigma = {v / x} outside {sector}")
        with mpmath.workdps(50):
            y = x * (1 + mpmath.mpf("1e-9"))
            quotient = (_value(text, y) - v) / (y - x)
        if slope is not None and not slope.lower - small <= quotient <= slope.upper + small:
            faults.append(f"a difference quotient {quotient} at {x} outside {slope}")
    return faults[:2]


def regions(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """A region of attraction: solutions from its sets, close to their ends, stay and decay, those outside do not."""
    counts = Counter[str]()
    n = int(rng.integers(1, 4))
    discrete = bool(rng.integers(2))
    A, B, C = (np.round(rng.normal(size=shape), 2) for shape in ((n, n), (n, 1), (1, n)))
    if rng.random() < 0.6:
        values = np.linalg.eigvals(A)
        size = np.abs(values).max() / rng.uniform(0.3, 1)
        A = np.round(A / size if discrete else A - (values.real.max() + rng.uniform(0, 1)) * np.eye(n), 2)
    low, high = (str(v) for v in np.round(rng.uniform(0.5, 3, 2), 2))
    gain, linear, cubic = (str(round(v, 2) or 0.01) for v in (rng.uniform(0.5, 4), rng.uniform(-1, 3), rng.normal()))
    law: Saturation | Cubic = Cubic(linear=linear, cubic=cubic)
    if rng.random() < 0.6:
        law = Saturation(gain=gain, limit=high, lower_limit=f"-{low}")
    case = (A.tolist(), B.tolist(), C.tolist(), law, discrete)
    parts = tuple([[str(v) for v in row] for row in side.tolist()] for side in (A, B, C, np.zeros((1, 1))))
    try:
        found = region(as_plant(parts, dt=1 if discrete else None), law, seconds=SECONDS)
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return counts, [], case
    counts[str(found.verdict)] += 1
    shown = [one.proof for one in (*found.sets, *found.outside)]
    counts["certificates"] += len(shown)
    faults = [said for one in shown if (said := checked(one.certificate))]

    def moved(x: np.ndarray) -> np.ndarray:
        return np.asarray(x @ A.T - np.asarray(law((x @ C.T)[:, 0]))[:, None] @ B.T)

    def later(x: np.ndarray) -> np.ndarray:
        widest = np.abs(x @ C.T).max() * 2 + 1
        steep = np.abs(np.diff(law(np.linspace(-widest, widest, 99)))).max() * 49 / widest
        h = 0.02 / max(np.linalg.norm(A, 2) + steep * np.linalg.norm(B) * np.linalg.norm(C), 0.1)
        for _ in range(1500):
            if discrete:
                x = moved(x)
                continue
            k1 = moved(x)
            k2 = moved(x + h / 2 * k1)
            k3 = moved(x + h / 2 * k2)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + moved(x + h * k3))
        return x

    with np.errstate(all="ignore"):
        for one in found.sets:
            counts["attack: starts in a set"] += 1
            begin = starts_in(one, rng.normal(size=(60, n)))
            end = later(begin)
            stays = one.values(end) <= 1 + 1e-6 if one.bounded else np.abs(end) <= 100 * np.abs(begin).max()
            if not (np.isfinite(end).all() and stays.all()):
                faults.append(f"PROVED, and a solution leaves the set: {np.abs(end).max():.3g} from {begin.tolist()}")
        for other in found.outside:
            counts["attack: starts outside"] += 1
            begin = starts_outside(other, rng.normal(size=(60, n)))
            sizes = np.abs(later(begin)).max(axis=1) / np.abs(begin).max(axis=1)
            if (sizes < 1e-3).any():
                faults.append(f"said to be outside, and a solution decays: {sizes.min():.3g} from {begin.tolist()}")
    return counts, faults, case


def starts_in(one: AttractedSet, x: np.ndarray) -> np.ndarray:
    """Points near the end of a set in the directions of ``x``; anywhere, where all starts are attracted."""
    if one.interval is not None:
        low, high = (min(max(float(end), -1e3), 1e3) for end in one.interval)
        return np.asarray(0.999 * np.where(x > 0, high, low))
    if not one.bounded:
        return x * np.geomspace(0.1, 30, len(x))[:, None]
    small, large = np.zeros(len(x)), np.full(len(x), 1e-9)
    for _ in range(100):
        inside = one.values(large[:, None] * x) <= 1
        small, large = np.where(inside, large, small), np.where(inside, 2 * large, large)
        if not inside.any():
            break
    for _ in range(30):
        middle = (small + large) / 2
        inside = one.values(middle[:, None] * x) <= 1
        small, large = np.where(inside, middle, small), np.where(inside, large, middle)
    return np.asarray(0.999 * small[:, None] * x)


def starts_outside(one: OutsideSet, x: np.ndarray) -> np.ndarray:
    """Points just beyond the end of what is kept, in the directions of ``x`` that reach it."""
    if one.interval is not None:
        low, high = one.interval
        return np.asarray([[1.001 * float(end)] for end in (low, high) if abs(end) < math.inf])
    if one.Q is not None:
        values = np.einsum("ki,ij,kj->k", x, np.array(one.Q, dtype=float), x)
        return np.asarray(x[values > 0] * np.sqrt(1.001 / values[values > 0])[:, None])
    ends = [row[-2:] for row in one.points]  # of arcs; before each its control point
    return np.asarray(1.01 * np.array(ends, dtype=float))

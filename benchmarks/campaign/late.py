"""Rates of decay and gains of loops with dead time, attacked by a collocation of the method of steps."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from campaign.single import Counts, checked

from lure import AssumptionError, InputError, NonlinearityClass, Sector, SlopeBounds
from lure.analysis import decay_rate, l2_gain
from lure.analysis.questions.decay import RateBound
from lure.analysis.questions.gain import GainBound
from lure.analysis.verdict import Verdict

Reals = np.ndarray
SECONDS, NODES, WORDS = 20.0, 18, 40


@dataclass(frozen=True)
class Late:
    """``sum_j n_j(s) exp(-j h s) / d(s)``; coefficients from the constant one upwards, ``d`` monic."""

    numerators: dict[int, list[Fraction]]
    denominator: list[Fraction]
    step: Fraction

    def text(self) -> str:
        """The plant as a user writes it."""
        terms = [f"({polynomial(n)})*exp(-{j * self.step}*s)" for j, n in self.numerators.items()]
        return f"({' + '.join(terms)})/({polynomial(self.denominator)})"

    def at(self, s: Reals) -> Reals:
        """Its values."""
        above = sum(
            np.polyval([float(c) for c in reversed(n)], s) * np.exp(-j * float(self.step) * s)
            for j, n in self.numerators.items()
        )
        return np.asarray(above / np.polyval([float(c) for c in reversed(self.denominator)], s))

    def stepped(self, gain: float) -> Reals:
        """The map from the last segments of the state, newest first, at the nodes of each, to those one step later."""
        n, most = len(self.denominator) - 1, max(self.numerators)
        A = np.diag(np.ones(n - 1), 1)
        A[-1] = [-float(c) for c in self.denominator[:-1]]
        slope = chebyshev(NODES) * 2 / float(self.step)
        size = (NODES + 1) * n
        left = np.kron(slope, np.eye(n)) - np.kron(np.eye(NODES + 1), A)
        right = np.zeros((size, most * size))
        for j, numerator in self.numerators.items():
            row = np.zeros((n, n))
            row[-1, : len(numerator)] = [-gain * float(c) for c in numerator]
            if j == 0:
                left -= np.kron(np.eye(NODES + 1), row)
            else:
                right[:, (j - 1) * size : j * size] = np.kron(np.eye(NODES + 1), row)
        left[-n:], right[-n:] = 0, 0  # the last node, where the step begins, is the first of the segment before
        left[-n:, -n:], right[-n:, :n] = np.eye(n), np.eye(n)
        ahead = np.linalg.solve(left, right)
        return np.vstack([ahead, np.eye(most * size)[: (most - 1) * size]])


Case = tuple[Late, str, Fraction, Fraction]  # the plant, a kind of class, and its ends


def polynomial(coefficients: list[Fraction]) -> str:
    """As text, ``(1/2)*s^2 + (-3)*s``."""
    return " + ".join(f"({c})*s^{i}" for i, c in enumerate(coefficients))


def chebyshev(n: int) -> Reals:
    """The matrix that differentiates polynomials at Chebyshev's points, from 1 down to -1 (Trefethen 2000)."""
    x = np.cos(np.pi * np.arange(n + 1) / n)
    weight = np.where(np.isin(np.arange(n + 1), (0, n)), 2.0, 1.0) * (-1.0) ** np.arange(n + 1)
    matrix = np.outer(weight, 1 / weight) / (x[:, None] - x + np.eye(n + 1))
    return np.asarray(matrix - np.diag(matrix.sum(axis=1)))


def late_drawn(rng: np.random.Generator) -> Case:
    """A plant of order 1 to 3 with one dead time or two, a kind of class and its ends."""
    n = int(rng.integers(1, 4))
    poles: list[complex] = []
    while len(poles) < n:
        real = -float(np.round(10 ** rng.uniform(-1, 0.7), 2)) if rng.random() < 0.85 else 0.0
        if len(poles) + 2 <= n and rng.random() < 0.5:
            omega = float(np.round(10 ** rng.uniform(-0.5, 0.7), 2))
            poles += [complex(real or -0.05, omega), complex(real or -0.05, -omega)]
        else:
            poles.append(complex(real))
    denominator = [Fraction(round(1000 * c), 1000) for c in np.poly(poles).real[::-1]]
    late = [int(j) for j in rng.choice([1, 2, 3], size=int(rng.integers(1, 3)), replace=False)]
    late += [0] if rng.random() < 0.2 else []
    numerators = {
        j: [Fraction(round(100 * c), 100) for c in rng.normal(size=int(rng.integers(1, n + 1)))] for j in late
    }
    numerators = {j: c for j, c in numerators.items() if any(c)} or {1: [Fraction(1)]}
    numerators = numerators if max(numerators) else numerators | {1: [Fraction(1)]}
    top = Fraction(max(1, round(100 * 10 ** rng.uniform(-1.5, 0.7))), 100)
    low = Fraction(0) if rng.random() < 0.4 else top * Fraction(int(rng.integers(-4, 7)), 8)
    plant = Late(numerators, denominator, Fraction(int(rng.integers(1, 13)), 8))
    return plant, str(rng.choice(["varying", "sector", "slope"])), low, top


def class_of(kind: str, low: Fraction, top: Fraction) -> Sector | SlopeBounds | NonlinearityClass:
    """A class with these ends."""
    if kind == "varying":
        return NonlinearityClass(sector=Sector(low, top), time_varying=True)
    return Sector(low, top) if kind == "sector" else SlopeBounds(low, top)


def slowest(plant: Late, kind: str, low: Fraction, top: Fraction, rng: np.random.Generator) -> float:
    """The largest exponent of growth of constant gains and, of a class that varies, of gains that jump."""
    gains = [float(low), float(top), *rng.uniform(float(low), float(top), 4)]
    steps = [plant.stepped(gain) for gain in gains]
    words = [[i] for i in range(len(gains))]
    if kind == "varying":
        words += [list(rng.integers(0, 2, int(rng.integers(2, 9)))) for _ in range(WORDS)]
    most = -math.inf
    for word in words:
        whole = np.eye(len(steps[0]))
        for i in word:
            whole = steps[int(i)] @ whole
        radius = float(np.abs(np.linalg.eigvals(whole)).max())
        most = max(most, math.log(max(radius, 1e-300)) / (len(word) * float(plant.step)))
    return most


def asked(
    rng: np.random.Generator, ask: Callable[..., Any], attack: Callable[..., list[str]]
) -> tuple[Counts, list[str], object]:
    """A loop asked about, its certificates checked twice, and what is proved attacked."""
    counts: Counts = Counter()
    case = late_drawn(rng)
    plant, kind, low, top = case
    try:
        found = ask(plant.text(), class_of(kind, low, top), seconds=SECONDS)
    except (InputError, AssumptionError) as error:
        counts[f"refused: {type(error).__name__}"] += 1
        return counts, [], case
    counts[str(found.verdict)] += 1
    shown = [one for one in (found.proof, found.refutation) if one is not None]
    counts["certificates"] += len(shown)
    faults = [said for one in shown if (said := checked(one.certificate))]
    if found.verdict is Verdict.PROVED:
        counts[f"attack: {attack.__name__}"] += 1
        faults += attack(found, case, rng)
    return counts, faults, case


def late_rate(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """The rate with dead time, from above by constant gains and by gains that jump."""
    return asked(rng, decay_rate, growth)


def late_gain(_kind: str, rng: np.random.Generator) -> tuple[Counts, list[str], object]:
    """The L2 gain from the input to the output of the plant, from below by constant gains, and what grows."""
    return asked(rng, l2_gain, response)


def growth(found: RateBound, case: Case, rng: np.random.Generator) -> list[str]:
    """Whether a solution decays more slowly than the rate."""
    most = slowest(*case, rng)
    slow = most > -found.rate.low + 1e-6 * (1 + found.rate.low)
    return [f"an exponent of {most!r} against {-found.rate.low!r}"] * slow


def response(found: GainBound, case: Case, rng: np.random.Generator) -> list[str]:
    """Whether a constant gain lets more through at some frequency, or a solution grows where the gain is finite."""
    plant, _, low, top = case
    if found.gain.high == math.inf:
        return []
    values = plant.at(1j * np.concatenate([np.geomspace(1e-4, 1e3, 4000), np.linspace(0.01, 20, 4000)]))
    constant = np.concatenate([[float(low), float(top)], rng.uniform(float(low), float(top), 30)])[:, None]
    worst, most = float(np.abs(values / (1 + constant * values)).max()), slowest(*case, rng)
    faults = [f"a gain of {worst!r} against {found.gain.high!r}"] * (worst > found.gain.high * (1 + 1e-9))
    return faults + [f"a finite gain, and solutions with the exponent {most!r}"] * (most > 1e-6)

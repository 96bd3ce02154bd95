"""Counterexamples replayed: the member belongs to the class that was asked about, and its solution does not decay."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np
from campaign.draws import Drawn
from campaign.exact import Piecewise, Rational, contains_gain, floats, plus, where
from scipy.linalg import expm

SLACK, POINTS = 1e-6, 40


def replayed(case: Drawn, proof: Mapping[str, Any]) -> str:
    """What is wrong with a counterexample; empty if it shows what it should, and "-" if it is not replayed."""
    method = proof["method"]
    if method in ("linear-gain", "matrix-gain"):
        return linear(case, Fraction(proof["gain"]))
    if method == "crossing":
        return crossing(case, [Fraction(v) for v in proof["gains"]], [Fraction(v) for v in proof["frequencies"]])
    if method == "switched-gain":
        return "-" if case.plant.delay else switched(case, proof)
    if method in ("orbit", "flow-orbit"):
        graph = Piecewise(
            tuple((Fraction(x), Fraction(y)) for x, y in proof["points"]),
            Fraction(proof["left"]),
            Fraction(proof["right"]),
        )
        if not graph.belongs(case.one):
            return f"{graph} is no member"
        if method == "orbit":
            return orbit(case.plant, graph, *([Fraction(v) for v in proof[side]] for side in ("u", "sigma")))
        return flow_orbit(case.plant, graph, proof)
    return "-"


def linear(case: Drawn, g: Fraction) -> str:
    """A constant gain: a root that is not strictly inside."""
    plant = case.plant
    if not contains_gain(case.one, g):
        return f"the gain {g} is no member"
    if plant.delay:
        low, high = plant.d[-1] + g * plant.n[-1], 1 + g * plant.through  # of d + g n e^(-s T) at 0, of 1 + g H at inf
        return "" if low * plant.d[0] <= 0 or high <= 0 else f"the gain {g} with a dead time"
    if 1 + g * plant.through == 0:
        return ""
    return f"the gain {g} is stable" if where(plus(plant.d, plant.n, g), discrete=plant.discrete) == "stable" else ""


def crossing(case: Drawn, gains: list[Fraction], frequencies: list[Fraction]) -> str:
    """A dead time: between the frequencies ``H(i w)`` is real where ``-1/H`` is a gain of the class."""
    plant = case.plant
    if not all(contains_gain(case.one, g) for g in gains):
        return f"the gains {gains} are no members"
    w = np.linspace(*(float(v) for v in frequencies), POINTS)
    n, d = (np.polyval(np.array([float(v) for v in side]), 1j * w) for side in (plant.n, plant.d))
    inverse = -d / n * np.exp(1j * w * float(plant.delay))
    near = np.abs(inverse - (inverse.real).clip(*(float(v) for v in gains)))
    return "" if near.min() < 1e-3 * np.abs(inverse).max() else f"no crossing: {near.min():.3g}"


def switched(case: Drawn, proof: Mapping[str, Any]) -> str:
    """Gains that jump: the matrix of a period has an eigenvalue outside the unit disc."""
    plant, gains = case.plant, [Fraction(g) for g in proof["gains"]]
    if not all(contains_gain(case.one, g) for g in gains) or case.one.linear or not case.one.time_varying:
        return f"the gains {gains} are no members"
    scaled, unit = scaled_time(plant)
    A, b, c, _ = floats(scaled.matrices())
    whole = np.eye(len(A))
    for g, time in zip(gains, proof.get("times", ["1"] * len(gains)), strict=True):
        closed = A - float(g / (1 + g * plant.through)) * np.outer(b, c)
        whole = (closed if plant.discrete else expm(closed * float(Fraction(time) * unit))) @ whole
    radius = float(np.abs(np.linalg.eigvals(whole)).max())
    return "" if radius > 1 - SLACK else f"the multiplier of a period is {radius!r}"


def scaled_time(plant: Rational) -> tuple[Rational, Fraction]:
    """The plant with poles about 1, and how many of its units of time one is."""
    if plant.discrete:
        return plant, Fraction(1)
    poles = np.abs(np.roots([float(v) for v in plant.d]))
    unit = Fraction(2.0 ** round(float(np.log2(poles[poles > 0]).mean()))) if (poles > 0).any() else Fraction(1)
    return plant.scaled(unit, Fraction(1)), unit


def orbit(plant: Rational, graph: Piecewise, u: list[Fraction], sigma: list[Fraction]) -> str:
    """A periodic solution in discrete time, exactly: ``d(q) sigma = n(q) u``, ``u = -phi(sigma)``."""
    period = len(u)
    if any(-graph.at(s) != v for s, v in zip(sigma, u, strict=True)):
        return "u is not -phi(sigma)"
    if not any(sigma) and not any(u):
        return "the orbit rests at 0"
    for t in range(period):
        left = sum(v * sigma[(t + len(plant.d) - 1 - i) % period] for i, v in enumerate(plant.d))
        right = sum(v * u[(t + len(plant.n) - 1 - i) % period] for i, v in enumerate(plant.n))
        if left != right:
            return f"no solution at sample {t}"
    return ""


def flow_orbit(plant: Rational, graph: Piecewise, proof: Mapping[str, Any]) -> str:
    """A periodic solution in continuous time: the state comes back, and ``sigma`` keeps to the pieces."""
    A, b, c, d = floats(plant.matrices())
    state = np.array([float(Fraction(v)) for v in proof["state"]])
    if len(state) != len(A):
        return "-"
    pieces, x, far = list(graph.pieces()), state, 0.0
    knots = [-math.inf, *(float(v) for v, _ in graph.points or ((Fraction(0), Fraction(0)),)), math.inf]
    wide = max((abs(k) for k in knots[1:-1]), default=0.0)
    for piece, duration in zip(proof["pieces"], proof["durations"], strict=True):
        slope, offset = (float(v) for v in pieces[piece])
        share = 1 / (1 + slope * float(d))
        field = np.zeros((len(A) + 1,) * 2)
        field[:-1, :-1], field[:-1, -1] = A - slope * share * np.outer(b, c), -b * offset * share
        one = expm(field * float(Fraction(duration)) / POINTS)
        for _ in range(POINTS):
            x = (one @ [*x, 1.0])[:-1]
            sigma = float(c @ x - float(d) * offset) * share
            wide = max(wide, abs(sigma))
            far = max(far, knots[piece] - sigma, sigma - knots[piece + 1])
    back = -x if proof["half"] else x
    if np.abs(back - state).max() > SLACK * np.abs(state).max() or far > SLACK * wide:
        return f"the state misses its start by {np.abs(back - state).max():.3g}, sigma its piece by {far:.3g}"
    moved = np.abs(np.linalg.norm(A @ state)) + np.abs(state).max()
    return "" if moved > 0 else "the orbit rests"

"""Delays known by their bound, and play and stop: the loop in place of theirs, and the delays that destabilise."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from lure.analysis.certificates import channels, memory
from lure.analysis.certificates.arithmetic import Rejected
from lure.analysis.certificates.channels import Plant, undelayed
from lure.analysis.certificates.systems import class_entries, texts
from lure.analysis.deadline import checkpoint
from lure.analysis.numerics.doubles import double_above
from lure.analysis.questions.channel_problem import channel_plant, loop_plant
from lure.analysis.questions.problem import Problem
from lure.arrays import NDArray, np, optimize
from lure.classes import DELAYS, FULL_BLOCK, SCALAR, Diagonal, NonlinearityClass, Sector
from lure.errors import AssumptionError, Reason
from lure.plants.delay_matrix import DelayMatrix
from lure.plants.multivariable import MultivariablePlant

_FACTORS = tuple(10 ** (k / 10) for k in range(-30, 31))
_MOST_BLOCKS, _HALVINGS, _MOST_SAMPLES, _OUTSIDE = 4, 50, 50, 1e-9
_GRID, _OCTAVES = 400, 64
_WIDTHS, _ON_AXIS = (1e-12, 1e-11, 1e-10, 1e-8, 1e-6), 1e-6


def delays_of(asked: Problem) -> list[int]:
    """The channels with a delay known by its bound."""
    return [i for i, one in enumerate(asked.classes.classes) if one.operator in DELAYS]


def wide_channels(asked: Problem) -> list[int]:
    """The channels of functions of several channels, in a full-block sector."""
    return [i for i, one in enumerate(asked.classes.classes) if one.operator == FULL_BLOCK]


def increments(asked: Problem) -> Problem:
    """Beside play and stop the question about the loop of ``x'`` less ``B_w w``, with sectors.

    Raises
    ------
    AssumptionError
        The theorem on play and stop is not for these classes.
    """
    if not any(one.memory for one in asked.classes.classes):
        return asked
    try:
        (A, B, C, D, *_), known = memory.increments(*stated(asked))
    except Rejected as error:
        raise AssumptionError(f"not covered by the theorem: {error}", code=Reason.NOT_APPLICABLE) from None
    classes = list(asked.classes.classes)
    for i in known.functions:
        moving = known.families[i].varying
        classes[i] = NonlinearityClass(sector=Sector(*known.bounds(i)), time_varying=moving)
    plant = MultivariablePlant(_rows(A), _rows(B), _rows(C), _rows(D), dt=channel_plant(asked.plant).dt)
    sizes = tuple(len(block) for block in known.blocks)
    return replace(asked, plant=plant, classes=Diagonal(tuple(classes), repeated=sizes))


def sectors_beside_memory(asked: Problem) -> Problem | None:
    """The question with sectors in place of slope bounds; None unless play and stop leave ``sigma = 0`` at rest there.

    Such functions then keep their sector, where Popov's terms are possible, in the loop of :func:`increments`.
    """
    classes = asked.classes
    if not any(one.memory for one in classes.classes):
        return None
    sloped = [one.slope is not None and not (one.memory or one.rectifier) for one in classes.classes]
    wider = tuple(
        NonlinearityClass(sector=Sector(*one.gains), time_varying=one.time_varying) if wide else one
        for one, wide in zip(classes.classes, sloped, strict=True)
    )
    found = replace(asked, classes=Diagonal(wider, repeated=classes.repeated))
    try:
        increments(found)
    except AssumptionError:
        return None
    return found if any(sloped) else None


def stated(asked: Problem) -> tuple[Plant, channels.Channels]:
    """The plant and the classes as the checker has them."""
    whole = asked.plant
    H, late, inner, rates = (
        (whole.base, whole.late, whole.inner, whole.rates)
        if isinstance(whole, DelayMatrix)
        else (channel_plant(whole), (), (), ())
    )
    A, B, C, D = ([list(row) for row in side] for side in (H.A, H.B, H.C, H.D))
    arriving = tuple((delay, [list(row) for row in rows]) for delay, rows in late)
    back = tuple([list(row) for row in rows] for rows in inner)
    moved = tuple(([list(row) for row in D_T], [list(row) for row in E]) for D_T, E in rates)
    return Plant(A, B, C, D, H.dt is not None, arriving, back, moved), channels.channels(
        class_entries(asked.classes), len(D)
    )


def without_delays(asked: Problem) -> Problem:
    """The question about norm-bounded operators, or sectors: its answer holds for delays, play, stop and full blocks.

    Raises
    ------
    AssumptionError
        The theorem on delays is not for this plant.
    """
    asked, own = increments(asked), [*delays_of(asked), *wide_channels(asked)]
    if not own:
        return asked
    try:
        found, known = undelayed(*stated(asked))
    except Rejected as error:
        raise AssumptionError(f"not covered by the theorem: {error}", code=Reason.NOT_APPLICABLE) from None
    classes = list(asked.classes.classes)
    for i in own:
        kind = "any" if known.families[i].varying else SCALAR
        classes[i] = NonlinearityClass.norm_bounded(known.bounds(i)[1], dynamics=kind)
    A, B, C, D = found[:4]
    plant = MultivariablePlant(_rows(A), _rows(B), _rows(C), _rows(D), dt=channel_plant(asked.plant).dt)
    return replace(asked, plant=plant, classes=replace(asked.classes, classes=tuple(classes)))


def _rows(side: list[list[Fraction]]) -> tuple[tuple[Fraction, ...], ...]:
    return tuple(map(tuple, side))


class _Crossing(NamedTuple):
    """Gains of the other channels, and a delay with a root ``i omega``."""

    gains: list[Fraction]
    channel: int
    delay: float
    omega: float


def delays_refuting(asked: Problem, most: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
    """Factors, and proofs that a constant delay in one channel destabilises, the smallest factor first.

    ``most``: the largest factor of interest.
    """
    if loop_plant(asked.plant).dt is not None:
        yield from _late(asked, most)
        return
    found = list[tuple[float, _Crossing]]()
    alone = [block[0] for block in asked.classes.blocks if len(block) == 1]
    blocks = [block for block in asked.classes.blocks if block not in asked.classes.operators]
    shapes = list(product((0, 1), repeat=len(blocks))) if len(blocks) <= _MOST_BLOCKS else [(0,), (1,)]
    for i in (i for i in delays_of(asked) if i in alone):
        for shape in shapes:
            checkpoint()
            taken = dict(zip(blocks, shape * (len(blocks) if len(blocks) > _MOST_BLOCKS else 1), strict=False))
            first = _first(asked, i, taken, min(most, _FACTORS[-1]))
            if first is not None:
                found.append(first)
    for factor, one in sorted(found, key=lambda each: each[0]):
        bound = float(asked.classes.upper[one.channel])
        for width in _WIDTHS:
            wide = 1e3 * width * (one.delay + 1 / one.omega)
            ends = Fraction(max(one.delay - wide, 0.0)), Fraction(one.delay + wide)
            alpha = Fraction(double_above(max(Fraction(factor), Fraction(double_above(ends[1] / Fraction(bound))))))
            proof: dict[str, Any] = {
                "method": "delayed-gains",
                "gains": texts(one.gains),
                "channel": one.channel + 1,
                "delays": texts(ends),
                "frequencies": texts([Fraction(one.omega * (1 - width)), Fraction(one.omega * (1 + width))]),
            }
            if alpha <= most:
                yield (alpha if math.isinf(most) else Fraction(most)), proof


def _late(asked: Problem, most: float) -> Iterator[tuple[Fraction, dict[str, Any]]]:
    """The same in discrete time: the fewest samples that destabilise, the gains at one end or the other."""
    A, B, C, D = channel_plant(asked.plant).doubles()
    classes, n, found = asked.classes, len(A), list[tuple[Fraction, dict[str, Any]]]()
    blocks = [block for block in classes.blocks if block not in classes.operators]
    shapes = list(product((0, 1), repeat=len(blocks))) if len(blocks) <= _MOST_BLOCKS else []
    for i in (i for i in delays_of(asked) if range(i, i + 1) in classes.blocks):
        for shape, k in product(shapes, range(1, _MOST_SAMPLES + 1)):
            checkpoint()
            alpha, gains = Fraction(k) / Fraction(classes.upper[i]), list(classes.lower)
            if alpha > most or any(alpha >= factor for factor, _ in found):
                continue
            for block, end in zip(blocks, shape, strict=True):
                for j in block:
                    gains[j] = classes.upper[j] * (alpha if classes.performance is None else 1) if end else gains[j]
            whole = np.zeros((n + k, n + k))
            G, row, late = np.diag([float(g) for g in gains]), np.eye(len(D))[i], np.eye(len(D))
            late[i, i] = 0
            inner = np.linalg.inv(np.eye(len(D)) + late @ D @ G)  # sigma = late (C x - D G sigma) + e_i q_k
            seen = np.zeros((len(D), n + k))
            seen[:, :n] = late @ C
            seen[:, -1] += row
            seen = inner @ seen
            whole[:n] = np.hstack([A, np.zeros((n, k))]) - B @ G @ seen
            whole[n] = np.append(C[i], np.zeros(k)) - D[i] @ G @ seen
            whole[range(n + 1, n + k), range(n, n + k - 1)] = 1
            if np.abs(np.linalg.eigvals(whole)).max() > 1 + _OUTSIDE:
                proof = {"method": "delayed-gains", "gains": texts(gains), "channel": i + 1, "samples": k}
                found.append((Fraction(double_above(alpha)), proof))
    for alpha, proof in sorted(found, key=lambda one: one[0]):
        yield (alpha if math.isinf(most) else Fraction(most)), proof


def _first(asked: Problem, i: int, taken: dict[range, int], top: float) -> tuple[float, _Crossing] | None:
    """The smallest factor at which a delay in one channel destabilises, beside gains at one end or the other."""
    lower, upper, bound = asked.classes.lower, asked.classes.upper, float(asked.classes.upper[i])
    moving = any(taken.values()) and asked.classes.performance is None

    def crossing(factor: float) -> _Crossing | None:
        """The least delay, if it is of the class."""
        gains = list(lower)
        for block, end in taken.items():
            for j in block:
                gains[j] = upper[j] * Fraction(factor if moving else 1) if end else lower[j]
        if any(gains[j] < low for j, low in enumerate(lower)):
            return None
        found = _least_delay(asked, gains, i)
        if found is None or found[0] > factor * bound * (1 + 1e-9):
            return None
        return _Crossing(gains, i, *found)

    if not moving:
        at = crossing(top)
        return None if at is None else (at.delay / bound, at)
    before = 0.0
    for factor in [*(f for f in _FACTORS if f < top), top]:
        one = crossing(factor)
        if one is not None:
            for _ in range(_HALVINGS if before else 0):
                middle = (before + factor) / 2
                inner = crossing(middle)
                before, factor, one = (before, middle, inner) if inner is not None else (middle, factor, one)
            return factor, one
        before = factor
    return None


def _least_delay(asked: Problem, gains: list[Fraction], i: int) -> tuple[float, float] | None:
    """The least delay of channel ``i`` with a root ``i omega``, and ``omega``, the other channels having gains."""
    rest = np.array([0.0 if j == i else float(g) for j, g in enumerate(gains)])
    if isinstance(asked.plant, DelayMatrix):
        return _least_of_late(asked.plant, rest, i)
    A, B, C, D = channel_plant(asked.plant).doubles()
    whole = np.linalg.solve(np.eye(len(D)) + D * rest, np.hstack([C, D]))
    inner, out = A - (B * rest) @ whole[:, : len(A)], whole[i : i + 1, : len(A)]
    into = B[:, i : i + 1] - (B * rest) @ whole[:, len(A) + i : len(A) + i + 1]
    values = np.linalg.eigvals(np.block([[inner, into @ into.T], [-out.T @ out, -inner.T]])).astype(complex)
    size = max(float(np.abs(values).max()), 1e-300)
    on_axis = np.abs(values.real) < _ON_AXIS * size
    omega: NDArray[np.float64] = values.imag[on_axis & (values.imag > _ON_AXIS * size)]
    found = list[tuple[float, float]]()
    for one in omega.tolist():
        response = complex((out @ np.linalg.solve(1j * one * np.eye(len(A)) - inner, into.astype(complex)))[0, 0])
        found.append((((math.pi + math.atan2(response.imag, response.real)) % (2 * math.pi)) / one, one))
    return min(found, default=None)


def _least_of_late(plant: DelayMatrix, rest: NDArray[np.float64], i: int) -> tuple[float, float] | None:
    """The same beside known dead times: where ``|h| - 1`` changes its sign between frequencies of a grid."""
    poles, longest = np.abs(np.linalg.eigvals(plant.base.doubles()[0])), float(plant.late[-1][0])
    scales = [*poles[poles > 0], 1 / longest]
    points = np.union1d(
        np.geomspace(min(scales) / _OCTAVES, max(scales) * _OCTAVES, _GRID), np.linspace(0, 40 / longest, _GRID)[1:]
    )

    def response(omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """``h``, the other channels being closed."""
        H = plant.transfer(1j * omega)
        return np.asarray((H @ np.linalg.inv(np.eye(len(rest)) + rest[:, None] * H))[:, i, i])

    sizes, found = np.abs(response(points)) - 1, list[tuple[float, float]]()
    for k in np.flatnonzero(sizes[:-1] * sizes[1:] < 0):

        def size(one: float) -> float:
            """How far the modulus of the response lies above 1."""
            return float(np.abs(response(np.array([one])))[0] - 1)

        one = float(optimize.brentq(size, points[k], points[k + 1], xtol=1e-15 * points[k], rtol=1e-15))
        found.append((((math.pi + float(np.angle(response(np.array([one]))[0]))) % (2 * math.pi)) / one, one))
    return min(found, default=None)

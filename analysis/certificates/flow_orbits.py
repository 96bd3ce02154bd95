"""Proofs for certificates that a loop with a piecewise-linear law oscillates, from the record of an orbit."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise
from typing import Any, cast

from flint import arb, arb_mat

from analysis.certificates.arithmetic import Rejected
from analysis.certificates.blocks import realised
from analysis.certificates.states import classes, flow_orbit
from analysis.certificates.systems import text, texts
from analysis.polynomial import exact_midpoint
from analysis.precision import ball, working_precision
from analysis.refutation.piecewise import PiecewiseLoop
from analysis.refutation.realisation import Realisation, balls
from analysis.refutation.validated import Itinerary, refined
from lure.errors import AssumptionError
from lure.laws.graph import Graph

LADDER = (256, 512, 1024, 2048, 4096)
SHARES = (Fraction(5, 8), Fraction(1, 2), Fraction(3, 8))
POLISHING = 12
INVERSE_BITS = 48


def flow_orbit_proof(
    system: Mapping[str, Any], laws: Mapping[str, Any], record: Mapping[str, object]
) -> dict[str, Any]:
    r"""The proof by ``flow-orbit`` for the record of a periodic orbit in continuous time.

    The record holds doubles.  Newton's method refines first state and durations to as many bits as the checker's balls
    have; the approximate inverse of the Jacobian is rounded; the radius is a power of two well above what the refined
    orbit misses by and far below where the Jacobian has changed.  More bits and other radii are tried until the
    checker's own test passes.

    Parameters
    ----------
    system, laws : Mapping
        As in the certificate.
    record : Mapping
        ``Witness.data`` of an orbit in continuous time: ``points``, ``left_slope``, ``right_slope``, ``pieces``,
        ``durations`` [s], ``state`` (in the coordinates of the checker's realisation) and ``half``.

    Returns
    -------
    dict
        ``proof`` of the certificate.

    Raises
    ------
    Rejected
        The checker's test passes at no number of bits; its last reason.
    AssumptionError
        Newton's method does not converge from the record.
    """
    A, b, c, d, _ = realised(system, Fraction(0))
    points = [(Fraction(x), Fraction(w)) for x, w in cast("list[list[str]]", record["points"])]
    left, right = (Fraction(cast("str", record[side])) for side in ("left_slope", "right_slope"))
    graph = Graph.through(points, left, right)
    linear = Realisation(tuple(tuple(row) for row in A), tuple(b), tuple(c), d)
    loop = PiecewiseLoop.of(linear, graph)
    orbit = refined(loop, _itinerary(record))
    if orbit is None:
        raise AssumptionError("Newton's method does not lead from the record to a periodic orbit; search for it anew")
    law = {
        "method": "flow-orbit",
        "points": [texts(point) for point in zip(graph.knots, graph.values, strict=True)],
        "left": text(left),
        "right": text(right),
        "pieces": list(orbit.pieces),
    }
    last = Rejected("no number of bits was tried")
    for bits in LADDER:
        numbers = _numbers(loop, orbit, bits)
        for share in SHARES:
            proof = {**law, **numbers, "radius": text(Fraction(1, 2 ** int(bits * share))), "bits": bits}
            try:
                flow_orbit((A, b, c, d), classes(laws), proof)
            except Rejected as refusal:
                last = refusal
            else:
                return proof
    raise last


def _itinerary(record: Mapping[str, object]) -> Itinerary:
    durations, state = (tuple(map(Fraction, cast("list[float]", record[name]))) for name in ("durations", "state"))
    pieces = tuple(cast("list[int]", record["pieces"]))
    return Itinerary(pieces=pieces, durations=durations, state=state, half=bool(record["half"]))


def _numbers(loop: PiecewiseLoop, orbit: Itinerary, bits: int) -> dict[str, Any]:
    """State and durations to so many bits after the point, and the inverse of the Jacobian there."""
    n = loop.system.order
    with working_precision(2 * bits):
        unknowns = [ball(v) for v in (*orbit.state, *orbit.durations)]
        for _ in range(POLISHING):
            shot = _shot(loop, orbit, unknowns)
            m = len(unknowns)
            misses, jacobian = (
                arb_mat([[shot[i, j] for j in columns] for i in range(m)]).mid() for columns in ([0], range(1, m + 1))
            )
            inverse = jacobian.inv().mid()
            step = inverse * misses
            unknowns = [(u - step[i, 0]).mid() for i, u in enumerate(unknowns)]
            if max(abs(step[i, 0]) for i in range(m)) < arb(2) ** -(bits + 8):
                break
        size = max(sum((abs(jacobian[i, j]) for j in range(m)), arb(0)) for i in range(m))
        digits = max(0, INVERSE_BITS + round(float(size)).bit_length())
        exact = [_rounded(exact_midpoint(u), bits) for u in unknowns]
        rows = [[text(_rounded(exact_midpoint(inverse[i, j]), digits)) for j in range(m)] for i in range(m)]
    return {"durations": texts(exact[n:]), "state": texts(exact[:n]), "half": orbit.half, "inverse": rows}


def _rounded(value: Fraction, bits: int) -> Fraction:
    """The nearest multiple of ``2^-bits``."""
    return Fraction(round(value * 2**bits), 2**bits)


def _shot(loop: PiecewiseLoop, orbit: Itinerary, unknowns: list[arb]) -> arb_mat:
    """``[F, F']`` at first state and durations: what closure and levels miss, and the derivative."""
    n, sign = loop.system.order, -1 if orbit.half else 1
    path = [*orbit.pieces, loop.mirrored(orbit.pieces[0]) if orbit.half else orbit.pieces[0]]
    exits = [loop.levels[min(p, q)] for p, q in pairwise(path)]
    m = len(unknowns)
    start = [*unknowns[:n], arb(1)]
    first = arb_mat([[x, *(arb(int(i == j < n)) for j in range(m))] for i, x in enumerate(start)])
    Z, rows = first, []
    for i, (piece, level) in enumerate(zip(orbit.pieces, [sign * exits[-1], *exits], strict=False)):
        G, t = balls(loop.generators[piece]), unknowns[n + i]
        row = balls([[*loop.system.c, -level]]) * Z
        rows.append([row[0, j] for j in range(m + 1)])
        Z = (G * t).exp() * Z
        push = G * Z
        for j in range(n):
            Z[j, n + 1 + i] += push[j, 0]
    closing = [[Z[i, j] - sign * first[i, j] for j in range(m + 1)] for i in range(n)]
    return arb_mat(closing + rows)

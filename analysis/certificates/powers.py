"""Lyapunov functions of higher degree, for a gain that varies in an interval; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations_with_replacement
from math import comb
from typing import Any

from . import states
from .arithmetic import INF, fields, integer, need, posed
from .balls import positive_definite
from .blocks import realised

MOST_MONOMIALS, MOST_POWER = 100, 20
Monomial = tuple[int, ...]


def monomials(order: int, power: int) -> list[Monomial]:
    """The exponents of the products of ``power`` out of so many states, the powers of the first one first."""
    return [
        tuple(chosen.count(i) for i in range(order)) for chosen in combinations_with_replacement(range(order), power)
    ]


def lifted(A: Any, m: list[Monomial]) -> list[list[Fraction]]:
    """The matrix ``L`` with ``m(x)' = L m(x)`` along ``x' = A x``: ``x_i`` in a product gives way to ``A_ij x_j``."""
    place, L = {e: i for i, e in enumerate(m)}, [[Fraction(0)] * len(m) for _ in m]
    for row, e in zip(L, m):
        for i, line in enumerate(A):
            for j, v in enumerate(line):
                if e[i] and v:
                    row[place[tuple(n - (h == i) + (h == j) for h, n in enumerate(e))]] += e[i] * v
    return L


def substituted(A: Any, m: list[Monomial]) -> list[list[Fraction]]:
    """The matrix ``M`` with ``m(A x) = M m(x)``: the products of the rows of ``A x``."""
    place, M = {e: i for i, e in enumerate(m)}, list[list[Fraction]]()
    for e in m:
        total = {(0,) * len(e): Fraction(1)}
        for i in [i for i, n in enumerate(e) for _ in range(n)]:
            longer = dict[Monomial, Fraction]()
            for f, c in total.items():
                for j, v in enumerate(A[i]):
                    if v:
                        g = tuple(n + (h == j) for h, n in enumerate(f))
                        longer[g] = longer.get(g, 0) + c * v
            total = longer
        row = [Fraction(0)] * len(m)
        for f, c in total.items():
            row[place[f]] = c
        M.append(row)
    return M


def vanishes(Z: list[list[int]], m: list[Monomial]) -> bool:
    """Whether ``m' Z m = 0`` for every ``x``, of a symmetric matrix: equal products of two monomials add up to 0."""
    total = dict[Monomial, int]()
    for e, row in zip(m, Z):
        for f, v in zip(m, row):
            product = tuple(a + b for a, b in zip(e, f))
            total[product] = total.get(product, 0) + v
    return not any(total.values())


def require_falling(ends: Any, proof: Any, *, discrete: bool) -> tuple[int, bool]:
    """The order of ``P``, once ``V = m'P m`` is found to fall along ``x' = A x`` for both matrices ``ends``.

    ``m`` are the products of ``power`` states, ``P > 0``, and ``V' = -m'G m``, ``G = Z - (L'P + P L) > 0``, with one
    ``Z``, ``m'Z m = 0``, for each end; in discrete time ``G = Z + P - M'P M``.  And whether, in continuous time, with
    the lower gain ``x_1`` has no influence: there ``G`` may be without the power of ``x_1``, so that ``V`` does not
    grow, and falls where another state is not 0.
    """
    _, power, given, *differences = fields(proof, "method", "power", "P", "lower", "upper")
    n, p = len(ends[0]), integer(power, 1, MOST_POWER)
    need(n > 0 and (count := comb(n + p - 1, p)) <= MOST_MONOMIALS, f"P is of no order from 1 to {MOST_MONOMIALS}")
    m, critical = monomials(n, p), not (discrete or any(row[0] for row in ends[0]))
    change = substituted if discrete else lifted
    for which, end, difference in zip(("lower", "upper"), ends, differences):
        P, a, Lt = states.symmetric(given, [*zip(*change(end, m))], count)
        Z, *_ = states.symmetric(difference, [], count)
        need(vanishes(Z, m), f"the form of the {which} end does not vanish on the monomials")
        falls = states.falling(P, Lt, a, discrete)[1]
        G = [[v + a ** (1 + discrete) * z for v, z in zip(row, line)] for row, line in zip(falls, Z)]
        if critical and which == "lower":
            need(not any(row[0] for row in G), "the power of x_1 is no direction of rest")
            G = [row[1:] for row in G[1:]]
        need(positive_definite(G), f"that V falls with the gain at the {which} end fails, or is undecided")
    need(positive_definite([row[: i + 1] for i, row in enumerate(P)]), "P > 0 fails, or is undecided")
    return count, critical


def facts(name: str, data: Any, system: Any, family: states.Family, proof: Any) -> tuple[bool, dict[str, str]]:
    """``V = m'P m`` falls with the gains at both ends of the sector, and so with all between them; whether critical.

    The gain ``g`` makes ``A - b c g/(1 + g d)``, a point between the matrices of both ends.  In discrete time ``V``
    need not fall between them, but products of both decay, and so do those of what lies between.
    """
    need(
        name == "homogeneous-lyapunov" and fields(data) == [], "this is no proof of the theorem, or it has a multiplier"
    )
    l, k = family.sector
    need(INF not in (abs(l), abs(k)), "the bounds of the sector are not finite")
    need(system["kind"] != "rod-scheme", "the rod has proofs of its own")
    A, b, c, d, discrete = realised(system, l)
    posed(1 + (k - l) * d > 0, "1 + g H(inf) vanishes for a gain g of the class")
    ends = [A, states.gained(A, b, [(k - l) / (1 + (k - l) * d) * v for v in c])]
    count, critical = require_falling(ends, proof, discrete=discrete)
    falls = (
        "V(x+) < V(x) for x != 0"
        if discrete
        else "V' <= 0, and V' < 0 where a state beside x_1 is not 0,"
        if critical
        else "V' < 0 for x != 0"
    )
    between = "" if discrete else " and all between"
    return critical, {
        "stable": f"V = m^T P m, P > 0, m the {count} monomials of degree {proof['power']} in the state",
        "inequality": f"{falls} with the gains {l}, {k}{between}; Gram matrices of order {count}",
        "well-posed": f"1 + g H(inf) does not vanish in the class, H(inf) = {d} after the shift",
    }

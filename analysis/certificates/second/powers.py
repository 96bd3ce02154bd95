"""Lyapunov functions of higher degree: polynomials, differentiated along both extreme loops, and Gram matrices."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import comb

from flint import arb_mat, fmpq, fmpq_mat

from lure.analysis.certificates.second.classes import Claim
from lure.analysis.certificates.second.matrix import BITS, positive_definite, triangle
from lure.analysis.certificates.second.numerics import to_fmpq, working_precision
from lure.analysis.certificates.second.reading import NotShown, count, record, require, tick
from lure.analysis.certificates.second.systems import Case, Rational, Row

LARGEST_GRAM = 100
Powers = tuple[int, ...]
Polynomial = dict[Powers, fmpq]


def require_powers(system: Rational, claim: Claim, proof: object) -> Case:
    """Check that one form of even degree is positive and falls along the loops with both ends of the sector as gains.

    Whether they are stable, or critical: with the lower gain the first state may have no influence, and the form does
    not grow, and falls where another state is not 0.

    Parameters
    ----------
    system : Rational
        The block; in discrete time products of both loops decay, and so do those of what lies between.
    claim : Claim
        The class, between finite gains.
    proof : object
        The half of the degree, ``P`` and for each end a form that vanishes on the monomials, in integers.

    Raises
    ------
    NotShown
        A matrix is not shown to be positive definite, or a Gram matrix is not one of the derivative.
    """
    found = record(proof, "method", "power", "P", "lower", "upper")
    require(found["method"] == "powers", "the method does not fit the theorem")
    if claim.width is None:
        raise NotShown("the class needs an upper bound")
    half, n = count(found["power"], least=1), system.states.order
    require(n > 0 and n <= LARGEST_GRAM and half <= LARGEST_GRAM, "the degree or the order is out of range")
    size = comb(n + half - 1, half)
    require(size <= LARGEST_GRAM, "there are too many monomials")
    basis = _basis(n, half)
    P = _symmetric(found["P"], size)
    _require_definite(P, "P")
    V = _polynomial(P, basis)
    case: Case = "stable"
    for name, gain in (("lower", claim.lower), ("upper", claim.lower + claim.width)):
        A, move = system.states.closed(gain), _moved if system.discrete else _along
        rate = fmpq_mat([[move({e: fmpq(1)}, A).get(f, fmpq(0)) for f in basis] for e in basis])
        less = P - rate.transpose() * P * rate if system.discrete else -rate.transpose() * P - P * rate
        G, later = _symmetric(found[name], size) + less, move(V, A)
        both = {e: V.get(e, fmpq(0)) * system.discrete - later.get(e, fmpq(0)) for e in {*V, *later}}
        falls = {e: v for e, v in both.items() if v != 0}
        require(_polynomial(G, basis) == falls, f"the Gram matrix of the {name} end is not one of -V'")
        if name == "lower" and not system.discrete and all(row[0] == 0 for row in A):
            require(all(G[i, 0] == 0 for i in range(size)), "the form moves with the first state alone")
            G, case = fmpq_mat([[G[i, j] for j in range(1, size)] for i in range(1, size)]), "critical"
        _require_definite(G, f"the Gram matrix of the {name} end")
    return case


def _basis(n: int, half: int) -> list[Powers]:
    """The exponents of that sum, descending."""
    if n == 1:
        return [(half,)]
    return [(first, *rest) for first in range(half, -1, -1) for rest in _basis(n - 1, half - first)]


def _symmetric(rows: object, size: int) -> fmpq_mat:
    half = triangle(rows, size)
    return fmpq_mat([[fmpq(half[max(i, j)][min(i, j)]) for j in range(size)] for i in range(size)])


def _polynomial(G: fmpq_mat, basis: Sequence[Powers]) -> Polynomial:
    """``m' G m``, without terms that are 0."""
    found = Polynomial()
    for (i, e), (j, f) in product(enumerate(basis), repeat=2):
        power = tuple(a + b for a, b in zip(e, f, strict=True))
        found[power] = found.get(power, fmpq(0)) + G[i, j]
    return {e: v for e, v in found.items() if v != 0}


def _along(p: Polynomial, A: tuple[Row, ...]) -> Polynomial:
    """``grad p . A x``, without terms that are 0."""
    found = Polynomial()
    for e, v in p.items():
        tick()
        for i, row in enumerate(A):
            for j, a in enumerate(row):
                if e[i] and a:
                    moved = list(e)
                    moved[i] -= 1
                    moved[j] += 1
                    found[tuple(moved)] = found.get(tuple(moved), fmpq(0)) + v * e[i] * to_fmpq(Fraction(a))
    return {e: v for e, v in found.items() if v != 0}


def _moved(p: Polynomial, A: tuple[Row, ...]) -> Polynomial:
    """``p(A x)``, without terms that are 0."""
    n, found = len(A), Polynomial()
    forms = [{tuple(int(h == j) for h in range(n)): to_fmpq(Fraction(a)) for j, a in enumerate(row) if a} for row in A]
    for e, v in p.items():
        tick()
        total: Polynomial = {(0,) * n: v}
        for form, times in zip(forms, e, strict=True):
            for _ in range(times):
                total = _times(total, form)
        for f, c in total.items():
            found[f] = found.get(f, fmpq(0)) + c
    return {e: v for e, v in found.items() if v != 0}


def _times(p: Polynomial, q: Polynomial) -> Polynomial:
    found = Polynomial()
    for (e, a), (f, b) in product(p.items(), q.items()):
        power = tuple(x + y for x, y in zip(e, f, strict=True))
        found[power] = found.get(power, fmpq(0)) + a * b
    return found


def _require_definite(M: fmpq_mat, name: str) -> None:
    for bits in BITS:
        tick()
        with working_precision(bits):
            if positive_definite(arb_mat(M)):
                return
    raise NotShown(f"{name} is not shown to be positive definite")

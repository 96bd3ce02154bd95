"""Certificates with a matrix P: the circle and Popov's criterion in state space, without a semidefinite program."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any

from lure.analysis.certificates.arithmetic import Malformed, Rejected
from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.riccati import MOST_IN_BALLS, Inequality, Rounded, close_solutions, solutions
from lure.analysis.certificates.states import deflated, matrix_facts
from lure.analysis.certificates.systems import system_of, text
from lure.analysis.certificates.theory import theory_of
from lure.analysis.numerics.exact_matrix import column_of, dot, integer_multiple, null_space
from lure.analysis.theorems.table import Upper
from lure.arrays import in_doubles, np
from lure.errors import AssumptionError
from lure.plants.block import StructuredPlant
from lure.plants.rational import RationalPlant
from lure.plants.state_space import StateSpace
from lure.record import described, quantity

Vector = list[Fraction]
Matrix = list[Vector]
MatrixBlock = RationalPlant | StateSpace | StructuredPlant


@described(frozen=True, kw_only=True, slots=True)
class Claim:
    r"""``1/width + Re[(1 + i omega theta) H] > 0`` of the shifted loop, in the states of the checker's ``P``."""

    A: Matrix = quantity("``x' = A x + b mu``, ``sigma = c x + d mu``; in discrete time ``x[t+1] = ...``")
    b: Vector
    c: Vector
    d: Fraction
    discrete: bool = quantity("Whether time is discrete")
    width: Fraction | None = quantity("Width of the sector, positive; None for no upper end")
    theta: Fraction = quantity("Popov's multiplier; 0 in discrete time")


def matrix_draft(
    block: MatrixBlock, upper: Upper, *, lower: Fraction = Fraction(0), theta: Fraction | None = None
) -> dict[str, Any]:
    r"""A certificate by a matrix ``P`` for the time-invariant nonlinearities of a sector, the checker's part left out.

    ``P`` makes ``V = x'P x + zeta^2/rho + 2 theta int phi`` fall along every solution.  The class may be narrowed or,
    for ``theta`` None, widened to nonlinearities that vary in time by changing ``laws`` of the draft: the proof is the
    same.

    Parameters
    ----------
    block : RationalPlant, StateSpace or StructuredPlant
        The block, of finitely many states; entries of matrices mean the doubles they are.
    upper : Fraction or {"finite", "inf"}
        Upper end of the sector.
    lower : Fraction
        Its lower end.
    theta : Fraction, optional
        Popov's multiplier [s], of either sign; None for the circle criterion.

    Returns
    -------
    dict
        For :func:`lure.analysis.certificates.drafts.completed`.  ``P`` passed the checker's test or, beyond order 64
        and
        where it leaves no doubt, one in floating point; the checker has yet to accept the whole certificate.

    Raises
    ------
    AssumptionError
        No ``P`` was found: the frequency inequality fails, ``A`` is not stable, the digits do not suffice, or the
        numbers of the block are not rational.  Nothing follows about the loop.

    Examples
    --------
    >>> draft = matrix_draft(RationalPlant([1], [1, 1]), Fraction(5))
    >>> draft["theorem"], len(draft["proof"]["P"])
    ('circle', 1)
    """
    system = system_of(block)
    try:
        A, b, c, d, discrete = realised(system, lower)
    except (Rejected, Malformed) as refusal:
        raise AssumptionError(f"no matrix P serves here: {refusal}") from None
    width = None if isinstance(upper, str) else Fraction(upper) - lower
    claim = Claim(A=A, b=b, c=c, d=d, discrete=discrete, width=width, theta=theta or Fraction(0))
    known = theory_of(block).matrices(claim.theta) if isinstance(block, StructuredPlant) else ()
    sector = [text(lower), upper if isinstance(upper, str) else text(upper)]
    return {
        "verdict": "PROVED",
        "numbers": "doubles, exactly" if isinstance(block, StateSpace) else "rationals",
        "system": system,
        "laws": {"sector": sector, "slope": None, "odd": False, "time_varying": False, "linear": False},
        "theorem": "circle" if theta is None else "popov",
        "multiplier": {} if theta is None else {"theta": str(theta)},
        "proof": proof_by_matrix(claim, known),
    }


def proof_by_matrix(claim: Claim, first: Iterable[Rounded] = (), *, close: bool = False) -> dict[str, Any]:
    """The first ``P`` that passes.

    ``claim``: what it is to show; ``first``: what to try first; ``close``: whether to go on where the frequency
    inequality leaves less room than doubles can tell, and to believe no ``P`` that is sure in doubles alone.

    Raises
    ------
    AssumptionError
        None was found; nothing follows about the loop.
    """
    zero, reason = zero_of(claim), "none was found"
    for P in _candidates(claim, zero, first, solutions_of if close else solutions):
        proof = {
            "method": "matrix",
            "P": [[str(v) for v in row] for row in P.rows],
            "exponent": P.exponent,
            "zero": zero,
        }
        if (P.sure and not close) or len(P.rows) > MOST_IN_BALLS:
            return proof
        try:
            matrix_facts(claim.A, claim.b, claim.c, claim.d, claim.width, claim.theta, claim.discrete, proof)
        except Rejected as refusal:
            reason = str(refusal)
        else:
            return proof
    rightmost = float(np.max(np.linalg.eigvals([[float(v) for v in row] for row in claim.A]).real)) if claim.b else 0.0
    raise AssumptionError(
        f"no matrix P was found ({reason}), and the rightmost eigenvalue of A is near {rightmost:.6g}; if the block is "
        "stable, try a smaller sector or another theta"
    )


def solutions_of(inequality: Inequality) -> Iterator[Rounded]:
    """Candidates with all the room there is, then those with hardly any."""
    with suppress(AssumptionError):
        yield from solutions(inequality)
    yield from close_solutions(inequality)


def _candidates(
    claim: Claim,
    zero: dict[str, Any] | None,
    first: Iterable[Rounded],
    solved: Callable[[Inequality], Iterator[Rounded]],
) -> Iterator[Rounded]:
    """What to try, the likeliest first."""
    yield from first
    A, b, c, rho = claim.A, claim.b, claim.c, Fraction(0)
    if zero is not None:
        try:
            A, b, c, rho = deflated(A, b, c, zero)
        except Rejected as refusal:
            raise AssumptionError(f"no matrix P serves here: {refusal}") from None
    r = (Fraction(0) if claim.width is None else 2 / claim.width) + 2 * claim.d
    if claim.discrete:
        yield from _discrete(A, b, c, r, solved)
        return
    r += 2 * claim.theta * (dot(c, b) + rho)
    if not r > 0:
        raise AssumptionError(f"the frequency inequality fails at infinity, where it is {float(r) / 2:.6g}")
    yield from solved(Inequality(A=A, b=b, c=c, theta=claim.theta, r=r))


def _discrete(
    A: Matrix, b: Vector, c: Vector, r: Fraction, solved: Callable[[Inequality], Iterator[Rounded]]
) -> Iterator[Rounded]:
    """By ``s = (z - 1)/(z + 1)``, ``J = (A + 1)^-1``: ``2P`` serves ``1 - 2J``, ``J b``, ``2 c J``, ``r - 2 c J b``."""
    from flint import fmpq, fmpq_mat

    n = len(b)
    if n > MOST_IN_BALLS:
        near = np.linalg.inv(in_doubles(A) + np.eye(n))
        J = [[Fraction(v) for v in row] for row in near.tolist()]
    else:
        plus = [[fmpq(v.numerator, v.denominator) + int(i == j) for j, v in enumerate(row)] for i, row in enumerate(A)]
        try:
            J = [[Fraction(int(v.p), int(v.q)) for v in row] for row in fmpq_mat(plus).inv().tolist()]
        except ZeroDivisionError:
            raise AssumptionError("A has the eigenvalue -1: the block is not stable") from None
    Jb, cJ = [dot(row, b) for row in J], [dot(c, column) for column in zip(*J, strict=True)]
    r -= 2 * dot(cJ, b)
    if not r > 0:
        raise AssumptionError(f"the frequency inequality fails at z = -1, where it is {float(r) / 2:.6g}")
    turned = [[int(i == j) - 2 * v for j, v in enumerate(row)] for i, row in enumerate(J)]
    for P in solved(Inequality(A=turned, b=Jb, c=[2 * v for v in cJ], theta=Fraction(0), r=r)):
        yield replace(P, exponent=P.exponent + 1, sure=False)


def zero_of(claim: Claim) -> dict[str, Any] | None:
    """The zero eigenvalue in the words of a certificate, None if there is none or time is discrete."""
    n = len(claim.b)
    if claim.discrete or _regular(claim.A):
        return None
    entries = np.empty((n, n), dtype=object)
    entries[:] = claim.A
    whole = integer_multiple(entries, "A")
    right, left = null_space(whole), null_space(whole.transpose())
    if right.ncols() != 1:
        return None
    x, y = column_of(right), column_of(left)
    return {"right": _short(x), "left": _short(y), "pivot": max(range(n), key=lambda i: abs(x[i]))}


def _regular(A: Matrix) -> bool:
    """Whether floating point finds ``A`` far from singular, which saves the exact test."""
    size = in_doubles(A)
    scale = np.linalg.svd(size / max(float(np.max(np.abs(size))), 1e-300), compute_uv=False)
    return bool(scale[-1] > 1e-6)


def _short(vector: Vector) -> list[str]:
    """A vector of integers without common divisor."""
    shared = math.gcd(*(v.numerator for v in vector)) or 1
    return [str(v / shared) for v in vector]

"""A linear gain with which a solution grows, by a quadratic form: for matrices too large for exact polynomials."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from flint import arb_mat

from lure.analysis.certificates.blocks import realised
from lure.analysis.certificates.riccati import Lyapunov, doubles
from lure.analysis.certificates.systems import text
from lure.analysis.numerics.polynomial import exact_midpoint
from lure.analysis.numerics.precision import ball, working_precision
from lure.arrays import Reals, balanced, in_doubles, np
from lure.errors import AssumptionError

BITS = 256
MOST_STEPS = 8
FINE = 1.0 / 8  # of the right-hand side 1: how far off the Lyapunov equation may be
START_BITS = 24

Rows = list[list[Fraction]]


def growth_proof(system: Mapping[str, Any], gain: Fraction) -> dict[str, Any]:
    r"""That with ``mu = -gain sigma`` a solution grows: ``P`` with ``A'P + PA < 0`` and a state ``x'P x < 0``.

    ``A`` is that of the closed loop; in discrete time ``A'P A - P < 0``.

    ``system``: the system as it stands in a certificate: of matrices, or a rational one in its companion form;
    ``gain``: the gain, with which the loop has an eigenvalue strictly outside.

    Returns
    -------
    dict
        ``proof`` of a certificate, method ``matrix-gain``.  Nothing is proved by it before the checker accepted it.

    Raises
    ------
    AssumptionError
        No such form was found: the loop is stable with this gain, or too close to the limit for doubles.

    Notes
    -----
    ``A'P + PA = -1`` is solved in balanced units by the Schur form, order ``n^3``, and improved with residuals of 256
    bits until ``P`` is known well enough.  By Lyapunov's theorem of inertia ``P`` then has as many negative
    eigenvalues as ``A`` has on the right.

    Examples
    --------
    >>> system = {"kind": "state-space", "time": "continuous", "A": [["-1"]], "b": ["1"], "c": ["-1"], "d": "0"}
    >>> proof = growth_proof(system, Fraction(2))
    >>> proof["start"], int(proof["P"][0][0]) < 0
    (['16777216'], True)
    """
    A, *_, discrete = realised(system, gain)
    closed = in_doubles(A)
    if not np.isfinite(closed).all():
        raise AssumptionError("the closed loop is too much for doubles; rescale the units of the block")
    _, units = balanced(closed)
    scaled = [[v * Fraction(units[j]) / Fraction(units[i]) for j, v in enumerate(row)] for i, row in enumerate(A)]
    P, start = _form(scaled, discrete=discrete)
    top = float(np.max(units))
    exponent = math.ceil(math.log2(16.0 * len(A) * (1.0 + float(np.linalg.norm(in_doubles(scaled)))) ** 2 * top * top))
    weights = [Fraction(v) for v in units.tolist()]
    rows = [
        [str(round(P[i][j] / (weights[i] * weights[j]) * Fraction(2) ** exponent)) for j in range(i + 1)]
        for i in range(len(A))
    ]
    along = start * units
    places = START_BITS - math.frexp(float(np.max(np.abs(along))))[1]
    return {
        "method": "matrix-gain",
        "gain": text(gain),
        "P": rows,
        "start": [str(round(math.ldexp(v, places + 1))) for v in along.tolist()],
    }


def _form(A: Rows, *, discrete: bool) -> tuple[Rows, Reals]:
    """``P`` with ``A'P + PA`` near -1 (``A'P A - P``), and a state for which it is negative."""
    equation, n = Lyapunov.of(in_doubles(A), discrete=discrete), len(A)
    with working_precision(BITS), np.errstate(all="ignore"):
        exact = arb_mat([[ball(v) for v in row] for row in A])
        P, residual = arb_mat(n, n), np.eye(n)
        for _ in range(MOST_STEPS):
            step = equation.solution(residual)
            if not np.isfinite(step).all():
                break
            P = (P + arb_mat(step.tolist())).mid()
            residual = np.eye(n) - _fall(exact, P, discrete=discrete)
            if float(np.linalg.norm(residual)) < FINE:
                values, vectors = np.linalg.eigh(doubles(P))
                if values[0] >= 0:
                    raise AssumptionError("the loop is stable with this gain, as far as doubles can tell")
                return [[exact_midpoint(P[i, j]) for j in range(n)] for i in range(n)], vectors[:, 0]
    raise AssumptionError("no form that falls was found: with this gain the loop is too close to its limit")


def _fall(A: arb_mat, P: arb_mat, *, discrete: bool) -> Reals:
    moved = A.transpose() * P
    return doubles(P - moved * A if discrete else -(moved + moved.transpose()))

"""From a certificate to a loop with a function ``V`` that falls: what the export proves by quadratic forms."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from itertools import islice
from typing import Any

from flint import arb_mat

from lure.analysis.certificates.arithmetic import INF, Malformed, Rejected, number, numbers
from lure.analysis.certificates.blocks import coefficients, realised
from lure.analysis.certificates.channels import Channels, Plant, channels, plant, triangle
from lure.analysis.certificates.frequencies import shifted
from lure.analysis.certificates.matrix import Claim, proof_by_matrix, solutions_of, zero_of
from lure.analysis.certificates.riccati import CLOSE, Inequality, Rounded, stabilising
from lure.analysis.certificates.states import classes, deflated
from lure.analysis.certificates.windows import Form, coupled
from lure.analysis.export.quadratic import Loop, Matrix, Vector, less, mix, rounded
from lure.analysis.export.words import refused
from lure.analysis.inequality.zero_modes import ZeroModes, zero_modes
from lure.analysis.numerics.exact_matrix import dot
from lure.analysis.numerics.polynomial import to_fraction
from lure.analysis.numerics.precision import ball, working_precision
from lure.errors import AssumptionError

Data = Mapping[str, Any]
BITS = (16, 32, 64, 128, 256, 512)
MOST_STATES, MOST_ALIKE = 16, 4  # 120 orders of as many channels and 0, or 384 with signs


def of_transfer(system: Data) -> Loop:
    """``z = (xi, xi', ..)`` with ``den xi = mu``, ``num xi = sigma``."""
    top, d, discrete = coefficients(system)
    n, order = top[0][1], len(d) - 1
    units = [[Fraction(i == j) for j in range(order + 1)] for i in range(order + 1)]
    return Loop(
        discrete=discrete, now=units[:-1], then=units[1:], phi=[[-v for v in d[::-1]]],
        sigma=[[*n[::-1], *[Fraction(0)] * (order + 1 - len(n))]], bounds=[], weights=[], theta=[], P=[], rows=units,
    )  # fmt: skip


def of_states(A: Matrix, B: Matrix, C: Matrix, D: Matrix, *, discrete: bool) -> Loop:
    """``z = (x, w)`` with ``w = phi(sigma)``."""
    n, m = len(A), len(D)
    units = [[Fraction(i == j) for j in range(n + m)] for i in range(n + m)]
    then, sigma = ([[*a, *(-v for v in b)] for a, b in zip(*side, strict=True)] for side in ((A, B), (C, D)))
    return Loop(
        discrete=discrete, now=units[:n], then=then, phi=units[n:], sigma=sigma, bounds=[], weights=[], theta=[], P=[],
        rows=units,
    )  # fmt: skip


def of_one(system: Data) -> Loop:
    """A plant of one channel by two polynomials or by matrices."""
    if system["kind"] == "transfer":
        return of_transfer(system)
    A, b, c, d, discrete = realised(system, Fraction(0))
    return of_states(A, [[v] for v in b], [c], [[d]], discrete=discrete)


def candidates(certificate: Data) -> Iterator[Loop]:
    """The loop of a certificate with a ``V`` of more and more digits.

    ``certificate``: one that the checker accepted, of a theorem that a quadratic form with integrals shows.

    Raises
    ------
    refused
        An ``InputError``: it is of another kind, or no ``P`` was found.
    """
    try:
        if isinstance(certificate["laws"], dict) and "channels" in certificate["laws"]:
            yield from _several(certificate)
        else:
            yield from _one(certificate)
    except (Rejected, Malformed, AssumptionError) as reason:
        raise refused(str(reason)) from None


def _one(certificate: Data) -> Iterator[Loop]:
    """The circle criterion, or Popov's; ``P`` is that of the certificate, or is found."""
    name, system, proof = certificate["theorem"], certificate["system"], certificate["proof"]
    if name not in ("circle", "popov") or system["kind"] not in ("transfer", "state-space"):
        raise refused(
            f"{name} by {proof['method']} has no export for a plant of the kind {system['kind']}; circle and popov "
            "have one, and by a polynomial park, off-axis-circle, zames-falb, order-cone, tsypkin and jury-lee"
        )
    if certificate["multiplier"].get("mirrored"):
        raise refused("its class has no lower bound; certify one with a lower bound")
    theta = number(certificate["multiplier"]["theta"]) if name == "popov" else Fraction(0)
    low, high = classes(certificate["laws"]).sector
    A, b, c, d, discrete = realised(system, low)
    if theta and d:
        raise refused("its matrices have a feedthrough, which Popov's term does not cover; export a circle criterion")
    if len(A) > MOST_STATES:
        raise refused(f"its plant has {len(A)} states, above {MOST_STATES}")
    width = None if high == INF else high - low
    claim = Claim(A=A, b=b, c=c, d=d, discrete=discrete, width=width, theta=theta)
    zero = proof["zero"] if proof["method"] == "matrix" else _zero(claim)
    # whether nothing is left of F at infinite frequency
    each = proof["method"] != "matrix" and width is None and not theta * dot(c, b) + d
    if each:
        found = _for_each_bound(claim, zero)
    else:
        own = _triangle(proof if proof["method"] == "matrix" else proof_by_matrix(_beside(claim, zero), close=True))
        found = iter([*(rounded(own, bits) for bits in BITS), own])
    rows, ends = _ends(_still(claim), b, c, zero)
    rest = None if zero is None or d else (numbers(zero["right"]), numbers(zero["left"]), int(zero["pivot"]))
    if not rows and rest is None:
        raise refused("its one state is an eigenvalue 0, and it has a feedthrough")
    loop, lead = of_one(system), Fraction(1)
    if system["kind"] == "transfer":
        lead = (loop.sigma[0][-1] * low - loop.phi[0][-1]) ** 2  # the states of `realised` are this times xi
    shape = loop.sigma[0][: len(A)]
    weights = [Fraction(2) if high == INF else 2 / (high - low)]
    loop = replace(loop, bounds=[(low, high)], weights=weights, theta=[theta], rows=rows, rest=rest, each=each)
    for P in found:
        whole = [[lead * v for v in row] for row in carried(P, rows, ends)]
        if theta and low:
            whole = [less(row, theta * low * s, shape) for row, s in zip(whole, shape, strict=True)]
        yield replace(loop, P=whole)


def _still(claim: Claim) -> Matrix:
    """What is 0 at an equilibrium: ``A``, in discrete time ``A - 1``."""
    return [[v - (claim.discrete and i == j) for j, v in enumerate(row)] for i, row in enumerate(claim.A)]


def _zero(claim: Claim) -> Data | None:
    """The eigenvalue 0, in discrete time 1, None if there is none."""
    return zero_of(replace(claim, A=_still(claim), discrete=False))


def _beside(claim: Claim, zero: Data | None) -> Claim:
    """What is left beside an eigenvalue 1: ``rho/(z - 1)`` has the real part ``-rho/2`` on the circle."""
    if zero is None or not claim.discrete:
        return claim
    small, b, c, rho = deflated(_still(claim), claim.b, claim.c, zero)
    A = [[v + (i == j) for j, v in enumerate(row)] for i, row in enumerate(small)]
    return replace(claim, A=A, b=b, c=c, d=claim.d - rho / 2)


def _triangle(proof: Data) -> Matrix:
    """``P`` of a proof."""
    half = [numbers(row) for row in proof["P"]]
    size = range(len(half))
    return [[half[max(i, j)][min(i, j)] / 2 ** proof["exponent"] for j in size] for i in size]


def _for_each_bound(claim: Claim, zero: Data | None) -> Iterator[Matrix]:
    """``P b = c + theta A'c`` exactly, else near a solution with a large upper bound; ``b`` is the last unit vector."""
    A, b, c = (claim.A, claim.b, claim.c) if zero is None else deflated(claim.A, claim.b, claim.c, zero)[:3]
    n = len(b)
    if not n:
        yield []
        return
    if claim.discrete or b[:-1] != [0] * (n - 1) or b[-1:] != [1]:
        raise refused("without an upper bound it needs a transfer function in continuous time; give an upper bound")
    q = [v + claim.theta * dot(c, [row[j] for row in A]) for j, v in enumerate(c)]
    for power in (2, 4, 6, 8, 12, 16, 20, 30, 40):
        near = Inequality(A=A, b=b, c=c, theta=claim.theta, r=Fraction(1, 1 << power))
        for one in islice(solutions_of(near), 4) if n > 1 else [Rounded(rows=[[0]], exponent=0)]:
            P = _triangle({"P": [[str(v) for v in row] for row in one.rows], "exponent": one.exponent})
            for own in (*(rounded(P, bits) for bits in BITS[:3]), P):
                own[-1] = list(q)
                for row, v in zip(own, q, strict=True):
                    row[-1] = v
                yield own


def _ends(A: Matrix, b: Vector, c: Vector, zero: Data | None) -> tuple[Matrix, list[tuple[Fraction, Vector]]]:
    """What tends to 0, as rows over ``x``, and squares beside ``P``: with an eigenvalue 0 ``zeta^2/rho``."""
    n = len(A)
    units = [[Fraction(i == j) for j in range(n)] for i in range(n)]
    if zero is None:
        return units, []
    *_, rho = deflated(A, b, c, zero)
    x, y, p = numbers(zero["right"]), numbers(zero["left"]), zero["pivot"]
    rest = [less(units[i], x[i] / x[p], units[p]) for i in range(n) if i != p]
    gain = dot(c, x) / dot(y, x)
    return rest, [(1 / rho, [gain * v for v in y])]


def carried(P: Matrix, rows: Matrix, ends: list[tuple[Fraction, Vector]]) -> Matrix:
    """``sum P_ij rows_i' rows_j`` and squares.

    Parameters
    ----------
    P : list of list of Fraction
        A form.
    rows : list of list of Fraction
        What it is a form in.
    ends : list of tuple
        Squares: a factor, and a row.
    """
    n = len((*rows, *(row for _, row in ends))[0])
    found = [[Fraction(0)] * n for _ in range(n)]
    pairs = [(v, rows[i], rows[j]) for i, row in enumerate(P) for j, v in enumerate(row)]
    for v, left, right in (*pairs, *((w, row, row) for w, row in ends)):
        for i, a in enumerate(left):
            if a and v:
                found[i] = [s + v * a * t for s, t in zip(found[i], right, strict=True)]
    return found


def _several(certificate: Data) -> Iterator[Loop]:
    """The circle criterion, or Popov's, with one multiplier for each channel, or one for all."""
    name, system, data, proof = (certificate[key] for key in ("theorem", "system", "multiplier", "proof"))
    kind, _, popov = name.rpartition("-")
    H = plant(system)
    asked = channels(certificate["laws"], len(H.D))
    ends, alike = [asked.bounds(i) for i in range(len(H.D))], None
    if kind == "coupled":
        kind, data, ends, alike = _coupled(data, asked)
    critical = "semidefinite" in proof and not asked.performance
    if not (alike or kind in ("diagonal", "full-block")) or popov not in ("circle", "popov") or critical:
        raise refused(f"{name} has no export; diagonal and full-block ones with a form that is definite have one")
    others = [block for block in asked.operators if block != asked.performance]
    if others or asked.delayed or any(one.memory or one.rate is not None for one in asked.families):
        raise refused("a channel is no function of sigma in a sector: it is an operator, has memory, a delay or a rate")
    if len(H.A) > MOST_STATES:
        raise refused(f"its plant has {len(H.A)} states, above {MOST_STATES}")
    m, bounds = len(H.D), ends
    theta = numbers(data["theta"]) if popov == "popov" else [Fraction(0)] * m
    loop = of_states(H.A, H.B, H.C, H.D, discrete=H.discrete)
    units = [[Fraction(i == j) for j in range(len(H.A))] for i in range(len(H.A))]
    resting = [numbers(v)[: len(units)] for v in proof.get("zero", [])]  # each with its own 1, where others have 0
    modes = None
    if proof["method"] != "matrix" and not H.discrete:
        modes = zero_modes(*shifted(H, [Fraction(low) for low, _ in bounds])[:3], discrete=False)
        resting = [] if modes is None else [[to_fraction(c) for c in v] for v in modes.right.transpose().tolist()]
    pivots = [next(i for i, c in enumerate(v) if c) for v in resting]
    rows = [
        mix([Fraction(1), *(-v[i] for v in resting)], [units[i], *(units[p] for p in pivots)])
        for i in range(len(units))
        if i not in pivots
    ]
    if not rows:
        raise refused("all its states belong to eigenvalues 0, or 1 in discrete time, and nothing tends to 0")
    loop = replace(loop, bounds=bounds, theta=theta, rows=rows)
    loop = replace(loop, weights=[2 * v for v in numbers(data["lambda"])] if "lambda" in data else [])
    if alike:
        loop = replace(loop, block=alike.M, odds="odd" in data["forms"][0]["kind"])
    elif kind != "diagonal":
        k = m - len(asked.performance or [])
        Pi, places = triangle(data["Pi"], 2 * k), [j for i in range(k) for j in (i, k + i)]
        loop = replace(
            loop, block=[[Pi[i][j] for j in places] for i in places], cones=_cones(data.get("N", []), bounds[:k])
        )
    for P in _matrices(H, loop, proof, modes):
        for own in (*(rounded(P, bits) for bits in BITS), P):
            yield replace(loop, P=own)


def _coupled(data: Data, asked: Channels) -> tuple[str, Data, list[tuple[Fraction, Fraction]], Form | None]:
    """What forms of several channels are: diagonal, or one of all channels; and the bounds that they are about."""
    forms, bounds = coupled(data["forms"], asked, 1, summed=False)
    plain = [one["kind"] in ("sector", "monotone", "odd") for one in data["forms"]]
    if all(plain) and [one.channels for one in forms] == [[i] for i in range(len(bounds))]:
        return "diagonal", {**data, "lambda": [one["rows"][0][0] for one in data["forms"]]}, bounds, None
    whole = [one.channels for one in forms] == [[*range(len(bounds))]] and len(bounds) <= MOST_ALIKE
    return "coupled", data, bounds, forms[0] if whole and data["forms"][0]["kind"] in ("monotone", "odd") else None


def _cones(given: Data, bounds: list[tuple[Fraction, Fraction]]) -> list[Matrix]:
    """The parts ``N`` of a full block, which are of ``(phi - l sigma, u sigma - phi)``, for ``Loop.cones``."""
    m, found = len(bounds), []
    for part in given:
        N = triangle(part, 2 * m)
        ends = []
        for i, (low, high) in enumerate(bounds):
            ends += [(place, (high - low) * end.denominator) for place, end in ((m + i, low), (i, high))]
        found.append([[a * b * N[i][j] for j, b in ends] for i, a in ends])
    return found


def _matrices(H: Plant, loop: Loop, proof: Data, modes: ZeroModes | None) -> Iterator[Matrix]:
    """``P`` of the certificate, or from Riccati's equation, with less and less room; none is believed.

    After the shift by the lower bounds ``-V' - 2 sum lambda_i psi_i (w_i sigma_i - psi_i)`` is a form in ``(x, psi)``
    with the blocks ``-(A'P + PA)``, ``PB - S`` and ``R``: ``S' = Lambda W C + Theta C A``, ``R = He(Lambda (1 + W D) +
    Theta C B)``.  Eigenvalues 0 are taken apart, and their part of ``P`` is prescribed.

    Raises
    ------
    refused
        In discrete time, or with one multiplier for all channels, without a ``P``.
    """
    if proof["method"] == "matrix":
        yield _triangle(proof)
        return
    if H.discrete or loop.block:
        raise refused("in discrete time, and with full blocks, several channels need a proof by a matrix")
    (A, B, C, D), m = shifted(H, [Fraction(low) for low, _ in loop.bounds]), len(H.D)
    given = [w / 2 for w in loop.weights]
    width = [Fraction(high) - low for low, high in loop.bounds]
    CB = [mix(row, B) for row in C]
    if modes is not None:
        r, inner = modes.right.ncols(), modes.apart((A, B, C, D))
        A, B, C = (
            [[to_fraction(v) for v in row] for row in side.tolist()]
            for side in (inner.A[r:, r:], inner.B[r:], inner.C[:, r:])
        )
    n, CA = len(A), [mix(row, A) if A else [] for row in C]
    S = [[given[i] * width[i] * C[i][k] + loop.theta[i] * CA[i][k] for i in range(m)] for k in range(n)]
    half = [[given[i] * ((i == j) + width[i] * D[i][j]) + loop.theta[i] * CB[i][j] for j in range(m)] for i in range(m)]
    R = [[half[i][j] + half[j][i] for j in range(m)] for i in range(m)]
    for P in _solutions(A, B, S, R) if n else iter([[]]):
        for own in [P] if modes is None else [*(rounded(P, bits) for bits in BITS), P]:
            found = (
                own if modes is None else _with_modes(modes, own, [a * b for a, b in zip(given, width, strict=True)])
            )
            for theta, (low, _), row in zip(loop.theta, loop.bounds, loop.sigma, strict=True):
                if theta and low:
                    found = [less(line, theta * low * v, row[: len(H.A)]) for line, v in zip(found, row, strict=False)]
            yield found


def _with_modes(modes: ZeroModes, inner: Matrix, weights: Vector) -> Matrix:
    """``P``, from the part that eigenvalues 0 prescribe, and that of what is beside them."""
    own, r = modes.energy(weights).tolist(), modes.right.ncols()
    turn = [[to_fraction(v) for v in row] for row in modes.turn.tolist()]
    first = carried([[to_fraction(v) for v in row] for row in own], turn[:r], [])
    rest = carried(inner, turn[r:], []) if inner else [[Fraction(0)] * len(turn) for _ in turn]
    return [[a + b for a, b in zip(*pair, strict=True)] for pair in zip(first, rest, strict=True)]


def _solutions(A: Matrix, B: Matrix, S: Matrix, R: Matrix) -> Iterator[Matrix]:
    """Solutions of Riccati's equation, with less and less room."""
    n = len(A)
    for power in CLOSE:
        with working_precision(max(128, 8 * power)), suppress(ArithmeticError, ValueError):
            room, sides = Fraction(1, 1 << power), [A, B, S]
            sides.append([[v - (i == j) * room for j, v in enumerate(row)] for i, row in enumerate(R)])
            sides.append([[(i == j) * room for j in range(n)] for i in range(n)])
            lower = stabilising(*(arb_mat([[ball(v) for v in row] for row in side]) for side in sides))
            if lower is not None:
                yield [[lower[max(i, j)][min(i, j)] for j in range(n)] for i in range(n)]

"""Several nonlinearities in discrete time: forms of several samples, part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from . import states
from .arithmetic import INF, ZERO, fields, form, integer, need
from .balls import dot, positive_definite
from .channels import Channels, Plant, Rows, closed_by, ordered, within


def lifted(H: Plant, data: Any, asked: Channels, proof: Any) -> tuple[dict[str, str], str]:
    """Forms of ``T`` samples in discrete time, of each nonlinearity: what was found, and what is assumed.

    ``P`` has either sign.  For ``xi = (x_1, phi_1, .., phi_(T-1))``, ``V = xi'P xi`` and ``w_b`` the samples of a block
    ``V(xi+) - V(xi) + sum w_b' M_b w_b <= -e |(xi, phi_T)|^2``, and ``w_b' M_b w_b >= 0`` along each solution.  For
    signals in l2 the sum over time bounds ``e sum |(xi, phi)|^2`` by ``V`` at the start, with an input too.  That they
    are in l2 follows by continuation from the stable loop ``phi = l sigma`` to ``l sigma + tau (phi - l sigma)``.
    """
    given, odd = fields(data, "windows", "odd")
    count = len(asked.blocks)
    form(all(isinstance(x, list) and len(x) == count for x in (given, odd)), f"{count} windows are needed, in order")
    need(H.discrete and ordered(H.D), "forms of several samples are for discrete time, D without a cycle of channels")
    blocks, samples = list[tuple[range, Rows]](), 0
    for block, rows, own in zip(asked.blocks, given, odd):
        family = asked.families[block[0]]
        need(INF not in map(abs, family.slope), f"channel {block[0] + 1} has no finite slope bounds")
        need(not family.varying and not family.rough, "locally Lipschitz nonlinearities fixed in time are needed")
        M, own = states.window({"taps": [], "window": rows, "odd": own}, False)
        need(not own or family.odd, f"the form of channel {block[0] + 1} needs an odd nonlinearity")
        samples = samples or len(M) // (2 * len(block))
        form(0 < len(M) == 2 * samples * len(block), "all windows have the same number of samples")
        blocks.append((block, M))
    lower = [family.slope[0] for family in asked.families]
    closed, n, m = closed_by(H, lower), len(H.A), len(H.D)
    need(closed is not None and within(closed, True), "the loop with the least slopes is not stable")
    N = n + m * samples
    phi = [[Fraction(i == n + j) for i in range(N)] for j in range(m * samples)]
    x, after, sigma = [[Fraction(i == j) for i in range(N)] for j in range(n)], Rows(), Rows()
    for t in range(samples):
        x = [*x, *([-v for v in row] for row in phi[m * t : m * (t + 1)])]  # (x, mu)
        sigma += [[dot(row, column) for column in zip(*x)] for row in ([*c, *d] for c, d in zip(H.C, H.D))]
        x = [[dot(row, column) for column in zip(*x)] for row in ([*a, *b] for a, b in zip(H.A, H.B))]
        after = after or [*x, *phi[m:]]
    order = N - m
    method, half, exponent = fields(proof, "method", "P", "exponent")
    form(method == "matrix", "several nonlinearities are proved by a matrix")
    P, e = states.symmetric(half, [[ZERO] * order], order)[0], integer(exponent, 0, 10**5)
    falls = [[Fraction(P[i][j] if i < order else 0, 2**e) for j in range(i + 1)] for i in range(N)]
    parts = [([[Fraction(v, 2**e) for v in row] for row in P], after)]
    for block, M in blocks:
        places = [m * t + i for t in range(samples) for i in block]
        u = [[p - lower[k % m] * s for p, s in zip(phi[k], sigma[k])] for k in places]
        v = [[asked.families[k % m].slope[1] * s - p for p, s in zip(phi[k], sigma[k])] for k in places]
        parts.append((M, [*u, *v]))
    for M, view in parts:
        columns = [*zip(*view)]
        turned = [[dot(row, column) for row in M] for column in columns]
        falls = [[v - dot(turned[i], columns[j]) for j, v in enumerate(row)] for i, row in enumerate(falls)]
    q = states.unit(falls)
    need(positive_definite([[int(q * v) for v in row] for row in falls]), "the inequality of P fails, or is undecided")
    facts = {
        "stable": f"the loop with the least slopes, {', '.join(map(str, lower))}: all eigenvalues are strictly inside",
        "cones": f"the forms are positive on every order cone of {samples} samples of each channel and 0",
        "inequality": f"the matrix of order {N} is positive definite: V falls",
        "well-posed": "sigma is given channel after channel: D has no cycle",
    }
    return facts, ""

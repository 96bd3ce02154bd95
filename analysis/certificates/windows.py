"""Several nonlinearities: forms that couple channels, and samples in discrete time; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from collections import defaultdict
from fractions import Fraction
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import states
from .arithmetic import INF, ZERO, fields, form, integer, need, numbers, tick
from .balls import dot, positive_definite
from .channels import (
    Channels,
    Plant,
    Rows,
    closed_by,
    each,
    existing,
    moved,
    ordered,
    rank,
    seen,
    triangle,
    uniform,
    within,
)

LONGEST = 40
SIDED = ("rising", "odd rising", "falling", "odd falling")


class Form(NamedTuple):
    """``w'M w >= 0``, ``w = (u, v)``, sample after sample; ``u = phi - l sigma``, ``v = h sigma - phi``."""

    channels: list[int]
    M: Rows


class Window(NamedTuple):
    """Forms of so many samples, those of one less that bound ``V`` from below, if ``P`` has to, and ``(l, h)``."""

    samples: int
    forms: list[Form]
    start: list[Form] | None
    bounds: list[tuple[Any, Any]]


def coupled(
    given: Any, asked: Channels, samples: int, summed: bool, rate: Fraction = Fraction(1)
) -> tuple[list[Form], list[tuple[Any, Any]]]:
    """Forms of so many samples of a few channels each, and the bounds ``(l, h)`` of ``u`` and ``v``.

    sector: ``sum q_k u_k v_k``, ``q_k >= 0``.  monotone, odd: ``2 u'Q v`` of channels with one nonlinearity whose
    slopes are in ``[l, h]``; ``u`` and ``v`` ascend with ``sigma``, so that ``sum_k u_k v_k >= sum_k u_k v_p(k)`` for
    every permutation ``p``, of some of the samples too: ``Q`` doubly hyperdominant, for odd ones (``|u|``, ``|v|``
    ascend with ``|sigma|``) doubly dominant.  rising: the same of ``2 u'Q (u + v)``, as ``u`` ascends where slopes are
    at least ``l``, and ``u + v`` is ``(h - l) sigma``; falling: of ``2 v'Q (u + v)`` where they are at most ``h``; the
    bounds are those of the sector then.  relu: ``u >= 0 >= v`` and ``u_k v_k = 0`` of any ReLUs.  ``summed``: over all
    time the sum of the form is nonnegative, by the same argument about all samples at once.  With a ``rate`` the
    samples are those of ``phi`` times ``rate^-t``: :func:`dominant`.
    """
    m, found, used = len(asked.families), list[Form](), dict[int, bool]()
    bounds: list[tuple[Any, Any]] = [asked.bounds(i) for i in range(m)]
    form(isinstance(given, list), "the forms are no list")
    for one in given:
        kind, where, rows = fields(one, "kind", "channels", "rows")
        form(isinstance(where, list) and isinstance(rows, list) and where != [], "a form has channels and rows")
        channels = [integer(i, 1, m) - 1 for i in where]
        beside = kind in ("sector", *SIDED)  # about the bounds of the sector, of which there may be more than one
        again = any(i in used and not (beside and used[i]) for i in channels)
        need(len({*channels}) == len(channels) and not again, "a channel stands twice in the forms")
        used.update(dict.fromkeys(channels, beside))
        families, p = [asked.families[i] for i in channels], samples * len(channels)
        need(not any(family.operator for family in families), "a form is of functions, an operator has a weight")
        if kind == "relu":
            need(all(family.relu for family in families), "a form is for ReLUs, and a channel has another class")
            need(not summed, "forms for ReLUs need a bound of V from below")
            M = triangle(rows, 2 * p)
            sign = [1] * p + [-1] * p
            right = (M[i][j] * sign[i] * sign[j] >= 0 for i in range(2 * p) for j in range(i + 1) if i != j + p)
            need(all(right), "an entry of a form for ReLUs has the wrong sign")
        else:
            known = kind in ("sector", "monotone", "odd", *SIDED)
            form(known and len(rows) == p, "a form has a kind, and a row each sample")
            Q = [numbers(row, p) for row in rows]
            if kind == "sector":
                right = (v >= 0 if k == l else v == 0 for k, row in enumerate(Q) for l, v in enumerate(row))
                need(all(right), "a form of the sector has an entry below 0, or beside the diagonal")
            else:
                same = any(set(channels) <= set(block) for block in asked.blocks)
                need(same, "a form couples channels with different nonlinearities")
                need(not any(family.varying for family in families), "nonlinearities fixed in time are needed")
                need("odd" not in kind or families[0].odd, "a form needs an odd nonlinearity")
                dominant(Q, len(channels), summed, "odd" in kind, rate)
                for i, family in zip(channels, families):
                    (low, high), (l, h) = family.slope, bounds[i]
                    need("rising" not in kind or low >= l, "a form needs slopes above the lower bound")
                    need("falling" not in kind or high <= h, "a form needs slopes below the upper bound")
                    bounds[i] = bounds[i] if kind in SIDED else family.slope
            across, none = [list(column) for column in zip(*Q)], [[ZERO] * p for _ in Q]
            both = [[v + w for v, w in zip(*pair)] for pair in zip(Q, across)] if kind in SIDED else none
            first, side, last = (none, across, both) if "falling" in kind else (both, Q, none)
            M = [a + b for a, b in zip(first, side)] + [list(a) + b for a, b in zip(zip(*side), last)]
        found.append(Form(channels, M))
    need(not any(family.rough for family in asked.families), "locally Lipschitz nonlinearities are needed")
    for i, ends in enumerate(bounds):
        need(INF not in map(abs, ends), f"channel {i + 1} has no finite bounds")
    return found, bounds


def dominant(Q: Rows, count: int, summed: bool, odd: bool, rate: Fraction = Fraction(1)) -> None:
    """Each entry on the diagonal is at least what ``|q|`` of its row, and of its column, add up to beside it.

    ``summed``: of the sums of the entries between two channels with one distance in time.  At a ``rate r`` these are
    of ``r^-k u_k`` and ``r^-l v_l``: ``r^(-k-l) u_k v_l <= r^(l-k) r^-2l F_l + r^(k-l) r^-2k (u_k v_k - F_k)``, with
    ``F = int u dv`` and ``0 <= F <= u v``, so that ``r^(k-l) |q|`` counts in the row, ``r^(l-k) |q|`` in the column;
    where nothing is summed ``r^(-k-l) |q|`` in both.
    """
    total, rows, columns = (defaultdict[Any, Fraction](Fraction) for _ in range(3))
    for k, row in enumerate(Q):
        for l, v in enumerate(row):
            weight = 1 if summed else rate ** -(k // count + l // count)
            total[(k % count, l % count, k // count - l // count) if summed else (k, l, 0)] += v * weight
    for (i, j, shift), v in total.items():
        beside = (i, shift) != (j, 0)
        need(odd or not beside or v <= 0, "an entry beside the diagonal is above 0, and the form is not for odd ones")
        rows[i] += -abs(v) * rate**shift if beside else v
        columns[j] += -abs(v) / rate**shift if beside else v
    need(min([*rows.values(), *columns.values()]) >= 0, "a form is not doubly dominant")


def static(given: Any, asked: Channels) -> tuple[Rows, list[tuple[Any, Any]]]:
    """``Pi`` of ``(sigma, phi)`` of forms of one sample, and the bounds that they are about."""
    found, bounds = coupled(given, asked, 1, False)
    m = len(bounds)
    Pi = [[ZERO] * 2 * m for _ in range(2 * m)]
    for channels, M in found:
        lines = [((i, -bounds[i][0]), (m + i, 1)) for i in channels]
        lines += [((i, bounds[i][1]), (m + i, -1)) for i in channels]
        for row, left in zip(M, lines):
            for v, right in zip(row, lines):
                for a, x in left if v else ():
                    for b, y in right:
                        Pi[a][b] += v * x * y
    return Pi, bounds


def of_orders(data: Any, asked: Channels) -> Window:
    """Forms that are positive on every order cone of the samples of a nonlinearity and 0."""
    given, odd = fields(data, "windows", "odd")
    blocks = [block for block in asked.blocks if block not in asked.operators]
    count = len(blocks)
    form(all(isinstance(x, list) and len(x) == count for x in (given, odd)), f"{count} windows are needed, in order")
    found, samples = list[Form](), 0
    for block, rows, own in zip(blocks, given, odd):
        family = asked.families[block[0]]
        need(INF not in map(abs, family.slope), f"channel {block[0] + 1} has no finite slope bounds")
        need(not family.varying and not family.rough, "locally Lipschitz nonlinearities fixed in time are needed")
        M, own = states.window({"taps": [], "window": rows, "odd": own}, False)
        need(not own or family.odd, f"the form of channel {block[0] + 1} needs an odd nonlinearity")
        samples = samples or len(M) // (2 * len(block))
        form(0 < len(M) == 2 * samples * len(block), "all windows have the same number of samples")
        found.append(Form(list(block), M))
    ends = [asked.bounds(i) if family.operator else family.slope for i, family in enumerate(asked.families)]
    return Window(samples, found, None, ends)


def of_pairs(data: Any, asked: Channels, rate: Fraction) -> Window:
    """Forms of pairs of samples; with ``start`` those that bound ``V`` from below."""
    length, given, first = fields(data, "samples", "forms", "start")
    samples = integer(length, 2, LONGEST)
    found, bounds = coupled(given, asked, samples, first is None, rate)
    if first is None:
        return Window(samples, found, None, bounds)
    start, others = coupled(first, asked, samples - 1, False, rate)
    need(others == bounds, "the forms at the start are about other bounds")
    return Window(samples, found, start, bounds)


def lifted(
    name: str, H: Plant, data: Any, asked: Channels, proof: Any, rate: Fraction | None = None
) -> tuple[dict[str, str], str]:
    """Forms of ``T`` samples in discrete time: what was found, and what is assumed.

    For ``xi = (x_1, phi_1, .., phi_(T-1))``, ``V = xi'P xi`` and the forms ``w_b' M_b w_b`` of samples of some channels
    ``V(xi+) - V(xi) + sum w_b' M_b w_b <= -e |(xi, phi_T)|^2``, and ``w_b' M_b w_b >= 0`` along each solution, or
    summed over time.  With forms ``N_b`` of ``T - 1`` samples and ``V - sum w_b' N_b w_b >= e |xi|^2``, ``V`` is
    positive along it and falls.  Else ``P`` has either sign: for signals in l2 the sum over time bounds ``e sum |(xi,
    phi)|^2`` by ``V`` at the start, with an input too.  That they are in l2 follows by continuation from the stable
    loop ``phi = l sigma`` to ``l sigma + tau (phi - l sigma)``, for which the forms are nonnegative too.
    Operators have ``lambda (r^2 |sigma_b|^2 - |mu_b|^2)`` of the last sample, of nonnegative sums, and ``l = 0``.
    With eigenvalues 1 the form is 0 at equilibria, :func:`at_rest`; without ``N_b``: :func:`settling`.
    """
    need(H.discrete and ordered(H.D, asked), "forms of several samples: discrete time, D without a cycle of channels")
    weights = [ZERO] * len(H.D)
    if asked.operators:
        form(isinstance(data, dict) and "lambda" in data, "lambda is missing")
        weights = numbers(data["lambda"], len(H.D))
        data = {key: value for key, value in data.items() if key != "lambda"}
        need(min(weights) >= 0 and not any(weights[i] for i in asked.functions), "lambda is of operators, and >= 0")
    uniform(weights, asked)
    ordering = name == "order-cones"
    samples, forms, start, bounds = of_orders(data, asked) if ordering else of_pairs(data, asked, rate or Fraction(1))
    lower = [ZERO if family.operator else l for family, (l, _) in zip(asked.families, bounds)]
    n, m = len(H.A), len(H.D)
    method, half, exponent, *zero = fields(proof, "method", "P", "exponent", *["zero"] * ("zero" in proof))
    form(not zero or isinstance(zero[0], list), "zero is a list of vectors")
    rests = len(zero[0]) if zero else 0
    if start is None:
        closed = closed_by(H, lower)
        need(closed is not None and within(closed, True, rests), "the loop with the least slopes is not stable")
    N = n + m * samples
    phi, sigma, after = signals(H, samples)
    order = N - m
    form(method == "matrix", "several nonlinearities are proved by a matrix")
    whole, e = states.symmetric(half, [[ZERO] * order], order)[0], integer(exponent, 0, 10**5)
    P = [[Fraction(v, 2**e) for v in row] for row in whole]

    def views(some: list[Form], length: int) -> list[tuple[Rows, Rows]]:
        """``M`` and the rows of ``w``."""
        found = []
        for channels, M in some:
            places = [(m * t + i, i) for t in range(length) for i in channels]
            u = [[p - bounds[i][0] * s for p, s in zip(phi[k], sigma[k])] for k, i in places]
            v = [[bounds[i][1] * s - p for p, s in zip(phi[k], sigma[k])] for k, i in places]
            found.append((M, [*u, *v]))
        return found

    places = [(m * (samples - 1) + i, i) for block in asked.operators for i in block]
    signs = [weights[i] * bounds[i][1] ** 2 for _, i in places] + [-weights[i] for _, i in places]
    weighted = [[v * (a == b) for b in range(len(signs))] for a, v in enumerate(signs)]
    last = [rows[k] for rows in (sigma, phi) for k, _ in places]
    less = [(P, after), *[(weighted, last)] * bool(places), *views(forms, samples)]
    padded = [[P[i][j] if i < order else ZERO for j in range(i + 1)] for i in range(N)]
    falls = remaining(padded, less)
    stable = f"the loop with the least slopes, {', '.join(map(str, lower))}: all eigenvalues are strictly inside"
    residue = {}
    if zero:
        need(rate is None, "with a rate an eigenvalue 1 is not covered", exact.Critical)
        falls = at_rest(falls, H, lower, zero[0], samples)
        residue["residue"] = rested(zero[0])
        if start is None:
            settling(H, asked, forms, bounds, P, zero[0])
            stable += f" but {rests}, which are 1"
    need(positive(falls), "the inequality of P fails, or is undecided")
    if start is not None:
        need(positive(remaining(padded[:order], views(start, samples - 1))), "V > 0 fails, or is undecided")
        stable = f"V less the forms at the start is positive definite (order {order})"
    cones = f"the forms are positive on every order cone of {samples} samples of each channel and 0"
    if not ordering:
        cones = f"the forms of {samples} samples are nonnegative: signs, and sums of rows and columns"
    facts = {
        "stable": stable,
        "cones": cones,
        "inequality": f"the matrix of order {N} is positive definite: V falls",
        "well-posed": "sigma is given channel after channel: D has no cycle",
    }
    return facts | residue, existing(asked)


def signals(H: Plant, samples: int) -> tuple[Rows, Rows, Rows]:
    """Rows of ``phi`` and ``sigma``, sample after sample, and of ``xi+``, in ``(x_1, phi_1, .., phi_T)``."""
    n, m = len(H.A), len(H.D)
    N = n + m * samples
    phi = [[Fraction(i == n + j) for i in range(N)] for j in range(m * samples)]
    x, after, sigma = [[Fraction(i == j) for i in range(N)] for j in range(n)], Rows(), Rows()
    for t in range(samples):
        x = [*x, *([-v for v in row] for row in phi[m * t : m * (t + 1)])]  # (x, mu)
        sigma += [[dot(row, column) for column in zip(*x)] for row in ([*c, *d] for c, d in zip(H.C, H.D))]
        x = [[dot(row, column) for column in zip(*x)] for row in ([*a, *b] for a, b in zip(H.A, H.B))]
        after = after or [*x, *phi[m:]]
    return phi, sigma, after


def at_rest(M: Any, H: Plant, low: list[Fraction], zero: Any, samples: int = 1) -> Any:
    """The form of a lower triangle ``M`` on a complement of equilibria ``(x, phi)``, ``phi = L sigma``, where it is 0.

    These have different ``sigma``, and each its own ``x_p = 1``, 0 for the others: without these ``x_p`` the
    form is positive definite if and only if it is so modulo the equilibria.  ``phi`` stands in ``M`` once a sample.
    """
    n, m = len(H.A), len(H.D)
    form(isinstance(zero, list) and 0 < len(zero) <= m, f"zero is a list of 1 to {m} vectors")
    vectors = [numbers(v, n + m) for v in zero]
    pivots = [next((i for i, c in enumerate(v) if c), n) for v in vectors]
    outputs = [[dot(row, v) for row in seen(H)] for v in vectors]
    alone = all(p < n and v[p] == (i == j) for i, p in enumerate(pivots) for j, v in enumerate(vectors))
    need(alone, "the equilibria of zero are not in echelon form")
    for v, sigma in zip(vectors, outputs):
        tick()
        still = [dot(row, v) == (c if H.discrete else 0) for row, c in zip(moved(H), v)]
        need(all(still) and v[n:] == [l * s for l, s in zip(low, sigma)], "a vector of zero is no equilibrium")
        v = v[:n] + v[n:] * samples
        flat = (sum(M[max(i, j)][min(i, j)] * c for j, c in enumerate(v) if c) for i in range(len(M)))
        need(not any(flat), "V' does not vanish at an equilibrium of zero")
    need(
        rank([*outputs, *([ZERO] * m for _ in range(m - len(outputs)))]) == len(outputs), "sigma does not see them all"
    )
    return [[v for j, v in enumerate(row) if j not in pivots] for i, row in enumerate(M) if i not in pivots]


def rested(zero: Any) -> str:
    """What :func:`at_rest` shows, in words."""
    return f"the form is 0 at {len(zero)} independent equilibria with phi = L sigma, all seen by sigma"


def settling(H: Plant, asked: Channels, forms: list[Form], bounds: Any, P: Rows, zero: Any) -> None:
    """Beside eigenvalues 1, for forms summed over time: what makes the loop with ``l sigma + tau w sigma`` stable.

    On the equilibria ``V > 0``, and ``sum u' M_uv v > 0`` over the samples for ``u = v = w sigma``: with ``x_0+ = x_0 -
    tau R x_0`` the former is ``P_0``, the latter, as ``M_vv = 0``, ``He P_0 R``.  So for small ``tau > 0`` the
    inequality holds strictly for slopes from ``l + tau w`` on, and ``sum |x_1|^2 + |phi|^2`` is bounded by one number
    for all ``tau``.
    """
    need(not asked.operators, "beside forms summed over time and an eigenvalue 1 there is an operator", exact.Critical)
    for i, one in each(asked):
        rising = bounds[i][0] <= one.slope[0] and not one.varying
        need(rising, f"beside an eigenvalue 1 channel {i + 1} has no lower bound of its slope", exact.Critical)
    n, vectors = len(H.A), [numbers(v, len(H.A) + len(H.D)) for v in zero]
    whole = [v[:n] + v[n:] * ((len(P) - n) // len(H.D)) for v in vectors]
    wide = [[(h - l) * dot(row, v) for row, (l, h) in zip(seen(H), bounds)] for v in vectors]
    moves = [[ZERO] * len(vectors) for _ in vectors]
    for channels, M in forms:
        p, turns = len(M) // 2, [[v[i] for i in channels] * (len(M) // 2 // len(channels)) for v in wide]
        for i, a in enumerate(turns):
            for j, b in enumerate(turns):
                moves[i][j] += sum(x * dot(row[p:], b) for x, row in zip(a, M))
        need(not any(v for row in M[p:] for v in row[p:]), "beside an eigenvalue 1 a form has v'M v", exact.Critical)
    energy = [[dot(a, [dot(row, b) for row in P]) for b in whole] for a in whole]
    need(positive(energy), "V > 0 fails at an equilibrium", exact.Critical)
    both = [[v + moves[j][i] for j, v in enumerate(row)] for i, row in enumerate(moves)]
    need(positive(both), "the forms do not move every equilibrium", exact.Critical)


def positive(M: Rows) -> bool:
    """Whether the matrix of a lower triangle is positive definite."""
    q = states.unit(M)
    return positive_definite([[int(q * v) for v in row[: i + 1]] for i, row in enumerate(M)])


def remaining(lower: Rows, less: list[tuple[Rows, Rows]]) -> Rows:
    """The lower triangle of a matrix less ``view' M view`` for each pair."""
    for M, view in less:
        columns = [*zip(*view)][: len(lower)]
        turned = [[dot(row, column) for row in M] for column in columns]
        lower = [[v - dot(turned[i], columns[j]) for j, v in enumerate(row)] for i, row in enumerate(lower)]
    return lower

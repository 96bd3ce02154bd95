"""Several nonlinearities in continuous time, decided over all frequencies by one polynomial: part of the checker.

Standard library only.  Polynomials in ``s = i omega`` are lists of coefficients, ascending; ``p(-s)`` is the conjugate.
Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import product
from math import factorial
from typing import Any, NamedTuple

from . import arithmetic as exact
from .arithmetic import ZERO, eliminated, fields, form, integer, need, number, numbers, tick
from .balls import dot, positive_definite
from .states import unit

MOST_CHANNELS, MOST_KERNELS = 8, 400
RISE, FALL = (0, 10041, 4751, 1133), (10000, 8563, 3183, 561)  # of |e^(-i x t) - 1|: m(s) = RISE/FALL, ascending
Rows = list[list[Fraction]]


class Kernel(NamedTuple):
    """``coefficient h`` in row ``i``, column ``j``, taken from ``M``: ``h^(s) = (rate/(rate + side s))^order``."""

    row: int
    column: int
    coefficient: Fraction
    rate: Fraction
    order: int
    side: int  # 1: causal, -1: anticausal


class Multiplier(NamedTuple):
    """``M(s) + s Theta``, ``M = Gamma - sum of kernels``: ``M`` acts on ``b``, against ``a``; ``s Theta`` on sigma.

    ``a_i = phi_i - l_i sigma_i`` and ``b_i = u_i sigma_i - phi_i``, the bounds being those of the slope for channels of
    ``moved``, of which ``M`` takes more than the value at one time.
    """

    gamma: Rows
    theta: list[Fraction]
    kernels: list[Kernel]

    @property
    def moved(self) -> set[int]:
        """Channels with kernels, or with entries beside the diagonal."""
        beside = {x for i, row in enumerate(self.gamma) for j, v in enumerate(row) if v and i != j for x in (i, j)}
        return beside | {x for k in self.kernels for x in (k.row, k.column)}


def multiplier(name: str, data: Any, m: int) -> Multiplier:
    """The multiplier of a certificate."""
    if name in ("diagonal-circle", "diagonal-popov"):
        weights, *rest = fields(data, "lambda", *["theta"] * (name == "diagonal-popov"))
        gamma = [[v if i == j else ZERO for j in range(m)] for i, v in enumerate(numbers(weights, m))]
        return Multiplier(gamma, numbers(rest[0], m) if rest else [ZERO] * m, [])
    need(name in ("matrix-zames-falb", "matrix-scalings"), f"{name!r:.40} is not proved by a determinant")
    gamma, theta, listed = fields(data, "gamma", "theta", "kernels")
    form(all(isinstance(x, list) for x in (gamma, listed)) and len(gamma) == m, "gamma has one row for each channel")
    form(len(listed) <= MOST_KERNELS, "there are too many kernels")
    found = []
    for item in listed:
        where, c, rate, order, side = fields(item, "channels", "coefficient", "rate", "order", "side")
        form(isinstance(where, list) and len(where) == 2, "a kernel has a row and a column")
        form(side in ("causal", "anticausal"), "a kernel is causal or anticausal")
        i, j = (integer(x, 1, m) - 1 for x in where)
        kernel = Kernel(i, j, number(c), number(rate), integer(order, 1, 20), 1 if side == "causal" else -1)
        form(kernel.rate > 0, "a kernel has a rate > 0")
        found.append(kernel)
    return Multiplier([numbers(row, m) for row in gamma], numbers(theta, m), found)


def dominant(
    given: Multiplier,
    odd: Any,
    blocks: Iterable[Iterable[int]],
    gains: Any,
    operators: Any = (),
    rate: Fraction = ZERO,
    turns: Any = (),
) -> None:
    """The conditions on ``M``: no kernel between different nonlinearities; doubly dominant; signs unless they are odd.

    With ``Phi_i' = a_i b_i'``, ``a_i(x) b_j(y) <= a_i(x) b_i(x) - Phi_i(x) + Phi_j(y)`` where ``i`` and ``j`` have one
    nonlinearity, and ``Phi_i, a_i b_i - Phi_i >= 0``.  So a kernel ``>= 0`` of mass ``c`` between ``i`` and ``j`` takes
    at most ``c`` times the integral of ``a_i b_i - Phi_i`` and of ``Phi_j``: what rows and columns add up to is paid by
    ``gamma_ii`` of ``a_i b_i``.  For odd ones the same with ``-y``.  Where ``gains`` says so ``phi_i`` is a constant
    gain ``g`` on its block ``b``, ``a_b^* M_bb b_b = (g - l)(u - g) sigma_b^* M_bb sigma_b``, and ``He M_bb > 0`` is
    enough.  For ``operators``, each its channels and whether it is one scalar ``delta`` in all of these:
    :func:`scaling`.

    With a ``rate r`` the signals are weighed by ``e^(r t)``, and of a kernel ``a_i b_i - Phi_i`` pays ``c h^(r)``,
    ``Phi_j`` pays ``c h^(-r)``; ``theta_i`` gives the first ``theta_i r/w_i``, one of ``turns``, and takes as much from
    the second.  docs/theory/rates.md.
    """
    for channels, alike in operators:
        scaling(given, channels, alike)
    joint = {i for channels, _ in operators for i in channels}
    m, block = len(given.gamma), {i: tuple(one) for one in blocks for i in one}
    free = {i for i in range(m) if gains[i] and hermitian_part(given, block[i])}
    rows, columns = [ZERO] * m, [ZERO] * m
    beside = [
        Kernel(i, j, -v, ZERO, 0, 1) for i, row in enumerate(given.gamma) for j, v in enumerate(row) if i != j and v
    ]
    for i, j, c, a, n, side in [*beside, *given.kernels]:
        need(j in block[i], f"channels {i + 1} and {j + 1} have different nonlinearities, and M has an entry for both")
        need(i in joint or c >= 0 or odd[i], f"M has a kernel below 0 for channel {i + 1}, which need not be odd")
        need(not n or a > abs(rate), "a kernel does not decay faster than the rate")
        first, second = ((a / (a + side * r)) ** n if n else 1 for r in (rate, -rate))
        rows[i], columns[j] = rows[i] + abs(c) * first, columns[j] + abs(c) * second
    for i in (i for i in range(m) if i not in free and i not in joint):
        turn = turns[i] if turns else ZERO
        most, gain = max(rows[i] - turn, columns[i] + turn), given.gamma[i][i]
        beyond = f", and He M > 0 fails for the gain of channel {i + 1}" * bool(gains[i])
        need(
            gain >= most, f"gamma_{i + 1}{i + 1} = {gain} is less than the kernels of its row or column, {most}{beyond}"
        )


def hermitian_part(given: Multiplier, channels: Iterable[int]) -> bool:
    """Whether ``M + M^* > 0`` on ``[0, inf]`` in the rows and columns of these channels, or ``M = 0`` there."""
    own = list(channels)
    place = {i: k for k, i in enumerate(own)}
    inside = [k for k in given.kernels if k.row in place and k.column in place]
    kernels = [k._replace(row=place[k.row], column=place[k.column]) for k in inside]
    q, M = entries(Multiplier([[given.gamma[i][j] for j in own] for i in own], [], kernels))
    if not any(any(f) for row in M for f in row):
        return True
    r = len(own)
    listed, _ = whole([total(M[i][j], conjugate(M[j][i])) for i in range(r) for j in range(r)])
    F = [listed[r * i : r * (i + 1)] for i in range(r)]
    p = exact.primitive(in_square(determinant(F)))
    still = positive_definite([[f[0] for f in row[: i + 1]] for i, row in enumerate(F)])
    return still and len(p) == r * (len(in_square(q)) - 1) + 1 and exact.positive(p)


def scaling(given: Multiplier, channels: Iterable[int], alike: bool) -> None:
    """``M = M^* > 0`` at all frequencies on the channels of an operator of norm up to ``u = -l``, and 0 beside them.

    ``Re a_b^* M b_b`` is ``(u^2 - |delta|^2) sigma_b^* M sigma_b`` for one scalar ``delta`` in all of its channels,
    ``alike``; else ``M`` has to be a multiple of 1: ``d (u^2 |sigma_b|^2 - |mu_b|^2)``.
    """
    own = set(channels)
    apart = [(i, j) for i, row in enumerate(given.gamma) for j, v in enumerate(row) if v and i != j]
    apart += [(k.row, k.column) for k in given.kernels if k.row != k.column]
    need(all(own.isdisjoint(pair) or (alike and own.issuperset(pair)) for pair in apart), "M couples an operator")
    each = {i: sorted(k[2:] for k in given.kernels if k.row == i == k.column) for i in own}
    one = alike or len({(given.gamma[i][i], *each[i]) for i in own}) == 1
    inside = [k for k in given.kernels if k.row in own]
    turned = sorted((j, i, c, a, n, -side) for i, j, c, a, n, side in inside)
    symmetric = all(given.gamma[i][j] == given.gamma[j][i] for i in own for j in own)
    need(
        one and symmetric and sorted(map(tuple, inside)) == turned,
        "M is no real multiple of 1, or M = M^* fails, for an operator",
    )
    need(hermitian_part(given, sorted(own)), "M > 0 fails for an operator")


def proved(H: Any, given: Multiplier, bounds: Any, outer: Any = ()) -> dict[str, str]:
    r"""``F = He [M (1 + W H) + s Theta H] > 0`` on ``[0, inf]`` after the shift by ``l``, and a stable loop there.

    Eigenvalues 0 of that loop are covered where :func:`residue` says so; ``F`` has a limit at 0 then.  ``det F`` times
    positive polynomials has no root, its full degree, and ``F(0)`` is positive definite.
    """
    n, m = len(H.A), len(H.D)
    need(m <= MOST_CHANNELS, f"determinants are taken up to {MOST_CHANNELS} channels")
    width = [u - l for l, u in bounds]
    d, N = transfer(*shifted(H, [l for l, _ in bounds]))
    zeros, N, found = residue(d, N, given, width, outer)
    own, d = d[zeros:], d[max(zeros - 1, 0) :]
    stable = exact.hurwitz(exact.homogeneous([Fraction(c) for c in own[::-1]], exact.S, exact.real(1), n - zeros))
    need(stable, "the loop with the gains at the lower bounds is not asymptotically stable")
    F, full = inequality(d, N, given, width)
    if zeros:  # over omega^2, as |d|^2 is
        need(not any(any(f[:2]) for row in F for f in row), "F has a pole at 0")
        F, full = [[[-c for c in f[2:]] for f in row] for row in F], full - 1
    need(positive_definite([[f[0] for f in row[: i + 1]] for i, row in enumerate(F)]), "F(0) > 0 fails")
    p, square = in_square(determinant(F)), in_square(times(own, conjugate(own)))
    for _ in range(m - 1):  # of |d|^2, of which every entry has one, det F keeps one
        p = quotient(p, square)
    p = exact.primitive(p)
    need(len(p) == full + 1, "F > 0 fails in the limit of high frequencies")
    need(exact.positive(p), "F > 0 fails at some frequency")
    rest = "is asymptotically stable" if not zeros else "has all other eigenvalues in the open left half-plane"
    return {
        "stable": f"the loop with the gains at the lower bounds {rest} (order {n - zeros})",
        "inequality": f"F(0) > 0, and det F, of degree {full} in omega^2, has no root in [0, inf]",
    } | found


def residue(
    d: list[int], N: Any, given: Multiplier, width: list[Fraction], outer: Any
) -> tuple[int, Any, dict[str, str]]:
    """How many roots ``r`` of ``d`` are 0, ``N/s^(r - 1)``, and what was found of ``R = lim s H``.

    ``M(0) W R`` is symmetric, with ``r`` positive eigenvalues and else 0.  So 0 is semisimple, its modes ``x_0' = B_0
    mu`` are moved and seen, ``R = C_0 B_0``, and ``P_0 B_0 = C_0' W M(0)'`` has a solution ``P_0 > 0``: for constant
    ``M`` a part of ``V``, whose derivative is ``2 mu' M(0) W C_0 x_0``.  With kernels ``He M(0) > 0`` is needed too,
    and that the ``outer`` channels, from ``z`` to ``w``, neither move nor see these modes.
    """
    r, m = next(i for i, c in enumerate(d) if c), len(N)
    if not r:
        return 0, N, {}
    M = [list(row) for row in given.gamma]
    for kernel in given.kernels:  # h(0) = 1
        M[kernel.row][kernel.column] -= kernel.coefficient
    both = [[M[i][j] + M[j][i] for j in range(i + 1)] for i in range(m)]
    q = unit(both)
    strict = not given.moved or positive_definite([[int(q * v) for v in row] for row in both])
    need(strict, "He M(0) > 0 fails", exact.Critical)
    need(not any(any(f[: r - 1]) for row in N for f in row), "H has a pole of higher order at 0", exact.Critical)
    N = [[f[r - 1 :] for f in row] for row in N]
    apart = not given.moved or not any(N[i][j][0] or N[j][i][0] for i in outer for j in range(m))
    need(apart, "beside kernels w moves, or z sees, an eigenvalue 0", exact.Critical)
    S = [[sum(M[i][k] * width[k] * N[k][j][0] for k in range(m)) / d[r] for j in range(m)] for i in range(m)]
    return r, N, signed(S, r, "M(0)" if given.moved else "Lambda")


def signed(S: Rows, r: int, name: str) -> dict[str, str]:
    """That ``S = name W lim s H`` is symmetric, with ``r`` positive eigenvalues, the others 0."""
    m, (p, _, _) = len(S), resolvent(S, [], [])
    positive = all(c * (-1) ** k > 0 for k, c in enumerate(p[: r + 1])) and not any(p[r + 1 :])
    symmetric = all(S[i][j] == S[j][i] for i in range(m) for j in range(i))
    need(symmetric, f"{name} W lim s H(s) is not symmetric", exact.Critical)
    need(r <= m and positive, f"{name} W lim s H(s) has not {r} positive eigenvalues, the others 0", exact.Critical)
    return {"residue": f"{name} W lim s H(s) is symmetric, with {r} positive eigenvalues and else 0"}


def solvable(H: Any, inside: bool, bounds: Any) -> str:
    """Why ``sigma + tau D phi(sigma) = y``, after the shift, has one solution for every ``tau`` in ``[0, 1]``.

    ``det(1 + D G)`` is affine in each gain: positive at the vertices of the slopes, it is so for all difference
    quotients; then ``sigma + D phi`` is one to one and proper, hence onto, its inverse Lipschitz.
    """
    need(inside, "D has a cycle of channels, and the slopes are not within the bounds")
    _, _, _, D = shifted(H, [l for l, _ in bounds])
    for ends in product(*((ZERO, u - l) for l, u in bounds)):
        whole = [[[(i == j) + v * g] for j, (v, g) in enumerate(zip(row, ends))] for i, row in enumerate(D)]
        need(determinant(whole)[0] > 0, "det(1 + D G) vanishes for some gains within the bounds", exact.IllPosed)
    return f"det(1 + D G) > 0 at the {2 ** len(D)} vertices of the slopes"


# -- the loop after the shift by the lower bounds
def shifted(H: Any, low: list[Fraction]) -> tuple[Rows, Rows, Rows, Rows]:
    """``A - B L C~``, ``B (1 - L D~)``, ``C~`` and ``D~``, where ``(C~, D~) = (1 + D L)^-1 (C, D)``."""
    n = len(H.A)
    if not any(low):
        return H.A, H.B, H.C, H.D
    left = [[(i == j) + v * low[j] for j, v in enumerate(row)] for i, row in enumerate(H.D)]
    seen = eliminated(left, [[*c, *d] for c, d in zip(H.C, H.D)])
    if seen is None:
        raise exact.IllPosed("the loop is not well posed at the lower bounds")
    back = [[l * v for v in row] for l, row in zip(low, seen)]
    moved = [[v - dot(b, column) for v, column in zip([*a, *b], zip(*back))] for a, b in zip(H.A, H.B)]
    return [row[:n] for row in moved], [row[n:] for row in moved], [row[:n] for row in seen], [row[n:] for row in seen]


def resolvent(A: Rows, B: Rows, C: Rows) -> tuple[list[int], int, list[Rows]]:
    """``p``: ``det(s - q A) = sum p_k s^(n - k)``, ``q``, and ``C X_k B``: ``adj(s - q A) = sum X_k s^(n - 1 - k)``.

    By Faddeev and Leverrier, in integers.
    """
    need(len(A) <= 60, "characteristic polynomials are formed up to order 60")
    n, (a, q), (b, left), (c, right) = len(A), whole(A), whole(B), whole(C)
    X, p, found = [[0] * n for _ in range(n)], [1], list[Rows]()
    for k in range(1, n + 1):
        tick()
        X = [[dot(row, column) + p[-1] * (i == j) for j, column in enumerate(zip(*X))] for i, row in enumerate(a)]
        XB = [[dot(row, column) for column in zip(*b)] for row in X]
        found.append([[Fraction(dot(row, column), left * right) for column in zip(*XB)] for row in c])
        p.append(-sum(dot(row, [X[h][i] for h in range(n)]) for i, row in enumerate(a)) // k)
    return p, q, found


def whole(rows: Any) -> tuple[list[list[int]], int]:
    """The rows times their common denominator, and that."""
    a = unit(rows)
    return [[v.numerator * (a // v.denominator) for v in row] for row in rows], a


def transfer(A: Rows, B: Rows, C: Rows, D: Rows) -> tuple[list[int], list[list[list[Fraction]]]]:
    """``d`` and ``N`` with ``C (s - A)^-1 B + D = N/d``, ``d = det(s - A)`` times a positive number."""
    p, q, seen = resolvent(A, B, C)
    n, d = len(A), [q**i * c for i, c in enumerate(reversed(p))]
    m = len(D[0])
    terms = [[[q ** (i + 1) * seen[n - 1 - i][h][j] for i in range(n)] for j in range(m)] for h in range(len(D))]
    return d, [[total([D[i][j] * c for c in d], f) for j, f in enumerate(row)] for i, row in enumerate(terms)]


def entries(given: Multiplier) -> tuple[list[Fraction], list[list[list[Fraction]]]]:
    """``q = prod (a^2 - s^2)^n > 0`` and ``q M``."""
    top = dict[Fraction, int]()
    for kernel in given.kernels:
        top[kernel.rate] = max(kernel.order, top.get(kernel.rate, 0))

    def below(rate: Fraction = ZERO, order: int = 0) -> list[Fraction]:
        """``q`` over ``(rate^2 - s^2)^order``."""
        factors = ([a * a, ZERO, Fraction(-1)] for a, n in top.items() for _ in range(n - order * (a == rate)))
        return chained(factors)

    q = below()
    M = [[[v * c for c in q] for v in row] for row in given.gamma]
    lags = dict[tuple[Fraction, int, int], list[Fraction]]()
    for i, j, c, a, n, side in given.kernels:  # (a/(a + side s))^n = a^n (a - side s)^n/(a^2 - s^2)^n
        if (a, n, side) not in lags:
            lags[a, n, side] = [a**n * v for v in times(chained([[a, Fraction(-side)]] * n), below(a, n))]
        M[i][j] = total(M[i][j], [-c * v for v in lags[a, n, side]])
    return q, M


def inequality(d: list[int], N: Any, given: Multiplier, width: list[Fraction]) -> tuple[list[list[list[int]]], int]:
    """``F`` times ``2 |d|^2 q`` and a number, ``q = prod (a^2 - s^2)^n > 0``; degree of ``det F`` in ``omega^2``."""
    m, (common, entry) = len(N), entries(given)
    (d, *lists), _ = whole([d, *(f for row in N for f in row)])  # in integers: each factor times its denominator
    (q, *kernels), _ = whole([common, *(f for row in entry for f in row)])
    N, M = ([side[m * i : m * (i + 1)] for i in range(m)] for side in (lists, kernels))
    ([wide], one), ([turns], same) = whole([width]), whole([given.theta])
    G = [
        [total([w * c for c in f], [one * c for c in d] if i == j else []) for j, f in enumerate(row)]
        for i, (w, row) in enumerate(zip(wide, N))
    ]  # d (1 + W H)
    Y = [
        [
            total(
                *(times([same * c for c in M[i][k]], G[k][j]) for k in range(m) if any(M[i][k])),
                [one * t * c for c in times([0, *q], N[i][j])] if t else [],
            )
            for j in range(m)
        ]
        for i, t in enumerate(turns)
    ]
    Z = [[times(y, conjugate(d)) for y in row] for row in Y]
    F = [[total(Z[i][j], conjugate(Z[j][i])) for j in range(m)] for i in range(m)]
    return F, len(d) - 1 + m * (len(q) - 1) // 2


# -- polynomials in s
def times(p: Any, q: Any) -> list[Any]:
    """The product."""
    tick()
    out = [0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        if a:
            for j, b in enumerate(q):
                out[i + j] += a * b
    return out


def total(*terms: Any) -> list[Any]:
    """The sum."""
    return [sum(p[i] for p in terms if i < len(p)) for i in range(max(map(len, terms)))]


def chained(factors: Iterable[Any]) -> list[Any]:
    """The product of all."""
    out = [Fraction(1)]
    for factor in factors:
        out = times(out, factor)
    return out


def conjugate(p: Any) -> list[Any]:
    """``p(-s)``."""
    return [-c if i % 2 else c for i, c in enumerate(p)]


def in_square(p: Any) -> list[Any]:
    """An even polynomial in ``s`` as one in ``omega^2 = -s^2``."""
    return [-c if i % 2 else c for i, c in enumerate(p[::2])]


def determinant(F: Any) -> list[Any]:
    """Of a matrix of polynomials, row by row: for every set of columns the minor of the rows so far."""
    minors = {0: [1]}
    for row in F:
        wider = dict[int, list[Any]]()
        for columns, p in minors.items():
            for j, f in enumerate(row):
                if not columns >> j & 1 and any(f):
                    sign = -1 if (columns >> j).bit_count() % 2 else 1
                    more = times(p, [sign * c for c in f])
                    wider[columns | 1 << j] = total(wider.get(columns | 1 << j, []), more)
        minors = wider
    return minors.get(2 ** len(F) - 1, [0])


def quotient(p: Any, q: Any) -> list[Fraction]:
    """``p/q``, which must be a polynomial."""
    rest, out = [Fraction(c) for c in p], list[Fraction]()
    while rest and not rest[-1]:
        rest.pop()
    while len(rest) >= len(q):
        tick()
        out.append(rest[-1] / q[-1])
        low = len(rest) - len(q)
        rest = [c - (out[-1] * q[i - low] if i >= low else 0) for i, c in enumerate(rest[:-1])]
    need(not any(rest), "det F has another denominator")
    return out[::-1]


def majorised() -> None:
    """``|m(i x)|^2 >= sup_(t <= x) |e^(-i t) - 1|^2``: ``2 - 2 cos x`` up to ``pi``, 4 beyond; ``p`` in ``x^2``.

    ``2 - 2 cos x <= sum_(k <= 11) (-1)^(k + 1) 2 x^(2k)/(2k)!``, the last term being positive; ``9.8 < pi^2 < 10``.
    """
    top, low = (in_square(times(p, conjugate(p))) for p in map(list, (RISE, FALL)))
    cosine = [ZERO, *(Fraction(2 * (-1) ** (k + 1), factorial(2 * k)) for k in range(1, 12))]
    near, far = total(top, [-v for v in times(cosine, low)]), total(top, [-4 * v for v in low])
    need(exact.positive(exact.primitive(near[1:]), ZERO, Fraction(10)), "the majorant fails up to pi")
    need(exact.positive(exact.primitive(far), Fraction(49, 5)), "the majorant fails beyond pi")

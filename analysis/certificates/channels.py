"""Several nonlinearities, one in each channel of a plant with as many inputs as outputs: part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate, pairwise, product
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import frequencies, states
from .arithmetic import INF, ZERO, S, eliminated, fields, form, integer, need, number, numbers, real, tick
from .balls import dot, positive_definite

MOST_STATES, MOST_CHANNELS = 200, 50
ONE_SOLUTION = "sigma + D phi(sigma) = y has exactly one solution sigma for every y"
MOST_VERTICES, MOST_STEPS = 10, 1000
THEOREMS = {  # whether with full-block multipliers, and whether with Popov's terms
    "diagonal-circle": (False, False),
    "diagonal-popov": (False, True),
    "full-block-circle": (True, False),
    "full-block-popov": (True, True),
}
Rows = list[list[Fraction]]


class Plant(NamedTuple):
    """``x' = A x + B mu``, ``sigma = C x + D mu`` (or ``x+``), ``mu_i = -phi_i(sigma_i)``."""

    A: Rows
    B: Rows
    C: Rows
    D: Rows
    discrete: bool


class Channels(NamedTuple):
    """The class of each channel, and the channels of each nonlinearity."""

    families: list[states.Family]
    blocks: list[range]

    def bounds(self, i: int) -> tuple[Any, Any]:
        """Bounds of ``phi_i(sigma)/sigma``: those of the sector and, as ``phi_i(0) = 0``, those of the slope."""
        sector, slope = self.families[i].sector, self.families[i].slope
        return max(sector[0], slope[0]), min(sector[1], slope[1])


def plant(system: Any) -> Plant:
    """The plant of a certificate."""
    kind, domain, *sides = fields(system, "kind", "time", "A", "B", "C", "D")
    form(kind == "multivariable" and domain in ("continuous", "discrete"), "the system is of no kind for channels")
    form(all(isinstance(side, list) and side for side in sides), "A, B, C and D are lists of rows")
    n, m = len(sides[0]), len(sides[3])
    form(n <= MOST_STATES and m <= MOST_CHANNELS, "there are too many states or channels")
    form([len(side) for side in sides] == [n, n, m, m], "A, B, C and D do not fit, or inputs and outputs differ")
    A, B, C, D = ([numbers(row, width) for row in side] for side, width in zip(sides, (n, m, n, m)))
    return Plant(A, B, C, D, domain == "discrete")


def channels(data: Any, m: int) -> Channels:
    """The classes of a certificate, one for each channel."""
    given, repeated = fields(data, "channels", "repeated")
    form(isinstance(given, list) and len(given) == m, f"{m} classes are needed, in order")
    sizes = ([m] if repeated else [1] * m) if type(repeated) is bool else repeated
    form(isinstance(sizes, list), "repeated is true, false, or how many channels in turn have the same nonlinearity")
    ends = list(accumulate(integer(size, 1, m) for size in sizes))
    form(ends[-1:] == [m], f"the channels with the same nonlinearity do not add up to {m}")
    blocks = [range(end - size, end) for end, size in zip(ends, sizes)]
    families = [states.classes(one) for one in given]
    same = all(given[i] == given[block[0]] for block in blocks for i in block)
    form(same, "a repeated nonlinearity has one class")
    return Channels(families, blocks)


def examined(
    verdict: str, name: str, data: Any, system: Any, given: Any, phi: Any, proof: Any
) -> tuple[bool, int, dict[str, str], str]:
    """Whether it is a proof, and what follows; 0: 0 attracts, 1: one moves on, 2: other equilibria, 3: no loop.

    And how every hypothesis was found to hold, and what is assumed.
    """
    asked = channels(given, len(plant(system).D))
    need(phi is None, "no nonlinearity is given beside several classes")
    facts = {"class": described(asked)}
    if verdict == "PROVED":
        found, assumed = proved(name, data, system, asked, proof)
        return True, 0, facts | found, assumed
    need((name, data) == ("counterexample", {}), "a refutation is a counterexample")
    end, found = refuted(system, asked, proof)
    return False, end, facts | found, ""


def described(asked: Channels) -> str:
    """The classes in words."""
    words = "; ".join(f"channel {i}: {states.described(family)}" for i, family in enumerate(asked.families, 1))
    same = [f"{block[0] + 1} to {block[-1] + 1}" for block in asked.blocks if len(block) > 1]
    if len(asked.blocks) == 1 and same:
        return f"{words}; one nonlinearity in all channels"
    return "".join([words, *(f"; one nonlinearity in the channels {channels}" for channels in same)])


def ordered(D: Rows) -> bool:
    """Whether the channels can be taken one after the other, each ``sigma_i`` given by those before it."""
    left = set(range(len(D)))
    while free := {i for i in left if not any(D[i][j] for j in left)}:
        left -= free
    return not left


def well_posed(D: Rows, asked: Channels) -> tuple[str, str]:
    """Why the loop has a solution and what is assumed for it; the inequality holds at ``x = 0``.

    There ``sum lambda_i (phi_i - l_i sigma_i)(u_i sigma_i - phi_i) < 0`` for ``sigma = -D phi != 0``.  Differences of
    two solutions of ``sigma + D phi(sigma) = y`` would satisfy the opposite if the slopes lie in ``[l_i, u_i]``; with
    ``y`` not equal too, ``|phi - phi'| <= K |y - y'|``: ``sigma`` is unique, Lipschitz in ``y``, and exists as a proper
    injective continuous map of ``R^m`` is onto (Brouwer).
    """
    if ordered(D):
        return "sigma is given channel after channel: D has no cycle", ""
    inside = (
        asked.bounds(i)[0] <= family.slope[0] and family.slope[1] <= asked.bounds(i)[1] for i, family in _each(asked)
    )
    if all(inside):
        return "the inequality at x = 0 bounds differences of solutions, the slopes being in the same bounds", ""
    return "the inequality at x = 0 shows det(1 + D G) != 0 for the gains of the class", ONE_SOLUTION


def _each(asked: Channels) -> Any:
    return enumerate(asked.families)


def proved(name: str, data: Any, system: Any, asked: Channels, proof: Any) -> tuple[dict[str, str], str]:
    """The circle criterion, or Popov's, with diagonal or full-block multipliers: what was found, and what is assumed.

    ``V = x'Px + 2 sum theta_i int_0^sigma_i phi_i`` is positive definite, and ``V' + (sigma, phi)' Pi (sigma, phi)``
    (discrete: the difference of ``V``) negative definite in ``(x, phi)``, where the form of ``Pi`` is nonnegative.
    """
    H = plant(system)
    if name == "constant-gains":
        fields(data)
        return gain_box(H, asked, *fields(proof, "method", "tree")), ""
    if name == "order-cones":
        return lifted(H, data, asked, proof)
    if proof["method"] == "determinant":
        return over_frequencies(name, data, H, asked, proof)
    need(name in THEOREMS, f"there is no theorem {name!r:.40} for several nonlinearities")
    (full, popov), n, m = THEOREMS[name], len(H.A), len(H.D)
    parts = ["N"] * (full and isinstance(data, dict) and "N" in data)
    given, *turned = fields(data, "Pi" if full else "lambda", *["theta"] * popov, *parts)
    theta = numbers(turned[0], m) if popov else [ZERO] * m
    need(not (popov and H.discrete), f"{name} is for continuous time")
    for i, family in _each(asked):
        need(INF not in map(abs, asked.bounds(i)), f"channel {i + 1} has no finite bounds")
        need(not family.rough, "locally Lipschitz nonlinearities are needed")
        need(not theta[i] or not family.varying, f"theta_{i + 1} needs a nonlinearity that does not depend on time")
        need(not theta[i] or not any(H.D[i]), f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone")
    method, rows, exponent = fields(proof, "method", "P", "exponent")
    form(method == "matrix", "several nonlinearities are proved by a matrix")
    P, q, whole = states.symmetric(rows, [*moved(H), *seen(H)], n)
    R, Z, e = whole[:n], whole[n:], integer(exponent, 0, 10**5)  # q (A, -B) and q (C, -D)
    bounds = [asked.bounds(i) for i in range(m)]
    Pi = full_block(given, turned[popov:], bounds) if full else diagonal(numbers(given, m), bounds)
    falls, above = inequality(P, (R, Z, q, e), Pi, theta, bounds, H.discrete)
    need(positive_definite(above), "V > 0 fails, or is undecided")
    need(positive_definite(falls), "the inequality of P fails, or is undecided")
    posed, assumed = well_posed(H.D, asked)
    V = "V = x^T P x + 2 sum theta_i int phi_i" if any(theta) else "V = x^T P x"
    facts = {
        "stable": f"{V} is positive definite (order {n})",
        "inequality": f"the matrix of order {n + m} is positive definite: V falls",
        "well-posed": posed,
    }
    return facts, assumed


def over_frequencies(name: str, data: Any, H: Plant, asked: Channels, proof: Any) -> tuple[dict[str, str], str]:
    """The frequency inequality of the circle criterion, Popov's or Zames and Falb's: what was found, and is assumed.

    With ``F > 0`` and a stable loop at the lower bounds there is a ``P`` for :func:`proved` where ``M`` is diagonal and
    constant (Kalman, Yakubovich, Popov).  In general ``int a'M b >= 0`` for every ``tau phi``, ``tau`` in ``[0, 1]``,
    after the shift, and ``F > 0`` bounds the solutions from ``tau = 0`` to ``tau = 1`` (Megretski, Rantzer).
    """
    fields(proof, "method")
    need(not H.discrete, f"{name} by a determinant is for continuous time")
    given = frequencies.multiplier(name, data, len(H.D))
    frequencies.dominant(given, [one.odd for one in asked.families], asked.blocks)
    bounds = [one.slope if i in given.moved else asked.bounds(i) for i, one in _each(asked)]
    for i, one in _each(asked):
        need(INF not in map(abs, bounds[i]), f"channel {i + 1} has no finite bounds")
        need(not one.rough, "locally Lipschitz nonlinearities are needed")
        constant = not given.theta[i] and i not in given.moved
        need(constant or not one.varying, f"channel {i + 1} needs a nonlinearity that does not depend on time")
        need(
            not (given.theta[i] and any(H.D[i])),
            f"theta_{i + 1} needs sigma_{i + 1} to be a function of the state alone",
        )
    facts = frequencies.proved(H, given, bounds)
    if name != "matrix-zames-falb":
        posed, assumed = well_posed(H.D, asked)
        return facts | {"well-posed": posed}, assumed
    inside = all(l <= x.slope[0] and x.slope[1] <= u for (l, u), x in zip(bounds, asked.families))
    return facts | {"well-posed": frequencies.solvable(H, inside, bounds)}, ""


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


def within(A: Rows, discrete: bool) -> bool:
    """Whether all eigenvalues are strictly inside, by Routh's array."""
    up, down = (real(1) + S, real(1) + exact.MINUS * S) if discrete else (S, real(1))
    inner = exact.homogeneous(characteristic(A), up, down, len(A))
    return len(exact.primitive(exact.ascending(inner))) == len(A) + 1 and exact.hurwitz(inner)


def moved(H: Plant) -> Rows:
    """Rows of ``(A, -B)``: ``x'`` (or ``x+``) from ``(x, phi)``."""
    return [[*a, *(-v for v in b)] for a, b in zip(H.A, H.B)]


def seen(H: Plant) -> Rows:
    """Rows of ``(C, -D)``: ``sigma`` from ``(x, phi)``."""
    return [[*c, *(-v for v in d)] for c, d in zip(H.C, H.D)]


def diagonal(weights: list[Fraction], bounds: Any) -> Rows:
    """``Pi`` of ``2 sum lambda_i (phi_i - l_i sigma_i)(u_i sigma_i - phi_i)``, ``lambda_i >= 0``."""
    need(min(weights) >= 0, "a weight lambda is negative")
    m = len(weights)
    Pi = [[ZERO] * 2 * m for _ in range(2 * m)]
    for i, (v, (l, u)) in enumerate(zip(weights, bounds)):
        Pi[i][i], Pi[i][m + i], Pi[m + i][i], Pi[m + i][m + i] = -2 * v * l * u, v * (l + u), v * (l + u), -2 * v
    return Pi


def full_block(given: Any, parts: Any, bounds: Any) -> Rows:
    """``Pi`` whose form is nonnegative for ``phi = Delta sigma``, ``Delta`` diagonal and within the bounds.

    At every vertex ``(1; Delta)' Pi (1; Delta) > 0``, and ``Pi`` has no entry > 0 on the diagonal of ``phi``: the form
    is concave in each ``Delta_ii``.  Or, with ``N``: ``phi_i - l_i sigma_i`` and ``u_i sigma_i - phi_i`` have one sign
    ``s_i``; times it both are ``y >= 0``, and the form in ``y`` less that of ``N``, entries ``>= 0``, is positive
    definite for all signs, up to a common one.
    """
    m = len(bounds)
    need(m <= MOST_VERTICES, f"full-block multipliers are for up to {MOST_VERTICES} channels")
    Pi = triangle(given, 2 * m)
    if not parts:
        need(max(Pi[m + i][m + i] for i in range(m)) <= 0, "Pi is not concave in each gain")
        for ends in product(*bounds):
            view = [[Fraction(i == j) for j in range(m)] for i in range(m)]
            definite(Pi, [*view, *([d * v for v in row] for d, row in zip(ends, view))], "at a vertex of the gains")
        return Pi
    form(
        isinstance(parts[0], list) and len(parts[0]) == 2 ** (m - 1), f"N has one part for each of {2 ** (m - 1)} signs"
    )
    for rest, part in zip(product((1, -1), repeat=m - 1), parts[0]):
        N, view = triangle(part, 2 * m), [[ZERO] * 2 * m for _ in range(2 * m)]
        need(min(map(min, N)) >= 0, "an entry of N is negative")
        for i, (sign, (l, u)) in enumerate(zip((1, *rest), bounds)):
            view[i][i] = view[i][m + i] = sign / (u - l)
            view[m + i][i], view[m + i][m + i] = sign * u / (u - l), sign * l / (u - l)
        definite(Pi, view, "for one of the signs", N)
    return Pi


def triangle(given: Any, order: int) -> Rows:
    """The symmetric matrix of a lower triangle."""
    form(isinstance(given, list) and len(given) == order, f"a lower triangle of order {order} is missing")
    half = [numbers(row, i + 1) for i, row in enumerate(given)]
    return [[half[max(i, j)][min(i, j)] for j in range(order)] for i in range(order)]


def definite(Pi: Rows, view: Rows, where: str, less: Any = None) -> None:
    """``view' Pi view``, less a matrix if there is one, is positive definite."""
    columns = [*zip(*view)]
    turned = [[dot(row, column) for row in Pi] for column in columns]
    inner = [[dot(row, column) for column in columns[: i + 1]] for i, row in enumerate(turned)]
    if less is not None:
        inner = [[v - w for v, w in zip(row, other)] for row, other in zip(inner, less)]
    q = states.unit(inner)
    need(positive_definite([[int(q * v) for v in row] for row in inner]), f"Pi is not positive definite {where}")


def inequality(P: Any, scaled: Any, Pi: Rows, theta: Any, bounds: Any, discrete: bool) -> tuple[Any, Any]:
    """Lower triangles of integers: of ``-V'`` less the form of ``Pi``, times ``2^e q^2 w``, and of a bound below ``V``.

    ``int phi_i >= min(theta_i l_i, theta_i u_i) sigma_i^2/(2 theta_i)``, whatever the sign of ``theta_i``.
    """
    R, Z, q, e = scaled
    n, m = len(P), len(Z)
    least = [min(t * l, t * u) for t, (l, u) in zip(theta, bounds)]
    w, N = states.unit([*Pi, theta, least]), n + m
    t, low = [int(w * v) for v in theta], [int(w * v) for v in least]
    PR = [[dot(row, column) for column in zip(*R)] for row in P]  # q P (A, -B)
    M = [[0] * (i + 1) for i in range(N)]
    for i in range(N):
        tick()
        for j in range(i + 1):
            if discrete:
                M[i][j] = (q * q * P[i][j] if i < n else 0) - sum(R[h][i] * PR[h][j] for h in range(n))
            else:
                M[i][j] = -q * ((PR[i][j] if i < n else 0) + (PR[j][i] if j < n else 0))
            M[i][j] *= w
    Y = [*Z, *([q * (i == n + h) for i in range(N)] for h in range(m))]  # q (sigma, phi)
    for y, row in zip(Y, Pi):
        tick()
        whole = [(int(w * v), other) for v, other in zip(row, Y) if v]
        side = [sum(v * other[j] for v, other in whole) << e for j in range(N)]  # of q w Pi (sigma, phi)
        for i in (i for i in range(N) if y[i]):
            M[i] = [v - y[i] * z for v, z in zip(M[i], side)]
    for h in (h for h in range(m) if t[h]):
        rate = [sum(Z[h][g] * R[g][i] for g in range(n)) for i in range(N)]  # q^2 sigma_h'
        for i in range(N):
            for j in range(i + 1):
                M[i][j] -= t[h] * ((i == n + h) * rate[j] + (j == n + h) * rate[i]) << e
    above = [
        [w * q * q * P[i][j] + (sum(low[h] * Z[h][i] * Z[h][j] for h in range(m)) << e) for j in range(i + 1)]
        for i in range(n)
    ]
    return M, above


def refuted(system: Any, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Gains ``mu_i = -g_i sigma_i`` of the class with which the loop is not asymptotically stable.

    What follows, as in :func:`examined`, and what was found.
    """
    H, method = plant(system), proof["method"]
    if method == "switched-gains":
        return 1, switched(H, asked, proof)
    need(method == "linear-gains", f"there is no refutation {method!r:.40} for several nonlinearities")
    gains = member(fields(proof, "method", "gains")[1], asked)
    words, closed = ", ".join(map(str, gains)), closed_by(H, gains)
    if closed is None:
        return 3, {"root": f"det(1 + H(inf) G) = 0 for the gains {words}"}
    order, p = len(closed), characteristic(closed)
    up, down = (real(1) + S, real(1) + exact.MINUS * S) if H.discrete else (S, real(1))
    inner = exact.primitive(exact.ascending(exact.homogeneous(p, up, down, order)))
    zeros = next(i for i, c in enumerate(inner) if c)
    rest = exact.homogeneous([Fraction(c) for c in inner[zeros:][::-1]], S, real(1), len(inner) - 1 - zeros)
    stable = len(inner) == order + 1 and exact.hurwitz(rest)  # shorter in discrete time: a root at z = -1
    need(zeros > 0 or not stable, "the loop with these gains is stable")
    if stable:
        at = "z = 1" if H.discrete else "s = 0"
        if zeros > order - rank(
            [[v - (i == j) * H.discrete for j, v in enumerate(row)] for i, row in enumerate(closed)]
        ):
            return 1, {"root": f"with the gains {words} the eigenvalue {at} of the loop has too few eigenvectors"}
        return 2, {"root": f"with the gains {words} the loop has an eigenvalue {at}, the others strictly inside"}
    return 1, {"root": f"with the gains {words} the loop has an eigenvalue not strictly inside, by Routh's array"}


def gain_box(H: Plant, asked: Channels, method: Any, tree: Any) -> dict[str, str]:
    """Constant gains: ``p(s, G) = det(1 + G D) det(s - A + B G (1 + D G)^-1 C)`` has no root with ``Re s >= 0``.

    It is affine in each gain, so that its values in a box lie in the convex hull of those at the vertices (mapping
    theorem); where several channels have one gain, of the means over the vertices with equally many at the upper end,
    Bernstein's coefficients.  A leaf of the tree splits the frequencies, and says for each part a direction ``u`` with
    ``Re u* p(i omega) > 0`` for these: no gain of the box has a root on the axis.  The leading coefficient keeps its
    sign, and the roots at one vertex lie to the left: so they do for every gain.  Discrete: ``z = (1 + s)/(1 - s)``.
    """
    form(method == "hull", "constant gains are proved by convex hulls")
    m, known = len(H.D), dict[tuple[Fraction, ...], tuple[Fraction, exact.Form]]()
    need(all(family.linear for family in asked.families), "a class is not one of constant gains")
    need(INF not in [abs(end) for i in range(m) for end in asked.bounds(i)], "a channel has no finite bounds")
    need(m <= MOST_VERTICES, f"boxes of gains have up to {MOST_VERTICES} channels")
    low, high = ([asked.bounds(block[0])[end] for block in asked.blocks] for end in (0, 1))
    pending, leaves = [(tree, low, high)], 0
    start = polynomial(H, [low[j] for j, block in enumerate(asked.blocks) for _ in block])
    need(
        start[0] != 0 and top(start[1]) == len(H.A) and exact.hurwitz(start[1]),
        "the loop at the lower bounds is unstable",
    )
    signs = [start[0] > 0, lead(start[1]) > 0]
    while pending:
        tick()
        node, low, high = pending.pop()
        if isinstance(node, dict) and "split" in node:
            (which, at), parts = fields(node, "split", "parts")
            j, at = integer(which, 0, len(low) - 1), number(at)
            form(isinstance(parts, list) and len(parts) == 2 and low[j] < at < high[j], "a box is split into two")
            pending += [
                (parts[0], low, [*high[:j], at, *high[j + 1 :]]),
                (parts[1], [*low[:j], at, *low[j + 1 :]], high),
            ]
            continue
        omega, directions = fields(node, "omega", "directions")
        leaves += 1
        ends: list[Any] = [ZERO, *(numbers(omega) if omega else []), None]
        form(isinstance(directions, list) and len(directions) == len(ends) - 1, "each part has one direction")
        need(all(a < b for a, b in pairwise(ends[:-1])), "the frequencies are not in order")
        turns = [exact.Form({(ZERO, 0): (a, -b)}) for a, b in (numbers(pair, 2) for pair in directions)]
        groups = dict[tuple[int, ...], tuple[Fraction, exact.Form]]()
        for ends_of in product((0, 1), repeat=m):
            at_ends = tuple((low[j], high[j])[ends_of[i]] for j, block in enumerate(asked.blocks) for i in block)
            if at_ends not in known:
                known[at_ends] = polynomial(H, list(at_ends))
            key = tuple(sum(ends_of[i] for i in block) for block in asked.blocks)
            det, p = groups.get(key, (ZERO, exact.Form()))
            need(known[at_ends][0] != 0, "1 + G D is singular at a vertex")
            groups[key] = det + known[at_ends][0], p + known[at_ends][1]
        for det, p in groups.values():
            kept = det != 0 and top(p) == len(H.A) and [det > 0, lead(p) > 0] == signs
            need(kept, "1 + G D, or a leading coefficient, changes its sign")
            for turn, (a, b) in zip(turns, pairwise(ends)):
                need(exact.positive((p * turn).part(), a, b), "a convex hull is not shown to exclude 0")
    found = f"no gain of the class has a root on the axis: {leaves} boxes, each the convex hull of its vertices"
    return {"stable": "the loop at the lower bounds is asymptotically stable", "gains": found}


def polynomial(H: Plant, gains: list[Fraction]) -> tuple[Fraction, exact.Form]:
    """``det(1 + G D)``, and it times the characteristic polynomial of the loop, on the axis; 0 if there is no loop."""
    whole = [[(i == j) + g * v for j, v in enumerate(row)] for i, (g, row) in enumerate(zip(gains, H.D))]
    det, closed, n = characteristic(whole)[-1] * (-1) ** len(whole), closed_by(H, gains), len(H.A)
    if closed is None:
        return ZERO, exact.Form()
    up, down = (real(1) + S, real(1) + exact.MINUS * S) if H.discrete else (S, real(1))
    return det, exact.homogeneous([det * c for c in characteristic(closed)], up, down, n)


def top(p: exact.Form) -> int:
    """The degree."""
    return max((n for _, n in p), default=-1)


def lead(p: exact.Form) -> Fraction:
    """The leading coefficient of ``p(s)``."""
    return exact.ascending(p)[top(p)]


def member(data: Any, asked: Channels) -> list[Fraction]:
    """One gain for each channel, all of the class."""
    gains = numbers(data, len(asked.families))
    inside = all(low <= g <= high for g, (low, high) in zip(gains, map(asked.bounds, range(len(gains)))))
    need(
        inside and all(len({gains[i] for i in block}) == 1 for block in asked.blocks), "the gains are outside the class"
    )
    return gains


def closed_by(H: Plant, gains: list[Fraction]) -> Rows | None:
    """The matrix of the loop with constant gains; None if it has no solution."""
    # mu = -G sigma and sigma = C x + D mu: (1 + G D) mu = -G C x
    left = [[(i == j) + g * v for j, v in enumerate(row)] for i, (g, row) in enumerate(zip(gains, H.D))]
    solved = eliminated(left, [[-g * v for v in row] for g, row in zip(gains, H.C)])
    if solved is None:
        return None
    return [[a + dot(b, column) for a, column in zip(row, zip(*solved))] for row, b in zip(H.A, H.B)]


def switched(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Gains that jump from one list to the next and repeat: some solution grows."""
    keys = ("method", "gains", "squarings", "bits", *([] if H.discrete else ["times"]))
    _, data, squarings, bits, *lengths = fields(proof, *keys)
    form(isinstance(data, list) and 0 < len(data) <= MOST_STEPS, f"gains are 1 to {MOST_STEPS} lists")
    need(len(H.A) <= 64, "orders up to 64 are needed")
    rows = [member(one, asked) for one in data]
    times = [None] * len(rows) if H.discrete else numbers(lengths[0], len(rows))
    need(all(t is None or t > 0 for t in times), "a time is not positive")
    for i, family in _each(asked):
        still = len({row[i] for row in rows}) == 1
        need(
            still or (family.varying and not family.linear),
            f"the gain of channel {i + 1} does not vary",
        )
    closed = {tuple(row): closed_by(H, row) for row in rows}
    need(None not in closed.values(), "1 + H(inf) G is singular for some of the gains", exact.IllPosed)
    steps = [(closed[tuple(row)], t) for row, t in zip(rows, times)]
    return states.grows(steps, integer(squarings, 0, 64), integer(bits, 64, 4096))


def rank(rows: Rows) -> int:
    """The rank of a square matrix, by elimination."""
    left, found = [list(row) for row in rows], 0
    for j in range(len(rows)):
        tick()
        pivot = next((row for row in left if row[j]), None)
        if pivot is not None:
            left.remove(pivot)
            left = [[v - row[j] / pivot[j] * u for v, u in zip(row, pivot)] if row[j] else row for row in left]
            found += 1
    return found


def characteristic(A: Rows) -> list[Fraction]:
    """``det(s - A)``, descending."""
    p, q, _ = frequencies.resolvent(A, [], [])
    return [Fraction(c, q**i) for i, c in enumerate(p)]

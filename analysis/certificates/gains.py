"""Linear members of classes in several channels: what they refute, and boxes of constant gains; part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product
from typing import Any

from . import arithmetic as exact
from . import pieces, signals, states
from .arithmetic import INF, ZERO, S, eliminated, fields, form, integer, need, number, numbers, real, tick
from .balls import box, dot
from .channels import (
    DELAYS,
    SCALAR,
    Channels,
    Plant,
    Rows,
    characteristic,
    closed_by,
    closed_loop,
    crossing,
    each,
    inside,
    matrices,
    member,
    plant,
    rank,
    within,
)

MOST_VERTICES, MOST_STEPS, MOST_SAMPLES = 10, 1000, 50
OPERATORS = ("any", "linear time-invariant", SCALAR)


def refuted(system: Any, asked: Channels, proof: Any, rate: Fraction | None = None) -> tuple[int, dict[str, str]]:
    """Linear members of the class, ``mu_i = -g_i sigma_i`` or operators, for which no proof is true.

    What follows, as in :func:`examined`, and what was found.
    """
    method = proof["method"]
    beside = ("delayed-gains", "delayed-members", "switched-gains")
    H = plant(system, method in ("late-crossing", "late-gains", "late-turns", *beside), rate)
    if H.late and "unlimited" in proof:
        return 11, signals.late_pole(H, asked, proof)
    if H.late and method not in beside:
        return crossing(H, asked, proof)
    need(not H.rates, "in neutral equations delays are not covered")
    if method == "relu-ray":
        return 1, ray(H, asked, proof)
    if method == "signal":
        return signals.signal(H, asked, proof)
    need(not any(family.relu for family in asked.families), "no gain is a ReLU")
    if method == "switched-gains":
        return 1, switched(H, asked, proof)
    if method == "ramped-gains":
        return 1, ramped(H, asked, proof)
    if method == "delayed-members":
        return signals.delayed_members(H, asked, proof)
    if method == "linear-members":
        return linear_members(H, asked, proof)
    if method == "delayed-gains":
        return late(H, asked, proof) if H.discrete else (1, delayed(H, asked, proof))
    if method == "flow-orbit":
        return 1, oscillation(H, asked, proof)
    if method == "memory-orbit":
        return 1, hysteresis(H, asked, proof)
    if method == "sampled-orbit":
        return 1, signals.sampled(H, asked, proof)
    if method == "equilibrium":
        return 2, signals.resting(H, asked, proof)
    need(method == "linear-gains", f"there is no refutation {method!r:.40} for several nonlinearities")
    if "unlimited" in proof:
        return 11, unlimited(H, asked, proof)
    if "matrices" in proof:
        _, data, given = fields(proof, "method", "gains", "matrices")
        found = closed_loop(H, matrices(member(data, asked), given, asked))
        need(found is not None, "the loop with these gains has no solution", exact.IllPosed)
        return unstable(H, (found or H).A, f"{', '.join(data)} and matrices of gains")
    _, data, *growth = fields(proof, "method", "gains", *["growth"] * ("growth" in proof))
    gains = member(data, asked, bool(growth))
    words, closed = ", ".join(map(str, gains)), closed_by(H, gains)
    if growth and closed is not None:  # beside what is bounded some solution grows
        rate = number(growth[0])
        moved = [
            [v / (1 + rate) if H.discrete else v - rate * (i == j) for j, v in enumerate(row)]
            for i, row in enumerate(closed)
        ]
        need(rate > 0 and not within(moved, H.discrete), "no solution is shown to grow")
        return 1, {"root": f"with the gains {words} some solution of the loop grows at the rate {rate}"}
    if closed is None:
        return 3, {"root": f"det(1 + H(inf) G) = 0 for the gains {words}"}
    return unstable(H, closed, words)


def unstable(H: Plant, closed: Rows, words: str) -> tuple[int, dict[str, str]]:
    """What follows of a loop that is not asymptotically stable, its matrix being given."""
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


def unlimited(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Constant gains for which the transfer function from one ``w_j`` to one ``z_i`` has a pole not strictly inside.

    Its numerator is ``det(s - A + b c) - det(s - A)`` up to the direct term, and what it shares with ``det(s - A)`` is
    divided out.  So some ``w`` of finite energy leaves ``z`` without: the gain of these members is infinite, or of
    those that come near to them, above every number.
    """
    _, data, pair = fields(proof, "method", "gains", "unlimited")
    form(isinstance(pair, list) and len(pair) == 2, "an output and an input are named")
    gains, own = member(data, asked, near=True), list(asked.performance or ())
    need(bool(own), "a gain is asked of a performance channel")
    i, j = (own[integer(v, 1, len(own)) - 1] for v in pair)
    found = closed_loop(H, [[g * (k == h) for h in range(len(gains))] for k, g in enumerate(gains)])
    need(found is not None, "the loop with these gains has no solution", exact.IllPosed)
    assert found is not None
    below = characteristic(found.A)
    moved = characteristic([[v - row[j] * c for v, c in zip(a, found.C[i])] for a, row in zip(found.A, found.B)])
    above = exact.primitive([v - u for u, v in zip(below, moved)][::-1])
    left, rest = exact.chain(exact.primitive(below[::-1]), above)[-1] if above else below[::-1], below[::-1]
    poles = list[Fraction]()  # below/left, descending
    while len(rest) >= len(left):
        poles.append(Fraction(rest[-1]) / left[-1])
        rest = [v - poles[-1] * u for v, u in zip(rest, [*[ZERO] * (len(rest) - len(left)), *left])][:-1]
    need(len(poles) > 1 and not inside(poles, H.discrete), "w does not move, or z not see, what does not fall")
    words = ", ".join(map(str, gains))
    return {
        "pole": f"with the gains {words} a pole from w_{pair[1]} to z_{pair[0]} not strictly inside, by Routh's array"
    }


def linear_members(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Constant gains, and operators ``Delta = u v'`` of all-passes: an unstable loop, or one with a larger gain.

    ``u_i = c_i a_i(s)``, ``|a_i| = 1`` on the axis, likewise ``v``: ``|Delta|`` is the product of the lengths of the
    coefficients at every frequency.  Of scalar ones ``delta = c a(s)``.  The gain is above ``gamma`` if ``|T(i omega)
    w| > gamma |w|`` for some ``w``: were it not, ``T`` would be analytic in ``Re s > 0`` and ``|T| <= gamma``.
    """
    keys = ["omega", "input"] if "omega" in proof else []
    _, data, listed, *at = fields(proof, "method", "gains", "operators", *keys)
    m, blocks = len(H.D), [block for block in asked.operators if asked.families[block[0]].operator in OPERATORS]
    gains = member(data, asked, near=bool(keys))
    need(not any(gains[i] for block in blocks for i in block), "an operator has a gain as well")
    form(isinstance(listed, list) and len(listed) == len(blocks), f"{len(blocks)} operators are needed, in order")
    G = [[g * (i == j) for j in range(m)] for i, g in enumerate(gains)]
    ends = list[list[Any]]([[None] * m, [None] * m])
    for block, item in zip(blocks, listed):
        if asked.families[block[0]].operator == SCALAR:  # delta = c a(s) in each of the channels
            (pair,) = fields(item, "delta")
            form(isinstance(pair, list) and len(pair) == 2, "delta is a pair of a coefficient and a rate, or null")
            delta, rate = number(pair[0]), None if pair[1] is None else number(pair[1])
            need(abs(delta) <= asked.bounds(block[0])[1], "an operator has a larger norm than its class")
            for i in block:
                G[i][i], ends[1][i] = delta, rate
            continue
        sides = list[list[Fraction]]()
        for rates, side in zip(ends, fields(item, "left", "right")):
            pairs = all(isinstance(x, list) and len(x) == 2 for x in side) if isinstance(side, list) else False
            form(pairs and len(side) == len(block), "an operator has pairs of a coefficient and a rate, or null")
            for i, (_, rate) in zip(block, side):
                rates[i] = None if rate is None else number(rate)
            sides.append([number(c) for c, _ in side])
        (left, right), most = sides, asked.bounds(block[0])[1] ** 2
        need(dot(left, left) * dot(right, right) <= most, "an operator has a larger norm than its class")
        for i, u in zip(block, left):
            for j, v in zip(block, right):
                G[i][j] = u * v
    found = closed_loop(filtered(H, *ends), G)
    words = f"{', '.join(map(str, gains))}{' and operators of all-passes' * bool(blocks)}"
    need(found is not None, "the loop with these operators has no solution", exact.IllPosed)
    assert found is not None
    if not keys:  # the operators at rest at first: some solution of the plant alone is not at rest, if they stay so
        n = len(H.A)
        apart = [row[n:] for row in found.A[n:]]
        need(not apart or within(apart, H.discrete), "the operators are not stable with D alone")
        return unstable(found, found.A, words)
    need(asked.performance is not None, "a gain is asked of a performance channel")
    rests = within(found.A, H.discrete)
    need(rests or not blocks, "the loop with these members is not stable")
    own = list(asked.performance or ())
    form(isinstance(at[1], list) and len(at[1]) == len(own), "the input has one entry for each channel")
    w, omega = [numbers(pair, 2) for pair in at[1]], None if at[0] is None else number(at[0])
    z = response(found, own, [[pair[0] for pair in w], [pair[1] for pair in w]], omega)
    size, gamma = sum((v * v for pair in w for v in pair), ZERO), 1 / asked.bounds(own[0])[1]
    need(dot(z, z) > gamma**2 * size, "the gain of this loop is not shown to be larger")
    where = f"omega = {'inf' if omega is None else omega}{', the tangent of half the angle' * H.discrete}"
    how = f"with {words} the loop is asymptotically stable" if rests else "whether it is does not matter"
    return 8, {"stable": how, "gain": f"|T w| > gamma |w| at {where}"}


def delayed(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Constant gains, no delay but in one channel: for one ``tau`` of its class the loop has a root on the axis.

    ``h`` is from this channel's ``mu`` to its ``sigma``, ``g = h e^(-i omega tau)``.  For ``a <= omega <= b`` let ``Re
    g < 0`` at both ends of ``tau``, ``Im g`` being below 0 at the first and above at the second, and ``b (tau_2 -
    tau_1) < 3``: as ``g`` turns by less than ``pi``, it is real and negative for one ``tau``, continuous in ``omega``.
    ``|h| - 1`` changes its sign between ``a`` and ``b``: somewhere ``1 + g = 0``.
    """
    _, data, where, delays, frequencies_of = fields(proof, "method", "gains", "channel", "delays", "frequencies")
    i, gains = integer(where, 1, len(H.D)) - 1, member(data, asked)
    need(
        range(i, i + 1) in asked.blocks and asked.families[i].operator in DELAYS, "the channel has no delay of its own"
    )
    (low, high), (a, b) = numbers(delays, 2), numbers(frequencies_of, 2)
    need(
        0 <= low < high <= asked.families[i].sector[1] and 0 < a < b and b * (high - low) < 3,
        "the delays are not of the class",
    )
    d, N = pieces.quotients(H, [g * (k != i) for k, g in enumerate(gains)])
    n = N[i][i]
    for tau, sign in ((low, -1), (high, 1)):
        g = n * d.conjugate() * exact.Form({(tau, 0): (Fraction(1), ZERO)})
        turned = g * exact.Form({(ZERO, 0): (ZERO, Fraction(-sign))})
        apart = box(exact.MINUS * g, a, b, 24) and box(turned, a, b, 24)
        need(apart, "the delay at which h e^(-i omega tau) is negative is not shown to lie in between")
    size = n * n.conjugate() + exact.MINUS * d * d.conjugate()
    signs = [[box(v * size, omega, omega, 24) for omega in (a, b)] for v in (real(1), exact.MINUS)]
    need([True, False] in signs and [False, True] in signs, "|h| - 1 does not change its sign")
    words = ", ".join(map(str, gains))
    return {"root": f"with the gains {words} and a delay of channel {i + 1} between {low} and {high} a root i omega"}


def late(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Gains, and a delay of ``k`` samples in one channel: ``q_1+ = sigma``, ``q_j+ = q_(j-1)``, ``mu = -q_k``."""
    _, data, where, samples = fields(proof, "method", "gains", "channel", "samples")
    i, k, gains = integer(where, 1, len(H.D)) - 1, integer(samples, 1, MOST_SAMPLES), member(data, asked)
    own = range(i, i + 1) in asked.blocks and asked.families[i].operator in DELAYS
    need(own and k <= asked.families[i].sector[1], "the delay is not of the class")
    n, m = len(H.A), len(gains)
    A = [[*row, *[ZERO] * k] for row in H.A] + [[*H.C[i], *[ZERO] * k]]
    A += [[Fraction(j == n + h) for j in range(n + k)] for h in range(k - 1)]
    C = [[*(ZERO if j == i else v for v in row), *[ZERO] * (k - 1), Fraction(j == i)] for j, row in enumerate(H.C)]
    D = [[ZERO if j == i else v for v in row] for j, row in enumerate(H.D)]
    moved = Plant(A, [*H.B, H.D[i], *([ZERO] * m for _ in range(k - 1))], C, D, True)
    closed, words = closed_by(moved, gains), ", ".join(map(str, gains))
    need(closed is not None, "the loop with these gains has no solution", exact.IllPosed)
    return unstable(moved, closed or [], f"{words} and a delay of {k} samples in channel {i + 1}")


def ray(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """A solution that grows, of a loop with ReLUs, which are gains as long as no ``sigma_i`` changes its sign.

    ``M``: the product of the steps with given gains (continuous time: one step, its matrix).  There are ``x*`` and
    ``lambda*`` with ``M x* = lambda* x*`` within ``r`` of those given, the largest entry ``x_p`` being held: with the
    derivative ``J`` of ``M x - lambda x`` by the others and ``lambda``, ``d -> -J^-1 (M x - lambda x - d_lambda d_x)``
    maps ``|d| <= r`` into itself (Brouwer).  At every step each ``sigma`` of a ReLU has the sign of its gain, for all
    ``x`` that near, and ``lambda* > 1``, in continuous time ``> 0``.  Entries of ``x`` that are 0 stay so where ``M``
    keeps them; a ``sigma`` of these alone is 0, and any gain is that of its ReLU.
    """
    _, data, state, eigenvalue, near = fields(proof, "method", "gains", "state", "value", "radius")
    form(isinstance(data, list) and 0 < len(data) <= (MOST_STEPS if H.discrete else 1), "gains are lists, a step each")
    rows, n, r = [numbers(row, len(asked.families)) for row in data], len(H.A), number(near)
    x, value = numbers(state, n), number(eigenvalue)
    firsts = {i: block[0] for block in asked.blocks for i in block}
    for i, family in each(asked):
        low, high = asked.bounds(i)
        own = {row[i] for row in rows}
        if family.relu:
            need(own <= {low, high}, f"channel {i + 1} has a gain that is none of its ReLU")
            continue
        plain = not family.operator and not family.memory and low <= min(own) == max(own) <= high
        need(plain and rows[0][i] == rows[0][firsts[i]], "the gains are outside the class")
    whole, seen = [[Fraction(i == j) for j in range(n)] for i in range(n)], list[tuple[bool, list[Fraction]]]()
    for row in rows:
        step = closed_loop(H, [[g * (i == j) for j in range(len(row))] for i, g in enumerate(row)])
        need(step is not None, "with some of the gains the loop has no solution")
        columns = [*zip(*whole)]
        for i, family in each(asked):
            if family.relu and step is not None:
                seen.append((row[i] == asked.bounds(i)[1], [dot(step.C[i], column) for column in columns]))
        whole = [[dot(line, column) for column in columns] for line in (step or H).A]
    kept = [j for j in range(n) if x[j]]
    if all(not whole[i][j] for i in range(n) if not x[i] for j in kept):
        whole, x, n = [[whole[i][j] for j in kept] for i in kept], [x[j] for j in kept], len(kept)
        seen = [(above, [line[j] for j in kept]) for above, line in seen]
    need(n > 0, "the state is 0")
    p = max(range(n), key=lambda i: abs(x[i]))
    J = [[*(v - value * (i == j) for j, v in enumerate(line) if j != p), -x[i]] for i, line in enumerate(whole)]
    off = [[dot(line, x) - value * x[i]] for i, line in enumerate(whole)]
    solved = eliminated(J, [[*f, *(Fraction(i == j) for j in range(n))] for i, f in enumerate(off)])
    need(x[p] != 0 < r and solved is not None, "the eigenvector is not shown to exist")
    size = max(sum(map(abs, row[1:]), ZERO) for row in solved or [])
    need(all(abs(row[0]) + size * r * r <= r for row in solved or []), "the eigenvector is not shown to exist")
    need(value - r > H.discrete, "the solution does not grow")
    for above, line in seen:
        least = (1 if above else -1) * dot(line, x) - r * sum(abs(v) for j, v in enumerate(line) if j != p)
        need(least > 0 or not any(line), "a ReLU has another gain there")
    steps = f" in {len(rows)} steps" * H.discrete
    return {"root": f"a solution that keeps its direction and grows{steps}, lambda within {r} of {value}"}


def filtered(H: Plant, left: list[Any], right: list[Any]) -> Plant:
    """The plant with ``(s - a)/(s + a)``, in discrete time ``(1 - a z)/(z - a)``, before inputs and after outputs."""
    for rate in (a for a in (*left, *right) if a is not None):
        need(abs(rate) < 1 if H.discrete else rate > 0, "an all-pass is not stable")
    given = [{i: a for i, a in enumerate(side) if a is not None} for side in (left, right)]
    steps = [(a, 1 - a * a, -a) if H.discrete else (-a, -2 * a, Fraction(1)) for side in given for a in side.values()]
    before, after = map(list, given)
    parts = steps[: len(before)], steps[len(before) :]
    n, m, p, q = len(H.A), len(H.D), len(before), len(after)
    ahead = dict(zip(before, parts[0]))
    direct = [ahead[i][2] if i in ahead else Fraction(1) for i in range(m)]

    def through(state: Any, into: Any) -> tuple[list[Fraction], list[Fraction]]:
        """A row of ``(A, B)`` or ``(C, D)`` with the filters before the inputs."""
        more = [into[i] * gain for i, (_, gain, _) in zip(before, parts[0])]
        return [*state, *more], [v * d for v, d in zip(into, direct)]

    pairs = [through(a, b) for a, b in zip(H.A, H.B)]
    A, B = [[*a, *[ZERO] * q] for a, _ in pairs], [b for _, b in pairs]
    A += [[*[ZERO] * n, *(part[0] * (i == k) for i in range(p)), *[ZERO] * q] for k, part in enumerate(parts[0])]
    B += [[Fraction(i == j) for j in range(m)] for i in before]
    seen = [through(c, d) for c, d in zip(H.C, H.D)]
    C, D = [[*c, *[ZERO] * q] for c, _ in seen], [d for _, d in seen]
    for k, (i, (pole, gain, straight)) in enumerate(zip(after, parts[1])):
        A.append([*C[i][: n + p], *(pole * (j == k) for j in range(q))])
        B.append(D[i])
        C[i] = [*(straight * v for v in C[i][: n + p]), *(gain * (j == k) for j in range(q))]
        D[i] = [straight * v for v in D[i]]
    return Plant(A, B, C, D, H.discrete)


def response(H: Plant, own: list[int], w: Any, omega: Fraction | None) -> list[Fraction]:
    """Real, then imaginary parts of ``T w`` at a frequency, None for infinity."""
    n, (re, im) = len(H.A), w
    direct = [[dot([H.D[i][j] for j in own], side) for i in own] for side in (re, im)]
    if omega is None and not H.discrete:
        return [*direct[0], *direct[1]]
    c, d = ZERO, omega or ZERO
    if H.discrete:  # z = e^(i theta), omega the tangent of theta/2
        c, d = Fraction(-1), ZERO
        if omega is not None:
            c, d = (1 - omega**2) / (1 + omega**2), 2 * omega / (1 + omega**2)
    real_part = [[c * (i == j) - v for j, v in enumerate(row)] for i, row in enumerate(H.A)]
    turn = [[d * (i == j) for j in range(n)] for i in range(n)]
    top = [[*row, *(-v for v in more)] for row, more in zip(real_part, turn)]
    low = [[*more, *row] for row, more in zip(real_part, turn)]
    driven = [[dot([b[j] for j in own], side)] for side in (re, im) for b in H.B]
    x = exact.eliminated([*top, *low], driven)
    need(x is not None, "the frequency is that of a pole")
    state = [row[0] for row in x or []]
    seen = [[dot(H.C[i], part) for i in own] for part in (state[:n], state[n:])]
    return [v + u for side, more in zip(seen, direct) for v, u in zip(side, more)]


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
    constant = all(family.linear and family.rate is None for family in asked.families)
    need(constant, "a class is not one of constant gains")
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


def switched(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Gains that jump from one list to the next and repeat: some solution grows."""
    data = proof.get("gains")
    form(isinstance(data, list) and 0 < len(data) <= MOST_STEPS, f"gains are 1 to {MOST_STEPS} lists")
    need(len(H.A) <= 64, "orders up to 64 are needed")
    rows = [member(one, asked) for one in data]
    for i, family in each(asked):
        moves = [abs(after[i] - row[i]) for row, after in zip(rows, [*rows[1:], rows[0]])]
        slow = H.discrete and family.rate is not None and max(moves) <= family.rate
        free = family.varying and not family.linear
        need(free or slow or not any(moves), f"the gain of channel {i + 1} does not vary so fast, or at all")
    if H.late:
        need(asked.performance is None, "beside dead times gains that jump are not about a gain from w to z")
        return signals.returning(H, rows, proof)
    _, _, squarings, bits, *lengths = fields(
        proof, "method", "gains", "squarings", "bits", *([] if H.discrete else ["times"])
    )
    times = [None] * len(rows) if H.discrete else numbers(lengths[0], len(rows))
    need(all(t is None or t > 0 for t in times), "a time is not positive")
    closed = {tuple(row): closed_by(H, row) for row in rows}
    need(None not in closed.values(), "1 + H(inf) G is singular for some of the gains", exact.IllPosed)
    steps = [(closed[tuple(row)], t) for row, t in zip(rows, times)]
    return states.grows(steps, integer(squarings, 0, 64), integer(bits, 64, 4096))


def ramped(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Gains that go linearly from one list to the next, from the last to the first, and repeat: some solution grows.

    Where they move ``sigma_i`` is a function of the state alone, so that the matrix of the loop goes linearly too.
    """
    _, data, squarings, bits, lengths = fields(proof, "method", "gains", "squarings", "bits", "times")
    form(isinstance(data, list) and 0 < len(data) <= MOST_STEPS, f"gains are 1 to {MOST_STEPS} lists")
    need(len(H.A) <= 64 and not H.discrete, "continuous time and orders up to 64 are needed")
    rows, times = [member(one, asked) for one in data], numbers(lengths, len(data))
    need(all(t > 0 for t in times), "a time is not positive")
    following = [*rows[1:], rows[0]]
    for i, family in each(asked):
        moves = [(abs(after[i] - row[i]), t) for row, after, t in zip(rows, following, times)]
        slow = family.rate is not None and all(move <= family.rate * t for move, t in moves)
        free = slow or (family.varying and not family.linear)
        still = not any(move for move, _ in moves)
        need(still or free, f"the gain of channel {i + 1} does not vary so fast, or at all")
        need(still or not any(H.D[i]), f"sigma_{i + 1}, whose gain moves, is no function of the state alone")
    closed = {tuple(row): closed_by(H, row) for row in rows}
    need(None not in closed.values(), "1 + H(inf) G is singular for some of the gains", exact.IllPosed)
    steps = [(closed[tuple(a)], t, *([closed[tuple(b)]] if a != b else [])) for a, b, t in zip(rows, following, times)]
    return states.grows(steps, integer(squarings, 0, 64), integer(bits, 64, 4096))


def oscillation(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """An orbit of the loop with piecewise linear ``phi_i``, one for each block, near the given one.

    On a stay ``phi = K sigma + q``, so that ``sigma = (1 + D K)^-1 (C x - D q)`` and ``x' = A x - B (K sigma + q)``; at
    its end one ``sigma_i`` is on a kink, where both stays give the same ``sigma``.
    """
    _, given, pieces, *rest = fields(proof, "method", "nonlinearities", *states.FLOW_ORBIT.split()[4:])
    form(isinstance(pieces, list) and bool(pieces), "there are no pieces")
    plain = not asked.operators and not any(family.memory for family in asked.families)
    need(plain and not H.discrete, "orbits of flows are for continuous time, and for functions of sigma")
    X0, times, half, Y, r = states.orbit_numbers(rest, pieces, len(H.A))
    lines = [phi.lines for phi in signals.graphs(given, asked, half)]
    form(all(isinstance(row, list) and len(row) == len(lines) for row in pieces), "a stay has a piece in each channel")
    path = [[integer(p, 0, len(own) - 1) for p, own in zip(row, lines)] for row in pieces]
    path += [[len(own) - 1 - p for p, own in zip(path[0], lines)] if half else path[0]]
    switches = [[(i, max(a, b)) for i, (a, b) in enumerate(zip(p, q)) if a != b] for p, q in pairwise(path)]
    ends = [row[0] for row in switches if len(row) == 1]
    steps = all(abs(a - b) <= 1 for p, q in pairwise(path) for a, b in zip(p, q))
    need(len(ends) == len(pieces) and steps, "the pieces do not follow one another, in one channel after the other")
    flows, stays = dict[tuple[int, ...], tuple[Rows, Rows]](), list[states.Stay]()
    for j, (at, (i, kink), last) in enumerate(zip(path, [ends[-1], *ends], ends)):
        if tuple(at) not in flows:
            flows[tuple(at)] = affine(H, [own[p] for own, p in zip(lines, at)], X0[-1])
        G, sigma = flows[tuple(at)]
        level = lines[i][kink][0] * (-1 if half and not j else 1)
        sides = [(own[p][0] if p else -INF, own[p + 1][0] if p + 1 < len(own) else INF) for own, p in zip(lines, at)]
        watched = [(row, side, k == i, k == last[0]) for k, (row, side) in enumerate(zip(sigma, sides))]
        stays.append(states.Stay(G, [*sigma[i][:-1], sigma[i][-1] - level / X0[-1]], watched))
    return states.periodic(stays, (X0, times), Y, r, -1 if half else 1)


def hysteresis(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """An orbit with one play or stop of slope ``g`` and half-width 1, near the given one; constant gains elsewhere.

    ``xi = sigma - p`` goes with ``sigma`` from 1 to -1, where it stays until ``sigma' = 0``; then the negative of all
    this.  ``phi = g xi`` of a stop, ``g (sigma - xi)`` of a play; in both parts ``sigma' < 0``.
    """
    _, data, *rest = fields(proof, "method", "gains", *states.FLOW_ORBIT.split()[5:])
    own, gains = [i for i, family in each(asked) if family.memory], member(data, asked, near=True)
    alone = len(own) == 1 and not asked.operators and not H.discrete
    need(alone and gains[own[0]] > 0, "one play or stop is needed, beside functions, in continuous time")
    i, g = own[0], gains[own[0]]
    found = closed_loop(H, [[v * (j == k != i) for k in range(len(gains))] for j, v in enumerate(gains)])
    need(found is not None, "the loop with these gains has no solution", exact.IllPosed)
    H = found or H
    need(not H.D[i][i], "sigma is no function of the state alone")
    X0, times, half, Y, r = states.orbit_numbers(rest, [0, 1], len(H.A) + 1)
    need(half, "an orbit of a play or a stop is given by its half")
    stop, c = asked.families[i].memory[0] == "stop", H.C[i]
    sides = zip(H.A, (row[i] for row in H.B))
    rows = [[*(v - (not stop) * b * g * u for v, u in zip(a, c)), (1 - 2 * stop) * b * g, ZERO] for a, b in sides]
    rate, still = [dot(c, column) for column in zip(*rows)], [ZERO] * (len(c) + 2)
    falls = (rate, (-INF, ZERO))
    stays = [
        states.Stay([*rows, rate, still], rate, [(*falls, True, False)]),
        states.Stay([*rows, still, still], [*still[2:], Fraction(1), 1 / X0[-1]], [(*falls, False, True)]),
    ]
    return states.periodic(stays, (X0, times), Y, r, -1)


def affine(H: Plant, lines: Any, e: Fraction) -> tuple[Rows, Rows]:
    """``X' = G X`` and ``sigma``, from ``X = (x, e)``, where ``phi_i = w_i + k_i (sigma_i - x_i)``."""
    gains, shifts = [k for *_, k in lines], [(w - k * x) / e for x, w, k in lines]
    left = [[(i == j) + v * k for j, (v, k) in enumerate(zip(row, gains))] for i, row in enumerate(H.D)]
    sigma = exact.eliminated(left, [[*row, -dot(d, shifts)] for row, d in zip(H.C, H.D)])
    need(sigma is not None, "1 + D K is singular on a stay", exact.IllPosed)
    assert sigma is not None
    phi = [[*(k * v for v in row[:-1]), k * row[-1] + q] for row, k, q in zip(sigma, gains, shifts)]
    rows = [[v - dot(b, column) for v, column in zip([*a, ZERO], zip(*phi))] for a, b in zip(H.A, H.B)]
    return [*rows, [ZERO] * len(rows[0])], sigma

"""What a disturbance gets through a loop from rest; gains that jump, exact orbits, equilibria: part of the checker.

Standard library only.  Every function raises ``Rejected`` unless what it is asked to show is shown.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import accumulate, pairwise
from math import comb, gcd, lcm
from typing import Any

from . import arithmetic as exact
from . import frequencies, pieces, states
from .arithmetic import INF, ZERO, fields, form, integer, need, number, numbers, real, tick
from .balls import Ball, ball, box, dot, exponential, identity, norm, plus, product, sign_of_determinant, size
from .blocks import below, coefficients, realised
from .channels import DELAYS, Channels, Plant, Rows, closed_by, each, member, ordered, rank

MOST_STEPS, MOST_SAMPLES, MOST_PARTS = 2000, 1000, 64
TERMS, SHORT = 20, 96  # terms of a series, and the bits that its squares are given
Line = tuple[Fraction, Fraction]


def signal(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """A disturbance from rest, ``phi_i = a sigma`` below 0 and ``b sigma`` above: more than ``gamma`` comes through.

    ``sum |z|^2`` over its samples is above ``gamma^2 sum |w|^2``, and so is that over all; or integrals of these.  The
    slopes may be others in each step where the class depends on time.  So they may in samples where it is a sector and
    no more: ``phi`` may have any value in it wherever ``sigma`` comes but once.
    """
    _, data, given, *rest = fields(
        proof, "method", "slopes", "inputs", *([] if H.discrete else ["times", "sides", "scale", "bits"])
    )
    own, functions = list(asked.performance or ()), asked.functions
    need(bool(own) and len(functions) + len(own) == len(H.D), "a signal goes through functions alone, from w to z")
    before = not any(H.D[i][j] for i in functions for j in functions if j >= i)
    need(before, "one function acts on another before it, or on itself, at once")
    form(isinstance(given, list) and 0 < len(given) <= MOST_STEPS, f"a signal has 1 to {MOST_STEPS} samples")
    form(isinstance(data, list) and len(data) == len(functions), "slopes are needed for each function")
    lines = {i: slopes(one, len(given), i, asked) for i, one in zip(functions, data)}
    same = all(lines[i] == lines[block[0]] for block in asked.blocks if block[0] in lines for i in block)
    need(same, "one nonlinearity has the same slopes in all its channels")
    inputs = [numbers(row, len(own)) for row in given]
    if H.discrete:
        through, all_of = samples(H, asked, lines, inputs)
    else:
        (times, sides, scale), bits = (
            (numbers(rest[0], len(given)), rest[1], number(rest[2])),
            integer(rest[3], 128, 8192),
        )
        form(isinstance(sides, list) and len(sides) == len(given), "the sides of 0 are missing")
        form(all(isinstance(at, list) and len(at) == len(functions) for at in sides), "each function has a side of 0")
        need(min(times) > 0 and scale > 0, "a step takes no time")
        for i, steps in lines.items():
            free = asked.families[i].varying or len(set(steps)) == 1
            need(free, f"the nonlinearity of channel {i + 1} does not depend on time")
        through, all_of = Flow(H, asked, lines, scale, bits).through(sides, inputs, times)
    need(through > all_of / asked.bounds(own[0])[1] ** 2, "the gain of this loop is not shown to be larger")
    words = "sum" if H.discrete else "int"
    return 8, {"gain": f"{words} |z|^2 > gamma^2 {words} |w|^2 over {len(given)} steps, from rest"}


def slopes(data: Any, count: int, i: int, asked: Channels) -> list[Line]:
    """The line of one channel in each step."""
    form(isinstance(data, list) and bool(data), "slopes are a pair, or a list of pairs")
    steps = isinstance(data[0], list)
    form(not steps or len(data) == count, "slopes of steps are as many as these")
    found = [(pair[0], pair[1]) for pair in (numbers(one, 2) for one in (data if steps else [data]))]
    (low, high), family = asked.bounds(i), asked.families[i]
    inside = all(low <= slope <= high for line in found for slope in line)
    need(inside, f"the slopes of channel {i + 1} are outside its class")
    straight = family.odd or family.linear
    need(not straight or all(a == b for a, b in found), f"channel {i + 1} has an odd nonlinearity")
    need(not family.linear or len(set(found)) == 1, f"channel {i + 1} is linear")
    need(not family.relu or set(found) == {(low, high)}, f"channel {i + 1} has another ReLU")
    need(family.rate is None or len(set(found)) == 1, f"the gain of channel {i + 1} does not vary so fast")
    return found if steps else found * count


def samples(H: Plant, asked: Channels, lines: dict[int, list[Line]], inputs: Rows) -> tuple[Fraction, Fraction]:
    """``sum |z|^2`` and ``sum |w|^2`` over the samples, exactly."""
    own, x, through, all_of = list(asked.performance or ()), [ZERO] * len(H.A), ZERO, ZERO
    known: dict[int, dict[Fraction, Fraction]] = {block[0]: {} for block in asked.blocks}
    jumps = {block[0] for block in asked.blocks if block[0] in lines and len(set(lines[block[0]])) > 1}
    for i in jumps:
        family = asked.families[i]
        whole = family.slope == (-INF, INF) or family.varying
        need(whole, f"channel {i + 1} has a slope, and does not depend on time")
    for t, row in enumerate(inputs):
        tick()
        mu = [ZERO] * len(H.D)
        for j, w in zip(own, row):
            mu[j] = w
        all_of += dot(mu, mu)
        for block in asked.blocks:
            for i in block if block[0] in lines else ():
                sigma = dot(H.C[i], x) + dot(H.D[i], mu)
                mu[i] = -lines[i][t][sigma > 0] * sigma
                if block[0] in jumps and not asked.families[i].varying:
                    sign = -1 if asked.families[i].odd and sigma < 0 else 1
                    met = known[block[0]].setdefault(sign * sigma, sign * mu[i])
                    need(met == sign * mu[i], f"phi of channel {i + 1} has two values at one sigma")
        z = [dot(H.C[j], x) + dot(H.D[j], mu) for j in own]
        through += dot(z, z)
        x = [dot(a, x) + dot(b, mu) for a, b in zip(H.A, H.B)]
    return through, all_of


class Flow:
    """A loop of lines, with a constant ``w`` on each step: ``X = (x, c w)`` goes as ``X' = G X`` on each side of 0.

    Let ``y`` go so from where ``x`` is, each ``sigma_i`` on the wrong side by ``delta_i`` at most.  In the maximum norm
    ``|mu_i - mu_i(y)| <= lambda_i |x - y| + nu_i``, ``nu_i = |b - a| delta_i + L sum |D_ij| nu_j``, ``L`` the largest
    slope, ``lambda_i = L (|C_i| + sum |D_ij| lambda_j)``: ``|x - y| <= h e^(M h) max_r sum |B_ri| nu_i`` within a step
    ``h``, ``M = max_r (|A_r| + sum |B_ri| lambda_i)``, of which ``M h <= 1/2`` is asked.
    """

    def __init__(self, H: Plant, asked: Channels, lines: dict[int, list[Line]], scale: Fraction, bits: int) -> None:
        self.H, self.own, self.lines, self.scale, self.bits = H, list(asked.performance or ()), lines, scale, bits
        self.steep = {i: max(abs(v) for line in steps for v in line) for i, steps in lines.items()}
        self.near = dict[int, Fraction]()
        for i, most in self.steep.items():
            self.near[i] = most * (size([H.C[i]]) + self.sized(H.D[i], self.near))
        self.fast = max(size([a]) + self.sized(b, self.near) for a, b in zip(H.A, H.B))
        self.known = dict[Any, tuple[Ball, dict[int, tuple[Ball, Ball, int]]]]()

    @staticmethod
    def sized(row: list[Fraction], parts: dict[int, Fraction]) -> Fraction:
        """``sum |row_i| part_i``."""
        return sum((abs(row[i]) * part for i, part in parts.items()), ZERO)

    def through(self, sides: Any, inputs: Rows, times: list[Fraction]) -> tuple[Fraction, Fraction]:
        """``int |z|^2``, at least, and ``int |w|^2``."""
        n, all_of, total = len(self.H.A), ZERO, ZERO
        X = Ball([[0] for _ in range(n + len(self.own))], 0, self.bits)
        for t, (w, h, at) in enumerate(zip(inputs, times, sides)):
            tick()
            need(self.fast * h <= Fraction(1, 2), "a step is too long for this loop")
            all_of += h * dot(w, w)
            X = X._replace(rows=X.rows[:n] + [[round(self.scale * v * 2**self.bits)] for v in w], error=X.error + 1)
            pairs = {i: steps[t] for i, steps in self.lines.items()}
            E, series = self.series(tuple(pair[integer(k, 0, 1)] for pair, k in zip(pairs.values(), at)), h)
            after, off = product(E, X), dict[int, Fraction]()
            for (i, (a, b)), k in zip(pairs.items(), at):
                wrong = astray(series[i], X, after, 1 if k else -1) if a != b else 0
                off[i] = abs(b - a) * wrong + self.steep[i] * self.sized(self.H.D[i], off)
            apart = 2 * h * max(self.sized(row, off) for row in self.H.B)
            for j in self.own:
                row, into = self.H.D[j], size([self.H.C[j]]) + self.sized(self.H.D[j], self.near)
                total += h * squared(series[j], X, int(into * apart + self.sized(row, off)) + 1)
            X = after._replace(error=after.error + int(apart) + 1)
        return total, all_of

    def series(self, gains: tuple[Fraction, ...], h: Fraction) -> tuple[Ball, dict[int, tuple[Ball, Ball, int]]]:
        """``exp(G h)``, and of each ``sigma_i`` and ``z_j`` its ``row`` of ``X``, those of the series, and their rest.

        As ``|G h| <= 1``, the rows ``row (G h)^j/j!`` from ``j = TERMS`` on add up to at most twice the first of them.
        """
        if (gains, h) in self.known:
            return self.known[gains, h]
        H, n, rows, mu = self.H, len(self.H.A), dict[int, list[Fraction]](), dict[int, list[Fraction]]()

        def seen(x: list[Fraction], inputs: list[Fraction]) -> list[Fraction]:
            """From ``X``, where this is from the state and ``mu``."""
            columns = zip(*mu.values()) if mu else [()] * (n + len(self.own))
            return [
                v + dot([inputs[i] for i in mu], column)
                for v, column in zip([*x, *(inputs[j] / self.scale for j in self.own)], columns)
            ]

        for i, g in zip(self.lines, gains):
            rows[i] = seen(H.C[i], H.D[i])
            mu[i] = [-g * v for v in rows[i]]
        rows |= {j: seen(H.C[j], H.D[j]) for j in self.own}
        step = [[h * v for v in seen(a, b)] for a, b in zip(H.A, H.B)]
        step += [[ZERO] * len(step[0]) for _ in self.own]
        need(size(step) <= 1, "a step is too long for this loop")
        turn, found = ball(step, self.bits), dict[int, tuple[Ball, Ball, int]]()
        for i, row in rows.items():
            terms = [ball([row], self.bits)]
            for k in range(1, TERMS + 1):
                last = product(terms[-1], turn)
                terms.append(Ball([[v // k for v in last.rows[0]]], last.error // k + 1 + len(row), self.bits))
            kept = Ball([term.rows[0] for term in terms[:-1]], max(term.error for term in terms), self.bits)
            found[i] = terms[0], kept, 2 * norm(terms[-1])
        self.known[gains, h] = exponential(step, Fraction(1), self.bits), found
        return self.known[gains, h]


def least(c: list[int]) -> int:
    """What ``sum c_j q^j`` is on ``[0, 1]`` at least, by its Bernstein coefficients."""
    n = len(c) - 1
    return min(sum(comb(k, j) * c[j] // comb(n, j) for j in range(k + 1)) for k in range(n + 1))


def astray(series: tuple[Ball, Ball, int], X: Ball, after: Ball, sign: int) -> int:
    """By how much ``sign sigma`` is below 0 in a step, at most, in units: it is no less than that at the end it leaves.

    The rest of the series is at most ``rest``, and that of the derivative ``TERMS rest``.
    """
    row, kept, tail = series
    P, end = product(kept, X), product(row, after)
    c, rest = [sign * v for (v,) in P.rows], TERMS * P.error + (tail * norm(X) >> X.bits) + TERMS + 1
    low, slopes_of = least(c) - rest, [j * v for j, v in enumerate(c)][1:]
    if least(slopes_of) - TERMS * rest > 0:
        low = max(low, c[0] - P.error)
    if least([-v for v in slopes_of]) - TERMS * rest > 0:
        low = max(low, sign * end.rows[0][0] - end.error)
    return max(0, -low)


def squared(series: tuple[Ball, Ball, int], X: Ball, apart: int) -> Fraction:
    """``int_0^1 z^2 dq``, at least, for every ``z`` that is ``apart`` units from the series."""
    _, kept, tail = series
    P, less = product(kept, X), X.bits - SHORT
    c = [v >> less for (v,) in P.rows]
    off = (TERMS * P.error + (tail * norm(X) >> X.bits) + apart + 1 >> less) + TERMS + 1
    powers = [
        sum(c[j] * c[m - j] for j in range(max(0, m - TERMS + 1), min(m + 1, TERMS))) for m in range(2 * TERMS - 1)
    ]
    whole = sum(p // (m + 1) for m, p in enumerate(powers)) - 2 * TERMS - 2 * off * sum(map(abs, c))
    return Fraction(max(0, whole), 4**SHORT)


def delayed_members(H: Plant, asked: Channels, proof: Any) -> tuple[int, dict[str, str]]:
    """Constant gains and constant delays, and a frequency where ``|T w| > gamma |w|``.

    With ``G`` of gains and ``e^(-i omega tau)``, 0 from ``w`` to ``z``, ``(d + N G) sigma = N w``; ``z`` by Cramer's
    rule.  Were the gain at most ``gamma``, ``T`` would be analytic in ``Re s > 0``, ``|T| <= gamma``, and so it would
    be on the axis: whether the loop is stable does not matter.
    """
    _, data, listed, where, given = fields(proof, "method", "gains", "delays", "omega", "input")
    m, gains, omega = len(H.D), member(data, asked), number(where)
    own, functions = list(asked.performance or ()), [i for i, family in each(asked) if not family.operator]
    late = [i for i, family in each(asked) if family.operator in DELAYS]
    need(not H.discrete and bool(own) and omega > 0, "in continuous time a gain from w to z is needed, and omega > 0")
    need(sorted([*own, *functions, *late]) == [*range(m)], "beside delays and functions there are other operators")
    need(ordered(H.D, asked) and m <= frequencies.MOST_CHANNELS, "D has a cycle of channels")
    form(bool(late) or listed == [], "there are as many delays as channels with one")
    taus = dict(zip(late, numbers(listed, len(late)) if late else ()))
    inside = all(0 <= tau <= asked.families[i].sector[1] for i, tau in taus.items())
    same = all(taus[i] == taus[block[0]] for block in asked.blocks if block[0] in taus for i in block)
    need(inside and same, "the delays are not of the class")
    form(isinstance(given, list) and len(given) == len(own), "the input has one entry for each channel")
    w = [numbers(pair, 2) for pair in given]
    d, N = pieces.quotients(H, [ZERO] * m)
    G = [exact.Form({(taus[j], 0): (Fraction(1), ZERO)}) if j in taus else real(g) for j, g in enumerate(gains)]
    whole = [[(d if i == j else exact.Form()) + f * G[j] for j, f in enumerate(row)] for i, row in enumerate(N)]
    entering = [exact.Form() for _ in range(m)]
    for j, (x, y) in zip(own, w):
        entering = [u + row[j] * exact.Form({(ZERO, 0): (x, y)}) for u, row in zip(entering, N)]
    below = pieces.leading(whole)[-1]
    size = sum((v * v for pair in w for v in pair), ZERO) / asked.bounds(own[0])[1] ** 2
    left = below * below.conjugate() * real(-size)
    for k in own:
        top = pieces.leading([[*row[:k], u, *row[k + 1 :]] for row, u in zip(whole, entering)])[-1]
        left = left + top * top.conjugate()
    need(box(left, omega, omega, 12), "the gain of this loop is not shown to be larger")
    waits = f", the delays being {', '.join(map(str, taus.values()))}" * bool(taus)
    return 8, {"gain": f"|T w| > gamma |w| at omega = {omega}{waits}"}


def graphs(given: Any, asked: Channels, half: bool) -> list[states.Graph]:
    """The nonlinearity of each channel, one being given for each block; odd ones if half a period is."""
    form(isinstance(given, list) and len(given) == len(asked.blocks), "one nonlinearity is needed for each block")
    found = list[states.Graph]()
    for block, one in zip(asked.blocks, given):
        phi, family = states.piecewise(*fields(one, "points", "left", "right")), asked.families[block[0]]
        need(phi.member(family._replace(odd=family.odd or half)), "a nonlinearity is not in its class, or not odd")
        found += [phi] * len(block)
    return found


def sampled(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """A periodic solution in samples, exactly: ``x+ = A x - B phi``, ``phi_i`` that of ``sigma = C x - D phi``.

    After the last sample the state is what it was, or with ``half`` its negative, all ``phi_i`` being odd.
    """
    _, given, listed, state, half = fields(proof, "method", "nonlinearities", "inputs", "state", "half")
    plain = not asked.operators and not any(family.memory for family in asked.families)
    need(plain and H.discrete, "sampled orbits are for discrete time, and for functions of sigma")
    form(type(half) is bool, "half is true or false")
    own, first = graphs(given, asked, half), numbers(state, len(H.A))
    form(isinstance(listed, list) and 0 < len(listed) <= MOST_SAMPLES, f"an orbit has 1 to {MOST_SAMPLES} samples")
    x, second = first, first
    for t, row in enumerate(listed):
        tick()
        mu = [-v for v in numbers(row, len(own))]
        sigma = [dot(c, x) + dot(d, mu) for c, d in zip(H.C, H.D)]
        need(all(phi.at(s) == -v for phi, s, v in zip(own, sigma, mu)), f"sample {t} is not on the nonlinearities")
        x = [dot(a, x) + dot(b, mu) for a, b in zip(H.A, H.B)]
        second = second if t else x
    need(x == [-v if half else v for v in first], "the state does not return")
    need(second != first, "the orbit rests")
    return {"orbit": f"a periodic solution of {len(listed) * (1 + half)} samples"}


def resting(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """A state that stays, exactly: ``A x - B phi`` is 0, or ``x`` in discrete time, ``phi`` that of ``C x - D phi``.

    With an eigenvalue 0 (``z = 1``) of the loop at the lower bounds this is refused: all that is proved there is that
    solutions converge to equilibria.
    """
    _, given, listed, state = fields(proof, "method", "nonlinearities", "inputs", "state")
    plain = not asked.operators and not any(family.memory for family in asked.families)
    need(plain, "equilibria are for functions of sigma")
    own, x = graphs(given, asked, False), numbers(state, len(H.A))
    mu = [-v for v in numbers(listed, len(own))]
    sigma = [dot(c, x) + dot(d, mu) for c, d in zip(H.C, H.D)]
    need(all(phi.at(s) == -v for phi, s, v in zip(own, sigma, mu)), "the state is not on the nonlinearities")
    moved = [dot(a, x) + dot(b, mu) - v * H.discrete for a, b, v in zip(H.A, H.B, x)]
    need(any(x) and not any(moved), "the state is 0, or does not stay")
    least = [asked.bounds(i)[0] for i in range(len(own))]
    closed = closed_by(H, least) if min(least) > -INF else None
    apart = [[v - (i == j) * H.discrete for j, v in enumerate(row)] for i, row in enumerate(closed or [])]
    need(closed is not None and rank(apart) == len(x), "equilibria refute nothing in the critical case")
    return {"equilibrium": "a state other than 0 at which a loop of the class stays"}


def switched_gain(system: Any, family: states.Family, proof: Any) -> dict[str, str]:
    """Gains that repeat: with no eigenvalue of the period's ``M`` outside the unit disc, ``|trace M^N| <= n``.

    Beside dead times :func:`returning`.
    """
    late, gains = system.get("kind") == "delay", numbers(proof.get("gains"))
    low, high = max(family.sector[0], family.slope[0]), min(family.sector[1], family.slope[1])
    need(family.varying, "the nonlinearities of the class do not vary")
    need(all(low <= g <= high for g in gains), "a gain is outside the class")
    if late:
        return returning(one_channel(system), [[g] for g in gains], proof)
    A, b, c, d, discrete = realised(system, ZERO)
    _, _, squarings, bits, *given = fields(
        proof, "method", "gains", "squarings", "bits", *([] if discrete else ["times"])
    )
    times = [None] * len(gains) if discrete else numbers(given[0], len(gains))
    need(0 < len(b) <= 64 and all(t is None or t > 0 for t in times), "orders 1 to 64 and times > 0 are needed")
    need(all(1 + g * d != 0 for g in gains), "1 + g H(inf) = 0", exact.IllPosed)
    closed = {g: states.gained(A, b, [g * v / (1 + g * d) for v in c]) for g in gains}
    return states.grows(
        [(closed[g], t) for g, t in zip(gains, times)], integer(squarings, 0, 64), integer(bits, 64, 4096)
    )


def one_channel(system: Any) -> Plant:
    """The plant of one channel: ``x_i' = x_(i+1)``, ``d x_1 + sum q x_1(t - T) = mu``, ``sigma = sum n x_1(t - T)``."""
    top, d, _ = coefficients(system)
    n, parts, back = len(d) - 1, dict(top), dict(below(system, d))
    need(n > 0, "the plant has no states")

    def row(p: list[Fraction]) -> list[Fraction]:
        """The coefficients below ``s^n``, ascending, over the first of ``d``."""
        return [c / d[0] for c in (*p[::-1], *[ZERO] * n)][:n]

    times, still = sorted({*parts, *back} - {ZERO}), [[ZERO] * n] * (n - 1)
    A = [[Fraction(j == i + 1) for j in range(n)] for i in range(n - 1)] + [[-c for c in row(d)]]
    inner = [[*still, [-c for c in row(back.get(tau, []))]] for tau in times]
    late = tuple((tau, [row(parts.get(tau, []))]) for tau in times)
    B, C = [[Fraction(i == n - 1)] for i in range(n)], [row(parts.get(ZERO, []))]
    return Plant(A, B, C, [[ZERO]], False, late, tuple(inner))


def returning(H: Plant, rows: list[list[Fraction]], proof: Any) -> dict[str, str]:
    """Gains that jump and repeat beside dead times: ``x(t + P) = rho x(t)`` with one real ``rho`` between two.

    With ``P = q h`` and dead times ``p h`` let ``X_j(t) = x(t + j h)``, ``0 <= t <= h``: what arrives is ``rho^m X_i``,
    ``j - p = m q + i``, so that ``X' = L(rho) X``, and ``X_j(h) = X_(j+1)(0)``, ``X_(q-1)(h) = rho X_0(0)``.  There is
    such an ``X != 0`` if ``det(S(rho) - Phi(rho))`` is 0, which changes its sign between both ends.
    """
    _, _, given, ends, bits = fields(proof, "method", "gains", "times", "multiplier", "bits")
    times, ends, bits = numbers(given, len(rows)), numbers(ends, 2), integer(bits, 64, 4096)
    need(0 < len(rows) <= MOST_STEPS and all(t > 0 for t in times), "there is no gain, or a time is not positive")
    stays, known = list[list[Rows]](), dict[tuple[Fraction, ...], list[Rows]]()
    plain = H._replace(A=[[v - (i == j) * (H.pace or 0) for j, v in enumerate(row)] for i, row in enumerate(H.A)])
    for gains in rows:
        if tuple(gains) not in known:
            late = zip((C for _, C in H.late), H.inner or [[[ZERO] * len(H.A)] * len(H.A)] * len(H.late))
            closed = [closed_by(one, gains) for one in (plain, *(plain._replace(A=A, C=C) for C, A in late))]
            need(None not in closed, "1 + H(inf) G is singular for some of the gains", exact.IllPosed)
            known[tuple(gains)] = [one or [] for one in closed]
        stays.append(known[tuple(gains)])
    period, until, n = sum(times, ZERO), [*accumulate(times)], len(H.A)
    unit = lcm(*(tau.denominator for tau in (period, *(tau for tau, _ in H.late))))
    h = Fraction(gcd(*(int(tau * unit) for tau in (period, *(tau for tau, _ in H.late)))), unit)
    q, waits = int(period / h), [0, *(int(tau / h) for tau, _ in H.late)]
    need(0 < n * q <= MOST_PARTS, "the period and the dead times have too small a common part")
    far = exponential([[(H.pace or ZERO) * period]], Fraction(1), bits)
    sure = min(map(abs, ends)) * (far.rows[0][0] - far.error) >= 2**bits
    need(ends[0] < ends[1] and ends[0] * ends[1] > 0 and sure, "a multiplier is not outside the unit circle")
    signs = list[int]()
    for rho in ends:
        Phi = ball(identity(n * q), bits)
        for u, v in pairwise(sorted({ZERO, h, *(t % h for t in until)})):
            L = [[ZERO] * (n * q) for _ in range(n * q)]
            for j in range(q):
                stay = stays[next(k for k, end in enumerate(until) if j * h + u < end)]
                for wait, G in zip(waits, stay):
                    m, i = divmod(j - wait, q)
                    for k, row in enumerate(G):
                        own = L[j * n + k]
                        own[i * n : (i + 1) * n] = [x + rho**m * y for x, y in zip(own[i * n :], row)]
            Phi = product(exponential(L, v - u, bits), Phi)
        S = [
            [(rho if k >= n * (q - 1) else 1) * Fraction(j == (k + n) % (n * q)) for j in range(n * q)]
            for k in range(n * q)
        ]
        signs.append(sign_of_determinant(plus(ball(S, bits), Phi, -1)))
    need(signs[0] * signs[1] < 0, "det(S - Phi) is not shown to change its sign")
    where = f"rho between {ends[0]} and {ends[1]}"
    return {"growth": f"x(t + {period}) = rho x(t) with {where}, where det(S - Phi) of order {n * q} changes its sign"}


def late_pole(H: Plant, asked: Channels, proof: Any) -> dict[str, str]:
    """Constant gains of a plant with dead times, for which what leads from one ``w_j`` to one ``z_i`` has a pole.

    It is ``N/chi``, both analytic, with a pole at ``s_0`` near by: in the disc of radius ``r``, in ``Re s > 0``, ``M``
    a bound of ``|chi''|`` there and ``L`` of ``|N'|``, ``|chi(s_0)| + M r^2/2 < |chi'(s_0)| r`` (Rouche) and ``|N(s_0)|
    > L r``; or ``chi(0) = 0`` exactly.  Of a finite gain it would be analytic in ``Re s > 0``, and bounded.
    """
    _, data, pair, where, near = fields(proof, "method", "gains", "unlimited", "root", "radius")
    form(proof["method"] == "late-gains" and isinstance(pair, list) and len(pair) == 2, "z_i and w_j are named")
    gains, own, (x, y), r = member(data, asked), list(asked.performance or ()), numbers(where, 2), number(near)
    need(bool(own) and len(H.D) <= frequencies.MOST_CHANNELS, "a gain is asked of a performance channel, of few others")
    i, j = (own[integer(v, 1, len(own)) - 1] for v in pair)
    chi, N = pieces.looped(H, gains)
    need((ZERO, len(H.A)) in chi, "the loop with these gains has no solution", exact.IllPosed)
    n = N[i][j]
    if x == y == r == 0:
        at_zero = [sum((u for (_, k), (u, _) in f.items() if not k), ZERO) for f in (chi, n)]
        need(at_zero[0] == 0 != at_zero[1], "s = 0 is no pole from w to z")
    else:
        need(0 < r < x, "the pole is not shown to lie in Re s > 0")
        sizes = [at_point(f, x, y) for f in (chi, slope(chi), n)]
        bounds = [
            sum((abs(c) * (x + abs(y) + r) ** k for (_, k), (c, _) in f.items()), ZERO)
            for f in (slope(slope(chi)), slope(n))
        ]
        need(sizes[0][1] + bounds[0] * r * r / 2 < sizes[1][0] * r, "no root of chi is shown to lie in the disc")
        need(sizes[2][0] > bounds[1] * r, "w does not move, or z not see, what does not fall")
    place = "s = 0" if not r else f"s = {x} + {y} i, within {r}"
    return {"pole": f"with the gains {', '.join(map(str, gains))} a pole from w_{pair[1]} to z_{pair[0]} at {place}"}


def slope(F: exact.Form) -> exact.Form:
    """The derivative of a sum of ``c s^n e^(-s tau)``."""
    first = exact.Form({(tau, n - 1): (n * c, ZERO) for (tau, n), (c, _) in F.items() if n})
    return first + exact.Form({(tau, n): (-tau * c, ZERO) for (tau, n), (c, _) in F.items() if tau})


def at_point(F: exact.Form, x: Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
    """Bounds of ``|F(x + i y)|``, of a sum of ``c s^n e^(-s tau)``."""
    u, v, off = ZERO, ZERO, ZERO
    for tau in {tau for tau, _ in F}:
        p = q = ZERO
        for c in reversed(F.part(0, tau)):
            p, q = p * x - q * y + c, p * y + q * x
        E = exponential([[-x * tau, y * tau], [-y * tau, -x * tau]], Fraction(1), 256)  # e^-x [[cos, sin], [-sin, cos]]
        c, s, error = (Fraction(part, 2**256) for part in (E.rows[0][0], E.rows[0][1], E.error))
        u, v, off = u + p * c + q * s, v + q * c - p * s, off + error * (abs(p) + abs(q))
    return max(abs(u), abs(v)) - off, abs(u) + abs(v) + 2 * off

"""The linear blocks of certificates: read, shifted and realised, and their multipliers; standard library only."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from . import arithmetic as exact
from . import states
from .arithmetic import (
    INF,
    ZERO,
    Form,
    IllPosed,
    Rejected,
    S,
    fields,
    form,
    homogeneous,
    hurwitz,
    integer,
    need,
    number,
    numbers,
    real,
    tick,
)
from .balls import right_zeros

MINUS = real(-1)
X1 = real(1, 0, 1)  # |1 + s|^2
STEPS = ("tsypkin", "tsypkin-odd", "jury-lee")


def powers(M: Any) -> list[Form]:
    """``sum M_ij z^(j - i)`` for the blocks ``(u, u)``, ``(u, v)``, ``(v, v)`` of ``M``, each over the last form."""
    T, found, below = len(M) // 2, list[Form](), real(1, 0, 1)
    for i, j in ((0, 0), (0, T), (T, T)):
        total = Form()
        for h in range(T):
            for k in range(T):
                turn = (real(1) + (S if k > h else MINUS * S)) ** (2 * abs(k - h)) * below ** (T - 1 - abs(k - h))
                total = total + real(M[i + h][j + k]) * turn
        found.append(total)
    return [*found, below ** max(T - 1, 0)]


def masses(data: Any, discrete: bool, rate: Fraction | None) -> tuple[Fraction, Fraction]:
    """``sum |c|``; with a rate ``1 - M(1/r)`` and ``1 - M(r)`` of ``|c|``, or ``1 - M(a)`` and ``1 - M(-a)``.

    Let ``F >= 0`` be the primitive of ``b`` over ``a``, for ``b(a)`` nondecreasing: ``b(x) a(y) <= b(x) a(x) - F(x) +
    F(y)``.  For samples at a distance of ``i``, each times its ``r^-t``, and summed: ``sum b_t a_(t-i) <= r^i sum (b a
    - F) + r^-i sum F``; and ``theta a'`` gives ``theta a`` times the first integral less the second.
    """
    theta, terms = kernels(data, discrete)
    if rate is None:
        mass = sum((abs(c) for c, *_ in terms), ZERO)
        return mass, mass
    found = [-theta * rate, theta * rate]
    for item in data["taps" if discrete else "kernels"]:
        if discrete:
            i, c = item[0], abs(number(item[1]))
            weights = rate**i, rate**-i
        else:
            need("delay" not in item, "a kernel that is a delay has no rational weight")
            a, n, c = number(item["rate"]), item["order"], abs(number(item["coefficient"]))
            need(a > abs(rate), "a kernel decays more slowly than the rate")
            weights = (a / (a + rate)) ** n, (a / (a - rate)) ** n
            weights = weights if item["side"] == "causal" else weights[::-1]
        found = [v + c * w for v, w in zip(found, weights)]
    return found[0], found[1]


def kernels(data: Any, discrete: bool) -> tuple[Fraction, list[tuple[Fraction, Form, Fraction, int]]]:
    """``theta``, and ``(c, h, a, n)`` for each kernel ``c h/(a^2 + omega^2)^n`` of mass ``c``."""
    terms, one, unit = list[tuple[Fraction, Form, Fraction, int]](), real(1), Fraction(1)
    theta, given = (ZERO, *fields(data, "taps")) if discrete else fields(data, "theta", "kernels")
    form(isinstance(given, list) and len(given) <= 400, "taps or kernels are a list")
    for item in given:
        if discrete:
            form(isinstance(item, list) and len(item) == 2 and item[0] != 0, "a tap is a pair, its shift not 0")
            i, sign = integer(item[0], -100, 100), MINUS if item[0] > 0 else one
            terms.append((number(item[1]), (one + sign * S) ** (2 * abs(i)), unit, abs(i)))
        elif isinstance(item, dict) and "delay" in item:
            c, tau = map(number, fields(item, "coefficient", "delay"))
            form(tau != 0, "the delay of a kernel is not 0")
            terms.append((c, Form({(tau, 0): (unit, ZERO)}), unit, 0))
        else:
            c, rate, n, side = fields(item, "coefficient", "rate", "order", "side")
            a, sign, n = number(rate), MINUS if side == "causal" else one, integer(n, 1, 20)
            form(a > 0 and side in ("causal", "anticausal"), "a kernel has a rate > 0 and is causal or anticausal")
            terms.append((number(c), (real(a) * (real(a) + sign * S)) ** n, a, n))
    form(not discrete or len({i for i, _ in given}) == len(given), "a shift is there twice")
    return number(theta) if not discrete else ZERO, terms


class Block(NamedTuple):
    """``H = n/d`` on the axis; in discrete time ``z = (1 + s)/(1 - s)``, which takes 1 to 0 and -1 to infinity."""

    n: Form
    d: Form
    order: int
    direct: Fraction  # H(infinity)
    discrete: bool
    delayed: bool

    @property
    def at_zero(self) -> list[Fraction]:
        """``d(0)`` and ``n(0)``."""
        return [sum((u for (_, n), (u, _) in p.items() if n == 0), ZERO) for p in (self.d, self.n)]


def multiplier(
    name: str, data: Any, B: Block, unbounded: bool, rate: Fraction | None = None
) -> tuple[Form, Form, Form, Form, bool]:
    """``m, p, e, r`` of ``F = Re[m (w N d* + |d|^2) + w e N d*] - w^2 r |N|^2``, over ``p |d|^2``; if odd is needed."""
    none, one = Form(), real(1)
    if name == "circle":
        fields(data)
        return one, one, none, none, False
    if name in ("popov", "off-axis-circle"):
        theta = number(*fields(data, "theta" if name == "popov" else "alpha"))
        need(theta >= 0 or not B.delayed or B.at_zero[0] != 0, "with dead time and a pole at 0 theta >= 0 is needed")
        turn = S if name == "popov" else Form({(ZERO, 0): (ZERO, Fraction(1))})
        return one + turn * real(theta), one, none, none, False
    if name == "park":
        theta, tau = map(number, fields(data, "theta", "tau"))
        need(tau >= 0, "tau < 0")
        return real(1, 0, tau) + S * real(theta), real(1, 0, tau), none, none, False
    if name in STEPS:
        q, ahead, odd = number(*fields(data, "q")), name == "jury-lee", name == "tsypkin-odd"
        need(q >= 0 and not (ahead and unbounded and q), "q < 0, or q > 0 without a bound on the slope")
        step = (one + S) ** 2 + MINUS * X1 if ahead else X1 + (one if odd else MINUS) * (one + MINUS * S) ** 2  # p Z
        return X1, X1, real(q) * step, real(0, 0, 2 * q if ahead else 0), odd
    if name == "order-cone":  # W* M W = uu - 2 Re[uv G] + vv |G|^2, over below, for W = (z^i, -G z^i), G = 1 + w H
        M, own = states.window(data, unbounded)
        m, p, *_, odd = multiplier("zames-falb", {"taps": data["taps"]}, B, unbounded)
        uu, uv, vv, below = powers(M)
        m, uu, uv, vv = m * below, p * uu, p * uv, p * vv
        return m + real(2) * uv + MINUS * (uu + vv), p * below, uu + MINUS * vv, vv, own or odd
    need(name == "zames-falb", f"there is no theorem {name!r:.40} for this kind of proof")
    theta, terms = kernels(data, B.discrete)
    top = {a: max(n for _, _, b, n in terms if b == a) for _, _, a, _ in terms}
    p = m = math.prod((real(a * a, 0, 1) ** n for a, n in top.items()), start=one)
    for c, h, a, n in terms:
        m = m + real(-c) * h * math.prod((real(b * b, 0, 1) ** (k - n * (a == b)) for b, k in top.items()), start=one)
    mass = max(masses(data, B.discrete, rate))
    need(mass <= 1 and (mass < 1 or not unbounded), f"the masses add up to {mass}: more than 1, or 1 without a bound")
    return m, p, S * real(theta) * p, none, any(c < 0 for c, *_ in terms)


def coefficients(system: Any) -> tuple[list[tuple[Fraction, list[Fraction]]], list[Fraction], bool]:
    """Delayed numerators and denominator, descending, and whether in discrete time."""
    if system.get("kind") == "delay":
        _, terms, bottom, *_ = fields(system, "kind", "terms", "denominator", *["feedback"] * ("feedback" in system))
        pairs = isinstance(terms, list) and all(isinstance(x, list) and len(x) == 2 for x in terms)
        form(pairs and len(terms) <= 100, "terms are up to 100 pairs")
        top, d, discrete = [(number(tau), numbers(n)) for tau, n in terms], numbers(bottom), False
        proper = all(tau >= 0 and len(n) < len(d) for tau, n in top) and len({tau for tau, _ in top}) == len(top) > 0
        form(proper, "terms need different delays >= 0 and must be strictly proper")
    else:
        kind, domain, n, bottom = fields(system, "kind", "time", "numerator", "denominator")
        form(kind == "transfer" and domain in ("continuous", "discrete"), "the system is of no kind for this proof")
        top, d, discrete = [(ZERO, numbers(n))], numbers(bottom), domain == "discrete"
    form(len(top[0][1]) <= len(d) and d[0] != 0, "the plant is not proper, or its denominator starts with 0")
    form(len(d) <= 401, f"the plant has degree {len(d) - 1}, and a certificate holds one of at most 400")
    return top, d, discrete


def below(system: Any, d: list[Fraction]) -> list[tuple[Fraction, list[Fraction]]]:
    """What of the denominator ``d + sum q e^(-s T)`` has dead time: pairs of ``T > 0`` and ``q``, of a lower degree."""
    given = system.get("feedback", [])
    pairs = isinstance(given, list) and all(isinstance(x, list) and len(x) == 2 for x in given) and len(given) <= 100
    form(pairs and ("feedback" not in system or len(given) > 0), "feedback is up to 100 pairs")
    found = [(number(tau), numbers(q)) for tau, q in given]
    proper = all(tau > 0 and len(q) < len(d) for tau, q in found) and len({tau for tau, _ in found}) == len(found)
    form(proper, "feedback needs different delays > 0, each of a lower degree than the denominator")
    return found


def block(system: Any) -> Block:
    """The linear block."""
    top, d, discrete = coefficients(system)
    up, down, order, n = (
        (real(1) + S, real(1) + MINUS * S, len(d) - 1, Form()) if discrete else (S, real(1), len(d) - 1, Form())
    )
    for tau, p in top:
        h = homogeneous(p, up, down, order)
        n = n + (h * Form({(tau, 0): (Fraction(1), ZERO)}) if tau else h)
    direct, whole = top[0][1][0] / d[0] if len(top[0][1]) == len(d) else ZERO, homogeneous(d, up, down, order)
    for tau, q in below(system, d):
        whole = whole + homogeneous(q, up, down, order) * Form({(tau, 0): (Fraction(1), ZERO)})
    return Block(n, whole, order, direct, discrete, system["kind"] == "delay")


def paced(system: Any, rate: Fraction) -> Any:
    """The system of ``x(t) r^-t``, in continuous time of ``x(t) e^(a t)``, as it stands in a certificate.

    With ``mu`` and ``sigma`` scaled alike it has ``H(r z)``, ``A/r`` and ``B/r``; or ``H(s - a)`` and ``A + a``.
    """
    form(isinstance(system, dict), "the system is missing")
    kind, discrete = system.get("kind"), system.get("time") == "discrete"
    kinds = ("transfer", "state-space", "multivariable", "family", "channel-family", "varying-family")
    need(kind in (*kinds, "multivariable delay"), "rates are not shown of such plants")
    need(rate > 0 or not discrete, "in discrete time a rate is positive")
    found = dict(system)
    if kind == "family":  # n and d are sums, and this is linear in them
        as_one = {"kind": "transfer", "time": system.get("time")}
        found["terms"] = [
            term | {n: v for n, v in paced(term | as_one, rate).items() if n in term} for term in system["terms"]
        ]
        return found
    if kind in kinds[4:]:  # A + a is (c A + a c)/c, c the common denominator
        found["terms"] = [dict(term) for term in system["terms"]]
        for term in found["terms"]:
            share, more = (Fraction(1), rate * number(term["common"])) if not discrete else (1 / rate, ZERO)
            for side, beside in (("A", more), ("B", ZERO)):
                rows = [numbers(row) for row in term[side]]
                term[side] = [
                    [str(share * v + beside * (i == j)) for j, v in enumerate(row)] for i, row in enumerate(rows)
                ]
        return found
    if kind == "transfer":
        for side in ("numerator", "denominator"):
            p = numbers(system[side])[::-1]
            if discrete:
                p = [c * rate**i for i, c in enumerate(p)]
            for i in range(0 if discrete else len(p)):  # Taylor's shift by -a
                for j in range(len(p) - 2, i - 1, -1):
                    p[j] -= rate * p[j + 1]
            found[side] = [str(c) for c in p[::-1]]
        return found
    for side in ("A", "b") if kind == "state-space" else ("A", "B"):
        rows = [numbers(row) for row in system[side]] if side != "b" else [numbers(system[side])]
        if discrete:
            rows = [[v / rate for v in row] for row in rows]
        elif side == "A":
            rows = [[v + rate * (i == j) for j, v in enumerate(row)] for i, row in enumerate(rows)]
        found[side] = [[str(v) for v in row] for row in rows]
    if kind == "state-space":
        (found["b"],) = found["b"]
    return found


def over_s(d: Form) -> Form:
    """``d/s``, for ``d(0) = 0``."""
    return Form({(tau, n - 1): (v, -u) for (tau, n), (u, v) in d.items() if n})


def at_zero(F: Form, critical: bool) -> int:
    """How often ``F`` vanishes at 0: twice with a pole there, once where ``1 + i alpha`` has turned its phase."""
    return 2 - any(F.part()[1:2]) if critical else 0


def shifted(B: Block, l: Fraction) -> tuple[Form, bool, str]:
    """``d + l n`` for the sector shifted by ``l``, whether it is critical, and what was checked of its roots."""
    d, at = B.d + real(l) * B.n if l else B.d, "z = 1" if B.discrete else "s = 0"
    if any(tau for tau, _ in d):
        return late_roots(B._replace(d=d))
    need(1 + l * B.direct != 0, "1 + l H(inf) = 0 at the lower bound l", IllPosed)
    need(max((n for _, n in d), default=-1) == B.order, "d + l n has a root at z = -1")
    if hurwitz(d):
        return d, False, f"d + l n, of degree {B.order}, has all roots strictly inside"
    low = over_s(d)
    need((ZERO, 0) not in d and hurwitz(low), f"d + l n has a root not strictly inside, and not one at {at} alone")
    residue = sum((u for (_, n), (u, _) in B.n.items() if n == 0), ZERO) / low[ZERO, 0][0] * (2 if B.discrete else 1)
    need(residue > 0, f"the residue at {at} is {residue}, not positive")
    return (
        d,
        True,
        f"d + l n, of degree {B.order}: residue {residue} > 0 at a simple root {at}, the others strictly inside",
    )


def late_roots(B: Block) -> tuple[Form, bool, str]:
    """The same of ``d = d_0 + sum q e^(-s T)``, ``d/s^n`` having a limit: ``d'(0) = d_0'(0) + sum q'(0) - T q(0)``."""
    bottom, top = B.at_zero
    critical = not bottom
    number, rise = right_zeros(
        B.d if B.d.part(B.order % 2)[-1] * (-1) ** (B.order // 2) > 0 else B.d * MINUS, B.order, critical
    )
    need(not number, "d has a root with Re s > 0")
    found = f"d(i omega){' / omega' * critical} {rise}"
    if not critical:
        return B.d, False, found
    slope = sum(((v, -tau * u)[n == 0] for (tau, n), (u, v) in B.d.items() if n < 2), ZERO)
    need(top * slope > 0, f"the residue at s = 0 is {top / slope}, not positive")
    return B.d, True, f"{found}: residue {top / slope} > 0 at a simple root 0"


def linear(B: Block, family: states.Family) -> dict[str, str]:
    """Every constant gain: at the roots of ``Im n d*``, where ``d + g n`` could vanish, ``|d|^2 + g Re n d* > 0``."""
    (l, k), one = family.sector, [1]
    ok = family.linear and abs(l) != INF and not B.delayed and not family.rough
    need(ok, "it is about constant gains from a finite lower bound on")
    d, critical, stable = shifted(B, l)
    need(not critical, "d + l n has a root at 0", exact.Critical)
    cross, square = B.n * d.conjugate(), d * d.conjugate()
    G = cross if k == INF else square + real(k - l) * cross
    g, W = G.part()[::2], cross.part(1)[1::2]
    while W and W[0] == 0:
        W = W[1:]
    full = len(g) == B.order + 1  # less, and Re n d* vanishes at infinity
    ends = (full and min(g[0], g[-1]) > 0) or (k == INF and not (g and g[0] < 0) and not (full and g[-1] < 0))
    inside = exact.roots(W, g, ZERO, None) == exact.roots(W, one, ZERO, None) if W else exact.positive(g or one)
    need(ends and inside, "a gain of the class has a root on the axis, or in the limit")
    found = "no gain of the class has a root on the axis, by Tarski's count, nor at infinity"
    return {"stable": stable, "gains": found}


def mirrored(B: Block) -> Block:
    """``-H``, whose nonlinearities are ``-phi``."""
    return B._replace(n=B.n * MINUS, direct=-B.direct)


def critical_end(B: Block, low: Any, high: Any) -> bool:
    """Whether the gain at an end of the class is a critical case: then its other equilibria refute nothing."""
    d, n = B.at_zero
    for end, sign in ((low, 1), (high, -1)):
        if abs(end) == INF or d + end * n != 0 or (B.delayed and sign == -1):  # there -H is not proved from an end
            continue
        try:
            if shifted(B if sign == 1 else mirrored(B), sign * end)[1]:
                return True
        except Rejected:
            continue
    return False


def realised(system: Any, l: Fraction) -> tuple[Any, Any, Any, Fraction, bool]:
    """``A, b, c, d`` of ``x' = A x + b mu``, ``sigma = c x + d mu`` (or ``x+``), shifted by ``l``, and if discrete."""
    if system.get("kind") == "state-space":
        _, domain, rows, b, c, d = fields(system, "kind", "time", "A", "b", "c", "d")
        form(isinstance(rows, list) and domain in ("continuous", "discrete"), "A is a list of rows, time is one of two")
        A, b, c, d = [numbers(row, len(rows)) for row in rows], numbers(b, len(rows)), numbers(c, len(rows)), number(d)
        need(1 + l * d != 0, "1 + l H(inf) = 0 at the lower bound l", IllPosed)
        gain = l / (1 + l * d)
        if gain:
            A = [[x - gain * u * v for x, v in zip(row, c, strict=True)] for row, u in zip(A, b, strict=True)]
        return A, [u / (1 + l * d) for u in b], [v / (1 + l * d) for v in c], d / (1 + l * d), domain == "discrete"
    if system.get("kind") == "rod-scheme":
        need(l == 0, "for the rod the classes begin at 0")
        return *scheme(system), ZERO, False
    top, d, discrete = coefficients(system)
    n = [ZERO] * (len(d) - len(top[0][1])) + top[0][1]
    need(system["kind"] == "transfer" and len(d) > 1, "state space needs a rational block with a state")
    d = [x + l * y for x, y in zip(d, n, strict=True)]
    need(d[0] != 0, "1 + l H(inf) = 0 at the lower bound l", IllPosed)
    direct, order = n[0] / d[0], len(d) - 1
    A = [[Fraction(j == i + 1) for j in range(order)] for i in range(order - 1)] + [[-x / d[0] for x in d[:0:-1]]]
    c = [(y - direct * x) / d[0] for x, y in zip(d[:0:-1], n[:0:-1], strict=True)]
    return A, [ZERO] * (order - 1) + [Fraction(1)], c, direct, discrete


def rod(system: Any) -> tuple[Fraction, Fraction, Fraction, Fraction, Fraction, int]:
    """``E, rho, L, A, k`` and the number of cells, 0 for the rod itself."""
    cells = fields(
        system, "kind", "E", "rho", "L", "A", "k", *(["cells"] if system.get("kind") == "rod-scheme" else [])
    )
    form(cells[0] in ("rod", "rod-scheme"), "the system is of no kind for this proof")
    E, rho, L, A, k = map(number, cells[1:6])
    form(min(E, rho, L, A) > 0, "E, rho, L and A are positive")
    return E, rho, L, A, k, integer(cells[6], 1, 1_000_000) if len(cells) == 7 else 0


def scheme(system: Any) -> tuple[Any, Any, Any]:
    """``A, b, c`` of the scheme: ``y_i' = s (prev_i - y_i)``, ``z' = y_N + d mu``, ``Z = A sqrt(rho E)`` rational."""
    E, rho, L, area, k, N = rod(system)
    square = area * area * rho * E
    Z = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    need(square == Z * Z and N <= 1000 and k + Z != 0, "Z = A sqrt(rho E) is irrational, N exceeds 1000, or k = -Z")
    s, a, d, order = Z * N / (area * rho * L), (k - Z) / (k + Z), area / Z, 2 * N + 1
    A = [[ZERO] * order for _ in range(order)]
    for i in range(2 * N):
        A[i][i] -= s
        A[i][i - 1 if i else 2 * N - 1] += s if i else -s * a
    A[2 * N][N - 1] = Fraction(1)
    return (
        A,
        [2 * s * d if i == N else d if i == 2 * N else ZERO for i in range(order)],
        [*[ZERO] * (2 * N), Fraction(1)],
    )


@cache
def identity(N: int) -> None:
    """``V' + (1/2) sum (prev_i - y_i)^2 + (1 - a^2)/2 y_2N^2 = 0`` for the scheme, a form in ``y`` and ``p = y_0``.

    Its coefficients are polynomials of degree at most 2 in ``a`` and ``d`` with integer coefficients below 100: they
    vanish if they do at ``a = 10^3``, ``d = 10^9``.
    """
    a, d, total = 10**3, 10**9, dict[tuple[int, int], int]()

    def put(u: int, v: int, x: int) -> None:
        """Add ``x y_u y_v``."""
        key = (u, v) if u < v else (v, u)
        total[key] = total.get(key, 0) + x
        if not total[key]:
            del total[key]

    for i in range(1, 2 * N + 1):
        tick()
        jump = [(i, -1), (2 * N, -a) if i == 1 else (i - 1, 1), *([(0, -2 * d)] if i == N + 1 else [])]
        for u, x in jump:  # jump (2 y_i + jump)
            for v, y in (*jump, (i, 2)):
                put(u, v, x * y)
    for u, v, x in ((0, N, 4 * d), (0, 0, -4 * d * d), (2 * N, 2 * N, 1 - a * a)):  # 2 (2 d P)' = 4 d p (y_N - d p)
        put(u, v, x)
    need(not total, "the dissipation identity fails")

"""An inequality with cosines and sines of the frequency, from kernels that are delays: intervals for `waves.v`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from lure.analysis.certificates.arithmetic import Form
from lure.analysis.export.circle import added, times
from lure.analysis.export.quadratic import whole
from lure.analysis.export.words import folded, integers
from lure.record import described, quantity

Poly = list[int]
ONE, ORDER, TERMS, DOUBLED = 1 << 80, 8, 9, 16
GRID, MOST_INTERVALS = 1 << 14, 300


@described(frozen=True)
class Waves:
    """``K Re F(omega) = p(u) + sum P(u) cos(k u/q) + Q(u) sin(k u/q)`` with ``u = GRID omega``, in integers."""

    p: Poly = quantity("What has no delay, the lowest coefficient first")
    terms: list[tuple[int, Poly, Poly]] = quantity("``k > 0``, ``P`` and ``Q``")
    q: int = quantity("The denominator of the angles")
    factor: Fraction = quantity("``K``")
    delays: list[Fraction] = quantity("The delays, positive")

    @classmethod
    def of(cls, F: Form) -> Waves:
        """From a sum of ``(u + i v) omega^n exp(-i omega tau)``."""
        F = F.folded()
        delays = sorted({tau for tau, _ in F if tau})
        rows = [F.part(), *(F.part(side, tau) for tau in delays for side in (0, 1))]
        scaled = [[v / GRID**n for n, v in enumerate(row)] for row in rows]
        unit = math.lcm(*(v.denominator for row in scaled for v in row))
        p, *sides = (whole(row, unit)[0] for row in scaled)
        angles, q = whole([tau / GRID for tau in delays])
        return cls(p, list(zip(angles, sides[::2], sides[1::2], strict=True)), q, Fraction(unit), delays)

    def found(self) -> tuple[list[int], list[Poly]] | None:
        """Widths of intervals from 0 on, and bounds of the waves beyond; None where an interval is too short."""
        a, h, widths = 0, GRID // 4, list[int]()
        while (tops := self.beyond(a)) is None:
            while h and not self.holds(a, h):
                h //= 2
            if not h or len(widths) == MOST_INTERVALS:
                return None
            widths.append(h)
            a, h = a + h, 2 * h
        return widths, tops

    def beyond(self, a: int) -> list[Poly] | None:
        """The last part of ``everywhere`` of the Coq files: with ``T = |P| + T_2``, ``T_2`` above ``Q^2/(2 |P|)``."""
        left, tops = moved(a, self.p), list[Poly]()
        for _, P, Q in self.terms:
            P, Q = ([abs(v) for v in moved(a, side)] for side in (P, Q))
            if not min(P):
                return None
            rest, more = times(Q, Q), [0] * max(1, len(Q) * 2 - len(P))
            for k in range(len(more) - 1, -1, -1):  # 2 |P| T_2 has no coefficient below that of Q^2
                own = slice(len(P) - 1, None) if k else slice(None)
                more[k] = max([0, *(-(-v // (2 * c)) for v, c in zip(rest[k:][own], P[own], strict=False))])
                rest = added(rest, [0] * k + P, -2 * more[k])
            tops.append(added(P, more))
            left = added(left, tops[-1], -1)
        return tops if min(left) >= 0 else None

    def holds(self, a: int, h: int) -> bool:
        """``on_interval`` of the Coq files."""
        weight = self.q**ORDER * math.factorial(ORDER)
        left = [ONE * weight * v for v in moved(a, self.p)]
        for k, P, Q in self.terms:
            known = angle(k * a, self.q)
            if known is None:
                return False
            (c, s, e), (C, S, _) = known, nest(ORDER, k, self.q)
            P, Q = moved(a, P), moved(a, Q)
            left = added(left, times(C, added([c * v for v in P], Q, s)))
            left = added(left, times(S, added([c * v for v in Q], P, -s)))
            left = added(left, sizes(P, Q), -2 * (weight * e + (ONE + e) * (k * h) ** ORDER))
        n = len(left) - 1
        own = [v * h**i for i, v in enumerate(left)]
        return sum(own) >= 0 and all(
            sum(v * math.comb(n - i, j - i) for i, v in enumerate(own[: j + 1])) >= 0 for j in range(n + 1)
        )

    def definitions(self, widths: Poly, tops: list[Poly]) -> Iterator[str]:
        """The numbers for Coq, and the test that they pass."""
        listed = "; ".join(f"({k}, ({integers(P)}, {integers(Q)}))" for k, P, Q in self.terms)
        yield folded(f"Definition still : list Z := {integers(self.p)}%Z.")
        yield folded(f"Definition waves_ : list wave := [{listed}]%Z.")
        yield folded(f"Definition widths : list Z := {integers(widths)}%Z.")
        yield folded(f"Definition tops : list (list Z) := {integers(tops)}%Z.")
        yield f"Lemma inside : everywhere {ORDER} {self.q} 0 widths still waves_ tops = true."
        yield "Proof. vm_cast_no_check (eq_refl true). Qed."


def moved(a: int, p: Poly) -> Poly:
    """``p(a + t)``."""
    found = list[int]()
    for c in reversed(p):
        found = added([c, *found], found, a)
    return found


def sizes(P: Poly, Q: Poly) -> Poly:
    """Coefficients above ``|P| + |Q|`` for ``t >= 0``."""
    return added([*map(abs, P)], [*map(abs, Q)])


def nest(m: int, p: int, q: int) -> tuple[Poly, Poly, int]:
    """Taylor's polynomials of ``cos(p t/q)`` and ``sin(p t/q)``, ``m`` terms of ``e^(i p t/q)``, times the last."""
    c, s, weight = list[int](), list[int](), 1
    for j in range(m, 0, -1):
        weight *= q * j
        c, s = [weight, *(-p * v for v in s)], [0, *(p * v for v in c)]
    return c, s, weight


def angle(p: int, q: int) -> tuple[int, int, int] | None:
    """Cosine and sine of ``p/q >= 0`` in units of ``1/ONE``, and their error at most; None where ``p/q`` is large."""
    c, s, weight = nest(TERMS, p, q << DOUBLED)
    if ONE * p**TERMS > weight:
        return None
    x, y, e = ONE * sum(c) // weight, ONE * sum(s) // weight, 2
    for _ in range(DOUBLED):
        x, y, e = (x * x - y * y) // ONE, 2 * x * y // ONE, 4 * e + 2
    return x, y, e

"""An inequality on the unit circle as a polynomial that Coq computes itself: `circle.v`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from typing import Any

from lure.analysis.certificates import arithmetic as exact
from lure.analysis.export.quadratic import whole
from lure.analysis.export.words import folded, integers, refused
from lure.record import described, quantity

Poly = list[Any]  # whole numbers or fractions, the lowest coefficient first
FINEST, DEEPEST = 160, 200


@dataclass(frozen=True)
class Curve:
    """A polynomial of ``w`` with complex coefficients."""

    re: Poly
    im: Poly

    def plus(self, other: Curve) -> Curve:
        """The sum."""
        return Curve(added(self.re, other.re), added(self.im, other.im))

    def times(self, other: Curve) -> Curve:
        """The product."""
        re = added(times(self.re, other.re), times(self.im, other.im), -1)
        return Curve(re, added(times(self.re, other.im), times(self.im, other.re)))

    def scaled(self, c: int) -> Curve:
        """Times a number."""
        return Curve([c * v for v in self.re], [c * v for v in self.im])

    @property
    def conjugate(self) -> Curve:
        """The conjugate for real ``w``."""
        return Curve(self.re, [-v for v in self.im])


def added(p: Poly, q: Poly, factor: int | Fraction = 1) -> Poly:
    """``p + factor q``."""
    found = [*p, *[0] * (len(q) - len(p))]
    for i, v in enumerate(q):
        found[i] += factor * v
    return found


def times(p: Poly, q: Poly) -> Poly:
    """``p q``."""
    found = [0] * (len(p) + len(q) - 1) if p and q else []
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            found[i + j] += a * b
    return found


def bottom(power: int) -> Poly:
    """``(1 + w^2)^power``."""
    return [math.comb(power, i // 2) if i % 2 == 0 else 0 for i in range(2 * power + 1)]


def _z(m: int, i: int) -> Curve:
    """``z^i (1 + w^2)^m``, ``z = (1 + i w)^2/(1 + w^2)``."""
    found = Curve(bottom(m - i), [])
    for _ in range(i):
        found = found.times(Curve([1, 0, -1], [0, 2]))
    return found


@described(frozen=True, kw_only=True)
class Circle:
    """``Re (m X conj D) - W* M W/q > 0`` on the unit circle."""

    X: list[int] = quantity("``den + k num``, the highest coefficient first")
    D: list[int] = quantity("``den + l num``, the highest coefficient first, times the same number as ``X``")
    factor: Fraction = quantity("That number")
    taps: list[tuple[int, int, bool]] = quantity(
        "``c``, the delay, and whether it is causal, of ``m = 1 - sum c/h z^-i``"
    )
    h: int = quantity("Their denominator")
    M: list[list[int]] = quantity("The form of the samples")
    q: int = quantity("Its denominator")

    @classmethod
    def of(
        cls,
        X: list[Fraction],
        D: list[Fraction],
        taps: list[tuple[Fraction, int, bool]],
        window: tuple[list[list[int]], int],
    ) -> Circle:
        """With integers."""
        both, factor = whole([*X, *D])
        top, h = whole([c for c, *_ in taps])
        listed = [(c, i, causal) for c, (_, i, causal) in zip(top, taps, strict=True)]
        return cls(
            X=both[: len(X)], D=both[len(X) :], factor=Fraction(factor), taps=listed, h=h, M=window[0], q=window[1]
        )

    @property
    def places(self) -> tuple[int, int, int, int, int]:
        """Order, reach of the taps, what it lacks of that of the samples, their number, and what these lack."""
        m, count = max((i for _, i, _ in self.taps), default=0), len(self.M) // 2
        return len(self.D) - 1, m, max(0, 2 * count - m), count, max(0, m - 2 * count)

    def polynomials(self) -> tuple[Poly, Poly]:
        """``h q`` times the left side, and ``|D|^2``, times a power of ``1 + w^2``."""
        n, m, a, count, b = self.places
        X, D = (
            reduce(Curve.plus, (_z(n, len(p) - 1 - i).scaled(c) for i, c in enumerate(p))) for p in (self.X, self.D)
        )
        multiplier = Curve([self.h * v for v in bottom(m)], [])
        for c, i, causal in self.taps:
            turn = _z(m, i)
            multiplier = multiplier.plus((turn.conjugate if causal else turn).scaled(-c))
        first = multiplier.times(X.times(D.conjugate)).re
        samples = [_z(count, i).times(side) for side in (D, X.scaled(-1)) for i in range(count)]
        form: Poly = []
        for parts in ([w.re for w in samples], [w.im for w in samples]):
            for row, left in zip(self.M, parts, strict=True):
                inner: Poly = []
                for v, right in zip(row, parts, strict=True):
                    inner = added(inner, right, v)
                form = added(form, times(left, inner))
        left = added([self.q * v for v in times(bottom(a), first)], times(bottom(b), form), -self.h)
        return left, times(bottom(m + a), D.times(D.conjugate).re)

    def definitions(self) -> list[str]:
        """The lists."""
        taps = "; ".join(f"({c}, {i}%nat, {str(causal).lower()})" for c, i, causal in self.taps)
        return [
            folded(f"Definition {name} : list Z := {integers(row)}%Z.")
            for name, row in (("closed_k", self.X), ("closed_l", self.D))
        ] + [folded(f"Definition kernel_ : list (Z * nat * bool) := [{taps}]%Z.")]

    def test(self) -> str:
        """The test that Coq computes.

        Raises
        ------
        refused
            An ``InputError``: it leaves too little room.
        """
        left, square = self.polynomials()
        for power in range(4, FINEST, 2):
            P = added([v << power for v in left], square, -1)
            while not P[-1]:
                P.pop()
            if len(P) == len(left) and exact.positive([Fraction(v) for v in P]):
                break
        else:
            raise refused("its inequality leaves no room that can be told")
        n, m, a, count, b = self.places
        form = "M" if self.M else "[]"
        return (
            f"{n} {m} {a} {count} {b} {self.h} {self.q} 1 {1 << power} closed_k closed_l kernel_ {form} {tree(P[::2])}"
        )


def tree(p: list[int], depth: int = 0) -> str:
    """A witness for ``positive`` of the Coq files: that ``p > 0`` on ``[0, inf)``, the lowest coefficient first.

    ``p``: a polynomial that is positive there, with a positive leading coefficient; ``depth``: how often it was split.

    Raises
    ------
    refused
        It leaves too little room.
    """
    if p[0] > 0 and min(p) >= 0:
        return "Signs"
    if depth > DEEPEST:
        raise refused("its inequality leaves too little room")
    shared, n = math.gcd(*p), len(p) - 1
    power = round((abs(p[0] // shared).bit_length() - abs(p[-1] // shared).bit_length()) / n)  # mean size of the roots
    a, b = (1 << power, 1) if power >= 0 else (1, 1 << -power)
    q = [c * a**i * b ** (n - i) for i, c in enumerate(p)]
    below, beyond = tree(exact.onwards(q[::-1]), depth + 1), tree(exact.onwards(q), depth + 1)
    return f"(Split {a} {b} {below} {beyond})"

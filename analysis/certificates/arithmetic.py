"""The exact arithmetic of the checker, and how it reads numbers; standard library only.

No statement about a loop is made here.  Polynomials and their signs (Sturm, Tarski, Routh), quasi-polynomials on the
imaginary axis; what is not rational is in ``balls``.
"""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from itertools import pairwise
from typing import Any

NUMBER = re.compile(r"-?[0-9]{1,4000}(/[1-9][0-9]{0,3999})?")
ZERO, INF, LARGEST_FILE, MOST_PARTS = Fraction(0), math.inf, 12_000_000, 200_000
DEADLINE = [INF]


class Malformed(ValueError):
    """The file is no certificate at all."""


class Rejected(ValueError):
    """The certificate does not prove its claim."""


class OutOfTime(Rejected):
    """The time allowed is over."""


class IllPosed(Rejected):
    """``1 + g H(inf)`` vanishes for a gain ``g`` of the class."""


class Critical(Rejected):
    """The loop has a pole at 0, and the theorem needs a stable one."""


def need(condition: bool, reason: str, error: type[ValueError] = Rejected) -> None:
    """A hypothesis fails."""
    if not condition:
        raise error(reason)


def posed(condition: bool, reason: str) -> None:
    """The equation of a loop has no one solution."""
    need(condition, reason, IllPosed)


def form(condition: bool, reason: str) -> None:
    """It is no certificate."""
    need(condition, reason, Malformed)


def tick() -> None:
    """Called in every long loop."""
    need(time.monotonic() < DEADLINE[0], "the time allowed for checking is over", OutOfTime)


@contextmanager
def checking(seconds: float) -> Iterator[None]:
    """The time allowed; and whatever goes wrong in it is a refusal."""
    DEADLINE[0] = time.monotonic() + seconds
    try:
        yield
    except (Rejected, Malformed):
        raise
    except (KeyError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise Malformed(f"a part is not of its form: {type(error).__name__} {error!s:.100}") from None
    except (ArithmeticError, MemoryError, ValueError) as error:
        raise Rejected(f"too large to be checked: {type(error).__name__} {error!s:.100}") from None
    finally:
        DEADLINE[0] = INF


def fields(data: Any, *names: str) -> list[Any]:
    """The values of an object that has exactly these keys."""
    form(
        isinstance(data, dict) and set(data) == set(names), f"an object needs the keys {', '.join(names)}, and no other"
    )
    return [data[name] for name in names]


def number(text: Any) -> Fraction:
    """An exact number from the text ``p`` or ``p/q``."""
    tick()
    form(isinstance(text, str) and NUMBER.fullmatch(text) is not None, f"not a number of the form p/q: {text!r:.60}")
    p, _, q = text.partition("/")
    return Fraction(int(p), int(q)) if q else Fraction(int(p))


def numbers(data: Any, length: int | None = None) -> list[Fraction]:
    """A list of exact numbers, of a certain length if given."""
    form(isinstance(data, list) and 0 < len(data) <= 2000, "a list of 1 to 2000 numbers is missing")
    form(length in (None, len(data)), f"a list needs {length} numbers")
    return [number(text) for text in data]


def integer(data: Any, least: int, most: int) -> int:
    """A count within bounds."""
    form(type(data) is int and least <= data <= most, f"a count is {data!r:.40}, not within {least} and {most}")
    return int(data)


def extended(data: Any) -> Any:
    """A bound of a class; "finite" means every finite one."""
    infinities = {"inf": INF, "finite": INF, "-inf": -INF}
    return infinities[data] if isinstance(data, str) and data in infinities else number(data)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    form(len({key for key, _ in pairs}) == len(pairs), "an object has a key twice")
    return dict(pairs)


def _no_float(text: str) -> Any:
    raise Malformed(f"a JSON number is not an integer: {text:.40}; exact numbers are text p/q")


def parsed(data: str | bytes) -> Any:
    """JSON without duplicate keys, floats or long integers."""
    form(len(data) <= LARGEST_FILE, f"more than {LARGEST_FILE} bytes")
    try:
        data = data.encode() if isinstance(data, str) else data
        form(sum(map(data.count, (b"[", b"{", b":"))) <= MOST_PARTS, f"more than {MOST_PARTS} lists and keys")
        return json.loads(data, object_pairs_hook=_unique, parse_float=_no_float, parse_constant=_no_float)
    except Malformed:
        raise
    except (ValueError, RecursionError) as error:
        raise Malformed(f"no JSON: {error!s:.200}") from None


# -- sums of (u + i v) omega^n exp(-i omega tau)
NOW: Any = 0  # no delay: ZERO, whose hash takes longer


class Form(dict[tuple[Fraction, int], tuple[Fraction, Fraction]]):
    """A sum of ``(u + i v) omega^n exp(-i omega tau)``, as ``{(tau, n): (u, v)}``."""

    def __add__(self, other: Form) -> Form:
        out = Form(self)
        for key, (u, v) in other.items():
            a, b = out.get(key, (ZERO, ZERO))
            out[key] = (a + u, b + v)
        return Form({key: z for key, z in out.items() if any(z)})

    def __mul__(self, other: Form) -> Form:
        (p, left), (q, right), out = self.whole(), other.whole(), dict[tuple[Fraction, int], tuple[int, int]]()
        for (s, m), (a, b) in left:
            tick()
            for (t, n), (c, d) in right:
                key = (s + t if t else s, m + n)
                u, v = out.get(key, (0, 0))
                out[key] = (u + a * c - b * d, v + a * d + b * c)
        return Form({key: (Fraction(u, p * q), Fraction(v, p * q)) for key, (u, v) in out.items() if u or v})

    def whole(self) -> tuple[int, list[tuple[tuple[Fraction, int], tuple[int, int]]]]:
        """A common denominator, and the terms times that: sums of integers are quick."""
        unit = math.lcm(*(x.denominator for z in self.values() for x in z))
        rows = [[x.numerator * (unit // x.denominator) for x in z] for z in self.values()]
        return unit, [(key, (u, v)) for key, (u, v) in zip(self, rows)]

    def __pow__(self, n: int) -> Form:
        return self * self ** (n - 1) if n > 0 else real(1)

    def conjugate(self) -> Form:
        """The complex conjugate."""
        return Form({(-tau, n): (u, -v) for (tau, n), (u, v) in self.items()})

    def folded(self) -> Form:
        """A sum with the same real part and no ``tau < 0``."""
        ahead = Form({key: z for key, z in self.items() if key[0] < 0})
        return Form({key: z for key, z in self.items() if key[0] >= 0}) + ahead.conjugate() if ahead else self

    def part(self, imaginary: int = 0, tau: Fraction = NOW) -> list[Fraction]:
        """Coefficients of one term, ascending."""
        top = max((n for (t, n), z in self.items() if t == tau and z[imaginary]), default=-1)
        return [self.get((tau, n), (ZERO, ZERO))[imaginary] for n in range(top + 1)]


def real(*p: Fraction | int) -> Form:
    """A real polynomial in omega, ascending."""
    return Form({(NOW, n): (Fraction(c), ZERO) for n, c in enumerate(p) if c})


S, X1, MINUS = Form({(NOW, 1): (ZERO, Fraction(1))}), real(1, 0, 1), real(-1)  # s = i omega, |1 + s|^2


def ascending(d: Form) -> list[Fraction]:
    """Real coefficients of d(s), s = i omega."""
    found = [d.get((NOW, n), (ZERO, ZERO))[n % 2] for n in range(max((n for _, n in d), default=-1) + 1)]
    return [c if n % 4 < 2 or not c else -c for n, c in enumerate(found)]


def homogeneous(p: list[Fraction], up: Form, down: Form, degree: int) -> Form:
    """Down^degree p(up/down), p descending."""
    if up is S:  # and down = 1: the powers of s are known
        powers = [(n, c) for n, c in enumerate(reversed(p)) if c]
    else:
        unit = math.lcm(*(c.denominator for c in p))
        u, v = ([int(c) if c.denominator == 1 else c for c in ascending(form)] for form in (up, down))
        out, weight = list[Any](), list[Any]([1])
        for c in p:
            out = added(multiplied(out, u), [int(c * unit) * x for x in weight])
            weight, degree = multiplied(weight, v), degree - 1
        for _ in range(degree + 1):
            out = multiplied(out, v)
        powers = [(n, Fraction(c, unit)) for n, c in enumerate(out) if c]
    turned = [(n, c if n % 4 < 2 else -c) for n, c in powers]
    return Form({(NOW, n): (ZERO, c) if n % 2 else (c, ZERO) for n, c in turned})


def added(p: list[Any], q: list[Any]) -> list[Any]:
    """The sum of two real polynomials, ascending."""
    p, q = (p, q) if len(p) >= len(q) else (q, p)
    return [a + b for a, b in zip(p, q)] + p[len(q) :]


def multiplied(p: list[Any], q: list[Any]) -> list[Any]:
    """The product of two real polynomials, ascending."""
    tick()
    out = [0] * (len(p) + len(q) - 1 if p and q else 0)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] += a * b
    return out


# -- real polynomials, ascending
def primitive(p: Any) -> list[int]:
    """Integers without common divisor, a positive multiple of p; no zeros at the end."""
    exact = [a if isinstance(a, int) else Fraction(a) for a in p]
    while exact and not exact[-1]:
        exact.pop()
    tick()
    unit = math.lcm(*(a.denominator for a in exact))
    whole = [a.numerator * (unit // a.denominator) for a in exact]
    shared = math.gcd(*whole)
    return [v // shared for v in whole]


def chain(p: list[int], q: list[int]) -> list[list[int]]:
    """Signed remainders; the last is the greatest common divisor."""
    rows = [p, q]
    while rows[-1]:
        tick()
        a, b = rows[-2:]
        while len(a) >= len(b):
            lead, top, low = abs(b[-1]), a[-1] if b[-1] > 0 else -a[-1], len(a) - len(b)
            a = primitive(lead * x - (top * b[i - low] if i >= low else 0) for i, x in enumerate(a))
        rows.append([-x for x in a])
    return rows[:-1]


def value(p: Any, x: Fraction) -> Fraction:
    """P(x), with one division."""
    total, unit = 0, 1
    for a in reversed(p):
        tick()
        total, unit = total * x.numerator + a * unit, unit * x.denominator
    return Fraction(total) * x.denominator / unit


def roots(p: Any, q: Any, low: Fraction, high: Fraction | None) -> int:
    """Distinct roots of ``p`` in ``(low, high)`` with ``q > 0`` less those with ``q < 0``; ``high`` None: infinity.

    By Sturm and Tarski; ``p`` must not vanish at the ends.
    """
    slope = real(*(i * a for i, a in enumerate(p) if i))
    rows = chain(primitive(p), primitive((slope * real(*q)).part()))
    ends = [value(row, low) for row in rows], [row[-1] if high is None else value(row, high) for row in rows]
    before, after = (sum((a > 0) != (b > 0) for a, b in pairwise([x for x in end if x])) for end in ends)
    return before - after


def positive(p: Any, low: Fraction = ZERO, high: Fraction | None = None) -> bool:
    """Whether ``p > 0`` on ``[low, high]``; for None on ``[low, inf)``, with a positive leading coefficient."""
    if not p or value(p, low) <= 0 or (p[-1] if high is None else value(p, high)) <= 0:
        return False
    if low == 0 and high is not None and p[0] + sum(min(a, 0) * high**i for i, a in enumerate(p) if i) > 0:
        return True
    if low == 0 and high is not None and len(p) > 4:
        found = positive_near(primitive(a * high**i for i, a in enumerate(p)))  # over [0, 1]
        if found is not None:
            return found
    p = p[::2] if low == 0 and high is None and not any(p[1::2]) else p
    if low > 0 and high is None:  # p(low + low x)
        p, low = onwards(primitive(a * low**i for i, a in enumerate(p))), ZERO
    if low == 0 and high is None and len(p) > 4:  # Sturm's chains are long
        whole = primitive(p)
        near = positive_near(whole)
        found = positive_near(whole[::-1]) if near else near  # at 1/x
        if found is not None:
            return found
    return len(p) == 1 or roots(p, [1], low, high) == 0


def positive_near(p: list[int]) -> bool | None:
    """Whether ``p > 0`` on ``[0, 1]``, from its signs at points and by Descartes' rule between them; None: undecided.

    With ``(1 + x)^n p(1/(1 + x))`` without a negative coefficient ``p`` has no root in ``(0, 1)``; else both halves.
    """
    parts, count = [p], 0
    while parts:
        tick()
        p, count, n = parts.pop(), count + 1, len(p) - 1
        if p[0] <= 0 or sum(p) <= 0:
            return False
        if min(onwards(p[::-1])) >= 0:
            continue
        if count > 10 * n:
            return None
        half = primitive(a << n - i for i, a in enumerate(p))  # p(x/2)
        half += [0] * (n + 1 - len(half))
        parts += [half, onwards(half)]
    return True


def onwards(p: list[int]) -> list[int]:
    """``p(x + 1)``."""
    p = list(p)
    for i in range(len(p) - 1):
        for j in range(len(p) - 2, i - 1, -1):
            p[j] += p[j + 1]
    return p


def hurwitz(d: Form) -> bool:
    """All roots in Re s < 0: the first column of Routh's array keeps its sign."""
    p = primitive(ascending(d))[::-1] or [0]
    a, b = ([x if p[0] > 0 else -x for x in p[i::2]] for i in (0, 1))
    while b and b[0] > 0:
        tick()
        row = [b[0] * x - a[0] * y for x, y in zip(a[1:], b[1:] + [0] * len(a))]
        a, b = b, [x // (math.gcd(*row) or 1) for x in row]
    return a[0] > 0 and not b


# -- matrices
def eliminated(left: Any, right: Any) -> list[list[Fraction]] | None:
    """The solution ``X`` of ``left X = right``, None if ``left`` is singular; by Bareiss and Jordan."""
    m, last, table = len(left), 1, list[list[int]]()
    for a, b in zip(left, right):
        row = [Fraction(v) for v in (*a, *b)]
        unit = math.lcm(*(v.denominator for v in row))
        table.append([v.numerator * (unit // v.denominator) for v in row])
    for i in range(m):
        tick()
        pivot = next((j for j in range(i, m) if table[j][i]), None)
        if pivot is None:
            return None
        table[i], table[pivot] = table[pivot], table[i]
        p, line = table[i][i], table[i]
        for j in range(m):
            if j != i:
                f = table[j][i]
                table[j] = [(p * v - f * u) // last for v, u in zip(table[j], line)]  # without a remainder
        last = p
    return [[Fraction(v, last) for v in row[m:]] for row in table]


def lasting(rows: Any, flow: Any) -> list[list[Fraction]]:
    """Independent linear equations of ``(x, phi)`` that hold at all times if the given ones do, ``x' = flow (x, phi)``.

    Of one in ``x`` alone the derivative is one, too.
    """
    n, before = len(flow), -1
    while True:
        left, kept = [row for row in rows if any(row)], list[list[Fraction]]()
        for j in [*range(n, len(flow[0])), *range(n)]:  # phi first: what is left after it is in x alone
            tick()
            pivot = next((row for row in left if row[j]), None)
            if pivot is not None:
                others = [(row, row[j] / pivot[j]) for row in left if row is not pivot]
                left = [[v - f * u for v, u in zip(row, pivot)] if f else row for row, f in others]
                kept.append(pivot)
        if len(kept) == before:
            return kept
        before, still = len(kept), [row[:n] for row in kept if not any(row[n:])]
        rows = [*kept, *([sum((a * v for a, v in zip(row, c)), ZERO) for c in zip(*flow)] for row in still)]

"""Whether a sum of polynomials times cosines and sines is positive, on boxes of frequency and beyond the last one."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from fractions import Fraction

from flint import arb, arb_series, fmpq_poly

from lure.analysis.certificates.second.axis import Curve, Need
from lure.analysis.certificates.second.numerics import (
    SERIES_TERMS,
    X,
    ball,
    positive_from_zero,
    to_fmpq,
    to_fraction,
    working_precision,
)
from lure.analysis.certificates.second.reading import NotShown, count, listed, number, record, require, tick

BITS = 256
MOST_BOXES = 60_000
DOUBLINGS = 60
NARROWEST = 40  # powers of 2 below the last frequency


def require_cover(curve: Curve, proof: object, need: Need) -> None:
    """Check ``F > 0`` on ``[0, inf)``, and for ``need = "positive"`` that it stays away from 0 over ``|d|^2``.

    The boxes of the file must follow one another from 0; each is halved here until a Taylor bound in ball arithmetic
    decides it.  Beyond them the part without delay must exceed the absolute values of the others, from some frequency
    on up to which boxes are added.

    Raises
    ------
    NotShown
        The boxes leave a gap, or positivity is not shown.
    """
    boxes = read_boxes(proof)
    end = at = boxes[-1][1]
    for _ in range(DOUBLINGS):
        if _tail(curve, end, need):
            break
        end *= 2
    else:
        raise NotShown("the part without delay does not outweigh the others at high frequencies")
    boxes.append((at, end))
    with working_precision(BITS):
        require(_positive(curve, boxes), "the inequality is not shown on the boxes")


Parts = tuple[fmpq_poly, fmpq_poly, fmpq_poly]


def require_whatever_delay(parts: Parts, waits: tuple[Fraction, Fraction], full: int, *, critical: bool) -> None:
    r"""Check ``F = A + E cos(omega T) + omega O sin(omega T) > 0`` for all ``T`` between two, away from 0 at infinity.

    As a function of ``T`` it goes up and down as a cosine of ``omega T`` does.  While ``omega`` times the range of
    ``T`` is below ``pi``, it is least at an end, unless it falls at the first and rises at the last; and it is positive
    where it is so at an end and ``A^2 > E^2 + omega^2 O^2``.

    Parameters
    ----------
    parts : tuple of fmpq_poly
        ``A``, ``E`` and ``O`` in ``x = omega^2``.
    waits : tuple of Fraction
        The least and the largest ``T``.
    full : int
        The degree of ``A`` that keeps ``F`` away from 0.
    critical : bool
        Whether ``F`` vanishes at 0 as ``x`` does.

    Raises
    ------
    NotShown
        It is not shown.
    """
    (plain, even, odd), (first, last) = parts, waits
    curves = [_with_delay(parts, T, full, critical=critical) for T in dict.fromkeys((last, first))]
    end = 1 / last
    for _ in range(DOUBLINGS):
        if _tail(curves[0], end, "positive"):
            break
        end *= 2
    else:
        raise NotShown("the part without delay does not outweigh the others at high frequencies")
    with working_precision(BITS):
        for curve in curves:
            require(_positive(curve, [(Fraction(0), end)]), "the inequality is not shown at an end of the dead time")
        room = plain * plain - even * even - X * odd * odd
        apart, rise, e, o = ([arb(c) for c in p.coeffs()] for p in (room, room.derivative(), even, odd))
        left, narrowest = deque([(Fraction(0), end)] * (first < last)), end / 2**NARROWEST
        while left:
            tick()
            low, high = left.popleft()  # the widest, so that what fails is met before much is looked at beside it
            omega = ball(low).union(ball(high))
            x = omega * omega
            starts, ends = _slope(e, o, omega, first), _slope(e, o, omega, last)
            room_left = _ball_at(apart, x.mid()) + _ball_at(rise, x) * (x - x.mid())
            one_way = starts > 0 or ends < 0
            if (one_way and high * (last - first) < 3) or room_left > 0:
                continue
            never = room_left <= 0 and (low * (last - first) >= 3 or (starts <= 0 and ends >= 0))  # nor in any part
            require(
                not never and high - low > narrowest, "the inequality is not shown between the ends of the dead time"
            )
            left += [(low, (low + high) / 2), ((low + high) / 2, high)]


def _slope(even: list[arb], odd: list[arb], omega: arb, T: Fraction) -> arb:
    """How fast ``F`` changes with ``T``, over ``omega^2``."""
    x, angle, wait = omega * omega, omega * ball(T), ball(T)
    return _ball_at(odd, x) * angle.cos() - _ball_at(even, x) * wait * angle.sinc()


def _with_delay(parts: Parts, T: Fraction, full: int, *, critical: bool) -> Curve:
    """``F`` for one ``T``."""
    plain, even = (p // X if critical else p for p in parts[:2])
    none = fmpq_poly([])
    terms = {Fraction(0): (plain, none), T: (even, parts[2])} if T else {T: (plain + even, none)}
    return Curve(terms=terms, full=full - critical, divided=critical)


def read_boxes(proof: object) -> list[tuple[Fraction, Fraction]]:
    """The boxes of a cover, neighbours from 0 on.

    Raises
    ------
    NotShown
        They leave a gap, or there are none.
    """
    found = record(proof, "method", "boxes", "order")
    count(found["order"])
    at = Fraction(0)
    boxes: list[tuple[Fraction, Fraction]] = []
    for box in listed(found["boxes"]):
        ends = [number(end) for end in listed(box)]
        require(len(ends) == 2 and ends[0] == at < ends[1], "the boxes leave a gap")
        boxes.append((ends[0], ends[1]))
        at = ends[1]
    require(len(boxes) > 0, "there are no boxes")
    return boxes


def _tail(curve: Curve, start: Fraction, need: Need) -> bool:
    r"""Whether ``F > 0`` for ``omega >= start`` whatever the cosines and sines are.

    With ``U`` the part without delay and ``A_j`` the others it follows from ``U > 0`` and
    ``U^2 > \sum_j |A_j|^2/\lambda_j >= (\sum_j |A_j|)^2``, ``\sum_j \lambda_j = 1``, which for terms in proportion is
    no loss with ``lambda_j`` in proportion to ``|A_j|`` at the start.
    """
    x, full, terms = to_fmpq(start * start), curve.full + curve.divided, curve.terms
    if curve.divided:  # what was before
        terms = {tau: (X * U + fmpq_poly([curve.level.get(tau, 0)]), V) for tau, (U, V) in terms.items()}
    plain = terms[Fraction(0)][0]
    squares = [U * U + X * V * V for tau, (U, V) in terms.items() if tau]
    sizes = [size for size in squares if size.degree() >= 0]
    weights = [_root(to_fraction(size(x))) for size in sizes]
    total = plain * plain
    for size, weight in zip(sizes, weights, strict=True):
        total -= size * to_fmpq(sum(weights) / weight)
    if need != "nonnegative" and (plain.degree() < full or total.degree() < 2 * full):
        return False
    beyond = fmpq_poly([x, 1])
    return positive_from_zero(plain(beyond)) and positive_from_zero(total(beyond))


def _root(value: Fraction) -> Fraction:
    """About the square root, and positive."""
    near = math.sqrt(value) if value > 0 else 0.0
    return Fraction(near) if 0 < near < math.inf else Fraction(1)


@dataclass(frozen=True, slots=True)
class _Term:
    tau: arb
    U: list[arb]
    V: list[arb]
    level: arb


def _positive(curve: Curve, boxes: list[tuple[Fraction, Fraction]]) -> bool:
    terms = [
        _Term(ball(tau), [arb(c) for c in U.coeffs()], [arb(c) for c in V.coeffs()], arb(curve.level.get(tau, 0)))
        for tau, (U, V) in curve.terms.items()
    ]
    stack = list(boxes)
    narrowest = boxes[-1][1] / 2**NARROWEST
    for _ in range(MOST_BOXES):
        tick()
        if not stack:
            return True
        low, high = stack.pop()
        bound, inside = _bound(terms, low, high, divided=curve.divided)
        if bound > 0:
            continue
        if inside <= 0 or high - low < narrowest:
            return False
        middle = (low + high) / 2
        stack += [(low, middle), (middle, high)]
    return False


def _bound(terms: list[_Term], low: Fraction, high: Fraction, *, divided: bool) -> tuple[arb, arb]:
    """Balls around the values on ``[low, high]``, by Taylor's formula, and around the one at the middle."""
    box = ball(low).union(ball(high))
    middle, radius = ball((low + high) / 2), ball((high - low) / 2).upper()
    here = _series(terms, arb_series([middle, 1]), divided=divided)
    if divided and low == 0:
        return _value(terms, box), here[0]
    last = _series(terms, arb_series([box, 1]), divided=divided)[SERIES_TERMS - 1]
    total, power = here[0], arb(1)
    for i in range(1, SERIES_TERMS):
        power *= radius
        coefficient = last if i == SERIES_TERMS - 1 else here[i]
        total += coefficient * power * (arb(0.5, 0.5) if i % 2 == 0 else arb(0, 1))
    return total, here[0]


def _value(terms: list[_Term], omega: arb) -> arb:
    """The critical case near 0: ``V sin(tau omega)/omega = V tau sinc``, and of ``level`` ``(cos - 1)/omega^2``."""
    x, total = omega * omega, arb(0)
    for term in terms:
        angle = omega * term.tau
        total += _ball_at(term.U, x) * angle.cos() + _ball_at(term.V, x) * term.tau * angle.sinc()
        total -= term.level * (term.tau * (angle / 2).sinc()) ** 2 / 2
    return total


def _series(terms: list[_Term], omega: arb_series, *, divided: bool) -> arb_series:
    x, total = omega * omega, 0 * omega
    for term in terms:
        angle = omega * term.tau
        sine = angle.sin()
        total += _at(term.U, x) * angle.cos() + _at(term.V, x) * (sine / omega if divided else omega * sine)
        if term.level != 0:
            half = (angle / 2).sin() / omega
            total -= half * half * (2 * term.level)
    return total


def _ball_at(coefficients: list[arb], x: arb) -> arb:
    total = arb(0)
    for c in reversed(coefficients):
        total = total * x + c
    return total


def _at(coefficients: list[arb], x: arb_series) -> arb_series:
    total = 0 * x
    for c in reversed(coefficients):
        total = total * x + c
    return total

"""Plants with parameters that are constant but unknown in a box: every hypothesis for all of them.

On a box ``p_j = low_j + w_j t_j`` the polynomials ``n`` and ``d`` are multiplied out in ``t``, ``0 <= t_j <= 1``; the
inequality, which is linear in ``n d*`` and ``|d|^2``, then is a polynomial in ``t`` whose coefficients are polynomials
in the frequency.  A polynomial in ``t`` is a mean of its Bernstein coefficients, which follow from its own.  With a
dead time, affine in the parameters, it has two such parts, and holds for every value that this takes on the box.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import comb
from typing import Any, TypeAlias, TypeVar

from flint import fmpq, fmpq_poly

from lure.analysis.certificates.second import theorems
from lure.analysis.certificates.second.axis import Axis, holds_from_zero, holds_on_circle
from lure.analysis.certificates.second.classes import Nonlinearities
from lure.analysis.certificates.second.cover import require_whatever_delay
from lure.analysis.certificates.second.numerics import (
    Laurent,
    X,
    from_descending,
    positive_from_zero,
    positive_on_circle,
    to_fmpq,
    to_fraction,
)
from lure.analysis.certificates.second.question import Question
from lure.analysis.certificates.second.reading import (
    Document,
    NotShown,
    count,
    listed,
    mapping,
    number,
    numbers,
    record,
    require,
    text,
    tick,
)
from lure.analysis.certificates.second.systems import Delayed, Rational, read_system, shifted

MOST_BOXES, MOST_POWER = 100_000, 40
Powers = tuple[int, ...]
Box = tuple[tuple[Fraction, Fraction], ...]
Polynomials = dict[Powers, fmpq_poly]
Value: TypeAlias = Any  # a number or a polynomial
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True, slots=True)
class Plants:
    """``n`` and ``d`` as polynomials in the parameters, whose coefficients are polynomials in ``s`` or ``z``."""

    discrete: bool
    box: Box
    degrees: tuple[int, ...]
    terms: tuple[tuple[Powers, list[Fraction], list[Fraction]], ...]
    delay: tuple[Fraction, ...] = ()

    def waits(self, box: Box) -> tuple[Fraction, Fraction]:
        """The least and the largest dead time, which is affine: at two corners."""
        first, *rest = self.delay
        both = [[c * end for end in pair] for c, pair in zip(rest, box, strict=True)]
        return first + sum(map(min, both)), first + sum(map(max, both))

    def at(self, point: list[Fraction]) -> dict[str, object]:
        """One plant, as in a file."""
        sides: list[list[Fraction]] = [[Fraction(0)] * len(self.terms[0][2]) for _ in range(2)]
        for powers, *both in self.terms:
            weight = Fraction(1)
            for value, power in zip(point, powers, strict=True):
                weight *= value**power
            sides = [[v + weight * c for v, c in zip(s, own, strict=True)] for s, own in zip(sides, both, strict=True)]
        while len(sides[0]) > 1 and sides[0][0] == 0:
            sides[0] = sides[0][1:]
        top, bottom = ([str(v) for v in side] for side in sides)
        if self.delay:
            wait, _ = self.waits(tuple((v, v) for v in point))
            return {"kind": "delay", "terms": [[str(wait), top]], "denominator": bottom}
        time = "discrete" if self.discrete else "continuous"
        return {"kind": "transfer", "time": time, "numerator": top, "denominator": bottom}

    def within(self, box: Box) -> tuple[Polynomials, Polynomials]:
        """``n`` and ``d`` in ``t``, each of which goes from 0 to 1 over the box."""
        sides: tuple[Polynomials, Polynomials] = ({}, {})
        for powers, *both in self.terms:
            tick()
            for found, own in zip(sides, both, strict=True):
                p = from_descending(own)
                for turned in product(*(range(e + 1) for e in powers)):
                    weight = Fraction(1)
                    for (low, high), e, i in zip(box, powers, turned, strict=True):
                        weight *= comb(e, i) * low ** (e - i) * (high - low) ** i
                    found[turned] = found.get(turned, fmpq_poly([])) + to_fmpq(weight) * p
        return sides


def read_plants(system: Mapping[str, object]) -> Plants:
    """The plants of a system with parameters.

    Raises
    ------
    NotShown
        It is none.
    """
    late = system.get("kind") == "delay-family"
    found = record(system, "kind", "time", "parameters", "terms", *(("delay",) if late else ()))
    require(late or found["kind"] == "family", "the kind of system is unknown")
    require(found["time"] in ("continuous", "discrete"), "time is neither continuous nor discrete")
    box = read_parameters(found["parameters"])
    terms = list[tuple[Powers, list[Fraction], list[Fraction]]]()
    for entry in listed(found["terms"]):
        term = record(entry, "powers", "numerator", "denominator")
        powers = tuple(count(e) for e in listed(term["powers"]))
        require(len(powers) == len(box) and max(powers) <= MOST_POWER, "the powers of a term do not fit")
        terms.append((powers, numbers(term["numerator"]), numbers(term["denominator"])))
    require(len({powers for powers, *_ in terms}) == len(terms), "a term is there twice")
    sizes = {len(side) for _, *both in terms for side in both}
    require(len(sizes) == 1 and 0 not in sizes, "there are no terms, or with coefficients of different number")
    degrees = tuple(max(powers[j] for powers, *_ in terms) for j in range(len(box)))
    delay = tuple(numbers(found["delay"])) if late else ()
    plants = Plants(discrete=found["time"] == "discrete", box=box, degrees=degrees, terms=tuple(terms), delay=delay)
    if late:
        require(len(delay) == 1 + len(box) and not plants.discrete, "the dead time does not fit the plants")
        require(plants.waits(box)[0] >= 0 and any(delay), "the dead time is negative, or none")
    return plants


def read_parameters(value: object) -> Box:
    """The bounds of the parameters, each of which has a name; ``value``: as they stand in a file.

    Raises
    ------
    NotShown
        A name or an interval is missing.
    """
    names, box = list[str](), list[tuple[Fraction, Fraction]]()
    for entry in listed(value):
        name, *ends = listed(entry)
        require(len(ends) == 2, "a parameter has no two bounds")
        low, high = map(number, ends)
        require(low < high, "a parameter has no interval")
        names.append(text(name))
        box.append((low, high))
    require(len(names) > 0 and len(set(names)) == len(names), "parameters are missing or named twice")
    return tuple(box)


def require_inside(value: object, box: Box) -> list[Fraction]:
    """The parameters of one plant.

    Parameters
    ----------
    value : object
        As they stand in a file.
    box : tuple of (Fraction, Fraction)
        Their bounds.

    Raises
    ------
    NotShown
        One is not within its bounds.
    """
    point = numbers(value)
    require(len(point) == len(box), "the plant has other parameters")
    require(all(a <= v <= b for v, (a, b) in zip(point, box, strict=True)), "a parameter is outside its bounds")
    return point


def member(document: Document) -> Document:
    """The document of one plant of a box, with which a refutation is about an ordinary loop."""
    plants, found = read_plants(document.system), record(document.proof, "method", "at", "proof")
    require(found["method"] == "member", "one plant of the box is needed")
    point = require_inside(found["at"], plants.box)
    return replace(document, system=plants.at(point), proof=mapping(found["proof"]))


def proved(document: Document, nonlinearities: Nonlinearities) -> str:
    """The sentence that is proved of all plants of a box.

    Raises
    ------
    NotShown
        It is not shown of one of the boxes into which that is cut.
    """
    plants = read_plants(document.system)
    found = record(document.proof, "method", "boxes")
    require(found["method"] == "boxes", "the method does not fit a plant with parameters")
    record(document.multiplier)
    require(not nonlinearities.relu and nonlinearities.upper != "inf", "a class has no upper bound, or is a ReLU")
    require(all(top[0] == 0 for _, top, _ in plants.terms), "with parameters there is no direct term")
    require(not plants.delay or document.theorem in ("circle", "popov"), "the theorem is not for dead times in a box")
    said = {
        _on_box(plants, box, replace(document, multiplier=multiplier), nonlinearities)
        for box, multiplier in leaves(mapping(found["boxes"]), plants.box)
    }
    require(len(said) == 1, "another sentence follows for other parameters")
    return said.pop()


def leaves(tree: Mapping[str, object], box: Box) -> Iterator[tuple[Box, Mapping[str, object]]]:
    """Every box that is cut no further, with its multiplier; together they are the whole.

    ``tree``: the cuts, as they stand in a file.
    """
    waiting, met = [(tree, box)], 0
    while waiting:
        tick()
        part, own = waiting.pop()
        met += 1
        require(met <= MOST_BOXES, "there are too many boxes")
        if set(part) == {"multiplier"}:
            yield own, mapping(part["multiplier"])
            continue
        found = record(part, "parameter", "at", "below", "above")
        j, cut = count(found["parameter"]), number(found["at"])
        require(j < len(own), "a cut is no cut")
        low, high = own[j]
        require(low < cut < high, "a cut is no cut")
        for name, ends in (("above", (cut, high)), ("below", (low, cut))):
            waiting.append((mapping(found[name]), (*own[:j], ends, *own[j + 1 :])))


def _on_box(plants: Plants, box: Box, document: Document, nonlinearities: Nonlinearities) -> str:
    """What follows for all plants of a box by one multiplier."""
    system = read_system(plants.at([(low + high) / 2 for low, high in box]))
    if not isinstance(system, Rational | Delayed):
        raise NotShown("parameters are those of rational plants and of plants with dead time")
    order = system.plant.degree if isinstance(system, Rational) else system.d.degree()
    require(order == len(plants.terms[0][2]) - 1, "the order is less in the middle of a box")
    if document.theorem == "circle":
        record(document.multiplier)
    asked = theorems.posed(document, system, nonlinearities)
    require(not plants.delay or asked.claim.lower == 0, "with dead time and parameters the lower bound must be 0")
    middle = shifted(system, asked.claim.lower)
    theorems.require_case(asked, middle.case)
    n, d = plants.within(box)
    loop = {powers: p + to_fmpq(asked.claim.lower) * n[powers] for powers, p in d.items()}
    twice = tuple(2 * e for e in plants.degrees)
    critical = middle.case == "critical"
    end = fmpq(1) if plants.discrete else fmpq(0)
    if critical:
        require(all(p(end) == 0 for p in loop.values()), "the pole at 0 moves with the parameters")
        slope = middle.d.derivative()(end)
        rest = {powers: to_fraction(p(end) * slope) for powers, p in n.items()}
        require(all(v > 0 for v in bernstein(rest, plants.degrees)), "the residue at the pole 0 is not positive")
    if plants.delay:
        _on_late_line(asked, (n, loop, middle.d), (plants.degrees, twice), plants.waits(box), critical=critical)
    elif plants.discrete:
        _on_circle(asked, (n, loop, middle.d), (plants.degrees, twice), critical=critical)
    else:
        _on_line(asked, (n, loop, middle.d), (plants.degrees, twice), critical=critical)
    return theorems.sentence(asked, middle.case)


Sides = tuple[Polynomials, Polynomials, fmpq_poly]


def _on_line(asked: Question, sides: Sides, degrees: tuple[Powers, Powers], *, critical: bool) -> None:
    """Check the poles and the inequality in continuous time."""
    cross, square = _products(sides, degrees[0], critical=critical)
    order = sides[2].degree()
    ease = to_fmpq(asked.claim.inverse_gain)
    if asked.theorem == "off-axis-circle":
        alpha = to_fmpq(number(record(asked.document.multiplier, "alpha")["alpha"]))
        forms = {
            powers: (own.e + ease * square[powers].e)(X * X) - alpha * X * own.o(X * X) for powers, own in cross.items()
        }
        for p in bernstein(forms, degrees[1]):
            require(holds_from_zero(p, 2 * order, asked.claim.need), "the inequality may fail in a box")
        return
    multiplier = theorems.multiplier_of(asked)
    m, weight = multiplier.terms[Fraction(0)], to_fmpq(multiplier.theta) * multiplier.below
    require(set(multiplier.terms) == {Fraction(0)}, "kernels that are delays are not used with parameters")
    forms = {
        powers: (m * (own + square[powers].times(fmpq_poly([ease])))).e - weight * X * own.o
        for powers, own in cross.items()
    }
    full = order + multiplier.below.degree() + multiplier.growth - critical
    for p in bernstein(forms, degrees[1]):
        require(holds_from_zero(p // X if critical else p, full, asked.claim.need), "the inequality may fail in a box")


def _products(sides: Sides, degrees: Powers, *, critical: bool) -> tuple[dict[Powers, Axis], dict[Powers, Axis]]:
    """``n d*`` and ``|d|^2`` on the line, of plants whose poles are checked."""
    n, d = ({powers: Axis.of(p) for powers, p in side.items()} for side in sides[:2])
    middle = Axis.of(sides[2]).conjugate()
    for p in bernstein({powers: (own * middle).e for powers, own in d.items()}, degrees):
        kept = p // X if critical else p
        full = sides[2].degree() - critical
        require(positive_from_zero(kept) and kept.degree() == full, "a pole may reach the axis in a box")
    back = {powers: own.conjugate() for powers, own in d.items()}
    return _product(n, back, _add_axis), _product(d, back, _add_axis)


def _on_late_line(
    asked: Question,
    sides: Sides,
    degrees: tuple[Powers, Powers],
    waits: tuple[Fraction, Fraction],
    *,
    critical: bool,
) -> None:
    """The same with dead times between two.

    ``Re[(1 + i omega theta) n d* exp(-i omega T)] + |d|^2/w``: of the Bernstein coefficients of ``E + i omega O`` in
    front of the exponential, and of ``|d|^2/w``.
    """
    cross, square = _products(sides, degrees[0], critical=critical)
    theta, ease = theorems.multiplier_of(asked).theta, to_fmpq(asked.claim.inverse_gain)
    require(theta >= 0, "with dead time theta >= 0 is needed")
    turned = {p: Axis(own.e - to_fmpq(theta) * X * own.o, own.o + to_fmpq(theta) * own.e) for p, own in cross.items()}
    parts = [{p: own.e for p, own in turned.items()}, {p: own.o for p, own in turned.items()}]
    plain = {p: ease * own.e for p, own in square.items()}
    for forms in zip(*(bernstein(part, degrees[1]) for part in (plain, *parts)), strict=True):
        require_whatever_delay(forms, waits, sides[2].degree(), critical=critical)


def _on_circle(asked: Question, sides: Sides, degrees: tuple[Powers, Powers], *, critical: bool) -> None:
    """Check the poles and the inequality in discrete time."""
    require(asked.theorem != "order-cone", "forms of several samples are not used with parameters")
    n, d = ({powers: Laurent(p) for powers, p in side.items()} for side in sides[:2])
    middle = Laurent(sides[2]).conjugate()
    for p in bernstein({powers: (own * middle).real_part() for powers, own in d.items()}, degrees[0]):
        require(
            positive_on_circle(p // theorems.ONE_MINUS_C if critical else p), "a pole may reach the circle in a box"
        )
    ahead, back = ({powers: own.conjugate() for powers, own in side.items()} for side in (n, d))
    cross, square, own = (_product(a, b, Laurent.__add__) for a, b in ((n, back), (d, back), (n, ahead)))
    forms = {
        powers: theorems.on_products(asked, Fraction(0), (p, square[powers], own[powers]))
        for powers, p in cross.items()
    }
    for p in bernstein(forms, degrees[1]):
        kept = p // theorems.ONE_MINUS_C if critical else p
        require(holds_on_circle(kept, asked.claim.need), "the inequality may fail in a box")


def _add_axis(a: Axis, b: Axis) -> Axis:
    return a + b


def _product(a: dict[Powers, T], b: dict[Powers, T], add: Callable[[T, T], T]) -> dict[Powers, T]:
    """The product of two polynomials in ``t``."""
    found = dict[Powers, T]()
    for i, p in a.items():
        tick()
        for j, q in b.items():
            powers = tuple(x + y for x, y in zip(i, j, strict=True))
            term: T = p * q  # type: ignore[operator]  # both are of a ring
            found[powers] = add(found[powers], term) if powers in found else term
    return found


def bernstein(p: Mapping[Powers, Value], degrees: Powers) -> Iterator[Value]:
    """The coefficients of a polynomial in ``t`` of these degrees before Bernstein's polynomials.

    ``p``: its own coefficients, numbers, polynomials or matrices, by the powers of ``t``.
    """
    found = dict(p)
    for j, degree in enumerate(degrees):
        lines = dict[Powers, dict[int, Value]]()
        for powers, value in found.items():
            lines.setdefault((*powers[:j], 0, *powers[j + 1 :]), {})[powers[j]] = value
        found = {}
        for start, line in lines.items():
            tick()
            for k in range(degree + 1):
                total = 0 * next(iter(line.values()))
                for i, value in line.items():
                    share = Fraction(comb(k, i), comb(degree, i))
                    total += (share if isinstance(value, Fraction) else to_fmpq(share)) * value
                found[(*start[:j], k, *start[j + 1 :])] = total
    yield from found.values()
